//! What the lanes find of cuboids beside the general search in f64 and longer numbers.

use super::super::frame::{FramePair, SimdFrame};
use super::super::prepare;
use super::depths;
use super::nearest_features::{self, Found};
use super::patches;
use crate::closed::{Axes, cuboid_depth, cuboid_depth_along};
use crate::distance::distance;
use crate::query::{Feature, Manifold, ManifoldContacts, Manifolds, MeasureAt, MeasureDepth};
use crate::simd::Purpose;
use crate::{
    Accuracy, ContactList, Depths, DistanceResult, PosedShape, PosedSupport, Sides, Verdict,
};
use dcd_geom::glam::{DQuat, DVec3};
use dcd_geom::{Aabb, Kind, Pair, Pose, Scene, Shape};
use dcd_simd::Path;

/// Repeatable numbers (splitmix64).
struct Draw(u64);

impl Draw {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ z >> 31) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn vector(&mut self) -> DVec3 {
        DVec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0
    }

    fn turn(&mut self) -> DQuat {
        DQuat::from_vec4(self.vector().extend(self.unit() * 2.0 - 1.0)).normalize()
    }
}

/// Pairs 2k, 2k + 1: turned any way, alike, by quarters, or nearly so; some flat, some thin, near the origin and far.
fn pairs_of_cuboids(seed: u64, count: usize, scale: f64) -> Scene {
    let mut draw = Draw(seed);
    let (mut shapes, mut poses) = (Vec::new(), Vec::new());
    for k in 0..count {
        let far = if k % 11 == 0 { draw.vector() * 1e3 } else { draw.vector() };
        let turn = if k % 5 == 0 { DQuat::IDENTITY } else { draw.turn() };
        let tilt = [0.0, 1e-9, 1e-6, 1e-3][k / 8 % 4];
        let own = [
            turn,
            turn * DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2),
            turn * DQuat::from_scaled_axis(draw.vector() * tilt),
        ];
        let other = if k % 8 < 3 { own[k % 8] } else { draw.turn() };
        let offset = draw.vector().normalize() * (0.4 + 1.4 * draw.unit());
        for (turn, place) in [(turn, far), (other, far + offset)] {
            let mut half = draw.vector().abs() * 0.5 + 0.1;
            half[k % 3] *= [1.0, 1.0, 1.0, 1e-3, 0.0][k / 3 % 5];
            shapes.push(Shape::cuboid(half * scale).unwrap());
            poses.push(Pose::new(turn, place * scale).unwrap());
        }
    }
    Scene::one_each(shapes, poses).unwrap()
}

fn prepared(scene: &Scene) -> SimdFrame {
    let mut frame = SimdFrame::default();
    let mut aabbs = vec![Aabb::default(); scene.len()];
    let part = frame.layout(scene, Sides::One, Purpose::Measure);
    let objects = prepare::Prepare { scene, first: 0, part, aabbs: &mut aabbs };
    prepare::prepare(Path::best(), objects);
    frame
}

