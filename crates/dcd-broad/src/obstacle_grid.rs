//! A grid of the obstacles near any point.

mod cells;
mod hits;
mod look_up;
mod reach;
#[cfg(test)]
mod tests;

pub use hits::{Cell, GridHits};
pub use look_up::PosedBounds;

use cells::Grid;
use dcd_geom::glam::Vec3A;
use dcd_geom::{Aabb, BoundingSphere, InscribedSphere, Pair};
use reach::ObstacleRow;

/// Bounds of an obstacle: an AABB and a sphere that both contain it, and a sphere that it contains.
#[derive(Clone, Copy, Debug)]
pub struct ObstacleBounds {
    /// The exact AABB, which decides pairs.
    pub aabb: Aabb,
    /// A sphere round it, infinite where none is known.
    pub sphere: BoundingSphere,
    /// A sphere inside of it.
    pub inner: InscribedSphere,
}

impl ObstacleBounds {
    const EVERYTHING: Self = Self {
        aabb: Aabb::EVERYTHING,
        sphere: BoundingSphere::EVERYTHING,
        inner: InscribedSphere::NOTHING,
    };
}

/// A grid over static obstacles: each cell lists those that a sphere about one of its points may reach, and
/// names the one that such a sphere most likely touches.
///
/// Most query spheres are near nothing and read one short list. Where a list would be long, or a sphere is
/// larger than the grid was made for, the grid answers [`ObstacleGrid::unknown`] and a tree must be
/// queried.
#[derive(Clone, Debug)]
pub struct ObstacleGrid {
    obstacle_bounds: Vec<ObstacleRow>,
    inners: Vec<InscribedSphere>,
    grid: Grid,
    /// The largest radius that the lists are made for, metres.
    radius: f32,
    /// The grid's cells, one of what is larger than the grid was made for, and the end.
    cells: Vec<Listed>,
    /// The lists, each ascending. An unknown one is the number after the last obstacle's.
    members: Vec<u32>,
}

/// The list of a cell.
#[derive(Clone, Copy, Debug)]
struct Listed {
    /// Where its list begins; it ends where that of the next cell begins.
    start: u32,
    /// The obstacle whose inner sphere is nearest its middle, of those that it lists or would list.
    nearest: u32,
}

/// How many obstacles a list may have. Larger: more are looked at one by one where a tree tests
/// sixteen at once. Smaller: the tree is queried more often. No effect on any answer.
const LONGEST: usize = 16;

/// Beyond this an obstacle counts as infinite, metres: it widens no grid. A half-space's AABB ends at
/// [`Aabb::LIMIT`].
const INFINITE: f32 = 1e36;

impl ObstacleGrid {
    /// A grid for spheres of at most this radius, metres.
    pub fn new(obstacle_bounds: &[ObstacleBounds], radius: f32) -> Self {
        let reached: Vec<Aabb> =
            obstacle_bounds.iter().map(|obstacle| widened(&obstacle.aabb, radius)).collect();
        let ends = |aabb: &&Aabb| aabb.max.abs().max(aabb.min.abs()).max_element() < INFINITE;
        let extent = reached.iter().filter(ends).fold(Aabb::EMPTY, |all, one| all.union(one));
        let grid = Grid::finest(extent, &reached);
        let all = obstacle_bounds.iter().chain(&[ObstacleBounds::EVERYTHING]);
        let mut obstacle_grid = Self {
            obstacle_bounds: all.clone().map(ObstacleRow::of).collect(),
            inners: all.map(|obstacle| obstacle.inner).collect(),
            grid,
            radius,
            cells: Vec::new(),
            members: Vec::new(),
        };
        let counts = obstacle_grid.layout(&reached);
        obstacle_grid.list(&reached, &counts);
        obstacle_grid
    }

    /// Lays out the lists and finds the obstacle nearest each cell. Returns the lengths of the lists.
    fn layout(&mut self, reached: &[Aabb]) -> Vec<u32> {
        let unknown = self.unknown();
        let mut counts = vec![0; self.grid.len()];
        let mut nearest = vec![(unknown, f32::INFINITY); counts.len()];
        for (number, (aabb, inner)) in (0..).zip(reached.iter().zip(&self.inners)) {
            let obstacle = &self.obstacle_bounds[number as usize];
            self.grid.for_each_cell(aabb, |cell, region| {
                counts[cell] += u32::from(obstacle.is_near_any(&region, self.radius));
                let away = region.middle.distance(inner.centre) - inner.radius;
                if away < nearest[cell].1 {
                    nearest[cell] = (number, away);
                }
            });
        }
        let mut start = 0;
        for (&count, &(nearest, _)) in counts.iter().zip(&nearest) {
            self.cells.push(Listed { start, nearest });
            start += if count > LONGEST as u32 { 1 } else { count };
        }
        // The last list is that of spheres larger than the grid was made for.
        self.cells.extend([start, start + 1].map(|start| Listed { start, nearest: unknown }));
        counts
    }

    /// Writes the lists that are not too long.
    fn list(&mut self, reached: &[Aabb], counts: &[u32]) {
        let length = self.cells.last().map_or(0, |end| end.start) as usize;
        // Every list is read at its maximum length.
        let mut members = vec![self.unknown(); length + LONGEST];
        let mut next: Vec<u32> = self.cells.iter().map(|cell| cell.start).collect();
        for (number, aabb) in (0..).zip(reached) {
            let obstacle = &self.obstacle_bounds[number as usize];
            self.grid.for_each_cell(aabb, |cell, region| {
                let is_listed = counts[cell] <= LONGEST as u32;
                if is_listed && obstacle.is_near_any(&region, self.radius) {
                    members[next[cell] as usize] = number;
                    next[cell] += 1;
                }
            });
        }
        self.members = members;
    }

    /// The number that stands for "unknown"; no obstacle has it.
    pub fn unknown(&self) -> u32 {
        self.obstacle_bounds.len() as u32 - 1
    }

    /// How far the inner sphere of a noted one is from a contact with the obstacle that it most likely touches
    /// ([`InscribedSphere::short_of`]); infinite if that is unknown.
    #[inline]
    pub fn short_of(&self, noted: &Cell, inner: &InscribedSphere) -> f32 {
        self.inners[noted.likeliest as usize].short_of(inner)
    }

    /// Appends the pairs (i, j) of some of the obstacles, by their numbers i, with what is called j, whose
    /// closed AABBs overlap that AABB and for which `keep(i)` holds.
    #[inline]
    pub fn append_pairs(
        &self,
        (name, aabb): (u32, &Aabb),
        numbers: &[u32],
        keep: impl Fn(u32) -> bool,
        out: &mut Vec<Pair>,
    ) {
        let (min, max) = (Vec3A::from(aabb.min), Vec3A::from(aabb.max));
        let start = out.len();
        let mut end = start;
        out.resize(start + numbers.len(), Pair::default());
        for &number in numbers {
            let obstacle = &self.obstacle_bounds[number as usize];
            let overlap = (obstacle.min().cmple(max) & min.cmple(obstacle.max())).all();
            out[end] = Pair { i: number, j: name };
            end += usize::from(overlap && keep(number));
        }
        out.truncate(end);
    }
}

/// Every centre of a sphere of that radius that may reach the AABB. One step outward is more than the
/// difference's rounding.
fn widened(aabb: &Aabb, radius: f32) -> Aabb {
    Aabb {
        min: (aabb.min - radius).map(f32::next_down),
        max: (aabb.max + radius).map(f32::next_up),
    }
}
