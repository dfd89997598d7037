//! What is prepared of every object once a step.

use super::axis_aligned::AxisAligned;
use super::compounds::{CompoundPart, Compounds, Members, laid_out};
use super::cores::{Core, Cores};
use super::form::{Form, Purpose};
use super::prepare::constants;
use crate::Sides;
use crate::closed::PlacedSphere;
use crate::narrow_phase::PAIRS_WORTH_A_TASK;
use dcd_geom::glam::DVec3;
use dcd_geom::{Pair, Revision, Scene, Shape, Splittable};
use dcd_simd::{Block, Lanes, Row, WIDTH, prefetch};

/// All objects, ready for the lanes.
#[derive(Clone, Debug, Default)]
pub struct SimdFrame {
    /// Of the scene's shapes.
    cores: Cores,
    form: Form,
    /// Whether some record is marked as [`STRAIGHT_CORE`].
    has_straight_cores: bool,
    /// Whether some object is a mesh or a compound.
    has_parts: bool,
    /// How many objects there are. Behind them in the lists are the parts of compounds.
    objects: usize,
    records: Vec<Record>,
    blocks: Vec<Block>,
    /// One for each record; none at all where no shape of the scene has boxes.
    boxes: Vec<ObbRecord>,
    /// One for each object; none at all where no shape of the scene is a cuboid.
    uprights: Vec<AxisAligned>,
    compounds: Compounds,
    /// What the offsets are for.
    layout: Option<(Revision, Sides, Purpose)>,
    /// Lent to the first part that has an object.
    extremes: Box<Extremes>,
}

/// The largest x, y, z and the largest −x, −y, −z of sixteen objects, lane by lane, on their way to
/// the boxes. To clear it takes as long as to prepare several objects.
#[derive(Clone, Debug, Default)]
pub(super) struct Extremes([[Row; WIDTH]; 6]);

impl Extremes {
    /// Takes in those of one object's vertices, lane by lane.
    #[inline(always)]
    pub(super) fn keep<L: Lanes>(&mut self, l: L, object: usize, found: [L::F; 6]) {
        let Self(rows) = self;
        for side in 0..6 {
            l.store(found[side], &mut rows[side][object]);
        }
    }

    /// How far each of the sixteen objects reaches, to six sides.
    #[inline(always)]
    pub(super) fn of_each<L: Lanes>(&self, l: L) -> [Row; 6] {
        let Self(rows) = self;
        let mut reach = [Row::default(); 6];
        for side in 0..6 {
            l.store(l.largest_of_each(&rows[side]), &mut reach[side]);
        }
        reach
    }
}

/// A record's mark that its [`ObbRecord`] is valid.
pub(super) const HAS_OBB: u8 = 1;
/// A record's mark that the lanes can resolve pairs of it: it has vertices, or needs none.
pub(super) const LIVE: u8 = 2;

/// A record's mark that its [`AxisAligned`] is valid.
pub(super) const AXIS_ALIGNED: u8 = 4;

/// A record's mark that its vertices are all of it, and not those of a hull inside it; or that it
/// needs none.
pub(super) const WHOLE: u8 = 8;
/// A record's mark that its boxes are the object itself.
pub(super) const BOX: u8 = 16;
/// A record's mark that it is a sphere: its centre is exact, and the fourth number of it the radius.
pub(super) const SPHERE: u8 = 32;
/// A record's mark that it has vertices, and its core is a point or the segment between the first of them and that seen through
/// the centre.
pub(super) const STRAIGHT_CORE: u8 = 64;

/// A record's mark that it is a part whose boxes are a cuboid as it was given, and it is that but for what f64 rounds.
pub(super) const NEARLY_BOX: u8 = 128;