#[test]
fn the_distance_at_the_features_that_the_lanes_find_is_that_of_the_search() {
    let mut missed = [0; 3];
    let mut count = 0;
    for (seed, scale) in [(1, 1.0), (2, 1e-4), (3, 1e4)] {
        let scene = pairs_of_cuboids(seed, 4000, scale);
        let frame = prepared(&scene);
        let frames = FramePair::of_one(&frame);
        let posed = |pair: Pair| [pair.i, pair.j].map(|k| PosedShape::of(&scene, k));
        let truth = |pair: Pair| match distance(posed(pair)[0], posed(pair)[1]).0 {
            DistanceResult::Apart(found) => Some(found),
            _ => None,
        };
        let all = (0..scene.len() as u32 / 2).map(|k| Pair::new(2 * k, 2 * k + 1));
        let apart: Vec<Pair> = all.filter(|&pair| truth(pair).is_some()).collect();
        let mut scratch = nearest_features::Scratch::default();
        let margin = 0.4 * scale;
        nearest_features::find(Path::best(), frames, (&apart, margin), &mut scratch);
        for (&pair, found) in apart.iter().zip(&scratch.found) {
            let truth = truth(pair).unwrap();
            let near = match found {
                Found::Unknown => panic!("{pair:?} is in range"),
                Found::Beyond => {
                    assert!(truth.upper() > margin, "{truth:?}");
                    continue;
                }
                Found::Near(near) => near,
            };
            assert!(f64::from(near.lower) <= truth.upper(), "{near:?} {truth:?}");
            count += 1;
            let accurate = [Accuracy::F64, Accuracy::Certified]
                .map(|accuracy| near.distance(accuracy, posed(pair)));
            let [in_f64, certified] = accurate;
            let in_f32 = near.distance_in_f32(frames, pair);
            for (k, found) in [in_f32, in_f64, certified].into_iter().enumerate() {
                let Some(found) = found else {
                    missed[k] += 1;
                    continue;
                };
                assert!(
                    found.lower() <= truth.upper() && truth.lower() <= found.upper(),
                    "{k} {found:?} {truth:?} {near:?}"
                );
                let apart = found.point_b - found.point_a - found.normal * found.distance;
                assert!(apart.length() < 1e-11 * scale, "{k} {found:?} {truth:?}");
            }
        }
    }
    // Edges and faces that are level but for a tilt that f32 does not see.
    let [in_f32, in_f64, certified] = missed;
    assert!(count > 3000 && in_f32 < count / 100, "{count} {missed:?}");
    assert!(in_f64 < count / 20 && certified < count / 5, "{count} {missed:?}");
}

#[test]
fn the_axes_that_the_lanes_leave_out_change_no_depth() {
    let (mut looked_at, mut count) = (0, 0);
    for (seed, scale) in [(4, 1.0), (5, 1e-4), (6, 1e4), (7, 1.0)] {
        let scene = pairs_of_cuboids(seed, 4000, scale);
        let frame = prepared(&scene);
        let mut scratch = depths::Scratch::default();
        scratch.pairs.extend((0..scene.len() as u32 / 2).map(|k| Pair::new(2 * k, 2 * k + 1)));
        depths::find(Path::best(), FramePair::of_one(&frame), &mut scratch);
        for (pair, &axes) in scratch.pairs.iter().zip(&scratch.axes) {
            let [a, b] = [pair.i, pair.j].map(|k| {
                let side = PosedShape::of(&scene, k);
                PosedSupport::polytope(side.shape.as_polytope().unwrap(), side.pose)
            });
            for accuracy in [Accuracy::F32, Accuracy::F64, Accuracy::Certified] {
                let all = cuboid_depth(a, b, accuracy);
                if all.is_some() {
                    assert_eq!(cuboid_depth_along(axes, a, b, accuracy), all, "{pair:?} {axes:?}");
                    let mirrored = cuboid_depth_along(axes.mirrored(), b, a, accuracy);
                    assert_eq!(mirrored, cuboid_depth(b, a, accuracy), "{pair:?} {axes:?}");
                    count += 1;
                    looked_at += axes.0.count_ones();
                }
            }
            assert_eq!(axes.mirrored().mirrored(), axes);
        }
    }
    assert!(count > 3000 && looked_at < 5 * count, "{count} {looked_at}");
    assert_eq!(Axes::ALL.mirrored(), Axes::ALL);
}

/// Those of the pairs 2k, 2k + 1 that touch.
fn touching_pairs(scene: &Scene) -> Vec<Pair> {
    let touch = |pair: &Pair| {
        let [a, b] = [pair.i, pair.j].map(|k| PosedShape::of(scene, k));
        crate::certified::overlap_of(a, b).0 == Verdict::Touching(())
    };
    (0..scene.len() as u32 / 2).map(|k| Pair { i: 2 * k, j: 2 * k + 1 }).filter(touch).collect()
}

/// How far a point is from the surface of a cuboid.
fn off_surface(point: DVec3, cuboid: PosedShape<'_>, half: DVec3) -> f64 {
    let local = cuboid.pose.rotation().transpose() * (point - cuboid.pose.translation());
    let beyond = local.abs() - half;
    let outside = beyond.max(DVec3::ZERO).length();
    if outside > 0.0 { outside } else { -beyond.max_element() }
}

