use super::super::super::tests::{Draw, arm, checker, obstacle};
use super::super::tests::{mobile, mobile_path};
use super::super::{Before, Edge, EdgeAnswer, EdgeChecker, JointPath};
use super::*;
use crate::{AllowedPairs, Obstacle, Robot, StateChecker, Workcell, World};
use dcd_exec::Par;
use dcd_geom::{Pose, Shape};
use dcd_gjk::distance::distance as measured;
use glam::DQuat;

/// That many obstacles of some kinds, as far from the origin as the range says.
fn obstacles(draw: &mut Draw, count: usize, far: [f64; 2]) -> Vec<Obstacle> {
    let one = |n: usize| {
        let shape = match n % 5 {
            0 => Shape::sphere(0.1 + 0.05 * draw.unit()),
            1 => Shape::cuboid(draw.vector().abs() * 0.2 + 0.01),
            2 => Shape::cylinder(0.2, 0.05).and_then(|shape| shape.rounded(0.01)),
            3 => Shape::hull((0..9).map(|_| draw.vector() * 0.2).collect()),
            _ => Shape::mesh(
                (0..5).map(|_| draw.vector() * 0.2).collect(),
                vec![[0, 1, 2], [1, 2, 3], [2, 3, 4]],
            ),
        };
        let turn = DQuat::from_scaled_axis(draw.vector() * 3.0);
        let away = far[0] + (far[1] - far[0]) * draw.unit().abs();
        let pose = Pose::new(turn, draw.vector().normalize() * away).unwrap();
        Obstacle { name: format!("o{n}"), shape: shape.unwrap(), pose }
    };
    (0..count).map(one).collect()
}

fn path(draw: &mut Draw, values: usize, (k, change): (usize, f64)) -> JointPath {
    let from: Vec<f64> = (0..values).map(|_| draw.unit() * 1.5).collect();
    let mut near = || -> Vec<f64> { from.iter().map(|x| x + draw.unit() * change).collect() };
    if k.is_multiple_of(3) {
        JointPath::Bezier([near(), near(), near(), near()])
    } else {
        JointPath::Straight([near(), near()])
    }
}

/// The same that takes up all pairs.
fn of_all_pairs(checker: &EdgeChecker) -> EdgeChecker {
    EdgeChecker { by_mover: None, ..checker.clone() }
}

#[test]
fn edges_among_far_obstacles_are_those_among_the_near_ones_alone() {
    let mut draw = Draw::new();
    let [mut free, mut hits, mut alike] = [0; 3];
    for k in 0..60 {
        let near = obstacles(&mut draw, 5, [0.6, 3.5]);
        // The arm reaches as far as 4.2, and no two of its links are farther from each other than 2.
        let far = obstacles(&mut draw, 300, [7.0, 12.0]);
        let few = checker(arm(3), near.clone());
        let (first, many) =
            if k % 2 == 0 { (0, [near, far].concat()) } else { (300, [far, near].concat()) };
        let many = checker(arm(3), many);
        assert!(many.by_mover.is_some() && few.by_mover.is_none());
        let path = path(&mut draw, 4, (k, [0.02, 0.3, 1.5][k / 6 % 3]));
        for check in [EdgeChecker::check, EdgeChecker::check_any] {
            let mut due = check(&few, &path, 3000).unwrap();
            if let EdgeAnswer::Hit { pair, .. } | EdgeAnswer::Undecided { pair, .. } =
                &mut due.answer
            {
                pair.iter_mut().filter(|object| **object >= 4).for_each(|object| *object += first);
            }
            let edge = check(&many, &path, 3000).unwrap();
            if edge == due {
                alike += 1;
            } else {
                // Boxes in the world prove some of what is near far from others.
                let clearance = |edge: &Edge| match edge.answer {
                    EdgeAnswer::Free { clearance } => clearance,
                    _ => panic!("{path:?}: {edge:?}, not {due:?}"),
                };
                assert!(clearance(&edge) >= 0.49 * clearance(&due), "{path:?}: {edge:?} {due:?}");
                assert!(edge.nodes <= due.nodes, "{path:?}: {edge:?} {due:?}");
            }
            free += u32::from(matches!(due.answer, EdgeAnswer::Free { .. }));
            hits += u32::from(matches!(due.answer, EdgeAnswer::Hit { .. }));
        }
    }
    assert!(free > 10 && hits > 10 && alike >= 110, "{free} {hits} {alike}");
}

