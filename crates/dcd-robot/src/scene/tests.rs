mod carried;

use crate::{Attached, LinkShapes, PlanningScene, Robot, RobotError, Srdf, Workcell, World};
use dcd_geom::{Pose, Shape};
use dcd_pipeline::{Par, Pipeline};
use glam::{DQuat, DVec3};
use std::path::Path;

/// Two cubes of edge 1: the base at its root, the arm's own at x = 2 at rest, turning about z.
const ARM: &str = r#"<robot name="arm">
  <link name="base"><collision><geometry><box size="1 1 1"/></geometry></collision></link>
  <link name="arm"><collision><origin xyz="2 0 0"/><geometry><box size="1 1 1"/></geometry></collision></link>
  <joint name="turn" type="continuous"><axis xyz="0 0 1"/><parent link="base"/><child link="arm"/></joint>
  <joint name="stiff" type="fixed"><parent link="arm"/><child link="tip"/><origin xyz="3 0 0"/></joint>
  <link name="tip"/>
</robot>"#;

const SRDF: &str = r#"<robot name="arm">
  <virtual_joint name="floor" type="floating" parent_frame="world" child_link="base"/>
</robot>"#;

fn arm() -> Robot {
    Robot::read(ARM, Path::new("."), LinkShapes::Hulls).unwrap()
}

fn world_of(yaml: &str) -> Result<World, RobotError> {
    PlanningScene::read(yaml)?.world(&arm(), Some(&Srdf::read(SRDF).unwrap()))
}

fn assert_refused(yaml: &str, why: &[&str]) {
    let refused = world_of(yaml).unwrap_err().to_string();
    for why in why {
        assert!(refused.contains(why), "{why:?} is not in {refused:?}");
    }
}

/// A scene of one sphere of radius 0.25 with this in front of its lists, and this beside the world.
fn sphere(more: &str, beside: &str) -> String {
    format!(
        "world:
  collision_objects:
    - id: ball
      {more}
      primitives: [{{type: sphere, dimensions: [0.25]}}]
      primitive_poses: [{{position: [0, 0, 0.5], orientation: [0, 0, 0, 1]}}]
{beside}"
    )
}

/// Where the sphere of [`sphere`] is.
fn sphere_at(more: &str, beside: &str) -> DVec3 {
    let world = world_of(&sphere(more, beside)).unwrap();
    assert_eq!(world.obstacles[0].name, "ball");
    world.obstacles[0].pose.translation()
}

fn assert_near(a: DVec3, b: DVec3) {
    assert!(a.distance(b) < 1e-14, "{a} is not {b}");
}

/// The touching pairs of names at the world's own state, sorted.
fn touching(world: &World) -> Vec<[String; 2]> {
    let mut allowed = crate::AllowedPairs::adjacent(&arm());
    allowed.extend(&world.allowed);
    let mut cell = Workcell::new(arm(), world, &allowed).unwrap();
    let state = cell.robot().state(&world.joints).unwrap();
    cell.set_state(&state).unwrap();
    touching_in(&cell)
}

/// The touching pairs of names where a cell is, sorted.
pub(crate) fn touching_in(cell: &Workcell) -> Vec<[String; 2]> {
    let mut pipeline = Pipeline::new();
    let step = pipeline.step(cell.scene(), Par::Serial);
    let mut pairs: Vec<_> =
        step.contacts().map(|pair| cell.names_of(pair).map(str::to_owned)).collect();
    pairs.sort();
    pairs
}

const QUARTER: &str = "robot_state: {joint_state: {name: [turn], position: [1.5707963267948966]}}";

