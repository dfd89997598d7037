//! Supports of two polytopes, sixteen vertices at a time in f32.
//!
//! [`Approximate`] reads the f32 vertices alone: for searches, which prove nothing. [`Exact`] compares in f64 those
//! vertices that f32 leaves, most often one: the same bits as all vertices in f64 (docs/numerics/queries.md, "supports
//! by lanes").

use crate::{Difference, Vertex};
use dcd_geom::glam::{DMat3, DVec3, Mat3, Vec3};
use dcd_geom::{Polytope, Shape, Support, SupportMap};
use dcd_simd::{Block, Kernel, Lanes, WIDTH, dispatch};

/// What a product of a direction and a vertex, both rounded to f32, loses, and half of what the threshold below it
/// does: five roundings and one half. Unit: 2⁻²⁴ of the direction's length by the outer radius. Smaller: another vertex
/// than the farthest. Larger: more vertices are compared in f64.
const LOST: f64 = 6.0 * (f32::EPSILON as f64 / 2.0);

/// What the same product loses in f64. Unit: 2⁻⁵³ of the direction's length by the reach.
const LOST_IN_F64: f64 = 8.0 * (f64::EPSILON / 2.0);

pub(crate) type Polytopes<'b> = Difference<'b, f64, Polytope, Polytope>;

/// A support map that may have its vertices in blocks.
pub(crate) trait InBlocks: SupportMap<f64> {
    /// The polytope that it is.
    fn polytope(&self) -> Option<&Polytope>;
}

impl InBlocks for Polytope {
    #[inline(always)]
    fn polytope(&self) -> Option<&Polytope> {
        Some(self)
    }
}

impl InBlocks for Shape {
    #[inline(always)]
    fn polytope(&self) -> Option<&Polytope> {
        match self {
            Self::Polytope(polytope) => Some(polytope),
            _ => None,
        }
    }
}

/// [`Difference::lowest`], by lanes where that is quicker.
pub(crate) fn lowest<A: InBlocks, B: InBlocks>(
    difference: &Difference<'_, f64, A, B>,
    direction: DVec3,
) -> (Vertex<f64>, f64) {
    let (a, b) = difference.maps();
    if has_blocks(a) || has_blocks(b) {
        dispatch(LowestVertex { difference, direction })
    } else {
        difference.lowest(direction)
    }
}

fn has_blocks(map: &impl InBlocks) -> bool {
    map.polytope().is_some_and(|polytope| !polytope.vertex_blocks().is_empty())
}

/// One support, compiled once a path for all searches that take it.
struct LowestVertex<'a, 'b, A, B> {
    difference: &'a Difference<'b, f64, A, B>,
    direction: DVec3,
}

impl<A: InBlocks, B: InBlocks> Kernel for LowestVertex<'_, '_, A, B> {
    type Output = (Vertex<f64>, f64);

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Self::Output {
        let Self { difference, direction } = self;
        let (a, b) = difference.maps();
        let [in_a, in_b] = difference.to_local(direction);
        let (a, b) = (farthest(l, a, -in_a), farthest(l, b, in_b));
        let vertex = Vertex { w: difference.world(a.point, b.point), a, b };
        (vertex, difference.separation(direction, &vertex))
    }
}

/// How the vertex of a difference that is lowest along a direction is found.
pub(crate) trait Lowest {
    /// The vertex, and the separation there, scaled. The direction's largest component is 1.
    fn lowest(&self, direction: DVec3) -> (Vertex<f64>, f64);
}

/// As [`Difference::lowest`], bit for bit.
pub(crate) struct Exact<'a, 'b, L, A, B> {
    pub(crate) lanes: L,
    pub(crate) difference: &'a Difference<'b, f64, A, B>,
}

impl<L: Lanes, A: InBlocks, B: InBlocks> Lowest for Exact<'_, '_, L, A, B> {
    #[inline(always)]
    fn lowest(&self, direction: DVec3) -> (Vertex<f64>, f64) {
        self.lanes.call(LowestVertex { difference: self.difference, direction })
    }
}

