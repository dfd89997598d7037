//! A scene of outer hulls, and inside each shape another one.

use crate::{ContactSink, Empty, Method, NarrowPhase, PosedShape, Reason, Verdict, certified};
use dcd_geom::{Aabb, Pair, Scene, Shape};

/// Yes, no, or within the tolerance: for a scene whose shapes contain the true ones, with shapes
/// that are inside them.
///
/// Apart where the scene's shapes are, touching where the inner ones do, and undecided with
/// [`Reason::WithinTolerance`] between: so the true shapes' answer, and none of them wrong.
#[derive(Clone, Debug, Default)]
pub struct InnerOuter {
    inner: Vec<Shape>,
}

impl InnerOuter {
    /// Shape k of `inner` lies inside shape k of the scene; a shape of the scene beyond the last
    /// counts as its own.
    pub fn new(inner: Vec<Shape>) -> Self {
        Self { inner }
    }

    /// The verdict on two objects of a scene of outer shapes, by index.
    pub fn verdict(&self, scene: &Scene, pair: Pair) -> (Verdict<()>, Method) {
        let objects = [pair.i, pair.j].map(|object| object as usize);
        let [a, b] = objects.map(|i| PosedShape { shape: scene.shape(i), pose: &scene.poses()[i] });
        let (outer, method) = certified::overlap_of(a, b);
        if outer == Verdict::Apart {
            return (outer, method);
        }
        let inside = |i: usize, own| self.inner.get(scene.shape_of()[i] as usize).unwrap_or(own);
        let a = PosedShape { shape: inside(objects[0], a.shape), ..a };
        let b = PosedShape { shape: inside(objects[1], b.shape), ..b };
        match certified::overlap_of(a, b) {
            (Verdict::Touching(()), method) => (Verdict::Touching(()), method),
            (_, method) => (Verdict::Undecided(Reason::WithinTolerance), method),
        }
    }
}

impl NarrowPhase for InnerOuter {
    type Answer = ();
    type Frame = ();
    type Part<'f> = Empty;
    type Scratch = ();

    fn aabb_margin(&self) -> Option<f64> {
        Some(0.0)
    }

    fn layout(&self, scene: &Scene, (): &mut ()) -> Empty {
        Empty::of(scene.len())
    }

    /// Nothing is held but AABBs, which are the scene's.
    fn keeps(&self, _: &Empty) -> bool {
        true
    }

    fn prepare(&self, scene: &Scene, first: usize, _: Empty, aabbs: &mut [Aabb]) {
        for (i, aabb) in (first..).zip(aabbs) {
            *aabb = scene.aabb(i);
        }
    }

    fn decide(
        &self,
        scene: &Scene,
        (): &(),
        pairs: &[Pair],
        (): &mut (),
        sink: &mut ContactSink<'_, ()>,
    ) {
        for &pair in pairs {
            let (verdict, method) = self.verdict(scene, pair);
            sink.file(pair, method, verdict);
        }
    }
}
