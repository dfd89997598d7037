//! Names that one thing has alone.

use super::RobotError;
use std::collections::HashMap;

/// Names of one kind of thing, and the indices of those that have them.
pub(super) struct Names<'a> {
    what: &'static str,
    indices: HashMap<&'a str, usize>,
}

impl<'a> Names<'a> {
    /// Refuses a name that two have, on the line of the second.
    pub(super) fn of(
        what: &'static str,
        all: impl Iterator<Item = (&'a str, usize)>,
    ) -> Result<Self, RobotError> {
        let mut indices = HashMap::new();
        for (index, (name, line)) in all.enumerate() {
            if indices.insert(name, index).is_some() {
                return Err(RobotError::Twice { what, name: name.to_owned() }.at_line(line));
            }
        }
        Ok(Self { what, indices })
    }

    pub(super) fn find(&self, name: &str) -> Option<usize> {
        self.indices.get(name).copied()
    }

    /// The index of a name that `user` says.
    pub(super) fn index(&self, name: &str, user: &str) -> Result<usize, RobotError> {
        self.find(name).ok_or_else(|| RobotError::Unknown {
            what: self.what,
            name: name.to_owned(),
            user: user.to_owned(),
        })
    }
}
