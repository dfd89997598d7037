//! glTF 2.0: the meshes of the scene that the file shows.
//!
//! The crate `gltf` reads and checks the JSON and the chunks. Accessors are read here: its own
//! iterators take for granted that they fit their buffers, and its import brings a reader of images.

mod accessor;
mod buffers;

#[cfg(test)]
mod tests;

use super::triangles::Assembly;
use super::{MeshError, MeshFormat, MeshOptions, MeshPlace, MeshWarning, TriangleMesh, UpAxis};
use crate::bytes::without_mark;
use accessor::Accessors;
use glam::{DAffine3, DMat3, DMat4, DVec3};
use gltf::mesh::Mode;
use gltf::{Document, Gltf, Node, Primitive, Semantic};
use std::collections::HashMap;
use std::rc::Rc;

/// Deeper nodes than this are refused: deeper than any tool nests them, and what a node that is its
/// own descendant comes to.
const DEEPEST: usize = 256;

/// More visits of nodes than this are refused: a node may not have two parents, but a file that
/// breaks this rule multiplies its nodes.
const MAX_VISITS: usize = 1 << 20;

/// Reads the triangles of every mesh of the scene, moved as its nodes say, metres.
pub(super) fn read(bytes: &[u8], options: &MeshOptions) -> Result<TriangleMesh, MeshError> {
    let bytes = without_mark(bytes);
    check_header(bytes)?;
    let invalid = |error: gltf::Error| refused("", error.to_string());
    let Gltf { document, blob } = Gltf::from_slice_without_validation(bytes).map_err(invalid)?;
    let json = document.into_json();
    check_version(&json)?;
    check_copies(bytes)?;
    check_attributes(&json)?;
    check_transforms(&json)?;
    let document = Document::from_json(json).map_err(invalid)?;
    check_extensions(&document)?;
    let buffers = buffers::load(&document, blob, options)?;
    let mut walk = Walk {
        accessors: Accessors { buffers: &buffers },
        read: HashMap::new(),
        whole: Assembly::default(),
        lines: 0,
    };
    let warning = MeshWarning::UpAxis { axis: "y", taken: options.up_axis };
    walk.whole.mesh.warnings.push(warning);
    let names = unread_extensions(&document);
    if !names.is_empty() {
        walk.whole.mesh.warnings.push(MeshWarning::Extensions { names });
    }
    let count = document.animations().count();
    if count > 0 {
        walk.whole.mesh.warnings.push(MeshWarning::Animations { count });
    }
    let turn = match options.up_axis {
        UpAxis::Ros => DMat3::IDENTITY,
        UpAxis::File => DMat3::from_cols(DVec3::X, DVec3::Z, -DVec3::Y),
    };
    walk.scene(&document, DAffine3::from_mat3(turn))?;
    if walk.lines > 0 {
        walk.whole.mesh.warnings.push(MeshWarning::Lines { count: walk.lines });
    }
    Ok(walk.whole.mesh)
}

fn refused(path: &str, problem: impl Into<String>) -> MeshError {
    let place = if path.is_empty() { MeshPlace::File } else { MeshPlace::Json(path.to_owned()) };
    MeshError::refused(MeshFormat::Gltf, place, problem)
}

/// The header of a binary file: the library subtracts from its length before it looks, and looks at nothing
/// behind it, where zeros alone are no other file.
fn check_header(bytes: &[u8]) -> Result<(), MeshError> {
    if !bytes.starts_with(b"glTF") {
        return Ok(());
    }
    let length = bytes.get(8..).and_then(|rest| rest.first_chunk::<4>());
    let length = length.map_or(0, |field| u32::from_le_bytes(*field) as usize);
    if length >= 20 && bytes.get(length..).is_some_and(|rest| rest.iter().all(|&byte| byte == 0)) {
        return Ok(());
    }
    let problem = format!("the header states {length} bytes, but there are {}", bytes.len());
    Err(MeshError::refused(MeshFormat::Gltf, MeshPlace::Byte(8), problem))
}

/// Another major version may place or make meshes by what is not read here, and a reader of 2.0 is not enough
/// where the file says so.
fn check_version(json: &gltf::json::Root) -> Result<(), MeshError> {
    let (version, least) = (&json.asset.version, json.asset.min_version.as_deref());
    if version.starts_with("2.") && least.is_none_or(|least| least == "2.0") {
        return Ok(());
    }
    let readers = least.map_or(String::new(), |least| format!(", for readers of {least:?}"));
    let problem = format!("version {version:?}{readers}: 2.0 is understood");
    Err(refused("asset", problem))
}

