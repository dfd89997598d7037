//! The triangles of a mesh that touch a polytope: no more of them are measured than may be the deepest.

use super::depths::{self, tolerance};
use super::{Accuracy, few_parts};
use crate::epa::{self, Depth};
use crate::mesh::{self, AS_DEEP, KnownParts, TouchingTriangle};
use crate::{PosedShape, Verdict};
use dcd_geom::glam::DVec3;
use dcd_geom::{Kind, Part, Polytope, Pose, Shape, SupportMap};
use std::ops::Range;

/// The triangles that touch, of which some are still looked at.
pub(super) struct OpenTriangles<'a> {
    pub(super) accuracy: Accuracy,
    pub(super) mesh: PosedShape<'a>,
    pub(super) bodies: &'a [Body<'a>],
    /// Those of one body after those of another.
    pub(super) triangles: &'a mut [TouchingTriangle],
    pub(super) memory: &'a mut epa::Scratch,
}

/// A polytope that touches a mesh, or a part of a compound that does, as it was given.
pub(super) struct Body<'a> {
    pub(super) side: PosedShape<'a>,
    pub(super) polytope: &'a Polytope,
    pub(super) part: Option<u32>,
    /// How far its points may be from those that answers are given for, metres.
    pub(super) moved: f64,
    /// Its triangles, by number.
    pub(super) triangles: Range<usize>,
}

impl<'a> Body<'a> {
    /// A polytope and all triangles; `None` of another shape.
    pub(super) fn whole(side: PosedShape<'a>, triangles: &[TouchingTriangle]) -> Option<Self> {
        let Shape::Polytope(polytope) = side.shape else { return None };
        Some(Self { side, polytope, part: None, moved: 0.0, triangles: 0..triangles.len() })
    }

    /// How far it reaches against a normal, from the mesh's origin, the radii of both counted.
    pub(super) fn below(&self, mesh: PosedShape<'_>, normal: DVec3) -> f64 {
        let local = self.side.pose.rotation().transpose() * -normal;
        let delta = self.side.pose.translation() - mesh.pose.translation();
        let core =
            local.dot(SupportMap::<f64>::support(self.polytope, local).point) - normal.dot(delta);
        core + (mesh.shape.radius() + self.polytope.swept_radius())
    }
}

/// Whether it is a compound of few polytopes.
pub(super) fn is_of_few(shape: &Shape) -> bool {
    let Shape::Compound(compound) = shape else { return false };
    let parts = compound.parts();
    parts.len() <= few_parts::MOST && parts.iter().all(|part| part.shape.as_polytope().is_some())
}

/// The parts of a compound that touch a mesh, by index, where they are and as they were given; and how far each may be from
/// where the compound has it. `None` where that is too far.
pub(super) fn touching_parts<'a>(
    whole: PosedShape<'a>,
    touching: &[[u32; 2]],
) -> Option<Vec<(u32, &'a Part, Pose, f64)>> {
    let Shape::Compound(compound) = whole.shape else { return None };
    let touches = |number: u32| touching.iter().any(|&[_, part]| part == number);
    let touching = (0..).zip(compound.parts()).filter(|&(number, _)| touches(number));
    let place = |(number, part): (u32, &'a Part)| {
        let (pose, moved) = few_parts::place(whole.pose, part)?;
        Some((number, part, pose, moved))
    };
    touching.map(place).collect()
}

