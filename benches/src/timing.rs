//! How a time is taken: warm-up, number of runs, median and minimum, and interleaved rivals.
//!
//! The closures give their own times, so the policy itself reads no clock and can be tested.

use std::hint::black_box;
use std::time::{Duration, Instant};

use serde::{Deserialize, Deserializer, Serialize};

/// A run shorter than this is repeated within the run and its time divided.
/// Long against the clock's steps (tens of nanoseconds) and the cost of reading it, short enough
/// that ten of them go unnoticed.
const SHORTEST_RUN: Duration = Duration::from_millis(1);

/// Runs go untimed until they add up to this, so that caches, branch predictors and the processor's
/// frequency are steady.
const WARM_UP: Duration = Duration::from_millis(10);

/// Bounds the untimed runs, and the repeats within one run, of what takes no measurable time.
const MAX_REPEATS: u32 = 1000;

/// How often a run is repeated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effort {
    /// Ten runs where one is under a second, three where under ten seconds, else one.
    Full,
    /// Three runs where one is under a second, else one.
    Quick,
}

impl Effort {
    /// The number of timed runs of something that takes `one`.
    #[must_use]
    pub fn runs(self, one: Duration) -> u32 {
        let seconds = one.as_secs_f64();
        match self {
            Self::Full if seconds < 1.0 => 10,
            Self::Full if seconds < 10.0 => 3,
            Self::Quick if seconds < 1.0 => 3,
            Self::Full | Self::Quick => 1,
        }
    }
}

/// What was seen of one quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Sample {
    /// Number of timed runs.
    pub runs: u32,
    /// How often the work was repeated within each run; the times below are per repeat.
    pub repeats: u32,
    /// The shortest of the runs. Written as milliseconds.
    #[serde(with = "milliseconds")]
    pub min: Duration,
    /// The median of the runs. Written as milliseconds.
    #[serde(with = "milliseconds")]
    pub median: Duration,
}

/// Two rivals that took turns.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pair {
    /// The times of the first.
    pub a: Sample,
    /// The times of the second.
    pub b: Sample,
    /// Median over the rounds of b's time by a's: how many times as fast a is.
    /// NaN, as the two below, where one of them takes no time; written as null.
    #[serde(deserialize_with = "number_or_null")]
    pub ratio: f64,
    /// The smallest of these ratios.
    #[serde(deserialize_with = "number_or_null")]
    pub least: f64,
    /// The largest of these ratios.
    #[serde(deserialize_with = "number_or_null")]
    pub most: f64,
}

/// The time of one call, and what it returned.
pub fn time<T>(work: impl FnOnce() -> T) -> (Duration, T) {
    let start = Instant::now();
    let result = black_box(work());
    (start.elapsed(), result)
}

/// Samples the time of `work`; what it returns is dropped outside the timer.
pub fn measure<T>(effort: Effort, mut work: impl FnMut() -> T) -> Sample {
    let [sample] = measure_stages(effort, || [time(&mut work).0]);
    sample
}

/// Samples the `K` times that one run of `work` returns (say, its stages and the whole).
///
/// The longest of them decides how often it is run. What is to run only once, because it is long,
/// runs without warm-up: a cold start is lost in it.
pub fn measure_stages<const K: usize>(
    effort: Effort,
    mut work: impl FnMut() -> [Duration; K],
) -> [Sample; K] {
    let first = work();
    let runs = effort.runs(longest(&first));
    if runs == 1 {
        return samples(&[first], 1);
    }
    let repeats = warm_up(first, &mut work);
    let times: Vec<_> = (0..runs).map(|_| run(repeats, &mut work)).collect();
    samples(&times, repeats)
}

