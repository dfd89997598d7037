//! Queries of a scene on the trees of the last step.

mod casts;
mod impacts;
mod nearest;
mod order;
mod rays;
mod regions;

pub use casts::ObjectImpact;
use dcd_broad::StaticTree;
use dcd_bvh::WideBvh;
use dcd_geom::glam::DVec3;
use dcd_geom::{Aabb, Filter, Motion, Scene};
use dcd_simd::{Aabb16, ArrayVec, BoxTest, Kernel, Lanes, Row, WIDTH, dispatch};
pub use impacts::{Impacts, PairImpact, Velocity};
pub use nearest::NearestObject;
pub use rays::ObjectHit;
pub use regions::{Found, RegionError};
use std::cmp::Ordering;
use std::fmt;

/// Why a scene cannot be queried.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum QueryError {
    /// The pipeline has not taken a step.
    NoStep,
    /// The scene is not what it was at the last step.
    SceneChanged,
    /// A number that has to be finite, and at least 0 where it is a length or a time, is not.
    BadNumber {
        /// Which: "point", "distance", "time", "tolerance", "velocity", "centre".
        what: &'static str,
        /// Of which of those that were given.
        index: usize,
        /// What was given.
        value: f64,
    },
    /// There is not one velocity for each slot.
    LengthsDiffer {
        /// How many velocities.
        given: usize,
        /// How many slots.
        slots: usize,
    },
}

fn check_length(what: &'static str, value: f64) -> Result<(), QueryError> {
    // Written so that NaN is refused.
    if value >= 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(QueryError::BadNumber { what, index: 0, value })
    }
}

fn check_finite(what: &'static str, index: usize, v: DVec3) -> Result<(), QueryError> {
    match v.to_array().into_iter().find(|x| !(x.abs() <= Aabb::LIMIT)) {
        Some(value) => Err(QueryError::BadNumber { what, index, value }),
        None => Ok(()),
    }
}

impl fmt::Display for QueryError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoStep => f.write_str("the pipeline has taken no step to query"),
            Self::SceneChanged => {
                f.write_str("the scene has changed since the last step: step it again first")
            }
            Self::BadNumber { what, index, value } => {
                write!(f, "{what} {index} holds {value:e}, out of range")
            }
            Self::LengthsDiffer { given, slots } => {
                write!(f, "{given} velocities for a scene of {slots} slots")
            }
        }
    }
}

impl std::error::Error for QueryError {}

/// Whether a query sees sensors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SensorChoice {
    /// Solid objects alone.
    #[default]
    Solid,
    /// Sensors alone.
    Sensors,
    /// Both.
    All,
}

/// Which objects a query sees: those whose filter agrees with its own, by sensor, and by a predicate.
#[derive(Clone, Copy, Default)]
pub struct QueryFilter<'f> {
    /// The groups that the query is in and those that it can meet.
    pub filter: Filter,
    /// Whether it sees sensors.
    pub sensors: SensorChoice,
    /// Static or moving objects alone, if said.
    pub motion: Option<Motion>,
    /// Called last, with an object's index; perhaps on many threads. Must return the same for one object in one query.
    pub may: Option<&'f (dyn Fn(u32) -> bool + Sync)>,
}

impl fmt::Debug for QueryFilter<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { filter, sensors, motion, .. } = self;
        write!(f, "QueryFilter {{ {filter:?}, {sensors:?}, {motion:?} }}")
    }
}

impl<'f> QueryFilter<'f> {
    /// Every solid object.
    pub const ALL: Self =
        Self { filter: Filter::ALL, sensors: SensorChoice::Solid, motion: None, may: None };

    /// The same with a predicate.
    pub fn with_predicate(self, may: &'f (dyn Fn(u32) -> bool + Sync)) -> Self {
        Self { may: Some(may), ..self }
    }

    /// Whether the query sees that object of the scene.
    #[inline]
    fn sees(&self, scene: &Scene, object: u32) -> bool {
        let i = object as usize;
        let is_wanted = match self.sensors {
            SensorChoice::All => true,
            SensorChoice::Solid => !scene.sensors()[i],
            SensorChoice::Sensors => scene.sensors()[i],
        };
        is_wanted
            && self.filter.allows(scene.filters()[i])
            && self.motion.is_none_or(|motion| scene.motion(i) == Some(motion))
            && self.may.is_none_or(|may| may(object))
    }
}

/// How many boxes a query begins in, in most scenes where it begins in any; more take a second allocation.
const MET_FIRST: usize = 64;

/// Of how many objects all boxes are looked at once, whichever of them may be met. No effect on any answer. Larger: objects in a
/// list that an earlier hit would have left out.
const FEW: usize = WIDTH;

/// A search that ends with the first or nearest object.
trait Search {
    /// Takes in what an object says. Returns whether it is met where the query begins.
    fn meet(&mut self, object: u32) -> bool;

    /// The key of what is known to be enough: an object whose box has a greater one is not met.
    fn limit(&self) -> f32;
}

/// The trees of a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Trees<'a> {
    /// Of the moving objects, if the broad phase has one.
    pub(crate) movers: Option<&'a WideBvh>,
    /// Their slots as it numbers them, where they are not its numbers.
    pub(crate) mover_slots: Option<&'a [u32]>,
    /// Of the static objects, and their slots.
    pub(crate) statics: (&'a StaticTree, &'a [u32]),
}

