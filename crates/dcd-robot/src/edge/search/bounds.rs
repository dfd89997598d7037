//! What is proved of a pair in the interval round where the robot is, without a solver.

use super::super::bounding_volumes::Support;
use super::super::place::{Near, Twist};
use super::super::rows::RowMotion;
use super::super::{EdgePair, Number, ROUNDED_UP, Still};
use super::{BySpheres, EdgeSearch, Gaps};
use glam::DVec3;

/// What coordinates and turned directions lose in f64, relative to the lengths that go into them, with much
/// room.
pub(super) const ROUNDING: f64 = 1e-12;

impl EdgeSearch<'_> {
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
        let (nodes, half, is_even) = (self.nodes, self.half, self.is_even);
        let Number::Moves(number) = self.checker.number(object) else { return };
        let mover = &mut self.movers[number];
        if mover.node == nodes {
            return;
        }
        mover.node = nodes;
        let volumes = &self.checker.volumes[i];
        let pose = &self.at.poses[*part];
        let stretch = 1.0 + 1e-9 + 4.0 * pose.deviation();
        mover.deviation = pose.deviation();
        mover.middle = pose.apply(volumes.whole.centre);
        mover.twist = *self.at.twist(self.checker.robot().parts()[*part].link);
        let near = Near {
            joints: &chain.joints,
            lengths: &mover.lengths,
            before: &mover.before,
            middle: mover.middle,
            radius: volumes.turning * stretch + mover.lengths.deviation + ROUNDING * mover.length,
            twist: mover.twist,
            half,
            is_even,
        };
        mover.local.set(self.checker, &self.at, &near);
    }

    /// Where a moving object's spheres are.
    fn update_cover(&mut self, object: u32) {
        let i = object as usize;
        let mover = self.mover(object);
        if mover.cover_node == self.nodes {
            return;
        }
        let volumes = &self.checker.volumes[i];
        let motion = RowMotion {
            base: self.checker.robot().base.translation,
            turn: mover.twist.turn,
            at_base: mover.twist.at_base,
            half: self.half,
            change: 0.5 * self.half * self.half * mover.local.acceleration[0],
            most: self.half * mover.local.speed[0],
        };
        let placed = volumes.cover.place(self.pose(object), &motion);
        let nodes = self.nodes;
        if let Some(mover) = self.mover_mut(object) {
            (mover.cover, mover.cover_node) = (placed, nodes);
        }
    }

    /// How far two objects may move to each other: against the frame of the joints that carry both.
    pub(super) fn moved(&self, pair: &EdgePair) -> f64 {
        let [a, b] = pair.objects;
        if self.checker.movers[b as usize].is_none() {
            return self.mover(a).local.moved;
        }
        let common = pair.common as usize;
        let speed = |object: u32| self.mover(object).local.speed[common];
        let mut moved = self.half * (speed(a) + speed(b));
        let base = self.checker.robot().base.translation;
        let carrier = self.carrier(pair);
        let [in_a, in_b] = [a, b].map(|object| {
            let mover = self.mover(object);
            let twist = mover.twist.from(&carrier);
            let radius = self.checker.volumes[object as usize].turning + mover.lengths.deviation;
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
            let local = &self.mover(object).local;
            local.acceleration.get(pair.common as usize).copied().unwrap_or(0.0)
        };
        change(pair.objects[0]) + change(pair.objects[1])
    }

    /// What coordinates and velocities of both lose in f64.
    pub(super) fn slack(&self, pair: &EdgePair) -> f64 {
        let places = pair.objects.map(|object| self.place_of(object));
        self.slack_of(pair, places, self.half)
    }

    /// The same with both places known so, in intervals of half that length.
    pub(super) fn slack_of(&self, pair: &EdgePair, [at_a, at_b]: [Still; 2], half: f64) -> f64 {
        let [a, b] = pair.objects.map(|object| self.mover(object));
        let lengths = at_a.length + at_b.length;
        let turned = a.lengths.turned + b.lengths.turned;
        let relative = ROUNDING + turned + 4.0 * (at_a.deviation + at_b.deviation);
        relative * lengths * (1.0 + half * (8.0 + a.turns + b.turns))
    }

    /// What its poses may be off by, twice: where the gap is found, and where it is relied on.
    pub(super) fn off(&self, pair: &EdgePair) -> f64 {
        let of = |object: u32| 2.0 * self.mover(object).lengths.deviation;
        of(pair.objects[0]) + of(pair.objects[1])
    }

    pub(super) fn by_spheres(&mut self, edge_pair: &EdgePair) -> BySpheres {
        let [a, b] = edge_pair.objects;
        let (in_a, in_b) = (a as usize, b as usize);
        let off = self.off(edge_pair) + self.slack(edge_pair);
        let whole_a = self.checker.volumes[in_a].whole.outer;
        let whole_b = self.checker.volumes[in_b].whole.outer;
        let moved = self.moved(edge_pair);
        let middle = self.mover(a).middle;
        let other = self.checker.movers[in_b].is_some();
        if other {
            let between = self.mover(b).middle - middle;
            let margin = between.length() - whole_a - whole_b - moved - off;
            if self.suffices(margin) || !margin.is_finite() {
                return BySpheres { margin, upper: f64::INFINITY, direction: between };
            }
            let [row, other] = [in_a, in_b].map(|i| &self.checker.volumes[i].cover);
            if row.is_one() && other.is_one() {
                let upper = (between.length() - row.inner() - other.inner()).max(0.0) + off;
                return BySpheres { margin, upper, direction: between };
            }
            self.update_cover(a);
            self.update_cover(b);
            let (placed, other_placed) = (&self.mover(a).cover, &self.mover(b).cover);
            let found = row.against_row(placed, (other, other_placed));
            let margin = margin.max(found.least - moved - off);
            return BySpheres { margin, upper: found.upper + off, direction: found.direction };
        }
        let rotation = *self.pose(b).rotation();
        if whole_b == f64::INFINITY {
            // A half-space ends along its normal alone; no solid is round it.
            let support = self.checker.volumes[in_b].support.as_ref();
            let normal = support.and_then(Support::normal).unwrap_or_default();
            let (margin, upper) = (f64::NEG_INFINITY, f64::INFINITY);
            return BySpheres { margin, upper, direction: rotation * -normal };
        }
        let solid = &self.checker.volumes[in_b].solid;
        let local = self.local(b, middle);
        let (far, near) = solid.nearest(local);
        let direction = rotation * (near - local);
        let margin = far - whole_a - moved - off;
        let cover = &self.checker.volumes[in_a].cover;
        if self.suffices(margin) || !far.is_finite() {
            let margin = if far.is_finite() { margin } else { f64::NEG_INFINITY };
            return BySpheres { margin, upper: f64::INFINITY, direction };
        }
        let is_exact = self.checker.volumes[in_b].is_solid;
        let upper = |found: f64| if is_exact { found.max(0.0) + off } else { f64::INFINITY };
        if cover.is_one() {
            return BySpheres { margin, upper: upper(far - cover.inner()), direction };
        }
        self.update_cover(a);
        let pose = self.pose(b);
        let found = cover.against_solid(&self.mover(a).cover, (solid, pose));
        let upper = upper(found.upper);
        BySpheres { margin: margin.max(found.least - off), upper, direction: found.direction }
    }

    /// How near the pair comes at least, by its gap along a direction: at either end as if all kept their velocities,
    /// less what their accelerations may do. `None` where one has no support map.
    pub(super) fn along(&self, edge_pair: &EdgePair, direction: DVec3) -> Option<Gaps> {
        let [a, b] = edge_pair.objects;
        let supports = [a, b].map(|i| self.checker.volumes[i as usize].support.as_ref());
        let ([Some(in_a), Some(in_b)], Some(n)) = (supports, direction.try_normalize()) else {
            return None;
        };
        let base = self.checker.robot().base.translation;
        let carrier = self.carrier(edge_pair);
        // At either end, how far an object reaches towards the other.
        let far = |i: u32, support: &Support, side: f64| {
            let twist = match &self.checker.movers[i as usize] {
                Some(_) => self.mover(i).twist.from(&carrier),
                // Obstacles stand still; what carries both is still too, as seen from it.
                None => Twist::default(),
            };
            let pose = self.pose(i);
            let inverse = pose.rotation().transpose();
            let turned = n.cross(twist.turn);
            // n·(ω × p) is p·(n × ω): the support in a direction that is turned a little.
            let d = [self.half, -self.half].map(|s| (n + s * turned) * side);
            let moved = self.half * side * n.dot(twist.at_base);
            let from_base = pose.translation() - base;
            let [first, last] = support.along(d.map(|d| inverse * d));
            [from_base.dot(d[0]) + first + moved, from_base.dot(d[1]) + last - moved]
        };
        let (far_a, far_b) = (far(a, in_a, 1.0), far(b, in_b, -1.0));
        let (first, last) = (-far_b[0] - far_a[0], -far_b[1] - far_a[1]);
        let change = 0.5 * self.half * self.half * self.change(edge_pair) * ROUNDED_UP;
        let lost = self.slack(edge_pair) + self.off(edge_pair);
        let proved = (first.min(last) - change - lost) * (1.0 - 1e-9);
        // The gap at the middle is no less than the mean of both: the least of what is linear is concave.
        Some(Gaps { proved, middle: 0.5 * (first + last) - lost })
    }
}
