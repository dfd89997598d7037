use super::*;
use crate::certificate::Bounds;
use crate::distance::approach;
use crate::exact;
use crate::motion::tests::Draw;
use crate::{Difference, Vertex};
use dcd_geom::glam::DQuat;
use dcd_geom::{Pose, Support};

/// Two hulls, every other rounded, that are apart by a gap of about that many metres at the most.
fn pair(draw: &mut Draw, k: usize, gap: f64) -> [(Polytope, Pose); 2] {
    let far = [DVec3::ZERO, DVec3::new(1e3, -2e3, 5e2)][k % 2];
    let radius = [0.0, 0.05][k / 2 % 2];
    let mut shape = |count: usize| {
        let points = (0..count).map(|_| draw.vector().normalize() * 0.5).collect();
        Polytope::hull(points).unwrap().rounded(radius).unwrap()
    };
    let (a, b) = (shape(1 + k % 20), shape(4 + k / 3 % 20));
    let mut turn = || DQuat::from_scaled_axis(draw.vector() * 3.0).normalize();
    let (at_a, turned) = (Pose::new(turn(), far).unwrap(), turn());
    let away = draw.vector().normalize();
    // From far away towards a, until they are so near or have passed each other.
    let mut apart = 1.5;
    for _ in 0..8 {
        let pose = Pose::new(turned, far + away * apart).unwrap();
        let (in_a, in_b) = (PosedSupport::polytope(&a, &at_a), PosedSupport::polytope(&b, &pose));
        match found(in_a, in_b, 0.0).and_then(|near| distance(in_a, in_b, &near)) {
            Some(found) if found.distance > gap => apart -= 0.9 * (found.distance - 0.5 * gap),
            _ => break,
        }
    }
    [(a, at_a), (b, Pose::new(turned, far + away * apart).unwrap())]
}

/// Where a search in f64 ends with bounds that are so near.
fn found(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
    gap: f64,
) -> Option<Approach> {
    let difference = Difference::new(a, b)?;
    let mut near = Approach::begin(&difference);
    approach(&difference, &Bounds::of(&difference), gap, &mut near).ok().map(|()| near)
}

/// Whether it is the distance of whole numbers, which is right to 2⁻⁴⁹ of itself.
fn is_exact(
    found: &Distance,
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
) -> bool {
    let exactly = exact::closest(a, b, &[]).map_or(0.0, |exactly| exactly.distance);
    (found.distance - exactly).abs() <= found.error_bound + exactly * 2f64.powi(-49)
}

#[test]
fn the_features_of_a_search_in_f64_give_the_distance_of_whole_numbers() {
    let mut draw = Draw(31);
    let mut count = 0;
    for k in 0..240 {
        let gap = [1.0, 1e-2, 1e-6][k % 3];
        let [(a, at_a), (b, at_b)] = pair(&mut draw, k, gap);
        let (a, b) = (PosedSupport::polytope(&a, &at_a), PosedSupport::polytope(&b, &at_b));
        let near = found(a, b, 0.0).unwrap();
        let Some(found) = distance(a, b, &near) else { continue };
        assert!(is_exact(&found, a, b), "{k} {found:?}");
        assert!(found.error_bound <= 1.1 * f64::EPSILON * found.distance, "{k} {found:?}");
        let off = found.point_b - found.point_a - found.normal * found.distance;
        let far = at_a.translation().length() + at_b.translation().length();
        assert!(off.length() <= 1e-14 * (1.0 + far), "{k} {off}");
        count += 1;
    }
    // The rest are nearly at the border of their features.
    assert!(count >= 225, "{count}");
}

#[test]
fn features_that_are_not_the_nearest_give_no_distance() {
    let mut draw = Draw(32);
    let mut refused = 0;
    for k in 0..240 {
        let [(a, at_a), (b, at_b)] = pair(&mut draw, k, 0.1);
        let (a, b) = (PosedSupport::polytope(&a, &at_a), PosedSupport::polytope(&b, &at_b));
        // A search that has ended too early, or another's weights.
        let mut near = found(a, b, [0.3, 0.1, 0.0][k % 3]).unwrap();
        if k % 3 == 2 {
            near.weights = [0.2, 0.3, 0.5, 0.0];
        }
        match distance(a, b, &near) {
            Some(found) => assert!(is_exact(&found, a, b), "{k} {found:?}"),
            None => refused += 1,
        }
    }
    assert!(refused > 40, "{refused}");
}

