//! Seeded scenes, drawn on all threads: before any clock starts.

use dcd_exec::{Exec, Par};
use dcd_geom::Scene;
use dcd_scenes::{SceneSpec, SpecError};

/// The same scene as [`SceneSpec::scene`].
///
/// # Errors
/// Those of [`SceneSpec::scene`].
pub fn draw(spec: &SceneSpec) -> Result<Scene, SpecError> {
    spec.scene_by(&|count, task| Exec::from(Par::Pool).tasks(count, task))
}
