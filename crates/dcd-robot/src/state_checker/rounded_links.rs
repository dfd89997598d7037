//! The links of sixteen states, and their spheres, in f32.

// In kernels: an iterator that is left out of line costs more than the loop.
#![allow(clippy::needless_range_loop)]

use super::alone::LinkRow;
use super::chain::{Chain, Drives, loaded};
use super::link_frames::{HALF, LinkFrames};
use super::links::LinkSpheres;
use super::numbers::{All, One};
use super::obstacle_tree::NearObstacles;
use super::one_link::{LinkPlace, LinkPlaces, OneState};
use super::{MARGIN, SpherePacket};
use dcd_geom::Aabb;
use dcd_simd::{Block, Lanes, Row, WIDTH};
use glam::Vec3;

/// The links of sixteen states in f32.
#[derive(Clone, Debug, Default)]
pub(super) struct Rounded {
    pub(super) world: Vec<RoundedLink>,
    pub(super) own: Vec<RoundedLink>,
    /// The obstacles near a link, each with the states in which it is.
    pub(super) near: NearObstacles,
    /// A box round each link in all states of a packet.
    pub(super) aabbs: Vec<Aabb>,
    /// Of a state alone, in place of those above.
    pub(super) one: OneRounded,
}

/// The links of a state alone.
#[derive(Clone, Debug, Default)]
pub(super) struct OneRounded {
    /// See [`OneState`].
    frames: Vec<Row>,
    world: Vec<LinkSphereRow>,
    own: Vec<LinkSphereRow>,
}

/// The spheres round what each of sixteen links carries, in the world, metres.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LinkSphereRow {
    pub(super) centre: Block,
    /// By how much a comparison of anything on the link may be off.
    pub(super) margin: Row,
}

impl OneRounded {
    /// Where the links are with what meets obstacles.
    #[inline(always)]
    pub(super) fn world(&self) -> OneState<'_> {
        OneState { frames: &self.frames, spheres: &self.world }
    }

    /// Where they are with what meets the robot, if that is not the same.
    #[inline(always)]
    pub(super) fn own(&self) -> OneState<'_> {
        OneState { frames: &self.frames, spheres: &self.own }
    }

    /// Finds the spheres of other bodies on the same links, which have been placed.
    #[inline(always)]
    pub(super) fn place_own<L: Lanes>(&mut self, l: L, rows: &[LinkRow], slid: f32) {
        finish_rows(l, rows, (&self.frames, slid), &mut self.own);
    }
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
    /// Finds where the links and their spheres are in sixteen states, the links with spheres first. Returns what all joints
    /// slide together, metres.
    #[inline(always)]
    pub(super) fn place<L: Lanes>(
        &self,
        l: L,
        links: &[LinkSpheres],
        to: &mut Vec<RoundedLink>,
    ) -> L::F {
        let slid = self.chain.place(All(l), self.drives, to);
        for lane in bits(self.exact) {
            for (link, rounded) in links.iter().zip(to.iter_mut()) {
                let row = &self.frames.frames[link.link];
                for k in 0..12 {
                    rounded.frame[k].0[lane] = row[k][lane / HALF][lane % HALF] as f32;
                }
            }
        }
        finish(l, links, slid, to);
        slid
    }

    /// The same of the state of a lane alone, sixteen links to a row.
    #[inline(always)]
    pub(super) fn place_alone<L: Lanes>(
        &self,
        l: L,
        (links, rows, lane): (&[LinkSpheres], &[LinkRow], usize),
        to: &mut OneRounded,
    ) -> f32 {
        let by = l.load(self.drives.alone(lane));
        let slid = self.place_frames(l, (by, lane), &mut to.frames);
        let OneRounded { frames, world, .. } = to;
        if self.exact >> lane & 1 == 1 {
            for (link, frame) in links.iter().zip(&mut *frames) {
                let numbers = &self.frames.frames[link.link];
                for k in 0..12 {
                    frame.0[k / 3 * 4 + k % 3] = numbers[k][lane / HALF][lane % HALF] as f32;
                }
            }
        }
        finish_rows(l, rows, (frames, slid), world);
        slid
    }

    /// The same of a state that the bounds cover, by what [`Chain::read_alone`] takes of it.
    #[inline(always)]
    pub(super) fn place_read<L: Lanes>(
        &self,
        l: L,
        (rows, by): (&[LinkRow], L::F),
        to: &mut OneRounded,
    ) -> f32 {
        let slid = self.place_frames(l, (by, 0), &mut to.frames);
        finish_rows(l, rows, (&to.frames, slid), &mut to.world);
        slid
    }

    /// Finds the links of a state alone, by what moves its first sixteen joints.
    #[inline(always)]
    fn place_frames<L: Lanes>(&self, l: L, (by, lane): (L::F, usize), to: &mut Vec<Row>) -> f32 {
        let moved = One::moved(l, by);
        self.chain.place_alone(One::with(l, lane, &moved), self.drives, to)
    }
}

