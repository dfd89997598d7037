//! Writes a few inputs for each target to start from: `seeds FOLDER`.

use dcd_io::{Capture, RawObject, RawScene, RawShape, write_hull_scene};
use glam::{DQuat, DVec3};
use std::io;
use std::path::PathBuf;

fn main() -> io::Result<()> {
    let Some(folder) = std::env::args_os().nth(1).map(PathBuf::from) else {
        return Err(io::Error::other("usage: seeds FOLDER"));
    };
    let targets = [
        ("overlap", pairs()),
        ("measures", pairs()),
        ("scene", [scenes(), compounds(), meshes()].concat()),
        ("frames", courses()),
        ("probe", batches()),
        ("readers", files()?),
        ("hull", clouds()),
        ("far", moved()),
        ("urdf", [chosen(0, ROBOTS), numbers(1)].concat()),
        ("srdf", [plain(PAIRS), numbers(2)].concat()),
        ("scenes", [chosen(0, WORLDS), numbers(1)].concat()),
        ("requests", [chosen(0, REQUESTS), numbers(1)].concat()),
        ("archives", [vec![vec![0], vec![1]], numbers(2)].concat()),
        ("obj", plain(MESHES)),
        ("stl", stl()),
        ("collada", collada()),
        ("gltf", gltf()),
    ];
    for (target, seeds) in targets {
        let folder = folder.join(target);
        std::fs::create_dir_all(&folder)?;
        for (k, seed) in seeds.iter().enumerate() {
            std::fs::write(folder.join(format!("seed-{k}")), seed)?;
        }
    }
    Ok(())
}

/// Eighths, as the numbers' first tags have them.
const HALF: u8 = 4;
const ONE: u8 = 8;

/// First bytes of shapes that are no polytopes, and the bit that rounds them.
const CYLINDER: u8 = 226;
const COMPOUND: u8 = 227;
const MESH: u8 = 235;
const ROUNDED: u8 = 16;

/// A cube of edge 1; the same, rounded by an eighth; a sphere of radius ½; a tetrahedron.
fn shapes() -> [Vec<u8>; 4] {
    let corners = [[0, 0, 0], [ONE, 0, 0], [0, ONE, 0], [0, 0, ONE]].concat();
    [
        vec![0, HALF, HALF, HALF],
        vec![16, HALF, HALF, HALF, 1],
        vec![1, HALF],
        [vec![2, 4], corners].concat(),
    ]
}

/// At the origin, touching at (1, 0, 0), a float past that, turned by quarters, turned by any.
fn poses() -> [Vec<u8>; 5] {
    [
        vec![0, 0, 0, 0],
        vec![0, ONE, 0, 0],
        vec![0, 81, ONE, 0, 0],
        vec![1 | 1 << 2 | 1 << 4, ONE, HALF, 0],
        vec![2, 1, 2, 3, 4, ONE, HALF, 1],
    ]
}

fn pairs() -> Vec<Vec<u8>> {
    let mut pairs = Vec::new();
    for a in &shapes() {
        for b in &shapes() {
            for pose in &poses() {
                pairs.push([&a[..], &poses()[0], b, pose, &[0]].concat());
                pairs.push([&a[..], &poses()[4], b, pose, &[1]].concat());
            }
        }
    }
    pairs
}

fn scenes() -> Vec<Vec<u8>> {
    let head = |objects: u8| [vec![3], shapes().concat(), vec![objects]].concat();
    let object = |k: u8| [vec![128 + k % 4], poses()[usize::from(k) % 5].clone()].concat();
    let row = |k: u8| vec![128, 0, k.wrapping_mul(ONE) & 63, 0, 0];
    let scene = |objects: u8, object: &dyn Fn(u8) -> Vec<u8>| {
        (0..objects).fold(head(objects), |scene, k| [scene, object(k)].concat())
    };
    vec![scene(2, &object), scene(19, &object), scene(8, &row), scene(19, &row)]
}

