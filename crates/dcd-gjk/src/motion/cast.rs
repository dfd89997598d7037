//! Polytopes that move and do not turn: a ray against their difference.
//!
//! At a time t the difference has moved by t·v, so that the two meet when the point −t·v enters it as it stands.
//! Along v the difference is a polygon: a search in the plane finds three vertices round the ray's line, or a
//! direction that proves a miss. Supports along the triangle's normal then move it outward until it is a face
//! (the portals of Snethen, "Xenocollide", Game Programming Gems 7, 2008, round a line in place of a segment).
//!
//! Supports in f32 lead to the face or to the direction of a miss; from there on they are f64's.

use super::advance::Advance;
use super::ray_frame::{Miss, RayFrame, Turned};
use super::{Closing, Limits, MovingShape, UNIT, ray_frame};
use crate::certificate::Bounds;
use crate::distance::Distance;
use crate::gjk::unit;
use crate::supports::{Exact, Polytopes};
use crate::{Difference, PosedSupport, Vertex};
use dcd_geom::glam::{DMat3, DVec2, DVec3};
use dcd_geom::{Polytope, Shape, Support};
use dcd_simd::{Kernel, Lanes, dispatch};

/// How many supports either half of the search takes in f64. From where f32 leads one is usual, from anywhere hulls of
/// some thirty vertices need four and seven. Smaller: more casts are left to the general search.
const SUPPORTS: usize = 32;

/// What the search ends within, as a share of the tolerance. Larger: rounding may leave the end outside of it. Smaller:
/// more supports where many faces are nearly level.
const WITHIN: f64 = 0.5;

/// The same where supports are f32's: what these leave. Unit: the pair's size.
const WITHIN_IN_F32: f64 = 16.0 * (f32::EPSILON as f64 / 2.0);

/// What [`super::advance`] tells, for polytopes without a radius that do not turn; `None` of others, and of those that
/// overlap as they stand or that rounding leaves open.
///
/// Proved by one support: the gap along its direction, less what poses are off by, over the closing speed along it.
pub(super) fn cast(
    [a, b]: [MovingShape<'_>; 2],
    closing: &Closing,
    limits: &Limits,
) -> Option<Advance> {
    let (Shape::Polytope(in_a), Shape::Polytope(in_b)) = (a.shape, b.shape) else {
        return None;
    };
    if closing.turns() || in_a.swept_radius() > 0.0 || in_b.swept_radius() > 0.0 {
        return None;
    }
    let (start_a, start_b) = (&a.motion.start, &b.motion.start);
    let (posed_a, posed_b) =
        (PosedSupport::polytope(in_a, start_a), PosedSupport::polytope(in_b, start_b));
    let difference = Difference::new(posed_a, posed_b)?;
    let &Limits { until, tolerance, .. } = limits;
    let line = Line::of(&difference, closing.linear, [until, tolerance])?;
    let mut face = [Corner::NONE; 3];
    let End { direction, separation, is_met } = dispatch(OnLine { line: &line, face: &mut face })?;
    let lower = Bounds::of(&difference).lower_bound(direction, separation);
    let gap = lower.next_down() / difference.scale() - limits.off(0.0);
    if !(gap > 0.0) {
        return None;
    }
    let speed = closing.along(-direction);
    let t = limits.lasts(0.0, gap, speed);
    if speed <= 0.0 || t > until {
        return Some(Advance::Free);
    }
    if !is_met {
        return Some(Advance::Until(t));
    }
    let tolerance = tolerance - limits.off(t);
    let met = Met { difference: &difference, closing, t, tolerance };
    let near = met.within_tolerance([a, b], &face, direction);
    Some(near.map_or(Advance::Until(t), |found| Advance::Near(t, found)))
}

/// Two polytopes that meet at a time.
struct Met<'a, 'b> {
    /// Theirs as they stand.
    difference: &'a Polytopes<'b>,
    closing: &'a Closing,
    t: f64,
    /// Within which they are to be, less what poses are off by; metres.
    tolerance: f64,
}

/// What moving a point of the difference loses: a difference of velocities, two products and a sum, and weights that
/// are quotients. Unit: 2⁻⁵³ of the pair's size and the way together.
const MOVED: f64 = 16.0;

impl Met<'_, '_> {
    /// The points where the line passes the face, if they are proved to be within the tolerance of each other.
    ///
    /// No pose is made: with weights that sum to 1 the point of the difference moves as the whole does.
    fn within_tolerance(
        &self,
        [a, b]: [MovingShape<'_>; 2],
        face: &[Corner; 3],
        direction: DVec3,
    ) -> Option<Distance> {
        let weight = |i: usize, j: usize| face[i].at.perp_dot(face[j].at).max(0.0);
        let weights = [weight(1, 2), weight(2, 0), weight(0, 1)];
        let total = weights[0] + weights[1] + weights[2];
        let (mut w, mut in_a, mut in_b) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
        for (Corner { vertex, .. }, weight) in face.iter().zip(weights) {
            let weight = weight / total;
            w += vertex.w * weight;
            in_a += vertex.a.point * weight;
            in_b += vertex.b.point * weight;
        }
        let scale = self.difference.scale();
        let moved = self.closing.linear * (self.t * scale);
        let length = (w + moved).length();
        let lost = MOVED * UNIT * (self.difference.size() + moved.length());
        let farthest = Bounds::of(self.difference).upper_bound(length) + lost;
        // Written so that NaN is no proof.
        let is_near = farthest / scale <= self.tolerance;
        let at = |side: MovingShape<'_>, point| {
            side.motion.start.apply(point) + side.motion.linear * self.t
        };
        let (point_a, point_b) = (at(a, in_a), at(b, in_b));
        let normal = -direction / direction.length();
        let is_near = is_near && point_a.is_finite() && point_b.is_finite();
        is_near.then_some(Distance { normal, point_a, point_b, ..Distance::default() })
    }
}

/// A vertex of the difference, and where it is as seen along the line, scaled.
#[derive(Clone, Copy)]
struct Corner {
    vertex: Vertex<f64>,
    at: DVec2,
}

impl Corner {
    /// A place for one.
    const NONE: Self = {
        let none = Support { point: DVec3::ZERO, feature: 0 };
        Self { vertex: Vertex { w: DVec3::ZERO, a: none, b: none }, at: DVec2::ZERO }
    };
}

/// How the search ended.
struct End {
    /// Along which a support was taken last.
    direction: DVec3,
    /// The separation there, scaled.
    separation: f64,
    /// Whether the line passes through a face; else it misses the difference, or meets it after the end of the way.
    is_met: bool,
}

/// The line of the ray: from the origin against the velocity.
struct Line<'a, 'b> {
    difference: &'a Polytopes<'b>,
    /// Two axes that are normal to it, and their cross product: where the difference moves to. Of unit length.
    axes: DMat3,
    /// How far the difference moves, scaled.
    way: f64,
    /// How near along the line the search ends, scaled.
    near: f64,
}

/// Supports in f64 of the difference against a line.
type OfLine<'a, 'b, L> = Exact<'a, 'b, L, Polytope, Polytope>;

/// A search that leaves the face where it is said: as a result it would be copied.
struct OnLine<'l, 'a, 'b> {
    line: &'l Line<'a, 'b>,
    face: &'l mut [Corner; 3],
}

