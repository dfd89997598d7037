//! What is too much is refused with exit code 2 before allocation.
#![allow(missing_docs)]

mod common;

use common::{dcd, dcd_reading};
use std::process::Command;

#[test]
fn absurd_counts_are_refused_with_an_estimate() {
    let out = std::env::temp_dir().join("dcd-never-written");
    let out = out.to_str().unwrap();
    for (arguments, why) in [
        (&["detect", "--scene", "paper", "--n", "1000000000000"][..], "5.0e14 bytes"),
        (&["detect", "--scene", "paper", "--n", "4294967295"], "1.3e13 bytes of memory"),
        (&["detect", "--scene", "spheres", "--n", "4294967295"], "2.1e12 bytes of memory"),
        (&["detect", "--scene", "paper", "--repeat", "1000000000000"], "8.0e13 bytes"),
        (&["detect", "--scene", "paper", "--threads", "1000000000000"], "2.0e18 bytes"),
        (&["capture", "--scene", "pile", "--n", "4294967294", "--out", out], "bytes of memory"),
        (
            &["capture", "--scene", "bricks", "--frames", "4294967295", "--out", out],
            "4294967295 frames of 8000 objects take about 3.6e15 bytes",
        ),
    ] {
        dcd(arguments).assert_refused(&[why]);
    }
    assert!(!std::path::Path::new(out).exists());
}

/// The command with so many kilobytes of address space.
#[cfg(target_os = "linux")]
fn within(kilobytes: u32, arguments: &[&str]) -> (Option<i32>, String) {
    let script = format!("ulimit -v {kilobytes}; exec \"$0\" \"$@\"");
    let ran = Command::new("sh")
        .args(["-c", &script, env!("CARGO_BIN_EXE_dcd")])
        .args(arguments)
        .output()
        .unwrap();
    (ran.status.code(), String::from_utf8(ran.stderr).unwrap())
}

#[cfg(target_os = "linux")]
#[test]
fn what_memory_cannot_hold_is_refused_before_allocation() {
    let one = "--threads=1";
    for (arguments, why) in [
        (&["detect", "--scene", "spheres", "--n", "4000000", one][..], "2.0e9 bytes of memory"),
        (&["detect", "--scene", "identical", "--n", "12000", one], "1.2e9 bytes of memory"),
        (&["detect", "/dev/zero", one], "/dev/zero: more than"),
        (&["detect", "--clouds", "/dev/zero", one], "/dev/zero: more than"),
        (&["detect", "--capture", "/dev/zero", one], "/dev/zero: more than"),
    ] {
        let (code, printed) = within(900_000, arguments);
        assert!(code == Some(2) && printed.contains(why), "{arguments:?}: {code:?} {printed}");
    }
    let (code, printed) = within(900_000, &["detect", "--scene", "identical", "--n", "500", one]);
    assert_eq!((code, printed.as_str()), (Some(0), ""));
}

#[test]
fn a_line_that_never_ends_is_refused() {
    if !cfg!(target_os = "linux") {
        return println!("skipped: there is no /dev/zero");
    }
    dcd(&["pairs", "/dev/zero"]).assert_refused(&["/dev/zero", "longer than 268435456 bytes"]);
}

#[test]
fn a_byte_order_mark_before_the_first_pair_is_passed_over() {
    let pair = r#"{"name": "x", "a": [[0, 0, 0]], "pose_a": {"q": [0, 0, 0, 1], "t": [0, 0, 0]}, "b": [[1, 1, 1]], "pose_b": {"q": [0, 0, 0, 1], "t": [0, 0, 0]}}"#;
    let text = format!("\u{feff}{pair}\r\n{pair}\n");
    let lines = dcd_reading(text.as_bytes(), &["pairs", "-"]).answers();
    assert!(lines.len() == 2 && lines.iter().all(|line| line["answer"] == "apart"), "{lines:?}");
}

