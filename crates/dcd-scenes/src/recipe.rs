//! The recipes of the seeded scenes.

use crate::random::Draw;
use crate::{RawObject, RawScene, RawShape, RawShare};
use dcd_io::run::{self, Run};
use glam::{DQuat, DVec3};
use std::ops::Range;

/// Streams from here on are the clusters' middles; below they are objects.
const CLUSTER_STREAMS: u64 = 1 << 63;
/// Objects in a cluster.
const CLUSTER_SIZE: usize = 100;
/// Bricks in a row, and rows in a layer.
const BRICK_ROW: usize = 20;

/// What a scene is made of and how it is spread.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Recipe {
    /// Single objects, each drawn by itself.
    Scattered { body: Body, spread: Spread },
    /// Unit cubes in a grid.
    Bricks { pitch: f64 },
    /// The paper's first object, again and again.
    Identical,
}

/// The shape of a scattered object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Body {
    /// The hull of the paper's cloud, stretched along its own axes.
    Hull { stretch: DVec3 },
    /// A cuboid with edges in this range, metres.
    Box { low: f64, high: f64 },
    /// The hull of the eight corners of such a cuboid.
    BoxAsHull { low: f64, high: f64 },
    /// A sphere with a radius in this range, metres.
    Sphere { low: f64, high: f64 },
    /// In a cycle a sphere of radius 0.25 … 0.5, a cuboid with edges in 0.3 … 1.5, a capsule of radius
    /// 0.1 … 0.4 and half height 0.1 … 0.6, and the paper's hull; metres.
    Mixed,
    /// The paper's, scaled by 10^u, u in this range; the first object is a slab.
    Sized { low: f64, high: f64, slab: DVec3 },
}

/// Where scattered objects are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Spread {
    /// A cube of this half-width, metres, for any number of objects.
    Fixed(f64),
    /// A cube of the half-width listed for the largest number not above that of the
    /// objects (or the first), scaled so that the density is that entry's.
    Dense(&'static [(usize, f64)]),
    /// Cubes of half-width `cluster`, their middles in one of half-width `whole`.
    Clusters { cluster: f64, whole: f64 },
}

impl Recipe {
    /// Bytes of an object at least: its pose and record, and its shape unless it is shared. Of the
    /// paper's hulls 75 vertices in f64, and in f32 in the shape and in the step's frame.
    pub(crate) fn least_bytes(&self) -> f64 {
        match self {
            Self::Scattered { body: Body::Hull { .. } | Body::Sized { .. }, .. } => 3000.0,
            Self::Scattered { .. } => 500.0,
            Self::Bricks { .. } | Self::Identical => 300.0,
        }
    }

    /// Some of so many objects, which must be no more than a u32 counts.
    pub(crate) fn share(
        &self,
        range: Range<usize>,
        (objects, seed): (usize, u64),
        run: &Run<'_>,
    ) -> RawShare {
        let first = range.start;
        match *self {
            Self::Scattered { body, spread } => {
                let scatter = Scatter { body, place: spread.place(objects), seed };
                let shape_names = range.clone().map(|i| i as u64).collect();
                let drawn = run::map(run, range, |k, i| scatter.object(k as u32, i));
                let (shapes, objects) = drawn.into_iter().unzip();
                RawShare { first, shape_names, scene: RawScene { shapes, objects } }
            }
            Self::Bricks { pitch } => {
                let shapes = vec![RawShape::Cuboid { half_extents: DVec3::splat(0.5) }];
                let objects = range.map(|i| brick(i, pitch)).collect();
                RawShare { first, shape_names: vec![0], scene: RawScene { shapes, objects } }
            }
            Self::Identical => {
                let scatter = Scatter { body: Body::PAPER, place: Place::Cube(3.0), seed };
                let (shape, object) = scatter.object(0, 0);
                let scene = RawScene { shapes: vec![shape], objects: vec![object; range.len()] };
                RawShare { first, shape_names: vec![0], scene }
            }
        }
    }
}

impl Body {
    /// The paper's hull as it is.
    pub(crate) const PAPER: Self = Self::Hull { stretch: DVec3::ONE };
}

/// The cuboids of every scene that has some.
pub(crate) const BOX: Body = Body::Box { low: 0.3, high: 1.5 };
/// The spheres of every scene that has some.
pub(crate) const SPHERE: Body = Body::Sphere { low: 0.25, high: 0.5 };

/// A [`Spread`] for a known number of objects.
#[derive(Clone, Copy)]
enum Place {
    Cube(f64),
    Clusters { cluster: f64, whole: f64 },
}

impl Spread {
    fn place(self, objects: usize) -> Place {
        match self {
            Self::Fixed(half_width) => Place::Cube(half_width),
            Self::Clusters { cluster, whole } => Place::Clusters { cluster, whole },
            Self::Dense(table) => {
                let row = table.iter().rev().find(|(count, _)| *count <= objects);
                let &(count, half_width) = row.or(table.first()).unwrap_or(&(1, 1.0));
                Place::Cube(half_width * libm::cbrt(objects as f64 / count as f64))
            }
        }
    }
}

