//! The nearest points of cores beside the same in f64, and rounded scenes beside exact arithmetic.

use super::super::simplex::{Nearest, Vertex};
use super::super::vector::V3;
use super::forms::contacts;
use super::{Numbers, pairs, paths};
use crate::{Method, PosedSupport, certified};
use dcd_geom::glam::{DQuat, DVec3};
use dcd_geom::{Pair, Pose, Scene, Shape};
use dcd_simd::{Kernel, Lanes, Row, WIDTH, dispatch_on};

/// Sixteen times four points, w first.
struct Four<'a>(&'a [[Row; 3]; 4]);

impl Kernel for Four<'_> {
    type Output = ([Row; 3], Row);

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Self::Output {
        let (mut point, mut squared) = ([Row::default(); 3], Row::default());
        let load = |k: usize| Vertex::unnumbered(l, V3::<L>::load(l, &self.0[k]));
        let nearest = Nearest::of(l, load(0), [load(1), load(2), load(3)]);
        nearest.point.store(l, &mut point);
        l.store(nearest.squared, &mut squared);
        (point, squared)
    }
}

/// The least distance from the origin of w, the segments from it to the others, and the insides of
/// the triangles with two of them, by angles and areas.
fn plain([w, rest @ ..]: [DVec3; 4]) -> f64 {
    let mut least = w.length();
    for (k, &p) in rest.iter().enumerate() {
        let along = (p - w).normalize_or_zero();
        if w.dot(along) < 0.0 && p.dot(along) > 0.0 {
            least = least.min(w.reject_from(along).length());
        }
        least = least.min(p.length());
        let q = rest[(k + 1) % 3];
        let normal = (p - w).cross(q - w);
        let foot = normal * (normal.dot(w) / normal.length_squared());
        let sides = [(w, p), (p, q), (q, w)].map(|(from, to)| (to - from).cross(foot - from));
        if sides.iter().all(|side| side.dot(normal) > 0.0) {
            least = least.min(foot.length());
        }
    }
    least
}

/// The direction to the nearest point of each four, the edges from w to the two others that it lies between, and their
/// weights.
struct Directions<'a>(&'a [[Row; 3]; 4]);

impl Kernel for Directions<'_> {
    type Output = ([[Row; 3]; 4], [Row; 2]);

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Self::Output {
        let (mut found, mut weights) = ([[Row::default(); 3]; 4], [Row::default(); 2]);
        let load = |k: usize| Vertex::unnumbered(l, V3::<L>::load(l, &self.0[k]));
        let nearest = Nearest::of(l, load(0), [load(1), load(2), load(3)]);
        nearest.direction(l, load(0)).store(l, &mut found[0]);
        nearest.point.store(l, &mut found[1]);
        nearest.p.at.store(l, &mut found[2]);
        nearest.q.at.store(l, &mut found[3]);
        l.store(nearest.weights[0], &mut weights[0]);
        l.store(nearest.weights[1], &mut weights[1]);
        (found, weights)
    }
}

#[test]
fn a_direction_is_at_right_angles_to_what_the_nearest_point_lies_in() {
    let mut numbers = Numbers(43);
    let (mut points_off, mut seen) = (0, [0; 3]);
    for group in 0..400 {
        // So near the origin that the point's own rounding turns it.
        let fours: [[DVec3; 4]; WIDTH] = std::array::from_fn(|_| {
            let around = numbers.vector();
            std::array::from_fn(|k| numbers.vector() * [0.0, 1.0, 1.0, 1.0][k] + around * 0.02)
        });
        let rows: [[Row; 3]; 4] = std::array::from_fn(|k| {
            std::array::from_fn(|axis| Row(fours.map(|four| four[k][axis] as f32)))
        });
        for path in paths() {
            let ([direction, point, p, q], weights) = dispatch_on(path, Directions(&rows));
            for lane in 0..WIDTH {
                let at = |rows: &[Row; 3]| {
                    DVec3::from_array([0, 1, 2].map(|axis| rows[axis].0[lane].into()))
                };
                let (direction, point, w) = (at(&direction), at(&point), at(&rows[0]));
                let has = weights.map(|weight| weight.0[lane] > 0.0);
                let edges = [at(&p) - w, at(&q) - w];
                let sine = edges[0].normalize_or_zero().cross(edges[1].normalize_or_zero());
                seen[usize::from(has[0]) + usize::from(has[1])] += 1;
                if has[1] && sine.length() < 0.1 {
                    continue;
                }
                for edge in (0..2).filter(|&k| has[k]).map(|k| edges[k]) {
                    let cosine = |v: DVec3| v.normalize().dot(edge.normalize()).abs();
                    let off = cosine(direction);
                    assert!(off < 1e-5, "{path:?} {group} {lane}: {off:e}");
                    points_off += usize::from(cosine(point) > 1e-5);
                }
                assert!(direction.distance(point) < 1e-5, "{path:?} {group} {lane}");
            }
        }
    }
    assert!(points_off > 100 && seen.iter().all(|&count| count > 100), "{points_off} {seen:?}");
}

