//! A file that the command writes is there whole or not at all, and is nobody else's.
#![allow(missing_docs)]

mod common;

use common::{Hull, dcd, hull_file};
use std::fs;
use std::path::{Path, PathBuf};

/// A folder with a scene of two touching cubes, gone with the test.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        fs::write(folder.at("scene"), scene()).unwrap();
        folder
    }

    fn at(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.0.path()).unwrap();
        let mut names: Vec<_> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }
}

fn scene() -> Vec<u8> {
    hull_file(&[0.0, 0.5].map(|x| Hull::unit_cube([x, 0.0, 0.0])))
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

#[test]
fn an_output_that_is_the_input_is_refused_however_it_is_spelt() {
    let folder = Folder::new();
    fs::create_dir(folder.at("sub")).unwrap();
    fs::hard_link(folder.at("scene"), folder.at("hard")).unwrap();
    #[cfg_attr(not(unix), expect(unused_mut))]
    let mut spellings = vec!["scene", "sub/../scene", "./scene", "hard"];
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("scene", folder.at("soft")).unwrap();
        spellings.push("soft");
    }
    for spelling in spellings {
        for flag in ["--out", "--answers"] {
            let (input, output) = (folder.at("scene"), folder.at(spelling));
            let ran = dcd(&["detect", text(&input), flag, text(&output)]);
            ran.assert_refused(&[spelling, "it is an input"]);
            assert_eq!(fs::read(&input).unwrap(), scene(), "{spelling}");
        }
    }
}

/// A tetrahedron.
const MESH: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

/// A triangle whose corners are in a file beside.
const TOOL: &str = r#"{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
"meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
"accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}],
"bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"uri": "tool.bin", "byteLength": 36}]}"#;

#[test]
fn an_output_that_a_robot_or_a_state_names_is_refused() {
    let folder = Folder::new();
    let named = ["body.obj", "package.xml", "tool.gltf", "tool.bin", "held.obj"];
    let corners = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].map(f32::to_le_bytes).concat();
    let package = "<package><name>arm</name></package>";
    let contents =
        [MESH.as_bytes(), package.as_bytes(), TOOL.as_bytes(), &corners, MESH.as_bytes()];
    for (name, content) in named.iter().zip(contents) {
        fs::write(folder.at(name), content).unwrap();
    }
    let mesh = |file: &str| {
        format!("<collision><geometry><mesh filename=\"{file}\"/></geometry></collision>")
    };
    let (body, tool) = (mesh("package://arm/body.obj"), mesh("tool.gltf"));
    let urdf = format!("<robot name=\"arm\"><link name=\"body\">{body}{tool}</link></robot>");
    let attached = r#"[{"name": "rod", "link": "body", "shape": {"mesh": "held.obj"}}]"#;
    fs::write(folder.at("arm.urdf"), urdf).unwrap();
    fs::write(folder.at("states"), format!("{{\"q\": [], \"attached\": {attached}}}\n")).unwrap();
    let [urdf, states] = ["arm.urdf", "states"].map(|name| folder.at(name));
    let before = folder.names();
    for (name, content) in named.iter().zip(contents) {
        let output = folder.at(name);
        for flag in ["--glb", "--acm"] {
            if *name != "held.obj" {
                dcd(&["robot", text(&urdf), flag, text(&output)])
                    .assert_refused(&[name, "it is an input"]);
            }
        }
        let ran = dcd(&["robot", text(&urdf), "--states", text(&states), "--glb", text(&output)]);
        assert!(ran.code == Some(2) && ran.stderr.contains("it is an input"), "{name}: {ran:?}");
        assert_eq!(fs::read(&output).unwrap(), content, "{name}");
        assert_eq!(folder.names(), before);
    }
}

#[test]
fn two_outputs_that_are_one_file_are_refused() {
    let folder = Folder::new();
    let (out, scene) = (folder.at("out"), folder.at("scene"));
    let answers = folder.at("sub");
    fs::create_dir(&answers).unwrap();
    let again = answers.join("../out");
    for other in [&out, &again] {
        let ran = dcd(&["detect", text(&scene), "--out", text(&out), "--answers", text(other)]);
        ran.assert_refused(&["out", "one would be lost"]);
    }
    assert_eq!(folder.names(), ["scene", "sub"]);
}

#[test]
fn a_capture_that_is_replayed_is_no_output_and_outputs_replace_what_was_there() {
    let folder = Folder::new();
    let out = folder.at("out");
    fs::write(&out, "old").unwrap();
    let ran = dcd(&["detect", text(&folder.at("scene")), "--out", text(&out)]);
    assert_eq!(ran.code, Some(0), "{ran:?}");
    assert_eq!(fs::read(&out).unwrap(), [1, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0]);
    assert_eq!(folder.names(), ["out", "scene"]);
}

#[test]
fn a_run_that_is_refused_leaves_the_old_output() {
    let folder = Folder::new();
    let (out, broken) = (folder.at("out"), folder.at("broken"));
    fs::write(&out, "old").unwrap();
    fs::write(&broken, [9, 0, 0, 0]).unwrap();
    dcd(&["detect", text(&broken), "--out", text(&out)]).assert_refused(&["broken"]);
    dcd(&["capture", "--scene", "heap", "--out", text(&out)]).assert_refused(&["heap"]);
    assert_eq!(fs::read(&out).unwrap(), b"old");
    assert_eq!(folder.names(), ["broken", "out", "scene"]);
}

