//! Where to cut, so that all ranks have equally much to do.

use crate::{Cuts, Grid, Transport};
use dcd_broad::{IdentifiedAabbs, StaticTree};
use dcd_exec::{Exec, Segments};
use dcd_geom::glam::{DVec3, Vec3};
use dcd_geom::{Aabb, Pair};

/// How many objects are drawn for a cut, about, at least; and for each rank. More: a better balance, and
/// more to sort on every rank. 256 for a rank leave a deviation of some 6 % where costs are alike.
const DRAWN: u64 = 1 << 16;
const DRAWN_A_RANK: u64 = 256;

/// How many pairs of those that were drawn are looked at, at most, for each object that was.
const PAIRS_A_DRAWN: u64 = 16;

/// What a rank has to do in a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Load {
    /// Objects that it owns.
    pub objects: u64,
    /// Candidate pairs that it judges.
    pub pairs: u64,
}

impl Load {
    /// In candidate pairs: an object, with its box and its place in the tree, takes about as long as two of
    /// them (100 ns against 50 ns for the paper's hulls).
    pub fn cost(self) -> u64 {
        2 * self.objects + self.pairs
    }
}

/// Regions of equal cost for the objects with these boxes and names, each rank giving those that it has.
///
/// Some objects are drawn, by their names alone, and the candidates that they are in; an object costs where
/// its middle is, a pair where the lower corner of its intersection is. The regions are cut between them. So
/// the cuts depend on the objects and the number of ranks, not on who has which.
pub fn cut(transport: &impl Transport, boxes: &[Aabb], names: &[u64], exec: Exec) -> Cuts {
    let drawn = Drawn::among(transport, boxes, names);
    let grid = grid(transport, boxes, &drawn.fences());
    let pairs = drawn.pairs(&grid, boxes, names, exec);
    let objects = drawn.boxes.len() as u64;
    let (pairs, weight) = thinned(transport, pairs, PAIRS_A_DRAWN * objects);
    // A pair is found from both of its ends, so that it counts half at each.
    let object = 2 * Load { objects: 1, pairs: 0 }.cost();
    let objects = drawn.boxes.iter().map(|aabb| (grid.key_of(aabb), object));
    let mut costs: Vec<(u64, u64)> =
        objects.chain(pairs.into_iter().map(|key| (key, weight))).collect();
    costs.sort_unstable();
    let stands_for = stands_for(transport, &grid, boxes, &drawn);
    costs.iter_mut().for_each(|(key, cost)| *cost *= stands_for[octant(*key)]);
    Cuts::new(grid, starts(&costs, transport.size()))
}

/// Octants in which objects are counted: 16 along each axis, so that [`DRAWN`] objects leave hardly one without any.
/// More: objects of octants that nothing was drawn in count nowhere, which moves the cuts. Fewer: a draw that has hit
/// one side of an octant more than the other does.
const OCTANTS: usize = 1 << 12;

/// What one drawn object stands for where all are drawn.
const ONE: u64 = 1 << 10;

/// The octant of a key.
fn octant(key: u64) -> usize {
    (key >> 51) as usize & (OCTANTS - 1)
}

/// For each octant how many objects one of those that were drawn there stands for: all are counted, so that a
/// draw that has hit one place more than another moves no cut.
fn stands_for(transport: &impl Transport, grid: &Grid, boxes: &[Aabb], drawn: &Drawn) -> Vec<u64> {
    let counts = |boxes: &[Aabb]| {
        let mut counts = vec![0u64; OCTANTS];
        boxes.iter().for_each(|aabb| counts[octant(grid.key_of(aabb))] += 1);
        counts
    };
    let mut all = counts(boxes);
    transport.sum(&mut all);
    let drawn = counts(&drawn.boxes);
    let sum = |counts: &[u64]| counts.iter().sum::<u64>().max(1);
    let usual = ONE * sum(&all) / sum(&drawn);
    all.iter()
        .zip(&drawn)
        .map(|(&all, &drawn)| (ONE * all).checked_div(drawn).unwrap_or(usual))
        .collect()
}

/// By how much of a rank's part a cut may be off, one part in so many, for the sake of a rounder key, which makes
/// larger cubes of the regions, with less surface and fewer ghosts. Larger parts: worse balance.
const GIVE: u64 = 50;

