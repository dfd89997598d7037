//! The general way is the other method: it clips what both show, in the world.

use super::super::corners::Corners;
use super::super::cuboids::tests::Draw;
use super::super::write;
use super::*;
use crate::query::{Accuracy, depths};
use dcd_geom::Pose;
use dcd_geom::glam::DQuat;

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

#[test]
fn what_rests_on_a_plane_does_so_where_the_general_way_has_it() {
    let mut draw = draw(61);
    let (mut several, mut compared) = (0, 0);
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
        let Some(resting) = Resting::of(&depth, sides) else { continue };
        let Verdict::Touching(found) = resting.manifold(&depth) else { panic!("round {round}") };
        let mut due = Manifold::default();
        write(&depth, sides[0], sides[1], &mut Corners::default(), &mut due);
        let [found] = &*found else { panic!("round {round}: {} manifolds", found.len()) };
        assert_eq!((found.normal, found.count), (due.normal, due.count), "round {round}");
        for point in due.points() {
            let is_same = |other: &&ManifoldPoint| {
                other.point_a.distance(point.point_a) < SAME_PLACE
                    && other.point_b.distance(point.point_b) < SAME_PLACE
                    && (other.depth - point.depth).abs() < SAME_PLACE
                    && other.features == point.features
            };
            assert!(
                found.points().iter().any(|p| is_same(&p)),
                "round {round}: {found:?}, {due:?}"
            );
        }
        assert!((found.error_bound - due.error_bound).abs() < SAME_PLACE, "round {round}");
        several += usize::from(due.count > 1);
        compared += 1;
    }
    assert!(compared > 5_000 && several > 1_000, "{compared}, {several} of several points");
}
