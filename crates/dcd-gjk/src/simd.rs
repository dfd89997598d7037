//! The default narrow phase: sixteen pairs at a time in f32, every answer with its certificate.
//!
//! A pair passes stages, each a small kernel that resolves what it can prove and hands on the rest:
//! spheres, inner and outer OBBs, the axis between the centres, the cone, a second point, the portal. Between
//! stages it waits on a packet queue until sixteen have come together. What the lanes cannot prove is
//! resolved in f64, and what f64 cannot prove in exact arithmetic. A pair of compounds passes the stages as the pairs of its
//! parts.

pub(crate) mod axis;
mod axis_aligned;
pub(crate) mod bounds;
mod by_parts;
pub(crate) mod certificate;
mod closed;
mod compounds;
pub(crate) mod cores;
pub(crate) mod decide;
mod depths;
mod distances;
mod expand;
mod first_stages;
mod form;
pub(crate) mod frame;
mod inscribed;
mod kept_proofs;
mod kind_order;
mod nearest_points;
mod obb;
mod packet;
mod part_group;
mod portal;
mod prefetch;
pub(crate) mod prepare;
#[cfg(test)]
mod reference;
mod scene_pairs;
mod simplex;
mod spheres;
mod straight;
mod support;
mod tetrahedron;
mod touching_parts;
pub(crate) mod vector;

pub use crate::temporal::Coherent;
pub use certificate::{CertifiedBounds, UncheckedBounds};
pub use closed::patches::CuboidPatch;
pub(crate) use closed::patches::{PatchPoint, Shown, ShownKind};
pub use decide::Scratch;
pub use depths::{CoreContact, SimdDepths};
pub(crate) use depths::{NearCore, SearchAlone, depth_of_cuboids};
pub use distances::SimdDistances;
pub(crate) use form::Purpose;
pub use frame::{Part, SimdFrame};

use crate::{
    Contact, ContactList, ContactSink, NarrowPhase, PosedShape, Prepared, Sides, certified,
};
use certificate::ErrorBounds;
use dcd_geom::{Aabb, Pair, Scene};
use dcd_simd::Path;
use decide::Slice;
use frame::FramePair;
use spheres::{MeasureSpheres, Near, NearPair};
use std::marker::PhantomData;

/// Whether two objects touch, proved: the most reliable method, and the default.
pub type Overlap = SimdOverlap<CertifiedBounds>;

/// Whether two objects touch, as f32 has it: the same lanes without their certificate.
///
/// What it saves over [`Overlap`] is what a proof costs, next to nothing; what it risks is a wrong
/// answer where the gap or overlap is within rounding, some 1e-5 of the objects' size. A pair on
/// which f32 can gain no more is called touching. Such answers may differ from CPU to CPU, with the order of the two
/// objects, and with the pairs that are decided in one call; a step's are the same at any number of threads. In a scene
/// of spheres alone they are [`Overlap`]'s, which cost no more.
pub type OverlapUnchecked = SimdOverlap<UncheckedBounds>;

/// The SIMD narrow phase, with or without error bounds: [`Overlap`] or [`OverlapUnchecked`].
#[derive(Clone, Copy, Debug)]
pub struct SimdOverlap<T> {
    path: Path,
    bounds: PhantomData<T>,
}

impl<T> Default for SimdOverlap<T> {
    fn default() -> Self {
        Self::on(Path::best())
    }
}

impl<T> SimdOverlap<T> {
    /// On that path, or the portable one where this CPU does not have it. The proved answers are
    /// the same on every path; for tests and measurements.
    pub fn on(path: Path) -> Self {
        Self { path, bounds: PhantomData }
    }
}

impl<T: ErrorBounds> NarrowPhase for SimdOverlap<T> {
    type Answer = ();
    type Frame = SimdFrame;
    type Part<'f>
        = Part<'f>
    where
        T: 'f;
    type Scratch = Scratch;

    fn aabb_margin(&self) -> Option<f64> {
        Some(0.0)
    }

    fn fewest_pairs(&self, frame: &SimdFrame) -> usize {
        frame.fewest_pairs()
    }

    fn constant_answer(&self) -> Option<()> {
        Some(())
    }

    fn layout<'f>(&self, scene: &Scene, sides: Sides, frame: &'f mut SimdFrame) -> Part<'f> {
        frame.layout(scene, sides, Purpose::Decide)
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
        scratch: &mut Scratch,
        sink: &mut ContactSink<'_, ()>,
    ) {
        let frames = FramePair { a: a.frame, b: b.frame };
        if frames.are_spheres() {
            let touching = TouchingSpheres([a.scene, b.scene]);
            return spheres::decide(self.path, (frames, pairs, 0.0), touching, sink);
        }
        T::judge(&Slice { path: self.path, a, b, pairs }, scratch, sink.report);
        append_contacts(scratch.touching(), pairs, sink.contacts);
    }
}

/// Which spheres touch, in these scenes.
struct TouchingSpheres<'a>([&'a Scene; 2]);

impl MeasureSpheres for TouchingSpheres<'_> {
    type Answer = ();

    #[inline(always)]
    fn measure_all(&self, near: &Near<'_>, contacts: &mut Vec<Contact<()>>) -> bool {
        let is_known = near.count_of_open() == 0;
        if is_known {
            contacts.extend(near.pairs().map(|(pair, _)| Contact { pair, answer: () }));
        }
        is_known
    }

    #[inline(always)]
    fn measure(&self, near: NearPair, contacts: &mut Vec<Contact<()>>) -> bool {
        if near.touches {
            contacts.push_pair(near.pair);
        }
        near.touches
    }

    #[inline(never)]
    fn resolve(&mut self, pair: Pair, sink: &mut ContactSink<'_, ()>) {
        let [a, b] = self.0;
        let (verdict, method) =
            certified::overlap_of(PosedShape::of(a, pair.i), PosedShape::of(b, pair.j));
        sink.file(pair, method, verdict);
    }
}

/// Appends the touching pairs in order.
#[inline]
pub(crate) fn append_contacts(touching: &[bool], pairs: &[Pair], contacts: &mut Vec<Contact<()>>) {
    append_touching((touching, pairs), contacts, |pair| Contact { pair, answer: () });
}

/// Appends what is made of the touching pairs, in order, without a branch that half of the pairs would mispredict.
#[inline(always)]
fn append_touching<T: Clone + Default>(
    (touching, pairs): (&[bool], &[Pair]),
    list: &mut Vec<T>,
    of: impl Fn(Pair) -> T,
) {
    let mut end = list.len();
    list.resize(end + pairs.len(), T::default());
    for (&touches, &pair) in touching.iter().zip(pairs) {
        list[end] = of(pair);
        end += usize::from(touches);
    }
    list.truncate(end);
}
