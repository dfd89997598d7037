//! Queries after steps of a scene that changes, beside those of a pipeline that has seen nothing.

use super::*;

/// Changes some objects of a scene, in any order.
fn change(scene: &mut Scene, random: &mut Random) {
    let below =
        |random: &mut Random, end: usize| ((random.next() + 1.0) / 2.0 * end as f64) as usize % end;
    for _ in 0..below(random, 12) {
        let object = below(random, scene.len());
        let shape = below(random, scene.shapes().len()) as u32;
        let turn = DQuat::from_scaled_axis(random.vector() * 3.0);
        let pose = Pose::new(turn, random.vector() * 4.0).unwrap();
        if scene.motion(object).is_none() {
            scene.insert(Object::new(shape, pose)).unwrap();
            continue;
        }
        match below(random, 9) {
            0 | 1 => scene.set_pose(object, pose).unwrap(),
            2 => {
                let motion = if random.next() > 0.0 { Motion::Moving } else { Motion::Static };
                scene.set_motion(object, motion).unwrap();
            }
            3 => scene.set_shape(object, shape).unwrap(),
            4 => scene.set_sensor(object, random.next() > 0.0).unwrap(),
            5 => scene
                .set_filter(object, Filter { groups: 1 << (shape % 3), mask: u32::MAX })
                .unwrap(),
            6 => {
                let handle = scene.handle(object).unwrap();
                scene.remove(handle).unwrap();
            }
            7 if scene.len() > 6 && scene.motion(scene.len() - 1).is_some() => {
                scene.swap_remove(object).unwrap()
            }
            _ => {
                let object = Object::new(shape, pose);
                scene.insert(if random.next() > 0.0 { object.fixed() } else { object }).unwrap();
            }
        }
    }
}

#[test]
fn queries_of_a_scene_that_changes_are_those_of_a_pipeline_that_has_seen_nothing() {
    let mut random = Random::seeded(61);
    let mut met = 0;
    for round in 0..6 {
        let mut scene = scene([9, 60, 200][round % 3]);
        let mut held = Pipeline::new();
        for step in 0..12 {
            change(&mut scene, &mut random);
            held.step(&scene, Par::Serial);
            let mut anew = Pipeline::new();
            anew.step(&scene, Par::Serial);
            let rays = rays(&scene, 40);
            let sphere = Shape::sphere(0.1).unwrap();
            let motions: Vec<RigidMotion> = rays
                .iter()
                .map(|ray| RigidMotion {
                    linear: ray.direction(),
                    ..RigidMotion::at_rest(Pose::from_translation(ray.origin()).unwrap())
                })
                .collect();
            for filter in &filters() {
                let answers = |pipeline: &Pipeline| {
                    let queries = pipeline.queries(&scene).unwrap();
                    let (mut all, mut found) = (Vec::new(), Vec::new());
                    let mut said = String::new();
                    for (ray, motion) in rays.iter().zip(&motions) {
                        let point = ray.at(0.3);
                        queries.all_hits(ray, filter, &mut all);
                        queries.in_sphere(point, 0.5, filter, &mut found).unwrap();
                        let nearest = queries.nearest(point, f64::INFINITY, filter).unwrap();
                        let first = queries.first_hit(ray, filter);
                        let is_met = queries.any_hit(ray, filter).is_some();
                        said += &format!("{all:?} {found:?} {nearest:?} {first:?} {is_met} ");
                        let moving = MovingShape { shape: &sphere, motion };
                        // Of what is met at one time any is the first.
                        let impact = queries.cast(moving, 1.0, 1e-6, filter).unwrap();
                        said += &format!(
                            "{:?} ",
                            impact.map(|found| match found.impact {
                                Impact::Hit { t, .. } | Impact::Undecided { free_until: t } => t,
                                Impact::Free => f64::NAN,
                            })
                        );
                    }
                    (said, all.len())
                };
                let ((ours, count), (due, _)) = (answers(&held), answers(&anew));
                assert!(ours == due, "round {round}, step {step}: {ours}\n{due}");
                met += count;
            }
        }
    }
    assert!(met > 100, "{met}");
}
