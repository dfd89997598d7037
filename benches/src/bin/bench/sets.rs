//! Correctness: every way finds one set of contacts, and the same bytes at any number of threads.

use anyhow::{Result, anyhow};
use dcd_benches::{Agreement, Column, Report, Table, Units};
use dcd_broad::{BroadPhase, TreePairs};
use dcd_exec::{Par, with_threads};
use dcd_geom::Scene;
use dcd_gjk::{Certified, NarrowPhase, Pairwise};
use dcd_parry::{ParryGjk, ParryShapes};
use dcd_pipeline::Pipeline;
use serde::{Deserialize, Serialize};

use crate::case::{Case, Cases, Setting};
use crate::every_pair::EveryPair;
use crate::runtimes;
use crate::table1::Preset;
use crate::variant::{Timed, Variant, double_phase};

/// How the result is judged beyond the variants of the figures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Judge {
    /// Every pair by the certified solver, one at a time: no AABBs, no tree, no lanes.
    BruteForce,
    /// Every pair by Parry's GJK in f64 on our support maps.
    ParryGjk,
    /// Every pair by Parry's shapes in f64 and its `intersection_test`.
    ParryIntersection,
    /// The paper's pipeline as written; the variants have it as coded.
    AsWritten,
}

impl Judge {
    const ALL: [Self; 4] =
        [Self::BruteForce, Self::ParryGjk, Self::ParryIntersection, Self::AsWritten];

    fn name(self) -> &'static str {
        match self {
            Self::BruteForce => "brute force, certified pair by pair",
            Self::ParryGjk => "Parry's GJK f64 on our support maps, all pairs",
            Self::ParryIntersection => "Parry's shapes f64, intersection_test, all pairs",
            Self::AsWritten => "double phase as written",
        }
    }

    fn key(self) -> String {
        format!("sets/{}", self.name())
    }

    /// What it finds in one parallel run.
    fn judge(self, case: &Case) -> Agreement {
        match self {
            Self::BruteForce => over_all_pairs(&Pairwise(Certified), case),
            Self::ParryGjk => over_all_pairs(&Pairwise(ParryGjk::<f64>::default()), case),
            Self::ParryIntersection => over_all_pairs(&ParryShapes::<f64>::new(&case.scene), case),
            Self::AsWritten => {
                let mut pipeline = double_phase(TreePairs::paper_as_written());
                let step = pipeline.step(&case.scene, Par::WarmPool);
                case.agreement_of(step.contacts(), step.report())
            }
        }
    }
}

fn over_all_pairs<N: NarrowPhase<Answer = ()>>(narrow: &N, case: &Case) -> Agreement {
    let mut every_pair = EveryPair::new(narrow);
    every_pair.run(&case.scene, Par::WarmPool.into());
    every_pair.agreement(case)
}

/// Digests of the ordered candidates and contacts.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Order {
    /// Numbers of threads, 0 for serial, each with its digest in hexadecimal.
    digests: Vec<(usize, String)>,
}

/// The numbers of threads that must give the same bytes; 0 is serial, without a pool.
const THREADS: [usize; 5] = [0, 1, 2, 3, 7];

fn order_key(preset: Preset) -> String {
    format!("order/{}", preset.name())
}

pub(crate) fn plan(setting: &Setting) -> Vec<String> {
    let variants = Variant::ALL.map(|variant| variant.key(setting.largest()));
    let others = Judge::ALL.map(Judge::key).into_iter().chain(Preset::ALL.map(order_key));
    variants.into_iter().chain(others).collect()
}

pub(crate) fn measure(setting: &Setting, units: &mut Units, cases: &mut Cases) -> Result<()> {
    let objects = setting.largest();
    for preset in Preset::ALL {
        units.run(&order_key(preset), || order(preset, &cases.get(objects)?.scene))?;
    }
    for judge in Judge::ALL {
        units.run(&judge.key(), || Ok(judge.judge(cases.get(objects)?)))?;
    }
    runtimes::measure_size(setting, units, cases, objects)
}

fn order(preset: Preset, scene: &Scene) -> Result<Order> {
    let digest_at = |threads: usize| {
        Ok((
            threads,
            match preset {
                Preset::AsWritten => {
                    digest(double_phase(TreePairs::paper_as_written()), scene, threads)
                }
                Preset::AsCoded => {
                    digest(double_phase(TreePairs::paper_as_coded()), scene, threads)
                }
                Preset::Ours => digest(Pipeline::new(), scene, threads),
            }?,
        ))
    };
    Ok(Order { digests: THREADS.into_iter().map(digest_at).collect::<Result<_>>()? })
}