/// A vertex near the lowest, by f32 alone. Decides the way of a search, never an answer.
pub(crate) struct Approximate<'b, L> {
    lanes: L,
    maps: (&'b Polytope, &'b Polytope),
    middle: DVec3,
    scaled: [DMat3; 2],
    rotations: [Mat3; 2],
}

impl<'b, L: Lanes> Approximate<'b, L> {
    /// `None` where neither has its vertices in blocks.
    #[inline(always)]
    pub(crate) fn of(lanes: L, difference: &Polytopes<'b>) -> Option<Self> {
        let maps @ (a, b) = difference.maps();
        if a.vertex_blocks().is_empty() && b.vertex_blocks().is_empty() {
            return None;
        }
        let ([of_a, of_b], scale) = (difference.rotations(), difference.scale());
        let (middle, scaled) = (difference.middle(), [of_a * scale, of_b * scale]);
        let rotations = [of_a.as_mat3(), of_b.as_mat3()];
        Some(Self { lanes, maps, middle, scaled, rotations })
    }
}

impl<L: Lanes> Lowest for Approximate<'_, L> {
    #[inline(always)]
    fn lowest(&self, direction: DVec3) -> (Vertex<f64>, f64) {
        let ((a, b), [of_a, of_b]) = (self.maps, &self.rotations);
        let d = direction.as_vec3();
        let in_a = -Vec3::new(of_a.x_axis.dot(d), of_a.y_axis.dot(d), of_a.z_axis.dot(d));
        let in_b = Vec3::new(of_b.x_axis.dot(d), of_b.y_axis.dot(d), of_b.z_axis.dot(d));
        let (a, b) = (nearly_farthest(self.lanes, a, in_a), nearly_farthest(self.lanes, b, in_b));
        let w = (self.scaled[0] * a.point - self.scaled[1] * b.point) + self.middle;
        (Vertex { w, a, b }, direction.dot(w))
    }
}

/// Sixteen products of vertices and a direction, each rounded twice: the same bits on every path.
#[inline(always)]
fn along<L: Lanes>(l: L, block: &Block, d: &[L::F; 3]) -> L::F {
    let Block([x, y, z]) = block;
    let (x, y, z) = (l.mul(l.load(x), d[0]), l.mul(l.load(y), d[1]), l.mul(l.load(z), d[2]));
    l.add(l.add(x, y), z)
}

/// A vertex near the farthest, its point relative to the centre of the inscribed sphere.
#[inline(always)]
fn nearly_farthest<L: Lanes>(l: L, polytope: &Polytope, direction: Vec3) -> Support<f64> {
    let blocks = polytope.vertex_blocks();
    if blocks.is_empty() {
        let found: Support<f64> = polytope.support(direction.as_dvec3());
        return Support { point: found.point - polytope.inner().centre, ..found };
    }
    let [x, y, z] = direction.to_array();
    let d = [l.splat(x), l.splat(y), l.splat(z)];
    let (mut best, mut of) = (l.splat(f32::MIN), l.splat(0.0));
    for (number, block) in blocks.iter().enumerate() {
        let along = along(l, block, &d);
        let is_farther = l.lt(best, along);
        best = l.select(is_farther, along, best);
        of = l.select(is_farther, l.splat(number as f32), of);
    }
    let is_farthest = l.le(l.splat(l.largest(best)), best);
    // Some lane always is, but for NaN.
    let lane = (l.bits(is_farthest).trailing_zeros() as usize).min(WIDTH - 1);
    let mut numbers = [0.0; WIDTH];
    l.store_to(of, &mut numbers);
    let number = (numbers[lane] as usize).min(blocks.len() - 1);
    let point = blocks[number].point(lane).as_dvec3();
    Support { point, feature: (number * WIDTH + lane) as u32 }
}

