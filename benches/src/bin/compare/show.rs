//! Tables, notes and JSON of what was compared.

use anyhow::Result;
use dcd_benches::{Cell, Column, Header, Report, Table};
use dcd_gjk::Method;

use crate::json::objects;
use crate::judge::{Account, Wrong};
use crate::race::{Beside, Comparison, Race};
use crate::rivals::{PARTS, WHOLE};

/// What a reader of the tables must know.
const NOTES: [&str; 6] = [
    "A ratio is Parry's time by ours, taken round by round, the two interleaved in one process; the \
     median of the rounds, with the least and the most. Above 1 we are faster. `broad` is build and \
     pairs together. Every step is a first step: buffers are kept, nothing learnt about the poses \
     is (but for Parry's tree, which starts from the order of its last one, its fastest way).",
    "Parry is parry3d in f32: its AABBs, its binned tree, the tree against itself (the parallel \
     traversal above one thread), a query for each candidate. Its shapes are made and its poses \
     converted outside of the timer; our step starts from f64 poses.",
    "Candidates differ by rounding: both take the AABB of the rotated vertices, but our AABBs are \
     f32 rounded outward from f64, so that no contact is lost, and Parry's are f32 rounded to \
     nearest from a rotation in f32. Pairs with an object that Parry has no shape for are ours \
     alone.",
    "Our contact set is compared with that of Parry in f64; every pair on which we, Parry in f64 \
     and Parry in f32 differ is judged by exact integers on the vertices R·v + t, and `wrong` \
     counts against that. A pair that is left undecided is not wrong. Where our set is wrong no \
     time is shown.",
    "`brute force` and `every pair` are our own step without a tree, by our step: with the AABBs of \
     all pairs compared, and with all pairs given to the narrow phase as they are.",
    "Narrower paths are our own step on one thread with the instructions of CPUs that have no more, \
     in the same process, the two interleaved. Contacts and their order are the same.",
];

/// The report of all comparisons.
pub(crate) fn report(header: Header, comparisons: &[Comparison]) -> Result<Report> {
    let mut report = Report::new("compare", "Our default pipeline beside Parry's best", header);
    report.table(summary(comparisons)?);
    report.table(methods(comparisons)?);
    report.table(answers(comparisons)?);
    NOTES.into_iter().for_each(|note| report.note(note));
    for line in differences(comparisons) {
        report.note(line);
    }
    report.heading("Stages");
    report.table(ratios(comparisons)?);
    report.table(stages(comparisons)?);
    report.table(narrower(comparisons)?);
    report.attach("results", comparisons.iter().flat_map(objects).collect());
    Ok(report)
}

/// What the terminal shows: every stage of one scene, one line for each scene of several.
pub(crate) fn terminal(comparisons: &[Comparison]) -> Result<String> {
    let times = if comparisons.len() == 1 { stages(comparisons)? } else { ratios(comparisons)? };
    let mut text = String::new();
    for table in [times, narrower(comparisons)?, methods(comparisons)?, answers(comparisons)?] {
        text += &format!("{}\n\n{}\n", table.title(), table.to_markdown());
    }
    let mut notes = differences(comparisons);
    notes.extend(NOTES.map(str::to_owned));
    Ok(text + &notes.join("\n"))
}

/// The figures that most readers want: one row for each scene and number of threads.
fn summary(comparisons: &[Comparison]) -> Result<Table> {
    let mut columns = ["scene", "N", "threads", "candidates", "contacts"].map(Column::new).to_vec();
    columns.extend(["ours", "Parry f32"].map(|name| Column::new(name).unit("ms").decimals(4)));
    columns.extend(SUMMARY.map(|part| Column::new(PARTS[part]).unit("×").decimals(1)));
    columns.push(Column::new("Parry f32 wrong"));
    let title = "The step beside Parry's, and how many times as fast";
    let mut table = Table::new("summary", title, columns);
    for_each_race(comparisons, |comparison, threads, race| {
        let judged = &comparison.judged;
        let mut row = name_cells(comparison, threads);
        row.extend([judged.ours.candidates, judged.contacts].map(Cell::from));
        let whole = race.map(|race| race.parts[WHOLE]);
        row.push(whole.map(|whole| whole.ours.median).into());
        row.push(whole.map(|whole| whole.rival.median).into());
        row.extend(SUMMARY.map(|part| race.and_then(|race| race.parts[part].ratio).into()));
        row.push(judged.parry_f32.wrong().into());
        table.push(row)
    })?;
    Ok(table)
}

