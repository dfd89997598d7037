//! Spheres and cuboids by their own forms, against the paths that serve any polytope.

mod judge;

use dcd_geom::glam::{DMat3, DQuat, DVec3};
use dcd_geom::{Polytope, Pose, Shape};
use dcd_gjk::distance::gap_along;
use dcd_gjk::epa::Depth;
use dcd_gjk::query::{Feature, MeasureAt};
use dcd_gjk::{
    Accuracy, Depths, Distance, DistanceResult, Manifold, Manifolds, PairSolver, PosedShape,
    Verdict, distance,
};
use judge::cases::Draw;

const ACCURACIES: [Accuracy; 3] = [Accuracy::F32, Accuracy::F64, Accuracy::Certified];

/// Two shapes, their poses, and the same vertices as hulls, which no closed form knows.
struct Case {
    shapes: [Shape; 2],
    hulls: [Shape; 2],
    poses: [Pose; 2],
    size: f64,
}

impl Case {
    fn new(polytopes: [Polytope; 2], poses: [Pose; 2]) -> Self {
        let size = polytopes.iter().map(|p| p.reach() + p.swept_radius()).sum();
        let hulls = polytopes.each_ref().map(|polytope| {
            let hull = Polytope::hull(polytope.vertices().to_vec()).unwrap();
            Shape::from(hull.rounded(polytope.swept_radius()).unwrap())
        });
        Self { shapes: polytopes.map(Shape::from), hulls, poses, size }
    }

    fn posed<'a>(&'a self, shapes: &'a [Shape; 2]) -> [PosedShape<'a>; 2] {
        [0, 1].map(|k| PosedShape { shape: &shapes[k], pose: &self.poses[k] })
    }

    fn depth(&self, shapes: &[Shape; 2], accuracy: Accuracy) -> Option<Depth> {
        let [a, b] = self.posed(shapes);
        if let Verdict::Touching(_) = Depths.solve(a, b, &mut Default::default()) {
            let Verdict::Touching(depth) =
                Depths.measure_at(accuracy, a, b, &mut Default::default())
            else {
                panic!("undecided: {:?}", self.shapes);
            };
            let Verdict::Touching(mirrored) =
                Depths.measure_at(accuracy, b, a, &mut Default::default())
            else {
                panic!("undecided: {:?}", self.shapes);
            };
            let back = Depth {
                normal: -mirrored.normal,
                point_a: mirrored.point_b,
                point_b: mirrored.point_a,
                ..mirrored
            };
            assert_eq!(depth, back);
            return Some(depth);
        }
        None
    }

    fn manifold(&self, shapes: &[Shape; 2]) -> Manifold {
        let [a, b] = self.posed(shapes);
        let [ab, ba] = [(a, b), (b, a)].map(|(a, b)| {
            match Manifolds::default().measure_at(Accuracy::F64, a, b, &mut Default::default()) {
                Verdict::Touching(manifolds) => manifolds[0],
                other => panic!("{other:?}"),
            }
        });
        assert_eq!(ab.normal, -ba.normal);
        for (p, q) in ab.points().iter().zip(ba.points()) {
            assert_eq!((p.point_a, p.point_b, p.depth), (q.point_b, q.point_a, q.depth));
            assert_eq!(p.features, [q.features[1], q.features[0]]);
        }
        ab
    }

    /// How far a point is from one of the shapes, by a sphere of radius 0 against the hull.
    fn outside(&self, side: usize, point: DVec3) -> f64 {
        let dot = Shape::from(Polytope::hull(vec![DVec3::ZERO]).unwrap());
        let pose = Pose::from_translation(point).unwrap();
        let [a, b] = self.posed(&self.hulls);
        let dot = PosedShape { shape: &dot, pose: &pose };
        match distance::distance(dot, [a, b][side]).0 {
            DistanceResult::Apart(found) => found.distance,
            _ => 0.0,
        }
    }

    /// Judges one depth by the general search's of the same vertices.
    fn judge_depth(&self, truth: &Depth, accuracy: Accuracy) -> Depth {
        let found = self.depth(&self.shapes, accuracy).expect("touching");
        let context =
            format!("{accuracy:?} {found:?} {truth:?} {:?} {:?}", self.shapes, self.poses);
        assert!(
            (found.depth - truth.depth).abs() <= found.error_bound + truth.error_bound,
            "{context}"
        );
        let promised = match accuracy {
            Accuracy::F32 => 2.5e-6 * (self.size + self.delta()),
            Accuracy::F64 => (1e-10 * found.depth).max(3.2e-14 * (self.size + self.delta())),
            // The general search of swept shapes that all but touch says less.
            Accuracy::Certified if found.depth < 1e-15 * self.size => f64::INFINITY,
            Accuracy::Certified => 1e-9 * found.depth + 1e-22 * self.size,
        };
        assert!(found.error_bound <= promised, "{context}");
        assert!((found.normal.length() - 1.0).abs() < 1e-12, "{context}");
        // The depth along the stated normal.
        let [a, b] = self.posed(&self.hulls);
        let far = self.poses.iter().map(|p| p.translation().length()).sum::<f64>();
        let rounding = 1e-14 * (self.size + self.delta());
        if let Some(gap) = gap_along(a, b, found.normal) {
            assert!(-gap <= found.depth + found.error_bound + rounding, "{gap} {context}");
        }
        let between = found.point_a - found.point_b - found.normal * found.depth;
        let rounding = found.error_bound + rounding + 1e-15 * far;
        assert!(between.length() <= 4.0 * rounding, "{between} {context}");
        for (side, point) in [found.point_a, found.point_b].into_iter().enumerate() {
            let outside = self.outside(side, point);
            assert!(outside <= 1e-12 * self.size + 4.0 * rounding, "{outside} {context}");
        }
        found
    }

    fn distance(&self, shapes: &[Shape; 2], accuracy: Accuracy) -> Distance {
        let [a, b] = self.posed(shapes);
        let ab = distance::distance_at(accuracy, a, b).0;
        match (ab, distance::distance_at(accuracy, b, a).0) {
            (DistanceResult::Apart(ab), DistanceResult::Apart(ba)) => {
                assert_eq!((ab.distance, ab.normal), (ba.distance, -ba.normal));
                assert_eq!((ab.point_a, ab.error_bound), (ba.point_b, ba.error_bound));
                ab
            }
            other => panic!("{other:?} {:?} {:?}", self.shapes, self.poses),
        }
    }

    /// Judges the distances of a pair that is apart by the general search's of the same vertices.
    fn judge_distances(&self) {
        let truth = self.distance(&self.hulls, Accuracy::Certified);
        let size = self.size + self.delta();
        for accuracy in ACCURACIES {
            let found = self.distance(&self.shapes, accuracy);
            let context =
                format!("{accuracy:?} {found:?} {truth:?} {:?} {:?}", self.shapes, self.poses);
            let bound = found.error_bound + truth.error_bound;
            assert!((found.distance - truth.distance).abs() <= bound, "{context}");
            let promised = match accuracy {
                Accuracy::F32 => 2.5e-6 * size,
                // Poses far from rotations are the search's.
                Accuracy::F64 => 1e-8 * size,
                Accuracy::Certified => 1e-12 * found.distance,
            };
            assert!(found.error_bound <= promised, "{context}");
            let far = self.poses.iter().map(|p| p.translation().length()).sum::<f64>();
            let between = found.point_b - found.point_a - found.normal * found.distance;
            assert!(between.length() <= 1e-9 * size + 1e-15 * far, "{context}");
        }
    }

    fn delta(&self) -> f64 {
        (self.poses[0].translation() - self.poses[1].translation()).abs().element_sum()
    }
}

