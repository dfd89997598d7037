//! Decides the pairs that the caller's own culling left.

use super::checker::{Hit, Other};
use super::decisions::{Against, Decisions};
use super::posed_links::PosedLinks;
use super::rows::LinkRows;
use super::set::Set;
use super::{LinkSet, Obstacles, StaticWorld};
use dcd_exec::PerThread;
use dcd_geom::{Pose, SceneError};
use dcd_gjk::NarrowPhase;

/// A link of a configuration, and what it may touch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Candidate {
    /// Which configuration, of those that are decided together.
    pub configuration: u32,
    /// Which of its links.
    pub link: u32,
    /// An obstacle, or a link of smaller index.
    pub other: Other,
}

/// Decides pairs of links with obstacles and with each other for a caller that does its own culling: what
/// a [`BatchChecker`](super::BatchChecker) does after culling. The link set's own
/// filters and pairs are ignored.
pub struct PairDecider<N: NarrowPhase = dcd_gjk::Overlap> {
    rows: LinkRows,
    scratch: PerThread<Scratch<N>>,
}

struct Scratch<N: NarrowPhase> {
    due: Vec<Set>,
    posed: PosedLinks<N>,
    decisions: Decisions<N>,
}

impl<N: NarrowPhase> Default for Scratch<N> {
    fn default() -> Self {
        let (due, posed, decisions) = (Vec::new(), PosedLinks::default(), Decisions::default());
        Self { due, posed, decisions }
    }
}

impl<N: NarrowPhase> std::fmt::Debug for PairDecider<N> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("PairDecider").field("links", &self.rows.link_set).finish_non_exhaustive()
    }
}

impl<N: NarrowPhase> PairDecider<N> {
    /// A decider for so many configurations at once, at most 512.
    ///
    /// # Errors
    /// Those of [`StaticWorld::checker`].
    pub fn new(link_set: LinkSet, configurations: usize) -> Result<Self, SceneError> {
        let rows = LinkRows::new(link_set, configurations)?;
        Ok(Self { rows, scratch: PerThread::default() })
    }

    /// Reports what is not proved apart: contacts with obstacles, then of links, then the undecided pairs.
    /// `pose(configuration, link)` is called once for each configuration and link that a candidate names.
    ///
    /// # Errors
    /// More objects than a u32 counts; a candidate of a configuration, a link or an obstacle that is not
    /// there, by its link; a pose out of range, by configuration · links + link: nothing is reported then.
    pub fn decide(
        &self,
        StaticWorld(world): &StaticWorld<N>,
        candidates: &[Candidate],
        pose: impl FnMut(usize, usize) -> Pose,
        hits: impl FnMut(Hit<N::Answer>),
    ) -> Result<(), SceneError> {
        self.rows.check_count(world)?;
        let sides = (&**world, &self.rows);
        self.scratch.with(|scratch| scratch.decide(sides, candidates, pose, hits))
    }
}

impl<N: NarrowPhase> Scratch<N> {
    fn decide(
        &mut self,
        (world, rows): (&Obstacles<N>, &LinkRows),
        candidates: &[Candidate],
        pose: impl FnMut(usize, usize) -> Pose,
        mut hits: impl FnMut(Hit<N::Answer>),
    ) -> Result<(), SceneError> {
        let links = rows.link_set.len();
        self.posed.clear(world, rows);
        self.due.clear();
        self.due.resize(links, Set::default());
        for candidate in candidates {
            let configuration = candidate.configuration as usize;
            let is_there = candidate.other_is_there(world) && configuration < rows.row;
            let Some(due) = self.due.get_mut(candidate.link as usize).filter(|_| is_there) else {
                let object = candidate.link as usize;
                return Err(SceneError::NoSuchObject { object, objects: links });
            };
            due.add(configuration);
            if let Other::Link(other) = candidate.other {
                self.due[other as usize].add(configuration);
            }
        }
        if let Some((_, error)) = self.posed.place(&world.narrow, rows, &self.due, pose) {
            return Err(error);
        }
        self.list(world, candidates);
        self.decisions.decide(world, &self.posed);
        for (against, pair, verdict) in self.decisions.hits() {
            let link = |object: u32| (object as usize / rows.row) as u32;
            let other = match against {
                Against::Obstacles => Other::Obstacle(world.names[pair.i as usize]),
                Against::Links => Other::Link(link(pair.i)),
            };
            let configuration = self.posed.configuration(pair.j) as u32;
            hits(Hit { configuration, link: link(pair.j), other, verdict });
        }
        Ok(())
    }

    /// Lists the candidates whose AABBs overlap.
    fn list(&mut self, world: &Obstacles<N>, candidates: &[Candidate]) {
        let Self { posed, decisions, .. } = self;
        decisions.clear();
        for &Candidate { configuration, link, other } in candidates {
            let configuration = configuration as usize;
            match other {
                Other::Obstacle(name) => {
                    let pair = number_of(world, name).and_then(|obstacle| {
                        posed.obstacle_pair(world, configuration, (link as usize, obstacle))
                    });
                    decisions.pairs_mut(Against::Obstacles).extend(pair);
                }
                Other::Link(other) => {
                    let pair = posed.self_pair(configuration, (other, link));
                    decisions.pairs_mut(Against::Links).extend(pair);
                }
            }
        }
    }
}

impl Candidate {
    fn other_is_there<N: NarrowPhase>(&self, world: &Obstacles<N>) -> bool {
        match self.other {
            Other::Obstacle(name) => number_of(world, name).is_some(),
            Other::Link(other) => other < self.link,
        }
    }
}

/// The obstacle with that index in the scene that the world was made from.
fn number_of<N: NarrowPhase>(world: &Obstacles<N>, name: u32) -> Option<usize> {
    match world.names.get(name as usize) {
        Some(&same) if same == name => Some(name as usize),
        _ => world.names.binary_search(&name).ok(),
    }
}
