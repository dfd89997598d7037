//! The values of a state along an edge.

use super::interval::Interval;
use super::jet::Jet;
use super::slerp::Slerp;

/// A Bézier curve of the values by its control points: two, or four.
pub(super) struct Path {
    control: Vec<Vec<f64>>,
}

impl Path {
    pub(super) fn new(control: Vec<Vec<f64>>, values: usize) -> Result<Self, String> {
        if control.len() != 2 && control.len() != 4 {
            return Err(format!("{} control points, not 2 or 4", control.len()));
        }
        if let Some(point) = control.iter().find(|point| point.len() != values) {
            return Err(format!("a control point of {} values, not {values}", point.len()));
        }
        match control.iter().flatten().find(|x| !x.is_finite()) {
            Some(x) => Err(format!("a control point has the value {x}")),
            None => Ok(Self { control }),
        }
    }

    /// A value of the state, by de Casteljau's scheme.
    pub(super) fn value(&self, index: usize, t: Interval) -> Jet {
        let mut points: Vec<Interval> =
            self.control.iter().map(|point| Interval::point(point[index])).collect();
        let degree = points.len() - 1;
        let between = |a: Interval, b: Interval| a.add(t.mul(b.sub(a)));
        // One level, two levels and three levels above the end: differences are derivatives.
        let mut jet = Jet::ZERO;
        for left in (0..=degree).rev() {
            let factor = |n: usize| Interval::point(n as f64);
            match left {
                2 => {
                    let change = points[2].sub(points[1]).sub(points[1].sub(points[0]));
                    jet.second = change.mul(factor(degree * (degree - 1)));
                }
                1 => jet.first = points[1].sub(points[0]).mul(factor(degree)),
                0 => jet.value = points[0],
                _ => {}
            }
            points = points.windows(2).map(|ends| between(ends[0], ends[1])).collect();
        }
        jet
    }

    /// The way of the quaternion whose numbers begin at `first`: the great circle's at constant speed, from the first
    /// control point to the last.
    pub(super) fn slerp(&self, first: usize) -> Result<Slerp, String> {
        let at = |point: &[f64]| [0, 1, 2, 3].map(|k| point[first + k]);
        let from = at(&self.control[0]);
        if self.control.iter().all(|point| at(point) == from) {
            return Slerp::still(from);
        }
        match &self.control[..] {
            [_, to] => Slerp::between(from, at(to)),
            _ => Err("a curve of quaternions".to_owned()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_and_its_derivatives_are_bernsteins() {
        let points = [0.3, -1.2, 2.5, 0.7];
        let path = Path::new(points.iter().map(|&x| vec![x]).collect(), 1).unwrap();
        for t in [0.0, 0.25, 0.7, 1.0] {
            let s: f64 = 1.0 - t;
            let [a, b, c, d] = points;
            let value = s * s * s * a + 3.0 * s * s * t * b + 3.0 * s * t * t * c + t * t * t * d;
            let first = 3.0 * (s * s * (b - a) + 2.0 * s * t * (c - b) + t * t * (d - c));
            let second = 6.0 * (s * (c - 2.0 * b + a) + t * (d - 2.0 * c + b));
            let jet = path.value(0, Interval::point(t));
            for (found, expected) in
                [jet.value, jet.first, jet.second].iter().zip([value, first, second])
            {
                assert!(
                    found.lo - 1e-13 < expected && expected < found.hi + 1e-13,
                    "{t}: {found:?} {expected}"
                );
                assert!(found.hi - found.lo < 1e-13, "{t}: {found:?}");
            }
        }
        let line = Path::new(vec![vec![1.0], vec![3.0]], 1).unwrap();
        let jet = line.value(0, Interval::new(0.25, 0.75));
        assert!(
            jet.value.lo <= 1.5
                && jet.value.hi >= 2.5
                && jet.first.lo <= 2.0
                && jet.first.hi >= 2.0
        );
        assert!(jet.second.magnitude() == 0.0);
    }
}
