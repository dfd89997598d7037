//! Ellipsoids: their nearest point by the secular equation, planes with whole numbers, balls beside spheres, and
//! every kind beside polytopes inside and round them.

mod judge;

use dcd_geom::glam::DVec3;
use dcd_geom::{Polytope, Pose, Shape};
use dcd_gjk::query::ray::{Ray, first_hit};
use dcd_gjk::{
    Depths, DistanceResult, Manifolds, PairSolver, PosedShape, Verdict, certified, distance,
};
use judge::cases::Draw;

/// Beyond this much of the pair's size f64 must decide.
const DECIDED: f64 = 1e-9;

/// From the seed that `DCD_SEED` names, else from this one.
fn draw_from(fixed: u64) -> Draw {
    Draw(std::env::var("DCD_SEED").map_or(fixed, |seed| seed.parse().expect("a seed")))
}

fn verdict(a: PosedShape<'_>, b: PosedShape<'_>) -> Verdict<()> {
    let answer = certified::overlap_of(a, b).0;
    assert_eq!(answer, certified::overlap_of(b, a).0);
    answer
}

fn half_axes(draw: &mut Draw, size: f64) -> DVec3 {
    DVec3::from_array([(); 3].map(|()| (0.05 + 0.6 * draw.unit().abs()) * size))
}

