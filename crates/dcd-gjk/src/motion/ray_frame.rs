//! The difference of two polytopes in the axes of a ray against it, in f32: leads a search to the face that the ray
//! enters through, or to the direction of a miss, and proves nothing.
//!
//! The vertices are turned once. A support then is one direction for both shapes, what it finds needs no turn, and its
//! first two coordinates are where it is seen along the ray. The first triangle is round the place where the ray would
//! enter a sphere: its three supports wait for nothing, and it is near to the face.

use crate::supports::Polytopes;
use dcd_geom::Polytope;
use dcd_geom::glam::{DMat3, Mat3A, Vec2, Vec3};
use dcd_simd::{Block, Lanes, WIDTH};
use triangle::Triangle;

/// How many supports either half of the search takes. Hulls of some thirty vertices need one and three. Smaller: more
/// casts are left to supports in f64.
const SUPPORTS: usize = 32;

/// Where the radius of the first sphere is between the inner radius, 0, and the outer one, 1. Decides the way.
const BETWEEN: f64 = 0.5;

/// How far the first three directions are from the normal there, as a tangent. Larger: a triangle that is more often
/// round the line, and farther from the face.
const SPREAD: f32 = 0.4;

/// The sine between ray and normal at which the sphere is met where the ray passes it by. Larger: a triangle seen from
/// its side.
const STEEPEST: f32 = 0.95;

/// How far across a difference's middle may be and count as straight ahead, scaled.
const STRAIGHT: f32 = 1e-6;

/// Up to 32 vertices, which are compared at once.
type Chunk = [Block; 2];

/// The bits of a product that the number of a vertex in a [`Chunk`] takes: a maximum carries it along. Of vertices within
/// 2⁻¹⁸ of the product of each other any may be the farthest.
const NUMBER: u32 = 2 * WIDTH as u32 - 1;

/// A shape's vertices in the axes of the ray.
pub(super) struct Turned<'p> {
    first: Chunk,
    /// The number of the second block's first vertex: 0 where it is the first block again.
    second: u32,
    /// Those past the first chunk, as they are in the shape: most hulls have none.
    rest: &'p [Block],
    /// What turns these: row k of the turn is axis k.
    rows: Mat3A,
}

impl<'p> Turned<'p> {
    /// Without vertices.
    #[inline(always)]
    pub(super) fn none() -> Self {
        Self { first: Chunk::default(), second: 0, rest: &[], rows: Mat3A::ZERO }
    }

    /// Takes in a shape; `None` if it has more than sixteen vertices and none in blocks.
    #[inline(always)]
    fn fill<L: Lanes>(&mut self, l: L, polytope: &'p Polytope, rows: Mat3A) -> Option<()> {
        let known = polytope.vertex_blocks();
        let own = match polytope.vertices() {
            few if known.is_empty() && few.len() <= WIDTH => {
                Block::relative(few, polytope.inner().centre).next()
            }
            _ => None,
        };
        let by = [
            splat(l, rows.x_axis.into()),
            splat(l, rows.y_axis.into()),
            splat(l, rows.z_axis.into()),
        ];
        let [low, high] = &mut self.first;
        let first = known.first().or(own.as_ref())?;
        turn(l, first, &by, low);
        // A vertex that is there twice has one number.
        turn(l, known.get(1).unwrap_or(first), &by, high);
        self.second = if known.len() > 1 { WIDTH as u32 } else { 0 };
        self.rest = known.get(2..).unwrap_or_default();
        self.rows = rows;
        Some(())
    }

    /// The number and the place of a vertex farthest along a direction, to within what its number takes of its bits.
    #[inline(always)]
    fn farthest<L: Lanes>(&self, l: L, direction: Vec3, splatted: &[L::F; 3]) -> (u32, Vec3) {
        let [low, high] = &self.first;
        let numbers = l.lane_numbers();
        let in_low = l.tag(low.along(l, splatted), l.splat_u(NUMBER), numbers);
        let numbers = l.add_u(numbers, l.splat_u(self.second));
        let in_high = l.tag(high.along(l, splatted), l.splat_u(NUMBER), numbers);
        let most = l.largest(l.max(in_low, in_high));
        let number = (most.to_bits() & NUMBER) as usize;
        let found = (number as u32, self.first[number / WIDTH].point(number % WIDTH));
        if self.rest.is_empty() {
            return found;
        }
        self.farther(l, direction, most).unwrap_or(found)
    }

