//! A box whose farthest corners are cut off.

use super::{Budget, Near, beyond, holds_all};
use dcd_geom::Polytope;
use dcd_geom::glam::DVec3;

/// How far outside of the shape the planes stay, as a part of the tolerance: covers the rounding
/// of their corners and is taken from what the outer hull may be off by.
const MARGIN: f64 = 1.0 / 64.0;

/// The least margin, relative to the shape's size: corners between nearly parallel planes lose
/// some thousand ulps.
const LEAST: f64 = 1e-9;

/// How often the margin is widened eightfold where the shape is not held.
const ATTEMPTS: i32 = 4;

/// Points whose hull contains the shape's core, exactly.
pub(super) fn round(shape: &Polytope, budget: Budget) -> Near {
    let least = (budget.tolerance * MARGIN).max(LEAST * shape.outer_radius());
    for attempt in 0..ATTEMPTS {
        let near = Cut::new(shape, least * 8f64.powi(attempt)).down_to(budget);
        let hull = Polytope::hull(near.points.clone());
        if hull.is_ok_and(|hull| holds_all(&hull, shape.vertices())) {
            return near;
        }
    }
    // The box of the vertices' own coordinates holds them as they are.
    let (low, high) = extent(shape);
    let corners: Vec<DVec3> = (0..8).map(|k| corner(k, low, high)).collect();
    let distance = corners.iter().fold(0.0, |most: f64, &c| most.max(beyond(c, shape).0));
    Near { points: corners, distance }
}

fn extent(shape: &Polytope) -> (DVec3, DVec3) {
    let (low, high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    shape.vertices().iter().fold((low, high), |(low, high), &v| (low.min(v), high.max(v)))
}

/// Corner k of a box, x fastest.
fn corner(k: usize, low: DVec3, high: DVec3) -> DVec3 {
    let side = |axis: usize| if k >> axis & 1 == 0 { low[axis] } else { high[axis] };
    DVec3::new(side(0), side(1), side(2))
}

/// A simple polytope round the shape: at each corner three planes meet.
#[derive(Clone)]
struct Cut<'a> {
    shape: &'a Polytope,
    margin: f64,
    corners: Vec<Corner>,
    planes: u32,
}

#[derive(Clone, Copy)]
struct Corner {
    at: DVec3,
    planes: [u32; 3],
    /// How far it is from the shape, at least, and the direction to it.
    distance: f64,
    outward: DVec3,
}

impl<'a> Cut<'a> {
    fn new(shape: &'a Polytope, margin: f64) -> Self {
        let (low, high) = extent(shape);
        let (low, high) = (low - margin, high + margin);
        let mut cut = Self { shape, margin, corners: Vec::new(), planes: 6 };
        for k in 0..8 {
            let planes = [0, 1, 2].map(|axis| 2 * axis + (k as u32 >> axis & 1));
            let at = cut.corner(corner(k, low, high), planes);
            cut.corners.push(at);
        }
        cut
    }

    fn corner(&self, at: DVec3, planes: [u32; 3]) -> Corner {
        let (distance, outward) = beyond(at, self.shape);
        Corner { at, planes, distance, outward }
    }

    /// Cuts until the tolerance is met, the vertices are used up, or nothing is left to gain.
    fn down_to(mut self, budget: Budget) -> Near {
        while let Some(farthest) = self.farthest()
            && farthest.distance > budget.tolerance
            && farthest.distance > 2.0 * self.margin
        {
            let mut next = self.clone();
            if !next.cut_off(&farthest) || next.corners.len() > budget.vertices {
                break;
            }
            self = next;
        }
        let distance = self.farthest().map_or(0.0, |corner| corner.distance);
        Near { points: self.corners.iter().map(|corner| corner.at).collect(), distance }
    }

    fn farthest(&self) -> Option<Corner> {
        self.corners.iter().copied().max_by(|a, b| a.distance.total_cmp(&b.distance))
    }

    /// Cuts with the plane that touches the shape, but for the margin, across the direction to
    /// `corner`. False where it would cut nothing off.
    fn cut_off(&mut self, corner: &Corner) -> bool {
        let normal = corner.outward;
        let along = |v: &DVec3| normal.dot(*v);
        let end = self.shape.vertices().iter().map(along).fold(f64::NEG_INFINITY, f64::max);
        let height = |c: &Corner| normal.dot(c.at) - (end + self.margin);
        let (off, kept): (Vec<Corner>, Vec<Corner>) =
            self.corners.iter().partition(|&c| height(c) > 0.0);
        if off.is_empty() || kept.is_empty() {
            return false;
        }
        let mut corners = kept.clone();
        for gone in &off {
            for stays in &kept {
                let Some(edge) = shared(gone.planes, stays.planes) else { continue };
                let (above, below) = (height(gone), -height(stays));
                let at = gone.at.lerp(stays.at, above / (above + below));
                corners.push(self.corner(at, [edge[0], edge[1], self.planes]));
            }
        }
        self.corners = corners;
        self.planes += 1;
        true
    }
}

/// The two planes in which both corners lie, if they are the ends of an edge.
fn shared(a: [u32; 3], b: [u32; 3]) -> Option<[u32; 2]> {
    let mut both = a.into_iter().filter(|plane| b.contains(plane));
    let edge = [both.next()?, both.next()?];
    both.next().is_none().then_some(edge)
}
