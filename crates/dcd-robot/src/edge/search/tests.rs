use super::super::tests::groups::arm_of_several;
use super::super::tests::{Draw, arm, at, checker, obstacle};
use super::*;
use crate::{AllowedPairs, LinkShapes, Robot, Workcell, World};
use dcd_geom::{Pose, Shape};
use dcd_gjk::distance::{DistanceResult, distance, gap_along};
use glam::DQuat;
use std::path::Path;

/// The robot in the middle of an interval.
fn search<'a>(
    checker: &'a EdgeChecker,
    path: &'a JointPath,
    (middle, half): (f64, f64),
) -> EdgeSearch<'a> {
    let mut search = EdgeSearch::new(checker, path, (1, Before::Hit));
    search.nodes = 1;
    search.at.go_to(checker, path, middle).unwrap();
    search.half = half;
    (0..checker.volumes.len() as u32).for_each(|i| search.update(i));
    search
}

#[test]
fn no_pair_comes_nearer_in_an_interval_than_is_proved_of_it() {
    let mut draw = Draw::new();
    let (mut proved, mut tight) = (0, 0);
    for k in 0..60 {
        let shapes = [
            Shape::cuboid(draw.vector().abs() * 0.3 + 0.01).unwrap(),
            Shape::cylinder(0.3, 0.1).unwrap(),
            Shape::hull((0..12).map(|_| draw.vector() * 0.3).collect()).unwrap(),
        ];
        let mut obstacles = Vec::new();
        for (n, shape) in shapes.into_iter().enumerate() {
            let turn = DQuat::from_scaled_axis(draw.vector() * 3.0);
            let pose = Pose::new(turn, draw.vector() * 2.5).unwrap();
            obstacles
                .push(crate::Obstacle { pose, ..obstacle(&format!("o{n}"), shape, DVec3::ZERO) });
        }
        let checker = checker(arm(3), obstacles);
        let mut state = || -> Vec<f64> { (0..4).map(|_| draw.unit() * 2.0).collect() };
        let path = if k % 2 == 0 {
            JointPath::Straight([state(), state()])
        } else {
            JointPath::Bezier([state(), state(), state(), state()])
        };
        let half = [0.1, 0.02, 1e-3][k % 3];
        let middle = 0.5 + 0.3 * draw.unit();
        let mut now = search(&checker, &path, (middle, half));
        for pair in 0..checker.pairs.len() as u32 {
            let edge_pair = checker.pairs[pair as usize];
            let [a, b] = edge_pair.objects;
            let Some(found) = measured(&now, [a, b]) else { continue };
            let bounds = now.by_spheres(&edge_pair);
            let normal = found.normal;
            let gaps = now.along(&edge_pair, normal).unwrap();
            let along = gaps.proved;
            assert!(gaps.middle <= found.upper(), "{path:?} {a} {b}: {found:?}");
            assert!(bounds.upper >= found.lower(), "{path:?} {a} {b}: {found:?}");
            let margin = along.max(bounds.margin).max(found.lower() - now.moved(&edge_pair));
            let mut least = f64::INFINITY;
            for s in -20..=20 {
                let t = middle + half * f64::from(s) / 20.0;
                let there = search(&checker, &path, (t, 0.0));
                let Some(found) = measured(&there, [a, b]) else {
                    // It touches there, or nearly.
                    least = 0.0;
                    break;
                };
                least = least.min(found.upper());
                if edge_pair.common == 0 {
                    // Along the same direction, which is the world's here.
                    let gap = gap_along(there.posed(a), there.posed(b), normal).unwrap();
                    assert!(along <= gap + 1e-12, "{path:?} {a} {b} at {t}: {along} {gap}");
                }
                if margin <= 0.0 {
                    break;
                }
            }
            if margin > 0.0 {
                proved += 1;
                tight += u32::from(margin > 0.9 * least);
                assert!(margin <= least, "{path:?} {a} {b}: {margin} {least}");
            }
        }
    }
    assert!(proved > 300 && tight > 100, "{proved} {tight}");
}

/// How near the spheres of each pair, then of each group of pairs, come in each slice of the path until there, by samples.
fn least_in_slices(checker: &EdgeChecker, path: &JointPath, end: f64) -> Vec<[f64; 16]> {
    let open = checker.pairs.len() + checker.groups.groups.len();
    let mut least = vec![[f64::INFINITY; 16]; open];
    for step in 0..=16 * 16 {
        let there = search(checker, path, (end * f64::from(step) / 256.0, 0.0));
        for (open, least) in (0..).zip(&mut least) {
            let far = there.far(open);
            // The borders belong to both.
            for slice in [step / 16, (step - 1) / 16] {
                if let Some(least) = least.get_mut(slice as usize) {
                    *least = least.min(far);
                }
            }
        }
    }
    least
}

