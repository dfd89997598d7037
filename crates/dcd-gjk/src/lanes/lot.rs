//! Pairs on their way through the stages, sixteen at a time.

use dcd_geom::lanes::{IndexRow, Row, WIDTH};

/// Sixteen pairs and what is known of them. Lengths are metres, in world axes; every point is one
/// of A − B.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Lot {
    /// Each pair's number in its slice.
    pub(super) number: IndexRow,
    /// Object a.
    pub(super) a: IndexRow,
    /// Object b.
    pub(super) b: IndexRow,
    /// The difference of the centres: the centre of a ball inside A − B.
    pub(super) c: [Row; 3],
    /// That ball's radius, rounded down.
    pub(super) inner: Row,
    /// The sum of the swept radii, rounded up.
    pub(super) radius: Row,
    /// u·m: the unit of every rounding bound.
    pub(super) unit: Row,
    /// The sum of the centres' own errors.
    pub(super) slack: Row,
    /// Up to three support points: the portal.
    pub(super) p: [[Row; 3]; 3],
    /// The direction of the next support.
    pub(super) d: [Row; 3],
    /// Bit k: pair k has a portal that the ray from c to the origin passes.
    pub(super) found: u32,
}

impl Lot {
    /// Every row of numbers.
    fn rows(&self) -> impl Iterator<Item = &Row> {
        let scalars = [&self.inner, &self.radius, &self.unit, &self.slack];
        self.c.iter().chain(scalars).chain(self.p.iter().flatten()).chain(&self.d)
    }

    fn rows_mut(&mut self) -> impl Iterator<Item = &mut Row> {
        let scalars = [&mut self.inner, &mut self.radius, &mut self.unit, &mut self.slack];
        self.c.iter_mut().chain(scalars).chain(self.p.iter_mut().flatten()).chain(&mut self.d)
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

    /// How many lots there are, and lot k with the mask of the lanes in use.
    pub(super) fn lots(&self) -> usize {
        self.lots.len()
    }

    /// Lot k, and the mask of its lanes in use.
    #[inline(always)]
    pub(super) fn lot(&mut self, k: usize) -> (&mut Lot, u32) {
        let used = (self.len - k * WIDTH).min(WIDTH);
        (&mut self.lots[k], (1 << used) - 1)
    }

    /// Appends one pair of another lot.
    #[inline(always)]
    pub(super) fn push(&mut self, from: &Lot, lane: usize) {
        let to = self.len % WIDTH;
        if to == 0 {
            self.lots.push(Lot::default());
        }
        self.len += 1;
        let Some(lot) = self.lots.last_mut() else { return };
        lot.number.0[to] = from.number.0[lane];
        lot.a.0[to] = from.a.0[lane];
        lot.b.0[to] = from.b.0[lane];
        lot.found |= (from.found >> lane & 1) << to;
        for (row, source) in lot.rows_mut().zip(from.rows()) {
            row.0[to] = source.0[lane];
        }
    }
}
