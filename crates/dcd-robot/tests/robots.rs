//! The robots of the data folder, which nobody here made. Without it these tests say that they skip.
#![allow(missing_docs)]

use dcd_geom::Pose;
use dcd_io::data;
use dcd_robot::{AllowedPairs, Motion, Robot, Workcell, World, read_problems};
use glam::DVec3;
use std::path::PathBuf;

/// A file, or the news that the test skips.
fn file(path: &str) -> Option<PathBuf> {
    let found = data::file(path);
    if found.is_none() {
        println!("skipped: {path} is not there");
    }
    found
}

fn panda() -> Option<Robot> {
    file("panda/panda.urdf").map(|urdf| Robot::load(&urdf).unwrap())
}

fn placed(robot: &Robot, state: &[f64]) -> Vec<Pose> {
    let mut poses = Vec::new();
    robot.place(state, &mut poses).unwrap();
    poses
}

#[test]
fn the_panda_has_seven_joints_and_eleven_hulls() {
    let Some(panda) = panda() else { return };
    assert_eq!((panda.name.as_str(), panda.links().len(), panda.parts().len()), ("panda", 13, 11));
    let expected: Vec<String> = (1..=7).map(|k| format!("panda_joint{k}")).collect();
    assert_eq!(panda.variables(), expected);
    let fixed = panda.joints().iter().filter(|joint| joint.motion == Motion::Fixed).count();
    assert_eq!((panda.joints().len(), fixed), (12, 5));
    for part in panda.parts() {
        let vertices = part.shape.as_polytope().unwrap().vertices().len();
        assert!((8..1000).contains(&vertices), "{} {vertices}", panda.links()[part.link].name);
    }
}

