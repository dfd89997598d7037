//! Up to sixteen parts of a compound side by side: all of them have one pose, so that their centres, their OBBs and the AABBs of
//! cuboids are found in lanes.

#[cfg(test)]
mod tests;

use super::bounds::{TURNED, U};
use super::cores::{Core, ObbBoundsF32};
use super::frame::{ObbRecord, Record};
use super::prepare::{place, slack, turn};
use dcd_geom::{Aabb, Aabb16, Pose};
use dcd_simd::{Lanes, Row, WIDTH};

/// Half of the lanes, which f64 lanes have.
const HALF: usize = WIDTH / 2;

/// What does not depend on the pose, of poses that depart from a rotation by less than [`TURNED`], of all groups.
///
/// Coordinate by coordinate, each of as many numbers as the group has parts: what is loaded past them is of no lane that is used.
#[derive(Clone, Debug, Default)]
pub(crate) struct PartGroups {
    groups: Vec<Header>,
    /// Of each group the three coordinates of [`Core::centre`], then the nine of [`ObbBoundsF32::axes`].
    wide: Vec<f64>,
    /// Of each group the last seven of an [`ObbRecord`]'s numbers.
    narrow: Vec<f32>,
}

/// How many numbers of a part are f64.
const WIDE: usize = 12;

/// How many are f32.
const NARROW: usize = 7;

/// What is known of a group beside the numbers of its parts.
#[derive(Clone, Copy, Debug)]
struct Header {
    /// How many parts the groups before it have.
    before: usize,
    /// How many there are in it.
    count: usize,
    /// Whether each is a cuboid of radius 0, to what f64 rounds.
    are_boxes: bool,
    /// How far the compound's parts reach: [`Core::reach`].
    reach: f64,
    /// The first block of the first one: those of the others follow.
    first_block: u32,
}

/// One group.
#[derive(Clone, Copy)]
pub(super) struct PartGroup<'a> {
    header: &'a Header,
    /// From its own numbers on.
    wide: &'a [f64],
    narrow: &'a [f32],
}

impl PartGroups {
    /// How many groups there are.
    pub(crate) fn len(&self) -> usize {
        self.groups.len()
    }

    /// Adds a group of parts with these cores and, where they have some, these boxes.
    pub(crate) fn push(&mut self, cores: &[Core], obbs: &[ObbBoundsF32]) {
        let boxed = |core: &Core| (core.is_box || core.is_nearly_box) && core.radius == 0.0;
        let before = self.groups.last().map_or(0, |last| last.before + last.count);
        let (reach, first_block) = cores.first().map_or((0.0, 0), |core| (core.reach, core.first));
        let (count, are_boxes) = (cores.len(), cores.iter().all(boxed));
        self.groups.push(Header { before, count, are_boxes, reach, first_block });
        // Behind the last group's are as many as the lanes load from its last number on.
        self.wide.resize(WIDE * (before + count) + HALF, 0.0);
        self.narrow.resize(NARROW * (before + count) + WIDTH, 0.0);
        let (wide, narrow) = (&mut self.wide[WIDE * before..], &mut self.narrow[NARROW * before..]);
        for (part, core) in cores.iter().enumerate() {
            for (row, x) in core.centre.to_array().into_iter().enumerate() {
                wide[row * count + part] = x;
            }
            let Some(obb) = obbs.get(part).filter(|_| core.has_obb) else { continue };
            let axes = obb.axes.iter().flat_map(|axis| axis.as_dvec3().to_array());
            for (row, x) in (3..).zip(axes) {
                wide[row * count + part] = x;
            }
            let record = place(&Record::default(), core, &Pose::IDENTITY);
            let numbers = turn(obb, &record, &Pose::IDENTITY).numbers.0;
            for (row, &x) in numbers[9..].iter().enumerate() {
                narrow[row * count + part] = x;
            }
        }
    }

    /// The group with that number, which there must be.
    #[inline(always)]
    pub(super) fn group(&self, number: usize) -> PartGroup<'_> {
        let header = &self.groups[number];
        let (wide, narrow) =
            (&self.wide[WIDE * header.before..], &self.narrow[NARROW * header.before..]);
        PartGroup { header, wide, narrow }
    }
}

