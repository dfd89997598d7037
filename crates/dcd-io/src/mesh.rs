//! Triangle meshes from files.

mod collada;
mod error;
mod gltf;
mod obj;
mod opened;
mod paths;
mod stl;
mod triangles;

use crate::bytes::without_mark;
use crate::{RawMesh, ReadError, load_ply};
use dcd_geom::{Shape, ShapeError};
use glam::DVec3;
use std::path::Path;

pub use error::{MeshError, MeshPlace};
pub use opened::OpenedFiles;
pub use paths::{MeshNotFound, MeshPaths};
pub use triangles::{MeshFormat, MeshOptions, MeshWarning, TriangleMesh, UpAxis};

/// Reads the triangles of a Wavefront OBJ file: all of its objects as one mesh, faces of more
/// corners cut into fans. Every vertex is kept, those that no face names behind the others. Points and
/// lines are passed over, and materials are not looked for.
///
/// # Errors
/// Text that is no OBJ, a number that is not finite, a face with a corner that is no vertex. Names may be in any encoding whose
/// bytes below 128 are ASCII.
pub fn read_obj(bytes: &[u8]) -> Result<RawMesh, ReadError> {
    let options = tobj::LoadOptions {
        triangulate: true,
        ignore_points: true,
        ignore_lines: true,
        ..tobj::LoadOptions::default()
    };
    let no_materials = |_: &Path| Ok(Default::default());
    // Names may be in any encoding whose bytes below 128 are ASCII: what counts is ASCII.
    let text = String::from_utf8_lossy(without_mark(bytes));
    let text = &without_comments(text.as_bytes())[..];
    check_lines(text)?;
    check_indices(text)?;
    let faces = without_lines(text);
    let read = tobj::load_obj_buf(&mut &faces[..], &options, no_materials);
    let (models, _) = read.map_err(|error| ReadError::Obj { message: error.to_string() })?;
    let mut frame = RawMesh::default();
    for model in models {
        // Indices count from the object's own first vertex.
        let first = frame.vertices.len() as u32;
        let points = model.mesh.positions.as_chunks().0;
        frame.vertices.extend(points.iter().map(|&point| DVec3::from_array(point)));
        let corners = model.mesh.indices.as_chunks().0;
        let faces = corners.iter().map(|&face: &[u32; 3]| face.map(|k| k.saturating_add(first)));
        frame.faces.extend(faces);
    }
    frame.vertices.extend(loose_vertices(text)?);
    frame.check_corners()?;
    Ok(frame)
}

/// Refuses lines that the library would cut elsewhere than those who wrote them: what is behind a lone carriage return
/// or a backslash would be passed over, or be a statement of its own.
fn check_lines(text: &[u8]) -> Result<(), ReadError> {
    for (index, line) in text.split(|&byte| byte == b'\n').enumerate() {
        let line = line.trim_ascii();
        let problem = if line.contains(&b'\r') {
            "a carriage return alone ends no line"
        } else if line.ends_with(b"\\") && !line.starts_with(b"#") {
            "a statement continued on the next line is not supported"
        } else {
            continue;
        };
        return Err(ReadError::Obj { message: format!("line {}: {problem}", index + 1) });
    }
    Ok(())
}

/// Checks that every index of a face, line or point names one of the vertices (texture vertices, normals)
/// that a u32 counts, from the end those before it. The library multiplies them unchecked: a large one
/// would wrap round and name another vertex.
fn check_indices(text: &[u8]) -> Result<(), ReadError> {
    let mut counts = [0i64; 3];
    for (index, line) in text.split(|&byte| byte == b'\n').enumerate() {
        let text = String::from_utf8_lossy(line);
        let mut words = text.split_whitespace();
        match words.next() {
            Some("v") => counts[0] += 1,
            Some("vt") => counts[1] += 1,
            Some("vn") => counts[2] += 1,
            Some("f" | "l" | "p") => {
                for field in words.flat_map(|corner| corner.split('/').zip(counts)) {
                    // What is no number is for the library to refuse.
                    let (Ok(k), count) = (field.0.parse::<i128>(), i128::from(field.1)) else {
                        continue;
                    };
                    if k == 0 || k < -count || k > i128::from(u32::MAX) {
                        let message = format!("line {}: there is no index {k}", index + 1);
                        return Err(ReadError::Obj { message });
                    }
                }
            }
            _ => {}
        }
    }
    Ok(())
}

