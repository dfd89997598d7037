//! The outlines of what two shapes show each other, seen along a normal, and what they have in common: the one clipped by
//! the other.
//!
//! The same corners and features as the general way's ([`super::clip`]), in less memory.

use super::clip::has_sharp_corner;
use super::facing::{Part, edge};
use super::feature::{Placed, View};
use super::leaning_edge::{level_of_edge, level_of_triangles_edge};
use super::polygon::{Polygon, PolygonCorner, PolygonLine, features};
use super::{CROSSING, Feature};
use dcd_geom::Polytope;
use dcd_geom::glam::{DVec2, DVec3};
use dcd_simd::ArrayVec;

/// The most corners of a face. Larger: memory. Smaller: faces of many corners that go the general way.
pub(super) const CORNERS: usize = 10;

/// A face or an edge as it is seen.
pub(super) struct Outline<const MOST: usize = CORNERS> {
    /// By index, with their places and heights; counter-clockwise as the normal looks back on them.
    corners: ArrayVec<(u32, DVec3), MOST>,
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
    /// The cosine of the angle by which it leans.
    level: f64,
}

/// An outline, whatever it has memory for.
#[derive(Clone, Copy)]
pub(super) struct Shown<'a> {
    corners: &'a [(u32, DVec3)],
    leaning: Leaning,
}

impl Outline {
    /// What a polytope shows. `None` of a vertex, and of a face of many corners.
    #[inline(always)]
    pub(super) fn of(
        view: &View,
        part: &Part<'_>,
        polytope: &Polytope,
        placed: &Placed<'_>,
    ) -> Option<Self> {
        let turn = view.turn(placed.rotation);
        let (at, height) = view.of(placed.place);
        let origin = at.extend(height);
        let corner = |&index: &u32| (index, origin + turn * polytope.vertices()[index as usize]);
        let mut outline = Self::empty(part.name());
        match part {
            Part::Vertex(_) => return None,
            Part::Edge(ends) => {
                outline.corners.extend(ends.iter().map(corner));
                outline.leaning.level = level_of_edge(polytope, *ends, view.towards(placed));
            }
            Part::Face { corners, .. } if corners.len() > CORNERS => return None,
            Part::Face { normal, corners, .. } => {
                // Those of one that looks against the normal go round clockwise.
                match placed.sense < 0.0 {
                    true => outline.corners.extend(corners.iter().rev().map(corner)),
                    false => outline.corners.extend(corners.iter().map(corner)),
                }
                outline.leaning.lean(turn * *normal);
            }
        }
        Some(outline)
    }
}

impl Outline<3> {
    /// What a triangle with that radius shows, of corners in world axes. `None` of a vertex.
    pub(super) fn of_triangle(
        view: &View,
        part: &Part<'_>,
        (triangle, radius): (&[DVec3; 3], f64),
    ) -> Option<Self> {
        let corner = |&index: &u32| {
            let (at, height) = view.of(triangle[index as usize]);
            (index, at.extend(height))
        };
        let mut outline = Self::empty(part.name());
        match part {
            Part::Vertex(_) => return None,
            Part::Edge(ends) => {
                outline.corners.extend(ends.iter().map(corner));
                outline.leaning.level =
                    level_of_triangles_edge(triangle, *ends, view.normal(), radius);
            }
            Part::Face { normal, corners, .. } => {
                outline.corners.extend(corners.iter().map(corner));
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
        Self { corners: ArrayVec::new(), leaning }
    }

    pub(super) fn shown(&self) -> Shown<'_> {
        Shown { corners: &self.corners, leaning: self.leaning }
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
        let base = self.corners[0].1;
        base.z + self.leaning.slope.dot(at - base.truncate())
    }

    /// A feature of it whose corners are numbered by their places; what is no corner and no edge of it is the whole.
    #[inline(always)]
    fn named(&self, feature: Feature) -> Feature {
        let index = |place: u32| self.corners[place as usize].0;
        match feature {
            Feature::Vertex(place) => Feature::Vertex(index(place)),
            Feature::Edge(j, k) => edge(index(j), index(k)),
            _ => self.leaning.whole,
        }
    }

    /// How far inside the surface of what is swept by that radius its points may be that are swept along the normal: metres.
    fn inside(&self, radius: f64) -> f64 {
        radius * (1.0 - self.leaning.level).max(0.0)
    }
}

/// The outlines of a and b with their swept radii, of which one clips the other.
pub(super) struct Outlines<'a> {
    clips: Shown<'a>,
    clipped: Shown<'a>,
    /// 0 if a clips, 1 if b.
    number: usize,
    radii: [f64; 2],
}

