//! The contract of narrow phases on scenes with shapes of every kind: the library's own keep it, and
//! what breaks it is caught.

mod judge;

use dcd_geom::contract::Violation;
use dcd_geom::glam::DVec3;
use dcd_geom::{Aabb, Object, Pair, Pose, Scene, Shape};
use dcd_gjk::simplify::InnerOuter;
use dcd_gjk::{
    Accuracy, BoundsOnly, Certified, Coherent, ContactSink, Depths, Distances, Gjk, Manifolds,
    Method, NarrowPhase, Overlap, OverlapUnchecked, PairSolver, Pairwise, PosedShape, Prepared,
    Proximities, Sides, SimdDepths, SimdDistances, ThenMeasure, Verdict, Within, contract,
};
use dcd_simd::Path;
use judge::cases::Draw;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

/// One of each kind that has no vertices of its own, or many parts, and two that have.
fn shapes() -> Vec<Shape> {
    let cube = Shape::cuboid(DVec3::new(0.5, 0.4, 0.3)).unwrap();
    let there = |x: f64| Pose::from_translation(DVec3::X * x).unwrap();
    let parts = vec![
        (cube.clone(), there(-0.5)),
        (Shape::cylinder(0.4, 0.2).unwrap(), there(0.6)),
        (Shape::sphere(0.3).unwrap(), there(1.0)),
    ];
    let corners = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(1.0, 1.0, 0.2)];
    let triangles = vec![[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 4, 2]];
    vec![
        Shape::compound(parts).unwrap(),
        Shape::mesh(corners, triangles).unwrap().rounded(0.05).unwrap(),
        Shape::half_space(DVec3::Z, -1.2).unwrap().rounded(0.25).unwrap(),
        Shape::half_space(DVec3::new(0.3, 0.2, 1.0), -2.0).unwrap(),
        Shape::cone(0.5, 0.3).unwrap(),
        Shape::capsule(0.3, 0.2).unwrap(),
        cube,
    ]
}

fn scene() -> (Scene, Vec<Pair>) {
    let mut draw = Draw(41);
    let shapes = shapes();
    let count = 3 * shapes.len() as u32;
    let objects: Vec<Object> = (0..count)
        .map(|k| {
            let shape = k % shapes.len() as u32;
            // One floor that lies level, whose box ends above.
            let level = k == 2;
            let rotation = draw.rotation();
            let pose = match level {
                true => Pose::IDENTITY,
                false => Pose::new(rotation, draw.vector() * 1.5).unwrap(),
            };
            Object::new(shape, pose)
        })
        .collect();
    let pairs = (0..count).flat_map(|i| (i + 1..count).map(move |j| Pair::new(i, j)));
    (Scene::new(shapes, objects).unwrap(), pairs.collect())
}

fn contract_of<N>(narrow: &N) -> Result<(), Violation>
where
    N: NarrowPhase,
    N::Answer: PartialEq + std::fmt::Debug,
{
    let (scene, pairs) = scene();
    contract::narrow_phase(narrow, &scene, &pairs)
}

#[test]
fn every_phase_of_our_own_keeps_the_contract_among_compounds_meshes_and_half_spaces() {
    for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
        contract_of(&Overlap::on(path)).unwrap();
        contract_of(&OverlapUnchecked::on(path)).unwrap();
        contract_of(&Coherent::on(path)).unwrap();
        contract_of(&Within::by(Overlap::on(path), 0.25).unwrap()).unwrap();
        for accuracy in [Accuracy::F32, Accuracy::F64, Accuracy::Certified] {
            contract_of(&SimdDistances::on(path, 0.25, accuracy).unwrap()).unwrap();
        }
        contract_of(&SimdDepths::on(path, Depths, Accuracy::F32)).unwrap();
        contract_of(&SimdDepths::on(path, Manifolds::default(), Accuracy::Certified)).unwrap();
    }
    contract_of(&Pairwise(Gjk::<f32>::default())).unwrap();
    contract_of(&Pairwise(Gjk::<f64>::default())).unwrap();
    contract_of(&Pairwise(Certified)).unwrap();
    contract_of(&Pairwise(BoundsOnly)).unwrap();
    contract_of(&Pairwise(Distances::within(0.25).unwrap())).unwrap();
    contract_of(&Pairwise(Proximities::within(0.25).unwrap())).unwrap();
    contract_of(&Pairwise(Depths)).unwrap();
    contract_of(&Pairwise(Manifolds::default())).unwrap();
    contract_of(&ThenMeasure::new(Distances::within(0.25).unwrap()).unwrap()).unwrap();
    contract_of(&ThenMeasure::new(Depths).unwrap()).unwrap();
    contract_of(&ThenMeasure::new(Manifolds::default()).unwrap()).unwrap();
    contract_of(&ThenMeasure::new(Proximities::within(0.25).unwrap()).unwrap()).unwrap();
    contract_of(&Within::by(Pairwise(Certified), 0.25).unwrap()).unwrap();
    let inner = shapes().into_iter().map(|shape| match shape {
        Shape::Polytope(cube) => Shape::from(Arc::unwrap_or_clone(cube).rounded(0.0).unwrap()),
        other => other,
    });
    contract_of(&InnerOuter::new(inner.collect())).unwrap();
}

