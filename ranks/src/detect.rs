//! `dcd-mpi detect`: every touching pair of a scene.

use crate::memory;
use crate::output::Output;
use crate::source::{Loaded, Source};
use crate::summary::{self, Found, RankReport};
use clap::{Args, ValueEnum};
use dcd_exec::{Exec, Par};
use dcd_mpi::Mpi;
use dcd_pipeline::{Question, StageClock};
use dcd_ranks::{RankError, RankScene, RankStep, Traffic, Transport, digest, sort_contacts};
use rayon::ThreadPoolBuilder;
use serde::Serialize;
use std::fmt::Display;
use std::io::{Write, stdout};
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Find every touching pair of a scene
#[derive(Args)]
#[command(override_usage = "mpirun -n RANKS dcd-mpi detect [OPTIONS] <FILE|--scene NAME>")]
pub(crate) struct Detect {
    #[command(flatten)]
    source: Source,
    /// Which arithmetic decides the candidate pairs
    #[arg(long, value_enum, default_value_t)]
    precision: Precision,
    /// What is computed for each touching pair
    #[arg(long, value_enum, default_value_t)]
    query: Query,
    /// How good the bound of what is measured has to be; no effect with --query overlap
    #[arg(long, value_enum, default_value_t)]
    accuracy: Accuracy,
    /// Pairs within M metres of each other count as touching; with --query overlap, distance and gradient
    #[arg(long, value_name = "M", default_value_t = 0.0, allow_negative_numbers = true)]
    margin: f64,
    /// How many threads a rank, 1 … 1,024; 1 touches no pool
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: u16,
    /// How many times the step is run and timed, 1 … 1,000,000
    #[arg(long, value_name = "K", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    repeat: u32,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
    /// Write the contacts: u32 count, then u32 i, u32 j each, sorted, i < j, little endian; every rank must see the
    /// folder
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// Which arithmetic decides. Without error bounds contacts would depend on the number of ranks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Precision {
    /// What f64 can prove, else undecided
    F64,
    /// Every answer proved, down to exact integers
    #[default]
    Certified,
}

/// What is computed for each touching pair.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum Query {
    /// Nothing more
    #[default]
    Overlap,
    /// How far apart it is
    Distance,
    /// How deep it overlaps
    Depth,
    /// The points in which it touches
    Manifold,
    /// Its signed distance, and how that changes with both poses
    Gradient,
}

/// How good a bound has to be.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum Accuracy {
    /// Some millionths of the pair's size
    F32,
    /// What f64 gives
    F64,
    /// Nine digits of a depth and twelve of a distance, however small
    #[default]
    Certified,
}

/// Why a run ended early, on all ranks alike.
#[derive(Clone, Debug)]
pub(crate) struct Failure {
    pub(crate) code: u8,
    pub(crate) message: String,
}

impl Failure {
    /// Bad input.
    pub(crate) fn input(message: impl Display) -> Self {
        Self { code: 2, message: message.to_string() }
    }

    /// What was found could not be written.
    pub(crate) fn output(message: impl Display) -> Self {
        Self { code: 1, message: message.to_string() }
    }
}

/// What `result` is on this rank, if it is no failure on any: else that of the first rank that failed.
pub(crate) fn agree<T>(mpi: &Mpi, result: Result<T, Failure>) -> Result<T, Failure> {
    let own = result
        .as_ref()
        .err()
        .map_or(Vec::new(), |failure| [&[failure.code][..], failure.message.as_bytes()].concat());
    let all = mpi.all_gather(&own);
    match all.iter().find_map(|failure| failure.split_first()) {
        None => result,
        Some((&code, message)) => {
            Err(Failure { code, message: String::from_utf8_lossy(message).into_owned() })
        }
    }
}

