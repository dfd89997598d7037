//! The shapes of links, each mesh file read once.

use super::bounds::{MESH_FILES, VERTICES};
use super::scan::bounded;
use super::urdf::Geometry;
use super::{LinkShapes, MeshSource, RobotError, world};
use dcd_geom::{Aabb, ConvexHull, Polytope, Shape};
use dcd_gjk::simplify::{Budget, SimplifyError, simplify};
use dcd_io::TriangleMesh;
use glam::DVec3;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::PathBuf;

/// Makes shapes of the geometry that a file describes.
pub(super) struct Shapes<'a> {
    pub(super) source: &'a MeshSource,
    /// Where each name leads.
    files: HashMap<String, PathBuf>,
    /// Of each file at each scale, by its bits.
    meshes: HashMap<(PathBuf, [u64; 3], LinkShapes), MadeShape>,
    vertices: usize,
    /// What a user should know of how mesh files were read, each once.
    notes: BTreeSet<String>,
}

/// A shape, and by how much at most it stands out of what it is made for, metres.
#[derive(Clone)]
pub(super) struct MadeShape {
    pub(super) shape: Shape,
    pub(super) tolerance: f64,
}

impl<'a> Shapes<'a> {
    pub(super) fn new(source: &'a MeshSource) -> Self {
        Self {
            source,
            files: HashMap::new(),
            meshes: HashMap::new(),
            vertices: 0,
            notes: BTreeSet::new(),
        }
    }

    /// The shape of a geometry that `user` has, a mesh taken as `meshes` says.
    pub(super) fn shape(
        &mut self,
        geometry: &Geometry,
        (user, meshes): (&str, LinkShapes),
    ) -> Result<MadeShape, RobotError> {
        let exact = |shape| MadeShape { shape, tolerance: 0.0 };
        let made = match geometry {
            Geometry::Box { size } => Shape::cuboid(*size * 0.5).map(exact),
            Geometry::Sphere { radius } => Shape::sphere(*radius).map(exact),
            Geometry::Cylinder { radius, length } => world::cylinder(*length, *radius).map(exact),
            Geometry::Capsule { radius, length } => world::capsule(*length, *radius).map(exact),
            Geometry::Mesh { file, scale } => Ok(self.mesh(file, *scale, (user, meshes))?),
        };
        let made = made.map_err(|error| RobotError::Shape { user: user.to_owned(), error })?;
        let reach = made.shape.reach();
        if !(reach <= Aabb::LIMIT) {
            return Err(RobotError::OutOfRange { user: user.to_owned(), reach });
        }
        self.vertices += match &made.shape {
            Shape::Polytope(hull) => hull.vertices().len(),
            Shape::Mesh(mesh) => mesh.vertices().len(),
            _ => 1,
        };
        bounded("vertices of all collision geometry", self.vertices, VERTICES)?;
        Ok(made)
    }

    fn mesh(
        &mut self,
        name: &str,
        scale: DVec3,
        (user, shapes): (&str, LinkShapes),
    ) -> Result<MadeShape, RobotError> {
        let file = match self.files.get(name) {
            Some(file) => file.clone(),
            None => {
                let file = self.source.find(name, user)?;
                self.files.insert(name.to_owned(), file.clone());
                bounded("mesh files", self.files.len(), MESH_FILES)?;
                file
            }
        };
        let key = (file, scale.to_array().map(f64::to_bits), shapes);
        if let Some(known) = self.meshes.get(&key) {
            return Ok(known.clone());
        }
        let mesh = self.source.load(&key.0, scale, user)?;
        let notes =
            mesh.warnings.iter().map(|warning| format!("{}: {warning}", dcd_io::shown(&key.0)));
        self.notes.extend(notes);
        let made = made(mesh, shapes, user)?;
        self.meshes.insert(key, made.clone());
        Ok(made)
    }

    /// What a user should know of the meshes: a sentence each.
    pub(super) fn notes(self) -> impl Iterator<Item = String> {
        let simple = self.meshes.iter().filter_map(|((.., shapes), made)| match shapes {
            LinkShapes::OuterHulls { vertices } if made.tolerance > 0.0 => {
                Some((*vertices, made.tolerance))
            }
            _ => None,
        });
        let mut largest: BTreeMap<usize, f64> = BTreeMap::new();
        for (vertices, tolerance) in simple {
            let most = largest.entry(vertices).or_default();
            *most = most.max(tolerance);
        }
        let simple = largest.into_iter().map(|(vertices, tolerance)| {
            format!(
                "meshes stand for hulls round them of at most {vertices} vertices, which are at most {tolerance:.2e} m larger"
            )
        });
        self.notes.into_iter().chain(simple)
    }
}

fn made(mesh: TriangleMesh, shapes: LinkShapes, user: &str) -> Result<MadeShape, RobotError> {
    let refused = |error| RobotError::Shape { user: user.to_owned(), error };
    let exact = |shape| MadeShape { shape, tolerance: 0.0 };
    match shapes {
        LinkShapes::Hulls => Shape::hull(corners(mesh.vertices)).map(exact).map_err(refused),
        LinkShapes::Meshes => {
            Shape::mesh(mesh.vertices, mesh.triangles).map(exact).map_err(refused)
        }
        LinkShapes::OuterHulls { vertices } => {
            let hull = Polytope::hull(corners(mesh.vertices)).map_err(refused)?;
            let simple = simplify(&hull, Budget { tolerance: 0.0, vertices });
            let simple = simple.map_err(|error| not_simple(error, user))?;
            let (shape, tolerance) = (Shape::Polytope(simple.outer.into()), simple.outer_distance);
            Ok(MadeShape { shape, tolerance })
        }
    }
}

fn not_simple(error: SimplifyError, user: &str) -> RobotError {
    let why = format!("a hull of few vertices: {error}");
    RobotError::Refused { user: user.to_owned(), why }
}

/// The corners of the points' hull, flat ones' too; all points where exact signs are out of reach, or
/// where the shape will refuse them.
fn corners(points: Vec<DVec3>) -> Vec<DVec3> {
    match ConvexHull::of(&points) {
        Ok(hull) => hull.corners().iter().map(|&k| points[k as usize]).collect(),
        Err(_) => points,
    }
}
