//! Work that is cut into tasks, for who has threads: here are none.

use std::sync::{Mutex, OnceLock, PoisonError};

/// Runs task 0, 1, … count − 1, each once, in any order and on any threads, and comes back when all
/// are done. What is made does not depend on the order.
pub type Run<'a> = dyn Fn(usize, &(dyn Fn(usize) + Sync)) + 'a;

/// One task after the other, on the calling thread.
pub fn in_order(count: usize, task: &(dyn Fn(usize) + Sync)) {
    (0..count).for_each(task);
}

/// What `make` makes of each item, in their order; each item is gone when it is used.
pub fn map<T: Send, U: Send + Sync>(
    run: &Run<'_>,
    items: impl IntoIterator<Item = T>,
    make: impl Fn(usize, T) -> U + Sync,
) -> Vec<U> {
    let slot = |item| (Mutex::new(Some(item)), OnceLock::new());
    let slots: Vec<(Mutex<Option<T>>, OnceLock<U>)> = items.into_iter().map(slot).collect();
    let work = |k: usize| {
        let Some((item, made)) = slots.get(k) else { return };
        let item = item.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some(item) = item {
            let _ = made.set(make(k, item));
        }
    };
    run(slots.len(), &work);
    // For a run that leaves some out.
    in_order(slots.len(), &work);
    slots.into_iter().filter_map(|(_, made)| made.into_inner()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_made_stands_in_the_order_of_the_items_whatever_the_order_of_the_work() {
        let backwards = |count: usize, task: &(dyn Fn(usize) + Sync)| {
            (0..count).rev().for_each(task);
        };
        let forgetful = |count: usize, task: &(dyn Fn(usize) + Sync)| {
            (0..count).step_by(2).for_each(|k| {
                task(k);
                task(k);
                task(k + count);
            });
        };
        let runs: [&Run<'_>; 3] = [&in_order, &backwards, &forgetful];
        for run in runs {
            let made = map(run, 10..15, |k, item| (k, item));
            assert_eq!(made, [(0, 10), (1, 11), (2, 12), (3, 13), (4, 14)]);
        }
    }
}
