//! Poses, shapes, support maps, bounds and scenes.
//!
//! A [`Scene`] owns checked [`Shape`]s and places them by [`Pose`]s; whatever depends on a shape alone
//! is computed once, when the shape is made. A [`SupportMap`] is all that a solver needs of a convex
//! shape. Input is f64 (glam); AABBs are f32, rounded outward. [`contract`] tests a support map.
//!
//! Deliberately absent: threads, trees over objects, solvers, files, `unsafe`.
#![forbid(unsafe_code)]

pub mod contract;
mod curved;
mod ellipsoid;
mod error;
mod facet_planes;
mod facets;
mod feature_rows;
mod half_space;
mod hull;
mod list;
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

pub use curved::{Curved, CurvedKind};
pub use dcd_simd::{Aabb, Aabb16, BoundingSphere, Pair, Sphere16};
pub use ellipsoid::Ellipsoid;
pub use error::{PoseError, SceneError, ShapeError};
pub use facet_planes::{FacetPlanes, PlaneRow};
pub use facets::{FLATNESS, Facet, Facets, HalfEdge};
pub use feature_rows::{EdgeRow, FaceRow, FeatureRows};
pub use half_space::HalfSpace;
pub use hull::{ConvexHull, Dimension, HullError};
pub use list::List;
pub use obb::ObbBounds;
pub use parts::{Adjacency, Compound, Corners, LeafFilter, Mesh, Part, PartTree, Triangles};
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
