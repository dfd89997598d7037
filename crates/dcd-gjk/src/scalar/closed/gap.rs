//! How far apart two shapes are as one evaluation in f64 has it, and what that proves.

use crate::epa::Depth;
use crate::{Distance, DistanceResult, Reason, Verdict};
use dcd_geom::glam::DVec3;

/// The signed distance of two shapes, negative where they overlap, and what it may be off by. World frame, metres.
pub(crate) struct Gap {
    value: f64,
    error: f64,
    /// From a to b, of unit length.
    normal: DVec3,
    /// Nearest to the other shape, or deepest in it.
    point_a: DVec3,
    point_b: DVec3,
}

impl Gap {
    /// Of two shapes, with the normal from the first to the second and a point of each; `swapped`: the first is b.
    #[inline(always)]
    pub(super) fn new(
        (value, error): (f64, f64),
        normal: DVec3,
        [first, second]: [DVec3; 2],
        swapped: bool,
    ) -> Self {
        if swapped {
            Self { value, error, normal: -normal, point_a: second, point_b: first }
        } else {
            Self { value, error, normal, point_a: first, point_b: second }
        }
    }

    /// Whether they are proved to be farther apart than that, metres.
    #[inline]
    pub(crate) fn is_beyond(&self, margin: f64) -> bool {
        (self.value - self.error).next_down() > margin
    }

    /// How deep they overlap; `None` where that is not proved.
    #[inline]
    pub(crate) fn depth(self) -> Option<Depth> {
        let Self { value, error: error_bound, normal, point_a, point_b } = self;
        let is_proved = value < -error_bound;
        is_proved.then(|| Depth { depth: -value, normal, point_a, point_b, error_bound })
    }

    /// Whether they touch, and how deep.
    #[inline]
    pub(crate) fn verdict(self) -> Verdict<Depth> {
        if self.value > self.error {
            return Verdict::Apart;
        }
        self.depth().map_or(Verdict::Undecided(Reason::WithinRounding), Verdict::Touching)
    }

    /// How far apart they are, or that they touch; `None` where neither is proved.
    #[inline]
    pub(crate) fn distance(self) -> Option<DistanceResult> {
        let Self { value: distance, error: error_bound, normal, point_a, point_b } = self;
        if distance > error_bound {
            let found = Distance { distance, point_a, point_b, normal, error_bound };
            return Some(DistanceResult::Apart(found));
        }
        (distance < -error_bound).then_some(DistanceResult::Touching)
    }
}
