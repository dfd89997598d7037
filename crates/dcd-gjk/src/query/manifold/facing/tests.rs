use super::*;

#[test]
fn a_triangle_shows_what_its_list_of_faces_has() {
    let mut state = 3u64;
    let mut draw = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    let mut vector = || DVec3::new(draw(), draw(), draw());
    let (mut edges, mut vertices) = (0, 0);
    for round in 0..2000 {
        let corners = [vector(), vector(), vector()];
        let polytope = Polytope::mesh_triangle(corners).unwrap();
        let along = (corners[1] - corners[0]).normalize();
        let direction = match round % 3 {
            0 => vector(),
            1 => along.cross(vector()) + along * 0.2 * vector(),
            _ => along.cross(vector()),
        };
        let choice = Choice { polytope: &polytope, direction: direction.normalize() };
        let (found, due) = (choice.part(), choice.searched());
        assert_eq!(name(&polytope, choice.direction), due.name(), "{round}");
        match (found, due) {
            (Part::Vertex(found), Part::Vertex(due)) => {
                assert_eq!(found, due, "{round}");
                vertices += 1;
            }
            (Part::Edge(found), Part::Edge(due)) => {
                assert_eq!(found, due, "{round}");
                edges += 1;
            }
            (Part::Face { index: found, .. }, Part::Face { index: due, .. }) => {
                assert_eq!(found, due, "{round}");
            }
            _ => panic!("{round}: {corners:?} {direction}"),
        }
    }
    assert!(edges > 300 && vertices > 300, "{edges} {vertices}");
}

#[test]
fn segments_and_boxes_show_what_their_lists_of_faces_have() {
    let mut draw = super::super::cuboid_faces::tests::Draw(5);
    let mut vector = || DVec3::from_array([(); 3].map(|()| 2.0 * draw.unit() - 1.0));
    let mut counts = [0; 3];
    for round in 0..3000 {
        let (p, q) = (vector(), vector());
        let polytope = match round % 2 {
            0 => Polytope::segment(p, q).unwrap(),
            _ => Polytope::cuboid(p.abs() + 0.01).unwrap(),
        };
        let level = (q - p).cross(vector()).normalize() + 0.3 * vector();
        let steep = vector();
        let direction = if round % 4 < 2 { level } else { steep }.normalize();
        let choice = Choice { polytope: &polytope, direction };
        let (found, due) = (choice.part().name(), choice.searched().name());
        assert_eq!(found, due, "{round}: {p} {q} {direction}");
        assert_eq!(name(&polytope, direction), due, "{round}");
        counts[match due {
            Feature::Vertex(_) => 0,
            Feature::Edge(..) => 1,
            _ => 2,
        }] += 1;
    }
    assert!(counts.iter().all(|&count| count > 50), "{counts:?}");
}

#[test]
fn a_hull_shows_round_an_edge_or_a_face_what_all_its_farthest_vertices_have() {
    let mut draw = super::super::cuboid_faces::tests::Draw(7);
    let mut number = || 2.0 * draw.unit() - 1.0;
    let (mut counts, mut level) = ([0; 2], 0);
    for round in 0..300 {
        // Flat ones among them, whose faces look almost alike; every other one with faces of many corners.
        let thin = [1.0, 0.05][round / 2 % 2];
        let points = (0..8 + round % 30).map(|_| {
            let point = DVec3::new(number(), number(), number());
            DVec3::new(point.x, point.y, thin * point.z) * if round % 2 == 0 { 1.0 } else { 2.0 }
        });
        let points: Vec<_> = match round % 2 {
            0 => points.collect(),
            _ => points.map(|point| point.round()).collect(),
        };
        let Ok(polytope) = Polytope::hull(points) else { continue };
        let facets = polytope.facets();
        let due = |direction: DVec3| {
            let choice = Choice { polytope: &polytope, direction };
            let along = polytope.vertices().iter().map(|vertex| direction.dot(*vertex));
            let farthest = along.fold(f64::NEG_INFINITY, f64::max);
            let least = farthest - FARTHEST * polytope.outer_radius();
            (choice.searched().name(), choice.round_vertices(&[], least).name())
        };
        for facet in facets.facets() {
            for tilt in [0.0, 1e-9, 1e-5] {
                let tilted = facet.normal + DVec3::new(number(), number(), number()) * tilt;
                let (found, due) = due(tilted.normalize_or(DVec3::X));
                assert_eq!(found, due, "{round}: {facet:?} {tilt}");
                level += 1;
            }
        }
        for j in 0..polytope.vertices().len() as u32 {
            for half_edge in facets.half_edges_from(j) {
                let k = half_edge.to;
                let back = facets.half_edges_from(k).iter().find(|back| back.to == j).unwrap();
                let share = 0.5 + 0.5 * number();
                let direction = half_edge.normal.lerp(back.normal, share).normalize_or(DVec3::X);
                let (found, due) = due(direction);
                assert_eq!(found, due, "{round}: {j} {k} {direction}");
                match due {
                    Feature::Edge(..) => counts[0] += 1,
                    Feature::Face(_) => counts[1] += 1,
                    _ => {}
                }
            }
        }
    }
    assert!(counts.iter().all(|&count| count > 1000) && level > 1000, "{counts:?} {level}");
}

