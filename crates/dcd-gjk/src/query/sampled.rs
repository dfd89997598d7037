//! The depth of shapes that are known by their support maps alone.
//!
//! A hull of support points is inside its shape, so the depth of two such hulls is at most the
//! shapes' depth; how far the shapes reach along any direction is at least that depth. Each round
//! finds the hulls' direction of least depth, goes downhill from there on the shapes' own
//! reach, and adds to the hulls the support points of where it arrives and of a ring round it,
//! until both bounds meet.

use crate::UNIT;
use crate::distance::{DistanceResult, of_polytopes};
use crate::epa::{Depth, Scratch, depth_of_overlap as depth_of_polytopes};
use crate::{PosedShape, PosedSupport, order};
use dcd_geom::glam::DVec3;
use dcd_geom::{Polytope, Pose, SupportMap};

/// How often the hulls grow. Ten are usual for an ellipsoid; the bounds stay as far apart as they
/// are where that is not enough. Larger: more time for shapes that are curved and flat at once.
const ROUNDS: usize = 16;

/// How much narrower the ring is in each round, no unit: a facet between the points of a ring of
/// radius ε lies about ε² of the shape's size below its surface.
const NARROWING: f64 = 1.0 / 8.0;

/// How often the ring on the way downhill is moved or halved; the last is as narrow as rounding.
const STEPS: usize = 64;

/// The cosine from which on two directions are so nearly one that the witnesses of either will do for both. Larger: witnesses of
/// hulls as they were first. Smaller: those of another direction that is as deep.
const ALIKE: f64 = 1.0 - 1e-6;

/// The angles from a normal, in radians, at which the ends of a face or an edge are looked for. Larger: points that are less far
/// along it. Smaller: directions that rounding makes one.
const ANGLES: [f64; 2] = [1e-4, 1e-7];

/// The relative gap at which the bounds have met: what is promised of a depth.
const GAP: f64 = 1e-9;

/// How deep two shapes overlap that are known to touch.
pub(super) fn depth_of_overlap(
    a: PosedShape<'_>,
    b: PosedShape<'_>,
    scratch: &mut Scratch,
) -> Depth {
    if order::is_swapped(a, b) {
        Couple { a: b, b: a }.depth(scratch).mirrored()
    } else {
        Couple { a, b }.depth(scratch)
    }
}

/// Two shapes in their order.
struct Couple<'a> {
    a: PosedShape<'a>,
    b: PosedShape<'a>,
}

