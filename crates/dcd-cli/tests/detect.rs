//! What `dcd detect` finds and how it reports it.
#![allow(missing_docs)]

mod common;

use common::{Hull, PRECISIONS, cube, dcd, dcd_reading, hull_file};
use dcd_io::write_hull_scene;
use dcd_scenes::SceneSpec;
use serde_json::Value;
use std::path::PathBuf;

/// 64-bit FNV-1a of nothing.
const NO_CONTACTS: &str = "cbf29ce484222325";

fn temporary(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name)
}

/// The contacts of a file that `--out` wrote.
fn read_contacts(file: &[u8]) -> Vec<(u32, u32)> {
    let mut words = file.chunks_exact(4).map(|word| u32::from_le_bytes(word.try_into().unwrap()));
    let count = words.next().unwrap();
    let words: Vec<u32> = words.collect();
    let contacts: Vec<_> = words.chunks_exact(2).map(|pair| (pair[0], pair[1])).collect();
    assert_eq!((contacts.len(), file.len()), (count as usize, 4 + 8 * count as usize));
    contacts
}

fn fnv1a(bytes: &[u8]) -> String {
    let hash = bytes.iter().fold(0xcbf2_9ce4_8422_2325u64, |hash, &byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    });
    format!("{hash:016x}")
}

#[test]
fn no_object_and_one_object_are_legal_and_have_no_pair() {
    for objects in [0, 1] {
        let hulls = vec![Hull::unit_cube([1.0, 2.0, 3.0]); objects];
        for precision in PRECISIONS {
            for threads in ["1", "2"] {
                let arguments =
                    ["detect", "-", "--precision", precision, "--threads", threads, "--json"];
                let reported = dcd_reading(&hull_file(&hulls), &arguments).summary();
                for (key, value) in [("objects", objects), ("pairs", 0), ("contacts", 0)] {
                    assert_eq!(reported[key], value, "{key}: {reported}");
                }
                assert_eq!(
                    (&reported["undecided"], &reported["digest"]),
                    (&0.into(), &NO_CONTACTS.into())
                );
            }
        }
    }
}

#[test]
fn touching_cubes_are_a_contact_and_a_hair_apart_they_are_none() {
    let places = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0 + f64::EPSILON, 0.0], [9.0, 0.0, 0.0]];
    let out = temporary("touching_cubes");
    let file = hull_file(&places.map(Hull::unit_cube));
    let arguments = ["detect", "-", "--json", "--out", out.to_str().unwrap()];
    let reported = dcd_reading(&file, &arguments).summary();
    assert_eq!((&reported["objects"], &reported["contacts"]), (&4.into(), &1.into()));
    assert_eq!((&reported["undecided"], &reported["precision"]), (&0.into(), &"certified".into()));
    assert_eq!(read_contacts(&std::fs::read(out).unwrap()), [(0, 1)]);
}

#[test]
fn the_json_has_the_documented_keys_in_order_and_sensible_times() {
    let arguments = ["detect", "--scene", "paper", "--n", "60", "--json", "--repeat", "4"];
    let ran = dcd(&[&arguments[..], &["--threads", "2"]].concat());
    let reported = ran.summary();
    let keys = [
        "objects",
        "pairs",
        "contacts",
        "undecided",
        "threads",
        "precision",
        "ms",
        "peak_rss_bytes",
        "digest",
    ];
    let places = keys.map(|key| ran.stdout.find(&format!("\"{key}\":")).unwrap());
    assert!(
        places.is_sorted() && reported.as_object().unwrap().len() == keys.len(),
        "{}",
        ran.stdout
    );
    assert_eq!(reported["threads"], 2);
    let spread = |stage: &str| {
        let number = |key: &str| reported["ms"][stage][key].as_f64().unwrap();
        (number("min"), number("median"))
    };
    let stages = ["aabbs", "build", "pairs", "narrow"].map(spread);
    let (least, middle) = spread("total");
    assert!(stages.iter().all(|&(min, median)| 0.0 <= min && min <= median && min <= least));
    // The stages are parts of the step.
    assert!(stages.iter().map(|stage| stage.0).sum::<f64>() <= least && least <= middle);
    if cfg!(target_os = "linux") {
        assert!(reported["peak_rss_bytes"].as_u64().unwrap() > 1 << 20);
    }
}

