//! Where the objects of a scene touch: up to four points a pair, as a physics engine wants them.

use dcd_pipeline::prelude::*;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let shapes = vec![
        Shape::half_space(DVec3::Z, 0.0)?,
        Shape::cuboid(DVec3::splat(0.5))?,
        Shape::cylinder(0.5, 0.3)?,
    ];
    let at = |x: f64, z: f64| Pose::from_translation(DVec3::new(x, 0.0, z));
    // A crate and a barrel that stand on the ground, sunk in by a millimetre; a crate on the crate.
    let objects = [
        Object::new(0, Pose::IDENTITY).fixed(),
        Object::new(1, at(0.0, 0.499)?),
        Object::new(2, at(2.0, 0.499)?),
        Object::new(1, at(0.2, 1.498)?),
    ];
    let scene = Scene::new(shapes, objects)?;
    let fast = WithAccuracy::new(Manifolds::default(), Accuracy::F64);
    let mut pipeline = Pipeline::with(WideTree::default(), ThenMeasure::new(fast)?);
    let step = pipeline.step(&scene, Par::Pool);
    for contact in step.answers() {
        let Pair { i, j } = contact.pair;
        // One manifold: shapes of parts may have more.
        for manifold in &contact.answer {
            let Manifold { normal, error_bound, .. } = manifold;
            println!("{i} and {j} along {normal}, to within {error_bound:.0e} m:");
            for point in manifold.points() {
                println!("  {:.4} m deep at {:.3}", point.depth, point.point_a);
            }
            assert_eq!(manifold.points().len(), 4);
        }
    }
    assert_eq!(step.contact_count(), 3);
    Ok(())
}
