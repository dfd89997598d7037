//! The shapes of a scene, made on all threads, with a bar where that takes long.

use crate::failure::Failure;
use crate::progress::Progress;
use dcd_exec::{Exec, Par, with_threads};
use dcd_scenes::Run;

/// Runs `make` on so many threads; on one, without a pool. The result is the same at any number.
pub(crate) fn on_threads<T: Send>(
    threads: usize,
    make: impl FnOnce(&Run<'_>) -> T + Send,
) -> Result<T, Failure> {
    if threads == 1 {
        return Ok(make(&|count, task| watched(Par::Serial, count, task)));
    }
    with_threads(threads, || make(&|count, task| watched(Par::Pool, count, task)))
        .map_err(|error| Failure::at(format_args!("{threads} threads"), error))
}

fn watched(par: Par, count: usize, task: &(dyn Fn(usize) + Sync)) {
    let progress = Progress::over(count as u64, "making shapes");
    Exec::from(par).tasks(count, |k| {
        task(k);
        progress.step();
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU64, Ordering};

    #[test]
    fn every_task_is_run_on_one_thread_and_on_several() {
        for threads in [1, 3] {
            let sum = AtomicU64::new(0);
            let add = |k: usize| {
                sum.fetch_add(k as u64, Ordering::Relaxed);
            };
            assert!(on_threads(threads, |run| run(1000, &add)).is_ok());
            assert_eq!(sum.into_inner(), 499_500);
        }
    }
}
