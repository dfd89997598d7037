//! The manifold of two hulls or capsules: the feature of one clipped by the face of the other, seen along the normal.
//!
//! The same features and corners as the general way's, in less memory, and written where the answer is to be.

use super::clip::{different, has_sharp_corner};
use super::corners::share_no_corners;
use super::cuboid_pair::Place;
use super::cuboid_polygon::{LineOf, PointOf, Polygon, features};
use super::facing::Part;
use super::feature::{Placed, View};
use super::feature_code::FeatureCode;
use super::leaning_edge::level_of_edge;
use super::patch_writer::{PatchWriter, Point};
use super::reduce;
use super::{CROSSING, Feature, SAME, bound_of, bound_of_witnesses};
use crate::PosedShape;
use crate::epa::Depth;
use crate::query::FoundDepth;
use dcd_geom::Polytope;
use dcd_geom::glam::{DMat3, DVec2, DVec3};
use dcd_simd::ArrayVec;

/// The most corners that a patch may have. Larger: memory. Smaller: faces of many corners that go the general way.
const MOST: usize = 24;

/// The most corners of a face: two such have a patch of fewer than [`MOST`].
const CORNERS: usize = 10;

type Line = LineOf<u32>;

/// The corners of a patch of two hulls.
pub(super) type Points = Polygon<u32, MOST>;

/// A hull, what it shows, and how that is seen along the normal.
struct Side<'a> {
    polytope: &'a Polytope,
    part: &'a Part<'a>,
    /// From its own frame to the view's.
    turn: DMat3,
    /// Its origin as it is seen.
    origin: DVec3,
    /// How square to the normal its face is, 0 where it is no face.
    facing: f64,
    /// By how much its plane rises along x and y; 0 where it is no face.
    slope: DVec2,
    /// The cosine of the angle by which a face or an edge leans; 0 for others.
    level: f64,
    /// Whether it looks against the normal: its face's corners then go round clockwise.
    is_turned: bool,
}

impl<'a> Side<'a> {
    #[inline(always)]
    fn of(view: &View, polytope: &'a Polytope, part: &'a Part<'a>, placed: &Placed<'a>) -> Self {
        let turn = view.turn(placed.rotation);
        let (at, height) = view.of(placed.place);
        let (mut facing, mut slope, mut level) = (0.0, DVec2::ZERO, 0.0);
        match *part {
            Part::Face { normal, .. } => {
                let normal = turn * normal;
                facing = normal.z.abs();
                slope = -normal.truncate() / normal.z;
                level = facing;
            }
            Part::Edge(ends) => level = level_of_edge(polytope, ends, view.towards(placed)),
            Part::Vertex(_) => {}
        }
        let is_turned = placed.sense < 0.0;
        Self { polytope, part, turn, origin: at.extend(height), facing, slope, level, is_turned }
    }

    /// A vertex as it is seen: its place, and its height.
    #[inline(always)]
    fn point(&self, index: u32) -> DVec3 {
        self.origin + self.turn * self.polytope.vertices()[index as usize]
    }

    /// The corners of its face or edge, counter-clockwise as the normal looks back on them. `None` of a vertex, and of
    /// too many.
    #[inline(always)]
    fn corners(&self) -> Option<ArrayVec<(u32, DVec3), CORNERS>> {
        let mut corners = ArrayVec::new();
        let corner = |&index: &u32| (index, self.point(index));
        match self.part {
            Part::Vertex(_) => return None,
            Part::Edge(ends) => corners.extend(ends.iter().map(corner)),
            Part::Face { corners: numbers, .. } if numbers.len() > CORNERS => return None,
            Part::Face { corners: numbers, .. } => match self.is_turned {
                true => corners.extend(numbers.iter().rev().map(corner)),
                false => corners.extend(numbers.iter().map(corner)),
            },
        }
        Some(corners)
    }
}

/// Writes the manifold of two hulls of that depth; false, and nothing written, where the general way is needed: for
/// spheres, edges that are nearly parallel, and faces of many corners.
pub(super) fn write(
    known: &FoundDepth,
    [a, b]: [PosedShape<'_>; 2],
    points: &mut Points,
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
    let sides =
        [Side::of(&view, in_a, &part_a, &placed[0]), Side::of(&view, in_b, &part_b, &placed[1])];
    // The face that is more square to the normal clips: its plane is the better known.
    let number = usize::from(sides[0].facing < sides[1].facing);
    let clipping = HullClipping {
        view: &view,
        clips: &sides[number],
        clipped: &sides[1 - number],
        number,
        size,
    };
    let Some(base) = clipping.clip(points) else { return false };
    let error_bound = bound_of(depth, size, [a, b]);
    let origin = a.pose.translation();
    if !clipping.write(depth, (points, base), (origin, error_bound), writer) {
        writer.write_witnesses(depth, whole, bound_of_witnesses(depth, size, [a, b]));
    }
    true
}

/// What clips, and what is clipped.
struct HullClipping<'a> {
    view: &'a View,
    clips: &'a Side<'a>,
    clipped: &'a Side<'a>,
    /// 0 if a clips, 1 if b.
    number: usize,
    /// How large the shapes are.
    size: f64,
}

