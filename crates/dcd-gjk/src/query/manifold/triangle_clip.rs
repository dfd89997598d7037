//! The corners that a triangle has in common with a body, seen along a normal: the one clipped by the other.
//!
//! The same features and corners as the general way's, in less memory.

use super::CROSSING;
use super::Feature;
use super::clip::{Corner, has_sharp_corner, inside_of};
use super::cuboid_polygon::{LineOf, PointOf, Polygon, features};
use super::facing::{Part, edge};
use super::feature::{Placed, View};
use super::leaning_edge::{level_of_edge, level_of_triangles_edge};
use dcd_geom::Polytope;
use dcd_geom::glam::{DVec2, DVec3};
use dcd_simd::ArrayVec;

/// The most corners of what a body shows. Larger: memory. Smaller: faces of many corners that go the general way.
const CORNERS: usize = 10;

/// One more for each of four cuts, and spare ones for what rounding adds.
const MOST: usize = CORNERS + 6;

/// By the places of corners in their outlines, which are small: points are moved by every cut.
type Line = LineOf<u8>;

/// The corners of a patch of a triangle and a body.
pub(super) type Points = Polygon<u8, MOST>;

/// A face or an edge as it is seen.
pub(super) struct Outline<const MOST: usize = CORNERS> {
    /// By index, with their places and heights; counter-clockwise as the normal looks back on them.
    points: ArrayVec<(u32, DVec3), MOST>,
    leaning: Leaning,
}

/// What of it is not a corner.
#[derive(Clone, Copy)]
struct Leaning {
    whole: Feature,
    /// How square to the normal its face is, 0 where it is no face.
    facing: f64,
    /// By how much its plane rises along x and y; 0 where it is no face.
    slope: DVec2,
    /// See [`Corner::swept`].
    level: f64,
}

/// An outline, whatever it has memory for.
#[derive(Clone, Copy)]
struct Shown<'a> {
    points: &'a [(u32, DVec3)],
    leaning: Leaning,
}

impl Outline {
    /// What a body shows against the view's normal. `None` of a vertex, and of a face of many corners.
    pub(super) fn of_body(
        view: &View,
        part: &Part<'_>,
        body: &Polytope,
        placed: &Placed<'_>,
    ) -> Option<Self> {
        let turn = view.turn(placed.rotation);
        let (at, height) = view.of(placed.place);
        let origin = at.extend(height);
        let point = |index: u32| (index, origin + turn * body.vertices()[index as usize]);
        let mut outline = Self::empty(part.name());
        match part {
            Part::Vertex(_) => return None,
            &Part::Edge([j, k]) => {
                outline.points.extend([point(j), point(k)].into_iter());
                outline.leaning.level = level_of_edge(body, [j, k], view.towards(placed));
            }
            Part::Face { normal, corners, .. } => {
                if corners.len() > CORNERS {
                    return None;
                }
                // It looks against the normal, and its corners go round clockwise.
                outline.points.extend(corners.iter().rev().map(|&index| point(index)));
                outline.leaning.lean(turn * *normal);
            }
        }
        Some(outline)
    }
}

impl Outline<3> {
    /// What a triangle with that radius shows, of corners in world axes. `None` of a vertex.
    fn of_triangle(
        view: &View,
        part: &Part<'_>,
        (triangle, radius): (&[DVec3; 3], f64),
    ) -> Option<Self> {
        let point = |index: u32| {
            let (at, height) = view.of(triangle[index as usize]);
            (index, at.extend(height))
        };
        let mut outline = Self::empty(part.name());
        match part {
            Part::Vertex(_) => return None,
            &Part::Edge([j, k]) => {
                outline.points.extend([point(j), point(k)].into_iter());
                outline.leaning.level =
                    level_of_triangles_edge(triangle, [j, k], view.normal(), radius);
            }
            Part::Face { normal, corners, .. } => {
                outline.points.extend(corners.iter().map(|&index| point(index)));
                let (rise, cosine) = view.of(*normal);
                outline.leaning.lean(rise.extend(cosine));
            }
        }
        Some(outline)
    }
}

impl<const MOST: usize> Outline<MOST> {
    fn empty(whole: Feature) -> Self {
        let leaning = Leaning { whole, facing: 0.0, slope: DVec2::ZERO, level: 0.0 };
        Self { points: ArrayVec::new(), leaning }
    }

    fn shown(&self) -> Shown<'_> {
        Shown { points: &self.points, leaning: self.leaning }
    }
}

