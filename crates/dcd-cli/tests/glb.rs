//! `--glb` writes what was checked, to be looked at.
#![allow(missing_docs)]

mod common;

use common::{Folder, POST, dcd};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// A file that is gone with the test.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str) -> Self {
        Self(std::env::temp_dir().join(format!("dcd-glb-{}-{name}", std::process::id())))
    }

    fn path(&self) -> &str {
        self.0.to_str().unwrap()
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        std::fs::remove_file(&self.0).ok();
    }
}

/// The JSON chunk of a binary glTF.
fn document(path: &Path) -> Value {
    let bytes = std::fs::read(path).unwrap();
    let u32_at = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!((&bytes[..4], u32_at(4), u32_at(8)), (&b"glTF"[..], 2, bytes.len()));
    serde_json::from_slice(&bytes[20..20 + u32_at(12)]).unwrap()
}

fn names(document: &Value, what: &str) -> Vec<String> {
    let named = document[what].as_array().into_iter().flatten();
    named.filter_map(|one| one["name"].as_str().map(str::to_owned)).collect()
}

#[test]
fn a_scene_is_drawn_with_its_touching_objects_and_contact_points() {
    let file = Scratch::new("scene");
    let bricks = ["detect", "--scene", "bricks", "--n", "27", "--glb", file.path(), "--json"];
    let ran = dcd(&[&bricks[..], &["--query", "manifold"]].concat());
    assert_eq!((ran.code, ran.stderr.as_str()), (Some(0), ""), "{ran:?}");
    let summary: Value = serde_json::from_str(&ran.stdout).unwrap();
    assert!(summary["contacts"].as_u64().unwrap() > 0);
    let drawn = document(&file.0);
    let objects = names(&drawn, "nodes").iter().filter(|name| name.starts_with("object ")).count();
    assert_eq!(objects, 27);
    assert!(names(&drawn, "nodes").contains(&"contacts of frame 0".to_owned()));
    assert!(names(&drawn, "materials").contains(&"touching".to_owned()));
    assert!(drawn.get("animations").is_none());
}

#[test]
fn a_capture_and_its_replay_are_drawn_as_the_same_animation() {
    let [capture, drawn, again] = ["capture", "drawn", "again"].map(Scratch::new);
    let pile = ["capture", "--scene", "pile", "--n", "12", "--frames", "30"];
    let to = ["--out", capture.path(), "--glb", drawn.path()];
    let ran = dcd(&[&pile[..], &to[..]].concat());
    assert_eq!((ran.code, ran.stderr.as_str()), (Some(0), ""), "{ran:?}");
    let ran =
        dcd(&["detect", "--capture", capture.path(), "--glb", again.path(), "--threads", "1"]);
    assert_eq!((ran.code, ran.stderr.as_str()), (Some(0), ""), "{ran:?}");
    assert_eq!(std::fs::read(&drawn.0).unwrap(), std::fs::read(&again.0).unwrap());
    let document = document(&drawn.0);
    let inputs = document["animations"][0]["samplers"].as_array().unwrap().iter();
    for sampler in inputs {
        let accessor = sampler["input"].as_u64().unwrap() as usize;
        assert_eq!(document["accessors"][accessor]["count"], 30);
    }
}

#[test]
fn a_picture_in_place_of_an_input_or_another_output_is_refused() {
    let file = Scratch::new("same");
    let ran = dcd(&[
        "detect",
        "--scene",
        "bricks",
        "--n",
        "8",
        "--out",
        file.path(),
        "--glb",
        file.path(),
    ]);
    assert_eq!(ran.code, Some(2), "{ran:?}");
    assert!(!file.0.exists());
}

/// A bar of length 2 that turns about z with its end on the axis, and a hand that is carried by it.
const ARM: &str = r#"<robot name="arm">
  <link name="base"/>
  <link name="bar"><collision><origin xyz="1 0 0"/><geometry><box size="2 0.1 0.1"/></geometry></collision></link>
  <joint name="turn" type="continuous"><axis xyz="0 0 1"/><parent link="base"/><child link="bar"/></joint>
