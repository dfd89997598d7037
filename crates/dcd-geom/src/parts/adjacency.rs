//! Which triangles of a mesh share edges and vertices.

use super::Mesh;
use glam::DVec3;

/// What lies round the edges and vertices of a mesh. Vertices at one place are one, whatever their indices.
#[derive(Clone, Debug)]
pub struct Adjacency {
    /// The corners of each triangle, by index into [`Mesh::points`].
    corners: Vec<[u32; 3]>,
    /// Two points that an edge joins, the smaller index first, and the opposite corner of a triangle with that edge;
    /// sorted.
    edges: Vec<[u32; 3]>,
    /// A point, and one that an edge joins with it; sorted, each once.
    rings: Vec<[u32; 2]>,
}

impl Adjacency {
    /// Costs a search for each corner and two sorts.
    pub(super) fn of(mesh: &Mesh) -> Self {
        let key = |p: &DVec3| p.to_array().map(f64::to_bits);
        let points = mesh.points();
        let index = |corner: u32| {
            let place = mesh.vertices()[corner as usize] + DVec3::ZERO;
            let found = points.binary_search_by_key(&key(&place), key);
            // Every corner is among the points.
            found.unwrap_or_else(|next| next) as u32
        };
        let corners: Vec<[u32; 3]> =
            mesh.triangles().iter().map(|triangle| triangle.map(index)).collect();
        let (mut edges, mut rings) = (Vec::new(), Vec::new());
        for &[p, q, r] in &corners {
            for [from, to, opposite] in [[p, q, r], [q, r, p], [r, p, q]] {
                edges.push([from.min(to), from.max(to), opposite]);
                rings.extend([[from, to], [to, from]]);
            }
        }
        edges.sort_unstable();
        rings.sort_unstable();
        rings.dedup();
        Self { corners, edges, rings }
    }

    /// The corners of triangle k, by index into [`Mesh::points`]; `None` for no triangle of the mesh.
    pub fn corners(&self, k: usize) -> Option<[u32; 3]> {
        self.corners.get(k).copied()
    }

    /// The corners that lie opposite an edge, one for each triangle that has it: by index into [`Mesh::points`], as the
    /// two ends are.
    pub fn opposite(&self, [from, to]: [u32; 2]) -> impl Iterator<Item = u32> + Clone {
        let edge = [from.min(to), from.max(to)];
        let first = self.edges.partition_point(|&[p, q, _]| [p, q] < edge);
        let of_edge = self.edges[first..].iter().take_while(move |&&[p, q, _]| [p, q] == edge);
        of_edge.map(|&[_, _, opposite]| opposite)
    }

    /// The points that edges join with one: by index into [`Mesh::points`], as that is, ascending.
    pub fn ring(&self, point: u32) -> impl Iterator<Item = u32> + Clone {
        let first = self.rings.partition_point(|&[p, _]| p < point);
        self.rings[first..].iter().take_while(move |&&[p, _]| p == point).map(|&[_, other]| other)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_and_rings_are_those_of_a_search_through_all_triangles() {
        // A strip whose second triangle has vertices of its own, a third on the same edge, and one by itself.
        let place =
            [[0, 0], [1, 0], [0, 1], [1, 0], [0, 1], [1, 1], [-1, 2], [5, 5], [6, 5], [5, 6]];
        let vertices = place.map(|[x, y]| DVec3::new(f64::from(x), f64::from(y), -0.0)).to_vec();
        let mesh = Mesh::new(vertices, vec![[0, 1, 2], [3, 5, 4], [2, 1, 6], [7, 8, 9], [7, 7, 8]])
            .unwrap();
        let adjacency = mesh.adjacency();
        let points = mesh.points();
        let of = |k: usize| mesh.corners(k).unwrap();
        for k in 0..5 {
            let corners = adjacency.corners(k).unwrap();
            assert_eq!(corners.map(|corner| points[corner as usize]), of(k));
        }
        assert_eq!(adjacency.corners(5), None);
        for p in 0..points.len() as u32 {
            let at = |k: u32| points[k as usize];
            let joined = |q: u32| {
                (0..5).any(|k| {
                    let [a, b, c] = of(k);
                    [[a, b], [b, c], [c, a], [b, a], [c, b], [a, c]].contains(&[at(p), at(q)])
                })
            };
            let ring: Vec<u32> = (0..points.len() as u32).filter(|&q| joined(q)).collect();
            assert_eq!(adjacency.ring(p).collect::<Vec<_>>(), ring, "{p}");
            for q in p + 1..points.len() as u32 {
                let opposite = (0..5).filter_map(|k| {
                    let corners = of(k);
                    let has = |v: DVec3| corners.contains(&v);
                    (has(at(p)) && has(at(q)))
                        .then(|| corners.into_iter().find(|&v| v != at(p) && v != at(q)))
                        .flatten()
                });
                let mut opposite: Vec<_> =
                    opposite.map(|v| v.to_array().map(f64::to_bits)).collect();
                let found = adjacency.opposite([q, p]).filter(|&k| k != p && k != q);
                let mut found: Vec<_> = found.map(|k| at(k).to_array().map(f64::to_bits)).collect();
                opposite.sort_unstable();
                found.sort_unstable();
                assert_eq!(found, opposite, "{p}, {q}");
            }
        }
    }
}
