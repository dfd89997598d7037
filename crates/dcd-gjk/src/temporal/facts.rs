//! What is known of pairs, and until when.

use crate::simd::axis::Axis;
use dcd_geom::Pair;
use dcd_simd::prefetch;
use std::sync::atomic::{AtomicU32, AtomicU64, AtomicUsize, Ordering::Relaxed};

/// What is known of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fact {
    Apart,
    Touching,
}

/// Facts by pair, in tiles: what is known of each of some objects and each of some others.
///
/// Objects are ranked by when the candidates last named them: where these come leaf by leaf, in the
/// order of the leaves. So the pairs of two leaves, which come one after the other, find their facts
/// in one tile, for as long as objects stay about where they were.
///
/// A slot is one atomic word, so that threads read and write tiles at once; each pair has a slot of
/// its own.
#[derive(Debug, Default)]
pub(super) struct Facts {
    entries: Vec<Entry>,
    /// For each object the clearance that no fact about it is above, metres.
    limits: Vec<f32>,
    /// Objects whose ranks are alike but for this many bits share their tiles.
    shift: u32,
    /// For each group of objects its first tile, and one more.
    firsts: Vec<u32>,
    /// For each tile the other group that it is about, in ascending order from one `firsts` to the
    /// next. Groups of which there was no candidate when tiles were laid out have none.
    others: Vec<u32>,
    /// Tile by tile: the sum of the two ways up to which the fact holds, as an f32 above 0 whose
    /// sign bit says that the two touch; or 0. The first tile stands for those that do not exist.
    slots: Vec<AtomicU32>,
    /// For eight slots each the axis that separates one of their pairs, and one more than which.
    /// One that is lost to another pair's costs time and nothing else.
    axes: Vec<AtomicU64>,
    /// The objects by rank, and the groups of each tile; for laying out alone.
    order: Vec<u32>,
    listed: Vec<(u32, u32)>,
    /// How many facts have found no tile in this step.
    refused: AtomicUsize,
    /// Whether tiles are to be laid out for the candidates of this step.
    empty: bool,
    /// Whether they have been: then nothing is known of any pair.
    new: bool,
    /// How many pairs have been looked up in this step, and of how many something was known.
    looked_up: AtomicUsize,
    known: AtomicUsize,
}

/// Where an object's facts are, and how far it has travelled.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    rank: u32,
    /// How far its points have travelled, metres, rounded up.
    way: f32,
}

/// A pair's slot.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Slot(u32);

/// Where an object's facts are: see [`Facts::spot`].
struct Spot {
    /// That of the lower rank first.
    groups: (u32, u32),
    /// In the tile.
    place: u32,
    way: f32,
}

/// A pair's slot, and how far its objects have travelled together.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Found {
    pub(super) slot: Slot,
    way: f32,
}

/// The tile that stands for those that do not exist: nothing is written there.
const NO_TILE: u32 = 0;

/// Groups of sixteen where objects have this many candidates each, else of four: a tile should not
/// be much larger than what is kept in it. Larger: more tiles to be found in dense scenes. Smaller:
/// more memory in sparse ones.
const DENSE: usize = 32;

/// Tiles are laid out anew once the facts that have found none are this part of the candidates.
/// Larger: done more often. Smaller: more is found anew in each step.
const REFUSED: usize = 16;

/// Where nothing new is kept, pairs are looked up for as long as this part of them was known in the
/// step before. Larger: facts are lost that would have saved time. Smaller: more is looked up in vain.
const PAYS: f64 = 0.75;

/// How many slots share the clearance for one axis: of the pairs of a dense scene one in fifteen needs one.
/// Larger: more are lost. Smaller: more memory.
const SLOTS_WITH_ONE_AXIS: usize = 8;

/// The bit of a slot for which of the two facts it is: the threshold's sign.
const TOUCHES: u32 = 1 << 31;

/// A smaller clearance is not kept, metres: f32's roundings are relative above it.
const LEAST: f32 = 1e-30;

/// What a sum of two ways, a threshold and their conversions to f32 may gain by rounding. No unit.
const ROUNDED: f32 = 1.0 - 8.0 * (f32::EPSILON / 2.0);

/// How far an object has travelled, and the clearance that no fact about it is above. Metres.
#[derive(Clone, Copy, Debug)]
pub(super) struct Way {
    pub(super) travelled: f64,
    pub(super) limit: f64,
}

impl Way {
    /// Both to the safe side; a way that does not change keeps its number.
    pub(super) fn write(self, entry: &mut Entry, limit: &mut f32) {
        entry.way = (self.travelled as f32).next_up();
        *limit = (self.limit as f32).next_down().max(0.0);
    }
}

