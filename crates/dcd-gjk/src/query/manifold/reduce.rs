//! Four corners that stand for all.

use super::clip::Corner;

/// The deepest; the farthest from it; the one that spans the largest triangle with both; and the
/// one that adds the most on the other side of the triangle. Fewer where there are fewer, or where
/// all are in line. The first among equals.
///
/// `None` of no corners.
pub(super) fn to_four(corners: &[Corner]) -> Option<([Corner; 4], usize)> {
    let deepest = most(corners, Corner::depth)?;
    let mut kept = [deepest; 4];
    if corners.len() <= 4 {
        let others = corners.iter().filter(|corner| corner.at != deepest.at);
        let mut count = 1;
        for (slot, corner) in kept[1..].iter_mut().zip(others) {
            *slot = *corner;
            count += 1;
        }
        return Some((kept, count));
    }
    let from = |corner: &Corner| corner.at - deepest.at;
    let second = most(corners, |corner| from(corner).length_squared())?;
    let base = from(&second);
    let beside = |corner: &Corner| base.perp_dot(from(corner));
    let mut count = 2;
    kept[1] = second;
    for side in [1.0, -1.0] {
        if let Some(corner) = most(corners, |corner| side * beside(corner))
            && side * beside(&corner) > 0.0
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
