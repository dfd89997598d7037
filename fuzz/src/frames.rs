//! Courses of steps, by the driver that the ordinary tests run on seeds of the moment.

use crate::Input;
use beside_fresh::{Seen, run};
use course::Source;

#[path = "../../crates/dcd-pipeline/tests/all/moving/beside_fresh.rs"]
mod beside_fresh;
#[path = "../../crates/dcd-pipeline/tests/all/moving/course.rs"]
mod course;

impl Source for Input<'_> {
    fn byte(&mut self) -> Option<u8> {
        Input::byte(self)
    }
}

/// Every narrow phase that remembers, and those that only keep what rests, report at each step of any
/// course what a fresh pipeline reports: the same AABBs, candidates and contacts, in the same order.
pub fn frames(bytes: &[u8]) {
    let Seen { steps, contacts, between, remembered } = run(&mut Input(bytes), STEPS);
    assert!(steps > 0 || (contacts, between, remembered) == (0, 0, 0), "something of no step");
}

/// Steps at most; most inputs end before.
const STEPS: usize = 200;
