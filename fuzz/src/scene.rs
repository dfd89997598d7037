//! Whole steps, on every path of the lanes.

use crate::Input;
use dcd_exec::Par;
use dcd_geom::lanes::Path;
use dcd_geom::{Filter, Object, Scene, Shape};
use dcd_gjk::{Overlap, Placed, Verdict, certified};
use dcd_pipeline::{Pipeline, WideTree};

/// Objects in a scene at most: enough for a lot of sixteen pairs, and every pair is judged singly.
const OBJECTS: u8 = 20;

/// Each path's contacts are those of the certified ladder, pair by pair; a pipeline that has seen
/// another frame gives what a fresh one gives.
pub fn scene(bytes: &[u8]) {
    let mut input = Input(bytes);
    let Some(mut scene) = scene_of(&mut input) else { return };
    let mut kept: Vec<_> = paths().map(pipeline).collect();
    check(&scene, &mut kept);
    for i in 0..scene.len() {
        let Some(pose) = input.pose() else { break };
        // Refused where it is out of range; the scene is then as it was.
        let _ = scene.set_pose(i, pose);
    }
    check(&scene, &mut kept);
}

fn paths() -> impl Iterator<Item = Path> {
    Path::ALL.into_iter().filter(|path| path.is_available())
}

fn pipeline(path: Path) -> Pipeline {
    Pipeline::new(WideTree::default(), Overlap::on(path))
}

fn scene_of(input: &mut Input<'_>) -> Option<Scene> {
    let shapes = 1 + input.byte()? % 4;
    let shapes = (0..shapes).map(|_| input.polytope().map(Shape::from));
    let shapes = shapes.collect::<Option<Vec<_>>>()?;
    let count = input.byte()? % OBJECTS;
    let mut objects = Vec::new();
    for _ in 0..count {
        let byte = input.byte()?;
        let shape = u32::from(byte) % shapes.len() as u32;
        let filter = match byte >> 6 {
            0 => Filter { groups: 1, mask: 2 },
            1 => Filter { groups: 3, mask: 1 },
            _ => Filter::ALL,
        };
        objects.push(Object { shape, pose: input.pose()?, filter });
    }
    Scene::new(shapes, objects).ok()
}

fn check(scene: &Scene, kept: &mut [Pipeline]) {
    let truth = judged(scene);
    for (path, kept) in paths().zip(kept) {
        let mut fresh = pipeline(path);
        let step = fresh.step(scene, Par::Serial);
        assert!(step.report().undecided().is_empty(), "{path:?}");
        let contacts: Vec<_> = step.contacts().collect();
        let mut sorted = contacts.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, truth, "{path:?}");
        let again: Vec<_> = kept.step(scene, Par::Serial).contacts().collect();
        assert_eq!(again, contacts, "{path:?}, kept");
    }
}

/// Every pair that the filters allow, one by one.
fn judged(scene: &Scene) -> Vec<(u32, u32)> {
    let placed =
        |i: u32| Placed { shape: scene.shape(i as usize), pose: &scene.poses()[i as usize] };
    let count = scene.len() as u32;
    let pairs = (0..count).flat_map(|i| (i + 1..count).map(move |j| (i, j)));
    let touching = |&(i, j): &(u32, u32)| {
        scene.allows(i, j) && certified::overlap_of(placed(i), placed(j)).0 == Verdict::Touching(())
    };
    pairs.filter(touching).collect()
}
