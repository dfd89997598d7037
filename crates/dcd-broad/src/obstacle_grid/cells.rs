//! A grid of cells.

use dcd_geom::Aabb;
use dcd_geom::glam::{UVec3, Vec3, Vec3A};
use dcd_simd::{Block, Lanes};

/// How many cells there may be, and how many may list an obstacle, for each obstacle. Larger: shorter
/// lists in more memory. No effect on what is known to be near.
const CELLS: usize = 64;
const LISTED: usize = 256;

/// How many cells there may be in any case: f32 counts them.
const MAX_CELLS: usize = 1 << 22;

/// Cubes, or all but: each axis has its own scale. After the last cell along each axis comes one of
/// what is beyond, the first one has what is before it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    origin: Vec3A,
    /// Cells a metre.
    scale: Vec3A,
    /// The number of the last cell along each axis, that of what is beyond.
    last: Vec3A,
    /// From one cell to the next along each axis.
    strides: Vec3A,
}

/// An f32 of this size has no digits after the point, and its lowest 23 bits are what it is larger by.
pub(super) const WHOLE: f32 = (1 << 23) as f32;

impl Grid {
    /// The grid of as many cells over that extent as [`CELLS`] and [`LISTED`] allow for these AABBs.
    pub(super) fn finest(extent: Aabb, boxes: &[Aabb]) -> Self {
        let mut finest = Self::of(Aabb::default(), Vec3::ZERO);
        if !extent.is_valid() {
            return finest;
        }
        let size = extent.max - extent.min;
        let most = (CELLS * boxes.len()).min(MAX_CELLS);
        for halvings in 0..16 {
            let edge = size.max_element() / (1 << halvings) as f32;
            let grid = Self::of(extent, (size / edge).ceil().max(Vec3::ONE));
            let counts = boxes.iter().map(|aabb| grid.range(aabb).count());
            let listed = counts.fold(0, usize::saturating_add);
            if halvings > 0 && (grid.len() > most || listed > LISTED * boxes.len()) {
                break;
            }
            finest = grid;
        }
        finest
    }

    /// A grid with so many cells along each axis.
    fn of(extent: Aabb, cells: Vec3) -> Self {
        // Nearly a cell short, so that the last point is in the last cell and not beyond.
        let scale = (cells - 0.75).max(Vec3::ZERO) / (extent.max - extent.min);
        let count = cells + 1.0;
        let strides = Vec3::new(1.0, count.x, count.x * count.y);
        Self {
            origin: extent.min.into(),
            // Where an extent is 0, or all but, one cell has all.
            scale: scale.map(|scale| if scale.is_finite() { scale } else { 0.0 }).into(),
            last: cells.into(),
            strides: strides.into(),
        }
    }

    pub(super) fn len(&self) -> usize {
        let counts = Vec3::from(self.last + Vec3A::ONE).to_array();
        counts.iter().fold(1, |all: usize, &count| all.saturating_mul(count as usize))
    }

    /// The place of each coordinate along its axis, a whole number. It never falls where a
    /// coordinate grows, for rounding never turns two numbers round; so between two points of an AABB
    /// there are only places between theirs, whatever was rounded.
    #[inline]
    fn place(&self, point: Vec3A) -> Vec3A {
        let place = ((point - self.origin) * self.scale).max(Vec3A::ZERO).min(self.last);
        (place + WHOLE) - WHOLE
    }

    /// The numbers of the cells that sixteen points are in, as [`Self::place`] has them.
    #[inline(always)]
    pub(super) fn cells<L: Lanes>(&self, l: L, points: &Block) -> L::F {
        let mut number = l.splat(0.0);
        for axis in 0..3 {
            let from = l.sub(l.load(&points.0[axis]), l.splat(self.origin[axis]));
            let place = l.mul(from, l.splat(self.scale[axis]));
            let place = l.min(l.max(place, l.splat(0.0)), l.splat(self.last[axis]));
            let whole = l.splat(WHOLE);
            let place = l.sub(l.add(place, whole), whole);
            // Whole numbers below 2²³: nothing is rounded.
            number = l.mul_add(place, l.splat(self.strides[axis]), number);
        }
        number
    }

    fn range(&self, aabb: &Aabb) -> Range {
        let place = |point: Vec3| Vec3::from(self.place(point.into())).as_uvec3();
        Range { first: place(aabb.min), end: place(aabb.max) + UVec3::ONE }
    }

    /// Visits the cells that an AABB meets: their numbers, and what is in them.
    pub(super) fn for_each_cell(&self, aabb: &Aabb, mut visit: impl FnMut(usize, Region)) {
        let Range { first, end } = self.range(aabb);
        let strides = Vec3::from(self.strides).as_uvec3();
        for z in first.z..end.z {
            for y in first.y..end.y {
                let row = (z * strides.z + y * strides.y) as usize;
                for x in first.x..end.x {
                    visit(row + x as usize, self.region(UVec3::new(x, y, z)));
                }
            }
        }
    }

    /// The region of the cell at that place.
    fn region(&self, place: UVec3) -> Region {
        let place = Vec3A::from(place.as_vec3());
        let edge = Vec3A::ONE / self.scale;
        let middle = self.origin + place * edge;
        // Of an axis with one cell the edge is infinite, and the middle not a number.
        let has_ends = self.scale.cmpgt(Vec3A::ZERO);
        let half = edge * HALF + middle.abs() * ROUNDED;
        let (min, max) = (middle - half, middle + half);
        Region {
            middle: Vec3A::select(has_ends, middle, self.origin).into(),
            min: Vec3A::select(has_ends & place.cmpgt(Vec3A::ZERO), min, Vec3A::NEG_INFINITY),
            max: Vec3A::select(has_ends & place.cmplt(self.last), max, Vec3A::INFINITY),
        }
    }
}

/// Half a cell's edge, in edges, with a margin for the rounding of a coordinate in f32: see
/// docs/numerics/proofs.md, "what is near". Smaller: contacts could be missed. Larger: longer lists.
const HALF: f32 = 0.5 + 1.0 / 16.0;

/// What f32 loses in a cell's middle and ends, beside that. Unit: of the middle. Smaller: contacts
/// could be missed. Larger: longer lists far from the origin.
const ROUNDED: f32 = 4.0 * f32::EPSILON;

/// A cell.
pub(super) struct Region {
    pub(super) middle: Vec3,
    /// The corners of the cell's extent, rounded outward.
    pub(super) min: Vec3A,
    pub(super) max: Vec3A,
}

/// Cells from one up to another, that one not included.
struct Range {
    first: UVec3,
    end: UVec3,
}

impl Range {
    fn count(&self) -> usize {
        let counts = (self.end - self.first).to_array();
        counts.iter().fold(1, |all: usize, &count| all.saturating_mul(count as usize))
    }
}