#[test]
fn a_face_of_four_corners_that_rounding_has_bent_is_measured_at_its_own() {
    let cube = Polytope::cuboid(DVec3::splat(0.5)).unwrap();
    let corner = Polytope::hull(vec![DVec3::ZERO, DVec3::splat(1.0), DVec3::new(1.0, 2.0, 0.5)]);
    let corner = corner.unwrap();
    let mut draw = Draw(33);
    for k in 0..60 {
        let turn = DQuat::from_scaled_axis(draw.vector()).normalize();
        let at_a = Pose::new(turn, draw.vector()).unwrap();
        // Over the middle of a face, and its tip down.
        let over = DVec3::new(0.3 * draw.number(), 0.3 * draw.number(), 0.6);
        let at_b = Pose::new(turn, at_a.apply(over)).unwrap();
        let (a, b) = (PosedSupport::polytope(&cube, &at_a), PosedSupport::polytope(&corner, &at_b));
        let near = found(a, b, 0.0).unwrap();
        if let Some(found) = distance(a, b, &near) {
            assert!(is_exact(&found, a, b), "{k} {found:?}");
        }
        let (found, _) = crate::distance::of_polytopes(a, b);
        let crate::DistanceResult::Apart(found) = found else { panic!("{k} {found:?}") };
        assert!(is_exact(&found, a, b), "{k} {found:?}");
    }
}

/// What the vertices of those numbers give, with those weights: the shapes are where their vertices are.
fn of_vertices(
    [a, b]: [&[DVec3]; 2],
    pairs: &[[u32; 2]],
    weights: [f64; 4],
) -> (Option<Distance>, f64) {
    let [a, b] = [a, b].map(|vertices| Polytope::hull(vertices.to_vec()).unwrap());
    let (a, b) =
        (PosedSupport::polytope(&a, &Pose::IDENTITY), PosedSupport::polytope(&b, &Pose::IDENTITY));
    let mut near = Approach::towards(DVec3::X);
    near.weights = weights;
    for &[k, l] in pairs {
        let support = |body: PosedSupport<'_, Polytope>, feature: u32| Support {
            point: body.map.vertices()[feature as usize],
            feature,
        };
        let (in_a, in_b) = (support(a, k), support(b, l));
        near.simplex.push(Vertex { w: in_a.point - in_b.point, a: in_a, b: in_b });
    }
    (distance(a, b, &near), exact::closest(a, b, &[]).unwrap().distance)
}

#[test]
fn a_point_beyond_the_end_of_an_edge_is_no_point_of_it() {
    let edge = [DVec3::ZERO, DVec3::X];
    let point = [DVec3::new(-0.5, 0.0, 1.0)];
    let (found, _) = of_vertices([&edge, &point], &[[0, 0], [1, 0]], [0.5, 0.5, 0.0, 0.0]);
    assert_eq!(found, None);
}

#[test]
fn an_edge_of_the_difference_that_is_level_though_those_of_its_shapes_are_not_is_refused() {
    let edge = [DVec3::ZERO, DVec3::X];
    let other = [DVec3::new(0.003, -0.05, 1.0), DVec3::new(1.003, 0.05, 1.0)];
    let (found, exactly) = of_vertices([&edge, &other], &[[0, 0], [1, 1]], [0.5, 0.5, 0.0, 0.0]);
    assert_eq!((found, exactly), (None, 1.0));
}

#[test]
fn a_sliver_whose_second_edge_is_not_corrected_is_refused() {
    let over = [DVec3::new(0.4, 0.0, 1.0)];
    for tip in [1e-4, -1e-4] {
        let sliver = [DVec3::ZERO, DVec3::X, DVec3::new(0.5, tip, 0.1 * tip)];
        for first in 0..3 {
            let pairs = [first, (first + 1) % 3, (first + 2) % 3].map(|k| [k, 0]);
            let weights = [0.3, 0.4, 0.3, 0.0];
            let (found, exactly) = of_vertices([&sliver, &over], &pairs, weights);
            let is_right = |found: &Distance| (found.distance - exactly).abs() <= 1e-15;
            assert!(found.as_ref().is_none_or(is_right), "{tip} {first} {found:?} {exactly}");
        }
    }
}
