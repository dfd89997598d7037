//! Scenes of one kind of shape, of which the others have few or none.

use anyhow::Result;
use dcd_geom::glam::DVec3;
use dcd_geom::{Object, Pose, Scene, Shape};

use crate::kinds::Draw;

/// What all objects of a scene are: each its own shape, about a metre across.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Scattered {
    Capsules,
    Cylinders,
    /// Four cuboids each.
    Compounds,
    /// Twenty cuboids each.
    LargeCompounds,
    /// Six hulls of up to twenty vertices each.
    Decompositions,
    /// The surfaces of cuboids, twelve triangles each.
    Meshes,
}

impl Scattered {
    pub(crate) const ALL: [Self; 6] = [
        Self::Capsules,
        Self::Cylinders,
        Self::Compounds,
        Self::LargeCompounds,
        Self::Decompositions,
        Self::Meshes,
    ];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Capsules => "capsules",
            Self::Cylinders => "cylinders",
            Self::Compounds => "compounds",
            Self::LargeCompounds => "large-compounds",
            Self::Decompositions => "decompositions",
            Self::Meshes => "meshes",
        }
    }

    /// So many objects, one a cubic metre.
    pub(crate) fn scene(self, objects: usize, seed: u64) -> Result<Scene> {
        let mut draw = Draw(seed);
        let half_width = (objects as f64).cbrt() / 2.0;
        let (mut shapes, mut placed) = (Vec::new(), Vec::new());
        for number in 0..u32::try_from(objects)? {
            shapes.push(self.shape(&mut draw)?);
            placed.push(Object::new(number, draw.pose(half_width)?));
        }
        Ok(Scene::new(shapes, placed)?)
    }

    fn shape(self, draw: &mut Draw) -> Result<Shape> {
        let half = draw.half_extents();
        let mut compound =
            |count: usize, spread: f64, part: &dyn Fn(&mut Draw) -> Result<Shape>| {
                let parts = (0..count).map(|_| Ok((part(draw)?, draw.pose(spread)?)));
                anyhow::Ok(Shape::compound(parts.collect::<Result<Vec<(Shape, Pose)>>>()?)?)
            };
        match self {
            Self::Capsules => draw.named("capsule"),
            Self::Cylinders => draw.named("cylinder"),
            Self::Compounds => compound(4, 0.3, &|_| Ok(Shape::cuboid(half * 0.4)?)),
            Self::LargeCompounds => compound(20, 0.4, &|_| Ok(Shape::cuboid(half * 0.3)?)),
            Self::Decompositions => compound(6, 0.3, &|draw| {
                let point = |_| draw.vector().normalize_or(DVec3::X) * half * 0.5;
                Ok(Shape::hull((0..20).map(point).collect())?)
            }),
            Self::Meshes => surface_of_cuboid(half),
        }
    }
}

/// A cuboid's surface, each face as two triangles.
fn surface_of_cuboid(half: DVec3) -> Result<Shape> {
    let sign = |corner: u32, bit: u32| if corner & bit == 0 { -1.0 } else { 1.0 };
    let corner = |k: u32| DVec3::from_array([1, 2, 4].map(|bit| sign(k, bit))) * half;
    let faces =
        [[0, 2, 1, 3], [4, 5, 6, 7], [0, 1, 4, 5], [2, 6, 3, 7], [0, 4, 2, 6], [1, 3, 5, 7]];
    let triangles = faces.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [b, d, c]]).collect();
    Ok(Shape::mesh((0..8).map(corner).collect(), triangles)?)
}
