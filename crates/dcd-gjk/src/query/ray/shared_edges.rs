//! Triangles that a ray meets at their edges: of one alone it is not known, of those that hang together there it may be
//! (docs/numerics/queries.md, "Through an edge").

use super::RayHit;
use dcd_geom::glam::DVec3;

/// How many triangles are held. Larger: time, by its square, for rays along the ridge of a mesh. Smaller: hits through a corner of
/// many triangles that stay uncertain.
const MOST: usize = 64;

/// On which side of an edge, from its first end to its second, the ray goes by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RaySide {
    Left,
    Right,
    Unknown,
}

/// A triangle that the ray is not proved to miss, and what it is proved to be beside.
#[derive(Clone, Copy, Debug)]
pub(super) struct DoubtfulHit {
    pub(super) corners: [DVec3; 3],
    /// Of the edges from corner 1 to 2, from 2 to 0 and from 0 to 1.
    pub(super) sides: [RaySide; 3],
    /// Whether all of its times are within the ray's own.
    pub(super) is_within: bool,
    pub(super) hit: RayHit,
}

/// The directed edges of a triangle that turns left round the ray, as far as that is known.
type Edges = [([DVec3; 2], RaySide); 3];

impl DoubtfulHit {
    /// `None` where no edge is known.
    fn edges(&self) -> Option<Edges> {
        let [a, b, c] = self.corners;
        let [u, v, w] = self.sides;
        if self.sides.contains(&RaySide::Left) {
            return Some([([b, c], u), ([c, a], v), ([a, b], w)]);
        }
        let is_known = self.sides.contains(&RaySide::Right);
        is_known.then_some([([c, b], u), ([a, c], v), ([b, a], w)])
    }

    /// Whether both have an edge of which neither knows its side.
    fn hangs_together(&self, other: &Self) -> bool {
        self.unknown_edges().any(|[from, to]| {
            other.unknown_edges().any(|edge| edge == [to, from] || edge == [from, to])
        })
    }

    fn unknown_edges(&self) -> impl Iterator<Item = [DVec3; 2]> {
        let [a, b, c] = self.corners;
        let edges = [[b, c], [c, a], [a, b]].into_iter().zip(self.sides);
        edges.filter(|(_, side)| *side == RaySide::Unknown).map(|(edge, _)| edge)
    }
}

/// The triangles of a mesh that a ray may meet at their edges.
#[derive(Debug, Default)]
pub(super) struct DoubtfulHits(Vec<DoubtfulHit>);

impl DoubtfulHits {
    /// Holds one until all are known; gives it back where there are too many.
    pub(super) fn hold(&mut self, hit: DoubtfulHit) -> Option<RayHit> {
        if self.0.len() >= MOST {
            return Some(hit.hit);
        }
        self.0.push(hit);
        None
    }

    /// Calls `visit` for the hits that are held, in their order, as [`super::for_each_hit`] does: those of which the ray is proved to
    /// meet one have the times of all of these.
    pub(super) fn settle(mut self, mut limit: f64, visit: &mut dyn FnMut(RayHit) -> f64) {
        let mut settled = 0;
        while settled < self.0.len() {
            let end = self.gather(settled);
            let group = &self.0[settled..end];
            let is_met = group.iter().all(|hit| hit.is_within) && winds_round_the_ray(group);
            let lower = group.iter().fold(f64::INFINITY, |t, hit| t.min(hit.hit.t_lower));
            let upper = group.iter().fold(0.0f64, |t, hit| t.max(hit.hit.t_upper));
            for DoubtfulHit { hit, .. } in group {
                if lower > limit {
                    break;
                }
                let t = 0.5 * (hit.t_lower + hit.t_upper);
                limit = visit(match is_met {
                    true => RayHit { t, t_lower: lower, t_upper: upper, is_certain: true, ..*hit },
                    false => *hit,
                });
            }
            settled = end;
        }
    }

    /// Moves what hangs together with a triangle behind it. Returns where that ends.
    fn gather(&mut self, first: usize) -> usize {
        let (mut end, mut looked_at) = (first + 1, first);
        while looked_at < end {
            let mut other = end;
            while other < self.0.len() {
                if self.0[looked_at].hangs_together(&self.0[other]) {
                    self.0.swap(end, other);
                    end += 1;
                }
                other += 1;
            }
            looked_at += 1;
        }
        end
    }
}

/// Whether the ray is proved to meet one of some triangles: the edges that are left over when they are put together all turn left
/// round it.
fn winds_round_the_ray(group: &[DoubtfulHit]) -> bool {
    let mut open: Vec<[DVec3; 2]> = Vec::new();
    for hit in group {
        let Some(edges) = hit.edges() else { return false };
        for (edge, side) in edges {
            if side != RaySide::Unknown {
                continue;
            }
            let [from, to] = edge;
            match open.iter().position(|&other| other == [to, from]) {
                Some(place) => drop(open.swap_remove(place)),
                None => open.push(edge),
            }
        }
    }
    open.is_empty()
}

#[cfg(test)]
mod tests;
