//! Half-spaces against the exact method: near the origin, a half-space is a box of its depth.

mod judge;

use dcd_geom::glam::{DMat3, DVec3};
use dcd_geom::{HalfSpace, Polytope, Pose, Shape};
use dcd_gjk::certified::{overlap_exactly, overlap_of};
use dcd_gjk::closed::half_space;
use dcd_gjk::{
    Accuracy, Depths, DistanceResult, PairSolver, PosedShape, PosedSupport, Verdict, distance,
};
use judge::cases::Draw;

/// z ≤ `offset` as far as a pair of `size` reaches: the same plane, with the same pose exactly the
/// same points.
fn boxed(offset: f64, size: f64) -> Polytope {
    let wide = [-64.0 * size, 64.0 * size];
    let corners = wide.into_iter().flat_map(|x| {
        wide.into_iter().flat_map(move |y| [DVec3::new(x, y, offset), DVec3::new(x, y, wide[0])])
    });
    Polytope::hull(corners.collect()).unwrap()
}

fn hull(draw: &mut Draw, size: f64) -> Polytope {
    let count = 1 + draw.below(12);
    let vertices = (0..count).map(|_| draw.vector() * size).collect();
    let radius = if draw.below(2) == 0 { 0.0 } else { 0.25 * size };
    Polytope::hull(vertices).unwrap().rounded(radius).unwrap()
}

fn pose(draw: &mut Draw, size: f64) -> Pose {
    Pose::new(draw.rotation(), draw.vector() * size).unwrap()
}

fn touches(a: PosedShape<'_>, b: PosedShape<'_>) -> bool {
    let answer = overlap_of(a, b).0;
    assert_eq!(answer, overlap_of(b, a).0);
    match answer {
        Verdict::Touching(()) => true,
        Verdict::Apart => false,
        Verdict::Undecided(reason) => panic!("{reason:?}"),
    }
}

#[test]
fn polytopes_are_judged_as_the_exact_method_judges_a_box_of_the_same_plane() {
    let mut draw = Draw(5);
    let mut flips = 0;
    for size in [1e-3, 1.0, 1e3] {
        for _ in 0..60 {
            let polytope = hull(&mut draw, size);
            let (pose_a, pose_b) = (pose(&mut draw, size), pose(&mut draw, size));
            let swept = if draw.below(2) == 0 { 0.0 } else { 0.125 * size };
            let judge = |offset: f64| {
                let half_space = HalfSpace::new(DVec3::Z, offset).unwrap().rounded(swept).unwrap();
                let (a, b) = (Shape::from(half_space), Shape::from(polytope.clone()));
                let ours = touches(
                    PosedShape { shape: &a, pose: &pose_a },
                    PosedShape { shape: &b, pose: &pose_b },
                );
                let solid = boxed(offset, size).rounded(swept).unwrap();
                let (a, b) = (
                    PosedSupport::polytope(&solid, &pose_a),
                    PosedSupport::polytope(&polytope, &pose_b),
                );
                assert_eq!(
                    ours,
                    overlap_exactly(a, b),
                    "{offset:?} {polytope:?} {pose_a:?} {pose_b:?}"
                );
                ours
            };
            // Down to the two neighbouring offsets between which the answer flips.
            let (mut apart, mut touching) = (-8.0 * size, 8.0 * size);
            assert!(!judge(apart) && judge(touching));
            loop {
                let middle = 0.5 * (apart + touching);
                if middle <= apart || middle >= touching {
                    break;
                }
                if judge(middle) { touching = middle } else { apart = middle }
            }
            flips += usize::from(apart.next_up() == touching);
        }
    }
    assert_eq!(flips, 180);
}

#[test]
fn a_normal_counts_whatever_its_length_and_the_pose_as_it_is() {
    let mut draw = Draw(6);
    for _ in 0..200 {
        let polytope = hull(&mut draw, 1.0);
        let pose_b = pose(&mut draw, 2.0);
        // A matrix as far from a rotation as a pose may be.
        let off = DMat3::from_diagonal(DVec3::ONE + draw.vector() * 3e-7);
        let rotation = DMat3::from_quat(draw.rotation()) * off;
        let pose_a = Pose::from_matrix(rotation, draw.vector()).unwrap();
        let offset = draw.unit();
        let length = 2f64.powi(draw.below(9) as i32 - 4);
        let a = Shape::half_space(DVec3::Z * length, offset * length).unwrap();
        let b = Shape::from(polytope.clone());
        let ours = touches(
            PosedShape { shape: &a, pose: &pose_a },
            PosedShape { shape: &b, pose: &pose_b },
        );
        let solid = boxed(offset, 1.0);
        let (a, b) =
            (PosedSupport::polytope(&solid, &pose_a), PosedSupport::polytope(&polytope, &pose_b));
        assert_eq!(ours, overlap_exactly(a, b));
    }
}

