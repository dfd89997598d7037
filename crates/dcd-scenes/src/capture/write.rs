//! A capture as bytes.

use super::{Capture, SIGNATURE, VERSION, tag};
use dcd_geom::{Filter, Kind, Polytope, Pose, SceneError};
use std::io::{self, Write};

impl Capture {
    /// Writes the file: one that [`Capture::read`] gives back, bit for bit.
    ///
    /// # Errors
    /// Those of writing; more frames than a u32 counts, as invalid input that holds a
    /// [`SceneError`].
    pub fn write(&self, out: &mut impl Write) -> io::Result<()> {
        let scene = &self.scene;
        let frames = u32::try_from(self.count).map_err(|_| {
            let refused = SceneError::TooMany { what: "frames", count: self.count };
            io::Error::new(io::ErrorKind::InvalidInput, refused)
        })?;
        out.write_all(&SIGNATURE)?;
        // A scene has no more shapes and objects than a u32 counts, a shape no more vertices.
        words(out, &[VERSION, scene.shapes().len() as u32, scene.len() as u32, frames])?;
        for polytope in scene.shapes().iter().filter_map(|shape| shape.as_polytope()) {
            write_shape(out, polytope)?;
        }
        for (&shape, &Filter { groups, mask }) in scene.shape_of().iter().zip(scene.filters()) {
            words(out, &[shape, groups, mask])?;
        }
        for (frame, poses) in (0..frames).zip(self.frames()) {
            words(out, &[frame])?;
            poses.iter().try_for_each(|pose| write_pose(out, pose))?;
        }
        out.flush()
    }
}

fn write_shape(out: &mut impl Write, polytope: &Polytope) -> io::Result<()> {
    let radius = polytope.swept_radius();
    match polytope.kind() {
        Kind::Cuboid { half_extents } => {
            words(out, &[tag::CUBOID])?;
            numbers(out, &[radius])?;
            numbers(out, &half_extents.to_array())
        }
        Kind::Point => {
            words(out, &[tag::SPHERE])?;
            numbers(out, &[radius])
        }
        _ => {
            words(out, &[tag::HULL])?;
            numbers(out, &[radius])?;
            words(out, &[polytope.vertices().len() as u32])?;
            polytope.vertices().iter().try_for_each(|vertex| numbers(out, &vertex.to_array()))
        }
    }
}

fn write_pose(out: &mut impl Write, pose: &Pose) -> io::Result<()> {
    numbers(out, &pose.rotation().to_cols_array())?;
    numbers(out, &pose.translation().to_array())
}

fn words(out: &mut impl Write, words: &[u32]) -> io::Result<()> {
    words.iter().try_for_each(|word| out.write_all(&word.to_le_bytes()))
}

fn numbers(out: &mut impl Write, numbers: &[f64]) -> io::Result<()> {
    numbers.iter().try_for_each(|number| out.write_all(&number.to_le_bytes()))
}
