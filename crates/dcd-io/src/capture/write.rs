//! A capture as bytes.

use super::{Capture, SIGNATURE, VERSION, shape, slot};
use dcd_geom::{Filter, Motion, Pose, SceneError};
use std::io::{self, Write};

impl Capture {
    /// Writes the file: one that [`Capture::read`] gives back, bit for bit.
    ///
    /// # Errors
    /// Those of writing; more frames or ignored pairs than a u32 counts, as invalid input that holds
    /// a [`SceneError`].
    pub fn write(&self, out: &mut impl Write) -> io::Result<()> {
        let scene = &self.scene;
        let frames = u32::try_from(self.count).map_err(|_| too_many("frames", self.count))?;
        out.write_all(&SIGNATURE)?;
        // A scene has no more shapes and objects than a u32 counts, a shape no more vertices.
        words(out, &[VERSION, scene.shapes().len() as u32, scene.len() as u32, frames])?;
        scene.shapes().iter().try_for_each(|shape| shape::write(out, shape))?;
        for (i, &Filter { groups, mask }) in scene.filters().iter().enumerate() {
            let held = match scene.motion(i) {
                None => slot::FREE,
                Some(Motion::Static) => slot::STATIC,
                Some(Motion::Moving) => slot::MOVING,
            };
            let sensor = if scene.sensors()[i] { slot::SENSOR } else { 0 };
            words(out, &[scene.shape_of()[i], groups, mask, held + sensor])?;
        }
        let ignored = u32::try_from(scene.ignored_pairs().count());
        words(
            out,
            &[ignored.map_err(|_| too_many("ignored pairs", scene.ignored_pairs().count()))?],
        )?;
        scene.ignored_pairs().try_for_each(|pair| words(out, &[pair.i, pair.j]))?;
        for (frame, poses) in (0..frames).zip(self.frames()) {
            words(out, &[frame])?;
            poses.iter().try_for_each(|pose| write_pose(out, pose))?;
        }
        out.flush()
    }
}

fn too_many(what: &'static str, count: usize) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, SceneError::TooMany { what, count })
}

pub(super) fn write_pose(out: &mut impl Write, pose: &Pose) -> io::Result<()> {
    numbers(out, &pose.rotation().to_cols_array())?;
    numbers(out, &pose.translation().to_array())
}

pub(super) fn words(out: &mut impl Write, words: &[u32]) -> io::Result<()> {
    words.iter().try_for_each(|word| out.write_all(&word.to_le_bytes()))
}

pub(super) fn numbers(out: &mut impl Write, numbers: &[f64]) -> io::Result<()> {
    numbers.iter().try_for_each(|number| out.write_all(&number.to_le_bytes()))
}
