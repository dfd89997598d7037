//! Compounds in the lanes: each part is an object of the frame, behind those of the scene.
//!
//! So a pair of compounds is as many pairs of parts as have boxes that overlap, and these pass the
//! stages of any pair, sixteen at a time, whichever compounds they are of.

use super::bounds::TURNED;
use super::cores::{Core, Cores};
use super::frame::{Extremes, HAS_OBB, LIVE, ObbRecord, Record, WHOLE};
use super::part_group::{PartGroup, union};
use super::prepare::{Rotation, boxed, place, turn};
use dcd_geom::{Aabb, Aabb16, Pose, Scene, Shape};
use dcd_simd::{Block, Lanes, MAX_BLOCKS, WIDTH};

/// Where the parts of an object begin in a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Start {
    /// Its first part's record.
    pub(super) record: u32,
    /// Its first part's first block of vertices.
    pub(super) block: u32,
    /// Its first group of boxes.
    pub(super) group: u32,
}

/// The data of a scene's compounds' parts that the frame's own lists do not hold.
#[derive(Clone, Debug, Default)]
pub(super) struct Compounds {
    /// One for each object and one behind the last; none at all in a scene without compounds.
    starts: Vec<Start>,
    /// For each part the object that it is of, and its number in the compound.
    owners: Vec<(u32, u32)>,
    /// The parts' boxes in the world, sixteen a group, each group of one object.
    groups: Vec<Aabb16>,
    /// For each group the box round it.
    unions: Vec<Aabb>,
    /// For each object whether its parts' records are of a pose that is no rotation: see [`TURNED`].
    stretched: Vec<bool>,
}

/// The buffers for the parts of a range of objects.
#[derive(Debug, Default)]
pub(super) struct CompoundPart<'f> {
    /// One more than there are objects, or none.
    pub(super) starts: &'f [Start],
    pub(super) records: &'f mut [Record],
    pub(super) blocks: &'f mut [Block],
    pub(super) boxes: &'f mut [ObbRecord],
    groups: &'f mut [Aabb16],
    unions: &'f mut [Aabb],
    stretched: &'f mut [bool],
}

/// The parts of an object: their records follow each other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Members<'f> {
    pub(super) first: u32,
    pub(super) groups: &'f [Aabb16],
    pub(super) unions: &'f [Aabb],
}

impl Compounds {
    /// Extends the records and blocks behind the objects' own, and writes where each part's blocks are, or that it needs none:
    /// see [`Form::CuboidParts`](super::form::Form::CuboidParts).
    pub(super) fn set_offsets(
        &mut self,
        (scene, all_cores): (&Scene, &Cores),
        records: &mut Vec<Record>,
        (first, have_vertices): (u32, bool),
    ) {
        self.starts.clear();
        self.owners.clear();
        self.groups.clear();
        self.unions.clear();
        self.stretched.clear();
        let cores = all_cores.cores();
        let parts = |shape: u32| &cores[shape as usize];
        let count = |shape: &u32| parts(*shape).parts as usize;
        let all = records.len() + scene.shape_of().iter().map(count).sum::<usize>();
        // More than a u32 counts stay with the general search.
        if all == records.len() || u32::try_from(all).is_err() {
            return;
        }
        self.stretched.resize(scene.len(), false);
        let mut block = first;
        for (object, &shape) in (0..).zip(scene.shape_of()) {
            self.starts.push(self.end(records, block));
            let of = parts(shape);
            let own = &all_cores.parts()[of.first_part as usize..][..of.parts as usize];
            for part in own {
                self.owners.push((object, part.part));
                let (record, next) = match have_vertices {
                    true => laid_out(part, block),
                    false => (Record { first: block, marks: LIVE, ..Record::default() }, block),
                };
                records.push(place(&record, part, &Pose::IDENTITY));
                block = next;
            }
            let groups = self.groups.len() + (of.parts as usize).div_ceil(WIDTH);
            self.groups.resize(groups, Aabb16::EMPTY);
            self.unions.resize(groups, Aabb::EMPTY);
        }
        self.starts.push(self.end(records, block));
    }

    fn end(&self, records: &[Record], block: u32) -> Start {
        Start { record: records.len() as u32, block, group: self.groups.len() as u32 }
    }

    /// One past the last block.
    pub(super) fn blocks(&self) -> Option<u32> {
        self.starts.last().map(|end| end.block)
    }

