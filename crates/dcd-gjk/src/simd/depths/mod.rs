//! How deep pairs overlap: the polytope grows in f32, and f64 evaluates the face that it ends at.
//!
//! The last surface of the search is closed, and holds the origin by bounds that count every rounding. At [`Accuracy::F32`] those bounds are the depth's; at the others the faces that may be the
//! nearest are measured again in f64, where the depth and its bound come from (docs/numerics/proofs.md, "Depth by a
//! surface in f32"). What is not known as well as the accuracy requires is measured by the solver itself.

mod answers;
mod apart;
mod confirm;
mod formulas;
mod nearest_face;
mod of_parts;
mod proposed;
mod search;
mod searched;
mod start;
mod surface;
mod vectors;

pub(super) use vectors::vertex;

use super::closed::{depths as of_cuboids, patches};
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
    Sides, Verdict, order,
};
use answers::{Answers, Contacts, WriteDepth};
use apart::{ApartCores, Thought};
use confirm::{Ended, SearchedPair, Side};
use dcd_geom::{Aabb, List, Pair, Scene};
use dcd_simd::{ArrayVec, Kernel, Lanes, Path, dispatch_on};
use formulas::{BySpheres, Sort, WritePatches};
use nearest_face::OfFaces;
use of_parts::OfParts;
use proposed::{Proposal, Propose};
use search::{DepthSearch, Next};
use searched::Searched;
use start::Starts;
use surface::{Point, Surface};

/// How deep the touching pairs overlap, and what a solver makes of it: [`Depths`] or
/// [`Manifolds`](crate::Manifolds), at any accuracy.
///
/// Contact is proved as in [`Overlap`](crate::Overlap). For polytopes of which one has no closed form the
/// depth is searched in f32, sixteen vertices or faces an operation, with a proved bound that is as good as the
/// accuracy requires: that of the search at [`Accuracy::F32`], at others and of rounded ones that of f64, which confirms it.
/// The solver measures all other pairs, and what is not known as well. The same bits on every path and at any number of threads;
/// (a, b) and (b, a) are mirrored.
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
        let TouchingScratch {
            surfaces,
            starts,
            of_cuboids,
            patches,
            cuboids,
            searched,
            apart,
            proposals,
            of_faces,
            support_scratch,
        } = scratch;
        let (accuracy, frames, answers) = (self.accuracy, objects.frames, &mut answers);
        let sort = Sort { objects, accuracy, of_cuboids, cuboids, searched, apart, answers };
        dispatch_on(self.path, sort);
        if S::READS_PATCHES && accuracy == Accuracy::F32 {
            patches::find(self.path, frames, &of_cuboids.pairs, patches);
            let patches = &*patches;
            let write = WritePatches { objects, patches, of_cuboids, cuboids, answers };
            dispatch_on(self.path, write);
        }
        // The axes count of those alone whose patch is not known.
        of_cuboids::find(self.path, frames, of_cuboids);
        let listed = ScenePairs { pairs: &of_cuboids.pairs, ..objects };
        for (place, (&number, &axes)) in cuboids.iter().zip(&of_cuboids.axes).enumerate() {
            listed.look_ahead_to_shapes(place);
            let number = number as usize;
            let sides = objects.posed(objects.pairs[number]);
            let found = depth_of_cuboids(axes, sides, accuracy);
            let found = found.map(|depth| Found { depth, farthest: None });
            answers.write(number, found.as_ref());
        }
        // What is thought to be apart first, and then what turns out to be.
        let (of_facets, how) = ((objects, S::READS_FACETS), (Thought::ByRecords, accuracy));
        apart.answer(self.path, of_facets, how, answers, |_, number| {
            searched.push(frames, (number, objects.pairs[number as usize]));
        });
        searched.end(objects.pairs);
        if !searched.pairs.is_empty() {
            let proves = accuracy == Accuracy::F32;
            let of_pairs = (&*searched.pairs, proves);
            dispatch_on(self.path, Propose::of(frames, of_pairs, support_scratch, proposals));
            of_faces.take(searched, proposals);
            let reads_facets = S::READS_FACETS;
            of_faces.answer_on(self.path, (objects, reads_facets), answers);
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
        answers.end();
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
        frame.layout(scene, sides)
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
            if let Verdict::Undecided(reason) = measured {
                sink.report.leave_unmeasured(pair, reason);
            }
            measured != Verdict::Touching(())
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

/// How many pairs are searched side by side: the supports of one do not wait for the faces of another. No effect on any
/// result. Larger: surfaces that leave the nearest cache. Smaller: arithmetic that waits.
const SEATS: usize = 8;

/// Searches the pairs.
struct SearchPairs<'a> {
    objects: ScenePairs<'a>,
    /// Their numbers among the touching ones.
    numbers: &'a [u32],
    /// Which of them is searched next.
    place: usize,
    accuracy: Accuracy,
    surfaces: &'a mut [Surface; SEATS],
    starts: &'a mut Starts,
    /// What of each the search starts with, if something is proposed.
    proposals: &'a [Option<Proposal>],
    /// The numbers of the swept pairs whose cores do not overlap, as far as f32 knows.
    apart: &'a mut Vec<u32>,
    /// Whether the facets of a pair are read where its answer is written.
    reads_facets: bool,
    /// Whether what the next pairs read is prefetched.
    looks_ahead: bool,
    answers: &'a mut dyn WriteDepth,
}