/// Whether the normal is out of the first or into the second.
const SENSES: [f64; 2] = [1.0, -1.0];

/// The area that the points span, seen along the normal.
fn area(found: &Manifold) -> f64 {
    let points: Vec<DVec3> = found.points().iter().map(|point| point.point_a).collect();
    let mut largest: f64 = 0.0;
    for order in [[0, 1, 2, 3], [0, 2, 1, 3], [0, 1, 3, 2]] {
        let at = |k: usize| points[order[k].min(points.len() - 1)];
        let diagonals = (at(2) - at(0)).cross(at(3) - at(1));
        largest = largest.max(diagonals.dot(found.normal).abs() / 2.0);
    }
    largest
}

#[test]
fn the_patches_that_the_lanes_find_lie_on_both_cuboids_and_are_as_deep_as_they() {
    let mut counts = [0; 5];
    let (mut known, mut touching, mut narrower) = (0, 0, 0);
    let first = std::env::var("DCD_SEED").map_or(11, |seed| seed.parse().expect("a seed"));
    for (seed, scale) in (first..).zip([1.0, 1e-4, 1e4, 1.0]) {
        let scene = pairs_of_cuboids(seed, 4000, scale);
        let frame = prepared(&scene);
        let frames = FramePair::of_one(&frame);
        let posed = |pair: Pair| [pair.i, pair.j].map(|k| PosedShape::of(&scene, k));
        let pairs = touching_pairs(&scene);
        let swapped: Vec<Pair> = pairs.iter().map(|pair| Pair { i: pair.j, j: pair.i }).collect();
        let found = |pairs: &[Pair]| {
            let mut scratch = patches::Scratch::default();
            patches::find(Path::best(), frames, pairs, &mut scratch);
            let answers = pairs.iter().enumerate().map(|(number, &pair)| {
                let patch = scratch.of(number);
                let mut list = ManifoldContacts::default();
                list.push_pair(pair);
                let sides = posed(pair);
                let is_written = patch.is_known()
                    && Manifolds::default().measure_cuboids(patch, sides, (&mut list, 0));
                is_written.then(|| list.contacts(0..1).next().unwrap().answer[0])
            });
            answers.collect::<Vec<_>>()
        };
        for ((&pair, lanes), mirrored) in pairs.iter().zip(found(&pairs)).zip(found(&swapped)) {
            touching += 1;
            let Some(lanes) = lanes else {
                assert!(mirrored.is_none(), "{pair:?}");
                continue;
            };
            let mirrored = mirrored.unwrap();
            known += 1;
            let [a, b] = posed(pair);
            let half = [a, b].map(|side| match side.shape.as_polytope().unwrap().kind() {
                Kind::Cuboid { half_extents } => half_extents,
                _ => unreachable!(),
            });
            let size = half[0].length() + half[1].length();
            let size = size + (b.pose.translation() - a.pose.translation()).length();
            let Verdict::Touching(depth) =
                Depths.measure_at(Accuracy::Certified, a, b, &mut Default::default())
            else {
                panic!("{pair:?}");
            };
            let bound = lanes.error_bound;
            assert!(bound <= 3e-5 * size, "{pair:?} {bound:e} {size}");
            assert!((lanes.normal.length() - 1.0).abs() < 1e-12);
            let points = lanes.points();
            counts[points.len()] += 1;
            assert!((points[0].depth - depth.depth).abs() <= bound, "{pair:?} {lanes:?} {depth:?}");
            assert_eq!((mirrored.normal, mirrored.error_bound), (-lanes.normal, bound));
            for (point, other) in points.iter().zip(mirrored.points()) {
                assert!(point.depth >= 0.0 && point.depth <= points[0].depth, "{pair:?}");
                let apart = point.point_a - point.point_b - lanes.normal * point.depth;
                assert!(apart.length() <= 1e-12 * (size + a.pose.translation().length()));
                for (side, (place, half)) in
                    [(point.point_a, half[0]), (point.point_b, half[1])].into_iter().enumerate()
                {
                    let off = off_surface(place, [a, b][side], half);
                    assert!(off <= bound, "{pair:?} {side} {off:e} {lanes:?}");
                    if let Feature::Face(number) = point.features[side] {
                        let (shape, towards) = ([a, b][side].shape, lanes.normal * SENSES[side]);
                        let facets = shape.as_polytope().unwrap().facets().facets();
                        let facing = [a, b][side].pose.rotation() * facets[number as usize].normal;
                        assert!(facing.dot(towards) > 0.96, "{pair:?} {side} {lanes:?}");
                    }
                }
                assert_eq!((point.point_a, point.point_b), (other.point_b, other.point_a));
                assert_eq!(point.features, [other.features[1], other.features[0]]);
            }
            // Beside the general way's, of the same normal.
            let Verdict::Touching(reference) =
                Manifolds::default().measure_at(Accuracy::F64, a, b, &mut Default::default())
            else {
                panic!("{pair:?}");
            };
            if reference[0].normal.dot(lanes.normal) > 1.0 - 1e-9 {
                let (wide, least) = (area(&reference[0]), 1e-4 * size * size);
                narrower += usize::from(area(&lanes) < 0.9 * wide - least);
                assert!(area(&lanes) >= 0.5 * wide - least, "{pair:?} {lanes:?} {reference:?}");
            }
        }
    }
    assert!(known * 10 > touching * 6, "{known} of {touching}");
    assert!(narrower * 50 < known, "{narrower} of {known}");
    assert!(counts[1..].iter().all(|&count| count > 5), "{counts:?}");
}

