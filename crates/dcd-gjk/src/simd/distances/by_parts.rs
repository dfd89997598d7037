//! Pairs of objects of which one is a compound: the distances of their parts, sixteen pairs of parts at a time.
//!
//! Of each pair the likeliest parts come first; of the others those alone whose boxes are nearer than these.

use super::super::closed::{are_cuboids, nearest_features as of_cuboids};
use super::super::expand::{Expand, Queue};
use super::super::frame::FramePair;
use super::super::nearest_points;
use super::super::scene_pairs::ScenePairs;
use super::of_points::distance_of;
use crate::closed::{self, distance_of_spheres};
use crate::distance::DistanceResult;
use crate::mesh::NearParts;
use crate::{Accuracy, Distance, PosedShape, mesh};
use dcd_geom::Pair;
use dcd_simd::{Path, Unfused, dispatch_on};
use std::ops::Range;

/// What the lanes found of two objects by their parts.
#[derive(Clone, Debug, Default)]
pub(super) enum Found {
    /// That they are farther apart than the margin.
    #[default]
    Beyond,
    /// How far apart they are.
    Near(Distance),
    /// Which parts may be the nearest, in [`ByParts::candidates`].
    Among(Range<usize>),
}

/// What a thread reuses from slice to slice.
#[derive(Debug, Default)]
pub(super) struct ByParts {
    /// The pairs, all of which are known to be apart.
    pub(super) pairs: Vec<Pair>,
    /// For each what was found.
    pub(super) found: Vec<Found>,
    /// Pairs of parts, by their numbers in their compounds.
    pub(super) candidates: Vec<NearParts>,
    numbers: Vec<u32>,
    queue: Queue,
    /// The gaps of the likeliest pairs of parts, and of the others.
    firsts: Gaps,
    rest: Gaps,
    /// Where the others of each question end that are looked at.
    ends: Vec<usize>,
    lanes: PartLanes,
}

/// Pairs of parts, and what is known of each.
#[derive(Debug, Default)]
struct Gaps {
    /// By their records.
    pairs: Vec<Pair>,
    gaps: Vec<Gap>,
}

/// What is known of how far apart two parts are.
#[derive(Clone, Copy, Debug)]
struct Gap {
    /// At most that far, metres; infinite: farther than the margin.
    lower: f64,
    /// The distance, where the lanes know it.
    distance: Option<Distance>,
    /// Between which vertices two polytopes are thought to be nearest, by their places in the blocks.
    start: Option<[[u32; 2]; 3]>,
}

impl Gap {
    const BEYOND: Self = Self { lower: f64::INFINITY, distance: None, start: None };

    /// Of that distance, if it is known; at least `lower` of it.
    fn of(distance: Option<Distance>, lower: f64) -> Self {
        let of_distance = distance.map_or(0.0, |found| found.lower());
        Self { lower: lower.max(of_distance), distance, start: None }
    }

    /// The same, where that is known too.
    fn starting_from(self, start: [[u32; 2]; 3]) -> Self {
        Self { start: Some(start), ..self }
    }

    fn upper(&self) -> f64 {
        self.distance.map_or(f64::INFINITY, |found| found.upper())
    }
}

/// What the lanes work with.
#[derive(Debug, Default)]
struct PartLanes {
    of_cuboids: of_cuboids::Scratch,
    cuboids: Listed,
    nearest: nearest_points::Scratch,
    others: Listed,
}

/// Some of the pairs of parts.
#[derive(Debug, Default)]
struct Listed {
    pairs: Vec<Pair>,
    /// Their places among all.
    at: Vec<usize>,
}

impl Listed {
    fn clear(&mut self) {
        self.pairs.clear();
        self.at.clear();
    }

    fn push(&mut self, at: usize, pair: Pair) {
        self.pairs.push(pair);
        self.at.push(at);
    }
}

