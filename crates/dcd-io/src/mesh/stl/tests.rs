use super::*;

/// A binary file with this header and these triangles.
fn binary_file(header: &[u8], triangles: &[[[f32; 3]; 3]]) -> Vec<u8> {
    let mut bytes = header.to_vec();
    bytes.resize(80, 0);
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for corners in triangles {
        // Nothing depends on the normal.
        bytes.extend([f32::NAN; 3].iter().flat_map(|x| x.to_le_bytes()));
        bytes.extend(corners.iter().flatten().flat_map(|x| x.to_le_bytes()));
        bytes.extend([7, 7]);
    }
    bytes
}

const SQUARE: [[[f32; 3]; 3]; 2] = [
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.1]],
    [[-0.0, 0.0, 0.0], [1.0, 1.0, 0.1], [0.0, 1.0, 0.0]],
];

fn facet_text(corners: [[f64; 3]; 3]) -> String {
    let vertex = |[x, y, z]: [f64; 3]| format!("      vertex {x:e} {y:e} {z:e}\n");
    let vertices: String = corners.into_iter().map(vertex).collect();
    format!("  facet normal 0 0 1\n    outer loop\n{vertices}    endloop\n  endfacet\n")
}

const FIRST: [[f64; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.1]];

fn line_of(error: MeshError) -> usize {
    match error {
        MeshError::Refused { place: MeshPlace::Line(line), .. } => line,
        other => panic!("no line in: {other}"),
    }
}

#[test]
fn a_binary_file_is_read_and_welded_exactly() {
    let mesh = read(&binary_file(b"made by hand", &SQUARE)).unwrap();
    // The first corners differ in the sign of zero alone.
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(mesh.vertices[2], DVec3::new(1.0, 1.0, f64::from(0.1f32)));
    let mut apart = SQUARE;
    apart[1][1][2] = f32::from_bits(0.1f32.to_bits() + 1);
    assert_eq!(read(&binary_file(b"", &apart)).unwrap().vertices.len(), 5);
}

#[test]
fn a_binary_file_that_begins_with_solid_is_binary() {
    for header in [&b"solid"[..], b"solid part\nfacet normal 0 0 1", b"SOLID Exported"] {
        let mesh = read(&binary_file(header, &SQUARE)).unwrap();
        assert_eq!(mesh, read(&binary_file(b"", &SQUARE)).unwrap());
    }
}

#[test]
fn degenerate_and_repeated_triangles_are_kept() {
    let point = [[1.0; 3]; 3];
    let mesh = read(&binary_file(b"", &[SQUARE[0], SQUARE[0], point])).unwrap();
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 1, 2], [3, 3, 3]]);
    assert!(dcd_geom::Shape::mesh(mesh.vertices, mesh.triangles).is_ok());
}

#[test]
fn a_binary_file_that_is_cut_or_goes_on_is_refused() {
    for header in [&b""[..], b"solid part"] {
        let bytes = binary_file(header, &SQUARE);
        for end in 0..bytes.len() {
            assert!(read(&bytes[..end]).is_err(), "{end}");
        }
        let longer = [&bytes[..], &[0; RECORD]].concat();
        let error = read(&longer).unwrap_err();
        assert!(error.to_string().contains("counts 2 triangles"), "{error}");
        // A few bytes behind the last triangle are not another one, and named; corners without the two bytes behind
        // them may be one.
        assert_eq!(read(&bytes).unwrap().warnings, []);
        for behind in [1, 47, 48, 49] {
            let read = read(&[&bytes[..], &[0; 49][..behind]].concat());
            if behind < 48 {
                let mesh = read.unwrap();
                assert_eq!(mesh.triangles.len(), 2);
                assert_eq!(mesh.warnings, [MeshWarning::Behind { bytes: behind }]);
            } else {
                let error = read.unwrap_err().to_string();
                assert!(error.ends_with("hold 2 and the corners of another"), "{error}");
            }
        }
    }
}

#[test]
fn an_absurd_count_is_refused_before_anything_is_allocated() {
    for header in [&b""[..], b"solid part"] {
        let mut bytes = binary_file(header, &SQUARE);
        bytes[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
        let error = read(&bytes).unwrap_err();
        assert!(error.to_string().contains("4294967295"), "{error}");
    }
}

#[test]
fn a_corner_that_is_not_finite_is_named_with_its_triangle_and_byte() {
    let mut square = SQUARE;
    square[1][2][1] = f32::INFINITY;
    let error = read(&binary_file(b"", &square)).unwrap_err();
    let at = 84 + 50 + 12 + 4 * 7;
    assert_eq!(error.to_string(), format!("STL, byte {at}: a corner of triangle 1 holds inf"));
}

#[test]
fn text_is_read_with_full_precision_and_in_either_case() {
    let text = format!("solid a part, facets of it\n{}endsolid a part\n", facet_text(FIRST));
    for text in
        [text.clone(), text.to_uppercase(), text.replace('\n', "\r\n"), format!("\n {text}")]
    {
        let mesh = read(text.as_bytes()).unwrap();
        assert_eq!(mesh.triangles, [[0, 1, 2]]);
        assert_eq!(mesh.vertices[2], DVec3::new(0.0, 1.0, 0.1));
    }
}

#[test]
fn every_solid_of_a_text_is_read() {
    let second = FIRST.map(|[x, y, z]| [x, y, z + 5.0]);
    let solid = |corners| format!("solid\n{}endsolid\n", facet_text(corners));
    let text = [solid(FIRST), solid(second)].concat();
    let mesh = read(text.as_bytes()).unwrap();
    assert_eq!((mesh.triangles.len(), mesh.vertices.len()), (2, 6));
}

#[test]
fn a_normal_may_be_anything_and_a_facet_in_one_line() {
    let text = "solid x\nfacet normal -nan(ind) nan 0 outer loop vertex 0 0 0 vertex 1 0 0 \
                vertex 0 1 0 endloop endfacet\nendsolid x";
    assert_eq!(read(text.as_bytes()).unwrap().triangles.len(), 1);
}

#[test]
fn a_text_that_is_cut_anywhere_is_refused() {
    let text = format!("solid a\n{}endsolid", facet_text(FIRST));
    for end in 0..text.len() {
        assert!(read(&text.as_bytes()[..end]).is_err(), "{end}");
    }
    assert!(read(text.as_bytes()).is_ok());
}

#[test]
fn what_is_wrong_with_a_text_is_said_with_its_line() {
    let whole = format!("solid a\n{}endsolid a\n", facet_text(FIRST));
    for (from, to, line) in [
        ("1e-1", "nan", 6),
        ("1e-1", "one", 6),
        ("outer loop", "outer", 4),
        ("    endloop", "      vertex 1 1 1\n    endloop", 7),
        ("endfacet", "facet", 8),
        ("endsolid a", "endsolid a\nfacet", 10),
    ] {
        let changed = whole.replacen(from, to, 1);
        assert_ne!(changed, whole);
        assert_eq!(line_of(read(changed.as_bytes()).unwrap_err()), line, "{to}");
    }
}

#[test]
fn a_facet_in_the_line_of_a_name_is_not_passed_over() {
    let facet = facet_text(FIRST).replace('\n', " ");
    let lines = format!("solid a\n{facet}\nendsolid a solid b {facet} endsolid b\n");
    assert_eq!(line_of(read(lines.as_bytes()).unwrap_err()), 3);
    let one = format!("solid a {facet} endsolid a");
    assert_eq!(line_of(read(one.as_bytes()).unwrap_err()), 1);
}
