//! Cores without an inscribed sphere, far from the origin of their own frame: the centre that stands
//! for them is rounded, and no certificate may take it for a point that it is not.

mod judge;

use dcd_geom::glam::{DMat3, DVec3};
use dcd_geom::{Aabb, Pair, Polytope, Pose, Scene, Shape, Support, SupportMap};
use dcd_gjk::{
    Coherent, ContactSink, NarrowPhase, Overlap, PosedShape, PosedSupport, Prepared, Report, Sides,
    Verdict, Within, certified,
};
use dcd_simd::Path;
use judge::cases::Draw;
use std::sync::Arc;

/// Two shapes at their poses.
type Case = [(Shape, Pose); 2];

fn truth(case: &Case) -> bool {
    let [a, b] = case.each_ref().map(|(shape, pose)| PosedShape { shape, pose });
    certified::overlap_of(a, b).0 == Verdict::Touching(())
}

/// What a narrow phase says of all cases in one scene, so that its lanes hold sixteen different ones.
fn found<N: NarrowPhase<Answer = ()>>(narrow: &N, cases: &[Case]) -> Vec<bool> {
    let shapes = cases.iter().flatten().map(|(shape, _)| shape.clone()).collect();
    let poses = cases.iter().flatten().map(|(_, pose)| *pose).collect();
    let scene = Scene::one_each(shapes, poses).unwrap();
    let pairs: Vec<Pair> = (0..cases.len() as u32).map(|k| Pair::new(2 * k, 2 * k + 1)).collect();
    let mut frame = N::Frame::default();
    let part = narrow.layout(&scene, Sides::One, &mut frame);
    narrow.prepare(&scene, 0, part, &mut vec![Aabb::default(); scene.len()]);
    narrow.begin_pairs(&mut frame, std::iter::once(&pairs[..]));
    let (mut contacts, mut report) = (Vec::new(), Report::default());
    let mut sink = ContactSink { contacts: &mut contacts, report: &mut report };
    let side = Prepared { scene: &scene, frame: &frame };
    narrow.decide(side, side, &pairs, &mut N::Scratch::default(), &mut sink);
    assert!(report.undecided().is_empty(), "{:?}", report.undecided());
    let mut touches = vec![false; cases.len()];
    for contact in contacts {
        touches[contact.pair.i as usize / 2] = true;
    }
    touches
}

fn paths() -> impl Iterator<Item = Path> {
    Path::ALL.into_iter().filter(|path| path.is_available())
}

/// That every narrow phase of the lanes says of each case what the exact method says.
fn check(cases: &[Case]) {
    let truth: Vec<bool> = cases.iter().map(truth).collect();
    for path in paths() {
        let by_lanes = [found(&Overlap::on(path), cases), found(&Coherent::on(path), cases)];
        for found in by_lanes {
            let wrong = (0..cases.len()).find(|&k| found[k] != truth[k]);
            assert_eq!(wrong.map(|k| format!("{:?}", cases[k])), None, "{path:?}");
        }
    }
}

fn next(x: f64, ulps: i64) -> f64 {
    f64::from_bits((x.to_bits() as i64 + ulps) as u64)
}

#[test]
fn copies_of_one_far_point_are_not_called_touching_by_their_mean() {
    let sphere = |x: f64| Shape::hull(vec![DVec3::splat(x); 64]).unwrap().rounded(1.0).unwrap();
    let (p, q, t) = (2135251731709.0234, 2135251731709.0078, 1.170341962416876);
    let mut cases = Vec::new();
    for k in 0..16 {
        for l in 0..16 {
            let pose = Pose::from_translation(DVec3::splat(t)).unwrap();
            cases.push([(sphere(next(p, k)), Pose::IDENTITY), (sphere(next(q, l)), pose)]);
        }
    }
    assert!(!truth(&cases[0]));
    check(&cases);
    // The same points without a radius, and a margin in its place.
    let points = |(shape, pose): (Shape, Pose)| (shape.rounded(0.0).unwrap(), pose);
    let bare: Vec<Case> = cases.iter().cloned().map(|case| case.map(points)).collect();
    let within = found(&Within::by(Overlap::default(), 2.0).unwrap(), &bare);
    assert_eq!(within, cases.iter().map(truth).collect::<Vec<_>>());
}

/// A core that has no sphere inside, of about that size, round a point `far` of its own frame.
fn core(draw: &mut Draw, size: f64, far: DVec3) -> Polytope {
    let count = draw.below(69);
    let mut flat = |count: u64| {
        let (x, y) = (draw.vector() * size, draw.vector() * size);
        (0..count).map(|_| far + x * draw.unit() + y * draw.unit()).collect::<Vec<_>>()
    };
    match flat(1)[0].x.to_bits() % 8 {
        0..3 => Polytope::hull(vec![flat(1)[0]; 30 + count as usize]),
        3 => Polytope::segment(flat(1)[0], flat(1)[0]),
        4 => Polytope::triangle([flat(1)[0], flat(1)[0], flat(1)[0]]),
        5 => Polytope::hull(flat(12)),
        // More than are all taken: the extreme ones of these.
        6 => Polytope::hull(flat(200)),
        _ => {
            let (from, along) = (flat(1)[0], flat(1)[0] - far);
            Polytope::hull((0..60).map(|k| from + along * f64::from(k)).collect())
        }
    }
    .unwrap()
}

