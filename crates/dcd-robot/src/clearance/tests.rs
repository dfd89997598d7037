//! Clearances beside every pair measured alone, and gradients beside finite differences.

use super::*;
use crate::{AllowedPairs, LinkShapes, Obstacle, World};
use dcd_geom::{Pose, Shape};
use dcd_gjk::query::Smoothness;
use std::path::Path;

/// Joints of every kind: one floats, two turn, one mimics, one slides.
const ROBOT: &str = r#"<robot name="arm">
  <link name="world"/>
  <link name="body"><collision><geometry><box size="0.3 0.2 0.4"/></geometry></collision></link>
  <link name="upper"><collision><origin xyz="0.2 0 0.3" rpy="0.3 0 0.1"/>
    <geometry><box size="0.1 0.12 0.5"/></geometry></collision></link>
  <link name="lower"><collision><origin xyz="0 0.1 0.3"/>
    <geometry><sphere radius="0.11"/></geometry></collision></link>
  <link name="hand"><collision><origin xyz="0 0 0.1"/>
    <geometry><box size="0.08 0.3 0.02"/></geometry></collision></link>
  <link name="finger"><collision><origin xyz="0.05 0 0.1"/>
    <geometry><box size="0.02 0.02 0.1"/></geometry></collision></link>
  <joint name="float" type="floating"><parent link="world"/><child link="body"/></joint>
  <joint name="shoulder" type="revolute"><parent link="body"/><child link="upper"/>
    <origin xyz="0.1 0 0.4" rpy="0.2 -0.3 0.1"/><axis xyz="0 0.6 0.8"/>
    <limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
  <joint name="elbow" type="continuous"><parent link="upper"/><child link="lower"/>
    <origin xyz="0 0 0.7"/><axis xyz="1 0 0"/></joint>
  <joint name="wrist" type="prismatic"><parent link="lower"/><child link="hand"/>
    <origin xyz="0 0 0.5"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
  <joint name="knuckle" type="revolute"><parent link="hand"/><child link="finger"/>
    <origin xyz="0 0 0.2"/><axis xyz="0 1 0"/><mimic joint="elbow" multiplier="-0.5" offset="0.2"/>
    <limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
</robot>"#;

/// Numbers in −1 … 1 by a linear congruence.
struct Draw(u64);

impl Draw {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    fn state(&mut self) -> Vec<f64> {
        let mut q = || DQuat::from_xyzw(self.next(), self.next(), self.next(), self.next());
        let q = q().normalize();
        let place = [self.next(), self.next(), self.next()];
        let joints = [3.0, 3.0, 0.3].map(|reach| reach * self.next());
        [&place[..], &q.to_array(), &joints].concat()
    }
}

fn cell() -> Workcell {
    let robot = Robot::read(ROBOT, Path::new("."), LinkShapes::Hulls).unwrap();
    let allowed = AllowedPairs::adjacent(&robot);
    let at = |x: f64, y: f64, z: f64| {
        Pose::new(DQuat::from_rotation_y(x) * DQuat::from_rotation_x(z), DVec3::new(x, y, z))
    };
    let shapes = [
        Shape::sphere(0.3).unwrap(),
        Shape::cuboid(DVec3::new(0.2, 0.3, 0.1)).unwrap(),
        Shape::hull(vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z * 0.5]).unwrap(),
    ];
    let places = [at(1.6, 0.3, 0.2), at(-1.4, 0.6, 0.8), at(0.2, -1.8, 0.3)];
    let obstacles = shapes.into_iter().zip(places).zip(["ball", "box", "wedge"]);
    let obstacles = obstacles.map(|((shape, pose), name)| Obstacle {
        name: name.to_owned(),
        shape,
        pose: pose.unwrap(),
    });
    let world = World { obstacles: obstacles.collect(), ..World::default() };
    Workcell::new(robot, &world, &allowed).unwrap()
}

#[test]
fn the_clearance_is_the_least_of_all_pairs_each_measured_alone() {
    let (mut cell, mut draw) = (cell(), Draw(1));
    let mut touching = 0;
    for _ in 0..300 {
        let state = draw.state();
        let clearance = cell.clearance(&state).unwrap().unwrap();
        let solver = Proximities::within(1e6).unwrap();
        let pairs = cell.pairs_by_gap();
        assert!(pairs.len() > 20);
        let measured = pairs.iter().map(|&(gap, pair)| {
            let verdict =
                solver.solve(cell.posed(pair.i), cell.posed(pair.j), &mut Scratch::default());
            let Verdict::Touching(found) = verdict else { panic!("{verdict:?}") };
            assert!(gap <= found.signed_distance.max(0.0) + found.error_bound, "{gap} {found:?}");
            (pair, found)
        });
        let all: Vec<(Pair, Proximity)> = measured.collect();
        let least = all.iter().map(|(_, found)| found.signed_distance).fold(f64::MAX, f64::min);
        assert_eq!(clearance.proximity.signed_distance, least);
        touching += usize::from(least < 0.0);
        let margin = 0.4;
        let mut due: Vec<Pair> = all
            .iter()
            .filter(|(_, f)| f.signed_distance <= margin)
            .map(|(pair, _)| *pair)
            .collect();
        due.sort_unstable();
        let near = cell.clearances(&state, margin).unwrap();
        let due: Vec<[u32; 2]> = due.iter().map(|pair| [pair.i, pair.j]).collect();
        assert_eq!(near.iter().map(|near| near.objects).collect::<Vec<_>>(), due);
    }
    assert!(touching > 20, "{touching}");
    assert!(cell.clearances(&draw.state(), f64::NAN).is_err());
}

