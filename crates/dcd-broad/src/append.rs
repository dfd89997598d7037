//! Drops the pairs that a predicate excludes.

use dcd_geom::Pair;

/// Runs `search`, which appends, and drops what it appended where `keep(i, j)` does not hold. The search does
/// not see `keep`, so that its kernels are compiled once and not for every predicate.
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
    // Branchless, since most filters would be mispredicted.
    for k in 0..new.len() {
        new[kept] = new[k];
        kept += usize::from(keep(new[k].i, new[k].j));
    }
    out.truncate(start + kept);
}
