//! Edges that pass an obstacle at a gap that is made: how many are decided within a time, and how long that takes.

use std::time::Duration;

use anyhow::{Context, Result};
use dcd_benches::timing::time;
use dcd_geom::{Pose, Shape};
use dcd_gjk::PosedShape;
use dcd_gjk::distance::{DistanceResult, distance};
use dcd_robot::{
    AllowedPairs, EdgeAnswer, EdgeChecker, JointPath, Obstacle, Robot, RobotError, Workcell, World,
};
use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::data::{Geometry, on_the_way};
use crate::edges::BUDGET;

/// The gaps, metres.
pub(crate) const GAPS: [f64; 7] = [1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8];

/// What is decided within that counts.
pub(crate) const IN_TIME: Duration = Duration::from_millis(10);

/// States in which the least distance is looked for, before it is refined.
const STATES: usize = 400;

/// Edges at one gap: times in microseconds.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Group {
    pub(crate) gap: f64,
    pub(crate) free: usize,
    pub(crate) hits: usize,
    pub(crate) undecided: usize,
    pub(crate) in_time: usize,
    pub(crate) times: Vec<f64>,
    pub(crate) nodes: Vec<f64>,
    /// Reported clearances over the gap.
    pub(crate) clearances: Vec<f64>,
}

/// An edge of a robot in an empty world, and where its parts are on the way.
struct Edge<'a> {
    robot: &'a Robot,
    ends: &'a [Vec<f64>; 2],
    poses: Vec<Vec<Pose>>,
}

/// For each gap so many edges beside a sphere or a box, by turns; hulls.
pub(crate) fn run(
    (robot, allowed): (&Robot, &AllowedPairs),
    ends: &[[Vec<f64>; 2]],
    (count, rounds): (usize, usize),
    seed: u64,
) -> Result<Vec<Group>> {
    let mut groups = GAPS.map(|gap| Group { gap, ..Group::default() });
    let empty = Workcell::new(robot.clone(), &World::default(), allowed)?;
    let empty = EdgeChecker::new(empty);
    let mut draw = Draw(seed);
    let mut made = 0;
    for ends in ends {
        if made == count {
            break;
        }
        // What touches by itself grazes nothing.
        let found = empty.check(&JointPath::Straight(ends.clone()), BUDGET)?;
        if !matches!(found.answer, EdgeAnswer::Free { .. }) {
            continue;
        }
        made += 1;
        let edge = Edge::new(robot, ends)?;
        let shape = if made % 2 == 0 {
            Shape::sphere(0.05)?
        } else {
            Shape::cuboid(DVec3::new(0.04, 0.06, 0.05))?
        };
        for group in &mut groups {
            let Some(obstacle) = edge.obstacle(&shape, group.gap, &mut draw)? else { continue };
            let world = World { obstacles: vec![obstacle], ..World::default() };
            let checker = EdgeChecker::new(Workcell::new(robot.clone(), &world, allowed)?);
            group.add(&checker, &JointPath::Straight(ends.clone()), rounds)?;
        }
    }
    Ok(groups.to_vec())
}

impl Group {
    fn add(&mut self, checker: &EdgeChecker, path: &JointPath, rounds: usize) -> Result<()> {
        let edge = checker.check(path, BUDGET)?;
        let times = (0..rounds.max(1)).map(|_| time(|| checker.check(path, BUDGET)).0);
        let mut times: Vec<Duration> = times.collect();
        times.sort_unstable();
        let median = times[times.len() / 2];
        let decided = match edge.answer {
            EdgeAnswer::Free { clearance } => {
                self.clearances.push(clearance / self.gap);
                self.free += 1;
                true
            }
            EdgeAnswer::Hit { .. } => {
                self.hits += 1;
                true
            }
            EdgeAnswer::Undecided { .. } => {
                self.undecided += 1;
                false
            }
        };
        self.in_time += usize::from(decided && median <= IN_TIME);
        self.times.push(median.as_secs_f64() * 1e6);
        self.nodes.push(edge.nodes as f64);
        Ok(())
    }
}

impl<'a> Edge<'a> {
    fn new(robot: &'a Robot, ends: &'a [Vec<f64>; 2]) -> Result<Self> {
        let placed = |state: &Vec<f64>| {
            let mut poses = Vec::new();
            robot.place(state, &mut poses).map(|()| poses)
        };
        let states = on_the_way(ends, STATES);
        let poses = states.iter().map(placed).collect::<Result<Vec<_>, RobotError>>()?;
        Ok(Self { robot, ends, poses })
    }

