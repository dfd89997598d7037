//! States in lanes beside every pair decided alone, on random robots in random worlds.

mod batches;
mod boundary;
mod huge;
mod random;

use super::link_frames::{LinkFrames, PlaceFrames};
use super::one_link::{LinkPlace, LinkPlaces};
use super::places::{PlaceLinks, Places};
use super::rounded_links::Rounded;
use super::sift::MOST_ALONE;
use super::*;
use crate::{AllowedPairs, Attached, LinkShapes, Obstacle, Robot, World};
use dcd_geom::{Pose, Shape};
use dcd_gjk::{Certified, PairSolver, PosedShape};
use dcd_pipeline::Par;
use dcd_simd::{Path, WIDTH, dispatch_on};
use glam::{DMat3, DVec3};
use std::path::Path as FilePath;

pub(super) use random::{Draw, robot, seeded, shape, state, world};
use random::{cell, robot_of};

/// Every pair of a state that is not apart, each decided by itself in f64 and exactly.
fn alone(cell: &mut Workcell, state: &[f64]) -> Vec<(Pair, bool)> {
    cell.set_state(state).unwrap();
    let scene = cell.scene();
    let posed =
        |i: u32| PosedShape { shape: scene.shape(i as usize), pose: &scene.poses()[i as usize] };
    let mut memory = Default::default();
    let mut found = Vec::new();
    for j in 0..scene.len() as u32 {
        for i in (0..j).filter(|&i| scene.allows(i, j)) {
            match Certified.solve(posed(i), posed(j), &mut memory) {
                Verdict::Apart => {}
                verdict => found.push((Pair { i, j }, matches!(verdict, Verdict::Touching(_)))),
            }
        }
    }
    found.sort_unstable();
    found
}

#[test]
fn frames_are_those_of_one_state_at_a_time_bit_for_bit() {
    let mut draw = Draw(7);
    for round in 0..60 {
        let robot = robot(&mut draw, round % 2 == 0);
        let count = 1 + draw.below(16) as usize;
        let states: Vec<Vec<f64>> = (0..count).map(|_| state(&mut draw, &robot)).collect();
        for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
            let mut frames = LinkFrames::default();
            let states: Vec<&[f64]> = states.iter().map(Vec::as_slice).collect();
            frames.read(&robot, &states);
            dispatch_on(path, PlaceFrames { robot: &robot, states: &states, to: &mut frames });
            for (lane, state) in states.iter().enumerate() {
                let alone = robot.link_frames(state).unwrap();
                for (link, frame) in alone.iter().enumerate() {
                    assert_eq!(frames.frame(link, lane), *frame, "{path:?}, link {link}");
                }
            }
        }
        let mut frames = LinkFrames::default();
        for state in &states {
            frames.place_alone(&robot, state, 0);
            for (link, frame) in robot.link_frames(state).unwrap().iter().enumerate() {
                assert_eq!(frames.frame(link, 0), *frame, "alone, link {link}");
            }
            assert!(frames.is_finite(0));
        }
    }
}

