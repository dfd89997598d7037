//! The manifold of two shapes that touch by what is swept round their cores, as the lanes found these: where they have one point.

use super::Feature;
use super::cuboid_faces::number_in;
use super::cuboids::CuboidFeature;
use super::facing::Part;
use super::feature::cross_by;
use super::patch_writer::PatchWriter;
use crate::simd::{CoreContact, NearCore};
use dcd_geom::glam::DVec3;

/// The sine above which two edges surely cross that f32 knows to some millionths. Smaller: edges that are parallel, and touch in
/// two points, or where they cross is not well known.
const CROSSING: f64 = 1e-2;

/// What a core shows along the normal.
enum Shown {
    Vertex(Feature),
    /// With its direction.
    Edge(Feature, DVec3),
    Face(Feature),
}

/// Writes the witnesses of the depth; `None`, and nothing written, where the two may have more points in common.
#[inline(always)]
pub(super) fn write(contact: &CoreContact<'_>, writer: &mut impl PatchWriter) -> Option<()> {
    let CoreContact { depth, cores: [a, b] } = contact;
    let features = match [shown(a, depth.normal)?, shown(b, -depth.normal)?] {
        [Shown::Edge(of_a, e), Shown::Edge(of_b, f)] => {
            if !cross_by(CROSSING, depth.normal, [e, f]) {
                return None;
            }
            [of_a, of_b]
        }
        [Shown::Vertex(of_a), Shown::Vertex(of_b) | Shown::Edge(of_b, _) | Shown::Face(of_b)]
        | [Shown::Edge(of_a, _) | Shown::Face(of_a), Shown::Vertex(of_b)] => [of_a, of_b],
        _ => return None,
    };
    writer.write_witnesses(depth, features, depth.error_bound);
    Some(())
}

#[inline(always)]
fn shown(core: &NearCore<'_>, towards: DVec3) -> Option<Shown> {
    Some(match core {
        NearCore::Point => Shown::Vertex(Feature::Vertex(0)),
        NearCore::Segment(edge) => match Part::of_edge(*edge, towards)? {
            part @ Part::Vertex(_) => Shown::Vertex(part.name()),
            part => Shown::Edge(part.name(), *edge),
        },
        NearCore::Cuboid(cuboid) => {
            let towards = cuboid.towards.to_array();
            let seen = CuboidFeature::towards(towards);
            let face = |axis: usize| number_in(cuboid.case(), axis, towards[axis] > 0.0);
            // Of a flat one two corners may be the farthest; it has no number.
            face(0)?;
            let feature = seen.feature(towards, face)?;
            match seen {
                CuboidFeature::Face(_) => Shown::Face(feature),
                CuboidFeature::Edge(axis) => Shown::Edge(feature, cuboid.edge(axis)),
                CuboidFeature::Vertex => Shown::Vertex(feature),
            }
        }
    })
}
