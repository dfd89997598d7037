//! Which triangles of a mesh may be the deepest in a sphere or half-space, as one evaluation in f64 of each knows it: only these
//! need to be certified.

use super::is_swapped;
use crate::{PosedShape, closed};
use dcd_geom::Shape;

/// The pairs of parts of which one is the deepest, of a mesh and a sphere or half-space that touch: a part of `a` and one of
/// `b`, by index in rising order. `None` of other shapes, and where f64 leaves open which triangles touch.
pub(crate) fn may_be_deepest(a: PosedShape<'_>, b: PosedShape<'_>) -> Option<Vec<[u32; 2]>> {
    let swapped = is_swapped(a, b);
    let sides = if swapped { [b, a] } else { [a, b] };
    let Shape::Mesh(mesh) = sides[0].shape else { return None };
    let triangles = match sides[1].shape {
        Shape::HalfSpace(_) => closed::level::lowest_triangles((mesh, sides[0].pose), sides[1])?,
        _ => in_sphere(sides)?,
    };
    let pair = |triangle| if swapped { [0, triangle] } else { [triangle, 0] };
    Some(triangles.into_iter().map(pair).collect())
}

/// The same triangles of a mesh in a sphere.
fn in_sphere(sides: [PosedShape<'_>; 2]) -> Option<Vec<u32>> {
    let (mut deep, mut least) = (Vec::new(), 0.0f64);
    closed::centred::triangles_in_sphere(sides, None::<[u32; 0]>.map(IntoIterator::into_iter), {
        |triangle, _, depth| {
            least = least.max(depth.depth - depth.error_bound);
            deep.push((triangle, depth.depth + depth.error_bound));
        }
    })?;
    deep.retain(|&(_, most)| most >= least);
    let mut triangles: Vec<u32> = deep.into_iter().map(|(triangle, _)| triangle).collect();
    triangles.sort_unstable();
    (!triangles.is_empty()).then_some(triangles)
}