    /// The buffers for all parts, of which these are the records, blocks and boxes.
    pub(super) fn compound_part<'f>(
        &'f mut self,
        records: &'f mut [Record],
        blocks: &'f mut [Block],
        boxes: &'f mut [ObbRecord],
    ) -> CompoundPart<'f> {
        let Self { starts, groups, unions, stretched, .. } = self;
        CompoundPart { starts, records, blocks, boxes, groups, unions, stretched }
    }

    /// The parts of an object, if it has some.
    #[inline(always)]
    pub(super) fn members(&self, object: u32) -> Option<Members<'_>> {
        let [start, end] = *self.starts.get(object as usize..)?.first_chunk()?;
        let groups = start.group as usize..end.group as usize;
        let members = Members {
            first: start.record,
            groups: self.groups.get(groups.clone())?,
            unions: self.unions.get(groups)?,
        };
        (start != end).then_some(members)
    }

    /// The object that a part is of, and its number in the compound; `None` of an object's own record.
    #[inline(always)]
    pub(super) fn owner_of(&self, record: u32) -> Option<(u32, u32)> {
        let number = record.checked_sub(self.starts.first()?.record)?;
        self.owners.get(number as usize).copied()
    }

    /// A part's place among those of the object that it is of.
    pub(super) fn place_of(&self, object: u32, record: u32) -> u32 {
        record - self.starts[object as usize].record
    }
}

/// A record whose vertices begin at that block, and the next one's first block. A shape with too many vertices
/// for the lanes gets no blocks: its pairs are resolved in f64.
pub(super) fn laid_out(core: &Core, first: u32) -> (Record, u32) {
    let next = first.saturating_add(core.blocks);
    let fits =
        next as usize <= MAX_BLOCKS && core.blocks <= u32::from(super::bounds::TAGGED_BLOCKS);
    let (blocks, next) = if fits { (core.blocks as u8, next) } else { (0, first) };
    (Record { first, blocks, ..Record::default() }, next)
}

impl<'f> CompoundPart<'f> {
    pub(super) fn split_at(self, middle: usize) -> (Self, Self) {
        let (Some(&base), Some(&cut)) = (self.starts.first(), self.starts.get(middle)) else {
            return (self, Self::default());
        };
        let (records, later_records) =
            self.records.split_at_mut((cut.record - base.record) as usize);
        let (blocks, later_blocks) = self.blocks.split_at_mut((cut.block - base.block) as usize);
        let boxes = records.len().min(self.boxes.len());
        let (boxes, later_boxes) = self.boxes.split_at_mut(boxes);
        let groups = (cut.group - base.group) as usize;
        let (groups, later_groups) = self.groups.split_at_mut(groups);
        let (unions, later_unions) = self.unions.split_at_mut(groups.len());
        let (stretched, later_stretched) = self.stretched.split_at_mut(middle);
        let starts = &self.starts[..=middle];
        (
            Self { starts, records, blocks, boxes, groups, unions, stretched },
            Self {
                starts: &self.starts[middle..],
                records: later_records,
                blocks: later_blocks,
                boxes: later_boxes,
                groups: later_groups,
                unions: later_unions,
                stretched: later_stretched,
            },
        )
    }

    /// Whether the range's `k`-th object has parts here.
    #[inline(always)]
    pub(super) fn holds(&self, k: usize) -> bool {
        self.starts.get(k + 1).is_some_and(|end| *end != self.starts[k])
    }

    /// Makes the parts of the range's `k`-th object ready, and returns the box round them.
    #[inline(always)]
    pub(super) fn prepare<L: Lanes>(
        &mut self,
        l: L,
        (k, whole): (usize, Whole<'_>),
        extremes: &mut Extremes,
    ) -> Aabb {
        let [base, start, end] = [self.starts[0], self.starts[k], self.starts[k + 1]];
        let mut part = (start.record - base.record) as usize;
        let last = (end.record - base.record) as usize;
        let mut blocks = &mut self.blocks[(start.block - base.block) as usize..];
        let is_turned = whole.pose.deviation() < TURNED;
        let was_stretched = std::mem::replace(&mut self.stretched[k], !is_turned);
        let rotation = Rotation::of(l, whole.pose);
        let records = self.records[part..last].chunks_mut(WIDTH);
        let mut core = whole.core.first_part as usize;
        let mut around = Aabb::EMPTY;
        let groups = (whole.core.first_group as usize..).zip((start.group - base.group) as usize..);
        for ((of_shape, group), records) in groups.zip(records) {
            let boxes = self.boxes.get_mut(part..).unwrap_or_default();
            if is_turned && was_stretched {
                whole.place(core, records);
            }
            let own = Own { rotation: &rotation, core, records, boxes, blocks };
            let (aabbs, others) = match is_turned {
                true => whole.turned(l, &whole.cores.groups().group(of_shape), own, extremes),
                false => whole.each(l, own, extremes),
            };
            (self.groups[group], blocks) = (aabbs, others);
            self.unions[group] = union(l, &aabbs);
            around = around.union(&self.unions[group]);
            core += WIDTH;
            part += WIDTH;
        }
        around
    }
}

/// Of one group of parts the first one's core and what is to be written, and all blocks from its first one on.
struct Own<'f, 'r, L: Lanes> {
    rotation: &'r Rotation<L>,
    core: usize,
    records: &'r mut [Record],
    boxes: &'r mut [ObbRecord],
    blocks: &'f mut [Block],
}

/// A compound at a pose.
#[derive(Clone, Copy)]
pub(super) struct Whole<'a> {
    pub(super) cores: &'a Cores,
    pub(super) core: &'a Core,
    pub(super) shape: &'a Shape,
    pub(super) pose: &'a Pose,
}

