//! Triangles over shared vertices.

use super::adjacency::Adjacency;
use super::tree::PartTree;
use crate::error::check_length;
use crate::sphere::reach;
use crate::{Aabb, ObbBounds, ShapeError};
use dcd_simd::{Block, WIDTH};
use glam::DVec3;
use std::sync::OnceLock;

/// The triangles of one leaf as the lanes want them: relative to a point of their own, in f32.
#[derive(Clone, Debug)]
pub struct Triangles {
    /// The origin of the corners, in the mesh's frame, metres.
    pub centre: DVec3,
    /// The largest distance of a corner from the centre, rounded up.
    pub radius: f64,
    /// The first, second and third corners less the centre, rounded to f32. Lanes past the last
    /// triangle hold the first one.
    pub corners: [Block; 3],
}

/// All corners of a mesh as the lanes want them: relative to the middle of their AABB, in f32.
#[derive(Clone, Debug)]
pub struct Corners {
    /// The origin of these corners, in the mesh's frame, metres.
    pub centre: DVec3,
    /// The largest distance of a corner from the centre, rounded up.
    pub radius: f64,
    /// Each less the centre, rounded to f32, sixteen a block; the last block is filled up with the
    /// last one.
    pub blocks: Vec<Block>,
}

/// A surface of triangles: not what it encloses, if it encloses anything.
///
/// Each triangle is the hull of its three corners. It may be degenerate: a segment, or a point.
/// The mesh touches what one of its triangles touches.
///
/// ```
/// use dcd_geom::glam::DVec3;
/// use dcd_geom::{Mesh, Shape};
/// let square = vec![DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
/// let mesh = Mesh::new(square.clone(), vec![[0, 1, 2], [0, 2, 3]])?;
/// assert_eq!(mesh.corners(1), Some([DVec3::ZERO, DVec3::X + DVec3::Y, DVec3::Y]));
/// let ground = Shape::from(mesh);
/// assert!(Mesh::new(square, vec![[0, 1, 7]]).is_err());
/// # assert!(ground.is_bounded());
/// # Ok::<(), dcd_geom::ShapeError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Mesh {
    vertices: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    /// The vertices that triangles use, each once: the mesh's extent is theirs.
    points: Vec<DVec3>,
    /// These points as the lanes read them.
    all_corners: Corners,
    tree: PartTree,
    leaves: Vec<Triangles>,
    reach: f64,
    radius: f64,
    adjacency: OnceLock<Adjacency>,
}