/// A pair that is being searched.
struct Seat<'a> {
    /// Its number among the touching ones.
    number: usize,
    pair: SearchedPair<'a>,
    search: DepthSearch,
    /// The support that was evaluated last.
    point: Point,
}

impl Kernel for SearchPairs<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(mut self, l: L) {
        let mut seats = [const { None }; SEATS];
        // What the answer of a pair reads and writes is prefetched when its search ends. It has come when that of the next
        // one ends: only then is the answer written.
        let mut last = None;
        loop {
            let mut is_idle = true;
            for (number, seat) in seats.iter_mut().enumerate() {
                if seat.is_none() {
                    *seat = self.next(l, number);
                }
                is_idle &= seat.is_none();
            }
            if is_idle {
                break;
            }
            for seat in seats.iter_mut().flatten() {
                seat.point = seat.search.support(l, &seat.pair.cloud);
            }
            for (place, surface) in seats.iter_mut().zip(&mut *self.surfaces) {
                let Some(seat) = place else { continue };
                let found = match seat.search.take(l, seat.point, surface) {
                    Next::Support => continue,
                    Next::Ended { nearest, reach } => {
                        self.answers.prefetch(seat.number);
                        if self.reads_facets && self.looks_ahead {
                            seat.pair.prefetch_half_edges(&seat.point);
                        }
                        let ended = Ended { surface, nearest, reach, farthest: seat.point };
                        seat.pair.depth(l, self.accuracy, &ended)
                    }
                    Next::Failed => None,
                };
                if found.is_none() && seat.pair.is_swept() {
                    self.apart.push(seat.number as u32);
                    *place = None;
                    continue;
                }
                if let Some(before) = last.replace((seat.number, found)) {
                    self.answers.write(before.0, before.1.as_ref());
                }
                *place = None;
            }
        }
        if let Some((number, found)) = last {
            self.answers.write(number, found.as_ref());
        }
    }
}

impl<'a> SearchPairs<'a> {
    fn search_on(self, path: Path) {
        dispatch_on(path, self);
    }

    /// The next pair that is to be searched, in the seat of that number; those before it are answered.
    #[inline(always)]
    fn next<L: Lanes>(&mut self, l: L, seat: usize) -> Option<Seat<'a>> {
        let ScenePairs { frames, pairs, .. } = self.objects;
        loop {
            let place = self.place;
            let (&pair, number) = (pairs.get(place)?, *self.numbers.get(place)? as usize);
            self.place += 1;
            let [a, b] = self.objects.posed(pair);
            if self.looks_ahead {
                self.objects.look_ahead(place, self.reads_facets);
            }
            let [of_a, of_b] = self.objects.cores(pair);
            let side = |core, frame: &'a SimdFrame, record: u32, placed| {
                let blocks = frame.blocks_of(frame.record(record));
                Side { core, blocks, placed }
            };
            let sides = [side(of_a, frames.a, pair.i, a), side(of_b, frames.b, pair.j, b)];
            if let Some(searched) = SearchedPair::of(sides, self.accuracy) {
                let accuracy = searched.sharpened(self.accuracy);
                let mut search = DepthSearch::new(&searched.cloud, accuracy);
                if !self.start_proposed(l, (&searched, place), (&mut search, seat)) {
                    let is_second = !frames.is_one();
                    let of_a = self.starts.of(l, (pair.i, false), sides[0].blocks);
                    let of_b = self.starts.of(l, (pair.j, is_second), sides[1].blocks);
                    let extremes = searched.in_order([&of_a, &of_b]);
                    search.start(l, &searched.cloud, extremes, &mut self.surfaces[seat]);
                }
                return Some(Seat { number, pair: searched, search, point: Point::default() });
            }
            self.answers.write(number, None);
        }
    }

    /// Starts from the triangle that is proposed for the pair in that place; false where there is none, or a flat one.
    #[inline(always)]
    fn start_proposed<L: Lanes>(
        &mut self,
        l: L,
        (searched, place): (&SearchedPair<'_>, usize),
        (search, seat): (&mut DepthSearch, usize),
    ) -> bool {
        let Some(Some(proposal)) = self.proposals.get(place) else { return false };
        let [p, q, r] = proposal.triangle;
        let triangle = [searched.in_order(p), searched.in_order(q), searched.in_order(r)];
        search.start_proposed(l, &searched.cloud, triangle, &mut self.surfaces[seat])
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
