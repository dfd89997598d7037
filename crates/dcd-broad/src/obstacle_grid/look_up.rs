//! Looks up the cells of posed spheres.

use super::cells::WHOLE;
use super::{GridHits, Listed, ObstacleGrid};
use dcd_geom::{PackedSphereBounds, Pose, Sphere16};
use dcd_simd::{IndexRow, Kernel, Lanes, Path, WIDTH, dispatch_on, prefetch};
use std::ops::Range;

/// Bounds at poses: pose k is that of bound k modulo their number.
#[derive(Clone, Copy, Debug)]
pub struct PosedBounds<'a> {
    /// The bounds.
    pub bounds: &'a PackedSphereBounds,
    /// Their poses.
    pub poses: &'a [Pose],
}

impl ObstacleGrid {
    /// Places the spheres of some of the poses, sixteen a row, and appends those near which anything may be to the
    /// noted ones. Writes only these rows of `spheres`, which has one for every sixteen poses; skips rows
    /// that it does not have.
    pub fn look_up(
        &self,
        posed: PosedBounds<'_>,
        rows: Range<usize>,
        spheres: &mut [Sphere16],
        hits: &mut GridHits,
    ) {
        let end = rows.end.min(spheres.len());
        let rows = rows.start.min(end)..end;
        let count = if posed.bounds.is_empty() { 0 } else { posed.poses.len() };
        let [first, end] = [rows.start, rows.end].map(|row| count.min(row * WIDTH));
        hits.cells.resize(rows.len(), IndexRow::default());
        dispatch_on(
            Path::best(),
            LookUp {
                obstacle_grid: self,
                bounds: posed.bounds,
                first,
                poses: &posed.poses[first..end],
                spheres: &mut spheres[rows],
                cells: &mut hits.cells,
            },
        );
        self.note(first..end, &posed.poses[end..], hits);
    }

    /// The cells of sixteen spheres.
    #[inline(always)]
    pub(super) fn cells<L: Lanes>(&self, l: L, spheres: &Sphere16) -> L::U {
        let cell = self.grid.cells(l, &spheres.centre);
        // The cell of spheres larger than the grid was made for. Written so that NaN is among them.
        let unforeseen = l.splat((self.cells.len() - 2) as f32);
        let is_foreseen = l.le(l.load(&spheres.radius), l.splat(self.radius));
        let whole = l.add(l.select(is_foreseen, cell, unforeseen), l.splat(WHOLE));
        l.tag_of(whole, l.splat_u(WHOLE as u32 - 1))
    }

    /// Notes those of the placed spheres near which anything may be.
    pub(super) fn note(&self, spheres: Range<usize>, later: &[Pose], hits: &mut GridHits) {
        hits.note(spheres, |number, cell| {
            // The next poses are prefetched.
            prefetch(later.get(number..=number).unwrap_or_default());
            let [Listed { start, nearest }, next] = [cell, cell + 1].map(|cell| self.cells[cell]);
            (start..next.start, nearest)
        });
    }
}

/// Poses bounds, and finds the cells of their spheres.
struct LookUp<'a> {
    obstacle_grid: &'a ObstacleGrid,
    bounds: &'a PackedSphereBounds,
    /// How many poses come before.
    first: usize,
    poses: &'a [Pose],
    spheres: &'a mut [Sphere16],
    cells: &'a mut [IndexRow],
}

impl Kernel for LookUp<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        let rows = self.poses.chunks(WIDTH).zip(self.spheres).zip(self.cells);
        for (k, ((poses, spheres), cells)) in rows.enumerate() {
            let bound = (self.first + k * WIDTH) % self.bounds.len();
            self.bounds.spheres(l, bound, poses, spheres);
            l.store_u(self.obstacle_grid.cells(l, spheres), cells);
        }
    }
}
