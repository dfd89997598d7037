//! The points of manifolds of rounded shapes are no farther inside of their surfaces than the bound says, nor outside, also
//! where poses are hardly rotations.

use super::PosedSupport;
use super::manifold_points::{ACCURACIES, ROUNDING, verdict};
use super::patches::{grid, off_surface, part_of, parts};
use super::scenes::Draw;
use dcd_geom::glam::{DMat3, DQuat, DVec3};
use dcd_geom::{Pose, Shape};
use dcd_gjk::query::MeasureAt;
use dcd_gjk::{Manifolds, Verdict};

/// What poses are off rotations by: nothing but rounding, or nearly as much as a pose may be.
const OFF: [f64; 3] = [0.0, 0.0, 4e-7];

/// A polytope, level or leaning, and what is swept round it; some are not rounded.
fn rounded(draw: &mut Draw, k: usize) -> Shape {
    let half = draw.vector().abs() * 0.5 + 0.1;
    let core = match k % 4 {
        0 => Shape::cuboid(half),
        1 => Shape::hull((0..10).map(|_| draw.vector() * 0.6).collect()),
        2 => Shape::triangle([DVec3::ZERO, DVec3::X * half, DVec3::new(0.1, half.y, half.z)]),
        _ => Shape::segment(-half, half),
    };
    core.and_then(|core| core.rounded([0.0, 0.1, 0.5, 2.0][k / 4 % 4])).unwrap()
}

fn pose(draw: &mut Draw, off: f64) -> Pose {
    let turn = DMat3::from_quat(DQuat::from_scaled_axis(draw.vector() * 3.0));
    let stretch = DMat3::from_diagonal(DVec3::ONE + draw.vector() * off);
    Pose::from_matrix(turn * stretch, draw.vector()).unwrap()
}

/// A rounded polytope, a compound of some, a wavy rounded mesh, or a half-space.
fn shape(draw: &mut Draw, k: usize, kind: usize) -> Shape {
    match kind {
        0 => Shape::compound(
            (0..3).map(|j| (rounded(draw, k + j), pose(draw, OFF[k % 3]))).collect(),
        )
        .unwrap(),
        1 => {
            let at = |x: f64, y: f64| {
                let [x, y] = [x, y].map(|k| k / 4.0 - 0.5);
                DVec3::new(x, y, 0.3 * (3.0 * x).sin() * (4.0 * y).cos())
            };
            let (vertices, triangles) = grid(4, at);
            let mesh = Shape::mesh(vertices, triangles).unwrap();
            mesh.rounded([0.0, 0.1, 0.4][k / 3 % 3]).unwrap()
        }
        2 => Shape::half_space(DVec3::Z, 0.0).unwrap(),
        _ => rounded(draw, k),
    }
}

/// The second shape moved towards the first until they touch: from afar, in steps. `None` where they do not.
fn moved_to_touch(a: &PosedSupport, b: &PosedSupport, draw: &mut Draw) -> Option<PosedSupport> {
    let way = draw.vector();
    let at = |j: u32| {
        let place = b.pose.translation() + way * (4.0 - 0.25 * f64::from(j));
        let pose = b.pose.with_translation(place).unwrap();
        PosedSupport { shape: b.shape.clone(), pose }
    };
    (0..16).map(at).find(|b| verdict(a.placed(), b.placed()) == Verdict::Touching(()))
}

#[test]
fn points_are_as_near_to_swept_surfaces_as_the_bound_says() {
    let mut draw = Draw::seeded(41);
    let mut counts = [[0; 4]; 3];
    for k in 0..4000usize {
        let kinds = [3, k % 5];
        let off = k / 5 % 3;
        let [a, b] = kinds.map(|kind| {
            let shape = shape(&mut draw, k / 15 + kind, kind);
            PosedSupport { shape, pose: pose(&mut draw, OFF[off]) }
        });
        // A mesh or a compound on a half-space too.
        let a = if kinds[1] == 2 && k % 2 == 0 {
            let shape = shape(&mut draw, k, k / 2 % 2);
            PosedSupport { shape, ..a }
        } else {
            a
        };
        let Some(b) = moved_to_touch(&a, &b, &mut draw) else { continue };
        let of_parts = [&a, &b].map(|side| parts(&side.shape));
        for accuracy in ACCURACIES {
            let mut scratch = Default::default();
            let found =
                Manifolds::default().measure_at(accuracy, a.placed(), b.placed(), &mut scratch);
            let Verdict::Touching(found) = found else { panic!("{k}: {found:?}") };
            for manifold in found.iter() {
                for point in manifold.points() {
                    let ends = [(point.point_a, &a), (point.point_b, &b)];
                    for (number, (at, side)) in ends.into_iter().enumerate() {
                        if !side.shape.is_bounded() {
                            continue;
                        }
                        let part = part_of(&of_parts[number], point.parts[number]);
                        let by = off_surface(at, part, &side.pose) - manifold.error_bound;
                        assert!(by <= ROUNDING, "{k}, {accuracy:?}: {point:?} {number} by {by}");
                        counts[off][kinds[1].min(3)] += 1;
                    }
                }
            }
        }
    }
    assert!(counts.iter().flatten().all(|&count| count > 200), "{counts:?}");
}

#[test]
fn points_of_a_compound_on_a_plane_are_off_by_what_its_frame_is_off_a_rotation() {
    let sphere = Shape::sphere(0.5).unwrap();
    let compound = Shape::compound(vec![(sphere, Pose::from_translation(DVec3::X).unwrap())]);
    let plane = PosedSupport::at(&Shape::half_space(DVec3::Z, 0.0).unwrap(), DVec3::ZERO);
    // Within what is still taken for a rotation at the accuracy of f32.
    let stretch = DMat3::from_diagonal(DVec3::new(1.0, 1.0, 1.0 + 4e-13));
    let pose = Pose::from_matrix(stretch, DVec3::NEG_Z * 3.0).unwrap();
    let compound = PosedSupport { shape: compound.unwrap(), pose };
    for accuracy in ACCURACIES {
        let (a, b) = (compound.placed(), plane.placed());
        let found = Manifolds::default().measure_at(accuracy, a, b, &mut Default::default());
        let Verdict::Touching(found) = found else { panic!("{found:?}") };
        let (point, bound) = (found[0].points()[0], found[0].error_bound + 1e-15);
        assert!(point.point_b.z.abs() <= bound, "{accuracy:?}: {point:?} {bound}");
        assert!((point.point_a.z + 3.5).abs() <= bound, "{accuracy:?}: {point:?} {bound}");
    }
}
