//! Where the manifold of two convex shapes is written: in an empty manifold, or where a step keeps it. What finds the points
//! writes them once, where they are to stay: a point that is copied right after it has been written is waited for.

use super::feature_code::FeatureCode;
use super::{Feature, Manifold, ManifoldPoint};
use crate::epa::Depth;
use dcd_geom::glam::DVec3;

/// A point of shapes without parts.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    pub(super) point_a: DVec3,
    pub(super) point_b: DVec3,
    pub(super) depth: f64,
    pub(super) features: [FeatureCode; 2],
}

/// Where one manifold of shapes without parts is written.
pub(super) trait PatchWriter {
    /// Writes what all points share, and the deepest. Once, before any other.
    fn begin(&mut self, normal: DVec3, error_bound: f64, deepest: Point);

    /// Writes a further point.
    fn push(&mut self, point: Point);

    /// Writes the witnesses of a depth alone.
    #[inline(always)]
    fn write_witnesses(&mut self, depth: &Depth, features: [Feature; 2], error_bound: f64) {
        let &Depth { depth, normal, point_a, point_b, .. } = depth;
        let features = features.map(FeatureCode::from);
        self.begin(normal, error_bound, Point { point_a, point_b, depth, features });
    }
}

impl PatchWriter for Manifold {
    #[inline(always)]
    fn begin(&mut self, normal: DVec3, error_bound: f64, deepest: Point) {
        (self.normal, self.error_bound) = (normal, error_bound);
        self.push(deepest);
    }

    #[inline(always)]
    fn push(&mut self, Point { point_a, point_b, depth, features }: Point) {
        let features = features.map(Feature::from);
        self.points.push(ManifoldPoint { point_a, point_b, depth, features, parts: [None; 2] });
    }
}

/// Writes what is found of a pair, or of the same pair in the other order.
pub(super) struct InOrder<'a, W> {
    pub(super) writer: &'a mut W,
    /// Whether a and b are exchanged.
    pub(super) is_swapped: bool,
}

impl<W> InOrder<'_, W> {
    #[inline(always)]
    fn point(&self, mut point: Point) -> Point {
        if self.is_swapped {
            (point.point_a, point.point_b) = (point.point_b, point.point_a);
            point.features.reverse();
        }
        point
    }
}

impl<W: PatchWriter> PatchWriter for InOrder<'_, W> {
    #[inline(always)]
    fn begin(&mut self, normal: DVec3, error_bound: f64, deepest: Point) {
        let normal = if self.is_swapped { -normal } else { normal };
        let deepest = self.point(deepest);
        self.writer.begin(normal, error_bound, deepest);
    }

    #[inline(always)]
    fn push(&mut self, point: Point) {
        let point = self.point(point);
        self.writer.push(point);
    }
}
