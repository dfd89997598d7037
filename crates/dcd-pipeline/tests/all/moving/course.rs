//! Scenes that move, come and go: any bytes are a course.

use dcd_geom::glam::{DQuat, DVec3};
use dcd_geom::{Filter, Motion, Object, Pose, Scene, Shape};

/// Where a course gets its choices from.
pub(crate) trait Source {
    /// The next choice; `None` at the end.
    fn byte(&mut self) -> Option<u8>;

    /// A number below `end`, which is at most 256.
    fn below(&mut self, end: usize) -> Option<usize> {
        Some(usize::from(self.byte()?) % end.max(1))
    }
}

/// A source without an end (Steele et al., SplitMix64, 2014).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seeded(pub(crate) u64);

impl Seeded {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Each component within −1 … 1.
    fn vector(&mut self) -> DVec3 {
        let mut number = || (self.next() >> 11) as f64 / (1u64 << 52) as f64 - 1.0;
        DVec3::new(number(), number(), number())
    }
}

impl Source for Seeded {
    fn byte(&mut self) -> Option<u8> {
        Some((self.next() >> 56) as u8)
    }
}

/// Objects in a scene at most: enough for static trees of several leaves.
const OBJECTS: usize = 64;

/// Shapes in a scene at most.
const SHAPES: usize = 24;

/// How far from the origin objects stay that do not leap, metres.
const HALF_WIDTH: f64 = 2.5;

/// A few scenes of which one is shown at a time.
pub(crate) struct Course<'s, S> {
    source: &'s mut S,
    scenes: Vec<Scene>,
    shown: usize,
}

impl<'s, S: Source> Course<'s, S> {
    /// A first scene. `None` at the source's end.
    pub(crate) fn new(source: &'s mut S) -> Option<Self> {
        let scene = new_scene(source)?;
        Some(Self { source, scenes: vec![scene], shown: 0 })
    }

    /// The scene as it stands.
    pub(crate) fn scene(&self) -> &Scene {
        &self.scenes[self.shown]
    }

    /// The next choice, for whoever looks on.
    pub(crate) fn byte(&mut self) -> Option<u8> {
        self.source.byte()
    }

    /// What happens between two steps: mostly some objects move, and now and then more.
    pub(crate) fn advance(&mut self) -> Option<()> {
        let changes = [1, 1, 1, 2, 3, 6][self.source.below(6)?];
        for _ in 0..changes {
            self.change()?;
        }
        Some(())
    }

    fn change(&mut self) -> Option<()> {
        match self.source.below(20)? {
            0..=5 => self.walk(Motion::Moving),
            6 => self.walk(Motion::Static),
            7 | 8 => self.leap(Motion::Moving),
            9 | 10 => self.leap(Motion::Static),
            11 => self.remove(),
            12 => self.insert(),
            13 | 14 => {
                self.remove()?;
                self.insert()
            }
            15 => self.add_shapes(),
            16 => self.show_another(),
            17 => self.ignore(),
            // Nothing moves.
            _ => Some(()),
        }
    }

    /// Every object of that kind moves by a little, some by nothing, a few by much.
    fn walk(&mut self, kind: Motion) -> Option<()> {
        let mut random =
            Seeded(u64::from(self.source.byte()?) << 8 | u64::from(self.source.byte()?));
        let scene = &mut self.scenes[self.shown];
        for i in (0..scene.len()).filter(|&i| scene.motion(i) == Some(kind)).collect::<Vec<_>>() {
            let step = [0.05, 1e-2, 1e-3, 1e-5, 0.0, 0.0][random.next() as usize % 6];
            let pose = scene.poses()[i];
            let turn = DQuat::from_scaled_axis(random.vector() * step);
            let turn = (turn * DQuat::from_mat3(pose.rotation())).normalize();
            let at = pose.translation() + random.vector() * step;
            let at = at.clamp(DVec3::splat(-HALF_WIDTH), DVec3::splat(HALF_WIDTH));
            set(scene, i, Pose::new(turn, at).ok());
        }
        Some(())
    }

    /// One object of that kind goes anywhere: among the others, far off, or to where another is.
    fn leap(&mut self, kind: Motion) -> Option<()> {
        let (choice, byte) = (self.source.below(6)?, self.source.byte()?);
        let new = place(self.source)?;
        let scene = &mut self.scenes[self.shown];
        let Some(i) = some_slot(scene, byte, Some(kind)) else { return Some(()) };
        let there = match choice {
            0 => Pose::from_translation(new.translation() * 2f64.powi(i32::from(byte % 60))).ok(),
            1 => scene.poses().get(usize::from(byte) / 4).copied(),
            _ => Some(new),
        };
        set(scene, i, there);
        Some(())
    }

    fn remove(&mut self) -> Option<()> {
        let byte = self.source.byte()?;
        let scene = &mut self.scenes[self.shown];
        if let Some(handle) = some_slot(scene, byte, None).and_then(|i| scene.handle(i)) {
            let _ = scene.remove(handle);
        }
        Some(())
    }

    fn insert(&mut self) -> Option<()> {
        let scene = &mut self.scenes[self.shown];
        let new = object(self.source, scene.shapes().len())?;
        if scene.object_count() < OBJECTS {
            let _ = scene.insert(new);
        }
        Some(())
    }

    fn add_shapes(&mut self) -> Option<()> {
        let new = shape(self.source)?;
        let scene = &mut self.scenes[self.shown];
        if scene.shapes().len() < SHAPES {
            let _ = scene.add_shapes([new]);
        }
        Some(())
    }

