//! How deep pairs overlap: the polytope grows in f32, and f64 evaluates the face that it ends at.
//!
//! The last surface of the search is closed, and holds the origin by bounds that count every rounding. At [`Accuracy::F32`] those bounds are the depth's; at the others the faces that may be the
//! nearest are measured again in f64, where the depth and its bound come from (docs/numerics/proofs.md, "Depth by a
//! surface in f32"). What is not known as well as the accuracy requires is measured by the solver itself.

mod confirm;
mod search;
mod surface;

use super::closed::{are_cuboids, depths as of_cuboids};
use super::frame::{FramePair, SimdFrame};
use super::{CertifiedBounds, ErrorBounds, Part, Scratch as Yes, Slice, prepare};
use crate::closed::{self, Axes};
use crate::epa::Depth;
use crate::query::MeasureDepth;
use crate::{
    Accuracy, Contact, ContactSink, Depths, NarrowPhase, PosedShape, PosedSupport, Prepared, Sides,
    Verdict, order,
};
use confirm::{Ended, SearchedPair, Side};
use dcd_geom::{Aabb, Pair, Scene};
use dcd_simd::{Kernel, Lanes, Path, dispatch_on};
use search::{Next, Search};
use std::slice::Iter;
use surface::{Point, Surface};

/// How deep the touching pairs overlap, and what a solver makes of it: [`Depths`] or
/// [`Manifolds`](crate::Manifolds), at any accuracy.
///
/// Contact is proved as in [`Overlap`](crate::Overlap). For polytopes without a swept radius the
/// depth is searched in f32, sixteen vertices or faces an operation, with a proved bound that is as good as the
/// accuracy requires: that of the search at [`Accuracy::F32`], at others that of f64, which confirms it. The solver
/// measures all other pairs, and what is not known as well. The same bits on every path and at any number of threads;
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
    surfaces: Box<[Surface; SEATS]>,
    of_cuboids: of_cuboids::Scratch,
    /// For each touching pair its depth, if it is confirmed.
    found: Vec<Option<Depth>>,
    solver: S,
}

impl<S: MeasureDepth + 'static> NarrowPhase for SimdDepths<S> {
    type Answer = S::Answer;
    type Frame = SimdFrame;
    type Part<'f> = Part<'f>;
    type Scratch = Scratch<S::Scratch>;

    fn aabb_margin(&self) -> Option<f64> {
        Some(0.0)
    }

    fn layout<'f>(&self, scene: &Scene, sides: Sides, frame: &'f mut SimdFrame) -> Part<'f> {
        frame.layout(scene, sides)
    }

    fn keeps(&self, part: &Part<'_>) -> bool {
        part.kept
    }

    fn prepare(&self, scene: &Scene, first: usize, part: Part<'_>, aabbs: &mut [Aabb]) {
        prepare::prepare_unfused(self.path, prepare::Prepare { scene, first, part, aabbs });
    }

    fn decide(
        &self,
        a: Prepared<'_, SimdFrame>,
        b: Prepared<'_, SimdFrame>,
        pairs: &[Pair],
        scratch: &mut Self::Scratch,
        sink: &mut ContactSink<'_, S::Answer>,
    ) {
        let Scratch { yes, surfaces, of_cuboids, found, solver } = scratch;
        CertifiedBounds::judge(&Slice { path: self.path, a, b, pairs }, yes, sink.report);
        let touching =
            || pairs.iter().zip(yes.touching()).filter(|(_, yes)| **yes).map(|(p, _)| *p);
        found.clear();
        let accuracy = self.accuracy;
        let frames = FramePair { a: a.frame, b: b.frame };
        let posed = |pair: Pair| [PosedShape::of(a.scene, pair.i), PosedShape::of(b.scene, pair.j)];
        let shapes =
            |pair: Pair| [a.scene.shape_of()[pair.i as usize], b.scene.shape_of()[pair.j as usize]];
        of_cuboids.pairs.clear();
        of_cuboids.pairs.extend(touching().filter(|&pair| are_cuboids(frames, pair)));
        of_cuboids::find(self.path, frames, of_cuboids);
        let each = touching().map(|pair| (pair, posed(pair), shapes(pair)));
        let axes = of_cuboids.axes.iter();
        let found_here = &mut *found;
        dispatch_on(self.path, Each { frames, accuracy, each, axes, surfaces, found: found_here });
        for (pair, found) in touching().zip(&*found) {
            if let Some(depth) = found.filter(|_| frames.spheres(pair).is_some()) {
                let answer = self.solver.measure_spheres(depth);
                sink.contacts.push(Contact { pair, answer });
                continue;
            }
            let [one, other] = posed(pair);
            if let Some(depth) = found {
                sink.contacts.push(Contact { pair, answer: S::Answer::default() });
                let answer = sink.contacts.last_mut().map(|contact| &mut contact.answer);
                if answer.is_some_and(|answer| {
                    self.solver.measure_polytopes(depth, [one, other], solver, answer)
                }) {
                    continue;
                }
                sink.contacts.pop();
            }
            let verdict = match found {
                Some(depth) => self.solver.measure_depth(*depth, one, other, solver),
                None => self.solver.measure_at(self.accuracy, one, other, solver),
            };
            match verdict {
                Verdict::Touching(answer) => sink.contacts.push(Contact { pair, answer }),
                Verdict::Apart => {}
                Verdict::Undecided(reason) => sink.report.leave_unmeasured(pair, reason),
            }
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
        CertifiedBounds::judge(&Slice { path: self.path, a, b, pairs }, yes, sink.report);
        let touching = pairs.iter().zip(yes.touching()).filter(|(_, yes)| **yes);
        let unmeasured = |(&pair, _)| Contact { pair, answer: S::Answer::default() };
        sink.contacts.extend(touching.map(unmeasured));
    }
}

