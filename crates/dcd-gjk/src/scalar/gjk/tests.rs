use super::*;
use crate::PosedSupport;
use dcd_geom::glam::{DQuat, DVec3};
use dcd_geom::{Polytope, Pose};

fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::from_translation(DVec3::new(x, y, z)).unwrap()
}

fn judge<R: Real>(a: (&Polytope, Pose), b: (&Polytope, Pose)) -> Verdict<()> {
    overlap(
        &Difference::<R, _, _>::new(
            PosedSupport::polytope(a.0, &a.1),
            PosedSupport::polytope(b.0, &b.1),
        )
        .unwrap(),
    )
}

fn cube() -> Polytope {
    Polytope::cuboid(DVec3::splat(0.5)).unwrap()
}

#[test]
fn aligned_boxes_are_resolved_on_either_side_of_touching() {
    let origin = at(0.0, 0.0, 0.0);
    for axis in [DVec3::X, -DVec3::Y, DVec3::Z, DVec3::new(1.0, 1.0, 0.0), DVec3::ONE] {
        for (pitch, expected) in [
            (1.0 + 1e-9, Verdict::Apart),
            (1.0 + 1e-14, Verdict::Apart),
            (1.0 - 1e-13, Verdict::Touching(())),
            (1.0 - 1e-3, Verdict::Touching(())),
            (0.5, Verdict::Touching(())),
            (0.0, Verdict::Touching(())),
        ] {
            let there = Pose::from_translation(axis * pitch).unwrap();
            let verdict = judge::<f64>((&cube(), origin), (&cube(), there));
            assert_eq!(verdict, expected, "{axis} {pitch}");
        }
    }
}

#[test]
fn faces_that_touch_exactly_are_left_undecided() {
    let verdict = judge::<f64>((&cube(), at(0.0, 0.0, 0.0)), (&cube(), at(1.0, 0.0, 0.0)));
    assert_eq!(verdict, Verdict::Undecided(Reason::WithinRounding));
}

#[test]
fn a_cube_round_a_point_touches_it_wherever_it_is() {
    let point = Polytope::hull(vec![DVec3::ZERO]).unwrap();
    let octahedron = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|d| [d, -d]).collect();
    let octahedron = Polytope::hull(octahedron).unwrap();
    for t in [0.0, 0.25, 0.4999999] {
        for place in [at(t, 0.0, 0.0), at(t, t, 0.0), at(t, t, t), at(0.0, -t, t)] {
            let verdict = judge::<f64>((&cube(), at(0.0, 0.0, 0.0)), (&point, place));
            assert_eq!(verdict, Verdict::Touching(()), "{place:?}");
        }
    }
    let centre = at(3.0, 0.0, 0.0);
    assert_eq!(judge::<f64>((&octahedron, centre), (&point, centre)), Verdict::Touching(()));
}

#[test]
fn f32_resolves_what_is_wider_than_its_rounding() {
    let origin = at(0.0, 0.0, 0.0);
    let turned = DQuat::from_rotation_z(0.3) * DQuat::from_rotation_x(0.7);
    for (x, expected) in [(0.84, Verdict::Touching(())), (1.4, Verdict::Apart)] {
        let there = Pose::new(turned, DVec3::new(x, 0.5, 0.0)).unwrap();
        assert_eq!(judge::<f32>((&cube(), origin), (&cube(), there)), expected);
    }
    let near = at(1.0 + 1e-5, 0.0, 0.0);
    assert_eq!(judge::<f32>((&cube(), origin), (&cube(), near)), Verdict::Apart);
    let close = at(1.0 + 1e-8, 0.0, 0.0);
    let verdict = judge::<f32>((&cube(), origin), (&cube(), close));
    assert_eq!(verdict, Verdict::Undecided(Reason::WithinRounding));
}

#[test]
fn spheres_touch_by_their_radii() {
    let (small, large) = (Polytope::sphere(1.0).unwrap(), Polytope::sphere(2.0).unwrap());
    for (x, expected) in [
        (2.9999999, Verdict::Touching(())),
        (3.0000001, Verdict::Apart),
        (3.0, Verdict::Undecided(Reason::WithinRounding)),
        (0.0, Verdict::Touching(())),
    ] {
        assert_eq!(judge::<f64>((&small, at(x, 0.0, 0.0)), (&large, at(0.0, 0.0, 0.0))), expected);
    }
}

#[test]
fn a_map_that_answers_nan_ends_undecided() {
    struct Nan;
    impl SupportMap<f64> for Nan {
        fn support(&self, _: DVec3) -> Support<f64> {
            Support { point: DVec3::NAN, feature: 0 }
        }
    }
    let pose = at(0.0, 0.0, 0.0);
    let bad = PosedSupport { map: &Nan, pose: &pose, reach: 1.0, centre: DVec3::ZERO, inner: None };
    let cube = cube();
    let difference =
        Difference::<f64, _, _>::new(bad, PosedSupport::polytope(&cube, &pose)).unwrap();
    assert!(matches!(overlap(&difference), Verdict::Undecided(_)));
}
