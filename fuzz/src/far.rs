//! Shapes far from the origin of their own frame, brought together by their poses.

use crate::Input;
use crate::scene::{check, judged, kept, paths};
use dcd_exec::Par;
use dcd_geom::glam::DVec3;
use dcd_geom::{Aabb, Kind, Object, Polytope, Pose, Scene, Shape};
use dcd_gjk::{Overlap, PosedShape, Verdict, Within, certified};
use dcd_pipeline::{Pipeline, WideTree};

/// One more than the objects of a scene at most: every pair is judged singly.
const OBJECTS: u8 = 10;

/// How many pairs of a scene the exact judge checks, and of how many vertices each at most.
const JUDGED: (usize, usize) = (2, 8);

/// Compounds, meshes, curved, flat and rounded shapes that are up to 2⁶⁰ m from the origin of their
/// own frame. On each path the contacts are those of the certified solver, pair by pair and part by
/// part; so are the pairs within a margin; and the certified solver says of small polytopes what the exact judge
/// says.
pub fn far(bytes: &[u8]) {
    let mut input = Input(bytes);
    let Some(scene) = scene_of(&mut input) else { return };
    judge(&scene);
    check(&scene, &mut kept());
    if let Some(margin) = input.number() {
        check_within(&scene, margin);
    }
}

fn scene_of(input: &mut Input<'_>) -> Option<Scene> {
    let shapes = 1 + input.byte()? % 3;
    let shapes = (0..shapes).map(|_| moved(input)).collect::<Option<Vec<_>>>()?;
    let count = input.byte()? % OBJECTS;
    let objects = (0..count).map(|_| {
        let k = usize::from(input.byte()?) % shapes.len();
        let pose = input.pose()?;
        // Where the shape's origin would be without having been moved.
        let t = pose.translation() - *pose.rotation() * shapes[k].1;
        Some(Object::new(k as u32, Pose::from_matrix(*pose.rotation(), t).ok()?))
    });
    let objects = objects.collect::<Option<Vec<_>>>()?;
    Scene::new(shapes.iter().map(|(shape, _)| shape.clone()).collect(), objects).ok()
}

/// A shape, and by how much it was moved in its own frame.
fn moved(input: &mut Input<'_>) -> Option<(Shape, DVec3)> {
    let shape = input.shape()?;
    let by = input.vector()? * 2f64.powi(i32::from(input.byte()? % 57));
    let there = Pose::from_translation(by).ok()?;
    let moved = match &shape {
        Shape::Polytope(polytope) => {
            let points: Vec<DVec3> = polytope.vertices().iter().map(|&v| v + by).collect();
            let core = match (polytope.kind(), &points[..]) {
                (Kind::Segment, &[from, to]) => Polytope::segment(from, to),
                (Kind::Triangle, &[a, b, c]) => Polytope::triangle([a, b, c]),
                // Of a point so many copies that the sums of their mean are rounded.
                (Kind::Point, &[p]) => Polytope::hull(vec![p; 64]),
                _ => Polytope::hull(points),
            };
            core.ok()?.rounded(polytope.swept_radius()).ok()?.into()
        }
        Shape::Mesh(mesh) => {
            let points = mesh.vertices().iter().map(|&v| v + by).collect();
            let mesh_there = Shape::mesh(points, mesh.triangles().to_vec()).ok()?;
            mesh_there.rounded(mesh.swept_radius()).ok()?
        }
        Shape::Compound(compound) => {
            let parts = compound.parts().iter().map(|part| {
                let t = part.pose.translation() + by;
                Some((part.shape.clone(), Pose::from_matrix(*part.pose.rotation(), t).ok()?))
            });
            Shape::compound(parts.collect::<Option<_>>()?).ok()?
        }
        Shape::Curved(_) | Shape::Ellipsoid(_) => Shape::compound(vec![(shape, there)]).ok()?,
        _ => return Some((shape, DVec3::ZERO)),
    };
    Some((moved, by))
}

fn check_within(scene: &Scene, margin: f64) {
    let half = margin / 2.0;
    let shapes = scene.shapes().iter().map(|shape| shape.swept(half).ok());
    let Some(shapes) = shapes.collect::<Option<Vec<_>>>() else { return };
    let objects = scene.shape_of().iter().zip(scene.poses());
    let objects = objects.map(|(&shape, &pose)| Object::new(shape, pose));
    let Ok(grown) = Scene::new(shapes, objects) else { return };
    let truth = judged(&grown);
    for path in paths() {
        // A margin that no box holds is refused.
        let Ok(narrow) = Within::by(Overlap::on(path), margin) else {
            assert!(!(0.0..=Aabb::LIMIT).contains(&margin), "{margin}");
            return;
        };
        let mut pipeline = Pipeline::with(WideTree::default(), narrow);
        let step = pipeline.step(scene, Par::Serial);
        let known = step.contacts().filter(|pair| !truth.undecided.contains(pair));
        let mut touching: Vec<_> = known.collect();
        touching.sort_unstable();
        assert_eq!(touching, truth.touching, "{path:?}, within {margin}");
    }
}

/// What the certified solver says of the first pairs of small polytopes is what the exact judge says.
fn judge(scene: &Scene) {
    let (pairs, vertices) = JUDGED;
    let small = |i: usize| {
        let polytope = scene.shape(i).as_polytope()?;
        (polytope.vertices().len() <= vertices).then_some((polytope, &scene.poses()[i]))
    };
    let all = (0..scene.len()).flat_map(|i| (i + 1..scene.len()).map(move |j| (i, j)));
    let small = all.filter_map(|(i, j)| Some((i, j, small(i)?, small(j)?)));
    for (i, j, a, b) in small.take(pairs) {
        let placed = |i: usize| PosedShape { shape: scene.shape(i), pose: &scene.poses()[i] };
        let found = certified::overlap_of(placed(i), placed(j)).0;
        assert_eq!(found == Verdict::Touching(()), dcd_judge::touches(a, b), "{i}, {j}");
    }
}
