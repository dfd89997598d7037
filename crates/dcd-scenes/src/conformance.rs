//! The conformance suite: pairs where solvers go wrong, by category, from a seed.
//!
//! A generator, not a file: the same pairs on every machine. It holds no answers. Pairs between
//! neighbouring floats are found by bisection, for which the caller lends a judge; with one that is
//! exact the suite is determined.

mod bodies;
mod contacts;
mod extremes;
mod flips;
mod kinds;
mod known;
mod places;
mod rounded;

pub use flips::Slide;
pub use kinds::{ShapeFamily, ShapeJudge, ShapePair, shape_flip};

use crate::random::Draw;
use bodies::Placed;
use dcd_geom::{Polytope, Pose};
use glam::DVec3;
use std::fmt;

/// The category of a test pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum Category {
    /// Hulls of random points, turned any way.
    Random,
    /// Random hulls up to 1e9 from the origin.
    Far,
    /// Random hulls at 1e-9 … 1e9 metres.
    Scaled,
    /// One up to a million times as large as the other.
    Ratio,
    /// Slivers: 1 : 1e-3 : 1e-7.
    Sliver,
    /// Needles: 1e-5 : 1e-5 : 2.
    Needle,
    /// Flat, in one plane or not.
    Flat,
    /// All points on a line.
    Collinear,
    /// Single points: apart, on a vertex, inside.
    Point,
    /// Every point several times.
    Duplicate,
    /// Faces that just touch, or nearly.
    Faces,
    /// Edges that just touch, or nearly.
    Edges,
    /// Vertices that just touch, or nearly.
    Vertices,
    /// One inside the other.
    Nested,
    /// Round one centre.
    Concentric,
    /// The same shape at the same pose.
    Identical,
    /// Cuboids aligned with each other, stacked as bricks and pallets are.
    Aligned,
    /// Moved until the next float touches: a gap that cannot be smaller.
    Gap,
    /// Moved until the next float does not touch: an overlap that cannot be smaller.
    Overlap,
    /// Overlaps nearly as deep as the shapes.
    Deep,
    /// Facets that are nearly one plane, and many vertices nearly as far: where searches cycle.
    Cycling,
    /// Denormal numbers.
    Denormal,
    /// Numbers near the largest.
    Huge,
    /// Spheres, capsules, rounded hulls, tangent or not.
    Rounded,
    /// Geometry on which other libraries are known to fail.
    Known,
}

impl Category {
    /// All, in the order of the suite.
    pub const ALL: [Self; 25] = [
        Self::Random,
        Self::Far,
        Self::Scaled,
        Self::Ratio,
        Self::Sliver,
        Self::Needle,
        Self::Flat,
        Self::Collinear,
        Self::Point,
        Self::Duplicate,
        Self::Faces,
        Self::Edges,
        Self::Vertices,
        Self::Nested,
        Self::Concentric,
        Self::Identical,
        Self::Aligned,
        Self::Gap,
        Self::Overlap,
        Self::Deep,
        Self::Cycling,
        Self::Denormal,
        Self::Huge,
        Self::Rounded,
        Self::Known,
    ];

    /// Whether its shapes are so thin that the last digits of a depth hang on theirs.
    #[must_use]
    pub fn is_thin(self) -> bool {
        matches!(self, Self::Sliver | Self::Needle | Self::Cycling)
    }
}

impl fmt::Display for Category {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&format!("{self:?}").to_lowercase())
    }
}

/// A pair of the suite.
#[derive(Clone, Debug)]
pub struct Case {
    /// What it is there for.
    pub category: Category,
    /// The power of ten nearest to the size of the larger shape, metres.
    pub decade: i32,
    /// The first shape.
    pub a: Polytope,
    /// The first shape's pose.
    pub pose_a: Pose,
    /// The second shape.
    pub b: Polytope,
    /// The second shape's pose.
    pub pose_b: Pose,
}

