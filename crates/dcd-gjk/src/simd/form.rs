//! What the objects of a scene have in common, and so what must be prepared of them.

use super::cores::{Core, Cores, is_sphere};
use dcd_geom::{Kind, Shape};

/// What is to be found of pairs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Purpose {
    /// Which of them touch.
    Decide,
    /// How far or how deep, too.
    Measure,
}

/// What the objects of a scene have in common.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Form {
    /// Nothing: every polytope has its vertices.
    #[default]
    Any,
    /// All are spheres, and marked as [`SPHERE`](super::frame::SPHERE): [`super::spheres`] resolves their pairs.
    Spheres,
    /// All are cuboids of radius 0: the sphere and OBB tests resolve their pairs.
    Cuboids,
    /// All that would have vertices, whole objects and parts of compounds, are cuboids of radius 0, and pairs are only decided: by the
    /// same tests. Parts have no vertices then, which would be more than half of what is written of them; whole objects have
    /// theirs, which are not read.
    CuboidParts,
}

impl Form {
    pub(super) fn of(shapes: &[Shape], cores: &Cores, purpose: Purpose) -> Self {
        let spheres = |shape: &Shape| shape.as_polytope().is_some_and(is_sphere);
        let kind = |shape: &Shape| shape.as_polytope().map(|p| (p.kind(), p.swept_radius()));
        let cuboids = |shape| matches!(kind(shape), Some((Kind::Cuboid { .. }, 0.0)));
        let parts = cores.parts();
        if shapes.iter().all(spheres) {
            Self::Spheres
        } else if shapes.iter().all(cuboids) {
            Self::Cuboids
        } else if purpose == Purpose::Decide
            && !parts.is_empty()
            && cores.cores().iter().all(|core| core.blocks == 0 || is_cuboid(core))
            && parts.iter().all(is_cuboid)
        {
            Self::CuboidParts
        } else {
            Self::Any
        }
    }
}

/// Whether a core is its boxes, so that no vertex of it is needed. A whole object that the lanes do not know is none, and is resolved by
/// itself; a part that they do not know, as a moved ellipsoid or a foreign shape, is none either, and would be passed by among
/// parts that need no vertices.
fn is_cuboid(core: &Core) -> bool {
    (core.is_box || core.is_nearly_box) && core.has_obb && core.radius == 0.0
}
