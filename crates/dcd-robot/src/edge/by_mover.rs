//! The pairs with obstacles by what moves: where obstacles are many, a search takes up those alone that come near.

use super::EdgePair;
use super::groups::Groups;
use std::ops::Range;

/// What a search begins with, groups by their numbers behind those of all pairs.
#[derive(Clone, Debug)]
pub(super) struct ByMover {
    /// Groups and pairs in none without an obstacle, in the order of a search.
    pub(super) own: Vec<u32>,
    /// What moves and meets obstacles.
    pub(super) movers: Vec<MeetsObstacles>,
    /// Objects that stand still, each with the group or the pair in none: for each of what moves ascending.
    of_obstacles: Vec<(u32, u32)>,
    /// Obstacles that no sphere holds: near everything.
    pub(super) unbounded: Vec<u32>,
    /// The first obstacle.
    first: u32,
    /// How many pairs there are.
    pairs: u32,
}

/// An object, or a link that carries several, that meets obstacles.
#[derive(Clone, Debug)]
pub(super) struct MeetsObstacles {
    pub(super) object: u32,
    of_obstacles: Range<usize>,
}

impl ByMover {
    /// Of these pairs, with obstacles at those places of the scene, some of which no sphere holds.
    pub(super) fn of(
        (pairs, groups): (&[EdgePair], &Groups),
        obstacles: Range<usize>,
        unbounded: Vec<usize>,
    ) -> Self {
        let first_group = pairs.len() as u32;
        let of_groups = (first_group..).zip(&groups.groups).map(|(open, group)| (open, group.pair));
        let single = groups.single.iter().map(|&pair| (pair, pairs[pair as usize]));
        let (mut own, mut met) = (Vec::new(), Vec::new());
        for (open, pair) in of_groups.chain(single) {
            let [a, b] = pair.objects;
            if obstacles.contains(&(b as usize)) {
                met.push((a, b, open));
            } else {
                own.push(open);
            }
        }
        met.sort_unstable();
        let (mut movers, mut from) = (Vec::new(), 0);
        for of_one in met.chunk_by(|a, b| a.0 == b.0) {
            let of_obstacles = from..from + of_one.len();
            from = of_obstacles.end;
            movers.push(MeetsObstacles { object: of_one[0].0, of_obstacles });
        }
        Self {
            own,
            movers,
            of_obstacles: met.iter().map(|&(_, obstacle, open)| (obstacle, open)).collect(),
            unbounded: unbounded.iter().map(|&object| (object - obstacles.start) as u32).collect(),
            first: obstacles.start as u32,
            pairs: first_group,
        }
    }

    /// How many groups and pairs in none there are with an obstacle.
    pub(super) fn len(&self) -> usize {
        self.of_obstacles.len()
    }

    /// The group or the pair in none of what moves and an obstacle, by its place among these, if they may not touch.
    pub(super) fn get(&self, mover: &MeetsObstacles, obstacle: u32) -> Option<u32> {
        let of_one = &self.of_obstacles[mover.of_obstacles.clone()];
        let object = self.first + obstacle;
        let known = of_one.binary_search_by_key(&object, |&(obstacle, _)| obstacle);
        known.ok().map(|place| of_one[place].1)
    }

    /// Puts groups and pairs in the order of a search, each once: groups first.
    pub(super) fn sort(&self, open: &mut Vec<u32>) {
        open.sort_by_key(|&open| (open < self.pairs, open));
        open.dedup();
    }
}
