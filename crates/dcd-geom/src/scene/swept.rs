//! A scene whose shapes have grown: what is within a margin of what.

use super::{Slot, check_reach};
use crate::{Motion, Revision, Scene, Shape};
use std::sync::Arc;

impl Scene {
    /// A scene of the same objects in the same slots, every shape with a sphere of this radius swept round it
    /// (see [`Shape::swept`]), in metres. `None` for a radius that is negative or not finite, and
    /// where a shape or an object would reach out of range.
    pub fn swept(&self, radius: f64) -> Option<Self> {
        let grown: Result<Vec<Shape>, _> = self.shapes.iter().map(|s| s.swept(radius)).collect();
        let shapes = grown.ok()?;
        let mut copy =
            Self { shapes: Arc::default(), shape_history: Default::default(), ..self.clone() };
        copy.add_shapes(shapes).ok()?;
        copy.static_revision = Revision::draw();
        copy.is_in_range().then_some(copy)
    }

    /// Takes the poses of a scene of the same layout; whether all objects are then in range. If
    /// not, only another call makes this scene one to be used again.
    pub fn follow(&mut self, original: &Self) -> bool {
        let moved = |i: usize| self.poses[i] != original.poses[i];
        let stands = |i: usize| self.slots[i] == Slot::Holds(Motion::Static);
        if self.statics > 0 && (0..self.len()).any(|i| stands(i) && moved(i)) {
            self.static_revision = Revision::draw();
        }
        self.poses.clone_from(&original.poses);
        self.pose_revision.mark();
        self.is_in_range()
    }

    fn is_in_range(&self) -> bool {
        (0..self.len()).all(|i| {
            self.slots[i] == Slot::Free || check_reach(i, self.shape(i), &self.poses[i]).is_ok()
        })
    }
}
