//! What each rank has and does, on scenes of every kind.

use anyhow::{Context, Result};
use dcd_benches::{Cell, Column, Options, Report, Table, Units};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::program::Program;

const SCENES: [(&str, usize); 6] = [
    ("paper", 10_000),
    ("sparse", 1_000_000),
    ("clustered", 10_000),
    ("big-and-small", 10_000),
    ("boxes", 10_000_000),
    ("sparse", 3_000_000),
];
const RANKS: [usize; 4] = [1, 2, 4, 8];

/// Of one run.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Row {
    digest: String,
    contacts: u64,
    /// The most objects of a rank, and the most of all ranks' costs by the mean.
    most_objects: u64,
    imbalance: f64,
    ghosts: u64,
    most_sent_bytes: u64,
    exchange_ms: f64,
    total_ms: f64,
    peak_bytes: u64,
    most_peak_bytes: u64,
}

fn key(scene: &str, objects: usize, ranks: usize) -> String {
    format!("spread/{scene}/N={objects}/ranks={ranks}")
}

fn cases() -> impl Iterator<Item = (&'static str, usize, usize)> {
    SCENES.into_iter().flat_map(|(scene, objects)| {
        // What takes most memory at once, not at every number of ranks.
        let is_large = objects > 1_000_000;
        let ranks = RANKS.into_iter().filter(move |&ranks| !is_large || matches!(ranks, 2 | 4));
        ranks.map(move |ranks| (scene, objects, ranks))
    })
}

pub(crate) fn plan() -> Vec<String> {
    cases().map(|(scene, objects, ranks)| key(scene, objects, ranks)).collect()
}

pub(crate) fn measure(program: &Program, options: &Options, units: &mut Units) -> Result<()> {
    for (scene, objects, ranks) in cases() {
        units.run(&key(scene, objects, ranks), || {
            let repeats = if objects > 1_000_000 { 3 } else { 7 };
            let arguments = [
                ("--scene", scene.to_owned()),
                ("--n", objects.to_string()),
                ("--seed", options.seed.to_string()),
                ("--repeat", repeats.to_string()),
            ];
            let arguments: Vec<String> =
                arguments.into_iter().flat_map(|(name, value)| [name.to_owned(), value]).collect();
            row(&program.detect(ranks, &arguments)?)
        })?;
    }
    Ok(())
}

fn row(report: &Value) -> Result<Row> {
    let ranks = report["ranks"].as_array().context("no list of ranks")?;
    let of = |key: &str| -> Result<Vec<u64>> {
        ranks.iter().map(|rank| rank[key].as_u64().with_context(|| key.to_owned())).collect()
    };
    let (objects, pairs) = (of("objects")?, of("pairs")?);
    let costs = objects.iter().zip(&pairs).map(|(objects, pairs)| 2 * objects + pairs);
    let costs: Vec<u64> = costs.collect();
    let most = |numbers: &[u64]| numbers.iter().max().copied().unwrap_or(0);
    let mean = costs.iter().sum::<u64>() as f64 / ranks.len() as f64;
    let peaks = of("peak_rss_bytes")?;
    Ok(Row {
        digest: report["digest"].as_str().context("no digest")?.to_owned(),
        contacts: report["contacts"].as_u64().context("no contacts")?,
        most_objects: most(&objects),
        imbalance: most(&costs) as f64 / mean,
        ghosts: of("ghosts")?.iter().sum(),
        most_sent_bytes: most(&of("bytes_sent")?),
        exchange_ms: report["ms"]["exchange"]["median"].as_f64().context("no time")?,
        total_ms: report["ms"]["total"]["median"].as_f64().context("no time")?,
        peak_bytes: peaks.iter().sum(),
        most_peak_bytes: most(&peaks),
    })
}

pub(crate) fn show(units: &Units, report: &mut Report) -> Result<()> {
    let columns = [
        Column::new("scene"),
        Column::new("N"),
        Column::new("ranks"),
        Column::new("contacts"),
        Column::new("digest"),
        Column::new("most objects"),
        Column::new("imbalance").unit("×"),
        Column::new("ghosts"),
        Column::new("most sent").unit("kB"),
        Column::new("exchange").unit("ms").decimals(2),
        Column::new("whole").unit("ms").decimals(2),
        Column::new("memory of all").unit("MB").decimals(0),
        Column::new("of the largest").unit("MB").decimals(0),
    ];
    let mut table = Table::new("spread", "What the ranks have and do", columns);
    for (scene, objects, ranks) in cases() {
        let Some(row) = units.get::<Row>(&key(scene, objects, ranks)) else { continue };
        // On two cores, more ranks than two share them: their time says nothing.
        let ms = |ms: f64| if ranks <= 2 { Cell::Number(ms) } else { Cell::Missing };
        table.push([
            Cell::from(scene),
            Cell::from(objects as u64),
            Cell::from(ranks as u64),
            Cell::from(row.contacts),
            Cell::from(row.digest),
            Cell::from(row.most_objects),
            Cell::Number(row.imbalance),
            Cell::from(row.ghosts),
            Cell::Number(row.most_sent_bytes as f64 / 1e3),
            ms(row.exchange_ms),
            ms(row.total_ms),
            Cell::Number(row.peak_bytes as f64 / 1e6),
            Cell::Number(row.most_peak_bytes as f64 / 1e6),
        ])?;
    }
    report.heading("At 1, 2, 4 and 8 ranks");
    report.note(
        "`mpirun -n R dcd-mpi detect --scene S --n N --json`, medians of 7 steps (3 of the largest), a thread a rank. \
         Imbalance: the largest cost of a rank by the mean, a cost being 2 an object and 1 a candidate pair, as the \
         cuts count. Bytes are those of a step whose shapes the ranks know already.",
    );
    report.table(table);
    Ok(())
}
