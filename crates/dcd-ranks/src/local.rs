//! What one rank has: the objects that it owns, and ghosts.

use crate::share::Bounds;
use crate::{Cuts, RankError};
use dcd_exec::Exec;
use dcd_geom::{Aabb, Object, Pose, Scene, Shape};
use std::collections::HashMap;
use std::ops::Range;

/// What a slot of the scene holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Role {
    Free,
    /// Owned; whether its box lies in the rank's region with both ends.
    Owned {
        inside: bool,
    },
    /// Owned by another; when it was last heard of.
    Ghost {
        heard: u64,
    },
}

/// An ordinary scene, and what its objects are called.
#[derive(Debug, Default)]
pub(crate) struct Local {
    scene: Scene,
    /// By slot.
    names: Vec<u64>,
    roles: Vec<Role>,
    boxes: Vec<Aabb>,
    /// By name.
    slots: HashMap<u64, u32>,
    owned: usize,
    ghosts: usize,
    shapes: Shapes,
}

/// What is known of the scene's shapes.
#[derive(Debug, Default)]
struct Shapes {
    by_name: HashMap<u64, u32>,
    names: Vec<u64>,
    bounds: Vec<Bounds>,
    /// How many slots have it.
    uses: Vec<u32>,
    unused: usize,
}

/// A scene of shapes that nobody has any more is made anew when these are more than half of all, and more
/// than so many.
const UNUSED: usize = 4096;

/// Slots that a task looks at.
const SLOTS_A_TASK: usize = 4096;

impl Local {
    pub(crate) fn scene(&self) -> &Scene {
        &self.scene
    }

    pub(crate) fn names(&self) -> &[u64] {
        &self.names
    }

    pub(crate) fn roles(&self) -> &[Role] {
        &self.roles
    }

    pub(crate) fn boxes(&self) -> &[Aabb] {
        &self.boxes
    }

    pub(crate) fn owned_count(&self) -> usize {
        self.owned
    }

    pub(crate) fn ghost_count(&self) -> usize {
        self.ghosts
    }

    /// The slots of the objects that it owns.
    pub(crate) fn owned(&self) -> impl Iterator<Item = usize> {
        let roles = self.roles.iter().enumerate();
        roles.filter(|(_, role)| matches!(role, Role::Owned { .. })).map(|(slot, _)| slot)
    }

    pub(crate) fn slot(&self, name: u64) -> Option<usize> {
        self.slots.get(&name).map(|&slot| slot as usize)
    }

    /// The name of a slot's shape, and the shape.
    pub(crate) fn shape(&self, slot: usize) -> (u64, &Shape) {
        (self.shapes.names[self.scene.shape_index(slot) as usize], self.scene.shape(slot))
    }

    /// Takes in shapes by their names; those that are known stay.
    pub(crate) fn learn(
        &mut self,
        shapes: impl IntoIterator<Item = (u64, Shape)>,
    ) -> Result<(), RankError> {
        let mut new = Vec::new();
        for (name, shape) in shapes {
            let next = self.shapes.names.len() as u32;
            if *self.shapes.by_name.entry(name).or_insert(next) != next {
                continue;
            }
            let bounds = Bounds::of(&shape).ok_or(RankError::Foreign { shape: name })?;
            self.shapes.names.push(name);
            self.shapes.bounds.push(bounds);
            self.shapes.uses.push(0);
            self.shapes.unused += 1;
            new.push(shape);
        }
        if !new.is_empty() {
            self.scene.add_shapes(new).map_err(RankError::Shapes)?;
        }
        Ok(())
    }

    /// Places a body whose shape is known, or moves it if it is there; from now on it has that role.
    pub(crate) fn put(
        &mut self,
        (name, shape): (u64, u64),
        pose: Pose,
        role: Role,
    ) -> Result<(), RankError> {
        let refused = |error| RankError::Scene { body: name, error };
        if let Some(slot) = self.slot(name) {
            self.scene.set_pose(slot, pose).map_err(refused)?;
            self.set_role(slot, role);
            return Ok(());
        }
        let Some(&shape) = self.shapes.by_name.get(&shape) else {
            let shapes = self.shapes.names.len();
            return Err(RankError::NoSuchShape { body: name, shape: shape as usize, shapes });
        };
        let handle = self.scene.insert(Object::new(shape, pose)).map_err(refused)?;
        let slot = handle.index as usize;
        if slot == self.names.len() {
            self.names.push(name);
            self.roles.push(Role::Free);
            self.boxes.push(Aabb::EMPTY);
        }
        self.names[slot] = name;
        self.slots.insert(name, handle.index);
        let uses = &mut self.shapes.uses[shape as usize];
        self.shapes.unused -= usize::from(*uses == 0);
        *uses += 1;
        self.set_role(slot, role);
        Ok(())
    }

