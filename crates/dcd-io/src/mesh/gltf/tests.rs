use super::*;
use serde_json::{Value, json};

/// A triangle and its corners' indices in 8 bits: 36 bytes, and three.
fn triangle_bytes() -> Vec<u8> {
    let corners = [[0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let mut bytes: Vec<u8> = corners.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    bytes.extend([0, 1, 2]);
    bytes
}

/// A file with that triangle as mesh 0 and these nodes, of which those listed are the scene's roots.
fn file(nodes: Value, roots: Value) -> Value {
    json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": roots}],
        "nodes": nodes,
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
             "min": [0, 0, 0], "max": [1, 1, 0]},
            {"bufferView": 1, "componentType": 5121, "count": 3, "type": "SCALAR"}
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": 36},
            {"buffer": 0, "byteOffset": 36, "byteLength": 3}
        ],
        "buffers": [{"byteLength": 39, "uri": data_uri(&triangle_bytes())}]
    })
}

fn data_uri(bytes: &[u8]) -> String {
    use base64::Engine as _;
    let text = base64::engine::general_purpose::STANDARD.encode(bytes);
    format!("data:application/octet-stream;base64,{text}")
}

fn read_json(file: &Value) -> Result<TriangleMesh, MeshError> {
    read(file.to_string().as_bytes(), &MeshOptions::default())
}

