//! OBJ: what the library reads, after what it would pass over in silence is refused.

use super::{MeshError, MeshFormat, MeshPlace, TriangleMesh, read_obj};
use crate::ReadError;
use crate::bytes::without_mark;

/// Statements whose geometry no reader here makes: surfaces without triangles, other files.
const REFUSED: [&str; 6] = ["surf", "bzp", "bsp", "cdp", "res", "call"];

/// Reads the faces of a file as triangles.
pub(super) fn read(bytes: &[u8]) -> Result<TriangleMesh, MeshError> {
    for (index, line) in without_mark(bytes).split(|&byte| byte == b'\n').enumerate() {
        let word = line.split(u8::is_ascii_whitespace).find(|word| !word.is_empty());
        if let Some(name) = REFUSED.iter().find(|name| word == Some(name.as_bytes())) {
            let problem = format!("{name:?} is not supported");
            return Err(refused(index + 1, problem));
        }
    }
    match read_obj(bytes) {
        Ok(mesh) => Ok(mesh.into()),
        Err(ReadError::Obj { message }) => {
            let line = first_bad_line(bytes);
            // Some messages name it themselves.
            let problem = message.strip_prefix(&format!("line {line}: ")).unwrap_or(&message);
            Err(refused(line, problem.to_owned()))
        }
        Err(error) => Err(MeshError::Read(error)),
    }
}

fn refused(line: usize, problem: String) -> MeshError {
    MeshError::refused(MeshFormat::Obj, MeshPlace::Line(line), problem)
}

/// The line, counted from 1, up to which the text can no longer be read: the library names none.
fn first_bad_line(bytes: &[u8]) -> usize {
    let lines: Vec<_> = bytes.split_inclusive(|&byte| byte == b'\n').collect();
    let ends: Vec<usize> = lines
        .iter()
        .scan(0, |end, line| {
            *end += line.len();
            Some(*end)
        })
        .collect();
    let reads = |&end: &usize| !matches!(read_obj(&bytes[..end]), Err(ReadError::Obj { .. }));
    (ends.partition_point(reads) + 1).min(ends.len().max(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_names_its_line() {
        for (text, line) in [
            ("v 0 0 0\nv 1 0 0\nv 0 1 zero\nf 1 2 3\n", 3),
            ("# a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 4\n", 6),
            ("v 0 0 0\nf 1 two 3", 2),
            ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 6148914691236517207\n", 4),
        ] {
            let error = read(text.as_bytes()).unwrap_err();
            let place = MeshPlace::Line(line);
            assert!(
                matches!(&error, MeshError::Refused { place: found, .. } if *found == place),
                "{text}: {error}"
            );
        }
    }

    #[test]
    fn free_form_surfaces_and_other_files_are_refused_with_their_line() {
        let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
        for statement in ["surf 0 1 0 1 1 2 3 4", "call part.obj", "\tbzp 1 2 3"] {
            let error = read(format!("{triangle}{statement}\n").as_bytes()).unwrap_err();
            assert!(error.to_string().starts_with("OBJ, line 5: "), "{error}");
        }
        let first = read(format!("\u{feff}call part.obj\n{triangle}").as_bytes()).unwrap_err();
        assert!(first.to_string().starts_with("OBJ, line 1: "), "{first}");
        assert_eq!(read(format!("{triangle}usemtl surf\n").as_bytes()).unwrap().triangles.len(), 1);
    }
}
