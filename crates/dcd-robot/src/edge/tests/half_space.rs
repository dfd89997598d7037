//! Edges above a ground without an end.

use super::*;

/// The ground below a plane through a point, which a turn tilts.
fn ground(through: DVec3, turn: DQuat) -> Obstacle {
    // In its own frame the plane is neither through the origin nor square to an axis.
    let normal = DVec3::new(0.0, 3.0, 4.0);
    let shape = Shape::half_space(normal, 10.0).unwrap();
    let upright = DQuat::from_rotation_arc(normal / 5.0, DVec3::Z);
    let turn = (turn * upright).normalize();
    let pose = Pose::new(turn, through - turn * (normal / 5.0) * 2.0).unwrap();
    Obstacle { name: "ground".to_owned(), shape, pose }
}

#[test]
fn a_link_that_slides_along_the_ground_at_a_micrometre_is_proved_free() {
    for gap in [1e-3, 1e-6, 1e-8] {
        let ground = ground(DVec3::new(3.0, -7.0, -0.1 - gap), DQuat::IDENTITY);
        let checker = checker(arm(1), vec![ground]);
        let edge = checker.check(&straight(&[0.5, 0.0], &[0.5, 1.0]), 10_000).unwrap();
        let EdgeAnswer::Free { clearance } = edge.answer else { panic!("{gap}: {edge:?}") };
        assert!(clearance <= gap * 1.0001 && clearance > 0.4 * gap, "{gap}: {clearance}");
        assert!(edge.nodes < 100, "{gap}: {}", edge.nodes);
    }
}

#[test]
fn edges_above_a_slope_are_answered_as_their_samples_say() {
    let mut draw = Draw::new();
    let [mut free, mut hits, mut k] = [0; 3];
    while k < 60 || free <= 10 || hits <= 10 {
        assert!(k < 1000, "{free} {hits}");
        let turn = DQuat::from_scaled_axis(draw.vector() * [0.0, 0.5][k % 2]);
        let below = DVec3::new(draw.unit() * 9.0, draw.unit() * 9.0, -1.4 + 0.4 * draw.unit());
        let robot = if k % 3 == 0 { cart() } else { arm(3) };
        let checker = checker(robot, vec![ground(below, turn)]);
        let mut state = || -> Vec<f64> { (0..4).map(|_| draw.unit() * 0.8).collect() };
        let path = if k % 4 == 0 {
            JointPath::Bezier([state(), state(), state(), state()])
        } else {
            JointPath::Straight([state(), state()])
        };
        let edge = checker.check(&path, 10_000).unwrap();
        assert!(!matches!(edge.answer, EdgeAnswer::Undecided { .. }), "{k}: {edge:?}");
        assert_holds(&checker, &path, &edge, 300);
        let is_free = matches!(edge.answer, EdgeAnswer::Free { .. });
        (free, hits, k) = (free + usize::from(is_free), hits + usize::from(!is_free), k + 1);
    }
}
