//! Proved faces beside the least of all directions that a face of A − B can have, in f64.

use super::super::proposed::tests::{proposed, scene, vertices};
use super::*;
use crate::motion::tests::Draw;
use dcd_geom::glam::DQuat;
use dcd_geom::{Object, Pose, Scene, Shape};
use dcd_simd::{Block, Row, Unfused, WIDTH};

/// How far a body reaches along a direction.
fn reach(vertices: &[DVec3], along: DVec3) -> f64 {
    vertices.iter().map(|v| v.dot(along)).fold(f64::NEG_INFINITY, f64::max)
}

/// The directions in which a face of a hull of these can lie, each and its opposite: those of all triples.
fn of_faces(vertices: &[DVec3]) -> Vec<DVec3> {
    let mut found = Vec::new();
    for (k, p) in vertices.iter().enumerate() {
        for (m, q) in vertices.iter().enumerate().skip(k + 1) {
            found.extend(vertices[m + 1..].iter().map(|r| (q - p).cross(r - p)));
        }
    }
    found
}

/// The same of its edges: those of all pairs.
fn of_edges(vertices: &[DVec3]) -> Vec<DVec3> {
    let others = |k: usize| vertices[k + 1..].iter().map(move |q| q - vertices[k]);
    (0..vertices.len()).flat_map(others).collect()
}

/// How deep two hulls overlap: each face of A − B is one of a, or of b, or of two edges.
fn depth(a: &[DVec3], b: &[DVec3]) -> f64 {
    let mut directions = of_faces(a);
    directions.extend(of_faces(b));
    let edges = of_edges(b);
    for edge in of_edges(a) {
        directions.extend(edges.iter().map(|other| edge.cross(*other)));
    }
    let long = directions.into_iter().filter_map(DVec3::try_normalize);
    let both = long.flat_map(|n| [n, -n]);
    both.map(|n| reach(a, n) + reach(b, -n)).fold(f64::INFINITY, f64::min)
}

#[test]
fn the_depth_is_between_the_bounds_of_a_nearest_face() {
    let mut draw = Draw(7);
    let (mut proved, mut others) = (0, 0);
    for far in [0.0, 100.0, 1e7] {
        let scene = scene(&mut draw, 1200, far);
        let pairs: Vec<_> = (0..1200).map(|k| Pair::new(2 * k, 2 * k + 1)).collect();
        for (pair, proposal) in pairs.iter().zip(proposed(&scene, Path::best(), &pairs)) {
            let Some(proposal) = proposal else { continue };
            let Some(face) = proposal.nearest else {
                others += 1;
                continue;
            };
            proved += 1;
            let (a, b) = (vertices(&scene, pair.i), vertices(&scene, pair.j));
            let (depth, [lower, upper]) = (depth(&a, &b), face.bounds.map(f64::from));
            // What the vertices themselves are rounded by, so far out.
            let off = far * 1e-15;
            assert!(lower <= depth + off && depth <= upper + off, "{pair:?}: {depth}, {face:?}");
            assert!(
                (f64::from(face.depth) - depth).abs() < 1e-6 + off,
                "{pair:?}: {depth}, {face:?}"
            );
            assert!(upper - lower < 2e-5 + 4.0 * far * 1e-15, "{face:?}");
        }
    }
    println!("{proved} proved, {others} not");
    assert!(proved > 300 && others > 300, "{proved}, {others}");
}

/// Pairs 2k, 2k + 1 of plates that lie on each other, every other pair turned.
fn plates(draw: &mut Draw, count: u32) -> Scene {
    let thick: [f64; 4] = [0.005, 0.01, 0.02, 0.05];
    let plate = |z: f64| {
        let corner = |k: u32| DVec3::from([0, 1, 2].map(|axis| f64::from(k >> axis & 1) - 0.5));
        Shape::hull((0..8).map(|k| corner(k) * DVec3::new(1.0, 0.8, 2.0 * z)).collect()).unwrap()
    };
    let mut objects = Vec::new();
    for k in 0..count {
        let (one, other) = (k % 4, k / 4 % 4);
        let turn = DQuat::from_rotation_z(if k % 2 == 0 { 0.0 } else { draw.number() });
        let least = thick[one as usize].min(thick[other as usize]);
        let deep = least * draw.number().abs();
        let height = thick[one as usize] + thick[other as usize] - deep;
        let beside = draw.vector() * DVec3::new(0.8, 0.6, 0.0);
        let at = [DVec3::ZERO, beside + DVec3::Z * height];
        objects.push(Object::new(one, Pose::from_translation(at[0]).unwrap()));
        objects.push(Object::new(other, Pose::new(turn, at[1]).unwrap()));
    }
    Scene::new(thick.map(plate).to_vec(), objects).unwrap()
}

