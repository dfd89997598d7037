//! Scenes of all kinds of shapes, of sizes far apart, at any rank, within margins far above and far below them: beside every pair
//! alone, and beside the exact judge.

use super::scenes::Draw;
use super::within::found;
use dcd_geom::glam::{DQuat, DVec3};
use dcd_geom::{Object, Pair, Polytope, Pose, Scene, Shape};
use dcd_gjk::distance::distance;
use dcd_gjk::{
    Accuracy, Contact, Depths, DistanceResult, PairSolver, PosedShape, SimdDepths, SimdDistances,
    Verdict,
};
use dcd_simd::Path;

/// A shape of about that size.
fn shape(draw: &mut Draw, k: usize, size: f64) -> Shape {
    let half = draw.vector().abs() * size + 0.01 * size;
    let mut cloud =
        |count: usize| -> Vec<DVec3> { (0..count).map(|_| draw.vector() * size).collect() };
    let made = match k % 14 {
        0 | 13 => Shape::sphere(half.x),
        1 | 12 => Shape::cuboid(half),
        2 => Shape::capsule(half.x, half.y),
        3 => Shape::cylinder(half.x, half.y),
        4 => Shape::cone(half.x, half.y),
        5 => Shape::ellipsoid(half),
        6 => Shape::hull(cloud(8)),
        7 => Shape::hull(cloud(40)),
        8 => Shape::mesh(cloud(7), vec![[0, 1, 2], [2, 3, 4], [4, 5, 6]]),
        9 => {
            let at = |x: f64| Pose::from_translation(DVec3::X * x).unwrap();
            let parts = vec![
                (Shape::cuboid(half).unwrap(), at(0.5 * size)),
                (Shape::sphere(half.y).unwrap(), at(-0.5 * size)),
            ];
            Shape::compound(parts)
        }
        10 => Shape::triangle([half, DVec3::X * size, DVec3::NEG_Y * half.z]),
        _ => Shape::hull(cloud(6)).and_then(|hull| hull.rounded(0.1 * size)),
    };
    made.unwrap()
}

/// Objects that are beside an earlier one each, touching it or not.
fn scene(draw: &mut Draw, round: usize, unit: f64) -> Scene {
    let shapes: Vec<Shape> = (0..28)
        .map(|k| {
            let size = unit * [1.0, 1e-3, 30.0][(k + round) % 3];
            shape(draw, k, size)
        })
        .collect();
    let far = draw.vector() * unit * [0.0, 1e3][round / 4 % 2];
    let mut objects: Vec<Object> = Vec::new();
    for k in 0..44usize {
        let turn = if k % 4 == 0 { DQuat::IDENTITY } else { draw.turn() };
        let kind = (k * 5 + round) % shapes.len();
        let place = match objects.get(k / 2) {
            Some(other) => {
                let reach = shapes[other.shape as usize].reach() + shapes[kind].reach();
                let way = draw.vector().normalize() * reach * (0.3 + 0.6 * draw.unit().abs());
                other.pose.translation() + way
            }
            None => far + draw.vector() * unit,
        };
        objects.push(Object::new(kind as u32, Pose::new(turn, place).unwrap()));
    }
    Scene::new(shapes, objects).unwrap()
}

/// Whether a distance is between two bounds, by the exact judge; nothing of shapes that it does not know or that have many vertices.
fn judged(scene: &Scene, pair: Pair, low: f64, high: f64) -> Option<bool> {
    let of = |object: u32| -> Option<(&Polytope, &Pose)> {
        let polytope = scene.shape(object as usize).as_polytope()?;
        (polytope.vertices().len() <= 8).then_some((polytope, &scene.poses()[object as usize]))
    };
    Some(dcd_judge::distance_is_in(of(pair.i)?, of(pair.j)?, low, high))
}

#[test]
fn distances_and_depths_of_any_rank_hold_beside_every_pair_alone_and_the_judge() {
    let mut draw = Draw::seeded(103);
    let mut counts = [0; 4];
    for round in 0..8 {
        let unit = [1.0, 1e-6, 1e6, 1e-3][round % 4];
        let scene = scene(&mut draw, round, unit);
        let count = scene.len() as u32;
        let pairs: Vec<Pair> =
            (0..count).flat_map(|i| (i + 1..count).map(move |j| Pair::new(i, j))).collect();
        let posed = |pair: Pair| [pair.i, pair.j].map(|object| PosedShape::of(&scene, object));
        let truth: Vec<DistanceResult> = pairs
            .iter()
            .map(|&pair| {
                let [a, b] = posed(pair);
                distance(a, b).0
            })
            .collect();
        let margin = unit * [0.0, 1e-9, 0.3, 1e4][(round / 4 + round) % 4];
        for accuracy in [Accuracy::F32, Accuracy::F64, Accuracy::Certified] {
            let said = format!("round {round}, {accuracy:?}, within {margin:e}");
            let on = |path| SimdDistances::on(path, margin, accuracy).unwrap();
            let (near, report) = found(&on(Path::best()), &scene, &pairs);
            for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
                assert!(found(&on(path), &scene, &pairs).0 == near, "{said}, {path:?}");
            }
            let mut near = near.iter().peekable();
            for (&pair, truth) in pairs.iter().zip(&truth) {
                let answer = near.next_if(|contact| contact.pair == pair).map(|c| c.answer);
                let is_open = report.undecided().iter().any(|undecided| undecided.pair == pair);
                let said = format!("{said}: {pair:?} {answer:?} {truth:?}");
                match (answer, truth) {
                    (None, DistanceResult::Touching) => assert!(is_open, "{said}"),
                    (None, DistanceResult::Apart(due)) => {
                        assert!(is_open || due.upper() > margin, "{said}")
                    }
                    (Some(None), DistanceResult::Apart(due)) => panic!("{said} {due:?}"),
                    (Some(Some(found)), DistanceResult::Touching) => {
                        assert!(found.lower() == 0.0, "{said}");
                    }
                    (Some(Some(found)), DistanceResult::Apart(due)) => {
                        let meet = found.lower() <= due.upper() && due.lower() <= found.upper();
                        assert!(meet && found.lower() <= margin, "{said}");
                        if (pair.i + pair.j + round as u32).is_multiple_of(11)
                            && let Some(is_in) = judged(&scene, pair, found.lower(), found.upper())
                        {
                            assert!(is_in, "{said}");
                            counts[2] += 1;
                        }
                        counts[0] += 1;
                    }
                    _ => counts[3] += 1,
                }
            }
            assert!(near.next().is_none(), "{said}");
            let on = |path| SimdDepths::on(path, Depths, accuracy);
            let (deep, _) = found(&on(Path::best()), &scene, &pairs);
            for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
                assert!(found(&on(path), &scene, &pairs).0 == deep, "{said}, {path:?}");
            }
            for Contact { pair, answer } in &deep {
                let [a, b] = posed(*pair);
                let Verdict::Touching(due) = Depths.solve(a, b, &mut Default::default()) else {
                    panic!("{said}: {pair:?}")
                };
                let off = (answer.depth - due.depth).abs();
                assert!(
                    off <= answer.error_bound + due.error_bound,
                    "{said}: {pair:?} {answer:?} {due:?}"
                );
                counts[1] += 1;
            }
        }
    }
    assert!(counts[..3].iter().all(|&count| count > 50), "{counts:?}");
}