/// As a binary file, the buffer in its BIN chunk.
fn binary(mut file: Value) -> Vec<u8> {
    file["buffers"][0].as_object_mut().unwrap().remove("uri");
    let pad = |mut bytes: Vec<u8>, with: u8| {
        bytes.resize(bytes.len().next_multiple_of(4), with);
        bytes
    };
    let (json, bin) = (pad(file.to_string().into_bytes(), b' '), pad(triangle_bytes(), 0));
    let length = (12 + 8 + json.len() + 8 + bin.len()) as u32;
    let mut bytes = [b"glTF", &2u32.to_le_bytes()[..], &length.to_le_bytes()].concat();
    for (kind, chunk) in [(b"JSON", json), (b"BIN\0", bin)] {
        bytes.extend((chunk.len() as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(chunk);
    }
    bytes
}

fn one_node() -> Value {
    file(json!([{"mesh": 0}]), json!([0]))
}

#[test]
fn text_and_binary_files_are_read_alike() {
    let mesh = read_json(&one_node()).unwrap();
    assert_eq!(mesh.vertices, [DVec3::ZERO, DVec3::X, DVec3::Y]);
    assert_eq!(mesh.triangles, [[0, 1, 2]]);
    assert_eq!(read(&binary(one_node()), &MeshOptions::default()).unwrap(), mesh);
}

#[test]
fn a_byte_order_mark_is_passed_over() {
    let text = one_node().to_string();
    let marked = read(format!("\u{feff}{text}").as_bytes(), &MeshOptions::default());
    assert_eq!(marked.unwrap(), read_json(&one_node()).unwrap());
}

#[test]
fn every_instance_is_moved_by_all_nodes_above_it() {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let nodes = json!([
        {"translation": [1, 2, 3], "children": [1, 2]},
        {"mesh": 0, "scale": [2, 2, 2]},
        {"rotation": [0, 0, half, half], "children": [3]},
        {"mesh": 0, "matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 10,0,0,1]},
        {"mesh": 0}
    ]);
    // The last node is not in the scene.
    let mesh = read_json(&file(nodes, json!([0]))).unwrap();
    assert_eq!(mesh.triangles, [[0, 1, 2], [3, 4, 5]]);
    let expected = [[1, 2, 3], [3, 2, 3], [1, 4, 3], [1, 12, 3], [1, 13, 3], [0, 12, 3]];
    for (found, at) in mesh.vertices.iter().zip(expected) {
        let expected = DVec3::from_array(at.map(f64::from));
        assert!(found.distance(expected) < 1e-6, "{found} {expected}");
    }
}

#[test]
fn y_is_up_unless_coordinates_are_taken_as_they_are() {
    for (up_axis, third) in [(UpAxis::Ros, DVec3::Y), (UpAxis::File, DVec3::Z)] {
        let options = MeshOptions { up_axis, ..MeshOptions::default() };
        let mesh = read(one_node().to_string().as_bytes(), &options).unwrap();
        assert_eq!(mesh.vertices[2], third);
        assert_eq!(mesh.warnings, [MeshWarning::UpAxis { axis: "y", taken: up_axis }]);
    }
}

#[test]
fn a_mirrored_instance_keeps_its_front() {
    let mesh = read_json(&file(json!([{"mesh": 0, "scale": [1, 1, -1]}]), json!([0]))).unwrap();
    assert_eq!(mesh.triangles, [[0, 2, 1]]);
}

#[test]
fn strips_and_fans_become_triangles_and_lines_a_warning() {
    let mut file = one_node();
    let quad = [[0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let bytes: Vec<u8> = quad.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    file["buffers"][0] = json!({"byteLength": 48, "uri": data_uri(&bytes)});
    file["bufferViews"] = json!([{"buffer": 0, "byteLength": 48}]);
    file["accessors"] = json!([{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
        "min": [0, 0, 0], "max": [1, 1, 0]}]);
    let primitive = |mode: u32| json!({"attributes": {"POSITION": 0}, "mode": mode});
    file["meshes"][0]["primitives"] = json!([primitive(6), primitive(5), primitive(1)]);
    let mesh = read_json(&file).unwrap();
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [4, 5, 6], [6, 5, 7]]);
    assert!(mesh.warnings.contains(&MeshWarning::Lines { count: 1 }));
    // Four corners without indices are no triangles.
    file["meshes"][0]["primitives"] = json!([primitive(4)]);
    assert!(read_json(&file).unwrap_err().to_string().contains("4 corners"));
}

#[test]
fn what_could_hide_geometry_is_refused_with_its_place() {
    let changed = |path: &str, value: Value| {
        let mut file = one_node();
        *file.pointer_mut(path).unwrap() = value;
        file
    };
    let skinned = {
        let mut file = file(json!([{"mesh": 0, "skin": 0}]), json!([0]));
        file["skins"] = json!([{"joints": [0]}]);
        file
    };
    let morphed = changed(
        "/meshes/0/primitives/0",
        json!({"attributes": {"POSITION": 0}, "targets": [{"POSITION": 0}]}),
    );
    let mut required = one_node();
    required["extensionsUsed"] = json!(["KHR_draco_mesh_compression"]);
    required["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
    let mut copies = one_node();
    copies["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing"]);
    let mut sparse = one_node();
    sparse["accessors"][0]["sparse"] = json!({"count": 1,
        "indices": {"bufferView": 1, "componentType": 5121}, "values": {"bufferView": 0}});
    let elsewhere = changed("/buffers/0/uri", json!("other.bin"));
    let mut undecided = one_node();
    undecided.as_object_mut().unwrap().remove("scene");
    undecided["scenes"] = json!([{"nodes": [0]}, {"nodes": []}]);
    for (file, says) in [
        (skinned, "nodes[0]"),
        (morphed, "meshes[0].primitives[0]"),
        (required, "extensionsRequired"),
        (copies, "extensionsUsed"),
        (sparse, "accessors[0]"),
        (elsewhere, "buffers[0]"),
        (undecided, "scene"),
    ] {
        let error = read_json(&file).unwrap_err().to_string();
        assert!(error.starts_with("glTF") && error.contains(says), "{says}: {error}");
    }
}

#[test]
fn copies_of_a_node_are_refused_though_no_extension_is_declared() {
    let copies = json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 0}}});
    let looks = json!({"KHR_node_visibility": {"visible": true}});
    let nodes = |extensions| json!([{"mesh": 0}, {"mesh": 0, "extensions": extensions}]);
    assert_eq!(read_json(&file(nodes(looks), json!([0, 1]))).unwrap().triangles.len(), 2);
    let copied = file(nodes(copies), json!([0, 1]));
    for bytes in [copied.to_string().into_bytes(), binary(copied)] {
        let error = read(&bytes, &MeshOptions::default()).unwrap_err().to_string();
        assert!(error.starts_with("glTF, nodes[1]: "), "{error}");
    }
}

