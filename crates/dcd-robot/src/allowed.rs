//! Pairs of links that may touch.

mod layer;

use super::{Robot, RobotError, Srdf};
pub(super) use layer::{Layer, Matrix};
use std::collections::HashSet;
use std::path::Path;

/// Which pairs of names, of links or obstacles, may touch: their contacts are not reported.
///
/// Links that are tied rigidly are kept as bodies, so that what this takes grows with the number of
/// links and not with that of their pairs. An obstacle is of no body, whatever its name.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct AllowedPairs {
    /// Where two speak of a pair the later one counts.
    layers: Vec<Layer>,
}

impl AllowedPairs {
    /// Reads the pairs of an SRDF file, whatever their reason: see [`Srdf::load`].
    ///
    /// # Errors
    /// Those of [`Srdf::load`].
    pub fn load(srdf: &Path) -> Result<Self, RobotError> {
        Srdf::load(srdf).map(|srdf| srdf.allowed)
    }

    /// Links that touch by how they are built, for a robot without SRDF: those that a joint joins,
    /// links without a shape between them passed over, and those that no joint moves against each
    /// other.
    pub fn adjacent(robot: &Robot) -> Self {
        let mut layer = Layer::default();
        let (bodies, parents) = robot.bodies_and_parents();
        let name = |link: usize| robot.links()[link].name.as_str();
        for (link, (body, parent)) in bodies.into_iter().zip(parents).enumerate() {
            layer.tie(name(link), body);
            if let Some(parent) = parent {
                layer.set(name(link), name(parent), true);
            }
        }
        Self { layers: vec![layer] }
    }

    /// Allows a pair, in either order.
    pub fn allow(&mut self, a: &str, b: &str) {
        if self.layers.is_empty() {
            self.layers.push(Layer::default());
        }
        if let Some(layer) = self.layers.last_mut() {
            layer.set(a, b, true);
        }
    }

    /// Forgets the pairs that are allowed by name and that this name is of, and the body that it is in.
    pub(super) fn forget(&mut self, name: &str) {
        self.layers.iter_mut().for_each(|layer| layer.forget(name));
    }

    /// Takes a name out of the body that it is in.
    pub(super) fn untie(&mut self, name: &str) {
        self.layers.iter_mut().for_each(|layer| layer.untie(name));
    }

    /// Takes over what the other says, which counts where both speak of a pair.
    pub fn extend(&mut self, other: &Self) {
        self.layers.extend(other.layers.iter().cloned());
    }

    /// Takes over what another SRDF of the same robot says.
    pub(super) fn merge(&mut self, other: Self) {
        for layer in other.layers {
            match self.layers.last_mut() {
                Some(last) if last.is_of_links() && layer.is_of_links() => last.merge(layer),
                _ => self.layers.push(layer),
            }
        }
    }

    /// Without what an SRDF says of names that are no links of the robot: obstacles and carried objects are none.
    pub(super) fn of_robot(mut self, robot: &Robot) -> Self {
        let links: HashSet<&str> = robot.links().iter().map(|link| link.name.as_str()).collect();
        self.layers.iter_mut().for_each(|layer| layer.keep_links(&links));
        self
    }

    /// Allows what a link carries to touch that link and what else it carries.
    pub(super) fn carry(&mut self, object: &str, link: &str) {
        if self.layers.is_empty() {
            self.layers.push(Layer::default());
        }
        let place = self.layers.iter().rposition(|layer| layer.carries_by(link));
        let place = place.unwrap_or(self.layers.len() - 1);
        self.layers[place].carry(object, link);
    }

    /// How many of these pairs may touch of which a scene, with a matrix of its own, says nothing: MoveIt takes that matrix in place of all
    /// that an SRDF says, and checks them.
    pub fn count_missing_in_matrix_of(&self, scene: &Self) -> usize {
        if !scene.layers.iter().any(Layer::has_matrix) {
            return 0;
        }
        let named = self.layers.iter().flat_map(Layer::named).filter(|(_, may)| *may);
        let is_said =
            |a: &str, b: &str| scene.layers.iter().any(|layer| layer.says(a, b).is_some());
        named.filter(|([a, b], _)| !is_said(a, b)).count()
    }

    pub(super) fn push(&mut self, layer: Layer) {
        self.layers.push(layer);
    }

    pub(super) fn layers(&self) -> &[Layer] {
        &self.layers
    }

    /// Whether the pair may touch, in either order.
    pub fn contains(&self, a: &str, b: &str) -> bool {
        self.layers.iter().rev().find_map(|layer| layer.says(a, b)).unwrap_or(false)
    }

    /// How many pairs are named one by one as those that may touch: not those of bodies, nor of
    /// defaults.
    pub fn len(&self) -> usize {
        self.layers.iter().map(|layer| layer.named().filter(|(_, may)| *may).count()).sum()
    }

    /// Whether nothing is said to be allowed.
    pub fn is_empty(&self) -> bool {
        self.layers.iter().all(Layer::is_empty)
    }
}

#[cfg(test)]
mod tests;
