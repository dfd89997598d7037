//! From an inner point off every symmetry through the origin to the surface: resolves what GJK
//! cannot, where the origin is on a face, an edge or a corner of its simplex.
//!
//! Aligned boxes, stacked faces, identical and concentric shapes put the origin exactly on lower
//! faces of GJK's simplex, and then its direction is rounding. A ray from a point in general
//! position meets the surface inside a face, so that point and face hold the origin strictly
//! inside, by enough for the certificate. The directions are normals of faces, which are accurate
//! however near the faces are.
//!
//! Source: Minkowski portal refinement, Snethen 2008; the skewed start and the certificate are ours.

use crate::certificate::Bounds;
use crate::gjk::unit;
use crate::simplex::{Triple, cross, determinant, dot, minus, negated, plus};
use crate::{Difference, Reason, Verdict};
use dcd_geom::{Real, SupportMap, Vector};

/// How many supports one ray may take. No unit. Hulls need 3 to 8.
const MAX_SUPPORTS: usize = 40;

/// Where the first ray begins, in radii of the inner sphere from its centre: half a radius, so that
/// neither its own rounding nor the sphere's matters, and off every symmetry.
const OFF_CENTRE: [f64; 3] = [0.34375, 0.203125, -0.28125];

/// The first direction in which the inner point's vertices are sought: none that shapes like. World
/// axes, no unit, largest component in [½, 1].
const FIRST: [f64; 3] = [0.90625, 0.578125, 0.421875];

/// What each of four vertices weighs in the inner point of a later ray, in 32nds; one row a ray.
/// All different, so that the symmetry of a shape is not the point's. Each row sums to 32: the
/// weights are exact, so the point is in the hull.
const WEIGHTS: [[f64; 4]; 3] =
    [[12.0, 9.0, 6.0, 5.0], [5.0, 7.0, 9.0, 11.0], [8.0, 13.0, 4.0, 7.0]];

/// The verdict by up to four rays. Of the cores alone: swept radii only help to prove apart.
pub(crate) fn overlap<R, A, B>(
    difference: &Difference<'_, R, A, B>,
    bounds: &Bounds<R>,
) -> Verdict<()>
where
    R: Real,
    A: SupportMap<R> + ?Sized,
    B: SupportMap<R> + ?Sized,
{
    let surface = Surface { difference, bounds };
    match surface.rays() {
        Ok(true) => Verdict::Touching(()),
        Err(Axis::Separates) => Verdict::Apart,
        Ok(false) | Err(Axis::Shallow) => Verdict::Undecided(Reason::WithinRounding),
    }
}

/// An axis found on the way that ends the search.
enum Axis {
    Separates,
    /// The difference ends so near to the origin that no tetrahedron in it can be certified.
    Shallow,
}

struct Surface<'a, R: Real, A: ?Sized, B: ?Sized> {
    difference: &'a Difference<'a, R, A, B>,
    bounds: &'a Bounds<R>,
}

