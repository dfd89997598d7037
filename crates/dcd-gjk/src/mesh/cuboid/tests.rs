use super::*;
use crate::mesh::reach::tests::vector;
use crate::{Depths, PairSolver, PosedShape, Verdict, certified};
use dcd_geom::Polytope;
use dcd_geom::glam::DQuat;

#[test]
fn the_axes_say_what_the_exact_search_finds() {
    let sharp = Shape::cuboid(DVec3::new(0.3, 0.2, 0.4)).unwrap();
    let bodies = [sharp.clone(), sharp.swept(0.1).unwrap()];
    let (mut state, mut touching, mut apart, mut parallel) = (5, 0, 0, 0);
    for round in 0..6000 {
        let body = &bodies[round % 2];
        let size = [1.0, 0.3, 3.0, 1e-2][round / 2 % 4];
        let far = if round % 5 == 0 { vector(&mut state) * 1e4 } else { DVec3::ZERO };
        // A third lie flat, with edges along those of the cuboid, or almost.
        let is_flat = round % 3 == 0;
        let mut corners = [0; 3].map(|_| vector(&mut state) * size);
        let mut turn = || DQuat::from_scaled_axis(vector(&mut state) * 3.0);
        let (mut turns, mut offset) = ([turn(), turn()], vector(&mut state) * 0.5);
        if is_flat {
            corners = [DVec3::ZERO, DVec3::X * size, DVec3::Y * size];
            let lean = [0.0, 1e-15, 1e-11, 1e-7][round / 24 % 4];
            turns[1] = turns[0] * DQuat::from_scaled_axis(vector(&mut state) * lean);
            offset = turns[0] * DVec3::new(offset.x, offset.y, 0.4 + 0.1 * offset.z);
        }
        let pose = Pose::new(turns[0], far).unwrap();
        let body_pose = Pose::new(turns[1], far + offset).unwrap();
        let swept = if round % 7 == 0 { 0.05 } else { 0.0 };
        let triangle =
            Shape::from(Polytope::mesh_triangle(corners).unwrap().rounded(swept).unwrap());
        let part = Part::Triangle { corners, reach: 4.0 * size, radius: swept };
        let parts = [part, Part::Shape(body)];
        let poses = [&pose, &body_pose];
        let (a, b) = (
            PosedShape { shape: &triangle, pose: &pose },
            PosedShape { shape: body, pose: &body_pose },
        );
        let due = Depths.solve(a, b, &mut Default::default());
        let slack = 1e-12 * (1.0 + far.length());
        for order in [[0, 1], [1, 0]] {
            let sense = if order[0] == 0 { 1.0 } else { -1.0 };
            let couple = Couple::of(order.map(|k| parts[k]), order.map(|k| poses[k])).unwrap();
            match couple.by_axes() {
                Some(ByAxes::Touching(Some(found))) => {
                    let Verdict::Touching(due) = due else { panic!("{round}: {found:?}") };
                    let off = (due.depth - found.depth).abs();
                    let bound = due.error_bound + found.error_bound;
                    assert!(off <= bound, "{round}: {off} {found:?} {due:?}");
                    let between = found.point_a - found.point_b - found.normal * found.depth;
                    assert!(between.length() <= slack, "{round}: {found:?}");
                    let points = if order[0] == 0 {
                        [found.point_a, found.point_b]
                    } else {
                        [found.point_b, found.point_a]
                    };
                    // What moves the triangle out leaves its point on the cuboid, and the other way round.
                    let on = pose.rotation().transpose()
                        * (points[0] - far - found.normal * sense * swept);
                    let beside = on.distance(nearest_of_triangle(corners, on));
                    assert!(beside <= found.error_bound + slack, "{round}: {beside} {found:?}");
                    // Nothing else is lost, but of edges that are nearly parallel.
                    let is_tight = found.error_bound <= beside + 1e-9 + slack;
                    assert!(is_tight || is_flat, "{round}: {beside} {found:?}");
                    touching += 1;
                    parallel += usize::from(is_flat && found.error_bound <= 1e-9);
                }
                Some(ByAxes::Apart(axis)) => {
                    assert!(matches!(due, Verdict::Apart), "{round}: {due:?}");
                    let reach = couple.most_along(-axis);
                    assert!(reach < slack, "{round}: {reach}");
                    apart += 1;
                }
                _ => {}
            }
        }
    }
    assert!(touching > 2500 && apart > 1500 && parallel > 300, "{touching} {apart} {parallel}");
}