/// Beside the frames of one state at a time: every link's within its bound of them, on every path.
#[test]
fn frames_in_f32_are_within_their_bounds_of_those_of_one_state_at_a_time() {
    let mut draw = seeded(11);
    let mut largest = 0.0f64;
    for round in 0..200 {
        let mut robot = robot(&mut draw, round % 2 == 0);
        if round % 3 == 0 {
            robot.base = crate::kinematics::JointFrame::of_pose(&draw.pose(2.0));
        }
        let cell = Workcell::new(robot, &World::default(), &AllowedPairs::default()).unwrap();
        let checker = StateChecker::new(cell).unwrap();
        let (prepared, robot) = (&checker.prepared, checker.cell().robot());
        let mut states: Vec<Vec<f64>> = (0..16).map(|_| state(&mut draw, robot)).collect();
        // Beyond what the bounds cover.
        states[3].iter_mut().for_each(|value| *value *= if *value > 0.9 { 4.0 } else { 1.0 });
        if states[3].iter().any(|value| value.abs() > 3.5) {
            states[3] = robot.rest_state();
            let moved = robot.joints().iter().filter_map(|joint| joint.motion.drive());
            moved.for_each(|by| states[3][by.value] = 9.5);
        }
        for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
            let mut places = Places::default();
            let all: Vec<&[f64]> = states.iter().map(Vec::as_slice).collect();
            places.read(prepared, &all).unwrap();
            let (placed, links) = (places.placed(prepared), &*prepared.world_links);
            let rows = &*prepared.world_rows;
            let mut rounded = Rounded::default();
            let open = (1 << WIDTH) - 1;
            dispatch_on(path, PlaceLinks { placed, open, links, rows, to: &mut rounded });
            let rounded = rounded.world;
            let mut alone = Rounded::default();
            for lane in 0..WIDTH {
                // One of a few, each of them in turn.
                let few = all.chunks(MOST_ALONE).nth(lane / MOST_ALONE).unwrap();
                places.read(prepared, few).unwrap();
                let (placed, to) = (places.placed(prepared), &mut alone);
                let open = 1 << (lane % MOST_ALONE);
                dispatch_on(path, PlaceLinks { placed, open, links, rows, to });
                for link in 0..links.len() {
                    let (alone, among) = (alone.one.world().at(link), (&*rounded, lane).at(link));
                    let numbers = (0..12).map(|k| [alone.number(k), among.number(k)]);
                    let centres = alone.centre().to_array().into_iter();
                    let centres = centres.zip(among.centre().to_array()).map(|(a, b)| [a, b]);
                    let margins = [[alone.margin(), among.margin()]];
                    for [alone, among] in numbers.chain(centres).chain(margins) {
                        let same = alone.to_bits() == among.to_bits();
                        assert!(same, "{path:?}, link {link}, lane {lane}: {alone:e}, {among:e}");
                    }
                }
            }
            for (lane, state) in states.iter().enumerate() {
                let frames = robot.link_frames(state).unwrap();
                let slides = robot.joints().iter().filter_map(|joint| match joint.motion {
                    crate::Motion::Slides { by, .. } => by.of(state).map(f64::abs),
                    _ => None,
                });
                let slid: f64 = slides.sum();
                for ((link, error), ours) in links.iter().zip(&prepared.chain.errors).zip(&rounded)
                {
                    let number = |k: usize| f64::from(ours.frame[k].0[lane]);
                    let vector = |k: usize| DVec3::new(number(k), number(k + 1), number(k + 2));
                    let turn = DMat3::from_cols(vector(0), vector(3), vector(6));
                    let frame = &frames[link.link];
                    for _ in 0..4 {
                        let point = draw.vector();
                        let truth = frame.rotation * point + frame.translation;
                        let off = (turn * point + vector(9)).distance(truth);
                        let bound = error.shift
                            + error.turn * point.length()
                            + error.per_slid * slid
                            // Those beyond the bounds are rounded.
                            + truth.abs().max_element() * 0.5f64.powi(24);
                        assert!(off <= bound, "{path:?}, lane {lane}: {off:e}, bound {bound:e}");
                        assert!(bound < 2e-4 * (1.0 + slid), "{bound:e}");
                        largest = largest.max(off / bound);
                    }
                }
            }
        }
    }
    assert!(largest > 0.05, "the bounds are {largest} times as large");
}

#[test]
fn answers_are_those_of_every_pair_decided_alone() {
    let mut draw = seeded(1);
    let (mut free, mut hits) = (0, 0);
    for _ in 0..120 {
        let counts = judge(&mut draw, cell);
        (free, hits) = (free + counts[0], hits + counts[1]);
    }
    assert!(free > 200 && hits > 2000, "{free} free, {hits} hits");
}