    /// Moves an object.
    pub(crate) fn set_pose(&mut self, slot: usize, pose: Pose) -> Result<(), RankError> {
        let refused = |error| RankError::Scene { body: self.names[slot], error };
        self.scene.set_pose(slot, pose).map_err(refused)
    }

    pub(crate) fn set_role(&mut self, slot: usize, role: Role) {
        let before = std::mem::replace(&mut self.roles[slot], role);
        for (role, more) in [(before, false), (role, true)] {
            let count = match role {
                Role::Free => continue,
                Role::Owned { .. } => &mut self.owned,
                Role::Ghost { .. } => &mut self.ghosts,
            };
            if more { *count += 1 } else { *count -= 1 }
        }
    }

    /// Takes a body out.
    pub(crate) fn remove(&mut self, slot: usize) {
        let Some(handle) = self.scene.handle(slot) else { return };
        let shape = self.scene.shape_index(slot) as usize;
        if self.scene.remove(handle).is_ok() {
            self.slots.remove(&self.names[slot]);
            self.shapes.uses[shape] -= 1;
            self.shapes.unused += usize::from(self.shapes.uses[shape] == 0);
            self.boxes[slot] = Aabb::EMPTY;
            self.set_role(slot, Role::Free);
        }
    }

    /// Takes out the ghosts that were not heard of at `now`.
    pub(crate) fn forget_unheard(&mut self, now: u64) {
        for slot in 0..self.roles.len() {
            if matches!(self.roles[slot], Role::Ghost { heard } if heard != now) {
                self.remove(slot);
            }
        }
    }

    /// Drops the shapes that nobody has, if they are many.
    pub(crate) fn drop_unused_shapes(&mut self) -> Result<(), RankError> {
        let Shapes { unused, ref names, .. } = self.shapes;
        if unused <= UNUSED || unused * 2 <= names.len() {
            return Ok(());
        }
        let mut anew = Self::default();
        let used = (0..names.len()).filter(|&k| self.shapes.uses[k] > 0);
        anew.learn(used.map(|k| (names[k], self.scene.shapes()[k].clone())))?;
        for slot in (0..self.roles.len()).filter(|&slot| self.roles[slot] != Role::Free) {
            let shape = names[self.scene.shape_index(slot) as usize];
            let name = self.names[slot];
            anew.put((name, shape), self.scene.poses()[slot], self.roles[slot])?;
        }
        *self = anew;
        Ok(())
    }

    /// Boxes all objects, grown by so many metres, and finds which of those that it owns lie inside of its
    /// region with both ends.
    pub(crate) fn make_boxes(
        &mut self,
        (cuts, region): (&Cuts, &Range<u64>),
        grown: f64,
        exec: Exec,
    ) {
        let Self { scene, roles, boxes, shapes, .. } = self;
        exec.divide((&mut roles[..], &mut boxes[..]), SLOTS_A_TASK, |first, (roles, boxes)| {
            for (k, (role, aabb)) in roles.iter_mut().zip(boxes).enumerate() {
                if *role == Role::Free {
                    continue;
                }
                let slot = first + k;
                let bounds = &shapes.bounds[scene.shape_index(slot) as usize];
                *aabb = bounds.aabb(&scene.poses()[slot], grown);
                if let Role::Owned { inside } = role {
                    *inside = cuts.is_inside(region, aabb);
                }
            }
        });
    }

    /// Boxes one object.
    pub(crate) fn make_box(&mut self, slot: usize, grown: f64) {
        let bounds = &self.shapes.bounds[self.scene.shape_index(slot) as usize];
        self.boxes[slot] = bounds.aabb(&self.scene.poses()[slot], grown);
    }
}
