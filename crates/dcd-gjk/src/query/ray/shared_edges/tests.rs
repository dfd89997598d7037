use super::super::tests::Random;
use super::super::{Ray, first_hit};
use crate::PosedShape;
use dcd_geom::glam::{DMat3, DVec3};
use dcd_geom::{Pose, Shape};
use std::collections::BTreeSet;
use std::f64::consts::{PI, TAU};

/// Vertices and triangles.
type Surface = (Vec<DVec3>, Vec<[u32; 3]>);

/// A cuboid, two triangles a face.
fn cube() -> Surface {
    let sign = |k: u32, bit: u32| if k & bit == 0 { -1.0 } else { 1.0 };
    let vertices = (0..8).map(|k| DVec3::new(sign(k, 1), sign(k, 2), sign(k, 4)));
    let faces =
        [[0, 2, 1, 3], [4, 5, 6, 7], [0, 1, 4, 5], [2, 6, 3, 7], [0, 4, 2, 6], [1, 3, 5, 7]];
    let triangles = faces.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [b, d, c]]);
    (vertices.collect(), triangles.collect())
}

/// A ball of twelve meridians, which meet at the poles.
fn ball() -> Surface {
    let (around, rings) = (12u32, 6u32);
    let mut vertices = vec![DVec3::Z, -DVec3::Z];
    for ring in 1..rings {
        for k in 0..around {
            let (theta, phi) =
                (PI * f64::from(ring) / f64::from(rings), TAU * f64::from(k) / f64::from(around));
            let (sin, cos) = theta.sin_cos();
            vertices.push(DVec3::new(sin * phi.cos(), sin * phi.sin(), cos));
        }
    }
    let at = |ring: u32, k: u32| 2 + (ring - 1) * around + k % around;
    let mut triangles = Vec::new();
    for k in 0..around {
        triangles.push([0, at(1, k), at(1, k + 1)]);
        triangles.push([1, at(rings - 1, k + 1), at(rings - 1, k)]);
        for ring in 1..rings - 1 {
            let [a, b] = [at(ring, k), at(ring, k + 1)];
            let [c, d] = [at(ring + 1, k), at(ring + 1, k + 1)];
            triangles.extend([[a, c, b], [b, c, d]]);
        }
    }
    (vertices, triangles)
}

fn edges(triangles: &[[u32; 3]]) -> BTreeSet<[u32; 2]> {
    let all = triangles.iter().flat_map(|&[p, q, r]| [[p, q], [q, r], [r, p]]);
    all.map(|[p, q]| [p.min(q), p.max(q)]).collect()
}

/// A ray into a surface through a corner or through an edge, and the triangles there.
struct Aimed {
    ray: Ray,
    there: Vec<usize>,
}

impl Aimed {
    /// `None` unless all triangles that are there face the ray.
    fn of(random: &mut Random, (vertices, triangles): &Surface, ends: &[u32]) -> Option<Self> {
        let weight = 0.2 + 0.3 * (1.0 + random.vector().x);
        let target = match *ends {
            [p, q] => vertices[p as usize].lerp(vertices[q as usize], weight),
            _ => vertices[ends[0] as usize],
        };
        let from = target * 2.0 + random.vector() * 0.8;
        let is_there = |&k: &usize| ends.iter().all(|end| triangles[k].contains(end));
        let there: Vec<usize> = (0..triangles.len()).filter(is_there).collect();
        let way = (target - from).normalize();
        let faces = |&k: &usize| {
            let [p, q, r] = triangles[k].map(|corner| vertices[corner as usize]);
            let normal = (q - p).cross(r - p);
            // Outward, whichever way the triangle goes round.
            (normal * normal.dot(p).signum()).normalize().dot(way) < -0.05
        };
        let ray = Ray::endless(from, target - from).unwrap();
        there.iter().all(faces).then_some(Self { ray, there })
    }
}

