//! Batches of configurations against a world.

use crate::Input;
use crate::judge::part_by_part;
use crate::scene::{paths, scene_of};
use dcd_exec::Par;
use dcd_geom::{Object, Pose, Scene, Shape};
use dcd_gjk::{Overlap, PosedShape, Verdict};
use dcd_pipeline::{BatchChecker, Hit, LinkSet, Other, StaticWorld};

/// Links and batches at most.
const LINKS: u8 = 4;
const BATCHES: u8 = 3;

/// One more than the configurations of a batch at most: enough for a second row of sixteen spheres.
const CONFIGURATIONS: u8 = 24;

/// On each path all hits are those of the certified solver, pair by pair and part by part, and a first
/// hit is one of them where there is one; what earlier batches left behind changes nothing.
pub fn probe(bytes: &[u8]) {
    let mut input = Input(bytes);
    let Some((scene, links)) = world_of(&mut input) else { return };
    let Some(batches) = batches(&mut input, links.len()) else { return };
    for path in paths() {
        let world = StaticWorld::new(&scene, Overlap::on(path), Par::Serial).unwrap();
        let link_set = LinkSet::new(links.clone()).against_itself(&[(0, 1)]);
        let link_set = link_set.unwrap_or_else(|_| LinkSet::new(links.clone()));
        let Ok(mut checker) = world.checker(link_set) else {
            let at_origin = (0..links.len() as u32).map(|link| Object::new(link, Pose::IDENTITY));
            assert!(Scene::new(links, at_origin).is_err(), "links were refused");
            return;
        };
        for poses in &batches {
            check(&scene, &links, poses, &mut checker);
        }
    }
}

fn world_of(input: &mut Input<'_>) -> Option<(Scene, Vec<Shape>)> {
    let links = 1 + input.byte()? % LINKS;
    let links = (0..links).map(|_| input.shape()).collect::<Option<_>>()?;
    Some((scene_of(input)?, links))
}

fn batches(input: &mut Input<'_>, links: usize) -> Option<Vec<Vec<Pose>>> {
    let batches = 1 + input.byte()? % BATCHES;
    let mut batch = || {
        let count = usize::from(input.byte()? % CONFIGURATIONS);
        (0..count * links).map(|_| input.pose()).collect()
    };
    (0..batches).map(|_| batch()).collect()
}

type HitKey = (u32, u32, Other);

fn check(scene: &Scene, links: &[Shape], poses: &[Pose], checker: &mut BatchChecker) {
    let Ok(all) = checker.all(poses, Par::Serial) else {
        // Only what no scene would take is refused.
        let objects = poses.iter().zip((0..links.len() as u32).cycle());
        let objects = objects.map(|(&pose, link)| Object::new(link, pose));
        assert!(Scene::new(links.to_vec(), objects).is_err(), "poses were refused");
        return;
    };
    let (mut touching, mut undecided) = (Vec::new(), Vec::new());
    let hit = |found: &Hit<()>| (found.configuration, found.link, found.other);
    for found in all.iter() {
        if found.touches() { &mut touching } else { &mut undecided }.push(hit(&found));
    }
    let (mut due, mut open) = (Vec::new(), Vec::new());
    for (hit, verdict) in judged(scene, links, poses) {
        match verdict {
            Verdict::Apart => {}
            Verdict::Touching(()) => due.push(hit),
            Verdict::Undecided(_) => open.push(hit),
        }
    }
    // Of curved shapes the lanes may know more.
    let known = |hits: &[HitKey]| -> Vec<HitKey> {
        let mut known: Vec<HitKey> =
            hits.iter().filter(|hit| !open.contains(hit)).copied().collect();
        known.sort_unstable();
        known
    };
    assert_eq!(known(&touching), known(&due), "all hits");
    assert_eq!(known(&undecided), [], "undecided");
    let firsts = checker.first(poses, Par::Serial).unwrap();
    for (own, found) in (0..).zip(firsts) {
        let of_own = |hits: &[HitKey]| hits.iter().any(|hit| hit.0 == own);
        match found {
            Some(found) if found.touches() => assert!(touching.contains(&hit(found)), "{found:?}"),
            Some(found) => assert!(!of_own(&touching) && undecided.contains(&hit(found))),
            None => {
                assert!(!of_own(&touching) && !of_own(&undecided), "of {own} nothing is reported")
            }
        }
    }
}

/// Every pair of the query, one by one.
fn judged(scene: &Scene, links: &[Shape], poses: &[Pose]) -> Vec<(HitKey, Verdict<()>)> {
    let mut judged = Vec::new();
    for (own, poses) in (0..).zip(poses.chunks(links.len())) {
        let placed: Vec<_> =
            links.iter().zip(poses).map(|(shape, pose)| PosedShape { shape, pose }).collect();
        for (link, &a) in (0..).zip(&placed) {
            for i in 0..scene.len() {
                let b = PosedShape { shape: scene.shape(i), pose: &scene.poses()[i] };
                judged.push(((own, link, Other::Obstacle(i as u32)), part_by_part(b, a)));
            }
            for (other, &b) in (0..link).zip(&placed).filter(|(other, _)| (*other, link) != (0, 1))
            {
                judged.push(((own, link, Other::Link(other)), part_by_part(b, a)));
            }
        }
    }
    judged
}
