//! A thread's work on a few configurations.

use super::World;
use super::first::Search;
use super::outlook::Outlook;
use super::probe::{Finding, Other, Probe};
use super::set::{Members, ROW, Set};
use dcd_broad::Named;
use dcd_geom::{Aabb, Divide, Pair, Pose, Scene};
use dcd_gjk::{Contact, Findings, NarrowPhase, Report, Verdict};
use std::ops::Range;

/// A scene of the obstacles and of a row of objects for each link, made ready again and again.
///
/// Links that are near something take the objects of their row one after the other, so that what is
/// prepared lies without gaps; the rest of a row stays as it was.
pub(super) struct Desk<N: NarrowPhase> {
    scene: Scene,
    frame: N::Frame,
    pub(super) aabbs: Vec<Aabb>,
    /// 0, 1, 2, …: what the boxes of the rows are called.
    names: Vec<u32>,
    scratch: N::Scratch,
    pub(super) outlook: Outlook,
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
    pub(super) search: Search,
    pub(super) sorting: Sorting<N::Answer>,
}

impl<N: NarrowPhase> Default for Desk<N> {
    fn default() -> Self {
        Self {
            scene: Scene::default(),
            frame: N::Frame::default(),
            aabbs: Vec::new(),
            names: Vec::new(),
            scratch: N::Scratch::default(),
            outlook: Outlook::default(),
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
            search: Search::default(),
            sorting: Sorting::default(),
        }
    }
}

/// Findings to be put in the order of their configurations.
pub(super) struct Sorting<A> {
    findings: Vec<Finding<A>>,
    /// Where those of each configuration begin.
    starts: [usize; ROW + 1],
}

impl<A> Default for Sorting<A> {
    fn default() -> Self {
        Self { findings: Vec::new(), starts: [0; ROW + 1] }
    }
}

impl<N: NarrowPhase> Desk<N> {
    /// Makes room and prepares the obstacles, the first time and when there is need of more.
    pub(super) fn set_up(&mut self, probe: &Probe<'_, N>) {
        let (template, links) = (&probe.template, probe.linkage.len());
        if self.scene.layout() == template.layout() {
            return;
        }
        self.scene = template.clone();
        self.aabbs.resize(template.len(), Aabb::EMPTY);
        self.names.clear();
        self.names.extend((0..).take(template.len()));
        self.owners.resize(probe.row * links, 0);
        self.slots.resize(links, [0; ROW]);
        let part = probe.world.narrow.lay_out(&self.scene, &mut self.frame);
        let ((part, aabbs), _) = (part, &mut self.aabbs[..]).split_at(probe.world.obstacles.len());
        probe.world.narrow.prepare(&self.scene, 0, part, aabbs);
    }

    /// Takes up so many configurations, at most a row.
    pub(super) fn open(&mut self, probe: &Probe<'_, N>, start: usize, count: usize) {
        self.set_up(probe);
        let links = probe.linkage.len();
        for sets in [&mut self.due, &mut self.posed] {
            sets.clear();
            sets.resize(links, Set::default());
        }
        (self.start, self.count) = (start, count);
    }

    /// All pairs of the configurations taken up, settled. The index of the first pose that was
    /// refused, if any.
    pub(super) fn settle_all(&mut self, probe: &Probe<'_, N>, poses: &[Pose]) -> Option<usize> {
        let links = probe.linkage.len();
        let row = (&poses[self.start * links..], self.count);
        self.open = self.outlook.look(probe, row, |_, _, _| false);
        for (link, due) in self.due.iter_mut().enumerate() {
            *due = self.outlook.near(link);
        }
        for (pair, &(k, l)) in probe.linkage.own_pairs.iter().enumerate() {
            self.due[k as usize] |= self.outlook.met(pair);
            self.due[l as usize] |= self.outlook.met(pair);
        }
        let refused = self.place(probe, poses);
        self.pairs.clear();
        for link in 0..links {
            self.append_pairs(probe, link);
        }
        for (pair, &(k, l)) in probe.linkage.own_pairs.iter().enumerate() {
            for own in Members::of(self.outlook.met(pair)) {
                let met = self.own_pair(own, [k, l]);
                self.pairs.extend(met);
            }
        }
        self.decide(probe);
        refused
    }

    /// Poses and prepares what is due and not yet posed. The index of the first pose that was
    /// refused.
    pub(super) fn place(&mut self, probe: &Probe<'_, N>, poses: &[Pose]) -> Option<usize> {
        let (rows, count) = (probe.world.obstacles.len(), probe.linkage.len());
        let mut refused: Option<usize> = None;
        self.fresh.clear();
        for link in 0..count {
            let first = probe.row_of(link) + self.posed[link].len();
            let mut slot = first;
            for own in Members::of(self.due[link] & !self.posed[link]) {
                let pose = (self.start + own) * count + link;
                if self.scene.set_pose(slot, poses[pose]).is_err() {
                    refused = Some(refused.map_or(pose, |first| first.min(pose)));
                    continue;
                }
                self.posed[link].add(own);
                self.owners[slot - rows] = own as u32;
                self.slots[link][own] = slot as u32;
                slot += 1;
            }
            self.fresh.push(first..slot);
        }
        self.prepare(probe);
        refused
    }

