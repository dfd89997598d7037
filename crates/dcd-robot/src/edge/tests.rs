pub(super) mod groups;
mod half_space;

use super::*;
use crate::{AllowedPairs, Attached, LinkShapes, Obstacle, World};
use dcd_geom::{Pose, Shape};
use dcd_gjk::distance::{DistanceResult, distance};
use dcd_gjk::{PosedShape, Verdict, certified};
use glam::{DQuat, DVec3};
use std::path::Path;

/// An arm of links of length 1 along x, turned about z, y, z, …; the last one slides out of the one before.
pub(super) fn arm(turns: usize) -> Robot {
    let link = |k: usize| {
        format!(
            "<link name=\"l{k}\"><collision><origin xyz=\"0.5 0 0\"/><geometry><box size=\"0.8 0.1 0.1\"/>\
             </geometry></collision></link>"
        )
    };
    let joint = |k: usize| {
        let axis = if k.is_multiple_of(2) { "0 0 1" } else { "0 1 0" };
        format!(
            "<joint name=\"j{k}\" type=\"continuous\"><origin xyz=\"{} 0 0\"/><axis xyz=\"{axis}\"/>\
             <parent link=\"{}\"/><child link=\"l{k}\"/></joint>",
            if k == 0 { 0 } else { 1 },
            if k == 0 { "base".to_owned() } else { format!("l{}", k - 1) }
        )
    };
    let links: String = (0..turns).map(link).collect();
    let joints: String = (0..turns).map(joint).collect();
    let slide = format!(
        "<link name=\"tip\"><collision><geometry><sphere radius=\"0.1\"/></geometry></collision></link>\
         <joint name=\"slide\" type=\"prismatic\"><origin xyz=\"1.1 0 0\"/><axis xyz=\"1 0 0\"/>\
         <limit lower=\"0\" upper=\"1\" effort=\"1\" velocity=\"1\"/><parent link=\"l{}\"/><child link=\"tip\"/></joint>",
        turns - 1
    );
    let text = format!("<robot name=\"arm\"><link name=\"base\"/>{links}{joints}{slide}</robot>");
    Robot::read(&text, Path::new("."), LinkShapes::Hulls).unwrap()
}

pub(super) fn obstacle(name: &str, shape: Shape, at: DVec3) -> Obstacle {
    Obstacle { name: name.to_owned(), shape, pose: Pose::from_translation(at).unwrap() }
}

pub(super) fn checker(robot: Robot, obstacles: Vec<Obstacle>) -> EdgeChecker {
    let allowed = AllowedPairs::adjacent(&robot);
    let world = World { obstacles, ..World::default() };
    EdgeChecker::new(Workcell::new(robot, &world, &allowed).unwrap())
}

fn straight(from: &[f64], to: &[f64]) -> JointPath {
    JointPath::Straight([from.to_vec(), to.to_vec()])
}

/// The pairs that touch at t, and the least distance of all others, by each pair alone.
pub(super) fn at(checker: &EdgeChecker, path: &JointPath, t: f64) -> (Vec<[u32; 2]>, f64) {
    let (mut state, mut poses) = (Vec::new(), Vec::new());
    let cell = checker.cell();
    path.state_at(cell.robot(), t, &mut state);
    cell.robot().place(&state, &mut poses).unwrap();
    let scene = cell.scene();
    let posed = |i: u32| {
        let pose = poses.get(i as usize).unwrap_or(&scene.poses()[i as usize]);
        PosedShape { shape: scene.shape(i as usize), pose }
    };
    let (mut touching, mut least) = (Vec::new(), f64::INFINITY);
    for i in 0..scene.len() as u32 {
        for j in i + 1..scene.len() as u32 {
            if !scene.allows(i, j) {
                continue;
            }
            match certified::overlap_of(posed(i), posed(j)).0 {
                Verdict::Touching(()) => touching.push([i, j]),
                Verdict::Apart => {
                    let DistanceResult::Apart(found) = distance(posed(i), posed(j)).0 else {
                        continue;
                    };
                    least = least.min(found.upper());
                }
                Verdict::Undecided(_) => {}
            }
        }
    }
    (touching, least)
}

