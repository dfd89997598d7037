//! A ray and sixteen triangles in f32: which of them the test of one triangle is proved to miss.
//!
//! The signs of two edge functions differ by more than all that either computation may lose (docs/numerics/queries.md,
//! "Triangles by lanes"): so no hit depends on the lanes, nor on which triangles they leave.

use super::triangle::Sheared;
use dcd_geom::glam::DVec3;
use dcd_geom::{LeafFilter, Triangles};
use dcd_simd::{Block, Lanes};

/// How much an edge function may be off, per square of the coordinates' size. Unit: 2⁻²⁴. Larger: triangles that are
/// missed and tested in f64. Smaller: hits lost.
const OFF: f64 = 64.0 / (1u32 << 24) as f64;

/// The same per margin and size, and per square of the margin. No unit.
const OFF_BY_MARGIN: f64 = 16.0;

/// Metres: products of coordinates of that size are far from the end of f32's range. Beyond it all triangles are tested
/// in f64.
const LARGEST: f64 = 1e18;

/// The triangles of a mesh's leaves that a ray does not surely miss; their swept radius is 0.
pub(super) struct NotMissed<'a> {
    pub(super) sheared: &'a Sheared,
    pub(super) leaves: &'a [Triangles],
}

/// Where sixteen corners are seen.
type SeenCorners<L> = [<L as Lanes>::F; 2];

impl LeafFilter for NotMissed<'_> {
    /// A triangle is missed wherever its box is, but for rays that begin or end before it.
    const AFTER_BOXES: bool = false;

    #[inline(always)]
    fn keep<L: Lanes>(&self, l: L, leaf: usize, lanes: u32) -> u32 {
        let Some(leaf) = self.leaves.get(leaf) else { return lanes };
        let &Sheared { axes, shear, origin, margin, .. } = self.sheared;
        let at = seen_from(leaf.centre, origin, axes, shear);
        let size = 1.5 * leaf.radius + at[0].abs().max(at[1].abs());
        let off = OFF * (size * size) + OFF_BY_MARGIN * (margin * (size + margin));
        // Written so that NaN is large.
        if !(size < LARGEST && off < LARGEST) {
            return lanes;
        }
        let at = [l.splat(at[0] as f32), l.splat(at[1] as f32)];
        let shear = [l.splat(shear[0] as f32), l.splat(shear[1] as f32)];
        let [a, b, c] = &leaf.corners;
        let a = seen(l, a, axes, (shear, at));
        let b = seen(l, b, axes, (shear, at));
        let c = seen(l, c, axes, (shear, at));
        let (u, v, w) = (edge(l, b, c), edge(l, c, a), edge(l, a, b));
        let more = l.splat((off as f32).next_up() + f32::MIN_POSITIVE);
        let less = l.neg(more);
        let is_left = l.or(l.lt(more, u), l.or(l.lt(more, v), l.lt(more, w)));
        let is_right = l.or(l.lt(u, less), l.or(l.lt(v, less), l.lt(w, less)));
        lanes & !l.bits(l.and(is_left, is_right))
    }
}

/// Where the ray's origin is seen from a point, along the ray.
#[inline(always)]
fn seen_from(centre: DVec3, origin: DVec3, [x, y, z]: [usize; 3], shear: [f64; 2]) -> [f64; 2] {
    let v = (origin - centre).to_array();
    [v[x] - shear[0] * v[z], v[y] - shear[1] * v[z]]
}

/// Corners, relative to their leaf's centre, as a ray sees them that goes through a place.
#[inline(always)]
fn seen<L: Lanes>(
    l: L,
    corners: &Block,
    [x, y, z]: [usize; 3],
    (shear, at): (SeenCorners<L>, SeenCorners<L>),
) -> SeenCorners<L> {
    let rows = &corners.0;
    let along = l.load(&rows[z]);
    let beside = [l.sub(l.load(&rows[x]), at[0]), l.sub(l.load(&rows[y]), at[1])];
    [l.sub(beside[0], l.mul(shear[0], along)), l.sub(beside[1], l.mul(shear[1], along))]
}

/// Twice the area of a triangle with the ray.
#[inline(always)]
fn edge<L: Lanes>(l: L, a: SeenCorners<L>, b: SeenCorners<L>) -> L::F {
    l.sub(l.mul(a[0], b[1]), l.mul(a[1], b[0]))
}

