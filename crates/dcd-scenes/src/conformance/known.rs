//! Geometry on which other libraries are known to fail, rebuilt from its description.

use super::bodies::{Placed, at, cuboid, direction, hull, power_of_ten, sized, turned};
use crate::random::Draw;
use dcd_geom::{Polytope, Pose};
use glam::DVec3;

/// Makes pair `k` of its kind.
type Family = fn(usize, &mut Draw) -> Option<[Placed; 2]>;

/// The families, in a cycle.
pub(super) fn known(k: usize, draw: &mut Draw) -> Option<[Placed; 2]> {
    const FAMILIES: [Family; 10] = [
        small_hulls,
        cubes_as_hulls,
        part_in_a_hall,
        corner_gap,
        baked_far_out,
        origin_on_the_first_face,
        drum_on_a_plate,
        near_parallel_triangles,
        slab_and_crumb,
        sphere_on_a_thin_triangle,
    ];
    FAMILIES[k % FAMILIES.len()](k / FAMILIES.len(), draw)
}

/// Hulls of 1/64 to 1/4096 m: areas fall below an absolute epsilon.
fn small_hulls(k: usize, draw: &mut Draw) -> Option<[Placed; 2]> {
    let size = libm::exp2(-6.0 - (k % 7) as f64);
    let spot = draw.point(-1.5, 1.5) * size;
    let (a, b) = (hull(draw, size)?, hull(draw, size)?);
    Some([(a, turned(draw, DVec3::ZERO)?), (b, turned(draw, spot)?)])
}

/// Cubes given as points: an expanding polytope that takes a wrong face.
fn cubes_as_hulls(k: usize, _: &mut Draw) -> Option<[Placed; 2]> {
    const SPOTS: [DVec3; 6] = [
        DVec3::new(0.75, 0.0, 0.0),
        DVec3::new(0.25, 0.0, 0.0),
        DVec3::ZERO,
        DVec3::new(0.75, 0.25, 0.0),
        DVec3::new(0.5, 0.5, 0.5),
        DVec3::new(1.0, 0.0, 0.0),
    ];
    let cube = sized(&Polytope::cuboid(DVec3::splat(0.5)).ok()?, 1.0)?;
    Some([(cube.clone(), Pose::IDENTITY), (cube, at(SPOTS[k % SPOTS.len()])?)])
}

/// A millimetre in a kilometre, on the floor but for some micrometres, or in the air.
fn part_in_a_hall(k: usize, draw: &mut Draw) -> Option<[Placed; 2]> {
    let hall = Polytope::cuboid(DVec3::new(500.0, 500.0, 0.5)).ok()?;
    let part = sized(&cuboid(draw)?, 1e-3)?;
    let ground = draw.point(-400.0, 400.0) * DVec3::new(1.0, 1.0, 0.0);
    let height = 0.5 + [1e-3, 1.0005e-3, 0.9e-3, 2e-3, 0.1][k % 5];
    Some([(hall, Pose::IDENTITY), (part, turned(draw, ground + DVec3::Z * height)?)])
}

/// Cubes apart or not by an ulp of 1, along an axis or a diagonal.
fn corner_gap(k: usize, _: &mut Draw) -> Option<[Placed; 2]> {
    let cube = Polytope::cuboid(DVec3::splat(0.5)).ok()?;
    let along = [DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::ONE][k % 3];
    let step = [1f64.next_up(), 1f64.next_down(), 1.0, 1.0 + 1e-15][k / 3 % 4];
    Some([(cube.clone(), Pose::IDENTITY), (cube, at(along * step)?)])
}

/// Apart or overlapping by a thousandth, 1e4 to 1e8 from the origin: world vertices in f32 lose it.
fn baked_far_out(k: usize, draw: &mut Draw) -> Option<[Placed; 2]> {
    let out = direction(draw) * power_of_ten(4 + (k % 5) as i32);
    let gap = if k.is_multiple_of(2) { 1e-3 } else { -1e-3 };
    let cube = Polytope::cuboid(DVec3::splat(0.5)).ok()?;
    Some([(cube.clone(), at(out)?), (cube, at(out + DVec3::X * (1.0 + gap))?)])
}