#[test]
fn cylinders_and_cones_touch_a_floor_up_to_the_last_bit() {
    let floor = Shape::half_space(DVec3::Z * 3.0, 0.0).unwrap();
    let origin = Pose::IDENTITY;
    let lying = DMat3::from_cols(DVec3::X, DVec3::Z, -DVec3::Y);
    let down = DMat3::from_cols(DVec3::X, -DVec3::Y, -DVec3::Z);
    let (cylinder, cone) =
        (Shape::cylinder(0.75, 0.375).unwrap(), Shape::cone(0.75, 0.375).unwrap());
    let round = Shape::cylinder(0.75, 0.375).unwrap().rounded(0.125).unwrap();
    for (shape, rotation, height) in [
        (&cylinder, DMat3::IDENTITY, 0.75f64),
        (&cylinder, lying, 0.375),
        (&round, DMat3::IDENTITY, 0.875),
        (&round, lying, 0.5),
        (&cone, DMat3::IDENTITY, 0.75),
        (&cone, down, 0.75),
        (&cone, lying, 0.375),
    ] {
        for (z, touching) in [(height, true), (height.next_up(), false), (height.next_down(), true)]
        {
            let there = Pose::from_matrix(rotation, DVec3::new(5.0, -7.0, z)).unwrap();
            let (a, b) =
                (PosedShape { shape: &floor, pose: &origin }, PosedShape { shape, pose: &there });
            assert_eq!(touches(a, b), touching, "{shape:?} {z:?}");
        }
    }
}

#[test]
fn a_leaning_cylinder_touches_where_its_rim_does() {
    let mut draw = Draw(7);
    let floor = Shape::half_space(DVec3::Z, 0.0).unwrap();
    for _ in 0..500 {
        let (h, r) = (draw.unit().abs(), draw.unit().abs());
        let (shape, swept) = (Shape::cylinder(h, r).unwrap(), draw.unit().abs());
        let shape = shape.rounded(swept).unwrap();
        let rotation = draw.rotation();
        let axis = DMat3::from_quat(rotation).z_axis.z.abs();
        let height = h * axis + r * (1.0 - axis * axis).sqrt() + swept;
        let at = |z: f64| {
            let pose = Pose::new(rotation, DVec3::Z * z).unwrap();
            let origin = Pose::IDENTITY;
            touches(
                PosedShape { shape: &floor, pose: &origin },
                PosedShape { shape: &shape, pose: &pose },
            )
        };
        assert!(at(height * (1.0 - 1e-14)) && !at(height * (1.0 + 1e-14)), "{h} {r} {axis}");
    }
}

#[test]
fn two_half_spaces_are_apart_only_where_they_face_away_from_each_other() {
    let below = |normal: DVec3, offset: f64| Shape::half_space(normal, offset).unwrap();
    let (floor, slope) = (below(DVec3::Z, 0.0), below(DVec3::new(0.0, 1e-9, -1.0), -1.0));
    let origin = Pose::IDENTITY;
    let judge = |a: &Shape, b: &Shape| {
        touches(PosedShape { shape: a, pose: &origin }, PosedShape { shape: b, pose: &origin })
    };
    assert!(judge(&floor, &slope) && judge(&floor, &floor));
    // −2z ≤ o is z ≥ −o/2.
    for (offset, touching) in [(0.0, true), (-1e-300, false), (1e-300, true), (-1.0, false)] {
        assert_eq!(judge(&floor, &below(DVec3::Z * -2.0, offset)), touching, "{offset}");
    }
    let round = below(DVec3::Z * -2.0, -1.0).rounded(0.5).unwrap();
    assert!(judge(&floor, &round));
    assert!(!judge(&floor, &below(DVec3::Z * -2.0, -1f64.next_up()).rounded(0.5).unwrap()));
}