struct Scatter {
    body: Body,
    place: Place,
    seed: u64,
}

impl Scatter {
    /// Object `i`, which depends on the seed, `i` and the half-width alone; its shape is to be number `shape`.
    fn object(&self, shape: u32, i: usize) -> (RawShape, RawObject) {
        let mut draw = Draw::new(self.seed, i as u64);
        let rotation = draw.rotation();
        let spot = draw.point(-1.0, 1.0);
        let translation = match self.place {
            Place::Cube(half_width) => spot * half_width,
            Place::Clusters { cluster, whole } => {
                let stream = CLUSTER_STREAMS | (i / CLUSTER_SIZE) as u64;
                Draw::new(self.seed, stream).point(-1.0, 1.0) * whole + spot * cluster
            }
        };
        let object = RawObject { shape, rotation, translation };
        match self.body {
            Body::Sized { slab, .. } if i == 0 => {
                let flat =
                    RawObject { rotation: DQuat::IDENTITY, translation: DVec3::ZERO, ..object };
                (RawShape::Cuboid { half_extents: slab * 0.5 }, flat)
            }
            body => (body.shape(i, &mut draw), object),
        }
    }
}

impl Body {
    /// The shape of object `i`, where that is one of its kind alone.
    fn shape(self, i: usize, draw: &mut Draw) -> RawShape {
        match self {
            Self::Hull { stretch } => RawShape::of_cloud(cloud(draw, stretch)),
            Self::Box { low, high } => {
                RawShape::Cuboid { half_extents: draw.point(low, high) * 0.5 }
            }
            Self::BoxAsHull { low, high } => {
                let corners = Self::Box { low, high }.shape(i, draw).points();
                RawShape::Hull { points: corners, triangles: Vec::new() }
            }
            Self::Sphere { low, high } => RawShape::Sphere { radius: draw.between(low, high) },
            Self::Mixed => match i % 4 {
                0 => SPHERE.shape(i, draw),
                1 => BOX.shape(i, draw),
                2 => {
                    let radius = draw.between(0.1, 0.4);
                    RawShape::Capsule { half_height: draw.between(0.1, 0.6), radius }
                }
                _ => Self::PAPER.shape(i, draw),
            },
            Self::Sized { low, high, .. } => {
                let size = libm::exp10(draw.between(low, high));
                RawShape::of_cloud(cloud(draw, DVec3::splat(size)))
            }
        }
    }
}

/// The paper's cloud: k points uniform in the unit cube, k uniform in 50..100.
fn cloud(draw: &mut Draw, stretch: DVec3) -> Vec<DVec3> {
    let count = draw.count(50..100);
    (0..count).map(|_| draw.point(0.0, 1.0) * stretch).collect()
}

/// Brick `i` of a tower of layers of 20 × 20, x fastest.
fn brick(i: usize, pitch: f64) -> RawObject {
    let layer = BRICK_ROW * BRICK_ROW;
    let cell = [i % BRICK_ROW, i / BRICK_ROW % BRICK_ROW, i / layer].map(|k| k as f64);
    let translation = DVec3::from_array(cell) * pitch;
    RawObject { shape: 0, rotation: DQuat::IDENTITY, translation }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dense_spread_keeps_the_density_of_its_table() {
        let spread = Spread::Dense(&[(10_000, 12.0), (100_000, 30.0)]);
        let half_width = |objects| match spread.place(objects) {
            Place::Cube(half_width) => half_width,
            Place::Clusters { .. } => f64::NAN,
        };
        assert_eq!(half_width(10_000), 12.0);
        assert_eq!(half_width(100_000), 30.0);
        assert!((half_width(80_000) - 24.0).abs() < 1e-12);
        assert!((half_width(1250) - 6.0).abs() < 1e-12);
    }

    #[test]
    fn bricks_fill_a_cube_of_twenty() {
        assert_eq!(brick(7_999, 1.0).translation, DVec3::splat(19.0));
        assert_eq!(brick(21, 2.0).translation, DVec3::new(2.0, 2.0, 0.0));
    }

    #[test]
    fn the_papers_clouds_have_fifty_to_ninety_nine_points_in_the_unit_cube() {
        let sizes: Vec<usize> = (0..2000)
            .map(|i| {
                let cloud = cloud(&mut Draw::new(5, i), DVec3::ONE);
                assert!(
                    cloud.iter().all(|p| p.cmpge(DVec3::ZERO).all() && p.cmplt(DVec3::ONE).all())
                );
                cloud.len()
            })
            .collect();
        assert_eq!((sizes.iter().min(), sizes.iter().max()), (Some(&50), Some(&99)));
    }
}
