//! Cylinders and cones: between prisms inside and round them, and decided where they should be; their
//! supports and answers against exact arithmetic.

mod judge;

use dcd_geom::glam::{DMat3, DVec3};
use dcd_geom::{Curved, Polytope, Pose, Shape, SupportMap};
use dcd_gjk::{Accuracy, DistanceResult, PosedShape, Verdict, certified, distance};
use judge::cases::Draw;
use num_bigint::BigInt;
use std::f64::consts::PI;

/// Beyond this much of the pair's size f64 must decide (docs/numerics/proofs.md, "cylinders and cones").
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

fn verdict(a: PosedShape<'_>, b: PosedShape<'_>) -> Verdict<()> {
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
    let mut resolved = [0; 2];
    for size in [1e-3, 1.0, 1e3] {
        for _ in 0..400 {
            let bracket = Bracket::any(&mut draw, size);
            let shape = other(&mut draw, size);
            let pose = |draw: &mut Draw, far: f64| {
                Pose::new(draw.rotation(), draw.vector() * (far * size)).unwrap()
            };
            let (pose_a, pose_b) = (pose(&mut draw, 0.1), pose(&mut draw, 0.9));
            let b = PosedShape { shape: &shape, pose: &pose_b };
            let of = |shape| PosedShape { shape, pose: &pose_a };
            let ours = verdict(of(&bracket.shape), b);
            if verdict(of(&bracket.inner), b) == Verdict::Touching(()) {
                assert_eq!(ours, Verdict::Touching(()), "{:?} {shape:?}", bracket.shape);
                resolved[0] += 1;
            }
            if verdict(of(&bracket.outer), b) == Verdict::Apart {
                assert_eq!(ours, Verdict::Apart, "{:?} {shape:?}", bracket.shape);
                resolved[1] += 1;
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
    assert!(resolved[0] > 300 && resolved[1] > 300, "{resolved:?}");
}

#[test]
fn a_sphere_above_the_rim_of_a_flat_cone_is_apart() {
    let shapes = [Shape::sphere(0.1).unwrap(), Shape::cone(0.0, 1.0).unwrap()];
    for (at, due) in [(10.0, 9.9), (-10.0, 9.9), (0.3, 0.2)] {
        let there = Pose::from_translation(DVec3::new(1.0, 0.0, at)).unwrap();
        let a = PosedShape { shape: &shapes[0], pose: &there };
        let b = PosedShape { shape: &shapes[1], pose: &Pose::IDENTITY };
        for accuracy in [Accuracy::F32, Accuracy::F64, Accuracy::Certified] {
            let (found, _) = distance::distance_at(accuracy, a, b);
            let DistanceResult::Apart(found) = found else { panic!("{accuracy:?} {at} {found:?}") };
            assert!((found.distance - due).abs() <= 1e-9, "{accuracy:?} {at} {found:?}");
        }
    }
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
        let placed_a = PosedShape { shape: &a, pose: &pose_a };
        let start = distance::distance(placed_a, PosedShape { shape: &b, pose: &pose_b }).0;
        let DistanceResult::Apart(found) = start else { panic!("{a:?} {b:?}") };
        for exponent in [2, 4, 6, 8, 9] {
            let gap = 10f64.powi(-exponent) * size + 2.0 * DECIDED * size;
            for sign in [1.0, -1.0] {
                let way = found.normal * (found.distance - sign * gap);
                let pose_b = Pose::new(rotation, far - way).unwrap();
                let answer = verdict(placed_a, PosedShape { shape: &b, pose: &pose_b });
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
                    let here = PosedShape { shape: a, pose: &Pose::IDENTITY };
                    verdict(here, PosedShape { shape: b, pose: &there })
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

/// A float in units of 2⁻³⁰⁰. Products and sums of these are exact.
fn whole(x: f64) -> BigInt {
    let scaled = x * 2f64.powi(300);
    assert!(scaled.is_finite() && scaled.fract() == 0.0, "{x}");
    let exponent = ((scaled.to_bits() >> 52 & 0x7ff) as i32 - 1075).max(0);
    BigInt::from((scaled / 2f64.powi(exponent)) as i128) << exponent
}

/// Of units of 2⁻³⁰⁰ to the power `power`.
fn rounded(x: &BigInt, power: i32) -> f64 {
    let shift = (x.bits() as i64 - 64).max(0);
    let top = x.clone() >> shift;
    let top = i128::try_from(top).unwrap() as f64;
    // In two steps: the unit to a power is out of range.
    let exponent = shift as i32 - 300 * power;
    top * 2f64.powi(exponent / 2) * 2f64.powi(exponent - exponent / 2)
}

/// How far the support in that direction falls short of the farthest point, and how far it is outside
/// of its disc, both in units of 2⁻⁵³·(half height + radius), the first per |d|₁.
fn support_is_off(shape: &Curved, d: DVec3) -> [f64; 2] {
    const U: f64 = f64::EPSILON / 2.0;
    let found = shape.support(d).point;
    let [x, y, z] = d.to_array().map(whole);
    let [px, py, pz] = found.to_array().map(whole);
    let across = &x * &x + &y * &y;
    let along = &x * &px + &y * &py + &z * &pz;
    let size = shape.half_height() + shape.radius();
    let short = shape.discs().map(|(height, radius)| {
        // ρ·√q − Y = (ρ²·q − Y²)/(ρ·√q + Y), the numerator exactly.
        let radius = whole(radius);
        let rest = &along - &z * whole(height);
        let reach = &radius * &radius * &across;
        let (root, rest_f64) = (rounded(&reach, 4).sqrt(), rounded(&rest, 2));
        match rest_f64 > 0.0 {
            true => rounded(&(reach - &rest * &rest), 4) / (root + rest_f64),
            false => root - rest_f64,
        }
    });
    let short = short[0].max(short[1]) / (U * size * d.abs().element_sum());
    let [lower, upper] = shape.discs();
    let radius = if found.z > 0.0 { upper.1 } else { lower.1 };
    let beyond = &px * &px + &py * &py - whole(radius) * whole(radius);
    let outside = rounded(&beyond, 2) / (2.0 * radius.max(f64::MIN_POSITIVE)) / (U * size);
    [short, outside]
}

#[test]
fn supports_fall_short_by_less_than_the_proved_twelve_roundings() {
    let mut draw = Draw(51);
    let length = |draw: &mut Draw| (0.1 + draw.unit().abs()) * 2f64.powi(draw.below(9) as i32 - 4);
    let shape = |kind: bool, h: f64, r: f64| {
        if kind { Curved::cylinder(h, r) } else { Curved::cone(h, r) }.unwrap()
    };
    let mut worst = [0.0f64; 2];
    for start in 0..400 {
        let kind = start % 2 == 0;
        let (mut h, mut r) = (length(&mut draw), length(&mut draw));
        let mut d = draw.vector() * DVec3::new(1.0, length(&mut draw), length(&mut draw));
        if !kind && start % 4 == 1 {
            // Normal to the side, where both discs are as far.
            d.z = d.x.hypot(d.y) * r / (2.0 * h);
        }
        let mut best = support_is_off(&shape(kind, h, r), d);
        for _ in 0..60 {
            let near = |x: f64, draw: &mut Draw| {
                let most = 1 << (1 + draw.below(40));
                let ulps = draw.below(most) as i64;
                let other = f64::from_bits((x.to_bits() as i64 + ulps) as u64);
                if draw.below(2) == 0 { other } else { x }
            };
            let (other_h, other_r) = (near(h, &mut draw), near(r, &mut draw));
            let other = DVec3::from_array(d.to_array().map(|x| near(x, &mut draw)));
            let found = support_is_off(&shape(kind, other_h, other_r), other);
            for k in 0..2 {
                worst[k] = worst[k].max(found[k]);
            }
            if found[0] > best[0] {
                (best, h, r, d) = (found, other_h, other_r, other);
            }
        }
    }
    println!("short by {:.2} of 12, outside by {:.2} of 6", worst[0], worst[1]);
    assert!(worst[0] <= 12.0 && worst[1] <= 6.0, "{worst:?}");
    assert!(worst[0] > 1.0 && worst[1] > 1.0, "the climb finds nothing: {worst:?}");
}

/// Two shapes of which it is known exactly whether they touch at a place.
struct Known {
    shapes: [Shape; 2],
    rotation: DMat3,
    /// Where the second is, by one number.
    at: Box<dyn Fn(f64) -> DVec3>,
    /// Whether they touch there.
    touches: Box<dyn Fn(DVec3) -> bool>,
    /// Near the number where that changes.
    about: f64,
}

/// x² + y² ≤ (Σ lengths)², exactly.
fn within(x: f64, y: f64, lengths: [f64; 4]) -> bool {
    let sum: BigInt = lengths.into_iter().map(whole).sum();
    whole(x) * whole(x) + whole(y) * whole(y) <= &sum * &sum
}

fn known(draw: &mut Draw, k: usize) -> Known {
    let size = [1.0, 2f64.powi(-20), 2f64.powi(20)][k % 3];
    let mut length = || (0.1 + 0.9 * draw.unit().abs()) * size;
    let (h, r, g, s) = (length(), length(), length(), length());
    let swept = if k.is_multiple_of(2) { [0.0; 2] } else { [length(), length()] };
    let [a, b] = swept;
    let cylinder = |h, r, swept| Shape::cylinder(h, r).unwrap().rounded(swept).unwrap();
    let cone = |h, r, swept| Shape::cone(h, r).unwrap().rounded(swept).unwrap();
    let quarter = DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X);
    let (c, z) = (draw.unit() * r.min(s), draw.unit() * 0.9 * h.min(g));
    let lengths = [r, s, a, b];
    match k % 5 {
        // Side by side: the axes parallel, the heights overlapping.
        0 => Known {
            shapes: [cylinder(h, r, a), cylinder(g, s, b)],
            rotation: DMat3::IDENTITY,
            at: Box::new(move |x| DVec3::new(x, c, z)),
            touches: Box::new(move |t| within(t.x, t.y, lengths)),
            about: ((r + s + a + b).powi(2) - c * c).sqrt(),
        },
        // The cone's base is as high as some of the cylinder.
        1 => Known {
            shapes: [cone(h, r, a), cylinder(g, s, b)],
            rotation: DMat3::IDENTITY,
            at: Box::new(move |x| DVec3::new(x, c, z - h)),
            touches: Box::new(move |t| within(t.x, t.y, lengths)),
            about: ((r + s + a + b).powi(2) - c * c).sqrt(),
        },
        // End to end: the second's disc above the first's, overlapping it.
        2 => Known {
            shapes: [cylinder(h, r, a), cylinder(g, s, b)],
            rotation: DMat3::IDENTITY,
            at: Box::new(move |z| DVec3::new(c, 0.0, z)),
            touches: Box::new(move |t| within(t.z, 0.0, [h, g, a, b])),
            about: h + g + a + b,
        },
        // The apex below the middle of a disc.
        3 => Known {
            shapes: [cone(h, r, a), cylinder(g, s, b)],
            rotation: DMat3::IDENTITY,
            at: Box::new(move |z| DVec3::new(0.9 * c.abs().min(s), 0.0, z)),
            touches: Box::new(move |t| within(t.z, 0.0, [h, g, a, b])),
            about: h + g + a + b,
        },
        // Crossed: the second's axis along x.
        _ => Known {
            shapes: [cylinder(h, r, a), cylinder(g, s, b)],
            rotation: quarter,
            at: Box::new(move |y| DVec3::new(0.5 * z, y, 0.5 * z)),
            touches: Box::new(move |t| within(t.y, 0.0, lengths)),
            about: r + s + a + b,
        },
    }
}

#[test]
fn pairs_known_exactly_are_never_contradicted_at_neighbouring_floats() {
    let mut draw = Draw(52);
    let mut open = 0;
    for k in 0..300 {
        let Known { shapes: [a, b], rotation, at, touches, about } = known(&mut draw, k);
        let ulps = |x: f64, by: i64| f64::from_bits((x.to_bits() as i64 + by) as u64);
        let (mut near, mut far) = (ulps(about, -1 << 20), ulps(about, 1 << 20));
        assert!(touches(at(near)) && !touches(at(far)), "{k}");
        while near.next_up() < far {
            let middle = f64::from_bits(near.to_bits() + (far.to_bits() - near.to_bits()) / 2);
            if touches(at(middle)) { near = middle } else { far = middle }
        }
        for exponent in 0..36 {
            let step = (1i64 << exponent) - 1;
            for (steps, truth) in [(ulps(near, -step), true), (ulps(far, step), false)] {
                let pose = Pose::from_matrix(rotation, at(steps)).unwrap();
                let here = PosedShape { shape: &a, pose: &Pose::IDENTITY };
                let there = PosedShape { shape: &b, pose: &pose };
                match verdict(here, there) {
                    Verdict::Touching(()) => assert!(truth, "{k} {a:?} {b:?} {pose:?}"),
                    Verdict::Apart => assert!(!truth, "{k} {a:?} {b:?} {pose:?}"),
                    Verdict::Undecided(_) => {
                        open += 1;
                        // 2³⁴ ulps are a millionth.
                        assert!(exponent < 26, "{k} {a:?} {b:?} {pose:?} {exponent}");
                    }
                }
                let gap = (steps - near).abs();
                match distance::distance(here, there).0 {
                    DistanceResult::Interval { within: found, depth, .. } => {
                        assert!(found.distance == 0.0 && found.error_bound.is_finite());
                        // Along the axis that defines the place, nothing is farther or deeper.
                        let bound = if truth { depth } else { found.error_bound };
                        assert!(bound >= 0.5 * gap && depth.is_finite(), "{k} {found:?} {gap}");
                    }
                    DistanceResult::Apart(found) => assert!(!truth, "{k} {found:?}"),
                    DistanceResult::Touching => assert!(truth, "{k}"),
                    DistanceResult::Undecided(reason) => panic!("{k}: {reason:?}"),
                }
            }
        }
    }
    assert!(open > 0, "nothing is near the bound");
}
