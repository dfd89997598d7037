//! Output in task order, written by many threads without a lock.

use crate::{Exec, List, PerThread, Splittable};
use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering};

/// How many items a task changes: some microseconds of work.
const CHANGED_AT_ONCE: usize = 16 * 1024;

/// A list written in pieces: task k writes segment k to the end of its thread's buffer, and the
/// segments are read in the order of the tasks. The buffers are kept from one use to the next.
pub type Segments<T> = Segmented<Vec<T>>;

/// [`Segments`] whose buffers are lists of any kind.
#[derive(Debug)]
pub struct Segmented<L: List> {
    lent: PerThread<Buffer<L>>,
    /// As they are lent: out of its box and into another, a buffer would allocate.
    #[allow(clippy::vec_box)]
    buffers: Vec<Box<Buffer<L>>>,
    spans: Vec<Span>,
}

/// A thread's buffer, known by a number while it is lent.
#[derive(Debug)]
struct Buffer<L> {
    number: Option<u32>,
    items: L,
}

/// Where a segment is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Span {
    buffer: u32,
    start: usize,
    len: usize,
}

impl Span {
    /// Both as one span, where `next` begins in the same buffer at this one's end. Whether it does
    /// depends on the schedule; what they hold, one after the other, does not.
    pub fn followed_by(self, next: Self) -> Option<Self> {
        let adjoins = self.buffer == next.buffer && self.start + self.len == next.start;
        adjoins.then(|| Self { len: self.len + next.len, ..self })
    }
}

/// Part of a segment: see [`Segments::cut`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cut(Span);

/// Hands out the calling thread's buffer, for recursions that make their own tasks.
#[derive(Debug)]
pub struct Filler<'a, L: List> {
    lent: &'a PerThread<Buffer<L>>,
    next: AtomicU32,
}

impl<L: List> Default for Buffer<L> {
    fn default() -> Self {
        Self { number: None, items: L::default() }
    }
}

impl<L: List> Default for Segmented<L> {
    fn default() -> Self {
        Self { lent: PerThread::default(), buffers: Vec::new(), spans: Vec::new() }
    }
}

impl<L: List> Filler<'_, L> {
    /// Runs `write`, which appends to the buffer that it is given and leaves what is there alone,
    /// and says where it wrote.
    pub fn segment(&self, write: impl FnOnce(&mut L)) -> Span {
        self.lent.with(|buffer| {
            let new = || self.next.fetch_add(1, Ordering::Relaxed);
            let number = *buffer.number.get_or_insert_with(new);
            let start = buffer.items.len();
            write(&mut buffer.items);
            Span { buffer: number, start, len: buffer.items.len().saturating_sub(start) }
        })
    }
}

impl<L: List> Segmented<L> {
    /// Replaces the contents: `task(k, buffer)` appends segment k to the buffer.
    pub fn fill(&mut self, exec: Exec, tasks: usize, task: impl Fn(usize, &mut L) + Sync) {
        self.fill_by(exec, tasks, &task);
    }

    fn fill_by(&mut self, exec: Exec, tasks: usize, task: &(dyn Fn(usize, &mut L) + Sync)) {
        if exec.is_plain(tasks) {
            return self.fill_here(exec, tasks, task);
        }
        let mut spans = std::mem::take(&mut self.spans);
        spans.clear();
        spans.resize(tasks, Span::default());
        self.clear();
        let filler = Filler { lent: &self.lent, next: AtomicU32::new(0) };
        exec.each(&mut spans, |k, span| *span = filler.segment(|buffer| task(k, buffer)));
        self.adopt(spans);
    }

    /// The same on the calling thread: one buffer, lent to nobody. What lending costs would show in
    /// a small scene.
    fn fill_here(&mut self, exec: Exec, tasks: usize, task: &dyn Fn(usize, &mut L)) {
        if self.buffers.is_empty() {
            self.lent.take_all(&mut self.buffers);
        }
        for buffer in &mut self.buffers {
            buffer.items.clear();
            buffer.number = None;
        }
        if self.buffers.is_empty() {
            self.buffers.push(Box::default());
        }
        let Self { buffers, spans, .. } = self;
        spans.clear();
        let Some(Buffer { number, items }) = buffers.first_mut().map(Box::as_mut) else { return };
        *number = Some(0);
        exec.in_order(tasks, &mut |k| {
            let start = items.len();
            task(k, items);
            spans.push(Span { buffer: 0, start, len: items.len().saturating_sub(start) });
        });
    }

