//! What stands near a place, cell by cell.

use dcd_geom::glam::{UVec3, Vec3, Vec3A};
use dcd_geom::{Aabb, LooseBall, Pair};

/// Where something stands: a box and a ball that both contain it.
#[derive(Clone, Copy, Debug)]
pub struct Outline {
    /// The exact box, which pairs are told by.
    pub aabb: Aabb,
    /// A ball round it, infinite where none is known.
    pub ball: LooseBall,
}

impl Outline {
    const EVERYTHING: Self = Self { aabb: Aabb::EVERYTHING, ball: LooseBall::EVERYTHING };
}

/// A grid over outlines that stay: each cell lists those that a ball about one of its points may
/// reach.
///
/// Most of what is asked for is near nothing, and for that one short list is read. Where a list
/// would be long, or the ball is larger than what was foreseen, the grid knows nothing, and a tree
/// has to be asked.
#[derive(Clone, Debug)]
pub struct Vicinity {
    outlines: Vec<Compact>,
    grid: Grid,
    /// The largest radius that the lists are made for, metres.
    radius: f32,
    /// Where the list of each cell begins, and where that of the last one ends.
    starts: Vec<u32>,
    /// The lists, each ascending. One that is not known is the number after the last outline's.
    members: Vec<u32>,
}

/// What balls may reach, ball by ball. Memory that is used again.
#[derive(Clone, Debug, Default)]
pub struct Reached {
    /// For each ball where its numbers end.
    ends: Vec<u32>,
    /// More than there are: what is beyond the last end means nothing.
    numbers: Vec<u32>,
    /// For each listed number the ball that it is listed for.
    balls: Vec<u32>,
    /// For each listed number how many before it are reached.
    before: Vec<u32>,
}

impl Reached {
    /// Where the numbers of each ball end: those of the next one begin there.
    pub fn ends(&self) -> &[u32] {
        &self.ends
    }

    /// The numbers of the outlines that each ball may reach, ascending, ball by ball. Where that is
    /// not known, [`Vicinity::unknown`] alone.
    pub fn numbers(&self) -> &[u32] {
        &self.numbers[..self.ends.last().map_or(0, |&end| end as usize)]
    }
}

/// How many outlines a list may have. Larger: more are looked at one by one where a tree tests
/// sixteen at once. Smaller: the tree is asked more often. No effect on any answer.
const LONGEST: usize = 16;

/// Beyond this an outline counts as infinite, metres: it widens no grid. A half-space's box ends at
/// [`Aabb::LIMIT`].
const INFINITE: f32 = 1e36;

/// How many cells there may be, and how many may list an outline, for each outline. Larger: shorter
/// lists in more memory. No effect on any answer.
const CELLS: usize = 64;
const LISTED: usize = 256;

/// How many cells there may be in any case: f32 counts them.
const MOST_CELLS: usize = 1 << 22;

impl Vicinity {
    /// For balls of at most this radius, metres.
    pub fn new(outlines: &[Outline], radius: f32) -> Self {
        let reached: Vec<Aabb> =
            outlines.iter().map(|outline| widened(&outline.aabb, radius)).collect();
        let ends = |aabb: &&Aabb| aabb.max.abs().max(aabb.min.abs()).max_element() < INFINITE;
        let extent = reached.iter().filter(ends).fold(Aabb::EMPTY, |all, one| all.union(one));
        let grid = Grid::finest(extent, &reached);
        let mut counts = vec![0u32; grid.len()];
        for aabb in &reached {
            grid.for_each_cell(aabb, |cell| counts[cell] += 1);
        }
        let mut starts = Vec::with_capacity(counts.len() + 2);
        let mut end = 0;
        for &count in &counts {
            starts.push(end);
            end += if count > LONGEST as u32 { 1 } else { count };
        }
        // A last list is that of what is larger than foreseen. All are read as long as they may be.
        starts.extend([end, end + 1]);
        let mut members = vec![outlines.len() as u32; end as usize + 1 + LONGEST];
        let mut next = starts.clone();
        for (number, aabb) in (0..).zip(&reached) {
            grid.for_each_cell(aabb, |cell| {
                if counts[cell] <= LONGEST as u32 {
                    members[next[cell] as usize] = number;
                    next[cell] += 1;
                }
            });
        }
        let outlines = outlines.iter().chain(&[Outline::EVERYTHING]).map(Compact::of).collect();
        Self { outlines, grid, radius, starts, members }
    }

    /// The number of what is not known, none of an outline.
    pub fn unknown(&self) -> u32 {
        self.outlines.len() as u32 - 1
    }

