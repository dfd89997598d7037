//! `dcd robot --acm` as a stranger runs it. Tests of the shared robots say that they skip where they are absent.
#![allow(missing_docs)]

mod common;

use common::{Folder, dcd};
use dcd_io::data;
use dcd_pipeline::{Par, Pipeline};
use dcd_robot::{Robot, Srdf, Workcell, World};
use serde_json::{Value, json};

/// Two bars that turn about the ends of a base by half a turn at most; they meet at rest.
const ARMS: &str = r#"<robot name="arms">
  <link name="base"><collision><geometry><box size="2 0.1 0.1"/></geometry></collision></link>
  <link name="left"><collision><origin xyz="0.5 0 0"/><geometry><box size="1.2 0.1 0.1"/></geometry></collision></link>
  <link name="right"><collision><origin xyz="-0.5 0 0"/><geometry><box size="1.2 0.1 0.1"/></geometry></collision></link>
  <joint name="l" type="revolute"><origin xyz="-1 0 0.2"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/>
    <parent link="base"/><child link="left"/></joint>
  <joint name="r" type="revolute"><origin xyz="1 0 0.2"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/>
    <parent link="base"/><child link="right"/></joint>
</robot>"#;

#[test]
fn a_pair_that_touches_at_rest_is_a_fault_that_is_written_only_on_request() {
    let folder = Folder::new("acm");
    let urdf = folder.file("arms.urdf", ARMS);
    let out = folder.path("out.srdf");
    let ran = dcd(&["robot", &urdf, "--acm", &out, "--json"]);
    assert_eq!(ran.code, Some(0), "{ran:?}");
    let reported: Value = serde_json::from_str(&ran.stdout).unwrap();
    assert_eq!((&reported["adjacent"], &reported["at_rest"]), (&json!(2), &json!(1)));
    assert!(ran.stderr.contains("touch at rest"), "{ran:?}");
    let written = std::fs::read_to_string(&out).unwrap();
    assert!(!written.contains("Default") && written.contains("Adjacent"), "{written}");
    let ran = dcd(&["robot", &urdf, "--acm", &out, "--allow-default"]);
    assert_eq!(ran.code, Some(0), "{ran:?}");
    assert!(std::fs::read_to_string(&out).unwrap().contains("reason=\"Default\""));
    // What was written is read: nothing touches at rest any more.
    let ran = dcd(&["robot", &urdf, "--srdf", &out]);
    assert!(ran.code == Some(0) && ran.stdout.contains("nothing touches"), "{ran:?}");
    let refused = dcd(&["robot", &urdf, "--acm", &urdf]);
    assert_eq!(refused.code, Some(2), "it would write over the robot: {refused:?}");
}

/// Every pair that is marked as one that never touches, in fresh samples.
fn never_holds(name: &str, urdf: &str) {
    let Some(urdf) = data::file(urdf) else {
        println!("skipped: {urdf} is not there");
        return;
    };
    let folder = Folder::new(name);
    let out = folder.path("out.srdf");
    let ran = dcd(&["robot", urdf.to_str().unwrap(), "--acm", &out, "--json"]);
    assert_eq!(ran.code, Some(0), "{ran:?}");
    let reported: Value = serde_json::from_str(&ran.stdout).unwrap();
    let never = ["never_proved", "never_sampled"].map(|key| reported[key].as_u64().unwrap());
    assert!(never.iter().sum::<u64>() > 0, "{reported}");
    let text = std::fs::read_to_string(&out).unwrap();
    let never: Vec<&str> = text.lines().filter(|line| line.contains("\"Never\"")).collect();
    let never = format!("<robot name=\"r\">{}</robot>", never.concat());
    let never = Srdf::read(&never).unwrap().allowed;
    let robot = Robot::load(&urdf).unwrap();
    // All pairs but the adjacent ones are checked.
    let adjacent: Vec<&str> = text.lines().filter(|line| !line.contains("\"Never\"")).collect();
    let adjacent = Srdf::read(&adjacent.join("\n")).unwrap().allowed;
    let limits: Vec<[f64; 2]> = robot
        .variables()
        .iter()
        .map(|name| {
            let joint = robot.joints().iter().find(|joint| joint.name == *name).unwrap();
            joint.limits.unwrap_or([-3.2, 3.2])
        })
        .collect();
    let mut cell = Workcell::new(robot, &World::default(), &adjacent).unwrap();
    let (mut pipeline, mut seed) = (Pipeline::new(), 0x9e37_79b9_7f4a_7c15u64);
    for _ in 0..100_000 {
        let state: Vec<f64> = limits
            .iter()
            .map(|[lower, upper]| {
                seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                lower + (upper - lower) * ((seed >> 11) as f64 / (1u64 << 53) as f64)
            })
            .collect();
        cell.set_state(&state).unwrap();
        let step = pipeline.step(cell.scene(), Par::Serial);
        for pair in step.contacts() {
            let [a, b] = cell.names_of(pair);
            assert!(!never.contains(a, b), "{name}: {a} and {b} touch at {state:?}");
        }
    }
}

#[test]
fn pairs_of_the_panda_that_never_touch_do_not_in_fresh_samples() {
    never_holds("acm-panda", "panda/panda.urdf");
}

#[test]
fn pairs_of_the_pr2_that_never_touch_do_not_in_fresh_samples() {
    let pr2 = "robots/example-robot-data/robots/pr2_description/urdf/pr2.urdf";
    never_holds("acm-pr2", pr2);
}

#[test]
fn pairs_of_the_ur10_that_never_touch_do_not_in_fresh_samples() {
    never_holds("acm-ur10", "robots/ur_description/urdf/ur10.urdf");
}
