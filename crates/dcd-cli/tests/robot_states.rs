//! `dcd robot --states` as a stranger runs it. The test of the Panda says that it skips where it is absent.
#![allow(missing_docs)]

mod common;

use common::{Folder, dcd, lines};
use dcd_io::data;
use serde_json::{Value, json};

/// Three boxes of edge 1, their middles at x = 0, 1.5 and 3.75; joints about z at 1.5 and 2.25.
const ARM: &str = r#"<robot name="arm">
  <link name="base"><collision><geometry><box size="1 1 1"/></geometry></collision></link>
  <link name="upper"><collision><geometry><box size="1 1 1"/></geometry></collision></link>
  <link name="lower"><collision><origin xyz="1.5 0 0"/><geometry><box size="1 1 1"/></geometry></collision></link>
  <joint name="shoulder" type="continuous"><origin xyz="1.5 0 0"/><axis xyz="0 0 1"/>
    <parent link="base"/><child link="upper"/></joint>
  <joint name="elbow" type="revolute"><origin xyz="0.75 0 0"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" effort="1" velocity="1"/><parent link="upper"/><child link="lower"/></joint>
</robot>"#;

/// A box whose face is at x = 4.25.
const WALL: &str = "world:
  collision_objects:
    - id: wall
      primitives: [{type: box, dimensions: [1, 8, 8]}]
      primitive_poses: [{position: [4.75, 0, 0], orientation: [0, 0, 0, 1]}]
";

#[test]
fn a_line_comes_out_for_each_state_and_a_refused_one_does_not_end_the_run() {
    let folder = Folder::new("states");
    let (urdf, wall) = (folder.file("arm.urdf", ARM), folder.file("wall.yaml", WALL));
    let states = r#"{"q": [0, 0]}
{"q": {"elbow": 1.5707963267948966}}
{"q": {"elbow": 4}}
{"q": {"ankle": 0}}
{"q": {"elbow": 1.5707963267948966}, "attached": [{"name": "rod", "link": "upper", "shape": {"box": [6, 0.1, 0.1]}}]}
"#;
    let states = folder.file("states.jsonl", states);
    let ran = dcd(&["robot", &urdf, "--world", &wall, "--states", &states]);
    assert_eq!(ran.code, Some(2), "{ran:?}");
    assert!(ran.stderr.contains("line 3: joint \"elbow\" is at 4e0"), "{ran:?}");
    assert!(ran.stderr.contains("1 of 5 lines refused"), "{ran:?}");
    let found = lines(&ran.stdout);
    let error = found[3]["error"].as_str().unwrap();
    assert!(error.starts_with("line 4: ") && error.contains("ankle"), "{error}");
    assert_eq!(found[0], json!({"state": 0, "free": false, "contacts": [["lower", "wall"]]}));
    assert_eq!(found[1], json!({"state": 1, "free": true, "contacts": []}));
    assert_eq!(found[4]["contacts"], json!([["base", "rod"], ["rod", "wall"]]));
    assert_eq!(found.len(), 5);
}

#[test]
fn the_names_of_a_pair_are_sorted_and_so_are_the_pairs_of_states_and_edges() {
    let folder = Folder::new("sorted");
    let urdf = folder.file("arm.urdf", ARM);
    // Named before every link, the box is the lower link's obstacle and what the upper carries.
    let world = folder.file("a.yaml", &WALL.replace("wall", "a wall"));
    let attached = r#"[{"name": "a rod", "link": "upper", "shape": {"box": [6, 0.1, 0.1]}}]"#;
    let states = format!("{{\"q\": [0, 0], \"attached\": {attached}}}\n");
    let states = folder.file("states.jsonl", &states);
    let ran = dcd(&["robot", &urdf, "--world", &world, "--states", &states]);
    let contacts =
        [["a rod", "a wall"], ["a rod", "base"], ["a rod", "lower"], ["a wall", "lower"]];
    assert_eq!(lines(&ran.stdout)[0]["contacts"], json!(contacts), "{ran:?}");
    let edges = folder.file("edges.jsonl", "{\"from\": [0, 1], \"to\": [0, 0]}\n");
    let ran = dcd(&["robot", &urdf, "--world", &world, "--edges", &edges]);
    assert_eq!(lines(&ran.stdout)[0]["pair"], json!(["a wall", "lower"]), "{ran:?}");
}

