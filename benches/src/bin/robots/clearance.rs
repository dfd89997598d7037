//! How near the clearance of a free edge is to what samples find.

use anyhow::{Result, ensure};
use dcd_exec::Par;
use dcd_robot::{EdgeAnswer, EdgeChecker, JointPath, StateChecker};
use serde::{Deserialize, Serialize};

use crate::data::{Setting, on_the_way};
use crate::edges::BUDGET;

/// The least distance below which a ratio says more of rounding than of the search, metres.
pub(crate) const LEAST: f64 = 1e-3;

/// Of free edges.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Outcome {
    pub(crate) samples: usize,
    /// Reported clearances over the least distance of the samples, where that is at least [`LEAST`].
    pub(crate) ratios: Vec<f64>,
    /// Free edges that come nearer than that.
    pub(crate) nearer: usize,
}

/// Of at most so many free edges.
pub(crate) fn run(settings: &[Setting], samples: usize, most: usize) -> Result<Outcome> {
    let mut outcome = Outcome { samples, ..Outcome::default() };
    for setting in settings {
        if outcome.ratios.len() == most {
            break;
        }
        let checker = EdgeChecker::new(setting.cell.clone());
        let found = checker.check(&JointPath::Straight(setting.ends.clone()), BUDGET)?;
        let EdgeAnswer::Free { clearance } = found.answer else { continue };
        let states = StateChecker::new(setting.cell.clone())?;
        let found = states.clearances(&on_the_way(&setting.ends, samples), Par::Pool)?;
        let distances = found.iter().flatten().map(|found| found.proximity.signed_distance);
        let least = distances.fold(f64::INFINITY, f64::min);
        ensure!(clearance <= least, "a clearance of {clearance}, but a sample at {least}");
        if least >= LEAST {
            outcome.ratios.push(clearance / least);
        } else {
            outcome.nearer += 1;
        }
    }
    Ok(outcome)
}