#[test]
fn the_text_reports_what_the_json_reports() {
    let arguments = ["detect", "--scene", "paper", "--n", "60", "--threads", "2"];
    let text = dcd(&arguments).stdout;
    let reported = dcd(&[&arguments[..], &["--json"]].concat()).summary();
    let value = |what: &str| {
        let line = text.lines().find_map(|line| line.strip_prefix(what)).unwrap();
        line.trim().to_owned()
    };
    for (line, key) in
        [("objects", "objects"), ("candidate pairs", "pairs"), ("contacts", "contacts")]
    {
        assert_eq!(value(line), reported[key].to_string());
    }
    assert_eq!(Value::from(value("digest")), reported["digest"]);
    assert_eq!((value("undecided"), value("threads")), ("0".into(), "2".into()));
    assert_eq!(value("precision"), "certified");
}

#[test]
fn the_contact_file_is_sorted_and_the_digest_is_of_its_pairs() {
    let out = temporary("sorted_contacts");
    let arguments = ["detect", "--scene", "paper", "--n", "500", "--json", "--out"];
    let reported = dcd(&[&arguments[..], &[out.to_str().unwrap()]].concat()).summary();
    let file = std::fs::read(out).unwrap();
    let contacts = read_contacts(&file);
    assert!(contacts.len() > 1000 && contacts.is_sorted());
    assert!(contacts.iter().all(|(i, j)| i < j && *j < 500));
    assert!(contacts.windows(2).all(|two| two[0] != two[1]));
    assert_eq!(reported["contacts"], contacts.len());
    assert_eq!(reported["digest"], fnv1a(&file[4..]));
}

#[test]
fn the_digest_is_the_same_at_any_thread_count_and_in_every_repeat() {
    for precision in PRECISIONS {
        let reported = ["1", "2", "3", "7"].map(|threads| {
            let scene =
                ["detect", "--scene", "paper", "--n", "400", "--json", "--precision", precision];
            let reported =
                dcd(&[&scene[..], &["--threads", threads, "--repeat", threads]].concat());
            reported.summary()
        });
        for other in &reported[1..] {
            for key in ["pairs", "contacts", "undecided", "digest"] {
                assert_eq!(other[key], reported[0][key], "{precision}, {key}");
            }
        }
        assert_ne!(reported[0]["digest"], NO_CONTACTS);
    }
}

#[test]
fn methods_that_decide_every_pair_agree() {
    let detect = |precision| {
        dcd(&["detect", "--scene", "paper", "--n", "300", "--json", "--precision", precision])
    };
    let certified = detect("certified").summary();
    for precision in PRECISIONS {
        let reported = detect(precision).summary();
        assert_eq!(reported["precision"], precision);
        if reported["undecided"] == 0 && precision != "parry-f32" {
            assert_eq!(reported["digest"], certified["digest"], "{precision}");
        }
    }
}

#[test]
fn a_scene_that_is_written_and_read_gives_the_same_contacts() {
    // Hulls with their surfaces, cuboids as corners, and one shape for many objects.
    for (name, objects) in [("paper", 200), ("boxes", 300), ("bricks", 500)] {
        let raw = SceneSpec::parse(name).unwrap().with_objects(objects).raw().unwrap();
        let mut file = Vec::new();
        write_hull_scene(&raw, &mut file).unwrap();
        let path = temporary(&format!("written_{name}"));
        std::fs::write(&path, &file).unwrap();
        let count = objects.to_string();
        let seeded = dcd(&["detect", "--scene", name, "--n", &count, "--json"]).summary();
        let read = dcd(&["detect", path.to_str().unwrap(), "--json"]).summary();
        let piped = dcd_reading(&file, &["detect", "-", "--json"]).summary();
        for key in ["objects", "pairs", "contacts", "undecided", "digest"] {
            assert_eq!(read[key], seeded[key], "{name}, {key}");
            assert_eq!(piped[key], seeded[key], "{name}, {key}");
        }
    }
}

#[test]
fn triangles_may_be_absent_and_change_no_answer() {
    let mut hulls = [[0.0; 3], [0.7, 0.2, 0.1]].map(Hull::unit_cube);
    let without = dcd_reading(&hull_file(&hulls), &["detect", "-", "--json"]).summary();
    hulls[0].triangles = vec![[0, 1, 2], [1, 3, 2]];
    let with = dcd_reading(&hull_file(&hulls), &["detect", "-", "--json"]).summary();
    assert_eq!((&with["digest"], &with["contacts"]), (&without["digest"], &1.into()));
}

