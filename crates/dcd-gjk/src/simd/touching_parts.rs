//! Which parts of meshes and polytopes touch, where a measure of them follows.

use crate::{Method, PosedShape, Verdict, mesh};

/// Which parts of the touching meshes and polytopes of a slice touch: found once, for yes or no and for the measure.
#[derive(Clone, Debug, Default)]
pub(super) struct TouchingParts {
    pub(super) is_wanted: bool,
    /// For each pair its number in the slice, and where its list ends.
    ends: Vec<(u32, usize)>,
    parts: Vec<[u32; 2]>,
}

impl TouchingParts {
    /// Forgets the last slice.
    pub(super) fn begin(&mut self, is_wanted: bool) {
        self.is_wanted = is_wanted;
        self.ends.clear();
        self.parts.clear();
    }

    /// Looks for all of a pair.
    pub(super) fn search(
        &mut self,
        number: u32,
        [a, b]: [PosedShape<'_>; 2],
        scratch: &mut mesh::Scratch,
    ) -> (Verdict<()>, Method) {
        let first = self.parts.len();
        let found = mesh::touching(a, b, scratch, &mut self.parts);
        if found.0 == Verdict::Touching(()) {
            self.ends.push((number, self.parts.len()));
        } else {
            self.parts.truncate(first);
        }
        found
    }

    /// Whether there is a list.
    pub(super) fn has_any(&self) -> bool {
        !self.ends.is_empty()
    }

    /// The lists of the touching pairs, each with its number in the slice, in rising order.
    pub(super) fn lists(&self) -> impl Iterator<Item = (u32, &[[u32; 2]])> {
        let mut first = 0;
        self.ends.iter().map(move |&(number, end)| {
            let begin = std::mem::replace(&mut first, end);
            (number, &self.parts[begin..end])
        })
    }
}