#[test]
fn spheres_that_are_proved_apart_in_a_slice_are_apart_all_along_it() {
    let mut draw = Draw::new();
    // Of all, of those that hardly are apart, and of those that are far apart, and left open in vain.
    let (mut proved, mut near, mut far, mut in_vain) = (0, 0, 0, 0);
    for k in 0..60 {
        let shapes = [
            Shape::cuboid(draw.vector().abs() * 0.3 + 0.01).unwrap(),
            Shape::cylinder(0.3, 0.1).unwrap().rounded(0.02).unwrap(),
            Shape::hull((0..12).map(|_| draw.vector() * 0.3).collect()).unwrap(),
        ];
        let obstacles = shapes.into_iter().map(|shape| {
            let turn = DQuat::from_scaled_axis(draw.vector() * 3.0);
            let pose = Pose::new(turn, draw.vector() * 2.5).unwrap();
            crate::Obstacle { pose, ..obstacle(&format!("{pose:?}"), shape, DVec3::ZERO) }
        });
        let robot = if k % 3 == 0 { arm_of_several() } else { arm(4) };
        let values = robot.variables().len();
        let checker = checker(robot, obstacles.collect());
        let mut state = || -> Vec<f64> { (0..values).map(|_| draw.unit() * 2.0).collect() };
        let path = if k % 2 == 0 {
            JointPath::Straight([state(), state()])
        } else {
            JointPath::Bezier([state(), state(), state(), state()])
        };
        let (end, nearest) = ([1.0, 0.8125, 0.25][k / 6 % 3], [0.0, 0.2][k / 3 % 2]);
        let slices = EdgeSearch::new(&checker, &path, (1, Before::Hit)).slice(end, nearest);
        let slices = slices.unwrap();
        assert_eq!(slices.open.len(), checker.pairs.len() + checker.groups.groups.len());
        let least = least_in_slices(&checker, &path, end);
        for (open, least) in (0..).zip(&least) {
            for (slice, &least) in least.iter().enumerate() {
                let is_proved = slices.prove(open, 1 << slice);
                let least = least - nearest;
                assert!(!is_proved || least > 0.0, "{path:?}, {end}: {open} {slice} {least}");
                proved += u32::from(is_proved);
                near += u32::from(is_proved && least < 0.03);
                far += u32::from(least > 0.3);
                in_vain += u32::from(!is_proved && least > 0.3);
            }
        }
    }
    assert!(proved > 10_000 && near > 5 && in_vain * 20 < far, "{proved} {near} {in_vain} {far}");
}

/// A body that floats, an arm that turns on it, a plate fixed to that, and a finger that slides as the arm turns.
pub(super) fn mobile() -> Robot {
    let text = r#"<robot name="mobile"><link name="world"/>
      <link name="body"><collision><origin xyz="0.1 0 0" rpy="0.3 0.2 1"/><geometry><box size="0.5 0.3 0.1"/></geometry></collision></link>
      <link name="arm"><collision><origin xyz="0.4 0 0"/><geometry><box size="0.8 0.1 0.1"/></geometry></collision></link>
      <link name="plate"><collision><geometry><cylinder radius="0.1" length="0.02"/></geometry></collision></link>
      <link name="finger"><collision><geometry><sphere radius="0.05"/></geometry></collision></link>
      <joint name="free" type="floating"><origin xyz="0.2 0.1 0" rpy="0.4 -1 0.3"/><parent link="world"/><child link="body"/></joint>
      <joint name="turn" type="continuous"><origin xyz="0.3 0 0.2" rpy="1 0.5 0"/><axis xyz="0 0.6 0.8"/>
        <parent link="body"/><child link="arm"/></joint>
      <joint name="hold" type="fixed"><origin xyz="0.8 0 0" rpy="0 0.7 2"/><parent link="arm"/><child link="plate"/></joint>
      <joint name="slide" type="prismatic"><origin xyz="0.9 0 0" rpy="0 1 0"/><axis xyz="1 0 0"/><parent link="arm"/><child link="finger"/>
        <limit lower="-1" upper="1" effort="1" velocity="1"/><mimic joint="turn" multiplier="-0.3" offset="0.1"/></joint>
      </robot>"#;
    Robot::read(text, Path::new("."), LinkShapes::Hulls).unwrap()
}

/// That robot on a base anywhere, among boxes.
fn mobile_checker(draw: &mut Draw) -> EdgeChecker {
    let boxes = (0..3).map(|n| {
        let at = draw.vector() * 2.0;
        obstacle(&format!("o{n}"), Shape::cuboid(DVec3::splat(0.1)).unwrap(), at)
    });
    let obstacles = boxes.collect();
    let turn = DQuat::from_scaled_axis(draw.vector() * 3.0);
    let base = Some(Pose::new(turn, draw.vector() * 0.5).unwrap());
    let (robot, world) = (mobile(), World { obstacles, base, ..World::default() });
    let allowed = AllowedPairs::adjacent(&robot);
    EdgeChecker::new(Workcell::new(robot, &world, &allowed).unwrap())
}

