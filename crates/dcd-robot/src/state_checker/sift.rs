//! Sixteen states against everything, by spheres: what is proved to touch, and what is left.

// In kernels: an iterator that is left out of line costs more than the loop.
#![allow(clippy::needless_range_loop)]

use super::link_frames::LinkFrames;
use super::links::{LinkSpheres, SphereRow};
use super::obstacle_tree::ObstacleTree;
use super::prepared::Prepared;
use super::solids::{Reached, Solid, inside, within};
use super::{Goal, MARGIN, Sixteen};
use dcd_geom::Aabb;
use dcd_pipeline::{Candidate, Other};
use dcd_simd::{Block, Kernel, Lanes, Row, WIDTH};
use glam::Vec3;

/// What the spheres of some states tell.
#[derive(Clone, Debug, Default)]
pub(super) struct Found {
    /// Pairs that are proved to touch: of each state all, or one where only one is asked for.
    pub(super) touching: Vec<Candidate>,
    /// Pairs that may touch, each with a direction from what the link may touch to the link.
    pub(super) candidates: Vec<(Candidate, Vec3)>,
}

/// The links of sixteen states in f32.
#[derive(Clone, Debug, Default)]
pub(super) struct Rounded {
    pub(super) world: Vec<RoundedLink>,
    own: Vec<RoundedLink>,
    near: Vec<(u32, u32)>,
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

/// Compares the spheres of sixteen states.
pub(super) struct Sift<'a> {
    pub(super) prepared: &'a Prepared,
    pub(super) frames: &'a LinkFrames,
    pub(super) rounded: &'a mut Rounded,
    /// The number of the first state.
    pub(super) first: u32,
    /// The states that there are, a bit each.
    pub(super) open: u32,
    pub(super) goal: Goal,
    pub(super) found: &'a mut Found,
}

impl Kernel for Sift<'_> {
    /// The states that have no hit yet, where one is enough.
    type Output = u32;

    #[inline(always)]
    fn run<L: Lanes>(mut self, l: L) -> u32 {
        let Rounded { world, own, near } = std::mem::take(self.rounded);
        let (mut world, mut own, mut near) = (world, own, near);
        round(l, &self.prepared.world_links, self.frames, &mut world);
        if self.prepared.tree.is_none() && self.is_few(world.len()) {
            self.few_against_obstacles(l, &world, &mut near);
        } else {
            for (link, rounded) in self.prepared.world_links.iter().zip(&world) {
                self.against_obstacles(l, (link, rounded), &mut near);
            }
        }
        let own_links = self.prepared.own_links();
        if self.prepared.own_links.is_some() {
            round(l, own_links, self.frames, &mut own);
        }
        let rounded = if self.prepared.own_links.is_some() { &own } else { &world };
        if self.is_few(self.prepared.link_pairs.len()) {
            self.few_against_each_other(l, rounded);
        } else {
            for &[a, b] in &self.prepared.link_pairs {
                let of = |k: u32| (&own_links[k as usize], &rounded[k as usize]);
                self.against_each_other(l, of(a), of(b));
            }
        }
        *self.rounded = Rounded { world, own, near };
        self.open
    }
}

/// Rounds the links' frames, and finds where their spheres are.
#[inline(always)]
pub(super) fn round<L: Lanes>(
    l: L,
    links: &[LinkSpheres],
    frames: &LinkFrames,
    to: &mut Vec<RoundedLink>,
) {
    to.resize(links.len(), RoundedLink::default());
    for (link, rounded) in links.iter().zip(to) {
        let row = &frames.frames[link.link];
        for k in 0..12 {
            l.store(l.round_from([&row[k][0], &row[k][1]]), &mut rounded.frame[k]);
        }
        let frame = loaded(l, &rounded.frame);
        let centre = placed(l, &frame, splat(l, link.centre));
        rounded.centre = stored(l, centre);
        let far = l.max(l.max(l.abs(frame[9]), l.abs(frame[10])), l.abs(frame[11]));
        let margin = l.mul_add(far, l.splat(MARGIN as f32), l.splat(link.margin));
        l.store(margin, &mut rounded.margin);
    }
}