    /// Another scene, or one before: a copy that goes its own way, a new one, or one of nothing.
    fn show_another(&mut self) -> Option<()> {
        let choice = self.source.below(8)?;
        let new = match choice {
            0 => self.scene().clone(),
            1 => new_scene(self.source)?,
            2 => Scene::default(),
            _ => {
                self.shown = choice % self.scenes.len();
                return Some(());
            }
        };
        self.scenes.truncate(3);
        self.scenes.push(new);
        self.shown = self.scenes.len() - 1;
        Some(())
    }

    fn ignore(&mut self) -> Option<()> {
        let bytes = [self.source.byte()?, self.source.byte()?];
        let scene = &mut self.scenes[self.shown];
        let [Some(i), Some(j)] = bytes.map(|byte| some_slot(scene, byte, None)) else {
            return Some(());
        };
        // Refused for a pair of one, which is as well.
        let _ = if bytes[0] < 128 { scene.ignore_pair(i, j) } else { scene.unignore_pair(i, j) };
        Some(())
    }
}

/// Refused poses leave the object where it is.
fn set(scene: &mut Scene, i: usize, pose: Option<Pose>) {
    if let Some(pose) = pose {
        let _ = scene.set_pose(i, pose);
    }
}

/// An object, of that kind if one is given.
fn some_slot(scene: &Scene, byte: u8, kind: Option<Motion>) -> Option<usize> {
    let fits = |&i: &usize| match (scene.motion(i), kind) {
        (None, _) => false,
        (Some(_), None) => true,
        (motion, kind) => motion == kind,
    };
    let slots: Vec<usize> = (0..scene.len()).filter(fits).collect();
    slots.get(usize::from(byte) % slots.len().max(1)).copied()
}

/// Of one kind (whose pairs need no vertices) or of many; a third of the objects static.
fn new_scene(source: &mut impl Source) -> Option<Scene> {
    let count = [3, 8, 16, 20, 40, 60][source.below(6)?];
    let shapes = match source.below(4)? {
        0 => vec![Shape::sphere(0.5), Shape::sphere(0.2), Shape::sphere(1e-4)],
        1 => [0.5, 0.3, 0.7].map(|half| Shape::cuboid(DVec3::new(half, 0.4, 0.3))).to_vec(),
        _ => {
            let some = (0..4).map(|_| Some(Ok(shape(source)?)));
            some.collect::<Option<Vec<_>>>()?
        }
    };
    let shapes: Vec<Shape> = shapes.into_iter().flatten().collect();
    let mut random = Seeded(u64::from(source.byte()?));
    let objects = (0..count).map(|_| object(&mut random, shapes.len()));
    Scene::new(shapes.clone(), objects.collect::<Option<Vec<_>>>()?).ok()
}

fn object(source: &mut impl Source, shapes: usize) -> Option<Object> {
    let new = Object::new(source.below(shapes)? as u32, place(source)?);
    let filter = match source.below(16)? {
        0 => Filter { groups: 1, mask: 2 },
        _ => Filter::ALL,
    };
    let new = if source.below(3)? == 0 { new.fixed() } else { new };
    Some(Object { filter, ..new })
}

/// On a grid, so that faces meet exactly, or anywhere; upright or turned.
fn place(source: &mut impl Source) -> Option<Pose> {
    let choice = source.below(4)?;
    let bytes = [source.byte()?, source.byte()?, source.byte()?];
    let grid = DVec3::from_array(bytes.map(|byte| f64::from(byte as i8) / 64.0));
    if choice > 0 {
        return Pose::from_translation(if choice == 1 { (grid * 4.0).round() / 4.0 } else { grid })
            .ok();
    }
    let mut random = Seeded(u64::from_le_bytes([bytes[0], bytes[1], bytes[2], 0, 0, 0, 0, 0]));
    Pose::new(DQuat::from_scaled_axis(random.vector() * 3.0), grid).ok()
}

/// One of every kind; those that no way is known of (compounds, meshes, half-spaces) often.
fn shape(source: &mut impl Source) -> Option<Shape> {
    let kind = source.below(16)?;
    let mut random = Seeded(u64::from(source.byte()?));
    let size = 0.15 + 0.5 * random.vector().x.abs();
    let at = |v: DVec3| Pose::from_translation(v).ok();
    let sphere = Shape::sphere(size).ok()?;
    let cube = Shape::cuboid(DVec3::new(size, 0.3, 0.25)).ok()?;
    let hull = |count: usize, random: &mut Seeded| {
        Shape::hull((0..count).map(|_| random.vector() * size).collect()).ok()
    };
    match kind {
        0 => Some(sphere),
        1 => Shape::sphere(1e-4).ok(),
        2 => Some(cube),
        3 => hull(12, &mut random),
        4 => hull(60, &mut random),
        5 => hull(8, &mut random)?.rounded(0.1).ok(),
        6 => Shape::capsule(size, 0.15).ok(),
        7 => Shape::triangle([0, 1, 2].map(|_| random.vector())).ok(),
        8 => Shape::cylinder(size, 0.3).ok(),
        9 => Shape::cone(size, 0.3).ok()?.rounded(0.05).ok(),
        10 | 11 => {
            let parts = [(sphere, at(random.vector() * 0.5)?), (cube, at(random.vector() * 0.5)?)];
            Shape::compound(parts.to_vec()).ok()
        }
        12 => {
            // More than sixteen parts: a second row of boxes.
            let along = |k: usize| Some((cube.clone(), at(DVec3::Y * (0.1 * k as f64))?));
            Shape::compound((0..18).map(along).collect::<Option<_>>()?).ok()
        }
        13 | 14 => {
            let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].map(|v| v * 2.0 * size);
            let faces = vec![[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]];
            Shape::mesh(corners.to_vec(), faces).ok()
        }
        _ => Shape::half_space(random.vector(), -1.5).ok(),
    }
}
