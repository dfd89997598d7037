//! Penetration depth against hand, exact arithmetic, and any finite number.

mod by_hand;
mod extreme;
mod random;

use dcd_geom::glam::DVec3;
use dcd_geom::{Polytope, Pose};
use dcd_gjk::epa::{self, Depth, Scratch};
use dcd_gjk::{PosedSupport, Verdict};

/// A shape and where it is.
type PosedShape = (Polytope, Pose);

fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::from_translation(DVec3::new(x, y, z)).unwrap()
}

fn hull(points: &[[f64; 3]]) -> Polytope {
    Polytope::hull(points.iter().map(|&p| p.into()).collect()).unwrap()
}

fn cube() -> Polytope {
    Polytope::cuboid(DVec3::splat(0.5)).unwrap()
}

fn solve(a: &PosedShape, b: &PosedShape) -> Verdict<Depth> {
    let body = |(map, pose)| PosedSupport::polytope(map, pose);
    let (a, b) = ((&a.0, &a.1), (&b.0, &b.1));
    epa::depth(body(a), body(b), &mut Scratch::default())
}

/// The depth, whether or not the query could prove the contact.
fn overlap(a: &PosedShape, b: &PosedShape) -> Depth {
    let body = |(map, pose)| PosedSupport::polytope(map, pose);
    let (a, b) = ((&a.0, &a.1), (&b.0, &b.1));
    epa::depth_of_overlap(body(a), body(b), &mut Scratch::default())
}

fn touching(a: &PosedShape, b: &PosedShape) -> Depth {
    match solve(a, b) {
        Verdict::Touching(depth) => depth,
        other => panic!("{other:?} for {a:?} and {b:?}"),
    }
}
