//! Robots, the pairs of theirs that may touch, and archives of problems.

use crate::Input;
use crate::text::{Shown, built_request, built_scene};
use dcd_robot::{AllowedPairs, LinkShapes, Robot, read_problems};
use std::collections::BTreeSet;
use std::io::Read;
use std::path::PathBuf;

/// A file for what is read by its path, one for each process and kind.
fn file(kind: &str, bytes: &[u8]) -> PathBuf {
    let memory = PathBuf::from("/dev/shm");
    let folder = if memory.is_dir() { memory } else { std::env::temp_dir() };
    let path = folder.join(format!("dcd-fuzz-{}-{kind}", std::process::id()));
    std::fs::write(&path, bytes).expect("the folder of temporary files takes one");
    path
}

/// No panic; a robot that was read has a shape for each collision element of the text, by a scan that
/// knows nothing of the reader, and of a robot that is built from the bytes as many as were built in.
/// The first byte says which of the two.
pub fn urdf(bytes: &[u8]) {
    let Some((&which, rest)) = bytes.split_first() else { return };
    let (text, count) = match which % 2 {
        0 => (rest.to_vec(), collisions(rest)),
        _ => {
            let Some((text, count)) = built_robot(&mut Input(rest)) else { return };
            (text.into_bytes(), Some(count))
        }
    };
    let Ok(robot) = Robot::load_as(&file("urdf", &text), LinkShapes::Hulls) else { return };
    if let Some(count) = count {
        assert_eq!(robot.parts().len(), count);
    }
    let state = robot.rest_state();
    let mut poses = Vec::new();
    if robot.place(&state, &mut poses).is_ok() {
        assert_eq!(poses.len(), robot.parts().len());
    }
    let _ = AllowedPairs::adjacent(&robot);
}

/// How many collision elements are children of links of the root; none where a document type or a
/// namespace could make the text mean something else.
fn collisions(text: &[u8]) -> Option<usize> {
    let text = std::str::from_utf8(text).ok()?;
    if ["<!D", "<!E", "xmlns", "<![CDATA["].iter().any(|mark| text.contains(mark)) {
        return None;
    }
    let (mut rest, mut open, mut count) = (text, Vec::<&str>::new(), 0);
    while let Some((_, after)) = rest.split_once('<') {
        if let Some(comment) = after.strip_prefix("!--") {
            rest = comment.split_once("-->")?.1;
        } else if let Some(instruction) = after.strip_prefix('?') {
            rest = instruction.split_once("?>")?.1;
        } else if let Some(end) = after.strip_prefix('/') {
            open.pop();
            rest = end.split_once('>')?.1;
        } else {
            let name = after.split(|c: char| c.is_whitespace() || c == '>' || c == '/').next()?;
            open.push(name);
            count += usize::from(matches!(open[..], ["robot", "link", "collision"]));
            let (tag, behind) = after.split_at(end_of_tag(after)?);
            if tag.ends_with('/') {
                open.pop();
            }
            rest = &behind[1..];
        }
    }
    Some(count)
}

/// Where the `>` of a tag is, those in quotes passed over.
fn end_of_tag(tag: &str) -> Option<usize> {
    let mut quote = None;
    tag.char_indices().find_map(|(at, c)| {
        match (quote, c) {
            (None, '>') => return Some(at),
            (None, '"' | '\'') => quote = Some(c),
            (Some(open), _) if open == c => quote = None,
            _ => {}
        }
        None
    })
}

