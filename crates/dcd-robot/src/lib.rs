//! Robots and the worlds they stand in: URDF with OBJ meshes, SRDF, MoveIt's scenes and requests.
//!
//! A [`Robot`] is its links' shapes and its joints; [`Robot::place`] says where its shapes
//! are for joint values. [`AllowedPairs`] are those links that may touch. A [`World`] is boxes,
//! cylinders and spheres. A [`Workcell`] is all of them as one checked scene, with names, whose
//! pairs that may touch are refused before any narrow work.
//!
//! Sines and cosines are libm's, so that a pose is the same on every machine.
#![forbid(unsafe_code)]

mod allowed;
mod archive;
mod error;
mod kinematics;
mod mesh;
mod model;
mod problem;
mod request;
mod workcell;
mod world;

pub use allowed::AllowedPairs;
pub use archive::{LARGEST_ARCHIVE, LARGEST_ENTRY};
pub use error::RobotError;
pub use model::{Joint, Link, LinkShapes, Motion, Part, Robot};
pub use problem::{Problem, problems_in, read_problems};
pub use request::Request;
pub use workcell::Workcell;
pub use world::{Obstacle, World};
