//! Half-spaces that hold the whole second shape: what is outside of one is apart from it.
//!
//! A convex shape that misses one triangle beyond a plane mostly misses its neighbours, and the
//! boxes round them, beyond the same plane. So the planes with which searches in f64 ended are kept
//! for the rest of the pair, and sixteen boxes or triangles are held against each at once
//! (docs/numerics/proofs.md, "parts").

use super::bounds::{CORNERS, CORNERS_OF_BOXES, U, U64};
use super::relative_pose::RelativePose;
use super::side::{Parts, Side};
use crate::simd::vector::V3;
use dcd_geom::glam::{DVec3, Vec3};
use dcd_geom::{Aabb16, ObbBounds, Shape, SupportMap, Triangles};
use dcd_simd::Lanes;

/// How many separating planes are kept; the oldest goes first. No unit. Smaller: parts resolved one by one that
/// an earlier plane separates. Larger: more planes to test each leaf against. Never an answer.
const MOST: usize = 12;

/// How much of the box round a shape the box inside it must be, along each axis, for their faces to
/// be separating planes from the start. No unit. Smaller: separating planes that separate little. Never an answer.
const BOX: f64 = 0.99;

/// The half-space {x: normal·x ≤ height} in the first shape's axes, with a convex second shape in
/// it. A point of the first that is surely above is apart from the second.
#[derive(Clone, Copy, Debug)]
struct SeparatingPlane {
    /// Numbers that f32 holds; the largest component is 1 or −1.
    normal: Vec3,
    /// Above the second shape, the swept radii of both and what f64 loses. Metres.
    height: f64,
    /// The same for the corners of the first tree's boxes.
    height_of_boxes: f32,
}

/// The separating planes of one pair of shapes.
#[derive(Clone, Debug, Default)]
pub(super) struct SeparatingPlanes {
    planes: Vec<SeparatingPlane>,
    /// Where the next one goes once there are as many as are kept.
    oldest: usize,
}

impl SeparatingPlanes {
    /// Forgets the last pair.
    pub(super) fn clear(&mut self) {
        self.planes.clear();
        self.oldest = 0;
    }

    /// Forgets the last pair. Of a box those three faces are known at once that look towards the
    /// first shape.
    pub(super) fn begin(&mut self, relative: &RelativePose, [a, b]: [&Side<'_>; 2]) {
        self.clear();
        let Parts::One(shape @ Shape::Polytope(polytope)) = b.parts else { return };
        let is_box = |obb: &&ObbBounds| obb.inner.cmpgt(obb.outer * BOX).all();
        let (Some(obb), Some(tree)) = (polytope.obb().filter(is_box), a.tree()) else {
            return;
        };
        let middle = relative.rotation * polytope.inner().centre + relative.offset;
        let towards = tree.aabb().centre().as_dvec3() - middle;
        for axis in 0..3 {
            let normal = relative.rotation * obb.axes.col(axis);
            let normal = if normal.dot(towards) < 0.0 { -normal } else { normal };
            self.planes.extend(SeparatingPlane::of(relative, a, shape, normal));
        }
    }

    /// Adds the separating plane of the second shape along a direction of the first axes, any length.
    pub(super) fn add(&mut self, relative: &RelativePose, [a, b]: [&Side<'_>; 2], along: DVec3) {
        let Parts::One(shape) = b.parts else { return };
        let Some(plane) = SeparatingPlane::of(relative, a, shape, along) else { return };
        if self.planes.len() < MOST {
            self.planes.push(plane);
        } else {
            self.planes[self.oldest] = plane;
            self.oldest = (self.oldest + 1) % MOST;
        }
    }

    /// Which of the open lanes' boxes no separating plane shuts out.
    #[inline(always)]
    pub(super) fn boxes<L: Lanes>(&self, l: L, boxes: &Aabb16, mut open: u32) -> u32 {
        for plane in self.planes.iter().rev() {
            if open == 0 {
                break;
            }
            let mut lowest = l.splat(0.0);
            for (axis, along) in plane.normal.to_array().into_iter().enumerate() {
                let nearest = if along < 0.0 { &boxes.max[axis] } else { &boxes.min[axis] };
                lowest = l.mul_add(l.splat(along), l.load(nearest), lowest);
            }
            open &= !l.bits(l.lt(l.splat(plane.height_of_boxes), lowest));
        }
        open
    }

    /// Which of the open lanes' triangles no separating plane shuts out.
    #[inline(always)]
    pub(super) fn triangles<L: Lanes>(&self, l: L, leaf: &Triangles, open: u32) -> u32 {
        self.triangles_within(l, leaf, open, 0.0)
    }

    /// Which of the open lanes' triangles no plane shuts out that is so far from a separating one, metres of the first axes.
    #[inline(always)]
    pub(super) fn triangles_within<L: Lanes>(
        &self,
        l: L,
        leaf: &Triangles,
        mut open: u32,
        distance: f64,
    ) -> u32 {
        for plane in self.planes.iter().rev() {
            if open == 0 {
                break;
            }
            let Vec3 { x, y, z } = plane.normal;
            let normal = V3(l.splat(x), l.splat(y), l.splat(z));
            let [a, b, c] = &leaf.corners;
            let a = normal.dot(l, V3::load(l, &a.0));
            let b = normal.dot(l, V3::load(l, &b.0));
            let c = normal.dot(l, V3::load(l, &c.0));
            let lowest = l.min(l.min(a, b), c);
            open &= !l.bits(l.lt(l.splat(plane.height_over(leaf, distance)), lowest));
        }
        open
    }
}

impl SeparatingPlane {
    /// `None` where the direction is none.
    fn of(relative: &RelativePose, a: &Side<'_>, shape: &Shape, along: DVec3) -> Option<Self> {
        let largest = along.abs().max_element();
        // Written so that NaN is no direction.
        if !(largest > 0.0 && largest < f64::INFINITY) {
            return None;
        }
        let normal = (along / largest).as_vec3();
        let d = normal.as_dvec3();
        let norm1 = d.abs().element_sum();
        let local = relative.rotation.transpose() * d;
        let core = local.dot(shape.support(local).point) + d.dot(relative.offset);
        let short = shape.support_error() * local.abs().element_sum();
        let swept = (a.radius() + shape.radius()) * relative.stretch() * d.length();
        let rounding = 2.0 * relative.slack() * norm1;
        let height = core + rounding + (short + swept) * (1.0 + 8.0 * U64);
        let of_boxes = height + CORNERS_OF_BOXES * U * relative.size() * norm1;
        Some(Self { normal, height, height_of_boxes: (of_boxes as f32).next_up() })
    }

    /// What the corners of a leaf must exceed to be so far from the plane, metres; counted from the leaf's centre.
    #[inline(always)]
    fn height_over(&self, leaf: &Triangles, distance: f64) -> f32 {
        let d = self.normal.as_dvec3();
        let rounding = CORNERS * U * leaf.radius * d.abs().element_sum();
        let beyond = if distance == 0.0 { 0.0 } else { distance * d.length() };
        ((self.height - d.dot(leaf.centre) + rounding + beyond) as f32).next_up()
    }
}
