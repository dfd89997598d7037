//! How deep.

use super::scenes::{Draw, pile, shapes};
use super::within::found;
use super::{PosedSupport, answer_of, solve};
use dcd_geom::glam::{DQuat, DVec3};
use dcd_geom::{Polytope, Shape, Support, SupportMap};
use dcd_gjk::{
    Accuracy, Depths, Method, Overlap, PairSolver, Pairwise, PosedShape, ThenMeasure, Verdict,
    WithAccuracy, contract, epa,
};
use std::sync::Arc;

#[test]
fn depths_keep_the_contract_one_by_one_and_after_the_lanes() {
    let (scene, pairs) = pile(shapes(), 40);
    contract::narrow_phase(&Pairwise(Depths), &scene, &pairs).unwrap();
    contract::narrow_phase(&ThenMeasure::new(Depths).unwrap(), &scene, &pairs).unwrap();
}

#[test]
fn every_touching_pair_has_its_depth() {
    let mut polytopes = shapes();
    polytopes.pop();
    let (scene, pairs) = pile(polytopes, 60);
    let (yes, _) = found(&Overlap::default(), &scene, &pairs);
    let (deep, report) = found(&ThenMeasure::new(Depths).unwrap(), &scene, &pairs);
    let pairs_of = |contacts: &[dcd_gjk::Contact<_>]| -> Vec<_> {
        contacts.iter().map(|contact| contact.pair).collect()
    };
    assert!(yes.len() > 50 && report.undecided().is_empty(), "{}", yes.len());
    assert_eq!(yes.iter().map(|contact| contact.pair).collect::<Vec<_>>(), pairs_of(&deep));
    assert_eq!(deep, found(&Pairwise(Depths), &scene, &pairs).0);
    for depth in deep.iter().map(|contact| contact.answer) {
        assert!(depth.depth > 0.0 || depth.error_bound < 1e-15, "{depth:?}");
        assert!((depth.normal.length() - 1.0).abs() < 1e-12 && !depth.is_saturated());
    }
}

/// Calls apart what it is asked about, as a foreign library may what hardly touches.
struct NeverTouching {
    on_purpose: bool,
}

impl PairSolver for NeverTouching {
    type Answer = ();
    type Scratch = ();
    fn method(&self) -> Method {
        Method::Foreign
    }
    fn solve(&self, _: PosedShape<'_>, _: PosedShape<'_>, (): &mut ()) -> Verdict<()> {
        Verdict::Apart
    }
    fn may_leave_out(&self) -> bool {
        self.on_purpose
    }
}

#[test]
fn a_pair_that_touches_and_is_not_measured_is_undecided() {
    let (scene, pairs) = pile(shapes(), 40);
    let (yes, before) = found(&Overlap::default(), &scene, &pairs);
    assert!(yes.len() > 20);
    for on_purpose in [false, true] {
        let narrow = ThenMeasure::new(NeverTouching { on_purpose }).unwrap();
        let (contacts, report) = found(&narrow, &scene, &pairs);
        let lost = if on_purpose { 0 } else { yes.len() };
        let due = before.undecided().len() + lost;
        assert_eq!((contacts.len(), report.undecided().len()), (0, due));
    }
}

/// An ellipsoid, as a foreign shape: its support is a formula, right to a few roundings.
struct Ellipsoid(DVec3);

impl SupportMap<f64> for Ellipsoid {
    fn support(&self, direction: DVec3) -> Support<f64> {
        let stretched = self.0 * direction;
        let point = self.0 * stretched.try_normalize().unwrap_or(DVec3::X);
        // A feature for a point: its own bits, mixed.
        let bits = point.to_array().map(f64::to_bits);
        let mixed = bits.iter().fold(0u64, |mix, x| (mix ^ x).wrapping_mul(0x9e37_79b9_7f4a_7c15));
        Support { point, feature: (mixed >> 32) as u32 }
    }

    fn support_error(&self) -> f64 {
        4.0 * f64::EPSILON * self.0.max_element()
    }
}

