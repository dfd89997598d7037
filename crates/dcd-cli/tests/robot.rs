//! `dcd robot` as a stranger runs it. Tests of the Panda say that they skip where it is absent.
#![allow(missing_docs)]

mod common;

use common::{Folder, dcd};
use dcd_io::data;
use dcd_robot::bounds;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// The folder of the Panda, or the news that the test skips.
fn panda() -> Option<PathBuf> {
    let urdf = data::file("panda/panda.urdf");
    if urdf.is_none() {
        println!("skipped: panda/panda.urdf is not there");
    }
    Some(urdf?.parent()?.to_path_buf())
}

fn text(path: &Path) -> String {
    path.to_str().unwrap().to_owned()
}

/// Three boxes of edge 1, their middles at x = 0, 1.5 and 3.75; joints about z at 1.5 and 2.25.
const ARM: &str = r#"<robot name="arm">
  <link name="base"><collision><geometry><box size="1 1 1"/></geometry></collision></link>
  <link name="upper"><collision><geometry><box size="1 1 1"/></geometry></collision></link>
  <link name="lower"><collision><origin xyz="1.5 0 0"/><geometry><box size="1 1 1"/></geometry></collision></link>
  <joint name="shoulder" type="continuous"><origin xyz="1.5 0 0"/><axis xyz="0 0 1"/>
    <parent link="base"/><child link="upper"/></joint>
  <joint name="elbow" type="continuous"><origin xyz="0.75 0 0"/><axis xyz="0 0 1"/>
    <parent link="upper"/><child link="lower"/></joint>
</robot>"#;

/// A box whose face is at x = 4.25 and a sphere above the base, which it touches in one point.
const WORLD: &str = "world:
  collision_objects:
    - id: wall
      primitives: [{type: box, dimensions: [1, 8, 8]}]
      primitive_poses: [{position: [4.75, 0, 0], orientation: [0, 0, 0, 1]}]
    - id: ball
      primitives: [{type: sphere, dimensions: [0.5]}]
      primitive_poses: [{position: [0, 0, 1], orientation: [0, 0, 0, 1]}]
";

fn touching(arguments: &[&str]) -> Vec<[String; 2]> {
    touching_and_noted(arguments, &[])
}

/// The touching pairs, after asserting that each of these, and no line without one of them, is on
/// standard error.
fn touching_and_noted(arguments: &[&str], notes: &[&str]) -> Vec<[String; 2]> {
    let mut ran = dcd(&[&["robot", "--json"], arguments].concat());
    for note in notes {
        assert!(ran.stderr.contains(note), "{note:?} is not in {ran:?}");
    }
    let expected = |line: &str| notes.iter().any(|note| line.contains(note));
    assert!(ran.stderr.lines().all(expected), "{ran:?}");
    ran.stderr.clear();
    let answer = ran.summary();
    assert_eq!(answer["undecided"], Value::Array(vec![]));
    serde_json::from_value(answer["touching"].clone()).unwrap()
}

fn pairs(names: &[[&str; 2]]) -> Vec<[String; 2]> {
    names.iter().map(|pair| pair.map(str::to_owned)).collect()
}

#[test]
fn an_arm_touches_what_a_hand_computes_touching_faces_included() {
    let folder = Folder::new("arm");
    let (arm, world) = (folder.file("arm.urdf", ARM), folder.file("world.yaml", WORLD));
    // Stretched out, the lower arm's face is exactly the wall's.
    let rest = touching(&[&arm, "--world", &world]);
    assert_eq!(rest, pairs(&[["base", "ball"], ["lower", "wall"]]));
    // The elbow folded back, the lower arm is on the base: not adjacent, so that it is reported.
    let folded = touching(&[&arm, "--state", "elbow=3.141592653589793"]);
    assert_eq!(folded, pairs(&[["base", "lower"]]));
    let srdf = folder.file(
        "arm.srdf",
        r#"<robot name="arm"><disable_collisions link1="lower" link2="base"/></robot>"#,
    );
    // An SRDF says all: what is adjacent is allowed only if it says so.
    let said = touching(&[&arm, "--srdf", &srdf, "--state", "0,3.141592653589793"]);
    assert_eq!(said, pairs(&[["upper", "lower"]]));
    let said = dcd(&["robot", &arm, "--world", &world]);
    assert_eq!(said.stdout, "base and ball touch\nlower and wall touch\n");
    assert_eq!(dcd(&["robot", &arm]).stdout, "nothing touches\n");
}

