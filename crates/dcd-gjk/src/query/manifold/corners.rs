//! The corners of what two shapes, or many parts of them, have in common along one normal.

use super::clip::{Corner, Patch, drop_doubles};
use super::cuboids::CuboidPolygon;
use super::facing::{Part, name};
use super::feature::{Placed, Seen, View, surely_cross};
use super::hull_pair::HullPolygon;
use super::outline::Outline;
use super::reduce::Spot;
use super::triangle_clip::{self, TrianglePolygon};
use super::{
    Feature, Manifold, ManifoldPoint, SAME, bound_of, bound_of_witnesses, reduce, uneven_by,
    unevenness, write_one_point,
};
use super::{cuboids, on_plane};
use crate::PosedShape;
use crate::closed::is_sphere;
use crate::epa::Depth;
use dcd_geom::glam::{DMat3, DVec2, DVec3};
use dcd_geom::{Kind, Polytope, Shape, SupportMap};
use std::cell::OnceCell;

/// Of more corners than these doubles are kept: what looks for them compares each with all, and of many corners the four are
/// apart without it. Larger: objects with thousands of parts or triangles in one patch that take seconds. Not below 4.
const DOUBLES: usize = 64;

/// Corners with heights that count the swept radii; memory that clipping takes.
#[derive(Debug, Default)]
pub(super) struct Corners {
    corners: Vec<Corner>,
    patch: Patch,
    pub(super) of_cuboids: CuboidPolygon,
    pub(super) of_hulls: HullPolygon,
    of_triangles: TrianglePolygon,
    /// How large the shapes are.
    size: f64,
    /// How far corners may be off, and short of the depth, for faces that are not flat: metres.
    uneven: f64,
    /// How large the parts are, whether they have features to be seen or none.
    noted: f64,
}