#[test]
fn curved_shapes_have_a_depth_within_its_bound() {
    // Two ellipsoids along a common principal axis: the depth along it is known, and least.
    let half = DVec3::new(0.5, 1.0, 1.5);
    let shape = Shape::custom(Arc::new(Ellipsoid(half))).unwrap();
    for overlap in [1e-6, 1e-3, 0.1, 0.25] {
        let a = PosedSupport::at(&shape, DVec3::new(10.0, 0.0, 0.0));
        let b = PosedSupport::at(&shape, DVec3::new(11.0 - overlap, 0.0, 0.0));
        let found = answer_of(&Depths, &a, &b);
        assert!(found.lower() <= overlap && overlap <= found.upper(), "{overlap} {found:?}");
        assert!(found.error_bound <= 1e-8 * overlap + 1e-14, "{overlap} {found:?}");
        assert!((found.normal.dot(DVec3::X) - 1.0).abs() < 1e-4, "{found:?}");
    }
}

#[test]
fn a_foreign_sphere_is_as_deep_as_our_own() {
    let mut draw = Draw(11);
    let ours = Shape::sphere(0.5).unwrap();
    let foreign = Shape::custom(Arc::new(Polytope::sphere(0.5).unwrap())).unwrap();
    let cube = Shape::cuboid(DVec3::splat(0.5)).unwrap();
    for _ in 0..50 {
        let (turn, place) = (draw.turn(), draw.vector() * 0.8);
        let a = PosedSupport::new(cube.clone(), DQuat::IDENTITY, DVec3::ZERO);
        let answers = [&ours, &foreign]
            .map(|s| solve(&Depths, &a, &PosedSupport::new(s.clone(), turn, place)));
        let [Verdict::Touching(ours), Verdict::Touching(foreign)] = answers else {
            assert_eq!(answers[0], answers[1]);
            continue;
        };
        let gap = (ours.depth - foreign.depth).abs();
        assert!(gap <= ours.error_bound + foreign.error_bound + 1e-15, "{ours:?} {foreign:?}");
        assert!(foreign.error_bound < 1e-13, "{foreign:?}");
    }
}

#[test]
fn the_depth_of_a_swapped_pair_is_mirrored_bit_for_bit() {
    let mut draw = Draw(12);
    let shapes = shapes();
    let mut touching = 0;
    for k in 0..200usize {
        let body = |k: usize, draw: &mut Draw| {
            PosedSupport::new(shapes[k % shapes.len()].clone(), draw.turn(), draw.vector() * 0.5)
        };
        let (a, b) = (body(k, &mut draw), body(k / 6, &mut draw));
        let (Verdict::Touching(ab), Verdict::Touching(ba)) =
            (solve(&Depths, &a, &b), solve(&Depths, &b, &a))
        else {
            continue;
        };
        touching += 1;
        assert_eq!((ab.depth, ab.error_bound, ab.normal), (ba.depth, ba.error_bound, -ba.normal));
        assert_eq!((ab.point_a, ab.point_b), (ba.point_b, ba.point_a));
    }
    assert!(touching > 100, "{touching}");
}

#[test]
fn a_cylinder_and_a_cone_have_their_depth_against_boxes_and_each_other() {
    let (cylinder, cone) = (Shape::cylinder(1.0, 0.5).unwrap(), Shape::cone(1.0, 0.5).unwrap());
    let cube = Shape::cuboid(DVec3::splat(0.5)).unwrap();
    let turn = DQuat::from_rotation_z(0.7);
    // Caps and sides whose depth is known: along z two half heights, along x a radius.
    for (a, b, place, depth) in [
        (&cylinder, &cube, DVec3::new(0.1, 0.0, 1.4), 0.1),
        (&cylinder, &cube, DVec3::new(0.9, 0.0, 0.0), 0.1),
        (&cylinder, &cylinder, DVec3::new(0.6, 0.0, 0.3), 0.4),
        (&cone, &cube, DVec3::new(0.1, 0.0, -1.4), 0.1),
    ] {
        let flat = DQuat::IDENTITY;
        let (a, b) = (
            PosedSupport::new(a.clone(), turn, DVec3::ZERO),
            PosedSupport::new(b.clone(), flat, place),
        );
        let found = answer_of(&Depths, &a, &b);
        assert!((found.depth - depth).abs() <= found.error_bound, "{found:?}");
        assert!(found.error_bound < 1e-8 * depth, "{found:?}");
    }
}

