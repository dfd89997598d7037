//! Proved faces beside the least of all directions that a face of A − B can have, in f64.

use super::super::proposed::tests::{proposed, scene, vertices};
use super::*;
use crate::motion::tests::Draw;
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

/// Sixteen triangles and spheres.
struct Triangles<'a> {
    corners: &'a [Block; 3],
    centres: &'a Block,
    radii: &'a Row,
}

/// The bounds from below where the triangles are the nearest, else NaN; how far from the triangle's points are the feet of the origin.
struct Proved {
    lower: Row,
    aside: Row,
}

impl Kernel for Triangles<'_> {
    type Output = Proved;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Proved {
        let [p, q, r] = self.corners;
        let corners = [V3::load(l, &p.0), V3::load(l, &q.0), V3::load(l, &r.0)];
        let (c, inner) = (V3::load(l, &self.centres.0), l.load(self.radii));
        let (size, slack) = (l.add(l.splat(1.0), c.norm1(l)), l.splat(0.0));
        let found = Enclosed { corners, c, inner, size, slack }.nearest_face(l);
        let [p, q, r] = corners;
        let [second, third] = found.weights;
        let point = p.plus(l, second, q.sub(l, p)).plus(l, third, r.sub(l, p));
        let between = point.sub(l, scaled(l, found.normal, found.distance));
        let [mut lower, mut aside] = [Row::default(); 2];
        l.store(l.select(found.holds, found.lower, l.splat(f32::NAN)), &mut lower);
        l.store(l.sqrt(between.dot(l, between)), &mut aside);
        Proved { lower, aside }
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

/// Sixteen of them above and below the origin, all of whose heights are that much less.
fn draw_triangles(draw: &mut Draw, flat: f64) -> ([Block; 3], Block, Row) {
    let mut blocks = [Block::default(); 4];
    let mut radii = Row::default();
    for lane in 0..WIDTH {
        let depth = 0.2 * draw.number().abs();
        let mut set = |block: usize, v: DVec3| {
            let numbers = (v * DVec3::new(1.0, 1.0, flat)).as_vec3().to_array();
            blocks[block].0.iter_mut().zip(numbers).for_each(|(row, x)| row.0[lane] = x);
        };
        for corner in 0..3 {
            let (sine, cosine) = (f64::from(corner as u32) * 2.1).sin_cos();
            let far = 0.4 * draw.number().abs();
            let at = DVec3::new(cosine * far, sine * far, depth) + draw.vector() * 0.05;
            set(corner, at);
        }
        set(3, draw.vector() * 0.1 - DVec3::Z * 0.3);
        radii.0[lane] = (0.3 * flat * draw.number().abs()) as f32;
    }
    let [p, q, r, centres] = blocks;
    ([p, q, r], centres, radii)
}

#[test]
fn no_bound_from_below_is_above_the_least_reach_of_triangle_and_sphere() {
    let mut draw = Draw(9);
    let (mut held, mut close) = (0, 0);
    for _ in 0..60 {
        let (corners, centres, radii) = draw_triangles(&mut draw, 1.0);
        let kernel = Triangles { corners: &corners, centres: &centres, radii: &radii };
        let Proved { lower, .. } = dispatch_on(Path::best(), Unfused(kernel));
        for lane in (0..WIDTH).filter(|&lane| !lower.0[lane].is_nan()) {
            let [p, q, r] = corners.map(|block| block.point(lane).as_dvec3());
            let sphere = (centres.point(lane).as_dvec3(), radii.0[lane].into());
            let least = least_reach([p, q, r], sphere, &mut draw);
            assert!(f64::from(lower.0[lane]) <= least, "{lane}: {} {least}", lower.0[lane]);
            held += 1;
            close += usize::from(f64::from(lower.0[lane]) > least - 1e-4);
        }
    }
    println!("{held} held, {close} close");
    assert!(held > 200 && close > 100, "{held}, {close}");
}

#[test]
fn the_foot_of_the_origin_is_in_what_counts_as_the_nearest_though_all_is_nearly_flat() {
    let mut draw = Draw(13);
    let mut held = 0;
    for _ in 0..4000 {
        let (corners, centres, radii) = draw_triangles(&mut draw, 4e-5);
        let kernel = Triangles { corners: &corners, centres: &centres, radii: &radii };
        let Proved { lower, aside } = dispatch_on(Path::best(), Unfused(kernel));
        for lane in (0..WIDTH).filter(|&lane| !lower.0[lane].is_nan()) {
            assert!(aside.0[lane] < 2e-6, "{lane}: {}", aside.0[lane]);
            held += 1;
        }
    }
    println!("{held} held");
    assert!(held > 200, "{held}");
}
