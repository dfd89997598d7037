//! The convex hull of a point cloud, from Parry, believed only after a check.

use crate::CloudKind;
use glam::DVec3;
use parry3d_f64::transformation::try_convex_hull;
use std::collections::HashMap;
use std::fmt;
use std::panic::catch_unwind;

/// More points than this are not handed to the library: it recurses over the facets that a point
/// sees, and a stack that runs out cannot be caught.
const MOST_POINTS: usize = 4096;

/// The smallest and largest extent of a cloud, metres, that the library is asked about: beyond
/// them its squares and triple products leave the range of f64.
const EXTENTS: std::ops::RangeInclusive<f64> = 1e-90..=1e90;

/// How far a point of the cloud may lie beyond a facet's plane. No unit: times the cloud's largest
/// extent. Above what the library itself decides by (100 ε on a cloud that it scales to between 1
/// and 50), so that it rejects wrong hulls, not rounded ones. Larger: points of the cloud are lost.
const OUTSIDE: f64 = 1e-12;

/// What the triple product of three vectors of the cloud's extent may be wrong by. No unit: times
/// the extent cubed; some ten roundings of 2⁻⁵³. It matters for slivers, whose plane is noise.
const VOLUME_ROUNDING: f64 = 16.0 * f64::EPSILON;

/// A hull: the shape is by definition the hull of these vertices.
#[derive(Clone, Debug, PartialEq)]
pub struct Hull {
    /// The cloud's points that are kept, each once, bit for bit and in the cloud's order.
    pub vertices: Vec<DVec3>,
    /// The surface, closed, counter-clockwise seen from outside, by index into `vertices`.
    pub triangles: Vec<[u32; 3]>,
}

/// Why a cloud has no hull here and stays a point set, which is a legal shape.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum HullRefusal {
    /// It is empty, or holds NaN or infinity.
    Invalid,
    /// It has no volume, or next to none.
    NotSolid(CloudKind),
    /// It has more points than the library can be trusted with.
    TooManyPoints {
        /// How many.
        count: usize,
    },
    /// It is too small or too large, in metres, for the library's arithmetic.
    OutOfRange,
    /// The library said no.
    Library(String),
    /// The library gave a hull that is not closed, has other vertices than the cloud, or leaves a
    /// point of the cloud outside.
    Unsound {
        /// Which of these.
        what: &'static str,
    },
}

impl fmt::Display for HullRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Invalid => write!(f, "the cloud is empty or not finite"),
            Self::NotSolid(kind) => write!(f, "the cloud has no volume: {kind:?}"),
            Self::TooManyPoints { count } => {
                write!(f, "{count} points are more than {MOST_POINTS}")
            }
            Self::OutOfRange => write!(f, "the cloud is too small or too large"),
            Self::Library(reason) => write!(f, "the hull library refuses: {reason}"),
            Self::Unsound { what } => write!(f, "the hull library's answer is unsound: {what}"),
        }
    }
}

impl std::error::Error for HullRefusal {}

/// The convex hull of a cloud, its inner points dropped.
///
/// A point may be dropped that lies outside of the kept ones' hull by at most 1e-12 of the cloud's
/// extent. Costs tens of microseconds for a hundred points, and grows as points times facets.
///
/// # Errors
/// A cloud without volume, out of range, or whose hull the library refuses or gets wrong.
pub fn convex_hull(points: &[DVec3]) -> Result<Hull, HullRefusal> {
    let extent = check_cloud(points)?;
    // The library asserts its own invariants, which no check beforehand can foresee. Catching is
    // the last resort: it prints the panic's message, and does nothing where panics abort.
    let found = catch_unwind(|| try_convex_hull(points))
        .map_err(|_| HullRefusal::Library("it panicked".into()))?;
    let (vertices, triangles) = found.map_err(|error| HullRefusal::Library(error.to_string()))?;
    let hull = in_cloud_order(points, &vertices, &triangles)?;
    check_closed(&hull.triangles)?;
    check_convex(&hull, points, extent)?;
    Ok(hull)
}

/// The cloud's largest extent along an axis, if the library may be asked about it.
fn check_cloud(points: &[DVec3]) -> Result<f64, HullRefusal> {
    match CloudKind::of(points) {
        None => return Err(HullRefusal::Invalid),
        Some(CloudKind::Solid) => {}
        Some(kind) => return Err(HullRefusal::NotSolid(kind)),
    }
    if points.len() > MOST_POINTS {
        return Err(HullRefusal::TooManyPoints { count: points.len() });
    }
    let min = points.iter().fold(DVec3::INFINITY, |m, &p| m.min(p));
    let max = points.iter().fold(DVec3::NEG_INFINITY, |m, &p| m.max(p));
    let extent = (max - min).max_element();
    if EXTENTS.contains(&extent) { Ok(extent) } else { Err(HullRefusal::OutOfRange) }
}

/// The library's hull with its vertices in the cloud's order, so that only their set depends on
/// the library.
fn in_cloud_order(
    points: &[DVec3],
    vertices: &[DVec3],
    triangles: &[[u32; 3]],
) -> Result<Hull, HullRefusal> {
    let bits = |p: &DVec3| p.to_array().map(f64::to_bits);
    let mut position = HashMap::with_capacity(points.len());
    for (index, point) in points.iter().enumerate() {
        position.entry(bits(point)).or_insert(index);
    }
    let known = |vertex| position.get(&bits(vertex)).copied();
    let foreign = HullRefusal::Unsound { what: "a vertex is not in the cloud" };
    let from = vertices.iter().map(known).collect::<Option<Vec<_>>>().ok_or(foreign)?;
    let mut kept = from.clone();
    kept.sort_unstable();
    kept.dedup();
    let repeated = HullRefusal::Unsound { what: "a vertex occurs twice" };
    if kept.len() != from.len() {
        return Err(repeated);
    }
    let renamed = |&corner: &u32| {
        let index = from.get(corner as usize)?;
        Some(kept.binary_search(index).ok()? as u32)
    };
    let triangles = triangles.iter().map(|triangle| {
        let [a, b, c] = triangle;
        Some([renamed(a)?, renamed(b)?, renamed(c)?])
    });
    let missing = HullRefusal::Unsound { what: "a triangle names a vertex that is not there" };
    let triangles = triangles.collect::<Option<Vec<_>>>().ok_or(missing)?;
    Ok(Hull { vertices: kept.into_iter().map(|index| points[index]).collect(), triangles })
}

