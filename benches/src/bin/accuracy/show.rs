//! Tables and pictures of what was measured.

use anyhow::Result;
use dcd_benches::{Cell, Column, Header, Report, Table};

use crate::measure::{Measured, OfPrecision};
use crate::pictures;
use crate::precision::{Precision, Query};
use crate::tally::{Group, Kind};

/// What a reader of the tables must know.
const NOTES: [&str; 5] = [
    "The precisions are interleaved on slices of 512 pairs, in one process on one thread; the least time of \
     the rounds counts, slice by slice. What depends on an object alone is made outside of the \
     timer: world AABBs, the rotated vertices of packets, Parry's shapes and poses.",
    "`boxes` and `spheres` are conservative: their \"apart\" is never wrong, their \"touching\" only \
     means near; as a distance they give what is at most the true one, as a depth what is at least \
     it. `f32` and `f64` prove what they answer and leave open what they cannot prove. `certified` \
     and `certified, lanes` prove every answer. What the lanes leave open on the suite are pairs \
     beyond the range of f32 AABBs, which no scene takes; the certified solver answers those one by \
     one. Parry's answers are as it gives them; open is what it refuses.",
    "The truth of the suite is exact: whole numbers of any length, another method than any solver's. \
     The truth of a scene is the certified solver's; every pair on which a solver differs from it is \
     decided by the exact judge (`doubted`), and `overruled` counts where that is wrong.",
    "Distances are computed for the pairs that are apart, depths for those that touch. An error counts \
     in sizes of the pair (no coordinate of A − B is larger than one size); a relative error is to \
     the true distance or depth, where that is above 1e-12 of the size. On scenes the certified \
     solver is the truth, so that its own error shows on the suite alone.",
    "A wrong yes is a \"touching\" for a pair apart, a distance of 0 among them; a wrong no an \
     \"apart\" for a pair that touches.",
];

/// The report of all that was measured.
pub(crate) fn report(header: Header, found: &[Measured]) -> Result<Report> {
    let mut report = Report::new("accuracy", "What speed costs in accuracy", header);
    report.figure(pictures::yes_or_no(found)?);
    report.note(pictures::NOTE);
    for query in [Query::Distance, Query::Depth, Query::Manifold] {
        report.figure(pictures::numbers(found, query)?);
    }
    report.table(answers(found)?);
    for (query, id, title) in [
        (Query::Distance, "distances", "Distances of pairs apart"),
        (Query::Depth, "depths", "Depths of pairs that touch"),
        (Query::Manifold, "manifolds", "Depths at the deepest points of manifolds"),
    ] {
        report.table(numbers(found, query, (id, title))?);
    }
    NOTES.into_iter().for_each(|note| report.note(note));
    report.heading("Where each precision breaks");
    for (kind, title) in [(Kind::Category, "category"), (Kind::Decade, "size in metres")] {
        for query in Query::ALL {
            report.table(breaks(found, query, (kind, title))?);
        }
    }
    report.note(
        "Wrong + open answers; then, for numbers, the worst error of the rest in sizes of \
         the pair.",
    );
    report.attach("results", serde_json::to_value(found)?);
    Ok(report)
}

fn suite(found: &[Measured], query: Query) -> Option<&Measured> {
    found.iter().find(|measured| measured.subject == "suite" && measured.query == query)
}

/// One row for each subject and precision: yes or no.
fn answers(found: &[Measured]) -> Result<Table> {
    let counts = ["wrong yes", "wrong no", "undecided", "doubted", "overruled"];
    let columns = ["subject", "pairs", "precision"].map(Column::new).into_iter().chain([
        Column::new("a pair").unit("ns").decimals(1),
        Column::new("by certified, packets").unit("×").decimals(2),
    ]);
    let columns = columns.chain(counts.map(Column::new));
    let mut table = Table::new("answers", "Yes or no", columns);
    for measured in found.iter().filter(|measured| measured.query == Query::YesNo) {
        let lanes =
            measured.precisions.iter().find(|of| of.precision == Precision::Lanes).map(|of| of.ns);
        for of in &measured.precisions {
            let ratio = lanes.map_or(f64::NAN, |lanes| of.ns / lanes);
            let mut row = name_cells(measured, of);
            row.extend([of.ns, ratio].map(Cell::from));
            row.extend([of.wrong_yes, of.wrong_no, of.undecided].map(Cell::from));
            row.extend([measured.doubted, measured.overruled].map(Cell::from));
            table.push(row)?;
        }
    }
    Ok(table)
}