#[test]
fn distance_and_depth_are_along_the_normal_and_hold_their_bounds() {
    let mut draw = Draw(8);
    for k in 0..400 {
        let polytope = hull(&mut draw, 1.0);
        let (pose_a, pose_b) = (pose(&mut draw, 1.0), pose(&mut draw, 1.0));
        // Some offsets are bisected to within rounding of a touch.
        let (mut low, mut high) = (-8.0, 8.0);
        let shape = Shape::from(polytope);
        let half_space = |offset: f64| Shape::half_space(DVec3::Z * 4.0, offset * 4.0).unwrap();
        for _ in 0..(k % 5) * 12 {
            let middle = 0.5 * (low + high);
            let a = half_space(middle);
            let (a, b) = (
                PosedShape { shape: &a, pose: &pose_a },
                PosedShape { shape: &shape, pose: &pose_b },
            );
            if touches(a, b) { high = middle } else { low = middle }
        }
        let (gap, gap_bound, normal) = {
            let a = half_space(low);
            let (a, b) = (
                PosedShape { shape: &a, pose: &pose_a },
                PosedShape { shape: &shape, pose: &pose_b },
            );
            let (DistanceResult::Apart(found), _) = distance::distance(a, b) else { panic!() };
            let (DistanceResult::Apart(back), _) = distance::distance(b, a) else { panic!() };
            assert_eq!((found.distance, found.normal), (back.distance, -back.normal));
            assert_eq!((found.point_a, found.point_b), (back.point_b, back.point_a));
            let between = found.point_b - found.point_a;
            assert!((between - found.normal * found.distance).length() < 1e-14);
            assert!(half_space::depth(a, b) == Some(Verdict::Apart));
            (found.distance, found.error_bound, found.normal)
        };
        let a = half_space(high);
        let (a, b) =
            (PosedShape { shape: &a, pose: &pose_a }, PosedShape { shape: &shape, pose: &pose_b });
        let Some(Verdict::Touching(deep)) = half_space::depth(a, b) else { panic!() };
        assert_eq!(distance::distance(a, b).0, DistanceResult::Touching);
        let solved = Depths.solve(a, b, &mut Default::default());
        assert_eq!(solved, Verdict::Touching(deep));
        let between = deep.point_a - deep.point_b;
        assert!((between - deep.normal * deep.depth).length() < 1e-13);
        assert!(normal.dot(deep.normal) > 1.0 - 1e-14);
        // The plane moved from one to the other, by their offsets, in exact or nearly exact steps;
        // the matrix scales its normal by some units of rounding.
        let moved = high - low;
        let rounding = (gap + deep.depth) * 1e-14;
        let error = (gap + deep.depth - moved).abs();
        assert!(error <= gap_bound + deep.error_bound + rounding, "{error} {moved}");
        for (value, bound) in [(gap, gap_bound), (deep.depth, deep.error_bound)] {
            assert!(bound <= 1e-12 * value, "{value} {bound}");
        }
    }
}

#[test]
fn what_is_apart_by_less_than_f64_sees_is_farther_than_nothing() {
    let mut draw = Draw(19);
    let mut hairs = 0;
    for k in 0..3000 {
        let polytope = Shape::from(hull(&mut draw, 1.0));
        let poses = [pose(&mut draw, 1.0), pose(&mut draw, 1.0)];
        let at = |offset: f64| Shape::half_space(DVec3::Z, offset).unwrap();
        let b = PosedShape { shape: &polytope, pose: &poses[1] };
        let far = at(-9.0);
        let a = PosedShape { shape: &far, pose: &poses[0] };
        let DistanceResult::Apart(found) = distance::distance(a, b).0 else { panic!("{k}") };
        // Up to the shape, but for rounding either way.
        let near = at(found.distance - 9.0);
        let a = PosedShape { shape: &near, pose: &poses[0] };
        if touches(a, b) {
            continue;
        }
        let DistanceResult::Apart(best) = distance::distance(a, b).0 else { panic!("{k}") };
        for accuracy in [Accuracy::F32, Accuracy::F64] {
            for (a, b) in [(a, b), (b, a)] {
                let DistanceResult::Apart(found) = distance::distance_at(accuracy, a, b).0 else {
                    panic!("{k}")
                };
                assert!(found.distance > 0.0, "{k}: {found:?} {best:?}");
                let off = (found.distance - best.distance).abs();
                assert!(off <= found.error_bound + best.error_bound, "{k}: {found:?} {best:?}");
            }
        }
        hairs += usize::from(best.distance < 1e-14);
    }
    assert!(hairs > 100, "{hairs}");
}
