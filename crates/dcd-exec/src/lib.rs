//! Parallel execution with a fixed order of results. The only crate with threads.
//!
//! Work is cut into tasks whose number depends on the work alone, and task k writes segment k
//! ([`Segments`]). So the result is the same at any number of threads, and [`Par::Serial`] runs the same
//! code on one. A closure given to [`Exec`] must not depend on the order or the thread in which it runs.
//! It is called through a pointer, once a task, so that the code that runs it is compiled once.
//!
//! Deliberately absent: a clock (an optional [`Observer`] sees tasks begin and end, and may measure), a
//! thread pool ([`Par::Pool`] is rayon's current one), locks.
#![forbid(unsafe_code)]

mod keep_alive;
mod observe;
mod per_thread;
mod segments;

pub use dcd_geom::{List, Splittable};
pub use observe::{Observer, Stage};
pub use per_thread::PerThread;
pub use segments::{Cut, Filler, Segmented, Segments, Span};

use keep_alive::{Engaged, KeepAlive};
use rayon::slice::ParallelSliceMut;

/// Where tasks run.
///
/// ```
/// use dcd_exec::{Exec, Par, Segments};
/// // Task k writes list k; the lists are read in the order of the tasks, whoever ran them.
/// let squares = |par: Par| {
///     let mut lists = Segments::default();
///     lists.fill(Exec::from(par), 100, |k, list| list.push(k * k));
///     lists.iter().flatten().copied().collect::<Vec<_>>()
/// };
/// assert_eq!(squares(Par::Serial), squares(Par::Pool));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Par {
    /// On the calling thread, in order; rayon is never touched.
    Serial,
    /// On rayon's current pool: the global one, or that of `ThreadPool::install`.
    #[default]
    Pool,
    /// The same pool, whose threads stay awake from section to section of a step. A sleeping thread
    /// takes some ten microseconds to wake, longer than many a section, so a step of a millisecond
    /// gains; but between sections each thread of the pool spins, up to a millisecond in vain, on
    /// a core that the host might have used. `docs/performance.md` has what it gains.
    WarmPool,
}

/// Where tasks run, and their observer. Cheap to copy; made from a [`Par`].
#[derive(Clone, Copy, Default)]
pub struct Exec<'a> {
    /// `Serial` or `Pool`.
    par: Par,
    /// Whether threads of the pool are to stay awake in [`Self::within_pool`].
    warm: bool,
    observer: Option<&'a dyn Observer>,
    keep_alive: Option<&'a KeepAlive>,
}

impl From<Par> for Exec<'_> {
    fn from(par: Par) -> Self {
        let (par, warm) = match par {
            Par::WarmPool => (Par::Pool, true),
            par => (par, false),
        };
        Self { par, warm, ..Self::default() }
    }
}

impl<'a> Exec<'a> {
    /// How many items are sorted without touching the pool: some tens of microseconds of work.
    pub const SORTED_AT_ONCE: usize = 4096;

    /// Notifies `observer` when stages and tasks begin and end.
    pub fn observed(par: Par, observer: &'a dyn Observer) -> Self {
        Self { observer: Some(observer), ..Self::from(par) }
    }

    /// Whether tasks run on the pool, for foreign code that has a parallel version of its own.
    pub fn is_pooled(self) -> bool {
        self.par == Par::Pool
    }

    /// The same, but serial below `few` items, where the pool would cost more than it
    /// saves. The tasks, and what comes of them, are the same.
    pub fn serial_below(self, items: usize, few: usize) -> Self {
        if items <= few { Self { par: Par::Serial, ..self } } else { self }
    }