/// That an answer is what samples say as far as they say something.
fn assert_holds(checker: &EdgeChecker, path: &JointPath, edge: &Edge, samples: usize) {
    let free_until = if let EdgeAnswer::Free { .. } = edge.answer { 1.0 } else { edge.free_until };
    let mut least = (f64::INFINITY, 0.0);
    let look = |t: f64, least: &mut (f64, f64)| {
        if (0.0..free_until).contains(&t) || t == 1.0 && free_until == 1.0 {
            let (touching, distance) = at(checker, path, t);
            assert!(touching.is_empty(), "{path:?}: {edge:?}, but {touching:?} at {t}");
            *least = if distance < least.0 { (distance, t) } else { *least };
        }
    };
    (0..=samples).for_each(|k| look(free_until * (k as f64 / samples as f64), &mut least));
    // What is nearest may be between two samples.
    for halved in 0..20 {
        let step = free_until / (samples as f64 * f64::from(1 << halved));
        [least.1 - step, least.1 + step].into_iter().for_each(|t| look(t, &mut least));
    }
    let least = least.0;
    match edge.answer {
        EdgeAnswer::Free { clearance } => {
            assert!(clearance > 0.0 && clearance <= least, "{path:?}: {edge:?}, but {least}");
            assert!(clearance >= 0.49 * least, "{path:?}: {edge:?}, but {least}");
        }
        EdgeAnswer::Hit { t, pair } => {
            let (touching, _) = at(checker, path, t);
            assert!(touching.contains(&pair), "{path:?}: {edge:?}, but {touching:?}");
            assert!(edge.free_until <= t);
        }
        EdgeAnswer::Undecided { t, .. } => assert_eq!(t[0], edge.free_until),
    }
}

/// Numbers that differ from run to run; the seed is printed where an assertion fails.
pub(super) struct Draw(u64);

impl Draw {
    /// From the seed that `DCD_SEED` names, else always from the same.
    pub(super) fn new() -> Self {
        let named = std::env::var("DCD_SEED").ok().map(|seed| seed.parse().expect("a seed"));
        let seed: u64 = named.unwrap_or(2026);
        println!("seed {seed}");
        Self(seed)
    }

    /// From -1 to 1.
    pub(super) fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    pub(super) fn vector(&mut self) -> DVec3 {
        DVec3::new(self.unit(), self.unit(), self.unit())
    }
}

#[test]
fn random_edges_are_answered_as_their_samples_say() {
    let mut draw = Draw::new();
    let [mut free, mut hits] = [0; 2];
    for k in 0..40 {
        let robot = arm(3);
        let obstacles = (0..6).map(|n| {
            let shape = match n % 5 {
                0 => Shape::sphere(0.2 + 0.1 * draw.unit()),
                3 => Shape::mesh(
                    (0..7).map(|_| draw.vector() * 0.4).collect(),
                    vec![[0, 1, 2], [1, 2, 3], [3, 4, 5], [4, 5, 6]],
                ),
                1 => Shape::cuboid(draw.vector().abs() * 0.3 + 0.01),
                2 => Shape::cylinder(0.3, 0.1),
                _ => Shape::capsule(0.3, 0.1),
            };
            let turn = DQuat::from_scaled_axis(draw.vector() * 3.0);
            let pose = Pose::new(turn, draw.vector() * 2.5).unwrap();
            Obstacle { name: format!("o{n}"), shape: shape.unwrap(), pose }
        });
        let checker = checker(robot, obstacles.collect());
        let mut state = || -> Vec<f64> { (0..4).map(|_| draw.unit() * 1.5).collect() };
        let path = if k % 2 == 0 {
            JointPath::Straight([state(), state()])
        } else {
            JointPath::Bezier([state(), state(), state(), state()])
        };
        let edge = checker.check(&path, 100_000).unwrap();
        assert_holds(&checker, &path, &edge, 500);
        assert_eq!(edge, checker.check(&path, 100_000).unwrap());
        free += usize::from(matches!(edge.answer, EdgeAnswer::Free { .. }));
        hits += usize::from(matches!(edge.answer, EdgeAnswer::Hit { .. }));
        assert!(free + hits == k + 1, "{edge:?}");
    }
    assert!(free > 0 && hits > 0, "{free} free, {hits} hits");
}

