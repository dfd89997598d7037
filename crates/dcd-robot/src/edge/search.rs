//! The search over intervals of a path.

use super::reach::Lengths;
use super::{Edge, EdgeAnswer, EdgeChecker, EdgePair, EdgeReason, JointPath};
use crate::kinematics::JointFrame;
use crate::{Motion, RobotError};
use dcd_geom::{BoundingSphere, Pose};
use dcd_gjk::distance::{DistanceResult, distance, gap_along, in_f64};
use dcd_gjk::{PosedShape, Verdict, certified};
use glam::DVec3;

/// An interval is not halved below this length. No unit. Smaller: more intervals where shapes graze each
/// other. Larger: gaps below a micrometre stay undecided.
const SHORTEST: f64 = 1.0 / (1u64 << 40) as f64;

/// How near to a hit the path before it is proved free, if it is. No unit. Smaller: more intervals before
/// each hit (at 2⁻¹² twice as many). Larger: `free_until` ends earlier.
const BEFORE_A_HIT: f64 = 1.0 / (1u64 << 8) as f64;

/// What the numbers of a bound lose in f64, relative, with much room.
const ROOM: f64 = 1.0 + 1e-9;

pub(super) struct Search<'a> {
    checker: &'a EdgeChecker,
    path: &'a JointPath,
    budget: usize,
    /// One for each object, empty for obstacles.
    lengths: Vec<Lengths>,
    /// For each pair how fast it closes at most, and what the poses of both may be off by, twice: where the gap
    /// is found, and where it is relied on.
    rates: Vec<[f64; 2]>,
    /// For each pair the direction in which its gap was last found, zero before.
    directions: Vec<DVec3>,
    /// A distance that some pair has somewhere on the path: what comes no nearer than half of it is proved.
    nearest: f64,
    clearance: f64,
    nodes: usize,
    hit: Option<(f64, [u32; 2])>,
    /// The first interval that is left, with a pair of it.
    left: Option<([f64; 2], [u32; 2], EdgeReason)>,
    at: Place,
}

/// The robot at one t.
#[derive(Default)]
struct Place {
    t: f64,
    state: Vec<f64>,
    rates: Vec<f64>,
    poses: Vec<Pose>,
    frames: Vec<JointFrame>,
    /// Of all objects.
    spheres: Vec<BoundingSphere>,
}

/// How a part moves at one t against the frame of the joints that it shares with another.
#[derive(Clone, Copy, Default)]
struct Twist {
    /// The velocity of the middle of its sphere.
    velocity: DVec3,
    /// How it turns, rad.
    turn: DVec3,
    /// The radius of the sphere.
    radius: f64,
    /// The largest speed and acceleration of its points on the path.
    speed: f64,
    acceleration: f64,
}

struct Node {
    from: f64,
    to: f64,
    pairs: Vec<u32>,
}

impl<'a> Search<'a> {
    pub(super) fn new(
        checker: &'a EdgeChecker,
        path: &'a JointPath,
        budget: usize,
    ) -> Result<Self, RobotError> {
        let extents = path.extents(checker.robot());
        let lengths = checker.movers.iter().map(|mover| {
            mover.as_ref().map_or_else(Lengths::default, |(_, chain)| chain.lengths(&extents))
        });
        let lengths: Vec<Lengths> = lengths.collect();
        let rates = checker.pairs.iter().map(|pair| {
            let both = pair.objects.map(|object| &lengths[object as usize]);
            both.iter().fold([0.0; 2], |[speed, off], one| {
                [speed + one.speed_from(pair.common as usize) * ROOM, off + 2.0 * one.deviation]
            })
        });
        let rates = rates.collect();
        let directions = vec![DVec3::ZERO; checker.pairs.len()];
        Ok(Self {
            checker,
            path,
            budget,
            lengths,
            rates,
            directions,
            nearest: f64::INFINITY,
            clearance: f64::INFINITY,
            nodes: 0,
            hit: None,
            left: None,
            at: Place::default(),
        })
    }

    pub(super) fn run(mut self) -> Result<Edge, RobotError> {
        for end in [0.0, 1.0] {
            self.nodes += 1;
            self.go_to(end)?;
            self.hit = self.touching().map(|pair| (end, pair));
            if self.hit.is_some() {
                break;
            }
        }
        let pairs = (0..self.checker.pairs.len() as u32).collect();
        let mut stack = vec![Node { from: 0.0, to: 1.0, pairs }];
        while let Some(node) = stack.pop() {
            // What is beyond a hit, or beyond what is left already, tells nothing more.
            if self.hit.is_some_and(|(t, _)| node.from >= t) {
                continue;
            }
            if let Some(reason) = self.ends(&node) {
                self.leave(&node, reason);
                continue;
            }
            self.nodes += 1;
            let middle = 0.5 * (node.from + node.to);
            self.go_to(middle)?;
            let pairs = self.unproved(&node);
            if !pairs.is_empty() {
                stack.push(Node { from: middle, to: node.to, pairs: pairs.clone() });
                stack.push(Node { from: node.from, to: middle, pairs });
            }
        }
        Ok(self.edge())
    }

