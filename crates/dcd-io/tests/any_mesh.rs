//! Whatever a mesh file holds, it is read or refused: files that are all but right.
#![cfg(feature = "meshes")]
#![allow(missing_docs)]

use dcd_geom::Shape;
use dcd_io::{MeshFormat, MeshOptions, TriangleMesh, UpAxis};
use proptest::collection::vec;
use proptest::prelude::*;

const STL: &str = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n\
    vertex 0 1 1e-1\nendloop\nendfacet\nendsolid a\n";

const COLLADA: &str = r##"<COLLADA><asset><unit meter="0.0254"/><up_axis>Y_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh><source id="s">
<float_array id="f" count="12">0 0 0 1 0 0 1 1 0 0 1 .5</float_array><technique_common>
<accessor source="#f" count="4" stride="3"><param name="X"/><param name="Y"/><param name="Z"/></accessor>
</technique_common></source><vertices id="v"><input semantic="POSITION" source="#s"/></vertices>
<polylist count="2"><input semantic="VERTEX" source="#v" offset="0"/><vcount>4 3</vcount><p>0 1 2 3 0 1 2</p></polylist>
<tristrips count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 3 2</p></tristrips>
</mesh></geometry></library_geometries>
<library_nodes><node id="n"><skew>45 0 1 0 1 0 0</skew><instance_geometry url="#g"/></node></library_nodes>
<library_visual_scenes><visual_scene id="w"><node><translate>1 2 3</translate><rotate>0 0 1 90</rotate>
<matrix>1 0 0 5 0 1 0 6 0 0 1 7 0 0 0 1</matrix><lookat>1 2 3 0 0 0 0 0 1</lookat><scale>1 -1 1</scale>
<instance_node url="#n"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#w"/></scene></COLLADA>"##;

const GLTF: &str = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
"nodes":[{"children":[1],"translation":[1,2,3]},{"mesh":0,"scale":[1,1,-1]}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1},{"attributes":{"POSITION":0},"mode":5}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},
{"bufferView":1,"byteOffset":1,"componentType":5121,"count":3,"type":"SCALAR"}],
"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":32,"byteLength":4}],
"buffers":[{"byteLength":36,"uri":"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]}"#;

const OBJ: &str = "o a\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 .1\nf 1 2 3 4\nf -1/1/1 -2 -3\nl 1 2\n";

/// Two triangles, with a header as a text has it.
fn binary_stl() -> Vec<u8> {
    let mut bytes = b"solid facet".to_vec();
    bytes.resize(80, 0);
    bytes.extend(2u32.to_le_bytes());
    let triangle = [0f32, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    for _ in 0..2 {
        bytes.extend(triangle.iter().flat_map(|x| x.to_le_bytes()));
        bytes.extend([0, 0]);
    }
    bytes
}

fn binary_gltf() -> Vec<u8> {
    let mut json = GLTF
        .replace(",\"uri\":\"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA\"", "")
        .into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut bytes = [b"glTF", &2u32.to_le_bytes()[..]].concat();
    bytes.extend((12 + 8 + json.len() as u32 + 8 + 36).to_le_bytes());
    for (kind, chunk) in [(b"JSON", &json), (b"BIN\0", &vec![0; 36])] {
        bytes.extend((chunk.len() as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(chunk);
    }
    bytes
}

fn files() -> Vec<(MeshFormat, Vec<u8>)> {
    vec![
        (MeshFormat::Stl, STL.as_bytes().to_vec()),
        (MeshFormat::Stl, binary_stl()),
        (MeshFormat::Collada, COLLADA.as_bytes().to_vec()),
        (MeshFormat::Gltf, GLTF.as_bytes().to_vec()),
        (MeshFormat::Gltf, binary_gltf()),
        (MeshFormat::Obj, OBJ.as_bytes().to_vec()),
    ]
}

/// What is put in the place of some bytes: anything, and what numbers and counts break at.
const BREAKERS: [&str; 14] = [
    "",
    "0",
    "-1",
    "3",
    "4294967295",
    "4294967296",
    "18446744073709551615",
    "1e308",
    "-1e999",
    "nan",
    "<node>",
    "facet",
    "#n",
    "\u{0}",
];

#[derive(Clone, Debug)]
struct Change {
    place: prop::sample::Index,
    removed: usize,
    breaker: usize,
    noise: Vec<u8>,
}

fn change() -> impl Strategy<Value = Change> {
    let parts =
        (any::<prop::sample::Index>(), 0..6usize, 0..BREAKERS.len(), vec(any::<u8>(), 0..3));
    parts.prop_map(|(place, removed, breaker, noise)| Change { place, removed, breaker, noise })
}

fn check(bytes: &[u8], format: MeshFormat) {
    for up_axis in [UpAxis::Ros, UpAxis::File] {
        let options = MeshOptions { up_axis, ..MeshOptions::default() };
        match TriangleMesh::read(bytes, format, &options) {
            Ok(mesh) => {
                assert!(mesh.vertices.iter().all(|vertex| vertex.is_finite()));
                assert!(Shape::mesh(mesh.vertices, mesh.triangles).is_ok());
            }
            Err(error) => assert!(!error.to_string().is_empty()),
        }
    }
}

#[test]
fn the_files_that_are_changed_are_right_before() {
    for (format, bytes) in files() {
        let mesh = TriangleMesh::read(&bytes, format, &MeshOptions::default());
        assert!(!mesh.unwrap().triangles.is_empty(), "{format}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 20_000, failure_persistence: None, ..Default::default()
    })]

    #[test]
    fn a_mesh_file_with_some_bytes_changed_never_panics(
        (file, changes) in (0..6usize, vec(change(), 1..4)),
    ) {
        let (format, mut bytes) = files().swap_remove(file);
        for change in changes {
            let start = change.place.index(bytes.len());
            let end = (start + change.removed).min(bytes.len());
            let put = [BREAKERS[change.breaker].as_bytes(), &change.noise].concat();
            bytes.splice(start..end, put);
            if bytes.is_empty() {
                break;
            }
        }
        check(&bytes, format);
    }

    #[test]
    fn any_bytes_are_a_mesh_or_refused(bytes in vec(any::<u8>(), 0..200)) {
        for (format, _) in files() {
            check(&bytes, format);
        }
    }
}
