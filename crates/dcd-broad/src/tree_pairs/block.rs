//! Combinations of the children of two nodes.

use std::iter::DoubleEndedIterator;

/// Two nodes that meet, by number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Visit {
    pub(super) a: u32,
    pub(super) b: u32,
}

/// The meetings below a meeting: rows of combinations.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block<'t> {
    pub(super) rows: &'t [u32],
    pub(super) columns: &'t [u32],
    pub(super) corner: Corner,
}

/// Which combinations of rows and columns meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Corner {
    /// All.
    Square,
    /// Row k meets the columns from k on: each two of a node's own children, once.
    Triangle,
}

impl<'t> Block<'t> {
    /// The upper and the lower rows, for two tasks.
    pub(super) fn halves(self) -> (Self, Self) {
        let (upper, lower) = self.rows.split_at(self.rows.len().div_ceil(2));
        let first_column = match self.corner {
            Corner::Square => 0,
            Corner::Triangle => upper.len(),
        };
        let columns = &self.columns[first_column..];
        (Self { rows: upper, ..self }, Self { rows: lower, columns, ..self })
    }

    /// The meetings, row by row.
    pub(super) fn visits(self) -> impl DoubleEndedIterator<Item = Visit> + use<'t> {
        self.rows.iter().enumerate().flat_map(move |(k, &a)| {
            let first_column = match self.corner {
                Corner::Square => 0,
                Corner::Triangle => k,
            };
            self.columns[first_column..].iter().map(move |&b| Visit { a, b })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn met(block: Block) -> Vec<(u32, u32)> {
        block.visits().map(|visit| (visit.a, visit.b)).collect()
    }

    #[test]
    fn halves_meet_what_the_whole_does_in_the_same_order() {
        let children = [0, 1, 2, 3, 4];
        for count in 1..=5 {
            for (columns, corner) in
                [(&children[..count], Corner::Triangle), (&[7, 8, 9], Corner::Square)]
            {
                let whole = Block { rows: &children[..count], columns, corner };
                let (upper, lower) = whole.halves();
                assert_eq!([met(upper), met(lower)].concat(), met(whole));
            }
        }
    }

    #[test]
    fn a_triangle_has_each_two_once_and_each_with_itself() {
        let block = Block { rows: &[5, 6, 7], columns: &[5, 6, 7], corner: Corner::Triangle };
        assert_eq!(met(block), [(5, 5), (5, 6), (5, 7), (6, 6), (6, 7), (7, 7)]);
    }
}
