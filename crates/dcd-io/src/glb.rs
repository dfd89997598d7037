//! Scenes as binary glTF 2.0, to be looked at: shapes at their poses, touching ones in another colour,
//! contact points with their normals, and frames as an animation.

mod document;
mod surface;

use dcd_geom::{Motion, Pose, Scene};
use document::Document;
use glam::{DQuat, DVec3};
use gltf::json::animation::{Animation, Channel, Interpolation, Property, Sampler};
use gltf::json::buffer::Target;
use gltf::json::material::{PbrBaseColorFactor, PbrMetallicRoughness, StrengthFactor};
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::scene::UnitQuaternion;
use gltf::json::validation::Checked;
use gltf::json::{Accessor, Index, Material, Mesh, Node};
use std::collections::HashMap;
use std::io::{self, Write};
use surface::Surface;

/// A point in which two objects touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GlbContact {
    /// Where, in the world, metres.
    pub point: DVec3,
    /// The direction in which it is drawn, of unit length.
    pub normal: DVec3,
}

/// How something looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Look {
    Apart,
    Static,
    Touching,
    Contact,
}

/// A scene to be written as binary glTF: objects and poses in f32, metres, z up (a root node turns it to
/// glTF's y up). Round shapes are drawn by flat faces inside of them, a half-space by a square as
/// wide as the scene.
///
/// Several frames become an animation. Each object that moves has a node that is animated; one
/// whose look changes has a node for each look, of which one at a time has a size.
///
/// ```
/// use dcd_geom::{Pose, Scene, Shape};
/// use dcd_io::GlbScene;
/// let scene = Scene::one_each(vec![Shape::sphere(1.0)?], vec![Pose::IDENTITY])?;
/// let mut file = Vec::new(); // or a file
/// GlbScene::new(&scene).write(&mut file)?;
/// assert!(file.starts_with(b"glTF"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct GlbScene<'s> {
    scene: &'s Scene,
    /// What each object is called; none: it is not drawn.
    names: Vec<Option<String>>,
    /// How poses go from frame to frame.
    between: Interpolation,
    frames: Vec<Frame>,
}

#[derive(Clone, Debug)]
struct Frame {
    time: f32,
    /// Translation and quaternion of each slot.
    poses: Vec<([f32; 3], [f32; 4])>,
    touching: Vec<bool>,
    contacts: Vec<GlbContact>,
}

impl<'s> GlbScene<'s> {
    /// A picture of this scene's shapes and objects, without frames.
    pub fn new(scene: &'s Scene) -> Self {
        let is_there = |i: &usize| scene.motion(*i).is_some();
        let name = |i| Some(i).filter(is_there).map(|i| format!("object {i}"));
        let names = (0..scene.len()).map(name).collect();
        Self { scene, names, between: Interpolation::Linear, frames: Vec::new() }
    }

    /// Calls each object by its name; one without a name is not drawn.
    ///
    /// # Errors
    /// Another number of names than of slots, or a name for a slot without an object.
    pub fn named(mut self, names: Vec<Option<String>>) -> io::Result<Self> {
        if names.len() != self.scene.len() {
            return refused(format!("{} names for {} objects", names.len(), self.scene.len()));
        }
        let none = |&i: &usize| names[i].is_some() && self.scene.motion(i).is_none();
        if let Some(i) = (0..names.len()).find(none) {
            return refused(format!("a name for object {i}, which is not there"));
        }
        self.names = names;
        Ok(self)
    }

    /// Holds each frame until the next, in place of moving from one to the other.
    #[must_use]
    pub fn held(mut self) -> Self {
        self.between = Interpolation::Step;
        self
    }

