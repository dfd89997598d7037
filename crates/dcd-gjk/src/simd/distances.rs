//! How far apart pairs are: the nearest vertices sixteen pairs at a time in f32, and what the accuracy makes of them.

mod by_parts;
mod of_points;
mod of_rims;
mod sorted;

use super::certificate::GapBounds;
use super::closed::nearest_features as of_cuboids;
use super::form::Purpose;
use super::frame::{FramePair, SimdFrame};
use super::nearest_points::{Found, NearestPoints};
use super::scene_pairs::ScenePairs;
use super::spheres::{self, MeasureSpheres, Near, NearPair};
use super::{ErrorBounds, Part, Scratch as Yes, Slice, prepare};
use crate::closed::{self, PlacedSphere, distance_of_spheres, distance_within, spheres_are_beyond};
use crate::distance::{DistanceResult, distance_below, of_apart};
use crate::mesh::{Limited, NearParts};
use crate::query::{
    DistanceContacts, FEWEST_MEASURED, check_margin, distance_at_once, distance_of_mesh_within,
    grown, spheres_are_apart, within_margin,
};
use crate::{
    Accuracy, Contact, ContactList, ContactSink, Distance, Method, NarrowPhase, PosedShape,
    PosedSupport, Prepared, Report, Sides, Verdict, certified, mesh,
};
use dcd_geom::{Aabb, Pair, Scene, Shape, ShapeError};
use dcd_simd::Path;
use of_points::distance_of;
use sorted::{Kind, Searched, Sorted};
use std::ops::Range;
use std::slice;

/// How far apart the pairs within a margin are: [`Distances`](crate::Distances) at any accuracy, in packets of sixteen.
///
/// Contact is proved as in [`Overlap`](crate::Overlap). For the other pairs the lanes find the nearest
/// vertices, of cuboids the nearest faces, edges or corners. At [`Accuracy::F32`] spheres and capsules, with each other and
/// with cuboids, are evaluated once in f64, with its bound. Of others the distance is that of the points there, of vertices
/// in f32 unless the shapes are close, and the bound is what the lanes prove from below: some millionths of the pair's
/// size. At the other accuracies the search goes on from them in f64 or longer numbers, with the bounds of these. Beside a
/// cylinder or cone it goes on in f64 at any accuracy, from the nearest vertices of a hull inside that one. Compounds
/// are as far apart as their nearest parts, which the lanes look for. Shapes without a lane kernel, sizes outside f32's range,
/// and pairs whose bound is too wide are measured one pair at a time.
///
/// Whether a pair with a distance within its bound of the margin is reported is decided exactly, of radii that are each grown by
/// half of the margin and rounded to f64. The same bits on every path and at any number of threads, whatever the other
/// pairs; (a, b) and (b, a) are mirrored. The last bits need not be those of [`Distances`](crate::Distances), whose search
/// starts elsewhere.
///
/// ```
/// use dcd_pipeline::prelude::*;
/// let poses = [0.0, 0.9, 2.1].map(|x| Pose::from_translation(DVec3::X * x));
/// let poses = poses.into_iter().collect::<Result<Vec<_>, _>>()?;
/// let scene = Scene::one_each(vec![Shape::sphere(0.5)?; 3], poses)?;
/// let narrow = dcd_gjk::SimdDistances::within(0.25, Accuracy::F32)?;
/// let mut pipeline = Pipeline::with(WideTree::default(), narrow);
/// let near: Vec<_> = pipeline.step(&scene, Par::Serial).answers().collect();
/// assert!(near[0].answer.is_none()); // the first pair overlaps
/// let far = near[1].answer.ok_or("a distance")?;
/// assert!((far.distance - 0.2).abs() <= far.error_bound);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct SimdDistances {
    path: Path,
    accuracy: Accuracy,
    margin: f64,
}

impl SimdDistances {
    /// Of the pairs within that many metres, at that accuracy.
    ///
    /// # Errors
    /// A margin that is negative, not a number, or above [`Aabb::LIMIT`].
    pub fn within(margin: f64, accuracy: Accuracy) -> Result<Self, ShapeError> {
        Self::on(Path::best(), margin, accuracy)
    }

    /// The same on a path: see [`SimdOverlap::on`](super::SimdOverlap::on).
    ///
    /// # Errors
    /// Those of [`SimdDistances::within`].
    pub fn on(path: Path, margin: f64, accuracy: Accuracy) -> Result<Self, ShapeError> {
        check_margin(margin)?;
        Ok(Self { path, accuracy, margin })
    }

