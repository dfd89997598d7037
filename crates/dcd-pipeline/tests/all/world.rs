//! Configurations against a world: what a scene of each alone says, at any thread count.

use dcd_broad::BruteForce;
use dcd_exec::with_threads;
use dcd_geom::glam::DVec3;
use dcd_geom::{Aabb, Filter, Object, Pair, Pose, Scene, SceneError, Shape};
use dcd_gjk::{
    Certified, ContactSink, Method, PairSolver, Pairwise, PosedShape, Prepared, Reason, Sides,
    Verdict, Within,
};
use dcd_pipeline::{
    BatchChecker, Candidate, Hit, LinkSet, NarrowPhase, Other, Overlap, PairDecider, Par, Pipeline,
    StaticWorld,
};
use dcd_scenes::SceneSpec;

/// Obstacles in a cube, one slot free, some that only robots of group 2 meet.
fn obstacles() -> Scene {
    let spec = SceneSpec::parse("paper").unwrap().with_objects(70).with_seed(21);
    let paper = spec.scene().unwrap();
    let objects = (0..70).map(|i| {
        let object = Object::new(i, paper.poses()[i as usize]);
        match i % 7 {
            0 => object.fixed(),
            1 => Object { filter: Filter { groups: 2, mask: u32::MAX }, ..object },
            _ => object,
        }
    });
    let mut scene = Scene::new(paper.shapes().to_vec(), objects).unwrap();
    scene.remove(scene.handle(13).unwrap()).unwrap();
    scene
}

fn shapes() -> Vec<Shape> {
    let spec = SceneSpec::parse("needles").unwrap().with_objects(3).with_seed(4);
    let mut shapes = spec.scene().unwrap().shapes().to_vec();
    shapes.push(Shape::sphere(0.3).unwrap());
    shapes.push(Shape::cuboid(DVec3::new(0.3, 0.2, 0.6)).unwrap());
    shapes
}

const UNMET: Filter = Filter { groups: 1, mask: 1 };
const EXCEPT: [(usize, usize); 2] = [(0, 1), (4, 3)];

/// Five links, the last of which misses the obstacles of group 2.
fn link_set() -> LinkSet {
    let link_set = LinkSet::new(shapes()).with_filter(4, UNMET).unwrap();
    link_set.against_itself(&EXCEPT).unwrap()
}

/// More configurations than are worked on at once, some of them far away.
fn poses() -> Vec<Pose> {
    let spec = SceneSpec::parse("paper").unwrap().with_objects(5 * 600).with_seed(8);
    let paper = spec.scene().unwrap();
    let spread = |(k, pose): (usize, &Pose)| {
        let base = paper.poses()[k / 5 * 5].translation() * if k / 5 % 3 == 0 { 1.0 } else { 2.0 };
        Pose::from_matrix(*pose.rotation(), base + pose.translation() * 0.4).unwrap()
    };
    paper.poses().iter().enumerate().map(spread).collect()
}

/// What touches in a scene of the obstacles and one configuration, every pair judged exactly.
fn alone(obstacles: &Scene, configuration: u32, poses: &[Pose]) -> Vec<(u32, u32, Other)> {
    let mut scene = obstacles.clone();
    // Free slots would be taken by links.
    while scene.object_count() < scene.len() {
        let far = Pose::from_translation(DVec3::splat(1e6)).unwrap();
        scene.insert(Object::new(0, far)).unwrap();
    }
    let first = scene.len() as u32;
    let added = scene.add_shapes(shapes()).unwrap();
    for (k, (shape, &pose)) in added.zip(poses).enumerate() {
        let filter = if k == 4 { UNMET } else { Filter::ALL };
        scene.insert(Object { filter, ..Object::new(shape, pose) }).unwrap();
    }
    let mut pipeline = Pipeline::with(BruteForce, Pairwise(Certified));
    let step = pipeline.step_where(&scene, Par::Serial, |i, j| {
        let (k, l) =
            ((i as usize).wrapping_sub(first as usize), (j as usize).wrapping_sub(first as usize));
        j >= first && !EXCEPT.contains(&(k, l)) && !EXCEPT.contains(&(l, k))
    });
    let other = |i: u32| if i < first { Other::Obstacle(i) } else { Other::Link(i - first) };
    let mut touching: Vec<_> =
        step.contacts().map(|(i, j)| (configuration, j - first, other(i))).collect();
    touching.sort_unstable();
    touching
}

