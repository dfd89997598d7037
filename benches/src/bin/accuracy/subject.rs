//! Pairs and what is true of them.

use anyhow::{Context, Result};
use dcd_benches::Options;
use dcd_geom::{Pair, Pose, Scene, Shape};
use dcd_gjk::distance::{self, DistanceResult};
use dcd_gjk::epa::{self, Scratch};
use dcd_gjk::{Certified, Overlap, PairSolver, PosedShape, PosedSupport, Verdict, certified};
use dcd_judge::Truth;
use dcd_pipeline::{Par, Pipeline, WideTree};
use dcd_scenes::SceneSpec;
use dcd_scenes::conformance::{Case, Category, ShapePair, suite};

use crate::precision::{Said, body};

/// How to make a subject.
#[derive(Clone, Debug)]
pub(crate) enum Recipe {
    /// The candidate pairs of a scene.
    Scene { spec: SceneSpec, seed: u64 },
    /// The conformance suite.
    Suite { seed: u64 },
}

/// The scenes of a report: name, objects of a full run and of a quick one.
const SCENES: [(&str, usize, usize); 7] = [
    ("paper", 10_000, 500),
    ("sparse", 10_000, 1_000),
    ("game-hulls", 10_000, 1_000),
    ("boxes", 20_000, 1_000),
    ("bricks", 10_000, 1_000),
    ("bricks-apart", 10_000, 1_000),
    ("bricks-overlapping", 10_000, 1_000),
];

/// The subjects of a report, and a sentence for each that cannot be had.
pub(crate) fn recipes(options: &Options) -> (Vec<Recipe>, Vec<String>) {
    let (mut recipes, mut absent) = (Vec::new(), Vec::new());
    for (name, full, quick) in SCENES {
        let objects = if options.quick { quick } else { full };
        let spec = SceneSpec::parse(name).map(|spec| spec.with_objects(objects));
        // For one object, a scene says at once whether its files are there.
        let there = spec.and_then(|spec| spec.with_objects(1).raw().map(|_| spec));
        match there {
            Ok(spec) => recipes.push(Recipe::Scene { spec, seed: options.seed }),
            Err(error) => absent.push(format!("`{name}` is left out: {error}")),
        }
    }
    recipes.push(Recipe::Suite { seed: options.seed });
    absent.iter().for_each(|note| eprintln!("{note}"));
    (recipes, absent)
}

impl Recipe {
    pub(crate) fn name(&self) -> &'static str {
        match self {
            Self::Scene { spec, .. } => spec.name(),
            Self::Suite { .. } => "suite",
        }
    }

    pub(crate) fn subject(&self) -> Result<Subject> {
        match self {
            Self::Scene { spec, seed } => {
                let scene = spec.with_seed(*seed).scene()?;
                Ok(Subject::of_scene(self.name(), scene))
            }
            Self::Suite { seed } => Subject::of_cases("suite", &suite(*seed, &touches)),
        }
    }
}

/// What the certified precision says of a case.
pub(crate) fn touches(case: &Case) -> bool {
    let a = PosedSupport::polytope(&case.a, &case.pose_a);
    let b = PosedSupport::polytope(&case.b, &case.pose_b);
    certified::overlap(a, b).0 == Verdict::Touching(())
}

fn polytopes(case: &Case) -> ([Shape; 2], [Pose; 2]) {
    ([case.a.clone().into(), case.b.clone().into()], [case.pose_a, case.pose_b])
}

/// Pairs of objects.
pub(crate) struct Subject {
    pub(crate) name: String,
    pub(crate) shapes: Vec<Shape>,
    pub(crate) poses: Vec<Pose>,
    pub(crate) pairs: Vec<[u32; 2]>,
    /// The objects that f32 AABBs hold, for the lanes.
    pub(crate) scene: Scene,
    /// Each pair in that scene.
    pub(crate) in_scene: Vec<Option<Pair>>,
    pub(crate) truth: Known,
}

/// What is known of the pairs.
pub(crate) enum Known {
    /// Exactly, and which category and decade each is of.
    Exactly(Vec<Truth>, Vec<Label>),
    /// Whether each touches: by the certified precision for a scene, by the judge for flips.
    YesNo(Vec<bool>),
}

/// The groups that a pair of the suite is counted in.
#[derive(Clone, Debug)]
pub(crate) struct Label {
    /// The category's place in the suite.
    pub(crate) rank: usize,
    pub(crate) category: String,
    pub(crate) decade: i32,
}

impl Subject {
    fn of_scene(name: &str, scene: Scene) -> Self {
        let mut pipeline = Pipeline::with(WideTree::default(), Overlap::default());
        let candidates: Vec<Pair> = pipeline.step(&scene, Par::Serial).candidates().collect();
        let count = scene.len();
        let mut subject = Self {
            name: name.to_owned(),
            shapes: (0..count).map(|i| scene.shape(i).clone()).collect(),
            poses: scene.poses().to_vec(),
            pairs: candidates.iter().map(|pair| [pair.i, pair.j]).collect(),
            in_scene: candidates.into_iter().map(Some).collect(),
            scene,
            truth: Known::YesNo(Vec::new()),
        };
        let touches = |k: u32| {
            let [a, b] = subject.placed(k);
            Certified.solve(a, b, &mut Default::default()) == Verdict::Touching(())
        };
        subject.truth = Known::YesNo((0..subject.pairs.len() as u32).map(touches).collect());
        subject
    }