#[test]
fn the_points_of_a_nearest_face_are_as_far_apart_as_it_is_deep() {
    let scene = plates(&mut Draw(11), 4000);
    let pairs: Vec<_> = (0..4000).map(|k| Pair::new(2 * k, 2 * k + 1)).collect();
    let mut proved = 0;
    for (pair, proposal) in pairs.iter().zip(proposed(&scene, Path::best(), &pairs)) {
        let Some(Proposal { triangle, nearest: Some(face) }) = proposal else { continue };
        proved += 1;
        let (a, b) = (vertices(&scene, pair.i), vertices(&scene, pair.j));
        let corner = |[i, j]: [u32; 2]| a[i.min(7) as usize] - b[j.min(7) as usize];
        let ([p, q, r], [second, third]) = (triangle.map(corner), face.weights.map(f64::from));
        let between = p + (q - p) * second + (r - p) * third;
        // Of A − B, or of B − A.
        let normal = face.normal.as_dvec3() * between.dot(face.normal.as_dvec3()).signum();
        let off = between.distance(normal * f64::from(face.depth));
        // The sizes and the way between the centres are below 2.8.
        assert!(off < 4e-6, "{pair:?}: {off}, {face:?}");
    }
    println!("{proved} proved");
    assert!(proved > 300, "{proved}");
}

/// Sixteen triangles and spheres: the bounds from below where they hold, else NaN.
struct Lower<'a> {
    corners: &'a [Block; 3],
    centres: &'a Block,
    radii: &'a Row,
}

impl Kernel for Lower<'_> {
    type Output = Row;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Row {
        let [p, q, r] = self.corners;
        let corners = [V3::load(l, &p.0), V3::load(l, &q.0), V3::load(l, &r.0)];
        let (c, inner) = (V3::load(l, &self.centres.0), l.load(self.radii));
        let (size, slack) = (l.add(l.splat(1.0), c.norm1(l)), l.splat(0.0));
        let found = Enclosed { corners, c, inner, size, slack }.nearest_face(l);
        let mut lower = Row::default();
        l.store(l.select(found.holds, found.lower, l.splat(f32::NAN)), &mut lower);
        lower
    }
}

/// How far the hull of three points and a sphere reaches along the direction in which it reaches the least, or a little farther.
fn least_reach(corners: [DVec3; 3], (c, radius): (DVec3, f64), draw: &mut Draw) -> f64 {
    let reach = |n: DVec3| (c.dot(n) + radius).max(reach(&corners, n));
    let mut least = (f64::INFINITY, DVec3::Z);
    for round in 0..400 {
        let (from, step) =
            if round < 100 { (DVec3::ZERO, 1.0) } else { (least.1, 0.97f64.powi(round - 100)) };
        for _ in 0..8 {
            let Some(n) = (from + draw.vector() * step).try_normalize() else { continue };
            if reach(n) < least.0 {
                least = (reach(n), n);
            }
        }
    }
    least.0
}

#[test]
fn no_bound_from_below_is_above_the_least_reach_of_triangle_and_sphere() {
    let mut draw = Draw(9);
    let (mut held, mut close) = (0, 0);
    for _ in 0..60 {
        let mut blocks = [Block::default(); 4];
        let mut radii = Row::default();
        for lane in 0..WIDTH {
            let depth = 0.2 * draw.number().abs();
            let mut set = |block: usize, v: DVec3| {
                let numbers = v.as_vec3().to_array();
                blocks[block].0.iter_mut().zip(numbers).for_each(|(row, x)| row.0[lane] = x);
            };
            for corner in 0..3 {
                let (sine, cosine) = (f64::from(corner as u32) * 2.1).sin_cos();
                let far = 0.4 * draw.number().abs();
                let at = DVec3::new(cosine * far, sine * far, depth) + draw.vector() * 0.05;
                set(corner, at);
            }
            set(3, draw.vector() * 0.1 - DVec3::Z * 0.3);
            radii.0[lane] = (0.3 * draw.number().abs()) as f32;
        }
        let [p, q, r, centres] = &blocks;
        let kernel = Lower { corners: &[*p, *q, *r], centres, radii: &radii };
        let lower = dispatch_on(Path::best(), Unfused(kernel));
        for lane in (0..WIDTH).filter(|&lane| !lower.0[lane].is_nan()) {
            let [p, q, r, c] = blocks.map(|block| block.point(lane).as_dvec3());
            let least = least_reach([p, q, r], (c, radii.0[lane].into()), &mut draw);
            assert!(f64::from(lower.0[lane]) <= least, "{lane}: {} {least}", lower.0[lane]);
            held += 1;
            close += usize::from(f64::from(lower.0[lane]) > least - 1e-4);
        }
    }
    println!("{held} held, {close} close");
    assert!(held > 200 && close > 100, "{held}, {close}");
}