/// A roof whose ridge is all that is highest, and whose gables alone look up: both as much.
#[test]
fn of_two_faces_beyond_the_ends_of_an_edge_that_look_alike_the_first_is_shown() {
    let roof = [
        [-1.0, 0.0, 1.0],
        [1.0, 0.0, 1.0],
        [-10.0, -1.0, 0.0],
        [-10.0, 1.0, 0.0],
        [10.0, -1.0, 0.0],
        [10.0, 1.0, 0.0],
    ];
    let mut firsts = [0; 2];
    // The numbers of the vertices decide that of the faces.
    for turn in 0..6 {
        for back in [false, true] {
            let mut points = roof.map(DVec3::from_array).to_vec();
            points.rotate_left(turn);
            if back {
                points.reverse();
            }
            let polytope = Polytope::hull(points).unwrap();
            let ends: Vec<u32> =
                (0..6).filter(|&k| polytope.vertices()[k as usize].z == 1.0).collect();
            let choice = Choice { polytope: &polytope, direction: DVec3::Z };
            let gable = |end: u32| {
                let around = polytope.facets().half_edges_from(end).iter();
                around.copied().find(|half_edge| half_edge.normal.z > FACING).unwrap()
            };
            let gables = [gable(ends[0]), gable(ends[1])];
            assert_eq!(gables[0].normal.z, gables[1].normal.z);
            let due = gables[0].face.min(gables[1].face);
            assert_eq!(choice.searched().name(), Feature::Face(due), "{turn} {back}");
            assert_eq!(choice.round_vertices(&[], 1.0).name(), Feature::Face(due), "{turn} {back}");
            firsts[usize::from(due == gables[1].face)] += 1;
        }
    }
    assert!(firsts.iter().all(|&count| count > 0), "{firsts:?}");
}

/// Of a vertex that comes twice, a hair off, one is no corner: what is between the two is no edge.
#[test]
fn a_vertex_and_a_point_beside_it_are_no_edge() {
    let mut beside = 0;
    for hair in [1e-10, 1e-12, 1e-14] {
        for offset in [DVec3::X, DVec3::Y, DVec3::new(-1.0, 0.5, 0.0)] {
            for is_last in [false, true] {
                let base = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
                let mut points = base.map(DVec3::from_array).to_vec();
                let (apex, other) = (DVec3::Z, DVec3::Z + offset * hair);
                points.extend(if is_last { [apex, other] } else { [other, apex] });
                let polytope = Polytope::hull(points).unwrap();
                let edges = |k: u32| polytope.facets().half_edges_from(k);
                let is_edge = edges(4).iter().any(|half_edge| half_edge.to == 5);
                println!(
                    "{hair} {offset} {is_last}: {} {} {is_edge}",
                    edges(4).len(),
                    edges(5).len()
                );
                let choice = Choice { polytope: &polytope, direction: DVec3::Z };
                let least = 1.0 - FARTHEST * polytope.outer_radius();
                let due = choice.round_vertices(&[], least).name();
                assert_eq!(choice.searched().name(), due, "{hair} {offset} {is_last}");
                beside += usize::from(!is_edge);
            }
        }
    }
    assert!(beside > 0);
}