/// One compound beside another, touching by their outermost parts; a long one among single shapes;
/// parts that are round or no polytope, the whole rounded.
fn compounds() -> Vec<Vec<u8>> {
    let [cube, rounded, sphere, tetrahedron] = shapes();
    let along = |x: u8| vec![0, x, 0, 0];
    let compound = |parts: &[(&Vec<u8>, u8)]| {
        let placed = parts.iter().map(|(shape, x)| [&shape[..], &along(*x)].concat());
        [vec![COMPOUND, parts.len() as u8], placed.collect::<Vec<_>>().concat()].concat()
    };
    let object = |shape: u8, x: u8| [vec![128 + shape], along(x)].concat();
    let scene = |shapes: &[&Vec<u8>], objects: &[Vec<u8>]| {
        let shapes: Vec<u8> = shapes.iter().flat_map(|shape| shape.iter().copied()).collect();
        [vec![3], shapes, vec![objects.len() as u8], objects.concat()].concat()
    };
    let short = compound(&[(&cube, 0), (&sphere, ONE), (&tetrahedron, 2 * ONE)]);
    let row: Vec<_> = (0..19).map(|k| (&cube, k * 3)).collect();
    let long = compound(&row);
    let cylinder = vec![CYLINDER, HALF, HALF];
    let mut mixed = compound(&[(&cylinder, 0), (&rounded, ONE)]);
    mixed[0] |= ROUNDED;
    mixed.push(1);
    let scattered: Vec<_> = (0..16).map(|k| object(k % 4, k.wrapping_mul(5) & 63)).collect();
    vec![
        scene(&[&short, &short, &cube, &sphere], &[object(0, 0), object(1, 3 * ONE)]),
        scene(&[&long, &short, &cube, &sphere], &scattered),
        scene(&[&long, &long, &mixed, &cylinder], &scattered),
        scene(&[&short, &mixed, &cube, &rounded], &scattered),
    ]
}

/// The surface of a tetrahedron; a strip of as many triangles as there may be, rounded or not.
fn surfaces() -> [Vec<u8>; 3] {
    let corners = [[0, 0, 0], [ONE, 0, 0], [0, ONE, 0], [0, 0, ONE]].concat();
    let closed = [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]].concat();
    let zigzag: Vec<u8> = (0..16).flat_map(|k| [k * 3, k % 2 * ONE, 0]).collect();
    let strip: Vec<u8> = (0..14).flat_map(|k| [k, k + 1, k + 2]).collect();
    let strip = [vec![16], zigzag, vec![14], strip].concat();
    [
        [vec![MESH, 4], corners, vec![4], closed].concat(),
        [vec![MESH], strip.clone()].concat(),
        [vec![MESH | ROUNDED], strip, vec![1]].concat(),
    ]
}

/// Surfaces among each other and among shapes of other kinds.
fn meshes() -> Vec<Vec<u8>> {
    let [closed, strip, rounded] = surfaces();
    let [cube, ..] = shapes();
    let objects: Vec<u8> = (0..16u8)
        .flat_map(|k| [vec![128 + k % 4], poses()[usize::from(k) % 5].clone()].concat())
        .collect();
    let scene = |shapes: [&Vec<u8>; 4]| {
        let shapes: Vec<u8> = shapes.iter().flat_map(|shape| shape.iter().copied()).collect();
        [vec![3], shapes, vec![16], objects.clone()].concat()
    };
    vec![scene([&closed, &strip, &rounded, &cube]), scene([&strip, &strip, &closed, &rounded])]
}

/// A few links among every scene, once and again.
fn batches() -> Vec<Vec<u8>> {
    let [cube, rounded, sphere, tetrahedron] = shapes();
    let [closed, ..] = surfaces();
    let links = [vec![2], cube, sphere, tetrahedron].concat();
    let others = [vec![1], closed, rounded].concat();
    let poses = |count: usize| poses().into_iter().cycle().take(count).flatten();
    let batches = |links: usize| {
        let batch = |count: u8| [count].into_iter().chain(poses(usize::from(count) * links));
        [1].into_iter().chain(batch(17)).chain(batch(3)).collect::<Vec<u8>>()
    };
    let scenes = [scenes(), compounds(), meshes()].concat();
    let worlds = scenes.into_iter().flat_map(|scene| {
        [[&links[..], &scene, &batches(3)].concat(), [&others[..], &scene, &batches(2)].concat()]
    });
    worlds.collect()
}

