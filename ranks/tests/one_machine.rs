//! The program under mpirun finds what one machine finds, and refuses what it cannot read, on all ranks.

use dcd_exec::Par;
use dcd_geom::Scene;
use dcd_io::write_hull_scene;
use dcd_pipeline::Pipeline;
use dcd_scenes::SceneSpec;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const RANKS: [usize; 5] = [1, 2, 3, 4, 8];

/// Those at which more scenes are looked at: to start many ranks takes seconds.
const FEW: [usize; 2] = [3, 8];

fn mpirun(ranks: usize, arguments: &[&str]) -> Output {
    mpirun_of(Path::new(env!("CARGO_BIN_EXE_dcd-mpi")), ranks, arguments)
}

/// More ranks than cores, and in a container as root: what a test machine is.
fn mpirun_of(program: &Path, ranks: usize, arguments: &[&str]) -> Output {
    Command::new("mpirun")
        .args(["-n", &ranks.to_string()])
        .arg(program)
        .args(arguments)
        .env("OMPI_ALLOW_RUN_AS_ROOT", "1")
        .env("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1")
        .env("OMPI_MCA_rmaps_base_oversubscribe", "1")
        .env("OMPI_MCA_btl_vader_single_copy_mechanism", "none")
        .output()
        .expect("mpirun runs: ranks/check installs it")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn json(output: &Output) -> Value {
    assert!(output.status.success(), "{}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("one object")
}

/// What `dcd detect` writes of the scene: by the library, on one machine.
fn contacts(scene: &Scene) -> Vec<(u32, u32)> {
    let mut pipeline = Pipeline::new();
    let mut contacts: Vec<_> = pipeline.step(scene, Par::Serial).contacts().collect();
    contacts.sort_unstable();
    contacts
}

fn file_of(contacts: &[(u32, u32)]) -> Vec<u8> {
    let numbers = contacts.iter().flat_map(|&(i, j)| [i, j]);
    let all = std::iter::once(contacts.len() as u32).chain(numbers);
    all.flat_map(u32::to_le_bytes).collect()
}

/// 64-bit FNV-1a, as published.
fn fnv1a(bytes: &[u8]) -> String {
    let hash = bytes.iter().fold(0xcbf2_9ce4_8422_2325u64, |hash, &byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    });
    format!("{hash:016x}")
}

/// Runs the same question at some numbers of ranks.
fn check(what: &[&str], scene: &Scene, folder: &Path, numbers: &[usize]) {
    let contacts = contacts(scene);
    let expected = file_of(&contacts);
    for &ranks in numbers {
        let out = folder.join(format!("out-{ranks}"));
        let out_name = out.to_str().expect("a plain name");
        let arguments = [&["detect"], what, &["--json", "--out", out_name]].concat();
        let found = json(&mpirun(ranks, &arguments));
        assert_eq!(std::fs::read(&out).expect("written"), expected, "{what:?} at {ranks} ranks");
        assert_eq!(found["digest"], fnv1a(&expected[4..]), "{what:?} at {ranks} ranks");
        assert_eq!(found["contacts"], contacts.len());
        assert_eq!(found["objects"], scene.len());
        assert_eq!(found["undecided"], 0);
        let of_ranks = found["ranks"].as_array().expect("a list");
        assert_eq!(of_ranks.len(), ranks);
        let sum =
            |key: &str| of_ranks.iter().map(|rank| rank[key].as_u64().expect(key)).sum::<u64>();
        assert_eq!(sum("objects"), scene.len() as u64);
        assert_eq!(sum("pairs"), found["pairs"]);
        assert_eq!(sum("bytes_sent"), sum("bytes_received"));
    }
}

#[test]
fn seeded_scenes_have_the_same_contacts_at_any_number_of_ranks() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, n, numbers) in [
        ("paper", 300, &RANKS[..]),
        ("sparse", 3000, &FEW),
        ("clustered", 2000, &FEW),
        ("big-and-small", 1500, &FEW),
        ("bricks", 900, &FEW),
    ] {
        let scene = SceneSpec::parse(name).expect("known").with_objects(n).scene().expect("made");
        check(&["--scene", name, "--n", &n.to_string()], &scene, folder.path(), numbers);
    }
}

