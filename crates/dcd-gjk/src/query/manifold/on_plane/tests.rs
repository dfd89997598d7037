//! The general way is the other method: it clips what both show, in the world.

use super::super::corners::Corners;
use super::super::cuboid_faces::tests::Draw;
use super::super::write_by_corners;
use super::*;
use crate::closed::level::gap_and_lowest;
use crate::query::{Accuracy, depths};
use dcd_geom::glam::DQuat;
use dcd_geom::{Curved, Pose};

/// Far above what rounding does to lengths of about a metre.
const SAME_PLACE: f64 = 1e-9;

fn draw(fixed: u64) -> Draw {
    Draw(std::env::var("DCD_SEED").map_or(fixed, |seed| seed.parse().expect("a seed")))
}

fn vector(draw: &mut Draw) -> DVec3 {
    DVec3::new(draw.unit(), draw.unit(), draw.unit()) * 2.0 - 1.0
}

fn shape(draw: &mut Draw, k: usize) -> Shape {
    let shape = match k % 5 {
        0 => Shape::cuboid(DVec3::new(0.5, 0.3, 0.2) * (0.5 + draw.unit())),
        1 => Shape::capsule(0.2 + draw.unit(), 0.1 + 0.2 * draw.unit()),
        2 => Shape::cylinder(0.2 + draw.unit(), 0.2 + 0.3 * draw.unit()),
        3 => Shape::cone(0.3 + draw.unit(), 0.2 + 0.3 * draw.unit()),
        _ => Shape::hull((0..12).map(|_| vector(draw) * 0.7).collect()),
    };
    shape.unwrap()
}

/// Whether a point is on a disc's rim, the other on the plane z = 0 over it, and both as far apart as stated.
fn is_of_rim(curved: &Curved, body: PosedShape<'_>, point: &ManifoldPoint, swapped: bool) -> bool {
    let (of_body, of_plane) = match swapped {
        true => (point.point_b, point.point_a),
        false => (point.point_a, point.point_b),
    };
    let local = body.pose.rotation().transpose() * (of_body - body.pose.translation());
    let on_rim = curved.discs().iter().any(|(z, radius)| {
        (local.z - z).abs() < SAME_PLACE && (local.truncate().length() - radius).abs() < SAME_PLACE
    });
    let below = of_plane - of_body;
    on_rim && of_plane.z.abs() < SAME_PLACE && below.distance(DVec3::Z * point.depth) < SAME_PLACE
}

#[test]
fn what_rests_on_a_plane_does_so_where_the_general_way_has_it() {
    let mut draw = draw(61);
    let (mut several, mut compared, mut of_vertex) = (0, 0, 0);
    for round in 0..20_000 {
        let shape = shape(&mut draw, round);
        // Half of them nearly upright, so that faces and lines rest.
        let tilt = vector(&mut draw) * if round % 2 == 0 { 0.02 } else { 3.0 };
        let turn = DQuat::from_scaled_axis(tilt);
        let height = 0.5 * draw.unit() - 0.3;
        let pose = Pose::new(turn, DVec3::new(0.3, -0.2, height)).unwrap();
        let plane = Shape::half_space(DVec3::Z, 0.0).unwrap();
        let (body, ground) = (
            PosedShape { shape: &shape, pose: &pose },
            PosedShape { shape: &plane, pose: &Pose::IDENTITY },
        );
        let sides = if round % 3 == 0 { [ground, body] } else { [body, ground] };
        let Some(depth) = depths::by_frame(Accuracy::F32, sides[0], sides[1]) else { continue };
        let [mut found, mut due] = [Manifold::default(); 2];
        if !write(&depth, sides, &mut found) {
            continue;
        }
        let (_, lowest) = gap_and_lowest(Accuracy::F32, sides[0], sides[1]).unwrap();
        let known = Resting::seen(&depth, sides, lowest, |resting| resting.part.name());
        let searched = Resting::seen(&depth, sides, None, |resting| resting.part.name());
        assert_eq!(known, searched, "round {round}");
        of_vertex += usize::from(lowest.is_some());
        write_by_corners(&depth.into(), sides, &mut Corners::default(), &mut due);
        assert_eq!(
            (found.normal, found.points.len()),
            (due.normal, due.points.len()),
            "round {round}"
        );
        let is_same = |p: &ManifoldPoint, q: &ManifoldPoint| {
            p.point_a.distance(q.point_a) < SAME_PLACE
                && p.point_b.distance(q.point_b) < SAME_PLACE
                && (p.depth - q.depth).abs() < SAME_PLACE
                && p.features == q.features
        };
        assert!(is_same(&found.points[0], &due.points[0]), "round {round}: {found:?}, {due:?}");
        for point in found.points() {
            let is_there = due.points().iter().any(|other| is_same(point, other));
            // Of the eight corners that stand for a rim several sets of four span as much, but for rounding.
            let is_of_rim = matches!(&shape, Shape::Curved(curved) if due.points.len() == 4
                && is_of_rim(curved, body, point, round % 3 == 0));
            assert!(is_there || is_of_rim, "round {round}: {found:?}, {due:?}");
        }
        // The general way counts faces that are bent where it sees a vertex alone.
        let same = SAME_PLACE + unevenness([&shape, &plane]);
        assert!((found.error_bound - due.error_bound).abs() < same, "round {round}");
        several += usize::from(due.points.len() > 1);
        compared += 1;
    }
    assert!(compared > 5_000 && several > 1_000, "{compared}, {several} of several points");
    assert!(of_vertex > 1_000, "{of_vertex} with a known vertex");
}

