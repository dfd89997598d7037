//! Spheres that cover a shape together, and for each a concentric sphere inside the shape.

use dcd_geom::{CurvedKind, Kind, Polytope, Pose, Shape, SphereBounds};
use glam::DVec3;
use std::collections::HashMap;
use std::sync::Arc;

/// One of the spheres that cover a shape, in the shape's own frame, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CoverSphere {
    pub(crate) centre: DVec3,
    /// Infinite where the shape has no end.
    pub(crate) outer: f64,
    /// The radius of a sphere about the same centre that the shape contains; −∞ where none is known.
    pub(crate) inner: f64,
}

/// What a covering sphere is larger by, and an inner one smaller, than it was found: of the shape's reach.
/// Faces are merged within 1e-9 of the extent ([`dcd_geom::FLATNESS`]), and pieces are cut in f64.
const COVER_MARGIN: f64 = 4e-9;

/// How far the singular values of a base's, a link's and an origin's rotation may be from 1 together: each passes
/// [`dcd_geom::Pose::UNIT_TOLERANCE`] in each entry, products of links' rotations lose far less.
pub(crate) const STRETCH: f64 = 16.0 * dcd_geom::Pose::UNIT_TOLERANCE;

/// Covers of shapes that share their data with clones, so that those who need the same one find it once: by where the data is, which
/// stays there as long as the shape is held here, and how many spheres there are at most.
#[derive(Debug, Default)]
pub(crate) struct Covers(HashMap<(usize, usize), (Shape, Vec<CoverSphere>)>);

impl Covers {
    /// [`cover`].
    pub(crate) fn of(&mut self, shape: &Shape, most: usize) -> Vec<CoverSphere> {
        let find = || cover(shape, most);
        // Others have a formula: to look for what was found would take longer.
        let Some(address) = address_of(shape) else { return find() };
        self.0.entry((address, most)).or_insert_with(|| (shape.clone(), find())).1.clone()
    }
}

/// Where a shape has the data that it shares with its clones, if it does.
fn address_of(shape: &Shape) -> Option<usize> {
    match shape {
        Shape::Polytope(shared) => Some(Arc::as_ptr(shared).addr()),
        Shape::Mesh(shared) => Some(Arc::as_ptr(shared).addr()),
        Shape::Compound(shared) => Some(Arc::as_ptr(shared).addr()),
        _ => None,
    }
}

/// Whether two shapes are clones of one.
pub(crate) fn is_one(a: &Shape, b: &Shape) -> bool {
    match (a, b) {
        (Shape::Curved(a), Shape::Curved(b)) => a == b,
        (Shape::Ellipsoid(a), Shape::Ellipsoid(b)) => a == b,
        _ => address_of(a).is_some_and(|address| address_of(b) == Some(address)),
    }
}

/// At most so many spheres, at least one, that cover the shape together.
pub(crate) fn cover(shape: &Shape, most: usize) -> Vec<CoverSphere> {
    let found = match shape {
        Shape::Polytope(polytope) => of_polytope(polytope, most),
        Shape::Curved(curved) if curved.kind() == CurvedKind::Cylinder => {
            let (height, radius) = (curved.half_height(), curved.radius());
            let pieces = ((height / radius).ceil()).clamp(1.0, most.max(1) as f64);
            let piece = height / pieces;
            let margin = COVER_MARGIN * shape.reach();
            let swept = curved.swept_radius();
            let at = |k: usize| {
                let z = (2.0 * k as f64 + 1.0) * piece - height;
                CoverSphere {
                    centre: DVec3::Z * z,
                    outer: radius.hypot(piece) + swept + margin,
                    inner: radius.min(height - z.abs()) + swept - margin,
                }
            };
            (0..pieces as usize).map(at).collect()
        }
        Shape::Mesh(mesh) => {
            let corners = (0..mesh.triangles().len()).filter_map(|k| mesh.corners(k));
            let faces: Vec<Vec<DVec3>> = corners.map(Vec::from).collect();
            let mut pieces = Vec::new();
            split(faces, most, Inside::Hollow, &mut pieces);
            let grown = mesh.swept_radius() + COVER_MARGIN * mesh.reach();
            let piece = |(centre, radius)| CoverSphere {
                centre,
                outer: radius + grown,
                inner: f64::NEG_INFINITY,
            };
            pieces.into_iter().map(piece).collect()
        }
        Shape::Compound(compound) => {
            let parts = compound.parts();
            let each = most / parts.len().max(1);
            let all = parts.iter().flat_map(|part| cover(part.placed(), each));
            if each > 0 { all.collect() } else { Vec::new() }
        }
        _ => Vec::new(),
    };
    let is_cover = !found.is_empty() && found.len() <= most.max(1);
    if is_cover && found.iter().all(|sphere| sphere.outer.is_finite()) {
        found
    } else {
        vec![alone(shape)]
    }
}

