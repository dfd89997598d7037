//! Spheres against cuboids, capsules, cylinders, cones, triangles, hulls and meshes, rounded or not: how far the sphere's centre
//! is from the core of the other, seen in its frame, negative inside.
//!
//! That distance changes by no more than the centre does, and so by no more than the centre lost on its way into the
//! frame: one evaluation is the answer with its bound, and no support is needed (docs/numerics/proofs.md, "A sphere's
//! centre").

mod faces;

use super::gap::Gap;
use super::{SIZES, UNIT, is_sphere};
use crate::epa::Depth;
use crate::query::Accuracy;
use crate::{DistanceResult, PosedShape, Verdict};
use dcd_geom::glam::{DMat3, DVec2, DVec3};
use dcd_geom::{Curved, CurvedKind, Kind, Mesh, Polytope, Pose, Shape, Vector};

/// How far the centre's distance from a box or an upright segment may be off. Unit: u·m. Derived: 19.
const STRAIGHT: f64 = 32.0;

/// The same of cylinders, cones, triangles and hulls. Derived: 35.
const ROUND: f64 = 48.0;

/// The same, for what the pose is off a rotation by. Unit: its deviation, times m. Derived: 2.1.
pub(super) const DEVIATION: f64 = 3.0;

/// The largest deviation of a pose at the accuracy of f32: a direction turned by it is of unit length but for rounding.
/// Larger: normals that are not.
pub(super) const TURNED: f64 = 1e-12;

/// The same at that of f64: a bound of at most 3e-14 of the pair's size. A rotation's is some 50u.
const ORTHONORMAL: f64 = 64.0 * UNIT;

/// By how much more than rounding a distance may be off at the accuracy of f64, for a bound of at most 3e-14 of the pair's size.
/// Unit: u of it. Larger: wider bounds. Smaller: more searches.
const UNSURE: f64 = 24.0;

/// The least distance of the centre from the core's surface of which a direction is taken, metres: its square does not
/// underflow.
const SHORTEST: f64 = 1e-140;

/// Where a point is beside a core, in the core's frame.
#[derive(Clone, Copy)]
struct Beside {
    /// How far outside, negative inside. Metres.
    distance: f64,
    /// Of unit length, away from the core's nearest point.
    outward: DVec3,
    /// By how much more than rounding the distance may be off.
    unsure: f64,
}

/// How far apart a sphere and another are, or that they touch; `None` for other kinds, where f64 proves neither, and at the
/// certified accuracy. What a pose is off a rotation by is more than distances in f64 lose otherwise.
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

/// The largest deviation of a pose that is taken for a rotation at an accuracy: none at the certified one.
#[inline]
pub(super) fn largest_deviation(accuracy: Accuracy) -> Option<f64> {
    match accuracy {
        Accuracy::F32 => Some(TURNED),
        Accuracy::F64 => Some(ORTHONORMAL),
        Accuracy::Certified => None,
    }
}