    /// Runs `work`, which is of many sections, inside the pool, so that it is entered once. On the calling
    /// thread if that is where tasks run.
    ///
    /// With [`Par::WarmPool`], threads that have taken part stay awake until it ends: those that find
    /// nothing to do yield to whatever else the machine or the pool has to do, and sleep after a
    /// millisecond in vain.
    pub fn within_pool<T: Send>(self, work: impl FnOnce(Exec<'_>) -> T + Send) -> T {
        if self.par == Par::Serial || threads() == 1 {
            return work(self);
        }
        rayon::scope(|_| {
            if !self.warm {
                return work(self);
            }
            let keep_alive = KeepAlive::default();
            let _engaged = Engaged::begin();
            work(Exec { keep_alive: Some(&keep_alive), ..self })
        })
    }

    /// Runs `work` as a stage by that name, for the observer.
    pub fn stage<T>(self, stage: Stage, work: impl FnOnce() -> T) -> T {
        let Some(observer) = self.observer else { return work() };
        observer.stage_begins(stage);
        let result = work();
        observer.stage_ends(stage);
        result
    }

    /// Runs `task(0)`, `task(1)`, … `task(count − 1)`, in any order.
    pub fn tasks(self, count: usize, task: impl Fn(usize) + Sync) {
        self.tasks_by(count, &task);
    }

    fn tasks_by(self, count: usize, task: &(dyn Fn(usize) + Sync)) {
        if self.is_plain(count) {
            return self.in_order(count, &mut |k| task(k));
        }
        self.section(count, || self.divide_from(0, Count(count), 1, &|k, _| task(k)));
    }

    /// Whether so many tasks run on the calling thread, without the pool.
    pub(crate) fn is_plain(self, tasks: usize) -> bool {
        self.par == Par::Serial || tasks <= 1
    }

    /// Runs `task(0)`, `task(1)`, … on the calling thread, in order.
    pub(crate) fn in_order(self, count: usize, task: &mut dyn FnMut(usize)) {
        self.section(count, || (0..count).for_each(|k| self.watched(k, || task(k))));
    }

    /// Runs `task(k, item k)` for each item, in any order.
    pub fn each<T: Send>(self, items: &mut [T], task: impl Fn(usize, &mut T) + Sync) {
        self.divide(items, 1, |first, items| {
            items.iter_mut().enumerate().for_each(|(k, item)| task(first + k, item));
        });
    }

    /// Sorts. Unstable, so that the result is determined only if no two are equal.
    pub fn sort<T: Ord + Send>(self, items: &mut [T]) {
        let count = items.len();
        let mut sort = || match self.serial_below(count, Self::SORTED_AT_ONCE).par {
            Par::Serial => items.sort_unstable(),
            Par::Pool | Par::WarmPool => items.par_sort_unstable(),
        };
        let Some(observer) = self.observer else { return sort() };
        observer.sort_begins(count);
        sort();
        observer.sort_ends();
    }

    /// Runs both, perhaps at once. For recursions; neither is a task to the observer.
    pub fn join<A: Send, B: Send>(
        self,
        a: impl FnOnce() -> A + Send,
        b: impl FnOnce() -> B + Send,
    ) -> (A, B) {
        match self.par {
            Par::Serial => (a(), b()),
            Par::Pool | Par::WarmPool => match self.keep_alive {
                None => rayon::join(a, b),
                Some(keep_alive) => rayon::join(a, || keep_alive.engage(b)),
            },
        }
    }

    /// Cuts `whole` into parts of `grain` elements (the last may be shorter) and runs
    /// `task(first element, part)` on each. `grain` must not be 0, and is taken as 1 if it is.
    pub fn divide<P: Splittable>(self, whole: P, grain: usize, task: impl Fn(usize, P) + Sync) {
        self.divide_by(whole, grain.max(1), &task);
    }

    fn divide_by<P: Splittable>(self, whole: P, grain: usize, task: &(dyn Fn(usize, P) + Sync)) {
        let tasks = whole.len().div_ceil(grain);
        self.section(tasks, || self.divide_from(0, whole, grain, task));
    }

    fn divide_from<P: Splittable>(
        self,
        first: usize,
        part: P,
        grain: usize,
        task: &(dyn Fn(usize, P) + Sync),
    ) {
        let tasks = part.len().div_ceil(grain);
        if tasks <= 1 {
            if tasks == 1 {
                self.watched(first / grain, || task(first, part));
            }
            return;
        }
        let middle = tasks / 2 * grain;
        let (left, right) = part.split_at(middle);
        self.join(
            || self.divide_from(first, left, grain, task),
            || self.divide_from(first + middle, right, grain, task),
        );
    }

    /// Runs `work` as a section of so many tasks, for the observer.
    fn section(self, tasks: usize, work: impl FnOnce()) {
        let Some(observer) = self.observer else { return work() };
        observer.section_begins(tasks);
        work();
        observer.section_ends();
    }

    /// Runs `work` as task `k`, for the observer.
    pub(crate) fn watched<T>(self, k: usize, work: impl FnOnce() -> T) -> T {
        let Some(observer) = self.observer else { return work() };
        observer.task_begins(k);
        let result = work();
        observer.task_ends(k);
        result
    }
}

/// So many tasks that work on nothing of their own.
struct Count(usize);

impl Splittable for Count {
    fn len(&self) -> usize {
        self.0
    }
    fn split_at(self, middle: usize) -> (Self, Self) {
        (Self(middle), Self(self.0 - middle))
    }
}

/// Runs `work` inside a pool of that many threads, which is made for it.
///
/// # Errors
/// The pool could not be made; rayon's reason.
pub fn with_threads<T: Send>(
    threads: usize,
    work: impl FnOnce() -> T + Send,
) -> Result<T, Box<dyn std::error::Error + Send + Sync>> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    Ok(pool.install(work))
}