/// One sphere round a shape of any kind.
fn alone(shape: &Shape) -> CoverSphere {
    let none = CoverSphere { centre: DVec3::ZERO, outer: f64::INFINITY, inner: f64::NEG_INFINITY };
    SphereBounds::of(shape).map_or(none, |bounds| {
        let sphere = bounds.sphere(&Pose::IDENTITY);
        let inner = f64::from(bounds.concentric(&sphere).radius);
        CoverSphere { centre: sphere.centre.as_dvec3(), outer: f64::from(sphere.radius), inner }
    })
}

fn of_polytope(polytope: &Polytope, most: usize) -> Vec<CoverSphere> {
    let (vertices, swept) = (polytope.vertices(), polytope.swept_radius());
    let margin = COVER_MARGIN * polytope.reach();
    if let &[centre] = vertices {
        return vec![CoverSphere { centre, outer: swept, inner: swept }];
    }
    let facets = polytope.facets();
    let corners = |facet| facets.corners(facet).iter().map(|&k| vertices[k as usize]);
    let faces: Vec<Vec<DVec3>> = facets.facets().iter().map(|f| corners(f).collect()).collect();
    let planes: Vec<(DVec3, f64)> = facets
        .facets()
        .iter()
        .map(|f| (f.normal, corners(f).map(|v| f.normal.dot(v)).fold(f64::INFINITY, f64::min)))
        .collect();
    let inner_at = |centre: DVec3| {
        let depth = planes.iter().map(|&(normal, offset)| offset - normal.dot(centre));
        let depth = depth.fold(f64::INFINITY, f64::min) - margin;
        match polytope.kind() {
            // A piece's centre is on the segment, to within what is taken off.
            Kind::Segment => swept - margin,
            _ if depth > 0.0 => depth + swept,
            _ => f64::NEG_INFINITY,
        }
    };
    let mut pieces = Vec::new();
    split(faces, most, Inside::Solid, &mut pieces);
    let piece = |(centre, radius)| CoverSphere {
        centre,
        outer: radius + swept + margin,
        inner: inner_at(centre),
    };
    pieces.into_iter().map(piece).collect()
}

/// Whether what the polygons bound belongs to the shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Inside {
    Solid,
    Hollow,
}

/// Halves what the convex polygons bound, across its longest side, until there are so many pieces, and appends a
/// centre and a radius of a sphere round each.
fn split(faces: Vec<Vec<DVec3>>, most: usize, inside: Inside, spheres: &mut Vec<(DVec3, f64)>) {
    let points = || faces.iter().flatten();
    let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (min, max) = points().fold(none, |(min, max), &v| (min.min(v), max.max(v)));
    if faces.is_empty() {
        return;
    }
    let (centre, extent) = (min * 0.5 + max * 0.5, max - min);
    let radius = points().map(|v| v.distance(centre)).fold(0.0, f64::max);
    if most < 2 || radius == 0.0 {
        spheres.push((centre, radius));
        return;
    }
    let axis = (0..3).fold(0, |longest, k| if extent[k] > extent[longest] { k } else { longest });
    for side in [1.0, -1.0] {
        let half = halved(&faces, (axis, centre[axis], side), inside);
        split(half, most / 2, inside, spheres);
    }
}

