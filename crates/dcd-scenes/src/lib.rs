//! Everything that makes or reads input: seeded scenes, and readers of real files.
//!
//! A [`SceneSpec`] names a scene and makes it from a seed, the same on every machine. Readers take
//! bytes and refuse what is wrong with its place and value; none panics, and none allocates for a
//! count before it has seen that the file can hold so many. Both give a [`RawScene`], the plain
//! material, which becomes a checked [`dcd_geom::Scene`]:
//!
//! ```
//! use dcd_scenes::SceneSpec;
//! let scene = SceneSpec::paper().with_objects(100).with_seed(7).scene()?;
//! assert_eq!(scene.len(), 100);
//! # Ok::<(), dcd_scenes::SpecError>(())
//! ```
//!
//! Deliberately absent: threads, clocks, pair finding, answers, and std's sine and power, whose
//! last bits differ from machine to machine (libm's do not).
#![forbid(unsafe_code)]

mod boxes;
mod bytes;
mod capture;
mod cloud;
mod clouds;
pub mod conformance;
pub mod data;
mod error;
mod game_hulls;
#[cfg(feature = "hull")]
mod hull;
mod hull_scene;
#[cfg(feature = "meshes")]
mod mesh;
mod pairs;
mod pile;
mod ply;
mod random;
mod raw;
mod recipe;
#[cfg(feature = "robots")]
pub mod robot;
mod spec;
mod swept;
mod walk;

pub use boxes::{load_boxes, read_boxes};
pub use capture::{Capture, CaptureError, place_frame};
pub use cloud::{CloudCensus, CloudKind};
pub use clouds::{load_clouds, read_clouds};
pub use error::ReadError;
pub use error::shown;
pub use game_hulls::{GameHulls, GameSize};
#[cfg(feature = "hull")]
pub use hull::{Hull, HullRefusal, convex_hull};
pub use hull_scene::{load_hull_scene, read_hull_scene, write_hull_scene};
#[cfg(feature = "meshes")]
pub use mesh::{load_mesh, load_obj, poses_in, read_obj};
pub use pairs::{LONGEST_LINE, PairError, PairFault, PairInput, read_pair, read_pairs};
pub use pile::{Pile, PileContact};
pub use ply::{Frame, load_frame, read_frame};
pub use raw::{BuildError, RawObject, RawScene, RawShape};
pub use spec::{SceneSpec, SpecError};
pub use swept::{SweptBoxes, load_listed_pairs, read_listed_pairs};
pub use walk::RandomWalk;
