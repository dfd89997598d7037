//! Which links are near anything, before any of them is prepared.

use super::probe::Probe;
use super::set::{Marks, Members, ROW, Set, WORDS};
use dcd_broad::{BoxRow, Listing, Posed, Reached};
use dcd_geom::lanes::WIDTH;
use dcd_geom::{BallRow, LooseBall, Pose};
use dcd_gjk::NarrowPhase;

/// Bounds of the links of a row, and what they leave to be asked exactly.
#[derive(Default)]
pub(super) struct Outlook {
    /// The links' balls, configuration by configuration.
    balls: Vec<BallRow>,
    reached: Reached,
    /// For each configuration and link that may reach an obstacle, where among what is reached the
    /// obstacles begin and end; [`UNKNOWN`] where the tree has to be asked.
    spans: Vec<Span>,
    /// For each link the configurations in which its bound may reach something, as the lists know,
    /// and those of them in which the tree has to be asked.
    listed: Vec<[Marks; 2]>,
    /// For each link its box in each configuration, where the tree or other links are asked for it.
    bounds: Vec<[BoxRow; WORDS]>,
    /// For each link the configurations in which its bound reaches an obstacle.
    near: Vec<Set>,
    /// For each of the linkage's own pairs the configurations in which the two bounds overlap.
    met: Vec<Set>,
}

type Span = [u32; 2];

const UNKNOWN: Span = [u32::MAX; 2];

impl Outlook {
    /// Looks where the links of so many configurations are; `poses` are those of the row.
    ///
    /// `ends` is told which links may reach anything, by their configuration and their number, with
    /// their ball and what is noted of it, and may end the configuration: then no more is known of it.
    /// Returns the others.
    pub(super) fn look<N: NarrowPhase>(
        &mut self,
        probe: &Probe<'_, N>,
        (poses, count): (&[Pose], usize),
        mut ends: impl FnMut([usize; 2], &LooseBall, &Listing) -> bool,
    ) -> Set {
        let links = probe.linkage.len();
        let Self { balls, reached, .. } = self;
        balls.resize((count * links).div_ceil(WIDTH), BallRow::default());
        reached.clear();
        let mut left = Set::first(count);
        let posed = Posed { bounds: &probe.bounds, poses: &poses[..count * links] };
        // By sixteen configurations, which fill as many rows as there are links, so that they stay near.
        for first in (0..balls.len()).step_by(links.max(1)) {
            let rows = first..balls.len().min(first + links);
            let noted = reached.noted();
            probe.vicinity.look_up(posed, rows, balls, reached);
            reached.sift(noted, links, |own, listing| {
                let ball = listing.ball as usize;
                let (link, at) = (ball - own * links, balls[ball / WIDTH].get(ball % WIDTH));
                let has_ended = ends([own, link], &at, listing);
                if has_ended {
                    left.remove(own);
                }
                has_ended
            });
        }
        self.ask_lists(probe);
        self.ask_tree(probe, left);
        self.met.clear();
        for &(k, l) in &probe.linkage.own_pairs {
            let [k, l] = [k, l].map(|link| &self.bounds[link as usize]);
            self.met.push(left & Set(std::array::from_fn(|word| k[word].overlaps(&l[word]))));
        }
        left
    }

    /// Notes which links reach what is listed.
    fn ask_lists<N: NarrowPhase>(&mut self, probe: &Probe<'_, N>) {
        let (links, unlisted) = (probe.linkage.len(), probe.vicinity.unknown());
        self.spans.resize(links * ROW, UNKNOWN);
        self.listed.clear();
        self.listed.resize_with(links, Default::default);
        probe.vicinity.reach(&self.balls, &mut self.reached);
        let numbers = self.reached.numbers();
        for (ball, span) in self.reached.spans() {
            let (own, link) = (ball / links, ball % links);
            let is_any = span[1] > span[0];
            let is_unknown = is_any && numbers[span[0] as usize] == unlisted;
            self.spans[own * links + link] = if is_unknown { UNKNOWN } else { span };
            self.listed[link][0].mark(own, is_any);
            self.listed[link][1].mark(own, is_unknown);
        }
    }

    /// Asks the tree where nothing is listed, and notes the boxes that are asked for later.
    fn ask_tree<N: NarrowPhase>(&mut self, probe: &Probe<'_, N>, left: Set) {
        let links = probe.linkage.len();
        let asks_links = !probe.linkage.own_pairs.is_empty();
        self.bounds.resize_with(links, Default::default);
        self.near.clear();
        for (link, listed) in self.listed.iter().enumerate() {
            let [mut near, unknown] = listed.each_ref().map(Marks::set);
            if !asks_links && unknown.is_empty() {
                self.near.push(near);
                continue;
            }
            near &= !unknown;
            let row = &mut self.bounds[link];
            for own in Members::of(left) {
                let ball = own * links + link;
                let ball = self.balls[ball / WIDTH].get(ball % WIDTH);
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
            self.near.push(near);
        }
    }

    /// The configurations in which a link is near an obstacle, of those that were not ended.
    pub(super) fn near(&self, link: usize) -> Set {
        self.near[link]
    }

    /// The obstacles that a link's bound may reach in a configuration, ascending. `None`: not known.
    pub(super) fn obstacles(&self, link: usize, own: usize) -> Option<&[u32]> {
        if !self.near[link].has(own) {
            return Some(&[]);
        }
        let [start, end] = self.spans[own * self.near.len() + link];
        self.reached.numbers().get(start as usize..end as usize)
    }

    /// The configurations in which two links are near each other, by the number of their pair.
    pub(super) fn met(&self, pair: usize) -> Set {
        self.met[pair]
    }
}