/// Whole, narrow and broad, as places in [`PARTS`].
const SUMMARY: [usize; 3] = [WHOLE, 4, 3];

/// What each method decides, and what each stage costs on the first number of threads.
fn methods(comparisons: &[Comparison]) -> Result<Table> {
    let decides = |k: usize| comparisons.iter().any(|c| c.decided.get(k).is_some_and(|&n| n > 0));
    let methods: Vec<usize> = (0..Method::ALL.len()).filter(|&k| decides(k)).collect();
    let mut columns = ["scene", "N", "candidates"].map(Column::new).to_vec();
    columns.extend(methods.iter().map(|&k| Column::new(spoken(k)).unit("%").decimals(2)));
    columns.push(Column::new("threads"));
    columns.extend(["boxes", "build"].map(|name| Column::new(name).unit("ns/object").decimals(1)));
    columns.extend(["pairs", "narrow"].map(|name| Column::new(name).unit("ns/pair").decimals(1)));
    let title =
        "What each method resolves, in percent of the candidates, and what each stage costs";
    let mut table = Table::new("methods", title, columns);
    for comparison in comparisons {
        let (objects, pairs) =
            (comparison.objects as f64, comparison.judged.ours.candidates as f64);
        let mut row = vec![Cell::from(comparison.scene.as_str()), comparison.objects.into()];
        row.push(comparison.judged.ours.candidates.into());
        let share = |&k: &usize| Some(100.0 * *comparison.decided.get(k)? as f64 / pairs);
        row.extend(methods.iter().map(|k| Cell::from(share(k))));
        let race = comparison.races.first();
        row.push(race.map(|race| race.threads).into());
        for (part, count) in [(0, objects), (1, objects), (2, pairs), (4, pairs)] {
            let ns = |race: &Race| race.parts[part].ours.median.as_secs_f64() * 1e9 / count;
            row.push(race.map(ns).into());
        }
        table.push(row)?;
    }
    Ok(table)
}

/// What method `k` of [`Method::ALL`] is called.
fn spoken(k: usize) -> String {
    match Method::ALL[k] {
        Method::CentreAxis => "centre axis".to_owned(),
        method => format!("{method:?}").to_lowercase(),
    }
}

/// One row for each scene and number of threads.
fn ratios(comparisons: &[Comparison]) -> Result<Table> {
    let ratio = |name: &str| Column::new(name).unit("×").decimals(2);
    let mut columns = vec![Column::new("scene"), Column::new("N"), Column::new("threads")];
    columns.extend(["ours", "Parry f32"].map(|name| Column::new(name).unit("ms").decimals(4)));
    columns.extend(["whole", "least", "most"].map(ratio));
    columns.extend(PARTS[..WHOLE].iter().map(|part| ratio(part)));
    columns.extend(["brute force", "every pair"].map(ratio));
    let mut table =
        Table::new("ratios", "Whole step, and how many times as fast as Parry", columns);
    for_each_race(comparisons, |comparison, threads, race| {
        let mut row = name_cells(comparison, threads);
        let whole = race.map(|race| race.parts[WHOLE]);
        row.push(whole.map(|whole| whole.ours.median).into());
        row.push(whole.map(|whole| whole.rival.median).into());
        let range = whole.map(|whole| [whole.ratio, whole.least, whole.most]);
        row.extend(range.unwrap_or_default().map(Cell::from));
        row.extend((0..WHOLE).map(|part| race.and_then(|race| race.parts[part].ratio).into()));
        row.push(race.and_then(|race| race.brute_force?.ratio).into());
        row.push(race.and_then(|race| race.every_pair?.ratio).into());
        table.push(row)
    })?;
    Ok(table)
}

