use super::*;
use crate::{AllowedPairs, LinkShapes, Workcell, World};
use dcd_pipeline::{Par, Pipeline};
use std::path::Path;

/// Two boxes of edge 1 at x = 0 and 2, the second turned about z by "turn"; "twin" does as "turn" does.
const ARM: &str = r#"<robot name="arm">
  <link name="base"><collision><geometry><box size="1 1 1"/></geometry></collision></link>
  <link name="hand"><collision><geometry><box size="1 1 1"/></geometry></collision></link>
  <link name="tip"/><link name="eye"/>
  <joint name="turn" type="continuous"><origin xyz="2 0 0"/><axis xyz="0 0 1"/><parent link="base"/><child link="hand"/></joint>
  <joint name="slide" type="prismatic"><axis xyz="1 0 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/>
    <parent link="hand"/><child link="tip"/></joint>
  <joint name="twin" type="continuous"><axis xyz="0 0 1"/><mimic joint="turn"/><parent link="base"/><child link="eye"/></joint>
</robot>"#;

fn arm() -> Robot {
    Robot::read(ARM, Path::new("."), LinkShapes::Hulls).unwrap()
}

fn reader(robot: &Robot) -> StateReader<'_> {
    let meshes = MeshSource::beside(Path::new("."), LinkShapes::Hulls);
    StateReader::new(robot, vec![0.5, 0.25], meshes)
}