/// As a scene's step has it: what a link carries meets that link unless some table allows it.
#[test]
fn what_a_link_carries_meets_that_link_unless_it_may_touch_it() {
    let mut draw = seeded(23);
    let (mut free, mut hits, mut round) = (0, 0, 0);
    // Whatever the seed, until enough of both were drawn.
    while round < 80 || free <= 100 || hits <= 1000 {
        assert!(round < 1000, "{free} free, {hits} hits");
        let counts = judge(&mut draw, |draw| {
            let robot = robot(draw, round % 2 == 0);
            let mut world = World::default();
            let links = ["l1", "l2", "l2"];
            for (name, link) in ["held", "other", "third"].into_iter().zip(links) {
                let shapes: Vec<_> =
                    (0..1 + draw.below(2)).map(|_| (shape(draw), draw.pose(0.4))).collect();
                world.attach(Attached::new(name, link, shapes), ["l0"]);
            }
            let adjacent = AllowedPairs::adjacent(&robot);
            let allowed = if round % 4 == 0 { AllowedPairs::default() } else { adjacent };
            Workcell::new(robot, &world, &allowed).unwrap()
        });
        (free, hits, round) = (free + counts[0], hits + counts[1], round + 1);
    }
}

/// Compares the answers of some states with every pair decided alone. How many states are free, how many pairs touch.
fn judge(draw: &mut Draw, cell: impl Fn(&mut Draw) -> Workcell) -> [usize; 2] {
    let mut cell = cell(draw);
    let (mut free, mut hits) = (0, 0);
    let checker = StateChecker::new(cell.clone()).unwrap();
    let count = 1 + draw.below(40) as usize;
    let states: Vec<Vec<f64>> = (0..count).map(|_| state(draw, cell.robot())).collect();
    let all = checker.all(&states, Par::Serial).unwrap();
    let first = checker.first(&states, Par::Serial).unwrap();
    let collides = checker.collides(&states, Par::Serial).unwrap();
    for (k, state) in states.iter().enumerate() {
        let truth = alone(&mut cell, state);
        let of_state = all.iter().filter(|hit| hit.state as usize == k);
        let ours: Vec<_> = of_state.map(|hit| (hit.pair, hit.touches())).collect();
        assert_eq!(ours, truth, "state {k} of {:?}", cell.names());
        let of_one = checker.all(&[state], Par::Serial).unwrap();
        let of_one: Vec<_> = of_one.iter().map(|hit| (hit.pair, hit.touches())).collect();
        assert_eq!(of_one, truth, "state {k} by itself");
        assert_eq!(collides[k], !truth.is_empty());
        let found = first[k].map(|hit| (hit.pair, hit.touches()));
        assert_eq!(found.is_some(), !truth.is_empty());
        assert!(found.is_none_or(|hit| truth.contains(&hit)));
        assert!(first[k].is_none_or(|hit| hit.state as usize == k));
        let touches = truth.iter().any(|&(_, touches)| touches);
        assert!(!touches || found.is_some_and(|(_, touches)| touches));
        free += usize::from(truth.is_empty());
        hits += truth.len();
    }
    [free, hits]
}

#[test]
fn answers_depend_on_the_state_alone() {
    let mut draw = Draw(3);
    for _ in 0..12 {
        let cell = cell(&mut draw);
        let checker = StateChecker::new(cell.clone()).unwrap();
        let states: Vec<Vec<f64>> = (0..300).map(|_| state(&mut draw, cell.robot())).collect();
        let (first, all) = (
            checker.first(&states, Par::Serial).unwrap(),
            checker.all(&states, Par::Serial).unwrap(),
        );
        for threads in [2, 3] {
            let again = dcd_exec::with_threads(threads, || {
                (
                    checker.first(&states, Par::Pool).unwrap(),
                    checker.all(&states, Par::Pool).unwrap(),
                )
            });
            assert!(again.is_ok_and(|again| again == (first.clone(), all.clone())));
        }
        // Alone and with others.
        for k in [0, 17, 63, 64, 299] {
            let one = checker.first(&states[k..=k], Par::Serial).unwrap();
            let expected = first[k].map(|hit| StateHit { state: 0, ..hit });
            assert_eq!(one, [expected]);
        }
    }
}

