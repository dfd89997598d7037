//! A ray and triangles, watertight (S. Woop, C. Benthin, I. Wald, "Watertight ray/triangle intersection", 2013).
//!
//! All triangles of a mesh see one ray, sheared onto the z axis, and two triangles compute the same number for an
//! edge that they share, but for its sign. So no ray passes between them. An edge function whose sign the margin
//! does not prove counts as either.

use super::leaf::NotMissed;
use super::local::LocalRay;
use super::{Ray, RayHit, general};
use crate::PosedShape;
use crate::query::PartIndex;
use dcd_geom::glam::DVec3;
use dcd_geom::{Mesh, Shape};

/// The shear that takes a ray to the z axis.
pub(super) struct Sheared {
    /// Which coordinates are x, y and z; the direction's largest component is z.
    pub(super) axes: [usize; 3],
    /// At most 1 in size.
    pub(super) shear: [f64; 2],
    /// One over the direction's largest component.
    per_z: f64,
    pub(super) origin: DVec3,
    pub(super) margin: f64,
}

impl Sheared {
    pub(super) fn of(ray: &LocalRay) -> Self {
        let d = ray.direction;
        let size = d.abs();
        let z = if size.x >= size.y && size.x >= size.z {
            0
        } else if size.y >= size.z {
            1
        } else {
            2
        };
        let axes = [(z + 1) % 3, (z + 2) % 3, z];
        let shear = [d[axes[0]] / d[z], d[axes[1]] / d[z]];
        Self { axes, shear, per_z: 1.0 / d[z], origin: ray.origin, margin: 2.0 * ray.margin }
    }

    /// A corner as the ray sees it.
    #[inline(always)]
    fn seen(&self, corner: DVec3) -> [f64; 3] {
        let [x, y, z] = self.axes;
        let v = (corner - self.origin).to_array();
        [v[x] - self.shear[0] * v[z], v[y] - self.shear[1] * v[z], v[z] * self.per_z]
    }

    /// The hit of a triangle, without a part.
    pub(super) fn hit(&self, ray: &Ray, local: &LocalRay, corners: [DVec3; 3]) -> Option<RayHit> {
        let [a, b, c] = [self.seen(corners[0]), self.seen(corners[1]), self.seen(corners[2])];
        let m = self.margin;
        // Outside of the box round it: a miss of what is seen edge on as well.
        for k in 0..2 {
            let (low, high) = (a[k].min(b[k]).min(c[k]), a[k].max(b[k]).max(c[k]));
            if low > m || high < -m {
                return None;
            }
        }
        let (u, v, w) = (edge(b, c), edge(c, a), edge(a, b));
        let off = [span(b, c), span(c, a), span(a, b)].map(|span| m * (span + 2.0 * m));
        let (mut more, mut less) = (0, 0);
        for (sign, off) in [u, v, w].into_iter().zip(off) {
            more += u32::from(sign > off);
            less += u32::from(sign < -off);
        }
        if more > 0 && less > 0 {
            return None;
        }
        let is_met = more == 3 || less == 3;
        let (near, far) = (a[2].min(b[2]).min(c[2]), a[2].max(b[2]).max(c[2]));
        let depth_off = m * self.per_z.abs();
        let determinant = u + v + w;
        let lost: f64 = off.iter().sum();
        let (t, error) = if determinant.abs() > 4.0 * lost {
            let t = ((u * a[2] + v * b[2] + w * c[2]) / determinant).clamp(near, far);
            let spread: f64 =
                off.iter().zip([a, b, c]).map(|(off, corner)| off * (corner[2] - t).abs()).sum();
            (t, 2.0 * spread / determinant.abs() + depth_off)
        } else {
            (0.5 * (near + far), 0.5 * (far - near) + depth_off)
        };
        let error = error + (t.abs() + error) * (4.0 * f64::EPSILON);
        let (first, last) = (t - error, t + error);
        if last < 0.0 || first > ray.max_t() {
            return None;
        }
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        let normal = if normal.dot(local.direction) > 0.0 { -normal } else { normal };
        let (t_lower, t_upper) = (first.max(0.0), last.min(ray.max_t()));
        let is_certain = is_met && first >= 0.0 && last <= ray.max_t();
        Some(RayHit {
            // A corner at the origin may have −0.
            t: if is_certain { t.clamp(t_lower, t_upper) } else { t_lower } + 0.0,
            t_lower,
            t_upper,
            is_certain,
            normal: local.in_world(normal),
            facet: None,
            part: None,
        })
    }
}

/// Twice the area of a triangle with the origin.
fn edge(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

/// By how much an edge function changes at most with a margin at its ends, over the margin; its own rounding is in it.
fn span(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0].abs() + a[1].abs() + b[0].abs() + b[1].abs()
}

/// The hits of a mesh's triangles: see [`super::for_each_hit`].
pub(super) fn of_mesh(
    ray: &Ray,
    posed: PosedShape<'_>,
    mesh: &Mesh,
    mut limit: f64,
    visit: &mut dyn FnMut(RayHit) -> f64,
) {
    let radius = mesh.swept_radius();
    let local = LocalRay::of(ray, &posed, mesh.reach() + radius);
    // The radius in the mesh's own frame, grown by what a pose may stretch.
    let slabs = local.slabs(radius * (1.0 + 4.0 * posed.pose.deviation()));
    let sheared = Sheared::of(&local);
    let first = slabs.key_of(limit);
    let mut of_triangle = |number: u32, _| {
        let Some(corners) = mesh.corners(number as usize) else { return slabs.key_of(limit) };
        let hit = if radius == 0.0 {
            sheared.hit(ray, &local, corners)
        } else {
            // Its corners and the radius were checked when the mesh was made.
            Shape::triangle(corners)
                .and_then(|triangle| triangle.rounded(radius))
                .ok()
                .and_then(|shape| general::hit(ray, PosedShape { shape: &shape, pose: posed.pose }))
        };
        if let Some(hit) = hit {
            limit = visit(RayHit { part: Some(PartIndex::Triangle(number)), ..hit });
        }
        slabs.key_of(limit)
    };
    if radius == 0.0 {
        let near = NotMissed { sheared: &sheared, leaves: mesh.leaves() };
        mesh.tree().visit_filtered((&slabs, &near), first, &mut of_triangle);
    } else {
        mesh.tree().visit(&slabs, first, &mut of_triangle);
    }
}
