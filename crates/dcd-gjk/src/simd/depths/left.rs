//! The pairs that the solver measures one by one, in an order in which neighbours are of the same kinds.

use super::super::frame::{BOX, FramePair, Record, SPHERE};
use dcd_geom::Pair;

/// The pairs that are left to the solver.
#[derive(Debug, Default)]
pub(super) struct Left {
    /// Their numbers among those that touch.
    pub(super) numbers: Vec<u32>,
    /// The pairs, in the order of their numbers there.
    pub(super) pairs: Vec<Pair>,
    /// The numbers with the kinds of their pairs above.
    keyed: Vec<u64>,
}

impl Left {
    /// Brings together those whose objects are of the same kinds, for what one of them takes the next one does: its branches
    /// are predicted. Of the same kinds the first comes first; what is of parts comes last, in one rising order.
    pub(super) fn sort(&mut self, frames: FramePair<'_>, touching: &[Pair]) {
        let Self { numbers, pairs, keyed } = self;
        let keys = numbers.iter().map(|&number| {
            u64::from(kinds(frames, touching[number as usize])) << 32 | u64::from(number)
        });
        keyed.clear();
        keyed.extend(keys);
        keyed.sort_unstable();
        numbers.clear();
        numbers.extend(keyed.iter().map(|&key| key as u32));
        pairs.clear();
        pairs.extend(numbers.iter().map(|&number| touching[number as usize]));
    }
}

/// What the objects of a pair are, as their records have it.
fn kinds(frames: FramePair<'_>, pair: Pair) -> u32 {
    let [a, b] = [kind(frames.a.record(pair.i)), kind(frames.b.record(pair.j))];
    if a == OF_PARTS || b == OF_PARTS { OF_PARTS * OF_PARTS } else { OF_PARTS * a + b }
}

/// The kind of what has no vertices in the lanes: compounds, meshes, half-spaces.
const OF_PARTS: u32 = 4;

fn kind(record: &Record) -> u32 {
    match record {
        _ if record.marks & SPHERE != 0 => 0,
        _ if record.marks & BOX != 0 => 1,
        _ if record.blocks == 0 => OF_PARTS,
        _ if record.radius > 0.0 => 2,
        _ => 3,
    }
}
