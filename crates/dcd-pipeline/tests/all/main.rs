//! The pipeline as its users have it. One binary: what each file would compile anew is compiled once.
#![allow(missing_docs)]

mod adversary;
mod answers;
mod capture;
mod frames;
mod half_space;
mod moving;
mod order;
mod panics;
mod queries;
#[path = "../random/mod.rs"]
mod random;
mod remembered;
mod scene_queries;
mod sensors;
mod world;
