//! Time against tolerance: hulls of few vertices round and inside the paper's.

use anyhow::{Context, Result};
use dcd_benches::{Axis, Cell, Column, Figure, Options, Report, Series, Table};
use dcd_geom::{Scene, Shape};
use dcd_gjk::simplify::{Budget, Simplified, simplify};
use dcd_scenes::SceneSpec;
use serde::{Deserialize, Serialize};

use crate::measure::{Turn, take_turns};
use crate::precision::{Precision, Query, Said};
use crate::subject::{Known, Recipe, Subject};

/// The unit.
pub(crate) const KEY: &str = "paper/tolerance";

/// Metres, on hulls that fill most of a unit cube.
const TOLERANCES: [f64; 4] = [0.02, 0.05, 0.1, 0.2];
/// No hull has more vertices.
const VERTICES: usize = 64;
/// Objects of a full run and of a quick one: simplifying takes some milliseconds each.
const OBJECTS: [usize; 2] = [2_000, 300];

/// What hulls within a tolerance cost, and how often they are wrong.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Coarse {
    /// Metres; 0 for the shapes as they are.
    tolerance: f64,
    pairs: usize,
    /// Mean vertices of the outer hulls and of the inner ones.
    vertices: [f64; 2],
    /// A pair of outer hulls in the lanes, and one at a time.
    nanoseconds: [f64; 2],
    /// Pairs apart whose outer hulls touch.
    wrong_yes: usize,
    /// Pairs that touch whose inner hulls do not.
    wrong_no: usize,
    /// Pairs that touch whose outer hulls do not, and pairs apart whose inner hulls touch: none.
    impossible: usize,
}

impl Coarse {
    /// What outer and inner hulls promise, where it is broken.
    pub(crate) fn broken_promise(&self) -> Option<String> {
        let Self { tolerance, impossible, .. } = self;
        (*impossible > 0).then(|| format!("tolerance {tolerance}: {impossible} impossible answers"))
    }
}

/// Outer and inner hulls of the paper's scene on the candidate pairs of the scene itself.
pub(crate) fn measure(options: &Options) -> Result<Vec<Coarse>> {
    let objects = OBJECTS[usize::from(options.quick)];
    let spec = SceneSpec::paper().with_objects(objects);
    let exact = Recipe::Scene { spec, seed: options.seed }.subject()?;
    let pairs: Vec<u32> = (0..exact.pairs.len() as u32).collect();
    // Nothing simplified first: what the tolerances are compared with.
    let mut levels =
        vec![(0.0, coarsened(&exact, Clone::clone)?, coarsened(&exact, Clone::clone)?)];
    for tolerance in TOLERANCES {
        let budget = Budget { tolerance, vertices: VERTICES };
        let simple: Vec<Simplified> = exact
            .shapes
            .iter()
            .map(|shape| {
                let polytope = shape.as_polytope().context("the paper's shapes are polytopes")?;
                simplify(polytope, budget).context("a hull of the paper's")
            })
            .collect::<Result<_>>()?;
        let mut of = simple.iter();
        let outer = coarsened(&exact, |s| of.next().map_or(s.clone(), |h| h.outer.clone().into()))?;
        let mut of = simple.iter();
        let inner = coarsened(&exact, |s| of.next().map_or(s.clone(), |h| h.inner.clone().into()))?;
        levels.push((tolerance, outer, inner));
    }
    let mut turns: Vec<Turn<'_>> = Vec::new();
    for (_, outer, inner) in &levels {
        turns.push(Turn::new((Precision::Lanes, Query::YesNo), outer));
        turns.push(Turn::new((Precision::Certified, Query::YesNo), outer));
        turns.push(Turn::new((Precision::Lanes, Query::YesNo), inner));
    }
    take_turns(&mut turns, Query::YesNo, &pairs, options);
    let levels = levels.iter().zip(turns.chunks(3));
    Ok(levels
        .map(|((tolerance, outer, inner), turns)| {
            let count = |turn: &Turn<'_>, said: Said, touches: bool| {
                let of = pairs.iter().zip(&turn.said);
                of.filter(|&(&k, &s)| s == said && exact.touches(k) == touches).count()
            };
            let [outer_lanes, _, inner_lanes] = [0, 1, 2].map(|k| &turns[k]);
            Coarse {
                tolerance: *tolerance,
                pairs: pairs.len(),
                vertices: [mean_vertices(outer), mean_vertices(inner)],
                nanoseconds: [0, 1].map(|k| turns[k].nanoseconds(&pairs)),
                wrong_yes: count(outer_lanes, Said::Touching, false),
                wrong_no: count(inner_lanes, Said::Apart, true),
                impossible: count(outer_lanes, Said::Apart, true)
                    + count(inner_lanes, Said::Touching, false),
            }
        })
        .collect())
}

