//! What the lanes read of a shape, in one place for all shapes of a scene.

use crate::Shape;
use crate::lanes::Block;
use glam::DVec3;

/// What depends on a polytope alone, as the lanes want it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Core {
    /// The inner ball's centre in the shape's own frame, metres: the blocks count from here.
    pub centre: DVec3,
    /// The radius of a ball round the centre inside the core, rounded down.
    pub inner: f64,
    /// The radius of a ball round the centre that holds the core, rounded up.
    pub outer: f64,
    /// The largest distance of a vertex from the origin of the shape's own frame, rounded up.
    pub reach: f64,
    /// The radius swept round the core.
    pub radius: f64,
    /// Its first block in [`Cores::blocks`].
    pub first: u32,
    /// How many blocks it has; 0 for a shape that is no polytope.
    pub blocks: u32,
}

/// The cores of all shapes of a scene, and their vertices in f32 blocks, one after the other.
#[derive(Clone, Debug, Default)]
pub struct Cores {
    cores: Vec<Core>,
    blocks: Vec<Block>,
}

impl Cores {
    /// Of these shapes. `None` if there are more than u32::MAX blocks.
    pub(crate) fn of(shapes: &[Shape]) -> Option<Self> {
        let mut cores = Self::default();
        cores.cores.reserve(shapes.len());
        cores
            .blocks
            .reserve(shapes.iter().filter_map(Shape::as_polytope).map(|p| p.block_count()).sum());
        for shape in shapes {
            let Some(polytope) = shape.as_polytope() else {
                cores.cores.push(Core::default());
                continue;
            };
            let first = u32::try_from(cores.blocks.len()).ok()?;
            cores.blocks.extend(polytope.local_blocks());
            cores.cores.push(Core {
                centre: polytope.inner().centre,
                inner: polytope.inner().radius,
                outer: polytope.outer_radius(),
                reach: polytope.reach(),
                radius: polytope.swept_radius(),
                first,
                blocks: u32::try_from(polytope.block_count()).ok()?,
            });
        }
        Some(cores)
    }

    /// One for each shape of the scene.
    pub fn cores(&self) -> &[Core] {
        &self.cores
    }

    /// The vertices of a core, relative to its centre.
    #[inline]
    pub fn blocks(&self, core: &Core) -> &[Block] {
        &self.blocks[core.first as usize..][..core.blocks as usize]
    }
}
