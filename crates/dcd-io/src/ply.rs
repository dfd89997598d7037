//! Triangle meshes from binary PLY.
//!
//! Our own reader, and small: it takes x, y, z and the corner lists, passes over whatever else the
//! header declares, and believes no count that the file is too short for.

mod header;

use crate::ReadError;
use crate::bytes::{Cursor, Field};
use glam::DVec3;
use header::{CORNERS, Element, Endian, Header, Kind, Scalar};
use std::path::Path;

/// One frame of a simulated triangle mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RawMesh {
    /// Where the vertices are, metres.
    pub vertices: Vec<DVec3>,
    /// The faces' corners, by index into `vertices`.
    pub faces: Vec<[u32; 3]>,
}

/// Reads a binary PLY file, of either byte order, whose faces are triangles.
///
/// # Errors
/// A header that is no such thing, a file that is cut short or goes on, a number that is not
/// finite, a face that is no triangle or has a corner that is no vertex.
pub fn read_ply(bytes: &[u8]) -> Result<RawMesh, ReadError> {
    let header = Header::read(bytes)?;
    let mut body = Body { cursor: Cursor::new(bytes, header.length), endian: header.endian };
    let mut frame = RawMesh::default();
    for element in &header.elements {
        match element.name.as_str() {
            "vertex" => frame.vertices = body.vertices(element)?,
            "face" => frame.faces = body.faces(element)?,
            _ => body.rows(element, |_, _| Ok(()))?,
        }
    }
    body.cursor.end()?;
    frame.check_corners()?;
    Ok(frame)
}

/// [`read_ply`] from a file.
///
/// # Errors
/// Those of [`read_ply`], and those of reading the file, both with its path.
pub fn load_ply(path: &Path) -> Result<RawMesh, ReadError> {
    ReadError::within(path, read_ply)
}

impl RawMesh {
    pub(crate) fn check_corners(&self) -> Result<(), ReadError> {
        let count = self.vertices.len();
        for (index, face) in self.faces.iter().enumerate() {
            if let Some(&corner) = face.iter().find(|&&corner| corner as usize >= count) {
                let target = corner.into();
                return Err(ReadError::OutOfBounds { what: "face", index, target, count });
            }
        }
        Ok(())
    }
}

/// What follows the header.
struct Body<'a> {
    cursor: Cursor<'a>,
    endian: Endian,
}

