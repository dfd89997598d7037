//! A robot of three links among static obstacles: which of its configurations are free?

use dcd_pipeline::geom::glam::{DQuat, DVec3};
use dcd_pipeline::geom::{Object, PoseError};
use dcd_pipeline::{LinkSet, Other, Overlap, Par, Pose, Scene, Shape, StaticWorld};

/// Where the links of an arm are whose every joint is bent by that angle.
fn arm(angle: f64) -> Result<Vec<Pose>, PoseError> {
    let mut joint = DVec3::ZERO;
    let poses = (1..=3).map(|link| {
        let turn = DQuat::from_rotation_y(angle * f64::from(link));
        let half = turn * DVec3::Z * 0.5;
        let pose = Pose::new(turn, joint + half);
        joint += half * 2.0;
        pose
    });
    poses.collect()
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let shapes = vec![Shape::cuboid(DVec3::new(5.0, 5.0, 0.1))?, Shape::sphere(0.5)?];
    let at = |x: f64, z: f64| Pose::from_translation(DVec3::new(x, 0.0, z));
    let obstacles = [Object::new(0, at(0.0, -0.2)?), Object::new(1, at(1.2, 2.2)?)];
    let world = StaticWorld::new(&Scene::new(shapes, obstacles)?, Overlap::default(), Par::Pool)?;

    let link = Shape::cuboid(DVec3::new(0.05, 0.05, 0.5))?;
    let robot = LinkSet::new(vec![link; 3]).against_itself(&[(0, 1), (1, 2)])?;
    let mut checker = world.checker(robot)?;
    let batch: Vec<Vec<Pose>> =
        (0..100).map(|k| arm(f64::from(k) * 0.02)).collect::<Result<_, _>>()?;
    let first = checker.first(&batch.concat(), Par::Pool)?;
    for found in first.iter().flatten() {
        println!("{}: link {} and {:?}", found.configuration, found.link, found.other);
    }
    let hit = |other: Other| first.iter().flatten().any(|found| found.other == other);
    assert!(first[0].is_none() && hit(Other::Obstacle(0)) && hit(Other::Obstacle(1)));
    Ok(())
}
