//! What a point cloud spans.

use glam::DVec3;
use std::fmt;

/// How thin a cloud may be and still count as having no thickness. No unit: times the cloud's
/// largest extent along an axis. Larger than the rounding of f32 data about its own size (2⁻²⁴),
/// far below anything that was modelled. Names and counts depend on it, answers never do.
const THINNESS: f64 = 1e-6;

/// What a cloud spans.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CloudKind {
    /// All points are at one place, exactly.
    Point,
    /// Collinear: no point is farther than 1e-6 of the cloud's extent from its longest line.
    Needle,
    /// Coplanar: no point is farther than 1e-6 of the cloud's extent from its widest plane.
    Flat,
    /// It has a volume.
    Solid,
}

impl CloudKind {
    /// Classifies a cloud; none if it is empty or holds a number that is not finite.
    ///
    /// The line goes through the two points found by walking to the farthest twice, the plane
    /// through them and the point farthest from the line: within a factor of two of the best ones.
    pub fn of(points: &[DVec3]) -> Option<Self> {
        let origin = *points.first()?;
        if !points.iter().all(|p| p.is_finite()) {
            return None;
        }
        // Halved, so that the difference of two finite numbers is finite.
        let half = |p: DVec3| p * 0.5 - origin * 0.5;
        let extent = points.iter().fold(0.0, |m: f64, &p| m.max(half(p).abs().max_element()));
        if extent == 0.0 {
            return Some(Self::Point);
        }
        let units: Vec<DVec3> = points.iter().map(|&p| half(p) / extent).collect();
        let (_, a) = farthest(&units, |p| p.length());
        let (length, b) = farthest(&units, |p| p.distance(a));
        let along = (b - a) / length;
        let (width, c) = farthest(&units, |p| (p - a).cross(along).length());
        if width <= THINNESS {
            return Some(Self::Needle);
        }
        let across = along.cross(c - a).normalize_or_zero();
        let (thickness, _) = farthest(&units, |p| across.dot(p - a).abs());
        Some(if thickness <= THINNESS { Self::Flat } else { Self::Solid })
    }
}

/// The first of the points that are farthest, and how far it is.
fn farthest(points: &[DVec3], distance: impl Fn(DVec3) -> f64) -> (f64, DVec3) {
    let far = points.iter().map(|&p| (distance(p), p));
    far.fold((0.0, DVec3::ZERO), |best, next| if next.0 > best.0 { next } else { best })
}

/// How many clouds are of each kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CloudCensus {
    /// Clouds with a volume.
    pub solid: usize,
    /// Coplanar ones.
    pub flat: usize,
    /// Collinear ones.
    pub needles: usize,
    /// Single places.
    pub points: usize,
    /// Empty ones, and those that hold NaN or infinity: no shape at all.
    pub invalid: usize,
    /// How many of the solid ones have no hull, so that they stay point sets: numbers too far apart.
    pub refused: usize,
}

impl CloudCensus {
    /// Counts.
    pub fn of<'a>(clouds: impl IntoIterator<Item = &'a [DVec3]>) -> Self {
        let mut census = Self::default();
        for cloud in clouds {
            let slot = match CloudKind::of(cloud) {
                Some(CloudKind::Solid) => &mut census.solid,
                Some(CloudKind::Flat) => &mut census.flat,
                Some(CloudKind::Needle) => &mut census.needles,
                Some(CloudKind::Point) => &mut census.points,
                None => &mut census.invalid,
            };
            *slot += 1;
            if CloudKind::of(cloud) == Some(CloudKind::Solid) && crate::convex_hull(cloud).is_err()
            {
                census.refused += 1;
            }
        }
        census
    }
}

impl fmt::Display for CloudCensus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { solid, flat, needles, points, invalid, refused } = self;
        write!(
            f,
            "{solid} solid ({refused} kept as point sets), {flat} flat, {needles} needle-like, \
             {points} single points, {invalid} invalid"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line() -> Vec<DVec3> {
        (0..9).map(|k| DVec3::new(0.1, -0.7, 0.3) * f64::from(k) + DVec3::splat(5.0)).collect()
    }

    #[test]
    fn each_kind_is_distinguished_at_any_scale() {
        let mut flat = line();
        flat.push(DVec3::new(9.0, 1.0, 2.0));
        let mut solid = flat.clone();
        solid.push(DVec3::new(-3.0, 0.0, 8.0));
        for scale in [1e-300, 1e-9, 1.0, 1e9, 1e300] {
            let kind = |points: &[DVec3]| {
                CloudKind::of(&points.iter().map(|&p| p * scale).collect::<Vec<_>>())
            };
            assert_eq!(kind(&[DVec3::ONE; 5]), Some(CloudKind::Point));
            assert_eq!(kind(&line()), Some(CloudKind::Needle));
            assert_eq!(kind(&flat), Some(CloudKind::Flat));
            assert_eq!(kind(&solid), Some(CloudKind::Solid));
        }
    }

    #[test]
    fn two_points_are_a_needle_and_three_are_flat() {
        assert_eq!(CloudKind::of(&[DVec3::ZERO, DVec3::X]), Some(CloudKind::Needle));
        assert_eq!(CloudKind::of(&[DVec3::ZERO, DVec3::X, DVec3::Y]), Some(CloudKind::Flat));
        let wide = [DVec3::splat(-f64::MAX), DVec3::splat(f64::MAX)];
        assert_eq!(CloudKind::of(&wide), Some(CloudKind::Needle));
    }

    #[test]
    fn an_empty_or_infinite_cloud_has_no_kind() {
        assert_eq!(CloudKind::of(&[]), None);
        assert_eq!(CloudKind::of(&[DVec3::ZERO, DVec3::NAN]), None);
        let clouds = [vec![], vec![DVec3::ONE], line()];
        let census = CloudCensus::of(clouds.iter().map(Vec::as_slice));
        let expected = CloudCensus { invalid: 1, points: 1, needles: 1, ..Default::default() };
        assert_eq!(census, expected);
    }
}
