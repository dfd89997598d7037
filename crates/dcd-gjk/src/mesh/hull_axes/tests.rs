//! The judges are the certified depth, which searches, and exact integers.

use super::*;
use crate::closed::nearest_of_triangle;
use crate::mesh::reach::tests::vector;
use crate::mesh::side::Part;
use crate::{Depths, PairSolver, PosedShape, Verdict, certified};
use dcd_geom::glam::{DMat3, DQuat};
use dcd_geom::{Pose, Shape, SupportMap};

/// From a tetrahedron to a hull of more than one row of faces, and of two of edges.
fn hull(k: usize, state: &mut u64) -> Shape {
    let count = [4, 5, 8, 15, 30, 60][k % 6];
    let stretch = [DVec3::ONE, DVec3::new(1.0, 0.3, 0.6), DVec3::new(0.1, 1.0, 0.9)][k / 6 % 3];
    let points = (0..count).map(|_| vector(state).normalize() * stretch * 0.4).collect();
    let swept = if k % 5 == 4 { 0.1 } else { 0.0 };
    Shape::hull(points).unwrap().swept(swept).unwrap()
}

/// How far a point is from a triangle, at most: of a needle, whose nearest point loses digits, from its edges too.
fn beside([p, q, r]: [DVec3; 3], on: DVec3) -> f64 {
    let off_edge = |from: DVec3, to: DVec3| {
        let along = to - from;
        let share = (on - from).dot(along) / along.length_squared();
        on.distance(from + along * share.clamp(0.0, 1.0))
    };
    let off_edges = off_edge(p, q).min(off_edge(q, r)).min(off_edge(r, p));
    on.distance(nearest_of_triangle([p, q, r], on)).min(off_edges)
}

#[test]
fn the_planes_say_what_the_exact_search_finds() {
    let (mut state, mut touching, mut apart, mut open) = (5, 0, 0, 0);
    for round in 0..6000 {
        let body = &hull(round, &mut state);
        let size = [1.0, 0.3, 3.0, 5e-2][round / 2 % 4];
        let far = if round % 5 == 0 { vector(&mut state) * 1e4 } else { DVec3::ZERO };
        let corners = [0; 3].map(|_| vector(&mut state) * size);
        let mut turn = || DQuat::from_scaled_axis(vector(&mut state) * 3.0);
        let turns = [turn(), turn()];
        // The middle of the body is near a point of the triangle.
        let on = corners[0].lerp(corners[1], 0.4).lerp(corners[2], 0.3);
        let pose = Pose::new(turns[0], far).unwrap();
        let offset = *pose.rotation() * on + vector(&mut state) * 0.4;
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
                Some(ByAxes::Touching(found)) => {
                    let Verdict::Touching(due) = due else { panic!("{round}: {found:?}") };
                    touching += 1;
                    let Some(found) = found else {
                        open += 1;
                        continue;
                    };
                    let off = (due.depth - found.depth).abs();
                    let bound = due.error_bound + found.error_bound;
                    assert!(off <= bound, "{round}: {off} {found:?} {due:?}");
                    let between = found.point_a - found.point_b - found.normal * found.depth;
                    assert!(between.length() <= slack, "{round}: {found:?}");
                    let points = match order[0] {
                        0 => [found.point_a, found.point_b],
                        _ => [found.point_b, found.point_a],
                    };
                    let normal = found.normal * sense;
                    let on = pose.rotation().transpose() * (points[0] - far - normal * swept);
                    let beside = on.distance(nearest_of_triangle(corners, on));
                    assert!(beside <= found.error_bound + slack, "{round}: {beside} {found:?}");
                    // The body's point is as far along the normal as any of it.
                    let local = body_pose.rotation().transpose() * -normal;
                    let most = local.dot(body.support(local).point) + body.radius();
                    let at = -normal.dot(points[1] - body_pose.translation());
                    assert!((most - at).abs() <= found.error_bound + slack, "{round}: {found:?}");
                }
                Some(ByAxes::Apart(axis)) => {
                    assert!(matches!(due, Verdict::Apart), "{round}: {due:?}");
                    assert!(couple.most_along(-axis) < slack, "{round}");
                    apart += 1;
                }
                // Cores that do not meet, though what is swept round them may; and what hardly does.
                None => {
                    let is_open = match due {
                        Verdict::Touching(due) => due.depth < body.radius() + swept + 1e-4,
                        _ => body.radius() + swept > 0.0,
                    };
                    open += usize::from(!is_open);
                }
            }
        }
    }
    assert!(touching > 4000 && apart > 2500 && open < 100, "{touching} {apart} {open}");
}

