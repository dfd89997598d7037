//! The objects that stand for links, a row for each.

use super::set::ROW;
use super::{LinkSet, Obstacles};
use dcd_geom::{Object, Pose, Scene, SceneError};
use dcd_gjk::NarrowPhase;

/// Links, and a row of objects for each.
pub(super) struct LinkRows {
    pub(super) link_set: LinkSet,
    /// A row of objects for each link.
    pub(super) template: Scene,
    /// How many objects a row has: the configurations that are taken up at once, at most [`ROW`].
    pub(super) row: usize,
}

impl LinkRows {
    pub(super) fn new(link_set: LinkSet, row: usize) -> Result<Self, SceneError> {
        let row = row.min(ROW);
        let template = rows_of(&link_set, row)?;
        Ok(Self { link_set, template, row })
    }

    /// Checks that obstacles and the most objects of links together fit a u32.
    pub(super) fn check_count<N: NarrowPhase>(
        &self,
        world: &Obstacles<N>,
    ) -> Result<(), SceneError> {
        let count = world.len().saturating_add(self.link_set.len().saturating_mul(ROW));
        let fits = u32::try_from(count).is_ok();
        if fits { Ok(()) } else { Err(SceneError::TooMany { what: "objects", count }) }
    }

    /// Lengthens the rows.
    pub(super) fn lengthen(&mut self, row: usize) -> Result<(), SceneError> {
        (self.template, self.row) = (rows_of(&self.link_set, row)?, row);
        Ok(())
    }
}

/// A row of that many objects for each link.
fn rows_of(link_set: &LinkSet, row: usize) -> Result<Scene, SceneError> {
    // Their count is checked before.
    let links = 0..link_set.len() as u32;
    let objects = links.flat_map(|link| (0..row).map(move |_| Object::new(link, Pose::IDENTITY)));
    let rows = Scene::new(link_set.shapes.clone(), objects);
    rows.map_err(|error| match error {
        SceneError::OutOfRange { object, .. } => numbered(error, object / row),
        other => other,
    })
}

/// The error, renumbered to the object with that number.
pub(super) fn numbered(error: SceneError, number: usize) -> SceneError {
    match error {
        SceneError::OutOfRange { reach, .. } => SceneError::OutOfRange { object: number, reach },
        other => other,
    }
}
