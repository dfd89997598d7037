//! The manifold of two boxes whose edges are along the world's axes, as bricks, crates and voxels have them: the rectangle
//! in which two faces overlap.
//!
//! The features are those of boxes that are turned: these are found by clipping one face with the other.

use super::cuboid_faces::face_number;
use super::cuboids::is_solid;
use super::feature_code::FeatureCode;
use super::patch_writer::{PatchWriter, Point};
use super::{Feature, bound_of, clip::APART};
use crate::PosedShape;
use crate::epa::Depth;
use dcd_geom::glam::{DMat3, DVec3};
use dcd_geom::{Kind, Polytope};

/// A box whose edges are along the world's axes.
struct Upright<'a> {
    polytope: &'a Polytope,
    /// Along its own axes, and along the world's.
    own_half: [f64; 3],
    half: [f64; 3],
    centre: [f64; 3],
    /// For each of the world's axes, which of its own is along it, and whether it leads the same way.
    own: [(usize, bool); 3],
}

impl<'a> Upright<'a> {
    /// `None` of other shapes, rounded and flat boxes, and those that are turned otherwise than by quarters.
    #[inline(always)]
    fn of(side: PosedShape<'a>) -> Option<Self> {
        let polytope = side.shape.as_polytope()?;
        let Kind::Cuboid { half_extents } = polytope.kind() else { return None };
        let &DMat3 { x_axis, y_axis, z_axis } = side.pose.rotation();
        let [along_x, along_y, along_z] =
            [world_axis(x_axis)?, world_axis(y_axis)?, world_axis(z_axis)?];
        if polytope.swept_radius() != 0.0 || !is_solid(half_extents) {
            return None;
        }
        let (own_half, mut half, mut own) = (half_extents.to_array(), [0.0; 3], [(0, false); 3]);
        for (k, (axis, is_forward)) in [along_x, along_y, along_z].into_iter().enumerate() {
            half[axis] = own_half[k];
            own[axis] = (k, is_forward);
        }
        let centre = side.pose.translation().to_array();
        Some(Self { polytope, own_half, half, centre, own })
    }

    /// Where it ends along an axis, up or down.
    #[inline(always)]
    fn end(&self, axis: usize, is_up: bool) -> f64 {
        if is_up {
            self.centre[axis] + self.half[axis]
        } else {
            self.centre[axis] - self.half[axis]
        }
    }

    /// The bit that the vertices at that end have in their number.
    #[inline(always)]
    fn bit(&self, axis: usize, is_up: bool) -> u32 {
        let (own, is_forward) = self.own[axis];
        u32::from(is_up == is_forward) << own
    }

    /// The face at that end.
    #[inline(always)]
    fn face(&self, axis: usize, is_up: bool) -> Option<FeatureCode> {
        let (own, is_forward) = self.own[axis];
        let number = face_number(self.polytope, self.own_half, own, is_up == is_forward)?;
        Some(Feature::Face(number).into())
    }

    /// The edge at those ends of two axes.
    #[inline(always)]
    fn edge(&self, ends: [(usize, bool); 2], along: usize) -> FeatureCode {
        let low = ends.map(|(axis, is_up)| self.bit(axis, is_up));
        let low = low[0] | low[1];
        FeatureCode::edge(low, low | 1 << self.own[along].0)
    }
}

/// The axis of the world that a column of a rotation is, and whether it leads the same way; `None` of others.
#[inline(always)]
fn world_axis(column: DVec3) -> Option<(usize, bool)> {
    let size = column.abs();
    let axis = usize::from(size.y == 1.0) + 2 * usize::from(size.z == 1.0);
    let is_one = size.element_sum() == 1.0 && size.max_element() == 1.0;
    is_one.then(|| (axis, column.element_sum() > 0.0))
}

/// Where the two end that clip each other, along an axis of their faces, up or down.
#[derive(Clone, Copy)]
struct End {
    at: f64,
    is_up: bool,
    /// Whether the one that clips ends there: the other reaches beyond it.
    is_of_clips: bool,
}

/// Two boxes that show each other faces.
struct Faces<'a> {
    clips: Upright<'a>,
    clipped: Upright<'a>,
    /// The axis that they are normal to, and whether the one that clips shows the face at its upper end.
    axis: usize,
    is_up: bool,
    whole: [FeatureCode; 2],
}

