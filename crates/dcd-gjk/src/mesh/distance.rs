//! How far apart two shapes are: pairs of blocks and parts, the nearest boxes first, until no box
//! left over is nearer than what was found.

use super::nearest_triangle::{Left, nearest_parts};
use super::pair;
use super::relative_pose::RelativePose;
use super::side::{Parts, Side};
use super::{Scratch, in_order};
use crate::Method;
use crate::distance::{
    Distance, DistanceResult, distance_at as of_convex, gap_along, in_f64, of_apart,
};
use crate::query::{Accuracy, may_be_nearest};
use crate::{PosedShape, PosedSupport, Reason, closed};
use dcd_simd::{Kernel, Lanes, Row, WIDTH, dispatch};
use std::cmp::Ordering;

/// What is still to be looked at, and how near it may be.
#[derive(Clone, Copy, Debug)]
pub(super) struct Open {
    /// At most the distance between the two boxes' contents, metres, at least 0.
    pub(super) lower: f32,
    pub(super) what: What,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum What {
    Parts([u32; 2]),
    Blocks([u32; 2]),
}

/// The nearest is the greatest, for a heap; of equals any, but always the same.
impl Ord for Open {
    fn cmp(&self, other: &Self) -> Ordering {
        other.lower.total_cmp(&self.lower).then_with(|| other.what.cmp(&self.what))
    }
}

impl PartialOrd for Open {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Open {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Open {}

/// The distance of two shapes, at least one of them a compound or a mesh, with the highest method
/// that was needed: that of their nearest parts, with witness points on those.
///
/// Never undecided where all parts are polytopes. (a, b) and (b, a) give the same bits, mirrored.
/// Of a mesh and another, a convex shape or a compound of few parts, f64 finds the few triangles that may be the nearest; else it
/// costs some microseconds for every pair of parts whose boxes are nearer than the parts.
pub fn distance(
    a: PosedShape<'_>,
    b: PosedShape<'_>,
    scratch: &mut Scratch,
) -> (DistanceResult, Method) {
    distance_at(Accuracy::Certified, [a, b], scratch)
}

/// The same with the parts measured at an accuracy.
pub(crate) fn distance_at(
    accuracy: Accuracy,
    sides: [PosedShape<'_>; 2],
    scratch: &mut Scratch,
) -> (DistanceResult, Method) {
    match nearer_than((f64::MAX, accuracy), sides, scratch) {
        (Limited::Known(found), method) => (found, method),
        (Limited::Beyond, method) => (DistanceResult::Undecided(Reason::Range), method),
    }
}

/// What is known of two shapes of which a distance below a limit alone matters.
pub(crate) enum Limited {
    /// That they are at least so far apart.
    Beyond,
    Known(DistanceResult),
}

impl Limited {
    /// The same seen from b.
    pub(crate) fn mirrored(self) -> Self {
        match self {
            Self::Beyond => Self::Beyond,
            Self::Known(found) => Self::Known(found.mirrored()),
        }
    }
}

/// The same where a distance below `far` alone matters: metres.
pub(crate) fn nearer_than(
    (far, accuracy): (f64, Accuracy),
    [a, b]: [PosedShape<'_>; 2],
    scratch: &mut Scratch,
) -> (Limited, Method) {
    let ([first, second], swapped) = in_order(a, b);
    let in_order = if swapped { [b, a] } else { [a, b] };
    let (a, b) = (&first, &second);
    let mut best = Best::at(accuracy);
    let alone = |parts| NearParts { parts, start: None };
    if let Some(parts) = lowest_parts([a, b]).or_else(|| may_be_nearest(in_order)) {
        best.measure_all([a, b], parts.into_iter().map(alone));
    } else if let Some(relative) = RelativePose::of(a, b) {
        match nearest_parts([a, b], &relative, scratch, far) {
            Some(Left::Touching) => best.touching = true,
            Some(Left::Near(parts)) if parts.is_empty() => return (Limited::Beyond, Method::F64),
            Some(Left::Near(parts)) => {
                best.is_sifted = true;
                best.measure_all([a, b], parts.into_iter().map(alone));
            }
            None => best = dispatch(NearestParts { a, b, relative: &relative, scratch, best }),
        }
    } else {
        let of_a = |part_a| (0..b.count()).map(move |part_b| [part_a, part_b]);
        best.measure_all([a, b], (0..a.count()).flat_map(of_a).map(alone));
    }
    let (result, method) = best.answer();
    (Limited::Known(if swapped { result.mirrored() } else { result }), method)
}

/// Two parts by index, and vertices of each between which their nearest points are thought to be, where these are known: any are
/// sound, good ones quick.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NearParts {
    pub(crate) parts: [u32; 2],
    pub(crate) start: Option<[[u32; 2]; 3]>,
}

impl NearParts {
    fn mirrored(self) -> Self {
        let swapped = |[a, b]: [u32; 2]| [b, a];
        Self { parts: swapped(self.parts), start: self.start.map(|start| start.map(swapped)) }
    }
}

/// The distance of two shapes that are apart, and that is that of one of these pairs of parts, measured at an accuracy.
///
/// (a, b) and (b, a) give the same bits, mirrored, for the same pairs.
pub(crate) fn distance_of_nearest(
    accuracy: Accuracy,
    [a, b]: [PosedShape<'_>; 2],
    pairs: &mut [NearParts],
) -> DistanceResult {
    let ([first, second], swapped) = in_order(a, b);
    if swapped {
        pairs.iter_mut().for_each(|pair| *pair = pair.mirrored());
    }
    pairs.sort_unstable_by_key(|pair| pair.parts);
    let mut best = Best::at(accuracy);
    best.measure_all([&first, &second], pairs.iter().copied());
    let (result, _) = best.answer();
    if swapped { result.mirrored() } else { result }
}

/// The pairs of a triangle of a mesh and a half-space of which one is the nearest, by index; `None` of other shapes.
fn lowest_parts([first, second]: [&Side<'_>; 2]) -> Option<Vec<[u32; 2]>> {
    let (mesh, Parts::One(shape)) = (first.mesh()?, second.parts) else { return None };
    let plane = PosedShape { shape, pose: second.pose };
    let triangles = closed::level::lowest_triangles((mesh, first.pose), plane)?;
    Some(triangles.into_iter().map(|triangle| [triangle, 0]).collect())
}

/// How much nearer than the nearest parts others may be that are not measured, relative to the distance: half of what is promised
/// of a certified one. The bound counts it. Larger: bounds beyond what is promised. Smaller: parts as far away as the nearest are
/// measured too, each by itself.
const ALIKE: f64 = 5e-13;

/// The best so far.
struct Best {
    accuracy: Accuracy,
    /// Whether f64 has left out all pairs that it proves to be farther than another.
    is_sifted: bool,
    nearest: Option<Distance>,
    /// At most the true distance of any pair measured.
    lower: f64,
    touching: bool,
    undecided: Option<Reason>,
    /// Of the pairs of which it is not known whether they touch: the nearest by its bound, and how deep
    /// the deepest may be.
    interval: Option<(Reason, Distance, f64)>,
    method: Option<Method>,
}

#[derive(PartialEq, Eq)]
enum Known {
    /// More may be nearer.
    Some,
    /// Nothing is nearer than touching.
    All,
}

impl Best {
    fn at(accuracy: Accuracy) -> Self {
        Self {
            accuracy,
            is_sifted: false,
            nearest: None,
            lower: 0.0,
            touching: false,
            undecided: None,
            interval: None,
            method: None,
        }
    }

    /// Measures pairs of parts until two touch.
    fn measure_all(&mut self, sides: [&Side<'_>; 2], pairs: impl IntoIterator<Item = NearParts>) {
        for pair in pairs {
            if self.measure(sides, pair) == Known::All {
                break;
            }
        }
    }

    fn measure(&mut self, [a, b]: [&Side<'_>; 2], pair: NearParts) -> Known {
        let [part_a, part_b] = pair.parts;
        let (Some(in_a), Some(in_b)) =
            (pair::to_shape(a.part(part_a)), pair::to_shape(b.part(part_b)))
        else {
            self.undecided = self.undecided.or(Some(Reason::Range));
            return Known::Some;
        };
        let (in_a, in_b) =
            (PosedShape { shape: &in_a, pose: a.pose }, PosedShape { shape: &in_b, pose: b.pose });
        if let Some(lower) = self.no_nearer(in_a, in_b) {
            self.lower = self.lower.min(lower);
            return Known::Some;
        }
        if self.is_farther(in_a, in_b) {
            return Known::Some;
        }
        let (result, method) =
            match pair.start.and_then(|start| self.searched_from(in_a, in_b, start)) {
                Some(found) => (found, Method::F64),
                None => of_convex(self.accuracy, in_a, in_b),
            };
        self.method = self.method.max(Some(method));
        match result {
            DistanceResult::Touching => {
                self.touching = true;
                return Known::All;
            }
            DistanceResult::Undecided(reason) => {
                self.undecided = self.undecided.or(Some(reason));
            }
            DistanceResult::Interval { reason, within, depth } => {
                let (reason, known, deepest) = self.interval.unwrap_or((reason, within, depth));
                let nearer = within.error_bound < known.error_bound;
                let nearest = if nearer { within } else { known };
                self.interval = Some((reason, nearest, deepest.max(depth)));
            }
            DistanceResult::Apart(found) => {
                let lower = found.distance - found.error_bound;
                match &mut self.nearest {
                    Some(nearest) => {
                        self.lower = self.lower.min(lower);
                        if found.distance < nearest.distance {
                            *nearest = found;
                        }
                    }
                    None => {
                        self.lower = lower;
                        self.nearest = Some(found);
                    }
                }
            }
        }
        Known::Some
    }

    /// The distance of two polytopes that are apart, searched from vertices of each; `None` of others.
    fn searched_from(
        &self,
        a: PosedShape<'_>,
        b: PosedShape<'_>,
        start: [[u32; 2]; 3],
    ) -> Option<DistanceResult> {
        let (in_a, in_b) = (a.shape.as_polytope()?, b.shape.as_polytope()?);
        let (a, b) = (PosedSupport::polytope(in_a, a.pose), PosedSupport::polytope(in_b, b.pose));
        Some(of_apart(self.accuracy, a, b, start))
    }

    /// At most how far two parts are apart, if their gap along the normal of the nearest so far shows that to be no less than
    /// these are, within what a certified distance may be off. Triangles round the nearest corner or edge of a mesh are as far away
    /// as each other: one is measured.
    fn no_nearer(&self, a: PosedShape<'_>, b: PosedShape<'_>) -> Option<f64> {
        let nearest = self.nearest.filter(|_| self.accuracy == Accuracy::Certified)?;
        let lower = gap_along(a, b, nearest.normal)?;
        (lower >= nearest.distance * (1.0 - ALIKE)).then_some(lower)
    }

    /// Whether f64 proves two parts farther apart than the nearest so far: not asked where f64 measures them, or has
    /// measured them.
    fn is_farther(&self, a: PosedShape<'_>, b: PosedShape<'_>) -> bool {
        let asks = self.accuracy == Accuracy::Certified && !self.is_sifted;
        let Some(nearest) = self.nearest.filter(|_| asks) else { return false };
        let is_bounded = a.shape.is_bounded() && b.shape.is_bounded();
        let apart =
            |found| matches!(found, DistanceResult::Apart(d) if d.lower() > nearest.distance);
        is_bounded && apart(in_f64(a, b))
    }

    /// Whether nothing at least so far away can be nearer.
    fn is_nearer_than(&self, lower: f32) -> bool {
        self.nearest.is_some_and(|nearest| f64::from(lower) >= nearest.distance)
    }

    fn answer(self) -> (DistanceResult, Method) {
        let method = self.method.unwrap_or(Method::F64);
        if let (false, None, Some((reason, within, depth))) =
            (self.touching, self.undecided, self.interval)
        {
            return (DistanceResult::Interval { reason, within, depth }, method);
        }
        let result = match (self.touching, self.undecided, self.nearest) {
            (true, ..) => DistanceResult::Touching,
            (_, Some(reason), _) => DistanceResult::Undecided(reason),
            (_, _, Some(nearest)) => {
                // Another pair may be nearer than the nearest by its own bound.
                let below = (nearest.distance - self.lower).next_up();
                let error_bound = nearest.error_bound.max(below).min(f64::MAX);
                DistanceResult::Apart(Distance { error_bound, ..nearest })
            }
            // There is at least one pair, and each has an answer.
            (_, None, None) => DistanceResult::Undecided(Reason::Range),
        };
        (result, method)
    }
}

struct NearestParts<'a> {
    a: &'a Side<'a>,
    b: &'a Side<'a>,
    relative: &'a RelativePose,
    scratch: &'a mut Scratch,
    best: Best,
}

impl Kernel for NearestParts<'_> {
    type Output = Best;

    #[inline(always)]
    fn run<L: Lanes>(mut self, l: L) -> Best {
        self.scratch.begin(self.b);
        self.scratch.open.clear();
        let roots = What::Blocks([self.a.root(), self.b.root()]);
        self.scratch.open.push(Open { lower: 0.0, what: roots });
        while let Some(Open { lower, what }) = self.scratch.open.pop() {
            if self.best.is_nearer_than(lower) {
                break;
            }
            match what {
                What::Blocks(blocks) => {
                    let limit = self.best.nearest.map_or(f64::INFINITY, |best| best.distance);
                    self.scratch.expand(l, self.relative, ([self.a, self.b], blocks), limit);
                }
                What::Parts(parts) => {
                    let pair = NearParts { parts, start: None };
                    if self.best.measure([self.a, self.b], pair) == Known::All {
                        break;
                    }
                }
            }
        }
        self.best
    }
}

impl Scratch {
    /// Replaces two blocks by the pairs of what is below the upper one, or below both, that are nearer than that: metres.
    #[inline(always)]
    pub(super) fn expand<L: Lanes>(
        &mut self,
        l: L,
        relative: &RelativePose,
        ([a, b], [block_a, block_b]): ([&Side<'_>; 2], [u32; 2]),
        limit: f64,
    ) {
        self.place(l, relative, b, block_b);
        let Some(tree) = a.tree() else { return };
        let boxes = &tree.blocks()[block_a as usize];
        let (below_a, below_b) = (a.below(block_a), b.below(block_b));
        let leaves = [a.is_leaf(block_a), b.is_leaf(block_b)];
        let open = &mut self.open;
        let mut push = |lower: f32, what: What| {
            if f64::from(lower) < limit {
                open.push(Open { lower, what });
            }
        };
        // Boxes are compared in axes that may be longer than the world's.
        let shrink = l.splat((1.0 / relative.stretch()) as f32 * (1.0 - 16.0 * f32::EPSILON));
        let mut nearest_of_a = Row([f32::INFINITY; WIDTH]);
        for lane_b in 0..WIDTH {
            let one = self.blocks[block_b as usize].get(lane_b);
            // Boxes of nothing are NaN here.
            if !one.is_valid() {
                continue;
            }
            let mut gaps = Row::default();
            l.store(l.mul(boxes.gaps(l, &one), shrink), &mut gaps);
            let mut nearest = f32::INFINITY;
            for lane_a in 0..WIDTH {
                let lower = gaps.0[lane_a];
                let what = [below_a.0[lane_a], below_b.0[lane_b]];
                match leaves {
                    // To nothing it is infinitely far.
                    _ if !(lower < f32::INFINITY) => {}
                    [true, true] => push(lower, What::Parts(what)),
                    [false, false] => push(lower, What::Blocks(what)),
                    [true, false] => nearest = nearest.min(lower),
                    [false, true] => {
                        nearest_of_a.0[lane_a] = nearest_of_a.0[lane_a].min(lower);
                    }
                }
            }
            if nearest < f32::INFINITY {
                push(nearest, What::Blocks([block_a, below_b.0[lane_b]]));
            }
        }
        for lane in 0..WIDTH {
            if nearest_of_a.0[lane] < f32::INFINITY {
                push(nearest_of_a.0[lane], What::Blocks([below_a.0[lane], block_b]));
            }
        }
    }
}