#[test]
fn edges_among_hundreds_are_answered_as_all_pairs_and_as_states_say() {
    let mut draw = Draw::new();
    let [mut free, mut alike, mut hits, mut fewer] = [0; 4];
    for k in 0..60 {
        let checker = checker(arm(2), obstacles(&mut draw, 250, [1.0, 6.0]));
        let path = path(&mut draw, 3, (k, [0.02, 0.1, 0.6][k / 3 % 3]));
        let (edge, due) = (
            checker.check(&path, 20_000).unwrap(),
            of_all_pairs(&checker).check(&path, 20_000).unwrap(),
        );
        let cell = checker.cell().clone();
        let states = StateChecker::new(cell).unwrap();
        let until = if let EdgeAnswer::Free { .. } = edge.answer { 1.0 } else { edge.free_until };
        let sampled = |count: usize| -> Vec<Vec<f64>> {
            let mut state = Vec::new();
            let mut at = |k: usize| {
                let t = until * k as f64 / count as f64;
                path.state_at(checker.robot(), t, &mut state);
                state.clone()
            };
            // What begins with a hit is free nowhere.
            (0..count + usize::from(until == 1.0)).map(&mut at).collect()
        };
        if until > 0.0 {
            let found = states.first(&sampled(1000), Par::Serial).unwrap();
            assert!(found.iter().flatten().all(|hit| !hit.touches()), "{path:?}: {edge:?}");
        }
        match (&edge.answer, &due.answer) {
            (EdgeAnswer::Free { clearance }, EdgeAnswer::Free { clearance: due }) => {
                free += 1;
                // What is near limits it, and is found alike, unless all pairs begin with a box that is nearer than what is in it.
                assert!(*clearance >= 0.49 * due, "{path:?}: {clearance} {due}");
                alike += u32::from((clearance - due).abs() <= 1e-9 * due);
                let least = states.clearances(&sampled(60), Par::Serial).unwrap();
                for least in least.into_iter().flatten() {
                    let least = least.proximity.signed_distance + least.proximity.error_bound;
                    assert!(*clearance <= least + 1e-9, "{path:?}: {clearance} {least:?}");
                }
            }
            (EdgeAnswer::Hit { t, pair }, EdgeAnswer::Hit { t: due, pair: due_pair }) => {
                hits += 1;
                assert_eq!((t, pair), (due, due_pair), "{path:?}");
            }
            _ => panic!("{path:?}: {edge:?} {due:?}"),
        }
        assert!(edge.free_until >= due.free_until && edge.nodes <= due.nodes, "{edge:?} {due:?}");
        let mut search = EdgeSearch::new(&checker, &path, (1, Before::Hit));
        search.keep_near_pairs(1.0).unwrap();
        fewer += u32::from(search.pairs.len() < checker.pairs.len());
    }
    assert!(free > 10 && hits > 10 && fewer > 20, "{free} {hits} {fewer}");
    assert!(alike * 10 >= free * 9, "{alike} {free}");
}

/// That pairs that are left out are as far apart as what is noted of them, all along the path; how many of them hardly are, and how many
/// are left out.
fn assert_left_out_are_far(checker: &EdgeChecker, path: &JointPath, end: f64) -> [usize; 2] {
    let mut search = EdgeSearch::new(checker, path, (1, Before::Hit));
    search.hit = (end < 1.0).then_some((end, [0, 0]));
    search.keep_near_pairs(end).unwrap();
    let distance = if end < 1.0 { 0.0 } else { search.clearance };
    let kept = |pair: &&EdgePair| search.pairs.iter().any(|kept| kept.objects == pair.objects);
    let left: Vec<&EdgePair> = checker.pairs.iter().filter(|pair| !kept(pair)).collect();
    assert!(left.iter().all(|pair| checker.movers[pair.objects[1] as usize].is_none()));
    let mut least = vec![f64::INFINITY; left.len()];
    for k in 0..=16 {
        let mut there = EdgeSearch::new(checker, path, (1, Before::Hit));
        there.at.go_to(checker, path, end * f64::from(k) / 16.0).unwrap();
        for (pair, least) in left.iter().zip(&mut least) {
            let [a, b] = pair.objects.map(|object| there.posed(object));
            let DistanceResult::Apart(found) = measured(a, b).0 else {
                panic!("{pair:?} {path:?}")
            };
            assert!(found.upper() > distance, "{pair:?} {path:?}: {found:?}");
            *least = least.min(found.upper());
        }
    }
    let hardly = least.iter().filter(|&&least| least < 1.5 * distance + 0.1).count();
    [hardly, left.len()]
}

#[test]
fn what_is_left_out_is_farther_than_what_is_noted_all_along_the_path() {
    let mut draw = Draw::new();
    let [mut hardly, mut left] = [0; 2];
    for k in 0..24 {
        let (ends, change) = ([1.0, 1.0, 0.375], [0.02, 0.2, 0.6][k / 3 % 3]);
        let found = if k % 2 == 0 {
            let checker = checker(arm(3), obstacles(&mut draw, 150, [0.5, 5.0]));
            let path = path(&mut draw, 4, (k, change));
            assert_left_out_are_far(&checker, &path, ends[k % 3])
        } else {
            let mut obstacles = obstacles(&mut draw, 150, [0.3, 4.0]);
            // What has no end is near everything.
            obstacles.push(obstacle(
                "ground",
                Shape::half_space(DVec3::Z, -9.0).unwrap(),
                DVec3::ZERO,
            ));
            let turn = DQuat::from_scaled_axis(draw.vector() * 3.0);
            let base = Some(Pose::new(turn, draw.vector() * 0.5).unwrap());
            let (robot, world) = (mobile(), World { obstacles, base, ..World::default() });
            let allowed = AllowedPairs::adjacent(&robot);
            let checker = EdgeChecker::new(Workcell::new(robot, &world, &allowed).unwrap());
            let path = mobile_path(&mut draw, change);
            assert_left_out_are_far(&checker, &path, ends[k % 3])
        };
        hardly += found[0];
        left += found[1];
    }
    assert!(hardly > 0 && left > 2000, "{hardly} {left}");
}

