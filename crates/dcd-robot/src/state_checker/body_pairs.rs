//! Which bodies of a robot are checked against each other, a bit for each pair: lanes find many touching pairs, and the
//! scene's lists of ignored ones cost more than comparing the spheres.

/// Of more bodies the scene is asked. Larger: more memory, a bit for each pair. No effect on any answer.
const MOST: usize = 1024;

/// A bit for each pair of bodies.
#[derive(Clone, Debug, Default)]
pub(super) struct BodyPairs {
    count: usize,
    /// u64s of a body.
    row: usize,
    bits: Vec<u64>,
}

impl BodyPairs {
    /// Of so many bodies, where `allows` says whether two of them are checked; empty where there are too many.
    pub(super) fn of(bodies: usize, allows: impl Fn(u32, u32) -> bool) -> Self {
        if bodies > MOST {
            return Self::default();
        }
        let row = bodies.div_ceil(64);
        let mut bits = vec![0; bodies * row];
        for body in 0..bodies {
            for other in (0..bodies).filter(|&other| other != body) {
                if allows(body as u32, other as u32) {
                    bits[body * row + other / 64] |= 1 << (other % 64);
                }
            }
        }
        Self { count: bodies, row, bits }
    }

    /// Whether two different bodies are checked; `None` where it is not known.
    #[inline]
    pub(super) fn get(&self, body: u32, other: u32) -> Option<bool> {
        let (body, other) = (body as usize, other as usize);
        if body >= self.count || other >= self.count {
            return None;
        }
        Some(self.bits[body * self.row + other / 64] >> (other % 64) & 1 == 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pair_is_what_it_was_said_to_be_and_others_are_unknown() {
        let allows = |a: u32, b: u32| (a + b) % 5 > 1;
        for count in [0u32, 1, 63, 64, 65, 130] {
            let pairs = BodyPairs::of(count as usize, allows);
            for a in 0..count {
                for b in (0..count).filter(|&b| b != a) {
                    assert_eq!(pairs.get(a, b), Some(allows(a, b)), "{a} and {b} of {count}");
                }
            }
            assert_eq!((pairs.get(0, count), pairs.get(count, 0)), (None, None));
        }
        assert_eq!(BodyPairs::of(MOST + 1, allows).get(0, 1), None);
    }
}
