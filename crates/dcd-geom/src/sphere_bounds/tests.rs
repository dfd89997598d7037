//! Bounds beside the shapes that they are of, and posed in lanes beside one by one.

use super::*;
use crate::Sphere16;
use dcd_simd::{Kernel, Lanes, Path, WIDTH, dispatch_on};
use glam::DQuat;
use std::sync::Arc;

fn shapes() -> Vec<Shape> {
    let far = DVec3::new(1e4, -3e3, 20.0);
    let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    let hull = Shape::hull(corners.map(|v| v + far).to_vec()).unwrap();
    let place = Pose::new(DQuat::from_rotation_y(0.3), DVec3::new(0.0, 9.0, 1.0)).unwrap();
    vec![
        hull.clone(),
        hull.clone().rounded(0.25).unwrap(),
        Shape::sphere(1e-30).unwrap(),
        Shape::cuboid(DVec3::new(3.0, 0.1, 1e-9)).unwrap(),
        Shape::cylinder(1.0, 0.2).unwrap(),
        Shape::cone(0.4, 2.0).unwrap(),
        Shape::ellipsoid(DVec3::new(1.0, 0.2, 3.0)).unwrap(),
        Shape::mesh(corners.to_vec(), vec![[0, 1, 2], [1, 2, 3]]).unwrap(),
        Shape::custom(Arc::new(polytope())).unwrap(),
        Shape::compound(vec![(hull, place), (Shape::cone(1.0, 1.0).unwrap(), place)]).unwrap(),
    ]
}

fn polytope() -> crate::Polytope {
    crate::Polytope::hull(vec![DVec3::X, DVec3::Y * 3.0, DVec3::Z]).unwrap()
}

#[test]
fn it_holds_the_box_of_every_shape_at_every_pose() {
    let turns = [0.0, 0.1, 1.0, 2.0, 3.0]
        .map(|angle| DQuat::from_rotation_x(angle) * DQuat::from_rotation_z(0.7 * angle));
    let places = [DVec3::ZERO, DVec3::new(-1e4, 3e3, -20.0), DVec3::splat(1e-20), DVec3::X * 1e30];
    for shape in shapes() {
        let bound = SphereBounds::of(&shape).unwrap();
        for (turn, place) in turns.iter().flat_map(|q| places.map(|t| (*q, t))) {
            let pose = Pose::new(turn, place).unwrap();
            let tight = shape.aabb(&pose);
            for loose in [bound.aabb(&pose), in_lanes(&bound, &pose).aabb()] {
                assert!(loose.contains(&tight), "{shape:?} at {pose:?}: {loose:?}, {tight:?}");
            }
            let swept = shape.swept(0.5).unwrap().aabb(&pose);
            assert!(bound.swept(0.5).aabb(&pose).contains(&swept), "{shape:?} at {pose:?}");
        }
    }
}

/// As the last of sixteen different poses, of another number on every path.
fn in_lanes(bound: &SphereBounds, pose: &Pose) -> BoundingSphere {
    let other = SphereBounds::of(&Shape::sphere(0.3).unwrap());
    let sphere_at = |path, count: usize| {
        let bounds: Vec<_> = std::iter::repeat_n(other, count - 1).chain([Some(*bound)]).collect();
        let poses: Vec<Pose> =
            (0..5).flat_map(|_| places()).take(count - 1).chain([*pose]).collect();
        let mut row = Sphere16::default();
        let start = poses.len().saturating_sub(WIDTH);
        let (bounds, poses) = (&PackedSphereBounds::new(bounds), &poses[start..]);
        dispatch_on(path, PlaceSpheres { bounds, start, poses, row: &mut row });
        row.get(poses.len() - 1)
    };
    let sphere = sphere_at(Path::Portable, 1);
    for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
        for count in [1, 2, 5, 16, 17, 40] {
            assert_eq!(sphere_at(path, count), sphere, "{path:?} {count}");
        }
    }
    sphere
}