#[test]
fn what_is_degenerate_or_just_touches_is_never_wrong() {
    let grid = |v: DVec3| (v * 4.0).round() * 0.25;
    let (mut state, mut touching, mut apart, mut open) = (29, 0, 0, 0);
    for round in 0..6000 {
        // Points of a grid: many in one plane, and edges along those of the triangle.
        let points: Vec<DVec3> = (0..12).map(|_| grid(vector(&mut state) * 0.6)).collect();
        let body = Shape::hull(points.clone()).unwrap();
        let mut corners = [0; 3].map(|_| grid(vector(&mut state)));
        let [p, q, _] = corners;
        match round % 5 {
            0 => {}
            1 => corners[2] = p.lerp(q, 0.3) + vector(&mut state) * [1e-3, 1e-7, 1e-13][round % 3],
            // Corners and edges of the hull, and beside them by a rounding.
            2 => corners[0] = points[0],
            3 => corners = [points[0], points[1], points[2] + vector(&mut state) * 1e-14],
            _ => corners = corners.map(|corner| corner * 1e-7 + points[0]),
        }
        let far = if round % 4 == 3 { vector(&mut state) * 1e5 } else { DVec3::ZERO };
        let turn = match round % 2 {
            0 => DQuat::IDENTITY,
            _ => DQuat::from_scaled_axis(vector(&mut state) * 3.0),
        };
        let pose = Pose::new(turn, far).unwrap();
        let Ok(triangle) = Polytope::mesh_triangle(corners) else { continue };
        let triangle = Shape::from(triangle);
        let part = Part::Triangle { corners, reach: triangle.reach(), radius: 0.0 };
        let couple = Couple::of([part, Part::Shape(&body)], [&pose, &pose]).unwrap();
        let a = PosedShape { shape: &triangle, pose: &pose };
        let b = PosedShape { shape: &body, pose: &pose };
        let due = certified::overlap_of(a, b).0;
        match couple.by_axes() {
            Some(ByAxes::Touching(found)) => {
                assert_eq!(due, Verdict::Touching(()), "{round}: {found:?}");
                let Some(found) = found else { continue };
                let Verdict::Touching(due) = Depths.solve(a, b, &mut Default::default()) else {
                    panic!("{round}: {found:?}");
                };
                let off = (due.depth - found.depth).abs();
                let bound = due.error_bound + found.error_bound;
                assert!(off <= bound, "{round}: {off} {found:?} {due:?}");
                // The witnesses are of the two.
                let slack = found.error_bound + 1e-12 * (1.0 + far.length());
                let back = pose.rotation().transpose();
                let [on, at] = [found.point_a, found.point_b].map(|point| back * (point - far));
                let beside = beside(corners, on);
                assert!(beside <= slack, "{round}: {beside} {found:?}");
                for _ in 0..50 {
                    let d = vector(&mut state).normalize();
                    let past = d.dot(at - body.support(d).point);
                    assert!(past <= slack, "{round}: {past} {found:?}");
                }
                touching += 1;
            }
            Some(ByAxes::Apart(_)) => {
                assert_eq!(due, Verdict::Apart, "{round}");
                apart += 1;
            }
            None => open += 1,
        }
    }
    assert!(touching > 1500 && apart > 300 && open > 500, "{touching} {apart} {open}");
}

#[test]
fn a_plane_that_f32_takes_for_another_is_in_the_bound() {
    let (mut state, mut found) = (3, 0);
    for round in 0..500 {
        // Eight faces about as far from the middle, where a tiny triangle is.
        let mut end = |d: DVec3| d * (1.0 + 1e-8 * vector(&mut state).x);
        let axes = [DVec3::X, DVec3::Y, DVec3::Z];
        let body = Shape::hull(axes.into_iter().flat_map(|d| [end(d), end(-d)]).collect()).unwrap();
        let corners = [0; 3].map(|_| vector(&mut state) * 4e-6);
        let turn = DQuat::from_scaled_axis(vector(&mut state) * 3.0);
        let poses = [Pose::IDENTITY, Pose::new(turn, DVec3::ZERO).unwrap()];
        let triangle = Shape::from(Polytope::mesh_triangle(corners).unwrap());
        let part = Part::Triangle { corners, reach: triangle.reach(), radius: 0.0 };
        let couple = Couple::of([part, Part::Shape(&body)], poses.each_ref()).unwrap();
        let Some(ByAxes::Touching(Some(depth))) = couple.by_axes() else { continue };
        let [a, b] = [(&triangle, &poses[0]), (&body, &poses[1])]
            .map(|(shape, pose)| PosedShape { shape, pose });
        let Verdict::Touching(due) = Depths.solve(a, b, &mut Default::default()) else {
            panic!("{round}")
        };
        let off = (due.depth - depth.depth).abs();
        assert!(off <= due.error_bound + depth.error_bound, "{round}: {off} {depth:?} {due:?}");
        found += 1;
    }
    assert!(found > 300, "{found}");
}