/// Checks that no node has two transforms: the library would pass over the second.
fn check_transforms(json: &gltf::json::Root) -> Result<(), MeshError> {
    let has_both = |node: &gltf::json::Node| {
        let decomposed =
            node.translation.is_some() || node.rotation.is_some() || node.scale.is_some();
        node.matrix.is_some() && decomposed
    };
    match json.nodes.iter().position(has_both) {
        None => Ok(()),
        Some(index) => {
            let problem = "it has a matrix and a translation, rotation or scale";
            Err(refused(&format!("nodes[{index}]"), problem))
        }
    }
}

/// Checks that every attribute names an accessor: the library's own check assumes it.
fn check_attributes(json: &gltf::json::Root) -> Result<(), MeshError> {
    let count = json.accessors.len();
    for (index, mesh) in json.meshes.iter().enumerate() {
        let mut attributes = mesh.primitives.iter().flat_map(|each| each.attributes.values());
        if let Some(wrong) = attributes.find(|accessor| accessor.value() >= count) {
            let problem = format!("it names accessor {}, but there are {count}", wrong.value());
            return Err(refused(&format!("meshes[{index}]"), problem));
        }
    }
    Ok(())
}

/// Makes copies of a node's mesh, and need not be required.
const COPIES: &str = "EXT_mesh_gpu_instancing";

/// Checks that no node copies its mesh, declared or not: the library drops what it does not know of a node, so
/// that the text itself is looked at.
fn check_copies(bytes: &[u8]) -> Result<(), MeshError> {
    let invalid = |error: gltf::Error| refused("", error.to_string());
    let binary = bytes.starts_with(b"glTF").then(|| gltf::Glb::from_slice(bytes)).transpose();
    let binary = binary.map_err(invalid)?;
    let text = binary.as_ref().map_or(bytes, |binary| &binary.json);
    let json: serde_json::Value =
        serde_json::from_slice(text).map_err(|error| refused("", error.to_string()))?;
    let nodes = json["nodes"].as_array().map_or(&[][..], Vec::as_slice);
    match nodes.iter().position(|node| !node["extensions"][COPIES].is_null()) {
        None => Ok(()),
        Some(index) => {
            Err(refused(&format!("nodes[{index}]"), format!("{COPIES} is not supported")))
        }
    }
}

/// What is required is refused by the library, but for what concerns the look alone; copies of
/// meshes would be passed over although they are not required.
fn check_extensions(document: &Document) -> Result<(), MeshError> {
    if document.extensions_used().any(|name| name == COPIES) {
        return Err(refused("extensionsUsed", format!("{COPIES} is not supported")));
    }
    if document.extensions_required().any(|name| name.contains("quantization")) {
        return Err(refused("extensionsRequired", "quantized meshes are not supported"));
    }
    Ok(())
}

/// How the names of extensions begin that concern looks and labels alone.
const LOOKS: [&str; 6] =
    ["KHR_materials_", "KHR_texture_", "EXT_texture_", "KHR_lights_", "EXT_lights_", "KHR_xmp"];

/// The extensions that the file uses, but for those of looks: none of them is read here, and one that is not required
/// may place meshes nevertheless.
fn unread_extensions(document: &Document) -> Vec<String> {
    let of_looks = |name: &&str| LOOKS.iter().any(|look| name.starts_with(look));
    document.extensions_used().filter(|name| !of_looks(name)).map(str::to_owned).collect()
}

/// The walk through the scene's nodes.
struct Walk<'a> {
    accessors: Accessors<'a>,
    /// The meshes that were read already.
    read: HashMap<usize, Rc<TriangleMesh>>,
    whole: Assembly,
    /// Primitives with points and lines alone.
    lines: usize,
}

