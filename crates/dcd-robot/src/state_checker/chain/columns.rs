//! The links of one state: the operations of sixteen states, each rounded alike, with a column of a frame in a register
//! where they have a number of sixteen frames.

// In kernels: an iterator that is left out of line costs more than the loop.
#![allow(clippy::needless_range_loop)]

use super::turns::rotation;
use super::{Chain, Column, Drives, Moves, Quarter, Sign, Step};
use crate::state_checker::numbers::{Numbers, One};
use dcd_simd::{Lanes, Row, WIDTH};
use glam::Vec4;

/// A frame by columns: the rotation's, then the translation. The fourth numbers mean nothing.
type Columns = [Vec4; 4];

impl Chain {
    /// Places the links of a state alone: `to` has a frame for each, and whole sixteens. Returns what all joints slide together,
    /// metres.
    #[inline(always)]
    pub(in super::super) fn place_alone<L: Lanes>(
        &self,
        l: One<'_, L>,
        drives: &Drives,
        to: &mut Vec<Row>,
    ) -> f32 {
        let count = self.frames.next_multiple_of(WIDTH);
        if to.len() != count {
            to.resize(count, Row::default());
        }
        let (axes, at) = (self.base.rotation, self.base.translation);
        let column = |k: usize| axes.col(k).as_vec3().extend(0.0);
        // What was placed last stays in registers: most often it is the next one's parent, and each step waits for the one
        // before it.
        let mut last = self.root;
        let mut held = [column(0), column(1), column(2), at.as_vec3().extend(0.0)];
        to[last] = stored(&held);
        let mut slid = 0.0;
        for step in &self.steps {
            let [x, y, z, at] = if step.parent == last { held } else { loaded(&to[step.parent]) };
            let at = shifted::<L>([x, y, z], step, at);
            let axes = match (step.quarter, &step.turned) {
                (Some(Quarter::X(Sign::Plus)), _) => [x, z, -y],
                (Some(Quarter::X(Sign::Minus)), _) => [x, -z, y],
                (Some(Quarter::Y(Sign::Plus)), _) => [-z, y, x],
                (Some(Quarter::Y(Sign::Minus)), _) => [z, y, -x],
                (Some(Quarter::Z(Sign::Plus)), _) => [y, -x, z],
                (Some(Quarter::Z(Sign::Minus)), _) => [-y, x, z],
                (None, Some([a, b, c])) => {
                    let axes = [x, y, z];
                    [turned::<L>(axes, a), turned::<L>(axes, b), turned::<L>(axes, c)]
                }
                (None, None) => [x, y, z],
            };
            held = match step.moves {
                Moves::Never => [axes[0], axes[1], axes[2], at],
                Moves::About(axis, sign, row) => {
                    let [sin, cos] = l.sin_cos(&drives.rows, row);
                    let sin = if sign == Sign::Plus { sin } else { -sin };
                    let [x, y, z] = axes;
                    match axis {
                        0 => {
                            let [y, z] = mixed::<L>([y, z], [sin, cos]);
                            [x, y, z, at]
                        }
                        1 => {
                            let [z, x] = mixed::<L>([z, x], [sin, cos]);
                            [x, y, z, at]
                        }
                        _ => {
                            let [x, y] = mixed::<L>([x, y], [sin, cos]);
                            [x, y, z, at]
                        }
                    }
                }
                Moves::Turns(axis, row) => {
                    let turn = rotation(l, axis, l.sin_cos(&drives.rows, row));
                    turned_by::<L>(axes, at, &turn)
                }
                Moves::Slides(axis, row) => {
                    let far = l.load(&drives.rows[row]);
                    slid += far.abs();
                    let by = [axis[0] * far, axis[1] * far, axis[2] * far];
                    let mut at = at;
                    for k in 0..3 {
                        if axis[k] != 0.0 {
                            at = mul_add::<L>(axes[k], by[k], at);
                        }
                    }
                    [axes[0], axes[1], axes[2], at]
                }
                Moves::Orients(number) => {
                    let mut turn = [0.0; 9];
                    for k in 0..9 {
                        turn[k] = l.load(&drives.turns[number][k]);
                    }
                    turned_by::<L>(axes, at, &turn)
                }
            };
            last = step.child;
            to[last] = stored(&held);
        }
        slid
    }
}

/// A frame in memory, column by column.
#[inline(always)]
fn stored(columns: &Columns) -> Row {
    let mut row = Row([0.0; WIDTH]);
    for k in 0..4 {
        columns[k].write_to_slice(&mut row.0[4 * k..]);
    }
    row
}

#[inline(always)]
fn loaded(Row(numbers): &Row) -> Columns {
    [0, 4, 8, 12].map(|first| Vec4::from_slice(&numbers[first..]))
}

/// a·b + c, rounded as the lanes do. Written out: a closure is left out of line, without their instructions.
#[inline(always)]
fn mul_add<L: Lanes>(a: Vec4, b: f32, c: Vec4) -> Vec4 {
    if L::FUSED {
        let ([x, y, z, w], c) = (a.to_array(), c.to_array());
        Vec4::new(x.mul_add(b, c[0]), y.mul_add(b, c[1]), z.mul_add(b, c[2]), w.mul_add(b, c[3]))
    } else {
        a * b + c
    }
}

/// What is at `at`, moved along the parent's axes to where a step's link is: those of 0 are left out.
#[inline(always)]
fn shifted<L: Lanes>(axes: [Vec4; 3], step: &Step, mut at: Vec4) -> Vec4 {
    for k in 0..3 {
        if step.along >> k & 1 == 1 {
            at = mul_add::<L>(axes[k], step.by[k], at);
        }
    }
    at
}

/// What is at `at`, moved along the axes: those of 0 are left out.
#[inline(always)]
fn moved<L: Lanes>(axes: [Vec4; 3], by: [f32; 3], mut at: Vec4) -> Vec4 {
    for k in 0..3 {
        if by[k] != 0.0 {
            at = mul_add::<L>(axes[k], by[k], at);
        }
    }
    at
}

/// The rotation times a column.
#[inline(always)]
fn turned<L: Lanes>(axes: [Vec4; 3], column: &Column) -> Vec4 {
    match *column {
        Column::Of(k, sign) => {
            let axis = match k {
                0 => axes[0],
                1 => axes[1],
                _ => axes[2],
            };
            if sign == Sign::Plus { axis } else { -axis }
        }
        Column::Mixed(numbers) => moved::<L>(axes, numbers, Vec4::ZERO),
    }
}

/// Two columns turned about the third.
#[inline(always)]
fn mixed<L: Lanes>([u, v]: [Vec4; 2], [sin, cos]: [f32; 2]) -> [Vec4; 2] {
    [mul_add::<L>(u, cos, v * sin), v * cos - u * sin]
}

/// A frame turned by a rotation, column by column.
#[inline(always)]
fn turned_by<L: Lanes>(axes: [Vec4; 3], at: Vec4, turn: &[f32; 9]) -> Columns {
    let mut columns = [at; 4];
    for k in 0..3 {
        let sum = mul_add::<L>(axes[1], turn[3 * k + 1], axes[0] * turn[3 * k]);
        columns[k] = mul_add::<L>(axes[2], turn[3 * k + 2], sum);
    }
    columns
}