/// How many pairs are searched side by side: the supports of one do not wait for the faces of another. No effect on any
/// result. Larger: surfaces that leave the nearest cache. Smaller: arithmetic that waits.
const SEATS: usize = 8;

/// Searches the pairs.
struct Each<'a, I> {
    frames: FramePair<'a>,
    accuracy: Accuracy,
    /// Touching pairs, with the numbers of their shapes.
    each: I,
    /// For each pair of cuboids among them the axes that count.
    axes: Iter<'a, Axes>,
    surfaces: &'a mut [Surface; SEATS],
    found: &'a mut Vec<Option<Depth>>,
}

/// A pair that is being searched.
struct Seat<'a> {
    /// Its number among the touching ones.
    number: usize,
    pair: SearchedPair<'a>,
    search: Search,
    /// The support that was evaluated last.
    point: Point,
}

impl<'a, I: Iterator<Item = (Pair, [PosedShape<'a>; 2], [u32; 2])>> Kernel for Each<'a, I> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(mut self, l: L) {
        let mut seats: [Option<Seat<'a>>; SEATS] = [const { None }; SEATS];
        loop {
            let mut is_idle = true;
            for seat in &mut seats {
                if seat.is_none() {
                    *seat = self.next();
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
                match seat.search.take(l, seat.point, surface) {
                    Next::Support => continue,
                    Next::Ended { nearest, reach } => {
                        let ended = Ended { surface, nearest, reach };
                        self.found[seat.number] = seat.pair.depth(l, self.accuracy, &ended);
                    }
                    Next::Failed => {}
                }
                *place = None;
            }
        }
    }
}

impl<'a, I: Iterator<Item = (Pair, [PosedShape<'a>; 2], [u32; 2])>> Each<'a, I> {
    /// The next pair that is to be searched; those before it are answered.
    #[inline(always)]
    fn next(&mut self) -> Option<Seat<'a>> {
        loop {
            let (pair, [a, b], [shape_a, shape_b]) = self.each.next()?;
            let number = self.found.len();
            if let Some(spheres) = self.frames.spheres(pair) {
                let sharp = closed::sharp_of(self.accuracy);
                self.found.push(closed::depth_of_spheres(spheres, sharp));
                continue;
            }
            if are_cuboids(self.frames, pair) {
                let axes = self.axes.next();
                self.found
                    .push(axes.and_then(|&axes| depth_of_cuboids(axes, [a, b], self.accuracy)));
                continue;
            }
            self.found.push(None);
            let side = |frame: &'a SimdFrame, object: u32, shape: u32, placed| {
                let core = &frame.cores().cores()[shape as usize];
                Side { core, blocks: frame.blocks_of(frame.record(object)), placed }
            };
            let a = side(self.frames.a, pair.i, shape_a, a);
            let b = side(self.frames.b, pair.j, shape_b, b);
            if let Some(pair) = SearchedPair::of(a, b) {
                let search = Search::new(&pair.cloud, self.accuracy);
                return Some(Seat { number, pair, search, point: Point::default() });
            }
        }
    }
}

/// The depth of two cuboids, along the axes that may be the least.
fn depth_of_cuboids(axes: Axes, [a, b]: [PosedShape<'_>; 2], accuracy: Accuracy) -> Option<Depth> {
    let (in_a, in_b) = (a.shape.as_polytope()?, b.shape.as_polytope()?);
    let swapped = order::is_swapped(a, b);
    let (a, b) = (PosedSupport::polytope(in_a, a.pose), PosedSupport::polytope(in_b, b.pose));
    let (a, b, axes) = if swapped { (b, a, axes.mirrored()) } else { (a, b, axes) };
    let found =
        closed::upright_depth(a, b).or_else(|| closed::cuboid_depth_along(axes, a, b, accuracy))?;
    Some(if swapped { found.mirrored() } else { found })
}
