//! Half-spaces against cuboids, capsules, hulls, cylinders, cones and meshes where a certified answer is not asked for: the
//! lowest point above the plane, once in f64.
//!
//! [`half_space`](super::half_space) takes the plane as the pose has it, exactly; here the pose's matrix is a rotation,
//! and what it is off one by is in the bound (docs/numerics/proofs.md, "Half-spaces in f64").

mod in_frame;

use super::gap::Gap;
use super::{SIZES, UNIT};
use crate::query::Accuracy;
use crate::{DistanceResult, PosedShape};
use dcd_geom::glam::{DMat3, DVec3};
use dcd_geom::{Curved, HalfSpace, Kind, Mesh, Polytope, Pose, Shape, Support, SupportMap, Vector};
use dcd_simd::HeightsAlong;
pub(crate) use in_frame::PlaneInFrame;

/// How far a gap may be off. Unit: u·m. Derived: 36.
const LOST: f64 = 48.0;

/// The same, for what the plane's pose is off a rotation by. Unit: its deviation, times m. Derived: 2.2.
const DEVIATION: f64 = 3.0;

/// The least part of a direction across a round shape's axis by which a point of its rim is chosen: its square does not
/// underflow. No unit. Smaller: points beside the rim.
const ACROSS: f64 = 1e-140;

/// How far apart they are, or that they touch; `None` of other kinds, where f64 proves neither, and at the certified
/// accuracy.
///
/// (a, b) and (b, a) give the same bits, mirrored.
#[inline]
pub(crate) fn distance(
    accuracy: Accuracy,
    a: PosedShape<'_>,
    b: PosedShape<'_>,
) -> Option<DistanceResult> {
    gap_of(accuracy, a, b)?.distance()
}

/// Of a half-space and another shape, from the plane: how far the lowest point is above it. `None` of other kinds, and at
/// the certified accuracy.
///
/// (a, b) and (b, a) give the same bits, mirrored.
#[inline]
pub(super) fn gap_of(accuracy: Accuracy, a: PosedShape<'_>, b: PosedShape<'_>) -> Option<Gap> {
    gap_and_lowest(accuracy, a, b).map(|(gap, _)| gap)
}

/// The same, and which vertex of a polytope that is no cuboid is the lowest.
#[inline(always)]
pub(crate) fn gap_and_lowest(
    accuracy: Accuracy,
    a: PosedShape<'_>,
    b: PosedShape<'_>,
) -> Option<(Gap, Option<u32>)> {
    let most = super::centred::largest_deviation(accuracy)?;
    let (half_space, plane, other, swapped) = match (a.shape, b.shape) {
        (Shape::HalfSpace(half_space), _) => (half_space, a, b, false),
        (_, Shape::HalfSpace(half_space)) => (half_space, b, a, true),
        _ => return None,
    };
    if !(plane.pose.deviation() <= most) {
        return None;
    }
    gap_above(half_space, plane, other, swapped)
}

/// A plane as another shape sees it.
struct PlaneAtShape {
    /// Out of the half-space, of unit length: in the world, and in the shape's own frame.
    outward: DVec3,
    along: DVec3,
    offset: f64,
    /// From the plane's origin to the shape's, in the world.
    delta: DVec3,
}

impl PlaneAtShape {
    #[inline(always)]
    fn of(half_space: &HalfSpace, plane: &Pose, shape: &Pose) -> Self {
        let outward = *plane.rotation() * half_space.unit_normal();
        let offset = half_space.unit_offset();
        let delta = shape.translation() - plane.translation();
        let DMat3 { x_axis, y_axis, z_axis } = shape.rotation();
        let along = DVec3::new(x_axis.dot(outward), y_axis.dot(outward), z_axis.dot(outward));
        Self { outward, along, offset, delta }
    }

    /// How far the gap of a point of the shape may be off, where it reaches so far from its own origin and the two are swept by
    /// `radius` together; `None` where a length is out of range.
    #[inline(always)]
    fn error(&self, (reach, radius): (f64, f64), plane: &Pose, shape: &Pose) -> Option<f64> {
        let reach = reach * (1.0 + shape.deviation());
        let size = reach + self.delta.norm1() + self.offset.abs() + radius;
        // False for NaN. A normal's squares are in range with its components.
        let is_in_range = SIZES.contains(&size);
        is_in_range.then(|| (LOST * UNIT + DEVIATION * plane.deviation()) * size)
    }
}

#[inline(always)]
fn gap_above(
    half_space: &HalfSpace,
    plane: PosedShape<'_>,
    other: PosedShape<'_>,
    swapped: bool,
) -> Option<(Gap, Option<u32>)> {
    let seen = PlaneAtShape::of(half_space, plane.pose, other.pose);
    let PlaneAtShape { outward, along, offset, delta } = seen;
    let Lowest { point, height, vertex, reach, swept } = Lowest::of(other.shape, along)?;
    let radius = half_space.swept_radius() + swept;
    let value = (height + outward.dot(delta)) - offset - radius;
    let error = seen.error((reach, radius), plane.pose, other.pose)?;
    let lowest = other.pose.apply(point) - outward * swept;
    let on_plane = lowest - outward * value;
    Some((Gap::new((value, error), outward, [on_plane, lowest], swapped), vertex))
}