/// Runs `a` and `b` in alternation, at least one round, and gives for each of the `K` times that
/// both return the median of the rounds' ratios.
///
/// Who goes first alternates too, so that a drift of the machine favours neither.
pub fn pairs_of<const K: usize>(
    rounds: u32,
    mut a: impl FnMut() -> [Duration; K],
    mut b: impl FnMut() -> [Duration; K],
) -> [Pair; K] {
    let first = a();
    let repeats_a = warm_up(first, &mut a);
    let first = b();
    let repeats_b = warm_up(first, &mut b);

    let (mut times_a, mut times_b) = (Vec::new(), Vec::new());
    for round in 0..rounds.max(1) {
        if round % 2 == 0 {
            times_a.push(run(repeats_a, &mut a));
            times_b.push(run(repeats_b, &mut b));
        } else {
            times_b.push(run(repeats_b, &mut b));
            times_a.push(run(repeats_a, &mut a));
        }
    }
    let (samples_a, samples_b) = (samples(&times_a, repeats_a), samples(&times_b, repeats_b));
    std::array::from_fn(|k| {
        let mut ratios: Vec<f64> =
            times_a.iter().zip(&times_b).map(|(a, b)| ratio(b[k], a[k])).collect();
        ratios.sort_by(f64::total_cmp);
        let (least, most) = (ratios[0], ratios[ratios.len() - 1]);
        let ratio = f64::midpoint(ratios[(ratios.len() - 1) / 2], ratios[ratios.len() / 2]);
        Pair { a: samples_a[k], b: samples_b[k], ratio, least, most }
    })
}

/// Runs `work` until it is warm and gives the number of repeats that make a run long enough.
fn warm_up<const K: usize>(first: [Duration; K], work: &mut impl FnMut() -> [Duration; K]) -> u32 {
    let mut last = longest(&first);
    let mut spent = last;
    for _ in 1..MAX_REPEATS {
        if spent >= WARM_UP {
            break;
        }
        last = longest(&work());
        spent += last;
    }
    let repeats = SHORTEST_RUN.as_nanos().div_ceil(last.as_nanos().max(1));
    u32::try_from(repeats).unwrap_or(MAX_REPEATS).min(MAX_REPEATS)
}

/// One run: the mean times of `repeats` calls.
fn run<const K: usize>(repeats: u32, work: &mut impl FnMut() -> [Duration; K]) -> [Duration; K] {
    let mut sums = [Duration::ZERO; K];
    for _ in 0..repeats {
        let times = work();
        for (sum, time) in sums.iter_mut().zip(times) {
            *sum += time;
        }
    }
    sums.map(|sum| sum / repeats)
}

/// The samples of at least one run.
fn samples<const K: usize>(times: &[[Duration; K]], repeats: u32) -> [Sample; K] {
    std::array::from_fn(|k| {
        let mut sorted: Vec<Duration> = times.iter().map(|stages| stages[k]).collect();
        sorted.sort();
        let runs = sorted.len();
        let median = (sorted[(runs - 1) / 2] + sorted[runs / 2]) / 2;
        Sample { runs: u32::try_from(runs).unwrap_or(u32::MAX), repeats, min: sorted[0], median }
    })
}

fn ratio(upper: Duration, lower: Duration) -> f64 {
    if upper.is_zero() || lower.is_zero() {
        return f64::NAN;
    }
    upper.as_secs_f64() / lower.as_secs_f64()
}

fn longest(times: &[Duration]) -> Duration {
    times.iter().copied().max().unwrap_or_default()
}

fn number_or_null<'a, D: Deserializer<'a>>(from: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(from)?.unwrap_or(f64::NAN))
}

/// A duration as a number of milliseconds.
mod milliseconds {
    use std::time::Duration;

    use serde::{Deserialize, Deserializer, Serializer, de::Error};

    pub(super) fn serialize<S: Serializer>(time: &Duration, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_f64(time.as_secs_f64() * 1e3)
    }

