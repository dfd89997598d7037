//! A ray and triangles, watertight (S. Woop, C. Benthin, I. Wald, "Watertight ray/triangle intersection", 2013).
//!
//! All triangles of a mesh see one ray, sheared onto the z axis, and two triangles compute the same number for an
//! edge that they share, but for its sign. So no ray passes between them. An edge function whose sign the margin
//! does not prove counts as either.

use super::leaf::NotMissed;
use super::local::{LocalRay, is_later};
use super::shared_edges::{DoubtfulHit, DoubtfulHits, RaySide};
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

    /// Whether a ray misses all that is so near to a triangle, metres, or meets it later than `limit`.
    fn passes(&self, corners: [DVec3; 3], near: f64, limit: f64) -> bool {
        let [a, b, c] = corners.map(|corner| self.seen(corner));
        // The shear is at most 1: what is seen of a length is below 1.5 of it.
        let m = self.margin + 1.5 * near;
        let is_beside = |k: usize| a[k].min(b[k]).min(c[k]) > m || a[k].max(b[k]).max(c[k]) < -m;
        let depth_off = m * self.per_z.abs();
        let (first, last) = (a[2].min(b[2]).min(c[2]), a[2].max(b[2]).max(c[2]));
        is_beside(0) || is_beside(1) || last + depth_off < 0.0 || is_later(first - depth_off, limit)
    }

    /// The hit of a triangle, without a part.
    pub(super) fn hit(&self, ray: &Ray, local: &LocalRay, corners: [DVec3; 3]) -> Option<RayHit> {
        Some(self.with_sides(ray, local, corners)?.hit)
    }

    /// The same, and beside which edges the ray goes.
    fn with_sides(&self, ray: &Ray, local: &LocalRay, corners: [DVec3; 3]) -> Option<DoubtfulHit> {
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
        let side = |edge: f64, off: f64| match edge {
            left if left > off => RaySide::Left,
            right if right < -off => RaySide::Right,
            _ => RaySide::Unknown,
        };
        let sides = [side(u, off[0]), side(v, off[1]), side(w, off[2])];
        if sides.contains(&RaySide::Left) && sides.contains(&RaySide::Right) {
            return None;
        }
        let is_met = !sides.contains(&RaySide::Unknown);
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
        let is_within = first >= 0.0 && last <= ray.max_t();
        let is_certain = is_met && is_within;
        let hit = RayHit {
            // A corner at the origin may have −0.
            t: if is_certain { t.clamp(t_lower, t_upper) } else { t_lower } + 0.0,
            t_lower,
            t_upper,
            is_certain,
            normal: local.in_world(normal),
            facet: None,
            part: None,
        };
        Some(DoubtfulHit { corners, sides, is_within, hit })
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
    let part = |number: u32| Some(PartIndex::Triangle(number));
    if radius == 0.0 {
        let near = NotMissed { sheared: &sheared, leaves: mesh.leaves() };
        let mut doubtful = DoubtfulHits::default();
        mesh.tree().visit_filtered((&slabs, &near), first, &mut |number, _| {
            let found = mesh.corners(number as usize);
            if let Some(mut found) = found.and_then(|of| sheared.with_sides(ray, &local, of)) {
                found.hit.part = part(number);
                let is_met = !found.sides.contains(&RaySide::Unknown);
                let known = if is_met { Some(found.hit) } else { doubtful.hold(found) };
                limit = known.map_or(limit, &mut *visit);
            }
            slabs.key_of(limit)
        });
        doubtful.settle(limit, visit);
    } else {
        let grown = radius * (1.0 + 4.0 * posed.pose.deviation());
        mesh.tree().visit(&slabs, first, &mut |number, _| {
            let near = mesh.corners(number as usize);
            if let Some(corners) = near.filter(|&of| !sheared.passes(of, grown, limit)) {
                // Its corners and the radius were checked when the mesh was made.
                let shape = Shape::triangle(corners).and_then(|triangle| triangle.rounded(radius));
                let of = |shape| general::hit(ray, PosedShape { shape, pose: posed.pose });
                if let Some(hit) = shape.ok().as_ref().and_then(of) {
                    limit = visit(RayHit { part: part(number), ..hit });
                }
            }
            slabs.key_of(limit)
        });
    }
}
