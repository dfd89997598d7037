//! Impacts that are known, and random ones beside samples.

use super::*;
use crate::{Verdict, certified};
use dcd_geom::glam::DQuat;

fn at(place: DVec3) -> RigidMotion {
    RigidMotion::at_rest(Pose::from_translation(place).unwrap())
}

fn impact(a: (&Shape, &RigidMotion), b: (&Shape, &RigidMotion), until: f64) -> Impact {
    let [a, b] = [a, b].map(|(shape, motion)| MovingShape { shape, motion });
    time_of_impact(a, b, until, 1e-6).unwrap()
}

#[test]
fn spheres_meet_when_their_centres_are_a_diameter_apart() {
    let sphere = Shape::sphere(0.5).unwrap();
    let left = RigidMotion { linear: DVec3::X * 3.0, ..at(DVec3::X * -4.0) };
    // Beside the axis by 0.6: at 0.8 along it they touch.
    let right = RigidMotion { linear: DVec3::X * -1.0, ..at(DVec3::new(4.0, 0.6, 0.0)) };
    let Impact::Hit { free_until, t, normal, .. } =
        impact((&sphere, &left), (&sphere, &right), 5.0)
    else {
        panic!()
    };
    let truth = (8.0 - 0.8) / 4.0;
    assert!(free_until <= truth && t <= truth && truth - t < 1e-6, "{t} {truth}");
    assert!(normal.distance(DVec3::new(0.8, 0.6, 0.0)) < 1e-5, "{normal}");
    assert_eq!(impact((&sphere, &left), (&sphere, &right), 1.7), Impact::Free);
    let beside = RigidMotion { start: at(DVec3::new(4.0, 1.001, 0.0)).start, ..right };
    assert_eq!(impact((&sphere, &left), (&sphere, &beside), 100.0), Impact::Free);
    let Impact::Hit { free_until, t, touches, .. } =
        impact((&sphere, &left), (&sphere, &left), 1.0)
    else {
        panic!()
    };
    assert_eq!((free_until, t, touches), (0.0, 0.0, true));
}

#[test]
fn before_a_negative_end_nothing_is_met() {
    let (ball, still) = (Shape::sphere(1.0).unwrap(), at(DVec3::ZERO));
    assert_eq!(impact((&ball, &still), (&ball, &still), -1.0), Impact::Free);
    let floor = Shape::half_space(DVec3::Z, 0.0).unwrap();
    assert_eq!(impact((&floor, &still), (&floor, &still), -1.0), Impact::Free);
}

#[test]
fn nothing_fast_passes_through_a_thin_plate_of_any_kind() {
    let bar = Shape::cuboid(DVec3::new(0.5, 0.05, 0.05)).unwrap();
    let thin = DVec3::new(2.0, 2.0, 1e-4);
    let plate = Shape::cuboid(thin).unwrap();
    let corner = |x: f64, y: f64| DVec3::new(2.0 * x, 2.0 * y, 0.0);
    let corners = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    let surface = Shape::mesh(corners, vec![[0, 1, 2], [0, 2, 3]]).unwrap();
    let parts = Shape::compound(vec![(plate.clone(), Pose::IDENTITY)]).unwrap();
    let plane = Shape::half_space(DVec3::NEG_Z, 0.0).unwrap();
    let fast = RigidMotion {
        linear: DVec3::Z * 1e4,
        angular: DVec3::new(30.0, 50.0, -20.0),
        ..at(DVec3::Z * -100.0)
    };
    for shape in [&plate, &surface, &parts, &plane] {
        let still = at(DVec3::ZERO);
        let found = impact((&bar, &fast), (shape, &still), 1.0);
        let Impact::Hit { free_until, t, .. } = found else { panic!("{shape:?}: {found:?}") };
        // The bar reaches no farther than half of its diagonal.
        assert!(free_until <= t && (0.99e-2..1e-2).contains(&t), "{found:?}");
        let pose = fast.pose_at(t).unwrap();
        let (a, b) =
            (PosedShape { shape: &bar, pose: &pose }, PosedShape { shape, pose: &still.start });
        if let DistanceResult::Apart(gap) = distance_at(Accuracy::Certified, a, b).0 {
            assert!(gap.distance <= 1e-6, "{gap:?}");
        }
    }
}

