//! Where the balls of posed bounds lie.

use super::grid::WHOLE;
use super::{Listed, Reached, Vicinity};
use dcd_geom::lanes::{IndexRow, Kernel, Lanes, Path, WIDTH, dispatch_on, prefetch};
use dcd_geom::{BallRow, Bounds, Pose};
use std::ops::Range;

/// Bounds at poses: the first pose is that of the first bound, the next of the next, after the last of
/// the first again.
#[derive(Clone, Copy, Debug)]
pub struct Posed<'a> {
    /// What is posed.
    pub bounds: &'a Bounds,
    /// Where it is.
    pub poses: &'a [Pose],
}

impl Vicinity {
    /// Finds the balls of some of the poses, sixteen a row, and notes those near which anything may
    /// be, after those that are noted. Of `balls`, which has a row for every sixteen poses, these are
    /// written; rows that it does not have are none.
    pub fn look_up(
        &self,
        posed: Posed<'_>,
        rows: Range<usize>,
        balls: &mut [BallRow],
        reached: &mut Reached,
    ) {
        let end = rows.end.min(balls.len());
        let rows = rows.start.min(end)..end;
        let count = if posed.bounds.is_empty() { 0 } else { posed.poses.len() };
        let [first, end] = [rows.start, rows.end].map(|row| count.min(row * WIDTH));
        reached.cells.resize(rows.len(), IndexRow::default());
        dispatch_on(
            Path::best(),
            LookUp {
                vicinity: self,
                bounds: posed.bounds,
                first,
                poses: &posed.poses[first..end],
                balls: &mut balls[rows],
                cells: &mut reached.cells,
            },
        );
        self.note(first..end, &posed.poses[end..], reached);
    }

    /// The cells of sixteen balls.
    #[inline(always)]
    pub(super) fn cells<L: Lanes>(&self, l: L, balls: &BallRow) -> L::U {
        let cell = self.grid.cells(l, &balls.centre);
        // That of what is larger than foreseen. Written so that NaN is.
        let unforeseen = l.splat((self.cells.len() - 2) as f32);
        let is_foreseen = l.le(l.load(&balls.radius), l.splat(self.radius));
        let whole = l.add(l.select(is_foreseen, cell, unforeseen), l.splat(WHOLE));
        l.tag_of(whole, l.splat_u(WHOLE as u32 - 1))
    }

    /// Notes those of the balls whose cells were found near which anything may be.
    pub(super) fn note(&self, balls: Range<usize>, later: &[Pose], reached: &mut Reached) {
        reached.note(balls, |number, cell| {
            // While memory answers for these, that of as many later ones is asked.
            prefetch(later.get(number..=number).unwrap_or_default());
            let [Listed { start, nearest }, next] = [cell, cell + 1].map(|cell| self.cells[cell]);
            (start..next.start, nearest)
        });
    }
}

/// Poses bounds, and finds the cells of their balls.
struct LookUp<'a> {
    vicinity: &'a Vicinity,
    bounds: &'a Bounds,
    /// How many poses come before.
    first: usize,
    poses: &'a [Pose],
    balls: &'a mut [BallRow],
    cells: &'a mut [IndexRow],
}

impl Kernel for LookUp<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        let rows = self.poses.chunks(WIDTH).zip(self.balls).zip(self.cells);
        for (k, ((poses, balls), cells)) in rows.enumerate() {
            let bound = (self.first + k * WIDTH) % self.bounds.len();
            self.bounds.balls(l, bound, poses, balls);
            l.store_u(self.vicinity.cells(l, balls), cells);
        }
    }
}
