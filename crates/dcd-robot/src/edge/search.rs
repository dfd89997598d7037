//! The search through a path's intervals.

use super::path::JointPath;
use super::place::{Local, Near, Place, Twist};
use super::reach::Lengths;
use super::{Before, Edge, EdgeAnswer, EdgeChecker, EdgePair, EdgeReason, ROOM};
use crate::RobotError;
use dcd_exec::Par;
use dcd_geom::Pose;
use dcd_gjk::PosedShape;
use dcd_gjk::distance::{DistanceResult, distance, in_f64};
use glam::DVec3;
use std::ops::Range;

/// An interval is not halved below this length. No unit. Smaller: more intervals where shapes graze each
/// other. Larger: gaps below a micrometre stay undecided.
const SHORTEST: f64 = 1.0 / (1u64 << 40) as f64;

/// How near to a hit the path before it is proved free, if it is. No unit. Smaller: more intervals before
/// each hit (at 2⁻¹² twice as many). Larger: `free_until` ends earlier.
const BEFORE_A_HIT: f64 = 1.0 / (1u64 << 8) as f64;

/// The states of a path that are looked at before any interval: in sixteenths, all at once.
const SAMPLES: [u8; 16] = [0, 16, 8, 4, 12, 2, 6, 10, 14, 1, 3, 5, 7, 9, 11, 13];

/// What coordinates and turned directions lose in f64, relative to the lengths that go into them, with much
/// room.
const ROUNDING: f64 = 1e-12;

pub(super) struct Search<'a> {
    checker: &'a EdgeChecker,
    path: &'a JointPath,
    budget: usize,
    before: Before,
    /// For each object that moves what bounds its motion.
    movers: Vec<Mover>,
    /// For each pair what its poses may be off by, twice: where the gap is found, and where it is relied on.
    off: Vec<f64>,
    /// For each pair the direction in which its gap was last found, in the frame of the joints that carry both;
    /// zero before.
    directions: Vec<DVec3>,
    /// A distance that some pair has somewhere on the path: what comes no nearer than half of it is proved.
    nearest: f64,
    clearance: f64,
    nodes: usize,
    hit: Option<(f64, [u32; 2])>,
    /// The first interval that is left, with a pair of it.
    left: Option<([f64; 2], [u32; 2], EdgeReason)>,
    at: Place,
    half: f64,
    /// The pairs of all nodes on the stack.
    open: Vec<u32>,
    is_even: bool,
}

/// An object that moves; empty for obstacles.
#[derive(Default)]
struct Mover {
    lengths: Lengths,
    /// How fast the joints before each turn together at most, and how fast that changes.
    before: Vec<[f64; 2]>,
    /// How far from the base any point of it is.
    length: f64,
    /// The node for which the rest is computed.
    node: usize,
    local: Local,
    middle: DVec3,
    twist: Twist,
    /// The spheres' middles, and the node that they are of.
    cover: Vec<DVec3>,
    cover_node: usize,
}

struct Node {
    from: f64,
    to: f64,
    pairs: Range<usize>,
}

/// What the spheres of a pair prove.
struct BySpheres {
    /// The pair comes no nearer than that in the interval.
    margin: f64,
    /// From one to the other where they are nearest.
    direction: DVec3,
}

impl<'a> Search<'a> {
    pub(super) fn new(
        checker: &'a EdgeChecker,
        path: &'a JointPath,
        (budget, before): (usize, Before),
    ) -> Self {
        let extents = path.extents(checker.robot());
        let is_even = matches!(path, JointPath::Straight(_));
        let movers = checker.movers.iter().map(|mover| {
            let Some((_, chain)) = mover else { return Mover::default() };
            let lengths = chain.lengths(&extents);
            let (mut turns, mut changes) = (0.0, 0.0);
            let before = lengths.turn.iter().map(|&turn| {
                let before = [turns, changes];
                changes += turn * turns * ROOM;
                turns += turn * ROOM;
                before
            });
            Mover { before: before.collect(), length: lengths.length, lengths, ..Mover::default() }
        });
        let movers: Vec<Mover> = movers.collect();
        let off = checker.pairs.iter().map(|pair| {
            let of = |object: u32| 2.0 * movers[object as usize].lengths.deviation;
            of(pair.objects[0]) + of(pair.objects[1])
        });
        Self {
            off: off.collect(),
            movers,
            checker,
            path,
            budget,
            before,
            directions: vec![DVec3::ZERO; checker.pairs.len()],
            nearest: f64::INFINITY,
            clearance: f64::INFINITY,
            nodes: 0,
            hit: None,
            left: None,
            at: Place::default(),
            half: 0.0,
            open: Vec::new(),
            is_even,
        }
    }

