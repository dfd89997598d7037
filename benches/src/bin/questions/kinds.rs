//! Every kind of shape against every kind: microseconds a pair, ours beside Parry's of the same pairs.

use anyhow::{Context, Result, ensure};
use dcd_benches::timing::{Pair as Times, pairs_of, time};
use dcd_benches::{Cell, Column, Effort, Report, Table};
use dcd_geom::glam::{DMat3, DQuat, DVec3};
use dcd_geom::{Pair, Pose, Scene, Shape};
use dcd_gjk::query::MeasureAt;
use dcd_gjk::{Accuracy, Depths, Distances, Manifolds, PosedShape, Verdict, certified};
use dcd_pipeline::Par;
use serde::{Deserialize, Serialize};

use crate::contest::{Kind, MARGIN};
use crate::parry::Parry;

/// The kinds, about a metre across.
const KINDS: [&str; 11] = [
    "sphere",
    "capsule",
    "cuboid",
    "rounded cuboid",
    "cylinder",
    "cone",
    "hull",
    "triangle",
    "half-space",
    "mesh",
    "compound",
];

/// One question of pairs of two kinds.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Cross {
    pub(crate) kinds: [String; 2],
    pub(crate) question: Kind,
    pub(crate) accuracy: String,
    pub(crate) pairs: usize,
    /// Pairs that could not be measured.
    pub(crate) undecided: usize,
    /// The worst bound, metres.
    pub(crate) worst: f64,
    /// Of all pairs.
    pub(crate) times: Times,
}

/// All pairs of kinds whose names hold `filter`, as "one-other".
pub(crate) fn keys(filter: &str) -> Vec<[usize; 2]> {
    let all = (0..KINDS.len()).flat_map(|i| (i..KINDS.len()).map(move |j| [i, j]));
    let is_compared = |&[i, j]: &[usize; 2]| {
        // Two half-spaces, or a half-space and a mesh, have no depth at Parry.
        [KINDS[i], KINDS[j]] != ["half-space"; 2] && name([i, j]).contains(filter)
    };
    all.filter(is_compared).collect()
}

pub(crate) fn name([i, j]: [usize; 2]) -> String {
    format!("{}-{}", KINDS[i], KINDS[j])
}

const ACCURACIES: [(&str, Accuracy); 3] =
    [("f32", Accuracy::F32), ("f64", Accuracy::F64), ("certified", Accuracy::Certified)];

/// Drawn numbers (splitmix64).
pub(crate) struct Draw(pub(crate) u64);

impl Draw {
    /// In [0, 1).
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ z >> 31) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    pub(crate) fn vector(&mut self) -> DVec3 {
        DVec3::new(self.between(-1.0, 1.0), self.between(-1.0, 1.0), self.between(-1.0, 1.0))
    }

    pub(crate) fn pose(&mut self, reach: f64) -> Result<Pose> {
        let turn = DQuat::from_vec4(self.vector().extend(self.between(-1.0, 1.0))).normalize();
        Ok(Pose::new(turn, self.vector() * reach)?)
    }

    pub(crate) fn half_extents(&mut self) -> DVec3 {
        let mut extent = || self.between(0.2, 0.5);
        DVec3::new(extent(), extent(), extent())
    }

    /// A shape of that kind, one of [`KINDS`].
    pub(crate) fn named(&mut self, kind: &str) -> Result<Shape> {
        let half = self.half_extents();
        Ok(match kind {
            "sphere" => Shape::sphere(half.x)?,
            "capsule" => Shape::capsule(half.x, half.y * 0.6)?,
            "cuboid" => Shape::cuboid(half)?,
            "rounded cuboid" => Shape::cuboid(half * 0.8)?.rounded(0.08)?,
            "cylinder" => Shape::cylinder(half.x, half.y)?,
            "cone" => Shape::cone(half.x, half.y)?,
            "hull" => {
                let point = |_| self.vector().normalize_or(DVec3::X) * half;
                Shape::hull((0..20).map(point).collect())?
            }
            "triangle" => Shape::triangle([0, 1, 2].map(|_| self.vector() * half))?,
            "half-space" => Shape::half_space(self.vector().normalize_or(DVec3::Z), 0.0)?,
            "mesh" => terrain()?,
            _ => {
                let mut part = |_| Ok((Shape::cuboid(half * 0.4)?, self.pose(0.3)?));
                Shape::compound((0..4).map(&mut part).collect::<Result<_>>()?)?
            }
        })
    }
}

/// Sixteen squares each way over a metre and a half, uneven.
fn terrain() -> Result<Shape> {
    const SIDE: u32 = 16;
    let at = |x: u32, y: u32| {
        let [u, v] = [x, y].map(|k| f64::from(k) / f64::from(SIDE) * 1.5 - 0.75);
        DVec3::new(u, v, 0.1 * (3.0 * u).sin() * (4.0 * v).cos())
    };
    let line = 0..=SIDE;
    let vertices = line.clone().flat_map(|x| line.clone().map(move |y| at(x, y))).collect();
    let square = |x: u32, y: u32| {
        let [a, b] = [x * (SIDE + 1) + y, (x + 1) * (SIDE + 1) + y];
        [[a, b, a + 1], [b, b + 1, a + 1]]
    };
    let triangles = (0..SIDE).flat_map(|x| (0..SIDE).flat_map(move |y| square(x, y))).collect();
    Ok(Shape::mesh(vertices, triangles)?)
}

