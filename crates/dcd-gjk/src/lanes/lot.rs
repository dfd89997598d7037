//! Pairs on their way through the stages, sixteen at a time.

use super::vector::V3;
use dcd_geom::glam::Vec3;
use dcd_geom::lanes::{IndexRow, Lanes, Row, WIDTH};

/// Sixteen pairs and what is known of them, row by row. Lengths are metres, in world axes; every
/// point is one of A − B.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Lot {
    /// Each pair's number in its slice.
    pub(super) number: IndexRow,
    /// The vertices of object a.
    pub(super) a: Side,
    /// The vertices of object b.
    pub(super) b: Side,
    /// Bit k: pair k has a portal that the ray from c to the origin passes.
    pub(super) found: u32,
    rows: [Row; 19],
}

/// Where sixteen objects' vertices are in the frame.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Side {
    /// The first block of each.
    pub(super) first: IndexRow,
    /// How many it has.
    pub(super) blocks: IndexRow,
}

impl Side {
    #[inline(always)]
    pub(super) fn write(&mut self, lane: usize, first: u32, blocks: u32) {
        self.first.0[lane] = first;
        self.blocks.0[lane] = blocks;
    }

    #[inline(always)]
    fn copy(&mut self, to: usize, from: &Self, lane: usize) {
        self.write(to, from.first.0[lane], from.blocks.0[lane]);
    }
}

/// How many rows of a lot mean something after a stage: what is pushed on.
pub(super) const AFTER_SECOND_POINT: usize = Vector::D as usize + 3;
/// See [`AFTER_SECOND_POINT`].
pub(super) const AFTER_ROUND: usize = Vector::P2 as usize + 3;

/// A row of numbers in a lot.
#[derive(Clone, Copy, Debug)]
pub(super) enum Number {
    /// The radius of a ball round c inside A − B, rounded down.
    Inner = 0,
    /// The sum of the swept radii, rounded up.
    Radius = 1,
    /// u·m: the unit of every rounding bound.
    Unit = 2,
    /// The sum of the centres' own errors.
    Slack = 3,
}

/// Three rows of a lot.
#[derive(Clone, Copy, Debug)]
pub(super) enum Vector {
    /// The difference of the centres: the centre of a ball inside A − B.
    C = 4,
    /// The first support point of the portal.
    P0 = 7,
    /// The second.
    P1 = 10,
    /// The direction of the next support.
    D = 13,
    /// The third.
    P2 = 16,
}

impl Lot {
    #[inline(always)]
    pub(super) fn number<L: Lanes>(&self, l: L, which: Number) -> L::F {
        l.load(&self.rows[which as usize])
    }

    #[inline(always)]
    pub(super) fn set_number<L: Lanes>(&mut self, l: L, which: Number, x: L::F) {
        l.store(x, &mut self.rows[which as usize]);
    }

    #[inline(always)]
    pub(super) fn write(&mut self, which: Number, lane: usize, x: f32) {
        self.rows[which as usize].0[lane] = x;
    }

    #[inline(always)]
    pub(super) fn write_vector(&mut self, which: Vector, lane: usize, v: [f32; 3]) {
        self.rows[which as usize].0[lane] = v[0];
        self.rows[which as usize + 1].0[lane] = v[1];
        self.rows[which as usize + 2].0[lane] = v[2];
    }

    /// Two axes from b to a that may separate a lane's pair: between the centres, and against the
    /// direction of the next support.
    pub(super) fn axes(&self, lane: usize) -> [Vec3; 2] {
        let at = |first: usize| Vec3::from_array([0, 1, 2].map(|k| self.rows[first + k].0[lane]));
        [at(Vector::C as usize), -at(Vector::D as usize)]
    }

    #[inline(always)]
    pub(super) fn vector<L: Lanes>(&self, l: L, which: Vector) -> V3<L> {
        let at = which as usize;
        V3(l.load(&self.rows[at]), l.load(&self.rows[at + 1]), l.load(&self.rows[at + 2]))
    }

    #[inline(always)]
    pub(super) fn set_vector<L: Lanes>(&mut self, l: L, which: Vector, v: V3<L>) {
        let at = which as usize;
        l.store(v.0, &mut self.rows[at]);
        l.store(v.1, &mut self.rows[at + 1]);
        l.store(v.2, &mut self.rows[at + 2]);
    }
}

/// Pairs in lots that are full but for the last.
#[derive(Clone, Debug, Default)]
pub(super) struct Queue {
    lots: Vec<Lot>,
    len: usize,
}

impl Queue {
    pub(super) fn clear(&mut self) {
        self.lots.clear();
        self.len = 0;
    }

    pub(super) fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// How many lots there are.
    pub(super) fn lots(&self) -> usize {
        self.lots.len()
    }

    /// Lot k, and the mask of its lanes in use.
    #[inline(always)]
    pub(super) fn lot(&mut self, k: usize) -> (&mut Lot, u32) {
        let used = (self.len - k * WIDTH).min(WIDTH);
        (&mut self.lots[k], (1 << used) - 1)
    }

    /// Appends one pair of another lot, its first `ROWS` rows.
    #[inline(always)]
    pub(super) fn push<const ROWS: usize>(&mut self, from: &Lot, lane: usize) {
        let to = self.len % WIDTH;
        if to == 0 {
            self.lots.push(Lot::default());
        }
        self.len += 1;
        let Some(lot) = self.lots.last_mut() else { return };
        lot.number.0[to] = from.number.0[lane];
        lot.a.copy(to, &from.a, lane);
        lot.b.copy(to, &from.b, lane);
        lot.found |= (from.found >> lane & 1) << to;
        for row in 0..ROWS {
            lot.rows[row].0[to] = from.rows[row].0[lane];
        }
    }
}

/// The numbers of the set bits, from the lowest.
#[derive(Clone, Copy, Debug)]
pub(super) struct LanesOf(pub(super) u32);

impl Iterator for LanesOf {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        let lane = self.0.trailing_zeros();
        self.0 &= self.0.wrapping_sub(1);
        (lane < WIDTH as u32).then_some(lane as usize)
    }
}
