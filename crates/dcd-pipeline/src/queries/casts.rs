//! A moving shape against a scene at rest.

use super::{Queries, QueryError, QueryFilter, check_finite, check_length, order};
use dcd_exec::Exec;
use dcd_gjk::PosedShape;
use dcd_gjk::motion::{Impact, MovingShape, RigidMotion, time_of_impact};
use dcd_simd::{BoxTest, RaySlabs};

/// What a moving shape meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObjectImpact {
    /// The object's index.
    pub object: u32,
    /// When and where: `a` is the moving shape. Never [`Impact::Free`].
    pub impact: Impact,
}

/// By when something may have happened: the time of a hit, the end of what is known to be free.
pub(super) fn time_of(impact: &Impact) -> f64 {
    match *impact {
        Impact::Free => f64::INFINITY,
        Impact::Hit { t, .. } => t,
        Impact::Undecided { free_until } => free_until,
    }
}

pub(super) fn check_times(until: f64, tolerance: f64) -> Result<(), QueryError> {
    check_length("time", until)?;
    check_length("tolerance", tolerance)
}

pub(super) fn check_motion(index: usize, motion: &RigidMotion) -> Result<(), QueryError> {
    check_finite("velocity", index, motion.linear)?;
    check_finite("velocity", index, motion.angular)?;
    check_finite("centre", index, motion.centre)
}

impl Queries<'_> {
    /// What a moving shape meets first from t = 0 to `until`, all objects at rest. No object is met before the impact's
    /// `free_until`, and `None` proves that none is met at all. What passes within `tolerance` metres and touches nothing
    /// may count as met; of objects that are met at one time, as f64 knows it, any is the first. A shape cast along a
    /// translation is a motion whose `angular` is 0.
    ///
    /// # Errors
    /// A time or tolerance that is negative or not finite, a velocity or centre that is out of range.
    pub fn cast(
        &self,
        moving: MovingShape<'_>,
        until: f64,
        tolerance: f64,
        filter: &QueryFilter<'_>,
    ) -> Result<Option<ObjectImpact>, QueryError> {
        check_times(until, tolerance)?;
        check_motion(0, moving.motion)?;
        let motion = moving.motion;
        let longest = motion.linear.abs().max_element();
        let first = match moving.carried_box(until) {
            // Where it is met soonest first, if it goes anywhere.
            Some(corners) if (1e-100..1e100).contains(&longest) => {
                let slabs = RaySlabs::swept(corners, motion.linear);
                self.first_impact(moving, [until, tolerance], filter, &slabs, &|t| slabs.key_of(t))
            }
            _ => {
                let aabb = moving.swept_aabb(until);
                self.first_impact(moving, [until, tolerance], filter, &aabb, &|_| 0.0)
            }
        };
        Ok(first)
    }

    fn first_impact(
        &self,
        moving: MovingShape<'_>,
        [until, tolerance]: [f64; 2],
        filter: &QueryFilter<'_>,
        test: &impl BoxTest,
        key_of: &dyn Fn(f64) -> f32,
    ) -> Option<ObjectImpact> {
        let mut first: Option<ObjectImpact> = None;
        let mut end = until;
        self.visit(test, key_of(end), &mut |object, _| {
            if filter.sees(self.scene, object) {
                let PosedShape { shape, pose } = PosedShape::of(self.scene, object);
                let still = RigidMotion::at_rest(*pose);
                let target = MovingShape { shape, motion: &still };
                // A motion that leaves the range is known to be free nowhere.
                let impact = time_of_impact(moving, target, end, tolerance)
                    .unwrap_or(Impact::Undecided { free_until: 0.0 });
                if impact != Impact::Free {
                    let t = time_of(&impact);
                    let is_first = first.is_none_or(|known| {
                        t.total_cmp(&time_of(&known.impact)).then(object.cmp(&known.object)).is_lt()
                    });
                    if is_first {
                        first = Some(ObjectImpact { object, impact });
                    }
                    if let Impact::Hit { t, .. } = impact {
                        end = end.min(t);
                    }
                }
            }
            key_of(end)
        });
        first
    }

    /// Replaces `impacts` by the first of each moving shape, in their order.
    ///
    /// # Errors
    /// Those of [`Queries::cast`], a velocity with the shape's index; nothing is changed then.
    pub fn casts<'e>(
        &self,
        moving: &[MovingShape<'_>],
        until: f64,
        tolerance: f64,
        filter: &QueryFilter<'_>,
        exec: impl Into<Exec<'e>>,
        impacts: &mut Vec<Option<ObjectImpact>>,
    ) -> Result<(), QueryError> {
        check_times(until, tolerance)?;
        for (k, moving) in moving.iter().enumerate() {
            check_motion(k, moving.motion)?;
        }
        let order = (moving.len(), order::of_motions(moving, self.aabbs));
        order::answer_each((exec.into(), 1), order, impacts, |k| {
            // Checked above.
            self.cast(moving[k], until, tolerance, filter).unwrap_or_default()
        });
        Ok(())
    }
}
