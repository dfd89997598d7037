//! Pairs that are taken one by one, in an order in which neighbours are of the same kinds: what one of them takes the next
//! one does, so that its branches are predicted and its code is near.

use super::frame::{BOX, FramePair, Record, SPHERE};
use dcd_geom::Pair;

/// What is reused from slice to slice.
#[derive(Clone, Debug, Default)]
pub(super) struct KindOrder<T> {
    kinds: Vec<u8>,
    ordered: Vec<T>,
}

impl<T: Copy> KindOrder<T> {
    /// Brings together the items whose pairs are of the same kinds. Of the same kinds those come first whose numbers are
    /// lower.
    pub(super) fn sort(
        &mut self,
        (frames, pairs): (FramePair<'_>, &[Pair]),
        items: &mut Vec<T>,
        number_of: impl Fn(&T) -> u32,
    ) {
        let Self { kinds, ordered } = self;
        // Hardly any work: mostly they are in that order.
        items.sort_unstable_by_key(&number_of);
        kinds.clear();
        kinds.extend(items.iter().map(|item| kinds_of(frames, pairs[number_of(item) as usize])));
        let mut ends = [0; KINDS * KINDS];
        kinds.iter().for_each(|&kind| ends[usize::from(kind)] += 1);
        if ends.contains(&items.len()) {
            return;
        }
        let mut end = 0;
        for count in &mut ends {
            end += std::mem::replace(count, end);
        }
        ordered.clone_from(items);
        for (&item, &kind) in items.iter().zip(&*kinds) {
            let place = &mut ends[usize::from(kind)];
            ordered[*place] = item;
            *place += 1;
        }
        std::mem::swap(items, ordered);
    }
}

/// What the objects of a pair are, as their records have it.
fn kinds_of(frames: FramePair<'_>, pair: Pair) -> u8 {
    KINDS as u8 * kind_of(frames.a.record(pair.i)) + kind_of(frames.b.record(pair.j))
}

/// How many kinds are told apart.
const KINDS: usize = 5;

/// The last one is what has no vertices in the lanes: compounds, meshes, half-spaces.
fn kind_of(record: &Record) -> u8 {
    match record {
        _ if record.marks & SPHERE != 0 => 0,
        _ if record.marks & BOX != 0 => 1,
        _ if record.blocks == 0 => 4,
        _ if record.radius > 0.0 => 2,
        _ => 3,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{NarrowPhase, Overlap, Sides};
    use dcd_geom::glam::DVec3;
    use dcd_geom::{Aabb, Pose, Scene, Shape};

    /// Shapes of all kinds, and which of them count as one kind.
    fn shapes() -> Vec<(Shape, u8)> {
        let hull = vec![DVec3::X, DVec3::Y, DVec3::Z, -DVec3::ONE, DVec3::ONE];
        let mesh = Shape::mesh(hull[..3].to_vec(), vec![[0, 1, 2]]);
        let compound = Shape::compound(vec![(Shape::sphere(0.1).unwrap(), Pose::IDENTITY); 2]);
        vec![
            (Shape::sphere(0.5).unwrap(), 0),
            (mesh.unwrap(), 4),
            (Shape::capsule(0.5, 0.2).unwrap(), 2),
            (Shape::cuboid(DVec3::ONE).unwrap(), 1),
            (Shape::hull(hull).unwrap(), 3),
            (compound.unwrap(), 4),
            (Shape::half_space(DVec3::Z, 0.0).unwrap(), 4),
        ]
    }

    #[test]
    fn pairs_of_the_same_kinds_come_together_in_their_order_and_none_is_lost() {
        let shapes = shapes();
        let kind = |object: u32| shapes[object as usize % shapes.len()].1;
        let count = 3 * shapes.len() as u32;
        let cycle = shapes.iter().map(|(shape, _)| shape.clone()).cycle().take(count as usize);
        let scene = Scene::one_each(cycle.collect(), vec![Pose::IDENTITY; count as usize]).unwrap();
        let (narrow, mut frame) = (Overlap::default(), Default::default());
        let part = narrow.layout(&scene, Sides::One, &mut frame);
        narrow.prepare(&scene, 0, part, &mut vec![Aabb::EMPTY; scene.len()]);
        let pairs = (0..count).flat_map(|i| (i + 1..count).map(move |j| Pair { i, j }));
        let pairs: Vec<Pair> = pairs.collect();
        // Not in order, and not all.
        let total = pairs.len() as u32;
        let numbers: Vec<u32> = (0..total).map(|k| k * 11 % total).filter(|k| k % 5 != 0).collect();
        let (frames, mut sorted) = (FramePair { a: &frame, b: &frame }, numbers.clone());
        KindOrder::default().sort((frames, &pairs), &mut sorted, |&number| number);
        let kinds = |number: u32| {
            let Pair { i, j } = pairs[number as usize];
            (kind(i), kind(j))
        };
        let runs: Vec<&[u32]> = sorted.chunk_by(|&k, &l| kinds(k) == kinds(l)).collect();
        let mut seen: Vec<_> = runs.iter().map(|run| kinds(run[0])).collect();
        seen.sort_unstable();
        seen.dedup();
        assert_eq!((seen.len(), runs.len()), (25, 25), "{seen:?}");
        assert!(runs.iter().all(|run| run.is_sorted()));
        let [mut before, mut after] = [numbers, sorted];
        before.sort_unstable();
        after.sort_unstable();
        assert_eq!(before, after);
    }
}
