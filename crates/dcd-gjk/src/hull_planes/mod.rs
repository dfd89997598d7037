//! How deep a solid hull and a capsule or cuboid overlap, rounded or not, by the planes of their cores' difference
//! (docs/numerics/proofs.md, "a hull and a cuboid").

mod features;
mod lanes;
mod round;
mod witness;

use crate::PosedSupport;
use crate::epa::Depth;
use crate::query::{Accuracy, tolerance};
use dcd_geom::glam::{DMat3, DVec3};
use dcd_geom::{Kind, Polytope};
use dcd_simd::{Path, Unfused, dispatch_on};
pub(crate) use features::{HullFeatures, shares};
use lanes::{CuboidPlanes, EDGES, Feature, Planes};
pub(crate) use lanes::{PLANE, PRODUCT, SHORTEST};
pub(crate) use round::Round;

/// Unit roundoff of f32, and of f64.
const U32: f64 = f32::EPSILON as f64 / 2.0;
const U64: f64 = f64::EPSILON / 2.0;

/// Lengths, metres, whose products f32 holds.
const SIZES: std::ops::Range<f64> = 1e-6..1e8;

/// How far poses may be from rotations, both together, for the body's axes to count as square to each other. Larger: false
/// lower bounds. Smaller: more pairs that are searched.
const TURNED: f64 = 1e-9;

/// What the body's corners lose on their way into the hull's frame. Unit: u·m. Derived: 20. Smaller: depths outside their
/// bound.
const PLACED: f64 = 40.0;

/// What the reach along a plane's normal loses. Unit: u of the size and the radii. Smaller: depths outside their bound.
const REACH: f64 = 16.0;

/// What the direction of a product of an edge with an axis loses in f64. Unit: u of the edge's length by the product's.
const LEAN: f64 = 16.0;

/// The depth of a hull and a capsule or cuboid whose cores overlap, from a to b, with a bound as good as f64's. `None` of others,
/// and where the planes do not say.
///
/// (a, b) and (b, a) give the same bits, mirrored.
pub(crate) fn depth([a, b]: [PosedSupport<'_, Polytope>; 2]) -> Option<Depth> {
    let is_body = |kind| matches!(kind, Kind::Segment | Kind::Cuboid { .. });
    match (a.map.kind(), b.map.kind()) {
        (Kind::Hull, other) if is_body(other) => depth_from_hull(a, b),
        (other, Kind::Hull) if is_body(other) => depth_from_hull(b, a).map(Depth::mirrored),
        _ => None,
    }
}

/// From a hull to a capsule or cuboid.
fn depth_from_hull(
    side: PosedSupport<'_, Polytope>,
    at: PosedSupport<'_, Polytope>,
) -> Option<Depth> {
    let placed = Placed::of(side, at)?;
    let (hull, other) = (side.map, at.map);
    let least = placed.least()?;
    let radius = hull.swept_radius() + other.swept_radius();
    let rounding = REACH * U64 * (placed.size + radius);
    let at_least = least.at_least - rounding - placed.hull.rows.normal_error() * placed.size;
    // Of cores that do not meet, the planes do not bound what the radii overlap. Written so that NaN is none.
    if !(at_least > placed.off) {
        return None;
    }
    let reach = placed.reach(least.outward);
    let (at_hull, beside) = placed.witness(least.feature?, least.outward, reach)?;
    let depth = reach + radius;
    let error_bound = (reach - at_least).max(0.0) + placed.off + beside + rounding;
    let turn = side.pose.rotation();
    // Of unit length also where the pose is hardly a rotation: radii may be many times the size.
    let normal = (*turn * least.outward).normalize();
    let at_hull = *turn * (at_hull + hull.inner().centre) + normal * hull.swept_radius();
    let point_a = side.pose.translation() + at_hull;
    let point_b = side.pose.translation() + (at_hull - normal * depth);
    // Not less at f32: where planes leave more open, their directions are worse than what a manifold needs.
    let [relative, of_size] = tolerance(Accuracy::F64);
    // False for NaN.
    let is_good = error_bound <= (relative * depth).max(of_size * placed.size);
    let found = Depth { depth, normal, point_a, point_b, error_bound };
    (is_good && depth.is_finite()).then_some(found)
}

/// The core of a capsule or cuboid in the frame of a hull, from its centre.
struct Placed<'a> {
    hull: HullFeatures<'a>,
    centre: DVec3,
    /// Right-handed, of unit length.
    axes: [DVec3; 3],
    /// 0 along the second and third of a segment.
    half: [f64; 3],
    is_segment: bool,
    /// At least the length of every vector from the one to the other.
    size: f64,
    /// How far the corners may be off, metres.
    off: f64,
}

