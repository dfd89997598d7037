//! One against many: queries from outside the scene, against static obstacles.

mod checker;
mod culling;
mod decisions;
mod first_hits;
mod link_set;
mod pair_decider;
mod posed_links;
mod rows;
mod set;
mod worker;

pub use checker::{BatchChecker, Hit, Hits, Other};
pub use link_set::LinkSet;
pub use pair_decider::{Candidate, PairDecider};

use dcd_broad::{IdentifiedAabbs, ObstacleBounds, StaticTree};
use dcd_exec::{Exec, Par};
use dcd_geom::{
    Aabb, BoundingSphere, Filter, InscribedSphere, Object, Pose, Scene, SceneError, SphereBounds,
    Splittable,
};
use dcd_gjk::{NarrowPhase, Overlap, Prepared, Sides};
use std::ops::Range;
use std::sync::{Arc, OnceLock};

/// How many obstacles a task prepares.
const OBSTACLES_PER_TASK: usize = 256;

/// Obstacles prepared once: shared by all batch checkers that check against them, on all their threads.
/// A clone is the same world until one of the two is changed; what holds the other keeps the obstacles as they were, a checker until
/// [`BatchChecker::set_world`].
///
/// Where a shape of the caller's own panics while its world changes, and the panic is caught, the world is not whole until another
/// change succeeds: checks against it panic.
///
/// ```
/// use dcd_pipeline::prelude::*;
/// use dcd_pipeline::{LinkSet, StaticWorld};
/// let shelf = Scene::one_each(vec![Shape::cuboid(DVec3::new(1.0, 1.0, 0.1))?], vec![Pose::IDENTITY])?;
/// let world = StaticWorld::new(&shelf, Overlap::default(), Par::Pool)?;
/// // Prepared once; each checker holds the same obstacles.
/// let mut left = world.checker(LinkSet::new(vec![Shape::sphere(0.1)?]))?;
/// let mut right = world.checker(LinkSet::new(vec![Shape::sphere(0.3)?]))?;
/// let pose = [Pose::from_translation(DVec3::Z * 0.35)?];
/// assert!(left.first(&pose, Par::Serial)?[0].is_none());
/// assert!(right.first(&pose, Par::Serial)?[0].is_some());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct StaticWorld<N: NarrowPhase = Overlap>(Arc<Obstacles<N>>);

/// The prepared obstacles of a world.
struct Obstacles<N: NarrowPhase> {
    narrow: N,
    /// The obstacles alone, one after the other.
    scene: Scene,
    frame: N::Frame,
    /// For each obstacle its index in the scene that it came from.
    names: Vec<u32>,
    /// For each obstacle its box, grown as the narrow phase says.
    aabbs: Vec<Aabb>,
    /// Made at the first use.
    search: OnceLock<ObstacleSearch>,
    /// Whether some obstacle has a filter.
    filtered: bool,
    /// Whether the frame and the boxes are those of the scene: not while they are written, nor once a shape has panicked then.
    is_prepared: bool,
}

/// What finds the obstacles near something.
struct ObstacleSearch {
    tree: StaticTree,
    /// For each obstacle its AABB and its sphere, grown as the narrow phase says, and a sphere in it.
    bounds: Vec<ObstacleBounds>,
}

impl ObstacleSearch {
    fn of<N: NarrowPhase>(world: &Obstacles<N>, exec: Exec<'_>) -> Self {
        let mut tree = StaticTree::default();
        let own: Vec<u32> = (0..).take(world.len()).collect();
        tree.build(IdentifiedAabbs { aabbs: &world.aabbs, names: &own }, exec);
        let obstacle = |(i, &aabb): (usize, &Aabb)| {
            let (bound, pose) = (SphereBounds::of(world.scene.shape(i)), &world.scene.poses()[i]);
            let grown = bound.and_then(|bound| Some(bound.swept(world.narrow.aabb_margin()?)));
            ObstacleBounds {
                aabb,
                sphere: grown.map_or(BoundingSphere::EVERYTHING, |grown| grown.sphere(pose)),
                inner: bound.map_or(InscribedSphere::NOTHING, |bound| bound.inner_sphere(pose)),
            }
        };
        Self { tree, bounds: world.aabbs.iter().enumerate().map(obstacle).collect() }
    }
}