    /// The farthest of the rest, if it is farther than that.
    #[inline(always)]
    fn farther<L: Lanes>(&self, l: L, direction: Vec3, most: f32) -> Option<(u32, Vec3)> {
        let splatted = splat(l, (self.rows * direction.to_vec3a()).into());
        // The blocks' numbers as bits of f32, which no operation reads as such.
        let (mut best, mut of) = (l.splat(most), l.splat(0.0));
        for (number, block) in self.rest.iter().enumerate() {
            let along = block.along(l, &splatted);
            let is_farther = l.lt(best, along);
            best = l.select(is_farther, along, best);
            of = l.select(is_farther, l.splat(f32::from_bits(number as u32)), of);
        }
        let farthest = l.largest(best);
        if !(farthest > most) {
            return None;
        }
        let lane = l.bits(l.le(l.splat(farthest), best)).trailing_zeros() as usize % WIDTH;
        let mut numbers = [0.0; WIDTH];
        l.store_to(of, &mut numbers);
        let number = numbers[lane].to_bits() as usize;
        let place = self.rows.transpose() * self.rest.get(number)?.point(lane).to_vec3a();
        Some((((2 + number) * WIDTH + lane) as u32, place.into()))
    }
}

/// A block's points by three rows of a matrix.
#[inline(always)]
fn turn<L: Lanes>(l: L, block: &Block, rows: &[[L::F; 3]; 3], to: &mut Block) {
    for (to, row) in to.0.iter_mut().zip(rows) {
        l.store(block.along(l, row), to);
    }
}

#[inline(always)]
fn splat<L: Lanes>(l: L, v: Vec3) -> [L::F; 3] {
    [l.splat(v.x), l.splat(v.y), l.splat(v.z)]
}

fn in_f32(matrix: &DMat3) -> Mat3A {
    let DMat3 { x_axis, y_axis, z_axis } = matrix;
    Mat3A::from_cols(x_axis.as_vec3a(), y_axis.as_vec3a(), z_axis.as_vec3a())
}

/// A vertex of the difference, scaled, and the numbers of the two that it stems from.
#[derive(Clone, Copy)]
pub(super) struct Corner {
    w: Vec3,
    pub(super) vertices: [u32; 2],
}

impl Corner {
    /// Where it is as seen along the ray.
    fn at(&self) -> Vec2 {
        self.w.truncate()
    }
}

/// A direction along which the difference is not met in time, in the axes, and a vertex lowest along it.
pub(super) struct Miss {
    pub(super) direction: Vec3,
    pub(super) corner: Corner,
}

/// The difference as the ray sees it.
pub(super) struct RayFrame<'t, 'p, L> {
    lanes: L,
    /// Both to the other side: what is farthest of them is lowest of the difference.
    sides: [&'t Turned<'p>; 2],
    middle: Vec3,
    /// Of a sphere that is about as large as the difference, scaled.
    radius: f32,
    /// How far the difference moves, scaled.
    way: f32,
    /// How near along the ray the search ends, scaled.
    near: f32,
}

impl<'t, 'p, L: Lanes> RayFrame<'t, 'p, L> {
    /// With axes of unit length, the last one against the ray. The sides' memory is the caller's, so that nothing large
    /// is moved.
    #[inline(always)]
    pub(super) fn of(
        lanes: L,
        difference: &Polytopes<'p>,
        axes: &DMat3,
        [way, near]: [f64; 2],
        [side_a, side_b]: [&'t mut Turned<'p>; 2],
    ) -> Option<Self> {
        let (a, b) = difference.maps();
        let [of_a, of_b] = &difference.rotations();
        let scale = difference.scale();
        let scaled = in_f32(axes) * scale as f32;
        // Rows of −R_A and R_B along the axes.
        side_a.fill(lanes, a, in_f32(of_a).transpose() * -scaled)?;
        side_b.fill(lanes, b, in_f32(of_b).transpose() * scaled)?;
        let outer = (a.outer_radius() + b.outer_radius()) * scale;
        let radius = difference.inner() * (1.0 - BETWEEN) + outer * BETWEEN;
        Some(Self {
            lanes,
            sides: [side_a, side_b],
            middle: (axes.transpose() * difference.middle()).as_vec3(),
            radius: radius as f32,
            way: way as f32,
            near: near as f32,
        })
    }

    /// The corners of the face that the ray enters through, counter-clockwise as seen along it, or a miss.
    #[inline(always)]
    pub(super) fn search(&self) -> Option<Result<[Corner; 3], Miss>> {
        let first = self.first_directions();
        let found = [self.lowest(first[0]), self.lowest(first[1]), self.lowest(first[2])];
        for (&direction, &(corner, separation)) in first.iter().zip(&found) {
            if self.is_missed(direction, separation) {
                return Some(Err(Miss { direction, corner }));
            }
        }
        match self.portal([found[0].0, found[1].0, found[2].0])? {
            Ok(corners) => self.face(&corners),
            missed => Some(missed),
        }
    }