#[test]
fn an_output_that_cannot_be_made_is_named_and_not_its_temporary_file() {
    let folder = Folder::new();
    let out = folder.at("no/out");
    let ran = dcd(&["detect", text(&folder.at("scene")), "--out", text(&out)]);
    ran.assert_refused(&[text(&out)]);
    assert!(!ran.stderr.contains(".part"), "{ran:?}");
}

#[test]
fn states_that_are_all_refused_leave_the_old_picture() {
    let folder = Folder::new();
    let urdf = "<robot name=\"arm\"><link name=\"body\"><collision><geometry><sphere radius=\"1\"/></geometry>\
                </collision></link></robot>";
    let [robot, states, glb] = ["arm.urdf", "states", "old.glb"].map(|name| folder.at(name));
    fs::write(&robot, urdf).unwrap();
    fs::write(&glb, "old").unwrap();
    let draw = |lines: &str| {
        fs::write(&states, lines).unwrap();
        dcd(&["robot", text(&robot), "--states", text(&states), "--glb", text(&glb)])
    };
    for lines in ["", "{}\n{\"q\": [1]}\n"] {
        assert_eq!(draw(lines).code, Some(2), "{lines}");
        assert_eq!(fs::read(&glb).unwrap(), b"old");
        assert_eq!(folder.names(), ["arm.urdf", "old.glb", "scene", "states"]);
    }
    // Where one is answered it is drawn.
    assert_eq!(draw("{}\n{\"q\": []}\n").code, Some(2));
    assert!(fs::read(&glb).unwrap().starts_with(b"glTF"));
}

/// A shell, for what only a shell can set up: limits, redirections.
#[cfg(unix)]
fn shell(script: &str, arguments: &[&Path]) -> std::process::Output {
    std::process::Command::new("sh")
        .args(["-c", script, env!("CARGO_BIN_EXE_dcd")])
        .args(arguments)
        .output()
        .unwrap()
}

#[cfg(unix)]
#[test]
fn an_output_that_is_standard_input_or_standard_output_is_refused() {
    let folder = Folder::new();
    let input = folder.at("scene");
    let ran = shell("exec \"$0\" detect - --out \"$1\" <\"$1\"", &[&input]);
    assert_eq!(ran.status.code(), Some(2), "{ran:?}");
    assert_eq!(fs::read(&input).unwrap(), scene());
    let out = folder.at("out");
    let ran = shell("exec \"$0\" detect \"$1\" --out \"$2\" >\"$2\"", &[&input, &out]);
    assert_eq!(ran.status.code(), Some(2), "{ran:?}");
}

#[cfg(unix)]
#[test]
fn a_full_disk_leaves_the_old_output_and_no_litter() {
    let folder = Folder::new();
    let out = folder.at("out");
    fs::write(&out, "old").unwrap();
    // A block is 512 or 1,024 bytes, a capture of 50 cubes in 20 frames some 96 kB.
    let script = "ulimit -f 8; exec \"$0\" capture --scene bricks --n 50 --frames 20 --out \"$1\"";
    let ran = shell(script, &[&out]);
    let reported = String::from_utf8(ran.stderr).unwrap();
    assert!(
        ran.status.code() == Some(1) && reported.contains("out: "),
        "{:?} {reported}",
        ran.status
    );
    assert_eq!(fs::read(&out).unwrap(), b"old");
    assert_eq!(folder.names(), ["out", "scene"]);
    // A device stays one, and says that it is full.
    let ran = dcd(&["detect", text(&folder.at("scene")), "--out", "/dev/full"]);
    assert_eq!(ran.code, Some(1), "{ran:?}");
    assert!(!fs::metadata("/dev/full").unwrap().is_file());
}

#[cfg(unix)]
#[test]
fn an_interrupted_run_leaves_the_old_output_and_no_litter() {
    use std::os::unix::process::ExitStatusExt;
    use std::process::{Command, Stdio};
    use std::time::{Duration, Instant};
    for signal in ["INT", "TERM", "HUP"] {
        let folder = Folder::new();
        let out = folder.at("out");
        fs::write(&out, "old").unwrap();
        let mut child = Command::new(env!("CARGO_BIN_EXE_dcd"))
            .args(["detect", "--scene", "paper", "--n", "1000", "--threads", "1"])
            .args(["--repeat", "1000000", "--out", text(&out)])
            .stdout(Stdio::null())
            .spawn()
            .unwrap();
        let begun = Instant::now();
        while folder.names().len() < 3 {
            assert!(begun.elapsed() < Duration::from_secs(120), "no temporary file");
            std::thread::sleep(Duration::from_millis(5));
        }
        let number = child.id().to_string();
        let sent = Command::new("kill").args([format!("-{signal}"), number]).status().unwrap();
        assert!(sent.success());
        let ended = child.wait().unwrap();
        assert!(ended.signal().is_some(), "{signal}: {ended}");
        assert_eq!(fs::read(&out).unwrap(), b"old");
        assert_eq!(folder.names(), ["out", "scene"], "{signal}");
    }
}
