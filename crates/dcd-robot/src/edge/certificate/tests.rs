//! Certificates are judged by `dcd_judge::Replay`, which has kinematics and intervals of its own.

use super::super::tests::{Draw, arm, checker, floating, obstacle};
use super::super::{EdgeAnswer, EdgeChecker, JointPath};
use crate::{AllowedPairs, Obstacle, Workcell, World};
use dcd_geom::{Pose, Shape};
use dcd_judge::{Replay, Replayed};
use glam::{DQuat, DVec3};
use serde_json::{Value, json};

/// The lines of a certificate for an edge that is called free.
fn lines(checker: &EdgeChecker, path: &JointPath) -> Option<[String; 2]> {
    let edge = checker.check(path, 100_000).unwrap();
    let EdgeAnswer::Free { clearance } = edge.answer else { return None };
    let certificate = checker.certificate(path, clearance, 1_000_000);
    let certificate = certificate.unwrap_or_else(|error| panic!("{path:?} {edge:?}: {error}"));
    assert_eq!(certificate, checker.certificate(path, clearance, 1_000_000).unwrap());
    Some([checker.certificate_cell().unwrap(), certificate.line(7)])
}

fn replayed([cell, edge]: &[String; 2]) -> Result<Replayed, String> {
    let mut replay = Replay::with_budget(1_000_000);
    replay.line(cell)?;
    replay.line(edge)
}

/// Of a checker and a path: whether it is free, which must be proved.
fn assert_replays(checker: &EdgeChecker, path: &JointPath) -> bool {
    let Some(lines) = lines(checker, path) else { return false };
    match replayed(&lines) {
        Ok(Replayed::Accepted { edge: 7, pairs, planes, .. }) => {
            assert_eq!(pairs, checker.pairs.len(), "{path:?}");
            assert!(planes >= pairs, "{path:?}");
            true
        }
        other => panic!("{path:?}: {other:?}"),
    }
}

/// A shape of any kind, of some tenths of a metre.
fn shape(draw: &mut Draw, kind: usize) -> Shape {
    let mut points = |n: usize| -> Vec<DVec3> { (0..n).map(|_| draw.vector() * 0.3).collect() };
    match kind % 9 {
        0 => Shape::sphere(0.25),
        1 => Shape::cuboid(DVec3::new(0.3, 0.05, 0.2)),
        2 => Shape::cylinder(0.3, 0.1),
        3 => Shape::capsule(0.3, 0.1),
        4 => Shape::cone(0.3, 0.2),
        5 => Shape::hull(points(12)),
        6 => Shape::mesh(points(9), vec![[0, 1, 2], [3, 4, 5], [6, 7, 8], [0, 4, 8], [2, 3, 7]]),
        7 => Shape::hull(points(6)).and_then(|hull| hull.rounded(0.05)),
        _ => {
            let turn = DQuat::from_rotation_x(0.7);
            let at = |x: f64| Pose::new(turn, DVec3::X * x).unwrap();
            let parts =
                [Shape::cylinder(0.2, 0.1), Shape::cuboid(DVec3::splat(0.1)), Shape::sphere(0.1)];
            let placed = parts.into_iter().zip([-0.4, 0.0, 0.4]);
            Shape::compound(placed.map(|(shape, x)| (shape.unwrap(), at(x))).collect())
        }
    }
    .unwrap()
}

fn placed(draw: &mut Draw, name: usize, shape: Shape) -> Obstacle {
    let turn = DQuat::from_scaled_axis(draw.vector() * 3.0);
    let pose = Pose::new(turn, draw.vector() * 2.5).unwrap();
    Obstacle { name: format!("o{name}"), shape, pose }
}

#[test]
fn every_edge_that_is_called_free_is_certified_and_replays() {
    let mut draw = Draw::new();
    let mut free = 0;
    for k in 0..60 {
        let obstacles = (0..5).map(|n| {
            let shape = shape(&mut draw, n + k);
            placed(&mut draw, n, shape)
        });
        let checker = checker(arm(3), obstacles.collect());
        let mut state = || -> Vec<f64> { (0..4).map(|_| draw.unit() * 1.5).collect() };
        let path = if k % 2 == 0 {
            JointPath::Straight([state(), state()])
        } else {
            JointPath::Bezier([state(), state(), state(), state()])
        };
        free += usize::from(assert_replays(&checker, &path));
    }
    assert!(free > 12, "{free}");
}

