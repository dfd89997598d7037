use super::AllowedPairs;
use crate::scene::tests::touching_in;
use crate::{Attached, LinkShapes, Obstacle, Robot, Srdf, Workcell, World};
use dcd_geom::{Pose, Shape};
use std::path::Path;

/// Three balls of radius 1.2 at x = 0, 1 and 2, each on a joint of its own, so that no two are rigid.
fn robot() -> Robot {
    let ball = "<collision><geometry><sphere radius=\"1.2\"/></geometry></collision>";
    let link = |name: &str| format!("<link name=\"{name}\">{ball}</link>");
    let joint = |parent: &str, child: &str| {
        format!(
            "<joint name=\"{child}_j\" type=\"continuous\"><origin xyz=\"1 0 0\"/><axis xyz=\"1 0 0\"/>\
             <parent link=\"{parent}\"/><child link=\"{child}\"/></joint>"
        )
    };
    let body = [link("a"), link("b"), link("c"), joint("a", "b"), joint("b", "c")].concat();
    Robot::read(&format!("<robot name=\"r\">{body}</robot>"), Path::new("."), LinkShapes::Hulls)
        .unwrap()
}

fn srdf(body: &str) -> Srdf {
    Srdf::read(&format!("<robot name=\"r\">{body}</robot>")).unwrap()
}

/// A ball on a link, where the link is.
fn carried(name: &str, link: &str) -> Attached {
    Attached::new(name, link, [(Shape::sphere(0.4).unwrap(), Pose::IDENTITY)])
}

/// The touching pairs of names, sorted.
fn touching(world: &World, allowed: &AllowedPairs) -> Vec<[String; 2]> {
    touching_in(&Workcell::new(robot(), world, allowed).unwrap())
}

/// With a ball in the world that touches all links.
fn with_obstacle(name: &str) -> World {
    let obstacle = Obstacle {
        name: name.to_owned(),
        shape: Shape::sphere(3.0).unwrap(),
        pose: Pose::IDENTITY,
    };
    World { obstacles: vec![obstacle], ..World::default() }
}

#[test]
fn an_srdf_speaks_of_links_alone_whatever_has_the_names_in_it() {
    let named = |name: &str| {
        srdf(&format!(
            r#"<disable_collisions link1="a" link2="{name}"/><disable_default_collisions link="{name}"/>
            <disable_collisions link1="a" link2="b"/>"#
        ))
    };
    let links = [["a", "c"], ["b", "c"]];
    let of = |name: &'static str, touched: &[&'static str]| {
        let mut all: Vec<[&str; 2]> = links.to_vec();
        all.extend(touched.iter().map(|&link| [link, name]));
        all.sort_unstable();
        all
    };
    let found = touching(&with_obstacle("box"), &named("box").allowed);
    assert_eq!(found, of("box", &["a", "b", "c"]));
    let mut world = World::default();
    world.attach(carried("tool", "b"), ["c"]);
    let mut allowed = named("tool").allowed;
    allowed.extend(&world.allowed);
    assert_eq!(touching(&world, &allowed), of("tool", &["a"]));
}

#[test]
fn names_in_an_srdf_are_without_the_spaces_round_them() {
    let spaced = srdf(
        "<disable_default_collisions link=\" a\"/><enable_collisions link1=\"b \" link2=\"\ta\"/>",
    );
    assert_eq!(touching(&World::default(), &spaced.allowed), [["a", "b"], ["b", "c"]]);
}

#[test]
fn of_two_srdfs_a_pair_that_either_lists_comes_before_the_defaults_of_both() {
    let files = [
        r#"<enable_collisions link1="a" link2="b"/>"#,
        r#"<disable_default_collisions link="a"/><disable_collisions link1="b" link2="c"/>"#,
    ];
    for order in [[0, 1], [1, 0]] {
        let [mut first, second] = order.map(|k| srdf(files[k]));
        first.extend(second).unwrap();
        assert_eq!(touching(&World::default(), &first.allowed), [["a", "b"]]);
    }
}

#[test]
fn what_one_link_carries_is_one_body_and_of_no_body_of_links() {
    let mut world = World { allowed: AllowedPairs::adjacent(&robot()), ..World::default() };
    for (name, link) in [("one", "a"), ("two", "a"), ("other", "b"), ("third", "a")] {
        world.attach(carried(name, link), [] as [&str; 0]);
    }
    let allowed = world.allowed.clone();
    assert!(allowed.contains("one", "two") && allowed.contains("third", "one"));
    assert!(!allowed.contains("one", "other") && !allowed.contains("other", "a"));
    assert!(!allowed.contains("one", "b") && !allowed.contains("one", "c"));
    let met = touching(&world, &allowed);
    let due =
        [["a", "c"], ["a", "other"], ["b", "one"], ["b", "third"], ["b", "two"], ["c", "other"]];
    assert_eq!(met, due);
    // Of all that there was on the link nothing is there any more.
    for name in ["one", "two", "third"] {
        world.detach(name).unwrap();
    }
    world.attach(carried("fourth", "c"), [] as [&str; 0]);
    world.attach(carried("fifth", "a"), [] as [&str; 0]);
    assert!(!world.allowed.contains("fourth", "fifth"));
}
