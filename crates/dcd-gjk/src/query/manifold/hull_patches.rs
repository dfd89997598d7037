//! The manifolds of hulls and capsules, eight pairs at a time in f64: what [`super::hull_pair`] finds corner by corner, without
//! its branches.
//!
//! Each corner of what two features have in common is found by itself: where an edge of the one that is clipped comes into the
//! face that clips and goes out, where the corners of that face are, and where its sides meet the surface. What is no
//! corner of a pair has no depth (docs/numerics/proofs.md, "manifolds").

mod choose;
mod clip;
mod rows;
mod several;

use super::corners::share_no_corners;
use super::facing::Part;
use super::feature_code::FeatureCode;
use super::leaning_edge::level_of_edge;
use super::patch_writer::{PatchWriter, Point};
use super::{SAME, bound_of, bound_of_witnesses, unevenness};
use crate::order;
use crate::query::{FoundDepth, FoundPair};
use dcd_geom::glam::DVec3;
use dcd_geom::{Kind, Polytope};
use dcd_simd::Lanes;
use rows::{CORNERS, SLOTS, write};
pub(super) use rows::{PAIRS, Packet};
pub(super) use several::WriteSeveral;

/// What a place of a patch is by: below it a side of the face that clips, from it on a corner of it, by their numbers.
const CORNER: f64 = CORNERS as f64;

/// By the surface, where the depth is 0.
const SURFACE: f64 = 2.0 * CORNER;

/// By itself: a corner of what is clipped.
const VERTEX: f64 = 3.0 * CORNER;

/// How far the shapes may reach from their own origins, by their size: what rounding takes of their coordinates is far below
/// what the lanes count as beside a side. Larger: corners that are lost. Smaller: shapes that go pair by pair.
const REACH: f64 = 8.0;