#[test]
fn an_empty_line_is_refused_as_the_line_that_it_is() {
    let folder = Folder::new("empty");
    let urdf = folder.file("arm.urdf", ARM);
    let states = folder.file("states.jsonl", "\n{\"q\": [0, 1]\n");
    let ran = dcd(&["robot", &urdf, "--links", "meshes", "--states", &states]);
    let errors: Vec<Value> = lines(&ran.stdout).iter().map(|line| line["error"].clone()).collect();
    assert_eq!(errors[0], "line 1: no state: EOF while parsing a value");
    assert_eq!(errors[1], "line 2: no state: EOF while parsing an object");
    assert!(ran.stderr.contains("meshes are taken as their triangles"), "{ran:?}");
}

#[test]
fn a_clearance_is_reported_with_its_pair_and_its_derivatives() {
    let folder = Folder::new("clearance");
    let (urdf, wall) = (folder.file("arm.urdf", ARM), folder.file("wall.yaml", WALL));
    let states = folder.file("states.jsonl", "{\"q\": [0, 1.5707963267948966]}\n{\"q\": [0, 0]}\n");
    let arguments = ["robot", &urdf, "--world", &wall, "--states", &states, "--clearance"];
    let ran = dcd(&arguments);
    assert!(ran.stderr.contains("meshes are taken as hulls"), "{ran:?}");
    let found = lines(&ran.stdout);
    // Neighbours do not count. From base's edge at (0.5, 0.5) to lower's at (1.75, 1), which turns about the
    // elbow at x = 2.25 and the shoulder at 1.5.
    let (clearance, distance) = (&found[0]["clearance"], 1.25f64.hypot(0.5));
    let near = |value: &Value, due: f64| (value.as_f64().unwrap() - due).abs() < 1e-9;
    assert!(near(&clearance["distance"], distance) && found[0]["free"] == true, "{clearance}");
    assert!(clearance["error_bound"].as_f64().unwrap() < 1e-12, "{clearance}");
    let slope = |joint: &str, x: f64| {
        let due = (-1.25 + 0.5 * (1.75 - x)) / distance;
        near(&clearance["gradient"][joint], due)
    };
    assert!(slope("elbow", 2.25) && slope("shoulder", 1.5), "{clearance}");
    let pair = (&clearance["pair"][0], &clearance["pair"][1]);
    assert_eq!((pair.0.as_str(), pair.1.as_str()), (Some("base"), Some("lower")), "{clearance}");
    let deep = &found[1]["clearance"];
    assert!(near(&deep["distance"], 0.0) && found[1]["free"] == false, "{deep}");
    assert_eq!(deep["pair"], json!(["lower", "wall"]));
    // A padded link is another object, behind the obstacles; its normal points from the first name to the other all the same.
    let padded = dcd(&[&arguments[..], &["--padding", "0.1"]].concat());
    let deep = &lines(&padded.stdout)[1]["clearance"];
    assert!(near(&deep["distance"], -0.1) && near(&deep["normal"][0], 1.0), "{deep}");
    assert_eq!(deep["pair"], json!(["lower", "wall"]));
    assert!(near(&deep["point_a"][0], 4.35) && near(&deep["point_b"][0], 4.25), "{deep}");
    let alone = dcd(&["robot", &urdf, "--clearance"]);
    assert_eq!(alone.code, Some(2), "{alone:?}");
}

#[test]
fn a_world_as_text_is_the_same_world() {
    let folder = Folder::new("scene-text");
    let (urdf, wall) = (folder.file("arm.urdf", ARM), folder.file("wall.yaml", WALL));
    let text = "wall\n* wall\n1\nbox\n1 8 8\n4.75 0 0\n0 0 0 1\n0 0 0 0\n.\n";
    let scene = folder.file("wall.scene", text);
    let states = folder.file("states.jsonl", "{\"q\": [0, 0]}\n{\"q\": [0, 1.5]}\n");
    let [yaml, text] = [&wall, &scene].map(|world| {
        let ran = dcd(&["robot", &urdf, "--world", world, "--states", &states]);
        assert_eq!(ran.code, Some(0), "{ran:?}");
        lines(&ran.stdout)
    });
    assert_eq!(yaml, text);
    assert_eq!(text[0]["contacts"], json!([["lower", "wall"]]));
}