    /// Why the node is not looked at any more.
    fn ends(&self, node: &Node) -> Option<EdgeReason> {
        let length = node.to - node.from;
        let is_short = length <= SHORTEST || (self.hit.is_some() && length <= BEFORE_A_HIT);
        if is_short {
            Some(EdgeReason::Short)
        } else if self.nodes >= self.budget {
            Some(EdgeReason::Budget)
        } else {
            None
        }
    }

    fn leave(&mut self, node: &Node, reason: EdgeReason) {
        let pair = node.pairs.first().map(|&pair| self.checker.pairs[pair as usize].objects);
        // The stack gives them in the order of t.
        if let (None, Some(pair)) = (&self.left, pair) {
            self.left = Some(([node.from, node.to], pair, reason));
        }
    }

    fn edge(self) -> Edge {
        let nodes = self.nodes;
        let left_from = self.left.map_or(1.0, |([from, _], ..)| from);
        let (answer, free_until) = match (self.hit, self.left) {
            (Some((t, pair)), _) => (EdgeAnswer::Hit { t, pair }, left_from.min(t)),
            (None, Some((t, pair, reason))) => (EdgeAnswer::Undecided { t, pair, reason }, t[0]),
            (None, None) => (EdgeAnswer::Free { clearance: self.clearance }, 1.0),
        };
        Edge { answer, free_until, nodes }
    }

    fn go_to(&mut self, t: f64) -> Result<(), RobotError> {
        let Self { checker, path, at, .. } = self;
        let robot = checker.robot();
        at.t = t;
        path.state_at(robot, t, &mut at.state);
        path.rates_at(t, &mut at.rates);
        at.frames = robot.link_frames(&at.state)?;
        robot.pose_parts(&at.frames, &mut at.poses)?;
        at.spheres.clear();
        let scene = checker.cell.scene();
        for (i, sphere) in checker.spheres.iter().enumerate() {
            let pose = match &checker.movers[i] {
                Some((part, _)) => &at.poses[*part],
                None => &scene.poses()[i],
            };
            let sphere = sphere.as_ref();
            at.spheres.push(sphere.map_or(BoundingSphere::EVERYTHING, |s| s.sphere(pose)));
        }
        Ok(())
    }