#[test]
fn a_scenes_boxes_cylinders_and_spheres_are_read_with_their_poses() {
    let world = world_of(
        "world:
  collision_objects:
    - id: table
      primitives:
        - {type: box, dimensions: [2, 4, 6]}
        - {type: 2, dimensions: [0.5]}
      primitive_poses:
        - {position: [1, 2, 3], orientation: [0, 0, 0, 1]}
        - {position: {x: 0, y: 0, z: 1}, orientation: {x: 0, y: 0, z: 1, w: 0}}
    - id: can
      pose: {position: [0, 0, 5], orientation: [0, 0, 0.7071067811865476, 0.7071067811865476]}
      primitives: [{type: cylinder, dimensions: [0.4, 0.1]}]
      primitive_poses: [{position: [1, 0, 0], orientation: [0, 0, 0, 1]}]
allowed_collision_matrix:
  entry_names: [table, hand]
  entry_values: [[false, true], {enabled: [true, false]}]
",
    )
    .unwrap();
    let names: Vec<&str> = world.obstacles.iter().map(|o| o.name.as_str()).collect();
    assert_eq!(names, ["table", "table", "can"]);
    let [table, sphere, can] = &world.obstacles[..] else { unreachable!() };
    let boxed = table.shape.aabb(&table.pose);
    assert!(boxed.min.z <= 0.0 && boxed.min.z > -1e-5 && boxed.max.y < 4.00001);
    assert_eq!(sphere.pose.translation(), DVec3::Z);
    assert!(can.pose.translation().distance(DVec3::new(0.0, 1.0, 5.0)) < 1e-15);
    let boxed = can.shape.aabb(&can.pose);
    assert!((boxed.max.z - 5.2).abs() < 1e-5 && (boxed.max.x - 0.1).abs() < 1e-5);
    assert!(world.allowed.contains("hand", "table") && !world.allowed.contains("can", "hand"));
}

#[test]
fn what_is_wrong_in_a_scene_is_named() {
    let scene = |primitive: &str, pose: &str| {
        let text = format!(
            "world: {{collision_objects: [{{id: can, primitives: [{primitive}], \
             primitive_poses: [{pose}]}}]}}"
        );
        world_of(&text).unwrap_err().to_string()
    };
    let here = "{position: [0, 0, 0], orientation: [0, 0, 0, 1]}";
    for (primitive, pose, why) in [
        ("{type: box, dimensions: [1, 2]}", here, "\"can\": box: 2 dimensions, not 3"),
        ("{type: torus, dimensions: [1, 2]}", here, "shape \"torus\" is not supported"),
        ("{type: 5, dimensions: [1, 2]}", here, "shape \"5\" is not supported"),
        ("{type: sphere, dimensions: [-1]}", here, "line 1: object \"can\": the radius is -1"),
        ("{type: sphere, dimensions: [.nan]}", here, "the radius is NaN"),
        ("{type: sphere, dimensions: [1]}", "", "0 primitive poses, not 1"),
        (
            "{type: sphere, dimensions: [1]}",
            "{position: [0, 0, 0], orientation: [0, 0, 0, 0]}",
            "|q|² = 0",
        ),
        ("{type: sphere, dimensions: [one]}", here, "no scene"),
    ] {
        let refused = scene(primitive, pose);
        assert!(refused.contains(why), "{why:?} is not in {refused:?}");
    }
    let matrix = |values: &str| {
        format!(
            "world: {{}}\nallowed_collision_matrix: {{entry_names: [a, b], entry_values: {values}}}"
        )
    };
    assert_refused(&matrix("[[false, true]]"), &["line 2", "1 entries, not 2"]);
    assert_refused(&matrix("[[false, true], [false, false]]"), &["\"a\" and \"b\"", "both"]);
}

#[test]
fn a_misspelt_key_a_request_and_an_empty_file_are_no_scene() {
    assert_refused("world: {collision_object: [{id: ball}]}", &["no scene", "collision_object"]);
    assert_refused(&sphere("headr: {frame_id: arm}", ""), &["headr", "line 4"]);
    assert_refused(&sphere("", "wrld: 1"), &["wrld"]);
    assert_refused("start_state: {joint_state: {name: [], position: []}}", &["start_state"]);
    for empty in ["", "{}", "# nothing", "robot_model_name: arm"] {
        let refused = world_of(empty).unwrap_err();
        assert!(matches!(refused, RobotError::NotOfKind { what: "scene", .. }), "{refused}");
    }
}

#[test]
fn a_world_without_an_obstacle_is_reported() {
    let world = world_of("world: {}").unwrap();
    assert_eq!(world.notes, ["there is no obstacle in it"]);
    assert!(world_of(&sphere("", "")).unwrap().notes.is_empty());
}

