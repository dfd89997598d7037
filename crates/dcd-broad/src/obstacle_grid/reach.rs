//! Which obstacles of their lists spheres may reach.

use super::cells::Region;
use super::hits::Kept;
use super::{GridHits, LONGEST, ObstacleBounds, ObstacleGrid};
use dcd_geom::glam::{Vec3A, Vec4};
use dcd_geom::{Aabb, BoundingSphere, Sphere16};
use dcd_simd::{Kernel, Lanes, Path, Row, WIDTH, dispatch_on};

/// Factor on a radius in the query of a whole cell. No unit; far above what f32
/// loses in a comparison. Smaller: contacts could be missed. Larger: longer lists.
const SAFE: f32 = 1.0 + 1.0 / 1024.0;

/// An obstacle as it is compared: the AABB's least and largest corner, the sphere's centre and its radius, four
/// lanes each, the last without meaning where there are three numbers.
#[derive(Clone, Copy, Debug)]
pub(super) struct ObstacleRow(Row);

impl ObstacleRow {
    pub(super) fn of(obstacle: &ObstacleBounds) -> Self {
        let ObstacleBounds { aabb: Aabb { min, max }, sphere, .. } = *obstacle;
        let BoundingSphere { centre, radius } = sphere;
        let mut row = Row::default();
        let quarters = [min.extend(0.0), max.extend(0.0), centre.extend(radius)];
        for (quarter, numbers) in row.0.chunks_exact_mut(4).zip(quarters) {
            numbers.write_to_slice(quarter);
        }
        Self(row)
    }

    #[inline]
    fn quarter(&self, k: usize) -> Vec4 {
        Vec4::from_slice(&self.0.0[4 * k..])
    }

    /// The AABB's least corner.
    #[inline]
    pub(super) fn min(&self) -> Vec3A {
        Vec3A::from_vec4(self.quarter(0))
    }

    /// The AABB's largest corner.
    #[inline]
    pub(super) fn max(&self) -> Vec3A {
        Vec3A::from_vec4(self.quarter(1))
    }

    /// Whether a sphere of at most that radius about any point of a cell may be near.
    pub(super) fn is_near_any(&self, cell: &Region, radius: f32) -> bool {
        let (min, max, sphere) = (self.min(), self.max(), self.quarter(2));
        let centre = Vec3A::from_vec4(sphere);
        let beyond = (min - cell.max).max(cell.min - max).max(Vec3A::ZERO);
        let to_sphere = (centre - cell.max).max(cell.min - centre).max(Vec3A::ZERO);
        let (radius, both) = (radius * SAFE, (radius + sphere.w) * SAFE);
        // Written so that a NaN is near.
        let is_apart =
            |beyond: Vec3A, reach: f32| beyond.length_squared() > reach * reach + f32::MIN_POSITIVE;
        !is_apart(beyond, radius) && !is_apart(to_sphere, both)
    }
}

impl ObstacleGrid {
    /// Finds which obstacles the noted spheres may reach; `spheres` are those of the look-up, sixteen a row.
    pub fn reach(&self, spheres: &[Sphere16], reached: &mut GridHits) {
        self.reach_on(Path::best(), spheres, reached);
    }

    pub(super) fn reach_on(&self, path: Path, spheres: &[Sphere16], reached: &mut GridHits) {
        dispatch_on(path, Reach { obstacle_grid: self, spheres, reached });
    }
}

/// Concatenates the lists, tests every entry and keeps what is reached.
struct Reach<'a> {
    obstacle_grid: &'a ObstacleGrid,
    spheres: &'a [Sphere16],
    reached: &'a mut GridHits,
}

impl Kernel for Reach<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(mut self, l: L) {
        let count = self.concatenate(l);
        self.keep(l, count);
        self.trim();
    }
}

