//! A robot's states by Parry in f64: what a user of Parry would write.

use crate::forms::in_parrys_frame;
use crate::world::Until;
use crate::{Library, Query};
use dcd_geom::{Pair, Pose, Scene, Shape};
use parry3d_f64::bounding_volume::{Aabb, BoundingVolume};
use parry3d_f64::math::Pose as ParryPose;
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy};
use parry3d_f64::shape::SharedShape;

/// Parry's shapes for a robot in its world, a tree over the world, and which pairs are checked.
pub struct ParryRobot {
    links: Vec<SharedShape>,
    obstacles: Vec<(SharedShape, ParryPose)>,
    tree: Bvh,
    /// The pairs of links that may not touch.
    self_pairs: Vec<Pair>,
    /// For each link and obstacle whether they may not touch.
    is_checked: Vec<bool>,
    boxes: Vec<Aabb>,
}

impl ParryRobot {
    /// For a scene whose first `links` objects are the robot's, the others obstacles that stand still; pairs that the scene
    /// does not allow are not checked. None, if Parry has no shape for one of them, or there are fewer objects than links.
    pub fn new(scene: &Scene, links: usize) -> Option<Self> {
        if scene.len() < links {
            return None;
        }
        let forms =
            scene.shapes().iter().map(<f64 as Library>::form).collect::<Option<Vec<_>>>()?;
        let form_of = |i: usize| forms[scene.shape_index(i) as usize].clone();
        let obstacles: Vec<_> =
            (links..scene.len()).map(|i| (form_of(i), pose_of(scene, i))).collect();
        let boxes = obstacles.iter().map(|(form, pose)| form.compute_aabb(pose)).enumerate();
        let (all, own_links) = (scene.len() as u32, links as u32);
        let pairs = (0..own_links).flat_map(|i| (i + 1..all).map(move |j| Pair { i, j }));
        let (own_pairs, world_pairs): (Vec<_>, Vec<_>) = pairs.partition(|p| p.j < own_links);
        Some(Self {
            links: (0..links).map(form_of).collect(),
            tree: Bvh::from_iter(BvhBuildStrategy::Binned, boxes),
            obstacles,
            self_pairs: own_pairs.into_iter().filter(|p| scene.allows(p.i, p.j)).collect(),
            is_checked: world_pairs.iter().map(|p| scene.allows(p.i, p.j)).collect(),
            boxes: Vec::new(),
        })
    }

    /// The touching pairs with the links at these poses ([`ParryRobot::pose`]), all or the first alone, and how many it left
    /// undecided.
    pub fn check(&mut self, poses: &[ParryPose], until: Until, touching: &mut Vec<Pair>) -> usize {
        let Self { links, obstacles, tree, self_pairs, is_checked, boxes } = self;
        touching.clear();
        boxes.clear();
        boxes.extend(links.iter().zip(poses).map(|(form, pose)| form.compute_aabb(pose)));
        let mut unanswered = 0;
        let mut query =
            |pair: Pair, a: (&SharedShape, &ParryPose), b: (&SharedShape, &ParryPose)| {
                match <f64 as Library>::touching(Query::IntersectionTest, a, b) {
                    Some(true) => touching.push(pair),
                    Some(false) => {}
                    None => unanswered += 1,
                }
                until == Until::First && !touching.is_empty()
            };
        for &pair in &*self_pairs {
            let [i, j] = [pair.i as usize, pair.j as usize];
            if boxes[i].intersects(&boxes[j])
                && query(pair, (&links[i], &poses[i]), (&links[j], &poses[j]))
            {
                return unanswered;
            }
        }
        for (i, aabb) in boxes.iter().enumerate() {
            for leaf in tree.intersect_aabb(aabb) {
                let k = leaf as usize;
                if is_checked[i * obstacles.len() + k] {
                    let pair = Pair { i: i as u32, j: links.len() as u32 + leaf };
                    let (form, pose) = &obstacles[k];
                    if query(pair, (&links[i], &poses[i]), (form, pose)) {
                        return unanswered;
                    }
                }
            }
        }
        unanswered
    }
}

/// Where object `i` is, in Parry's terms: for what stands along y there, y takes the place of z.
fn pose_of(scene: &Scene, i: usize) -> ParryPose {
    parry_pose(scene.shape(i), &scene.poses()[i])
}

impl ParryRobot {
    /// A pose of a link of that shape, as Parry holds it.
    pub fn pose(shape: &Shape, pose: &Pose) -> ParryPose {
        parry_pose(shape, pose)
    }
}

/// A pose of that shape in Parry's terms.
fn parry_pose(shape: &Shape, pose: &Pose) -> ParryPose {
    <f64 as Library>::pose(&in_parrys_frame(shape, pose))
}
