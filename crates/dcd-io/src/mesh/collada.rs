//! COLLADA: the geometry that the instantiated visual scene shows.
//!
//! Our own reader, for geometry alone: the readers among the kept crates drop what tests here hold
//! (instances beyond the first, transforms of parent nodes, skew, units). Whatever could hide
//! geometry is refused with its element and line; materials, cameras, lights, normals and texture
//! coordinates are passed over. docs/meshes.md says what is read how.

mod geometry;
mod transform;
mod xml;

#[cfg(test)]
mod tests;

use super::triangles::Assembly;
use super::{MeshError, MeshWarning, TriangleMesh, UpAxis};
use crate::XmlBounds;
use glam::{DAffine3, DMat3, DVec3};
use roxmltree::{Document, Node};
use std::collections::HashMap;
use std::rc::Rc;
use xml::{Ids, children, own, refused};

/// Deeper nodes than this are refused: deeper than any tool nests them, and what a node that
/// contains an instance of itself comes to.
const DEEPEST: usize = 256;

/// More nodes and elements in them than this are refused: instances of instances multiply.
const MAX_VISITS: usize = 1 << 20;

/// What takes the parser more than time linear in the text's length. Some tools declare the namespace of a
/// formula wherever one stands; elements, at any depth, take linear time.
const BOUNDS: XmlBounds =
    XmlBounds { elements: usize::MAX, nesting: usize::MAX, attributes: 64, namespaces: 1024 };

/// Reads the triangles of every geometry of the scene, moved as its nodes say, metres.
pub(super) fn read(bytes: &[u8], up_axis: UpAxis) -> Result<TriangleMesh, MeshError> {
    // Ids and names alone may be other than ASCII.
    let text = String::from_utf8_lossy(bytes);
    let text = text.trim_start_matches('\u{feff}');
    BOUNDS.check(text).map_err(xml::too_large)?;
    let document = Document::parse(text).map_err(xml::malformed)?;
    let root = document.root_element();
    if root.tag_name().name() != "COLLADA" {
        return Err(refused(root, "the root of a COLLADA file is <COLLADA>"));
    }
    let asset = Asset::of(root)?;
    let ids = Ids::of(&document);
    let mut walk = Walk { ids: &ids, read: HashMap::new(), whole: Assembly::default(), lines: 0 };
    let mut turn = DMat3::IDENTITY;
    if asset.up != "Z_UP" {
        let warning = MeshWarning::UpAxis { axis: asset.up, taken: up_axis };
        walk.whole.mesh.warnings.push(warning);
        if up_axis == UpAxis::File {
            turn = asset.turn();
        }
    }
    let to_ros = DAffine3::from_mat3(turn * DMat3::from_diagonal(DVec3::splat(asset.metres)));
    walk.nodes_below(scene(root, &ids)?, to_ros)?;
    let count = animations(root);
    if count > 0 {
        walk.whole.mesh.warnings.push(MeshWarning::Animations { count });
    }
    if walk.lines > 0 {
        walk.whole.mesh.warnings.push(MeshWarning::Lines { count: walk.lines });
    }
    Ok(walk.whole.mesh)
}

/// What the file says of its unit and axes.
struct Asset {
    /// Metres in a unit of length.
    metres: f64,
    up: &'static str,
}

impl Asset {
    fn of(root: Node<'_, '_>) -> Result<Self, MeshError> {
        let mut asset = Self { metres: 1.0, up: "Y_UP" };
        for name in ["unit", "up_axis"] {
            let mut said = own(root, "asset").flat_map(|asset| own(asset, name));
            if let Some(second) = said.nth(1) {
                return Err(refused(second, format!("a second <{name}>")));
            }
        }
        for own_asset in own(root, "asset") {
            asset = asset.with(own_asset)?;
        }
        // The unit of an element inside would hold for that element alone.
        let inner = root.descendants().filter(|node| node.tag_name().name() == "asset");
        for inner in inner.filter(|node| node.parent() != Some(root)) {
            let said = Self { ..asset }.with(inner)?;
            if (said.metres, said.up) != (asset.metres, asset.up) {
                return Err(refused(inner, "an element's own unit or up axis is not supported"));
            }
        }
        Ok(asset)
    }

    fn with(mut self, asset: Node<'_, '_>) -> Result<Self, MeshError> {
        for child in children(asset) {
            match child.tag_name().name() {
                "unit" => {
                    // A name alone leaves the default, a metre.
                    let Some(text) = child.attribute("meter") else { continue };
                    self.metres = match text.trim().parse::<f64>() {
                        Ok(metres) if metres.is_finite() && metres > 0.0 => metres,
                        _ => {
                            return Err(refused(child, format!("{text:?} is no length in metres")));
                        }
                    };
                }
                "up_axis" => {
                    let text = xml::text(child)?;
                    self.up = match text.trim() {
                        "X_UP" => "X_UP",
                        "Y_UP" => "Y_UP",
                        "Z_UP" => "Z_UP",
                        other => return Err(refused(child, format!("{other:?} is no up axis"))),
                    };
                }
                _ => {}
            }
        }
        Ok(self)
    }

