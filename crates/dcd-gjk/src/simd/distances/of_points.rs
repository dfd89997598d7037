//! The distance of two polytopes by the vertices that the lanes found: those of f32, or, of shapes that are close, those of f64.

use super::super::bounds::{ROTATED, U};
use super::super::depths::vertex;
use super::super::frame::{FramePair, Record, SimdFrame, WHOLE};
use super::super::nearest_points::NearestPoints;
use crate::distance::rounded_up;
use crate::{Distance, PosedShape};
use dcd_geom::glam::DVec3;
use dcd_geom::{Pair, Polytope, Pose};

/// A bound above this, of the pair's size, is one that the lanes did not reach; the pair is measured in f64. No
/// unit. Larger: worse bounds. Smaller: more pairs take a microsecond.
const WORST: f64 = 8e-6;

/// What the f64 arithmetic of a distance may be off by: unit 2⁻⁵³ of the pair's size. Weights 8, the
/// rotations 12 for each shape, differences and the length 8; and a margin.
const ROUNDED: f64 = 64.0 * crate::UNIT;

/// The most that the vertices of f32 may be off, relative to the distance between them: the sine of the angle by which that turns
/// the normal. No unit. Larger: worse normals of shapes that are close. Smaller: more pairs whose vertices are read in f64.
const SURE: f64 = 1.0 / 256.0;

impl NearestPoints {
    /// The distance by the vertices as the frames have them; `None` of shapes too close for that, and where the bound is too wide.
    #[inline(always)]
    pub(super) fn distance_in_f32(&self, frames: FramePair<'_>, pair: Pair) -> Option<Distance> {
        let weights = weights(self.weights)?;
        let [a, b] = [frames.a.record(pair.i), frames.b.record(pair.j)];
        // Others are more than their vertices.
        (a.marks & b.marks & WHOLE != 0).then_some(())?;
        let from_a = mean(frames.a, a, self.corners.map(|[corner, _]| corner), weights);
        let from_b = mean(frames.b, b, self.corners.map(|[_, corner]| corner), weights);
        let between = centre(a) - centre(b);
        // Exchanging the two only changes signs.
        let from_origin = between + (from_a - from_b);
        let length = from_origin.length();
        let sizes = f64::from(a.size) + f64::from(b.size);
        let slack = f64::from(a.slack) + f64::from(b.slack);
        let radii = [a, b].map(|record| f64::from(record.radius));
        // Of three coordinates; a radius is rounded up by 6u of itself at most.
        let swept = radii[0] + radii[1];
        let off = 1.75 * (f64::from(ROTATED * U) * sizes + slack) + f64::from(8.0 * U) * swept;
        let distance = length - swept;
        let size = sizes + between.abs().element_sum();
        let error_bound = rounded_up((length - f64::from(self.lower)).max(off) + ROUNDED * size);
        let is_good = off <= SURE * length && distance > 0.0 && error_bound <= WORST * size;
        is_good.then(|| {
            let normal = -from_origin / length;
            Distance {
                distance,
                point_a: centre(a) + from_a + normal * radii[0],
                point_b: centre(b) + from_b - normal * radii[1],
                normal,
                error_bound,
            }
        })
    }
}

/// Where an object's centre is.
#[inline(always)]
fn centre(record: &Record) -> DVec3 {
    let [x, y, z, _] = record.centre;
    DVec3::new(x, y, z)
}

/// The mean of three vertices of an object with these weights, from its centre.
#[inline(always)]
fn mean(frame: &SimdFrame, record: &Record, vertices: [u32; 3], weights: [f64; 3]) -> DVec3 {
    let blocks = frame.blocks_of(record);
    let [p, q, r] = vertices.map(|number| vertex(blocks, number as usize).as_dvec3());
    let [of_p, of_q, of_r] = weights;
    p * of_p + q * of_q + r * of_r
}

/// The distance of two polytopes that are apart, by vertices whose weighted means are nearest points of their cores
/// or nearly so, and what the lanes prove from below. `None`: that bound is too wide.
pub(super) fn distance_of(
    points: &NearestPoints,
    a: PosedShape<'_>,
    b: PosedShape<'_>,
) -> Option<Distance> {
    let (in_a, in_b) = (a.shape.as_polytope()?, b.shape.as_polytope()?);
    let weights = weights(points.weights)?;
    let turned = |side: usize, polytope: &Polytope, pose: &Pose| {
        let vertices = polytope.vertices();
        // The last block is filled up with the last vertex.
        let vertex = |number: u32| vertices[(number as usize).min(vertices.len() - 1)];
        let corners = points.corners.iter().zip(weights);
        let mean: DVec3 = corners.map(|(corner, weight)| vertex(corner[side]) * weight).sum();
        *pose.rotation() * mean
    };
    let (from_a, from_b) = (turned(0, in_a, a.pose), turned(1, in_b, b.pose));
    let apart = a.pose.translation() - b.pose.translation();
    let from_origin = (from_a - from_b) + apart;
    let length = from_origin.length();
    let normal = -from_origin / length;
    let reach = |polytope: &Polytope, pose: &Pose| polytope.reach() * (1.0 + pose.deviation());
    let size = reach(in_a, a.pose) + reach(in_b, b.pose) + apart.abs().element_sum();
    let rounding = ROUNDED * (size + in_a.swept_radius() + in_b.swept_radius());
    let radii = in_a.swept_radius() + in_b.swept_radius();
    let distance = length - radii;
    let lower = f64::from(points.lower) - radii;
    let error_bound = (distance - lower).max(0.0) + 2.0 * rounding;
    let is_good = distance > 0.0 && error_bound <= WORST * size && normal.is_finite();
    is_good.then(|| Distance {
        distance,
        point_a: a.pose.translation() + from_a + normal * in_a.swept_radius(),
        point_b: b.pose.translation() + from_b - normal * in_b.swept_radius(),
        normal,
        error_bound,
    })
}

/// Of the three points: none below 0, and 1 together but for rounding.
fn weights([second, third]: [f32; 2]) -> Option<[f64; 3]> {
    let (second, third) = (f64::from(second), f64::from(third));
    let all = [1.0 - second - third, second, third].map(|weight| weight.max(0.0));
    let sum: f64 = all.iter().sum();
    (sum > 0.5 && sum.is_finite()).then(|| all.map(|weight| weight / sum))
}
