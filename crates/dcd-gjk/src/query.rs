//! Queries beyond yes or no. Each is a type that the user chooses and pays for.
//!
//! | type | finds | answer for each pair |
//! | --- | --- | --- |
//! | [`Within`] | which pairs are within a margin | nothing |
//! | [`Distances`] | how far apart, within a margin | [`Distance`](crate::Distance) |
//! | [`Depths`] | how deep | [`Depth`](crate::epa::Depth) |
//! | [`Manifolds`] | where they touch, in up to four points a patch | [`ManifoldSet`] |
//! | [`Proximities`] | how far or how deep, and how that changes with the poses | [`Proximity`] |
//!
//! [`Within`] is a narrow phase. The others are solvers of single pairs: [`ThenMeasure`] runs them
//! after the SIMD test, and only on the pairs that it finds, so that a scene of which one pair
//! in fifty touches pays for one in fifty. [`Pairwise`](crate::Pairwise) runs them on every pair.
//!
//! ```
//! use dcd_gjk::{Depths, Distances, ThenMeasure};
//! let how_deep = ThenMeasure::new(Depths)?;
//! let how_far = ThenMeasure::new(Distances::within(0.05)?)?;
//! # Ok::<(), dcd_geom::ShapeError>(())
//! ```
//!
//! [`WithAccuracy`] gives a solver a wider bound for less time; the bound is proved all the same.
//!
//! Every number is in metres, every vector in the world frame. A normal points from a, the object
//! with the smaller index, to b. For (b, a) a solver returns the same bits, mirrored. A bound
//! is proved: the true value lies within it.

mod accuracy;
mod contact_set;
mod depths;
mod distance_contacts;
mod distances;
mod few_parts;
mod local;
mod manifold;
mod open_triangles;
pub mod point;
mod proximity;
pub mod ray;
mod sampled;
mod then_measure;
mod within;

pub use crate::mesh::PartIndex;
pub use accuracy::{Accuracy, FoundDepth, FoundPair, MeasureAt, MeasureDepth, WithAccuracy};
pub use depths::Depths;
pub use distance_contacts::DistanceContacts;
pub use distances::Distances;
pub use manifold::{
    Feature, Manifold, ManifoldContacts, ManifoldOptions, ManifoldPoint, ManifoldSet, Manifolds,
    MeshEdges, MeshSides,
};
pub use proximity::{Gradient, Proximities, Proximity, Smoothness, Twist};
pub use then_measure::ThenMeasure;
pub use within::Within;

pub use crate::simd::CuboidPatch;

pub(crate) use depths::CERTIFIED;
pub(crate) use distances::{
    distance_at_once, distance_of_mesh_within, spheres_are_apart, within_margin,
};
pub use few_parts::PartContact;
pub(crate) use few_parts::{FoundParts, PartSpheres, may_be_nearest};
pub(crate) use manifold::{FACING, LEVEL, case_of};
pub(crate) use within::grown;

use dcd_geom::{Aabb, ShapeError};

/// The fewest pairs that are worth a task where they are measured: each takes half a microsecond and more.
pub(crate) const FEWEST_MEASURED: usize = 128;

/// Refuses a margin that is no length, or larger than AABBs can hold.
pub(crate) fn check_margin(margin: f64) -> Result<(), ShapeError> {
    // Written so that NaN is refused.
    if (0.0..=Aabb::LIMIT).contains(&margin) {
        Ok(())
    } else {
        Err(ShapeError::BadLength { what: "margin", value: margin })
    }
}