#[test]
fn a_thin_plate_that_a_long_arm_sweeps_past_is_met() {
    // The tip's way crosses the plate of a millimetre in some 1e-4 of the edge.
    let plate = Shape::cuboid(DVec3::new(0.3, 0.0005, 0.3)).unwrap();
    let at_three = DVec3::new(3.0, 0.0, 0.0);
    let checker = checker(arm(3), vec![obstacle("plate", plate, at_three)]);
    let path = straight(&[-1.2, 0.0, 0.0, 0.2], &[1.3, 0.0, 0.0, 0.2]);
    let edge = checker.check(&path, 10_000).unwrap();
    assert!(matches!(edge.answer, EdgeAnswer::Hit { .. }), "{edge:?}");
    assert_holds(&checker, &path, &edge, 2000);
}

#[test]
fn a_full_turn_between_two_equal_places_is_not_passed_over() {
    let ball = || Shape::sphere(0.2).unwrap();
    let behind = DVec3::new(-2.0, 0.0, 0.0);
    let turn = straight(&[0.0; 4], &[std::f64::consts::TAU, 0.0, 0.0, 0.0]);
    let hit = checker(arm(3), vec![obstacle("ball", ball(), behind)]);
    let edge = hit.check(&turn, 10_000).unwrap();
    assert!(matches!(edge.answer, EdgeAnswer::Hit { .. }), "{edge:?}");
    assert_holds(&hit, &turn, &edge, 500);
    // Out of its reach it is free, and so is the way there and back.
    let free = checker(arm(3), vec![obstacle("ball", ball(), behind * 4.0)]);
    for path in [turn, JointPath::Bezier([vec![0.0; 4], vec![2.0; 4], vec![2.0; 4], vec![0.0; 4]])]
    {
        let edge = free.check(&path, 10_000).unwrap();
        assert_holds(&free, &path, &edge, 500);
    }
}

#[test]
fn an_edge_of_length_zero_is_its_state() {
    let checker =
        checker(arm(2), vec![obstacle("ball", Shape::sphere(0.2).unwrap(), DVec3::Y * 2.0)]);
    let stay = |angle: f64| straight(&[angle, 0.0, 0.0], &[angle, 0.0, 0.0]);
    let edge = checker.check(&stay(0.0), 100).unwrap();
    let EdgeAnswer::Free { clearance } = edge.answer else { panic!("{edge:?}") };
    let (_, least) = at(&checker, &stay(0.0), 0.0);
    // Half is promised; where nothing moves only the direction between two spheres may lean a little.
    assert!(clearance > 0.99 * least && clearance <= least, "{clearance} {least}");
    let edge = checker.check(&stay(std::f64::consts::FRAC_PI_2), 100).unwrap();
    assert!(matches!(edge.answer, EdgeAnswer::Hit { t: 0.0, .. }), "{edge:?}");
}

#[test]
fn a_link_that_slides_along_a_wall_at_a_micrometre_is_proved_free() {
    // The tip is a sphere of 0.1, its middle on y = 0; the wall's face is a micrometre beyond it.
    for gap in [1e-3, 1e-6, 1e-8] {
        let wall = Shape::cuboid(DVec3::new(5.0, 1.0, 5.0)).unwrap();
        let place = DVec3::new(0.0, 1.1 + gap, 0.0);
        let checker = checker(arm(1), vec![obstacle("wall", wall, place)]);
        let path = straight(&[0.0, 0.0], &[0.0, 1.0]);
        let edge = checker.check(&path, 100_000).unwrap();
        let EdgeAnswer::Free { clearance } = edge.answer else { panic!("{gap}: {edge:?}") };
        assert!(clearance <= gap * 1.0001 && clearance > 0.4 * gap, "{gap}: {clearance}");
        assert!(edge.nodes < 100, "{gap}: {}", edge.nodes);
        // Turned towards the wall by less than the gap at the far end, and by more.
        for (angle, free) in [(0.4 * gap / 2.1, true), (3.0 * gap / 1.1, false)] {
            let path = straight(&[0.0, 0.0], &[angle, 1.0]);
            let edge = checker.check(&path, 100_000).unwrap();
            assert_eq!(matches!(edge.answer, EdgeAnswer::Free { .. }), free, "{gap}: {edge:?}");
            assert_holds(&checker, &path, &edge, 200);
        }
    }
}

