use crate::{AllowedPairs, LinkShapes, Robot, RobotError, Workcell, World};
use std::fmt::Write;
use std::path::Path;

const SPHERE: &str = "<collision><geometry><sphere radius=\"0.1\"/></geometry></collision>";

fn read(text: &str) -> Result<Robot, RobotError> {
    Robot::read(text, Path::new("."), LinkShapes::Hulls)
}

/// A robot from the text between `<robot>` and its end, which begins on line 2.
fn robot(inside: &str) -> Result<Robot, RobotError> {
    read(&format!(
        "<robot name=\"r\" xmlns:xacro=\"http://www.ros.org/wiki/xacro\">\n{inside}\n</robot>"
    ))
}

fn link(name: &str) -> String {
    format!("<link name=\"{name}\">{SPHERE}</link>\n")
}

fn joint(kind: &str, [parent, child]: [&str; 2], more: &str) -> String {
    format!(
        "<joint name=\"{parent}-{child}\" type=\"{kind}\"><origin xyz=\"0 0 1\"/>\
         <parent link=\"{parent}\"/><child link=\"{child}\"/>{more}</joint>\n"
    )
}

fn assert_refused(inside: &str, why: &[&str]) {
    let refused = robot(inside).unwrap_err().to_string();
    for why in why {
        assert!(refused.contains(why), "{why:?} is not in {refused:?}");
    }
}

/// One link behind the other, the last ones first in the file.
fn chain(links: usize, kind: &str) -> String {
    let mut text = String::from("<robot name=\"chain\">\n");
    for k in (0..links).rev() {
        text.push_str(&link(&format!("l{k}")));
        if k > 0 {
            let ends = [format!("l{}", k - 1), format!("l{k}")];
            text.push_str(&joint(kind, [&ends[0], &ends[1]], ""));
        }
    }
    text + "</robot>"
}

#[test]
fn an_element_of_xacro_or_a_value_to_be_computed_is_refused_and_a_declaration_passes() {
    assert!(robot(&link("a")).is_ok());
    let call = format!("{}<xacro:arm name=\"b\"/>", link("a"));
    assert_refused(&call, &["line 3", "\"arm\"", "xacro must be expanded"]);
    for value in ["${r}", "$(find x)/m.obj"] {
        assert_refused(&link("a").replace("0.1", value), &["line 2", "\"sphere\"", "xacro", value]);
    }
}

#[test]
fn a_forest_a_ring_and_a_robot_without_collision_geometry_are_refused_by_name() {
    assert_refused(&[link("a"), link("b")].concat(), &["line 3", "\"a\"", "\"b\"", "one root"]);
    let ring = [joint("fixed", ["a", "b"], ""), joint("fixed", ["b", "a"], "")].concat();
    assert_refused(&([link("c"), link("a"), link("b")].concat() + &ring), &["\"a\"", "one way"]);
    assert_refused("<link name=\"a\"><visual/></link>", &["\"r\"", "no collision geometry"]);
    assert_refused("", &["no collision geometry"]);
}

#[test]
fn what_is_not_understood_is_refused_with_its_line_and_what_makes_no_difference_is_named() {
    let with = |from: &str, to: &str| {
        let parts = [link("a"), link("b"), joint("revolute", ["a", "b"], "<axis xyz=\"0 0 1\"/>")];
        parts.concat().replace(from, to)
    };
    for (from, to, why) in [
        ("<link name=\"b\">", "<lnik name=\"b\">", "no URDF"),
        ("</joint>", "<limts/></joint>", "line 4: joint \"a-b\": element \"limts\""),
        ("xyz=\"0 0 1\"/><parent", "xzy=\"0 0 1\"/><parent", "no attribute \"xzy\""),
        ("<sphere radius=\"0.1\"/>", "<sphere diameter=\"0.1\"/>", "\"diameter\""),
        ("<sphere radius=\"0.1\"/>", "<sphere/>", "line 2: link \"a\": sphere has no radius"),
        ("<sphere radius=\"0.1\"/>", "", "0 shapes, not 1"),
        ("<sphere radius=\"0.1\"/>", "<torus/>", "shape \"torus\""),
        ("<sphere radius=\"0.1\"/>", "<sphere radius=\"0.1\"/><sphere radius=\"1\"/>", "2 shapes"),
        ("radius=\"0.1\"", "radius=\"0,1\"", "\"0,1\" is no number"),
        ("xyz=\"0 0 1\"/><parent", "xyz=\"0 0\"/><parent", "2 numbers, not 3"),
        ("<collision>", "<x:collision xmlns:x=\"u\"/><collision>", "another namespace"),
        ("<axis xyz", "<axis xmlns=\"u\" xyz", "axis has a namespace of its own"),
        ("<axis xyz", "<axis xyz=\"1 0 0\"/><axis xyz", "two of \"axis\""),
        ("<link name=\"b\">", "<:link name=\"b\">", "a prefix without a name before \":link\""),
        (
            "radius=\"0.1\"",
            ":radius=\"0.1\"",
            "line 2: no URDF: a prefix without a name before \":radius\"",
        ),
        ("revolute", "ball", "joint type \"ball\" is not supported"),
    ] {
        assert_refused(&with(from, to), &[why]);
    }
    let more = "<inertial/><visual><geometry><mesh filename=\"no/such.dae\"/></geometry></visual>\
                <collision>";
    let plain = robot(&with("<collision>", more)).unwrap();
    let [note] = plain.notes() else { panic!("{:?}", plain.notes()) };
    assert!(note.contains("2 inertial (first on line 2)") && note.contains("visual"), "{note}");
    assert!(note.contains("joints without the limits"), "{note}");
    let fixed = robot(&with("revolute", "fixed")).unwrap().notes().concat();
    assert!(fixed.contains("fixed or floating joints' axes (line 4)"), "{fixed}");
    let entity = read(
        "<?xml version=\"1.0\"?>\n<!DOCTYPE robot [<!ENTITY r \"1\">]>\n<robot name=\"&r;\"/>",
    );
    let entity = entity.unwrap_err().to_string();
    assert_eq!(entity, "line 2: no URDF: a document type and its entities are not read");
}

