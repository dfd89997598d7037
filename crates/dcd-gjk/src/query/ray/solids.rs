//! Where a line enters and leaves spheres, capsules, boxes and cylinders. Each is given as large as it is to be
//! taken; below 0 it is empty.

use super::local::{Chord, LocalRay};
use dcd_geom::glam::{DVec2, DVec3};
use dcd_geom::{Curved, CurvedKind};

/// The result of a closed form for a shape that may have none.
pub(super) enum Outcome {
    /// Proved: no common point.
    Missed,
    /// The chord.
    Met(Chord),
    /// There is no form for it.
    Unknown,
}

/// By the distance of the centre from the line, so that nothing cancels.
pub(super) fn sphere(ray: &LocalRay, centre: DVec3, radius: f64) -> Option<Chord> {
    let to_centre = centre - ray.origin;
    let a = ray.direction.length_squared();
    let b = to_centre.dot(ray.direction);
    let off = to_centre.cross(ray.direction).length_squared();
    let under = radius * radius * a - off;
    // Written so that NaN is no miss.
    if radius < 0.0 || under < 0.0 {
        return None;
    }
    let half = under.sqrt();
    let enter = (b - half) / a;
    Some(Chord { enter, leave: (b + half) / a, normal: ray.at(enter) - centre, facet: None })
}

/// A sphere swept along a segment.
pub(super) fn capsule(ray: &LocalRay, ends: [DVec3; 2], radius: f64) -> Option<Chord> {
    let [from, to] = ends;
    let mut all: Option<Chord> = None;
    let mut take = |chord: Option<Chord>| {
        all = match (all, chord) {
            (Some(all), Some(chord)) => {
                let first = if chord.enter < all.enter { chord } else { all };
                Some(Chord { leave: all.leave.max(chord.leave), ..first })
            }
            (all, chord) => all.or(chord),
        };
    };
    take(sphere(ray, from, radius));
    take(sphere(ray, to, radius));
    let length = (to - from).length();
    if length > 0.0 && radius >= 0.0 {
        let axis = (to - from) / length;
        let start = ray.origin - from;
        let (height, rise) = (axis.dot(start), axis.dot(ray.direction));
        let (across, drift) = (start - axis * height, ray.direction - axis * rise);
        let off = across.cross(drift).length_squared();
        let round = circle(
            [across.dot(drift), drift.length_squared(), off, across.length_squared()],
            radius,
        );
        let side = round.and_then(|chord| chord.and(between(height, rise, [0.0, length], axis)?));
        take(side.map(|chord| {
            let point = ray.at(chord.enter) - from;
            Chord { normal: point - axis * axis.dot(point), ..chord }
        }));
    }
    all
}

/// Where a point of a plane is within a circle round the origin, by what it is made of: start · drift, |drift|²,
/// |start × drift|², |start|². Without a normal.
fn circle([b, a, off, start]: [f64; 4], radius: f64) -> Option<Chord> {
    if a == 0.0 {
        return (start <= radius * radius).then_some(Chord::LINE);
    }
    let under = radius * radius * a - off;
    if under < 0.0 {
        return None;
    }
    let half = under.sqrt();
    Some(Chord { enter: (-b - half) / a, leave: (-b + half) / a, ..Chord::LINE })
}

/// Where a coordinate that rises like that is between two values.
fn between(at: f64, rise: f64, [low, high]: [f64; 2], axis: DVec3) -> Option<Chord> {
    if rise == 0.0 {
        return (low <= at && at <= high).then_some(Chord::LINE);
    }
    let (s, t) = ((low - at) / rise, (high - at) / rise);
    let (enter, leave) = if rise > 0.0 { (s, t) } else { (t, s) };
    Some(Chord { enter, leave, normal: axis * -rise.signum(), facet: None })
}

/// A box round the origin.
pub(super) fn cuboid(ray: &LocalRay, half: DVec3) -> Option<Chord> {
    if half.min_element() < 0.0 {
        return None;
    }
    let slab =
        |k: usize, axis: DVec3| between(ray.origin[k], ray.direction[k], [-half[k], half[k]], axis);
    slab(0, DVec3::X)?.and(slab(1, DVec3::Y)?)?.and(slab(2, DVec3::Z)?)
}

/// A cylinder grown by a length at its side and both ends.
pub(super) fn curved(ray: &LocalRay, curved: &Curved, grown: f64) -> Outcome {
    if curved.kind() != CurvedKind::Cylinder {
        return Outcome::Unknown;
    }
    let (radius, height) = (curved.radius() + grown, curved.half_height() + grown);
    if radius < 0.0 || height < 0.0 {
        return Outcome::Missed;
    }
    let (across, drift) = (ray.origin.truncate(), ray.direction.truncate());
    let off = across.perp_dot(drift);
    let round = circle(
        [across.dot(drift), drift.length_squared(), off * off, across.length_squared()],
        radius,
    );
    let side = round.map(|chord| {
        let DVec2 { x, y } = across + drift * chord.enter;
        Chord { normal: DVec3::new(x, y, 0.0), ..chord }
    });
    let ends = between(ray.origin.z, ray.direction.z, [-height, height], DVec3::Z);
    match side.and_then(|side| side.and(ends?)) {
        Some(chord) => Outcome::Met(chord),
        None => Outcome::Missed,
    }
}