#[inline(always)]
fn loaded<L: Lanes>(l: L, rows: &[Row; 12]) -> [L::F; 12] {
    let mut frame = [l.splat(0.0); 12];
    for k in 0..12 {
        frame[k] = l.load(&rows[k]);
    }
    frame
}

#[inline(always)]
fn splat<L: Lanes>(l: L, point: Vec3) -> [L::F; 3] {
    [l.splat(point.x), l.splat(point.y), l.splat(point.z)]
}

/// R·c + t.
#[inline(always)]
fn placed<L: Lanes>(l: L, frame: &[L::F; 12], [x, y, z]: [L::F; 3]) -> [L::F; 3] {
    let mut centre = [x; 3];
    for k in 0..3 {
        let sum = l.mul_add(frame[k], x, frame[9 + k]);
        centre[k] = l.mul_add(frame[6 + k], z, l.mul_add(frame[3 + k], y, sum));
    }
    centre
}

#[inline(always)]
pub(super) fn stored<L: Lanes>(l: L, centre: [L::F; 3]) -> Block {
    let mut block = Block::default();
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
    /// Lists the obstacles whose boxes are near a sphere of that radius, state by state.
    fn ask(&self, radius: f32, open: u32, tree: &ObstacleTree, near: &mut Vec<(u32, u32)>) {
        let mut aabbs = [Aabb::EMPTY; WIDTH];
        for lane in bits(open) {
            let (centre, radius) = (self.centre.point(lane), radius + self.margin.0[lane]);
            let aabb = Aabb { min: centre - radius, max: centre + radius };
            // Written so that a NaN is near everything.
            let is_known = aabb.min.is_finite() && aabb.max.is_finite();
            aabbs[lane] = if is_known { aabb } else { Aabb::EVERYTHING };
        }
        tree.reached(&aabbs, |obstacle, lane| {
            if open >> lane & 1 == 1 {
                near.push((obstacle, 1 << lane));
            }
        });
    }

    /// The link's own sphere in all sixteen states.
    #[inline(always)]
    fn spheres<L: Lanes>(&self, l: L, link: &LinkSpheres) -> Sixteen<L> {
        Sixteen {
            centre: of_block(l, &self.centre),
            outer: l.splat(link.radius),
            inner: l.splat(f32::NEG_INFINITY),
            margin: l.load(&self.margin),
        }
    }

    /// Sixteen spheres on the link, in one of the states.
    #[inline(always)]
    pub(super) fn row<L: Lanes>(&self, l: L, row: &SphereRow, lane: usize) -> Sixteen<L> {
        let mut frame = [l.splat(0.0); 12];
        for k in 0..12 {
            frame[k] = l.splat(self.frame[k].0[lane]);
        }
        Sixteen {
            centre: placed(l, &frame, of_block(l, &row.centre)),
            outer: l.load(&row.outer),
            inner: l.load(&row.inner),
            margin: l.splat(self.margin.0[lane]),
        }
    }
}

/// The spheres of up to sixteen links in one state.
#[derive(Default)]
struct Gathered {
    centre: Block,
    radius: Row,
    margin: Row,
}

impl Gathered {
    #[inline(always)]
    fn set(&mut self, k: usize, (link, rounded): (&LinkSpheres, &RoundedLink), lane: usize) {
        // Not zipped: in a function of another CPU feature that is a call.
        for axis in 0..3 {
            self.centre.0[axis].0[k] = rounded.centre.0[axis].0[lane];
        }
        (self.radius.0[k], self.margin.0[k]) = (link.radius, rounded.margin.0[lane]);
    }