/// From a few micrometres to kilometres, cubes to needles and plates.
fn cuboid(draw: &mut Draw, size: f64) -> Polytope {
    let stretch = match draw.below(4) {
        0 => DVec3::new(1.0, 1e-3, 1e-3),
        1 => DVec3::new(1.0, 1.0, 1e-4),
        _ => DVec3::ONE,
    };
    let edges = [(); 3].map(|()| (0.2 + 0.5 * draw.unit().abs()) * size);
    let made = Polytope::cuboid(DVec3::from_array(edges) * stretch).unwrap();
    if draw.below(5) == 0 { made.rounded(0.1 * size).unwrap() } else { made }
}

/// Turned at random, hardly turned, by right angles, or as another.
fn rotation(draw: &mut Draw, like: DQuat) -> DQuat {
    match draw.below(7) {
        0 => DQuat::IDENTITY,
        1 => DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2 * f64::from(draw.below(4) as u32)),
        2 => like,
        3 => (like * DQuat::from_scaled_axis(draw.vector() * 1e-9)).normalize(),
        4 => (like * DQuat::from_rotation_y(draw.unit() * 1e-3)).normalize(),
        _ => draw.rotation(),
    }
}

fn cuboids(draw: &mut Draw) -> Case {
    let size = [1e-5, 1.0, 1e3, 1.0][draw.below(4) as usize];
    let ratio = [1.0, 1.0, 1.0, 1e-3][draw.below(4) as usize];
    let far = if draw.below(4) == 0 { DVec3::new(1e6, -3e5, 7.0) * size } else { DVec3::ZERO };
    let polytopes = [cuboid(draw, size), cuboid(draw, size * ratio)];
    let turn_a = draw.rotation();
    let turn_b = rotation(draw, turn_a);
    let away = match draw.below(8) {
        0 => DVec3::ZERO,
        1 => turn_a * DVec3::new(0.0, 0.0, 0.5 * size),
        _ => draw.vector() * (0.8 * size),
    };
    let poses = [Pose::new(turn_a, far), Pose::new(turn_b, far + away)].map(Result::unwrap);
    let poses = if draw.below(6) == 0 {
        // As far from a rotation as a pose may be.
        let off = DMat3::from_diagonal(DVec3::ONE + draw.vector() * 3e-7);
        poses.map(|p| Pose::from_matrix(*p.rotation() * off, p.translation()).unwrap())
    } else {
        poses
    };
    Case::new(polytopes, poses)
}