#[test]
fn few_corners_are_the_points_that_are_chosen_of_any_number() {
    let mut draw = draw(62);
    // By how many corners are shown, and how many points there are.
    let (mut counts, mut left) = ([[0; 4]; 4], 0);
    for round in 0..30_000 {
        let thin = [1.0, 1.0, 1e-3, 1e-9, 1e-10, 0.0][round / 5 % 6];
        let corner = |draw: &mut Draw| vector(draw) * DVec3::new(1.0, thin, 1.0);
        let shape = match round % 5 {
            0 => Shape::triangle([(); 3].map(|()| corner(&mut draw))),
            1 => Shape::capsule(0.2 + draw.unit(), 0.1 + 0.2 * draw.unit()),
            2 => Shape::capsule([0.5, 1e-9, 1e-10][round / 5 % 3], 0.1 + 0.2 * draw.unit()),
            3 => Shape::cylinder(0.2 + draw.unit(), 0.2 + 0.3 * draw.unit()),
            _ => Shape::hull((0..12).map(|_| corner(&mut draw)).collect()),
        };
        let Ok(shape) = shape else { continue };
        let rounded = if round % 7 == 0 { shape.clone().rounded(0.1) } else { Ok(shape.clone()) };
        let shape = rounded.unwrap_or(shape);
        let tilt = vector(&mut draw) * if round % 2 == 0 { 0.1 } else { 3.0 };
        let pose = Pose::new(
            DQuat::from_scaled_axis(tilt),
            DVec3::new(0.3, -0.2, 0.5 * draw.unit() - 0.3),
        )
        .unwrap();
        let plane = Shape::half_space(DVec3::Z, 0.0).unwrap();
        let body = PosedShape { shape: &shape, pose: &pose };
        let ground = PosedShape { shape: &plane, pose: &Pose::IDENTITY };
        let sides = if round % 3 == 0 { [ground, body] } else { [body, ground] };
        let Some(depth) = depths::by_frame(Accuracy::F32, sides[0], sides[1]) else { continue };
        Resting::seen(&depth, sides, None, |resting| {
            let [mut found, mut due] = [Manifold::default(); 2];
            let is_written = match *resting.corners() {
                [p, q] => resting.write_edge([p, q], &depth, &mut found),
                [p, q, r] => resting.write_triangle([p, q, r], &depth, &mut found),
                _ => return,
            };
            if !is_written {
                assert_eq!(found.points.len(), 0, "round {round}");
                left += 1;
                return;
            }
            resting.write_chosen(&depth, &mut due);
            assert_eq!(found.points(), due.points(), "round {round}");
            assert_eq!((found.normal, found.error_bound), (due.normal, due.error_bound));
            counts[resting.corners().len()][found.points().len()] += 1;
        });
    }
    let [_, _, [_, of_edge @ .., _], [_, of_triangle @ ..]] = counts;
    assert!(of_edge.iter().all(|&count| count > 200), "{counts:?}");
    assert!(of_triangle.iter().all(|&count| count > 5), "{counts:?}");
    assert!(left > 20, "{left}");
}
