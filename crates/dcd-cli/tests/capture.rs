//! `dcd capture` records, `dcd detect --capture` replays.
#![allow(missing_docs)]

mod common;

use common::dcd;
use serde_json::Value;
use std::path::PathBuf;

/// A file that is gone with the test.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str) -> Self {
        Self(std::env::temp_dir().join(format!("dcd-{}-{name}", std::process::id())))
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

fn record(arguments: &[&str], file: &Scratch) {
    let ran = dcd(&[&["capture", "--out", file.path()], arguments].concat());
    assert_eq!((ran.code, ran.stderr.as_str()), (Some(0), ""), "{ran:?}");
}

fn replay(file: &Scratch, arguments: &[&str]) -> Value {
    dcd(&[&["detect", "--json", "--capture", file.path()], arguments].concat()).summary()
}

/// All that a replay says but for times and threads.
fn found(replayed: &Value) -> Vec<(u64, u64, u64, String)> {
    let number = |frame: &Value, what: &str| frame[what].as_u64().unwrap();
    let frames = replayed["frames"].as_array().unwrap().iter();
    frames
        .map(|frame| {
            let digest = frame["digest"].as_str().unwrap().to_owned();
            let [pairs, contacts] = ["pairs", "contacts"].map(|what| number(frame, what));
            (pairs, contacts, number(frame, "undecided"), digest)
        })
        .collect()
}

#[test]
fn a_pile_of_300_frames_replays_with_the_same_bytes_at_one_two_and_three_threads() {
    let file = Scratch::new("pile");
    record(&["--scene", "pile", "--n", "150", "--frames", "300"], &file);
    let one = replay(&file, &["--threads", "1"]);
    assert_eq!(
        (one["objects"].as_u64(), one["precision"].as_str()),
        (Some(151), Some("certified"))
    );
    let frames = found(&one);
    assert_eq!(frames.len(), 300);
    // In the air first, a heap last, and no frame like the one before.
    assert!(frames[0].1 < 50 && frames[299].1 > 250, "{:?} {:?}", frames[0], frames[299]);
    assert!(frames.iter().all(|frame| frame.2 == 0));
    for threads in ["2", "3"] {
        let other = replay(&file, &["--threads", threads]);
        assert_eq!(found(&other), frames, "{threads} threads");
        assert_eq!(other["digest"], one["digest"]);
    }
}

#[test]
fn a_walk_replays_on_every_method_and_its_first_frame_is_the_scene() {
    let file = Scratch::new("walk");
    let scene = ["--scene", "paper", "--n", "300"];
    record(&[&scene[..], &["--frames", "4", "--sigma", "0.02"]].concat(), &file);
    let frames = found(&replay(&file, &[]));
    let first = dcd(&[&["detect", "--json"], &scene[..]].concat()).summary();
    assert_eq!(first["contacts"].as_u64(), Some(frames[0].1));
    for precision in ["f64", "parry-f64"] {
        let other = found(&replay(&file, &["--precision", precision]));
        let counts = |frames: &[(u64, u64, u64, String)]| -> Vec<_> {
            frames.iter().map(|frame| (frame.1, frame.2)).collect()
        };
        assert_eq!(counts(&other), counts(&frames), "{precision}");
    }
    let text = dcd(&["detect", "--capture", file.path()]);
    assert_eq!(text.code, Some(0));
    assert_eq!(text.stdout.lines().count(), 1 + 4 + 1);
}

#[test]
fn a_broken_capture_is_refused_with_its_place() {
    let file = Scratch::new("broken");
    record(&["--scene", "bricks", "--n", "8", "--frames", "2"], &file);
    let whole = std::fs::read(&file.0).unwrap();
    let refused = |bytes: &[u8], why: &[&str]| {
        std::fs::write(&file.0, bytes).unwrap();
        dcd(&["detect", "--capture", file.path()]).assert_refused(why);
    };
    refused(&whole[..whole.len() - 1], &[file.path(), "are left"]);
    refused(b"", &[file.path(), "signature"]);
    let mut version = whole.clone();
    version[8] = 9;
    refused(&version, &[file.path(), "version 9, not 1"]);
    let mut nan = whole.clone();
    let end = nan.len();
    nan[end - 8..].copy_from_slice(&f64::NAN.to_le_bytes());
    refused(&nan, &[file.path(), "frame 1, object 7", "NaN"]);
}

#[test]
fn what_cannot_be_recorded_is_refused() {
    let file = Scratch::new("never");
    let capture =
        |arguments: &[&str]| dcd(&[&["capture", "--out", file.path()], arguments].concat());
    capture(&["--scene", "heap"]).assert_refused(&["heap", "pile"]);
    capture(&["--scene", "paper", "--sigma", "-1"]).assert_refused(&["sigma", "-1"]);
    capture(&["--scene", "pile", "--sigma", "1"]).assert_refused(&["--sigma"]);
    dcd(&["capture", "--scene", "pile", "--out", "/no/such/folder/x"])
        .assert_refused(&["/no/such/folder/x"]);
    dcd(&["detect", "--capture", "/no/such/file"]).assert_refused(&["/no/such/file"]);
}
