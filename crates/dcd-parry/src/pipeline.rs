//! Parry's best pipeline, as a rival.

use crate::forms::{Forms, Placed, Placement, decide};
use crate::{Library, Query};
use dcd_exec::{Exec, PerThread, Segments, Stage};
use dcd_geom::{Pair, Scene};
use dcd_gjk::{Contact, ContactSink, Report};

/// How many AABBs a task computes.
const OBJECTS_PER_TASK: usize = 256;

/// How many candidate pairs a task judges, at most: about a millisecond.
const PAIRS_PER_TASK: usize = 2048;

/// Parry's AABBs, its binned tree, the tree against itself (the parallel traversal above one
/// thread), and a query for each candidate: each stage as fast as its public API allows.
///
/// Shapes are made here and poses converted by [`ParryPipeline::place`], since whoever uses Parry
/// holds both as Parry's own; a step pays for neither. The tree's build is serial: Parry has no
/// other.
pub struct ParryPipeline<R: Library> {
    query: Query,
    upkeep: Upkeep,
    forms: Forms<R>,
    placements: Vec<Placement<R>>,
    /// The objects that Parry has a shape for: leaf k is object `accepted[k]`.
    accepted: Vec<u32>,
    refused: Vec<u32>,
    boxes: Vec<R::Box>,
    tree: R::Tree,
    candidates: Vec<(u32, u32)>,
    contacts: Segments<Contact<()>>,
    reports: PerThread<Report>,
    report: Report,
}

/// What becomes of the tree from step to step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Upkeep {
    /// It is built anew by binning, in the memory of the one before: the fastest way where objects
    /// have moved far, and without them all the same.
    #[default]
    Rebuild,
    /// Its nodes are fitted to the new AABBs, and a part of it improved: Parry's own way from frame
    /// to frame.
    Refit,
}

/// A pipeline with the objects where the scene has them.
pub struct Ready<'a, R: Library> {
    pipeline: &'a mut ParryPipeline<R>,
    scene: &'a Scene,
}

impl<R: Library> ParryPipeline<R> {
    /// Makes Parry's shapes for the scene's.
    pub fn new(scene: &Scene, query: Query) -> Self {
        Self {
            query,
            upkeep: Upkeep::default(),
            forms: Forms::of(scene),
            placements: Vec::new(),
            accepted: Vec::new(),
            refused: Vec::new(),
            boxes: Vec::new(),
            tree: R::Tree::default(),
            candidates: Vec::new(),
            contacts: Segments::default(),
            reports: PerThread::default(),
            report: Report::default(),
        }
    }

    /// The pipeline with the tree updated in that way.
    pub fn with_upkeep(self, upkeep: Upkeep) -> Self {
        Self { upkeep, ..self }
    }

    /// Takes over the scene's poses; and its shapes, if they are not those that were seen last.
    pub fn place<'a>(&'a mut self, scene: &'a Scene) -> Ready<'a, R> {
        if !self.forms.fit(scene) {
            self.forms = Forms::of(scene);
        }
        self.placements.clear();
        self.placements.extend((0..scene.len()).map(|i| Placement::of(scene, i)));
        self.accepted.clear();
        self.refused.clear();
        for (object, placement) in (0..).zip(&self.placements) {
            let accept = self.forms.accept(placement);
            let list = if accept { &mut self.accepted } else { &mut self.refused };
            list.push(object);
        }
        Ready { pipeline: self, scene }
    }

    fn compute_boxes(&mut self, exec: Exec) {
        self.boxes.resize(self.accepted.len(), R::NO_BOX);
        let Self { forms, placements, accepted, boxes, .. } = self;
        exec.divide((&accepted[..], &mut boxes[..]), OBJECTS_PER_TASK, |_, (objects, boxes)| {
            for (&object, slot) in objects.iter().zip(boxes) {
                *slot = forms.boxed(&placements[object as usize]);
            }
        });
    }

    fn find_candidates(&mut self, scene: &Scene, exec: Exec) {
        R::collect_leaf_pairs(&mut self.tree, exec, &mut self.candidates);
        if !self.refused.is_empty() {
            for (a, b) in &mut self.candidates {
                (*a, *b) = (self.accepted[*a as usize], self.accepted[*b as usize]);
            }
        }
        if scene.is_filtered() {
            self.candidates.retain(|&(a, b)| scene.allows(a, b));
        }
    }

    fn judge(&mut self, exec: Exec) {
        let Self { query, forms, placements, candidates, contacts, reports, report, .. } = self;
        let slices = candidates.len().div_ceil(PAIRS_PER_TASK);
        contacts.fill(exec, slices, |k, contacts| {
            reports.with(|report| {
                let slice = candidates[k * PAIRS_PER_TASK..].iter().take(PAIRS_PER_TASK);
                let pairs = slice.map(|&(a, b)| Pair::new(a, b));
                let sides = (Placed { forms, placements }, Placed { forms, placements });
                decide(*query, sides, pairs, &mut ContactSink { contacts, report });
            });
        });
        report.clear();
        reports.iter_mut().for_each(|part| report.absorb(part));
        report.sort();
    }
}

impl<R: Library> Ready<'_, R> {
    /// From AABBs to contacts, in Parry's own order, which depends on earlier steps (the tree comes
    /// of the one before) but not on `exec`.
    pub fn step<'e>(&mut self, exec: impl Into<Exec<'e>>) -> ParryStep<'_> {
        let (pipeline, exec) = (&mut *self.pipeline, exec.into());
        exec.stage(Stage::Boxes, || pipeline.compute_boxes(exec));
        exec.stage(Stage::Build, || {
            let boxes = pipeline.boxes.iter().copied();
            match pipeline.upkeep {
                Upkeep::Rebuild => R::rebuild(boxes, &mut pipeline.tree),
                Upkeep::Refit => R::refit(boxes, &mut pipeline.tree),
            }
        });
        exec.stage(Stage::Pairs, || pipeline.find_candidates(self.scene, exec));
        exec.stage(Stage::Narrow, || pipeline.judge(exec));
        ParryStep {
            candidates: &pipeline.candidates,
            contacts: &pipeline.contacts,
            refused: &pipeline.refused,
            report: &pipeline.report,
        }
    }
}

/// What a step found. Borrows the pipeline's buffers.
pub struct ParryStep<'p> {
    candidates: &'p [(u32, u32)],
    contacts: &'p Segments<Contact<()>>,
    refused: &'p [u32],
    report: &'p Report,
}

impl<'p> ParryStep<'p> {
    /// The pairs of objects whose AABBs overlap, in the tree's order.
    pub fn candidates(&self) -> impl ExactSizeIterator<Item = Pair> + use<'p> {
        self.candidates.iter().map(|&(a, b)| Pair::new(a, b))
    }

    /// The pairs that Parry says touch, in the same order.
    pub fn contacts(&self) -> impl Iterator<Item = Pair> + use<'p> {
        self.contacts.iter().flatten().map(|contact| contact.pair)
    }

    /// How many pairs Parry says touch.
    pub fn contact_count(&self) -> usize {
        self.contacts.len()
    }

    /// The pairs sorted, to be compared as a set.
    pub fn sorted_contacts(&self) -> Vec<Pair> {
        let mut contacts: Vec<_> = self.contacts().collect();
        contacts.sort_unstable();
        contacts
    }

    /// The objects whose shapes Parry refused: in no candidate.
    pub fn refused(&self) -> &'p [u32] {
        self.refused
    }

    /// How the candidates were decided, and which Parry left undecided.
    pub fn report(&self) -> &'p Report {
        self.report
    }
}
