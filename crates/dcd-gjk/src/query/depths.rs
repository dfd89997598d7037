//! How deep touching pairs overlap.

use super::few_parts::{self, PartContact, Wanted};
use super::{Accuracy, FoundDepth, FoundPair, MeasureAt, MeasureDepth, open_triangles, sampled};
use crate::closed::{self, half_space};
use crate::epa::{self, Depth};
use crate::mesh::{Effort, KnownParts, OfTriangle, PartPair};
use crate::simd::CoreContact;
use crate::{
    Contact, Method, PairSolver, PosedShape, PosedSupport, Reason, Verdict, certified, expanding,
    mesh, order,
};
use dcd_geom::{Kind, Pair, Shape};
use dcd_simd::Path;

/// How deep a pair overlaps, where, and with what bound: see [`Depth`].
///
/// A touching pair always has its depth, exact touching included (0). Between polytopes, rounded
/// or not, the bound is at most 1e-9 of the depth but for 1e-22 of the pair's size, of rounded ones 1e-16, and 1e-13 where these are
/// flat and nearly parallel; nothing is undecided; nor against a half-space, out of which the shortest way is along its normal (two of
/// them have no depth: [`Reason::Range`]). With another shape the depth is that of polytopes inside
/// the shapes, which grow where it is decided, bounded from above by the shapes' own supports; a
/// pair is undecided where [`certified::overlap_of`] is.
///
/// Of compounds and meshes it is the depth of the deepest pair of parts, which is less than what
/// separates the whole.
///
/// Some three microseconds for hulls of tens of vertices, some more where f64 does not know nine digits, ten to twenty
/// where double-double does not either; of spheres, capsules and cuboids, nearly always by formula, less than one; some
/// ten for cylinders and cones, some hundred for foreign shapes.
///
/// ```
/// use dcd_geom::glam::DVec3;
/// use dcd_geom::{Pose, Shape};
/// use dcd_gjk::{Depths, PairSolver, PosedShape, Verdict};
/// let (cube, ball) = (Shape::cuboid(DVec3::ONE)?, Shape::sphere(0.5)?);
/// let pose = Pose::from_translation(DVec3::X * 1.4)?;
/// let (a, b) = (PosedShape { shape: &cube, pose: &Pose::IDENTITY }, PosedShape { shape: &ball, pose: &pose });
/// let Verdict::Touching(found) = Depths.solve(a, b, &mut Default::default()) else {
///     panic!("0.1 m deep");
/// };
/// assert!((found.depth - 0.1).abs() <= found.error_bound);
/// assert!(found.normal.distance(DVec3::X) < 1e-12); // from a to b
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct Depths;

impl PairSolver for Depths {
    type Answer = Depth;
    type Scratch = epa::Scratch;

    fn method(&self) -> Method {
        Method::Exact
    }

    fn solve(
        &self,
        a: PosedShape<'_>,
        b: PosedShape<'_>,
        scratch: &mut epa::Scratch,
    ) -> Verdict<Depth> {
        self.resolve(a, b, scratch).0
    }

    fn measure(
        &self,
        a: PosedShape<'_>,
        b: PosedShape<'_>,
        scratch: &mut epa::Scratch,
    ) -> Verdict<Depth> {
        of_touching(Accuracy::Certified, a, b, scratch)
    }

    fn resolve(
        &self,
        a: PosedShape<'_>,
        b: PosedShape<'_>,
        scratch: &mut epa::Scratch,
    ) -> (Verdict<Depth>, Method) {
        // A depth that is certified is more than its bound: the two touch.
        let upright = upright(a, b).filter(|found| found.depth > found.error_bound);
        if let Some(found) = upright.or_else(|| by_formula(Accuracy::Certified, a, b)) {
            return (Verdict::Touching(found), Method::F64);
        }
        let (verdict, method) = certified::overlap_of(a, b);
        let verdict = match verdict {
            Verdict::Touching(()) => of_touching(Accuracy::Certified, a, b, scratch),
            Verdict::Apart => Verdict::Apart,
            Verdict::Undecided(reason) => Verdict::Undecided(reason),
        };
        (verdict, method)
    }
}