/// Finds the spheres of a state alone, sixteen links at a time.
#[inline(always)]
fn finish_rows<L: Lanes>(
    l: L,
    rows: &[LinkRow],
    (frames, slid): (&[Row], f32),
    to: &mut Vec<LinkSphereRow>,
) {
    if to.len() != rows.len() {
        to.resize(rows.len(), LinkSphereRow::default());
    }
    let (frames, _) = frames.as_chunks();
    for ((row, frames), to) in rows.iter().zip(frames).zip(to) {
        let [a, b, c, _, d, e, f, _, g, h, i, _, x, y, z, _] = l.transpose(frames);
        let frame = [a, b, c, d, e, f, g, h, i, x, y, z];
        let (centre, lost) =
            (of_block(l, &row.centre), [l.load(&row.lost[0]), l.load(&row.lost[1])]);
        (to.centre, to.margin) = spheres_of(l, &frame, (centre, lost), l.splat(slid));
    }
}

/// Finds where the spheres are of other bodies on the same links, which have been placed.
#[inline(always)]
pub(super) fn place_again<L: Lanes>(
    l: L,
    links: &[LinkSpheres],
    (placed, slid): (&[RoundedLink], L::F),
    to: &mut Vec<RoundedLink>,
) {
    to.clear();
    to.extend_from_slice(placed);
    finish(l, links, slid, to);
}

#[inline(always)]
fn finish<L: Lanes>(l: L, links: &[LinkSpheres], slid: L::F, to: &mut [RoundedLink]) {
    for (number, link) in links.iter().enumerate() {
        let rounded = &mut to[number];
        let (centre, lost) = (splat(l, link.centre), link.lost.map(|lost| l.splat(lost)));
        let frame = loaded(All(l), &rounded.frame);
        (rounded.centre, rounded.margin) = spheres_of(l, &frame, (centre, lost), slid);
    }
}

/// The centres in the world of spheres round what links carry, and the margins, by the links' frames, the centres in these,
/// [`LinkSpheres::lost`] and what all joints slide together.
#[inline(always)]
fn spheres_of<L: Lanes>(
    l: L,
    frame: &[L::F; 12],
    (centre, [still, per_slid]): ([L::F; 3], [L::F; 2]),
    slid: L::F,
) -> (Block, Row) {
    let far = l.max(l.max(l.abs(frame[9]), l.abs(frame[10])), l.abs(frame[11]));
    let of_place = l.mul_add(far, l.splat(MARGIN as f32), still);
    let mut margin = Row([0.0; WIDTH]);
    l.store(l.mul_add(slid, per_slid, of_place), &mut margin);
    (stored(l, placed(l, frame, centre)), margin)
}

#[inline(always)]
pub(super) fn splat<L: Lanes>(l: L, point: Vec3) -> [L::F; 3] {
    [l.splat(point.x), l.splat(point.y), l.splat(point.z)]
}

/// R·c + t.
#[inline(always)]
pub(super) fn placed<L: Lanes>(l: L, frame: &[L::F; 12], [x, y, z]: [L::F; 3]) -> [L::F; 3] {
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
pub(super) fn of_block<L: Lanes>(l: L, Block([x, y, z]): &Block) -> [L::F; 3] {
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
}

/// A link in one of the states.
#[derive(Clone, Copy)]
pub(super) struct InLane<'a> {
    link: &'a RoundedLink,
    lane: usize,
}

/// The links in one of the states.
impl<'a> LinkPlaces for (&'a [RoundedLink], usize) {
    type Link = InLane<'a>;

    #[inline(always)]
    fn at(self, slot: usize) -> InLane<'a> {
        InLane { link: &self.0[slot], lane: self.1 }
    }
}

impl LinkPlace for InLane<'_> {
    #[inline(always)]
    fn number(self, k: usize) -> f32 {
        self.link.frame[k].0[self.lane]
    }

    #[inline(always)]
    fn centre(self) -> Vec3 {
        self.link.centre.point(self.lane)
    }

    #[inline(always)]
    fn margin(self) -> f32 {
        self.link.margin.0[self.lane]
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