#[test]
fn an_objects_frame_is_the_roots_a_links_at_the_scenes_state_or_one_that_the_scene_fixes() {
    for frame in ["''", "\"\"", "world", "/world", "base"] {
        let header = format!("header: {{frame_id: {frame}}}");
        assert_near(sphere_at(&header, ""), DVec3::Z * 0.5);
    }
    let tip = "header: {seq: 0, stamp: {secs: 0, nsecs: 0}, frame_id: tip}";
    assert_near(sphere_at(tip, ""), DVec3::new(3.0, 0.0, 0.5));
    // A quarter turn takes the tip from x to y.
    assert_near(sphere_at(tip, QUARTER), DVec3::new(0.0, 3.0, 0.5));
    let fixed = "fixed_frame_transforms:
  - header: {frame_id: tip}
    child_frame_id: shelf
    transform: {translation: [0, 0, 7], rotation: [0, 0, 0, 1]}
  - child_frame_id: world
    transform: {translation: [0, 0, 0], rotation: [0, 0, 0, 1]}";
    assert_near(sphere_at("header: {frame_id: shelf}", fixed), DVec3::new(3.0, 0.0, 7.5));
    assert_refused(&sphere("header: {frame_id: shelf}", ""), &["line 3", "no frame \"shelf\""]);
    let moved = fixed.replace("[0, 0, 0],", "[0, 0, 1],");
    assert_refused(&sphere("", &moved), &["fixed frame \"world\"", "elsewhere"]);
}

#[test]
fn the_base_pose_and_joint_values_of_the_scene_are_used() {
    let state = "robot_state:
  joint_state: {name: [turn], position: [1.5707963267948966]}
  multi_dof_joint_state:
    joint_names: [floor]
    transforms: [{translation: [0, 0, 10], rotation: [0, 0, 0, 1]}]";
    let world = world_of(&sphere("header: {frame_id: tip}", state)).unwrap();
    assert_near(world.obstacles[0].pose.translation(), DVec3::new(0.0, 3.0, 10.5));
    assert_near(world.base.unwrap().translation(), DVec3::Z * 10.0);
    // The sphere of the world's own frame is below the robot now, the one in the base's frame in it.
    assert!(touching(&world_of(&sphere("", state)).unwrap()).is_empty());
    let inside = world_of(&sphere("header: {frame_id: base}", state)).unwrap();
    assert_eq!(touching(&inside), [["base", "ball"]]);
    let other = state.replace("[floor]", "[sky]");
    assert_refused(&sphere("", &other), &["no virtual joint", "\"sky\""]);
    let frame = state.replace("joint_names", "header: {frame_id: map}\n    joint_names");
    assert_refused(&sphere("", &frame), &["no frame \"map\""]);
    let unknown = QUARTER.replace("turn", "elbow");
    assert_refused(&sphere("", &unknown), &["no joint \"elbow\""]);
}

#[test]
fn a_floating_and_a_planar_joint_take_their_values_from_a_transform() {
    let urdf = |kind: &str| {
        let (base, body) = (
            "<link name=\"base\"/>",
            r#"<joint name="move" type="KIND"><parent link="base"/>
            <child link="body"/><axis xyz="0 0 1"/></joint>"#,
        );
        let shape = r#"<link name="body"><collision><geometry><sphere radius="1"/></geometry></collision></link>"#;
        let text = format!("<robot name=\"r\">{base}{shape}{}</robot>", body.replace("KIND", kind));
        Robot::read(&text, Path::new("."), LinkShapes::Hulls).unwrap()
    };
    let state = |robot: &Robot, frame: &str, transform: &str| {
        let text = format!(
            "world: {{}}\nrobot_state:\n  multi_dof_joint_state:\n    header: {{frame_id: {frame}}}\n    \
             joint_names: [move]\n    transforms: [{{{transform}}}]"
        );
        let world = PlanningScene::read(&text).unwrap().world(robot, None)?;
        robot.state(&world.joints)
    };
    let turned = "translation: [1, 2, 0], rotation: [0, 0, 0.6, 0.8]";
    let floating = state(&urdf("floating"), "base", turned).unwrap();
    assert_eq!(floating, [1.0, 2.0, 0.0, 0.0, 0.0, 0.6, 0.8]);
    let planar = state(&urdf("planar"), "\"\"", turned).unwrap();
    assert_eq!(planar[..2], [1.0, 2.0]);
    assert!((planar[2].tan() - 24.0 / 7.0).abs() < 1e-12, "{planar:?}");
    let refused = |transform: &str, frame: &str| {
        state(&urdf("planar"), frame, transform).unwrap_err().to_string()
    };
    assert!(refused(&turned.replace("0]", "1]"), "base").contains("leaves the plane"));
    assert!(refused(turned, "map").contains("\"map\""));
    // Three numbers have no one name, and no number two sources.
    let of_base = urdf("planar").state(&[("move".to_owned(), 1.5)]).unwrap_err().to_string();
    assert!(of_base.contains("it has 3 values: move/x, move/y"), "{of_base}");
    let twice = format!(
        "world: {{}}\nrobot_state:\n  joint_state: {{name: [move/x], position: [3]}}\n  multi_dof_joint_state:\n    \
         joint_names: [move]\n    transforms: [{{{turned}}}]"
    );
    let refused = PlanningScene::read(&twice).unwrap().world(&urdf("planar"), None).unwrap_err();
    assert!(refused.to_string().contains("two of value of joint \"move/x\""), "{refused}");
}

