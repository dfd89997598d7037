//! How deep pairs overlap: the polytope grows in f32, and f64 evaluates the face that it ends at.
//!
//! The last surface of the search is closed, and holds the origin by bounds that count every rounding. At [`Accuracy::F32`] those bounds are the depth's; at the others the faces that may be the
//! nearest are measured again in f64, where the depth and its bound come from (docs/numerics/proofs.md, "Depth by a
//! surface in f32"). What is not known as well as the accuracy requires is measured by the solver itself.

mod alone;
mod answers;
mod apart;
mod confirm;
mod formulas;
mod nearest_face;
mod of_parts;
mod points;
mod proposed;
mod search;
mod search_pairs;
mod searched;
mod start;
mod straight;
mod surface;
mod vectors;

pub(crate) use alone::SearchAlone;
pub(super) use points::Points;
pub use straight::CoreContact;
pub(crate) use straight::NearCore;
pub(super) use vectors::vertex;

use super::closed::{depths as of_cuboids, patches};
use super::form::Purpose;
use super::frame::{FramePair, SimdFrame};
use super::kind_order::KindOrder;
use super::scene_pairs::ScenePairs;
use super::spheres;
use super::support::SupportScratch;
use super::touching_parts::Wanted;
use super::{CertifiedBounds, ErrorBounds, Part, Scratch as Yes, Slice, append_touching, prepare};
use crate::closed::{self, Axes};
use crate::epa::Depth;
use crate::query::{FEWEST_MEASURED, FoundDepth as Found, MeasureDepth};
use crate::{
    Accuracy, ContactList, ContactSink, Depths, NarrowPhase, PosedShape, PosedSupport, Prepared,
    Reason, Sides, Verdict, order,
};
use answers::{Answers, Contacts, WriteDepth};
use apart::{ApartCores, Thought};
use dcd_geom::{Aabb, List, Pair, Scene};
use dcd_simd::{ArrayVec, Path, dispatch_on};
use formulas::{BySpheres, Listed, Sort, WritePatches};
use nearest_face::OfFaces;
use of_parts::OfParts;
use proposed::{Proposal, Propose};
use search_pairs::{SEATS, SearchPairs};
use searched::Searched;
use start::Starts;
use straight::StraightPairs;
use surface::Surface;

/// How deep the touching pairs overlap, and what a solver makes of it: [`Depths`] or
/// [`Manifolds`](crate::Manifolds), at any accuracy.
///
/// Contact is proved as in [`Overlap`](crate::Overlap). For polytopes of which one has no closed form the
/// depth is searched in f32, sixteen vertices or faces an operation, with a proved bound that is as good as the
/// accuracy requires: that of the search at [`Accuracy::F32`], at others and of rounded ones that of f64, which confirms it.
/// At [`Accuracy::F32`] so are cylinders and cones, rounded or not, beside polytopes and each other, and spheres and capsules have
/// the nearest points of their cores, with each other and cuboids. The solver measures all other pairs, and what is not known as
/// well. The same bits on every path and at any number of threads; (a, b) and (b, a) are
/// mirrored.
///
/// ```
/// use dcd_pipeline::prelude::*;
/// let poses = [0.0, 0.9, 2.1].map(|x| Pose::from_translation(DVec3::X * x));
/// let poses = poses.into_iter().collect::<Result<Vec<_>, _>>()?;
/// let scene = Scene::one_each(vec![Shape::sphere(0.5)?; 3], poses)?;
/// let narrow = SimdDepths::new(Depths, Accuracy::F32);
/// let mut pipeline = Pipeline::with(WideTree::default(), narrow);
/// let deep: Vec<_> = pipeline.step(&scene, Par::Serial).answers().collect();
/// assert_eq!((deep.len(), deep[0].pair), (1, Pair { i: 0, j: 1 }));
/// assert!((deep[0].answer.depth - 0.1).abs() <= deep[0].answer.error_bound);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct SimdDepths<S = Depths> {
    path: Path,
    accuracy: Accuracy,
    solver: S,
}

impl<S: MeasureDepth> SimdDepths<S> {
    /// The answers of that solver, at that accuracy.
    pub fn new(solver: S, accuracy: Accuracy) -> Self {
        Self::on(Path::best(), solver, accuracy)
    }

    /// The same on a path: see [`SimdOverlap::on`](super::SimdOverlap::on).
    pub fn on(path: Path, solver: S, accuracy: Accuracy) -> Self {
        Self { path, accuracy, solver }
    }
}

