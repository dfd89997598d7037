//! The command as a stranger runs it, and files to give it.
#![allow(dead_code)] // each test file uses its part

use serde_json::Value;
use std::io::Write;
use std::path::PathBuf;
use std::process::{Command, Stdio};

pub(crate) const PRECISIONS: [&str; 5] = ["fast", "f64", "certified", "parry-f32", "parry-f64"];
pub(crate) const OUR_PRECISIONS: [&str; 3] = ["fast", "f64", "certified"];

pub(crate) const ACCURACIES: [&str; 3] = ["f32", "f64", "certified"];

/// The flags of `dcd pairs` that choose who answers a query, and how.
pub(crate) fn ways(query: &str) -> Vec<[&'static str; 2]> {
    let precisions = |names: &[&'static str]| -> Vec<_> {
        names.iter().map(|name| ["--precision", name]).collect()
    };
    match query {
        "boolean" => precisions(&PRECISIONS),
        _ => {
            let accuracies = ACCURACIES.map(|name| ["--accuracy", name]);
            [&accuracies[..], &precisions(&["certified", "parry-f32", "parry-f64"])].concat()
        }
    }
}

/// A post of edge 0.2 at y = 1.5.
pub(crate) const POST: &str = "world:
  collision_objects:
    - id: post
      primitives: [{type: box, dimensions: [0.2, 0.2, 1]}]
      primitive_poses: [{position: [0, 1.5, 0], orientation: [0, 0, 0, 1]}]
";

/// The values of JSON Lines.
pub(crate) fn lines(text: &str) -> Vec<Value> {
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// What a run left behind.
#[derive(Debug)]
pub(crate) struct Ran {
    /// `None` if a signal ended it.
    pub(crate) code: Option<i32>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

/// Runs `dcd` with nothing on standard input.
pub(crate) fn dcd(arguments: &[&str]) -> Ran {
    dcd_reading(b"", arguments)
}

/// Runs `dcd` with this on standard input.
pub(crate) fn dcd_reading(input: &[u8], arguments: &[&str]) -> Ran {
    let mut child = Command::new(env!("CARGO_BIN_EXE_dcd"))
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut stdin = child.stdin.take().unwrap();
    let output = std::thread::scope(|scope| {
        // Beside the reading, or both pipes could be full. A run that refuses early closes its end.
        scope.spawn(move || stdin.write_all(input).ok());
        child.wait_with_output().unwrap()
    });
    let text = |bytes| String::from_utf8(bytes).unwrap();
    let ran = Ran {
        code: output.status.code(),
        stdout: text(output.stdout),
        stderr: text(output.stderr),
    };
    assert!(!ran.stderr.contains("panicked"), "{arguments:?}: {ran:?}");
    ran
}

impl Ran {
    /// Its lines as JSON, after asserting that all went well.
    pub(crate) fn answers(&self) -> Vec<Value> {
        assert_eq!((self.code, self.stderr.as_str()), (Some(0), ""), "{self:?}");
        self.lines()
    }

    /// Its lines as JSON.
    pub(crate) fn lines(&self) -> Vec<Value> {
        self.stdout.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
    }

    /// Its one JSON object, after asserting that all went well.
    pub(crate) fn summary(&self) -> Value {
        let mut lines = self.answers();
        assert_eq!(lines.len(), 1);
        lines.remove(0)
    }

    /// Asserts that the input was refused without an answer, and that all of `why` stands in the
    /// message.
    pub(crate) fn assert_refused(&self, why: &[&str]) {
        assert_eq!((self.code, self.stdout.as_str()), (Some(2), ""), "{self:?}");
        for why in why {
            assert!(self.stderr.contains(why), "{why:?} is not in {self:?}");
        }
    }
}

/// Files of a robot and its world, in a folder that is gone with the test.
pub(crate) struct Folder(pub(crate) PathBuf);

impl Folder {
    pub(crate) fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("dcd-test-{}-{name}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        Self(folder)
    }

    /// Where a file of that name would be.
    pub(crate) fn path(&self, name: &str) -> String {
        self.0.join(name).to_string_lossy().into_owned()
    }

    pub(crate) fn file(&self, name: &str, content: &str) -> String {
        let path = self.0.join(name);
        std::fs::write(&path, content).unwrap();
        path.to_str().unwrap().to_owned()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        std::fs::remove_dir_all(&self.0).ok();
    }
}

/// One object of a hull scene's file.
#[derive(Clone, Debug)]
pub(crate) struct Hull {
    pub(crate) vertices: Vec<[f64; 3]>,
    pub(crate) triangles: Vec<[u32; 3]>,
    pub(crate) quaternion: [f64; 4],
    pub(crate) translation: [f64; 3],
}

impl Hull {
    /// The cube of edge 1 round its own origin, in place.
    pub(crate) fn unit_cube(translation: [f64; 3]) -> Self {
        Self {
            vertices: cube([0.5; 3]),
            triangles: vec![],
            quaternion: [0.0, 0.0, 0.0, 1.0],
            translation,
        }
    }

    fn write(&self, file: &mut Vec<u8>) {
        file.extend((self.vertices.len() as u32).to_le_bytes());
        file.extend((self.triangles.len() as u32).to_le_bytes());
        let numbers = self.vertices.as_flattened();
        file.extend(numbers.iter().flat_map(|x| x.to_le_bytes()));
        file.extend(self.triangles.as_flattened().iter().flat_map(|k| k.to_le_bytes()));
        let pose = self.quaternion.iter().chain(&self.translation);
        file.extend(pose.flat_map(|x| x.to_le_bytes()));
    }
}

/// The corners of a box round the origin.
pub(crate) fn cube(half: [f64; 3]) -> Vec<[f64; 3]> {
    let sign = |k: u32, bit: u32| if k >> bit & 1 == 0 { -1.0 } else { 1.0 };
    (0..8).map(|k| [0, 1, 2].map(|axis| sign(k, axis) * half[axis as usize])).collect()
}

/// A hull scene's file.
pub(crate) fn hull_file(hulls: &[Hull]) -> Vec<u8> {
    let mut file = (hulls.len() as u32).to_le_bytes().to_vec();
    hulls.iter().for_each(|hull| hull.write(&mut file));
    file
}
