//! Obstacles as sixteen spheres are compared with them.

use super::separate::Support;
use super::{FAR, MARGIN, SpherePacket};
use dcd_geom::{Aabb, CurvedKind, Kind, Polytope, Pose, Scene, Shape, SphereBounds};
use dcd_simd::{Block, Lanes, WIDTH};
use glam::{DVec3, Vec3};
use std::ops::Range;

/// An obstacle: a closed form where its shape has one, else what is known round it and in it.
#[derive(Clone, Debug)]
pub(super) struct Solid {
    form: Form,
    /// The axes of its own frame in the world; none where they are the world's.
    axes: Option<[Vec3; 3]>,
    /// The origin of that frame, or the middle of the box, metres.
    centre: Vec3,
    /// Half the box, metres.
    half: Vec3,
    /// What is swept round it, metres.
    swept: f32,
    /// By how much a comparison with it may be off, metres.
    margin: f32,
    /// Which blocks are its vertices in the world, if it is a hull of few without a closed form; what is swept round
    /// them, metres, rounded up.
    corners: Range<u32>,
    round: f32,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Form {
    /// A sphere.
    Point,
    /// A capsule along its z axis, of that half height.
    Segment { half_height: f32 },
    /// A cylinder along its z axis.
    Cylinder { half_height: f32, radius: f32 },
    /// The box of `half`.
    Box,
    /// Something in the box and in the outer sphere, that contains the inner one.
    Bounded { outer: (Vec3, f32), inner: (Vec3, f32) },
}

/// How far from a rotation an obstacle's matrix may be for closed forms, which take its transpose for its inverse;
/// 2⁻³⁰ is a sixteen thousandth of [`MARGIN`]. What is farther is compared by its bounds.
const RIGID: f64 = 1.0 / (1u64 << 30) as f64;

/// Of hulls with more vertices planes are left to the narrow phase: theirs would be copied for every world.
const CORNERS: usize = 64;

/// Which of sixteen spheres reach an obstacle, a bit each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Overlaps {
    /// What is not proved apart, what is proved to touch among it.
    pub(super) near: u32,
    /// Whose inner spheres are proved to touch.
    pub(super) touched: u32,
}

impl Solid {
    /// Of an object of a scene, with a box round it; adds its vertices to `blocks`, where there are any.
    pub(super) fn of(
        scene: &Scene,
        object: usize,
        blocks: Option<&mut Vec<Block>>,
    ) -> (Self, Aabb) {
        let (shape, pose) = (scene.shape(object), &scene.poses()[object]);
        let form = ClosedForm::of(shape);
        if let Some(solid) = form.as_ref().and_then(|form| form.at(pose)) {
            let aabb = solid.aabb();
            return (solid, aabb);
        }
        let aabb = scene.aabb(object);
        let mut solid = bounded(shape, pose, &aabb);
        let (Some(blocks), None) = (blocks, form) else { return (solid, aabb) };
        if let Some(polytope) = shape.as_polytope().filter(|p| p.vertices().len() <= CORNERS) {
            let first = blocks.len();
            let mut placed = [DVec3::ZERO; WIDTH];
            for few in polytope.vertices().chunks(WIDTH) {
                placed.iter_mut().zip(few).for_each(|(to, &v)| *to = pose.apply(v));
                blocks.extend(Block::relative(&placed[..few.len()], DVec3::ZERO));
            }
            // An object has four at most, and there are less than 2³² / 512 objects.
            solid.corners = first as u32..blocks.len() as u32;
            solid.round = (polytope.swept_radius() as f32).next_up();
        }
        (solid, aabb)
    }

    /// A box round it, if it has a closed form: its supports along the axes, and its margin.
    fn aabb(&self) -> Aabb {
        let core = Vec3::new(
            self.reach_along(Vec3::X),
            self.reach_along(Vec3::Y),
            self.reach_along(Vec3::Z),
        );
        let reach = core + self.swept + self.margin;
        Aabb { min: self.centre - reach, max: self.centre + reach }
    }

    /// Which blocks of all obstacles' ones are its vertices; none of what has a closed form or is no hull of few.
    pub(super) fn corner_range(&self) -> Range<usize> {
        self.corners.start as usize..self.corners.end as usize
    }

    /// The same with its vertices in other blocks.
    pub(super) fn with_corners(self, first: usize) -> Self {
        // As many blocks as it had: see `of`.
        let first = first as u32;
        Self { corners: first..first + (self.corners.end - self.corners.start), ..self }
    }

