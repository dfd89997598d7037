//! Sensors: what touches them is listed apart from the contacts, and never measured.

use dcd_broad::WideTree;
use dcd_exec::with_threads;
use dcd_geom::glam::DVec3;
use dcd_geom::{Object, Pose, Scene, Shape};
use dcd_gjk::{
    Coherent, Contact, Depths, Method, NarrowPhase, PairSolver, Pairwise, PosedShape, ThenMeasure,
    Verdict,
};
use dcd_pipeline::{Change, Events, Overlap, Par, Pipeline};
use dcd_scenes::SceneSpec;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Every third object a sensor, every fourth static.
fn scene() -> (Scene, Scene) {
    let solid = SceneSpec::parse("paper").unwrap().with_objects(300).with_seed(9).scene().unwrap();
    let objects = (0..solid.len()).map(|i| {
        let object = Object::new(solid.shape_of()[i], solid.poses()[i]);
        if i % 4 == 0 { object.fixed() } else { object }
    });
    let solid = Scene::new(solid.shapes().to_vec(), objects).unwrap();
    let mut sensing = solid.clone();
    (0..solid.len()).step_by(3).for_each(|i| sensing.set_sensor(i, true).unwrap());
    (solid, sensing)
}

fn is_sensed(pair: (u32, u32)) -> bool {
    pair.0.is_multiple_of(3) || pair.1.is_multiple_of(3)
}

/// Contacts with their answers, and what was sensed.
type Reported<A> = (Vec<Contact<A>>, Vec<(u32, u32)>);

fn reported<N: NarrowPhase + Send>(narrow: N, scene: &Scene, par: Par) -> Reported<N::Answer> {
    let mut pipeline = Pipeline::with(WideTree::default(), narrow);
    // A second step, so that whoever remembers does.
    pipeline.step(scene, par);
    let step = pipeline.step(scene, par);
    (step.answers().collect(), step.sensor_pairs().collect())
}

fn check<N>(narrow: impl Fn() -> N + Sync)
where
    N: NarrowPhase<Answer: PartialEq + std::fmt::Debug> + Send,
{
    let (solid, sensing) = scene();
    let (all, none) = reported(narrow(), &solid, Par::Serial);
    assert!(none.is_empty());
    let (contacts, mut sensed) = reported(narrow(), &sensing, Par::Serial);
    for threads in [1, 3] {
        let again = with_threads(threads, || reported(narrow(), &sensing, Par::Pool)).unwrap();
        assert!(again == (contacts.clone(), sensed.clone()), "{threads} threads");
    }
    let due = all.iter().filter(|contact| !is_sensed(contact.pair.into()));
    assert!(due.eq(&contacts) && contacts.len() > 50, "{}", contacts.len());
    let pairs = all.iter().map(|contact| contact.pair.into());
    let mut due: Vec<(u32, u32)> = pairs.filter(|&pair| is_sensed(pair)).collect();
    due.sort_unstable();
    sensed.sort_unstable();
    assert!(sensed == due && due.len() > 50, "{}", due.len());
}

#[test]
fn contacts_and_what_is_sensed_together_are_the_contacts_without_sensors() {
    check(Overlap::default);
    check(Coherent::default);
    check(|| ThenMeasure::new(Depths).unwrap());
    check(|| Pairwise(dcd_gjk::Certified));
}

#[test]
fn what_touches_a_sensor_is_never_measured() {
    #[derive(Default)]
    struct Counting(AtomicUsize);
    impl PairSolver for &Counting {
        type Answer = ();
        type Scratch = ();
        fn method(&self) -> Method {
            Method::Foreign
        }
        fn solve(&self, _: PosedShape<'_>, _: PosedShape<'_>, (): &mut ()) -> Verdict<()> {
            self.0.fetch_add(1, Ordering::Relaxed);
            Verdict::Touching(())
        }
    }
    // For the solver's type must outlive every frame.
    let counting: &'static Counting = Box::leak(Box::default());
    let (_, sensing) = scene();
    let mut pipeline = Pipeline::with(WideTree::default(), ThenMeasure::new(counting).unwrap());
    let step = pipeline.step(&sensing, Par::Serial);
    assert!(step.sensor_pairs().count() > 50);
    assert_eq!(counting.0.load(Ordering::Relaxed), step.contact_count());
}

#[test]
fn what_enters_and_leaves_a_sensor_is_an_event_of_its_own_list() {
    let at = |x: f64| Pose::from_translation(DVec3::X * x).unwrap();
    let shapes = vec![Shape::cuboid(DVec3::ONE).unwrap(), Shape::sphere(0.5).unwrap()];
    let gate = Object::new(0, at(0.0)).fixed().as_sensor();
    let mut scene = Scene::new(shapes, [gate, Object::new(1, at(-3.0))]).unwrap();
    let (mut pipeline, mut contacts, mut sensed) =
        (Pipeline::new(), Events::default(), Events::default());
    let mut changes = Vec::new();
    for x in [-3.0, -1.0, 0.0, 3.0] {
        scene.set_pose(1, at(x)).unwrap();
        let step = pipeline.step(&scene, Par::Serial);
        assert!(contacts.follow(&scene, &step, Par::Serial).unwrap().is_empty());
        sensed.follow_sensors(&scene, &step, Par::Serial).unwrap();
        changes.extend(sensed.iter().map(|event| event.change));
    }
    assert_eq!(changes, [Change::Begin, Change::Stay, Change::End]);
    // Solid again, and its slot is no sensor for who comes next.
    scene.set_pose(1, at(0.0)).unwrap();
    scene.set_sensor(0, false).unwrap();
    assert_eq!(pipeline.step(&scene, Par::Serial).contact_count(), 1);
    scene.set_sensor(0, true).unwrap();
    scene.remove(scene.handle(0).unwrap()).unwrap();
    scene.insert(Object::new(0, at(0.0))).unwrap();
    assert!(!scene.has_sensors());
    assert_eq!(pipeline.step(&scene, Par::Serial).contact_count(), 1);
}
