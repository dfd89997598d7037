//! What thousands of ranks would take, by the model of ghosts, measured steps and published networks.

use anyhow::Result;
use dcd_benches::{Cell, Column, Options, Report, Table, timing};
use dcd_exec::Par;
use dcd_pipeline::Pipeline;
use dcd_scenes::SceneSpec;

use crate::model::{Fitted, World};

/// A network as published: seconds for a message, bytes a second and rank.
struct Network {
    name: &'static str,
    latency: f64,
    bandwidth: f64,
}

/// Ethernet of 40 Gb/s with usNIC: 1.93 µs and 37.23 Gb/s between two hosts under Open MPI 1.8.1 (Squyres,
/// "MPI over 40Gb Ethernet", blogs.cisco.com). Red Storm: at most 5 µs between its furthest nodes and 1.5
/// GB/s into each by its requirements (Brightwell et al., "Portals 3.3 on the Sandia/Cray Red Storm
/// system").
const NETWORKS: [Network; 2] = [
    Network { name: "40 GbE", latency: 1.93e-6, bandwidth: 37.23e9 / 8.0 },
    Network { name: "Red Storm", latency: 5e-6, bandwidth: 1.5e9 },
];

/// Ranks that a rank in the middle shares a face, an edge or a corner with.
const NEIGHBOURS: f64 = 26.0;

const RANKS: [usize; 5] = [8, 64, 512, 1_024, 4_096];
const WEAK_A_RANK: f64 = 244_140.625;
const STRONG_OBJECTS: f64 = 1e9;
/// Objects of the step that is timed, in a full run and in a quick one.
const TIMED: [usize; 2] = [250_000, 4_000];

/// Seconds an object and step of so many on one thread: measured here.
fn seconds_an_object(objects: usize) -> Result<f64> {
    let scene = SceneSpec::sparse().with_objects(objects).scene()?;
    let mut pipeline = Pipeline::new();
    let mut times: Vec<f64> = (0..7)
        .map(|_| {
            timing::time(|| pipeline.step(&scene, Par::Serial).contact_count()).0.as_secs_f64()
        })
        .collect();
    times.sort_unstable_by(f64::total_cmp);
    Ok(times[times.len() / 2] / objects as f64)
}

pub(crate) fn show(
    options: &Options,
    (world, fitted): (World, Fitted),
    report: &mut Report,
) -> Result<()> {
    let timed = TIMED[usize::from(options.quick)];
    // A million boxes are cut for each.
    let ranks = if options.quick { &RANKS[..1] } else { &RANKS };
    let an_object = seconds_an_object(timed)?;
    let mut columns = vec![
        Column::new("scaling"),
        Column::new("ranks (assumed)"),
        Column::new("objects (assumed)").decimals(0),
        Column::new("ghosts a rank (model)").decimals(0),
        Column::new("sent a rank (model)").unit("kB").decimals(0),
        Column::new("step (measured rate)").unit("ms").decimals(2),
    ];
    for network in &NETWORKS {
        columns.push(
            Column::new(format!("exchange, {} (published rate)", network.name))
                .unit("ms")
                .decimals(3),
        );
        columns.push(Column::new(format!("efficiency, {}", network.name)).decimals(3));
    }
    let mut table = Table::new("forecast", "Thousands of ranks", columns);
    for scaling in ["weak", "strong"] {
        for &ranks in ranks {
            let count = ranks as f64;
            let objects = if scaling == "weak" { WEAK_A_RANK * count } else { STRONG_OBJECTS };
            let ghosts = fitted.ghosts(world.with_objects(objects), ranks) / count;
            let bytes = ghosts * fitted.bytes_a_ghost;
            let own = objects / count;
            let step = (own + ghosts) * an_object;
            let mut row = vec![
                Cell::from(scaling),
                Cell::from(ranks as u64),
                Cell::Number(objects),
                Cell::Number(ghosts),
                Cell::Number(bytes / 1e3),
                Cell::Number(step * 1e3),
            ];
            for network in &NETWORKS {
                // The counts go to all ranks in as many rounds as halvings, each of half of them; then the
                // ghosts to the neighbours.
                let rounds = count.log2();
                let counts = rounds * (network.latency + 8.0 * count / 2.0 / network.bandwidth);
                let exchange = counts + NEIGHBOURS * network.latency + bytes / network.bandwidth;
                row.push(Cell::Number(exchange * 1e3));
                row.push(Cell::Number(own * an_object / (step + exchange)));
            }
            table.push(row)?;
        }
    }
    report.heading("Thousands of ranks");
    report.note(format!(
        "Nobody has run this. Assumed: a cube of the density of `sparse`, ranks of one thread of this machine, equal \
         costs, no other traffic. Measured: {:.0} ns an object and step ({timed} objects, one thread), ghosts and bytes \
         as fitted above. Published: 1.93 µs and 37.23 Gb/s of 40 Gb Ethernet with usNIC (Squyres, “MPI over 40Gb \
         Ethernet”, blogs.cisco.com), 5 µs and 1.5 GB/s of Red Storm, its requirements (Brightwell et al., “Portals \
         3.3 on the Sandia/Cray Red Storm system”). Weak: as many objects a rank as a billion on 4,096; strong: a \
         billion. Efficiency: a step of a rank's own objects by the whole.",
        an_object * 1e9
    ));
    report.table(table);
    Ok(())
}
