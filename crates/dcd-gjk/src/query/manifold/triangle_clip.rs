//! The corners that a triangle has in common with a body, seen along a normal.

use super::clip::Corner;
use super::facing::Part;
use super::feature::View;
use super::outline::{CORNERS, Outline, Outlines};
use super::polygon::Polygon;
use dcd_geom::glam::{DVec2, DVec3};

/// One more than a body's corners for each of four cuts, and spare ones for what rounding adds.
const MOST: usize = CORNERS + 6;

/// The patch of a triangle and a body.
pub(super) type TrianglePolygon = Polygon<MOST>;

/// Adds what a triangle that shows that and a body have in common, the radii of both counted, unless it is deeper than
/// `most` anywhere. `None` where the general way is needed: for edges that are nearly parallel.
pub(super) fn add(
    (view, radii, most): (&View, [f64; 2], f64),
    (part, triangle): (&Part<'_>, &[DVec3; 3]),
    body: &Outline,
    polygon: &mut TrianglePolygon,
    corners: &mut Vec<Corner>,
) -> Option<()> {
    let Some(triangle) = Outline::of_triangle(view, part, (triangle, radii[0])) else {
        return Some(());
    };
    let outlines = Outlines::of([triangle.shown(), body.shown()], radii);
    outlines.clip(polygon)?;
    let radius = outlines.radius();
    // Written so that NaN is no corner.
    if !polygon.list().iter().all(|corner| corner.depth + radius <= most) {
        return Some(());
    }
    let inside = outlines.inside();
    corners.extend(polygon.list().iter().map(|corner| {
        let at = DVec2::from_array(corner.at);
        Corner::new(at, outlines.heights(corner), outlines.features(corner)).inside(inside)
    }));
    Some(())
}

#[cfg(test)]
mod tests;