impl<R, A, B> Surface<'_, R, A, B>
where
    R: Real,
    A: SupportMap<R> + ?Sized,
    B: SupportMap<R> + ?Sized,
{
    /// Whether a ray shows that the origin is surely inside.
    fn rays(&self) -> Result<bool, Axis> {
        if let Some(inner) = self.inner_sphere_point()
            && self.ray(&inner)?
        {
            return Ok(true);
        }
        let corners = self.corners()?;
        for weights in WEIGHTS {
            if self.ray(&inner_point(&corners, weights))? {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// A point of the inner sphere off its centre, if the sphere is large beside rounding.
    fn inner_sphere_point(&self) -> Option<Triple<R>> {
        let radius = self.difference.inner();
        let middle = self.difference.middle().components();
        let skewed = OFF_CENTRE.map(|x| R::from_f64(x) * radius);
        (!self.bounds.passes_through(radius * radius)).then(|| plus(&middle, &skewed))
    }

    /// The vertex farthest along a direction. `None` where the direction is rounding alone.
    fn farthest(&self, direction: &Triple<R>) -> Result<Option<Triple<R>>, Axis> {
        let Some(d) = unit::<R>(negated(direction)) else { return Ok(None) };
        let (vertex, separation) = self.difference.lowest(d);
        if self.bounds.proves_apart(d, separation) {
            return Err(Axis::Separates);
        }
        if self.bounds.is_shallow(d, separation) {
            return Err(Axis::Shallow);
        }
        Ok(Some(vertex.w.components()))
    }

    /// Four vertices that span a tetrahedron, as large as six supports find, if the difference is
    /// not flat.
    fn corners(&self) -> Result<[Triple<R>; 4], Axis> {
        let first = FIRST.map(R::from_f64);
        let c0 = self.farthest(&first)?.unwrap_or([R::ZERO; 3]);
        let c1 = self.beyond(&negated(&first), &c0)?;
        let edge = minus(&c1, &c0);
        let c2 = self.beyond(&across(&edge), &c0)?;
        let c3 = self.beyond(&cross(&edge, &minus(&c2, &c0)), &c0)?;
        Ok([c0, c1, c2, c3])
    }

    /// A vertex clearly beyond or clearly before the plane through `from`; else any.
    fn beyond(&self, normal: &Triple<R>, from: &Triple<R>) -> Result<Triple<R>, Axis> {
        let Some(found) = self.farthest(normal)? else { return Ok(*from) };
        let height = dot(&minus(&found, from), normal);
        if self.bounds.passes_through(height * height / dot(normal, normal)) {
            return Ok(self.farthest(&negated(normal))?.unwrap_or(*from));
        }
        Ok(found)
    }

    /// Follows the ray from `inner` through the origin: whether the origin is surely inside.
    fn ray(&self, inner: &Triple<R>) -> Result<bool, Axis> {
        let Some(mut portal) = self.portal(inner)? else { return Ok(false) };
        for _ in 0..MAX_SUPPORTS {
            let outward = portal.outward();
            let [p1, p2, p3] = portal.0;
            if self.bounds.four_combined_points_touch(&[*inner, p1, p2, p3]) {
                return Ok(true);
            }
            let Some(p4) = self.farthest(&outward)? else { break };
            if !(dot(&minus(&p4, &p1), &outward) > R::ZERO) || portal.0.contains(&p4) {
                break;
            }
            portal = portal.split(inner, p4);
        }
        Ok(false)
    }

    /// Three vertices whose triangle the ray passes through.
    fn portal(&self, inner: &Triple<R>) -> Result<Option<Portal<R>>, Axis> {
        let Some(p1) = self.farthest(&negated(inner))? else { return Ok(None) };
        let Some(p2) = self.farthest(&cross(&p1, inner))? else { return Ok(None) };
        let mut portal = Portal([p1, p2, p2]);
        for _ in 0..MAX_SUPPORTS {
            let [p1, p2, _] = portal.0;
            let mut side = cross(&minus(&p1, inner), &minus(&p2, inner));
            if dot(&side, inner) > R::ZERO {
                side = negated(&side);
                portal.0.swap(0, 1);
            }
            let Some(p3) = self.farthest(&side)? else { return Ok(None) };
            let [p1, p2, _] = portal.0;
            portal.0[2] = p3;
            if determinant(inner, &p1, &p3) < R::ZERO {
                portal.0 = [p1, p3, p3];
            } else if determinant(inner, &p3, &p2) < R::ZERO {
                portal.0 = [p3, p2, p2];
            } else {
                return Ok(Some(portal));
            }
        }
        Ok(None)
    }
}

/// A triangle of vertices in the ray's way.
#[derive(Clone, Copy)]
struct Portal<R: Real>([Triple<R>; 3]);

impl<R: Real> Portal<R> {
    /// Its normal, away from the inner point: the corners turn that way from the start.
    fn outward(&self) -> Triple<R> {
        let [p1, p2, p3] = &self.0;
        cross(&minus(p2, p1), &minus(p3, p1))
    }

    /// With `p4` beyond it: the one of the three new triangles that the ray passes through.
    fn split(&self, inner: &Triple<R>, p4: Triple<R>) -> Self {
        let [p1, p2, p3] = self.0;
        let plane = cross(&p4, inner);
        let before = |p: &Triple<R>| dot(p, &plane) > R::ZERO;
        match (before(&p1), before(&p2), before(&p3)) {
            (true, false, _) => Self([p1, p2, p4]),
            (false, _, true) => Self([p3, p1, p4]),
            _ => Self([p2, p3, p4]),
        }
    }
}

/// A direction normal to an edge: its cross product with the axis that it is farthest from.
fn across<R: Real>(edge: &Triple<R>) -> Triple<R> {
    let [x, y, z] = edge.map(R::abs);
    let axis = match (x <= y && x <= z, y <= z) {
        (true, _) => [R::ONE, R::ZERO, R::ZERO],
        (false, true) => [R::ZERO, R::ONE, R::ZERO],
        (false, false) => [R::ZERO, R::ZERO, R::ONE],
    };
    cross(edge, &axis)
}

fn inner_point<R: Real>(corners: &[Triple<R>; 4], weights: [f64; 4]) -> Triple<R> {
    let [w0, w1, w2, w3] = weights.map(|weight| R::from_f64(weight / 32.0));
    let [c0, c1, c2, c3] = corners;
    [0, 1, 2].map(|k| (c0[k] * w0 + c1[k] * w1) + (c2[k] * w2 + c3[k] * w3))
}