    /// Prepares what was posed last; everything, where the frame has not kept the rest.
    fn prepare(&mut self, probe: &Probe<'_, N>) {
        let Self { scene, frame, aabbs, fresh, .. } = self;
        let part = probe.world.narrow.lay_out(scene, frame);
        if !probe.world.narrow.keeps(&part) {
            return probe.world.narrow.prepare(scene, 0, part, aabbs);
        }
        let mut rest = (part, &mut aabbs[..]);
        let mut start = 0;
        for new in fresh.iter().filter(|new| !new.is_empty()) {
            let (_, others) = rest.split_at(new.start - start);
            let ((part, aabbs), others) = others.split_at(new.len());
            probe.world.narrow.prepare(scene, new.start, part, aabbs);
            (rest, start) = (others, new.end);
        }
    }

    /// Appends the pairs of a link, where it was posed last, with the obstacles: object by object, the
    /// obstacles ascending.
    pub(super) fn append_pairs(&mut self, probe: &Probe<'_, N>, link: usize) {
        let mut pairs = std::mem::take(&mut self.pairs);
        if self.scene.filters_movers() {
            self.ask(probe, link, |i, j| self.scene.allows(i, j), &mut pairs);
        } else {
            self.ask(probe, link, |_, _| true, &mut pairs);
        }
        self.pairs = pairs;
    }

    fn ask(
        &self,
        probe: &Probe<'_, N>,
        link: usize,
        keep: impl Fn(u32, u32) -> bool,
        pairs: &mut Vec<Pair>,
    ) {
        let Self { aabbs, names, owners, .. } = self;
        let (World { tree, obstacles, .. }, new) = (probe.world, self.fresh[link].clone());
        let ask_tree = |slots: Range<usize>, pairs: &mut Vec<Pair>| {
            if !slots.is_empty() {
                let start = pairs.len();
                let asked = Named { aabbs: &aabbs[slots.clone()], names: &names[slots] };
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
            let own = owners[slot - obstacles.len()] as usize;
            if let Some(numbers) = self.outlook.obstacles(link, own) {
                ask_tree(unknown..slot, pairs);
                unknown = slot + 1;
                probe.vicinity.append_pairs((names[slot], &aabbs[slot]), numbers, &keep, pairs);
            }
        }
        ask_tree(unknown..new.end, pairs);
    }

    /// The pair of two links of one configuration, if their boxes overlap.
    pub(super) fn own_pair(&self, own: usize, links: [u32; 2]) -> Option<Pair> {
        let links = links.map(|link| link as usize);
        // Of a pose that was refused there is no object.
        if links.iter().any(|&link| !self.posed[link].has(own)) {
            return None;
        }
        let [k, l] = links.map(|link| self.slots[link][own]);
        let overlap = self.aabbs[k as usize].overlaps(&self.aabbs[l as usize]);
        overlap.then(|| Pair::new(k, l))
    }

    /// Settles the pairs.
    pub(super) fn decide(&mut self, probe: &Probe<'_, N>) {
        let Self { scene, frame, scratch, pairs, contacts, report, .. } = self;
        contacts.clear();
        report.clear();
        let mut findings = Findings { contacts, report };
        probe.world.narrow.decide(scene, frame, pairs, scratch, &mut findings);
        report.sort();
    }

    /// Appends all findings, configuration by configuration.
    pub(super) fn append_all(&mut self, probe: &Probe<'_, N>, out: &mut Vec<Finding<N::Answer>>) {
        let mut sorting = std::mem::take(&mut self.sorting);
        let touching = self.contacts.iter().map(|c| (c.pair, Verdict::Touching(c.answer)));
        let undecided = self.report.undecided().iter();
        let undecided = undecided.map(|u| (u.pair, Verdict::Undecided(u.reason)));
        sorting.findings.clear();
        sorting.starts = [0; ROW + 1];
        for (pair, verdict) in touching.chain(undecided) {
            let (own, finding) = self.finding(probe, pair, verdict);
            sorting.starts[own + 1] += 1;
            sorting.findings.push(finding);
        }
        for own in 0..ROW {
            sorting.starts[own + 1] += sorting.starts[own];
        }
        let end = out.len();
        out.extend_from_slice(&sorting.findings);
        for &finding in &sorting.findings {
            let place = &mut sorting.starts[finding.configuration as usize - self.start];
            out[end + *place] = finding;
            *place += 1;
        }
        self.sorting = sorting;
    }

    /// A pair of the scene as a finding, and its configuration counted from the first.
    pub(super) fn finding(
        &self,
        probe: &Probe<'_, N>,
        Pair { i, j }: Pair,
        verdict: Verdict<N::Answer>,
    ) -> (usize, Finding<N::Answer>) {
        let rows = probe.world.obstacles.len();
        let link = |slot: u32| ((slot as usize - rows) / probe.row) as u32;
        let other = match probe.world.names.get(i as usize) {
            Some(&obstacle) => Other::Obstacle(obstacle),
            None => Other::Link(link(i)),
        };
        let own = self.owners[j as usize - rows] as usize;
        let configuration = (self.start + own) as u32;
        (own, Finding { configuration, link: link(j), other, verdict })
    }
}