struct PlaceSpheres<'a> {
    bounds: &'a PackedSphereBounds,
    start: usize,
    poses: &'a [Pose],
    row: &'a mut Sphere16,
}

impl Kernel for PlaceSpheres<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        self.bounds.spheres(l, self.start, self.poses, self.row);
    }
}

#[test]
fn the_largest_sphere_is_as_large_as_any_within_that_far() {
    for bound in shapes().iter().filter_map(SphereBounds::of) {
        for place in [DVec3::ZERO, DVec3::new(-1e4, 3e3, -20.0), DVec3::X * 1e30] {
            let turn = DQuat::from_rotation_x(0.7);
            let pose = Pose::new(turn, place).unwrap();
            let within = place.abs().max_element();
            let lanes = in_lanes(&bound, &pose);
            for sphere in [bound.sphere(&pose), lanes] {
                assert!(sphere.radius <= bound.largest_sphere(within), "{bound:?} at {place}");
            }
        }
    }
}

fn places() -> impl Iterator<Item = Pose> {
    let turn = |k: u32| DQuat::from_rotation_x(f64::from(k)) * DQuat::from_rotation_z(0.7);
    let place = |k: u32| DVec3::new(f64::from(k), -0.3, 1e3 * f64::from(k % 3));
    (0..9).map(move |k| Pose::new(turn(k), place(k)).unwrap())
}

#[test]
fn an_inner_sphere_reaches_no_farther_than_its_shape_in_any_direction() {
    let directions = (0..500).map(|k| {
        let t = f64::from(k);
        DVec3::new(t.sin(), (t * 0.73).cos(), (t * 0.37).sin()).normalize()
    });
    let mut known = 0;
    for (shape, pose) in shapes().iter().flat_map(|shape| places().map(move |p| (shape, p))) {
        let bound = SphereBounds::of(shape).unwrap();
        let (loose, best) = (bound.sphere(&pose), bound.inner_sphere(&pose));
        let concentric = bound.concentric(&loose);
        assert!(concentric.radius <= best.radius && concentric.centre == loose.centre);
        known += usize::from(concentric.radius > 0.0);
        // A box is the reach along six directions, and those of a turned shape along others.
        for d in directions.clone() {
            let turned = Pose::new(DQuat::from_rotation_arc(d, DVec3::X), DVec3::ZERO).unwrap();
            let whole = Pose::from_matrix(
                *turned.rotation() * *pose.rotation(),
                *turned.rotation() * pose.translation(),
            );
            let reach = f64::from(shape.aabb(&whole.unwrap()).max.x);
            for sphere in [best, concentric] {
                let far = d.dot(sphere.centre.as_dvec3()) + f64::from(sphere.radius);
                assert!(far <= reach, "{sphere:?} of {shape:?} at {pose:?} along {d}");
            }
        }
    }
    assert!(known > 10, "{known}");
}

#[test]
fn spheres_that_just_miss_are_short_of_meeting_and_those_that_overlap_are_not() {
    let at = |x: f32, radius| InscribedSphere { centre: Vec3::X * x, radius };
    for size in [1e-15, 1e-6, 1.0, 1e6, 1e15] {
        let sphere = at(3.0 * size, size);
        assert!(sphere.short_of(&at(0.0, 1.999 * size)) > 0.0);
        assert!(sphere.short_of(&at(0.0, 2.001 * size)) <= 0.0);
    }
    // No sphere of negative radius meets any but one that holds its centre by more.
    assert!(at(0.0, -1.0).short_of(&at(0.0, -1.0)) > 0.0);
    assert!(at(0.0, -1.0).short_of(&at(0.0, 0.5)) > 0.0);
    assert!(at(0.0, -1.0).short_of(&at(0.5, 2.0)) <= 0.0);
    for other in [at(0.0, 1e30), at(f32::NAN, 1.0), at(0.0, f32::NAN), InscribedSphere::NOTHING] {
        let short_of = InscribedSphere::NOTHING.short_of(&other);
        assert!(short_of > 0.0 || short_of.is_nan(), "{other:?}");
    }
}

