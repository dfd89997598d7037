//! Links at poses, prepared for the narrow phase.

use super::Obstacles;
use super::checker::BatchChecker;
use super::culling::Culling;
use super::rows::{LinkRows, numbered};
use super::set::{Members, ROW, Set};
use crate::moving_ranges::for_each_range;
use dcd_broad::IdentifiedAabbs;
use dcd_geom::{Aabb, Pair, Pose, Scene, SceneError};
use dcd_gjk::{NarrowPhase, Prepared, Sides};
use std::ops::Range;

/// A scene of a row of objects for each link, prepared again and again.
///
/// Links that are near something take the objects of their row one after the other, so that what is
/// prepared lies without gaps; the rest of a row stays as it was.
pub(super) struct PosedLinks<N: NarrowPhase> {
    scene: Scene,
    frame: N::Frame,
    aabbs: Vec<Aabb>,
    /// For each link the configurations of which it is posed.
    posed: Vec<Set>,
    /// For each object the configuration that it stands for.
    configurations: Vec<u32>,
    /// For each link and configuration the object that stands for it, where it is posed.
    objects: Vec<[u32; ROW]>,
    /// For each link the objects that were posed last.
    fresh: Vec<Range<usize>>,
    /// The number of an object in queries of the tree, counted on from those of the obstacles.
    names: Vec<u32>,
}

impl<N: NarrowPhase> Default for PosedLinks<N> {
    fn default() -> Self {
        Self {
            scene: Scene::default(),
            frame: N::Frame::default(),
            aabbs: Vec::new(),
            posed: Vec::new(),
            configurations: Vec::new(),
            objects: Vec::new(),
            fresh: Vec::new(),
            names: Vec::new(),
        }
    }
}

impl<N: NarrowPhase> PosedLinks<N> {
    /// Reserves memory, the first time and when more is needed, and forgets all poses.
    pub(super) fn clear(&mut self, world: &Obstacles<N>, rows: &LinkRows) {
        let (template, links) = (&rows.template, rows.link_set.len());
        if self.scene.layout() != template.layout() {
            self.scene = template.clone();
            self.aabbs.resize(template.len(), Aabb::EMPTY);
            self.configurations.resize(template.len(), 0);
            self.objects.resize(links, [0; ROW]);
        }
        self.posed.clear();
        self.posed.resize(links, Set::default());
        self.fresh.clear();
        self.fresh.resize(links, 0..0);
        let first = world.len() as u32;
        if self.names.len() != template.len() || self.names.first() != Some(&first) {
            self.names.clear();
            self.names.extend((first..).take(template.len()));
        }
    }