/// Pairs 2k, 2k + 1 that are not turned: of numbers with few digits, so that sides meet and faces rest exactly, and of any.
fn level_pairs(seed: u64, count: usize, scale: f64) -> Scene {
    let mut draw = Draw(seed);
    let (mut shapes, mut poses) = (Vec::new(), Vec::new());
    for k in 0..count {
        let mut vector = |least: f64| {
            let any = draw.vector();
            if k % 3 == 0 { any.abs() + least } else { (any.abs() * 4.0).ceil() * 0.25 + least }
        };
        let (half, other) = (vector(0.0) * 0.5 + 0.125, vector(0.0) * 0.5 + 0.125);
        let signs = draw.vector().signum();
        let reach = half + other;
        let offset = match k % 4 {
            0 => reach * DVec3::new(1.0, draw.unit(), draw.unit()),
            1 => reach * [DVec3::new(draw.unit(), 1.0, 1.0), DVec3::ONE, DVec3::Z][k / 4 % 3],
            2 => ((reach * draw.vector()) * 8.0).round() * 0.125,
            _ => reach * draw.vector(),
        };
        let far = if k % 11 == 0 { draw.vector() * 1e3 } else { DVec3::ZERO };
        for (half, place) in [(half, far), (other, far + offset * signs)] {
            shapes.push(Shape::cuboid(half * scale).unwrap());
            poses.push(Pose::from_translation(place * scale).unwrap());
        }
    }
    Scene::one_each(shapes, poses).unwrap()
}

/// How far a point is from a feature of a cuboid that is not turned.
fn off_feature(point: DVec3, feature: Feature, cuboid: PosedShape<'_>) -> f64 {
    let polytope = cuboid.shape.as_polytope().unwrap();
    let place = |k: u32| polytope.vertices()[k as usize] + cuboid.pose.translation();
    let corners: Vec<DVec3> = match feature {
        Feature::Vertex(k) => vec![place(k)],
        Feature::Edge(j, k) => vec![place(j), place(k)],
        Feature::Face(k) => {
            let facet = &polytope.facets().facets()[k as usize];
            polytope.facets().corners(facet).iter().map(|&k| place(k)).collect()
        }
        Feature::Surface => panic!("of cuboids alone"),
    };
    // All of these are boxes along the axes.
    let least = corners.iter().copied().reduce(DVec3::min).unwrap();
    let most = corners.iter().copied().reduce(DVec3::max).unwrap();
    (point - point.clamp(least, most)).length()
}

