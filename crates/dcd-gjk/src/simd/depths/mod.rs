//! How deep pairs overlap: the polytope grows in f32, and f64 confirms the face that it ends at.
//!
//! The search in f32 finds where to look, nothing more: its last surface is closed, and holds the origin by bounds
//! that count every rounding; the faces that may be the nearest are measured again in f64, where the depth and its
//! bound come from (docs/numerics/proofs.md, "Depth by a surface in f32"). What is not confirmed as well as the
//! accuracy requires is measured by the solver itself.

mod search;
mod surface;

use super::closed::{are_cuboids, depths as of_cuboids};
use super::cores::{Core, Cores};
use super::frame::{FramePair, SimdFrame};
use super::{CertifiedBounds, ErrorBounds, Part, Scratch as Yes, Slice, prepare};
use crate::closed::{self, Axes};
use crate::epa::Depth;
use crate::expanding::{Ending, confirmed_depth, is_inside};
use crate::query::MeasureDepth;
use crate::{
    Accuracy, Contact, ContactSink, Depths, Difference, NarrowPhase, PosedShape, PosedSupport,
    Prepared, Sides, Verdict, order,
};
use dcd_geom::glam::{DVec3, Vec3};
use dcd_geom::{Aabb, Kind, Pair, Polytope, Scene};
use dcd_simd::{Block, Kernel, Lanes, Path, dispatch_on};
use search::{LENGTH, OFF, Search};
use surface::{Point, Surface};

/// How deep the touching pairs overlap, and what a solver makes of it: [`Depths`] or
/// [`Manifolds`](crate::Manifolds), at any accuracy.
///
/// Contact is proved as in [`Overlap`](crate::Overlap). For polytopes without a swept radius the
/// depth is searched in f32, sixteen vertices or faces an operation, and confirmed in f64 with a proved bound that is
/// as good as the accuracy requires; the solver measures all other pairs, and what is not confirmed. The same bits
/// on every path and at any number of threads; (a, b) and (b, a) are mirrored.
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
    search: search::Scratch,
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
        let Scratch { yes, search, of_cuboids, found, solver } = scratch;
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
        let axes = &of_cuboids.axes;
        dispatch_on(self.path, Each { frames, accuracy, each, axes, search, found: &mut *found });
        for (pair, found) in touching().zip(&*found) {
            if let Some(depth) = found.filter(|_| frames.spheres(pair).is_some()) {
                let answer = self.solver.measure_spheres(depth);
                sink.contacts.push(Contact { pair, answer });
                continue;
            }
            let [one, other] = posed(pair);
            if let Some(depth) = found
                && are_cuboids(frames, pair)
            {
                sink.contacts.push(Contact { pair, answer: S::Answer::default() });
                let answer = sink.contacts.last_mut().map(|contact| &mut contact.answer);
                if answer.is_some_and(|answer| {
                    self.solver.measure_cuboids(depth, [one, other], solver, answer)
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

/// Searches pair after pair.
struct Each<'a, I> {
    frames: FramePair<'a>,
    accuracy: Accuracy,
    /// Touching pairs, with the numbers of their shapes.
    each: I,
    /// For each pair of cuboids among them the axes that count.
    axes: &'a [Axes],
    search: &'a mut search::Scratch,
    found: &'a mut Vec<Option<Depth>>,
}

impl<'a, I: Iterator<Item = (Pair, [PosedShape<'a>; 2], [u32; 2])>> Kernel for Each<'a, I> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        let Self { frames, accuracy, each, axes, search, found } = self;
        let mut axes = axes.iter();
        for (pair, [a, b], [shape_a, shape_b]) in each {
            if let Some(spheres) = frames.spheres(pair) {
                found.push(closed::depth_of_spheres(spheres, closed::sharp_of(accuracy)));
                continue;
            }
            if are_cuboids(frames, pair) {
                found.push(axes.next().and_then(|&axes| depth_of_cuboids(axes, [a, b], accuracy)));
                continue;
            }
            let (cores_a, cores_b) = (frames.a.cores(), frames.b.cores());
            let side = |cores: &'a Cores, shape: u32, placed| {
                let core = &cores.cores()[shape as usize];
                Side { core, blocks: cores.blocks(core), placed }
            };
            let (a, b) = (side(cores_a, shape_a, a), side(cores_b, shape_b, b));
            found.push(depth(l, [a, b], accuracy, search));
        }
    }
}