    pub(super) fn run(mut self) -> Result<Edge, RobotError> {
        self.sample()?;
        if self.hit.is_some() && self.before == Before::Anything {
            return Ok(self.edge());
        }
        self.open.extend(0..self.checker.pairs.len() as u32);
        let end = self.hit.map_or(1.0, |(t, _)| t);
        let mut stack = Vec::new();
        if end > 0.0 {
            stack.push(Node { from: 0.0, to: end, pairs: 0..self.open.len() });
        }
        while let Some(node) = stack.pop() {
            // What is beyond a hit tells nothing more, nor is anything left to find before it.
            if let Some((t, _)) = self.hit
                && (node.from >= t || self.left.is_some() || self.before == Before::Anything)
            {
                continue;
            }
            if let Some(reason) = self.ends(&node) {
                self.leave(&node, reason);
                continue;
            }
            self.nodes += 1;
            let middle = 0.5 * (node.from + node.to);
            self.at.go_to(self.checker, self.path, middle)?;
            self.half = 0.5 * (node.to - node.from) * ROOM;
            self.open.truncate(node.pairs.end);
            let pairs = self.unproved(&node);
            if !pairs.is_empty() {
                stack.push(Node { from: middle, to: node.to, pairs: pairs.clone() });
                stack.push(Node { from: node.from, to: middle, pairs });
            }
        }
        Ok(self.edge())
    }

    /// Looks for a hit at a few states.
    fn sample(&mut self) -> Result<(), RobotError> {
        let Some(states) = &self.checker.states else { return Ok(()) };
        let sample = |k: u8| {
            let mut state = Vec::new();
            self.path.state_at(self.checker.robot(), f64::from(k) / 16.0, &mut state);
            state
        };
        let sampled = SAMPLES.map(sample);
        let found = states.first(&sampled, Par::Serial)?;
        let touching = SAMPLES.iter().zip(&found).filter_map(|(&k, found)| {
            let hit = found.as_ref().filter(|hit| hit.touches())?;
            Some((k, hit.pair))
        });
        if let Some((k, pair)) = touching.min_by_key(|&(k, _)| k) {
            self.hit = Some((f64::from(k) / 16.0, self.checker.in_order([pair.i, pair.j])));
        }
        Ok(())
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
        let pair = self.open.get(node.pairs.start);
        let pair = pair.map(|&pair| self.checker.pairs[pair as usize].objects);
        // The stack gives them in the order of t.
        if let (None, Some(pair)) = (&self.left, pair) {
            self.left = Some(([node.from, node.to], pair, reason));
        }
    }

    fn edge(self) -> Edge {
        let nodes = self.nodes;
        let left_from = self.left.map_or(1.0, |([from, _], ..)| from);
        let (answer, free_until) = match (self.hit, self.left) {
            (Some((t, pair)), _) if self.before == Before::Anything => {
                (EdgeAnswer::Hit { t, pair }, 0.0)
            }
            (Some((t, pair)), _) => (EdgeAnswer::Hit { t, pair }, left_from.min(t)),
            (None, Some((t, pair, reason))) => (EdgeAnswer::Undecided { t, pair, reason }, t[0]),
            (None, None) => (EdgeAnswer::Free { clearance: self.clearance }, 1.0),
        };
        Edge { answer, free_until, nodes }
    }

    fn pose(&self, object: u32) -> &Pose {
        let i = object as usize;
        match &self.checker.movers[i] {
            Some((part, _)) => &self.at.poses[*part],
            None => &self.checker.cell.scene().poses()[i],
        }
    }

