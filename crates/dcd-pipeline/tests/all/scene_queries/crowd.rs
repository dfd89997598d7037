//! A point that several objects hold, and rays from there.

use super::*;

#[test]
fn of_several_objects_that_hold_a_point_the_least_is_the_nearest_and_met_first() {
    // Of few objects all boxes are looked at once.
    for (objects, spread) in [(600, 1.0), (16, 0.2)] {
        the_least_is_the_nearest_and_met_first(objects, spread);
    }
}

/// Of so many hulls, whose distances from the middle are multiplied.
fn the_least_is_the_nearest_and_met_first(objects: usize, spread: f64) {
    let paper = SceneSpec::paper().with_objects(objects).with_seed(5).scene().unwrap();
    // One shape in five is swept, so that points lie between its core and its surface too.
    let shape = |k: usize| match paper.shape(k) {
        shape if k.is_multiple_of(5) => shape.swept(0.05).unwrap(),
        shape => shape.clone(),
    };
    let placed = (0..paper.len()).map(|k| {
        let pose = paper.poses()[k];
        let turn = DQuat::from_mat3(pose.rotation());
        let pose = Pose::new(turn, pose.translation() * spread).unwrap();
        let object = Object::new(k as u32, pose);
        if k.is_multiple_of(2) { object.fixed() } else { object }
    });
    let scene = Scene::new((0..paper.len()).map(shape).collect(), placed).unwrap();
    let mut pipeline = Pipeline::new();
    pipeline.step(&scene, Par::Serial);
    let queries = pipeline.queries(&scene).unwrap();
    let (mut random, sphere) = (Random::seeded(59), Shape::sphere(0.0).unwrap());
    let mut crowds = 0;
    for round in 0..300 {
        let middle = scene.poses()[round % scene.len()].translation();
        let point = middle + random.vector() * 0.3;
        let at = Pose::from_translation(point).unwrap();
        let point_object = PosedShape { shape: &sphere, pose: &at };
        let holds = |&k: &u32| {
            let (verdict, _) = certified::overlap_of(point_object, PosedShape::of(&scene, k));
            verdict == Verdict::Touching(())
        };
        let due: Vec<u32> = (0..scene.len() as u32).filter(holds).collect();
        let found = queries.nearest(point, f64::INFINITY, &QueryFilter::ALL).unwrap().unwrap();
        if let Some(&least) = due.first() {
            assert_eq!((found.object, found.distance), (least, 0.0), "round {round} of {due:?}");
            let ray = Ray::endless(point, random.vector()).unwrap();
            let found = queries.first_hit(&ray, &QueryFilter::ALL).unwrap();
            assert_eq!((found.object, found.hit.t), (least, 0.0), "round {round} of {due:?}");
            assert_eq!(found.hit.normal, DVec3::ZERO);
        } else {
            assert!(found.upper > 0.0, "round {round}: {found:?}");
        }
        crowds += usize::from(due.len() > 1);
    }
    assert!(crowds > 20, "{crowds}");
}
