//! The certified method on the whole conformance suite, by the exact judge.

use dcd_geom::{Aabb, Pair, Polytope, Pose, Scene, Shape};
use dcd_gjk::distance::{self, DistanceResult};
use dcd_gjk::epa::{self, Scratch};
use dcd_gjk::{
    ContactSink, Method, NarrowPhase, Overlap, PosedSupport, Prepared, Report, Sides, Verdict,
    certified,
};
use dcd_judge::Truth;
use dcd_scenes::conformance::{Case, Category, suite};
use dcd_simd::Path;
use std::collections::BTreeMap;

type Bodies<'a> = [PosedSupport<'a, Polytope>; 2];

fn bodies(case: &Case) -> Bodies<'_> {
    [PosedSupport::polytope(&case.a, &case.pose_a), PosedSupport::polytope(&case.b, &case.pose_b)]
}

fn sides(case: &Case) -> [(&Polytope, &Pose); 2] {
    [(&case.a, &case.pose_a), (&case.b, &case.pose_b)]
}

fn judged(case: &Case) -> bool {
    let [a, b] = sides(case);
    dcd_judge::touches(a, b)
}

fn certified_touches(case: &Case) -> bool {
    let [a, b] = bodies(case);
    certified::overlap(a, b).0 == Verdict::Touching(())
}

/// The pair's size: every coordinate of A − B is below it. May overflow to infinity.
fn size(case: &Case) -> f64 {
    let reach = |shape: &Polytope| shape.reach() + shape.swept_radius();
    let t = (case.pose_a.translation() - case.pose_b.translation()).abs();
    reach(&case.a) + reach(&case.b) + t.element_sum()
}

/// 2⁻⁵³.
const U: f64 = f64::EPSILON / 2.0;

/// What is off in a case, as a sentence.
fn faults(case: &Case, scratch: &mut Scratch) -> Vec<String> {
    let mut faults = Vec::new();
    let [a, b] = sides(case);
    let truth = Truth::of(a, b);
    let touches = truth.touches();
    if judged(case) != touches {
        faults.push(format!("the judges differ: {truth:?}"));
    }
    let [a, b] = bodies(case);
    let expected = if touches { Verdict::Touching(()) } else { Verdict::Apart };
    for found in [certified::overlap(a, b).0, certified::overlap(b, a).0] {
        if found != expected {
            faults.push(format!("{found:?}, in truth {expected:?}"));
        }
    }
    let value = truth.value();
    // Where even the truth is no f64 nothing can be promised of a number.
    let representable = value.abs() <= f64::MAX / 4.0 && size(case) <= f64::MAX / 4.0;
    match distance::of_polytopes(a, b).0 {
        DistanceResult::Apart(found) if !touches => {
            if representable {
                let number = Number { value: -found.distance, bound: found.error_bound };
                faults.extend(number.faults("distance", &truth, allowed(1e-12, value, case)));
            }
        }
        DistanceResult::Touching if touches => {}
        found => faults.push(format!("{found:?}, in truth {value}")),
    }
    match epa::depth(a, b, scratch) {
        Verdict::Touching(found) if touches => {
            let relative = if case.category.is_thin() { 1e-6 } else { 1e-9 };
            let number = Number { value: found.depth, bound: found.error_bound };
            faults.extend(number.faults("depth", &truth, allowed(relative, value, case)));
        }
        Verdict::Apart if !touches => {}
        Verdict::Undecided(_) if touches && !representable => {}
        found => faults.push(format!("{found:?}, in truth {value}")),
    }
    faults
}

/// How far a number may be off, and how wide its bound may be.
#[derive(Clone, Copy)]
struct Allowed {
    error: f64,
    bound: f64,
}

fn allowed(relative: f64, value: f64, case: &Case) -> Allowed {
    let size = size(case);
    // Relative alone wherever the truth is above 1e-12 of the size.
    let absolute = if value.abs() > 1e-12 * size { 0.0 } else { 32.0 * U * size };
    // Some denormal units are what is left of any digit near the least number.
    let least = if value.abs() < 1e-290 { 4.0 * f64::from_bits(1) } else { 0.0 };
    Allowed {
        error: relative * value.abs() + absolute + least,
        bound: relative.max(1e-9) * value.abs() + 1e-12 * size + least,
    }
}

/// A signed depth as a method has it.
struct Number {
    value: f64,
    bound: f64,
}

impl Number {
    fn faults(&self, name: &str, truth: &Truth, allowed: Allowed) -> Vec<String> {
        let mut faults = Vec::new();
        let Self { value, bound } = *self;
        let error = truth.less(value).abs();
        if !(error <= allowed.error) {
            faults.push(format!("{name} {value} is off by {error}, above {}", allowed.error));
        }
        if !(bound <= allowed.bound) {
            faults.push(format!("{name} {value} has the bound {bound}, above {}", allowed.bound));
        } else if !(truth.is_within(value - bound, value + bound) || error <= bound) {
            faults.push(format!("{name} {value} ± {bound} does not hold {}", truth.value()));
        }
        faults
    }
}

