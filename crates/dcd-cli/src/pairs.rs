//! `dcd pairs`: a line of JSON for each pair of a file.

mod answer;
mod ours;
mod parry;

use crate::failure::{Failure, print_message};
use crate::precision::{Accuracy, Library, Precision};
use crate::progress::Progress;
use answer::Answer;
use clap::{Args, ValueEnum};
use dcd_geom::{Polytope, Pose, Shape};
use dcd_gjk::PosedShape;
use dcd_io::{PairError, PairFault, PairInput, read_pairs, shown};
use ours::Solvers;
use serde::Serialize;
use std::fs::File;
use std::io::{self, BufRead, BufReader, IsTerminal, Write, stdin, stdout};
use std::path::PathBuf;

const DETAILS: &str = r#"FILE holds a pair a line:
  {"name": "…", "a": [[x, y, z], …], "pose_a": {"R": [[…3], …3 rows], "t": [x, y, z]}, "b": …, "pose_b": …}
Points in metres in the shape's own frame; R row by row, or a unit quaternion q = [x, y, z, w] in its place. Other keys are refused, but for "name" and those that begin with an underscore; so is JSON nested deeper than 127 but under a name that begins so. A line of more than 268,435,456 bytes ends the run. The file may begin with a byte order mark.

A line comes out for each, in order:
  {"name": "…", "answer": "apart"|"touching"|"undecided", "method": "…", …}
  method       what decided it: f32, f64, exact, parry-f32, parry-f64
  reason       why the pair is undecided, or its distance without a bound: "out of range" where it is
               more than an f64 holds, and the number given is one that it surely exceeds
  distance     metres; 0 for a touching pair
  depth        metres; for touching pairs alone, 0 for one that just touches
  normal       of unit length, from a to b, world frame
  point_a, point_b   between which the distance or depth is, world frame
  points       of --query manifold, the deepest first: each with depth, point_a, point_b, feature_a,
               feature_b (vertices by index); normal and error_bound are those of all
  error_bound  the truth is within it, metres; absent on parry-f32 and parry-f64, which give none
A line that is no such pair comes out as {"name": …, "error": "line …"}, on standard error too, and the run goes on; the exit code is 2 then.

--precision fast and f64 are for --query boolean alone. Of a depth or manifold, method names what proved that the pair touches. Parry's precisions print what query::intersection_test, distance, closest_points and contact say, right or wrong."#;

/// Decide pairs of posed point sets, one a line
#[derive(Args)]
#[command(after_long_help = DETAILS)]
pub(crate) struct Pairs {
    /// Pairs as JSON Lines (format: see --help); `-` is standard input
    file: PathBuf,
    /// How pairs are decided
    #[arg(long, value_enum, default_value_t)]
    precision: Precision,
    /// What to compute for each pair
    #[arg(long, value_enum, default_value_t)]
    query: Query,
    /// How tight the error bound of a distance or depth must be, on our precisions: looser is faster, and
    /// still proved; ignored with --query boolean
    #[arg(long, value_enum, default_value_t)]
    accuracy: Accuracy,
    /// Query (b, a): the same answer mirrored, bit for bit, but on Parry's precisions
    #[arg(long)]
    swap: bool,
}

/// What is computed for each pair.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum Query {
    /// Whether it touches
    #[default]
    #[value(alias = "overlap")]
    Boolean,
    /// How far apart it is, and between which points
    Distance,
    /// How deep it overlaps, and where
    Depth,
    /// The points in which it touches, up to four
    Manifold,
}

/// One of the two.
struct Side {
    shape: Shape,
    pose: Pose,
}

impl Side {
    fn new(shape: Polytope, pose: Pose) -> Self {
        Self { shape: shape.into(), pose }
    }

    fn placed(&self) -> PosedShape<'_> {
        PosedShape { shape: &self.shape, pose: &self.pose }
    }
}

#[derive(Serialize)]
#[serde(untagged)]
enum Outcome {
    Answered(Answer),
    Refused { error: String },
}

#[derive(Serialize)]
struct Line<'a> {
    name: Option<&'a str>,
    #[serde(flatten)]
    outcome: Outcome,
}

