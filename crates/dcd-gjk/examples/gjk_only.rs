//! Two shapes, no scene, no threads: dcd-geom and dcd-gjk alone.

use dcd_geom::glam::DVec3;
use dcd_geom::{Polytope, Pose};
use dcd_gjk::{PosedSupport, Verdict, certified};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let cube = Polytope::cuboid(DVec3::splat(0.5))?;
    let here = Pose::IDENTITY;
    // The next float past one edge length: the faces just touch, then they just do not.
    for (x, touches) in [(1.0, true), (1.0_f64.next_up(), false)] {
        let there = Pose::from_translation(DVec3::X * x)?;
        let (a, b) = (PosedSupport::polytope(&cube, &here), PosedSupport::polytope(&cube, &there));
        let (verdict, method) = certified::overlap(a, b);
        println!("at {x}: {verdict:?}, proved by {method:?}");
        assert_eq!(verdict == Verdict::Touching(()), touches);
    }
    Ok(())
}
