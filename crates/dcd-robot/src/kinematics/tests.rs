use super::*;
use crate::AllowedPairs;
use std::f64::consts::FRAC_PI_2;
use std::path::{Path, PathBuf};

/// A robot from the text between `<robot>` and its end.
fn robot(inside: &str) -> Result<Robot, RobotError> {
    let file = Temporary::new();
    std::fs::write(&file.0, format!("<robot name=\"r\">{inside}</robot>")).unwrap();
    Robot::load(&file.0)
}

/// A file that is gone with the test.
struct Temporary(PathBuf);

impl Temporary {
    fn new() -> Self {
        use std::sync::atomic::{AtomicU32, Ordering};
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        Self(std::env::temp_dir().join(format!("dcd-{}-{number}.urdf", std::process::id())))
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        std::fs::remove_file(&self.0).ok();
    }
}

fn link(name: &str) -> String {
    format!(
        "<link name=\"{name}\"><collision><origin xyz=\"0 0 0.5\"/><geometry>\
         <box size=\"0.1 0.2 1\"/></geometry></collision></link>"
    )
}

/// A joint from one link to the next, a metre up, with what is said of it.
fn joint(kind: &str, [parent, child]: [&str; 2], more: &str) -> String {
    format!(
        "<joint name=\"{parent}{child}\" type=\"{kind}\"><origin xyz=\"0 0 1\"/>\
         <parent link=\"{parent}\"/><child link=\"{child}\"/>\
         <limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/>{more}</joint>"
    )
}

/// Three links in a row: a turn about y, then a slide along x (of any length).
fn arm() -> Robot {
    let turn = joint("revolute", ["a", "b"], "<axis xyz=\"0 1 0\"/>");
    let slide = joint("prismatic", ["b", "c"], "<axis xyz=\"3 0 0\"/>");
    // The far joint stands first in the file.
    robot(&[link("a"), link("b"), link("c"), slide, turn].concat()).unwrap()
}

fn placed(robot: &Robot, state: &[f64]) -> Vec<Pose> {
    let mut poses = Vec::new();
    robot.place(state, &mut poses).unwrap();
    poses
}

fn assert_near(a: DVec3, b: DVec3) {
    assert!(a.distance(b) < 1e-15, "{a} is not {b}");
}

#[test]
fn an_arm_stands_where_a_hand_computes_it() {
    let arm = arm();
    // In the file's order, whatever order the chain has.
    assert_eq!(arm.variables(), ["bc", "ab"]);
    let rest = placed(&arm, &[0.0, 0.0]);
    for (link, pose) in rest.iter().enumerate() {
        assert_near(pose.translation(), DVec3::Z * (link as f64 + 0.5));
    }
    // A quarter turn about y takes z to x and x to −z; the slide is along the turned x.
    let turned = placed(&arm, &[0.25, FRAC_PI_2]);
    assert_near(turned[0].translation(), DVec3::Z * 0.5);
    assert_near(turned[1].translation(), DVec3::new(0.5, 0.0, 1.0));
    assert_near(turned[2].translation(), DVec3::new(1.5, 0.0, 0.75));
    assert_near(turned[2].apply(DVec3::X), DVec3::new(1.5, 0.0, -0.25));
}

#[test]
fn roll_pitch_and_yaw_turn_about_x_then_y_then_z_of_the_outer_frame() {
    let xyz = [1.0, 2.0, 3.0];
    let rpy = [FRAC_PI_2, 0.0, FRAC_PI_2];
    let frame = JointFrame::of_angles(DVec3::from_array(xyz), rpy);
    assert_near(frame.rotation * DVec3::X, DVec3::Y);
    assert_near(frame.rotation * DVec3::Y, DVec3::Z);
    assert_eq!(frame.translation, DVec3::new(1.0, 2.0, 3.0));
}

#[test]
fn a_joint_that_mimics_moves_by_its_leaders_value() {
    let turn = joint("continuous", ["a", "b"], "<axis xyz=\"0 0 1\"/>");
    let mimic = joint(
        "prismatic",
        ["a", "c"],
        "<axis xyz=\"1 0 0\"/><mimic joint=\"ab\" multiplier=\"-2\" offset=\"0.5\"/>",
    );
    let robot = robot(&[link("a"), link("b"), link("c"), turn, mimic].concat()).unwrap();
    assert_eq!(robot.variables(), ["ab"]);
    let poses = placed(&robot, &[0.75]);
    assert_near(poses[2].translation(), DVec3::new(-1.0, 0.0, 1.5));
}

