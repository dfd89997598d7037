//! The point clouds of a shipped game, spread at a chosen density.

use crate::random::Draw;
use crate::{RawObject, RawScene, RawShape, RawShare};
use dcd_io::run::{self, Run};
use glam::{DMat3, DVec3};
use std::ops::Range;

/// How many other objects an object is compared with to compute the half-width.
const PARTNERS: usize = 16;
/// The cube's edge, metres, is not looked for much beyond this: AABBs are f32.
const LARGEST_EDGE: f64 = 1e12;

/// How large the hulls are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GameSize {
    /// As in the game: from 6 centimetres to 440 metres.
    True,
    /// Each scaled so that its largest extent along an axis of its own is 1 metre.
    Unit,
}

/// How the clouds of `data/hulls` are spread.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GameHulls {
    /// How large.
    pub size: GameSize,
    /// About how many candidate pairs (overlapping exact AABBs) there are for each object. The
    /// cube is made as large as that takes, so that positions scale with the number of objects.
    pub candidates: f64,
}

impl GameHulls {
    /// A scene of clouds: object i has cloud i modulo their number, so that all occur if there are
    /// enough objects. The paper's rotations; the middle of each object's AABB is uniform in a cube.
    pub fn raw(&self, clouds: &[Vec<DVec3>], objects: usize, seed: u64) -> RawScene {
        self.raw_by(clouds, (objects, seed), &run::in_order)
    }

    /// [`GameHulls::raw`], the same by any [`Run`]: a task makes a hull.
    pub fn raw_by(
        &self,
        clouds: &[Vec<DVec3>],
        (objects, seed): (usize, u64),
        run: &Run<'_>,
    ) -> RawScene {
        self.share_by(clouds, 0..objects, (objects, seed), run).scene
    }

    /// Some of the objects, with the hulls that they have; all clouds are looked at.
    pub(crate) fn share_by(
        &self,
        clouds: &[Vec<DVec3>],
        range: Range<usize>,
        (objects, seed): (usize, u64),
        run: &Run<'_>,
    ) -> RawShare {
        // No cloud, no object.
        let objects = if clouds.is_empty() { 0 } else { objects };
        let range = range.start.min(objects)..range.end.min(objects);
        let used = &clouds[..clouds.len().min(objects)];
        let mut scaled: Vec<Vec<DVec3>> = used.iter().map(|cloud| self.scaled(cloud)).collect();
        let place = |i: usize| {
            let shape = i % scaled.len();
            Placed::draw(&mut Draw::new(seed, i as u64), &scaled[shape], shape as u32)
        };
        let mut placed: Vec<Placed> = (0..objects).map(place).collect();
        let half_width = half_width(&placed, self.candidates);
        // Each cloud stands where the first object of the share that has it does.
        let count = scaled.len().min(range.len());
        let names: Vec<usize> = range.clone().take(count).map(|i| i % scaled.len()).collect();
        for (k, Placed { object, spot, middle, .. }) in placed[range.clone()].iter_mut().enumerate()
        {
            object.shape = (k % count) as u32;
            object.translation = *spot * half_width - *middle;
        }
        let clouds = names.iter().map(|&shape| std::mem::take(&mut scaled[shape]));
        let shapes = run::map(run, clouds, |_, cloud| RawShape::of_cloud(cloud));
        let own = placed.drain(range.clone()).map(|placed| placed.object);
        RawShare {
            first: range.start,
            shape_names: names.iter().map(|&shape| shape as u64).collect(),
            scene: RawScene { shapes, objects: own.collect() },
        }
    }

    fn scaled(&self, cloud: &[DVec3]) -> Vec<DVec3> {
        let (min, max) = bounds(cloud.iter().copied());
        let extent = (max - min).max_element();
        let scale = match self.size {
            GameSize::Unit if extent > 0.0 => 1.0 / extent,
            _ => 1.0,
        };
        cloud.iter().map(|&p| p * scale).collect()
    }
}

/// An object whose half-width is not known yet.
struct Placed {
    object: RawObject,
    /// Its AABB's middle, in half-widths.
    spot: DVec3,
    /// Its AABB's middle relative to its own origin, metres, world axes.
    middle: DVec3,
    /// Half the edges of its AABB.
    half: DVec3,
}

impl Placed {
    fn draw(draw: &mut Draw, cloud: &[DVec3], shape: u32) -> Self {
        let rotation = draw.rotation();
        let turn = DMat3::from_quat(rotation.normalize());
        let (min, max) = bounds(cloud.iter().map(|&p| turn * p));
        let object = RawObject { shape, rotation, translation: DVec3::ZERO };
        let spot = draw.point(-1.0, 1.0);
        Self { object, spot, middle: (min + max) * 0.5, half: (max - min) * 0.5 }
    }
}

