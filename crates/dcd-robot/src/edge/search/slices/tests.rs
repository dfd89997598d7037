use super::super::super::place::Twist;
use super::super::super::tests::Draw;
use super::kernels::PlaceSphere;
use super::*;
use crate::kinematics::JointFrame;
use crate::state_checker::link_frames::FrameRow;
use glam::{DMat3, DQuat, DVec3};

#[test]
fn a_sphere_is_where_its_pose_puts_it_and_moves_as_its_link_does() {
    let mut draw = Draw::new();
    for k in 0..50 {
        let mut frame = || JointFrame {
            rotation: DMat3::from_quat(DQuat::from_scaled_axis(draw.vector() * 3.0)),
            translation: draw.vector(),
        };
        let (link, mut origin) = (frame(), frame());
        if k % 5 == 0 {
            origin.rotation = DMat3::IDENTITY;
        }
        let (centre, base) = (draw.vector(), draw.vector());
        let twist = Twist { turn: draw.vector(), at_base: draw.vector() };
        let row = |x: f64| [[x; HALF]; 2];
        let mut frame: FrameRow = [NONE; 12];
        let numbers = link.rotation.to_cols_array().into_iter();
        for (k, x) in numbers.chain(link.translation.to_array()).enumerate() {
            frame[k] = row(x);
        }
        let rows = |v: DVec3| v.to_array().map(row);
        let twist_row = TwistRow { turn: rows(twist.turn), at_base: rows(twist.at_base) };
        let mut to = SphereRow {
            centre: [NONE; 3],
            velocity: [NONE; 3],
            speed: NONE,
            radius: 0.0,
            deviation: 0.0,
            accelerations: Vec::new(),
        };
        let (origin, twist_row) = (&origin, &twist_row);
        let frame = &frame;
        dispatch(PlaceSphere { frame, origin, centre, twist: twist_row, base, to: &mut to });
        let pose = link.then(origin).pose().unwrap();
        let at = pose.apply(centre);
        let speed = twist.of(at - base);
        for lane in [0, WIDTH - 1] {
            let vector = |points: &Points| {
                DVec3::from_array(points.map(|row| row[lane / HALF][lane % HALF]))
            };
            assert!(vector(&to.centre).distance(at) < 1e-14, "{lane}");
            assert!(vector(&to.velocity).distance(speed) < 1e-14, "{lane}");
            assert!((to.speed[lane / HALF][lane % HALF] - speed.length()).abs() < 1e-14);
        }
        let deviation = pose.deviation();
        assert!(to.deviation >= 0.9 * deviation && to.deviation < deviation + 1e-14);
    }
}