/// The core of a shape.
#[derive(Clone, Copy)]
enum Core<'a> {
    Cuboid(DVec3),
    /// Along z.
    Segment {
        low: DVec3,
        high: f64,
    },
    Curved(&'a Curved),
    Triangle(&'a Polytope),
    Hull(&'a Polytope),
    /// Its nearest triangle.
    Mesh(&'a Mesh),
}

impl<'a> Core<'a> {
    #[inline(always)]
    fn of(shape: &'a Shape) -> Option<Self> {
        match shape {
            Shape::Polytope(polytope) => match (polytope.kind(), polytope.vertices()) {
                (Kind::Triangle, _) => Some(Self::Triangle(polytope)),
                (Kind::Hull, _) => Some(Self::Hull(polytope)),
                (Kind::Cuboid { half_extents }, _) => Some(Self::Cuboid(half_extents)),
                (Kind::Segment, &[p, q]) if p.x == q.x && p.y == q.y => {
                    let (low, high) = if p.z <= q.z { (p, q.z) } else { (q, p.z) };
                    Some(Self::Segment { low, high })
                }
                _ => None,
            },
            Shape::Curved(curved) => Some(Self::Curved(curved)),
            Shape::Mesh(mesh) => Some(Self::Mesh(mesh)),
            _ => None,
        }
    }

    #[inline(always)]
    fn beside(self, point: DVec3) -> Option<Beside> {
        match self {
            Self::Cuboid(half) => beside_cuboid(half, point),
            Self::Segment { low, high } => {
                let foot = DVec3::new(low.x, low.y, point.z.clamp(low.z, high));
                outside(point - foot)
            }
            Self::Curved(curved) => beside_curved(curved, point),
            Self::Triangle(triangle) => {
                faces::beside_triangle(triangle.vertices(), point, triangle.reach())
            }
            Self::Hull(hull) => faces::beside_hull(hull, point),
            Self::Mesh(mesh) => faces::beside_mesh(mesh, point),
        }
    }
}

/// A point that is away from its nearest of a core; `None` where it is too near for a direction.
#[inline(always)]
fn outside(away: DVec3) -> Option<Beside> {
    let distance = away.length();
    (distance > SHORTEST).then(|| Beside { distance, outward: away / distance, unsure: 0.0 })
}

#[inline(always)]
fn beside_cuboid(half: DVec3, point: DVec3) -> Option<Beside> {
    let away = point - point.clamp(-half, half);
    if away != DVec3::ZERO {
        return outside(away);
    }
    let beyond = (point.abs() - half).to_array();
    let mut axis = if beyond[1] > beyond[0] { 1 } else { 0 };
    if beyond[2] > beyond[axis] {
        axis = 2;
    }
    let mut outward = DVec3::ZERO;
    outward[axis] = if point[axis] < 0.0 { -1.0 } else { 1.0 };
    Some(Beside { distance: beyond[axis], outward, unsure: 0.0 })
}

/// By the half-plane of the point and the axis: across the axis, and along it.
#[inline(always)]
fn beside_curved(curved: &Curved, point: DVec3) -> Option<Beside> {
    let across = (point.x * point.x + point.y * point.y).sqrt();
    let seen = DVec2::new(across, point.z);
    let (half_height, radius) = (curved.half_height(), curved.radius());
    let (distance, outward) = match curved.kind() {
        CurvedKind::Cylinder => beside_rectangle(half_height, radius, seen),
        _ => beside_wedge(half_height, radius, seen),
    }?;
    // Round the axis any azimuth is as good.
    let (x, y) = if across > SHORTEST { (point.x / across, point.y / across) } else { (1.0, 0.0) };
    let outward = DVec3::new(x * outward.x, y * outward.x, outward.y);
    Some(Beside { distance, outward, unsure: 0.0 })
}

/// A cylinder's half-plane: across ≤ radius, |along| ≤ half height.
#[inline(always)]
fn beside_rectangle(half_height: f64, radius: f64, seen: DVec2) -> Option<(f64, DVec2)> {
    let up = if seen.y < 0.0 { -1.0 } else { 1.0 };
    let (across, along) = (seen.x - radius, seen.y.abs() - half_height);
    if across > 0.0 && along > 0.0 {
        let away = DVec2::new(across, along);
        let distance = away.length();
        let found = || (distance, DVec2::new(away.x / distance, up * away.y / distance));
        return (distance > SHORTEST).then(found);
    }
    Some(if across > along { (across, DVec2::X) } else { (along, DVec2::new(0.0, up)) })
}

/// A cone's half-plane: a triangle of the axis, the base below and the side.
///
/// What lies in a corner's cone of normals is decided by products of the very difference whose direction is returned, so
/// that no point of the core reaches farther along it by more than these products lose.
#[inline(always)]
fn beside_wedge(half_height: f64, radius: f64, seen: DVec2) -> Option<(f64, DVec2)> {
    let side = DVec2::new(-radius, 2.0 * half_height);
    let length = side.length();
    if !(length > SHORTEST) {
        return None;
    }
    let from_rim = DVec2::new(seen.x - radius, seen.y + half_height);
    let from_apex = DVec2::new(seen.x, seen.y - half_height);
    let of_corner = |away: DVec2| {
        let distance = away.length();
        (distance > SHORTEST).then(|| (distance, away / distance))
    };
    if from_rim.dot(side) <= 0.0 {
        if seen.x > radius {
            return of_corner(from_rim);
        }
        // Above the rim of a cone without height the product is 0 too.
        if !(from_rim.y > 0.0) {
            return Some((-from_rim.y, DVec2::NEG_Y));
        }
    }
    if from_apex.dot(side) >= 0.0 {
        return of_corner(from_apex);
    }
    let outward = DVec2::new(side.y, -side.x) / length;
    let to_side = outward.dot(from_rim);
    Some(if to_side >= -from_rim.y { (to_side, outward) } else { (-from_rim.y, DVec2::NEG_Y) })
}

/// Of a sphere and another shape, from the sphere. `None` for other kinds, where f64 says nothing, and at the certified
/// accuracy.
///
/// (a, b) and (b, a) give the same bits, mirrored.
#[inline]
pub(super) fn gap_of(accuracy: Accuracy, a: PosedShape<'_>, b: PosedShape<'_>) -> Option<Gap> {
    gap_and_outward(accuracy, a, b).map(|(gap, _)| gap)
}

/// The same, and where the sphere is from the other shape, in its frame: of unit length.
#[inline]
pub(crate) fn gap_and_outward(
    accuracy: Accuracy,
    a: PosedShape<'_>,
    b: PosedShape<'_>,
) -> Option<(Gap, DVec3)> {
    let most = largest_deviation(accuracy)?;
    let swapped = !is_sphere(a);
    let (sphere, other) = if swapped { (b, a) } else { (a, b) };
    let core = Core::of(other.shape)?;
    let Shape::Polytope(round) = sphere.shape else { return None };
    if round.kind() != Kind::Point || other.pose.deviation() > most {
        return None;
    }
    let seen = Seen::of((round, sphere.pose), other)?;
    let beside = core.beside(seen.place)?;
    // What is proposed by an edge or a face is mostly known as well as f64 knows anything.
    if accuracy == Accuracy::F64 && beside.unsure > UNSURE * UNIT * seen.size {
        return None;
    }
    Some((seen.gap(beside, swapped), beside.outward))
}

/// A sphere in the frame of another shape.
struct Seen<'a> {
    /// Of its centre.
    place: DVec3,
    /// The same in the world.
    centre: DVec3,
    radius: f64,
    /// Round the core of the other.
    swept: f64,
    other: &'a Pose,
    /// Of the pair, at least: metres.
    size: f64,
    /// What the centre's distance from the core may be off by: metres.
    error: f64,
}

impl<'a> Seen<'a> {
    /// `None` where a length is out of range.
    #[inline(always)]
    fn of((sphere, at): (&Polytope, &Pose), other: PosedShape<'a>) -> Option<Self> {
        let middle = *sphere.vertices().first()?;
        let turned = if middle == DVec3::ZERO { middle } else { *at.rotation() * middle };
        let from = (at.translation() - other.pose.translation()) + turned;
        let (reach, swept, lost) = match other.shape {
            Shape::Polytope(polytope) => {
                let is_straight = matches!(polytope.kind(), Kind::Cuboid { .. } | Kind::Segment);
                let lost = if is_straight { STRAIGHT } else { ROUND };
                (polytope.reach(), polytope.swept_radius(), lost)
            }
            Shape::Curved(curved) => {
                (curved.half_height() + curved.radius(), curved.swept_radius(), ROUND)
            }
            Shape::Mesh(mesh) => (mesh.reach(), mesh.swept_radius(), ROUND),
            _ => return None,
        };
        let radius = sphere.swept_radius();
        let size =
            reach + 2.0 * sphere.reach() + (at.translation() - other.pose.translation()).norm1();
        // False for NaN.
        if !(SIZES.contains(&size) && radius + swept < SIZES.end) {
            return None;
        }
        let DMat3 { x_axis, y_axis, z_axis } = other.pose.rotation();
        let place = DVec3::new(x_axis.dot(from), y_axis.dot(from), z_axis.dot(from));
        let error = (lost * UNIT + DEVIATION * other.pose.deviation()) * size;
        let centre = at.translation() + turned;
        Some(Self { place, centre, radius, swept, other: other.pose, size, error })
    }

    /// From the sphere, given where its centre is beside the core.
    #[inline(always)]
    fn gap(&self, beside: Beside, swapped: bool) -> Gap {
        let Beside { distance, outward, unsure } = beside;
        let value = distance - (self.radius + self.swept);
        let error = self.error
            + 4.0 * UNIT * (distance.abs() + self.radius + self.swept)
            + unsure * (1.0 + 4.0 * self.other.deviation());
        let normal = -(*self.other.rotation() * outward);
        let on_sphere = self.centre + normal * self.radius;
        let on_other = on_sphere + normal * value;
        Gap::new((value, error), normal, [on_sphere, on_other], swapped)
    }
}

/// Calls `found` for each triangle of a mesh that touches a sphere, with the depth from the mesh to the sphere, at the
/// accuracy of f32; in an order that depends on the two alone. Those that touch may be known.
/// `None`, and some of them, where f64 leaves one open, and of other shapes.
pub(crate) fn triangles_in_sphere(
    [mesh, sphere]: [PosedShape<'_>; 2],
    touching: Option<impl Iterator<Item = u32>>,
    mut found: impl FnMut(u32, &[DVec3; 3], Depth),
) -> Option<()> {
    let (Shape::Mesh(of_mesh), Shape::Polytope(round)) = (mesh.shape, sphere.shape) else {
        return None;
    };
    if round.kind() != Kind::Point || mesh.pose.deviation() > TURNED {
        return None;
    }
    let seen = Seen::of((round, sphere.pose), mesh)?;
    // More than the centre may be off, and than the sum loses.
    let within = (seen.radius + seen.swept + 4.0 * seen.error) * (1.0 + 8.0 * UNIT);
    let meet = |triangle: u32, corners: &[DVec3; 3], beside: Option<Beside>| {
        match seen.gap(beside?, true).verdict() {
            Verdict::Touching(depth) => found(triangle, corners, depth),
            Verdict::Apart => {}
            Verdict::Undecided(_) => return None,
        }
        Some(())
    };
    match touching {
        Some(touching) => faces::triangles_of(of_mesh, seen.place, touching, meet),
        None => faces::triangles_within(of_mesh, (seen.place, within), meet),
    }
}

#[cfg(test)]
mod tests;
