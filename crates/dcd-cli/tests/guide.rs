//! The commands of the guide's page on robots, run as printed, in a copy of the folder that it names.
#![allow(missing_docs)]
#![cfg(unix)]

use std::path::{Path, PathBuf};
use std::process::Command;

fn guide() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/guide")
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let (entry, path) = entry.map(|entry| (entry.file_name(), entry.path())).unwrap();
        if path.is_dir() {
            copy(&path, &to.join(entry));
        } else {
            std::fs::copy(&path, to.join(entry)).unwrap();
        }
    }
}

/// A block of commands, with what the block of text right behind it says that they print.
struct Printed {
    commands: String,
    output: Option<String>,
}

fn blocks(page: &str) -> Vec<Printed> {
    let mut found: Vec<Printed> = Vec::new();
    let mut lines = page.lines();
    while let Some(line) = lines.next() {
        let Some(language) = line.strip_prefix("```") else { continue };
        let block: String = lines
            .by_ref()
            .take_while(|line| *line != "```")
            .map(|line| format!("{line}\n"))
            .collect();
        match language {
            "sh" => found.push(Printed { commands: block, output: None }),
            "text" => found.last_mut().expect("commands come first").output = Some(block),
            _ => {}
        }
    }
    found
}

/// Whether a line is as the page has it, where `…` stands for anything.
fn is_as_printed(line: &str, printed: &str) -> bool {
    let mut parts = printed.split('…');
    let Some(mut rest) = line.strip_prefix(parts.next().unwrap()) else { return false };
    let mut open = false;
    for part in parts {
        let Some(at) = rest.find(part) else { return false };
        rest = &rest[at + part.len()..];
        open = part.is_empty();
    }
    open || rest.is_empty()
}

#[test]
fn an_ellipsis_stands_for_anything_and_nothing_else_does() {
    assert!(is_as_printed("a 0.0351, b", "a 0.03…, b"));
    assert!(is_as_printed("a 0.0351, b", "a 0.0…"));
    assert!(is_as_printed("as is", "as is"));
    for printed in ["a 0.04…, b", "a 0.03…, c", "a 0.03…,", "a"] {
        assert!(!is_as_printed("a 0.0351, b", printed), "{printed}");
    }
}

#[test]
fn the_commands_for_robots_print_what_the_page_says() {
    let folder = tempfile::tempdir().unwrap();
    copy(&guide().join("arm"), folder.path());
    let program = Path::new(env!("CARGO_BIN_EXE_dcd")).parent().unwrap();
    let path = format!("{}:{}", program.display(), std::env::var("PATH").unwrap());

    let page = std::fs::read_to_string(guide().join("robots.md")).unwrap();
    let blocks = blocks(&page);
    assert!(blocks.iter().filter(|block| block.output.is_some()).count() >= 4);
    for Printed { commands, output } in blocks {
        let ran = Command::new("sh")
            .args(["-e", "-c", &commands])
            .current_dir(folder.path())
            .env("PATH", &path)
            .env_remove("ROS_PACKAGE_PATH")
            .output()
            .unwrap();
        let stdout = String::from_utf8(ran.stdout).unwrap();
        assert!(ran.status.success(), "{commands}{}", String::from_utf8_lossy(&ran.stderr));
        let Some(output) = output else { continue };
        assert_eq!(stdout.lines().count(), output.lines().count(), "{commands}{stdout}");
        for (line, printed) in stdout.lines().zip(output.lines()) {
            assert!(is_as_printed(line, printed), "{commands}{line}\nis not\n{printed}");
        }
    }
    for written in ["arm.srdf", "answers.jsonl", "edges.glb"] {
        assert!(folder.path().join(written).is_file(), "{written}");
    }
}