    /// Which outlines each of some balls may reach.
    ///
    /// Without a branch that depends on what is near: first all lists are put one after the other,
    /// then all that is listed is tested.
    pub fn reach(&self, balls: &[LooseBall], reached: &mut Reached) {
        let Reached { ends, numbers, balls: owners, before } = reached;
        // Never shorter, so that nothing is filled twice.
        let most = numbers.len().max(balls.len() * LONGEST);
        numbers.resize(most, 0);
        owners.resize(most, 0);
        before.resize(most + 1, 0);
        ends.clear();
        let mut listed = 0;
        for (ball, own) in balls.iter().zip(0..) {
            let cell = self.cell(ball);
            let [start, end] = [self.starts[cell] as usize, self.starts[cell + 1] as usize];
            // As many in any case, so that there is no loop.
            numbers[listed..listed + LONGEST].copy_from_slice(&self.members[start..][..LONGEST]);
            owners[listed..listed + LONGEST].fill(own);
            listed += end - start;
            ends.push(listed as u32);
        }
        let mut kept = 0;
        for k in 0..listed {
            let ball = &balls[owners[k] as usize];
            let outline = &self.outlines[numbers[k] as usize];
            numbers[kept] = numbers[k];
            kept += usize::from(outline.is_near(ball.centre.into(), ball.radius));
            before[k + 1] = kept as u32;
        }
        ends.iter_mut().for_each(|end| *end = before[*end as usize]);
    }

    /// The list that has all that a ball may reach.
    #[inline]
    fn cell(&self, ball: &LooseBall) -> usize {
        let cell = self.grid.cell(ball.centre.into());
        // Written so that NaN is not known.
        if ball.radius <= self.radius { cell } else { self.starts.len() - 2 }
    }

    /// Appends the pairs of a name with some of the outlines, by their numbers, whose closed boxes
    /// overlap that box and for which `keep(i, j)`, i < j, holds. No name may be that of an outline.
    #[inline]
    pub fn append_pairs(
        &self,
        (name, aabb): (u32, &Aabb),
        numbers: &[u32],
        keep: impl Fn(u32, u32) -> bool,
        out: &mut Vec<Pair>,
    ) {
        let (min, max) = (Vec3A::from(aabb.min), Vec3A::from(aabb.max));
        let start = out.len();
        let mut end = start;
        out.resize(start + numbers.len(), Pair::default());
        for &number in numbers {
            let outline = &self.outlines[number as usize];
            let overlap = (outline.min.cmple(max) & min.cmple(outline.max)).all();
            let pair = Pair::new(number, name);
            out[end] = pair;
            end += usize::from(overlap && keep(pair.i, pair.j));
        }
        out.truncate(end);
    }
}

/// An outline as it is compared: a cache line.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Compact {
    min: Vec3A,
    max: Vec3A,
    centre: Vec3A,
    radius: f32,
}

impl Compact {
    fn of(outline: &Outline) -> Self {
        let Outline { aabb: Aabb { min, max }, ball: LooseBall { centre, radius } } = *outline;
        Self { min: min.into(), max: max.into(), centre: centre.into(), radius }
    }

    /// Whether a [`LooseBall`] may reach what both the box and the ball contain: docs/numerics.md,
    /// "what is near".
    #[inline]
    fn is_near(&self, centre: Vec3A, radius: f32) -> bool {
        let beyond = (self.min - centre).max(centre - self.max).max(Vec3A::ZERO);
        let both = radius + self.radius;
        // What underflows is below the least normal number.
        let in_box = beyond.length_squared() <= radius * radius + f32::MIN_POSITIVE;
        let to_ball = (centre - self.centre).length_squared();
        in_box & (to_ball <= both * both + f32::MIN_POSITIVE)
    }
}

/// Cubes, or all but: each axis has its own scale. After the last cell along each axis comes one of
/// what is beyond, the first one has what is before it.
#[derive(Clone, Copy, Debug)]
struct Grid {
    origin: Vec3A,
    /// Cells a metre.
    scale: Vec3A,
    /// The number of the last cell along each axis, that of what is beyond.
    last: Vec3A,
    /// From one cell to the next along each axis.
    strides: Vec3A,
}

/// An f32 of this size has no digits after the point.
const WHOLE: f32 = (1 << 23) as f32;

impl Grid {
    /// Of as many cells over that extent as [`CELLS`] and [`LISTED`] allow for these boxes.
    fn finest(extent: Aabb, boxes: &[Aabb]) -> Self {
        let mut finest = Self::of(Aabb::default(), Vec3::ZERO);
        if !extent.is_valid() {
            return finest;
        }
        let size = extent.max - extent.min;
        let most = (CELLS * boxes.len()).min(MOST_CELLS);
        for halvings in 0..16 {
            let edge = size.max_element() / (1 << halvings) as f32;
            let grid = Self::of(extent, (size / edge).ceil().max(Vec3::ONE));
            let counts = boxes.iter().map(|aabb| grid.range(aabb).count());
            let listed = counts.fold(0, usize::saturating_add);
            if halvings > 0 && (grid.len() > most || listed > LISTED * boxes.len()) {
                break;
            }
            finest = grid;
        }
        finest
    }