    /// Adds a frame, `time` seconds after the first, which is at 0: a pose for each slot, the objects that
    /// touch, and contact points, if there are any to be drawn.
    ///
    /// # Errors
    /// Another number of poses than of slots, a time that is not after the frame before, or an index
    /// that is no slot's.
    pub fn frame(
        &mut self,
        time: f64,
        poses: &[Pose],
        touching: impl IntoIterator<Item = u32>,
        contacts: Vec<GlbContact>,
    ) -> io::Result<()> {
        let slots = self.scene.len();
        if poses.len() != slots {
            return refused(format!("{} poses for {slots} objects", poses.len()));
        }
        let time = time as f32;
        let before = self.frames.last().map_or(f32::NEG_INFINITY, |frame| frame.time);
        if !(time.is_finite() && time > before && (time == 0.0) == self.frames.is_empty()) {
            return refused(format!("a frame at {time:e} s after one at {before:e} s"));
        }
        let mut flags = vec![false; slots];
        for i in touching {
            match flags.get_mut(i as usize) {
                Some(flag) => *flag = true,
                None => return refused(format!("object {i} of {slots}")),
            }
        }
        let poses = poses.iter().map(in_f32).collect();
        self.frames.push(Frame { time, poses, touching: flags, contacts });
        Ok(())
    }

    /// Writes the file. A scene without a frame is drawn where it stands, nothing touching.
    ///
    /// # Errors
    /// Those of the writer; a file of 4 GiB or more, which the format has no length for.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        if self.frames.is_empty() {
            let mut still = self.clone();
            still.frame(0.0, self.scene.poses(), [], Vec::new())?;
            return still.write(out);
        }
        Writer::new(self).write(out)
    }
}

fn refused<T>(problem: String) -> io::Result<T> {
    Err(io::Error::new(io::ErrorKind::InvalidInput, problem))
}

fn in_f32(pose: &Pose) -> ([f32; 3], [f32; 4]) {
    let rotation = DQuat::from_mat3(pose.rotation()).as_quat().normalize();
    (pose.translation().as_vec3().to_array(), rotation.to_array())
}

struct Writer<'g> {
    scene: &'g Scene,
    names: &'g [Option<String>],
    between: Interpolation,
    frames: &'g [Frame],
    extent: f64,
    document: Document,
    surfaces: HashMap<u32, Option<[Index<Accessor>; 2]>>,
    materials: HashMap<Look, Index<Material>>,
    meshes: HashMap<(u32, Look), Index<Mesh>>,
    channels: Vec<Channel>,
    samplers: Vec<Sampler>,
    /// The times of the frames, once an animation needs them.
    times: Option<Index<Accessor>>,
}

impl<'g> Writer<'g> {
    fn new(glb: &'g GlbScene<'_>) -> Self {
        Self {
            scene: glb.scene,
            names: &glb.names,
            between: glb.between,
            frames: &glb.frames,
            extent: extent(glb.scene, &glb.names),
            document: Document::default(),
            surfaces: HashMap::new(),
            materials: HashMap::new(),
            meshes: HashMap::new(),
            channels: Vec::new(),
            samplers: Vec::new(),
            times: None,
        }
    }

    fn write(mut self, out: &mut dyn Write) -> io::Result<()> {
        let names = self.names.iter().enumerate();
        let objects = names.filter_map(|(i, name)| Some((i, name.as_deref()?)));
        let mut nodes: Vec<Index<Node>> = objects.map(|(i, name)| self.object(i, name)).collect();
        for frame in 0..self.frames.len() {
            nodes.extend(self.contacts(frame));
        }
        if !self.channels.is_empty() {
            self.document.root.push(Animation {
                extensions: None,
                extras: Default::default(),
                channels: self.channels,
                name: Some("frames".to_owned()),
                samplers: self.samplers,
            });
        }
        // A quarter turn about x brings z up to glTF's y up.
        let half = std::f32::consts::FRAC_1_SQRT_2;
        let top = Node {
            name: Some("z up".to_owned()),
            rotation: Some(UnitQuaternion([-half, 0.0, 0.0, half])),
            children: (!nodes.is_empty()).then_some(nodes),
            ..Node::default()
        };
        self.document.write(top, out)
    }

