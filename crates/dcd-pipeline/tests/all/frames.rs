//! A thousand frames in which objects move, appear and vanish: a pipeline reports in each, after all before,
//! what a fresh one reports.

use dcd_exec::with_threads;
use dcd_geom::glam::{DQuat, DVec3};
use dcd_geom::{Aabb, Filter, Handle, Object, Pair, Pose, Scene, Shape};
use dcd_gjk::{Coherent, ContactSink, Method, Prepared, Sides};
use dcd_pipeline::{Change, Event, Events, NarrowPhase, Overlap, Par, Pipeline, WideTree};
use dcd_scenes::{RandomWalk, SceneSpec};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A small generator of this test's own (Steele et al., SplitMix64, 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, end: usize) -> usize {
        (self.next() % end as u64) as usize
    }

    fn within(&mut self, half_width: f64) -> f64 {
        ((self.next() >> 11) as f64 / (1u64 << 52) as f64 - 1.0) * half_width
    }

    fn vector(&mut self, half_width: f64) -> DVec3 {
        DVec3::new(self.within(half_width), self.within(half_width), self.within(half_width))
    }

    fn pose(&mut self, half_width: f64) -> Pose {
        let turn = DQuat::from_scaled_axis(self.vector(3.0));
        Pose::new(turn, self.vector(half_width)).unwrap()
    }
}

/// A scene that changes, seeded.
struct Walk {
    scene: Scene,
    random: Random,
    hulls: Vec<Shape>,
}

const HALF_WIDTH: f64 = 3.5;

impl Walk {
    fn new() -> Self {
        let spec = SceneSpec::parse("paper").unwrap().with_objects(40).with_seed(9);
        let hulls = spec.scene().unwrap().shapes().to_vec();
        let shapes = vec![Shape::sphere(0.4).unwrap(), Shape::cuboid(DVec3::splat(0.4)).unwrap()];
        let mut walk = Self { scene: Scene::new(shapes, []).unwrap(), random: Random(7), hulls };
        (0..320).for_each(|_| walk.insert());
        walk
    }

    fn insert(&mut self) {
        let random = &mut self.random;
        let shape = random.below(self.scene.shapes().len()) as u32;
        let mut object = Object::new(shape, random.pose(HALF_WIDTH));
        if random.below(4) == 0 {
            object = object.fixed();
        }
        if random.below(10) == 0 {
            object.filter = Filter { groups: 1, mask: 2 };
        }
        let handle = self.scene.insert(object).unwrap();
        let other = random.below(self.scene.len());
        if random.below(3) == 0 && other != handle.index as usize {
            // Refused where that slot is free, which is as well.
            let _ = self.scene.ignore_pair(handle.index as usize, other);
        }
    }

    /// Most frames move the moving objects alone, some far, some a little, some not at all; some
    /// frames move a static one, some insert, remove or bring a new shape.
    fn advance(&mut self) {
        for i in 0..self.scene.len() {
            let fixed = self.random.below(20_000) == 0;
            if self.scene.motion(i).is_none() || !(fixed || moves(&self.scene, i)) {
                continue;
            }
            let step = [0.05, 0.05, 1e-3, 1e-4, 0.0][i % 5];
            let pose = self.scene.poses()[i];
            let turn = DQuat::from_mat3(pose.rotation());
            let turn = DQuat::from_scaled_axis(self.random.vector(step)) * turn;
            let at = pose.translation() + self.random.vector(step);
            let at = at.clamp(DVec3::splat(-HALF_WIDTH), DVec3::splat(HALF_WIDTH));
            self.scene.set_pose(i, Pose::new(turn.normalize(), at).unwrap()).unwrap();
        }
        for _ in 0..[0, 0, 0, 1, 4][self.random.below(5)] {
            let i = self.random.below(self.scene.len());
            if let Some(handle) = self.scene.handle(i) {
                self.scene.remove(handle).unwrap();
            }
        }
        while self.scene.object_count() < 320 && self.random.below(4) > 0 {
            self.insert();
        }
        if self.random.below(25) == 0
            && let Some(hull) = self.hulls.pop()
        {
            self.scene.add_shapes([hull]).unwrap();
        }
    }
}

fn moves(scene: &Scene, i: usize) -> bool {
    scene.motion(i) == Some(dcd_geom::Motion::Moving)
}

/// A predicate of the user's own, without a pattern.
fn may(i: u32, j: u32) -> bool {
    (i * 7) ^ j != 40 && !(i + j).is_multiple_of(17)
}

/// All that a frame reports.
#[derive(PartialEq)]
struct Reported {
    aabbs: Vec<Aabb>,
    candidates: Vec<Pair>,
    contacts: Vec<(u32, u32)>,
    events: Vec<Event>,
}

