//! The grid's answers against brute force.

use super::*;
use dcd_geom::glam::{Vec3, Vec3Swizzles};
use dcd_geom::{PackedSphereBounds, Pose, Shape, Sphere16, SphereBounds};
use dcd_simd::{IndexRow, Kernel, Lanes, Path, WIDTH, dispatch_on};

fn obstacle(centre: Vec3, half: Vec3) -> ObstacleBounds {
    let aabb = Aabb { min: centre - half, max: centre + half };
    let sphere = BoundingSphere { centre, radius: half.length() * 0.8 };
    ObstacleBounds { aabb, sphere, inner: InscribedSphere { centre, radius: half.min_element() } }
}

/// Centres on a spiral of that size, and radii of some of its hundredths.
fn spheres(count: usize, size: f32) -> Vec<BoundingSphere> {
    let sphere = |k: usize| {
        let t = k as f32;
        let centre = Vec3::new(t.sin(), (t * 0.73).cos(), (t * 0.37).sin() * 0.6) * size;
        BoundingSphere { centre, radius: size * (1.0 + t % 7.0) * 0.02 }
    };
    (0..count).map(sphere).collect()
}

fn obstacle_bounds(count: usize, size: f32) -> Vec<ObstacleBounds> {
    let half = Vec3::new(1.0, 0.6, 0.3);
    let all = spheres(count, size).into_iter();
    all.map(|BoundingSphere { centre, radius }| obstacle(-centre.zxy() * 0.9, half * radius))
        .collect()
}

/// By how much a sphere ends short of both, metres, in f64: negative where it reaches both.
fn gap(obstacle: &ObstacleBounds, sphere: &BoundingSphere) -> f64 {
    let ObstacleBounds { aabb, sphere: other, .. } = obstacle;
    let (centre, radius) = (sphere.centre.as_dvec3(), f64::from(sphere.radius));
    let nearest = centre.clamp(aabb.min.as_dvec3(), aabb.max.as_dvec3());
    let between = centre.distance(other.centre.as_dvec3()) - f64::from(other.radius);
    centre.distance(nearest).max(between) - radius
}

/// Finds the cells of all spheres.
struct Cells<'a>(&'a ObstacleGrid, &'a [Sphere16], &'a mut Vec<IndexRow>);

impl Kernel for Cells<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        let Self(obstacle_grid, spheres, cells) = self;
        cells.resize(spheres.len(), IndexRow::default());
        for (spheres, cells) in spheres.iter().zip(cells) {
            l.store_u(obstacle_grid.cells(l, spheres), cells);
        }
    }
}

fn rows(spheres: &[BoundingSphere]) -> Vec<Sphere16> {
    let row = |spheres: &[BoundingSphere]| {
        let mut row = Sphere16::default();
        for (k, sphere) in spheres.iter().enumerate() {
            for (axis, x) in sphere.centre.to_array().into_iter().enumerate() {
                row.centre.0[axis].0[k] = x;
            }
            row.radius.0[k] = sphere.radius;
        }
        row
    };
    spheres.chunks(WIDTH).map(row).collect()
}

/// Notes the spheres as [`ObstacleGrid::look_up`] does.
fn note(
    obstacle_grid: &ObstacleGrid,
    spheres: &[BoundingSphere],
    path: Path,
    reached: &mut GridHits,
) {
    reached.clear();
    dispatch_on(path, Cells(obstacle_grid, &rows(spheres), &mut reached.cells));
    obstacle_grid.note(0..spheres.len(), &[], reached);
}

fn reached(obstacle_grid: &ObstacleGrid, spheres: &[BoundingSphere]) -> Vec<Vec<u32>> {
    let reported = |path| {
        let mut reached = GridHits::default();
        // The second time in memory that was used before, by more.
        for spheres in [&[spheres, spheres].concat(), spheres] {
            note(obstacle_grid, spheres, path, &mut reached);
            obstacle_grid.reach_on(path, &rows(spheres), &mut reached);
        }
        let mut all = vec![Vec::new(); spheres.len()];
        for (sphere, [start, end]) in reached.spans() {
            all[sphere] = reached.numbers()[start as usize..end as usize].to_vec();
        }
        all
    };
    let all = reported(Path::Portable);
    for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
        assert_eq!(reported(path), all, "{path:?}");
    }
    all
}

/// How many spheres it knew nothing of.
fn must_agree_with_the_plainest_judge(
    obstacle_bounds: &[ObstacleBounds],
    spheres: &[BoundingSphere],
) -> usize {
    let largest = spheres.iter().map(|sphere| sphere.radius).fold(0.0, f32::max);
    let obstacle_grid = ObstacleGrid::new(obstacle_bounds, largest);
    let mut unknown = 0;
    for (sphere, reported) in spheres.iter().zip(reached(&obstacle_grid, spheres)) {
        if reported == [obstacle_grid.unknown()] {
            unknown += 1;
            continue;
        }
        assert!(reported.is_sorted());
        for (number, obstacle) in (0..).zip(obstacle_bounds) {
            // What spheres allow for is far more than this.
            let (gap, rounding) = (gap(obstacle, sphere), 1e-6 * f64::from(largest));
            assert!(reported.contains(&number) || gap > -rounding, "{number} is lost: {gap}");
            assert!(!reported.contains(&number) || gap <= rounding, "{number} is reported: {gap}");
        }
    }
    unknown
}