#[test]
fn a_floor_has_the_depth_of_what_is_below_it() {
    let floor = Shape::half_space(DVec3::Z, 0.0).unwrap();
    let cube = Shape::cuboid(DVec3::splat(0.5)).unwrap();
    let (a, b) = (PosedSupport::at(&floor, DVec3::ZERO), PosedSupport::at(&cube, DVec3::Z * 0.25));
    let found = answer_of(&Depths, &a, &b);
    assert!((found.depth - 0.25).abs() <= found.error_bound && found.normal == DVec3::Z);
    assert_eq!(solve(&Depths, &a, &PosedSupport::at(&cube, DVec3::Z)), Verdict::Apart);
    assert!(matches!(solve(&Depths, &a, &a), Verdict::Undecided(_)));
}

#[test]
fn formulas_for_rounded_shapes_hold_beside_the_expanding_polytope() {
    let mut draw = Draw(29);
    let round = |draw: &mut Draw, kind: u32| {
        let size = 0.2 + 0.1 * draw.unit();
        match kind % 3 {
            0 => Shape::sphere(size).unwrap(),
            1 => Shape::capsule(0.5, size).unwrap(),
            _ => Shape::cuboid(DVec3::splat(2.0 * size)).unwrap(),
        }
    };
    let (mut measured, mut sharp) = (0, 0);
    for k in 0..6000u32 {
        let [one, other] = [k, k / 3].map(|kind| round(&mut draw, kind));
        let place = draw.vector() * 10f64.powi(-((k % 8) as i32) / 2);
        let a = PosedSupport::new(one, draw.turn(), draw.vector() * 10.0);
        let there = a.pose.translation() + place;
        let b = PosedSupport::new(other, draw.turn(), there);
        let (in_a, in_b) = (a.shape.as_polytope().unwrap(), b.shape.as_polytope().unwrap());
        let placed = [
            dcd_gjk::PosedSupport::polytope(in_a, &a.pose),
            dcd_gjk::PosedSupport::polytope(in_b, &b.pose),
        ];
        let expected = epa::depth(placed[0], placed[1], &mut epa::Scratch::default());
        let size = in_a.reach() + in_b.reach() + place.length();
        for accuracy in [Accuracy::F32, Accuracy::F64, Accuracy::Certified] {
            let solver = WithAccuracy::new(Depths, accuracy);
            let found = solve(&solver, &a, &b);
            let seen = solve(&solver, &b, &a);
            let (Verdict::Touching(found), Verdict::Touching(seen), Verdict::Touching(truth)) =
                (found, seen, expected)
            else {
                assert!(found == Verdict::Apart && expected == Verdict::Apart, "{a:?}\n{b:?}");
                continue;
            };
            let off = (found.depth - truth.depth).abs();
            assert!(
                off <= found.error_bound + truth.error_bound,
                "{found:?} {truth:?} {a:?} {b:?}"
            );
            assert_eq!((seen.depth, seen.error_bound), (found.depth, found.error_bound));
            assert_eq!((seen.point_a, seen.normal), (found.point_b, -found.normal));
            let along = found.point_a - found.point_b - found.normal * found.depth;
            assert!(along.length() < 1e-13 * (size + 20.0), "{found:?}");
            match accuracy {
                Accuracy::F32 => assert!(found.error_bound <= 1.6e-5 * size, "{found:?}"),
                Accuracy::F64 => assert!(found.error_bound <= 1e-9 * size, "{found:?}"),
                Accuracy::Certified => {
                    let most = (1e-9 * found.depth).max(1e-21 * size);
                    assert!(found.error_bound <= most, "{found:?}");
                    sharp += usize::from(found.error_bound <= 1e-13 * found.depth);
                }
            }
            measured += 1;
        }
        // Measured at once or after a yes, a depth is the same.
        let mut scratch = epa::Scratch::default();
        if let Verdict::Touching(_) = expected {
            let after = Depths.measure(a.placed(), b.placed(), &mut scratch);
            assert_eq!(Depths.solve(a.placed(), b.placed(), &mut scratch), after);
        }
    }
    println!("{measured} depths, {sharp} of the certified to thirteen digits");
    assert!(measured > 6000 && sharp > 1000, "{measured} {sharp}");
}
