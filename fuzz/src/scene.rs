//! Whole steps, on every path of the lanes.

use crate::Input;
use crate::judge::{agree, part_by_part};
use dcd_exec::Par;
use dcd_geom::glam::DVec3;
use dcd_geom::{Filter, Motion, Object, Pose, Scene};
use dcd_gjk::{Coherent, Overlap, PosedShape, Verdict, certified};
use dcd_pipeline::{Pipeline, WideTree};
use dcd_simd::Path;

/// Objects in a scene at most: enough for a packet of sixteen pairs, and every pair is judged singly.
const OBJECTS: u8 = 20;

/// Frames at most.
const FRAMES: usize = 4;

/// On each path the contacts are those of the certified solver, pair by pair; what stays undecided
/// is among what the certified solver leaves so, of which the lanes may know more (of curved shapes). A
/// pipeline that has seen other frames gives what a fresh one gives, one that remembers proofs too.
pub fn scene(bytes: &[u8]) {
    let mut input = Input(bytes);
    let Some(mut scene) = scene_of(&mut input) else { return };
    let mut kept = kept();
    for _ in 0..FRAMES {
        check(&scene, &mut kept);
        if change(&mut scene, &mut input).is_none() {
            break;
        }
    }
}

pub(crate) fn paths() -> impl Iterator<Item = Path> {
    Path::ALL.into_iter().filter(|path| path.is_available())
}

/// Pipelines that have seen nothing yet, for each path.
pub(crate) fn kept() -> Vec<(Pipeline, Remembering)> {
    paths().map(|path| (pipeline(path), remembering(path))).collect()
}

fn pipeline(path: Path) -> Pipeline {
    Pipeline::with(WideTree::default(), Overlap::on(path))
}

fn remembering(path: Path) -> Remembering {
    Pipeline::with(WideTree::default(), Coherent::on(path))
}

pub(crate) type Remembering = Pipeline<WideTree, Coherent>;

pub(crate) fn scene_of(input: &mut Input<'_>) -> Option<Scene> {
    let shapes = 1 + input.byte()? % 4;
    let shapes = (0..shapes).map(|_| input.shape()).collect::<Option<Vec<_>>>()?;
    let count = input.byte()? % OBJECTS;
    let objects = (0..count).map(|_| object(input, shapes.len()));
    let objects = objects.collect::<Option<Vec<_>>>()?;
    Scene::new(shapes, objects).ok()
}

fn object(input: &mut Input<'_>, shapes: usize) -> Option<Object> {
    let byte = input.byte()?;
    let filter = match byte >> 6 {
        0 => Filter { groups: 1, mask: 2 },
        1 => Filter { groups: 3, mask: 1 },
        _ => Filter::ALL,
    };
    let motion = if byte & 32 == 0 { Motion::Moving } else { Motion::Static };
    let shape = u32::from(byte & 31) % shapes as u32;
    Some(Object { filter, motion, ..Object::new(shape, input.pose()?) })
}

/// Up to seven changes; what the scene refuses leaves it as it was. `None` at the bytes' end.
fn change(scene: &mut Scene, input: &mut Input<'_>) -> Option<()> {
    let changes = input.byte()? % 8;
    for _ in 0..changes {
        let (kind, i) = (input.byte()? % 5, usize::from(input.byte()? % OBJECTS));
        match kind {
            0 => {
                let _ = scene.handle(i).map(|handle| scene.remove(handle));
            }
            1 if scene.len() < usize::from(OBJECTS) => {
                let _ = scene.insert(object(input, scene.shapes().len())?);
            }
            2 => {
                let _ = scene.ignore_pair(i, usize::from(input.byte()?));
            }
            3 => {
                let _ = scene.set_pose(i, input.pose()?);
            }
            _ => nudge(scene, i, input.byte()?),
        }
    }
    Some(())
}

/// A step of between 1 and 2⁻³¹ metres along an axis: what proofs may outlast.
fn nudge(scene: &mut Scene, i: usize, byte: u8) {
    let Some(&pose) = scene.poses().get(i) else { return };
    let axis = [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X][usize::from(byte % 4)];
    let step = axis * 2f64.powi(-i32::from(byte >> 3));
    if let Ok(pose) = Pose::from_matrix(*pose.rotation(), pose.translation() + step) {
        let _ = scene.set_pose(i, pose);
    }
}

/// The verdict on every pair that may be reported, one by one. What stays undecided here the broad phase
/// may know to be apart.
#[derive(Debug, Default)]
pub(crate) struct Judged {
    pub(crate) touching: Vec<(u32, u32)>,
    pub(crate) undecided: Vec<(u32, u32)>,
}

pub(crate) fn check(scene: &Scene, kept: &mut [(Pipeline, Remembering)]) {
    let truth = judged(scene);
    for (path, (kept, remembering)) in paths().zip(kept) {
        let mut fresh = pipeline(path);
        let step = fresh.step(scene, Par::Serial);
        let contacts: Vec<_> = step.contacts().collect();
        let known = |pairs: &[(u32, u32)]| -> Vec<(u32, u32)> {
            let known = pairs.iter().filter(|pair| !truth.undecided.contains(pair));
            known.copied().collect()
        };
        let mut touching = known(&contacts);
        touching.sort_unstable();
        assert_eq!(touching, truth.touching, "{path:?}");
        let open: Vec<_> =
            step.report().undecided().iter().map(|left| pair_of(left.pair)).collect();
        assert_eq!(known(&open), [], "{path:?}");
        let again: Vec<_> = kept.step(scene, Par::Serial).contacts().collect();
        assert_eq!(again, contacts, "{path:?}, kept");
        let again: Vec<_> = remembering.step(scene, Par::Serial).contacts().collect();
        assert_eq!(known(&again), known(&contacts), "{path:?}, remembering");
    }
}

fn pair_of(pair: dcd_geom::Pair) -> (u32, u32) {
    pair.into()
}

pub(crate) fn judged(scene: &Scene) -> Judged {
    let mut judged = Judged::default();
    let placed =
        |i: u32| PosedShape { shape: scene.shape(i as usize), pose: &scene.poses()[i as usize] };
    let count = scene.len() as u32;
    let pairs = (0..count).flat_map(|i| (i + 1..count).map(move |j| (i, j)));
    for (i, j) in pairs.filter(|&(i, j)| scene.allows(i, j)) {
        let (a, b) = (placed(i), placed(j));
        let found = part_by_part(a, b);
        let whole = certified::overlap_of(a, b).0;
        assert!(agree(found, whole), "{i}, {j}: {found:?} part by part, {whole:?} as a whole");
        match found {
            Verdict::Apart => {}
            Verdict::Touching(()) => judged.touching.push((i, j)),
            Verdict::Undecided(_) => judged.undecided.push((i, j)),
        }
    }
    judged
}