</robot>"#;

/// A robot's picture, drawn by the command with these arguments behind the robot and its world.
fn drawn(folder: &Folder, arguments: &[&str]) -> Value {
    let (urdf, post) = (folder.file("arm.urdf", ARM), folder.file("post.yaml", POST));
    let glb = folder.file("out.glb", "");
    let ran = dcd(&[&["robot", &urdf, "--world", &post, "--glb", &glb], arguments].concat());
    assert_eq!(ran.code, Some(0), "{ran:?}");
    document(Path::new(&glb))
}

/// How many times of frames an animation has, and how nodes change between them.
fn frames_of(document: &Value) -> (u64, Vec<String>) {
    let samplers = document["animations"][0]["samplers"].as_array().unwrap();
    let times = samplers[0]["input"].as_u64().unwrap() as usize;
    // Written out only where it is not LINEAR.
    let between =
        |sampler: &Value| sampler["interpolation"].as_str().unwrap_or("LINEAR").to_owned();
    let mut kinds: Vec<String> = samplers.iter().map(between).collect();
    kinds.sort();
    kinds.dedup();
    (document["accessors"][times]["count"].as_u64().unwrap(), kinds)
}

#[test]
fn a_robot_is_drawn_in_its_world_by_the_names_of_links_and_obstacles() {
    let folder = Folder::new("glb-state");
    let free = drawn(&folder, &["--state", "0"]);
    assert_eq!(names(&free, "nodes"), ["bar", "post", "z up"]);
    assert_eq!(names(&free, "materials"), ["apart", "static"]);
    let hit = drawn(&folder, &["--state", "1.5707963267948966"]);
    assert_eq!(names(&hit, "nodes"), ["bar", "post", "contacts of frame 0", "z up"]);
    assert_eq!(names(&hit, "materials"), ["touching", "contact"]);
    // At 0.05 beside the post a padded bar touches it, and is drawn as it is.
    let padded = drawn(&folder, &["--state", "1.4", "--padding", "0.3"]);
    assert_eq!(names(&padded, "nodes"), ["bar", "post", "contacts of frame 0", "z up"]);
}

#[test]
fn states_are_shown_one_after_the_other_and_edges_as_motions() {
    let folder = Folder::new("glb-lines");
    let states = folder.file("states.jsonl", "{\"q\": [0]}\n{\"q\": [1.6]}\n{\"q\": [3]}\n");
    let shown = drawn(&folder, &["--states", &states]);
    assert_eq!(frames_of(&shown), (3, vec!["STEP".to_owned()]));
    assert!(names(&shown, "nodes").contains(&"contacts of frame 1".to_owned()));
    let edges =
        folder.file("edges.jsonl", "{\"from\": [0], \"to\": [1]}\n{\"from\": [1], \"to\": [2]}\n");
    let moving = drawn(&folder, &["--edges", &edges]);
    // 61 states each, and the one that the second touches in.
    assert_eq!(frames_of(&moving), (123, vec!["LINEAR".to_owned(), "STEP".to_owned()]));
}

#[test]
fn a_picture_of_robots_that_carry_different_things_is_refused_by_its_line() {
    let folder = Folder::new("glb-carried");
    let (urdf, glb) = (folder.file("arm.urdf", ARM), folder.file("out.glb", "as it was"));
    let carried =
        r#"{"q": [1], "attached": [{"name": "cup", "link": "bar", "shape": {"sphere": 0.1}}]}"#;
    let states = folder.file("states.jsonl", &format!("{{\"q\": [0]}}\n{carried}\n"));
    let ran = dcd(&["robot", &urdf, "--states", &states, "--glb", &glb]);
    assert_eq!((ran.code, ran.stdout.lines().count()), (Some(2), 2), "{ran:?}");
    assert!(ran.stderr.contains("--glb: line 2"), "{ran:?}");
    assert_eq!(std::fs::read(&glb).unwrap(), b"as it was");
    let ran = dcd(&["robot", &urdf, "--states", &states, "--glb", &states]);
    assert_eq!(ran.code, Some(2), "{ran:?}");
}
