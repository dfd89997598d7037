//! A thread's work on a few configurations.

use super::StaticWorld;
use super::checker::{BatchChecker, Hit, Other};
use super::culling::Culling;
use super::first_hits::FirstHitSearch;
use super::set::{Members, ROW, Set};
use dcd_broad::IdentifiedAabbs;
use dcd_geom::{Aabb, Pair, Pose, Scene, Splittable};
use dcd_gjk::{Contact, ContactSink, NarrowPhase, Report, Verdict};
use std::ops::Range;

/// A scene of the obstacles and of a row of objects for each link, made ready again and again.
///
/// Links that are near something take the objects of their row one after the other, so that what is
/// prepared lies without gaps; the rest of a row stays as it was.
pub(super) struct WorkerScratch<N: NarrowPhase> {
    scene: Scene,
    frame: N::Frame,
    pub(super) aabbs: Vec<Aabb>,
    /// 0, 1, 2, …: what the boxes of the rows are called.
    names: Vec<u32>,
    scratch: N::Scratch,
    pub(super) culling: Culling,
    /// The first configuration, by its number in the batch, and how many there are.
    pub(super) start: usize,
    count: usize,
    /// The configurations that are still asked for, counted from the first.
    pub(super) open: Set,
    /// For each link the configurations in which it is wanted next.
    pub(super) due: Vec<Set>,
    /// For each link the configurations of which it is posed.
    pub(super) posed: Vec<Set>,
    /// For each object of the rows the configuration that it stands for.
    pub(super) owners: Vec<u32>,
    /// For each link and configuration the object that stands for it, where it is posed.
    pub(super) slots: Vec<[u32; ROW]>,
    /// For each link the objects that were posed last.
    pub(super) fresh: Vec<Range<usize>>,
    pub(super) pairs: Vec<Pair>,
    pub(super) contacts: Vec<Contact<N::Answer>>,
    pub(super) report: Report,
    pub(super) search: FirstHitSearch,
    pub(super) sorting: Sorting<N::Answer>,
}

impl<N: NarrowPhase> Default for WorkerScratch<N> {
    fn default() -> Self {
        Self {
            scene: Scene::default(),
            frame: N::Frame::default(),
            aabbs: Vec::new(),
            names: Vec::new(),
            scratch: N::Scratch::default(),
            culling: Culling::default(),
            start: 0,
            count: 0,
            open: Set::default(),
            due: Vec::new(),
            posed: Vec::new(),
            owners: Vec::new(),
            slots: Vec::new(),
            fresh: Vec::new(),
            pairs: Vec::new(),
            contacts: Vec::new(),
            report: Report::default(),
            search: FirstHitSearch::default(),
            sorting: Sorting::default(),
        }
    }
}

/// Findings to be put in the order of their configurations.
pub(super) struct Sorting<A> {
    hits: Vec<Hit<A>>,
    /// Where those of each configuration begin.
    starts: [usize; ROW + 1],
}

impl<A> Default for Sorting<A> {
    fn default() -> Self {
        Self { hits: Vec::new(), starts: [0; ROW + 1] }
    }
}

impl<N: NarrowPhase> WorkerScratch<N> {
    /// Makes room and prepares the obstacles, the first time and when there is need of more.
    pub(super) fn set_up(&mut self, checker: &BatchChecker<'_, N>) {
        let (template, links) = (&checker.template, checker.link_set.len());
        if self.scene.layout() == template.layout() {
            return;
        }
        self.scene = template.clone();
        self.aabbs.resize(template.len(), Aabb::EMPTY);
        self.names.clear();
        self.names.extend((0..).take(template.len()));
        self.owners.resize(checker.row * links, 0);
        self.slots.resize(links, [0; ROW]);
        let part = checker.world.narrow.layout(&self.scene, &mut self.frame);
        let ((part, aabbs), _) =
            (part, &mut self.aabbs[..]).split_at(checker.world.obstacles.len());
        checker.world.narrow.prepare(&self.scene, 0, part, aabbs);
    }

