//! `dcd capture`: a moving scene, recorded frame by frame.

mod frames;
pub(crate) mod replay;

use crate::failure::Failure;
use crate::output::{Output, check_distinct};
use crate::precision::Precision;
use crate::progress::Progress;
use crate::{count, memory};
use clap::Args;
use dcd_geom::Pose;
use dcd_io::{Capture as Recording, data, shown};
use frames::Moving;
use replay::Replay;
use std::io::{Write, stdout};
use std::path::PathBuf;
use std::thread::available_parallelism;

/// Record a moving scene, to be replayed by `dcd detect --capture`
#[derive(Args)]
pub(crate) struct Capture {
    /// `pile`: hulls that fall on a slab; or a seeded scene of `dcd detect`, whose objects walk at
    /// random
    #[arg(long, value_name = "NAME")]
    scene: String,
    /// How many frames; all are held in memory, 104 bytes an object and frame
    #[arg(long, value_name = "K", default_value_t = 300, value_parser = count::frames)]
    frames: u32,
    /// How many objects [default: 1000 hulls; the scene's usual number]
    #[arg(long, value_name = "N", value_parser = count::objects)]
    n: Option<u32>,
    /// The seed
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// The standard deviation of a step of the walk, metres and rad [default: 0.01]
    #[arg(long, value_name = "SIGMA", allow_negative_numbers = true)]
    sigma: Option<f64>,
    /// The capture to write (format: docs/captures.md)
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Write the frames as binary glTF 2.0 too, an animation at 60 Hz, z up: objects that touch something
    /// (certified; undecided pairs count) in another colour
    #[arg(long, value_name = "FILE")]
    glb: Option<PathBuf>,
}

impl Capture {
    pub(crate) fn run(self) -> Result<(), Failure> {
        let inputs = data::file("hulls/convex_hulls.bin");
        let inputs: Vec<_> = inputs.as_deref().into_iter().collect();
        let outputs: Vec<_> = [Some(&self.out), self.glb.as_ref()].into_iter().flatten().collect();
        check_distinct(&inputs, &outputs.into_iter().map(PathBuf::as_path).collect::<Vec<_>>())?;
        let mut moving = Moving::new(&self)?;
        let objects = moving.scene().len();
        let what = format_args!("{} frames of {objects} objects", self.frames);
        let poses = f64::from(self.frames) * objects as f64;
        memory::demand("--frames", what, poses * size_of::<Pose>() as f64)?;
        // Before the work, so that a wrong path costs none.
        let mut file = Output::create(&self.out)?;
        let glb = self.glb.as_deref().map(Output::create).transpose()?;
        let progress = Progress::over(self.frames.into(), "frames");
        let refused = |error| Failure::at(&self.scene, error);
        let mut recording = Recording::new(moving.scene()).map_err(refused)?;
        for frame in 0..self.frames {
            if frame > 0 {
                moving.advance().map_err(|e| Failure::at(format_args!("frame {frame}"), e))?;
            }
            recording.frame(moving.scene()).map_err(refused)?;
            progress.step();
        }
        drop(progress);
        file.write(|mut to| recording.write(&mut to))?;
        if let Some(mut glb) = glb {
            let threads = available_parallelism().map_or(1, usize::from);
            let found = Replay { precision: Precision::Certified, threads }.frames(&recording)?;
            glb.write(|to| replay::draw(&recording, &found, to))?;
            glb.commit()?;
        }
        file.commit()?;
        writeln!(stdout(), "{} frames of {objects} objects in {}", self.frames, shown(&self.out))
            .map_err(Failure::Output)
    }
}