impl<N: NarrowPhase> Clone for StaticWorld<N> {
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }
}

impl<N: NarrowPhase> std::fmt::Debug for StaticWorld<N> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("StaticWorld").field("obstacles", &self.0.names).finish_non_exhaustive()
    }
}

impl<N: NarrowPhase> StaticWorld<N> {
    /// Takes all objects of a scene, moving ones and sensors too, at their present poses.
    ///
    /// # Errors
    /// None for a valid scene.
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
        let scene = Scene::new(scene.shapes().to_vec(), objects)?;
        let world = Obstacles::new(scene, names, narrow, exec);
        world.search.get_or_init(|| ObstacleSearch::of(&world, exec));
        Ok(Self(Arc::new(world)))
    }

    /// From objects that follow each other in a scene, by their places among these, for a [`PairDecider`], which
    /// searches nothing: the tree is made once a checker needs it.
    ///
    /// # Errors
    /// The first of them that is not there.
    pub fn for_pairs(scene: &Scene, objects: Range<usize>, narrow: N) -> Result<Self, SceneError> {
        check_are_there(scene, objects.clone())?;
        let shapes = objects.clone().map(|i| scene.shape(i).clone()).collect();
        let names: Vec<u32> = (0..).take(objects.len()).collect();
        let objects = names.iter().zip(objects).map(|(&shape, i)| Object {
            filter: scene.filters()[i],
            ..Object::new(shape, scene.poses()[i])
        });
        let scene = Scene::new(shapes, objects)?;
        Ok(Self(Arc::new(Obstacles::new(scene, names, narrow, Exec::from(Par::Serial)))))
    }

    /// Takes other objects, as [`StaticWorld::for_pairs`] does: in the memory of those before, where no clone and
    /// no checker holds them too.
    ///
    /// # Errors
    /// Those of [`StaticWorld::for_pairs`]; nothing is changed then.
    pub fn replace_for_pairs(
        &mut self,
        scene: &Scene,
        objects: Range<usize>,
    ) -> Result<(), SceneError>
    where
        N: Clone,
    {
        match Arc::get_mut(&mut self.0) {
            Some(obstacles) => obstacles.replace(scene, objects),
            None => {
                *self = Self::for_pairs(scene, objects, self.0.narrow.clone())?;
                Ok(())
            }
        }
    }

    /// Moves an object, by its place among those that the world was made of. Where a clone or a checker holds the world too, all of
    /// it is made anew, and that one keeps the objects as they were.
    ///
    /// # Errors
    /// There is no such object, or it would be out of range; nothing is changed then.
    pub fn set_pose(&mut self, object: usize, pose: Pose) -> Result<(), SceneError>
    where
        N: Clone,
    {
        if let Some(obstacles) = Arc::get_mut(&mut self.0) {
            return obstacles.set_pose(object, pose);
        }
        let Obstacles { scene, names, narrow, .. } = &*self.0;
        let mut scene = scene.clone();
        scene.set_pose(object, pose)?;
        let exec = Exec::from(Par::Serial);
        *self = Self(Arc::new(Obstacles::new(scene, names.clone(), narrow.clone(), exec)));
        Ok(())
    }

    /// Ready to check configurations of these links, again and again.
    ///
    /// # Errors
    /// More shapes or objects than a u32 counts: a batch checker holds up to 512 objects for each link. A link that
    /// is out of range without being moved, by its number.
    pub fn checker(&self, link_set: LinkSet) -> Result<BatchChecker<N>, SceneError> {
        BatchChecker::new(self.clone(), link_set)
    }
}

