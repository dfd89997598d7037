//! Sixteen states against everything, by spheres: what is proved to touch, and what is left.

use super::links::{LinkSpheres, SphereRow};
use super::obstacle_tree::NearObstacles;
use super::one_link::{LinkPlace, LinkPlaces};
use super::packed_aabbs::{around, overlap};
use super::prepared::Prepared;
use super::rounded_links::{Placed, Rounded, RoundedLink, bits, place_again, splat, stored};
use super::solids::{Overlaps, Solid, inside, within};
use super::{Goal, SpherePacket};
use dcd_geom::Aabb;
use dcd_pipeline::{Candidate, Other};
use dcd_simd::{Kernel, Lanes, Row, WIDTH};
use glam::Vec3;

/// What the spheres of some states prove, and what they leave open.
#[derive(Clone, Debug, Default)]
pub(super) struct Found {
    /// Pairs that are proved to touch: of each state all, or one where one is enough.
    pub(super) touching: Vec<Candidate>,
    /// Pairs that may touch, each with a direction from what the link may touch to the link.
    pub(super) candidates: Vec<(Candidate, Vec3)>,
}

/// Compares the spheres of sixteen states.
pub(super) struct Sift<'a> {
    pub(super) prepared: &'a Prepared,
    pub(super) placed: Placed<'a>,
    /// The number of the first state.
    pub(super) first: u32,
    /// The states that there are, a bit each.
    pub(super) open: u32,
    pub(super) goal: Goal,
    pub(super) found: &'a mut Found,
}

/// With the memory of where the links are.
pub(super) struct SiftPacket<'a>(pub(super) Sift<'a>, pub(super) &'a mut Rounded);

impl Kernel for SiftPacket<'_> {
    /// The states that have no hit yet, where one is enough.
    type Output = u32;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> u32 {
        let Self(mut sift, rounded) = self;
        sift.together(l, rounded);
        sift.open
    }
}

/// One state alone: with its values, if they were not read.
pub(super) struct SiftState<'a>(
    pub(super) Sift<'a>,
    pub(super) &'a mut Rounded,
    pub(super) Option<&'a [f64]>,
);

impl Kernel for SiftState<'_> {
    /// As of a packet; `None`, and nothing is done, of values that [`Chain::read_alone`](super::chain::Chain::read_alone)
    /// does not take.
    type Output = Option<u32>;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Option<u32> {
        let Self(mut sift, Rounded { one, near, .. }, values) = self;
        let state = sift.open.trailing_zeros() as usize;
        let (prepared, placed) = (sift.prepared, sift.placed);
        let (links, rows) = (&*prepared.world_links, &*prepared.world_rows);
        let slid = match values {
            Some(values) => {
                let by = placed.chain.read_alone(l, values)?;
                placed.place_read(l, (rows, by), one)
            }
            None => placed.place_alone(l, (links, rows, state), one),
        };
        sift.alone(l, (state, slid), one, near);
        Some(sift.open)
    }
}

/// Whether of a packet's states one is taken up alone: its links are in the lanes then, [`Rounded::one`].
pub(super) fn is_alone(states: u32) -> bool {
    states.is_power_of_two()
}

/// Up to how many states of a packet are taken up one by one: of more, sixteen states' lanes take less time. Of the Panda
/// as spheres two, three and four took 1.9, 1.4 and 1.1 times as long together. No effect on any answer.
pub(super) const MOST_ALONE: usize = 4;

/// The states of a packet of so many that are taken up at once, a bit each.
pub(super) fn taken_up(states: usize) -> impl Iterator<Item = u32> {
    let (count, at_once) = if states <= MOST_ALONE { (states, 1) } else { (1, states) };
    (0..count).map(move |first| ((1 << at_once) - 1) << first)
}

/// A box round each link in all of some states.
#[inline(always)]
fn boxed<L: Lanes>(
    l: L,
    links: &[LinkSpheres],
    rounded: &[RoundedLink],
    open: u32,
    aabbs: &mut Vec<Aabb>,
) {
    aabbs.clear();
    for (k, link) in links.iter().enumerate() {
        aabbs.push(around(l, &rounded[k].spheres(l, link), open));
    }
}

