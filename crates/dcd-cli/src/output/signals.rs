//! Removes temporary files when a signal ends the run.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, Once};
use tempfile::NamedTempFile;

/// The temporary files that there are. Held while one is made or renamed, so that a signal finds each
/// either here or done.
static TEMPORARY: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn temporary() -> MutexGuard<'static, Vec<PathBuf>> {
    // Paths alone: nothing that a panic could leave half done.
    TEMPORARY.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
}

/// Makes a temporary file that a signal removes.
pub(super) fn made(make: impl FnOnce() -> io::Result<NamedTempFile>) -> io::Result<NamedTempFile> {
    static WATCHED: Once = Once::new();
    WATCHED.call_once(watch);
    let mut temporary = temporary();
    let file = make()?;
    temporary.push(file.path().to_path_buf());
    Ok(file)
}

/// Renames a temporary file; none of that name is left.
pub(super) fn renamed<T>(path: &Path, rename: impl FnOnce() -> io::Result<T>) -> io::Result<T> {
    let path = path.to_path_buf();
    let mut temporary = temporary();
    let done = rename()?;
    temporary.retain(|other| *other != path);
    Ok(done)
}

/// Waits for what ends a run, beside the work; then the signal does what it does.
#[cfg(unix)]
fn watch() {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
    use signal_hook::iterator::Signals;
    use signal_hook::low_level::emulate_default_handler;
    use std::sync::Arc;
    use std::sync::atomic::AtomicBool;
    // A file that grows past the user's limit is an error of writing, as a full disk is.
    let _ = signal_hook::flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false)));
    let Ok(mut signals) = Signals::new([SIGINT, SIGTERM, SIGHUP]) else { return };
    std::thread::spawn(move || {
        if let Some(signal) = signals.forever().next() {
            let temporary = temporary();
            temporary.iter().for_each(|path| drop(std::fs::remove_file(path)));
            let _ = emulate_default_handler(signal);
        }
    });
}

#[cfg(not(unix))]
fn watch() {}