/// That each directed edge occurs once, and its reverse once.
fn check_closed(triangles: &[[u32; 3]]) -> Result<(), HullRefusal> {
    let edges = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    let mut edges: Vec<_> = edges.collect();
    edges.sort_unstable();
    let once = edges.windows(2).all(|pair| pair[0] != pair[1]);
    let closed = edges.iter().all(|&[a, b]| edges.binary_search(&[b, a]).is_ok());
    if triangles.len() >= 4 && once && closed {
        Ok(())
    } else {
        Err(HullRefusal::Unsound { what: "its surface is not closed" })
    }
}

/// That no point of the cloud lies outside of any facet's plane.
fn check_convex(hull: &Hull, points: &[DVec3], extent: f64) -> Result<(), HullRefusal> {
    for triangle in &hull.triangles {
        let [a, b, c] = triangle.map(|corner| hull.vertices[corner as usize]);
        let normal = (b - a).cross(c - a);
        let most = OUTSIDE * extent * normal.length() + VOLUME_ROUNDING * extent.powi(3);
        // Written so that NaN is refused.
        if !points.iter().all(|&p| normal.dot(p - a) <= most) {
            return Err(HullRefusal::Unsound { what: "a point of the cloud is left outside" });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(n: u32) -> Vec<DVec3> {
        (0..n * n * n)
            .map(|k| DVec3::new((k % n).into(), (k / n % n).into(), (k / n / n).into()))
            .collect()
    }

    #[test]
    fn a_cube_with_points_inside_keeps_its_corners_in_order() {
        let mut cloud = grid(2);
        cloud.insert(3, DVec3::splat(0.5));
        cloud.push(cloud[2]);
        let hull = convex_hull(&cloud).unwrap();
        assert_eq!(hull.vertices, grid(2));
        assert_eq!(hull.triangles.len(), 12);
    }

    #[test]
    fn the_surface_looks_outward() {
        let cloud = grid(2);
        let hull = convex_hull(&cloud).unwrap();
        let volume: f64 = hull
            .triangles
            .iter()
            .map(|t| t.map(|k| hull.vertices[k as usize]))
            .map(|[a, b, c]| a.dot(b.cross(c)) / 6.0)
            .sum();
        assert!((volume - 1.0).abs() < 1e-15);
    }

    #[test]
    fn clouds_without_volume_are_refused_with_their_kind() {
        let flat: Vec<_> = grid(3).into_iter().map(|p| p * DVec3::new(1.0, 1.0, 0.0)).collect();
        let needle: Vec<_> = (0..7).map(|k| DVec3::new(0.3, 0.1, -0.7) * f64::from(k)).collect();
        for (cloud, kind) in [
            (flat, CloudKind::Flat),
            (needle, CloudKind::Needle),
            (vec![DVec3::ONE; 9], CloudKind::Point),
        ] {
            assert_eq!(convex_hull(&cloud), Err(HullRefusal::NotSolid(kind)));
        }
    }

    #[test]
    fn invalid_huge_and_tiny_clouds_are_refused() {
        assert_eq!(convex_hull(&[]), Err(HullRefusal::Invalid));
        assert_eq!(convex_hull(&[DVec3::NAN; 5]), Err(HullRefusal::Invalid));
        for scale in [1e-200, 1e-100, 1e100, 1e308] {
            let cloud: Vec<_> = grid(2).into_iter().map(|p| p * scale).collect();
            assert_eq!(convex_hull(&cloud), Err(HullRefusal::OutOfRange), "{scale}");
        }
        assert_eq!(convex_hull(&grid(17)), Err(HullRefusal::TooManyPoints { count: 4913 }));
    }

    #[test]
    fn a_slab_too_thin_for_the_library_stays_whole_or_is_refused() {
        // The library takes this for flat and would lose one side.
        for thickness in [1e-2, 1e-3, 1e-4, 1e-5] {
            let flatten = DVec3::new(1.0, 1.0, thickness);
            let cloud: Vec<_> = grid(2).into_iter().map(|p| p * flatten).collect();
            match convex_hull(&cloud) {
                Ok(hull) => assert_eq!(hull.vertices, cloud),
                Err(refusal) => {
                    assert!(matches!(refusal, HullRefusal::Unsound { .. }), "{refusal}")
                }
            }
        }
    }

    #[test]
    fn a_surface_with_a_hole_or_a_lost_point_is_unsound() {
        let cloud = grid(2);
        let mut hull = convex_hull(&cloud).unwrap();
        let mut with_spike = cloud.clone();
        with_spike.push(DVec3::new(0.5, 0.5, 1.001));
        assert!(check_convex(&hull, &cloud, 1.0).is_ok());
        assert!(check_convex(&hull, &with_spike, 1.0).is_err());
        hull.triangles.pop();
        assert!(check_closed(&hull.triangles).is_err());
        assert!(in_cloud_order(&cloud[1..], &cloud, &hull.triangles).is_err());
        assert!(in_cloud_order(&cloud, &cloud, &[[0, 1, 8]]).is_err());
    }
}
