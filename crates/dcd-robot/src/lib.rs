//! Robots and the worlds they stand in: URDF with OBJ meshes, SRDF, MoveIt's scenes and requests.
//!
//! A [`Robot`] is its links' shapes and its joints; [`Robot::place`] says where its shapes
//! are for joint values. [`AllowedPairs`] are those links that may touch. A [`World`] is boxes,
//! cylinders and spheres, by a [`PlanningScene`], with what that says of the robot. A [`Workcell`] is all of them as one checked scene, with names, whose
//! pairs that may touch are refused before any narrow work.
//!
//! Whatever a file says is used, refused, or named in the `notes` of what was read; [`bounds`] are
//! checked before the work that they bound. A mesh's name may lead anywhere in the file system: up
//! from the URDF's folder, and to absolute paths.
//!
//! Sines and cosines are libm's, so that a pose is the same on every machine.
#![forbid(unsafe_code)]

mod allowed;
mod archive;
pub mod bounds;
mod error;
mod frames;
mod kinematics;
mod mesh;
mod message;
mod model;
mod names;
mod notes;
mod objects;
mod padding;
mod problem;
mod request;
mod scan;
mod scene;
mod shapes;
mod srdf;
mod tree;
mod urdf;
mod workcell;
mod world;
mod xml;
mod yaml;

pub use allowed::AllowedPairs;
pub use archive::{LARGEST_ARCHIVE, LARGEST_ENTRY};
pub use error::RobotError;
pub use kinematics::BeyondLimits;
pub use model::{Drive, Joint, Link, LinkShapes, Motion, Part, Robot};
pub use problem::{Problem, problems_in, read_problems};
pub use request::Request;
pub use scene::PlanningScene;
pub use srdf::{Srdf, VirtualJoint};
pub use workcell::Workcell;
pub use world::{Attached, Obstacle, Padding, World};
