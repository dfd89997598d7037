//! `dcd robot --edges` as a stranger runs it. The test of the Panda says that it skips where it is absent.
#![allow(missing_docs)]

mod common;

use common::{Folder, POST, dcd, lines};
use dcd_io::data;
use dcd_judge::{Replay, Replayed};
use serde_json::json;

/// A slider along x that carries a turning bar of length 2, its end on the axis.
const ARM: &str = r#"<robot name="arm">
  <link name="rail"/>
  <link name="slider"><collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision></link>
  <link name="bar"><collision><origin xyz="1 0 0"/><geometry><box size="2 0.1 0.1"/></geometry></collision></link>
  <joint name="slide" type="prismatic"><axis xyz="1 0 0"/><limit lower="-5" upper="5" effort="1" velocity="1"/>
    <parent link="rail"/><child link="slider"/></joint>
  <joint name="turn" type="continuous"><axis xyz="0 0 1"/><parent link="slider"/><child link="bar"/></joint>
</robot>"#;

#[test]
fn each_edge_is_free_with_a_clearance_or_hit_at_a_parameter() {
    let folder = Folder::new("edges");
    let (urdf, post) = (folder.file("arm.urdf", ARM), folder.file("post.yaml", POST));
    let edges = r#"{"from": [0, 0], "to": [0, 3.141592653589793]}
{"from": [0, 0], "to": [0, -3.141592653589793]}
{"from": {"slide": -4}, "to": {"slide": 4}}
{"from": [0, 6.283185307179586], "to": [0, 0]}
{"control": [[0, 0], [0, -1], [0, -1], [0, 0]]}
{"control": [[0, 0], [0, 8], [0, -1], [0, 0]]}
"#;
    let edges = folder.file("edges.jsonl", edges);
    let ran = dcd(&["robot", &urdf, "--world", &post, "--edges", &edges]);
    assert_eq!(ran.code, Some(0), "{ran:?}");
    let found = lines(&ran.stdout);
    let answers: Vec<_> = found.iter().map(|line| line["answer"].as_str().unwrap()).collect();
    // A full turn back is a full turn: the post is met though both ends are the same place.
    assert_eq!(answers, ["hit", "free", "free", "hit", "free", "hit"]);
    let (t, until) = (found[0]["t"].as_f64().unwrap(), found[0]["free_until"].as_f64().unwrap());
    // The bar's side of half width 0.05 meets the post's corner (0.1, 1.4) at this angle.
    let corner = 1.4f64.atan2(0.1) - (0.05 / 1.4f64.hypot(0.1)).asin();
    let first = corner / std::f64::consts::PI;
    assert!(until <= first && first <= t && until > first - 6e-3, "{until} {first} {t}");
    assert_eq!(found[0]["pair"], json!(["bar", "post"]));
    // Straight under the post all the way: 1.4 from the bar's side.
    let clearance = found[2]["clearance"].as_f64().unwrap();
    assert!(clearance <= 1.3 && clearance > 0.4, "{clearance}");
    assert_eq!(found[2]["free_until"], json!(1.0));
}

/// What the judge says of each line of a certificate.
fn replayed(certificate: &str) -> Vec<Replayed> {
    let mut replay = Replay::default();
    let text = std::fs::read_to_string(certificate).unwrap();
    text.lines().map(|line| replay.line(line).unwrap()).collect()
}

