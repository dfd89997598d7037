use super::*;
use crate::LinkShapes;
use std::path::Path;

/// A base on wheels that carries two arms, one with a finger that mimics the other's.
const URDF: &str = r#"<robot name="r">
  <link name="floor"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <link name="body"/><link name="left"/><link name="left_hand"/><link name="right"/>
  <link name="finger"/><link name="thumb"/>
  <joint name="drive" type="planar"><parent link="floor"/><child link="body"/><axis xyz="0 0 1"/></joint>
  <joint name="left_shoulder" type="continuous"><parent link="body"/><child link="left"/></joint>
  <joint name="left_wrist" type="fixed"><parent link="left"/><child link="left_hand"/></joint>
  <joint name="right_shoulder" type="continuous"><parent link="body"/><child link="right"/></joint>
  <joint name="grasp" type="continuous"><parent link="right"/><child link="finger"/></joint>
  <joint name="follow" type="continuous"><parent link="right"/><child link="thumb"/><mimic joint="grasp"/></joint>
</robot>"#;

const SRDF: &str = r#"<robot name="r">
  <group name="left"><chain base_link="body" tip_link="left_hand"/></group>
  <group name="across"><chain base_link="left_hand" tip_link="right"/></group>
  <group name="hand"><joint name="grasp"/><passive_joint name="follow"/></group>
  <group name="thumb"><link name="thumb"/></group>
  <group name="drive"><joint name="drive"/></group>
  <group name="on_wheels"><link name="body"/></group>
  <group name="foot"><link name="floor"/></group>
  <group name="all"><group name="left"/><group name="hand"/><group name="left"/></group>
  <group_state name="home" group="hand"><joint name="grasp" value="0.5"/><joint name="follow" value="9"/></group_state>
  <group_state name="home" group="drive"><joint name="drive" value="1 2 -3"/></group_state>
  <end_effector name="gripper" parent_link="right" group="hand" parent_group="across"/>
</robot>"#;

fn robot() -> Robot {
    Robot::read(URDF, Path::new("."), LinkShapes::Hulls).unwrap()
}

fn with(body: &str) -> Srdf {
    Srdf::read(&format!("<robot name=\"r\">{body}</robot>")).unwrap()
}

/// The names of a group's joints, links and variables.
fn named(srdf: &Srdf, robot: &Robot, name: &str) -> [Vec<String>; 3] {
    let JointGroup { joints, links, variables } = srdf.joint_group(robot, name).unwrap();
    let mut joints: Vec<_> = joints.iter().map(|&j| robot.joints()[j].name.clone()).collect();
    joints.sort_unstable();
    let mut links: Vec<_> = links.iter().map(|&l| robot.links()[l].name.clone()).collect();
    links.sort_unstable();
    [joints, links, variables.iter().map(|&v| robot.variables()[v].clone()).collect()]
}

#[test]
fn groups_are_found_by_joints_links_chains_and_other_groups() {
    let (robot, srdf) = (robot(), Srdf::read(SRDF).unwrap());
    let expect = |name: &str, joints: &[&str], links: &[&str], variables: &[&str]| {
        assert_eq!(named(&srdf, &robot, name), [joints, links, variables], "{name}");
    };
    expect("left", &["left_shoulder", "left_wrist"], &["left", "left_hand"], &["left_shoulder"]);
    expect(
        "across",
        &["left_shoulder", "left_wrist", "right_shoulder"],
        &["left", "left_hand", "right"],
        &["left_shoulder", "right_shoulder"],
    );
    expect("hand", &["follow", "grasp"], &["finger", "thumb"], &["grasp"]);
    // What it mimics is in no group of its own.
    expect("thumb", &["follow"], &["thumb"], &[]);
    let values = ["drive/x", "drive/y", "drive/theta"];
    let steps = ["drive/theta", "drive/x", "drive/y"];
    expect("drive", &steps, &["body", "drive/x", "drive/y"], &values);
    expect("on_wheels", &steps, &["body", "drive/x", "drive/y"], &values);
    expect("foot", &[], &["floor"], &[]);
    expect(
        "all",
        &["follow", "grasp", "left_shoulder", "left_wrist"],
        &["finger", "left", "left_hand", "thumb"],
        &["left_shoulder", "grasp"],
    );
    assert_eq!(srdf.notes(&robot).unwrap(), [""; 0]);
}