#[test]
fn a_number_that_is_off_and_a_bound_that_is_wide_or_does_not_hold_are_faults() {
    // Unit cubes a quarter apart.
    let cube = Polytope::cuboid(dcd_geom::glam::DVec3::splat(0.5)).unwrap();
    let there = Pose::from_translation(dcd_geom::glam::DVec3::X * 1.25).unwrap();
    let case = Case::new(Category::Faces, [(cube.clone(), Pose::IDENTITY), (cube, there)]);
    let [a, b] = sides(&case);
    let truth = Truth::of(a, b);
    let faults = |value: f64, bound: f64| {
        let number = Number { value, bound };
        number.faults("distance", &truth, allowed(1e-12, truth.value(), &case)).len()
    };
    assert_eq!(faults(-0.25, 0.0), 0);
    assert_eq!(faults(-0.25 * (1.0 + 1e-13), 1e-13), 0);
    assert_eq!(faults(-0.25 * (1.0 + 1e-11), 1e-10), 1, "off");
    assert_eq!(faults(-0.25 * (1.0 + 1e-13), 1e-15), 1, "does not hold");
    assert_eq!(faults(-0.25, 1e-9), 1, "wide");
    assert_eq!(faults(-0.25, f64::NAN), 1);
    assert_eq!(faults(f64::NAN, f64::INFINITY), 2);
}

#[test]
fn the_certified_method_is_right_on_the_whole_suite() {
    // The method itself finds the neighbouring floats, which is quick; whatever it finds is judged.
    let cases = suite(1, &certified_touches);
    assert!(cases.len() >= 3000, "{}", cases.len());
    let mut scratch = Scratch::default();
    let mut wrong = Vec::new();
    for (k, case) in cases.iter().enumerate() {
        let faults = faults(case, &mut scratch);
        wrong.extend(faults.into_iter().map(|fault| format!("{k} {}: {fault}", case.category)));
    }
    assert!(wrong.is_empty(), "{} faults:\n{}", wrong.len(), wrong.join("\n"));
}

/// A scene of both shapes of each case; none where one of them is out of a scene's range.
fn scene_of(cases: &[&Case]) -> Option<Scene> {
    let shapes = cases.iter().flat_map(|case| [case.a.clone().into(), case.b.clone().into()]);
    let poses = cases.iter().flat_map(|case| [case.pose_a, case.pose_b]);
    Scene::one_each(shapes.collect::<Vec<Shape>>(), poses.collect()).ok()
}

/// The answer of the lanes for each case, all decided at once; none where they leave it undecided.
fn decided_by_lanes(scene: &Scene, path: Path) -> Vec<Option<bool>> {
    let pairs: Vec<Pair> =
        (0..scene.len() as u32 / 2).map(|k| Pair::new(2 * k, 2 * k + 1)).collect();
    let narrow = Overlap::on(path);
    let mut frame = <Overlap as NarrowPhase>::Frame::default();
    let mut aabbs = vec![Aabb::default(); scene.len()];
    let part = narrow.layout(scene, Sides::One, &mut frame);
    narrow.prepare(scene, 0, part, &mut aabbs);
    let (mut contacts, mut report) = (Vec::new(), Report::default());
    let mut sink = ContactSink { contacts: &mut contacts, report: &mut report };
    let side = Prepared { scene, frame: &frame };
    narrow.decide(side, side, &pairs, &mut Default::default(), &mut sink);
    let mut said = vec![Some(false); pairs.len()];
    contacts.iter().for_each(|contact| said[contact.pair.i as usize / 2] = Some(true));
    report.undecided().iter().for_each(|open| said[open.pair.i as usize / 2] = None);
    said
}

#[test]
fn the_lanes_are_right_on_the_whole_suite_on_every_path() {
    // What the certified method says of this suite is judged above.
    let cases = suite(1, &certified_touches);
    let (inside, outside): (Vec<&Case>, Vec<&Case>) =
        cases.iter().partition(|case| scene_of(&[*case]).is_some());
    println!("{} cases, {} out of a scene's range", inside.len(), outside.len());
    for case in &outside {
        assert_eq!(case.category, Category::Huge);
    }
    assert!(inside.len() >= 3000 - 200, "{}", inside.len());
    let truth: Vec<bool> = inside.iter().map(|case| certified_touches(case)).collect();
    let scene = scene_of(&inside).unwrap();
    for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
        let said = decided_by_lanes(&scene, path);
        let wrong = (0..inside.len()).find(|&k| said[k] != Some(truth[k]));
        let case = wrong.map(|k| format!("{k} {}: {:?}", inside[k].category, said[k]));
        assert_eq!(case, None, "{path:?}");
    }
}

#[test]
fn every_category_has_its_pairs_and_both_answers_where_it_can() {
    let mut counts = BTreeMap::<Category, [usize; 2]>::new();
    let cases = suite(2, &certified_touches);
    for case in &cases {
        let [a, b] = bodies(case);
        let (verdict, method) = certified::overlap(a, b);
        assert!(method <= Method::Exact);
        let touches = usize::from(verdict == Verdict::Touching(()));
        counts.entry(case.category).or_default()[touches] += 1;
    }
    for category in Category::ALL {
        let [apart, touching] = counts.get(&category).copied().unwrap_or_default();
        println!("{category:12} {apart} apart, {touching} touching");
        assert!(apart + touching >= 120, "{category}: {apart} + {touching}");
        let one_answer = match category {
            Category::Gap => touching,
            Category::Overlap | Category::Nested | Category::Concentric => apart,
            Category::Identical | Category::Deep => apart,
            _ => {
                assert!(apart.min(touching) >= 5, "{category}: {apart} and {touching}");
                0
            }
        };
        assert_eq!(one_answer, 0, "{category}");
    }
}

#[test]
fn a_seed_makes_the_same_suite_again() {
    let flat = |case: &Case| {
        let of = |(shape, pose): (&Polytope, &Pose)| format!("{:?} {pose:?}", shape.vertices());
        sides(case).map(of).concat()
    };
    // No judge: no pair between neighbouring floats.
    let [one, again, other] = [1, 1, 2].map(|seed| suite(seed, &|_| false));
    let same = |a: &[Case], b: &[Case]| a.iter().map(flat).eq(b.iter().map(flat));
    assert!(same(&one, &again) && !same(&one, &other));
}
