//! What every stage shares: poses, boxes, shapes, support maps, scenes and SIMD lanes.
//!
//! A [`Scene`] owns checked [`Shape`]s and places them by [`Pose`]s; whatever depends on a shape
//! alone is computed once, when it is made. Input is f64 (glam); boxes are f32 rounded outward.
//!
//! Deliberately absent: threads, trees, solvers, files. The lanes stand in `dcd-simd`, and
//! can be had here as [`lanes`].
#![forbid(unsafe_code)]

mod ball;
mod bound;
mod core;
mod curved;
mod divide;
mod error;
mod facets;
mod half_space;
mod hull;
mod inscribed;
pub mod law;
mod parts;
mod polytope;
mod pose;
mod real;
mod scene;
mod shape;
mod support;
mod twin_box;

pub use ball::Ball;
pub use bound::{Bound, Bounds, SnugBall};
pub use core::{Core, Cores, LaneBox, MOST_PARTS};
pub use curved::{Curved, CurvedKind};
pub use dcd_simd::{self as lanes, Aabb, BallRow, LooseBall, Pair, Sixteen};
pub use divide::Divide;
pub use error::{PoseError, SceneError, ShapeError};
pub use facets::{FLATNESS, Facet, Facets};
pub use half_space::HalfSpace;
pub use hull::{ConvexHull, Dimension, HullError};
pub use parts::{Compound, Corners, Mesh, Part, PartTree, Triangles};
pub use polytope::{Kind, Polytope};
pub use pose::Pose;
pub use real::{Matrix, Real, Vector};
pub use scene::{Filter, Handle, Motion, Object, ObjectRef, Scene, Stamp};
pub use shape::Shape;
pub use support::{Support, SupportMap};
pub use twin_box::TwinBox;

/// glam, so that a user has the same version of it.
pub use glam;