impl Case {
    /// A case of two shapes and their poses.
    #[must_use]
    pub fn new(category: Category, [(a, pose_a), (b, pose_b)]: [(Polytope, Pose); 2]) -> Self {
        let size = (a.reach() + a.swept_radius()).max(b.reach() + b.swept_radius());
        // log10 of a denormal is right too.
        let decade = if size > 0.0 { libm::round(libm::log10(size)) as i32 } else { 0 };
        Self { category, decade, a, pose_a, b, pose_b }
    }
}

/// Pairs of a category.
const EACH: usize = 150;

/// Attempts at a pair: a line that never leaves a shape, an overflow.
const ATTEMPTS: usize = 4 * EACH;

/// Streams from here on are flips; below they are categories.
const FLIP_STREAMS: u64 = 1 << 62;

/// After so many flips the kinds of pairs come round again.
const FORMS: u64 = 3 * 4 * 5 * 5 * 8;

/// Whether a pair touches, for the bisections.
pub type Judge<'a> = &'a dyn Fn(&Case) -> bool;

/// All pairs of the suite, grouped by category in the order of [`Category::ALL`].
///
/// `touches` should be exact: then the pairs depend on the seed alone.
#[must_use]
pub fn suite(seed: u64, touches: Judge<'_>) -> Vec<Case> {
    let mut cases = Vec::new();
    for (stream, category) in (0..).zip(Category::ALL) {
        let mut draw = Draw::new(seed, stream);
        let end = cases.len() + EACH;
        for k in 0..ATTEMPTS {
            if cases.len() == end {
                break;
            }
            let Some(pair) = drawn(category, k, &mut draw) else { continue };
            let case = Case::new(category, pair);
            let side = match category {
                Category::Overlap => 0,
                Category::Gap => 1,
                _ => {
                    cases.push(case);
                    continue;
                }
            };
            let sides = flips::neighbours(case, &mut draw, touches);
            cases.extend(sides.map(|sides| sides[side].clone()));
        }
    }
    cases
}

/// Flip `k` of a seed: the two neighbouring floats between which a pair stops touching, as it is
/// moved along a line; the one that touches first. `None` where `touches` sees no end of it.
///
/// Each depends on the seed, `k` and `touches` alone: any number of them can be had in any order.
#[must_use]
pub fn flip(seed: u64, k: u64, touches: Judge<'_>) -> Option<[Case; 2]> {
    let mut draw = Draw::new(seed, FLIP_STREAMS | k);
    let pair = flips::origin((k % FORMS) as usize, &mut draw)?;
    flips::neighbours(Case::new(Category::Overlap, pair), &mut draw, touches)
}

/// Pair `k` of a category, before any bisection; `None` where a number overflowed on the way.
fn drawn(category: Category, k: usize, draw: &mut Draw) -> Option<[Placed; 2]> {
    match category {
        Category::Random => places::random(draw),
        Category::Far => places::far(k, draw),
        Category::Scaled => places::scaled(k, draw),
        Category::Ratio => places::ratio(k, draw),
        Category::Sliver => places::stretched(DVec3::new(1.0, 1e-3, 1e-7), draw),
        Category::Needle => places::stretched(DVec3::new(1e-5, 1e-5, 2.0), draw),
        Category::Flat => places::flat(k, draw),
        Category::Collinear => places::collinear(k, draw),
        Category::Point => places::point(k, draw),
        Category::Duplicate => places::duplicate(draw),
        Category::Nested => places::nested(k, draw),
        Category::Concentric => places::concentric(k, draw),
        Category::Identical => places::identical(k, draw),
        Category::Deep => places::deep(draw),
        Category::Faces => contacts::meeting(1, k, draw),
        Category::Edges => contacts::meeting(2, k, draw),
        Category::Vertices => contacts::meeting(3, k, draw),
        Category::Aligned => contacts::aligned(k, draw),
        Category::Gap | Category::Overlap => flips::origin(k, draw),
        Category::Cycling => extremes::cycling(k, draw),
        Category::Denormal => extremes::denormal(k, draw),
        Category::Huge => extremes::huge(k, draw),
        Category::Rounded => rounded::rounded(k, draw),
        Category::Known => known::known(k, draw),
    }
}