/// Of robots whose links fill several rows, among few obstacles and many.
#[test]
fn a_state_alone_has_the_answers_that_it_has_among_others() {
    let mut draw = seeded(11);
    let (mut free, mut hits) = (0, 0);
    for round in 0..40 {
        let robot = robot_of(&mut draw, [3, 15, 16, 17, 40][round % 5], round % 2 == 0);
        let world = world(&mut draw, &robot);
        let allowed = AllowedPairs::adjacent(&robot);
        let cell = Workcell::new(robot, &world, &allowed).unwrap();
        let checker = StateChecker::new(cell.clone()).unwrap();
        let states: Vec<Vec<f64>> = (0..20).map(|_| state(&mut draw, cell.robot())).collect();
        let first = checker.first(&states, Par::Serial).unwrap();
        let all = checker.all(&states, Par::Serial).unwrap();
        for (k, state) in states.iter().enumerate() {
            let again = |hit: &StateHit| StateHit { state: 0, ..*hit };
            let alone = checker.first(std::slice::from_ref(state), Par::Serial).unwrap();
            assert_eq!(alone, [first[k].as_ref().map(again)], "first of {k}, round {round}");
            let alone = checker.all(std::slice::from_ref(state), Par::Serial).unwrap();
            let of_state = all.iter().filter(|hit| hit.state as usize == k).map(again);
            assert!(of_state.eq(alone), "all of {k}, round {round}");
        }
        free += first.iter().filter(|hit| hit.is_none()).count();
        hits += all.len();
    }
    assert!(free > 20 && hits > 2000, "{free} free, {hits} hits");
}

/// A sphere that slides towards an obstacle is bisected down to the last state that is free.
#[test]
fn spheres_that_just_touch_are_decided_as_exactly_as_pairs_alone() {
    let urdf = r#"<robot name="probe"><link name="world"/>
      <link name="ball"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
      <joint name="slide" type="prismatic"><parent link="world"/><child link="ball"/>
      <origin xyz="0.03 0.02 0.01" rpy="0.1 0.2 0.3"/><axis xyz="0.6 0 0.8"/>
      <limit lower="-9" upper="9" effort="1" velocity="1"/></joint></robot>"#;
    let mut draw = Draw(9);
    let mut flips = 0;
    for _ in 0..40 {
        let robot = Robot::read(urdf, FilePath::new("."), LinkShapes::Hulls).unwrap();
        let shape = shape(&mut draw);
        let pose = draw.pose(0.3);
        let obstacles = vec![Obstacle { name: "o".to_owned(), shape, pose }];
        let world = World { obstacles, ..World::default() };
        let mut cell = Workcell::new(robot, &world, &AllowedPairs::default()).unwrap();
        let checker = StateChecker::new(cell.clone()).unwrap();
        let touches = |value: f64| checker.collides(&[[value]], Par::Serial).unwrap()[0];
        let (mut inside, mut outside) = (0.0, 4.0);
        if !touches(inside) || touches(outside) {
            continue;
        }
        while f64::midpoint(inside, outside) != inside && f64::midpoint(inside, outside) != outside
        {
            let middle = f64::midpoint(inside, outside);
            let ours = touches(middle);
            assert_eq!(ours, !alone(&mut cell, &[middle]).is_empty(), "at {middle:e}");
            if ours { inside = middle } else { outside = middle }
        }
        flips += 1;
    }
    assert!(flips > 5, "{flips}");
}

