//! What a scene can ask beyond yes or no.

mod depths;
mod distances;
mod manifolds;
mod proximity;
mod scenes;
mod within;

use dcd_geom::glam::{DQuat, DVec3};
use dcd_geom::{Pose, Shape};
use dcd_gjk::{PairSolver, Placed, Verdict};

/// A shape and where it is.
#[derive(Clone, Debug)]
struct Body {
    shape: Shape,
    pose: Pose,
}

impl Body {
    fn new(shape: Shape, turn: DQuat, place: DVec3) -> Self {
        Self { shape, pose: Pose::new(turn, place).unwrap() }
    }

    fn at(shape: &Shape, place: DVec3) -> Self {
        Self::new(shape.clone(), DQuat::IDENTITY, place)
    }

    fn placed(&self) -> Placed<'_> {
        Placed { shape: &self.shape, pose: &self.pose }
    }
}

fn ask<S: PairSolver>(solver: &S, a: &Body, b: &Body) -> Verdict<S::Answer> {
    solver.solve(a.placed(), b.placed(), &mut S::Scratch::default())
}

/// What is told of a pair that touches, or is within the margin.
fn told<S: PairSolver>(solver: &S, a: &Body, b: &Body) -> S::Answer {
    let Verdict::Touching(answer) = ask(solver, a, b) else { panic!("{a:?}\n{b:?}") };
    answer
}
