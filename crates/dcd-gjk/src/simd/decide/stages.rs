//! The stages that pairs wait for, and which is next.

use super::super::packet::Whole;
use super::Scratch;

/// A stage after the spheres, with a queue of its own.
#[derive(Clone, Copy)]
pub(super) enum Stage {
    Straight,
    Obbs,
    CentreAxis,
    Nearest,
    Search,
    SecondPoint,
    Portal,
}

impl Stage {
    /// All, the latest first.
    const LATEST_FIRST: [Self; 7] = [
        Self::Portal,
        Self::SecondPoint,
        Self::Search,
        Self::Nearest,
        Self::CentreAxis,
        Self::Obbs,
        Self::Straight,
    ];
}

impl Scratch {
    /// The latest stage for which a packet waits. So each stage finds space in the next one's queue for what it
    /// hands on.
    #[inline(always)]
    pub(super) fn latest_stage(&self, whole: Whole) -> Option<Stage> {
        let waits = |stage: &Stage| match stage {
            Stage::Straight => self.straight.has(whole),
            Stage::Obbs => self.boxed.has(whole),
            Stage::CentreAxis => self.axis.has(whole),
            Stage::Nearest => self.near.has(whole),
            Stage::Search => self.search.has(whole),
            Stage::SecondPoint => self.second.has(whole),
            Stage::Portal => self.portal.has(whole),
        };
        Stage::LATEST_FIRST.into_iter().find(waits)
    }
}
