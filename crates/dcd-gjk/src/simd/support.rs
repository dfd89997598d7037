//! The support of sixteen objects in sixteen directions.

use super::frame::SimdFrame;
use super::vector::V3;
use dcd_simd::{IndexRow, Kernel, Lanes, Row, WIDTH};

/// What [`supports`] writes on its way; kept, so that it need not be cleared.
#[derive(Clone, Debug, Default)]
pub(super) struct SupportScratch {
    /// For each lane its vertices' values along its direction, tagged, block upon block.
    along: [Row; WIDTH],
    /// Each lane's first block in the frame.
    first: IndexRow,
    /// The mask of the bits that carry a vertex's number.
    tag: IndexRow,
    /// What was found.
    points: [Row; 3],
    numbers: IndexRow,
}

/// For each of the first `used` lanes, a farthest rotated vertex of that lane's object along its
/// direction, up to rounding and to the bits that carry the vertex's number, and that number; other lanes
/// are unspecified.
///
/// The number travels in the value's own lowest bits, so that the largest of all brings it along.
#[inline(always)]
pub(super) fn supports<L: Lanes>(
    l: L,
    frame: &SimdFrame,
    support_scratch: &mut SupportScratch,
    (objects, directions): (&IndexRow, V3<L>),
    used: usize,
) -> (V3<L>, L::U) {
    let mut d = [Row::default(); 3];
    // Without a zero below 0, by which alone those of (a, b) and (b, a) may differ: vertices at right angles to one, as of
    // a segment or a plate, are then as far in both orders, and the same is chosen.
    let zero = l.splat(0.0);
    V3(zero, zero, zero).add(l, directions).store(l, &mut d);
    l.call(Supports {
        frame,
        support_scratch: &mut *support_scratch,
        objects,
        directions: &d,
        used,
    });
    (V3::load(l, &support_scratch.points), l.load_u(&support_scratch.numbers))
}

/// For each of the first `used` lanes, how far that lane's object reaches along its direction, of its rotated vertices, up to
/// rounding alone; other lanes are unspecified.
#[inline(always)]
pub(super) fn reaches<L: Lanes>(
    l: L,
    frame: &SimdFrame,
    support_scratch: &mut SupportScratch,
    (objects, directions): (&IndexRow, V3<L>),
    used: usize,
) -> L::F {
    let mut d = [Row::default(); 3];
    directions.store(l, &mut d);
    let (records, all) = (frame.records(), frame.blocks());
    for k in 0..used.min(WIDTH) {
        let record = &records[objects.0[k] as usize];
        let d = V3::<L>(l.splat(d[0].0[k]), l.splat(d[1].0[k]), l.splat(d[2].0[k]));
        let own = &all[record.first as usize..][..usize::from(record.blocks)];
        let Some((block, rest)) = own.split_first() else { continue };
        let mut best = V3::load(l, &block.0).dot(l, d);
        for block in rest {
            best = l.max(best, V3::load(l, &block.0).dot(l, d));
        }
        l.store(best, &mut support_scratch.along[k]);
    }
    l.largest_of_each(&support_scratch.along)
}

/// [`supports`], compiled once a path: every stage needs it, and it is most of what a stage would take to compile.
struct Supports<'a> {
    frame: &'a SimdFrame,
    support_scratch: &'a mut SupportScratch,
    objects: &'a IndexRow,
    directions: &'a [Row; 3],
    used: usize,
}

impl Kernel for Supports<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        let Self { frame, support_scratch, objects, directions: d, used } = self;
        let numbers = l.lane_numbers();
        let (records, blocks) = (frame.records(), frame.blocks());
        for k in 0..used.min(WIDTH) {
            let record = &records[objects.0[k] as usize];
            support_scratch.first.0[k] = record.first;
            support_scratch.tag.0[k] = record.tag.into();
            let d = V3::<L>(l.splat(d[0].0[k]), l.splat(d[1].0[k]), l.splat(d[2].0[k]));
            let tag = l.splat_u(record.tag.into());
            let own = &blocks[record.first as usize..][..usize::from(record.blocks)];
            let Some((block, rest)) = own.split_first() else { continue };
            let mut best = l.tag(V3::load(l, &block.0).dot(l, d), tag, numbers);
            if rest.len() < 2 {
                // Whether a small hull has one block or two is not predicted: of one the first is looked at again.
                let second = rest.len();
                let numbers = l.add_u(numbers, l.splat_u((second * WIDTH) as u32));
                best = l.max(best, l.tag(V3::load(l, &own[second].0).dot(l, d), tag, numbers));
            } else {
                let mut numbers = numbers;
                for block in rest {
                    numbers = l.add_u(numbers, l.splat_u(WIDTH as u32));
                    best = l.max(best, l.tag(V3::load(l, &block.0).dot(l, d), tag, numbers));
                }
            }
            l.store(best, &mut support_scratch.along[k]);
        }
        let number =
            l.tag_of(l.largest_of_each(&support_scratch.along), l.load_u(&support_scratch.tag));
        let [x, y, z] = l.pick(frame.blocks(), l.load_u(&support_scratch.first), number);
        V3::<L>(x, y, z).store(l, &mut support_scratch.points);
        l.store_u(number, &mut support_scratch.numbers);
    }
}
