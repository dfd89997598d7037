//! Which links are near anything, before any of them is prepared.

use super::probe::Probe;
use super::set::{Marks, ROW, Set, WORDS};
use dcd_broad::{BoxRow, Cell, Reached};
use dcd_geom::{LooseBall, Pose, lanes};
use dcd_gjk::NarrowPhase;

/// Bounds of the links of a row, and what they leave to be asked exactly.
#[derive(Default)]
pub(super) struct Outlook {
    /// The configurations that are not ended.
    owns: Vec<u32>,
    /// Their links' balls and where those are looked up, configuration by configuration.
    balls: Vec<LooseBall>,
    cells: Vec<Cell>,
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

/// How many configurations ahead their poses are asked for: what is looked at while memory answers.
/// No effect on any result.
const AHEAD: usize = 3;

impl Outlook {
    /// Looks where the links of so many configurations are; `poses` are those of the row.
    ///
    /// `ends` is told the balls of a configuration's links and their cells, and may end it: then no
    /// more is known of it. Returns the others.
    pub(super) fn look<N: NarrowPhase>(
        &mut self,
        probe: &Probe<'_, N>,
        (poses, count): (&[Pose], usize),
        mut ends: impl FnMut(usize, &[LooseBall], &[Cell]) -> bool,
    ) -> Set {
        let links = probe.linkage.len();
        self.owns.clear();
        self.balls.resize(count * links, LooseBall::EVERYTHING);
        self.cells.resize(count * links, Cell::default());
        let mut left = Marks::default();
        // Pose after pose, as they lie in memory.
        for own in 0..count {
            if let Some(later) = poses.get((own + AHEAD) * links..(own + AHEAD + 1) * links) {
                lanes::prefetch(later);
            }
            // In the place of those that are ended.
            let start = self.owns.len() * links;
            let balls = &mut self.balls[start..][..links];
            let cells = &mut self.cells[start..][..links];
            let bounds = poses[own * links..].iter().zip(&probe.bounds);
            for ((pose, bound), (ball, cell)) in bounds.zip(balls.iter_mut().zip(&mut *cells)) {
                *ball = bound.as_ref().map_or(LooseBall::EVERYTHING, |bound| bound.ball(pose));
                *cell = probe.vicinity.cell(ball);
                probe.vicinity.call(*cell);
            }
            if !ends(own, balls, cells) {
                self.owns.push(own as u32);
                left.mark(own, true);
            }
        }
        self.balls.truncate(self.owns.len() * links);
        self.cells.truncate(self.owns.len() * links);
        let left = left.set();
        self.ask_lists(probe);
        self.ask_tree(probe);
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
        probe.vicinity.reach(&self.balls, &self.cells, &mut self.reached);
        let numbers = self.reached.numbers();
        for (ball, span) in self.reached.spans() {
            let (own, link) = (self.owns[ball / links] as usize, ball % links);
            let is_any = span[1] > span[0];
            let is_unknown = is_any && numbers[span[0] as usize] == unlisted;
            self.spans[own * links + link] = if is_unknown { UNKNOWN } else { span };
            self.listed[link][0].mark(own, is_any);
            self.listed[link][1].mark(own, is_unknown);
        }
    }

    /// Asks the tree where nothing is listed, and notes the boxes that are asked for later.
    fn ask_tree<N: NarrowPhase>(&mut self, probe: &Probe<'_, N>) {
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
            for (&own, ball) in self.owns.iter().zip(self.balls.iter().skip(link).step_by(links)) {
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
