//! What a rank brings along.

use crate::balance::mixed;
use crate::wire::Writer;
use crate::{RankError, Transport};
use dcd_geom::glam::DVec3;
use dcd_geom::{Aabb, Filter, HalfSpace, Motion, Pose, Scene, Shape};

/// An object of the whole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// Its name: no other body of any rank has it. Contacts name it, the smaller first.
    pub name: u64,
    /// Its shape's index in the share.
    pub shape: u32,
    /// Where it is.
    pub pose: Pose,
}

/// Some of the objects, whichever: they are moved to where they belong.
#[derive(Clone, Debug, Default)]
pub struct Share {
    /// The shapes, each with a name; one name is one shape, on all ranks.
    pub shapes: Vec<(u64, Shape)>,
    /// The bodies that place them.
    pub bodies: Vec<Body>,
}

impl Share {
    /// The objects of a scene of moving objects: body k is named `first` + k, and `shape_name` names the shapes.
    /// Slots that hold no object are passed over.
    ///
    /// # Errors
    /// What ranks do not know of and would lose: a static object, a filter, a sensor, an ignored pair. A body whose
    /// name would be more than a u64 counts.
    pub fn of_scene(
        scene: &Scene,
        first: u64,
        shape_name: impl Fn(usize) -> u64,
    ) -> Result<Self, RankError> {
        refuse_what_is_lost(scene)?;
        let shapes = scene.shapes().iter().enumerate();
        let shapes = shapes.map(|(k, shape)| (shape_name(k), shape.clone())).collect();
        let objects = scene.poses().iter().enumerate();
        let objects = objects.filter(|&(k, _)| scene.motion(k).is_some());
        let bodies = objects.map(|(object, &pose)| {
            let name = first.checked_add(object as u64);
            let name = name.ok_or(RankError::NoName { object, first })?;
            Ok(Body { name, shape: scene.shape_index(object), pose })
        });
        Ok(Self { shapes, bodies: bodies.collect::<Result<_, _>>()? })
    }

    /// That every body has a shape.
    pub(crate) fn check(&self) -> Result<(), RankError> {
        let shapes = self.shapes.len();
        let lost = self.bodies.iter().find(|body| body.shape as usize >= shapes);
        match lost {
            None => Ok(()),
            Some(&Body { name, shape, .. }) => {
                Err(RankError::NoSuchShape { body: name, shape: shape as usize, shapes })
            }
        }
    }
}

fn refuse_what_is_lost(scene: &Scene) -> Result<(), RankError> {
    let lost = |object: usize| match scene.motion(object)? {
        Motion::Static => Some("a static object"),
        _ if scene.filters()[object] != Filter::default() => Some("a filter"),
        _ if scene.sensors()[object] => Some("a sensor"),
        _ => None,
    };
    let ignored = scene.ignored_pairs().next().map(|pair| (pair.i as usize, "an ignored pair"));
    let object = (0..scene.len()).find_map(|object| Some((object, lost(object)?)));
    match object.or(ignored) {
        None => Ok(()),
        Some((object, what)) => Err(RankError::Unsupported { object, what }),
    }
}

/// That no name is that of two bodies, on whichever ranks. Collective.
pub(crate) fn check_names(transport: &impl Transport, names: &[u64]) -> Result<(), RankError> {
    let seen = to_judges(transport, names.iter().map(|&name| [name]));
    let twice = seen.windows(2).find(|pair| pair[0] == pair[1]);
    agree(transport, twice.map_or(Ok(()), |pair| Err(RankError::Twice { body: pair[0][0] })))
}

