//! What `dcd pairs` answers and how it is printed.
#![allow(missing_docs)]

mod common;

use common::{ACCURACIES, OUR_PRECISIONS, Ran, cube, dcd, dcd_reading, ways};
use dcd_geom::glam::{DMat3, DVec3};
use dcd_io::RawScene;
use dcd_scenes::SceneSpec;
use serde_json::{Value, json};

const IDENTITY: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Two cubes of edge 1, the second moved by this.
fn cubes(moved: [f64; 3]) -> Value {
    json!({
        "name": format!("{moved:?}"),
        "a": cube([0.5; 3]), "pose_a": {"R": IDENTITY, "t": [0, 0, 0]},
        "b": cube([0.5; 3]), "pose_b": {"R": IDENTITY, "t": moved},
    })
}

/// Neighbours of a seeded scene.
fn neighbours(name: &str, objects: usize) -> Vec<Value> {
    let RawScene { shapes, objects } =
        SceneSpec::parse(name).unwrap().with_objects(objects).with_seed(3).raw().unwrap();
    let points = |k: usize| -> Vec<[f64; 3]> {
        shapes[objects[k].shape as usize].points().iter().map(|p| p.to_array()).collect()
    };
    let pose = |k: usize| {
        let turn = DMat3::from_quat(objects[k].rotation.normalize()).transpose();
        json!({"R": turn.to_cols_array_2d(), "t": objects[k].translation.to_array()})
    };
    let pair = |k: usize| {
        json!({
            "name": k.to_string(),
            "a": points(k), "pose_a": pose(k), "b": points(k + 1), "pose_b": pose(k + 1),
        })
    };
    (0..objects.len() - 1).map(pair).collect()
}

fn run_pairs(pairs: &[Value], arguments: &[&str]) -> Ran {
    let text: Vec<String> = pairs.iter().map(Value::to_string).collect();
    dcd_reading(text.join("\n").as_bytes(), &[&["pairs", "-"], arguments].concat())
}

fn keys(line: &Value) -> Vec<&str> {
    line.as_object().unwrap().keys().map(String::as_str).collect()
}

fn number(line: &Value, key: &str) -> f64 {
    line[key].as_f64().unwrap_or_else(|| panic!("no {key} in {line}"))
}

fn vector(line: &Value, key: &str) -> DVec3 {
    DVec3::from_array([0, 1, 2].map(|axis| line[key][axis].as_f64().unwrap()))
}

#[test]
fn cubes_a_metre_apart_are_at_distance_one() {
    for [flag, way] in ways("distance") {
        let arguments = ["--query", "distance", flag, way];
        let line = run_pairs(&[cubes([2.0, 0.0, 0.0])], &arguments).answers().remove(0);
        assert_eq!((&line["answer"], number(&line, "distance")), (&"apart".into(), 1.0));
        assert!(vector(&line, "normal").abs_diff_eq(DVec3::X, 1e-12), "{line}");
        let [a, b] = ["point_a", "point_b"].map(|key| vector(&line, key));
        assert!((a.x - 0.5).abs() < 1e-12 && (b - a).abs_diff_eq(DVec3::X, 1e-12), "{line}");
    }
}

#[test]
fn cubes_that_overlap_by_a_quarter_are_a_quarter_deep() {
    let arguments = ["--query", "depth"];
    let line = run_pairs(&[cubes([0.75, 0.0, 0.0])], &arguments).answers().remove(0);
    assert_eq!((&line["answer"], number(&line, "depth")), (&"touching".into(), 0.25));
    assert!(number(&line, "error_bound") < 1e-14);
    assert!(vector(&line, "normal").abs_diff_eq(DVec3::X, 1e-12), "{line}");
    let deep = vector(&line, "point_a") - vector(&line, "point_b");
    assert!(deep.abs_diff_eq(DVec3::X * 0.25, 1e-12), "{line}");
}

#[test]
fn cubes_that_just_touch_are_touching_at_distance_and_depth_zero_by_the_exact_method() {
    let pair = [cubes([1.0, 0.5, 0.0])];
    for (query, key) in [("distance", "distance"), ("depth", "depth")] {
        let line = run_pairs(&pair, &["--query", query]).answers().remove(0);
        assert_eq!((&line["answer"], &line["method"]), (&"touching".into(), &"exact".into()));
        assert_eq!(number(&line, key), 0.0);
        assert!(number(&line, "error_bound") < 1e-15);
    }
    let apart = [cubes([1.0f64.next_up(), 0.5, 0.0])];
    let line = run_pairs(&apart, &["--query", "distance"]).answers().remove(0);
    assert_eq!(line["answer"], "apart");
    let off = (number(&line, "distance") - f64::EPSILON).abs();
    assert!(off <= number(&line, "error_bound") && off <= 1e-12 * f64::EPSILON, "{line}");
    // What f64 cannot prove it does not say.
    let line = run_pairs(&pair, &["--precision", "f64"]).answers().remove(0);
    assert_eq!((&line["answer"], &line["method"]), (&"undecided".into(), &"f64".into()));
    assert_eq!(line["reason"], "within rounding");
}