/// The vertices that are no triangle's corner, in the file's order: the library leaves them out. Refuses any
/// vertex that is not finite. The text is one that the library has read.
fn loose_vertices(text: &[u8]) -> Result<Vec<DVec3>, ReadError> {
    let (mut vertices, mut named) = (Vec::new(), Vec::new());
    for (index, line) in text.split(|&byte| byte == b'\n').enumerate() {
        let text = String::from_utf8_lossy(line);
        let mut words = text.split_whitespace();
        match words.next() {
            Some("v") => {
                let vertex = vertex(words);
                if !vertex.is_finite() {
                    let message = format!("line {}: a vertex that is not finite", index + 1);
                    return Err(ReadError::Obj { message });
                }
                vertices.push(vertex);
            }
            // Of fewer corners it is no face.
            Some("f") if words.clone().nth(2).is_some() => {
                let corners = words.filter_map(|corner| corner.split('/').next()?.parse().ok());
                named.extend(
                    corners.map(|k: i64| if k < 0 { vertices.len() as i64 + k } else { k - 1 }),
                );
            }
            _ => {}
        }
    }
    let mut is_loose = vec![true; vertices.len()];
    for k in named {
        if let Some(is_loose) = usize::try_from(k).ok().and_then(|k| is_loose.get_mut(k)) {
            *is_loose = false;
        }
    }
    let loose = vertices.into_iter().zip(is_loose).filter(|(_, is_loose)| *is_loose);
    Ok(loose.map(|(vertex, _)| vertex).collect())
}

/// Three coordinates, or four where the last divides the others, as the library has it; colours may follow three.
fn vertex<'a>(words: impl Iterator<Item = &'a str>) -> DVec3 {
    let numbers: Vec<f64> = words.map(|word| word.parse().unwrap_or(f64::NAN)).collect();
    match numbers[..] {
        [x, y, z, w] => DVec3::new(x, y, z) / w,
        [x, y, z, ..] => DVec3::new(x, y, z),
        _ => DVec3::NAN,
    }
}

/// The text with the comments behind the numbers of vertices, faces, lines and points made blanks: the library takes them for numbers.
/// One that hides the end of a line stays, and is refused.
fn without_comments(text: &[u8]) -> Vec<u8> {
    let mut plain = Vec::with_capacity(text.len());
    for line in text.split_inclusive(|&byte| byte == b'\n') {
        let first = plain.len();
        plain.extend_from_slice(line);
        let word = line.split(u8::is_ascii_whitespace).find(|word| !word.is_empty());
        let comment = line.windows(2).position(|at| at[0].is_ascii_whitespace() && at[1] == b'#');
        if let (Some(b"v" | b"vt" | b"vn" | b"f" | b"l" | b"p"), Some(at)) = (word, comment) {
            let said = line[at..].trim_ascii();
            if !said.contains(&b'\r') && !said.ends_with(b"\\") {
                let comment = plain[first + at..].iter_mut();
                comment.filter(|byte| **byte != b'\n').for_each(|byte| *byte = b' ');
            }
        }
    }
    plain
}

/// The text with its lines of points made comments: the library takes those of three and more points for
/// faces.
fn without_lines(text: &[u8]) -> Vec<u8> {
    let mut faces = Vec::with_capacity(text.len());
    for line in text.split_inclusive(|&byte| byte == b'\n') {
        let word = line.split(u8::is_ascii_whitespace).find(|word| !word.is_empty());
        if matches!(word, Some(b"l" | b"p")) {
            faces.push(b'#');
        }
        faces.extend_from_slice(line);
    }
    faces
}

/// [`read_obj`] from a file.
///
/// # Errors
/// Those of [`read_obj`], and those of reading the file, both with its path.
pub fn load_obj(path: &Path) -> Result<RawMesh, ReadError> {
    ReadError::within(path, read_obj)
}

/// The mesh of a file: PLY where it is called so, else OBJ.
///
/// # Errors
/// Those of [`load_ply`] and [`load_obj`].
pub fn load_mesh(path: &Path) -> Result<RawMesh, ReadError> {
    let is_ply = path.extension().is_some_and(|kind| kind.eq_ignore_ascii_case("ply"));
    if is_ply { load_ply(path) } else { load_obj(path) }
}

impl RawMesh {
    /// The mesh as a shape.
    ///
    /// # Errors
    /// Those of [`dcd_geom::Mesh::new`]: for what was read, no triangle at all.
    pub fn into_shape(self) -> Result<Shape, ShapeError> {
        Shape::mesh(self.vertices, self.faces)
    }

