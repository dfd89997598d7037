//! Nearest points against the certified distance of a sphere of radius 0, which knows no planes.

use super::*;
use crate::distance;
use crate::query::ray::tests::{Random, shapes};

/// A bracket of the distance that GJK proves.
fn by_gjk(point: DVec3, posed: PosedShape<'_>) -> [f64; 2] {
    let (sphere, at) = (Shape::sphere(0.0).unwrap(), Pose::from_translation(point).unwrap());
    let sphere = PosedShape { shape: &sphere, pose: &at };
    match distance::distance(sphere, posed).0 {
        DistanceResult::Apart(found) => [found.lower(), found.upper()],
        DistanceResult::Touching => [0.0, 0.0],
        DistanceResult::Interval { within, .. } => [0.0, within.upper()],
        DistanceResult::Undecided(_) => [0.0, f64::INFINITY],
    }
}

#[test]
fn brackets_hold_the_certified_distance_at_every_scale_and_place() {
    let mut random = Random::seeded(20_261_125);
    let mut by_face = 0;
    for scale in [1e-6, 1e-3, 1.0, 1e4] {
        for away in [0.0, 1e6] {
            for (name, shape) in shapes(&mut random, scale) {
                for k in 0..60 {
                    let place = random.vector() * away;
                    let pose = random.pose(place);
                    let posed = PosedShape { shape: &shape, pose: &pose };
                    let far = [0.3, 1.0, 2.0, 30.0][k % 4] * scale;
                    let point = pose.translation() + random.vector() * far;
                    let found = nearest_point(point, posed, f64::INFINITY).unwrap();
                    let context = format!("{name}, scale {scale:e}, away {away:e}, {k}: {found:?}");
                    let [lower, upper] = by_gjk(point, posed);
                    assert!(
                        found.lower <= upper && lower <= found.upper,
                        "{context} [{lower}, {upper}]"
                    );
                    assert!((found.lower..=found.upper).contains(&found.distance), "{context}");
                    let width = found.upper - found.lower;
                    assert!(width <= 1e-9 * (scale + away), "{context}");
                    // The point is of the shape and as far away as is said, to within the rounding of places.
                    let slack = 1e-11 * (scale + away) + found.upper - found.lower;
                    assert!(by_gjk(found.nearest, posed)[0] <= slack, "{context}");
                    let length = (found.nearest - point).length();
                    assert!((length - found.distance).abs() <= slack, "{context}");
                    by_face += usize::from(name == "hull" && found.distance > 0.0);
                    // What is farther than a limit is let go of only where that is so.
                    for limit in [found.lower * 0.5, found.lower, found.upper * 1.001] {
                        let within = nearest_point(point, posed, limit);
                        assert!(within.is_some() || lower.max(found.lower) >= limit, "{context}");
                        assert!(within.is_none_or(|within| within == found), "{context}");
                    }
                }
            }
        }
    }
    assert!(by_face > 100);
}

#[test]
fn a_point_on_a_face_or_vertex_is_within_rounding_of_it() {
    let shape = Shape::cuboid(DVec3::ONE).unwrap();
    let hull = Shape::hull(shape.as_polytope().unwrap().vertices().to_vec()).unwrap();
    for shape in [shape, hull] {
        let posed = PosedShape { shape: &shape, pose: &Pose::IDENTITY };
        for point in [DVec3::X, DVec3::ONE, DVec3::new(1.0, 0.5, -1.0)] {
            let found = nearest_point(point, posed, f64::INFINITY).unwrap();
            assert!(found.lower == 0.0 && found.upper <= 1e-12, "{point} {found:?}");
        }
        let inside = nearest_point(DVec3::splat(0.999), posed, 0.0).unwrap();
        assert_eq!((inside.distance, inside.nearest), (0.0, DVec3::splat(0.999)));
    }
}

#[test]
fn of_a_point_that_is_no_number_nothing_is_claimed() {
    let shape = Shape::cuboid(DVec3::ONE).unwrap();
    let posed = PosedShape { shape: &shape, pose: &Pose::IDENTITY };
    let found = nearest_point(DVec3::NAN, posed, 1.0).unwrap();
    assert_eq!((found.lower, found.upper), (0.0, f64::INFINITY));
}

#[test]
fn a_point_beside_a_cuboid_is_not_in_it_however_small_both_are() {
    for exponent in -300..=30 {
        let size = 10f64.powi(exponent);
        let shape = Shape::cuboid(DVec3::splat(size)).unwrap();
        let posed = PosedShape { shape: &shape, pose: &Pose::IDENTITY };
        for times in [0.0, 0.5, 1.5, 4.0] {
            let found = nearest_point(DVec3::X * (times * size), posed, f64::INFINITY).unwrap();
            let truth = (times - 1.0).max(0.0) * size;
            let holds = found.lower <= truth && truth <= found.upper;
            assert!(holds, "{times} of {size:e}: {found:?}");
        }
    }
}

#[test]
fn a_point_of_a_shape_as_long_as_f64_allows_is_not_beyond_it() {
    let segment = Shape::segment(DVec3::ZERO, DVec3::X * 4e154).unwrap();
    let posed = PosedShape { shape: &segment, pose: &Pose::IDENTITY };
    let found = nearest_point(DVec3::ZERO, posed, 1.0);
    assert!(found.is_some_and(|found| found.lower == 0.0), "{found:?}");
}
