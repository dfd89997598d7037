//! All that a scene needs, in one line: `use dcd_pipeline::prelude::*;`.
//!
//! Shapes, poses and objects; the pipeline and what a step returns; the narrow phases to choose from; glam's
//! vector and quaternion, in the version that the interface takes.

pub use crate::{
    Answer, AnyPipeline, AnyStep, Change, Event, Events, Exec, Par, Pipeline, Precision, Question,
    Step, WideTree,
};
pub use dcd_geom::glam::{DQuat, DVec3};
pub use dcd_geom::{Filter, Handle, Motion, Object, ObjectRef, Pair, Pose, Scene, Shape};
pub use dcd_gjk::query::{
    Feature, ManifoldOptions, ManifoldPoint, MeshEdges, MeshSides, PartIndex,
};
pub use dcd_gjk::{
    Accuracy, BoundsOnly, Certified, Coherent, Contact, Depths, Distances, Gjk, Manifold,
    ManifoldSet, Manifolds, Overlap, OverlapUnchecked, Pairwise, Proximities, SimdDepths,
    ThenMeasure, Verdict, WithAccuracy, Within,
};