    /// Takes up so many configurations, at most a row.
    pub(super) fn open(&mut self, checker: &BatchChecker<'_, N>, start: usize, count: usize) {
        self.set_up(checker);
        let links = checker.link_set.len();
        for sets in [&mut self.due, &mut self.posed] {
            sets.clear();
            sets.resize(links, Set::default());
        }
        (self.start, self.count) = (start, count);
    }

    /// All pairs of the configurations taken up, settled. The index of the first pose that was
    /// refused, if any.
    pub(super) fn settle_all(
        &mut self,
        checker: &BatchChecker<'_, N>,
        poses: &[Pose],
    ) -> Option<usize> {
        let links = checker.link_set.len();
        let row = (&poses[self.start * links..], self.count);
        self.open = self.culling.look(checker, row, |_, _, _| false);
        for (link, due) in self.due.iter_mut().enumerate() {
            *due = self.culling.near(link);
        }
        for (pair, &(k, l)) in checker.link_set.self_pairs.iter().enumerate() {
            self.due[k as usize] |= self.culling.met(pair);
            self.due[l as usize] |= self.culling.met(pair);
        }
        let refused = self.place(checker, poses);
        self.pairs.clear();
        for link in 0..links {
            self.append_pairs(checker, link);
        }
        for (pair, &(k, l)) in checker.link_set.self_pairs.iter().enumerate() {
            for config in Members::of(self.culling.met(pair)) {
                let met = self.self_pair(config, [k, l]);
                self.pairs.extend(met);
            }
        }
        self.decide(checker);
        refused
    }

    /// Poses and prepares what is due and not yet posed. The index of the first pose that was
    /// refused.
    pub(super) fn place(&mut self, checker: &BatchChecker<'_, N>, poses: &[Pose]) -> Option<usize> {
        let (rows, count) = (checker.world.obstacles.len(), checker.link_set.len());
        let mut refused: Option<usize> = None;
        self.fresh.clear();
        for link in 0..count {
            let first = checker.row_of(link) + self.posed[link].len();
            let mut slot = first;
            for config in Members::of(self.due[link] & !self.posed[link]) {
                let pose = (self.start + config) * count + link;
                if self.scene.set_pose(slot, poses[pose]).is_err() {
                    refused = Some(refused.map_or(pose, |first| first.min(pose)));
                    continue;
                }
                self.posed[link].add(config);
                self.owners[slot - rows] = config as u32;
                self.slots[link][config] = slot as u32;
                slot += 1;
            }
            self.fresh.push(first..slot);
        }
        self.prepare(checker);
        refused
    }

    /// Prepares what was posed last; everything, where the frame has not kept the rest.
    fn prepare(&mut self, checker: &BatchChecker<'_, N>) {
        let Self { scene, frame, aabbs, fresh, .. } = self;
        let part = checker.world.narrow.layout(scene, frame);
        if !checker.world.narrow.keeps(&part) {
            return checker.world.narrow.prepare(scene, 0, part, aabbs);
        }
        let mut rest = (part, &mut aabbs[..]);
        let mut start = 0;
        for new in fresh.iter().filter(|new| !new.is_empty()) {
            let (_, others) = rest.split_at(new.start - start);
            let ((part, aabbs), others) = others.split_at(new.len());
            checker.world.narrow.prepare(scene, new.start, part, aabbs);
            (rest, start) = (others, new.end);
        }
    }

    /// Appends the pairs of a link, where it was posed last, with the obstacles: object by object, the
    /// obstacles ascending.
    pub(super) fn append_pairs(&mut self, checker: &BatchChecker<'_, N>, link: usize) {
        let mut pairs = std::mem::take(&mut self.pairs);
        if self.scene.filters_movers() {
            self.ask(checker, link, |i, j| self.scene.allows(i, j), &mut pairs);
        } else {
            self.ask(checker, link, |_, _| true, &mut pairs);
        }
        self.pairs = pairs;
    }

