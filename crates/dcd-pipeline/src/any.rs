//! A pipeline whose question is chosen at run time: for a command, a binding, a settings file.

use crate::step::{Sealed, StepPairs, any};
use crate::{Pipeline, Queries, QueryError, Step};
use dcd_broad::{BroadPhase, WideTree};
use dcd_exec::Exec;
use dcd_geom::{Pair, Revision, Scene, ShapeError};
use dcd_gjk::epa::Depth;
use dcd_gjk::query::ManifoldOptions;
use dcd_gjk::{
    Accuracy, Contact, ContactAnswer, Depths, Distance, Gjk, ManifoldSet, Manifolds, Overlap,
    OverlapUnchecked, Pairwise, Proximities, Proximity, Report, SimdDepths, SimdDistances,
    ThenMeasure, WithAccuracy, Within,
};

/// What a yes or no guarantees.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Precision {
    /// f32 without error bounds: [`OverlapUnchecked`]. Refused where one scene is spread over ranks.
    Fast,
    /// What f64 can prove, else undecided: [`Gjk`].
    F64,
    /// Proved, down to exact arithmetic: [`Overlap`].
    #[default]
    Certified,
}

/// The query for a scene's pairs. Margins are metres: pairs within the margin of each other count as
/// touching.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Question {
    /// Whether they touch.
    Overlap {
        /// What the answer guarantees.
        precision: Precision,
        /// Pairs within this distance touch, metres.
        margin: f64,
    },
    /// How far apart they are: [`SimdDistances`].
    Distance {
        /// How good the bound has to be.
        accuracy: Accuracy,
        /// Pairs within this distance touch, metres.
        margin: f64,
    },
    /// How deep those that touch overlap: [`Depths`].
    Depth {
        /// How good the bound has to be.
        accuracy: Accuracy,
    },
    /// The contact points of those that touch: [`Manifolds`].
    Manifold {
        /// How good the bound has to be.
        accuracy: Accuracy,
        /// How the surfaces of meshes count.
        options: ManifoldOptions,
    },
    /// The signed distance and its derivatives: [`Proximities`].
    Gradient {
        /// How good the bound has to be.
        accuracy: Accuracy,
        /// Pairs within this distance touch, metres.
        margin: f64,
    },
}

impl Default for Question {
    fn default() -> Self {
        Self::Overlap { precision: Precision::default(), margin: 0.0 }
    }
}

/// What a step reports of a touching pair.
#[derive(Clone, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "a step's answers are all of one variant")]
#[non_exhaustive]
pub enum Answer {
    /// That it touches.
    Overlap,
    /// `None` where the two overlap, or are too near for that to be proved.
    Distance(Option<Distance>),
    /// How deep it overlaps.
    Depth(Depth),
    /// Where it touches.
    Manifold(ManifoldSet),
    /// Signed distance and derivatives.
    Gradient(Proximity),
}

/// A [`Pipeline`] for a [`Question`] that is known at run time only.
///
/// One enum over the types that a program would otherwise name, so that a step is as fast as theirs.
///
/// ```
/// use dcd_pipeline::prelude::*;
/// let poses = [0.0, 0.9, 2.1].map(|x| Pose::from_translation(DVec3::X * x));
/// let poses = poses.into_iter().collect::<Result<Vec<_>, _>>()?;
/// let scene = Scene::one_each(vec![Shape::sphere(0.5)?; 3], poses)?;
/// let question = Question::Depth { accuracy: Accuracy::F64 };
/// let mut pipeline = AnyPipeline::new(question)?;
/// for (pair, answer) in pipeline.step(&scene, Par::Pool).answers() {
///     let Answer::Depth(found) = answer else { unreachable!("a depth was asked for") };
///     assert_eq!(pair, Pair { i: 0, j: 1 });
///     assert!((found.depth - 0.1).abs() <= found.error_bound);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct AnyPipeline<B: BroadPhase = WideTree>(Inner<B>);