/// One or two shapes of each kind, moved by none, by eighths, and by up to 2⁴⁰ of them; nine objects
/// near each other, and a margin.
fn moved() -> Vec<Vec<u8>> {
    let [cube, rounded, sphere, tetrahedron] = shapes();
    let [closed, _, strip] = surfaces();
    let cylinder = vec![CYLINDER, HALF, HALF];
    let compound = [vec![COMPOUND, 1], rounded.clone(), poses()[0].clone()].concat();
    let segment = vec![3 | ROUNDED, 0, 0, 0, ONE, 0, 0, HALF];
    let kinds = [cube, rounded, sphere, tetrahedron, closed, strip, cylinder, compound, segment];
    let objects: Vec<u8> =
        (0..9u8).flat_map(|k| [vec![k], poses()[usize::from(k) % 5].clone()].concat()).collect();
    let by = |power: u8| vec![ONE, 3, ONE + 5, power];
    let of = |a: &Vec<u8>, b: &Vec<u8>, power: u8| {
        [&[1][..], a, &by(power), b, &by(power / 2), &[9], &objects, &[HALF]].concat()
    };
    let pairs = kinds.iter().flat_map(|a| kinds.iter().map(move |b| (a, b)));
    pairs.flat_map(|(a, b)| [0, 20, 40].map(|power| of(a, b, power))).collect()
}

/// Bytes that repeat in periods of many lengths, so that every kind of change comes up among steps in
/// which little moves; each first scene of another size and form.
fn courses() -> Vec<Vec<u8>> {
    let course = |k: u8| {
        let step = |n: u32| (n.wrapping_mul(2_654_435_761) >> 13) as u8 ^ k.wrapping_mul(37);
        [vec![k % 6, k / 6], (0..900).map(step).collect()].concat()
    };
    (0..24).map(course).collect()
}

fn clouds() -> Vec<Vec<u8>> {
    let cube = (0..8u8).flat_map(|k| [k & 1, k >> 1 & 1, k >> 2 & 1].map(|bit| bit * ONE));
    let round = (0..60u8).flat_map(|k| [k, k.wrapping_mul(7), k.wrapping_mul(29)]);
    vec![cube.collect(), round.collect()]
}

fn files() -> io::Result<Vec<Vec<u8>>> {
    let points = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    let triangles = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    let scene = RawScene {
        shapes: vec![RawShape::Hull { points, triangles }],
        objects: vec![RawObject { shape: 0, rotation: DQuat::IDENTITY, translation: DVec3::ONE }],
    };
    let mut hulls = vec![3];
    write_hull_scene(&scene, &mut hulls)?;
    let mut capture = vec![5];
    let moving = scene.into_scene().map_err(io::Error::other)?;
    let mut recorded = Capture::new(&moving).map_err(io::Error::other)?;
    recorded.frame(&moving).map_err(io::Error::other)?;
    recorded.write(&mut capture)?;
    let frame = ply();
    Ok(vec![
        capture,
        b"\x000 0 0 1 1 1\n0.5 0 -1e3 2 3.25 1\n".to_vec(),
        [&[1, 2, 0, 0, 0][..], &1f32.to_le_bytes().repeat(6)].concat(),
        [&[2][..], &frame].concat(),
        [&[2][..], &frame, &frame].concat(),
        hulls,
        b"\x04[[0, 1], [2, 5]]".to_vec(),
        b"\x06{\"name\":\"x\",\"a\":[[0,0,0],[1,0,0]],\"pose_a\":{\"q\":[0,0,0,1],\"t\":[0,0,0]},\
          \"b\":[[0,0,1]],\"pose_b\":{\"R\":[[1,0,0],[0,1,0],[0,0,1]],\"t\":[0,1,NaN]}}\n"
            .to_vec(),
    ])
}

