//! A surface that grows point by point.

use super::*;
use crate::motion::tests::Draw;
use dcd_simd::{Kernel, Path, dispatch_on};

/// Starts with a tetrahedron round the origin and adds points beyond its nearest face; what comes nearest then, by what
/// the insertion says and by all faces, as long as it is not refused.
struct Grow<'a>(&'a [Vec3]);

impl Kernel for Grow<'_> {
    type Output = Vec<[usize; 3]>;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Vec<[usize; 3]> {
        let mut surface = Surface::default();
        let at = |x: f32, y: f32, z: f32| Point { at: Vec3::new(x, y, z), numbers: [0; 2] };
        let corners =
            [at(1.0, 0.0, -0.5), at(-0.7, 0.8, -0.5), at(-0.6, -0.9, -0.5), at(0.0, 0.0, 1.0)];
        assert!(surface.start(l, corners).is_some());
        let mut found = Vec::new();
        for &direction in self.0 {
            let seen = surface.nearest(l);
            let beyond = surface.normal(seen) * (surface.distance(seen) + 0.5) + direction * 0.1;
            let point = Point { at: beyond, numbers: [0; 2] };
            let Some(nearest) = surface.insert(l, point, 1e-6) else { break };
            assert!(is_closed(&surface));
            let alive = (0..surface.faces).filter(|&face| surface.distance(face).is_finite());
            let plain = alive.fold(0, |least, face| {
                let is_nearer = surface.distance(face) < surface.distance(least);
                if is_nearer || !surface.distance(least).is_finite() { face } else { least }
            });
            found.push([nearest, surface.nearest(l), plain]);
        }
        found
    }
}

/// Whether every edge of a face runs once, and once the other way.
fn is_closed(surface: &Surface) -> bool {
    let alive = (0..surface.faces).filter(|&face| surface.distance(face).is_finite());
    let edges: Vec<[usize; 2]> =
        alive.flat_map(|face| edges_of(numbers(surface.corners[face]))).collect();
    let count = |edge: [usize; 2]| edges.iter().filter(|&&other| other == edge).count();
    !edges.is_empty() && edges.iter().all(|&[p, q]| count([p, q]) == 1 && count([q, p]) == 1)
}

fn edges_of([p, q, r]: [usize; 3]) -> [[usize; 2]; 3] {
    [[p, q], [q, r], [r, p]]
}

#[test]
fn the_horizon_of_any_faces_of_an_octahedron_is_what_has_no_edge_against_it() {
    const APEX: usize = 6;
    let mut in_rings = 0;
    for gone in 1..1u64 << OCTAHEDRON.len() {
        let mut surface = Surface::default();
        surface.corners[..OCTAHEDRON.len()].copy_from_slice(&OCTAHEDRON);
        surface.faces = OCTAHEDRON.len();
        let edges: Vec<[usize; 2]> =
            Bits(gone).flat_map(|face| edges_of(numbers(OCTAHEDRON[face]))).collect();
        let outer = edges.iter().filter(|&&[p, q]| !edges.contains(&[q, p]));
        let mut outer: Vec<[usize; 3]> = outer.map(|&[p, q]| [p, q, APEX]).collect();
        outer.sort_unstable();
        let is_simple = outer.windows(2).all(|two| two[0][0] != two[1][0]);
        let found = surface.find_horizon(gone, APEX);
        assert_eq!(found, (is_simple && !outer.is_empty()).then_some(outer.len()), "{gone:b}");
        if let Some(edges) = found {
            let written = &surface.corners[surface.faces..][..edges];
            let mut written: Vec<[usize; 3]> = written.iter().map(|&face| numbers(face)).collect();
            written.sort_unstable();
            assert_eq!(written, outer, "{gone:b}");
            in_rings += 1;
        }
    }
    assert!(in_rings > 50 && in_rings < 255, "{in_rings}");
}

#[test]
fn an_insertion_names_the_face_that_is_the_nearest_of_all_then() {
    let mut draw = Draw(5);
    let (mut insertions, mut many) = (0, 0);
    for _ in 0..100 {
        let directions: Vec<Vec3> = (0..24).map(|_| draw.vector().as_vec3()).collect();
        let mut of_paths = Vec::new();
        for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
            let found = dispatch_on(path, Grow(&directions));
            for [told, all, plain] in &found {
                assert_eq!((told, all), (plain, plain), "{path:?}");
            }
            of_paths.push(found);
        }
        assert!(of_paths.iter().all(|found| *found == of_paths[0]));
        insertions += of_paths[0].len();
        many += usize::from(of_paths[0].len() > 8);
    }
    assert!(insertions > 800 && many > 30, "{insertions} {many}");
}
