//! Shapes and the objects that place them.

use crate::{Aabb, Cores, Pose, SceneError, Shape};
use std::sync::Arc;

/// Which objects may pair: each is a member of some groups and asks for some groups.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Filter {
    /// The groups it is in, one bit each.
    pub groups: u32,
    /// The groups it can touch.
    pub mask: u32,
}

impl Filter {
    /// In every group, touching every group: what an object has unless said otherwise.
    pub const ALL: Self = Self { groups: u32::MAX, mask: u32::MAX };

    /// Whether each asks for a group of the other.
    #[inline]
    pub fn allows(self, other: Self) -> bool {
        self.groups & other.mask != 0 && other.groups & self.mask != 0
    }
}

impl Default for Filter {
    fn default() -> Self {
        Self::ALL
    }
}

/// A shape somewhere.
#[derive(Clone, Copy, Debug)]
pub struct Object {
    /// The shape's index in the scene.
    pub shape: u32,
    /// Where it is.
    pub pose: Pose,
    /// What it may pair with.
    pub filter: Filter,
}

/// Shapes, and objects that place them: the input of a step, valid by construction.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    shapes: Arc<[Shape]>,
    cores: Cores,
    shape_of: Vec<u32>,
    poses: Vec<Pose>,
    filters: Vec<Filter>,
    filtered: bool,
}

impl Scene {
    /// Shapes, shared by the objects that name them.
    ///
    /// # Errors
    /// An object whose shape does not exist or that reaches beyond [`Aabb::LIMIT`]; more shapes or
    /// objects than a u32 counts.
    pub fn new(
        shapes: Vec<Shape>,
        objects: impl IntoIterator<Item = Object>,
    ) -> Result<Self, SceneError> {
        check_count("shapes", shapes.len())?;
        let polytopes = shapes.iter().filter_map(Shape::as_polytope);
        let (what, count) = ("blocks of vertices", polytopes.map(|p| p.block_count()).sum());
        let cores = Cores::of(&shapes).ok_or(SceneError::TooMany { what, count })?;
        let mut scene = Self { shapes: shapes.into(), cores, ..Self::default() };
        for (object, Object { shape, pose, filter }) in objects.into_iter().enumerate() {
            check_count("objects", object)?;
            let shapes = scene.shapes.len();
            let known = scene.shapes.get(shape as usize);
            let known = known.ok_or(SceneError::NoSuchShape { object, shape, shapes })?;
            check_reach(object, known, &pose)?;
            scene.shape_of.push(shape);
            scene.poses.push(pose);
            scene.filters.push(filter);
            scene.filtered |= filter != Filter::ALL;
        }
        Ok(scene)
    }

    /// One object for each shape, in order, as in the paper's scenes.
    ///
    /// # Errors
    /// Those of [`Scene::new`], and lengths that differ.
    pub fn one_each(shapes: Vec<Shape>, poses: Vec<Pose>) -> Result<Self, SceneError> {
        if shapes.len() != poses.len() {
            return Err(SceneError::LengthsDiffer { shapes: shapes.len(), poses: poses.len() });
        }
        let filter = Filter::ALL;
        let objects = (0u32..).zip(poses).map(|(shape, pose)| Object { shape, pose, filter });
        Self::new(shapes, objects)
    }

    /// Moves object `i`.
    ///
    /// # Errors
    /// There is no such object, or it would reach beyond [`Aabb::LIMIT`]; nothing is changed then.
    pub fn set_pose(&mut self, i: usize, pose: Pose) -> Result<(), SceneError> {
        let objects = self.len();
        let Some(slot) = self.poses.get_mut(i) else {
            return Err(SceneError::NoSuchObject { object: i, objects });
        };
        check_reach(i, &self.shapes[self.shape_of[i] as usize], &pose)?;
        *slot = pose;
        Ok(())
    }

    /// How many objects there are.
    pub fn len(&self) -> usize {
        self.poses.len()
    }

    /// Whether there is no object.
    pub fn is_empty(&self) -> bool {
        self.poses.is_empty()
    }

    /// The shapes.
    pub fn shapes(&self) -> &[Shape] {
        &self.shapes
    }

    /// The shapes, to be kept: whoever derives something from them can tell by `Arc::ptr_eq` that
    /// it is still of this scene.
    pub fn shared_shapes(&self) -> &Arc<[Shape]> {
        &self.shapes
    }