    /// Resolves a pair by itself. Shapes are grown by the margin only where the distance is within its bound of
    /// the margin.
    fn alone(&self, a: PosedShape<'_>, b: PosedShape<'_>) -> (Verdict<Option<Distance>>, Method) {
        if spheres_are_apart(a, b, self.margin) {
            return (Verdict::Apart, Method::F64);
        }
        let is_mesh = |shape: &Shape| matches!(shape, Shape::Mesh(_));
        // More than rounding beyond the margin.
        let far = self.margin * (1.0 + 1e-9) + f64::MIN_POSITIVE;
        let found = match is_mesh(a.shape) || is_mesh(b.shape) {
            true if a.shape.is_bounded() && b.shape.is_bounded() => {
                distance_of_mesh_within(self.accuracy, [a, b], far)
            }
            _ => distance_below((self.accuracy, far), a, b),
        };
        match found {
            (Limited::Known(found), method) => (within_margin(found, self.margin, a, b), method),
            (Limited::Beyond, method) => (Verdict::Apart, method),
        }
    }

    /// A pair that is apart, by what the lanes found of it.
    fn by_search(
        &self,
        found: Found,
        (objects, pair): (ScenePairs<'_>, Pair),
        [a, b]: [PosedShape<'_>; 2],
    ) -> Verdict<Option<Distance>> {
        let points = match found {
            Found::Beyond => return Verdict::Apart,
            Found::Unknown => return self.alone(a, b).0,
            Found::Nearest(points) => points,
        };
        let found = match self.accuracy {
            Accuracy::F32 => {
                let found = points.distance_in_f32(objects.frames, pair);
                found.or_else(|| distance_of(&points, a, b)).map(DistanceResult::Apart)
            }
            accuracy => going_on(accuracy, &points, a, b),
        };
        let of_rims = || of_rims::distance_of(self.accuracy, &points, (objects, pair));
        let found = found.or_else(of_rims);
        match found {
            Some(found) => within_margin(found, self.margin, a, b),
            None => self.alone(a, b).0,
        }
    }

    /// Two spheres of which that is not known in f64.
    #[inline(never)]
    fn resolve_spheres(
        &self,
        spheres: Option<[PlacedSphere; 2]>,
        [a, b]: [PosedShape<'_>; 2],
    ) -> (Verdict<Option<Distance>>, Method) {
        match certified::overlap_of(a, b) {
            (Verdict::Touching(()), method) => (Verdict::Touching(None), method),
            (Verdict::Apart, method) => (self.by_bounds_of_centres(spheres, [a, b]), method),
            (Verdict::Undecided(_), _) => self.alone(a, b),
        }
    }

    /// Two spheres that are apart, of which their centres and radii are read and nothing else. False where the bound leaves
    /// it open whether they are within the margin.
    #[inline]
    fn by_centres(
        &self,
        spheres: [PlacedSphere; 2],
        pair: Pair,
        contacts: &mut DistanceContacts,
    ) -> bool {
        if spheres_are_beyond(spheres, self.margin) {
            return true;
        }
        match distance_of_spheres(spheres, closed::sharp_of(self.accuracy)) {
            Some(DistanceResult::Apart(found)) if found.upper() <= self.margin => {
                contacts.push(Contact { pair, answer: Some(found) });
                true
            }
            _ => false,
        }
    }

    /// Two spheres that [`SimdDistances::by_centres`] leaves open.
    fn by_bounds_of_centres(
        &self,
        spheres: Option<[PlacedSphere; 2]>,
        [a, b]: [PosedShape<'_>; 2],
    ) -> Verdict<Option<Distance>> {
        let sharp = closed::sharp_of(self.accuracy);
        match spheres.and_then(|both| distance_of_spheres(both, sharp)) {
            Some(found) => within_margin(found, self.margin, a, b),
            None => self.alone(a, b).0,
        }
    }

    /// A pair that is apart, by what was found of it.
    #[inline(always)]
    fn by_found(
        &self,
        found: Measured<'_>,
        spheres: Option<[PlacedSphere; 2]>,
        (objects, pair): (ScenePairs<'_>, Pair),
    ) -> Verdict<Option<Distance>> {
        let sides = objects.posed(pair);
        match found {
            Measured::Searched(nearest) => self.by_search(nearest, (objects, pair), sides),
            Measured::Cuboids(features) => self.by_features(features, objects.frames, pair, sides),
            Measured::Parts(found, candidates) => self.by_parts(found, candidates, sides),
            Measured::Formula => self.by_formula(sides),
            Measured::Centres => self.by_bounds_of_centres(spheres, sides),
        }
    }

    /// Two cuboids that are apart, by what the lanes found of them.
    fn by_features(
        &self,
        found: of_cuboids::Found,
        frames: FramePair<'_>,
        pair: Pair,
        [a, b]: [PosedShape<'_>; 2],
    ) -> Verdict<Option<Distance>> {
        let near = match found {
            of_cuboids::Found::Beyond => return Verdict::Apart,
            of_cuboids::Found::Unknown => return self.alone(a, b).0,
            of_cuboids::Found::Near(near) => near,
        };
        let found = match self.accuracy {
            Accuracy::F32 => near.distance_in_f32(frames, pair),
            _ => None,
        };
        let found = found.or_else(|| near.distance(self.accuracy, [a, b]));
        match found {
            Some(found) if found.upper() <= self.margin => Verdict::Touching(Some(found)),
            Some(found) if found.lower() > self.margin => Verdict::Apart,
            Some(found) => within_margin(DistanceResult::Apart(found), self.margin, a, b),
            None => self.alone(a, b).0,
        }
    }

    /// Two that are apart, one of them a compound, by what the lanes found of their parts.
    fn by_parts(
        &self,
        found: &by_parts::Found,
        candidates: &[NearParts],
        [a, b]: [PosedShape<'_>; 2],
    ) -> Verdict<Option<Distance>> {
        let found = match found {
            by_parts::Found::Beyond => return Verdict::Apart,
            by_parts::Found::Near(found) => DistanceResult::Apart(*found),
            by_parts::Found::Among(range) => mesh::distance_of_nearest(
                self.accuracy,
                [a, b],
                &mut candidates[range.clone()].to_vec(),
            ),
        };
        within_margin(found, self.margin, a, b)
    }

    /// A pair that is apart of which one evaluation in f64 says how far.
    fn by_formula(&self, [a, b]: [PosedShape<'_>; 2]) -> Verdict<Option<Distance>> {
        match distance_at_once(self.accuracy, a, b) {
            Some(found) => within_margin(found, self.margin, a, b),
            None => self.alone(a, b).0,
        }
    }
}

/// The distance of two polytopes that are apart, searched on from their nearest vertices.
fn going_on(
    accuracy: Accuracy,
    points: &NearestPoints,
    a: PosedShape<'_>,
    b: PosedShape<'_>,
) -> Option<DistanceResult> {
    let (in_a, in_b) = (a.shape.as_polytope()?, b.shape.as_polytope()?);
    let corners = points.corners_of([in_a, in_b]);
    let (a, b) = (PosedSupport::polytope(in_a, a.pose), PosedSupport::polytope(in_b, b.pose));
    Some(of_apart(accuracy, a, b, corners))
}

/// What a thread reuses from slice to slice.
#[derive(Debug, Default)]
pub struct Scratch {
    yes: Yes,
    report: Report,
    sorted: Sorted,
}

/// What is measured of spheres.
struct BySpheres<'a> {
    narrow: &'a SimdDistances,
    objects: ScenePairs<'a>,
}

impl BySpheres<'_> {
    #[inline(always)]
    fn distance(&self, spheres: [PlacedSphere; 2]) -> Option<Distance> {
        let SimdDistances { accuracy, margin, .. } = *self.narrow;
        distance_within(spheres, margin, closed::sharp_of(accuracy))
    }
}

impl MeasureSpheres for BySpheres<'_> {
    type Answer = Option<Distance>;

    #[inline(always)]
    fn measure_all(&self, near: &Near<'_>, contacts: &mut DistanceContacts) -> bool {
        let distances = near.open().map_while(
            #[inline(always)]
            |spheres| self.distance(spheres?),
        );
        contacts.extend(near.pairs(), near.count_of_open(), distances)
    }

    #[inline(always)]
    fn measure(&self, near: NearPair, contacts: &mut DistanceContacts) -> bool {
        if near.touches {
            contacts.push_pair(near.pair);
            return true;
        }
        let answer = self.distance(near.spheres);
        if answer.is_some() {
            contacts.push(Contact { pair: near.pair, answer });
        }
        answer.is_some()
    }

    #[inline(never)]
    fn resolve(&mut self, pair: Pair, sink: &mut ContactSink<'_, Option<Distance>>) {
        let spheres = self.objects.frames.spheres(pair);
        let (verdict, method) = self.narrow.resolve_spheres(spheres, self.objects.posed(pair));
        sink.file(pair, method, verdict);
    }
}

impl NarrowPhase for SimdDistances {
    type Answer = Option<Distance>;
    type Frame = SimdFrame;
    type Part<'f> = Part<'f>;
    type Scratch = Scratch;

    fn aabb_margin(&self) -> Option<f64> {
        Some(self.margin / 2.0)
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
        let objects = prepare::Prepare { scene, first, part, aabbs: &mut *aabbs };
        prepare::prepare(self.path, objects);
        for aabb in aabbs {
            *aabb = grown(aabb, self.margin / 2.0);
        }
    }

    fn decide(
        &self,
        a: Prepared<'_, SimdFrame>,
        b: Prepared<'_, SimdFrame>,
        pairs: &[Pair],
        scratch: &mut Scratch,
        sink: &mut ContactSink<'_, Option<Distance>>,
    ) {
        let frames = FramePair { a: a.frame, b: b.frame };
        if frames.are_spheres() {
            let objects = ScenePairs { frames, scenes: [a.scene, b.scene], pairs };
            let measure = BySpheres { narrow: self, objects };
            return spheres::decide(self.path, (frames, pairs, self.margin), measure, sink);
        }
        let Scratch { yes, report, sorted } = &mut *scratch;
        report.clear();
        // Rounded up, so that no pair within the margin is left out.
        yes.measured.margin = (self.margin as f32).next_up();
        GapBounds::judge(&Slice { path: self.path, a, b, pairs }, yes, report);
        // What is undecided there is resolved again, by itself.
        report.sort();
        let undecided = report.take_undecided();
        sink.report.absorb(report);
        sorted.sort(self.path, frames, (yes, pairs, self.margin, self.accuracy));
        let objects = ScenePairs { frames, scenes: [a.scene, b.scene], pairs };
        sorted.by_parts.find(self.path, objects, (self.margin, self.accuracy));
        let mut found = InOrder::of(sorted, objects);
        for &number in &sorted.read {
            let (pair, kind) = (pairs[number as usize], sorted.kinds[number as usize]);
            // No table of jumps: of spheres nothing tells the next pair's kind.
            if kind == Kind::Touching {
                sink.contacts.push_pair(pair);
                continue;
            }
            let is_decided = undecided.is_empty()
                || undecided.binary_search_by_key(&pair, |undecided| undecided.pair).is_err();
            let spheres = if kind == Kind::Spheres { frames.spheres(pair) } else { None };
            if is_decided && spheres.is_some_and(|both| self.by_centres(both, pair, sink.contacts))
            {
                continue;
            }
            let found = found.next(self, kind, number);
            if !is_decided {
                let [one, other] = objects.posed(pair);
                let (verdict, method) = self.alone(one, other);
                sink.file(pair, method, verdict);
                continue;
            }
            // Counted already, as apart.
            match self.by_found(found, spheres, (objects, pair)) {
                Verdict::Apart => {}
                Verdict::Touching(answer) => sink.contacts.push(Contact { pair, answer }),
                Verdict::Undecided(reason) => sink.report.leave_unmeasured(pair, reason),
            }
        }
    }
}

/// What the lanes found of a pair, or how it is measured.
#[derive(Clone, Copy)]
enum Measured<'a> {
    Searched(Found),
    Cuboids(of_cuboids::Found),
    /// And the pairs of parts that may be the nearest.
    Parts(&'a by_parts::Found, &'a [NearParts]),
    Formula,
    Centres,
}

/// What was found of the pairs that are read, in their order.
struct InOrder<'a> {
    searched: &'a Searched,
    near: Range<usize>,
    of_cuboids: slice::Iter<'a, of_cuboids::Found>,
    by_parts: slice::Iter<'a, by_parts::Found>,
    candidates: &'a [NearParts],
    formulas: Range<usize>,
    /// The pairs that were searched, and those with a formula.
    objects: [ScenePairs<'a>; 2],
}

impl<'a> InOrder<'a> {
    fn of(sorted: &'a Sorted, objects: ScenePairs<'a>) -> Self {
        let Sorted { formulas, searched, of_cuboids, by_parts, .. } = sorted;
        Self {
            searched,
            near: 0..searched.near.len(),
            of_cuboids: of_cuboids.found.iter(),
            by_parts: by_parts.found.iter(),
            candidates: &by_parts.candidates,
            formulas: 0..formulas.len(),
            objects: [&searched.measured, formulas].map(|pairs| ScenePairs { pairs, ..objects }),
        }
    }

    /// Of the next pair, of that kind and number.
    #[inline(always)]
    fn next(&mut self, narrow: &SimdDistances, kind: Kind, number: u32) -> Measured<'a> {
        let [searched, with_formula] = self.objects;
        match kind {
            Kind::Cuboids => Measured::Cuboids(self.of_cuboids.next().copied().unwrap_or_default()),
            Kind::Searched => {
                // At that of f32 the vertices are those that have just been read.
                if let (Some(place), false) = (self.near.next(), narrow.accuracy == Accuracy::F32) {
                    searched.look_ahead(place, false);
                }
                Measured::Searched(self.searched.found[number as usize])
            }
            Kind::Formula => {
                with_formula.look_ahead_to_ends(self.formulas.next().unwrap_or_default());
                Measured::Formula
            }
            Kind::Parts => {
                let found = self.by_parts.next().unwrap_or(&by_parts::Found::Beyond);
                Measured::Parts(found, self.candidates)
            }
            Kind::Touching | Kind::Spheres | Kind::Beyond => Measured::Centres,
        }
    }
}
