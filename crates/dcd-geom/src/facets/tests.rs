//! Faces of shapes that are known, and of points that make it hard.

use super::*;
use crate::{Polytope, Sphere};

/// That the rings are closed and convex, and hold every vertex.
fn validate(vertices: &[DVec3]) -> Facets {
    let facets = Facets::of(vertices);
    let extent = vertices.iter().fold(0.0f64, |most, v| most.max(v.distance(vertices[0])));
    let mut edges = Vec::new();
    for facet in facets.facets() {
        let corners = facets.corners(facet);
        assert!(corners.len() >= 3 && (facet.normal.length() - 1.0).abs() < 1e-12, "{vertices:?}");
        let base = vertices[corners[0] as usize];
        for &v in vertices {
            assert!((v - base).dot(facet.normal) <= 10.0 * FLATNESS * extent, "{vertices:?}");
        }
        for (k, &from) in corners.iter().enumerate() {
            edges.push((from, corners[(k + 1) % corners.len()]));
        }
    }
    for vertex in 0..vertices.len() as u32 {
        let mut around = Vec::new();
        for (face, facet) in (0..).zip(facets.facets()) {
            let corners = facets.corners(facet);
            if let Some(k) = corners.iter().position(|&corner| corner == vertex) {
                let normal = if corners.len() < 3 { DVec3::ZERO } else { facet.normal };
                let to = corners[(k + 1) % corners.len()];
                let Facet { first, count, .. } = *facet;
                around.push(HalfEdge { normal, face, to, first, count });
            }
        }
        assert_eq!(facets.half_edges_from(vertex), around, "{vertices:?}");
        for half_edge in facets.half_edges_from(vertex) {
            let facet = &facets.facets()[half_edge.face as usize];
            assert_eq!(facets.face_corners(half_edge), facets.corners(facet), "{vertices:?}");
        }
    }
    let mut backwards: Vec<_> = edges.iter().map(|&(from, to)| (to, from)).collect();
    edges.sort_unstable();
    backwards.sort_unstable();
    assert_eq!(edges, backwards, "an edge belongs to two faces: {vertices:?}");
    facets
}

fn corner_counts(facets: &Facets) -> Vec<usize> {
    let mut counts: Vec<_> = facets.facets().iter().map(|f| facets.corners(f).len()).collect();
    counts.sort_unstable();
    counts
}