    /// What the lanes read of the shapes.
    pub fn cores(&self) -> &Cores {
        &self.cores
    }

    /// For each object its shape's index.
    pub fn shape_of(&self) -> &[u32] {
        &self.shape_of
    }

    /// For each object its pose.
    pub fn poses(&self) -> &[Pose] {
        &self.poses
    }

    /// For each object its filter.
    pub fn filters(&self) -> &[Filter] {
        &self.filters
    }

    /// The shape of object `i`, which must be below [`Scene::len`].
    #[inline]
    pub fn shape(&self, i: usize) -> &Shape {
        &self.shapes[self.shape_of[i] as usize]
    }

    /// Whether any object's filter is other than [`Filter::ALL`], so that pairs must be asked.
    pub fn is_filtered(&self) -> bool {
        self.filtered
    }

    /// Whether the filters of two objects let them pair.
    #[inline]
    pub fn allows(&self, i: u32, j: u32) -> bool {
        self.filters[i as usize].allows(self.filters[j as usize])
    }

    /// The box of object `i`: see [`Shape::aabb`].
    pub fn aabb(&self, i: usize) -> Aabb {
        self.shape(i).aabb(&self.poses[i])
    }
}

/// That a scene may have this many of something.
fn check_count(what: &'static str, count: usize) -> Result<(), SceneError> {
    if u32::try_from(count).is_ok() { Ok(()) } else { Err(SceneError::TooMany { what, count }) }
}

fn check_reach(object: usize, shape: &Shape, pose: &Pose) -> Result<(), SceneError> {
    let reach = pose.translation().abs().max_element() + shape.reach() * (1.0 + pose.deviation());
    // Written so that NaN is refused.
    if reach <= Aabb::LIMIT { Ok(()) } else { Err(SceneError::OutOfRange { object, reach }) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn ball() -> Shape {
        Shape::sphere(1.0).unwrap()
    }

    #[test]
    fn lengths_that_differ_are_refused_with_both() {
        let refused = Scene::one_each(vec![ball()], vec![]).unwrap_err();
        assert_eq!(refused, SceneError::LengthsDiffer { shapes: 1, poses: 0 });
    }

    #[test]
    fn an_unknown_shape_is_refused_with_the_object() {
        let object = |shape| Object { shape, pose: Pose::IDENTITY, filter: Filter::ALL };
        let refused = Scene::new(vec![ball()], [object(0), object(7)]).unwrap_err();
        assert_eq!(refused, SceneError::NoSuchShape { object: 1, shape: 7, shapes: 1 });
    }

    #[test]
    fn an_object_out_of_range_is_refused_and_set_pose_leaves_the_scene_alone() {
        let far = Pose::from_translation(DVec3::new(0.0, 1e38, 0.0)).unwrap();
        let refused = Scene::one_each(vec![ball()], vec![far]).unwrap_err();
        assert!(matches!(refused, SceneError::OutOfRange { object: 0, reach } if reach >= 1e38));
        let mut scene = Scene::one_each(vec![ball()], vec![Pose::IDENTITY]).unwrap();
        assert!(scene.set_pose(0, far).is_err());
        assert_eq!(scene.poses()[0], Pose::IDENTITY);
        let missing = SceneError::NoSuchObject { object: 1, objects: 1 };
        assert_eq!(scene.set_pose(1, Pose::IDENTITY), Err(missing));
    }

    #[test]
    fn a_count_past_u32_is_refused() {
        assert!(check_count("objects", u32::MAX as usize).is_ok());
        let count = u32::MAX as usize + 1;
        assert_eq!(
            check_count("objects", count),
            Err(SceneError::TooMany { what: "objects", count })
        );
    }

    #[test]
    fn an_empty_scene_is_legal() {
        assert!(Scene::one_each(vec![], vec![]).unwrap().is_empty());
    }

    #[test]
    fn filters_must_agree_both_ways() {
        let robot = Filter { groups: 1, mask: 2 };
        let world = Filter { groups: 2, mask: 1 };
        assert!(robot.allows(world) && world.allows(robot));
        assert!(!robot.allows(robot) && !world.allows(Filter { groups: 1, mask: 0 }));
    }
}