impl ByParts {
    /// Looks for the nearest parts of each of the pairs.
    pub(super) fn find(
        &mut self,
        path: Path,
        objects: ScenePairs<'_>,
        (margin, accuracy): (f64, Accuracy),
    ) {
        let Self { pairs, found, candidates, numbers, queue, firsts, rest, ends, lanes } = self;
        let objects = ScenePairs { pairs, ..objects };
        let frames = objects.frames;
        candidates.clear();
        found.clear();
        found.resize(pairs.len(), Found::Beyond);
        numbers.clear();
        numbers.extend(0..pairs.len() as u32);
        // Rounded up, so that no pair within the margin is left out.
        let far = Some((margin as f32).next_up());
        let mut open = &numbers[..];
        while !open.is_empty() {
            let expand = Expand { frames, pairs, numbers: open, margin: far, queue };
            open = &open[dispatch_on(path, Unfused(expand))..];
            firsts.take_firsts(queue);
            lanes.measure(path, (objects, margin), firsts);
            rest.take_rest(queue, firsts, ends);
            lanes.measure(path, (objects, margin), rest);
            let mut begin = 0;
            for (place, (question, &end)) in queue.questions.iter().zip(&*ends).enumerate() {
                let of_rest = begin..end;
                let all = firsts.of(place..place + 1).chain(rest.of(of_rest));
                found[question.number as usize] =
                    nearest(all, accuracy, (objects, question.number), candidates);
                begin = end;
            }
        }
    }
}

impl Gaps {
    fn clear(&mut self) {
        self.pairs.clear();
        self.gaps.clear();
    }

    /// Nothing is known of a pair of parts but how far apart its boxes are.
    fn push(&mut self, pair: Pair, of_boxes: f32) {
        self.pairs.push(pair);
        self.gaps.push(Gap { lower: f64::from(of_boxes), distance: None, start: None });
    }

    /// Takes the likeliest pair of each question.
    fn take_firsts(&mut self, queue: &Queue) {
        self.clear();
        for (&pair, &gap) in queue.first.iter().zip(&queue.gaps[0]) {
            self.push(pair, gap);
        }
    }

    /// Takes all others that may be nearer than those, and where those of each question end.
    fn take_rest(&mut self, queue: &Queue, firsts: &Self, ends: &mut Vec<usize>) {
        self.clear();
        ends.clear();
        let mut begin = 0;
        for (question, first) in queue.questions.iter().zip(&firsts.gaps) {
            let (of_rest, upper) = (begin..question.end as usize, first.upper());
            for (&pair, &gap) in queue.rest[of_rest.clone()].iter().zip(&queue.gaps[1][of_rest]) {
                if f64::from(gap) <= upper {
                    self.push(pair, gap);
                }
            }
            ends.push(self.pairs.len());
            begin = question.end as usize;
        }
    }

    fn of(&self, range: Range<usize>) -> impl Iterator<Item = (Pair, Gap)> + Clone {
        self.pairs[range.clone()].iter().copied().zip(self.gaps[range].iter().copied())
    }
}

impl PartLanes {
    /// Measures two spheres from their centres, and lists the others.
    fn list(&mut self, frames: FramePair<'_>, Gaps { pairs, gaps, .. }: &mut Gaps) {
        self.cuboids.clear();
        self.others.clear();
        for ((at, &pair), gap) in pairs.iter().enumerate().zip(gaps) {
            if let Some(spheres) = frames.spheres(pair) {
                let distance = match distance_of_spheres(spheres, closed::AS_F64) {
                    Some(DistanceResult::Apart(distance)) => Some(distance),
                    _ => None,
                };
                *gap = Gap::of(distance, gap.lower);
            } else if are_cuboids(frames, pair) {
                self.cuboids.push(at, pair);
            } else {
                self.others.push(at, pair);
            }
        }
    }

