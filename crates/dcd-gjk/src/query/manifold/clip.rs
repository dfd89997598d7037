//! What two features have in common, seen along the normal.

use super::Feature;
use super::facing::edge;
use super::feature::{Point, Seen};
use super::reduce::Spot;
use dcd_geom::glam::{DVec2, DVec3};

/// The sine below which two edges are parallel: they then meet along a length, not in a point.
/// Larger: points where parallel edges lean apart. Smaller: one point where a beam lies on another.
const PARALLEL: f64 = 1e-9;

/// How far apart two corners must be, relative to the size, not to be one.
pub(super) const APART: f64 = 1e-9;

/// The sine below which a corner of a face that clips is sharp: where its two sides cut, rounding moves that corner by some
/// 8u of the size over the sine. Larger: more faces that go the general way, which takes such a cut to the corner itself. Smaller:
/// points of a needle beyond its end.
pub(super) const SHARP: f64 = 1e-4;

/// Whether a face has a sharp corner, by its corners as they are seen, in order round it.
#[inline(always)]
pub(super) fn has_sharp_corner(corners: &[(u32, DVec3)]) -> bool {
    let [.., (_, before), (_, last)] = corners else { return false };
    let (mut side, mut from) = ((last - before).truncate(), last);
    corners.len() > 2
        && corners.iter().any(|(_, to)| {
            let next = (to - from).truncate();
            let turn = side.perp_dot(next);
            let squares = side.length_squared() * next.length_squared();
            (side, from) = (next, to);
            // Written so that NaN is sharp.
            !(turn * turn > SHARP * SHARP * squares)
        })
}

/// A corner of what two features have in common.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    /// Where, in the plane.
    pub(super) at: DVec2,
    /// The height of a's feature there, and of b's.
    pub(super) heights: [f64; 2],
    pub(super) features: [Feature; 2],
    /// By how much, seen along the normal, the point of b may be beside that of a: metres.
    pub(super) beside: f64,
    /// How far inside a swept surface a point may be that is swept along the normal: metres.
    inside: f64,
    /// Of which pair of parts it is, by the caller's count.
    pub(super) pair: u32,
    /// What the edge to the next corner is a part of.
    side: Side,
}

/// What an edge of the patch is a part of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    /// An edge of the feature that is clipped, by its vertices.
    Clipped(u32, u32),
    /// An edge of the feature that clips.
    Clips(u32, u32),
    /// Where the depth is 0.
    Surface,
}

impl Corner {
    /// Where nothing is clipped.
    pub(super) fn new(at: DVec2, heights: [f64; 2], features: [Feature; 2]) -> Self {
        Self { at, heights, features, beside: 0.0, inside: 0.0, pair: 0, side: Side::Surface }
    }

    /// With the spheres that are swept round the cores, moved along the normal: from a face or edge that leans, by the
    /// angle of the cosine `level`, that is a little less than to the surface (docs/numerics/proofs.md, "manifolds").
    pub(super) fn swept(self, radii: [f64; 2], level: [f64; 2]) -> Self {
        let [height_a, height_b] = self.heights;
        let heights = [height_a + radii[0], height_b - radii[1]];
        Self { heights, inside: inside_of(radii, level), ..self }
    }

    /// At places that are so far inside a swept surface, metres.
    pub(super) fn inside(self, inside: f64) -> Self {
        Self { inside, ..self }
    }

    /// How far its points may be off the surfaces of parts of that depth.
    pub(super) fn off_surface(&self, depth: f64) -> f64 {
        self.beside + self.inside.min((depth - self.depth()).max(0.0))
    }
}

/// How far inside the swept surfaces of features that lean by angles of those cosines their points may be: metres.
#[inline(always)]
pub(super) fn inside_of(radii: [f64; 2], level: [f64; 2]) -> f64 {
    let inside = |k: usize| radii[k] * (1.0 - level[k]).max(0.0);
    inside(0).max(inside(1))
}

/// What two features have in common, with the memory that clipping takes.
#[derive(Debug, Default)]
pub(super) struct Patch {
    corners: Vec<Corner>,
    next: Vec<Corner>,
}

/// Which of the two is clipped: its number in a pair.
#[derive(Clone, Copy)]
struct Clipping<'a> {
    clipped: &'a Seen<'a>,
    clips: &'a Seen<'a>,
    /// 0 if that is a, 1 if b.
    number: usize,
}