impl Sift<'_> {
    /// Several states: each link in all of them against one obstacle or another link.
    #[inline(always)]
    fn together<L: Lanes>(&mut self, l: L, rounded: &mut Rounded) {
        let Rounded { world, own, near, aabbs, .. } = rounded;
        let (world_links, own_links) = (&self.prepared.world_links, self.prepared.own_links());
        let slid = self.placed.place(l, world_links, world);
        boxed(l, world_links, world, self.open, aabbs);
        for (slot, aabb) in aabbs.iter().enumerate() {
            if self.open == 0 {
                return;
            }
            self.against_obstacles(l, (world_links, world), (slot, aabb), near);
        }
        if self.prepared.own_links.is_some() {
            place_again(l, own_links, (world, slid), own);
            boxed(l, own_links, own, self.open, aabbs);
        }
        let placed = if self.prepared.own_links.is_some() { &*own } else { &*world };
        for &[a, b] in &self.prepared.link_pairs {
            if self.open != 0 && overlap(&aabbs[a as usize], &aabbs[b as usize]) {
                self.against_each_other(l, (own_links, placed), [a as usize, b as usize]);
            }
        }
    }

    #[inline(always)]
    fn against_obstacles<L: Lanes>(
        &mut self,
        l: L,
        (links, placed): (&[LinkSpheres], &[RoundedLink]),
        (slot, aabb): (usize, &Aabb),
        near: &mut NearObstacles,
    ) {
        let (link, rounded) = (&links[slot], &placed[slot]);
        self.list_near(l, (&rounded.spheres(l, link), self.open), aabb, near);
        let any = near.listed.iter().fold(0, |any, &(_, states)| any | states);
        for lane in bits(any) {
            self.rows_against(l, (link, (placed, lane).at(slot)), lane, (&near.listed, lane));
        }
    }

    /// The spheres of a link in one state against obstacles, those of which a bit is set.
    #[inline(always)]
    pub(super) fn rows_against<L: Lanes>(
        &mut self,
        l: L,
        (link, placed): (&LinkSpheres, impl LinkPlace),
        lane: usize,
        (near, bit): (&[(u32, u32)], usize),
    ) {
        for row in &link.rows {
            let spheres = placed.row(l, row);
            for &(number, marked) in near {
                if marked >> bit & 1 == 0 || self.open >> lane & 1 == 0 {
                    continue;
                }
                let solid: &Solid = &self.prepared.solids[number as usize];
                let reached = solid.reached(l, &spheres);
                if reached.near & row.filled != 0 {
                    let at = stored(l, spheres.centre);
                    let towards = |k: usize| solid.towards(at.point(k));
                    self.note(lane, row, Other::Obstacle(number), reached, towards);
                }
            }
        }
    }

    /// Lists the obstacles that are near some of sixteen spheres, within a box round those, and near which, a bit each.
    #[inline(always)]
    pub(super) fn list_near<L: Lanes>(
        &self,
        l: L,
        (spheres, some): (&SpherePacket<L>, u32),
        aabb: &Aabb,
        near: &mut NearObstacles,
    ) {
        near.listed.clear();
        if let Some(tree) = &self.prepared.tree {
            let mut reach = Row([0.0; WIDTH]);
            l.store(l.add(spheres.outer, spheres.margin), &mut reach);
            let stored = (&stored(l, spheres.centre), &reach);
            tree.list_near(stored, some, &self.prepared.aabbs, near);
            near.listed.retain_mut(|(number, which)| {
                *which &= self.prepared.solids[*number as usize].near(l, spheres);
                *which != 0
            });
            return;
        }
        for (first, row) in self.prepared.boxes.iter().enumerate() {
            for k in bits(row.overlapped(l, aabb)) {
                let number = first * WIDTH + k;
                let which = self.prepared.solids[number].near(l, spheres) & some;
                if which != 0 {
                    near.listed.push((number as u32, which));
                }
            }
        }
    }

    #[inline(always)]
    fn against_each_other<L: Lanes>(
        &mut self,
        l: L,
        (links, placed): (&[LinkSpheres], &[RoundedLink]),
        [a, b]: [usize; 2],
    ) {
        let (of_a, of_b) = (placed[a].spheres(l, &links[a]), placed[b].spheres(l, &links[b]));
        let states = near_spheres(l, &of_a, &of_b) & self.open;
        for lane in bits(states) {
            let of = |slot: usize| (&links[slot], (placed, lane).at(slot));
            self.rows_against_each_other(l, of(a), of(b), lane);
        }
    }

    /// The spheres of two links in one state.
    #[inline(always)]
    pub(super) fn rows_against_each_other<L: Lanes, P: LinkPlace>(
        &mut self,
        l: L,
        a: (&LinkSpheres, P),
        b: (&LinkSpheres, P),
        lane: usize,
    ) {
        // The spheres of one link that reach the other link's own.
        let own = SpherePacket {
            centre: splat(l, a.1.centre()),
            outer: l.splat(a.0.radius),
            inner: l.splat(f32::NEG_INFINITY),
            margin: l.splat(a.1.margin()),
        };
        for row in &b.0.rows {
            let of_b = b.1.row(l, row);
            let candidates = near_spheres(l, &own, &of_b) & row.filled;
            if candidates == 0 {
                continue;
            }
            let of_row = stored(l, of_b.centre);
            for other in &a.0.rows {
                let of_a = a.1.row(l, other);
                let at = stored(l, of_a.centre);
                // Of all spheres of one body together.
                let (mut body, mut of_body) = (u32::MAX, Vec3::ZERO);
                let mut all = Overlaps::default();
                for k in bits(candidates) {
                    if row.bodies[k] != body {
                        let towards = |k: usize| of_body - at.point(k);
                        self.note(lane, other, Other::Link(body), all, towards);
                        (body, all) = (row.bodies[k], Overlaps::default());
                    }
                    let one = SpherePacket {
                        centre: splat(l, of_row.point(k)),
                        outer: l.splat(row.outer.0[k]),
                        inner: l.splat(row.inner.0[k]),
                        margin: of_b.margin,
                    };
                    let Overlaps { near, touched } = meeting(l, &of_a, &one);
                    if all.near == 0 && near & other.filled != 0 {
                        of_body = of_row.point(k);
                    }
                    all.near |= near;
                    all.touched |= touched;
                }
                let towards = |k: usize| of_body - at.point(k);
                self.note(lane, other, Other::Link(body), all, towards);
            }
        }
    }

    /// Notes the bodies of a row that something is near.
    #[inline(always)]
    fn note(
        &mut self,
        lane: usize,
        row: &SphereRow,
        other: Other,
        reached: Overlaps,
        towards: impl Fn(usize) -> Vec3,
    ) {
        let (mut near, touched) = (reached.near & row.filled, reached.touched & row.filled);
        while near != 0 && self.open >> lane & 1 == 1 {
            let k = near.trailing_zeros() as usize;
            let same = row.same[k];
            near &= !same;
            let is_touching = touched & same != 0;
            self.note_body(lane, (row.bodies[k], other), is_touching, || towards(k));
        }
    }

    fn note_body(
        &mut self,
        lane: usize,
        (body, other): (u32, Other),
        is_touching: bool,
        towards: impl FnOnce() -> Vec3,
    ) {
        // A link that is compared with itself has each of its bodies twice.
        if other == Other::Link(body) || !self.prepared.allows(body, other) {
            return;
        }
        let (link, other, sense) = match other {
            // Reported as from the body to the other one.
            Other::Link(other) if other > body => (other, Other::Link(body), 1.0),
            Other::Link(other) => (body, Other::Link(other), -1.0),
            obstacle => (body, obstacle, 1.0),
        };
        let configuration = self.first + lane as u32;
        let candidate = Candidate { configuration, link, other };
        if !is_touching {
            self.found.candidates.push((candidate, towards() * sense));
            return;
        }
        self.found.touching.push(candidate);
        if self.goal == Goal::One {
            self.open &= !(1 << lane);
        }
    }
}

