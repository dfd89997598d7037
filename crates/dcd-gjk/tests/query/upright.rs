//! Cuboids along the world's axes whose numbers are whole, times a power of two: whether they touch, are within a margin, and
//! how deep they overlap are comparisons of whole numbers.

use super::lane_parts::manifolds;
use super::scenes::Draw;
use super::within::found;
use dcd_geom::glam::{DMat3, DVec3};
use dcd_geom::{Object, Pair, Pose, Scene, Shape};
use dcd_gjk::{Accuracy, Contact, Depths, Manifolds, Overlap, SimdDepths, SimdDistances};
use dcd_simd::Path;

/// A cuboid: twice its middle, its edges along the world's axes, and the shape that it is of.
struct Upright {
    middle: [i64; 3],
    edges: [i64; 3],
    shape: usize,
    turn: usize,
}

/// How far two are apart along each axis: below 0 where they overlap.
fn gaps(a: &Upright, b: &Upright) -> [i64; 3] {
    [0, 1, 2].map(|k| (a.middle[k] - b.middle[k]).abs() - a.edges[k] - b.edges[k])
}

fn turns() -> [DMat3; 4] {
    let quarter = DMat3::from_cols(DVec3::Y, -DVec3::X, DVec3::Z);
    let third = DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X);
    [DMat3::IDENTITY, quarter, third, quarter * third]
}

/// The scene of one of them a quarter of which touch an earlier one, or are a margin apart from it, exactly or but for one.
fn pile(draw: &mut Draw, unit: f64, margin: i64, others: &[Shape]) -> (Scene, Vec<Upright>) {
    let mut below = |most: i64| ((draw.unit() + 1.0) * 0.5 * most as f64) as i64;
    let edges: Vec<[i64; 3]> = (0..5)
        .map(|k| [0; 3].map(|_| if k == 4 { 1 } else { 0 } + below([9, 1 << 10, 1 << 20][k % 3])))
        .collect();
    let mut all: Vec<Upright> = Vec::new();
    for k in 0..36usize {
        let (shape, turn) = (k % 5, below(4) as usize);
        let own = DVec3::from(edges[shape].map(|x| x as f64));
        let turned = (turns()[turn] * own).abs();
        let edges = turned.to_array().map(|x| x as i64);
        let mut middle = [0; 3].map(|_| below(1 << 21));
        if k > 5 {
            let other = &all[below(k as i64) as usize];
            // By 0 or a margin along one axis, or by 3 and 4 fifths, or 2, 3 and 6 sevenths of it along several.
            let ways = [[1, 0, 0], [0, -1, 0], [3, 4, 0], [2, -3, 6]];
            let lengths = [1, 1, 5, 7];
            let which = below(4) as usize;
            for axis in 0..3 {
                let way = ways[which][axis];
                let gap = 2 * margin * way / lengths[which] + below(3) - 1;
                let reach = other.edges[axis] + edges[axis];
                middle[axis] = other.middle[axis]
                    + match way {
                        0 => below(3) - 1,
                        _ if k % 3 == 0 => way.signum() * reach,
                        _ => way.signum() * reach + gap,
                    };
            }
        }
        all.push(Upright { middle, edges, shape, turn });
    }
    let cuboids = edges
        .iter()
        .map(|edges| Shape::cuboid(DVec3::from(edges.map(|x| x as f64)) * 0.5 * unit).unwrap());
    let objects = all.iter().map(|one| {
        let place = DVec3::from(one.middle.map(|x| x as f64)) * 0.5 * unit;
        Object::new(one.shape as u32, Pose::from_matrix(turns()[one.turn], place).unwrap())
    });
    let objects = objects.collect::<Vec<_>>();
    (Scene::new(cuboids.chain(others.iter().cloned()).collect(), objects).unwrap(), all)
}

