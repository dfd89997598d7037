//! Triangles to draw a shape by.

use dcd_geom::{CurvedKind, Facets, HalfSpace, Polytope, Shape, SupportMap};
use glam::{DVec3, Vec3};
use std::f64::consts::TAU;

/// Corners of a disc. More: larger files. Fewer: a cylinder looks like a prism.
const ROUND: u32 = 32;

/// How often the faces of an octahedron are cut in four for the directions that a sphere is drawn by:
/// 258 of them.
const CUTS: u32 = 3;

/// A surface in the shape's own frame, metres.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Surface {
    pub(super) positions: Vec<Vec3>,
    pub(super) triangles: Vec<[u32; 3]>,
}

impl Surface {
    /// The surface of a shape in a scene that is `extent` metres wide: so far a half-space's plane is drawn, and a
    /// thousandth of it thick what has no thickness in two directions.
    pub(super) fn of(shape: &Shape, extent: f64) -> Self {
        match shape {
            Shape::Polytope(polytope) => Self::of_polytope(polytope, extent),
            Shape::Curved(curved) => {
                let discs =
                    curved.discs().into_iter().zip([true, curved.kind() == CurvedKind::Cylinder]);
                let core: Vec<DVec3> =
                    discs.flat_map(|((z, r), is_disc)| disc(z, r, is_disc)).collect();
                Self::around(&core, curved.swept_radius())
            }
            Shape::Ellipsoid(ellipsoid) => {
                let core: Vec<DVec3> = directions().map(|d| ellipsoid.half_axes() * d).collect();
                Self::around(&core, ellipsoid.swept_radius())
            }
            Shape::HalfSpace(half_space) => Self::of_plane(half_space, extent),
            Shape::Custom(map) => {
                let core: Vec<DVec3> = directions().map(|d| map.support(d).point).collect();
                Self::around(&core, map.radius())
            }
            Shape::Compound(compound) => {
                let mut all = Self::default();
                for part in compound.parts() {
                    let mut drawn = Self::of(&part.shape, extent);
                    for point in &mut drawn.positions {
                        *point = part.pose.apply(point.as_dvec3()).as_vec3();
                    }
                    all.append(drawn);
                }
                all
            }
            Shape::Mesh(mesh) => Self {
                positions: mesh.vertices().iter().map(|v| v.as_vec3()).collect(),
                triangles: mesh.triangles().to_vec(),
            },
            // A kind that is not known here yet has a place and no look.
            _ => Self::default(),
        }
    }

    fn of_polytope(polytope: &Polytope, extent: f64) -> Self {
        let radius = polytope.swept_radius();
        let facets = polytope.facets();
        let is_thin = facets.facets().iter().all(|facet| facet.normal == DVec3::ZERO);
        if radius == 0.0 && !is_thin {
            return Self::of_facets(polytope.vertices(), facets);
        }
        // A sphere or capsule is as thick as it is.
        let drawn = if radius == 0.0 { extent * 1e-3 } else { radius };
        Self::around(polytope.vertices(), drawn)
    }

    /// The hull of points with a sphere swept round it, drawn by its supports.
    fn around(core: &[DVec3], radius: f64) -> Self {
        if radius == 0.0 {
            return Self::of_facets(core, &Facets::of(core));
        }
        let support = |d: DVec3| {
            let larger = |best: DVec3, &v: &DVec3| if v.dot(d) > best.dot(d) { v } else { best };
            core[1..].iter().fold(core[0], larger) + d * radius
        };
        let points: Vec<DVec3> = directions().map(support).collect();
        Self::of_facets(&points, &Facets::of(&points))
    }

    fn of_facets(vertices: &[DVec3], facets: &Facets) -> Self {
        let mut surface = Self {
            positions: vertices.iter().map(|v| v.as_vec3()).collect(),
            triangles: Vec::new(),
        };
        for facet in facets.facets() {
            if let [first, rest @ ..] = facets.corners(facet) {
                surface.triangles.extend(rest.windows(2).map(|edge| [*first, edge[0], edge[1]]));
            }
        }
        surface
    }

    fn of_plane(half_space: &HalfSpace, extent: f64) -> Self {
        let unit = half_space.unit_normal();
        let middle = unit * (half_space.unit_offset() + half_space.swept_radius());
        let (x, y) = unit.any_orthonormal_pair();
        let corner = |(i, j): (f64, f64)| (middle + (x * i + y * j) * extent).as_vec3();
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        Self { positions: corners.map(corner).to_vec(), triangles: vec![[0, 1, 2], [0, 2, 3]] }
    }

    fn append(&mut self, other: Self) {
        let first = self.positions.len() as u32;
        self.positions.extend(other.positions);
        self.triangles.extend(other.triangles.iter().map(|corners| corners.map(|k| first + k)));
    }
}

