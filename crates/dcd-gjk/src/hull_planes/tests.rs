//! The judges are the certified depth, which searches, and the reach along many directions.

use super::lanes::{Way, others};
use super::*;
use crate::motion::tests::Draw;
use crate::{Depths, PairSolver, PosedShape, Verdict};
use dcd_geom::glam::DQuat;
use dcd_geom::{Pose, Shape, SupportMap};

/// From a tetrahedron to a hull of more than one row of faces, and of two of edges.
fn hull(draw: &mut Draw, k: usize) -> Shape {
    let count = [4, 5, 8, 15, 30, 60][k % 6];
    let stretch = [DVec3::ONE, DVec3::new(1.0, 0.3, 0.6), DVec3::new(0.1, 1.0, 0.9)][k / 6 % 3];
    let points = (0..count).map(|_| draw.vector().normalize() * stretch * 0.4).collect();
    Shape::hull(points).unwrap().swept([0.0, 0.1][usize::from(k % 5 == 4)]).unwrap()
}

/// Capsules and cuboids, thin ones among them.
fn body(draw: &mut Draw, k: usize) -> Shape {
    let half = draw.vector().abs() * [0.4, 1.5, 0.05][k / 2 % 3] + 0.01;
    match k % 4 {
        0 => Shape::capsule(half.x, 0.1 * half.y).unwrap(),
        1 => Shape::cuboid(half * DVec3::new(1.0, 1.0, 0.05)).unwrap(),
        2 => Shape::cuboid(half).unwrap(),
        _ => Shape::cuboid(half).unwrap().swept(0.05).unwrap(),
    }
}