#[cfg(test)]
mod tests {
    use super::super::local::LocalRay;
    use super::super::tests::Random;
    use super::super::{Ray, RayHit};
    use super::*;
    use crate::PosedShape;
    use dcd_geom::{Aabb, Mesh, Pose, Shape};
    use dcd_simd::{Kernel, Path, WIDTH, dispatch_on};

    /// What is kept of all lanes of a leaf.
    struct Kept<'a> {
        test: &'a NotMissed<'a>,
        leaf: usize,
    }

    impl Kernel for Kept<'_> {
        type Output = u32;

        #[inline(always)]
        fn run<L: Lanes>(self, l: L) -> u32 {
            self.test.keep(l, self.leaf, (1 << WIDTH) - 1)
        }
    }

    /// A wavy strip of triangles that share edges; or triangles of any size, needles and points among them.
    fn mesh(random: &mut Random, round: usize, size: f64) -> Mesh {
        let (count, mut points) = (12u32, Vec::new());
        for k in 0..count * 3 {
            let on_grid = DVec3::new(f64::from(k / 3), f64::from(k % 3), 0.0);
            let bend = random.vector() * [0.0, 0.2, 4.0][round % 3];
            points.push((on_grid + bend) * size);
        }
        let mut triangles = Vec::new();
        for k in 0..3 * (count - 1) {
            let corner = [[k, k + 3, k + 1], [k + 3, k + 4, k + 1]];
            if round.is_multiple_of(2) && k % 3 < 2 {
                triangles.extend(corner);
            } else if round % 2 == 1 {
                triangles.push([k, (k * 7) % (3 * count), (k * k) % (3 * count)]);
            }
        }
        Mesh::new(points, triangles).unwrap()
    }

    #[test]
    fn no_triangle_is_left_out_that_the_test_of_one_triangle_meets() {
        let mut random = Random::seeded(47);
        let (mut dropped, mut met, mut kept_in_vain) = (0, 0, 0);
        for round in 0..600 {
            let size = [1.0, 1e-3, 1e4, 1e-30, 1e7][round % 5];
            let mesh = mesh(&mut random, round, size);
            let at = random.vector() * size * [0.0, 1.0, 1e4][round / 5 % 3];
            let pose = if round % 2 == 0 { Pose::IDENTITY } else { random.pose(at) };
            let [a, b, c] = mesh.corners(round % mesh.triangles().len()).unwrap();
            let mix = |x: f64, y: f64| a * (1.0 - x - y) + b * x + c * y;
            // Inside of a triangle, on its edge, into its corner, and beside it.
            let target = match round / 2 % 4 {
                0 => mix(0.3, 0.3),
                1 => mix(0.5, 0.0),
                2 => a,
                _ => mix(0.3, 0.3) + random.vector() * size,
            };
            let way = match round / 8 % 3 {
                0 => DVec3::Z,
                1 => b - target,
                _ => random.vector(),
            };
            let way = way.normalize_or(DVec3::X) * size * [1.0, 30.0, 1e5][round / 24 % 3];
            let (from, to) = (pose.apply(target - way), pose.apply(target + way));
            let Ok(ray) = Ray::between(from, to) else { continue };
            let reach = mesh.reach();
            let (leaves, count) = (mesh.leaves(), mesh.tree().leaf_count());
            let shape = Shape::from(mesh.clone());
            let local = LocalRay::of(&ray, &PosedShape { shape: &shape, pose: &pose }, reach);
            let sheared = Sheared::of(&local);
            let test = NotMissed { sheared: &sheared, leaves };
            for leaf in 0..count {
                let kept = Path::ALL.into_iter().filter(|path| path.is_available());
                let kept: Vec<u32> =
                    kept.map(|path| dispatch_on(path, Kept { test: &test, leaf })).collect();
                let boxes = &mesh.tree().blocks()[leaf];
                for lane in (0..WIDTH).filter(|&lane| boxes.get(lane) != Aabb::EMPTY) {
                    let number = mesh.tree().below()[leaf].0[lane];
                    let corners = mesh.corners(number as usize).unwrap();
                    let hit: Option<RayHit> = sheared.hit(&ray, &local, corners);
                    for &kept in &kept {
                        let is_kept = kept >> lane & 1 == 1;
                        assert!(is_kept || hit.is_none(), "{round}: {number} {corners:?} {hit:?}");
                        dropped += usize::from(!is_kept);
                        kept_in_vain += usize::from(is_kept && hit.is_none());
                        met += usize::from(hit.is_some());
                    }
                }
            }
        }
        assert!(dropped > 2 * kept_in_vain && met > 500, "{dropped} {kept_in_vain} {met}");
    }
}
