//! When shapes without thickness meet: what is proved of their motions holds at every sample.

use super::degenerate::{KINDS, thin, without_area};
use super::manifold_points::{CONVEX, convex, place, turn, verdict};
use super::scenes::Draw;
use dcd_geom::{Pose, Shape};
use dcd_gjk::motion::{Impact, MovingShape, RigidMotion, time_of_impact};
use dcd_gjk::{PosedShape, Verdict};

const UNTIL: f64 = 2.0;
const SAMPLES: usize = 40;

fn shape(draw: &mut Draw, k: usize) -> Shape {
    match k % 4 {
        0 => convex(draw, k / 4 % CONVEX, true),
        1 => {
            let triangles: Vec<_> = (0..3).map(|j| without_area(draw, k + j)).collect();
            let numbers = (0..3).map(|j| [0, 1, 2].map(|corner| 3 * j + corner)).collect();
            Shape::mesh(triangles.concat(), numbers).unwrap()
        }
        _ => thin(draw, k / 4 % KINDS, 1.0),
    }
}

fn motion(draw: &mut Draw, k: usize) -> RigidMotion {
    let round = k % 3 < 2;
    let from = place(draw, round) * 2.0;
    // Most pass the origin.
    let past = place(draw, round) * [0.0, 0.3, 2.0][k / 2 % 3];
    RigidMotion {
        start: Pose::from_matrix(turn(draw, round), from).unwrap(),
        linear: past - from * [0.0, 0.5, 1.0, 4.0][k % 4],
        angular: place(draw, round) * [0.0, 0.0, 3.0, 1e-7][k / 2 % 4],
        centre: place(draw, round) * 0.5,
    }
}

#[test]
fn thin_shapes_meet_when_their_samples_say() {
    let mut draw = Draw::seeded(47);
    let [mut free, mut hits, mut open] = [0; 3];
    for k in 0..4_000usize {
        let shapes = [shape(&mut draw, k), shape(&mut draw, k / 5)];
        let motions = [motion(&mut draw, k), motion(&mut draw, k / 7)];
        let touch_at = |t: f64| {
            let poses = motions.map(|motion| motion.pose_at(t).unwrap());
            let [a, b] = [0, 1].map(|k| PosedShape { shape: &shapes[k], pose: &poses[k] });
            verdict(a, b)
        };
        let [a, b] = [0, 1].map(|k| MovingShape { shape: &shapes[k], motion: &motions[k] });
        let found = time_of_impact(a, b, UNTIL, 1e-6).unwrap();
        let free_until = match found {
            Impact::Free => {
                free += 1;
                UNTIL
            }
            Impact::Hit { free_until, t, touches, point_a, point_b, .. } => {
                hits += 1;
                assert!(free_until <= t && t <= UNTIL, "{k}: {found:?}");
                assert!(!touches || touch_at(t) != Verdict::Apart, "{k}: {found:?}");
                let gap = point_a.distance(point_b);
                assert!(touches || gap <= 1.001e-6, "{k}: {gap} {found:?}");
                free_until
            }
            Impact::Undecided { free_until } => {
                open += 1;
                free_until
            }
        };
        for sample in 0..SAMPLES {
            let t = free_until * (sample as f64 / SAMPLES as f64);
            let touches = free_until > 0.0 && touch_at(t) == Verdict::Touching(());
            assert!(!touches, "{k}: at {t}, {found:?} {shapes:?} {motions:?}");
        }
    }
    assert!(free > 500 && hits > 500 && open < 40, "{free} {hits} {open}");
}
