//! The values along one axis: where they lie, which of them get a tick, how a tick reads.

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};

use super::Scale;
use crate::table::grouped;

/// The values that an axis spans, `low` < `high`; both positive if it is logarithmic.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Span {
    scale: Scale,
    low: f64,
    high: f64,
}

impl Span {
    /// The span of all values with a small margin: from zero, or between whole steps of 1, 2 and 5.
    pub(super) fn over(scale: Scale, values: impl Iterator<Item = f64> + Clone) -> Self {
        let low = values.clone().fold(f64::INFINITY, f64::min);
        let high = values.fold(f64::NEG_INFINITY, f64::max);
        if low > high {
            return Self { scale, low: 1.0, high: 10.0 };
        }
        let (low, high) = match scale {
            Scale::Linear => {
                let (low, high) = (low.min(0.0), high.max(0.0));
                let margin = 0.04 * (high - low);
                (if low < 0.0 { low - margin } else { low }, high + margin)
            }
            Scale::Logarithmic => (low / 1.25, high * 1.25),
        };
        Self { scale, low, high: if high > low { high } else { low + 1.0 } }
    }

    /// At most `most` round values within the span.
    fn ticks(&self, most: usize) -> Vec<f64> {
        match self.scale {
            Scale::Linear => self.linear_ticks(most.max(1)),
            Scale::Logarithmic => self.logarithmic_ticks(most.max(1)),
        }
    }

    fn linear_ticks(&self, most: usize) -> Vec<f64> {
        let span = self.high - self.low;
        let decade = (span / most as f64).log10().floor();
        let steps = [1.0, 2.0, 5.0, 10.0].map(|step| step * 10_f64.powf(decade));
        let fits = |step: &f64| (self.high / step).floor() - (self.low / step).ceil() < most as f64;
        let step = steps.into_iter().find(fits).unwrap_or(span);
        let (first, last) = ((self.low / step).ceil() as i64, (self.high / step).floor() as i64);
        (first..=last).map(|k| k as f64 * step).collect()
    }

    fn logarithmic_ticks(&self, most: usize) -> Vec<f64> {
        let (first, last) = (self.low.log10().floor() as i32, self.high.log10().ceil() as i32);
        let with = |digits: &[f64], stride: i32| -> Vec<f64> {
            let decades = (first.div_euclid(stride)..=last).map(|k| k * stride);
            let values = decades.flat_map(|k| digits.iter().map(move |d| d * 10_f64.powi(k)));
            values.filter(|value| (self.low..=self.high).contains(value)).collect()
        };
        let fine = [&[1.0, 2.0, 5.0][..], &[1.0, 3.0]].map(|digits| with(digits, 1));
        if fine[0].len() < 2 {
            return self.linear_ticks(most);
        }
        let coarse = (1..=last - first).map(|stride| with(&[1.0], stride));
        fine.into_iter().chain(coarse).find(|ticks| ticks.len() <= most).unwrap_or_default()
    }
}

impl Ranged for Span {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (from, to): (i32, i32)) -> i32 {
        let share = match self.scale {
            Scale::Linear => (value - self.low) / (self.high - self.low),
            Scale::Logarithmic => (value / self.low).ln() / (self.high / self.low).ln(),
        };
        from + (f64::from(to - from) * share).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        self.ticks(hint.max_num_points())
    }

    fn range(&self) -> std::ops::Range<f64> {
        self.low..self.high
    }
}

impl ValueFormatter<f64> for Span {
    fn format_ext(&self, value: &f64) -> String {
        let size = value.abs();
        if size != 0.0 && !(1e-3..1e7).contains(&size) {
            return format!("{value:e}");
        }
        // Ticks are few digits times a power of ten: what is left behind them is rounding.
        let text = format!("{value:.6}");
        grouped(text.trim_end_matches('0').trim_end_matches('.'))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn logarithmic(low: f64, high: f64) -> Span {
        Span { scale: Scale::Logarithmic, low, high }
    }

    #[test]
    fn ticks_are_round_within_the_span_and_few() {
        let linear = |low, high| Span { scale: Scale::Linear, low, high };
        assert_eq!(linear(0.0, 104.0).ticks(6), [0.0, 20.0, 40.0, 60.0, 80.0, 100.0]);
        assert_eq!(linear(0.0, 0.9).ticks(5), [0.0, 0.2, 0.4, 0.6000000000000001, 0.8]);
        assert_eq!(logarithmic(8.0, 12_500.0).ticks(5), [10.0, 100.0, 1000.0, 10_000.0]);
        assert_eq!(logarithmic(0.8, 12.5).ticks(5), [1.0, 2.0, 5.0, 10.0]);
        assert_eq!(logarithmic(3.1, 4.1).ticks(3), [3.5, 4.0]);
        assert_eq!(logarithmic(0.9, 1.1e9).ticks(5), [1.0, 100.0, 1e4, 1e6, 1e8]);
    }

    #[test]
    fn a_decade_takes_the_same_length_everywhere_on_a_logarithmic_axis() {
        let span = logarithmic(1.0, 1000.0);
        assert_eq!([1.0, 10.0, 100.0, 1000.0].map(|x| span.map(&x, (0, 300))), [0, 100, 200, 300]);
        assert_eq!(span.map(&10.0, (300, 0)), 200);
    }

    #[test]
    fn ticks_are_written_without_the_rounding_behind_them() {
        let span = logarithmic(1.0, 2.0);
        for (value, text) in
            [(0.6000000000000001, "0.6"), (10_000.0, "10,000"), (1e-6, "1e-6"), (0.0, "0")]
        {
            assert_eq!(span.format_ext(&value), text);
        }
    }
}
