//! What a ray meets: each shape's first point on it, with a bracket that holds the truth.
//!
//! A ray is brought into the shape's own frame in f64; what that and the closed forms lose is a length, the margin.
//! The shape grown by it is met no later than the shape, the shape shrunk by it no earlier: the two times are the
//! bracket (docs/numerics/queries.md). Shapes without a closed form take conservative advancement.

mod general;
mod half_space;
mod leaf;
mod local;
mod planes;
mod shared_edges;
mod solids;
#[cfg(test)]
pub(super) mod tests;
mod triangle;

use super::PartIndex;
use crate::PosedShape;
use dcd_geom::glam::DVec3;
use dcd_geom::{Aabb, Kind, Polytope, Shape};
use dcd_simd::RaySlabs;
use local::{Chord, LocalRay, is_later};
use std::fmt;

/// The points `origin` + t·`direction` for t from 0 to `max_t`, checked when it is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    origin: DVec3,
    direction: DVec3,
    max_t: f64,
}

/// Why a ray was refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum RayError {
    /// A coordinate of the origin is not finite, or beyond [`Aabb::LIMIT`].
    BadOrigin {
        /// The first such coordinate.
        value: f64,
    },
    /// The direction is 0, not finite, or its largest component is not within 1e±100.
    BadDirection {
        /// As given.
        direction: DVec3,
    },
    /// The end is NaN or below 0.
    BadEnd {
        /// As given.
        max_t: f64,
    },
}

impl fmt::Display for RayError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::BadOrigin { value } => {
                write!(f, "the ray's origin holds {value:e}, out of range")
            }
            Self::BadDirection { direction: DVec3 { x, y, z } } => {
                write!(f, "[{x:e}, {y:e}, {z:e}] is no direction of a ray")
            }
            Self::BadEnd { max_t } => write!(f, "the ray's end is {max_t:e}, not at least 0"),
        }
    }
}

impl std::error::Error for RayError {}

/// How long a direction's largest component may be, so that squares of coordinates and products with it stay in
/// range. No unit.
const DIRECTIONS: std::ops::RangeInclusive<f64> = 1e-100..=1e100;

/// A direction whose largest component is in this range is taken as it is; others are scaled. No unit. Larger: closed forms of small
/// shapes underflow. Smaller: hits that are scaled in vain.
const AS_GIVEN: std::ops::Range<f64> = 1e-50..1e50;

impl Ray {
    /// From a point, metres, along a direction of any length, world axes. `max_t` counts in lengths of the
    /// direction and may be infinite.
    ///
    /// # Errors
    /// An origin that is not finite or out of range, a direction that is 0, not finite or out of range, an end
    /// that is NaN or below 0; each with its value.
    pub fn new(origin: DVec3, direction: DVec3, max_t: f64) -> Result<Self, RayError> {
        // Each written so that NaN is refused.
        if let Some(&value) = origin.to_array().iter().find(|x| !(x.abs() <= Aabb::LIMIT)) {
            return Err(RayError::BadOrigin { value });
        }
        let largest = direction.abs().max_element();
        if !(direction.is_finite() && DIRECTIONS.contains(&largest)) {
            return Err(RayError::BadDirection { direction });
        }
        if !(max_t >= 0.0) {
            return Err(RayError::BadEnd { max_t });
        }
        Ok(Self { origin, direction, max_t })
    }

    /// The same ray without an end.
    ///
    /// # Errors
    /// Those of [`Ray::new`].
    pub fn endless(origin: DVec3, direction: DVec3) -> Result<Self, RayError> {
        Self::new(origin, direction, f64::INFINITY)
    }

    /// From one point to another: t is 1 there.
    ///
    /// # Errors
    /// Those of [`Ray::new`]; two equal points have no direction.
    pub fn between(from: DVec3, to: DVec3) -> Result<Self, RayError> {
        Self::new(from, to - from, 1.0)
    }

    /// Where it begins, metres.
    pub fn origin(&self) -> DVec3 {
        self.origin
    }

    /// As given.
    pub fn direction(&self) -> DVec3 {
        self.direction
    }

    /// Where it ends, in lengths of the direction.
    pub fn max_t(&self) -> f64 {
        self.max_t
    }

    /// The point at t, rounded.
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + self.direction * t
    }

    /// The same ray along a direction whose largest component is within 1 to 2, and how long one of its lengths is in those of this
    /// one: a power of two, so that nothing is rounded.
    fn scaled(&self) -> (Self, f64) {
        let largest = self.direction.abs().max_element();
        // The exponent's bits alone.
        let length = f64::from_bits(largest.to_bits() & f64::INFINITY.to_bits());
        let (direction, max_t) = (self.direction / length, self.max_t * length);
        (Self { direction, max_t, ..*self }, length.recip())
    }

    /// What a tree's boxes are tested with.
    pub fn slabs(&self) -> RaySlabs {
        RaySlabs::new(self.origin, self.direction, 0.0)
    }
}

