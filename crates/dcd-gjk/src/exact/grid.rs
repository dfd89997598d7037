//! A pair of placed hulls in units of a common grid: fine enough that every vertex of the
//! difference is on it (integers), or as coarse as the pair (double-double).

use super::integer::{Dyadic, Number};
use crate::PosedSupport;
use crate::simplex::{Triple, dot, minus, plus};
use dcd_geom::Polytope;
use dcd_geom::glam::{DMat3, DVec3};

/// Which of a hull's vertices may be lowest, decided in f64. Unit: u·|d|₁, for a hull scaled to
/// reach 1: twice 13.1 (the direction's rounding 6.03, Rᵀd 3, the scale 1, ·v 3) and a margin.
const FILTER: f64 = 27.0 * crate::UNIT;

/// The largest coordinate, in bits, for which machine words hold every number of the search: the
/// longest product is s² with 8·14 + 12 = 124 bits (docs/numerics/proofs.md, "the exact method").
const SMALL_BITS: i32 = 14;

/// How long a number may be before its first product in machine words.
const SMALL_INPUT_BITS: i32 = 100;

/// Reaches whose reciprocal keeps every product of the filter clear of over- and underflow, metres.
const FILTERED: std::ops::Range<f64> = 1e-290..1e290;

/// How fine the grid of a pair is, and whether its numbers are short.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extent {
    /// The lowest bits of R and of the vertices; `None` for a hull of zeros, which R cannot move.
    sides: [Option<[i32; 2]>; 2],
    unit: i32,
    small: bool,
}

impl Extent {
    /// So fine that every vertex is on it.
    pub(crate) fn of(a: PosedSupport<'_, Polytope>, b: PosedSupport<'_, Polytope>) -> Self {
        let bodies = [a, b];
        let sides = bodies.map(|body| {
            let vertices = body.map.vertices().iter().flat_map(|vertex| vertex.to_array());
            Some([Span::of(body.pose.rotation().to_cols_array())?, Span::of(vertices)?])
        });
        let rest = Span::of(bodies.into_iter().flat_map(|body| {
            let t = body.pose.translation();
            [t.x, t.y, t.z, body.map.swept_radius()]
        }));
        let lows = sides.iter().flatten().map(|[rotation, vertices]| rotation.low + vertices.low);
        let unit = lows.chain(rest.map(|span| span.low)).min().unwrap_or(0);
        let delta = a.pose.translation() - b.pose.translation();
        let radius = a.map.swept_radius() + b.map.swept_radius();
        let size = 2.0 * (a.reach + b.reach) + delta.abs().element_sum() + radius;
        let is_short = |span: &Span| span.high - span.low <= SMALL_INPUT_BITS;
        let small = size.is_finite()
            && Dyadic::new(size).highest().is_none_or(|top| top - unit <= SMALL_BITS)
            && rest.is_none_or(|span| span.high - unit <= SMALL_INPUT_BITS)
            && sides.iter().flatten().flatten().all(is_short);
        let sides = sides.map(|spans| spans.map(|spans| spans.map(|span| span.low)));
        Self { sides, unit, small }
    }

    /// In units near the pair's size, for numbers that are not whole.
    pub(crate) fn coarse(unit: i32) -> Self {
        Self { sides: [Some([0, unit]); 2], unit, small: false }
    }

    /// The exponent of the grid's unit, of two.
    pub(crate) fn unit(&self) -> i32 {
        self.unit
    }

    /// Whether machine words hold every number of the search.
    pub(crate) fn is_small(&self) -> bool {
        self.small
    }
}

/// The exponents of the lowest and the highest bit among some numbers.
#[derive(Clone, Copy, Debug)]
struct Span {
    low: i32,
    high: i32,
}

impl Span {
    /// `None` where all are 0.
    fn of(numbers: impl IntoIterator<Item = f64>) -> Option<Self> {
        let spans = numbers.into_iter().map(Dyadic::new);
        let spans = spans.filter_map(|x| Some(Self { low: x.lowest()?, high: x.highest()? }));
        let both = |s: Self, t: Self| Self { low: s.low.min(t.low), high: s.high.max(t.high) };
        spans.reduce(both)
    }
}

/// Two placed hulls in whole numbers of the grid's unit.
pub(crate) struct Grid<'a, T> {
    a: Side<'a, T>,
    b: Side<'a, T>,
    delta: Triple<T>,
    radius: T,
}