/// One triangle.
fn ply() -> Vec<u8> {
    let header = "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\n\
                  property float y\nproperty float z\nelement face 1\n\
                  property list uchar int vertex_indices\nend_header\n";
    let corners = [0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let mut file = header.as_bytes().to_vec();
    file.extend(corners.iter().flat_map(|x| x.to_le_bytes()));
    file.push(3);
    file.extend([0i32, 1, 2].iter().flat_map(|k| k.to_le_bytes()));
    file
}

const ROBOTS: &[&str] = &[
    "<robot name=\"arm\"><link name=\"a\"><collision><geometry><box size=\"1 1 1\"/></geometry>\
     </collision></link><link name=\"b\"><collision><origin xyz=\"1 0 0\" rpy=\"0 0 1\"/><geometry>\
     <sphere radius=\"0.5\"/></geometry></collision><collision><geometry><cylinder radius=\"1\" \
     length=\"2\"/></geometry></collision></link><joint name=\"j\" type=\"revolute\"><axis \
     xyz=\"0 0 1\"/><limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/><parent link=\"a\"/>\
     <child link=\"b\"/></joint></robot>",
    "<?xml version=\"1.0\"?><!-- <collision> --><robot name=\"r\"><link name=\"a\"><visual><geometry>\
     <sphere radius=\"1\"/></geometry></visual><inertial><mass value=\"1\"/></inertial></link>\
     <joint name=\"j\" type=\"fixed\"><parent link=\"a\"/><child link=\"b\"/><mimic joint=\"k\"/>\
     </joint><link name=\"b\"/></robot>",
];

const PAIRS: &[&str] =
    &["<robot name=\"r\"><disable_collisions link1=\"a\" link2=\"b\" reason=\"Adjacent\"/>\
     <virtual_joint name=\"v\" type=\"fixed\" parent_frame=\"world\" child_link=\"a\"/></robot>"];

const WORLDS: &[&str] = &[
    "name: s\nworld:\n  collision_objects:\n    - id: can\n      header: {frame_id: world}\n      \
     pose: {position: [0, 0, 1], orientation: [0, 0, 0, 1]}\n      primitives:\n        - type: \
     cylinder\n          dimensions: [0.2, 0.1]\n      primitive_poses:\n        - position: [1, 0, 0]\n\
     \x20         orientation: [0, 0, 0, 1]\n",
    "allowed_collision_matrix: {entry_names: [a, b], entry_values: [[false, true], [true, false]]}\n\
     robot_state: {joint_state: {name: [j], position: [0.5]}}\nworld: {collision_objects: []}\n",
];

const REQUESTS: &[&str] =
    &["start_state: {joint_state: {name: [a, b], position: [1, -0.5]}}\ngoal_constraints:\n  - \
     joint_constraints:\n      - joint_name: b\n        position: 2\n"];

const MESHES: &[&str] = &[
    "o a\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0.1\nvt 0 0\nvn 0 0 1\nf 1/1/1 2//1 3 4\n",
    "\u{feff}v 0 0 0 1\nv 1e-3 -0 5\nv 1 1 1\nf -3 -2 -1\no b\nv 5 5 5\nf 4 4 4\nl 1 2\n",
];

/// Texts behind the byte that chooses them.
fn chosen(which: u8, texts: &[&str]) -> Vec<Vec<u8>> {
    texts.iter().map(|text| [&[which], text.as_bytes()].concat()).collect()
}

fn plain(texts: &[&str]) -> Vec<Vec<u8>> {
    texts.iter().map(|text| text.as_bytes().to_vec()).collect()
}

/// What is built from numbers, behind the byte that chooses it.
fn numbers(which: u8) -> Vec<Vec<u8>> {
    let counting = |step: u8| (0..200u8).map(move |k| k.wrapping_mul(step) % 61);
    [1, 3, 7].map(|step| [which].into_iter().chain(counting(step)).collect()).to_vec()
}

/// A square in both kinds, the binary one with a header that begins as text does.
fn stl() -> Vec<Vec<u8>> {
    let facet = |corner: &str| {
        format!(
            "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 1 0\nvertex {corner}\n\
             endloop\nendfacet\n"
        )
    };
    let text = ["solid a\n", &facet("0 1 0"), &facet("1e0 0 -0"), "endsolid a\n"].concat();
    let mut binary = b"solid".to_vec();
    binary.resize(80, 0);
    binary.extend(2u32.to_le_bytes());
    for last in [[0f32, 1.0, 0.0], [1.0, 0.0, 0.0]] {
        let numbers = [[0.0; 3], [0.0; 3], [1.0, 1.0, 0.0], last];
        binary.extend(numbers.iter().flatten().flat_map(|x: &f32| x.to_le_bytes()));
        binary.extend([0; 2]);
    }
    vec![text.into_bytes(), binary]
}

/// One instance in a moved node for each kind of primitive and transform.
fn collada() -> Vec<Vec<u8>> {
    let input = "<input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/>";
    let file = |primitives: &str, transform: &str| {
        format!(
            "<COLLADA><asset><unit meter=\"0.0254\"/><up_axis>Y_UP</up_axis></asset>\
             <library_geometries><geometry id=\"g\"><mesh><source id=\"s\">\
             <float_array id=\"f\" count=\"12\">0 0 0 1 0 0 1 1 0 0 1 .5</float_array>\
             <technique_common><accessor source=\"#f\" count=\"4\" stride=\"3\">\
             <param name=\"X\"/><param name=\"Y\"/><param name=\"Z\"/></accessor>\
             </technique_common></source><vertices id=\"v\">\
             <input semantic=\"POSITION\" source=\"#s\"/></vertices>{primitives}</mesh></geometry>\
             </library_geometries><library_nodes><node id=\"n\">{transform}\
             <instance_geometry url=\"#g\"/></node></library_nodes><library_visual_scenes>\
             <visual_scene id=\"w\"><node><instance_node url=\"#n\"/></node></visual_scene>\
             </library_visual_scenes><scene><instance_visual_scene url=\"#w\"/></scene></COLLADA>"
        )
        .into_bytes()
    };
    let strip = format!("<tristrips count=\"1\">{input}<p>0 1 3 2</p></tristrips>");
    let list = format!("<polylist>{input}<vcount>4 3</vcount><p>0 1 2 3 0 1 2</p></polylist>");
    let triangles = format!("<triangles count=\"1\">{input}<p>0 1 2</p></triangles>");
    vec![
        file(&strip, "<translate>1 2 3</translate><rotate>0 0 1 90</rotate>"),
        file(&list, "<skew>45 0 1 0 1 0 0</skew><scale>1 -1 1</scale>"),
        file(&triangles, "<matrix>1 0 0 5 0 1 0 6 0 0 1 7 0 0 0 1</matrix>"),
        file(&triangles, "<lookat>1 2 3 0 0 0 0 0 1</lookat>"),
    ]
}

/// A triangle in a data URI, and the same in a binary file.
fn gltf() -> Vec<Vec<u8>> {
    let file = |uri: &str| {
        format!(
            "{{\"asset\":{{\"version\":\"2.0\"}},\"scene\":0,\"scenes\":[{{\"nodes\":[0]}}],\
             \"nodes\":[{{\"children\":[1],\"translation\":[1,2,3]}},{{\"mesh\":0,\"scale\":[1,1,-1]}}],\
             \"meshes\":[{{\"primitives\":[{{\"attributes\":{{\"POSITION\":0}}}}]}}],\
             \"accessors\":[{{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\",\
             \"min\":[0,0,0],\"max\":[1,1,0]}}],\"bufferViews\":[{{\"buffer\":0,\"byteLength\":36}}],\
             \"buffers\":[{{\"byteLength\":36{uri}}}]}}"
        )
    };
    // Zeros: base64 needs no library for them, and the mesh is a point.
    let text = file(&format!(",\"uri\":\"data:;base64,{}\"", "A".repeat(48)));
    let mut json = file("").into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut binary = [b"glTF", &2u32.to_le_bytes()[..]].concat();
    binary.extend((12 + 8 + json.len() as u32 + 8 + 36).to_le_bytes());
    for (kind, chunk) in [(b"JSON", &json), (b"BIN\0", &vec![0; 36])] {
        binary.extend((chunk.len() as u32).to_le_bytes());
        binary.extend(kind);
        binary.extend(chunk);
    }
    vec![text.into_bytes(), binary]
}
