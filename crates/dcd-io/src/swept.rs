//! AABBs swept by a mesh's vertices and faces from one frame to the next.

use crate::bytes::without_mark;
use crate::{RawMesh, ReadError};
use dcd_geom::Aabb;
use glam::DVec3;
use std::path::Path;

/// One AABB for each vertex and one for each face: the smallest that holds it in both frames, and
/// so wherever it is between them while its vertices move straight.
///
/// Listed pairs name AABBs by ids that count vertices first, then edges, then faces. Edges have
/// ids but no AABB here.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SweptBoxes {
    /// The AABBs: vertices, then faces.
    pub boxes: Vec<Aabb>,
    /// How many vertices there are.
    pub vertices: usize,
    /// How many edges there are.
    pub edges: usize,
}

impl SweptBoxes {
    /// Sweeps one frame to the next.
    ///
    /// # Errors
    /// Frames of other numbers of vertices or faces, or whose faces differ; a corner that is no
    /// vertex.
    pub fn between(first: &RawMesh, second: &RawMesh) -> Result<Self, ReadError> {
        let counts = [
            ("number of vertices", first.vertices.len(), second.vertices.len()),
            ("number of faces", first.faces.len(), second.faces.len()),
        ];
        for (what, first, second) in counts {
            if first != second {
                return Err(ReadError::FramesDiffer { what, first, second });
            }
        }
        if let Some(face) = first.faces.iter().zip(&second.faces).position(|(a, b)| a != b) {
            return Err(ReadError::FramesDiffer { what: "face", first: face, second: face });
        }
        first.check_corners()?;
        let moved = first.vertices.iter().zip(&second.vertices);
        let mut boxes: Vec<Aabb> = moved.map(|(&a, &b)| swept(a, b)).collect();
        let faces = first.faces.iter().map(|face| {
            let corners = face.map(|corner| boxes[corner as usize]);
            corners.iter().fold(Aabb::EMPTY, |all, corner| all.union(corner))
        });
        let faces: Vec<Aabb> = faces.collect();
        boxes.extend(faces);
        Ok(Self { boxes, vertices: first.vertices.len(), edges: edges(&first.faces) })
    }

    /// The index in [`SweptBoxes::boxes`] of the AABB with this id; none if it is an edge's or
    /// nobody's.
    pub fn index_of(&self, id: u32) -> Option<usize> {
        let id = id as usize;
        let index = if id < self.vertices { id } else { id.checked_sub(self.edges)? };
        let is_edge = id >= self.vertices && index < self.vertices;
        (!is_edge && index < self.boxes.len()).then_some(index)
    }
}

fn swept(a: DVec3, b: DVec3) -> Aabb {
    Aabb::outward(a.min(b), a.max(b))
}

/// How many different edges the faces have.
fn edges(faces: &[[u32; 3]]) -> usize {
    let sides = faces.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
    let mut edges: Vec<_> = sides.map(|(a, b)| (a.min(b), a.max(b))).collect();
    edges.sort_unstable();
    edges.dedup();
    edges.len()
}

/// Reads pairs of AABB ids: a JSON array of arrays of two.
///
/// # Errors
/// Anything else.
pub fn read_listed_pairs(bytes: &[u8]) -> Result<Vec<[u32; 2]>, ReadError> {
    serde_json::from_slice(without_mark(bytes)).map_err(ReadError::Json)
}

/// [`read_listed_pairs`] from a file.
///
/// # Errors
/// Those of [`read_listed_pairs`], and those of reading the file, both with its path.
pub fn load_listed_pairs(path: &Path) -> Result<Vec<[u32; 2]>, ReadError> {
    ReadError::within(path, read_listed_pairs)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(height: f64) -> RawMesh {
        let corner = |x: f64, y: f64| DVec3::new(x, y, height);
        let vertices = vec![corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)];
        RawMesh { vertices, faces: vec![[0, 1, 2], [0, 2, 3]] }
    }

    #[test]
    fn aabbs_hold_both_frames_and_ids_leave_space_for_edges() {
        let swept = SweptBoxes::between(&square(0.0), &square(2.0)).unwrap();
        assert_eq!((swept.vertices, swept.edges, swept.boxes.len()), (4, 5, 6));
        assert_eq!(swept.boxes[1], Aabb::outward(DVec3::X, DVec3::new(1.0, 0.0, 2.0)));
        assert_eq!(swept.boxes[5], Aabb::outward(DVec3::ZERO, DVec3::new(1.0, 1.0, 2.0)));
        let indices: Vec<_> = (0..12).map(|id| swept.index_of(id)).collect();
        let boxed =
            [Some(0), Some(1), Some(2), Some(3), None, None, None, None, None, Some(4), Some(5)];
        assert_eq!(indices[..11], boxed);
        assert_eq!((indices[11], swept.index_of(u32::MAX)), (None, None));
    }

    #[test]
    fn frames_that_do_not_belong_together_are_refused() {
        let mut other = square(1.0);
        other.faces[1] = [0, 3, 2];
        let refused = SweptBoxes::between(&square(0.0), &other).unwrap_err();
        assert!(matches!(refused, ReadError::FramesDiffer { what: "face", first: 1, .. }));
        other.vertices.pop();
        let refused = SweptBoxes::between(&square(0.0), &other).unwrap_err();
        assert!(matches!(refused, ReadError::FramesDiffer { first: 4, second: 3, .. }));
        let mut lost = square(0.0);
        lost.faces[0][2] = 4;
        let refused = SweptBoxes::between(&lost, &lost).unwrap_err();
        assert!(matches!(refused, ReadError::OutOfBounds { index: 0, target: 4, .. }));
    }

    #[test]
    fn what_is_no_list_of_pairs_is_refused() {
        assert_eq!(read_listed_pairs(b"[[1,2],[3,4]]").unwrap(), [[1, 2], [3, 4]]);
        assert_eq!(read_listed_pairs(b"\xef\xbb\xbf[[1,2]]").unwrap(), [[1, 2]]);
        for text in ["", "[[1,2]", "[[1]]", "[[1,2,3]]", "[[1,-2]]", "[[1,4294967296]]", "{}"] {
            let refused = read_listed_pairs(text.as_bytes());
            assert!(matches!(refused, Err(ReadError::Json(_))), "{text}");
        }
    }
}
