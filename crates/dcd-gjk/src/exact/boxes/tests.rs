use super::*;
use dcd_geom::Pose;
use dcd_geom::glam::DQuat;
use proptest::prelude::*;

/// The closed form's answer, the same in both orders and that of the exact integers.
fn resolved(a: (&Polytope, &Pose), b: (&Polytope, &Pose)) -> Option<(bool, Method)> {
    let (a, b) = (PosedSupport::polytope(a.0, a.1), PosedSupport::polytope(b.0, b.1));
    let answer = touch(a, b);
    assert_eq!(answer, touch(b, a));
    if let Some((touches, _)) = answer {
        assert_eq!(touches, crate::exact::touches(a, b, &[]), "{a:?} {b:?}");
    }
    answer
}

fn cuboid(x: f64, y: f64, z: f64) -> Polytope {
    Polytope::cuboid(DVec3::new(x, y, z)).unwrap()
}

#[test]
fn bricks_touch_exactly_and_a_float_more_is_a_gap() {
    let brick = cuboid(0.35, 0.35, 0.35);
    let origin = Pose::from_translation(DVec3::new(0.1, 0.2, 0.3)).unwrap();
    for step in [DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::ONE] {
        let mut flips = 0;
        let mut before = None;
        for ulps in -4i64..=4 {
            let pitch = f64::from_bits(0.7f64.to_bits().wrapping_add_signed(ulps));
            let t = origin.translation() + step * pitch;
            let there = Pose::from_translation(t).unwrap();
            let (touches, _) = resolved((&brick, &origin), (&brick, &there)).unwrap();
            flips += usize::from(before.is_some_and(|before| before != touches));
            before = Some(touches);
        }
        assert_eq!(flips, 1, "{step}");
    }
}

#[test]
fn boxes_turned_by_quarters_have_their_edges_swapped() {
    let plank = cuboid(2.0, 0.25, 0.5);
    let upright = DMat3::from_cols(DVec3::Y, -DVec3::X, DVec3::Z);
    let turned = |x: f64| Pose::from_matrix(upright, DVec3::new(x, 0.0, 0.0)).unwrap();
    let touching = resolved((&plank, &Pose::IDENTITY), (&plank, &turned(2.25)));
    assert_eq!(touching, Some((true, Method::Exact)));
    let apart = resolved((&plank, &Pose::IDENTITY), (&plank, &turned(2.25f64.next_up())));
    assert!(!apart.unwrap().0);
    assert_eq!(
        resolved((&plank, &Pose::IDENTITY), (&plank, &turned(3.0))),
        Some((false, Method::F64))
    );
}

#[test]
fn other_shapes_and_turns_are_left_to_others() {
    let plank = cuboid(2.0, 0.25, 0.5);
    let rounded = plank.clone().rounded(0.125).unwrap();
    let turned = Pose::new(DQuat::from_rotation_x(0.3), DVec3::ONE).unwrap();
    let here = Pose::IDENTITY;
    assert_eq!(resolved((&plank, &here), (&rounded, &here)), None);
    assert_eq!(resolved((&plank, &here), (&plank, &turned)), None);
    let huge = cuboid(1e300, 1.0, 1.0);
    assert_eq!(resolved((&huge, &here), (&plank, &here)), None);
    let hull = Polytope::hull(plank.vertices().to_vec()).unwrap();
    assert_eq!(resolved((&plank, &here), (&hull, &here)), None);
}

#[test]
fn boxes_that_stand_upright_are_decided_exactly_whatever_their_heading() {
    let crate_ = cuboid(0.5, 0.25, 0.35);
    let turn = DQuat::from_rotation_z(0.3);
    let here = Pose::new(turn, DVec3::new(3.1, 4.1, 0.35)).unwrap();
    assert_eq!(upright(here.rotation(), 2), Some(2));
    assert_eq!((upright(here.rotation(), 0), upright(here.rotation(), 1)), (None, None));
    let above = |z: f64| Pose::new(turn, DVec3::new(3.2, 4.2, 0.35 + z)).unwrap();
    let long = Arithmetic { unit: double_double::EPSILON, sign: |sum| Some(exact_sign(sum)) };
    let half = Halves { a: DVec3::new(0.5, 0.25, 0.35), b: DVec3::new(0.5, 0.25, 0.35) };
    for (z, touches) in [(0.7, true), (0.7f64.next_up(), false)] {
        let there = above(z);
        let bodies =
            [PosedSupport::polytope(&crate_, &here), PosedSupport::polytope(&crate_, &there)];
        // By double-double alone, without integers.
        assert_eq!(signs::<DoubleDouble>(bodies, half, &long), Some(touches), "{z}");
        assert_eq!(resolved((&crate_, &here), (&crate_, &there)).unwrap().0, touches);
    }
}

proptest! {
    #[test]
    fn turned_stacks_are_judged_as_integers_judge_them(
        angles in prop::array::uniform3(-3.0..3.0f64), half in prop::array::uniform3(0.01..3.0f64),
        offset in prop::array::uniform3(-1.5..1.5f64), at in prop::array::uniform3(-50.0..50.0f64),
        face in 0usize..3, aligned in any::<bool>(),
    ) {
        let [x, y, z] = angles;
        let turn = DQuat::from_rotation_x(x) * DQuat::from_rotation_y(y) * DQuat::from_rotation_z(z);
        let turn = if aligned { DQuat::IDENTITY } else { turn };
        let half = DVec3::from_array(half);
        let mut way = DVec3::from_array(offset) * half;
        // Face on face, to within rounding.
        way[face] = 2.0 * half[face];
        let brick = cuboid(half.x, half.y, half.z);
        let here = Pose::new(turn, DVec3::from_array(at)).unwrap();
        let there = Pose::new(turn, here.apply(way)).unwrap();
        prop_assert!(resolved((&brick, &here), (&brick, &there)).is_some());
    }
}