/// The depth of two cuboids, along the axes that may be the least.
fn depth_of_cuboids(axes: Axes, [a, b]: [PosedShape<'_>; 2], accuracy: Accuracy) -> Option<Depth> {
    let (in_a, in_b) = (a.shape.as_polytope()?, b.shape.as_polytope()?);
    let swapped = order::is_swapped(a, b);
    let (a, b) = (PosedSupport::polytope(in_a, a.pose), PosedSupport::polytope(in_b, b.pose));
    match swapped {
        true => closed::cuboid_depth_along(axes.mirrored(), b, a, accuracy).map(Depth::mirrored),
        false => closed::cuboid_depth_along(axes, a, b, accuracy),
    }
}

/// An object as the search reads it.
#[derive(Clone, Copy)]
struct Side<'a> {
    core: &'a Core,
    blocks: &'a [Block],
    placed: PosedShape<'a>,
}

impl<'a> Side<'a> {
    /// Of a polytope.
    fn support(&self) -> Option<PosedSupport<'a, Polytope>> {
        let polytope = self.placed.shape.as_polytope()?;
        Some(PosedSupport::polytope(polytope, self.placed.pose))
    }
}

/// The depth of two objects that touch, confirmed; `None` where it is not, and of shapes that are not searched.
#[inline(always)]
fn depth<L: Lanes>(
    l: L,
    [a, b]: [Side<'_>; 2],
    accuracy: Accuracy,
    scratch: &mut search::Scratch,
) -> Option<Depth> {
    let sharp = |side: Side<'_>| {
        let polytope = side.placed.shape.as_polytope().filter(|p| p.swept_radius() == 0.0)?;
        Some(polytope.kind())
    };
    // Two cuboids have a formula.
    if let (Kind::Cuboid { .. }, Kind::Cuboid { .. }) = (sharp(a)?, sharp(b)?) {
        return None;
    }
    let swapped = order::is_swapped(a.placed, b.placed);
    let (a, b) = if swapped { (b, a) } else { (a, b) };
    let bodies = [a.support()?, b.support()?];
    let difference = Difference::new(bodies[0], bodies[1])?;
    let sides = [(a.core, a.blocks, a.placed.pose), (b.core, b.blocks, b.placed.pose)];
    let search = Search::of(&difference, sides, scratch)?;
    let unit = f64::from(search.unit);
    search.run(l)?;
    let found = confirmed(&scratch.surface, unit, |ending| {
        confirmed_depth(difference, bodies, accuracy, &ending)
    })?;
    Some(if swapped { found.mirrored() } else { found })
}

/// Hands on the faces of the last surface that may be the nearest, and what is proved of the others.
fn confirmed(
    surface: &Surface,
    unit: f64,
    confirm: impl FnOnce(Ending<'_>) -> Option<Depth>,
) -> Option<Depth> {
    let off = OFF * unit;
    let distance = |face: usize| f64::from(surface.distance(face));
    let least = (0..surface.faces()).map(distance).fold(f64::INFINITY, f64::min);
    let limit = least + 2.0 * off;
    let mut faces = [[[0; 2]; 3]; MOST];
    let mut count = 0;
    for face in (0..surface.faces()).filter(|&face| distance(face) <= limit) {
        let [p, q, r] = surface.corners(face);
        *faces.get_mut(count)? = [p.vertices, q.vertices, r.vertices];
        count += 1;
    }
    let holds_origin = least * LENGTH > off && all_inward(surface);
    let others = holds_origin.then_some(limit * LENGTH - off);
    confirm(Ending { faces: &faces[..count], others })
}

/// How many faces may be the nearest to f32's knowledge: what is more goes to the search in f64. Two are the rule where
/// edges cross.
const MOST: usize = 8;

/// Whether every face surely has the origin on its inner side: f64 looks at those that f32 is not sure of.
fn all_inward(surface: &Surface) -> bool {
    let mut doubtful = surface.doubtful();
    while doubtful != 0 {
        let face = doubtful.trailing_zeros() as usize;
        doubtful &= doubtful - 1;
        let at = |point: Point| Vec3::from_array(point.at).as_dvec3();
        let corners: [DVec3; 3] = surface.corners(face).map(at);
        if !is_inside(corners) {
            return false;
        }
    }
    true
}