/// One row for each scene, number of threads and stage.
fn stages(comparisons: &[Comparison]) -> Result<Table> {
    let columns = ["scene", "N", "threads", "stage"].map(Column::new).into_iter().chain([
        Column::new("ours").unit("ms").decimals(4),
        Column::new("ours, least").unit("ms").decimals(4),
        Column::new("rival").unit("ms").decimals(4),
        Column::new("rival, least").unit("ms").decimals(4),
        Column::new("ratio").unit("×").decimals(2),
        Column::new("least").unit("×").decimals(2),
        Column::new("most").unit("×").decimals(2),
        Column::new("rounds"),
    ]);
    let title = "Each stage: medians and least times, and the rival's time by ours";
    let mut table = Table::new("stages", title, columns);
    for_each_race(comparisons, |comparison, threads, race| {
        let Some(race) = race else { return Ok(()) };
        let brute = race.brute_force.as_ref().map(|beside| ("whole, brute force", beside));
        let every = race.every_pair.as_ref().map(|beside| ("whole, every pair", beside));
        for (stage, beside) in PARTS.into_iter().zip(&race.parts).chain(brute).chain(every) {
            let mut row = name_cells(comparison, threads);
            row.push(stage.into());
            for sample in [beside.ours, beside.rival] {
                row.extend([sample.median, sample.min].map(Cell::from));
            }
            row.extend([beside.ratio, beside.least, beside.most].map(Cell::from));
            row.push(race.rounds.into());
            table.push(row)?;
        }
        Ok(())
    })?;
    Ok(table)
}

/// One row for each scene and path that has narrower registers than the one measured.
fn narrower(comparisons: &[Comparison]) -> Result<Table> {
    let columns = ["scene", "N", "threads", "path"].map(Column::new).into_iter().chain([
        Column::new("widest").unit("ms").decimals(4),
        Column::new("this path").unit("ms").decimals(4),
        Column::new("times its time").unit("×").decimals(2),
        Column::new("least").unit("×").decimals(2),
        Column::new("most").unit("×").decimals(2),
    ]);
    let title = "The whole step on narrower registers, and how many times as long it takes";
    let mut table = Table::new("paths", title, columns);
    for_each_race(comparisons, |comparison, threads, race| {
        for narrower in race.map(|race| race.narrower.as_slice()).unwrap_or_default() {
            let Beside { ours, rival, ratio, least, most } = narrower.whole;
            let mut row = name_cells(comparison, threads);
            row.push(narrower.path.as_str().into());
            row.extend([ours.median, rival.median].map(Cell::from));
            row.extend([ratio, least, most].map(Cell::from));
            table.push(row)?;
        }
        Ok(())
    })?;
    Ok(table)
}

/// One row for each scene: what was found, and who is wrong.
fn answers(comparisons: &[Comparison]) -> Result<Table> {
    let columns = [
        "scene",
        "N",
        "candidates",
        "Parry's candidates",
        "contacts",
        "undecided",
        "wrong",
        "Parry f32: false contacts",
        "Parry f32: missed",
        "Parry f64: wrong",
        "Parry f64: undecided",
        "Parry refused",
        "judged exactly",
    ];
    let mut table =
        Table::new("answers", "What was found, and who is wrong", columns.map(Column::new));
    for comparison in comparisons {
        let judged = &comparison.judged;
        let Account { candidates, undecided, .. } = judged.ours;
        let counts = [
            comparison.objects,
            candidates,
            judged.parry_f32.candidates,
            judged.contacts,
            undecided,
            judged.ours.wrong(),
            judged.parry_f32.false_contacts,
            judged.parry_f32.missed,
            judged.parry_f64.wrong(),
            judged.parry_f64.undecided,
            judged.parry_f64.refused,
            judged.judged_exactly,
        ];
        let scene = Cell::from(comparison.scene.as_str());
        table.push([scene].into_iter().chain(counts.map(Cell::from)))?;
    }
    Ok(table)
}

