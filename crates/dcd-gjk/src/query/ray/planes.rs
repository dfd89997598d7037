//! A line clipped against the planes of a polytope's faces (M. Cyrus and J. Beck, 1978).
//!
//! Sixteen planes at a time in f32 leave those that may be entered last or left first, most often one of each; these are
//! compared in f64. The same bits as by all planes in f64 (docs/numerics/queries.md, "planes by lanes").

use super::local::{Chord, LocalRay, is_later};
use dcd_geom::{FacetPlanes, PlaneRow};
use dcd_simd::{Kernel, Lanes, Row, WIDTH, dispatch};

/// What the height of a point above a plane and the slope of a line lose in f32. Unit: 2⁻²⁴ of the lengths that go into
/// it. A height: 5.1 for its product, 2 for the offset and the difference. A slope: 5.1, and 3 of the time for the
/// reciprocal, its product and the end of the interval. Smaller: another plane than the one that counts. Larger: more
/// planes are compared again.
const LOST: f64 = 10.0 * (f32::EPSILON as f64 / 2.0);

/// A slope this many times what it may be off has a reciprocal that is off by one part in as many. Smaller: wider bounds
/// on all times. Larger: more planes count as level, and are compared in f64.
const SURE: f32 = 101.0;

/// How many rows of planes are not computed again: of hulls of some sixty vertices. Larger: more memory is cleared.
const KEPT: usize = 8;

/// Lengths for which no product or quotient in f32 comes near its range's ends; from the reciprocal on.
const WIDEST: f64 = (1u64 << 40) as f64;

/// The chord in the outer planes, each moved outward by `out`, and that in the inner ones, moved by `inward`, which
/// is below 0. `None` where the line misses the outer ones, or enters them after `limit`.
pub(super) fn chords(
    ray: &LocalRay,
    planes: &FacetPlanes,
    [out, inward]: [f64; 2],
    limit: f64,
) -> Option<(Chord, Option<Chord>)> {
    let mut clip = Clip { ray, planes, out, inward, ..Clip::new(ray, planes) };
    match InF32::of(ray, planes, [out, inward]) {
        Some(line) => dispatch(Candidates { line, clip: &mut clip }),
        None => (0..planes.len()).for_each(|k| clip.take(k)),
    }
    clip.chords(limit)
}

/// What planes leave of a line.
struct Clip<'a> {
    ray: &'a LocalRay,
    planes: &'a FacetPlanes,
    out: f64,
    inward: f64,
    outer: Chord,
    inner: Chord,
    entered: usize,
    is_beyond: bool,
}

impl<'a> Clip<'a> {
    fn new(ray: &'a LocalRay, planes: &'a FacetPlanes) -> Self {
        let (outer, inner) = (Chord::LINE, Chord::LINE);
        Self { ray, planes, out: 0.0, inward: 0.0, outer, inner, entered: 0, is_beyond: false }
    }

    #[inline(always)]
    fn take(&mut self, k: usize) {
        let (o, d) = (self.ray.origin, self.ray.direction);
        let [nx, ny, nz] = &self.planes.normals;
        let along = nx[k] * o.x + ny[k] * o.y + nz[k] * o.z;
        let rise = nx[k] * d.x + ny[k] * d.y + nz[k] * d.z;
        let beyond = self.planes.outer[k] + self.out - along;
        let within = self.planes.inner[k] + self.inward - along;
        let (s, t) = (beyond / rise, within / rise);
        if rise < 0.0 {
            if s > self.outer.enter {
                (self.outer.enter, self.entered) = (s, k);
            }
            self.inner.enter = self.inner.enter.max(t);
        } else if rise > 0.0 {
            self.outer.leave = self.outer.leave.min(s);
            self.inner.leave = self.inner.leave.min(t);
        } else {
            self.is_beyond |= beyond < 0.0;
            if !(within > 0.0) {
                self.inner.leave = f64::NEG_INFINITY;
            }
        }
    }

    fn chords(self, limit: f64) -> Option<(Chord, Option<Chord>)> {
        let Self { planes, mut outer, inner, entered, .. } = self;
        if self.is_beyond || outer.enter > outer.leave || is_later(outer.enter, limit) {
            return None;
        }
        if outer.enter > f64::NEG_INFINITY {
            (outer.normal, outer.facet) = (planes.normal(entered), Some(entered as u32));
        }
        Some((outer, (inner.enter <= inner.leave).then_some(inner)))
    }
}

/// A line in f32.
struct InF32 {
    origin: [f32; 3],
    direction: [f32; 3],
    /// How far a height above either plane may be off, metres, and a slope.
    lost: [f32; 2],
}

impl InF32 {
    /// `None` where f32 does not have its range.
    fn of(ray: &LocalRay, planes: &FacetPlanes, [out, inward]: [f64; 2]) -> Option<Self> {
        let far = ray.origin.abs().element_sum() + planes.largest_offset();
        let size = ray.direction.abs().element_sum();
        let moved = planes.thickness() + out.abs() + inward.abs();
        // Written so that NaN is none.
        let is_within = far + moved < WIDEST && size > WIDEST.recip() && size < WIDEST;
        let lost =
            [LOST * far + moved, LOST * size].map(|x| (x * 1.001) as f32 + f32::MIN_POSITIVE);
        let (origin, direction) =
            (ray.origin.as_vec3().to_array(), ray.direction.as_vec3().to_array());
        is_within.then_some(Self { origin, direction, lost })
    }
}

/// Hands on the planes that count.
struct Candidates<'a, 'b> {
    line: InF32,
    clip: &'a mut Clip<'b>,
}

