//! The expansion: from an inner polytope to the nearest facet of the difference.

use super::hull::Hull;
use super::lattice::{LatticeDifference, Normal, Support, Vertex, length};
use super::wide::Wide;

/// How often the polytope may grow. Each growth adds a vertex of a finite set, so the search ends
/// by itself; this bounds the time (about 50 ms) where the facets are many and all alike, as for
/// two finely cut concentric balls. Smaller: larger error bounds there.
const GROWTHS: usize = 1 << 14;

/// The relative gap between the bounds at which the search stops. Well below what is promised of
/// a depth, 1e-9. Smaller: more growth on finely cut shapes, for digits that nobody asked for.
const GAP: f64 = 1.0 / (1u64 << 42) as f64;

/// The difference and what its supports prove.
pub(super) struct Viewer<'a> {
    pub(super) difference: LatticeDifference<'a>,
}

/// A direction in which every point of the difference has a negative product.
#[derive(Clone, Copy, Debug)]
pub(super) struct Separated {
    pub(super) normal: Normal,
}

/// What the expansion ends with; units of the lattice.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    /// The least distance of a plane of the inner polytope, negative where the origin is outside.
    pub(super) lower: f64,
    /// The difference's reach along `normal`: the depth of that direction.
    pub(super) upper: f64,
    pub(super) normal: Normal,
    /// Whether the origin is surely in the true difference.
    pub(super) enclosed: bool,
}

impl<'a> Viewer<'a> {
    /// The support along `normal`, unless that separates.
    pub(super) fn view(&mut self, normal: &Normal) -> Result<Support, Separated> {
        let support = self.difference.support(normal);
        if support.reach < Wide::ZERO
            && support.reach.to_f64() < -self.difference.slack() * length(normal)
        {
            return Err(Separated { normal: *normal });
        }
        Ok(support)
    }

    /// Grows the hull of `corners` until its nearest face is one of the difference.
    pub(super) fn expand(
        &mut self,
        corners: [Vertex; 4],
        hull: &mut Hull,
    ) -> Result<Bounds, Separated> {
        hull.start(corners);
        let mut best: Option<(f64, Normal)> = None;
        let mut growths = 0;
        loop {
            let nearest = hull.nearest();
            let face = hull.face(nearest);
            let lower = face.distance();
            let (normal, offset) = (face.normal, face.offset);
            let ended = |upper: f64, slack: f64| upper - lower <= GAP * upper.max(0.0) + slack;
            let known = best.is_some_and(|(upper, _)| ended(upper, self.difference.slack()));
            if !known && growths < GROWTHS {
                let support = self.view(&normal)?;
                let upper = support.reach.to_f64() / length(&normal);
                if best.is_none_or(|(least, _)| upper < least) {
                    best = Some((upper, normal));
                }
                // Otherwise the vertex lies strictly beyond the face, for equal products have
                // equal quotients.
                if !ended(upper, self.difference.slack()) {
                    hull.insert(support.vertex, nearest);
                    growths += 1;
                    continue;
                }
            }
            let (upper, normal) = best.unwrap_or((f64::INFINITY, normal));
            let enclosed = self.encloses(lower, offset >= Wide::ZERO);
            return Ok(Bounds { lower, upper, normal, enclosed });
        }
    }

    /// Whether a polytope whose nearest plane is at `lower` and which, on the lattice, has the
    /// origin in it or not, shows that the true difference has it.
    fn encloses(&self, lower: f64, on_lattice: bool) -> bool {
        if self.difference.slack() == 0.0 {
            on_lattice
        } else {
            !self.difference.is_flat() && lower > self.difference.slack()
        }
    }
}