/// What a thread reuses from slice to slice.
#[derive(Debug, Default)]
pub struct Scratch<S> {
    yes: Yes,
    of_touching: TouchingScratch,
    of_parts: OfParts,
    touching: Vec<Pair>,
    left: Left,
    solver: S,
}

/// The pairs that the solver measures one by one.
#[derive(Debug, Default)]
struct Left {
    /// Their numbers among those that touch.
    numbers: Vec<u32>,
    /// The pairs, in the order of their numbers there.
    pairs: Vec<Pair>,
    order: KindOrder<u32>,
}

impl Left {
    /// Brings together those of the same kinds.
    fn sort(&mut self, frames: FramePair<'_>, touching: &[Pair]) {
        let Self { numbers, pairs, order } = self;
        order.sort((frames, touching), numbers, |&number| number);
        pairs.clear();
        pairs.extend(numbers.iter().map(|&number| touching[number as usize]));
    }
}

/// The same for the pairs that touch.
#[derive(Debug, Default)]
struct TouchingScratch {
    surfaces: Box<[Surface; SEATS]>,
    starts: Starts,
    of_cuboids: of_cuboids::Scratch,
    patches: patches::Scratch,
    /// The numbers of the pairs of cuboids that are not yet answered, in the order of those that `of_cuboids` looks at.
    cuboids: Vec<u32>,
    /// The pairs of cuboids that are not turned, where their patches are read.
    level: Listed,
    straight: StraightPairs,
    searched: Searched,
    apart: ApartCores,
    proposals: Vec<Option<Proposal>>,
    of_faces: OfFaces,
    support_scratch: SupportScratch,
}

impl<S: MeasureDepth> SimdDepths<S> {
    /// Answers pairs that touch, but for those that are left to the solver.
    fn answer(
        &self,
        objects: ScenePairs<'_>,
        scratch: &mut TouchingScratch,
        mut answers: Answers<'_, S>,
    ) {
        let answers = &mut answers;
        self.answer_by_formulas(objects, scratch, answers);
        if S::READS_PATCHES && self.accuracy == Accuracy::F32 {
            self.write_patches(objects, scratch, answers);
        }
        self.answer_cuboids(objects, scratch, answers);
        self.answer_searched(objects, scratch, answers);
        answers.end();
    }

    /// Answers those with formulas, and lists the others by what answers them.
    fn answer_by_formulas(
        &self,
        objects: ScenePairs<'_>,
        scratch: &mut TouchingScratch,
        answers: &mut Answers<'_, S>,
    ) {
        let TouchingScratch { of_cuboids, cuboids, level, straight, searched, apart, .. } = scratch;
        let accuracy = self.accuracy;
        straight.begin();
        let answers = &mut *answers;
        let lists = Sort {
            objects,
            accuracy,
            of_cuboids,
            cuboids,
            level,
            straight,
            searched,
            apart,
            answers,
        };
        dispatch_on(self.path, lists);
        straight.answer(answers);
    }

    /// Writes the patches of cuboids where the lanes find them.
    fn write_patches(
        &self,
        objects: ScenePairs<'_>,
        scratch: &mut TouchingScratch,
        answers: &mut Answers<'_, S>,
    ) {
        let TouchingScratch { of_cuboids, patches, cuboids, level, .. } = scratch;
        let frames = objects.frames;
        let Listed { numbers, pairs } = level;
        patches::level::find(self.path, frames, pairs, patches);
        let write = WritePatches { objects, patches, pairs, numbers, answers };
        dispatch_on(self.path, write);
        let pairs = &mut of_cuboids.pairs;
        pairs.append(&mut level.pairs);
        cuboids.append(&mut level.numbers);
        patches::find(self.path, frames, pairs, patches);
        let write = WritePatches { objects, patches, pairs, numbers: cuboids, answers };
        dispatch_on(self.path, write);
    }