    /// Its vertices in the world, of all obstacles' ones, if it is a hull of few without a closed form.
    pub(super) fn corners<'a>(&self, blocks: &'a [Block]) -> Option<&'a [Block]> {
        let corners = self.corner_range();
        (!corners.is_empty()).then(|| &blocks[corners])
    }

    /// By how much a comparison with it may be off, metres.
    pub(super) fn margin(&self) -> f32 {
        self.margin
    }

    /// What is swept round those, and by how much a comparison may be off, metres.
    pub(super) fn reach(&self) -> f32 {
        self.round + self.margin
    }

    /// The squared distances of sixteen points from its core, or of what is known by bounds from its box, m².
    #[inline(always)]
    fn core_distances<L: Lanes>(&self, l: L, centre: [L::F; 3]) -> L::F {
        let mut from = from_point(l, centre, self.centre);
        if let Some([x, y, z]) = self.axes {
            from = [along(l, from, x), along(l, from, y), along(l, from, z)];
        }
        let none = l.splat(0.0);
        let away = match self.form {
            Form::Point => from,
            Form::Segment { half_height } => [from[0], from[1], beyond(l, from[2], half_height)],
            Form::Cylinder { half_height, radius } => {
                let square = l.mul_add(from[0], from[0], l.mul(from[1], from[1]));
                let radial = l.max(l.sub(l.sqrt(square), l.splat(radius)), none);
                [radial, none, beyond(l, from[2], half_height)]
            }
            Form::Box | Form::Bounded { .. } => [
                beyond(l, from[0], self.half.x),
                beyond(l, from[1], self.half.y),
                beyond(l, from[2], self.half.z),
            ],
        };
        squared(l, away)
    }

    /// Which of sixteen spheres are near, by the squared distances of their centres from the core and by the outer radii
    /// with what is swept round it and all margins.
    #[inline(always)]
    fn near_core<L: Lanes>(&self, l: L, centre: [L::F; 3], square: L::F, reach: L::F) -> u32 {
        let near = within(l, square, reach);
        let Form::Bounded { outer: (middle, radius), .. } = self.form else { return near };
        let to_outer = squared(l, from_point(l, centre, middle));
        near & within(l, to_outer, l.add(reach, l.splat(radius)))
    }

    /// Which of the spheres are near: what [`Self::reached`] finds of spheres with nothing known inside.
    #[inline(always)]
    pub(super) fn near<L: Lanes>(&self, l: L, spheres: &SpherePacket<L>) -> u32 {
        let SpherePacket { centre, outer, margin, .. } = *spheres;
        let margin = l.add(margin, l.splat(self.margin));
        let reach = l.add(l.add(outer, l.splat(self.swept)), margin);
        self.near_core(l, centre, self.core_distances(l, centre), reach)
    }

    /// Which of the spheres are near, and which touch. The outer and inner radii are without the spheres' own
    /// margins (docs/numerics/proofs.md, "states in lanes").
    #[inline(always)]
    pub(super) fn reached<L: Lanes>(&self, l: L, spheres: &SpherePacket<L>) -> Overlaps {
        let SpherePacket { centre, outer, inner, margin } = *spheres;
        let (margin, swept) = (l.add(margin, l.splat(self.margin)), l.splat(self.swept));
        let (reach, inner_reach) =
            (l.add(l.add(outer, swept), margin), l.sub(l.add(inner, swept), margin));
        let square = self.core_distances(l, centre);
        let near = self.near_core(l, centre, square, reach);
        // A maximum may swallow a NaN: a centre that is NaN touches nothing.
        let sum = l.add(l.add(centre[0], centre[1]), centre[2]);
        let somewhere = l.bits(l.le(sum, sum));
        let (square, inner_reach) = match self.form {
            Form::Bounded { inner: (middle, radius), .. } => {
                let to_inner = squared(l, from_point(l, centre, middle));
                (to_inner, l.add(inner_reach, l.splat(radius)))
            }
            _ => (square, inner_reach),
        };
        let touched = inside(l, square, inner_reach) & somewhere;
        Overlaps { near: near | touched, touched }
    }
}

impl Solid {
    /// Whether it is what its form says: not known by bounds alone.
    pub(super) fn is_closed(&self) -> bool {
        !matches!(self.form, Form::Bounded { .. })
    }

