//! A thread's work on a few configurations.

use super::probe::{Finding, Other, Probe};
use dcd_broad::Named;
use dcd_geom::{Aabb, Divide, Pair, Pose, Scene};
use dcd_gjk::{Contact, Findings, NarrowPhase, Report, Verdict};
use std::ops::Range;

/// How many configurations are worked on at once, and objects a row has: enough for full lanes
/// when a few links are asked for, few enough for their vertices to stay near.
pub(super) const ROW: usize = 64;

/// A scene of the obstacles and of a row of objects for each link, made ready again and again:
/// only the rows change.
pub(super) struct Desk<N: NarrowPhase> {
    scene: Scene,
    frame: N::Frame,
    aabbs: Vec<Aabb>,
    /// 0, 1, 2, …: what the boxes of the rows are called.
    names: Vec<u32>,
    scratch: N::Scratch,
    /// The first configuration, by its number in the batch.
    start: usize,
    /// The configurations that are still asked for, counted from the first.
    open: Vec<u32>,
    /// For each object of the rows the configuration that it stands for.
    owners: Vec<u32>,
    /// For each link of each configuration the object that stood for it.
    slots: Vec<u32>,
    pairs: Vec<Pair>,
    contacts: Vec<Contact<N::Answer>>,
    report: Report,
    sorting: Sorting<N::Answer>,
}

impl<N: NarrowPhase> Default for Desk<N> {
    fn default() -> Self {
        Self {
            scene: Scene::default(),
            frame: N::Frame::default(),
            aabbs: Vec::new(),
            names: Vec::new(),
            scratch: N::Scratch::default(),
            start: 0,
            open: Vec::new(),
            owners: Vec::new(),
            slots: Vec::new(),
            pairs: Vec::new(),
            contacts: Vec::new(),
            report: Report::default(),
            sorting: Sorting::default(),
        }
    }
}

/// Findings to be put in the order of their configurations.
struct Sorting<A> {
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
    /// Takes up configurations, at most a row; prepares the obstacles the first time.
    pub(super) fn open(&mut self, probe: &Probe<'_, N>, start: usize, count: usize) {
        let template = &probe.template;
        if self.scene.layout() != template.layout() {
            self.scene = template.clone();
            self.aabbs.resize(template.len(), Aabb::EMPTY);
            self.names.extend((0..).take(template.len()));
            self.owners.resize(ROW * probe.linkage.len(), 0);
            self.slots.resize(ROW * probe.linkage.len(), 0);
            let part = probe.world.narrow.lay_out(&self.scene, &mut self.frame);
            let ((part, aabbs), _) =
                (part, &mut self.aabbs[..]).split_at(probe.world.obstacles.len());
            probe.world.narrow.prepare(&self.scene, 0, part, aabbs);
        }
        self.start = start;
        self.open.clear();
        self.open.extend(0..count as u32);
    }

    /// Poses and prepares some links of the open configurations. The index of the first pose that
    /// was refused, if any.
    pub(super) fn place(
        &mut self,
        probe: &Probe<'_, N>,
        links: &Range<usize>,
        poses: &[Pose],
    ) -> Option<usize> {
        let (rows, count) = (probe.world.obstacles.len(), probe.linkage.len());
        let mut refused: Option<usize> = None;
        for link in links.clone() {
            for (place, &own) in self.open.iter().enumerate() {
                let slot = rows + ROW * link + place;
                let pose = (self.start + own as usize) * count + link;
                if self.scene.set_pose(slot, poses[pose]).is_err() {
                    refused = Some(refused.map_or(pose, |first| first.min(pose)));
                }
                self.owners[slot - rows] = own;
                self.slots[own as usize * count + link] = slot as u32;
            }
        }
        let part = probe.world.narrow.lay_out(&self.scene, &mut self.frame);
        let mut first = rows + ROW * links.start;
        let (_, mut rest) = (part, &mut self.aabbs[..]).split_at(first);
        for _ in links.clone() {
            let (row, others) = rest.split_at(ROW);
            let ((part, aabbs), _) = row.split_at(self.open.len());
            probe.world.narrow.prepare(&self.scene, first, part, aabbs);
            (first, rest) = (first + ROW, others);
        }
        refused
    }

    /// Finds and settles the pairs of these links of the open configurations: with the obstacles,
    /// link by link, then with the links before.
    pub(super) fn decide(&mut self, probe: &Probe<'_, N>, links: &Range<usize>) {
        let Self { scene, frame, aabbs, names, scratch, open, pairs, contacts, report, .. } = self;
        pairs.clear();
        for link in links.clone() {
            let first = probe.world.obstacles.len() + ROW * link;
            let row = first..first + open.len();
            let asked = Named { aabbs: &aabbs[row.clone()], names: &names[row] };
            if scene.filters_movers() {
                probe.world.tree.append_pairs(asked, |i, j| scene.allows(i, j), pairs);
            } else {
                probe.world.tree.append_pairs(asked, |_, _| true, pairs);
            }
        }
        let count = probe.linkage.len();
        let own_pairs = &probe.linkage.own_pairs;
        let own_pairs = own_pairs.iter().filter(|(_, l)| links.contains(&(*l as usize)));
        for &(k, l) in own_pairs {
            for &own in &*open {
                let slot = |link: u32| self.slots[own as usize * count + link as usize];
                let (k, l) = (slot(k), slot(l));
                if aabbs[k as usize].overlaps(&aabbs[l as usize]) {
                    pairs.push(Pair::new(k, l));
                }
            }
        }
        contacts.clear();
        report.clear();
        let mut findings = Findings { contacts, report };
        probe.world.narrow.decide(scene, frame, pairs, scratch, &mut findings);
        report.sort();
    }

    /// Writes the first finding of each open configuration, and closes those that touch.
    pub(super) fn keep_first(
        &mut self,
        probe: &Probe<'_, N>,
        found: &mut [Option<Finding<N::Answer>>],
    ) {
        for contact in &self.contacts {
            let verdict = Verdict::Touching(contact.answer);
            let (own, finding) = self.finding(probe, contact.pair, verdict);
            let place = |finding: &Finding<_>| (finding.link, finding.other);
            let known = found[own].as_ref().filter(|known| known.touches());
            if known.is_none_or(|known| place(&finding) < place(known)) {
                found[own] = Some(finding);
            }
        }
        for undecided in self.report.undecided() {
            let verdict = Verdict::Undecided(undecided.reason);
            let (own, finding) = self.finding(probe, undecided.pair, verdict);
            found[own].get_or_insert(finding);
        }
        self.open.retain(|&own| !found[own as usize].as_ref().is_some_and(Finding::touches));
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
    fn finding(
        &self,
        probe: &Probe<'_, N>,
        Pair { i, j }: Pair,
        verdict: Verdict<N::Answer>,
    ) -> (usize, Finding<N::Answer>) {
        let rows = probe.world.obstacles.len();
        let link = |slot: u32| ((slot as usize - rows) / ROW) as u32;
        let other = match probe.world.names.get(i as usize) {
            Some(&obstacle) => Other::Obstacle(obstacle),
            None => Other::Link(link(i)),
        };
        let own = self.owners[j as usize - rows] as usize;
        let configuration = (self.start + own) as u32;
        (own, Finding { configuration, link: link(j), other, verdict })
    }
}
