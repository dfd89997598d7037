//! Where the mesh files of a URDF are, and how they are read.

use super::{LinkShapes, RobotError};
use dcd_io::{MeshPaths, TriangleMesh, UpAxis};
use glam::DVec3;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Where a robot's mesh files are and how they are read.
#[derive(Clone, Debug)]
pub struct MeshSource {
    /// Where they are.
    pub paths: MeshPaths,
    /// Which way is up in them.
    pub up_axis: UpAxis,
    /// What each is taken as.
    pub shapes: LinkShapes,
    /// Links whose meshes are taken as something else, by their names.
    pub of_links: BTreeMap<String, LinkShapes>,
}

impl MeshSource {
    /// Meshes beside or above files of a folder, as they stand in their files.
    pub(super) fn beside(folder: &Path, shapes: LinkShapes) -> Self {
        let (paths, of_links) = (MeshPaths::new(folder), BTreeMap::new());
        Self { paths, up_axis: UpAxis::Ros, shapes, of_links }
    }

    /// What the meshes of a link are taken as.
    pub(super) fn shapes_of(&self, link: &str) -> LinkShapes {
        self.of_links.get(link).copied().unwrap_or(self.shapes)
    }

    /// The file of the mesh that `user` names.
    pub(super) fn find(&self, name: &str, user: &str) -> Result<PathBuf, RobotError> {
        let found = self.paths.resolve(name);
        found.map_err(|error| RobotError::NoMesh { user: user.to_owned(), error })
    }

    /// The mesh that `user` names, scaled.
    pub(super) fn load(
        &self,
        path: &Path,
        scale: DVec3,
        user: &str,
    ) -> Result<TriangleMesh, RobotError> {
        let mesh = TriangleMesh::load_with(path, self.up_axis, self.paths.opened());
        let mesh = mesh.map_err(|error| RobotError::Mesh { user: user.to_owned(), error })?;
        Ok(mesh.scaled(scale))
    }
}
