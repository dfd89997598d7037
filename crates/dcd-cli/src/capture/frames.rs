//! The next frame of a moving scene.

use super::Capture;
use crate::failure::Failure;
use crate::making::on_threads;
use crate::memory;
use dcd_geom::{Pair, Scene, SceneError};
use dcd_gjk::{PosedSupport, epa};
use dcd_pipeline::{Par, Pipeline};
use dcd_scenes::{Pile, PileContact, RandomWalk, SceneSpec};

/// The name of the scene of falling hulls.
const PILE: &str = "pile";
/// Hulls in it.
const USUAL_HULLS: u32 = 1_000;
/// Bytes of a hull of the pile, which share their shapes, at least.
const BYTES_A_HULL: f64 = 400.0;
/// The deviation of a walk's steps, metres and rad.
const USUAL_SIGMA: f64 = 0.01;

/// A moving scene.
pub(super) enum Moving {
    /// Falling hulls.
    Falling(Box<Falling>),
    /// A random walk.
    Walking(Box<Walking>),
}

/// A scene and its walk.
#[derive(Debug)]
pub(super) struct Walking {
    scene: Scene,
    walk: RandomWalk,
}

/// A pile and what finds its contacts.
#[derive(Debug)]
pub(super) struct Falling {
    pile: Pile,
    pipeline: Pipeline,
    contacts: Vec<PileContact>,
    scratch: epa::Scratch,
}

impl Moving {
    pub(super) fn new(options: &Capture) -> Result<Self, Failure> {
        if options.scene == PILE {
            if options.sigma.is_some() {
                return Err(Failure::at("--sigma", "a pile falls, it does not walk"));
            }
            let hulls = options.n.unwrap_or(USUAL_HULLS) as usize;
            let what = format_args!("{hulls} hulls");
            memory::demand("--n", what, hulls as f64 * BYTES_A_HULL)?;
            let pile = Pile::new(hulls, options.seed).map_err(|e| Failure::at("--n", e))?;
            return Ok(Self::Falling(Box::new(Falling::new(pile))));
        }
        let mut spec = SceneSpec::parse(&options.scene)
            .map_err(|error| Failure::at("--scene", format_args!("{error} {PILE}")))?
            .with_seed(options.seed);
        spec.objects = options.n.map_or(spec.objects, |n| n as usize);
        let what = format_args!("{} objects of {:?}", spec.objects, options.scene);
        memory::demand("--n", what, spec.least_bytes())?;
        let walk = RandomWalk::new(options.sigma.unwrap_or(USUAL_SIGMA), options.seed);
        let walk = walk.map_err(|error| Failure::at("--sigma", error))?;
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let scene = on_threads(cores, |run| spec.scene_by(run))?;
        let scene = scene.map_err(|error| Failure::at(&options.scene, error))?;
        Ok(Self::Walking(Box::new(Walking { scene, walk })))
    }

    pub(super) fn scene(&self) -> &Scene {
        match self {
            Self::Falling(falling) => falling.pile.scene(),
            Self::Walking(walking) => &walking.scene,
        }
    }

    pub(super) fn advance(&mut self) -> Result<(), SceneError> {
        match self {
            Self::Falling(falling) => falling.advance(),
            Self::Walking(walking) => walking.walk.step(&mut walking.scene),
        }
    }
}

impl Falling {
    fn new(pile: Pile) -> Self {
        let (pipeline, contacts, scratch) = Default::default();
        Self { pile, pipeline, contacts, scratch }
    }

    fn advance(&mut self) -> Result<(), SceneError> {
        let Self { pile, pipeline, contacts, scratch } = self;
        let scene = pile.scene();
        contacts.clear();
        let touching = pipeline.step(scene, Par::WarmPool);
        contacts.extend(touching.contacts().filter_map(|(i, j)| contact(scene, i, j, scratch)));
        pile.advance(contacts)
    }
}

/// How deep two touching objects overlap; none for shapes that have no depth here.
fn contact(scene: &Scene, i: u32, j: u32, scratch: &mut epa::Scratch) -> Option<PileContact> {
    let [a, b] = [i as usize, j as usize];
    let (shape_a, shape_b) = (scene.shape(a).as_polytope()?, scene.shape(b).as_polytope()?);
    let found = epa::depth_of_overlap(
        PosedSupport::polytope(shape_a, &scene.poses()[a]),
        PosedSupport::polytope(shape_b, &scene.poses()[b]),
        scratch,
    );
    Some(PileContact {
        pair: Pair::new(i, j),
        normal: found.normal,
        depth: found.depth,
        point: (found.point_a + found.point_b) * 0.5,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pile_comes_to_rest_on_its_slab() {
        let mut falling = Falling::new(Pile::new(60, 2).unwrap());
        let mut deepest = 0.0f64;
        for frame in 0..300 {
            falling.advance().unwrap();
            if frame > 200 {
                deepest = falling.contacts.iter().fold(deepest, |most, c| most.max(c.depth));
            }
        }
        let poses = falling.pile.scene().poses();
        let lowest = poses[1..].iter().map(|pose| pose.translation().z).fold(9.0, f64::min);
        let before = poses.to_vec();
        falling.advance().unwrap();
        let moved = falling.pile.scene().poses().iter().zip(&before);
        let fastest = moved.map(|(a, b)| a.translation().distance(b.translation()));
        let fastest = 60.0 * fastest.fold(0.0, f64::max);
        println!(
            "{} contacts, deepest {deepest} m, lowest {lowest} m, fastest {fastest} m/s",
            falling.contacts.len()
        );
        assert!(falling.contacts.len() > 60);
        // Hulls half a metre wide and more: no centre is below the slab, none flies.
        assert!(deepest < 0.1 && lowest > 0.05 && fastest < 1.0);
    }
}