/// Stretched out at rest: heights are sums of the file's offsets, and the arm's axis is x = 0 up to
/// the wrist, which stands out by 0.088.
#[test]
fn the_panda_at_rest_stands_where_its_offsets_add_up() {
    let Some(panda) = panda() else { return };
    let at = |poses: &[Pose], name: &str| {
        let part = panda.parts().iter().position(|part| panda.links()[part.link].name == name);
        poses[part.unwrap()]
    };
    let rest = placed(&panda, &[0.0; 7]);
    let near = |pose: Pose, x: f64, z: f64| {
        let t = pose.translation();
        assert!(t.distance(DVec3::new(x, 0.0, z)) < 1e-10, "{t}");
    };
    near(at(&rest, "panda_link1"), 0.0, 0.333);
    near(at(&rest, "panda_link3"), 0.0, 0.333 + 0.316);
    near(at(&rest, "panda_link4"), 0.0825, 0.333 + 0.316);
    near(at(&rest, "panda_link5"), 0.0, 0.333 + 0.316 + 0.384);
    near(at(&rest, "panda_link7"), 0.088, 0.333 + 0.316 + 0.384);
    // The hand points down.
    near(at(&rest, "panda_hand"), 0.088, 0.333 + 0.316 + 0.384 - 0.107);
    let turned = placed(&panda, &[std::f64::consts::PI, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    near(at(&turned, "panda_hand"), -0.088, 0.333 + 0.316 + 0.384 - 0.107);
    for (a, b) in rest.iter().zip(&turned) {
        assert!((a.translation().z - b.translation().z).abs() < 1e-10);
    }
}

#[test]
fn the_pandas_srdf_names_its_adjacent_links() {
    let (Some(panda), Some(srdf)) = (panda(), file("panda/panda.srdf")) else { return };
    let allowed = AllowedPairs::load(&srdf).unwrap();
    assert_eq!(allowed.len(), 34);
    for joint in panda.joints() {
        let [a, b] = [joint.parent, joint.child].map(|link| panda.links()[link].name.as_str());
        let shaped = |name: &str| panda.parts().iter().any(|p| panda.links()[p.link].name == name);
        assert!(!shaped(a) || !shaped(b) || allowed.contains(a, b), "{a} {b}");
    }
    // What is adjacent by the joints alone, the SRDF allows too, but for rigid pairs.
    let adjacent = AllowedPairs::adjacent(&panda);
    assert!(adjacent.contains("panda_hand", "panda_link7"));
    assert!(!adjacent.contains("panda_link0", "panda_link2"));
}

#[test]
fn the_archive_holds_seven_sets_of_a_hundred_problems() {
    let (Some(panda), Some(archive)) = (panda(), file("panda/problems.tar.bz2")) else { return };
    let problems = read_problems(&archive).unwrap();
    assert_eq!(problems.len(), 700);
    let mut sets: Vec<&str> = problems.iter().map(|problem| problem.set.as_str()).collect();
    sets.dedup();
    assert_eq!(sets.len(), 7);
    let mut obstacles = 0;
    for problem in &problems {
        let world = problem.scene.world(&panda, None).unwrap();
        obstacles += world.obstacles.len();
        let [start, goal] =
            [problem.request.start_of(&panda), problem.request.goal_of(&panda)].map(Result::unwrap);
        assert_ne!(start, goal, "{} {}", problem.set, problem.number);
        assert!(world.allowed.contains("panda_hand", "panda_link6"));
        assert_eq!(world.base, None);
        // What the URDF fixes is named, and nothing else is left unsaid.
        let [fingers] = &world.notes[..] else { panic!("{:?}", world.notes) };
        assert!(fingers.contains("panda_finger_joint1, panda_finger_joint2"), "{fingers}");
    }
    assert_eq!(obstacles, 8_200);
    let first = &problems[0];
    let world = first.scene.world(&panda, None).unwrap();
    let mut cell = Workcell::new(panda.clone(), &world, &world.allowed).unwrap();
    cell.set_state(&first.request.start_of(&panda).unwrap()).unwrap();
    assert_eq!(cell.scene().len(), 11 + world.obstacles.len());
    assert_eq!(cell.scene().static_count(), world.obstacles.len());
    assert_eq!(cell.names()[0], "panda_link0");
}

#[test]
fn the_atlas_is_read_too() {
    let Some(folder) = data::folder().map(|folder| folder.join("atlas")) else {
        println!("skipped: there is no data folder");
        return;
    };
    let files = std::fs::read_dir(&folder).into_iter().flatten().flatten();
    let urdf = files.map(|file| file.path()).find(|path| path.extension() == Some("urdf".as_ref()));
    let Some(urdf) = urdf else {
        println!("skipped: atlas is not there");
        return;
    };
    let atlas = Robot::load(&urdf).unwrap();
    println!("{}: {} links, {} parts", atlas.name, atlas.links().len(), atlas.parts().len());
    assert!(atlas.variables().len() >= 28 && atlas.parts().len() >= 20);
    let allowed = AllowedPairs::adjacent(&atlas);
    let state = vec![0.0; atlas.variables().len()];
    let mut cell = Workcell::new(atlas, &World::default(), &allowed).unwrap();
    cell.set_state(&state).unwrap();
    assert!(cell.scene().is_filtered());
}

/// A robot of one link, whose mesh has those points.
fn robot_of_points(name: &str, points: impl ExactSizeIterator<Item = DVec3>) -> Robot {
    let folder = std::env::temp_dir().join(format!("dcd-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    // A point that no face has is not read.
    let faces: String =
        (3..=points.len()).map(|k| format!("f {} {} {k}\n", k - 2, k - 1)).collect();
    let vertices: String = points.map(|p| format!("v {} {} {}\n", p.x, p.y, p.z)).collect();
    let mesh = vertices + &faces;
    std::fs::write(folder.join("link.obj"), mesh).unwrap();
    let urdf = folder.join("robot.urdf");
    let text = "<robot name=\"r\"><link name=\"a\"><collision><geometry>\
        <mesh filename=\"link.obj\"/></geometry></collision></link></robot>";
    std::fs::write(&urdf, text).unwrap();
    let robot = Robot::load(&urdf).unwrap();
    std::fs::remove_dir_all(&folder).unwrap();
    robot
}

#[test]
fn a_mesh_of_more_than_four_thousand_points_is_reduced_to_its_corners() {
    let vertices = |robot: Robot| robot.parts()[0].shape.as_polytope().unwrap().vertices().len();
    let cell = |k: u32| DVec3::new((k % 30).into(), (k / 30 % 30).into(), (k / 900).into());
    assert_eq!(vertices(robot_of_points("solid", (0..27_000).map(cell))), 8);
    assert_eq!(vertices(robot_of_points("flat", (0..900).map(cell))), 4);
}