impl Body<'_> {
    fn vertices(&mut self, element: &Element) -> Result<Vec<DVec3>, ReadError> {
        let x = element.property(&["x"], "x of the vertices")?;
        let y = element.property(&["y"], "y of the vertices")?;
        let z = element.property(&["z"], "z of the vertices")?;
        let mut vertices = Vec::new();
        self.rows(element, |index, row| {
            let coordinates = [x, y, z].map(|at| row[at].first().copied().unwrap_or(f64::NAN));
            if let Some(&value) = coordinates.iter().find(|x| !x.is_finite()) {
                return Err(ReadError::NotFinite { what: "vertex", index, value });
            }
            vertices.push(DVec3::from_array(coordinates));
            Ok(())
        })?;
        Ok(vertices)
    }

    fn faces(&mut self, element: &Element) -> Result<Vec<[u32; 3]>, ReadError> {
        let corners = element.property(&CORNERS, "list of corners")?;
        let mut faces = Vec::new();
        self.rows(element, |face, row| {
            let &[a, b, c] = row[corners].as_slice() else {
                return Err(ReadError::NotATriangle { face, corners: row[corners].len() as u64 });
            };
            let mut triangle = [0; 3];
            for (corner, index) in triangle.iter_mut().zip([a, b, c]) {
                // Negative, fractional and too large ones become an index that is no vertex.
                let known = index >= 0.0 && index.fract() == 0.0 && index < f64::from(u32::MAX);
                *corner = if known { index as u32 } else { u32::MAX };
            }
            faces.push(triangle);
            Ok(())
        })?;
        Ok(faces)
    }

    /// Reads an element row by row: for each property its numbers, one unless it is a list.
    fn rows(
        &mut self,
        element: &Element,
        mut each: impl FnMut(usize, &[Vec<f64>]) -> Result<(), ReadError>,
    ) -> Result<(), ReadError> {
        let smallest = element.properties.iter().map(|property| property.kind.smallest()).sum();
        let elements = Field { what: "elements", index: 0 };
        self.cursor.check_count(elements, element.count, smallest)?;
        let mut row = vec![Vec::new(); element.properties.len()];
        for index in 0..element.count as usize {
            let field = Field { what: "element", index };
            for (property, numbers) in element.properties.iter().zip(&mut row) {
                numbers.clear();
                match property.kind {
                    Kind::Scalar(scalar) => numbers.push(self.scalar(scalar, field)?),
                    Kind::List { length, item } => {
                        let length = self.length(length, field)?;
                        self.cursor.check_count(field, length, item.size())?;
                        for _ in 0..length {
                            numbers.push(self.scalar(item, field)?);
                        }
                    }
                }
            }
            each(index, &row)?;
        }
        Ok(())
    }

    fn length(&mut self, scalar: Scalar, field: Field) -> Result<u64, ReadError> {
        let length = self.scalar(scalar, field)?;
        // The header lets integers alone count, so this is exact.
        if length >= 0.0 {
            Ok(length as u64)
        } else {
            Err(ReadError::Negative { index: field.index, length: length as i64 })
        }
    }

    /// Every type of PLY is exact in f64.
    fn scalar(&mut self, scalar: Scalar, field: Field) -> Result<f64, ReadError> {
        Ok(match scalar {
            Scalar::I8 => i8::from_le_bytes(self.take(field)?).into(),
            Scalar::U8 => u8::from_le_bytes(self.take(field)?).into(),
            Scalar::I16 => i16::from_le_bytes(self.take(field)?).into(),
            Scalar::U16 => u16::from_le_bytes(self.take(field)?).into(),
            Scalar::I32 => i32::from_le_bytes(self.take(field)?).into(),
            Scalar::U32 => u32::from_le_bytes(self.take(field)?).into(),
            Scalar::F32 => f32::from_le_bytes(self.take(field)?).into(),
            Scalar::F64 => f64::from_le_bytes(self.take(field)?),
        })
    }

    /// The next bytes, little endian whatever they are in the file.
    fn take<const N: usize>(&mut self, field: Field) -> Result<[u8; N], ReadError> {
        match self.endian {
            Endian::Little => self.cursor.take(field),
            Endian::Big => self.cursor.take_big(field),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "ply\nformat binary_big_endian 1.0\ncomment made by hand\n\
        element vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        property uchar red\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";

    fn file(corners: &[i32]) -> Vec<u8> {
        let mut bytes = HEADER.as_bytes().to_vec();
        for vertex in [[0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.1, 0.0]] {
            bytes.extend(vertex.iter().flat_map(|x| x.to_be_bytes()));
            bytes.push(255);
        }
        bytes.push(corners.len() as u8);
        bytes.extend(corners.iter().flat_map(|k| k.to_be_bytes()));
        bytes
    }

    fn with_header(from: &str, to: &str) -> Result<RawMesh, ReadError> {
        let bytes = file(&[0, 1, 2]);
        let changed = HEADER.replace(from, to);
        assert_ne!(changed, HEADER);
        read_ply(&[changed.as_bytes(), &bytes[HEADER.len()..]].concat())
    }

    #[test]
    fn vertices_and_faces_are_read_and_the_rest_passed_over() {
        let frame = read_ply(&file(&[0, 1, 2])).unwrap();
        assert_eq!(frame.vertices[2], DVec3::new(0.0, f64::from(0.1f32), 0.0));
        assert_eq!(frame.faces, [[0, 1, 2]]);
    }

    #[test]
    fn the_other_byte_order_is_read_too() {
        let little =
            HEADER.replace("big", "little").replace(" 3\n", " 1\n").replace("int ", "uint16 ");
        let mut bytes = little.into_bytes();
        bytes.extend([1f32, 2.0, 3.0].iter().flat_map(|x| x.to_le_bytes()));
        bytes.push(9);
        bytes.push(3);
        bytes.extend([0; 6]);
        let frame = read_ply(&bytes).unwrap();
        assert_eq!(frame.vertices, [DVec3::new(1.0, 2.0, 3.0)]);
        assert_eq!(frame.faces, [[0; 3]]);
    }

    #[test]
    fn a_file_cut_at_any_byte_is_refused() {
        let bytes = file(&[0, 1, 2]);
        for end in 0..bytes.len() {
            assert!(read_ply(&bytes[..end]).is_err(), "{end}");
        }
        let refused = read_ply(&[&bytes[..], &[0]].concat()).unwrap_err();
        assert!(matches!(refused, ReadError::Oversized { left: 1, .. }));
    }

    #[test]
    fn a_corrupt_count_is_refused_before_it_is_allocated() {
        for (from, to) in [("vertex 3", "vertex 99999999999999999"), ("face 1", "face 4294967295")]
        {
            let refused = with_header(from, to).unwrap_err();
            assert!(matches!(refused, ReadError::Truncated { .. }), "{refused}");
        }
        let refused = with_header("list uchar", "list uint").unwrap_err();
        assert!(matches!(refused, ReadError::Truncated { needed: 201_326_592, .. }), "{refused}");
    }

    #[test]
    fn a_face_that_is_no_triangle_or_leaves_the_vertices_is_refused() {
        let refused = read_ply(&file(&[0, 1])).unwrap_err();
        assert!(matches!(refused, ReadError::NotATriangle { face: 0, corners: 2 }), "{refused}");
        for corner in [3, -1, i32::MAX] {
            let refused = read_ply(&file(&[0, 1, corner])).unwrap_err();
            assert!(
                matches!(refused, ReadError::OutOfBounds { index: 0, count: 3, .. }),
                "{refused}"
            );
        }
    }

    #[test]
    fn a_vertex_that_is_not_finite_is_named() {
        let mut bytes = file(&[0, 1, 2]);
        let second = HEADER.len() + 13;
        bytes[second..second + 4].copy_from_slice(&f32::NAN.to_be_bytes());
        let refused = read_ply(&bytes).unwrap_err();
        assert!(
            matches!(refused, ReadError::NotFinite { what: "vertex", index: 1, .. }),
            "{refused}"
        );
    }

    #[test]
    fn a_list_of_negative_length_is_refused() {
        let mut bytes = HEADER.replace("list uchar", "list char").into_bytes();
        bytes.extend([0; 39]);
        bytes.push(0xff);
        let refused = read_ply(&bytes).unwrap_err();
        assert!(matches!(refused, ReadError::Negative { index: 0, length: -1 }), "{refused}");
    }

    #[test]
    fn headers_that_mean_nothing_are_refused_with_their_line() {
        for (from, to, bad) in [
            ("ply", "plx", 1),
            ("binary_big_endian", "ascii", 2),
            ("comment", "remark", 3),
            ("element vertex 3", "element vertex three", 4),
            ("element vertex 3\n", "", 4),
            ("property float x", "property real x", 5),
            ("property float x", "property float", 5),
            ("list uchar", "list float", 10),
        ] {
            let refused = with_header(from, to).unwrap_err();
            assert!(
                matches!(refused, ReadError::Header { line, .. } if line == bad),
                "{to}: {refused}"
            );
        }
        let lacking = with_header("float z", "float w").unwrap_err();
        assert!(matches!(lacking, ReadError::Missing { what: "z of the vertices" }), "{lacking}");
        let format = with_header("format binary_big_endian 1.0\n", "").unwrap_err();
        assert!(matches!(format, ReadError::Missing { .. }), "{format}");
    }

    #[test]
    fn elements_and_properties_of_one_name_and_strips_are_refused() {
        for (element, why) in [
            ("vertex 0\nproperty float x", "a second element vertex"),
            ("tristrips 1\nproperty list int int vertex_indices", "made of vertices"),
            ("range 1\nproperty float a\nproperty char a", "with two of a"),
        ] {
            let more = format!(
                "element face 1\nproperty list uchar int vertex_indices\nelement {element}\n"
            );
            let refused =
                with_header("element face 1\nproperty list uchar int vertex_indices\n", &more);
            let refused = refused.unwrap_err().to_string();
            assert!(refused.starts_with("line 11") && refused.contains(why), "{refused}");
        }
        let both = "vertex_indices\nproperty list uchar int vertex_index\n";
        let refused = with_header("vertex_indices\n", both).unwrap_err().to_string();
        assert!(refused.contains("with two lists of corners"), "{refused}");
        // No strip hides nothing.
        let none = "element tristrips 0\nproperty list int int vertex_indices\nend_header";
        assert!(with_header("end_header", none).is_ok());
    }

    #[test]
    fn an_element_without_properties_cannot_make_work_from_nothing() {
        let refused =
            with_header("element face", "element ghost 99999999999\nelement face").unwrap_err();
        assert!(matches!(refused, ReadError::Header { line: 9, .. }), "{refused}");
    }
}
