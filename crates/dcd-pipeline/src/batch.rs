//! One against many: what does not enter the scene, against obstacles that stand still.

mod checker;
mod culling;
mod first_hits;
mod link_set;
mod set;
mod worker;

pub use checker::{BatchChecker, Hit, Hits, Other};
pub use link_set::LinkSet;

use dcd_broad::{IdentifiedAabbs, ObstacleBounds, StaticTree};
use dcd_exec::Exec;
use dcd_geom::{Aabb, BoundingSphere, InscribedSphere, Object, Scene, SceneError, SphereBounds};
use dcd_gjk::{NarrowPhase, Overlap};

/// How many obstacles a task prepares.
const OBSTACLES_PER_TASK: usize = 256;

/// Obstacles prepared once: their boxes and a tree over them. Asked by a [`BatchChecker`].
#[derive(Debug)]
pub struct StaticWorld<N = Overlap> {
    narrow: N,
    /// The obstacles alone, one after the other.
    obstacles: Scene,
    /// For each obstacle its index in the scene that it came from.
    names: Vec<u32>,
    tree: StaticTree,
    /// For each obstacle its box and its sphere, grown as the narrow phase says, and a sphere in it.
    obstacle_bounds: Vec<ObstacleBounds>,
}

impl<N: NarrowPhase> StaticWorld<N> {
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
        let part = narrow.layout(&obstacles, &mut frame);
        exec.divide((part, &mut aabbs[..]), OBSTACLES_PER_TASK, |first_hits, (part, aabbs)| {
            narrow.prepare(&obstacles, first_hits, part, aabbs);
        });
        let mut tree = StaticTree::default();
        let own: Vec<u32> = (0..).take(aabbs.len()).collect();
        tree.build(IdentifiedAabbs { aabbs: &aabbs, names: &own }, exec);
        let obstacle = |(i, &aabb): (usize, &Aabb)| {
            let (bound, pose) = (SphereBounds::of(obstacles.shape(i)), &obstacles.poses()[i]);
            let grown = bound.and_then(|bound| Some(bound.swept(narrow.aabb_margin()?)));
            ObstacleBounds {
                aabb,
                sphere: grown.map_or(BoundingSphere::EVERYTHING, |grown| grown.sphere(pose)),
                inner: bound.map_or(InscribedSphere::NOTHING, |bound| bound.inner_sphere(pose)),
            }
        };
        let obstacle_bounds = aabbs.iter().enumerate().map(obstacle).collect();
        Ok(Self { narrow, obstacles, names, tree, obstacle_bounds })
    }

    /// Beyond which coordinate there is nothing, but for what has no end, metres.
    fn farthest(&self) -> f64 {
        let farthest = |obstacle: &ObstacleBounds| {
            let Aabb { min, max } = obstacle.aabb;
            f64::from(min.abs().max(max.abs()).max_element())
        };
        let ends = |&farthest: &f64| farthest < 0.1 * Aabb::LIMIT;
        self.obstacle_bounds.iter().map(farthest).filter(ends).fold(0.0, f64::max)
    }

    /// Ready to ask for configurations of these links, again and again.
    ///
    /// # Errors
    /// More shapes or objects than a u32 counts: a batch checker holds up to 512 objects for each link. A link that
    /// is out of range without being moved, by its number.
    pub fn checker(&self, link_set: LinkSet) -> Result<BatchChecker<'_, N>, SceneError> {
        BatchChecker::new(self, link_set)
    }
}