/// How many threads [`Par::Pool`] has here.
pub fn threads() -> usize {
    rayon::current_num_threads()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    #[test]
    fn every_task_runs_once_serial_or_pooled() {
        for par in [Par::Serial, Par::Pool, Par::WarmPool] {
            let counts: Vec<AtomicUsize> = (0..100).map(|_| AtomicUsize::new(0)).collect();
            Exec::from(par).tasks(100, |k| {
                counts[k].fetch_add(1, Ordering::Relaxed);
            });
            assert!(counts.iter().all(|c| c.load(Ordering::Relaxed) == 1));
        }
    }

    #[test]
    fn division_gives_the_same_parts_at_any_thread_count() {
        for par in [Par::Serial, Par::Pool, Par::WarmPool] {
            for len in [0, 1, 7, 8, 9, 100] {
                let mut cells = vec![(0, 0); len];
                Exec::from(par).divide(&mut cells[..], 8, |first, part| {
                    let size = part.len();
                    part.iter_mut().for_each(|cell| *cell = (first, size));
                });
                for (k, cell) in cells.iter().enumerate() {
                    assert_eq!(*cell, (k / 8 * 8, 8.min(len - k / 8 * 8)));
                }
            }
        }
    }

    /// Counts its notifications.
    #[derive(Default)]
    struct Counts([AtomicUsize; 8]);

    impl Counts {
        fn add(&self, place: usize, by: usize) {
            self.0[place].fetch_add(by, Ordering::Relaxed);
        }
    }

    impl Observer for Counts {
        fn stage_begins(&self, _: Stage) {
            self.add(0, 1);
        }
        fn stage_ends(&self, _: Stage) {
            self.add(1, 1);
        }
        fn section_begins(&self, tasks: usize) {
            self.add(2, tasks);
        }
        fn section_ends(&self) {
            self.add(3, 1);
        }
        fn sort_begins(&self, items: usize) {
            self.add(4, items);
        }
        fn sort_ends(&self) {
            self.add(5, 1);
        }
        fn task_begins(&self, _: usize) {
            self.add(6, 1);
        }
        fn task_ends(&self, _: usize) {
            self.add(7, 1);
        }
    }

    #[test]
    fn an_observer_sees_every_section_and_task_begin_and_end() {
        for par in [Par::Serial, Par::Pool, Par::WarmPool] {
            let counts = Counts::default();
            let exec = Exec::observed(par, &counts);
            exec.stage(Stage::Pairs, || exec.tasks(10, |_| ()));
            exec.each(&mut [0; 5], |_, _| ());
            exec.divide(&mut [0; 20][..], 8, |_, _| ());
            exec.sort(&mut [3, 1, 2]);
            let tasks = 10 + 5 + 3;
            let seen = counts.0.map(AtomicUsize::into_inner);
            assert_eq!(seen, [1, 1, tasks, 3, 3, 1, tasks, tasks]);
        }
    }
}