#[test]
fn bad_states_are_refused_by_their_index() {
    let mut draw = Draw(5);
    let cell = loop {
        let cell = cell(&mut draw);
        let slides = |joint: &crate::Joint| matches!(joint.motion, crate::Motion::Slides { .. });
        if cell.robot().joints().iter().any(slides)
            && cell.scene().len() > cell.robot().parts().len()
        {
            break cell;
        }
    };
    let checker = StateChecker::new(cell.clone()).unwrap();
    let good = cell.robot().rest_state();
    let said = |states: &[Vec<f64>]| checker.all(states, Par::Serial).unwrap_err().to_string();
    let short = vec![good.clone(), good[1..].to_vec()];
    assert!(said(&short).starts_with("state 1: "), "{}", said(&short));
    let mut states = vec![good; 100];
    states[77][0] = f64::NAN;
    assert!(said(&states).starts_with("state 77: ") && said(&states).contains("NaN"));
    assert!(checker.collides::<Vec<f64>>(&[], Par::Serial).unwrap().is_empty());
    // Of one alone there is no index.
    let alone = |state: &[f64]| checker.is_free(state).unwrap_err().to_string();
    for bad in [&short[1], &states[77]] {
        assert_eq!(said(std::slice::from_ref(bad)), format!("state 0: {}", alone(bad)));
    }
}

#[test]
fn a_link_out_of_range_is_refused_and_never_free() {
    let urdf = r#"<robot name="far"><link name="a"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
      <link name="b"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
      <joint name="slide" type="prismatic"><parent link="a"/><child link="b"/><axis xyz="1 0 0"/>
      <limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>"#;
    // With none, with few and with many obstacles.
    for obstacles in [0, 3, 100] {
        let robot = Robot::read(urdf, FilePath::new("."), LinkShapes::Hulls).unwrap();
        let obstacles = (0..obstacles).map(|k| Obstacle {
            name: format!("o{k}"),
            shape: Shape::sphere(0.1).unwrap(),
            pose: Pose::from_translation(DVec3::new(0.0, 1.0 + f64::from(k), 0.0)).unwrap(),
        });
        let world = World { obstacles: obstacles.collect(), ..World::default() };
        let cell = Workcell::new(robot, &world, &AllowedPairs::default()).unwrap();
        let checker = StateChecker::new(cell).unwrap();
        for far in [1e38, 1e300, f64::MAX] {
            let error = checker.first(&[[3.0], [far]], Par::Serial).unwrap_err().to_string();
            assert!(error.starts_with("state 1: "), "{error}");
        }
        assert_eq!(checker.collides(&[[1e30], [0.1]], Par::Serial).unwrap(), [false, true]);
    }
}

#[test]
fn another_cell_is_checked_as_by_a_checker_of_its_own() {
    let mut draw = Draw(21);
    for round in 0..40 {
        let robot = robot(&mut draw, round % 2 == 0);
        let other = self::robot(&mut draw, round % 3 == 0);
        let mut checker: Option<StateChecker> = None;
        for _ in 0..6 {
            let robot = if draw.below(4) == 0 { &other } else { &robot };
            let world = world(&mut draw, robot);
            let allowed = match draw.below(3) {
                0 => AllowedPairs::default(),
                _ => AllowedPairs::adjacent(robot),
            };
            let cell = Workcell::new(robot.clone(), &world, &allowed).unwrap();
            let states: Vec<Vec<f64>> = (0..20).map(|_| state(&mut draw, robot)).collect();
            let fresh = StateChecker::new(cell.clone()).unwrap();
            let ours = match checker.take() {
                Some(mut checker) => checker.set_cell(cell).map(|()| checker),
                None => StateChecker::new(cell),
            };
            let ours = ours.unwrap();
            let all = |checker: &StateChecker| checker.all(&states, Par::Serial).unwrap();
            assert_eq!(all(&ours), all(&fresh));
            let first = |checker: &StateChecker| checker.first(&states, Par::Serial).unwrap();
            assert_eq!(first(&ours), first(&fresh));
            checker = Some(ours);
        }
    }
}