/// Pairs of two kinds: those that touch, or those that do not.
fn scene(kinds: [usize; 2], touching: bool, count: usize, seed: u64) -> Result<Scene> {
    let mut draw = Draw(seed ^ (kinds[0] * 16 + kinds[1]) as u64);
    let (mut shapes, mut poses) = (Vec::new(), Vec::new());
    for _ in 0..count * 1000 {
        if shapes.len() == 2 * count {
            break;
        }
        let [a, b] = [draw.named(KINDS[kinds[0]])?, draw.named(KINDS[kinds[1]])?];
        let [at_a, at_b] = [draw.pose(0.5)?, draw.pose(0.5)?];
        let (in_a, in_b) =
            (PosedShape { shape: &a, pose: &at_a }, PosedShape { shape: &b, pose: &at_b });
        let is = match certified::overlap_of(in_a, in_b).0 {
            Verdict::Touching(()) => touching,
            Verdict::Apart => !touching,
            Verdict::Undecided(_) => false,
        };
        if is {
            shapes.extend([a, b]);
            poses.extend([at_a, at_b]);
        }
    }
    ensure!(shapes.len() == 2 * count, "too few pairs of {}", name(kinds));
    Ok(Scene::one_each(shapes, poses)?)
}

/// Measures all pairs: how many could not be measured, and the worst bound.
fn measure<S: MeasureAt>(
    solver: S,
    accuracy: Accuracy,
    scene: &Scene,
    pairs: &[Pair],
    bound: impl Fn(&S::Answer) -> f64,
) -> (usize, f64) {
    let mut scratch = S::Scratch::default();
    let (mut undecided, mut worst) = (0, 0.0f64);
    for pair in pairs {
        let [a, b] = [pair.i as usize, pair.j as usize]
            .map(|k| PosedShape { shape: scene.shape(k), pose: &scene.poses()[k] });
        match solver.measure_at(accuracy, a, b, &mut scratch) {
            Verdict::Touching(answer) => worst = worst.max(bound(&answer)),
            Verdict::Apart => {}
            Verdict::Undecided(_) => undecided += 1,
        }
    }
    (undecided, worst)
}

/// Three queries of two kinds of shape, at every accuracy.
pub(crate) fn run_kinds(kinds: [usize; 2], seed: u64, effort: Effort) -> Result<Vec<Cross>> {
    let (count, rounds) = if effort == Effort::Quick { (8, 1) } else { (256, 7) };
    let mut found = Vec::new();
    for question in [Kind::Distance, Kind::Depth, Kind::Manifold] {
        let scene = scene(kinds, question != Kind::Distance, count, seed)?;
        let pairs: Vec<Pair> = (0..count as u32).map(|k| Pair::new(2 * k, 2 * k + 1)).collect();
        let margin = if question == Kind::Distance { 10.0 } else { 0.0 };
        let parry = Parry::new(&scene, &pairs, margin)?;
        for (name, accuracy) in ACCURACIES {
            let run = || match question {
                Kind::Distance => measure(
                    Distances::within(MARGIN).expect("a margin"),
                    accuracy,
                    &scene,
                    &pairs,
                    |distance| distance.map_or(0.0, |d| d.error_bound),
                ),
                Kind::Depth => measure(Depths, accuracy, &scene, &pairs, |depth| depth.error_bound),
                Kind::Manifold | Kind::Overlap => {
                    measure(Manifolds::default(), accuracy, &scene, &pairs, |m| m.error_bound())
                }
            };
            let (undecided, worst) = run();
            let mut ours = || [time(run).0];
            let mut theirs = || [time(|| parry.count(question, Par::Serial)).0];
            let [times] = pairs_of(rounds, &mut ours, &mut theirs);
            found.push(Cross {
                kinds: kinds.map(|kind| KINDS[kind].to_owned()),
                question,
                accuracy: name.to_owned(),
                pairs: count,
                undecided,
                worst,
                times,
            });
        }
    }
    Ok(found)
}

/// Where Parry's own cylinders, cones and half-spaces are: round y, and with the plane through the origin.
pub(crate) fn in_parrys_frame(shape: &Shape, pose: &Pose) -> Result<Pose> {
    let DMat3 { x_axis: x, y_axis: y, z_axis: z } = *pose.rotation();
    match shape {
        Shape::Curved(_) => Pose::from_matrix(DMat3::from_cols(x, z, -y), pose.translation())
            .context("a turned pose"),
        Shape::HalfSpace(half_space) => {
            ensure!(half_space.offset() == 0.0, "a half-space whose plane is not at its origin");
            Ok(*pose)
        }
        _ => Ok(*pose),
    }
}

pub(crate) fn report(report: &mut Report, found: &[Cross]) -> Result<()> {
    report.note(
        "Kinds against kinds: random shapes of about a metre, pairs that touch (apart, for distances), each solver \
         called pair by pair; Parry in f32, the same pairs, interleaved.",
    );
    let columns = ["kinds", "question", "accuracy", "pairs", "undecided"];
    let columns = columns.map(Column::new).into_iter().chain([
        Column::new("ours").unit("µs").decimals(2),
        Column::new("Parry f32").unit("µs").decimals(2),
        Column::new("ratio").unit("×").decimals(2),
        Column::new("worst bound").unit("µm").decimals(4),
    ]);
    let mut table = Table::new("kinds", "A pair of two kinds", columns);
    for cross in found {
        let us = |time: std::time::Duration| time.as_secs_f64() * 1e6 / cross.pairs as f64;
        let times = &cross.times;
        let numbers = [us(times.a.median), us(times.b.median), times.ratio, cross.worst * 1e6]
            .map(Cell::from);
        let names = [
            Cell::from(cross.kinds.join("-").as_str()),
            Cell::from(cross.question.name()),
            Cell::from(cross.accuracy.as_str()),
            Cell::from(cross.pairs),
            Cell::from(cross.undecided),
        ];
        table.push(names.into_iter().chain(numbers))?;
    }
    report.table(table);
    Ok(())
}