/// What of the polygons is on one side of the plane at `at` across an axis, and what closes them there.
fn halved(
    faces: &[Vec<DVec3>],
    (axis, at, side): (usize, f64, f64),
    inside: Inside,
) -> Vec<Vec<DVec3>> {
    let mut kept = Vec::with_capacity(faces.len() + 1);
    let mut cut: Vec<DVec3> = Vec::new();
    for face in faces {
        let mut polygon = Vec::with_capacity(face.len() + 2);
        for (k, &a) in face.iter().enumerate() {
            let b = face[(k + 1) % face.len()];
            let (from, to) = ((a[axis] - at) * side, (b[axis] - at) * side);
            if from >= 0.0 {
                polygon.push(a);
            }
            if (from < 0.0) != (to < 0.0) {
                let mut crossing = a + (b - a) * (from / (from - to)).clamp(0.0, 1.0);
                crossing[axis] = at;
                polygon.push(crossing);
                cut.push(crossing);
            }
        }
        if !polygon.is_empty() {
            kept.push(polygon);
        }
    }
    if inside == Inside::Solid && !cut.is_empty() {
        let mean = cut.iter().sum::<DVec3>() / cut.len() as f64;
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let angle = |p: &DVec3| libm::atan2(p[v] - mean[v], p[u] - mean[u]);
        let mut round: Vec<(f64, DVec3)> = cut.into_iter().map(|p| (angle(&p), p)).collect();
        round.sort_by(|a, b| a.0.total_cmp(&b.0));
        kept.push(round.into_iter().map(|(_, p)| p).collect());
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shapes() -> Vec<Shape> {
        let vertex = |k: i32| {
            let angle = f64::from(k) * 2.399963;
            let z = 1.0 - (f64::from(k) + 0.5) / 60.0;
            let ring = (1.0 - z * z).sqrt();
            DVec3::new(0.3 * ring * angle.cos(), 0.1 * ring * angle.sin(), 0.05 * z)
        };
        let corner =
            |k: i32| DVec3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2));
        vec![
            Shape::cuboid(DVec3::new(1.0, 0.2, 0.1)).unwrap(),
            Shape::cuboid(DVec3::ONE).unwrap(),
            Shape::hull((0..120).map(vertex).collect()).unwrap().rounded(0.01).unwrap(),
            Shape::hull((0..7).map(corner).collect()).unwrap(),
            Shape::hull(vec![DVec3::ZERO, DVec3::X, DVec3::new(0.2, 0.7, 0.0), DVec3::Y]).unwrap(),
            Shape::sphere(0.3).unwrap(),
            Shape::capsule(0.7, 0.1).unwrap(),
            Shape::triangle([DVec3::X, DVec3::Y, DVec3::Z]).unwrap().rounded(0.1).unwrap(),
            Shape::cylinder(0.5, 0.1).unwrap(),
            Shape::cylinder(0.01, 0.4).unwrap().rounded(0.1).unwrap(),
            Shape::cone(0.3, 0.2).unwrap(),
            Shape::mesh((0..8).map(corner).collect(), vec![[0, 1, 2], [1, 3, 2], [4, 5, 7]])
                .unwrap(),
            Shape::compound(vec![
                (Shape::sphere(0.1).unwrap(), Pose::IDENTITY),
                (
                    Shape::cuboid(DVec3::ONE).unwrap(),
                    Pose::from_translation(DVec3::X * 3.0).unwrap(),
                ),
            ])
            .unwrap(),
        ]
    }

    /// Points of the shape, its surface among them: between its supports in many directions.
    fn points_of(shape: &Shape) -> Vec<DVec3> {
        let directions = (0..200).map(|k| {
            let angle = f64::from(k) * 2.399963;
            let z = 1.0 - (f64::from(k) + 0.5) / 100.0;
            let ring = (1.0 - z * z).sqrt();
            DVec3::new(ring * angle.cos(), ring * angle.sin(), z)
        });
        let extreme = |convex: &Shape| -> Vec<DVec3> {
            let of = |d: DVec3| match convex {
                Shape::Polytope(p) => {
                    let far = p.vertices().iter().max_by(|a, b| a.dot(d).total_cmp(&b.dot(d)));
                    *far.unwrap() + d * p.swept_radius()
                }
                Shape::Curved(c) => {
                    let [low, high] = c.discs();
                    let flat = DVec3::new(d.x, d.y, 0.0).normalize_or_zero();
                    let rim = |(z, r): (f64, f64)| DVec3::Z * z + flat * r;
                    let (low, high) = (rim(low), rim(high));
                    let far = if low.dot(d) > high.dot(d) { low } else { high };
                    far + d * c.swept_radius()
                }
                _ => unreachable!(),
            };
            let ends: Vec<DVec3> = directions.clone().map(of).collect();
            let between =
                (0..ends.len()).flat_map(|i| (0..ends.len()).step_by(7).map(move |j| (i, j)));
            let mix = |(i, j): (usize, usize)| {
                let part = ((i * 31 + j * 17) % 101) as f64 / 100.0;
                ends[i] * part + ends[j] * (1.0 - part)
            };
            between.map(mix).collect()
        };
        match shape {
            Shape::Mesh(mesh) => (0..mesh.triangles().len())
                .filter_map(|k| mesh.corners(k))
                .flat_map(|[a, b, c]| {
                    (0..50).map(move |k| {
                        let (u, v) = (f64::from(k % 7) / 6.0, f64::from(k / 7) / 7.0);
                        a + (b - a) * u + (c - a) * (v * (1.0 - u))
                    })
                })
                .collect(),
            Shape::Compound(compound) => {
                compound.parts().iter().flat_map(|part| extreme(part.placed())).collect()
            }
            convex => extreme(convex),
        }
    }

    #[test]
    fn a_cover_that_was_found_is_that_of_the_shape_and_of_its_clones() {
        let (mut covers, shapes) = (Covers::default(), shapes());
        for most in [1, 8, 1] {
            for shape in shapes.iter().chain(&shapes.clone()) {
                assert_eq!(covers.of(shape, most), cover(shape, most));
            }
        }
        let shared = shapes.iter().filter(|shape| address_of(shape).is_some()).count();
        assert_eq!(covers.0.len(), 2 * shared, "found once for each number of spheres");
        for (i, a) in shapes.iter().enumerate() {
            let clones: Vec<bool> = shapes.clone().iter().map(|b| is_one(a, b)).collect();
            assert!(clones.iter().enumerate().all(|(k, &is_clone)| is_clone == (k == i)));
        }
    }

    #[test]
    fn every_point_of_a_shape_is_in_some_sphere() {
        for shape in shapes() {
            for most in [1, 2, 3, 8, 16] {
                let spheres = cover(&shape, most);
                assert!((1..=most).contains(&spheres.len()), "{shape:?}");
                for p in points_of(&shape) {
                    let is_in = |s: &CoverSphere| s.centre.distance(p) <= s.outer * (1.0 + 1e-12);
                    assert!(spheres.iter().any(is_in), "{shape:?}: {p} in none of {spheres:?}");
                }
            }
        }
    }

    #[test]
    fn an_inner_sphere_is_inside() {
        let mut proved = 0;
        for shape in shapes().iter().filter(|shape| shape.is_convex()) {
            for sphere in cover(shape, 16).iter().filter(|sphere| sphere.inner > 0.0) {
                proved += 1;
                // The support in any direction reaches beyond the sphere's.
                let points = points_of(shape);
                for k in 0..100 {
                    let angle = f64::from(k) * 2.399963;
                    let z = 1.0 - (f64::from(k) + 0.5) / 50.0;
                    let ring = (1.0 - z * z).sqrt();
                    let d = DVec3::new(ring * angle.cos(), ring * angle.sin(), z);
                    let far = match shape {
                        Shape::Polytope(p) => {
                            let far = p.vertices().iter().map(|v| v.dot(d));
                            far.fold(f64::NEG_INFINITY, f64::max) + p.swept_radius()
                        }
                        _ => points.iter().map(|v| v.dot(d)).fold(f64::NEG_INFINITY, f64::max),
                    };
                    let slack = if matches!(shape, Shape::Polytope(_)) { 0.0 } else { 0.05 };
                    assert!(far + slack >= sphere.centre.dot(d) + sphere.inner, "{shape:?} {d}");
                }
            }
        }
        assert!(proved > 20, "{proved}");
    }

    #[test]
    fn more_spheres_are_smaller_ones() {
        let long = Shape::cuboid(DVec3::new(1.0, 0.1, 0.1)).unwrap();
        let largest =
            |most| cover(&long, most).iter().map(|sphere| sphere.outer).fold(0.0, f64::max);
        assert!(largest(1) > 1.0 && largest(8) < 0.25);
    }
}