/// One object on one cache line. The radii include what the pose's matrix departs from a rotation
/// by, and are rounded to the safe side.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub(super) struct Record {
    /// Where the shape's centre is in the world, metres, up to `slack` a component. The fourth number lets two centres be
    /// subtracted as one vector; of a [`SPHERE`] it is the radius, and the centre is exact.
    pub(super) centre: [f64; 4],
    /// The object's first block in the frame.
    pub(super) first: u32,
    /// The lowest bits of a value that carry its vertex's number: see [`super::support`].
    pub(super) tag: u16,
    /// How many blocks it has; 0 where the lanes do not know the shape, or the scene is of a form
    /// without vertices.
    pub(super) blocks: u8,
    /// [`HAS_OBB`], [`LIVE`], [`AXIS_ALIGNED`], [`WHOLE`], [`BOX`], [`SPHERE`], [`STRAIGHT_CORE`] and [`NEARLY_BOX`], each or
    /// not.
    pub(super) marks: u8,
    /// A sphere round the centre inside the object, its swept radius included: rounded down.
    pub(super) inner: f32,
    /// A sphere round the centre that holds the object, its swept radius included: rounded up.
    pub(super) outer: f32,
    /// κ·r: a sphere round the centre that holds the core, rounded up.
    pub(super) size: f32,
    /// The swept radius, rounded up.
    pub(super) radius: f32,
    /// See [`super::bounds::CENTRE`], metres, rounded up.
    pub(super) slack: f32,
    /// By how much the vertex that is returned as the farthest may be nearer than another, or than
    /// what the object has beyond its vertices, rounded up. Unit: metres a metre of the direction's
    /// 1-norm.
    pub(super) choice: f32,
}

/// Of a [`SPHERE`] its centre and its radius.
impl AsRef<[f64; 4]> for Record {
    #[inline(always)]
    fn as_ref(&self) -> &[f64; 4] {
        &self.centre
    }
}

/// An object's boxes on one cache line: the inner and outer OBBs of its shape, turned, round the record's
/// centre.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ObbRecord {
    /// Three directions of edges in the world; half the edges of a box that holds the object, its
    /// swept radius included, rounded up; and of one inside it, rounded down. The sixteenth number says how a cuboid's half
    /// edges compare.
    pub(super) numbers: Row,
}

impl ObbRecord {
    /// That of an object of which nothing is known to be inside, as of a mesh: no axis finds it to overlap another.
    #[inline(always)]
    pub(super) fn hold_nothing(&mut self) {
        self.numbers.0[12..15].fill(f32::NEG_INFINITY);
    }
}

/// How many pairs are worth a task where some object has parts: each pair of them takes as long as many of others.
const FEWEST_OF_PARTS: usize = 128;

/// Frames with at most this many bytes of vertices are not prefetched: what stays in the second cache while other work runs
/// between two steps. Larger: scenes that come back to cold caches wait for memory, 10,000 hulls a seventh of their time.
/// Smaller: small ones spend a tenth of their time on hints.
const NEAR: usize = 2 << 20;

/// The same of records and boxes, where pairs read no vertices. Larger: 10,000 cuboids wait a quarter of their time. Smaller: as many
/// spheres spend that on hints.
const NEAR_RECORDS: usize = 1 << 20;

/// The frames of both objects of a pair: the first one's and the second one's, which may be one frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FramePair<'a> {
    pub(crate) a: &'a SimdFrame,
    pub(crate) b: &'a SimdFrame,
}

impl<'a> FramePair<'a> {
    /// Of a scene against itself.
    #[cfg(test)]
    pub(crate) fn of_one(frame: &'a SimdFrame) -> Self {
        Self { a: frame, b: frame }
    }

    /// Two spheres, exactly as they are placed; `None` of other objects.
    #[inline(always)]
    pub(super) fn spheres(self, pair: Pair) -> Option<[PlacedSphere; 2]> {
        spheres_of([&self.a.records, &self.b.records], pair)
    }

    pub(super) fn is_one(self) -> bool {
        std::ptr::eq(self.a, self.b)
    }

    /// Whether polytopes have their vertices: if not, no stage evaluates supports.
    #[inline(always)]
    pub(super) fn have_vertices(self) -> bool {
        self.a.has_vertices() && self.b.has_vertices()
    }

    /// Whether all objects are spheres.
    #[inline(always)]
    pub(super) fn are_spheres(self) -> bool {
        self.a.form == Form::Spheres && self.b.form == Form::Spheres
    }

    /// Whether a near cache holds all that pairs read: then prefetching costs more than it
    /// hides.
    #[inline(always)]
    pub(super) fn are_near(self) -> bool {
        self.a.is_near() && self.b.is_near()
    }

    /// Whether any object is marked as [`STRAIGHT_CORE`].
    #[inline(always)]
    pub(super) fn have_straight_cores(self) -> bool {
        self.a.has_straight_cores || self.b.has_straight_cores
    }

    /// Whether any object is made of parts.
    #[inline(always)]
    pub(super) fn have_parts(self) -> bool {
        self.a.has_parts || self.b.has_parts
    }

    /// Whether the lanes know the parts of any object.
    pub(super) fn have_compounds(self) -> bool {
        self.a.has_compounds() || self.b.has_compounds()
    }
}

