//! Readers and writers of files: meshes, point clouds, AABBs, hull scenes, captures, pairs.
//!
//! Readers take bytes. An error names the place and the value that is wrong; none panics, and none
//! allocates for a count before it has seen that the file can hold so many. A scene is read as a
//! [`RawScene`], the plain numbers, which becomes a checked [`dcd_geom::Scene`].
//!
//! Deliberately absent: threads, clocks, pair finding, answers, random numbers.
#![forbid(unsafe_code)]

mod boxes;
mod bytes;
mod capture;
mod cloud;
mod clouds;
pub mod data;
mod error;
#[cfg(feature = "meshes")]
mod glb;
mod hull;
mod hull_scene;
mod lines;
#[cfg(feature = "meshes")]
mod mesh;
mod pairs;
mod ply;
mod raw;
pub mod run;
mod swept;
#[cfg(feature = "meshes")]
mod xml_bounds;

#[cfg(all(doctest, feature = "meshes"))]
#[doc = include_str!("../../../docs/meshes.md")]
mod mesh_files {}

pub use boxes::{load_boxes, read_boxes};
pub use capture::{Capture, CaptureError, place_frame, read_shape, write_shape};
pub use cloud::{CloudCensus, CloudKind};
pub use clouds::{load_clouds, read_clouds};
pub use error::{ReadError, shown};
#[cfg(feature = "meshes")]
pub use glb::{GlbContact, GlbScene};
pub use hull::{Hull, HullRefusal, convex_hull};
pub use hull_scene::{
    HullRecords, load_hull_records, load_hull_scene, read_hull_scene, write_hull_scene,
};
pub use lines::{LONGEST_LINE, read_lines};
#[cfg(feature = "meshes")]
pub use mesh::{
    MeshError, MeshFormat, MeshNotFound, MeshOptions, MeshPaths, MeshPlace, MeshWarning,
    OpenedFiles, TriangleMesh, UpAxis, load_mesh, load_obj, read_obj,
};
pub use pairs::{PairError, PairFault, PairInput, read_pair, read_pairs};
pub use ply::{RawMesh, load_ply, read_ply};
pub use raw::{BuildError, RawObject, RawScene, RawShape, RawShare};
pub use swept::{SweptBoxes, load_listed_pairs, read_listed_pairs};
#[cfg(feature = "meshes")]
pub use xml_bounds::{XmlBounds, XmlTooLarge};
