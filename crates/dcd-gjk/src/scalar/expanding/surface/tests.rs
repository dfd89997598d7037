use super::*;
use crate::motion::tests::Draw;
use dcd_geom::Support;
use std::collections::BTreeSet;

fn vertex(w: DVec3, feature: u32) -> Vertex<f64> {
    let support = Support { point: w, feature };
    Vertex { w, a: support, b: support }
}

/// A tetrahedron round the origin.
fn tetrahedron(draw: &mut Draw) -> Surface {
    let at = |w: DVec3| vertex(w * 0.01 + draw.vector() * 1e-3, 0);
    let corners = [DVec3::ONE, DVec3::new(1.0, -1.0, -1.0), DVec3::new(-1.0, 1.0, -1.0)];
    let [p, q, r] = corners.map(at);
    let mut surface = Surface::default();
    surface.start([p, q, r, vertex(-(p.w + q.w + r.w), 0)]).unwrap();
    surface
}

/// The places of the faces that it has.
fn alive(surface: &Surface) -> Vec<usize> {
    (0..surface.faces.len()).filter(|&k| surface.distances[k] < GONE).collect()
}

/// Every edge is one of two faces, which know each other; and no place is lost.
fn is_closed(surface: &Surface) {
    let alive = alive(surface);
    let mut corners = BTreeSet::new();
    for &k in &alive {
        let Face { vertices, neighbours, .. } = surface.faces[k];
        corners.extend(vertices);
        for (j, other) in neighbours.into_iter().enumerate() {
            assert!(surface.distances[other as usize] < GONE, "{k}: its neighbour is gone");
            let across = surface.faces[other as usize];
            let edge = (vertices[(j + 1) % 3], vertices[j]);
            let back = (0..3).find(|&i| (across.vertices[i], across.vertices[(i + 1) % 3]) == edge);
            assert_eq!(across.neighbours[back.unwrap()] as usize, k);
        }
    }
    assert_eq!(alive.len(), 2 * corners.len() - 4);
    assert_eq!(alive.len() + surface.gone.len(), surface.faces.len());
}

#[test]
fn a_surface_stays_closed_and_knows_its_nearest_face_also_where_it_swallows_vertices() {
    let mut draw = Draw(3);
    let (mut swallowed, mut largest) = (0, 0);
    for round in 0..200 {
        let mut surface = tetrahedron(&mut draw);
        // Far beside the last one a point sees most faces, else a few.
        let growth = [1.01, 1.1, 1.5][round % 3];
        let mut far = 0.02;
        for k in 0..30 {
            far *= growth;
            let new = vertex(draw.vector().normalize() * far, k + 1);
            let sees =
                |&k: &usize| surface.faces[k].normal.dot(new.w) > surface.distances[k] + 1e-9;
            let Some(seen) = alive(&surface).into_iter().find(sees) else { continue };
            surface.insert(new, seen as u32).unwrap();
            is_closed(&surface);
            let least =
                |&j: &usize, &k: &usize| surface.distances[j].total_cmp(&surface.distances[k]);
            let nearest = alive(&surface).into_iter().min_by(least);
            assert_eq!(Some(surface.nearest() as usize), nearest);
            swallowed += usize::from(!surface.gone.is_empty());
            largest = largest.max(surface.faces.len());
        }
    }
    assert!(swallowed > 100 && largest > 40, "{swallowed} {largest}");
}

#[test]
fn a_ray_leaves_by_the_face_that_it_passes_through() {
    let mut draw = Draw(5);
    for _ in 0..200 {
        let mut surface = tetrahedron(&mut draw);
        for k in 0..20 {
            let new = vertex(draw.vector().normalize() * (0.1 + 0.01 * f64::from(k)), k + 1);
            let sees =
                |&k: &usize| surface.faces[k].normal.dot(new.w) > surface.distances[k] + 1e-9;
            let Some(seen) = alive(&surface).into_iter().find(sees) else { continue };
            surface.insert(new, seen as u32).unwrap();
        }
        assert!(surface.inner_radius() > 0.0);
        let nearest = surface.plane(surface.nearest()).0;
        for direction in [nearest, draw.vector(), draw.vector(), draw.vector()] {
            let (corners, weights) = surface.leaving(direction);
            let is_a_face = alive(&surface).iter().any(|&k| surface.faces[k].vertices == corners);
            assert!(is_a_face && weights.iter().all(|&weight| weight >= 0.0), "{weights:?}");
            let at: DVec3 =
                (0..3).map(|k| surface.vertices[corners[k] as usize].w * weights[k]).sum();
            let beside = at.reject_from(direction).length();
            assert!(at.dot(direction) > 0.0 && beside < 1e-12, "{direction}: {beside}");
        }
    }
}