impl Couple<'_> {
    fn depth(&self, scratch: &mut Scratch) -> Depth {
        let mut inside = [Inside::new(self.a), Inside::new(self.b)];
        let mut best = Depth { depth: f64::MAX, ..Depth::default() };
        let mut lower = 0.0f64;
        let mut width = 1.0;
        for _ in 0..ROUNDS {
            let [Some(hull_a), Some(hull_b)] = [inside[0].hull(), inside[1].hull()] else { break };
            let body_a = PosedSupport::polytope(&hull_a, self.a.pose);
            let body_b = PosedSupport::polytope(&hull_b, self.b.pose);
            let found = depth_of_polytopes(body_a, body_b, scratch);
            lower = lower.max(found.lower());
            let (depth, normal) = self.downhill(found.normal);
            if depth < best.depth {
                best = Depth { depth, normal, ..found };
            } else if found.normal.dot(best.normal) > ALIKE {
                // Those of finer hulls are nearer to the surfaces.
                (best.point_a, best.point_b) = (found.point_a, found.point_b);
            }
            width *= NARROWING;
            let mut grew = false;
            for direction in ring(best.normal, width).into_iter().chain([normal, found.normal]) {
                let [end_a, end_b] = self.ends(direction);
                grew |= inside[0].add(end_a) | inside[1].add(end_b);
            }
            if best.depth - lower <= GAP * best.depth || !grew {
                break;
            }
        }
        if let Some([point_a, point_b]) = self.witnesses(&best) {
            let other = Depth { point_a, point_b, ..best };
            best = if other.missed() < best.missed() { other } else { best };
        }
        let error = (best.depth - lower).max(0.0);
        Depth { error_bound: (error + 4.0 * UNIT * best.depth).min(f64::MAX), ..best }
    }

    /// Where the shapes are deepest along the normal of a depth, one point above the other. The points that are farthest along
    /// directions round the normal are what each shape shows there; their hulls are parted along it, and have nearest points.
    fn witnesses(&self, depth: &Depth) -> Option<[DVec3; 2]> {
        let normal = depth.normal;
        let (mut of_a, mut of_b) = (Vec::new(), Vec::new());
        let delta = self.b.pose.translation() - self.a.pose.translation();
        let rings = ANGLES.map(|angle| ring(normal, angle));
        for direction in rings.into_iter().flatten().chain([normal]) {
            let [end_a, end_b] = self.ends(direction);
            of_a.push(*self.a.pose.rotation() * end_a);
            of_b.push(*self.b.pose.rotation() * end_b + delta);
        }
        let radii = [self.a.shape.radius(), self.b.shape.radius()];
        let farthest = |points: &[DVec3]| points.iter().map(|p| p.length()).fold(0.0, f64::max);
        let parted = depth.depth - radii[0] - radii[1] + farthest(&of_a) + farthest(&of_b);
        of_b.iter_mut().for_each(|point| *point += normal * parted);
        let hulls = [Polytope::hull(of_a).ok()?, Polytope::hull(of_b).ok()?];
        let [a, b] = hulls.each_ref().map(|hull| PosedSupport::polytope(hull, &Pose::IDENTITY));
        let (DistanceResult::Apart(found), _) = of_polytopes(a, b) else { return None };
        let origin = self.a.pose.translation();
        let point_a = found.point_a + normal * radii[0];
        let point_b = found.point_b - normal * (parted + radii[1]);
        Some([origin + point_a, origin + point_b])
    }

    /// A direction near which no reach is less, and that reach.
    fn downhill(&self, from: DVec3) -> (f64, DVec3) {
        let (mut least, mut normal) = (self.reach(from), from);
        let mut width = 0.25;
        for _ in 0..STEPS {
            let around = ring(normal, width).map(|direction| (self.reach(direction), direction));
            let lowest = around.into_iter().min_by(|(r, _), (s, _)| r.total_cmp(s));
            match lowest {
                Some((reach, direction)) if reach < least => (least, normal) = (reach, direction),
                _ => width *= 0.5,
            }
            if width < UNIT {
                break;
            }
        }
        (least, normal)
    }

    /// The farthest points of the two cores, along a world direction and against it, each in its
    /// own frame.
    fn ends(&self, direction: DVec3) -> [DVec3; 2] {
        let farthest = |side: PosedShape<'_>, direction: DVec3| {
            side.shape.support(side.pose.rotation().transpose() * direction).point
        };
        [farthest(self.a, direction), farthest(self.b, -direction)]
    }

    /// At least how far A − B reaches along a unit direction.
    ///
    /// The direction's length, two rotations, products and sums lose at most 16u of the pair's
    /// size; 32u also cover the radii. A support falls short by its error in each component.
    fn reach(&self, normal: DVec3) -> f64 {
        let (a, b) = (self.a, self.b);
        let delta = a.pose.translation() - b.pose.translation();
        let [end_a, end_b] = self.ends(normal);
        let along = (*a.pose.rotation() * end_a - *b.pose.rotation() * end_b + delta).dot(normal);
        let radius = a.shape.radius() + b.shape.radius();
        let size = end_a.abs().element_sum() + end_b.abs().element_sum();
        let size = 1.1 * size + delta.abs().element_sum() + radius;
        let short = 2.0 * (a.shape.support_error() + b.shape.support_error());
        let reach = along + radius + 32.0 * UNIT * size + short;
        // A NaN of a foreign map bounds nothing.
        if reach >= 0.0 { reach.min(f64::MAX) } else { f64::MAX }
    }
}

/// Six unit directions at about this angle, in radians, round a unit direction.
fn ring(normal: DVec3, angle: f64) -> [DVec3; 6] {
    let (p, q) = normal.any_orthonormal_pair();
    let (half, root) = (0.5, 0.75f64.sqrt());
    let sixths =
        [(1.0, 0.0), (half, root), (-half, root), (-1.0, 0.0), (-half, -root), (half, -root)];
    sixths.map(|(x, y)| (normal + (p * x + q * y) * angle).normalize())
}

/// Points of a core in its own frame, whose hull is inside it.
struct Inside<'a> {
    shape: PosedShape<'a>,
    points: Vec<DVec3>,
    /// Its own vertices: nothing to grow.
    whole: bool,
}

impl<'a> Inside<'a> {
    fn new(shape: PosedShape<'a>) -> Self {
        if let Some(polytope) = shape.shape.as_polytope() {
            return Self { shape, points: polytope.vertices().to_vec(), whole: true };
        }
        let steps = || [-1.0, 0.0, 1.0].into_iter();
        let directions =
            steps().flat_map(|x| steps().flat_map(move |y| steps().map(move |z| [x, y, z])));
        let mut inside = Self { shape, points: Vec::with_capacity(26 + 8 * ROUNDS), whole: false };
        for direction in directions.map(DVec3::from_array).filter(|&d| d != DVec3::ZERO) {
            inside.add(shape.shape.support(direction).point);
        }
        inside
    }

    fn add(&mut self, point: DVec3) -> bool {
        let new = !self.whole && point.is_finite() && !self.points.contains(&point);
        if new {
            self.points.push(point);
        }
        new
    }

    /// `None` for a map that has no finite point.
    fn hull(&self) -> Option<Polytope> {
        let hull = Polytope::hull(self.points.clone()).ok()?;
        hull.rounded(self.shape.shape.radius()).ok()
    }
}
