//! What of a robot and its world does not depend on a state.

mod changes;

use super::alone::{LinkPairRow, LinkRow};
use super::body_pairs::BodyPairs;
use super::chain::Chain;
use super::covers::{Covers, is_one};
use super::link_frames::LinkFrames;
use super::links::{Body, BodyHull, LinkSpheres, links};
use super::obstacle_tree::ObstacleTree;
use super::packed_aabbs::PackedAabbs;
use super::solids::Solid;
use crate::kinematics::JointFrame;
use crate::{Joint, Motion, Robot, RobotError, Workcell};
use dcd_geom::{Aabb, Pair, Pose, Shape};
use dcd_pipeline::{LinkSet, Other};
use dcd_simd::Block;
use std::ops::Range;

/// What does not depend on a state.
#[derive(Debug)]
pub(super) struct Prepared {
    pub(super) cell: Workcell,
    /// For each body its object in the scene and the part that moves it: the parts, then the padded ones.
    pub(super) bodies: Vec<(u32, usize)>,
    /// For each body its vertices, if it is a hull.
    pub(super) hulls: Vec<Option<BodyHull>>,
    /// For each obstacle its box in the world.
    pub(super) aabbs: Vec<Aabb>,
    pub(super) solids: Vec<Solid>,
    /// The vertices of the hulls among them.
    pub(super) corners: Vec<Block>,
    pub(super) boxes: Vec<PackedAabbs>,
    /// Where there are many of them.
    pub(super) tree: Option<ObstacleTree>,
    /// The spheres of what meets obstacles, link by link.
    pub(super) world_links: Vec<LinkSpheres>,
    /// The spheres of what meets the robot, where they are not the same.
    pub(super) own_links: Option<Vec<LinkSpheres>>,
    /// Those of either, sixteen links to a row.
    pub(super) world_rows: Vec<LinkRow>,
    pub(super) own_rows: Vec<LinkRow>,
    /// Where the links are in f32.
    pub(super) chain: Chain,
    /// The links that may meet each other, by their places among those with spheres.
    pub(super) link_pairs: Vec<[u32; 2]>,
    /// The same for a state alone.
    pub(super) link_pair_rows: Vec<LinkPairRow>,
    /// The bodies that are checked against each other, of those that meet the robot.
    body_pairs: BodyPairs,
    /// Whether some pair may touch, or does not meet; whether an obstacle is in such a pair.
    filtered: bool,
    obstacles_filtered: bool,
}

impl Prepared {
    pub(super) fn of(cell: Workcell, covers: &mut Covers) -> Self {
        let parts = cell.robot().parts.len();
        let bodies = bodies(&cell);
        let is_padded = |part: usize| bodies[parts..].iter().any(|&(_, padded)| padded == part);
        let meets_world = |&number: &usize| number >= parts || !is_padded(number);
        let all = 0..bodies.len();
        let mut spheres = |numbers: &mut dyn Iterator<Item = usize>| {
            let shapes: Vec<Body<'_>> =
                numbers.map(|number| body(&cell, &bodies, number)).collect();
            links(cell.robot(), &shapes, covers)
        };
        let world_links = spheres(&mut all.clone().filter(meets_world));
        let own_links = cell.is_padded().then(|| spheres(&mut (0..parts)));
        let hulls = all.clone().map(|number| BodyHull::of(&body(&cell, &bodies, number))).collect();
        let chain = Chain::of(cell.robot(), &world_links);
        let mut prepared = Self {
            chain,
            bodies,
            hulls,
            aabbs: Vec::new(),
            solids: Vec::new(),
            corners: Vec::new(),
            boxes: Vec::new(),
            tree: None,
            world_links,
            own_links,
            world_rows: Vec::new(),
            own_rows: Vec::new(),
            link_pairs: Vec::new(),
            link_pair_rows: Vec::new(),
            body_pairs: BodyPairs::default(),
            filtered: false,
            obstacles_filtered: false,
            cell,
        };
        prepared.bound_links();
        prepared.take_obstacles();
        prepared.take_pairs();
        prepared
    }