/// Balls in a grid that the arm never comes near.
fn far_balls() -> Vec<Obstacle> {
    let at = |k: usize| DVec3::new((k % 10) as f64, (k / 10) as f64, 9.0);
    let ball = |k: usize| obstacle(&format!("far {k}"), Shape::sphere(0.3).unwrap(), at(k));
    (0..100).map(ball).collect()
}

#[test]
fn an_obstacle_that_is_met_in_the_middle_of_an_edge_alone_is_met_among_many() {
    let plate = |x: f64| {
        let plate = Shape::cuboid(DVec3::new(0.3, 0.0005, 0.3)).unwrap();
        obstacle("plate", plate, DVec3::new(x, 0.0, 0.0))
    };
    let straight = JointPath::Straight([vec![-1.2, 0.0, 0.0, 0.2], vec![1.3, 0.0, 0.0, 0.2]]);
    for k in 0..40 {
        // The tip ends at 3.4 from the base's axis.
        let x = 3.02 + 0.05 * f64::from(k);
        let few = checker(arm(3), vec![plate(x)]);
        let many = checker(arm(3), [vec![plate(x)], far_balls()].concat());
        let (edge, due) =
            (many.check(&straight, 10_000).unwrap(), few.check(&straight, 10_000).unwrap());
        assert_eq!(edge, due, "{x}");
        let EdgeAnswer::Free { clearance } = edge.answer else {
            assert!(matches!(edge.answer, EdgeAnswer::Hit { .. }) && x < 3.7, "{x}: {edge:?}");
            continue;
        };
        assert!(x > 3.7 && clearance <= x - 0.3 - 3.4 + 1e-9, "{x}: {edge:?}");
    }
}

/// One body that slides along x, and meets nothing of its own.
fn slider() -> Robot {
    let text = r#"<robot name="slider"><link name="base"/><link name="ball"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
      <joint name="along" type="prismatic"><axis xyz="1 0 0"/><limit lower="-9" upper="9" effort="1" velocity="1"/>
      <parent link="base"/><child link="ball"/></joint></robot>"#;
    Robot::read(text, std::path::Path::new("."), crate::LinkShapes::Hulls).unwrap()
}

#[test]
fn an_obstacle_just_beyond_what_is_taken_up_limits_no_clearance_falsely() {
    // One ball is 0.5 from the middle of the path; another is nearer to its end, or a little farther than what is taken up.
    let ball = |name: &str, at| obstacle(name, Shape::sphere(0.2).unwrap(), at);
    let path = JointPath::Straight([vec![-0.1], vec![0.1]]);
    let beside = ball("beside", DVec3::Y * 0.8);
    for k in 0..200 {
        let gap = 0.3 + 0.002 * f64::from(k);
        let end = ball("end", DVec3::X * (0.1 + 0.3 + gap));
        let many = checker(slider(), [vec![beside.clone(), end], far_balls()].concat());
        let edge = many.check(&path, 1000).unwrap();
        let EdgeAnswer::Free { clearance } = edge.answer else { panic!("{gap}: {edge:?}") };
        let least = gap.min(0.5);
        assert!(clearance <= least && clearance >= 0.49 * least, "{gap}: {clearance}");
        let due = of_all_pairs(&many).check(&path, 1000).unwrap();
        assert_eq!(edge, due, "{gap}");
    }
    // Nothing near at all: what is nearest is found all the same.
    let alone = checker(slider(), far_balls());
    let edge = alone.check(&path, 1000).unwrap();
    let EdgeAnswer::Free { clearance } = edge.answer else { panic!("{edge:?}") };
    assert!((4.0..8.61).contains(&clearance), "{edge:?}");
    assert_eq!(edge, of_all_pairs(&alone).check(&path, 1000).unwrap());
}

#[test]
fn certificates_among_many_obstacles_have_planes_for_all_pairs() {
    let checker = checker(arm(2), far_balls());
    let path = JointPath::Straight([vec![0.0, 0.1, 0.2], vec![0.2, 0.3, 0.1]]);
    let EdgeAnswer::Free { clearance } = checker.check(&path, 1000).unwrap().answer else {
        panic!("not free")
    };
    let certificate = checker.certificate(&path, clearance, 10_000).unwrap();
    assert_eq!(certificate.pairs.len(), checker.pairs.len());
    assert!(certificate.pairs.iter().all(|pair| !pair.planes.is_empty()));
}