/// Of a step on so many threads: 64-bit FNV-1a over candidates and contacts in their order.
fn digest<B, N>(mut pipeline: Pipeline<B, N>, scene: &Scene, threads: usize) -> Result<String>
where
    B: BroadPhase,
    N: NarrowPhase<Answer = ()> + Send,
{
    let mut step = |par: Par| {
        let step = pipeline.step(scene, par);
        let candidates = step.candidates().map(|pair| (pair.i, pair.j));
        let mut digest = 0xcbf2_9ce4_8422_2325_u64;
        for (i, j) in candidates.chain([(u32::MAX, u32::MAX)]).chain(step.contacts()) {
            for byte in i.to_le_bytes().into_iter().chain(j.to_le_bytes()) {
                digest = (digest ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
            }
        }
        format!("{digest:016x}")
    };
    match threads {
        0 => Ok(step(Par::Serial)),
        _ => with_threads(threads, || step(Par::WarmPool)).map_err(|error| anyhow!("{error}")),
    }
}

impl Order {
    fn is_one(&self) -> bool {
        self.digests.windows(2).all(|two| two[0].1 == two[1].1)
    }
}

/// Each set by name, and how it stands.
fn compared(setting: &Setting, units: &Units) -> Vec<(&'static str, Option<Agreement>)> {
    let variants = Variant::ALL.map(|variant| {
        let timed: Option<Timed> = units.get(&variant.key(setting.largest()));
        (variant.name, timed.map(|timed| timed.agreement))
    });
    let judges = Judge::ALL.map(|judge| (judge.name(), units.get(&judge.key())));
    variants.into_iter().chain(judges).collect()
}

pub(crate) fn draw(setting: &Setting, units: &Units, report: &mut Report) -> Result<()> {
    report.heading("Correctness");
    report.note(
        "Each set is compared, after its length, with that of our default pipeline; a pair in one of \
         the two alone is judged in exact integers, which know nothing of AABBs, trees, lanes or \
         floating point. Equal to the same set, all are equal to each other.",
    );
    let columns = [
        Column::new("way"),
        Column::new("contacts"),
        Column::new("false"),
        Column::new("missed"),
        Column::new("ours wrong"),
        Column::new("undecided"),
        Column::new("set"),
    ];
    let title = format!("Contact sets at N = {}", setting.largest());
    let mut table = Table::new("sets", title, columns);
    for (name, agreement) in compared(setting, units) {
        let count = |of: fn(&Agreement) -> u64| agreement.as_ref().map(of).into();
        let verdict = agreement.as_ref().map(|agreement| match agreement.is_equal() {
            true => "equal".to_owned(),
            false => format!("differs, such as {:?}", agreement.examples),
        });
        table.push([
            name.into(),
            count(|a| a.found),
            count(|a| a.false_contacts),
            count(|a| a.missed),
            count(|a| a.expected_wrong),
            count(|a| a.undecided),
            verdict.into(),
        ])?;
    }
    report.table(table);
    draw_order(setting, units, report)
}

fn draw_order(setting: &Setting, units: &Units, report: &mut Report) -> Result<()> {
    let threads = THREADS.map(|threads| match threads {
        0 => Column::new("serial"),
        1 => Column::new("1 thread"),
        _ => Column::new(format!("{threads} threads")),
    });
    let columns = [Column::new("pipeline")].into_iter().chain(threads);
    let title = format!("Digests of candidates and contacts in order at N = {}", setting.largest());
    let mut table = Table::new("order", title, columns);
    for preset in Preset::ALL {
        let order: Option<Order> = units.get(&order_key(preset));
        let digest = |k: usize| {
            let order = order.as_ref().and_then(|order| order.digests.get(k));
            order.map(|(_, digest)| digest.as_str()).into()
        };
        let digests = (0..THREADS.len()).map(digest);
        table.push([preset.name().into()].into_iter().chain(digests))?;
    }
    report.table(table);
    Ok(())
}

/// How the contacts of our judges stand, as far as they are known.
pub(crate) fn agreements(units: &Units) -> Vec<(String, Agreement)> {
    let ours = [Judge::BruteForce, Judge::AsWritten].map(Judge::key);
    ours.into_iter().filter_map(|key| units.get(&key).map(|agreement| (key, agreement))).collect()
}

/// The pipelines whose order is known to depend on the number of threads.
pub(crate) fn unordered(units: &Units) -> Vec<String> {
    let depends = |preset: &Preset| {
        let order: Option<Order> = units.get(&order_key(*preset));
        order.is_some_and(|order| !order.is_one())
    };
    Preset::ALL.into_iter().filter(depends).map(order_key).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use dcd_benches::Effort;

    const SETTING: Setting = Setting { effort: Effort::Quick, seed: 1, sizes: &[1000] };

    #[test]
    fn every_way_finds_one_set_among_a_thousand_objects() -> Result<()> {
        let mut cases = Cases::of(&SETTING);
        let case = cases.get(1000)?;
        for variant in Variant::ALL {
            let timed = variant.measure(&SETTING, case)?;
            assert!(timed.agreement.is_equal(), "{}: {:?}", variant.name, timed.agreement);
            assert!(timed.agreement.found > 5000, "{}", variant.name);
        }
        for judge in Judge::ALL {
            let agreement = judge.judge(case);
            assert!(agreement.is_equal(), "{}: {agreement:?}", judge.name());
        }
        Ok(())
    }

    #[test]
    fn the_ordered_result_is_the_same_bytes_at_any_number_of_threads() -> Result<()> {
        let mut cases = Cases::of(&SETTING);
        let scene = &cases.get(1000)?.scene;
        for preset in Preset::ALL {
            let order = order(preset, scene)?;
            assert!(order.is_one() && order.digests.len() == 5, "{preset:?}: {order:?}");
        }
        Ok(())
    }

    #[test]
    fn a_digest_sees_the_order() -> Result<()> {
        let mut cases = Cases::of(&SETTING);
        let scene = &cases.get(100)?.scene;
        let ours = digest(Pipeline::new(), scene, 0)?;
        let paper = digest(double_phase(TreePairs::default()), scene, 0)?;
        assert_ne!(ours, paper, "one set of candidates and contacts, in two orders");
        Ok(())
    }
}
