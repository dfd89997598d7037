//! The links of sixteen states, and their spheres, in f32.

// In kernels: an iterator that is left out of line costs more than the loop.
#![allow(clippy::needless_range_loop)]

use super::alone::LinkRow;
use super::chain::{Chain, Drives, loaded};
use super::link_frames::{HALF, LinkFrames};
use super::links::{LinkSpheres, SphereRow};
use super::numbers::{All, First, Numbers};
use super::prepared::Prepared;
use super::{MARGIN, SpherePacket};
use dcd_geom::Aabb;
use dcd_simd::{Block, Lanes, Row, WIDTH};
use glam::Vec3;

/// The links of sixteen states in f32.
#[derive(Clone, Debug, Default)]
pub(super) struct Rounded {
    pub(super) world: Vec<RoundedLink>,
    pub(super) own: Vec<RoundedLink>,
    /// The obstacles near a link, each with the states in which it is, a bit each.
    pub(super) near: Vec<(u32, u32)>,
    /// A box round each link in all states of a packet.
    pub(super) aabbs: Vec<Aabb>,
    /// The links of a state alone.
    pub(super) gathered: Vec<LinkRow>,
}

#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RoundedLink {
    /// The rotation's columns, then the translation.
    pub(super) frame: [Row; 12],
    /// Of the sphere round all that the link carries, in the world, metres.
    pub(super) centre: Block,
    /// By how much a comparison of anything on the link may be off, metres.
    pub(super) margin: Row,
}

impl Rounded {
    /// The links that meet obstacles.
    pub(super) fn world(&self) -> &[RoundedLink] {
        &self.world
    }

    /// The links that meet each other.
    pub(super) fn own(&self, prepared: &Prepared) -> &[RoundedLink] {
        if prepared.own_links.is_some() { &self.own } else { &self.world }
    }
}

/// What says where the links of sixteen states are.
#[derive(Clone, Copy)]
pub(super) struct Placed<'a> {
    pub(super) chain: &'a Chain,
    pub(super) drives: &'a Drives,
    /// Those that [`Chain::read`] leaves, and where their links are.
    pub(super) exact: u32,
    pub(super) frames: &'a LinkFrames,
}

impl Placed<'_> {
    /// Finds where the links and their spheres are in the states of which a bit is set, the links with spheres first.
    /// Returns what all joints slide together, metres.
    #[inline(always)]
    pub(super) fn place<L: Lanes>(
        &self,
        l: L,
        open: u32,
        links: &[LinkSpheres],
        to: &mut Vec<RoundedLink>,
    ) -> L::F {
        // Of a state alone fifteen lanes in sixteen would be computed in vain.
        if open == 1 {
            let sines = First::sines(l, &self.drives.rows);
            l.splat(self.placed(First::with(l, &sines), links, to))
        } else {
            self.placed(All(l), links, to)
        }
    }

    #[inline(always)]
    fn placed<N: Numbers>(&self, l: N, links: &[LinkSpheres], to: &mut Vec<RoundedLink>) -> N::F {
        let slid = self.chain.place(l, self.drives, to);
        for lane in bits(self.exact) {
            for (link, rounded) in links.iter().zip(to.iter_mut()) {
                let row = &self.frames.frames[link.link];
                for k in 0..12 {
                    rounded.frame[k].0[lane] = row[k][lane / HALF][lane % HALF] as f32;
                }
            }
        }
        self.finish(l, links, slid, to);
        slid
    }

    /// Finds where the spheres are of other bodies on the same links, which have been placed.
    #[inline(always)]
    pub(super) fn place_again<L: Lanes>(
        &self,
        l: L,
        links: &[LinkSpheres],
        (placed, slid): (&[RoundedLink], L::F),
        to: &mut Vec<RoundedLink>,
    ) {
        to.clear();
        to.extend_from_slice(placed);
        self.finish(All(l), links, slid, to);
    }

    #[inline(always)]
    fn finish<N: Numbers>(&self, l: N, links: &[LinkSpheres], slid: N::F, to: &mut [RoundedLink]) {
        for (number, link) in links.iter().enumerate() {
            let rounded = &mut to[number];
            let frame = loaded(l, &rounded.frame);
            let centre = link.centre.to_array();
            let centre =
                placed(l, &frame, [l.splat(centre[0]), l.splat(centre[1]), l.splat(centre[2])]);
            for axis in 0..3 {
                l.store(centre[axis], &mut rounded.centre.0[axis]);
            }
            let far = l.max(l.max(l.abs(frame[9]), l.abs(frame[10])), l.abs(frame[11]));
            let [still, per_slid] = self.chain.errors[number].of_size(link.size);
            let margin = l.mul_add(far, l.splat(MARGIN as f32), l.splat(link.margin + still));
            let margin = l.mul_add(slid, l.splat(per_slid), margin);
            l.store(margin, &mut rounded.margin);
        }
    }
}

#[inline(always)]
pub(super) fn splat<L: Lanes>(l: L, point: Vec3) -> [L::F; 3] {
    [l.splat(point.x), l.splat(point.y), l.splat(point.z)]
}

/// R·c + t.
#[inline(always)]
fn placed<N: Numbers>(l: N, frame: &[N::F; 12], [x, y, z]: [N::F; 3]) -> [N::F; 3] {
    let mut centre = [x; 3];
    for k in 0..3 {
        let sum = l.mul_add(frame[k], x, frame[9 + k]);
        centre[k] = l.mul_add(frame[6 + k], z, l.mul_add(frame[3 + k], y, sum));
    }
    centre
}

#[inline(always)]
pub(super) fn stored<L: Lanes>(l: L, centre: [L::F; 3]) -> Block {
    // Written out: the derived default is a call in a kernel.
    let mut block = Block([Row([0.0; WIDTH]); 3]);
    for axis in 0..3 {
        l.store(centre[axis], &mut block.0[axis]);
    }
    block
}

#[inline(always)]
fn of_block<L: Lanes>(l: L, Block([x, y, z]): &Block) -> [L::F; 3] {
    [l.load(x), l.load(y), l.load(z)]
}

impl RoundedLink {
    /// The link's own sphere in all sixteen states.
    #[inline(always)]
    pub(super) fn spheres<L: Lanes>(&self, l: L, link: &LinkSpheres) -> SpherePacket<L> {
        SpherePacket {
            centre: of_block(l, &self.centre),
            outer: l.splat(link.radius),
            inner: l.splat(f32::NEG_INFINITY),
            margin: l.load(&self.margin),
        }
    }

    /// Sixteen spheres on the link, in one of the states.
    #[inline(always)]
    pub(super) fn row<L: Lanes>(&self, l: L, row: &SphereRow, lane: usize) -> SpherePacket<L> {
        let mut frame = [l.splat(0.0); 12];
        for k in 0..12 {
            frame[k] = l.splat(self.frame[k].0[lane]);
        }
        SpherePacket {
            centre: placed(All(l), &frame, of_block(l, &row.centre)),
            outer: l.load(&row.outer),
            inner: l.load(&row.inner),
            margin: l.splat(self.margin.0[lane]),
        }
    }
}

/// The set bits of a number, the least first.
pub(super) fn bits(mut of: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let bit = (of != 0).then(|| of.trailing_zeros() as usize)?;
        of &= of - 1;
        Some(bit)
    })
}