#[derive(Debug)]
enum Inner<B: BroadPhase> {
    Fast(Pipeline<B, Within<OverlapUnchecked>>),
    F64(Pipeline<B, Within<Pairwise<Gjk<f64>>>>),
    Certified(Pipeline<B, Within<Overlap>>),
    Distance(Pipeline<B, SimdDistances>),
    Depth(Pipeline<B, SimdDepths>),
    Manifold(Pipeline<B, SimdDepths<Manifolds>>),
    Gradient(Pipeline<B, ThenMeasure<WithAccuracy<Proximities>>>),
}

/// Calls the same method on the pipeline of any variant.
macro_rules! whichever {
    ($inner:expr, $pipeline:ident => $then:expr) => {
        match $inner {
            Inner::Fast($pipeline) => $then,
            Inner::F64($pipeline) => $then,
            Inner::Certified($pipeline) => $then,
            Inner::Distance($pipeline) => $then,
            Inner::Depth($pipeline) => $then,
            Inner::Manifold($pipeline) => $then,
            Inner::Gradient($pipeline) => $then,
        }
    };
}

impl AnyPipeline {
    /// A pipeline for that question, with the fastest tree.
    ///
    /// # Errors
    /// A margin that is negative, not a number, or above [`dcd_geom::Aabb::LIMIT`].
    pub fn new(question: Question) -> Result<Self, ShapeError> {
        Self::with(WideTree::default(), question)
    }
}

impl<B: BroadPhase> AnyPipeline<B> {
    /// A pipeline for that question, with the caller's broad phase.
    ///
    /// # Errors
    /// Those of [`AnyPipeline::new`].
    pub fn with(broad: B, question: Question) -> Result<Self, ShapeError> {
        let inner = match question {
            Question::Overlap { precision: Precision::Fast, margin } => {
                let narrow = Within::by(OverlapUnchecked::default(), margin)?;
                Inner::Fast(Pipeline::with(broad, narrow))
            }
            Question::Overlap { precision: Precision::F64, margin } => {
                let narrow = Within::by(Pairwise(Gjk::default()), margin)?;
                Inner::F64(Pipeline::with(broad, narrow))
            }
            Question::Overlap { precision: Precision::Certified, margin } => {
                Inner::Certified(Pipeline::with(broad, Within::margin(margin)?))
            }
            Question::Distance { accuracy, margin } => {
                Inner::Distance(Pipeline::with(broad, SimdDistances::within(margin, accuracy)?))
            }
            Question::Depth { accuracy } => {
                Inner::Depth(Pipeline::with(broad, SimdDepths::new(Depths, accuracy)))
            }
            Question::Manifold { accuracy, options } => Inner::Manifold(Pipeline::with(
                broad,
                SimdDepths::new(Manifolds { options }, accuracy),
            )),
            Question::Gradient { accuracy, margin } => {
                let solver = WithAccuracy::new(Proximities::within(margin)?, accuracy);
                Inner::Gradient(Pipeline::with(broad, ThenMeasure::new(solver)?))
            }
        };
        Ok(Self(inner))
    }

    /// [`Pipeline::prepare_shapes`].
    pub fn prepare_shapes(&mut self, scene: &Scene) {
        whichever!(&mut self.0, pipeline => pipeline.prepare_shapes(scene));
    }

    /// [`Pipeline::queries`].
    ///
    /// # Errors
    /// Those of [`Pipeline::queries`].
    pub fn queries<'a>(&'a self, scene: &'a Scene) -> Result<Queries<'a>, QueryError> {
        whichever!(&self.0, pipeline => pipeline.queries(scene))
    }

