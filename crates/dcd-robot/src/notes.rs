//! What a file has that is known here and makes no difference to what touches.

use std::collections::BTreeMap;
use std::fmt::Write;

/// Elements and fields that were passed over: how many of each kind, and the first one's line.
#[derive(Default)]
pub(super) struct Unused(BTreeMap<String, (usize, usize)>);

impl Unused {
    /// Counts one on this line.
    pub(super) fn add(&mut self, kind: impl Into<String>, line: usize) {
        let (count, first) = self.0.entry(kind.into()).or_insert((0, line));
        *count += 1;
        *first = line.min(*first);
    }

    /// All of them in one sentence; none where nothing was passed over.
    pub(super) fn note(&self) -> Option<String> {
        let mut text = String::new();
        for (kind, (count, line)) in &self.0 {
            text.push_str(if text.is_empty() { "not used: " } else { ", " });
            // Writing to a string cannot fail.
            let _ = match count {
                1 => write!(text, "{kind} (line {line})"),
                _ => write!(text, "{count} {kind} (first on line {line})"),
            };
        }
        (!text.is_empty()).then_some(text)
    }

    /// The kinds alone, alike for all files that have the same ones.
    pub(super) fn kinds(&self) -> Option<String> {
        let kinds: Vec<&str> = self.0.keys().map(String::as_str).collect();
        (!kinds.is_empty()).then(|| format!("not used: {}", kinds.join(", ")))
    }
}