impl Mesh {
    /// A mesh of vertices in its own frame, metres, and three of their indices a triangle. A
    /// vertex that no triangle names is allowed and no part of the mesh.
    ///
    /// # Errors
    /// No triangle at all, more than a u32 counts, a vertex that is not finite, an index that names
    /// no vertex.
    pub fn new(vertices: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Result<Self, ShapeError> {
        check(&vertices, &triangles)?;
        let corners = |triangle: &[u32; 3]| triangle.map(|corner: u32| vertices[corner as usize]);
        let boxes: Vec<Aabb> = triangles
            .iter()
            .map(|triangle| {
                let [a, b, c] = corners(triangle);
                Aabb::outward(a.min(b).min(c), a.max(b).max(c))
            })
            .collect();
        let tree = PartTree::over(&boxes);
        let leaves = (0..tree.leaf_count())
            .map(|leaf| {
                // A lane without a triangle holds the empty AABB and the index 0.
                let lanes = tree.below()[leaf].0;
                let filled = |lane: usize| tree.blocks()[leaf].get(lane) != Aabb::EMPTY;
                let count = (0..WIDTH).take_while(|&lane| filled(lane)).count();
                Triangles::of(lanes[..count].iter().map(|&k| corners(&triangles[k as usize])))
            })
            .collect();
        let points = distinct(triangles.iter().flat_map(corners).collect());
        let (all_corners, reach) = (Corners::of(&points), reach(points.iter().copied()));
        let (radius, adjacency) = (0.0, OnceLock::new());
        Ok(Self {
            vertices,
            triangles,
            points,
            all_corners,
            tree,
            leaves,
            reach,
            radius,
            adjacency,
        })
    }

    /// The same triangles with a sphere of this radius swept round each, metres; replaces any other
    /// radius.
    ///
    /// # Errors
    /// A radius that is negative or not finite.
    pub fn rounded(mut self, radius: f64) -> Result<Self, ShapeError> {
        check_length("radius", radius)?;
        self.radius = radius;
        Ok(self)
    }

    /// The radius swept round each triangle, metres.
    pub fn swept_radius(&self) -> f64 {
        self.radius
    }

    /// The vertices as given.
    pub fn vertices(&self) -> &[DVec3] {
        &self.vertices
    }

    /// The triangles as given, each the indices of its corners.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The corners of triangle k, if there is one.
    #[inline]
    pub fn corners(&self, k: usize) -> Option<[DVec3; 3]> {
        // Every index was checked when the mesh was made.
        self.triangles.get(k).map(|triangle| triangle.map(|corner| self.vertices[corner as usize]))
    }

    /// Every point that is a corner, once, in a fixed order: their hull is the mesh's.
    pub fn points(&self) -> &[DVec3] {
        &self.points
    }

    /// The points as the lanes read them, for the mesh's AABB.
    pub fn all_corners(&self) -> &Corners {
        &self.all_corners
    }

    /// An OBB round all corners, in the mesh's frame, and where its middle is; `None` where lengths overflow. Nothing is inside the
    /// mesh. Computed at every call.
    pub fn obb(&self) -> Option<(DVec3, ObbBounds)> {
        let Corners { centre, radius, .. } = self.all_corners;
        ObbBounds::round(&self.points, centre, radius)
    }

    /// The tree over the triangles, the swept radius not counted.
    pub fn tree(&self) -> &PartTree {
        &self.tree
    }

    /// The triangles of each leaf of the tree, lane by lane.
    pub fn leaves(&self) -> &[Triangles] {
        &self.leaves
    }

    /// Which triangles share edges and vertices: found at the first call, for all threads.
    pub fn adjacency(&self) -> &Adjacency {
        self.adjacency.get_or_init(|| Adjacency::of(self))
    }

    /// The largest distance of a corner from the origin of the mesh's frame, rounded up; the swept
    /// radius is not counted.
    pub fn reach(&self) -> f64 {
        self.reach
    }
}

/// The middle of the AABB round points.
fn middle(points: impl Iterator<Item = DVec3> + Clone) -> DVec3 {
    let low = points.clone().fold(DVec3::INFINITY, DVec3::min);
    low * 0.5 + points.fold(DVec3::NEG_INFINITY, DVec3::max) * 0.5
}

impl Corners {
    fn of(points: &[DVec3]) -> Self {
        let centre = middle(points.iter().copied());
        let radius = reach(points.iter().map(|&point| point - centre));
        Self { centre, radius, blocks: Block::relative(points, centre).collect() }
    }
}

impl Triangles {
    fn of(triangles: impl Iterator<Item = [DVec3; 3]> + Clone) -> Self {
        let points = triangles.clone().flatten();
        let centre = middle(points.clone());
        let mut corners = [Block::default(); 3];
        let first = triangles.clone().next().unwrap_or_default();
        let lanes = triangles.chain(std::iter::repeat(first));
        for (lane, triangle) in lanes.take(WIDTH).enumerate() {
            for (block, corner) in corners.iter_mut().zip(triangle) {
                let local = (corner - centre).as_vec3().to_array();
                for (row, x) in block.0.iter_mut().zip(local) {
                    row.0[lane] = x;
                }
            }
        }
        let relative = points.map(|point| point - centre);
        Self { centre, radius: reach(relative), corners }
    }
}

fn check(vertices: &[DVec3], triangles: &[[u32; 3]]) -> Result<(), ShapeError> {
    let count = vertices.len();
    if triangles.is_empty() {
        return Err(ShapeError::Empty);
    }
    if u32::try_from(count).is_err() {
        return Err(ShapeError::TooManyVertices { count });
    }
    if u32::try_from(triangles.len()).is_err() {
        return Err(ShapeError::TooManyParts { count: triangles.len() });
    }
    for (vertex, v) in vertices.iter().enumerate() {
        if let Some(&value) = v.to_array().iter().find(|x| !x.is_finite()) {
            return Err(ShapeError::NotFinite { vertex, value });
        }
    }
    for (triangle, corners) in triangles.iter().enumerate() {
        if let Some(&vertex) = corners.iter().find(|&&corner| corner as usize >= count) {
            return Err(ShapeError::NoSuchVertex { triangle, vertex, vertices: count });
        }
    }
    Ok(())
}

/// Each point once, −0 and 0 being one.
fn distinct(mut points: Vec<DVec3>) -> Vec<DVec3> {
    points.iter_mut().for_each(|point| *point += DVec3::ZERO);
    let key = |p: &DVec3| p.to_array().map(f64::to_bits);
    points.sort_unstable_by_key(key);
    points.dedup();
    points
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Pose, Shape};