#[test]
fn all_that_a_sphere_reaches_is_reported_and_nothing_else_at_every_size() {
    for size in [1e-9, 1e-3, 1.0, 1e6, 1e15] {
        for count in [0, 1, 30, 500] {
            let spheres = spheres(400, size);
            let unknown =
                must_agree_with_the_plainest_judge(&obstacle_bounds(count, size), &spheres);
            assert!(unknown < 40, "{unknown} of 400 are not known");
        }
    }
}

#[test]
fn far_from_the_origin_where_a_cell_is_few_steps_of_f32_all_is_reported_too() {
    for far in [1e3, 1e5, 3e6] {
        let shift = Vec3::new(far, -0.7 * far, 0.3 * far);
        let mut spheres = spheres(400, 1.0);
        spheres.iter_mut().for_each(|sphere| sphere.centre += shift);
        let shifted =
            |o: &ObstacleBounds| obstacle(o.sphere.centre + shift, Vec3::splat(o.sphere.radius));
        let obstacle_bounds: Vec<ObstacleBounds> =
            obstacle_bounds(200, 1.0).iter().map(shifted).collect();
        must_agree_with_the_plainest_judge(&obstacle_bounds, &spheres);
    }
}

#[test]
fn what_has_no_end_or_lies_far_off_is_reached_too() {
    let mut obstacle_bounds = obstacle_bounds(40, 1.0);
    obstacle_bounds.push(ObstacleBounds::EVERYTHING);
    let floor = Aabb { max: Vec3::new(1e37, 1e37, -0.3), ..Aabb::EVERYTHING };
    obstacle_bounds.push(ObstacleBounds { aabb: floor, ..ObstacleBounds::EVERYTHING });
    must_agree_with_the_plainest_judge(&obstacle_bounds, &spheres(400, 1.0));
    obstacle_bounds.push(obstacle(Vec3::splat(1e9), Vec3::ONE));
    must_agree_with_the_plainest_judge(&obstacle_bounds, &spheres(400, 1.0));
    let one_point = vec![obstacle(Vec3::ZERO, Vec3::ZERO); 3];
    must_agree_with_the_plainest_judge(
        &one_point,
        &[BoundingSphere { radius: 0.0, ..spheres(1, 0.0)[0] }],
    );
    must_agree_with_the_plainest_judge(&one_point, &spheres(50, 1e-3));
}

#[test]
fn of_a_crowd_and_of_a_larger_sphere_than_foreseen_nothing_is_known() {
    let crowd = vec![obstacle(Vec3::ZERO, Vec3::ONE); LONGEST + 1];
    let obstacle_grid = ObstacleGrid::new(&crowd, 0.5);
    let at = |x: f32, radius| BoundingSphere { centre: Vec3::X * x, radius };
    let queries = [at(0.0, 0.5), at(9.0, 0.5), at(9.0, 0.6), BoundingSphere::EVERYTHING];
    let unknown = vec![obstacle_grid.unknown()];
    assert_eq!(
        reached(&obstacle_grid, &queries),
        [unknown.clone(), vec![], unknown.clone(), unknown]
    );
    let obstacle_grid = ObstacleGrid::new(&crowd[..LONGEST], 0.5);
    assert_eq!(reached(&obstacle_grid, &queries[..1]), [(0..LONGEST as u32).collect::<Vec<_>>()]);
}

#[test]
fn pairs_are_those_of_the_boxes_that_overlap_and_are_kept() {
    let obstacle_bounds = obstacle_bounds(60, 1.0);
    let obstacle_grid = ObstacleGrid::new(&obstacle_bounds, 0.1);
    let numbers: Vec<u32> = (0..60).collect();
    let queries = Aabb { min: Vec3::splat(-0.7), max: Vec3::splat(0.4) };
    let mut pairs = vec![Pair::new(1, 2)];
    obstacle_grid.append_pairs((7, &queries), &numbers, |i| !i.is_multiple_of(3), &mut pairs);
    let overlaps =
        |i: &u32| obstacle_bounds[*i as usize].aabb.overlaps(&queries) && !i.is_multiple_of(3);
    let due: Vec<Pair> = numbers.into_iter().filter(overlaps).map(|i| Pair { i, j: 7 }).collect();
    assert!(due.len() > 3);
    assert_eq!(pairs[1..], due);
}