    /// Of pairs with their exact truth: milliseconds each.
    pub(crate) fn of_cases(name: &str, cases: &[Case]) -> Result<Self> {
        let truths =
            cases.iter().map(|case| Truth::of((&case.a, &case.pose_a), (&case.b, &case.pose_b)));
        let rank = |case: &Case| {
            Category::ALL.iter().position(|&category| category == case.category).unwrap_or(0)
        };
        let label = |case: &Case| Label {
            rank: rank(case),
            category: case.category.to_string(),
            decade: case.decade,
        };
        let labels = cases.iter().map(label).collect();
        Self::with_truth(
            name,
            cases.iter().map(polytopes),
            Known::Exactly(truths.collect(), labels),
        )
    }

    /// Of flips, judged yes or no alone.
    pub(crate) fn of_flips(cases: &[Case]) -> Result<Self> {
        let judged =
            |case: &Case| dcd_judge::touches((&case.a, &case.pose_a), (&case.b, &case.pose_b));
        let truth = Known::YesNo(cases.iter().map(judged).collect());
        Self::with_truth("flips", cases.iter().map(polytopes), truth)
    }

    /// Of pairs of shapes of any kind, whose truth is known.
    pub(crate) fn of_shapes(name: &str, pairs: &[ShapePair], touches: Vec<bool>) -> Result<Self> {
        let pairs =
            pairs.iter().map(|pair| ([pair.a.clone(), pair.b.clone()], [pair.pose_a, pair.pose_b]));
        Self::with_truth(name, pairs, Known::YesNo(touches))
    }

    fn with_truth(
        name: &str,
        cases: impl ExactSizeIterator<Item = ([Shape; 2], [Pose; 2])>,
        truth: Known,
    ) -> Result<Self> {
        let (mut shapes, mut poses, mut in_scene) = (Vec::new(), Vec::new(), Vec::new());
        let (mut in_range, mut placed) = (Vec::new(), Vec::new());
        let count = cases.len() as u32;
        for (pair, at) in cases {
            let fits = Scene::one_each(pair.to_vec(), at.to_vec()).is_ok();
            let first = in_range.len() as u32;
            in_scene.push(fits.then(|| Pair::new(first, first + 1)));
            if fits {
                in_range.extend(pair.iter().cloned());
                placed.extend(at);
            }
            shapes.extend(pair);
            poses.extend(at);
        }
        Ok(Self {
            name: name.to_owned(),
            pairs: (0..count).map(|k| [2 * k, 2 * k + 1]).collect(),
            scene: Scene::one_each(in_range, placed).context("objects that fit pair by pair")?,
            shapes,
            poses,
            in_scene,
            truth,
        })
    }

    pub(crate) fn placed(&self, k: u32) -> [PosedShape<'_>; 2] {
        self.pairs[k as usize]
            .map(|i| PosedShape { shape: &self.shapes[i as usize], pose: &self.poses[i as usize] })
    }

    pub(crate) fn touches(&self, k: u32) -> bool {
        match &self.truth {
            Known::Exactly(truths, _) => truths[k as usize].touches(),
            Known::YesNo(touches) => touches[k as usize],
        }
    }

    /// The exact judge's word.
    pub(crate) fn judged(&self, k: u32) -> Option<bool> {
        let [a, b] = self.placed(k);
        let (shape_a, shape_b) = (a.shape.as_polytope()?, b.shape.as_polytope()?);
        Some(dcd_judge::touches((shape_a, a.pose), (shape_b, b.pose)))
    }

    /// The true depth, or the negative distance; on a scene as the certified precision has it.
    pub(crate) fn value(&self, k: u32, scratch: &mut Scratch) -> f64 {
        if let Known::Exactly(truths, _) = &self.truth {
            return truths[k as usize].value();
        }
        let [a, b] = self.placed(k);
        if let DistanceResult::Apart(found) = distance::distance(a, b).0 {
            return -found.distance;
        }
        match [body(a), body(b)] {
            [Some(a), Some(b)] => epa::depth_of_overlap(a, b, scratch).depth,
            _ => f64::NAN,
        }
    }

    /// How far a precision's number is from the truth, whose rounded value is `value`.
    pub(crate) fn error(&self, k: u32, said: Said, value: f64) -> Option<f64> {
        let Said::Measured(found) = said else { return None };
        let signed = if self.touches(k) { found } else { -found };
        Some(match &self.truth {
            Known::Exactly(truths, _) => truths[k as usize].less(signed).abs(),
            Known::YesNo(_) => (signed - value).abs(),
        })
    }

    /// The pair's size: no coordinate of A − B is larger.
    pub(crate) fn size(&self, k: u32) -> f64 {
        let [a, b] = self.placed(k);
        let between = (a.pose.translation() - b.pose.translation()).abs().element_sum();
        a.shape.reach() + b.shape.reach() + between
    }
}