fn reported(hit: &Hit<()>) -> (u32, u32, Other) {
    assert!(hit.touches());
    (hit.configuration, hit.link, hit.other)
}

#[test]
fn every_configuration_gets_what_a_scene_of_its_own_says() {
    let (obstacles, poses) = (obstacles(), poses());
    let due: Vec<Vec<_>> =
        (0..).zip(poses.chunks(5)).map(|(c, poses)| alone(&obstacles, c, poses)).collect();
    assert!(due.iter().any(Vec::is_empty) && due.iter().any(|due| due.len() > 3));
    let own = |touch: &&(u32, u32, Other)| matches!(touch.2, Other::Link(_));
    assert!(due.iter().flatten().filter(own).count() > 10);

    let world = StaticWorld::new(&obstacles, Overlap::default(), Par::Serial).unwrap();
    let mut checker = world.checker(link_set()).unwrap();
    for _ in 0..2 {
        let first = checker.first(&poses, Par::Serial).unwrap();
        assert_eq!(first.len(), due.len());
        for (found, due) in first.iter().zip(&due) {
            assert_eq!(found.is_some(), !due.is_empty());
            assert!(
                found.iter().all(|found| due.contains(&reported(found))),
                "{found:?} of {due:?}"
            );
        }
        let mut all: Vec<_> = checker
            .all(&poses, Par::Serial)
            .unwrap()
            .iter()
            .map(|found| reported(&found))
            .collect();
        assert!(all.iter().map(|touch| touch.0).is_sorted());
        all.sort_unstable();
        assert_eq!(all, due.concat());
    }
}

#[test]
fn a_checker_outlives_its_world_and_takes_another_one() {
    let poses = poses();
    let world_of =
        |scene: &Scene| StaticWorld::new(scene, Overlap::default(), Par::Serial).unwrap();
    let answers = |checker: &mut BatchChecker| {
        let first = checker.first(&poses, Par::Serial).unwrap().to_vec();
        let all: Vec<_> = checker.all(&poses, Par::Serial).unwrap().iter().collect();
        (first, all)
    };
    // Other obstacles, more and fewer, and none.
    let mut fewer = obstacles();
    (0..fewer.len()).step_by(2).for_each(|i| fewer.remove(fewer.handle(i).unwrap()).unwrap_or(()));
    let mut more = obstacles();
    let far = Pose::from_translation(DVec3::splat(0.25)).unwrap();
    more.insert(Object::new(0, far)).unwrap();
    let mut checker = world_of(&obstacles()).checker(link_set()).unwrap();
    answers(&mut checker);
    for scene in [fewer, more, Scene::default(), obstacles()] {
        checker.set_world(world_of(&scene)).unwrap();
        let fresh = &mut world_of(&scene).checker(link_set()).unwrap();
        assert!(answers(&mut checker) == answers(fresh), "{} obstacles", scene.object_count());
    }
}

#[test]
fn the_answers_and_their_order_are_one_at_any_thread_count() {
    let (obstacles, poses) = (obstacles(), poses());
    let run = |par| {
        let world = StaticWorld::new(&obstacles, Overlap::default(), par).unwrap();
        let mut checker = world.checker(link_set()).unwrap();
        let first = checker.first(&poses, par).unwrap().to_vec();
        // A smaller batch between.
        checker.first(&poses[..35], par).unwrap();
        let again = checker.first(&poses, par).unwrap().to_vec();
        assert_eq!(first, again);
        let all: Vec<_> = checker.all(&poses, par).unwrap().iter().collect();
        (first, all)
    };
    let serial = run(Par::Serial);
    for threads in [1, 2, 3, 7] {
        assert!(with_threads(threads, || run(Par::Pool)).unwrap() == serial, "{threads} threads");
    }
}