    /// Answers cuboids along the axes that may be the least: those alone whose patch is not known.
    fn answer_cuboids(
        &self,
        objects: ScenePairs<'_>,
        scratch: &mut TouchingScratch,
        answers: &mut Answers<'_, S>,
    ) {
        let TouchingScratch { of_cuboids, cuboids, .. } = scratch;
        of_cuboids::find(self.path, objects.frames, of_cuboids);
        let listed = ScenePairs { pairs: &of_cuboids.pairs, ..objects };
        for (place, (&number, &axes)) in cuboids.iter().zip(&of_cuboids.axes).enumerate() {
            listed.look_ahead_to_shapes(place);
            let number = number as usize;
            let sides = objects.posed(objects.pairs[number]);
            let found = depth_of_cuboids(axes, sides, self.accuracy);
            let found = found.map(|depth| Found { depth, farthest: None });
            answers.write(number, found.as_ref());
        }
    }

    /// Answers those that need a search: first the pairs whose cores are predicted to be apart, then the others, and at last
    /// those whose cores the search finds apart.
    fn answer_searched(
        &self,
        objects: ScenePairs<'_>,
        scratch: &mut TouchingScratch,
        answers: &mut Answers<'_, S>,
    ) {
        let TouchingScratch {
            surfaces,
            starts,
            searched,
            apart,
            proposals,
            of_faces,
            support_scratch,
            ..
        } = scratch;
        let (accuracy, frames, reads_facets) = (self.accuracy, objects.frames, S::READS_FACETS);
        let of_facets = (objects, reads_facets);
        apart.answer(self.path, of_facets, (Thought::ByRecords, accuracy), answers, |_, number| {
            searched.push(frames, (number, objects.pairs[number as usize]));
        });
        searched.end(objects.pairs);
        if searched.pairs.is_empty() {
            return;
        }
        let proves = accuracy == Accuracy::F32;
        let of_pairs = (&*searched.pairs, proves);
        dispatch_on(self.path, Propose::of(frames, of_pairs, support_scratch, proposals));
        of_faces.take(searched, proposals);
        of_faces.answer_on(self.path, of_facets, answers);
        starts.begin();
        let looks_ahead = !objects.have_few_shapes();
        let apart_numbers = apart.begin();
        let search = SearchPairs {
            objects: ScenePairs { pairs: &searched.pairs, ..objects },
            numbers: &searched.numbers,
            place: 0,
            accuracy,
            starts,
            proposals,
            surfaces,
            apart: apart_numbers,
            reads_facets,
            looks_ahead,
            answers,
        };
        search.search_on(self.path);
        let how = (Thought::BySearch, accuracy);
        apart.answer(self.path, of_facets, how, answers, |answers, number| {
            answers.write(number as usize, None);
        });
    }
}

