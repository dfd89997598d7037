//! The direction between two features, by what they are and not by two points of them.
//!
//! Of two points that all but meet the difference is rounding, and both shapes may reach far beyond them along it. But the nearest
//! features of two shapes have a common normal: square to the edges, sides and rims on which the points are. It too is a proposal,
//! which the pair's own bounds prove.

use dcd_geom::glam::{DMat3, DVec3};

/// The least sine of two tangents that span a plane. No unit. Larger: lines that cross, taken for parallel. Smaller: planes that
/// are rounding.
const CROSSING: f64 = 1e-9;

/// What a difference of two points is off by: below, its side of a plane is not known. Unit: u of the pair's size. Smaller: normals
/// that point the wrong way. Larger: a support more.
const UNSURE: f64 = 64.0;

/// How long the difference of two points may be for its direction to be less than the features' own. Unit: the pair's size: a
/// thousandth, where rounding turns it by some ten thousand u. Larger: normals that are not needed. Smaller: wider bounds.
pub(crate) const HARDLY_APART: f64 = 1e-3;

/// How far two points may be beside each other, seen along a normal that is proposed for them: what rounding leaves of nearest ones.
/// Unit: u of the pair's size. Larger: points that are not as far apart as is said. Smaller: normals that are not taken.
pub(crate) const ASIDE: f64 = 128.0;

/// Along one feature, of any length; zeros where there are fewer.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Tangents {
    /// Along an edge, up a side, or of a plane.
    pub(crate) straight: [DVec3; 2],
    /// Round an axis: there a normal that is turned a little costs its square.
    pub(crate) round: DVec3,
}

impl Tangents {
    /// The same in another frame.
    pub(crate) fn turned(self, turn: DMat3) -> Self {
        Self { straight: self.straight.map(|tangent| turn * tangent), round: turn * self.round }
    }
}

/// Directions, of unit length, that may be the common normal of two features with a point of each, of which `between` is the
/// difference; the likeliest first. Both ways where rounding leaves that open.
pub(crate) fn normals(
    between: DVec3,
    size: f64,
    [one, other]: [Tangents; 2],
) -> impl Iterator<Item = DVec3> {
    let of_one = square_to(between, one, other);
    let of_other = square_to(between, other, one).filter(|normal| of_one != Some(*normal));
    let unsure = UNSURE * (f64::EPSILON / 2.0) * size;
    [of_one, of_other].into_iter().flatten().flat_map(move |normal| {
        let is_known = normal.dot(between) > unsure;
        [Some(normal), (!is_known).then_some(-normal)].into_iter().flatten()
    })
}

/// The part of a vector that is square to the tangents, of unit length. Those of the first feature count first, and none that is
/// in the span of those before.
fn square_to(between: DVec3, first: Tangents, second: Tangents) -> Option<DVec3> {
    let [a, b] = first.straight;
    let [c, d] = second.straight;
    let mut tangents =
        [a, b, c, d, first.round, second.round].into_iter().filter_map(DVec3::try_normalize);
    let Some(along) = tangents.next() else { return between.try_normalize() };
    for tangent in tangents {
        let across = tangent - along * along.dot(tangent);
        if across.length_squared() > CROSSING * CROSSING {
            // Once more: what is left of a tangent nearly along the other is off by as much of it.
            let across = across.normalize();
            let across = across - along * along.dot(across);
            let normal = along.cross(across).normalize();
            return Some(if normal.dot(between) < 0.0 { -normal } else { normal });
        }
    }
    (between - along * along.dot(between)).try_normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::tests::Draw;

    fn straight(one: DVec3, other: DVec3) -> Tangents {
        Tangents { straight: [one, other], round: DVec3::ZERO }
    }

    #[test]
    fn the_normal_of_two_lines_is_square_to_both_however_little_they_cross() {
        let mut draw = Draw(5);
        for k in 0..2000 {
            let turn = 10f64.powi(-(k % 8));
            let [along, aside, between] = [0; 3].map(|_| draw.vector());
            let other = along + aside * turn;
            let lines = [straight(along, DVec3::ZERO), straight(other, DVec3::ZERO)];
            let found: Vec<_> = normals(between, 1e-3, lines).collect();
            assert!(!found.is_empty(), "{k}");
            for normal in found {
                assert!((normal.length() - 1.0).abs() < 1e-15, "{k}");
                let off = normal.dot(along).abs().max(normal.dot(other).abs());
                assert!(off < 4e-15, "{k}: {off:e}");
                assert!(normal.dot(between) > 0.0, "{k}");
            }
        }
    }

    #[test]
    fn a_plane_has_its_normal_and_a_line_that_of_its_nearest_points_and_what_is_on_neither_side_has_both()
     {
        let plane = straight(DVec3::X, DVec3::Y);
        let none = Tangents::default();
        let of = |between, tangents| normals(between, 1.0, tangents).collect::<Vec<_>>();
        let slanted = DVec3::new(0.3, -0.4, -1.2);
        assert_eq!(of(slanted, [plane, none]), [DVec3::NEG_Z]);
        assert_eq!(of(slanted, [none, plane]), [DVec3::NEG_Z]);
        assert_eq!(of(slanted, [none, none]), [slanted.normalize()]);
        let line = Tangents { round: DVec3::X, ..none };
        assert_eq!(of(slanted, [line, none]), [DVec3::new(0.0, -0.4, -1.2).normalize()]);
        assert_eq!(of(slanted * 1e-17, [plane, none]), [DVec3::NEG_Z, DVec3::Z]);
        assert_eq!(of(DVec3::ZERO, [none, none]), []);
    }
}
