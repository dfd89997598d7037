//! The files of the data folder, which nobody here made. Without it these tests say that they skip.

use dcd_geom::Aabb;
use dcd_io::{CloudCensus, SweptBoxes, data, load_boxes, load_clouds, load_ply};
use std::path::PathBuf;

/// A file, or the news that the test skips.
fn file(path: &str) -> Option<PathBuf> {
    let found = data::file(path);
    if found.is_none() {
        println!("skipped: {path} is not there");
    }
    found
}

/// Pairs of AABBs for which `overlap` holds, by brute force.
fn pairs(boxes: &[Aabb], overlap: impl Fn(&Aabb, &Aabb) -> bool) -> usize {
    let row = |(i, a)| boxes[..i].iter().filter(|b| overlap(a, b)).count();
    boxes.iter().enumerate().map(row).sum()
}

fn overlap_inside(a: &Aabb, b: &Aabb) -> bool {
    a.min.cmplt(b.max).all() && b.min.cmplt(a.max).all()
}

#[test]
fn the_levels_boxes_have_the_pairs_that_their_readme_counts() {
    for (path, count, closed, inside) in
        [("aabbs/bounds01.txt", 288, 650, None), ("aabbs/bounds03.txt", 268, 7155, Some(7148))]
    {
        let Some(path) = file(path) else { return };
        let boxes = load_boxes(&path).unwrap();
        assert_eq!(boxes.len(), count);
        assert_eq!(pairs(&boxes, Aabb::overlaps), closed);
        if let Some(inside) = inside {
            assert_eq!(pairs(&boxes, overlap_inside), inside);
        }
    }
}

#[test]
fn the_32006_boxes_have_twelve_pairs() {
    let Some(path) = file("aabbs/32006GPUAABBs.txt") else { return };
    let boxes = load_boxes(&path).unwrap();
    assert_eq!(boxes.len(), 32_006);
    assert_eq!(pairs(&boxes, Aabb::overlaps), 12);
}

#[test]
fn every_listed_pair_of_swept_boxes_overlaps() {
    let names = ["ccd-n-body/balls16_18.ply", "ccd-n-body/balls16_19.ply", "ccd-n-body/18vf.json"];
    let [Some(first), Some(second), Some(list)] = names.map(file) else { return };
    let (first, second) = (load_ply(&first).unwrap(), load_ply(&second).unwrap());
    assert_eq!((first.vertices.len(), first.faces.len()), (73_960, 146_480));
    let swept = SweptBoxes::between(&first, &second).unwrap();
    assert_eq!(swept.boxes.len(), 73_960 + 146_480);
    let listed = dcd_io::load_listed_pairs(&list).unwrap();
    assert_eq!(listed.len(), 9_460);
    for [vertex, face] in listed {
        let [a, b] = [vertex, face].map(|id| swept.index_of(id).unwrap());
        assert!(a < swept.vertices && b >= swept.vertices);
        assert!(swept.boxes[a].overlaps(&swept.boxes[b]), "{vertex}, {face}");
    }
}

#[test]
fn every_cloud_of_the_game_is_a_shape() {
    let Some(path) = file("hulls/convex_hulls.bin") else { return };
    let clouds = load_clouds(&path).unwrap();
    assert_eq!(clouds.len(), 6_755);
    let mut sizes: Vec<usize> = clouds.iter().map(Vec::len).collect();
    sizes.sort_unstable();
    assert_eq!((sizes[0], sizes[3377], sizes[6754]), (4, 16, 100));
    let census = CloudCensus::of(clouds.iter().map(Vec::as_slice));
    println!("{census}");
    let expected = CloudCensus { solid: 6_730, flat: 25, ..CloudCensus::default() };
    assert_eq!(census, expected);
}
