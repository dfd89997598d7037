//! The long run between neighbouring floats: every answer judged exactly, and a file of what was
//! wrong.

use anyhow::{Result, ensure};
use dcd_benches::{Cell, Column, Header, Options, Print, Report, Table, Units, timing};
use dcd_scenes::conformance::{Case, flip};
use serde::{Deserialize, Serialize};

use crate::kinds::{self, Families};
use crate::precision::{Precision, Query, Ready, Said};
use crate::subject::{Subject, touches};

/// Answers of a unit: after so many a run that is stopped goes on.
const UNIT: u64 = 10_000;

/// Of these, answers about shapes of every kind, which the polytopes' precisions do not all know.
const UNIT_OF_KINDS: u64 = UNIT / 4;

/// What a precision said of some pairs.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Account {
    pub(crate) wrong_yes: u64,
    pub(crate) wrong_no: u64,
    pub(crate) undecided: u64,
}

impl Account {
    /// What `precision` says of all pairs of a subject whose index passes `keep`, against the truth.
    pub(crate) fn take(
        precision: Precision,
        subject: &Subject,
        keep: impl Fn(u32) -> bool,
    ) -> Self {
        let pairs: Vec<u32> = (0..subject.pairs.len() as u32).filter(|&k| keep(k)).collect();
        let mut said = Vec::new();
        let of = (precision, Query::YesNo);
        Ready::new(of, subject).run(of, subject, &pairs, &mut said);
        let mut account = Self::default();
        for (&k, &said) in pairs.iter().zip(&said) {
            match (said, subject.touches(k)) {
                (Said::Touching, false) => account.wrong_yes += 1,
                (Said::Apart, true) => account.wrong_no += 1,
                (Said::Open, _) => account.undecided += 1,
                _ => {}
            }
        }
        account
    }

    pub(crate) fn add(&mut self, other: Self) {
        self.wrong_yes += other.wrong_yes;
        self.wrong_no += other.wrong_no;
        self.undecided += other.undecided;
    }
}

/// A unit of the run.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Judged {
    answers: u64,
    /// Lines along which the pair never stopped touching, or never touched.
    without_end: u64,
    seconds: f64,
    /// In the order of [`Precision::ALL`].
    precisions: Vec<Account>,
    families: Families,
}

/// Runs, or goes on with, so many answers, and writes the report `adversary`.
pub(crate) fn run(options: &Options, answers: u64, print: Print) -> Result<()> {
    let header = Header::observe(options);
    let dir = options.dir("adversary");
    let count = answers.div_ceil(UNIT);
    let key = |unit: u64| format!("{unit:05}");
    let mut units = Units::open(&dir, &header.fingerprint(), (0..count).map(key), options.start())?;
    let mut all = Vec::new();
    for unit in 0..count {
        all.push(units.run(&key(unit), || judged(options.seed, unit))?);
    }
    let mut report = Report::new("adversary", "Between neighbouring floats", header);
    report.missing(&units);
    report.note(
        "Hulls, plates, needles and cuboids, some rounded, at 1e-6, 1 and 1e6 m, some far out, moved \
         along a line until the answer flips between two neighbouring floats. Both neighbours are \
         decided at every precision and judged exactly, by a linear program in whole numbers (for radii, by \
         the exact signed depth). So are flat and rounded shapes, compounds, meshes, cylinders and \
         cones, up to 1e12 of their sizes from the origin of their own frame, at the certified \
         precisions. No exact method of the library answers for cylinders and cones: what the \
         bound of f64 does not resolve is undecided.",
    );
    let sum = |of: fn(&Judged) -> u64| all.iter().map(of).sum::<u64>();
    let judged = sum(|unit| unit.answers + unit.families.answers());
    let seconds: f64 = all.iter().map(|unit| unit.seconds).sum();
    report.note(format!(
        "{judged} answers at {} flips in {seconds:.0} s; {} lines had no end and were passed over.",
        judged / 2,
        sum(|unit| unit.without_end + unit.families.without_end)
    ));
    report.table(table(&all)?);
    report.table(kinds::table(all.iter().map(|unit| &unit.families))?);
    report.hand_out(&dir, print)?;
    units.finish()?;
    let wrong = certified_wrong(&all);
    ensure!(wrong == 0, "{wrong} certified answers are wrong or undecided");
    Ok(())
}

fn judged(seed: u64, unit: u64) -> Result<Judged> {
    let (time, judged) = timing::time(|| -> Result<Judged> {
        let polytopes = (UNIT - UNIT_OF_KINDS) / 2;
        let flips: Vec<Option<[Case; 2]>> =
            (unit * polytopes..(unit + 1) * polytopes).map(|k| flip(seed, k, &touches)).collect();
        let without_end = flips.iter().filter(|flip| flip.is_none()).count() as u64;
        let cases: Vec<Case> = flips.into_iter().flatten().flatten().collect();
        let subject = Subject::of_flips(&cases)?;
        let precisions =
            Precision::ALL.map(|precision| Account::take(precision, &subject, |_| true)).to_vec();
        let kinds = UNIT_OF_KINDS / 2;
        let families = kinds::judged(seed, unit * kinds..(unit + 1) * kinds)?;
        Ok(Judged { answers: cases.len() as u64, without_end, seconds: 0.0, precisions, families })
    });
    Ok(Judged { seconds: time.as_secs_f64(), ..judged? })
}

fn of_precision(all: &[Judged], precision: usize) -> Account {
    all.iter().fold(Account::default(), |mut sum, unit| {
        sum.add(unit.precisions.get(precision).copied().unwrap_or_default());
        sum
    })
}

fn certified_wrong(all: &[Judged]) -> u64 {
    let certified =
        Precision::ALL.iter().enumerate().filter(|(_, precision)| precision.is_certified());
    certified
        .map(|(k, _)| of_precision(all, k))
        .map(|account| account.wrong_yes + account.wrong_no + account.undecided)
        .chain(all.iter().map(|unit| unit.families.failures()))
        .sum()
}

fn table(all: &[Judged]) -> Result<Table> {
    let counts = ["answers", "wrong yes", "wrong no", "undecided"].map(Column::new);
    let columns = [Column::new("precision")].into_iter().chain(counts);
    let columns = columns.chain([Column::new("wrong").unit("%").decimals(4)]);
    let mut table = Table::new("adversary", "Answers at neighbouring floats", columns);
    let answers: u64 = all.iter().map(|unit| unit.answers).sum();
    for (k, precision) in Precision::ALL.into_iter().enumerate() {
        let Account { wrong_yes, wrong_no, undecided } = of_precision(all, k);
        let share = 100.0 * (wrong_yes + wrong_no) as f64 / answers.max(1) as f64;
        let counts = [answers, wrong_yes, wrong_no, undecided].map(Cell::from);
        let row = [Cell::from(precision.name())].into_iter().chain(counts);
        table.push(row.chain([share.into()]))?;
    }
    Ok(table)
}