/// The farthest vertex in f64, the first among equals.
#[inline(always)]
fn farthest<L: Lanes>(l: L, map: &impl InBlocks, direction: DVec3) -> Support<f64> {
    let Some(polytope) = map.polytope() else { return map.support(direction) };
    let (blocks, vertices) = (polytope.vertex_blocks(), polytope.vertices());
    let Some((first, rest)) = blocks.split_first() else { return polytope.support(direction) };
    let [x, y, z] = direction.as_vec3().to_array();
    let d = [l.splat(x), l.splat(y), l.splat(z)];
    let mut most = along(l, first, &d);
    for block in rest {
        most = l.max(most, along(l, block, &d));
    }
    let size = direction.abs().element_sum();
    let lost = size * (LOST * polytope.outer_radius() + LOST_IN_F64 * polytope.reach());
    let least = f64::from(l.largest(most)) - 2.0 * lost;
    let least = l.splat(least as f32 - f32::MIN_POSITIVE);
    let (mut best, mut farthest) = (0, f64::MIN);
    for (number, block) in blocks.iter().enumerate() {
        let mut bits = l.bits(l.le(least, along(l, block, &d))) & 0xffff;
        while bits != 0 {
            // The last block is filled up with the last vertex.
            let k = (number * WIDTH + bits.trailing_zeros() as usize).min(vertices.len() - 1);
            bits &= bits - 1;
            let along = vertices[k].dot(direction);
            if along > farthest {
                (best, farthest) = (k, along);
            }
        }
    }
    Support { point: vertices[best], feature: best as u32 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PosedSupport;
    use crate::gjk::unit;
    use crate::motion::tests::Draw;
    use dcd_geom::Pose;
    use dcd_geom::glam::DQuat;
    use dcd_simd::{Path, dispatch_on};

    struct ByF32<'a, 'b>(&'a Polytopes<'b>, DVec3);

    impl Kernel for ByF32<'_, '_> {
        type Output = Option<(Vertex<f64>, f64)>;

        #[inline(always)]
        fn run<L: Lanes>(self, lanes: L) -> Self::Output {
            Some(Approximate::of(lanes, self.0)?.lowest(self.1))
        }
    }

    fn polytope(draw: &mut Draw, k: usize) -> Polytope {
        // Every other one with ties, a third far from its own origin, some without blocks.
        let from = [DVec3::ZERO, DVec3::ZERO, DVec3::splat(1e7)][k % 3];
        let scale = [1.0, 1e-4, 1e4][k / 2 % 3];
        let points = (0..4 + k % 90).map(|_| {
            let point = draw.vector();
            scale * (from + if k.is_multiple_of(2) { (point * 3.0).round() } else { point })
        });
        Polytope::hull(points.collect()).unwrap()
    }

    #[test]
    fn lanes_find_the_vertex_that_all_in_f64_would_and_the_same_one_on_every_path() {
        let seed = std::env::var("DCD_SEED").map_or(5, |seed| seed.parse().expect("a seed"));
        let mut draw = Draw(seed);
        let mut in_f32 = 0;
        for k in 0..1500 {
            let (a, b) = (polytope(&mut draw, k), polytope(&mut draw, k / 7));
            let turn = DQuat::from_scaled_axis(draw.vector() * f64::from(k as u32 % 4));
            let (pose_a, pose_b) = (
                Pose::new(turn.normalize(), draw.vector()).unwrap(),
                Pose::from_translation(draw.vector()).unwrap(),
            );
            let posed = (PosedSupport::polytope(&a, &pose_a), PosedSupport::polytope(&b, &pose_b));
            let difference = Difference::new(posed.0, posed.1).unwrap();
            for j in 0..6 {
                let along = if j == 0 { DVec3::Y } else { draw.vector() };
                let along = if j % 2 == 0 { turn * along.round() } else { along };
                let Some(direction) = unit::<f64>(along.to_array()) else { continue };
                let expected = difference.lowest(direction);
                let first = dispatch(ByF32(&difference, direction));
                for path in Path::ALL {
                    let kernel = LowestVertex { difference: &difference, direction };
                    assert_eq!(dispatch_on(path, kernel), expected, "{seed} {k} {path:?}");
                    assert_eq!(
                        dispatch_on(path, ByF32(&difference, direction)),
                        first,
                        "{seed} {k}"
                    );
                }
                if let Some((_, separation)) = first {
                    in_f32 += 1;
                    assert!((separation - expected.1).abs() < 1e-6, "{seed} {k}");
                }
            }
        }
        assert!(in_f32 > 1000, "{in_f32}");
    }
}