    /// An obstacle that the edge passes at that gap, by the samples and what refines them; none where the line on which it
    /// is moved has no such place.
    fn obstacle(&self, shape: &Shape, gap: f64, draw: &mut Draw) -> Result<Option<Obstacle>> {
        // From a part of the robot outwards.
        let poses = &self.poses[draw.below(self.poses.len())];
        let from = poses[draw.below(poses.len())].translation();
        let way = draw.direction();
        let mut between = [0.0, 3.0];
        if self.least(shape, from + way * between[1])? <= gap {
            return Ok(None);
        }
        if self.least(shape, from)? > gap {
            return Ok(None);
        }
        for _ in 0..60 {
            let middle = 0.5 * (between[0] + between[1]);
            let is_far = self.least(shape, from + way * middle)? > gap;
            between[usize::from(is_far)] = middle;
        }
        let pose = Pose::from_translation(from + way * between[1])?;
        Ok(Some(Obstacle { name: "obstacle".to_owned(), shape: shape.clone(), pose }))
    }

    /// How near the obstacle comes, metres; 0 where it touches.
    fn least(&self, shape: &Shape, at: DVec3) -> Result<f64> {
        let place = Pose::from_translation(at)?;
        let obstacle = PosedShape { shape, pose: &place };
        let mut found: Vec<f64> = Vec::with_capacity(STATES);
        for poses in &self.poses {
            found.push(self.distance(obstacle, poses, f64::INFINITY));
            if found.last() == Some(&0.0) {
                return Ok(0.0);
            }
        }
        let bottoms = (0..STATES).filter(|&k| {
            let before = k.checked_sub(1).map_or(f64::INFINITY, |k| found[k]);
            let after = found.get(k + 1).copied().unwrap_or(f64::INFINITY);
            found[k] <= before && found[k] <= after
        });
        let mut bottoms: Vec<usize> = bottoms.collect();
        bottoms.sort_by(|&a, &b| found[a].total_cmp(&found[b]));
        let mut least = f64::INFINITY;
        for &k in bottoms.iter().take(3) {
            least = least.min(self.refined(obstacle, k)?);
        }
        Ok(least)
    }

    /// The least distance between the samples beside a sample, by golden sections.
    fn refined(&self, obstacle: PosedShape<'_>, sample: usize) -> Result<f64> {
        let t = |k: usize| k as f64 / (STATES - 1) as f64;
        let (mut from, mut to) = (t(sample.saturating_sub(1)), t((sample + 1).min(STATES - 1)));
        let mut poses = Vec::new();
        let mut at = |t: f64| -> Result<f64> {
            let ends = self.ends[0].iter().zip(&self.ends[1]);
            let state: Vec<f64> = ends.map(|(a, b)| a + t * (b - a)).collect();
            self.robot.place(&state, &mut poses)?;
            Ok(self.distance(obstacle, &poses, f64::INFINITY))
        };
        let golden = 0.5 * (5f64.sqrt() - 1.0);
        let mut inner = [to - golden * (to - from), from + golden * (to - from)];
        let mut values = [at(inner[0])?, at(inner[1])?];
        for _ in 0..40 {
            if values[0] <= values[1] {
                (to, inner[1], values[1]) = (inner[1], inner[0], values[0]);
                inner[0] = to - golden * (to - from);
                values[0] = at(inner[0])?;
            } else {
                (from, inner[0], values[0]) = (inner[0], inner[1], values[1]);
                inner[1] = from + golden * (to - from);
                values[1] = at(inner[1])?;
            }
        }
        Ok(at(from)?.min(at(to)?).min(values[0]).min(values[1]))
    }

    /// The distance of the nearest part, if that is below a bound; 0 where one touches.
    fn distance(&self, obstacle: PosedShape<'_>, poses: &[Pose], below: f64) -> f64 {
        let mut least = below;
        for (part, pose) in self.robot.parts().iter().zip(poses) {
            let reach = part.shape.reach() + obstacle.shape.reach();
            let between = pose.translation().distance(obstacle.pose.translation());
            if between - reach >= least {
                continue;
            }
            match distance(PosedShape { shape: &part.shape, pose }, obstacle).0 {
                DistanceResult::Apart(found) => least = least.min(found.distance),
                _ => return 0.0,
            }
        }
        least
    }
}

/// Numbers from a seed.
struct Draw(u64);

impl Draw {
    fn next(&mut self) -> u64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        self.0 >> 11
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() >> 20) as usize % n.max(1)
    }

    /// Of unit length.
    fn direction(&mut self) -> DVec3 {
        loop {
            let [x, y, z] = [(); 3].map(|()| self.next() as f64 / (1u64 << 52) as f64 - 1.0);
            let v = DVec3::new(x, y, z);
            if let Some(unit) = v.try_normalize().filter(|_| v.length() < 1.0) {
                return unit;
            }
        }
    }
}

/// The ends of every problem's edge.
pub(crate) fn ends(data: &crate::data::Data) -> Result<Vec<[Vec<f64>; 2]>> {
    let settings = data.settings(Geometry::Hulls).context("the problems")?;
    Ok(settings.into_iter().map(|setting| setting.ends).collect())
}
