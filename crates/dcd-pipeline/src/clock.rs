//! The time of each stage, for callers who want it.

use dcd_exec::{Observer, Stage};
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Times the stages of the steps that it observes. Not for use by two pipelines at once.
#[derive(Debug, Default)]
pub struct StageClock(Mutex<Times>);

#[derive(Debug, Default)]
struct Times {
    begun: Option<Instant>,
    spent: [Duration; Stage::ALL.len()],
}

impl StageClock {
    /// The time spent in each stage since the last call, in the order of [`Stage::ALL`].
    pub fn take(&self) -> [Duration; Stage::ALL.len()] {
        self.with(|times| std::mem::take(&mut times.spent))
    }

    fn with<T>(&self, work: impl FnOnce(&mut Times) -> T) -> T {
        // A panic elsewhere leaves valid times.
        work(&mut self.0.lock().unwrap_or_else(|poisoned| poisoned.into_inner()))
    }
}

impl Observer for StageClock {
    fn stage_begins(&self, _: Stage) {
        self.with(|times| times.begun = Some(Instant::now()));
    }

    fn stage_ends(&self, stage: Stage) {
        let now = Instant::now();
        self.with(|times| {
            if let Some(begun) = times.begun.take() {
                times.spent[stage as usize] += now - begun;
            }
        });
    }
}