    /// The node of an object, with one below it for each look that it has in some frame.
    fn object(&mut self, i: usize, name: &str) -> Index<Node> {
        let look = |frame: &Frame| match (frame.touching[i], self.scene.motion(i)) {
            (true, _) => Look::Touching,
            (false, Some(Motion::Static)) => Look::Static,
            (false, _) => Look::Apart,
        };
        let looks: Vec<Look> = self.frames.iter().map(look).collect();
        let shape = self.scene.shape_of()[i];
        let (translation, rotation) = self.frames[0].poses[i];
        let mut node = Node {
            name: Some(name.to_owned()),
            translation: Some(translation),
            rotation: Some(UnitQuaternion(rotation)),
            ..Node::default()
        };
        if looks.iter().all(|&look| look == looks[0]) {
            node.mesh = self.mesh(shape, looks[0]);
        } else {
            // An object is moving or static throughout, so that one other look is all there is.
            let other = looks.iter().find(|&&look| look != Look::Touching);
            let both = [*other.unwrap_or(&looks[0]), Look::Touching];
            let children = both.map(|look| {
                let mesh = self.mesh(shape, look);
                self.shown_when(Node { mesh, ..Node::default() }, |frame| looks[frame] == look)
            });
            node.children = Some(children.to_vec());
        }
        let node = self.document.root.push(node);
        self.animate(node, i);
        node
    }

    /// Moves a node with its object, if that moves.
    fn animate(&mut self, node: Index<Node>, i: usize) {
        let frames = self.frames;
        let first = frames[0].poses[i];
        if frames.iter().any(|frame| frame.poses[i].0 != first.0) {
            let places: Vec<_> = frames.iter().map(|frame| frame.poses[i].0).collect();
            self.channel(node, Property::Translation, self.between, &places);
        }
        if frames.iter().any(|frame| frame.poses[i].1 != first.1) {
            let mut turns: Vec<[f32; 4]> = frames.iter().map(|frame| frame.poses[i].1).collect();
            for k in 1..turns.len() {
                // q and −q are one rotation; the nearer one takes the short way.
                let dot: f32 = turns[k].iter().zip(turns[k - 1]).map(|(a, b)| a * b).sum();
                if dot < 0.0 {
                    turns[k] = turns[k].map(|x| -x);
                }
            }
            self.channel(node, Property::Rotation, self.between, &turns);
        }
    }

    /// A node that has its size in those frames, and none in the others.
    fn shown_when(&mut self, node: Node, shown: impl Fn(usize) -> bool) -> Index<Node> {
        let scale = |frame: usize| [f32::from(u8::from(shown(frame))); 3];
        let scales: Vec<[f32; 3]> = (0..self.frames.len()).map(scale).collect();
        let node = self.document.root.push(Node { scale: Some(scales[0]), ..node });
        if scales.iter().any(|scale| *scale != scales[0]) {
            self.channel(node, Property::Scale, Interpolation::Step, &scales);
        }
        node
    }

    fn channel<const N: usize>(
        &mut self,
        node: Index<Node>,
        path: Property,
        interpolation: Interpolation,
        values: &[[f32; N]],
    ) {
        let frames = self.frames;
        let document = &mut self.document;
        let times = self.times.get_or_insert_with(|| {
            let times: Vec<[f32; 1]> = frames.iter().map(|frame| [frame.time]).collect();
            document.vectors(&times, None)
        });
        let sampler = Sampler {
            extensions: None,
            extras: Default::default(),
            input: *times,
            interpolation: Checked::Valid(interpolation),
            output: document.vectors(values, None),
        };
        let target = gltf::json::animation::Target {
            extensions: None,
            extras: Default::default(),
            node,
            path: Checked::Valid(path),
        };
        self.channels.push(Channel {
            sampler: Index::new(self.samplers.len() as u32),
            target,
            extensions: None,
            extras: Default::default(),
        });
        self.samplers.push(sampler);
    }