#[test]
fn a_certificate_has_a_proof_of_each_free_edge_and_nothing_of_others() {
    let folder = Folder::new("certificate");
    let (urdf, post) = (folder.file("arm.urdf", ARM), folder.file("post.yaml", POST));
    let carried = r#""attached": [{"name": "rod", "link": "bar", "shape": {"cylinder": [0.05, 0.4]}, "pose": {"xyz": [1, 0.1, 0]}}]"#;
    let edges = format!(
        "{}\n{}\n{}\n{}\n{}\n{}\n",
        r#"{"from": [0, 0], "to": [0, -3.141592653589793]}"#,
        r#"{"from": [0, 0], "to": [0, 3.141592653589793]}"#,
        r#"{"from": [0, 0]}"#,
        r#"{"control": [[0, 0], [0, -1], [0, -1], [0, 0]]}"#,
        format_args!(r#"{{"from": [0, 0], "to": [0, -1], {carried}}}"#),
        r#"{"from": {"slide": -4}, "to": {"slide": 4}}"#,
    );
    let edges = folder.file("edges.jsonl", &edges);
    let out = folder.path("proofs.jsonl");
    let run = ["robot", &urdf, "--world", &post, "--edges", &edges, "--padding", "0.01"];
    let plain = dcd(&run);
    let ran = dcd(&[&run[..], &["--certificate", &out]].concat());
    // The third line is no edge.
    assert_eq!((ran.code, &ran.stdout), (Some(2), &plain.stdout), "{ran:?}");
    let found = replayed(&out);
    let cells = found.iter().filter(|line| matches!(line, Replayed::Cell { .. })).count();
    // What it carries makes it another robot, and again.
    assert_eq!(cells, 3, "{found:?}");
    let edges: Vec<_> =
        found.iter().filter(|line| !matches!(line, Replayed::Cell { .. })).collect();
    for (k, edge) in edges.iter().enumerate() {
        match (k, edge) {
            (1, Replayed::NotFree { edge: 1, answer }) => assert_eq!(answer, "hit"),
            (2, Replayed::NotFree { edge: 2, answer }) => assert_eq!(answer, "error"),
            (_, &&Replayed::Accepted { edge, clearance, planes, .. }) => {
                assert!(edge == k && clearance > 0.01 && planes > 0, "{edge} {clearance}");
            }
            other => panic!("{other:?}"),
        }
    }
    assert_eq!(edges.len(), 6);
    let same = dcd(&[&run[..], &["--certificate", run[5]]].concat());
    assert_eq!(same.code, Some(2), "it would be written over the edges: {same:?}");
    let none = dcd(&["robot", &urdf, "--certificate", &out]);
    assert_eq!(none.code, Some(2), "a certificate without edges: {none:?}");
}

#[test]
fn a_budget_ends_an_edge_undecided_and_what_is_carried_is_part_of_it() {
    let folder = Folder::new("budget");
    let (urdf, post) = (folder.file("arm.urdf", ARM), folder.file("post.yaml", POST));
    let carried = r#""attached": [{"name": "rod", "link": "bar", "shape": {"box": [0.1, 0.1, 3.5]}, "pose": {"xyz": [1, 1, 0]}}]"#;
    let edges = folder.file(
        "edges.jsonl",
        &format!(
            "{{\"from\": [0, -0.2], \"to\": [0, 1.45]}}\n{{\"from\": [0, -0.2], \"to\": [0, 0.8], {carried}}}\n"
        ),
    );
    let ran = dcd(&["robot", &urdf, "--world", &post, "--edges", &edges]);
    assert_eq!(ran.code, Some(0), "{ran:?}");
    let found = lines(&ran.stdout);
    assert_eq!([&found[0]["answer"], &found[1]["answer"]], ["free", "hit"]);
    assert_eq!(found[1]["pair"], json!(["post", "rod"]));
    let ran = dcd(&["robot", &urdf, "--world", &post, "--edges", &edges, "--budget", "2"]);
    let found = lines(&ran.stdout);
    // Both ends are looked at in any case, and the second edge ends in the post.
    assert_eq!(found[1]["answer"], "hit");
    assert_eq!(found[0]["answer"], "undecided", "{}", found[0]);
    assert!(found[0]["reason"].as_str().unwrap().contains("budget"), "{}", found[0]);
    assert_eq!(found[0]["free_until"], found[0]["t"][0]);
}

#[test]
fn what_is_no_edge_is_refused_with_its_line() {
    let folder = Folder::new("refused-edges");
    let urdf = folder.file("arm.urdf", ARM);
    let edges = r#"{"from": [0, 0]}
{"from": [0, 0], "to": [0, 1], "control": []}
{"control": [[0, 0], [0, 1], [1, 1]]}
{"from": [0, 0], "to": [0, 1], "via": [0, 0]}
{"from": [0, 0], "to": [0, 1e999]}
{"from": [0, 0], "to": [0]}
"#;
    let edges = folder.file("edges.jsonl", edges);
    let ran = dcd(&["robot", &urdf, "--edges", &edges]);
    assert_eq!(ran.code, Some(2), "{ran:?}");
    assert!(ran.stderr.contains("6 of 6 lines refused"), "{ran:?}");
    for (k, line) in lines(&ran.stdout).iter().enumerate() {
        let error = line["error"].as_str().unwrap();
        assert!(error.starts_with(&format!("line {}: ", k + 1)), "{error}");
        assert_eq!(line["edge"], k);
    }
    let none = dcd(&["robot", &urdf, "--budget", "5"]);
    assert_eq!(none.code, Some(2), "a budget without edges: {none:?}");
}

#[test]
fn a_free_edge_of_the_panda_has_free_samples() {
    let Some(urdf) = data::file("panda/panda.urdf") else {
        println!("skipped: panda/panda.urdf is not there");
        return;
    };
    let srdf = urdf.with_extension("srdf");
    let (urdf, srdf) = (urdf.to_str().unwrap(), srdf.to_str().unwrap());
    let folder = Folder::new("panda-edges");
    let from = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785];
    let to = [0.6, -0.4, 0.3, -1.9, 0.2, 1.8, 0.4];
    let line = json!({"from": from, "to": to});
    let edges = folder.file("edges.jsonl", &format!("{line}\n"));
    for shapes in ["hulls", "meshes"] {
        let out = folder.path("proofs.jsonl");
        let run = [
            "robot",
            urdf,
            "--srdf",
            srdf,
            "--links",
            shapes,
            "--edges",
            &edges,
            "--certificate",
            &out,
        ];
        let ran = dcd(&run);
        assert_eq!(ran.code, Some(0), "{ran:?}");
        let edge = &lines(&ran.stdout)[0];
        assert_eq!(edge["answer"], "free", "{edge}");
        let found = replayed(&out);
        assert!(
            matches!(found[..], [Replayed::Cell { .. }, Replayed::Accepted { .. }]),
            "{found:?}"
        );
    }
    let states: String = (0..=20)
        .map(|k| {
            let t = f64::from(k) / 20.0;
            let q: Vec<f64> = from.iter().zip(&to).map(|(a, b)| a + t * (b - a)).collect();
            format!("{}\n", json!({ "q": q }))
        })
        .collect();
    let states = folder.file("states.jsonl", &states);
    let ran = dcd(&["robot", urdf, "--srdf", srdf, "--states", &states]);
    assert!(lines(&ran.stdout).iter().all(|line| line["free"] == true), "{ran:?}");
}
