//! What the lanes prove of spheres, capsules and cuboids beside the certified distance and depth.

use super::super::certificate::CertifiedBounds;
use super::super::first_stages::Entry;
use super::super::prepare;
use super::*;
use crate::distance::distance;
use crate::motion::tests::Draw;
use crate::query::MeasureAt;
use crate::simd::Purpose;
use crate::{Accuracy, Depths, DistanceResult, PosedShape, Sides, Verdict, certified};
use dcd_geom::glam::{DQuat, DVec3};
use dcd_geom::{Aabb, Polytope, Pose, Scene, Shape};
use dcd_simd::{Kernel, Path, dispatch_on};

/// What is proved of at most sixteen pairs of one form: the lanes that are apart and that touch, and the clearances.
struct Proofs<'a> {
    frames: FramePair<'a>,
    pairs: &'a [Pair],
    cores: CoreForm,
}

impl Kernel for Proofs<'_> {
    type Output = (u32, u32, Row);

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Self::Output {
        let (mut entry, mut straight) = (Entry::default(), StraightPairs::default());
        entry.read::<CertifiedBounds>(self.frames, self.pairs, 0);
        entry.spheres::<L, CertifiedBounds>(l);
        let packet = (&entry.packet, self.pairs.len());
        let found = match self.cores {
            CoreForm::Straight => straight.of_two(l, self.frames, packet),
            _ => straight.beside_cuboid(l, self.frames, packet),
        };
        let mut clearance = Row::default();
        l.store(found.clearance, &mut clearance);
        (found.apart & entry.live, found.touching & entry.live, clearance)
    }
}

fn shape(draw: &mut Draw, k: usize, scale: f64) -> Shape {
    let half = (draw.vector().abs() * 0.5 + 0.02) * scale;
    let radius = if k.is_multiple_of(5) { 0.0 } else { half.y * 0.7 };
    let segment = |from: DVec3, to: DVec3| {
        Shape::from(Polytope::segment(from, to).unwrap().rounded(radius).unwrap())
    };
    match k % 7 {
        0 | 1 => Shape::sphere(radius).unwrap(),
        2 => Shape::capsule(half.x * [1.0, 1e-9, 0.0][k / 7 % 3], radius).unwrap(),
        3 => segment(draw.vector() * scale, draw.vector() * scale),
        4 => Shape::capsule(half.x, radius).unwrap(),
        _ => Shape::cuboid(half * DVec3::new(1.0, 1.0, [1.0, 1e-3, 0.0][k / 7 % 3])).unwrap(),
    }
}

/// Pairs 2k, 2k + 1, one of each not a cuboid: turned any way, alike and nearly so, near the origin and far; every other pair
/// moved until it touches or not by some millionths.
fn scene(seed: u64, count: usize, scale: f64) -> Scene {
    let mut draw = Draw(seed);
    let (mut shapes, mut poses) = (Vec::new(), Vec::new());
    for k in 0..count {
        let pair = [shape(&mut draw, k % 5, scale), shape(&mut draw, k / 5, scale)];
        let turn = DQuat::from_scaled_axis(draw.vector() * 3.0);
        let tilt = DQuat::from_scaled_axis(draw.vector() * [0.0, 1e-7, 1e-3, 3.0][k % 4]);
        let far = draw.vector() * [0.0, 1.0, 100.0][k / 4 % 3] * scale;
        let at = draw.vector() * 1.4 * scale;
        let place = |off: DVec3| {
            let other = Pose::new(tilt * turn, far + at + off).unwrap();
            [Pose::new(turn, far).unwrap(), other]
        };
        let mut posed = place(DVec3::ZERO);
        let [a, b] = [0, 1].map(|k| PosedShape { shape: &pair[k], pose: &posed[k] });
        if let (DistanceResult::Apart(found), true) = (distance(a, b).0, k % 2 == 0) {
            let gap = draw.number() * [1e-6, 1e-7][k / 2 % 2] * scale;
            posed = place(found.normal * (gap - found.distance));
        }
        shapes.extend(pair);
        poses.extend(posed);
    }
    Scene::one_each(shapes, poses).unwrap()
}

#[test]
fn what_is_proved_of_straight_cores_is_true_on_every_path_and_little_is_left_open() {
    // Of pairs at random, then of those within a hair: apart, touching, left open.
    let mut counts = [[0; 3]; 2];
    for (seed, scale) in [(1, 1.0), (2, 1e-4), (3, 1e4)] {
        let scene = scene(seed, 3000, scale);
        let mut frame = SimdFrame::default();
        let mut aabbs = vec![Aabb::default(); scene.len()];
        let part = frame.layout(&scene, Sides::One, Purpose::Measure);
        let objects = prepare::Prepare { scene: &scene, first: 0, part, aabbs: &mut aabbs };
        prepare::prepare(Path::best(), objects);
        let frames = FramePair::of_one(&frame);
        for cores in [CoreForm::Straight, CoreForm::AndCuboid] {
            let pairs = (0..scene.len() as u32).step_by(2).map(|k| Pair::new(k, k + 1));
            let pairs: Vec<Pair> =
                pairs.filter(|&pair| CoreForm::of_pair(frames, pair) == cores).collect();
            assert!(pairs.len() > 500);
            for pairs in pairs.chunks(WIDTH) {
                for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
                    let found = dispatch_on(path, Proofs { frames, pairs, cores });
                    for (lane, pair) in pairs.iter().enumerate() {
                        let is = |lanes: u32| lanes >> lane & 1 == 1;
                        let (apart, touches) = (is(found.0), is(found.1));
                        let by_a_hair = usize::from(pair.i / 2 % 2 == 0);
                        let outcome = if apart { 0 } else { 2 - usize::from(touches) };
                        counts[by_a_hair][outcome] += 1;
                        if apart || touches {
                            let clearance = f64::from(found.2.0[lane]);
                            holds(&scene, *pair, (apart, touches, clearance));
                        }
                    }
                }
            }
        }
    }
    let [at_random, by_a_hair] = counts;
    assert!(at_random[0] > 1000 && at_random[1] > 200, "{counts:?}");
    assert!(at_random[2] * 1000 < at_random[0] + at_random[1], "{counts:?}");
    assert!(by_a_hair.iter().all(|&count| count > 100), "{counts:?}");
}

/// Asserts that a pair is apart, or touches, by the clearance at least.
fn holds(scene: &Scene, pair: Pair, (apart, touches, clearance): (bool, bool, f64)) {
    let [a, b] = [pair.i, pair.j].map(|k| PosedShape::of(scene, k));
    assert!(apart != touches, "{a:?} {b:?}");
    if apart {
        let DistanceResult::Apart(due) = distance(a, b).0 else { panic!("{a:?} {b:?}") };
        assert!((0.0..=due.upper()).contains(&clearance), "{clearance} {due:?} {a:?} {b:?}");
        return;
    }
    assert_eq!(certified::overlap_of(a, b).0, Verdict::Touching(()), "{a:?} {b:?}");
    if let Verdict::Touching(due) =
        Depths.measure_at(Accuracy::Certified, a, b, &mut Default::default())
    {
        assert!(clearance <= due.depth + due.error_bound, "{clearance} {due:?} {a:?} {b:?}");
    }
}