#[test]
fn flat_needle_like_and_point_like_hulls_are_legal_on_every_method() {
    let mut hulls: Vec<_> = (0..4).map(|_| Hull::unit_cube([0.0; 3])).collect();
    hulls[1].vertices = cube([0.3, 0.3, 0.0]);
    hulls[2].vertices = vec![[0.1, 0.0, 0.0], [0.4, 0.1, 0.0]];
    hulls[3].vertices = vec![[0.2; 3]; 5];
    for precision in PRECISIONS {
        let arguments = ["detect", "-", "--json", "--precision", precision];
        let reported = dcd_reading(&hull_file(&hulls), &arguments).summary();
        let sum = reported["contacts"].as_u64().unwrap() + reported["undecided"].as_u64().unwrap();
        assert!(sum <= reported["pairs"].as_u64().unwrap());
        if precision == "certified" {
            // All in the cube, and the line in the plane; the point is in neither.
            assert_eq!(
                (&reported["contacts"], &reported["undecided"]),
                (&4.into(), &0.into()),
                "{reported}"
            );
        }
    }
}

#[test]
fn the_seed_makes_the_scene() {
    let digest = |seed| {
        let reported = dcd(&["detect", "--scene", "paper", "--n", "100", "--json", "--seed", seed]);
        reported.summary()["digest"].clone()
    };
    assert_eq!(digest("5"), digest("5"));
    assert_ne!(digest("5"), digest("6"));
}

#[test]
fn clouds_become_a_scene_whose_density_is_a_parameter() {
    let cloud = |k: u32| {
        let mut bytes = 8u32.to_le_bytes().to_vec();
        let corners = cube([0.5, 1.0, 0.5 + 0.1 * f64::from(k)]);
        bytes.extend(corners.as_flattened().iter().flat_map(|&x| (x as f32).to_le_bytes()));
        bytes
    };
    let file: Vec<u8> = (0..10).flat_map(cloud).collect();
    let candidates = |density| {
        let arguments = ["detect", "--clouds", "-", "--json", "--n", "2000", "--density", density];
        let reported = dcd_reading(&file, &arguments).summary();
        assert_eq!((&reported["clouds"]["solid"], &reported["undecided"]), (&10.into(), &0.into()));
        reported["pairs"].as_f64().unwrap() / 2000.0
    };
    assert!((candidates("1") - 1.0).abs() < 0.2);
    assert!((candidates("8") - 8.0).abs() < 1.6);
    let every = dcd_reading(&file, &["detect", "--clouds", "-", "--json"]).summary();
    assert_eq!(every["objects"], 10);
    let text = dcd_reading(&file, &["detect", "--clouds", "-", "--true-size"]).stdout;
    assert!(text.contains("10 solid") && text.contains("0 flat"), "{text}");
}

#[test]
fn help_lists_the_formats_the_methods_and_the_exit_codes() {
    let all = dcd(&["--help"]).stdout;
    assert!(all.contains("detect") && all.contains("pairs") && all.contains("Exit codes: 0"));
    let detect = dcd(&["detect", "--help"]).stdout;
    for word in ["little endian", "FNV-1a", "certified", "--repeat", "--out", "sparse", "[default"]
    {
        assert!(detect.contains(word), "{word}");
    }
    let pairs = dcd(&["pairs", "--help"]).stdout;
    for word in ["pose_a", "error_bound", "--swap", "--query", "parry-f32", "exit code is 2"] {
        assert!(pairs.contains(word), "{word}");
    }
}

/// A row of cubes of edge 1, each 0.9 from the last, then one 0.2 away.
fn row() -> Vec<u8> {
    hull_file(&[0.0, 0.9, 1.8, 3.0].map(|x| Hull::unit_cube([x, 0.0, 0.0])))
}

