//! The states of a packet, and where their links are: in f32 for the lanes, as [`Robot::place`](crate::Robot::place)
//! has them where pairs are decided.

use super::alone::LinkRow;
use super::chain::Drives;
use super::link_frames::{LinkFrames, PlaceFrames};
use super::links::LinkSpheres;
use super::prepared::Prepared;
use super::rounded_links::{Placed, Rounded, bits};
use super::sift::is_alone;
use super::worker::RefusedState;
use dcd_simd::{Kernel, Lanes, Path, WIDTH, dispatch_on};

/// Up to how many states are placed one by one; more are placed together, in all lanes. No effect on any answer.
const FEW: u32 = 4;

/// At most sixteen states.
#[derive(Clone, Debug, Default)]
pub(super) struct Places {
    drives: Drives,
    /// The states whose links the lanes take from `frames`.
    uncovered: u32,
    /// Where the links are of the states of which a bit of `known` is set.
    pub(super) frames: LinkFrames,
    known: u32,
}

impl Places {
    /// Takes states up; refuses one by its lane.
    pub(super) fn read(
        &mut self,
        prepared: &Prepared,
        states: &[&[f64]],
    ) -> Result<(), RefusedState> {
        let robot = prepared.robot();
        self.uncovered = prepared.chain.read(robot, states, &mut self.drives);
        self.known = self.uncovered;
        for lane in bits(self.uncovered) {
            let state = states[lane];
            robot.check_state(state).map_err(|error| (lane, error))?;
            self.frames.place_alone(robot, state, lane);
            // Refused even where no pair contains the link.
            if !self.frames.is_finite(lane) {
                robot.place(state, &mut Vec::new()).map_err(|error| (lane, error))?;
            }
        }
        Ok(())
    }

    /// Takes up states that the bounds of f32 cover, to be read where they are placed.
    pub(super) fn take_covered(&mut self) {
        (self.uncovered, self.known) = (0, 0);
    }

    /// Whether the bounds of f32 hold for a state: then no link of it is out of range.
    pub(super) fn covers(&self, lane: usize) -> bool {
        self.uncovered >> lane & 1 == 0
    }

    /// What says where the links are in f32.
    pub(super) fn placed<'a>(&'a self, prepared: &'a Prepared) -> Placed<'a> {
        let Self { drives, uncovered, frames, .. } = self;
        Placed { chain: &prepared.chain, drives, exact: *uncovered, frames }
    }

    /// Finds the frames of some of the states that were taken up.
    pub(super) fn place_exactly(&mut self, prepared: &Prepared, states: &[&[f64]], lanes: u32) {
        let (robot, wanted) = (prepared.robot(), lanes & !self.known);
        if wanted.count_ones() > FEW {
            self.frames.read(robot, states);
            dispatch_on(Path::best(), PlaceFrames { robot, states, to: &mut self.frames });
            self.known = (1 << WIDTH) - 1;
            return;
        }
        for lane in bits(wanted) {
            self.frames.place_alone(robot, states[lane], lane);
        }
        self.known |= wanted;
    }
}

/// Finds where links and their spheres are, and nothing else.
pub(super) struct PlaceLinks<'a> {
    pub(super) placed: Placed<'a>,
    /// The states that there are, a bit each.
    pub(super) open: u32,
    pub(super) links: &'a [LinkSpheres],
    /// The same, sixteen to a row.
    pub(super) rows: &'a [LinkRow],
    pub(super) to: &'a mut Rounded,
}

impl Kernel for PlaceLinks<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        let Self { placed, open, links, rows, to } = self;
        if is_alone(open) {
            let lane = open.trailing_zeros() as usize;
            placed.place_alone(l, (links, rows, lane), &mut to.one);
        } else {
            placed.place(l, links, &mut to.world);
        }
    }
}
