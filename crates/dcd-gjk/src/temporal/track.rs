//! How far the points of an object have travelled.

use super::facts::Way;
use crate::simd::cores::Core;
use dcd_geom::{Pose, Scene};

/// An object's way: a sum, step by step, of how far its points have moved at most.
#[derive(Clone, Copy, Debug)]
pub(super) struct Track {
    /// Where it was when it was prepared last.
    pose: Pose,
    /// Which object it is: the slot's generation and the shape.
    object: Option<(u32, u32)>,
    /// Metres.
    way: f64,
    /// What a step counts as at most, metres: see [`FAR`].
    limit: f64,
    /// How far it moved last, metres.
    step: f64,
}

/// A step longer than this counts as this, and no fact is kept with more clearance. Unit: the object's
/// outer radius. So a jump, or another object in the slot, ends every fact, and does not make the
/// way so long that f32 resolves no small clearance in it. Larger: ways wear out sooner. Smaller: objects
/// far from all others are decided again more often.
const FAR: f64 = 8.0;

/// After this many of the longest steps everything is forgotten and ways start from 0: by then f32
/// resolves clearances from about 1/2000 of the object's radius on. Larger: finer ones are lost. Smaller:
/// more steps in which everything is found anew.
const WORN: f64 = 1024.0;

/// How far R' − R may stretch a vector, beyond its Frobenius norm over √2, by what the two matrices
/// depart from rotations. Unit: the sum of their deviations. 1 + √(3/2) = 2.23.
const DEPARTURE: f64 = 2.25;

/// What the roundings of a displacement may take from it, f64. No unit. Some fifty, and clearance.
const ROUNDED: f64 = 1.0 + 256.0 * f64::EPSILON;

/// How far the centre's difference may be off. Unit: 2⁻⁵³ of |t|₁ + |t'|₁ and both reaches; as
/// `CENTRE` (simd/bounds.rs), in each of three coordinates.
const CENTRES: f64 = 16.0 * f64::EPSILON;

impl Default for Track {
    fn default() -> Self {
        Self { pose: Pose::IDENTITY, object: None, way: 0.0, limit: 0.0, step: 0.0 }
    }
}

impl Track {
    /// Adds what the object of that slot has moved since its last step. Returns whether its way has
    /// become too long for f32.
    pub(super) fn follow(&mut self, scene: &Scene, cores: &[Core], slot: usize) -> bool {
        let shape = scene.shape_of()[slot];
        let object = Some((scene.generations()[slot], shape));
        let pose = &scene.poses()[slot];
        let moved = self.pose != *pose;
        if self.object != object {
            let core = &cores[shape as usize];
            let limit = FAR * (core.outer + core.radius);
            // No clearance of the object before was above its limit.
            self.way += self.limit.max(limit);
            // How fast it moves is not known yet.
            (self.object, self.limit, self.step) = (object, limit, 0.0);
        } else if moved {
            let core = &cores[shape as usize];
            let step = displacement(&self.pose, pose, core);
            // Written so that NaN and overflow count as the longest step.
            self.step = if step < self.limit { step } else { self.limit };
            self.way += self.step;
        } else {
            self.step = 0.0;
        }
        // What stands still is not written.
        if moved {
            self.pose = *pose;
        }
        self.way > WORN * self.limit
    }

    pub(super) fn start_again(&mut self) {
        self.way = 0.0;
    }

    pub(super) fn way(&self) -> Way {
        Way { travelled: self.way, limit: self.limit }
    }

    /// Whether it moved farther than that in its last step. Unit: the object's outer radius.
    pub(super) fn exceeds(&self, radii: f64) -> bool {
        self.step > radii / FAR * self.limit
    }
}

/// How far a point of the object moves at most from one pose to the other, metres, rounded up:
/// its centre's way, and the change of the rotation times the outer radius.
fn displacement(from: &Pose, to: &Pose, core: &Core) -> f64 {
    let change = *to.rotation() - *from.rotation();
    let [x, y, z] = [change.x_axis, change.y_axis, change.z_axis];
    let frobenius = (x.length_squared() + y.length_squared() + z.length_squared()).sqrt();
    let departure = from.deviation() + to.deviation();
    // Two singular values of the difference of two rotations are equal, the third is 0.
    let turn = frobenius * std::f64::consts::FRAC_1_SQRT_2 + DEPARTURE * departure;
    let shift = change * core.centre + (to.translation() - from.translation());
    let extent = |pose: &Pose| pose.translation().abs().element_sum() + core.reach;
    let rounding = CENTRES * (extent(from) + extent(to));
    (shift.length() + turn * core.outer + rounding) * ROUNDED
}