impl Default for Entry {
    /// Of an object that came after the layout: no tile is about it.
    fn default() -> Self {
        Self { rank: u32::MAX, way: 0.0 }
    }
}

impl Facts {
    /// Forgets all, at once; tiles are made when the candidates are known.
    pub(super) fn forget(&mut self) {
        self.empty = true;
        // Without groups no pair has a tile, and without slots none has a fact.
        self.firsts.clear();
        self.slots.clear();
        self.axes.clear();
    }

    /// One for each object of the scene.
    pub(super) fn resize(&mut self, objects: usize) {
        self.empty |= self.entries.is_empty();
        self.entries.resize(objects, Entry::default());
        self.limits.resize(objects, 0.0);
    }

    /// For each object where its way is written, and its limit.
    pub(super) fn ways_mut(&mut self) -> (&mut [Entry], &mut [f32]) {
        (&mut self.entries, &mut self.limits)
    }

    /// Lays out the tiles for these candidates if they are new, or too many facts found none.
    pub(super) fn lay_out_tiles<'p>(
        &mut self,
        candidates: impl Iterator<Item = &'p [Pair]> + Clone,
    ) {
        let refused = std::mem::take(self.refused.get_mut());
        self.new = false;
        if self.empty || refused > 0 {
            let pairs: usize = candidates.clone().map(<[Pair]>::len).sum();
            if self.empty || refused > pairs / REFUSED {
                self.shift = if pairs / DENSE >= self.entries.len() { 4 } else { 2 };
                self.set_ranks(candidates.clone());
                self.set_tiles(candidates);
                (self.empty, self.new) = (false, true);
            }
        }
    }

    /// Ranks the objects by when the candidates name them for the last time.
    fn set_ranks<'p>(&mut self, candidates: impl Iterator<Item = &'p [Pair]>) {
        self.entries.iter_mut().for_each(|entry| entry.rank = u32::MAX);
        for (number, pair) in (0..).zip(candidates.flatten()) {
            self.entries[pair.i as usize].rank = number;
            self.entries[pair.j as usize].rank = number;
        }
        self.order.clear();
        self.order.extend((0..).take(self.entries.len()));
        self.order.sort_unstable_by_key(|&object| (self.entries[object as usize].rank, object));
        for (rank, &object) in (0..).zip(&self.order) {
            self.entries[object as usize].rank = rank;
        }
    }

    /// Makes an empty tile for every two groups of which there is a candidate.
    fn set_tiles<'p>(&mut self, candidates: impl Iterator<Item = &'p [Pair]>) {
        let groups = self.entries.len().div_ceil(1 << self.shift);
        let mut tiles = std::mem::take(&mut self.listed);
        tiles.clear();
        for &pair in candidates.flatten() {
            let groups = self.spot(pair).groups;
            if tiles.last() != Some(&groups) {
                tiles.push(groups);
            }
        }
        tiles.sort_unstable();
        tiles.dedup();
        // Slots are numbered in 32 bits.
        tiles.truncate((1 << (32 - 2 * self.shift)) - 1);
        self.others.clear();
        self.others.push(u32::MAX);
        self.others.extend(tiles.iter().map(|&(_, other)| other));
        self.firsts.clear();
        let first = |group| 1 + tiles.partition_point(|&(low, _)| low < group) as u32;
        self.firsts.extend((0..=groups as u32).map(first));
        self.slots.clear();
        self.slots.resize_with(self.others.len() << (2 * self.shift), || AtomicU32::new(0));
        self.axes.clear();
        self.axes.resize_with(self.slots.len() / SLOTS_WITH_ONE_AXIS, || AtomicU64::new(0));
        self.listed = tiles;
    }

    /// Where a pair's fact is, and how far its objects have travelled together.
    #[inline(always)]
    fn spot(&self, Pair { i, j }: Pair) -> Spot {
        let (a, b) = (self.entries[i as usize], self.entries[j as usize]);
        let (low, high) = (a.rank.min(b.rank), a.rank.max(b.rank));
        let alone = (1 << self.shift) - 1;
        Spot {
            groups: (low >> self.shift, high >> self.shift),
            place: (low & alone) << self.shift | high & alone,
            way: a.way + b.way,
        }
    }

    /// The first slot of the tile of two groups.
    #[inline(always)]
    fn tile(&self, (low, high): (u32, u32)) -> u32 {
        let ends = self.firsts.get(low as usize..).and_then(|firsts| firsts.first_chunk());
        let Some(&[first, end]) = ends else { return NO_TILE };
        let others = self.others.get(first as usize..end as usize).unwrap_or_default();
        let at = others.partition_point(|&other| other < high);
        let found = others.get(at) == Some(&high);
        if found { (first + at as u32) << (2 * self.shift) } else { NO_TILE }
    }

    /// Whether nothing is known of any pair, in this step.
    pub(super) fn are_new(&self) -> bool {
        self.new
    }

    /// Counts pairs that have been looked up, and those of which something was known.
    pub(super) fn count(&self, looked_up: usize, known: usize) {
        self.looked_up.fetch_add(looked_up, Relaxed);
        self.known.fetch_add(known, Relaxed);
    }

    /// Whether the last step knew enough for another look-up to pay, though nothing be kept in it.
    /// Begins to count anew.
    pub(super) fn still_pay(&mut self) -> bool {
        let looked_up = std::mem::take(self.looked_up.get_mut());
        let known = std::mem::take(self.known.get_mut());
        self.are_dense() && looked_up > 0 && (self.new || known as f64 >= PAYS * looked_up as f64)
    }

    /// Whether objects have so many candidates that a fact costs little beside a fresh answer.
    pub(super) fn are_dense(&self) -> bool {
        self.shift == 4
    }

    /// For looking up pairs one after the other.
    pub(super) fn reader(&self) -> Reader<'_> {
        Reader { facts: self, groups: (u32::MAX, u32::MAX), first: NO_TILE }
    }

    /// What is known of a pair that has just been found.
    #[inline(always)]
    pub(super) fn recall(&self, found: &Found) -> Option<Fact> {
        let word = self.slots.get(found.slot.0 as usize).map_or(0, |slot| slot.load(Relaxed));
        let fact = if word & TOUCHES == 0 { Fact::Apart } else { Fact::Touching };
        (found.way < f32::from_bits(word & !TOUCHES)).then_some(fact)
    }

    /// Where a slot's axis is, and the mark of an axis of this slot.
    #[inline(always)]
    fn axis_at(&self, Slot(slot): Slot) -> (Option<&AtomicU64>, u64) {
        let (at, which) =
            (slot as usize / SLOTS_WITH_ONE_AXIS, slot as usize % SLOTS_WITH_ONE_AXIS);
        (self.axes.get(at), which as u64 + 1)
    }

    /// The axis that separated a pair last, if it was hard to find.
    #[inline(always)]
    pub(super) fn axis(&self, slot: Slot) -> Axis {
        let (word, which) = self.axis_at(slot);
        let word = word.map_or(0, |word| word.load(Relaxed));
        let axis = if word & 0xffff == which { word } else { 0 };
        Axis([(axis >> 16) as i16, (axis >> 32) as i16, (axis >> 48) as i16])
    }

    /// Keeps the axis of a pair that is apart, and forgets that of one that has come to touch.
    #[inline(always)]
    pub(super) fn keep_axis(&self, slot: Slot, fact: Fact, axis: Axis) {
        let (word, which) = self.axis_at(slot);
        let [x, y, z] = axis.0.map(|x| u64::from(x as u16));
        let apart = z << 48 | y << 32 | x << 16 | which;
        let new = if fact == Fact::Apart { apart } else { 0 };
        if let Some(word) = word {
            word.store(new, Relaxed);
        }
    }

    /// Keeps what was proved of a pair just now, with that clearance, metres.
    #[inline(always)]
    pub(super) fn remember(&self, (pair, slot): (Pair, Slot), fact: Fact, clearance: f32) {
        let Pair { i, j } = pair;
        let way = self.entries[i as usize].way + self.entries[j as usize].way;
        let limit = self.limits[i as usize].min(self.limits[j as usize]);
        let until = (way * ROUNDED + clearance.min(limit)) * ROUNDED;
        // Written so that NaN is not kept.
        if !(way < until && clearance > LEAST) {
            return;
        }
        let touches = if fact == Fact::Touching { TOUCHES } else { 0 };
        if slot.0 >> (2 * self.shift) == NO_TILE {
            self.refused.fetch_add(1, Relaxed);
        } else if let Some(slot) = self.slots.get(slot.0 as usize) {
            slot.store(touches | until.to_bits(), Relaxed);
        }
    }
}

/// Looks up pairs, of which most have their facts in the tile of the one before.
#[derive(Debug)]
pub(super) struct Reader<'f> {
    facts: &'f Facts,
    /// Those of the last pair, and the first slot of their tile.
    groups: (u32, u32),
    first: u32,
}

impl Reader<'_> {
    /// Where a pair's fact is. Prefetches it.
    #[inline(always)]
    pub(super) fn find(&mut self, pair: Pair) -> Found {
        let Spot { groups, place, way } = self.facts.spot(pair);
        if groups != self.groups {
            (self.groups, self.first) = (groups, self.facts.tile(groups));
        }
        let slot = self.first | place;
        prefetch(self.facts.slots.get(slot as usize..slot as usize + 1).unwrap_or_default());
        Found { slot: Slot(slot), way }
    }
}
