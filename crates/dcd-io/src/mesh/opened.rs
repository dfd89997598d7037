//! Which files a reading has opened.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The files that were opened to read meshes: of the meshes, of what they name, and each `package.xml`. Clones
/// share one list.
///
/// A program that writes files can ask it which names it must not write to.
#[derive(Clone, Debug, Default)]
pub struct OpenedFiles(Arc<Mutex<BTreeSet<PathBuf>>>);

impl OpenedFiles {
    /// Adds a file.
    pub fn add(&self, path: &Path) {
        self.list().insert(path.to_path_buf());
    }

    /// All of them, by name.
    #[must_use]
    pub fn paths(&self) -> Vec<PathBuf> {
        self.list().iter().cloned().collect()
    }

    fn list(&self) -> MutexGuard<'_, BTreeSet<PathBuf>> {
        // A set is whole whatever thread has panicked.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