/// Runs the walk with one pipeline, shows each frame to `look`, and returns how many answers came
/// from earlier frames.
fn run<N>(narrow: N, par: Par, mut look: impl FnMut(usize, &Scene, Reported)) -> u64
where
    N: NarrowPhase<Answer = ()>,
{
    let mut walk = Walk::new();
    let mut pipeline = Pipeline::with(WideTree::default(), narrow);
    let (mut events, mut remembered) = (Events::default(), 0);
    for frame in 0..1000 {
        let step = pipeline.step_where(&walk.scene, par, may);
        assert!(step.report().undecided().is_empty());
        remembered += step.report().resolved(Method::Remembered);
        let reported = Reported {
            aabbs: step.aabbs().to_vec(),
            candidates: step.candidates().collect(),
            contacts: step.contacts().collect(),
            events: events.follow(&walk.scene, &step, par).unwrap().iter().collect(),
        };
        look(frame, &walk.scene, reported);
        walk.advance();
    }
    remembered
}

/// The plainest comparison of two sets of touching objects.
fn events_between(before: &[(Handle, Handle)], now: &[(Handle, Handle)]) -> Vec<Event> {
    let mut changes: BTreeMap<_, _> = before.iter().map(|&pair| (pair, Change::End)).collect();
    for &pair in now {
        let known = changes.contains_key(&pair);
        changes.insert(pair, if known { Change::Stay } else { Change::Begin });
    }
    let mut events: Vec<Event> =
        changes.into_iter().map(|((a, b), change)| Event { a, b, change }).collect();
    events.sort_by_key(|event| (event.pair(), event.change));
    events
}

#[test]
fn every_frame_of_a_thousand_is_that_of_a_fresh_pipeline_at_any_thread_count() {
    let mut frames = Vec::new();
    let mut before = Vec::new();
    let mut counts = [0; 3];
    let remembered = run(Overlap::default(), Par::Serial, |frame, scene, reported| {
        let mut fresh = Pipeline::new();
        let step = fresh.step_where(scene, Par::Serial, may);
        assert_eq!(reported.aabbs, step.aabbs(), "boxes of frame {frame}");
        assert!(reported.candidates.iter().copied().eq(step.candidates()), "candidates of {frame}");
        assert!(reported.contacts.iter().copied().eq(step.contacts()), "contacts of frame {frame}");
        for &(i, j) in &reported.contacts {
            assert!(scene.allows(i, j) && may(i, j), "{i} and {j} in frame {frame}");
        }
        let handle = |i: u32| scene.handle(i as usize).unwrap();
        let now: Vec<_> = reported.contacts.iter().map(|&(i, j)| (handle(i), handle(j))).collect();
        assert_eq!(reported.events, events_between(&before, &now), "events of frame {frame}");
        reported.events.iter().for_each(|event| counts[event.change as usize] += 1);
        before = now;
        frames.push(reported);
    });
    assert_eq!(remembered, 0);
    // Otherwise the walk would test nothing.
    assert!(counts.iter().all(|&count| count > 1000), "{counts:?}");
    let same = |frame: usize, _: &Scene, reported| {
        assert!(reported == frames[frame], "frame {frame}");
    };
    for threads in [1, 2, 3] {
        let run = || {
            run(Overlap::default(), Par::Pool, same);
            run(Coherent::default(), Par::Pool, same)
        };
        let remembered = with_threads(threads, run).unwrap();
        let candidates: usize = frames.iter().map(|reported| reported.candidates.len()).sum();
        assert!(remembered > candidates as u64 / 10, "{remembered} of {candidates}");
    }
}

/// The default narrow phase, which counts the objects that it prepares.
struct Counting(Overlap, &'static AtomicUsize);

impl NarrowPhase for Counting {
    type Answer = <Overlap as NarrowPhase>::Answer;
    type Frame = <Overlap as NarrowPhase>::Frame;
    type Part<'f> = <Overlap as NarrowPhase>::Part<'f>;
    type Scratch = <Overlap as NarrowPhase>::Scratch;

    fn layout<'f>(
        &self,
        scene: &Scene,
        sides: Sides,
        frame: &'f mut Self::Frame,
    ) -> Self::Part<'f> {
        self.0.layout(scene, sides, frame)
    }

    fn keeps(&self, part: &Self::Part<'_>) -> bool {
        self.0.keeps(part)
    }

    fn prepare(&self, scene: &Scene, first: usize, part: Self::Part<'_>, aabbs: &mut [Aabb]) {
        self.1.fetch_add(aabbs.len(), Ordering::Relaxed);
        self.0.prepare(scene, first, part, aabbs);
    }

    fn decide(
        &self,
        a: Prepared<'_, Self::Frame>,
        b: Prepared<'_, Self::Frame>,
        pairs: &[Pair],
        scratch: &mut Self::Scratch,
        sink: &mut ContactSink<'_, Self::Answer>,
    ) {
        self.0.decide(a, b, pairs, scratch, sink);
    }
}

