//! Links that carry several objects.

use super::*;

/// An arm of three links of length 1, turned about z, y and z, each with spheres beside it and a box across it.
pub(in super::super) fn arm_of_several() -> Robot {
    let of = |origin: &str, geometry: &str| {
        format!("<collision><origin {origin}/><geometry>{geometry}</geometry></collision>")
    };
    let mut text = String::from("<robot name=\"several\"><link name=\"base\"/>");
    for k in 0..3 {
        let spheres = (0..4).map(|n| {
            let (x, y) = (0.2 + 0.2 * f64::from(n), 0.05 * f64::from(n % 2));
            of(&format!("xyz=\"{x} {y} 0\""), "<sphere radius=\"0.06\"/>")
        });
        let across = of("xyz=\"0.5 0 0.1\" rpy=\"0.3 0.2 1.0\"", "<box size=\"0.3 0.04 0.05\"/>");
        let (axis, at) = (if k == 1 { "0 1 0" } else { "0 0 1" }, if k == 0 { 0 } else { 1 });
        let parent = if k == 0 { "base".to_owned() } else { format!("l{}", k - 1) };
        text += &format!(
            "<link name=\"l{k}\">{}{across}</link><joint name=\"j{k}\" type=\"continuous\"><origin xyz=\"{at} 0 0\"/>\
             <axis xyz=\"{axis}\"/><parent link=\"{parent}\"/><child link=\"l{k}\"/></joint>",
            spheres.collect::<String>()
        );
    }
    Robot::read(&(text + "</robot>"), Path::new("."), LinkShapes::Hulls).unwrap()
}

fn random_obstacles(draw: &mut Draw) -> Vec<Obstacle> {
    let obstacle = |n: usize| {
        let shape = match n % 3 {
            0 => Shape::sphere(0.15),
            1 => Shape::cuboid(draw.vector().abs() * 0.3 + 0.01),
            _ => Shape::cylinder(0.3, 0.1),
        };
        let at = draw.vector().normalize() * (1.6 + 0.9 * draw.unit());
        super::obstacle(&format!("o{n}"), shape.unwrap(), at)
    };
    (0..5).map(obstacle).collect()
}

#[test]
fn each_pair_is_in_one_group_or_in_none() {
    let checker = checker(arm_of_several(), random_obstacles(&mut Draw::new()));
    let Groups { groups, members, single } = &*checker.groups;
    let of_groups = groups.iter().flat_map(|group| checker.groups.members_of(group));
    assert!(of_groups.eq(members));
    let mut all = members.clone();
    all.extend(single);
    all.sort_unstable();
    assert!(all.iter().copied().eq(0..checker.pairs.len() as u32));
    // Three links beside five obstacles, and the first beside the last.
    assert_eq!((groups.len(), single.len()), (16, 0));
}

#[test]
fn edges_of_links_with_several_objects_are_answered_as_their_samples_say() {
    let mut draw = Draw::new();
    let [mut free, mut hits, mut undecided, mut k] = [0; 4];
    while k < 60 || free <= 5 || hits <= 5 || undecided <= 5 {
        assert!(k < 1000, "{free} {hits} {undecided}");
        let checker = checker(arm_of_several(), random_obstacles(&mut draw));
        let mut state = || -> Vec<f64> { (0..3).map(|_| draw.unit() * 1.5).collect() };
        let path = match k % 3 {
            0 => JointPath::Bezier([state(), state(), state(), state()]),
            _ => JointPath::Straight([state(), state()]),
        };
        let edge = checker.check(&path, 10_000).unwrap();
        assert_holds(&checker, &path, &edge, 150);
        match edge.answer {
            EdgeAnswer::Free { .. } => free += 1,
            EdgeAnswer::Hit { .. } => hits += 1,
            EdgeAnswer::Undecided { .. } => panic!("{path:?}: {edge:?}"),
        }
        let stopped = checker.check(&path, edge.nodes / 2).unwrap();
        assert_holds(&checker, &path, &stopped, 150);
        if let EdgeAnswer::Undecided { pair, .. } = stopped.answer {
            assert!(checker.pairs.iter().any(|known| known.objects == pair), "{pair:?}");
            undecided += 1;
        }
        k += 1;
    }
}

/// A bar of balls of radius 0.01 that slides along x.
fn bar(balls: &[f64]) -> Robot {
    let ball = |y: &f64| {
        format!(
            "<collision><origin xyz=\"0 {y} 0\"/><geometry><sphere radius=\"0.01\"/></geometry></collision>"
        )
    };
    let balls: String = balls.iter().map(ball).collect();
    let text = format!(
        "<robot name=\"slide\"><link name=\"base\"/><link name=\"bar\">{balls}</link><joint name=\"along\" type=\"prismatic\">\
         <axis xyz=\"1 0 0\"/><limit lower=\"-2\" upper=\"2\" effort=\"1\" velocity=\"1\"/><parent link=\"base\"/>\
         <child link=\"bar\"/></joint></robot>"
    );
    Robot::read(&text, Path::new("."), LinkShapes::Hulls).unwrap()
}

/// That the bar is proved free up to the last ball on its path, which it meets at 0.99 or later, but for what is left
/// before a hit.
fn assert_free_up_to_the_end(balls: &[f64], path: &JointPath, others: [DVec3; 2]) {
    let small = |name: &str, at| obstacle(name, Shape::sphere(0.01).unwrap(), at);
    let [beside, met] = others;
    let checker = checker(bar(balls), vec![small("beside", beside), small("met", met)]);
    let edge = checker.check(path, 10_000).unwrap();
    assert!(matches!(edge.answer, EdgeAnswer::Hit { t: 0.99..=1.0, .. }), "{edge:?}");
    assert!(edge.free_until > 0.99 - 1.0 / 128.0 && edge.free_until < 1.0, "{edge:?}");
}

#[test]
fn a_link_that_leaves_a_ball_between_its_own_is_proved_free_up_to_what_it_meets() {
    // The sphere round the bar begins in that round the first ball, by less than it moves in the shortest interval.
    let others = [DVec3::X * -0.517, DVec3::new(2.0, 0.5, 0.0)];
    assert_free_up_to_the_end(&[-0.5, 0.5], &straight(&[0.0], &[2.0]), others);
}

#[test]
fn what_comes_near_long_before_a_hit_is_told_from_one() {
    // 6t(1 − t)² − t³ has its maximum there: the bar turns back 10 µm before a ball, of which a motion as long as what is
    // left before a hit may take 40.
    let path = JointPath::Bezier([0.0, 2.0, 0.0, -1.0].map(|x| vec![x]));
    let t: f64 = (24.0 - 216f64.sqrt()) / 30.0;
    let farthest = 6.0 * t * (1.0 - t).powi(2) - t.powi(3);
    let others = [DVec3::X * (farthest + 0.02 + 1e-5), DVec3::X * -1.0];
    assert_free_up_to_the_end(&[0.0], &path, others);
}