impl Detect {
    /// Collective, as all that follows.
    pub(crate) fn run(self, mpi: &Mpi) -> Result<(), Failure> {
        let question = self.question()?;
        let out = self.out.as_deref().map(|path| Output::create(path, mpi)).transpose()?;
        let begun = Instant::now();
        let Loaded { share, objects } = self.source.load(mpi)?;
        let loaded = begun.elapsed();
        let begun = Instant::now();
        let mut scene = RankScene::new(mpi, share, question).map_err(Failure::input)?;
        scene.prepare_shapes();
        let spread = begun.elapsed();
        let threads = usize::from(self.threads);
        let par = agree(mpi, pool(threads))?;
        let (step, times, traffic) =
            steps(&mut scene, mpi, par, self.repeat).unwrap_or_else(|error| lost(mpi, &error));
        let RankStep { contacts, undecided, load, .. } = step;
        let (owned, ghosts) = (scene.owned_count(), scene.ghost_count());
        let begun = Instant::now();
        let sorted = sort_contacts(mpi, contacts);
        let sorting = begun.elapsed();
        let begun = Instant::now();
        let digest = digest(mpi, &sorted).map_err(Failure::input)?;
        let digesting = begun.elapsed();
        if let Some(out) = out {
            out.write(&sorted, mpi)?;
        }
        let report = RankReport {
            rank: mpi.rank(),
            objects: owned,
            ghosts,
            pairs: load.pairs,
            contacts: sorted.contacts.len(),
            undecided,
            sent_bytes: traffic.sent,
            received_bytes: traffic.received,
            times,
            load_time: loaded,
            spread_time: spread,
            sort_time: sorting,
            digest_time: digesting,
            peak_bytes: memory::peak_bytes(),
        };
        let found = Found {
            objects,
            contacts: sorted.total,
            threads,
            precision: self.precision,
            repeats: self.repeat,
            digest,
        };
        let text = summary::gathered(mpi, &report, &found, self.json);
        let printed = match text {
            Some(text) => stdout().write_all(text.as_bytes()).map_err(Failure::output),
            None => Ok(()),
        };
        agree(mpi, printed)
    }

    fn question(&self) -> Result<Question, Failure> {
        let margin = self.margin;
        if self.precision != Precision::Certified && self.query != Query::Overlap {
            return Err(Failure::input(
                "--precision: it is for --query overlap alone; --accuracy chooses how a measure is computed",
            ));
        }
        if matches!(self.query, Query::Depth | Query::Manifold) && margin != 0.0 {
            return Err(Failure::input(format!(
                "--margin {margin:e}: touching pairs alone have a depth: it must be 0"
            )));
        }
        let precision = match self.precision {
            Precision::F64 => dcd_pipeline::Precision::F64,
            Precision::Certified => dcd_pipeline::Precision::Certified,
        };
        let accuracy = match self.accuracy {
            Accuracy::F32 => dcd_gjk::Accuracy::F32,
            Accuracy::F64 => dcd_gjk::Accuracy::F64,
            Accuracy::Certified => dcd_gjk::Accuracy::Certified,
        };
        Ok(match self.query {
            Query::Overlap => Question::Overlap { precision, margin },
            Query::Distance => Question::Distance { accuracy, margin },
            Query::Depth => Question::Depth { accuracy },
            Query::Manifold => Question::Manifold { accuracy, options: Default::default() },
            Query::Gradient => Question::Gradient { accuracy, margin },
        })
    }
}

/// Makes the pool. The calling thread is one of its threads: it alone speaks to MPI.
fn pool(threads: usize) -> Result<Par, Failure> {
    if threads == 1 {
        return Ok(Par::Serial);
    }
    let pool = ThreadPoolBuilder::new().num_threads(threads).use_current_thread().build_global();
    pool.map(|()| Par::WarmPool).map_err(|error| Failure::input(format!("--threads: {error}")))
}

/// For each step the exchange, the stages in their order, and last the whole.
pub(crate) type Times = [Duration; 6];

/// The other ranks do not know of it, and wait for this one: all end.
fn lost(mpi: &Mpi, error: &RankError) -> ! {
    eprintln!("dcd-mpi: rank {}: {error}", mpi.rank());
    mpi.abort(2)
}

type Stepped = Result<(RankStep, Vec<Times>, Traffic), RankError>;

/// The steps; the traffic is that of the last. All ranks begin each together.
fn steps(scene: &mut RankScene<'_, Mpi>, mpi: &Mpi, par: Par, repeats: u32) -> Stepped {
    let clock = StageClock::default();
    let (mut times, mut last) = (Vec::new(), RankStep::default());
    let mut traffic = Traffic::default();
    for _ in 0..repeats {
        mpi.sum(&mut [0]);
        let (before, begun) = (mpi.traffic(), Instant::now());
        scene.refresh(par)?;
        let exchanged = begun.elapsed();
        let after = mpi.traffic();
        traffic =
            Traffic { sent: after.sent - before.sent, received: after.received - before.received };
        last = scene.detect(Exec::observed(par, &clock))?;
        let whole = begun.elapsed();
        let [boxes, build, pairs, narrow] = clock.take();
        times.push([exchanged, boxes, build, pairs, narrow, whole]);
    }
    Ok((last, times, traffic))
}
