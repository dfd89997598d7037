//! What an answer says of all objects, though their brackets are of unlike width.

use super::*;

fn at(x: f64, y: f64) -> Pose {
    Pose::from_translation(DVec3::new(x, y, 0.0)).unwrap()
}

#[test]
fn no_object_is_met_before_the_first_hit_though_another_is_surely_met() {
    // In the plane of the long one's face, which the ray meets from t = 1 on; the small one surely from 1.5 on.
    let long = Shape::cuboid(DVec3::new(2.0, 1.0, 1.0)).unwrap();
    let small = Shape::cuboid(DVec3::splat(0.25)).unwrap();
    let scene = Scene::one_each(vec![small, long], vec![at(1.75, 1.0), at(3.0, 0.0)]).unwrap();
    let mut pipeline = Pipeline::new();
    pipeline.step(&scene, Par::Serial);
    let ray = Ray::endless(DVec3::Y, DVec3::X).unwrap();
    let found = pipeline.queries(&scene).unwrap().first_hit(&ray, &QueryFilter::ALL).unwrap();
    assert!(found.object == 1 && found.hit.t_lower <= 1.0 && !found.hit.is_certain, "{found:?}");
}

#[test]
fn the_first_hit_and_the_nearest_count_a_wide_bracket_behind_a_narrow_one() {
    // The sphere is 0.9999999 away, to within 1e-7; the cuboid 0.99999995, to within 1e-13.
    let (radius, from) = (2.0_f64.powi(30), DVec3::X * -1e-7);
    let face = from.x - 0.99999995;
    let shapes = vec![Shape::sphere(radius).unwrap(), Shape::cuboid(DVec3::splat(0.5)).unwrap()];
    let scene = Scene::one_each(shapes, vec![at(-1.0 - radius, 0.0), at(face - 0.5, 0.0)]).unwrap();
    let mut pipeline = Pipeline::new();
    pipeline.step(&scene, Par::Serial);
    let queries = pipeline.queries(&scene).unwrap();
    let ray = Ray::endless(from, -DVec3::X).unwrap();
    let met = queries.first_hit(&ray, &QueryFilter::ALL).unwrap();
    assert!(met.hit.t_lower <= 0.9999999 && met.hit.t_upper >= 0.9999999, "{met:?}");
    let near = queries.nearest(from, f64::INFINITY, &QueryFilter::ALL).unwrap().unwrap();
    assert!(near.lower <= 0.9999999 && near.upper >= 0.9999999, "{near:?}");
}
