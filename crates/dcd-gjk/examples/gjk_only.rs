//! Two shapes, no scene, no threads: dcd-geom and dcd-gjk alone.

use dcd_geom::glam::DVec3;
use dcd_geom::{Polytope, Pose};
use dcd_gjk::{Body, Verdict, certified};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let cube = Polytope::cuboid(DVec3::splat(0.5))?;
    let here = Pose::IDENTITY;
    // The next float past one edge length: the faces just touch, then they just do not.
    for (x, touches) in [(1.0, true), (1.0_f64.next_up(), false)] {
        let there = Pose::from_translation(DVec3::X * x)?;
        let (a, b) = (Body::polytope(&cube, &here), Body::polytope(&cube, &there));
        let (verdict, rung) = certified::overlap(a, b);
        println!("at {x}: {verdict:?}, proved by {rung:?}");
        assert_eq!(verdict == Verdict::Touching(()), touches);
    }
    Ok(())
}