impl Reach<'_> {
    /// Puts the lists one after the other, each with its sphere. Returns how many numbers there are; sixteen more are
    /// void.
    #[inline(always)]
    fn concatenate<L: Lanes>(&mut self, l: L) -> usize {
        let members = &self.obstacle_grid.members[..];
        let listed: u32 = self.reached.lists_mut().iter().map(|list| list.end).sum();
        let most = self.reached.numbers.len().max(listed as usize + LONGEST);
        self.reached.numbers.resize(most, 0);
        let mut columns = std::mem::take(&mut self.reached.spheres);
        columns.iter_mut().for_each(|column| column.resize(most, 0.0));
        let mut numbers = std::mem::take(&mut self.reached.numbers);
        let mut end = 0;
        for list in self.reached.lists_mut() {
            // A constant number, so that there is no loop.
            let taken = end..end + LONGEST;
            numbers[taken.clone()].copy_from_slice(&members[list.start as usize..][..LONGEST]);
            let at = list.sphere as usize;
            let BoundingSphere { centre, radius } = self.spheres[at / WIDTH].get(at % WIDTH);
            let sphere = [centre.x, centre.y, centre.z, radius];
            for (column, x) in columns.iter_mut().zip(sphere) {
                if let Some(column) = column[taken.clone()].first_chunk_mut() {
                    l.store_to(l.splat(x), column);
                }
            }
            end += list.end as usize;
            list.end = end as u32;
        }
        numbers[end..end + LONGEST].fill(0);
        (self.reached.numbers, self.reached.spheres) = (numbers, columns);
        end
    }

    /// Keeps the numbers that their sphere may reach.
    #[inline(always)]
    fn keep<L: Lanes>(&mut self, l: L, count: usize) {
        let GridHits { numbers, spheres, kept, .. } = &mut *self.reached;
        let obstacles = &self.obstacle_grid.obstacle_bounds[..];
        kept.clear();
        let mut before = 0;
        for first in (0..count).step_by(WIDTH) {
            let Some(found) = numbers[first..].first_chunk::<WIDTH>() else { continue };
            let rows = found.map(|number| obstacles[number as usize].0);
            let found = l.load_from_u(found);
            let sphere = spheres.each_ref().map(|column| {
                column[first..].first_chunk().map_or(l.splat(0.0), |column| l.load_from(column))
            });
            // Those of void numbers come after all that a list has.
            let bits = near(l, &rows, sphere);
            kept.push(Kept { bits, before: before as u32 });
            let mut packed = [0; 2 * WIDTH];
            l.compress_to_u(bits, found, &mut packed, 0);
            numbers[before..before + WIDTH].copy_from_slice(&packed[..WIDTH]);
            before += bits.count_ones() as usize;
        }
        kept.push(Kept { bits: 0, before: before as u32 });
    }

    /// Trims the lists to what was kept.
    #[inline(always)]
    fn trim(&mut self) {
        let kept = std::mem::take(&mut self.reached.kept);
        let mut start = 0;
        for list in self.reached.lists_mut() {
            let Kept { bits, before } = kept[list.end as usize / WIDTH];
            let below = bits & ((1 << (list.end as usize % WIDTH)) - 1);
            list.start = start;
            list.end = before + below.count_ones();
            start = list.end;
        }
        self.reached.kept = kept;
    }
}

/// Which of sixteen bounding spheres, each given by its centre and radius, may reach what both the AABB and the sphere
/// of its obstacle contain: docs/numerics/proofs.md, "what is near".
#[inline(always)]
fn near<L: Lanes>(l: L, obstacles: &[Row; WIDTH], [x, y, z, radius]: [L::F; 4]) -> u32 {
    let [a, b, c, _, d, e, f, _, p, q, r, outer, ..] = l.transpose(obstacles);
    let (zero, least) = (l.splat(0.0), l.splat(f32::MIN_POSITIVE));
    let [mut to_box, mut to_sphere] = [zero; 2];
    for (x, min, max, centre) in [(x, a, d, p), (y, b, e, q), (z, c, f, r)] {
        let beyond = l.max(l.max(l.sub(min, x), l.sub(x, max)), zero);
        to_box = l.add(to_box, l.mul(beyond, beyond));
        let between = l.sub(x, centre);
        to_sphere = l.add(to_sphere, l.mul(between, between));
    }
    let both = l.add(radius, outer);
    // What underflows is below the least normal number.
    let in_box = l.le(to_box, l.add(l.mul(radius, radius), least));
    let in_sphere = l.le(to_sphere, l.add(l.mul(both, both), least));
    l.bits(l.and(in_box, in_sphere))
}