/// A chain of links with spheres, boxes and cylinders, and how many it has.
fn built_robot(input: &mut Input<'_>) -> Option<(String, usize)> {
    let links = input.byte()? % 12;
    let (mut text, mut count) = (String::from("<robot name=\"r\">"), 0);
    for link in 0..links {
        text += &format!("<link name=\"l{link}\">");
        for _ in 0..input.byte()? % 4 {
            let size = input.number()?.abs();
            let geometry = match input.byte()? % 3 {
                0 => format!("<sphere radius=\"{size:e}\"/>"),
                1 => format!("<box size=\"{size:e} 1 2\"/>"),
                _ => format!("<cylinder radius=\"1\" length=\"{size:e}\"/>"),
            };
            let [x, y, z] = input.vector()?.to_array();
            text += &format!(
                "<collision><origin xyz=\"{x:e} {y:e} {z:e}\"/><geometry>{geometry}</geometry>\
                 </collision>"
            );
            count += 1;
        }
        text += "</link>";
        if link > 0 {
            let kind = ["revolute", "fixed", "prismatic", "continuous"];
            let (kind, parent) = (kind[usize::from(input.byte()? % 4)], input.byte()? % link);
            text += &format!(
                "<joint name=\"j{link}\" type=\"{kind}\"><axis xyz=\"0 0 1\"/>\
                 <limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/>\
                 <parent link=\"l{parent}\"/><child link=\"l{link}\"/></joint>"
            );
        }
    }
    Some((text + "</robot>", count))
}

/// No panic; of pairs that are built from the bytes each may touch, in either order, and no other.
pub fn srdf(bytes: &[u8]) {
    let _ = AllowedPairs::load(&file("srdf", bytes));
    let mut input = Input(bytes);
    let (mut pairs, mut text) = (BTreeSet::new(), String::from("<robot name=\"r\">"));
    while let (Some(a), Some(b)) = (input.byte(), input.byte()) {
        let (a, b) = (a % 24, b % 24);
        if a != b {
            pairs.insert((a.min(b), a.max(b)));
            text +=
                &format!("<disable_collisions link1=\"l{a}\" link2=\"l{b}\" reason=\"Never\"/>");
        }
    }
    let Ok(allowed) = AllowedPairs::load(&file("srdf", (text + "</robot>").as_bytes())) else {
        return;
    };
    for a in 0..24 {
        for b in 0..24 {
            let said = pairs.contains(&(a.min(b), a.max(b)));
            assert_eq!(allowed.contains(&format!("l{a}"), &format!("l{b}")), said, "{a} {b}");
        }
    }
}

/// No panic, whatever the bytes unpack to; an archive that is packed here, of scenes and requests that
/// are built from the bytes, holds a problem for each, and none is lost or read twice.
pub fn archives(bytes: &[u8]) {
    let Some((&which, rest)) = bytes.split_first() else { return };
    match which % 3 {
        0 => drop(read_problems(&file("archive", rest))),
        1 => drop(read_problems(&file("archive", &packed(rest)))),
        _ => {
            let Some((tar, problems)) = built_archive(&mut Input(rest)) else { return };
            let Ok(found) = read_problems(&file("archive", &packed(&tar))) else { return };
            let found: Vec<_> = found.iter().map(|p| (p.set.clone(), p.number.clone())).collect();
            assert!(found.iter().eq(&problems), "{found:?} {}", Shown(&tar));
        }
    }
}

fn packed(bytes: &[u8]) -> Vec<u8> {
    let mut packed = Vec::new();
    let mut encoder = bzip2::read::BzEncoder::new(bytes, bzip2::Compression::fast());
    encoder.read_to_end(&mut packed).expect("memory takes all");
    packed
}

/// The set and the number of a problem.
type Numbered = (String, String);

/// An archive of problems, and their sets and numbers.
fn built_archive(input: &mut Input<'_>) -> Option<(Vec<u8>, BTreeSet<Numbered>)> {
    let mut tar = tar::Builder::new(Vec::new());
    let mut problems = BTreeSet::new();
    let mut add = |name: String, text: &str| {
        let mut header = tar::Header::new_gnu();
        header.set_size(text.len() as u64);
        tar.append_data(&mut header, name, text.as_bytes()).ok()
    };
    for _ in 0..input.byte()? % 4 {
        let (set, number) = (input.byte()? % 3, input.byte()?);
        if problems.insert((format!("set{set}"), number.to_string())) {
            add(format!("p/set{set}/scene{number}.yaml"), &built_scene(input)?.0)?;
            add(format!("p/set{set}/request{number}.yaml"), &built_request(input)?.0)?;
        }
    }
    let tar = tar.into_inner().ok()?;
    (!problems.is_empty()).then_some((tar, problems))
}