    /// With so many cells along each axis.
    fn of(extent: Aabb, cells: Vec3) -> Self {
        // Nearly a cell short, so that the last point is in the last cell and not beyond.
        let scale = (cells - 0.75).max(Vec3::ZERO) / (extent.max - extent.min);
        let count = cells + 1.0;
        let strides = Vec3::new(1.0, count.x, count.x * count.y);
        Self {
            origin: extent.min.into(),
            // Where an extent is 0, or all but, one cell has all.
            scale: scale.map(|scale| if scale.is_finite() { scale } else { 0.0 }).into(),
            last: cells.into(),
            strides: strides.into(),
        }
    }

    fn len(&self) -> usize {
        let counts = Vec3::from(self.last + Vec3A::ONE).to_array();
        counts.iter().fold(1, |all: usize, &count| all.saturating_mul(count as usize))
    }

    /// The place of each coordinate along its axis, a whole number. It never falls where a
    /// coordinate grows, for rounding never turns two numbers round; so between two points of a box
    /// there are only places between theirs, whatever was rounded.
    #[inline]
    fn place(&self, point: Vec3A) -> Vec3A {
        let place = ((point - self.origin) * self.scale).max(Vec3A::ZERO).min(self.last);
        (place + WHOLE) - WHOLE
    }

    /// The number of the cell that a point is in.
    #[inline]
    fn cell(&self, point: Vec3A) -> usize {
        // The number's lowest bits, for it is whole and below 2²³.
        let number = self.place(point).dot(self.strides);
        ((number + WHOLE).to_bits() - WHOLE.to_bits()) as usize
    }

    fn range(&self, aabb: &Aabb) -> Range {
        let place = |point: Vec3| Vec3::from(self.place(point.into())).as_uvec3();
        Range { first: place(aabb.min), end: place(aabb.max) + UVec3::ONE }
    }

    fn for_each_cell(&self, aabb: &Aabb, mut visit: impl FnMut(usize)) {
        let Range { first, end } = self.range(aabb);
        let strides = Vec3::from(self.strides).as_uvec3();
        for z in first.z..end.z {
            for y in first.y..end.y {
                let row = (z * strides.z + y * strides.y) as usize;
                (first.x..end.x).for_each(|x| visit(row + x as usize));
            }
        }
    }
}

/// Cells from one up to another, that one not included.
struct Range {
    first: UVec3,
    end: UVec3,
}

impl Range {
    fn count(&self) -> usize {
        let counts = (self.end - self.first).to_array();
        counts.iter().fold(1, |all: usize, &count| all.saturating_mul(count as usize))
    }
}

