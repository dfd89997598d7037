//! What the fuzz targets check, each for any bytes. A violated contract panics, which is what a fuzzer
//! looks for; docs/fuzzing.md says how to run them.
#![forbid(unsafe_code)]
#![deny(missing_docs)]

mod far;
mod frames;
mod hull;
mod input;
mod judge;
mod measures;
mod meshes;
mod overlap;
mod probe;
mod readers;
mod robots;
mod scene;
mod text;

pub use far::far;
pub use frames::frames;
pub use hull::hull;
pub use input::Input;
pub use measures::measures;
pub use meshes::{collada, gltf, stl};
pub use overlap::overlap;
pub use probe::probe;
pub use readers::readers;
pub use robots::{archives, srdf, urdf};
pub use scene::scene;
pub use text::{obj, requests, scenes};