#[test]
fn the_hit_of_a_configuration_does_not_depend_on_its_batch() {
    let (obstacles, poses) = (obstacles(), poses());
    let world = StaticWorld::new(&obstacles, Overlap::default(), Par::Serial).unwrap();
    let mut checker = world.checker(link_set()).unwrap();
    let hits = |found: &[Option<Hit<()>>]| -> Vec<_> {
        found.iter().map(|found| found.map(|found| (found.link, found.other))).collect()
    };
    let due = hits(checker.first(&poses, Par::Serial).unwrap());
    assert!(due.iter().flatten().any(|(_, other)| matches!(other, Other::Link(_))));
    let mut alone = Vec::new();
    for poses in poses.chunks(5) {
        alone.extend(hits(checker.first(poses, Par::Serial).unwrap()));
    }
    assert_eq!(alone, due);
    let backwards: Vec<Pose> = poses.chunks(5).rev().flatten().copied().collect();
    let mut backwards = hits(checker.first(&backwards, Par::Serial).unwrap());
    backwards.reverse();
    assert_eq!(backwards, due);
    // So many that more of them are taken up at once.
    let many = poses.repeat(2500 / due.len() + 1);
    let mut many = hits(checker.first(&many, Par::Serial).unwrap());
    assert!(many.len() > 2048);
    assert!(many.chunks(due.len()).all(|hits| hits == due));
    many = hits(checker.first(&poses, Par::Serial).unwrap());
    assert_eq!(many, due);
}

#[test]
fn what_cannot_be_decided_is_reported_and_a_contact_comes_before_it() {
    /// Knows spheres alone.
    struct Spheres;
    impl PairSolver for Spheres {
        type Answer = ();
        type Scratch = ();
        fn method(&self) -> Method {
            Method::Foreign
        }
        fn solve(&self, a: PosedShape<'_>, b: PosedShape<'_>, (): &mut ()) -> Verdict<()> {
            let is_sphere =
                |p: &PosedShape<'_>| p.shape.as_polytope().unwrap().vertices().len() == 1;
            match is_sphere(&a) && is_sphere(&b) {
                true => Certified.solve(a, b, &mut Default::default()),
                false => Verdict::Undecided(Reason::Foreign),
            }
        }
    }
    let (sphere, cube) = (Shape::sphere(1.0).unwrap(), Shape::cuboid(DVec3::ONE).unwrap());
    let obstacle = Scene::new(vec![sphere.clone()], [Object::new(0, Pose::IDENTITY)]).unwrap();
    let world = StaticWorld::new(&obstacle, Pairwise(Spheres), Par::Serial).unwrap();
    let mut checker = world.checker(LinkSet::new(vec![cube, sphere])).unwrap();
    let at = |x: f64| Pose::from_translation(DVec3::X * x).unwrap();
    let batch = [at(0.0), at(9.0), at(0.0), at(1.0), at(9.0), at(9.0)];
    let undecided = Verdict::Undecided(Reason::Foreign);
    let first = checker.first(&batch, Par::Serial).unwrap();
    assert_eq!(first[0].map(|found| (found.link, found.verdict)), Some((0, undecided)));
    assert_eq!(first[1].map(|found| (found.link, found.verdict)), Some((1, Verdict::Touching(()))));
    assert_eq!(first[2], None);
    let all: Vec<_> = checker.all(&batch, Par::Serial).unwrap().iter().collect();
    let short = |found: &Hit<()>| (found.configuration, found.link, found.verdict);
    assert_eq!(
        all.iter().map(short).collect::<Vec<_>>(),
        [(0, 0, undecided), (1, 1, Verdict::Touching(())), (1, 0, undecided)]
    );
}

