//! What each precision costs against how wrong it is, a picture a query.

use anyhow::Result;
use dcd_benches::TradeChart;

use crate::measure::{Measured, OfPrecision};
use crate::precision::{Precision, Query};

/// The subject whose times the pictures show, and the one whose errors they do.
const ORDINARY: &str = "paper";
const HARD: &str = "suite";

/// What a reader of the pictures must know.
pub(crate) const NOTE: &str = "Which precision to choose: left is fast, below is right, and the lowest row is zero. Nanoseconds a pair are \
     those of the paper's scene, where pairs are ordinary; errors are those of the suite, where they are not. Where a \
     precision gives no number for some of the suite's pairs, or a false yes or no, its name says for how many. \
     Pairs beyond the range of f32 AABBs, which no scene takes, do not count for packets.";

const TIME: &str = "nanoseconds a pair, paper's scene";
const GROUPS: [&str; 4] = ["dcd, in packets", "dcd, pair by pair", "bounds alone", "Parry"];

/// The group of [`GROUPS`].
fn group(precision: Precision) -> usize {
    match precision {
        precision if precision.is_in_packets() => 0,
        Precision::Boxes | Precision::Spheres => 2,
        Precision::ParryF32 | Precision::ParryF64 => 3,
        _ => 1,
    }
}

/// Yes or no: the shares of the suite's pairs that are answered wrongly and not at all.
pub(crate) fn yes_or_no(found: &[Measured]) -> Result<TradeChart> {
    let axes = [TIME, "share of the suite's pairs [%]"];
    let title = "Yes or no: time against error";
    let mut chart = TradeChart::new("trade-yes-no", title, axes, GROUPS, ["wrong", "undecided"]);
    for Point { name, group, time, of, pairs } in points(found, Query::YesNo) {
        let share = |count: usize| 100.0 * count as f64 / pairs.max(1) as f64;
        chart.push(name, group, time, &[share(of.wrong()), share(of.undecided)])?;
    }
    Ok(chart)
}

/// A number: its errors on the suite, in sizes of the pair.
pub(crate) fn numbers(found: &[Measured], query: Query) -> Result<TradeChart> {
    let name = query.name();
    let title = format!("{}{}: time against error", name[..1].to_uppercase(), &name[1..]);
    let axes = [TIME, "error on the suite [sizes of the pair]"];
    let marks = ["median", "99th percentile", "worst"];
    let mut chart = TradeChart::new(format!("trade-{name}"), title, axes, GROUPS, marks);
    for Point { name, group, time, of, pairs } in points(found, query) {
        let Some(errors) = of.errors else { continue };
        let share = |count: usize, what: &str| {
            let percent = 100.0 * count as f64 / pairs.max(1) as f64;
            (count > 0).then(|| format!("{percent:.1} % {what}"))
        };
        let broken: Vec<String> = [share(of.wrong(), "wrong"), share(of.undecided, "open")]
            .into_iter()
            .flatten()
            .collect();
        let name = match broken.as_slice() {
            [] => name.to_owned(),
            broken => format!("{name} ({})", broken.join(", ")),
        };
        chart.push(&name, group, time, &[errors.median, errors.percentile_99, errors.worst])?;
    }
    Ok(chart)
}

/// A precision in a picture.
struct Point {
    name: &'static str,
    group: usize,
    time: f64,
    of: OfPrecision,
    pairs: usize,
}

/// The precisions that were measured on both subjects.
fn points(found: &[Measured], query: Query) -> Vec<Point> {
    let of = |subject: &str| {
        found.iter().find(|measured| measured.subject == subject && measured.query == query)
    };
    let (Some(ordinary), Some(hard)) = (of(ORDINARY), of(HARD)) else { return Vec::new() };
    let point = |of: &OfPrecision| {
        let precision = of.precision;
        let timed = ordinary.precisions.iter().find(|timed| timed.precision == precision)?;
        let beyond = if precision.is_in_packets() { hard.beyond } else { 0 };
        let of = OfPrecision { undecided: of.undecided.saturating_sub(beyond), ..of.clone() };
        let (name, group) = (precision.name(), group(precision));
        (timed.ns > 0.0).then_some(Point { name, group, time: timed.ns, of, pairs: hard.pairs })
    };
    hard.precisions.iter().filter_map(point).collect()
}