/// Two polytopes, and what they show along the normal.
struct Shown<'a> {
    pair: &'a FoundPair<'a>,
    polytopes: [&'a Polytope; 2],
    parts: [Part<'a>; 2],
    /// How square to the normal the faces are; 0 of an edge.
    facing: [f64; 2],
    /// Which of the two clips.
    clips: usize,
}

/// How the manifold of two polytopes is found.
enum Way {
    /// As that of a pair alone.
    Alone,
    /// They touch in the witnesses of their depth.
    InOnePoint,
    /// A face clips.
    Patch,
}

impl<'a> Shown<'a> {
    /// What two polytopes of that depth show; `None` of others, of spheres, which show nothing of their own, and of two
    /// cuboids, which are clipped in the axes of one.
    ///
    /// The same whichever of the two is a.
    #[inline(always)]
    fn of(pair: &'a FoundPair<'a>) -> Option<Self> {
        let [a, b] = pair.sides;
        let polytopes = [a.shape.as_polytope()?, b.shape.as_polytope()?];
        let is_cuboid = |polytope: &Polytope| matches!(polytope.kind(), Kind::Cuboid { .. });
        let fewest = polytopes[0].vertices().len().min(polytopes[1].vertices().len());
        if fewest < 2 || (is_cuboid(polytopes[0]) && is_cuboid(polytopes[1])) {
            return None;
        }
        let normal = pair.found.depth.normal;
        let [of_a, of_b] = match pair.found.farthest {
            Some([a, b]) => [Some(a), Some(b)],
            None => [None; 2],
        };
        // Both before the first is looked along, which ends by a branch that is not predicted: the other is known by then.
        let to_b = a.pose.rotation().transpose() * normal;
        let to_a = b.pose.rotation().transpose() * -normal;
        let part_a = Part::round(polytopes[0], to_b, of_a);
        let part_b = Part::round(polytopes[1], to_a, of_b);
        let facing = [facing(&part_a, to_b), facing(&part_b, to_a)];
        // The face that is more square to the normal, whose plane is the better known.
        let clips = match facing[0] == facing[1] {
            true => usize::from(order::is_swapped(a, b)),
            false => usize::from(facing[0] < facing[1]),
        };
        Some(Self { pair, polytopes, parts: [part_a, part_b], facing, clips })
    }

    #[inline(always)]
    fn way(&self) -> Way {
        let [a, b] = self.pair.sides;
        let (parts, rotations) =
            ([&self.parts[0], &self.parts[1]], [a.pose.rotation(), b.pose.rotation()]);
        if share_no_corners(self.pair.found.depth.normal, parts, self.polytopes, rotations) {
            return Way::InOnePoint;
        }
        let reach = self.polytopes[0].reach() + self.polytopes[1].reach();
        let most = parts[0].corners().len().max(parts[1].corners().len());
        // False for NaN.
        let is_here = self.facing[self.clips] > 0.0 && reach <= REACH * self.size();
        if is_here && most <= CORNERS { Way::Patch } else { Way::Alone }
    }

    /// How large both shapes are.
    #[inline(always)]
    fn size(&self) -> f64 {
        2.0 * (self.polytopes[0].outer_radius() + self.polytopes[1].outer_radius())
    }

    /// From the one that clips into the other.
    #[inline(always)]
    fn to_other(&self) -> DVec3 {
        let normal = self.pair.found.depth.normal;
        if self.clips == 0 { normal } else { -normal }
    }

    /// Writes them in a lane of a packet.
    #[inline(always)]
    fn pack(&self, lane: usize, packet: &mut Packet) {
        let (clips, clipped) = (self.clips, 1 - self.clips);
        let poses = [self.pair.sides[0].pose, self.pair.sides[1].pose];
        write(&mut packet.normal, lane, self.to_other());
        let apart = poses[clipped].translation() - poses[clips].translation();
        write(&mut packet.apart, lane, apart);
        packet.size[lane] = self.size();
        packet.radius[lane] = self.polytopes[0].swept_radius() + self.polytopes[1].swept_radius();
        for (k, outline) in [(clips, &mut packet.clips), (clipped, &mut packet.clipped)] {
            let part = &self.parts[k];
            let normal = match part {
                Part::Face { normal, .. } => *normal,
                _ => DVec3::ZERO,
            };
            let corners = (part.corners(), self.polytopes[k].vertices());
            outline.write(lane, poses[k].rotation(), normal, corners);
        }
    }

    /// Writes the witnesses of the depth alone.
    #[inline(always)]
    fn write_witnesses(&self, writer: &mut impl PatchWriter) {
        let FoundPair { found, sides, .. } = self.pair;
        let error_bound = bound_of_witnesses(&found.depth, self.size(), *sides);
        let whole = [self.parts[0].name(), self.parts[1].name()];
        writer.write_witnesses(&found.depth, whole, error_bound);
    }

    /// Writes the patch in that lane of a packet of which all is found.
    #[inline(always)]
    fn write(&self, lane: usize, packet: &Packet, writer: &mut impl PatchWriter) {
        let FoundPair { found: FoundDepth { depth, .. }, sides, .. } = self.pair;
        let (size, kept) = (self.size(), &packet.kept);
        // A depth in f32 is off the corners', which are in f64, by up to its bound.
        let short = depth.depth - kept.depths[0][lane];
        let uneven = unevenness(sides.map(|side| side.shape));
        // False for NaN, which numbers near the end of their range make.
        if !(short <= SAME * size + uneven + depth.error_bound) {
            return self.write_witnesses(writer);
        }
        let count = (kept.count[lane] as usize).clamp(1, 4);
        let placed = KeptCorners::of(self, lane, packet);
        let mut shallowest = depth.depth;
        for depths in &kept.depths[..count] {
            shallowest = shallowest.min(depths[lane]);
        }
        let off_surface = self.inside().min((depth.depth - shallowest).max(0.0));
        let error_bound = bound_of(depth, size, *sides) + off_surface + short.abs() + uneven;
        let error_bound = error_bound.min(f64::MAX);
        let deepest = Point { depth: depth.depth, ..placed.point(0) };
        writer.begin(depth.normal, error_bound, deepest);
        for k in 1..count {
            writer.push(placed.point(k));
        }
    }

    /// How far inside a swept surface a point may be that is swept along the normal, metres: see "manifolds" in
    /// docs/numerics/proofs.md.
    #[inline(always)]
    fn inside(&self) -> f64 {
        let [a, b] = self.polytopes;
        if a.swept_radius().max(b.swept_radius()) == 0.0 {
            return 0.0;
        }
        self.leans(0).max(self.leans(1))
    }

    /// The same of one of the two.
    #[inline(never)]
    fn leans(&self, k: usize) -> f64 {
        let polytope = self.polytopes[k];
        let level = match self.parts[k] {
            Part::Edge(ends) => {
                let FoundPair { found, sides, .. } = self.pair;
                let sense = if k == 0 { 1.0 } else { -1.0 };
                let towards = sides[k].pose.rotation().transpose() * (found.depth.normal * sense);
                level_of_edge(polytope, ends, towards)
            }
            _ => self.facing[k],
        };
        polytope.swept_radius() * (1.0 - level).max(0.0)
    }
}

impl Part<'_> {
    /// Its corners, by index: in order round a face.
    fn corners(&self) -> &[u32] {
        match self {
            Part::Vertex(index) => std::slice::from_ref(index),
            Part::Edge(ends) => ends,
            Part::Face { corners, .. } => corners,
        }
    }
}