/// A scene and the AABBs and trees of the last step: see [`crate::Pipeline::queries`]. Cheap to copy; a query
/// changes nothing, and any number may run at once.
///
/// Answers are proved as far as they say so: an object that is not in an answer has been proved not to belong there,
/// but for what a filter left out. They depend on the scene and the query, not on threads. Coordinates are metres
/// of the world; space ends at ±[`Aabb::LIMIT`].
///
/// ```
/// use dcd_pipeline::prelude::*;
/// let poses = [0.0, 0.9, 2.1].map(|x| Pose::from_translation(DVec3::X * x));
/// let poses = poses.into_iter().collect::<Result<Vec<_>, _>>()?;
/// let scene = Scene::one_each(vec![Shape::sphere(0.5)?; 3], poses)?;
/// use dcd_pipeline::{QueryFilter, Ray};
/// let mut pipeline = Pipeline::new();
/// pipeline.step(&scene, Par::Serial);
/// let queries = pipeline.queries(&scene)?;
/// let ray = Ray::new(DVec3::new(5.0, 0.0, 0.0), -DVec3::X, 10.0)?;
/// let hit = queries.first_hit(&ray, &QueryFilter::ALL).ok_or("a hit")?;
/// assert_eq!(hit.object, 2);
/// assert!(hit.hit.t_lower <= 2.4 && 2.4 <= hit.hit.t_upper);
/// let nearest = queries.nearest(DVec3::new(-1.0, 0.0, 0.0), f64::INFINITY, &QueryFilter::ALL)?;
/// assert_eq!(nearest.map(|near| near.object), Some(0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Queries<'a> {
    scene: &'a Scene,
    aabbs: &'a [Aabb],
    trees: Trees<'a>,
}

impl<'a> Queries<'a> {
    pub(crate) fn new(scene: &'a Scene, aabbs: &'a [Aabb], trees: Trees<'a>) -> Self {
        Self { scene, aabbs, trees }
    }

    /// The scene.
    pub fn scene(&self) -> &'a Scene {
        self.scene
    }

    /// Has a search meet the objects whose boxes have a key of 0, ascending, for these may be met where the query begins. Of
    /// what is met there the least object counts, so that the first of these that is ends it. If none is it meets the others
    /// whose boxes have a key of at most its limit: the static ones, then the moving ones, nearer nodes first.
    fn meet_nearest(&self, test: &impl BoxTest, search: &mut impl Search) {
        if self.scene.len() <= FEW {
            return self.meet_nearest_of_few(test, search);
        }
        if self.met_first(test).into_iter().any(|object| search.meet(object)) {
            return;
        }
        self.visit(test, search.limit(), &mut |object, key| {
            if key > 0.0 {
                search.meet(object);
            }
            search.limit()
        });
    }

    /// The same of at most [`FEW`] objects: their boxes are looked at once.
    fn meet_nearest_of_few(&self, test: &impl BoxTest, search: &mut impl Search) {
        let (mut near, limit) = (ArrayVec::<(u32, f32), FEW>::new(), search.limit());
        self.visit(test, limit, &mut |object, key| {
            near.push((object, key));
            limit
        });
        let is_later = |key: f32| key > 0.0;
        // Stable: the later ones stay in their order.
        near.sort_by(|&(object, key), &(other, beside)| {
            let of_first = if is_later(key) { Ordering::Equal } else { object.cmp(&other) };
            is_later(key).cmp(&is_later(beside)).then(of_first)
        });
        for &(object, key) in &*near {
            let is_met = key <= search.limit() && search.meet(object);
            if is_met && !is_later(key) {
                return;
            }
        }
    }

    /// The objects whose boxes have a key of 0, ascending.
    fn met_first(&self, test: &impl BoxTest) -> Vec<u32> {
        let mut objects = Vec::new();
        self.visit(test, 0.0, &mut |object, _| {
            if objects.is_empty() {
                objects.reserve(MET_FIRST);
            }
            objects.push(object);
            0.0
        });
        objects.sort_unstable();
        objects
    }

    /// Calls `visit(object, key)` for each object whose box has a key of at most the limit: the static ones, then
    /// the moving ones, nearer nodes first. Takes what it returns for the limit from then on.
    fn visit(&self, test: &impl BoxTest, limit: f32, visit: &mut dyn FnMut(u32, f32) -> f32) {
        // An infinite key is that of what cannot be an answer.
        let mut limit = limit.min(f32::MAX);
        let (statics, slots) = self.trees.statics;
        if !slots.is_empty() {
            statics.tree().visit(test, limit, &mut |k, key| {
                limit = visit(slots[k as usize], key).min(f32::MAX);
                limit
            });
        }
        let slot = |k: u32| self.trees.mover_slots.map_or(k, |slots| slots[k as usize]);
        match self.trees.movers {
            Some(tree) => tree.visit(test, limit, &mut |k, key| visit(slot(k), key)),
            None => {
                let count = self.trees.mover_slots.map_or(self.aabbs.len(), <[u32]>::len);
                for first in (0..count).step_by(WIDTH) {
                    let slots: [u32; WIDTH] = std::array::from_fn(|k| {
                        if first + k < count { slot((first + k) as u32) } else { 0 }
                    });
                    let mut boxes = Aabb16::EMPTY;
                    for (k, &slot) in slots.iter().enumerate().take(count - first) {
                        boxes.set(k, &self.aabbs[slot as usize]);
                    }
                    let keys = dispatch(Keys { test, boxes: &boxes });
                    for (key, &slot) in keys.0.iter().zip(&slots) {
                        if *key <= limit {
                            limit = visit(slot, *key).min(f32::MAX);
                        }
                    }
                }
            }
        }
    }
}

/// Sixteen boxes without a tree.
struct Keys<'a, T> {
    test: &'a T,
    boxes: &'a Aabb16,
}

impl<T: BoxTest> Kernel for Keys<'_, T> {
    type Output = Row;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Row {
        let mut keys = Row::default();
        l.store(self.test.keys(l, self.boxes), &mut keys);
        keys
    }
}
