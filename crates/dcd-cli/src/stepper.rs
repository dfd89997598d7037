//! Whoever steps: our pipelines, or Parry's shapes in ours.

use crate::failure::Failure;
use crate::precision::{Library, Precision};
use dcd_broad::WideTree;
use dcd_exec::with_threads;
use dcd_geom::Scene;
use dcd_parry::ParryShapes;
use dcd_pipeline::{AnyPipeline, AnyStep, Exec, Par, Pipeline, Question};

/// A pipeline of either kind.
pub(crate) trait Stepper: Send {
    fn step(&mut self, scene: &Scene, exec: Exec) -> AnyStep<'_>;

    /// Of Parry's how many shapes it refused: their pairs are undecided.
    fn refused(&self) -> Option<usize> {
        None
    }
}

impl Stepper for AnyPipeline {
    fn step(&mut self, scene: &Scene, exec: Exec) -> AnyStep<'_> {
        AnyPipeline::step(self, scene, exec)
    }
}

/// Parry's shapes in our pipeline.
struct ByParry<R: dcd_parry::Library> {
    pipeline: Pipeline<WideTree, ParryShapes<R>>,
    refused: usize,
}

impl<R: dcd_parry::Library> ByParry<R> {
    fn new(scene: &Scene) -> Self {
        let shapes = ParryShapes::new(scene);
        let refused = shapes.refused().count();
        Self { pipeline: Pipeline::with(WideTree::default(), shapes), refused }
    }
}

impl<R: dcd_parry::Library> Stepper for ByParry<R> {
    fn step(&mut self, scene: &Scene, exec: Exec) -> AnyStep<'_> {
        AnyStep::Overlap(self.pipeline.step(scene, exec))
    }

    fn refused(&self) -> Option<usize> {
        Some(self.refused)
    }
}

/// That question at that precision, which counts for yes or no alone. What depends on the scene's shapes
/// alone is derived here.
pub(crate) fn stepper(
    scene: &Scene,
    precision: Precision,
    question: Question,
) -> Result<Box<dyn Stepper>, Failure> {
    let ours = |question| {
        let mut pipeline =
            AnyPipeline::new(question).map_err(|error| Failure::at("--margin", error))?;
        pipeline.prepare_shapes(scene);
        Ok(Box::new(pipeline) as Box<dyn Stepper>)
    };
    match (precision.library(), question) {
        (Library::ParryF32, _) => Ok(Box::new(ByParry::<f32>::new(scene))),
        (Library::ParryF64, _) => Ok(Box::new(ByParry::<f64>::new(scene))),
        (Library::Ours(precision), Question::Overlap { margin, .. }) => {
            ours(Question::Overlap { precision, margin })
        }
        (Library::Ours(_), question) => ours(question),
    }
}

/// Runs on that many threads, 1 without a pool.
pub(crate) fn on_threads<T: Send>(
    threads: usize,
    run: impl FnOnce(Par) -> T + Send,
) -> Result<T, Failure> {
    if threads == 1 {
        return Ok(run(Par::Serial));
    }
    with_threads(threads, || run(Par::WarmPool))
        .map_err(|error| Failure::at(format_args!("{threads} threads"), error))
}
