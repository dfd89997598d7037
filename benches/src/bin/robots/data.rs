//! The Panda and its problems, where the data is.

use std::path::Path;
use std::sync::Arc;

use anyhow::{Context, Result};
use clap::ValueEnum;
use dcd_io::data;
use dcd_robot::{
    AllowedPairs, LinkShapes, Obstacle, Problem, Robot, Srdf, Workcell, read_problems,
};

/// What the robot's links are taken as.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Geometry {
    Spheres,
    Hulls,
    Meshes,
}

impl Geometry {
    pub(crate) const ALL: [Self; 3] = [Self::Spheres, Self::Hulls, Self::Meshes];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Spheres => "59 spheres",
            Self::Hulls => "hulls",
            Self::Meshes => "meshes",
        }
    }
}

/// The files: the robot with meshes, with spheres, its pairs that may touch, and the problems.
const FILES: [&str; 4] = [
    "panda/panda.urdf",
    "panda/panda_spherized.urdf",
    "panda/panda.srdf",
    "panda/problems.tar.bz2",
];

/// A problem's robot among its obstacles, and the two ends of its edge.
pub(crate) struct Setting {
    pub(crate) cell: Workcell,
    /// What of the world a planner is given.
    pub(crate) obstacles: Vec<Obstacle>,
    pub(crate) ends: [Vec<f64>; 2],
}

/// The problems of the archive.
pub(crate) struct Data {
    urdf: [std::path::PathBuf; 2],
    srdf: Srdf,
    problems: Vec<Problem>,
}

impl Data {
    /// Every so many problems; none where a file is absent, with its name.
    pub(crate) fn load(every: usize) -> Result<Result<Self, &'static str>> {
        let mut found = Vec::new();
        for file in FILES {
            match data::file(file) {
                Some(path) => found.push(path),
                None => return Ok(Err(file)),
            }
        }
        let [meshes, spheres, srdf, problems] = &found[..] else { return Ok(Err(FILES[0])) };
        let problems = read_problems(problems)?.into_iter().step_by(every.max(1)).collect();
        let urdf = [meshes.clone(), spheres.clone()];
        Ok(Ok(Self { urdf, srdf: Srdf::load(srdf)?, problems }))
    }

    pub(crate) fn count(&self) -> usize {
        self.problems.len()
    }

    pub(crate) fn robot(&self, geometry: Geometry) -> Result<Robot> {
        let [meshes, spheres] = &self.urdf;
        let (path, shapes): (&Path, _) = match geometry {
            Geometry::Spheres => (spheres, LinkShapes::Hulls),
            Geometry::Hulls => (meshes, LinkShapes::Hulls),
            Geometry::Meshes => (meshes, LinkShapes::Meshes),
        };
        Ok(Robot::load_as(path, shapes)?)
    }

    /// The pairs of links that may touch.
    pub(crate) fn allowed(&self) -> &AllowedPairs {
        &self.srdf.allowed
    }

    /// The ends of the first problem's edge.
    pub(crate) fn ends(&self) -> Result<[Vec<f64>; 2]> {
        let robot = Arc::new(self.robot(Geometry::Hulls)?);
        let problem = self.problems.first().context("no problem")?;
        Ok(self.setting(&robot, problem)?.ends)
    }

    pub(crate) fn settings(&self, geometry: Geometry) -> Result<Vec<Setting>> {
        let robot = Arc::new(self.robot(geometry)?);
        let settings = self.problems.iter().map(|problem| {
            let place = || format!("{}/{}", problem.set, problem.number);
            self.setting(&robot, problem).with_context(place)
        });
        settings.collect()
    }

    fn setting(&self, robot: &Arc<Robot>, problem: &Problem) -> Result<Setting> {
        let srdf = Some(&self.srdf);
        let mut world = problem.scene.world(robot, srdf)?;
        problem.request.place_base(&mut world, robot, srdf)?;
        let ends =
            [problem.request.start_in(&world, robot)?, problem.request.goal_in(&world, robot)?];
        let mut allowed = self.srdf.allowed.clone();
        allowed.extend(&world.allowed);
        world.allowed = AllowedPairs::default();
        let cell = Workcell::new(Arc::clone(robot), &world, &allowed)?;
        Ok(Setting { cell, obstacles: world.obstacles, ends })
    }
}

/// So many states on the straight line between two, both among them.
pub(crate) fn on_the_way([from, to]: &[Vec<f64>; 2], count: usize) -> Vec<Vec<f64>> {
    let at = |k: usize| {
        let part = k as f64 / (count - 1).max(1) as f64;
        from.iter().zip(to).map(|(a, b)| a * (1.0 - part) + b * part).collect()
    };
    (0..count).map(at).collect()
}