#[test]
fn cuboids_are_as_deep_as_the_hulls_of_their_vertices() {
    let mut draw = Draw(71);
    let mut touching = 0;
    for _ in 0..6000 {
        let case = cuboids(&mut draw);
        let Some(truth) = case.depth(&case.hulls, Accuracy::Certified) else {
            assert!(case.depth(&case.shapes, Accuracy::Certified).is_none());
            continue;
        };
        for accuracy in ACCURACIES {
            case.judge_depth(&truth, accuracy);
        }
        touching += 1;
    }
    assert!(touching > 2000, "{touching}");
}

#[test]
fn cuboids_are_as_far_apart_as_the_hulls_of_their_vertices() {
    let mut draw = Draw(74);
    let mut apart = 0;
    for _ in 0..6000 {
        let mut case = cuboids(&mut draw);
        let [a, b] = &case.poses;
        let away = (b.translation() - a.translation()) * 2.0;
        case.poses[1] = b.with_translation(a.translation() + away).unwrap();
        let [a, b] = case.posed(&case.shapes);
        if let (DistanceResult::Apart(found), _) = distance::distance(a, b)
            && found.distance > 1e-9 * case.size
        {
            case.judge_distances();
            apart += 1;
        }
    }
    assert!(apart > 1000, "{apart}");
}

#[test]
fn resting_and_touching_cuboids_have_their_depth() {
    let cube = || Polytope::cuboid(DVec3::splat(0.5)).unwrap();
    for turn in [DQuat::IDENTITY, DQuat::from_scaled_axis(DVec3::new(0.3, -0.7, 0.2))] {
        for depth in [0.0, 1e-14, 1e-9, 1e-6, 1e-3, 0.25, 0.5] {
            for slide in [DVec3::ZERO, DVec3::new(0.25, 0.5, 0.0), DVec3::new(0.999, -0.3, 0.0)] {
                let place = turn * (slide + DVec3::Z * (1.0 - depth));
                let poses = [Pose::new(turn, DVec3::ZERO), Pose::new(turn, place)];
                let case = Case::new([cube(), cube()], poses.map(Result::unwrap));
                let Some(truth) = case.depth(&case.hulls, Accuracy::Certified) else { continue };
                for accuracy in ACCURACIES {
                    case.judge_depth(&truth, accuracy);
                }
            }
        }
    }
}

/// Whether two manifolds have the same points, of features of the same kinds.
fn are_alike(one: &Manifold, other: &Manifold, near: f64) -> bool {
    let kind = |feature: &Feature| match feature {
        Feature::Vertex(_) => 0,
        Feature::Edge(..) => 1,
        Feature::Face(_) => 2,
        Feature::Surface => 3,
    };
    one.points().len() == other.points().len()
        && one.points().iter().all(|p| {
            other.points().iter().any(|q| {
                p.point_a.distance(q.point_a) <= near
                    && p.point_b.distance(q.point_b) <= near
                    && (p.depth - q.depth).abs() <= near
                    && p.features.each_ref().map(kind) == q.features.each_ref().map(kind)
            })
        })
}

#[test]
fn cuboids_touch_where_the_hulls_of_their_vertices_do() {
    let mut draw = Draw(72);
    let (mut touching, mut unlike, mut counts) = (0, 0, [0; 5]);
    for _ in 0..6000 {
        let case = cuboids(&mut draw);
        if case.depth(&case.hulls, Accuracy::Certified).is_none() {
            continue;
        }
        let (found, general) = (case.manifold(&case.shapes), case.manifold(&case.hulls));
        let context = format!("{found:#?} {general:#?} {:?} {:?}", case.shapes, case.poses);
        let bound = found.error_bound;
        let points = found.points();
        assert!(bound <= 1e-7 * case.size + general.error_bound, "{context}");
        for point in points {
            assert!(case.outside(0, point.point_a) <= bound, "{context}");
            assert!(case.outside(1, point.point_b) <= bound, "{context}");
            let between = point.point_a - point.point_b - found.normal * point.depth;
            assert!(between.length() <= bound, "{context}");
            assert!((0.0..=points[0].depth).contains(&point.depth), "{context}");
        }
        counts[points.len()] += 1;
        touching += 1;
        // Of two axes that are as good either is right: boxes with one centre.
        if found.normal.distance(general.normal) > 1e-3 {
            continue;
        }
        let is_alike = are_alike(&found, &general, 1e-7 * case.size);
        unlike += usize::from(!is_alike);
    }
    // Where a corner is on the rim of a face, rounding chooses.
    assert!(unlike * 100 < touching, "{unlike} of {touching}");
    assert!(touching > 2000 && counts[1..].iter().all(|&c| c > 0), "{touching} {counts:?}");
}

