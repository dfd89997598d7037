//! What a polytope shows along a normal: a face, an edge or a vertex, seen from there.

use super::facing::Part;
use super::leaning_edge::{level_of_edge, level_of_triangles_edge};
use super::{CROSSING, Feature};
use dcd_geom::Polytope;
use dcd_geom::glam::{DMat3, DVec2, DVec3};

/// The plane that a normal looks at, and the height along it.
pub(super) struct View {
    x: DVec3,
    y: DVec3,
    normal: DVec3,
}

/// Where a shape is seen: rotated, and then moved to its place from the view's origin; it looks along the normal times
/// `sense`, which is 1 or −1.
pub(super) struct Placed<'a> {
    pub(super) rotation: &'a DMat3,
    pub(super) place: DVec3,
    pub(super) sense: f64,
}

/// A feature as it is seen.
pub(super) struct Seen<'a> {
    part: Part<'a>,
    points: Points,
    /// The cosine of the angle by which a face or an edge leans; 0 for others.
    level: f64,
    /// How square to the normal its face is, 0 where it is no face.
    facing: f64,
    /// By how much its plane rises along x and y; 0 where it is no face.
    slope: DVec2,
}

/// How many corners need no allocation.
const FEW: usize = 8;

/// The corners of a feature.
struct Points {
    few: [Point; FEW],
    many: Vec<Point>,
    count: usize,
}

/// A corner of a feature: its index, its place in the plane, its height.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Point {
    pub(super) index: u32,
    pub(super) at: DVec2,
    pub(super) height: f64,
}

impl View {
    pub(super) fn along(normal: DVec3) -> Self {
        // The other order's normal may differ in the sign of a zero, which would turn the plane.
        let (x, y) = (normal + DVec3::ZERO).any_orthonormal_pair();
        Self { x, y, normal }
    }

    /// The direction that it looks along.
    pub(super) fn normal(&self) -> DVec3 {
        self.normal
    }

    /// The place of a vector in the plane, and its height.
    pub(super) fn of(&self, v: DVec3) -> (DVec2, f64) {
        (DVec2::new(self.x.dot(v), self.y.dot(v)), self.normal.dot(v))
    }

    /// Back from the plane, at two heights.
    pub(super) fn in_world(&self, at: DVec2, heights: [f64; 2]) -> [DVec3; 2] {
        let on_plane = self.x * at.x + self.y * at.y;
        heights.map(|height| on_plane + self.normal * height)
    }

    /// The direction, in the shape's own frame, in which it shows its feature.
    #[inline(always)]
    pub(super) fn towards(&self, placed: &Placed<'_>) -> DVec3 {
        placed.rotation.transpose() * (self.normal * placed.sense)
    }

    /// What a polytope shows.
    pub(super) fn seen<'a>(&self, polytope: &'a Polytope, placed: &Placed<'_>) -> Seen<'a> {
        self.seen_part(self.part(polytope, placed), polytope, placed)
    }

    /// Which part of a polytope it shows.
    pub(super) fn part<'a>(&self, polytope: &'a Polytope, placed: &Placed<'_>) -> Part<'a> {
        Part::facing(polytope, self.towards(placed))
    }

