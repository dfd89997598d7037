//! Which links of a Panda arm touch each other or a shelf? Skips where the data is absent.

use dcd_io::data;
use dcd_pipeline::{Par, Pipeline};
use dcd_robot::{Robot, Srdf, Workcell, read_problems};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let files = ["panda/panda.urdf", "panda/panda.srdf", "panda/problems.tar.bz2"];
    let [Some(urdf), Some(srdf), Some(archive)] = files.map(data::file) else {
        println!("skipped: there is no panda in the data folder");
        return Ok(());
    };
    let panda = Robot::load(&urdf)?;
    let srdf = Srdf::load(&srdf)?;
    let problem = read_problems(&archive)?.swap_remove(0);
    let world = problem.scene.world(&panda, Some(&srdf))?;
    let mut allowed = srdf.allowed.clone();
    allowed.extend(&world.allowed);

    let mut cell = Workcell::new(panda, &world, &allowed)?;
    let mut pipeline = Pipeline::new();
    let (start, goal) =
        (problem.request.start_of(cell.robot())?, problem.request.goal_of(cell.robot())?);
    for percent in (0..=100u8).step_by(10) {
        let part = f64::from(percent) / 100.0;
        let state: Vec<f64> =
            start.iter().zip(&goal).map(|(a, b)| a * (1.0 - part) + b * part).collect();
        cell.set_state(&state)?;
        let step = pipeline.step(cell.scene(), Par::Serial);
        let names = cell.names();
        let touching: Vec<_> =
            step.contacts().map(|(i, j)| [&names[i as usize], &names[j as usize]]).collect();
        println!("{percent:>3} % of the way: {touching:?}");
    }
    Ok(())
}
