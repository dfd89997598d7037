//! Random robots in random worlds.

use crate::{AllowedPairs, LinkShapes, Obstacle, Padding, Robot, Workcell, World};
use dcd_geom::{Pose, Shape};
use glam::{DQuat, DVec3};
use std::fmt::Write;
use std::path::Path as FilePath;

/// Numbers in −1 … 1 by a linear congruence.
pub(in super::super) struct Draw(pub(in super::super) u64);

/// The numbers of a test: of that seed, or of the one that DCD_SEED adds.
pub(in super::super) fn seeded(seed: u64) -> Draw {
    let more = std::env::var("DCD_SEED").ok().and_then(|text| text.parse().ok());
    let seed = seed.wrapping_add(more.unwrap_or(0u64).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    println!("seed {seed}");
    Draw(seed)
}

impl Draw {
    pub(in super::super) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    pub(in super::super) fn below(&mut self, end: u32) -> u32 {
        ((self.next() + 1.0) / 2.0 * f64::from(end)) as u32 % end
    }

    pub(in super::super) fn size(&mut self, least: f64, most: f64) -> f64 {
        least + (most - least) * (self.next() + 1.0) / 2.0
    }

    pub(in super::super) fn vector(&mut self) -> DVec3 {
        DVec3::new(self.next(), self.next(), self.next())
    }

    pub(in super::super) fn pose(&mut self, far: f64) -> Pose {
        let q = DQuat::from_xyzw(self.next(), self.next(), self.next(), self.next()).normalize();
        let turned = if self.below(3) == 0 { DQuat::IDENTITY } else { q };
        Pose::new(turned, self.vector() * far).unwrap()
    }
}

/// A chain with branches, of joints of every kind; what it carries as the draw says.
pub(in super::super) fn robot(draw: &mut Draw, spheres_alone: bool) -> Robot {
    let links = 3 + draw.below(5);
    robot_of(draw, links, spheres_alone)
}

/// The same of so many links.
pub(in super::super) fn robot_of(draw: &mut Draw, links: u32, spheres_alone: bool) -> Robot {
    let mut urdf = "<robot name=\"random\">".to_owned();
    for link in 0..links {
        let _ = write!(urdf, "<link name=\"l{link}\">");
        for _ in 0..draw.below(if spheres_alone { 20 } else { 4 }) + u32::from(link == 0) {
            let at = draw.vector() * 0.2;
            let rpy = draw.vector() * 3.0;
            let kind = if spheres_alone { 0 } else { draw.below(3) };
            let shape = match kind {
                0 => format!("<sphere radius=\"{}\"/>", draw.size(0.02, 0.1)),
                1 => {
                    let mut edge = || draw.size(0.02, 0.5);
                    format!("<box size=\"{} {} {}\"/>", edge(), edge(), edge())
                }
                _ => {
                    let (radius, length) = (draw.size(0.02, 0.1), draw.size(0.02, 0.6));
                    format!("<cylinder radius=\"{radius}\" length=\"{length}\"/>")
                }
            };
            let _ = write!(
                urdf,
                "<collision><origin xyz=\"{} {} {}\" rpy=\"{} {} {}\"/><geometry>{shape}</geometry></collision>",
                at.x, at.y, at.z, rpy.x, rpy.y, rpy.z
            );
        }
        urdf += "</link>";
    }
    for child in 1..links {
        let parent = if draw.below(4) == 0 { 0 } else { child - 1 };
        let kind = ["revolute", "prismatic", "continuous", "fixed", "floating", "revolute"]
            [draw.below(6) as usize];
        let axis = match draw.below(4) {
            0 => DVec3::X,
            1 => -DVec3::Z,
            2 => DVec3::Y,
            _ => draw.vector().normalize(),
        };
        let (at, rpy) = (draw.vector() * 0.4, draw.vector() * f64::from(draw.below(2)));
        let _ = write!(
            urdf,
            "<joint name=\"j{child}\" type=\"{kind}\"><parent link=\"l{parent}\"/><child link=\"l{child}\"/>\
             <origin xyz=\"{} {} {}\" rpy=\"{} {} {}\"/><axis xyz=\"{} {} {}\"/>\
             <limit lower=\"-3\" upper=\"3\" effort=\"1\" velocity=\"1\"/></joint>",
            at.x, at.y, at.z, rpy.x, rpy.y, rpy.z, axis.x, axis.y, axis.z
        );
    }
    urdf += "</robot>";
    Robot::read(&urdf, FilePath::new("."), LinkShapes::Hulls).unwrap()
}

/// An obstacle of any kind of shape.
pub(in super::super) fn shape(draw: &mut Draw) -> Shape {
    let size = draw.size(0.05, 0.4);
    let points = |draw: &mut Draw, count: u32| (0..count).map(|_| draw.vector() * size).collect();
    let shape = match draw.below(11) {
        0 | 1 => Shape::cuboid(draw.vector().abs() * size),
        2 => Shape::cylinder(size, 0.1 + 0.4 * size),
        3 => Shape::sphere(size),
        4 => Shape::capsule(size, 0.1),
        5 => Shape::hull(points(draw, 12)),
        6 => Shape::cone(size, 0.2),
        7 => Shape::half_space(draw.vector(), -1.0),
        8 => Shape::mesh(points(draw, 6), vec![[0, 1, 2], [2, 3, 4], [3, 4, 5], [0, 4, 5]]),
        9 => Shape::segment(draw.vector() * size, draw.vector()),
        _ => {
            let parts = [Shape::sphere(0.1), Shape::cylinder(0.1, 0.2)];
            let parts = parts.into_iter().map(|part| (part.unwrap(), draw.pose(0.2)));
            Shape::compound(parts.collect())
        }
    };
    let shape = shape.unwrap();
    if draw.below(4) == 0 { shape.swept(0.03).unwrap() } else { shape }
}

pub(in super::super) fn world(draw: &mut Draw, robot: &Robot) -> World {
    // Few, or more than are compared one after the other.
    let most = if draw.below(5) == 0 { 120 } else { 12 };
    let obstacles = (0..draw.below(most)).map(|k| Obstacle {
        name: format!("o{k}"),
        shape: shape(draw),
        pose: draw.pose(0.8),
    });
    let mut world = World { obstacles: obstacles.collect(), ..World::default() };
    if draw.below(3) == 0 {
        world.base = Some(draw.pose(0.5));
    }
    for link in robot.links().iter().filter(|_| draw.below(6) == 0) {
        world.padding.insert(link.name.clone(), Padding { padding: 0.02, ..Padding::NONE });
    }
    world
}

pub(in super::super) fn cell(draw: &mut Draw) -> Workcell {
    let spheres_alone = draw.below(2) == 0;
    let robot = robot(draw, spheres_alone);
    let world = world(draw, &robot);
    let allowed =
        if draw.below(4) == 0 { AllowedPairs::default() } else { AllowedPairs::adjacent(&robot) };
    Workcell::new(robot, &world, &allowed).unwrap()
}

pub(in super::super) fn state(draw: &mut Draw, robot: &Robot) -> Vec<f64> {
    let mut state = robot.rest_state();
    for joint in robot.joints() {
        if let crate::Motion::Orients { first } = joint.motion {
            let q = DQuat::from_xyzw(draw.next(), draw.next(), draw.next(), draw.next());
            state[first..first + 4].copy_from_slice(&q.normalize().to_array());
        } else if let Some(by) = joint.motion.drive() {
            state[by.value] = draw.next() * 3.0;
        }
    }
    state
}
