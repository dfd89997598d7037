//! The expansion: from an inner polytope to the nearest facet of the difference.

use super::hull::Hull;
use super::lattice::{LatticeDifference, Normal, Support, Vertex, length};
use super::wide::Wide;

/// How often the polytope may grow. Each growth adds a vertex of a finite set, so the search ends
/// by itself, after eight for hulls of tens of vertices; this bounds the time (a tenth of a second)
/// where facets are many and all alike, as for concentric spheres cut into thousands. Smaller:
/// larger error bounds there.
pub(super) const GROWTHS: usize = 1 << 14;

/// The relative gap between the bounds at which the search stops. Well below what is promised of
/// a depth, 1e-9. Smaller: more growth on finely cut shapes, for digits beyond the promised ones.
const GAP: f64 = 1.0 / (1u64 << 42) as f64;

/// The difference and what its supports prove.
pub(super) struct Viewer<'a> {
    pub(super) difference: LatticeDifference<'a>,
    separation: Separation,
}

/// What a direction that separates means to a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Separation {
    /// Its end: there is no overlap.
    Ends,
    /// Nothing: the facets are wanted, wherever the origin is.
    Passes,
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
    pub(super) fn new(difference: LatticeDifference<'a>) -> Self {
        Self { difference, separation: Separation::Ends }
    }

    /// From now on no direction ends a search.
    pub(super) fn look_past_separation(&mut self) {
        self.separation = Separation::Passes;
    }

    /// The support along `normal`, unless that separates and ends the search.
    pub(super) fn view(&mut self, normal: &Normal) -> Result<Support, Separated> {
        let support = self.difference.support(normal);
        if self.separation == Separation::Ends
            && support.reach < Wide::ZERO
            && support.reach.to_f64() < -self.difference.slack() * length(normal)
        {
            return Err(Separated { normal: *normal });
        }
        Ok(support)
    }

    /// Grows the hull of `corners` until its nearest face is one of the difference, at most
    /// `limit` times.
    pub(super) fn expand(
        &mut self,
        corners: [Vertex; 4],
        hull: &mut Hull,
        limit: usize,
    ) -> Result<Bounds, Separated> {
        hull.start(corners);
        let mut best: Option<(f64, Normal)> = None;
        let mut grown = 0;
        loop {
            let nearest = hull.nearest();
            let face = hull.face(nearest);
            let (normal, offset, lower) = (face.normal, face.offset, face.distance());
            let met = |upper: f64, slack: f64| upper - lower <= GAP * upper.max(0.0) + slack;
            if !best.is_some_and(|(upper, _)| met(upper, self.difference.slack())) {
                let support = self.view(&normal)?;
                let upper = support.reach.to_f64() / length(&normal);
                if best.is_none_or(|(least, _)| upper < least) {
                    best = Some((upper, normal));
                }
                // A vertex for which they do not meet is strictly beyond the face: equal products
                // have equal quotients.
                if !met(upper, self.difference.slack()) && grown < limit {
                    hull.insert(support.vertex, nearest);
                    grown += 1;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PosedSupport;
    use dcd_geom::glam::{DQuat, DVec3};
    use dcd_geom::{Polytope, Pose};

    /// Points round the unit sphere, no two at one height.
    fn round() -> Polytope {
        let point = |k: i32| {
            let (z, angle) = (f64::from(2 * k - 199) / 200.0, 2.4 * f64::from(k));
            let r = (1.0 - z * z).sqrt();
            DVec3::new(r * angle.cos(), r * angle.sin(), z)
        };
        Polytope::hull((0..200).map(point).collect()).unwrap()
    }

    #[test]
    fn a_search_that_is_cut_short_has_bounds_that_hold() {
        let (a, b) = (round(), round());
        let turned = Pose::new(DQuat::from_rotation_x(0.7), DVec3::new(0.1, 0.2, 0.3)).unwrap();
        let (a, b) =
            (PosedSupport::polytope(&a, &Pose::IDENTITY), PosedSupport::polytope(&b, &turned));
        let mut hull = Hull::default();
        let mut bounds = |limit| {
            let mut dots = Vec::new();
            let mut viewer = Viewer::new(LatticeDifference::new(a, b, &mut dots));
            let corners = viewer.tetrahedron(DVec3::ONE).unwrap();
            viewer.expand(corners, &mut hull, limit).unwrap()
        };
        let truth = bounds(GROWTHS);
        assert!(truth.enclosed && truth.upper - truth.lower <= GAP * truth.upper);
        let mut last = f64::INFINITY;
        for limit in 0..20 {
            let Bounds { lower, upper, .. } = bounds(limit);
            assert!(lower <= truth.upper && truth.lower <= upper && upper.is_finite());
            assert!(upper <= last);
            last = upper;
        }
    }
}