#[test]
fn upright_cuboids_are_near_and_deep_as_whole_numbers_say() {
    let mut draw = Draw::seeded(101);
    let mut counts = [0; 4];
    for round in 0..36 {
        let unit = [1.0, 2f64.powi(-40), 2f64.powi(19)][round % 3];
        let margin = [0, 35, 7 << 12][round / 3 % 3];
        // Alone they have no vertices in the lanes.
        let others = if round % 2 == 0 { vec![] } else { vec![Shape::sphere(unit).unwrap()] };
        let (scene, all) = pile(&mut draw, unit, margin, &others);
        let count = all.len() as u32;
        let pairs: Vec<Pair> =
            (0..count).flat_map(|i| (i + 1..count).map(move |j| Pair::new(i, j))).collect();
        let of = |pair: &Pair| gaps(&all[pair.i as usize], &all[pair.j as usize]);
        // Twice the numbers.
        let beyond = |pair: &Pair, margin: i64| {
            let squares = of(pair).map(|gap| i128::from(gap.max(0)).pow(2));
            squares.iter().sum::<i128>() - i128::from(2 * margin).pow(2)
        };
        let due = |margin: i64| pairs.iter().copied().filter(move |pair| beyond(pair, margin) <= 0);
        for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
            let (touching, _) = found(&Overlap::on(path), &scene, &pairs);
            assert!(touching.iter().map(|c| c.pair).eq(due(0)), "round {round}, {path:?}");
            for accuracy in [Accuracy::F32, Accuracy::F64, Accuracy::Certified] {
                let said = format!("round {round}, {path:?} {accuracy:?}");
                let narrow = SimdDistances::on(path, margin as f64 * unit, accuracy).unwrap();
                let (near, _) = found(&narrow, &scene, &pairs);
                assert!(near.iter().map(|c| c.pair).eq(due(margin)), "{said}");
                for Contact { pair, answer } in &near {
                    assert_eq!(answer.is_none(), beyond(pair, 0) <= 0, "{said}: {pair:?}");
                    if let Some(found) = answer {
                        let truth = (beyond(pair, 0) as f64).sqrt() * 0.5 * unit;
                        let off = (found.distance - truth).abs();
                        let bound = found.error_bound * 1.01 + 4.0 * f64::EPSILON * truth;
                        assert!(off <= bound, "{said}: {pair:?} {found:?} {truth}");
                    }
                }
                let (deep, _) = found(&SimdDepths::on(path, Depths, accuracy), &scene, &pairs);
                assert!(deep.iter().map(|c| c.pair).eq(due(0)), "{said}");
                for Contact { pair, answer } in &deep {
                    let truth =
                        of(pair).map(|gap| -gap).into_iter().min().unwrap() as f64 * 0.5 * unit;
                    let off = (answer.depth - truth).abs();
                    assert!(off <= answer.error_bound, "{said}: {pair:?} {answer:?} {truth}");
                }
                let (sets, _) =
                    found(&SimdDepths::on(path, Manifolds::default(), accuracy), &scene, &pairs);
                assert!(sets.iter().map(|c| c.pair).eq(due(0)), "{said}");
                counts[0] += near.len();
                counts[1] += deep.len();
            }
        }
        counts[2] += pairs.iter().filter(|pair| beyond(pair, margin) == 0).count();
        counts[3] += pairs.iter().filter(|pair| of(pair).into_iter().max() == Some(0)).count();
    }
    assert!(counts.iter().all(|&count| count > 30), "{counts:?}");
}

#[test]
fn a_plate_has_four_points_however_thin_it_is() {
    for power in [10, 29, 30, 31, 36, 37, 38, 60, 300] {
        let half = DVec3::new(1.0, 1.0, 2f64.powi(-power));
        let shapes = [Shape::cuboid(half).unwrap(), Shape::cuboid(DVec3::ONE).unwrap()];
        for turn in turns() {
            let poses = [DVec3::ZERO, DVec3::new(0.5, 0.0, 1.0)]
                .map(|place| Pose::from_matrix(turn, turn * place).unwrap());
            let scene = Scene::one_each(shapes.to_vec(), poses.to_vec()).unwrap();
            for accuracy in [Accuracy::F32, Accuracy::F64, Accuracy::Certified] {
                for set in manifolds(&scene, accuracy) {
                    let points: usize = set.iter().map(|manifold| manifold.points().len()).sum();
                    assert_eq!((set.len(), points), (1, 4), "{power} {accuracy:?} {set:?}");
                }
            }
        }
    }
}