/// A straight path of that robot, on which each value changes by about so much.
pub(super) fn mobile_path(draw: &mut Draw, change: f64) -> JointPath {
    let from = [draw.vector(), draw.vector()];
    let mut state = |change: f64| {
        let [place, turn] = from.map(|v| v + draw.vector() * change);
        let mut state = place.to_array().to_vec();
        state.extend(DQuat::from_scaled_axis(turn).normalize().to_array());
        state.push(draw.unit() * change);
        state
    };
    JointPath::Straight([state(0.0), state(change)])
}

#[test]
fn no_slice_proves_more_than_is_left_of_floating_and_mimicking_links_on_a_turned_base() {
    let mut draw = Draw::new();
    // Of all, and of those that are hardly farther apart than what is proved.
    let (mut proved, mut near) = (0, 0);
    for k in 0..30 {
        let checker = mobile_checker(&mut draw);
        // Slow and fast: what accelerations may do counts little and much.
        let path = mobile_path(&mut draw, [0.05, 0.5][k % 2]);
        let least = least_in_slices(&checker, &path, 1.0);
        let mut search = EdgeSearch::new(&checker, &path, (1, Before::Hit));
        for k in 0..12 {
            let mut number = |below: usize| (draw.unit().abs() * 1e6) as usize % below;
            let some = least[number(least.len())][number(16)];
            // A little less than what some pair keeps, and a little more.
            let nearest = (some * [0.999, 1.0 + 1e-9][k % 2]).max(0.0);
            let slices = search.slice(1.0, nearest).unwrap();
            for (open, least) in (0..).zip(&least) {
                for (slice, &least) in least.iter().enumerate() {
                    if slices.prove(open, 1 << slice) {
                        assert!(least > nearest, "{path:?}: {open} {slice} {least} {nearest}");
                        proved += 1;
                        near += u32::from(least < nearest + 0.002);
                    }
                }
            }
        }
    }
    assert!(proved > 5_000 && near > 50, "{proved} {near}");
}

#[test]
fn a_node_has_a_part_of_the_slices_that_it_reaches_into() {
    let slices = Slices { end: 0.8125, open: vec![0b10, 0, u16::MAX] };
    let of = |from: f64, to: f64| slices.of(&Node { from, to, pairs: 0..0 });
    let slice = 0.8125 / 16.0;
    assert_eq!(of(0.0, 0.8125), u16::MAX);
    assert_eq!(of(0.0, slice), 1);
    assert_eq!(of(slice, 3.0 * slice), 0b110);
    assert_eq!(of(15.25 * slice, 15.5 * slice), 1 << 15);
    assert_eq!(of(14.5 * slice, 15.5 * slice), 0b11 << 14);
    assert!(slices.prove(0, 0b101) && !slices.prove(0, 0b110) && slices.prove(1, u16::MAX));
    assert!(!slices.prove(2, 1) && !slices.prove(3, 1));
    // Where nothing is known nothing is proved.
    let none = Slices::default();
    assert_eq!(none.of(&Node { from: 0.5, to: 0.75, pairs: 0..0 }), u16::MAX);
    assert!(!none.prove(0, 1));
}

fn measured(search: &EdgeSearch<'_>, [a, b]: [u32; 2]) -> Option<dcd_gjk::distance::Distance> {
    match distance(search.posed(a), search.posed(b)).0 {
        DistanceResult::Apart(found) => Some(found),
        _ => None,
    }
}

#[test]
fn a_hit_alone_is_a_hit_and_a_free_edge_free() {
    let mut draw = Draw::new();
    let ball = |at| obstacle("ball", Shape::sphere(0.4).unwrap(), at);
    let (mut hits, mut free) = (0, 0);
    for _ in 0..120 {
        let checker = checker(arm(3), vec![ball(draw.vector() * 1.5)]);
        let mut state = || -> Vec<f64> { (0..4).map(|_| draw.unit()).collect() };
        let path = JointPath::Straight([state(), state()]);
        let (all, any) =
            (checker.check(&path, 10_000).unwrap(), checker.check_any(&path, 10_000).unwrap());
        match any.answer {
            EdgeAnswer::Hit { t, pair } => {
                hits += 1;
                assert!(at(&checker, &path, t).0.contains(&pair), "{path:?}");
                assert!(matches!(all.answer, EdgeAnswer::Hit { .. }), "{path:?}");
            }
            _ => {
                free += 1;
                assert_eq!(all, any, "{path:?}");
            }
        }
    }
    assert!(hits > 0 && free > 0, "{hits} {free}");
}
