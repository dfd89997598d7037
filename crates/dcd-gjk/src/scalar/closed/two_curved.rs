//! Where two cylinders or cones are nearest.
//!
//! The point of such a shape nearest to a given one has a formula. So two nearest points, where either lies on a rim, are a
//! root in one angle; on two sides, or on a disc, they are known at once. Which of these it is, and where the angle's search
//! begins, a few projections to and fro say. What comes out is a proposal: the pair's own bounds prove it.

use super::UNIT;
use super::curved_points::CurvedPoints;
use super::feature_normal::{self, HARDLY_APART};
use super::profile::{Foot, Part, Profile};
use crate::PosedShape;
use crate::mesh::Limited;
use dcd_geom::glam::{DMat3, DVec2, DVec3};
use dcd_geom::{Curved, Shape};

/// How often features are tried, and how often an angle is corrected, at most: two and four are usual. Fewer: points that the
/// bounds refuse.
const TRIES: usize = 6;
const CORRECTIONS: usize = 8;

/// The square of the sine of two axes below which sides count as parallel, and have no one place where they cross. No unit.
/// Larger: points that are not the nearest by that sine. Smaller: places that rounding has moved.
const PARALLEL: f64 = 1e-28;

/// How far the line between two points may be turned from the nearest ones', where a bound of millionths of the size is
/// enough, and where all that f64 has is asked for. Radians: the bounds lose about its square. Larger: points that the bounds
/// refuse. Smaller: corrections for nothing.
const TURNED: f64 = 5e-4;
const SHARPLY_TURNED: f64 = 1e-8;

/// The same where the points all but meet. Larger: points beside each other. Smaller: corrections for nothing.
const HARDLY_TURNED: f64 = 1e-14;

/// How far a point moves by rounding alone, where it counts. Unit: u of the pair's size; twice what two turns and a foot lose. Smaller: corrections
/// without end where the shapes all but meet. Larger: points beside the nearest.
const ROUNDING: f64 = 32.0;

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
    /// What two points of a core may be apart and be the same, metres; 0 where nothing is known of what all but meets.
    rounding: f64,
    /// The square of the last distance of two points.
    squared: f64,
    /// Whether the one is the second of the pair.
    swapped: bool,
    /// How often two sides have been tried: by their common normal, by the lines up them, then the nearest rim.
    tried_sides: usize,
}

