//! OBJ: what the library reads, after what it would pass over in silence is refused or counted.

use super::{
    MeshError, MeshFormat, MeshPlace, MeshWarning, TriangleMesh, read_obj, without_comments,
};
use crate::ReadError;
use crate::bytes::without_mark;

/// Statements of names and looks, and of what a surface that is not refused would need.
const OF_NO_SURFACE: [&[u8]; 28] = [
    b"g",
    b"o",
    b"s",
    b"mg",
    b"usemtl",
    b"mtllib",
    b"usemap",
    b"maplib",
    b"bevel",
    b"c_interp",
    b"d_interp",
    b"lod",
    b"shadow_obj",
    b"trace_obj",
    b"ctech",
    b"stech",
    b"vp",
    b"cstype",
    b"deg",
    b"bmat",
    b"step",
    b"parm",
    b"trim",
    b"hole",
    b"scrv",
    b"sp",
    b"end",
    b"con",
];

/// Reads the faces of a file as triangles.
pub(super) fn read(bytes: &[u8]) -> Result<TriangleMesh, MeshError> {
    let warnings = passed_over(bytes)?;
    match read_obj(bytes) {
        Ok(mesh) => Ok(TriangleMesh { warnings, ..mesh.into() }),
        Err(ReadError::Obj { message }) => {
            let line = first_bad_line(bytes);
            // Some messages name it themselves.
            let problem = message.strip_prefix(&format!("line {line}: ")).unwrap_or(&message);
            Err(refused(line, problem.to_owned()))
        }
        Err(error) => Err(MeshError::Read(error)),
    }
}

/// What the library passes over: points, lines and faces of fewer than three corners, and lines of numbers
/// alone, as some write their counts. Any other statement could be a surface, and is refused.
fn passed_over(bytes: &[u8]) -> Result<Vec<MeshWarning>, MeshError> {
    let (mut lines, mut numbers, mut first) = (0, 0, 0);
    for (index, line) in
        without_comments(without_mark(bytes)).split(|&byte| byte == b'\n').enumerate()
    {
        let mut words = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        match words.next() {
            None | Some([b'#', ..] | b"v" | b"vt" | b"vn") => {}
            Some(b"f") => lines += usize::from(words.nth(2).is_none()),
            Some(b"l" | b"p" | b"curv" | b"curv2") => lines += 1,
            Some(word) if OF_NO_SURFACE.contains(&word) => {}
            Some(_) if is_numbers(line) => {
                first = if numbers == 0 { index + 1 } else { first };
                numbers += 1;
            }
            Some(word) => {
                let problem = format!("{:?} is not supported", String::from_utf8_lossy(word));
                return Err(refused(index + 1, problem));
            }
        }
    }
    let lines = (lines > 0).then_some(MeshWarning::Lines { count: lines });
    let numbers = (numbers > 0).then_some(MeshWarning::Numbers { count: numbers, first });
    Ok(lines.into_iter().chain(numbers).collect())
}

fn is_numbers(line: &[u8]) -> bool {
    String::from_utf8_lossy(line).split_whitespace().all(|word| word.parse::<f64>().is_ok())
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
    fn a_comment_may_stand_behind_numbers() {
        let text = "v 0 0 0 # a\nv 1 0 0\t#b\nv 0 1 0\nf 1 2 3 # 4 5\nf 1 2 # 3\nusemtl steel #2\n";
        let mesh = read(text.as_bytes()).unwrap();
        assert_eq!((mesh.vertices.len(), mesh.triangles.len()), (3, 1));
        assert_eq!(mesh.warnings, [MeshWarning::Lines { count: 1 }]);
        for bad in ["f 1 2 3#\n", "f 1 2 3 # a\rf 1 2 3\n", "f 1 2 3 # a\\\nf 1 2 3\n"] {
            let text = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{bad}");
            assert!(read(text.as_bytes()).is_err(), "{bad}");
        }
    }

    #[test]
    fn free_form_surfaces_and_other_files_are_refused_with_their_line() {
        let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
        for statement in ["surf 0 1 0 1 1 2 3 4", "call part.obj", "\tbzp 1 2 3"] {
            let error = read(format!("{triangle}{statement}\n").as_bytes()).unwrap_err();
            assert!(error.to_string().starts_with("OBJ, line 5: "), "{error}");
        }
        let others = ["F 1 2 3", "V 9 9 9", "fo 1 2 3", "CALL part.obj", "cdc 1 2 3 4"];
        let no_statements = ["face 1 2 3", "\0\0f 1 2 3", "1 2 three", "G part"];
        for other in others.into_iter().chain(no_statements) {
            let error = read(format!("{triangle}{other}\n").as_bytes()).unwrap_err();
            assert!(error.to_string().starts_with("OBJ, line 5: "), "{error}");
        }
        let first = read(format!("\u{feff}call part.obj\n{triangle}").as_bytes()).unwrap_err();
        assert!(first.to_string().starts_with("OBJ, line 1: "), "{first}");
        assert_eq!(read(format!("{triangle}usemtl surf\n").as_bytes()).unwrap().triangles.len(), 1);
    }

    #[test]
    fn names_may_be_in_any_encoding_and_numbers_may_not() {
        let text = |number: &[u8]| {
            let names = b"# Gr\xf6\xdfe\no \xd4\xd8\nusemtl \xff\n";
            [&names[..], b"v 0 0 0\nv 1 0 0\nv 0 1 ", number, b"\nf 1 2 3\n"].concat()
        };
        assert_eq!(read(&text(b"0")).unwrap().triangles, [[0, 1, 2]]);
        let error = read(&text(b"0\xff")).unwrap_err().to_string();
        assert!(error.starts_with("OBJ, line 6: "), "{error}");
    }

    #[test]
    fn lines_that_others_cut_elsewhere_are_refused() {
        let four = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n";
        for more in
            ["f 1 2 \\\n4", "g a \\\nf 1 2 4", "g a\\\r\ng b", "# a\rf 1 2 4", "g a\rf 1 2 4\r"]
        {
            let error = read(format!("{four}{more}\n").as_bytes()).unwrap_err().to_string();
            assert!(error.starts_with("OBJ, line 6: "), "{more:?}: {error}");
        }
        let carriage = read(four.replace('\n', "\r").as_bytes()).unwrap_err().to_string();
        assert!(carriage.starts_with("OBJ, line 1: a carriage return"), "{carriage}");
        let same = format!("# C:\\\n{}", four.replace('\n', "\r\n"));
        assert_eq!(read(same.as_bytes()).unwrap().triangles.len(), 1);
    }

    #[test]
    fn what_is_passed_over_is_counted() {
        let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
        let warnings = |more: &str| {
            let read = read(format!("{triangle}{more}\n").as_bytes()).unwrap();
            assert_eq!(read.triangles.len(), 1);
            read.warnings
        };
        assert_eq!(warnings("# F 1 2 3\no part\ns off\nusemtl f\n\n  vn 0 0 1\r"), []);
        let lines = MeshWarning::Lines { count: 4 };
        assert_eq!(warnings("l 1 2 3\np 1\nf 1 2\nf 3"), [lines]);
        let numbers = MeshWarning::Numbers { count: 2, first: 5 };
        assert_eq!(warnings("648 216\n 1e3"), [numbers]);
    }
}
