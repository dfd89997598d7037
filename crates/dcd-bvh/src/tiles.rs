//! Sorts boxes into tiles by their centres: slabs of like count in x, strips of each slab in y, and leaves of each strip
//! in z (sort-tile-recursive; S. Leutenegger et al., 1997).

use crate::bins::{self, Centre};
use crate::sample_sort::{PARTED_AT_ONCE, SampleSort};
use dcd_exec::Exec;
use dcd_geom::Aabb;

/// Sorts boxes into tiles. Keeps its memory.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tiles {
    centres: Vec<Centre>,
    parted: Vec<Centre>,
    sample_sort: SampleSort,
}

impl Tiles {
    /// Orders the boxes' centres by tiles, `leaf` of them a leaf; the order within a leaf is none in particular. No two centres
    /// count as equal: of those that are, the one with the smaller number is first. The same whatever `exec` is.
    pub(crate) fn sort(&mut self, aabbs: &[Aabb], leaf: usize, exec: Exec) {
        let Self { centres, parted, sample_sort } = self;
        centres.resize(aabbs.len(), Centre::default());
        if aabbs.len() <= leaf {
            // There is nothing to keep apart.
            return centres
                .iter_mut()
                .zip(0..)
                .for_each(|(centre, i)| *centre = Centre::of(&aabbs[i], i));
        }
        parted.resize(aabbs.len(), Centre::default());
        let exec = exec.serial_below(aabbs.len(), PARTED_AT_ONCE);
        let leaves = aabbs.len().div_ceil(leaf);
        let across = (leaves as f64).cbrt().ceil().max(1.0) as usize;
        let strip = leaves.div_ceil(across * across).max(1) * leaf;
        let slab = strip * across;
        let centre = |i: usize| Centre::of(&aabbs[i], i);
        sample_sort.part(exec, (centres, parted), slab, centre);
        exec.divide((&centres[..], &mut parted[..]), slab, |_, (from, to)| {
            bins::part::<1>(from, to, strip);
        });
        // Tasks of their own: there are few slabs.
        exec.divide((&parted[..], &mut centres[..]), strip, |_, (from, to)| {
            bins::part::<2>(from, to, leaf);
        });
    }

    /// The centres in that order.
    pub(crate) fn order(&self) -> &[Centre] {
        &self.centres
    }
}