/// [`FramePair::spheres`] of the records of both frames.
#[inline(always)]
pub(super) fn spheres_of([a, b]: [&[Record]; 2], pair: Pair) -> Option<[PlacedSphere; 2]> {
    let (a, b) = (&a[pair.i as usize], &b[pair.j as usize]);
    let sphere = |&Record { centre: [x, y, z, radius], .. }: &Record| PlacedSphere {
        centre: DVec3::new(x, y, z),
        radius,
    };
    (a.marks & b.marks & SPHERE != 0).then(|| [sphere(a), sphere(b)])
}

/// The frame's buffers for a range of the objects.
#[derive(Debug)]
pub struct Part<'f> {
    /// Whether the frame's lists are those of the layout before, so that they hold what they held.
    pub(crate) kept: bool,
    pub(crate) cores: &'f Cores,
    pub(super) form: Form,
    pub(super) records: &'f mut [Record],
    pub(super) blocks: &'f mut [Block],
    pub(super) boxes: &'f mut [ObbRecord],
    pub(super) uprights: &'f mut [AxisAligned],
    pub(super) compound_part: CompoundPart<'f>,
    /// Scratch memory that need not be cleared; a part without makes its own.
    pub(super) extremes: Option<&'f mut Extremes>,
}

impl SimdFrame {
    /// Assigns offsets only; does nothing where the scene's layout and the sides are those of the
    /// last step.
    pub(crate) fn layout(&mut self, scene: &Scene, sides: Sides, purpose: Purpose) -> Part<'_> {
        let layout = Some((scene.layout(), sides, purpose));
        let kept = self.layout == layout;
        if !kept {
            self.set_offsets(scene, sides, purpose);
            self.layout = layout;
        }
        let Self { cores, form, records, blocks, boxes, uprights, compounds, extremes, .. } = self;
        let (records, of_parts) = records.split_at_mut(self.objects);
        let own = match of_parts.first() {
            Some(part) => part.first as usize,
            None => blocks.len(),
        };
        let (blocks, blocks_of_parts) = blocks.split_at_mut(own);
        let own = records.len().min(boxes.len());
        let (boxes, boxes_of_parts) = boxes.split_at_mut(own);
        let compound_part = compounds.compound_part(of_parts, blocks_of_parts, boxes_of_parts);
        let form = *form;
        Part {
            kept,
            cores,
            form,
            records,
            blocks,
            boxes,
            uprights,
            compound_part,
            extremes: Some(extremes),
        }
    }

    fn set_offsets(&mut self, scene: &Scene, sides: Sides, purpose: Purpose) {
        self.cores.follow(scene);
        let (cores, parts) = (self.cores.cores(), self.cores.parts());
        self.form = match sides {
            Sides::One => Form::of(scene.shapes(), &self.cores, purpose),
            Sides::Two => Form::Any,
        };
        let mut all = cores.iter().chain(parts);
        self.has_straight_cores = self.form == Form::Any && all.any(|core| core.is_straight);
        let has_parts = |shape: &Shape| matches!(shape, Shape::Mesh(_) | Shape::Compound(_));
        self.has_parts = scene.shapes().iter().any(has_parts);
        self.objects = scene.len();
        self.records.resize(scene.len(), Record::default());
        let may_stand = cores.iter().chain(parts).any(|core| core.is_box);
        self.uprights.resize(if may_stand { scene.len() } else { 0 }, AxisAligned::default());
        let mut first = 0u32;
        let have_blocks = matches!(self.form, Form::Any | Form::CuboidParts);
        if have_blocks {
            for (record, &shape) in self.records.iter_mut().zip(scene.shape_of()) {
                (*record, first) = laid_out(&cores[shape as usize], first);
            }
        }
        let has_vertices = self.has_vertices();
        self.compounds.set_offsets((scene, &self.cores), &mut self.records, (first, has_vertices));
        let boxed = self.cores.have_obbs();
        self.boxes.resize(if boxed { self.records.len() } else { 0 }, ObbRecord::default());
        let blocks = self.compounds.blocks().unwrap_or(first);
        self.blocks.resize(blocks as usize, Block::default());
        if !have_blocks {
            constants(scene, &self.cores, &mut self.records, &mut self.boxes);
        }
    }

    /// How many pairs take some tens of microseconds at least to decide.
    pub(crate) fn fewest_pairs(&self) -> usize {
        if self.has_parts { FEWEST_OF_PARTS } else { PAIRS_WORTH_A_TASK }
    }

    fn has_compounds(&self) -> bool {
        self.records.len() > self.objects
    }

    pub(super) fn cores(&self) -> &Cores {
        &self.cores
    }

    /// The parts of a compound that the lanes know.
    #[inline(always)]
    pub(super) fn members(&self, object: u32) -> Option<Members<'_>> {
        self.compounds.members(object)
    }

    /// Whether the lanes know an object as one.
    #[inline(always)]
    pub(super) fn is_live(&self, object: u32) -> bool {
        self.record(object).marks & LIVE != 0
    }

    /// The object that a part is of, and its number in the compound; `None` of an object's own record.
    #[inline(always)]
    pub(super) fn owner_of(&self, record: u32) -> Option<(u32, u32)> {
        self.compounds.owner_of(record)
    }

    /// The core of an object or of a part.
    #[inline(always)]
    pub(super) fn core_of(&self, scene: &Scene, record: u32) -> &Core {
        let whole = |object: u32| &self.cores.cores()[scene.shape_index(object as usize) as usize];
        match self.owner_of(record) {
            Some((object, _)) => {
                let place = self.compounds.place_of(object, record);
                &self.cores.parts()[(whole(object).first_part + place) as usize]
            }
            None => whole(record),
        }
    }

    #[inline(always)]
    pub(super) fn records(&self) -> &[Record] {
        &self.records
    }

    #[inline(always)]
    pub(super) fn record(&self, object: u32) -> &Record {
        &self.records[object as usize]
    }

    #[inline(always)]
    pub(super) fn blocks_of(&self, record: &Record) -> &[Block] {
        &self.blocks[record.first as usize..][..usize::from(record.blocks)]
    }

    #[inline(always)]
    pub(super) fn has_vertices(&self) -> bool {
        self.form == Form::Any
    }

    #[inline(always)]
    fn is_near(&self) -> bool {
        match self.form {
            Form::Any => size_of_val(&*self.blocks) <= NEAR,
            Form::Spheres | Form::Cuboids | Form::CuboidParts => {
                size_of_val(&*self.records) + size_of_val(&*self.boxes) <= NEAR_RECORDS
            }
        }
    }

    /// Prefetches all that pairs of an object without vertices read.
    #[inline(always)]
    pub(super) fn prefetch(&self, object: u32) {
        prefetch(std::slice::from_ref(self.record(object)));
        if let Some(boxes) = self.boxes.get(object as usize) {
            prefetch(std::slice::from_ref(boxes));
        }
    }

    /// The boxes of an object that has some.
    #[inline(always)]
    pub(super) fn boxes(&self, object: u32) -> &ObbRecord {
        &self.boxes[object as usize]
    }

    /// Half the edges along the world's axes of a cuboid that stands along them.
    pub(super) fn upright(&self, object: u32) -> &AxisAligned {
        &self.uprights[object as usize]
    }

    /// All objects' vertices.
    #[inline(always)]
    pub(super) fn blocks(&self) -> &[Block] {
        &self.blocks
    }
}

