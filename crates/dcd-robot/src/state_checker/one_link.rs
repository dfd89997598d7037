//! A link in one state: of a packet, or of a state alone.

// In kernels: an iterator that is left out of line costs more than the loop.
#![allow(clippy::needless_range_loop)]

use super::SpherePacket;
use super::links::SphereRow;
use super::rounded_links::{LinkSphereRow, of_block, placed};
use dcd_simd::{Lanes, Row, WIDTH};
use glam::Vec3;

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

/// The links of a state alone.
#[derive(Clone, Copy)]
pub(super) struct OneState<'a> {
    /// Each with the rotation's columns, then the translation, a number that means nothing behind each.
    pub(super) frames: &'a [Row],
    /// Sixteen links to a row.
    pub(super) spheres: &'a [LinkSphereRow],
}

impl<'a> LinkPlaces for OneState<'a> {
    type Link = OneLink<'a>;

    #[inline(always)]
    fn at(self, slot: usize) -> OneLink<'a> {
        let spheres = &self.spheres[slot / WIDTH];
        OneLink { frame: &self.frames[slot], spheres, lane: slot % WIDTH }
    }
}

/// A link of a state alone.
#[derive(Clone, Copy)]
pub(super) struct OneLink<'a> {
    frame: &'a Row,
    spheres: &'a LinkSphereRow,
    lane: usize,
}

impl LinkPlace for OneLink<'_> {
    #[inline(always)]
    fn number(self, k: usize) -> f32 {
        self.frame.0[k / 3 * 4 + k % 3]
    }

    #[inline(always)]
    fn centre(self) -> Vec3 {
        self.spheres.centre.point(self.lane)
    }

    #[inline(always)]
    fn margin(self) -> f32 {
        self.spheres.margin.0[self.lane]
    }
}