impl<'a> Outlines<'a> {
    /// The face that is more square to the normal clips: its plane is the better known.
    pub(super) fn of([a, b]: [Shown<'a>; 2], radii: [f64; 2]) -> Self {
        let number = usize::from(a.leaning.facing < b.leaning.facing);
        let [clips, clipped] = if number == 0 { [a, b] } else { [b, a] };
        Self { clips, clipped, number, radii }
    }

    /// Both radii.
    pub(super) fn radius(&self) -> f64 {
        self.radii[0] + self.radii[1]
    }

    /// How far inside the swept surfaces points may be: metres.
    pub(super) fn inside(&self) -> f64 {
        let [of_clips, of_clipped] =
            if self.number == 0 { self.radii } else { [self.radii[1], self.radii[0]] };
        self.clips.inside(of_clips).max(self.clipped.inside(of_clipped))
    }

    /// What the two have in common, their depths without the radii: nothing of edges that cross. `None` where the general way
    /// is needed.
    #[inline(always)]
    pub(super) fn clip<const MOST: usize>(&self, polygon: &mut Polygon<MOST>) -> Option<()> {
        polygon.clear();
        let (clips, clipped) = (self.clips.corners, self.clipped.corners);
        if let ([p, q], [r, s]) = (clips, clipped) {
            let (e, f) = ((q.1 - p.1).truncate(), (s.1 - r.1).truncate());
            let crosses = e.perp_dot(f).abs() > CROSSING * (e.length() * f.length());
            return crosses.then_some(());
        }
        if has_sharp_corner(clips) {
            return None;
        }
        let sense = if self.number == 0 { 1.0 } else { -1.0 };
        for (k, &(_, at)) in clipped.iter().enumerate() {
            let next = if k + 1 < clipped.len() { k + 1 } else { 0 };
            let line = PolygonLine::Clipped(k as u8, next as u8);
            let depth = sense * (self.clips.height(at.truncate()) - at.z);
            polygon.push(PolygonCorner { at: [at.x, at.y], depth, line, origin: [line; 2] });
        }
        let last = clips.len() - 1;
        let mut from = (last, clips[last].1);
        for (k, &(_, to)) in clips.iter().enumerate() {
            let (start, along) = (from.1, to - from.1);
            let inside = |corner: &PolygonCorner| {
                along.x * (corner.at[1] - start.y) - along.y * (corner.at[0] - start.x)
            };
            polygon.cut(inside, PolygonLine::Clips(from.0 as u8, k as u8))?;
            from = (k, to);
        }
        let radius = self.radius();
        polygon.cut(|corner| corner.depth + radius, PolygonLine::Surface)
    }

    /// The heights of a and of b at a corner, with the radii.
    #[inline(always)]
    pub(super) fn heights(&self, corner: &PolygonCorner) -> [f64; 2] {
        let height = self.clips.height(DVec2::from_array(corner.at));
        let [a, b] = match self.number {
            0 => [height, height - corner.depth],
            _ => [height + corner.depth, height],
        };
        [a + self.radii[0], b - self.radii[1]]
    }

    /// What of a and of b a corner belongs to.
    #[inline(always)]
    pub(super) fn features(&self, corner: &PolygonCorner) -> [Feature; 2] {
        let [of_clips, of_clipped] = features(corner.origin, [Feature::Surface; 2]);
        let [clips, clipped] = [self.clips.named(of_clips), self.clipped.named(of_clipped)];
        if self.number == 0 { [clips, clipped] } else { [clipped, clips] }
    }
}
