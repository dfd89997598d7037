//! A plane's height as a function on a body: n·x − d pulled back from the plane's frame through the joints.

use super::cell::{Cell, Core, Piece, Placement};
use super::interval::Interval;
use super::jet::Jet;
use super::lines::MotionLine;
use super::path::Path;
use super::slerp::Slerp;

/// x ↦ row·x + offset, both of which depend on t.
#[derive(Clone, Copy)]
pub(super) struct Functional {
    row: [Jet; 3],
    offset: Jet,
}

/// An edge in its cell.
pub(super) struct Motion<'a> {
    pub(super) cell: &'a Cell,
    pub(super) path: &'a Path,
    /// For each joint that a quaternion turns its way.
    pub(super) slerps: Vec<Option<Slerp>>,
}

fn dot(row: &[Jet; 3], v: &[Interval; 3]) -> Jet {
    (0..3).fold(Jet::ZERO, |sum, k| sum.add(row[k].scale(v[k])))
}

impl Functional {
    pub(super) fn new(normal: [f64; 3], offset: Jet) -> Self {
        Self { row: normal.map(|x| Jet::constant(Interval::point(x))), offset }
    }

    /// Its value at R·x + t.
    fn placed(self, placement: &Placement) -> Self {
        let column = |k: usize| [0, 1, 2].map(|i| placement.rows[i][k]);
        Self {
            offset: self.offset.add(dot(&self.row, &placement.t)),
            row: [0, 1, 2].map(|k| dot(&self.row, &column(k))),
        }
    }

    fn turned(self, rows: &[[Jet; 3]; 3]) -> Self {
        let entry =
            |k: usize| (0..3).fold(Jet::ZERO, |sum, i| sum.add(self.row[i].mul(rows[i][k])));
        Self { row: [0, 1, 2].map(entry), ..self }
    }

    fn slid(self, axis: [f64; 3], by: Jet) -> Self {
        let along = dot(&self.row, &axis.map(Interval::point));
        Self { offset: self.offset.add(along.mul(by)), ..self }
    }
}

/// I + K·sin + K²·(1 − cos), K the matrix of the cross product with the axis.
fn rotation(axis: [f64; 3], angle: Jet) -> [[Jet; 3]; 3] {
    let [sin, cos] = angle.sin_cos();
    let versine = Jet::constant(Interval::ONE).sub(cos);
    let a = axis.map(Interval::point);
    let square = a.iter().fold(Interval::ZERO, |sum, x| sum.add(x.square()));
    // K² = a·aᵀ − |a|²·I.
    let entry = |i: usize, j: usize| {
        let of_square = a[i].mul(a[j]).sub(if i == j { square } else { Interval::ZERO });
        let of_cross = match (j + 3 - i) % 3 {
            1 => a[3 - i - j].neg(),
            2 => a[3 - i - j],
            _ => Interval::ZERO,
        };
        let identity = if i == j { Interval::ONE } else { Interval::ZERO };
        Jet::constant(identity).add(sin.scale(of_cross)).add(versine.scale(of_square))
    };
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| entry(i, j)))
}

impl Motion<'_> {
    /// A functional of the frame from which joints, the last first, lead to a link, on that link.
    pub(super) fn on_link(&self, mut of: Functional, joints: &[usize], t: Interval) -> Functional {
        for &index in joints.iter().rev() {
            let joint = &self.cell.joints[index];
            of = of.placed(&joint.origin);
            let drive = |value: usize, factor: f64, offset: f64| {
                let moved = self.path.value(value, t).scale(Interval::point(factor));
                moved.add(Jet::constant(Interval::point(offset)))
            };
            of = match joint.motion {
                MotionLine::Fixed => of,
                MotionLine::Turns { axis, value, factor, offset } => {
                    of.turned(&rotation(axis, drive(value, factor, offset)))
                }
                MotionLine::Slides { axis, value, factor, offset } => {
                    of.slid(axis, drive(value, factor, offset))
                }
                MotionLine::Orients { .. } => match &self.slerps[index] {
                    Some(slerp) => of.turned(&slerp.rotation(t)),
                    None => of,
                },
            };
        }
        of
    }

    /// A functional of the world on the root link.
    pub(super) fn on_root(&self, of: Functional) -> Functional {
        of.placed(&self.cell.base)
    }
}

/// What is known of a functional on an interval of t: where it would be at both ends if it kept its speed at a middle, and
/// how much its second derivative adds at most.
pub(super) struct Bounds {
    ends: [([Interval; 3], Interval); 2],
    row: [Interval; 3],
    offset: Interval,
}

impl Bounds {
    /// From what it is at the middle of an interval of t and over all of it.
    pub(super) fn new(middle: &Functional, all: &Functional, ends: [Interval; 2]) -> Self {
        let far = ends[0].magnitude().max(ends[1].magnitude());
        let half_square = Interval::point(far).square().mul(Interval::point(0.5));
        // From 0 up to that, times the second derivative.
        let added = Interval::new(0.0, half_square.hi);
        let at = |jet: &Jet, s: Interval| jet.value.add(jet.first.mul(s));
        Self {
            ends: ends.map(|s| (middle.row.map(|jet| at(&jet, s)), at(&middle.offset, s))),
            row: all.row.map(|jet| jet.second.mul(added)),
            offset: all.offset.second.mul(added),
        }
    }

    /// At least the largest value on a piece's core.
    pub(super) fn above(&self, piece: &Piece, points: &[[f64; 3]]) -> f64 {
        // A function of t that is linear, or the length of such, is largest at an end.
        let at_ends = |value: &dyn Fn(&[Interval; 3]) -> Interval, more: Interval| {
            let [a, b] = [0, 1].map(|k| {
                let (row, offset) = &self.ends[k];
                value(row).add(*offset).add(more).add(self.offset).hi
            });
            larger(a, b)
        };
        let of_point = |p: &[f64; 3]| {
            let value = |row: &[Interval; 3]| {
                (0..3).fold(Interval::ZERO, |sum, k| sum.add(row[k].mul(Interval::point(p[k]))))
            };
            at_ends(&value, value(&self.row))
        };
        match &piece.core {
            Core::Points(points) => points.iter().map(of_point).fold(f64::NEG_INFINITY, larger),
            Core::Triangle(corners) => {
                corners.iter().map(|&k| of_point(&points[k])).fold(f64::NEG_INFINITY, larger)
            }
            Core::Discs(discs) => {
                let of_disc = |&[z, radius]: &[f64; 2]| {
                    let value = |row: &[Interval; 3]| {
                        let across = row[0].square().add(row[1].square()).sqrt();
                        row[2].mul(Interval::point(z)).add(across.mul(Interval::point(radius)))
                    };
                    at_ends(&value, value(&self.row))
                };
                discs.iter().map(of_disc).fold(f64::NEG_INFINITY, larger)
            }
        }
    }
}

/// The larger of both, infinite where one is no number.
fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::INFINITY } else { a.max(b) }
}

impl Functional {
    /// On a piece that has a place of its own in the body.
    pub(super) fn on_piece(self, piece: &Piece) -> Self {
        piece.pose.as_ref().map_or(self, |pose| self.placed(pose))
    }

    /// On a body in its link, or in the world.
    pub(super) fn on_body(self, pose: &Placement) -> Self {
        self.placed(pose)
    }
}