    /// Three directions round the one that is normal to a sphere where the ray enters it.
    fn first_directions(&self) -> [Vec3; 3] {
        let across = self.middle.truncate();
        let far = across.length();
        let outward = if far > STRAIGHT { across / far } else { Vec2::X };
        let sin = (far / self.radius).min(STEEPEST);
        let cos = (1.0 - sin * sin).sqrt();
        let normal = (outward * sin).extend(-cos);
        let (up, aside) = ((outward * cos).extend(sin) * SPREAD, outward.perp().extend(0.0));
        // Half the side of a triangle in a circle of that radius.
        let aside = aside * (0.75f32.sqrt() * SPREAD);
        [normal + up, normal - up * 0.5 + aside, normal - up * 0.5 - aside]
    }

    /// The vertex lowest along a direction, and the separation there.
    #[inline(always)]
    fn lowest(&self, direction: Vec3) -> (Corner, f32) {
        let splatted = splat(self.lanes, direction);
        let (a, in_a) = self.sides[0].farthest(self.lanes, direction, &splatted);
        let (b, in_b) = self.sides[1].farthest(self.lanes, direction, &splatted);
        let w = self.middle - (in_a + in_b);
        (Corner { w, vertices: [a, b] }, direction.dot(w))
    }

    /// Whether that separation along a direction is not closed before the end of the way.
    fn is_missed(&self, direction: Vec3, separation: f32) -> bool {
        separation > 0.0 && separation > -direction.z * self.way
    }

    /// From any three corners to three round the ray's line: over the edge that the line is behind there is a corner
    /// behind the line, or a direction that misses it.
    #[inline(always)]
    fn portal(&self, mut corners: [Corner; 3]) -> Option<Result<[Corner; 3], Miss>> {
        let cross = |i: &Corner, j: &Corner| i.at().perp_dot(j.at());
        let [p, q, r] = &corners;
        let mut side = [cross(p, q), cross(q, r), cross(r, p)];
        if side[0] + side[1] + side[2] < 0.0 {
            corners.swap(1, 2);
            side = [-side[2], -side[1], -side[0]];
        }
        for _ in 0..SUPPORTS {
            let last = if side[1] < side[2] { 1 } else { 2 };
            let k = if side[0] < side[last] { 0 } else { last };
            if side[k] >= 0.0 {
                return Some(Ok(corners));
            }
            let (from, to) = (corners[k], corners[(k + 1) % 3]);
            let direction = (to.at() - from.at()).perp().extend(0.0);
            let (corner, separation) = self.lowest(direction);
            if self.is_missed(direction, separation) {
                return Some(Err(Miss { direction, corner }));
            }
            if corner.vertices == from.vertices || corner.vertices == to.vertices {
                return None;
            }
            corners = [from, corner, to];
            side = [cross(&from, &corner), cross(&corner, &to), -side[k]];
        }
        None
    }

    /// From three corners round the line to the face that the ray enters through.
    #[inline(always)]
    fn face(&self, corners: &[Corner; 3]) -> Option<Result<[Corner; 3], Miss>> {
        let mut triangle = Triangle::of(corners);
        for _ in 0..SUPPORTS {
            let direction = triangle.normal();
            let (corner, separation) = self.lowest(direction);
            if self.is_missed(direction, separation) {
                return Some(Err(Miss { direction, corner }));
            }
            let slope = -direction.z;
            // Written so that NaN ends it.
            if !(slope > 0.0) {
                return None;
            }
            let height = direction.dot(triangle.first()) - separation;
            if height <= self.near * slope || triangle.has(&corner) {
                return Some(Ok(triangle.corners()));
            }
            let dropped = triangle.dropped_for(&corner);
            if !dropped.any() {
                return None;
            }
            triangle.exchange(dropped, &corner);
        }
        None
    }
}

