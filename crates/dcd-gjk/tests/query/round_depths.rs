//! How deep cylinders and cones overlap what has corners, and each other, as the lanes find it: beside the certified search.

use super::lane_depths::alone;
use super::patches::off_surface;
use super::scenes::{Draw, in_both_orders};
use super::within::{found, on_every_path};
use dcd_geom::glam::{DQuat, DVec3};
use dcd_geom::{Object, Pair, Pose, Scene, Shape, SupportMap};
use dcd_gjk::query::MeasureAt;
use dcd_gjk::{
    Accuracy, Contact, Depths, Manifolds, PairSolver, PosedShape, SimdDepths, Verdict, certified,
    epa,
};

/// Cylinders and cones, some flat or long or rounded, and what is not round.
pub(super) fn shapes(draw: &mut Draw, scale: f64) -> Vec<Shape> {
    let mut all = Vec::new();
    for k in 0..24 {
        let stretch = [1.0, 0.02, 30.0][k % 3];
        let radius = (0.1 + 0.4 * draw.unit().abs()) * scale;
        let height = radius * stretch * (0.5 + draw.unit().abs());
        let shape = match k % 2 {
            0 => Shape::cylinder(height, radius),
            _ => Shape::cone(height, radius),
        };
        let swept = if k % 5 == 0 { 0.1 * scale } else { 0.0 };
        all.push(shape.unwrap().swept(swept).unwrap());
    }
    for corners in [2, 3, 8, 30] {
        let corners = (0..corners).map(|_| draw.vector() * 0.6 * scale).collect();
        all.push(Shape::hull(corners).unwrap());
    }
    all.push(Shape::cuboid(DVec3::new(0.5, 0.4, 0.3) * scale).unwrap());
    all.push(Shape::cuboid(DVec3::new(0.5, 0.4, 0.3) * scale).unwrap().swept(0.1 * scale).unwrap());
    all.push(Shape::capsule(0.4 * scale, 0.2 * scale).unwrap());
    all
}

/// Two shapes, the first of them round, that are turned and have a way from the one to the other.
pub(super) struct Couple {
    pub(super) kinds: [u32; 2],
    pub(super) turns: [DQuat; 2],
    pub(super) place: DVec3,
    pub(super) way: DVec3,
}

impl Couple {
    /// Number k: turned at random, alike, by quarters or by all but that.
    pub(super) fn draw(draw: &mut Draw, shapes: &[Shape], far: f64, k: u32) -> Self {
        let round = 24;
        let kind = |draw: &mut Draw, most: usize| (draw.unit().abs() * most as f64) as u32;
        let kinds = [kind(draw, round), kind(draw, shapes.len())];
        let place = draw.vector() * far;
        let turn = if k.is_multiple_of(3) { DQuat::IDENTITY } else { draw.turn() };
        let second = match k % 7 {
            0 => turn,
            1 => turn * DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2),
            2 => turn * DQuat::from_scaled_axis(draw.vector() * 1e-7),
            _ => draw.turn(),
        };
        let way = match k % 5 {
            0 => turn * DVec3::Z,
            1 => turn * DVec3::X,
            _ => draw.vector().normalize(),
        };
        Self { kinds, turns: [turn, second], place, way }
    }

    /// How far along the way the centres are where the two just part.
    pub(super) fn parting(&self, shapes: &[Shape]) -> f64 {
        let along = |side: usize, way: DVec3| {
            let (local, shape) =
                (self.turns[side].inverse() * way, &shapes[self.kinds[side] as usize]);
            local.dot(shape.support(local).point) + shape.radius()
        };
        along(0, self.way) + along(1, -self.way)
    }

    /// Both, the centres so far apart along the way.
    pub(super) fn objects(&self, reach: f64) -> [Object; 2] {
        let Self { kinds, turns, place, way } = *self;
        let at = [place, place + way * reach];
        [0, 1].map(|side| Object::new(kinds[side], Pose::new(turns[side], at[side]).unwrap()))
    }
}

/// Pairs 2k, 2k + 1: deep, concentric, coaxial, and with hardly anything in common.
pub(super) fn objects(
    draw: &mut Draw,
    shapes: &[Shape],
    [scale, far]: [f64; 2],
    count: u32,
) -> Vec<Object> {
    let pair = |k: u32| {
        let couple = Couple::draw(draw, shapes, far, k);
        let reach = match k % 11 {
            0 => 0.0,
            1 => 1e-9,
            // Up to where they part.
            2..5 => couple.parting(shapes) * (1.0 - [1e-8, 1e-4, 1e-2][k as usize % 3]),
            _ => 0.7 * draw.unit().abs() * scale,
        };
        couple.objects(reach)
    };
    (0..count).flat_map(pair).collect()
}

fn depths(scene: &Scene, pairs: &[Pair]) -> Vec<Contact<epa::Depth>> {
    on_every_path(|path| SimdDepths::on(path, Depths, Accuracy::F32), scene, pairs)
}