/// One row for each subject and precision: a number, and how far it is off.
fn numbers(found: &[Measured], query: Query, (id, title): (&str, &str)) -> Result<Table> {
    let columns = ["subject", "pairs", "precision"].map(Column::new).into_iter();
    let columns = columns.chain([Column::new("a pair").unit("ns").decimals(1)]);
    let counts = ["wrong", "undecided"].map(Column::new);
    let errors =
        ["median [sizes]", "99 % [sizes]", "worst [sizes]", "median, relative", "worst, relative"];
    let columns = columns.chain(counts).chain(errors.map(Column::new));
    let mut table = Table::new(id, title, columns);
    for measured in found.iter().filter(|measured| measured.query == query) {
        for of in &measured.precisions {
            let mut row = name_cells(measured, of);
            row.push(of.ns.into());
            row.extend([of.wrong(), of.undecided].map(Cell::from));
            row.extend(match of.errors {
                None => [const { Cell::Missing }; 5],
                Some(errors) => [
                    errors.median,
                    errors.percentile_99,
                    errors.worst,
                    errors.median_relative,
                    errors.worst_relative,
                ]
                .map(in_powers),
            });
            table.push(row)?;
        }
    }
    Ok(table)
}

fn name_cells(measured: &Measured, of: &OfPrecision) -> Vec<Cell> {
    vec![measured.subject.as_str().into(), measured.pairs.into(), of.precision.name().into()]
}

/// An error spans too many powers of ten for a fixed number of decimals.
fn in_powers(error: f64) -> Cell {
    Cell::Text(if error == 0.0 { "0".to_owned() } else { format!("{error:.1e}") })
}

/// One row for each group of the suite, one column for each precision.
fn breaks(found: &[Measured], query: Query, (kind, title): (Kind, &str)) -> Result<Table> {
    let precisions = Precision::answering(query);
    let names = precisions.iter().map(|precision| Column::new(precision.name()));
    let columns = [title, "pairs"].map(Column::new).into_iter().chain(names);
    let by = if kind == Kind::Category { "categories" } else { "decades" };
    let query_name = query.name();
    let title = format!("The suite by {title}: {query_name}");
    let mut table = Table::new(format!("{by}-{query_name}"), title, columns);
    let Some(measured) = suite(found, query) else { return Ok(table) };
    let groups = |of: &'_ OfPrecision| -> Vec<Group> {
        of.groups.iter().filter(|group| group.kind == kind).cloned().collect()
    };
    let of_methods: Vec<Vec<Group>> = measured.precisions.iter().map(groups).collect();
    let Some(first) = of_methods.first() else { return Ok(table) };
    for (row, group) in first.iter().enumerate() {
        let cells = of_methods.iter().map(|groups| groups.get(row).map_or(Cell::Missing, broken));
        let names = [Cell::from(group.name.as_str()), group.pairs.into()];
        table.push(names.into_iter().chain(cells))?;
    }
    Ok(table)
}

fn broken(group: &Group) -> Cell {
    let mut text = match (group.wrong, group.undecided) {
        (0, 0) => "·".to_owned(),
        (wrong, 0) => format!("{wrong}"),
        (wrong, open) => format!("{wrong} + {open}"),
    };
    if let Some(worst) = group.worst.filter(|&worst| worst > 0.0) {
        text = format!("{text}; {worst:.0e}");
    }
    Cell::Text(text)
}