impl Patch {
    pub(super) fn corners(&self) -> &[Corner] {
        &self.corners
    }

    /// Where the cores are at least `least` deep.
    pub(super) fn of(&mut self, a: &Seen<'_>, b: &Seen<'_>, least: f64, size: f64) {
        self.corners.clear();
        // The face that is more square to the normal clips: its plane is the better known.
        let clipping = if a.facing() >= b.facing() {
            Clipping { clipped: b, clips: a, number: 1 }
        } else {
            Clipping { clipped: a, clips: b, number: 0 }
        };
        match (clipping.clips.points().len(), clipping.clipped.points().len()) {
            (3.., 2..) => self.clip(clipping, least),
            (2, 2) => {
                self.parallel_edges(a, b);
                self.cut(|corner| corner.depth() - least, Side::Surface, clipping);
            }
            _ => {}
        }
        self.drop_doubles(size);
    }

    fn clip(&mut self, clipping: Clipping<'_>, least: f64) {
        self.begin(clipping);
        let Clipping { clips, .. } = clipping;
        let mut last = clips.points().last();
        for to in clips.points() {
            let Some(from) = last.replace(to) else { return };
            let along = to.at - from.at;
            let inside = |corner: &Corner| along.perp_dot(corner.at - from.at);
            self.cut(inside, Side::Clips(from.index, to.index), clipping);
        }
        self.cut(|corner| corner.depth() - least, Side::Surface, clipping);
    }

    /// The clipped feature as it is.
    fn begin(&mut self, Clipping { clipped, clips, number }: Clipping<'_>) {
        let points = clipped.points();
        for (k, &Point { index, at, height }) in points.iter().enumerate() {
            let next = points[if k + 1 < points.len() { k + 1 } else { 0 }].index;
            let mut heights = [clips.height(at); 2];
            heights[number] = height;
            let mut features = [clips.whole(); 2];
            features[number] = Feature::Vertex(index);
            let side = Side::Clipped(index, next);
            self.corners.push(Corner { side, ..Corner::new(at, heights, features) });
        }
    }

    /// Keeps where a function that is linear over the patch is at least 0 (Sutherland and Hodgman
    /// 1974).
    fn cut(&mut self, value: impl Fn(&Corner) -> f64, side: Side, clipping: Clipping<'_>) {
        self.next.clear();
        let Some(first) = self.corners.first() else { return };
        let first = (first, value(first));
        let mut of_corner = first.1;
        for (k, corner) in self.corners.iter().enumerate() {
            let next = self.corners.get(k + 1);
            let (after, there) = next.map_or(first, |next| (next, value(next)));
            let here = std::mem::replace(&mut of_corner, there);
            if here >= 0.0 {
                self.next.push(*corner);
            }
            if (here >= 0.0) != (there >= 0.0) {
                let mut between = corner.towards(after, here / (here - there));
                between.features = clipping.features(corner.side, side);
                clipping.take_to_vertex(&mut between, corner.side, side);
                between.side = if here >= 0.0 { side } else { corner.side };
                self.next.push(between);
            }
        }
        std::mem::swap(&mut self.corners, &mut self.next);
    }

    /// The ends of what two edges share, if they are parallel; nothing if they cross.
    fn parallel_edges(&mut self, a: &Seen<'_>, b: &Seen<'_>) {
        let ([p, q], [r, s]) = (a.points(), b.points()) else { return };
        let (e, f) = (q.at - p.at, s.at - r.at);
        if e.perp_dot(f).abs() > PARALLEL * e.length() * f.length() || e == DVec2::ZERO {
            return;
        }
        let along = |point: &Point| (point.at - p.at).dot(e) / e.length_squared();
        // Points are on a's edge, and beside b's by what the normal is off.
        let beside =
            (r.at - p.at).perp_dot(e).abs().max((s.at - p.at).perp_dot(e).abs()) / e.length();
        let mut others = [*r, *s];
        others.sort_by(|v, w| along(v).total_cmp(&along(w)));
        let [low, high] = others.map(|point| along(&point));
        let (from, to) = (low.max(0.0), high.min(1.0));
        if !(from <= to) {
            return;
        }
        for (t, own, other) in
            [(from, (low <= 0.0, p.index), others[0]), (to, (high >= 1.0, q.index), others[1])]
        {
            let share = if high > low { (t - low) / (high - low) } else { 0.0 };
            let height_b = others[0].height + (others[1].height - others[0].height) * share;
            let (is_own, index) = own;
            let features = if is_own {
                [Feature::Vertex(index), b.whole()]
            } else {
                [a.whole(), Feature::Vertex(other.index)]
            };
            let heights = [p.height + (q.height - p.height) * t, height_b];
            self.corners.push(Corner { beside, ..Corner::new(p.at + e * t, heights, features) });
        }
    }

