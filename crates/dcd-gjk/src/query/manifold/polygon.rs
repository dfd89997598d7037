//! The polygon in which two faces touch, while one of them cuts it: its corners, and what each is a corner of.

use super::Feature;
use super::facing::edge;

/// What the edge of a polygon is a part of; vertices are numbered as their face or box has them.
#[derive(Clone, Copy, Debug)]
pub(super) enum PolygonLine {
    /// The edge of the clipped shape between two of its vertices.
    Clipped(u8, u8),
    /// That of the shape that clips.
    Clips(u8, u8),
    /// Where the depth is 0.
    Surface,
}

/// A corner of the polygon. Small: it is moved by every cut.
#[derive(Clone, Copy, Debug)]
pub(super) struct PolygonCorner {
    /// Of boxes, on the face that clips, along its two sides; of others, in the plane square to the normal.
    pub(super) at: [f64; 2],
    /// How far the clipped shape reaches under the face, along the normal.
    pub(super) depth: f64,
    /// What the edge to the next corner is a part of.
    pub(super) line: PolygonLine,
    /// The edge of the polygon on which it is, and what cuts that edge; the edge itself at a corner of the clipped shape,
    /// where it begins.
    pub(super) origin: [PolygonLine; 2],
}

/// What a corner of that origin belongs to: of the shape that clips, and of the other, of which `whole` is seen.
pub(super) fn features([of_edge, by]: [PolygonLine; 2], whole: [Feature; 2]) -> [Feature; 2] {
    use PolygonLine as Line;
    let [of_clips, of_clipped] = whole;
    let edge = |j: u8, k: u8| edge(j.into(), k.into());
    match (of_edge, by) {
        (_, Line::Clipped(number, _)) => [of_clips, Feature::Vertex(number.into())],
        (Line::Clipped(j, k), Line::Clips(l, m)) => [edge(l, m), edge(j, k)],
        (Line::Clipped(j, k), Line::Surface) => [of_clips, edge(j, k)],
        (Line::Clips(l, m), Line::Clips(n, o)) => {
            let shared = [l, m].into_iter().find(|k| [n, o].contains(k));
            [shared.map_or(edge(n, o), |k| Feature::Vertex(k.into())), of_clipped]
        }
        (Line::Clips(l, m), Line::Surface) | (Line::Surface, Line::Clips(l, m)) => {
            [edge(l, m), of_clipped]
        }
        (Line::Surface, Line::Surface) => whole,
    }
}

/// The corners, in order round it, and memory for as many after the next cut.
#[derive(Debug)]
pub(super) struct Polygon<const MOST: usize> {
    rounds: [[PolygonCorner; MOST]; 2],
    /// Which of the two holds them.
    now: usize,
    count: usize,
}

impl<const MOST: usize> Default for Polygon<MOST> {
    fn default() -> Self {
        let line = PolygonLine::Clipped(0, 0);
        let unused = PolygonCorner { at: [0.0; 2], depth: 0.0, line, origin: [line; 2] };
        Self { rounds: [[unused; MOST]; 2], now: 0, count: 0 }
    }
}

impl<const MOST: usize> Polygon<MOST> {
    pub(super) fn list(&self) -> &[PolygonCorner] {
        &self.rounds[self.now][..self.count]
    }

    pub(super) fn clear(&mut self) {
        self.count = 0;
    }

    /// Of the first ones, for which there is memory.
    pub(super) fn push(&mut self, corner: PolygonCorner) {
        if let Some(slot) = self.rounds[self.now].get_mut(self.count) {
            *slot = corner;
            self.count += 1;
        }
    }

    /// Keeps where a function that is linear over the patch is at least 0 (Sutherland and Hodgman 1974). `None` where
    /// there is no memory left: only what rounding has spoilt has so many corners.
    #[inline(always)]
    pub(super) fn cut(
        &mut self,
        value: impl Fn(&PolygonCorner) -> f64,
        line: PolygonLine,
    ) -> Option<()> {
        let [first, second] = &mut self.rounds;
        let (points, next) = if self.now == 0 { (&*first, second) } else { (&*second, first) };
        let points = &points[..self.count];
        let mut values = [0.0; MOST];
        let mut outside = 0;
        for (to, point) in values.iter_mut().zip(points) {
            *to = value(point);
            outside += usize::from(!(*to >= 0.0));
        }
        if outside == 0 {
            return Some(());
        }
        let mut kept = 0;
        for (k, from) in points.iter().enumerate() {
            let after = if k + 1 < points.len() { k + 1 } else { 0 };
            let (to, here, there) = (&points[after], values[k], values[after]);
            if here >= 0.0 {
                *next.get_mut(kept)? = *from;
                kept += 1;
            }
            if (here >= 0.0) != (there >= 0.0) {
                let share = here / (here - there);
                let between = |x: f64, y: f64| x + (y - x) * share;
                *next.get_mut(kept)? = PolygonCorner {
                    at: [between(from.at[0], to.at[0]), between(from.at[1], to.at[1])],
                    depth: between(from.depth, to.depth),
                    line: if here >= 0.0 { line } else { from.line },
                    origin: [from.line, line],
                };
                kept += 1;
            }
        }
        (self.now, self.count) = (1 - self.now, kept);
        Some(())
    }
}
