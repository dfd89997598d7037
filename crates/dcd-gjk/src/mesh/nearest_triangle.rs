//! Which triangles of a mesh are nearest to convex shapes, and how far that is at the accuracy of f32.
//!
//! Triangles are met by the nearest boxes. One that was measured leaves a direction along which the shape is apart from
//! it, and mostly from its neighbours: a triangle that is as far away along one as the nearest is known to be needs
//! no search (docs/numerics/proofs.md, "Nearest triangles").

use super::distance::Limited;
use super::pair::Core;
use super::reach::{Couple, SecondAlong};
use super::relative_pose::RelativePose;
use super::separating_planes::SeparatingPlanes;
use super::side::{Part, Parts, Side};
use super::{Scratch, in_order, two_meshes};
use crate::distance::{Distance, DistanceResult, Nearer, nearer};
use crate::{PosedShape, PosedSupport};
use dcd_geom::glam::DVec3;
use dcd_geom::{LeafFilter, Mesh, Shape};
use dcd_simd::{Lanes, PointDistance};
use std::cell::RefCell;

/// How many directions are kept; the oldest goes first. No unit. Smaller: triangles measured for nothing. Larger: more
/// directions to try each triangle along. Never an answer.
const MOST: usize = 8;

/// How much nearer than the nearest a triangle may be that is not measured, relative to the pair's size: far within the
/// accuracy of f32. Larger: wider bounds. Smaller: all triangles round the nearest corner are measured.
const CLOSE: f64 = 1e-9;

/// How near the bounds of a distance have to come, relative to the shape's diameter. Larger: the bound is above what
/// the accuracy of f32 promises. Smaller: more supports.
const GAP: f64 = 1e-6;

/// The most parts of a compound, which are measured one by one. More: both trees are quicker.
const PARTS: usize = 16;

