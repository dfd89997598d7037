//! The report on a run, as text and as JSON: by rank 0, on all ranks.

use crate::detect::{Precision, Times};
use dcd_mpi::Mpi;
use dcd_ranks::Transport;
use serde::{Deserialize, Serialize};
use std::fmt::Write;
use std::time::Duration;

/// The report of a rank to rank 0.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct RankReport {
    pub(crate) rank: usize,
    pub(crate) objects: usize,
    pub(crate) ghosts: usize,
    pub(crate) pairs: u64,
    pub(crate) contacts: usize,
    pub(crate) undecided: usize,
    pub(crate) sent_bytes: u64,
    pub(crate) received_bytes: u64,
    pub(crate) times: Vec<Times>,
    pub(crate) load_time: Duration,
    pub(crate) spread_time: Duration,
    pub(crate) sort_time: Duration,
    pub(crate) digest_time: Duration,
    pub(crate) peak_bytes: Option<u64>,
}

/// What all know.
#[derive(Clone, Debug)]
pub(crate) struct Found {
    pub(crate) objects: u64,
    pub(crate) contacts: u64,
    pub(crate) threads: usize,
    pub(crate) precision: Precision,
    pub(crate) repeats: u32,
    pub(crate) digest: u64,
}

#[derive(Serialize)]
struct Json {
    objects: u64,
    pairs: u64,
    contacts: u64,
    undecided: usize,
    threads: usize,
    precision: Precision,
    ms: Stages,
    ms_load: f64,
    ms_spread: f64,
    ms_sort: f64,
    ms_digest: f64,
    peak_rss_bytes: Option<u64>,
    digest: String,
    ranks: Vec<RankJson>,
}

#[derive(Serialize)]
struct RankJson {
    rank: usize,
    objects: usize,
    ghosts: usize,
    pairs: u64,
    /// Of the sorted contacts.
    contacts: usize,
    undecided: usize,
    bytes_sent: u64,
    bytes_received: u64,
    ms: Stages,
    peak_rss_bytes: Option<u64>,
}

#[derive(Serialize)]
struct Stages {
    exchange: Spread,
    aabbs: Spread,
    build: Spread,
    pairs: Spread,
    narrow: Spread,
    total: Spread,
}

/// Of the repeats, milliseconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
struct Spread {
    min: f64,
    median: f64,
}

/// On rank 0 the summary of all ranks' reports. Collective.
pub(crate) fn gathered(mpi: &Mpi, own: &RankReport, found: &Found, json: bool) -> Option<String> {
    // Numbers alone: nothing in it can fail.
    let own = serde_json::to_vec(own).unwrap_or_default();
    let all = mpi.all_gather(&own);
    if mpi.rank() != 0 {
        return None;
    }
    let ranks: Vec<RankReport> =
        all.iter().filter_map(|report| serde_json::from_slice(report).ok()).collect();
    Some(if json { as_json(&ranks, found) } else { as_text(&ranks, found) })
}

fn as_json(ranks: &[RankReport], found: &Found) -> String {
    let longest =
        |of: fn(&RankReport) -> Duration| ms(ranks.iter().map(of).max().unwrap_or_default());
    let json = Json {
        objects: found.objects,
        pairs: ranks.iter().map(|rank| rank.pairs).sum(),
        contacts: found.contacts,
        undecided: ranks.iter().map(|rank| rank.undecided).sum(),
        threads: found.threads,
        precision: found.precision,
        ms: Stages::of(&slowest(ranks)),
        ms_load: longest(|rank| rank.load_time),
        ms_spread: longest(|rank| rank.spread_time),
        ms_sort: longest(|rank| rank.sort_time),
        ms_digest: longest(|rank| rank.digest_time),
        peak_rss_bytes: ranks.iter().map(|rank| rank.peak_bytes).sum(),
        digest: format!("{:016x}", found.digest),
        ranks: ranks.iter().map(RankJson::of).collect(),
    };
    serde_json::to_string(&json).unwrap_or_default() + "\n"
}

