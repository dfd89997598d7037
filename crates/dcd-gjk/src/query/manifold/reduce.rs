//! Four corners that stand for all.

use super::clip::Corner;

/// The deepest; the farthest from it; the one that spans the largest triangle with both; and the
/// one that adds the most on the other side of the triangle. Fewer where there are fewer; of corners that
/// are in line, but for `near`, the deepest and the ends. The first among equals.
///
/// `None` of no corners.
pub(super) fn to_four(corners: &[Corner], near: f64) -> Option<([Corner; 4], usize)> {
    let deepest = most(corners, Corner::depth)?;
    let mut kept = [deepest; 4];
    let from = |corner: &Corner| corner.at - deepest.at;
    let second = most(corners, |corner| from(corner).length_squared())?;
    let base = from(&second);
    let off_line = |corner: &Corner| base.perp_dot(from(corner));
    let level = near * base.length();
    if corners.iter().all(|corner| off_line(corner).abs() <= level) {
        let mut count = 1;
        let end = most(corners, |corner| (corner.at - second.at).length_squared())?;
        for corner in [second, end] {
            if corner.at.distance(deepest.at) > near {
                kept[count] = corner;
                count += 1;
            }
        }
        return Some((kept, count));
    }
    if corners.len() <= 4 {
        let others = corners.iter().filter(|corner| corner.at != deepest.at);
        let mut count = 1;
        for (slot, corner) in kept[1..].iter_mut().zip(others) {
            *slot = *corner;
            count += 1;
        }
        return Some((kept, count));
    }
    let mut count = 2;
    kept[1] = second;
    for side in [1.0, -1.0] {
        if let Some(corner) = most(corners, |corner| side * off_line(corner))
            && side * off_line(&corner) > level
        {
            kept[count] = corner;
            count += 1;
        }
    }
    Some((kept, count))
}

fn most(corners: &[Corner], value: impl Fn(&Corner) -> f64) -> Option<Corner> {
    let mut best: Option<(f64, Corner)> = None;
    for corner in corners {
        let value = value(corner);
        if best.is_none_or(|(most, _)| value > most) {
            best = Some((value, *corner));
        }
    }
    best.map(|(_, corner)| corner)
}