/// Points of a circle round the z axis; of an apex one.
fn disc(z: f64, radius: f64, is_disc: bool) -> Vec<DVec3> {
    let count = if is_disc { ROUND } else { 1 };
    let angle = |k: u32| TAU * f64::from(k) / f64::from(count);
    (0..count).map(|k| DVec3::new(radius * angle(k).cos(), radius * angle(k).sin(), z)).collect()
}

/// Unit vectors all round: the corners of an octahedron whose faces are cut in four again and again.
fn directions() -> impl Iterator<Item = DVec3> {
    let n = 1i32 << CUTS;
    let within = move |x: i32, y: i32| x.abs() + y.abs() <= n;
    let plane = (-n..=n).flat_map(move |x| (-n..=n).map(move |y| (x, y)));
    plane.filter(move |&(x, y)| within(x, y)).flat_map(move |(x, y)| {
        let z = n - x.abs() - y.abs();
        let sides = if z == 0 { 1 } else { 2 };
        let point = move |side: i32| {
            DVec3::new(f64::from(x), f64::from(y), f64::from(z * (1 - 2 * side))).normalize()
        };
        (0..sides).map(point)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use dcd_geom::Pose;

    /// Six times the volume inside of a closed surface.
    fn six_volumes(surface: &Surface) -> f64 {
        let corner = |k: u32| surface.positions[k as usize].as_dvec3();
        let of = |&[a, b, c]: &[u32; 3]| corner(a).dot(corner(b).cross(corner(c)));
        surface.triangles.iter().map(of).sum()
    }

    fn volume(shape: &Shape) -> f64 {
        six_volumes(&Surface::of(shape, 1.0)) / 6.0
    }

    #[test]
    fn surfaces_face_outward_and_hold_the_shape_s_volume() {
        let cube = Shape::cuboid(DVec3::new(0.5, 1.0, 1.5)).unwrap();
        assert!((volume(&cube) - 6.0).abs() < 1e-6);
        let pi = TAU / 2.0;
        let round = [
            (Shape::sphere(1.0).unwrap(), 4.0 / 3.0 * pi),
            (Shape::capsule(1.0, 1.0).unwrap(), 4.0 / 3.0 * pi + 2.0 * pi),
            (Shape::cylinder(1.0, 1.0).unwrap(), 2.0 * pi),
            (Shape::cone(1.0, 1.0).unwrap(), 2.0 / 3.0 * pi),
            (Shape::ellipsoid(DVec3::new(1.0, 2.0, 0.5)).unwrap(), 4.0 / 3.0 * pi),
        ];
        for (shape, exact) in round {
            let drawn = volume(&shape);
            assert!(drawn < exact && drawn > 0.95 * exact, "{shape:?}: {drawn} of {exact}");
        }
    }

    #[test]
    fn a_compound_is_its_parts_in_their_places() {
        let cube = Shape::cuboid(DVec3::ONE).unwrap();
        let at = |x: f64| Pose::from_translation(DVec3::X * x).unwrap();
        let pair = Shape::compound(vec![(cube.clone(), at(-5.0)), (cube, at(5.0))]).unwrap();
        let drawn = Surface::of(&pair, 1.0);
        assert!((six_volumes(&drawn) / 6.0 - 16.0).abs() < 1e-5);
        let ends = drawn.positions.iter().map(|p| p.x);
        assert_eq!((ends.clone().fold(0.0, f32::min), ends.fold(0.0, f32::max)), (-6.0, 6.0));
    }

    #[test]
    fn what_is_thin_is_drawn() {
        let thin = [
            Shape::segment(DVec3::ZERO, DVec3::X).unwrap(),
            Shape::sphere(0.0).unwrap(),
            Shape::triangle([DVec3::ZERO, DVec3::X, DVec3::Y]).unwrap(),
            Shape::half_space(DVec3::Z * 2.0, 4.0).unwrap(),
        ];
        for shape in thin {
            let drawn = Surface::of(&shape, 10.0);
            assert!(!drawn.triangles.is_empty(), "{shape:?}");
        }
        // As large as it is, however wide the scene.
        for (shape, far) in
            [(Shape::sphere(0.05).unwrap(), 0.05), (Shape::capsule(0.1, 0.05).unwrap(), 0.15)]
        {
            let points = Surface::of(&shape, 1000.0).positions;
            let farthest = points.iter().fold(0.0f32, |most, p| most.max(p.length()));
            assert!((farthest - far).abs() < 1e-6, "{farthest} {far}");
        }
        let plane = Surface::of(&Shape::half_space(DVec3::Z * 2.0, 4.0).unwrap(), 10.0);
        assert!(plane.positions.iter().all(|p| p.z == 2.0));
    }
}
