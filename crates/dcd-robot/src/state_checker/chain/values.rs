//! What moves the joints of a state alone: its values side by side.

use super::Chain;
use crate::state_checker::link_frames::HALF;
use dcd_simd::{Lanes, WIDTH};

/// Which eight values of a state move joints, and how: of those that there are not, 0 times one that there is.
#[derive(Clone, Copy, Debug)]
struct Values {
    values: [usize; HALF],
    factors: [f64; HALF],
    offsets: [f64; HALF],
    /// The least that is too much, and the most that is too little.
    above: [f64; HALF],
    below: [f64; HALF],
}

/// How the values of a state are read into lanes, where these hold all of them.
#[derive(Clone, Debug, Default)]
pub(super) struct ValueRow {
    /// How many values a state has.
    count: usize,
    /// None, where the lanes do not hold them.
    halves: Vec<Values>,
}

impl ValueRow {
    /// Of a chain that is made but for this, of a robot whose states have so many values. The values that move nothing, which
    /// have to be numbers too, come behind the others.
    pub(super) fn of(chain: &Chain, count: usize) -> Self {
        let moving =
            chain.drives.iter().map(|&(by, most)| (by.value, [by.factor, by.offset], most));
        let idle = chain.idle.iter().map(|&value| (value, [1.0, 0.0], f64::MAX));
        let all: Vec<_> = moving.chain(idle).collect();
        let are_held = chain.is_bounded && chain.quaternions.is_empty() && all.len() <= WIDTH;
        if !are_held || all.is_empty() {
            return Self::default();
        }
        let of_few = |few: &[(usize, [f64; 2], f64)]| {
            let mut row = Values {
                values: [0; HALF],
                factors: [0.0; HALF],
                offsets: [0.0; HALF],
                above: [1.0; HALF],
                below: [-1.0; HALF],
            };
            for (k, &(value, [factor, offset], most)) in few.iter().enumerate() {
                (row.values[k], row.factors[k], row.offsets[k]) = (value, factor, offset);
                (row.above[k], row.below[k]) = (most.next_up(), (-most).next_down());
            }
            row
        };
        Self { count, halves: all.chunks(HALF).map(of_few).collect() }
    }
}

impl Chain {
    /// Takes what moves the joints in a state, which [`Chain::read`] takes number by number and rounds alike. `None` for what
    /// that leaves, and where the lanes do not hold all.
    #[inline(always)]
    pub(in super::super) fn read_alone<L: Lanes>(&self, l: L, state: &[f64]) -> Option<L::F> {
        let ValueRow { count, halves } = &self.values;
        if state.len() != *count || halves.is_empty() {
            return None;
        }
        let (mut numbers, mut known) = ([[0.0; HALF]; 2], (1 << HALF) - 1);
        for (half, numbers) in halves.iter().zip(&mut numbers) {
            // Number by number in registers: what is stored and then loaded together is waited for.
            let values = half.values;
            let values = [
                state[values[0]],
                state[values[1]],
                state[values[2]],
                state[values[3]],
                state[values[4]],
                state[values[5]],
                state[values[6]],
                state[values[7]],
            ];
            let scaled = l.mul_d(l.load_d(&values), l.load_d(&half.factors));
            let moved = l.add_d(scaled, l.load_d(&half.offsets));
            // Written so that a NaN is not known.
            known &= l.lt_d(moved, l.load_d(&half.above)) & l.lt_d(l.load_d(&half.below), moved);
            l.store_d(moved, numbers);
        }
        (known == (1 << HALF) - 1).then(
            #[inline(always)]
            || l.round_from([&numbers[0], &numbers[1]]),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::state_checker::StateChecker;
    use crate::state_checker::chain::Drives;
    use crate::state_checker::tests::{robot, seeded, state};
    use crate::{AllowedPairs, Workcell, World};
    use dcd_simd::{Kernel, Path, Row, dispatch_on};

    /// A state's values side by side.
    struct Read<'a>(&'a Chain, &'a [f64]);

    impl Kernel for Read<'_> {
        type Output = Option<Row>;

        fn run<L: Lanes>(self, l: L) -> Option<Row> {
            let mut row = Row::default();
            l.store(self.0.read_alone(l, self.1)?, &mut row);
            Some(row)
        }
    }

    fn paths() -> impl Iterator<Item = Path> {
        Path::ALL.into_iter().filter(|path| path.is_available())
    }

    #[test]
    fn values_read_side_by_side_are_those_read_one_by_one() {
        let mut draw = seeded(47);
        let (mut taken, mut left) = (0, 0);
        for round in 0..60 {
            let robot = robot(&mut draw, round % 2 == 0);
            let cell = Workcell::new(robot, &World::default(), &AllowedPairs::default()).unwrap();
            let checker = StateChecker::new(cell).unwrap();
            let (chain, robot) = (&checker.prepared.chain, checker.cell().robot());
            let rest = state(&mut draw, robot);
            let mut states = vec![rest.clone(), [&rest[..], &[0.0]].concat()];
            if !rest.is_empty() {
                states.push(rest[1..].to_vec());
            }
            let odd =
                [f64::NAN, f64::INFINITY, -f64::INFINITY, f64::MAX, 8.0, -8.0, 8.1, -8.1, 2e6];
            for (value, number) in (0..rest.len()).flat_map(|k| odd.map(|number| (k, number))) {
                let mut state = rest.clone();
                state[value] = number;
                states.push(state);
            }
            for path in paths() {
                for state in &states {
                    let mut drives = Drives::default();
                    let is_known = chain.read(robot, &[state], &mut drives) == 0;
                    let is_held = !chain.values.halves.is_empty();
                    let expected = (is_known && is_held).then(|| drives.alone(0).0);
                    let found = dispatch_on(path, Read(chain, state));
                    // The values that move nothing come behind the others.
                    let moving = chain.drives.len().min(WIDTH);
                    let bits = |row: [f32; WIDTH]| row.map(f32::to_bits)[..moving].to_vec();
                    assert_eq!(found.map(|row| bits(row.0)), expected.map(bits), "{state:?}");
                    *(if found.is_some() { &mut taken } else { &mut left }) += 1;
                }
            }
        }
        println!("{taken} taken, {left} left");
        let least = 150 * paths().count();
        assert!(taken > least && left > least);
    }
}
