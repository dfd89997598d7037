//! Which links are near anything, before any of them is prepared.

use super::probe::Probe;
use super::set::{Marks, Members, ROW, Set, WORDS};
use dcd_broad::{BoxRow, Reached};
use dcd_geom::{LooseBall, Pose, lanes};
use dcd_gjk::NarrowPhase;

/// Bounds of the links, and what they leave to be asked exactly.
#[derive(Default)]
pub(super) struct Outlook {
    /// For each link its bound in every configuration that was looked at, where the tree or other
    /// links are asked for it.
    bounds: Vec<[BoxRow; WORDS]>,
    /// For each link, for every configuration that was looked at, where in `obstacles` those begin
    /// and end that its bound may reach; [`UNKNOWN`] where the tree has to be asked.
    spans: Vec<[Span; ROW]>,
    obstacles: Vec<u32>,
    /// Of the link that is looked at: the configurations, and its balls.
    owns: Vec<u32>,
    balls: Vec<LooseBall>,
    reached: Reached,
    /// For each link the configurations in which its bound overlaps an obstacle or a link.
    near: Vec<Set>,
    /// For each of the linkage's own pairs the configurations, of those that were looked at last,
    /// in which the two bounds overlap.
    met: Vec<Set>,
}

type Span = [u32; 2];

const UNKNOWN: Span = [u32::MAX; 2];

/// How many configurations ahead a pose is asked for: about as many as are looked at while memory
/// answers. No effect on any result.
const AHEAD: usize = 20;

impl Outlook {
    /// Makes room once, and forgets what was near.
    pub(super) fn open<N: NarrowPhase>(&mut self, probe: &Probe<'_, N>) {
        let links = probe.linkage.len();
        self.bounds.resize_with(links, Default::default);
        self.spans.resize(links, [UNKNOWN; ROW]);
        self.obstacles.clear();
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
        let call = |own: usize| {
            let place = own * links + link;
            lanes::prefetch(std::slice::from_ref(&poses[place]));
            // And the next link's, which is looked at next.
            if let Some(next) = poses.get(place + 1) {
                lanes::prefetch(std::slice::from_ref(next));
            }
        };
        let bound = probe.bounds[link];
        let count = which.len();
        self.owns.resize(count, 0);
        self.balls.resize(count, LooseBall::EVERYTHING);
        let mut later = Members::of(which);
        later.by_ref().take(AHEAD).for_each(call);
        let places = self.owns.iter_mut().zip(&mut self.balls);
        for (own, (number, ball)) in Members::of(which).zip(places) {
            later.next().map(call);
            let pose = &poses[own * links + link];
            *number = own as u32;
            *ball = bound.map_or(LooseBall::EVERYTHING, |bound| bound.ball(pose));
        }
        let mut near = self.reach(probe, link);
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

    /// The configurations, of those that are looked at, in which a link reaches an obstacle.
    fn reach<N: NarrowPhase>(&mut self, probe: &Probe<'_, N>, link: usize) -> Set {
        let (mut near, unknown) = self.reach_listed(probe, link);
        let asks_links = !probe.linkage.own_pairs.is_empty();
        if !asks_links && unknown.is_empty() {
            return near;
        }
        let row = &mut self.bounds[link];
        for (&own, ball) in self.owns.iter().zip(&self.balls) {
            let own = own as usize;
            if asks_links || unknown.has(own) {
                row[own / BoxRow::LENGTH].set(own % BoxRow::LENGTH, &ball.aabb());
            }
            // Posed in any case, so that a pose out of range is met.
            if ball.radius == f32::INFINITY {
                near.add(own);
            }
        }
        for (word, row) in row.iter().enumerate() {
            near.0[word] |= probe.world.tree.reached(row, unknown.0[word]);
        }
        near
    }

    /// The configurations in which a link reaches what is listed, and those where nothing is known.
    fn reach_listed<N: NarrowPhase>(&mut self, probe: &Probe<'_, N>, link: usize) -> (Set, Set) {
        let Self { spans, obstacles, owns, balls, reached, .. } = self;
        let spans = &mut spans[link];
        probe.vicinity.reach(balls, reached);
        let (mut near, mut unknown) = (Marks::default(), Marks::default());
        let (first, mut start) = (obstacles.len() as u32, 0);
        obstacles.extend_from_slice(reached.numbers());
        for (&own, &end) in owns.iter().zip(reached.ends()) {
            let own = own as usize;
            spans[own] = [first + start, first + end];
            near.mark(own, end > start);
            if end > start && reached.numbers()[start as usize] == probe.vicinity.unknown() {
                spans[own] = UNKNOWN;
                unknown.mark(own, true);
            }
            start = end;
        }
        let unknown = unknown.set();
        (near.set() & !unknown, unknown)
    }

    /// The obstacles that a link's bound may reach in a configuration that was looked at, ascending.
    /// `None`: not known.
    pub(super) fn obstacles(&self, link: usize, own: usize) -> Option<&[u32]> {
        let [start, end] = self.spans[link][own];
        self.obstacles.get(start as usize..end as usize)
    }

    /// The configurations in which two links are near each other, by the number of their pair, of
    /// those in which the later link was looked at last.
    pub(super) fn met(&self, pair: usize) -> Set {
        self.met[pair]
    }
}
