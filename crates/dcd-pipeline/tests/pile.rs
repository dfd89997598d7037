//! A small pile on a terrain comes to rest by its manifolds, and nothing sinks.

#[path = "../examples/pile/world.rs"]
mod world;

use dcd_pipeline::prelude::*;
use world::World;

#[test]
fn mixed_bodies_come_to_rest_on_a_terrain_and_none_sinks() {
    let mut world = World::new(42, 3).unwrap();
    let manifolds = WithAccuracy::new(Manifolds, Accuracy::F32);
    let mut pipeline = Pipeline::with(WideTree::default(), ThenMeasure::new(manifolds).unwrap());
    for _ in 0..300 {
        let step = pipeline.step(world.scene(), Par::Serial);
        assert_eq!(step.report().undecided().len(), 0);
        world.advance(step.answers()).unwrap();
        assert!(world.lowest_centre() > 0.05, "{}", world.lowest_centre());
    }
    let moving = world.speeds().filter(|&speed| speed > 0.1).count();
    assert_eq!(moving, 0, "{:?}", world.speeds().collect::<Vec<_>>());
}
