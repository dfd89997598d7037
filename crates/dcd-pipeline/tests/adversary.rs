//! Pairs moved by bisection to where the answer flips between neighbouring floats, and then to
//! either side by less and more than the rounding of f32: where the lanes would be wrong first.

use dcd_geom::glam::DVec3;
use dcd_geom::lanes::Path;
use dcd_geom::{Polytope, Pose, Scene, Shape};
use dcd_gjk::{Body, Overlap, Verdict, certified};
use dcd_pipeline::{Par, Pipeline, WideTree};
use dcd_scenes::SceneSpec;

/// A pair whose second body slides along a line.
struct Slide<'a> {
    a: &'a Polytope,
    at_a: Pose,
    b: &'a Polytope,
    from: Pose,
    along: DVec3,
}

impl Slide<'_> {
    fn pose(&self, s: f64) -> Pose {
        let t = self.from.translation() + self.along * s;
        Pose::from_matrix(*self.from.rotation(), t).unwrap()
    }

    fn touches(&self, s: f64) -> bool {
        let at_b = self.pose(s);
        let verdict =
            certified::overlap(Body::polytope(self.a, &self.at_a), Body::polytope(self.b, &at_b)).0;
        verdict == Verdict::Touching(())
    }

    /// The last s that touches; the next float does not. `None` if the line starts apart.
    fn flip(&self, far: f64) -> Option<f64> {
        let (mut near, mut far) = (0.0_f64, far);
        if !self.touches(near) || self.touches(far) {
            return None;
        }
        while near.next_up() < far {
            // Halfway in bits, so that the end is two neighbouring floats.
            let middle = f64::from_bits(near.to_bits() + (far.to_bits() - near.to_bits()) / 2);
            if self.touches(middle) { near = middle } else { far = middle }
        }
        Some(near)
    }
}

/// How far from the flip, in units of f32's roundoff of the pair's size.
const STEPS: [f64; 9] = [0.0, 0.1, 0.5, 1.0, 3.0, 10.0, 30.0, 100.0, 1000.0];

fn attack(name: &str, scale: f64, offset: f64) {
    let objects = 120;
    let scene = SceneSpec::parse(name).unwrap().with_objects(objects).with_seed(9).scene().unwrap();
    let scaled = |i: usize| {
        let polytope = scene.shape(i).as_polytope().unwrap();
        Polytope::hull(polytope.vertices().iter().map(|&v| v * scale).collect()).unwrap()
    };
    let mut flips = 0;
    for i in 0..objects - 1 {
        let (a, b) = (scaled(i), scaled(i + 1));
        // Both centres at one place, so that every line starts in an overlap.
        let at = |k: usize, polytope: &Polytope| {
            let rotation = *scene.poses()[k].rotation();
            let t = DVec3::splat(offset) - rotation * polytope.inner().centre;
            Pose::from_matrix(rotation, t).unwrap()
        };
        let along = (scene.poses()[i].translation() - scene.poses()[i + 1].translation()) * scale;
        let slide = Slide { a: &a, at_a: at(i, &a), b: &b, from: at(i + 1, &b), along };
        let Some(flip) = slide.flip(1e3) else { continue };
        flips += 1;
        let unit = 2f64.powi(-24) * (a.reach() + b.reach()) / along.length();
        let sides =
            STEPS.iter().flat_map(|step| [flip + step * unit, flip.next_up() - step * unit]);
        for s in sides.chain([flip, flip.next_up()]).filter(|s| *s >= 0.0) {
            let truth = slide.touches(s);
            let shapes = vec![Shape::from(a.clone()), Shape::from(b.clone())];
            let pair = Scene::one_each(shapes, vec![slide.at_a, slide.pose(s)]).unwrap();
            for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
                let mut pipeline = Pipeline::new(WideTree::on(path), Overlap::on(path));
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
            attack(name, scale, 0.0);
        }
    }
}

#[test]
fn the_lanes_are_right_on_both_sides_of_every_flip_far_from_the_origin() {
    for name in ["paper", "plates"] {
        attack(name, 1.0, 1e5);
        attack(name, 1.0, 1e9);
    }
}
