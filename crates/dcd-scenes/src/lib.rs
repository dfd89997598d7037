//! Seeded scenes, and the conformance suite.
//!
//! A [`SceneSpec`] names a scene and makes it from a seed, the same on every machine: as a
//! [`RawScene`], the plain material, which becomes a checked [`dcd_geom::Scene`]:
//!
//! ```
//! use dcd_scenes::SceneSpec;
//! let scene = SceneSpec::paper().with_objects(100).with_seed(7).scene()?;
//! assert_eq!(scene.len(), 100);
//! # Ok::<(), dcd_scenes::SpecError>(())
//! ```
//!
//! Deliberately absent: readers of files (`dcd-io`), robots (`dcd-robot`), threads (a [`Run`] brings
//! them), clocks, pair finding, answers, and std's sine and power, whose last bits differ from
//! machine to machine (libm's do not).
#![forbid(unsafe_code)]

pub mod conformance;
mod game_hulls;
mod pile;
mod poses;
mod random;
mod recipe;
mod spec;
mod terrain;
mod walk;

pub use dcd_io::run::Run;
pub use dcd_io::{BuildError, RawObject, RawScene, RawShape, RawShare};
use dcd_io::{ReadError, data, load_clouds};
pub use game_hulls::{GameHulls, GameSize};
pub use pile::{Pile, PileContact};
pub use poses::poses_in;
pub use spec::{SceneSpec, SpecError};
pub use terrain::terrain;
pub use walk::RandomWalk;