#[test]
fn the_patches_of_cuboids_that_are_not_turned_are_the_rectangles_that_both_share() {
    let mut counts = [0; 5];
    for (seed, scale) in [(21, 1.0), (22, 1e-4), (23, 1e4)] {
        let scene = level_pairs(seed, 3000, scale);
        let frame = prepared(&scene);
        let frames = FramePair::of_one(&frame);
        let posed = |pair: Pair| [pair.i, pair.j].map(|k| PosedShape::of(&scene, k));
        let pairs = touching_pairs(&scene);
        let swapped: Vec<Pair> = pairs.iter().map(|pair| Pair { i: pair.j, j: pair.i }).collect();
        let found = |pairs: &[Pair]| {
            let mut scratch = patches::Scratch::default();
            patches::level::find(Path::best(), frames, pairs, &mut scratch);
            let answers = pairs.iter().enumerate().map(|(number, &pair)| {
                assert!(patches::level::are_level(frames, pair), "{pair:?}");
                let patch = scratch.of(number);
                let mut list = ManifoldContacts::default();
                list.push_pair(pair);
                let is_written = patch.is_known()
                    && Manifolds::default().measure_cuboids(patch, posed(pair), (&mut list, 0));
                is_written.then(|| list.contacts(0..1).next().unwrap().answer[0])
            });
            answers.collect::<Vec<_>>()
        };
        for ((&pair, lanes), mirrored) in pairs.iter().zip(found(&pairs)).zip(found(&swapped)) {
            let [a, b] = posed(pair);
            let apart = b.pose.translation() - a.pose.translation();
            let (Some(lanes), Some(mirrored)) = (lanes, mirrored) else {
                // Two of one centre have no order.
                assert_eq!((apart, lanes, mirrored), (DVec3::ZERO, None, None), "{pair:?}");
                continue;
            };
            let half = [a, b].map(|side| match side.shape.as_polytope().unwrap().kind() {
                Kind::Cuboid { half_extents } => half_extents,
                _ => unreachable!(),
            });
            let size = half[0].element_sum() + half[1].element_sum() + apart.abs().element_sum();
            let what = format!("{pair:?} {half:?} {apart} {lanes:?}");
            let overlaps = half[0] + half[1] - apart.abs();
            let bound = lanes.error_bound;
            assert!(bound <= 1e-5 * size + 4e-15 * a.pose.translation().length(), "{what}");
            let axis = lanes.normal.abs().max_position();
            assert_eq!(lanes.normal.abs()[axis], 1.0, "{what}");
            assert!(lanes.normal.dot(apart) >= 0.0, "{what}");
            assert!(overlaps[axis] <= overlaps.min_element() + bound, "{what}");
            // The rectangle that both share, beside the normal.
            let low = (-half[0]).max(apart - half[1]);
            let high = half[0].min(apart + half[1]);
            let others = [(axis + 1) % 3, (axis + 2) % 3];
            let is_wide = others.map(|k| high[k] - low[k] > bound);
            let points = lanes.points();
            let due = is_wide.map(|is_wide| if is_wide { 2 } else { 1 });
            assert_eq!(points.len(), due[0] * due[1], "{what}");
            counts[points.len()] += 1;
            for (j, point) in points.iter().enumerate() {
                assert!((point.depth - overlaps[axis]).abs() <= bound, "{what}");
                let at = point.point_a - a.pose.translation();
                for k in others {
                    let off = (at[k] - low[k]).abs().min((at[k] - high[k]).abs());
                    assert!(off <= bound, "{what} {j} {k} {off}");
                }
                for other in &points[..j] {
                    assert!(point.point_a.distance(other.point_a) > bound, "{what}");
                }
                let sides = [(point.point_a, a), (point.point_b, b)];
                for ((place, side), feature) in sides.into_iter().zip(point.features) {
                    let off = off_feature(place, feature, side);
                    assert!(off <= bound, "{what} {place} {feature:?} {off}");
                }
                let other = mirrored.points()[j];
                assert_eq!((point.point_a, point.point_b), (other.point_b, other.point_a));
                assert_eq!(point.features, [other.features[1], other.features[0]]);
            }
            assert_eq!((mirrored.normal, mirrored.error_bound), (-lanes.normal, bound));
        }
    }
    let [_, one, two, _, four] = counts;
    assert!(one > 100 && two > 500 && four > 3000, "{counts:?}");
}
