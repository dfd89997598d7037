//! How the corner of another shape that is lowest goes round one of its faces on the way round each vertex of a hull.

use dcd_geom::FeatureRows;

/// The vertices at which the way takes one edge of the other shape.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Round {
    /// The vertices at which it goes forth along the edge, and back.
    forth: u64,
    back: u64,
    /// How often it does.
    count: u32,
}

impl Round {
    /// Takes in a row of the hull's edges, by the lanes in which the way across them goes forth, and back. Round an edge's
    /// other end it goes the other way.
    #[inline(always)]
    pub(super) fn add(&mut self, rows: &FeatureRows, row: usize, [forth, back]: [u32; 2]) {
        self.count += forth.count_ones() + back.count_ones();
        for (mut set, is_forth) in [(forth, true), (back, false)] {
            while set != 0 {
                let edge = row * 16 + set.trailing_zeros() as usize;
                set &= set - 1;
                let Some([from, to]) = rows.edge_vertices(edge) else { continue };
                let (first, second) = if is_forth { (from, to) } else { (to, from) };
                self.forth |= 1 << first;
                self.back |= 1 << second;
            }
        }
    }

    /// The vertices at which it goes forth once more than back, and back once more than forth; `None` where it may do either
    /// more than once.
    #[inline(always)]
    pub(super) fn vertices(&self) -> Option<[u64; 2]> {
        let is_once = |set: u64| set.count_ones() == self.count;
        (is_once(self.forth) && is_once(self.back))
            .then_some([self.forth & !self.back, self.back & !self.forth])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dcd_geom::Polytope;
    use dcd_geom::glam::DVec3;

    #[test]
    fn the_way_round_a_vertex_goes_once_round_or_nothing_is_claimed() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let tetrahedron = Polytope::hull(corners.to_vec()).unwrap();
        let rows = tetrahedron.feature_rows().unwrap();
        let edge = |ends: [u32; 2]| (0..6).find(|&k| rows.edge_vertices(k) == Some(ends)).unwrap();
        let of = |forth: &[[u32; 2]]| {
            let mut round = Round::default();
            round.add(rows, 0, [forth.iter().fold(0, |set, &ends| set | 1 << edge(ends)), 0]);
            round.vertices()
        };
        // Forth across each: once round at both ends of a path.
        assert_eq!(of(&[[0, 1], [1, 2]]), Some([1, 4]));
        assert_eq!(of(&[]), Some([0, 0]));
        // Twice round vertex 0, and twice round vertex 3.
        assert_eq!(of(&[[0, 1], [0, 2]]), None);
        assert_eq!(of(&[[0, 3], [1, 3]]), None);
    }
}
