//! A plane between two bodies on an interval of t.

use super::cell::Body;
use super::cover::Part;
use super::functional::{Bounds, Functional, Motion};
use super::interval::Interval;
use super::jet::Jet;
use std::ops::Range;

/// The plane n·x = d in a frame, d going evenly from its first value to its last; the first body is where n·x < d.
pub(super) struct Plane {
    pub(super) part: Part,
    normal: [f64; 3],
    offset: [f64; 2],
}

/// Intervals of t are not halved below this length: no proof.
const SHORTEST: f64 = 1.0 / (1u64 << 50) as f64;

impl Plane {
    /// From a row of its file: t₀, t₁, the normal, d at t₀ and at t₁; for some pieces alone, the first and the end of the first
    /// body's and of the second's.
    pub(super) fn new(row: &[f64], whole: &Part) -> Result<Self, String> {
        if let Some(x) = row.iter().find(|x| !x.is_finite()) {
            return Err(format!("a plane with the number {x}"));
        }
        let (plane, pieces) = match row.len() {
            7 => (row, whole.pieces.clone()),
            11 => {
                let at = |k: usize| {
                    let x = row[7 + k];
                    let all = whole.pieces[k / 2].end;
                    let is_whole = x >= 0.0 && x <= all as f64 && x.fract() == 0.0;
                    is_whole.then_some(x as usize).ok_or_else(|| format!("piece {x} of {all}"))
                };
                let pieces = [at(0)?..at(1)?, at(2)?..at(3)?];
                if pieces.iter().any(Range::is_empty) {
                    return Err(format!("a plane of no pieces: {pieces:?}"));
                }
                (&row[..7], pieces)
            }
            n => return Err(format!("a plane of {n} numbers")),
        };
        let &[from, to, x, y, z, first, last] = plane else { return Err("no plane".to_owned()) };
        if !(0.0 <= from && from < to && to <= 1.0) {
            return Err(format!("a plane for t from {from} to {to}"));
        }
        if [x, y, z] == [0.0; 3] {
            return Err("a plane without a normal".to_owned());
        }
        let part = Part { t: [from, to], pieces };
        Ok(Self { part, normal: [x, y, z], offset: [first, last] })
    }

    /// d on an interval of t, with its derivative.
    fn offset(&self, t: Interval) -> Jet {
        let [from, to] = self.part.t.map(Interval::point);
        let [first, last] = self.offset.map(Interval::point);
        let slope = last.sub(first).div(to.sub(from));
        let value = first.add(slope.mul(t.sub(from)));
        Jet { value, first: slope, second: Interval::ZERO }
    }
}

/// Two bodies and the frame that planes between them are given in.
pub(super) struct Sides<'a> {
    motion: &'a Motion<'a>,
    bodies: [&'a Body; 2],
    /// From the frame to each body's link; none for a body that stands still.
    chains: [Option<Vec<usize>>; 2],
    in_world: bool,
    /// At least how much longer a normal is in the world.
    stretch: Interval,
    /// How far either body must be from the plane at least, metres.
    apart: Interval,
}

impl<'a> Sides<'a> {
    pub(super) fn new(
        motion: &'a Motion<'a>,
        bodies: [&'a Body; 2],
        frame: Option<usize>,
        apart: Interval,
    ) -> Result<Self, String> {
        let chain = |body: &Body| match body.link {
            None if frame.is_none() => Ok(None),
            None => Err(format!("the plane moves with a link and {:?} does not", body.name)),
            Some(link) => match motion.cell.chain(link, frame) {
                Some(chain) => Ok(Some(chain)),
                None => Err(format!("{:?} does not move with the plane's link", body.name)),
            },
        };
        let chains = [chain(bodies[0])?, chain(bodies[1])?];
        let stretch = frame.map_or(Interval::ONE, |link| motion.cell.stretch[link]);
        Ok(Self { motion, bodies, chains, in_world: frame.is_none(), stretch, apart })
    }

    /// That both bodies are on their sides on all of the plane's interval.
    pub(super) fn hold(&self, plane: &Plane, left: &mut usize) -> Result<(), String> {
        (0..2).try_for_each(|side| self.holds(plane, side, left))
    }

    /// The height of a body over the plane, on its own side negative.
    fn height(&self, plane: &Plane, side: usize, t: Interval) -> Functional {
        let sign = if side == 0 { 1.0 } else { -1.0 };
        let normal = plane.normal.map(|x| sign * x);
        let offset = plane.offset(t).scale(Interval::point(-sign));
        let mut height = Functional::new(normal, offset);
        if let Some(chain) = &self.chains[side] {
            if self.in_world {
                height = self.motion.on_root(height);
            }
            height = self.motion.on_link(height, chain, t);
        }
        height.on_body(&self.bodies[side].pose)
    }

    fn holds(&self, plane: &Plane, side: usize, left: &mut usize) -> Result<(), String> {
        let mut open = vec![plane.part.t];
        while let Some([from, to]) = open.pop() {
            *left = left.checked_sub(1).ok_or("the budget of intervals is spent")?;
            if self.is_below(plane, side, [from, to]) {
                continue;
            }
            let middle = 0.5 * from + 0.5 * to;
            if !(from < middle && middle < to && to - from > SHORTEST) {
                let name = &self.bodies[side].name;
                return Err(format!("{name:?} is not proved beside its plane at t = {middle}"));
            }
            open.push([middle, to]);
            open.push([from, middle]);
        }
        Ok(())
    }

    /// Whether all of a body is proved on its side on an interval.
    fn is_below(&self, plane: &Plane, side: usize, [from, to]: [f64; 2]) -> bool {
        let body = self.bodies[side];
        let middle = 0.5 * from + 0.5 * to;
        let t = Interval::point(middle);
        let ends = [from, to].map(|end| Interval::point(end).sub(t));
        let at_middle = self.height(plane, side, t);
        let over_all = self.height(plane, side, Interval::new(from, to));
        let of_body = Bounds::new(&at_middle, &over_all, ends);
        let square =
            plane.normal.iter().fold(Interval::ZERO, |s, &x| s.add(Interval::point(x).square()));
        let length = square.sqrt().mul(self.stretch);
        body.pieces[plane.part.pieces[side].clone()].iter().all(|piece| {
            let bounds = piece
                .pose
                .as_ref()
                .map(|_| Bounds::new(&at_middle.on_piece(piece), &over_all.on_piece(piece), ends));
            let above = bounds.as_ref().unwrap_or(&of_body).above(piece, &body.points);
            let swept = piece.radius.add(self.apart).mul(length);
            // A sum that is no number is not below 0.
            Interval::point(above).add(swept).hi < 0.0
        })
    }
}
