//! Worlds that change: an obstacle that comes, moves or goes, all of them exchanged, a cloud of points replaced.

use std::sync::Arc;
use std::time::Duration;

use anyhow::{Context, Result, ensure};
use dcd_benches::timing::time;
use dcd_exec::Par;
use dcd_geom::{Pose, Shape, glam::DVec3};
use dcd_robot::{
    AllowedPairs, Obstacle, Robot, SensedPoint, SensedWorld, StateChecker, Workcell, World,
};
use serde::{Deserialize, Serialize};

use crate::data::on_the_way;

/// How many obstacles a world has.
pub(crate) const OBSTACLES: [usize; 2] = [12, 1000];

/// How many points are seen, and how many states are checked among them.
pub(crate) const POINTS: usize = 100_000;
const STATES: usize = 1000;

/// How many states are checked after a change, and how many changes there are.
const AT_ONCE: usize = 16;
const CHANGES: usize = 400;

/// Microseconds.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Outcome {
    pub(crate) worlds: Vec<Changes>,
    pub(crate) sensed: Sensed,
}

/// The medians of changes of a world of so many obstacles.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Changes {
    pub(crate) obstacles: usize,
    pub(crate) moved: f64,
    pub(crate) added: f64,
    pub(crate) removed: f64,
    pub(crate) exchanged: f64,
    /// A cell and a checker made of world and robot.
    pub(crate) made: f64,
    /// All pairs of [`AT_ONCE`] states: again, and right after an obstacle moved since one went.
    pub(crate) checked: f64,
    pub(crate) checked_after: f64,
}

/// A cloud of [`POINTS`].
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Sensed {
    pub(crate) replaced: f64,
    /// Of a state, the mean; how many of [`STATES`] are free.
    pub(crate) state: f64,
    pub(crate) free: usize,
}

pub(crate) fn run(
    (robot, allowed): (Robot, &AllowedPairs),
    ends: &[Vec<f64>; 2],
    rounds: usize,
) -> Result<Outcome> {
    let robot = Arc::new(robot);
    let worlds = OBSTACLES
        .iter()
        .map(|&count| changes((&robot, allowed), ends, (count, CHANGES.min(CHANGES * rounds / 5))));
    let worlds = worlds.collect::<Result<_>>()?;
    let cell = Workcell::new(robot, &World::default(), allowed)?;
    Ok(Outcome { worlds, sensed: sensed(&StateChecker::new(cell)?, rounds)? })
}

/// Numbers that fill the unit cube evenly.
fn even(k: usize) -> DVec3 {
    let part = |step: f64| (k as f64 * step).fract();
    DVec3::new(
        part(0.819_172_513_396_164_5),
        part(0.671_043_606_703_789_2),
        part(0.549_700_477_901_970_3),
    )
}

/// A box or a cylinder round the robot, smaller where there are many.
fn obstacle(k: usize, count: usize) -> Result<Obstacle> {
    let size = 0.3 / (count as f64).cbrt();
    let shape = if k.is_multiple_of(3) {
        Shape::cylinder(size, 0.5 * size)?
    } else {
        Shape::cuboid(DVec3::new(1.0, 0.6, 0.2) * size)?
    };
    Ok(Obstacle { name: format!("obstacle {k}"), shape, pose: pose(k)? })
}

fn pose(k: usize) -> Result<Pose> {
    let at = (even(k) - DVec3::new(0.5, 0.5, 0.0)) * DVec3::new(2.0, 2.0, 1.4);
    Ok(Pose::from_translation(at)?)
}

fn changes(
    (robot, allowed): (&Arc<Robot>, &AllowedPairs),
    ends: &[Vec<f64>; 2],
    (count, changes): (usize, usize),
) -> Result<Changes> {
    let obstacles = (0..count).map(|k| obstacle(k, count)).collect::<Result<Vec<_>>>()?;
    let mut world = World { obstacles, ..World::default() };
    let states = on_the_way(ends, AT_ONCE);
    let make = |world: &World| -> Result<StateChecker> {
        Ok(StateChecker::new(Workcell::new(robot.clone(), world, allowed)?)?)
    };
    let (mut times, mut checker) = ([const { Vec::new() }; 7], make(&world)?);
    for k in 0..changes {
        let (place, to) = (k * 7 % count, pose(count + k)?);
        let (spent, moved) = time(|| checker.move_obstacle(place, to));
        moved?;
        world.obstacles[place].pose = to;
        times[0].push(spent);
        for times in &mut times[1..3] {
            let (spent, found) = time(|| checker.all(&states, Par::Serial));
            found?;
            times.push(spent);
        }
        let new = obstacle(count + k, count)?;
        let (spent, added) = time(|| checker.add_obstacle(&new));
        ensure!(added? == count, "an obstacle is not behind the others");
        times[3].push(spent);
        let (spent, removed) = time(|| checker.remove_obstacle(place));
        removed?;
        times[4].push(spent);
        world.obstacles[place] = new;
        if k.is_multiple_of(20) {
            let (spent, anew) = time(|| make(&world));
            times[5].push(spent);
            let found = anew?.all(&states, Par::Serial)?;
            ensure!(found == checker.all(&states, Par::Serial)?, "a changed world differs");
            let (spent, exchanged) = time(|| checker.set_obstacles(&world.obstacles));
            exchanged?;
            times[6].push(spent);
            ensure!(found == checker.all(&states, Par::Serial)?, "an exchanged world differs");
        }
    }
    let [moved, checked_after, checked, added, removed, made, exchanged] = times.map(median);
    let obstacles = count;
    Ok(Changes { obstacles, moved, added, removed, exchanged, made, checked, checked_after })
}

fn median(mut times: Vec<Duration>) -> f64 {
    times.sort_unstable();
    times.get(times.len() / 2).map_or(f64::NAN, |time| time.as_secs_f64() * 1e6)
}

/// A table before the robot and a wall behind it.
fn sensed(checker: &StateChecker, rounds: usize) -> Result<Sensed> {
    let point = |k: usize| {
        let DVec3 { x: u, y: v, .. } = even(k);
        let centre = if k.is_multiple_of(2) {
            DVec3::new(0.35 + 0.8 * u, 1.6 * v - 0.8, 0.1)
        } else {
            DVec3::new(-0.5, 2.0 * u - 1.0, 1.5 * v)
        };
        SensedPoint { centre, radius: 0.005 }
    };
    let points: Vec<SensedPoint> = (0..POINTS).map(point).collect();
    let mut sensed = SensedWorld::of_points(&points)?;
    let rest = checker.cell().robot().rest_state();
    let state = |k: usize| {
        let value = |joint: usize| 1.5 * (even(k)[joint % 3] - 0.5) * (1.0 + joint as f64 % 2.0);
        rest.iter().enumerate().map(|(joint, rest)| rest + value(joint)).collect()
    };
    let states: Vec<Vec<f64>> = (0..STATES).map(state).collect();
    let (mut replaced, mut checked, mut free) = (Vec::new(), Vec::new(), None);
    for _ in 0..=rounds {
        let (spent, done) = time(|| sensed.replace_points(&points));
        done?;
        replaced.push(spent);
        let (spent, found) = time(|| checker.collides_with_sensed(&states, &sensed, Par::Serial));
        let count = found?.iter().filter(|hit| !**hit).count();
        ensure!(*free.get_or_insert(count) == count, "two checks of a cloud differ");
        checked.push(spent);
    }
    let free = free.context("no round")?;
    Ok(Sensed { replaced: median(replaced), state: median(checked) / STATES as f64, free })
}
