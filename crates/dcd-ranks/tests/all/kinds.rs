//! Shapes of every kind, a terrain, a floor without an end, and what ranks refuse.

use crate::common::*;
use dcd_geom::glam::{DQuat, DVec3};
use dcd_geom::{Filter, Motion, Object, Pose, Scene, Shape};
use dcd_gjk::Accuracy;
use dcd_ranks::threads;
use dcd_ranks::{Body, RankError, RankScene, Share, Transport};

/// Half of the terrain's edge, metres.
const HALF: f64 = 12.0;

/// A height over the plane, metres.
fn height(x: f64, y: f64) -> f64 {
    0.8 * (0.7 * x).sin() + 0.6 * (0.5 * y).cos()
}

/// A surface of 2 · 24² triangles.
fn terrain() -> Shape {
    const CELLS: u32 = 24;
    let at = |k: u32| 2.0 * HALF * (f64::from(k) / f64::from(CELLS) - 0.5);
    let vertices = (0..=CELLS).flat_map(|j| (0..=CELLS).map(move |i| (at(i), at(j))));
    let vertices = vertices.map(|(x, y)| DVec3::new(x, y, height(x, y))).collect();
    let corner = |i: u32, j: u32| j * (CELLS + 1) + i;
    let cells = (0..CELLS).flat_map(|j| (0..CELLS).map(move |i| (i, j)));
    let triangles = cells.flat_map(|(i, j)| {
        let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i, j + 1), corner(i + 1, j + 1)];
        [[a, b, d], [a, d, c]]
    });
    Shape::mesh(vertices, triangles.collect()).unwrap()
}

/// One of each kind that ranks exchange but half-spaces.
fn kinds() -> Vec<Shape> {
    let points = (0..14).map(|k| {
        let turn = f64::from(k);
        DVec3::new((2.4 * turn).cos(), (2.4 * turn).sin(), 0.15 * turn - 1.0) * 0.5
    });
    let up = Pose::new(DQuat::from_rotation_x(0.7), DVec3::Z * 0.4).unwrap();
    let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].map(|corner| corner * 0.9);
    vec![
        Shape::hull(points.collect()).unwrap(),
        Shape::cuboid(DVec3::new(0.3, 0.5, 0.2)).unwrap(),
        Shape::sphere(0.4).unwrap(),
        Shape::capsule(0.5, 0.2).unwrap(),
        Shape::segment(-DVec3::X, DVec3::X).unwrap(),
        Shape::triangle([DVec3::X, DVec3::Y, DVec3::Z]).unwrap(),
        Shape::cylinder(0.4, 0.3).unwrap(),
        Shape::cone(0.5, 0.4).unwrap().rounded(0.05).unwrap(),
        Shape::mesh(corners.into(), vec![[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]).unwrap(),
        Shape::compound(vec![
            (Shape::cuboid(DVec3::new(0.5, 0.1, 0.1)).unwrap(), Pose::IDENTITY),
            (Shape::cylinder(0.3, 0.15).unwrap(), up),
            (Shape::sphere(0.2).unwrap(), up),
        ])
        .unwrap(),
    ]
}

/// So many bodies of all kinds a little above and below the terrain's height, crowded towards one corner; with
/// what is as large as their world.
fn scene(bodies: u32, large: &[(Shape, Pose)]) -> Scene {
    let mut shapes = kinds();
    let count = shapes.len() as u32;
    let mut objects: Vec<Object> = (0..bodies)
        .map(|k| {
            // Fractions of multiples of irrational numbers.
            let [u, v, w] = [0.754_877_666, 0.569_840_291, 0.438_579_021]
                .map(|irrational: f64| (f64::from(k + 1) * irrational).fract());
            let (x, y) = (HALF * (2.0 * u * u - 1.0), HALF * (2.0 * v - 1.0));
            let axis = DVec3::new(u - 0.5, v - 0.5, w + 0.1).normalize();
            let spot = DVec3::new(x, y, height(x, y) + 1.6 * (w - 0.4));
            Object::new(k % count, Pose::new(DQuat::from_axis_angle(axis, 9.0 * w), spot).unwrap())
        })
        .collect();
    for (place, (shape, pose)) in large.iter().enumerate() {
        // Among the others, so that neither name is always the smaller.
        objects
            .insert((place * 31 + 7).min(objects.len()), Object::new(shapes.len() as u32, *pose));
        shapes.push(shape.clone());
    }
    Scene::new(shapes, objects).unwrap()
}

