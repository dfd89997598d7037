//! A flag is used or refused, never passed over.
#![allow(missing_docs)]

mod common;

use common::dcd;

/// The flags of `dcd robot` that say what is checked.
const SUBJECTS: [&[&str]; 6] = [
    &["--state", "0,0"],
    &["--states", "states.jsonl"],
    &["--edges", "edges.jsonl"],
    &["--request", "request.yaml"],
    &["--all-problems", "problems.tar.bz2"],
    &["--acm", "out.srdf"],
];

/// What depends on one of them, and on which.
const DEPENDENT: [(&[&str], &str); 6] = [
    (&["--clearance"], "--states"),
    (&["--budget", "3"], "--edges"),
    (&["--certificate", "out.jsonl"], "--edges"),
    (&["--goal"], "--request"),
    (&["--samples", "3"], "--acm"),
    (&["--allow-default"], "--acm"),
];

/// Asserts that these are refused for their flags: there are no such files, which would be refused with
/// their names.
fn assert_refused_together(first: &[&str], one: &[&str], other: &[&str]) {
    let arguments = [first, one, other].concat();
    let ran = dcd(&arguments);
    ran.assert_refused(&[one[0], other[0], "cannot be used with"]);
}

#[test]
fn a_flag_of_dcd_robot_is_refused_beside_what_it_does_not_belong_to() {
    for (flag, of) in DEPENDENT {
        for subject in SUBJECTS.iter().filter(|subject| subject[0] != of) {
            assert_refused_together(&["robot", "no.urdf"], subject, flag);
        }
        dcd(&[&["robot", "no.urdf"], flag].concat()).assert_refused(&["required", of]);
    }
}

#[test]
fn only_one_flag_of_dcd_robot_says_what_is_checked() {
    for (k, one) in SUBJECTS.iter().enumerate() {
        for other in &SUBJECTS[k + 1..] {
            assert_refused_together(&["robot", "no.urdf"], one, other);
        }
    }
}

#[test]
fn flags_of_clouds_are_refused_beside_another_source() {
    for source in [&["--scene", "paper"][..], &["--capture", "no.cap"]] {
        for flag in [&["--density", "3"][..], &["--true-size"]] {
            assert_refused_together(&["detect"], source, flag);
        }
    }
    dcd(&["detect", "no.bin", "--true-size"]).assert_refused(&["--true-size", "FILE"]);
}