impl<'a, T: Number> Grid<'a, T> {
    pub(crate) fn new(
        a: PosedSupport<'a, Polytope>,
        b: PosedSupport<'a, Polytope>,
        extent: &Extent,
    ) -> Self {
        let on_grid = |x: f64| T::on_grid(x, extent.unit);
        let translation =
            |body: PosedSupport<'_, Polytope>| body.pose.translation().to_array().map(on_grid);
        let radius = |body: PosedSupport<'_, Polytope>| on_grid(body.map.swept_radius());
        Self {
            a: Side::new(a, extent, 0),
            b: Side::new(b, extent, 1),
            delta: minus(&translation(a), &translation(b)),
            radius: radius(a).plus(&radius(b)),
        }
    }

    /// R_A·a − R_B·b + t_A − t_B for a vertex of each, by index.
    pub(crate) fn point(&self, [a, b]: [usize; 2]) -> Triple<T> {
        plus(&minus(&self.a.world(a), &self.b.world(b)), &self.delta)
    }

    /// The vertices whose difference is lowest along `direction`.
    pub(crate) fn lowest(&self, direction: &Triple<T>) -> [usize; 2] {
        let away = crate::simplex::negated(direction);
        [self.a.lowest(direction), self.b.lowest(&away)]
    }

    /// The sum of the swept radii.
    pub(crate) fn radius(&self) -> &T {
        &self.radius
    }
}

/// The numbers of the bits that are set, in rising order.
fn set_bits(mut bits: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let number = bits.trailing_zeros();
        bits &= bits.wrapping_sub(1);
        (number < u64::BITS).then_some(number as usize)
    })
}

/// One placed hull.
struct Side<'a, T> {
    vertices: &'a [DVec3],
    rotation: &'a DMat3,
    /// Brings the vertices to length 1 for the filter; 0 outside of its range: all vertices pass.
    scale: f64,
    /// R by rows, in units of its own.
    rows: [Triple<T>; 3],
    unit: i32,
    /// From the units of R and the vertices to the grid's.
    shift: u32,
}

impl<'a, T: Number> Side<'a, T> {
    fn new(body: PosedSupport<'a, Polytope>, extent: &Extent, k: usize) -> Self {
        let rotation = body.pose.rotation();
        let filtered = FILTERED.contains(&body.reach);
        let rows =
            |unit| [0, 1, 2].map(|r| rotation.row(r).to_array().map(|x| T::on_grid(x, unit)));
        let nothing = || [(); 3].map(|()| [T::zero(), T::zero(), T::zero()]);
        let side = extent.sides[k];
        let [rotation_unit, unit] = side.unwrap_or([extent.unit, 0]);
        Self {
            vertices: body.map.vertices(),
            rotation,
            scale: if filtered { body.reach.recip() } else { 0.0 },
            rows: if side.is_some() { rows(rotation_unit) } else { nothing() },
            unit,
            shift: (rotation_unit + unit).abs_diff(extent.unit),
        }
    }

    fn local(&self, k: usize) -> Triple<T> {
        self.vertices[k].to_array().map(|x| T::on_grid(x, self.unit))
    }

    fn world(&self, k: usize) -> Triple<T> {
        let local = self.local(k);
        let turned = [0, 1, 2].map(|r| dot(&self.rows[r], &local));
        if self.shift == 0 {
            return turned;
        }
        let shift = T::power_of_two(self.shift);
        turned.map(|x| x.times(&shift))
    }

    /// The vertex lowest along a world direction. The few that f64 cannot order are compared exactly.
    fn lowest(&self, direction: &Triple<T>) -> usize {
        let rounded = T::rounded(direction);
        let local = self.rotation.transpose() * rounded * self.scale;
        let along = |vertex: &DVec3| local.dot(*vertex);
        let least = self.vertices.iter().map(along).fold(f64::INFINITY, f64::min);
        let limit = least + FILTER * rounded.abs().element_sum();
        // A bit for each of 64: the few that are open are found without a branch on each. Written so that NaN, which an
        // overflow makes, lets every vertex pass.
        let chunks = self.vertices.chunks(u64::BITS as usize).enumerate();
        let mut open = chunks.flat_map(|(number, chunk)| {
            let is_open = |vertex: &DVec3| u64::from(!(along(vertex) > limit));
            let bits = chunk.iter().rev().fold(0, |bits, vertex| bits << 1 | is_open(vertex));
            set_bits(bits).map(move |k| number * u64::BITS as usize + k)
        });
        let Some(first) = open.next() else { return 0 };
        let Some(second) = open.next() else { return first };
        let [x, y, z] = &self.rows;
        let [dx, dy, dz] = direction;
        let column = |c: usize| x[c].times(dx).plus(&y[c].times(dy)).plus(&z[c].times(dz));
        let exact_local = [column(0), column(1), column(2)];
        let exactly = |k: usize| dot(&exact_local, &self.local(k));
        let mut best = (first, exactly(first));
        for k in std::iter::once(second).chain(open) {
            let value = exactly(k);
            if value.minus(&best.1).is_negative() {
                best = (k, value);
            }
        }
        best.0
    }
}
