//! The manifold of two hulls or capsules: the feature of one clipped by the face of the other, seen along the normal.
//!
//! The same features and corners as the general way's, in less memory, and written where the answer is to be.

use super::clip::different;
use super::corners::share_no_corners;
use super::cuboid_pair::Place;
use super::facing::Part;
use super::feature::{Placed, View};
use super::feature_code::FeatureCode;
use super::outline::{CORNERS, Outline, Outlines};
use super::patch_writer::{PatchWriter, Point};
use super::polygon::Polygon;
use super::reduce;
use super::{SAME, bound_of, bound_of_witnesses, unevenness};
use crate::PosedShape;
use crate::epa::Depth;
use crate::query::FoundDepth;
use dcd_geom::glam::{DVec2, DVec3};
use dcd_simd::ArrayVec;

/// The most corners that a patch of two faces of [`CORNERS`] may have: one more for each cut, and spare ones for what rounding
/// adds.
const MOST: usize = 2 * CORNERS + 4;

/// The patch of two hulls.
pub(super) type HullPolygon = Polygon<MOST>;

/// Writes the manifold of two hulls of that depth; false, and nothing written, where the general way is needed: for
/// spheres, edges that are nearly parallel, and faces of many corners.
pub(super) fn write(
    known: &FoundDepth,
    [a, b]: [PosedShape<'_>; 2],
    polygon: &mut HullPolygon,
    writer: &mut impl PatchWriter,
) -> bool {
    let (Some(in_a), Some(in_b)) = (a.shape.as_polytope(), b.shape.as_polytope()) else {
        return false;
    };
    // A sphere shows nothing of its own.
    if in_a.vertices().len().min(in_b.vertices().len()) < 2 {
        return false;
    }
    let depth = &known.depth;
    let view = View::along(depth.normal);
    let delta = b.pose.translation() - a.pose.translation();
    let placed = [
        Placed { rotation: a.pose.rotation(), place: DVec3::ZERO, sense: 1.0 },
        Placed { rotation: b.pose.rotation(), place: delta, sense: -1.0 },
    ];
    let [of_a, of_b] = match known.farthest {
        Some([a, b]) => [Some(a), Some(b)],
        None => [None; 2],
    };
    // Both before the first is looked along, which ends by a branch that is not predicted: the other is known by then.
    let towards = placed.each_ref().map(|placed| view.towards(placed));
    // Two places, not one of two: what is copied right after it has been written is waited for.
    let part_a = Part::round(in_a, towards[0], of_a);
    let part_b = Part::round(in_b, towards[1], of_b);
    let parts = [&part_a, &part_b];
    let size = 2.0 * (in_a.outer_radius() + in_b.outer_radius());
    let whole = [part_a.name(), part_b.name()];
    if share_no_corners(depth.normal, parts, [in_a, in_b], [a.pose.rotation(), b.pose.rotation()]) {
        writer.write_witnesses(depth, whole, bound_of_witnesses(depth, size, [a, b]));
        return true;
    }
    let outlines = [
        Outline::of(&view, &part_a, in_a, &placed[0]),
        Outline::of(&view, &part_b, in_b, &placed[1]),
    ];
    let [Some(of_a), Some(of_b)] = &outlines else { return false };
    let radii = [in_a.swept_radius(), in_b.swept_radius()];
    let outlines = Outlines::of([of_a.shown(), of_b.shown()], radii);
    if outlines.clip(polygon).is_none() {
        return false;
    }
    let uneven = unevenness([a.shape, b.shape]);
    let (origin, error_bound) = (a.pose.translation(), bound_of(depth, size, [a, b]) + uneven);
    let patch = HullPatch { view: &view, outlines, polygon, origin, size, uneven };
    if !patch.write(depth, error_bound, writer) {
        writer.write_witnesses(depth, whole, bound_of_witnesses(depth, size, [a, b]));
    }
    true
}

/// What two hulls have in common.
struct HullPatch<'a> {
    view: &'a View,
    outlines: Outlines<'a>,
    polygon: &'a HullPolygon,
    /// Where the view is in the world.
    origin: DVec3,
    /// How large the shapes are.
    size: f64,
    /// How far the deepest corner may be short for faces that are not flat, metres.
    uneven: f64,
}