impl MeasureAt for Depths {
    fn measure_at(
        &self,
        accuracy: Accuracy,
        a: PosedShape<'_>,
        b: PosedShape<'_>,
        scratch: &mut epa::Scratch,
    ) -> Verdict<Depth> {
        of_touching(accuracy, a, b, scratch)
    }
}

impl MeasureDepth for Depths {
    fn measure_depth(
        &self,
        depth: Depth,
        _: PosedShape<'_>,
        _: PosedShape<'_>,
        _: &mut epa::Scratch,
    ) -> Verdict<Depth> {
        Verdict::Touching(depth)
    }

    #[inline]
    fn measure_spheres(&self, depth: &Depth, _: f64, answer: &mut Depth) {
        *answer = *depth;
    }

    #[inline(always)]
    fn push_spheres(
        &self,
        pair: Pair,
        (depth, _): (&Depth, f64),
        contacts: &mut Vec<Contact<Depth>>,
    ) {
        contacts.push(Contact { pair, answer: *depth });
    }

    fn measure_polytopes(
        &self,
        _: Path,
        pairs: &[FoundPair<'_>],
        _: &mut epa::Scratch,
        contacts: &mut Vec<Contact<Depth>>,
    ) -> u32 {
        for pair in pairs {
            contacts[pair.number].answer = pair.found.depth;
        }
        0
    }

    #[inline(always)]
    fn measure_cores(
        &self,
        contact: &CoreContact<'_>,
        (contacts, number): (&mut Vec<Contact<Depth>>, usize),
    ) -> bool {
        contacts[number].answer = contact.depth;
        true
    }

    fn measure_alone(
        &self,
        accuracy: Accuracy,
        [a, b]: [PosedShape<'_>; 2],
        scratch: &mut epa::Scratch,
        (contacts, number): (&mut Vec<Contact<Depth>>, usize),
    ) -> Verdict<()> {
        let found = match by_frame(accuracy, a, b) {
            Some(found) => Verdict::Touching(found),
            None => {
                without_frame((accuracy, Searched::InLanes), a, b, scratch).map(|found| found.depth)
            }
        };
        found.map(|found| contacts[number].answer = found)
    }

    fn measure_parts(
        &self,
        accuracy: Accuracy,
        known: KnownParts<'_>,
        [a, b]: [PosedShape<'_>; 2],
        scratch: &mut epa::Scratch,
        answer: &mut Depth,
    ) -> Verdict<()> {
        // But at f32 the depth is that without the parts; its bound may be nearer.
        let found = match accuracy {
            Accuracy::F32 => mesh::depth_in_sphere([a, b], known.parts),
            _ => by_frame(accuracy, a, b),
        };
        if let Some(found) =
            found.or_else(|| open_triangles::depth(accuracy, [a, b], known, scratch))
        {
            *answer = found;
            return Verdict::Touching(());
        }
        let pairs = mesh::pairs_of([a, b], known.parts);
        of_deepest(accuracy, &pairs, [a, b], scratch).map(|found| *answer = found)
    }

    fn measure_compounds(
        &self,
        accuracy: Accuracy,
        known: &mut [PartContact<'_>],
        sides: [PosedShape<'_>; 2],
        scratch: &mut epa::Scratch,
        answer: &mut Depth,
    ) -> Verdict<()> {
        if let Some(found) = few_parts::depth_of_known(accuracy, known, sides, scratch) {
            *answer = found;
            return Verdict::Touching(());
        }
        let [a, b] = sides;
        self.measure_at(accuracy, a, b, scratch).map(|found| *answer = found)
    }

    const READS_BOUNDS: bool = true;
}

/// The bound that is promised of a depth, relative to it.
pub(crate) const CERTIFIED: f64 = 1e-9;

/// The depth of two shapes that are known to touch.
pub(super) fn of_touching(
    accuracy: Accuracy,
    a: PosedShape<'_>,
    b: PosedShape<'_>,
    scratch: &mut epa::Scratch,
) -> Verdict<Depth> {
    match by_frame(accuracy, a, b) {
        Some(found) => Verdict::Touching(found),
        None => without_frame((accuracy, Searched::Not), a, b, scratch).map(|found| found.depth),
    }
}

/// What was done for a pair before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Searched {
    Not,
    /// The lanes found no depth, or refused the pair.
    InLanes,
}

/// The same of two shapes of which [`by_frame`] has none.
pub(super) fn without_frame(
    (accuracy, searched): (Accuracy, Searched),
    a: PosedShape<'_>,
    b: PosedShape<'_>,
    scratch: &mut epa::Scratch,
) -> Verdict<FoundDepth> {
    if mesh::have_parts(a.shape, b.shape) {
        let is_f32 = accuracy == Accuracy::F32;
        let of_few = match accuracy {
            Accuracy::Certified => None,
            _ => few_parts::depth(accuracy, [a, b], scratch),
        };
        let of_triangles = || open_triangles::depth_of_parts([a, b], scratch);
        if let Some(found) = of_few.or_else(|| is_f32.then(of_triangles).flatten()) {
            return Verdict::Touching(found.into());
        }
        let pairs = match may_be_deepest(accuracy, [a, b], scratch) {
            Some(parts) => mesh::pairs_of([a, b], &parts),
            None => mesh::touching_parts(a, b, &mut mesh::Scratch::default()),
        };
        return of_deepest(accuracy, &pairs, [a, b], scratch).map(FoundDepth::from);
    }
    if let Some(verdict) = half_space::depth_within(a, b, closed::sharp_of(accuracy)) {
        return verdict.map(FoundDepth::from);
    }
    if let Some(found) = upright(a, b).or_else(|| by_formula(accuracy, a, b)) {
        return Verdict::Touching(found.into());
    }
    // Of curved shapes at f32 alone; a certified bound is to be as near as a search has it.
    let are_polytopes = a.shape.as_polytope().is_some() && b.shape.as_polytope().is_some();
    if (accuracy == Accuracy::F32 || accuracy == Accuracy::F64 && are_polytopes)
        && let Some(OfTriangle::Deep(found)) = mesh::of_triangle(a, b, tolerance(accuracy))
    {
        return Verdict::Touching(found.into());
    }
    let (lanes, surface) = scratch.searches();
    let in_lanes = |sides: [PosedShape<'_>; 2]| match searched {
        Searched::Not => lanes.depth(accuracy, sides),
        Searched::InLanes => None,
    };
    let grown = expanding::depth_of_overlap(a, b, accuracy, surface, in_lanes);
    // What the searches below promise.
    let is_good = |FoundDepth { depth, .. }: &FoundDepth| {
        accuracy != Accuracy::Certified || depth.error_bound <= CERTIFIED * depth.depth
    };
    if let Some(found) = grown.filter(is_good) {
        return Verdict::Touching(found);
    }
    match (a.shape, b.shape) {
        (Shape::Polytope(in_a), Shape::Polytope(in_b)) => {
            let (a, b) =
                (PosedSupport::polytope(in_a, a.pose), PosedSupport::polytope(in_b, b.pose));
            Verdict::Touching(epa::depth_of_overlap(a, b, scratch).into())
        }
        // Two half-spaces: hardly ever to be parted at all.
        _ if !(a.shape.reach().is_finite() && b.shape.reach().is_finite()) => {
            Verdict::Undecided(Reason::Range)
        }
        _ => {
            let sampled = sampled::depth_of_overlap(a, b, scratch);
            let is_narrower = |grown: &FoundDepth| grown.depth.error_bound <= sampled.error_bound;
            Verdict::Touching(grown.filter(is_narrower).unwrap_or(sampled.into()))
        }
    }
}

/// The depth of two spheres; and where a certified one is not asked for, of a sphere or half-space and another, seen in the
/// frame of one of them, and of a capsule and a capsule or cuboid.
#[inline]
pub(super) fn by_frame(accuracy: Accuracy, a: PosedShape<'_>, b: PosedShape<'_>) -> Option<Depth> {
    let of_spheres = closed::depth_of_two_spheres(a, b, closed::sharp_of(accuracy));
    of_spheres.or_else(|| closed::gap(accuracy, a, b)?.depth())
}

/// The pairs of parts of which one is the deepest, as f64 knows it, so that the others need not be measured.
fn may_be_deepest(
    accuracy: Accuracy,
    [a, b]: [PosedShape<'_>; 2],
    scratch: &mut epa::Scratch,
) -> Option<Vec<[u32; 2]>> {
    // Else the parts of few were looked at before, in vain.
    if accuracy == Accuracy::Certified
        && let Some(found) = few_parts::touching(Wanted::Deepest, [a, b], scratch)
    {
        return Some(found.into_iter().map(|(parts, _)| parts).collect());
    }
    mesh::may_be_deepest(a, b)
}

/// The depth of the deepest of these parts of two shapes.
fn of_deepest(
    accuracy: Accuracy,
    pairs: &[PartPair<'_>],
    sides: [PosedShape<'_>; 2],
    scratch: &mut epa::Scratch,
) -> Verdict<Depth> {
    let found = mesh::deepest(pairs, |pair, effort| {
        pair.depth_by(effort, || of_parts(accuracy, effort, pair, sides, scratch))
    });
    match found {
        Ok((_, depth)) => Verdict::Touching(depth),
        Err(reason) => Verdict::Undecided(reason),
    }
}

/// The depth of two parts that are known to touch; `None` where that effort does not find it.
pub(super) fn of_parts(
    accuracy: Accuracy,
    effort: Effort,
    pair: &PartPair<'_>,
    sides: [PosedShape<'_>; 2],
    scratch: &mut epa::Scratch,
) -> Option<Verdict<Depth>> {
    let found = pair.by_formula(tolerance(accuracy)).map(Verdict::Touching);
    match effort {
        Effort::Formula => found,
        Effort::Whole => found.or_else(|| {
            Some(pair.measured_by(sides, |[a, b]| of_touching(accuracy, a, b, scratch)))
        }),
    }
}

/// The bounds that are good enough: relative to the depth, and to the pair's size.
pub(crate) fn tolerance(accuracy: Accuracy) -> [f64; 2] {
    match accuracy {
        Accuracy::F32 => [0.0, 1e-6],
        Accuracy::F64 => [1e-10, 128.0 * f64::EPSILON],
        Accuracy::Certified => [CERTIFIED, 0.0],
    }
}

/// The depth of spheres, capsules and boxes, and of spheres and capsules against others whose cores they do not
/// overlap, where its bound is as good as required.
/// (a, b) and (b, a) give the same bits, mirrored.
pub(super) fn by_formula(
    accuracy: Accuracy,
    a: PosedShape<'_>,
    b: PosedShape<'_>,
) -> Option<Depth> {
    let (in_a, in_b) = (a.shape.as_polytope()?, b.shape.as_polytope()?);
    let (a, b) = (PosedSupport::polytope(in_a, a.pose), PosedSupport::polytope(in_b, b.pose));
    let in_order = |a, b| match in_a.kind() {
        Kind::Cuboid { .. } if matches!(in_b.kind(), Kind::Cuboid { .. }) => {
            closed::cuboid_depth(a, b, accuracy)
        }
        _ => closed::depth(a, b, sharp_of(accuracy, [in_a.kind(), in_b.kind()]))
            .or_else(|| closed::cuboid_depth(a, b, accuracy)),
    };
    if order::are_swapped(a, b) { in_order(b, a).map(Depth::mirrored) } else { in_order(a, b) }
}

/// The depth of two cuboids along the world's axes that are known to touch.
/// (a, b) and (b, a) give the same bits, mirrored.
pub(super) fn upright(a: PosedShape<'_>, b: PosedShape<'_>) -> Option<Depth> {
    let (in_a, in_b) = (a.shape.as_polytope()?, b.shape.as_polytope()?);
    let (a, b) = (PosedSupport::polytope(in_a, a.pose), PosedSupport::polytope(in_b, b.pose));
    match order::are_swapped(a, b) {
        true => closed::upright_depth(b, a).map(Depth::mirrored),
        false => closed::upright_depth(a, b),
    }
}

/// The bound, relative to the depth, that a formula may leave. A triangle is mostly one of a mesh, whose reach is many
/// times the triangle's size: what is promised suffices, for the search that does better takes ten times as long.
fn sharp_of(accuracy: Accuracy, kinds: [Kind; 2]) -> f64 {
    match accuracy {
        Accuracy::Certified if kinds.contains(&Kind::Triangle) => CERTIFIED,
        accuracy => closed::sharp_of(accuracy),
    }
}