/// Without the triangles of those numbers; every other one goes round the other way where `mixes` says so.
fn mesh((vertices, triangles): &Surface, without: &[usize], mixes: bool) -> Shape {
    let turned = |(k, &[p, q, r]): (usize, &[u32; 3])| {
        if mixes && k % 2 == 0 { [q, p, r] } else { [p, q, r] }
    };
    let all = triangles.iter().enumerate().filter(|(k, _)| !without.contains(k));
    Shape::mesh(vertices.clone(), all.map(turned).collect()).unwrap()
}

#[test]
fn a_ray_into_a_closed_surface_certainly_meets_it_at_edges_and_corners_too() {
    let mut random = Random::seeded(93);
    let (mut aimed_at, mut doubtful_alone) = (0, 0);
    for round in 0..24 {
        let (mut vertices, triangles) = if round % 2 == 0 { cube() } else { ball() };
        if round >= 4 {
            let scale =
                DMat3::from_diagonal(DVec3::new(1.0, 0.7, 1.3)) * [1.0, 1e-4, 1e5][round % 3];
            vertices.iter_mut().for_each(|vertex| *vertex = scale * *vertex);
        }
        let size = vertices[0].length();
        let pose = match round % 4 {
            0 | 1 => Pose::IDENTITY,
            _ => random.pose(DVec3::ONE * (3.0 * size)),
        };
        let surface = (vertices, triangles);
        let is_mixed = round % 3 == 0;
        let whole = mesh(&surface, &[], is_mixed);
        let corners = (0..surface.0.len() as u32).map(|corner| vec![corner]);
        for ends in corners.chain(edges(&surface.1).into_iter().map(Vec::from)) {
            let unit: Surface =
                (surface.0.iter().map(|vertex| *vertex / size).collect(), surface.1.clone());
            let Some(Aimed { ray, there }) = Aimed::of(&mut random, &unit, &ends) else { continue };
            let (from, to) = (ray.origin() * size, (ray.origin() + ray.direction()) * size);
            let from = pose.apply(from);
            let ray = Ray::endless(from, pose.apply(to) - from).unwrap();
            let posed = PosedShape { shape: &whole, pose: &pose };
            let hit = first_hit(&ray, posed).unwrap();
            assert!(hit.is_certain, "{round} {ends:?} {hit:?}");
            let holds = hit.t_lower - 1e-12 <= 1.0 && 1.0 <= hit.t_upper + 1e-12;
            assert!(holds && hit.error_bound() < 1e-9, "{round} {ends:?} {hit:?}");
            aimed_at += 1;
            // With one of them gone, the ray may go through the gap beside the others.
            let left_out = there[round % there.len()];
            let open = mesh(&surface, &[left_out], is_mixed);
            let hit = first_hit(&ray, PosedShape { shape: &open, pose: &pose }).unwrap();
            if hit.t < 1.0 + 1e-9 {
                assert!(!hit.is_certain, "{round} {ends:?} {hit:?}");
                doubtful_alone += 1;
            }
        }
    }
    assert!(aimed_at > 300 && doubtful_alone > 200, "{aimed_at} {doubtful_alone}");
}

#[test]
fn the_middle_of_a_cubes_face_is_certainly_met_and_its_rim_is_not() {
    let whole = mesh(&cube(), &[], false);
    let posed = PosedShape { shape: &whole, pose: &Pose::IDENTITY };
    let at = |y: f64, z: f64| {
        first_hit(&Ray::endless(DVec3::new(-5.0, y, z), DVec3::X).unwrap(), posed).unwrap()
    };
    let middle = at(0.0, 0.0);
    assert!(middle.is_certain && (middle.t - 4.0).abs() < 1e-12, "{middle:?}");
    assert!(!at(1.0, 0.0).is_certain && !at(1.0, 1.0).is_certain);
}

