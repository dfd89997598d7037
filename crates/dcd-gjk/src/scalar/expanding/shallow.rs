//! The depth at the end of a search, measured in double-double: what f64's roundings leave of a shallow one is too much.

use super::confirm::NearFace;
use super::surface::Surface;
use super::{ExpandingSearch, Tolerance};
use crate::certificate::Bounds;
use crate::double_double::{DoubleDouble, EPSILON};
use crate::epa::Depth;
use crate::exact::Number;
use crate::exact::grid::{Extent, Grid};
use crate::gjk::unit;
use crate::query::FoundDepth;
use crate::simplex::{Scalar, Triple, cross, dot, minus, negated};
use dcd_geom::Polytope;
use dcd_geom::glam::DVec3;
use dcd_simd::ArrayVec;

/// How much farther than the nearest face another surely is the farther one, as f64 has both: 2⁻⁴⁰, some thousand
/// times what f64 loses. Lengths of a difference, below 1. Smaller: a bound by f64's knowledge of the other. Larger: more
/// faces in double-double.
const APART: f64 = 1.0 / (1u64 << 40) as f64;

/// How many faces are measured. Two are the rule where edges cross, and as many triangles as a polygon has where a face
/// is the nearest. Fewer: more pairs for the exact search.
pub(super) const MOST: usize = 8;

/// How far a height over a computed plane, or the reach along its normal, may be off. Unit: ε, lengths below 1. A vertex
/// loses 5.01 a coordinate, the product with the normal n 3 and that the vertex is the farthest 12, all times
/// |n|₁ ≤ √3·|n|; the root and the quotient 12 (docs/numerics/proofs.md, "Depth in double-double"). Smaller: a bound that is none.
const OFF: f64 = 64.0;

/// The squared length below which a normal is a sliver's: 2⁻⁶⁰. The digits of its products stay in f64's range.
const SLIVER: f64 = 1.0 / (1u64 << 60) as f64;

/// The gap between the bounds that is good enough, relative to the depth: where the exact search stops.
const GAP: f64 = 1.0 / (1u64 << 42) as f64;

/// As good as the exact search's answer, or none.
const AS_EXACT: Tolerance = Tolerance { relative: GAP, of_size: 0.0, at_end: GAP, least: 0.0 };

/// The faces that may be the nearest, of a surface of vertices that surely winds round the origin.
struct Near {
    faces: ArrayVec<NearFace, MOST>,
    /// At most the distance of the others, for the true vertices.
    others: f64,
}

impl Near {
    /// `None` of too many.
    fn of(faces: impl Iterator<Item = NearFace> + Clone, bounds: &Bounds<f64>) -> Option<Self> {
        let nearest = faces.clone().map(|face| face.clearance).fold(f64::INFINITY, f64::min);
        let mut near = Self { faces: ArrayVec::new(), others: f64::INFINITY };
        for face in faces {
            if face.clearance > nearest + APART {
                near.others = near.others.min(bounds.least_reach(face.clearance));
            } else if near.faces.len() < MOST {
                near.faces.push(face);
            } else {
                return None;
            }
        }
        Some(near)
    }
}

/// What double-double finds of some faces: lengths of the difference, to within [`OFF`].
struct Measured {
    /// How far the difference reaches along the nearest face's normal.
    reach: DoubleDouble,
    /// At most the distance of each face from the origin.
    lower: DoubleDouble,
    /// Of the nearest face, outward, of any length.
    normal: DVec3,
    /// The vertices of a and of b that are farthest along it.
    farthest: [u32; 2],
}