#[test]
fn the_normal_points_from_the_first_name_to_the_other_beside_padded_links_too() {
    let (cell, mut draw) = (cell(), Draw(4));
    let world = World {
        obstacles: (0..cell.names().len())
            .filter(|&i| cell.part_of(i).is_none())
            .map(|i| Obstacle {
                name: cell.names()[i].clone(),
                shape: cell.scene().shape(i).clone(),
                pose: cell.scene().poses()[i],
            })
            .collect(),
        ..World::default()
    };
    let robot = cell.robot().clone();
    let mut padded = world;
    padded.pad(&robot, 0.05).unwrap();
    let mut cell = Workcell::new(robot, &padded, &AllowedPairs::default()).unwrap();
    assert!(cell.is_padded());
    let (point, mut with_obstacles) = (Shape::sphere(0.0).unwrap(), 0);
    for _ in 0..50 {
        for near in cell.clearances(&draw.state(), 1.0).unwrap() {
            let [a, b] = near.objects;
            assert!(cell.part_of(a as usize).is_some(), "the robot's comes first");
            let [first, other] = cell.names_of((a, b)).map(str::to_owned);
            let obstacles = ["ball", "box", "wedge"];
            assert!(!obstacles.contains(&&*first));
            with_obstacles += usize::from(obstacles.contains(&&*other));
            // Where each says that it is.
            let found = near.proximity;
            for (object, place) in [(a, found.point_a), (b, found.point_b)] {
                let pose = Pose::from_translation(place).unwrap();
                let posed = PosedShape { shape: &point, pose: &pose };
                let solver = Proximities::within(1e6).unwrap();
                let verdict = solver.solve(posed, cell.posed(object), &mut Scratch::default());
                let Verdict::Touching(off) = verdict else { panic!("{verdict:?}") };
                assert!(off.signed_distance.abs() < 1e-6, "{object}: {off:?}");
            }
        }
    }
    assert!(with_obstacles > 20, "{with_obstacles}");
}

#[test]
fn the_gradient_is_what_finite_differences_find_where_it_is_smooth() {
    const STEP: f64 = 1e-5;
    let (mut cell, mut draw) = (cell(), Draw(7));
    let mut compared = 0;
    for _ in 0..200 {
        let state = draw.state();
        for near in cell.clearances(&state, 0.5).unwrap() {
            if near.proximity.smoothness != Smoothness::Smooth {
                continue;
            }
            let mut at = |state: &[f64]| {
                // Quaternions are made of unit length again, as a robot takes them.
                let mut state = state.to_vec();
                let q = quaternion(&state, 3).normalize();
                state[3..7].copy_from_slice(&q.to_array());
                let all = cell.clearances(&state, 10.0).unwrap();
                all.into_iter().find(|found| found.objects == near.objects).unwrap().proximity
            };
            for variable in 0..state.len() {
                let moved = |by: f64| {
                    let mut moved = state.clone();
                    moved[variable] += by;
                    moved
                };
                let (before, after) = (at(&moved(-STEP)), at(&moved(STEP)));
                // Where a corner turns into an edge the derivative bends.
                let bends = (before.normal - after.normal).length() > 100.0 * STEP;
                if bends || [before, after].iter().any(|p| p.smoothness != Smoothness::Smooth) {
                    continue;
                }
                let slope = (after.signed_distance - before.signed_distance) / (2.0 * STEP);
                let said = near.gradient[variable];
                assert!((slope - said).abs() < 1e-6, "{variable}: {said} {slope} {near:?}");
                compared += 1;
            }
        }
    }
    assert!(compared > 5000, "{compared}");
}

#[test]
fn the_least_distance_has_a_bound_that_covers_the_pairs_that_are_less_well_known() {
    let known = |signed_distance, error_bound| Proximity {
        signed_distance,
        error_bound,
        ..Proximity::default()
    };
    let (near, far) = ([0, 1], [0, 2]);
    // The second may be as near as 0.25.
    let mut least = Least::default();
    least.take(near, known(1.0, 1e-9));
    least.take(far, known(1.25, 1.0));
    let (pair, found) = least.with_its_bound().unwrap();
    assert_eq!((pair, found.signed_distance), (near, 1.0));
    assert!(found.error_bound >= 0.75 && found.error_bound < 0.75 + 1e-9);
    // The other way round, and with a bound that says nothing.
    let mut least = Least::default();
    least.take(far, known(1.25, f64::MAX));
    least.take(near, known(1.0, 1e-9));
    let (pair, found) = least.with_its_bound().unwrap();
    assert_eq!((pair, found.error_bound), (near, f64::MAX));
    assert!(Least::default().with_its_bound().is_none());
}
