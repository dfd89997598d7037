//! The manifold of two boxes: what [`super::cuboids`] clips, in the plane of the face that clips, and nothing besides.

use super::clip::different;
use super::cuboids::{self, Clipped, CuboidClipping, CuboidPolygon, MOST};
use super::feature_code::FeatureCode;
use super::patch_writer::{PatchWriter, Point};
use super::polygon::features;
use super::reduce::{self, Spot};
use super::{Feature, SAME, bound_of, bound_of_witnesses, upright};
use crate::PosedShape;
use crate::epa::Depth;
use dcd_geom::glam::{DVec2, DVec3};

/// A corner of the patch: where, square to the normal, how deep, and its number in the list of corners.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Place {
    pub(super) at: DVec2,
    pub(super) depth: f64,
    pub(super) number: usize,
}

impl Spot for Place {
    #[inline]
    fn at(&self) -> DVec2 {
        self.at
    }

    #[inline]
    fn depth(&self) -> f64 {
        self.depth
    }
}

/// Writes the manifold of two boxes of that depth; false, and nothing written, where the general way is needed: see
/// [`cuboids::clipped`].
pub(super) fn write(
    depth: &Depth,
    sides: [PosedShape<'_>; 2],
    points: &mut CuboidPolygon,
    writer: &mut impl PatchWriter,
) -> bool {
    // Of two faces that are as square to the normal the first clips.
    upright::write(depth, sides, 0, writer) || write_clipped(depth, sides, points, writer)
}

/// The same by what the face of one clips of the other.
pub(super) fn write_clipped(
    depth: &Depth,
    [a, b]: [PosedShape<'_>; 2],
    points: &mut CuboidPolygon,
    writer: &mut impl PatchWriter,
) -> bool {
    let Some(clipped) = cuboids::clipped(points, depth.normal, [a, b]) else { return false };
    let size = clipped.patch.size;
    let is_patch = clipped.face.as_ref().is_some_and(|(clipping, number)| {
        let seen = ClippedPair { clipped: &clipped, clipping, number: *number };
        let error_bound = bound_of(depth, size, [a, b]);
        seen.write(depth, points, (a.pose.translation(), error_bound), writer)
    });
    if !is_patch {
        let error_bound = bound_of_witnesses(depth, size, [a, b]);
        writer.write_witnesses(depth, clipped.patch.whole, error_bound);
    }
    true
}

/// What a face clips, and whose it is: 0 or 1.
struct ClippedPair<'a> {
    clipped: &'a Clipped<'a>,
    clipping: &'a CuboidClipping<'a>,
    number: usize,
}

impl ClippedPair<'_> {
    /// False, and nothing written, where no corner is as deep as the pair.
    #[inline(always)]
    fn write(
        &self,
        depth: &Depth,
        points: &CuboidPolygon,
        (origin, error_bound): (DVec3, f64),
        writer: &mut impl PatchWriter,
    ) -> bool {
        let Clipped { patch, radii, level, .. } = self.clipped;
        let mut places = [Place::default(); MOST];
        let count = self.places(points, radii[0] + radii[1], &mut places);
        let count = different(&mut places[..count], patch.size);
        let places = &places[..count];
        let tolerance = SAME * patch.size;
        let Some((kept, count)) = reduce::to_four(places, tolerance) else { return false };
        // False for NaN, which numbers near the end of their range make.
        if !(places[kept[0]].depth >= depth.depth - tolerance) {
            return false;
        }
        let inside = (radii[0] * (1.0 - level[0])).max(radii[1] * (1.0 - level[1])).max(0.0);
        let shallowest = kept[..count].iter().map(|&k| places[k].depth).fold(depth.depth, f64::min);
        let off_surface = inside.min((depth.depth - shallowest).max(0.0));
        let error_bound = (error_bound + off_surface).min(f64::MAX);
        let deepest =
            Point { depth: depth.depth, ..self.point(&places[kept[0]], points, depth, origin) };
        writer.begin(depth.normal, error_bound, deepest);
        for &k in &kept[1..count] {
            writer.push(self.point(&places[k], points, depth, origin));
        }
        true
    }

    /// A corner as a point.
    #[inline(always)]
    fn point(&self, place: &Place, points: &CuboidPolygon, depth: &Depth, origin: DVec3) -> Point {
        let Clipped { patch, radii, .. } = self.clipped;
        let normal = depth.normal;
        let corner = &points.list()[place.number];
        let on_face = self.clipping.in_world(corner.at) + origin;
        let whole: [Feature; 2] = [patch.whole[self.number], patch.whole[1 - self.number]];
        let [of_clips, of_clipped] = features(corner.origin, whole);
        let ([over_a, under_b], features) = match self.number {
            0 => ([0.0, corner.depth], [of_clips, of_clipped]),
            _ => ([corner.depth, 0.0], [of_clipped, of_clips]),
        };
        Point {
            point_a: on_face + normal * (over_a + radii[0]),
            point_b: on_face - normal * (under_b + radii[1]),
            depth: place.depth.clamp(0.0, depth.depth),
            features: features.map(FeatureCode::from),
        }
    }

    /// The corners as they are seen along the normal, with the radii in their depths: how many.
    #[inline(always)]
    fn places(&self, points: &CuboidPolygon, radius: f64, places: &mut [Place; MOST]) -> usize {
        // Axes square to the normal: the first side's part, and what is square to both, counter-clockwise along a's normal.
        let [along_p, along_q, square] = self.clipping.normal();
        let length = (1.0 - along_p * along_p).sqrt();
        let sense = if self.number == 0 { 1.0 } else { -1.0 };
        let (across, upright) = (along_p * along_q / length, sense * square / length);
        let list = points.list();
        for (number, (place, point)) in places.iter_mut().zip(list).enumerate() {
            let [x, y] = point.at;
            let at = DVec2::new(x * length - y * across, y * upright);
            *place = Place { at, depth: point.depth + radius, number };
        }
        list.len()
    }
}