/// A multiplicative generator: enough for places.
fn draw(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(0xd134_2543_de82_ef95).wrapping_add(1);
    (*state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

#[test]
fn a_cube_has_six_faces_of_four_corners_turned_and_far_away_too() {
    let cube = Polytope::cuboid(DVec3::new(1.0, 2.0, 3.0)).unwrap();
    assert_eq!(corner_counts(&validate(cube.vertices())), [4; 6]);
    let turn = glam::DMat3::from_rotation_x(0.3) * glam::DMat3::from_rotation_z(1.1);
    for place in [DVec3::ZERO, DVec3::splat(1000.0)] {
        let turned: Vec<DVec3> = cube.vertices().iter().map(|&v| turn * v + place).collect();
        assert_eq!(corner_counts(&validate(&turned)), [4; 6]);
    }
    assert!(std::ptr::eq(cube.facets(), cube.facets()));
}

#[test]
fn a_prism_has_its_caps_whole() {
    let at = |k: u32, z: f64| {
        let angle = f64::from(k) * std::f64::consts::TAU / 12.0;
        DVec3::new(angle.cos(), angle.sin(), z)
    };
    let prism: Vec<DVec3> = (0..12).flat_map(|k| [at(k, -1.0), at(k, 1.0)]).collect();
    let facets = validate(&prism);
    assert_eq!(corner_counts(&facets), [[4; 12].to_vec(), vec![12; 2]].concat());
}

#[test]
fn points_inside_faces_and_edges_are_no_corners() {
    let steps = || (-1..=1).map(f64::from);
    let grid: Vec<DVec3> = steps()
        .flat_map(|x| steps().flat_map(move |y| steps().map(move |z| DVec3::new(x, y, z))))
        .collect();
    let twice = [grid.clone(), grid].concat();
    assert_eq!(corner_counts(&validate(&twice)), [4; 6]);
}

#[test]
fn any_points_have_a_closed_surface() {
    let mut state = 9;
    for k in 0..200 {
        let scale = 10f64.powi(k % 21 - 10);
        let flat = DVec3::new(1.0, 1.0, if k % 3 == 0 { 1e-4 } else { 1.0 });
        let count = 4 + k as usize % 60;
        let mut vector = || DVec3::new(draw(&mut state), draw(&mut state), draw(&mut state));
        let points: Vec<DVec3> = (0..count).map(|_| vector() * flat * scale).collect();
        validate(&points);
        // Few coordinates: most points are coplanar or collinear with others.
        let lattice: Vec<DVec3> = (0..count).map(|_| (vector() * 2.0).round() * scale).collect();
        if Sphere::inside(&lattice).radius > 1e-3 * scale {
            validate(&lattice);
        }
    }
}

#[test]
fn flat_straight_and_single_points_have_their_sides_ends_and_selves() {
    let square: Vec<DVec3> =
        Polytope::cuboid(DVec3::new(1.0, 1.0, 0.0)).unwrap().vertices().to_vec();
    let facets = Facets::of(&square);
    assert_eq!(corner_counts(&facets), [4, 4]);
    assert_eq!(facets.facets()[0].normal, -facets.facets()[1].normal);
    let line: Vec<DVec3> = [0.0, 3.0, 1.0, -2.0].map(|x| DVec3::new(x, 2.0 * x, 1.0)).to_vec();
    let facets = Facets::of(&line);
    let mut ends = facets.corners(&facets.facets()[0]).to_vec();
    ends.sort_unstable();
    assert_eq!((ends, facets.facets()[0].normal), (vec![1, 3], DVec3::ZERO));
    let facets = Facets::of(&[DVec3::ONE; 3]);
    assert_eq!(facets.corners(&facets.facets()[0]).len(), 1);
    assert_eq!(Facets::of(&[DVec3::splat(f64::MAX), DVec3::splat(f64::MIN)]).facets().len(), 1);
}

#[test]
fn triangles_and_polygons_list_their_faces_round_each_corner_as_a_search_does() {
    let corners = [DVec3::ZERO, DVec3::X, DVec3::new(0.25, 1.0, 0.0)];
    let quad = vec![DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
    let polygon = |corners: &[DVec3]| Polytope::polygon(corners.to_vec(), DVec3::Z).unwrap();
    let known = [
        Polytope::mesh_triangle(corners).unwrap(),
        polygon(&quad),
        polygon(&quad[..2]),
        polygon(&quad[..1]),
    ];
    let normal = known[0].normal_of_triangle();
    assert_eq!(normal, Some(known[0].facets().facets()[0].normal));
    assert_eq!(known[0].facets().corners(&known[0].facets().facets()[1]), [2, 1, 0]);
    for polytope in known {
        let (facets, searched) = (polytope.facets(), Facets::of(polytope.vertices()));
        assert_eq!(facets.facets().len(), searched.facets().len());
        for vertex in 0..polytope.vertices().len() as u32 {
            // Which side comes first is the search's choice.
            let names = |facets: &Facets| {
                let around = facets.half_edges_from(vertex);
                let mut ends: Vec<_> = around.iter().map(|half_edge| half_edge.to).collect();
                ends.sort_unstable();
                (around.iter().map(|half_edge| half_edge.face).collect::<Vec<_>>(), ends)
            };
            assert_eq!(names(facets), names(&searched), "vertex {vertex}");
        }
    }
}

#[test]
fn a_thin_plate_keeps_its_sides() {
    for thickness in [1e-2, 1e-4, 8e-6, 1e-6] {
        let corner = |k: u32| {
            let side = |bit: u32| if k >> bit & 1 == 0 { -0.5 } else { 0.5 };
            DVec3::new(side(0), side(1), side(2) * thickness)
        };
        let plate = Polytope::hull((0..8).map(corner).collect()).unwrap();
        let contact = plate.contact_facets();
        assert_eq!(corner_counts(contact), [4; 6], "{thickness}");
        assert_eq!(contact.unevenness(), 0.0, "{thickness}");
    }
}