/// The same for the sake of a key at which an octant as large as a rank's part, or larger, begins: then both regions
/// are whole cubes.
const GIVE_FOR_OCTANTS: u64 = 12;

/// The first key of each rank, where its part of the cost begins, about: of costs at keys, ascending.
fn starts(costs: &[(u64, u64)], size: usize) -> Vec<u64> {
    let whole: u64 = costs.iter().map(|&(_, cost)| cost).sum();
    let (size, mut before) = (size as u64, 0);
    // Sums of cost before each key, times the number of ranks: a rank's part is `whole`.
    let sums: Vec<(u64, u64)> = costs
        .iter()
        .map(|&(key, cost)| {
            before += cost;
            (key, (before - cost) * size)
        })
        .collect();
    // The roundest key before which the cost is off by one part in `give` at most, or else that of the next.
    let cut_within = |exact: u64, give: u64| {
        let off = whole / give;
        let next = sums.partition_point(|&(_, before)| before < exact);
        let first = sums.partition_point(|&(_, before)| before + off < exact);
        let last = sums.partition_point(|&(_, before)| before <= exact + off);
        let (first, last) = if first < last { (first, last - 1) } else { (next, next) };
        let low = first.checked_sub(1).map_or(0, |before| sums[before].0);
        sums.get(last).map_or(u64::MAX, |&(high, _)| roundest(low, high))
    };
    // Keys have 63 bits, three an octant.
    let part = (63 - size.ilog2()) / 3 * 3;
    let cut = |rank: u64| {
        let wide = cut_within(rank * whole, GIVE_FOR_OCTANTS);
        let is_whole = wide != u64::MAX && wide.trailing_zeros() >= part;
        if is_whole { wide } else { cut_within(rank * whole, GIVE) }
    };
    let mut starts: Vec<u64> =
        (0..size).map(|rank| if rank == 0 { 0 } else { cut(rank) }).collect();
    // A few objects for many ranks.
    starts.sort_unstable();
    starts
}

/// The number above `low` and not above `high` that 2 divides most often; `high` where there is none.
fn roundest(low: u64, high: u64) -> u64 {
    match low ^ high {
        0 => high,
        // Above the highest bit in which they differ they are alike, and there `high` has a 1.
        differ => high >> differ.ilog2() << differ.ilog2(),
    }
}

/// Of the numbered keys of all ranks at most so many, and how many each of them stands for: those that are
/// kept depend on their numbers alone.
fn thinned(transport: &impl Transport, own: Vec<(u64, u64)>, most: u64) -> (Vec<u64>, u64) {
    let mut count = [own.len() as u64];
    transport.sum(&mut count);
    let halvings = (0..63).find(|halvings| count[0] >> halvings <= most).unwrap_or(63);
    let kept = own.into_iter().filter(|(number, _)| number >> 1 <= (u64::MAX >> 1) >> halvings);
    let bytes: Vec<u8> = kept.flat_map(|(_, key)| key.to_le_bytes()).collect();
    let mut keys = Vec::new();
    for given in transport.all_gather(&bytes) {
        let (given, _) = given.as_chunks();
        keys.extend(given.iter().map(|key| u64::from_le_bytes(*key)));
    }
    (keys, 1 << halvings)
}

/// In the middle of a box.
fn middle(aabb: &Aabb) -> DVec3 {
    (aabb.min + (aabb.max - aabb.min) * 0.5).as_dvec3()
}

/// A grid leaves out what is further from the middle half of the objects than so many times its extent: half-spaces,
/// and what has fallen out of the world. Larger: such an object leaves the others fewer cells, of 2²¹ along an axis.
/// Smaller: more objects that share the outermost cells.
const FENCES: f64 = 1024.0;

/// Over the middles of all boxes within the fences.
fn grid(transport: &impl Transport, boxes: &[Aabb], fences: &(DVec3, DVec3)) -> Grid {
    let nothing = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let is_within = |p: &DVec3| p.cmpge(fences.0).all() && p.cmple(fences.1).all();
    let middles = boxes.iter().map(middle).filter(is_within);
    let (min, max) = middles.fold(nothing, |(a, b), p| (a.min(p), b.max(p)));
    let own: Vec<u8> =
        [min, max].iter().flat_map(|v| v.to_array()).flat_map(f64::to_le_bytes).collect();
    let (mut min, mut max) = nothing;
    for given in transport.all_gather(&own) {
        let (numbers, _) = given.as_chunks();
        if let [a, b, c, d, e, f] = *numbers {
            let vector = |v: [[u8; 8]; 3]| DVec3::from_array(v.map(f64::from_le_bytes));
            (min, max) = (min.min(vector([a, b, c])), max.max(vector([d, e, f])));
        }
    }
    Grid::over(min, max)
}

