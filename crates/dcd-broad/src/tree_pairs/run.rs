//! Segments in their order.

use dcd_exec::Span;

/// Segments one after the other; those that also lie so in memory are one. On one thread a run is
/// a single span, and joining two runs allocates only where a thread has stolen a task.
#[derive(Debug, Default)]
pub(super) struct Run {
    before: Vec<Span>,
    last: Option<Span>,
}

impl Run {
    pub(super) fn push(&mut self, next: Span) {
        let Some(last) = self.last else {
            self.last = Some(next);
            return;
        };
        self.last = last.followed_by(next).or_else(|| {
            self.before.push(last);
            Some(next)
        });
    }

    pub(super) fn append(&mut self, next: Self) {
        next.into_spans().for_each(|span| self.push(span));
    }

    pub(super) fn into_spans(self) -> impl Iterator<Item = Span> {
        self.before.into_iter().chain(self.last)
    }
}