    /// The contact points of a frame: each a line along its normal, from the point on.
    fn contacts(&mut self, frame: usize) -> Option<Index<Node>> {
        let frames = self.frames;
        let contacts = &frames[frame].contacts;
        if contacts.is_empty() {
            return None;
        }
        let length = 0.05 * self.extent;
        let ends = |c: &GlbContact| [c.point, c.point + c.normal * length];
        let ends: Vec<[f32; 3]> =
            contacts.iter().flat_map(ends).map(|end| end.as_vec3().to_array()).collect();
        let positions = self.document.vectors(&ends, Some(Target::ArrayBuffer));
        let lines = self.primitive(positions, None, (Mode::Lines, Look::Contact));
        let points = self.primitive(positions, None, (Mode::Points, Look::Contact));
        let mesh = self.document.root.push(mesh(vec![lines, points]));
        let name = Some(format!("contacts of frame {frame}"));
        let node = Node { mesh: Some(mesh), name, ..Node::default() };
        Some(self.shown_when(node, |shown| shown == frame))
    }

    /// The mesh of a shape in a look; none for a shape that has nothing to be drawn.
    fn mesh(&mut self, shape: u32, look: Look) -> Option<Index<Mesh>> {
        if let Some(&known) = self.meshes.get(&(shape, look)) {
            return Some(known);
        }
        let [positions, indices] = self.surface(shape)?;
        let primitive = self.primitive(positions, Some(indices), (Mode::Triangles, look));
        let index = self.document.root.push(mesh(vec![primitive]));
        self.meshes.insert((shape, look), index);
        Some(index)
    }

    fn surface(&mut self, shape: u32) -> Option<[Index<Accessor>; 2]> {
        let Self { scene, extent, document, surfaces, .. } = self;
        *surfaces.entry(shape).or_insert_with(|| {
            let surface = Surface::of(&scene.shapes()[shape as usize], *extent);
            if surface.triangles.is_empty() {
                return None;
            }
            let positions: Vec<[f32; 3]> = surface.positions.iter().map(|v| v.to_array()).collect();
            let positions = document.vectors(&positions, Some(Target::ArrayBuffer));
            let corners = surface.triangles.iter().flatten().copied();
            Some([positions, document.indices(corners)])
        })
    }

    fn primitive(
        &mut self,
        positions: Index<Accessor>,
        indices: Option<Index<Accessor>>,
        (mode, look): (Mode, Look),
    ) -> Primitive {
        let document = &mut self.document;
        let material =
            *self.materials.entry(look).or_insert_with(|| document.root.push(material(look)));
        Primitive {
            attributes: [(Checked::Valid(Semantic::Positions), positions)].into(),
            extensions: None,
            extras: Default::default(),
            indices,
            material: Some(material),
            mode: Checked::Valid(mode),
            targets: None,
        }
    }
}

fn mesh(primitives: Vec<Primitive>) -> Mesh {
    Mesh { extensions: None, extras: Default::default(), name: None, primitives, weights: None }
}

fn material(look: Look) -> Material {
    let (name, colour) = match look {
        Look::Apart => ("apart", [0.36, 0.54, 0.71, 1.0]),
        Look::Static => ("static", [0.62, 0.62, 0.60, 1.0]),
        Look::Touching => ("touching", [0.90, 0.36, 0.16, 1.0]),
        Look::Contact => ("contact", [0.05, 0.05, 0.05, 1.0]),
    };
    Material {
        name: Some(name.to_owned()),
        double_sided: true,
        pbr_metallic_roughness: PbrMetallicRoughness {
            base_color_factor: PbrBaseColorFactor(colour),
            metallic_factor: StrengthFactor(0.0),
            roughness_factor: StrengthFactor(0.8),
            ..PbrMetallicRoughness::default()
        },
        ..Material::default()
    }
}

/// How wide the bounded objects that are drawn lie, metres; 1 for none.
fn extent(scene: &Scene, names: &[Option<String>]) -> f64 {
    let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for i in (0..scene.len()).filter(|&i| names[i].is_some()) {
        if scene.shape(i).is_bounded() {
            let aabb = scene.aabb(i);
            min = min.min(aabb.min.as_dvec3());
            max = max.max(aabb.max.as_dvec3());
        }
    }
    let width = (max - min).max_element();
    if width > 0.0 && width.is_finite() { width } else { 1.0 }
}

#[cfg(test)]
mod tests;
