//! What of a shape proves it far from others without the solvers: spheres that cover it, a solid round it, and how
//! far it reaches along a direction.

use super::rows::{CoverRow, Farthest, POINTS_AT_ONCE, ROW};
use crate::state_checker::MESH_POINTS;
use crate::state_checker::covers::{CoverSphere, Covers};
use dcd_geom::{Aabb, ConvexHull, CurvedKind, Kind, Polytope, Pose, Shape};
use dcd_simd::dispatch;
use glam::DVec3;

/// At most so many spheres cover a shape. More: fewer pairs go to the solvers, each costs more.
pub(super) const MOST_SPHERES: usize = ROW;

/// Of a hull or a mesh of more vertices there is no support map: the solvers have better ones.
const MOST_VERTICES: usize = 4096;

/// In the shape's own frame, metres.
#[derive(Clone, Debug)]
pub(super) struct BoundingVolumes {
    /// A sphere round all of it; infinite round what has no end.
    pub(super) whole: CoverSphere,
    /// How far from its centre anything is that a turn moves: of a sphere nothing.
    pub(super) turning: f64,
    pub(super) cover: CoverRow,
    pub(super) solid: Solid,
    /// Whether that solid is the shape.
    pub(super) is_solid: bool,
    pub(super) support: Option<Support>,
    /// Of a mesh the hull of all its vertices, whose distances cost less.
    pub(super) hull: Option<Shape>,
    /// How far its points are from its frame's origin; of a half-space that of its plane.
    pub(super) reach: f64,
}

impl BoundingVolumes {
    /// Covered by at most so many spheres.
    pub(super) fn of(shape: &Shape, most: usize, covers: &mut Covers) -> Self {
        let one = covers.of(shape, 1);
        let none = CoverSphere { centre: DVec3::ZERO, outer: f64::INFINITY, inner: 0.0 };
        let whole = one.first().copied().unwrap_or(none);
        let cover = if most > 1 { covers.of(shape, most) } else { Vec::new() };
        // What one sphere covers as well, it covers alone.
        let cover = if cover.len() > 1 { CoverRow::of(&cover) } else { CoverRow::of(&[whole]) };
        let turning = if as_ball(shape).is_some() { 0.0 } else { whole.outer };
        let is_solid = match shape {
            Shape::Polytope(polytope) => {
                matches!(polytope.kind(), Kind::Cuboid { .. } | Kind::Point)
            }
            Shape::Curved(curved) => curved.kind() == CurvedKind::Cylinder,
            _ => false,
        };
        let (solid, hull) = (Solid::of(shape), hull(shape));
        // A mesh reaches as far as its hull.
        let support = Support::of(hull.as_ref().unwrap_or(shape));
        let reach = match &support {
            Some(Support { core: Core::Plane(_, offset), swept, .. }) => offset.abs() + swept,
            _ => whole.centre.length() + whole.outer,
        };
        Self { whole, turning, cover, solid, is_solid, support, hull, reach }
    }

    /// Of what is known by a sphere round it.
    pub(super) fn round(whole: CoverSphere) -> Self {
        let CoverSphere { centre, outer, .. } = whole;
        let solid = Solid::Box { middle: centre, half: DVec3::splat(outer), swept: 0.0 };
        Self {
            whole,
            turning: outer,
            cover: CoverRow::of(&[whole]),
            solid,
            is_solid: false,
            support: None,
            hull: None,
            reach: centre.length() + outer,
        }
    }
}

/// A sphere round one point: turned about that it stays where it is.
pub(super) fn as_ball(shape: &Shape) -> Option<&Polytope> {
    shape.as_polytope().filter(|polytope| polytope.kind() == Kind::Point)
}

/// Of a mesh, exactly, by its corners alone.
fn hull(shape: &Shape) -> Option<Shape> {
    let Shape::Mesh(mesh) = shape else { return None };
    let points = (mesh.points().len() <= MESH_POINTS).then(|| mesh.points())?;
    let hull = ConvexHull::of(points).ok()?;
    let corners: Vec<DVec3> = hull.corners().iter().map(|&k| points[k as usize]).collect();
    let is_small = corners.len() <= MOST_VERTICES;
    is_small.then(|| Shape::hull(corners)?.rounded(mesh.swept_radius()))?.ok()
}

/// A simple solid that contains a shape.
#[derive(Clone, Copy, Debug)]
pub(super) enum Solid {
    /// A box, and what is swept round it.
    Box { middle: DVec3, half: DVec3, swept: f64 },
    /// A cylinder round z.
    Cylinder { half: f64, radius: f64, swept: f64 },
}

