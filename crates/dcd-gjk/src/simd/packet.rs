//! Pairs on their way through the stages, sixteen at a time.

use super::vector::V3;
use dcd_geom::glam::Vec3;
use dcd_simd::{IndexRow, Kernel, Lanes, Row, WIDTH};
use std::mem::offset_of;

/// Sixteen pairs and what is known of them, row by row. Lengths are metres, in world axes; every
/// point is one of A − B.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PairPacket {
    /// Each pair's number in its slice.
    pub(super) number: IndexRow,
    /// The objects a.
    pub(super) a: IndexRow,
    /// The objects b.
    pub(super) b: IndexRow,
    rows: [Row; ROWS],
}

/// The rows of a packet, in the order in which the stages come to need them: a queue carries the first so many.
/// Never made: the places of its fields number the rows of [`PairPacket`].
#[repr(C)]
#[allow(dead_code, reason = "only the places of the fields are read")]
struct Layout {
    inner: Row,
    radius: Row,
    unit: Row,
    slack: Row,
    separation: Row,
    centres: [Row; 3],
    p0: [Row; 3],
    p1: [Row; 3],
    direction: [Row; 3],
    p2: [Row; 3],
    found: Row,
    round: Row,
    nearest: [Row; 3],
    lower: Row,
    second: Row,
    third: Row,
    c0: Row,
    c1: Row,
    c2: Row,
}

/// The number of the row that begins that many bytes into a [`Layout`].
const fn row(offset: usize) -> isize {
    (offset / size_of::<Row>()) as isize
}

/// How many rows of a packet mean something after a stage: what is carried on.
pub(super) const AFTER_SPHERES: usize = row(offset_of!(Layout, p0)) as usize;
/// See [`AFTER_SPHERES`].
pub(super) const AFTER_CONE: usize = row(offset_of!(Layout, p1)) as usize;
/// See [`AFTER_SPHERES`].
pub(super) const AFTER_SECOND_POINT: usize = row(offset_of!(Layout, nearest)) as usize;
/// See [`AFTER_SPHERES`]: of a pair whose distance is measured.
pub(super) const AFTER_NEAREST: usize = row(size_of::<Layout>()) as usize;

/// How many rows there are.
const ROWS: usize = AFTER_NEAREST;

/// A row of numbers in a packet.
#[derive(Clone, Copy, Debug)]
pub(super) enum Number {
    /// The radius of a sphere round c inside A − B, rounded down.
    Inner = row(offset_of!(Layout, inner)),
    /// The sum of the swept radii, rounded up.
    Radius = row(offset_of!(Layout, radius)),
    /// u·m: the unit of every rounding bound.
    Unit = row(offset_of!(Layout, unit)),
    /// The sum of the centres' own errors.
    Slack = row(offset_of!(Layout, slack)),
    /// What a separation may be off by, for a direction of 1-norm 1.
    Separation = row(offset_of!(Layout, separation)),
    /// 1 where the pair has a portal that the ray from c to the origin passes, else 0.
    Found = row(offset_of!(Layout, found)),
    /// How many supports it took after the second point.
    Round = row(offset_of!(Layout, round)),
    /// At most the distance of the cores, metres.
    Lower = row(offset_of!(Layout, lower)),
    /// The weight of the second point in the nearest one; the first has what the others leave of 1.
    Second = row(offset_of!(Layout, second)),
    /// The weight of the third.
    Third = row(offset_of!(Layout, third)),
}

/// A row of a packet: which vertices of a and of b make a point, as the float a + 4096·b. Both are numbers of
/// [`CORNER_BITS`] bits.
#[derive(Clone, Copy, Debug)]
pub(super) enum Corner {
    /// Of [`Vector::P0`].
    C0 = row(offset_of!(Layout, c0)),
    /// Of [`Vector::P1`].
    C1 = row(offset_of!(Layout, c1)),
    /// Of [`Vector::P2`].
    C2 = row(offset_of!(Layout, c2)),
}