/// A core at a pose that brings its middle near to a place; alone, or as a compound's only part.
fn body(draw: &mut Draw, size: f64, out: f64) -> (Shape, Pose, DVec3) {
    let far = draw.vector() * out;
    let core = core(draw, size, far);
    let radius = [0.0, 1.0, 1.0, 1e-3, 1e3][draw.below(5) as usize] * size;
    let core = core.rounded(radius).unwrap();
    let rotation = draw.rotation();
    let at = |middle: DVec3| Pose::new(rotation, -(rotation * middle)).unwrap();
    let middle = core.inner().centre;
    if draw.below(4) > 0 {
        return (core.into(), at(middle), middle);
    }
    let part = Pose::new(draw.rotation(), draw.vector() * out).unwrap();
    let middle = part.apply(middle);
    (Shape::compound(vec![(core.into(), part)]).unwrap(), at(middle), middle)
}

#[test]
fn cores_without_an_inscribed_sphere_are_right_on_both_sides_of_every_flip() {
    let mut draw = Draw(31);
    let (mut cases, mut flips) = (Vec::new(), 0);
    for k in 0..1200 {
        let size = [1.0, 1e-3, 1e3][k % 3];
        let out = size * [1.0, 1e3, 1e6, 1e9, 1e12][k % 5];
        let (a, b) = (body(&mut draw, size, out), body(&mut draw, size, out));
        let along = draw.vector() * size;
        let at = |steps: f64| -> Case {
            let there = Pose::from_matrix(*b.1.rotation(), b.1.translation() + along * steps);
            [(a.0.clone(), a.1), (b.0.clone(), there.unwrap())]
        };
        // What f64 loses in a centre, and what f32 loses of the size.
        let units = [2f64.powi(-53) * out / size, 2f64.powi(-24)];
        let (mut near, mut apart) = (0.0f64, 1e5f64);
        if !truth(&at(near)) {
            // Flat cores that miss each other from the start: near is near enough.
            for unit in units {
                cases.extend([0.0, 1.0, 10.0, 100.0].map(|k| at(k * unit)));
            }
            continue;
        }
        assert!(!truth(&at(apart)), "{:?}", at(apart));
        while near.next_up() < apart {
            let middle = f64::from_bits(near.to_bits() + (apart.to_bits() - near.to_bits()) / 2);
            if truth(&at(middle)) { near = middle } else { apart = middle }
        }
        flips += 1;
        for unit in units {
            let steps = [0.0, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0];
            let sides = steps.iter().flat_map(|k| [near - k * unit, apart + k * unit]);
            cases.extend(sides.filter(|s| *s >= 0.0).map(at));
        }
    }
    assert!(flips > 400, "{flips}");
    cases.chunks(512).for_each(check);
}

#[test]
fn flat_shapes_are_within_a_margin_where_their_grown_shapes_touch() {
    let mut draw = Draw(32);
    let mut cases: Vec<Case> = Vec::new();
    let margin = 0.5;
    for k in 0..400 {
        let out = [1.0, 1e3, 1e6, 1e9, 1e12][k % 5];
        let mut side = || {
            let far = draw.vector() * out;
            let core = core(&mut draw, 1.0, far);
            let rotation = draw.rotation();
            let to = -(rotation * core.inner().centre);
            (Shape::from(core), Pose::new(rotation, to).unwrap())
        };
        let (a, b) = (side(), side());
        let unit = 2f64.powi(-53) * out + 2f64.powi(-24);
        let along = draw.vector();
        let at = |steps: f64| -> Case {
            let there = Pose::from_matrix(*b.1.rotation(), b.1.translation() + along * steps);
            [a.clone(), (b.0.clone(), there.unwrap())]
        };
        let grown =
            |case: Case| case.map(|(shape, pose)| (shape.swept(margin / 2.0).unwrap(), pose));
        let (mut near, mut apart) = (0.0f64, 1e5f64);
        if !truth(&grown(at(near))) {
            continue;
        }
        while near.next_up() < apart {
            let middle = f64::from_bits(near.to_bits() + (apart.to_bits() - near.to_bits()) / 2);
            if truth(&grown(at(middle))) { near = middle } else { apart = middle }
        }
        let sides = [0.0, 1.0, 10.0, 100.0].map(|k| [near - k * unit, apart + k * unit]);
        cases.extend(sides.into_iter().flatten().filter(|s| *s >= 0.0).map(at));
    }
    assert!(cases.len() > 1000, "{}", cases.len());
    for cases in cases.chunks(512) {
        let truth: Vec<bool> = cases
            .iter()
            .map(|case| {
                truth(&case.clone().map(|(shape, pose)| (shape.swept(margin / 2.0).unwrap(), pose)))
            })
            .collect();
        for path in paths() {
            let found = found(&Within::by(Overlap::on(path), margin).unwrap(), cases);
            let wrong = (0..cases.len()).find(|&k| found[k] != truth[k]);
            assert_eq!(wrong.map(|k| format!("{:?}", cases[k])), None, "{path:?}");
        }
    }
}

