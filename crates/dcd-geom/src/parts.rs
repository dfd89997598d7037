//! Shapes made of convex parts: compounds and triangle meshes, each with a tree over its parts
//! that is built once, when the shape is made.

mod adjacency;
mod build;
mod compound;
mod mesh;
mod tree;
mod visit;

pub use adjacency::Adjacency;
pub use compound::{Compound, Part};
pub use mesh::{Corners, Mesh, Triangles};
pub use tree::PartTree;
pub use visit::LeafFilter;
