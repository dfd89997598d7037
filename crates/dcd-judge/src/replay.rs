//! Certificates of robot edges, replayed: that every configuration on an edge is free, by planes that a file names and
//! kinematics of its own in intervals (the format: docs/guide/certificates.md).
//!
//! Nothing is taken from the crates that wrote the file, and nothing of what the file says is believed but what it is about: the
//! robot, the bodies, the pairs that may touch and the path. A plane counts where, on all of its interval, an enclosure of
//! each body's height over it has the right sign; intervals are halved until that is so. What is not proved is refused.

mod angle;
mod cell;
mod cover;
mod functional;
mod interval;
mod jet;
mod lines;
mod path;
mod plane;
mod slerp;

use cell::Cell;
use cover::Part;
use functional::Motion;
use interval::Interval;
use lines::{CellLine, EdgeLine, Kind, MotionLine, PairLine};
use path::Path;
use plane::Plane;
use serde::Deserialize;
use std::collections::BTreeMap;

/// How many intervals of t may be looked at for an edge, if the caller says nothing.
pub const BUDGET: usize = 10_000_000;

/// Replays the lines of a certificate.
pub struct Replay {
    cell: Option<Cell>,
    budget: usize,
}

/// What a line is worth.
#[derive(Clone, Debug, PartialEq)]
pub enum Replayed {
    /// It states a robot and its world, of which the lines behind it are.
    Cell {
        /// Its name.
        robot: String,
        /// How many bodies there are.
        bodies: usize,
        /// How many pairs of them must be proved apart.
        pairs: usize,
    },
    /// It states an edge that nobody calls free.
    NotFree {
        /// Its number.
        edge: usize,
        /// What it is called.
        answer: String,
    },
    /// All of an edge is proved free.
    Accepted {
        /// Its number.
        edge: usize,
        /// How many pairs were proved apart.
        pairs: usize,
        /// How many planes prove it.
        planes: usize,
        /// How many intervals of t were looked at.
        intervals: usize,
        /// How near to each other two bodies come at least, metres, proved too; 0 where the file states nothing.
        clearance: f64,
    },
    /// An edge is called free and not proved to be.
    Refused {
        /// Its number.
        edge: usize,
        /// What is missing.
        why: String,
    },
}

impl Default for Replay {
    fn default() -> Self {
        Self::with_budget(BUDGET)
    }
}

impl Replay {
    /// Looks at so many intervals of t an edge at most.
    pub fn with_budget(budget: usize) -> Self {
        Self { cell: None, budget }
    }

    /// Replays the next line of a file.
    ///
    /// # Errors
    /// A line that is no line of a certificate, or that contradicts itself.
    pub fn line(&mut self, line: &str) -> Result<Replayed, String> {
        let kind: Kind = read(line)?;
        if kind.certificate.is_some() {
            // The one before holds no longer, whatever this one is.
            self.cell = None;
            let line: CellLine = read(line)?;
            let robot = line.robot.clone();
            let cell = self.cell.insert(Cell::new(line)?);
            let (bodies, pairs) = (cell.bodies.len(), cell.required.len());
            return Ok(Replayed::Cell { robot, bodies, pairs });
        }
        let line: EdgeLine = read(line)?;
        let (edge, answer) = (line.edge, line.answer.clone());
        if answer != "free" {
            return Ok(Replayed::NotFree { edge, answer });
        }
        let cell = self.cell.as_ref().ok_or("an edge before any robot")?;
        Ok(match accepted(cell, line, self.budget) {
            Ok(accepted) => accepted,
            Err(why) => Replayed::Refused { edge, why },
        })
    }
}

/// A key that stands twice is refused.
fn read<'a, T: Deserialize<'a>>(line: &'a str) -> Result<T, String> {
    serde_json::from_str(line).map_err(|error| error.to_string())
}

/// The proof of an edge, or what is wrong with it.
fn accepted(cell: &Cell, line: EdgeLine, budget: usize) -> Result<Replayed, String> {
    let EdgeLine { edge, error, control, clearance, pairs, .. } = line;
    if let Some(error) = error {
        return Err(format!("no proof: {error}"));
    }
    let path = Path::new(control.ok_or("no control points")?, cell.values)?;
    let slerps = cell.joints.iter().map(|joint| match joint.motion {
        MotionLine::Orients { first } => path.slerp(first).map(Some),
        _ => Ok(None),
    });
    let slerps = slerps.collect::<Result<_, _>>()?;
    let motion = Motion { cell, path: &path, slerps };
    let clearance = clearance.unwrap_or(0.0);
    if !(clearance >= 0.0 && clearance.is_finite()) {
        return Err(format!("a clearance of {clearance}"));
    }
    let mut proved = BTreeMap::new();
    let (mut planes, mut left) = (0, budget);
    for pair in pairs.ok_or("no pairs")? {
        let [i, j] = pair.bodies;
        if i.max(j) >= cell.bodies.len() || i == j {
            return Err(format!("a pair of bodies {i} and {j}"));
        }
        if proved.insert([i.min(j), i.max(j)], ()).is_some() {
            return Err(format!("{} stand twice", named(cell, [i, j])));
        }
        planes += pair.planes.len();
        replay_pair(&motion, &pair, clearance, &mut left)
            .map_err(|why| format!("{}: {why}", named(cell, [i, j])))?;
    }
    match cell.required.iter().find(|pair| !proved.contains_key(*pair)) {
        Some(&pair) => Err(format!("{} are missing", named(cell, pair))),
        None => {
            let (pairs, intervals) = (proved.len(), budget - left);
            Ok(Replayed::Accepted { edge, pairs, planes, intervals, clearance })
        }
    }
}

fn named(cell: &Cell, pair: [usize; 2]) -> String {
    let [a, b] = pair.map(|k| &cell.bodies[k].name);
    format!("{a:?} and {b:?} (bodies {} and {})", pair[0], pair[1])
}

/// Proves a pair apart on all of the path.
fn replay_pair(
    motion: &Motion<'_>,
    line: &PairLine,
    clearance: f64,
    left: &mut usize,
) -> Result<(), String> {
    let bodies = line.bodies.map(|k| &motion.cell.bodies[k]);
    let frame = match &line.frame {
        None => None,
        Some(name) => {
            let link = motion.cell.links.get(name);
            Some(*link.ok_or_else(|| format!("there is no link {name:?}"))?)
        }
    };
    let whole = Part { t: [0.0, 1.0], pieces: bodies.map(|body| 0..body.pieces.len()) };
    let planes = line.planes.iter().map(|row| Plane::new(row, &whole));
    let planes: Vec<Plane> = planes.collect::<Result<_, _>>()?;
    let parts: Vec<&Part> = planes.iter().map(|plane| &plane.part).collect();
    if let Some(Part { t, pieces: [a, b] }) = whole.left_by(&parts) {
        return Err(format!("no plane for t from {} to {}, pieces {a:?} and {b:?}", t[0], t[1]));
    }
    // Half of it on either side.
    let apart = Interval::point(clearance).mul(Interval::point(0.5));
    let sides = plane::Sides::new(motion, bodies, frame, apart)?;
    planes.iter().try_for_each(|plane| sides.hold(plane, left))
}