    /// The rotation from the file's axes to z up.
    fn turn(&self) -> DMat3 {
        match self.up {
            // Right is −y, up x, towards the viewer z.
            "X_UP" => DMat3::from_cols(DVec3::Z, -DVec3::X, -DVec3::Y),
            // Right is x, up y, towards the viewer z.
            "Y_UP" => DMat3::from_cols(DVec3::X, DVec3::Z, -DVec3::Y),
            _ => DMat3::IDENTITY,
        }
    }
}

/// How many animations say how something moves.
fn animations(root: Node<'_, '_>) -> usize {
    let libraries = own(root, "library_animations").flat_map(|library| library.descendants());
    let said = libraries.filter(|node| node.tag_name().name() == "animation");
    said.filter(|animation| own(*animation, "channel").next().is_some()).count()
}

/// The visual scene that the file instantiates.
fn scene<'a>(root: Node<'a, 'a>, ids: &Ids<'a>) -> Result<Node<'a, 'a>, MeshError> {
    let shown = own(root, "scene").flat_map(|scene| own(scene, "instance_visual_scene"));
    let shown: Vec<_> = shown.collect();
    match shown[..] {
        [] => Err(refused(root, "the file shows no visual scene (<instance_visual_scene>)")),
        [instance] => ids.target(instance, "url", "visual_scene"),
        [_, second, ..] => Err(refused(second, "a second visual scene is not supported")),
    }
}

/// The walk through the scene's nodes.
struct Walk<'a, 'i> {
    ids: &'i Ids<'a>,
    /// The geometries that were read already.
    read: HashMap<roxmltree::NodeId, Rc<TriangleMesh>>,
    whole: Assembly,
    /// Elements with lines alone.
    lines: usize,
}

/// A node that is to be visited.
struct Visit<'a> {
    node: Node<'a, 'a>,
    to_whole: DAffine3,
    depth: usize,
}

impl<'a> Walk<'a, '_> {
    fn nodes_below(&mut self, scene: Node<'a, 'a>, to_whole: DAffine3) -> Result<(), MeshError> {
        let mut ahead = vec![Visit { node: scene, to_whole, depth: 0 }];
        let mut visits = 0;
        while let Some(visit) = ahead.pop() {
            visits += 1 + children(visit.node).count();
            if visits > MAX_VISITS {
                let problem = format!("more than {MAX_VISITS} nodes and their elements are shown");
                return Err(refused(visit.node, problem));
            }
            if visit.depth > DEEPEST {
                let problem =
                    format!("nodes are nested more than {DEEPEST} deep, or in themselves");
                return Err(refused(visit.node, problem));
            }
            let first = ahead.len();
            self.visit(&visit, &mut ahead)?;
            // The file's order.
            ahead[first..].reverse();
        }
        Ok(())
    }

    /// Shows what a node shows itself, and lists the nodes below it.
    fn visit(&mut self, visit: &Visit<'a>, ahead: &mut Vec<Visit<'a>>) -> Result<(), MeshError> {
        let mut to_whole = visit.to_whole;
        for child in children(visit.node) {
            if let Some(transform) = transform::read(child)? {
                to_whole *= transform;
            }
        }
        let depth = visit.depth + 1;
        for child in children(visit.node) {
            match child.tag_name().name() {
                "node" => ahead.push(Visit { node: child, to_whole, depth }),
                "instance_node" => {
                    let node = self.ids.target(child, "url", "node")?;
                    ahead.push(Visit { node, to_whole, depth });
                }
                "instance_geometry" => {
                    let mesh = self.geometry(child)?;
                    if !self.whole.add(&mesh, to_whole) {
                        return Err(refused(child, "the scene has too many triangles"));
                    }
                }
                "instance_controller" => {
                    let problem = "skinned and morphed geometry (controllers) is not supported";
                    return Err(refused(child, problem));
                }
                "asset" | "extra" | "instance_camera" | "instance_light" | "evaluate_scene" => {}
                name if transform::NAMES.contains(&name) => {}
                _ => return Err(refused(child, "an unknown element in a node")),
            }
        }
        Ok(())
    }

    /// The triangles of a geometry, which is read once.
    fn geometry(&mut self, instance: Node<'a, 'a>) -> Result<Rc<TriangleMesh>, MeshError> {
        let geometry = self.ids.target(instance, "url", "geometry")?;
        if let Some(mesh) = self.read.get(&geometry.id()) {
            return Ok(Rc::clone(mesh));
        }
        let mut mesh = geometry::read(geometry, self.ids)?;
        for warning in mesh.warnings.drain(..) {
            if let MeshWarning::Lines { count } = warning {
                self.lines += count;
            }
        }
        let mesh = Rc::new(mesh);
        self.read.insert(geometry.id(), Rc::clone(&mesh));
        Ok(mesh)
    }
}