/// Sixteen planes: within which times each is passed, and whether it is entered, left, or neither for sure.
struct Times<L: Lanes> {
    earliest: L::F,
    latest: L::F,
    enters: L::M,
    leaves: L::M,
}

impl<L: Lanes> Times<L> {
    /// Those of which it depends whether a plane counts: when one is entered at the latest, left at the earliest.
    #[inline(always)]
    fn counted(&self, l: L) -> (L::F, [u32; 2]) {
        let times = l.select(self.enters, self.latest, self.earliest);
        (times, [l.bits(self.enters), l.bits(self.leaves)])
    }
}

impl InF32 {
    #[inline(always)]
    fn times<L: Lanes>(&self, l: L, row: &PlaneRow) -> Times<L> {
        let (mut along, mut rise) = (l.splat(0.0), l.splat(0.0));
        for axis in 0..3 {
            let normal = l.load(&row.normals[axis]);
            along = l.mul_add(normal, l.splat(self.origin[axis]), along);
            rise = l.mul_add(normal, l.splat(self.direction[axis]), rise);
        }
        let [of_height, of_rise] = self.lost.map(|lost| l.splat(lost));
        let inverse = l.div(l.splat(1.0), rise);
        let time = l.mul(l.sub(l.load(&row.outer), along), inverse);
        // Where the slope is sure the true one is at least 0.99 of it; the rest is for what this loses itself.
        let lost = l.mul(l.mul_add(l.abs(time), of_rise, of_height), l.abs(inverse));
        let lost = l.mul(lost, l.splat(1.02));
        let level = l.mul(of_rise, l.splat(SURE));
        Times {
            earliest: l.sub(time, lost),
            latest: l.add(time, lost),
            enters: l.lt(rise, l.neg(level)),
            leaves: l.lt(level, rise),
        }
    }
}

impl Kernel for Candidates<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        let Self { line, clip } = self;
        let planes = clip.planes;
        let (first, last) = (l.splat(f32::MIN), l.splat(f32::MAX));
        let (mut entered, mut left) = (first, last);
        let mut kept = [Row::default(); KEPT];
        let mut sides = [[0; 2]; KEPT];
        for (number, row) in planes.rows().iter().enumerate() {
            let times = line.times(l, row);
            entered = l.max(entered, l.select(times.enters, times.earliest, first));
            left = l.min(left, l.select(times.leaves, times.latest, last));
            if number < KEPT {
                let (counted, sides_of) = times.counted(l);
                l.store(counted, &mut kept[number]);
                sides[number] = sides_of;
            }
        }
        let (entered, left) = (l.largest(entered), -l.largest(l.neg(left)));
        if entered > left {
            clip.is_beyond = true;
            return;
        }
        let (entered, left) = (l.splat(entered), l.splat(left));
        for (number, row) in planes.rows().iter().enumerate() {
            let (counted, [enters, leaves]) = if number < KEPT {
                (l.load(&kept[number]), sides[number])
            } else {
                line.times(l, row).counted(l)
            };
            let counts =
                (enters & l.bits(l.le(entered, counted))) | (leaves & l.bits(l.le(counted, left)));
            let is_sure = enters | leaves;
            let mut bits = (counts | !is_sure) & 0xffff;
            while bits != 0 {
                let k = number * WIDTH + bits.trailing_zeros() as usize;
                bits &= bits - 1;
                // Past the last one the rows hold it again.
                if k < planes.len() {
                    clip.take(k);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PosedShape;
    use crate::motion::tests::Draw;
    use crate::query::ray::Ray;
    use dcd_geom::{Pose, Shape, glam::DVec3};

    #[test]
    fn the_lanes_clip_a_line_as_all_planes_do_one_by_one() {
        let seed = std::env::var("DCD_SEED").map_or(9, |seed| seed.parse().expect("a seed"));
        let mut draw = Draw(seed);
        let [mut met, mut missed] = [0; 2];
        for k in 0..4000 {
            let scale = [1.0, 1e-5, 1e5][k % 3];
            // A lattice's hull has planes along the axes.
            let points = (0..6 + k % 50).map(|_| {
                let point = draw.vector();
                if k % 2 == 0 { (point * 2.0).round() * scale } else { point * scale }
            });
            let shape = Shape::hull(points.collect()).unwrap();
            let pose = Pose::IDENTITY;
            let posed = PosedShape { shape: &shape, pose: &pose };
            let polytope = shape.as_polytope().unwrap();
            let from = draw.vector() * scale * [3.0, 300.0, 0.5][k / 3 % 3];
            let to = draw.vector() * scale * 1.2;
            let way = if k % 5 == 0 { DVec3::X * [1.0, 1e-6][k % 2] } else { to - from };
            let ray = Ray::endless(from, way).unwrap();
            let local = LocalRay::of(&ray, &posed, polytope.reach());
            let planes = polytope.planes();
            for limit in [f64::INFINITY, 1.0] {
                let moved = [local.margin, -local.margin];
                let found = chords(&local, planes, moved, limit);
                let mut plain =
                    Clip { out: moved[0], inward: moved[1], ..Clip::new(&local, planes) };
                (0..planes.len()).for_each(|k| plain.take(k));
                let expected = plain.chords(limit);
                assert_eq!(format!("{found:?}"), format!("{expected:?}"), "{seed} {k}");
                *(if found.is_some() { &mut met } else { &mut missed }) += 1;
            }
        }
        assert!(met > 500 && missed > 500, "{met} {missed}");
    }
}