    /// The smallest and largest coordinates of the vertices; infinite where there are none.
    pub fn extent(&self) -> (DVec3, DVec3) {
        let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        self.vertices.iter().fold(none, |(low, high), &v| (low.min(v), high.max(v)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn objects_become_one_mesh_and_polygons_fans() {
        let text = b"o first\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0.1\nf 1 2 3 4\n\
            o second\nv 5 5 5\nv 6 5 5\nv 6 6 5\nf 5/1/1 6/2/2 7/3/3\nl 1 2\n";
        let frame = read_obj(text).unwrap();
        assert_eq!(frame.faces.len(), 3);
        let corners = |face: usize| frame.faces[face].map(|k| frame.vertices[k as usize]);
        assert_eq!(corners(0), [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0)]);
        assert_eq!(corners(1)[2], DVec3::new(0.0, 1.0, 0.1));
        assert_eq!(corners(2)[0], DVec3::splat(5.0));
        assert!(matches!(frame.into_shape().unwrap(), Shape::Mesh(_)));
    }

    #[test]
    fn an_index_that_wraps_round_names_no_other_vertex() {
        let face = |corner: &str| {
            let text = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1 2 {corner}\n");
            read_obj(text.as_bytes()).map(|mesh| mesh.faces.len())
        };
        assert_eq!(face("-1").unwrap(), 1);
        // Three times this is 2 more than 2⁶⁴.
        for corner in ["6148914691236517207", "0", "-4", "3//-2", "3//0", "99999999999999999999"] {
            let refused = face(corner).unwrap_err().to_string();
            assert!(refused.contains("line 5"), "{corner}: {refused}");
        }
    }

    #[test]
    fn vertices_that_no_face_names_are_kept_behind_the_others() {
        let text = "o a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 9\nf 1 2 3\no b\nv 0 0 -9\nf 1 2 -1\n\
            v 7 7 7\nf 1 6\nl 1 4 6\nv 4 2 2 2\n";
        let mesh = read_obj(text.as_bytes()).unwrap();
        let corners = |face: usize| mesh.faces[face].map(|k| mesh.vertices[k as usize]);
        let x = DVec3::X;
        assert_eq!(corners(0), [DVec3::ZERO, x, DVec3::Y]);
        assert_eq!(corners(1), [DVec3::ZERO, x, DVec3::new(0.0, 0.0, -9.0)]);
        assert_eq!(mesh.faces.len(), 2);
        // Each object has the vertices that its faces name.
        let loose = [DVec3::new(0.0, 0.0, 9.0), DVec3::splat(7.0), DVec3::new(2.0, 1.0, 1.0)];
        assert_eq!(mesh.vertices[6..], loose);
        let early = read_obj(b"f 2 3/1 4//\nv 5 5 5\nv 0 0 0\nv 1 0 0\nv 0 1 0\n").unwrap();
        assert_eq!(early.vertices, [DVec3::ZERO, x, DVec3::Y, DVec3::splat(5.0)]);
    }

    #[test]
    fn a_line_of_three_points_is_no_face() {
        let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nf 1 2 3\n";
        let plain = read_obj(text.as_bytes()).unwrap();
        assert_eq!(plain.faces.len(), 1);
        for line in ["l 1 2 5", "  l 1 2 4 5", "p 1 2 5", "l 1/1 2/1 5/1"] {
            let text = format!("vt 0 0\n{text}{line}\n");
            assert_eq!(read_obj(text.as_bytes()).unwrap(), plain, "{line}");
        }
    }

    #[test]
    fn a_byte_order_mark_hides_no_vertex() {
        let text = "\u{feff}v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
        let plain = read_obj(&text.as_bytes()[3..]).unwrap();
        assert_eq!(read_obj(text.as_bytes()).unwrap(), plain);
    }

    #[test]
    fn what_is_wrong_with_a_file_is_said() {
        let corner = read_obj(b"v 0 0 0\nv 1 0 0\nf 1 2 3\n").unwrap_err();
        assert!(corner.to_string().contains("bounds"), "{corner}");
        let word = read_obj(b"v 0 0 zero\n").unwrap_err();
        assert!(matches!(word, ReadError::Obj { .. }), "{word}");
        for vertex in ["0 nan 0", "0 0 inf", "1e999 0 0"] {
            let named = format!("v 0 0 0\nv {vertex}\nv 1 1 1\nf 1 2 3\n");
            let loose = format!("v 0 0 0\nv {vertex}\nv 1 1 1\nv 0 0 1\nf 1 3 4\n");
            for text in [named, loose] {
                let refused = read_obj(text.as_bytes()).unwrap_err().to_string();
                assert!(refused.contains("line 2: a vertex that is not finite"), "{refused}");
            }
        }
        assert!(read_obj(b"").unwrap().into_shape().is_err());
    }
}