impl Walk<'_> {
    fn scene(&mut self, document: &Document, to_whole: DAffine3) -> Result<(), MeshError> {
        let mut scenes = document.scenes();
        let shown = match (document.default_scene(), scenes.next(), scenes.next()) {
            (Some(scene), ..) | (None, Some(scene), None) => scene,
            (None, None, _) => return Err(refused("scenes", "the file shows no scene")),
            (None, Some(_), Some(_)) => {
                return Err(refused("scene", "the file does not say which of its scenes it shows"));
            }
        };
        let mut ahead: Vec<(Node<'_>, DAffine3, usize)> =
            shown.nodes().map(|node| (node, to_whole, 0)).collect();
        ahead.reverse();
        let mut visits = 0;
        while let Some((node, to_whole, depth)) = ahead.pop() {
            visits += 1;
            let path = format!("nodes[{}]", node.index());
            if visits > MAX_VISITS {
                return Err(refused(&path, format!("more than {MAX_VISITS} nodes are shown")));
            }
            if depth > DEEPEST {
                let problem =
                    format!("nodes are nested more than {DEEPEST} deep, or in themselves");
                return Err(refused(&path, problem));
            }
            let to_whole = to_whole * transform(&node, &path)?;
            self.node(&node, to_whole, &path)?;
            let first = ahead.len();
            ahead.extend(node.children().map(|child| (child, to_whole, depth + 1)));
            ahead[first..].reverse();
        }
        Ok(())
    }

    fn node(&mut self, node: &Node<'_>, to_whole: DAffine3, path: &str) -> Result<(), MeshError> {
        let Some(mesh) = node.mesh() else { return Ok(()) };
        if node.skin().is_some() {
            return Err(refused(path, "skinned meshes are not supported"));
        }
        let known = self.read.get(&mesh.index()).cloned();
        let read = match known {
            Some(read) => read,
            None => {
                let read = Rc::new(self.mesh(&mesh)?);
                self.read.insert(mesh.index(), Rc::clone(&read));
                read
            }
        };
        if self.whole.add(&read, to_whole) {
            return Ok(());
        }
        Err(refused(path, "the scene has too many triangles"))
    }

    fn mesh(&mut self, mesh: &gltf::Mesh<'_>) -> Result<TriangleMesh, MeshError> {
        let mut whole = Assembly::default();
        for primitive in mesh.primitives() {
            let path = format!("meshes[{}].primitives[{}]", mesh.index(), primitive.index());
            if primitive.morph_targets().next().is_some() {
                return Err(refused(&path, "morph targets are not supported"));
            }
            if matches!(
                primitive.mode(),
                Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip
            ) {
                self.lines += 1;
                continue;
            }
            let read = self.primitive(&primitive, &path)?;
            if !whole.add(&read, DAffine3::IDENTITY) {
                return Err(refused(&path, "too many triangles"));
            }
        }
        whole.mesh.drop_loose_vertices();
        Ok(whole.mesh)
    }

    fn primitive(
        &mut self,
        primitive: &Primitive<'_>,
        path: &str,
    ) -> Result<TriangleMesh, MeshError> {
        let Some(positions) = primitive.get(&Semantic::Positions) else {
            return Err(refused(path, "there are no positions"));
        };
        let vertices = self.accessors.points(&positions)?;
        let corners = match primitive.indices() {
            Some(indices) => self.accessors.indices(&indices)?,
            None => (0..vertices.len() as u32).collect(),
        };
        if let Some(&corner) = corners.iter().find(|&&corner| corner as usize >= vertices.len()) {
            let problem = format!("it names point {corner}, but there are {}", vertices.len());
            return Err(refused(path, problem));
        }
        let mut triangles: Vec<[u32; 3]> = match primitive.mode() {
            Mode::TriangleStrip => strip(&corners),
            Mode::TriangleFan => super::triangles::fan(&corners).collect(),
            _ => {
                let (triangles, []) = corners.as_chunks::<3>() else {
                    let problem = format!("{} corners make no triangles", corners.len());
                    return Err(refused(path, problem));
                };
                triangles.to_vec()
            }
        };
        triangles.shrink_to_fit();
        Ok(TriangleMesh { vertices, triangles, warnings: Vec::new() })
    }
}

/// Every second triangle of a strip lists its corners the other way round.
fn strip(corners: &[u32]) -> Vec<[u32; 3]> {
    let triangles = corners.windows(3).enumerate();
    let turned = |(k, at): (usize, &[u32])| {
        if k % 2 == 0 { [at[0], at[1], at[2]] } else { [at[1], at[0], at[2]] }
    };
    triangles.map(turned).collect()
}

/// The transform from the node's frame to its parent's.
fn transform(node: &Node<'_>, path: &str) -> Result<DAffine3, MeshError> {
    use gltf::scene::Transform;
    let transform = match node.transform() {
        Transform::Matrix { matrix } => {
            let matrix = DMat4::from_cols_array_2d(&matrix.map(|column| column.map(f64::from)));
            if matrix.row(3) != glam::DVec4::W {
                return Err(refused(path, "a last row other than 0 0 0 1 is not supported"));
            }
            DAffine3::from_mat4(matrix)
        }
        Transform::Decomposed { translation, rotation, scale } => {
            let turn = glam::DQuat::from_array(rotation.map(f64::from));
            // What f32 and a few decimals leave of unit length is no reason to scale.
            if !((turn.length() - 1.0).abs() < LENGTH_OF_TURN) {
                return Err(refused(path, format!("a rotation of length {:e}", turn.length())));
            }
            let scale = DVec3::from_array(scale.map(f64::from));
            let translation = DVec3::from_array(translation.map(f64::from));
            DAffine3::from_scale_rotation_translation(scale, turn.normalize(), translation)
        }
    };
    if transform.is_finite() {
        return Ok(transform);
    }
    Err(refused(path, "a transform that is not finite"))
}

/// How far a rotation's quaternion may be from unit length; no unit. Above what three decimals, the
/// fewest that tools write, leave. Larger: what is no rotation passes for one.
const LENGTH_OF_TURN: f64 = 2e-3;
