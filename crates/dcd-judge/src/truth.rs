//! The signed depth of two shapes: exact to compare with, and rounded once to be shown.

use crate::Side;
use crate::directions::{Least, least_reach};
use crate::rounding::{leading, scaled};
use crate::world::{World, lowest_bit, whole};
use num_bigint::{BigInt, Sign};
use std::cmp::Ordering;

/// The depth of two shapes that touch, or the negative distance of two that do not, exactly:
/// (reach / √square + offset)·2^unit.
#[derive(Clone, Debug)]
pub struct Truth {
    reach: BigInt,
    square: BigInt,
    /// The sum of the swept radii.
    offset: BigInt,
    unit: i32,
}

/// Bits of a rounded result before it is rounded to an f64's 53: 17 digits and a margin for the
/// unit that a root loses.
const DIGITS: i64 = 72;

impl Truth {
    /// The truth for two posed shapes, their radii included.
    pub fn of(a: Side<'_>, b: Side<'_>) -> Self {
        Self::in_world(&World::of(a, b))
    }

    pub(crate) fn in_world(world: &World) -> Self {
        let Least { reach, square } = least_reach(world);
        Self { reach, square, offset: world.radius.clone(), unit: world.unit }
    }

    /// The truth for the shapes with so much more radius, metres; negative for less.
    #[must_use]
    pub fn rounded_by(&self, radius: f64) -> Self {
        let unit = self.unit.min(lowest_bit(radius));
        let finer = self.unit - unit;
        Self {
            reach: &self.reach << finer,
            square: self.square.clone(),
            offset: (&self.offset << finer) + whole(radius, unit),
            unit,
        }
    }

    /// Whether the shapes share a point.
    pub fn touches(&self) -> bool {
        self.sign() != Ordering::Less
    }

    /// The depth, or the negative distance, metres: the nearest f64.
    pub fn value(&self) -> f64 {
        let sign = self.sign();
        if sign == Ordering::Equal {
            return 0.0;
        }
        // More digits until what radius and reach leave of each other has enough of them.
        let mut finer = (DIGITS - self.bits_of_reach()).max(0);
        loop {
            let sum = self.fixed(finer);
            if sum.bits() as i64 >= DIGITS {
                let (m, e) = leading(&sum);
                return scaled(m, e - finer + i64::from(self.unit));
            }
            finer += DIGITS;
        }
    }

    /// The truth less x, metres: the nearest f64.
    pub fn less(&self, x: f64) -> f64 {
        self.rounded_by(-x).value()
    }

    /// Whether the depth, or the negative distance, is in low..=high, exactly.
    pub fn is_within(&self, low: f64, high: f64) -> bool {
        let from_low = self.rounded_by(-low).sign();
        let from_high = self.rounded_by(-high).sign();
        from_low != Ordering::Less && from_high != Ordering::Greater
    }

    /// The sign of reach / √square + offset.
    fn sign(&self) -> Ordering {
        let signed_square = |x: &BigInt| if x.sign() == Sign::Minus { -(x * x) } else { x * x };
        signed_square(&self.reach).cmp(&-(signed_square(&self.offset) * &self.square))
    }

    /// About how many bits reach / √square has before the point.
    fn bits_of_reach(&self) -> i64 {
        self.reach.bits() as i64 - self.square.bits() as i64 / 2
    }