fn as_text(ranks: &[RankReport], found: &Found) -> String {
    let mut text = String::new();
    let mut line = |what: &str, value: &dyn std::fmt::Display| {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{what:<16} {value}");
    };
    line("objects", &found.objects);
    line("candidate pairs", &ranks.iter().map(|rank| rank.pairs).sum::<u64>());
    line("contacts", &found.contacts);
    line("undecided", &ranks.iter().map(|rank| rank.undecided).sum::<usize>());
    line("ranks", &format_args!("{}, of {} threads", ranks.len(), found.threads));
    line("milliseconds", &format_args!("{:>11} {:>11}   of {}", "min", "median", found.repeats));
    let stages = Stages::of(&slowest(ranks));
    let rows = [
        ("  exchange", stages.exchange),
        ("  AABBs", stages.aabbs),
        ("  build", stages.build),
        ("  pairs", stages.pairs),
        ("  narrow", stages.narrow),
        ("  total", stages.total),
    ];
    for (name, Spread { min, median }) in rows {
        line(name, &format_args!("{min:>11.3} {median:>11.3}"));
    }
    let table = format!(
        "{:>5} {:>11} {:>10} {:>12} {:>12} {:>12} {:>10} {:>10}",
        "", "objects", "ghosts", "pairs", "sent", "received", "ms", "peak MB"
    );
    line("rank", &table);
    for rank in ranks {
        let RankReport { objects, ghosts, pairs, sent_bytes, received_bytes, .. } = rank;
        let total = Stages::of(&rank.times).total.median;
        let peak = rank.peak_bytes.map_or("-".into(), |bytes| format!("{:.1}", bytes as f64 / 1e6));
        let row = format!(
            "{:>5} {objects:>11} {ghosts:>10} {pairs:>12} {sent_bytes:>12} {received_bytes:>12} \
             {total:>10.3} {peak:>10}",
            ""
        );
        line(&format!("  {}", rank.rank), &row);
    }
    line("digest", &format_args!("{:016x}", found.digest));
    text
}

/// For each repeat and stage the rank that took longest.
fn slowest(ranks: &[RankReport]) -> Vec<Times> {
    let repeats = ranks.first().map_or(0, |rank| rank.times.len());
    let of = |repeat: usize, stage: usize| {
        ranks.iter().map(|rank| rank.times[repeat][stage]).max().unwrap_or_default()
    };
    (0..repeats).map(|repeat| [0, 1, 2, 3, 4, 5].map(|stage| of(repeat, stage))).collect()
}

impl RankJson {
    fn of(rank: &RankReport) -> Self {
        Self {
            rank: rank.rank,
            objects: rank.objects,
            ghosts: rank.ghosts,
            pairs: rank.pairs,
            contacts: rank.contacts,
            undecided: rank.undecided,
            bytes_sent: rank.sent_bytes,
            bytes_received: rank.received_bytes,
            ms: Stages::of(&rank.times),
            peak_rss_bytes: rank.peak_bytes,
        }
    }
}

impl Stages {
    fn of(times: &[Times]) -> Self {
        let spread = |stage: usize| Spread::of(times.iter().map(|step| step[stage]).collect());
        Self {
            exchange: spread(0),
            aabbs: spread(1),
            build: spread(2),
            pairs: spread(3),
            narrow: spread(4),
            total: spread(5),
        }
    }
}

impl Spread {
    fn of(mut times: Vec<Duration>) -> Self {
        times.sort_unstable();
        let runs = times.len();
        let nth = |k: usize| times.get(k).map_or(0.0, |&time| ms(time));
        // Between the middle two if their number is even.
        let median = (nth(runs.saturating_sub(1) / 2) + nth(runs / 2)) / 2.0;
        Self { min: nth(0), median }
    }
}

fn ms(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}
