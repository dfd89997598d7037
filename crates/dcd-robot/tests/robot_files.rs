//! Robots as their users have them: unedited URDF files of the data folder and the meshes that they
//! name. Without the folder these tests say that they skip.
#![allow(missing_docs)]

use dcd_io::{MeshPaths, RawMesh, TriangleMesh, UpAxis, data};
use dcd_robot::{LinkShapes, MeshSource, Robot};
use glam::DVec3;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

const PR2: &str = "robots/example-robot-data/robots/pr2_description/urdf/pr2.urdf";
const BAXTER: &str = "robots/example-robot-data/robots/baxter_description/urdf/baxter.urdf";
const UR10: &str = "robots/ur_description/urdf/ur10.urdf";

/// A file, or the news that the test skips.
fn file(path: &str) -> Option<PathBuf> {
    let found = data::file(path);
    if found.is_none() {
        println!("skipped: {path} is not there");
    }
    found
}

/// How many collision elements the links have, by the tags in the text alone.
fn collisions(urdf: &Path) -> usize {
    let text = std::fs::read_to_string(urdf).unwrap();
    let mut count = 0;
    let mut rest = text.as_str();
    while let Some(at) = rest.find('<') {
        rest = &rest[at..];
        let end = if rest.starts_with("<!--") { "-->" } else { ">" };
        let tag = &rest[..rest.find(end).unwrap()];
        let name = tag[1..].split(|c: char| c.is_whitespace() || c == '/').next();
        count += usize::from(name == Some("collision"));
        rest = &rest[tag.len() + end.len()..];
    }
    count
}

/// The robot as hulls and as meshes has a shape for each collision element.
fn loads_whole(path: &str, expected: usize) {
    let Some(urdf) = file(path) else { return };
    assert_eq!(collisions(&urdf), expected);
    for shapes in [LinkShapes::Hulls, LinkShapes::Meshes] {
        let robot = Robot::load_as(&urdf, shapes).unwrap();
        assert_eq!(robot.parts().len(), expected, "{shapes:?}");
        // Of mesh files there is nothing to say.
        let notes = robot.notes();
        assert!(notes.iter().all(|note| note.starts_with("not used: ")), "{notes:?}");
    }
}

#[test]
fn the_ur10_loads_with_every_collision_element() {
    loads_whole(UR10, 7);
}

#[test]
fn the_pr2_loads_with_every_collision_element() {
    let Some(urdf) = file(PR2) else { return };
    loads_whole(PR2, collisions(&urdf));
}

#[test]
fn the_baxter_loads_with_every_collision_element() {
    let Some(urdf) = file(BAXTER) else { return };
    loads_whole(BAXTER, collisions(&urdf));
}

/// The count of triangles is taken from the files without a reader: from the length of each binary
/// STL file, two of whose headers begin with "solid", and from the counts of each COLLADA polygon.
#[test]
fn every_triangle_of_every_mesh_file_is_read() {
    let Some(folder) = data::folder().map(|data| data.join("robots")) else {
        println!("skipped: there is no data folder");
        return;
    };
    let (mut ahead, mut files) = (vec![folder], 0);
    while let Some(folder) = ahead.pop() {
        for entry in std::fs::read_dir(&folder).into_iter().flatten().flatten() {
            let path = entry.path();
            let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
            match ending.as_deref() {
                _ if path.is_dir() => ahead.push(path),
                Some("stl") => {
                    let length = std::fs::metadata(&path).unwrap().len() as usize;
                    let mesh = TriangleMesh::load(&path, UpAxis::Ros).unwrap();
                    assert_eq!(mesh.triangles.len(), (length - 84) / 50, "{}", path.display());
                    files += 1;
                }
                Some("dae") => {
                    let mesh = TriangleMesh::load(&path, UpAxis::Ros).unwrap();
                    assert_eq!(
                        mesh.triangles.len(),
                        collada_triangles(&path),
                        "{}",
                        path.display()
                    );
                    files += 1;
                }
                _ => {}
            }
        }
    }
    if files == 0 {
        println!("skipped: there are no robots in the data folder");
    }
}

/// The triangles of a file with one instance of one geometry.
fn collada_triangles(path: &Path) -> usize {
    let text = std::fs::read_to_string(path).unwrap();
    assert_eq!(text.matches("<instance_geometry").count(), 1);
    let between = |text: &'static str, end: &'static str, from: &str| {
        let start = from.find(text)? + text.len();
        Some(from[start..start + from[start..].find(end)?].to_owned())
    };
    if let Some(sizes) = between("<vcount>", "</vcount>", &text) {
        return sizes.split_whitespace().map(|size| size.parse::<usize>().unwrap() - 2).sum();
    }
    let triangles = &text[text.find("<triangles").unwrap()..];
    between("count=\"", "\"", triangles).unwrap().parse().unwrap()
}

