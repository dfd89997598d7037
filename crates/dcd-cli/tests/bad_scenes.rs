//! Every kind of bad scene is refused by `dcd detect`: exit code 2, index and value, no panic.
#![allow(missing_docs)]

mod common;

use common::{Hull, Ran, dcd, dcd_reading, hull_file};

const BAD_NUMBERS: [(f64, &str); 3] =
    [(f64::NAN, "NaN"), (f64::INFINITY, "inf"), (f64::NEG_INFINITY, "-inf")];

/// Three cubes, the second one spoilt.
fn spoilt(spoil: impl FnOnce(&mut Hull)) -> Ran {
    let mut hulls: Vec<_> = [0.0, 0.5, 3.0].map(|x| Hull::unit_cube([x, 0.0, 0.0])).into();
    spoil(&mut hulls[1]);
    dcd_reading(&hull_file(&hulls), &["detect", "-"])
}

#[test]
fn the_scene_that_the_tests_spoil_is_fine() {
    assert_eq!(spoilt(|_| ()).code, Some(0));
}

#[test]
fn nan_and_infinity_in_a_vertex_are_refused_with_object_vertex_and_value() {
    for (bad, word) in BAD_NUMBERS {
        for axis in 0..3 {
            let why = ["standard input", "shape 1", "vertex 6", word];
            spoilt(|hull| hull.vertices[6][axis] = bad).assert_refused(&why);
        }
    }
}

#[test]
fn nan_and_infinity_in_a_pose_are_refused_with_object_and_value() {
    for (bad, word) in BAD_NUMBERS {
        for axis in 0..3 {
            spoilt(|hull| hull.translation[axis] = bad).assert_refused(&["object 1", word]);
        }
        for part in 0..4 {
            spoilt(|hull| hull.quaternion[part] = bad).assert_refused(&["object 1", word]);
        }
    }
}

#[test]
fn a_zero_or_unnormalised_quaternion_is_refused_with_its_length() {
    let zero = spoilt(|hull| hull.quaternion = [0.0; 4]);
    zero.assert_refused(&["object 1", "|q|² = 0e0, not 1"]);
    let long = spoilt(|hull| hull.quaternion = [0.0, 0.0, 0.0, 2.0]);
    long.assert_refused(&["object 1", "|q|² = 4e0, not 1"]);
    let huge = spoilt(|hull| hull.quaternion = [0.0, 0.0, 1e200, 0.0]);
    huge.assert_refused(&["object 1", "|q|² = inf, not 1"]);
    let nearly = spoilt(|hull| hull.quaternion[3] = 1.0 + 4e-7);
    assert_eq!(nearly.code, Some(0), "{nearly:?}");
}

#[test]
fn an_empty_hull_is_refused_with_its_index() {
    spoilt(|hull| hull.vertices.clear()).assert_refused(&["shape 1", "no point"]);
}

#[test]
fn an_object_beyond_the_range_of_boxes_is_refused_with_its_reach() {
    spoilt(|hull| hull.translation[2] = 1e39).assert_refused(&["object 1", "reaches 1e39 m"]);
}

#[test]
fn a_triangle_of_a_vertex_that_is_not_there_is_refused_with_both() {
    let lost = spoilt(|hull| hull.triangles = vec![[0, 1, 2], [0, 8, 2]]);
    lost.assert_refused(&["object 1", "refers to 8", "there are 8"]);
}