    /// A direction in its own frame.
    #[inline(always)]
    fn along_axes(&self, direction: Vec3) -> Vec3 {
        self.axes.map_or(direction, |[x, y, z]| {
            Vec3::new(x.dot(direction), y.dot(direction), z.dot(direction))
        })
    }

    /// How far its core reaches in a direction of unit length, from its centre on.
    #[inline(always)]
    fn reach_along(&self, direction: Vec3) -> f32 {
        let along = self.along_axes(direction);
        match self.form {
            Form::Point | Form::Bounded { .. } => 0.0,
            Form::Segment { half_height } => half_height * along.z.abs(),
            Form::Cylinder { half_height, radius } => {
                half_height * along.z.abs() + radius * across(along)
            }
            Form::Box => self.half.dot(along.abs()),
        }
    }

    /// The core's point there, from its centre on.
    fn farthest(&self, direction: Vec3) -> Vec3 {
        let along = self.along_axes(direction);
        let end = |half_height: f32| half_height.copysign(along.z);
        let point = match self.form {
            Form::Point | Form::Bounded { .. } => Vec3::ZERO,
            Form::Segment { half_height } => Vec3::new(0.0, 0.0, end(half_height)),
            Form::Cylinder { half_height, radius } => {
                let across = across(along);
                let rim = if across > 0.0 { radius / across } else { 0.0 };
                Vec3::new(along.x * rim, along.y * rim, end(half_height))
            }
            Form::Box => self.half.copysign(along),
        };
        let turned = |[x, y, z]: [Vec3; 3]| x * point.x + y * point.y + z * point.z;
        self.axes.map_or(point, turned)
    }
}

/// How much of a direction is across the z axis.
#[inline(always)]
fn across(direction: Vec3) -> f32 {
    (direction.x * direction.x + direction.y * direction.y).sqrt()
}

impl Support for &Solid {
    #[inline(always)]
    fn reach<L: Lanes>(&self, _: L, direction: Vec3) -> f32 {
        self.reach_along(direction)
    }

    #[inline(always)]
    fn point<L: Lanes>(&self, _: L, direction: Vec3) -> Vec3 {
        self.farthest(direction) + self.centre
    }

    fn origin(&self) -> Vec3 {
        self.centre
    }

    fn margin(&self) -> f32 {
        self.swept + self.margin
    }
}

impl Solid {
    /// A direction from the obstacle to a point near it.
    pub(super) fn towards(&self, point: Vec3) -> Vec3 {
        let from = point - self.centre;
        let beyond = |x: f32, half: f32| x.signum() * (x.abs() - half).max(0.0);
        let of_box = |x: Vec3| {
            let half = self.half;
            Vec3::new(beyond(x.x, half.x), beyond(x.y, half.y), beyond(x.z, half.z))
        };
        let away = match self.axes {
            None => of_box(from),
            Some([x, y, z]) => {
                let away = of_box(Vec3::new(x.dot(from), y.dot(from), z.dot(from)));
                x * away.x + y * away.y + z * away.z
            }
        };
        if away == Vec3::ZERO { from } else { away }
    }
}

#[inline(always)]
fn from_point<L: Lanes>(l: L, [x, y, z]: [L::F; 3], point: Vec3) -> [L::F; 3] {
    [l.sub(x, l.splat(point.x)), l.sub(y, l.splat(point.y)), l.sub(z, l.splat(point.z))]
}

#[inline(always)]
fn along<L: Lanes>(l: L, [x, y, z]: [L::F; 3], axis: Vec3) -> L::F {
    let sum = l.mul(x, l.splat(axis.x));
    l.mul_add(z, l.splat(axis.z), l.mul_add(y, l.splat(axis.y), sum))
}

/// How far a coordinate is beyond ± half.
#[inline(always)]
fn beyond<L: Lanes>(l: L, x: L::F, half: f32) -> L::F {
    l.max(l.sub(l.abs(x), l.splat(half)), l.splat(0.0))
}

#[inline(always)]
fn squared<L: Lanes>(l: L, [x, y, z]: [L::F; 3]) -> L::F {
    l.mul_add(x, x, l.mul_add(y, y, l.mul(z, z)))
}

/// Where such a distance may be within reach. Written so that a NaN is.
#[inline(always)]
pub(super) fn within<L: Lanes>(l: L, square: L::F, reach: L::F) -> u32 {
    let reach = l.mul_add(reach, reach, l.splat(f32::MIN_POSITIVE));
    ALL & !l.bits(l.lt(reach, square))
}