fn floor_and_slope() -> [(Shape, Pose); 2] {
    let tilted = Pose::new(DQuat::from_rotation_y(0.4), DVec3::new(0.0, 0.0, -1.5)).unwrap();
    let half_space = Shape::half_space(DVec3::Z, -0.2).unwrap();
    [(half_space.clone(), Pose::IDENTITY), (half_space.rounded(0.1).unwrap(), tilted)]
}

#[test]
fn bodies_of_every_kind_touch_a_terrain_as_on_one_machine() {
    let scene = scene(700, &[(terrain(), Pose::IDENTITY)]);
    let touching = on_one_machine(&scene, CERTIFIED).contacts;
    let on_terrain = touching.iter().filter(|pair| pair.contains(&7)).count();
    assert!(on_terrain > 100 && touching.len() > 2 * on_terrain, "{on_terrain}");
    for size in 1..=8 {
        check("terrain", &scene, size, [DEALT, ALL_ON_THE_LAST][size % 2]);
    }
}

#[test]
fn bodies_on_a_terrain_are_measured_as_on_one_machine() {
    let [floor, _] = floor_and_slope();
    let scene = scene(250, &[(terrain(), Pose::IDENTITY), floor]);
    for question in measures(Accuracy::Certified) {
        for size in [2, 5] {
            check_measured(&scene, question, size);
        }
    }
}

#[test]
fn a_floor_without_an_end_is_a_ghost_everywhere_and_takes_no_share_of_the_cut() {
    let scene = scene(800, &floor_and_slope());
    for size in [1, 2, 3, 4, 8, 64] {
        let costs = check("half-spaces", &scene, size, DEALT);
        if size <= 8 {
            let mean = costs.iter().sum::<u64>() as f64 / size as f64;
            let most = *costs.iter().max().unwrap() as f64;
            assert!(most / mean < 1.25, "{costs:?}");
        }
    }
    let ghosts = threads::run(4, |rank| {
        let mut ranked = RankScene::new(rank, share(&scene, rank, DEALT), CERTIFIED).unwrap();
        let found = step(&mut ranked);
        let owned = ranked.owned().filter(|(name, _)| [7, 38].contains(name)).count();
        (owned, found.contacts.iter().any(|pair| pair.contains(&7)))
    });
    assert_eq!(ghosts.iter().map(|(owned, _)| owned).sum::<usize>(), 2);
    assert!(ghosts.iter().all(|(_, touches)| *touches));
    // Alone, with nothing else in the world.
    let alone: Vec<(Shape, Pose)> = floor_and_slope().into();
    check("half-spaces alone", &self::scene(0, &alone), 3, DEALT);
}

#[test]
fn an_object_that_is_lost_in_space_leaves_the_others_spread() {
    let lost = Pose::from_translation(DVec3::new(1e12, -3e11, 0.0)).unwrap();
    let scene = scene(1200, &[(Shape::sphere(1.0).unwrap(), lost)]);
    let costs = check("lost in space", &scene, 4, IN_A_ROW);
    let mean = costs.iter().sum::<u64>() as f64 / 4.0;
    assert!(*costs.iter().max().unwrap() as f64 / mean < 1.25, "{costs:?}");
}

#[test]
fn objects_that_leave_the_grid_are_found() {
    let start = scene(900, &[(terrain(), Pose::IDENTITY)]);
    let mut moved = start.clone();
    let place = |k: usize| {
        let pose = start.poses()[k];
        let far = DVec3::new(1e5, -2e4, 300.0) * [0.0, 1.0, -1.0][k % 3];
        pose.with_translation(pose.translation() + far).unwrap()
    };
    (0..moved.len()).for_each(|k| moved.set_pose(k, place(k)).unwrap());
    let found = threads::run(4, |rank| {
        let mut ranked = RankScene::new(rank, share(&start, rank, DEALT), CERTIFIED).unwrap();
        let own: Vec<u64> = ranked.owned().map(|(name, _)| name).collect();
        own.iter().for_each(|&name| ranked.set_pose(name, place(name as usize)).unwrap());
        let first = step(&mut ranked);
        // By cuts of before, and by new ones.
        (0..20).any(|_| ranked.balance(first.load));
        (first.contacts, step(&mut ranked).contacts)
    });
    type Pairs = Vec<[u64; 2]>;
    let sorted = |of: fn(&(Pairs, Pairs)) -> &Pairs| {
        let mut all: Vec<[u64; 2]> = found.iter().flat_map(|part| of(part).clone()).collect();
        all.sort_unstable();
        all
    };
    let due = on_one_machine(&moved, CERTIFIED).contacts;
    assert!(due.len() > 100);
    assert_eq!(sorted(|part| &part.0), due);
    assert_eq!(sorted(|part| &part.1), due);
}

