//! The readers of mesh files.

use dcd_geom::Shape;
use dcd_io::{MeshFormat, MeshOptions, TriangleMesh, UpAxis};

/// A file of STL, text or binary.
pub fn stl(bytes: &[u8]) {
    read(bytes, MeshFormat::Stl);
}

/// A file of COLLADA.
pub fn collada(bytes: &[u8]) {
    read(bytes, MeshFormat::Collada);
}

/// A file of glTF, text or binary, whose buffers are in itself.
pub fn gltf(bytes: &[u8]) {
    read(bytes, MeshFormat::Gltf);
}

/// What is read is a shape, and the up axis turns it as a whole; each error has words.
fn read(bytes: &[u8], format: MeshFormat) {
    let [ros, file] = [UpAxis::Ros, UpAxis::File]
        .map(|up_axis| MeshOptions { up_axis, ..MeshOptions::default() })
        .map(|options| TriangleMesh::read(bytes, format, &options));
    let (ros, file) = match (ros, file) {
        (Ok(ros), Ok(file)) => (ros, file),
        (Err(error), Err(_)) => return assert!(!error.to_string().is_empty()),
        (Ok(_), Err(error)) | (Err(error), Ok(_)) => panic!("one up axis alone: {error}"),
    };
    // Of a transform that is all but singular rounding may decide whether it mirrors.
    let sorted = |mesh: &TriangleMesh| -> Vec<[u32; 3]> {
        let sorted = mesh.triangles.iter().map(|&corners| {
            let mut corners = corners;
            corners.sort_unstable();
            corners
        });
        sorted.collect()
    };
    assert_eq!(sorted(&ros), sorted(&file));
    assert_eq!(ros.vertices.len(), file.vertices.len());
    let corners = ros.triangles.iter().flatten();
    assert!(corners.clone().all(|&corner| (corner as usize) < ros.vertices.len()));
    assert!(ros.vertices.iter().all(|vertex| vertex.is_finite()));
    // Large meshes take their time as shapes.
    if ros.triangles.len() < 1000 {
        assert!(Shape::mesh(ros.vertices, ros.triangles).is_ok());
    }
}
