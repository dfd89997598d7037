//! The certified rung on the whole conformance suite, by the exact judge.

use dcd_geom::{Polytope, Pose};
use dcd_gjk::distance::{self, DistanceResult};
use dcd_gjk::epa::{self, Scratch};
use dcd_gjk::{Body, Rung, Verdict, certified};
use dcd_judge::Truth;
use dcd_scenes::conformance::{Case, Category, suite};
use std::collections::BTreeMap;

type Bodies<'a> = [Body<'a, Polytope>; 2];

fn bodies(case: &Case) -> Bodies<'_> {
    [Body::polytope(&case.a, &case.pose_a), Body::polytope(&case.b, &case.pose_b)]
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
                let near = [1e-12 * -value + 32.0 * U * size(case), least(value)];
                let what = (found.distance, found.error_bound);
                faults.extend(measured("distance", what, (&truth, -1.0), near));
            }
        }
        DistanceResult::Touching if touches => {}
        found => faults.push(format!("{found:?}, in truth {value}")),
    }
    match epa::depth(a, b, scratch) {
        Verdict::Touching(found) if touches => {
            let relative = if case.category.is_thin() { 1e-6 } else { 1e-9 };
            let near = [relative * value + 32.0 * U * size(case), least(value)];
            let what = (found.depth, found.error_bound);
            faults.extend(measured("depth", what, (&truth, 1.0), near));
        }
        Verdict::Apart if !touches => {}
        Verdict::Undecided(_) if touches && !representable => {}
        found => faults.push(format!("{found:?}, in truth {value}")),
    }
    faults
}

/// Some denormal units, which is what is left of any digit near the least number.
fn least(value: f64) -> f64 {
    if value.abs() < 1e-290 { 4.0 * f64::from_bits(1) } else { 0.0 }
}

/// What is off in a number and its bound; `sign` turns the number into the truth's.
fn measured(
    name: &str,
    (found, bound): (f64, f64),
    (truth, sign): (&Truth, f64),
    [near, least]: [f64; 2],
) -> Vec<String> {
    let mut faults = Vec::new();
    let error = truth.less(sign * found).abs();
    if !(error <= near + least) {
        faults.push(format!("{name} {found} is off by {error}, more than {near}"));
    }
    if !bound.is_finite() {
        faults.push(format!("{name} {found} has the bound {bound}"));
    } else if !truth.is_within(sign * found - bound, sign * found + bound) && !(error <= bound) {
        faults.push(format!("{name} {found} ± {bound} does not hold {}", truth.value()));
    }
    faults
}

#[test]
fn the_certified_rung_is_right_on_the_whole_suite() {
    // The rung itself finds the neighbouring floats, which is quick; whatever it finds is judged.
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

#[test]
fn every_category_has_its_pairs_and_both_answers_where_it_can() {
    let mut counts = BTreeMap::<Category, [usize; 2]>::new();
    let cases = suite(2, &certified_touches);
    for case in &cases {
        let [a, b] = bodies(case);
        let (verdict, rung) = certified::overlap(a, b);
        assert!(rung <= Rung::Exact);
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
