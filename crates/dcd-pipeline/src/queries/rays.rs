//! Rays through a scene.

use super::{Queries, QueryFilter, Search, order};
use dcd_exec::{Exec, Segments};
use dcd_gjk::PosedShape;
use dcd_gjk::query::ray::{Ray, RayHit, for_each_hit};
use dcd_simd::RaySlabs;

/// How many rays a task casts: some tens of microseconds.
const RAYS_PER_TASK: usize = 32;

/// A hit, and of which object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObjectHit {
    /// The object's index.
    pub object: u32,
    /// Where on it.
    pub hit: RayHit,
}

impl ObjectHit {
    /// By t, then by object, then by part or triangle.
    fn order(&self, other: &Self) -> std::cmp::Ordering {
        self.hit
            .t
            .total_cmp(&other.hit.t)
            .then(self.object.cmp(&other.object))
            .then(self.hit.part.cmp(&other.hit.part))
    }
}

/// What is known of a ray's first hit.
struct RayCast<'a> {
    queries: &'a Queries<'a>,
    ray: &'a Ray,
    slabs: &'a RaySlabs,
    filter: &'a QueryFilter<'a>,
    first: Option<ObjectHit>,
    /// Proved: nothing is met before, of what has been looked at; a hit with a wide bracket may come after the first by its t.
    lower: f64,
    /// What is met later is not the first.
    end: f64,
}

impl Search for RayCast<'_> {
    /// Casts the ray at an object. Returns whether the first hit known is where the ray begins.
    fn meet(&mut self, object: u32) -> bool {
        let Self { queries, ray, filter, first, lower, end, .. } = self;
        if filter.sees(queries.scene, object) {
            for_each_hit(ray, PosedShape::of(queries.scene, object), *end, &mut |hit| {
                let hit = ObjectHit { object, hit };
                *lower = lower.min(hit.hit.t_lower);
                if first.is_none_or(|known| hit.order(&known).is_lt()) {
                    *first = Some(hit);
                }
                if hit.hit.is_certain {
                    *end = end.min(hit.hit.t_upper);
                }
                *end
            });
        }
        first.is_some_and(|known| known.hit.t == 0.0)
    }

    fn limit(&self) -> f32 {
        self.slabs.key_of(self.end)
    }
}

impl Queries<'_> {
    /// The first hit of all objects that the filter lets pass: the least t, of equal ones that of the least object,
    /// then of the least part. Of what may be met at t = 0 the objects whose AABBs hold the
    /// origin come first. No object is met before its `t_lower`.
    ///
    /// A hit that is not certain may be a miss: what is behind it is in [`Queries::all_hits`].
    pub fn first_hit(&self, ray: &Ray, filter: &QueryFilter<'_>) -> Option<ObjectHit> {
        let slabs = &ray.slabs();
        // Later than its end nothing can be first.
        let end = ray.max_t();
        let (first, lower) = (None, f64::INFINITY);
        let mut search = RayCast { queries: self, ray, slabs, filter, first, lower, end };
        self.meet_nearest(slabs, &mut search);
        let RayCast { first, lower, .. } = search;
        let at_least = |hit| RayHit { t_lower: lower, ..hit };
        first.map(|found| ObjectHit { hit: at_least(found.hit), ..found })
    }

    /// Some object that the ray certainly meets, if any: sooner known than the first. The same at any number of
    /// threads. `None` does not prove the way free: hits that are not certain may remain. [`Queries::first_hit`]
    /// proves it.
    pub fn any_hit(&self, ray: &Ray, filter: &QueryFilter<'_>) -> Option<ObjectHit> {
        let slabs = ray.slabs();
        let mut found: Option<ObjectHit> = None;
        self.visit(&slabs, slabs.key_of(ray.max_t()), &mut |object, _| {
            if found.is_none() && filter.sees(self.scene, object) {
                let posed = PosedShape::of(self.scene, object);
                for_each_hit(ray, posed, ray.max_t(), &mut |hit| {
                    if found.is_none() && hit.is_certain {
                        found = Some(ObjectHit { object, hit });
                    }
                    if found.is_some() { -1.0 } else { ray.max_t() }
                });
            }
            if found.is_some() { -1.0 } else { slabs.key_of(ray.max_t()) }
        });
        found
    }

    /// Replaces `hits` by all, one of each convex object, one of each part of a compound and each triangle of a mesh
    /// that the ray may meet: by t, then by object, then by part.
    pub fn all_hits(&self, ray: &Ray, filter: &QueryFilter<'_>, hits: &mut Vec<ObjectHit>) {
        hits.clear();
        self.list_hits(ray, filter, hits);
    }

    /// Appends them.
    fn list_hits(&self, ray: &Ray, filter: &QueryFilter<'_>, hits: &mut Vec<ObjectHit>) {
        let first = hits.len();
        let slabs = ray.slabs();
        let end = slabs.key_of(ray.max_t());
        self.visit(&slabs, end, &mut |object, _| {
            if filter.sees(self.scene, object) {
                for_each_hit(ray, PosedShape::of(self.scene, object), ray.max_t(), &mut |hit| {
                    hits.push(ObjectHit { object, hit });
                    ray.max_t()
                });
            }
            end
        });
        hits[first..].sort_unstable_by(ObjectHit::order);
    }

    /// Replaces `hits` by the first hit of each ray, in the order of the rays; where there are many, they are cast in
    /// an order that takes those together that meet the same objects.
    pub fn first_hits<'e>(
        &self,
        rays: &[Ray],
        filter: &QueryFilter<'_>,
        exec: impl Into<Exec<'e>>,
        hits: &mut Vec<Option<ObjectHit>>,
    ) {
        let order = (rays.len(), order::of_rays(rays, self.aabbs));
        order::answer_each((exec.into(), RAYS_PER_TASK), order, hits, |k| {
            self.first_hit(&rays[k], filter)
        });
    }

    /// Replaces `hits` by all hits of each ray, those of ray k in segment k: see [`Queries::all_hits`].
    pub fn all_hits_of_each<'e>(
        &self,
        rays: &[Ray],
        filter: &QueryFilter<'_>,
        exec: impl Into<Exec<'e>>,
        hits: &mut Segments<ObjectHit>,
    ) {
        let order = (rays.len(), order::of_rays(rays, self.aabbs));
        order::list_each((exec.into(), RAYS_PER_TASK), order, hits, |k, hits| {
            self.list_hits(&rays[k], filter, hits);
        });
    }
}