/// Objects that were drawn, the same on all ranks.
struct Drawn {
    boxes: Vec<Aabb>,
    names: Vec<u64>,
}

impl Drawn {
    fn among(transport: &impl Transport, boxes: &[Aabb], names: &[u64]) -> Self {
        let mut count = [boxes.len() as u64];
        transport.sum(&mut count);
        let wanted = DRAWN.max(DRAWN_A_RANK * transport.size() as u64);
        let is_drawn = |name: u64| {
            let part = u64::MAX / count[0].max(1);
            count[0] <= wanted || mixed(name) <= part.saturating_mul(wanted)
        };
        let mut own = Vec::new();
        for (aabb, &name) in boxes.iter().zip(names).filter(|(_, name)| is_drawn(**name)) {
            own.extend_from_slice(&name.to_le_bytes());
            let corners = [aabb.min, aabb.max].map(|corner| corner.to_array());
            corners.as_flattened().iter().for_each(|x| own.extend_from_slice(&x.to_le_bytes()));
        }
        let mut drawn = Self { boxes: Vec::new(), names: Vec::new() };
        for given in transport.all_gather(&own) {
            let (records, _) = given.as_chunks::<32>();
            for record in records {
                let (numbers, _) = record.as_chunks::<4>();
                if let [low, high, corners @ ..] = numbers {
                    let [low, high] = [low, high].map(|half| u64::from(u32::from_le_bytes(*half)));
                    let at = |k: usize| f32::from_le_bytes(corners[k]);
                    let corner = |k: usize| Vec3::new(at(k), at(k + 1), at(k + 2));
                    drawn.names.push(low | high << 32);
                    drawn.boxes.push(Aabb { min: corner(0), max: corner(3) });
                }
            }
        }
        drawn
    }

    /// From where to where the middles reach that a grid is laid over.
    fn fences(&self) -> (DVec3, DVec3) {
        let quartiles = |axis: usize| {
            let mut along: Vec<f64> = self.boxes.iter().map(|aabb| middle(aabb)[axis]).collect();
            along.sort_unstable_by(f64::total_cmp);
            let quartile = |k: usize| along.get(along.len() * k / 4).copied().unwrap_or(0.0);
            (quartile(1), quartile(3))
        };
        let [x, y, z] = [0, 1, 2].map(quartiles);
        let (first, third) = (DVec3::new(x.0, y.0, z.0), DVec3::new(x.1, y.1, z.1));
        let reach = FENCES * (third - first).max_element();
        // More than half of them at one place say nothing of the others.
        let reach = if reach > 0.0 { reach } else { f64::INFINITY };
        (first - reach, third + reach)
    }

    /// The candidates of a drawn object and one of these: for each a number that depends on the pair, and the
    /// key of its corner.
    fn pairs(&self, grid: &Grid, boxes: &[Aabb], names: &[u64], exec: Exec) -> Vec<(u64, u64)> {
        let mut found = Vec::new();
        let drawn = u32::try_from(self.boxes.len()).unwrap_or(u32::MAX);
        let indices: Vec<u32> = (0..drawn).collect();
        let mut tree = StaticTree::default();
        tree.build(IdentifiedAabbs { aabbs: &self.boxes, names: &indices }, exec);
        let mut pairs: Segments<Pair> = Segments::default();
        // In parts, so that the pairs of a wall and a world take little memory.
        for (boxes, names) in boxes.chunks(PART).zip(names.chunks(PART)) {
            let queries: Vec<u32> = (drawn..).take(boxes.len()).collect();
            let is_another = |i: u32, j: u32| self.names[i as usize] != names[(j - drawn) as usize];
            let queries = IdentifiedAabbs { aabbs: boxes, names: &queries };
            tree.pairs(queries, is_another, exec, &mut pairs);
            found.extend(pairs.iter().flatten().map(|pair| {
                let (i, j) = (pair.i as usize, (pair.j - drawn) as usize);
                let corner = self.boxes[i].min.max(boxes[j].min);
                (mixed(mixed(self.names[i]) ^ names[j]), grid.key(corner))
            }));
        }
        found
    }
}