    #[inline(always)]
    fn spheres<L: Lanes>(&self, l: L) -> Sixteen<L> {
        Sixteen {
            centre: of_block(l, &self.centre),
            outer: l.load(&self.radius),
            inner: l.splat(f32::NEG_INFINITY),
            margin: l.load(&self.margin),
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

impl Sift<'_> {
    #[inline(always)]
    fn against_obstacles<L: Lanes>(
        &mut self,
        l: L,
        (link, rounded): (&LinkSpheres, &RoundedLink),
        near: &mut Vec<(u32, u32)>,
    ) {
        near.clear();
        match &self.prepared.tree {
            None => self.compare_all(l, (link, rounded), near),
            Some(tree) => rounded.ask(link.radius, self.open, tree, near),
        }
        let any = near.iter().fold(0, |any, &(_, states)| any | states);
        for lane in bits(any) {
            self.rows_against(l, (link, rounded), lane, (near, lane));
        }
    }

    /// The spheres of a link in one state against obstacles, those of which a bit is set.
    #[inline(always)]
    fn rows_against<L: Lanes>(
        &mut self,
        l: L,
        (link, rounded): (&LinkSpheres, &RoundedLink),
        lane: usize,
        (near, bit): (&[(u32, u32)], usize),
    ) {
        for row in &link.rows {
            let spheres = rounded.row(l, row, lane);
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

    /// Whether so many comparisons are fewer with sixteen of one state together than one of sixteen states.
    fn is_few(&self, comparisons: usize) -> bool {
        (self.open.count_ones() as usize) * comparisons.div_ceil(WIDTH) < comparisons
    }

    /// Sixteen links of one state at a time against each obstacle: what is found is the same, in the same order for
    /// each state.
    #[inline(always)]
    fn few_against_obstacles<L: Lanes>(
        &mut self,
        l: L,
        rounded: &[RoundedLink],
        near: &mut Vec<(u32, u32)>,
    ) {
        let links = &self.prepared.world_links;
        for lane in bits(self.open) {
            for (links, rounded) in links.chunks(WIDTH).zip(rounded.chunks(WIDTH)) {
                let mut gathered = Gathered::default();
                for (k, link) in links.iter().zip(rounded).enumerate() {
                    gathered.set(k, link, lane);
                }
                let (spheres, filled) = (gathered.spheres(l), (1 << links.len()) - 1);
                near.clear();
                for (number, solid) in (0..).zip(&self.prepared.solids) {
                    let marked = solid.reached(l, &spheres).near & filled;
                    if marked != 0 {
                        near.push((number, marked));
                    }
                }
                let any = near.iter().fold(0, |any, &(_, marked)| any | marked);
                for k in bits(any) {
                    self.rows_against(l, (&links[k], &rounded[k]), lane, (near, k));
                }
            }
        }
    }

    /// Sixteen pairs of links of one state at a time.
    #[inline(always)]
    fn few_against_each_other<L: Lanes>(&mut self, l: L, rounded: &[RoundedLink]) {
        let prepared = self.prepared;
        let of = |k: u32| (&prepared.own_links()[k as usize], &rounded[k as usize]);
        for lane in bits(self.open) {
            for pairs in prepared.link_pairs.chunks(WIDTH) {
                let [mut one, mut other] = [Gathered::default(), Gathered::default()];
                for (k, &[a, b]) in pairs.iter().enumerate() {
                    one.set(k, of(a), lane);
                    other.set(k, of(b), lane);
                }
                let near = meeting(l, &one.spheres(l), &other.spheres(l)).near;
                for k in bits(near & ((1 << pairs.len()) - 1)) {
                    if self.open >> lane & 1 == 1 {
                        let [a, b] = pairs[k];
                        self.rows_against_each_other(l, of(a), of(b), lane);
                    }
                }
            }
        }
    }

    /// Lists the obstacles near a link and in which states.
    #[inline(always)]
    fn compare_all<L: Lanes>(
        &self,
        l: L,
        (link, rounded): (&LinkSpheres, &RoundedLink),
        near: &mut Vec<(u32, u32)>,
    ) {
        let spheres = rounded.spheres(l, link);
        for (number, solid) in (0..).zip(&self.prepared.solids) {
            let states = solid.reached(l, &spheres).near & self.open;
            if states != 0 {
                near.push((number, states));
            }
        }
    }

    #[inline(always)]
    fn against_each_other<L: Lanes>(
        &mut self,
        l: L,
        a: (&LinkSpheres, &RoundedLink),
        b: (&LinkSpheres, &RoundedLink),
    ) {
        let (of_a, of_b) = (a.1.spheres(l, a.0), b.1.spheres(l, b.0));
        let states = meeting(l, &of_a, &of_b).near & self.open;
        for lane in bits(states) {
            self.rows_against_each_other(l, a, b, lane);
        }
    }

    /// The spheres of two links in one state.
    #[inline(always)]
    fn rows_against_each_other<L: Lanes>(
        &mut self,
        l: L,
        a: (&LinkSpheres, &RoundedLink),
        b: (&LinkSpheres, &RoundedLink),
        lane: usize,
    ) {
        // The spheres of one link that reach the other link's own.
        let own = Sixteen {
            centre: splat(l, a.1.centre.point(lane)),
            outer: l.splat(a.0.radius),
            inner: l.splat(f32::NEG_INFINITY),
            margin: l.splat(a.1.margin.0[lane]),
        };
        for row in &b.0.rows {
            let of_b = b.1.row(l, row, lane);
            let candidates = meeting(l, &own, &of_b).near & row.filled;
            if candidates == 0 {
                continue;
            }
            let of_row = stored(l, of_b.centre);
            for other in &a.0.rows {
                let of_a = a.1.row(l, other, lane);
                let at = stored(l, of_a.centre);
                // Of all spheres of one body together.
                let (mut body, mut of_body) = (u32::MAX, Vec3::ZERO);
                let mut all = Reached::default();
                for k in bits(candidates) {
                    if row.bodies[k] != body {
                        let towards = |k: usize| of_body - at.point(k);
                        self.note(lane, other, Other::Link(body), all, towards);
                        (body, all) = (row.bodies[k], Reached::default());
                    }
                    let one = Sixteen {
                        centre: splat(l, of_row.point(k)),
                        outer: l.splat(row.outer.0[k]),
                        inner: l.splat(row.inner.0[k]),
                        margin: of_b.margin,
                    };
                    let Reached { near, touched } = meeting(l, &of_a, &one);
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
        reached: Reached,
        towards: impl Fn(usize) -> Vec3,
    ) {
        let (mut near, touched) = (reached.near & row.filled, reached.touched & row.filled);
        while near != 0 && self.open >> lane & 1 == 1 {
            let k = near.trailing_zeros() as usize;
            let same = row.same[k];
            near &= !same;
            let is_touching = touched & same != 0;
            self.note_body(lane, (row.bodies[k], other), is_touching, towards(k));
        }
    }

    fn note_body(
        &mut self,
        lane: usize,
        (body, other): (u32, Other),
        is_touching: bool,
        towards: Vec3,
    ) {
        if !self.prepared.allows(body, other) {
            return;
        }
        let (link, other, towards) = match other {
            // Told from the body to the other one.
            Other::Link(other) if other > body => (other, Other::Link(body), towards),
            Other::Link(other) => (body, Other::Link(other), -towards),
            obstacle => (body, obstacle, towards),
        };
        let configuration = self.first + lane as u32;
        let candidate = Candidate { configuration, link, other };
        if !is_touching {
            self.found.candidates.push((candidate, towards));
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
fn meeting<L: Lanes>(l: L, a: &Sixteen<L>, b: &Sixteen<L>) -> Reached {
    let x = l.sub(a.centre[0], b.centre[0]);
    let y = l.sub(a.centre[1], b.centre[1]);
    let z = l.sub(a.centre[2], b.centre[2]);
    let square = l.mul_add(x, x, l.mul_add(y, y, l.mul(z, z)));
    let margin = l.add(a.margin, b.margin);
    let near = within(l, square, l.add(l.add(a.outer, b.outer), margin));
    let touched = inside(l, square, l.sub(l.add(a.inner, b.inner), margin));
    Reached { near: near | touched, touched }
}

/// Number of lanes, as the masks have them.
const _: () = assert!(WIDTH == 16);
