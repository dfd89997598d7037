//! Each rank's share of the objects: a range of a seeded scene, or of the records of a file.

use crate::detect::{Failure, agree};
use crate::memory;
use clap::Args;
use clap::builder::PossibleValuesParser;
use dcd_io::{HullRecords, load_hull_records, run};
use dcd_mpi::Mpi;
use dcd_ranks::{Share, Transport};
use dcd_scenes::{RawShare, SceneSpec};
use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

#[derive(Args)]
pub(crate) struct Source {
    /// A hull scene, as `dcd detect` reads it; every rank must see it
    #[arg(required_unless_present = "scene", conflicts_with_all = ["scene", "n", "seed"])]
    file: Option<PathBuf>,
    /// A seeded scene in place of a file
    #[arg(long, value_name = "NAME", value_parser = names())]
    scene: Option<String>,
    /// How many objects [default: the scene's usual number]
    #[arg(long, value_name = "N")]
    n: Option<u32>,
    /// The seed [default: 1]
    #[arg(long, value_name = "S")]
    seed: Option<u64>,
}

/// What a rank brings along, and how many objects there are on all.
pub(crate) struct Loaded {
    pub(crate) share: Share,
    pub(crate) objects: u64,
}

/// Bytes of memory for one of a file: its numbers, what is on its way, the shapes and what a step keeps of
/// them.
const BYTES_A_BYTE: f64 = 6.0;

impl Source {
    /// Collective; an error of one rank is one of all.
    pub(crate) fn load(&self, mpi: &Mpi) -> Result<Loaded, Failure> {
        match (&self.scene, &self.file) {
            (Some(name), _) => self.seeded(name, mpi),
            (None, Some(path)) => read(path, mpi),
            // clap has seen to it that there is one.
            (None, None) => Err(Failure::input("no file")),
        }
    }

    fn seeded(&self, name: &str, mpi: &Mpi) -> Result<Loaded, Failure> {
        let spec =
            SceneSpec::parse(name).map_err(|error| Failure::input(format!("--scene: {error}")));
        let mut spec = agree(mpi, spec)?;
        spec.objects = self.n.map_or(spec.objects, |n| n as usize);
        spec.seed = self.seed.unwrap_or(spec.seed);
        demand(mpi, &format!("--n: {} objects of {name:?}", spec.objects), spec.least_bytes())?;
        let range = part(spec.objects, mpi);
        let raw = spec.share_by(range, &run::in_order);
        let raw = agree(mpi, raw.map_err(|error| Failure::input(format!("{name}: {error}"))))?;
        made(raw, name, spec.objects as u64, mpi)
    }
}

/// The range of a rank, of so many.
fn part(objects: usize, mpi: &Mpi) -> Range<usize> {
    let (rank, size) = (mpi.rank(), mpi.size());
    objects * rank / size..objects * (rank + 1) / size
}

/// Rank 0 finds where the records stand, and each reads its own.
fn read(path: &Path, mpi: &Mpi) -> Result<Loaded, Failure> {
    let shown = dcd_io::shown(path);
    let length = fs::metadata(path).map_err(|error| Failure::input(format!("{shown}: {error}")));
    let length = agree(mpi, length.map(|data| data.len()))?;
    demand(mpi, &format!("{shown}: its objects"), BYTES_A_BYTE * length as f64)?;
    let found = if mpi.rank() == 0 { HullRecords::find(path, mpi.size()) } else { Ok(Vec::new()) };
    let found = agree(mpi, found.map_err(|error| Failure::input(error.to_string())))?;
    let numbers = found.iter().flat_map(|records| {
        let HullRecords { objects, bytes } = records;
        [objects.start.into(), objects.end.into(), bytes.start, bytes.end]
    });
    let own: Vec<u8> = numbers.flat_map(u64::to_le_bytes).collect();
    let given = mpi.all_gather(&own).swap_remove(0);
    let (numbers, _) = given.as_chunks();
    let numbers: Vec<u64> = numbers.iter().map(|number| u64::from_le_bytes(*number)).collect();
    let (parts, _) = numbers.as_chunks();
    let all: Vec<HullRecords> = parts
        .iter()
        .map(|&[first, end, start, stop]| HullRecords {
            objects: first as u32..end as u32,
            bytes: start..stop,
        })
        .collect();
    let raw = load_hull_records(path, &all[mpi.rank()]);
    let raw = agree(mpi, raw.map_err(|error| Failure::input(error.to_string())))?;
    made(raw, &shown, all.last().map_or(0, |last| last.objects.end.into()), mpi)
}

/// The checked share.
fn made(raw: RawShare, place: &str, objects: u64, mpi: &Mpi) -> Result<Loaded, Failure> {
    let (first, names) = (raw.first as u64, raw.shape_names.clone());
    let scene = raw.into_scene_by(&run::in_order);
    let scene = agree(mpi, scene.map_err(|error| Failure::input(format!("{place}: {error}"))))?;
    let share = Share::of_scene(&scene, first, |shape| names[shape]);
    let share = agree(mpi, share.map_err(|error| Failure::input(format!("{place}: {error}"))))?;
    Ok(Loaded { share, objects })
}

/// Refuses what needs more memory than this machine has for its ranks.
fn demand(mpi: &Mpi, what: &str, all_bytes: f64) -> Result<(), Failure> {
    let neighbours = mpi.neighbours() as f64;
    let bytes = all_bytes * neighbours / mpi.size() as f64;
    let available = memory::available_bytes().map_or(f64::INFINITY, |bytes| bytes as f64);
    let checked = if bytes <= available {
        Ok(())
    } else {
        Err(Failure::input(format!(
            "{what} take about {bytes:.1e} bytes of memory for {neighbours} ranks on a machine, but \
             {available:.1e} are available"
        )))
    };
    agree(mpi, checked)
}

fn names() -> PossibleValuesParser {
    SceneSpec::all().iter().map(SceneSpec::name).collect::<Vec<_>>().into()
}
