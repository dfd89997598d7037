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
            held = if step.way < OTHER {
                let (axes, sines) = ([x, y, z], l.first_sin_cos(step.row()));
                turned_in_place::<L>(step.way, (axes, at), signed(sines, step.moves))
            } else {
                let axes = at_rest::<L>([x, y, z], step);
                moved_by(l, (axes, at), (step.moves, drives), &mut slid)
            };
            last = step.child;
            to[last] = stored(&held);
        }
        slid
    }
}

/// The way of what turns about no axis of its frame, or is turned at rest by anything but a right angle.
const OTHER: u8 = 21;

/// Which way a step is taken: below [`OTHER`] the axis that it turns about, three times which right angle comes first.
pub(super) fn way(turned: Option<&[Column; 3]>, moves: &Moves) -> u8 {
    let quarter = turned.and_then(Quarter::of);
    let at_rest = match quarter {
        None => 0,
        Some(Quarter::X(Sign::Plus)) => 1,
        Some(Quarter::X(Sign::Minus)) => 2,
        Some(Quarter::Y(Sign::Plus)) => 3,
        Some(Quarter::Y(Sign::Minus)) => 4,
        Some(Quarter::Z(Sign::Plus)) => 5,
        Some(Quarter::Z(Sign::Minus)) => 6,
    };
    match *moves {
        Moves::About(axis, _, row) if row < WIDTH && turned.is_some() == quarter.is_some() => {
            3 * at_rest + axis as u8
        }
        _ => OTHER,
    }
}

impl Step {
    /// The row of what turns about an axis of its frame.
    #[inline(always)]
    fn row(&self) -> usize {
        if let Moves::About(_, _, row) = self.moves { row } else { 0 }
    }
}

/// A frame after a way: each of them has its columns in registers that the compiler knows, where one after the other, first
/// the right angle, then the axis, would move them about.
#[inline(always)]
fn turned_in_place<L: Lanes>(
    way: u8,
    ([x, y, z], at): ([Vec4; 3], Vec4),
    sines: [f32; 2],
) -> Columns {
    macro_rules! about {
        ($axes:expr, $axis:expr) => {{
            let [x, y, z] = turned_about::<L>($axes, $axis, sines);
            [x, y, z, at]
        }};
    }
    match way {
        0 => about!([x, y, z], 0),
        1 => about!([x, y, z], 1),
        2 => about!([x, y, z], 2),
        3 => about!([x, z, -y], 0),
        4 => about!([x, z, -y], 1),
        5 => about!([x, z, -y], 2),
        6 => about!([x, -z, y], 0),
        7 => about!([x, -z, y], 1),
        8 => about!([x, -z, y], 2),
        9 => about!([-z, y, x], 0),
        10 => about!([-z, y, x], 1),
        11 => about!([-z, y, x], 2),
        12 => about!([z, y, -x], 0),
        13 => about!([z, y, -x], 1),
        14 => about!([z, y, -x], 2),
        15 => about!([y, -x, z], 0),
        16 => about!([y, -x, z], 1),
        17 => about!([y, -x, z], 2),
        18 => about!([-y, x, z], 0),
        19 => about!([-y, x, z], 1),
        _ => about!([-y, x, z], 2),
    }
}

/// The columns of a frame turned about one of them.
#[inline(always)]
fn turned_about<L: Lanes>([x, y, z]: [Vec4; 3], axis: usize, sines: [f32; 2]) -> [Vec4; 3] {
    match axis {
        0 => {
            let [y, z] = mixed::<L>([y, z], sines);
            [x, y, z]
        }
        1 => {
            let [z, x] = mixed::<L>([z, x], sines);
            [x, y, z]
        }
        _ => {
            let [x, y] = mixed::<L>([x, y], sines);
            [x, y, z]
        }
    }
}

/// The sine and the cosine of what turns about an axis or its negative.
#[inline(always)]
fn signed([sin, cos]: [f32; 2], moves: Moves) -> [f32; 2] {
    let is_back = matches!(moves, Moves::About(_, Sign::Minus, _));
    [if is_back { -sin } else { sin }, cos]
}

/// The columns of a step's frame at rest.
#[inline(always)]
fn at_rest<L: Lanes>(axes: [Vec4; 3], step: &Step) -> [Vec4; 3] {
    let Some([a, b, c]) = &step.turned else { return axes };
    [turned::<L>(axes, a), turned::<L>(axes, b), turned::<L>(axes, c)]
}

