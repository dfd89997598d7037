//! Counting what is wrong.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::measure::OfPrecision;
use crate::precision::{Precision, Said};
use crate::subject::{Known, Subject};

/// How far numbers are off. A size is the pair's m: no coordinate of A − B is larger.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct Errors {
    /// How many numbers there were.
    pub(crate) count: usize,
    /// In sizes of the pair.
    pub(crate) median: f64,
    pub(crate) percentile_99: f64,
    pub(crate) worst: f64,
    /// Relative to the truth, where that is above 1e-12 of the size.
    pub(crate) median_relative: f64,
    pub(crate) worst_relative: f64,
}

/// Pairs of one category or decade.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Group {
    pub(crate) kind: Kind,
    pub(crate) name: String,
    pub(crate) pairs: usize,
    pub(crate) wrong: usize,
    pub(crate) undecided: usize,
    /// The largest error of a number in sizes of the pair.
    pub(crate) worst: Option<f64>,
}

/// What a group has in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub(crate) enum Kind {
    Category,
    Decade,
}

/// The answers of one precision, booked one by one.
pub(crate) struct Tally<'s> {
    subject: &'s Subject,
    wrong_yes: usize,
    wrong_no: usize,
    undecided: usize,
    errors: Vec<f64>,
    relative: Vec<f64>,
    categories: BTreeMap<usize, Group>,
    decades: BTreeMap<i32, Group>,
}

/// What became of an answer.
enum Fate {
    Right,
    Wrong,
    Open,
    /// A number, off by so many sizes.
    Off(f64),
}

/// Below this share of the pair's size no relative error is computed.
const LEAST_SHARE: f64 = 1e-12;

impl<'s> Tally<'s> {
    pub(crate) fn new(subject: &'s Subject) -> Self {
        Self {
            subject,
            wrong_yes: 0,
            wrong_no: 0,
            undecided: 0,
            errors: Vec::new(),
            relative: Vec::new(),
            categories: BTreeMap::new(),
            decades: BTreeMap::new(),
        }
    }

    /// What a precision said of pair `k`, whose true depth or negative distance is `value` where a
    /// number is computed.
    pub(crate) fn book(&mut self, k: u32, said: Said, value: Option<f64>) {
        let touches = self.subject.touches(k);
        let fate = match said {
            Said::Open => {
                self.undecided += 1;
                Fate::Open
            }
            Said::Apart if touches => {
                self.wrong_no += 1;
                Fate::Wrong
            }
            Said::Touching if !touches => {
                self.wrong_yes += 1;
                Fate::Wrong
            }
            Said::Apart | Said::Touching => Fate::Right,
            Said::Measured(_) => self.measured(k, said, value.unwrap_or(f64::NAN)),
        };
        if let Known::Exactly(_, labels) = &self.subject.truth {
            let label = &labels[k as usize];
            let category = self.categories.entry(label.rank);
            category.or_insert_with(|| Group::new(Kind::Category, &label.category)).book(&fate);
            let decade = self.decades.entry(label.decade);
            let name = || Group::new(Kind::Decade, &format!("1e{}", label.decade));
            decade.or_insert_with(name).book(&fate);
        }
    }

    fn measured(&mut self, k: u32, said: Said, value: f64) -> Fate {
        let size = self.subject.size(k);
        let error = self.subject.error(k, said, value);
        // Where the truth is no f64, the error is unknown.
        let Some(error) = error.filter(|error| error.is_finite() && size.is_finite()) else {
            return Fate::Right;
        };
        // A point on a point has no size, and no error either.
        let off = if error == 0.0 { 0.0 } else { error / size };
        self.errors.push(off);
        if value.abs() > LEAST_SHARE * size {
            self.relative.push(error / value.abs());
        }
        Fate::Off(off)
    }

    pub(crate) fn into_precision(mut self, precision: Precision, ns: f64) -> OfPrecision {
        self.errors.sort_by(f64::total_cmp);
        self.relative.sort_by(f64::total_cmp);
        let at = |sorted: &[f64], share: f64| {
            let last = sorted.len().saturating_sub(1);
            sorted.get((last as f64 * share).round() as usize).copied().unwrap_or(0.0)
        };
        let errors = (!self.errors.is_empty()).then(|| Errors {
            count: self.errors.len(),
            median: at(&self.errors, 0.5),
            percentile_99: at(&self.errors, 0.99),
            worst: at(&self.errors, 1.0),
            median_relative: at(&self.relative, 0.5),
            worst_relative: at(&self.relative, 1.0),
        });
        OfPrecision {
            precision,
            ns,
            wrong_yes: self.wrong_yes,
            wrong_no: self.wrong_no,
            undecided: self.undecided,
            errors,
            groups: self.categories.into_values().chain(self.decades.into_values()).collect(),
        }
    }
}

impl Group {
    fn new(kind: Kind, name: &str) -> Self {
        Self { kind, name: name.to_owned(), pairs: 0, wrong: 0, undecided: 0, worst: None }
    }

    fn book(&mut self, fate: &Fate) {
        self.pairs += 1;
        match fate {
            Fate::Right => {}
            Fate::Wrong => self.wrong += 1,
            Fate::Open => self.undecided += 1,
            Fate::Off(error) => self.worst = Some(self.worst.unwrap_or(0.0).max(*error)),
        }
    }
}