impl Pairs {
    pub(crate) fn run(self) -> Result<(), Failure> {
        self.check_precision()?;
        let (place, reader) = self.open()?;
        let mut out = stdout().lock();
        // Lines on a terminal are progress enough.
        let progress = (!out.is_terminal()).then(|| Progress::over(0, "pairs"));
        let mut solvers = Solvers::default();
        let (mut lines, mut refused) = (0u64, 0u64);
        for item in read_pairs(reader) {
            lines += 1;
            let read =
                item.map_err(|error| Failure::at(&place, format_args!("line {lines}: {error}")))?;
            let (name, outcome) = match read {
                Ok(pair) => {
                    let (name, answer) = self.answer(pair, &mut solvers);
                    (name, Outcome::Answered(answer))
                }
                Err(error) => {
                    refused += 1;
                    let message = format!("line {lines}: {}", without_line(&error));
                    print_message(format_args!("{place}: {message}"));
                    (error.name, Outcome::Refused { error: message })
                }
            };
            write_line(&mut out, &Line { name: name.as_deref(), outcome })
                .map_err(Failure::Output)?;
            progress.iter().for_each(Progress::step);
        }
        drop(progress);
        if refused > 0 {
            return Err(Failure::at(place, format_args!("{refused} of {lines} lines refused")));
        }
        Ok(())
    }

    /// Refuses a precision that does not answer the query.
    fn check_precision(&self) -> Result<(), Failure> {
        let is_ours = matches!(self.precision.library(), Library::Ours(_));
        let why = if self.query == Query::Manifold && !is_ours {
            "answers no --query manifold"
        } else if self.query != Query::Boolean && is_ours && self.precision != Precision::Certified
        {
            "it is for --query boolean alone; --accuracy chooses how a measure is computed"
        } else {
            return Ok(());
        };
        Err(Failure::at(format_args!("--precision {}", self.precision.name()), why))
    }

    fn open(&self) -> Result<(String, Box<dyn BufRead>), Failure> {
        if self.file.as_os_str() == "-" {
            return Ok(("standard input".into(), Box::new(stdin().lock())));
        }
        let place = shown(&self.file);
        match File::open(&self.file) {
            Ok(file) => Ok((place, Box::new(BufReader::new(file)))),
            Err(error) => Err(Failure::at(place, error)),
        }
    }

    fn answer(&self, pair: PairInput, solvers: &mut Solvers) -> (Option<String>, Answer) {
        let a = Side::new(pair.a, pair.pose_a);
        let b = Side::new(pair.b, pair.pose_b);
        let (a, b) = if self.swap { (b, a) } else { (a, b) };
        let answer = match self.precision.library() {
            Library::ParryF32 => parry::answer::<f32>(self.query, "parry-f32", &a, &b),
            Library::ParryF64 => parry::answer::<f64>(self.query, "parry-f64", &a, &b),
            Library::Ours(precision) => {
                let answer =
                    solvers.answer((precision, self.query, self.accuracy), a.placed(), b.placed());
                // Of two identical bodies (b, a) is (a, b) to the solver.
                if self.swap && are_identical(&a, &b) { answer.mirrored() } else { answer }
            }
        };
        (pair.name, answer)
    }
}

fn are_identical(a: &Side, b: &Side) -> bool {
    let bits = |side: &Side| -> Vec<u64> {
        let vertices = side.shape.as_polytope().map_or(&[][..], Polytope::vertices);
        let rotation = side.pose.rotation().to_cols_array();
        let translation = side.pose.translation().to_array();
        let numbers = rotation.into_iter().chain(translation);
        numbers.chain(vertices.iter().flat_map(|v| v.to_array())).map(f64::to_bits).collect()
    };
    bits(a) == bits(b)
}

fn write_line(out: &mut impl Write, line: &Line<'_>) -> io::Result<()> {
    serde_json::to_writer(&mut *out, line)?;
    out.write_all(b"\n")
}

/// The fault, without the JSON reader's count of lines, which sees one line at a time.
fn without_line(error: &PairError) -> String {
    let fault = error.fault.to_string();
    let PairFault::Json(json) = &error.fault else { return fault };
    let place = format!(" at line {} column {}", json.line(), json.column());
    match fault.strip_suffix(&place) {
        Some(what) if json.line() == 1 => format!("{what} at column {}", json.column()),
        // Behind the line's end.
        Some(what) => what.to_owned(),
        None => fault,
    }
}