#[test]
fn the_exact_method_says_of_them_what_the_judge_says() {
    let mut draw = Draw(33);
    for k in 0..60 {
        let out = [1e3, 1e9, 1e12][k % 3];
        let mut side = || {
            let (far, radius) = (draw.vector() * out, draw.unit().abs());
            let far = Polytope::segment(far, far + draw.vector()).unwrap().rounded(radius).unwrap();
            let rotation = draw.rotation();
            let to = draw.vector() - rotation * far.inner().centre;
            (far, Pose::new(rotation, to).unwrap())
        };
        let (a, b) = (side(), side());
        let judged = dcd_judge::touches((&a.0, &a.1), (&b.0, &b.1));
        let (of_a, of_b) = (PosedSupport::polytope(&a.0, &a.1), PosedSupport::polytope(&b.0, &b.1));
        assert_eq!(certified::overlap_exactly(of_a, of_b), judged, "{a:?} {b:?}");
    }
}

/// A polytope that is known by its support map alone.
struct Foreign(Polytope);

impl SupportMap<f64> for Foreign {
    fn support(&self, direction: DVec3) -> Support<f64> {
        self.0.support(direction)
    }
}

#[test]
fn the_origin_of_a_foreign_map_or_of_a_moved_part_is_not_taken_for_a_point_of_it() {
    let mut draw = Draw(34);
    let mut near_calls = 0;
    for k in 0..600 {
        let out = [1.0, 1e2, 1e4, 1e6][k % 4];
        let mut hull = |far: DVec3| {
            Polytope::hull((0..4 + k % 5).map(|_| far + draw.vector()).collect()).unwrap()
        };
        let (a, b) = (hull(DVec3::ZERO), hull(DVec3::splat(out)));
        let offset = draw.vector() * 0.5 - b.inner().centre;
        let foreign = Shape::custom(Arc::new(Foreign(b.clone()))).unwrap();
        let hull = Shape::from(a.clone());
        let at = |steps: f64| Pose::from_translation(offset + DVec3::X * steps).unwrap();
        let (mut near, mut apart) = (0.0, 10.0);
        let touches = |pose: &Pose| {
            let (a, b) =
                (PosedSupport::polytope(&a, &Pose::IDENTITY), PosedSupport::polytope(&b, pose));
            certified::overlap_exactly(a, b)
        };
        for _ in 0..60 {
            let middle = 0.5 * (near + apart);
            if touches(&at(middle)) { near = middle } else { apart = middle }
        }
        for unit in [0.0, 1.0, 4.0, 16.0, 64.0].map(|k| k * out * 2f64.powi(-50)) {
            let pose = at(apart + unit);
            let (a, b) = (
                PosedShape { shape: &hull, pose: &Pose::IDENTITY },
                PosedShape { shape: &foreign, pose: &pose },
            );
            let found = certified::overlap_of(a, b).0;
            assert_ne!(found, Verdict::Touching(()), "{:?} {:?} {unit}", a, b.pose);
            near_calls += usize::from(matches!(found, Verdict::Undecided(_)));
        }
    }
    assert!(near_calls > 100, "{near_calls}");
    // A part of a compound, a cylinder, far from the compound's own origin.
    let corner = DVec3::new(1099511627776.0, 412316860416.0, 1786706395136.0);
    let hull = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].map(|v| corner + v);
    let part = Pose::from_translation(DVec3::new(1048576.0, 393216.0, 1703936.0)).unwrap();
    let cylinder = Shape::cylinder(0.5, 0.5).unwrap();
    let turned = DMat3::from_cols(DVec3::Z, -DVec3::Y, DVec3::X);
    let there = Pose::from_matrix(turned, DVec3::new(-1703935.0, 393216.875, -1048575.625));
    let a = (Shape::hull(hull.to_vec()).unwrap(), Pose::from_translation(-corner).unwrap());
    let b = (Shape::compound(vec![(cylinder, part)]).unwrap(), there.unwrap());
    let (a, b) = (PosedShape { shape: &a.0, pose: &a.1 }, PosedShape { shape: &b.0, pose: &b.1 });
    // 0.0248 apart, along about (−1, −1, −1).
    assert_ne!(certified::overlap_of(a, b).0, Verdict::Touching(()));
    assert_ne!(certified::overlap_of(b, a).0, Verdict::Touching(()));
}
