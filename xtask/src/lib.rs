//! Drives the workspace: builds and runs the measuring binaries, runs the checks. It measures nothing
//! itself, and knows the workspace only through cargo.
//!
//! A library too, so that `cargo test` holds the workspace to its [policy] without the command.

#![forbid(unsafe_code)]

pub mod cargo;
pub mod ci;
pub mod license;
pub mod measure;
pub mod policy;
pub mod results;