/// Three rows of a packet.
#[derive(Clone, Copy, Debug)]
pub(super) enum Vector {
    /// The difference of the centres: the centre of a sphere inside A − B.
    C = row(offset_of!(Layout, centres)),
    /// The first support point of the portal.
    P0 = row(offset_of!(Layout, p0)),
    /// The second.
    P1 = row(offset_of!(Layout, p1)),
    /// The direction of the next support.
    D = row(offset_of!(Layout, direction)),
    /// The third.
    P2 = row(offset_of!(Layout, p2)),
    /// The nearest point to the origin that is known, where the distance is measured.
    Nearest = row(offset_of!(Layout, nearest)),
}

/// How many bits a vertex's number has at most; two of them fit into the 24 of an f32.
const CORNER_BITS: u32 = 12;

/// A [`Corner`] of the vertices of those numbers in a and in b.
#[inline(always)]
pub(super) fn corner_of_vertices<L: Lanes>(l: L, [a, b]: [L::U; 2]) -> L::F {
    let scale = l.splat((1u32 << CORNER_BITS) as f32);
    l.add(float(l, a), l.mul(float(l, b), scale))
}

/// A vertex's number as a float: the lowest bits of 2²³ + n are n.
#[inline(always)]
fn float<L: Lanes>(l: L, number: L::U) -> L::F {
    let base = l.splat((1u32 << (f32::MANTISSA_DIGITS - 1)) as f32);
    let low = l.splat_u((1 << CORNER_BITS) - 1);
    l.sub(l.tag(base, low, number), base)
}

/// The vertices' numbers in a and in b of a [`Corner`].
#[inline(always)]
pub(super) fn vertices_of_corner(corner: f32) -> [u32; 2] {
    let both = corner as u32;
    [both % (1 << CORNER_BITS), both >> CORNER_BITS]
}

impl PairPacket {
    #[inline(always)]
    pub(super) fn number<L: Lanes>(&self, l: L, which: Number) -> L::F {
        l.load(&self.rows[which as usize])
    }

    #[inline(always)]
    pub(super) fn set_number<L: Lanes>(&mut self, l: L, which: Number, x: L::F) {
        l.store(x, &mut self.rows[which as usize]);
    }

    /// Two axes from b to a that may separate a lane's pair: between the centres, and against the
    /// direction of the next support.
    pub(super) fn axes(&self, lane: usize) -> [Vec3; 2] {
        let at = |first: usize| Vec3::from_array([0, 1, 2].map(|k| self.rows[first + k].0[lane]));
        [at(Vector::C as usize), -at(Vector::D as usize)]
    }

    #[inline(always)]
    pub(super) fn vector<L: Lanes>(&self, l: L, which: Vector) -> V3<L> {
        let at = which as usize;
        V3(l.load(&self.rows[at]), l.load(&self.rows[at + 1]), l.load(&self.rows[at + 2]))
    }

    #[inline(always)]
    pub(super) fn corner<L: Lanes>(&self, l: L, which: Corner) -> L::F {
        l.load(&self.rows[which as usize])
    }

    #[inline(always)]
    pub(super) fn set_corner<L: Lanes>(&mut self, l: L, which: Corner, corner: L::F) {
        l.store(corner, &mut self.rows[which as usize]);
    }

    /// One lane's number.
    pub(super) fn number_of(&self, lane: usize, which: Number) -> f32 {
        self.rows[which as usize].0[lane]
    }

    /// One lane's corner: the vertices' numbers in a and in b.
    pub(super) fn corner_of(&self, lane: usize, which: Corner) -> [u32; 2] {
        vertices_of_corner(self.rows[which as usize].0[lane])
    }

    #[inline(always)]
    pub(super) fn set_vector<L: Lanes>(&mut self, l: L, which: Vector, v: V3<L>) {
        let at = which as usize;
        l.store(v.0, &mut self.rows[at]);
        l.store(v.1, &mut self.rows[at + 1]);
        l.store(v.2, &mut self.rows[at + 2]);
    }
}

/// Pairs that wait for their next stage until they fill a packet, the first `R` rows of each.
///
/// A stage takes whole packets, so that no lane is idle and no loop over the lanes is cut short at a
/// number that cannot be predicted; only the last packets of a slice are smaller.
#[derive(Clone, Debug)]
pub(super) struct PacketQueue<const R: usize> {
    len: usize,
    number: [u32; 2 * WIDTH],
    a: [u32; 2 * WIDTH],
    b: [u32; 2 * WIDTH],
    rows: [[f32; 2 * WIDTH]; R],
}