#[cfg(test)]
mod tests {
    use super::super::corners::Corners;
    use super::super::cuboid_faces::tests::Draw;
    use super::super::{Manifold, write_in_order};
    use super::*;
    use crate::{Accuracy, Depths, Verdict, query::MeasureAt};
    use dcd_geom::glam::DQuat;
    use dcd_geom::{Pose, Shape};

    impl Draw {
        fn vector(&mut self) -> DVec3 {
            DVec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0
        }

        fn turn(&mut self) -> DQuat {
            DQuat::from_vec4(self.vector().extend(self.unit() - 0.5)).normalize()
        }
    }

    /// How far the second point is from the first, and the others from the line of both, square to the normal.
    fn spans(found: &Manifold) -> Vec<f64> {
        let from_first =
            |k: usize| (found.points[k].point_a - found.points[0].point_a).cross(found.normal);
        let count = found.points().len();
        let off_line = |k: usize| from_first(k).cross(from_first(1)).length();
        (1..count).map(|k| if k == 1 { from_first(1).length() } else { off_line(k) }).collect()
    }

    #[test]
    fn two_boxes_have_the_manifold_that_the_corners_of_any_shapes_give() {
        let mut draw = Draw(7);
        let (mut points, mut corners) = (CuboidPolygon::default(), Corners::default());
        let mut counts = [0; 5];
        let (mut same, mut others) = (0, 0);
        for k in 0..20_000 {
            let shape = |draw: &mut Draw| {
                let half = draw.vector().abs() * 0.5 + 0.1;
                let radius = if k % 4 == 0 { 0.05 } else { 0.0 };
                Shape::cuboid(half).unwrap().rounded(radius).unwrap()
            };
            let shapes = [shape(&mut draw), shape(&mut draw)];
            let turn = draw.turn();
            let tilt = DQuat::from_scaled_axis(draw.vector() * [0.0, 1e-9, 1e-3, 0.2][k / 3 % 4]);
            let other = if k % 3 == 0 { draw.turn() } else { turn * tilt };
            let far = draw.vector() * 10.0;
            let poses = [
                Pose::new(turn, far).unwrap(),
                Pose::new(other, far + draw.vector() * 0.6).unwrap(),
            ];
            let [a, b] = [0, 1].map(|k| PosedShape { shape: &shapes[k], pose: &poses[k] });
            let mut scratch = Default::default();
            if crate::certified::overlap_of(a, b).0 != Verdict::Touching(()) {
                continue;
            }
            let Verdict::Touching(depth) = Depths.measure_at(Accuracy::F64, a, b, &mut scratch)
            else {
                panic!("{k}");
            };
            let mut found = Manifold::default();
            if !write(&depth, [a, b], &mut points, &mut found) {
                continue;
            }
            let mut reference = Manifold::default();
            write_in_order(&depth, [a, b], &mut corners, &mut reference);
            counts[found.points().len()] += 1;
            let size = 1e-8;
            // Corners that are as far, deep or wide as others may be chosen in their place.
            assert_eq!(found.normal, reference.normal);
            assert!((found.error_bound - reference.error_bound).abs() <= size, "{k}");
            if k % 3 > 0 && k / 3 % 4 < 3 {
                continue;
            }
            assert_eq!(found.points().len(), reference.points().len(), "{k}");
            for (x, y) in spans(&found).into_iter().zip(spans(&reference)) {
                assert!((x - y).abs() < size, "{k} {found:?} {reference:?}");
            }
            for (p, q) in found.points().iter().zip(reference.points()) {
                if p.features == q.features {
                    same += 1;
                    assert!(p.point_a.distance(q.point_a) < size, "{k}");
                    assert!(p.point_b.distance(q.point_b) < size, "{k}");
                    assert!((p.depth - q.depth).abs() < size, "{k}");
                } else {
                    others += 1;
                }
            }
        }
        assert!(others < same / 20, "{same} {others}");
        assert!(counts[1..].iter().all(|&count| count > 100), "{counts:?}");
    }
}