/// A triangle and the pose of a cuboid of that size, hard to tell from one that just touches.
fn hard(round: usize, half: DVec3, state: &mut u64) -> ([DVec3; 3], [Pose; 2]) {
    let grid = |v: DVec3| (v * 8.0).round() * 0.125;
    let mut corners = [0; 3].map(|_| vector(state));
    let [p, q, _] = corners;
    let far = if round % 4 == 3 { vector(state) * 1e5 } else { DVec3::ZERO };
    let turn = DQuat::from_scaled_axis(vector(state) * 3.0);
    let mut pose = Pose::new(turn, far).unwrap();
    let mut body = Pose::new(turn, far).unwrap();
    match round % 6 {
        // Corners, edges and sides that coincide with those of the cuboid.
        0 => {
            (pose, body) = (Pose::IDENTITY, Pose::from_translation(grid(vector(state))).unwrap());
            corners = corners.map(grid);
        }
        // In the plane of a side, and a rounding beside it.
        1 => {
            let lean = [0.0, 1e-16, -1e-16, 1e-14][round / 6 % 4];
            corners = corners.map(|c| DVec3::new(c.x, c.y, half.z + lean * c.x));
        }
        // Needles.
        2 => {
            corners[2] = p.lerp(q, 0.3) + vector(state) * [1e-5, 1e-9, 1e-13, 1e-17][round / 6 % 4]
        }
        // Along a direction of the cuboid, almost.
        3 => {
            let lean = [0.0, 1e-8, 1e-9, 1e-10][round / 6 % 4];
            corners[1] = p + DVec3::new(lean * p.x, lean * p.y, 1.0) * q.z;
        }
        // Without area: a segment or a point.
        4 => corners = [p, q, [p, q, p.midpoint(q), p][round / 6 % 4]],
        // Tiny, with a corner at a corner of the cuboid.
        _ => {
            let size = [1e-6, 1e-30, 1e-59, 1e-81][round / 6 % 4];
            corners = corners.map(|c| half + c * size);
        }
    }
    (corners, [pose, body])
}

#[test]
fn what_is_degenerate_or_just_touches_is_never_wrong() {
    let half = DVec3::new(0.375, 0.25, 0.5);
    let sharp = Shape::cuboid(half).unwrap();
    let bodies = [sharp.clone(), sharp.swept(0.125).unwrap()];
    let (mut state, mut touching, mut apart, mut open) = (23, [0; 6], 0, 0);
    for round in 0..6000 {
        let body = &bodies[round / 24 % 2];
        let (corners, poses) = hard(round, half, &mut state);
        let triangle = Shape::from(Polytope::mesh_triangle(corners).unwrap());
        let part = Part::Triangle { corners, reach: triangle.reach(), radius: 0.0 };
        let couple = Couple::of([part, Part::Shape(body)], poses.each_ref()).unwrap();
        let a = PosedShape { shape: &triangle, pose: &poses[0] };
        let b = PosedShape { shape: body, pose: &poses[1] };
        // In exact integers where f64 does not know.
        let due = certified::overlap_of(a, b).0;
        match couple.by_axes() {
            Some(ByAxes::Touching(Some(found))) => {
                assert_eq!(due, Verdict::Touching(()), "{round}: {found:?}");
                let Verdict::Touching(due) = Depths.solve(a, b, &mut Default::default()) else {
                    panic!("{round}: {found:?}");
                };
                let bound = due.error_bound + found.error_bound;
                let off = (due.depth - found.depth).abs();
                assert!(off <= bound, "{round}: {off} {found:?} {due:?}");
                // No direction parts them sooner.
                for _ in 0..50 {
                    let most = couple.most_along(vector(&mut state));
                    assert!(found.depth - found.error_bound <= most, "{round}: {found:?} {most}");
                }
                touching[round % 6] += 1;
            }
            Some(ByAxes::Apart(_)) => {
                assert_eq!(due, Verdict::Apart, "{round}");
                apart += 1;
            }
            _ => open += 1,
        }
    }
    let is_tried = touching.iter().filter(|&&count| count > 100).count() >= 4;
    assert!(is_tried && apart > 300 && open > 500, "{touching:?} {apart} {open}");
}