/// That a depth from a to b is what the certified search finds, and its witnesses are the deepest points.
fn check(found: &Depth, sides: [PosedShape<'_>; 2], slack: f64, what: usize) {
    let [a, b] = sides;
    let Verdict::Touching(due) = Depths.solve(a, b, &mut Default::default()) else {
        panic!("{what}: {found:?}")
    };
    let off = (due.depth - found.depth).abs();
    assert!(off <= due.error_bound + found.error_bound, "{what}: {off} {found:?} {due:?}");
    let between = found.point_a - found.point_b - found.normal * found.depth;
    assert!(between.length() <= slack, "{what}: {found:?}");
    for (side, point, normal) in
        [(a, found.point_a, found.normal), (b, found.point_b, -found.normal)]
    {
        let local = side.pose.rotation().transpose() * normal;
        let map = side.shape.as_polytope().unwrap();
        let most = local.dot(SupportMap::<f64>::support(map, local).point) + map.swept_radius();
        let at = normal.dot(point - side.pose.translation());
        assert!((most - at).abs() <= found.error_bound + slack, "{what}: {found:?}");
        // No direction has the point outside.
        let point = side.pose.rotation().transpose() * (point - side.pose.translation());
        let mut draw = Draw(what as u64 + 1);
        for _ in 0..20 {
            let d = draw.vector().normalize();
            let most = d.dot(SupportMap::<f64>::support(map, d).point) + map.swept_radius();
            assert!(d.dot(point) - most <= found.error_bound + slack, "{what}: {found:?}");
        }
    }
}

/// Whether the cores overlap clearly, as the planes should know.
fn do_cores_overlap(sides: [PosedShape<'_>; 2]) -> bool {
    let radius = |side: PosedShape<'_>| side.shape.as_polytope().unwrap().swept_radius();
    let radii = sides.map(radius).iter().sum::<f64>();
    let due = Depths.solve(sides[0], sides[1], &mut Default::default());
    matches!(due, Verdict::Touching(due) if due.depth > radii + 1e-4)
}

fn depth_of([a, b]: [PosedShape<'_>; 2]) -> Option<Depth> {
    let [in_a, in_b] = [a, b].map(|side| side.shape.as_polytope().unwrap());
    depth([PosedSupport::polytope(in_a, a.pose), PosedSupport::polytope(in_b, b.pose)])
}

#[test]
fn the_planes_say_what_the_certified_search_finds() {
    let (mut draw, mut deep, mut open) = (Draw(11), [0; 4], 0);
    for k in 0..4000 {
        let shapes = [hull(&mut draw, k), body(&mut draw, k)];
        let far = if k % 5 == 0 { draw.vector() * 1e4 } else { DVec3::ZERO };
        let poses = [0, 1].map(|_| {
            let turn = DQuat::from_scaled_axis(draw.vector() * 3.0);
            Pose::new(turn, far + draw.vector() * 0.2).unwrap()
        });
        let [a, b] = [0, 1].map(|k| PosedShape { shape: &shapes[k], pose: &poses[k] });
        let found = depth_of([a, b]);
        assert_eq!(found, depth_of([b, a]).map(Depth::mirrored), "{k}");
        match found {
            Some(found) => {
                check(&found, [a, b], 1e-12 * (1.0 + far.length()), k);
                deep[k % 4] += 1;
            }
            None => open += usize::from(do_cores_overlap([a, b])),
        }
    }
    assert!(deep.iter().all(|&count| count > 300) && open < 20, "{deep:?} {open}");
}

#[test]
fn what_is_degenerate_or_just_touches_is_never_wrong() {
    let (mut draw, mut deep, mut open) = (Draw(12), 0, 0);
    for k in 0..4000 {
        let grid = |v: DVec3| (v * 4.0).round() * 0.25;
        // Points of a grid: many in one plane, and edges along those of the cuboid.
        let points: Vec<DVec3> = (0..12).map(|_| grid(draw.vector() * 0.6)).collect();
        let half = grid(draw.vector().abs()) + 0.25;
        let other = match k % 3 {
            0 => Shape::capsule(half.x, 0.25),
            _ => Shape::cuboid(half * [1.0, 1e-7, 1e-3][k / 3 % 3]),
        };
        let shapes = [Shape::hull(points), other].map(Result::unwrap);
        let far = if k % 4 == 3 { draw.vector() * 1e5 } else { DVec3::ZERO };
        let turn = DQuat::from_scaled_axis(draw.vector() * [0.0, 3.0][k % 2]);
        let tilt = DQuat::from_scaled_axis(draw.vector() * [0.0, 0.0, 1e-9, 1e-16][k % 4]);
        let poses = [
            Pose::new(turn, far).unwrap(),
            Pose::new(turn * tilt, far + turn * grid(draw.vector())).unwrap(),
        ];
        let [a, b] = [0, 1].map(|k| PosedShape { shape: &shapes[k], pose: &poses[k] });
        match depth_of([a, b]) {
            Some(found) => {
                check(&found, [a, b], 1e-12 * (1.0 + far.length()), k);
                deep += 1;
            }
            None => open += usize::from(do_cores_overlap([a, b])),
        }
    }
    assert!(deep > 700 && open < 200, "{deep} {open}");
}

/// A rotation, but for 1e-10.
fn leaning(draw: &mut Draw) -> DMat3 {
    let turn = DMat3::from_quat(DQuat::from_scaled_axis(draw.vector() * 3.0));
    turn + DMat3::from_cols(draw.vector(), draw.vector(), draw.vector()) * 3e-11
}

#[test]
fn normals_are_of_unit_length_where_poses_are_hardly_rotations() {
    let (mut draw, mut deep) = (Draw(15), 0);
    for k in 0..400 {
        let shapes = [hull(&mut draw, k).swept(1e3).unwrap(), body(&mut draw, k)];
        let poses =
            [0; 2].map(|_| Pose::from_matrix(leaning(&mut draw), draw.vector() * 0.2).unwrap());
        let [a, b] = [0, 1].map(|k| PosedShape { shape: &shapes[k], pose: &poses[k] });
        let Some(found) = depth_of([a, b]) else { continue };
        deep += 1;
        let off = (found.normal.length() - 1.0).abs();
        assert!(off <= 4.0 * f64::EPSILON, "{k}: {off} {found:?}");
        // So the hull's witness is as far from its core as is swept round that.
        let core = found.point_a - found.normal * 1e3;
        let off = (found.point_a.distance(core) - 1e3).abs();
        assert!(off <= found.error_bound, "{k}: {off} {found:?}");
    }
    assert!(deep > 100, "{deep}");
}

#[test]
fn short_edges_lead_from_vertex_to_vertex() {
    let (mut draw, mut short) = (Draw(16), 0);
    for _ in 0..100 {
        let mut points: Vec<DVec3> = (0..8).map(|_| draw.vector()).collect();
        points.push(points[0] + draw.vector() * 1e-3);
        let hull = Polytope::hull(points).unwrap();
        let Some(features) = HullFeatures::of(&hull) else { continue };
        for edge in 0.. {
            let Some([_, along]) = features.edge(edge) else { break };
            let [from, to] = features.rows.edge_vertices(edge).unwrap();
            let [from, to] = [from, to].map(|end| hull.vertices()[end as usize]);
            assert_eq!(along, to - from);
            short += usize::from(along.length() < 2e-3);
        }
    }
    assert!(short > 30, "{short}");
}

#[test]
fn no_direction_parts_them_sooner_and_every_path_has_the_same_planes() {
    let (mut draw, mut inside) = (Draw(13), 0);
    for k in 0..800 {
        let shapes = [hull(&mut draw, k), body(&mut draw, k)];
        let turn = DQuat::from_scaled_axis(draw.vector() * 3.0);
        let poses = [Pose::IDENTITY, Pose::new(turn, draw.vector() * 0.2).unwrap()];
        let [a, b] = [0, 1].map(|k| PosedShape { shape: &shapes[k], pose: &poses[k] });
        let [in_a, in_b] = [a, b].map(|side| side.shape.as_polytope().unwrap());
        let [in_a, in_b] =
            [PosedSupport::polytope(in_a, a.pose), PosedSupport::polytope(in_b, b.pose)];
        let Some(placed) = Placed::of(in_a, in_b) else { continue };
        let centre = placed.centre.as_vec3();
        let axes = placed.axes.map(|axis| axis.as_vec3());
        let found = Path::ALL.map(|path| {
            let mut planes = Planes::default();
            let search = CuboidPlanes::<3> {
                rows: placed.hull.rows,
                centre,
                axes,
                half: placed.half.map(|half| half as f32),
                size: placed.size,
                planes: &mut planes,
            };
            dispatch_on(path, Unfused(search));
            format!("{planes:?}")
        });
        assert!(found.iter().all(|other| *other == found[0]), "{k}");
        let Some(least) = placed.least() else { continue };
        assert!(least.at_least <= placed.reach(least.outward) + 1e-12, "{k}");
        if least.at_least <= 0.0 {
            continue;
        }
        inside += 1;
        for j in 0..400 {
            let along =
                placed.hull.edge(j % placed.hull.hull.vertices().len()).unwrap_or_default()[1];
            let d = match j % 2 {
                0 => draw.vector(),
                _ => along.cross(placed.axes[j % 3]),
            };
            let Some(d) = d.try_normalize() else { continue };
            for d in [d, -d] {
                assert!(least.at_least <= placed.reach(d) + 1e-12, "{k}: {d}");
            }
        }
    }
    assert!(inside > 300, "{inside}");
}

#[test]
fn a_way_takes_the_edges_that_lie_on_its_sides() {
    let mut draw = Draw(14);
    for k in 0..1000 {
        let mut sets = [0u16; 9];
        sets.iter_mut().for_each(|set| *set = (draw.vector().x.abs() * 60000.0) as u16);
        let [a, b, c, d, e, f, g, h, i] = sets;
        let way = Way { left: [a, b, c], right: [d, e, f], before: [g, h, i] };
        for ((axis, due), (lanes, back)) in EDGES.into_iter().zip(way.taken()) {
            for lane in 0..16 {
                let is_above = way.sides(axis, lane);
                let [is_taken, is_back] = [lanes, back].map(|set| set >> lane & 1 != 0);
                let is_open = way.open(axis) >> lane & 1 != 0;
                let is_due = is_open && others(axis).iter().all(|&k| is_above[k] == due[k]);
                assert_eq!(is_taken, is_due, "{k}: {axis} {lane}");
                assert_eq!(is_back, !is_above[axis], "{k}: {axis} {lane}");
            }
        }
    }
}

#[test]
fn a_way_round_one_side_encloses_that_side_alone() {
    // The corners of each side, counter-clockwise seen from outside.
    for side in 0..6 {
        let [axis, is_below] = [side / 2, side % 2];
        let [j, k] = others(axis);
        let mut corners = [[false, false], [true, false], [true, true], [false, true]];
        if is_below == 1 {
            corners.reverse();
        }
        let mut times = [0; 5];
        for at in 0..4 {
            let [from, to] = [corners[at], corners[(at + 1) % 4]].map(|[above_j, above_k]| {
                let mut is_above = [is_below == 0; 3];
                (is_above[j], is_above[k]) = (above_j, above_k);
                is_above
            });
            let along = (0..3).find(|&k| from[k] != to[k]).unwrap();
            for (times, (edge, is_above)) in times.iter_mut().zip(EDGES) {
                if edge == along && others(edge).iter().all(|&k| is_above[k] == from[k]) {
                    *times += if to[along] { 1 } else { -1 };
                }
            }
        }
        let mut due = [0; 6];
        due[side] = 1;
        assert_eq!(enclosed(times), due, "{side}: {times:?}");
    }
}