/// Which spheres of the same number meet.
#[inline(always)]
pub(super) fn meeting<L: Lanes>(l: L, a: &SpherePacket<L>, b: &SpherePacket<L>) -> Overlaps {
    let (square, margin) = (between(l, a, b), l.add(a.margin, b.margin));
    let near = within(l, square, l.add(l.add(a.outer, b.outer), margin));
    let touched = inside(l, square, l.sub(l.add(a.inner, b.inner), margin));
    Overlaps { near: near | touched, touched }
}

/// The same of spheres round links, which prove no contact.
#[inline(always)]
pub(super) fn near_spheres<L: Lanes>(l: L, a: &SpherePacket<L>, b: &SpherePacket<L>) -> u32 {
    within(l, between(l, a, b), l.add(l.add(a.outer, b.outer), l.add(a.margin, b.margin)))
}

/// The squared distances of the centres, m².
#[inline(always)]
fn between<L: Lanes>(l: L, a: &SpherePacket<L>, b: &SpherePacket<L>) -> L::F {
    let x = l.sub(a.centre[0], b.centre[0]);
    let y = l.sub(a.centre[1], b.centre[1]);
    let z = l.sub(a.centre[2], b.centre[2]);
    l.mul_add(x, x, l.mul_add(y, y, l.mul(z, z)))
}

/// Number of lanes, as the masks have them.
const _: () = assert!(WIDTH == 16);
