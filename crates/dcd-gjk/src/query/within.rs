//! All pairs within a margin, by any narrow phase that decides yes or no.

use super::check_margin;
use crate::{ContactSink, NarrowPhase, Overlap, Prepared, Reason, Sides};
use dcd_geom::{Aabb, Pair, Revision, Scene, ShapeError, Splittable};

/// Which pairs are within a margin of each other: a narrow phase's yes or no on the scene's
/// shapes, each with a sphere of half the margin swept round it.
///
/// So the answer is as proved as that narrow phase's: with [`Overlap`] exact, a distance of the
/// margin itself included. Half the margin is added to each shape's own radius with one rounding;
/// for shapes without a radius there is none. A margin of 0 is the narrow phase itself.
///
/// Costs a second copy of the shapes and, a step, of the poses. Where an object that has grown
/// would reach beyond [`Aabb::LIMIT`], no pair of the scene is decided ([`Reason::Range`]).
///
/// ```
/// use dcd_pipeline::prelude::*;
/// let poses = [0.0, 0.9, 2.1].map(|x| Pose::from_translation(DVec3::X * x));
/// let poses = poses.into_iter().collect::<Result<Vec<_>, _>>()?;
/// let scene = Scene::one_each(vec![Shape::sphere(0.5)?; 3], poses)?;
/// let mut pipeline = Pipeline::with(WideTree::default(), Within::margin(0.25)?);
/// let near: Vec<_> = pipeline.step(&scene, Par::Serial).contacts().collect();
/// assert_eq!(near, [(0, 1), (1, 2)]); // the second pair is 0.2 m apart
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct Within<N = Overlap> {
    narrow: N,
    margin: f64,
}

impl Within {
    /// By the default narrow phase: proved.
    ///
    /// # Errors
    /// A margin, in metres, that is negative, not a number, or above [`Aabb::LIMIT`].
    pub fn margin(margin: f64) -> Result<Self, ShapeError> {
        Self::by(Overlap::default(), margin)
    }
}

impl<N> Within<N> {
    /// By that narrow phase.
    ///
    /// # Errors
    /// A margin, in metres, that is negative, not a number, or above [`Aabb::LIMIT`].
    pub fn by(narrow: N, margin: f64) -> Result<Self, ShapeError> {
        check_margin(margin)?;
        Ok(Self { narrow, margin })
    }

    fn half(&self) -> f64 {
        self.margin / 2.0
    }
}

/// The scene with its shapes grown, and what the narrow phase prepares of it.
#[derive(Clone, Debug, Default)]
pub struct WithinFrame<F> {
    grown: Grown,
    prepared: F,
}

/// What stands for the scene.
#[derive(Clone, Debug, Default)]
enum Grown {
    /// The scene itself.
    #[default]
    AsItIs,
    /// A copy with grown shapes.
    Copy { of: Revision, by: f64, scene: Box<Scene> },
    /// An object of the copy would be out of range.
    OutOfRange,
}

/// A range of the objects.
#[derive(Debug)]
pub struct Part<'f, P> {
    /// `None`: the scene as it is, its boxes to be grown afterwards.
    grown: Option<&'f Scene>,
    /// Whether the same stood for the scene before.
    kept: bool,
    prepared: P,
}

impl<P: Splittable> Splittable for Part<'_, P> {
    fn len(&self) -> usize {
        self.prepared.len()
    }

    fn split_at(self, middle: usize) -> (Self, Self) {
        let (first, others) = self.prepared.split_at(middle);
        let part = |prepared| Self { prepared, grown: self.grown, kept: self.kept };
        (part(first), part(others))
    }
}

impl<N: NarrowPhase> NarrowPhase for Within<N> {
    type Answer = N::Answer;
    type Frame = WithinFrame<N::Frame>;
    type Part<'f>
        = Part<'f, N::Part<'f>>
    where
        Self: 'f;
    type Scratch = N::Scratch;

    fn aabb_margin(&self) -> Option<f64> {
        self.narrow.aabb_margin().map(|own| own + self.half())
    }

    fn fewest_pairs(&self, frame: &Self::Frame) -> usize {
        self.narrow.fewest_pairs(&frame.prepared)
    }

    fn constant_answer(&self) -> Option<N::Answer> {
        self.narrow.constant_answer()
    }

