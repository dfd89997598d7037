//! Bodies of many kinds that fall on a terrain and come to rest on it, pushed apart by their contact manifolds.
//!
//! `cargo run --release --example pile -- 2000 300`: so many bodies, so many frames.

mod world;

use dcd_pipeline::prelude::*;
use std::time::{Duration, Instant};
use world::World;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut numbers = std::env::args().skip(1).map(|number| number.parse::<usize>());
    let bodies = numbers.next().unwrap_or(Ok(60))?;
    let frames = numbers.next().unwrap_or(Ok(60))?;
    let mut world = World::new(bodies, 1)?;
    let manifolds = WithAccuracy::new(Manifolds, Accuracy::F32);
    let mut pipeline = Pipeline::with(WideTree::default(), ThenMeasure::new(manifolds)?);
    let mut detection = Duration::ZERO;
    for frame in 1..=frames {
        let start = Instant::now();
        let step = pipeline.step(world.scene(), Par::Pool);
        detection += start.elapsed();
        world.advance(step.answers())?;
        if frame % 30 == 0 || frame == frames {
            let fastest = world.speeds().fold(0.0, f64::max);
            let moving = world.speeds().filter(|&speed| speed > 0.1).count();
            let (contacts, lowest) = (step.contact_count(), world.lowest_centre());
            println!(
                "frame {frame}: {contacts} contacts, {moving} of {bodies} bodies faster than 0.1 m/s, the fastest \
                 {fastest:.2} m/s, the lowest centre {lowest:.3} m above the ground"
            );
        }
    }
    println!("{:.2} ms of detection a frame", detection.as_secs_f64() * 1e3 / frames.max(1) as f64);
    Ok(())
}