#[test]
fn a_turning_bar_meets_a_post_when_its_side_gets_there() {
    let bar = Shape::cuboid(DVec3::new(1.0, 0.05, 0.05)).unwrap();
    // About its end.
    let turning =
        RigidMotion { angular: DVec3::Z * 2.0, centre: DVec3::NEG_X, ..at(DVec3::X * 1.0) };
    let post = Shape::sphere(0.1).unwrap();
    let still = at(DVec3::Y * 1.5);
    let Impact::Hit { t, .. } = impact((&bar, &turning), (&post, &still), 10.0) else { panic!() };
    let truth = (std::f64::consts::FRAC_PI_2 - (0.15f64 / 1.5).asin()) / 2.0;
    assert!((t - truth).abs() < 1e-6, "{t} {truth}");
    let far = at(DVec3::Y * 2.2);
    assert_eq!(impact((&bar, &turning), (&post, &far), 2.0), Impact::Free);
}

#[test]
fn a_turning_shape_starts_where_it_is_said_to() {
    let shape = Shape::cuboid(DVec3::splat(0.1)).unwrap();
    let plate = Shape::cuboid(DVec3::new(0.001, 0.1, 0.1)).unwrap();
    // To turn about a far centre adds it and takes it away again, which rounds by more than the gap.
    let leaving = RigidMotion {
        linear: DVec3::X,
        angular: DVec3::X,
        centre: DVec3::X * 1e6,
        ..at(DVec3::X * 0.1)
    };
    assert_eq!(leaving.pose_at(0.0).unwrap(), leaving.start);
    let still = at(DVec3::X * -(0.001 + 1e-11));
    let found = impact((&shape, &leaving), (&plate, &still), 1.0);
    assert!(!matches!(found, Impact::Hit { touches: true, .. }), "{found:?}");
    let reached = at(DVec3::X * -0.001);
    let found = impact((&shape, &leaving), (&plate, &reached), 1.0);
    assert!(matches!(found, Impact::Hit { touches: true, t: 0.0, .. }), "{found:?}");
}

#[test]
fn a_gap_within_the_rounding_of_poses_is_no_proof_though_shapes_part() {
    let cube = Shape::cuboid(DVec3::splat(0.5)).unwrap();
    let here = at(DVec3::X * 1e6);
    for speed in [1e-9, 1.0, 1e3] {
        let gap = 1e-9;
        let there = RigidMotion { linear: DVec3::X * speed, ..at(DVec3::X * (1e6 + 1.0 + gap)) };
        let [a, b] = [&here, &there].map(|motion| MovingShape { shape: &cube, motion });
        for until in [1e-12, 1.0, 1e3] {
            let found = time_of_impact(a, b, until, 1e-12).unwrap();
            assert_eq!(found, Impact::Undecided { free_until: 0.0 }, "{speed} {until}");
        }
    }
}

/// Numbers in −1 … 1, the same in every run.
pub(crate) struct Draw(pub(crate) u64);