/// A joint that mimics another by a factor comes to an infinite angle, and its link to a rotation of NaN.
#[test]
fn a_rotation_that_is_no_number_is_refused_and_never_free() {
    let urdf = r#"<robot name="wild">
      <link name="a"><collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision></link>
      <link name="b"><collision><geometry><box size="0.2 0.3 0.2"/></geometry></collision></link>
      <link name="c"><collision><geometry><box size="0.3 0.2 0.2"/></geometry></collision></link>
      <joint name="lead" type="continuous"><parent link="a"/><child link="b"/><origin xyz="1 0 0"/><axis xyz="0 0 1"/></joint>
      <joint name="follow" type="continuous"><parent link="a"/><child link="c"/><origin xyz="0 2 0"/><axis xyz="0 0 1"/>
        <mimic joint="lead" multiplier="10"/></joint></robot>"#;
    for obstacles in [0, 1, 100] {
        let robot = Robot::read(urdf, FilePath::new("."), LinkShapes::Hulls).unwrap();
        let obstacles = (0..obstacles).map(|k| Obstacle {
            name: format!("o{k}"),
            shape: Shape::cuboid(DVec3::splat(0.1)).unwrap(),
            pose: Pose::from_translation(DVec3::new(0.0, 0.0, 5.0 + f64::from(k))).unwrap(),
        });
        let world = World { obstacles: obstacles.collect(), ..World::default() };
        let cell = Workcell::new(robot, &world, &AllowedPairs::default()).unwrap();
        let checker = StateChecker::new(cell).unwrap();
        assert_eq!(checker.collides(&[[0.3]], Par::Serial).unwrap(), [false]);
        let states = [[0.3], [1e308]];
        assert!(checker.cell().robot().place(&states[1], &mut Vec::new()).is_err());
        let refused = [
            checker.collides(&states, Par::Serial).unwrap_err().to_string(),
            checker.all(&states, Par::Serial).unwrap_err().to_string(),
        ];
        assert!(refused.iter().all(|error| error.starts_with("state 1: ")), "{refused:?}");
    }
    // Where nothing is checked either.
    let robot = Robot::read(urdf, FilePath::new("."), LinkShapes::Hulls).unwrap();
    let allowed = AllowedPairs::from_pairs(&crate::PairSearch::default().run(&robot).unwrap());
    let cell = Workcell::new(robot, &World::default(), &allowed).unwrap();
    let checker = StateChecker::new(cell).unwrap();
    assert!(checker.prepared.link_pairs.is_empty());
    let error = checker.collides(&[[0.3], [1e308]], Par::Serial).unwrap_err().to_string();
    assert!(error.starts_with("state 1: "), "{error}");
}

#[test]
fn clearances_of_many_states_are_those_of_each_alone_in_the_cell_that_counts() {
    let mut draw = Draw(17);
    let robot = robot(&mut draw, false);
    let states: Vec<Vec<f64>> = (0..9).map(|_| state(&mut draw, &robot)).collect();
    let cell = |world: &World| {
        Workcell::new(robot.clone(), world, &AllowedPairs::adjacent(&robot)).unwrap()
    };
    let worlds = [world(&mut draw, &robot), World::default()];
    let mut checker = StateChecker::new(cell(&worlds[0])).unwrap();
    for world in &worlds {
        let mut alone = cell(world);
        checker.set_cell(cell(world)).unwrap();
        let expected: Vec<_> = states.iter().map(|state| alone.clearance(state).unwrap()).collect();
        for exec in [Par::Serial, Par::Pool] {
            assert_eq!(checker.clearances(&states, exec).unwrap(), expected);
        }
    }
    let refused = checker.clearances(&[&states[0][..], &[]], Par::Serial).unwrap_err();
    assert!(matches!(refused, RobotError::AtState { state: 1, .. }), "{refused}");
}
