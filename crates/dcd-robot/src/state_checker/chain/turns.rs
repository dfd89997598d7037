//! Frames of sixteen states, or of one, moved by what moves a joint, in f32.

// In kernels: an iterator that is left out of line costs more than the loop.
#![allow(clippy::needless_range_loop)]

use super::{Column, Sign};
use crate::state_checker::numbers::Numbers;
use dcd_simd::Row;

#[inline(always)]
pub(in super::super) fn loaded<L: Numbers>(l: L, rows: &[Row; 12]) -> [L::F; 12] {
    let mut frame = [l.splat(0.0); 12];
    for k in 0..12 {
        frame[k] = l.load(&rows[k]);
    }
    frame
}

/// Number by number: a slice would be copied by a call.
#[inline(always)]
pub(super) fn set_column<F: Copy>(frame: &mut [F; 12], k: usize, [x, y, z]: [F; 3]) {
    (frame[3 * k], frame[3 * k + 1], frame[3 * k + 2]) = (x, y, z);
}

/// The frame's rotation times a column.
#[inline(always)]
pub(super) fn turned<L: Numbers>(l: L, frame: &[L::F; 12], column: &Column) -> [L::F; 3] {
    let mut result = [l.splat(0.0); 3];
    match *column {
        Column::Of(k, sign) => {
            for axis in 0..3 {
                let number = frame[3 * k + axis];
                result[axis] = if sign == Sign::Plus { number } else { l.neg(number) };
            }
        }
        Column::Mixed(numbers) => {
            for k in 0..3 {
                if numbers[k] != 0.0 {
                    let number = l.splat(numbers[k]);
                    for axis in 0..3 {
                        result[axis] = l.mul_add(frame[3 * k + axis], number, result[axis]);
                    }
                }
            }
        }
    }
    result
}

/// Adds the parent's rotation times a vector to a frame's translation.
#[inline(always)]
pub(super) fn shift<L: Numbers>(l: L, parent: &[L::F; 12], by: [f32; 3], frame: &mut [L::F; 12]) {
    for k in 0..3 {
        if by[k] != 0.0 {
            let far = l.splat(by[k]);
            for axis in 0..3 {
                frame[9 + axis] = l.mul_add(parent[3 * k + axis], far, frame[9 + axis]);
            }
        }
    }
}

/// Turns a frame about an axis of its own: the other two columns are mixed.
#[inline(always)]
pub(super) fn turn_about<L: Numbers>(
    l: L,
    (axis, sign): (usize, Sign),
    [sin, cos]: [L::F; 2],
    frame: &mut [L::F; 12],
) {
    let sin = if sign == Sign::Plus { sin } else { l.neg(sin) };
    // Written out, so that no number of the frame has an index that is known at run time alone.
    match axis {
        0 => mix::<L, 3, 6>(l, [sin, cos], frame),
        1 => mix::<L, 6, 0>(l, [sin, cos], frame),
        _ => mix::<L, 0, 3>(l, [sin, cos], frame),
    }
}

#[inline(always)]
fn mix<L: Numbers, const U: usize, const V: usize>(
    l: L,
    [sin, cos]: [L::F; 2],
    frame: &mut [L::F; 12],
) {
    for k in 0..3 {
        let (u, v) = (frame[U + k], frame[V + k]);
        frame[U + k] = l.mul_add(u, cos, l.mul(v, sin));
        frame[V + k] = l.sub(l.mul(v, cos), l.mul(u, sin));
    }
}

/// Turns a frame by a rotation, column by column.
#[inline(always)]
pub(super) fn turn<L: Numbers>(l: L, rotation: &[L::F; 9], frame: &mut [L::F; 12]) {
    let rest = *frame;
    for column in 0..3 {
        for axis in 0..3 {
            let sum = l.mul(rest[axis], rotation[3 * column]);
            let sum = l.mul_add(rest[3 + axis], rotation[3 * column + 1], sum);
            frame[3 * column + axis] = l.mul_add(rest[6 + axis], rotation[3 * column + 2], sum);
        }
    }
}

/// The rotation about an axis of unit length, by columns.
#[inline(always)]
pub(super) fn rotation<L: Numbers>(l: L, [x, y, z]: [f32; 3], [sin, cos]: [L::F; 2]) -> [L::F; 9] {
    let versine = l.sub(l.splat(1.0), cos);
    let axis = [x, y, z];
    let mut result = [cos; 9];
    for i in 0..3 {
        let along = l.mul(l.splat(axis[i]), versine);
        for j in 0..3 {
            let start = if i == j { cos } else { l.splat(0.0) };
            result[3 * i + j] = l.mul_add(l.splat(axis[j]), along, start);
        }
    }
    let (x, y, z) = (l.mul(l.splat(x), sin), l.mul(l.splat(y), sin), l.mul(l.splat(z), sin));
    result[1] = l.add(result[1], z);
    result[2] = l.sub(result[2], y);
    result[3] = l.sub(result[3], z);
    result[5] = l.add(result[5], x);
    result[6] = l.add(result[6], y);
    result[7] = l.sub(result[7], x);
    result
}