impl Whole<'_> {
    /// Prepares a group of parts at a pose that is a rotation, of which what such poses have in common is written. Returns the parts'
    /// AABBs, and the blocks that are left.
    #[inline(always)]
    fn turned<'f, L: Lanes>(
        &self,
        l: L,
        group: &PartGroup<'_>,
        own: Own<'f, '_, L>,
        extremes: &mut Extremes,
    ) -> (Aabb16, &'f mut [Block]) {
        let Own { rotation, core, records, boxes, mut blocks } = own;
        let placed = group.place(l, self.pose, records, boxes);
        // One each, or none.
        let of_all = records.iter().map(|record| usize::from(record.blocks)).sum::<usize>();
        if group.are_boxes() && (of_all == records.len() || of_all == 0) {
            let (own, others) = blocks.split_at_mut(of_all);
            for (local, own) in self.cores.all_blocks()[group.first_block()..].iter().zip(own) {
                rotation.turn(l, local, own);
            }
            return (placed.aabbs(l), others);
        }
        for (lane, record) in records.iter().enumerate() {
            let found = self.vertices(l, rotation, (core + lane, record), &mut blocks);
            extremes.keep(l, lane, found);
        }
        (self.aabbs(l, core, records, extremes), blocks)
    }

    /// [`Whole::turned`] at any pose: all is written, part by part.
    #[inline(always)]
    fn each<'f, L: Lanes>(
        &self,
        l: L,
        own: Own<'f, '_, L>,
        extremes: &mut Extremes,
    ) -> (Aabb16, &'f mut [Block]) {
        let Own { rotation, core, records, boxes, mut blocks } = own;
        self.place(core, records);
        for (lane, record) in records.iter().enumerate() {
            if let (true, Some(boxes)) = (record.marks & HAS_OBB != 0, boxes.get_mut(lane)) {
                *boxes = turn(&self.cores.part_obbs()[core + lane], record, self.pose);
            }
            let found = self.vertices(l, rotation, (core + lane, record), &mut blocks);
            extremes.keep(l, lane, found);
        }
        (self.aabbs(l, core, records, extremes), blocks)
    }

    /// Writes the records of parts from that core on.
    fn place(&self, core: usize, records: &mut [Record]) {
        for (record, core) in records.iter_mut().zip(&self.cores.parts()[core..]) {
            *record = place(record, core, self.pose);
        }
    }

    /// Writes the vertices of the part with that core into the first of the blocks, which then begin behind them, and returns how
    /// far it reaches.
    #[inline(always)]
    fn vertices<L: Lanes>(
        &self,
        l: L,
        rotation: &Rotation<L>,
        (core, record): (usize, &Record),
        blocks: &mut &mut [Block],
    ) -> [L::F; 6] {
        let (own, others) = std::mem::take(blocks).split_at_mut(usize::from(record.blocks));
        *blocks = others;
        let of = &self.cores.parts()[core];
        rotation.turn_all(l, &self.cores.blocks(of)[..own.len()], own)
    }

    /// The AABBs of parts from how far their vertices reach.
    #[inline(always)]
    fn aabbs<L: Lanes>(
        &self,
        l: L,
        core: usize,
        records: &[Record],
        extremes: &Extremes,
    ) -> Aabb16 {
        let reach = extremes.of_each(l);
        let mut aabbs = Aabb16::EMPTY;
        for (lane, record) in records.iter().enumerate() {
            let is_of_vertices = record.marks & WHOLE != 0 && record.blocks > 0;
            let aabb = match is_of_vertices {
                false => self.aabb_of(core + lane),
                true => boxed(record, &reach, lane),
            };
            aabbs.set(lane, &aabb);
        }
        aabbs
    }

    /// The box of the part with that core, from the part itself.
    fn aabb_of(&self, core: usize) -> Aabb {
        let part = self.cores.parts()[core].part;
        match self.shape {
            Shape::Compound(compound) => compound.parts()[part as usize].placed().aabb(self.pose),
            _ => Aabb::EVERYTHING,
        }
    }
}
