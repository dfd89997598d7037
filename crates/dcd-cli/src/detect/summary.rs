//! The summary of a run, as text and as JSON.

use super::contacts::digest;
use super::question::Question;
use super::steps::{Found, Plan};
use crate::precision::{Accuracy, Precision, in_words};
use dcd_io::CloudCensus;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::time::Duration;

/// What is reported.
pub(super) struct Summary<'a> {
    pub(super) objects: usize,
    pub(super) clouds: Option<CloudCensus>,
    pub(super) plan: Plan,
    pub(super) found: &'a Found,
    /// `None` where the system does not report it.
    pub(super) peak_bytes: Option<u64>,
}

#[derive(Serialize)]
struct Json {
    objects: usize,
    pairs: usize,
    contacts: usize,
    undecided: usize,
    threads: usize,
    precision: Precision,
    #[serde(skip_serializing_if = "Option::is_none")]
    query: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    margin: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    accuracy: Option<Accuracy>,
    #[serde(skip_serializing_if = "Option::is_none")]
    error_bound: Option<ErrorBound>,
    ms: Stages,
    /// null where the system does not report it.
    peak_rss_bytes: Option<u64>,
    digest: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    refused_shapes: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    clouds: Option<Clouds>,
}

#[derive(Serialize)]
struct Stages {
    aabbs: Spread,
    build: Spread,
    pairs: Spread,
    narrow: Spread,
    total: Spread,
}

/// Of the repeats, milliseconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
struct Spread {
    min: f64,
    median: f64,
}

/// Over all measures, metres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
struct ErrorBound {
    median: f64,
    p99: f64,
    worst: f64,
}

impl ErrorBound {
    /// `None` where nothing was measured.
    fn of(mut bounds: Vec<f64>) -> Option<Self> {
        bounds.sort_unstable_by(f64::total_cmp);
        let worst = *bounds.last()?;
        // The least that so many are not above.
        let at = |part: f64| bounds[((part * bounds.len() as f64).ceil() as usize).max(1) - 1];
        Some(Self { median: at(0.5), p99: at(0.99), worst })
    }
}

#[derive(Serialize)]
struct Clouds {
    solid: usize,
    flat: usize,
    needles: usize,
    points: usize,
    /// Of the solid ones, those that the hull library refused: they stay point sets.
    kept_as_point_sets: usize,
}

impl Summary<'_> {
    pub(super) fn json(&self) -> String {
        let Found { pairs, contacts, undecided, refused, .. } = self.found;
        let [aabbs, build, stage_pairs, narrow, total] = self.spreads();
        let query = self.plan.query;
        let json = Json {
            objects: self.objects,
            pairs: *pairs,
            contacts: contacts.len(),
            undecided: undecided.len(),
            threads: self.plan.threads,
            precision: self.plan.precision,
            query: Some(query.name()).filter(|_| !query.is_plain()),
            margin: Some(query.margin).filter(|_| !query.is_plain()),
            accuracy: Some(query.accuracy).filter(|_| query.question != Question::Overlap),
            error_bound: ErrorBound::of(self.found.error_bounds.clone()),
            ms: Stages { aabbs, build, pairs: stage_pairs, narrow, total },
            peak_rss_bytes: self.peak_bytes,
            digest: self.digest(),
            refused_shapes: *refused,
            clouds: self.clouds.map(|census| Clouds {
                solid: census.solid,
                flat: census.flat,
                needles: census.needles,
                points: census.points,
                kept_as_point_sets: census.refused,
            }),
        };
        // Strings and numbers alone: nothing in it can fail.
        serde_json::to_string(&json).unwrap_or_default() + "\n"
    }

    pub(super) fn text(&self) -> String {
        let mut text = String::new();
        let mut line = |what: &str, value: &dyn std::fmt::Display| {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{what:<16} {value}");
        };
        if let Some(census) = &self.clouds {
            line("clouds", census);
        }
        if let Some(refused) = self.found.refused {
            line("refused shapes", &format_args!("{refused} (Parry's; their pairs are undecided)"));
        }
        line("objects", &self.objects);
        line("candidate pairs", &self.found.pairs);
        line("contacts", &self.found.contacts.len());
        line("undecided", &format_args!("{}{}", self.found.undecided.len(), self.reasons()));
        let Plan { precision, threads, repeats, query } = self.plan;
        if !query.is_plain() {
            line("query", &format_args!("{}, within {} m", query.name(), query.margin));
        }
        if let Some(ErrorBound { median, p99, worst }) =
            ErrorBound::of(self.found.error_bounds.clone())
        {
            let bounds = format_args!("{median:.1e} median, {p99:.1e} 99 %, {worst:.1e} worst (m)");
            line("error bound", &bounds);
        }
        line("precision", &precision.name());
        line("threads", &threads);
        line("milliseconds", &format_args!("{:>11} {:>11}   of {repeats}", "min", "median"));
        let names = ["  AABBs", "  build", "  pairs", "  narrow", "  total"];
        for (name, Spread { min, median }) in names.into_iter().zip(self.spreads()) {
            line(name, &format_args!("{min:>11.3} {median:>11.3}"));
        }
        match self.peak_bytes {
            Some(bytes) => line("peak memory", &format_args!("{:.1} MB", bytes as f64 / 1e6)),
            None => line("peak memory", &"not reported by this system"),
        }
        line("digest", &self.digest());
        text
    }

    fn digest(&self) -> String {
        format!("{:016x}", digest(&self.found.contacts))
    }

    /// How many pairs are undecided for which reason.
    fn reasons(&self) -> String {
        let mut counts = BTreeMap::new();
        for undecided in &self.found.undecided {
            *counts.entry(in_words(undecided.reason)).or_insert(0usize) += 1;
        }
        let counts: Vec<_> = counts.iter().map(|(why, count)| format!("{count} {why}")).collect();
        if counts.is_empty() { String::new() } else { format!(" ({})", counts.join(", ")) }
    }

    fn spreads(&self) -> [Spread; 5] {
        [0, 1, 2, 3, 4].map(|stage| {
            let times = self.found.times.iter().map(|step| step[stage]);
            Spread::of(times.collect())
        })
    }
}

impl Spread {
    fn of(mut times: Vec<Duration>) -> Self {
        times.sort_unstable();
        let runs = times.len();
        let nth = |k: usize| times.get(k).map_or(0.0, |time| time.as_secs_f64() * 1e3);
        // Between the middle two if their number is even.
        let median = (nth(runs.saturating_sub(1) / 2) + nth(runs / 2)) / 2.0;
        Self { min: nth(0), median }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_of_bounds_are_bounds_that_occur() {
        let of = |bounds: &[f64]| ErrorBound::of(bounds.to_vec());
        assert_eq!(of(&[]), None);
        assert_eq!(of(&[3.0]), Some(ErrorBound { median: 3.0, p99: 3.0, worst: 3.0 }));
        let hundred: Vec<f64> = (1..=200).rev().map(f64::from).collect();
        assert_eq!(of(&hundred), Some(ErrorBound { median: 100.0, p99: 198.0, worst: 200.0 }));
    }

    #[test]
    fn the_median_is_the_middle_or_between_the_middle_two() {
        let of = |ms: &[u64]| Spread::of(ms.iter().map(|&ms| Duration::from_millis(ms)).collect());
        assert_eq!(of(&[5, 1, 9]), Spread { min: 1.0, median: 5.0 });
        assert_eq!(of(&[8, 2, 4, 10]), Spread { min: 2.0, median: 6.0 });
        assert_eq!(of(&[3]), Spread { min: 3.0, median: 3.0 });
    }
}
