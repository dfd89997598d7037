//! Boxes round what sixteen states have in common: what is far from all of them costs one comparison.

use super::solids::Solid;
use super::{FAR, SpherePacket};
use dcd_geom::Aabb;
use dcd_simd::{Block, Lanes, Row, WIDTH};
use glam::Vec3;

/// The boxes of sixteen obstacles, each larger by twice the obstacle's margin.
#[derive(Clone, Debug)]
pub(super) struct PackedAabbs {
    min: Block,
    max: Block,
    /// Those that there are.
    filled: u32,
}

impl PackedAabbs {
    /// Fills rows with the boxes of obstacles and what these are compared as, in place of what was there.
    pub(super) fn fill(rows: &mut Vec<Self>, aabbs: &[Aabb], solids: &[Solid]) {
        rows.clear();
        let groups = aabbs.chunks(WIDTH).zip(solids.chunks(WIDTH));
        rows.extend(groups.map(|(aabbs, solids)| Self::of_few(aabbs, solids)));
    }

    fn of_few(aabbs: &[Aabb], solids: &[Solid]) -> Self {
        let none = Block([Row([0.0; WIDTH]); 3]);
        let mut row = Self { min: none, max: none, filled: 0 };
        for (k, (aabb, solid)) in aabbs.iter().zip(solids).enumerate() {
            row.set(k, aabb, solid);
        }
        row
    }

    fn set(&mut self, k: usize, aabb: &Aabb, solid: &Solid) {
        let margin = 2.0 * solid.margin();
        for axis in 0..3 {
            self.min.0[axis].0[k] = aabb.min[axis] - margin;
            self.max.0[axis].0[k] = aabb.max[axis] + margin;
        }
        self.filled |= 1 << k;
    }

    /// Sets the box of an obstacle that there was, or of a new last one.
    pub(super) fn put(rows: &mut Vec<Self>, obstacle: usize, aabb: &Aabb, solid: &Solid) {
        match rows.get_mut(obstacle / WIDTH) {
            Some(row) => row.set(obstacle % WIDTH, aabb, solid),
            None => rows.push(Self::of_few(&[*aabb], std::slice::from_ref(solid))),
        }
    }

    /// Takes the last of so many boxes away.
    pub(super) fn drop_last(rows: &mut Vec<Self>, count: usize) {
        rows.truncate((count - 1).div_ceil(WIDTH));
        if let Some(row) = rows.get_mut((count - 1) / WIDTH) {
            row.filled &= !(1 << ((count - 1) % WIDTH));
        }
    }

    /// Which of the boxes another one overlaps, or is not known to be apart from: a NaN is near.
    #[inline(always)]
    pub(super) fn overlapped<L: Lanes>(&self, l: L, by: &Aabb) -> u32 {
        let mut apart = 0;
        for axis in 0..3 {
            let below = l.lt(l.splat(by.max[axis]), l.load(&self.min.0[axis]));
            let above = l.lt(l.load(&self.max.0[axis]), l.splat(by.min[axis]));
            apart |= l.bits(l.or(below, above));
        }
        self.filled & !apart
    }
}

/// A box round some of sixteen spheres, larger by twice the margin of each: so what is beyond it is
/// beyond what [`Solid::reached`] and spheres of links take for near, whatever those round, and an answer does not
/// depend on which spheres there are.
#[inline(always)]
pub(super) fn around<L: Lanes>(l: L, spheres: &SpherePacket<L>, some: u32) -> Aabb {
    let SpherePacket { centre, outer, margin, .. } = *spheres;
    let reach = l.add(outer, l.add(margin, margin));
    let (wanted, none) = (l.mask(some), l.splat(f32::NEG_INFINITY));
    let (mut min, mut max) = (Vec3::ZERO, Vec3::ZERO);
    let (mut known, most) = (some, l.splat(FAR));
    for axis in 0..3 {
        let (low, high) = (l.sub(reach, centre[axis]), l.add(reach, centre[axis]));
        known &= l.bits(l.and(l.le(low, most), l.le(high, most)));
        min[axis] = -l.largest(l.select(wanted, low, none));
        max[axis] = l.largest(l.select(wanted, high, none));
    }
    // A maximum may swallow a NaN.
    if known == some { Aabb { min, max } } else { Aabb::EVERYTHING }
}

/// Whether two boxes overlap, or are not known to be apart.
#[inline(always)]
pub(super) fn overlap(a: &Aabb, b: &Aabb) -> bool {
    let apart = |axis: usize| a.max[axis] < b.min[axis] || b.max[axis] < a.min[axis];
    !(apart(0) || apart(1) || apart(2))
}