    fn square() -> Vec<DVec3> {
        [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| DVec3::new(x, y, 2.0)).into()
    }

    #[test]
    fn a_mesh_without_triangles_is_refused() {
        assert_eq!(Mesh::new(square(), vec![]).unwrap_err(), ShapeError::Empty);
    }

    #[test]
    fn an_index_past_the_vertices_is_named() {
        let refused = Mesh::new(square(), vec![[0, 1, 2], [0, 4, 1]]).unwrap_err();
        assert_eq!(refused, ShapeError::NoSuchVertex { triangle: 1, vertex: 4, vertices: 4 });
        let refused = Mesh::new(vec![], vec![[0; 3]]).unwrap_err();
        assert_eq!(refused, ShapeError::NoSuchVertex { triangle: 0, vertex: 0, vertices: 0 });
    }

    #[test]
    fn a_vertex_that_is_not_finite_is_named_even_where_no_triangle_uses_it() {
        let mut vertices = square();
        vertices.push(DVec3::new(0.0, f64::INFINITY, 0.0));
        let refused = Mesh::new(vertices, vec![[0, 1, 2]]).unwrap_err();
        assert_eq!(refused, ShapeError::NotFinite { vertex: 4, value: f64::INFINITY });
    }

    #[test]
    fn degenerate_triangles_are_legal() {
        let mesh = Mesh::new(square(), vec![[0, 0, 0], [0, 1, 1], [0, 1, 2]]).unwrap();
        assert_eq!(mesh.tree().leaf_count(), 1);
        assert_eq!(mesh.leaves().len(), 1);
        assert_eq!(mesh.points().len(), 3);
    }

    #[test]
    fn a_vertex_that_no_triangle_names_is_no_part_of_the_mesh() {
        let mut vertices = square();
        vertices.push(DVec3::splat(100.0));
        let mesh = Shape::mesh(vertices, vec![[0, 1, 2]]).unwrap();
        assert!(mesh.reach() < 3.0);
        assert!(mesh.aabb(&Pose::IDENTITY).max.x <= 1.001);
    }

    #[test]
    fn the_corners_of_a_leaf_are_those_of_its_triangles() {
        let vertices: Vec<_> =
            (0..60).map(|k| DVec3::new(k as f64, (k * k % 7) as f64, 1e6)).collect();
        let triangles: Vec<_> = (0..58).map(|k| [k, k + 1, k + 2]).collect();
        let mesh = Mesh::new(vertices, triangles).unwrap();
        for (leaf, lanes) in mesh.leaves().iter().zip(mesh.tree().below()) {
            let expected = mesh.corners(lanes.0[0] as usize).unwrap();
            for (block, corner) in leaf.corners.iter().zip(expected) {
                let there = DVec3::from_array(block.0.map(|row| f64::from(row.0[0])));
                assert!((leaf.centre + there - corner).length() < 1e-5);
                assert!(there.length() <= leaf.radius * 1.000001);
            }
        }
    }
}