#[test]
fn a_joint_that_is_called_like_a_value_of_another_is_refused() {
    let value = joint("prismatic", ["b", "c"], "").replace("b-c", "a-b/rot_w");
    let robot =
        [link("a"), link("b"), link("c"), joint("floating", ["a", "b"], ""), value].concat();
    assert_refused(&robot, &["line 5: there are two of joint or value \"a-b/rot_w\""]);
}

#[test]
fn nothing_inside_an_element_of_attributes_nor_an_attribute_of_another_namespace_is_dropped() {
    let joints = "<axis xyz=\"0 0 1\"/><limit lower=\"0\"/>";
    let both = [link("a"), link("b"), joint("revolute", ["a", "b"], joints)].concat();
    for (from, to, why) in [
        ("<origin xyz=\"0 0 1\"/>", "<origin>0 0 1</origin>", "line 4: joint \"a-b\": origin says"),
        (
            "<origin xyz=\"0 0 1\"/>",
            "<origin><xyz/></origin>",
            "\"xyz\" is not understood in origin",
        ),
        ("<origin xyz", "<origin xmlns:u=\"u\" u:xyz", "\"xyz\" of another namespace"),
        ("<axis xyz=\"0 0 1\"/>", "<axis>0 0 1</axis>", "axis says \"0 0 1\""),
        ("<limit lower=\"0\"/>", "<limit><lower/></limit>", "\"lower\" is not understood in limit"),
        ("<parent link=\"a\"/>", "<parent link=\"a\"><pose/></parent>", "in parent"),
        ("<limit lower=\"0\"/>", "<mimic joint=\"a-b\"><if/></mimic>", "in mimic"),
        (
            "0.1\"/>",
            "0.1\"><box/></sphere>",
            "line 2: link \"a\": element \"box\" is not understood in",
        ),
        ("<geometry>", "<geometry scale=\"2\">", "geometry has no attribute \"scale\""),
    ] {
        assert!(both.contains(from), "{from}");
        assert_refused(&both.replace(from, to), &[why]);
    }
    let drake = "0.1\"><d:soft xmlns:d=\"u\"/></sphere>";
    let noted = both.replace("0.1\"/>", drake).replace("<geometry>", "<geometry>x");
    let noted = format!("<robot name=\"r\" scale=\"2\">{noted}</robot>");
    let notes = read(&noted).unwrap().notes().concat();
    for what in ["2 soft of another namespace", "2 text in geometry", "scale of robot (line 1)"] {
        assert!(notes.contains(what), "{what}: {notes}");
    }
}

#[test]
fn a_joint_that_mimics_one_that_mimics_moves_by_both_rules_and_a_ring_of_them_is_refused() {
    let mimic = |of: &str, rule: &str| format!("<mimic joint=\"{of}\" {rule}/>");
    let arm = |first: &str| {
        let parts = [
            link("a"),
            link("b"),
            link("c"),
            link("d"),
            joint("prismatic", ["c", "d"], &mimic("b-c", "multiplier=\"3\" offset=\"1\"")),
            joint("prismatic", ["b", "c"], &mimic("a-b", "multiplier=\"2\" offset=\"-1\"")),
            joint("prismatic", ["a", "b"], first),
        ];
        parts.concat()
    };
    let robot = robot(&arm("")).unwrap();
    assert_eq!(robot.variables(), ["a-b"]);
    let mut poses = Vec::new();
    robot.place(&[0.5], &mut poses).unwrap();
    let along: Vec<f64> = poses.iter().map(|pose| pose.translation().x).collect();
    // 0.5, then 2·0.5 − 1, then 3·0 + 1.
    assert_eq!(along, [0.0, 0.5, 0.5, 1.5]);
    assert_refused(&arm(&mimic("c-d", "")), &["mimics itself"]);
    assert_refused(&arm(&mimic("x", "")), &["joint \"a-b\"", "no moved joint \"x\""]);
}

