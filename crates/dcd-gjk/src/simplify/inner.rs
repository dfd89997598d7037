//! The hull of some of a shape's vertices.

use super::{Budget, Near, beyond};
use dcd_geom::glam::DVec3;
use dcd_geom::{Polytope, SupportMap};

/// Chosen vertices of a core of distinct ones: their hull is inside it.
pub(super) fn within(core: &Polytope, budget: Budget) -> Near {
    let points = core.vertices();
    let mut chosen = ends(core);
    // How far each was from an earlier, smaller hull: at least as far as from the last.
    let mut known = vec![f64::MAX; points.len()];
    loop {
        let Ok(hull) = Polytope::hull(chosen.clone()) else {
            return Near { points: points.to_vec(), distance: 0.0 };
        };
        let (farthest, distance) = farthest(points, &hull, &mut known);
        if distance <= budget.tolerance || chosen.len() >= budget.vertices {
            return Near { points: chosen, distance };
        }
        chosen.push(points[farthest]);
    }
}

/// The farthest along the six axes, each once.
fn ends(core: &Polytope) -> Vec<DVec3> {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|d| [d, -d]);
    let mut ends: Vec<u32> = axes.map(|d| SupportMap::<f64>::support(core, d).feature).collect();
    ends.sort_unstable();
    ends.dedup();
    ends.into_iter().map(|k| core.vertices()[k as usize]).collect()
}

/// The point farthest from the hull, and how far. Only those are measured again that were farther
/// from an earlier hull than what is found.
fn farthest(points: &[DVec3], hull: &Polytope, known: &mut [f64]) -> (usize, f64) {
    let mut measured = vec![false; points.len()];
    loop {
        let (mut first, mut most) = (0, 0.0);
        for (k, &distance) in known.iter().enumerate() {
            if distance > most {
                (first, most) = (k, distance);
            }
        }
        if most == 0.0 || measured[first] {
            return (first, most);
        }
        known[first] = beyond(points[first], hull).0;
        measured[first] = true;
    }
}
