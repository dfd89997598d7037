//! Closed forms beside the shapes' own supports and boxes in f64.

use super::super::separate::Support;
use super::super::tests::{Draw, shape};
use super::*;
use dcd_geom::{Object, SupportMap};

/// Beside the support map in f64: reach, point and box, each within the obstacle's margin.
#[test]
fn a_closed_form_reaches_as_far_as_its_shape() {
    let mut draw = Draw(29);
    let mut closed = 0;
    for _ in 0..600 {
        let (shape, pose) = (shape(&mut draw), draw.pose(3.0));
        let objects = [Object::new(0, pose)];
        let scene = Scene::new(vec![shape.clone()], objects).unwrap();
        let (solid, aabb) = Solid::of(&scene, 0, Some(&mut Vec::new()));
        if !solid.is_closed() {
            continue;
        }
        closed += 1;
        let truth = shape.aabb(&pose);
        assert!(aabb.min.cmple(truth.min).all() && aabb.max.cmpge(truth.max).all(), "{shape:?}");
        let margin = f64::from(solid.margin());
        let directions = (0..20).map(|_| draw.vector().normalize()).chain(DVec3::AXES);
        for direction in directions.collect::<Vec<_>>() {
            let (ours, point) =
                (solid.reach_along(direction.as_vec3()), solid.farthest(direction.as_vec3()));
            let point = (point + (&solid).origin()).as_dvec3();
            let along = pose.rotation().transpose() * direction;
            let core = along.dot(shape.support(along).point);
            assert!((f64::from(ours) - core).abs() < 0.25 * margin, "{shape:?}: {ours}, {core}");
            let reach = direction.dot(point - pose.translation());
            assert!((reach - core).abs() < 0.25 * margin, "{shape:?}: {point}");
            let swept = f64::from(Support::margin(&&solid)) - margin;
            assert!((swept - shape.radius()).abs() < 0.01 * margin, "{shape:?}");
        }
    }
    assert!(closed > 200, "{closed}");
}