    fn layout<'f>(
        &self,
        scene: &Scene,
        sides: Sides,
        frame: &'f mut Self::Frame,
    ) -> Self::Part<'f> {
        let kept = frame.grown.follow(scene, self.half());
        let grown = match &frame.grown {
            Grown::Copy { scene, .. } => Some(&**scene),
            Grown::AsItIs | Grown::OutOfRange => None,
        };
        let prepared = self.narrow.layout(grown.unwrap_or(scene), sides, &mut frame.prepared);
        Part { grown, kept, prepared }
    }

    fn keeps(&self, part: &Self::Part<'_>) -> bool {
        part.kept && self.narrow.keeps(&part.prepared)
    }

    fn prepare(&self, scene: &Scene, first: usize, part: Self::Part<'_>, aabbs: &mut [Aabb]) {
        let Part { grown: copy, prepared, .. } = part;
        self.narrow.prepare(copy.unwrap_or(scene), first, prepared, aabbs);
        if copy.is_none() {
            for aabb in aabbs {
                *aabb = grown(aabb, self.half());
            }
        }
    }

    fn decide(
        &self,
        a: Prepared<'_, Self::Frame>,
        b: Prepared<'_, Self::Frame>,
        pairs: &[Pair],
        scratch: &mut N::Scratch,
        sink: &mut ContactSink<'_, N::Answer>,
    ) {
        match (grown_side(a), grown_side(b)) {
            (Some(a), Some(b)) => self.narrow.decide(a, b, pairs, scratch, sink),
            _ => pairs.iter().for_each(|&pair| sink.report.leave(pair, Reason::Range)),
        }
    }
}

/// What stands for one side; `None` where an object of it would be out of range.
fn grown_side<F>(side: Prepared<'_, WithinFrame<F>>) -> Option<Prepared<'_, F>> {
    let scene = match &side.frame.grown {
        Grown::AsItIs => side.scene,
        Grown::Copy { scene, .. } => scene,
        Grown::OutOfRange => return None,
    };
    Some(Prepared { scene, frame: &side.frame.prepared })
}

impl Grown {
    /// Brings the copy to where the scene is; its shapes are grown once. Whether what stood for a
    /// scene before still does.
    fn follow(&mut self, original: &Scene, half: f64) -> bool {
        if half == 0.0 {
            return matches!(std::mem::replace(self, Self::AsItIs), Self::AsItIs);
        }
        if let Self::Copy { of, by, scene } = self
            && *of == original.layout()
            && *by == half
            && scene.follow(original)
        {
            return true;
        }
        let new = match original.swept(half) {
            Some(scene) => Self::Copy { of: original.layout(), by: half, scene: Box::new(scene) },
            None => Self::OutOfRange,
        };
        let before = std::mem::replace(self, new);
        matches!((before, self), (Self::OutOfRange, Self::OutOfRange))
    }
}

/// A box that holds every point within `by` of this one; the box itself for 0.
pub(crate) fn grown(aabb: &Aabb, by: f64) -> Aabb {
    if by == 0.0 || *aabb == Aabb::EMPTY {
        return *aabb;
    }
    // Half of an odd denormal, and each sum, is rounded once.
    let by = by.next_up();
    Aabb::strictly_outward(aabb.min.as_dvec3() - by, aabb.max.as_dvec3() + by)
}

#[cfg(test)]
mod tests {
    use super::*;
    use dcd_geom::glam::Vec3;

    #[test]
    fn a_margin_that_is_no_length_is_refused_with_its_value() {
        for bad in [-1e-300, f64::INFINITY, 1e38] {
            let refused = Within::margin(bad).unwrap_err();
            assert_eq!(refused, ShapeError::BadLength { what: "margin", value: bad });
        }
        assert!(Within::margin(f64::NAN).is_err());
    }

    #[test]
    fn a_grown_box_grows_by_the_least_margin_too_and_by_none_not_at_all() {
        let unit = Aabb { min: Vec3::NEG_ONE, max: Vec3::ONE };
        assert_eq!(grown(&unit, 0.0), unit);
        let least = grown(&unit, f64::from_bits(1));
        assert!(least.min.x < -1.0 && least.max.z > 1.0 && least.max.z < 1.0 + 1e-6);
    }
}
