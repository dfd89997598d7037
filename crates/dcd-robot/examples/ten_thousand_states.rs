//! From a URDF to ten thousand checked states.

use dcd_pipeline::Par;
use dcd_robot::{AllowedPairs, LinkShapes, PairSearch, Robot, StateChecker, Workcell, World};
use std::path::Path;

/// A two-link arm on a base; a file would be `Robot::load`.
const URDF: &str = r#"<robot name="arm">
  <link name="base"><collision><geometry><box size="0.4 0.4 0.1"/></geometry></collision></link>
  <link name="upper"><collision><origin xyz="0 0 0.5"/><geometry><cylinder radius="0.05" length="0.9"/></geometry></collision></link>
  <link name="lower"><collision><origin xyz="0 0 0.6"/><geometry><cylinder radius="0.05" length="1.1"/></geometry></collision></link>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><origin xyz="0 0 0.1"/>
    <axis xyz="0 1 0"/><limit lower="-1.5" upper="1.5" effort="1" velocity="1"/></joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="lower"/><origin xyz="0 0 1.1"/>
    <axis xyz="0 1 0"/><limit lower="-3.1" upper="3.1" effort="1" velocity="1"/></joint>
</robot>"#;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let robot = Robot::read(URDF, Path::new("."), LinkShapes::Hulls)?;
    let allowed = AllowedPairs::from_pairs(&PairSearch::default().run(&robot)?);
    let checker = StateChecker::new(Workcell::new(robot, &World::default(), &allowed)?)?;
    let at = |k: u32| [f64::from(k % 100) * 0.03 - 1.5, f64::from(k / 100) * 0.06 - 3.0];
    let states: Vec<[f64; 2]> = (0..10_000).map(at).collect();
    // What is not proved free collides.
    let free = checker.collides(&states, Par::Pool)?.iter().filter(|collides| !**collides).count();
    println!("{free} of 10,000 states are free");
    assert!(free > 5_000 && free < 10_000, "{free}");
    Ok(())
}
