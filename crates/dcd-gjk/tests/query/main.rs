//! Queries beyond yes or no.

mod both_orders;
mod core_contacts;
mod crowds;
mod degenerate;
mod depths;
mod distances;
mod hardly_touching;
mod lane_depths;
mod lane_parts;
mod manifold_points;
mod manifolds;
mod mesh_boxes;
mod nearest_parts;
mod patches;
mod proximity;
mod ranks;
mod rough_faces;
mod round_depths;
mod round_distances;
mod scenes;
mod sphere_scenes;
mod surfaces;
mod swept_surfaces;
mod thin_impacts;
mod thin_rays;
mod undecided;
mod upright;
mod within;

use dcd_geom::glam::{DQuat, DVec3};
use dcd_geom::{Pose, Shape};
use dcd_gjk::{PairSolver, PosedShape, Verdict};

/// A shape and where it is.
#[derive(Clone, Debug)]
struct PosedSupport {
    shape: Shape,
    pose: Pose,
}

impl PosedSupport {
    fn new(shape: Shape, turn: DQuat, place: DVec3) -> Self {
        Self { shape, pose: Pose::new(turn, place).unwrap() }
    }

    fn at(shape: &Shape, place: DVec3) -> Self {
        Self::new(shape.clone(), DQuat::IDENTITY, place)
    }

    fn placed(&self) -> PosedShape<'_> {
        PosedShape { shape: &self.shape, pose: &self.pose }
    }
}

fn solve<S: PairSolver>(solver: &S, a: &PosedSupport, b: &PosedSupport) -> Verdict<S::Answer> {
    solver.solve(a.placed(), b.placed(), &mut S::Scratch::default())
}

/// The answer for a pair that touches, or is within the margin.
fn answer_of<S: PairSolver>(solver: &S, a: &PosedSupport, b: &PosedSupport) -> S::Answer {
    let Verdict::Touching(answer) = solve(solver, a, b) else { panic!("{a:?}\n{b:?}") };
    answer
}