#[test]
fn values_are_taken_by_name_or_in_order_and_the_others_are_the_defaults() {
    let robot = arm();
    let mut reader = reader(&robot);
    let mut values = |line: &str| reader.read(line.as_bytes()).unwrap().values;
    assert_eq!(values(r#"{"q": [1, -2e-3]}"#), [1.0, -2e-3]);
    assert_eq!(values(r#"{"q": {"slide": 0.1}, "_note": {"any": [null]}, "name": 7}"#), [0.5, 0.1]);
    assert_eq!(values(r#"{"q": {}}"#), [0.5, 0.25]);
}

#[test]
fn what_is_not_understood_is_refused_by_name() {
    let robot = arm();
    let mut reader = reader(&robot);
    let attached = |object: &str| format!(r#"{{"q": [0, 0], "attached": [{object}]}}"#);
    let with =
        |shape: &str| attached(&format!(r#"{{"name": "cup", "link": "hand", "shape": {shape}}}"#));
    let cases = [
        ("", "no state"),
        ("[1, 2]", "no object"),
        ("{}", "there is no q"),
        (r#"{"q": 1}"#, "neither an object nor a list"),
        (r#"{"q": [1]}"#, "1 joint values, not 2"),
        (r#"{"q": [1, "2"]}"#, "joint \"slide\": its value is no number"),
        (r#"{"q": [1, NaN]}"#, "no state"),
        (r#"{"q": [1, 1e999]}"#, "no state"),
        (r#"{"q": {"trun": 1}}"#, "no joint \"trun\""),
        (r#"{"q": {"twin": 1}}"#, "joint \"twin\": it is fixed or mimics another"),
        (r#"{"q": {"turn": 1, "turn": 2}}"#, "key \"turn\" stands twice"),
        (r#"{"q": [0, 0], "attach": []}"#, "key \"attach\" is none of q, attached"),
        (&attached("{}"), "there is no name"),
        (&attached(r#"{"name": "cup", "link": "hand"}"#), "there is no shape"),
        (&with(r#"{"box": [1, 2]}"#), "2"),
        (&with(r#"{"box": [1, 2, -3]}"#), "-1.5e0"),
        (&with(r#"{"sphere": 1, "box": [1, 1, 1]}"#), "2 kinds, not 1"),
        (&with(r#"{"cone": [1, 1]}"#), "shape \"cone\" is not supported"),
        (&with(r#"{"mesh": "not/there.stl"}"#), "not/there.stl"),
        (&with(r#"{"sphere": 1}, "pose": {"q": [0, 0, 0, 2]}"#), "attached object \"cup\""),
        (&with(r#"{"sphere": 1}, "touch": "hand""#), "touch is no list"),
    ];
    for (line, why) in cases {
        let error = reader.read(line.as_bytes()).unwrap_err().to_string();
        assert!(error.contains(why), "{line}: {error}");
    }
}

#[test]
fn what_is_to_know_of_a_carried_mesh_is_said_once() {
    let folder = std::env::temp_dir().join(format!("dcd-carried-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let tool = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nl 1 4\n";
    std::fs::write(folder.join("tool.obj"), tool).unwrap();
    let robot = arm();
    let meshes = MeshSource::beside(&folder, LinkShapes::Hulls);
    let mut reader = StateReader::new(&robot, vec![0.0; 2], meshes);
    let mut notes = Vec::new();
    for name in ["a", "b"] {
        let line = format!(
            r#"{{"q": [0, 0], "attached": [{{"name": "{name}", "link": "hand", "shape": {{"mesh": "tool.obj"}}}}]}}"#
        );
        reader.read(line.as_bytes()).unwrap();
        notes.push(reader.take_notes());
    }
    std::fs::remove_dir_all(&folder).unwrap();
    assert!(notes[0].len() == 1 && notes[0][0].contains("tool.obj"), "{notes:?}");
    assert!(notes[1].is_empty(), "{notes:?}");
}

#[test]
fn what_a_state_carries_moves_with_its_link_and_may_touch_what_it_is_allowed_to() {
    let robot = arm();
    let mut reader = reader(&robot);
    // A stick from the hand's middle back to the base's, where the arm is not turned.
    let line = |touch: &str, turn: f64| {
        format!(
            r#"{{"q": [{turn}, 0], "attached": [{{"name": "stick", "link": "hand", "touch": [{touch}],
            "shape": {{"box": [2, 0.1, 0.1]}}, "pose": {{"xyz": [-1, 0, 0]}}}}]}}"#
        )
    };
    let mut touching = |line: String| {
        let state = reader.read(line.as_bytes()).unwrap();
        let (mut world, mut allowed) = (World::default(), AllowedPairs::adjacent(&robot));
        for AttachedObject { object, touch } in state.attached.iter() {
            world.attach(object.clone(), touch);
        }
        allowed.extend(&world.allowed);
        let mut cell = Workcell::new(robot.clone(), &world, &allowed).unwrap();
        cell.set_state(&state.values).unwrap();
        let mut pipeline = Pipeline::new();
        let step = pipeline.step(cell.scene(), Par::Serial);
        step.contacts().map(|pair| cell.names_of(pair).map(str::to_owned)).collect::<Vec<_>>()
    };
    assert_eq!(touching(line("", 0.0)), [["base", "stick"]]);
    assert_eq!(touching(line("\"base\"", 0.0)), [] as [[&str; 2]; 0]);
    assert_eq!(touching(line("", 1.5)), [] as [[&str; 2]; 0]);
}

#[test]
fn neighbouring_lines_share_what_they_carry_alike() {
    let robot = arm();
    let mut reader = reader(&robot);
    let cup = r#""attached": [{"name": "cup", "link": "hand", "shape": {"sphere": 0.1}}]"#;
    let line = |more: &str| format!(r#"{{"q": [0, 0]{more}}}"#);
    let mut read = |more: &str| reader.read(line(more).as_bytes()).unwrap().attached;
    let none = read("");
    let first = read(&format!(", {cup}"));
    assert!(Arc::ptr_eq(&first, &read(&format!(", {cup}"))));
    assert!(!Arc::ptr_eq(&first, &read(&format!(", {}", cup.replace("0.1", "0.2")))));
    assert!(none.is_empty() && read("").is_empty());
}

/// A base that moves in the plane, an arm that turns on it, a drone.
const SEVERAL: &str = r#"<robot name="several">
  <link name="world"/>
  <link name="base"><collision><geometry><box size="1 1 1"/></geometry></collision></link>
  <link name="arm"><collision><origin xyz="1 0 0"/><geometry><sphere radius="0.1"/></geometry></collision></link>
  <link name="drone"><collision><origin xyz="0 0 1"/><geometry><sphere radius="0.2"/></geometry></collision></link>
  <joint name="drive" type="planar"><origin xyz="0 0 0.5" rpy="0 0 1.5707963267948966"/>
    <parent link="world"/><child link="base"/></joint>
  <joint name="turn" type="continuous"><axis xyz="0 0 1"/><parent link="base"/><child link="arm"/></joint>
  <joint name="fly" type="floating"><origin xyz="0 0 2"/><parent link="world"/><child link="drone"/></joint>
</robot>"#;

#[test]
fn joints_of_several_values_are_lists_and_move_as_they_say() {
    let robot = Robot::read(SEVERAL, Path::new("."), LinkShapes::Hulls).unwrap();
    let names: Vec<&str> = robot.moved_joints().iter().map(|joint| joint.name.as_str()).collect();
    assert_eq!(names, ["drive", "turn", "fly"]);
    assert_eq!(robot.variables()[..4], ["drive/x", "drive/y", "drive/theta", "turn"]);
    assert_eq!(robot.variables()[4..6], ["fly/trans_x", "fly/trans_y"]);
    assert_eq!(robot.variables()[10], "fly/rot_w");
    let meshes = MeshSource::beside(Path::new("."), LinkShapes::Hulls);
    let mut reader = StateReader::new(&robot, robot.rest_state(), meshes);
    let half = std::f64::consts::FRAC_1_SQRT_2;
    // The drone turned by a quarter about x.
    let line =
        format!(r#"{{"q": [[1, 2, 1.5707963267948966], 0, [3, 4, 5, {half}, 0, 0, {half}]]}}"#);
    let listed = reader.read(line.as_bytes()).unwrap().values;
    let named = format!(
        r#"{{"q": {{"fly": [3, 4, 5, {half}, 0, 0, {half}], "drive": [1, 2, 1.5707963267948966]}}}}"#
    );
    assert_eq!(reader.read(named.as_bytes()).unwrap().values, listed);
    let mut poses = Vec::new();
    robot.place(&listed, &mut poses).unwrap();
    // The base's frame is turned by a quarter: its (1, 2) is the world's (−2, 1), and x of the base points to −x.
    let places: Vec<_> = poses.iter().map(|pose| pose.translation()).collect();
    let expected = [[-2.0, 1.0, 0.5], [-3.0, 1.0, 0.5], [3.0, 3.0, 7.0]];
    for (place, expected) in places.iter().zip(expected) {
        assert!(place.distance(DVec3::from_array(expected)) < 1e-12, "{places:?}");
    }
    robot.place(&robot.rest_state(), &mut poses).unwrap();
    assert!(poses[2].translation().distance(DVec3::Z * 3.0) < 1e-12);
    for (line, why) in [
        (r#"{"q": {"fly": [0, 0, 0]}}"#, "joint \"fly\": 3 values, not 7"),
        (r#"{"q": {"drive": 1}}"#, "no list of 3"),
        (r#"{"q": {"turn": [1]}}"#, "no number"),
        (r#"{"q": {"drive/x": 1}}"#, "drive/x"),
    ] {
        let refused = reader.read(line.as_bytes()).unwrap_err().to_string();
        assert!(refused.contains(why), "{line}: {refused}");
    }
    let mut long = robot.rest_state();
    long[10] = 1.5;
    let refused = robot.place(&long, &mut poses).unwrap_err().to_string();
    assert!(refused.contains("squared length of the quaternion"), "{refused}");
    for (from, to, why) in [
        ("type=\"planar\">", "type=\"planar\"><axis xyz=\"1 0 0\"/>", "axis of a planar joint"),
        ("type=\"floating\">", "type=\"floating\"><mimic joint=\"turn\"/>", "mimics none"),
    ] {
        let text = SEVERAL.replace(from, to);
        let refused =
            Robot::read(&text, Path::new("."), LinkShapes::Hulls).unwrap_err().to_string();
        assert!(refused.contains(why), "{refused}");
    }
}

#[test]
fn what_is_taken_and_put_down_stands_where_it_was_let_go() {
    let robot = arm();
    let ball = (dcd_geom::Shape::sphere(0.1).unwrap(), Pose::IDENTITY);
    let mut world = World::default();
    world.attach(Attached::new("ball", "hand", [ball]), ["base"]);
    let state = [std::f64::consts::FRAC_PI_2, 0.0];
    let held = Workcell::new(robot.clone(), &world, &world.allowed).unwrap();
    let touching = |mut cell: Workcell, state: &[f64]| {
        cell.set_state(state).unwrap();
        let mut pipeline = Pipeline::new();
        let contacts = pipeline.step(cell.scene(), Par::Serial).contacts();
        contacts.map(|pair| cell.names_of(pair).map(str::to_owned)).collect::<Vec<_>>()
    };
    assert!(touching(held.clone(), &state).is_empty());
    let poses = held.robot().link_poses(&state).unwrap();
    let hand = held.robot().links().iter().position(|link| link.name == "hand").unwrap();
    assert!(world.detach("cup").is_none());
    let ball = world.detach("ball").unwrap();
    world.obstacles.extend(ball.obstacles(&poses[hand]).unwrap());
    assert_eq!(world.obstacles[0].pose.translation(), DVec3::new(2.0, 0.0, 0.0));
    // It is in the hand, which may not touch it any more.
    assert!(world.attached.is_empty() && world.allowed.is_empty());
    let put = Workcell::new(robot, &world, &world.allowed).unwrap();
    assert_eq!(touching(put, &state), [["hand", "ball"]]);
}

#[test]
fn origins_are_those_of_the_file_and_carry_the_links_from_frame_to_frame() {
    let robot = arm();
    let state = [0.7, 0.0];
    let poses = robot.link_poses(&state).unwrap();
    for joint in robot.joints() {
        let [parent, child] = [joint.parent, joint.child].map(|link| poses[link]);
        let origin = joint.origin();
        let at = parent.rotation().mul_vec3(origin.translation) + parent.translation();
        assert!(at.distance(child.translation()) < 1e-15, "{}", joint.name);
    }
    let turn = robot.joints().iter().find(|joint| joint.name == "turn").unwrap();
    assert_eq!(turn.origin(), glam::DAffine3::from_translation(DVec3::new(2.0, 0.0, 0.0)));
    let part = &robot.parts()[1];
    assert_eq!((part.origin(), part.tolerance), (glam::DAffine3::IDENTITY, 0.0));
}
