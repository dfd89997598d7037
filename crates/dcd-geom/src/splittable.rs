//! Buffers that can be split in two.

/// A sequence that can be cut in two disjoint parts, so that each is worked on alone.
///
/// # Contract
/// `split_at(k)` for k ≤ `len()` gives parts of k and `len() − k` elements, the first k and the
/// others, in order.
pub trait Splittable: Sized + Send {
    /// How many elements.
    fn len(&self) -> usize;
    /// Whether there is none.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }
    /// The first `middle` elements, and the others.
    fn split_at(self, middle: usize) -> (Self, Self);
}

impl<T: Send> Splittable for &mut [T] {
    fn len(&self) -> usize {
        (**self).len()
    }
    fn split_at(self, middle: usize) -> (Self, Self) {
        self.split_at_mut(middle)
    }
}

impl<T: Sync> Splittable for &[T] {
    fn len(&self) -> usize {
        (**self).len()
    }
    fn split_at(self, middle: usize) -> (Self, Self) {
        (*self).split_at(middle)
    }
}

/// Two sequences of one length, element by element.
impl<A: Splittable, B: Splittable> Splittable for (A, B) {
    fn len(&self) -> usize {
        self.0.len().min(self.1.len())
    }
    fn split_at(self, middle: usize) -> (Self, Self) {
        let (a, b) = (self.0.split_at(middle), self.1.split_at(middle));
        ((a.0, b.0), (a.1, b.1))
    }
}