#[test]
fn a_link_that_is_out_of_range_unmoved_is_refused_by_its_number() {
    let world = StaticWorld::new(&obstacles(), Overlap::default(), Par::Serial).unwrap();
    let far = Shape::segment(DVec3::ZERO, DVec3::X * 1e300).unwrap();
    let links = LinkSet::new(vec![Shape::sphere(1.0).unwrap(), far]);
    let refused = world.checker(links).map(|_| ());
    assert!(
        matches!(refused, Err(SceneError::OutOfRange { object: 1, reach }) if reach >= 1e300),
        "{refused:?}"
    );
}

#[test]
fn a_decider_asks_for_each_pose_once_and_refuses_it_as_a_scene_does() {
    let world = StaticWorld::new(&obstacles(), Overlap::default(), Par::Serial).unwrap();
    let sphere = Shape::sphere(1.0).unwrap();
    let decider: PairDecider = PairDecider::new(LinkSet::new(vec![sphere; 2]), 4).unwrap();
    let of = |configuration| Candidate { configuration, link: 1, other: Other::Link(0) };
    let far = Pose::from_translation(DVec3::splat(1e300)).unwrap();
    for refused in [vec![], vec![(2, 1)], vec![(1, 1), (2, 0)]] {
        let mut posed = Vec::new();
        let pose = |configuration, link| {
            posed.push((configuration, link));
            if refused.contains(&(configuration, link)) { far } else { Pose::IDENTITY }
        };
        let mut hits = 0;
        let found = decider.decide(&world, &[of(1), of(2)], pose, |_| hits += 1);
        posed.sort_unstable();
        assert_eq!(posed, [(1, 0), (1, 1), (2, 0), (2, 1)]);
        // By configuration · links + link, with its largest coordinate and the radius.
        let due = refused.iter().map(|(configuration, link)| 2 * configuration + link).min();
        let due = due.map(|object| SceneError::OutOfRange { object, reach: 1e300 });
        assert_eq!((found.err(), hits), (due, if due.is_some() { 0 } else { 2 }));
    }
}

#[test]
fn a_batch_that_does_not_fit_is_refused_with_what_is_wrong() {
    let world = StaticWorld::new(&obstacles(), Overlap::default(), Par::Serial).unwrap();
    let mut checker = world.checker(link_set()).unwrap();
    let mut poses = poses();
    let lengths = SceneError::LengthsDiffer { shapes: 5, poses: 7 };
    assert_eq!(checker.first(&poses[..7], Par::Serial), Err(lengths));
    assert_eq!(checker.all(&poses[..7], Par::Serial).map(|_| ()), Err(lengths));
    let far = Pose::from_translation(DVec3::splat(2e37)).unwrap();
    (poses[423], poses[617]) = (far, far);
    for par in [Par::Serial, Par::Pool] {
        let refused = checker.all(&poses, par).map(|_| ());
        assert!(
            matches!(refused, Err(SceneError::OutOfRange { object: 423, reach }) if reach >= 2e37)
        );
    }
    // A first hit reports it only where no other link touches; also in larger tasks.
    poses[420..425].fill(far);
    for batch in [poses.repeat(5), poses] {
        let refused = checker.first(&batch, Par::Serial).map(|_| ());
        assert!(matches!(refused, Err(SceneError::OutOfRange { object: 420, .. })), "{refused:?}");
    }
    assert!(checker.first(&[], Par::Serial).unwrap().is_empty());
    let unknown = SceneError::NoSuchObject { object: 5, objects: 5 };
    assert_eq!(link_set().against_itself(&[(5, 0)]).map(|_| ()), Err(unknown));
}

#[test]
fn no_obstacle_and_no_link_are_legal_and_touch_nothing() {
    fn count<N: NarrowPhase>(world: &StaticWorld<N>, link_set: LinkSet, poses: &[Pose]) -> usize {
        let mut checker = world.checker(link_set).unwrap();
        checker.all(poses, Par::Pool).unwrap().len()
    }
    let empty = StaticWorld::new(&Scene::default(), Overlap::default(), Par::Serial).unwrap();
    let sphere = || LinkSet::new(vec![Shape::sphere(1.0).unwrap(); 2]);
    assert_eq!(count(&empty, sphere(), &[Pose::IDENTITY; 4]), 0);
    assert_eq!(count(&empty, sphere().against_itself(&[]).unwrap(), &[Pose::IDENTITY; 4]), 2);
    let world = StaticWorld::new(&obstacles(), Overlap::default(), Par::Serial).unwrap();
    assert_eq!(count(&world, LinkSet::new(vec![]), &[]), 0);
}

