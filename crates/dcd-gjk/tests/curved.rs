//! Cylinders and cones: between prisms inside and round them, and decided where they should be.

mod judge;

use dcd_geom::glam::{DMat3, DVec3};
use dcd_geom::{Polytope, Pose, Shape};
use dcd_gjk::{DistanceResult, Placed, Verdict, certified, distance};
use judge::cases::Draw;
use std::f64::consts::PI;

/// Beyond this much of the pair's size f64 must decide (docs/numerics.md, "cylinders and cones").
const DECIDED: f64 = 1e-9;

/// A cylinder or a cone, and hulls inside and round it that differ from it by 1.2e-3 of its radius.
struct Bracket {
    shape: Shape,
    inner: Shape,
    outer: Shape,
}

impl Bracket {
    fn of(shape: Shape, discs: [(f64, f64); 2], swept: f64) -> Self {
        const SIDES: u32 = 64;
        let prism = |stretch: f64| {
            let rim = |k: u32| {
                let (sin, cos) = (2.0 * PI * f64::from(k) / f64::from(SIDES)).sin_cos();
                discs.map(|(z, r)| DVec3::new(r * stretch * cos, r * stretch * sin, z))
            };
            let hull = Polytope::hull((0..SIDES).flat_map(rim).collect()).unwrap();
            Shape::from(hull.rounded(swept).unwrap())
        };
        let outward = 1.0 / (PI / f64::from(SIDES)).cos();
        let shape = shape.rounded(swept).unwrap();
        Self { shape, inner: prism(1.0 - 1e-14), outer: prism(outward * (1.0 + 1e-14)) }
    }

    fn any(draw: &mut Draw, size: f64) -> Self {
        let [h, r] = [(); 2].map(|()| (0.1 + 0.5 * draw.unit().abs()) * size);
        let swept = if draw.below(3) == 0 { 0.125 * size } else { 0.0 };
        if draw.below(2) == 0 {
            Self::of(Shape::cylinder(h, r).unwrap(), [(-h, r), (h, r)], swept)
        } else {
            Self::of(Shape::cone(h, r).unwrap(), [(-h, r), (h, 0.0)], swept)
        }
    }
}

fn verdict(a: Placed<'_>, b: Placed<'_>) -> Verdict<()> {
    let answer = certified::overlap_of(a, b).0;
    assert_eq!(answer, certified::overlap_of(b, a).0);
    answer
}

/// A hull, a cuboid, a sphere, a capsule, a triangle, a cylinder or a cone.
fn other(draw: &mut Draw, size: f64) -> Shape {
    let length = |draw: &mut Draw| (0.1 + 0.5 * draw.unit().abs()) * size;
    match draw.below(7) {
        0 => Shape::hull((0..20).map(|_| draw.vector() * 0.5 * size).collect()).unwrap(),
        1 => Shape::cuboid(DVec3::from_array([(); 3].map(|()| length(draw)))).unwrap(),
        2 => Shape::sphere(length(draw)).unwrap(),
        3 => Shape::capsule(length(draw), length(draw)).unwrap(),
        4 => Shape::triangle([(); 3].map(|()| draw.vector() * size)).unwrap(),
        5 => Shape::cylinder(length(draw), length(draw)).unwrap(),
        _ => Shape::cone(length(draw), length(draw)).unwrap(),
    }
}