/// Centres that differ along one axis: the origin lies on a face or edge of the first simplex.
fn origin_on_the_first_face(k: usize, draw: &mut Draw) -> Option<[Placed; 2]> {
    let (a, b) = (cuboid(draw)?, cuboid(draw)?);
    let axis = DVec3::AXES[k % 3];
    let reach = (a.vertices()[7] + b.vertices()[7]).dot(axis);
    let share = [0.0, 0.25, 0.5, 1.0, 1.5][k % 5];
    Some([(a, Pose::IDENTITY), (b, at(axis * reach * share)?)])
}

/// A drum of eight corners standing on a plate, sunk in by almost nothing or not at all.
fn drum_on_a_plate(k: usize, draw: &mut Draw) -> Option<[Placed; 2]> {
    let mut points = Vec::new();
    for corner in 0..8 {
        let (y, x) = libm::sincos(std::f64::consts::FRAC_PI_4 * f64::from(corner));
        points.extend([0.0, 0.25].map(|z| DVec3::new(0.0625 * x, 0.0625 * y, z)));
    }
    let plate = Polytope::cuboid(DVec3::new(1.0, 1.0, 0.0078125)).ok()?;
    let sunk = [0.0, 1e-9, -1e-9, 1e-6, -1e-6][k % 5];
    let ground = draw.point(-0.9, 0.9) * DVec3::new(1.0, 1.0, 0.0);
    let drum = Polytope::hull(points).ok()?;
    Some([(plate, Pose::IDENTITY), (drum, at(ground + DVec3::Z * (0.0078125 - sunk))?)])
}

/// Triangles of a millimetre, a hundredth of it apart, and almost parallel.
fn near_parallel_triangles(k: usize, draw: &mut Draw) -> Option<[Placed; 2]> {
    let size = power_of_ten(-3 - (k % 3) as i32);
    let mut triangle = |tilt: f64| {
        let points = (0..3).map(|_| draw.point(-1.0, 1.0) * DVec3::new(1.0, 1.0, tilt) * size);
        Polytope::hull(points.collect()).ok()
    };
    let (a, b) = (triangle(0.0)?, triangle(1e-6)?);
    Some([(a, Pose::IDENTITY), (b, at(DVec3::Z * size * 1e-2)?)])
}

/// A slab of 48 m and a crumb of a centimetre at its face.
fn slab_and_crumb(k: usize, draw: &mut Draw) -> Option<[Placed; 2]> {
    let slab = Polytope::cuboid(DVec3::new(24.0, 24.0, 0.25)).ok()?;
    let crumb = hull(draw, 0.01)?;
    let spot = draw.point(-20.0, 20.0) * DVec3::new(1.0, 1.0, 0.0);
    let height =
        0.25 + 0.01 * draw.between(-1.0, 1.0) + if k.is_multiple_of(4) { 0.01 } else { 0.0 };
    Some([(slab, turned(draw, DVec3::ZERO)?), (crumb, turned(draw, spot + DVec3::Z * height)?)])
}

/// A sphere that touches a long thin triangle near its edge, or just does not.
fn sphere_on_a_thin_triangle(k: usize, draw: &mut Draw) -> Option<[Placed; 2]> {
    let tip = DVec3::new(100.0, 1e-3, 0.0);
    let triangle = Polytope::hull(vec![DVec3::ZERO, DVec3::X * 100.0, tip]).ok()?;
    let sphere = Polytope::sphere(0.5).ok()?;
    let over = DVec3::new(draw.between(0.0, 100.0), draw.between(-0.5, 0.5), 0.0);
    let height = [0.5, 0.5f64.next_up(), 0.4, 0.1, 0.5f64.next_down()][k % 5];
    Some([(triangle, Pose::IDENTITY), (sphere, at(over + DVec3::Z * height)?)])
}
