//! Every tolerance of the f32 lanes. All are rounding bounds, derived in docs/numerics/proofs.md; none is
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
/// chose the winners; [`CHOICE`] comes on top. Smaller: a vertex on the other side could be missed
/// and a touching pair be called apart.
pub(super) const SEPARATION: f32 = 16.1;

/// By how much the choice of the farthest vertex may be wrong. Unit: tag·κ·r·|d|₁ for each object.
///
/// The vertex's number takes the place of its value's lowest bits, of which `tag` is the mask: two
/// values that differ in those bits alone differ by at most `tag` ulps, 2u·tag of the value, which
/// is at most κ·r·|d|₁ and the rounding that [`SEPARATION`] counts: 1/16 more covers it.
pub(super) const CHOICE: f64 = 2.125 * (f32::EPSILON / 2.0) as f64;

/// Of an object with more blocks of vertices than these the pairs go to f64. Blocks of sixteen.
///
/// Their number takes 12 bits of a value at most, so that a separation is off by a thousandth of
/// the size at most. Larger: the lanes prove less for large hulls. Smaller: more of them are slow.
pub(super) const TAGGED_BLOCKS: u8 = 255;

/// How far |c + Σ τ_k·p_k| may be off, with 0, 1, 2 and 3 points. Unit: u·m·(1 + Σ τ_k).
pub(super) const HULL_OF_SPHERE: [f32; 4] = [17.0, 20.0, 22.0, 24.0];

/// How far the nearest point that w, s·(p − w) and t·(q − w) make of three of A − B may be from one
/// of the hull of the cores, with what its length loses. Unit: u·m.
///
/// 12.2 for the three points, 17.4 for their combination, 5.2 for the comparison with the radii
/// (docs/numerics/proofs.md, "nearest points of cores"). Smaller: false contacts of rounded shapes.
pub(super) const NEAREST: f32 = 40.0;

/// How far the distance of two points, one of a segment and one of a segment or cuboid, may be off that of the cores, and how far
/// below that what it less an end's reach past them proves. Unit: u·m. Derived: 46; the slacks come on top, twice.
///
/// (docs/numerics/proofs.md, "Straight cores in lanes".) Smaller: false answers both ways.
pub(super) const STRAIGHT: f32 = 48.0;

/// By how much the sum of the swept radii, rounded up, may be above them. Unit: u of itself.
///
/// 7 for the two roundings up and the sum, 1 for the product. Smaller: false contacts.
pub(super) const RADIUS: f32 = 16.0;

/// How far |c| may be below its true value where outer spheres reject. Unit: u·m.
pub(super) const OUTER_SPHERES: f32 = 24.0;

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

/// How far what the inner and outer OBBs' fifteen axes compare may be off, edges that are parallel up to
/// [`PARALLEL`] taken as parallel. Unit: u·(m + the swept radii).
///
/// 32 for the arithmetic, 64 and 46 for turning one box by twice [`PARALLEL`] and shrinking it into
/// itself (docs/numerics/proofs.md, "inner and outer OBBs"). Smaller: false answers both ways.
pub(super) const OBB: f32 = 256.0;

/// Directions whose cross product has no component above this are parallel, and it is no axis to
/// test. Unit: u. Larger: [`OBB`] must grow with it. Smaller: fewer boxes with parallel edges
/// are resolved here.
pub(super) const PARALLEL: f32 = 16.0;

/// The largest deviation of a pose's matrix from a rotation for which the boxes are turned with it.
/// No unit. Larger: [`OBB`] would have to count it.
pub(super) const TURNED: f64 = 1e-9;

/// Sizes m for which no product of the kernels leaves f32's normal range (|n|² of a cross product
/// of two edges occurs): outside of it a pair goes to f64. Metres.
pub(super) const SIZE: std::ops::Range<f32> = 1e-7..1e9;

/// A direction d whose |d|₁ is not above this is too short for the bounds to hold against underflow,
/// and nothing is concluded from it. In the direction's own unit.
///
/// Three squares lose 2⁻¹⁴⁹ each, together a quarter of u of |d|₂² ≥ |d|₁²/3, so that the length by
/// which the swept radii are multiplied keeps its 3u; products with a vertex lose as much, and the
/// rounding that is counted, u·m·|d|₁ with m of [`SIZE`], is far above that. Smaller: rounded shapes
/// that touch are called apart.
pub(super) const SHORTEST: f32 = 1e-18;

/// How far each coordinate of a computed centre R·c + t may be off from a point of the core, and the
/// vertices counted from it from their place. Unit: 2⁻⁵³·(|t|∞ + κ·reach), metres.
///
/// Of κ·reach: three products and two sums of the rotation 3, the sum with t and the difference of two
/// centres 1 each; and either the vertices less the centre 2, or the mean that stands for the centre of a
/// core without an inner sphere 2.02: 7.02. Of |t|: 2. (docs/numerics/proofs.md, "centres".) Smaller: false
/// answers.
pub(super) const CENTRE: f64 = 8.0;

/// How far a component of c, or of a computed point of A − B, may be off where four of them hold the
/// origin. Unit: u·m; the slacks come on top.
///
/// 7.01 as for any rotated vertex, and 1 % for the determinants' own normals. Smaller: false contacts
/// of flat shapes.
pub(super) const CORNER: f32 = 8.0;

/// How far a determinant of three points may be off. Unit: u times the product of their 1-norms.
///
/// 2 for a minor, 3 for the dot product, and 3 for each norm of the bound. Smaller: false contacts of
/// flat shapes.
pub(super) const DETERMINANT: f32 = 16.0;

/// What the rest of that bound is multiplied by, for its own rounding: two edges with 4 each, two
/// products, a sum. Unit: 1. Smaller: false contacts of flat shapes.
pub(super) const EVALUATED: f32 = 1.0 + 32.0 * U;

/// An inner sphere below this resolves so little that four points are tried as well. Unit: u·m. Decides
/// what is computed, never an answer.
pub(super) const FLAT: f32 = 1024.0;

/// Nearest points whose distance the support beyond them could make smaller by no more than this are
/// nearest. Unit: u·m. Decides how many supports are evaluated, never an answer. Larger: wider bounds of distances.
/// Smaller: more supports, which rounding answers.
pub(super) const CLOSED: f32 = 12.0;
