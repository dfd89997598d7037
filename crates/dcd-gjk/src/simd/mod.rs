//! The default narrow phase: sixteen pairs at a time in f32, every answer with its certificate.
//!
//! A pair passes stages, each a small kernel that settles what it can prove and hands on the rest:
//! balls, twin boxes, the axis between the centres, the cone, a second point, the portal. Between
//! stages it waits on a belt until sixteen have come together. What the lanes cannot prove is
//! settled in f64, and what f64 cannot, exactly. A pair of compounds passes them as the pairs of its
//! parts.

mod ahead;
pub(crate) mod axis;
pub(crate) mod bounds;
mod boxes;
mod by_parts;
pub(crate) mod certificate;
mod compounds;
pub(crate) mod decide;
mod expand;
pub(crate) mod frame;
mod kept;
mod lot;
mod nearest;
mod opening;
mod portal;
pub(crate) mod prepare;
mod support;
mod tetrahedron;
#[cfg(test)]
mod twins;
mod upright;
pub(crate) mod vector;

pub use crate::temporal::Coherent;
pub use certificate::{Proved, Trusted};
pub use decide::Scratch;
pub use frame::{Frame, Part};

use crate::{Contact, Findings, NarrowPhase};
use certificate::Trust;
use dcd_geom::lanes::Path;
use dcd_geom::{Aabb, Pair, Scene};
use decide::Slice;
use std::marker::PhantomData;

/// Whether two objects touch, proved: the most reliable rung, and the default.
pub type Overlap = InLanes<Proved>;

/// Whether two objects touch, as f32 has it: the same lanes without their certificate.
///
/// What it saves over [`Overlap`] is what a proof costs, next to nothing; what it risks is a wrong
/// answer where the gap or overlap is within rounding, some 1e-5 of the objects' size. A pair on
/// which f32 can gain no more is called touching. Answers may differ from CPU to CPU.
pub type OverlapUnproved = InLanes<Trusted>;

/// The lanes, by what their answers are worth: [`Overlap`] or [`OverlapUnproved`].
#[derive(Clone, Copy, Debug)]
pub struct InLanes<T> {
    path: Path,
    trust: PhantomData<T>,
}

impl<T> Default for InLanes<T> {
    fn default() -> Self {
        Self::on(Path::best())
    }
}

impl<T> InLanes<T> {
    /// On that path, or the portable one where this CPU does not have it. The proved answers are
    /// the same on every path; for tests and measurements.
    pub fn on(path: Path) -> Self {
        Self { path, trust: PhantomData }
    }
}

impl<T: Trust> NarrowPhase for InLanes<T> {
    type Answer = ();
    type Frame = Frame;
    type Part<'f>
        = Part<'f>
    where
        T: 'f;
    type Scratch = Scratch;

    fn growth(&self) -> Option<f64> {
        Some(0.0)
    }

    fn sole_answer(&self) -> Option<()> {
        Some(())
    }

    fn lay_out<'f>(&self, scene: &Scene, frame: &'f mut Frame) -> Part<'f> {
        frame.lay_out(scene)
    }

    fn keeps(&self, part: &Part<'_>) -> bool {
        part.kept
    }

    fn prepare(&self, scene: &Scene, first: usize, part: Part<'_>, aabbs: &mut [Aabb]) {
        prepare::prepare(self.path, prepare::Prepare { scene, first, part, aabbs });
    }

    fn decide(
        &self,
        scene: &Scene,
        frame: &Frame,
        pairs: &[Pair],
        scratch: &mut Scratch,
        findings: &mut Findings<'_, ()>,
    ) {
        T::judge(&Slice { path: self.path, scene, frame, pairs }, scratch, findings.report);
        append_contacts(scratch.touching(), pairs, findings.contacts);
    }
}

/// Appends the touching pairs in order, without a branch that half of the pairs would mispredict.
pub(crate) fn append_contacts(touching: &[bool], pairs: &[Pair], contacts: &mut Vec<Contact<()>>) {
    let mut end = contacts.len();
    contacts.resize(end + pairs.len(), Contact::default());
    for (&touches, &pair) in touching.iter().zip(pairs) {
        contacts[end].pair = pair;
        end += usize::from(touches);
    }
    contacts.truncate(end);
}