/// A frame at rest, moved by what moves its joint.
#[inline(always)]
fn moved_by<L: Lanes>(
    l: One<'_, L>,
    (axes, mut at): ([Vec4; 3], Vec4),
    (moves, drives): (Moves, &Drives),
    slid: &mut f32,
) -> Columns {
    let mut columns = axes;
    match moves {
        Moves::Never => {}
        Moves::About(axis, _, row) => {
            columns = turned_about::<L>(axes, axis, signed(l.sin_cos(&drives.rows, row), moves));
        }
        Moves::Turns(axis, row) => {
            let turn = rotation(l, axis, l.sin_cos(&drives.rows, row));
            columns = turned_by::<L>(axes, &turn);
        }
        Moves::Slides(axis, row) => {
            let far = l.number(&drives.rows, row);
            *slid += far.abs();
            at = moved::<L>(axes, axis.map(|x| x * far), at, axis);
        }
        Moves::Orients(number) => {
            let mut turn = [0.0; 9];
            for k in 0..9 {
                turn[k] = l.load(&drives.turns[number][k]);
            }
            columns = turned_by::<L>(axes, &turn);
        }
    }
    [columns[0], columns[1], columns[2], at]
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

/// What is at `at`, moved along the axes: those of which `along` is 0 are left out.
#[inline(always)]
fn moved<L: Lanes>(axes: [Vec4; 3], by: [f32; 3], mut at: Vec4, along: [f32; 3]) -> Vec4 {
    for k in 0..3 {
        if along[k] != 0.0 {
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
        Column::Mixed(numbers) => moved::<L>(axes, numbers, Vec4::ZERO, numbers),
    }
}

/// Two columns turned about the third.
#[inline(always)]
fn mixed<L: Lanes>([u, v]: [Vec4; 2], [sin, cos]: [f32; 2]) -> [Vec4; 2] {
    [mul_add::<L>(u, cos, v * sin), v * cos - u * sin]
}

/// Columns turned by a rotation.
#[inline(always)]
fn turned_by<L: Lanes>(axes: [Vec4; 3], turn: &[f32; 9]) -> [Vec4; 3] {
    let mut columns = axes;
    for k in 0..3 {
        let sum = mul_add::<L>(axes[1], turn[3 * k + 1], axes[0] * turn[3 * k]);
        columns[k] = mul_add::<L>(axes[2], turn[3 * k + 2], sum);
    }
    columns
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::state_checker::StateChecker;
    use crate::state_checker::one_link::{LinkPlace, LinkPlaces};
    use crate::state_checker::places::{PlaceLinks, Places};
    use crate::state_checker::rounded_links::Rounded;
    use crate::state_checker::tests::seeded;
    use crate::{AllowedPairs, LinkShapes, Robot, Workcell, World};
    use dcd_simd::{Path, dispatch_on};
    use std::collections::BTreeSet;
    use std::f64::consts::FRAC_PI_2;

    /// Links one behind the other, each turned alike at rest and about another axis.
    fn arm(rpy: [f64; 3]) -> Robot {
        let link = |k: usize| {
            format!(
                "<link name=\"l{k}\"><collision><geometry><sphere radius=\"0.1\"/></geometry></collision></link>"
            )
        };
        let mut urdf = format!("<robot name=\"arm\">{}", link(0));
        let axes = ["1 0 0", "0 1 0", "0 0 1", "-1 0 0", "0 -1 0", "0 0 -1"];
        for (k, axis) in axes.into_iter().enumerate() {
            let [roll, pitch, yaw] = rpy;
            urdf += &link(k + 1);
            urdf += &format!(
                "<joint name=\"j{k}\" type=\"continuous\"><parent link=\"l{k}\"/><child link=\"l{}\"/>\
                 <origin xyz=\"0.3 0.2 -0.1\" rpy=\"{roll} {pitch} {yaw}\"/><axis xyz=\"{axis}\"/></joint>",
                k + 1
            );
        }
        urdf += "</robot>";
        Robot::read(&urdf, std::path::Path::new("."), LinkShapes::Hulls).unwrap()
    }

    #[test]
    fn a_state_alone_takes_every_way_as_it_does_among_others() {
        let mut draw = seeded(53);
        let mut ways = BTreeSet::new();
        let turns = (0..3).flat_map(|axis| [FRAC_PI_2, -FRAC_PI_2].map(|angle| (axis, angle)));
        for (axis, angle) in turns.chain([(0, 0.0)]) {
            let mut rpy = [0.0; 3];
            rpy[axis] = angle;
            let cell = Workcell::new(arm(rpy), &World::default(), &AllowedPairs::default());
            let checker = StateChecker::new(cell.unwrap()).unwrap();
            let prepared = &checker.prepared;
            ways.extend(prepared.chain.steps.iter().map(|step| step.way));
            let mut state = || [(); 6].map(|()| draw.next() * 3.0);
            let states: [[f64; 6]; 2] = [state(), state()];
            let both = states.each_ref().map(|state| &state[..]);
            for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
                let mut places = Places::default();
                places.read(prepared, &both).unwrap();
                let (links, rows) = (&*prepared.world_links, &*prepared.world_rows);
                let mut rounded = Rounded::default();
                for open in [0b11, 0b01] {
                    let placed = places.placed(prepared);
                    let to = &mut rounded;
                    dispatch_on(path, PlaceLinks { placed, open, links, rows, to });
                }
                for link in 0..links.len() {
                    let (alone, among) =
                        (rounded.one.world().at(link), (&*rounded.world, 0).at(link));
                    let bits = |number: f32| number.to_bits();
                    for k in 0..12 {
                        let both = [alone.number(k), among.number(k)].map(bits);
                        assert_eq!(both[0], both[1], "{path:?}, {rpy:?}, link {link}, number {k}");
                    }
                }
            }
        }
        assert!(ways.into_iter().eq(0..OTHER));
    }
}