    /// [`Pipeline::step`].
    pub fn step<'e>(&mut self, scene: &Scene, exec: impl Into<Exec<'e>>) -> AnyStep<'_> {
        self.step_where(scene, exec, any)
    }

    /// [`Pipeline::step_where`].
    pub fn step_where<'e>(
        &mut self,
        scene: &Scene,
        exec: impl Into<Exec<'e>>,
        may: impl Fn(u32, u32) -> bool + Sync,
    ) -> AnyStep<'_> {
        let exec = exec.into();
        match &mut self.0 {
            Inner::Fast(pipeline) => AnyStep::Overlap(pipeline.step_where(scene, exec, may)),
            Inner::F64(pipeline) => AnyStep::Overlap(pipeline.step_where(scene, exec, may)),
            Inner::Certified(pipeline) => AnyStep::Overlap(pipeline.step_where(scene, exec, may)),
            Inner::Distance(pipeline) => AnyStep::Distance(pipeline.step_where(scene, exec, may)),
            Inner::Depth(pipeline) => AnyStep::Depth(pipeline.step_where(scene, exec, may)),
            Inner::Manifold(pipeline) => AnyStep::Manifold(pipeline.step_where(scene, exec, may)),
            Inner::Gradient(pipeline) => AnyStep::Gradient(pipeline.step_where(scene, exec, may)),
        }
    }
}

/// What a step of an [`AnyPipeline`] found: a [`Step`] of the type that answers its question.
#[derive(Debug)]
#[non_exhaustive]
pub enum AnyStep<'p> {
    /// Yes or no.
    Overlap(Step<'p, ()>),
    /// Distances.
    Distance(Step<'p, Option<Distance>>),
    /// Depths.
    Depth(Step<'p, Depth>),
    /// Manifolds.
    Manifold(Step<'p, ManifoldSet>),
    /// Signed distances and derivatives.
    Gradient(Step<'p, Proximity>),
}

/// Calls the same method on the step of any variant.
macro_rules! of_step {
    ($any:expr, $step:ident => $then:expr) => {
        match $any {
            AnyStep::Overlap($step) => $then,
            AnyStep::Distance($step) => $then,
            AnyStep::Depth($step) => $then,
            AnyStep::Manifold($step) => $then,
            AnyStep::Gradient($step) => $then,
        }
    };
}

/// Pairs, perhaps with answers. A virtual call an item: the lists are short beside what made them.
type List<'p, T> = Box<dyn Iterator<Item = T> + 'p>;

impl<'p> AnyStep<'p> {
    /// [`Step::contacts`].
    pub fn contacts(&self) -> List<'p, (u32, u32)> {
        of_step!(self, step => Box::new(step.contacts()))
    }

    /// [`Step::sensor_pairs`].
    pub fn sensor_pairs(&self) -> List<'p, (u32, u32)> {
        of_step!(self, step => Box::new(step.sensor_pairs()))
    }

    /// [`Step::answers`].
    pub fn answers(&self) -> List<'p, (Pair, Answer)> {
        fn list<'p, A: ContactAnswer>(
            step: &Step<'p, A>,
            answer: fn(A) -> Answer,
        ) -> List<'p, (Pair, Answer)> {
            Box::new(
                step.answers()
                    .map(move |contact: Contact<A>| (contact.pair, answer(contact.answer))),
            )
        }
        match self {
            Self::Overlap(step) => list(step, |()| Answer::Overlap),
            Self::Distance(step) => list(step, Answer::Distance),
            Self::Depth(step) => list(step, Answer::Depth),
            Self::Manifold(step) => list(step, Answer::Manifold),
            Self::Gradient(step) => list(step, Answer::Gradient),
        }
    }

    /// [`Step::contact_count`].
    pub fn contact_count(&self) -> usize {
        of_step!(self, step => step.contact_count())
    }

    /// [`Step::candidate_count`].
    pub fn candidate_count(&self) -> usize {
        of_step!(self, step => step.candidate_count())
    }

    /// [`Step::report`].
    pub fn report(&self) -> &'p Report {
        of_step!(self, step => step.report())
    }
}

impl Sealed for AnyStep<'_> {}

impl StepPairs for AnyStep<'_> {
    fn contact_pairs(&self) -> impl Iterator<Item = (u32, u32)> {
        self.contacts()
    }

    fn pairs_with_sensors(&self) -> impl Iterator<Item = (u32, u32)> {
        self.sensor_pairs()
    }

    fn layout(&self) -> Revision {
        of_step!(self, step => step.layout())
    }
}