#[test]
fn the_likeliest_is_reported_with_its_shortfall_and_most_contacts_are_its() {
    let mut obstacle_bounds = obstacle_bounds(200, 1.0);
    obstacle_bounds.iter_mut().for_each(|obstacle| obstacle.inner.radius *= 4.0);
    let spheres = spheres(2000, 1.0);
    let obstacle_grid = ObstacleGrid::new(&obstacle_bounds, 0.2);
    let mut reached = GridHits::default();
    note(&obstacle_grid, &spheres, Path::best(), &mut reached);
    let inner = |sphere: &BoundingSphere| InscribedSphere {
        centre: sphere.centre,
        radius: sphere.radius * 0.7,
    };
    let mut noted = vec![(obstacle_grid.unknown(), f32::INFINITY); spheres.len()];
    reached.sift(0, 1, |sphere, cell| {
        assert_eq!(sphere, cell.sphere as usize);
        noted[sphere] = (cell.likeliest, obstacle_grid.short_of(cell, &inner(&spheres[sphere])));
        false
    });
    let (mut touching, mut reported) = (0, 0);
    for (sphere, &(likeliest, short_of)) in spheres.iter().zip(&noted) {
        let due = |obstacle: &ObstacleBounds| obstacle.inner.short_of(&inner(sphere));
        let least = obstacle_bounds.iter().map(due).fold(f32::INFINITY, f32::min);
        match obstacle_bounds.get(likeliest as usize) {
            Some(obstacle) => assert_eq!(short_of, due(obstacle)),
            None => assert!(likeliest == obstacle_grid.unknown() && short_of == f32::INFINITY),
        }
        touching += usize::from(least <= 0.0);
        reported += usize::from(short_of <= 0.0);
    }
    assert!(touching > 100 && 5 * reported > 4 * touching, "{reported} of {touching}");
}

#[test]
fn posed_bounds_are_looked_up_by_their_spheres_row_after_row() {
    let obstacle_bounds = obstacle_bounds(60, 1.0);
    let obstacle_grid = ObstacleGrid::new(&obstacle_bounds, 0.3);
    let shapes = [0.1, 0.2, 0.05].map(|radius| Shape::sphere(radius).unwrap());
    let bounds = PackedSphereBounds::new(shapes.iter().map(SphereBounds::of).collect());
    let centres = spheres(100, 1.0).into_iter().map(|sphere| sphere.centre.as_dvec3());
    let poses: Vec<Pose> = centres.map(|t| Pose::from_translation(t).unwrap()).collect();
    let mut found = vec![Sphere16::default(); poses.len().div_ceil(WIDTH)];
    let mut reached = GridHits::default();
    let posed = PosedBounds { bounds: &bounds, poses: &poses };
    // Rows that are not there are none.
    for rows in [0..3, 3..4, 4..9, 8..9] {
        obstacle_grid.look_up(posed, rows, &mut found, &mut reached);
    }
    let mut due = Vec::new();
    for (k, (pose, shape)) in poses.iter().zip(shapes.iter().cycle()).enumerate() {
        let (sphere, plain) =
            (found[k / WIDTH].get(k % WIDTH), SphereBounds::of(shape).unwrap().sphere(pose));
        assert!(sphere.centre.distance(plain.centre) < 1e-6, "{k}: {sphere:?}, {plain:?}");
        assert!((sphere.radius - plain.radius).abs() < 1e-6, "{k}: {sphere:?}, {plain:?}");
        due.push(sphere);
    }
    let mut again = GridHits::default();
    note(&obstacle_grid, &due, Path::best(), &mut again);
    assert!(reached.noted() > 20 && reached.noted() == again.noted());
    obstacle_grid.reach(&found, &mut reached);
    obstacle_grid.reach(&rows(&due), &mut again);
    assert!(reached.spans().eq(again.spans()) && reached.numbers() == again.numbers());
}

#[test]
fn a_run_that_has_ended_is_reported_no_more_and_none_of_it_is_noted() {
    let crowd = [obstacle(Vec3::ZERO, Vec3::ONE)];
    let obstacle_grid = ObstacleGrid::new(&crowd, 0.5);
    // Near it are all but the 3rd and all of the run that is third.
    let far = |k: usize| k == 3 || (8..12).contains(&k);
    let sphere = |k: usize| BoundingSphere {
        centre: Vec3::X * [0.0, 9.0][usize::from(far(k))],
        radius: 0.5,
    };
    let spheres: Vec<BoundingSphere> = (0..18).map(sphere).collect();
    let mut reached = GridHits::default();
    note(&obstacle_grid, &spheres, Path::best(), &mut reached);
    let mut reported = Vec::new();
    reached.sift(2, 4, |run, cell| {
        reported.push((run, cell.sphere));
        cell.sphere == 5 || cell.sphere == 17
    });
    assert_eq!(
        reported,
        [2, 4, 5, 12, 13, 14, 15, 16, 17].map(|sphere| (sphere as usize / 4, sphere))
    );
    obstacle_grid.reach(&rows(&spheres), &mut reached);
    let left: Vec<usize> = reached.spans().map(|(sphere, _)| sphere).collect();
    assert_eq!(left, [0, 1, 2, 12, 13, 14, 15]);
}