impl<const R: usize> Default for PacketQueue<R> {
    fn default() -> Self {
        let none = [0; 2 * WIDTH];
        Self { len: 0, number: none, a: none, b: none, rows: [[0.0; 2 * WIDTH]; R] }
    }
}

impl<const R: usize> PacketQueue<R> {
    /// Whether a packet can be taken that is `whole`.
    #[inline(always)]
    pub(super) fn has(&self, whole: Whole) -> bool {
        match whole {
            Whole::Only => self.len >= WIDTH,
            Whole::OrLast => self.len > 0,
        }
    }

    /// Appends the pairs of the packet set in `keep`. The queue must have space: [`PacketQueue::has`] no whole packet.
    #[inline(always)]
    pub(super) fn push<L: Lanes>(&mut self, l: L, packet: &PairPacket, keep: u32) {
        if keep != 0 {
            l.call(Push { queue: self, packet, keep });
        }
    }

    /// Moves the last pairs into the packet, sixteen or all there are, and returns how many. The
    /// other lanes of the packet keep some pair's numbers.
    #[inline(always)]
    pub(super) fn take<L: Lanes>(&mut self, l: L, packet: &mut PairPacket) -> usize {
        l.call(Take { queue: self, packet })
    }
}

/// [`PacketQueue::take`], compiled once a path.
struct Take<'a, const R: usize> {
    queue: &'a mut PacketQueue<R>,
    packet: &'a mut PairPacket,
}

impl<const R: usize> Kernel for Take<'_, R> {
    type Output = usize;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> usize {
        let Self { queue, packet } = self;
        let at = queue.len.saturating_sub(WIDTH).min(WIDTH);
        l.store_u(from_u(l, &queue.number, at), &mut packet.number);
        l.store_u(from_u(l, &queue.a, at), &mut packet.a);
        l.store_u(from_u(l, &queue.b, at), &mut packet.b);
        for row in 0..R {
            l.store(from(l, &queue.rows[row], at), &mut packet.rows[row]);
        }
        let taken = queue.len - at;
        queue.len = at;
        taken
    }
}

/// [`PacketQueue::push`], compiled once a path.
struct Push<'a, const R: usize> {
    queue: &'a mut PacketQueue<R>,
    packet: &'a PairPacket,
    keep: u32,
}

impl<const R: usize> Kernel for Push<'_, R> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        let Self { queue, packet, keep } = self;
        let at = queue.len.min(WIDTH);
        l.compress_to_u(keep, l.load_u(&packet.number), &mut queue.number, at);
        l.compress_to_u(keep, l.load_u(&packet.a), &mut queue.a, at);
        l.compress_to_u(keep, l.load_u(&packet.b), &mut queue.b, at);
        for row in 0..R {
            l.compress_to(keep, l.load(&packet.rows[row]), &mut queue.rows[row], at);
        }
        queue.len += keep.count_ones() as usize;
    }
}

/// Which packets a stage takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Whole {
    /// Those of sixteen pairs.
    Only,
    /// Smaller ones too, for no more pairs will come.
    OrLast,
}

/// Sixteen from `at` on, which is at most 16.
#[inline(always)]
fn from<L: Lanes>(l: L, row: &[f32; 2 * WIDTH], at: usize) -> L::F {
    match row[at..].first_chunk() {
        Some(numbers) => l.load_from(numbers),
        None => l.splat(0.0),
    }
}

/// See [`from`].
#[inline(always)]
fn from_u<L: Lanes>(l: L, row: &[u32; 2 * WIDTH], at: usize) -> L::U {
    match row[at..].first_chunk() {
        Some(numbers) => l.load_from_u(numbers),
        None => l.splat_u(0),
    }
}

/// The numbers of the set bits, from the lowest.
#[derive(Clone, Copy, Debug)]
pub(super) struct LanesOf(pub(super) u32);

impl Iterator for LanesOf {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        let lane = self.0.trailing_zeros();
        self.0 &= self.0.wrapping_sub(1);
        (lane < WIDTH as u32).then_some(lane as usize)
    }
}