impl Solid {
    fn of(shape: &Shape) -> Self {
        match shape {
            Shape::Curved(curved) if curved.kind() == CurvedKind::Cylinder => Self::Cylinder {
                half: curved.half_height(),
                radius: curved.radius(),
                swept: curved.swept_radius(),
            },
            Shape::Polytope(polytope) => {
                let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
                let (min, max) = polytope
                    .vertices()
                    .iter()
                    .fold(none, |(min, max), &v| (min.min(v), max.max(v)));
                let (middle, half) = (0.5 * min + 0.5 * max, 0.5 * max - 0.5 * min);
                Self::Box { middle, half, swept: polytope.swept_radius() }
            }
            _ => {
                let Aabb { min, max } = shape.aabb(&Pose::IDENTITY);
                let (min, max) = (min.as_dvec3(), max.as_dvec3());
                let (middle, half) = (0.5 * min + 0.5 * max, 0.5 * max - 0.5 * min);
                Self::Box { middle, half, swept: 0.0 }
            }
        }
    }

    /// How far a point is from the solid, 0 inside of what is swept, and the point of that nearest to it. Without a
    /// bound on rounding.
    #[inline]
    pub(super) fn nearest(&self, p: DVec3) -> (f64, DVec3) {
        match *self {
            Self::Box { middle, half, swept } => {
                let from = p - middle;
                let near = from.max(-half).min(half);
                ((from - near).length() - swept, near + middle)
            }
            Self::Cylinder { half, radius, swept } => {
                let rho = (p.x * p.x + p.y * p.y).sqrt();
                let part = if rho > radius { radius / rho } else { 1.0 };
                let near = DVec3::new(p.x * part, p.y * part, p.z.clamp(-half, half));
                ((p - near).length() - swept, near)
            }
        }
    }
}

/// How far a convex shape, or the hull of another, reaches.
#[derive(Clone, Debug)]
pub(super) struct Support {
    core: Core,
    swept: f64,
    /// The largest coordinate; of a plane its offset.
    size: f64,
}

#[derive(Clone, Debug)]
enum Core {
    /// Coordinates of the vertices, [`POINTS_AT_ONCE`] of x, then of y, then of z; the last ones repeat.
    Vertices(Vec<[[f64; POINTS_AT_ONCE]; 3]>),
    Point(DVec3),
    /// Discs normal to z at a height, with a radius.
    Discs([(f64, f64); 2]),
    /// A half-space's normal, of unit length, and how far the plane is along it.
    Plane(DVec3, f64),
}

/// How far a direction may be off a plane's normal, relative, for the half-space to end along it: a tenth of what turned
/// directions are given (`ROUNDING`), since points as far as a pair's lengths move by that. Smaller: no plane of a turned
/// half-space is met.
const PARALLEL: f64 = 1e-13;

/// What a product of three coordinates loses, relative: 3u, with a margin.
const DOT: f64 = 1e-15;

impl Support {
    fn of(shape: &Shape) -> Option<Self> {
        let (points, swept) = match shape {
            Shape::Polytope(polytope) => (polytope.vertices(), polytope.swept_radius()),
            Shape::Mesh(mesh) => (mesh.vertices(), mesh.swept_radius()),
            Shape::Curved(curved) => {
                let discs = curved.discs();
                let size = |(z, r): (f64, f64)| z.abs().max(r);
                let size = size(discs[0]).max(size(discs[1]));
                return Some(Self { core: Core::Discs(discs), swept: curved.swept_radius(), size });
            }
            Shape::HalfSpace(half_space) => {
                let (normal, offset) = (half_space.unit_normal(), half_space.unit_offset());
                let (core, swept) = (Core::Plane(normal, offset), half_space.swept_radius());
                return Some(Self { core, swept, size: offset.abs() });
            }
            _ => return None,
        };
        let last = *points.last().filter(|_| points.len() <= MOST_VERTICES)?;
        if points.len() == 1 {
            return Some(Self { core: Core::Point(last), swept, size: last.abs().max_element() });
        }
        let group = |chunk: &[DVec3]| {
            let at = |k: usize| chunk.get(k).copied().unwrap_or(last);
            [0, 1, 2].map(|axis| std::array::from_fn(|k| at(k)[axis]))
        };
        let core = Core::Vertices(points.chunks(POINTS_AT_ONCE).map(group).collect());
        let size = points.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
        Some(Self { core, swept, size })
    }

    /// The normal of a half-space, of unit length.
    pub(super) fn normal(&self) -> Option<DVec3> {
        match self.core {
            Core::Plane(normal, _) => Some(normal),
            _ => None,
        }
    }

