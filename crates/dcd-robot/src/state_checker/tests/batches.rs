//! States in batches of every size, at several numbers of threads, beside every pair decided and measured alone.

use super::*;
use crate::Padding;
use dcd_geom::Curved;
use dcd_gjk::{Depths, DistanceResult, distance};
use std::sync::Arc;

/// An obstacle of any kind, those of which the lanes know little among them.
fn any_shape(draw: &mut Draw) -> Shape {
    let (kind, size) = (draw.below(8), draw.size(0.05, 0.4));
    let mut cloud = |count: u32| (0..count).map(|_| draw.vector() * size).collect::<Vec<_>>();
    let made = match kind {
        0 => Shape::ellipsoid(cloud(1)[0].abs()),
        1 => Shape::hull(cloud(150)),
        2 => Shape::hull(cloud(3)),
        3 => Shape::cuboid(DVec3::new(size, 0.5 * size, 0.0)),
        4 => Shape::custom(Arc::new(Curved::cylinder(size, 0.5 * size).unwrap())),
        _ => return shape(draw),
    };
    made.unwrap()
}

/// A robot of any kind that carries shapes of any kind, some links padded and scaled, in a world of few or many obstacles.
fn equipped(draw: &mut Draw, round: usize) -> Workcell {
    let robot = robot(draw, round.is_multiple_of(3));
    let mut world = world(draw, &robot);
    for (k, name) in ["held", "other"].into_iter().enumerate().take(draw.below(3) as usize) {
        let shapes: Vec<_> = (0..=k).map(|_| (any_shape(draw), draw.pose(0.3))).collect();
        world.attach(Attached::new(name, &format!("l{}", 1 + k), shapes), ["l0"]);
    }
    for obstacle in &mut world.obstacles {
        obstacle.shape = any_shape(draw);
    }
    for link in robot.links() {
        if draw.below(5) == 0 {
            let (scale, padding) = (draw.size(0.8, 1.2), draw.size(0.0, 0.05));
            // What is known by its support map alone has no scale.
            let is_foreign = |object: &Attached| {
                let mut shapes = object.parts.iter().map(|(shape, _)| shape);
                object.link == link.name && shapes.any(|shape| matches!(shape, Shape::Custom(_)))
            };
            let scale = if world.attached.iter().any(is_foreign) { 1.0 } else { scale };
            let against_robot = draw.below(2) == 0;
            world.padding.insert(link.name.clone(), Padding { scale, padding, against_robot });
        }
    }
    let mut allowed = match round % 4 {
        0 => AllowedPairs::default(),
        _ => AllowedPairs::adjacent(&robot),
    };
    if round % 2 == 1 {
        // Obstacles thinly spread, and links that may touch each other: most states are free.
        world.obstacles.iter_mut().for_each(|obstacle| obstacle.pose = draw.pose(4.0));
        let carried = ["held".to_owned(), "other".to_owned()];
        let names = || robot.links().iter().map(|link| &link.name).chain(&carried);
        let pairs = names().flat_map(|a| names().map(move |b| (a, b)));
        pairs.filter(|(a, b)| a < b).for_each(|(a, b)| allowed.allow(a, b));
    }
    Workcell::new(robot, &world, &allowed).unwrap()
}

/// States of which some come twice.
fn states(draw: &mut Draw, robot: &Robot, count: usize) -> Vec<Vec<f64>> {
    let mut states: Vec<Vec<f64>> = Vec::new();
    for k in 0..count {
        let again =
            (k > 0 && draw.below(8) == 0).then(|| states[draw.below(k as u32) as usize].clone());
        states.push(again.unwrap_or_else(|| state(draw, robot)));
    }
    states
}

