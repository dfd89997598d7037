//! A link in one state: of a packet, or of a state alone.

// In kernels: an iterator that is left out of line costs more than the loop.
#![allow(clippy::needless_range_loop)]

use super::chain::{Columns, placed as of_columns};
use super::links::{LinkSpheres, SphereRow};
use super::numbers::mul_add;
use super::rounded_links::{of_block, placed};
use super::{MARGIN, SpherePacket};
use dcd_simd::Lanes;
use glam::{Vec3, Vec4};

/// Where the links are in one state.
pub(super) trait LinkPlaces: Copy {
    type Link: LinkPlace;
    /// Of a link with spheres, by its place among those.
    fn at(self, slot: usize) -> Self::Link;
}

/// Where a link is in one state.
pub(super) trait LinkPlace: Copy {
    /// Of the rotation's columns, then the translation.
    fn number(self, k: usize) -> f32;

    /// The middle of the sphere round all that the link carries, in the world, metres.
    fn centre(self) -> Vec3;

    /// By how much a comparison of anything on the link may be off, metres.
    fn margin(self) -> f32;

    /// Sixteen spheres on the link.
    #[inline(always)]
    fn row<L: Lanes>(self, l: L, row: &SphereRow) -> SpherePacket<L> {
        let mut frame = [l.splat(0.0); 12];
        for k in 0..12 {
            frame[k] = l.splat(self.number(k));
        }
        SpherePacket {
            centre: placed(l, &frame, of_block(l, &row.centre)),
            outer: l.load(&row.outer),
            inner: l.load(&row.inner),
            margin: l.splat(self.margin()),
        }
    }
}

/// A link of a state alone, in f32: two cache lines, where those of sixteen states have sixteen.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct OneLink {
    pub(super) columns: Columns,
    /// Of the sphere round all that the link carries, in the world; then the margin. Metres.
    centre: Vec4,
}

impl OneLink {
    /// Finds the sphere of a link that is placed.
    #[inline(always)]
    pub(super) fn finish<L: Lanes>(&mut self, link: &LinkSpheres, slid: f32) {
        let centre = of_columns::<L>(&self.columns, link.centre);
        let at = self.columns[3].abs();
        let larger = |a: f32, b: f32| if a > b { a } else { b };
        let far = larger(larger(at.x, at.y), at.z);
        let margin = mul_add::<L>(far, MARGIN as f32, link.lost[0]);
        let margin = mul_add::<L>(slid, link.lost[1], margin);
        self.centre = centre.truncate().extend(margin);
    }
}

impl<'a> LinkPlaces for &'a [OneLink] {
    type Link = &'a OneLink;

    #[inline(always)]
    fn at(self, slot: usize) -> &'a OneLink {
        &self[slot]
    }
}

impl LinkPlace for &OneLink {
    #[inline(always)]
    fn number(self, k: usize) -> f32 {
        self.columns[k / 3][k % 3]
    }

    #[inline(always)]
    fn centre(self) -> Vec3 {
        self.centre.truncate()
    }

    #[inline(always)]
    fn margin(self) -> f32 {
        self.centre.w
    }
}
