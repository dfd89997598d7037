//! Whether every object of a scene is at Parry what and where it is here.

use dcd_exec::{Exec, Par, Segments};
use dcd_geom::glam::DVec3;
use dcd_geom::{Object, Pose, Scene, Shape};
use dcd_parry::{Hit, Library, ParryPipeline, ParryRobot, ParryWorld, Query, Until};

fn at(point: DVec3) -> Pose {
    Pose::from_translation(point).unwrap()
}

fn ball(radius: f64) -> Shape {
    Shape::sphere(radius).unwrap()
}

/// What a robot of the first objects touches.
fn touched_by_robot(scene: &Scene, links: usize) -> Vec<(u32, u32)> {
    let mut robot = ParryRobot::new(scene, links).unwrap();
    let pose = |i: usize| ParryRobot::pose(scene.shape(i), &scene.poses()[i]);
    let poses: Vec<_> = (0..links).map(pose).collect();
    let mut touching = Vec::new();
    assert_eq!(robot.check(&poses, Until::Last, &mut touching), 0);
    touching.iter().map(|pair| (pair.i, pair.j)).collect()
}

/// The obstacles that one link touches, and how many pairs are not answered.
fn touched_in_world<R: Library>(world: &ParryWorld<R>, pose: Pose) -> (Vec<u32>, u64) {
    let mut hits = Segments::default();
    let exec = Exec::from(Par::Serial);
    let unanswered = world.query(&world.place(&[pose]), Until::Last, exec, &mut hits);
    (hits.iter().flatten().map(|hit: &Hit| hit.obstacle).collect(), unanswered)
}

fn world(obstacles: &Scene, link: Shape) -> ParryWorld<f64> {
    ParryWorld::new(obstacles, &[link], Query::IntersectionTest).unwrap()
}

#[test]
fn a_cylinder_or_cone_in_a_compound_stands_along_z() {
    for curved in [Shape::cylinder(2.0, 0.2).unwrap(), Shape::cone(2.0, 0.2).unwrap()] {
        let body = Shape::compound(vec![(curved, Pose::IDENTITY)]).unwrap();
        for (place, touches) in [(DVec3::Z, true), (DVec3::Y, false)] {
            let poses = vec![at(place * 1.9), Pose::IDENTITY];
            let scene = Scene::one_each(vec![ball(0.3), body.clone()], poses).unwrap();
            let expected = if touches { vec![(0, 1)] } else { vec![] };
            let mut rival = ParryPipeline::<f64>::new(&scene, Query::IntersectionTest);
            let mut ready = rival.place(&scene);
            assert_eq!(ready.step(Par::Serial).contact_count(), expected.len());
            assert_eq!(touched_by_robot(&scene, 1), expected);
            let obstacle = Scene::one_each(vec![body.clone()], vec![Pose::IDENTITY]).unwrap();
            let found = touched_in_world(&world(&obstacle, ball(0.3)), at(place * 1.9));
            assert_eq!(found, (vec![0; expected.len()], 0));
        }
    }
}

#[test]
fn a_robots_objects_may_share_shapes_in_any_order() {
    let four = [0.0, 0.4, 0.8, 5.0].map(|x| Object::new(0, at(DVec3::X * x)));
    let scene = Scene::new(vec![ball(0.5)], four).unwrap();
    assert_eq!(touched_by_robot(&scene, 1), [(0, 1), (0, 2)]);
    assert_eq!(touched_by_robot(&scene, 2), [(0, 1), (0, 2), (1, 2)]);
    let shapes = vec![ball(0.5), Shape::cuboid(DVec3::splat(0.5)).unwrap()];
    let objects = [(0, 0.0), (1, 9.0), (1, 0.5)].map(|(k, x)| Object::new(k, at(DVec3::X * x)));
    let scene = Scene::new(shapes, objects).unwrap();
    assert_eq!(touched_by_robot(&scene, 1), [(0, 2)]);
    assert!(ParryRobot::new(&scene, 4).is_none(), "there are three objects");
}

#[test]
fn a_half_space_ends_where_it_does() {
    let shapes = vec![ball(0.5), Shape::half_space(DVec3::Z, 3.0).unwrap()];
    let scene = Scene::one_each(shapes, vec![at(DVec3::Z * 3.2), Pose::IDENTITY]).unwrap();
    assert_eq!(touched_by_robot(&scene, 1), [(0, 1)]);
}

#[test]
fn a_world_says_what_it_is_not_asked_and_what_it_does_not_answer() {
    let egg = || Shape::ellipsoid(DVec3::new(0.2, 0.2, 2.0)).unwrap();
    let obstacles = Scene::one_each(vec![ball(0.1), egg()], vec![Pose::IDENTITY; 2]).unwrap();
    let of_ball = world(&obstacles, ball(0.3));
    assert_eq!(of_ball.refused_obstacles().collect::<Vec<_>>(), [1]);
    assert_eq!(of_ball.refused_links().count(), 0);
    assert_eq!(touched_in_world(&of_ball, Pose::IDENTITY), (vec![0], 0));
    let of_egg = world(&obstacles, egg());
    assert_eq!(of_egg.refused_links().collect::<Vec<_>>(), [0]);
    // So large that squares in f32 have no end.
    let huge = || Shape::cuboid(DVec3::splat(1e30)).unwrap();
    let obstacles = Scene::one_each(vec![huge()], vec![Pose::IDENTITY]).unwrap();
    let world = ParryWorld::<f32>::new(&obstacles, &[huge()], Query::IntersectionTest).unwrap();
    assert_eq!(touched_in_world(&world, Pose::IDENTITY), (vec![], 1));
}

#[test]
fn a_world_has_no_obstacles_that_were_removed() {
    let cube = Shape::cuboid(DVec3::splat(0.5)).unwrap();
    let poses = vec![Pose::IDENTITY, at(DVec3::X * 9.0)];
    let mut scene = Scene::one_each(vec![cube.clone(), cube], poses).unwrap();
    scene.remove(scene.handle(0).unwrap()).unwrap();
    let world = world(&scene, ball(0.3));
    assert_eq!(touched_in_world(&world, Pose::IDENTITY), (vec![], 0));
    assert_eq!(touched_in_world(&world, at(DVec3::X * 9.0)), (vec![1], 0));
}
