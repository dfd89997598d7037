//! Figures 1 and 2: the runtimes of all variants over the number of objects.

use anyhow::Result;
use dcd_benches::{Agreement, Axis, Column, Figure, Report, Series, Table, Units};

use crate::case::{Cases, Setting};
use crate::published;
use crate::variant::{Timed, Variant};

/// Every variant at every size, the small sizes first.
pub(crate) fn plan(setting: &Setting) -> Vec<String> {
    let at = |&objects: &usize| Variant::ALL.map(|variant| variant.key(objects));
    setting.sizes.iter().flat_map(at).collect()
}

pub(crate) fn measure(setting: &Setting, units: &mut Units, cases: &mut Cases) -> Result<()> {
    setting.sizes.iter().try_for_each(|&objects| measure_size(setting, units, cases, objects))
}

/// All variants at one size.
pub(crate) fn measure_size(
    setting: &Setting,
    units: &mut Units,
    cases: &mut Cases,
    objects: usize,
) -> Result<()> {
    for variant in Variant::ALL {
        units.run(&variant.key(objects), || variant.measure(setting, cases.get(objects)?))?;
    }
    Ok(())
}

/// Fills in all variants, and what the paper prints of them.
fn with_runtimes(mut figure: Figure, setting: &Setting, units: &Units) -> Result<Figure> {
    for variant in Variant::ALL {
        let points = setting.sizes.iter().filter_map(|&objects| {
            let timed: Timed = units.get(&variant.key(objects))?;
            Some((objects as f64, timed.sample.median.as_secs_f64() * 1e3))
        });
        figure.push(Series::measured(variant.name, points))?;
    }
    if setting.largest() == published::OBJECTS {
        for variant in Variant::ALL {
            let point = variant.published().map(|ms| (published::OBJECTS as f64, ms));
            if point.is_some() {
                figure.push(Series::published(variant.name, point))?;
            }
        }
    }
    Ok(figure)
}

pub(crate) fn draw_figure_1(setting: &Setting, units: &Units, report: &mut Report) -> Result<()> {
    report.heading("Figures 1 and 2: end to end");
    report.note(format!(
        "Our narrow phase is our GJK in f64, one pair at a time; Parry's is its own shapes in f64 \
         judged by `distance`, as the paper judged; both decide all pairs, without a broad phase. The \
         double phase is the paper's pipeline as coded, with our GJK. The paper prints numbers for \
         the double phase at N = {} alone: the sums of its Table 1.",
        published::OBJECTS
    ));
    let [x, y] = [Axis::linear("objects N"), Axis::linear("runtime [ms]")];
    let figure = Figure::new("fig1", "Figure 1: end-to-end runtime", x, y);
    report.figure(with_runtimes(figure, setting, units)?);
    report.table(runtime_table(setting, units)?);
    Ok(())
}

pub(crate) fn draw_figure_2(setting: &Setting, units: &Units, report: &mut Report) -> Result<()> {
    let [x, y] = [Axis::logarithmic("objects N"), Axis::logarithmic("runtime [ms]")];
    let figure = Figure::new("fig2", "Figure 2: end-to-end runtime, logarithmic", x, y);
    report.figure(with_runtimes(figure, setting, units)?);
    let Some(growth) = growth(setting, units)? else { return Ok(()) };
    report.note(
        "The paper's text calls the parallel double phase about constant in N. In its scene the \
         space stays the same while N grows, so the candidates grow with N squared, and so does \
         every variant; the linear scale hides it. The exponent is that of N between the two sizes.",
    );
    report.table(growth);
    Ok(())
}

fn runtime_table(setting: &Setting, units: &Units) -> Result<Table> {
    let variants = Variant::ALL.map(|variant| Column::new(variant.name).unit("ms"));
    let columns = [Column::new("N")].into_iter().chain(variants);
    let mut table = Table::new("runtimes", "End-to-end runtime, medians", columns);
    for &objects in setting.sizes {
        let time = |variant: Variant| {
            let timed: Option<Timed> = units.get(&variant.key(objects));
            timed.map(|timed| timed.sample.median).into()
        };
        table.push([objects.into()].into_iter().chain(Variant::ALL.map(time)))?;
    }
    Ok(table)
}

/// How the runtime grows from half of the largest size to that; `None` without such a size.
fn growth(setting: &Setting, units: &Units) -> Result<Option<Table>> {
    let large = setting.largest();
    let small = large / 2;
    if !setting.sizes.contains(&small) {
        return Ok(None);
    }
    let ms = |objects: usize| Column::new(format!("N = {objects}")).unit("ms");
    let exponent = Column::new("exponent").decimals(2);
    let columns = [Column::new("variant"), ms(small), ms(large), exponent];
    let mut table = Table::new("growth", "Growth of the runtime with N", columns);
    for variant in Variant::ALL {
        let time = |objects| {
            let timed: Option<Timed> = units.get(&variant.key(objects));
            timed.map(|timed| timed.sample.median.as_secs_f64() * 1e3)
        };
        let (before, after) = (time(small), time(large));
        let exponent = before.zip(after).map(|(before, after)| (after / before).log2());
        table.push([variant.name.into(), before.into(), after.into(), exponent.into()])?;
    }
    Ok(Some(table))
}

/// How the contacts of our variants stand at every size, as far as they are known.
pub(crate) fn agreements(setting: &Setting, units: &Units) -> Vec<(String, Agreement)> {
    let ours = Variant::ALL.into_iter().filter(Variant::is_ours);
    let keys = ours.flat_map(|variant| setting.sizes.iter().map(move |&size| variant.key(size)));
    let agreement = |key: String| {
        let timed: Timed = units.get(&key)?;
        Some((key, timed.agreement))
    };
    keys.filter_map(agreement).collect()
}
