//! A compound against a mesh: each part by itself, so that the separating planes and spheres of a convex shape
//! resolve many triangles at once.

use super::descent::{Bits, Descent};
use super::relative_pose::RelativePose;
use super::side::{Parts, Side};
use super::{Next, Scratch, Tally};
use crate::simd::cores::MAX_PARTS;
use dcd_geom::{Aabb16, Compound};
use dcd_simd::{Kernel, Lanes};

/// The second shape's parts, if they are tested one by one: a compound's against a mesh.
pub(super) fn parts_of<'a>([a, b]: [&Side<'a>; 2]) -> Option<&'a Compound> {
    match (a.parts, b.parts) {
        (Parts::Mesh(_), Parts::Compound(parts)) if parts.parts().len() <= MAX_PARTS => Some(parts),
        _ => None,
    }
}

/// The search of a mesh and a compound.
pub(super) struct PerPart<'a, 'g> {
    pub(super) sides: [&'a Side<'a>; 2],
    pub(super) compound: &'a Compound,
    pub(super) relative: &'a RelativePose,
    pub(super) scratch: &'a mut Scratch,
    pub(super) tally: &'a mut Tally<'g>,
}

impl Kernel for PerPart<'_, '_> {
    type Output = Next;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Next {
        let Self { sides: [a, b], compound, relative, scratch, tally } = self;
        let (Some(mesh), tree) = (a.tree(), compound.tree()) else { return Next::Go };
        let around = mesh.aabb();
        let leaves = tree.blocks().iter().zip(tree.below()).take(tree.leaf_count());
        for (boxes, below) in leaves {
            let mut placed = Aabb16::EMPTY;
            relative.place(l, boxes, &mut placed);
            for lane in Bits(placed.overlaps(l, &around)) {
                let number = below.0[lane];
                let shape = compound.parts()[number as usize].placed();
                let part = Side { parts: Parts::One(shape), pose: b.pose, reach: b.reach };
                let known = tally.listed();
                let next = l.call(&mut Descent::of([a, &part], relative, scratch, tally));
                tally.are_of(number, known);
                if next == Next::Stop {
                    return Next::Stop;
                }
            }
        }
        Next::Go
    }
}