/// The first point of a shape on a ray, or of a part of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayHit {
    /// When, in lengths of the direction: within the bracket, and at its beginning if the hit is not certain. 0 where the
    /// ray begins inside of what is solid.
    pub t: f64,
    /// Proved: at no earlier time is a point of the shape on the ray.
    pub t_lower: f64,
    /// If it is [certain](Self::is_certain), proved: at this time at the latest the ray has met the shape. Else where
    /// the ray may leave what it may have met.
    pub t_upper: f64,
    /// Whether the ray is proved to meet the shape. If not it comes so near, to within some 1e-13 of the distances
    /// involved, of cones, ellipsoids and rounded shapes some 1e-10 of their reach, that neither a hit nor a miss is
    /// proved: it grazes the shape, ends or begins at its surface, or passes through what is infinitely thin.
    ///
    /// Of a compound it says that of the part. A ray through an edge or corner that triangles of a mesh share is proved to meet one
    /// of these; then all of them say so, each with the times of all.
    pub is_certain: bool,
    /// The surface's, outward, against the ray for a triangle; world axes, of unit length but for rounding. Zero where the
    /// ray begins inside.
    pub normal: DVec3,
    /// Which face of a polytope ([`dcd_geom::Facets`]), where the ray enters through one that is known.
    pub facet: Option<u32>,
    /// Which part of a compound, or triangle of a mesh.
    pub part: Option<PartIndex>,
}

impl RayHit {
    /// Where a ray begins in what is solid.
    const INSIDE: Self = Self {
        t: 0.0,
        t_lower: 0.0,
        t_upper: 0.0,
        is_certain: true,
        normal: DVec3::ZERO,
        facet: None,
        part: None,
    };

    /// The same hit with its times in lengths of another direction, of which one of the ray's own is so many.
    fn in_lengths(self, length: f64) -> Self {
        let [t, t_lower, t_upper] = [self.t, self.t_lower, self.t_upper].map(|t| t * length);
        Self { t, t_lower, t_upper, ..self }
    }

    /// Half the width of the bracket round [`RayHit::t`], rounded up.
    pub fn error_bound(&self) -> f64 {
        (self.t - self.t_lower).max(self.t_upper - self.t).next_up()
    }

    /// Whether it comes first: by t, then by part.
    pub fn is_before(&self, other: &Self) -> bool {
        self.t.total_cmp(&other.t).then(self.part.cmp(&other.part)).is_lt()
    }
}

/// The first hit of a shape, of all its parts the first by t and then by index. `None` is proved: the ray meets no
/// point of it.
///
/// Compounds, cylinders, half-spaces and what else is solid are met at t = 0 by a ray that begins inside; a mesh is
/// its triangles alone. A ray through an edge or vertex of a closed mesh meets it.
///
/// ```
/// use dcd_geom::{Pose, Shape, glam::DVec3};
/// use dcd_gjk::PosedShape;
/// use dcd_gjk::query::ray::{Ray, first_hit};
/// let (shape, pose) = (Shape::cuboid(DVec3::ONE)?, Pose::from_translation(DVec3::X * 5.0)?);
/// let ray = Ray::endless(DVec3::ZERO, DVec3::X * 2.0)?;
/// let hit = first_hit(&ray, PosedShape { shape: &shape, pose: &pose }).unwrap();
/// assert!(hit.is_certain && (hit.t - 2.0).abs() <= hit.error_bound() && hit.error_bound() < 1e-12);
/// assert_eq!(hit.normal, -DVec3::X);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn first_hit(ray: &Ray, posed: PosedShape<'_>) -> Option<RayHit> {
    let (mut first, mut lower): (Option<RayHit>, f64) = (None, f64::INFINITY);
    for_each_hit(ray, posed, ray.max_t, &mut |hit| {
        lower = lower.min(hit.t_lower);
        if first.is_none_or(|known| hit.is_before(&known)) {
            first = Some(hit);
        }
        // What begins after a hit's end is after it.
        first.filter(|hit| hit.is_certain).map_or(ray.max_t, |hit| hit.t_upper)
    });
    first.map(|hit| RayHit { t_lower: lower, ..hit })
}

/// Calls `visit` for the hit of the shape, or of each part, in an order of its own, as far as it may be met at
/// `limit` or before, and takes what it returns for the limit from then on; a negative one ends the search.
pub fn for_each_hit(
    ray: &Ray,
    posed: PosedShape<'_>,
    limit: f64,
    visit: &mut dyn FnMut(RayHit) -> f64,
) {
    if !AS_GIVEN.contains(&ray.direction.abs().max_element()) {
        let (scaled, length) = ray.scaled();
        let mut visit_scaled = |hit: RayHit| visit(hit.in_lengths(length)) / length;
        return hits(&scaled, posed, limit / length, &mut visit_scaled);
    }
    hits(ray, posed, limit, visit);
}

