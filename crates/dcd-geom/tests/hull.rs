//! Hulls of clouds against integers: no point outside, no corner too many.

use dcd_geom::glam::{DMat3, DVec3};
use dcd_geom::{ConvexHull, Dimension, HullError};
use num_bigint::BigInt;

type Exact = [BigInt; 3];

/// The points times one power of two, as integers.
fn exact(points: &[DVec3]) -> Vec<Exact> {
    let parts = |x: f64| {
        let (bits, sign) = (x.to_bits(), if x < 0.0 { -1 } else { 1 });
        let exponent = (bits >> 52 & 0x7ff) as i64;
        let fraction = (bits & ((1 << 52) - 1)) as i64;
        let whole = if exponent == 0 { fraction } else { fraction | 1 << 52 };
        (sign * whole, exponent.max(1))
    };
    let numbers = points.iter().flat_map(|p| p.to_array()).filter(|&x| x != 0.0);
    let lowest = numbers.map(|x| parts(x).1).min().unwrap_or(1);
    let whole = |x: f64| {
        let (whole, exponent) = parts(x);
        BigInt::from(whole) << (exponent - lowest).max(0) as usize
    };
    points.iter().map(|p| p.to_array().map(whole)).collect()
}

fn minus(p: &Exact, q: &Exact) -> Exact {
    [&p[0] - &q[0], &p[1] - &q[1], &p[2] - &q[2]]
}

fn cross(p: &Exact, q: &Exact) -> Exact {
    let minor = |j: usize, k: usize| &p[j] * &q[k] - &p[k] * &q[j];
    [minor(1, 2), minor(2, 0), minor(0, 1)]
}

fn dot(p: &Exact, q: &Exact) -> BigInt {
    &p[0] * &q[0] + &p[1] * &q[1] + &p[2] * &q[2]
}

/// Panics unless the hull is a closed surface, none of the cloud is outside of any triangle's plane,
/// and at each corner three planes meet in that point alone.
fn prove(cloud: &[DVec3]) -> ConvexHull {
    let hull = ConvexHull::of(cloud).unwrap();
    assert_eq!(hull.dimension(), Dimension::Solid, "{cloud:?}");
    assert!(hull.corners().windows(2).all(|pair| pair[0] < pair[1]), "{cloud:?}");
    let points = exact(cloud);
    let corners: Vec<&Exact> = hull.corners().iter().map(|&k| &points[k as usize]).collect();
    let mut edges = Vec::new();
    let mut normals = vec![Vec::new(); corners.len()];
    for &triangle in hull.triangles() {
        let [a, b, c] = triangle.map(|k| corners[k as usize]);
        let normal = cross(&minus(b, a), &minus(c, a));
        let level = dot(&normal, a);
        assert!(points.iter().all(|p| dot(&normal, p) <= level), "outside: {cloud:?}");
        let [i, j, k] = triangle;
        edges.extend([[i, j], [j, k], [k, i]]);
        triangle.iter().for_each(|&k| normals[k as usize].push(normal.clone()));
    }
    let mut back: Vec<_> = edges.iter().map(|&[i, j]| [j, i]).collect();
    edges.sort_unstable();
    back.sort_unstable();
    assert!(edges.windows(2).all(|pair| pair[0] != pair[1]), "an edge occurs twice: {cloud:?}");
    assert_eq!(edges, back, "open: {cloud:?}");
    assert_eq!(hull.triangles().len() + 4, 2 * corners.len(), "no sphere: {cloud:?}");
    let zero = BigInt::from(0);
    for (corner, normals) in normals.iter().enumerate() {
        let is_corner = normals
            .iter()
            .any(|n| normals.iter().any(|m| normals.iter().any(|l| dot(&cross(n, m), l) != zero)));
        assert!(is_corner, "corner {corner} is in a face or edge: {cloud:?}");
    }
    hull
}

