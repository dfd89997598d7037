//! What two shapes come to, part by part.

use dcd_geom::{Polytope, Shape};
use dcd_gjk::{PosedShape, Verdict, certified};

/// Every part against every part up to the first that touches, with no tree that could hide one.
pub(crate) fn part_by_part(a: PosedShape<'_>, b: PosedShape<'_>) -> Verdict<()> {
    let (of_a, of_b) = (parts(a.shape), parts(b.shape));
    let mut all = Verdict::Apart;
    for (one, other) in of_a.iter().flat_map(|a| of_b.iter().map(move |b| (a, b))) {
        let (one, other) = (PosedShape { shape: one, ..a }, PosedShape { shape: other, ..b });
        match certified::overlap_of(one, other).0 {
            Verdict::Apart => {}
            Verdict::Touching(()) => return Verdict::Touching(()),
            undecided => all = undecided,
        }
    }
    all
}

/// The convex shapes that it is the union of, in its own frame.
fn parts(shape: &Shape) -> Vec<Shape> {
    match shape {
        Shape::Compound(compound) => {
            compound.parts().iter().map(|part| part.placed().clone()).collect()
        }
        Shape::Mesh(mesh) => {
            let triangle = |k| {
                let corners = Polytope::hull(mesh.corners(k)?.to_vec()).ok()?;
                corners.rounded(mesh.swept_radius()).ok().map(Shape::from)
            };
            (0..mesh.triangles().len()).filter_map(triangle).collect()
        }
        _ => vec![shape.clone()],
    }
}

/// Equal, or at least one of them undecided: a tree's AABBs may decide what a pair of parts leaves open.
pub(crate) fn agree(one: Verdict<()>, other: Verdict<()>) -> bool {
    let decided = |verdict| match verdict {
        Verdict::Apart => Some(false),
        Verdict::Touching(()) => Some(true),
        Verdict::Undecided(_) => None,
    };
    let (one, other) = (decided(one), decided(other));
    one == other || one.is_none() || other.is_none()
}
