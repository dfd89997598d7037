//! The same step with our answers, with Parry's GJK on our shapes, and with Parry's own shapes.

use dcd_gjk::{NarrowPhase, Pairwise};
use dcd_parry::{ParryGjk, ParryShapes};
use dcd_pipeline::geom::glam::DVec3;
use dcd_pipeline::{Overlap, Par, Pipeline, Pose, Scene, Shape, WideTree};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let octahedron = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|v| [v, -v]).collect();
    let shapes = vec![Shape::hull(octahedron)?, Shape::cuboid(DVec3::ONE)?, Shape::sphere(0.7)?];
    let at = |x: f64, y: f64| Pose::from_translation(DVec3::new(x, y, 0.0));
    let scene = Scene::one_each(shapes, vec![at(0.0, 0.0)?, at(1.6, 0.3)?, at(0.9, 1.9)?])?;

    let ours = contacts(Overlap::default(), &scene);
    println!("ours: {ours:?}");
    assert_eq!(contacts(Pairwise(ParryGjk::<f64>::default()), &scene), ours);
    assert_eq!(contacts(ParryShapes::<f64>::new(&scene), &scene), ours);
    assert_eq!(contacts(ParryShapes::<f32>::new(&scene), &scene), ours);
    Ok(())
}

fn contacts(narrow: impl NarrowPhase, scene: &Scene) -> Vec<(u32, u32)> {
    let mut pipeline = Pipeline::with(WideTree::default(), narrow);
    let mut contacts: Vec<_> = pipeline.step(scene, Par::Serial).contacts().collect();
    contacts.sort_unstable();
    contacts
}