/// That no name is that of two shapes, on whichever ranks, by what their bytes come to. Collective.
pub(crate) fn check_shapes(
    transport: &impl Transport,
    shapes: &[(u64, Shape)],
) -> Result<(), RankError> {
    let digest = |(name, shape): &(u64, Shape)| {
        let mut bytes = Writer(Vec::new());
        bytes.shape(*name, shape)?;
        Ok([*name, bytes.0.chunks(8).fold(bytes.0.len() as u64, fold_digest)])
    };
    let digests = agree(transport, shapes.iter().map(digest).collect::<Result<Vec<_>, _>>())?;
    let seen = to_judges(transport, digests);
    let two = seen.windows(2).find(|two| two[0][0] == two[1][0] && two[0] != two[1]);
    agree(transport, two.map_or(Ok(()), |two| Err(RankError::TwoShapes { shape: two[0][0] })))
}

/// Sends entries that begin with a name to the rank that looks at that name, and returns what came to this one, sorted. Collective.
fn to_judges<const N: usize>(
    transport: &impl Transport,
    entries: impl IntoIterator<Item = [u64; N]>,
) -> Vec<[u64; N]> {
    let mut messages = vec![Vec::new(); transport.size()];
    for entry in entries {
        let name = entry.first().copied().unwrap_or_default();
        let judge = mixed(name) % transport.size() as u64;
        messages[judge as usize].extend(entry.iter().flat_map(|number| number.to_le_bytes()));
    }
    let messages = messages.into_iter().enumerate().filter(|(_, message)| !message.is_empty());
    let mut seen: Vec<[u64; N]> = Vec::new();
    for (_, message) in transport.exchange(messages.collect()) {
        let (numbers, _) = message.as_chunks();
        let (entries, _) = numbers.as_chunks::<N>();
        seen.extend(entries.iter().map(|entry| entry.map(u64::from_le_bytes)));
    }
    seen.sort_unstable();
    seen
}

/// A digest with up to eight more bytes.
fn fold_digest(digest: u64, bytes: &[u8]) -> u64 {
    let word = bytes.iter().rev().fold(0, |word, &byte| word << 8 | u64::from(byte));
    mixed(digest.rotate_left(23) ^ mixed(word))
}

/// What a box in the world is made of, of a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Bounds {
    /// Of one that has an end.
    Box(LocalBox),
    /// Of one that has none: its box reaches as far as objects do. So it is a ghost wherever its box reaches, and
    /// is owned where the middle of that box lies.
    HalfSpace(HalfSpace),
}

/// A box round a shape in its own frame, from which a box in the world is made at the cost of a matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LocalBox {
    centre: DVec3,
    half: DVec3,
    radius: f64,
}

/// By how much of its coordinates and its size a box is grown: f64 and f32 round by less, and so do the boxes
/// of every narrow phase, which lie inside of it.
const SLACK: f64 = 1.0 / (1u64 << 20) as f64;

impl Bounds {
    /// Of any shape but one that is known by its support map alone, which no message holds.
    pub(crate) fn of(shape: &Shape) -> Option<Self> {
        match shape {
            Shape::Polytope(polytope) => {
                Some(Self::Box(LocalBox::round(polytope.vertices(), polytope.swept_radius())))
            }
            Shape::Mesh(mesh) => {
                Some(Self::Box(LocalBox::round(mesh.points(), mesh.swept_radius())))
            }
            Shape::HalfSpace(half_space) => Some(Self::HalfSpace(*half_space)),
            Shape::Curved(_) | Shape::Ellipsoid(_) | Shape::Compound(_) => {
                let Aabb { min, max } = shape.aabb(&Pose::IDENTITY);
                Some(Self::Box(LocalBox::round(&[min.as_dvec3(), max.as_dvec3()], 0.0)))
            }
            _ => None,
        }
    }

    /// A box that holds the shape at that pose, and all within `grown` metres of it. The same on all ranks.
    #[inline]
    pub(crate) fn aabb(&self, pose: &Pose, grown: f64) -> Aabb {
        match self {
            Self::Box(local) => local.aabb(pose, grown),
            Self::HalfSpace(half_space) => {
                let Aabb { min, max } = half_space.aabb(pose);
                let size = pose.translation().abs().max_element() + half_space.swept_radius();
                let [min, max] = [min, max].map(|corner| {
                    let corner = corner.as_dvec3();
                    (corner, (corner.abs() + size) * SLACK + grown)
                });
                Aabb { min: (min.0 - min.1).as_vec3(), max: (max.0 + max.1).as_vec3() }
            }
        }
    }
}