/// The signed distance of a point with no coordinate 0 from the surface: the nearest surface point is aᵢ²pᵢ/(t + aᵢ²)
/// for the one t above −min aᵢ² at which it is on the surface, found by bisection.
fn signed_distance(half: DVec3, p: DVec3) -> f64 {
    let squares = half * half;
    let nearest = |t: f64| squares * p / (squares + t);
    let is_outside = |t: f64| (nearest(t) / half).length_squared() > 1.0;
    let (mut low, mut high) = (-squares.min_element(), (half * p).length() + 1.0);
    while is_outside(high) {
        high *= 2.0;
    }
    for _ in 0..200 {
        let middle = low + 0.5 * (high - low);
        if is_outside(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    let sign = if (p / half).length_squared() > 1.0 { 1.0 } else { -1.0 };
    sign * (nearest(high) - p).length()
}

#[test]
fn spheres_are_as_far_or_as_deep_as_the_nearest_point_says() {
    let mut draw = draw_from(31);
    let mut seen = [0; 2];
    for k in 0..3000 {
        let size = [1e-3, 1.0, 1e3][k % 3];
        let half = half_axes(&mut draw, size);
        let pose = Pose::new(draw.rotation(), draw.vector() * size).unwrap();
        let at = draw.vector() * (0.5 * size);
        let radius = 0.3 * draw.unit().abs() * size;
        let swept = if k % 4 == 0 { 0.1 * size } else { 0.0 };
        let ellipsoid = Shape::ellipsoid(half).and_then(|shape| shape.rounded(swept)).unwrap();
        let sphere = Shape::sphere(radius).unwrap();
        let there = Pose::from_translation(pose.apply(at)).unwrap();
        let a = PosedShape { shape: &ellipsoid, pose: &pose };
        let b = PosedShape { shape: &sphere, pose: &there };
        let expected = signed_distance(half, at) - radius - swept;
        // The centre's place, and the judge's own nearest point.
        let rounding = 1e-12 * size;
        match distance::distance(a, b).0 {
            DistanceResult::Apart(found) => {
                seen[0] += 1;
                let off = (found.distance - expected).abs();
                assert!(
                    off <= found.error_bound + rounding,
                    "{half} {at} {radius}: {found:?} {expected}"
                );
                assert!(found.error_bound <= 1e-9 * size, "{found:?}");
                assert_eq!(verdict(a, b), Verdict::Apart);
            }
            DistanceResult::Touching => {
                seen[1] += 1;
                assert_eq!(verdict(a, b), Verdict::Touching(()));
                let depth = Depths.resolve(a, b, &mut Default::default()).0;
                let Verdict::Touching(depth) = depth else { panic!("{depth:?}") };
                let off = (depth.depth + expected).abs();
                assert!(
                    off <= depth.error_bound + rounding,
                    "{half} {at} {radius}: {depth:?} {expected}"
                );
                let manifold = Manifolds::default().resolve(a, b, &mut Default::default()).0;
                assert!(matches!(manifold, Verdict::Touching(_)), "{manifold:?}");
            }
            other => assert!(expected.abs() < DECIDED * size, "{other:?} {expected}"),
        }
    }
    assert!(seen[0] > 500 && seen[1] > 500, "{seen:?}");
}

#[test]
fn a_plane_that_just_touches_is_told_from_one_that_just_does_not() {
    // |A·n| of half axes (2, 3, 6) and the normal (1, 1, 1) is 7.
    let shape = Shape::ellipsoid(DVec3::new(2.0, 3.0, 6.0)).unwrap();
    for shift in [DVec3::ZERO, DVec3::new(1.0, -2.0, 8.0), DVec3::splat(1e6)] {
        let pose = Pose::from_translation(shift).unwrap();
        let a = PosedShape { shape: &shape, pose: &pose };
        let touch = shift.element_sum() - 7.0;
        for (offset, expected) in [
            (touch, Verdict::Touching(())),
            (touch.next_down(), Verdict::Apart),
            (touch.next_up(), Verdict::Touching(())),
        ] {
            let plane = Shape::half_space(DVec3::ONE, offset).unwrap();
            let b = PosedShape { shape: &plane, pose: &Pose::IDENTITY };
            assert_eq!(verdict(a, b), expected, "{shift} {offset}");
        }
    }
}

#[test]
fn balls_are_answered_as_spheres() {
    let mut draw = draw_from(32);
    let mut touching = 0;
    for k in 0..1200 {
        let size = [1e-3, 1.0, 1e3][k % 3];
        let radius = (0.1 + 0.4 * draw.unit().abs()) * size;
        let ball = Shape::ellipsoid(DVec3::splat(radius)).unwrap();
        let sphere = Shape::sphere(radius).unwrap();
        let other = other(&mut draw, size);
        let pose_a = Pose::new(draw.rotation(), draw.vector() * (0.1 * size)).unwrap();
        let pose_b = Pose::new(draw.rotation(), draw.vector() * size).unwrap();
        let of = |shape| PosedShape { shape, pose: &pose_a };
        let b = PosedShape { shape: &other, pose: &pose_b };
        assert_eq!(verdict(of(&ball), b), verdict(of(&sphere), b), "{radius} {other:?}");
        match (distance::distance(of(&ball), b).0, distance::distance(of(&sphere), b).0) {
            (DistanceResult::Apart(ours), DistanceResult::Apart(expected)) => {
                let bound = ours.error_bound + expected.error_bound + 1e-14 * size;
                assert!(
                    (ours.distance - expected.distance).abs() <= bound,
                    "{ours:?} {expected:?}"
                );
            }
            (DistanceResult::Touching, DistanceResult::Touching) => touching += 1,
            differ => panic!("{differ:?}"),
        }
    }
    assert!(touching > 200, "{touching}");
}

/// A hull, a cuboid, a capsule, a triangle, a cylinder, a cone, an ellipsoid, a compound or a mesh.
fn other(draw: &mut Draw, size: f64) -> Shape {
    let length = |draw: &mut Draw| (0.1 + 0.5 * draw.unit().abs()) * size;
    let hull = |draw: &mut Draw| {
        Shape::hull((0..20).map(|_| draw.vector() * 0.5 * size).collect()).unwrap()
    };
    match draw.below(9) {
        0 => hull(draw),
        1 => Shape::cuboid(DVec3::from_array([(); 3].map(|()| length(draw)))).unwrap(),
        2 => Shape::capsule(length(draw), length(draw)).unwrap(),
        3 => Shape::triangle([(); 3].map(|()| draw.vector() * size)).unwrap(),
        4 => Shape::cylinder(length(draw), length(draw)).unwrap(),
        5 => Shape::cone(length(draw), length(draw)).unwrap(),
        6 => Shape::ellipsoid(half_axes(draw, size)).unwrap(),
        7 => {
            let mut part =
                |shape| (shape, Pose::new(draw.rotation(), draw.vector() * (0.3 * size)).unwrap());
            let ellipsoid = part(Shape::ellipsoid(DVec3::new(0.1, 0.2, 0.4) * size).unwrap());
            Shape::compound(vec![part(Shape::cuboid(DVec3::splat(0.2 * size)).unwrap()), ellipsoid])
                .unwrap()
        }
        _ => {
            let corners = (0..12).map(|_| draw.vector() * size).collect();
            Shape::mesh(corners, vec![[0, 1, 2], [3, 4, 5], [6, 7, 8], [9, 10, 11]]).unwrap()
        }
    }
}

#[test]
fn every_kind_is_between_a_polytope_inside_and_one_outside() {
    let mut draw = draw_from(33);
    let directions: Vec<DVec3> = (0..400)
        .map(|k| {
            let z = 1.0 - (f64::from(k) + 0.5) / 200.0;
            let (sine, cosine) = (f64::from(k) * 2.399963).sin_cos();
            let across = (1.0 - z * z).sqrt();
            DVec3::new(across * cosine, across * sine, z)
        })
        .collect();
    let mut resolved = [0; 2];
    for k in 0..900 {
        let size = [1e-3, 1.0, 1e3][k % 3];
        let half = half_axes(&mut draw, size);
        // The hull of points within 8 degrees of any direction, stretched by more than 1/cos(8°), holds the ball.
        let hull = |by: f64| {
            let points = directions.iter().map(|&d| half * d * by).collect();
            Shape::from(Polytope::hull(points).unwrap())
        };
        let (ellipsoid, inner, outer) =
            (Shape::ellipsoid(half).unwrap(), hull(1.0 - 1e-14), hull(1.02));
        let shape = other(&mut draw, size);
        let pose_a = Pose::new(draw.rotation(), draw.vector() * (0.1 * size)).unwrap();
        let pose_b = Pose::new(draw.rotation(), draw.vector() * (0.8 * size)).unwrap();
        let of = |shape| PosedShape { shape, pose: &pose_a };
        let b = PosedShape { shape: &shape, pose: &pose_b };
        let ours = verdict(of(&ellipsoid), b);
        if verdict(of(&inner), b) == Verdict::Touching(()) {
            assert_eq!(ours, Verdict::Touching(()), "{half} {shape:?}");
            resolved[0] += 1;
        }
        if verdict(of(&outer), b) == Verdict::Apart {
            assert_eq!(ours, Verdict::Apart, "{half} {shape:?}");
            resolved[1] += 1;
            let far = |shape| match distance::distance(of(shape), b).0 {
                DistanceResult::Apart(found) => {
                    [found.distance - found.error_bound, found.distance + found.error_bound]
                }
                other => panic!("{other:?}"),
            };
            let ([least, _], [low, high], [_, most]) = (far(&outer), far(&ellipsoid), far(&inner));
            assert!(least <= high && low <= most, "{half} {shape:?}");
        }
    }
    assert!(resolved[0] > 200 && resolved[1] > 200, "{resolved:?}");
}

#[test]
fn rays_meet_them_where_the_quadratic_says() {
    let mut draw = draw_from(34);
    let mut hits = 0;
    for k in 0..1000 {
        let size = [1e-3, 1.0, 1e3][k % 3];
        let half = half_axes(&mut draw, size);
        let ellipsoid = Shape::ellipsoid(half).unwrap();
        let pose = Pose::new(draw.rotation(), draw.vector() * size).unwrap();
        let origin = draw.vector().normalize() * (3.0 * size);
        let direction = (draw.vector() * (0.5 * size) - origin) / size;
        // On the unit ball.
        let (o, d) = (origin / half, direction / half);
        let (a, b, c) = (d.length_squared(), o.dot(d), o.length_squared() - 1.0);
        let root = b * b - a * c;
        let rotation = *pose.rotation();
        let ray = Ray::endless(pose.apply(origin), rotation * direction).unwrap();
        let hit = first_hit(&ray, PosedShape { shape: &ellipsoid, pose: &pose });
        if root > 1e-6 * b * b {
            hits += 1;
            let t = (-b - root.sqrt()) / a;
            let hit = hit.expect("a hit");
            assert!(
                hit.is_certain && (hit.t - t).abs() <= hit.error_bound() + 1e-9 * size,
                "{hit:?} {t}"
            );
        } else if root < -1e-6 * b * b {
            assert!(hit.is_none(), "{hit:?}");
        }
    }
    assert!(hits > 300, "{hits}");
}