    /// Measures pairs of parts.
    fn measure(&mut self, path: Path, (objects, margin): (ScenePairs<'_>, f64), all: &mut Gaps) {
        let frames = objects.frames;
        self.list(frames, all);
        let Self { of_cuboids, cuboids, nearest, others } = self;
        let Gaps { pairs, gaps } = all;
        of_cuboids::find(path, frames, (&cuboids.pairs, margin), of_cuboids);
        for (&at, found) in cuboids.at.iter().zip(&of_cuboids.found) {
            gaps[at] = match found {
                of_cuboids::Found::Beyond => Gap::BEYOND,
                of_cuboids::Found::Unknown => gaps[at],
                of_cuboids::Found::Near(near) => {
                    let distance = near.distance_in_f32(frames, pairs[at]);
                    Gap::of(distance, gaps[at].lower.max(f64::from(near.lower)))
                        .starting_from(near.vertices())
                }
            };
        }
        nearest_points::find(path, frames, (&others.pairs, margin), nearest);
        for (&at, found) in others.at.iter().zip(&nearest.found) {
            gaps[at] = match found {
                nearest_points::Found::Beyond => Gap::BEYOND,
                nearest_points::Found::Unknown => gaps[at],
                nearest_points::Found::Nearest(points) => {
                    let in_f64 = || {
                        let [a, b] = objects.posed(pairs[at]);
                        distance_of(points, a, b)
                    };
                    let distance = points.distance_in_f32(frames, pairs[at]).or_else(in_f64);
                    Gap::of(distance, gaps[at].lower).starting_from(points.corners)
                }
            };
        }
    }
}

/// The nearest of all pairs of parts of the objects' pair of that number: its distance, where that is known well enough, or
/// those that may be it.
fn nearest(
    all: impl Iterator<Item = (Pair, Gap)> + Clone,
    accuracy: Accuracy,
    (objects, number): (ScenePairs<'_>, u32),
    candidates: &mut Vec<NearParts>,
) -> Found {
    let pair = objects.pairs[number as usize];
    let upper = all.clone().map(|(_, gap)| gap.upper()).fold(f64::INFINITY, f64::min);
    let may_be = all.filter(|(_, gap)| gap.lower <= upper && gap.lower < f64::INFINITY);
    if may_be.clone().next().is_none() {
        return Found::Beyond;
    }
    let numbers = |records| objects.part_numbers(records);
    if accuracy == Accuracy::F32
        && let Some(distances) = may_be
            .clone()
            .map(|(records, gap)| Some((records, gap.distance?)))
            .collect::<Option<Vec<_>>>()
        && let Some(distance) = least(&distances, objects.posed(pair), numbers)
    {
        return Found::Near(distance);
    }
    let begin = candidates.len();
    let candidate = |(records, gap): (Pair, Gap)| {
        let start = gap.start.and_then(|start| vertices(start, objects.posed(records)));
        NearParts { parts: numbers(records), start }
    };
    candidates.extend(may_be.map(candidate));
    Found::Among(begin..candidates.len())
}

/// The vertices of two polytopes in those places of their blocks, the last of which is filled up with the last vertex.
fn vertices(places: [[u32; 2]; 3], [a, b]: [PosedShape<'_>; 2]) -> Option<[[u32; 2]; 3]> {
    let last =
        |side: PosedShape<'_>| (side.shape.as_polytope()?.vertices().len() as u32).checked_sub(1);
    let (last_a, last_b) = (last(a)?, last(b)?);
    Some(places.map(|[a, b]| [a.min(last_a), b.min(last_b)]))
}

/// The least of the distances of pairs of parts, and what bounds it. Of equal ones the first by its parts' numbers, in an order
/// that is one for (a, b) and (b, a).
fn least(
    distances: &[(Pair, Distance)],
    [a, b]: [PosedShape<'_>; 2],
    numbers: impl Fn(Pair) -> [u32; 2],
) -> Option<Distance> {
    let shortest = distances.iter().map(|(_, found)| found.distance).fold(f64::INFINITY, f64::min);
    let lower = distances.iter().map(|(_, found)| found.lower()).fold(f64::INFINITY, f64::min);
    let mut as_near = distances.iter().filter(|(_, found)| found.distance == shortest);
    let first = as_near.next()?;
    let mut least = first.1;
    if as_near.clone().next().is_some() {
        let is_swapped = mesh::is_swapped(a, b);
        let key = |records| {
            let [of_a, of_b] = numbers(records);
            if is_swapped { [of_b, of_a] } else { [of_a, of_b] }
        };
        least = std::iter::once(first).chain(as_near).min_by_key(|(pair, _)| key(*pair))?.1;
    }
    let below = (shortest - lower).next_up();
    Some(Distance { error_bound: least.error_bound.max(below), ..least })
}