#[test]
fn a_floating_robot_s_edges_replay() {
    let mut draw = Draw::new();
    let mut free = 0;
    for _ in 0..40 {
        let posts = (0..8)
            .map(|n| obstacle(&format!("o{n}"), Shape::sphere(0.4).unwrap(), draw.vector() * 3.0));
        let checker = checker(floating(), posts.collect());
        let mut state = || {
            let (place, turn) = (draw.vector() * 2.0, DQuat::from_scaled_axis(draw.vector() * 3.0));
            [&place.to_array()[..], &turn.normalize().to_array()[..]].concat()
        };
        let path = JointPath::Straight([state(), state()]);
        free += usize::from(assert_replays(&checker, &path));
    }
    assert!(free > 8, "{free}");
}

#[test]
fn a_floating_robot_that_grazes_a_ball_while_it_turns_nearly_once_round_replays() {
    let mut draw = Draw::new();
    // The corners of a bar 2 m long and 0.1 m thick, held at an end, but for the third dimension.
    let reach = 2f64.hypot(0.05);
    for turn in [1e-6, 3.15, std::f64::consts::TAU - 2.002e-3] {
        let from = DQuat::from_scaled_axis(draw.vector() * 3.0).normalize();
        let (sin, cos) = (0.5 * turn).sin_cos();
        let state = |q: DQuat| [&[0.0; 3][..], &q.to_array()[..]].concat();
        let path = [state(from), state(from * DQuat::from_xyzw(0.0, 0.0, sin, cos))];
        for gap in [1e-5, 1e-7, 1e-9] {
            let way = if turn < 1.0 { DVec3::X } else { DVec3::Y };
            let far = if turn < 1.0 { 2.0 } else { reach } + 0.4 + gap;
            let ball = obstacle("ball", Shape::sphere(0.4).unwrap(), from * way * far);
            let checker = checker(floating(), vec![ball]);
            assert!(assert_replays(&checker, &JointPath::Straight(path.clone())), "{turn} {gap}");
        }
    }
}

#[test]
fn a_link_that_grazes_a_wall_replays() {
    for gap in [1e-2, 1e-4, 1e-6, 1e-8] {
        let wall = Shape::cuboid(DVec3::new(5.0, 1.0, 5.0)).unwrap();
        let place = DVec3::new(0.0, 1.1 + gap, 0.0);
        let checker = checker(arm(1), vec![obstacle("wall", wall, place)]);
        for path in [[vec![0.0, 0.0], vec![0.0, 1.0]], [vec![0.0, 0.0], vec![0.4 * gap / 2.1, 1.0]]]
        {
            assert!(assert_replays(&checker, &JointPath::Straight(path)), "{gap}");
        }
    }
}

#[test]
fn a_sphere_that_slides_past_the_cylinder_of_a_compound_replays() {
    let cylinder = Shape::cylinder(5.0, 1.0).unwrap();
    // Leant over and turned, so that no box's side parts them; not with its middle beside the sphere, so that no covering sphere does.
    let lean = DQuat::from_rotation_x(0.3) * DQuat::from_rotation_z(0.4);
    let along = lean * DVec3::Z;
    let across = DVec3::X.cross(along).normalize();
    // Turned by less than corners in place of its discs are apart, so that none of them is nearest.
    for turn in [DQuat::from_rotation_z(0.1), DQuat::IDENTITY] {
        let parts = vec![
            (cylinder.clone(), Pose::new(turn, DVec3::ZERO).unwrap()),
            (Shape::sphere(0.1).unwrap(), Pose::from_translation(DVec3::Z * 9.0).unwrap()),
        ];
        let shape = Shape::compound(parts).unwrap();
        for gap in [1e-3, 1e-5, 1e-7] {
            for aside in [0.0, 0.07, 0.2] {
                let place = DVec3::X * (1.4 + aside) + across * (1.1 + gap) + along * 0.37;
                let (name, shape) = ("column".to_owned(), shape.clone());
                let column = Obstacle { name, shape, pose: Pose::new(lean, place).unwrap() };
                let checker = checker(arm(1), vec![column]);
                let path = JointPath::Straight([vec![0.0, 0.0], vec![0.0, 0.6]]);
                assert!(assert_replays(&checker, &path), "{turn} {gap} {aside}");
            }
        }
    }
}