/// Against the smallest and largest of the numbers in the text: the file is in metres with z up, and
/// its one node does not move.
#[test]
fn the_baxters_pedestal_has_the_extent_of_its_numbers() {
    let path = "robots/example-robot-data/robots/baxter_description/meshes/base/\
                pedestal_link_collision.DAE";
    let Some(path) = file(path) else { return };
    let text = std::fs::read_to_string(&path).unwrap();
    let array = &text[text.find("<float_array").unwrap()..text.find("</float_array>").unwrap()];
    let numbers = array[array.find('>').unwrap() + 1..].split_whitespace();
    let numbers: Vec<f64> = numbers.map(|number| number.parse().unwrap()).collect();
    let along = |axis: usize| numbers.iter().copied().skip(axis).step_by(3);
    let low = DVec3::from_array([0, 1, 2].map(|axis| along(axis).fold(f64::INFINITY, f64::min)));
    let high =
        DVec3::from_array([0, 1, 2].map(|axis| along(axis).fold(f64::NEG_INFINITY, f64::max)));
    for up_axis in [UpAxis::Ros, UpAxis::File] {
        let mesh = RawMesh::from(TriangleMesh::load(&path, up_axis).unwrap());
        assert_eq!(mesh.extent(), (low, high));
    }
}

#[test]
fn a_package_that_is_said_to_be_elsewhere_is_not_looked_for_beside() {
    let Some(urdf) = file(UR10) else { return };
    let paths = MeshPaths::new(urdf.parent().unwrap());
    let with = |folder: &Path| MeshSource {
        paths: paths.clone().with_package("ur_description", folder),
        up_axis: UpAxis::Ros,
        shapes: LinkShapes::Hulls,
        of_links: BTreeMap::new(),
    };
    let package = urdf.ancestors().nth(2).unwrap();
    assert!(Robot::load_with(&urdf, &with(package)).is_ok());
    let error = Robot::load_with(&urdf, &with(Path::new("/no/such"))).unwrap_err().to_string();
    assert!(error.contains("/no/such/meshes/ur10/collision/"), "{error}");
    assert!(error.starts_with(urdf.to_str().unwrap()) && error.contains("link \""), "{error}");
}

#[test]
fn outer_hulls_have_few_vertices_and_hold_every_vertex_of_the_mesh_hulls() {
    let Some(urdf) = file(PR2) else { return };
    const VERTICES: usize = 24;
    let folder = urdf.parent().unwrap();
    let whole = LinkShapes::Hulls;
    let source = |shapes, of_links| MeshSource {
        paths: MeshPaths::new(folder),
        up_axis: UpAxis::Ros,
        shapes,
        of_links,
    };
    let exact = Robot::load_with(&urdf, &source(whole, BTreeMap::new())).unwrap();
    let spared = "base_link";
    let of_links = BTreeMap::from([(spared.to_owned(), whole)]);
    let few = LinkShapes::OuterHulls { vertices: VERTICES };
    let robot = Robot::load_with(&urdf, &source(few, of_links)).unwrap();
    let mut larger = 0;
    for (few, exact) in robot.parts().iter().zip(exact.parts()) {
        let (Some(outer), Some(hull)) = (few.shape.as_polytope(), exact.shape.as_polytope()) else {
            continue;
        };
        if robot.links()[few.link].name == spared {
            assert_eq!((outer.vertices(), few.tolerance), (hull.vertices(), 0.0));
            continue;
        }
        assert!(outer.vertices().len() <= VERTICES.max(8));
        // Along no direction does the mesh stand out of it, nor it out of the mesh by more than the tolerance.
        let end = |points: &[DVec3], along: DVec3| {
            points.iter().map(|p| p.dot(along)).fold(f64::NEG_INFINITY, f64::max)
        };
        for along in directions() {
            let [outer, hull] = [outer, hull].map(|shape| end(shape.vertices(), along));
            let rounding = 1e-12;
            assert!(hull <= outer + rounding && outer <= hull + few.tolerance + rounding);
        }
        larger += usize::from(few.tolerance > 0.0);
    }
    assert!(larger > 10, "{larger}");
    let note = robot.notes().iter().find(|note| note.contains("24 vertices")).unwrap();
    assert!(note.contains("m larger"), "{note}");
}

/// Some hundred unit vectors all round.
fn directions() -> impl Iterator<Item = DVec3> {
    let turns = (0..16).map(|k| f64::from(k) / 8.0 * std::f64::consts::PI);
    turns.flat_map(|a| {
        (0..9).map(move |k| {
            let z = f64::from(k) / 4.0 - 1.0;
            let r = (1.0 - z * z).sqrt();
            DVec3::new(r * a.cos(), r * a.sin(), z)
        })
    })
}

#[test]
fn a_link_that_is_not_there_and_too_few_vertices_are_refused() {
    let Some(urdf) = file(UR10) else { return };
    let paths = MeshPaths::new(urdf.parent().unwrap());
    let refused = |shapes, link: Option<&str>| {
        let of_links = link.map(|link| (link.to_owned(), shapes)).into_iter().collect();
        let (paths, up_axis) = (paths.clone(), UpAxis::Ros);
        let source = MeshSource { paths, up_axis, shapes, of_links };
        Robot::load_with(&urdf, &source).unwrap_err().to_string()
    };
    let unknown = refused(LinkShapes::Meshes, Some("no_such_link"));
    assert!(unknown.contains("there is no link \"no_such_link\""), "{unknown}");
    let few = refused(LinkShapes::OuterHulls { vertices: 7 }, None);
    assert!(few.contains("link \"base_link_inertia\"") && few.contains("7 vertices"), "{few}");
}
