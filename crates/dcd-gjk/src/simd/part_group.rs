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

/// What does not depend on the pose, of a pose that departs from a rotation by less than [`TURNED`], coordinate by coordinate;
/// nothing past the last part.
#[derive(Clone, Debug, Default)]
pub(crate) struct PartGroup {
    /// How many parts there are.
    count: usize,
    /// Whether each is a cuboid of radius 0, to what f64 rounds.
    are_boxes: bool,
    /// How far the compound's parts reach: [`Core::reach`].
    reach: f64,
    /// [`Core::centre`].
    centres: Wide,
    /// [`ObbBoundsF32::axes`].
    edges: [Wide; 3],
    /// The last seven of an [`ObbRecord`]'s numbers.
    constants: [Row; 7],
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

impl PartGroup {
    /// Of parts with these cores and, where they have some, these boxes.
    pub(crate) fn of(cores: &[Core], obbs: &[ObbBoundsF32]) -> Self {
        let boxed = |core: &Core| (core.is_box || core.is_nearly_box) && core.radius == 0.0;
        let reach = cores.first().map_or(0.0, |core| core.reach);
        let are_boxes = cores.iter().all(boxed);
        let mut group = Self { count: cores.len(), are_boxes, reach, ..Self::default() };
        for (lane, core) in cores.iter().enumerate() {
            let (half, at) = (lane / HALF, lane % HALF);
            for (row, x) in group.centres[half].iter_mut().zip(core.centre.to_array()) {
                row[at] = x;
            }
            let Some(obb) = obbs.get(lane).filter(|_| core.has_obb) else { continue };
            for (edges, edge) in group.edges.iter_mut().zip(obb.axes) {
                for (row, x) in edges[half].iter_mut().zip(edge.as_dvec3().to_array()) {
                    row[at] = x;
                }
            }
            let record = place(&Record::default(), core, &Pose::IDENTITY);
            let numbers = turn(obb, &record, &Pose::IDENTITY).numbers.0;
            for (row, &x) in group.constants.iter_mut().zip(&numbers[9..]) {
                row.0[lane] = x;
            }
        }
        group
    }

    /// Whether the AABBs of all of them are known without their vertices: see [`PlacedGroup::aabbs`].
    #[inline(always)]
    pub(super) fn are_boxes(&self) -> bool {
        self.are_boxes
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
        let slack = slack(self.reach, pose, 1.0 + TURNED);
        let used = l.mask((1u32 << self.count) - 1);
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
        for (number, row) in numbers[9..].iter_mut().zip(&self.constants) {
            *number = l.load(row);
        }
        for (row, &number) in rows.iter_mut().zip(&numbers[..9]) {
            l.store(number, row);
        }
        rows[9..].copy_from_slice(&self.constants);
        for (boxes, numbers) in boxes.iter_mut().zip(l.transpose(&rows)).take(self.count) {
            l.store(numbers, &mut boxes.numbers);
        }
        PlacedGroup { centres: rounded, numbers, slack, used }
    }

    /// R·c + t of the parts' centres, and these rounded to f32.
    #[inline(always)]
    fn moved<L: Lanes>(&self, l: L, pose: &Pose) -> (Wide, [L::F; 3]) {
        let mut moved = Wide::default();
        let translation = pose.translation().to_array();
        for (moved, centres) in moved.iter_mut().zip(&self.centres).take(self.halves()) {
            let turned = turned(l, pose, centres);
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
        for (wide, edges) in wide.iter_mut().zip(&self.edges[edge]).take(self.halves()) {
            let turned = turned(l, pose, edges);
            for axis in 0..3 {
                l.store_d(turned[axis], &mut wide[axis]);
            }
        }
        rounded(l, &wide)
    }

    /// How many halves of the lanes hold parts.
    #[inline(always)]
    fn halves(&self) -> usize {
        self.count.div_ceil(HALF)
    }
}

/// Three coordinates of sixteen vectors in f64, by halves of the lanes.
type Wide = [[[f64; HALF]; 3]; 2];

#[inline(always)]
fn rounded<L: Lanes>(l: L, [low, high]: &Wide) -> [L::F; 3] {
    let [x, y, z] = low;
    [l.round_from([x, &high[0]]), l.round_from([y, &high[1]]), l.round_from([z, &high[2]])]
}

/// R·v of half of the vectors, summed as a matrix and one vector are.
#[inline(always)]
fn turned<L: Lanes>(l: L, pose: &Pose, [x, y, z]: &[[f64; HALF]; 3]) -> [L::D; 3] {
    let [x, y, z] = [l.load_d(x), l.load_d(y), l.load_d(z)];
    let columns = pose.rotation().to_cols_array_2d();
    let mut turned = [x, y, z];
    for (axis, along) in turned.iter_mut().enumerate() {
        let [a, b, c] = [columns[0][axis], columns[1][axis], columns[2][axis]];
        let sum = l.add_d(l.mul_d(l.splat_d(a), x), l.mul_d(l.splat_d(b), y));
        *along = l.add_d(sum, l.mul_d(l.splat_d(c), z));
    }
    turned
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