impl LocalBox {
    fn round(points: &[DVec3], radius: f64) -> Self {
        let nothing = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (min, max) =
            points.iter().fold(nothing, |(min, max), &vertex| (min.min(vertex), max.max(vertex)));
        let centre = min + (max - min) * 0.5;
        Self { centre, half: (max - centre).max(centre - min), radius }
    }

    #[inline]
    fn aabb(&self, pose: &Pose, grown: f64) -> Aabb {
        let turn = pose.rotation();
        let centre = pose.apply(self.centre);
        let [x, y, z] = self.half.to_array();
        let half = turn.x_axis.abs() * x + turn.y_axis.abs() * y + turn.z_axis.abs() * z;
        // R may be a rotation up to some 1e-6, by which a sphere is no sphere; a box that holds one may shrink by
        // as much.
        let (swept, held) = (1.0 + pose.deviation(), 1.0 + 2.0 * pose.deviation());
        let half = half * held + self.radius * swept + grown;
        let size = centre.abs().max_element() + half.max_element() + self.centre.length();
        let half = half + size * SLACK;
        Aabb { min: (centre - half).as_vec3(), max: (centre + half).as_vec3() }
    }
}

/// What `result` is on this rank, if it is no error on any: else the first rank's error, in words.
pub(crate) fn agree<T>(
    transport: &impl Transport,
    result: Result<T, RankError>,
) -> Result<T, RankError> {
    let own = result.as_ref().err().map(ToString::to_string).unwrap_or_default();
    let all = transport.all_gather(own.as_bytes());
    let failed = all.iter().position(|message| !message.is_empty());
    match (result, failed) {
        (Ok(value), None) => Ok(value),
        (Err(error), _) => Err(error),
        (Ok(_), Some(rank)) => {
            let message = String::from_utf8_lossy(&all[rank]).into_owned();
            Err(RankError::Elsewhere { rank, message })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dcd_geom::glam::DQuat;

    #[test]
    fn the_box_holds_the_shapes_own_wherever_it_is() {
        let points = vec![DVec3::ZERO, DVec3::X * 3.0, DVec3::Y, DVec3::new(0.2, 0.3, -2.0)];
        let shapes = [
            Shape::hull(points.clone()).unwrap(),
            Shape::sphere(0.3).unwrap(),
            Shape::capsule(0.5, 0.25).unwrap(),
            Shape::cuboid(DVec3::new(0.01, 2.0, 30.0)).unwrap(),
            Shape::cone(0.5, 0.3).unwrap().rounded(0.1).unwrap(),
            Shape::ellipsoid(DVec3::new(0.5, 0.1, 2.0)).unwrap().rounded(0.1).unwrap(),
            Shape::mesh(points, vec![[0, 1, 2], [1, 2, 3]]).unwrap(),
            Shape::compound(vec![
                (Shape::sphere(0.7).unwrap(), Pose::from_translation(DVec3::X).unwrap()),
                (Shape::cylinder(1.0, 0.2).unwrap(), Pose::IDENTITY),
            ])
            .unwrap(),
        ];
        for (k, shape) in shapes.iter().enumerate() {
            let bounds = Bounds::of(shape).unwrap();
            for turn in 0..50 {
                let angle = f64::from(turn) * 0.4;
                let axis = DVec3::new(angle.sin(), 1.0, angle.cos()).normalize();
                let spot = DVec3::new(angle, -angle, 1.0) * [1.0, 1e-3, 1e5, 1e9][k % 4];
                let pose = Pose::new(DQuat::from_axis_angle(axis, angle), spot).unwrap();
                let (outer, inner) = (bounds.aabb(&pose, 0.5), shape.aabb(&pose));
                assert!(outer.min.cmplt(inner.min).all() && outer.max.cmpgt(inner.max).all());
            }
        }
    }
}