impl Leaning {
    /// By a face's normal as it is seen.
    fn lean(&mut self, normal: DVec3) {
        self.facing = normal.z.abs();
        self.level = self.facing;
        self.slope = -normal.truncate() / normal.z;
    }
}

impl Shown<'_> {
    /// The height of its plane over a place.
    #[inline(always)]
    fn height(&self, at: DVec2) -> f64 {
        let base = self.points[0].1;
        base.z + self.leaning.slope.dot(at - base.truncate())
    }

    /// A feature of it whose corners are numbered by their places; what is no corner and no edge of it is the whole.
    #[inline(always)]
    fn named(&self, feature: Feature) -> Feature {
        let index = |place: u32| self.points[place as usize].0;
        match feature {
            Feature::Vertex(place) => Feature::Vertex(index(place)),
            Feature::Edge(j, k) => edge(index(j), index(k)),
            _ => self.leaning.whole,
        }
    }
}

/// Adds what a triangle that shows that and a body have in common, the radii of both counted, unless it is deeper than
/// `most` anywhere. `None` where the general way is needed: for edges that are nearly parallel.
pub(super) fn add(
    (view, radii, most): (&View, [f64; 2], f64),
    (part, triangle): (&Part<'_>, &[DVec3; 3]),
    body: &Outline,
    points: &mut Points,
    corners: &mut Vec<Corner>,
) -> Option<()> {
    let Some(triangle) = Outline::of_triangle(view, part, (triangle, radii[0])) else {
        return Some(());
    };
    let (triangle, body) = (triangle.shown(), body.shown());
    // The face that is more square to the normal clips: its plane is the better known.
    let number = usize::from(triangle.leaning.facing < body.leaning.facing);
    let (clips, clipped) = if number == 0 { (triangle, body) } else { (body, triangle) };
    if let ([p, q], [r, s]) = (clips.points, clipped.points) {
        let (e, f) = ((q.1 - p.1).truncate(), (s.1 - r.1).truncate());
        return (e.perp_dot(f).abs() > CROSSING * (e.length() * f.length())).then_some(());
    }
    let radius = radii[0] + radii[1];
    clip(number, [clips, clipped], radius, points)?;
    // Written so that NaN is no corner.
    if !points.list().iter().all(|point| point.depth + radius <= most) {
        return Some(());
    }
    let inside = inside_of(radii, [triangle.leaning.level, body.leaning.level]);
    corners.extend(points.list().iter().map(|point: &PointOf<u8>| {
        let at = DVec2::from_array(point.at);
        let height = clips.height(at);
        let [of_clips, of_clipped] = features(point.origin, [Feature::Surface; 2]);
        let (of_clips, of_clipped) = (clips.named(of_clips), clipped.named(of_clipped));
        let (heights, features) = match number {
            0 => ([height, height - point.depth], [of_clips, of_clipped]),
            _ => ([height + point.depth, height], [of_clipped, of_clips]),
        };
        let heights = [heights[0] + radii[0], heights[1] - radii[1]];
        Corner::new(at, heights, features).inside(inside)
    }));
    Some(())
}

/// Clips the second by the first, a face; `number` is 0 if this is the triangle's.
fn clip(
    number: usize,
    [clips, clipped]: [Shown<'_>; 2],
    radius: f64,
    points: &mut Points,
) -> Option<()> {
    points.clear();
    if has_sharp_corner(clips.points) {
        return None;
    }
    let sense = if number == 0 { 1.0 } else { -1.0 };
    let last = clipped.points.len() - 1;
    for (k, &(_, at)) in clipped.points.iter().enumerate() {
        let next = if k < last { k + 1 } else { 0 };
        let line = Line::Clipped(k as u8, next as u8);
        let depth = sense * (clips.height(at.truncate()) - at.z);
        points.push(PointOf { at: [at.x, at.y], depth, line, origin: [line; 2] });
    }
    let last = clips.points.len() - 1;
    let mut from = (last, clips.points[last].1);
    for (k, &(_, to)) in clips.points.iter().enumerate() {
        let (start, along) = (from.1, to - from.1);
        let inside = |point: &PointOf<u8>| {
            along.x * (point.at[1] - start.y) - along.y * (point.at[0] - start.x)
        };
        points.cut(inside, Line::Clips(from.0 as u8, k as u8))?;
        from = (k, to);
    }
    points.cut(|point| point.depth + radius, Line::Surface)
}

#[cfg(test)]
mod tests;