/// The distance of a mesh and another, a convex shape or a compound of few; `None` of others, where f64 leaves open whether they
/// touch, and where a length is out of range.
///
/// (a, b) and (b, a) give the same bits, mirrored. What is at least `far` apart, metres, need not be measured.
pub(crate) fn distance_in_f32([a, b]: [PosedShape<'_>; 2], far: f64) -> Option<Limited> {
    let is_mesh = |side: PosedShape<'_>| matches!(side.shape, Shape::Mesh(_));
    if !is_mesh(a) && !is_mesh(b) {
        return None;
    }
    let ([first, second], swapped) = in_order(a, b);
    let relative = RelativePose::of(&first, &second)?;
    let mut nearest = Nearest::nearer_than(far);
    match search([&first, &second], &relative, &mut Scratch::default(), &mut nearest)? {
        Found::Touching => Some(Limited::Known(DistanceResult::Touching)),
        Found::Apart if nearest.best.is_none() => Some(Limited::Beyond),
        Found::Apart => {
            let found = DistanceResult::Apart(nearest.distance()?);
            Some(Limited::Known(if swapped { found.mirrored() } else { found }))
        }
    }
}

/// What f64 leaves of a mesh and a shape for the nearest pair of parts.
pub(super) enum Left {
    /// They touch.
    Touching,
    /// Pairs of a triangle and a part, by index in rising order: one of them is the nearest. None: they are at least as far
    /// apart as matters.
    Near(Vec<[u32; 2]>),
}

/// Which triangles of a mesh and parts of another, of a bounded convex shape or of a compound of few may be nearest to each other; `None` of others,
/// and where f64 leaves open whether they touch.
pub(super) fn nearest_parts(
    sides: [&Side<'_>; 2],
    relative: &RelativePose,
    scratch: &mut Scratch,
    far: f64,
) -> Option<Left> {
    let mut nearest = Nearest { measured: Some(Vec::new()), ..Nearest::nearer_than(far) };
    if let Found::Touching = search(sides, relative, scratch, &mut nearest)? {
        return Some(Left::Touching);
    }
    let (limit, mut measured) = (nearest.limit(), nearest.measured?);
    measured.retain(|one| one.lower <= limit);
    let mut near: Vec<[u32; 2]> = measured.iter().map(|one| one.parts).collect();
    near.sort_unstable();
    Some(Left::Near(near))
}

/// Meets the triangles of the first shape, a mesh, by each part of the second. `None` of other shapes, and where a triangle
/// could not be measured.
fn search(
    [first, second]: [&Side<'_>; 2],
    relative: &RelativePose,
    scratch: &mut Scratch,
    nearest: &mut Nearest,
) -> Option<Found> {
    let mut look_at = |part: u32, shape: &Shape| {
        let alone = Side { parts: Parts::One(shape), pose: second.pose, reach: second.reach };
        NearestTriangle::of([first, &alone], part, relative, nearest)?.run()
    };
    match second.parts {
        Parts::One(shape) => look_at(0, shape),
        Parts::Compound(compound) if compound.parts().len() <= PARTS => {
            let mut found = Found::Apart;
            for (number, part) in (0..).zip(compound.parts()) {
                found = look_at(number, part.placed())?;
                if matches!(found, Found::Touching) {
                    break;
                }
            }
            Some(found)
        }
        Parts::Mesh(_) => two_meshes::meet([first, second], relative, scratch, nearest),
        Parts::Compound(_) => None,
    }
}

/// Whether the shape touches a triangle.
pub(super) enum Found {
    Apart,
    Touching,
}

/// The nearest so far, from the mesh.
pub(super) struct Nearest {
    best: Option<Distance>,
    /// What is at least so far away does not matter, metres.
    far: f64,
    /// At most the distance of every triangle that was met.
    lower: f64,
    /// What was measured, where all that may be the nearest are wanted.
    measured: Option<Vec<Measured>>,
}

/// A triangle and a part of the other shape, by index, and at most how far apart they are.
struct Measured {
    parts: [u32; 2],
    lower: f64,
}

impl Nearest {
    /// Of none yet, and of those alone that are nearer than that: metres.
    pub(super) fn nearer_than(far: f64) -> Self {
        Self { best: None, far, lower: f64::INFINITY, measured: None }
    }

    /// What is at least so far away does not change what is known; where all that may be the nearest are wanted, is none
    /// of them.
    pub(super) fn limit(&self) -> f64 {
        let limit = |best: Distance| match self.measured {
            Some(_) => (best.distance + best.error_bound).next_up(),
            None => best.distance - best.error_bound,
        };
        self.best.map_or(f64::MAX, limit).min(self.far)
    }

    /// How much nearer than that what is passed by may be, relative to the pair's size. Where nothing is measured yet no bound counts
    /// what is passed by.
    pub(super) fn close(&self) -> f64 {
        if self.measured.is_some() || self.best.is_none() { 0.0 } else { CLOSE }
    }

    /// Takes in that a pair of parts is at least so far apart and not measured.
    pub(super) fn pass(&mut self, lower: f64) {
        self.lower = self.lower.min(lower);
    }

    pub(super) fn add(&mut self, parts: [u32; 2], found: Distance) {
        let lower = found.distance - found.error_bound;
        self.lower = self.lower.min(lower);
        if let Some(measured) = &mut self.measured {
            measured.push(Measured { parts, lower });
        }
        if self.best.is_none_or(|best| found.distance < best.distance) {
            self.best = Some(found);
        }
    }

    fn distance(&self) -> Option<Distance> {
        let best = self.best?;
        // Another may be nearer than the nearest by its own bound.
        let below = (best.distance - self.lower).next_up();
        let error_bound = best.error_bound.max(below).min(f64::MAX);
        (best.distance > error_bound).then_some(Distance { error_bound, ..best })
    }
}

/// The search for the triangle of a mesh that is nearest to a convex shape.
struct NearestTriangle<'a> {
    mesh: &'a Mesh,
    /// The mesh, and the shape as if it were alone.
    sides: [&'a Side<'a>; 2],
    /// Which part of the other shape that is.
    part: u32,
    relative: &'a RelativePose,
    body: PosedSupport<'a, Shape>,
    /// Any triangle and the shape: what is the same of all.
    couple: Couple<'a>,
    slack: f64,
    directions: [Option<SecondAlong>; MOST],
    oldest: usize,
    /// The same directions for the lanes.
    planes: SeparatingPlanes,
    nearest: &'a mut Nearest,
}

impl<'a> NearestTriangle<'a> {
    fn of(
        sides: [&'a Side<'a>; 2],
        part: u32,
        relative: &'a RelativePose,
        nearest: &'a mut Nearest,
    ) -> Option<Self> {
        let [first, second] = sides;
        let (mesh, Parts::One(shape)) = (first.mesh()?, second.parts) else { return None };
        if !shape.is_bounded() {
            return None;
        }
        let couple = Couple::of([first.part(0), Part::Shape(shape)], [first.pose, second.pose])?;
        Some(Self {
            mesh,
            sides,
            part,
            relative,
            body: PosedSupport::shape(shape, second.pose),
            slack: couple.slack(),
            couple,
            directions: [const { None }; MOST],
            oldest: 0,
            planes: SeparatingPlanes::default(),
            nearest,
        })
    }

    /// `None` where a triangle could not be measured.
    fn run(mut self) -> Option<Found> {
        let boxes = PointDistance::from_box(&self.relative.around(self.sides[1]));
        if self.nearest.best.is_none()
            && let first @ (None | Some(Found::Touching)) = self.meet(self.likely())
        {
            return first;
        }
        let (mesh, limit) = (self.mesh, self.key(&boxes));
        let search = RefCell::new(self);
        let mut found = Some(Found::Apart);
        mesh.tree().visit_filtered((&boxes, &NotFarther(&search)), limit, &mut |triangle, _| {
            let mut search = search.borrow_mut();
            match search.meet(triangle) {
                Some(Found::Apart) => search.key(&boxes),
                other => {
                    found = other;
                    -1.0
                }
            }
        });
        found
    }

    /// A triangle of the box that is near the shape's middle.
    fn likely(&self) -> u32 {
        let middle = self.relative.rotation * self.body.centre + self.relative.offset;
        let mut likely = 0;
        self.mesh.tree().visit(&PointDistance::new(middle), f32::MAX, &mut |triangle, _| {
            likely = triangle;
            -1.0
        });
        likely
    }

    /// At least how far a triangle is, in metres of the mesh's axes, that is no nearer than is known.
    fn limit(&self) -> f64 {
        self.nearest.limit().max(0.0) * self.relative.stretch()
    }

    fn key(&self, boxes: &PointDistance) -> f32 {
        boxes.key_of(self.limit())
    }

    /// Measures a triangle, unless a direction shows that it is no nearer.
    fn meet(&mut self, triangle: u32) -> Option<Found> {
        let [mesh, _] = self.sides;
        let part = mesh.part(triangle);
        let Part::Triangle { corners, .. } = part else { return None };
        let limit = self.nearest.limit();
        let lower = self.lower(&corners);
        if lower >= limit - self.nearest.close() * self.couple.size() {
            self.nearest.pass(lower);
            return Some(Found::Apart);
        }
        let core = Core::of(&part)?;
        let gap = 2.0 * GAP * self.body.reach;
        match nearer(core.body(mesh.pose), self.body, [gap, limit]) {
            Nearer::Apart(found) => {
                self.keep(found.normal);
                self.nearest.add([triangle, self.part], found);
            }
            Nearer::Beyond(direction) => self.keep(direction),
            Nearer::Touching => return Some(Found::Touching),
            Nearer::Unknown => return None,
        }
        Some(Found::Apart)
    }

    /// At most how far a triangle is from the shape, as the directions know it.
    fn lower(&self, corners: &[DVec3; 3]) -> f64 {
        let mut least = f64::INFINITY;
        for along in self.directions.iter().flatten() {
            let reach = along.of_triangle(corners);
            least = if reach < least { reach } else { least };
        }
        -(least + self.slack)
    }

    /// Keeps a direction from the mesh to the shape.
    fn keep(&mut self, direction: DVec3) {
        self.directions[self.oldest] = Some(self.couple.second_along(direction));
        self.oldest = (self.oldest + 1) % MOST;
        let [mesh, _] = self.sides;
        let along = mesh.pose.rotation().transpose() * -direction;
        self.planes.add(self.relative, self.sides, along);
    }
}

/// The triangles of a leaf that no plane proves to be no nearer than is known.
struct NotFarther<'s, 'a>(&'s RefCell<NearestTriangle<'a>>);

impl LeafFilter for NotFarther<'_, '_> {
    #[inline(always)]
    fn keep<L: Lanes>(&self, l: L, leaf: usize, lanes: u32) -> u32 {
        let search = self.0.borrow();
        let Some(triangles) = search.mesh.leaves().get(leaf) else { return lanes };
        search.planes.triangles_within(l, triangles, lanes, search.limit())
    }
}
