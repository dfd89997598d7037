//! The bounds of many shapes, posed sixteen at a time.

use super::{InscribedSphere, MARGIN, SphereBounds};
use crate::{Aabb, BoundingSphere, Pose, Sphere16};
use dcd_simd::{Lanes, Row, WIDTH};

/// Bounds that are posed together, again and again.
#[derive(Clone, Debug)]
pub struct PackedSphereBounds {
    bounds: Vec<Option<SphereBounds>>,
    /// The spheres' centres, x, y and z, their radii and the reaches: each bound after bound and then
    /// from the first on again, so that sixteen can be read from any on.
    columns: [Vec<f32>; 5],
}

/// Beyond this reach a sphere is infinite, metres: less than [`Aabb::LIMIT`] by far more than f32 loses
/// in a reach. Larger: what is out of range could count as far from everything.
const FARTHEST: f32 = 0.999 * Aabb::LIMIT as f32;

impl PackedSphereBounds {
    /// Packs these bounds, in this order; `None` becomes infinite spheres.
    pub fn new(bounds: Vec<Option<SphereBounds>>) -> Self {
        let column = |number: fn(&SphereBounds) -> f64| -> Vec<f32> {
            let number =
                |bound: &Option<SphereBounds>| bound.as_ref().map_or(f64::INFINITY, number);
            let again = bounds.iter().cycle().take(bounds.len() + WIDTH);
            again.map(|bound| number(bound) as f32).collect()
        };
        let columns = [
            column(|bound| bound.sphere.centre.x),
            column(|bound| bound.sphere.centre.y),
            column(|bound| bound.sphere.centre.z),
            column(|bound| bound.sphere.radius),
            column(|bound| bound.reach),
        ];
        Self { bounds, columns }
    }

    /// The largest of [`SphereBounds::largest_sphere`]; of what has no bound nothing is said.
    pub fn largest_sphere(&self, within: f64) -> f32 {
        self.bounds.iter().flatten().map(|bound| bound.largest_sphere(within)).fold(0.0, f32::max)
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.bounds.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.bounds.is_empty()
    }

    /// What is inside of a bound's shape, round the centre of its sphere: see [`SphereBounds::concentric`].
    #[inline]
    pub fn concentric(&self, bound: usize, sphere: &BoundingSphere) -> InscribedSphere {
        self.bounds[bound].map_or(InscribedSphere::NOTHING, |bound| bound.concentric(sphere))
    }

    /// The spheres of at most sixteen poses, the first of bound `first`, the next of the next, after the
    /// last of the first again: as [`SphereBounds::sphere`] has them but for what f32 loses
    /// (docs/numerics/proofs.md, "what is near"). Those beyond the last pose mean nothing. For kernels.
    #[inline(always)]
    pub fn spheres<L: Lanes>(&self, l: L, first: usize, poses: &[Pose], row: &mut Sphere16) {
        let mut rows = [Row::default(); WIDTH];
        for (pose, row) in poses.iter().zip(&mut rows) {
            let [most @ .., zz]: &[f64; 9] = pose.rotation().as_ref();
            let [x, y, z] = pose.translation().to_array();
            l.store(l.round_from([most, &[*zz, x, y, z, pose.deviation(), 0.0, 0.0, 0.0]]), row);
        }
        let [xx, xy, xz, yx, yy, yz, zx, zy, zz, x, y, z, deviation, ..] = l.transpose(&rows);
        let [x_column, y_column, z_column, radius, reach] = &self.columns;
        let point = [x_column, y_column, z_column].map(|column| &column[first..]);
        let centre = [
            moved(l, [xx, yx, zx, x], point),
            moved(l, [xy, yy, zy, y], point),
            moved(l, [xz, yz, zz, z], point),
        ];
        let (radius, reach) = (sixteen(l, &radius[first..]), sixteen(l, &reach[first..]));
        let stretch = l.add(l.splat(1.0), deviation);
        let far = l.max(l.max(l.abs(x), l.abs(y)), l.abs(z));
        let reach = l.add(far, l.mul(reach, stretch));
        let margin = l.add(l.mul(l.splat(MARGIN as f32), reach), l.splat(f32::MIN_POSITIVE));
        let radius = l.add(l.mul(radius, stretch), margin);
        // Written so that NaN is out of range.
        let is_within = l.le(reach, l.splat(FARTHEST));
        for (axis, centre) in centre.into_iter().enumerate() {
            l.store(l.select(is_within, centre, l.splat(0.0)), &mut row.centre.0[axis]);
        }
        l.store(l.select(is_within, radius, l.splat(f32::INFINITY)), &mut row.radius);
    }
}

/// One coordinate of points turned by a matrix and moved, given that row of the matrix and how far.
#[inline(always)]
fn moved<L: Lanes>(l: L, [x, y, z, t]: [L::F; 4], point: [&[f32]; 3]) -> L::F {
    // Products and sums one by one: fused they would differ from CPU to CPU.
    let sum = l.add(l.mul(x, sixteen(l, point[0])), l.mul(y, sixteen(l, point[1])));
    l.add(l.add(sum, l.mul(z, sixteen(l, point[2]))), t)
}

/// The first sixteen numbers, of at least as many.
#[inline(always)]
fn sixteen<L: Lanes>(l: L, numbers: &[f32]) -> L::F {
    match numbers.first_chunk() {
        Some(numbers) => l.load_from(numbers),
        None => l.splat(f32::INFINITY),
    }
}