/// Every centre of a ball of that radius that may reach the box. One step outward is more than the
/// difference's rounding.
fn widened(aabb: &Aabb, radius: f32) -> Aabb {
    Aabb {
        min: (aabb.min - radius).map(f32::next_down),
        max: (aabb.max + radius).map(f32::next_up),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dcd_geom::glam::Vec3Swizzles;

    fn outline(centre: Vec3, half: Vec3) -> Outline {
        let aabb = Aabb { min: centre - half, max: centre + half };
        Outline { aabb, ball: LooseBall { centre, radius: half.length() * 0.8 } }
    }

    /// Centres on a spiral of that size, and radii of some of its hundredths.
    fn balls(count: usize, size: f32) -> Vec<LooseBall> {
        let ball = |k: usize| {
            let t = k as f32;
            let centre = Vec3::new(t.sin(), (t * 0.73).cos(), (t * 0.37).sin() * 0.6) * size;
            LooseBall { centre, radius: size * (1.0 + t % 7.0) * 0.02 }
        };
        (0..count).map(ball).collect()
    }

    fn outlines(count: usize, size: f32) -> Vec<Outline> {
        let half = Vec3::new(1.0, 0.6, 0.3);
        let all = balls(count, size).into_iter();
        all.map(|LooseBall { centre, radius }| outline(-centre.zxy() * 0.9, half * radius))
            .collect()
    }

    /// By how much a ball ends short of both, metres, in f64: negative where it reaches both.
    fn gap(outline: &Outline, ball: &LooseBall) -> f64 {
        let Outline { aabb, ball: other } = outline;
        let (centre, radius) = (ball.centre.as_dvec3(), f64::from(ball.radius));
        let nearest = centre.clamp(aabb.min.as_dvec3(), aabb.max.as_dvec3());
        let between = centre.distance(other.centre.as_dvec3()) - f64::from(other.radius);
        centre.distance(nearest).max(between) - radius
    }

    fn reached(vicinity: &Vicinity, balls: &[LooseBall]) -> Vec<Vec<u32>> {
        let mut reached = Reached::default();
        // In memory that was used before, by more.
        vicinity.reach(&[balls, balls].concat(), &mut reached);
        vicinity.reach(balls, &mut reached);
        let starts = std::iter::once(&0).chain(reached.ends());
        let span = |(&start, &end): (&u32, &u32)| start as usize..end as usize;
        starts.zip(reached.ends()).map(span).map(|s| reached.numbers()[s].to_vec()).collect()
    }

    /// How many balls it knew nothing of.
    fn must_agree_with_the_plainest_judge(outlines: &[Outline], balls: &[LooseBall]) -> usize {
        let largest = balls.iter().map(|ball| ball.radius).fold(0.0, f32::max);
        let vicinity = Vicinity::new(outlines, largest);
        let mut unknown = 0;
        for (ball, told) in balls.iter().zip(reached(&vicinity, balls)) {
            if told == [vicinity.unknown()] {
                unknown += 1;
                continue;
            }
            assert!(told.is_sorted());
            for (number, outline) in (0..).zip(outlines) {
                // What balls allow for is far more than this.
                let (gap, rounding) = (gap(outline, ball), 1e-6 * f64::from(largest));
                assert!(told.contains(&number) || gap > -rounding, "{number} is lost: {gap}");
                assert!(!told.contains(&number) || gap <= rounding, "{number} is told: {gap}");
            }
        }
        unknown
    }

    #[test]
    fn all_that_a_ball_reaches_is_told_and_nothing_else_at_every_size() {
        for size in [1e-9, 1e-3, 1.0, 1e6, 1e15] {
            for count in [0, 1, 30, 500] {
                let balls = balls(400, size);
                let unknown = must_agree_with_the_plainest_judge(&outlines(count, size), &balls);
                assert!(unknown < 40, "{unknown} of 400 are not known");
            }
        }
    }

    #[test]
    fn what_has_no_end_or_lies_far_off_is_reached_too() {
        let mut outlines = outlines(40, 1.0);
        outlines.push(Outline::EVERYTHING);
        let floor = Aabb { max: Vec3::new(1e37, 1e37, -0.3), ..Aabb::EVERYTHING };
        outlines.push(Outline { aabb: floor, ball: LooseBall::EVERYTHING });
        must_agree_with_the_plainest_judge(&outlines, &balls(400, 1.0));
        outlines.push(outline(Vec3::splat(1e9), Vec3::ONE));
        must_agree_with_the_plainest_judge(&outlines, &balls(400, 1.0));
        let one_point = vec![outline(Vec3::ZERO, Vec3::ZERO); 3];
        must_agree_with_the_plainest_judge(
            &one_point,
            &[LooseBall { radius: 0.0, ..balls(1, 0.0)[0] }],
        );
        must_agree_with_the_plainest_judge(&one_point, &balls(50, 1e-3));
    }

    #[test]
    fn of_a_crowd_and_of_a_larger_ball_than_foreseen_nothing_is_known() {
        let crowd = vec![outline(Vec3::ZERO, Vec3::ONE); LONGEST + 1];
        let vicinity = Vicinity::new(&crowd, 0.5);
        let at = |x: f32, radius| LooseBall { centre: Vec3::X * x, radius };
        let asked = [at(0.0, 0.5), at(9.0, 0.5), at(9.0, 0.6), LooseBall::EVERYTHING];
        let unknown = vec![vicinity.unknown()];
        assert_eq!(reached(&vicinity, &asked), [unknown.clone(), vec![], unknown.clone(), unknown]);
        let vicinity = Vicinity::new(&crowd[..LONGEST], 0.5);
        assert_eq!(reached(&vicinity, &asked[..1]), [(0..LONGEST as u32).collect::<Vec<_>>()]);
    }

    #[test]
    fn pairs_are_those_of_the_boxes_that_overlap_and_are_kept() {
        let outlines = outlines(60, 1.0);
        let vicinity = Vicinity::new(&outlines, 0.1);
        let numbers: Vec<u32> = (0..60).collect();
        let asked = Aabb { min: Vec3::splat(-0.7), max: Vec3::splat(0.4) };
        let mut pairs = vec![Pair::new(1, 2)];
        vicinity.append_pairs(
            (99, &asked),
            &numbers,
            |i, j| !i.is_multiple_of(3) && j == 99,
            &mut pairs,
        );
        let overlaps =
            |i: &u32| outlines[*i as usize].aabb.overlaps(&asked) && !i.is_multiple_of(3);
        let due: Vec<Pair> =
            numbers.into_iter().filter(overlaps).map(|i| Pair::new(i, 99)).collect();
        assert!(due.len() > 3);
        assert_eq!(pairs[1..], due);
    }
}
