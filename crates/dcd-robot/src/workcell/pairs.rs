//! The allowed pairs of names, as pairs of a scene's objects.

use crate::allowed::Layer;
use crate::bounds::ALLOWED_PAIRS;
use crate::scan::bounded;
use crate::{AllowedPairs, Robot, RobotError};
use dcd_geom::Scene;
use std::collections::{BTreeMap, HashSet};
use std::ops::Range;

/// The names of the robot's links, with and without shapes, and of what it carries.
pub(super) fn own_names(robot: &Robot) -> HashSet<&str> {
    let links = robot.links().iter().map(|link| link.name.as_str());
    links.chain(robot.parts().iter().map(|part| robot.name_of(part))).collect()
}

/// Makes the scene ignore what may touch: in time linear in the objects, the pairs that are named,
/// and the objects of defaults.
pub(super) fn ignore(
    scene: &mut Scene,
    names: &[String],
    obstacles: Range<usize>,
    allowed: &AllowedPairs,
) -> Result<(), RobotError> {
    let mut objects: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    for (object, name) in names.iter().enumerate() {
        objects.entry(name).or_default().push(object);
    }
    let mut cell = Cell { scene, objects, obstacles, allowed, count: 0 };
    let tied = cell.bodies()?;
    for layer in allowed.layers() {
        layer.named().filter(|(_, may)| *may).try_for_each(|([a, b], _)| cell.ignore(a, b))?;
        for name in layer.open() {
            let others: Vec<&str> = cell.objects.keys().copied().collect();
            cell.looked_up(others.len())?;
            others.into_iter().try_for_each(|other| cell.ignore(name, other))?;
        }
    }
    for body in tied {
        cell.looked_up(body.len().saturating_mul(body.len()))?;
        for (k, a) in body.iter().enumerate() {
            body[k + 1..].iter().try_for_each(|b| cell.ignore(a, b))?;
        }
    }
    Ok(())
}

struct Cell<'a, 's> {
    scene: &'s mut Scene,
    /// In the order of names, so that what is ignored does not depend on a hash.
    objects: BTreeMap<&'a str, Vec<usize>>,
    obstacles: Range<usize>,
    allowed: &'a AllowedPairs,
    /// Pairs of objects so far.
    count: usize,
}

impl<'a> Cell<'a, '_> {
    /// Makes each rigid body, and each link that is in none, one group. Returns those bodies that
    /// must be taken pair by pair: some pair in them may not touch, or some link is in another too.
    fn bodies(&mut self) -> Result<Vec<Vec<&'a str>>, RobotError> {
        let mut grouped: HashSet<&str> = HashSet::new();
        let mut by_pair = Vec::new();
        for (at, layer) in self.allowed.layers().iter().enumerate() {
            let mut bodies: BTreeMap<usize, Vec<&'a str>> = BTreeMap::new();
            // What stands moves with no body, though something of its name may have.
            let moving = self.objects.iter().filter(|(_, objects)| !self.stand(objects));
            for (&name, _) in moving {
                if let Some(body) = layer.body(name) {
                    bodies.entry(body).or_default().push(name);
                }
            }
            let open = self.contradicted(at, layer);
            for (body, links) in bodies {
                if links.len() > 1 {
                    if open.contains(&body) || links.iter().any(|name| grouped.contains(name)) {
                        by_pair.push(links);
                    } else {
                        grouped.extend(&links);
                        self.group(&links)?;
                    }
                }
            }
        }
        let alone: Vec<&str> =
            self.objects.keys().copied().filter(|name| !grouped.contains(name)).collect();
        alone.into_iter().try_for_each(|name| self.group(&[name]))?;
        Ok(by_pair)
    }

    /// The bodies of a layer of which it, or a later one, says that two links may not touch.
    fn contradicted(&self, at: usize, layer: &Layer) -> HashSet<usize> {
        let later = self.allowed.layers()[at..].iter().flat_map(Layer::named);
        let refused = later.filter(|([a, b], may)| !may && a != b);
        let of_one = refused.filter_map(|([a, b], _)| {
            let body = layer.body(a)?;
            (layer.body(b) == Some(body)).then_some(body)
        });
        let mut open: HashSet<usize> = of_one.collect();
        // A later default may speak of two links of a body as well.
        let defaults = self.allowed.layers()[at + 1..].iter().flat_map(Layer::closed);
        open.extend(defaults.filter_map(|name| layer.body(name)));
        open
    }

    fn group(&mut self, names: &[&str]) -> Result<(), RobotError> {
        let all = names.iter().filter_map(|name| self.objects.get(name)).flatten().copied();
        let all: Vec<usize> = all.filter(|object| !self.obstacles.contains(object)).collect();
        if all.len() < 2 {
            return Ok(());
        }
        self.scene.ignore_among(&all).map_err(RobotError::Scene)
    }

    /// Whether the objects of a name are obstacles.
    fn stand(&self, objects: &[usize]) -> bool {
        objects.iter().all(|k| self.obstacles.contains(k))
    }

    /// Counts pairs of names that are looked up, whether they may touch or not.
    fn looked_up(&mut self, pairs: usize) -> Result<(), RobotError> {
        self.count = self.count.saturating_add(pairs);
        bounded("pairs of shapes that may touch", self.count, ALLOWED_PAIRS)
    }

    /// Ignores every object of one name with every one of the other, if the last word on the two
    /// is that they may touch.
    fn ignore(&mut self, a: &str, b: &str) -> Result<(), RobotError> {
        let (Some(of_a), Some(of_b)) = (self.objects.get(a), self.objects.get(b)) else {
            return Ok(());
        };
        if a == b || (self.stand(of_a) && self.stand(of_b)) || !self.allowed.contains(a, b) {
            return Ok(());
        }
        let pairs = of_a.len().saturating_mul(of_b.len());
        self.count = self.count.saturating_add(pairs);
        bounded("pairs of shapes that may touch", self.count, ALLOWED_PAIRS)?;
        for &i in of_a {
            for &j in of_b {
                self.scene.ignore_pair(i, j).map_err(RobotError::Scene)?;
            }
        }
        Ok(())
    }
}
