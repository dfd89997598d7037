//! The expanding polytope of one pair in f32, with supports of sixteen vertices an operation.

use super::super::bounds::U;
use super::super::cores::Core;
use super::surface::{Point, Surface, dot, load, splat};
use crate::Difference;
use dcd_geom::glam::{DMat3, Vec3};
use dcd_geom::{Polytope, Pose};
use dcd_simd::{Block, Kernel, Lanes, WIDTH};

/// Of a polytope with more blocks of vertices the pairs are searched in f64. Blocks of sixteen.
const BLOCKS: usize = 16;

/// How far from flat the first tetrahedron must be, relative to the pair's size: 2⁻¹². Smaller: slivers whose planes
/// f32 does not know. Larger: more thin pairs for the search in f64. Never an answer.
const FAT: f32 = 1.0 / 4096.0;

/// A support that is farther than the nearest face by no more than this is nothing new, and what a point is beyond
/// by no more it does not see. Unit: u·m. Decides how many supports are evaluated, never an answer.
const GAIN: f32 = 8.0;

/// How much nearer than computed the surface of the true vertices may be. Unit: u·m. 8 for each coordinate of a point
/// of A − B (`CORNER`), √3 of that; 3.1 for the products with the normal; and a margin. The normal's own length loses
/// [`LENGTH`]. Smaller: a bound that is none.
pub(crate) const OFF: f64 = 24.0;

/// What the length of a normal loses, relative. Unit: 1.
pub(crate) const LENGTH: f64 = 1.0 - 16.0 * U as f64;

/// One pair, in the difference's lengths.
pub(super) struct Search<'a> {
    pub(super) bodies: [Rotated<'a>; 2],
    /// The difference of the two centres.
    pub(super) middle: Vec3,
    /// u·m: what every bound is a multiple of.
    pub(super) unit: f32,
    pub(super) scratch: &'a mut Scratch,
}

/// A polytope's vertices round its centre, and how they are turned and scaled.
pub(super) struct Rotated<'a> {
    pub(super) blocks: &'a [Block],
    /// Column by column.
    pub(super) columns: [[f32; 3]; 3],
}

/// What a thread reuses from pair to pair.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch {
    rotated: [Vec<Block>; 2],
    pub(super) surface: Surface,
}

impl<'a> Search<'a> {
    /// `None` where a hull has too many vertices, or the pair is outside f32's range.
    pub(super) fn of(
        difference: &Difference<'_, f64, Polytope, Polytope>,
        [a, b]: [(&Core, &'a [Block], &Pose); 2],
        scratch: &'a mut Scratch,
    ) -> Option<Self> {
        let fits = |blocks: &[Block]| (1..=BLOCKS).contains(&blocks.len());
        if !fits(a.1) || !fits(b.1) {
            return None;
        }
        let scale = difference.scale();
        let middle = difference.middle();
        let reach = |core: &Core, pose: &Pose| core.outer * (1.0 + pose.deviation()) * scale;
        let size = reach(a.0, a.2) + reach(b.0, b.2) + middle.abs().element_sum();
        let rotated = |(_, blocks, pose): (&Core, &'a [Block], &Pose)| {
            let DMat3 { x_axis: x, y_axis: y, z_axis: z } = *pose.rotation() * scale;
            let columns = [x.as_vec3().to_array(), y.as_vec3().to_array(), z.as_vec3().to_array()];
            Rotated { blocks, columns }
        };
        // Much above 1 only for shapes far from their own origins; far below, f64 sees more than f32.
        (2f64.powi(-20)..4.0).contains(&size).then_some(())?;
        (1e-24..1e24).contains(&scale).then_some(())?;
        Some(Self {
            bodies: [rotated(a), rotated(b)],
            middle: middle.as_vec3(),
            unit: U * (size as f32 * (1.0 + 4.0 * U)),
            scratch,
        })
    }
}

impl Kernel for Search<'_> {
    /// Whether the search ended at a face beyond which there is nothing.
    type Output = Option<()>;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Option<()> {
        let Self { bodies: [a, b], middle, unit, scratch: Scratch { rotated, surface } } = self;
        let [rotated_a, rotated_b] = rotated;
        rotate(l, &a, rotated_a);
        rotate(l, &b, rotated_b);
        let vertices = Vertices { a: rotated_a, b: rotated_b, middle };
        surface.start(l, vertices.tetrahedron(l)?)?;
        let clear = GAIN * unit;
        loop {
            let nearest = surface.nearest(l);
            let (normal, distance) = (surface.normal(nearest), surface.distance(nearest));
            let point = vertices.farthest(l, normal);
            let along = Vec3::from_array(normal).dot(Vec3::from_array(point.at));
            // Written so that NaN ends the search.
            if !(along - distance > clear) {
                return (along.is_finite() && along > 0.0).then_some(());
            }
            // All of A − B is on the far side: the cores do not overlap, as far as f32 knows.
            if along < 0.0 {
                return None;
            }
            surface.insert(l, point, (nearest, clear))?;
        }
    }
}

/// The vertices, turned and scaled.
#[inline(always)]
fn rotate<L: Lanes>(l: L, body: &Rotated<'_>, rotated: &mut Vec<Block>) {
    let [x, y, z] = &body.columns;
    let rows = [[x[0], y[0], z[0]], [x[1], y[1], z[1]], [x[2], y[2], z[2]]];
    let rows = [splat(l, rows[0]), splat(l, rows[1]), splat(l, rows[2])];
    rotated.resize(body.blocks.len(), Block::default());
    for (to, from) in rotated.iter_mut().zip(body.blocks) {
        let v = load(l, from);
        l.store(dot(l, rows[0], v), &mut to.0[0]);
        l.store(dot(l, rows[1], v), &mut to.0[1]);
        l.store(dot(l, rows[2], v), &mut to.0[2]);
    }
}

/// Both bodies' vertices.
struct Vertices<'a> {
    a: &'a [Block],
    b: &'a [Block],
    middle: Vec3,
}