    /// That part as it is seen.
    pub(super) fn seen_part<'a>(
        &self,
        part: Part<'a>,
        polytope: &'a Polytope,
        placed: &Placed<'_>,
    ) -> Seen<'a> {
        let vertices = polytope.vertices();
        let seen = self.shown(part, placed, |index| vertices[index as usize]);
        match part {
            Part::Edge(ends) => {
                let level = level_of_edge(polytope, ends, self.towards(placed));
                Seen { level, ..seen }
            }
            _ => seen,
        }
    }

    /// What a triangle with that radius shows, of corners in its own frame.
    pub(super) fn seen_triangle<'a>(
        &self,
        part: Part<'a>,
        placed: &Placed<'_>,
        (corners, radius): (&[DVec3; 3], f64),
    ) -> Seen<'a> {
        let seen = self.shown(part, placed, |k| corners[k as usize]);
        match part {
            Part::Edge(ends) => {
                let towards = self.towards(placed);
                Seen { level: level_of_triangles_edge(corners, ends, towards, radius), ..seen }
            }
            _ => seen,
        }
    }

    /// Turns from a shape's own frame to the view's, a vector then costs one matrix.
    pub(super) fn turn(&self, rotation: &DMat3) -> DMat3 {
        DMat3::from_cols(self.x, self.y, self.normal).transpose() * *rotation
    }

    /// A part of a shape whose vertices are in its own frame.
    pub(super) fn shown<'a>(
        &self,
        part: Part<'a>,
        placed: &Placed<'_>,
        vertex: impl Fn(u32) -> DVec3,
    ) -> Seen<'a> {
        let Placed { rotation, place, sense } = *placed;
        let to_view = self.turn(rotation);
        let origin = self.of(place);
        let point = |index: u32| {
            let v = to_view * vertex(index);
            Point { index, at: origin.0 + v.truncate(), height: origin.1 + v.z }
        };
        let (mut facing, mut slope) = (0.0, DVec2::ZERO);
        let points = match part {
            Part::Vertex(index) => Points::of(std::iter::once(point(index))),
            Part::Edge(ends) => Points::of(ends.iter().copied().map(point)),
            Part::Face { normal, corners, .. } => {
                let normal = to_view * normal;
                facing = normal.z.abs();
                slope = -normal.truncate() / normal.z;
                // One that looks against the normal goes round clockwise.
                if sense < 0.0 {
                    Points::of(corners.iter().rev().copied().map(point))
                } else {
                    Points::of(corners.iter().copied().map(point))
                }
            }
        };
        Seen { part, points, level: facing, facing, slope }
    }
}

/// Whether two edges, world axes, surely cross as they are seen along a normal.
pub(super) fn surely_cross(normal: DVec3, e: DVec3, f: DVec3) -> bool {
    cross_by(CROSSING, normal, [e, f])
}

/// The same, where the sine between them is above that.
#[inline(always)]
pub(super) fn cross_by(sine: f64, normal: DVec3, [e, f]: [DVec3; 2]) -> bool {
    // Seen from the normal they are no longer than they are. False for NaN.
    let square = normal.dot(e.cross(f));
    square * square > sine * sine * e.length_squared() * f.length_squared()
}

impl Points {
    fn of(points: impl ExactSizeIterator<Item = Point>) -> Self {
        let count = points.len();
        let (mut few, mut many) = ([Point::default(); FEW], Vec::new());
        if count > FEW {
            many.extend(points);
        } else {
            few.iter_mut().zip(points).for_each(|(slot, point)| *slot = point);
        }
        Self { few, many, count }
    }
}

impl Seen<'_> {
    /// What it is as a whole.
    pub(super) fn whole(&self) -> Feature {
        self.part.name()
    }

    /// The same, of a line of a cylinder's or cone's side: the whole shape is on one side of a plane through it.
    pub(super) fn of_line(self) -> Self {
        let [p, q] = self.points() else { return self };
        let across = p.at.distance(q.at);
        let level = across / across.hypot(p.height - q.height).max(f64::MIN_POSITIVE);
        Self { level, ..self }
    }

    /// Its corners, counter-clockwise as the normal looks back on them.
    pub(super) fn points(&self) -> &[Point] {
        let Points { few, many, count } = &self.points;
        if *count > FEW { many } else { &few[..*count] }
    }

    /// How square to the normal its face is: the cosine between the two, 0 where it is no face.
    pub(super) fn facing(&self) -> f64 {
        self.facing
    }

    /// The cosine of the angle by which a face or an edge leans, as [`level_of_edge`] has it; 0 for a vertex.
    pub(super) fn level(&self) -> f64 {
        self.level
    }

    /// The height of its face's plane above a place, or of its first corner where it is no face.
    pub(super) fn height(&self, at: DVec2) -> f64 {
        let base = self.points()[0];
        base.height + self.slope.dot(at - base.at)
    }
}