#[test]
fn answers_and_distances_are_between_those_of_prisms_inside_and_outside() {
    let mut draw = Draw(21);
    let mut settled = [0; 2];
    for size in [1e-3, 1.0, 1e3] {
        for _ in 0..400 {
            let bracket = Bracket::any(&mut draw, size);
            let shape = other(&mut draw, size);
            let pose = |draw: &mut Draw, far: f64| {
                Pose::new(draw.rotation(), draw.vector() * (far * size)).unwrap()
            };
            let (pose_a, pose_b) = (pose(&mut draw, 0.1), pose(&mut draw, 0.9));
            let b = Placed { shape: &shape, pose: &pose_b };
            let of = |shape| Placed { shape, pose: &pose_a };
            let ours = verdict(of(&bracket.shape), b);
            if verdict(of(&bracket.inner), b) == Verdict::Touching(()) {
                assert_eq!(ours, Verdict::Touching(()), "{:?} {shape:?}", bracket.shape);
                settled[0] += 1;
            }
            if verdict(of(&bracket.outer), b) == Verdict::Apart {
                assert_eq!(ours, Verdict::Apart, "{:?} {shape:?}", bracket.shape);
                settled[1] += 1;
                let far = |shape| match distance::distance(of(shape), b).0 {
                    DistanceResult::Apart(found) => {
                        [found.distance - found.error_bound, found.distance + found.error_bound]
                    }
                    other => panic!("{other:?}"),
                };
                let ([least, _], [low, high], [_, most]) =
                    (far(&bracket.outer), far(&bracket.shape), far(&bracket.inner));
                assert!(least <= high && low <= most, "{:?} {shape:?}", bracket.shape);
            }
        }
    }
    assert!(settled[0] > 300 && settled[1] > 300, "{settled:?}");
}

#[test]
fn gaps_and_overlaps_beyond_the_stated_bound_are_decided() {
    let mut draw = Draw(22);
    for k in 0..1500 {
        let size = [1e-3, 1.0, 1e3][k % 3];
        let (a, b) = (Bracket::any(&mut draw, size).shape, other(&mut draw, size));
        let pose_a = Pose::new(draw.rotation(), DVec3::ZERO).unwrap();
        let (rotation, far) = (draw.rotation(), draw.vector().normalize() * (6.0 * size));
        let pose_b = Pose::new(rotation, far).unwrap();
        let placed_a = Placed { shape: &a, pose: &pose_a };
        let start = distance::distance(placed_a, Placed { shape: &b, pose: &pose_b }).0;
        let DistanceResult::Apart(found) = start else { panic!("{a:?} {b:?}") };
        for exponent in [2, 4, 6, 8, 9] {
            let gap = 10f64.powi(-exponent) * size + 2.0 * DECIDED * size;
            for sign in [1.0, -1.0] {
                let way = found.normal * (found.distance - sign * gap);
                let pose_b = Pose::new(rotation, far - way).unwrap();
                let answer = verdict(placed_a, Placed { shape: &b, pose: &pose_b });
                assert!(!matches!(answer, Verdict::Undecided(_)), "{a:?} {b:?} {gap} {answer:?}");
                // Two corners may pass each other.
                assert!(sign < 0.0 || answer == Verdict::Apart, "{a:?} {b:?} {gap}");
            }
        }
    }
}

#[test]
fn aligned_and_identical_shapes_are_decided() {
    let (cylinder, cone) = (Shape::cylinder(0.5, 0.25).unwrap(), Shape::cone(0.5, 0.25).unwrap());
    let cube = Shape::cuboid(DVec3::splat(0.5)).unwrap();
    let down = DMat3::from_cols(DVec3::X, -DVec3::Y, -DVec3::Z);
    for shift in [DVec3::ZERO, DVec3::X * 0.1, DVec3::new(0.1, 0.05, 0.0)] {
        for a in [&cylinder, &cone] {
            for b in [&cylinder, &cone, &cube] {
                let judge = |rotation: DMat3, z: f64| {
                    let there = Pose::from_matrix(rotation, shift + DVec3::Z * z).unwrap();
                    let here = Placed { shape: a, pose: &Pose::IDENTITY };
                    verdict(here, Placed { shape: b, pose: &there })
                };
                // Base to base, the other one below and upside down.
                for gap in [1e-9, 1e-6, 1e-3] {
                    assert_eq!(judge(down, -1.0 + gap), Verdict::Touching(()), "{a:?} {b:?} {gap}");
                    assert_eq!(judge(down, -1.0 - gap), Verdict::Apart, "{a:?} {b:?} {gap}");
                }
                for z in [0.0, 0.25, -0.25] {
                    assert_eq!(judge(DMat3::IDENTITY, z), Verdict::Touching(()), "{a:?} {b:?} {z}");
                }
            }
        }
    }
}