#[test]
fn what_a_link_carries_and_what_is_padded_moves_with_it() {
    let robot = arm(2);
    let ball = || obstacle("ball", Shape::sphere(0.2).unwrap(), DVec3::new(0.0, 3.5, 0.0));
    let mut world = World { obstacles: vec![ball()], ..World::default() };
    let turn = straight(&[0.0; 3], &[std::f64::consts::PI, 0.0, 0.0]);
    let answer = |world: &World| {
        let mut allowed = AllowedPairs::adjacent(&robot);
        allowed.extend(&world.allowed);
        let checker = EdgeChecker::new(Workcell::new(robot.clone(), world, &allowed).unwrap());
        checker.check(&turn, 10_000).unwrap().answer
    };
    assert!(matches!(answer(&world), EdgeAnswer::Free { .. }));
    let stick = Shape::cuboid(DVec3::new(0.7, 0.01, 0.01)).unwrap();
    let there = Pose::from_translation(DVec3::X * 0.7).unwrap();
    world.attach(Attached::new("stick", "tip", [(stick, there)]), [] as [&str; 0]);
    assert!(matches!(answer(&world), EdgeAnswer::Hit { .. }));
    let mut padded = World { obstacles: vec![ball()], ..World::default() };
    padded.pad(&robot, 1.15).unwrap();
    assert!(matches!(answer(&padded), EdgeAnswer::Hit { .. }));
}

#[test]
fn a_budget_ends_the_search_and_tells_where() {
    let wall = Shape::cuboid(DVec3::new(5.0, 1.0, 5.0)).unwrap();
    let checker =
        checker(arm(3), vec![obstacle("wall", wall, DVec3::new(0.0, 1.0 + 0.1 + 1e-5, 0.0))]);
    let path = straight(&[-1.5, 0.3, 0.0, 0.0], &[0.0, 0.0, 0.0, 0.5]);
    let edge = checker.check(&path, 5).unwrap();
    let EdgeAnswer::Undecided { t, reason, .. } = edge.answer else { panic!("{edge:?}") };
    assert_eq!((reason, t[0]), (EdgeReason::Budget, edge.free_until));
    assert!(edge.nodes <= 5);
    let refused = checker.check(&straight(&[0.0], &[0.0]), 5).unwrap_err().to_string();
    assert!(refused.contains("1 joint values, not 4"), "{refused}");
}

/// A bar of length 2, its end at the origin of what floats.
pub(super) fn floating() -> Robot {
    let text = r#"<robot name="floating"><link name="world"/>
      <link name="bar"><collision><origin xyz="1 0 0"/><geometry><box size="2 0.1 0.1"/></geometry></collision></link>
      <joint name="free" type="floating"><parent link="world"/><child link="bar"/></joint></robot>"#;
    Robot::read(text, Path::new("."), LinkShapes::Hulls).unwrap()
}

#[test]
fn a_floating_link_turns_the_way_that_its_quaternions_go() {
    let post = || obstacle("post", Shape::sphere(0.1).unwrap(), DVec3::new(0.0, 1.5, 0.0));
    let checker = checker(floating(), vec![post()]);
    // By z·angle: a third of a turn to either side, from along x.
    let turned = |angle: f64| {
        let q = DQuat::from_rotation_z(angle);
        [0.0, 0.0, 0.0, q.x, q.y, q.z, q.w]
    };
    let third = std::f64::consts::TAU / 3.0;
    let there = straight(&turned(0.0), &turned(third));
    let EdgeAnswer::Hit { t, .. } = checker.check(&there, 10_000).unwrap().answer else { panic!() };
    assert!((t - 0.75).abs() < 0.1, "a quarter of a turn: {t}");
    let away = straight(&turned(0.0), &turned(-third));
    let EdgeAnswer::Free { clearance } = checker.check(&away, 10_000).unwrap().answer else {
        panic!()
    };
    let least = (0..=1000).map(|k| at(&checker, &away, f64::from(k) / 1000.0).1);
    let least = least.fold(f64::INFINITY, f64::min);
    assert!(clearance <= least && clearance >= 0.4 * least, "{clearance} {least}");
    // The same rotation by the opposite quaternion is the long way round, past the post.
    let opposite = turned(-third).map(|x| -x);
    let opposite = [0.0, 0.0, 0.0, opposite[3], opposite[4], opposite[5], opposite[6]];
    let long = straight(&turned(0.0), &opposite);
    assert!(matches!(checker.check(&long, 10_000).unwrap().answer, EdgeAnswer::Hit { .. }));
}

