//! Hulls inside cylinders, cones and ellipsoids: what the lanes take in their place, with how much they leave out.

use dcd_geom::glam::DVec3;
use dcd_geom::{Curved, CurvedKind, Ellipsoid, Facets, ObbBounds, Sphere};
use std::f64::consts::{FRAC_1_SQRT_2, PI};
use std::sync::LazyLock;

/// The hull of some points of a curved shape's core.
#[derive(Clone, Debug)]
pub(super) struct Inscribed {
    /// All of them in the core.
    pub(super) vertices: Vec<DVec3>,
    /// How much farther the core reaches than the hull, at most, in any direction; metres.
    pub(super) excess: f64,
    /// The core's inner sphere.
    pub(super) inner: Sphere,
    /// The radius of a sphere round that one's centre that holds the core, rounded up.
    pub(super) outer: f64,
    /// A bound on how far any point of the core is from its frame's origin.
    pub(super) reach: f64,
    /// Of the core itself.
    pub(super) obb: Option<ObbBounds>,
}

/// How many corners stand for each of a cylinder's rims: three blocks of sixteen in all. More: each
/// support costs more. Fewer: more pairs are left to f64, for n corners leave out π²/2n² of the
/// radius (24: a hundredth). 16 and 32 measured no faster.
const CYLINDER_CORNERS: u32 = 24;

/// The same for a cone's one: with the apex two blocks.
const CONE_CORNERS: u32 = 31;

/// What a corner is drawn inwards by, relative to the radius: four times what the rounding of its
/// angle's sine and cosine and of two products may take it outwards.
const INWARDS: f64 = 16.0 * f64::EPSILON;

impl Inscribed {
    /// Of a cylinder or a cone.
    pub(super) fn of(curved: &Curved) -> Self {
        let corners = match curved.kind() {
            CurvedKind::Cylinder => CYLINDER_CORNERS,
            _ => CONE_CORNERS,
        };
        let turns: &[[f64; 2]] = match curved.kind() {
            CurvedKind::Cylinder => &CYLINDER_TURNS,
            _ => &CONE_TURNS,
        };
        let rims = curved.discs().map(|(z, radius)| match radius {
            0.0 => vec![DVec3::Z * z],
            _ => turns.iter().map(|&turn| corner(radius, turn, z)).collect(),
        });
        let inner = curved.inner();
        let outer = outer_radius(curved, inner.centre.z);
        // A regular polygon's sides are cos(π/n) of the radius from its middle. The last term is
        // for its corners, which are drawn inwards, and for what they are off by.
        let share = 1.0 - (PI / f64::from(corners)).cos();
        let excess = curved.radius() * (share + 4.0 * INWARDS);
        let obb = obb(curved, (inner, outer));
        Self { vertices: rims.concat(), excess, inner, outer, reach: curved.reach(), obb }
    }

    /// Of an ellipsoid: the points of a ball, stretched as it is.
    pub(super) fn of_ellipsoid(ellipsoid: &Ellipsoid) -> Self {
        let half_axes = ellipsoid.half_axes();
        let longest = half_axes.max_element();
        // In a direction d the ellipsoid reaches |A·d| and the hull at least the ball's share of that. The last term
        // is for what stretching rounds.
        let excess = longest * (1.0 - BALL.share + 4.0 * INWARDS);
        let inner = ellipsoid.inner();
        // The corners of the box inside: three equal terms of 1/3 in the ellipsoid's equation.
        let inside = half_axes * (FRAC_1_SQRT_3 * (1.0 - 4.0 * f64::EPSILON));
        let obb = ObbBounds::axis_aligned(half_axes, inside, (inner.radius, longest));
        let vertices = BALL.points.iter().map(|&point| half_axes * point).collect();
        Self { vertices, excess, inner, outer: longest, reach: ellipsoid.reach(), obb }
    }
}

/// Points of the unit ball, near its surface, and the radius of a ball round the origin that their hull holds.
struct Ball {
    points: Vec<DVec3>,
    share: f64,
}

/// 1/√3.
const FRAC_1_SQRT_3: f64 = 0.577_350_269_189_625_8;

/// What the ball's share is smaller than the least distance of its hull's planes that f64 finds: they are within
/// [`dcd_geom::FLATNESS`] of their corners. No unit.
const PLANES: f64 = 1e-8;

