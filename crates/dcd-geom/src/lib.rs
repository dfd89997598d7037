//! What every stage shares: poses, boxes, shapes, support maps, scenes and SIMD lanes.
//!
//! A [`Scene`] owns checked [`Shape`]s and places them by [`Pose`]s; whatever depends on a shape
//! alone is computed once, when it is made. Input is f64 (glam); boxes are f32 rounded outward.
//!
//! Deliberately absent: threads, trees, solvers, files. The lanes stand in `dcd-simd`, and
//! can be had here as [`lanes`].
#![forbid(unsafe_code)]

pub mod contract;
mod core;
mod curved;
mod error;
mod facets;
mod half_space;
mod hull;
mod inscribed;
mod obb;
mod parts;
mod polytope;
mod pose;
mod real;
mod scene;
mod shape;
mod sphere;
mod sphere_bounds;
mod splittable;
mod support;

pub use core::{Core, Cores, MAX_PARTS, ObbBoundsF32};
pub use curved::{Curved, CurvedKind};
pub use dcd_simd::{Aabb, Aabb16, BoundingSphere, Pair, Sphere16};
pub use error::{PoseError, SceneError, ShapeError};
pub use facets::{FLATNESS, Facet, Facets};
pub use half_space::HalfSpace;
pub use hull::{ConvexHull, Dimension, HullError};
pub use obb::ObbBounds;
pub use parts::{Compound, Corners, Mesh, Part, PartTree, Triangles};
pub use polytope::{Kind, Polytope};
pub use pose::Pose;
pub use real::{Matrix, Real, Vector};
pub use scene::{Filter, Handle, Motion, Object, ObjectRef, Revision, Scene};
pub use shape::Shape;
pub use sphere::Sphere;
pub use sphere_bounds::{InscribedSphere, PackedSphereBounds, SphereBounds};
pub use splittable::Splittable;
pub use support::{Support, SupportMap};

/// glam, so that a user has the same version of it.
pub use glam;
