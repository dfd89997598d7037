//! Where two cylinders or cones are nearest.
//!
//! The point of such a shape nearest to a given one has a formula. So two nearest points, where either lies on a rim, are a
//! root in one angle; on two sides, or on a disc, they are known at once. Which of these it is, and where the angle's search
//! begins, a few projections to and fro say. What comes out is a proposal: the pair's own bounds prove it.

use super::curved_points::CurvedPoints;
use super::profile::{Foot, Part, Profile};
use crate::PosedShape;
use crate::mesh::Limited;
use dcd_geom::Shape;
use dcd_geom::glam::{DMat3, DVec2, DVec3};

/// How often features are tried, and how often an angle is corrected, at most: two and four are usual. Fewer: points that the
/// bounds refuse.
const TRIES: usize = 6;
const CORRECTIONS: usize = 8;

/// The square of the sine of two axes below which sides count as parallel, and have no one place where they cross. No unit.
/// Larger: more pairs for the search. Smaller: places that rounding has moved.
const PARALLEL: f64 = 1e-20;

/// How far the line between two points may be turned from the nearest ones', where a bound of millionths of the size is
/// enough, and where all that f64 has is asked for. Radians: the bounds lose about its square. Larger: points that the bounds
/// refuse. Smaller: corrections for nothing.
const TURNED: f64 = 5e-4;
const SHARPLY_TURNED: f64 = 1e-8;

/// The largest correction of an angle that is taken, radians: Newton's method leads nowhere from afar. Larger: steps that
/// lead away. Smaller: more of them.
const FARTHEST: f64 = 0.5;

/// The other shape's place in the frame of one.
#[derive(Clone, Copy)]
struct Frame {
    turn: DMat3,
    delta: DVec3,
}

impl Frame {
    /// A point of the other's frame in this one.
    #[inline(always)]
    fn seen_by_me(&self, point: DVec3) -> DVec3 {
        self.turn * point + self.delta
    }

    /// A point of this frame in the other's.
    #[inline(always)]
    fn seen_by_other(&self, point: DVec3) -> DVec3 {
        self.turned_for_other(point - self.delta)
    }

    /// A direction of this frame in the other's.
    #[inline(always)]
    fn turned_for_other(&self, v: DVec3) -> DVec3 {
        DVec3::new(self.turn.x_axis.dot(v), self.turn.y_axis.dot(v), self.turn.z_axis.dot(v))
    }

    /// The same seen from the other.
    #[inline(always)]
    fn mirrored(&self) -> Self {
        Self { turn: self.turn.transpose(), delta: -self.turned_for_other(self.delta) }
    }
}

/// One curved shape and another, in the frame of the one.
struct Two {
    me: Profile,
    other: Profile,
    frame: Frame,
    /// How far the line between the points may be turned, radians.
    settled: f64,
    /// Whether the one is the second of the pair.
    swapped: bool,
}