/// Where it is proved to be at most that; what underflows is below the least normal number. A NaN is not.
#[inline(always)]
pub(super) fn inside<L: Lanes>(l: L, square: L::F, reach: L::F) -> u32 {
    let square = l.add(square, l.splat(f32::MIN_POSITIVE));
    let is_some = l.lt(l.splat(0.0), reach);
    l.bits(l.and(is_some, l.le(square, l.mul(reach, reach))))
}

const ALL: u32 = 0xffff;

/// The closed form of a shape that has one, wherever it is.
struct ClosedForm {
    form: Form,
    half: DVec3,
    swept: f64,
    reach: f64,
}

impl ClosedForm {
    fn of(shape: &Shape) -> Option<Self> {
        let (form, half, swept) = match shape {
            Shape::Polytope(polytope) => {
                let (form, half) = core_of(polytope)?;
                (form, half, polytope.swept_radius())
            }
            Shape::Curved(curved) if curved.kind() == CurvedKind::Cylinder => {
                let (half_height, radius) = (curved.half_height() as f32, curved.radius() as f32);
                (Form::Cylinder { half_height, radius }, DVec3::ZERO, curved.swept_radius())
            }
            _ => return None,
        };
        Some(Self { form, half, swept, reach: shape.reach() })
    }

    /// None where the pose turns by what is too far from a rotation, and none beyond [`FAR`].
    fn at(&self, pose: &Pose) -> Option<Solid> {
        let size = self.reach + pose.translation().abs().max_element();
        if !(pose.deviation() <= RIGID && size <= f64::from(FAR)) {
            return None;
        }
        let axes = pose.rotation();
        let turned = *axes != glam::DMat3::IDENTITY;
        Some(Solid {
            form: self.form,
            axes: turned.then(|| [axes.x_axis, axes.y_axis, axes.z_axis].map(|a| a.as_vec3())),
            centre: pose.translation().as_vec3(),
            half: self.half.as_vec3(),
            swept: self.swept as f32,
            margin: margin_of(size),
            corners: 0..0,
            round: 0.0,
        })
    }
}

/// The form of a polytope that has one, and its half extents if it is a cuboid. Looks at vertices where it has to: a
/// cuboid's are not in any cache in a world that is new.
fn core_of(polytope: &Polytope) -> Option<(Form, DVec3)> {
    let vertices = || polytope.vertices();
    let on_axis = || vertices().iter().all(|v| v.x == 0.0 && v.y == 0.0);
    let form = match polytope.kind() {
        Kind::Cuboid { half_extents } => return Some((Form::Box, half_extents)),
        Kind::Point if on_axis() && vertices()[0].z == 0.0 => Form::Point,
        Kind::Segment if on_axis() && vertices()[0].z == -vertices()[1].z => {
            Form::Segment { half_height: vertices()[1].z.abs() as f32 }
        }
        _ => return None,
    };
    Some((form, DVec3::ZERO))
}

/// Any shape by its box and its spheres.
fn bounded(shape: &Shape, pose: &Pose, aabb: &Aabb) -> Solid {
    let (min, max) = (aabb.min.as_dvec3(), aabb.max.as_dvec3());
    let (middle, half) = (min * 0.5 + max * 0.5, max * 0.5 - min * 0.5);
    let (mut outer, mut inner) = ((Vec3::ZERO, f32::INFINITY), (Vec3::ZERO, f32::NEG_INFINITY));
    if let Some(bounds) = SphereBounds::of(shape) {
        let (round, in_it) = (bounds.sphere(pose), bounds.inner_sphere(pose));
        let radius = inner_radius(f64::from(in_it.radius));
        (outer, inner) = ((round.centre, round.radius), (in_it.centre, radius));
    }
    let size = middle.abs().max_element() + half.max_element();
    Solid {
        form: Form::Bounded { outer, inner },
        axes: None,
        centre: middle.as_vec3(),
        half: half.as_vec3(),
        swept: 0.0,
        margin: margin_of(size),
        corners: 0..0,
        round: 0.0,
    }
}

/// An inner radius as it is compared: none beyond [`FAR`], so that no square that overflows is at most another.
pub(super) fn inner_radius(radius: f64) -> f32 {
    if radius <= f64::from(FAR) { radius as f32 } else { f32::NEG_INFINITY }
}

/// The margin of what has that size, rounded up.
pub(super) fn margin_of(size: f64) -> f32 {
    ((MARGIN * size) as f32).next_up().max(f32::MIN_POSITIVE)
}

#[cfg(test)]
mod tests;