#[test]
fn random_floating_edges_are_answered_as_their_samples_say() {
    let mut draw = Draw::new();
    let [mut free, mut hits] = [0; 2];
    for k in 0..40 {
        let posts = (0..14)
            .map(|n| obstacle(&format!("o{n}"), Shape::sphere(0.6).unwrap(), draw.vector() * 3.0));
        let checker = checker(floating(), posts.collect());
        let mut state = || {
            let (place, turn) = (draw.vector() * 2.0, DQuat::from_scaled_axis(draw.vector() * 3.0));
            let mut state = place.to_array().to_vec();
            state.extend(turn.normalize().to_array());
            state
        };
        let path = JointPath::Straight([state(), state()]);
        let found = checker.check(&path, 10_000).unwrap();
        let samples: Vec<_> =
            (0..=500).map(|s| at(&checker, &path, f64::from(s) / 500.0)).collect();
        let least = samples.iter().map(|(_, least)| *least).fold(f64::INFINITY, f64::min);
        match found.answer {
            EdgeAnswer::Free { clearance } => {
                free += 1;
                assert!(samples.iter().all(|(touching, _)| touching.is_empty()), "{k}");
                assert!(clearance <= least, "{k}: {clearance} {least}");
            }
            EdgeAnswer::Hit { t, pair } => {
                hits += 1;
                assert!(at(&checker, &path, t).0.contains(&pair), "{k}");
            }
            EdgeAnswer::Undecided { .. } => {}
        }
        let before =
            samples.iter().enumerate().filter(|(s, _)| *s as f64 / 500.0 < found.free_until);
        assert!(before.into_iter().all(|(_, (touching, _))| touching.is_empty()), "{k}");
    }
    assert!(free > 5 && hits > 5, "{free} {hits}");
}

#[test]
fn quaternions_without_one_way_between_them_are_refused() {
    let checker = checker(floating(), Vec::new());
    let (one, other) = ([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0]);
    let refused = checker.check(&straight(&one, &other), 10).unwrap_err().to_string();
    assert!(refused.contains("opposite") && refused.contains("free/rot_x"), "{refused}");
    let far = straight(&one, &[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.1]);
    let refused = checker.check(&far, 10).unwrap_err().to_string();
    assert!(refused.contains("quaternion") && refused.contains("free/rot"), "{refused}");
    let [a, b] = [one.to_vec(), vec![0.0, 0.0, 0.0, 0.6, 0.0, 0.0, 0.8]];
    let curve = JointPath::Bezier([a.clone(), a.clone(), b, a.clone()]);
    let refused = checker.check(&curve, 10).unwrap_err().to_string();
    assert!(refused.contains("curve of quaternions"), "{refused}");
    let mut moved = a.clone();
    moved[0] = 1.0;
    let curve = JointPath::Bezier([a.clone(), moved.clone(), moved, a]);
    assert!(matches!(checker.check(&curve, 10).unwrap().answer, EdgeAnswer::Free { .. }));
}

