//! The first tetrahedron, made from supports alone, so that it depends on no other solver.
//!
//! A difference that is a point, a segment or flat has none. It is given one, two or three apexes
//! off its point, line or plane, and C′ = conv(C ∪ apexes) takes its place: C is a face of C′, so
//! where the origin is in C's line or plane it is in C exactly if it is in C′, and no depth but 0
//! is possible. That it *is* there needs no test: the supports that show the difference to be flat
//! are on both sides of it, and one of them separates the origin if it is off.

use super::lattice::{
    Normal, POINT_BITS, Point, Vertex, as_normal, cross, dot, length, minus, rounded, shortened,
    two_to,
};
use super::search::{Separated, Viewer};
use super::wide::Wide;
use dcd_geom::glam::DVec3;

/// Units by which the quick tetrahedron must exceed flatness at each of its corners: 2⁻²⁰ of the
/// largest coordinate there may be. Larger: more pairs pay for fourteen supports. Smaller: normals
/// of first faces that are tilted by rounding.
const FAT: f64 = (1u64 << (POINT_BITS - 20)) as f64;

/// Units within which a difference of rounded vertices counts as flat. A flat one is off its plane
/// by 8√3 units at most, its own and those of the plane's three points, which the choice of widest
/// points magnifies at most eightfold. Larger: depths of that size are reported as 0 ± themselves.
const FLAT: f64 = 128.0;

const AXES: [Point; 3] = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];

impl Viewer<'_> {
    /// Four points of the difference, or of it and its apexes, that are not in one plane.
    pub(super) fn tetrahedron(&mut self, centre: DVec3) -> Result<[Vertex; 4], Separated> {
        match self.quick(centre)? {
            Some(corners) => Ok(corners),
            None => self.thorough(),
        }
    }

    /// Each support towards the origin, as GJK would; `None` if that is not fat.
    fn quick(&mut self, centre: DVec3) -> Result<Option<[Vertex; 4]>, Separated> {
        let v0 = self.view(&towards_origin(centre))?.vertex;
        if v0.w == [0; 3] {
            return Ok(None);
        }
        let v1 = self.view(&negative(&as_normal(v0.w)))?.vertex;
        let e = minus(v1.w, v0.w);
        if length(&as_normal(e)) < FAT {
            return Ok(None);
        }
        let v2 = self.view(&from_line_to_origin(v0.w, e))?.vertex;
        let normal = cross(e, minus(v2.w, v0.w));
        if length(&normal) < FAT * length(&as_normal(e)) {
            return Ok(None);
        }
        let offset = dot(&normal, v0.w);
        let inward = if offset > Wide::ZERO { negative(&normal) } else { normal };
        let thin = FAT * length(&normal);
        for direction in [inward, negative(&inward)] {
            let support = self.view(&direction)?;
            if (support.reach - dot(&direction, v0.w)).to_f64() > thin {
                return Ok(Some([v0, v1, v2, support.vertex]));
            }
        }
        Ok(None)
    }

    /// The widest points on both sides of everything found so far: finds a tetrahedron wherever
    /// there is one, and otherwise proves the rank and adds apexes.
    pub(super) fn thorough(&mut self) -> Result<[Vertex; 4], Separated> {
        let v0 = self.view(&as_normal(AXES[0]))?.vertex;
        let axes = AXES.map(as_normal);
        let off_point = |v: &Vertex| length(&as_normal(minus(v.w, v0.w)));
        let Some(v1) = self.widest(&axes, off_point)? else {
            let apexes = AXES.map(|axis| self.apex(v0, axis));
            return Ok([v0, apexes[0], apexes[1], apexes[2]]);
        };
        let e = minus(v1.w, v0.w);
        let across = AXES.map(|axis| cross(e, axis));
        let to_distance = 1.0 / length(&as_normal(e));
        let off_line = |v: &Vertex| length(&cross(e, minus(v.w, v0.w))) * to_distance;
        let Some(v2) = self.widest(&across, off_line)? else {
            let along = longest_axis(&as_normal(e));
            let [p, q] = [1, 2].map(|k| self.apex(v0, AXES[(along + k) % 3]));
            return Ok([v0, v1, p, q]);
        };
        let normal = cross(e, minus(v2.w, v0.w));
        let to_distance = 1.0 / length(&normal);
        let off_plane = |v: &Vertex| dot(&normal, minus(v.w, v0.w)).to_f64().abs() * to_distance;
        let v3 = match self.widest(&[normal], off_plane)? {
            Some(v3) => v3,
            None => self.apex(v0, AXES[longest_axis(&normal)]),
        };
        Ok([v0, v1, v2, v3])
    }

    /// Of the supports along and against each direction the one that is farthest off, if any is
    /// off by more than rounding.
    fn widest(
        &mut self,
        directions: &[Normal],
        off: impl Fn(&Vertex) -> f64,
    ) -> Result<Option<Vertex>, Separated> {
        let mut widest = None;
        let mut distance = 0.0;
        for &direction in directions {
            for direction in [direction, negative(&direction)] {
                let vertex = self.view(&direction)?.vertex;
                if off(&vertex) > distance {
                    distance = off(&vertex);
                    widest = Some(vertex);
                }
            }
        }
        let flat = if self.difference.slack() > 0.0 { FLAT } else { 0.0 };
        Ok(widest.filter(|_| distance > flat))
    }

    /// A point half a lattice's width from `base` along an axis, as part of the difference.
    fn apex(&mut self, base: Vertex, axis: Point) -> Vertex {
        let reach = 1i128 << (POINT_BITS - 1);
        let w = [0, 1, 2].map(|k| base.w[k] + axis[k] * reach);
        self.difference.add_apex(w)
    }
}

/// The direction from the difference's rough centre to the origin; X where they are one.
fn towards_origin(centre: DVec3) -> Normal {
    let largest = centre.abs().max_element();
    // A zero or overflowed centre makes NaN, which the conversion turns into 0.
    let direction = centre.to_array().map(|x| (-x / largest * two_to(60)) as i128);
    as_normal(if direction == [0; 3] { AXES[0] } else { direction })
}

/// The direction from the line through `p` along `e` to the origin, at right angles to the line;
/// any at right angles where the origin is on it.
pub(super) fn from_line_to_origin(p: Point, e: Point) -> Normal {
    let moment = shortened(&cross(p, e), POINT_BITS as u32);
    if moment == [0; 3] {
        let shortest = (0..3).min_by_key(|&k: &usize| e[k].unsigned_abs()).unwrap_or(0);
        return cross(e, AXES[shortest]);
    }
    // e × (p × e) points from the origin's foot on the line outward.
    cross(moment, e)
}

pub(super) fn negative(n: &Normal) -> Normal {
    n.map(|x| -x)
}

fn longest_axis(n: &Normal) -> usize {
    let n = rounded(n).abs();
    (0..3).max_by(|&j, &k| n[j].total_cmp(&n[k])).unwrap_or(0)
}
