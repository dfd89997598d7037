//! Lists that are filled, emptied and filled again.

/// A list that items are appended to: a `Vec`, or one that keeps its items in another form.
pub trait List: Default + Send {
    /// How many items.
    fn len(&self) -> usize;
    /// Whether there is none.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }
    /// Empties it and keeps its memory.
    fn clear(&mut self);
}

impl<T: Send> List for Vec<T> {
    #[inline]
    fn len(&self) -> usize {
        self.len()
    }
    #[inline]
    fn clear(&mut self) {
        self.clear();
    }
}