#[test]
fn a_request_gives_its_start_and_its_goal() {
    let folder = Folder::new("request");
    let arm = folder.file("arm.urdf", ARM);
    let request = folder.file(
        "request.yaml",
        "start_state: {joint_state: {name: [shoulder, elbow], position: [0.5, 0]}}
goal_constraints: [{joint_constraints: [{joint_name: elbow, position: 3.141592653589793}]}]
",
    );
    assert!(touching(&[&arm, "--request", &request]).is_empty());
    let goal = ["--request", &request, "--goal"];
    assert_eq!(touching(&[&[arm.as_str()], &goal[..]].concat()), pairs(&[["base", "lower"]]));
    let start =
        folder.file("start.yaml", "start_state: {joint_state: {name: [elbow], position: [1]}}");
    assert!(touching(&[&arm, "--request", &start]).is_empty());
    dcd(&["robot", &arm, "--request", &start, "--goal"]).assert_refused(&["start.yaml: goal: "]);
}

#[test]
fn bad_input_is_refused_with_its_place_and_value() {
    let folder = Folder::new("bad");
    let arm = folder.file("arm.urdf", ARM);
    let refused = |arguments: &[&str], why: &[&str]| {
        dcd(&[&["robot"], arguments].concat()).assert_refused(why);
    };
    refused(&["no/such.urdf"], &["no/such.urdf"]);
    let broken = folder.file("broken.urdf", "<robot><link></robot>");
    refused(&[&broken], &["broken.urdf", "no URDF", "1:"]);
    let lost = folder.file("lost.urdf", &ARM.replace("parent link=\"upper\"", "parent link=\"u\""));
    refused(&[&lost], &["lost.urdf", "line 7", "joint \"elbow\"", "no link \"u\""]);
    refused(&[&arm, "--state", "1"], &["--state", "1 values", "2 joints move", "shoulder, elbow"]);
    refused(&[&arm, "--state", "1,two"], &["value 1", "\"two\""]);
    refused(&[&arm, "--state", "nan,0"], &["value 0 is NaN"]);
    refused(&[&arm, "--state", "-1,1e400"], &["value 1 is inf"]);
    refused(&[&arm, "--state", "knee=1"], &["no joint \"knee\""]);
    refused(&[&arm, "--state", "elbow=1,2"], &["value 1", "without a joint's name"]);
    let world = folder.file("bad.yaml", &WORLD.replace("dimensions: [0.5]", "dimensions: [-0.5]"));
    refused(&[&arm, "--world", &world], &["bad.yaml", "line 6", "\"ball\"", "-5e-1"]);
    let torn = folder.file("torn.yaml", "world: [");
    refused(&[&arm, "--world", &torn], &["torn.yaml", "no scene"]);
    let srdf = folder.file("bad.srdf", "<robot><disable_collisions link1=\"a\"/></robot>");
    refused(&[&arm, "--srdf", &srdf], &["bad.srdf", "line 1", "link2"]);
    refused(&[&arm, "--all-problems", &arm], &["arm.urdf"]);
}

#[test]
fn the_panda_is_free_where_it_is_ready_and_not_where_it_is_in_its_base() {
    let Some(folder) = panda() else { return };
    let [urdf, srdf] = ["panda.urdf", "panda.srdf"].map(|name| text(&folder.join(name)));
    let notes = ["panda.urdf: not used: 2 contact", "link6.obj: 19 elements with points or lines"];
    let check =
        |state: &str| touching_and_noted(&[&urdf, "--srdf", &srdf, "--state", state], &notes);
    assert!(check("0,-0.785,0,-2.356,0,1.571,0.785").is_empty());
    // The hand bent down through the base.
    let bent = check("0,1.7,0,-3.0,0,0.5,0");
    println!("{bent:?}");
    assert!(!bent.is_empty());
}