/// A sphere of radius 0.5 at the tip, at x = 3.5 at rest.
const HELD: &str = "robot_state:
  attached_collision_objects:
    - link_name: tip
      touch_links: [arm]
      object:
        id: held
        header: {frame_id: tip}
        primitives: [{type: sphere, dimensions: [0.5]}]
        primitive_poses: [{position: [0, 0, 0], orientation: [0, 0, 0, 1]}]
";

#[test]
fn what_the_robot_carries_moves_with_its_link_and_touches_all_but_its_touch_links() {
    let at = |x: &str, y: &str, held: &str| {
        let text = sphere("", held).replace("[0, 0, 0.5]", &format!("[{x}, {y}, 0]"));
        touching(&world_of(&text).unwrap())
    };
    // At x = 3 it is in the arm's cube (up to 2.5) and not in what stands at 3.75.
    assert_eq!(at("3.7", "0", HELD), [["held", "ball"]]);
    assert!(at("3.8", "0", HELD).is_empty() && at("3.7", "0", "").is_empty());
    let free = HELD.replace("[arm]", "[]");
    assert_eq!(at("9", "9", &free), [["arm", "held"]]);
    let turned = HELD.replace(
        "robot_state:\n",
        "robot_state:\n  joint_state: {name: [turn], position: [1.5707963267948966]}\n",
    );
    assert_eq!(at("0", "3.7", &turned), [["held", "ball"]]);
    // Without shapes of its own it is the world's object of its name, which leaves the world.
    let taken = "robot_state:
  attached_collision_objects: [{link_name: base, object: {id: ball}, touch_links: []}]";
    let world = world_of(&sphere("", taken)).unwrap();
    assert!(world.obstacles.is_empty() && touching(&world).is_empty());
    assert_eq!(world.attached[0].name, "ball");
    let lost = taken.replace("id: ball", "id: cup");
    assert_refused(&sphere("", &lost), &["line 8", "\"cup\"", "no shape"]);
    assert_refused(&sphere("", &HELD.replace("link_name: tip", "link_name: toe")), &["\"toe\""]);
}

#[test]
fn padding_and_scale_make_links_larger_to_the_world_and_not_to_the_robot() {
    // The sphere's rim is 0.1 beyond the arm's face at 2.5, and the base 0.5 off the arm's other face.
    let at = |beside: &str| {
        let text = sphere("", beside).replace("[0, 0, 0.5]", "[2.85, 0, 0]");
        touching(&world_of(&text).unwrap())
    };
    assert!(at("").is_empty());
    assert_eq!(at("link_padding: [{link_name: arm, padding: 0.11}]"), [["arm", "ball"]]);
    assert!(at("link_padding: [{link_name: arm, padding: 0.09}]").is_empty());
    assert!(at("link_padding: [{link_name: base, padding: 0.11}]").is_empty());
    assert_eq!(at("link_scale: [{link_name: arm, scale: 1.21}]"), [["arm", "ball"]]);
    // Padded by 2 the arm would be in the base, but they are adjacent; so test the held object.
    let both = format!("{HELD}link_padding: [{{link_name: base, padding: 3}}]\n");
    let far = sphere("", &both).replace("[0, 0, 0.5]", "[-3, 0, 0]");
    assert_eq!(touching(&world_of(&far).unwrap()), [["base", "ball"]]);
    assert_refused(
        &sphere("", "link_padding: [{link_name: arm, padding: -1}]"),
        &["padding is -1e0"],
    );
    let note = world_of(&sphere("", "link_padding: [{link_name: leg, padding: 1}]")).unwrap().notes;
    assert!(note[0].contains("\"leg\""), "{note:?}");
}