impl Kernel for OnLine<'_, '_, '_> {
    type Output = Option<End>;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> Self::Output {
        let Self { line, face } = self;
        let (mut side_a, mut side_b) = (Turned::none(), Turned::none());
        let limits = [line.way, line.near.max(WITHIN_IN_F32)];
        let sides = [&mut side_a, &mut side_b];
        let frame = RayFrame::of(lanes, line.difference, &line.axes, limits, sides);
        let exact = |near| Exact { lanes, difference: line.difference, near };
        let found = match frame.and_then(|frame| frame.search()) {
            Some(Ok(known)) => {
                for (corner, known) in face.iter_mut().zip(known) {
                    *corner = line.corner(known);
                }
                line.face(&exact(Some(known[0].vertices)), face)
            }
            Some(Err(Miss { direction, corner })) => {
                let direction = unit::<f64>((line.axes * direction.as_dvec3()).to_array());
                let exact = exact(Some(corner.vertices));
                direction.and_then(|direction| line.lowest(&exact, direction).err())
            }
            None => None,
        };
        found.or_else(|| line.search(&exact(None), face))
    }
}

impl<'a, 'b> Line<'a, 'b> {
    fn of(
        difference: &'a Polytopes<'b>,
        velocity: DVec3,
        [until, tolerance]: [f64; 2],
    ) -> Option<Self> {
        let along = unit::<f64>(velocity.to_array())?.normalize();
        let (x, y) = along.any_orthonormal_pair();
        let axes = DMat3::from_cols(x, y, along);
        let scale = difference.scale();
        let way = velocity.length() * until * scale;
        Some(Self { difference, axes, way, near: WITHIN * tolerance * scale })
    }

    /// The end, from anywhere.
    #[inline(always)]
    fn search<L: Lanes>(
        &self,
        supports: &OfLine<'_, 'b, L>,
        corners: &mut [Corner; 3],
    ) -> Option<End> {
        match self.portal(supports)? {
            Ok(found) => {
                *corners = found;
                self.face(supports, corners)
            }
            Err(end) => Some(end),
        }
    }