#[test]
fn a_robot_that_carries_is_padded_and_stands_far_off_replays() {
    let robot = arm(3);
    let ball = Shape::sphere(0.2).unwrap();
    for (padded, base) in [(false, 0.0), (true, 0.0), (true, 1e4)] {
        let at = DVec3::new(base, 3.0, 0.0);
        let mut world =
            World { obstacles: vec![obstacle("ball", ball.clone(), at)], ..World::default() };
        world.base = Some(Pose::from_translation(DVec3::X * base).unwrap());
        let stick = Shape::cuboid(DVec3::new(0.2, 0.01, 0.01)).unwrap();
        let there = Pose::from_translation(DVec3::X * 0.2).unwrap();
        world.attach(crate::Attached::new("stick", "tip", [(stick, there)]), [] as [&str; 0]);
        if padded {
            world.pad(&robot, 0.02).unwrap();
        }
        let mut allowed = AllowedPairs::adjacent(&robot);
        allowed.extend(&world.allowed);
        let checker = EdgeChecker::new(Workcell::new(robot.clone(), &world, &allowed).unwrap());
        let path = JointPath::Straight([vec![0.0, 0.3, 0.1, 0.0], vec![0.5, 0.1, -0.4, 0.5]]);
        assert!(assert_replays(&checker, &path), "{padded} {base}");
    }
}

/// A free edge with a mesh and a sphere beside the arm, some of whose planes are of pieces.
fn honest() -> [Value; 2] {
    let ring: Vec<DVec3> = (0..12)
        .flat_map(|k| {
            let angle = f64::from(k) * std::f64::consts::TAU / 12.0;
            let p = DVec3::new(0.0, angle.cos(), angle.sin()) * 0.5;
            [p + DVec3::X * 1.4, p + DVec3::X * 1.6]
        })
        .collect();
    let next = |k: u32| (k + 2) % 24;
    let tube = (0..12u32)
        .map(|k| 2 * k)
        .flat_map(|k| [[k, k + 1, next(k)], [k + 1, next(k), next(k) + 1]]);
    let tube = Shape::mesh(ring, tube.collect()).unwrap();
    let ball = obstacle("ball", Shape::sphere(0.2).unwrap(), DVec3::new(1.0, 0.6, 0.8));
    let checker = checker(arm(3), vec![obstacle("tube", tube, DVec3::ZERO), ball]);
    // Through the tube, which nothing convex round it would let pass.
    let path = JointPath::Straight([vec![0.0, 0.0, 0.1, 0.0], vec![0.1, 0.15, 0.0, 0.3]]);
    let lines = lines(&checker, &path).expect("free");
    lines.map(|line| serde_json::from_str(&line).unwrap())
}

fn judged(lines: &[Value; 2]) -> Result<Replayed, String> {
    replayed(&[lines[0].to_string(), lines[1].to_string()])
}

fn assert_refused(lines: &[Value; 2], what: &str) {
    match judged(lines) {
        Ok(Replayed::Refused { edge: 7, .. }) | Err(_) => {}
        other => panic!("{what}: {other:?}"),
    }
}

#[test]
fn a_certificate_without_any_one_of_its_planes_or_pairs_is_refused() {
    let honest = honest();
    assert!(matches!(judged(&honest), Ok(Replayed::Accepted { .. })), "{:?}", judged(&honest));
    let count = |value: &Value| value.as_array().unwrap().len();
    let mut of_pieces = 0;
    for pair in 0..count(&honest[1]["pairs"]) {
        let mut forged = honest.clone();
        forged[1]["pairs"].as_array_mut().unwrap().remove(pair);
        assert_refused(&forged, "a pair is gone");
        for plane in 0..count(&honest[1]["pairs"][pair]["planes"]) {
            let mut forged = honest.clone();
            let planes = forged[1]["pairs"][pair]["planes"].as_array_mut().unwrap();
            of_pieces += usize::from(count(&planes[plane]) == 11);
            planes.remove(plane);
            assert_refused(&forged, "a plane is gone");
        }
    }
    assert!(of_pieces > 3, "{of_pieces}");
}