#[test]
fn each_query_writes_its_answers_and_finds_the_same_contacts() {
    for (query, key) in [
        ("depth", "depth"),
        ("manifold", "manifolds"),
        ("distance", "distance"),
        ("gradient", "gradient_a"),
    ] {
        let out = temporary(query);
        let arguments =
            ["detect", "-", "--json", "--query", query, "--answers", out.to_str().unwrap()];
        let reported = dcd_reading(&row(), &arguments).summary();
        assert_eq!(reported["contacts"], 2, "{reported}");
        let text = std::fs::read_to_string(&out).unwrap();
        let lines: Vec<Value> =
            text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        let pairs: Vec<_> = lines.iter().map(|line| (&line["i"], &line["j"])).collect();
        assert_eq!(pairs, [(&0.into(), &1.into()), (&1.into(), &2.into())]);
        assert!(lines.iter().all(|line| !line[key].is_null()), "{text}");
        if query == "manifold" {
            let [patch] = &lines[0]["manifolds"].as_array().unwrap()[..] else { panic!("{text}") };
            assert_eq!(patch["points"].as_array().unwrap().len(), 4);
            assert!((patch["depth"].as_f64().unwrap() - 0.1).abs() < 1e-12);
        }
    }
}

#[test]
fn every_accuracy_has_the_same_contacts_and_numbers_within_its_bounds() {
    for (query, key) in [("depth", "depth"), ("distance", "distance"), ("gradient", "distance")] {
        let detect = |accuracy: &str| {
            let out = temporary(&format!("{query}-{accuracy}"));
            let mut arguments =
                vec!["detect", "--scene", "mixed", "--n", "2000", "--json", "--query", query];
            arguments.extend(["--accuracy", accuracy, "--answers", out.to_str().unwrap()]);
            if query != "depth" {
                arguments.extend(["--margin", "0.05"]);
            }
            let reported = dcd(&arguments).summary();
            let text = std::fs::read_to_string(&out).unwrap();
            let answers: Vec<(f64, f64)> = text
                .lines()
                .map(|line| serde_json::from_str::<Value>(line).unwrap())
                .map(|line| (line[key].as_f64().unwrap(), line["error_bound"].as_f64().unwrap()))
                .collect();
            (reported, answers)
        };
        let (reported, certified) = detect("certified");
        assert!(certified.len() > 100, "{reported}");
        for accuracy in ["f32", "f64"] {
            let (other, answers) = detect(accuracy);
            assert_eq!(other["digest"], reported["digest"]);
            assert_eq!(other["accuracy"], accuracy);
            let bounds = &other["error_bound"];
            let worst = answers.iter().map(|&(_, bound)| bound).fold(0.0, f64::max);
            assert_eq!(bounds["worst"].as_f64().unwrap(), worst);
            assert!(bounds["median"].as_f64() <= bounds["p99"].as_f64(), "{bounds}");
            for ((value, bound), (truth, slack)) in answers.into_iter().zip(&certified) {
                assert!((value - truth).abs() <= bound + slack, "{query} {value} {truth} {bound}");
            }
        }
    }
}

#[test]
fn a_margin_finds_the_pairs_within_it_on_each_of_our_methods() {
    for precision in common::OUR_PRECISIONS {
        for (margin, contacts) in [("0", 2), ("0.1", 2), ("0.25", 3), ("10", 6)] {
            let queries = ["overlap", "distance"];
            let supported = if precision == "certified" { &queries[..] } else { &queries[..1] };
            for query in supported {
                let arguments =
                    ["--precision", precision, "--margin", margin, "--query", query, "--json"];
                let reported = dcd_reading(&row(), &[&["detect", "-"][..], &arguments].concat());
                assert_eq!(
                    reported.summary()["contacts"],
                    contacts,
                    "{precision} {margin} {query}"
                );
            }
        }
    }
}

#[test]
fn a_query_that_its_method_or_margin_rules_out_is_refused_with_both() {
    for (arguments, said) in [
        (["--precision", "parry-f32", "--query", "depth"], "parry-f32"),
        (["--precision", "f64", "--query", "distance"], "--accuracy"),
        (["--precision", "parry-f64", "--margin", "0.1"], "parry-f64"),
        (["--query", "manifold", "--margin", "0.1"], "1e-1"),
        (["--query", "depth", "--mesh-sides", "front"], "--mesh-sides"),
        (["--query", "overlap", "--mesh-edges", "active"], "--mesh-edges"),
        (["--query", "overlap", "--margin", "-1"], "-1"),
        (["--query", "overlap", "--margin", "NaN"], "NaN"),
        (["--query", "overlap", "--margin", "1e38"], "1e38 is not within"),
    ] {
        let ran = dcd_reading(&row(), &[&["detect", "-"][..], &arguments].concat());
        assert_eq!(ran.code, Some(2), "{ran:?}");
        assert!(ran.stderr.contains(said), "{ran:?}");
    }
}