/// How many boxes query the tree at a time.
const PART: usize = 1 << 14;

/// A number of which every bit depends on all of the name's (the finalizer of SplitMix64, Steele, Lea and
/// Flood 2014).
pub(crate) fn mixed(name: u64) -> u64 {
    let mut z = name.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::threads;

    #[test]
    fn equal_costs_are_cut_in_equal_numbers_and_a_dear_one_stands_alone() {
        let alike: Vec<_> = (0..12).map(|k| (k * 10, 5)).collect();
        assert_eq!(starts(&alike, 4), [0, 24, 56, 88]);
        let dear: Vec<_> = (0..4).map(|k| (k, if k == 1 { 97 } else { 1 })).collect();
        assert_eq!(starts(&dear, 2), [0, 2]);
        assert_eq!(starts(&[], 3), [0, u64::MAX, u64::MAX]);
        assert_eq!(starts(&[(7, 1)], 3), [0, u64::MAX, u64::MAX]);
    }

    #[test]
    fn a_cut_is_as_round_as_its_give_allows() {
        assert_eq!(roundest(5, 5), 5);
        assert_eq!(roundest(0b0111, 0b1010), 0b1000);
        assert_eq!(roundest(0b1_0011, 0b1_0110), 0b1_0100);
        assert_eq!(roundest(8, 9), 9);
        // Even costs at odd keys: the cut is a power of two.
        let alike: Vec<_> = (0..10_000).map(|k| (2 * k + 385, 3)).collect();
        assert_eq!(starts(&alike, 2), [0, 10_240]);
        for (low, high) in [(3, 900), (1 << 40, (1 << 40) + 77), (12, 13)] {
            let round = roundest(low, high);
            let slowly = (low + 1..=high).max_by_key(|k| (k.trailing_zeros(), u64::MAX - k));
            assert_eq!(Some(round.trailing_zeros()), slowly.map(u64::trailing_zeros));
            assert!(low < round && round <= high);
        }
    }

    #[test]
    fn what_is_thinned_stands_for_what_is_left_out() {
        let numbered = |rank: u64| (0..10_000).map(|k| (mixed(k + (rank << 32)), k)).collect();
        let found = threads::run(2, |rank| thinned(rank, numbered(rank.rank() as u64), 1000));
        assert_eq!(found[0], found[1]);
        let (keys, weight) = &found[0];
        assert_eq!(*weight, 32);
        let stands_for = keys.len() as f64 * 32.0;
        assert!((stands_for / 20_000.0 - 1.0).abs() < 0.2, "{stands_for}");
        let all = threads::run(2, |rank| thinned(rank, numbered(rank.rank() as u64), 20_000));
        assert_eq!((all[0].0.len(), all[0].1), (20_000, 1));
    }

    #[test]
    fn cuts_do_not_depend_on_who_has_which() {
        let boxes: Vec<Aabb> = (0..1000u64)
            .map(|k| {
                let at = |axis| (mixed(3 * k + axis) >> 40) as f32 / 16384.0;
                let min = Vec3::new(at(0), at(1), at(2));
                Aabb { min, max: min + 10.0 }
            })
            .collect();
        let spread = |way: fn(u64) -> usize| {
            threads::run(3, |rank| {
                let names: Vec<u64> = (0..1000).filter(|&k| way(k) == rank.rank()).collect();
                let own: Vec<Aabb> = names.iter().map(|&k| boxes[k as usize]).collect();
                cut(rank, &own, &names, Exec::default())
            })
        };
        let (striped, all_on_one) = (spread(|k| k as usize % 3), spread(|_| 1));
        assert_eq!(striped, all_on_one);
        assert_eq!(striped[0], striped[2]);
        let owners: Vec<usize> = boxes.iter().map(|aabb| striped[0].owner(aabb)).collect();
        for rank in 0..3 {
            let owned = owners.iter().filter(|&&owner| owner == rank).count();
            assert!((250..420).contains(&owned), "{owned}");
        }
    }
}
