//! Pushes a box off a sphere along the gradient of their signed distance.

use dcd_geom::glam::{DQuat, DVec3};
use dcd_geom::{Pose, Shape};
use dcd_gjk::{PairSolver, PosedShape, Proximities, Verdict};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (sphere, plank) = (Shape::sphere(0.5)?, Shape::cuboid(DVec3::new(1.0, 0.3, 0.2))?);
    let solver = Proximities::within(10.0)?;
    let mut scratch = Default::default();
    let (wanted, still) = (0.25, Pose::IDENTITY);
    let (mut turn, mut place) = (DQuat::IDENTITY, DVec3::new(0.7, 0.4, 0.1));
    for step in 0..100 {
        let pose = Pose::new(turn, place)?;
        let (a, b) = (
            PosedShape { shape: &sphere, pose: &still },
            PosedShape { shape: &plank, pose: &pose },
        );
        let Verdict::Touching(found) = solver.solve(a, b, &mut scratch) else {
            return Err("farther than ten metres".into());
        };
        let missing = wanted - found.signed_distance;
        println!("step {step}: {:+.6} m, {:?}", found.signed_distance, found.smoothness);
        if missing.abs() < 1e-6 {
            return Ok(());
        }
        // The least motion that, at first order, makes up what is missing.
        let gradient = found.gradient.b;
        let (along, about) = (gradient.translation, gradient.rotation);
        let scale = missing / (along.length_squared() + about.length_squared());
        place += along * scale;
        turn = (DQuat::from_scaled_axis(about * scale) * turn).normalize();
    }
    Err("the gradient leads nowhere".into())
}