#[test]
fn another_version_and_two_transforms_of_a_node_are_refused() {
    let with = |pointer: &str, value: Value| {
        let mut file =
            file(json!([{"mesh": 0, "matrix": DMat4::IDENTITY.to_cols_array()}]), json!([0]));
        let (above, key) = pointer.rsplit_once('/').unwrap();
        file.pointer_mut(above).unwrap()[key] = value;
        read_json(&file).map_err(|error| error.to_string())
    };
    assert!(with("/asset/generator", json!("x")).is_ok());
    assert!(
        with("/asset/minVersion", json!("2.0")).is_ok()
            && with("/asset/version", json!("2.1")).is_ok()
    );
    for (pointer, value, place) in [
        ("/asset/version", json!("3.0"), "asset: version \"3.0\""),
        ("/asset/version", json!("1.0"), "asset"),
        ("/asset/minVersion", json!("2.1"), "asset: version \"2.0\", for readers of \"2.1\""),
        ("/nodes/0/translation", json!([5, 0, 0]), "nodes[0]"),
        ("/nodes/0/rotation", json!([1, 0, 0, 0]), "nodes[0]"),
        ("/nodes/0/scale", json!([2, 2, 2]), "nodes[0]"),
    ] {
        let error = with(pointer, value).unwrap_err();
        assert!(error.starts_with(&format!("glTF, {place}: ")), "{pointer}: {error}");
    }
}

#[test]
fn an_extension_that_is_no_look_is_named() {
    let mut file = file(json!([{"mesh": 0}]), json!([0]));
    let named = |file: &Value| {
        let warnings = read_json(file).unwrap().warnings.into_iter();
        warnings
            .filter(|warning| !matches!(warning, MeshWarning::UpAxis { .. }))
            .collect::<Vec<_>>()
    };
    file["extensionsUsed"] = json!(["KHR_materials_unlit", "KHR_texture_transform"]);
    assert_eq!(named(&file), []);
    file["extensionsUsed"] = json!(["KHR_materials_unlit", "MSFT_lod"]);
    assert_eq!(named(&file), [MeshWarning::Extensions { names: vec!["MSFT_lod".to_owned()] }]);
}

#[test]
fn animations_are_named_and_not_played() {
    let mut file = file(json!([{"mesh": 0, "translation": [1, 2, 3]}]), json!([0]));
    let still = read_json(&file).unwrap();
    file["animations"] = json!([{
        "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
        "samplers": [{"input": 1, "output": 0}]
    }]);
    let mesh = read_json(&file).unwrap();
    assert!(mesh.warnings.contains(&MeshWarning::Animations { count: 1 }));
    assert_eq!(mesh.vertices, still.vertices);
}

