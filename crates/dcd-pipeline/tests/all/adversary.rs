//! Pairs moved by bisection to where the answer flips between neighbouring floats, and then to
//! either side by less and more than the rounding of f32: where the lanes would be wrong first.

use dcd_geom::glam::DVec3;
use dcd_geom::{Aabb, Kind, Pair, Polytope, Pose, Scene, Shape};
use dcd_gjk::{
    Contact, ContactSink, NarrowPhase, Overlap, PosedShape, PosedSupport, Prepared, Report, Sides,
    Verdict, certified,
};
use dcd_pipeline::{Par, Pipeline, WideTree};
use dcd_scenes::SceneSpec;
use dcd_scenes::conformance::{Case, Category, ShapePair, Slide, flip, shape_flip};
use dcd_simd::Path;

fn certified_touches(case: &Case) -> bool {
    let a = PosedSupport::polytope(&case.a, &case.pose_a);
    let b = PosedSupport::polytope(&case.b, &case.pose_b);
    certified::overlap(a, b).0 == Verdict::Touching(())
}

fn exactly_touches(case: &Case) -> bool {
    dcd_judge::touches((&case.a, &case.pose_a), (&case.b, &case.pose_b))
}

/// All cases in one scene, decided at once, so that the lanes hold sixteen different ones.
fn decided_by_lanes(cases: &[Case], path: Path) -> Vec<bool> {
    let shapes = cases.iter().flat_map(|case| [case.a.clone().into(), case.b.clone().into()]);
    let poses = cases.iter().flat_map(|case| [case.pose_a, case.pose_b]);
    let scene = Scene::one_each(shapes.collect::<Vec<Shape>>(), poses.collect()).unwrap();
    let (contacts, report) = decided(&scene, cases.len(), path);
    assert!(report.undecided().is_empty(), "{:?}", report.undecided());
    let mut touches = vec![false; cases.len()];
    for contact in contacts {
        touches[contact.pair.i as usize / 2] = true;
    }
    touches
}

/// Object 2k against object 2k + 1.
fn decided(scene: &Scene, pairs: usize, path: Path) -> (Vec<Contact<()>>, Report) {
    let pairs: Vec<Pair> = (0..pairs as u32).map(|k| Pair::new(2 * k, 2 * k + 1)).collect();
    let narrow = Overlap::on(path);
    let mut frame = <Overlap as NarrowPhase>::Frame::default();
    let mut aabbs = vec![Aabb::default(); scene.len()];
    let part = narrow.layout(scene, Sides::One, &mut frame);
    narrow.prepare(scene, 0, part, &mut aabbs);
    let (mut contacts, mut report) = (Vec::new(), Report::default());
    let mut sink = ContactSink { contacts: &mut contacts, report: &mut report };
    let side = Prepared { scene, frame: &frame };
    narrow.decide(side, side, &pairs, &mut Default::default(), &mut sink);
    (contacts, report)
}

/// Flips at a time.
const BATCH: usize = 256;

#[test]
fn twenty_thousand_answers_at_neighbouring_floats_are_right_by_the_exact_judge() {
    let mut flips = (0..).filter_map(|k| flip(1, k, &certified_touches)).take(10_000);
    let mut judged = 0;
    loop {
        let cases: Vec<Case> = flips.by_ref().take(BATCH).flatten().collect();
        if cases.is_empty() {
            break;
        }
        // The certified method said "touching" to the first of two and "apart" to the second.
        let truth: Vec<bool> = cases.iter().map(exactly_touches).collect();
        let wrong = truth.iter().enumerate().position(|(k, &touches)| touches != (k % 2 == 0));
        assert_eq!(wrong.map(|k| &cases[k]).map(|case| format!("{case:?}")), None);
        for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
            let found = decided_by_lanes(&cases, path);
            let wrong = (0..cases.len()).find(|&k| found[k] != truth[k]);
            assert_eq!(wrong.map(|k| &cases[k]).map(|case| format!("{case:?}")), None, "{path:?}");
        }
        judged += cases.len();
    }
    assert_eq!(judged, 20_000);
}

/// By the certified method; of cylinders and cones, which have none, by the judge.
fn shapes_touch(pair: &ShapePair) -> Option<bool> {
    if pair.is_curved() {
        return dcd_judge::shapes_touch((&pair.a, &pair.pose_a), (&pair.b, &pair.pose_b));
    }
    let a = PosedShape { shape: &pair.a, pose: &pair.pose_a };
    let b = PosedShape { shape: &pair.b, pose: &pair.pose_b };
    Some(certified::overlap_of(a, b).0 == Verdict::Touching(()))
}

/// What the lanes say of all pairs at once; `None` of those that they leave undecided.
fn shapes_decided_by_lanes(pairs: &[ShapePair], path: Path) -> Vec<Option<bool>> {
    let shapes = pairs.iter().flat_map(|pair| [pair.a.clone(), pair.b.clone()]);
    let poses = pairs.iter().flat_map(|pair| [pair.pose_a, pair.pose_b]);
    let scene = Scene::one_each(shapes.collect(), poses.collect()).unwrap();
    let (contacts, report) = decided(&scene, pairs.len(), path);
    let mut touches = vec![Some(false); pairs.len()];
    for contact in contacts {
        touches[contact.pair.i as usize / 2] = Some(true);
    }
    for undecided in report.undecided() {
        touches[undecided.pair.i as usize / 2] = None;
    }
    touches
}