/// Our own, but the box of one object is cut on one side by so much.
struct Cut {
    object: usize,
    side: usize,
    by: f32,
}

impl NarrowPhase for Cut {
    type Answer = ();
    type Frame = <Overlap as NarrowPhase>::Frame;
    type Part<'f> = <Overlap as NarrowPhase>::Part<'f>;
    type Scratch = <Overlap as NarrowPhase>::Scratch;

    fn layout<'f>(
        &self,
        scene: &Scene,
        sides: Sides,
        frame: &'f mut Self::Frame,
    ) -> Self::Part<'f> {
        Overlap::default().layout(scene, sides, frame)
    }

    fn prepare(&self, scene: &Scene, first: usize, part: Self::Part<'_>, aabbs: &mut [Aabb]) {
        Overlap::default().prepare(scene, first, part, aabbs);
        let own = self.object.checked_sub(first).and_then(|k| aabbs.get_mut(k));
        if let Some(aabb) = own {
            match self.side {
                0..3 => aabb.min[self.side] += self.by,
                _ => aabb.max[self.side - 3] -= self.by,
            }
        }
    }

    fn decide(
        &self,
        a: Prepared<'_, Self::Frame>,
        b: Prepared<'_, Self::Frame>,
        pairs: &[Pair],
        scratch: &mut Self::Scratch,
        sink: &mut ContactSink<'_, ()>,
    ) {
        Overlap::default().decide(a, b, pairs, scratch, sink);
    }
}

#[test]
fn a_box_that_is_cut_is_caught_whatever_kind_of_shape_it_is_of() {
    let kinds = shapes().len();
    for side in 0..6 {
        for object in 0..kinds {
            // A floor has an end above alone; its box is wide.
            let by = if (2..4).contains(&object) { 3e38 } else { 1e-3 };
            let refused = contract_of(&Cut { object, side, by });
            assert!(refused.is_err(), "side {side} of object {object}");
        }
        contract_of(&Cut { object: 0, side, by: 0.0 }).unwrap();
    }
    // The plane of the level one, which a thousandth is enough to cut.
    assert!(contract_of(&Cut { object: 2, side: 5, by: 1e-3 }).is_err());
}

/// Returns the contrary verdict for one pair in some hundred when it is solved again.
#[derive(Default)]
struct Forgetful(AtomicU32);

impl PairSolver for Forgetful {
    type Answer = ();
    type Scratch = ();

    fn method(&self) -> Method {
        Method::Foreign
    }

    fn solve(&self, a: PosedShape<'_>, b: PosedShape<'_>, (): &mut ()) -> Verdict<()> {
        let calls = self.0.fetch_add(1, Ordering::Relaxed);
        match Certified.solve(a, b, &mut Default::default()) {
            Verdict::Touching(()) if calls % 127 == 126 => Verdict::Apart,
            Verdict::Apart if calls % 127 == 126 => Verdict::Touching(()),
            verdict => verdict,
        }
    }
}

#[test]
fn a_phase_whose_answers_change_is_caught_among_shapes_of_every_kind() {
    assert!(contract_of(&Pairwise(Forgetful::default())).is_err());
}