impl<S: MeasureDepth + 'static> NarrowPhase for SimdDepths<S> {
    type Answer = S::Answer;
    type Frame = SimdFrame;
    type Part<'f> = Part<'f>;
    type Scratch = Scratch<S::Scratch>;

    fn aabb_margin(&self) -> Option<f64> {
        Some(0.0)
    }

    fn fewest_pairs(&self, _: &SimdFrame) -> usize {
        FEWEST_MEASURED
    }

    fn layout<'f>(&self, scene: &Scene, sides: Sides, frame: &'f mut SimdFrame) -> Part<'f> {
        frame.layout(scene, sides, Purpose::Measure)
    }

    fn keeps(&self, part: &Part<'_>) -> bool {
        part.kept
    }

    fn prepare(&self, scene: &Scene, first: usize, part: Part<'_>, aabbs: &mut [Aabb]) {
        prepare::prepare(self.path, prepare::Prepare { scene, first, part, aabbs });
    }

    fn decide(
        &self,
        a: Prepared<'_, SimdFrame>,
        b: Prepared<'_, SimdFrame>,
        pairs: &[Pair],
        scratch: &mut Self::Scratch,
        sink: &mut ContactSink<'_, S::Answer>,
    ) {
        let Scratch { yes, of_touching, of_parts, touching, left, solver } = scratch;
        let frames = FramePair { a: a.frame, b: b.frame };
        if frames.are_spheres() {
            let objects = ScenePairs { frames, scenes: [a.scene, b.scene], pairs };
            let measure = BySpheres { narrow: self, objects, scratch: solver };
            return spheres::decide(self.path, (frames, pairs, 0.0), measure, sink);
        }
        let wanted = if S::READS_BOUNDS { Wanted::Bounds } else { Wanted::Parts };
        yes.touching_parts.begin(wanted);
        CertifiedBounds::judge(&Slice { path: self.path, a, b, pairs }, yes, sink.report);
        touching.clear();
        append_touching((yes.touching(), pairs), touching, |pair| pair);
        // Each answer is written when it is known.
        let first = sink.contacts.len();
        touching.iter().for_each(|&pair| sink.contacts.push_pair(pair));
        left.numbers.clear();
        let objects = ScenePairs { frames, scenes: [a.scene, b.scene], pairs: touching };
        let (contacts, numbers) = (&mut *sink.contacts, &mut left.numbers);
        let to = Contacts {
            path: self.path,
            solver: &self.solver,
            scratch: solver,
            contacts,
            first,
            left: numbers,
        };
        let answers = Answers { objects, to, waiting: ArrayVec::new() };
        self.answer(objects, of_touching, answers);
        let of_compounds = (pairs, &yes.touching_parts.of_compounds);
        of_parts.measure((self.path, self.accuracy), objects, of_compounds, of_touching);
        let (of_parts, mut parts) = (&*of_parts, Vec::new());
        left.sort(frames, touching);
        let mut lists = yes.touching_parts.lists().peekable();
        let Left { numbers, pairs: in_order, .. } = left;
        let in_order = ScenePairs { pairs: in_order, ..objects };
        let mut place = 0;
        numbers.retain(|&number| {
            let pair = in_order.pairs[place];
            in_order.look_ahead_to_measured(place, S::READS_FACETS);
            place += 1;
            let sides = objects.posed(pair);
            let to = first + number as usize;
            let measured = match lists.next_if(|&(listed, _)| pairs[listed as usize] == pair) {
                Some((_, known)) => {
                    if let Some((next, known)) = lists.peek() {
                        in_order.look_ahead_to_parts(pairs[*next as usize], known.parts);
                    }
                    let mut verdict = Verdict::Apart;
                    sink.contacts.write(to, |answer| {
                        verdict =
                            self.solver.measure_parts(self.accuracy, known, sides, solver, answer);
                        verdict == Verdict::Touching(())
                    });
                    verdict
                }
                None if of_parts.list_known(objects, number, &mut parts) => {
                    let mut verdict = Verdict::Apart;
                    sink.contacts.write(to, |answer| {
                        let known = &mut parts[..];
                        verdict = self.solver.measure_compounds(
                            self.accuracy,
                            known,
                            sides,
                            solver,
                            answer,
                        );
                        verdict == Verdict::Touching(())
                    });
                    verdict
                }
                None => {
                    let place = (&mut *sink.contacts, to);
                    self.solver.measure_alone(self.accuracy, sides, solver, place)
                }
            };
            match measured {
                Verdict::Touching(()) => return false,
                Verdict::Apart if self.solver.may_leave_out() => {}
                Verdict::Apart => sink.report.leave_unmeasured(pair, Reason::WithinRounding),
                Verdict::Undecided(reason) => sink.report.leave_unmeasured(pair, reason),
            }
            true
        });
        if !numbers.is_empty() {
            numbers.sort_unstable();
            sink.contacts.take_away(first, numbers);
        }
    }

    fn sense(
        &self,
        a: Prepared<'_, SimdFrame>,
        b: Prepared<'_, SimdFrame>,
        pairs: &[Pair],
        scratch: &mut Self::Scratch,
        sink: &mut ContactSink<'_, S::Answer>,
    ) {
        let yes = &mut scratch.yes;
        yes.touching_parts.begin(Wanted::Nothing);
        CertifiedBounds::judge(&Slice { path: self.path, a, b, pairs }, yes, sink.report);
        let touching = pairs.iter().zip(yes.touching()).filter(|(_, yes)| **yes);
        touching.for_each(|(&pair, _)| sink.contacts.push_pair(pair));
    }
}

/// The depth of two cuboids, along the axes that may be the least.
pub(crate) fn depth_of_cuboids(
    axes: Axes,
    [a, b]: [PosedShape<'_>; 2],
    accuracy: Accuracy,
) -> Option<Depth> {
    let (in_a, in_b) = (a.shape.as_polytope()?, b.shape.as_polytope()?);
    let swapped = order::is_swapped(a, b);
    let (a, b) = (PosedSupport::polytope(in_a, a.pose), PosedSupport::polytope(in_b, b.pose));
    let (a, b, axes) = if swapped { (b, a, axes.mirrored()) } else { (a, b, axes) };
    let found =
        closed::upright_depth(a, b).or_else(|| closed::cuboid_depth_along(axes, a, b, accuracy))?;
    Some(if swapped { found.mirrored() } else { found })
}