/// The plane that is nearest to the origin.
struct Least {
    /// Of unit length.
    outward: DVec3,
    feature: Option<Feature>,
    /// How far it is: no plane is nearer.
    at_least: f64,
}

impl Least {
    /// Takes in a plane by its outward normal and its distance; of one without, or of NaN, nothing is known of any.
    fn add(&mut self, feature: Feature, plane: Option<(DVec3, f64)>) {
        let (outward, distance) = plane.unwrap_or((DVec3::ZERO, f64::NEG_INFINITY));
        let distance = distance.max(f64::NEG_INFINITY);
        if distance < self.at_least {
            *self = Self { outward, feature: Some(feature), at_least: distance };
        }
    }
}

impl<'a> Placed<'a> {
    /// `None` of poses that are hardly rotations, and of lengths that f32 does not hold.
    fn of(side: PosedSupport<'a, Polytope>, at: PosedSupport<'_, Polytope>) -> Option<Self> {
        let (hull, other) = (side.map, at.map);
        let features = HullFeatures::of(hull)?;
        features.prefetch();
        let deviation = side.pose.deviation() + at.pose.deviation();
        let back = side.pose.rotation().transpose();
        let turn = back * *at.pose.rotation();
        let delta = at.pose.translation() - side.pose.translation();
        let from = back * delta - hull.inner().centre;
        let (middle, axes, half) = match (other.kind(), other.vertices()) {
            (Kind::Cuboid { half_extents }, _) => (DVec3::ZERO, turn, half_extents),
            (Kind::Segment, &[start, end]) => {
                let along = turn * (end - start);
                let length = along.length();
                let axis = along / length;
                let (second, third) = axis.any_orthonormal_pair();
                let axes = DMat3::from_cols(axis, second, third);
                (turn * ((start + end) * 0.5), axes, DVec3::new(0.5 * length, 0.0, 0.0))
            }
            _ => return None,
        };
        let centre = middle + from;
        let lengths = hull.reach() + other.reach() + delta.length();
        let off = (PLACED * U64 + 4.0 * deviation) * lengths;
        let size = hull.outer_radius() + centre.length() + half.element_sum() + off;
        let is_segment = other.kind() == Kind::Segment;
        // Written so that NaN is none.
        let is_known = deviation <= TURNED && half.x > 0.0 && SIZES.contains(&size);
        if !(is_known && Planes::has_room(features.rows)) {
            return None;
        }
        Some(Self {
            hull: features,
            centre,
            axes: [axes.x_axis, axes.y_axis, axes.z_axis],
            half: half.to_array(),
            is_segment,
            size,
            off,
        })
    }

    /// `None` where it is not known which planes there are.
    fn least(&self) -> Option<Least> {
        let mut planes = Planes::default();
        match self.is_segment {
            true => self.search::<1>(&mut planes),
            false => self.search::<3>(&mut planes),
        }
        let mut least = Least { outward: DVec3::ZERO, feature: None, at_least: f64::INFINITY };
        self.each_side(&planes, |side| least.add(side, self.plane(side)))?;
        let lost = PLANE * U32 * self.size;
        let looked_at = planes.each_near(lost, |plane| least.add(plane, self.plane(plane)));
        // Others may be nearer than the nearest of these. Written so that NaN is.
        if !(least.at_least <= looked_at) {
            let most = ((least.at_least + lost) as f32).next_up();
            planes.each_within(most, |plane| least.add(plane, self.plane(plane)));
        }
        Some(least)
    }

