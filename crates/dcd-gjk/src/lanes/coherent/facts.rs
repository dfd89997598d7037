//! What is known of pairs, and until when.

use dcd_geom::Pair;
use dcd_geom::lanes::prefetch;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering::Relaxed};

/// What is known of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fact {
    Apart,
    Touching,
}

/// Facts by pair: for each object a shelf of slots, which hold what is known of it and of objects
/// whose shelves come later.
///
/// Shelves come in the order in which the candidates last named their objects: where these come
/// leaf by leaf, that of the leaves. So the pairs of a leaf find their facts in a few neighbouring
/// shelves, for as long as objects stay about where they were.
///
/// A slot is one atomic word, so that threads read and write shelves at once. A fact that is lost
/// to another thread's costs time and nothing else.
#[derive(Debug, Default)]
pub(super) struct Facts {
    shelves: Vec<Shelf>,
    /// For each object the room that no fact about it is above, metres.
    limits: Vec<f32>,
    slots: Vec<Bunch>,
    /// The objects in the order of their shelves; for laying out alone.
    order: Vec<u32>,
    /// How many facts have found no slot in this step.
    refused: AtomicUsize,
    /// Whether the shelves are to be laid out for the candidates of this step.
    empty: bool,
}

/// An object's part of the slots, and how far it has travelled.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Shelf {
    /// Its place in the order of shelves.
    place: u32,
    /// Its first bunch of slots; one more than its own stands behind its last.
    first: u32,
    /// How many bunches it has; while shelves are laid out, for how
    /// many pairs it is.
    bunches: u32,
    /// How far its points have travelled, metres, rounded up; NaN for an object that moves so fast
    /// that nothing about it is worth keeping.
    way: f32,
}

/// Slots that are looked at together: a fact lies in the bunch that its pair is hashed to, or in the
/// one after.
type Bunch = [AtomicU64; 4];

/// Slots for each pair that a shelf is laid out for. Larger: more memory. Smaller: more facts find
/// no slot.
const SLOTS_FOR_ONE: u32 = 2;

/// The shelves are laid out anew once the facts that have found no slot are this part of the
/// candidates. Larger: done more often. Smaller: more is found anew in each step.
const REFUSED: usize = 8;

/// A slot that holds nothing: its threshold is NaN, and so is above no way.
const NOTHING: u64 = u64::MAX;

/// What a search in a bunch tells where the fact may lie in the next one; as a threshold it is NaN
/// as well.
const FULL: u64 = u64::MAX - 1;

/// The bit of a slot that says which of the two it is: the threshold's sign.
const TOUCHES: u64 = 1 << 31;

/// A smaller room is not kept, metres: f32's roundings are relative above it.
const LEAST: f32 = 1e-30;

/// What a sum of two ways, a threshold and their conversions to f32 may gain by rounding. No unit.
const ROUNDED: f32 = 1.0 - 8.0 * (f32::EPSILON / 2.0);

/// How far an object has travelled, and the room that no fact about it is above. Metres.
#[derive(Clone, Copy, Debug)]
pub(super) struct Way {
    pub(super) travelled: f64,
    pub(super) limit: f64,
    /// Whether it moves too fast for facts about it to last.
    pub(super) restless: bool,
}

impl Way {
    /// Both to the safe side; a way that does not change keeps its number.
    pub(super) fn write(self, shelf: &mut Shelf, limit: &mut f32) {
        shelf.way = if self.restless { f32::NAN } else { (self.travelled as f32).next_up() };
        *limit = (self.limit as f32).next_down().max(0.0);
    }
}

impl Shelf {
    /// The bunch in which an object's slot is looked for first; `None` on a shelf without slots.
    #[inline(always)]
    fn bunch(&self, other: u32) -> Option<usize> {
        // Fibonacci hashing (Knuth, The Art of Computer Programming 3, 6.4).
        let hash = other.wrapping_mul(0x9E37_79B9);
        let bunch = (u64::from(hash) * u64::from(self.bunches)) >> 32;
        (self.bunches > 0).then_some(self.first as usize + bunch as usize)
    }
}

impl Facts {
    /// Forgets all; slots and shelves are made when the candidates are known.
    pub(super) fn forget(&mut self) {
        self.empty = true;
    }

    /// One for each object of the scene. New ones have no slots yet.
    pub(super) fn make_shelves(&mut self, objects: usize) {
        self.empty |= self.shelves.is_empty();
        self.shelves.resize(objects, Shelf::default());
        self.limits.resize(objects, 0.0);
    }

    /// For each object where its way is written, and its limit.
    pub(super) fn ways_mut(&mut self) -> (&mut [Shelf], &mut [f32]) {
        (&mut self.shelves, &mut self.limits)
    }

