//! GJK: whether the Minkowski difference of two shapes holds the origin.

use crate::certificate::{Bounds, combined_length};
use crate::portal;
use crate::simplex::{Nearest, Triple, nearest, norm1};
use crate::{Difference, Reason, Verdict, Vertex};
use dcd_geom::{Real, Support, SupportMap, Vector};

/// How many supports a search takes at most. No unit. Hulls need 3 to 6, slivers some 20, smooth
/// shapes one for each digit or so. Smaller: undecided pairs. Larger: a foreign map that does not
/// converge costs more.
pub(crate) const MAX_SUPPORTS: usize = 96;

/// The direction where the two centres coincide: none of the directions that shapes like, so that
/// no face of a box is met head on. World axes, no unit, largest component in [½, 1].
const SKEW: [f64; 3] = [0.5625, 0.84375, -0.71875];

/// Whether two shapes touch.
///
/// Apart only where a separating axis exceeds its rounding bound, touching only where a simplex
/// (or a point within the swept radii) surely does; else undecided. Stops at the first proof.
/// Takes at most 96 supports for GJK and 4 × 84 where the origin is on a face, an edge or a corner
/// of GJK's simplex; allocates nothing.
///
/// Source: Gilbert, Johnson, Keerthi 1988; the nearest point after Montanari, Petrinic, Barbieri
/// 2017 in that it is taken from signed volumes.
pub fn overlap<R, A, B>(difference: &Difference<'_, R, A, B>) -> Verdict<()>
where
    R: Real,
    A: SupportMap<R> + ?Sized,
    B: SupportMap<R> + ?Sized,
{
    overlap_with_simplex(difference).0
}

/// The verdict, and the simplex where the search ended: the nearest one found.
pub(crate) fn overlap_with_simplex<R, A, B>(
    difference: &Difference<'_, R, A, B>,
) -> (Verdict<()>, Simplex<R>)
where
    R: Real,
    A: SupportMap<R> + ?Sized,
    B: SupportMap<R> + ?Sized,
{
    let bounds = Bounds::of(difference);
    let mut simplex = Simplex::default();
    let verdict = match search(difference, &bounds, &mut simplex) {
        End::Known(verdict) => verdict,
        End::Open => portal::overlap(difference, &bounds),
    };
    (verdict, simplex)
}

/// How GJK ended.
enum End {
    /// Proved by this arithmetic.
    Known(Verdict<()>),
    /// Near a lower face of its simplex, where its directions are rounding.
    Open,
}

fn search<R, A, B>(
    difference: &Difference<'_, R, A, B>,
    bounds: &Bounds<R>,
    simplex: &mut Simplex<R>,
) -> End
where
    R: Real,
    A: SupportMap<R> + ?Sized,
    B: SupportMap<R> + ?Sized,
{
    let mut direction = start::<R>(difference.middle());
    let mut nearest_so_far = R::MAX;
    let mut shallow = false;
    for _ in 0..MAX_SUPPORTS {
        let (vertex, separation) = difference.lowest(direction);
        if bounds.proves_apart(direction, separation) {
            return End::Known(Verdict::Apart);
        }
        shallow |= bounds.is_shallow(direction, separation);
        if simplex.holds(&vertex) {
            return End::Open;
        }
        simplex.push(vertex);
        let Some(near) = simplex.nearest() else { break };
        let squared = near.square[0] / near.square[1];
        // Strictly nearer, or rounding is all that moves it. False for NaN.
        if !(squared < nearest_so_far) {
            simplex.pop();
            return End::Open;
        }
        nearest_so_far = squared;
        simplex.keep(&near);
        if bounds.simplex_touches(simplex) {
            return End::Known(Verdict::Touching(()));
        }
        if bounds.radius() > R::ZERO {
            let distance = combined_length(simplex.vertices(), near.weights());
            if bounds.proves_swept_touching(distance) {
                return End::Known(Verdict::Touching(()));
            }
        }
        let through = bounds.passes_through(squared);
        if through && shallow {
            // The surface and a point inside are both within rounding of the origin.
            return End::Known(Verdict::Undecided(Reason::WithinRounding));
        }
        match unit(near.direction) {
            Some(next) if !through => direction = next,
            _ => return End::Open,
        }
    }
    End::Known(Verdict::Undecided(Reason::Iterations))
}

/// The first direction: from the origin to the difference's middle.
pub(crate) fn start<R: Real>(middle: R::Vec3) -> R::Vec3 {
    let skew = SKEW.map(R::from_f64);
    unit(middle.components()).unwrap_or(R::Vec3::new(skew[0], skew[1], skew[2]))
}

/// The same direction with a largest component of 1. `None` where it has none to rounding's
/// knowledge: zero, denormal, infinite, NaN.
#[inline]
pub(crate) fn unit<R: Real>(direction: Triple<R>) -> Option<R::Vec3> {
    let [x, y, z] = direction;
    let largest = x.abs().max(y.abs()).max(z.abs());
    // |·|₁ keeps a NaN beside larger numbers.
    if !(largest >= R::MIN_POSITIVE && norm1(&direction) <= R::MAX) {
        return None;
    }
    Some(R::Vec3::new(x / largest, y / largest, z / largest))
}

/// Up to four vertices of a difference.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Simplex<R: Real> {
    vertices: [Vertex<R>; 4],
    count: usize,
}

impl<R: Real> Default for Simplex<R> {
    fn default() -> Self {
        let none = Support { point: R::Vec3::ZERO, feature: 0 };
        Self { vertices: [Vertex { w: R::Vec3::ZERO, a: none, b: none }; 4], count: 0 }
    }
}

impl<R: Real> Simplex<R> {
    pub(crate) fn vertices(&self) -> &[Vertex<R>] {
        &self.vertices[..self.count]
    }

    pub(crate) fn points(&self) -> [Triple<R>; 4] {
        self.vertices.map(|vertex| vertex.w.components())
    }

    pub(crate) fn holds(&self, vertex: &Vertex<R>) -> bool {
        self.vertices().iter().any(|known| known.is_same(vertex))
    }

    /// Adds a vertex; a fifth is left out.
    pub(crate) fn push(&mut self, vertex: Vertex<R>) {
        if let Some(slot) = self.vertices.get_mut(self.count) {
            *slot = vertex;
            self.count += 1;
        }
    }

    /// Takes the last one away.
    pub(crate) fn pop(&mut self) {
        self.count = self.count.saturating_sub(1);
    }

    pub(crate) fn nearest(&self) -> Option<Nearest<R>> {
        nearest(&self.points()[..self.count])
    }

    /// Takes away all but the first ones.
    pub(crate) fn truncate(&mut self, count: usize) {
        self.count = self.count.min(count);
    }

    /// Keeps the vertices that span the nearest point, in the order of its weights.
    pub(crate) fn keep(&mut self, near: &Nearest<R>) {
        self.count = near.count;
        let mut kept = near.kept;
        for slot in 0..near.count {
            let k = kept[slot];
            if k == slot {
                continue;
            }
            self.vertices.swap(slot, k);
            // What stood here is now there.
            for later in &mut kept[slot + 1..] {
                if *later == slot {
                    *later = k;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
