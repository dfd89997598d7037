//! What the lanes found of pairs of cuboids, as the lanes wrote it: read once, where the manifold is written.

use dcd_simd::{Row, WIDTH};

/// Added to a whole number below 2²², leaves that in the lowest bits of the sum, with nothing rounded.
pub(super) const WHOLE: f32 = 8_388_608.0;

/// What each part of [`Codes`] is multiplied by: how many points, the number after that of the first's edge and of the
/// second's, whose face clips, and what each shows.
pub(super) const PLACES: [f32; 6] = [1.0, 8.0, 32.0, 128.0, 256.0, 32_768.0];

/// What is found of sixteen pairs.
#[derive(Clone, Debug, Default)]
pub(super) struct Rows {
    /// The lanes of which something is, those whose first cuboid is b, and those whose normal, from the first to the second, is
    /// against the edge or product that makes it.
    pub(super) known: u32,
    pub(super) swapped: u32,
    pub(super) backward: u32,
    pub(super) bound: Row,
    /// See [`Codes`]; [`WHOLE`] is added.
    pub(super) codes: Row,
    /// How the half edges of the first compare, and 32 times that of the second; [`WHOLE`] is added.
    pub(super) cases: Row,
    /// Of each point three coordinates, the depth and the bounds, to which [`WHOLE`] is added.
    pub(super) points: [[Row; 5]; 4],
}

/// What the lanes found of a pair of cuboids that touch.
#[derive(Clone, Copy, Debug)]
pub struct CuboidPatch<'a> {
    pub(super) rows: &'a Rows,
    pub(super) lane: usize,
}

/// A point of the first cuboid where its face clips, else of the second, and how deep the two overlap there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PatchPoint {
    /// From the first's centre, world axes, metres.
    pub(crate) offset: [f32; 3],
    pub(crate) depth: f32,
    /// The two that meet there: edges of what is clipped, from the corner of their number to the next, below 4; sides of the face
    /// below 8, at the high end of its first axis, the low end, of the second alike; 8: the surface.
    pub(crate) bounds: [u8; 2],
}

/// What a cuboid shows along the normal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Shown {
    pub(crate) kind: ShownKind,
    /// The axis that the face is normal to, or that the edge is along.
    pub(crate) axis: u32,
    /// The number of the farthest corner: a bit for each axis.
    pub(crate) corner: u32,
    /// How the half edges compare: see [`case_of`](crate::query::case_of).
    pub(crate) case: u32,
}

/// A face, an edge or a corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ShownKind {
    Face,
    Edge,
    Vertex,
}

/// All that is a small number of a pair, in one: see [`PLACES`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Codes(u32);

impl CuboidPatch<'_> {
    #[inline(always)]
    fn at(&self, row: &Row) -> f32 {
        row.0[self.lane % WIDTH]
    }

    #[inline(always)]
    fn is_in(&self, lanes: u32) -> bool {
        lanes >> (self.lane % WIDTH) & 1 == 1
    }

    /// Whether anything was found; if not, nothing else is to be read.
    #[inline(always)]
    pub(crate) fn is_known(&self) -> bool {
        self.is_in(self.rows.known)
    }

    /// Whether the first cuboid is b.
    #[inline(always)]
    pub(crate) fn is_swapped(&self) -> bool {
        self.is_in(self.rows.swapped)
    }

    /// Whether the normal, from the first to the second, is against the edge or product that makes it.
    #[inline(always)]
    pub(crate) fn is_back(&self) -> bool {
        self.is_in(self.rows.backward)
    }

    /// See [`Manifold::error_bound`](crate::query::Manifold::error_bound).
    #[inline(always)]
    pub(crate) fn error_bound(&self) -> f32 {
        self.at(&self.rows.bound)
    }

    #[inline(always)]
    pub(crate) fn codes(&self) -> Codes {
        Codes(self.at(&self.rows.codes).to_bits())
    }

    /// What the one shows whose face clips, and the other.
    #[inline(always)]
    pub(crate) fn shown(&self) -> [Shown; 2] {
        let (codes, cases) = (self.codes(), self.at(&self.rows.cases).to_bits());
        let (first, second) = ((codes.0 >> 8, cases), (codes.0 >> 15, cases >> 5));
        let (clips, other) = if codes.clips() == 0 { (first, second) } else { (second, first) };
        [Shown::decode(clips), Shown::decode(other)]
    }

    /// One to four points: the deepest first.
    #[inline(always)]
    pub(crate) fn points(&self) -> impl Iterator<Item = PatchPoint> {
        let count = self.codes().0 & 7;
        self.rows.points.iter().take(count as usize).map(|[x, y, z, depth, bounds]| {
            let bounds = self.at(bounds).to_bits() as u8;
            PatchPoint {
                offset: [self.at(x), self.at(y), self.at(z)],
                depth: self.at(depth),
                bounds: [bounds / 16, bounds % 16],
            }
        })
    }
}

impl Codes {
    /// The numbers of the first's edge and of the second's that make the normal.
    #[inline(always)]
    pub(crate) fn edges(self) -> [Option<usize>; 2] {
        let edge = |number: u32| (number as usize).checked_sub(1);
        [edge(self.0 >> 3 & 3), edge(self.0 >> 5 & 3)]
    }

    /// Whose face clips: 0 or 1.
    #[inline(always)]
    pub(crate) fn clips(self) -> usize {
        (self.0 >> 7 & 1) as usize
    }
}

impl Shown {
    /// Of the lowest seven bits of the one, and the lowest five of the other.
    #[inline(always)]
    fn decode((code, case): (u32, u32)) -> Self {
        let kind = match code & 3 {
            0 => ShownKind::Face,
            1 => ShownKind::Edge,
            _ => ShownKind::Vertex,
        };
        Self { kind, axis: code >> 2 & 3, corner: code >> 4 & 7, case: case & 31 }
    }
}
