//! The later stages of pairs whose distance is to be measured: one search finds that they touch, that they are beyond the margin,
//! or where they are nearest (docs/numerics/proofs.md, "Distances in lanes").

use super::super::certificate::{ErrorBounds, KeptProof};
use super::super::first_stages::{self, Place, Resolved};
use super::super::nearest_points::{Found, Step, begin, beyond_by, put_nearest};
use super::super::packet::{Number, Vector};
use super::{Decide, Scratch, Stage, count, used};
use crate::Method;
use dcd_simd::{Kernel, Lanes};

/// What is found of the pairs of a slice beside whether they touch, where their distance is to be measured.
#[derive(Clone, Debug, Default)]
pub(in super::super) struct Measured {
    /// What is farther apart is not measured, metres.
    pub(in super::super) margin: f32,
    /// For each pair its nearest points; of what touches or is beyond the margin nothing.
    pub(in super::super) found: Vec<Found>,
}

impl Measured {
    /// Before that many pairs are judged.
    pub(super) fn begin(&mut self, pairs: usize) {
        self.found.clear();
        self.found.resize(pairs, Found::Unknown);
    }
}

/// A stage of the search, in which no product and sum are fused: all paths find the same points.
struct Searches<'a, 'b, T>(&'a mut Decide<'b, T>, Stage);

impl<T: ErrorBounds> Kernel for Searches<'_, '_, T> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        match self.1 {
            Stage::CentreAxis => self.0.first_point(l),
            _ => self.0.search(l),
        }
    }
}

impl<T: ErrorBounds> Decide<'_, T> {
    /// A stage of the search, where there is one.
    #[inline(always)]
    pub(super) fn measure<L: Lanes>(&mut self, l: L, stage: Stage) {
        if T::KEEPS == KeptProof::Gap {
            l.run_unfused(Searches(self, stage));
        }
    }

    /// The axis between the centres, and the cone.
    #[inline(always)]
    fn first_point<L: Lanes>(&mut self, l: L) {
        let Scratch { support_scratch, packet, axis, measured, .. } = &mut *self.scratch;
        let taken = axis.take(l, packet);
        let mut at = Place { frames: self.frames, support_scratch };
        let direction = packet.vector(l, Vector::C).neg(l);
        let apart = Resolved::apart(l, begin(l, &mut at, (packet, taken), direction));
        let cone = Resolved::touching(l, first_stages::cone::<L, T>(l, packet)).but(apart);
        let beyond = Resolved { apart: beyond_by(l, apart, measured.margin), ..apart };
        let done = self.resolve(l, Method::CentreAxis, beyond, used(taken))
            | self.resolve(l, Method::Cone, cone, used(taken));
        self.scratch.search.push(l, &self.scratch.packet, used(taken) & !done);
    }

    /// One support towards the origin. Where there is no nearer point and none proved the pair apart, the cores overlap, as a
    /// portal may prove.
    #[inline(always)]
    fn search<L: Lanes>(&mut self, l: L) {
        let Scratch { support_scratch, packet, search, measured, .. } = &mut *self.scratch;
        let taken = search.take(l, packet);
        let mut at = Place { frames: self.frames, support_scratch };
        let step = Step::of(l, &mut at, packet, taken);
        let apart = step.apart(l);
        let touching = Resolved::touching(l, step.touching(l, packet)).but(apart);
        let beyond = beyond_by(l, apart, measured.margin);
        let resolved = Resolved { apart: beyond, clearance: apart.clearance, ..touching };
        let ended = step.done & used(taken) & !resolved.all();
        // By any of the supports so far.
        let is_apart = l.lt(packet.number(l, Number::Radius), packet.number(l, Number::Lower));
        let near = ended & l.bits(is_apart);
        put_nearest(&mut measured.found, packet, near);
        self.report.count(Method::Portal, count(near));
        step.keep(l, packet);
        let done = self.resolve(l, Method::Portal, resolved, used(taken));
        let Scratch { packet, search, second, .. } = &mut *self.scratch;
        second.push(l, packet, ended & !near);
        search.push(l, packet, used(taken) & !(done | ended));
    }
}