#[test]
fn what_was_known_at_rest_serves_the_first_fast_frames_and_fast_ones_keep_nothing() {
    // Dense enough for a look-up to cost little beside an answer.
    let spec = SceneSpec::parse("paper").unwrap().with_objects(2500).with_seed(4);
    let mut scene = spec.scene().unwrap();
    let mut walk = RandomWalk::new(0.02, 11).unwrap();
    let mut coherent = Pipeline::with(WideTree::default(), Coherent::default());
    let mut fresh = Pipeline::new();
    let mut known = Vec::new();
    for walks in [false, false, true, true, true, true, true, false, false] {
        if walks {
            walk.step(&mut scene).unwrap();
        }
        let step = coherent.step(&scene, Par::Pool);
        let candidates = step.candidate_count() as f64;
        known.push(step.report().resolved(Method::Remembered) as f64 / candidates);
        assert!(step.contacts().eq(fresh.step(&scene, Par::Pool).contacts()), "{known:?}");
    }
    let [first, at_rest, fast, .., still_fast, slow, slow_again] = known[..] else { panic!() };
    assert!(first == 0.0 && at_rest > 0.99 && fast > 0.2, "{known:?}");
    assert!(still_fast == 0.0 && slow < 0.5 && slow_again > 0.99, "{known:?}");
}

#[test]
fn static_objects_are_prepared_once_until_something_of_them_changes() {
    let spec = SceneSpec::parse("sparse").unwrap().with_objects(2000);
    let plain = spec.scene().unwrap();
    let objects = (0..2000).map(|i| {
        let object = Object::new(i, plain.poses()[i as usize]);
        if i < 1900 { object.fixed() } else { object }
    });
    let mut scene = Scene::new(plain.shapes().to_vec(), objects).unwrap();
    static COUNT: AtomicUsize = AtomicUsize::new(0);
    let narrow = Counting(Overlap::default(), &COUNT);
    let mut pipeline = Pipeline::with(dcd_broad::WideTree::default(), narrow);
    let mut prepared = |scene: &Scene| {
        pipeline.step(scene, Par::Serial);
        COUNT.swap(0, Ordering::Relaxed)
    };
    assert_eq!(prepared(&scene), 2000);
    assert_eq!(prepared(&scene), 100);
    scene.set_pose(1950, Pose::IDENTITY).unwrap();
    assert_eq!(prepared(&scene), 100);
    scene.set_pose(7, Pose::IDENTITY).unwrap();
    assert_eq!(prepared(&scene), 2000);
    assert_eq!(prepared(&scene), 100);
    scene.remove(scene.handle(1999).unwrap()).unwrap();
    assert_eq!(prepared(&scene), 2000);
    assert_eq!(prepared(&scene), 99);
    // Another scene between, whose AABBs and frame take the same memory.
    assert_eq!(prepared(&plain), 2000);
    assert_eq!(prepared(&scene), 2000);
}

#[test]
fn static_objects_between_moving_ones_are_left_alone() {
    let spec = SceneSpec::parse("sparse").unwrap().with_objects(2000);
    let plain = spec.scene().unwrap();
    // One moving object in a hundred, and two of them side by side.
    let moves = |i: u32| i.is_multiple_of(100) || i == 101;
    let objects = (0..2000).map(|i| {
        let object = Object::new(i, plain.poses()[i as usize]);
        if moves(i) { object } else { object.fixed() }
    });
    let scene = Scene::new(plain.shapes().to_vec(), objects).unwrap();
    static COUNT: AtomicUsize = AtomicUsize::new(0);
    let narrow = Counting(Overlap::default(), &COUNT);
    let mut pipeline = Pipeline::with(dcd_broad::WideTree::default(), narrow);
    let first: Vec<_> = pipeline.step(&scene, Par::Serial).contacts().collect();
    assert_eq!(COUNT.swap(0, Ordering::Relaxed), 2000);
    let second: Vec<_> = pipeline.step(&scene, Par::Serial).contacts().collect();
    assert_eq!(COUNT.swap(0, Ordering::Relaxed), 21);
    assert_eq!(first, second);
}

#[test]
fn static_objects_touch_the_moving_ones_and_never_each_other() {
    let mut walk = Walk::new();
    let mut brute: Vec<(u32, u32)> = Vec::new();
    let mut plain = Pipeline::with(dcd_broad::BruteForce, Overlap::default());
    for _ in 0..20 {
        // The same objects, all of them moving.
        let objects = (0..walk.scene.len()).map(|i| Object {
            filter: walk.scene.filters()[i],
            ..Object::new(walk.scene.shape_of()[i], walk.scene.poses()[i])
        });
        let all = Scene::new(walk.scene.shapes().to_vec(), objects).unwrap();
        brute.clear();
        brute.extend(plain.step(&all, Par::Serial).contacts());
        brute.retain(|&(i, j)| walk.scene.allows(i, j));
        let mut reported: Vec<_> =
            Pipeline::new().step(&walk.scene, Par::Serial).contacts().collect();
        reported.sort_unstable();
        assert_eq!(reported, brute);
        walk.advance();
    }
}