/// How deep a mesh and a compound of few polytopes overlap that touch, at the accuracy of f32; `None` of other shapes, and
/// where a triangle cannot be measured.
///
/// (a, b) and (b, a) give the same bits, mirrored.
pub(super) fn depth_of_parts(
    [a, b]: [PosedShape<'_>; 2],
    memory: &mut epa::Scratch,
) -> Option<Depth> {
    let (sides, mesh) = match (a.shape, b.shape) {
        (Shape::Mesh(_), other) if is_of_few(other) => ([a, b], 0),
        (other, Shape::Mesh(_)) if is_of_few(other) => ([b, a], 1),
        _ => return None,
    };
    let (mut touching, mut triangles) = (Vec::new(), Vec::new());
    mesh::touching_or_open(sides, &mut mesh::Scratch::default(), &mut touching);
    let parts = touching_parts(sides[1], &touching)?;
    let bodies = &triangles_of_parts(sides[0], &parts, &touching, &mut triangles)?;
    let triangles = &mut triangles[..];
    let accuracy = Accuracy::F32;
    let (_, found) =
        OpenTriangles { accuracy, mesh: sides[0], bodies, triangles, memory }.deepest()?;
    Some(if mesh == 0 { found } else { found.mirrored() })
}

/// Appends the triangles of a mesh that touch these parts, each with its depth; the parts with theirs. `None`, and some
/// triangles, of other parts than polytopes, and where a length is out of range.
pub(super) fn triangles_of_parts<'a>(
    mesh: PosedShape<'_>,
    parts: &'a [(u32, &'a Part, Pose, f64)],
    touching: &[[u32; 2]],
    triangles: &mut Vec<TouchingTriangle>,
) -> Option<Vec<Body<'a>>> {
    let add = |(number, part, pose, moved): &'a (u32, &'a Part, Pose, f64)| {
        let Shape::Polytope(polytope) = &part.shape else { return None };
        let side = PosedShape { shape: &part.shape, pose };
        let first = triangles.len();
        let own = touching.iter().filter(|[_, part]| part == number);
        let good = tolerance(Accuracy::F32);
        let own = (own.map(|pair| pair[0]), KnownParts::default());
        mesh::touching_triangles([mesh, side], good, own, triangles)?;
        triangles[first..].iter_mut().for_each(|triangle| triangle.widen(*moved));
        let (part, triangles) = (Some(*number), first..triangles.len());
        Some(Body { side, polytope, part, moved: *moved, triangles })
    };
    parts.iter().map(add).collect()
}

