//! Pairs that have a formula: spheres are answered where they are met, cuboids from the patches that the lanes found.

use super::super::axis_aligned;
use super::super::closed::patches;
use super::super::closed::{are_cuboids, depths as of_cuboids};
use super::super::scene_pairs::ScenePairs;
use super::super::spheres::{MeasureSpheres, Near, NearPair};
use super::apart::ApartCores;
use super::searched::{Searched, are_cores_apart, are_whole, may_be_searched};
use super::straight::StraightPairs;
use super::{Answers, SimdDepths};
use crate::closed;
use crate::query::MeasureDepth;
use crate::{Accuracy, Contact, ContactList, ContactSink, ContactsOf, Verdict, certified};
use dcd_geom::Pair;
use dcd_simd::{Kernel, Lanes};

/// Answers the pairs of spheres and lists the others by how they are measured; what the lanes do not search is left to the
/// solver. A kernel for the CPU's instructions alone.
pub(super) struct Sort<'a, 'b, S: MeasureDepth> {
    pub(super) objects: ScenePairs<'a>,
    pub(super) accuracy: Accuracy,
    pub(super) of_cuboids: &'a mut of_cuboids::Scratch,
    pub(super) cuboids: &'a mut Vec<u32>,
    pub(super) level: &'a mut Listed,
    pub(super) straight: &'a mut StraightPairs,
    pub(super) searched: &'a mut Searched,
    pub(super) apart: &'a mut ApartCores,
    pub(super) answers: &'a mut Answers<'b, S>,
}

impl<S: MeasureDepth> Kernel for Sort<'_, '_, S> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, _: L) {
        let Self {
            objects,
            accuracy,
            of_cuboids,
            cuboids,
            level,
            straight,
            searched,
            apart,
            answers,
        } = self;
        let ScenePairs { frames, pairs, .. } = objects;
        let sharp = closed::sharp_of(accuracy);
        cuboids.clear();
        of_cuboids.pairs.clear();
        searched.begin();
        let apart = apart.begin();
        // The closed form of boxes along the axes has their patch. At f32's accuracy the lanes find it in less time.
        let is_upright_known = S::READS_PATCHES && accuracy != Accuracy::F32;
        let are_patches_read = S::READS_PATCHES && accuracy == Accuracy::F32;
        level.clear();
        for (number, &pair) in (0..).zip(pairs) {
            if let Some(spheres) = frames.spheres(pair) {
                match closed::depth_of_spheres(spheres, sharp) {
                    Some(depth) => {
                        answers.write_spheres(number, &depth, closed::off_surface(spheres));
                    }
                    None => answers.to.left.push(number),
                }
            } else if is_upright_known && axis_aligned::are_upright(frames, pair) {
                answers.to.left.push(number);
            } else if are_patches_read && patches::level::are_level(frames, pair) {
                level.push(number, pair);
            } else if are_cuboids(frames, pair) {
                cuboids.push(number);
                of_cuboids.pairs.push(pair);
            } else if !may_be_searched(frames, pair, accuracy) {
                if !(accuracy == Accuracy::F32 && straight.push(frames, (number, pair))) {
                    answers.to.left.push(number);
                }
            } else if are_cores_apart(frames, pair) {
                // Of a hull inside the core the lanes know no distance.
                let apart =
                    if are_whole(frames, pair) { &mut *apart } else { &mut *answers.to.left };
                apart.push(number);
            } else {
                searched.push(frames, (number, pair));
            }
        }
    }
}

/// What is made of scenes of spheres.
pub(super) struct BySpheres<'a, S: MeasureDepth> {
    pub(super) narrow: &'a SimdDepths<S>,
    pub(super) objects: ScenePairs<'a>,
    pub(super) scratch: &'a mut S::Scratch,
}

impl<S: MeasureDepth> MeasureSpheres for BySpheres<'_, S> {
    type Answer = S::Answer;

    /// One by one: each has an answer of its own.
    #[inline(always)]
    fn measure_all(&self, _: &Near<'_>, _: &mut ContactsOf<S::Answer>) -> bool {
        false
    }

    #[inline(always)]
    fn measure(&self, near: NearPair, contacts: &mut ContactsOf<S::Answer>) -> bool {
        let SimdDepths { accuracy, solver, .. } = self.narrow;
        let NearPair { pair, spheres, .. } = near;
        let Some(depth) = closed::depth_of_spheres(spheres, closed::sharp_of(*accuracy)) else {
            return false;
        };
        solver.push_spheres(pair, (&depth, closed::off_surface(spheres)), contacts);
        true
    }

    #[inline(never)]
    fn resolve(&mut self, pair: Pair, sink: &mut ContactSink<'_, S::Answer>) {
        let [a, b] = self.objects.posed(pair);
        let (verdict, method) = certified::overlap_of(a, b);
        match verdict {
            Verdict::Touching(()) => {}
            Verdict::Apart => return sink.report.count(method, 1),
            Verdict::Undecided(reason) => return sink.report.leave(pair, reason),
        }
        sink.report.count(method, 1);
        let SimdDepths { accuracy, solver, .. } = self.narrow;
        match solver.measure_at(*accuracy, a, b, self.scratch) {
            Verdict::Touching(answer) => sink.contacts.push(Contact { pair, answer }),
            Verdict::Apart => {}
            Verdict::Undecided(reason) => sink.report.leave_unmeasured(pair, reason),
        }
    }
}

/// Answers the pairs of cuboids whose patches the lanes know, and keeps the others in the lists: the pairs, and their numbers.
pub(super) struct WritePatches<'a, 'b, S: MeasureDepth> {
    pub(super) objects: ScenePairs<'a>,
    pub(super) patches: &'a patches::Scratch,
    pub(super) pairs: &'a mut Vec<Pair>,
    pub(super) numbers: &'a mut Vec<u32>,
    pub(super) answers: &'a mut Answers<'b, S>,
}

impl<S: MeasureDepth> Kernel for WritePatches<'_, '_, S> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, _: L) {
        let Self { objects, patches, pairs, numbers, answers } = self;
        let mut kept = 0;
        for place in 0..pairs.len().min(numbers.len()) {
            ScenePairs { pairs, ..objects }.look_ahead_to_poses(place);
            let (pair, number) = (pairs[place], numbers[place]);
            let patch = patches.of(place);
            if !patch.is_known() || !answers.write_patch(number, patch, objects.posed(pair)) {
                (pairs[kept], numbers[kept]) = (pair, number);
                kept += 1;
            }
        }
        pairs.truncate(kept);
        numbers.truncate(kept);
    }
}

/// Some of the pairs that touch, and their numbers among these.
#[derive(Debug, Default)]
pub(super) struct Listed {
    pub(super) numbers: Vec<u32>,
    pub(super) pairs: Vec<Pair>,
}

impl Listed {
    pub(super) fn clear(&mut self) {
        self.numbers.clear();
        self.pairs.clear();
    }

    #[inline(always)]
    pub(super) fn push(&mut self, number: u32, pair: Pair) {
        self.numbers.push(number);
        self.pairs.push(pair);
    }
}
