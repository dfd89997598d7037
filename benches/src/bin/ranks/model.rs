//! A model of ghosts: boxes of one size, uniform in a cube, are cut as ranks cut theirs, and those that reach into
//! other regions are counted. No step is run, and no rank.

use dcd_exec::{Exec, Par};
use dcd_geom::Aabb;
use dcd_geom::glam::{DVec3, Vec3};
use dcd_ranks::{Traffic, Transport, cut};
use dcd_scenes::poses_in;

/// How many boxes are placed, at most, along each axis.
const MOST_ALONG: usize = 100;

/// A cube, in which objects are uniform.
#[derive(Clone, Copy, Debug)]
pub(crate) struct World {
    pub(crate) objects: f64,
    /// The cube's edge, metres.
    pub(crate) edge: f64,
}

impl World {
    /// As dense, with another number of objects.
    pub(crate) fn with_objects(self, objects: f64) -> Self {
        Self { objects, edge: self.edge * (objects / self.objects).cbrt() }
    }
}

/// The two numbers that are fitted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fitted {
    /// The edge of an object's box, metres.
    pub(crate) box_edge: f64,
    pub(crate) bytes_a_ghost: f64,
}

impl Fitted {
    /// Those of a world in which these numbers of ranks have so many ghosts together, and so many bytes are sent.
    pub(crate) fn of(world: World, ranks: &[usize], ghosts: f64, bytes: f64) -> Self {
        let by_model = |box_edge: f64| -> f64 {
            ranks.iter().map(|&ranks| counted(world, box_edge, ranks)).sum()
        };
        // Ghosts are about as the edge is: the rule of three, again.
        let mut box_edge = (world.edge.powi(3) / world.objects).cbrt();
        for _ in 0..4 {
            box_edge *= ghosts / by_model(box_edge);
        }
        Self { box_edge, bytes_a_ghost: bytes / ghosts }
    }

    /// Ghosts of all ranks.
    pub(crate) fn ghosts(self, world: World, ranks: usize) -> f64 {
        counted(world, self.box_edge, ranks)
    }
}

/// Ghosts of so many ranks in a world of boxes of that edge. Of a larger world than [`MOST_ALONG`] allows a smaller
/// one, as dense, is cut.
fn counted(world: World, box_edge: f64, ranks: usize) -> f64 {
    let placed = world.with_objects(world.objects.min(MOST_ALONG.pow(3) as f64).round());
    let middles = middles(world, placed);
    let boxes = |edge: f64| {
        let half = Vec3::splat(0.5 * edge as f32);
        middles.iter().map(move |&middle| Aabb { min: middle - half, max: middle + half })
    };
    let names: Vec<u64> = (0..middles.len() as u64).collect();
    let placed_boxes: Vec<Aabb> = boxes(box_edge).collect();
    let cuts = cut(&Alone { size: ranks }, &placed_boxes, &names, Exec::from(Par::Serial));
    let mut reached = Vec::new();
    let ghosts = boxes(box_edge * placed.edge / world.edge).map(|aabb| {
        cuts.reached(&aabb, &mut reached);
        reached.len() - 1
    });
    ghosts.sum::<usize>() as f64 * world.objects / placed.objects
}

/// Seed of the boxes: none of a scene's.
const SEED: u64 = 0x0067_686f_7374_7321;

/// Independent where they are the world's own; of a larger one's, whose counts vary less, one a cell of a lattice.
fn middles(world: World, placed: World) -> Vec<Vec3> {
    let points = poses_in(DVec3::ZERO, DVec3::ONE, SEED).map(|pose| pose.translation());
    let is_sample = placed.objects < world.objects;
    let along = MOST_ALONG;
    let cell = |k: usize| {
        let cell = [k % along, k / along % along, k / along / along];
        DVec3::from_array(cell.map(|c| c as f64))
    };
    let points = points.take(placed.objects as usize).enumerate();
    let points = points.map(|(k, p)| if is_sample { (cell(k) + p) / along as f64 } else { p });
    points.map(|p| (p * placed.edge).as_vec3()).collect()
}

/// One rank of so many, that has all objects: where cuts are does not depend on who has which.
struct Alone {
    size: usize,
}

impl Transport for Alone {
    fn rank(&self) -> usize {
        0
    }

    fn size(&self) -> usize {
        self.size
    }

    fn exchange(&self, messages: Vec<(usize, Vec<u8>)>) -> Vec<(usize, Vec<u8>)> {
        messages.into_iter().filter(|(to, message)| *to == 0 && !message.is_empty()).collect()
    }

    fn all_gather(&self, own: &[u8]) -> Vec<Vec<u8>> {
        let mut all = vec![Vec::new(); self.size];
        all[0] = own.to_vec();
        all
    }

    fn sum(&self, _: &mut [u64]) {}

    fn chain(&self, first: u64, pass: impl FnOnce(u64) -> u64) -> u64 {
        pass(first)
    }

    fn traffic(&self) -> Traffic {
        Traffic::default()
    }
}