    fn posed(&self, object: u32) -> PosedShape<'_> {
        let shape = self.checker.cell.scene().shape(object as usize);
        PosedShape { shape, pose: self.pose(object) }
    }

    /// The node's pairs that are not proved apart on all of it, from where the robot is now, its middle: where they
    /// are among all open ones.
    fn unproved(&mut self, node: &Node) -> Range<usize> {
        let from = self.open.len();
        // Some distance first: it tells of most others that they are far.
        if self.nearest == f64::INFINITY && self.hit.is_none() {
            let far = |&k: &usize| self.far(self.open[k]);
            let nearest = node.pairs.clone().min_by(|j, k| far(j).total_cmp(&far(k)));
            if let Some(k) = nearest {
                self.open.swap(node.pairs.start, k);
            }
        }
        for k in node.pairs.clone() {
            let pair = self.open[k];
            if !self.is_proved(pair) {
                self.open.push(pair);
            }
            if self.hit.is_some_and(|(t, _)| t < node.to && t > node.from) {
                // Only what is before it matters, and all of that is asked for again.
                self.open.truncate(from);
                return node.pairs.clone();
            }
        }
        from..self.open.len()
    }

    /// About how far two objects are, for an order.
    fn far(&self, pair: u32) -> f64 {
        let [a, b] = self.checker.pairs[pair as usize].objects;
        let [in_a, in_b] = [a, b].map(|object| {
            let whole = &self.checker.outlines[object as usize].whole;
            (self.pose(object).apply(whole.centre), whole.outer)
        });
        if self.checker.movers[b as usize].is_some() {
            return in_a.0.distance(in_b.0) - in_a.1 - in_b.1;
        }
        let local = self.local(b, in_a.0);
        self.checker.outlines[b as usize].solid.nearest(local).0 - in_a.1
    }

    /// A point in an object's own frame.
    fn local(&self, object: u32, point: DVec3) -> DVec3 {
        let pose = self.pose(object);
        pose.rotation().transpose() * (point - pose.translation())
    }

    /// Whether a clearance is so large that a larger one would not count: half of the nearest distance; none
    /// counts before a hit.
    fn suffices(&self, clearance: f64) -> bool {
        clearance > 0.0 && (self.hit.is_some() || clearance >= 0.5 * self.nearest)
    }

    fn note(&mut self, clearance: f64) -> bool {
        self.clearance = self.clearance.min(clearance);
        true
    }

    /// Whether the pair is proved apart for half of the node to either side of where the robot is now, by as much as a
    /// clearance asks for.
    fn is_proved(&mut self, pair: u32) -> bool {
        let edge_pair = self.checker.pairs[pair as usize];
        let [a, b] = edge_pair.objects;
        self.update(a);
        self.update(b);
        let found = self.by_spheres(pair, &edge_pair);
        if self.suffices(found.margin) {
            return self.note(found.margin);
        }
        let common = self.common(&edge_pair);
        let carried = common.map(|link| *self.link_pose(link));
        let last = self.directions[pair as usize];
        let last = carried.map_or(last, |rotation| rotation * last);
        for direction in [last, found.direction] {
            let proved = self.along(pair, &edge_pair, direction);
            if self.suffices(proved) {
                self.keep(pair, carried, direction);
                return self.note(proved);
            }
        }
        self.is_proved_by_distance(pair, carried)
    }

    fn keep(&mut self, pair: u32, carried: Option<glam::DMat3>, direction: DVec3) {
        let own = carried.map_or(direction, |rotation| rotation.transpose() * direction);
        self.directions[pair as usize] = own;
    }

    fn is_proved_by_distance(&mut self, pair: u32, carried: Option<glam::DMat3>) -> bool {
        let edge_pair = self.checker.pairs[pair as usize];
        let [a, b] = edge_pair.objects.map(|object| self.posed(object));
        let mut found = in_f64(a, b);
        if !matches!(found, DistanceResult::Apart(_)) {
            found = distance(a, b).0;
        }
        let found = match found {
            DistanceResult::Apart(found) => found,
            // Proved, at the poses that the robot's placing gives.
            DistanceResult::Touching => {
                self.hit = Some((self.at.t, edge_pair.objects));
                return false;
            }
            _ => return false,
        };
        self.keep(pair, carried, found.normal);
        let off = self.off[pair as usize];
        self.nearest = self.nearest.min(found.upper() + off);
        let mut proved = found.lower() - (self.moved(&edge_pair) + off);
        if !self.suffices(proved) {
            proved = proved.max(self.along(pair, &edge_pair, found.normal));
        }
        // Proved, and by as much as a clearance asks for.
        let enough = proved > 0.0 && (self.suffices(proved) || proved >= 0.5 * found.lower());
        if enough { self.note(proved) } else { false }
    }

    /// The link that the last joint moves which carries both.
    fn common(&self, pair: &EdgePair) -> Option<usize> {
        let (_, chain) = self.checker.movers[pair.objects[0] as usize].as_ref()?;
        let last = *chain.joints.get((pair.common as usize).checked_sub(1)?)?;
        Some(self.checker.robot().joints()[last as usize].child)
    }

    fn link_pose(&self, link: usize) -> &glam::DMat3 {
        self.at.rotation(link)
    }

    /// Computes how a moving object moves now, if this is not done.
    fn update(&mut self, object: u32) {
        let i = object as usize;
        let Some((part, chain)) = &self.checker.movers[i] else { return };
        let mover = &mut self.movers[i];
        if mover.node == self.nodes {
            return;
        }
        mover.node = self.nodes;
        let whole = &self.checker.outlines[i].whole;
        let pose = &self.at.poses[*part];
        let stretch = 1.0 + 1e-9 + 4.0 * pose.deviation();
        mover.middle = pose.apply(whole.centre);
        mover.twist = *self.at.twist(self.checker.robot().parts()[*part].link);
        let near = Near {
            joints: &chain.joints,
            lengths: &mover.lengths,
            before: &mover.before,
            middle: mover.middle,
            radius: whole.outer * stretch + mover.lengths.deviation + ROUNDING * mover.length,
            twist: mover.twist,
            half: self.half,
            is_even: self.is_even,
        };
        mover.local.set(self.checker, &self.at, &near);
    }

    /// The middles of an object's spheres.
    fn update_cover(&mut self, object: u32) {
        let i = object as usize;
        if self.movers[i].cover_node == self.nodes {
            return;
        }
        let mut cover = std::mem::take(&mut self.movers[i].cover);
        cover.clear();
        let pose = self.pose(object);
        cover.extend(self.checker.outlines[i].cover.iter().map(|s| pose.apply(s.centre)));
        let mover = &mut self.movers[i];
        (mover.cover, mover.cover_node) = (cover, self.nodes);
    }

    /// How far two objects may move to each other: against the frame of the joints that carry both.
    fn moved(&self, pair: &EdgePair) -> f64 {
        let [a, b] = pair.objects.map(|object| object as usize);
        if self.checker.movers[b].is_none() {
            return self.movers[a].local.moved;
        }
        let common = pair.common as usize;
        let speed = |i: usize| self.movers[i].local.speed[common];
        let mut moved = self.half * (speed(a) + speed(b));
        let base = self.checker.robot().base.translation;
        let carrier = self.carrier(pair);
        let [in_a, in_b] = [a, b].map(|i| {
            let mover = &self.movers[i];
            let twist = mover.twist.from(&carrier);
            let radius = self.checker.outlines[i].whole.outer;
            (twist.of(mover.middle - base), radius * twist.turn.length())
        });
        let now = (in_a.0 - in_b.0).length() + in_a.1 + in_b.1;
        let change = 0.5 * self.half * self.half * self.change(pair);
        moved = moved.min(self.half * now * ROOM + change);
        moved * ROOM + self.slack(pair)
    }

    fn carrier(&self, pair: &EdgePair) -> Twist {
        self.common(pair).map_or(Twist::default(), |link| *self.at.twist(link))
    }

    /// How large the accelerations of both are together at most.
    fn change(&self, pair: &EdgePair) -> f64 {
        let change = |object: u32| {
            let local = &self.movers[object as usize].local;
            local.acceleration.get(pair.common as usize).copied().unwrap_or(0.0)
        };
        change(pair.objects[0]) + change(pair.objects[1])
    }

    /// What coordinates and velocities of both lose in f64.
    fn slack(&self, pair: &EdgePair) -> f64 {
        let of = |object: u32| {
            let mover = &self.movers[object as usize];
            let pose = self.pose(object);
            let own = self.checker.outlines[object as usize].reach + pose.translation().length();
            let turns: f64 = mover.lengths.turn.iter().sum();
            (mover.length + own, turns, pose.deviation())
        };
        let [a, b] = pair.objects.map(of);
        let lengths = a.0 + b.0;
        (ROUNDING + 4.0 * (a.2 + b.2)) * lengths * (1.0 + self.half * (8.0 + a.1 + b.1))
    }

    fn by_spheres(&mut self, pair: u32, edge_pair: &EdgePair) -> BySpheres {
        let [a, b] = edge_pair.objects;
        let (in_a, in_b) = (a as usize, b as usize);
        let off = self.off[pair as usize] + self.slack(edge_pair);
        let whole_a = self.checker.outlines[in_a].whole.outer;
        let whole_b = self.checker.outlines[in_b].whole.outer;
        let moved = self.moved(edge_pair);
        let middle = self.movers[in_a].middle;
        let other = self.checker.movers[in_b].is_some();
        if other {
            let between = self.movers[in_b].middle - middle;
            let margin = between.length() - whole_a - whole_b - moved - off;
            if self.suffices(margin) || !margin.is_finite() {
                return BySpheres { margin, direction: between };
            }
            let (covered, direction) = self.between_covers(a, b);
            return BySpheres { margin: margin.max(covered - moved - off), direction };
        }
        let solid = &self.checker.outlines[in_b].solid;
        let rotation = *self.pose(b).rotation();
        let local = self.local(b, middle);
        let (far, near) = solid.nearest(local);
        let direction = rotation * (near - local);
        let margin = far - whole_a - moved - off;
        let cover = &self.checker.outlines[in_a].cover;
        if self.suffices(margin) || cover.is_empty() || !far.is_finite() {
            let margin = if far.is_finite() { margin } else { f64::NEG_INFINITY };
            return BySpheres { margin, direction };
        }
        self.update_cover(a);
        let mover = &self.movers[in_a];
        let base = self.checker.robot().base.translation;
        let turn = mover.twist.turn.length();
        let change = 0.5 * self.half * self.half * mover.local.acceleration[0];
        let most = self.half * mover.local.speed[0];
        let inverse = rotation.transpose();
        let place = self.pose(b).translation();
        let (mut least, mut direction) = (f64::INFINITY, direction);
        for (sphere, &centre) in cover.iter().zip(&mover.cover) {
            let local = inverse * (centre - place);
            let (far, near) = solid.nearest(local);
            let now = mover.twist.of(centre - base).length() + sphere.outer * turn;
            let moved = (self.half * now * ROOM + change).min(most) * ROOM;
            let margin = far - sphere.outer - moved;
            if margin < least {
                (least, direction) = (margin, near - local);
            }
        }
        if least < f64::INFINITY && direction != DVec3::ZERO {
            direction = rotation * direction;
        }
        BySpheres { margin: margin.max(least - off), direction }
    }

    /// How far the spheres of two moving objects are from each other, and the direction there.
    fn between_covers(&mut self, a: u32, b: u32) -> (f64, DVec3) {
        self.update_cover(a);
        self.update_cover(b);
        let spheres = |i: u32| {
            let (outline, mover) = (&self.checker.outlines[i as usize], &self.movers[i as usize]);
            let cover = outline.cover.iter().zip(&mover.cover).map(|(s, &c)| (c, s.outer));
            let alone = outline.cover.is_empty().then_some((mover.middle, outline.whole.outer));
            cover.chain(alone)
        };
        let whole = (self.movers[b as usize].middle, self.checker.outlines[b as usize].whole.outer);
        let (mut least, mut direction) = (f64::INFINITY, whole.0 - self.movers[a as usize].middle);
        for (centre, radius) in spheres(a) {
            if centre.distance(whole.0) - radius - whole.1 >= least {
                continue;
            }
            for (other, outer) in spheres(b) {
                let between = other - centre;
                let far = between.length() - radius - outer;
                if far < least {
                    (least, direction) = (far, between);
                }
            }
        }
        (least, direction)
    }

    /// How near the pair comes at least, by its gap along a direction: at either end as if all kept their velocities,
    /// less what their accelerations may do. −∞ where one has no support map.
    fn along(&self, pair: u32, edge_pair: &EdgePair, direction: DVec3) -> f64 {
        let [a, b] = edge_pair.objects;
        let supports = [a, b].map(|i| self.checker.outlines[i as usize].support.as_ref());
        let ([Some(in_a), Some(in_b)], Some(n)) = (supports, direction.try_normalize()) else {
            return f64::NEG_INFINITY;
        };
        let base = self.checker.robot().base.translation;
        let carrier = self.carrier(edge_pair);
        // Obstacles stand still; what carries both is still too, as seen from it.
        let twist_of = |i: u32| match &self.checker.movers[i as usize] {
            Some(_) => self.movers[i as usize].twist.from(&carrier),
            None => Twist::default(),
        };
        let far = |i: u32, support: &super::outline::Support, twist: &Twist, side: f64, s: f64| {
            let pose = self.pose(i);
            // n·(ω × p) is p·(n × ω): the support in a direction that is turned a little.
            let d = (n + s * n.cross(twist.turn)) * side;
            let local = pose.rotation().transpose() * d;
            let moved = s * side * n.dot(twist.at_base);
            (pose.translation() - base).dot(d) + support.along(local) + moved
        };
        let (twist_a, twist_b) = (twist_of(a), twist_of(b));
        let gap = |s: f64| -far(b, in_b, &twist_b, -1.0, s) - far(a, in_a, &twist_a, 1.0, s);
        let first = gap(self.half);
        if !(first > 0.0) {
            return first;
        }
        let least = first.min(gap(-self.half));
        let change = 0.5 * self.half * self.half * self.change(edge_pair) * ROOM;
        let rounding = self.slack(edge_pair) * 0.1;
        (least - change - rounding - self.off[pair as usize]) * (1.0 - 1e-9)
    }
}