    /// Whether a cell has the same robot, carrying the same.
    pub(super) fn has_robot_of(&self, cell: &Workcell) -> bool {
        let (old, new) = (self.cell.robot(), cell.robot());
        let has_robot = || {
            old.links.len() == new.links.len()
                && old.joints.iter().map(kinematics).eq(new.joints.iter().map(kinematics))
        };
        bodies(cell) == self.bodies
            && (std::ptr::eq(old, new) || has_robot())
            && (0..self.bodies.len()).all(|number| {
                let of = |cell| body(cell, &self.bodies, number);
                is_same_body(&of(&self.cell), &of(cell))
            })
    }

    /// Takes another cell of the same robot.
    pub(super) fn exchange(&mut self, cell: Workcell) {
        let parts = 0..cell.robot().parts.len();
        let is_filtered_alike = self.cell.scene().has_same_filters(cell.scene(), parts);
        self.cell = cell;
        if self.chain.base != self.robot().base {
            self.chain = Chain::of(self.cell.robot(), &self.world_links);
            self.bound_links();
        }
        self.take_obstacles();
        if !is_filtered_alike {
            self.take_pairs();
        }
    }

    /// Takes from the chain what the rounding of the links' places comes to.
    fn bound_links(&mut self) {
        let Self { chain, world_links, own_links, .. } = self;
        chain.bound(world_links);
        own_links.iter_mut().for_each(|links| chain.bound(links));
        self.world_rows = LinkRow::of(world_links);
        self.own_rows = LinkRow::of(own_links.as_deref().unwrap_or_default());
    }

    /// Takes the obstacles from the cell.
    fn take_obstacles(&mut self) {
        let obstacles = self.obstacles();
        let Self { cell, hulls, aabbs, solids, corners, boxes, .. } = self;
        let scene = cell.scene();
        let parts = hulls.iter().any(Option::is_some);
        aabbs.clear();
        solids.clear();
        corners.clear();
        for object in obstacles {
            let (solid, aabb) = Solid::of(scene, object, parts.then_some(&mut *corners));
            solids.push(solid);
            aabbs.push(aabb);
        }
        PackedAabbs::fill(boxes, aabbs, solids);
        self.tree = ObstacleTree::of(aabbs);
        self.note_filters();
    }

    /// Takes note of which obstacles are filtered, if any.
    fn note_filters(&mut self) {
        self.filtered = self.cell.scene().filters_movers();
        self.obstacles_filtered = self.cell.filters_obstacles();
    }

    /// Takes the pairs of the robot's own bodies, and so of its links, that are checked.
    fn take_pairs(&mut self) {
        let (parts, scene) = (self.robot().parts.len(), self.cell.scene());
        let object = |body: u32| self.bodies[body as usize].0;
        self.body_pairs = BodyPairs::of(parts, |a, b| scene.allows(object(a), object(b)));
        self.link_pairs = self.link_pairs();
        self.link_pair_rows = LinkPairRow::of(&self.link_pairs);
    }

    /// An obstacle as it is compared, with a box round it, its vertices behind those that there are, if a plane may part
    /// any body from it.
    fn solid(&mut self, object: usize) -> (Solid, Aabb) {
        let parts = self.hulls.iter().any(Option::is_some);
        let corners = parts.then_some(&mut self.corners);
        Solid::of(self.cell.scene(), object, corners)
    }

    pub(super) fn robot(&self) -> &Robot {
        self.cell.robot()
    }

    fn obstacles(&self) -> Range<usize> {
        self.cell.obstacles()
    }

    pub(super) fn own_links(&self) -> &[LinkSpheres] {
        self.own_links.as_deref().unwrap_or(&self.world_links)
    }

    /// The pairs of links of which some bodies may not touch.
    fn link_pairs(&self) -> Vec<[u32; 2]> {
        let links = self.own_links();
        let bodies: Vec<Vec<u32>> = links.iter().map(LinkSpheres::bodies).collect();
        let mut pairs = Vec::new();
        for (b, of_b) in (0..).zip(&bodies) {
            // A link meets itself where it carries what may not touch it.
            for (a, of_a) in (0..=b).zip(&bodies) {
                let is_checked = |k: u32, other| k != other && self.allows(k, Other::Link(other));
                if of_a.iter().any(|&k| of_b.iter().any(|&other| is_checked(k, other))) {
                    pairs.push([a, b]);
                }
            }
        }
        pairs
    }

