//! Pairs written sixteen at a time, and taken back where nobody wants them.

use dcd_geom::Pair;
use dcd_geom::lanes::{IndexRow, Lanes, WIDTH};

/// Appends the pairs of an object with the `hits` of sixteen others.
#[inline(always)]
pub(crate) fn append<L: Lanes>(
    l: L,
    (one, others, hits): (u32, &IndexRow, u32),
    out: &mut Vec<Pair>,
) {
    let others = l.compress_u(l.mask(hits), l.load_u(others));
    // Sixteen are written and the surplus taken back: a copy of fixed length has no loop.
    let mut pairs = [Pair::default(); WIDTH];
    l.store_pairs(others, l.splat_u(one), &mut pairs);
    let start = out.len();
    out.extend_from_slice(&pairs);
    out.truncate(start + hits.count_ones() as usize);
}

/// Runs `search`, which appends, and takes back what it appended where `keep(i, j)` does not hold. The
/// search knows nothing of `keep`, so that its kernels are compiled once and not for every predicate.
#[inline]
pub(crate) fn append_where(
    out: &mut Vec<Pair>,
    keep: impl Fn(u32, u32) -> bool,
    search: impl FnOnce(&mut Vec<Pair>),
) {
    let start = out.len();
    search(out);
    let new = &mut out[start..];
    let mut kept = 0;
    // Without a branch that many a filter would have mispredicted.
    for k in 0..new.len() {
        new[kept] = new[k];
        kept += usize::from(keep(new[k].i, new[k].j));
    }
    out.truncate(start + kept);
}
