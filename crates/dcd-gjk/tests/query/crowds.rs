//! Crowds of shapes of all kinds on a grid, where faces, edges and corners meet exactly: what a scene answers is what every two
//! of their convex parts answer alone.

use super::degenerate::{KINDS, thin, without_area};
use super::manifold_points::{ROUNDING, judge_all, judge_depths, place, shape, turn, verdict};
use super::scenes::Draw;
use dcd_geom::glam::DVec3;
use dcd_geom::{Pose, Shape};
use dcd_gjk::{PosedShape, Verdict};
use dcd_pipeline::prelude::{Par, Pipeline, Scene};

/// A shape, and its convex parts in its own frame, made without it.
struct Member {
    shape: Shape,
    parts: Vec<Shape>,
}

/// Triangles on a grid of quarters, some without area.
fn mesh(draw: &mut Draw, k: usize) -> Member {
    let count = 1 + k % 21;
    let triangle = |draw: &mut Draw, j: usize| match (k + j) % 5 {
        0 => without_area(draw, j),
        _ => [0; 3].map(|_| place(draw, true)),
    };
    let triangles: Vec<_> = (0..count).map(|j| triangle(draw, j)).collect();
    let numbers = (0..count as u32).map(|j| [3 * j, 3 * j + 1, 3 * j + 2]).collect();
    let hull = |corners: &[DVec3; 3]| Shape::hull(corners.to_vec()).unwrap();
    let parts = triangles.iter().map(hull).collect();
    Member { shape: Shape::mesh(triangles.concat(), numbers).unwrap(), parts }
}

fn compound(draw: &mut Draw, k: usize) -> Member {
    let part = |draw: &mut Draw, j: usize| {
        let pose = Pose::from_matrix(turn(draw, true), place(draw, true) * 0.5).unwrap();
        (convex(draw, 7 * k + j), pose)
    };
    let shape = Shape::compound((0..1 + k % 9).map(|j| part(draw, j)).collect()).unwrap();
    let Shape::Compound(made) = &shape else { panic!("no compound") };
    let parts = made.parts().iter().map(|part| part.placed().clone()).collect();
    Member { shape, parts }
}

fn convex(draw: &mut Draw, k: usize) -> Shape {
    match k % 3 {
        0 => thin(draw, k / 3 % KINDS, 1.0),
        // As many cylinders and cones as others would leave much undecided.
        _ => shape(draw, [0, 1, 2, 3, 7, 8][k / 3 % 6], true),
    }
}

fn member(draw: &mut Draw, k: usize) -> Member {
    match k % 6 {
        0 => mesh(draw, k / 6),
        1 => compound(draw, k / 6),
        _ => {
            let shape = convex(draw, k);
            Member { parts: vec![shape.clone()], shape }
        }
    }
}

/// Whether parts of two members touch, as certified pairs say; `None` where that is undecided.
fn due(members: [&Member; 2], poses: [&Pose; 2]) -> Option<bool> {
    let mut is_open = false;
    for part_a in &members[0].parts {
        for part_b in &members[1].parts {
            let [a, b] = [(part_a, poses[0]), (part_b, poses[1])]
                .map(|(shape, pose)| PosedShape { shape, pose });
            match verdict(a, b) {
                Verdict::Touching(()) => return Some(true),
                Verdict::Apart => {}
                Verdict::Undecided(_) => is_open = true,
            }
        }
    }
    (!is_open).then_some(false)
}

#[test]
fn crowds_touch_as_their_parts_do() {
    let mut draw = Draw::seeded(53);
    let [mut apart, mut touching, mut open] = [0; 3];
    for k in 0..60usize {
        let members: Vec<_> = (0..40).map(|j| member(&mut draw, 41 * k + j)).collect();
        let pose = |draw: &mut Draw| {
            let round = k % 4 < 3;
            Pose::from_matrix(turn(draw, round), place(draw, round) * 1.5).unwrap()
        };
        let poses: Vec<_> = (0..40).map(|_| pose(&mut draw)).collect();
        let shapes = members.iter().map(|member| member.shape.clone()).collect();
        let scene = Scene::one_each(shapes, poses.clone()).unwrap();
        let mut pipeline = Pipeline::new();
        let step = pipeline.step(&scene, Par::Serial);
        let found: Vec<_> = step.answers().map(|found| [found.pair.i, found.pair.j]).collect();
        let unsure: Vec<_> =
            step.report().undecided().iter().map(|found| [found.pair.i, found.pair.j]).collect();
        for i in 0..40usize {
            for j in i + 1..40 {
                let pair = [i as u32, j as u32];
                if unsure.contains(&pair) {
                    open += 1;
                    continue;
                }
                let touches = found.contains(&pair);
                let due = due([&members[i], &members[j]], [&poses[i], &poses[j]]);
                assert!(
                    due.is_none_or(|due| due == touches),
                    "{k}: {pair:?} {touches}, not {due:?}"
                );
                apart += usize::from(due == Some(false));
                touching += usize::from(due == Some(true));
            }
        }
    }
    assert!(apart > 20_000 && touching > 4_000 && open < 400, "{apart} {touching} {open}");
}

#[test]
fn two_of_a_crowd_have_manifolds_that_are_true_and_depths_that_agree() {
    let mut draw = Draw::seeded(61);
    let mut judged = 0;
    for k in 0..8_000usize {
        let members = [member(&mut draw, k), member(&mut draw, k / 6)];
        let round = k % 4 < 3;
        let poses = [0; 2].map(|_| {
            Pose::from_matrix(turn(&mut draw, round), place(&mut draw, round) * 0.7).unwrap()
        });
        let [a, b] = [0, 1].map(|k| PosedShape { shape: &members[k].shape, pose: &poses[k] });
        if verdict(a, b) != Verdict::Touching(()) {
            continue;
        }
        let what = format!("{k}");
        judged += judge_all([a, b], false, (ROUNDING, &what));
        judge_depths([a, b], (1e-12, &what));
    }
    assert!(judged > 5_000, "{judged}");
}