impl HullClipping<'_> {
    /// The swept radii of a and of b.
    fn radii(&self) -> [f64; 2] {
        let radii = [self.clips.polytope.swept_radius(), self.clipped.polytope.swept_radius()];
        if self.number == 0 { radii } else { [radii[1], radii[0]] }
    }

    /// Clips the one by the other: no corners of edges that cross. A corner of the face that clips; `None` where the
    /// general way is needed.
    #[inline(always)]
    fn clip(&self, points: &mut Points) -> Option<DVec3> {
        points.clear();
        let (clips, clipped) = (self.clips.corners()?, self.clipped.corners()?);
        let (clips, clipped) = (&*clips, &*clipped);
        let base = clips.first()?.1;
        if let ([p, q], [r, s]) = (clips, clipped) {
            let (e, f) = ((q.1 - p.1).truncate(), (s.1 - r.1).truncate());
            let crossing = e.perp_dot(f).abs() > CROSSING * (e.length() * f.length());
            return crossing.then_some(base);
        }
        if has_sharp_corner(clips) {
            return None;
        }
        let sense = if self.number == 0 { 1.0 } else { -1.0 };
        for (k, &(index, at)) in clipped.iter().enumerate() {
            let next = clipped[if k + 1 < clipped.len() { k + 1 } else { 0 }].0;
            let line = Line::Clipped(index, next);
            let depth = sense * (self.height(base, at.truncate()) - at.z);
            points.push(PointOf { at: [at.x, at.y], depth, line, origin: [line; 2] });
        }
        let mut from = clips.last()?;
        for to in clips {
            let (start, along) = (from.1, to.1 - from.1);
            let inside = |point: &PointOf<u32>| {
                along.x * (point.at[1] - start.y) - along.y * (point.at[0] - start.x)
            };
            points.cut(inside, Line::Clips(from.0, to.0))?;
            from = to;
        }
        let [radius_a, radius_b] = self.radii();
        points.cut(|point| point.depth + (radius_a + radius_b), Line::Surface)?;
        Some(base)
    }

    /// The height of the plane that clips above a place.
    #[inline(always)]
    fn height(&self, base: DVec3, at: DVec2) -> f64 {
        base.z + self.clips.slope.dot(at - base.truncate())
    }

    /// False, and nothing written, where no corner is as deep as the pair.
    #[inline(always)]
    fn write(
        &self,
        depth: &Depth,
        (points, base): (&Points, DVec3),
        (origin, error_bound): (DVec3, f64),
        writer: &mut impl PatchWriter,
    ) -> bool {
        let radii = self.radii();
        let mut places = [Place::default(); MOST];
        let list = points.list();
        for (number, (place, point)) in places.iter_mut().zip(list).enumerate() {
            *place = Place {
                at: DVec2::from_array(point.at),
                depth: point.depth + (radii[0] + radii[1]),
                number,
            };
        }
        let count = different(&mut places[..list.len()], self.size);
        let places = &places[..count];
        let tolerance = SAME * self.size;
        let Some((kept, count)) = reduce::to_four(places, tolerance) else { return false };
        // A depth in f32 is off the corners', which are in f64, by up to its bound.
        let short = depth.depth - places[kept[0]].depth;
        // False for NaN, which numbers near the end of their range make.
        if !(short <= tolerance + depth.error_bound) {
            return false;
        }
        let leans = |side: &Side<'_>| side.polytope.swept_radius() * (1.0 - side.level).max(0.0);
        let inside = leans(self.clips).max(leans(self.clipped));
        let shallowest = kept[..count].iter().map(|&k| places[k].depth).fold(depth.depth, f64::min);
        let off_surface = inside.min((depth.depth - shallowest).max(0.0));
        let error_bound = (error_bound + off_surface + short.abs()).min(f64::MAX);
        let corners =
            PlacedCorners { clipping: self, list, base, origin, whole: self.whole(), radii };
        let deepest = Point { depth: depth.depth, ..corners.point(&places[kept[0]], depth) };
        writer.begin(depth.normal, error_bound, deepest);
        for &k in &kept[1..count] {
            writer.push(corners.point(&places[k], depth));
        }
        true
    }

    /// What the one that clips shows, and the other.
    fn whole(&self) -> [Feature; 2] {
        [self.clips.part.name(), self.clipped.part.name()]
    }
}

/// The corners of a patch, to be written as points.
struct PlacedCorners<'a> {
    clipping: &'a HullClipping<'a>,
    list: &'a [PointOf<u32>],
    /// A corner of the face that clips.
    base: DVec3,
    /// Where the view is in the world.
    origin: DVec3,
    whole: [Feature; 2],
    radii: [f64; 2],
}

impl PlacedCorners<'_> {
    #[inline(always)]
    fn point(&self, place: &Place, depth: &Depth) -> Point {
        let Self { clipping, list, base, origin, whole, radii } = *self;
        let corner = &list[place.number];
        let height = clipping.height(base, place.at);
        let [of_clips, of_clipped] = features(corner.origin, whole);
        let (heights, features) = match clipping.number {
            0 => ([height, height - corner.depth], [of_clips, of_clipped]),
            _ => ([height + corner.depth, height], [of_clipped, of_clips]),
        };
        let heights = [heights[0] + radii[0], heights[1] - radii[1]];
        let [point_a, point_b] = clipping.view.in_world(place.at, heights);
        Point {
            point_a: point_a + origin,
            point_b: point_b + origin,
            depth: place.depth.clamp(0.0, depth.depth),
            features: features.map(FeatureCode::from),
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
        let (mut points, mut corners) = (Points::default(), Corners::default());
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
        let mut points = Points::default();
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
            let write = |farthest, points: &mut Points| {
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
