//! Which parts of meshes and polytopes touch, where a measure of them follows.

use crate::mesh::{self, KnownParts, TriangleDepths};
use crate::{Method, PosedShape, Verdict};

/// Which parts of the touching meshes and polytopes of a slice touch: found once, for yes or no and for the measure.
#[derive(Clone, Debug, Default)]
pub(super) struct TouchingParts {
    pub(super) is_wanted: bool,
    /// For each pair its number in the slice, and where its lists end.
    ends: Vec<(u32, Lengths)>,
    parts: Vec<[u32; 2]>,
    /// Of some of these.
    depths: TriangleDepths,
}

/// How long the lists are: of parts, of depths, and of what bounds depths.
type Lengths = [usize; 3];

impl TouchingParts {
    /// Forgets the last slice.
    pub(super) fn begin(&mut self, is_wanted: bool) {
        self.is_wanted = is_wanted;
        self.ends.clear();
        self.parts.clear();
        self.depths.known.clear();
        self.depths.at_most.clear();
    }

    /// Looks for all of a pair.
    pub(super) fn search(
        &mut self,
        number: u32,
        [a, b]: [PosedShape<'_>; 2],
        scratch: &mut mesh::Scratch,
    ) -> (Verdict<()>, Method) {
        let first = self.lengths();
        let Self { parts, depths, .. } = self;
        let found = mesh::touching_with_depths(a, b, scratch, (&mut *parts, &mut *depths));
        if found.0 == Verdict::Touching(()) {
            self.ends.push((number, self.lengths()));
        } else {
            parts.truncate(first[0]);
            depths.known.truncate(first[1]);
            depths.at_most.truncate(first[2]);
        }
        found
    }

    fn lengths(&self) -> Lengths {
        [self.parts.len(), self.depths.known.len(), self.depths.at_most.len()]
    }

    /// Whether there is a list.
    pub(super) fn has_any(&self) -> bool {
        !self.ends.is_empty()
    }

    /// The lists of the touching pairs, each with its number in the slice, in rising order.
    pub(super) fn lists(&self) -> impl Iterator<Item = (u32, KnownParts<'_>)> {
        let mut first = [0; 3];
        self.ends.iter().map(move |&(number, end)| {
            let begin = std::mem::replace(&mut first, end);
            let known = KnownParts {
                parts: &self.parts[begin[0]..end[0]],
                depths: &self.depths.known[begin[1]..end[1]],
                at_most: &self.depths.at_most[begin[2]..end[2]],
            };
            (number, known)
        })
    }
}
