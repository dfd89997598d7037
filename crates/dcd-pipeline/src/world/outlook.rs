//! Which links are near anything, before any of them is prepared.

use super::probe::Probe;
use super::set::{Marks, Members, ROW, Set, WORDS};
use dcd_broad::{BoxRow, BoxSet, Listing, Posed, Reached};
use dcd_geom::lanes::{Kernel, Lanes, Path, WIDTH, dispatch_on};
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
    /// For each link its box in each configuration, where the tree is asked for it.
    bounds: Vec<[BoxRow; WORDS]>,
    /// For each link its ball in each configuration, where other links are asked for it.
    of_links: Vec<[BallRow; ROW / WIDTH]>,
    /// For each link the configurations in which its bound reaches an obstacle.
    near: Vec<Set>,
    /// For each of the linkage's own pairs the configurations in which the two balls meet.
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
        self.ask_links(probe, left);
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

    /// Notes which links are near each other.
    fn ask_links<N: NarrowPhase>(&mut self, probe: &Probe<'_, N>, left: Set) {
        let (links, pairs) = (probe.linkage.len(), &probe.linkage.own_pairs[..]);
        self.met.clear();
        self.met.resize(pairs.len(), Set::default());
        if pairs.is_empty() {
            return;
        }
        self.of_links.resize_with(links, Default::default);
        let mut rows = 0;
        for own in Members::of(left) {
            let row = own / WIDTH;
            rows = row + 1;
            for (link, balls) in self.of_links.iter_mut().enumerate() {
                let ball = own * links + link;
                let ball = self.balls[ball / WIDTH].get(ball % WIDTH);
                balls[row].set(own % WIDTH, &ball);
                // Posed in any case, so that a pose out of range is met.
                if ball.radius == f32::INFINITY {
                    self.near[link].add(own);
                }
            }
        }
        dispatch_on(Path::best(), Meet { pairs, rows, balls: &self.of_links, met: &mut self.met });
        self.met.iter_mut().for_each(|met| *met &= left);
    }

    /// Asks the tree where nothing is listed.
    fn ask_tree<N: NarrowPhase>(&mut self, probe: &Probe<'_, N>, left: Set) {
        let links = probe.linkage.len();
        self.bounds.resize_with(links, Default::default);
        self.near.clear();
        for (link, listed) in self.listed.iter().enumerate() {
            let [mut near, unknown] = listed.each_ref().map(Marks::set);
            if unknown.is_empty() {
                self.near.push(near);
                continue;
            }
            near &= !unknown;
            let row = &mut self.bounds[link];
            for own in Members::of(left & unknown) {
                let ball = own * links + link;
                let ball = self.balls[ball / WIDTH].get(ball % WIDTH);
                row[own / BoxRow::LENGTH].set(own % BoxRow::LENGTH, &ball.aabb());
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

/// Compares the balls of each pair in the first rows of configurations.
struct Meet<'a> {
    pairs: &'a [(u32, u32)],
    rows: usize,
    balls: &'a [[BallRow; ROW / WIDTH]],
    met: &'a mut [Set],
}

impl Kernel for Meet<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        for (&(k, l), met) in self.pairs.iter().zip(self.met) {
            let (a, b) = (&self.balls[k as usize], &self.balls[l as usize]);
            for row in 0..self.rows.min(ROW / WIDTH) {
                let meeting = BoxSet::from(a[row].meeting(lanes, &b[row]));
                let first = row * WIDTH;
                met.0[first / BoxRow::LENGTH] |= meeting << (first % BoxRow::LENGTH);
            }
        }
    }
}