#[test]
fn named_states_give_each_variable_its_value() {
    let (robot, srdf) = (robot(), Srdf::read(SRDF).unwrap());
    let state = |group, name| srdf.group_state(&robot, group, name);
    let named = |values: Vec<(usize, f64)>| {
        values.into_iter().map(|(k, x)| (robot.variables()[k].clone(), x)).collect::<Vec<_>>()
    };
    assert_eq!(named(state("hand", "home").unwrap()), [("grasp".to_owned(), 0.5)]);
    let drive = ["drive/x", "drive/y", "drive/theta"].map(str::to_owned);
    let expected: Vec<_> = drive.into_iter().zip([1.0, 2.0, -3.0]).collect();
    assert_eq!(named(state("drive", "home").unwrap()), expected);
    let unknown = state("left", "home").unwrap_err().to_string();
    assert_eq!(unknown, "group \"left\": there is no state \"home\"");
    let short = SRDF.replace("1 2 -3", "1 2");
    let refused = Srdf::read(&short).unwrap().group_state(&robot, "drive", "home").unwrap_err();
    assert_eq!(refused.to_string(), "group_state \"home\", joint \"drive\": 2 values, not 3");
}

#[test]
fn end_effectors_are_kept_as_the_file_has_them() {
    let srdf = Srdf::read(SRDF).unwrap();
    let expected = EndEffector {
        name: "gripper".to_owned(),
        group: "hand".to_owned(),
        parent_link: "right".to_owned(),
        parent_group: Some("across".to_owned()),
    };
    assert_eq!(srdf.end_effectors, [expected]);
}

#[test]
fn what_groups_name_and_there_is_not_is_noted_and_refused_when_used() {
    let robot = robot();
    let srdf = with(
        r#"<group name="a"><joint name="no_joint"/></group>
        <group name="b"><chain base_link="body" tip_link="no_link"/></group>
        <group name="c"><group name="no_group"/></group>
        <group name="d"><group name="e"/></group><group name="e"><group name="d"/></group>
        <group_state name="s" group="a"><joint name="no_joint" value="1"/></group_state>
        <end_effector name="h" parent_link="nowhere" group="no_group"/>"#,
    );
    let notes = srdf.notes(&robot).unwrap();
    let expected = [
        "group \"a\": there is no joint \"no_joint\"",
        "group \"b\": there is no link \"no_link\"",
        "group \"c\": there is no group \"no_group\"",
        "group_state \"s\": there is no joint \"no_joint\"",
        "end_effector \"h\": there is no group \"no_group\"",
        "end_effector \"h\": there is no link \"nowhere\"",
    ];
    assert_eq!(notes, expected);
    let refused = srdf.joint_group(&robot, "a").unwrap_err().to_string();
    assert_eq!(refused, expected[0]);
    let ring = srdf.joint_group(&robot, "d").unwrap_err().to_string();
    assert_eq!(ring, "group \"d\": it holds itself, by way of others");
    let chain: String = (0..100)
        .map(|k| format!("<group name=\"g{k}\"><group name=\"g{}\"/></group>", k + 1))
        .collect();
    let deep = with(&chain).joint_group(&robot, "g0").unwrap_err().to_string();
    assert!(deep.contains("64 deep"), "{deep}");
}

#[test]
fn what_is_not_understood_in_a_group_is_refused_with_its_line() {
    let refused = |body: &str| {
        Srdf::read(&format!("<robot name=\"r\">\n{body}</robot>")).unwrap_err().to_string()
    };
    let element = refused("<group name=\"a\"><lnk name=\"b\"/></group>");
    assert_eq!(element, "line 2: group \"a\": element \"lnk\" is not understood here");
    assert!(refused("<group/>").contains("group has no name"));
    assert!(refused("<group name=\"a\"><chain base_link=\"b\"/></group>").contains("no tip_link"));
    let twice = refused("<group name=\"a\"/><group name=\"a\"/>");
    assert_eq!(twice, "line 2: there are two of group \"a\"");
    let state = "<group_state name=\"s\" group=\"a\"/>";
    assert!(refused(&state.repeat(2)).contains("group \"a\": there are two of state \"s\""));
    let value = |value: &str| {
        refused(&format!(
            "<group_state name=\"s\" group=\"a\"><joint name=\"j\" value=\"{value}\"/></group_state>"
        ))
    };
    assert!(value("1 two").contains("\"two\" is no number"));
    assert!(value("inf").contains("inf"));
    assert!(value("").contains("0 numbers"));
}