#[test]
fn links_that_are_joined_or_rigidly_tied_are_adjacent() {
    let tied = |pair| joint("fixed", pair, "");
    let turn = joint("revolute", ["b", "c"], "<axis xyz=\"0 1 0\"/>");
    let bare = "<link name=\"b\"/>".to_owned();
    let parts = [link("a"), bare, link("c"), link("d"), tied(["a", "b"]), turn, tied(["c", "d"])];
    let again = joint("fixed", ["c", "e"], "");
    let robot = robot(&[&parts.concat(), &link("e"), &again].map(|s| s.as_str()).concat()).unwrap();
    let allowed = AllowedPairs::adjacent(&robot);
    // Through b, which has no shape; d and e are both tied to c.
    for [x, y] in [["a", "c"], ["c", "d"], ["d", "e"], ["c", "e"]] {
        assert!(allowed.contains(x, y), "{x} {y}");
    }
    assert!(!allowed.contains("a", "d") && !allowed.contains("a", "e"));
}

#[test]
fn elements_of_other_namespaces_are_passed_over() {
    let inside = "<robot name=\"r\" xmlns:x=\"http://x\"><x:a><x:b/></x:a><link name=\"a\">\
                  <collision><geometry><box size=\"1 1 1\"/><x:convex/></geometry></collision></link>\
                  </robot>";
    let file = Temporary::new();
    std::fs::write(&file.0, inside).unwrap();
    assert_eq!(Robot::load(&file.0).unwrap().parts().len(), 1);
}

#[test]
fn what_makes_no_robot_is_refused_by_name() {
    let refused = |parts: &[String]| robot(&parts.concat()).unwrap_err().to_string();
    let turn = |pair| joint("revolute", pair, "<axis xyz=\"0 1 0\"/>");
    let (a, b) = (link("a"), link("b"));
    for (parts, why) in [
        (vec![a.clone(), a.clone()], "two of link \"a\""),
        (vec![a.clone(), turn(["a", "b"])], "joint \"ab\": there is no link \"b\""),
        (vec![a.clone(), b.clone(), turn(["a", "b"]), turn(["b", "a"])], "not on one way"),
        (
            vec![a.clone(), b.clone(), turn(["a", "b"]), joint("fixed", ["a", "b"], "")],
            "two of joint",
        ),
        (vec![a.clone(), b.clone(), joint("ball", ["a", "b"], "")], "\"ball\""),
        (
            vec![a.clone(), b.clone(), joint("revolute", ["a", "b"], "<axis xyz=\"0 0 0\"/>")],
            "length of the axis is 0e0",
        ),
        (
            vec![a.clone(), b.clone(), joint("revolute", ["a", "b"], "<mimic joint=\"x\"/>")],
            "there is no moved joint \"x\"",
        ),
        (vec![a.replace("0 0 0.5", "0 0 nan")], "xyz of origin is NaN"),
        (vec![a.replace("0.1 0.2 1", "0.1 -2 1")], "link \"a\": the half extent is -1"),
        (
            vec![a.replace("<box size=\"0.1 0.2 1\"/>", "<mesh filename=\"no.obj\"/>")],
            "mesh \"no.obj\"",
        ),
    ] {
        let said = refused(&parts);
        assert!(said.contains(why), "{why:?} is not in {said:?}");
    }
    let absent = Robot::load(Path::new("no/such.urdf")).unwrap_err().to_string();
    assert!(absent.contains("no/such.urdf"), "{absent}");
    assert!(robot("<link").is_err());
}

#[test]
fn a_state_that_does_not_fit_is_refused_with_its_value() {
    let arm = arm();
    let mut poses = Vec::new();
    let refused = |result: Result<(), RobotError>| result.unwrap_err().to_string();
    let short = refused(arm.place(&[0.0], &mut poses));
    assert_eq!(short, "robot \"r\": 1 joint values, not 2");
    let nan = refused(arm.place(&[0.0, f64::NAN], &mut poses));
    assert_eq!(nan, "joint \"ab\": the value is NaN");
    let unknown = arm.state(&[("elbow".to_owned(), 1.0)]).unwrap_err().to_string();
    assert_eq!(unknown, "state: there is no joint \"elbow\"");
    let state = arm.state(&[("ab".to_owned(), 1.0), ("ab".to_owned(), 0.5)]).unwrap();
    assert_eq!(state, [0.0, 0.5]);
}
