//! AABBs as text: one a line, min x y z max x y z.

use crate::ReadError;
use crate::bytes::without_mark;
use dcd_geom::Aabb;
use glam::Vec3;
use std::path::Path;

/// Reads AABBs. Blank lines are passed over.
///
/// Each number becomes the nearest f32: such files are prints of f32, and where enough digits were
/// printed the nearest one is the number itself; rounding outward would add a float to every side
/// that is no binary fraction, and could join AABBs that were apart. Equal texts give equal
/// numbers, so that AABBs that touch in the text touch here.
///
/// # Errors
/// A line without six fields, a field that is no number or not finite, an AABB that is inside out.
pub fn read_boxes(bytes: &[u8]) -> Result<Vec<Aabb>, ReadError> {
    let lines = without_mark(bytes).split(|&byte| byte == b'\n').enumerate();
    let lines = lines.filter(|(_, line)| !line.trim_ascii().is_empty());
    lines.map(|(index, line)| read_box(index + 1, line)).collect()
}

/// [`read_boxes`] from a file.
///
/// # Errors
/// Those of [`read_boxes`], and those of reading the file, both with its path.
pub fn load_boxes(path: &Path) -> Result<Vec<Aabb>, ReadError> {
    ReadError::within(path, read_boxes)
}

fn read_box(line: usize, text: &[u8]) -> Result<Aabb, ReadError> {
    let fields = || text.split(u8::is_ascii_whitespace).filter(|field| !field.is_empty());
    let found = fields().count();
    if found != 6 {
        return Err(ReadError::Fields { line, expected: 6, found });
    }
    let mut numbers = [0f32; 6];
    for (field, (number, bytes)) in numbers.iter_mut().zip(fields()).enumerate() {
        let text = String::from_utf8_lossy(bytes);
        *number = match text.parse() {
            Ok(number) => number,
            Err(_) => return Err(ReadError::NotANumber { line, field, text: text.into_owned() }),
        };
        if !number.is_finite() {
            let value = (*number).into();
            return Err(ReadError::NotFinite { what: "line", index: line, value });
        }
    }
    let [x, y, z, ..] = numbers;
    let [.., far_x, far_y, far_z] = numbers;
    let aabb = Aabb { min: Vec3::new(x, y, z), max: Vec3::new(far_x, far_y, far_z) };
    match (0..3).find(|&axis| aabb.min[axis] > aabb.max[axis]) {
        None => Ok(aabb),
        Some(axis) => {
            let (min, max) = (aabb.min[axis], aabb.max[axis]);
            Err(ReadError::InsideOut { line, axis, min, max })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_are_read_with_or_without_a_last_newline() {
        let boxes = read_boxes(b"-1 -2 -3 1 2 3.5\r\n\n0 0 0 0 0 1e-3").unwrap();
        assert_eq!(boxes.len(), 2);
        assert_eq!(boxes[0].max, Vec3::new(1.0, 2.0, 3.5));
        assert_eq!(boxes[1].max.z, 1e-3);
        assert!(read_boxes(b"").unwrap().is_empty());
    }

    #[test]
    fn a_byte_order_mark_is_passed_over() {
        assert_eq!(read_boxes(b"\xef\xbb\xbf0 0 0 1 1 1").unwrap().len(), 1);
    }

    #[test]
    fn a_line_with_another_number_of_fields_is_refused() {
        for (text, count) in [("0 0 0 1 1", 5), ("0 0 0 1 1 1 1", 7)] {
            let refused = read_boxes(format!("0 0 0 1 1 1\n{text}\n").as_bytes()).unwrap_err();
            let named = matches!(refused, ReadError::Fields { line: 2, expected: 6, found } if found == count);
            assert!(named, "{refused}");
        }
    }

    #[test]
    fn what_is_no_finite_number_is_refused_with_its_text() {
        let refused = read_boxes(b"0 0 0 1 one 1").unwrap_err();
        let named =
            matches!(&refused, ReadError::NotANumber { line: 1, field: 4, text } if text == "one");
        assert!(named, "{refused}");
        for bad in ["nan", "inf", "1e40", "-1e40"] {
            let refused = read_boxes(format!("0 0 0 1 {bad} 1").as_bytes()).unwrap_err();
            assert!(matches!(refused, ReadError::NotFinite { index: 1, .. }), "{refused}");
        }
        assert!(matches!(read_boxes(b"0 0 \xff 1 1 1"), Err(ReadError::NotANumber { .. })));
    }

    #[test]
    fn a_box_that_is_inside_out_is_refused_with_its_axis() {
        let refused = read_boxes(b"0 3 0 1 2 1").unwrap_err();
        assert!(matches!(refused, ReadError::InsideOut { line: 1, axis: 1, .. }), "{refused}");
    }

    #[test]
    fn text_cut_at_any_byte_never_panics() {
        let text = b"0 0 0 1 1 1\n0 0 0 2.5 2.5 2.5\n";
        let cut = (0..text.len()).map(|end| read_boxes(&text[..end]));
        assert!(cut.filter(|boxes| boxes.is_err()).count() > 15);
    }
}
