//! Proved faces beside the least of all directions that a face of A − B can have, in f64.

use super::super::proposed::tests::{proposed, scene, vertices};
use crate::motion::tests::Draw;
use dcd_geom::Pair;
use dcd_geom::glam::DVec3;
use dcd_simd::Path;

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
