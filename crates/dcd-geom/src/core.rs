//! What the lanes read of a shape, in one place for all shapes of a scene.

use crate::lanes::Block;
use crate::{Shape, TwinBox};
use glam::{DVec3, Vec3};

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
    /// Whether [`Cores::twin_boxes`] has its boxes.
    pub has_twin_box: bool,
}

/// A [`TwinBox`] in f32.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LaneBox {
    /// The directions of the edges, each component off by one rounding.
    pub axes: [Vec3; 3],
    /// Half the edges of the outer box, rounded up.
    pub outer: Vec3,
    /// Half the edges of the inner box, rounded down.
    pub inner: Vec3,
}

impl LaneBox {
    fn of(twin_box: &TwinBox) -> Self {
        let axes = [twin_box.axes.x_axis, twin_box.axes.y_axis, twin_box.axes.z_axis];
        let up = |x: f64| (x as f32).next_up();
        let down = |x: f64| (x as f32).next_down().max(0.0);
        let [x, y, z] = twin_box.outer.to_array().map(up);
        let [u, v, w] = twin_box.inner.to_array().map(down);
        Self {
            axes: axes.map(|axis| axis.as_vec3()),
            outer: Vec3::new(x, y, z),
            inner: Vec3::new(u, v, w),
        }
    }
}

/// The cores of all shapes of a scene, and their vertices in f32 blocks, one after the other.
#[derive(Clone, Debug, Default)]
pub struct Cores {
    cores: Vec<Core>,
    blocks: Vec<Block>,
    /// One for each shape, up to the last that has one.
    twin_boxes: Vec<LaneBox>,
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
                has_twin_box: polytope.twin_box().is_some(),
            });
            if let Some(twin_box) = polytope.twin_box() {
                cores.twin_boxes.resize(cores.cores.len(), LaneBox::default());
                cores.twin_boxes[cores.cores.len() - 1] = LaneBox::of(twin_box);
            }
        }
        Some(cores)
    }

    /// One for each shape of the scene.
    pub fn cores(&self) -> &[Core] {
        &self.cores
    }

    /// For each shape its boxes, up to the last that has some; meaningful where
    /// [`Core::has_twin_box`] is set.
    pub fn twin_boxes(&self) -> &[LaneBox] {
        &self.twin_boxes
    }

    /// The vertices of a core, relative to its centre.
    #[inline]
    pub fn blocks(&self, core: &Core) -> &[Block] {
        &self.blocks[core.first as usize..][..core.blocks as usize]
    }
}
