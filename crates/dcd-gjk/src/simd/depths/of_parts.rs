//! How deep the parts of compounds overlap that touch: cuboids by what the lanes find of them, polytopes by the search that
//! objects have. What neither knows is left to the solver.

use super::super::closed::{are_cuboids, depths as of_cuboids, patches};
use super::super::frame::{FramePair, Record};
use super::super::scene_pairs::ScenePairs;
use super::super::touching_parts::OfCompounds;
use super::answers::{Answers, Contacts};
use super::{SimdDepths, TouchingScratch};
use crate::epa::{self, Depth};
use crate::query::{FoundParts, PartContact, PartSpheres};
use crate::{Accuracy, Contact, Depths};
use dcd_geom::Pair;
use dcd_geom::glam::DVec3;
use dcd_simd::{ArrayVec, Path};
use std::ops::Range;

/// What a thread reuses from slice to slice.
#[derive(Debug, Default)]
pub(super) struct OfParts {
    /// The pairs of objects of whose parts is known which touch: their numbers among all that touch, in rising order, and where
    /// their parts are.
    questions: Vec<(u32, Range<usize>)>,
    parts: Vec<Parts>,
    of_cuboids: of_cuboids::Scratch,
    patches: patches::Scratch,
    has_patches: bool,
    /// The pairs of parts that are searched, by their records, and what of them is found.
    searched: Vec<Pair>,
    contacts: Vec<Contact<Depth>>,
    left: Vec<u32>,
    scratch: epa::Scratch,
}

/// Two parts that touch, by their numbers in their compounds.
#[derive(Clone, Copy, Debug)]
struct Parts {
    numbers: [u32; 2],
    spheres: PartSpheres,
    found: Found,
}

/// Where it is what was found of two parts.
#[derive(Clone, Copy, Debug)]
enum Found {
    Nowhere,
    /// Their place among the cuboids.
    Cuboids(usize),
    /// Their place among those searched.
    Searched(usize),
}

impl OfParts {
    /// Measures the parts of pairs of a slice, those that were judged by their parts. `objects` has the pairs that touch, in the
    /// slice's order.
    pub(super) fn measure(
        &mut self,
        (path, accuracy): (Path, Accuracy),
        objects: ScenePairs<'_>,
        slice: (&[Pair], &OfCompounds),
        lanes: &mut TouchingScratch,
    ) {
        self.list(objects, slice);
        if self.questions.is_empty() {
            return;
        }
        let Self {
            parts, of_cuboids, patches, has_patches, searched, contacts, left, scratch, ..
        } = self;
        *has_patches = accuracy == Accuracy::F32;
        if *has_patches {
            patches::find(path, objects.frames, &of_cuboids.pairs, patches);
        }
        of_cuboids::find(path, objects.frames, of_cuboids);
        let objects = ScenePairs { pairs: searched, ..objects };
        contacts.clear();
        contacts.extend(searched.iter().map(|&pair| Contact { pair, answer: Depth::default() }));
        left.clear();
        let to = Contacts { path, solver: &Depths, scratch, contacts, first: 0, left };
        let answers = Answers { objects, to, waiting: ArrayVec::new() };
        SimdDepths { path, accuracy, solver: Depths }.answer(objects, lanes, answers);
        left.sort_unstable();
        for part in parts {
            if let Found::Searched(place) = part.found
                && left.binary_search(&(place as u32)).is_ok()
            {
                part.found = Found::Nowhere;
            }
        }
    }

    /// Lists the parts by how they are measured.
    fn list(&mut self, objects: ScenePairs<'_>, (pairs, known): (&[Pair], &OfCompounds)) {
        let Self { questions, parts, of_cuboids, searched, .. } = self;
        questions.clear();
        parts.clear();
        of_cuboids.pairs.clear();
        searched.clear();
        let mut touching = (0u32..).zip(objects.pairs);
        let mut begin = 0;
        for &(number, end) in &known.ends {
            let pair = pairs[number as usize];
            let records = &known.pairs[begin..end];
            begin = end;
            let Some((place, _)) = touching.find(|(_, touching)| **touching == pair) else {
                return;
            };
            let [a, b] = objects.posed(pair);
            // Equal parts at one pose have no order by content.
            let have_order = a.pose != b.pose;
            let first = parts.len();
            parts.extend(records.iter().map(|&records| {
                let found = match have_order {
                    false => Found::Nowhere,
                    true if are_cuboids(objects.frames, records) => {
                        of_cuboids.pairs.push(records);
                        Found::Cuboids(of_cuboids.pairs.len() - 1)
                    }
                    true => {
                        searched.push(records);
                        Found::Searched(searched.len() - 1)
                    }
                };
                let numbers = objects.part_numbers(records);
                Parts { numbers, spheres: spheres(objects.frames, records), found }
            }));
            questions.push((place, first..parts.len()));
        }
    }

    /// Prefetches the parts of the pair behind the one that was listed last.
    fn look_ahead(&self, objects: ScenePairs<'_>, place: usize) {
        if let Some((number, parts)) = self.questions.get(place + 1) {
            let numbers = self.parts[parts.clone()].iter().map(|part| part.numbers);
            objects.look_ahead_to_compounds(objects.pairs[*number as usize], numbers);
        }
    }

    /// Lists what is known of the parts of the pair of that number among those that touch; false, and nothing listed, of one that
    /// was not judged by its parts.
    pub(super) fn list_known<'k>(
        &'k self,
        objects: ScenePairs<'_>,
        number: u32,
        known: &mut Vec<PartContact<'k>>,
    ) -> bool {
        let Ok(place) = self.questions.binary_search_by_key(&number, |question| question.0) else {
            return false;
        };
        self.look_ahead(objects, place);
        known.clear();
        known.extend(self.parts[self.questions[place].1.clone()].iter().map(|part| {
            let found = match part.found {
                Found::Nowhere => FoundParts::Nothing,
                Found::Searched(place) => FoundParts::Depth(self.contacts[place].answer),
                Found::Cuboids(place) => {
                    let patch = self.has_patches.then(|| self.patches.of(place));
                    match patch.filter(|patch| patch.is_known()) {
                        Some(patch) => FoundParts::Patch(patch),
                        None => FoundParts::Axes(self.of_cuboids.axes[place]),
                    }
                }
            };
            PartContact { parts: part.numbers, spheres: part.spheres, found }
        }));
        true
    }
}

/// The spheres in two parts and round them: none in and one without end round a part that the lanes do not know.
#[inline(always)]
fn spheres(frames: FramePair<'_>, records: Pair) -> PartSpheres {
    let (a, b) = (frames.a.record(records.i), frames.b.record(records.j));
    let centre = |record: &Record| DVec3::from_slice(&record.centre[..3]);
    let between = centre(b) - centre(a);
    if a.blocks == 0 || b.blocks == 0 {
        return PartSpheres { between, inner: f64::NEG_INFINITY, outer: f64::INFINITY };
    }
    let slack = f64::from(a.slack) + f64::from(b.slack);
    PartSpheres {
        between,
        inner: f64::from(a.inner) + f64::from(b.inner) - 2.0 * slack,
        outer: f64::from(a.outer) + f64::from(b.outer) + 2.0 * slack,
    }
}
