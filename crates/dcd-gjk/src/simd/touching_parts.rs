//! Which parts touch of meshes and polytopes, and of compounds, where a measure of them follows.

use crate::epa::Depth;
use crate::mesh::{self, KnownParts, Lists};
use crate::{Method, PosedShape, Verdict};
use dcd_geom::Pair;
use dcd_simd::Path;

/// Which parts of the touching meshes and polytopes of a slice touch: found once, for yes or no and for the measure.
#[derive(Clone, Debug, Default)]
pub(super) struct TouchingParts {
    wanted: Wanted,
    /// For each pair its number in the slice, and where its lists end.
    ends: Vec<(u32, Lengths)>,
    parts: Vec<[u32; 2]>,
    /// Of some of these.
    depths: Vec<(u32, Depth)>,
    /// Upper bounds of how deep they are.
    at_most: Vec<(u32, f32)>,
    pub(super) of_compounds: OfCompounds,
}

/// Which parts of the touching pairs of a slice touch that are of compounds.
#[derive(Clone, Debug, Default)]
pub(super) struct OfCompounds {
    /// For each pair its number in the slice, in rising order, and where its pairs of parts end.
    pub(super) ends: Vec<(u32, usize)>,
    /// By their records.
    pub(super) pairs: Vec<Pair>,
}

impl OfCompounds {
    fn clear(&mut self) {
        self.ends.clear();
        self.pairs.clear();
    }

    /// Takes in a pair of the slice by its number, and its parts.
    pub(super) fn push(&mut self, number: u32, parts: impl Iterator<Item = Pair>) {
        let begin = self.pairs.len();
        self.pairs.extend(parts);
        if self.pairs.len() > begin {
            self.ends.push((number, self.pairs.len()));
        }
    }
}

/// What the measure reads of the parts that touch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum Wanted {
    #[default]
    Nothing,
    /// Which they are.
    Parts,
    /// And [`KnownParts::at_most`].
    Bounds,
}

/// How long the lists are: of parts, of depths, and of what bounds depths.
type Lengths = [usize; 3];

impl TouchingParts {
    /// Forgets the last slice.
    pub(super) fn begin(&mut self, wanted: Wanted) {
        self.wanted = wanted;
        self.ends.clear();
        self.parts.clear();
        self.depths.clear();
        self.at_most.clear();
        self.of_compounds.clear();
    }

    pub(super) fn is_wanted(&self) -> bool {
        self.wanted != Wanted::Nothing
    }

    /// Looks for all of a pair.
    pub(super) fn search(
        &mut self,
        path: Path,
        (number, sides): (u32, [PosedShape<'_>; 2]),
        scratch: &mut mesh::Scratch,
    ) -> (Verdict<()>, Method) {
        let first = self.lengths();
        let Self { parts, depths, at_most, wanted, .. } = self;
        let bounds = (*wanted == Wanted::Bounds).then_some(&mut *at_most);
        let lists = Lists { pairs: &mut *parts, depths: &mut *depths, at_most: bounds };
        let found = mesh::touching_with_depths(path, sides, scratch, lists);
        if found.0 == Verdict::Touching(()) {
            self.ends.push((number, self.lengths()));
        } else {
            parts.truncate(first[0]);
            depths.truncate(first[1]);
            at_most.truncate(first[2]);
        }
        found
    }

    fn lengths(&self) -> Lengths {
        [self.parts.len(), self.depths.len(), self.at_most.len()]
    }

    /// The lists of the touching pairs, each with its number in the slice, in rising order.
    pub(super) fn lists(&self) -> impl Iterator<Item = (u32, KnownParts<'_>)> {
        let mut first = [0; 3];
        self.ends.iter().map(move |&(number, end)| {
            let begin = std::mem::replace(&mut first, end);
            let known = KnownParts {
                parts: &self.parts[begin[0]..end[0]],
                depths: &self.depths[begin[1]..end[1]],
                at_most: &self.at_most[begin[2]..end[2]],
            };
            (number, known)
        })
    }
}
