//! A line clipped against the planes of a polytope's faces (M. Cyrus and J. Beck, 1978).

use super::local::{Chord, LocalRay, is_later};
use dcd_geom::FacetPlanes;

/// How many planes are compared at once: enough to keep the arithmetic busy between two decisions.
const CHUNK: usize = 8;

/// The chord in the outer planes, each moved outward by `out`, and that in the inner ones, moved by `inward`, which
/// is below 0. `None` where the line misses the outer ones, or enters them after `limit`.
pub(super) fn chords(
    ray: &LocalRay,
    planes: &FacetPlanes,
    [out, inward]: [f64; 2],
    limit: f64,
) -> Option<(Chord, Option<Chord>)> {
    let (mut outer, mut inner) = (Chord::LINE, Chord::LINE);
    let mut entered = 0;
    let (o, d) = (ray.origin, ray.direction);
    let [nx, ny, nz] = &planes.normals;
    for first in (0..planes.len()).step_by(CHUNK) {
        let count = (planes.len() - first).min(CHUNK);
        let (mut along, mut rise) = ([0.0; CHUNK], [0.0; CHUNK]);
        let part = first..first + count;
        let normals = nx[part.clone()].iter().zip(&ny[part.clone()]).zip(&nz[part.clone()]);
        for (((x, y), z), (along, rise)) in normals.zip(along.iter_mut().zip(&mut rise)) {
            *along = x * o.x + y * o.y + z * o.z;
            *rise = x * d.x + y * d.y + z * d.z;
        }
        let (high, low) = (&planes.outer[part.clone()], &planes.inner[part]);
        for k in 0..count {
            let (beyond, within) = (high[k] + out - along[k], low[k] + inward - along[k]);
            let (s, t) = (beyond / rise[k], within / rise[k]);
            if rise[k] < 0.0 {
                if s > outer.enter {
                    (outer.enter, entered) = (s, first + k);
                }
                inner.enter = inner.enter.max(t);
            } else if rise[k] > 0.0 {
                outer.leave = outer.leave.min(s);
                inner.leave = inner.leave.min(t);
            } else {
                if beyond < 0.0 {
                    return None;
                }
                if !(within > 0.0) {
                    inner.leave = f64::NEG_INFINITY;
                }
            }
        }
        if outer.enter > outer.leave || is_later(outer.enter, limit) {
            return None;
        }
    }
    if outer.enter > f64::NEG_INFINITY {
        (outer.normal, outer.facet) = (planes.normal(entered), Some(entered as u32));
    }
    Some((outer, (inner.enter <= inner.leave).then_some(inner)))
}