#[test]
fn the_depth_of_round_pairs_is_within_the_bound_and_its_points_on_both_surfaces() {
    let (mut bounds, mut sampled) = (Vec::new(), 0);
    let mut scratch = <Depths as PairSolver>::Scratch::default();
    for (seed, scale, far, count) in [
        (1, 1.0, 1.0, 1500),
        (2, 1e-4, 1e-4, 400),
        (3, 1e5, 1e5, 400),
        (4, 1.0, 1e6, 400),
        (5, 1e-20, 1e-20, 200),
    ] {
        let mut draw = Draw::seeded(seed);
        let shapes = shapes(&mut draw, scale);
        let objects = objects(&mut draw, &shapes, [scale, far], count);
        let scene = Scene::new(shapes, objects).unwrap();
        let pairs: Vec<_> = (0..count).map(|k| Pair::new(2 * k, 2 * k + 1)).collect();
        let in_lanes = depths(&scene, &pairs);
        let alone = alone(Accuracy::F32, &scene, in_lanes.iter().map(|found| found.pair));
        for Contact { pair, answer } in in_lanes.into_iter().chain(alone) {
            let sides = [pair.i, pair.j].map(|k| PosedShape::of(&scene, k));
            let [a, b] = sides;
            let apart = a.pose.translation() - b.pose.translation();
            let size = a.shape.reach() + b.shape.reach() + apart.abs().element_sum();
            let what = format!("{seed} {pair:?} {answer:?} {:?} {:?}", a.shape, b.shape);
            let truth = match Depths.measure_at(Accuracy::Certified, a, b, &mut scratch) {
                Verdict::Touching(truth) => truth,
                other => panic!("{what}: {other:?}"),
            };
            let off = (answer.depth - truth.depth).abs();
            assert!(off <= answer.error_bound + truth.error_bound, "{what} {truth:?}");
            // By that way the two come apart.
            let by = answer.normal * (answer.depth + answer.error_bound + 1e-9 * size);
            let away = Pose::from_matrix(*b.pose.rotation(), b.pose.translation() + by).unwrap();
            let moved = certified::overlap_of(a, PosedShape { pose: &away, ..b }).0;
            assert_ne!(moved, Verdict::Touching(()), "{what}");
            let slack = 1e-9 * size + 1e-14 * far;
            // Where the two have one axis, or nearly, samples are searched: no accuracy gets good bounds there.
            let is_sampled = truth.error_bound > 1e-8 * truth.depth.max(1e-4 * size);
            let off = if is_sampled { 1e-3 } else { 1e-5 } * size + slack;
            for (point, side) in [(answer.point_a, a), (answer.point_b, b)] {
                let beside = off_surface(point, side.shape, side.pose);
                assert!(beside <= off, "{what}: {beside}");
            }
            let missed = answer.point_a - answer.point_b - answer.normal * answer.depth;
            assert!(missed.length() <= off, "{what}: {missed}");
            sampled += usize::from(is_sampled);
            if is_sampled {
                continue;
            }
            bounds.push(answer.error_bound / size);
        }
    }
    bounds.sort_unstable_by(f64::total_cmp);
    let at = |share: f64| bounds[((bounds.len() - 1) as f64 * share) as usize];
    println!("{} depths, {:e}, {:e}, {:e}", bounds.len(), at(0.5), at(0.99), at(1.0));
    assert!(bounds.len() > 2800 && sampled < 300, "{} {sampled}", bounds.len());
    assert!(at(0.99) < 1e-5, "{}", at(0.99));
}

#[test]
fn both_orders_of_round_pairs_are_mirrored_and_other_pairs_change_nothing() {
    let mut draw = Draw::seeded(5);
    let shapes = shapes(&mut draw, 1.0);
    let objects = objects(&mut draw, &shapes, [1.0, 2.0], 500);
    let [scene, mirrored] = in_both_orders(shapes, objects);
    let pairs: Vec<_> = (0..500).map(|k| Pair::new(2 * k, 2 * k + 1)).collect();
    let back: Vec<_> =
        pairs.iter().rev().map(|pair| Pair::new(999 - pair.j, 999 - pair.i)).collect();
    let lanes = SimdDepths::new(Depths, Accuracy::F32);
    let (all, _) = found(&lanes, &scene, &pairs);
    let (seen, _) = found(&lanes, &mirrored, &back);
    assert!(all.len() > 300 && all.len() == seen.len());
    for (one, other) in all.iter().zip(seen.iter().rev()) {
        let [i, j] = [one.pair.i, one.pair.j].map(|k| k as usize);
        if scene.shape_of()[i] == scene.shape_of()[j] && scene.poses()[i] == scene.poses()[j] {
            // Both are equal, so both orders are one.
            continue;
        }
        let (ours, theirs) = (one.answer, other.answer);
        assert_eq!((ours.depth, ours.error_bound), (theirs.depth, theirs.error_bound));
        assert_eq!((ours.point_a, ours.point_b), (theirs.point_b, theirs.point_a));
        assert_eq!(ours.normal, -theirs.normal, "{:?}", one.pair);
    }
    for chunk in pairs.chunks(7) {
        let (some, _) = found(&lanes, &scene, chunk);
        assert!(some.iter().eq(all.iter().filter(|contact| chunk.contains(&contact.pair))));
    }
    // Their manifolds are of these depths.
    let (sets, _) = found(&SimdDepths::new(Manifolds::default(), Accuracy::F32), &scene, &pairs);
    assert_eq!(sets.len(), all.len());
    for (set, depth) in sets.iter().zip(&all) {
        let deepest = &set.answer[0];
        let off = (deepest.points()[0].depth - depth.answer.depth).abs();
        assert!(off <= deepest.error_bound + depth.answer.error_bound, "{:?}", set.pair);
    }
}
