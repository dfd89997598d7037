//! The Panda among its obstacles and every seeded scene, on every path of the lanes that this CPU has,
//! the portable one among them: the contacts are those of f64 and integers, pair by pair.

use dcd_geom::Scene;
use dcd_gjk::{Certified, Pairwise};
use dcd_io::data;
use dcd_pipeline::{BroadPhase, NarrowPhase, Overlap, Par, Pipeline, WideTree};
use dcd_scenes::SceneSpec;
use dcd_simd::Path;

/// The sorted contacts of a step, none undecided.
fn contacts(broad: impl BroadPhase, narrow: impl NarrowPhase, scene: &Scene) -> Vec<(u32, u32)> {
    let mut pipeline = Pipeline::with(broad, narrow);
    let step = pipeline.step(scene, Par::Serial);
    assert!(step.report().undecided().is_empty());
    let mut contacts: Vec<_> = step.contacts().collect();
    contacts.sort_unstable();
    contacts
}

/// How many contacts there are, the same on every path.
fn agreed(name: &str, scene: &Scene) -> usize {
    let truth = contacts(WideTree::on(Path::Portable), Pairwise(Certified), scene);
    for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
        let found = contacts(WideTree::on(path), Overlap::on(path), scene);
        assert_eq!(found, truth, "{name} on {path:?}");
    }
    truth.len()
}

#[test]
fn every_seeded_scene_has_the_same_contacts_on_every_path() {
    for spec in SceneSpec::all() {
        if spec.name().starts_with("game") && data::file("hulls/convex_hulls.bin").is_none() {
            println!("skipped: {} needs hulls/convex_hulls.bin", spec.name());
            continue;
        }
        // All of the identical ones touch each other.
        let objects = if spec.name() == "identical" { 60 } else { 1_000 };
        for seed in [1, 2] {
            let scene = spec.with_objects(objects).with_seed(seed).scene().unwrap();
            let found = agreed(spec.name(), &scene);
            println!("{}: {found} contacts", spec.name());
            assert!(found > 0 || spec.name() == "bricks-apart", "{}", spec.name());
        }
    }
}

#[test]
fn the_panda_has_the_same_contacts_on_every_path_in_every_problem_of_the_archive() {
    use dcd_robot::{Robot, Srdf, Workcell, read_problems};
    let file = |name: &str| data::file(&format!("panda/{name}"));
    let files = ["panda.urdf", "panda.srdf", "problems.tar.bz2"].map(file);
    let [Some(urdf), Some(srdf), Some(archive)] = files else {
        return println!("skipped: the Panda is not there");
    };
    let (panda, srdf) = (Robot::load(&urdf).unwrap(), Srdf::load(&srdf).unwrap());
    let (mut cells, mut found) = (0, 0);
    for problem in read_problems(&archive).unwrap() {
        let world = problem.scene.world(&panda, Some(&srdf)).unwrap();
        let mut allowed = srdf.allowed.clone();
        allowed.extend(&world.allowed);
        let mut cell = Workcell::new(panda.clone(), &world, &allowed).unwrap();
        let start = problem.request.start_of(&panda).unwrap();
        let goal = problem.request.goal_of(&panda).unwrap();
        // Neither end touches anything; on the straight way between them much does.
        for part in [0.0, 0.3, 0.5, 0.7] {
            let state = start.iter().zip(&goal).map(|(a, b)| a * (1.0 - part) + b * part);
            cell.set_state(&state.collect::<Vec<_>>()).unwrap();
            found += agreed(&problem.number, cell.scene());
        }
        cells += 1;
    }
    println!("{cells} problems, {found} contacts");
    assert!(cells == 700 && found > 500, "{cells} problems, {found} contacts");
}
