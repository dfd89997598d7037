//! What the reader of YAML refuses, said to who wrote the file and not to who set the reader's options.

use serde_saphyr::budget::BudgetBreach;
use serde_saphyr::{DefaultMessageFormatter, Error, MessageFormatter};
use std::borrow::Cow;

/// The words for it.
pub(super) struct Words;

impl MessageFormatter for Words {
    fn format_message<'a>(&self, error: &'a Error) -> Cow<'a, str> {
        match error {
            Error::DuplicateMappingKey { key: Some(key), .. } => {
                format!("key {key:?} stands twice").into()
            }
            Error::DuplicateMappingKey { key: None, .. } => "a key stands twice".into(),
            Error::Budget { breach, .. } => match breach {
                BudgetBreach::Documents { .. } => "it holds more than one document".into(),
                BudgetBreach::Depth { .. } => "it is nested too deep".into(),
                BudgetBreach::Nodes { .. } | BudgetBreach::Events { .. } => {
                    "it has too many values".into()
                }
                BudgetBreach::Aliases { .. } | BudgetBreach::Anchors { .. } => {
                    "it has too many aliases".into()
                }
                _ => DefaultMessageFormatter.format_message(error),
            },
            _ => DefaultMessageFormatter.format_message(error),
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::{Limits, read_request};

    #[test]
    fn a_refusal_speaks_of_the_file_and_not_of_the_readers_options() {
        let limits = Limits { nesting: 8, nodes: 100, aliases: 10 };
        let long = format!("goal_constraints: [{}]", "{}, ".repeat(200));
        for (text, why) in [
            ("start_state: {}\nstart_state: {}\n", "key \"start_state\" stands twice"),
            ("start_state: {}\n---\nstart_state: {}\n", "more than one document"),
            (&long, "too many values"),
        ] {
            let refused = read_request(text, limits).unwrap_err();
            assert!(refused.contains(why), "{why:?} is not in {refused:?}");
        }
    }
}
