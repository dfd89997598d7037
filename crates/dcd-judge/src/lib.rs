//! The judge of tests and measurements: what is true of two polytopes, rounded or not, in whole
//! numbers of any length.
//!
//! World vertices R·v + t are sums of products of f64s, hence whole numbers of one power of two.
//! On them three methods answer, none of which shares code or method with the solvers:
//! - [`touches`]: a linear program (Bland's rule), and for radii the nearest feature;
//! - [`Truth`]: the signed depth, as the least reach over every direction that a facet, an edge or a
//!   vertex of A − B can have, in all digits of an f64;
//! - [`distance_is_in`]: by enumerating the vertices, segments and triangles of A − B.
//!
//! [`shapes_touch`] applies the first to compounds and meshes part by part, and knows cylinders and cones
//! where comparing squares decides.
//!
//! [`Replay`] replays the certificates of robot edges by kinematics of its own in interval arithmetic; the binary
//! `dcd-replay` does so with a file.
//!
//! A crate of its own, and never published, so that both the tests of other crates and the
//! measuring binaries can be judged by it. No library depends on it. It costs milliseconds a pair
//! and grows with the sixth power of the vertices: for hulls of up to some thirty points.
#![forbid(unsafe_code)]

mod directions;
mod features;
mod program;
mod replay;
mod rounding;
mod shapes;
mod truth;
mod world;

pub use features::{distance_is_in, touches};
pub use replay::{BUDGET, Replay, Replayed};
pub use shapes::{Placed, curved_touch, shapes_touch};
pub use truth::Truth;

use dcd_geom::{Polytope, Pose};

/// A polytope and where it is.
pub type Side<'a> = (&'a Polytope, &'a Pose);