mod triangle;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gjk::unit;
    use crate::motion::tests::Draw;
    use crate::{Difference, PosedSupport};
    use dcd_geom::Pose;
    use dcd_geom::glam::{DQuat, DVec3};
    use dcd_simd::{Kernel, Path, dispatch_on};

    /// What is found along some directions, then at the end of the search.
    struct Found<'a, 'b> {
        difference: &'a Polytopes<'b>,
        axes: DMat3,
        directions: [Vec3; 8],
    }

    type End = Option<Result<[[u32; 2]; 3], Vec3>>;

    impl Kernel for Found<'_, '_> {
        type Output = Option<([([u32; 2], f32); 8], End)>;

        #[inline(always)]
        fn run<L: Lanes>(self, l: L) -> Self::Output {
            let Self { difference, axes, directions } = self;
            let (mut a, mut b) = (Turned::none(), Turned::none());
            let frame = RayFrame::of(l, difference, &axes, [2.0, 1e-6], [&mut a, &mut b])?;
            let mut along = [([0; 2], 0.0); 8];
            for (along, direction) in along.iter_mut().zip(directions) {
                let (corner, separation) = frame.lowest(direction);
                *along = (corner.vertices, separation);
            }
            let end = frame.search().map(|end| match end {
                Ok([p, q, r]) => Ok([p.vertices, q.vertices, r.vertices]),
                Err(miss) => Err(miss.direction),
            });
            Some((along, end))
        }
    }

    /// Whether the line through the origin along z passes between three points, by more than what f32 leaves or not.
    fn is_between(points: [DVec3; 3]) -> bool {
        let at = points.map(|point| point.truncate());
        (0..3).all(|k| at[k].perp_dot(at[(k + 1) % 3]) >= -1e-6)
    }

    #[test]
    fn f32_leads_to_the_face_that_the_ray_enters_or_to_a_miss_on_every_path() {
        let seed = std::env::var("DCD_SEED").map_or(5, |seed| seed.parse().expect("a seed"));
        let mut draw = Draw(seed);
        let [mut faces, mut misses, mut open] = [0; 3];
        for k in 0..1200 {
            // Some without blocks, some with one, some with more than a chunk.
            let mut hull = |count| Polytope::hull((0..count).map(|_| draw.vector()).collect());
            let (a, b) = (hull(4 + k % 90).unwrap(), hull(4 + k / 3 % 60).unwrap());
            let turn = DQuat::from_scaled_axis(draw.vector() * 3.0).normalize();
            let pose_a = Pose::new(turn, draw.vector() * 3.0).unwrap();
            let pose_b = Pose::from_translation(draw.vector() * 3.0).unwrap();
            let posed = (PosedSupport::polytope(&a, &pose_a), PosedSupport::polytope(&b, &pose_b));
            let difference = Difference::new(posed.0, posed.1).unwrap();
            let [w, velocity] = [difference.middle(), draw.vector()];
            let z = (velocity * 0.5 - w).normalize();
            let (x, y) = z.any_orthonormal_pair();
            let axes = DMat3::from_cols(x, y, z);
            let directions = [(); 8].map(|()| draw.vector().as_vec3());
            let found = [Path::Avx2, Path::Avx512, Path::Portable]
                .map(|path| dispatch_on(path, Found { difference: &difference, axes, directions }));
            assert!(found[0] == found[1] && found[1] == found[2], "{seed} {k}");
            let (along, end) = found[0].unwrap();
            let world = |direction: Vec3| axes * direction.as_dvec3();
            for (direction, (_, separation)) in directions.into_iter().zip(along) {
                let expected = difference.lowest(world(direction)).1;
                assert!((f64::from(separation) - expected).abs() < 2e-6, "{seed} {k}");
            }
            let exactly = |direction: DVec3| {
                let direction = unit::<f64>(direction.to_array()).unwrap();
                (direction, difference.lowest(direction).1)
            };
            match end {
                Some(Ok(corners)) => {
                    faces += 1;
                    let corners = corners.map(|[of_a, of_b]| {
                        let last = [a.vertices().len() - 1, b.vertices().len() - 1];
                        let at = |number: u32, last: usize| (number as usize).min(last);
                        let in_a = a.vertices()[at(of_a, last[0])];
                        difference.world(in_a, b.vertices()[at(of_b, last[1])])
                    });
                    assert!(is_between(corners.map(|w| axes.transpose() * w)), "{seed} {k}");
                    let [p, q, r] = corners;
                    let (direction, lowest) = exactly((r - p).cross(q - p));
                    // Nothing is in front of the face, as seen along the ray.
                    let slope = -direction.dot(z);
                    assert!(direction.dot(p) - lowest <= 1e-5 * slope.max(0.1), "{seed} {k}");
                }
                Some(Err(direction)) => {
                    misses += 1;
                    let (direction, separation) = exactly(world(direction));
                    let closed = -direction.dot(z) * 2.0;
                    assert!(separation > -1e-6 && separation > closed - 1e-6, "{seed} {k}");
                }
                None => open += 1,
            }
        }
        assert!(faces > 300 && misses > 100 && open < 60, "{faces} {misses} {open}");
    }
}