    pub(super) fn prepared(&self) -> Prepared<'_, N::Frame> {
        Prepared { scene: &self.scene, frame: &self.frame }
    }

    /// The objects of a link that were posed last.
    pub(super) fn fresh(&self, link: usize) -> Range<usize> {
        self.fresh[link].clone()
    }

    /// The configuration that an object stands for.
    pub(super) fn configuration(&self, object: u32) -> usize {
        self.configurations[object as usize] as usize
    }

    /// Poses and prepares what is due and not yet posed, at `pose(configuration, link)`, which is called once for
    /// each. Returns the first refused pose, configuration by configuration: its number, and the error, which numbers
    /// it too.
    pub(super) fn place(
        &mut self,
        narrow: &N,
        rows: &LinkRows,
        due: &[Set],
        mut pose: impl FnMut(usize, usize) -> Pose,
    ) -> Option<(usize, SceneError)> {
        let links = rows.link_set.len();
        let mut refused: Option<(usize, SceneError)> = None;
        for (link, &due) in due.iter().enumerate() {
            let due = due & !self.posed[link];
            // Of a state alone few links are: counting the others' members would cost as much as posing one.
            if due.is_empty() {
                self.fresh[link] = 0..0;
                continue;
            }
            let first = rows.row * link + self.posed[link].len();
            let mut object = first;
            for config in Members::of(due) {
                if let Err(error) = self.scene.set_pose(object, pose(config, link)) {
                    let number = config * links + link;
                    if refused.is_none_or(|(first, _)| number < first) {
                        refused = Some((number, numbered(error, number)));
                    }
                    continue;
                }
                self.posed[link].add(config);
                self.configurations[object] = config as u32;
                self.objects[link][config] = object as u32;
                object += 1;
            }
            self.fresh[link] = first..object;
        }
        self.prepare(narrow);
        refused
    }

    /// Prepares what was posed last; everything, where the frame has not kept the rest.
    fn prepare(&mut self, narrow: &N) {
        let Self { scene, frame, aabbs, fresh, .. } = self;
        let part = narrow.layout(scene, Sides::Two, frame);
        if !narrow.keeps(&part) {
            return narrow.prepare(scene, 0, part, aabbs);
        }
        let new = fresh.iter().filter(|new| !new.is_empty()).cloned();
        for_each_range((part, &mut aabbs[..]), 0, new, |new, (part, aabbs)| {
            narrow.prepare(scene, new.start, part, aabbs);
        });
    }

    /// Appends the pairs of an obstacle and an object of a link, where it was posed last: object by object,
    /// the obstacles ascending.
    pub(super) fn append_pairs(
        &self,
        checker: &BatchChecker<N>,
        culling: &Culling,
        link: usize,
        pairs: &mut Vec<Pair>,
    ) {
        if checker.filtered {
            self.query(checker, culling, link, |i| checker.allows(link, i), pairs);
        } else {
            self.query(checker, culling, link, |_| true, pairs);
        }
    }

    fn query(
        &self,
        checker: &BatchChecker<N>,
        culling: &Culling,
        link: usize,
        keep: impl Fn(u32) -> bool,
        pairs: &mut Vec<Pair>,
    ) {
        let new = self.fresh(link);
        // The first object whose tree query is pending: what it may reach is not known.
        let mut unknown = new.start;
        for object in new.clone() {
            let config = self.configurations[object] as usize;
            if let Some(numbers) = culling.obstacles(link, config) {
                self.query_tree(checker, unknown..object, &keep, pairs);
                unknown = object + 1;
                let query = (object as u32, &self.aabbs[object]);
                checker.obstacle_grid.append_pairs(query, numbers, &keep, pairs);
            }
        }
        self.query_tree(checker, unknown..new.end, &keep, pairs);
    }

    /// Appends the pairs of some objects as the tree has them.
    fn query_tree(
        &self,
        checker: &BatchChecker<N>,
        objects: Range<usize>,
        keep: impl Fn(u32) -> bool,
        pairs: &mut Vec<Pair>,
    ) {
        if objects.is_empty() {
            return;
        }
        let start = pairs.len();
        let (aabbs, names) = (&self.aabbs[objects.clone()], &self.names[objects]);
        let query = IdentifiedAabbs { aabbs, names };
        checker.world.search().tree.append_pairs(query, |i, _| keep(i), pairs);
        let new = &mut pairs[start..];
        let obstacles = checker.world.len() as u32;
        new.iter_mut().for_each(|pair| pair.j -= obstacles);
        // One query per object, so that short lists are left to be sorted.
        let lists = new.chunk_by_mut(|a, b| a.j == b.j);
        lists.for_each(|list| list.sort_unstable_by_key(|pair| pair.i));
    }

    /// An obstacle and the object of a link in a configuration, if their AABBs overlap.
    pub(super) fn obstacle_pair(
        &self,
        world: &Obstacles<N>,
        config: usize,
        (link, obstacle): (usize, usize),
    ) -> Option<Pair> {
        let j = self.posed[link].has(config).then(|| self.objects[link][config])?;
        let aabb = world.aabbs.get(obstacle)?;
        aabb.overlaps(&self.aabbs[j as usize]).then_some(Pair { i: obstacle as u32, j })
    }

    /// The objects of two links of one configuration, if their AABBs overlap.
    pub(super) fn self_pair(&self, config: usize, links: (u32, u32)) -> Option<Pair> {
        let links = [links.0, links.1].map(|link| link as usize);
        // A refused pose has no object.
        if links.iter().any(|&link| !self.posed[link].has(config)) {
            return None;
        }
        let [k, l] = links.map(|link| self.objects[link][config]);
        let overlap = self.aabbs[k as usize].overlaps(&self.aabbs[l as usize]);
        overlap.then(|| Pair::new(k, l))
    }
}
