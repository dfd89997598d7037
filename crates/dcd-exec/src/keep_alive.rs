//! Threads that stay awake from section to section.
//!
//! An idle thread of the pool sleeps after some ten microseconds, and waking it takes longer than
//! many a section of a step. So whoever has worked in a section waits for the next one awake, until
//! the step is over. It waits in a job of its own, below which nothing of ours waits, and meanwhile
//! does whatever other work the pool has: so nobody waits for a thread that waits.

use std::cell::Cell;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// How often a thread looks for work in vain before it is left to sleep all the same: about a
/// millisecond. Longer: what is serial in between costs the other threads' time.
const PATIENCE: u32 = 2048;

thread_local! {
    /// Whether this thread is in a section kept awake or a job of one, or waits for the next.
    static ENGAGED: Cell<bool> = const { Cell::new(false) };
}

/// Signals to waiting threads that the step is over, when this is dropped.
#[derive(Debug, Default)]
pub(crate) struct KeepAlive {
    over: Arc<AtomicBool>,
}

impl Drop for KeepAlive {
    fn drop(&mut self) {
        self.over.store(true, Ordering::Relaxed);
    }
}

impl KeepAlive {
    /// Runs a job that another thread may have come by. That thread stays awake afterwards.
    pub(crate) fn engage<T>(&self, job: impl FnOnce() -> T) -> T {
        let Some(engaged) = Engaged::begin() else { return job() };
        let result = job();
        drop(engaged);
        let over = Arc::clone(&self.over);
        rayon::spawn(move || wait(&over));
        result
    }
}

/// The time for which a thread is [`ENGAGED`]; ends with a panic too.
pub(crate) struct Engaged;

impl Engaged {
    /// `None` if it is already.
    pub(crate) fn begin() -> Option<Self> {
        (!ENGAGED.replace(true)).then(|| Self)
    }
}

impl Drop for Engaged {
    fn drop(&mut self) {
        ENGAGED.set(false);
    }
}

/// Works until the step is over, unless this thread is needed elsewhere: a job that waits for others
/// may come by this one, and must go on as soon as they are done.
fn wait(over: &AtomicBool) {
    let Some(_engaged) = Engaged::begin() else { return };
    let mut in_vain = 0;
    while in_vain < PATIENCE && !over.load(Ordering::Relaxed) {
        if rayon::yield_now() == Some(rayon::Yield::Executed) {
            in_vain = 0;
        } else {
            in_vain += 1;
            std::thread::yield_now();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Exec, Par, with_threads};
    use std::panic::{AssertUnwindSafe, catch_unwind};
    use std::sync::atomic::AtomicUsize;

    #[test]
    fn a_thread_is_engaged_once_and_until_the_first_is_dropped() {
        let first = Engaged::begin();
        assert!(first.is_some() && Engaged::begin().is_none() && Engaged::begin().is_none());
        drop(first);
        assert!(Engaged::begin().is_some());
    }

    #[test]
    fn wholes_within_tasks_of_others_end_with_every_task_run_once() {
        let runs = AtomicUsize::new(0);
        let whole = |exec: Exec| {
            for _ in 0..20 {
                exec.tasks(7, |_| {
                    runs.fetch_add(1, Ordering::Relaxed);
                });
            }
        };
        for threads in 1..5 {
            runs.store(0, Ordering::Relaxed);
            let done = with_threads(threads, || {
                Exec::from(Par::WarmPool).tasks(9, |_| {
                    Exec::from(Par::WarmPool).within_pool(|exec| {
                        exec.tasks(3, |_| Exec::from(Par::WarmPool).within_pool(whole));
                        whole(exec);
                    });
                });
            });
            assert!(done.is_ok());
            assert_eq!(runs.load(Ordering::Relaxed), 9 * 4 * 20 * 7);
        }
    }

    #[test]
    fn from_outside_the_work_moves_into_the_pool() {
        assert_eq!(rayon::current_thread_index(), None);
        let inside =
            Exec::from(Par::WarmPool).within_pool(|_| rayon::current_thread_index().is_some());
        assert!(inside || crate::threads() == 1);
        assert_eq!(Exec::from(Par::Serial).within_pool(|_| rayon::current_thread_index()), None);
    }

    #[test]
    fn a_panic_passes_through_and_leaves_its_thread_free() {
        let free = with_threads(2, || {
            let within_pool = || {
                Exec::from(Par::WarmPool)
                    .within_pool(|exec| exec.tasks(8, |k| assert_ne!(k, 5, "five")));
            };
            let panicked = catch_unwind(AssertUnwindSafe(within_pool)).is_err();
            panicked && Engaged::begin().is_some()
        });
        assert!(matches!(free, Ok(true)));
    }
}
