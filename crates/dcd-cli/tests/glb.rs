//! `--glb` writes what was asked about, to be looked at.
#![allow(missing_docs)]

mod common;

use common::dcd;
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