#[test]
fn a_state_beyond_limits_is_reported_with_the_joint_and_its_value() {
    let limit = "<limit lower=\"-1\" upper=\"0.5\"/>";
    let robot = robot(&[link("a"), link("b"), joint("revolute", ["a", "b"], limit)].concat());
    let robot = robot.unwrap();
    assert_eq!(robot.joints()[0].limits, Some([-1.0, 0.5]));
    assert!(robot.beyond_limits(&[0.5]).is_empty());
    let beyond = robot.beyond_limits(&[-1.25]);
    assert_eq!(
        beyond[0].to_string(),
        "joint \"a-b\" is at -1.25e0, beyond its limits -1e0 to 5e-1"
    );
}

#[test]
fn a_quaternion_in_place_of_angles_turns_alike() {
    let with = |turn: &str| {
        let text =
            link("a").replace("<geometry>", &format!("<origin xyz=\"1 2 3\" {turn}/><geometry>"));
        let robot = robot(&text).unwrap();
        let mut poses = Vec::new();
        robot.place(&[], &mut poses).unwrap();
        poses[0]
    };
    let angles = with("rpy=\"1.5707963267948966 0 0\"");
    let quaternion = with("quat_xyzw=\"0.7071067811865476 0 0 0.7071067811865476\"");
    let apart = angles.apply(glam::DVec3::ONE).distance(quaternion.apply(glam::DVec3::ONE));
    assert!(apart < 1e-15, "{apart}");
}

#[test]
fn elements_nested_fifteen_thousand_deep_are_refused_without_a_stack_overflow() {
    let nested = format!("{}{}{}", link("a"), "<x>".repeat(15_000), "</x>".repeat(15_000));
    assert_refused(&nested, &["line 3", "64 nested elements"]);
    // Where they stand in what is passed over as well.
    let inside = nested.replace("</link>\n", "").replacen("<x>", "<visual>", 1);
    assert_refused(&inside, &["64 nested elements"]);
}

/// Quadratic work on these would take minutes.
#[test]
fn a_chain_of_a_hundred_thousand_links_is_read_placed_and_allowed_in_linear_time() {
    let chain = read(&chain(100_000, "continuous")).unwrap();
    assert_eq!(chain.variables().len(), 99_999);
    let allowed = AllowedPairs::adjacent(&chain);
    assert!(allowed.contains("l7", "l6") && !allowed.contains("l7", "l5"));
    let named: Vec<(String, f64)> =
        chain.variables().iter().map(|name| (name.clone(), 0.0)).collect();
    let state = chain.state(&named).unwrap();
    let mut cell = Workcell::new(chain, &World::default(), &allowed).unwrap();
    cell.set_state(&state).unwrap();
    let last = cell.names().iter().position(|name| name == "l99999").unwrap();
    assert_eq!(cell.scene().poses()[last].translation(), glam::DVec3::Z * 99_999.0);
    assert_eq!(cell.scene().ignored_pairs().count(), 99_999);
}

#[test]
fn rigid_groups_of_thousands_of_links_take_no_pair_each() {
    let tied = read(&chain(50_000, "fixed")).unwrap();
    let allowed = AllowedPairs::adjacent(&tied);
    assert!(allowed.contains("l0", "l49999") && allowed.contains("l3", "l2"));
    let cell = Workcell::new(tied, &World::default(), &allowed).unwrap();
    assert!(!cell.scene().allows(0, 49_999) && !cell.scene().allows(7, 23_456));
}

#[test]
fn a_long_chain_of_mimics_is_followed_in_linear_time_whatever_its_order() {
    let mut text = String::from("<robot name=\"m\">\n") + &link("root");
    for k in 0..20_000 {
        text.push_str(&link(&format!("l{k}")));
        let next = k + 1;
        let mimic =
            if next < 20_000 { format!("<mimic joint=\"root-l{next}\"/>") } else { String::new() };
        let child = format!("l{k}");
        write!(text, "{}", joint("prismatic", ["root", &child], &mimic)).unwrap();
    }
    let robot = read(&(text + "</robot>")).unwrap();
    assert_eq!(robot.variables(), ["root-l19999"]);
    let mut poses = Vec::new();
    robot.place(&[0.25], &mut poses).unwrap();
    assert!(poses[1..].iter().all(|pose| pose.translation().x == 0.25));
}
