//! Simplified hulls: what they promise, seen on seeded shapes.

mod judge;

use dcd_geom::glam::{DQuat, DVec3};
use dcd_geom::{Pair, Polytope, Pose, Scene, Shape};
use dcd_gjk::certified::{overlap, overlap_exactly};
use dcd_gjk::simplify::{Budget, InnerOuter, Simplified, SimplifyError, simplify};
use dcd_gjk::{DistanceResult, PosedSupport, Reason, Verdict, distance};
use judge::cases::Draw;

/// Points on an ellipsoid, stretched and turned: all of them vertices.
fn round(draw: &mut Draw, count: usize, stretch: DVec3) -> Polytope {
    let turned = DQuat::from_rotation_y(draw.unit()) * DQuat::from_rotation_x(draw.unit());
    let point = |_| turned * (draw.vector().normalize() * stretch) + DVec3::new(3.0, 0.0, 0.0);
    Polytope::hull((0..count).map(point).collect()).unwrap()
}

fn body(polytope: &Polytope) -> PosedSupport<'_, Polytope> {
    PosedSupport::polytope(polytope, &Pose::IDENTITY)
}

/// The largest distance of a vertex of `from` from `to`: the Hausdorff distance where one holds the
/// other.
fn farthest(from: &Polytope, to: &Polytope) -> f64 {
    let core = Polytope::hull(to.vertices().to_vec()).unwrap();
    let mut most = 0.0f64;
    for &vertex in from.vertices() {
        let point = Polytope::hull(vec![vertex]).unwrap();
        if let (DistanceResult::Apart(found), _) = distance::of_polytopes(body(&point), body(&core))
        {
            most = most.max(found.lower());
        }
    }
    most
}

/// What always holds: the order of the three, the distances, the number of vertices.
fn assert_promises(shape: &Polytope, found: &Simplified, budget: Budget) {
    let Simplified { outer, inner, .. } = found;
    let core = Polytope::hull(outer.vertices().to_vec()).unwrap();
    for &vertex in shape.vertices() {
        let point = Polytope::hull(vec![vertex]).unwrap();
        assert!(overlap_exactly(body(&core), body(&point)), "{vertex} is outside");
    }
    assert!(inner.vertices().iter().all(|vertex| shape.vertices().contains(vertex)));
    assert!(outer.vertices().len() <= budget.vertices, "{}", outer.vertices().len());
    assert!(inner.vertices().len() <= budget.vertices, "{}", inner.vertices().len());
    assert!(farthest(outer, shape) <= found.outer_distance);
    assert!(farthest(shape, inner) <= found.inner_distance);
    assert_eq!(outer.swept_radius(), shape.swept_radius());
    assert_eq!(inner.swept_radius(), shape.swept_radius());
}

const FORMS: [DVec3; 5] = [
    DVec3::ONE,
    DVec3::new(0.1, 0.1, 2.0),
    DVec3::new(1.0, 1.0, 0.02),
    DVec3::new(1.0, 1.0, 0.0),
    DVec3::new(1.0, 0.0, 0.0),
];

#[test]
fn both_hulls_keep_their_promises_whatever_the_shape_and_the_budget() {
    let mut draw = Draw(41);
    for scale in [1e-3, 1.0, 1e3] {
        for stretch in FORMS {
            let shape = round(&mut draw, 150, stretch);
            let vertices = shape.vertices().iter().map(|&v| v * scale).collect();
            let shape = Polytope::hull(vertices).unwrap().rounded(0.125 * scale).unwrap();
            for vertices in [8, 20, 60] {
                for tolerance in [0.0, 0.01, 0.2] {
                    let budget = Budget { tolerance: tolerance * scale, vertices };
                    let found = simplify(&shape, budget).unwrap();
                    assert_promises(&shape, &found, budget);
                }
            }
        }
    }
}

#[test]
fn a_tolerance_that_the_vertices_suffice_for_is_met_with_few() {
    let mut draw = Draw(42);
    for stretch in [FORMS[0], FORMS[1], FORMS[2]] {
        let shape = round(&mut draw, 400, stretch);
        let mut last = usize::MAX;
        for tolerance in [0.05, 0.1, 0.2] {
            let found = simplify(&shape, Budget { tolerance, vertices: 300 }).unwrap();
            let most = found.outer_distance.max(found.inner_distance);
            assert!(found.is_within(tolerance), "{stretch} {tolerance}: {most}");
            let count = found.outer.vertices().len() + found.inner.vertices().len();
            assert!(count <= last && count < 500, "{stretch} {tolerance}: {count}");
            last = count;
        }
    }
}