fn bounds(points: impl Iterator<Item = DVec3>) -> (DVec3, DVec3) {
    points.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(min, max), p| (min.min(p), max.max(p)))
}

/// The half-width of the cube in which the expected number of overlapping AABBs is `candidates` an
/// object: by bisection, over a fixed choice of pairs. 0, all at one place, if even that gives too
/// few; capped if no cube of finite size gives so few.
fn half_width(placed: &[Placed], candidates: f64) -> f64 {
    let pairs_an_object = placed.len().saturating_sub(1) as f64 / 2.0;
    if pairs_an_object <= candidates {
        return 0.0;
    }
    let expected = |edge: f64| pairs_an_object * mean_overlap(placed, edge);
    let (mut low, mut high) = (0.0, 1.0);
    while expected(high) > candidates && high < LARGEST_EDGE {
        (low, high) = (high, 2.0 * high);
    }
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if expected(middle) > candidates { low = middle } else { high = middle }
    }
    0.5 * high
}

/// The probability that two AABBs overlap whose middles are uniform in a cube of this edge, on
/// average over pairs: each object with some that are spread over the whole, since neighbours in
/// the file are alike. Two uniform numbers in [0, L] are within s of each other with probability
/// 2s/L − (s/L)².
fn mean_overlap(placed: &[Placed], edge: f64) -> f64 {
    let others = placed.len().saturating_sub(1);
    let partners = PARTNERS.min(others);
    let pairs = placed.iter().enumerate().flat_map(|(i, a)| {
        let steps = (0..partners).map(move |k| 1 + k * others / partners);
        steps.map(move |step| a.half + placed[(i + step) % placed.len()].half)
    });
    let overlap = |sum: DVec3| {
        let s = (sum / edge).min(DVec3::ONE);
        (s * (2.0 - s)).element_product()
    };
    pairs.map(overlap).sum::<f64>() / (placed.len() * partners).max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn clouds() -> Vec<Vec<DVec3>> {
        let corner = |k: u32| DVec3::new((k & 1).into(), (k >> 1 & 1).into(), (k >> 2).into());
        let cube: Vec<DVec3> = (0..8).map(corner).collect();
        let off_centre = cube.iter().map(|&p| p * 3.0 + 100.0).collect();
        vec![cube, off_centre, vec![DVec3::ONE; 4]]
    }

    #[test]
    fn every_cloud_occurs_and_the_shapes_are_shared() {
        let game = GameHulls { size: GameSize::True, candidates: 1.0 };
        let raw = game.raw(&clouds(), 7, 1);
        assert_eq!(raw.shapes.len(), 3);
        let shapes: Vec<u32> = raw.objects.iter().map(|object| object.shape).collect();
        assert_eq!(shapes, [0, 1, 2, 0, 1, 2, 0]);
        assert_eq!(raw.into_scene().unwrap().len(), 7);
    }

    #[test]
    fn the_density_is_about_what_was_requested() {
        for candidates in [0.5, 4.0, 20.0] {
            for size in [GameSize::True, GameSize::Unit] {
                let raw = GameHulls { size, candidates }.raw(&clouds(), 3000, 2);
                let scene = raw.into_scene().unwrap();
                let boxes: Vec<_> = (0..scene.len()).map(|i| scene.aabb(i)).collect();
                let overlaps = (0..boxes.len())
                    .map(|i| boxes[..i].iter().filter(|b| b.overlaps(&boxes[i])).count())
                    .sum::<usize>();
                let found = overlaps as f64 / 3000.0;
                assert!((found / candidates - 1.0).abs() < 0.1, "{size:?} {candidates}: {found}");
            }
        }
    }

    #[test]
    fn unit_size_scales_the_largest_extent_and_leaves_a_point_alone() {
        let game = GameHulls { size: GameSize::Unit, candidates: 1.0 };
        let raw = game.raw(&clouds(), 3, 1);
        let (min, max) = bounds(raw.shapes[1].points().into_iter());
        assert!(((max - min).max_element() - 1.0).abs() < 1e-12);
        assert_eq!(raw.shapes[2].points(), [DVec3::ONE; 4]);
    }

    #[test]
    fn no_cloud_or_no_object_makes_an_empty_scene() {
        let game = GameHulls { size: GameSize::Unit, candidates: 4.0 };
        assert_eq!(game.raw(&[], 100, 1), RawScene::default());
        assert_eq!(game.raw(&clouds(), 0, 1), RawScene::default());
        assert_eq!(game.raw(&clouds(), 1, 1).objects.len(), 1);
    }
}