/// The same along a direction that is not scaled.
fn hits(ray: &Ray, posed: PosedShape<'_>, limit: f64, visit: &mut dyn FnMut(RayHit) -> f64) {
    match posed.shape {
        Shape::Compound(compound) => {
            let local = LocalRay::of(ray, &posed, compound.reach());
            let slabs = local.slabs(0.0);
            let mut limit = limit;
            compound.tree().visit(&slabs, slabs.key_of(limit), &mut |part, _| {
                let shape = compound.parts()[part as usize].placed();
                let part_posed = PosedShape { shape, pose: posed.pose };
                if let Some(hit) = convex(ray, part_posed, limit) {
                    limit = visit(RayHit { part: Some(PartIndex::Part(part)), ..hit });
                }
                slabs.key_of(limit)
            });
        }
        Shape::Mesh(_) if is_far(ray, posed) => {
            visit(RayHit { t_upper: ray.max_t, is_certain: false, ..RayHit::INSIDE });
        }
        Shape::Mesh(mesh) => triangle::of_mesh(ray, posed, mesh, limit, visit),
        _ => {
            if let Some(hit) = convex(ray, posed, limit) {
                visit(hit);
            }
        }
    }
}

/// How large a shape and its distance from a ray may be together, metres, for closed forms: squares of these lengths times a direction's
/// are in range. Larger: rays that begin far off and are called inside.
const FARTHEST: f64 = 1e100;

/// Whether a shape that has an end is farther or larger than that.
fn is_far(ray: &Ray, posed: PosedShape<'_>) -> bool {
    let way = (posed.pose.translation() - ray.origin).abs().max_element();
    // Written so that NaN is too far.
    posed.shape.is_bounded() && !(way + posed.shape.reach() <= FARTHEST)
}

/// The hit of a convex shape; none is looked for that is proved to be later than `limit`.
fn convex(ray: &Ray, posed: PosedShape<'_>, limit: f64) -> Option<RayHit> {
    if is_far(ray, posed) {
        return general::hit(ray, posed);
    }
    match posed.shape {
        Shape::HalfSpace(half_space) => half_space::hit(ray, half_space, posed.pose),
        Shape::Polytope(polytope) => of_polytope(ray, posed, polytope, limit),
        Shape::Curved(curved) if curved.swept_radius() == 0.0 => {
            let local = LocalRay::of(ray, &posed, curved.reach());
            match solids::curved(&local, curved, local.margin) {
                solids::Outcome::Missed => None,
                solids::Outcome::Unknown => general::hit(ray, posed),
                solids::Outcome::Met(outer) => {
                    let inner = match solids::curved(&local, curved, -local.margin) {
                        solids::Outcome::Met(chord) => Some(chord),
                        _ => None,
                    };
                    local.bracket(ray, outer, inner)
                }
            }
        }
        _ => general::hit(ray, posed),
    }
}

fn of_polytope(
    ray: &Ray,
    posed: PosedShape<'_>,
    polytope: &Polytope,
    limit: f64,
) -> Option<RayHit> {
    let radius = polytope.swept_radius();
    let local = LocalRay::of(ray, &posed, polytope.reach() + radius);
    // A radius is a length of the world: in the shape's frame it is one up to what the pose stretches.
    let slack = local.margin + radius * (4.0 * posed.pose.deviation());
    let inner = polytope.inner();
    if (local.origin - inner.centre).length() + slack <= inner.radius {
        return Some(RayHit::INSIDE);
    }
    let sphere = |grown: f64| solids::sphere(&local, inner.centre, grown);
    // A miss of the sphere round it is a miss. It is tested first because other tests cost more.
    let round = sphere(polytope.outer_radius() + radius + slack)?;
    if round.leave < 0.0 || is_later(round.enter, limit) {
        return None;
    }
    let both = |chord: &dyn Fn(f64) -> Option<Chord>| {
        let outer = chord(slack)?;
        local.bracket(ray, outer, chord(-slack))
    };
    match (polytope.kind(), polytope.vertices()) {
        (_, [centre]) => both(&|by| solids::sphere(&local, *centre, radius + by)),
        (_, [from, to]) if radius > 0.0 => {
            both(&|by| solids::capsule(&local, [*from, *to], radius + by))
        }
        (Kind::Cuboid { half_extents }, _) if radius == 0.0 => {
            both(&|by| solids::cuboid(&local, half_extents + by))
        }
        (_, [a, b, c]) if radius == 0.0 => {
            let sheared = triangle::Sheared::of(&local);
            sheared.hit(ray, &local, [*a, *b, *c])
        }
        _ => {
            let planes = polytope.planes();
            if planes.is_empty() {
                return general::hit(ray, posed);
            }
            let (outer, inner) = planes::chords(&local, planes, [radius + slack, -slack], limit)?;
            if radius > 0.0 || !planes.has_inside() {
                return general::hit(ray, posed);
            }
            local.bracket(ray, outer, inner)
        }
    }
}
