//! A robot among 100,000 sensed points: what it costs to take them, to take out the robot's own, and to check states.
//!
//! `cargo run --release -p dcd-robot --example sensed -- ROBOT.urdf`

use dcd_geom::glam::DVec3;
use dcd_pipeline::Par;
use dcd_robot::{AllowedPairs, Robot, SensedPoint, SensedWorld, StateChecker, Workcell, World};
use std::path::PathBuf;
use std::time::Instant;

const POINTS: u32 = 100_000;
const STATES: u32 = 1000;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let Some(urdf) = std::env::args_os().nth(1).map(PathBuf::from) else {
        println!("sensed ROBOT.urdf");
        return Ok(());
    };
    let robot = Robot::load(&urdf)?;
    let cell = Workcell::new(robot, &World::default(), &AllowedPairs::default())?;
    let checker = StateChecker::new(cell)?;
    // A table before the robot and a wall behind it, by a sequence that fills the unit square evenly.
    let points: Vec<SensedPoint> = (0..POINTS)
        .map(|k| {
            let part = |step: f64| (f64::from(k) * step).fract();
            let (u, v) = (part(0.754_877_666_246_692_8), part(0.569_840_290_998_053_3));
            let centre = if k % 2 == 0 {
                DVec3::new(0.35 + 0.8 * u, 1.6 * v - 0.8, 0.1)
            } else {
                DVec3::new(-0.5, 2.0 * u - 1.0, 1.5 * v)
            };
            SensedPoint { centre, radius: 0.005 }
        })
        .collect();
    let begun = Instant::now();
    let mut sensed = SensedWorld::of_points(&points)?;
    println!("{POINTS} points made in {:.2?}", begun.elapsed());
    let begun = Instant::now();
    sensed.replace_points(&points)?;
    println!("replaced in {:.2?}", begun.elapsed());
    let rest = checker.cell().robot().rest_state();
    let begun = Instant::now();
    let own = checker.own_points(&rest, &sensed, 0.02)?;
    sensed.remove(&own);
    println!("{} of the robot's own found and removed in {:.2?}", own.len(), begun.elapsed());
    let state = |k: u32| {
        let value = |joint: usize| {
            let part = (f64::from(k) * [0.819_172_5, 0.671_043_6, 0.549_700_4][joint % 3]).fract();
            1.5 * (part - 0.5) * (1.0 + joint as f64 % 2.0)
        };
        rest.iter().enumerate().map(|(joint, rest)| rest + value(joint)).collect()
    };
    let states: Vec<Vec<f64>> = (0..STATES).map(state).collect();
    checker.collides_with_sensed(&states, &sensed, Par::Serial)?;
    let begun = Instant::now();
    let collides = checker.collides_with_sensed(&states, &sensed, Par::Serial)?;
    let spent = begun.elapsed() / STATES;
    let hit = collides.iter().filter(|hit| **hit).count();
    println!("{STATES} states, {hit} not free: {spent:.2?} each");
    Ok(())
}