#[test]
fn what_a_link_carries_is_padded_and_scaled_as_the_link_is() {
    // A sphere of 0.4 on the tip, at x = 3: 0.35 from the ball, 0.1 from the arm's own face.
    let load = Attached::new("load", "tip", [(Shape::sphere(0.4).unwrap(), Pose::IDENTITY)]);
    let world = |beside: &str| {
        let text = sphere("", beside).replace("[0, 0, 0.5]", "[4, 0, 0]");
        let mut world = world_of(&text).unwrap();
        world.attach(load.clone(), [] as [&str; 0]);
        world
    };
    let at = |beside: &str| touching(&world(beside));
    assert!(at("").is_empty());
    assert!(at("link_padding: [{link_name: tip, padding: 0.34}]").is_empty());
    assert_eq!(at("link_padding: [{link_name: tip, padding: 0.36}]"), [["load", "ball"]]);
    assert!(at("link_padding: [{link_name: arm, padding: 0.36}]").is_empty());
    assert!(at("link_scale: [{link_name: tip, scale: 1.87}]").is_empty());
    assert_eq!(at("link_scale: [{link_name: tip, scale: 1.88}]"), [["load", "ball"]]);
    for (padding, pairs) in [(0.09, &[][..]), (0.11, &[["arm", "load"]])] {
        let mut against_itself = world("");
        against_itself.pad(&arm(), padding).unwrap();
        against_itself.padding.retain(|link, _| link == "tip");
        against_itself.padding.values_mut().for_each(|padding| padding.against_robot = true);
        assert_eq!(touching(&against_itself), pairs, "{padding}");
    }
}

#[test]
fn what_a_scene_says_twice_of_one_name_is_refused() {
    let list = "joint_state: {name: [turn, turn], position: [1, 0]}";
    let transform = "{translation: [0, 0, 5], rotation: [0, 0, 0, 1]}";
    let several = format!("joint_names: [v, v], transforms: [{transform}, {transform}]");
    for (text, line, what) in [
        (format!("robot_state: {{{list}}}"), "line 7", "two of value of joint \"turn\""),
        (
            format!("robot_state:\n  multi_dof_joint_state: {{{several}}}"),
            "line 8",
            "two of transform of joint \"v\"",
        ),
        (
            "link_padding: [{link_name: arm, padding: 1},\n  {link_name: arm, padding: 0}]".to_owned(),
            "line 8",
            "two of padding \"arm\"",
        ),
        (
            "link_scale: [{link_name: leg, scale: 2}, {link_name: leg, scale: 1}]".to_owned(),
            "line 7",
            "two of scale \"leg\"",
        ),
        (
            "allowed_collision_matrix: {default_entry_names: [arm, arm], default_entry_values: [false, true]}"
                .to_owned(),
            "line 7",
            "two of default entry \"arm\"",
        ),
    ] {
        assert_refused(&sphere("", &text), &[line, what]);
    }
}

#[test]
fn defaults_of_the_allowed_pairs_hold_where_no_entry_speaks() {
    let at = |matrix: &str| {
        let text = sphere("", &format!("allowed_collision_matrix: {{{matrix}}}"));
        touching(&world_of(&text).unwrap())
    };
    let default = "default_entry_names: [ball], default_entry_values: [true]";
    assert_eq!(at(""), [["base", "ball"]]);
    assert!(at(default).is_empty());
    assert_eq!(at(&default.replace("true", "false")), [["base", "ball"]]);
    let entry = "entry_names: [ball, base], entry_values: [[false, false], [false, false]]";
    assert_eq!(at(&format!("{entry}, {default}")), [["base", "ball"]]);
}

#[test]
fn what_is_removed_is_gone_and_octomaps_planes_and_other_operations_are_refused() {
    let two = |operation: &str| {
        format!("{}    - id: ball\n      operation: {operation}\n", sphere("", ""))
    };
    for remove in ["1", "REMOVE", "remove"] {
        assert!(world_of(&two(remove)).unwrap().obstacles.is_empty());
    }
    let unknown =
        two("1").replace("    - id: ball\n      operation", "    - id: can\n      operation");
    let world = world_of(&unknown).unwrap();
    assert!(world.obstacles.len() == 1 && world.notes[0].contains("\"can\""));
    assert_refused(&two("2"), &["line 7", "operation \"2\""]);
    assert_refused(&two("move"), &["operation \"move\""]);
    assert_refused(&two("0"), &["line 7", "two of object \"ball\""]);
    let octomap = "world: {octomap: {octomap: {data: [1, 2]}}}";
    assert_refused(octomap, &["line 1", "octomap"]);
    assert!(world_of(&octomap.replace("1, 2", "")).is_ok());
    let plane = "world: {collision_objects: [{id: p, planes: [{coef: [0, 0, 1, 0]}]}]}";
    assert_refused(plane, &["\"p\"", "planes"]);
}