    /// Whether a body is checked against an obstacle, by its number, or another body.
    #[inline]
    pub(super) fn allows(&self, body: u32, other: Other) -> bool {
        let known = match other {
            _ if !self.filtered => Some(true),
            Other::Link(other) => self.body_pairs.get(body, other),
            Other::Obstacle(_) => (!self.obstacles_filtered).then_some(true),
        };
        if let Some(known) = known {
            return known;
        }
        let Pair { i, j } = self.pair(body, other);
        self.cell.scene().allows(i, j)
    }

    /// The objects of a pair.
    pub(super) fn pair(&self, body: u32, other: Other) -> Pair {
        Pair::new(self.bodies[body as usize].0, self.object_of(other))
    }

    /// An obstacle's or another body's object in the scene.
    pub(super) fn object_of(&self, other: Other) -> u32 {
        match other {
            // Obstacles follow the parts.
            Other::Obstacle(number) => self.robot().parts.len() as u32 + number,
            Other::Link(other) => self.bodies[other as usize].0,
        }
    }

    /// Whether a body is a sphere, and the other one is a sphere or an obstacle of one piece.
    pub(super) fn is_sphere_pair(&self, body: u32, other: Other) -> bool {
        let shape = |object: u32| self.cell.scene().shape(object as usize);
        let is_sphere =
            |object: u32| shape(object).as_polytope().is_some_and(|p| p.vertices().len() == 1);
        let against = self.object_of(other);
        is_sphere(self.bodies[body as usize].0)
            && match other {
                Other::Link(_) => is_sphere(against),
                Other::Obstacle(_) => {
                    !matches!(shape(against), Shape::Mesh(_) | Shape::Compound(_))
                }
            }
    }

    /// Whether both are polytopes, of whose touching nothing is ever undecided.
    pub(super) fn is_polytope_pair(&self, body: u32, other: Other) -> bool {
        let objects = [self.bodies[body as usize].0, self.object_of(other)];
        let scene = self.cell.scene();
        objects.iter().all(|&object| scene.shape(object as usize).as_polytope().is_some())
    }

    pub(super) fn link_set(&self) -> LinkSet {
        let shape = |&(object, _): &(u32, usize)| self.cell.scene().shape(object as usize).clone();
        LinkSet::new(self.bodies.iter().map(shape).collect())
    }

    /// Where a body is.
    pub(super) fn pose(
        &self,
        frames: &LinkFrames,
        lane: usize,
        body: usize,
    ) -> Result<Pose, RobotError> {
        let part = &self.robot().parts[self.bodies[body].1];
        let placed = frames.frame(part.link, lane).then(&part.origin);
        placed.pose().map_err(|error| {
            let user = format!("link {:?}", self.robot().links[part.link].name);
            RobotError::Pose { user, error }
        })
    }
}

/// For each body of a cell its object in the scene and the part that moves it: the parts, then the padded ones.
fn bodies(cell: &Workcell) -> Vec<(u32, usize)> {
    let moved = |i: usize| Some((i as u32, cell.part_of(i)?));
    let (still, all) = (cell.obstacles(), cell.scene().len());
    (0..still.start).chain(still.end..all).filter_map(moved).collect()
}

fn body<'a>(cell: &'a Workcell, bodies: &[(u32, usize)], number: usize) -> Body<'a> {
    let (object, part) = bodies[number];
    let part = &cell.robot().parts[part];
    let (link, shape, origin) = (part.link, cell.scene().shape(object as usize), part.origin);
    Body { number: number as u32, link, shape, origin }
}

/// Whether two bodies are placed alike and share their shape.
fn is_same_body(a: &Body<'_>, b: &Body<'_>) -> bool {
    is_one(a.shape, b.shape) && a.link == b.link && a.origin == b.origin
}

/// What of a joint says where its child is.
fn kinematics(joint: &Joint) -> (usize, usize, &Motion, &JointFrame) {
    (joint.parent, joint.child, &joint.motion, &joint.origin)
}