#[test]
fn a_precision_of_yes_or_no_is_refused_for_a_measure() {
    for query in ["distance", "depth", "manifold"] {
        for precision in ["fast", "f64"] {
            let arguments = ["--query", query, "--precision", precision];
            let ran = run_pairs(&[cubes([2.0, 0.0, 0.0])], &arguments);
            ran.assert_refused(&["--precision", precision, "--query boolean alone", "--accuracy"]);
        }
    }
}

#[test]
fn only_what_the_query_requests_is_present() {
    let pairs = [cubes([3.0, 0.0, 0.0]), cubes([0.5, 0.0, 0.0])];
    let way = ["normal", "point_a", "point_b"];
    let base = ["answer", "method", "name"];
    let sorted = |parts: &[&[&'static str]]| {
        let mut keys = parts.concat();
        keys.sort_unstable();
        keys
    };
    for precision in OUR_PRECISIONS {
        let lines = run_pairs(&pairs, &["--precision", precision]).answers();
        assert!(lines.iter().all(|line| keys(line) == base));
    }
    for accuracy in ACCURACIES {
        let lines_of =
            |query| run_pairs(&pairs, &["--accuracy", accuracy, "--query", query]).answers();
        let lines = lines_of("distance");
        assert_eq!(keys(&lines[0]), sorted(&[&base, &way, &["distance", "error_bound"]]));
        assert_eq!(keys(&lines[1]), sorted(&[&base, &["distance", "error_bound"]]));
        assert_eq!(number(&lines[1], "distance"), 0.0);
        let lines = lines_of("depth");
        assert_eq!(keys(&lines[0]), base);
        assert_eq!(keys(&lines[1]), sorted(&[&base, &way, &["depth", "error_bound"]]));
    }
    for precision in ["parry-f32", "parry-f64"] {
        for query in ["boolean", "distance", "depth"] {
            for line in run_pairs(&pairs, &["--precision", precision, "--query", query]).answers() {
                assert!(line["method"] == precision && line.get("error_bound").is_none(), "{line}");
            }
        }
    }
}

#[test]
fn the_boolean_query_is_the_default_and_so_is_the_certified_method() {
    let pairs = neighbours("paper", 20);
    let plain = run_pairs(&pairs, &[]).stdout;
    assert_eq!(
        plain,
        run_pairs(&pairs, &["--query", "boolean", "--precision", "certified"]).stdout
    );
    assert_eq!(plain.lines().count(), 19);
}

/// The line that a mirror shows.
fn mirrored(mut line: Value) -> Value {
    let object = line.as_object_mut().unwrap();
    if let Some(a) = object.remove("point_a") {
        let b = object.insert("point_b".into(), a).unwrap();
        object.insert("point_a".into(), b);
        let normal = &mut object["normal"];
        let negated = [0, 1, 2].map(|axis| -normal[axis].as_f64().unwrap());
        *normal = json!(negated);
    }
    line
}

#[test]
fn the_swapped_answer_is_mirrored_bit_for_bit() {
    let mut pairs = neighbours("paper", 60);
    pairs.extend(neighbours("big-and-small", 60));
    pairs.extend(neighbours("bricks", 30));
    pairs.extend(neighbours("identical", 3));
    for place in [[1.0, 0.0, 0.0], [1.0, 1.0, 1.0], [0.0; 3], [0.25, 0.25, 0.25], [2.0, 2.0, 0.0]] {
        pairs.push(cubes(place));
    }
    let mut kinds = [0; 2];
    for query in ["boolean", "distance", "depth"] {
        for [flag, way] in ways(query).into_iter().filter(|[_, way]| !way.starts_with("parry")) {
            let straight = run_pairs(&pairs, &[flag, way, "--query", query]).answers();
            let swapped = run_pairs(&pairs, &[flag, way, "--query", query, "--swap"]).answers();
            for (straight, swapped) in straight.into_iter().zip(swapped) {
                kinds[0] += usize::from(straight.get("distance").is_some());
                kinds[1] += usize::from(straight.get("depth").is_some());
                // As text, so that the sign of zero counts.
                assert_eq!(mirrored(straight).to_string(), swapped.to_string(), "{way} {query}");
            }
        }
    }
    assert!(kinds.iter().all(|&count| count > 50), "{kinds:?}");
}

#[test]
fn numbers_read_back_to_the_answer_of_the_library() {
    let pairs = neighbours("paper", 40);
    let lines = run_pairs(&pairs, &["--query", "distance"]).answers();
    let mut apart = 0;
    for (pair, line) in pairs.iter().zip(lines) {
        let pair = dcd_io::read_pair(pair.to_string().as_bytes()).unwrap();
        let (a, b) = (pair.a.into(), pair.b.into());
        let a = dcd_gjk::PosedShape { shape: &a, pose: &pair.pose_a };
        let b = dcd_gjk::PosedShape { shape: &b, pose: &pair.pose_b };
        match dcd_gjk::distance::distance(a, b).0 {
            dcd_gjk::DistanceResult::Apart(found) => {
                assert_eq!(number(&line, "distance").to_bits(), found.distance.to_bits());
                assert_eq!(number(&line, "error_bound").to_bits(), found.error_bound.to_bits());
                let bits = |v: DVec3| v.to_array().map(f64::to_bits);
                assert_eq!(bits(vector(&line, "normal")), bits(found.normal));
                assert_eq!(bits(vector(&line, "point_a")), bits(found.point_a));
                assert_eq!(bits(vector(&line, "point_b")), bits(found.point_b));
                apart += 1;
            }
            _ => assert_eq!(line["answer"], "touching"),
        }
    }
    assert!(apart > 10);
}

#[test]
fn distance_and_points_agree_with_each_other_and_with_parry() {
    let pairs = neighbours("paper", 60);
    let ours = run_pairs(&pairs, &["--query", "distance"]).answers();
    let parry = run_pairs(&pairs, &["--query", "distance", "--precision", "parry-f64"]).answers();
    for (ours, parry) in ours.iter().zip(&parry) {
        assert_eq!(ours["answer"], parry["answer"]);
        let distance = number(ours, "distance");
        assert!((distance - number(parry, "distance")).abs() < 1e-9, "{ours} {parry}");
        if distance > 0.0 {
            let way = vector(ours, "point_b") - vector(ours, "point_a");
            assert!((way.length() - distance).abs() < 1e-12, "{ours}");
            assert!(way.abs_diff_eq(vector(ours, "normal") * distance, 1e-12), "{ours}");
        }
    }
}

#[test]
fn a_rotation_may_be_a_quaternion_and_the_matrix_counts_where_both_stand() {
    let half = 0.5f64.sqrt();
    let mut pair = cubes([1.2, 0.0, 0.0]);
    let straight = run_pairs(&[pair.clone()], &["--query", "distance"]).answers().remove(0);
    assert!((number(&straight, "distance") - 0.2).abs() < 1e-12);
    pair["pose_b"]["q"] = json!([0.0, 0.0, (half * 0.5 - 0.25 + 0.5).sqrt(), 0.0]);
    assert_eq!(run_pairs(&[pair.clone()], &["--query", "distance"]).answers()[0], straight);
    // An eighth of a turn brings the edge to the face.
    let eighth = std::f64::consts::PI / 8.0;
    pair["pose_b"] = json!({"q": [0.0, 0.0, eighth.sin(), eighth.cos()], "t": [1.3, 0, 0]});
    let turned = run_pairs(&[pair], &["--query", "distance"]).answers().remove(0);
    assert!((number(&turned, "distance") - (0.8 - half)).abs() < 1e-12, "{turned}");
}

#[test]
fn names_may_be_absent_keys_with_an_underscore_stand_and_lines_may_end_in_carriage_returns() {
    let mut pair = cubes([5.0, 0.0, 0.0]);
    pair.as_object_mut().unwrap().remove("name");
    pair["_truth"] = json!({"distance": [4.0, null]});
    let text = format!("{pair}\r\n{}", cubes([0.0; 3]));
    let lines = dcd_reading(text.as_bytes(), &["pairs", "-"]).answers();
    assert_eq!((&lines[0]["name"], &lines[0]["answer"]), (&Value::Null, &"apart".into()));
    assert_eq!(lines[1]["answer"], "touching");
}

#[test]
fn an_empty_file_has_no_answers_and_a_path_is_read_like_standard_input() {
    assert_eq!(dcd_reading(b"", &["pairs", "-"]).answers(), Vec::<Value>::new());
    let path = format!("{}/one_pair.jsonl", env!("CARGO_TARGET_TMPDIR"));
    let pair = cubes([2.0, 0.0, 0.0]);
    std::fs::write(&path, pair.to_string()).unwrap();
    assert_eq!(dcd(&["pairs", &path]).answers(), run_pairs(&[pair], &[]).answers());
}

#[test]
fn a_reader_that_has_read_enough_ends_the_run_in_silence() {
    use std::io::{BufRead, BufReader, Write};
    use std::process::{Command, Stdio};
    let mut child = Command::new(env!("CARGO_BIN_EXE_dcd"))
        .args(["pairs", "-"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut stdin = child.stdin.take().unwrap();
    let mut stdout = BufReader::new(child.stdout.take().unwrap());
    let pair = format!("{}\n", cubes([2.0, 0.0, 0.0]));
    // Each answer comes before the next pair is there.
    let mut line = String::new();
    for _ in 0..3 {
        line.clear();
        stdin.write_all(pair.as_bytes()).unwrap();
        stdout.read_line(&mut line).unwrap();
        assert!(line.contains("apart"));
    }
    drop(stdout);
    // Another test's child, until it is its own program, holds the reading end open too: an answer or
    // two may still be taken. The run has ended once it takes no pair any more.
    let refused = (0..1 << 16).any(|_| stdin.write_all(pair.as_bytes()).is_err());
    assert!(refused, "it goes on");
    drop(stdin);
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), output.stderr.len()), (Some(1), 0), "{output:?}");
}