impl Vertices<'_> {
    /// The point of A − B farthest along a direction, up to rounding.
    #[inline(always)]
    fn farthest<L: Lanes>(&self, l: L, direction: [f32; 3]) -> Point {
        let (a, of_a) = farthest(l, self.a, direction);
        let (b, of_b) = farthest(l, self.b, [-direction[0], -direction[1], -direction[2]]);
        Point { at: ((of_a - of_b) + self.middle).to_array(), vertices: [a, b] }
    }

    /// Four points that are far from one plane, each a support towards the origin.
    #[inline(always)]
    fn tetrahedron<L: Lanes>(&self, l: L) -> Option<[Point; 4]> {
        let at = |point: &Point| Vec3::from_array(point.at);
        let start = if self.middle == Vec3::ZERO { Vec3::X } else { -self.middle };
        let v0 = self.farthest(l, start.to_array());
        let back = if at(&v0) == Vec3::ZERO { -start } else { -at(&v0) };
        let v1 = self.farthest(l, back.to_array());
        let edge = at(&v1) - at(&v0);
        if !(edge.length_squared() > FAT * FAT) {
            return None;
        }
        let off_line = edge.cross(at(&v0)).cross(edge);
        let is_off = off_line.length_squared() > FAT * FAT * edge.length_squared().powi(2);
        let square = if is_off { -off_line } else { edge.any_orthogonal_vector() };
        let height = |point: &Point| edge.cross(at(point) - at(&v0)).length_squared();
        let least = FAT * FAT * edge.length_squared();
        let mut v2 = self.farthest(l, square.to_array());
        if !(height(&v2) > least) {
            v2 = self.farthest(l, (-square).to_array());
            if !(height(&v2) > least) {
                return None;
            }
        }
        let normal = edge.cross(at(&v2) - at(&v0));
        let inward = if normal.dot(at(&v0)) > 0.0 { -normal } else { normal };
        let height = |point: &Point| normal.dot(at(point) - at(&v0));
        let least = FAT * normal.length();
        let mut v3 = self.farthest(l, inward.to_array());
        if !(height(&v3).abs() > least) {
            v3 = self.farthest(l, (-inward).to_array());
            if !(height(&v3).abs() > least) {
                return None;
            }
        }
        Some(if height(&v3) > 0.0 { [v0, v1, v2, v3] } else { [v0, v2, v1, v3] })
    }
}

/// The first of the vertices that are farthest along a direction, and its number.
#[inline(always)]
fn farthest<L: Lanes>(l: L, blocks: &[Block], direction: [f32; 3]) -> (u32, Vec3) {
    let d = splat(l, direction);
    let mut best = l.splat(f32::NEG_INFINITY);
    for block in blocks {
        best = l.max(best, dot(l, load(l, block), d));
    }
    let top = l.splat(l.largest(best));
    for (number, block) in blocks.iter().enumerate() {
        let hit = l.bits(l.le(top, dot(l, load(l, block), d)));
        if hit != 0 {
            let lane = hit.trailing_zeros();
            return ((number * WIDTH) as u32 + lane, block.point(lane as usize));
        }
    }
    (0, blocks.first().map_or(Vec3::NAN, |block| block.point(0)))
}