impl Faces<'_> {
    /// Where what they have in common ends along an axis: at two places, or at one where they only just meet.
    #[inline(always)]
    fn ends(&self, axis: usize, near: f64) -> Option<([End; 2], usize)> {
        let [down, up] = [false, true].map(|is_up| {
            let (of_clips, of_clipped) =
                (self.clips.end(axis, is_up), self.clipped.end(axis, is_up));
            let is_of_clips = if is_up { of_clips < of_clipped } else { of_clips > of_clipped };
            End { at: if is_of_clips { of_clips } else { of_clipped }, is_up, is_of_clips }
        });
        let width = up.at - down.at;
        // Written so that NaN is none.
        if !(width >= -near) {
            return None;
        }
        // Of one place the other's own end, as far as it has one.
        let first = if width <= near && down.is_of_clips { up } else { down };
        Some(([first, up], if width <= near { 1 } else { 2 }))
    }

    /// What the corner at those ends of the two axes is: of the one that clips, and of the other.
    #[inline(always)]
    fn features(&self, [(p, at_p), (q, at_q)]: [(usize, End); 2]) -> [FeatureCode; 2] {
        let Self { clips, clipped, axis, is_up, whole } = self;
        let of_clips =
            |end: (usize, End), along| clips.edge([(*axis, *is_up), (end.0, end.1.is_up)], along);
        let of_clipped = |end: (usize, End), along| {
            clipped.edge([(*axis, !*is_up), (end.0, end.1.is_up)], along)
        };
        let vertex = |side: &Upright<'_>, is_up: bool| {
            let ends = side.bit(p, at_p.is_up) | side.bit(q, at_q.is_up);
            FeatureCode::vertex(side.bit(*axis, is_up) | ends)
        };
        match (at_p.is_of_clips, at_q.is_of_clips) {
            (false, false) => [whole[0], vertex(clipped, !*is_up)],
            (true, false) => [of_clips((p, at_p), q), of_clipped((q, at_q), p)],
            (false, true) => [of_clips((q, at_q), p), of_clipped((p, at_p), q)],
            (true, true) => [vertex(clips, *is_up), whole[1]],
        }
    }
}

/// Writes the manifold of two boxes of that depth, of which the one of that number, 0 or 1, clips; false, and nothing written,
/// where the general way is needed.
#[inline]
pub(super) fn write(
    depth: &Depth,
    [a, b]: [PosedShape<'_>; 2],
    clips: usize,
    writer: &mut impl PatchWriter,
) -> bool {
    let Some((axis, is_up)) = world_axis(depth.normal) else { return false };
    let (Some(of_a), Some(of_b)) = (Upright::of(a), Upright::of(b)) else { return false };
    let (Some(face_a), Some(face_b)) = (of_a.face(axis, is_up), of_b.face(axis, !is_up)) else {
        return false;
    };
    let size = 2.0 * (of_a.polytope.outer_radius() + of_b.polytope.outer_radius());
    let faces_at = [of_a.end(axis, is_up), of_b.end(axis, !is_up)];
    let faces = match clips {
        0 => Faces { clips: of_a, clipped: of_b, axis, is_up, whole: [face_a, face_b] },
        _ => Faces { clips: of_b, clipped: of_a, axis, is_up: !is_up, whole: [face_b, face_a] },
    };
    let [p, q] = [(axis + 1) % 3, (axis + 2) % 3];
    let near = APART * size;
    let (Some((of_p, count_p)), Some((of_q, count_q))) = (faces.ends(p, near), faces.ends(q, near))
    else {
        return false;
    };
    let point = |at_p: End, at_q: End| {
        let [mut point_a, mut point_b] = [[0.0; 3]; 2];
        for (point, at) in [(&mut point_a, faces_at[0]), (&mut point_b, faces_at[1])] {
            (point[axis], point[p], point[q]) = (at, at_p.at, at_q.at);
        }
        let [of_clips, of_clipped] = faces.features([(p, at_p), (q, at_q)]);
        let features = if clips == 0 { [of_clips, of_clipped] } else { [of_clipped, of_clips] };
        let (point_a, point_b) = (DVec3::from_array(point_a), DVec3::from_array(point_b));
        Point { point_a, point_b, depth: depth.depth, features }
    };
    writer.begin(depth.normal, bound_of(depth, size, [a, b]), point(of_p[0], of_q[0]));
    // The one across first, then the others.
    match (count_p, count_q) {
        (1, 1) => {}
        (1, _) | (_, 1) => writer.push(point(of_p[count_p - 1], of_q[count_q - 1])),
        _ => {
            writer.push(point(of_p[1], of_q[1]));
            writer.push(point(of_p[1], of_q[0]));
            writer.push(point(of_p[0], of_q[1]));
        }
    }
    true
}

#[cfg(test)]
mod tests;
