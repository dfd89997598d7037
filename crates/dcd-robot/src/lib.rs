//! Robots and their surroundings: URDF with its meshes, SRDF, MoveIt's scenes and requests.
//!
//! A [`Robot`] has links with shapes, and joints; [`Robot::place`] computes the poses of its shapes from
//! joint values (forward kinematics). [`AllowedPairs`] are the links that may touch. A [`World`] is
//! boxes, cylinders and spheres. A [`Workcell`] is all of them as one checked scene, with names; pairs
//! that may touch are filtered before the narrow phase.
//!
//! A [`StateChecker`] takes states sixteen at a time, an [`EdgeChecker`] whole motions.
//!
//! Sines and cosines are libm's, so that a pose is the same on every machine.
#![forbid(unsafe_code)]

mod allowed;
mod angle;
mod archive;
pub mod bounds;
mod clearance;
mod edge;
mod error;
mod frames;
mod generate;
mod json;
mod kinematics;
mod mesh;
mod model;
mod names;
mod notes;
mod objects;
mod padding;
mod problem;
mod request;
mod scan;
mod scene;
mod scene_text;
mod sensed;
mod several;
mod shapes;
mod srdf;
mod state_checker;
mod states;
mod tree;
mod urdf;
mod workcell;
mod world;
mod xml;
mod yaml;

pub use allowed::AllowedPairs;
pub use archive::{LARGEST_ARCHIVE, LARGEST_ENTRY};
pub use clearance::Clearance;
pub use edge::{
    CertifiedPair, Edge, EdgeAnswer, EdgeCertificate, EdgeChecker, EdgeReason, JointPath,
    SeparatingPlane,
};
pub use error::RobotError;
pub use generate::{LinkPair, PairReason, PairSearch, write_srdf};
pub use kinematics::BeyondLimits;
pub use mesh::MeshSource;
pub use model::{Drive, Joint, Link, LinkShapes, Motion, MovedJoint, Part, Robot};
pub use problem::{Problem, problems_in, read_problems};
pub use request::Request;
pub use scene::PlanningScene;
pub use sensed::{SensedPoint, SensedWorld};
pub use srdf::{EndEffector, Group, GroupMember, GroupState, JointGroup, Srdf, VirtualJoint};
pub use state_checker::{SensedHit, StateChecker, StateHit};
pub use states::{AttachedObject, EdgeRequest, State, StateReader};
pub use workcell::Workcell;
pub use world::{Attached, Obstacle, Padding, World};

/// The guide's page, whose code is compiled and run.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/guide/robots.md")]
mod guide {}
