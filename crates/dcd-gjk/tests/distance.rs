//! The distance and its bound against every feature in whole numbers.

mod judge;

use dcd_geom::Shape;
use dcd_geom::glam::DVec3;
use dcd_gjk::certified::overlap_exactly;
use dcd_gjk::{Distance, DistanceResult, distance};
use judge::cases::{Draw, aligned, bisected, lattice, random};
use judge::{PosedShape, distance_is_in};

/// Checks both ways' answers; the certified distance where they are apart.
fn measured([a, b]: &[PosedShape; 2]) -> Option<Distance> {
    let (result, _) = distance::of_polytopes(a.body(), b.body());
    let (mirrored, _) = distance::of_polytopes(b.body(), a.body());
    let (shape_a, shape_b) = (Shape::from(a.shape.clone()), Shape::from(b.shape.clone()));
    let placed_a = dcd_gjk::PosedShape { shape: &shape_a, pose: &a.pose };
    let placed_b = dcd_gjk::PosedShape { shape: &shape_b, pose: &b.pose };
    let plain = distance::in_f64(placed_a, placed_b);
    let touches = overlap_exactly(a.body(), b.body());
    match result {
        DistanceResult::Apart(found) => {
            assert!(!touches && plain != DistanceResult::Touching, "{a:?}\n{b:?}");
            let DistanceResult::Apart(seen_from_b) = mirrored else { panic!("{a:?}\n{b:?}") };
            assert_eq!((seen_from_b.point_a, seen_from_b.point_b), (found.point_b, found.point_a));
            assert_eq!(seen_from_b.normal, -found.normal);
            must_hold(a, b, &found);
            if let DistanceResult::Apart(plain) = plain {
                must_hold(a, b, &plain);
            }
            if let DistanceResult::Interval { within: plain, .. } = plain {
                assert!(plain.distance == 0.0 && distance_is_in(a, b, 0.0, plain.upper()));
            }
            Some(found)
        }
        DistanceResult::Touching => {
            assert!(touches && mirrored == result, "{a:?}\n{b:?}");
            assert!(!matches!(plain, DistanceResult::Apart(_)), "{a:?}\n{b:?}");
            None
        }
        DistanceResult::Interval { reason, .. } | DistanceResult::Undecided(reason) => {
            panic!("{reason:?} {a:?}\n{b:?}")
        }
    }
}

fn must_hold(a: &PosedShape, b: &PosedShape, found: &Distance) {
    let Distance { distance, point_a, point_b, normal, error_bound } = *found;
    let low = (distance - error_bound).next_down().max(0.0);
    let high = (distance + error_bound).next_up();
    assert!(distance_is_in(a, b, low, high), "{found:?}\n{a:?}\n{b:?}");
    assert!((normal.length() - 1.0).abs() < 1e-15, "{found:?}");
    let world = a.pose.translation().length() + a.shape.reach() + a.shape.swept_radius();
    let along = point_b - point_a - normal * distance;
    assert!(along.length() <= 1e-14 * (world + distance) + error_bound, "{found:?} {along}");
}

/// The size that the promise of a small relative error speaks of.
fn size(a: &PosedShape, b: &PosedShape) -> f64 {
    a.shape.reach() + b.shape.reach() + a.pose.translation().distance(b.pose.translation())
}

#[test]
fn distances_of_any_hulls_hold_and_are_right_in_twelve_digits() {
    let mut draw = Draw(11);
    let mut apart = 0;
    for k in 0..400 {
        let [a, b] = if k % 2 == 0 { random(&mut draw, 5) } else { lattice(&mut draw, 5) };
        let b = b.moved_to(b.pose.translation() * (1.0 + (k % 3) as f64));
        if let Some(found) = measured(&[a, b]) {
            assert!(found.error_bound <= 1e-15 * found.distance, "{found:?}");
            apart += 1;
        }
    }
    assert!(apart > 200, "{apart}");
}

#[test]
fn gaps_between_neighbouring_floats_are_measured() {
    let mut draw = Draw(12);
    let mut gaps = 0;
    for k in 0..400 {
        let pair = match k % 3 {
            0 => random(&mut draw, 5),
            1 => aligned(&mut draw),
            _ => lattice(&mut draw, 5),
        };
        if k % 3 == 1 && pair.iter().all(|p| p.shape.vertices().len() > 5) && k > 20 {
            continue; // boxes have 64 differences: slow to judge
        }
        let quick = |a: &PosedShape, b: &PosedShape| overlap_exactly(a.body(), b.body());
        if let Some([touching, apart]) = bisected(&pair, draw.vector(), quick) {
            assert!(measured(&touching).is_none());
            let found = measured(&apart).unwrap();
            let [a, b] = &apart;
            assert!(found.distance < 1e-12 * size(a, b), "{found:?}");
            // A lattice point moved by the least f64 leaves a gap of it, and no digit to be right.
            let least = found.distance < f64::MIN_POSITIVE;
            assert!(least || found.error_bound <= 1e-12 * found.distance, "{found:?}");
            gaps += 1;
        }
    }
    assert!(gaps > 30, "{gaps}");
}

#[test]
fn distances_at_any_scale_and_far_from_the_origin_hold() {
    let mut draw = Draw(13);
    for k in 0..120 {
        let scale = [1e-300, 1e-9, 1e-3, 1e3, 1e9, 1e290][k % 6];
        let [a, b] = random(&mut draw, 4).map(|placed| placed.scaled(scale));
        measured(&[a.clone(), b.clone()]);
        let far = DVec3::new(1e9, -1e9, 1e9) * scale;
        let [a, b] = [a, b].map(|p| p.moved_to(p.pose.translation() + far));
        measured(&[a, b]);
    }
}

#[test]
fn distances_of_rounded_hulls_hold() {
    let mut draw = Draw(14);
    let mut apart = 0;
    for k in 0..160 {
        let radii = [draw.below(4) as f64 / 16.0, draw.unit().abs() * 0.25];
        let pair = if k % 2 == 0 { random(&mut draw, 4) } else { lattice(&mut draw, 4) };
        let [a, b] = pair;
        let rounded =
            |p: PosedShape, r| PosedShape { shape: p.shape.rounded(r).unwrap(), pose: p.pose };
        let pair = [rounded(a, radii[0]), rounded(b, radii[1])];
        apart += usize::from(measured(&pair).is_some());
        let quick = |a: &PosedShape, b: &PosedShape| overlap_exactly(a.body(), b.body());
        if k % 4 == 0
            && let Some([touching, apart]) = bisected(&pair, draw.vector(), quick)
        {
            assert!(measured(&touching).is_none());
            measured(&apart).unwrap();
        }
    }
    assert!(apart > 20, "{apart}");
}