/// Two spheres that are far apart or deep, or that touch but for rounding.
fn spheres(draw: &mut Draw) -> Case {
    let size = [1e-6, 1.0, 1e5][draw.below(3) as usize];
    let far = if draw.below(3) == 0 { DVec3::new(1e6, -3e5, 7.0) } else { DVec3::ZERO };
    let radii = [(); 2].map(|()| (0.1 + draw.unit().abs()) * size);
    let gap = [0.3, 1e-6, 1e-12, 0.0][draw.below(4) as usize] * draw.unit();
    let direction = draw.vector().try_normalize().unwrap_or(DVec3::X);
    let away = direction * ((radii[0] + radii[1]) * (1.0 + gap));
    let poses = [far, far + away].map(|t| Pose::new(draw.rotation(), t).unwrap());
    Case::new(radii.map(|r| Polytope::sphere(r).unwrap()), poses)
}

#[test]
fn spheres_are_as_far_or_deep_as_points_with_radii() {
    let mut draw = Draw(73);
    let (mut touching, mut apart) = (0, 0);
    for _ in 0..6000 {
        let case = spheres(&mut draw);
        if let Some(truth) = case.depth(&case.hulls, Accuracy::Certified) {
            for accuracy in ACCURACIES {
                case.judge_depth(&truth, accuracy);
            }
            let manifold = case.manifold(&case.shapes);
            let depth = case.depth(&case.shapes, Accuracy::F64).unwrap();
            let [point] = manifold.points() else { panic!("{manifold:?}") };
            assert_eq!((point.point_a, point.point_b), (depth.point_a, depth.point_b));
            touching += 1;
            continue;
        }
        case.judge_distances();
        apart += 1;
    }
    assert!(touching > 1000 && apart > 1000, "{touching} {apart}");
}

#[test]
fn poses_off_rotations_leave_no_wide_bounds() {
    let (mut draw, mut counts) = (Draw(75), [0; 2]);
    for k in 0..1200 {
        let scale = 10f64.powi(k % 5);
        let half = draw.vector().abs() * scale + 0.4;
        let round = match k % 2 {
            0 => Polytope::sphere(0.3).unwrap(),
            _ => Polytope::segment(DVec3::ZERO, draw.vector() * 0.2).unwrap().rounded(0.3).unwrap(),
        };
        let off = DVec3::ONE + draw.vector() * [4e-7, 1e-7, 1e-9][k as usize / 5 % 3];
        let turn = DMat3::from_quat(draw.rotation()) * DMat3::from_diagonal(off);
        // Beside a face by a little, or into it.
        let gap = 1e-3 * draw.unit();
        let place = DVec3::new(0.3 * half.x, 0.2 * half.y, half.z + 0.3 + gap);
        let cuboid = Polytope::cuboid(half).unwrap();
        let from = draw.vector();
        let poses =
            [DVec3::ZERO, place].map(|place| Pose::from_matrix(turn, turn * place + from).unwrap());
        let case = Case::new([cuboid, round], poses);
        let size = case.size + (poses[0].translation() - poses[1].translation()).length();
        let truth = case.depth(&case.shapes, Accuracy::Certified);
        counts[usize::from(truth.is_some())] += 1;
        for accuracy in [Accuracy::F32, Accuracy::F64] {
            let (found, truth) = match truth {
                Some(truth) => {
                    let found = case.depth(&case.shapes, accuracy).unwrap();
                    ([found.depth, found.error_bound], [truth.depth, truth.error_bound])
                }
                None => {
                    let of = |accuracy| case.distance(&case.shapes, accuracy);
                    let both = [accuracy, Accuracy::Certified].map(of);
                    both.map(|found| [found.distance, found.error_bound]).into()
                }
            };
            let what = format!("{k} {accuracy:?} {found:?} {truth:?} of {size}");
            assert!((found[0] - truth[0]).abs() <= found[1] + truth[1], "{what}");
            assert!(found[1] <= 1e-5 * size, "{what}");
        }
    }
    assert!(counts.iter().all(|&count| count > 300), "{counts:?}");
}
