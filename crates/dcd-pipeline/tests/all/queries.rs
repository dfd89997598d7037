//! Queries through the whole step: the same answers at any number of threads, and step after step.

use dcd_broad::WideTree;
use dcd_exec::with_threads;
use dcd_geom::glam::{DQuat, DVec3};
use dcd_geom::{Object, Pose, Scene, Shape};
use dcd_gjk::query::{ManifoldOptions, MeshEdges, MeshSides};
use dcd_gjk::{
    Accuracy, Contact, Depths, Distances, Manifolds, NarrowPhase, PairSolver, Proximities,
    ThenMeasure, Within,
};
use dcd_pipeline::{Answer, AnyPipeline, Par, Pipeline, Question};
use dcd_scenes::SceneSpec;

fn scene() -> Scene {
    SceneSpec::parse("paper").unwrap().with_objects(300).with_seed(5).scene().unwrap()
}

fn answers<N: NarrowPhase + Send>(narrow: N, scene: &Scene, par: Par) -> Vec<Contact<N::Answer>> {
    let mut pipeline = Pipeline::with(WideTree::default(), narrow);
    let first: Vec<_> = pipeline.step(scene, par).answers().collect();
    let second: Vec<_> = pipeline.step(scene, par).answers().collect();
    assert_eq!(first.len(), second.len());
    second
}

fn are_the_same_at_any_number_of_threads<S>(solver: S)
where
    S: PairSolver<Answer: PartialEq + std::fmt::Debug> + Copy + Send + 'static,
{
    for scene in [scene(), on_waves()] {
        let run = |par| answers(ThenMeasure::new(solver).unwrap(), &scene, par);
        let serial = run(Par::Serial);
        assert!(serial.len() > 100, "{}", serial.len());
        for threads in [1, 2, 5] {
            assert_eq!(with_threads(threads, || run(Par::Pool)).unwrap(), serial);
        }
    }
}

/// Spheres, boxes and compounds that are pressed into a mesh of waves.
fn on_waves() -> Scene {
    let (line, side) = (41, 14);
    let place = |k: u32| f64::from(k) * 0.35;
    let vertex = |i: u32, j: u32| {
        DVec3::new(place(i), place(j), 0.2 * (place(i) * 2.0).sin() * place(j).cos())
    };
    let vertices = (0..line).flat_map(|i| (0..line).map(move |j| vertex(i, j))).collect();
    let square = |i: u32, j: u32| {
        let [a, b] = [i * line + j, (i + 1) * line + j];
        [[a, b, b + 1], [a, b + 1, a + 1]]
    };
    let square = |i| (0..line - 1).flat_map(move |j| square(i, j));
    let mesh = Shape::mesh(vertices, (0..line - 1).flat_map(square).collect()).unwrap();
    let cuboid = Shape::cuboid(DVec3::new(0.4, 0.3, 0.2)).unwrap();
    let at = |x: f64| Pose::from_translation(DVec3::X * x).unwrap();
    let pair = Shape::compound(vec![(cuboid.clone(), at(-0.2)), (cuboid.clone(), at(0.3))]);
    let shapes = vec![mesh, cuboid, Shape::sphere(0.4).unwrap(), pair.unwrap()];
    let body = |k: u32| {
        let turn = DQuat::from_scaled_axis(DVec3::new(0.3, 0.1, 0.7) * f64::from(k % 5));
        let [x, y] = [k % side, k / side].map(|c| f64::from(c) + 0.4);
        Object::new(1 + k % 3, Pose::new(turn, DVec3::new(x, y, 0.15)).unwrap())
    };
    let ground = Object::new(0, Pose::IDENTITY);
    Scene::new(shapes, std::iter::once(ground).chain((0..side * side).map(body))).unwrap()
}

#[test]
fn every_query_reports_the_same_at_any_number_of_threads() {
    are_the_same_at_any_number_of_threads(Depths);
    are_the_same_at_any_number_of_threads(Manifolds::default());
    are_the_same_at_any_number_of_threads(Distances::within(0.05).unwrap());
    are_the_same_at_any_number_of_threads(Proximities::within(0.05).unwrap());
}

#[test]
fn a_margin_finds_more_pairs_and_all_of_the_touching_ones() {
    let scene = scene();
    let pairs = |margin: f64| -> Vec<_> {
        let contacts = answers(Within::margin(margin).unwrap(), &scene, Par::Serial);
        let mut pairs: Vec<_> = contacts.iter().map(|contact| contact.pair).collect();
        pairs.sort_unstable();
        pairs
    };
    let (touching, near) = (pairs(0.0), pairs(0.05));
    assert!(near.len() > touching.len());
    assert!(touching.iter().all(|pair| near.binary_search(pair).is_ok()));
}

#[test]
fn a_question_of_manifolds_takes_meshes_as_its_options_say() {
    let corners = vec![DVec3::new(-3.0, -3.0, 0.0), DVec3::X * 6.0, DVec3::Y * 6.0];
    let floor = Shape::mesh(corners, vec![[0, 1, 2]]).unwrap();
    let below = Pose::from_translation(DVec3::new(0.5, 0.5, -0.1)).unwrap();
    let shapes = vec![floor, Shape::sphere(0.2).unwrap()];
    let scene = Scene::one_each(shapes, vec![Pose::IDENTITY, below]).unwrap();
    let normals = |mesh_sides| {
        let options = ManifoldOptions { mesh_sides, mesh_edges: MeshEdges::All };
        let question = Question::Manifold { accuracy: Accuracy::F64, options };
        let mut pipeline = AnyPipeline::new(question).unwrap();
        let step = pipeline.step(&scene, Par::Serial);
        let found = step.answers().flat_map(|(_, answer)| {
            let Answer::Manifold(found) = answer else { panic!("{answer:?}") };
            found.iter().map(|manifold| manifold.normal.z.round()).collect::<Vec<_>>()
        });
        found.collect::<Vec<_>>()
    };
    assert_eq!(normals(MeshSides::Both), [-1.0]);
    assert_eq!(normals(MeshSides::Outward), [1.0]);
    assert_eq!(normals(MeshSides::Front), [0.0; 0]);
}
