//! Values reused by the tasks of a thread.

use std::cell::RefCell;
use thread_local::ThreadLocal;

/// Values that tasks borrow, one for each thread that works at once: scratch memory and buffers.
///
/// A task that borrows while another on the same thread has not given back (it called rayon,
/// which stole) gets a value of its own: nothing is ever shared or refused.
#[derive(Debug)]
pub struct PerThread<T: Send> {
    /// In boxes, so that lending a large value moves a pointer.
    free: ThreadLocal<RefCell<Vec<Box<T>>>>,
}

impl<T: Send> Default for PerThread<T> {
    fn default() -> Self {
        Self { free: ThreadLocal::new() }
    }
}

impl<T: Send + Default> PerThread<T> {
    /// Lends a value to `task`.
    pub fn with<R>(&self, task: impl FnOnce(&mut T) -> R) -> R {
        let (free, mut value) = self.lend();
        let result = task(&mut value);
        free.borrow_mut().push(value);
        result
    }

    /// A value, and where it is to be given back.
    fn lend(&self) -> (&RefCell<Vec<Box<T>>>, Box<T>) {
        let free = self.free.get_or_default();
        let value = free.borrow_mut().pop().unwrap_or_default();
        (free, value)
    }
}

impl<T: Send> PerThread<T> {
    /// Every value there is, in no particular order.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut T> {
        self.free.iter_mut().flat_map(|free| free.get_mut().iter_mut().map(Box::as_mut))
    }

    /// Moves every value to `values`, in no particular order.
    pub(crate) fn take_all(&mut self, values: &mut Vec<Box<T>>) {
        self.free.iter_mut().for_each(|free| values.append(free.get_mut()));
    }

    /// Hands the values back to the threads that have worked before; if there is none, they stay.
    pub(crate) fn give_back(&mut self, values: &mut Vec<Box<T>>) {
        while !values.is_empty() {
            let mut threads = 0;
            for free in self.free.iter_mut() {
                threads += 1;
                free.get_mut().extend(values.pop());
            }
            if threads == 0 {
                return;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_stays_where_it_is_from_loan_to_loan() {
        let values = PerThread::<[u8; 32]>::default();
        let place = || values.with(|value| std::ptr::from_ref(value).addr());
        assert_eq!(place(), place());
    }

    #[test]
    fn a_borrow_inside_a_borrow_gets_a_value_of_its_own() {
        let mut values = PerThread::<Vec<u32>>::default();
        values.with(|outer| {
            outer.push(1);
            values.with(|inner| inner.push(2));
            assert_eq!(outer, &[1]);
        });
        let mut all: Vec<_> = values.iter_mut().map(|v| v.clone()).collect();
        all.sort();
        assert_eq!(all, [vec![1], vec![2]]);
    }
}
