//! Whether intervals of t and ranges of pieces leave nothing out.

use std::ops::Range;

/// A part of what has to be proved of a pair: an interval of t, some pieces of the first body, some of the second.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Part {
    pub(super) t: [f64; 2],
    pub(super) pieces: [Range<usize>; 2],
}

impl Part {
    fn is_in(&self, other: &Self) -> bool {
        let inside = |k: usize| {
            other.pieces[k].start <= self.pieces[k].start
                && self.pieces[k].end <= other.pieces[k].end
        };
        other.t[0] <= self.t[0] && self.t[1] <= other.t[1] && inside(0) && inside(1)
    }

    fn meets(&self, other: &Self) -> bool {
        let across = |k: usize| {
            other.pieces[k].start < self.pieces[k].end && self.pieces[k].start < other.pieces[k].end
        };
        other.t[0] < self.t[1] && self.t[0] < other.t[1] && across(0) && across(1)
    }

    /// In two, at a border of one of the parts inside of it: the middle one of those of t, else of pieces.
    fn halves(&self, parts: &[&Self]) -> Option<[Self; 2]> {
        let borders = |of: &dyn Fn(&Self) -> [f64; 2]| {
            let [from, to] = of(self);
            let all = parts.iter().flat_map(|part| of(part));
            let mut inside: Vec<f64> = all.filter(|&x| from < x && x < to).collect();
            inside.sort_by(f64::total_cmp);
            inside.get(inside.len() / 2).copied()
        };
        if let Some(t) = borders(&|part| part.t) {
            let half = |t| Self { t, pieces: self.pieces.clone() };
            return Some([half([self.t[0], t]), half([t, self.t[1]])]);
        }
        for k in 0..2 {
            let ends = |part: &Self| [part.pieces[k].start as f64, part.pieces[k].end as f64];
            if let Some(border) = borders(&ends) {
                let border = border as usize;
                let mut halves = [self.clone(), self.clone()];
                halves[0].pieces[k].end = border;
                halves[1].pieces[k].start = border;
                return Some(halves);
            }
        }
        None
    }

    /// The first part of it that none of the parts holds, if there is one.
    pub(super) fn left_by(&self, parts: &[&Self]) -> Option<Self> {
        let parts: Vec<&Self> = parts.iter().copied().filter(|part| self.meets(part)).collect();
        if parts.iter().any(|part| self.is_in(part)) {
            return None;
        }
        match self.halves(&parts) {
            Some(halves) => halves.iter().find_map(|half| half.left_by(&parts)),
            // None lies across it, so that none holds any of it.
            None => Some(self.clone()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(t: [f64; 2], a: Range<usize>, b: Range<usize>) -> Part {
        Part { t, pieces: [a, b] }
    }

    fn left(whole: &Part, parts: &[Part]) -> Option<Part> {
        whole.left_by(&parts.iter().collect::<Vec<_>>())
    }

    #[test]
    fn what_is_cut_into_parts_is_covered_and_with_any_part_gone_it_is_not() {
        let whole = part([0.0, 1.0], 0..5, 0..7);
        let mut draw = 11u64;
        let mut next = |n: usize| {
            draw = draw
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (draw >> 33) as usize % n
        };
        for _ in 0..50 {
            let mut parts = vec![whole.clone()];
            for _ in 0..60 {
                let k = next(parts.len());
                let cut = parts.swap_remove(k);
                let mut halves = [cut.clone(), cut.clone()];
                let axis = next(3);
                if axis == 2 {
                    let t = 0.5 * (cut.t[0] + cut.t[1]);
                    (halves[0].t[1], halves[1].t[0]) = (t, t);
                } else if cut.pieces[axis].len() > 1 {
                    let at = cut.pieces[axis].start + 1 + next(cut.pieces[axis].len() - 1);
                    (halves[0].pieces[axis].end, halves[1].pieces[axis].start) = (at, at);
                } else {
                    parts.push(cut);
                    continue;
                }
                parts.extend(halves);
            }
            assert_eq!(left(&whole, &parts), None);
            let gone = parts.swap_remove(next(parts.len()));
            let missing = left(&whole, &parts).unwrap();
            assert!(missing.is_in(&gone), "{missing:?} {gone:?}");
        }
    }

    #[test]
    fn a_gap_of_a_single_number_of_f64_is_seen() {
        let whole = part([0.0, 1.0], 0..1, 0..1);
        let [first, last] = [0.5, 0.5f64.next_up()];
        let both = |first, last| [part([0.0, first], 0..1, 0..1), part([last, 1.0], 0..1, 0..1)];
        assert_eq!(left(&whole, &both(first, last)).unwrap().t, [first, last]);
        assert_eq!(left(&whole, &both(last, first)), None);
        assert_eq!(left(&whole, &[]), Some(whole.clone()));
    }
}
