//! What a cell is not made of, where a caller says it without a file.
#![allow(missing_docs)]

use dcd_geom::glam::DVec3;
use dcd_geom::{Pose, Shape};
use dcd_robot::{AllowedPairs, Attached, LinkShapes, Padding, Robot, RobotError, Workcell, World};
use std::path::Path;

const SLIDE: &str = r#"<robot name="slide">
  <link name="a"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <link name="b"><collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision></link>
  <joint name="j" type="prismatic">
    <parent link="a"/><child link="b"/><axis xyz="1 0 0"/>
    <limit lower="0" upper="2" effort="1" velocity="1"/>
  </joint>
</robot>"#;

fn robot() -> Robot {
    Robot::read(SLIDE, Path::new("."), LinkShapes::Hulls).unwrap()
}

fn carrying(name: &str, link: &str) -> World {
    let pose = Pose::from_translation(DVec3::Z * 0.5).unwrap();
    let mut world = World::default();
    world.attach(Attached::new(name, link, [(Shape::sphere(0.3).unwrap(), pose)]), ["a", "b"]);
    world
}

#[test]
fn a_robot_that_carries_something_takes_nothing_of_that_name() {
    let cell = |robot: Robot, world: &World| Workcell::new(robot, world, &world.allowed.clone());
    let first = cell(robot(), &carrying("tin", "a")).unwrap();
    let refused = cell(first.robot().clone(), &carrying("tin", "b")).err().unwrap().to_string();
    assert!(refused.contains("tin") && refused.contains("has that name too"), "{refused}");
    let second = cell(first.robot().clone(), &carrying("cup", "b")).unwrap();
    assert_eq!(second.names().iter().filter(|name| ["tin", "cup"].contains(&&***name)).count(), 2);
}

#[test]
fn a_padding_that_makes_a_link_smaller_is_refused() {
    let made = |padding: Padding| {
        ["a", "b"].map(|link| {
            let mut world = World::default();
            world.padding.insert(link.to_owned(), padding);
            Workcell::new(robot(), &world, &AllowedPairs::default()).map(|_| ())
        })
    };
    assert!(made(Padding { padding: 0.05, scale: 1.5, ..Padding::NONE }).iter().all(Result::is_ok));
    for (padding, scale) in
        [(-0.05, 1.0), (f64::NAN, 1.0), (0.0, 0.0), (0.0, -0.5), (0.0, f64::INFINITY)]
    {
        for against_robot in [false, true] {
            for refused in made(Padding { padding, scale, against_robot }) {
                assert!(
                    matches!(refused, Err(RobotError::Shape { .. })),
                    "{padding} {scale} {refused:?}"
                );
            }
        }
    }
}
