//! What links carry, and put down or hand on.

use super::*;
use crate::Attached;
use crate::allowed::Layer;

/// The tip carries two overlapping spheres, `one` and `two`, and a third that touches neither.
fn carried() -> World {
    let object = |name: &str, x: f64| {
        format!(
            "    - link_name: tip
      object:
        id: {name}
        header: {{frame_id: tip}}
        primitives: [{{type: sphere, dimensions: [0.5]}}]
        primitive_poses: [{{position: [{x}, 0, 0], orientation: [0, 0, 0, 1]}}]\n"
        )
    };
    let objects = [object("one", 3.0), object("two", 3.5), object("far", 7.0)].concat();
    let attached = format!("robot_state:\n  attached_collision_objects:\n{objects}");
    world_of(&sphere("", &attached).replace("[0, 0, 0.5]", "[0, 0, 9]")).unwrap()
}

fn tip_at_rest() -> Pose {
    Pose::from_translation(DVec3::new(3.0, 0.0, 0.0)).unwrap()
}

/// The sphere `one` where the tip has it at rest, carried by the base.
fn one_on_the_base() -> Attached {
    let at = Pose::from_translation(DVec3::new(6.0, 0.0, 0.0)).unwrap();
    Attached::new("one", "base", [(Shape::sphere(0.5).unwrap(), at)])
}

#[test]
fn what_is_detached_meets_what_it_was_carried_with() {
    let mut world = carried();
    assert!(touching(&world).is_empty() && world.allowed.contains("one", "two"));
    let one = world.detach("one").unwrap();
    assert!(!world.allowed.contains("one", "two") && world.allowed.contains("two", "far"));
    let mut elsewhere = world.clone();
    elsewhere.attach(one_on_the_base(), [""; 0]);
    assert_eq!(touching(&elsewhere), [["two", "one"]]);
    world.obstacles.extend(one.obstacles(&tip_at_rest()).unwrap());
    assert_eq!(touching(&world), [["two", "one"]]);
}

#[test]
fn what_is_attached_anew_is_of_no_other_links_body() {
    let mut world = carried();
    // Taken without `detach`, which would forget whom it was carried with.
    world.attached.retain(|attached| attached.name != "one");
    world.attach(one_on_the_base(), [""; 0]);
    assert_eq!(touching(&world), [["two", "one"]]);
}

#[test]
fn an_obstacle_is_of_no_rigid_body() {
    for refused in [None, Some(["two", "far"])] {
        let mut world = carried();
        let one = world.attached.remove(0);
        world.obstacles.extend(one.obstacles(&tip_at_rest()).unwrap());
        // A pair that may not touch: the body is taken pair by pair.
        if let Some([a, b]) = refused {
            let mut layer = Layer::default();
            layer.set(a, b, false);
            world.allowed.push(layer);
        }
        assert_eq!(touching(&world), [["two", "one"]], "{refused:?}");
    }
}