/// The spheres of two rows that meet.
struct Meet<'a>([&'a Sphere16; 2]);

impl Kernel for Meet<'_> {
    type Output = u32;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> u32 {
        self.0[0].meeting(l, self.0[1])
    }
}

#[test]
fn rows_of_spheres_are_compared_number_by_number() {
    // From so small that squares vanish to so large that they overflow.
    let size = |k: usize| 10f32.powi(4 * k as i32 - 24);
    let sphere = |x: f32, radius: f32| BoundingSphere { centre: Vec3::Y * x, radius };
    let (mut a, mut b) = (Sphere16::default(), Sphere16::default());
    for k in 0..WIDTH {
        // The even ones overlap, the odd ones miss.
        let radius = size(k) * if k % 2 == 0 { 0.01 } else { -0.01 };
        a.set(k, &sphere(-size(k), 2.0 * size(k)));
        b.set(k, &sphere(size(k), radius));
        assert_eq!(b.get(k), sphere(size(k), radius));
    }
    b.set(7, &BoundingSphere::EVERYTHING);
    for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
        let meeting = dispatch_on(path, Meet([&a, &b]));
        for k in 0..WIDTH {
            let meets = meeting >> k & 1 == 1;
            let may_miss = k % 2 == 1 && k != 7;
            assert!(meets || may_miss, "{k}, {path:?}");
            let is_exact = (1e-18..1e18).contains(&size(k));
            assert!(!(meets && may_miss && is_exact), "{k}, {path:?}");
        }
    }
}

#[test]
fn of_what_is_known_by_its_surface_or_its_map_alone_no_inner_sphere_is_known() {
    for shape in shapes() {
        let bound = SphereBounds::of(&shape).unwrap();
        let sphere = bound.inner_sphere(&Pose::IDENTITY);
        let is_solid = !matches!(shape, Shape::Mesh(_) | Shape::Custom(_));
        assert_eq!(sphere.radius > f32::NEG_INFINITY, is_solid, "{shape:?}");
    }
    let far = Pose::from_translation(DVec3::X * 1e200).unwrap();
    let bound = SphereBounds::of(&Shape::sphere(1.0).unwrap()).unwrap();
    assert_eq!(bound.inner_sphere(&far).radius, f32::NEG_INFINITY);
}

#[test]
fn it_is_no_larger_than_a_sphere_needs() {
    let bound = SphereBounds::of(&Shape::sphere(2.0).unwrap()).unwrap();
    let aabb = bound.aabb(&Pose::from_translation(DVec3::X * 3.0).unwrap());
    assert!(aabb.max.x < 5.0001 && aabb.min.x > 0.9999);
}

#[test]
fn what_has_no_end_has_no_bound_and_what_is_out_of_range_is_everywhere() {
    assert_eq!(SphereBounds::of(&Shape::half_space(DVec3::Z, 0.0).unwrap()), None);
    let bound = SphereBounds::of(&Shape::sphere(1.0).unwrap()).unwrap();
    let far = Pose::from_translation(DVec3::X * 1e200).unwrap();
    assert_eq!(bound.aabb(&far), Aabb::EVERYTHING);
    for x in [1e200, Aabb::LIMIT, 0.9999 * Aabb::LIMIT] {
        let far = Pose::from_translation(DVec3::NEG_X * x).unwrap();
        assert_eq!(in_lanes(&bound, &far), BoundingSphere::EVERYTHING);
    }
    let far = Pose::from_translation(DVec3::X * 0.99 * Aabb::LIMIT).unwrap();
    assert!(in_lanes(&bound, &far).radius < f32::INFINITY);
}
