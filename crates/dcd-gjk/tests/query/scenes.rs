//! A seeded pile in which a part of the pairs touches, for every query.

use super::PosedSupport;
use dcd_geom::glam::{DQuat, DVec3};
use dcd_geom::{Object, Pair, Polytope, Scene, Shape};
use std::sync::Arc;

/// A multiplicative generator (Steele and Vigna 2022): enough for places.
pub(crate) struct Draw(pub(crate) u64);

impl Draw {
    /// By that seed, or another by `DCD_SEED`.
    pub(crate) fn seeded(fixed: u64) -> Self {
        Self(std::env::var("DCD_SEED").map_or(fixed, |seed| seed.parse().expect("a seed")))
    }

    /// Uniform in −1 … 1.
    pub(crate) fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(0xd134_2543_de82_ef95).wrapping_add(1);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    pub(crate) fn vector(&mut self) -> DVec3 {
        DVec3::new(self.unit(), self.unit(), self.unit())
    }

    pub(crate) fn turn(&mut self) -> DQuat {
        let [x, y, z, w] = [0; 4].map(|_| self.unit());
        DQuat::from_xyzw(x, y, z, w + 1e-3).normalize()
    }
}

/// A box, a sphere, a rounded needle, a flat plate, a hull and, last, a foreign sphere.
pub(crate) fn shapes() -> Vec<Shape> {
    let mut draw = Draw(3);
    let cloud = (0..20).map(|_| draw.vector() * 0.6).collect();
    let needle = Polytope::hull(vec![DVec3::NEG_X * 0.8, DVec3::X * 0.8]).unwrap();
    vec![
        Shape::cuboid(DVec3::new(0.5, 0.4, 0.3)).unwrap(),
        Shape::sphere(0.4).unwrap(),
        needle.rounded(0.1).unwrap().into(),
        Shape::cuboid(DVec3::new(0.7, 0.6, 0.0)).unwrap(),
        Shape::hull(cloud).unwrap(),
        Shape::custom(Arc::new(Polytope::sphere(0.45).unwrap())).unwrap(),
    ]
}

/// Objects of these shapes in turn; half of them not rotated, so that faces are parallel.
pub(crate) fn pile(shapes: Vec<Shape>, objects: u32) -> (Scene, Vec<Pair>) {
    let mut draw = Draw(7);
    let kinds = shapes.len() as u32;
    let object = |k: u32| {
        let place = (draw.vector() * 8.0).round() / 4.0;
        let turn = if k.is_multiple_of(2) { DQuat::IDENTITY } else { draw.turn() };
        let PosedSupport { pose, .. } = PosedSupport::new(Shape::sphere(0.0).unwrap(), turn, place);
        Object::new(k % kinds, pose)
    };
    let scene = Scene::new(shapes, (0..objects).map(object).collect::<Vec<_>>()).unwrap();
    (scene, all_pairs(objects))
}

/// The scene of those objects, and that of the same in the reverse order: of n objects the pair (i, j) is (n − 1 − j, n − 1 − i) there.
pub(crate) fn in_both_orders(shapes: Vec<Shape>, objects: Vec<Object>) -> [Scene; 2] {
    let reversed = objects.iter().rev().copied().collect();
    [objects, reversed].map(|objects: Vec<_>| Scene::new(shapes.clone(), objects).unwrap())
}

/// Every pair of so many objects.
pub(crate) fn all_pairs(objects: u32) -> Vec<Pair> {
    (0..objects).flat_map(|i| (i + 1..objects).map(move |j| Pair::new(i, j))).collect()
}