#[test]
fn cuts_that_cannot_be_better_are_not_made_anew() {
    // All at one place are one rank's, whatever the cuts.
    let place = Pose::from_translation(DVec3::ONE).unwrap();
    let bodies = vec![place; 60].into_iter().map(|pose| Object::new(0, pose));
    let scene = Scene::new(vec![Shape::sphere(1.0).unwrap()], bodies).unwrap();
    check("one place", &scene, 4, DEALT);
    let recuts = threads::run(4, |rank| {
        let mut ranked = RankScene::new(rank, share(&scene, rank, DEALT), CERTIFIED).unwrap();
        let frames = (0..30).map(|_| {
            let found = step(&mut ranked);
            ranked.balance(found.load)
        });
        frames.filter(|is_cut| *is_cut).count()
    });
    assert_eq!(recuts, [0; 4]);
}

#[test]
fn a_name_of_two_bodies_is_refused_on_all_ranks() {
    let refused = threads::run(3, |rank| {
        let shapes = vec![(0, Shape::sphere(1.0).unwrap())];
        // Far apart, so that they belong to different ranks.
        let at =
            |name: u64| Pose::from_translation(DVec3::X * (100 * rank.rank()) as f64 + name as f64);
        let names = if rank.rank() == 1 { vec![4, 5] } else { vec![rank.rank() as u64, 5] };
        let bodies = names.into_iter().map(|name| Body { name, shape: 0, pose: at(name).unwrap() });
        RankScene::new(rank, Share { shapes, bodies: bodies.collect() }, CERTIFIED)
            .err()
            .map(|error| error.to_string())
    });
    for message in refused {
        assert!(
            message.as_ref().is_some_and(|text| text.contains("object 5 is there twice")),
            "{message:?}"
        );
    }
}

#[test]
fn what_ranks_do_not_know_of_is_refused_and_not_lost() {
    let objects =
        || (0..4).map(|k| Object::new(0, Pose::from_translation(DVec3::X * f64::from(k)).unwrap()));
    let with = |change: fn(&mut Object)| {
        let mut objects: Vec<Object> = objects().collect();
        change(&mut objects[2]);
        Scene::new(vec![Shape::sphere(1.0).unwrap()], objects).unwrap()
    };
    let of = |scene: &Scene| {
        Share::of_scene(scene, 0, |shape| shape as u64).map(|share| share.bodies.len())
    };
    let refused = |object, what| Err(RankError::Unsupported { object, what });
    assert_eq!(of(&with(|object| object.motion = Motion::Static)), refused(2, "a static object"));
    assert_eq!(of(&with(|object| object.sensor = true)), refused(2, "a sensor"));
    let none = |object: &mut Object| object.filter = Filter { mask: 0, ..Filter::default() };
    assert_eq!(of(&with(none)), refused(2, "a filter"));
    let mut plain = with(|_| ());
    assert_eq!(of(&plain), Ok(4));
    plain.ignore_pair(1, 3).unwrap();
    assert_eq!(of(&plain), refused(1, "an ignored pair"));
    let mut gone = with(|_| ());
    gone.remove(gone.handle(2).unwrap()).unwrap();
    assert_eq!(of(&gone), Ok(3));
}

#[test]
fn a_body_whose_name_is_more_than_a_u64_counts_is_refused() {
    let objects = [0.0, 3.0, 6.0].map(|x| Pose::from_translation(DVec3::X * x).unwrap());
    let mut scene = Scene::one_each(vec![Shape::sphere(1.0).unwrap(); 3], objects.into()).unwrap();
    let names = |scene: &Scene, first| {
        let share = Share::of_scene(scene, first, |shape| shape as u64)?;
        Ok(share.bodies.iter().map(|body| body.name).collect::<Vec<u64>>())
    };
    assert_eq!(names(&scene, u64::MAX - 2), Ok(vec![u64::MAX - 2, u64::MAX - 1, u64::MAX]));
    let first = u64::MAX;
    assert_eq!(names(&scene, first), Err(RankError::NoName { object: 1, first }));
    // A slot that holds no object needs no name.
    scene.remove(scene.handle(2).unwrap()).unwrap();
    assert_eq!(names(&scene, first - 1), Ok(vec![first - 1, first]));
}
