//! The shapes of links, each mesh file read once.

use super::bounds::{MESH_FILES, VERTICES};
use super::scan::bounded;
use super::urdf::Geometry;
use super::{LinkShapes, MeshSource, RobotError, world};
use dcd_geom::{ConvexHull, Shape};
use glam::DVec3;
use std::collections::{BTreeSet, HashMap};
use std::path::PathBuf;

/// Makes shapes of the geometry that a file describes.
pub(super) struct Shapes<'a> {
    source: &'a MeshSource,
    /// Where each name leads.
    files: HashMap<String, PathBuf>,
    /// Of each file at each scale, by its bits.
    meshes: HashMap<(PathBuf, [u64; 3]), Shape>,
    vertices: usize,
    /// What a user should know of how mesh files were read, each once.
    pub(super) notes: BTreeSet<String>,
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

    /// The shape of a geometry that `user` has.
    pub(super) fn shape(&mut self, geometry: &Geometry, user: &str) -> Result<Shape, RobotError> {
        let refused = |error| RobotError::Shape { user: user.to_owned(), error };
        let shape = match geometry {
            Geometry::Box { size } => Shape::cuboid(*size * 0.5).map_err(refused)?,
            Geometry::Sphere { radius } => Shape::sphere(*radius).map_err(refused)?,
            Geometry::Cylinder { radius, length } => {
                world::cylinder(*length, *radius).map_err(refused)?
            }
            Geometry::Capsule { radius, length } => {
                world::capsule(*length, *radius).map_err(refused)?
            }
            Geometry::Mesh { file, scale } => self.mesh(file, *scale, user)?,
        };
        self.vertices += match &shape {
            Shape::Polytope(hull) => hull.vertices().len(),
            Shape::Mesh(mesh) => mesh.vertices().len(),
            _ => 1,
        };
        bounded("vertices of all collision geometry", self.vertices, VERTICES)?;
        Ok(shape)
    }

    fn mesh(&mut self, name: &str, scale: DVec3, user: &str) -> Result<Shape, RobotError> {
        let file = match self.files.get(name) {
            Some(file) => file.clone(),
            None => {
                let file = self.source.find(name, user)?;
                self.files.insert(name.to_owned(), file.clone());
                bounded("mesh files", self.files.len(), MESH_FILES)?;
                file
            }
        };
        let key = (file, scale.to_array().map(f64::to_bits));
        if let Some(known) = self.meshes.get(&key) {
            return Ok(known.clone());
        }
        let mesh = self.source.load(&key.0, scale, user)?;
        let notes =
            mesh.warnings.iter().map(|warning| format!("{}: {warning}", dcd_io::shown(&key.0)));
        self.notes.extend(notes);
        let shape = match self.source.shapes {
            LinkShapes::Hulls => Shape::hull(corners(mesh.vertices)),
            LinkShapes::Meshes => Shape::mesh(mesh.vertices, mesh.triangles),
        };
        let shape = shape.map_err(|error| RobotError::Shape { user: user.to_owned(), error })?;
        self.meshes.insert(key, shape.clone());
        Ok(shape)
    }
}

/// The corners of the points' hull, flat ones' too; all points where exact signs are out of reach, or
/// where the shape will refuse them.
fn corners(points: Vec<DVec3>) -> Vec<DVec3> {
    match ConvexHull::of(&points) {
        Ok(hull) => hull.corners().iter().map(|&k| points[k as usize]).collect(),
        Err(_) => points,
    }
}