impl Corners {
    /// Notes how large two parts are: of those without features, as curved ones, the witnesses alone are corners.
    pub(super) fn note(&mut self, sides: [PosedShape<'_>; 2]) {
        let bounded = sides.iter().filter(|side| side.shape.is_bounded());
        self.noted = self.noted.max(bounded.map(|side| 2.0 * side.shape.reach()).sum());
    }

    pub(super) fn clear(&mut self) {
        self.corners.clear();
        (self.size, self.uneven, self.noted) = (0.0, 0.0, 0.0);
    }

    pub(super) fn len(&self) -> usize {
        self.corners.len()
    }

    /// The depth of the deepest corner behind the first so many.
    fn deepest_after(&self, count: usize) -> f64 {
        self.corners[count..].iter().map(Corner::depth).fold(f64::NEG_INFINITY, f64::max)
    }

    /// How deep a corner of a manifold of that depth may be: a depth in f32 is off the corners', which are in f64, by up to its
    /// bound.
    fn deepest_of(&self, depth: &Depth) -> f64 {
        depth.depth + self.tolerance() + depth.error_bound
    }

    /// Takes the corners behind the first so many away if one is deeper than those of a manifold of that depth: such parts meet
    /// along another normal.
    pub(super) fn drop_if_deeper(&mut self, count: usize, depth: &Depth) {
        if self.deepest_after(count) > self.deepest_of(depth) {
            self.corners.truncate(count);
        }
    }

    /// How large the shapes are whose corners these are: metres.
    pub(super) fn size(&self) -> f64 {
        self.size
    }

    /// What is lost by faces that are not flat.
    pub(super) fn tolerance(&self) -> f64 {
        SAME * self.size + self.uneven
    }

    /// The witnesses of a depth, whose normal may be another than the view's: off the surfaces by no more than its bound, and
    /// what they lack of the depth.
    pub(super) fn add_witness(&mut self, view: &View, depth: &Depth, origin: DVec3) {
        let ((at, height_a), (at_b, height_b)) =
            (view.of(depth.point_a - origin), view.of(depth.point_b - origin));
        let mut corner = Corner::new(at, [height_a, height_b], [Feature::Surface; 2]);
        corner.beside = at.distance(at_b) + depth.missed() + depth.error_bound;
        self.corners.push(corner);
    }

    /// Moves the corners behind the first so many: in the plane, and along the normal.
    pub(super) fn shift(&mut self, count: usize, (by, height): (DVec2, f64)) {
        for corner in &mut self.corners[count..] {
            corner.at += by;
            corner.heights = [corner.heights[0] + height, corner.heights[1] + height];
        }
    }

    /// Says of which pair of parts the corners behind the first so many are.
    pub(super) fn are_of(&mut self, pair: u32, count: usize) {
        self.corners[count..].iter_mut().for_each(|corner| corner.pair = pair);
    }

    /// Adds the corners of two convex shapes: none where they have no features to be seen. Returns what they
    /// show as wholes.
    ///
    /// World axes, counted from the first shape's origin: what is far from the world's is none the worse.
    pub(super) fn add(
        &mut self,
        view: &View,
        depth: &Depth,
        sides: [PosedShape<'_>; 2],
    ) -> [Feature; 2] {
        if let Some(patch) = cuboids::add(&mut self.corners, &mut self.of_cuboids, view, sides) {
            self.size = self.size.max(patch.size);
            return patch.whole;
        }
        let [a, b] = sides;
        self.uneven = self.uneven.max(unevenness([a.shape, b.shape]));
        if let Some(of_sphere) = of_sphere(view.normal(), sides, None) {
            self.size = self.size.max(of_sphere.size);
            return of_sphere.features;
        }
        let delta = b.pose.translation() - a.pose.translation();
        let placed = [
            Placed { rotation: a.pose.rotation(), place: DVec3::ZERO, sense: 1.0 },
            Placed { rotation: b.pose.rotation(), place: delta, sense: -1.0 },
        ];
        if let (Shape::Polytope(in_a), Shape::Polytope(in_b)) = (a.shape, b.shape) {
            return self.add_polytopes(view, [in_a, in_b], &placed);
        }
        let plane = |point: DVec3| view.of(point - a.pose.translation()).1;
        let [in_a, in_b] = &placed;
        match (a.shape, b.shape) {
            (shape, Shape::HalfSpace(_)) => {
                let Some(seen) = seen(view, shape, in_a) else { return [Feature::Surface; 2] };
                self.size = self.size.max(2.0 * size(shape));
                self.on_plane(&seen, shape.radius(), plane(depth.point_b), 0);
                [seen.whole(), Feature::Surface]
            }
            (Shape::HalfSpace(_), shape) => {
                let Some(seen) = seen(view, shape, in_b) else { return [Feature::Surface; 2] };
                self.size = self.size.max(2.0 * size(shape));
                self.on_plane(&seen, shape.radius(), plane(depth.point_a), 1);
                [Feature::Surface, seen.whole()]
            }
            (in_a_shape, in_b_shape) => {
                let Some(seen_a) = seen(view, in_a_shape, in_a) else {
                    return [Feature::Surface; 2];
                };
                let Some(seen_b) = seen(view, in_b_shape, in_b) else {
                    return [Feature::Surface; 2];
                };
                self.size = self.size.max(2.0 * (size(a.shape) + size(b.shape)));
                self.add_shared(&seen_a, &seen_b, [a.shape.radius(), b.shape.radius()]);
                let is_own = |shape: &Shape, whole| {
                    if shape.as_polytope().is_some() { whole } else { Feature::Surface }
                };
                [is_own(a.shape, seen_a.whole()), is_own(b.shape, seen_b.whole())]
            }
        }
    }

    /// The same of a half-space and a shape on it, in fewer steps where that shows few corners.
    pub(super) fn add_on_plane(
        &mut self,
        view: &View,
        depth: &Depth,
        sides: [PosedShape<'_>; 2],
    ) -> [Feature; 2] {
        match on_plane::add(view, depth, sides, &mut self.corners) {
            Some((whole, size)) => {
                self.size = self.size.max(size);
                whole
            }
            None => self.add(view, depth, sides),
        }
    }

    /// The same of two polytopes: most share a vertex or the crossing of two edges, which need not be seen.
    fn add_polytopes(
        &mut self,
        view: &View,
        polytopes: [&Polytope; 2],
        placed: &[Placed<'_>; 2],
    ) -> [Feature; 2] {
        let [a, b] = polytopes;
        self.size = self.size.max(2.0 * (a.outer_radius() + b.outer_radius()));
        let parts = [view.part(a, &placed[0]), view.part(b, &placed[1])];
        let whole = parts.each_ref().map(Part::name);
        if !share_no_corners(
            view.normal(),
            parts.each_ref(),
            polytopes,
            [&placed[0], &placed[1]].map(|placed| placed.rotation),
        ) {
            let [of_a, of_b] = parts;
            let (seen_a, seen_b) =
                (view.seen_part(of_a, a, &placed[0]), view.seen_part(of_b, b, &placed[1]));
            self.add_shared(&seen_a, &seen_b, [a.swept_radius(), b.swept_radius()]);
        }
        whole
    }

    /// The same of two triangles with their radii, of corners in world axes: none becomes a shape. `None` of a needle.
    pub(super) fn add_triangles(
        &mut self,
        view: &View,
        triangles: [&([DVec3; 3], f64); 2],
    ) -> Option<[Feature; 2]> {
        let [(of_a, radius_a), (of_b, radius_b)] = triangles;
        let part_a = Part::of_triangle(*of_a, view.normal())?;
        let part_b = Part::of_triangle(*of_b, -view.normal())?;
        self.size = self.size.max(2.0 * (outer_radius(of_a) + outer_radius(of_b)));
        let whole = [part_a.name(), part_b.name()];
        let edge =
            |corners: &[DVec3; 3], [j, k]: [u32; 2]| corners[k as usize] - corners[j as usize];
        let share_none = match (&part_a, &part_b) {
            (Part::Vertex(_), _) | (_, Part::Vertex(_)) => true,
            (Part::Edge(in_a), Part::Edge(in_b)) => {
                surely_cross(view.normal(), edge(of_a, *in_a), edge(of_b, *in_b))
            }
            _ => false,
        };
        if !share_none {
            let placed = |sense| Placed { rotation: &DMat3::IDENTITY, place: DVec3::ZERO, sense };
            let seen_a = view.seen_triangle(part_a, &placed(1.0), (of_a, *radius_a));
            let seen_b = view.seen_triangle(part_b, &placed(-1.0), (of_b, *radius_b));
            self.add_shared(&seen_a, &seen_b, [*radius_a, *radius_b]);
        }
        Some(whole)
    }

    /// What a polytope shows along the view, that part, for [`Corners::add_triangle`].
    pub(super) fn facing<'a>(
        view: &View,
        part: Part<'a>,
        polytope: &'a Polytope,
        placed: Placed<'a>,
    ) -> Facing<'a> {
        // Written where it is kept.
        Facing {
            outline: Outline::of(view, &part, polytope, &placed),
            whole: part.name(),
            has_corners: !matches!(part, Part::Vertex(_)),
            is_round: polytope.kind() == Kind::Point,
            part,
            seen: OnceCell::new(),
            polytope,
            placed,
        }
    }

    /// Adds the corners that a triangle shares with that, unless they are deeper than the depth: such parts meet along
    /// another normal. Returns what the two show as wholes; `None` of a needle.
    pub(super) fn add_triangle(
        &mut self,
        view: &View,
        (depth, radii): (&Depth, [f64; 2]),
        corners: &[DVec3; 3],
        facing: &Facing<'_>,
    ) -> Option<[Feature; 2]> {
        let part = Part::of_triangle(*corners, view.normal())?;
        self.size = self.size.max(size_with_triangle(corners, facing.polytope));
        self.uneven = self.uneven.max(uneven_by(facing.polytope));
        let whole = [part.name(), facing.whole];
        if !facing.has_corners {
            return Some(whole);
        }
        let most = self.deepest_of(depth);
        let added = facing.outline.as_ref().and_then(|body| {
            let (points, corners_found) = (&mut self.of_triangles, &mut self.corners);
            let how = (view, radii, most);
            triangle_clip::add(how, (&part, corners), body, points, corners_found)
        });
        if added.is_none() {
            let before = self.len();
            let placed = Placed { rotation: &DMat3::IDENTITY, place: DVec3::ZERO, sense: 1.0 };
            let triangle = view.seen_triangle(part, &placed, (corners, radii[0]));
            self.add_shared(&triangle, facing.seen(view), radii);
            self.drop_if_deeper(before, depth);
        }
        Some(whole)
    }

    /// What two features have in common, of shapes with those swept radii.
    fn add_shared(&mut self, a: &Seen<'_>, b: &Seen<'_>, radii: [f64; 2]) {
        self.patch.of(a, b, -(radii[0] + radii[1]), self.size);
        let level = [a.level(), b.level()];
        let swept = self.patch.corners().iter().map(|&corner| corner.swept(radii, level));
        self.corners.extend(swept);
    }

    /// The corners of a feature that are in a half-space, whose plane is level and at `height`; `number` is the
    /// shape's, 0 or 1.
    fn on_plane(&mut self, seen: &Seen<'_>, radius: f64, height: f64, number: usize) {
        for point in seen.points() {
            let mut heights = [height; 2];
            heights[number] = point.height;
            let mut radii = [0.0; 2];
            radii[number] = radius;
            let mut features = [Feature::Surface; 2];
            features[number] = Feature::Vertex(point.index);
            let corner = Corner::new(point.at, heights, features).swept(radii, [seen.level(); 2]);
            if corner.depth() >= 0.0 {
                self.corners.push(corner);
            }
        }
    }

    /// Writes up to four of the corners over an empty manifold; the witnesses of the depth where none is as deep. Returns
    /// the pair of each point, which is not known of such witnesses.
    pub(super) fn write(
        &mut self,
        view: &View,
        depth: &Depth,
        [a, b]: [PosedShape<'_>; 2],
        features: [Feature; 2],
        found: &mut Manifold,
    ) -> [Option<u32>; 4] {
        let mut pairs = [None; 4];
        if self.size == 0.0 && self.corners.len() > 1 {
            // Several parts, none with features to be seen: each has its witnesses.
            self.size = self.noted;
        }
        if self.size == 0.0 {
            write_one_point(depth, features, found);
            found.error_bound = (bound_of(depth, 0.0, [a, b]) + depth.missed()).min(f64::MAX);
            return pairs;
        }
        if self.corners.len() <= DOUBLES {
            drop_doubles(&mut self.corners, self.size);
        }
        let error_bound = bound_of(depth, self.size, [a, b]);
        // A depth in f32 is off the corners', which are in f64, by up to its bound.
        let short = depth.depth - self.deepest_after(0);
        // False for NaN, which numbers near the end of their range make.
        let stands_for_all = short <= self.tolerance() + depth.error_bound;
        let kept = reduce::to_four(&self.corners, self.tolerance()).filter(|_| stands_for_all);
        let Some((kept, count)) = kept else {
            write_one_point(depth, features, found);
            found.error_bound = bound_of_witnesses(depth, self.size, [a, b]);
            return pairs;
        };
        let mut off_surface = 0.0f64;
        let origin = a.pose.translation();
        for (pair, &k) in pairs.iter_mut().zip(&kept[..count]) {
            let corner = &self.corners[k];
            *pair = Some(corner.pair);
            let above = (corner.depth() - depth.depth).max(0.0);
            off_surface = off_surface.max(corner.off_surface(depth.depth) + above);
            let [point_a, point_b] = view.in_world(corner.at, corner.heights);
            found.points.push(ManifoldPoint {
                point_a: point_a + origin,
                point_b: point_b + origin,
                depth: corner.depth().clamp(0.0, depth.depth),
                features: corner.features,
                parts: [None; 2],
            });
        }
        found.points[0].depth = depth.depth;
        found.normal = depth.normal;
        let lost = off_surface + short.max(0.0) + self.uneven;
        found.error_bound = (error_bound + lost).min(f64::MAX);
        pairs
    }
}

/// What a polytope shows along a normal.
pub(super) struct Facing<'a> {
    whole: Feature,
    /// False of a vertex, which shares none.
    has_corners: bool,
    /// `None` also where the general way is needed.
    outline: Option<Outline>,
    is_round: bool,
    part: Part<'a>,
    /// What it shows, once that is needed.
    seen: OnceCell<Seen<'a>>,
    polytope: &'a Polytope,
    placed: Placed<'a>,
}

impl<'a> Facing<'a> {
    /// What it shows along the view of which it was made.
    fn seen(&self, view: &View) -> &Seen<'a> {
        self.seen.get_or_init(|| view.seen_part(self.part, self.polytope, &self.placed))
    }

    /// Whether it is a sphere, which has no face and no edge.
    pub(super) fn is_round(&self) -> bool {
        self.is_round
    }
}

/// How large a triangle and a polytope are.
pub(super) fn size_with_triangle(corners: &[DVec3; 3], polytope: &Polytope) -> f64 {
    2.0 * (outer_radius(corners) + polytope.outer_radius())
}

/// How far a triangle's corners are from their middle.
fn outer_radius(&[p, q, r]: &[DVec3; 3]) -> f64 {
    let middle = (p + q + r) / 3.0;
    let square = |corner: DVec3| corner.distance_squared(middle);
    square(p).max(square(q)).max(square(r)).sqrt()
}

/// What a sphere and another shape show as wholes: a point shares no corners with anything but a half-space.
pub(super) struct OfSphere {
    pub(super) features: [Feature; 2],
    /// How large the shapes are.
    pub(super) size: f64,
}

/// `None` where neither is a sphere, and against half-spaces and foreign shapes. Where the sphere is from the other shape may
/// be known in that one's frame, of unit length.
#[inline(always)]
pub(super) fn of_sphere(
    normal: DVec3,
    [a, b]: [PosedShape<'_>; 2],
    outward: Option<DVec3>,
) -> Option<OfSphere> {
    let (other, towards) = match [is_sphere(a), is_sphere(b)] {
        [true, _] => (b, -normal),
        [false, true] => (a, normal),
        [false, false] => return None,
    };
    let own = match other.shape {
        Shape::Polytope(polytope) => {
            let turned = || other.pose.rotation().transpose() * towards;
            name(polytope, outward.unwrap_or_else(turned))
        }
        Shape::Curved(_) => Feature::Surface,
        _ => return None,
    };
    let sphere = Feature::Vertex(0);
    let features = if is_sphere(a) { [sphere, own] } else { [own, sphere] };
    Some(OfSphere { features, size: 2.0 * (size(a.shape) + size(b.shape)) })
}

/// Whether two parts surely have no corners in common: a vertex shares none, nor do edges that cross.
pub(super) fn share_no_corners(
    normal: DVec3,
    parts: [&Part<'_>; 2],
    polytopes: [&Polytope; 2],
    rotations: [&DMat3; 2],
) -> bool {
    match parts {
        [Part::Vertex(_), _] | [_, Part::Vertex(_)] => true,
        [Part::Edge(of_a), Part::Edge(of_b)] => {
            let edge = |number: usize, [j, k]: [u32; 2]| {
                let vertices = polytopes[number].vertices();
                *rotations[number] * (vertices[k as usize] - vertices[j as usize])
            };
            surely_cross(normal, edge(0, *of_a), edge(1, *of_b))
        }
        _ => false,
    }
}

/// What a shape shows; `None` for one that has no features.
fn seen<'a>(view: &View, shape: &'a Shape, placed: &Placed<'_>) -> Option<Seen<'a>> {
    match shape {
        Shape::Polytope(polytope) => Some(view.seen(polytope, placed)),
        Shape::Curved(curved) => Some(view.seen_curved(curved, placed)),
        _ => None,
    }
}

/// How large the core of a shape with features is.
fn size(shape: &Shape) -> f64 {
    match shape {
        Shape::Polytope(polytope) => polytope.outer_radius(),
        Shape::Curved(curved) => curved.reach(),
        _ => 0.0,
    }
}
