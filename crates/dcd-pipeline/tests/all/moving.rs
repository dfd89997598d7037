//! Moving scenes with static objects, on fresh seeds: whatever a pipeline has seen, a step reports what a
//! fresh one reports, in the same order.
//!
//! `DCD_STEPS=100000 cargo test -p dcd-pipeline --test all moving` runs so many steps;
//! `DCD_SEED=…` repeats what a failure has printed.

mod beside_fresh;
mod course;

use beside_fresh::{Seen, run};
use course::Seeded;
use std::hash::{BuildHasher, RandomState};

/// Some seconds of steps.
const STEPS: usize = 2500;

/// Steps of a course: enough for most to have one look at everything; every eighth goes on until the
/// ways of what is small and moves are worn.
const COURSE: [usize; 8] = [100, 150, 200, 100, 150, 200, 100, 1500];

/// A number from the environment.
fn environment(name: &str) -> Option<u64> {
    let value = std::env::var(name).ok()?;
    Some(value.parse().unwrap_or_else(|_| panic!("{name} is not a number: {value:?}")))
}

#[test]
fn whatever_has_moved_before_a_step_reports_what_a_fresh_pipeline_reports_in_the_same_order() {
    let seed = environment("DCD_SEED").unwrap_or_else(|| RandomState::new().hash_one("moving"));
    let steps = environment("DCD_STEPS").map_or(STEPS, |steps| steps as usize);
    let mut all = Seen::default();
    for course in 0.. {
        if all.steps >= steps {
            break;
        }
        let own = seed.wrapping_add(course);
        // Shown where the test fails.
        println!("DCD_SEED={own} DCD_STEPS=1");
        let seen = run(&mut Seeded(own), COURSE[own as usize % COURSE.len()]);
        all.steps += seen.steps;
        all.contacts += seen.contacts;
        all.between += seen.between;
        all.remembered += seen.remembered;
    }
    eprintln!("DCD_SEED={seed}: {all:?}");
    // Otherwise the courses would test nothing.
    let least = all.steps.min(500);
    assert!(
        all.contacts > least && all.between > least && all.remembered > least as u64,
        "{all:?}"
    );
}
