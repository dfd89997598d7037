//! MoveIt's scenes and requests as YAML, and meshes as OBJ.

use crate::Input;
use dcd_io::{RawMesh, read_obj};
use dcd_robot::{LinkShapes, PlanningScene, Request, Robot, World};
use std::fmt;
use std::path::Path;
use std::sync::OnceLock;

/// Bytes as they stand in a message.
pub(crate) struct Shown<'a>(pub(crate) &'a [u8]);

impl fmt::Display for Shown<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.escape_ascii().fmt(f)
    }
}

/// No panic; of a scene that is built from the bytes every obstacle is there, under its name and where
/// it was put. The first byte says whether the rest is a text or what one is built from.
pub fn scenes(bytes: &[u8]) {
    let Some((&which, rest)) = bytes.split_first() else { return };
    if which % 2 == 0 {
        if let Ok(text) = std::str::from_utf8(rest) {
            drop(world(text));
        }
        return;
    }
    let Some((text, objects)) = built_scene(&mut Input(rest)) else { return };
    let Some(world) = world(&text) else { return };
    assert_eq!(world.obstacles.len(), objects.len(), "{text}");
    for (obstacle, (name, place)) in world.obstacles.iter().zip(&objects) {
        assert_eq!(
            (&obstacle.name, obstacle.pose.translation().to_array()),
            (name, *place),
            "{text}"
        );
    }
}

/// The name and the place of a shape.
pub(crate) type Placed = (String, [f64; 3]);

/// The scene that a text is, for a robot of one link.
fn world(text: &str) -> Option<World> {
    static ROBOT: OnceLock<Option<Robot>> = OnceLock::new();
    let urdf = "<robot name='r'><link name='base'><collision><geometry><sphere radius='1'/></geometry>\
                </collision></link></robot>";
    let robot = ROBOT.get_or_init(|| Robot::read(urdf, Path::new("."), LinkShapes::Hulls).ok());
    PlanningScene::read(text).ok()?.world(robot.as_ref()?, None).ok()
}

/// A scene's text, and the name and place of each of its shapes.
pub(crate) fn built_scene(input: &mut Input<'_>) -> Option<(String, Vec<Placed>)> {
    let (mut text, mut shapes) = (String::from("world:\n  collision_objects:\n"), Vec::new());
    let count = input.byte()? % 6;
    for object in 0..count {
        let (mut primitives, mut poses) = (Vec::new(), Vec::new());
        for _ in 0..1 + input.byte()? % 3 {
            let size = input.number()?.abs();
            primitives.push(match input.byte()? % 3 {
                0 => format!("{{type: sphere, dimensions: [{size:e}]}}"),
                1 => format!("{{type: box, dimensions: [1, {size:e}, 2]}}"),
                _ => format!("{{type: cylinder, dimensions: [{size:e}, 1]}}"),
            });
            // A zero's sign is no place.
            let place = input.vector()?.to_array().map(|x| x + 0.0);
            let [x, y, z] = place;
            poses.push(format!("{{position: [{x:e}, {y:e}, {z:e}], orientation: [0, 0, 0, 1]}}"));
            shapes.push((format!("o{object}"), place));
        }
        text += &format!(
            "    - id: o{object}\n      primitives: [{}]\n      primitive_poses: [{}]\n",
            primitives.join(", "),
            poses.join(", ")
        );
    }
    if count == 0 {
        text = "world: {collision_objects: []}\n".to_owned();
    }
    Some((text, shapes))
}

/// No panic; a request that was read is written and read again unchanged, and one that is built from
/// the bytes holds what was built in.
pub fn requests(bytes: &[u8]) {
    let Some((&which, rest)) = bytes.split_first() else { return };
    if which % 2 == 0 {
        let Ok(text) = std::str::from_utf8(rest) else { return };
        let Ok(request) = Request::read(text) else { return };
        let finite = |values: &[(String, f64)]| values.iter().all(|(_, value)| value.is_finite());
        if finite(&request.start) && finite(&request.goal) {
            let again = Request::read(&written(&request.start, &request.goal));
            let again = again.expect("what was written can be read");
            assert_eq!((again.start, again.goal), (request.start, request.goal));
        }
        return;
    }
    let Some((text, start, goal)) = built_request(&mut Input(rest)) else { return };
    let Ok(request) = Request::read(&text) else { return };
    assert_eq!((&request.start, &request.goal), (&start, &goal), "{text}");
}

type Values = Vec<(String, f64)>;

/// A request's text, its start and its goal.
pub(crate) fn built_request(input: &mut Input<'_>) -> Option<(String, Values, Values)> {
    let mut values = || -> Option<Values> {
        let count = input.byte()? % 8;
        (0..count).map(|k| Some((format!("j{k}"), input.number()?))).collect()
    };
    let (start, goal) = (values()?, values()?);
    let finite = start.iter().chain(&goal).all(|(_, value)| value.is_finite());
    finite.then(|| (written(&start, &goal), start, goal))
}

fn written(start: &[(String, f64)], goal: &[(String, f64)]) -> String {
    let name = |name: &str| {
        let plain = |c: char| matches!(c, ' '..='~') && !matches!(c, '"' | '\\');
        let escaped = |c: char| {
            if plain(c) { c.to_string() } else { format!("\\U{:08x}", u32::from(c)) }
        };
        format!("\"{}\"", name.chars().map(escaped).collect::<String>())
    };
    let names: Vec<_> = start.iter().map(|(joint, _)| name(joint)).collect();
    let values: Vec<_> = start.iter().map(|(_, value)| format!("{value:e}")).collect();
    let constraint = |(joint, value): &(String, f64)| {
        format!("{{joint_name: {}, position: {value:e}}}", name(joint))
    };
    let goals: Vec<_> = goal.iter().map(constraint).collect();
    format!(
        "start_state: {{joint_state: {{name: [{}], position: [{}]}}}}\n\
         goal_constraints: [{{joint_constraints: [{}]}}]\n",
        names.join(", "),
        values.join(", "),
        goals.join(", ")
    )
}

/// No panic; a mesh that was read has corners that are vertices, makes a shape or has no triangle, and
/// is written and read again unchanged.
pub fn obj(bytes: &[u8]) {
    let Ok(mesh) = read_obj(bytes) else { return };
    let count = mesh.vertices.len();
    assert!(mesh.faces.iter().flatten().all(|&corner| (corner as usize) < count));
    // Of another order are vertices that no face names.
    let corners = |mesh: &RawMesh| -> Vec<[[u64; 3]; 3]> {
        let bits = |k: u32| mesh.vertices[k as usize].to_array().map(f64::to_bits);
        mesh.faces.iter().map(|face| face.map(bits)).collect()
    };
    if !mesh.faces.is_empty() {
        let again = read_obj(text_of(&mesh).as_bytes()).expect("what was written can be read");
        assert_eq!(corners(&again), corners(&mesh));
        assert_eq!(again.vertices.len(), count);
    }
    assert_eq!(mesh.clone().into_shape().is_err(), mesh.faces.is_empty());
}

fn text_of(mesh: &RawMesh) -> String {
    let vertices = mesh.vertices.iter().map(|v| format!("v {:e} {:e} {:e}\n", v.x, v.y, v.z));
    let faces = mesh.faces.iter().map(|[a, b, c]| {
        format!("f {} {} {}\n", u64::from(*a) + 1, u64::from(*b) + 1, u64::from(*c) + 1)
    });
    vertices.chain(faces).collect()
}
