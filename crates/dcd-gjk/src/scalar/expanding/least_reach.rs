//! The direction in which some pieces of A − B reach least: Newton's method, from where a search has come.
//!
//! Along a unit direction n each piece j reaches h_j, with its farthest point g_j and second derivatives M_j. On the sphere of
//! directions their largest is least where a combination of the g_j of one piece, or of two that reach as far, is along n. What
//! comes out is a proposal: [`local_bound`](super::local_bound) proves it.

use super::pieces::{Piece, Seen};
use dcd_geom::glam::{DMat2, DVec2, DVec3};
use dcd_simd::ArrayVec;

/// Of how many pieces at most.
pub(super) const MOST: usize = 6;

/// How often the direction is corrected at most; four are usual. Fewer: proposals that are not proved, and the search goes on.
const STEPS: usize = 10;

/// The slope that is none, lengths below 1: how far the witnesses are beside each other as seen along the normal, and how much
/// farther one piece reaches than the other. Larger: the same. Smaller: steps for rounding.
const SETTLED: f64 = 1e-12;

/// The slope that is good enough where a step more does not lessen it: a disc that is seen nearly along its axis turns what rounding
/// does to a direction into a million times as much. Larger: witnesses beside each other.
const HARDLY: f64 = 1e-10;

/// How far apart the farthest points of two pieces must be, lengths below 1. Smaller: pieces that only rounding tells apart.
const LEVEL: f64 = 1e-8;

/// The largest correction, radians. Larger: steps beyond where the derivatives say anything.
const LARGEST: f64 = 0.5;

/// The pieces that reach farthest there, one or two, with their weights.
#[derive(Clone, Copy)]
pub(super) struct Least {
    /// Of unit length.
    pub(super) normal: DVec3,
    /// The same piece twice, where it is one.
    pub(super) seen: [Seen; 2],
    pub(super) weights: [f64; 2],
}

impl Least {
    /// How far both reach, by their weights.
    pub(super) fn reach(&self) -> f64 {
        let [s, t] = &self.seen;
        self.weights[0] * s.reach + self.weights[1] * t.reach
    }
}

/// A correction of the direction, and the two pieces that make it, with their weights.
struct Step {
    correction: DVec2,
    pieces: [usize; 2],
    /// Those before the correction, and the slope with them.
    weights: [f64; 2],
    slope: f64,
    /// How far the pieces are to reach after it.
    reach: f64,
}

/// A piece seen in the plane square to a direction.
#[derive(Clone, Copy, Default)]
struct Flat {
    reach: f64,
    first: DVec2,
    second: DMat2,
}

/// Where those pieces reach least, from a direction on; `None` where the steps lead nowhere.
pub(super) fn least(pieces: &[Piece], from: DVec3) -> Option<Least> {
    let mut normal = from.try_normalize()?;
    let mut last = f64::INFINITY;
    for _ in 0..STEPS {
        let mut seen = ArrayVec::<Seen, MOST>::new();
        for piece in pieces {
            seen.push(piece.seen(normal)?);
        }
        let (e, f) = normal.any_orthonormal_pair();
        let mut flat = ArrayVec::<Flat, MOST>::new();
        flat.extend(seen.iter().map(|seen| Flat::of(seen, [e, f])));
        let Step { correction, pieces: lead, weights, slope, .. } = best(&flat)?;
        if slope <= SETTLED || slope <= HARDLY && slope >= 0.5 * last {
            return Some(Least { normal, seen: lead.map(|k| seen[k]), weights });
        }
        if !(correction.length() <= LARGEST) {
            return None;
        }
        normal = (normal + e * correction.x + f * correction.y).normalize();
        last = slope;
    }
    None
}

impl Flat {
    fn of(seen: &Seen, [e, f]: [DVec3; 2]) -> Self {
        let mut second = DMat2::ZERO;
        for bend in &seen.bends {
            if bend.length > 0.0 {
                for across in bend.across {
                    let across = DVec2::new(across.dot(e), across.dot(f));
                    let scaled = across / bend.length;
                    second += DMat2::from_cols(across * scaled.x, across * scaled.y);
                }
            }
        }
        let first = DVec2::new(seen.point.dot(e), seen.point.dot(f));
        Self { reach: seen.reach, first, second }
    }

    /// Along n + t a piece reaches h + g·t + t·Mt/2, and that is longer than n by |t|²/2.
    fn on_sphere(&self, reach: f64) -> DMat2 {
        self.second - DMat2::from_diagonal(DVec2::splat(reach))
    }
}

/// Of the steps of one piece or two the one after which they reach most: no more of them is left out.
fn best(flat: &[Flat]) -> Option<Step> {
    let mut best: Option<Step> = None;
    let mut offer = |step: Option<Step>| {
        if let Some(step) = step
            && best.as_ref().is_none_or(|best| step.reach > best.reach)
        {
            best = Some(step);
        }
    };
    for (j, of_one) in flat.iter().enumerate() {
        offer(alone(of_one, j));
        for (k, other) in flat.iter().enumerate().skip(j + 1) {
            offer(together([of_one, other], [j, k]));
        }
    }
    best
}

/// `None` where the piece's reach is not least anywhere near.
fn alone(of: &Flat, number: usize) -> Option<Step> {
    let second = of.on_sphere(of.reach);
    // False for NaN.
    if !(second.x_axis.x > 0.0 && second.determinant() > 0.0) {
        return None;
    }
    let correction = -(second.inverse() * of.first);
    let reach = of.reach + 0.5 * of.first.dot(correction);
    let slope = of.first.length();
    Some(Step { correction, pieces: [number; 2], weights: [1.0, 0.0], slope, reach })
}

/// To where two pieces reach as far, and least along that line. `None` where one of them alone reaches less.
fn together([p, q]: [&Flat; 2], pieces: [usize; 2]) -> Option<Step> {
    let difference = p.first - q.first;
    let steep = difference.length();
    // False for NaN.
    if !(steep > LEVEL) {
        return None;
    }
    let e = difference / steep;
    let f = e.perp();
    let along_e = (q.reach - p.reach) / steep;
    let part = (-q.first.dot(e) / steep).clamp(0.0, 1.0);
    let reach = part * p.reach + (1.0 - part) * q.reach;
    let second = p.on_sphere(reach) * part + q.on_sphere(reach) * (1.0 - part);
    let (of_e, of_f) = (second * e, second * f);
    let bend = of_f.dot(f);
    if !(bend > 0.0) {
        return None;
    }
    let along_f = -(q.first.dot(f) + of_e.dot(f) * along_e) / bend;
    let correction = e * along_e + f * along_f;
    let after = -(q.first.dot(e) + (second * correction).dot(e)) / steep;
    if !(0.0..=1.0).contains(&after) {
        return None;
    }
    let slope = (p.first * part + q.first * (1.0 - part)).length() + (p.reach - q.reach).abs();
    let reach =
        p.reach + p.first.dot(correction) + 0.5 * correction.dot(p.on_sphere(reach) * correction);
    Some(Step { correction, pieces, weights: [part, 1.0 - part], slope, reach })
}
