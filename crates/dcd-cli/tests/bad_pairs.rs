//! Every kind of bad pair is refused by `dcd pairs` with a line of its own, and the run goes on.
#![allow(missing_docs)]

mod common;

use common::{dcd, dcd_reading};

const FINE: &str = r#"{"name": "fine", "a": [[0, 0, 0], [0.1, 2, 3]], "pose_a": {"R": [[0, -1, 0], [1, 0, 0], [0, 0, 1]], "t": [4, 5, 6]}, "b": [[1, 1, 1]], "pose_b": {"q": [0, 0, 0, 1], "t": [0, 0, 0]}}"#;

/// Queries a fine pair, the bad one, and a fine one, and asserts that the middle one is refused
/// with that name and with all of `why`, in its own line and on standard error.
#[track_caller]
fn assert_line_refused(bad: &str, name: Option<&str>, why: &[&str]) {
    let text = format!("{FINE}\n{bad}\n{FINE}\n");
    let ran = dcd_reading(text.as_bytes(), &["pairs", "-"]);
    assert_eq!(ran.code, Some(2), "{ran:?}");
    let lines = ran.lines();
    assert_eq!(lines.len(), 3);
    for fine in [&lines[0], &lines[2]] {
        assert_eq!((&fine["name"], &fine["answer"]), (&"fine".into(), &"apart".into()));
    }
    let refused = lines[1].as_object().unwrap();
    assert_eq!(refused.keys().collect::<Vec<_>>(), ["error", "name"]);
    assert_eq!(refused["name"].as_str(), name);
    let error = refused["error"].as_str().unwrap();
    for why in why.iter().chain(&["line 2"]) {
        assert!(error.contains(why) && ran.stderr.contains(why), "{why:?} is not in {ran:?}");
    }
    assert!(ran.stderr.contains("1 of 3 lines"), "{ran:?}");
}

/// The same for a fine line in which `from` is replaced once.
#[track_caller]
fn assert_refused(from: &str, to: &str, why: &[&str]) {
    assert!(FINE.contains(from));
    assert_line_refused(&FINE.replacen(from, to, 1), Some("fine"), why);
}