#[test]
fn a_plane_that_is_turned_over_moved_or_stretched_in_time_is_refused() {
    let honest = honest();
    let pairs = honest[1]["pairs"].as_array().unwrap().len();
    for pair in 0..pairs {
        let planes = honest[1]["pairs"][pair]["planes"].as_array().unwrap().len();
        for plane in 0..planes {
            let forged = |change: &dyn Fn(&mut Vec<f64>)| {
                let mut forged = honest.clone();
                let row = &mut forged[1]["pairs"][pair]["planes"][plane];
                let mut numbers: Vec<f64> = serde_json::from_value(row.clone()).unwrap();
                change(&mut numbers);
                *row = json!(numbers);
                forged
            };
            let turned = forged(&|row| row[2..7].iter_mut().for_each(|x| *x = -*x));
            assert_refused(&turned, "the plane is turned over");
            let sign = forged(&|row| row[2..5].iter_mut().for_each(|x| *x = -*x));
            assert_refused(&sign, "the normal has another sign");
            for by in [-20.0, 20.0] {
                let moved = forged(&|row| row[5..7].iter_mut().for_each(|d| *d += by));
                assert_refused(&moved, "the plane is elsewhere");
            }
            let shorter = forged(&|row| row[1] = 0.5 * (row[0] + row[1]));
            assert_refused(&shorter, "its interval is shorter");
            let backward = forged(&|row| row.swap(0, 1));
            assert_refused(&backward, "its interval ends before it begins");
            let nothing = forged(&|row| row[2..5].fill(0.0));
            assert_refused(&nothing, "it has no normal");
            let longer = forged(&|row| row.push(0.0));
            assert_refused(&longer, "it has a number more");
        }
    }
}

/// Of both lines.
type Change = &'static dyn Fn(&mut [Value; 2]);

#[test]
fn what_is_forged_of_the_robot_the_world_or_the_path_is_refused() {
    let honest = honest();
    let forged = |change: &dyn Fn(&mut [Value; 2])| {
        let mut forged = honest.clone();
        change(&mut forged);
        forged
    };
    let cases: [(&str, Change); 16] = [
        ("a ball that the arm meets", &|lines| {
            for body in lines[0]["bodies"].as_array_mut().unwrap() {
                if body["name"] == "ball" {
                    body["shape"]["pieces"][0]["radius"] = json!(0.9);
                }
            }
        }),
        ("a pair that may touch is one that may not", &|lines| {
            lines[0]["allowed"].as_array_mut().unwrap().remove(0);
        }),
        ("another path", &|lines| lines[1]["control"][1][0] = json!(3.0)),
        ("a path of too many values", &|lines| {
            lines[1]["control"][0].as_array_mut().unwrap().push(json!(0.0));
        }),
        ("a clearance that is not there", &|lines| lines[1]["clearance"] = json!(0.5)),
        ("a negative clearance", &|lines| lines[1]["clearance"] = json!(-1.0)),
        ("a joint that turns about another axis", &|lines| {
            lines[0]["joints"][1]["motion"]["turns"]["axis"] = json!([1.0, 0.0, 0.0]);
        }),
        ("an axis of length 2", &|lines| {
            lines[0]["joints"][1]["motion"]["turns"]["axis"] = json!([0.0, 2.0, 0.0]);
        }),
        ("a link that is elsewhere", &|lines| lines[0]["joints"][1]["origin"]["t"][1] = json!(0.6)),
        ("a reflection", &|lines| lines[0]["joints"][1]["origin"]["R"][0][0] = json!(-1.0)),
        ("a link of two parents", &|lines| {
            let joint = lines[0]["joints"][0].clone();
            lines[0]["joints"].as_array_mut().unwrap().push(joint);
        }),
        ("a key that nobody knows", &|lines| lines[1]["trust"] = json!(true)),
        ("an edge without a proof", &|lines| lines[1]["error"] = json!("none")),
        ("a pair in the frame of a link that it does not move with", &|lines| {
            lines[1]["pairs"][0]["frame"] = json!("tip");
        }),
        ("a pair twice", &|lines| {
            let pair = lines[1]["pairs"][0].clone();
            lines[1]["pairs"].as_array_mut().unwrap().push(pair);
        }),
        ("a later format", &|lines| lines[0]["certificate"] = json!("dcd-edges-2")),
    ];
    for (what, change) in cases {
        assert_refused(&forged(change), what);
    }
    // Without its first line an edge is of nothing.
    assert!(Replay::default().line(&honest[1].to_string()).is_err());
    let hit = json!({"edge": 3, "answer": "hit"}).to_string();
    assert!(matches!(Replay::default().line(&hit), Ok(Replayed::NotFree { edge: 3, .. })));
}