/// What is known of the distance of two cylinders or cones, by points of which the bounds are at most `gap` of the pair's size
/// apart, or what f64 leaves; beyond `far`, metres, no more than that. `None` of other kinds, where the cores seem to meet, and
/// where such points are not found.
pub(crate) fn distance([gap, far]: [f64; 2], [a, b]: [PosedShape<'_>; 2]) -> Option<Limited> {
    let (Shape::Curved(in_a), Shape::Curved(in_b)) = (a.shape, b.shape) else { return None };
    let points = CurvedPoints::of([in_a, in_b], [a.pose, b.pose])?;
    let is_beyond = |[of_a, of_b]: [DVec3; 2]| points.between(of_a, of_b).are_beyond(&points, far);
    let settled = if gap > 0.0 { TURNED } else { SHARPLY_TURNED };
    let mut two = Two::of([in_a, in_b], [a, b], [settled, 0.0])?;
    let hardly = HARDLY_APART * points.size();
    match two.nearest(far, is_beyond) {
        Some(Nearest::Beyond) => return Some(Limited::Beyond),
        Some(Nearest::Points(on)) => {
            let [of_a, of_b] = two.in_order(on);
            let found = points.between(of_a, of_b).distance(&points, [gap, far]);
            if found.is_some() {
                return found;
            }
        }
        None if two.squared >= hardly * hardly => return None,
        None => {}
    }
    let rounding = ROUNDING * UNIT * points.size();
    let two = Two::of([in_a, in_b], [a, b], [HARDLY_TURNED, rounding])?;
    let turns = [a, b].map(|side| *side.pose.rotation());
    distance_of_features(two, &points, [gap, far], turns)
}

/// The same where they all but meet or are all but parallel, by the common normal of the features on which the points are.
#[cold]
fn distance_of_features(
    mut two: Two,
    points: &CurvedPoints<'_>,
    limits: [f64; 2],
    [turn_a, turn_b]: [DMat3; 2],
) -> Option<Limited> {
    let Nearest::Points(on) = two.nearest(f64::INFINITY, |_| false)? else { return None };
    let [of_a, of_b] = two.in_order(on);
    let found = points.between(of_a, of_b);
    // To the first from the second, world axes.
    let in_world = |normal: DVec3| match two.swapped {
        false => turn_a * normal,
        true => -(turn_b * normal),
    };
    let mut normals = two.normals(on, points.size()).map(in_world);
    normals
        .find_map(|normal| points.along(normal, &found).distance(points, limits))
        .or_else(|| found.distance(points, limits))
}

/// Points of both cores, each in its own frame: mine and the other's.
enum Nearest {
    /// They prove more than the limit.
    Beyond,
    /// Perhaps the nearest.
    Points([DVec3; 2]),
}

impl Two {
    /// See the fields. `None` where a profile has no products of its lengths.
    fn of(
        curved: [&Curved; 2],
        [a, b]: [PosedShape<'_>; 2],
        [settled, rounding]: [f64; 2],
    ) -> Option<Self> {
        let back = a.pose.rotation().transpose();
        let delta = back * (b.pose.translation() - a.pose.translation());
        let frame = Frame { turn: back * *b.pose.rotation(), delta };
        let (me, other) = (Profile::of(curved[0])?, Profile::of(curved[1])?);
        let (swapped, tried_sides, squared) = (false, 0, f64::INFINITY);
        Some(Self { me, other, frame, settled, rounding, squared, swapped, tried_sides })
    }

    fn nearest(&mut self, far: f64, are_beyond: impl Fn([DVec3; 2]) -> bool) -> Option<Nearest> {
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
            self.squared = squared;
            if self.is_settled(moved, squared) && (tried > 0 || !self.is_perhaps_level(&foot)) {
                return Some(Nearest::Points([on_me, on_other]));
            }
            if tried == 0
                && squared > far * far
                && are_beyond(self.in_order([foot.point, on_other]))
            {
                return Some(Nearest::Beyond);
            }
            let foot_of_other = self.other.foot(self.frame.seen_by_other(foot.point));
            [on_me, on_other] = self.solved(&foot, &foot_of_other)?;
        }
        None
    }

    /// Whether a point that would move so far is where it belongs, the other so far away: squares.
    #[inline(always)]
    fn is_settled(&self, moved: f64, squared: f64) -> bool {
        moved <= (self.settled * self.settled) * squared + self.rounding * self.rounding
    }

    /// Whether a point beside a disc, or of two sides, may stay where it is because they are all but parallel, though the others
    /// are nearer. That counts where they all but meet.
    fn is_perhaps_level(&self, foot: &Foot) -> bool {
        if self.rounding == 0.0 {
            return false;
        }
        let foot_of_other = self.other.foot(self.frame.seen_by_other(foot.point));
        matches!(
            (foot.part, foot_of_other.part),
            (Part::Disc(_), _) | (_, Part::Disc(_)) | (Part::Side, Part::Side)
        )
    }

    /// What may be the direction to me from the other, in my frame, by the features that two points are on.
    fn normals(&self, [on_me, on_other]: [DVec3; 2], size: f64) -> impl Iterator<Item = DVec3> {
        let Self { me, other, frame, rounding, .. } = self;
        let there = frame.seen_by_me(on_other);
        let feet = (me.foot(there), other.foot(frame.seen_by_other(on_me)));
        // A point of a disc may be one of its rim but for rounding.
        [0.0, 2.0 * rounding].into_iter().flat_map(move |edge| {
            let mine = me.tangents(&feet.0, edge);
            let others = other.tangents(&feet.1, edge);
            let seen = [mine, others.turned(frame.turn)];
            feature_normal::normals(on_me - there, size, seen)
        })
    }

    fn in_order(&self, [on_me, on_other]: [DVec3; 2]) -> [DVec3; 2] {
        if self.swapped { [on_other, on_me] } else { [on_me, on_other] }
    }

    /// The nearest points of the features that two points are on, each in its own frame, or points from which to go on. It may
    /// exchange the two.
    fn solved(&mut self, on_me: &Foot, on_other: &Foot) -> Option<[DVec3; 2]> {
        match [on_me.part, on_other.part] {
            [Part::Inside, _] | [_, Part::Inside] => None,
            [Part::Disc(up), _] => self.on_disc(up),
            [_, Part::Disc(up)] => {
                self.exchange();
                self.on_disc(up)
            }
            [Part::Rim(up), _] => self.on_rim(on_me.outward, up),
            [_, Part::Rim(up)] => {
                self.exchange();
                self.on_rim(on_other.outward, up)
            }
            [Part::Side, Part::Side] => {
                let nearest = match self.tried_sides {
                    0 | 1 => self.on_sides([on_me, on_other]),
                    _ => self.nearest_rim([on_me, on_other]),
                };
                self.tried_sides += 1;
                match nearest {
                    OnSides::Inside(points) => Some(points),
                    OnSides::BeyondMine(up) => self.on_rim(on_me.outward, up),
                    OnSides::BeyondOther(up) => {
                        self.exchange();
                        self.on_rim(on_other.outward, up)
                    }
                }
            }
        }
    }

    fn exchange(&mut self) {
        std::mem::swap(&mut self.me, &mut self.other);
        self.frame = self.frame.mirrored();
        self.swapped = !self.swapped;
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

    /// Where the two sides are nearest, given two points that face each other: where the lines up them cross that do so too.
    fn on_sides(&self, [on_me, on_other]: [&Foot; 2]) -> OnSides {
        let Self { me, other, frame, .. } = self;
        // Of parallel ones those are as near as any.
        let as_they_are = OnSides::Inside([on_me.point, on_other.point]);
        let by_normal = || {
            let normal = self.normal_of_sides()?;
            let others_normal = frame.turned_for_other(-normal);
            Some([normal, others_normal].map(|normal| normal.truncate().try_normalize()))
        };
        let [Some(outward), Some(others_outward)] = (match self.tried_sides {
            0 => by_normal(),
            _ => Some([Some(on_me.outward), Some(on_other.outward)]),
        })
        .unwrap_or_default() else {
            return as_they_are;
        };
        let up = me.up_the_side(outward);
        let others_up = frame.turn * other.up_the_side(others_outward);
        let between =
            me.on_side(outward, 0.0) - frame.seen_by_me(other.on_side(others_outward, 0.0));
        // By the cross product: of lines that are nearly parallel the difference of squares is rounding.
        let across = up.cross(others_up);
        let squared = across.length_squared();
        if squared == 0.0 {
            return as_they_are;
        }
        let share = (-between.cross(others_up).dot(across) / squared).clamp(0.0, 1.0);
        let others_at = others_up.dot(between + up * share) / others_up.length_squared();
        let others_share = others_at.clamp(0.0, 1.0);
        let share = match others_at == others_share {
            true => share,
            false => up.dot(others_up * others_share - between) / up.length_squared(),
        };
        if !(0.0 < share && share < 1.0) {
            OnSides::BeyondMine(usize::from(share > 0.5))
        } else if !(0.0 < others_share && others_share < 1.0) {
            OnSides::BeyondOther(usize::from(others_share > 0.5))
        } else {
            let point = me.on_side(outward, share);
            OnSides::Inside([point, other.foot(frame.seen_by_other(point)).point])
        }
    }

    /// The rim nearest to one of two points of the sides.
    fn nearest_rim(&self, [on_me, on_other]: [&Foot; 2]) -> OnSides {
        let (of_me, up) = self.me.nearest_rim(on_me);
        let (of_other, others_up) = self.other.nearest_rim(on_other);
        match of_me <= of_other {
            true => OnSides::BeyondMine(up),
            false => OnSides::BeyondOther(others_up),
        }
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
        let Self { me, other, frame, .. } = self;
        let radius = me.radii[up];
        let (mut last, mut edge) = (None, None);
        for _ in 0..CORRECTIONS {
            let point = me.on_rim(outward, up);
            let seen = frame.seen_by_other(point);
            let foot = match edge {
                Some(above) => other.foot_on_rim(seen, above),
                None => other.foot(seen),
            };
            last = Some([point, foot.point]);
            match foot.part {
                Part::Inside => return None,
                Part::Disc(above) => match self.above_disc(up, above) {
                    AboveDisc::Point(lowest) => return Some(lowest),
                    AboveDisc::Anywhere => break,
                    AboveDisc::Edge(crossing) => {
                        (outward, edge) = (crossing, Some(above));
                        continue;
                    }
                },
                Part::Side | Part::Rim(_) => {}
            }
            let between = seen - foot.point;
            let tangent = frame.turned_for_other(outward.perp().extend(0.0));
            let away = frame.turned_for_other(outward.extend(0.0));
            let by_height = other.bends(&foot, [seen, tangent, away], radius);
            let step = by_height.and_then(newton).or_else(|| {
                // Of half the squared distance, by the angle, over the radius.
                let curve = radius * (1.0 - other.follows(&foot, tangent)) - between.dot(away);
                newton([between.dot(tangent), curve])
            });
            let moved = step.map_or(f64::MAX, |step| step * radius);
            if self.is_settled(moved * moved, between.length_squared()) {
                break;
            }
            outward = match step {
                Some(step) => (outward + outward.perp() * step).normalize(),
                None => frame.seen_by_me(foot.point).truncate().try_normalize()?,
            };
        }
        last
    }

    /// Where a rim of mine, which is partly above a disc of the other, is nearest to it.
    fn above_disc(&self, up: usize, above: usize) -> AboveDisc {
        let Self { me, other, frame, .. } = self;
        let normal = if above == 1 { frame.turn.z_axis } else { -frame.turn.z_axis };
        let Some(lowest) = (-normal.truncate()).try_normalize() else { return AboveDisc::Anywhere };
        let point = me.on_rim(lowest, up);
        let foot = other.foot(frame.seen_by_other(point));
        if foot.part == Part::Disc(above) {
            return AboveDisc::Point([point, foot.point]);
        }
        // Else where the rims cross, as seen along the axis.
        let centre = frame.seen_by_me(DVec3::Z * other.heights[above]).truncate();
        let (mine, others) = (me.radii[up], other.radii[above]);
        let squared = centre.length_squared();
        let along = (squared + mine * mine - others * others) / (2.0 * mine * squared);
        let aside = 1.0 / squared - along * along;
        if !(aside > 0.0) {
            return AboveDisc::Anywhere;
        }
        let [to_left, to_right] =
            [1.0, -1.0].map(|way| centre * along + centre.perp() * (way * aside.sqrt()));
        let is_left = normal.truncate().dot(to_left - to_right) < 0.0;
        let crossing = if is_left { to_left } else { to_right };
        AboveDisc::Edge(crossing.normalize())
    }
}

/// A step of Newton's method, by a first and a second derivative, towards a minimum that is not far.
fn newton([slope, curve]: [f64; 2]) -> Option<f64> {
    let step = -slope / curve;
    (curve > 0.0 && step.abs() <= FARTHEST).then_some(step)
}

/// Where a rim is nearest to a disc.
enum AboveDisc {
    /// There, in both frames.
    Point([DVec3; 2]),
    /// Where it is above it.
    Anywhere,
    /// Near the disc's own rim: the direction from the axis in which they cross.
    Edge(DVec2),
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