#[test]
fn more_vertices_are_never_farther() {
    let mut draw = Draw(43);
    let shape = round(&mut draw, 300, DVec3::new(1.0, 0.7, 0.4));
    let mut last = [f64::MAX; 2];
    for vertices in [8, 12, 16, 24, 48, 96] {
        let found = simplify(&shape, Budget { tolerance: 0.0, vertices }).unwrap();
        let now = [found.outer_distance, found.inner_distance];
        assert!(now[0] <= last[0] && now[1] <= last[1], "{vertices}: {now:?} {last:?}");
        last = now;
    }
    assert!(last[0] < 0.1 && last[1] < 0.1, "{last:?}");
}

#[test]
fn a_shape_that_fits_the_budget_is_kept_where_nothing_less_will_do() {
    let cube = Polytope::cuboid(DVec3::ONE).unwrap();
    let found = simplify(&cube, Budget { tolerance: 0.0, vertices: 8 }).unwrap();
    assert!(found.is_within(0.0));
    assert_eq!(found.outer.vertices().len(), 8);
    let point = Polytope::sphere(1.0).unwrap();
    let found = simplify(&point, Budget { tolerance: 0.0, vertices: 8 }).unwrap();
    assert!(found.is_within(0.0) && found.outer.vertices() == [DVec3::ZERO]);
}

#[test]
fn a_bad_budget_or_size_is_refused_with_its_value() {
    let cube = Polytope::cuboid(DVec3::ONE).unwrap();
    for value in [-1.0, f64::INFINITY, f64::NAN] {
        let refused = simplify(&cube, Budget { tolerance: value, vertices: 8 });
        assert!(matches!(refused, Err(SimplifyError::Tolerance { .. })));
    }
    let refused = simplify(&cube, Budget { tolerance: 1.0, vertices: 7 }).unwrap_err();
    assert_eq!(refused, SimplifyError::TooFewVertices { vertices: 7 });
    for half in [1e-80, 1e80] {
        let cube = Polytope::cuboid(DVec3::splat(half)).unwrap();
        let refused = simplify(&cube, Budget { tolerance: 0.0, vertices: 8 });
        assert!(matches!(refused, Err(SimplifyError::Size { .. })));
    }
}

#[test]
fn a_bracketed_scene_is_never_wrong_and_open_only_within_the_tolerance() {
    let mut draw = Draw(44);
    let tolerance = 0.05;
    let shapes: Vec<_> = (0..60)
        .map(|_| {
            let at = round(&mut draw, 80, DVec3::new(0.6, 0.5, 0.4));
            let centred = at.vertices().iter().map(|&v| v - DVec3::new(3.0, 0.0, 0.0)).collect();
            Polytope::hull(centred).unwrap()
        })
        .collect();
    let poses: Vec<_> =
        (0..60).map(|_| Pose::new(draw.rotation(), draw.vector() * 1.5).unwrap()).collect();
    let simple: Vec<_> = shapes
        .iter()
        .map(|shape| simplify(shape, Budget { tolerance, vertices: 200 }).unwrap())
        .collect();
    assert!(simple.iter().all(|found| found.is_within(tolerance)));
    let outer = simple.iter().map(|found| Shape::from(found.outer.clone())).collect();
    let inner = simple.iter().map(|found| Shape::from(found.inner.clone())).collect();
    let scene = Scene::one_each(outer, poses.clone()).unwrap();
    let inner_outer = InnerOuter::new(inner);
    let pairs: Vec<_> = (0..60).flat_map(|i| (i + 1..60).map(move |j| Pair { i, j })).collect();
    let mut seen = [0; 3];
    for &pair in &pairs {
        let [a, b] = [pair.i, pair.j].map(|i| i as usize);
        let (a, b) = (
            PosedSupport::polytope(&shapes[a], &poses[a]),
            PosedSupport::polytope(&shapes[b], &poses[b]),
        );
        let truth = overlap(a, b).0;
        match inner_outer.verdict((&scene, pair.i), (&scene, pair.j)).0 {
            Verdict::Undecided(reason) => {
                assert_eq!(reason, Reason::WithinTolerance);
                // No farther apart, and no deeper, than the hulls are off.
                if let (DistanceResult::Apart(found), _) = distance::of_polytopes(a, b) {
                    assert!(found.lower() <= 2.0 * tolerance);
                }
                let deep = dcd_gjk::epa::depth(a, b, &mut Default::default());
                if let Verdict::Touching(depth) = deep {
                    assert!(depth.lower() <= 2.0 * tolerance, "{depth:?}");
                }
                seen[2] += 1;
            }
            answer => {
                assert_eq!(answer, truth);
                seen[usize::from(answer == Verdict::Apart)] += 1;
            }
        }
    }
    assert!(seen.iter().all(|&count| count > 10), "{seen:?}");
    dcd_gjk::contract::narrow_phase(&inner_outer, &scene, &pairs).unwrap();
}
