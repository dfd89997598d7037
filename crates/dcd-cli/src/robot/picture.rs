//! A robot in its world as binary glTF: states one after the other, motions between them.

use super::refused;
use crate::failure::{Failure, print_message};
use crate::output::Output;
use dcd_io::{GlbContact, GlbScene};
use dcd_pipeline::{Par, Pipeline};
use dcd_robot::{JointPath, Robot, RobotError, Workcell};

/// How long a state is shown that is no part of a motion, seconds.
const SHOWN: f64 = 0.5;

/// How many states of an edge are shown, both ends among them: two seconds.
const OF_AN_EDGE: usize = 61;

/// How long a state of a motion is shown, seconds.
const OF_A_MOTION: f64 = 1.0 / 30.0;

/// States to be drawn.
#[derive(Debug, Default)]
pub(super) struct Picture {
    states: Vec<Vec<f64>>,
    /// Whether they are states of motions.
    moves: bool,
}

impl Picture {
    /// Adds a state.
    pub(super) fn show(&mut self, state: &[f64]) {
        self.states.push(state.to_vec());
    }

    /// Adds the states of a motion, that of the parameter at which it touches among them.
    pub(super) fn follow(&mut self, robot: &Robot, path: &JointPath, hit: Option<f64>) {
        self.moves = true;
        let last = (OF_AN_EDGE - 1) as f64;
        let mut at: Vec<f64> = (0..OF_AN_EDGE).map(|k| k as f64 / last).chain(hit).collect();
        at.sort_unstable_by(f64::total_cmp);
        at.dedup();
        for t in at {
            let mut state = Vec::new();
            path.state_at(robot, t, &mut state);
            self.states.push(state);
        }
    }

    /// Writes the robot of a cell in these states: links and obstacles by their names, of those that are
    /// padded what they are without it; what touches, and what may, in another colour; the points where.
    pub(super) fn write(&self, cell: &mut Workcell, mut file: Output) -> Result<(), Failure> {
        let scene = cell.scene().clone();
        let is_padded = |i: usize| cell.part_of(i).is_some_and(|part| part != i);
        let name = |i: usize| (!is_padded(i)).then(|| cell.names()[i].clone());
        let names = (0..scene.len()).map(name).collect();
        let mut glb = GlbScene::new(&scene).named(names).map_err(Failure::Output)?;
        let every = if self.moves { OF_A_MOTION } else { SHOWN };
        if !self.moves {
            glb = glb.held();
        }
        let (mut pipeline, mut unknown) = (Pipeline::new(), None);
        for (k, state) in self.states.iter().enumerate() {
            cell.set_state(state).map_err(refused)?;
            let touching = touching(cell, &mut pipeline);
            let points = if touching.is_empty() { Ok(Vec::new()) } else { contacts(cell, state) };
            let points = points.unwrap_or_else(|error| {
                unknown.get_or_insert(error);
                Vec::new()
            });
            glb.frame(k as f64 * every, cell.scene().poses(), touching, points)
                .map_err(Failure::Output)?;
        }
        if let Some(error) = unknown {
            print_message(format_args!(
                "--glb: contact points that are not known are not drawn: {error}"
            ));
        }
        file.write(|to| glb.write(to))?;
        file.commit()
    }
}

/// The objects that touch or may touch in the cell as it stands, a padded link by the link.
fn touching(cell: &Workcell, pipeline: &mut Pipeline) -> Vec<u32> {
    let step = pipeline.step(cell.scene(), Par::Pool);
    let left = step.report().undecided().iter().map(|left| left.pair.into());
    let objects = step.contacts().chain(left).flat_map(|(i, j)| [i, j]);
    objects.map(|i| cell.part_of(i as usize).map_or(i, |part| part as u32)).collect()
}

/// Where they touch: midway between the two shapes' deepest points, the normal from one to the other.
fn contacts(cell: &mut Workcell, state: &[f64]) -> Result<Vec<GlbContact>, RobotError> {
    let found = cell.clearances(state, 0.0)?;
    Ok(found
        .iter()
        .map(|clearance| &clearance.proximity)
        .map(|near| GlbContact { point: near.point_a.midpoint(near.point_b), normal: near.normal })
        .collect())
}