#[test]
fn answers_of_any_batch_at_any_number_of_threads_are_those_of_every_pair_alone() {
    let mut draw = seeded(31);
    let (mut free, mut hits) = (0, 0);
    for round in 0..12 {
        let mut cell = equipped(&mut draw, round);
        let checker = StateChecker::new(cell.clone()).unwrap();
        let states = states(&mut draw, cell.robot(), 100);
        let truth: Vec<_> = states.iter().map(|state| alone(&mut cell, state)).collect();
        let pair = |hit: &Option<StateHit>| hit.map(|hit| (hit.pair, hit.touches()));
        let first_of_all: Vec<_> =
            checker.first(&states, Par::Serial).unwrap().iter().map(pair).collect();
        for (size, threads) in
            [1, 2, 4, 5, 16, 19, 100].into_iter().flat_map(|s| [1, 2, 3].map(|t| (s, t)))
        {
            let said = format!("round {round}, {size} at once on {threads} threads");
            dcd_exec::with_threads(threads, || {
                let due = truth.chunks(size).zip(first_of_all.chunks(size));
                for (states, (truth, due_first)) in states.chunks(size).zip(due) {
                    let all = checker.all(states, Par::Pool).unwrap();
                    let first = checker.first(states, Par::Pool).unwrap();
                    assert!(first.iter().map(pair).eq(due_first.iter().copied()), "{said}");
                    let collides = checker.collides(states, Par::Pool).unwrap();
                    let ours =
                        all.iter().map(|hit| (hit.state as usize, (hit.pair, hit.touches())));
                    let due = truth
                        .iter()
                        .enumerate()
                        .flat_map(|(k, of)| of.iter().map(move |&hit| (k, hit)));
                    assert!(ours.eq(due), "{said}");
                    for (k, truth) in truth.iter().enumerate() {
                        assert_eq!(collides[k], !truth.is_empty(), "{said}");
                        assert_eq!(
                            checker.is_free(&states[k]).unwrap(),
                            truth.is_empty(),
                            "{said}"
                        );
                        let found = first[k].map(|hit| (hit.pair, hit.touches()));
                        assert_eq!(found.is_some(), !truth.is_empty(), "{said}");
                        assert!(found.is_none_or(|hit| truth.contains(&hit)), "{said}");
                        let touches = truth.iter().any(|&(_, touches)| touches);
                        assert!(!touches || found.is_some_and(|(_, touches)| touches), "{said}");
                    }
                }
            })
            .unwrap();
        }
        free += truth.iter().filter(|truth| truth.is_empty()).count();
        hits += truth.iter().map(Vec::len).sum::<usize>();
    }
    assert!(free > 50 && hits > 500, "{free} free, {hits} hits");
}

/// The least signed distance of all pairs that are checked, between two bounds.
fn least_alone(cell: &mut Workcell, state: &[f64]) -> Option<[f64; 2]> {
    cell.set_state(state).unwrap();
    let scene = cell.scene();
    let posed = |i: u32| PosedShape::of(scene, i);
    let mut least: Option<[f64; 2]> = None;
    for j in 0..scene.len() as u32 {
        for i in (0..j).filter(|&i| scene.allows(i, j)) {
            let known = match distance::distance(posed(i), posed(j)).0 {
                DistanceResult::Apart(found) => [found.lower(), found.upper()],
                DistanceResult::Interval { within, depth, .. } => [-depth, within.upper()],
                DistanceResult::Touching => {
                    match Depths.solve(posed(i), posed(j), &mut Default::default()) {
                        Verdict::Touching(found) => {
                            [-found.depth - found.error_bound, -found.depth + found.error_bound]
                        }
                        // Of a foreign shape.
                        _ => [f64::NEG_INFINITY, 0.0],
                    }
                }
                DistanceResult::Undecided(reason) => panic!("{reason:?}"),
            };
            let least = least.get_or_insert([f64::INFINITY; 2]);
            *least = [least[0].min(known[0]), least[1].min(known[1])];
        }
    }
    least
}

#[test]
fn clearances_of_any_batch_at_any_number_of_threads_are_the_least_of_every_pair_alone() {
    let mut draw = seeded(37);
    let (mut positive, mut negative) = (0, 0);
    for round in 0..16 {
        let mut cell = equipped(&mut draw, round);
        let checker = StateChecker::new(cell.clone()).unwrap();
        let states = states(&mut draw, cell.robot(), 17);
        let clearances = match checker.clearances(&states, Par::Serial) {
            Ok(clearances) => clearances,
            // A pair that has no signed distance.
            Err(error) => {
                println!("round {round}: {error}");
                continue;
            }
        };
        for (state, clearance) in states.iter().zip(&clearances) {
            let truth = least_alone(&mut cell, state);
            let Some(clearance) = clearance else {
                assert_eq!(truth, None, "round {round}");
                continue;
            };
            let [lower, upper] = truth.unwrap();
            let (found, bound) =
                (clearance.proximity.signed_distance, clearance.proximity.error_bound);
            let meets = found - bound <= upper && lower <= found + bound;
            assert!(meets, "round {round}: {clearance:?}, alone {lower} … {upper}");
            // The widest that other seeds have drawn is 1.6e-6, in metres.
            assert!(bound < 1e-5, "round {round}: {clearance:?}");
            if found > 0.0 { positive += 1 } else { negative += 1 }
        }
        for (size, threads) in
            [1, 2, 15, 16, 17].into_iter().flat_map(|s| [1, 2, 3].map(|t| (s, t)))
        {
            let again = dcd_exec::with_threads(threads, || {
                let chunks = states.chunks(size).map(|s| checker.clearances(s, Par::Pool).unwrap());
                chunks.collect::<Vec<_>>().concat()
            });
            assert!(
                again.unwrap() == clearances,
                "round {round}, {size} at once on {threads} threads"
            );
        }
    }
    assert!(positive > 10 && negative > 10, "{positive} {negative}");
}
