//! Parry's queries of posed shapes against static obstacles, as a rival.

use crate::forms::{Forms, Placement};
use crate::{Library, Query};
use dcd_exec::{Exec, Segments};
use dcd_geom::{Pose, Scene, SceneError, Shape};
use dcd_gjk::Verdict;
use std::sync::atomic::{AtomicU64, Ordering};

/// How many configurations a task takes.
const CONFIGURATIONS_PER_TASK: usize = 64;

/// Parry's tree over the AABBs of a scene's objects, queried with each link's AABB, and a query for
/// each obstacle that it names. A panic of Parry's is passed on.
pub struct ParryWorld<R: Library> {
    query: Query,
    /// The obstacles, and behind their shapes those of the links.
    scene: Scene,
    forms: Forms<R>,
    /// None in slots that are free.
    obstacles: Vec<Option<Placement<R>>>,
    tree: R::Tree,
    links: std::ops::Range<u32>,
}

/// The poses of a batch as Parry holds them: not part of what it is timed for.
pub struct Posed<R: Library>(Vec<Placement<R>>);

/// A link of a configuration, and the obstacle that Parry says it touches.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Hit {
    /// Which configuration.
    pub configuration: u32,
    /// Which of its links.
    pub link: u32,
    /// The obstacle's index in its scene.
    pub obstacle: u32,
}

/// Whether a link is tested after another of its configuration has touched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Until {
    /// No: a configuration ends with its first hit.
    First,
    /// Yes: every hit is reported.
    Last,
}

impl<R: Library> ParryWorld<R> {
    /// A tree over the objects of a scene, for configurations of these links.
    ///
    /// # Errors
    /// More shapes than a u32 counts.
    pub fn new(scene: &Scene, links: &[Shape], query: Query) -> Result<Self, SceneError> {
        let mut all = scene.clone();
        let links = all.add_shapes(links.iter().cloned())?;
        let forms = Forms::of(&all);
        let placed = |i: usize| scene.handle(i).map(|_| Placement::of(&all, i));
        let obstacles: Vec<_> = (0..scene.len()).map(placed).collect();
        let boxed = |of: &Option<Placement<R>>| of.as_ref().map_or(R::NO_BOX, |of| forms.boxed(of));
        let mut tree = R::Tree::default();
        R::build(obstacles.iter().map(boxed), &mut tree);
        Ok(Self { query, scene: all, forms, obstacles, tree, links })
    }

    /// The links that Parry has no shape for, by index: none of their hits is reported.
    pub fn refused_links(&self) -> impl Iterator<Item = u32> {
        let first = self.links.start;
        self.forms.refused().filter(move |&shape| shape >= first).map(move |shape| shape - first)
    }

    /// The same of the obstacles.
    pub fn refused_obstacles(&self) -> impl Iterator<Item = u32> {
        let is_refused = |of: &Option<Placement<R>>| of.is_some_and(|of| !self.forms.accept(&of));
        (0..).zip(&self.obstacles).filter(move |(_, of)| is_refused(of)).map(|(i, _)| i)
    }

    /// Takes in the poses of configurations, one after the other, one pose a link.
    pub fn place(&self, poses: &[Pose]) -> Posed<R> {
        let links = self.links.clone().cycle();
        let shapes = self.scene.shapes();
        let place = |(shape, pose)| Placement::at(shape, &shapes[shape as usize], pose);
        Posed(links.zip(poses).map(place).collect())
    }

    /// Replaces `hits` by what Parry says, configuration by configuration and link by link. Returns how many of the pairs that it
    /// was asked about it did not answer: these may be hits. It is not asked about [refused](ParryWorld::refused_links) shapes.
    #[must_use = "pairs that are not answered may be hits"]
    pub fn query(
        &self,
        posed: &Posed<R>,
        until: Until,
        exec: Exec,
        hits: &mut Segments<Hit>,
    ) -> u64 {
        let unanswered = AtomicU64::new(0);
        let grain = CONFIGURATIONS_PER_TASK * self.links.len().max(1);
        let batches: Vec<_> = posed.0.chunks(grain).collect();
        hits.fill(exec, batches.len(), |task, hits| {
            let configurations = batches[task].chunks(self.links.len().max(1));
            for (k, links) in configurations.enumerate() {
                let configuration = (task * CONFIGURATIONS_PER_TASK + k) as u32;
                let silent = self.query_one(configuration, links, until, hits);
                unanswered.fetch_add(silent, Ordering::Relaxed);
            }
        });
        unanswered.into_inner()
    }

    /// Returns how many pairs are not answered.
    fn query_one(
        &self,
        configuration: u32,
        links: &[Placement<R>],
        until: Until,
        hits: &mut Vec<Hit>,
    ) -> u64 {
        let mut unanswered = 0;
        for (link, placement) in (0..).zip(links) {
            let mut touched = false;
            R::leaves_near(&self.tree, &self.forms.boxed(placement), |obstacle| {
                let Some(other) = &self.obstacles[obstacle as usize] else { return true };
                match self.forms.verdict(self.query, placement, other) {
                    Verdict::Touching(()) => {
                        hits.push(Hit { configuration, link, obstacle });
                        touched = true;
                    }
                    Verdict::Apart => {}
                    Verdict::Undecided(_) => unanswered += 1,
                }
                !(touched && until == Until::First)
            });
            if touched && until == Until::First {
                return unanswered;
            }
        }
        unanswered
    }
}