/// Says nothing of how far its boxes reach, so that every link is posed and prepared.
struct Blind<N>(N);

impl<N: NarrowPhase> NarrowPhase for Blind<N> {
    type Answer = N::Answer;
    type Frame = N::Frame;
    type Part<'f>
        = N::Part<'f>
    where
        Self: 'f;
    type Scratch = N::Scratch;

    fn layout<'f>(&self, scene: &Scene, sides: Sides, frame: &'f mut N::Frame) -> N::Part<'f> {
        self.0.layout(scene, sides, frame)
    }

    fn keeps(&self, part: &N::Part<'_>) -> bool {
        self.0.keeps(part)
    }

    fn prepare(&self, scene: &Scene, first: usize, part: N::Part<'_>, aabbs: &mut [Aabb]) {
        self.0.prepare(scene, first, part, aabbs);
    }

    fn decide(
        &self,
        a: Prepared<'_, N::Frame>,
        b: Prepared<'_, N::Frame>,
        pairs: &[Pair],
        scratch: &mut N::Scratch,
        sink: &mut ContactSink<'_, N::Answer>,
    ) {
        self.0.decide(a, b, pairs, scratch, sink);
    }
}

/// Of every kind that a bound is made of in a way of its own, one far from its frame's origin, and
/// a half-space, which has none.
fn of_every_kind() -> Vec<Shape> {
    let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    let far = DVec3::new(3.0, -2.0, 0.5);
    let place = Pose::from_translation(DVec3::new(0.0, 0.7, -0.2)).unwrap();
    vec![
        Shape::hull(corners.map(|v| v * 0.6 + far).to_vec()).unwrap(),
        Shape::cylinder(0.5, 0.1).unwrap().rounded(0.05).unwrap(),
        Shape::mesh(corners.to_vec(), vec![[0, 1, 2], [1, 2, 3]]).unwrap(),
        Shape::compound(vec![
            (Shape::cuboid(DVec3::splat(0.2)).unwrap(), place),
            (Shape::cone(0.3, 0.2).unwrap(), Pose::IDENTITY),
        ])
        .unwrap(),
        Shape::half_space(DVec3::Z, -2.0).unwrap(),
    ]
}

#[test]
fn what_bounds_pass_over_touches_nothing_whatever_the_shapes_and_the_margin() {
    fn run<N: NarrowPhase<Answer = ()>>(narrow: N) -> (Vec<Hit<()>>, Vec<Option<Hit<()>>>) {
        let world = StaticWorld::new(&obstacles(), narrow, Par::Serial).unwrap();
        let link_set = LinkSet::new(of_every_kind()).against_itself(&[(1, 3)]).unwrap();
        let mut checker = world.checker(link_set).unwrap();
        let all = checker.all(&poses(), Par::Serial).unwrap().iter().collect();
        (all, checker.first(&poses(), Par::Serial).unwrap().to_vec())
    }
    fn check<N: NarrowPhase<Answer = ()> + Clone>(narrow: N) -> usize {
        let (all, first) = run(narrow.clone());
        let (due, due_first) = run(Blind(narrow));
        assert!(all == due);
        // Which of several hits is reported depends on what is known of the links.
        for (first, due) in first.iter().zip(due_first) {
            assert_eq!(first.is_some(), due.is_some());
            assert!(first.iter().all(|first| all.contains(first)));
        }
        for link in 0..5 {
            assert!(all.iter().any(|found| found.link == link && found.touches()), "{link}");
        }
        all.len()
    }
    let touching = check(Overlap::default());
    let within = check(Within::margin(0.25).unwrap());
    assert!(touching > 100 && within > touching, "{touching} and {within}");
}