#[test]
fn a_mesh_is_its_triangles_and_its_empty_inside_is_reported() {
    let mesh = "world:
  collision_objects:
    - id: sheet
      meshes:
        - vertices: [{x: -9, y: -9, z: 0}, [9, -9, 0], [0, 9, 0]]
          triangles: [{vertex_indices: [0, 1, 2]}]
      mesh_poses: [{position: [0, 0, 0.25], orientation: [0, 0, 0, 1]}]";
    let world = world_of(mesh).unwrap();
    assert!(matches!(world.obstacles[0].shape, Shape::Mesh(_)));
    assert_eq!(touching(&world), [["arm", "sheet"], ["base", "sheet"]]);
    assert!(world.notes[0].contains("surface"), "{:?}", world.notes);
    assert_refused(&mesh.replace("0, 1, 2]}", "0, 1]}"), &["2 corners"]);
    assert_refused(&mesh.replace("0, 1, 2]}", "0, 1, 3]}"), &["sheet"]);
}

#[test]
fn what_makes_no_difference_is_named() {
    let state =
        "robot_state: {joint_state: {name: [turn, stiff], position: [0, 1], velocity: [1, 2]}}
object_colors: [{id: ball, color: {r: 1, g: 0, b: 0, a: 1}}]
robot_model_name: leg
is_diff: true";
    let notes = world_of(&sphere("", state)).unwrap().notes.join("\n");
    for said in
        ["joint velocities", "object_colors", "fixed or mimic others: stiff", "\"leg\"", "is_diff"]
    {
        assert!(notes.contains(said), "{said:?} is not in {notes:?}");
    }
}

#[test]
fn an_obstacle_and_a_link_of_one_name_are_refused() {
    let same = |name: &str| {
        let world = world_of(&sphere("", "").replace("ball", name)).unwrap();
        Workcell::new(arm(), &world, &world.allowed).map(drop)
    };
    assert!(same("leg").is_ok());
    // The tip has no shape, and its name is taken all the same.
    for link in ["arm", "tip"] {
        let refused = same(link).unwrap_err().to_string();
        assert!(refused.contains(&format!("obstacle {link:?}")), "{refused}");
    }
    let world = world_of(&sphere("", &HELD.replace("id: held", "id: ball"))).unwrap();
    let refused = Workcell::new(arm(), &world, &world.allowed).map(drop).unwrap_err().to_string();
    assert!(refused.contains("\"ball\""), "{refused}");
}

#[test]
fn yaml_that_unfolds_or_nests_without_end_is_refused() {
    let mut bomb = String::from("a: &a0 [x, x, x, x, x, x, x, x, x, x]\n");
    for k in 1..12 {
        let parts = vec![format!("*a{}", k - 1); 10].join(", ");
        bomb += &format!("b{k}: &a{k} [{parts}]\n");
    }
    // Where any content may stand, so that it is not refused for what it is.
    let bomb = bomb.replace("\na", "\n  a").replace("\nb", "\n  b");
    assert_refused(&format!("world: {{}}\nobject_colors:\n  {bomb}"), &["no scene"]);
    for (open, close) in [("[", "]"), ("{a: ", "}")] {
        let deep = format!("object_colors: {}{}", open.repeat(100_000), close.repeat(100_000));
        assert_refused(&deep, &["no scene"]);
    }
    let block: String = (0..5_000).map(|depth| format!("{}- \n", " ".repeat(depth))).collect();
    assert_refused(&format!("object_colors:\n{block}"), &["no scene"]);
}

#[test]
fn an_object_in_the_roots_frame_keeps_its_pose_bit_for_bit() {
    let text = sphere("", "").replace("[0, 0, 0.5]", "[0.1, -0.2, 0.3]");
    let pose = world_of(&text).unwrap().obstacles[0].pose;
    assert_eq!(pose, Pose::new(DQuat::IDENTITY, DVec3::new(0.1, -0.2, 0.3)).unwrap());
}

#[test]
fn an_object_whose_geometry_is_elsewhere_is_refused() {
    let bare = "world: {collision_objects: [{id: mug, type: {key: mug, db: objects}}]}";
    assert_refused(bare, &["line 1", "\"mug\"", "no shape"]);
}