    /// The corner lowest along a direction, or the end if none is met there before the end of the way.
    #[inline(always)]
    fn lowest<L: Lanes>(
        &self,
        supports: &OfLine<'_, 'b, L>,
        direction: DVec3,
    ) -> Result<(Corner, f64), End> {
        let (vertex, separation) = supports.lowest(direction);
        if separation > 0.0 && separation > -direction.dot(self.axes.z_axis) * self.way {
            return Err(End { direction, separation, is_met: false });
        }
        Ok((self.seen(vertex), separation))
    }

    fn seen(&self, vertex: Vertex<f64>) -> Corner {
        let at = DVec2::new(self.axes.x_axis.dot(vertex.w), self.axes.y_axis.dot(vertex.w));
        Corner { vertex, at }
    }

    /// A corner that is known by its vertices.
    fn corner(&self, known: ray_frame::Corner) -> Corner {
        let (a, b) = self.difference.maps();
        let at = |polytope: &Polytope, number: u32| {
            let vertices = polytope.vertices();
            // The last block is filled up with the last vertex.
            let number = (number as usize).min(vertices.len() - 1);
            Support { point: vertices[number], feature: number as u32 }
        };
        let [number_a, number_b] = known.vertices;
        let (a, b) = (at(a, number_a), at(b, number_b));
        self.seen(Vertex { w: self.difference.world(a.point, b.point), a, b })
    }

    /// [`Line::lowest`] along a direction across the line.
    #[inline(always)]
    fn lowest_across<L: Lanes>(
        &self,
        supports: &OfLine<'_, 'b, L>,
        direction: DVec2,
    ) -> Option<Result<Corner, End>> {
        let direction = unit::<f64>((self.axes * direction.extend(0.0)).to_array())?;
        Some(self.lowest(supports, direction).map(|(corner, _)| corner))
    }

    /// Three corners round the line, counter-clockwise as seen against the velocity.
    ///
    /// The corner in front stays; the two others turn about it until the line is between them and then move outward.
    #[inline(always)]
    fn portal<L: Lanes>(&self, supports: &OfLine<'_, 'b, L>) -> Option<Result<[Corner; 3], End>> {
        let front = match self.lowest(supports, -self.axes.z_axis) {
            Ok((front, _)) => front,
            Err(end) => return Some(Err(end)),
        };
        let mut sides: [Option<Corner>; 2] = [None; 2];
        let mut outward = -front.at;
        for _ in 0..SUPPORTS {
            let corner = match self.lowest_across(supports, -outward)? {
                Ok(corner) => corner,
                Err(end) => return Some(Err(end)),
            };
            let known = [Some(front), sides[0], sides[1]];
            if known.iter().flatten().any(|known| known.vertex.is_same(&corner.vertex)) {
                return None;
            }
            // Right of the line as seen from the front, or left of it.
            let is_right = front.at.perp_dot(corner.at) >= 0.0;
            sides[usize::from(!is_right)] = Some(corner);
            outward = match sides {
                [Some(right), Some(left)] if right.at.perp_dot(left.at) >= 0.0 => {
                    return Some(Ok([front, right, left]));
                }
                [Some(right), Some(left)] => -(left.at - right.at).perp(),
                [Some(right), None] => (right.at - front.at).perp(),
                [None, Some(left)] => -(left.at - front.at).perp(),
                [None, None] => return None,
            };
        }
        None
    }

    /// From three corners round the line to the face that it enters through.
    #[inline(always)]
    fn face<L: Lanes>(
        &self,
        supports: &OfLine<'_, 'b, L>,
        corners: &mut [Corner; 3],
    ) -> Option<End> {
        for _ in 0..SUPPORTS {
            let [p, q, r] = [corners[0].vertex.w, corners[1].vertex.w, corners[2].vertex.w];
            let direction = unit::<f64>((r - p).cross(q - p).to_array())?;
            let (corner, separation) = match self.lowest(supports, direction) {
                Ok(found) => found,
                Err(end) => return Some(end),
            };
            let slope = -direction.dot(self.axes.z_axis);
            // Written so that NaN ends it.
            if !(slope > 0.0) {
                return None;
            }
            let height = direction.dot(p) - separation;
            let is_known = || corners.iter().any(|known| known.vertex.is_same(&corner.vertex));
            if height <= self.near * slope || is_known() {
                return Some(End { direction, separation, is_met: true });
            }
            let side = |k: usize| corner.at.perp_dot(corners[k].at);
            let side = [side(0), side(1), side(2)];
            let k = (0..3).find(|&k| side[k] >= 0.0 && side[(k + 1) % 3] <= 0.0)?;
            corners[(k + 2) % 3] = corner;
        }
        None
    }
}
