//! One against many: what does not enter the scene, against obstacles that stand still.

mod desk;
mod first;
mod linkage;
mod outlook;
mod probe;
mod set;

pub use linkage::Linkage;
pub use probe::{Finding, Found, Other, Probe};

use dcd_broad::{Named, Outline, StandingTree};
use dcd_exec::Exec;
use dcd_geom::{Aabb, Bound, LooseBall, Object, Scene, SceneError, SnugBall};
use dcd_gjk::{NarrowPhase, Overlap};

/// How many obstacles a task prepares.
const OBSTACLES_PER_TASK: usize = 256;

/// Obstacles prepared once: their boxes and a tree over them. Asked by a [`Probe`].
#[derive(Debug)]
pub struct World<N = Overlap> {
    narrow: N,
    /// The obstacles alone, one after the other.
    obstacles: Scene,
    /// For each obstacle its index in the scene that it came from.
    names: Vec<u32>,
    tree: StandingTree,
    /// For each obstacle its box and its ball, grown as the narrow phase says, and a ball in it.
    outlines: Vec<Outline>,
}

impl<N: NarrowPhase> World<N> {
    /// From the objects of a scene, moving ones too, as they stand.
    ///
    /// # Errors
    /// None that the scene has not passed already.
    pub fn new<'e>(
        scene: &Scene,
        narrow: N,
        exec: impl Into<Exec<'e>>,
    ) -> Result<Self, SceneError> {
        let exec = exec.into();
        let there = |&i: &u32| scene.motion(i as usize).is_some();
        let names: Vec<u32> = (0..).take(scene.len()).filter(there).collect();
        let objects = names.iter().map(|&i| i as usize).map(|i| Object {
            filter: scene.filters()[i],
            ..Object::new(scene.shape_of()[i], scene.poses()[i])
        });
        let obstacles = Scene::new(scene.shapes().to_vec(), objects)?;
        let mut aabbs = vec![Aabb::EMPTY; obstacles.len()];
        let mut frame = N::Frame::default();
        let part = narrow.lay_out(&obstacles, &mut frame);
        exec.divide((part, &mut aabbs[..]), OBSTACLES_PER_TASK, |first, (part, aabbs)| {
            narrow.prepare(&obstacles, first, part, aabbs);
        });
        let mut tree = StandingTree::default();
        let own: Vec<u32> = (0..).take(aabbs.len()).collect();
        tree.build(Named { aabbs: &aabbs, names: &own }, exec);
        let outline = |(i, &aabb): (usize, &Aabb)| {
            let (bound, pose) = (Bound::of(obstacles.shape(i)), &obstacles.poses()[i]);
            let grown = bound.and_then(|bound| Some(bound.swept(narrow.growth()?)));
            Outline {
                aabb,
                ball: grown.map_or(LooseBall::EVERYTHING, |grown| grown.ball(pose)),
                inner: bound.map_or(SnugBall::NOTHING, |bound| bound.inner_ball(pose)),
            }
        };
        let outlines = aabbs.iter().enumerate().map(outline).collect();
        Ok(Self { narrow, obstacles, names, tree, outlines })
    }

    /// Beyond which coordinate there is nothing, but for what has no end, metres.
    fn farthest(&self) -> f64 {
        let farthest = |outline: &Outline| {
            let Aabb { min, max } = outline.aabb;
            f64::from(min.abs().max(max.abs()).max_element())
        };
        let ends = |&farthest: &f64| farthest < 0.1 * Aabb::LIMIT;
        self.outlines.iter().map(farthest).filter(ends).fold(0.0, f64::max)
    }

    /// Ready to ask for configurations of these links, again and again.
    ///
    /// # Errors
    /// More shapes or objects than a u32 counts: a probe holds 128 objects for each link. A link that
    /// is out of range without being moved, by its number.
    pub fn probe(&self, linkage: Linkage) -> Result<Probe<'_, N>, SceneError> {
        Probe::new(self, linkage)
    }
}