/// As many of the clouds as span a volume are proved; at least half must.
fn prove_all(clouds: impl Iterator<Item = Vec<DVec3>>) {
    let (mut proved, mut all) = (0, 0);
    for cloud in clouds {
        all += 1;
        if ConvexHull::of(&cloud).unwrap().dimension() == Dimension::Solid {
            prove(&cloud);
            proved += 1;
        }
    }
    assert!(2 * proved >= all, "{proved} of {all}");
}

/// A multiplicative generator of numbers in −1 … 1: enough for places.
struct Draw(u64);

impl Draw {
    fn number(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(0xd134_2543_de82_ef95).wrapping_add(1);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    fn point(&mut self) -> DVec3 {
        DVec3::new(self.number(), self.number(), self.number())
    }

    fn cloud(&mut self, count: usize, place: impl Fn(DVec3) -> DVec3) -> Vec<DVec3> {
        (0..count).map(|_| place(self.point())).collect()
    }
}

/// Few coordinates: most points are coplanar with many.
fn lattice(draw: &mut Draw, count: usize, steps: f64) -> Vec<DVec3> {
    draw.cloud(count, |p| (p * steps).round())
}

#[test]
fn no_point_of_a_random_or_squeezed_cloud_is_outside_and_no_corner_is_too_many() {
    let mut draw = Draw(1);
    prove_all((0..120).map(|k| {
        let squeeze = DVec3::new(1.0, 10f64.powi(-(k % 7)), 10f64.powi(-(k % 17)));
        let offset = draw.point() * if k % 3 == 0 { 1e6 } else { 0.0 };
        draw.cloud(8 + k as usize, |p| p * squeeze + offset)
    }));
}

#[test]
fn of_lattices_grids_and_repeated_points_the_corners_alone_are_left() {
    let mut draw = Draw(2);
    prove_all((0..150).map(|k| {
        let mut cloud = lattice(&mut draw, 20 + k, 1.0 + (k % 5) as f64);
        cloud.extend_from_within(..cloud.len() / 2);
        cloud
    }));
    let grid = |k: u32| DVec3::new((k % 6).into(), (k / 6 % 6).into(), (k / 36).into());
    let hull = prove(&(0..216).map(grid).collect::<Vec<_>>());
    assert_eq!(hull.corners(), [0, 5, 30, 35, 180, 185, 210, 215]);
    assert_eq!(hull.triangles().len(), 12);
}

#[test]
fn every_point_of_a_sphere_is_a_corner_on_common_circles_too() {
    let mut draw = Draw(3);
    for _ in 0..10 {
        let cloud = draw.cloud(150, DVec3::normalize);
        assert_eq!(prove(&cloud).corners().len(), 150);
    }
    let whole = |k: i32| [k % 39 - 19, k / 39 % 39 - 19, k / 1521 - 19];
    let on_sphere = |p: &[i32; 3]| p.iter().map(|x| x * x).sum::<i32>() == 369;
    let spots = (0..59_319).map(whole).filter(on_sphere);
    let cloud: Vec<_> = spots.map(|p| DVec3::from_array(p.map(f64::from))).collect();
    assert!(cloud.len() > 100);
    assert_eq!(prove(&cloud).corners().len(), cloud.len());
}

#[test]
fn clouds_that_are_nearly_flat_or_straight_lose_nothing() {
    let mut draw = Draw(4);
    prove_all((0..60).map(|k| {
        let turn = DMat3::from_axis_angle(draw.point().normalize(), draw.number());
        let thin = DVec3::new(1.0, [1.0, 1e-15][k % 2], [0.0, 1e-16, 1e-18][k % 3]);
        let place = draw.point() * [0.0, 1.0, 1e3][k % 3];
        // What is left of the plane or line is noise of the last bits.
        draw.cloud(40, |p| turn * (p * thin) + place)
    }));
    // A square whose points are off its plane by the smallest number there is.
    let mut square = lattice(&mut draw, 50, 3.0);
    square.iter_mut().for_each(|p| *p *= DVec3::new(1.0, 1.0, 0.0) * 2f64.powi(-700));
    square[7].z = 5e-324;
    square[9].z = -5e-324;
    prove(&square);
}

#[test]
fn the_largest_and_the_smallest_clouds_have_the_hulls_of_those_in_between() {
    let cloud = Draw(5).cloud(60, |p| (p * 1024.0).round());
    let hull = prove(&cloud);
    for exponent in [-1074, -1022, -600, 0, 600, 1013] {
        let [half, rest] = [exponent / 2, exponent - exponent / 2].map(|e| 2f64.powi(e));
        let scaled: Vec<_> = cloud.iter().map(|&p| p * half * rest).collect();
        assert_eq!(prove(&scaled), hull, "2^{exponent}");
    }
}

#[test]
fn clouds_without_volume_have_the_ends_and_rings_that_they_should() {
    let corners = |cloud: &[DVec3]| {
        let hull = ConvexHull::of(cloud).unwrap();
        assert!(hull.triangles().is_empty());
        (hull.dimension(), hull.corners().to_vec())
    };
    assert_eq!(corners(&[DVec3::ONE]), (Dimension::Point, vec![0]));
    assert_eq!(corners(&[DVec3::ZERO, -DVec3::ZERO]), (Dimension::Point, vec![0]));
    let line: Vec<_> = [3.0, -1.0, 7.0, 7.0, -1.0].map(|t| DVec3::new(t, 2.0 * t, -t)).to_vec();
    assert_eq!(corners(&line), (Dimension::Line, vec![1, 2]));
    let two = [DVec3::splat(-f64::MAX), DVec3::splat(f64::MAX)];
    assert_eq!(corners(&two), (Dimension::Line, vec![0, 1]));
    // In each plane of two axes and in one across all.
    for [u, v] in [[DVec3::X, DVec3::Y], [DVec3::Y, DVec3::Z], [DVec3::Z, DVec3::X]] {
        for v in [v, v + DVec3::new(1.0, 2.0, 3.0)] {
            let spot = |k: u32| u * f64::from(k % 5) + v * f64::from(k / 5);
            let grid: Vec<_> = (0..20).map(spot).collect();
            assert_eq!(corners(&grid), (Dimension::Plane, vec![0, 4, 15, 19]));
        }
    }
}

#[test]
fn a_hull_is_the_same_whatever_the_order_of_the_cloud() {
    let places = |cloud: &[DVec3]| {
        let hull = ConvexHull::of(cloud).unwrap();
        let places = hull.corners().iter().map(|&k| cloud[k as usize].to_array());
        let mut places: Vec<_> = places.collect();
        places.sort_by(|p, q| p.partial_cmp(q).unwrap());
        places
    };
    let mut draw = Draw(6);
    for k in 0..30 {
        let cloud = lattice(&mut draw, 60, 2.0 + f64::from(k % 4));
        let backwards: Vec<_> = cloud.iter().rev().copied().collect();
        assert_eq!(places(&cloud), places(&backwards));
    }
}

#[test]
fn a_hundred_thousand_points_have_a_hull() {
    let cloud = Draw(7).cloud(100_000, DVec3::normalize);
    assert_eq!(ConvexHull::of(&cloud).unwrap().corners().len(), 100_000);
}

#[test]
fn what_has_no_hull_is_refused_with_its_index_and_value() {
    assert_eq!(ConvexHull::of(&[]), Err(HullError::Empty));
    let infinite = [DVec3::ZERO, DVec3::new(0.0, f64::INFINITY, 1.0)];
    let refused = HullError::NotFinite { index: 1, value: f64::INFINITY };
    assert_eq!(ConvexHull::of(&infinite), Err(refused));
    let wide = [DVec3::ZERO, DVec3::new(1.0, 1e-250, 1.0)];
    assert_eq!(ConvexHull::of(&wide), Err(HullError::TooWide));
}