    /// Lays out the shelves for these candidates if they are new, or too many facts found no slot.
    pub(super) fn make_room<'p>(&mut self, candidates: impl Iterator<Item = &'p [Pair]> + Clone) {
        let refused = std::mem::take(self.refused.get_mut());
        if refused > 0 {
            let pairs: usize = candidates.clone().map(<[Pair]>::len).sum();
            self.empty |= refused > pairs / REFUSED;
        }
        if std::mem::take(&mut self.empty) {
            self.set_places(candidates.clone());
            self.set_bunches(candidates);
        }
    }

    /// Numbers the objects in the order in which the candidates name them for the last time; those
    /// that they do not name come first.
    fn set_places<'p>(&mut self, candidates: impl Iterator<Item = &'p [Pair]>) {
        self.shelves.iter_mut().for_each(|shelf| shelf.place = 0);
        for (number, pair) in (1..).zip(candidates.flatten()) {
            self.shelves[pair.i as usize].place = number;
            self.shelves[pair.j as usize].place = number;
        }
        self.order.clear();
        self.order.extend((0..).take(self.shelves.len()));
        self.order.sort_unstable_by_key(|&object| (self.shelves[object as usize].place, object));
        for (number, &object) in (0..).zip(&self.order) {
            self.shelves[object as usize].place = number;
        }
    }

    /// Makes room on each shelf for its pairs.
    fn set_bunches<'p>(&mut self, candidates: impl Iterator<Item = &'p [Pair]>) {
        self.shelves.iter_mut().for_each(|shelf| shelf.bunches = 0);
        for &pair in candidates.flatten() {
            let (own, _) = self.owner(pair);
            self.shelves[own as usize].bunches += 1;
        }
        let mut first = 0u32;
        for &object in &self.order {
            let shelf = &mut self.shelves[object as usize];
            let slots = shelf.bunches.max(1).saturating_mul(SLOTS_FOR_ONE);
            let bunches = slots.div_ceil(size_of::<Bunch>() as u32 / size_of::<AtomicU64>() as u32);
            (shelf.first, shelf.bunches) = (first, bunches);
            first = first.saturating_add(bunches + 1);
        }
        self.slots.clear();
        self.slots.resize_with(first as usize, || [const { AtomicU64::new(NOTHING) }; 4]);
    }

    /// On whose shelf a pair's fact lies, and the other object.
    #[inline(always)]
    fn owner(&self, Pair { i, j }: Pair) -> (u32, u32) {
        if self.shelves[i as usize].place <= self.shelves[j as usize].place {
            (i, j)
        } else {
            (j, i)
        }
    }

    /// Asks memory for what [`Facts::recall`] will read. A hint.
    #[inline(always)]
    pub(super) fn look_ahead(&self, pair: Pair) {
        let (own, other) = self.owner(pair);
        if let Some(bunch) = self.shelves[own as usize].bunch(other) {
            prefetch(self.slots.get(bunch..bunch + 1).unwrap_or_default());
        }
    }

    /// What is known of a pair now.
    #[inline(always)]
    pub(super) fn recall(&self, pair: Pair) -> Option<Fact> {
        let (own, other) = self.owner(pair);
        let shelf = &self.shelves[own as usize];
        let way = shelf.way + self.shelves[other as usize].way;
        if way.is_nan() {
            return None;
        }
        let bunch = shelf.bunch(other)?;
        let mut slot = self.find(bunch, other);
        if slot == FULL {
            slot = self.find(bunch + 1, other);
        }
        let fact = if slot & TOUCHES == 0 { Fact::Apart } else { Fact::Touching };
        (way < threshold(slot)).then_some(fact)
    }

    /// The slot about that object in a bunch; else [`FULL`] if there is no room left in it, or
    /// [`NOTHING`].
    #[inline(always)]
    fn find(&self, bunch: usize, other: u32) -> u64 {
        let Some(slots) = self.slots.get(bunch) else { return NOTHING };
        // Slots are filled from the first on. No branch depends on where the fact lies.
        let [.., last] = slots;
        let mut found = if last.load(Relaxed) == NOTHING { NOTHING } else { FULL };
        for slot in slots {
            let slot = slot.load(Relaxed);
            found = if (slot >> 32) as u32 == other { slot } else { found };
        }
        found
    }

    /// Keeps what was proved of a pair just now, with that room, metres.
    #[inline(always)]
    pub(super) fn remember(&self, pair: Pair, fact: Fact, room: f32) {
        let (own, other) = self.owner(pair);
        let (shelf, other_shelf) = (&self.shelves[own as usize], &self.shelves[other as usize]);
        let way = shelf.way + other_shelf.way;
        let limit = self.limits[own as usize].min(self.limits[other as usize]);
        let until = (way * ROUNDED + room.min(limit)) * ROUNDED;
        // Written so that NaN is not kept.
        if !(way < until && room > LEAST) {
            return;
        }
        let touches = if fact == Fact::Touching { TOUCHES } else { 0 };
        let new = u64::from(other) << 32 | touches | u64::from(until.to_bits());
        let Some(bunch) = shelf.bunch(other) else { return };
        for bunch in [bunch, bunch + 1] {
            if let Some(slot) = self.free_slot(shelf, bunch, other) {
                slot.store(new, Relaxed);
                return;
            }
        }
        self.refused.fetch_add(1, Relaxed);
    }

    /// Where a bunch has room for a fact about that object: where the last one about it is, else
    /// where nothing is, else where something is no longer known.
    #[inline(always)]
    fn free_slot(&self, shelf: &Shelf, bunch: usize, other: u32) -> Option<&AtomicU64> {
        let slots = self.slots.get(bunch)?;
        let mut place = slots.len();
        for k in (0..slots.len()).rev() {
            place = if slots[k].load(Relaxed) == NOTHING { k } else { place };
        }
        for (k, slot) in slots.iter().enumerate() {
            place = if (slot.load(Relaxed) >> 32) as u32 == other { k } else { place };
        }
        let expired = |slot: &&AtomicU64| self.has_expired(shelf, slot.load(Relaxed));
        slots.get(place).or_else(|| slots.iter().find(expired))
    }

    /// Whether a slot of that shelf holds nothing that is still known.
    #[inline(always)]
    fn has_expired(&self, own: &Shelf, slot: u64) -> bool {
        let other = self.shelves.get((slot >> 32) as usize);
        !other.is_some_and(|other| own.way + other.way < threshold(slot))
    }
}

/// The sum of the two ways up to which a slot's fact holds.
#[inline(always)]
fn threshold(slot: u64) -> f32 {
    f32::from_bits((slot & !TOUCHES) as u32)
}