impl Draw {
    pub(crate) fn number(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    pub(crate) fn vector(&mut self) -> DVec3 {
        DVec3::new(self.number(), self.number(), self.number())
    }

    fn shape(&mut self) -> Shape {
        match (self.number() * 3.0).abs() as usize {
            0 => Shape::cuboid(self.vector().abs() * 0.5 + 0.05).unwrap(),
            1 => Shape::hull((0..12).map(|_| self.vector() * 0.6).collect()).unwrap(),
            _ => Shape::cylinder(0.4, 0.2).unwrap(),
        }
    }

    fn motion(&mut self, far: DVec3) -> RigidMotion {
        let turn = DQuat::from_scaled_axis(self.vector() * 3.0).normalize();
        RigidMotion {
            start: Pose::new(turn, self.vector() * 1.2 + far).unwrap(),
            linear: self.vector() * 4.0,
            angular: self.vector() * 5.0,
            centre: self.vector() * 0.3,
        }
    }
}

#[test]
fn random_motions_are_answered_as_their_samples_say() {
    // Another seed by `DCD_SEED`.
    let seed = std::env::var("DCD_SEED").map_or(3, |seed| seed.parse().expect("a seed"));
    let mut draw = Draw(seed);
    let [mut free, mut hits] = [0; 2];
    for k in 0..400 {
        let (shape_a, shape_b) = (draw.shape(), draw.shape());
        // A third of them where coordinates are as coarse as the tolerance.
        let far = [0.0, 1e4, 1e8][k % 3] * draw.vector();
        let (motion_a, motion_b) = (draw.motion(far), draw.motion(far));
        let touches = |t: f64| {
            let (pose_a, pose_b) = (motion_a.pose_at(t).unwrap(), motion_b.pose_at(t).unwrap());
            let a = PosedShape { shape: &shape_a, pose: &pose_a };
            let b = PosedShape { shape: &shape_b, pose: &pose_b };
            (
                certified::overlap_of(a, b).0 == Verdict::Touching(()),
                distance_at(Accuracy::F64, a, b).0,
            )
        };
        let found = impact((&shape_a, &motion_a), (&shape_b, &motion_b), 1.0);
        let free_until = match found {
            Impact::Free => {
                free += 1;
                1.0
            }
            Impact::Hit { free_until, t, .. } => {
                hits += 1;
                if let (false, DistanceResult::Apart(gap)) = touches(t) {
                    assert!(gap.distance <= 1e-6, "{k}: {gap:?}");
                }
                free_until
            }
            Impact::Undecided { free_until } => {
                assert!(k % 3 == 2, "{k}: {found:?}");
                free_until
            }
        };
        for sample in 0..200 {
            let t = free_until * f64::from(sample) / 200.0;
            assert!(free_until == 0.0 || !touches(t).0, "{k}: at {t}, {found:?}");
        }
        let back = impact((&shape_b, &motion_b), (&shape_a, &motion_a), 1.0);
        let is_open = |found| matches!(found, Impact::Undecided { .. });
        if !is_open(found) && !is_open(back) {
            assert_eq!(matches!(back, Impact::Free), matches!(found, Impact::Free), "{k}");
        }
    }
    assert!(free > 50 && hits > 50, "{free} {hits}");
}

/// Whether a is proved to touch b at a time, and how far apart they are at least.
fn touch_and_gap(a: (&Shape, &RigidMotion), b: (&Shape, &RigidMotion), t: f64) -> (bool, f64) {
    let (pose_a, pose_b) = (a.1.pose_at(t).unwrap(), b.1.pose_at(t).unwrap());
    let a = PosedShape { shape: a.0, pose: &pose_a };
    let b = PosedShape { shape: b.0, pose: &pose_b };
    let touches = certified::overlap_of(a, b).0 == Verdict::Touching(());
    let gap = match distance_at(Accuracy::Certified, a, b).0 {
        DistanceResult::Apart(gap) => gap.lower(),
        _ => 0.0,
    };
    (touches, gap)
}

#[test]
fn translations_are_answered_as_their_samples_say() {
    let seed = std::env::var("DCD_SEED").map_or(11, |seed| seed.parse().expect("a seed"));
    let mut draw = Draw(seed);
    let [mut free, mut hits] = [0; 2];
    for k in 0..600 {
        let (shape_a, shape_b) = (draw.shape(), draw.shape());
        let far = [0.0, 1e4][k % 2] * draw.vector();
        let [mut motion_a, mut motion_b] = [0, 1].map(|_| draw.motion(far));
        motion_b.start = Pose::new(
            DQuat::from_scaled_axis(draw.vector()).normalize(),
            motion_b.start.translation() + draw.vector() * 2.0,
        )
        .unwrap();
        // Towards the other, more or less.
        let way = motion_b.start.translation() - motion_a.start.translation();
        motion_a.linear = way + motion_a.linear * 0.25;
        motion_b.linear *= 0.1;
        // A third of them face to face: along an axis, and of the same attitude.
        if k % 3 == 0 {
            motion_a.start = Pose::from_translation(far).unwrap();
            motion_b.start = Pose::from_translation(far + DVec3::X * 3.0).unwrap();
            (motion_a.linear, motion_b.linear) = (DVec3::X * 4.0 * draw.number(), DVec3::ZERO);
        }
        (motion_a.angular, motion_b.angular) = (DVec3::ZERO, DVec3::ZERO);
        let (a, b) = ((&shape_a, &motion_a), (&shape_b, &motion_b));
        let found = impact(a, b, 1.0);
        let free_until = match found {
            Impact::Free => {
                free += 1;
                1.0
            }
            Impact::Hit { free_until, t, normal, touches, .. } => {
                hits += 1;
                assert!(touch_and_gap(a, b, t).1 <= 1e-6, "{k}: {found:?}");
                assert!(touches || (normal.length() - 1.0).abs() < 1e-12, "{k}: {found:?}");
                free_until
            }
            Impact::Undecided { .. } => panic!("{k}: {found:?}"),
        };
        for sample in 0..100 {
            let t = free_until * f64::from(sample) / 100.0;
            assert!(free_until == 0.0 || !touch_and_gap(a, b, t).0, "{k}: at {t}, {found:?}");
        }
        let mirrored = match impact(b, a, 1.0) {
            Impact::Hit { free_until, t, touches, normal, point_a, point_b } => {
                let (normal, point_a, point_b) = (-normal, point_b, point_a);
                Impact::Hit { free_until, t, touches, normal, point_a, point_b }
            }
            other => other,
        };
        assert_eq!(mirrored, found, "{k}");
    }
    assert!(free > 100 && hits > 100, "{free} {hits}");
}

#[test]
fn a_cast_of_hulls_is_answered_by_their_difference_alone() {
    let mut draw = Draw(11);
    let (mut asked, mut answered) = (0, 0);
    for _ in 0..300 {
        let mut hull = || Shape::hull((0..20).map(|_| draw.vector() * 0.6).collect()).unwrap();
        let (shape_a, shape_b) = (hull(), hull());
        let way = draw.vector() * 3.0 + DVec3::X * 2.0;
        let moving = RigidMotion { linear: way + draw.vector() * 0.5, ..at(way * -1.5) };
        let still = at(DVec3::ZERO);
        let [a, b] = [(&shape_a, &moving), (&shape_b, &still)]
            .map(|(shape, motion)| MovingShape { shape, motion });
        if touch_and_gap((&shape_a, &moving), (&shape_b, &still), 0.0).0 {
            continue;
        }
        asked += 1;
        let limits = Limits { until: 2.0, tolerance: 1e-6, off: [1e-12, 0.0] };
        let known = cast::cast([a, b], &Closing::of(a, b), &limits);
        answered += usize::from(matches!(known, Some(Advance::Free | Advance::Near(..))));
        if let Some(Advance::Near(t, found)) = known {
            let (touch, gap) = touch_and_gap((&shape_a, &moving), (&shape_b, &still), t);
            assert!(!touch && gap <= 1e-6, "{gap}");
            assert!(found.point_a.distance(found.point_b) <= 1e-6);
            // Each is of its own shape there.
            for (side, point) in [(a, found.point_a), (b, found.point_b)] {
                let (pose, dot) = (side.motion.pose_at(t).unwrap(), Shape::sphere(1e-9).unwrap());
                let at = Pose::from_translation(point).unwrap();
                let (side, dot) = (
                    PosedShape { shape: side.shape, pose: &pose },
                    PosedShape { shape: &dot, pose: &at },
                );
                assert_eq!(certified::overlap_of(side, dot).0, Verdict::Touching(()));
            }
        }
    }
    assert!(asked > 200 && answered * 100 >= asked * 95, "{answered} of {asked}");
}

#[test]
fn a_rotation_is_its_series_in_the_matrix_of_the_cross_product() {
    let axes =
        [DVec3::X, DVec3::NEG_Y, DVec3::Z, DVec3::new(0.6, 0.0, -0.8), DVec3::ONE.normalize()];
    for axis in axes {
        for angle in [0.0, 1e-9, -0.3, 1.0, 2.5, 31.4, -1e5] {
            let DVec3 { x, y, z } = axis;
            let cross = DMat3::from_cols(
                DVec3::new(0.0, z, -y),
                DVec3::new(-z, 0.0, x),
                DVec3::new(y, -x, 0.0),
            );
            let (sin, cos) = libm::sincos(angle);
            let series = DMat3::IDENTITY + cross * sin + cross * cross * (1.0 - cos);
            assert_eq!(rotation_from_axis_angle(axis, angle), series, "{axis} {angle}");
        }
    }
}

#[test]
fn what_has_no_end_and_overlaps_as_it_stands_is_hit_at_0() {
    let ground = Shape::half_space(DVec3::Z, 0.0).unwrap();
    let still = at(DVec3::ZERO);
    let falling = RigidMotion { linear: -DVec3::Z, ..at(DVec3::Z * 0.5) };
    let side = |motion| MovingShape { shape: &ground, motion };
    for motions in [[&still, &still], [&falling, &still], [&still, &falling]] {
        let found = time_of_impact(side(motions[0]), side(motions[1]), 10.0, 1e-6).unwrap();
        assert!(matches!(found, Impact::Hit { t: 0.0, touches: true, .. }), "{found:?}");
    }
    // Two that face each other and come nearer touch at no time known.
    let upside = Shape::half_space(-DVec3::Z, -1.0).unwrap();
    let above = MovingShape { shape: &upside, motion: &still };
    let found = time_of_impact(above, side(&still), 10.0, 1e-6).unwrap();
    assert!(!matches!(found, Impact::Hit { .. }), "{found:?}");
}

#[test]
fn at_a_hit_far_away_the_gap_is_within_the_tolerance_though_the_poses_are_rounded() {
    let radii = [0.8372686230158296, 0.32824769929555153];
    let [a, b] = radii.map(|radius| Shape::sphere(radius).unwrap());
    let linear = DVec3::new(-0.29413191990663573, -0.9176586915653901, -0.9690766718938771);
    let from = DVec3::new(7445.992473103491, -1683.5877388034596, 8807.131144970788);
    let motion_a = RigidMotion { linear, ..at(from) };
    let linear = DVec3::new(-0.293387267595119, -0.9178271006037109, -0.9681960132606151);
    let motion_b = RigidMotion { linear, ..at(DVec3::ZERO) };
    let a = MovingShape { shape: &a, motion: &motion_a };
    let b = MovingShape { shape: &b, motion: &motion_b };
    let tolerance = 1.165516322311381e-6;
    match time_of_impact(a, b, 20_000_000.061177533, tolerance).unwrap() {
        Impact::Hit { t, .. } => {
            // Exact but for 1e-11: the way from one to the other is short.
            let between = from + (motion_a.linear - motion_b.linear) * t;
            let gap = between.length() - (radii[0] + radii[1]);
            assert!(gap <= tolerance + 1e-11, "{gap:e}");
        }
        Impact::Undecided { .. } => {}
        Impact::Free => panic!("they meet"),
    }
}

#[test]
fn a_late_end_does_not_leave_an_early_meeting_open() {
    let ball = Shape::sphere(0.5).unwrap();
    let cuboid = Shape::cuboid(DVec3::splat(0.5)).unwrap();
    let turning = RigidMotion { linear: DVec3::X, angular: DVec3::Z * 0.1, ..at(DVec3::X * -3.0) };
    let straight = RigidMotion { angular: DVec3::ZERO, ..turning };
    let still = at(DVec3::ZERO);
    for (shape, motion) in [(&ball, &straight), (&cuboid, &straight), (&cuboid, &turning)] {
        let a = MovingShape { shape, motion };
        let b = MovingShape { shape: &ball, motion: &still };
        for until in [10.0, 1e8, 1e100] {
            let found = time_of_impact(a, b, until, 1e-6).unwrap();
            let Impact::Hit { t, .. } = found else { panic!("{until:e} {found:?}") };
            assert!(t > 1.7 && t < 2.1, "{until:e} {found:?}");
        }
    }
}

#[test]
fn a_ball_that_spins_is_as_free_and_meets_as_soon_as_one_that_does_not() {
    let ground = Shape::half_space(DVec3::Z, 0.0).unwrap();
    let slab = Shape::cuboid(DVec3::new(5.0, 5.0, 0.5)).unwrap();
    let still = at(DVec3::ZERO);
    let below = at(DVec3::Z * -0.5);
    let ball = Shape::sphere(0.5).unwrap();
    for (floor, motion) in [(&ground, &still), (&slab, &below)] {
        let floor = MovingShape { shape: floor, motion };
        let meets = |linear: DVec3, spin: f64| {
            let motion = RigidMotion { linear, angular: DVec3::X * spin, ..at(DVec3::Z * 0.51) };
            time_of_impact(MovingShape { shape: &ball, motion: &motion }, floor, 1.0, 1e-6).unwrap()
        };
        assert_eq!(meets(DVec3::X, 1e4), Impact::Free);
        let [Impact::Hit { t: plain, .. }, Impact::Hit { t: spinning, .. }] =
            [0.0, 1e4].map(|spin| meets(-DVec3::Z, spin))
        else {
            panic!("no hit");
        };
        assert!((plain - 0.01).abs() < 2e-6 && (spinning - plain).abs() < 2e-6);
    }
}

/// Velocities whose squares underflow, and one whose square does not.
const SLOW: [f64; 8] = [1e-140, 1e-150, 1e-156, 1e-158, 1e-161, 1e-163, 1e-200, 1e-290];

#[test]
fn what_moves_so_slowly_that_squares_underflow_is_never_free_where_it_meets() {
    let ball = Shape::sphere(0.5).unwrap();
    let corners = vec![DVec3::new(0.0, -1.0, -1.0), DVec3::new(0.0, 1.0, -1.0), DVec3::Z];
    let cube = Shape::cuboid(DVec3::splat(0.5)).unwrap();
    let shapes = [
        (Shape::mesh(corners, vec![[0, 1, 2]]).unwrap(), 4.5),
        (Shape::half_space(DVec3::X, 0.0).unwrap(), 4.5),
        (Shape::compound(vec![(cube.clone(), Pose::IDENTITY)]).unwrap(), 4.0),
        (cube, 4.0),
        (ball.clone(), 4.0),
    ];
    let rod = Shape::cuboid(DVec3::new(2.0, 0.1, 0.1)).unwrap();
    let beside = at(DVec3::Y * 1.5);
    let small = Shape::sphere(0.2).unwrap();
    let mut hits = 0;
    let mut check = |found: Impact, truth: f64| {
        let until = match found {
            Impact::Free => panic!("{truth}"),
            Impact::Hit { free_until, .. } => {
                hits += 1;
                free_until
            }
            Impact::Undecided { free_until } => free_until,
        };
        assert!(until <= truth * (1.0 + 1e-9), "{found:?} {truth}");
    };
    for v in SLOW {
        let flies = RigidMotion { linear: DVec3::X * v, ..at(DVec3::X * -5.0) };
        for (shape, way) in &shapes {
            let still = at(DVec3::ZERO);
            check(impact((shape, &flies), (&ball, &still), 10.0 / v), way / v);
            check(impact((&ball, &still), (shape, &flies), 10.0 / v), way / v);
        }
        // The rod's side is 0.3 from the ball's centre where sin(1.5708 − angle) is 0.2.
        let turns = RigidMotion { angular: DVec3::Z * v, ..at(DVec3::ZERO) };
        let angle = std::f64::consts::FRAC_PI_2 - (0.3f64 / 1.5).asin();
        check(impact((&rod, &turns), (&small, &beside), 3.0 / v), angle / v);
        let moving = MovingShape { shape: &rod, motion: &turns };
        let swept = moving.swept_aabb(3.0 / v);
        for share in [0.25, 0.5, 1.0] {
            let place = rod.aabb(&turns.pose_at(share * 3.0 / v).unwrap());
            assert!(swept.min.cmple(place.min).all() && swept.max.cmpge(place.max).all(), "{v}");
        }
    }
    assert!(hits > SLOW.len(), "{hits}");
}

#[test]
fn a_box_of_an_endless_turn_is_round_all_places() {
    let shape = Shape::sphere(0.5).unwrap();
    for centre in [DVec3::ZERO, DVec3::X * 0.1] {
        let angular = DVec3::new(2.0, 0.0, 1.0);
        let motion = RigidMotion { linear: DVec3::X, angular, centre, ..at(DVec3::X * -5.0) };
        let moving = MovingShape { shape: &shape, motion: &motion };
        let [low, high] = moving.carried_box(f64::MAX).unwrap();
        let start = shape.aabb(&motion.start);
        // Written so that NaN holds nothing.
        assert!(low.cmple(start.min.as_dvec3()).all() && high.cmpge(start.max.as_dvec3()).all());
        assert!(moving.swept_aabb(f64::MAX).max.x >= 1e30, "{low} {high}");
    }
}