    /// At least the largest p·d of the shape's points p, for two d in its own frame.
    #[inline]
    pub(super) fn along(&self, directions: [DVec3; 2]) -> [f64; 2] {
        let far = match &self.core {
            Core::Discs(discs) => directions.map(|d| {
                let flat = (d.x * d.x + d.y * d.y).sqrt();
                let [a, b] = discs.map(|(z, r)| z * d.z + r * flat);
                a.max(b)
            }),
            Core::Vertices(points) => dispatch(Farthest { points, directions }),
            Core::Point(point) => directions.map(|d| point.dot(d)),
            Core::Plane(normal, offset) => directions.map(|d| {
                let length = d.length();
                let is_along = (d - normal * length).length() <= PARALLEL * length;
                if is_along { offset * length } else { f64::INFINITY }
            }),
        };
        [0, 1].map(|k| {
            let d = directions[k];
            let norm = d.abs().element_sum();
            far[k] + self.swept * d.length() + DOT * 4.0 * (self.size + self.swept) * norm
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_point_of_a_shape_is_beyond_its_support_or_nearer_than_its_solid() {
        let corner = |k: i32| {
            DVec3::new(f64::from(k % 5) * 0.31, f64::from(k % 7) - 2.0, f64::from(k % 3) * 0.7)
        };
        let hull = Shape::hull((0..35).map(corner).collect()).unwrap();
        // A tetrahedron with a triangle inside.
        let corners = [[0.0, 0.0, 1.0], [1.0, 0.0, -0.5], [-0.6, 0.8, -0.5], [-0.6, -0.8, -0.5]];
        let vertices = corners.into_iter().chain(corners.map(|v| v.map(|x| 0.1 * x)));
        let triangles = vec![[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 2, 3], [4, 5, 6]];
        let mesh = Shape::mesh(vertices.map(DVec3::from).collect(), triangles).unwrap();
        let shapes = [
            Shape::cuboid(DVec3::new(1.0, 2.0, 0.01)).unwrap(),
            Shape::sphere(0.3).unwrap(),
            mesh.clone(),
            mesh.rounded(0.05).unwrap(),
            Shape::cylinder(0.4, 0.2).unwrap(),
            Shape::cylinder(0.4, 0.2).unwrap().rounded(0.1).unwrap(),
            Shape::cone(0.4, 0.2).unwrap(),
            hull.clone(),
            hull.rounded(0.05).unwrap(),
        ];
        for shape in shapes {
            let BoundingVolumes { support, solid, whole, .. } =
                BoundingVolumes::of(&shape, MOST_SPHERES, &mut Covers::default());
            let support = support.unwrap();
            let at = dcd_gjk::PosedShape { shape: &shape, pose: &Pose::IDENTITY };
            for k in 0..300 {
                let angle = f64::from(k) * 2.399963;
                let z = 1.0 - (f64::from(k) + 0.5) / 150.0;
                let ring = (1.0 - z * z).sqrt();
                let d = DVec3::new(ring * angle.cos(), ring * angle.sin(), z);
                // A point far out along d: what the solvers measure to it.
                let p = d * (whole.outer + whole.centre.length() + 0.5 + f64::from(k % 4));
                let point = Shape::sphere(1e-9).unwrap();
                let pose = Pose::from_translation(p).unwrap();
                let there = dcd_gjk::PosedShape { shape: &point, pose: &pose };
                let dcd_gjk::distance::DistanceResult::Apart(found) =
                    dcd_gjk::distance::distance(at, there).0
                else {
                    panic!("{shape:?} {p}")
                };
                let (far, _) = solid.nearest(p);
                assert!(far <= found.upper() + 2e-9, "{shape:?} {p}: {far} {found:?}");
                assert!(
                    p.dot(d) - support.along([d, -d])[0] <= found.upper() + 2e-9,
                    "{shape:?} {d}"
                );
                // The support along the nearest direction is the distance itself.
                let along = p.dot(found.normal) - support.along([DVec3::X, found.normal])[1];
                assert!((along - found.distance).abs() < 1e-8, "{shape:?} {d}: {along} {found:?}");
            }
        }
    }

    #[test]
    fn a_box_is_as_far_as_it_is_and_what_has_no_end_nowhere() {
        let covers = &mut Covers::default();
        let plate = Shape::cuboid(DVec3::new(1.0, 2.0, 0.01)).unwrap();
        let plate = BoundingVolumes::of(&plate, MOST_SPHERES, covers);
        assert!((plate.solid.nearest(DVec3::new(0.0, 1.5, 1.0)).0 - 0.99).abs() < 1e-15);
        assert!(plate.solid.nearest(DVec3::new(0.5, -1.9, 0.0)).0 <= 0.0);
        let ground = BoundingVolumes::of(&Shape::half_space(DVec3::Z, 0.0).unwrap(), 1, covers);
        assert!(!(ground.solid.nearest(DVec3::Z * 9.0).0 > 0.0));
        assert!(ground.whole.outer == f64::INFINITY && ground.reach == 0.0);
        let slope = Shape::half_space(DVec3::new(0.0, 3.0, 4.0), 10.0).unwrap();
        let slope = BoundingVolumes::of(&slope.rounded(0.5).unwrap(), 1, covers);
        let ends = slope.support.unwrap().along([DVec3::new(0.0, 0.6, 0.8) * 3.0, DVec3::Z]);
        assert!((ends[0] - 7.5).abs() < 1e-13 && ends[1] == f64::INFINITY && slope.reach == 2.5);
    }
}