    /// (reach / √square + offset)·2^finer, less than one off.
    fn fixed(&self, finer: i64) -> BigInt {
        let square = (&self.reach * &self.reach) << (2 * finer);
        let root = (square / &self.square).sqrt();
        let reach = if self.reach.sign() == Sign::Minus { -root } else { root };
        reach + (&self.offset << finer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dcd_geom::glam::DVec3;
    use dcd_geom::{Polytope, Pose};

    fn at(x: f64, y: f64, z: f64) -> Pose {
        Pose::from_translation(DVec3::new(x, y, z)).unwrap()
    }

    fn cube() -> Polytope {
        Polytope::cuboid(DVec3::splat(0.5)).unwrap()
    }

    fn of_cubes(pose: &Pose) -> Truth {
        Truth::of((&cube(), &Pose::IDENTITY), (&cube(), pose))
    }

    #[test]
    fn cubes_have_the_depth_that_one_reads_off() {
        for (x, depth) in [(0.75, 0.25), (0.25, 0.75), (0.0, 1.0), (1.0, 0.0)] {
            let truth = of_cubes(&at(x, 0.0, 0.0));
            assert_eq!(truth.value(), depth);
            assert!(truth.is_within(depth, depth) && truth.touches());
            let beside = [(depth.next_up(), 9.0), (-9.0, depth.next_down())];
            assert!(beside.iter().all(|&(low, high)| !truth.is_within(low, high)));
        }
    }

    #[test]
    fn the_distance_of_two_corners_is_a_root() {
        // Corner to corner along (2, 3, 6), which is 7 long, and along (1, 1, 1).
        let truth = of_cubes(&at(3.0, 4.0, 7.0));
        assert_eq!((truth.value(), truth.rounded_by(7.5).value()), (-7.0, 0.5));
        assert_eq!(truth.rounded_by(7f64.next_up()).value(), 4.0 * f64::EPSILON);
        assert_eq!(of_cubes(&at(2.0, 2.0, 2.0)).value(), -(3f64.sqrt()));
        // √3 = 1.732050807568877193176604… (an f64) + 1.0035084221806902653…e-16.
        let rest = of_cubes(&at(2.0, 2.0, 2.0)).less(-(3f64.sqrt()));
        assert_eq!(rest, -1.003_508_422_180_690_3e-16);
    }

    #[test]
    fn the_plane_of_a_corner_is_a_third_of_a_root_away() {
        let corner = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let corner = Polytope::hull(corner).unwrap();
        let point = Polytope::hull(vec![DVec3::splat(0.25)]).unwrap();
        let truth = Truth::of((&corner, &Pose::IDENTITY), (&point, &Pose::IDENTITY));
        assert_eq!(truth.value(), 0.144_337_567_297_406_44);
    }

    #[test]
    fn points_segments_and_plates_that_touch_have_depth_zero() {
        let hull = |points: &[DVec3]| Polytope::hull(points.to_vec()).unwrap();
        let point = hull(&[DVec3::ZERO]);
        let segment = hull(&[DVec3::NEG_X, DVec3::X]);
        let plate = hull(&[DVec3::NEG_X, DVec3::X, DVec3::Y]);
        let shapes = [&point, &segment, &plate];
        for a in shapes {
            for b in shapes {
                let truth = Truth::of((a, &Pose::IDENTITY), (b, &Pose::IDENTITY));
                assert!(truth.touches() && truth.value() == 0.0, "{a:?} {b:?}");
                let apart = Truth::of((a, &Pose::IDENTITY), (b, &at(0.0, 0.0, 3.0)));
                assert!(!apart.touches() && apart.value() == -3.0, "{a:?} {b:?}");
                let beside = Truth::of((a, &Pose::IDENTITY), (b, &at(5.0, 0.0, 0.0)));
                assert!(!beside.touches() && beside.value() <= -3.0, "{a:?} {b:?}");
            }
        }
    }

    #[test]
    fn spheres_are_measured_by_their_radii() {
        let sphere = |r: f64| Polytope::sphere(r).unwrap();
        let touch = Truth::of((&sphere(2.0), &Pose::IDENTITY), (&sphere(3.0), &at(3.0, 0.0, 4.0)));
        assert!(touch.touches() && touch.value() == 0.0);
        let less = 3f64.next_down();
        let apart = Truth::of((&sphere(2.0), &Pose::IDENTITY), (&sphere(less), &at(3.0, 0.0, 4.0)));
        assert_eq!((apart.touches(), apart.value()), (false, -(3.0 - less)));
    }
}