    pub(super) fn deserialize<'a, D: Deserializer<'a>>(from: D) -> Result<Duration, D::Error> {
        let milliseconds = f64::deserialize(from)?;
        Duration::try_from_secs_f64(milliseconds / 1e3).map_err(Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: Duration = Duration::from_millis(1);

    /// Work whose calls take the listed milliseconds, the last one for ever; counts its calls.
    fn scripted<'a>(times: &'a [u32], calls: &'a mut usize) -> impl FnMut() -> [Duration; 1] + 'a {
        move || {
            let time = times[(*calls).min(times.len() - 1)];
            *calls += 1;
            [MS * time]
        }
    }

    #[test]
    fn the_shorter_a_run_the_more_runs() {
        for (millis, full, quick) in
            [(0, 10, 3), (999, 10, 3), (1000, 3, 1), (9999, 3, 1), (10_000, 1, 1)]
        {
            assert_eq!(Effort::Full.runs(MS * millis), full, "{millis} ms");
            assert_eq!(Effort::Quick.runs(MS * millis), quick, "{millis} ms");
        }
    }

    #[test]
    fn the_cold_first_run_does_not_count() {
        let mut calls = 0;
        let [sample] = measure_stages(Effort::Full, scripted(&[900, 20], &mut calls));
        assert_eq!(sample, Sample { runs: 10, repeats: 1, min: MS * 20, median: MS * 20 });
        assert_eq!(calls, 11);
    }

    #[test]
    fn what_takes_ten_seconds_runs_once() {
        let mut calls = 0;
        let [sample] = measure_stages(Effort::Full, scripted(&[12_000], &mut calls));
        assert_eq!((sample.runs, sample.median, calls), (1, MS * 12_000, 1));
    }

    #[test]
    fn an_even_number_of_runs_has_its_median_between_the_middle_two() {
        let times = [10, 9, 1, 8, 2, 7, 3, 6, 4, 5, 10];
        let mut calls = 0;
        let [sample] = measure_stages(Effort::Full, scripted(&times, &mut calls));
        assert_eq!(sample.min, MS);
        assert_eq!(sample.median, Duration::from_micros(5500));
    }

    #[test]
    fn a_short_run_is_repeated_until_it_is_long_enough() {
        let mut calls = 0_u32;
        let [sample, part] = measure_stages(Effort::Full, || {
            calls += 1;
            [MS / 10, MS / 40]
        });
        assert_eq!((sample.runs, sample.repeats), (10, 10));
        assert_eq!((sample.median, part.median), (MS / 10, MS / 40));
        assert_eq!(calls, 100 + 10 * 10, "a warm-up of ten milliseconds, then the runs");
    }

    #[test]
    fn work_without_a_measurable_time_ends() {
        let [sample] = measure_stages(Effort::Quick, || [Duration::ZERO]);
        assert_eq!((sample.runs, sample.repeats), (3, MAX_REPEATS));
    }

    #[test]
    fn the_ratio_of_a_pair_is_the_median_of_the_rounds() {
        let (mut calls_a, mut calls_b) = (0, 0);
        let a = scripted(&[10], &mut calls_a);
        let b = scripted(&[10, 20, 90, 40], &mut calls_b);
        let [pair] = pairs_of(3, a, b);
        assert_eq!((pair.ratio, pair.least, pair.most), (4.0, 2.0, 9.0));
        assert_eq!((pair.a.median, pair.b.median, pair.b.runs), (MS * 10, MS * 40, 3));
        assert_eq!((calls_a, calls_b), (4, 4));
    }

    #[test]
    fn rivals_take_turns_at_going_first() {
        let order = std::cell::RefCell::new(String::new());
        let turn = |name: char| {
            order.borrow_mut().push(name);
            [MS * 10]
        };
        pairs_of(3, || turn('a'), || turn('b'));
        assert_eq!(*order.borrow(), "ab".to_owned() + "ab" + "ba" + "ab");
    }

    #[test]
    fn a_stage_that_takes_no_time_has_no_ratio() -> Result<(), serde_json::Error> {
        let [pair] = pairs_of(2, || [MS * 10], || [Duration::ZERO]);
        assert!(pair.ratio.is_nan());
        let back: Pair = serde_json::from_str(&serde_json::to_string(&pair)?)?;
        assert!(back.ratio.is_nan() && back.a == pair.a);
        Ok(())
    }

    #[test]
    fn a_sample_reads_back_as_it_was_written() -> Result<(), serde_json::Error> {
        let nanos = Duration::from_nanos;
        let sample = Sample { runs: 3, repeats: 1, min: nanos(123), median: nanos(6_127_000_001) };
        let text = serde_json::to_string(&sample)?;
        assert!(text.contains(r#""median":6127.0"#), "{text}");
        assert_eq!(serde_json::from_str::<Sample>(&text)?, sample);
        assert!(serde_json::from_str::<Sample>(&text.replace("6127", "-6127")).is_err());
        Ok(())
    }
}