    fn ask(
        &self,
        checker: &BatchChecker<'_, N>,
        link: usize,
        keep: impl Fn(u32, u32) -> bool,
        pairs: &mut Vec<Pair>,
    ) {
        let Self { aabbs, names, owners, .. } = self;
        let (StaticWorld { tree, obstacles, .. }, new) = (checker.world, self.fresh[link].clone());
        let ask_tree = |slots: Range<usize>, pairs: &mut Vec<Pair>| {
            if !slots.is_empty() {
                let start = pairs.len();
                let asked = IdentifiedAabbs { aabbs: &aabbs[slots.clone()], names: &names[slots] };
                tree.append_pairs(asked, &keep, pairs);
                // The tree is asked slot by slot, so that short lists are left to be sorted.
                let of_one_slot = |a: &Pair, b: &Pair| a.j == b.j;
                let lists = pairs[start..].chunk_by_mut(of_one_slot);
                lists.for_each(|list| list.sort_unstable_by_key(|pair| pair.i));
            }
        };
        // The objects since which the tree has not been asked: what they may reach is not known.
        let mut unknown = new.start;
        for slot in new.clone() {
            let config = owners[slot - obstacles.len()] as usize;
            if let Some(numbers) = self.culling.obstacles(link, config) {
                ask_tree(unknown..slot, pairs);
                unknown = slot + 1;
                checker.obstacle_grid.append_pairs(
                    (names[slot], &aabbs[slot]),
                    numbers,
                    &keep,
                    pairs,
                );
            }
        }
        ask_tree(unknown..new.end, pairs);
    }

    /// The pair of two links of one configuration, if their boxes overlap.
    pub(super) fn self_pair(&self, config: usize, links: [u32; 2]) -> Option<Pair> {
        let links = links.map(|link| link as usize);
        // Of a pose that was refused there is no object.
        if links.iter().any(|&link| !self.posed[link].has(config)) {
            return None;
        }
        let [k, l] = links.map(|link| self.slots[link][config]);
        let overlap = self.aabbs[k as usize].overlaps(&self.aabbs[l as usize]);
        overlap.then(|| Pair::new(k, l))
    }

    /// Settles the pairs.
    pub(super) fn decide(&mut self, checker: &BatchChecker<'_, N>) {
        let Self { scene, frame, scratch, pairs, contacts, report, .. } = self;
        contacts.clear();
        report.clear();
        let mut sink = ContactSink { contacts, report };
        checker.world.narrow.decide(scene, frame, pairs, scratch, &mut sink);
        report.sort();
    }

    /// Appends all hits, configuration by configuration.
    pub(super) fn append_all(
        &mut self,
        checker: &BatchChecker<'_, N>,
        out: &mut Vec<Hit<N::Answer>>,
    ) {
        let mut sorting = std::mem::take(&mut self.sorting);
        let touching = self.contacts.iter().map(|c| (c.pair, Verdict::Touching(c.answer)));
        let undecided = self.report.undecided().iter();
        let undecided = undecided.map(|u| (u.pair, Verdict::Undecided(u.reason)));
        sorting.hits.clear();
        sorting.starts = [0; ROW + 1];
        for (pair, verdict) in touching.chain(undecided) {
            let (config, hit) = self.hit(checker, pair, verdict);
            sorting.starts[config + 1] += 1;
            sorting.hits.push(hit);
        }
        for config in 0..ROW {
            sorting.starts[config + 1] += sorting.starts[config];
        }
        let end = out.len();
        out.extend_from_slice(&sorting.hits);
        for &hit in &sorting.hits {
            let place = &mut sorting.starts[hit.configuration as usize - self.start];
            out[end + *place] = hit;
            *place += 1;
        }
        self.sorting = sorting;
    }

    /// A pair of the scene as a hit, and its configuration counted from the first.
    pub(super) fn hit(
        &self,
        checker: &BatchChecker<'_, N>,
        Pair { i, j }: Pair,
        verdict: Verdict<N::Answer>,
    ) -> (usize, Hit<N::Answer>) {
        let rows = checker.world.obstacles.len();
        let link = |slot: u32| ((slot as usize - rows) / checker.row) as u32;
        let other = match checker.world.names.get(i as usize) {
            Some(&obstacle) => Other::Obstacle(obstacle),
            None => Other::Link(link(i)),
        };
        let config = self.owners[j as usize - rows] as usize;
        let configuration = (self.start + config) as u32;
        (config, Hit { configuration, link: link(j), other, verdict })
    }
}
