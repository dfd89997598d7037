//! The clouds of a shipped game, through the command, against Parry on what Parry accepts.
#![allow(missing_docs)]

mod common;

use common::dcd;
use dcd_geom::{Scene, Shape};
use dcd_gjk::{PosedSupport, certified};
use dcd_io::{data, load_clouds};
use dcd_parry::{Library, ParryShapes};
use dcd_scenes::{GameHulls, GameSize};
use std::collections::BTreeSet;
use std::path::Path;

type Contacts = BTreeSet<(usize, usize)>;

/// What `--out` wrote with these arguments, and what was printed.
fn detect(clouds: &Path, arguments: &[&str]) -> (Contacts, serde_json::Value) {
    let out = format!("{}/real_clouds{}", env!("CARGO_TARGET_TMPDIR"), arguments.concat());
    let command = ["detect", "--clouds", clouds.to_str().unwrap(), "--json", "--out", &out];
    let reported = dcd(&[&command[..], arguments].concat()).summary();
    let file = std::fs::read(out).unwrap();
    let words = file[4..].chunks_exact(4).map(|w| u32::from_le_bytes(w.try_into().unwrap()));
    let words: Vec<usize> = words.map(|word| word as usize).collect();
    (words.chunks_exact(2).map(|pair| (pair[0], pair[1])).collect(), reported)
}

fn touch_exactly(scene: &Scene, (i, j): (usize, usize)) -> bool {
    let [a, b] = [i, j].map(|k| match scene.shape(k) {
        Shape::Polytope(polytope) => PosedSupport::polytope(polytope, &scene.poses()[k]),
        other => panic!("object {k} is {other:?}"),
    });
    certified::overlap_exactly(a, b)
}

#[test]
fn every_cloud_is_a_shape_and_parry_agrees_where_it_is_right() {
    let Some(path) = data::file("hulls/convex_hulls.bin") else {
        return println!("skipped: there is no hulls/convex_hulls.bin in a data folder");
    };
    let clouds = load_clouds(&path).unwrap();
    for (size, arguments) in [(GameSize::Unit, &[][..]), (GameSize::True, &["--true-size"])] {
        let (ours, reported) = detect(&path, arguments);
        assert_eq!((&reported["objects"], &reported["undecided"]), (&6755.into(), &0.into()));
        let census = &reported["clouds"];
        let count = |kind| census[kind].as_u64().unwrap();
        assert_eq!(["solid", "flat", "needles", "points"].map(count).iter().sum::<u64>(), 6755);
        assert!(ours.len() > 5000, "{}", ours.len());

        // The same scene once more, for the judge.
        let raw = GameHulls { size, candidates: 4.0 }.raw(&clouds, clouds.len(), 1);
        let scene = raw.into_scene().unwrap();
        let (parry, _) = detect(&path, &[arguments, &["--precision", "parry-f32"]].concat());
        assert_differences_are_parrys::<f32>(&scene, &ours, &parry);
        let (parry, _) = detect(&path, &[arguments, &["--precision", "parry-f64"]].concat());
        assert_differences_are_parrys::<f64>(&scene, &ours, &parry);
    }
}

/// On the pairs of shapes that Parry accepts, the exact judge says of each difference that we are
/// right.
fn assert_differences_are_parrys<R: Library>(scene: &Scene, ours: &Contacts, parry: &Contacts) {
    let refused: BTreeSet<u32> = ParryShapes::<R>::new(scene).refused().collect();
    let accepts =
        |&(i, j): &(usize, usize)| [i, j].iter().all(|&k| !refused.contains(&scene.shape_of()[k]));
    assert!(parry.iter().all(accepts));
    let ours: Contacts = ours.iter().copied().filter(accepts).collect();
    let differing: Vec<_> = ours.symmetric_difference(parry).copied().collect();
    for &pair in &differing {
        assert_eq!(touch_exactly(scene, pair), ours.contains(&pair), "{pair:?}");
    }
    let name = std::any::type_name::<R>();
    println!("Parry {name} refuses {} shapes, errs on {} pairs", refused.len(), differing.len());
    assert!(differing.len() < ours.len() / 100, "{} of {}", differing.len(), ours.len());
}