    fn posed(&self, object: u32) -> PosedShape<'_> {
        let i = object as usize;
        let scene = self.checker.cell.scene();
        let pose = match &self.checker.movers[i] {
            Some((part, _)) => &self.at.poses[*part],
            None => &scene.poses()[i],
        };
        PosedShape { shape: scene.shape(i), pose }
    }

    /// At most the distance of two objects, by the sphere of each and the other's sphere or box.
    fn far(&self, [a, b]: [u32; 2]) -> f64 {
        let [in_a, in_b] = [a, b].map(|object| &self.at.spheres[object as usize]);
        let [centre_a, centre_b] = [in_a, in_b].map(|sphere| sphere.centre.as_dvec3());
        let [radius_a, radius_b] = [in_a, in_b].map(|sphere| f64::from(sphere.radius));
        let to_box = |object: u32, point: DVec3| {
            self.checker.boxes[object as usize].far(self.posed(object).pose, point)
        };
        let between = centre_a.distance(centre_b) * (1.0 - 1e-12) - radius_a - radius_b;
        between.max(to_box(b, centre_a) - radius_a).max(to_box(a, centre_b) - radius_b)
    }

    /// A pair that is proved to touch where the robot is now.
    fn touching(&self) -> Option<[u32; 2]> {
        let pairs = self.checker.pairs.iter().map(|pair| pair.objects);
        pairs.filter(|&pair| !(self.far(pair) > 0.0)).find(|&[a, b]| {
            certified::overlap_of(self.posed(a), self.posed(b)).0 == Verdict::Touching(())
        })
    }

    /// The node's pairs that are not proved apart on all of it, from where the robot is now: its middle.
    fn unproved(&mut self, node: &Node) -> Vec<u32> {
        let half = 0.5 * (node.to - node.from) * ROOM;
        // The nearest by its spheres first: its distance tells of most others that they are far.
        let spheres = node
            .pairs
            .iter()
            .map(|&pair| (self.far(self.checker.pairs[pair as usize].objects), pair));
        let mut pairs: Vec<(f64, u32)> = spheres.collect();
        if let Some(first) = (0..pairs.len()).min_by(|&j, &k| pairs[j].0.total_cmp(&pairs[k].0)) {
            pairs.swap(0, first);
        }
        let mut left = Vec::new();
        for (far, pair) in pairs {
            let [speed, off] = self.rates[pair as usize];
            let loosely = far - (half * speed + off);
            if self.suffices(loosely) {
                self.clearance = self.clearance.min(loosely);
            } else if !self.is_proved_along(pair, half) && !self.is_proved(pair, half) {
                left.push(pair);
            }
            if self.hit.is_some_and(|(t, _)| t < node.to && t > node.from) {
                // Only what is before it matters, and all of that is asked for again.
                return node.pairs.clone();
            }
        }
        left
    }

    /// Whether a clearance is so large that a larger one would not count: half of the nearest distance; none
    /// counts before a hit.
    fn suffices(&self, clearance: f64) -> bool {
        clearance > 0.0 && (self.hit.is_some() || clearance >= 0.5 * self.nearest)
    }

    /// Whether one direction proves enough: that of the pair's last gap, or from one middle to the other.
    fn is_proved_along(&mut self, pair: u32, half: f64) -> bool {
        let edge_pair = self.checker.pairs[pair as usize];
        let [a, b] = edge_pair.objects;
        let mut direction = self.directions[pair as usize];
        if direction == DVec3::ZERO {
            let [of_a, of_b] = [a, b].map(|object| &self.at.spheres[object as usize]);
            direction = (of_b.centre - of_a.centre).as_dvec3();
        }
        let Some(gap) = gap_along(self.posed(a), self.posed(b), direction) else { return false };
        let [speed, off] = self.rates[pair as usize];
        let mut proved = gap - (half * speed + off);
        if !self.suffices(proved) {
            proved = proved.max(gap - (self.closing_along(&edge_pair, direction, half) + off));
        }
        let enough = self.suffices(proved);
        if enough {
            self.clearance = self.clearance.min(proved);
        }
        enough
    }

    /// Whether the pair is proved apart for `half` of t to either side of where the robot is now.
    fn is_proved(&mut self, pair: u32, half: f64) -> bool {
        let objects = self.checker.pairs[pair as usize].objects;
        let [a, b] = objects.map(|object| self.posed(object));
        let mut found = in_f64(a, b);
        if !matches!(found, DistanceResult::Apart(_)) {
            found = distance(a, b).0;
        }
        let found = match found {
            DistanceResult::Apart(found) => found,
            // Proved, at the poses that the robot's placing gives.
            DistanceResult::Touching => {
                self.hit = Some((self.at.t, objects));
                return false;
            }
            _ => return false,
        };
        let along = gap_along(a, b, found.normal);
        self.directions[pair as usize] = found.normal;
        let [speed, off] = self.rates[pair as usize];
        self.nearest = self.nearest.min(found.upper() + off);
        let mut proved = found.lower() - (half * speed + off);
        if !self.suffices(proved)
            && let Some(gap) = along
        {
            let closing =
                self.closing_along(&self.checker.pairs[pair as usize], found.normal, half);
            proved = proved.max(gap - (closing + off));
        }
        // Proved, and by as much as a clearance asks for.
        let enough = proved > 0.0 && (self.suffices(proved) || proved >= 0.5 * found.lower());
        if enough {
            self.clearance = self.clearance.min(proved);
        }
        enough
    }

    /// How much of a gap along a direction the pair closes in `half` of t: by its velocity now, and what its
    /// acceleration may add.
    fn closing_along(&self, pair: &EdgePair, direction: DVec3, half: f64) -> f64 {
        let normal = direction / direction.length();
        let [a, b] = pair.objects.map(|object| self.twist(object, pair.common as usize));
        let turning = |twist: &Twist| twist.radius * twist.turn.cross(normal).length();
        let speed = normal.dot(a.velocity - b.velocity).abs() + turning(&a) + turning(&b);
        let change = 0.5 * half * (a.acceleration + b.acceleration);
        // What is cancelled is rounded by parts of the speeds themselves.
        half * (speed + change + 1e-10 * (a.speed + b.speed)) * ROOM
    }

    /// How an object moves now against the frame of the joints that carry both of a pair.
    fn twist(&self, object: u32, common: usize) -> Twist {
        let Some((_, chain)) = &self.checker.movers[object as usize] else {
            return Twist::default();
        };
        let (lengths, sphere) = (&self.lengths[object as usize], &self.at.spheres[object as usize]);
        let middle = sphere.centre.as_dvec3();
        let mut twist = Twist {
            radius: f64::from(sphere.radius),
            acceleration: lengths.acceleration_from(common),
            speed: lengths.speed_from(common),
            ..Twist::default()
        };
        for &joint in &chain.joints[common..] {
            let joint = &self.checker.robot().joints()[joint as usize];
            let JointFrame { rotation, translation } = self.at.frames[joint.child];
            let rate = |by: crate::Drive| self.at.rates[by.value] * by.factor;
            match joint.motion {
                Motion::Fixed => {}
                // Its own turn leaves its axis where it is.
                Motion::Turns { axis, by } => {
                    let turn = rotation * axis * rate(by);
                    twist.turn += turn;
                    twist.velocity += turn.cross(middle - translation);
                }
                Motion::Slides { axis, by } => twist.velocity += rotation * axis * rate(by),
                Motion::Orients { first } => {
                    let rest = self.at.frames[joint.parent].then(&joint.origin).rotation;
                    let turn = rest * self.path.turn(first);
                    twist.turn += turn;
                    twist.velocity += turn.cross(middle - translation);
                }
            }
        }
        twist
    }
}