/// A cart on a plane with an arm whose finger slides as the arm turns.
fn cart() -> Robot {
    let text = r#"<robot name="cart"><link name="world"/>
      <link name="cart"><collision><geometry><box size="0.6 0.4 0.2"/></geometry></collision></link>
      <link name="arm"><collision><origin xyz="0.5 0 0"/><geometry><box size="0.8 0.1 0.1"/></geometry></collision></link>
      <link name="finger"><collision><geometry><cylinder radius="0.05" length="0.3"/></geometry></collision></link>
      <joint name="drive" type="planar"><axis xyz="0 0 1"/><parent link="world"/><child link="cart"/></joint>
      <joint name="turn" type="revolute"><origin xyz="0 0 0.2"/><axis xyz="0 0.6 0.8"/><parent link="cart"/><child link="arm"/>
        <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
      <joint name="slide" type="prismatic"><origin xyz="1 0 0"/><axis xyz="1 0 0"/><parent link="arm"/><child link="finger"/>
        <limit lower="-1" upper="1" effort="1" velocity="1"/><mimic joint="turn" multiplier="-0.3" offset="0.1"/></joint>
      </robot>"#;
    Robot::read(text, Path::new("."), LinkShapes::Hulls).unwrap()
}

/// The surface of a box as triangles.
fn box_of_triangles(half: DVec3) -> Shape {
    let corner = |k: usize| {
        let side = |bit: usize| if k >> bit & 1 == 1 { 1.0 } else { -1.0 };
        DVec3::new(side(0), side(1), side(2)) * half
    };
    let faces: [[u32; 4]; 6] =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
    Shape::mesh((0..8).map(corner).collect(), triangles.collect()).unwrap()
}

#[test]
fn planar_mimicking_and_limited_joints_among_triangles_are_answered_as_samples_say() {
    let mut draw = Draw::new();
    let (mut paths, mut edges) = (Vec::new(), Vec::new());
    let obstacles = (0..5).map(|n| {
        let half = draw.vector().abs() * 0.4 + 0.005;
        let shape = if n % 2 == 0 { box_of_triangles(half) } else { Shape::cuboid(half).unwrap() };
        let turn = DQuat::from_scaled_axis(draw.vector() * 3.0);
        let pose = Pose::new(turn, draw.vector() * 2.0).unwrap();
        Obstacle { name: format!("o{n}"), shape, pose }
    });
    let checker = checker(cart(), obstacles.collect());
    for k in 0..30 {
        // The arm at its limits, within and beyond them.
        let mut turn = || [1.0, -1.0, 0.5, 2.5 * draw.unit()][k % 4];
        let turns = [turn(), turn()];
        let mut state =
            |turn: f64| vec![draw.unit() * 2.0, draw.unit() * 2.0, draw.unit() * 4.0, turn];
        let path = JointPath::Straight(turns.map(&mut state));
        let edge = checker.check(&path, 100_000).unwrap();
        assert!(!matches!(edge.answer, EdgeAnswer::Undecided { .. }), "{path:?}: {edge:?}");
        assert_holds(&checker, &path, &edge, 300);
        paths.push(path);
        edges.push(edge);
    }
    let is_free = |edge: &&Edge| matches!(edge.answer, EdgeAnswer::Free { .. });
    let free = edges.iter().filter(is_free).count();
    println!("{free} of {} are free", edges.len());
    for exec in [dcd_exec::Par::Serial, dcd_exec::Par::Pool] {
        for size in [1, 7, 30] {
            let found = paths.chunks(size).flat_map(|part| checker.check_all(part, 100_000, exec));
            let found: Vec<Edge> = found.map(Result::unwrap).collect();
            assert_eq!(found, edges, "{exec:?}, {size} at once");
        }
    }
}

#[test]
fn another_cell_is_checked_as_by_a_checker_of_its_own() {
    let mut draw = Draw::new();
    let robot = arm(3);
    let allowed = AllowedPairs::adjacent(&robot);
    let mut cell = || {
        let balls = (0..4)
            .map(|n| obstacle(&format!("o{n}"), Shape::sphere(0.3).unwrap(), draw.vector() * 2.0));
        let world = World { obstacles: balls.collect(), ..World::default() };
        Workcell::new(robot.clone(), &world, &allowed).unwrap()
    };
    let mut held = EdgeChecker::new(cell());
    let mut one = Draw::new();
    for _ in 0..10 {
        let cell = cell();
        held.set_cell(cell.clone());
        let mut state = || -> Vec<f64> { (0..4).map(|_| one.unit()).collect() };
        let path = JointPath::Straight([state(), state()]);
        let alone = EdgeChecker::new(cell);
        assert_eq!(held.check(&path, 10_000).unwrap(), alone.check(&path, 10_000).unwrap());
    }
}
