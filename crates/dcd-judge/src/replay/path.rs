//! The values of a state along an edge.

use super::angle::sin_cos;
use super::interval::Interval;
use super::jet::Jet;

/// A Bézier curve of the values by its control points: two, or four.
pub(super) struct Path {
    control: Vec<Vec<f64>>,
}

/// The way of a unit quaternion x y z w.
pub(super) struct Slerp {
    from: [Interval; 4],
    /// Of unit length, at right angles to the first, and the angle between both ends, rad; none where nothing turns.
    way: Option<([Interval; 4], Interval)>,
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
        let at = |point: &Vec<f64>| [0, 1, 2, 3].map(|k| Interval::point(point[first + k]));
        let from = at(&self.control[0]);
        let same =
            self.control.iter().all(|p| p[first..first + 4] == self.control[0][first..first + 4]);
        if same {
            return Ok(Slerp { from: unit(from)?, way: None });
        }
        if self.control.len() != 2 {
            return Err("a curve of quaternions".to_owned());
        }
        let (from, to) = (unit(from)?, unit(at(&self.control[1]))?);
        let difference = [0, 1, 2, 3].map(|k| to[k].sub(from[k]));
        let chord = length(difference);
        // sin(angle / 2) = chord / 2, and both grow together up to half a turn.
        let half = half_angle(chord.mul(Interval::point(0.5)))?;
        let angle = half.mul(Interval::point(2.0));
        let [sin, cos] = sin_cos(angle);
        let any = Interval::within(1.0);
        let across = [0, 1, 2, 3].map(|k| to[k].sub(from[k].mul(cos)).div(sin).and(any));
        Ok(Slerp { from, way: Some((across, angle)) })
    }
}

fn length(q: [Interval; 4]) -> Interval {
    q.iter().fold(Interval::ZERO, |sum, x| sum.add(x.square())).sqrt()
}

fn unit(q: [Interval; 4]) -> Result<[Interval; 4], String> {
    let length = length(q);
    if !(length.lo > 0.999 && length.hi < 1.001) {
        return Err(format!("a quaternion of length {}", length.lo));
    }
    Ok(q.map(|x| x.div(length)))
}

/// The angle between 0 and a right one whose sine is in an interval: a guess that is then proved, from either side.
fn half_angle(sine: Interval) -> Result<Interval, String> {
    // Opposite quaternions have no one way between them.
    if !(sine.hi < 1.0 - 1e-7) {
        return Err("opposite quaternions".to_owned());
    }
    let widened = |sine: f64, outward: f64, is_proved: &dyn Fn(Interval) -> bool| {
        let guess = sine.clamp(0.0, 1.0).asin();
        let mut step = f64::EPSILON * outward * guess.max(1e-300);
        for _ in 0..60 {
            let angle = guess + step;
            if (0.0..=1.6).contains(&angle) && is_proved(sin_cos(Interval::point(angle))[0]) {
                return Some(angle);
            }
            step *= 2.0;
        }
        None
    };
    let lo = widened(sine.lo.max(0.0), -1.0, &|s| s.hi <= sine.lo).unwrap_or(0.0);
    let hi =
        widened(sine.hi, 1.0, &|s| s.lo >= sine.hi).ok_or("a quaternion's way is not enclosed")?;
    if hi > std::f64::consts::FRAC_PI_2 {
        return Err("opposite quaternions".to_owned());
    }
    Ok(Interval::new(lo, hi))
}

impl Slerp {
    /// The rotation's rows.
    pub(super) fn rotation(&self, t: Interval) -> [[Jet; 3]; 3] {
        let q = match &self.way {
            None => self.from.map(Jet::constant),
            Some((across, angle)) => {
                let value = t.mul(*angle);
                let angle = Jet { value, first: *angle, second: Interval::ZERO };
                let [sin, cos] = angle.sin_cos();
                [0, 1, 2, 3].map(|k| cos.scale(self.from[k]).add(sin.scale(across[k])))
            }
        };
        let [x, y, z, w] = q;
        let double = |a: Jet, b: Jet| a.mul(b).scale(Interval::point(2.0));
        let one = Jet::constant(Interval::ONE);
        let diagonal = |a: Jet, b: Jet| one.sub(double(a, a)).sub(double(b, b));
        [
            [diagonal(y, z), double(x, y).sub(double(z, w)), double(x, z).add(double(y, w))],
            [double(x, y).add(double(z, w)), diagonal(x, z), double(y, z).sub(double(x, w))],
            [double(x, z).sub(double(y, w)), double(y, z).add(double(x, w)), diagonal(x, y)],
        ]
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

    #[test]
    fn a_quaternion_turns_at_constant_speed_the_way_that_its_numbers_go() {
        // From no turn to one by `angle` about z; the far ones go the long way round of the rotations.
        for angle in [1e-9f64, 0.3, 2.0, 4.0, 6.0] {
            let (s, c) = (angle / 2.0).sin_cos();
            let path = Path::new(vec![vec![0.0, 0.0, 0.0, 1.0], vec![0.0, 0.0, s, c]], 4).unwrap();
            let slerp = path.slerp(0).unwrap();
            for t in [0.0, 0.3, 0.5, 1.0] {
                let (s, c) = (angle * t).sin_cos();
                let rows = slerp.rotation(Interval::point(t));
                for (found, expected) in
                    [(rows[0][0], c), (rows[0][1], -s), (rows[1][0], s), (rows[2][2], 1.0)]
                {
                    let found = found.value;
                    assert!(
                        found.lo - 1e-15 <= expected && expected <= found.hi + 1e-15,
                        "{angle} {t}"
                    );
                    assert!(found.hi - found.lo < 1e-11, "{angle} {t}: {found:?}");
                }
                let speed = rows[1][0].first;
                assert!(
                    speed.lo - 1e-12 <= angle * c && angle * c <= speed.hi + 1e-12,
                    "{angle} {t}"
                );
            }
        }
        let opposite =
            Path::new(vec![vec![0.0, 0.0, 0.0, 1.0], vec![0.0, 0.0, 0.0, -1.0]], 4).unwrap();
        assert!(opposite.slerp(0).is_err());
    }
}
