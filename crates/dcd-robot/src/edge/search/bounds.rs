//! What is proved of a pair in the interval round where the robot is, without a solver.

use super::super::place::{Near, Twist};
use super::super::{EdgePair, ROUNDED_UP};
use super::{BySpheres, Gaps, Search};
use glam::DVec3;

/// What coordinates and turned directions lose in f64, relative to the lengths that go into them, with much
/// room.
const ROUNDING: f64 = 1e-12;

impl Search<'_> {
    /// The link that the last joint moves which carries both.
    pub(super) fn common(&self, pair: &EdgePair) -> Option<usize> {
        let (_, chain) = self.checker.movers[pair.objects[0] as usize].as_ref()?;
        let last = *chain.joints.get((pair.common as usize).checked_sub(1)?)?;
        Some(self.checker.robot().joints()[last as usize].child)
    }

    /// Computes how a moving object moves now, if this is not done.
    pub(super) fn update(&mut self, object: u32) {
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
        mover.deviation = pose.deviation();
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
    pub(super) fn moved(&self, pair: &EdgePair) -> f64 {
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
        moved = moved.min(self.half * now * ROUNDED_UP + change);
        moved * ROUNDED_UP + self.slack(pair)
    }

    pub(super) fn carrier(&self, pair: &EdgePair) -> Twist {
        self.common(pair).map_or(Twist::default(), |link| *self.at.twist(link))
    }

    /// How large the accelerations of both are together at most.
    pub(super) fn change(&self, pair: &EdgePair) -> f64 {
        let change = |object: u32| {
            let local = &self.movers[object as usize].local;
            local.acceleration.get(pair.common as usize).copied().unwrap_or(0.0)
        };
        change(pair.objects[0]) + change(pair.objects[1])
    }

    /// What coordinates and velocities of both lose in f64.
    pub(super) fn slack(&self, pair: &EdgePair) -> f64 {
        let [a, b] = pair.objects.map(|object| &self.movers[object as usize]);
        let lengths = a.length + b.length;
        let relative = ROUNDING + 4.0 * (a.deviation + b.deviation);
        relative * lengths * (1.0 + self.half * (8.0 + a.turns + b.turns))
    }

    pub(super) fn by_spheres(&mut self, pair: u32, edge_pair: &EdgePair) -> BySpheres {
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
                return BySpheres { margin, upper: f64::INFINITY, direction: between };
            }
            let (covered, upper, direction) = self.between_covers(a, b);
            let margin = margin.max(covered - moved - off);
            return BySpheres { margin, upper: upper + off, direction };
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
            return BySpheres { margin, upper: f64::INFINITY, direction };
        }
        self.update_cover(a);
        let mover = &self.movers[in_a];
        let base = self.checker.robot().base.translation;
        let turn = mover.twist.turn.length();
        let change = 0.5 * self.half * self.half * mover.local.acceleration[0];
        let most = self.half * mover.local.speed[0];
        let inverse = rotation.transpose();
        let place = self.pose(b).translation();
        let (mut least, mut upper, mut direction) = (f64::INFINITY, f64::INFINITY, direction);
        for (sphere, &centre) in cover.iter().zip(&mover.cover) {
            let local = inverse * (centre - place);
            let (far, near) = solid.nearest(local);
            if sphere.inner > 0.0 {
                upper = upper.min(far - sphere.inner);
            }
            let now = mover.twist.of(centre - base).length() + sphere.outer * turn;
            let moved = (self.half * now * ROUNDED_UP + change).min(most) * ROUNDED_UP;
            let margin = far - sphere.outer - moved;
            if margin < least {
                (least, direction) = (margin, near - local);
            }
        }
        if least < f64::INFINITY && direction != DVec3::ZERO {
            direction = rotation * direction;
        }
        let is_exact = self.checker.outlines[in_b].is_solid;
        let upper = if is_exact { upper.max(0.0) + off } else { f64::INFINITY };
        BySpheres { margin: margin.max(least - off), upper, direction }
    }

    /// How far the spheres of two moving objects are from each other, and those inside of them, and the direction
    /// there.
    fn between_covers(&mut self, a: u32, b: u32) -> (f64, f64, DVec3) {
        self.update_cover(a);
        self.update_cover(b);
        let spheres = |i: u32| {
            let (outline, mover) = (&self.checker.outlines[i as usize], &self.movers[i as usize]);
            let cover = outline.cover.iter().zip(&mover.cover).map(|(s, &c)| (c, s));
            let alone = outline.cover.is_empty().then_some((mover.middle, &outline.whole));
            cover.chain(alone)
        };
        let whole = (self.movers[b as usize].middle, self.checker.outlines[b as usize].whole.outer);
        let (mut least, mut upper) = (f64::INFINITY, f64::INFINITY);
        let mut direction = whole.0 - self.movers[a as usize].middle;
        for (centre, one) in spheres(a) {
            if centre.distance(whole.0) - one.outer - whole.1 >= least {
                continue;
            }
            for (other_centre, other) in spheres(b) {
                let between = other_centre - centre;
                let length = between.length();
                let far = length - one.outer - other.outer;
                if far < least {
                    (least, direction) = (far, between);
                }
                if one.inner > 0.0 && other.inner > 0.0 {
                    upper = upper.min((length - one.inner - other.inner).max(0.0));
                }
            }
        }
        (least, upper, direction)
    }

    /// How near the pair comes at least, by its gap along a direction: at either end as if all kept their velocities,
    /// less what their accelerations may do. `None` where one has no support map.
    pub(super) fn along(&self, pair: u32, edge_pair: &EdgePair, direction: DVec3) -> Option<Gaps> {
        let [a, b] = edge_pair.objects;
        let supports = [a, b].map(|i| self.checker.outlines[i as usize].support.as_ref());
        let ([Some(in_a), Some(in_b)], Some(n)) = (supports, direction.try_normalize()) else {
            return None;
        };
        let base = self.checker.robot().base.translation;
        let carrier = self.carrier(edge_pair);
        // Obstacles stand still; what carries both is still too, as seen from it.
        let twist_of = |i: u32| match &self.checker.movers[i as usize] {
            Some(_) => self.movers[i as usize].twist.from(&carrier),
            None => Twist::default(),
        };
        let far =
            |i: u32, support: &super::super::outline::Support, twist: &Twist, side: f64, s: f64| {
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
            return Some(Gaps { proved: first.min(0.0), middle: 0.0 });
        }
        let last = gap(-self.half);
        let change = 0.5 * self.half * self.half * self.change(edge_pair) * ROUNDED_UP;
        let lost = self.slack(edge_pair) + self.off[pair as usize];
        let proved = (first.min(last) - change - lost) * (1.0 - 1e-9);
        // The gap at the middle is no less than the mean of both: the least of what is linear is concave.
        Some(Gaps { proved, middle: 0.5 * (first + last) - lost })
    }
}