/// Refuses the first of some slots of a scene that holds no object.
fn check_are_there(scene: &Scene, mut objects: Range<usize>) -> Result<(), SceneError> {
    match objects.find(|&i| scene.motion(i).is_none()) {
        Some(object) => Err(SceneError::NoSuchObject { object, objects: scene.len() }),
        None => Ok(()),
    }
}

impl<N: NarrowPhase> Obstacles<N> {
    fn new(scene: Scene, names: Vec<u32>, narrow: N, exec: Exec<'_>) -> Self {
        let (frame, search) = (N::Frame::default(), OnceLock::new());
        let aabbs = Vec::new();
        let (filtered, is_prepared) = (false, false);
        let mut new = Self { narrow, scene, frame, names, aabbs, search, filtered, is_prepared };
        new.prepare(exec);
        new
    }

    /// Prepares all objects of the scene.
    fn prepare(&mut self, exec: Exec<'_>) {
        self.is_prepared = false;
        let Self { narrow, scene, frame, aabbs, .. } = self;
        aabbs.resize(scene.len(), Aabb::EMPTY);
        let part = narrow.layout(scene, Sides::Two, frame);
        exec.divide((part, &mut aabbs[..]), OBSTACLES_PER_TASK, |first, (part, aabbs)| {
            narrow.prepare(scene, first, part, aabbs);
        });
        self.filtered = scene.filters().iter().any(|filter| *filter != Filter::ALL);
        self.is_prepared = true;
    }

    /// Takes other objects in place of these.
    fn replace(&mut self, scene: &Scene, objects: Range<usize>) -> Result<(), SceneError> {
        check_are_there(scene, objects.clone())?;
        let placed = objects.clone().map(|i| {
            let object = Object::new(0, scene.poses()[i]);
            (scene.shape(i), Object { filter: scene.filters()[i], ..object })
        });
        self.scene.replace_from(0, placed)?;
        self.is_prepared = false;
        self.names.clear();
        self.names.extend((0..).take(objects.len()));
        self.search = OnceLock::new();
        self.prepare(Exec::from(Par::Serial));
        Ok(())
    }

    fn set_pose(&mut self, object: usize, pose: Pose) -> Result<(), SceneError> {
        self.scene.set_pose(object, pose)?;
        let were_prepared = std::mem::replace(&mut self.is_prepared, false);
        self.search = OnceLock::new();
        if were_prepared {
            let Self { narrow, scene, frame, aabbs, .. } = self;
            let part = narrow.layout(scene, Sides::Two, frame);
            if narrow.keeps(&part) {
                let (part, _) = part.split_at(object).1.split_at(1);
                narrow.prepare(scene, object, part, &mut aabbs[object..=object]);
                self.is_prepared = true;
                return Ok(());
            }
        }
        self.prepare(Exec::from(Par::Serial));
        Ok(())
    }

    fn search(&self) -> &ObstacleSearch {
        self.check_is_prepared();
        self.search.get_or_init(|| ObstacleSearch::of(self, Exec::from(Par::Serial)))
    }

    fn len(&self) -> usize {
        self.names.len()
    }

    /// Panics where another answer would be about poses that are none of the scene's.
    fn check_is_prepared(&self) {
        assert!(self.is_prepared, "a shape panicked while the obstacles were prepared");
    }