/// How square to a direction a face is; 0 of what is no face.
#[inline(always)]
fn facing(part: &Part<'_>, towards: DVec3) -> f64 {
    match part {
        Part::Face { normal, .. } => normal.dot(towards).abs(),
        _ => 0.0,
    }
}

/// The corners of a patch that are kept, to be written as points.
struct KeptCorners<'a> {
    packet: &'a Packet,
    lane: usize,
    /// On the surface over the origin of the shape that clips.
    origin: DVec3,
    to_other: DVec3,
    most: f64,
    /// Whether a is the one that clips.
    is_of_a: bool,
    /// What the one that clips shows, and the other: as wholes, and their corners.
    whole: [FeatureCode; 2],
    corners: [&'a [u32]; 2],
}

impl<'a> KeptCorners<'a> {
    #[inline(always)]
    fn of(shown: &'a Shown<'_>, lane: usize, packet: &'a Packet) -> Self {
        let number = shown.clips;
        let (clips, clipped) = (&shown.parts[number], &shown.parts[1 - number]);
        let to_other = shown.to_other();
        let radius = shown.polytopes[number].swept_radius();
        Self {
            packet,
            lane,
            origin: shown.pair.sides[number].pose.translation() + to_other * radius,
            to_other,
            most: shown.pair.found.depth.depth,
            is_of_a: number == 0,
            whole: [clips.name().into(), clipped.name().into()],
            corners: [clips.corners(), clipped.corners()],
        }
    }

    /// One of the four.
    #[inline(always)]
    fn point(&self, k: usize) -> Point {
        let (kept, lane) = (&self.packet.kept, self.lane);
        let [x, y, z] = &kept.offsets[k];
        let depth = kept.depths[k][lane];
        let on_clips = self.origin + DVec3::new(x[lane], y[lane], z[lane]);
        let on_other = on_clips - self.to_other * depth;
        let [of_clips, of_other] = self.features(kept.slots[k][lane] as usize);
        let ([point_a, point_b], features) = match self.is_of_a {
            true => ([on_clips, on_other], [of_clips, of_other]),
            false => ([on_other, on_clips], [of_other, of_clips]),
        };
        Point { point_a, point_b, depth: depth.clamp(0.0, self.most), features }
    }

    /// What a corner belongs to: of the shape that clips, and of the other. Selected, since it cannot be predicted.
    #[inline(always)]
    fn features(&self, slot: usize) -> [FeatureCode; 2] {
        let ([of_clips, of_clipped], [sides, edges]) = (self.whole, self.corners);
        let select = FeatureCode::select;
        let by = self.packet.slots.0[slot % SLOTS].by[self.lane];
        let side = by as usize % CORNERS;
        let of_corner = select(by < SURFACE, FeatureCode::vertex(corner(sides, side)), of_clips);
        let of_clips = select(by < CORNER, from(sides, side), of_corner);
        let number = slot / 2;
        let is_of_clips = number >= self.packet.clipped.most;
        let own = FeatureCode::vertex(corner(edges, number));
        let of_edge = select(by >= VERTEX, own, from(edges, number));
        [of_clips, select(is_of_clips, of_clipped, of_edge)]
    }
}

/// The corner of that number.
#[inline(always)]
fn corner(corners: &[u32], number: usize) -> u32 {
    corners.get(number).copied().unwrap_or(0)
}

/// The edge from there to the next corner.
#[inline(always)]
fn from(corners: &[u32], number: usize) -> FeatureCode {
    let next = if number + 1 < corners.len() { number + 1 } else { 0 };
    FeatureCode::edge(corner(corners, number), corner(corners, next))
}

impl Packet {
    /// Makes place for the next pairs.
    #[inline(always)]
    fn begin(&mut self) {
        (self.clips.most, self.clipped.most) = (0, 0);
    }

    /// Finds the patches of so many pairs; which of them need another way, a bit each.
    #[inline(always)]
    fn search<L: Lanes>(&mut self, l: L, pairs: usize) -> u32 {
        self.clips.fill(pairs);
        self.clipped.fill(pairs);
        self.find(l);
        self.sharp
    }
}

#[cfg(test)]
mod tests;
