use super::*;
use dcd_geom::Pose;
use dcd_geom::glam::DQuat;
use proptest::prelude::*;

/// The verdict of the plane, where it has one that of the exact integers.
fn resolved(a: &(Polytope, Pose), b: &(Polytope, Pose)) -> Option<bool> {
    let (a, b) = (PosedSupport::polytope(&a.0, &a.1), PosedSupport::polytope(&b.0, &b.1));
    let answer = touch(a, b, &Difference::new(a, b).unwrap());
    let truth = crate::exact::touches(a, b, &[]);
    assert!(answer.is_none_or(|touches| touches == truth), "{a:?} {b:?}");
    answer
}

fn cuboid(x: f64, y: f64, z: f64) -> Polytope {
    Polytope::cuboid(DVec3::new(x, y, z)).unwrap()
}

fn heading(angle: f64, at: [f64; 3]) -> Pose {
    Pose::new(DQuat::from_rotation_z(angle), DVec3::from_array(at)).unwrap()
}

#[test]
fn a_crate_on_a_table_touches_and_a_float_above_it_does_not() {
    let table = (cuboid(1.0, 0.6, 0.35), heading(0.4, [0.1, 0.2, 0.35]));
    let above = |z: f64| (cuboid(0.2, 0.3, 0.15), heading(1.3, [0.3, 0.1, z]));
    // 0.35 + 0.35 + 0.15, of which no sum is exact.
    let heights = [0.85f64.next_down(), 0.85, 0.85f64.next_up()];
    let gap = |z: f64| exact_sign([z, -0.15, -0.35, -0.35]);
    for z in heights {
        let expected = match gap(z) {
            Ordering::Greater => Some(false),
            Ordering::Equal => Some(true),
            Ordering::Less => None,
        };
        assert_eq!(resolved(&table, &above(z)), expected, "{z}");
        assert_eq!(resolved(&above(z), &table), expected, "{z}");
    }
}

#[test]
fn concentric_stacks_and_stacks_along_any_axis_touch() {
    let dice = cuboid(0.5, 0.5, 0.5);
    for k in 0..3 {
        let axis = DVec3::from_array([0, 1, 2].map(|i| f64::from(u8::from(i == k))));
        for angle in [0.0, 0.3, 2.5] {
            let turn = DQuat::from_axis_angle(axis, angle);
            let at = |height: f64| Pose::new(turn, axis * height).unwrap();
            let lower = (dice.clone(), Pose::IDENTITY);
            let here = resolved(&lower, &(dice.clone(), at(1.0)));
            // Sines and cosines may leave a row of the matrix a little off its axis.
            assert!(here == Some(true) || picked(at(1.0).rotation(), k).is_none(), "{k} {angle}");
            assert!(resolved(&lower, &(dice.clone(), at(-1.0))).is_none_or(|touches| touches));
        }
    }
    let upright = heading(0.3, [0.0, 0.0, 1.0]);
    assert_eq!(resolved(&(dice.clone(), Pose::IDENTITY), &(dice, upright)), Some(true));
}

#[test]
fn faces_that_only_share_an_edge_are_left_to_integers() {
    let dice = cuboid(0.5, 0.5, 0.5);
    let lower = (dice.clone(), Pose::IDENTITY);
    assert_eq!(resolved(&lower, &(dice.clone(), heading(0.0, [1.0, 0.0, 1.0]))), None);
    assert_eq!(resolved(&lower, &(dice.clone(), heading(0.0, [3.0, 0.0, 1.0]))), Some(false));
    assert_eq!(resolved(&lower, &(dice, heading(0.7, [1.3, 0.0, 1.0]))), None);
}

proptest! {
    #[test]
    fn prisms_that_rest_on_each_other_are_judged_as_integers_judge_them(
        base in prop::collection::vec((-1.0..1.0f64, -1.0..1.0f64), 3..9), height in 0.1..2.0f64,
        angles in prop::array::uniform2(-3.0..3.0f64), at in prop::array::uniform2(-1.5..1.5f64),
    ) {
        let prism = |z: f64| base.iter().map(move |&(x, y)| DVec3::new(x, y, z));
        let prism = Polytope::hull(prism(-height).chain(prism(height)).collect()).unwrap();
        let lower = (prism.clone(), heading(angles[0], [0.0; 3]));
        resolved(&lower, &(prism.clone(), heading(angles[1], [at[0], at[1], 2.0 * height])));
        resolved(&lower, &(prism, heading(angles[1], [at[0], at[1], -2.0 * height])));
    }
}

#[test]
fn a_radius_too_small_for_the_scaled_difference_still_counts() {
    // Found by fuzzing: divided by the pair's size the radius is 0, and the gap is not above it.
    let radius = 2.5e-323;
    let aside = Pose::from_translation(DVec3::X * radius).unwrap();
    let capsule = (Polytope::capsule(10.0, radius).unwrap(), aside);
    let point = (cuboid(0.0, 0.0, 0.0), Pose::from_translation(DVec3::Z * 5.0).unwrap());
    assert_eq!(resolved(&capsule, &point), None);
    let [a, b] = [&capsule, &point].map(|(shape, pose)| PosedSupport::polytope(shape, pose));
    assert_eq!(crate::certified::overlap(a, b).0, crate::Verdict::Touching(()));
}