#[test]
fn padding_is_against_the_world_alone() {
    let folder = Folder::new("padding");
    let (urdf, wall) = (folder.file("arm.urdf", ARM), folder.file("wall.yaml", WALL));
    // The lower link's face is at 2.25 + 0.5 + 1.5 - 0.01, where the arm is pushed back by nothing: turned a
    // little, its corner is 2e-2 from the wall.
    let states = folder.file("states.jsonl", "{\"q\": [0, 2.2]}\n{\"q\": [0, 1.2]}\n");
    let free = |more: &[&str]| {
        let ran = dcd(&[&["robot", &urdf, "--world", &wall, "--states", &states], more].concat());
        assert_eq!(ran.code, Some(0), "{ran:?}");
        lines(&ran.stdout).iter().map(|line| line["free"].clone()).collect::<Vec<_>>()
    };
    assert_eq!(free(&[]), [true, true]);
    let padded = free(&["--padding", "1.0"]);
    // Against itself the arm is as it is built: padded by a metre, all its links would meet.
    assert_eq!(padded, [json!(true), json!(false)]);
    // Unless requested.
    assert_eq!(free(&["--padding", "1.0", "--pad-self"]), [json!(false), json!(false)]);
    let refused = dcd(&["robot", &urdf, "--padding", "-1"]);
    assert!(refused.code == Some(2) && refused.stderr.contains("-1"), "{refused:?}");
}

#[test]
fn an_empty_file_and_one_that_is_not_there_are_refused() {
    let folder = Folder::new("none");
    let urdf = folder.file("arm.urdf", ARM);
    let empty = folder.file("empty.jsonl", "");
    let ran = dcd(&["robot", &urdf, "--states", &empty]);
    assert!(ran.code == Some(2) && ran.stderr.contains("there are no states in it"), "{ran:?}");
    let ran = dcd(&["robot", &urdf, "--states", "not-there.jsonl"]);
    assert!(ran.code == Some(2) && ran.stderr.contains("not-there.jsonl"), "{ran:?}");
}

#[test]
fn many_states_of_the_panda_are_answered_as_one_by_one() {
    let Some(urdf) = data::file("panda/panda.urdf") else {
        println!("skipped: panda/panda.urdf is not there");
        return;
    };
    let (srdf, urdf) = (urdf.with_extension("srdf"), urdf.to_str().unwrap().to_owned());
    let srdf = srdf.to_str().unwrap();
    let folder = Folder::new("panda");
    let state = |k: usize| -> Vec<f64> {
        (0..7).map(|j| ((k * 7 + j * 3) % 23) as f64 * 0.2 - 1.1).collect()
    };
    let text: String = (0..200).map(|k| format!("{{\"q\": {:?}}}\n", state(k))).collect();
    let ran = dcd(&["robot", &urdf, "--srdf", srdf, "--states", &folder.file("s.jsonl", &text)]);
    let found = lines(&ran.stdout);
    assert_eq!(found.len(), 200, "{}", ran.stderr);
    for k in [0, 31, 32, 77, 199] {
        let values: Vec<String> = state(k).iter().map(f64::to_string).collect();
        let one = dcd(&["robot", &urdf, "--srdf", srdf, "--json", "--state", &values.join(",")]);
        assert_eq!(one.code, Some(0), "{one:?}");
        let one: Value = serde_json::from_str(&one.stdout).unwrap();
        let touching: Vec<[String; 2]> = serde_json::from_value(one["touching"].clone()).unwrap();
        let mut touching = touching.into_iter().map(sorted).collect::<Vec<_>>();
        touching.sort();
        assert_eq!(found[k]["contacts"], json!(touching), "{k}");
        assert_eq!(found[k]["free"], json!(one["touching"] == json!([])), "{k}");
    }
}

fn sorted(mut pair: [String; 2]) -> [String; 2] {
    pair.sort();
    pair
}