/// What is known of the distance of two cylinders or cones, by points of which the bounds are at most `gap` of the pair's size
/// apart, or what f64 leaves; beyond `far`, metres, no more than that. `None` of other kinds, where the cores seem to meet, and
/// where such points are not found.
pub(crate) fn distance([gap, far]: [f64; 2], [a, b]: [PosedShape<'_>; 2]) -> Option<Limited> {
    let (Shape::Curved(in_a), Shape::Curved(in_b)) = (a.shape, b.shape) else { return None };
    let points = CurvedPoints::of([in_a, in_b], [a.pose, b.pose])?;
    let back = a.pose.rotation().transpose();
    let delta = back * (b.pose.translation() - a.pose.translation());
    let frame = Frame { turn: back * *b.pose.rotation(), delta };
    let (me, other) = (Profile::of(in_a)?, Profile::of(in_b)?);
    let settled = if gap > 0.0 { TURNED } else { SHARPLY_TURNED };
    let is_beyond = |[of_a, of_b]: [DVec3; 2]| points.between(of_a, of_b).are_beyond(&points, far);
    match (Two { me, other, frame, settled, swapped: false }).nearest(far, is_beyond)? {
        Nearest::Beyond => Some(Limited::Beyond),
        Nearest::Points([of_a, of_b]) => points.between(of_a, of_b).distance(&points, [gap, far]),
    }
}

/// Points of both cores, each in its own frame.
enum Nearest {
    /// They prove more than the limit.
    Beyond,
    /// Perhaps the nearest.
    Points([DVec3; 2]),
}

impl Two {
    fn nearest(mut self, far: f64, are_beyond: impl Fn([DVec3; 2]) -> bool) -> Option<Nearest> {
        let mut on_me = self.me.foot(self.frame.delta).point;
        let mut on_other = self.other.foot(self.frame.seen_by_other(on_me)).point;
        for tried in 0..TRIES {
            // That point of the other is its nearest to this one of mine; here the converse is seen.
            let there = self.frame.seen_by_me(on_other);
            let foot = self.me.foot(there);
            if foot.part == Part::Inside {
                return None;
            }
            let moved = foot.point.distance_squared(on_me);
            let squared = there.distance_squared(foot.point);
            if moved <= (self.settled * self.settled) * squared {
                return Some(Nearest::Points(self.in_order([on_me, on_other])));
            }
            if tried == 0 && squared > far * far && are_beyond([foot.point, on_other]) {
                return Some(Nearest::Beyond);
            }
            let foot_of_other = self.other.foot(self.frame.seen_by_other(foot.point));
            [on_me, on_other] = self.solved(&foot, &foot_of_other)?;
        }
        None
    }

    fn in_order(&self, [on_me, on_other]: [DVec3; 2]) -> [DVec3; 2] {
        if self.swapped { [on_other, on_me] } else { [on_me, on_other] }
    }

    /// The nearest points of the features that two points are on, each in its own frame, or points from which to go on. It may
    /// exchange the two.
    fn solved(&mut self, on_me: &Foot, on_other: &Foot) -> Option<[DVec3; 2]> {
        match [on_me.part, on_other.part] {
            [Part::Inside, _] | [_, Part::Inside] => None,
            [Part::Side, Part::Side] => match self.on_sides()? {
                OnSides::Inside(points) => Some(points),
                OnSides::BeyondMine(up) => self.on_rim(on_me.outward, up),
                OnSides::BeyondOther(up) => {
                    self.exchange();
                    self.on_rim(on_other.outward, up)
                }
            },
            [Part::Side, _] => {
                self.exchange();
                self.on_feature(on_other)
            }
            _ => self.on_feature(on_me),
        }
    }

    fn exchange(&mut self) {
        std::mem::swap(&mut self.me, &mut self.other);
        self.frame = self.frame.mirrored();
        self.swapped = !self.swapped;
    }

    /// Of a disc or a rim of mine.
    fn on_feature(&self, on_me: &Foot) -> Option<[DVec3; 2]> {
        match on_me.part {
            Part::Disc(up) => self.on_disc(up),
            Part::Rim(up) => self.on_rim(on_me.outward, up),
            Part::Side | Part::Inside => None,
        }
    }

    /// The direction from my side to the other's, where these are nearest, in my frame and of unit length; `None` of parallel
    /// ones, or nearly. Its products with both axes are those of the sides' normals.
    fn normal_of_sides(&self) -> Option<DVec3> {
        let axis = self.frame.turn.z_axis;
        let sine = axis.x * axis.x + axis.y * axis.y;
        if !(sine > PARALLEL) {
            return None;
        }
        let (mine, others) = (self.me.rise(), -self.other.rise());
        let along_mine = (mine - axis.z * others) / sine;
        let along_other = (others - axis.z * mine) / sine;
        // Where no direction is square to both, what is nearest to one leads to a rim.
        let left = (1.0 - (along_mine * mine + along_other * others)).max(0.0);
        let across = DVec3::new(-axis.y, axis.x, 0.0);
        let across = if across.dot(self.frame.delta) < 0.0 { -across } else { across };
        Some(DVec3::Z * along_mine + axis * along_other + across * (left / sine).sqrt())
    }

    /// Where the two sides are nearest: where the lines up them cross that face each other.
    fn on_sides(&self) -> Option<OnSides> {
        let Self { me, other, frame, .. } = self;
        let normal = self.normal_of_sides()?;
        let outward = normal.truncate().try_normalize()?;
        let others_outward = frame.turned_for_other(-normal).truncate().try_normalize()?;
        let up = me.up_the_side(outward);
        let others_up = frame.turn * other.up_the_side(others_outward);
        let between =
            me.on_side(outward, 0.0) - frame.seen_by_me(other.on_side(others_outward, 0.0));
        let [uu, uv, vv] = [up.dot(up), up.dot(others_up), others_up.dot(others_up)];
        let (along, along_others) = (up.dot(between), others_up.dot(between));
        let divisor = uu * vv - uv * uv;
        let share = (uv * along_others - vv * along) / divisor;
        let others_share = (uu * along_others - uv * along) / divisor;
        let side = 0.0..=1.0;
        Some(if !side.contains(&share) {
            OnSides::BeyondMine(usize::from(share > 0.5))
        } else if !side.contains(&others_share) {
            OnSides::BeyondOther(usize::from(others_share > 0.5))
        } else {
            let points = [me.on_side(outward, share), other.on_side(others_outward, others_share)];
            OnSides::Inside(points)
        })
    }

    /// The other's point nearest to the plane of a disc of mine and the point below it; that of the rim where it is not above
    /// the disc.
    fn on_disc(&self, up: usize) -> Option<[DVec3; 2]> {
        let Self { me, other, frame, .. } = self;
        let outward = if up == 1 { DVec3::Z } else { DVec3::NEG_Z };
        let point = other.farthest(frame.turned_for_other(-outward));
        let there = frame.seen_by_me(point).truncate();
        if there.length_squared() <= me.radii[up] * me.radii[up] {
            return Some([there.extend(me.heights[up]), point]);
        }
        self.on_rim(there.try_normalize()?, up)
    }

    /// The point of a rim of mine that is nearest to the other, from one in a direction from the axis, and the other's.
    fn on_rim(&self, mut outward: DVec2, up: usize) -> Option<[DVec3; 2]> {
        let Self { me, other, frame, settled, .. } = self;
        let radius = me.radii[up];
        let mut last = None;
        for _ in 0..CORRECTIONS {
            let point = me.on_rim(outward, up);
            let seen = frame.seen_by_other(point);
            let foot = other.foot(seen);
            if foot.part == Part::Inside {
                return None;
            }
            last = Some([point, foot.point]);
            let between = seen - foot.point;
            let tangent = frame.turned_for_other(outward.perp().extend(0.0));
            let away = frame.turned_for_other(outward.extend(0.0));
            // Of half the squared distance, by the angle, over the radius.
            let slope = between.dot(tangent);
            let curve = radius * (1.0 - other.follows(&foot, tangent)) - between.dot(away);
            let step = -slope / curve;
            let moved = step * radius;
            if moved * moved <= (settled * settled) * between.length_squared() {
                break;
            }
            outward = if curve > 0.0 && step.abs() <= FARTHEST {
                (outward + outward.perp() * step).normalize()
            } else {
                frame.seen_by_me(foot.point).truncate().try_normalize()?
            };
        }
        last
    }
}

/// Where two sides are nearest.
enum OnSides {
    /// On both.
    Inside([DVec3; 2]),
    /// Beyond a rim, the lower or the upper.
    BeyondMine(usize),
    BeyondOther(usize),
}

#[cfg(test)]
mod tests;
