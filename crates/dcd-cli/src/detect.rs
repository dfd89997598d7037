//! `dcd detect`: every touching pair of a scene.

mod contacts;
mod crowd;
mod picture;
mod question;
mod source;
mod steps;
mod summary;

use crate::capture::replay::Replay;
use crate::count;
use crate::failure::Failure;
use crate::memory;
use crate::output::{Output, check_distinct};
use crate::precision::Precision;
use clap::Args;
pub(crate) use contacts::{digest, fnv1a};
use question::{Answers, QueryOptions};
use source::{Loaded, Source};
use std::io::{Write, stdout};
use std::path::PathBuf;
use std::thread::available_parallelism;
use steps::Plan;
use summary::Summary;

const DETAILS: &str = "\
FILE is a hull scene, raw, little endian: u32 n; then n times u32 vertex count, u32 triangle \
count, the vertices (3 f64 each, metres), the triangles (3 u32 each; they may be absent), a unit \
quaternion x y z w (4 f64), a translation (3 f64).

Reading and the making of shapes are not timed. Each repeat is a first step: buffers are kept, \
nothing that was learnt about the poses is. The broad phase is the wide tree at every precision.

The digest is 64-bit FNV-1a over the contacts as --out writes them, without the count: u32 i, \
u32 j, little endian, i < j, sorted. It is the same at any number of threads. The digests of \
--capture are over the contacts in the order that the step gives them.

--answers writes {\"i\": …, \"j\": …, …} for each contact, i being a and j b, in metres and the \
world frame:
  overlap    nothing more
  distance   distance, 0 for a pair that touches; else also normal, point_a, point_b
  depth      depth, normal, point_a, point_b
  manifold   manifolds: each with normal, depth, error_bound and points: each of these with depth, \
point_a, point_b, feature_a, feature_b; of compounds and meshes also the deepest part_a, part_b, \
triangle_a, triangle_b
  gradient   distance, below 0 for an overlap; normal, point_a, point_b; gradient_a and gradient_b, \
each for a translation and for a rotation about the object's own origin; smoothness: smooth, many \
points, many directions (no derivative, one of several reported) or unknown
The normal is of unit length and points from a to b. error_bound: the truth is within it; --json has \
the median, the 99th percentile and the worst of all, metres.

Limits: 4,294,967,295 objects, vertices a shape and contacts in --out; coordinates within 1e37 m; \
an eighth of the available memory for FILE, --clouds and --capture (also from a pipe); what memory \
cannot hold (objects, pairs, frames) is refused with an estimate before allocation.";

/// Find every touching pair of a scene
#[derive(Args)]
#[command(
    after_long_help = DETAILS,
    override_usage = "dcd detect [OPTIONS] <FILE|--scene NAME|--clouds FILE|--capture FILE>"
)]
pub(crate) struct Detect {
    #[command(flatten)]
    source: Source,
    #[command(flatten)]
    question: QueryOptions,
    /// How candidate pairs are decided
    #[arg(long, value_enum, default_value_t)]
    precision: Precision,
    /// How many threads, 1 … 1,024; 1 touches no pool [default: one a core]
    #[arg(long, value_name = "N", value_parser = count::threads)]
    threads: Option<u16>,
    /// How many times the step is run and timed, 1 … 1,000,000
    #[arg(
        long,
        value_name = "K",
        default_value_t = 1,
        conflicts_with = "capture",
        value_parser = count::repeats
    )]
    repeat: u32,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
    /// Write the contacts: u32 count, then u32 i, u32 j each, sorted, i < j, little endian
    #[arg(long, value_name = "FILE", conflicts_with = "capture")]
    out: Option<PathBuf>,
    /// Write the scene as binary glTF 2.0, z up: objects of contacts and of undecided pairs in
    /// another colour, the points of --query depth and manifold with their normals, the frames of
    /// --capture as an animation at 60 Hz
    #[arg(long, value_name = "FILE")]
    glb: Option<PathBuf>,
}

impl Detect {
    pub(crate) fn run(self) -> Result<(), Failure> {
        let cores = || available_parallelism().map_or(1, usize::from);
        let threads = self.threads.map_or_else(cores, usize::from);
        if let Some(path) = &self.source.capture {
            check_distinct(&[path], &self.glb.iter().map(PathBuf::as_path).collect::<Vec<_>>())?;
            let replay = Replay { precision: self.precision, threads };
            let replayed = replay.run(path, self.glb.as_deref())?;
            let text = if self.json { replayed.json() } else { replayed.text() };
            return stdout().write_all(text.as_bytes()).map_err(Failure::Output);
        }
        let mut query = self.question.query(self.precision)?;
        if self.glb.is_some() {
            query.answers = Answers::Kept;
        }
        let outputs = [self.out.as_deref(), self.question.answers.as_deref(), self.glb.as_deref()];
        let named: Vec<_> = outputs.into_iter().flatten().collect();
        let inputs = self.source.inputs();
        check_distinct(&inputs.iter().map(PathBuf::as_path).collect::<Vec<_>>(), &named)?;
        let Loaded { scene, clouds } = self.source.load(threads)?;
        crowd::check(&scene)?;
        // Before the work, so that a wrong path costs none.
        let [out, answers, glb] = outputs.map(|path| path.map(Output::create).transpose());
        let (mut out, mut answers, mut glb) = (out?, answers?, glb?);
        let plan = Plan { precision: self.precision, query, threads, repeats: self.repeat };
        let found = steps::run(&scene, plan)?;
        if let Some(file) = &mut answers {
            file.write(|to| contacts::write_reported(&found.reported, to))?;
        }
        if let Some(file) = &mut out {
            file.write(|to| contacts::write(&found.contacts, to))?;
        }
        if let Some(file) = &mut glb {
            file.write(|to| picture::write(&scene, &found, to))?;
        }
        // When all are whole.
        [answers, out, glb].into_iter().flatten().try_for_each(Output::commit)?;
        let summary = Summary {
            objects: scene.len(),
            clouds,
            plan,
            found: &found,
            peak_bytes: memory::peak_bytes(),
        };
        let text = if self.json { summary.json() } else { summary.text() };
        stdout().write_all(text.as_bytes()).map_err(Failure::Output)
    }
}