    fn drop_doubles(&mut self, size: f64) {
        drop_doubles(&mut self.corners, size);
    }
}

/// Keeps one corner of those at one place, the first, unless a later one is deeper: of layers that lie on each other.
pub(super) fn drop_doubles(corners: &mut Vec<Corner>, size: f64) {
    let kept = different(corners, size);
    corners.truncate(kept);
}

/// The same of a list, whose first entries are then those that are kept: how many.
pub(super) fn different<S: Spot + Copy>(corners: &mut [S], size: f64) -> usize {
    let near = APART * size;
    // Most are apart along one axis: a root saved.
    let are_apart = |offset: DVec2| offset.abs().max_element() > near || offset.length() > near;
    let mut kept = 0;
    for k in 0..corners.len() {
        let (at, depth) = (corners[k].at(), corners[k].depth());
        match corners[..kept].iter().position(|other| !are_apart(other.at() - at)) {
            None => {
                // Mostly none has been left out before.
                if kept < k {
                    corners[kept] = corners[k];
                }
                kept += 1;
            }
            // More than rounding, or which one is kept would change from frame to frame.
            Some(same) if depth > corners[same].depth() + near => corners[same] = corners[k],
            Some(_) => {}
        }
    }
    kept
}

impl Spot for Corner {
    fn at(&self) -> DVec2 {
        self.at
    }

    fn depth(&self) -> f64 {
        self.heights[0] - self.heights[1]
    }
}

impl Clipping<'_> {
    /// Where two sides of the face that clips cut, its vertex: of a needle, whose sides are nearly parallel, the cut is off it
    /// by what rounding makes of their angle.
    fn take_to_vertex(&self, corner: &mut Corner, of_edge: Side, by: Side) {
        let Some(vertex) = shared_vertex(of_edge, by) else { return };
        let Some(point) = self.clips.points().iter().find(|point| point.index == vertex) else {
            return;
        };
        corner.at = point.at;
        corner.heights[1 - self.number] = point.height;
        if self.clipped.facing() > 0.0 {
            corner.heights[self.number] = self.clipped.height(point.at);
        }
    }

    /// What a corner belongs to where an edge of the patch is cut by a side.
    fn features(&self, of_edge: Side, by: Side) -> [Feature; 2] {
        let (clipped, clips) = match (of_edge, by) {
            (Side::Clipped(j, k), Side::Clips(l, m)) => (edge(j, k), edge(l, m)),
            (Side::Clipped(j, k), _) => (edge(j, k), self.clips.whole()),
            (Side::Clips(..), Side::Clips(n, o)) => {
                let shared = shared_vertex(of_edge, by);
                (self.clipped.whole(), shared.map_or(edge(n, o), Feature::Vertex))
            }
            (Side::Clips(l, m), _) => (self.clipped.whole(), edge(l, m)),
            (Side::Surface, Side::Clips(l, m)) => (self.clipped.whole(), edge(l, m)),
            (Side::Surface, _) => (self.clipped.whole(), self.clips.whole()),
        };
        if self.number == 0 { [clipped, clips] } else { [clips, clipped] }
    }
}

/// The vertex that two sides of what clips have in common.
fn shared_vertex(one: Side, other: Side) -> Option<u32> {
    let (Side::Clips(l, m), Side::Clips(n, o)) = (one, other) else { return None };
    [l, m].into_iter().find(|k| [n, o].contains(k))
}

impl Corner {
    /// A part of the way to another.
    fn towards(&self, other: &Self, share: f64) -> Self {
        let height = |k: usize| self.heights[k] + (other.heights[k] - self.heights[k]) * share;
        Self {
            at: self.at + (other.at - self.at) * share,
            heights: [height(0), height(1)],
            ..*self
        }
    }
}
