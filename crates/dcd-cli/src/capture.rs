//! `dcd capture`: a scene that moves, recorded frame by frame.

mod frames;
pub(crate) mod replay;

use crate::failure::Failure;
use clap::{Args, value_parser};
use dcd_scenes::Capture as Recording;
use frames::Moving;
use std::fs::File;
use std::io::{BufWriter, Write, stdout};
use std::path::PathBuf;

/// Record a scene that moves, to be replayed by `dcd detect --capture`
#[derive(Args)]
pub(crate) struct Capture {
    /// `pile`: hulls that fall on a slab; or a seeded scene of `dcd detect`, whose objects walk at
    /// random
    #[arg(long, value_name = "NAME")]
    scene: String,
    /// How many frames
    #[arg(long, value_name = "K", default_value_t = 300, value_parser = value_parser!(u32).range(1..))]
    frames: u32,
    /// How many objects [default: 1000 hulls; the scene's usual number]
    #[arg(long, value_name = "N")]
    n: Option<u32>,
    /// The seed
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// The standard deviation of a step of the walk, metres and rad [default: 0.01]
    #[arg(long, value_name = "SIGMA", allow_negative_numbers = true)]
    sigma: Option<f64>,
    /// Where the capture is written (format: docs/captures.md)
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
}

impl Capture {
    pub(crate) fn run(self) -> Result<(), Failure> {
        let mut moving = Moving::new(&self)?;
        // Before the work, so that a wrong path costs none.
        let file = File::create(&self.out).map_err(|e| Failure::at(self.out.display(), e))?;
        let refused = |error| Failure::at(&self.scene, error);
        let mut recording = Recording::new(moving.scene()).map_err(refused)?;
        for frame in 0..self.frames {
            if frame > 0 {
                moving.advance().map_err(|e| Failure::at(format_args!("frame {frame}"), e))?;
            }
            recording.frame(moving.scene()).map_err(refused)?;
        }
        recording.write(&mut BufWriter::new(file)).map_err(Failure::Output)?;
        let objects = moving.scene().len();
        writeln!(stdout(), "{} frames of {objects} objects in {}", self.frames, self.out.display())
            .map_err(Failure::Output)
    }
}
