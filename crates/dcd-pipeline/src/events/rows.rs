//! Pairs as sorted rows.

use dcd_exec::{Exec, Splittable};

/// For each i of some pairs (i, j) its j's, ascending, one row after the other.
#[derive(Debug, Default)]
pub(super) struct Rows {
    /// Where each row starts, and where the last one ends.
    starts: Vec<usize>,
    items: Vec<u32>,
}

/// How many rows a task sorts: some tens of microseconds.
const ROWS_PER_TASK: usize = 256;

impl Rows {
    /// Takes in pairs whose i is below `rows`, each once, in any order. `pairs` is called twice and
    /// yields the same pairs.
    pub(super) fn fill<P: Iterator<Item = (u32, u32)>>(
        &mut self,
        rows: usize,
        pairs: impl Fn() -> P,
        exec: Exec,
    ) {
        let Self { starts, items } = self;
        starts.clear();
        starts.resize(rows + 1, 0);
        let mut count = 0;
        for (i, _) in pairs() {
            starts[i as usize] += 1;
            count += 1;
        }
        // Each start begins at its row's end and is counted down as the row fills.
        let mut end = 0;
        for start in &mut *starts {
            end += *start;
            *start = end;
        }
        items.clear();
        items.resize(count, 0);
        for (i, j) in pairs() {
            let place = &mut starts[i as usize];
            *place -= 1;
            items[*place] = j;
        }
        let cut = Sorting { bounds: &starts[..], items: &mut items[..] };
        exec.divide(cut, ROWS_PER_TASK, |_, Sorting { bounds, mut items }| {
            for bounds in bounds.windows(2) {
                let (row, rest) = std::mem::take(&mut items).split_at_mut(bounds[1] - bounds[0]);
                row.sort_unstable();
                items = rest;
            }
        });
    }

    /// Row i; empty where there is none.
    pub(super) fn row(&self, i: usize) -> &[u32] {
        match self.starts.get(i..i + 2) {
            Some(&[start, end]) => &self.items[start..end],
            _ => &[],
        }
    }
}

/// Rows to be sorted.
struct Sorting<'a> {
    /// The starts of the rows, and the end of the last.
    bounds: &'a [usize],
    items: &'a mut [u32],
}

impl Splittable for Sorting<'_> {
    fn len(&self) -> usize {
        self.bounds.len().saturating_sub(1)
    }
    fn split_at(self, middle: usize) -> (Self, Self) {
        let Self { bounds, items } = self;
        let (left, right) = items.split_at_mut(bounds[middle] - bounds[0]);
        (
            Self { bounds: &bounds[..=middle], items: left },
            Self { bounds: &bounds[middle..], items: right },
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dcd_exec::Par;

    #[test]
    fn rows_ascend_whatever_the_order_of_the_pairs_and_on_the_pool() {
        let pairs: Vec<(u32, u32)> =
            (0..5000u32).map(|k| (k * 7919 % 700, k * 104_729 % 10_007 + 700)).collect();
        for par in [Par::Serial, Par::Pool] {
            let mut rows = Rows::default();
            rows.fill(3, || [(2, 9), (0, 1), (2, 4)].into_iter(), par.into());
            assert_eq!(
                [rows.row(0), rows.row(1), rows.row(2), rows.row(3)],
                [&[1][..], &[], &[4, 9], &[]]
            );
            rows.fill(700, || pairs.iter().copied(), par.into());
            let mut reported: Vec<(u32, u32)> =
                (0..700).flat_map(|i| rows.row(i).iter().map(move |&j| (i as u32, j))).collect();
            let mut expected = pairs.clone();
            expected.sort_unstable();
            assert!(reported.is_sorted());
            assert_eq!(std::mem::take(&mut reported), expected);
            rows.fill(0, std::iter::empty, par.into());
            assert!(rows.row(0).is_empty());
        }
    }
}