    /// Replaces the contents by the segments that `work` makes and returns in their final order.
    pub fn gather(&mut self, work: impl FnOnce(&Filler<L>) -> Vec<Span>) {
        self.clear();
        let filler = Filler { lent: &self.lent, next: AtomicU32::new(0) };
        let spans = work(&filler);
        self.adopt(spans);
    }

    /// Empties the list and keeps its memory.
    pub fn clear(&mut self) {
        self.spans.clear();
        // Those too that a fill left there whose task panicked, still with their numbers.
        self.lent.take_all(&mut self.buffers);
        for buffer in &mut self.buffers {
            buffer.items.clear();
            buffer.number = None;
        }
        self.lent.give_back(&mut self.buffers);
    }

    fn adopt(&mut self, spans: Vec<Span>) {
        self.lent.take_all(&mut self.buffers);
        self.buffers.sort_unstable_by_key(|buffer| buffer.number.unwrap_or(u32::MAX));
        self.spans = spans;
    }

    /// How many items there are in all.
    pub fn len(&self) -> usize {
        self.spans.iter().map(|span| span.len).sum()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Where the segments are, in order: a buffer's list, and which of its items.
    pub fn spans(&self) -> impl Iterator<Item = (&L, Range<usize>)> {
        let place = |span: &Span| {
            let buffer = self.buffers.get(span.buffer as usize)?;
            Some((&buffer.items, span.start..span.start + span.len))
        };
        self.spans.iter().filter_map(place)
    }
}

impl<T: Send> Segments<T> {
    /// The segments in order.
    pub fn iter(&self) -> impl Iterator<Item = &[T]> {
        self.spans.iter().map(|&span| self.slice(Cut(span)))
    }

    /// Cuts every segment into as few pieces of at most `size` items as there may be, all as long as
    /// each other but for one item, and lists the pieces in order. They depend on the segments alone.
    pub fn cut(&self, size: usize, pieces: &mut Vec<Cut>) {
        pieces.clear();
        for &span in &self.spans {
            let count = span.len.div_ceil(size.max(1));
            for k in 0..count {
                let [begin, end] = [k, k + 1].map(|k| k * span.len / count);
                pieces.push(Cut(Span { start: span.start + begin, len: end - begin, ..span }));
            }
        }
    }

    /// The items of a piece that [`Segments::cut`] made of these contents; empty for any other.
    pub fn slice(&self, Cut(span): Cut) -> &[T] {
        let buffer = self.buffers.get(span.buffer as usize);
        buffer.and_then(|b| b.items.get(span.start..span.start + span.len)).unwrap_or_default()
    }

    /// Changes every item, in any order, in pieces that depend on the schedule.
    pub fn change_each(&mut self, exec: Exec, change: impl Fn(&mut T) + Sync) {
        for buffer in &mut self.buffers {
            exec.divide(&mut buffer.items[..], CHANGED_AT_ONCE, |_, items| {
                items.iter_mut().for_each(&change);
            });
        }
    }
}

impl<T: Send + Sync + Copy + Default> Segments<T> {
    /// All items in order, in one piece; copied in parallel.
    pub fn join_into(&self, exec: Exec, out: &mut Vec<T>) {
        out.clear();
        out.resize(self.len(), T::default());
        let copies = Copies { spans: &self.spans, out: &mut out[..] };
        exec.divide(copies, 1, |_, part| {
            let mut rest = part.out;
            for &span in part.spans {
                let (head, tail) = rest.split_at_mut(span.len);
                head.copy_from_slice(self.slice(Cut(span)));
                rest = tail;
            }
        });
    }
}

/// Segments and the memory they are copied to.
struct Copies<'a, T> {
    spans: &'a [Span],
    out: &'a mut [T],
}