#[test]
fn control_characters_of_names_are_escaped_in_messages() {
    let escape = "\u{1b}[31mno such\u{7}file";
    for arguments in [&["detect", escape][..], &["pairs", escape], &["detect", "--capture", escape]]
    {
        let ran = dcd(arguments);
        ran.assert_refused(&["\\u{1b}[31mno such\\u{7}file"]);
        assert!(!ran.stderr.contains('\u{1b}'), "{ran:?}");
    }
    let line = r#"{"name": "\u001b[31m", "\u001b[2J": 1}"#;
    let ran = dcd_reading(line.as_bytes(), &["pairs", "-"]);
    assert_eq!(ran.code, Some(2));
    assert!(!ran.stdout.contains('\u{1b}') && !ran.stderr.contains('\u{1b}'), "{ran:?}");
}

/// An archive of no file: 10240 zero bytes, packed.
const EMPTY_ARCHIVE: &[u8] =
    b"\x42\x5a\x68\x39\x31\x41\x59\x26\x53\x59\x59\x7b\xb8\xe4\x00\x00\x14\x50\x00\xc0\
    \x00\x04\x00\x00\x08\x20\x00\x30\xcc\x05\x29\xa6\x13\x62\x27\x8b\xb9\x22\x9c\x28\
    \x48\x2c\xbd\xdc\x72\x00";

/// A robot of one sphere, in a folder that is gone with the test.
#[test]
fn an_archive_without_problems_is_refused_and_no_nan_is_printed() {
    let folder = tempfile::tempdir().unwrap();
    let (urdf, archive) = (folder.path().join("ball.urdf"), folder.path().join("empty.tar.bz2"));
    let sphere = "<robot name=\"ball\"><link name=\"a\"><collision><geometry><sphere radius=\"1\"/>\
                </geometry></collision></link></robot>";
    std::fs::write(&urdf, sphere).unwrap();
    std::fs::write(&archive, EMPTY_ARCHIVE).unwrap();
    let ran = dcd(&["robot", urdf.to_str().unwrap(), "--all-problems", archive.to_str().unwrap()]);
    ran.assert_refused(&["empty.tar.bz2", "holds no scene"]);
}

/// A terminal's bytes while a run of more than two seconds goes on; none if `script` is not there.
#[cfg(target_os = "linux")]
fn on_a_terminal(arguments: &str) -> Option<String> {
    let command = format!("{} {arguments}", env!("CARGO_BIN_EXE_dcd"));
    let ran = Command::new("script").args(["-qec", &command, "/dev/null"]).output().ok()?;
    Some(String::from_utf8_lossy(&ran.stdout).into_owned())
}

#[cfg(target_os = "linux")]
#[test]
fn progress_is_shown_on_a_terminal_once_work_takes_more_than_two_seconds() {
    // Twenty seconds where nothing else runs; the run is not waited for to be quick.
    let long = "detect --scene identical --n 1500 --threads 1 --repeat 60 --json";
    let Some(printed) = on_a_terminal(long) else {
        return println!("skipped: the program script is not there");
    };
    let seconds = |printed: &str| {
        let json = printed.lines().find(|line| line.starts_with('{')).unwrap_or_default();
        let json: serde_json::Value = serde_json::from_str(json).unwrap_or_default();
        60.0 * json["ms"]["total"]["min"].as_f64().unwrap_or(0.0) * 1e-3
    };
    if seconds(&printed) < 2.5 {
        return println!("skipped: this machine is done before progress is due");
    }
    assert!(printed.contains("/60 steps"), "{printed}");
}

#[test]
fn help_says_the_limits() {
    for (arguments, words) in [
        (&["--help"][..], &["whole or not at all", "byte order mark", "an estimate"][..]),
        (&["detect", "--help"], &["1,024", "1,000,000", "4,294,967,295", "1e37", "eighth"]),
        (&["pairs", "--help"], &["268,435,456", "127", "underscore", "byte order mark"]),
        (&["capture", "--help"], &["104 bytes"]),
        (&["robot", "--help"], &["16,777,216", "1,073,741,824"]),
    ] {
        let help = dcd(arguments).stdout.replace('\n', " ");
        for word in words {
            assert!(help.contains(word), "{word:?} is not in {arguments:?}: {help}");
        }
    }
}
