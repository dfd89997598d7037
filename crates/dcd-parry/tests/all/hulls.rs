//! Our hulls beside Parry's: two methods, one shape.

use dcd_geom::ConvexHull;
use dcd_geom::glam::DVec3;
use dcd_scenes::SceneSpec;
use parry3d_f64::transformation::try_convex_hull;

/// A multiplicative generator of points in the unit cube.
fn cloud(seed: u64, count: usize) -> Vec<DVec3> {
    let mut state = seed;
    let mut number = || {
        state = state.wrapping_mul(0xd134_2543_de82_ef95).wrapping_add(1);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    (0..count).map(|_| DVec3::new(number(), number(), number())).collect()
}

fn volume(points: &[DVec3], triangles: &[[u32; 3]]) -> f64 {
    let corners = triangles.iter().map(|t| t.map(|k| points[k as usize]));
    corners.map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
}

fn sorted(mut points: Vec<DVec3>) -> Vec<[f64; 3]> {
    points.sort_by(|p, q| p.to_array().partial_cmp(&q.to_array()).unwrap());
    points.into_iter().map(|p| p.to_array()).collect()
}

#[test]
fn random_clouds_have_the_corners_and_the_volume_that_parry_finds() {
    for seed in 0..300 {
        let cloud = cloud(seed, 4 + seed as usize);
        let hull = ConvexHull::of(&cloud).unwrap();
        let ours: Vec<DVec3> = hull.corners().iter().map(|&k| cloud[k as usize]).collect();
        let (theirs, triangles) = try_convex_hull(&cloud).unwrap();
        let volumes = [volume(&ours, hull.triangles()), volume(&theirs, &triangles)];
        assert!((volumes[0] - volumes[1]).abs() < 1e-14, "{seed}: {volumes:?}");
        assert_eq!(sorted(ours), sorted(theirs), "{seed}");
    }
}

#[test]
fn the_hulls_of_the_papers_scene_are_parrys() {
    let shapes = SceneSpec::paper().with_objects(500).raw().unwrap().shapes;
    for shape in shapes {
        let (theirs, _) = try_convex_hull(&shape.points()).unwrap();
        assert_eq!(sorted(shape.points()), sorted(theirs));
    }
}