#[test]
fn a_file_is_read_in_shares_and_by_threads_too() {
    let folder = tempfile::tempdir().expect("a folder");
    let raw = SceneSpec::plates().with_objects(1000).raw().expect("made");
    let path = folder.path().join("scene");
    write_hull_scene(&raw, &mut std::fs::File::create(&path).expect("created")).expect("written");
    let scene = raw.into_scene().expect("checked");
    let name = path.to_str().expect("a plain name");
    check(&[name], &scene, folder.path(), &RANKS);
    check(&[name, "--threads", "2", "--repeat", "3"], &scene, folder.path(), &FEW);
}

#[test]
fn what_cannot_be_read_is_reported_once_and_ends_all_ranks() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut raw = SceneSpec::sparse().with_objects(100).raw().expect("made");
    raw.objects[77].translation.x = f64::NAN;
    let path = folder.path().join("scene");
    write_hull_scene(&raw, &mut std::fs::File::create(&path).expect("created")).expect("written");
    let name = path.to_str().expect("a plain name");
    let out = folder.path().join("out");
    let refused = mpirun(3, &["detect", name, "--out", out.to_str().expect("a plain name")]);
    let printed = text(&refused.stderr);
    assert_eq!(refused.status.code(), Some(2), "{printed}");
    let lines: Vec<&str> = printed.lines().filter(|line| line.starts_with("dcd-mpi: ")).collect();
    assert_eq!(lines.len(), 1, "{printed}");
    assert!(lines[0].contains(name) && lines[0].contains("object 77: "), "{printed}");
    assert!(!out.exists());
    for (arguments, what) in [
        (&["detect", "/no/such/file"][..], "/no/such/file"),
        (&["detect", "--scene", "sparse", "--n", "4000000000"], "memory"),
        (&["detect", "--scene", "sparse", "--margin", "-1"], "-1"),
        (&["detect", "--scene", "papier"], "papier"),
        (&["detect", "--scene", "sparse", "--out", "/no/such/folder/out"], "/no/such/folder/out"),
    ] {
        let refused = mpirun(2, arguments);
        let printed = text(&refused.stderr);
        assert_eq!(refused.status.code(), Some(2), "{arguments:?}: {printed}");
        assert!(printed.contains(what), "{arguments:?}: {printed}");
    }
    let bytes = std::fs::read(&path).expect("read");
    std::fs::write(&path, &bytes[..bytes.len() / 2]).expect("written");
    let printed = text(&mpirun(2, &["detect", name]).stderr);
    assert!(printed.contains(name) && printed.contains("of record"), "{printed}");
}

/// Cargo builds examples beside the tests.
fn example(name: &str) -> PathBuf {
    Path::new(env!("CARGO_BIN_EXE_dcd-mpi")).with_file_name("examples").join(name)
}

#[test]
fn messages_in_pieces_arrive_whole() {
    for ranks in [1, 3] {
        let done = mpirun_of(&example("pieces"), ranks, &[]);
        assert!(done.status.success(), "{}", text(&done.stderr));
        assert_eq!(text(&done.stdout).lines().filter(|line| *line == "whole").count(), ranks);
    }
}

#[test]
fn a_rank_that_panics_ends_all_with_its_message() {
    let lost = mpirun_of(&example("lost"), 3, &[]);
    let printed = text(&lost.stderr);
    assert!(!lost.status.success());
    assert!(printed.contains("rank 1 is lost"), "{printed}");
    assert!(!text(&lost.stdout).contains("goes on"));
}

#[test]
fn measures_are_of_as_many_pairs_as_on_one_machine() {
    let scene = SceneSpec::sparse().with_objects(600).scene().expect("made");
    let touching = contacts(&scene).len();
    for query in ["depth", "manifold"] {
        let arguments = ["detect", "--scene", "sparse", "--n", "600", "--json", "--query", query];
        assert_eq!(json(&mpirun(3, &arguments))["contacts"], touching);
    }
    let near = [
        "detect", "--scene", "sparse", "--n", "600", "--json", "--query", "distance", "--margin",
        "0.3",
    ];
    let near = json(&mpirun(2, &near))["contacts"].as_u64().expect("a count") as usize;
    assert!(near > touching);
}
