//! A scene of outer hulls, and inside each shape another one.

use crate::{Findings, NarrowPhase, Nothing, Placed, Reason, Rung, Verdict, certified};
use dcd_geom::{Aabb, Pair, Scene, Shape};

/// Yes, no, or within the tolerance: for a scene whose shapes contain the true ones, with shapes
/// that are inside them.
///
/// Apart where the scene's shapes are, touching where the inner ones do, and undecided with
/// [`Reason::WithinTolerance`] between: so the true shapes' answer, and none of them wrong.
#[derive(Clone, Debug, Default)]
pub struct Bracketed {
    inner: Vec<Shape>,
}

impl Bracketed {
    /// Shape k of `inner` lies inside shape k of the scene; a shape of the scene beyond the last
    /// counts as its own.
    pub fn new(inner: Vec<Shape>) -> Self {
        Self { inner }
    }

    /// The verdict on two objects of a scene of outer shapes, by index.
    pub fn verdict(&self, scene: &Scene, pair: Pair) -> (Verdict<()>, Rung) {
        let objects = [pair.i, pair.j].map(|object| object as usize);
        let [a, b] = objects.map(|i| Placed { shape: scene.shape(i), pose: &scene.poses()[i] });
        let (outer, rung) = certified::overlap_of(a, b);
        if outer == Verdict::Apart {
            return (outer, rung);
        }
        let inside = |i: usize, own| self.inner.get(scene.shape_of()[i] as usize).unwrap_or(own);
        let a = Placed { shape: inside(objects[0], a.shape), ..a };
        let b = Placed { shape: inside(objects[1], b.shape), ..b };
        match certified::overlap_of(a, b) {
            (Verdict::Touching(()), rung) => (Verdict::Touching(()), rung),
            (_, rung) => (Verdict::Undecided(Reason::WithinTolerance), rung),
        }
    }
}

impl NarrowPhase for Bracketed {
    type Answer = ();
    type Frame = ();
    type Part<'f> = Nothing;
    type Scratch = ();

    fn growth(&self) -> Option<f64> {
        Some(0.0)
    }

    fn lay_out(&self, scene: &Scene, (): &mut ()) -> Nothing {
        Nothing::of(scene.len())
    }

    /// Nothing is held but AABBs, which are the scene's.
    fn keeps(&self, _: &Nothing) -> bool {
        true
    }

    fn prepare(&self, scene: &Scene, first: usize, _: Nothing, aabbs: &mut [Aabb]) {
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
        findings: &mut Findings<'_, ()>,
    ) {
        for &pair in pairs {
            let (verdict, rung) = self.verdict(scene, pair);
            findings.file(pair, rung, verdict);
        }
    }
}