/// The corners of an icosahedron and the middles of its edges, 42 points, three blocks of sixteen: a ball of 0.93 is
/// inside. The next finer ones, 92 and 162, would cost twice and four times as much a support.
static BALL: LazyLock<Ball> = LazyLock::new(|| {
    let golden = 0.5 + 0.5 * 5f64.sqrt();
    let signs = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
    let corners: Vec<DVec3> = signs
        .into_iter()
        .flat_map(|(s, t)| {
            let [x, y, z] = [0.0, s, t * golden];
            [DVec3::new(x, y, z), DVec3::new(z, x, y), DVec3::new(y, z, x)]
        })
        .collect();
    // Edges are 2 long; the next shortest way between corners is longer than 3.
    let edges = corners.iter().enumerate().flat_map(|(k, &a)| {
        let rest = corners[k + 1..].iter();
        rest.filter(move |b| a.distance_squared(**b) < 6.0).map(move |&b| a + b)
    });
    let all = corners.iter().copied().chain(edges);
    let points: Vec<DVec3> = all.map(|point| point.normalize() * (1.0 - INWARDS)).collect();
    let facets = Facets::of(&points);
    let distance =
        |facet| facets.corners(facet).iter().map(|&k| facet.normal.dot(points[k as usize]));
    let nearest = facets.facets().iter().flat_map(distance).fold(1.0, f64::min);
    Ball { points, share: nearest - PLANES }
});

/// The sines and cosines of the corners of a cylinder's rims: they cost more than all else of it.
static CYLINDER_TURNS: LazyLock<Vec<[f64; 2]>> = LazyLock::new(|| turns(CYLINDER_CORNERS));

/// The same of a cone's.
static CONE_TURNS: LazyLock<Vec<[f64; 2]>> = LazyLock::new(|| turns(CONE_CORNERS));

fn turns(corners: u32) -> Vec<[f64; 2]> {
    let turn = |k: u32| (2.0 * PI * (f64::from(k) / f64::from(corners))).sin_cos();
    (0..corners).map(turn).map(Into::into).collect()
}

/// The point of a rim in a direction by its sine and cosine.
fn corner(radius: f64, [sine, cosine]: [f64; 2], z: f64) -> DVec3 {
    let within = radius * (1.0 - INWARDS);
    DVec3::new(within * cosine, within * sine, z)
}

/// The distance of the farthest point of both discs from the point of the axis at height z.
fn outer_radius(curved: &Curved, z: f64) -> f64 {
    let farthest = curved.discs().map(|(height, radius)| (height - z).hypot(radius));
    farthest[0].max(farthest[1]) * (1.0 + 8.0 * f64::EPSILON)
}

/// A box round it and, for a cylinder, one inside, where spheres are loose.
fn obb(curved: &Curved, (inner, outer): (Sphere, f64)) -> Option<ObbBounds> {
    let radius = curved.radius();
    let reach = curved.half_height() + inner.centre.z.abs();
    let around = DVec3::new(radius, radius, reach * (1.0 + 4.0 * f64::EPSILON));
    let square = radius * FRAC_1_SQRT_2 * (1.0 - 4.0 * f64::EPSILON);
    let inside = match curved.kind() {
        CurvedKind::Cylinder => DVec3::new(square, square, curved.half_height()),
        _ => DVec3::ZERO,
    };
    ObbBounds::axis_aligned(around, inside, (inner.radius, outer))
}

#[cfg(test)]
mod tests {
    use super::*;
    use dcd_geom::SupportMap;

    /// Directions all over the sphere, and along and across the axis.
    fn directions() -> impl Iterator<Item = DVec3> {
        let spiral = (0..2000).map(|k| {
            let z = 1.0 - (f64::from(k) + 0.5) / 1000.0;
            let (sine, cosine) = (f64::from(k) * 2.399963).sin_cos();
            let across = (1.0 - z * z).sqrt();
            DVec3::new(across * cosine, across * sine, z)
        });
        spiral.chain([DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z])
    }

    fn curved() -> impl Iterator<Item = Curved> {
        let sizes = [(1.0, 0.5), (1e-3, 1e-3), (0.01, 7.0), (1e3, 1e-3), (0.0, 1.0), (1.0, 0.0)];
        sizes
            .into_iter()
            .flat_map(|(h, r)| [Curved::cylinder(h, r).unwrap(), Curved::cone(h, r).unwrap()])
    }

