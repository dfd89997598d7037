//! The triangle of corners that a search for a face moves outward.

use super::Corner;
use dcd_geom::glam::{BVec3A, Vec3, Vec3A, Vec3Swizzles};

/// Three corners, their coordinates side by side: one goes for another without a branch, which no predictor would know,
/// and without a way through memory.
pub(super) struct Triangle {
    x: Vec3A,
    y: Vec3A,
    z: Vec3A,
    /// The numbers of their vertices, as bits of f32, which no operation reads as such.
    vertices: [Vec3A; 2],
}

impl Triangle {
    #[inline(always)]
    pub(super) fn of([p, q, r]: &[Corner; 3]) -> Self {
        let of = |side: usize| {
            let [p, q, r] = [p, q, r].map(|corner| f32::from_bits(corner.vertices[side]));
            Vec3A::new(p, q, r)
        };
        Self {
            x: Vec3A::new(p.w.x, q.w.x, r.w.x),
            y: Vec3A::new(p.w.y, q.w.y, r.w.y),
            z: Vec3A::new(p.w.z, q.w.z, r.w.z),
            vertices: [of(0), of(1)],
        }
    }

    /// They themselves.
    #[inline(always)]
    pub(super) fn corners(&self) -> [Corner; 3] {
        let [x, y, z] = [self.x, self.y, self.z].map(|coordinate| coordinate.to_array());
        let [of_a, of_b] = self.vertices.map(|of| of.to_array());
        let corner = |k: usize| Corner {
            w: Vec3::new(x[k], y[k], z[k]),
            vertices: [of_a[k].to_bits(), of_b[k].to_bits()],
        };
        [corner(0), corner(1), corner(2)]
    }

    /// The first corner's place.
    pub(super) fn first(&self) -> Vec3 {
        Vec3::new(self.x.x, self.y.x, self.z.x)
    }

    /// (r − p) × (q − p).
    #[inline(always)]
    pub(super) fn normal(&self) -> Vec3 {
        // Each corner less the next one: p − q, q − r.
        let edges = |of: Vec3A| of - of.yzx();
        let (x, y, z) = (edges(self.x), edges(self.y), edges(self.z));
        // (q − r) × (p − q), in the first lane.
        let across = |u: Vec3A, v: Vec3A| (u.yzx() * v - v.yzx() * u).x;
        Vec3::new(across(y, z), across(z, x), across(x, y))
    }

    /// Whether one of them is that one.
    #[inline(always)]
    pub(super) fn has(&self, corner: &Corner) -> bool {
        let [of_a, of_b] = self.vertices.map(|of| of.to_array());
        let is = |k: usize| [of_a[k].to_bits(), of_b[k].to_bits()] == corner.vertices;
        is(0) | is(1) | is(2)
    }

    /// Which of them goes when another comes between them: as seen from that one, the line is between the last on its
    /// left and the first on its right, and the third goes. None where all are on one side.
    #[inline(always)]
    pub(super) fn dropped_for(&self, corner: &Corner) -> BVec3A {
        let side = self.y * corner.w.x - self.x * corner.w.y;
        // Corner k goes where k + 1 is on the left and k + 2 is not, counted round.
        let (left, right) = (side.yzx(), side.zxy());
        left.cmpge(Vec3A::ZERO) & right.cmplt(Vec3A::ZERO)
    }

    /// Puts a corner in the place of those of a mask.
    #[inline(always)]
    pub(super) fn exchange(&mut self, which: BVec3A, corner: &Corner) {
        let put = |to: &mut Vec3A, one: f32| *to = Vec3A::select(which, Vec3A::splat(one), *to);
        put(&mut self.x, corner.w.x);
        put(&mut self.y, corner.w.y);
        put(&mut self.z, corner.w.z);
        for (to, &number) in self.vertices.iter_mut().zip(&corner.vertices) {
            put(to, f32::from_bits(number));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::tests::Draw;

    fn corner(draw: &mut Draw, number: u32) -> Corner {
        Corner { w: draw.vector().as_vec3(), vertices: [number, !number] }
    }

    /// Whether the line along z through the origin passes between three places, that go counter-clockwise.
    fn is_between(places: [Vec3; 3]) -> bool {
        let at = places.map(|place| place.truncate());
        (0..3).all(|k| at[k].perp_dot(at[(k + 1) % 3]) >= 0.0)
    }

    #[test]
    fn another_corner_takes_the_place_of_the_one_that_leaves_the_line_between_them() {
        let seed = std::env::var("DCD_SEED").map_or(5, |seed| seed.parse().expect("a seed"));
        let mut draw = Draw(seed);
        let mut gone = [0; 3];
        for _ in 0..3000 {
            let known = [1, 2, 3].map(|number| corner(&mut draw, number));
            if !is_between(known.each_ref().map(|corner| corner.w)) {
                continue;
            }
            let other = corner(&mut draw, 4);
            let mut triangle = Triangle::of(&known);
            assert!(!triangle.has(&other) && known.iter().all(|known| triangle.has(known)));
            let dropped = triangle.dropped_for(&other);
            let exchanged = |k: usize| {
                let mut corners = known;
                corners[k] = other;
                corners
            };
            let is_possible = |k: usize| is_between(exchanged(k).each_ref().map(|corner| corner.w));
            let k = (0..3).find(|&k| dropped.test(k)).expect("some corner goes");
            assert!(dropped.bitmask().is_power_of_two() && is_possible(k), "{seed} {k}");
            triangle.exchange(dropped, &other);
            let expected = exchanged(k);
            for (found, expected) in triangle.corners().iter().zip(&expected) {
                assert_eq!(
                    (found.w, found.vertices),
                    (expected.w, expected.vertices),
                    "{seed} {k}"
                );
            }
            assert_eq!(triangle.first(), expected[0].w);
            gone[k] += 1;
        }
        assert!(gone.iter().all(|&count| count > 50), "{gone:?}");
    }

    #[test]
    fn no_corner_goes_where_all_are_on_one_side() {
        let at = |x: f32, y: f32| Corner { w: Vec3::new(x, y, 0.0), vertices: [0; 2] };
        let triangle = Triangle::of(&[at(1.0, 1.0), at(2.0, 1.0), at(2.0, 3.0)]);
        assert!(!triangle.dropped_for(&at(1.0, 0.0)).any());
        assert!(!triangle.dropped_for(&at(f32::NAN, 0.0)).any());
    }

    #[test]
    fn the_normal_is_the_cross_product_of_the_edges() {
        let mut draw = Draw(7);
        for _ in 0..100 {
            let corners = [1, 2, 3].map(|number| corner(&mut draw, number));
            let [p, q, r] = corners.each_ref().map(|corner| corner.w);
            let off = Triangle::of(&corners).normal() - (r - p).cross(q - p);
            assert!(off.length() < 1e-5, "{off}");
        }
    }
}