    /// All planes but those of sides, in f32.
    fn search<const AXES: usize>(&self, planes: &mut Planes) {
        let search = CuboidPlanes::<AXES> {
            rows: self.hull.rows,
            centre: self.centre.as_vec3(),
            axes: self.axes.map(|axis| axis.as_vec3()),
            half: self.half.map(|half| half as f32),
            size: self.size,
            planes,
        };
        dispatch_on(Path::best(), Unfused(search));
    }

    /// Hands on the planes that are made of a vertex and a side of the cuboid. `None` where it is not known which there are.
    fn each_side(&self, planes: &Planes, mut found: impl FnMut(Feature)) -> Option<()> {
        let mut ways = [[0; 2]; EDGES.len()];
        for (way, round) in ways.iter_mut().zip(&planes.rounds) {
            *way = round.vertices()?;
        }
        let mut set = ways.as_flattened().iter().fold(0, |set, way| set | way);
        while set != 0 {
            let vertex = set.trailing_zeros() as usize;
            set &= set - 1;
            let times = ways
                .map(|[forth, back]| (forth >> vertex & 1) as i32 - (back >> vertex & 1) as i32);
            for (side, _) in enclosed(times).iter().enumerate().filter(|(_, times)| **times > 0) {
                found(Feature::Side { vertex, axis: side / 2, is_above: side % 2 == 0 });
            }
        }
        Some(())
    }

    /// The outward unit normal of a plane and its distance from the origin.
    fn plane(&self, feature: Feature) -> Option<(DVec3, f64)> {
        match feature {
            Feature::Face { face, is_above } => {
                let (outward, corners) = self.hull.rows.face_polygon(face)?;
                let at = self.hull.vertex(*corners.first()? as usize);
                Some((outward, outward.dot(at - self.corner(is_above))))
            }
            Feature::Side { vertex, axis, is_above } => {
                let outward = if is_above { -self.axes[axis] } else { self.axes[axis] };
                let from = self.hull.vertex(vertex) - self.centre;
                Some((outward, outward.dot(from) + self.half[axis]))
            }
            Feature::Edge { .. } => {
                let [from, along, on, across] = self.edges(feature)?;
                let product = along.cross(across);
                let length = product.length();
                let (outward, sine) = (product / length, length / along.length());
                Some((outward, outward.dot(from - on) - LEAN * U64 * self.size / sine))
            }
        }
    }

    /// An edge of the hull and one of the body: where the one begins and what leads to its end, the middle of the other and
    /// the unit vector along it.
    fn edges(&self, feature: Feature) -> Option<[DVec3; 4]> {
        let Feature::Edge { edge, axis, is_above } = feature else { return None };
        let [from, along] = self.hull.edge(edge)?;
        let across = if is_above[axis] { self.axes[axis] } else { -self.axes[axis] };
        Some([from, along, self.corner(is_above) - across * self.half[axis], across])
    }

    /// The corner that is on those sides of the middle.
    fn corner(&self, is_above: [bool; 3]) -> DVec3 {
        let mut at = self.centre;
        for (k, is_above) in is_above.into_iter().enumerate() {
            at += self.axes[k] * if is_above { self.half[k] } else { -self.half[k] };
        }
        at
    }

    /// The corner of the body that is lowest along a direction.
    fn lowest(&self, direction: DVec3) -> DVec3 {
        let mut at = self.centre;
        for (axis, half) in self.axes.iter().zip(self.half) {
            at -= *axis * half.copysign(direction.dot(*axis));
        }
        at
    }

    /// How far the two reach past each other where the hull leaves along a direction.
    fn reach(&self, outward: DVec3) -> f64 {
        self.hull.reach(outward) - outward.dot(self.lowest(outward))
    }
}

/// How often the lowest corner goes round the sides of a cuboid, above and below along each axis, by how often it goes along
/// [`EDGES`]: the least is 0.
///
/// A side is gone round once more than its neighbour across an edge if the way takes the edge once more in the sense that has
/// that side to its left.
fn enclosed([first, second, third, fourth, last]: [i32; 5]) -> [i32; 6] {
    let above = -first;
    let times = [0, above - last, above, second, third, -fourth];
    let least = times.into_iter().fold(0, i32::min);
    times.map(|times| times - least)
}

#[cfg(test)]
mod tests;
