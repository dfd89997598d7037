//! The distance of two cores of which only one below a limit matters.

use super::approach::approach_from;
use super::{Distance, unit};
use crate::certificate::Bounds;
use crate::gjk::Simplex;
use crate::supports::InBlocks;
use crate::{Difference, PosedSupport};
use dcd_geom::glam::DVec3;

/// What is known of two swept cores.
pub(crate) enum Nearer {
    /// How far apart they are.
    Apart(Distance),
    /// Proved at least so far apart as the limit; a direction along which they are, from the first to the second, of unit
    /// length but for rounding.
    Beyond(DVec3),
    Touching,
    /// f64 proves neither.
    Unknown,
}

/// The distance with bounds that are at most about `gap` apart, metres; the search ends where it is at least `limit`.
pub(crate) fn nearer<A: InBlocks, B: InBlocks>(
    a: PosedSupport<'_, A>,
    b: PosedSupport<'_, B>,
    [gap, limit]: [f64; 2],
) -> Nearer {
    let Some(difference) = Difference::new(a, b) else { return Nearer::Unknown };
    let (bounds, scale) = (Bounds::of(&difference), difference.scale());
    let swept = bounds.swept_upper();
    let enough = limit * scale + swept;
    match approach_from(&difference, &bounds, [gap * scale, enough], Simplex::default()) {
        Ok(near) if near.lower > swept && near.lower >= enough => {
            Nearer::Beyond(unit(-near.direction))
        }
        Ok(near) if near.lower > swept => Nearer::Apart(near.distance(&bounds, scale, (a, b))),
        Err(crate::Verdict::Touching(())) => Nearer::Touching,
        Ok(near) if bounds.proves_swept_touching(near.length) => Nearer::Touching,
        _ => Nearer::Unknown,
    }
}