/// The triangles of a mesh of which one has the corner that is lowest over a half-space's plane, by index in rising order; `None`
/// of another shape than that, and where a length is out of range.
pub(crate) fn lowest_triangles(
    (mesh, at): (&Mesh, &Pose),
    plane: PosedShape<'_>,
) -> Option<Vec<u32>> {
    let Shape::HalfSpace(half_space) = plane.shape else { return None };
    // Written so that NaN is too far from a rotation.
    if !(plane.pose.deviation() <= super::centred::TURNED) {
        return None;
    }
    let seen = PlaneAtShape::of(half_space, plane.pose, at);
    let (_, height) = lowest_of_mesh(mesh, seen.along)?;
    let radius = half_space.swept_radius() + mesh.swept_radius();
    let error = seen.error((mesh.reach(), radius), plane.pose, at)?;
    // Two heights may be off, and their sum is rounded.
    let most = (height + 2.0 * error).next_up();
    let tree = mesh.tree();
    let test = HeightsAlong::new(seen.along, &tree.aabb())?;
    let mut lowest = Vec::new();
    tree.visit_within(&test, test.key_of(most), &mut |triangle| {
        let corners = mesh.corners(triangle as usize);
        let is_low = |corner: &DVec3| corner.dot(seen.along) <= most;
        if corners.iter().flatten().any(is_low) {
            lowest.push(triangle);
        }
        true
    });
    lowest.sort_unstable();
    Some(lowest)
}

/// Where a shape is lowest.
struct Lowest {
    /// Of the core, in the shape's own frame.
    point: DVec3,
    /// How high that is along the direction.
    height: f64,
    /// Which vertex of a polytope that is no cuboid.
    vertex: Option<u32>,
    /// At least the length of every vector of the core.
    reach: f64,
    /// Swept round the core.
    swept: f64,
}

impl Lowest {
    /// Along a direction of the shape's own frame; `None` of other kinds.
    #[inline(always)]
    fn of(shape: &Shape, along: DVec3) -> Option<Self> {
        Some(match shape {
            Shape::Polytope(polytope) => {
                let (point, height, vertex) = lowest_of(polytope, along);
                let (reach, swept) = (polytope.reach(), polytope.swept_radius());
                Self { point, height, vertex, reach, swept }
            }
            Shape::Curved(curved) => {
                let (point, height) = lowest_of_curved(curved, along);
                let reach = curved.half_height() + curved.radius();
                Self { point, height, vertex: None, reach, swept: curved.swept_radius() }
            }
            Shape::Mesh(mesh) => {
                let (point, height) = lowest_of_mesh(mesh, along)?;
                let (reach, swept) = (mesh.reach(), mesh.swept_radius());
                Self { point, height, vertex: None, reach, swept }
            }
            _ => return None,
        })
    }
}

/// The point of a core that is lowest along a direction, how high it is along it, and which vertex it is, if it was looked
/// for among them: the first among equals.
#[inline(always)]
fn lowest_of(polytope: &Polytope, along: DVec3) -> (DVec3, f64, Option<u32>) {
    if let Kind::Cuboid { half_extents } = polytope.kind() {
        let lowest =
            half_extents * DVec3::select(along.cmplt(DVec3::ZERO), DVec3::ONE, DVec3::NEG_ONE);
        return (lowest, lowest.dot(along), None);
    }
    let Support { point, feature } = SupportMap::<f64>::support(polytope, -along);
    (point, point.dot(along), Some(feature))
}

/// The same of a mesh's corners: of equals the one with the smallest index. `None` where they leave the range of f32.
///
/// Only boxes of triangles are left out that are higher than a corner that was seen.
#[inline(never)]
fn lowest_of_mesh(mesh: &Mesh, along: DVec3) -> Option<(DVec3, f64)> {
    let tree = mesh.tree();
    let test = HeightsAlong::new(along, &tree.aabb())?;
    let mut best = (f64::INFINITY, u32::MAX);
    tree.visit(&test, f32::MAX, &mut |triangle, _| {
        for &corner in mesh.triangles().get(triangle as usize).into_iter().flatten() {
            let height = mesh.vertices()[corner as usize].dot(along);
            if height < best.0 || height == best.0 && corner < best.1 {
                best = (height, corner);
            }
        }
        test.key_of(best.0)
    });
    let lowest = mesh.vertices().get(best.1 as usize)?;
    Some((*lowest, best.0))
}

/// The same of the hull of two discs.
#[inline(always)]
fn lowest_of_curved(curved: &Curved, along: DVec3) -> (DVec3, f64) {
    let across = (along.x * along.x + along.y * along.y).sqrt();
    // Along the axis any point of the rim is as low.
    let (x, y) = if across > ACROSS { (along.x / across, along.y / across) } else { (0.0, 0.0) };
    let [low, high] = curved.discs().map(|(z, radius)| (z, radius, along.z * z - across * radius));
    let (z, radius, height) = if high.2 < low.2 { high } else { low };
    (DVec3::new(-radius * x, -radius * y, z), height)
}

#[cfg(test)]
mod tests;