/// The pairs on which we and Parry in f64 differ, one sentence each.
fn differences(comparisons: &[Comparison]) -> Vec<String> {
    let mut lines = Vec::new();
    for comparison in comparisons {
        for difference in &comparison.judged.differences {
            let truth = if difference.touching { "touching" } else { "apart" };
            let wrong = match difference.wrong {
                Wrong::Ours => "ours",
                Wrong::ParryF64 => "Parry f64",
            };
            let (label, i, j) = (comparison.label(), difference.i, difference.j);
            lines.push(format!("{label}: pair ({i}, {j}) is {truth}; {wrong} wrong."));
        }
    }
    lines
}

/// Calls `row` for each scene and number of threads, without times where our set is wrong.
fn for_each_race(
    comparisons: &[Comparison],
    mut row: impl FnMut(&Comparison, usize, Option<&Race>) -> Result<()>,
) -> Result<()> {
    for comparison in comparisons {
        for &threads in &comparison.threads {
            let race = comparison.races.iter().find(|race| race.threads == threads);
            row(comparison, threads, race)?;
        }
    }
    Ok(())
}

fn name_cells(comparison: &Comparison, threads: usize) -> Vec<Cell> {
    let scene = Cell::from(comparison.scene.as_str());
    vec![scene, comparison.objects.into(), threads.into()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::judge::Judged;

    fn wrong() -> Comparison {
        let ours = Account { contacts: 1, false_contacts: 1, ..Account::default() };
        let other = Account::default();
        let judged = Judged {
            contacts: 0,
            judged_exactly: 1,
            ours,
            parry_f32: other,
            parry_f64: other,
            differences: Vec::new(),
        };
        Comparison {
            scene: "paper".to_owned(),
            objects: 2,
            seed: Some(0),
            query: "intersection-test".to_owned(),
            digest: String::new(),
            judged,
            decided: Method::ALL
                .map(|method| match method {
                    Method::CentreAxis => 3,
                    Method::Cone => 1,
                    _ => 0,
                })
                .to_vec(),
            threads: vec![1],
            races: Vec::new(),
        }
    }

    #[test]
    fn a_wrong_set_has_a_row_without_times() -> Result<()> {
        let csv = ratios(&[wrong()])?.to_csv();
        let cells: Vec<&str> = csv.lines().nth(1).unwrap_or_default().split(',').collect();
        assert_eq!(cells[..3], ["paper", "2", "1"]);
        assert!(cells[3..].iter().all(|cell| cell.is_empty()), "{csv}");
        assert_eq!(stages(&[wrong()])?.to_csv().lines().count(), 1);
        assert!(summary(&[wrong()])?.to_csv().ends_with(",,,,,,0\n"));
        let objects = objects(&wrong());
        assert!(objects[0]["ms"].is_null() && objects[0]["ratio"].is_null());
        assert_eq!(objects[0]["wrong"]["ours"]["false_contacts"], 1);
        Ok(())
    }

    #[test]
    fn a_method_that_decides_nothing_anywhere_has_no_column() -> Result<()> {
        let mut comparison = wrong();
        comparison.judged.ours.candidates = 4;
        let markdown = methods(&[comparison])?.to_markdown();
        assert!(markdown.contains("| centre axis [%] | cone [%] | threads"), "{markdown}");
        assert!(markdown.contains("75.00") && markdown.contains("25.00"), "{markdown}");
        Ok(())
    }
}