/// How deep a mesh and a polytope overlap of which these parts touch; `None` of other shapes, and where a triangle cannot
/// be measured.
///
/// (a, b) and (b, a) give the same bits, mirrored.
pub(super) fn depth(
    accuracy: Accuracy,
    [a, b]: [PosedShape<'_>; 2],
    known: KnownParts<'_>,
    memory: &mut epa::Scratch,
) -> Option<Depth> {
    let (sides, mesh) = match (a.shape, b.shape) {
        (Shape::Mesh(_), _) => ([a, b], 0),
        _ => ([b, a], 1),
    };
    let good = tolerance(accuracy);
    if let Some(found) = mesh::deepest_by_formula(sides, good, (known, mesh)) {
        return Some(if mesh == 0 { found } else { found.mirrored() });
    }
    let mut triangles = Vec::with_capacity(known.parts.len());
    let numbers = known.parts.iter().map(|pair| pair[mesh]);
    mesh::touching_triangles(sides, good, (numbers, known), &mut triangles)?;
    let bodies = &[Body::whole(sides[1], &triangles)?];
    let triangles = &mut triangles[..];
    let (_, found) =
        OpenTriangles { accuracy, mesh: sides[0], bodies, triangles, memory }.deepest()?;
    Some(if mesh == 0 { found } else { found.mirrored() })
}

impl<'a> OpenTriangles<'a> {
    /// Of which body a triangle is.
    pub(super) fn body_of(&self, k: usize) -> Option<&'a Body<'a>> {
        self.bodies.iter().find(|body| body.triangles.contains(&k))
    }

    /// The deepest of the open triangles, and its depth with a bound that counts the others; `None` of none, and where one
    /// cannot be measured.
    pub(super) fn deepest(&mut self) -> Option<(usize, Depth)> {
        self.open().next()?;
        loop {
            match self.deepest_known() {
                Ok(found) => return Some(found),
                Err(k) => self.measure_one(k)?,
            }
        }
    }

    /// The same from what is known; a triangle that may be deeper is an error.
    fn deepest_known(&mut self) -> Result<(usize, Depth), usize> {
        let mut lead: Option<(usize, &Depth)> = None;
        let (mut upper, mut unknown) = (0.0f64, (f64::NEG_INFINITY, 0));
        for (k, triangle) in self.open() {
            match &triangle.depth {
                Some(depth) => {
                    upper = upper.max(depth.depth + depth.error_bound);
                    if lead.is_none_or(|(_, most)| depth.depth > most.depth) {
                        lead = Some((k, depth));
                    }
                }
                None if triangle.at_most > unknown.0 => unknown = (triangle.at_most, k),
                None => {}
            }
        }
        let (k, most) = lead.map(|(k, most)| (k, *most)).ok_or(unknown.1)?;
        if unknown.0 > f64::NEG_INFINITY {
            upper = upper.max(self.most_of_unknown(&most)?);
        }
        let above = (upper - most.depth).next_up().min(f64::MAX);
        Ok((k, Depth { error_bound: most.error_bound.max(above), ..most }))
    }

    /// An upper bound of how deep each triangle is that is not measured, if none may be deeper than that; else the one of which least is
    /// known is an error.
    fn most_of_unknown(&mut self, most: &Depth) -> Result<f64, usize> {
        let limit = most.depth * (1.0 + AS_DEEP);
        let (mut upper, mut deeper) = (0.0f64, None);
        for body in self.bodies {
            let triangles = &mut self.triangles[body.triangles.clone()];
            let is_unknown =
                |triangle: &TouchingTriangle| triangle.is_open && triangle.depth.is_none();
            if !triangles.iter().any(is_unknown) {
                continue;
            }
            let below = body.below(self.mesh, most.normal);
            let unknown =
                triangles.iter_mut().enumerate().filter(|(_, triangle)| is_unknown(triangle));
            for (k, triangle) in unknown {
                let along = reach(triangle, most.normal, below) + triangle.slack + body.moved;
                let at_most = triangle.at_most.min(along);
                // Written so that NaN is deeper.
                if at_most <= limit {
                    triangle.at_most = at_most;
                    upper = upper.max(at_most);
                } else if deeper.is_none_or(|(other, _)| triangle.at_most > other) {
                    deeper = Some((triangle.at_most, body.triangles.start + k));
                }
            }
        }
        deeper.map_or(Ok(upper), |(_, k)| Err(k))
    }

    /// By a search, which no formula replaces.
    pub(super) fn measure_one(&mut self, k: usize) -> Option<()> {
        let (mesh, body) = (self.mesh, self.body_of(k)?);
        let Shape::Mesh(of_mesh) = mesh.shape else { return None };
        let corners = of_mesh.corners(self.triangles[k].triangle as usize)?;
        let triangle =
            Polytope::mesh_triangle(corners).ok()?.rounded(of_mesh.swept_radius()).ok()?;
        let depth = self.search(triangle, body)?;
        let error_bound = depth.error_bound + body.moved;
        self.triangles[k].depth = Some(Depth { error_bound, ..depth });
        Some(())
    }

    fn search(&mut self, triangle: Polytope, body: &Body<'_>) -> Option<Depth> {
        let shape = Shape::from(triangle);
        let placed = PosedShape { shape: &shape, pose: self.mesh.pose };
        // No formula is left to try of a hull.
        if self.accuracy == Accuracy::F32 && body.polytope.kind() == Kind::Hull {
            let (lanes, _) = self.memory.searches();
            if let Some(found) = lanes.depth(Accuracy::F32, [placed, body.side]) {
                return Some(found.depth);
            }
        }
        match depths::of_touching(self.accuracy, placed, body.side, self.memory) {
            Verdict::Touching(depth) => Some(depth),
            _ => None,
        }
    }

    pub(super) fn open(&self) -> impl Iterator<Item = (usize, &TouchingTriangle)> {
        self.triangles.iter().enumerate().filter(|(_, triangle)| triangle.is_open)
    }
}

/// How far a triangle and a body reach past each other along a normal, rounded.
pub(super) fn reach(triangle: &TouchingTriangle, normal: DVec3, below: f64) -> f64 {
    let [p, q, r] = triangle.corners;
    normal.dot(p).max(normal.dot(q)).max(normal.dot(r)) + below
}