#[test]
fn nan_and_infinity_anywhere_are_refused_with_place_and_value() {
    for (word, value) in [("NaN", "NaN"), ("Infinity", "inf"), ("-Infinity", "-inf")] {
        assert_refused("0.1", word, &["a: vertex 1", value]);
        assert_refused("[[1, 1, 1]]", &format!("[[1, {word}, 1]]"), &["b: vertex 0", value]);
        assert_refused("[0, -1, 0]", &format!("[0, -1, {word}]"), &["pose_a", value]);
        assert_refused("[4, 5, 6]", &format!("[4, 5, {word}]"), &["pose_a", value]);
        assert_refused("[0, 0, 0, 1]", &format!("[{word}, 0, 0, 1]"), &["pose_b", value]);
        assert_refused(r#""t": [0, 0, 0]"#, &format!(r#""t": [0, {word}, 0]"#), &["pose_b", value]);
    }
    assert_refused("0.1", "1e999", &["number out of range", "column"]);
}

#[test]
fn a_zero_or_unnormalised_quaternion_is_refused_with_its_length() {
    assert_refused("[0, 0, 0, 1]", "[0, 0, 0, 0]", &["pose_b", "|q|² = 0e0, not 1"]);
    assert_refused("[0, 0, 0, 1]", "[0, 2, 0, 0]", &["pose_b", "|q|² = 4e0, not 1"]);
    assert_refused("[0, 0, 0, 1]", "[0, 0, 0, 1.000001]", &["pose_b", "|q|² = 1.0000020"]);
}

#[test]
fn a_matrix_that_is_no_rotation_is_refused_with_how_far_off_it_is() {
    assert_refused("[0, -1, 0]", "[0, -1, 0.5]", &["pose_a", "no rotation", "5e-1"]);
    assert_refused("[0, -1, 0]", "[0, -2, 0]", &["pose_a", "no rotation", "3"]);
    assert_refused("[0, -1, 0]", "[0, 0, 0]", &["pose_a", "no rotation", "1"]);
    assert_refused("[0, -1, 0]", "[0, 1, 0]", &["pose_a", "determinant is -1"]);
}

#[test]
fn an_empty_set_is_refused() {
    assert_refused("[[1, 1, 1]]", "[]", &["b: ", "no point"]);
}

#[test]
fn lengths_that_differ_from_three_are_refused_with_their_place() {
    assert_refused("[0.1, 2, 3]", "[0.1, 2]", &["invalid length 2", "column"]);
    assert_refused("[0.1, 2, 3]", "[0.1, 2, 3, 4]", &["column"]);
    assert_refused("[[0, -1, 0], ", "[", &["invalid length 2"]);
    assert_refused("[0, 0, 0, 1]", "[0, 0, 1]", &["invalid length 3"]);
    assert_refused("[4, 5, 6]", "[4, 5]", &["invalid length 2"]);
}

#[test]
fn keys_that_lack_or_hold_something_else_are_refused_by_name() {
    assert_refused(r#""a""#, r#""_c""#, &["missing field `a`"]);
    assert_refused(r#""t": [4, 5, 6]"#, r#""_u": 1"#, &["missing field `t`"]);
    assert_refused(r#""q""#, r#""_p""#, &["pose_b", "neither R nor q"]);
    assert_refused("0.1", "\"0.1\"", &["expected a number"]);
    assert_refused("0.1", "null", &["expected a number"]);
}

#[test]
fn a_line_that_is_no_object_is_refused_without_a_name() {
    for line in ["", "[]", "7", "{", "null", "]}", "{\"a\": [[1, 2, 3"] {
        assert_line_refused(line, None, &[]);
    }
}

#[test]
fn a_line_cut_short_keeps_its_name_and_says_where_it_ends() {
    let ran = dcd_reading(&FINE.as_bytes()[..100], &["pairs", "-"]);
    assert_eq!(ran.code, Some(2));
    let line = &ran.lines()[0];
    assert_eq!(line["name"], "fine");
    assert!(line["error"].as_str().unwrap().contains("EOF"), "{ran:?}");
}

#[test]
fn a_line_that_is_no_text_is_refused_and_the_run_goes_on() {
    let bytes = [b"\xff\xfe\x00\n", FINE.as_bytes()].concat();
    let ran = dcd_reading(&bytes, &["pairs", "-"]);
    assert_eq!(ran.code, Some(2));
    let lines = ran.lines();
    assert!(lines[0]["error"].as_str().unwrap().starts_with("line 1: "));
    assert_eq!(lines[1]["answer"], "apart");
}

#[test]
fn every_method_and_query_survives_extreme_but_finite_numbers() {
    let mut text = String::new();
    for size in ["1e308", "-1.7e308", "1e160", "1e-160", "1e-308", "5e-324"] {
        text += &FINE.replacen("0.1", size, 1).replacen('\n', "", 1);
        text.push('\n');
        text += &FINE.replace("[4, 5, 6]", &format!("[{size}, {size}, 1]"));
        text.push('\n');
    }
    for query in ["boolean", "distance", "depth"] {
        for [flag, way] in common::ways(query) {
            let ran = dcd_reading(text.as_bytes(), &["pairs", "-", flag, way, "--query", query]);
            let answers = ran.answers();
            assert_eq!(answers.len(), 12);
            // What is no finite number is printed as null.
            assert!(!ran.stdout.contains("null"), "{way} {query}: {}", ran.stdout);
            if way == "certified" {
                assert!(answers.iter().all(|line| line["answer"] != "undecided"), "{ran:?}");
            }
        }
    }
}

#[test]
fn an_unreadable_file_is_refused_with_its_name() {
    dcd(&["pairs", "no/such/file"]).assert_refused(&["no/such/file"]);
    dcd(&["pairs", env!("CARGO_MANIFEST_DIR")]).assert_refused(&[env!("CARGO_MANIFEST_DIR")]);
}

#[test]
fn bad_usage_is_refused_with_what_was_given() {
    for (arguments, why) in [
        (&["pairs"][..], "<FILE>"),
        (&["pairs", "-", "--precision", "slow"], "'slow'"),
        (&["pairs", "-", "--query", "volume"], "'volume'"),
        (&["pairs", "-", "-", "--swap"], "'-'"),
        (&[], "Usage"),
        (&["detct"], "'detct'"),
    ] {
        dcd(arguments).assert_refused(&[why]);
    }
}