    fn prepared(&self) -> Prepared<'_, N::Frame> {
        self.check_is_prepared();
        Prepared { scene: &self.scene, frame: &self.frame }
    }

    /// The largest finite coordinate of an obstacle, metres.
    fn farthest(&self) -> f64 {
        let farthest =
            |&Aabb { min, max }: &Aabb| f64::from(min.abs().max(max.abs()).max_element());
        let ends = |&farthest: &f64| farthest < 0.1 * Aabb::LIMIT;
        self.aabbs.iter().map(farthest).filter(ends).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dcd_geom::{Shape, glam::DVec3};

    fn at(x: f64) -> Pose {
        Pose::from_translation(DVec3::X * x).unwrap()
    }

    /// Unit cubes at these places.
    fn scene(places: &[f64]) -> Scene {
        let cube = Shape::cuboid(DVec3::splat(0.5)).unwrap();
        let poses: Vec<Pose> = places.iter().map(|&x| at(x)).collect();
        Scene::one_each(vec![cube; poses.len()], poses).unwrap()
    }

    /// The obstacles that a small sphere at each place touches.
    fn touched(world: &StaticWorld, places: &[f64]) -> Vec<Vec<u32>> {
        let links = LinkSet::new(vec![Shape::sphere(0.1).unwrap()]);
        let decider = PairDecider::new(links, 1).unwrap();
        let other = (0..world.0.len() as u32).map(Other::Obstacle);
        let candidates: Vec<Candidate> =
            other.map(|other| Candidate { configuration: 0, link: 0, other }).collect();
        let touched = places.iter().map(|&x| {
            let mut found = Vec::new();
            let hit = |hit: Hit<()>| match hit.other {
                Other::Obstacle(name) => found.push(name),
                Other::Link(_) => panic!("one link meets itself"),
            };
            decider.decide(world, &candidates, |_, _| at(x), hit).unwrap();
            found.sort_unstable();
            found
        });
        touched.collect()
    }

    #[test]
    fn an_exchanged_or_moved_world_answers_as_one_made_anew() {
        let probes: Vec<f64> = (0..12).map(f64::from).collect();
        let anew = |places: &[f64]| {
            StaticWorld::for_pairs(&scene(places), 0..places.len(), Overlap::default()).unwrap()
        };
        let mut world = anew(&[0.0, 2.0]);
        for places in [&[1.0, 5.0, 9.0][..], &[4.0], &[], &[3.0, 3.2, 8.0, 6.0]] {
            world.replace_for_pairs(&scene(places), 0..places.len()).unwrap();
            assert_eq!(touched(&world, &probes), touched(&anew(places), &probes));
        }
        world.set_pose(1, at(10.0)).unwrap();
        let moved = [3.0, 10.0, 8.0, 6.0];
        assert_eq!(touched(&world, &probes), touched(&anew(&moved), &probes));
        assert_eq!(touched(&world, &[10.0]), [[1]]);
        assert!(world.set_pose(4, at(0.0)).is_err() && world.set_pose(0, at(1e300)).is_err());
        // None of a slot that is free, or not there.
        let mut few = scene(&[0.0, 1.0, 2.0]);
        let freed = few.handle(1).unwrap();
        few.remove(freed).unwrap();
        for (objects, object) in [(0..3, 1), (2..4, 3), (7..9, 7)] {
            let missing = SceneError::NoSuchObject { object, objects: 3 };
            let made = StaticWorld::for_pairs(&few, objects.clone(), Overlap::default());
            assert_eq!(made.err(), Some(missing));
            assert_eq!(world.replace_for_pairs(&few, objects), Err(missing));
        }
        assert_eq!(touched(&world, &probes), touched(&anew(&moved), &probes));
        // A world that is held twice stays for the other.
        let mut other = world.clone();
        other.set_pose(0, at(1.0)).unwrap();
        assert_eq!(touched(&other, &[1.0, 3.0, 10.0]), [vec![0], vec![], vec![1]]);
        assert_eq!(touched(&world, &probes), touched(&anew(&moved), &probes));
        assert!(other.clone().set_pose(4, at(0.0)).is_err());
        other.replace_for_pairs(&scene(&[1.0]), 0..1).unwrap();
        assert_eq!(touched(&world, &probes), touched(&anew(&moved), &probes));
        assert_eq!(touched(&other, &[1.0, 3.0]), [vec![0], vec![]]);
    }
}
