//! The last method against a judge of another method.

mod judge;

use dcd_geom::glam::DVec3;
use dcd_geom::{Polytope, Pose};
use dcd_gjk::certified::overlap_exactly;
use judge::cases::{Draw, aligned, bisected, lattice, random};
use judge::{PosedShape, touches};

fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::from_translation(DVec3::new(x, y, z)).unwrap()
}

/// The method's answer, after the judge has agreed.
fn resolved([a, b]: &[PosedShape; 2]) -> bool {
    let answer = overlap_exactly(a.body(), b.body());
    assert_eq!(answer, touches(a, b), "{a:?}\n{b:?}");
    assert_eq!(answer, overlap_exactly(b.body(), a.body()));
    answer
}

#[test]
fn the_judge_knows_what_can_be_solved_by_hand() {
    let cube = Polytope::cuboid(DVec3::splat(0.5)).unwrap();
    let square = Polytope::cuboid(DVec3::new(1.0, 1.0, 0.0)).unwrap();
    let segment = Polytope::hull(vec![DVec3::ZERO, DVec3::new(3.0, 4.0, 0.0)]).unwrap();
    let point = Polytope::hull(vec![DVec3::ZERO]).unwrap();
    let placed = |shape: &Polytope, pose| PosedShape { shape: shape.clone(), pose };
    let cases = [
        (placed(&cube, at(0.0, 0.0, 0.0)), placed(&cube, at(1.0, 1.0, 1.0)), true),
        (placed(&cube, at(0.0, 0.0, 0.0)), placed(&cube, at(1.0 + 1e-15, 1.0, 1.0)), false),
        (placed(&cube, at(0.0, 0.0, 0.0)), placed(&cube, at(0.0, 0.0, 0.0)), true),
        (placed(&square, at(0.0, 0.0, 0.0)), placed(&square, at(0.0, 0.0, 1e-300)), false),
        (placed(&square, at(0.0, 0.0, 0.0)), placed(&square, at(2.0, 2.0, 0.0)), true),
        (placed(&segment, at(0.0, 0.0, 0.0)), placed(&point, at(1.5, 2.0, 0.0)), true),
        (placed(&segment, at(0.0, 0.0, 0.0)), placed(&point, at(1.5, 2.1, 0.0)), false),
        (placed(&segment, at(0.0, 0.0, 0.0)), placed(&point, at(6.0, 8.0, 0.0)), false),
        (placed(&point, at(1.0, 0.0, 0.0)), placed(&point, at(1.0, 0.0, 0.0)), true),
    ];
    for (a, b, expected) in cases {
        assert_eq!(touches(&a, &b), expected, "{a:?} {b:?}");
    }
    // A sphere of 1 beside a line through (3, 4): 4/5 of its distance along x.
    let sphere = |x: f64| placed(&point.clone().rounded(4.0).unwrap(), at(x, 0.0, 0.0));
    assert!(touches(&placed(&segment, at(0.0, 0.0, 0.0)), &sphere(5.0)));
    assert!(!touches(&placed(&segment, at(0.0, 0.0, 0.0)), &sphere(5.0f64.next_up())));
}

#[test]
fn lattice_hulls_are_judged_alike() {
    let mut draw = Draw(1);
    let hits = (0..2000).filter(|_| resolved(&lattice(&mut draw, 7))).count();
    assert!((250..1750).contains(&hits), "{hits}");
}

#[test]
fn hulls_of_any_points_are_judged_alike() {
    let mut draw = Draw(2);
    let hits = (0..1000).filter(|_| resolved(&random(&mut draw, 8))).count();
    assert!((100..900).contains(&hits), "{hits}");
}

#[test]
fn hulls_between_neighbouring_floats_are_judged_alike() {
    let mut draw = Draw(3);
    let mut flips = 0;
    for k in 0..150 {
        let pair = match k % 3 {
            0 => random(&mut draw, 8),
            1 => aligned(&mut draw),
            _ => lattice(&mut draw, 6),
        };
        let quick = |a: &PosedShape, b: &PosedShape| overlap_exactly(a.body(), b.body());
        if let Some([touching, apart]) = bisected(&pair, draw.vector(), quick) {
            assert!(resolved(&touching) && !resolved(&apart));
            flips += 1;
        }
    }
    assert!(flips > 50, "{flips}");
}

#[test]
fn extreme_scales_are_judged_alike() {
    let mut draw = Draw(4);
    for k in 0..60 {
        let scale = [2f64.powi(-1060), 1e-300, 1e-9, 1e9, 1e300, 2f64.powi(1018)][k % 6];
        let pair = if k % 2 == 0 { lattice(&mut draw, 6) } else { random(&mut draw, 6) };
        resolved(&pair.map(|placed| placed.scaled(scale)));
    }
    for _ in 0..40 {
        let [a, b] = random(&mut draw, 6);
        resolved(&[a.scaled(1e-200), b.scaled(1e200)]);
    }
}

#[test]
fn rounded_hulls_are_judged_alike() {
    let mut draw = Draw(5);
    let mut hits = 0;
    for k in 0..60 {
        let pair = if k % 2 == 0 { lattice(&mut draw, 4) } else { random(&mut draw, 4) };
        let radii = [draw.below(5) as f64 / 8.0, draw.below(5) as f64 / 8.0];
        let [a, b] = pair;
        let rounded =
            |p: PosedShape, r| PosedShape { shape: p.shape.rounded(r).unwrap(), pose: p.pose };
        let pair = [rounded(a, radii[0]), rounded(b, radii[1])];
        hits += usize::from(resolved(&pair));
        let quick = |a: &PosedShape, b: &PosedShape| overlap_exactly(a.body(), b.body());
        if k % 5 == 0
            && let Some([touching, apart]) = bisected(&pair, draw.vector(), quick)
        {
            assert!(resolved(&touching) && !resolved(&apart));
        }
    }
    assert!((10..58).contains(&hits), "{hits}");
}
