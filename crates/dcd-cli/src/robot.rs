//! `dcd robot`: which links of a robot touch each other or its world.

mod judge;
mod problems;
mod rival;
mod state;

use crate::failure::Failure;
use clap::{Args, ValueEnum};
use dcd_pipeline::{Par, Pipeline};
use dcd_robot::{AllowedPairs, LinkShapes, Request, Robot as Model, RobotError, Workcell, World};
use serde::Serialize;
use std::fmt::Write as _;
use std::io::{Write, stdout};
use std::path::PathBuf;

const DETAILS: &str = "\
Each mesh of the URDF's collision geometry (OBJ) is taken as the hull of its vertices, or, with \
--links meshes, as its triangles. A world is a scene of MoveIt as YAML: boxes, cylinders and spheres. The pairs of its allowed collision matrix \
may touch as those of the SRDF may; without an SRDF, links that a joint joins and links that are \
rigidly tied may. Joints that are fixed in the URDF stay as they are, whatever a request says.

--all-problems checks, for each scene and request of the archive, 100 states on the straight line \
from start to goal in joint space, both ends among them, by Parry in f64 as well, on the same \
shapes; each pair on which the two differ is settled exactly and told. Times are of one thread: \
ours of a batch of 100 states against a world that is made before; Parry's of the boxes of the \
links, a tree over the world that is made before, and query::intersection_test. A file of the archive \
unpacks to 16,777,216 bytes at most, all of it to 1,073,741,824.";

/// What the meshes of the links are taken as.
#[derive(Clone, Copy, ValueEnum)]
enum Links {
    /// The hulls of their vertices
    Hulls,
    /// Their triangles, which have no inside
    Meshes,
}

/// Find the touching links of a robot
#[derive(Args)]
#[command(after_long_help = DETAILS)]
pub(crate) struct Robot {
    /// The robot as URDF
    urdf: PathBuf,
    /// The pairs of links that may touch (disable_collisions)
    #[arg(long, value_name = "FILE")]
    srdf: Option<PathBuf>,
    /// What the meshes of the links are taken as
    #[arg(long, value_enum, default_value = "hulls")]
    links: Links,
    /// What stands round it: a scene of MoveIt as YAML
    #[arg(long, value_name = "SCENE.yaml", conflicts_with = "all_problems")]
    world: Option<PathBuf>,
    /// Joint values, comma-separated: one for each moved joint in the URDF's order, or NAME=VALUE
    /// for some [default: all 0]
    #[arg(
        long,
        value_name = "VALUES",
        allow_hyphen_values = true,
        conflicts_with_all = ["request", "goal", "all_problems"]
    )]
    state: Option<String>,
    /// A request of MoveIt as YAML in place of a state: its start
    #[arg(long, value_name = "REQUEST.yaml", conflicts_with = "all_problems")]
    request: Option<PathBuf>,
    /// The request's goal in place of its start
    #[arg(long, requires = "request")]
    goal: bool,
    /// An archive (tar.bz2) of sceneNUMBER.yaml and requestNUMBER.yaml: all are checked, beside
    /// Parry
    #[arg(long, value_name = "ARCHIVE")]
    all_problems: Option<PathBuf>,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// What one state's check found.
#[derive(Debug, Serialize)]
struct Answer {
    robot: String,
    links_with_shapes: usize,
    obstacles: usize,
    state: Vec<(String, f64)>,
    candidates: usize,
    touching: Vec<[String; 2]>,
    undecided: Vec<[String; 2]>,
}

impl Robot {
    pub(crate) fn run(self) -> Result<(), Failure> {
        let shapes = match self.links {
            Links::Hulls => LinkShapes::Hulls,
            Links::Meshes => LinkShapes::Meshes,
        };
        let model = Model::load_as(&self.urdf, shapes).map_err(refused)?;
        let allowed = match &self.srdf {
            Some(srdf) => AllowedPairs::load(srdf).map_err(refused)?,
            None => AllowedPairs::adjacent(&model),
        };
        let text = match &self.all_problems {
            Some(archive) => {
                let checked = problems::check(&model, &allowed, archive)?;
                if self.json { checked.json() } else { checked.text() }
            }
            None => {
                let answer = self.check(model, allowed)?;
                if self.json { answer.json() } else { answer.text() }
            }
        };
        stdout().write_all(text.as_bytes()).map_err(Failure::Output)
    }

    fn check(&self, model: Model, mut allowed: AllowedPairs) -> Result<Answer, Failure> {
        let world = self.world.as_deref().map(World::load).transpose().map_err(refused)?;
        let world = world.unwrap_or_default();
        allowed.extend(&world.allowed);
        let state = self.state_of(&model)?;
        let mut cell = Workcell::new(model, &world, &allowed).map_err(refused)?;
        cell.set_state(&state).map_err(refused)?;
        let mut pipeline = Pipeline::new();
        let step = pipeline.step(cell.scene(), Par::Serial);
        let named = |(i, j): (u32, u32)| [i, j].map(|k| cell.names()[k as usize].clone());
        let mut touching: Vec<_> = step.contacts().map(named).collect();
        touching.sort();
        let undecided = step.report().undecided().iter();
        Ok(Answer {
            robot: cell.robot().name.clone(),
            links_with_shapes: cell.robot().parts().len(),
            obstacles: world.obstacles.len(),
            state: cell.robot().moved_joints().iter().cloned().zip(state).collect(),
            candidates: step.candidate_count(),
            touching,
            undecided: undecided.map(|undecided| named(undecided.pair.into())).collect(),
        })
    }

    fn state_of(&self, model: &Model) -> Result<Vec<f64>, Failure> {
        if let Some(path) = &self.request {
            let request = Request::load(path).map_err(refused)?;
            let state = if self.goal { request.goal_of(model) } else { request.start_of(model) };
            return state.map_err(|error| Failure::at(path.display(), error));
        }
        match &self.state {
            Some(text) => state::parse(text, model).map_err(|e| Failure::at("--state", e)),
            None => Ok(vec![0.0; model.moved_joints().len()]),
        }
    }
}

/// The error names its file.
fn refused(error: RobotError) -> Failure {
    Failure::Input(error.to_string())
}

impl Answer {
    fn json(&self) -> String {
        // Strings and finite numbers alone: nothing in it can fail.
        serde_json::to_string(self).unwrap_or_default() + "\n"
    }

    fn text(&self) -> String {
        let mut text = String::new();
        for (pairs, what) in [(&self.touching, "touch"), (&self.undecided, "are undecided")] {
            for [a, b] in pairs {
                // Writing to a string cannot fail.
                let _ = writeln!(text, "{a} and {b} {what}");
            }
        }
        if text.is_empty() {
            text.push_str("nothing touches\n");
        }
        text
    }
}