impl ExpandingSearch<'_, Polytope> {
    /// The depth by faces of a surface that surely winds round the origin, those that may be the nearest. `others` is at
    /// most the distance of the rest. `None` where it is not known as well as by the exact search.
    pub(super) fn depth_by_faces(
        &self,
        bounds: &Bounds<f64>,
        faces: &[NearFace],
        others: f64,
    ) -> Option<FoundDepth> {
        let mut near = Near::of(faces.iter().copied(), bounds)?;
        near.others = near.others.min(others);
        self.measured(&near)
    }

    /// The depth by the surface that a search in f64 has ended with.
    pub(super) fn depth_by_surface(
        &self,
        bounds: &Bounds<f64>,
        surface: &Surface,
    ) -> Option<Depth> {
        // Moved to the true vertices it winds round the origin as well.
        if !(bounds.least_reach(surface.inner_radius()) > 0.0) {
            return None;
        }
        Some(self.measured(&Near::of(surface.faces(), bounds)?)?.depth)
    }

    fn measured(&self, near: &Near) -> Option<FoundDepth> {
        let [a, b] = self.bodies;
        // The scale is a power of two.
        let exponent = 1023 - (self.difference.scale().to_bits() >> 52) as i32;
        let grid = Grid::<DoubleDouble>::new(a, b, &Extent::coarse(exponent));
        let faces = &*near.faces;
        let Measured { reach, lower, normal, farthest } = measure(&grid, faces)?;
        let off = DoubleDouble::from(2.0 * OFF * EPSILON);
        let lower = lower.minus(&off);
        let lower = if lower.to_f64() < near.others { lower } else { near.others.into() };
        // The depth that is reported is the reach, so that the bound from below is the farther one.
        let error = reach.minus(&lower).plus(&off).to_f64();
        let direction = unit::<f64>(normal.to_array())?;
        let points = self.leaving(faces, direction, reach.to_f64())?;
        let depth = self.depth_within(AS_EXACT, reach.to_f64(), error, points, direction)?;
        Some(FoundDepth { depth, farthest: Some(farthest) })
    }
}

/// Points of the difference by the vertices that make them, each computed once: faces share corners, and one of them is
/// mostly the farthest.
struct Points<'a, 'b> {
    grid: &'a Grid<'b, DoubleDouble>,
    known: ArrayVec<([u32; 2], Triple<DoubleDouble>), { 3 * MOST }>,
}

impl Points<'_, '_> {
    /// The corner of a face.
    fn corner(&mut self, vertices: [u32; 2]) -> Triple<DoubleDouble> {
        let point = self.point(vertices);
        if !self.known.iter().any(|(known, _)| *known == vertices) {
            self.known.push((vertices, point));
        }
        point
    }

    fn point(&self, vertices: [u32; 2]) -> Triple<DoubleDouble> {
        let known = self.known.iter().find(|(known, _)| *known == vertices);
        known.map_or_else(|| self.grid.point(vertices.map(|k| k as usize)), |(_, point)| *point)
    }
}

fn measure(grid: &Grid<'_, DoubleDouble>, faces: &[NearFace]) -> Option<Measured> {
    let mut known = Points { grid, known: ArrayVec::new() };
    let mut nearest: Option<(DoubleDouble, Triple<DoubleDouble>)> = None;
    for NearFace { corners, .. } in faces {
        let points = corners.map(|corner| known.corner([corner.a.feature, corner.b.feature]));
        let [p, q, r] = &points;
        let normal = cross(&minus(q, p), &minus(r, p));
        let squared = dot(&normal, &normal);
        // Written so that NaN leaves the pair to the exact search.
        if !(squared.to_f64() > SLIVER) {
            return None;
        }
        // No point of a triangle is nearer than its lowest corner along any direction.
        let heights = [p, q, r].map(|point| dot(&normal, point));
        let height = heights.into_iter().reduce(lesser)?.divided_by(squared.sqrt());
        if nearest.as_ref().is_none_or(|(least, _)| height.minus(least).is_negative()) {
            nearest = Some((height, normal));
        }
    }
    let (lower, normal) = nearest?;
    let farthest = grid.lowest(&negated(&normal)).map(|vertex| vertex as u32);
    let length = dot(&normal, &normal).sqrt();
    let reach = dot(&normal, &known.point(farthest)).divided_by(length);
    Some(Measured { reach, lower, normal: DoubleDouble::rounded(&normal), farthest })
}

fn lesser(one: DoubleDouble, other: DoubleDouble) -> DoubleDouble {
    if other.minus(&one).is_negative() { other } else { one }
}