/// Where a vertical line meets a triangle of whole coordinates, exactly: between these heights, if it does.
fn heights([p, q, r]: [[i64; 3]; 3], [x, y]: [i64; 2]) -> Option<[f64; 2]> {
    let area = |a: [i64; 3], b: [i64; 3]| (a[0] - x) * (b[1] - y) - (a[1] - y) * (b[0] - x);
    let weights = [area(q, r), area(r, p), area(p, q)];
    let sum: i64 = weights.iter().sum();
    if sum != 0 {
        let is_inside = weights.iter().all(|&w| w * sum.signum() >= 0);
        let along = weights[0] * p[2] + weights[1] * q[2] + weights[2] * r[2];
        return is_inside.then_some([along as f64 / sum as f64; 2]);
    }
    // Seen edge on: where the line meets its edges.
    let mut found: Option<[f64; 2]> = None;
    for [a, b] in [[p, q], [q, r], [r, p]] {
        let ends = [0, 1].map(|k| (a[k].min(b[k]), a[k].max(b[k])));
        let holds = (ends[0].0..=ends[0].1).contains(&x) && (ends[1].0..=ends[1].1).contains(&y);
        if area(a, b) != 0 || !holds {
            continue;
        }
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let span = match dx * dx + dy * dy {
            0 => [a[2].min(b[2]) as f64, a[2].max(b[2]) as f64],
            square => {
                let part = ((x - a[0]) * dx + (y - a[1]) * dy) as f64 / square as f64;
                [a[2] as f64 + part * (b[2] - a[2]) as f64; 2]
            }
        };
        let known = found.unwrap_or(span);
        found = Some([known[0].min(span[0]), known[1].max(span[1])]);
    }
    found
}

#[test]
fn certain_hits_of_crumpled_meshes_on_a_grid_are_those_of_whole_numbers() {
    let mut random = Random::seeded(41);
    let (mut certain, mut doubtful, mut missed) = (0, 0, 0);
    for round in 0..600i64 {
        let mut draw = |count: i64| ((random.next() * 0.5 + 0.5) * count as f64) as i64;
        let side = 3 + round % 3;
        let vertices: Vec<[i64; 3]> =
            (0..6 + round % 5).map(|_| [draw(side), draw(side), draw(3)]).collect();
        let mut corner = || draw(vertices.len() as i64) as u32;
        let triangles: Vec<[u32; 3]> =
            (0..4 + round % 9).map(|_| [corner(), corner(), corner()]).collect();
        let places = vertices.iter().map(|v| DVec3::from_array(v.map(|x| x as f64)));
        let mesh = Shape::mesh(places.collect(), triangles.clone()).unwrap();
        for (x, y) in (0..side).flat_map(|x| (0..side).map(move |y| (x, y))) {
            let from = DVec3::new(x as f64, y as f64, -8.0);
            let ray = Ray::endless(from, DVec3::Z).unwrap();
            let truth = triangles.iter().filter_map(|triangle| {
                heights(triangle.map(|corner| vertices[corner as usize]), [x, y])
            });
            let truth: Vec<[f64; 2]> = truth.collect();
            let lowest = truth.iter().map(|[low, _]| low + 8.0).fold(f64::INFINITY, f64::min);
            match first_hit(&ray, PosedShape { shape: &mesh, pose: &Pose::IDENTITY }) {
                None => {
                    assert!(truth.is_empty(), "{round} {x} {y}");
                    missed += 1;
                }
                Some(hit) => {
                    let said = format!("{round} {x} {y}: {hit:?} {truth:?}");
                    assert!(hit.t_lower <= lowest + 1e-12, "{said}");
                    if hit.is_certain {
                        assert!(lowest <= hit.t_upper + 1e-12, "{said}");
                        certain += 1;
                    } else {
                        doubtful += 1;
                    }
                }
            }
        }
    }
    assert!(certain > 500 && doubtful > 1000 && missed > 1000, "{certain} {doubtful} {missed}");
}