/// The file of two cubes with a triangle each, with the place where each section begins and what
/// it is called.
fn sections() -> (Vec<u8>, Vec<(usize, &'static str)>) {
    let mut hull = Hull::unit_cube([0.0; 3]);
    hull.triangles.push([0, 1, 2]);
    let mut begins = vec![(0, "count")];
    let mut at = 4;
    for _ in 0..2 {
        for (what, size) in [("counts", 8), ("vertices", 8 * 24), ("triangles", 12), ("pose", 56)] {
            begins.push((at, what));
            at += size;
        }
    }
    let file = hull_file(&[hull.clone(), hull]);
    assert_eq!(file.len(), at);
    (file, begins)
}

#[test]
fn a_file_truncated_in_any_section_is_refused_with_what_is_missing() {
    let (file, begins) = sections();
    let ends = begins.iter().skip(1).map(|&(at, _)| at).chain([file.len()]);
    for (&(begin, what), end) in begins.iter().zip(ends) {
        for cut in [begin, begin + 1, end - 1] {
            let ran = dcd_reading(&file[..cut], &["detect", "-"]);
            // A count that the rest cannot hold is seen before the record itself.
            let early = what != "count" && ran.stderr.contains("the objects of record 0");
            ran.assert_refused(&["record", "bytes", "are left"]);
            assert!(early || ran.stderr.contains(what), "cut at {cut} in {what}: {ran:?}");
        }
    }
}

#[test]
fn an_oversized_file_is_refused_with_where_it_should_end() {
    let (mut file, _) = sections();
    let end = file.len();
    for surplus in [1, 8, 64] {
        file.resize(end + surplus, 0);
        let ran = dcd_reading(&file, &["detect", "-"]);
        ran.assert_refused(&[&format!("{surplus} bytes are left"), &format!("from byte {end} on")]);
    }
}

#[test]
fn counts_that_differ_from_what_is_there_are_refused() {
    let (file, _) = sections();
    let with_count = |at: usize, count: u32| {
        let mut file = file.clone();
        file[at..at + 4].copy_from_slice(&count.to_le_bytes());
        dcd_reading(&file, &["detect", "-"])
    };
    // Objects, then vertices and triangles of the first one.
    for (at, there, most) in [(0, 2, "274877906880"), (4, 8, "103079215080"), (8, 1, "51539607540")]
    {
        with_count(at, there + 1).assert_refused(&[]);
        with_count(at, there - 1).assert_refused(&[]);
        // The largest count is refused before anything is allocated for it.
        with_count(at, u32::MAX).assert_refused(&[most, "bytes"]);
    }
}

#[test]
fn an_unreadable_file_is_refused_with_its_name() {
    dcd(&["detect", "no/such/file"]).assert_refused(&["no/such/file"]);
    dcd(&["detect", env!("CARGO_MANIFEST_DIR")]).assert_refused(&[env!("CARGO_MANIFEST_DIR")]);
    dcd(&["detect", "-"]).assert_refused(&["standard input", "count"]);
}

#[test]
fn a_contact_file_that_cannot_be_made_is_refused_with_its_name() {
    let file = hull_file(&[]);
    let ran = dcd_reading(&file, &["detect", "-", "--out", "no/such/folder/contacts"]);
    ran.assert_refused(&["no/such/folder/contacts"]);
}

#[test]
fn bad_clouds_are_refused_with_their_index() {
    let cloud = |count: u32, numbers: &[f32]| {
        let mut bytes = count.to_le_bytes().to_vec();
        bytes.extend(numbers.iter().flat_map(|x| x.to_le_bytes()));
        bytes
    };
    let refuse = |second: Vec<u8>, why: &[&str]| {
        let file = [cloud(1, &[1.0; 3]), second].concat();
        dcd_reading(&file, &["detect", "--clouds", "-"]).assert_refused(why);
    };
    refuse(cloud(0, &[]), &["cloud 1", "no point"]);
    refuse(cloud(2, &[0.0, f32::NAN, 0.0, 1.0, 1.0, 1.0]), &["cloud 1", "NaN"]);
    refuse(cloud(2, &[0.0; 5]), &["record 1", "24 bytes", "20 are left"]);
    refuse(cloud(u32::MAX, &[0.0; 3]), &["record 1", "51539607540 bytes"]);
    refuse(vec![1, 0], &["record 1", "2 are left"]);
}

#[test]
fn bad_usage_is_refused_with_what_was_given() {
    for (arguments, why) in [
        (&["detect"][..], "--scene"),
        (&["detect", "-", "--threads", "0"], "'0'"),
        (&["detect", "-", "--threads", "1025"], "1025"),
        (&["detect", "-", "--threads", "two"], "'two'"),
        (&["detect", "-", "--repeat", "0"], "'0'"),
        (&["detect", "-", "--precision", "slow"], "'slow'"),
        (&["detect", "-", "--scene", "paper"], "--scene"),
        (&["detect", "-", "--n", "7"], "--n"),
        (&["detect", "--scene", "papier"], "'papier'"),
        (&["detect", "--scene", "paper", "--clouds", "-"], "--clouds"),
        (&["detect", "--scene", "paper", "--n", "4294967296"], "4294967296"),
        (&["detect", "--scene", "paper", "--n=-1"], "-1"),
        (&["detect", "--scene", "paper", "--density", "1"], "--density"),
        (&["detect", "-", "--true-size"], "--true-size"),
        (&["detect", "--clouds", "-", "--density", "0"], "not positive"),
        (&["detect", "--clouds", "-", "--density=NaN"], "not positive"),
        (&["detect", "--clouds", "-", "--density=-inf"], "not positive"),
        (&["detect", "--clouds", "-", "--density", "many"], "no number"),
    ] {
        dcd(arguments).assert_refused(&[why]);
    }
}
