//! Scenes on which absolute tolerances fail: tiny ones, and aligned boxes.

use anyhow::Result;
use dcd_benches::{Agreement, Column, Report, Table, Units};
use dcd_broad::WideTree;
use dcd_exec::Par;
use dcd_geom::Scene;
use dcd_gjk::{Gjk, Method, NarrowPhase, Overlap, Pairwise};
use dcd_io::{RawObject, RawScene, RawShape};
use dcd_parry::{ParryGjk, ParryShapes, Query};
use dcd_pipeline::Pipeline;
use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};

use crate::case::{Case, Setting, spec};

/// Objects of the scaled scenes.
const OBJECTS: usize = 1_000;
/// Cubes along each axis of the grid: 5,068 pairs of neighbours, diagonal ones included.
const EDGE: usize = 8;

/// A scene that is hard on tolerances.
#[derive(Clone, Copy, Debug)]
struct Trial {
    name: &'static str,
    kind: Kind,
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    /// The paper's, scaled.
    Scaled(f64),
    /// Unit cubes in a grid of this pitch.
    Grid(f64),
}

const TRIALS: [Trial; 7] = [
    Trial { name: "paper scene", kind: Kind::Scaled(1.0) },
    Trial { name: "× 1e-3", kind: Kind::Scaled(1e-3) },
    Trial { name: "× 1e-4", kind: Kind::Scaled(1e-4) },
    Trial { name: "cubes, pitch 1 − 1e-3", kind: Kind::Grid(1.0 - 1e-3) },
    Trial { name: "cubes, pitch 1 − 1e-9", kind: Kind::Grid(1.0 - 1e-9) },
    Trial { name: "cubes, pitch 1", kind: Kind::Grid(1.0) },
    Trial { name: "cubes, pitch 1 + 1e-9", kind: Kind::Grid(1.0 + 1e-9) },
];

/// The solvers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Solver {
    Ours,
    OursF64,
    ParryGjkF64,
    ParryDistanceF64,
    ParryF32,
}

impl Solver {
    const ALL: [Self; 5] =
        [Self::Ours, Self::OursF64, Self::ParryGjkF64, Self::ParryDistanceF64, Self::ParryF32];

    fn name(self) -> &'static str {
        match self {
            Self::Ours => "our default",
            Self::OursF64 => "our GJK f64 alone",
            Self::ParryGjkF64 => "Parry's GJK f64, our support maps",
            Self::ParryDistanceF64 => "Parry f64, distance",
            Self::ParryF32 => "Parry f32, intersection_test",
        }
    }

    fn answer(self, case: &Case) -> Answered {
        let shapes = || ParryShapes::<f64>::default().with_query(Query::Distance);
        match self {
            Self::Ours => answered(case, Overlap::default()),
            Self::OursF64 => answered(case, Pairwise(Gjk::<f64>::default())),
            Self::ParryGjkF64 => answered(case, Pairwise(ParryGjk::<f64>::default())),
            Self::ParryDistanceF64 => answered(case, shapes()),
            Self::ParryF32 => answered(case, ParryShapes::<f32>::default()),
        }
    }
}

#[derive(Debug, Serialize, Deserialize)]
struct Answered {
    agreement: Agreement,
    /// Pairs that only exact integers could decide.
    exact: u64,
}

/// Behind one broad phase, so that all decide the same candidates.
fn answered<N: NarrowPhase<Answer = ()>>(case: &Case, narrow: N) -> Answered {
    let mut pipeline = Pipeline::with(WideTree::default(), narrow);
    let step = pipeline.step(&case.scene, Par::WarmPool);
    let agreement = case.agreement_of(step.contacts(), step.report());
    Answered { agreement, exact: step.report().resolved(Method::Exact) }
}

impl Trial {
    fn key(&self, solver: Solver) -> String {
        format!("claims/tolerances/{}/{}", self.name, solver.name())
    }

    fn scene(&self, setting: &Setting) -> Result<Scene> {
        let raw = match self.kind {
            Kind::Scaled(scale) => scaled(spec(setting.seed, OBJECTS).raw()?, scale),
            Kind::Grid(pitch) => grid(pitch),
        };
        Ok(raw.into_scene()?)
    }
}

fn scaled(mut raw: RawScene, scale: f64) -> RawScene {
    for shape in &mut raw.shapes {
        match shape {
            RawShape::Hull { points, .. } => points.iter_mut().for_each(|point| *point *= scale),
            RawShape::Cuboid { half_extents } => *half_extents *= scale,
            _ => {}
        }
    }
    raw.objects.iter_mut().for_each(|object| object.translation *= scale);
    raw
}

fn grid(pitch: f64) -> RawScene {
    let place = |k: usize| {
        let cell = [k % EDGE, k / EDGE % EDGE, k / (EDGE * EDGE)].map(|k| k as f64);
        let translation = DVec3::from_array(cell) * pitch;
        RawObject { shape: 0, rotation: DQuat::IDENTITY, translation }
    };
    RawScene {
        shapes: vec![RawShape::Cuboid { half_extents: DVec3::splat(0.5) }],
        objects: (0..EDGE * EDGE * EDGE).map(place).collect(),
    }
}

fn all() -> impl Iterator<Item = (Trial, Solver)> {
    TRIALS.into_iter().flat_map(|trial| Solver::ALL.map(|solver| (trial, solver)))
}

pub(super) fn plan() -> Vec<String> {
    all().map(|(trial, solver)| trial.key(solver)).collect()
}

pub(super) fn measure(setting: &Setting, units: &mut Units) -> Result<()> {
    for (trial, solver) in all() {
        units.run(&trial.key(solver), || Ok(solver.answer(&Case::new(trial.scene(setting)?))))?;
    }
    Ok(())
}

/// How our certified contacts stand, as far as they are known.
pub(super) fn agreements(units: &Units) -> Vec<(String, Agreement)> {
    let agreement = |trial: Trial| {
        let key = trial.key(Solver::Ours);
        let answered: Answered = units.get(&key)?;
        Some((key, answered.agreement))
    };
    TRIALS.into_iter().filter_map(agreement).collect()
}

pub(super) fn draw(units: &Units, report: &mut Report) -> Result<()> {
    let columns = [
        Column::new("scene"),
        Column::new("solver"),
        Column::new("contacts"),
        Column::new("found"),
        Column::new("false"),
        Column::new("missed"),
        Column::new("undecided"),
        Column::new("decided in integers"),
    ];
    let title = format!("Tiny scenes of {OBJECTS} objects and grids of {} unit cubes", EDGE.pow(3));
    let mut table = Table::new("tolerances", title, columns);
    for (trial, solver) in all() {
        let answered: Option<Answered> = units.get(&trial.key(solver));
        let count = |of: fn(&Agreement) -> u64| answered.as_ref().map(|a| of(&a.agreement)).into();
        table.push([
            trial.name.into(),
            solver.name().into(),
            count(|a| a.expected),
            count(|a| a.found),
            count(|a| a.false_contacts),
            count(|a| a.missed),
            count(|a| a.undecided),
            answered.as_ref().map(|a| a.exact).into(),
        ])?;
    }
    report.note(
        "A tolerance that is a length fails when the scene is small, and where the gap is smaller \
         than it. Differences are judged in exact integers on the scene as it is, after its \
         coordinates were rounded: the scaled scenes are scenes of their own.",
    );
    report.table(table);
    Ok(())
}
