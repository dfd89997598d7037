//! What the fuzz targets check, each for any bytes. A violated law panics, which is what a fuzzer
//! looks for; docs/fuzzing.md says how to run them.
#![forbid(unsafe_code)]
#![deny(missing_docs)]

mod frames;
mod hull;
mod input;
mod judge;
mod measures;
mod overlap;
mod probe;
mod readers;
mod scene;

pub use frames::frames;
pub use hull::hull;
pub use input::Input;
pub use measures::measures;
pub use overlap::overlap;
pub use probe::probe;
pub use readers::readers;
pub use scene::scene;
