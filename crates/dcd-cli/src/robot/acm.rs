//! The pairs of links that need no check, as an SRDF.

use super::refused;
use crate::failure::{Failure, print_message};
use crate::output::{Output, check_distinct};
use crate::progress::Progress;
use dcd_robot::{LinkPair, PairReason, PairSearch, Robot, write_srdf};
use serde::Serialize;
use std::path::Path;

/// What is written, and from what.
pub(super) struct Acm<'a> {
    pub(super) search: PairSearch,
    /// Whether pairs that touch at rest are written too.
    pub(super) allow_default: bool,
    pub(super) out: &'a Path,
    /// The robot's file and those that it names.
    pub(super) read: &'a [&'a Path],
}

/// How many pairs there are for each reason.
#[derive(Debug, Default, Serialize)]
pub(super) struct Counted {
    links: usize,
    samples: usize,
    adjacent: usize,
    always: usize,
    /// Of links that touch at rest, but not always.
    at_rest: usize,
    never_proved: usize,
    never_sampled: usize,
}

impl Acm<'_> {
    /// Searches the pairs and writes them.
    pub(super) fn write(&self, robot: &Robot) -> Result<Counted, Failure> {
        check_distinct(self.read, &[self.out])?;
        let mut output = Output::create(self.out)?;
        let progress = Progress::over(1, "looking for pairs that need no check");
        let mut pairs = self.search.run(robot).map_err(refused)?;
        drop(progress);
        let mut counted = Counted::of(&pairs);
        counted.links = super::links_with_shapes(robot);
        counted.samples = self.search.samples;
        for LinkPair { links: [a, b], .. } in
            pairs.iter().filter(|pair| pair.reason == PairReason::Default)
        {
            let then = if self.allow_default { "allowed" } else { "left to be checked" };
            print_message(format_args!(
                "{a:?} and {b:?} touch at rest but not always, a fault of the model: {then}"
            ));
        }
        pairs.retain(|pair| self.allow_default || pair.reason != PairReason::Default);
        let text = write_srdf(&robot.name, &pairs);
        output.write(|to| to.write_all(text.as_bytes()))?;
        output.commit()?;
        Ok(counted)
    }
}

impl Counted {
    fn of(pairs: &[LinkPair]) -> Self {
        let mut counted = Self::default();
        for pair in pairs {
            *match pair.reason {
                PairReason::Adjacent => &mut counted.adjacent,
                PairReason::Always => &mut counted.always,
                PairReason::Default => &mut counted.at_rest,
                PairReason::Never { proved: true } => &mut counted.never_proved,
                PairReason::Never { proved: false } => &mut counted.never_sampled,
            } += 1;
        }
        counted
    }

    pub(super) fn json(&self) -> String {
        // Numbers alone: nothing in it can fail.
        serde_json::to_string(self).unwrap_or_default() + "\n"
    }

    pub(super) fn text(&self) -> String {
        let Self { links, samples, adjacent, always, at_rest, never_proved, never_sampled } = self;
        format!(
            "of {links} links with shapes, by {samples} samples: {adjacent} pairs adjacent, {always} touch \
             always, {at_rest} at rest but not always, {never_proved} never (proved), {never_sampled} never \
             (samples alone)\n"
        )
    }
}
