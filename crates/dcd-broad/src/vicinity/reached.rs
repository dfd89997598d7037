//! Lists put one after the other, and what of them is kept.

use super::LONGEST;

/// What balls may reach, ball by ball. Memory that is used again.
///
/// Filled without a branch that depends on what is near: first the balls of whose list anything
/// stands are told from the others, then all lists are put one after the other, then all that is
/// listed is tested.
#[derive(Clone, Debug, Default)]
pub struct Reached {
    /// The lists that have anything, more than there are: what is beyond means nothing, as in what
    /// follows.
    lists: Vec<List>,
    listed: usize,
    numbers: Vec<u32>,
    /// For each listed number the ball that it is listed for.
    balls: Vec<u32>,
    /// For each listed number how many before it are reached.
    before: Vec<u32>,
}

#[derive(Clone, Copy, Debug, Default)]
struct List {
    ball: u32,
    /// Where it begins: among the members, then among the numbers.
    start: u32,
    /// How many it has, then where it ends.
    end: u32,
}

impl Reached {
    /// The balls that may reach something: their numbers, ascending, and where among the
    /// [`Reached::numbers`] those of what they reach begin and end. A ball may reach nothing there.
    pub fn spans(&self) -> impl Iterator<Item = (usize, [u32; 2])> {
        self.lists[..self.listed].iter().map(|list| (list.ball as usize, [list.start, list.end]))
    }

    /// The numbers of the outlines that each ball may reach, ascending, ball by ball. Where that is
    /// not known, [`super::Vicinity::unknown`] alone.
    pub fn numbers(&self) -> &[u32] {
        let end = self.lists[..self.listed].last().map_or(0, |list| list.end);
        &self.numbers[..end as usize]
    }

    /// Puts the lists of balls one after the other, each given by its start among the members and its
    /// length, at most [`LONGEST`]; after every start there are as many members.
    pub(super) fn gather(
        &mut self,
        lists: impl ExactSizeIterator<Item = (u32, u32)>,
        members: &[u32],
    ) {
        // Never shorter, so that nothing is filled twice.
        let most = self.lists.len().max(lists.len() + 1);
        self.lists.resize(most, List::default());
        let (mut count, mut members_listed) = (0, 0);
        for (ball, (start, length)) in (0..).zip(lists) {
            self.lists[count] = List { ball, start, end: length };
            count += usize::from(length > 0);
            members_listed += length as usize;
        }
        self.listed = count;
        let most = self.numbers.len().max(members_listed + LONGEST);
        self.numbers.resize(most, 0);
        self.balls.resize(most, 0);
        self.before.resize(most + 1, 0);
        let mut end = 0;
        for list in &mut self.lists[..count] {
            let from = &members[list.start as usize..][..LONGEST];
            // As many in any case, so that there is no loop.
            self.numbers[end..end + LONGEST].copy_from_slice(from);
            self.balls[end..end + LONGEST].fill(list.ball);
            end += list.end as usize;
            list.end = end as u32;
        }
    }

    /// Keeps the numbers that `reaches` says their ball reaches.
    #[inline]
    pub(super) fn keep(&mut self, reaches: impl Fn(u32, u32) -> bool) {
        let Self { lists, listed, numbers, balls, before } = self;
        let lists = &mut lists[..*listed];
        let mut kept = 0;
        for k in 0..lists.last().map_or(0, |list| list.end as usize) {
            let number = numbers[k];
            numbers[kept] = number;
            kept += usize::from(reaches(balls[k], number));
            before[k + 1] = kept as u32;
        }
        let mut start = 0;
        for list in lists {
            list.start = start;
            list.end = before[list.end as usize];
            start = list.end;
        }
    }
}
