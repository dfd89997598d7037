//! Where the second shape is, seen from the first.

use super::body::Body;
use super::bounds::{BOX, OFFSET, SIZE, U, U64};
use super::side::{Parts, Side, extent, grown};
use dcd_geom::glam::{DMat3, DVec3};
use dcd_geom::{Aabb, Aabb16};
use dcd_simd::{Block, Lanes};

/// The second shape's place in the first one's axes: world points are mapped by R_Aᵀ, which keeps
/// what is apart apart and what touches touching, though it is a rotation only up to rounding.
pub(super) struct RelativePose {
    /// R_Aᵀ·R_B, rounded.
    pub(super) rotation: DMat3,
    /// R_Aᵀ·(t_B − t_A), rounded.
    pub(super) offset: DVec3,
    /// The pair's size m.
    size: f64,
    stretch: f64,
    /// How far R_Aᵀ·R_A may move a point, and what f64 loses. Metres.
    slack: f64,
    /// How much larger a turned box is made on each side, swept radii among it. Metres.
    margin: f32,
}

impl RelativePose {
    /// `None` where the pair's size leaves the range in which the bounds on f32 hold.
    #[inline(always)]
    pub(super) fn of(a: &Side<'_>, b: &Side<'_>) -> Option<Self> {
        let delta = b.pose.translation() - a.pose.translation();
        let stretch = |side: &Side<'_>| 1.0 + side.pose.deviation();
        let far = b.reach * stretch(b) + delta.abs().element_sum();
        let size = (a.reach + far) * stretch(a) * (1.0 + 16.0 * U64);
        // Written so that NaN is out of range.
        if !(SIZE[0]..=SIZE[1]).contains(&size) {
            return None;
        }
        let to_a = a.pose.rotation().transpose();
        let rotation = to_a * *b.pose.rotation();
        let offset = to_a * delta;
        let slack = OFFSET * U64 * size + a.pose.deviation() * a.reach;
        let swept = (a.radius() + b.radius()) * stretch(a) * (1.0 + 8.0 * U64);
        let spheres = b.pose.deviation() * b.reach;
        let margin = (BOX * U * size + slack + spheres + swept) as f32;
        Some(Self { rotation, offset, size, stretch: stretch(a), slack, margin: margin.next_up() })
    }

    /// The rotation's, in f32: of no use for a convex second shape, which is most.
    #[inline(always)]
    fn rows(&self) -> [[f32; 3]; 3] {
        let row = |axis| self.rotation.row(axis).as_vec3().to_array();
        [row(0), row(1), row(2)]
    }

    /// By how much the map to the first axes may lengthen.
    pub(super) fn stretch(&self) -> f64 {
        self.stretch
    }

    /// The pair's size m: how far points of either are from the origin of the first frame.
    pub(super) fn size(&self) -> f64 {
        self.size
    }

    /// What a coordinate of the first frame may be off beside its rounding to f32, metres.
    pub(super) fn slack(&self) -> f64 {
        self.slack
    }

    /// A block of the second shape's boxes in the first frame, grown for all rounding. Boxes of
    /// nothing become NaN, which overlaps nothing.
    #[inline(always)]
    pub(super) fn place<L: Lanes>(&self, l: L, boxes: &Aabb16, placed: &mut Aabb16) {
        let (rows, offset) = (self.rows(), self.offset.as_vec3().to_array());
        let half = l.splat(0.5);
        let mut middles = [half; 3];
        let mut halves = [half; 3];
        for axis in 0..3 {
            let (min, max) = (l.load(&boxes.min[axis]), l.load(&boxes.max[axis]));
            middles[axis] = l.mul(half, l.add(min, max));
            halves[axis] = l.mul(half, l.sub(max, min));
        }
        for axis in 0..3 {
            let mut middle = l.splat(offset[axis]);
            let mut reach = l.splat(self.margin);
            for k in 0..3 {
                let entry = rows[axis][k];
                middle = l.mul_add(l.splat(entry), middles[k], middle);
                reach = l.mul_add(l.splat(entry.abs()), halves[k], reach);
            }
            l.store(l.sub(middle, reach), &mut placed.min[axis]);
            l.store(l.add(middle, reach), &mut placed.max[axis]);
        }
    }

    /// The one box of a convex second shape in the first frame, from its supports.
    pub(super) fn place_one(&self, b: &Side<'_>) -> Aabb16 {
        let mut block = Aabb16::EMPTY;
        block.set(0, &self.around(b));
        block
    }

    /// The box round a convex second shape in the first frame.
    pub(super) fn around(&self, b: &Side<'_>) -> Aabb {
        let Parts::One(shape) = b.parts else { return Aabb::EMPTY };
        let rows = [0, 1, 2].map(|axis| self.rotation.row(axis));
        let (min, max) = extent(shape, rows, self.stretch);
        grown(min + self.offset, max + self.offset, self.margin)
    }

    /// The same from its vertices, which are turned already.
    #[inline(always)]
    pub(super) fn around_body(&self, body: &Body) -> Aabb {
        let (min, max) = body.extent();
        grown(min, max, self.margin)
    }

    /// Turns corners into the first axes: R_Aᵀ·R_B·x.
    #[inline(always)]
    pub(super) fn turn<L: Lanes>(&self, l: L, corners: &Block, turned: &mut Block) {
        let [x, y, z] = &corners.0;
        let (x, y, z) = (l.load(x), l.load(y), l.load(z));
        for (row, out) in self.rows().iter().zip(&mut turned.0) {
            let along = l.mul(l.splat(row[0]), x);
            let along = l.mul_add(l.splat(row[1]), y, along);
            l.store(l.mul_add(l.splat(row[2]), z, along), out);
        }
    }
}
