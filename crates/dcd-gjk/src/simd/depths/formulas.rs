//! Pairs that have a formula: spheres are answered where they are met, cuboids from the patches that the lanes found.

use super::super::closed::patches;
use super::super::closed::{are_cuboids, depths as of_cuboids};
use super::super::scene_pairs::ScenePairs;
use super::Answers;
use crate::query::MeasureDepth;
use crate::{Accuracy, closed};
use dcd_simd::{Kernel, Lanes};

/// Answers the pairs of spheres and lists the others by how they are measured. A kernel for the CPU's instructions alone.
pub(super) struct Sort<'a, 'b, S: MeasureDepth> {
    pub(super) objects: ScenePairs<'a>,
    pub(super) accuracy: Accuracy,
    pub(super) of_cuboids: &'a mut of_cuboids::Scratch,
    pub(super) cuboids: &'a mut Vec<u32>,
    pub(super) searched: &'a mut Vec<u32>,
    pub(super) answers: &'a mut Answers<'b, S>,
}

impl<S: MeasureDepth> Kernel for Sort<'_, '_, S> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, _: L) {
        let Self { objects, accuracy, of_cuboids, cuboids, searched, answers } = self;
        let ScenePairs { frames, pairs, .. } = objects;
        let sharp = closed::sharp_of(accuracy);
        let Answers { solver, answers, left, .. } = answers;
        cuboids.clear();
        of_cuboids.pairs.clear();
        searched.clear();
        for ((number, &pair), contact) in (0..).zip(pairs).zip(answers.iter_mut()) {
            if let Some(spheres) = frames.spheres(pair) {
                match closed::depth_of_spheres(spheres, sharp) {
                    Some(depth) => solver.measure_spheres(&depth, &mut contact.answer),
                    None => left.push(number),
                }
            } else if are_cuboids(frames, pair) {
                cuboids.push(number);
                of_cuboids.pairs.push(pair);
            } else {
                searched.push(number);
            }
        }
    }
}

/// Answers the pairs of cuboids whose patches the lanes know, and keeps the others in the lists.
pub(super) struct WritePatches<'a, 'b, S: MeasureDepth> {
    pub(super) objects: ScenePairs<'a>,
    pub(super) patches: &'a patches::Scratch,
    pub(super) of_cuboids: &'a mut of_cuboids::Scratch,
    pub(super) cuboids: &'a mut Vec<u32>,
    pub(super) answers: &'a mut Answers<'b, S>,
}

impl<S: MeasureDepth> Kernel for WritePatches<'_, '_, S> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, _: L) {
        let Self { objects, patches, of_cuboids, cuboids, answers } = self;
        let Answers { solver, answers, .. } = answers;
        let pairs = &mut of_cuboids.pairs;
        let mut kept = 0;
        for place in 0..pairs.len().min(cuboids.len()) {
            let (pair, number) = (pairs[place], cuboids[place]);
            let patch = patches.of(place);
            let answer = &mut answers[number as usize].answer;
            if !patch.is_known() || !solver.measure_cuboids(patch, objects.posed(pair), answer) {
                (pairs[kept], cuboids[kept]) = (pair, number);
                kept += 1;
            }
        }
        pairs.truncate(kept);
        cuboids.truncate(kept);
    }
}
