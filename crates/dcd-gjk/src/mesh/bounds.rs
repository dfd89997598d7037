//! Every tolerance of the search over parts. All are rounding bounds, derived in docs/numerics/proofs.md,
//! "parts".

/// Unit roundoff of f32.
pub(super) const U: f64 = f32::EPSILON as f64 / 2.0;

/// Unit roundoff of f64.
pub(super) const U64: f64 = crate::UNIT;

/// Rounded up to f32, of what is not below 0: without the branches of `next_up`, which took as long as the bounds themselves.
/// Infinity becomes NaN, which compares with nothing and so proves as little.
#[inline(always)]
pub(super) fn up(x: f64) -> f32 {
    f32::from_bits((x as f32).to_bits() + 1)
}

/// How far a face of a turned box may be from where it is computed. Unit: u·m, u of f32. Middle and
/// half edges lose 4, the rounded matrix 1, three products and sums 4, the offset 2, the last sums
/// 1; and what f64 loses. Smaller: parts that are missed. Larger: more pairs to compare.
pub(super) const BOX: f64 = 16.0;

/// How much a computed separation of two triangles may be above the true one. Unit: u·l·|d|₁, u of
/// f32, l the size of the two leaves. The first corners lose 1, the second 6, two dot products
/// 3 each of their own; 3 for the evaluation of the bound. Smaller: false "apart".
pub(super) const SEPARATION: f64 = 12.1;

/// How much lower a leaf's corners may be than they are computed along a separating plane's normal. Unit:
/// u·ρ·|d|₁, u of f32, ρ the leaf's radius. The corners' rounding 1, the dot product 3. Smaller:
/// false "apart".
pub(super) const CORNERS: f64 = 4.1;

/// The same for the lowest corner of a tree's box, which is exact. Unit: u·m·|d|₁. The dot product
/// 3. Smaller: false "apart".
pub(super) const CORNERS_OF_BOXES: f64 = 3.1;

/// How far the point of a leaf's triangle that is nearest to a sphere's centre may be from where it is
/// computed, and how much lower a corner may be along it. Unit: u·l, u of f32, l the leaf's radius
/// and its distance from the centre. √3 times 2 for a corner, 6 for the combination, 4 for weights
/// that exceed 1, and 3 for its length. Smaller: false answers.
pub(super) const NEAREST: f64 = 26.0;

/// What is lost in a coordinate of that point along an edge of a box. Unit: u·l, as for [`NEAREST`],
/// which comes on top. The edge's rounding 1 and the dot product 3. Smaller: false "touching".
pub(super) const INNER_BOX: f64 = 4.1;

/// How much a computed separation of a triangle and a body of vertices may be above the true one. Unit: u·l·|d|₁, l the
/// size of a leaf round the body's middle and the body's own. A corner less the middle 2, a dot product 3; a vertex 1
/// and 3; their difference 1; and 2 for the evaluation of the bound. Smaller: false "apart".
pub(super) const BODY_SEPARATION: f64 = 12.1;

/// The same in a cuboid's frame. A corner there 7.5 ([`CUBOID_CORNERS`]), a dot product 3, the reach 5, their difference
/// 1, and 2 for the other end of an edge.
pub(super) const CUBOID_SEPARATION: f64 = 18.6;

/// The same as [`BODY_HEIGHT`] of a cuboid's farthest corner: its reach loses 64 where a vertex and its dot product lose less.
/// Unit: u·l³. Smaller: false "touching".
pub(super) const CUBOID_HEIGHT: f64 = 136.0;

/// The same as [`BODY_DETERMINANT`], of a corner that is 10.4 off in place of 1.8. Unit: u·l³. Smaller: false "touching".
pub(super) const CUBOID_DETERMINANT: f64 = 32.0;

/// What a coordinate of a corner in a cuboid's frame may be off. Unit: u·l. The corner less the middle √3 times 2, the
/// axis' rounding 1, the dot product 3. Smaller: false "touching".
pub(super) const CUBOID_CORNERS: f64 = 8.1;

/// How far the height of a vertex over a triangle's plane may be off. Unit: u·l³, since the plane's normal has a length
/// of its own. Edges that lose √3 times 6 each, of a length of at most 2, make a normal that is off by 55.5; with what
/// the corner and the vertex lose, and the dot product, 90. Smaller: false "touching".
pub(super) const BODY_HEIGHT: f64 = 102.0;

/// What a determinant of two corners and a vertex may be off. Unit: u·l³. The three points √3 times 2, 2 and 1; the
/// arithmetic 5.1 times √3. Smaller: false "touching".
pub(super) const BODY_DETERMINANT: f64 = 26.0;

/// How far the point of a triangle that is nearest to an end of a capsule's core may be from where it is computed.
/// Unit: u·l, as [`NEAREST`] with corners that lose 4 in place of 2. Smaller: false "touching".
pub(super) const BODY_NEAREST: f64 = 40.0;

/// What a reach along a direction loses where it is divided by the direction's length. No unit: 16u of f32, of which the
/// square takes 3, its root 2.5 and the rest 3, and a matrix that departs from a rotation by at most [`TURNED`] nothing beside
/// these. Smaller: depths that are more than what bounds them.
pub(super) const BODY_REACH: f32 = 8.0 * f32::EPSILON;

/// The square of a direction's length below which it may lose to underflow. Unit: m⁴, or m² where the direction is no product
/// of edges. Larger: triangles of whose depths nothing is known. Smaller: depths that are more than what bounds them.
pub(super) const SHORTEST_SQUARE: f32 = 1e-30;

/// How far the two poses together may be from rotations for a shape's inner box to be turned with
/// them. No unit. Larger: the bound would have to count squares of it.
pub(super) const TURNED: f64 = 1e-9;

/// A sphere's radius below which squares may lose to underflow. Unit: metres. Smaller: false
/// "touching".
pub(super) const SMALLEST_SPHERE: f64 = 1e-15;

/// The length of an axis below which its square may. Unit: metres. Smaller: false "apart".
pub(super) const SHORTEST_AXIS: f64 = 1e-18;

/// What the two leaves' offset loses in f64. Unit: 2⁻⁵³·m. A relative pose 6 and 4, the turned
/// centre 3, two sums 2: 15. Smaller: false "apart".
pub(super) const OFFSET: f64 = 16.0;

/// How much a swept radius is enlarged in f32: 3u for |d|, 2u for the product and the sum, 1u for
/// the rounding of the radius, doubled. Unit: 1, relative.
pub(super) const SWEPT: f64 = 12.0 * U;

/// A direction whose components are all below this may lose its squares to underflow. Unit: square
/// metres (it is a product of two edges). Larger: pairs left to f64. Smaller: false "apart" for
/// rounded meshes.
pub(super) const SHORTEST: f64 = 1e-15;

/// Sizes of a pair between which no formula on f32 over- or underflows. Unit: metres. Outside, all
/// pairs of parts are resolved one by one.
pub(super) const SIZE: [f64; 2] = [1e-7, 1e9];

/// How much a determinant of three differences of corners may be off. Unit: 2⁻⁵³·m·e², e the
/// largest component of a difference. 18.2 times the 12.1 that a difference loses, and 37·2 for
/// the determinant's own arithmetic: 294.3. Smaller: false "touching".
pub(super) const PIERCING: f64 = 300.0;

/// How large e must be beside what a difference loses, so that products of two errors do not count.
/// Unit: 2⁻⁵³·m: a thousand times 12.1.
pub(super) const SMALLEST_EXTENT: f64 = 12_100.0;
