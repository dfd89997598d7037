//! Proofs that an edge is free, for whoever wants to check them by other means: separating planes for each pair of bodies on
//! intervals of t. The format is described in docs/guide/certificates.md; `dcd-judge` replays it.
//!
//! A plane is fixed in the world, or in the link that carries both bodies, but for an offset that goes evenly from one value to
//! another over the interval. Shapes that are not convex are proved apart piece by piece.

mod lines;
mod pieces;
#[cfg(test)]
mod tests;

pub(super) use pieces::Pieces;

use super::path::JointPath;
use super::search::EdgeSearch;
use super::{Before, EdgeChecker};
use crate::RobotError;
use glam::DVec3;
use std::ops::Range;
use std::sync::Arc;

/// Of the clearance of an edge the part that its certificate states.
const STATED: f64 = 0.5;

/// Of the stated clearance the part by which a body is beyond what is stated, on its side of a plane. Smaller: whoever replays a
/// certificate needs shorter intervals than it has. Larger: shorter ones here, and above 1 none is found where the clearance is
/// all there is.
const BEYOND: f64 = 0.2;

/// Separating planes that prove an edge free.
#[derive(Clone, Debug, PartialEq)]
pub struct EdgeCertificate {
    /// The path's control points.
    pub path: JointPath,
    /// No configuration comes nearer to anything than that, metres: half of that is between a body and each of its planes. Half of
    /// what [`EdgeAnswer::Free`](super::EdgeAnswer::Free) has; infinite where nothing could be met.
    pub clearance: f64,
    /// All pairs that may not touch.
    pub pairs: Vec<CertifiedPair>,
}

/// Two bodies that are apart on all of a path.
#[derive(Clone, Debug, PartialEq)]
pub struct CertifiedPair {
    /// The objects of the scene.
    pub objects: [u32; 2],
    /// The name of the link in whose frame the planes are; the world's where there is none.
    pub frame: Option<String>,
    /// For all t from 0 to 1 and all pieces, in the order of t.
    pub planes: Vec<SeparatingPlane>,
}

/// The plane n·x = d: the first body is where n·x < d, the second where n·x > d.
#[derive(Clone, Debug, PartialEq)]
pub struct SeparatingPlane {
    /// The interval of t in which it separates.
    pub t: [f64; 2],
    /// n, of length 1 but for rounding.
    pub normal: DVec3,
    /// d at either end of the interval, metres; between them it changes evenly.
    pub offset: [f64; 2],
    /// Which pieces of the first body and of the second; all where there is none.
    pub pieces: Option<[Range<u32>; 2]>,
}

impl EdgeChecker {
    /// Separating planes for an edge that [`check`](Self::check) calls free with this clearance, from at most `budget` intervals.
    /// Slower than the check: each pair needs planes of its own, whatever spheres prove.
    ///
    /// # Errors
    /// A path that [`check`](Self::check) refuses; a shape known by its support map alone, or a half-space; no plane found within the
    /// budget, or at all, with the pair.
    pub fn certificate(
        &self,
        path: &JointPath,
        clearance: f64,
        budget: usize,
    ) -> Result<EdgeCertificate, RobotError> {
        path.check(self.robot())?;
        let stated = STATED * clearance;
        let pieces = self.pieces()?;
        // Either body is half of the clearance from the plane.
        let needed = if stated.is_finite() { 0.5 * stated * (1.0 + BEYOND) } else { 0.0 };
        let search = EdgeSearch::new(self, path, (budget, Before::Hit));
        let pairs = search.planes(&pieces, needed)?;
        Ok(EdgeCertificate { path: path.clone(), clearance: stated, pairs })
    }

    /// The line of a certificate that states the robot, its world and the pairs that may touch: JSON, without a line's end. The lines
    /// of its edges follow it: [`EdgeCertificate::line`].
    ///
    /// # Errors
    /// A shape that has no certificates: see [`certificate`](Self::certificate).
    pub fn certificate_cell(&self) -> Result<String, RobotError> {
        lines::cell(self, &self.pieces()?)
    }

    /// The convex pieces of each object, made when they are first needed.
    fn pieces(&self) -> Result<Arc<[Pieces]>, RobotError> {
        let scene = self.cell.scene();
        let made = self.pieces.get_or_init(|| {
            (0..scene.len()).map(|i| Pieces::of(scene.shape(i)).ok_or(i)).collect()
        });
        made.clone().map_err(|i| RobotError::Refused {
            user: format!("body {:?}", self.cell.names()[i]),
            why: "no certificate is written of its shape: it is no polytope, cylinder, cone, mesh or \
                  compound of those"
                .to_owned(),
        })
    }
}

impl EdgeCertificate {
    /// The line of a certificate for an edge of this number: JSON, without a line's end. It holds for the robot of the last
    /// [`EdgeChecker::certificate_cell`] before it, which must be that of the same checker.
    pub fn line(&self, edge: usize) -> String {
        lines::edge(self, edge)
    }
}
