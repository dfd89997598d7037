//! Parry 0.31 behind the traits of this workspace, in its f32 build and in its f64 one.
//!
//! - [`ParryGjk`]: its GJK on our support maps, one pair at a time.
//! - [`ParryShapes`]: its own shapes through its public queries, as a narrow phase.
//! - [`ParryBvh`]: its bounding volume hierarchy, as a broad phase.
//! - [`ParryWorld`]: its tree queried with posed shapes against static obstacles.
//! - [`ParryRobot`]: a robot's states, links against each other and against its obstacles.
//! - [`ParryPipeline`]: its best pipeline from AABBs to contacts, each stage its own: the rival.
//!
//! ```
//! use dcd_geom::{Pose, Scene, Shape, glam::DVec3};
//! use dcd_parry::{ParryBvh, ParryPipeline, ParryShapes, Query};
//! use dcd_pipeline::{Par, Pipeline};
//!
//! let poses = [0.0, 1.5, 4.0].map(|x| Pose::from_translation(DVec3::X * x));
//! let poses = poses.into_iter().collect::<Result<Vec<_>, _>>()?;
//! let scene = Scene::one_each(vec![Shape::sphere(1.0)?; 3], poses)?;
//!
//! let mut swapped = Pipeline::with(ParryBvh::default(), ParryShapes::<f64>::new(&scene));
//! let contacts: Vec<_> = swapped.step(&scene, Par::Serial).contacts().collect();
//! assert_eq!(contacts, [(0, 1)]);
//!
//! let mut rival = ParryPipeline::<f32>::new(&scene, Query::IntersectionTest);
//! let mut ready = rival.place(&scene); // poses as Parry holds them: not part of its step
//! assert_eq!(ready.step(Par::Pool).contact_count(), 1);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! What Parry says is passed on as it is, right or wrong; what it does not say (it panics, it runs
//! out of iterations where that is visible, it refuses the shape, the numbers leave its range) is
//! undecided. Deliberately absent: any repair of its answers, and any use of it by the rest.
#![forbid(unsafe_code)]

mod bvh;
mod forms;
mod gjk;
mod library;
mod pipeline;
mod robot;
mod shapes;
mod world;

pub use bvh::ParryBvh;
pub use gjk::ParryGjk;
pub use library::{Library, Query};
pub use pipeline::{ParryPipeline, ParryStep, Ready, Upkeep};
pub use robot::ParryRobot;
pub use shapes::{ParryShapes, ShapesFrame};
pub use world::{Hit, ParryWorld, Posed, Until};