    #[test]
    fn the_hull_is_inside_and_the_core_reaches_no_farther_than_the_excess() {
        for shape in curved() {
            let hull = Inscribed::of(&shape);
            let lower = shape.discs()[0].1;
            for v in &hull.vertices {
                let at = (v.z + shape.half_height()) / (2.0 * shape.half_height());
                let allowed = match shape.kind() {
                    CurvedKind::Cylinder => lower,
                    CurvedKind::Cone if at > 0.5 => 0.0,
                    _ => lower,
                };
                assert!(v.z.abs() <= shape.half_height() && v.x.hypot(v.y) <= allowed, "{v}");
            }
            let error = shape.support_error();
            let mut largest = 0.0f64;
            for d in directions() {
                let farthest = hull.vertices.iter().map(|v| v.dot(d)).fold(f64::MIN, f64::max);
                let beyond = shape.support(d).point.dot(d) - farthest;
                assert!(beyond <= hull.excess + error, "{shape:?} {d}");
                largest = largest.max(beyond);
            }
            assert!(largest >= 0.9 * hull.excess - error, "{shape:?}: {largest} {}", hull.excess);
        }
    }

    fn ellipsoids() -> impl Iterator<Item = Ellipsoid> {
        let sizes = [
            [1.0, 1.0, 1.0],
            [1e-3, 2.0, 0.5],
            [3.0, 3.0, 1e-4],
            [0.0, 1.0, 2.0],
            [0.0, 0.0, 7.0],
            [0.0; 3],
        ];
        sizes.into_iter().map(|half| Ellipsoid::new(DVec3::from_array(half)).unwrap())
    }

    #[test]
    fn the_hull_of_an_ellipsoid_is_inside_and_its_excess_is_what_the_ellipsoid_has_more() {
        for shape in ellipsoids() {
            let half = shape.half_axes();
            let hull = Inscribed::of_ellipsoid(&shape);
            for v in &hull.vertices {
                let part =
                    |axis: usize| if half[axis] > 0.0 { v[axis] / half[axis] } else { v[axis] };
                let [x, y, z] = [0, 1, 2].map(part);
                assert!(x * x + y * y + z * z <= 1.0, "{shape:?} {v}");
            }
            let error = shape.support_error();
            let mut largest = 0.0f64;
            for d in directions() {
                let farthest = hull.vertices.iter().map(|v| v.dot(d)).fold(f64::MIN, f64::max);
                let point = shape.support(d).point;
                assert!(point.dot(d) - farthest <= hull.excess + error, "{shape:?} {d}");
                assert!(point.length() <= hull.outer + error);
                assert!(hull.inner.radius <= point.dot(d) + error);
                if let Some(obb) = hull.obb {
                    assert!(obb.inner.dot(d.abs()) <= point.dot(d) + error);
                    assert!(point.abs().cmple(obb.outer + error).all());
                }
                largest = largest.max(point.dot(d) - farthest);
            }
            if half == DVec3::ONE {
                assert!(largest >= 0.95 * hull.excess && hull.excess < 0.07, "{largest}");
            }
        }
        let flat = Inscribed::of_ellipsoid(&Ellipsoid::new(DVec3::new(3.0, 2.0, 0.1)).unwrap());
        assert!(flat.obb.unwrap().inner.max_element() > 1.7);
    }

    #[test]
    fn spheres_and_boxes_hold_what_they_should() {
        for shape in curved() {
            let Inscribed { inner, outer, obb, .. } = Inscribed::of(&shape);
            for d in directions() {
                let farthest = shape.support(d).point - inner.centre;
                assert!(farthest.length() <= outer, "{shape:?} {d}");
                let Some(reference) = obb else { continue };
                let error = shape.support_error();
                assert!(farthest.abs().cmple(reference.outer + error).all(), "{shape:?} {d}");
                // The inner box reaches no farther than the core in any direction.
                let reach = reference.inner.dot(d.abs());
                assert!(reach <= farthest.dot(d) + error, "{shape:?} {d}");
            }
        }
        let long = Inscribed::of(&Curved::cylinder(3.0, 0.5).unwrap());
        assert!(long.obb.unwrap().inner.min_element() > 0.35);
        assert!(Inscribed::of(&Curved::cylinder(0.5, 0.5).unwrap()).obb.is_none());
    }
}