/// A cube of edge 2, six quads.
const CUBE: &str =
    "v -1 -1 -1\nv 1 -1 -1\nv -1 1 -1\nv 1 1 -1\nv -1 -1 1\nv 1 -1 1\nv -1 1 1\nv 1 1 1
f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";

#[test]
fn a_sphere_inside_a_link_touches_its_hull_and_not_its_surface() {
    let folder = Folder::new("inside");
    folder.file("cube.obj", CUBE);
    let urdf = folder.file(
        "cube.urdf",
        "<robot name=\"cube\"><link name=\"cube\"><collision><geometry>\
         <mesh filename=\"cube.obj\" scale=\"2 1 1\"/></geometry></collision></link></robot>",
    );
    let world = |x: &str| {
        let text = WORLD.replace("[0, 0, 1]", &format!("[{x}, 0, 0]"));
        folder.file(&format!("world{x}.yaml"), &text)
    };
    let (inside, through) = (world("0.5"), world("1.75"));
    let links = |links, world: &str| touching(&[&urdf, "--world", world, "--links", links]);
    assert_eq!(links("hulls", &inside), pairs(&[["cube", "ball"]]));
    assert!(links("meshes", &inside).is_empty());
    assert_eq!(links("meshes", &through), pairs(&[["cube", "ball"]]));
    dcd(&["robot", &urdf, "--links", "spheres"])
        .assert_refused(&["spheres", "hulls, hulls:N and meshes"]);
    // A link may be otherwise than the rest, and the answer says so.
    let of_links = ["--links", "meshes", "--links-of", "cube=hulls:8"];
    assert_eq!(
        touching(&[&[urdf.as_str(), "--world", &inside][..], &of_links].concat()),
        pairs(&[["cube", "ball"]])
    );
    let json = dcd(&[&["robot", &urdf, "--json"][..], &of_links].concat()).stdout;
    assert!(json.contains(r#""geometry":"meshes","geometry_of":{"cube":"hulls:8"}"#), "{json}");
    let unknown = dcd(&["robot", &urdf, "--links-of", "cub=hulls"]);
    unknown.assert_refused(&["there is no link \"cub\""]);
    let twice = ["--links-of", "cube=hulls", "--links-of", "cube=meshes"];
    dcd(&[&["robot", &urdf][..], &twice].concat())
        .assert_refused(&["--links-of", "link \"cube\" is named twice"]);
    dcd(&["robot", &urdf, "--links", "hulls:7"]).assert_refused(&["link \"cube\"", "7 vertices"]);
}

/// A triangle in the plane of x and y with y up, in COLLADA.
const TRIANGLE: &str = r##"<COLLADA><asset><up_axis>Y_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh><source id="s">
<float_array id="f" count="9">0 0 0 4 0 0 0 4 0</float_array>
<technique_common><accessor source="#f" count="3" stride="3"/></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#s"/></vertices>
<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="w"><node><instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#w"/></scene></COLLADA>"##;

#[test]
fn packages_are_where_they_are_said_to_be_and_the_up_axis_as_requested() {
    let folder = Folder::new("packages");
    let elsewhere = Folder::new("elsewhere");
    let mesh = elsewhere.file("flat.dae", TRIANGLE);
    let urdf = folder.file(
        "flat.urdf",
        "<robot name=\"flat\"><link name=\"flat\"><collision><geometry>\
         <mesh filename=\"package://flat_description/flat.dae\"/></geometry></collision></link></robot>",
    );
    // A sphere round (0, 0, 3): where the triangle is if y is turned to z.
    let world = folder.file("up.yaml", &WORLD.replace("[0, 0, 1]", "[0, 0, 3]"));
    dcd(&["robot", &urdf]).assert_refused(&["flat.urdf", "looked for", "--package NAME=DIR"]);
    let package = format!("flat_description={}", text(&elsewhere.0));
    let run = |up: &[&str]| {
        let always =
            ["robot", &urdf, "--package", &package, "--world", &world, "--links", "meshes"];
        dcd(&[&always[..], up].concat())
    };
    for (arguments, answer) in [
        (&[][..], "nothing touches\n"),
        (&["--up-axis", "ros"], "nothing touches\n"),
        (&["--up-axis", "file"], "flat and ball touch\n"),
    ] {
        let ran = run(arguments);
        assert_eq!(ran.stdout, answer, "{arguments:?}");
        for part in ["flat.dae", "Y_UP", "--up-axis"] {
            assert!(ran.stderr.contains(part), "{part}: {}", ran.stderr);
        }
    }
    dcd(&["robot", &urdf, "--package", "no_folder"]).assert_refused(&["--package", "NAME=DIR"]);
    std::fs::write(&mesh, TRIANGLE.replace("<instance_geometry", "<instance_controller")).unwrap();
    run(&[]).assert_refused(&[
        "flat.urdf",
        "flat.dae",
        "link \"flat\"",
        "<instance_controller>",
        "line 8",
    ]);
}

/// The whole archive: some seconds, for tests are optimised.
#[test]
fn every_state_of_the_archive_is_answered_as_by_parry_but_for_judged_differences() {
    answered_as_parry("hulls");
}

#[test]
fn links_as_meshes_are_answered_as_parrys_meshes_but_for_judged_differences() {
    answered_as_parry("meshes");
}

fn answered_as_parry(links: &str) {
    let Some(folder) = panda() else { return };
    let archive = folder.join("problems.tar.bz2");
    if !archive.is_file() {
        println!("skipped: panda/problems.tar.bz2 is not there");
        return;
    }
    let [urdf, srdf] = ["panda.urdf", "panda.srdf"].map(|name| text(&folder.join(name)));
    let archive = text(&archive);
    let all = ["robot", &urdf, "--srdf", &srdf, "--links", links, "--json"];
    let all = [&all[..], &["--all-problems", &archive]].concat();
    let mut ran = dcd(&all);
    for note in [
        "panda.urdf: not used: 2 contact",
        "in 700 problems: scene: not used: values of joints that are fixed or mimic others: \
         panda_finger_joint1, panda_finger_joint2",
        "in 700 problems: request: not used: allowed_planning_time",
    ] {
        assert!(ran.stderr.contains(note), "{note:?} is not in {:?}", ran.stderr);
    }
    ran.stderr.clear();
    let checked = ran.summary();
    let number = |what: &str| checked[what].as_u64().unwrap();
    assert_eq!((number("problems"), number("states")), (700, 70_000));
    assert!(number("contacts") > 10_000 && number("in_contact") > 10_000);
    // As those who made the problems promise.
    assert_eq!((number("starts_in_contact"), number("goals_in_contact")), (0, 0));
    assert_eq!(number("undecided"), 0);
    for difference in checked["differences"].as_array().unwrap() {
        println!("{difference}");
        let truth = difference["truth"].as_str().unwrap();
        let right = if difference["we_say"] == "touching" { "touching" } else { "apart" };
        assert!(truth == right || truth == "open", "{difference}");
    }
}

#[test]
fn a_sphere_named_like_a_link_is_refused_and_under_another_name_it_touches() {
    let folder = Folder::new("names");
    let arm = folder.file("arm.urdf", ARM);
    let world = |name: &str| folder.file(&format!("{name}.yaml"), &WORLD.replace("ball", name));
    let same = dcd(&["robot", &arm, "--world", &world("upper")]);
    same.assert_refused(&["upper.yaml: obstacle \"upper\"", "a link of robot \"arm\""]);
    let other = touching(&[&arm, "--world", &world("b")]);
    assert_eq!(other, pairs(&[["base", "b"], ["lower", "wall"]]));
    dcd(&["robot", &arm, "--world", &world("wall")]).assert_refused(&["line 6", "\"wall\""]);
}

#[test]
fn a_misspelt_world_a_request_in_its_place_and_an_empty_file_are_refused() {
    let folder = Folder::new("typo");
    let arm = folder.file("arm.urdf", ARM);
    for (text, why) in [
        ("world:\n  collision_object:\n    - id: ball\n", "collision_object"),
        ("start_state: {joint_state: {name: [], position: []}}", "start_state"),
        ("", "no scene"),
    ] {
        let world = folder.file("typo.yaml", text);
        dcd(&["robot", &arm, "--world", &world]).assert_refused(&["typo.yaml: no scene", why]);
    }
    let empty = folder.file("empty.yaml", "world: {collision_objects: []}");
    let noted = ["empty.yaml: there is no obstacle in it"];
    assert!(touching_and_noted(&[&arm, "--world", &empty], &noted).is_empty());
}

#[test]
fn a_forest_xacro_and_fifteen_thousand_nested_elements_are_refused_with_exit_code_2() {
    let folder = Folder::new("forest");
    let first = ARM.find("  <joint").unwrap();
    let forest = folder.file("forest.urdf", &(ARM[..first].to_owned() + "</robot>"));
    dcd(&["robot", &forest]).assert_refused(&["line 3", "\"base\" and \"upper\"", "one root"]);
    let xacro = folder.file("arm.xacro", &ARM.replace("1.5 0 0", "${length} 0 0"));
    dcd(&["robot", &xacro]).assert_refused(&["line 4", "${length}", "xacro must be expanded"]);
    let nested = "<x>".repeat(15_000) + &"</x>".repeat(15_000);
    let nested = folder.file("deep.urdf", &ARM.replace("</robot>", &(nested + "</robot>")));
    dcd(&["robot", &nested]).assert_refused(&["deep.urdf: line 9", "64 nested elements"]);
}

#[test]
fn links_of_several_shapes_are_reported_once_and_on_one_line() {
    let folder = Folder::new("once");
    let again = "<collision><geometry><sphere radius=\"0.5\"/></geometry></collision></link>";
    let urdf = ARM.replacen("</link>", again, 1).replace("\"base\"", "\"ba&#10;se\"");
    let arm = folder.file("arm.urdf", &urdf);
    let world = folder.file("world.yaml", &WORLD.replace("[0, 0, 1]", "[0, 0, 0.5]"));
    let said = dcd(&["robot", &arm, "--world", &world]);
    assert_eq!(said.stdout, "ba\\nse and ball touch\nlower and wall touch\n", "{said:?}");
    assert_eq!(touching(&[&arm, "--world", &world]).len(), 2);
}

#[test]
fn a_state_beyond_limits_and_names_that_the_robot_does_not_have_are_warned_of() {
    let folder = Folder::new("limits");
    let limit = "<limit lower=\"-1\" upper=\"1\"/></joint>";
    let arm =
        folder.file("arm.urdf", &ARM.replace("</joint>", limit).replace("continuous", "revolute"));
    let beyond = "state: joint \"elbow\" is at 3.141592653589793e0, beyond its limits -1e0 to 1e0";
    let folded = touching_and_noted(&[&arm, "--state", "elbow=3.141592653589793"], &[beyond]);
    assert_eq!(folded, pairs(&[["base", "lower"]]));
    let srdf = folder.file(
        "arm.srdf",
        "<robot name=\"leg\"><disable_collisions link1=\"lower\" link2=\"knee\"/></robot>",
    );
    let notes = ["it is for robot \"leg\", not \"arm\"", "no such link", "\"knee\""];
    touching_and_noted(&[&arm, "--srdf", &srdf], &notes);
}

#[test]
fn the_scenes_state_holds_until_a_state_or_a_request_says_otherwise() {
    let folder = Folder::new("state");
    let arm = folder.file("arm.urdf", ARM);
    let state = "robot_state: {joint_state: {name: [elbow], position: [3.141592653589793]}}\n";
    let world = folder.file("world.yaml", &(WORLD.replace("4.75", "40") + state));
    let with = |more: &[&str]| touching(&[&[&arm, "--world", &world], more].concat());
    let folded = pairs(&[["base", "ball"], ["base", "lower"]]);
    assert_eq!(with(&[]), folded);
    assert_eq!(with(&["--state", "shoulder=0"]), folded);
    assert_eq!(with(&["--state", "elbow=0"]), pairs(&[["base", "ball"]]));
    let twice = dcd(&["robot", &arm, "--state", "elbow=0,elbow=3"]);
    twice.assert_refused(&["--state", "two values of \"elbow\""]);
    let mimic = "<mimic joint=\"shoulder\"/><parent link=\"upper\"/>";
    let led = folder.file("led.urdf", &ARM.replace("<parent link=\"upper\"/>", mimic));
    dcd(&["robot", &led, "--state", "elbow=0"]).assert_refused(&["\"elbow\" has no value"]);
    dcd(&["robot", &arm, "--padding", "-0.01"]).assert_refused(&["the padding is -1e-2"]);
    let request = folder.file(
        "request.yaml",
        "start_state: {joint_state: {name: [shoulder], position: [0]}}
goal_constraints: [{joint_constraints: [{joint_name: elbow, position: 0}]}]
",
    );
    assert_eq!(with(&["--request", &request]), folded);
    assert_eq!(with(&["--request", &request, "--goal"]), pairs(&[["base", "ball"]]));
    let knee =
        folder.file("knee.yaml", "start_state: {joint_state: {name: [knee], position: [0]}}");
    dcd(&["robot", &arm, "--request", &knee]).assert_refused(&["knee.yaml", "no joint \"knee\""]);
}

/// tar and bzip2 of no file.
const NO_PROBLEM: [u8; 46] = [
    66, 90, 104, 57, 49, 65, 89, 38, 83, 89, 89, 123, 184, 228, 0, 0, 20, 80, 0, 192, 0, 4, 0, 0,
    8, 32, 0, 48, 204, 5, 41, 166, 19, 98, 39, 139, 185, 34, 156, 40, 72, 44, 189, 220, 114, 0,
];

#[test]
fn an_archive_without_a_problem_is_refused() {
    let folder = Folder::new("archive");
    let arm = folder.file("arm.urdf", ARM);
    let archive = folder.0.join("empty.tar.bz2");
    std::fs::write(&archive, NO_PROBLEM).unwrap();
    let refused = dcd(&["robot", &arm, "--all-problems", &text(&archive)]);
    refused.assert_refused(&["empty.tar.bz2", "no archive of problems"]);
}

#[test]
fn the_help_says_which_files_are_opened_and_every_limit() {
    let help = dcd(&["robot", "--help"]).stdout.split_whitespace().collect::<Vec<_>>().join(" ");
    let numbers = [
        bounds::XML_ELEMENTS,
        bounds::NESTING,
        bounds::XML_ATTRIBUTES,
        bounds::XML_NAMESPACES,
        bounds::YAML_NODES,
        bounds::YAML_ALIASES,
        bounds::MESH_FILES,
        bounds::VERTICES,
        bounds::ALLOWED_PAIRS,
    ];
    for number in numbers {
        let digits = number.to_string();
        let grouped = (0..digits.len()).map(|k| {
            let comma = k > 0 && (digits.len() - k) % 3 == 0;
            format!("{}{}", if comma { "," } else { "" }, &digits[k..=k])
        });
        let grouped: String = grouped.collect();
        assert!(help.contains(&grouped), "{grouped} is not in the help");
    }
    assert_eq!(bounds::FILE_BYTES, 64 << 20);
    for said in
        ["64 MiB a file", "lead anywhere", "Files that are opened", "xacro FILE > robot.urdf"]
    {
        assert!(help.contains(said), "{said:?} is not in the help");
    }
}
