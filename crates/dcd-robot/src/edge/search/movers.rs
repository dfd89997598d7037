//! What moves and what stands still, where a search has the robot.

use super::super::place::{Local, Twist};
use super::super::reach::Lengths;
use super::super::rows::PlacedRow;
use super::super::{Number, Still};
use super::EdgeSearch;
use dcd_geom::Pose;
use dcd_gjk::PosedShape;
use glam::DVec3;

/// An object that moves.
#[derive(Default)]
pub(super) struct Mover {
    pub(super) lengths: Lengths,
    /// How fast the joints before each turn together at most, and how fast that changes.
    pub(super) before: Vec<[f64; 2]>,
    /// All lengths that go into its coordinates, and how fast its joints turn together, for [`EdgeSearch::slack`].
    pub(super) length: f64,
    pub(super) turns: f64,
    pub(super) deviation: f64,
    /// The node for which the rest is computed.
    pub(super) node: usize,
    pub(super) local: Local,
    pub(super) middle: DVec3,
    pub(super) twist: Twist,
    /// The spheres, and the node that they are of.
    pub(super) cover: PlacedRow,
    pub(super) cover_node: usize,
}

impl EdgeSearch<'_> {
    #[inline]
    pub(super) fn mover(&self, object: u32) -> &Mover {
        match self.checker.number(object) {
            Number::Moves(number) => &self.movers[number],
            Number::Still(_) => &self.still,
        }
    }

    /// That of an object that moves.
    pub(super) fn mover_mut(&mut self, object: u32) -> Option<&mut Mover> {
        match self.checker.number(object) {
            Number::Moves(number) => self.movers.get_mut(number),
            Number::Still(_) => None,
        }
    }

    /// What bounds the rounding of an object's place.
    #[inline]
    pub(super) fn place_of(&self, object: u32) -> Still {
        match self.checker.number(object) {
            Number::Moves(number) => {
                let Mover { length, deviation, .. } = self.movers[number];
                Still { length, deviation }
            }
            Number::Still(number) => self.checker.still[number],
        }
    }

    pub(super) fn pose(&self, object: u32) -> &Pose {
        let i = object as usize;
        match &self.checker.movers[i] {
            Some((part, _)) => &self.at.poses[*part],
            None => &self.checker.cell.scene().poses()[i],
        }
    }

    pub(super) fn posed(&self, object: u32) -> PosedShape<'_> {
        let shape = self.checker.cell.scene().shape(object as usize);
        PosedShape { shape, pose: self.pose(object) }
    }
}