#[test]
fn a_key_that_stands_twice_is_refused() {
    let [cell, edge] = honest();
    let twice = cell.to_string().replacen("\"allowed\":", "\"allowed\":[],\"allowed\":", 1);
    assert!(replayed(&[twice, edge.to_string()]).unwrap_err().contains("duplicate"));
    let twice = edge.to_string().replacen("\"answer\":", "\"answer\":\"hit\",\"answer\":", 1);
    assert!(replayed(&[cell.to_string(), twice]).unwrap_err().contains("duplicate"));
}

#[test]
fn what_stands_still_says_so() {
    let honest = honest();
    // Without its link a body would stand still, and need be apart from no obstacle.
    let bodies = honest[0]["bodies"].as_array().unwrap().len();
    for body in 0..bodies {
        let mut forged = honest.clone();
        forged[0]["bodies"][body].as_object_mut().unwrap().remove("link").unwrap();
        let refused = judged(&forged).unwrap_err();
        assert!(refused.contains("missing field `link`"), "{refused}");
    }
    let mut forged = honest.clone();
    forged[1]["pairs"][0].as_object_mut().unwrap().remove("frame").unwrap();
    assert_refused(&forged, "a pair without a frame");
}

#[test]
fn planes_count_in_another_world_only_where_that_is_free_too() {
    let mut draw = Draw::new();
    let [mut accepted, mut hits, mut rounds] = [0; 3];
    while rounds < 12 || accepted <= 20 || hits <= 20 {
        assert!(rounds < 200, "{accepted} {hits}");
        rounds += 1;
        let at = draw.vector() * 1.5;
        let world = |radius: f64, at| {
            checker(arm(3), vec![obstacle("ball", Shape::sphere(radius).unwrap(), at)])
        };
        let mut state = || -> Vec<f64> { (0..4).map(|_| draw.unit()).collect() };
        let path = JointPath::Straight([state(), state()]);
        let Some([_, edge]) = lines(&world(0.1, at), &path) else { continue };
        for k in 0..30 {
            let radius = 0.1 + 0.02 * f64::from(k);
            let other = world(radius, at + draw.vector() * 0.05 * f64::from(k % 3));
            let found = replayed(&[other.certificate_cell().unwrap(), edge.clone()]).unwrap();
            let hit = matches!(other.check(&path, 100_000).unwrap().answer, EdgeAnswer::Hit { .. });
            let is_accepted = matches!(found, Replayed::Accepted { .. });
            assert!(!(is_accepted && hit), "{path:?} {at} {radius}");
            (accepted, hits) = (accepted + u32::from(is_accepted), hits + u32::from(hit));
        }
    }
}

#[test]
fn what_has_no_certificate_is_refused_with_its_name() {
    let ground = obstacle("ground", Shape::half_space(DVec3::Z, -3.0).unwrap(), DVec3::ZERO);
    let checker = checker(arm(2), vec![ground]);
    let path = JointPath::Straight([vec![0.0; 3], vec![0.1; 3]]);
    let refused = checker.certificate(&path, 0.1, 100).unwrap_err().to_string();
    assert!(refused.contains("ground"), "{refused}");
    assert!(checker.certificate_cell().is_err());
}

#[test]
fn a_path_that_meets_something_gets_no_certificate() {
    let ball = obstacle("ball", Shape::sphere(0.4).unwrap(), DVec3::Y * 2.0);
    let checker = checker(arm(2), vec![ball]);
    let path = JointPath::Straight([vec![0.0; 3], vec![2.0, 0.0, 0.0]]);
    assert!(matches!(checker.check(&path, 1000).unwrap().answer, EdgeAnswer::Hit { .. }));
    let refused = checker.certificate(&path, 1e-3, 100_000).unwrap_err().to_string();
    assert!(refused.contains("ball"), "{refused}");
}
