//! Rays against shapes without thickness, along their faces and through their edges and corners: a hit's bracket against certified
//! overlaps of pieces of the ray.

use super::degenerate::{KINDS, thin, without_area};
use super::manifold_points::{CONVEX, convex, place, turn, verdict};
use super::scenes::Draw;
use dcd_geom::{Pose, Shape};
use dcd_gjk::query::ray::{Ray, first_hit};
use dcd_gjk::{PosedShape, Verdict};

/// What pieces of the ray are lengthened or shortened by, relative to the numbers at hand: their own ends are rounded.
const ROUNDING: f64 = 1e-12;

fn shape(draw: &mut Draw, k: usize) -> Shape {
    match k % 4 {
        0 => convex(draw, k / 4 % CONVEX, true),
        1 => {
            let triangle = |draw: &mut Draw, j: usize| match j % 2 {
                0 => without_area(draw, k + j),
                _ => [0; 3].map(|_| place(draw, true)),
            };
            let triangles: Vec<_> = (0..3).map(|j| triangle(draw, j)).collect();
            let numbers = (0..3).map(|j| [0, 1, 2].map(|corner| 3 * j + corner)).collect();
            Shape::mesh(triangles.concat(), numbers).unwrap()
        }
        _ => thin(draw, k / 4 % KINDS, 1.0),
    }
}

#[test]
fn rays_meet_thin_shapes_where_their_pieces_touch_them() {
    let mut draw = Draw::seeded(59);
    let [mut hits, mut misses] = [0; 2];
    for k in 0..30_000usize {
        let shape = shape(&mut draw, k);
        let round = k % 3 < 2;
        let pose = Pose::from_matrix(turn(&mut draw, round), place(&mut draw, round)).unwrap();
        let (from, to) = (place(&mut draw, round) * 2.0, place(&mut draw, round));
        let Ok(ray) = Ray::between(from, to) else { continue };
        let posed = PosedShape { shape: &shape, pose: &pose };
        let piece = |from: f64, to: f64| {
            let segment = Shape::segment(ray.at(from), ray.at(to)).unwrap();
            verdict(posed, PosedShape { shape: &segment, pose: &Pose::IDENTITY })
        };
        let what = format!("{k}: {shape:?} {pose:?} {ray:?}");
        match first_hit(&ray, posed) {
            Some(hit) => {
                hits += 1;
                let before = hit.t_lower - ROUNDING;
                let is_early = before > 0.0 && piece(0.0, before) == Verdict::Touching(());
                assert!(!is_early, "{what}: touches before {hit:?}");
                let is_late = piece(0.0, hit.t_upper + ROUNDING) == Verdict::Apart;
                assert!(!hit.is_certain || !is_late, "{what}: does not touch until {hit:?}");
            }
            None => {
                misses += 1;
                assert!(piece(0.0, 1.0) != Verdict::Touching(()), "{what}: touches");
            }
        }
    }
    assert!(hits > 2_000 && misses > 3_000, "{hits} {misses}");
}