#[test]
fn every_accuracy_gives_the_same_verdicts_and_numbers_within_its_bounds() {
    let pairs = neighbours("paper", 1600);
    for (query, key) in [("distance", "distance"), ("depth", "depth")] {
        let certified = run_pairs(&pairs, &["--query", query]).answers();
        let mut measured = 0;
        for accuracy in ["f32", "f64"] {
            let found = run_pairs(&pairs, &["--query", query, "--accuracy", accuracy]).answers();
            let back =
                run_pairs(&pairs, &["--query", query, "--accuracy", accuracy, "--swap"]).answers();
            for ((line, swapped), truth) in found.iter().zip(&back).zip(&certified) {
                assert_eq!(line["answer"], truth["answer"], "{line}");
                if truth[key].is_null() {
                    continue;
                }
                measured += 1;
                let within = number(line, "error_bound") + number(truth, "error_bound");
                assert!((number(line, key) - number(truth, key)).abs() <= within, "{line} {truth}");
                assert!(number(line, "error_bound") < 1e-5, "{line}");
                assert_eq!((&line[key], &line["point_a"]), (&swapped[key], &swapped["point_b"]));
            }
        }
        assert!(measured > 20, "{query}: {measured}");
    }
}

#[test]
fn a_manifold_has_the_corners_of_what_two_faces_share() {
    for accuracy in ["f64", "certified"] {
        let pairs = [cubes([0.75, 0.25, 0.5]), cubes([1.5, 0.0, 0.0])];
        let [touching, apart] =
            &run_pairs(&pairs, &["--query", "manifold", "--accuracy", accuracy]).answers()[..]
        else {
            panic!()
        };
        let points = touching["points"].as_array().unwrap();
        assert_eq!((points.len(), &apart["answer"]), (4, &"apart".into()), "{touching}");
        assert!(apart["points"].is_null() && vector(touching, "normal") == DVec3::X);
        for point in points {
            assert!((number(point, "depth") - 0.25).abs() <= number(touching, "error_bound"));
            let between = vector(point, "point_a") - vector(point, "point_b");
            assert!(between.distance(DVec3::X * 0.25) < 1e-12, "{point}");
        }
    }
    let refused =
        run_pairs(&[cubes([0.5; 3])], &["--query", "manifold", "--precision", "parry-f64"]);
    assert!(refused.code == Some(2) && refused.stderr.contains("parry-f64"), "{refused:?}");
}

#[test]
fn a_distance_that_no_f64_holds_is_bounded_from_below_with_the_reason() {
    let far = cubes([0.0; 3]).to_string().replace("[0,0,0]", "[-1.7e308,0,0]");
    let far = far.replace("[0.0,0.0,0.0]", "[1.7e308,0,0]");
    let far: Value = serde_json::from_str(&far).unwrap();
    let line = &run_pairs(&[far], &["--query", "distance"]).answers()[0];
    assert_eq!((&line["answer"], &line["reason"]), (&"apart".into(), &"out of range".into()));
    assert!(number(line, "distance") == f64::MAX && line["error_bound"].is_null(), "{line}");
}