/// Where a group of parts is.
pub(super) struct PlacedGroup<L: Lanes> {
    /// The components of their centres, rounded to f32.
    centres: [L::F; 3],
    /// The first twelve of each one's [`ObbRecord`]: its axes, and half the edges of the box round it.
    numbers: [L::F; 12],
    slack: f32,
    /// The lanes that hold a part.
    used: L::M,
}

impl PartGroup<'_> {
    /// Whether the AABBs of all of them are known without their vertices: see [`PlacedGroup::aabbs`].
    #[inline(always)]
    pub(super) fn are_boxes(&self) -> bool {
        self.header.are_boxes
    }

    /// The first block of the first part's vertices: those of the others follow.
    #[inline(always)]
    pub(super) fn first_block(&self) -> usize {
        self.header.first_block as usize
    }

    /// Writes what depends on the pose, which departs from a rotation by less than [`TURNED`]: where the parts are, as [`place`]
    /// does, and how their boxes are turned, as [`turn`] does, bit for bit. All else in the records is there already.
    #[inline(always)]
    pub(super) fn place<L: Lanes>(
        &self,
        l: L,
        pose: &Pose,
        records: &mut [Record],
        boxes: &mut [ObbRecord],
    ) -> PlacedGroup<L> {
        let slack = slack(self.header.reach, pose, 1.0 + TURNED);
        let used = l.mask((1u32 << self.header.count) - 1);
        let (centres, rounded) = self.moved(l, pose);
        for ([x, y, z], records) in centres.iter().zip(records.chunks_mut(HALF)) {
            for (record, ((&x, &y), &z)) in records.iter_mut().zip(x.iter().zip(y).zip(z)) {
                record.centre[..3].copy_from_slice(&[x, y, z]);
                record.slack = slack;
            }
        }
        let mut rows = [Row::default(); WIDTH];
        let mut numbers = [l.splat(0.0); 12];
        for edge in 0..3 {
            let turned = self.turned(l, pose, edge);
            numbers[3 * edge..][..3].copy_from_slice(&turned);
        }
        for (row, &number) in rows.iter_mut().zip(&numbers[..9]) {
            l.store(number, row);
        }
        for (number, row) in rows[9..].iter_mut().enumerate() {
            let constants = self.constants(l, number);
            l.store(constants, row);
            if let Some(half_edge) = numbers.get_mut(9 + number) {
                *half_edge = constants;
            }
        }
        for (boxes, numbers) in boxes.iter_mut().zip(l.transpose(&rows)).take(self.header.count) {
            l.store(numbers, &mut boxes.numbers);
        }
        PlacedGroup { centres: rounded, numbers, slack, used }
    }

    /// R·c + t of the parts' centres, and these rounded to f32.
    #[inline(always)]
    fn moved<L: Lanes>(&self, l: L, pose: &Pose) -> (Wide, [L::F; 3]) {
        let mut moved = Wide::default();
        let translation = pose.translation().to_array();
        for (half, moved) in moved.iter_mut().enumerate().take(self.halves()) {
            let turned = self.turned_half(l, pose, (0, half));
            for axis in 0..3 {
                let centre = l.add_d(turned[axis], l.splat_d(translation[axis]));
                l.store_d(centre, &mut moved[axis]);
            }
        }
        (moved, rounded(l, &moved))
    }

    /// R·e of the parts' edges with that number, rounded to f32.
    #[inline(always)]
    fn turned<L: Lanes>(&self, l: L, pose: &Pose, edge: usize) -> [L::F; 3] {
        let mut wide = Wide::default();
        for (half, wide) in wide.iter_mut().enumerate().take(self.halves()) {
            let turned = self.turned_half(l, pose, (3 + 3 * edge, half));
            for axis in 0..3 {
                l.store_d(turned[axis], &mut wide[axis]);
            }
        }
        rounded(l, &wide)
    }

    /// R·v of half of the vectors whose coordinates begin with that one, summed as a matrix and one vector are.
    #[inline(always)]
    fn turned_half<L: Lanes>(&self, l: L, pose: &Pose, (row, half): (usize, usize)) -> [L::D; 3] {
        let mut vector = [l.splat_d(0.0); 3];
        for (row, coordinate) in (row..).zip(&mut vector) {
            let at = row * self.header.count + half * HALF;
            if let Some(numbers) = self.wide[at..].first_chunk() {
                *coordinate = l.load_d(numbers);
            }
        }
        let [x, y, z] = vector;
        let columns = pose.rotation().to_cols_array_2d();
        for (axis, along) in vector.iter_mut().enumerate() {
            let [a, b, c] = [columns[0][axis], columns[1][axis], columns[2][axis]];
            let sum = l.add_d(l.mul_d(l.splat_d(a), x), l.mul_d(l.splat_d(b), y));
            *along = l.add_d(sum, l.mul_d(l.splat_d(c), z));
        }
        vector
    }

    /// The constants with that number.
    #[inline(always)]
    fn constants<L: Lanes>(&self, l: L, row: usize) -> L::F {
        let numbers = self.narrow[row * self.header.count..].first_chunk();
        numbers.map_or(l.splat(0.0), |numbers| l.load_from(numbers))
    }

    /// How many halves of the lanes hold parts.
    #[inline(always)]
    fn halves(&self) -> usize {
        self.header.count.div_ceil(HALF)
    }
}

