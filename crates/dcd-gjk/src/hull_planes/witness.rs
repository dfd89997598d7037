//! Where a hull and a body are deepest: the points over each other along the nearest plane's normal.

use super::lanes::Feature;
use super::{Placed, shares};
use dcd_geom::glam::DVec3;

/// How far the body's witness may be from what it is a point of, and below the deepest, relative to the size. Larger: wider
/// bounds. Smaller: more pairs that are searched.
const BESIDE: f64 = 1e-9;

/// The cosine from which on a face may be level.
const FACING: f64 = 1.0 - 1e-6;

impl Placed<'_> {
    /// The point of the hull that is deepest, from the centre, and how far the point over it is from the body. `None` where
    /// another plane, as near but for rounding, has them.
    pub(super) fn witness(
        &self,
        feature: Feature,
        outward: DVec3,
        reach: f64,
    ) -> Option<(DVec3, f64)> {
        // From a point of the hull to that of the body.
        let back = -outward * reach;
        let (at, beside) = match feature {
            Feature::Side { vertex, .. } => {
                let at = self.hull.vertex(vertex);
                (at, self.outside(at + back))
            }
            Feature::Face { face, .. } => {
                let (_, corners) = self.hull.rows.face_polygon(face)?;
                let at = self.lowest(outward) - back;
                // At a sharp corner its sides say less than the distance.
                let is_inside = self.hull.is_in_face(corners, outward, at);
                (at, if is_inside { 0.0 } else { f64::INFINITY })
            }
            Feature::Edge { axis, .. } => {
                let edges @ [from, along, on, across] = self.edges(feature)?;
                let [share, of_body] = shares(edges);
                let at = from + along * share.clamp(0.0, 1.0);
                let half = self.half[axis];
                (at, (on + across * of_body.clamp(-half, half)).distance(at + back))
            }
        };
        // Written so that NaN is beside.
        if beside <= BESIDE * self.size {
            return Some((at, beside));
        }
        self.on_level_edge(outward, back).or_else(|| self.on_level_face(outward, back))
    }

    /// The same where an edge of the hull is level and over the body.
    fn on_level_edge(&self, outward: DVec3, back: DVec3) -> Option<(DVec3, f64)> {
        let most = self.hull.reach(outward);
        let near = BESIDE * self.size;
        let lacking = |at: DVec3| most - outward.dot(at);
        let edges = (0..).map_while(|edge| self.hull.edge(edge));
        let is_level =
            |[from, along]: &[DVec3; 2]| lacking(*from).max(lacking(*from + *along)) <= near;
        edges.filter(is_level).find_map(|[from, along]| {
            let at = from + along * self.share_over(from + back, along)?;
            let beside = self.outside(at + back) + lacking(at).max(0.0);
            (beside <= near).then_some((at, beside))
        })
    }

    /// The middle of the share of a line that is in the body, but for rounding.
    fn share_over(&self, from: DVec3, along: DVec3) -> Option<f64> {
        let (mut least, mut most) = (0.0f64, 1.0f64);
        for (axis, half) in self.axes.iter().zip(self.half) {
            let (at, rise) = (axis.dot(from - self.centre), axis.dot(along));
            let half = half + 0.25 * BESIDE * self.size;
            if rise == 0.0 {
                if at.abs() > half {
                    return None;
                }
                continue;
            }
            let [p, q] = [(-half - at) / rise, (half - at) / rise];
            (least, most) = (least.max(p.min(q)), most.min(p.max(q)));
        }
        (least <= most).then_some(0.5 * (least + most))
    }

    /// The same where a face of the hull is level and over a corner of the body that is as low as any.
    fn on_level_face(&self, outward: DVec3, back: DVec3) -> Option<(DVec3, f64)> {
        let most = self.hull.reach(outward);
        let near = BESIDE * self.size;
        let low = self.low_corners(outward, 0.5 * near);
        let faces = (0..).map_while(|face| self.hull.rows.face_polygon(face));
        faces.filter(|(normal, _)| normal.dot(outward) > FACING).find_map(|(normal, corners)| {
            let places = low.iter().flatten().map(|&(corner, raised)| (corner - back, raised));
            places.into_iter().find_map(|(at, raised)| {
                let beside = raised + (most - outward.dot(at)).abs();
                let is_over = self.hull.is_in_face(corners, normal, at);
                (is_over && beside <= near).then_some((at, beside))
            })
        })
    }

    /// The corners of the body that are at most so much above the lowest along a direction, and how much they are.
    fn low_corners(&self, outward: DVec3, near: f64) -> [Option<(DVec3, f64)>; 8] {
        let lowest = self.lowest(outward);
        std::array::from_fn(|other| {
            let mut corner = lowest;
            for (k, (axis, half)) in self.axes.iter().zip(self.half).enumerate() {
                if other >> k & 1 == 1 {
                    corner += *axis * (2.0 * half).copysign(outward.dot(*axis));
                }
            }
            let raised = outward.dot(corner - lowest).abs();
            (raised <= near).then_some((corner, raised))
        })
    }

    /// How far a point is from the body.
    fn outside(&self, point: DVec3) -> f64 {
        let from = point - self.centre;
        let mut nearest = self.centre;
        for (axis, half) in self.axes.iter().zip(self.half) {
            nearest += *axis * axis.dot(from).clamp(-half, half);
        }
        nearest.distance(point)
    }
}
