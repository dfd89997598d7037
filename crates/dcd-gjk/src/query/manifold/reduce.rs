//! Four corners that stand for all.

use dcd_geom::glam::DVec2;

/// What can be a point of a manifold.
pub(super) trait Spot {
    /// Where, in the plane square to the normal.
    fn at(&self) -> DVec2;
    /// Negative where the objects are apart.
    fn depth(&self) -> f64;
}

/// By index: the deepest; the farthest from it; the one that spans the largest triangle with both; and the
/// one that adds the most on the other side of the triangle. Fewer where there are fewer; of corners that
/// are in line, but for `near`, the deepest and the ends. The first among equals.
///
/// `None` of no corners.
pub(super) fn to_four<S: Spot>(corners: &[S], near: f64) -> Option<([usize; 4], usize)> {
    if let [_] = corners {
        return Some(([0; 4], 1));
    }
    let first = most(corners, S::depth)?;
    let deepest = corners[first].at();
    let mut kept = [first; 4];
    if let [p, q] = corners {
        // In line: the ends.
        kept[1] = 1 - first;
        return Some((kept, 1 + usize::from(p.at().distance(q.at()) > near)));
    }
    let from = |corner: &S| corner.at() - deepest;
    let second = most(corners, |corner| from(corner).length_squared())?;
    let base = from(&corners[second]);
    let off_line = |corner: &S| base.perp_dot(from(corner));
    let level = near * base.length();
    if corners.iter().all(|corner| off_line(corner).abs() <= level) {
        let mut count = 1;
        let end = most(corners, |corner| (corner.at() - corners[second].at()).length_squared())?;
        for corner in [second, end] {
            if corners[corner].at().distance(deepest) > near {
                kept[count] = corner;
                count += 1;
            }
        }
        return Some((kept, count));
    }
    if corners.len() <= 4 {
        let others = (0..corners.len()).filter(|&corner| corners[corner].at() != deepest);
        let mut count = 1;
        for (slot, corner) in kept[1..].iter_mut().zip(others) {
            *slot = corner;
            count += 1;
        }
        return Some((kept, count));
    }
    let mut count = 2;
    kept[1] = second;
    for side in [1.0, -1.0] {
        if let Some(corner) = most(corners, |corner| side * off_line(corner))
            && side * off_line(&corners[corner]) > level
        {
            kept[count] = corner;
            count += 1;
        }
    }
    Some((kept, count))
}

/// The first among equals.
fn most<S>(corners: &[S], value: impl Fn(&S) -> f64) -> Option<usize> {
    let mut best = (value(corners.first()?), 0);
    for (k, corner) in corners.iter().enumerate().skip(1) {
        let value = value(corner);
        if value > best.0 {
            best = (value, k);
        }
    }
    Some(best.1)
}
