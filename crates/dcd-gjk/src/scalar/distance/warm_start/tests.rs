//! The search in f32 ends, mostly, with the vertices that the one in f64 ends with.

use super::*;
use crate::PosedSupport;
use crate::certificate::Bounds;
use crate::distance::approach::{Approach, approach, approach_from};
use crate::motion::tests::Draw;
use dcd_geom::Pose;
use dcd_geom::glam::DQuat;
use dcd_simd::{Path, dispatch_on};

/// Hulls of few vertices and of many, cuboids, triangles, segments, points, every third one far from its own origin.
fn polytope(draw: &mut Draw, k: usize) -> Polytope {
    let from = [DVec3::ZERO, DVec3::ZERO, DVec3::splat(1e4)][k % 3];
    match k % 7 {
        0 => Polytope::cuboid(draw.vector().abs() * 0.3 + 0.1).unwrap(),
        count @ 1..4 => Polytope::hull((0..count).map(|_| from + draw.vector()).collect()).unwrap(),
        _ => Polytope::hull((0..4 + k % 60).map(|_| from + draw.vector()).collect()).unwrap(),
    }
}

/// Two poses, from touching to far.
fn poses(draw: &mut Draw, polytopes: [&Polytope; 2]) -> [Pose; 2] {
    let away = draw.vector() * [0.5, 2.0, 4.0][(draw.vector().x.abs() * 3.0) as usize % 3];
    [0, 1].map(|k| {
        let turn = DQuat::from_scaled_axis(draw.vector() * 3.0);
        let centre = turn * polytopes[k].inner().centre;
        Pose::new(turn, away * k as f64 - centre).unwrap()
    })
}

/// The features of a simplex, in the order of their numbers.
fn features(simplex: &Simplex<f64>) -> Vec<[u32; 2]> {
    let mut found: Vec<_> = simplex.vertices().iter().map(|v| [v.a.feature, v.b.feature]).collect();
    found.sort_unstable();
    found
}

#[test]
fn a_warm_start_is_mostly_where_the_search_in_f64_ends() {
    let mut draw = Draw(61);
    let [mut apart, mut same] = [0; 2];
    for k in 0..4000 {
        let (a, b) = (polytope(&mut draw, k), polytope(&mut draw, k / 7));
        let [at_a, at_b] = poses(&mut draw, [&a, &b]);
        let posed = (PosedSupport::polytope(&a, &at_a), PosedSupport::polytope(&b, &at_b));
        let difference = Difference::<f64, _, _>::new(posed.0, posed.1).unwrap();
        let bounds = Bounds::of(&difference);
        let cold = approach_from(&difference, &bounds, [0.0, f64::MAX], Simplex::default());
        let mut start = Simplex::default();
        warm_start(&difference, &mut start);
        let warm = approach_from(&difference, &bounds, [0.0, f64::MAX], start);
        let Ok(cold) = cold else {
            assert!(warm.is_err(), "{k}");
            continue;
        };
        let warm = warm.unwrap();
        assert!(warm.lower <= cold.upper && cold.lower <= warm.upper, "{k}");
        assert!((warm.length - cold.length).abs() <= 1e-12, "{k}");
        let have_few = a.vertices().len() <= 8 && b.vertices().len() <= 8;
        assert_eq!(start.vertices().is_empty(), have_few, "{k}");
        if !have_few {
            apart += 1;
            same += usize::from(features(&start) == features(&warm.simplex));
        }
    }
    assert!(apart > 1000 && same * 100 > apart * 95, "{same} of {apart}");
}

#[test]
fn every_path_ends_with_the_same_vertices() {
    let mut draw = Draw(62);
    for k in 0..1500 {
        let (a, b) = (polytope(&mut draw, k), polytope(&mut draw, k / 5));
        let [at_a, at_b] = poses(&mut draw, [&a, &b]);
        let posed = (PosedSupport::polytope(&a, &at_a), PosedSupport::polytope(&b, &at_b));
        let difference = Difference::<f64, _, _>::new(posed.0, posed.1).unwrap();
        let [a, b] = [&a, &b].map(Core::Polytope);
        let search = || Search { a, b, frame: Frame::of(&difference) };
        let due = dispatch_on(Path::Portable, search());
        for path in Path::ALL {
            let found = dispatch_on(path, search());
            assert_eq!(found.list(), due.list(), "{k} {path:?}");
        }
    }
}

#[test]
fn sizes_beyond_f32_have_no_warm_start() {
    let mut draw = Draw(63);
    for scale in [1e-30, 1e30] {
        let mut hull = || Polytope::hull((0..12).map(|_| draw.vector() * scale).collect()).unwrap();
        let (a, b) = (hull(), hull());
        let away = Pose::from_translation(DVec3::X * 4.0 * scale).unwrap();
        let posed =
            (PosedSupport::polytope(&a, &Pose::IDENTITY), PosedSupport::polytope(&b, &away));
        let difference = Difference::<f64, _, _>::new(posed.0, posed.1).unwrap();
        let mut start = Simplex::default();
        warm_start(&difference, &mut start);
        assert!(start.vertices().is_empty());
    }
}

/// A cuboid, and a corner of a hull of many vertices on the diagonal of its face, where rounding has it.
fn hardly_apart(draw: &mut Draw, k: usize) -> ([Polytope; 2], [Pose; 2]) {
    let half = draw.vector().abs() * 0.4 + 0.1;
    let share = [0.0, 0.5, draw.number()][k % 3];
    let on_face = DVec3::new(half.x * share, half.y * share, half.z);
    let turn = DQuat::from_scaled_axis(draw.vector() * 3.0).normalize();
    let pose = Pose::new(turn, draw.vector() * [0.0, 1e3][k / 3 % 2]).unwrap();
    let above = (0..23).map(|_| DVec3::new(draw.number(), draw.number(), 1.0 + draw.number()));
    let corners = std::iter::once(DVec3::ZERO).chain(above).map(|corner| turn * corner);
    let other = Polytope::hull(corners.collect()).unwrap();
    let at = Pose::from_translation(pose.apply(on_face)).unwrap();
    ([Polytope::cuboid(half).unwrap(), other], [pose, at])
}

#[test]
fn of_what_is_hardly_apart_no_less_is_known_than_from_afar() {
    let mut draw = Draw(64);
    let mut known = 0;
    for k in 0..6000 {
        let ([a, b], [at_a, at_b]) = hardly_apart(&mut draw, k);
        let posed = (PosedSupport::polytope(&a, &at_a), PosedSupport::polytope(&b, &at_b));
        let difference = Difference::<f64, _, _>::new(posed.0, posed.1).unwrap();
        let bounds = Bounds::of(&difference);
        let cold = approach_from(&difference, &bounds, [0.0, f64::MAX], Simplex::default());
        let mut found = Approach::begin(&difference);
        let is_found = approach(&difference, &bounds, 0.0, &mut found).is_ok();
        let (Ok(cold), true) = (cold, is_found) else { continue };
        assert!(found.lower >= cold.lower.min(0.0), "{k}: {} {}", found.lower, cold.lower);
        known += 1;
    }
    assert!(known > 2000, "{known}");
}
