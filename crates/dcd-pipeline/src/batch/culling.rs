//! Which links are near anything, before any of them is prepared.

use super::checker::BatchChecker;
use super::set::{Marks, Members, ROW, Set, WORDS};
use dcd_broad::{Aabb128, Cell, GridHits, Mask128, PosedBounds};
use dcd_geom::{BoundingSphere, Pose, Sphere16};
use dcd_gjk::NarrowPhase;
use dcd_simd::{Kernel, Lanes, Path, WIDTH, dispatch_on};

/// Bounds of the links of a row, and what they leave to exact queries.
#[derive(Default)]
pub(super) struct Culling {
    /// The links' spheres, configuration by configuration.
    spheres: Vec<Sphere16>,
    reached: GridHits,
    /// For each configuration and link that may reach an obstacle, the range of these obstacles among the
    /// grid's hits; [`UNKNOWN`] where the tree must be queried.
    spans: Vec<Span>,
    /// For each link the configurations in which its bound may reach something, as the lists know,
    /// and those of them in which the tree must be queried.
    listed: Vec<[Marks; 2]>,
    /// For each link its AABB in each configuration, for the query of the tree.
    bounds: Vec<[Aabb128; WORDS]>,
    /// For each link its sphere in each configuration, for the queries of other links.
    of_links: Vec<[Sphere16; ROW / WIDTH]>,
    /// For each link the configurations in which its bound reaches an obstacle.
    near: Vec<Set>,
    /// For each of the link set's own pairs the configurations in which the two spheres meet.
    met: Vec<Set>,
}

type Span = [u32; 2];

const UNKNOWN: Span = [u32::MAX; 2];

impl Culling {
    /// Places and culls the links of so many configurations; `poses` are those of the row.
    ///
    /// `ends` receives the links that may reach anything: their configuration and number, their sphere and
    /// what is noted of it. It may end the configuration, of which nothing more is computed then. Returns the
    /// other configurations.
    pub(super) fn look<N: NarrowPhase>(
        &mut self,
        checker: &BatchChecker<N>,
        (poses, count): (&[Pose], usize),
        mut ends: impl FnMut([usize; 2], &BoundingSphere, &Cell) -> bool,
    ) -> Set {
        let links = checker.rows.link_set.len();
        let Self { spheres, reached, .. } = self;
        spheres.resize((count * links).div_ceil(WIDTH), Sphere16::default());
        reached.clear();
        let mut left = Set::first(count);
        let posed = PosedBounds { bounds: &checker.bounds, poses: &poses[..count * links] };
        // By sixteen configurations, which fill as many rows as there are links, so that they stay near.
        for first in (0..spheres.len()).step_by(links.max(1)) {
            let rows = first..spheres.len().min(first + links);
            let noted = reached.noted();
            checker.obstacle_grid.look_up(posed, rows, spheres, reached);
            reached.sift(noted, links, |config, cell| {
                let sphere = cell.sphere as usize;
                let (link, at) =
                    (sphere - config * links, spheres[sphere / WIDTH].get(sphere % WIDTH));
                let has_ended = ends([config, link], &at, cell);
                if has_ended {
                    left.remove(config);
                }
                has_ended
            });
        }
        self.query_lists(checker);
        self.query_tree(checker, left);
        self.query_links(checker, left);
        left
    }

    /// Notes which links reach what is listed.
    fn query_lists<N: NarrowPhase>(&mut self, checker: &BatchChecker<N>) {
        let (links, unlisted) = (checker.rows.link_set.len(), checker.obstacle_grid.unknown());
        self.spans.resize(links * ROW, UNKNOWN);
        self.listed.clear();
        self.listed.resize_with(links, Default::default);
        checker.obstacle_grid.reach(&self.spheres, &mut self.reached);
        let numbers = self.reached.numbers();
        for (sphere, span) in self.reached.spans() {
            let (config, link) = (sphere / links, sphere % links);
            let is_any = span[1] > span[0];
            let is_unknown = is_any && numbers[span[0] as usize] == unlisted;
            self.spans[config * links + link] = if is_unknown { UNKNOWN } else { span };
            self.listed[link][0].mark(config, is_any);
            self.listed[link][1].mark(config, is_unknown);
        }
    }

    /// Notes which links are near each other.
    fn query_links<N: NarrowPhase>(&mut self, checker: &BatchChecker<N>, left: Set) {
        let (links, pairs) = (checker.rows.link_set.len(), &checker.rows.link_set.self_pairs[..]);
        self.met.clear();
        self.met.resize(pairs.len(), Set::default());
        if pairs.is_empty() {
            return;
        }
        self.of_links.resize_with(links, Default::default);
        let mut rows = 0;
        for config in Members::of(left) {
            let row = config / WIDTH;
            rows = row + 1;
            for (link, spheres) in self.of_links.iter_mut().enumerate() {
                let sphere = config * links + link;
                let sphere = self.spheres[sphere / WIDTH].get(sphere % WIDTH);
                spheres[row].set(config % WIDTH, &sphere);
                // Posed in any case, so that a pose out of range is met.
                if sphere.radius == f32::INFINITY {
                    self.near[link].add(config);
                }
            }
        }
        dispatch_on(
            Path::best(),
            Meet { pairs, rows, spheres: &self.of_links, met: &mut self.met },
        );
        self.met.iter_mut().for_each(|met| *met &= left);
    }

    /// Queries the tree where nothing is listed.
    fn query_tree<N: NarrowPhase>(&mut self, checker: &BatchChecker<N>, left: Set) {
        let links = checker.rows.link_set.len();
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
            for config in Members::of(left & unknown) {
                let sphere = config * links + link;
                let sphere = self.spheres[sphere / WIDTH].get(sphere % WIDTH);
                row[config / Aabb128::LENGTH].set(config % Aabb128::LENGTH, &sphere.aabb());
                // Posed in any case, so that a pose out of range is met.
                if sphere.radius == f32::INFINITY {
                    near.add(config);
                }
            }
            for (word, row) in row.iter().enumerate() {
                near.0[word] |= checker.world.search().tree.reached(row, unknown.0[word]);
            }
            self.near.push(near);
        }
    }

    /// The configurations in which a link is near an obstacle, of those that were not ended.
    pub(super) fn near(&self, link: usize) -> Set {
        self.near[link]
    }

    /// The obstacles that a link's bound may reach in a configuration, ascending. `None`: not known.
    pub(super) fn obstacles(&self, link: usize, config: usize) -> Option<&[u32]> {
        if !self.near[link].has(config) {
            return Some(&[]);
        }
        let [start, end] = self.spans[config * self.near.len() + link];
        self.reached.numbers().get(start as usize..end as usize)
    }

    /// The configurations in which two links are near each other, by the number of their pair.
    pub(super) fn met(&self, pair: usize) -> Set {
        self.met[pair]
    }
}

/// Compares the spheres of each pair in the first rows of configurations.
struct Meet<'a> {
    pairs: &'a [(u32, u32)],
    rows: usize,
    spheres: &'a [[Sphere16; ROW / WIDTH]],
    met: &'a mut [Set],
}

impl Kernel for Meet<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        for (&(k, l), met) in self.pairs.iter().zip(self.met) {
            let (a, b) = (&self.spheres[k as usize], &self.spheres[l as usize]);
            for row in 0..self.rows.min(ROW / WIDTH) {
                let meeting = Mask128::from(a[row].meeting(lanes, &b[row]));
                let first = row * WIDTH;
                met.0[first / Aabb128::LENGTH] |= meeting << (first % Aabb128::LENGTH);
            }
        }
    }
}
