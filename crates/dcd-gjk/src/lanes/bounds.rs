//! Every tolerance of the f32 lanes. All are rounding bounds, derived in docs/numerics.md; none is
//! a matter of taste.
//!
//! u = 2⁻²⁴; m is the pair's size, κ_A·r_A + κ_B·r_B + |δ|₁, with r the outer radius round the
//! shape's centre and δ the difference of the two centres.

/// Unit roundoff of f32.
pub(super) const U: f32 = f32::EPSILON / 2.0;

/// How far a separation s = d·w, evaluated on the winning vertices, may be above the true one.
/// Unit: u·m·|d|₁.
///
/// 7.01 for the vertices' components (shape, matrix and δ rounded to f32, three products and two
/// sums each, two differences), 3 for the dot product, 6 for the two dot products (3 each) that
/// chose the winners, 30 because the winner's lane number took the place of its value's four
/// lowest bits: another vertex of the same bin may lie up to 15 ulps (30 u) lower. Smaller: a
/// vertex on the other side could be missed and a touching pair be called apart.
pub(super) const SEPARATION: f32 = 46.1;

/// How far |c + Σ τ_k·p_k| may be off, with 0, 1, 2 and 3 points. Unit: u·m·(1 + Σ τ_k).
pub(super) const HULL_OF_BALL: [f32; 4] = [17.0, 20.0, 22.0, 24.0];

/// How far |c| may be below its true value where outer balls reject. Unit: u·m.
pub(super) const OUTER_BALLS: f32 = 24.0;

/// How far a component of a rotated vertex, in f32, may be off. Unit: u·(κ·r).
///
/// The vertex and the matrix rounded to f32, three products, two sums; fused or not.
pub(super) const ROTATED: f32 = 5.01;

/// A support that is farther than the portal by no more than this gains rounding alone, and the
/// pair is left to f64. Unit: u·m·|d|₁. Decides who answers, never an answer.
pub(super) const GAIN: f32 = 8.0;

/// Three points whose plane's normal (twice their triangle's area) is no longer than this have no
/// plane to rounding's knowledge, and the pair is left to f64. Unit: u·m². Decides who answers,
/// never an answer.
pub(super) const PLANE: f32 = 4.0;

/// Sizes m for which no product of the kernels leaves f32's normal range (|n|² of a cross product
/// of two edges occurs): outside of it a pair goes to f64. Metres.
pub(super) const SIZE: std::ops::Range<f32> = 1e-7..1e9;

/// Below this, in m·|d|₁, a direction is too short for the bounds to hold against underflow, and
/// nothing is concluded from it. Square metres. Products of a direction and a vertex lose at most
/// 2⁻¹⁴⁹ each to underflow; u times this is a thousand times that.
pub(super) const SHORTEST: f32 = 1e-34;

/// How far each coordinate of a computed centre R·c + t may be off, and the vertices relative to
/// it. Unit: 2⁻⁵³·(|t|∞ + κ·reach), metres.
///
/// Three products and three sums, the difference of two centres, and the subtraction of the centre
/// from the vertices: 6, and room.
pub(super) const CENTRE: f64 = 8.0;
