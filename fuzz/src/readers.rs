//! Everything that reads files.

use dcd_io::{
    Capture, SweptBoxes, read_boxes, read_clouds, read_hull_scene, read_listed_pairs, read_pairs,
    read_ply, write_hull_scene,
};

/// The first byte says which reader, the rest is its file: none panics, and a scene or capture that
/// was read is written and read again without a change.
pub fn readers(bytes: &[u8]) {
    let Some((which, file)) = bytes.split_first() else { return };
    match which % 7 {
        0 => drop(read_boxes(file)),
        1 => drop(read_clouds(file)),
        2 => frames(file),
        3 => hull_scene(file),
        4 => drop(read_listed_pairs(file)),
        5 => capture(file),
        _ => read_pairs(file).flatten().for_each(drop),
    }
}

/// A frame, and the two that its halves may be.
fn frames(file: &[u8]) {
    let _ = read_ply(file);
    let (first, second) = file.split_at(file.len() / 2);
    if let (Ok(first), Ok(second)) = (read_ply(first), read_ply(second)) {
        let _ = SweptBoxes::between(&first, &second);
    }
}

fn hull_scene(file: &[u8]) {
    let Ok(scene) = read_hull_scene(file) else { return };
    let mut written = Vec::new();
    write_hull_scene(&scene, &mut written).expect("memory takes all");
    let again = read_hull_scene(&written).expect("what was written can be read");
    assert_eq!(again.digest(), scene.digest());
    let _ = scene.into_scene();
}

fn capture(file: &[u8]) {
    let Ok(capture) = Capture::read(file) else { return };
    let mut written = Vec::new();
    capture.write(&mut written).expect("memory takes all");
    let again = Capture::read(&written).expect("what was written can be read");
    assert!(again.frames().eq(capture.frames()));
}