impl Splittable for Part<'_> {
    fn len(&self) -> usize {
        self.records.len()
    }

    fn split_at(self, middle: usize) -> (Self, Self) {
        let base = self.records.first().map_or(0, |record| record.first);
        let blocks = match self.records.get(middle) {
            Some(record) => (record.first - base) as usize,
            None => self.blocks.len(),
        };
        let (kept, cores, form) = (self.kept, self.cores, self.form);
        let (left_compounds, right_compounds) = self.compound_part.split_at(middle);
        let (left, right) = self.records.split_at_mut(middle);
        let (left_blocks, right_blocks) = self.blocks.split_at_mut(blocks);
        let (left_boxes, right_boxes) = self.boxes.split_at_mut(middle.min(self.boxes.len()));
        let (left_uprights, right_uprights) =
            self.uprights.split_at_mut(middle.min(self.uprights.len()));
        let (lent, none) = (self.extremes, None);
        let (left_lent, right_lent) = if middle > 0 { (lent, none) } else { (none, lent) };
        (
            Self {
                kept,
                cores,
                form,
                records: left,
                blocks: left_blocks,
                boxes: left_boxes,
                uprights: left_uprights,
                compound_part: left_compounds,
                extremes: left_lent,
            },
            Self {
                kept,
                cores,
                form,
                records: right,
                blocks: right_blocks,
                boxes: right_boxes,
                uprights: right_uprights,
                compound_part: right_compounds,
                extremes: right_lent,
            },
        )
    }
}