#[test]
fn no_direction_parts_them_sooner_and_every_path_has_the_same_planes() {
    let (mut state, mut inside) = (41, 0);
    for round in 0..600 {
        let Shape::Polytope(body) = hull(round, &mut state) else { panic!() };
        let Some(rows) = body.feature_rows() else { continue };
        let corners = [0; 3].map(|_| vector(&mut state) * 0.5);
        let centre = body.inner().centre;
        let pose = Pose::IDENTITY;
        let shape = Shape::from(Polytope::clone(&body));
        let part = Part::Triangle { corners, reach: 1.0, radius: 0.0 };
        let couple = Couple::of([part, Part::Shape(&shape)], [&pose, &pose]).unwrap();
        let Some(placed) = couple.in_hull((&corners, 0), &body) else { continue };
        let [p, q, r] = placed.corners;
        let search = || HullAxes {
            rows,
            corner: p.as_vec3(),
            edges: [(q - p).as_vec3(), (r - p).as_vec3()],
            longest: placed.longest,
            size: placed.size,
        };
        let found = Path::ALL.map(|path| format!("{:?}", dispatch_on(path, Unfused(search()))));
        assert!(found.iter().all(|other| *other == found[0]), "{round}: {found:?}");
        let least = placed.least().unwrap();
        assert!(least.at_least <= least.reach + 1e-12, "{round}");
        if least.at_least <= 0.0 {
            continue;
        }
        inside += 1;
        let reach = |d: DVec3| {
            let most = body.vertices().iter().map(|v| d.dot(*v - centre)).fold(f64::MIN, f64::max);
            most - placed.corners.iter().map(|c| d.dot(*c)).fold(f64::MAX, f64::min)
        };
        let edges = [q - p, r - q, p - r];
        for k in 0..400 {
            let v = body.vertices();
            let edge = v[k % v.len()] - v[(k * 7 + 1) % v.len()];
            let d = match k % 2 {
                0 => vector(&mut state),
                _ => edge.cross(edges[k % 3]),
            };
            let Some(d) = d.try_normalize() else { continue };
            for d in [d, -d] {
                assert!(
                    least.at_least <= reach(d) + 1e-12,
                    "{round}: {} {}",
                    least.at_least,
                    reach(d)
                );
            }
        }
    }
    assert!(inside > 200, "{inside}");
}

#[test]
fn normals_are_of_unit_length_where_poses_are_hardly_rotations() {
    let (mut state, mut deep) = (9, [0; 2]);
    for round in 0..400 {
        let core = match round % 2 {
            0 => hull(round, &mut state),
            _ => Shape::cuboid(vector(&mut state).abs() * 0.4 + 0.1).unwrap(),
        };
        let body = core.swept(1e3).unwrap();
        let corners = [0; 3].map(|_| vector(&mut state) * 0.5);
        let poses = [0; 2].map(|_| {
            let turn = DMat3::from_quat(DQuat::from_scaled_axis(vector(&mut state) * 3.0));
            let off = [0; 3].map(|_| vector(&mut state) * 3e-8);
            let leaning = turn + DMat3::from_cols(off[0], off[1], off[2]);
            Pose::from_matrix(leaning, vector(&mut state) * 0.1).unwrap()
        });
        let parts = [Part::Triangle { corners, reach: 1.0, radius: 0.0 }, Part::Shape(&body)];
        let couple = Couple::of(parts, [&poses[0], &poses[1]]).unwrap();
        let Some(ByAxes::Touching(Some(found))) = couple.by_axes() else { continue };
        deep[round % 2] += 1;
        let off = (found.normal.length() - 1.0).abs();
        assert!(off <= 4.0 * f64::EPSILON, "{round}: {off} {found:?}");
    }
    assert!(deep.iter().all(|&count| count > 50), "{deep:?}");
}