/// Three coordinates of sixteen vectors in f64, by halves of the lanes.
type Wide = [[[f64; HALF]; 3]; 2];

#[inline(always)]
fn rounded<L: Lanes>(l: L, [low, high]: &Wide) -> [L::F; 3] {
    let [x, y, z] = low;
    [l.round_from([x, &high[0]]), l.round_from([y, &high[1]]), l.round_from([z, &high[2]])]
}

/// How far the reach of an OBB, from its axes in f32, may be off: 3u a component of an axis, for the part's axes, their
/// rotation and the matrix, 3u for the products and their sum, 3u for what is added to it. Unit: u of the sum of half its edges.
/// Smaller: parts whose AABBs do not hold them.
const REACH: f32 = 16.0;

/// The same of a centre: u for rounding it, u for the side of the box. Unit: u of its coordinate.
const ROUNDED_CENTRE: f32 = 4.0;

impl<L: Lanes> PlacedGroup<L> {
    /// The AABBs of the OBBs round the parts, sixteen at a time; empty past the last.
    #[inline(always)]
    pub(super) fn aabbs(&self, l: L) -> Aabb16 {
        let Self { centres, numbers, slack, used } = self;
        let [outer_x, outer_y, outer_z] = [numbers[9], numbers[10], numbers[11]];
        let sum = l.add(l.add(outer_x, outer_y), outer_z);
        let pad = l.add(l.mul(sum, l.splat(REACH * U)), l.splat(*slack));
        let (none, least) = (l.splat(f32::INFINITY), l.splat(f32::NEG_INFINITY));
        let mut aabbs = Aabb16::EMPTY;
        for axis in 0..3 {
            let [x, y, z] = [numbers[axis], numbers[3 + axis], numbers[6 + axis]];
            let (x, y) = (l.mul(l.abs(x), outer_x), l.mul(l.abs(y), outer_y));
            let reach = l.add(l.add(x, y), l.mul(l.abs(z), outer_z));
            let centre = centres[axis];
            let rounding = l.mul(l.abs(centre), l.splat(ROUNDED_CENTRE * U));
            let reach = l.add(reach, l.add(pad, rounding));
            l.store(l.select(*used, l.sub(centre, reach), none), &mut aabbs.min[axis]);
            l.store(l.select(*used, l.add(centre, reach), least), &mut aabbs.max[axis]);
        }
        aabbs
    }
}

/// [`Aabb16::union`] in lanes; without a negative 0, which would depend on the order of the lanes.
#[inline(always)]
pub(super) fn union<L: Lanes>(l: L, aabbs: &Aabb16) -> Aabb {
    let mut ends = [0.0; 6];
    for axis in 0..3 {
        ends[axis] = 0.0 - l.largest(l.neg(l.load(&aabbs.min[axis])));
        ends[3 + axis] = l.largest(l.load(&aabbs.max[axis])) + 0.0;
    }
    let [x, y, z, max @ ..] = ends;
    Aabb { min: [x, y, z].into(), max: max.into() }
}
