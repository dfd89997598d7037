//! A [`Feature`] as three numbers: one of several is selected number by number, without a branch that could not be predicted
//! and without a detour through memory, which would wait for what has just been written.

use super::Feature;
use std::hint::select_unpredictable;

/// Which feature it is, and the numbers that it has; 0 for one that it has not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct FeatureCode {
    kind: u32,
    first: u32,
    second: u32,
}

const SURFACE: u32 = 0;
const VERTEX: u32 = 1;
const EDGE: u32 = 2;
const FACE: u32 = 3;

impl FeatureCode {
    #[inline(always)]
    pub(super) fn vertex(index: u32) -> Self {
        Self { kind: VERTEX, first: index, second: 0 }
    }

    /// Between two vertices.
    #[inline(always)]
    pub(super) fn edge(j: u32, k: u32) -> Self {
        Self { kind: EDGE, first: j.min(k), second: j.max(k) }
    }

    #[inline(always)]
    pub(super) fn select(condition: bool, yes: Self, no: Self) -> Self {
        Self {
            kind: select_unpredictable(condition, yes.kind, no.kind),
            first: select_unpredictable(condition, yes.first, no.first),
            second: select_unpredictable(condition, yes.second, no.second),
        }
    }
}

impl From<Feature> for FeatureCode {
    #[inline(always)]
    fn from(feature: Feature) -> Self {
        let (kind, first, second) = match feature {
            Feature::Surface => (SURFACE, 0, 0),
            Feature::Vertex(index) => (VERTEX, index, 0),
            Feature::Edge(first, second) => (EDGE, first, second),
            Feature::Face(index) => (FACE, index, 0),
        };
        Self { kind, first, second }
    }
}

impl From<FeatureCode> for Feature {
    #[inline]
    fn from(FeatureCode { kind, first, second }: FeatureCode) -> Self {
        match kind {
            SURFACE => Self::Surface,
            VERTEX => Self::Vertex(first),
            EDGE => Self::Edge(first, second),
            _ => Self::Face(first),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_feature_is_read_as_it_was_written_and_selected_whole() {
        let last = u32::MAX;
        let features =
            [Feature::Surface, Feature::Vertex(last), Feature::Edge(3, last), Feature::Face(last)];
        for feature in features {
            assert_eq!(Feature::from(FeatureCode::from(feature)), feature);
            for other in features {
                let [yes, no] = [feature, other].map(FeatureCode::from);
                assert_eq!(Feature::from(FeatureCode::select(true, yes, no)), feature);
                assert_eq!(Feature::from(FeatureCode::select(false, yes, no)), other);
            }
        }
        assert_eq!(Feature::from(FeatureCode::vertex(7)), Feature::Vertex(7));
        assert_eq!(Feature::from(FeatureCode::edge(7, 2)), Feature::Edge(2, 7));
    }
}