impl HullPatch<'_> {
    /// Writes up to four of its corners; false, and nothing written, where none is as deep as the pair.
    #[inline(always)]
    fn write(&self, depth: &Depth, error_bound: f64, writer: &mut impl PatchWriter) -> bool {
        let radius = self.outlines.radius();
        let mut places: ArrayVec<Place, MOST> = ArrayVec::new();
        places.extend(self.polygon.list().iter().enumerate().map(|(number, corner)| {
            let (at, depth) = (DVec2::from_array(corner.at), corner.depth + radius);
            Place { at, depth, number }
        }));
        let count = different(&mut places, self.size);
        let places = &places[..count];
        let tolerance = SAME * self.size;
        let Some((kept, count)) = reduce::to_four(places, tolerance) else { return false };
        // A depth in f32 is off the corners', which are in f64, by up to its bound.
        let short = depth.depth - places[kept[0]].depth;
        // False for NaN, which numbers near the end of their range make.
        if !(short <= tolerance + self.uneven + depth.error_bound) {
            return false;
        }
        let shallowest = kept[..count].iter().map(|&k| places[k].depth).fold(depth.depth, f64::min);
        let off_surface = self.outlines.inside().min((depth.depth - shallowest).max(0.0));
        let error_bound = (error_bound + off_surface + short.abs()).min(f64::MAX);
        let deepest = Point { depth: depth.depth, ..self.point(&places[kept[0]], depth) };
        writer.begin(depth.normal, error_bound, deepest);
        for &k in &kept[1..count] {
            writer.push(self.point(&places[k], depth));
        }
        true
    }

    #[inline(always)]
    fn point(&self, place: &Place, depth: &Depth) -> Point {
        let corner = &self.polygon.list()[place.number];
        let [point_a, point_b] = self.view.in_world(place.at, self.outlines.heights(corner));
        Point {
            point_a: point_a + self.origin,
            point_b: point_b + self.origin,
            depth: place.depth.clamp(0.0, depth.depth),
            features: self.outlines.features(corner).map(FeatureCode::from),
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::corners::Corners;
    use super::super::cuboid_faces::tests::Draw;
    use super::super::{Manifold, ManifoldPoint, write_in_order};
    use super::*;
    use crate::{Accuracy, Depths, Verdict, query::MeasureAt};
    use dcd_geom::glam::DQuat;
    use dcd_geom::{Pose, Shape};

    pub(in super::super) fn vector(draw: &mut Draw) -> DVec3 {
        DVec3::new(draw.unit(), draw.unit(), draw.unit()) * 2.0 - 1.0
    }

    pub(in super::super) fn turn(draw: &mut Draw) -> DQuat {
        DQuat::from_vec4(vector(draw).extend(draw.unit() - 0.5)).normalize()
    }

    /// Clouds, prisms over regular polygons, plates, triangles, and capsules; others too with a swept radius.
    pub(in super::super) fn shape(draw: &mut Draw, k: usize) -> Shape {
        let prism = |sides: usize, height: f64| {
            let corner = |j: usize| {
                let angle = (j / 2) as f64 * std::f64::consts::TAU / sides as f64;
                DVec3::new(
                    angle.cos(),
                    angle.sin(),
                    if j.is_multiple_of(2) { -height } else { height },
                ) * 0.5
            };
            Shape::hull((0..2 * sides).map(corner).collect())
        };
        let shape = match k % 6 {
            0 | 1 => Shape::hull((0..20).map(|_| vector(draw) * 0.6).collect()),
            2 => prism(3 + k / 6 % 6, 0.7),
            3 => prism([12, 20, 24, 32][k / 6 % 4], 0.1),
            4 => Shape::capsule(draw.unit() * 0.6 + 0.1, 0.1),
            _ => Shape::triangle([vector(draw), vector(draw), vector(draw)]),
        };
        let radius = if k.is_multiple_of(7) { 0.05 } else { 0.0 };
        shape.unwrap().rounded(radius).unwrap()
    }

    #[test]
    fn two_hulls_have_the_manifold_that_the_corners_of_any_shapes_give() {
        let mut draw = Draw(11);
        let (mut points, mut corners) = (HullPolygon::default(), Corners::default());
        let (mut counts, mut known, mut general) = ([0; 5], 0, 0);
        for k in 0..20_000 {
            let shapes = [shape(&mut draw, k), shape(&mut draw, k / 6)];
            let turned = turn(&mut draw);
            let tilt =
                DQuat::from_scaled_axis(vector(&mut draw) * [0.0, 1e-9, 1e-3, 0.2][k / 25 % 4]);
            let other = if k % 2 == 0 { turn(&mut draw) } else { turned * tilt };
            let far = vector(&mut draw) * 10.0;
            let place = far + turned * (vector(&mut draw) * 0.6);
            let poses = [Pose::new(turned, far).unwrap(), Pose::new(other, place).unwrap()];
            let [a, b] = [0, 1].map(|k| PosedShape { shape: &shapes[k], pose: &poses[k] });
            if crate::certified::overlap_of(a, b).0 != Verdict::Touching(()) {
                continue;
            }
            let found = Depths.measure_at(Accuracy::F64, a, b, &mut Default::default());
            let Verdict::Touching(depth) = found else { panic!("{k}") };
            let mut found = Manifold::default();
            let unknown = FoundDepth { depth, farthest: None };
            if !write(&unknown, [a, b], &mut points, &mut found) {
                general += 1;
                continue;
            }
            known += 1;
            let mut reference = Manifold::default();
            write_in_order(&depth, [a, b], &mut corners, &mut reference);
            let size = 1e-9;
            counts[found.points().len()] += 1;
            assert_eq!(found.normal, reference.normal);
            assert!((found.error_bound - reference.error_bound).abs() <= size, "{k}");
            assert_eq!(found.points()[0].depth, reference.points()[0].depth, "{k}");
            // Corners that are as far, deep or wide as others may be chosen in their place.
            if k % 2 == 1 && k / 25 % 4 < 3 {
                continue;
            }
            assert_eq!(found.points().len(), reference.points().len(), "{k}");
            let is_same = |p: &ManifoldPoint, q: &ManifoldPoint| {
                p.features == q.features
                    && p.point_a.distance(q.point_a) < size
                    && p.point_b.distance(q.point_b) < size
                    && (p.depth - q.depth).abs() < size
            };
            for (p, q) in found.points().iter().zip(reference.points()) {
                assert!(is_same(p, q), "{k} {found:?} {reference:?}");
            }
        }
        assert!(known > 3 * general, "{known} {general}");
        assert!(counts[1..].iter().all(|&count| count > 50), "{counts:?}");
    }

    #[test]
    fn a_farthest_vertex_that_is_known_leads_to_the_same_manifold() {
        let mut draw = Draw(12);
        let mut points = HullPolygon::default();
        let (mut same, mut others) = (0, 0);
        for k in 0..8000 {
            let shapes = [shape(&mut draw, k), shape(&mut draw, k / 6)];
            let place = vector(&mut draw) * 0.6;
            let poses = [
                Pose::new(turn(&mut draw), DVec3::ZERO).unwrap(),
                Pose::new(turn(&mut draw), place).unwrap(),
            ];
            let [a, b] = [0, 1].map(|k| PosedShape { shape: &shapes[k], pose: &poses[k] });
            if crate::certified::overlap_of(a, b).0 != Verdict::Touching(()) {
                continue;
            }
            let found = Depths.measure_at(Accuracy::F64, a, b, &mut Default::default());
            let Verdict::Touching(depth) = found else { panic!("{k}") };
            let farthest = |side: PosedShape<'_>, normal: DVec3| {
                let vertices = side.shape.as_polytope().unwrap().vertices();
                let along = |k: &usize| normal.dot(side.pose.apply(vertices[*k]));
                let farthest = (0..vertices.len()).max_by(|j, k| along(j).total_cmp(&along(k)));
                farthest.unwrap() as u32
            };
            let vertices = [farthest(a, depth.normal), farthest(b, -depth.normal)];
            let write = |farthest, points: &mut HullPolygon| {
                let mut found = Manifold::default();
                write(&FoundDepth { depth, farthest }, [a, b], points, &mut found).then_some(found)
            };
            let (known, unknown) = (write(Some(vertices), &mut points), write(None, &mut points));
            // Of two edges that lean as little either may be seen.
            if known == unknown { same += 1 } else { others += 1 }
        }
        assert!(same > 1000 && others < same / 100, "{same} {others}");
    }
}