#[test]
fn shapes_of_every_kind_are_right_at_neighbouring_floats_by_the_exact_judge() {
    let mut flips = (0..).filter_map(|k| shape_flip(1, k, &shapes_touch)).take(1_500);
    let (mut judged, mut open) = (0, 0);
    loop {
        let pairs: Vec<ShapePair> = flips.by_ref().take(BATCH).flatten().collect();
        if pairs.is_empty() {
            break;
        }
        for (k, pair) in pairs.iter().enumerate() {
            let truth = dcd_judge::shapes_touch((&pair.a, &pair.pose_a), (&pair.b, &pair.pose_b));
            assert_eq!(truth, Some(k % 2 == 0), "{pair:?}");
        }
        for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
            for (k, found) in shapes_decided_by_lanes(&pairs, path).into_iter().enumerate() {
                // What is curved has no exact method: it may be left open, and is never wrong.
                let truth = (k % 2 == 0, pairs[k].is_curved());
                match (found, truth) {
                    (Some(found), (truth, _)) => {
                        assert_eq!(found, truth, "{path:?} {:?}", pairs[k])
                    }
                    (None, (_, is_curved)) => assert!(is_curved, "{path:?} {:?}", pairs[k]),
                }
                open += usize::from(found.is_none());
            }
        }
        judged += pairs.len();
    }
    assert_eq!(judged, 3_000);
    assert!(open > 0, "no cylinder or cone was near enough");
}

/// How far from the flip, in units of f32's roundoff of the pair's size.
const STEPS: [f64; 9] = [0.0, 0.1, 0.5, 1.0, 3.0, 10.0, 30.0, 100.0, 1000.0];

/// A shape of the same kind, that much larger.
fn scaled(polytope: &Polytope, scale: f64) -> Polytope {
    let vertices = || polytope.vertices().iter().map(|&v| v * scale).collect::<Vec<_>>();
    let core = match polytope.kind() {
        Kind::Cuboid { half_extents } => Polytope::cuboid(half_extents * scale),
        Kind::Point => Polytope::sphere(0.0),
        Kind::Segment => Polytope::segment(vertices()[0], vertices()[1]),
        _ => Polytope::hull(vertices()),
    };
    core.and_then(|core| core.rounded(polytope.swept_radius() * scale)).unwrap()
}

/// Every object against the one `next` places later.
fn attack(name: &str, next: usize, scale: f64, offset: f64) {
    let objects = 120;
    let scene = SceneSpec::parse(name).unwrap().with_objects(objects).with_seed(9).scene().unwrap();
    let scaled = |i: usize| scaled(scene.shape(i).as_polytope().unwrap(), scale);
    let mut flips = 0;
    for i in 0..objects - next {
        let (a, b) = (scaled(i), scaled(i + next));
        // Both centres at one place, so that every line starts in an overlap.
        let at = |k: usize, polytope: &Polytope| {
            let rotation = *scene.poses()[k].rotation();
            let t = DVec3::splat(offset) - rotation * polytope.inner().centre;
            Pose::from_matrix(rotation, t).unwrap()
        };
        let along =
            (scene.poses()[i].translation() - scene.poses()[i + next].translation()) * scale;
        let radii = a.swept_radius() + b.swept_radius();
        let unit = 2f64.powi(-24) * (a.reach() + b.reach() + radii) / along.length();
        let poses = [at(i, &a), at(i + next, &b)];
        let from = Case::new(Category::Overlap, [(a, poses[0]), (b, poses[1])]);
        let slide = Slide::new(from, along);
        let Some(flip) = slide.flip(1e3, &certified_touches) else { continue };
        flips += 1;
        let sides =
            STEPS.iter().flat_map(|step| [flip + step * unit, flip.next_up() - step * unit]);
        for s in sides.chain([flip, flip.next_up()]).filter(|s| *s >= 0.0) {
            let case = slide.at(s).unwrap();
            let truth = certified_touches(&case);
            let shapes = vec![Shape::from(case.a), Shape::from(case.b)];
            let pair = Scene::one_each(shapes, vec![case.pose_a, case.pose_b]).unwrap();
            for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
                let mut pipeline = Pipeline::with(WideTree::on(path), Overlap::on(path));
                let found = pipeline.step(&pair, Par::Serial).contact_count() == 1;
                assert_eq!(found, truth, "{name} {scale} {offset}: pair {i} at {s} on {path:?}");
            }
        }
    }
    assert!(flips > objects / 4, "{name}: only {flips} pairs flipped");
}

#[test]
fn the_lanes_are_right_on_both_sides_of_every_flip() {
    for name in ["paper", "needles", "plates"] {
        for scale in [1e-6, 1.0, 1e6] {
            attack(name, 1, scale, 0.0);
        }
    }
}

#[test]
fn the_lanes_are_right_on_both_sides_of_every_flip_far_from_the_origin() {
    for name in ["paper", "plates"] {
        attack(name, 1, 1.0, 1e5);
        attack(name, 1, 1.0, 1e9);
    }
}

#[test]
fn closed_forms_are_right_on_both_sides_of_every_flip() {
    for (scale, offset) in [(1e-6, 0.0), (1.0, 0.0), (1e6, 0.0), (1.0, 1e5), (1.0, 1e9)] {
        attack("spheres", 1, scale, offset);
        attack("cuboids", 1, scale, offset);
    }
}

#[test]
fn rounded_shapes_are_right_on_both_sides_of_every_flip() {
    // Four kinds in a cycle: the next is of another kind, the fourth of the same.
    for next in 1..=4 {
        for (scale, offset) in [(1e-6, 0.0), (1.0, 0.0), (1e6, 0.0), (1.0, 1e5)] {
            attack("mixed", next, scale, offset);
        }
    }
}