/// The same pairs and their truth with other shapes.
fn coarsened(exact: &Subject, shape: impl FnMut(&Shape) -> Shape) -> Result<Subject> {
    let shapes: Vec<Shape> = exact.shapes.iter().map(shape).collect();
    let touches = (0..exact.pairs.len() as u32).map(|k| exact.touches(k));
    Ok(Subject {
        name: exact.name.clone(),
        scene: Scene::one_each(shapes.clone(), exact.poses.clone())?,
        shapes,
        poses: exact.poses.clone(),
        pairs: exact.pairs.clone(),
        in_scene: exact.in_scene.clone(),
        truth: Known::YesNo(touches.collect()),
    })
}

fn mean_vertices(subject: &Subject) -> f64 {
    let of = |shape: &Shape| shape.as_polytope().map_or(0, |polytope| polytope.vertices().len());
    let sum: usize = subject.shapes.iter().map(of).sum();
    sum as f64 / subject.shapes.len().max(1) as f64
}

/// A table, and the picture of time against what is wrong.
pub(crate) fn show(coarse: &[Coarse], report: &mut Report) -> Result<()> {
    report.heading("Time against tolerance");
    let columns = [
        Column::new("tolerance").unit("m").decimals(2),
        Column::new("vertices, outer").decimals(1),
        Column::new("vertices, inner").decimals(1),
        Column::new("lanes, a pair").unit("ns").decimals(1),
        Column::new("one at a time").unit("ns").decimals(1),
        Column::new("pairs"),
        Column::new("wrong yes, outer"),
        Column::new("wrong no, inner"),
    ];
    let title = "Simplified hulls of the paper's scene, on its own candidate pairs";
    let mut table = Table::new("tolerance", title, columns);
    let axes = [Axis::logarithmic("nanoseconds a pair"), Axis::logarithmic("wrong yes [%]")];
    let [x, y] = axes;
    let mut figure = Figure::new("tolerance", "Outer hulls: time against error", x, y);
    let mut curves = [Vec::new(), Vec::new()];
    for one in coarse {
        let numbers = [one.tolerance, one.vertices[0], one.vertices[1]];
        let numbers = numbers.into_iter().chain(one.nanoseconds).map(Cell::from);
        let counts = [one.pairs, one.wrong_yes, one.wrong_no].map(Cell::from);
        table.push(numbers.chain(counts))?;
        let share = 100.0 * one.wrong_yes as f64 / one.pairs.max(1) as f64;
        for (curve, ns) in curves.iter_mut().zip(one.nanoseconds) {
            if share > 0.0 && ns > 0.0 {
                curve.push((ns, share));
            }
        }
    }
    report.table(table);
    report.note(
        "An outer hull holds its shape and misses no contact; an inner one is held by it and reports \
         none that is not there. A tolerance of 0 is the shapes as they are: no answer is wrong.",
    );
    let [lanes, single] = curves;
    figure.push(Series::measured("certified, lanes", lanes))?;
    figure.push(Series::measured("certified", single))?;
    report.figure(figure);
    Ok(())
}