impl<T: Send> Splittable for Copies<'_, T> {
    fn len(&self) -> usize {
        self.spans.len()
    }
    fn split_at(self, middle: usize) -> (Self, Self) {
        let (left, right) = self.spans.split_at(middle);
        let (slots, rest) = self.out.split_at_mut(left.iter().map(|span| span.len).sum());
        (Self { spans: left, out: slots }, Self { spans: right, out: rest })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Par, with_threads};

    fn filled(par: Par, tasks: usize) -> Vec<usize> {
        let mut segments = Segments::default();
        let mut joined = Vec::new();
        for round in 0..3 {
            segments.fill(par.into(), tasks, |k, out| {
                out.extend((0..k % 7).map(|x| 100 * k + x + round))
            });
            segments.join_into(par.into(), &mut joined);
            let spans = segments.spans().flat_map(|(list, items)| &list[items]);
            assert!(spans.eq(&joined));
            assert_eq!(joined, segments.iter().flatten().copied().collect::<Vec<_>>());
            assert_eq!(joined.len(), segments.len());
        }
        joined
    }

    #[test]
    fn the_order_is_that_of_the_tasks_at_any_thread_count() {
        let serial = filled(Par::Serial, 200);
        let expected: Vec<usize> =
            (0..200).flat_map(|k| (0..k % 7).map(move |x| 100 * k + x + 2)).collect();
        assert_eq!(serial, expected);
        for threads in [1, 2, 3, 7] {
            assert_eq!(with_threads(threads, || filled(Par::Pool, 200)).unwrap(), serial);
        }
    }

    #[test]
    fn every_item_is_changed_once() {
        for par in [Par::Serial, Par::Pool] {
            let mut segments = Segments::default();
            segments.fill(par.into(), 300, |k, out| out.extend(500 * k..500 * k + k));
            let before: Vec<_> = segments.iter().flatten().copied().collect();
            segments.change_each(par.into(), |item| *item += 7);
            assert!(segments.iter().flatten().copied().eq(before.iter().map(|item| item + 7)));
        }
    }

    #[test]
    fn serial_and_pooled_contents_take_each_others_place() {
        let mut segments = Segments::default();
        for (round, par) in [Par::Serial, Par::Pool, Par::Serial, Par::Pool].into_iter().enumerate()
        {
            for tasks in [0, 1, 2, 40] {
                segments.fill(par.into(), tasks, |k, out| out.extend([k, k + round]));
                let expected = (0..tasks).flat_map(|k| [k, k + round]);
                assert!(segments.iter().flatten().copied().eq(expected), "{par:?}, {tasks}");
                assert_eq!(segments.iter().count(), tasks);
            }
            segments.clear();
            assert!(segments.is_empty());
        }
    }

    #[test]
    fn cuts_cover_every_item_once_and_in_order() {
        let mut segments = Segments::default();
        segments.fill(Par::Serial.into(), 20, |k, out| out.extend(std::iter::repeat_n(k, k)));
        let mut pieces = Vec::new();
        segments.cut(4, &mut pieces);
        assert!(pieces.iter().all(|&p| (1..=4).contains(&segments.slice(p).len())));
        let again: Vec<_> = pieces.iter().flat_map(|&p| segments.slice(p)).collect();
        assert_eq!(again, segments.iter().flatten().collect::<Vec<_>>());
    }

    #[test]
    fn a_recursion_orders_its_own_segments() {
        fn halves(exec: Exec, range: std::ops::Range<u32>, filler: &Filler<Vec<u32>>) -> Vec<Span> {
            if range.len() <= 3 {
                return vec![filler.segment(|out| out.extend(range))];
            }
            let middle = range.start + range.len() as u32 / 2;
            let (mut left, right) = exec.join(
                || halves(exec, range.start..middle, filler),
                || halves(exec, middle..range.end, filler),
            );
            left.extend(right);
            left
        }
        for par in [Par::Serial, Par::Pool] {
            let mut segments = Segments::default();
            segments.gather(|filler| halves(par.into(), 0..100, filler));
            assert!(segments.iter().flatten().copied().eq(0..100));
        }
    }

    #[test]
    fn a_fill_after_one_that_panicked_has_all_that_its_tasks_write() {
        const TASKS: usize = 64;
        let write = |k: usize, out: &mut Vec<usize>| {
            // Long enough for every thread to take some.
            std::hint::black_box((0..2000_usize).fold(k, |x, y| x ^ y.wrapping_mul(7)));
            out.push(k);
        };
        for threads in [1, 2, 4, 7] {
            let refill = || {
                let mut segments = Segments::default();
                for round in 0..40 {
                    let broken = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
                        segments.fill(Par::Pool.into(), TASKS, |k, out| {
                            write(k, out);
                            assert!(k != 20 && k != 40, "on purpose");
                        });
                    }));
                    assert!(broken.is_err() && segments.is_empty());
                    if round % 2 == 0 {
                        segments.fill(Par::Pool.into(), TASKS, write);
                    } else {
                        segments.gather(|filler| {
                            (0..TASKS).map(|k| filler.segment(|out| write(k, out))).collect()
                        });
                    }
                    assert!(segments.iter().flatten().copied().eq(0..TASKS), "{threads}, {round}");
                }
            };
            with_threads(threads, refill).unwrap();
        }
    }

    #[test]
    fn a_task_that_calls_rayon_does_no_harm() {
        let mut segments = Segments::default();
        segments.fill(Par::Pool.into(), 64, |k, out| {
            rayon::join(|| std::hint::black_box(k), || std::hint::black_box(k + 1));
            out.push(k);
        });
        assert!(segments.iter().flatten().copied().eq(0..64));
    }
}