#[test]
fn counts_and_offsets_beyond_the_buffer_are_refused_before_anything_is_allocated() {
    let huge = json!(u64::MAX);
    for (path, value) in [
        ("/accessors/0/count", json!(4)),
        ("/accessors/0/count", json!(99_999_999_999u64)),
        ("/accessors/0/count", huge.clone()),
        ("/bufferViews/0/byteLength", huge.clone()),
        ("/bufferViews/1/byteOffset", huge.clone()),
        ("/bufferViews/1/byteOffset", json!(37)),
        ("/buffers/0/byteLength", json!(40)),
        ("/accessors/1/componentType", json!(5125)),
        ("/accessors/1/componentType", json!(5126)),
        ("/accessors/0/type", json!("VEC2")),
        ("/nodes/0/mesh", json!(1)),
        ("/meshes/0/primitives/0/attributes/POSITION", json!(2)),
        ("/meshes/0/primitives/0/indices", json!(2)),
        ("/scene", json!(1)),
    ] {
        let mut file = one_node();
        let place = file.pointer_mut(path);
        *place.unwrap() = value.clone();
        assert!(read_json(&file).is_err(), "{path} {value}");
    }
    for (key, value) in [("byteStride", json!(8)), ("byteStride", json!(252))] {
        let mut file = one_node();
        file["bufferViews"][0][key] = value;
        assert!(read_json(&file).is_err());
    }
}

#[test]
fn an_index_of_no_point_is_refused() {
    let mut bytes = triangle_bytes();
    bytes[37] = 3;
    let mut file = one_node();
    file["buffers"][0]["uri"] = json!(data_uri(&bytes));
    let error = read_json(&file).unwrap_err().to_string();
    assert!(error.contains("point 3, but there are 3"), "{error}");
}

#[test]
fn a_node_in_itself_ends_in_an_error() {
    let nodes = json!([{"children": [1]}, {"children": [0], "mesh": 0}]);
    let error = read_json(&file(nodes, json!([0]))).unwrap_err().to_string();
    assert!(error.contains("nested"), "{error}");
    let twice = (0..40).map(|k| json!({"children": [k + 1, k + 1]}));
    let nodes: Vec<_> = twice.chain([json!({"mesh": 0})]).collect();
    let error = read_json(&file(json!(nodes), json!([0]))).unwrap_err().to_string();
    assert!(error.contains("more than"), "{error}");
}

#[test]
fn a_binary_file_that_is_cut_anywhere_is_refused() {
    let bytes = binary(one_node());
    for end in 0..bytes.len() {
        assert!(read(&bytes[..end], &MeshOptions::default()).is_err(), "{end}");
    }
    for length in [0u32, 11, 12, 19, u32::MAX] {
        let mut changed = bytes.clone();
        changed[8..12].copy_from_slice(&length.to_le_bytes());
        assert!(read(&changed, &MeshOptions::default()).is_err(), "{length}");
    }
}

#[test]
fn what_is_behind_the_length_that_a_binary_file_states_is_refused_unless_it_is_zeros() {
    let bytes = binary(one_node());
    let with = |behind: &[u8]| read(&[&bytes[..], behind].concat(), &MeshOptions::default());
    assert_eq!(with(&[0; 7]).unwrap(), with(&[]).unwrap());
    for behind in [&bytes[..], &[0, 0, 1]] {
        let error = with(behind).unwrap_err().to_string();
        assert!(error.starts_with("glTF, byte 8: the header states"), "{error}");
    }
}

#[test]
fn a_buffer_in_a_file_beside_is_read() {
    let folder = std::env::temp_dir().join(format!("dcd-gltf-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("a b.bin"), triangle_bytes()).unwrap();
    let options = MeshOptions { folder: Some(folder.clone()), ..MeshOptions::default() };
    let read_with = |uri: &str| {
        let mut file = one_node();
        file["buffers"][0]["uri"] = json!(uri);
        read(file.to_string().as_bytes(), &options)
    };
    let found = [read_with("a%20b.bin"), read_with("a b.bin")];
    let absolute = folder.join("a b.bin");
    let absolute = absolute.to_str().unwrap();
    let encoded = absolute.replace('/', "%2F");
    let refused = [read_with("gone.bin"), read_with(absolute), read_with(&encoded)];
    std::fs::remove_dir_all(&folder).unwrap();
    for mesh in found {
        assert_eq!(mesh.unwrap().triangles.len(), 1);
    }
    for error in refused {
        assert!(error.unwrap_err().to_string().contains("no file relative to"));
    }
}
