//! A scene of outer hulls, and inside each shape another one.

use crate::{
    ContactSink, Empty, Method, NarrowPhase, PosedShape, Prepared, Reason, Sides, Verdict,
    certified,
};
use dcd_geom::{Aabb, Pair, Scene, Shape};

/// Yes, no, or within the tolerance: for a scene whose shapes contain the true ones, with shapes
/// that are inside them.
///
/// Apart where the scene's shapes are, touching where the inner ones do, and undecided with
/// [`Reason::WithinTolerance`] between: so the true shapes' answer, and none of them wrong.
///
/// ```
/// use dcd_geom::glam::DVec3;
/// use dcd_geom::{Pose, Scene, Shape};
/// use dcd_gjk::simplify::InnerOuter;
/// use dcd_gjk::{Reason, Verdict};
/// let poses = vec![Pose::IDENTITY, Pose::from_translation(DVec3::X * 1.9)?];
/// let outer = Scene::one_each(vec![Shape::sphere(1.0)?; 2], poses)?;
/// let between = InnerOuter::new(vec![Shape::sphere(0.9)?; 2]);
/// let (verdict, _) = between.verdict((&outer, 0), (&outer, 1));
/// assert_eq!(verdict, Verdict::Undecided(Reason::WithinTolerance));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
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

    /// The verdict on two objects of scenes of outer shapes that share a list of shapes, each by its scene and
    /// index.
    pub fn verdict(&self, a: (&Scene, u32), b: (&Scene, u32)) -> (Verdict<()>, Method) {
        let outer = |(scene, i)| PosedShape::of(scene, i);
        let (verdict, method) = certified::overlap_of(outer(a), outer(b));
        if verdict == Verdict::Apart {
            return (verdict, method);
        }
        match certified::overlap_of(self.inner_of(a), self.inner_of(b)) {
            (Verdict::Touching(()), method) => (Verdict::Touching(()), method),
            (_, method) => (Verdict::Undecided(Reason::WithinTolerance), method),
        }
    }

    /// The shape inside an object's, in its place.
    fn inner_of<'a>(&'a self, (scene, object): (&'a Scene, u32)) -> PosedShape<'a> {
        let outer = PosedShape::of(scene, object);
        let inner = self.inner.get(scene.shape_of()[object as usize] as usize);
        PosedShape { shape: inner.unwrap_or(outer.shape), ..outer }
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

    fn layout(&self, scene: &Scene, _: Sides, (): &mut ()) -> Empty {
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
        a: Prepared<'_, ()>,
        b: Prepared<'_, ()>,
        pairs: &[Pair],
        (): &mut (),
        sink: &mut ContactSink<'_, ()>,
    ) {
        for &pair in pairs {
            let (verdict, method) = self.verdict((a.scene, pair.i), (b.scene, pair.j));
            sink.file(pair, method, verdict);
        }
    }
}
