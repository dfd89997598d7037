//! The shapes of a scene, made on all threads, with a bar where that takes long.

use crate::failure::Failure;
use dcd_exec::{Exec, Par, with_threads};
use dcd_scenes::Run;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// What takes no longer shows no bar.
const LONG: Duration = Duration::from_secs(2);

/// What `make` makes on so many threads; on one, without a pool. The same at any number.
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
    let watch = Watch::new(count, LONG);
    Exec::from(par).tasks(count, |k| {
        task(k);
        watch.count();
    });
}

/// Counts what is done, and shows it once that has taken long.
struct Watch {
    tasks: u64,
    long: Duration,
    begun: Instant,
    done: AtomicU64,
    bar: OnceLock<ProgressBar>,
}

impl Watch {
    fn new(tasks: usize, long: Duration) -> Self {
        let (begun, done) = (Instant::now(), AtomicU64::new(0));
        Self { tasks: tasks as u64, long, begun, done, bar: OnceLock::new() }
    }

    fn count(&self) {
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        if self.begun.elapsed() >= self.long {
            self.bar.get_or_init(|| self.show()).set_position(done);
        }
    }

    /// On standard error, if that is a terminal.
    fn show(&self) -> ProgressBar {
        let style = ProgressStyle::with_template("making shapes [{wide_bar}] {pos}/{len} {eta}");
        let style = style.unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("=> ");
        let target = ProgressDrawTarget::stderr();
        ProgressBar::with_draw_target(Some(self.tasks), target).with_style(style)
    }
}

impl Drop for Watch {
    /// Nothing is left between a reader and the answer.
    fn drop(&mut self) {
        if let Some(bar) = self.bar.get() {
            bar.finish_and_clear();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bar_appears_once_the_work_takes_long_and_says_how_much_is_done() {
        let watch = Watch::new(3, Duration::MAX);
        watch.count();
        assert!(watch.bar.get().is_none());
        let watch = Watch::new(3, Duration::ZERO);
        watch.count();
        watch.count();
        let bar = watch.bar.get().map(|bar| (bar.position(), bar.length()));
        assert_eq!(bar, Some((2, Some(3))));
    }

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