#[test]
fn the_nearest_point_of_four_is_that_of_f64_and_as_near_as_it_says() {
    let mut numbers = Numbers(41);
    for group in 0..400 {
        // Some repeat a point, as the first rounds do.
        let fours: [[DVec3; 4]; WIDTH] = std::array::from_fn(|lane| {
            let around = numbers.vector() * 2.0;
            let mut four: [DVec3; 4] =
                std::array::from_fn(|_| (numbers.vector() + around).as_vec3().as_dvec3());
            if lane % 4 == 1 {
                four[3] = four[2];
            }
            if lane % 4 == 2 {
                (four[2], four[3]) = (four[1], four[1]);
            }
            four
        });
        let rows: [[Row; 3]; 4] = std::array::from_fn(|k| {
            std::array::from_fn(|axis| Row(fours.map(|four| four[k][axis] as f32)))
        });
        for path in paths() {
            let (point, squared) = dispatch_on(path, Four(&rows));
            for (lane, &four) in fours.iter().enumerate() {
                let point = DVec3::from_array([0, 1, 2].map(|axis| point[axis].0[lane].into()));
                let (found, least) = (point.length(), plain(four));
                assert!((found - least).abs() < 1e-3, "{path:?} {group} {lane}: {found} {least}");
                assert!((f64::from(squared.0[lane]).sqrt() - found).abs() < 1e-5);
            }
        }
    }
}

/// Capsules, spheres, boxes and rounded hulls near one another, some with parallel edges.
fn rounded(seed: u64) -> Scene {
    let mut numbers = Numbers(seed);
    let shapes = (0..80).map(|k| {
        let radius = 0.05 + 0.2 * numbers.next().abs();
        let shape = match k % 5 {
            0 => Shape::sphere(radius),
            1 => Shape::capsule(numbers.next().abs(), radius),
            2 => Shape::cuboid((numbers.vector() * 0.5).abs()).and_then(|s| s.rounded(radius)),
            3 => Shape::cuboid((numbers.vector() * 0.5).abs()),
            _ => Shape::hull((0..20).map(|_| numbers.vector() * 0.5).collect())
                .and_then(|s| s.rounded(radius)),
        };
        shape.unwrap()
    });
    let shapes: Vec<Shape> = shapes.collect();
    let poses = shapes.iter().enumerate().map(|(k, _)| {
        let place = numbers.vector() * 1.5;
        if k % 8 == 0 {
            return Pose::from_translation(place).unwrap();
        }
        let turn = DQuat::from_xyzw(numbers.next(), numbers.next(), numbers.next(), numbers.next());
        Pose::new(turn.normalize(), place).unwrap()
    });
    let poses = poses.collect();
    Scene::one_each(shapes, poses).unwrap()
}

#[test]
fn rounded_shapes_are_answered_in_the_lanes_as_exact_integers_answer_them() {
    for seed in 50..53 {
        let scene = rounded(seed);
        let body = |i: u32| {
            let polytope = scene.shape(i as usize).as_polytope().unwrap();
            PosedSupport::polytope(polytope, &scene.poses()[i as usize])
        };
        let touch = |pair: &Pair| certified::overlap_exactly(body(pair.i), body(pair.j));
        let exact: Vec<Pair> = pairs(&scene).into_iter().filter(touch).collect();
        for path in paths() {
            let (found, report) = contacts(&scene, path);
            assert_eq!(found, exact, "{path:?}");
            let left = report.resolved(Method::F64) + report.resolved(Method::Exact);
            assert!(left < 5 && report.resolved(Method::Portal) > 100, "{path:?}: {report:?}");
        }
    }
}
