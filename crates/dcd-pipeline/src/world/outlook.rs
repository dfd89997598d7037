//! Which links are near anything, before any of them is prepared.

use super::probe::Probe;
use super::set::{Members, Set, WORDS};
use dcd_broad::BoxRow;
use dcd_geom::{Aabb, Pose, lanes};
use dcd_gjk::NarrowPhase;

/// Bounds of the links, and what they leave to be asked exactly.
#[derive(Default)]
pub(super) struct Outlook {
    /// For each link its bound in every configuration that was looked at.
    bounds: Vec<[BoxRow; WORDS]>,
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
        self.bounds.resize_with(links, Default::default);
        self.near.clear();
        self.near.resize(links, Set::default());
        self.met.resize(probe.linkage.own_pairs.len(), Set::default());
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
        let mut near = Set::default();
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
            row[own / BoxRow::LENGTH].set(own % BoxRow::LENGTH, &aabb);
            if aabb.max.x == f32::INFINITY {
                // Posed in any case, so that a pose out of range is met.
                near.add(own);
            }
        }
        for (word, row) in row.iter().enumerate() {
            near.0[word] |= probe.world.tree.reached(row, which.0[word]);
        }
        for pair in probe.linkage.own_pairs_of(link) {
            let (k, l) = probe.linkage.own_pairs[pair];
            let [k, l] = [k as usize, l as usize];
            let overlap = |word: usize| self.bounds[k][word].overlaps(&self.bounds[l][word]);
            let met = which & Set(std::array::from_fn(overlap));
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