/// A chain of links of three spheres each, so many.
fn chain_of_spheres(links: usize) -> String {
    let sphere = |k: usize| {
        let z = 0.1 * k as f64;
        format!(
            r#"<collision><origin xyz="0 0 {z}"/><geometry><sphere radius="0.0{}"/></geometry></collision>"#,
            6 + k
        )
    };
    let spheres: String = (0..3).map(sphere).collect();
    let link = |k: usize| format!(r#"<link name="l{k}">{spheres}</link>"#);
    let joint = |k: usize| {
        let axis = ["1 0 0", "0 0 1", "0 1 0"][k % 3];
        format!(
            r#"<joint name="j{k}" type="continuous"><origin xyz="0 0 0.42"/><axis xyz="{axis}"/>
            <parent link="l{k}"/><child link="l{}"/></joint>"#,
            k + 1
        )
    };
    let all: String = (0..links).map(link).chain((0..links - 1).map(joint)).collect();
    format!(r#"<robot name="chain">{all}</robot>"#)
}

#[test]
fn many_states_of_a_robot_of_spheres_are_answered_as_few() {
    let folder = Folder::new("spheres");
    let urdf = folder.file("chain.urdf", &chain_of_spheres(6));
    let world = "world:
  collision_objects:
    - id: wall
      primitives: [{type: box, dimensions: [0.2, 4, 4]}, {type: cylinder, dimensions: [2, 0.2]}]
      primitive_poses: [{position: [0.9, 0, 0], orientation: [0, 0, 0, 1]},
        {position: [0, -1.6, 0.5], orientation: [0.6, 0, 0, 0.8]}]
";
    let world = folder.file("wall.yaml", world);
    let mut drawn = 7u64;
    let mut angle = || {
        drawn =
            drawn.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (drawn >> 33) as f64 / f64::from(1u32 << 31) * 5.0 - 2.5
    };
    // Straight, which touches itself and the wall nowhere, and with an angle beyond what lanes take, among others.
    let mut state = |k: usize| -> Vec<f64> {
        let far = if k % 41 == 1 { 50.0 } else { 0.0 };
        (0..5).map(|_| if k.is_multiple_of(37) { 0.0 } else { angle() + far }).collect()
    };
    let states: Vec<String> = (0..600).map(|k| format!("{{\"q\": {:?}}}\n", state(k))).collect();
    let answers = |name: &str, states: &[String]| {
        let file = folder.file(name, &states.concat());
        let ran = dcd(&["robot", &urdf, "--world", &world, "--states", &file]);
        assert_eq!(ran.code, Some(0), "{ran:?}");
        let of = |line: Value| {
            (line["free"].clone(), line["contacts"].clone(), line["undecided"].clone())
        };
        lines(&ran.stdout).into_iter().map(of).collect::<Vec<_>>()
    };
    let together = answers("all.jsonl", &states);
    // So few are not prepared for.
    let apart: Vec<_> = states.chunks(50).flat_map(|few| answers("few.jsonl", few)).collect();
    assert_eq!(together, apart);
    let free = together.iter().filter(|(free, ..)| *free == json!(true)).count();
    assert!((20..580).contains(&free), "{free}");
}

#[test]
fn a_line_without_an_end_ends_the_run_after_the_answers_to_those_before() {
    let folder = Folder::new("endless");
    let urdf = folder.file("arm.urdf", ARM);
    let first = r#"{"q": [0, 0], "from": [0, 0], "to": [0, 1]}"#;
    for (flag, keys, answer) in [("--states", "q", "state"), ("--edges", "from to", "edge")] {
        let mut line: Value = serde_json::from_str(first).unwrap();
        line.as_object_mut().unwrap().retain(|key, _| keys.contains(key.as_str()));
        let path = folder.file("lines.jsonl", &format!("{line}\n{line}\n"));
        let file = std::fs::File::options().write(true).open(&path).unwrap();
        // A hole, which takes no room on the disk.
        file.set_len(dcd_io::LONGEST_LINE + 1000).unwrap();
        let ran = dcd(&["robot", &urdf, flag, &path]);
        assert_eq!(ran.code, Some(2), "{ran:?}");
        assert!(ran.stderr.contains("lines.jsonl: line 3: a line is longer than"), "{ran:?}");
        let found = lines(&ran.stdout);
        assert_eq!((found.len(), &found[1][answer]), (2, &json!(1)), "{ran:?}");
    }
}
