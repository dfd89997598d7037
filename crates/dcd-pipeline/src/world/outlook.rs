//! Which links are near anything, before any of them is prepared.

use super::probe::Probe;
use dcd_broad::{BoxRow, BoxSet};
use dcd_geom::{Aabb, Pose, lanes};
use dcd_gjk::NarrowPhase;

/// How many configurations are worked on at once: enough for full lanes, few enough for the
/// vertices of their links to stay near.
pub(super) const ROW: usize = BoxRow::LENGTH;

/// Some of a row of configurations.
pub(super) type Set = BoxSet;

/// The members of a set, ascending.
pub(super) struct Members(pub(super) Set);

impl Iterator for Members {
    type Item = usize;

    #[inline]
    fn next(&mut self) -> Option<usize> {
        let member = self.0.trailing_zeros() as usize;
        self.0 &= self.0.wrapping_sub(1);
        (member < ROW).then_some(member)
    }
}

/// Bounds of the links, and what they leave to be asked exactly.
#[derive(Default)]
pub(super) struct Outlook {
    /// For each link its bound in every configuration that was looked at.
    bounds: Vec<BoxRow>,
    /// For each link the configurations in which its bound overlaps an obstacle or a link.
    near: Vec<Set>,
    /// For each of the linkage's own pairs the configurations, of those that were looked at last,
    /// in which the two bounds overlap.
    met: Vec<Set>,
}

/// How many configurations ahead a pose is asked for: about as many as are looked at while memory
/// answers. No effect on any result.
const AHEAD: usize = 20;

impl Outlook {
    /// Makes room once, and forgets what was near.
    pub(super) fn open<N: NarrowPhase>(&mut self, probe: &Probe<'_, N>) {
        let links = probe.linkage.len();
        self.bounds.resize_with(links, BoxRow::default);
        self.near.clear();
        self.near.resize(links, 0);
        self.met.resize(probe.linkage.own_pairs.len(), 0);
    }

    /// Looks where a link is in some configurations of a row, all links before it having been
    /// looked at there: in which of them it is near something. `poses` are those of the row.
    pub(super) fn look<N: NarrowPhase>(
        &mut self,
        probe: &Probe<'_, N>,
        link: usize,
        which: Set,
        poses: &[Pose],
    ) -> Set {
        let links = probe.linkage.len();
        let row = &mut self.bounds[link];
        let mut near = 0;
        let call = |own: usize| {
            let place = own * links + link;
            lanes::prefetch(std::slice::from_ref(&poses[place]));
            // A pose may lie on three cache lines, the last of which has the next one's beginning.
            if let Some(next) = poses.get(place + 1) {
                lanes::prefetch(std::slice::from_ref(&next.rotation().x_axis.x));
            }
        };
        let mut later = Members(which);
        later.by_ref().take(AHEAD).for_each(call);
        for own in Members(which) {
            later.next().map(call);
            let place = own * links + link;
            let bound = &probe.bounds[link];
            let aabb = bound.map_or(Aabb::EVERYTHING, |bound| bound.aabb(&poses[place]));
            row.set(own, &aabb);
            if aabb.max.x == f32::INFINITY {
                // Posed in any case, so that a pose out of range is met.
                near |= 1 << own;
            }
        }
        near |= probe.world.tree.reached(row, which);
        for pair in probe.linkage.own_pairs_of(link) {
            let (k, l) = probe.linkage.own_pairs[pair];
            let [k, l] = [k as usize, l as usize];
            let met = which & self.bounds[k].overlaps(&self.bounds[l]);
            self.met[pair] = met;
            self.near[k] |= met;
            near |= met;
        }
        self.near[link] |= near;
        near
    }

    /// The configurations in which a link is near something, of all that were looked at.
    pub(super) fn near(&self, link: usize) -> Set {
        self.near[link]
    }

    /// The configurations in which two links are near each other, by the number of their pair, of
    /// those in which the later link was looked at last.
    pub(super) fn met(&self, pair: usize) -> Set {
        self.met[pair]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn members_are_told_once_and_ascending() {
        assert_eq!(Members(0).count(), 0);
        assert_eq!(Members(1 << (ROW - 1) | 0b1010).collect::<Vec<_>>(), [1, 3, ROW - 1]);
        assert!(Members(Set::MAX).eq(0..ROW));
    }
}
