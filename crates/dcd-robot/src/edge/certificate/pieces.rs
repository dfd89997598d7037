//! A shape as convex pieces, in an order in which neighbours are near each other.

use dcd_geom::{Curved, Mesh, Polytope, Pose, Shape};
use glam::DVec3;
use std::ops::Range;

/// The convex pieces of a body, in its own frame.
#[derive(Clone, Debug)]
pub(in super::super) struct Pieces {
    pub(super) list: Vec<Piece>,
    /// Of a mesh its vertices, and the triangle of each piece.
    pub(super) surface: Option<(Vec<DVec3>, Vec<[u32; 3]>)>,
}

/// The hull of points, or of two discs, with a sphere swept round it.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    pub(super) core: Core,
    pub(super) radius: f64,
    /// In the body's frame, where points are not all that there is: of a compound's cylinders and cones.
    shape: Option<Shape>,
}

#[derive(Clone, Debug)]
pub(super) enum Core {
    Points(Vec<DVec3>),
    /// Discs normal to z: heights and radii; where they have a place of their own, that.
    Discs([(f64, f64); 2], Option<Pose>),
}

impl Pieces {
    /// None of a shape without an end, or known by its support map alone.
    pub(super) fn of(shape: &Shape) -> Option<Self> {
        let convex = |list| Some(Self { list, surface: None });
        match shape {
            Shape::Polytope(polytope) => convex(vec![Piece::of_polytope(polytope)]),
            Shape::Curved(curved) => convex(vec![Piece::of_curved(curved, None)]),
            Shape::Compound(compound) => {
                let curved = |part: &dcd_geom::Part, curved: &Curved, pose| Piece {
                    shape: Some(part.placed().clone()),
                    ..Piece::of_curved(curved, pose)
                };
                let piece = |part: &dcd_geom::Part| match part.placed() {
                    Shape::Polytope(polytope) => Some(Piece::of_polytope(polytope)),
                    Shape::Curved(still) => Some(curved(part, still, None)),
                    _ => part.moved_curved().map(|moved| curved(part, moved, Some(part.pose))),
                };
                let list: Option<Vec<Piece>> = compound.parts().iter().map(piece).collect();
                let mut list = list?;
                in_order(&mut list, &Piece::middle);
                convex(list)
            }
            Shape::Mesh(mesh) => Some(Self::of_mesh(mesh)),
            _ => None,
        }
    }

    fn of_mesh(mesh: &Mesh) -> Self {
        let points = mesh.vertices().to_vec();
        let corners = |triangle: &[u32; 3]| triangle.map(|k| points[k as usize]);
        let mut triangles = mesh.triangles().to_vec();
        in_order(&mut triangles, &|triangle| corners(triangle).iter().sum::<DVec3>() / 3.0);
        let piece = |triangle: &[u32; 3]| Piece {
            core: Core::Points(corners(triangle).to_vec()),
            radius: mesh.swept_radius(),
            shape: None,
        };
        let list = triangles.iter().map(piece).collect();
        Self { list, surface: Some((points, triangles)) }
    }

    pub(in super::super) fn all(&self) -> Range<u32> {
        0..self.list.len() as u32
    }

    fn within(&self, range: &Range<u32>) -> &[Piece] {
        &self.list[range.start as usize..range.end as usize]
    }

    /// The largest p·d of points p of some pieces, without a bound on rounding.
    pub(in super::super) fn along(&self, range: &Range<u32>, d: DVec3) -> f64 {
        let length = d.length();
        let far = |piece: &Piece| piece.core.along(d) + piece.radius * length;
        self.within(range).iter().map(far).fold(f64::NEG_INFINITY, f64::max)
    }

    /// A convex shape about as large as the hull of some pieces, of one alone that piece; for directions, which need no proof.
    pub(in super::super) fn hull(&self, range: &Range<u32>) -> Option<Shape> {
        let pieces = self.within(range);
        // Where little is between two bodies, a direction across corners in place of a disc does not part them.
        if let [Piece { shape: Some(shape), .. }] = pieces {
            return Some(shape.clone());
        }
        let radius = pieces.iter().map(|piece| piece.radius).fold(0.0, f64::max);
        let points = match &self.surface {
            Some((points, _)) if *range == self.all() => points.clone(),
            _ => pieces.iter().flat_map(|piece| piece.core.corners()).collect(),
        };
        Shape::hull(points).and_then(|hull| hull.rounded(radius)).ok()
    }
}

/// Cut in halves at the median along the longest side of what their middles span, and again.
fn in_order<T>(list: &mut [T], middle: &impl Fn(&T) -> DVec3) {
    if list.len() < 3 {
        return;
    }
    let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let span = list.iter().map(middle).fold(none, |(min, max), p| (min.min(p), max.max(p)));
    let extent = span.1 - span.0;
    let axis = (0..3).max_by(|&i, &j| extent[i].total_cmp(&extent[j])).unwrap_or(0);
    list.sort_by(|a, b| middle(a)[axis].total_cmp(&middle(b)[axis]));
    let (first, second) = list.split_at_mut(list.len() / 2);
    in_order(first, middle);
    in_order(second, middle);
}

impl Piece {
    fn of_polytope(polytope: &Polytope) -> Self {
        let core = Core::Points(polytope.vertices().to_vec());
        Self { core, radius: polytope.swept_radius(), shape: None }
    }

    fn of_curved(curved: &Curved, pose: Option<Pose>) -> Self {
        let core = Core::Discs(curved.discs(), pose);
        Self { core, radius: curved.swept_radius(), shape: None }
    }

    fn middle(&self) -> DVec3 {
        let corners = self.core.corners();
        corners.iter().sum::<DVec3>() / corners.len().max(1) as f64
    }
}

impl Core {
    fn along(&self, d: DVec3) -> f64 {
        match self {
            Self::Points(points) => {
                points.iter().map(|p| p.dot(d)).fold(f64::NEG_INFINITY, f64::max)
            }
            Self::Discs(discs, pose) => {
                let local = pose.map_or(d, |pose| pose.rotation().transpose() * d);
                let across = local.x.hypot(local.y);
                let [a, b] = discs.map(|(z, radius)| z * local.z + radius * across);
                a.max(b) + pose.map_or(0.0, |pose| pose.translation().dot(d))
            }
        }
    }

    /// Points whose hull is about the core.
    fn corners(&self) -> Vec<DVec3> {
        match self {
            Self::Points(points) => points.clone(),
            Self::Discs(discs, pose) => {
                let corner = |(z, radius): (f64, f64), k: u32| {
                    let (sin, cos) = libm::sincos(std::f64::consts::TAU * f64::from(k) / 16.0);
                    let p = DVec3::new(radius * cos, radius * sin, z);
                    pose.map_or(p, |pose| pose.apply(p))
                };
                discs.iter().flat_map(|&disc| (0..16).map(move |k| corner(disc, k))).collect()
            }
        }
    }
}
