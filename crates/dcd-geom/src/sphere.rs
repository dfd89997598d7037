//! Spheres inside and around a point set, in microseconds a shape.

use crate::support::farthest;
use glam::DVec3;

/// A sphere in a shape's own frame, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Its centre.
    pub centre: DVec3,
    /// Its radius, at least 0.
    pub radius: f64,
}

/// Unit roundoff of f64.
const U: f64 = f64::EPSILON / 2.0;

/// How often the centre is pushed away from the nearest face. No unit. Fewer: smaller inner
/// spheres, so that more pairs need a solver. More: microseconds a shape.
const PUSHES: usize = 40;

/// The first push, relative to the shape's size; each later one is shorter by the decay.
const FIRST_PUSH: f64 = 0.2;

/// See [`FIRST_PUSH`].
const PUSH_DECAY: f64 = 0.88;

impl Sphere {
    /// A sphere that lies inside the hull of `points`, as large as a few microseconds can find.
    ///
    /// Sound for any points: its radius is proved, with rounding, and is 0 where the hull is flat or nothing
    /// could be proved; the centre is then the mean of some of the points, within 2.02 units of 2⁻⁵³ of the
    /// largest length of a point from the hull. A closed surface of triangles between some of the points is
    /// made; if every triangle sees the centre on its inner side, every point of an open sphere that misses
    /// all triangles has the centre's winding number and is inside the hull, however wrong the surface may
    /// otherwise be (docs/numerics/proofs.md, "inner spheres").
    pub fn inside(points: &[DVec3]) -> Self {
        let chosen = extreme_points(points);
        if let Some(sphere) = Surface::around(&chosen).and_then(|surface| inside_of(&surface)) {
            return sphere;
        }
        Self::at_mean(&chosen)
    }

    /// A sphere of radius 0 at the mean of the points: of a set that has no sphere inside. The mean is
    /// within 2.02u of the largest length of a point from the hull (docs/numerics/proofs.md, "centres").
    pub(crate) fn at_mean(points: &[DVec3]) -> Self {
        Self { centre: mean(points), radius: 0.0 }
    }

    /// The smallest sphere round `centre` that holds all `points`, its radius rounded up.
    pub fn around(centre: DVec3, points: &[DVec3]) -> Self {
        Self { centre, radius: reach(points.iter().map(|&p| p - centre)) }
    }
}

/// The mean of the points, each coordinate within 2.02u of the exact one; the first point, which is
/// in the hull itself, where a sum overflows; the origin for no point at all.
///
/// What a sum loses is added up beside it (Ogita, Rump and Oishi 2005), so that the number of points
/// does not count. A plain sum of 98 would be off by a hundred roundings: certificates that take the
/// centre for a point of the shape would be false far from the origin of the shape's own frame.
fn mean(points: &[DVec3]) -> DVec3 {
    let first = points.first().copied().unwrap_or(DVec3::ZERO);
    let (mut sum, mut lost) = (DVec3::ZERO, DVec3::ZERO);
    for &p in points {
        let next = sum + p;
        // The sum's own rounding, exactly (Knuth's two-sum).
        let part = next - sum;
        lost += (sum - (next - part)) + (p - part);
        sum = next;
    }
    let mean = (sum + lost) / points.len().max(1) as f64;
    // An overflow makes a NaN of what was lost.
    if mean.is_finite() { mean } else { first }
}

/// The largest length of the vectors, rounded up; scaled, so that no square over- or underflows.
pub(crate) fn reach(vectors: impl Iterator<Item = DVec3> + Clone) -> f64 {
    let largest = vectors.clone().fold(0.0, |m: f64, v| m.max(v.abs().max_element()));
    if largest == 0.0 {
        return 0.0;
    }
    let longest = vectors.fold(0.0, |m: f64, v| m.max((v / largest).length_squared()));
    // Subtraction, division, three squares, two sums, root and product: 6u, and a margin.
    (longest.sqrt() * (1.0 + 8.0 * U) * largest).next_up()
}

/// How far outside of a face a point must be to be added to the surface, relative to the cloud's
/// size. Well above the rounding of a height, so that a face's own corners never see it; what it
/// leaves out of the inner sphere is as small.
const COPLANAR: f64 = 1e-12;

/// Up to this many points all are taken; of more, the supports in [`directions`].
const FEW: usize = 64;

/// The points that span the surface.
pub(crate) fn extreme_points(points: &[DVec3]) -> Vec<DVec3> {
    if points.len() <= FEW {
        return points.to_vec();
    }
    let mut chosen: Vec<u32> = directions().map(|d| farthest::<f64>(points, d).feature).collect();
    chosen.sort_unstable();
    chosen.dedup();
    chosen.into_iter().map(|k| points[k as usize]).collect()
}

/// The 98 directions to the points of a lattice of five a side that hide no other.
fn directions() -> impl Iterator<Item = DVec3> {
    let lattice = (0..125).map(|k| [k % 5 - 2, k / 5 % 5 - 2, k / 25 - 2]);
    let primitive = lattice.filter(|d: &[i32; 3]| d.iter().any(|x| x.abs() == 1));
    primitive.map(|d| DVec3::from_array(d.map(f64::from)))
}

/// A closed surface of triangles, made by adding one point after the other to a tetrahedron.
///
/// Rounding may make it other than the hull, never open: a point takes the place of the triangles
/// that it sees by the cone over their boundary, whichever they are.
pub(crate) struct Surface<'p> {
    points: &'p [DVec3],
    faces: Vec<Face>,
}

impl<'p> Surface<'p> {
    /// `None` where the points are flat, or an overflow leaves no normal.
    pub(crate) fn around(points: &'p [DVec3]) -> Option<Self> {
        let corners = tetrahedron(points)?;
        let mut surface = Self { points, faces: Vec::with_capacity(2 * points.len()) };
        for skipped in 0..4 {
            let [a, b, c] = [1, 2, 3].map(|k| corners[(skipped + k) % 4]);
            // Every other turn of four corners is odd.
            let outward = if skipped % 2 == 1 { [a, b, c] } else { [a, c, b] };
            surface.add(outward)?;
        }
        let size = reach(points.iter().map(|&p| p - points[0]));
        let mut edges = Vec::new();
        for (k, &p) in (0u32..).zip(points) {
            edges.clear();
            surface.faces.retain(|face| {
                let sees = face.height(points, p) < -COPLANAR * size;
                if sees {
                    let corners = face.corners;
                    edges.extend((0..3).map(|e| [corners[e], corners[(e + 1) % 3]]));
                }
                !sees
            });
            for &[a, b] in &edges {
                if !edges.contains(&[b, a]) {
                    surface.add([a, b, k])?;
                }
            }
        }
        Some(surface)
    }

    /// Each triangle's inward normal, of unit length but for rounding, and how far along it the
    /// nearest of its corners is outside of `centre`: see [`Face::clearance`].
    pub(crate) fn planes(&self, centre: DVec3) -> impl Iterator<Item = (DVec3, f64)> + '_ {
        self.faces.iter().map(move |face| (face.inward, face.clearance(self.points, centre)))
    }

    /// The corners of all faces, one face after the other.
    fn corners(&self) -> impl Iterator<Item = DVec3> + Clone + '_ {
        self.faces.iter().flat_map(|face| face.at(self.points))
    }

    fn add(&mut self, corners: [u32; 3]) -> Option<()> {
        self.faces.push(Face::new(self.points, corners)?);
        Some(())
    }
}

/// Four points far from one plane, the last on the inner side of the triangle of the others.
fn tetrahedron(points: &[DVec3]) -> Option<[u32; 4]> {
    let a = *points.first()?;
    let most = |height: &dyn Fn(DVec3) -> f64| {
        let heights = (0u32..).zip(points).map(|(k, &p)| (height(p), k));
        heights.max_by(|x, y| x.0.total_cmp(&y.0)).filter(|(height, _)| *height > 0.0)
    };
    let (_, b) = most(&|p| (p - a).length_squared())?;
    let ab = points[b as usize] - a;
    let (_, c) = most(&|p| ab.cross(p - a).length_squared())?;
    let normal = ab.cross(points[c as usize] - a);
    let (_, d) = most(&|p| normal.dot(p - a).abs())?;
    let outward = normal.dot(points[d as usize] - a) < 0.0;
    Some(if outward { [0, b, c, d] } else { [0, c, b, d] })
}

/// A triangle of the made surface: its corners by number, and its inward normal, of unit length but
/// for rounding.
struct Face {
    corners: [u32; 3],
    inward: DVec3,
}

impl Face {
    fn new(points: &[DVec3], corners: [u32; 3]) -> Option<Self> {
        let [a, b, c] = corners.map(|k| points[k as usize]);
        let normal = (c - a).cross(b - a);
        let length = normal.length();
        // False for NaN too, which an overflow makes.
        (length > 0.0 && length.is_finite()).then(|| Self { corners, inward: normal / length })
    }

    fn at(&self, points: &[DVec3]) -> [DVec3; 3] {
        self.corners.map(|k| points[k as usize])
    }

    /// How far `p` is on the inner side, approximately.
    fn height(&self, points: &[DVec3], p: DVec3) -> f64 {
        self.inward.dot(p - points[self.corners[0] as usize])
    }

    /// Whether det(a − p, b − p, c − p) is surely positive: p is on the inner side.
    fn surely_sees(&self, points: &[DVec3], p: DVec3) -> bool {
        let [a, b, c] = self.at(points).map(|corner| corner - p);
        let (m, n) = (b.abs(), c.abs());
        let minors =
            DVec3::new(m.y * n.z + m.z * n.y, m.z * n.x + m.x * n.z, m.x * n.y + m.y * n.x);
        // Three rounded differences and five operations a term: 8u of the permanent, doubled.
        a.dot(b.cross(c)) > 16.0 * U * a.abs().dot(minors) + f64::MIN_POSITIVE
    }

    /// A lower bound on the distance from `p` to the triangle, up to rounding.
    fn clearance(&self, points: &[DVec3], p: DVec3) -> f64 {
        let along = self.at(points).map(|corner| self.inward.dot(p - corner));
        along.into_iter().fold(f64::INFINITY, f64::min) / self.inward.length()
    }
}

fn inside_of(surface: &Surface<'_>) -> Option<Sphere> {
    let centre = deepest(surface)?;
    let radius = proved_radius(surface, centre)?;
    Some(Sphere { centre, radius })
}

/// A point far from all faces: from their mean, pushed away from the nearest one again and again,
/// by steps that shrink.
fn deepest(surface: &Surface<'_>) -> Option<DVec3> {
    let weight = 1.0 / (3 * surface.faces.len()).max(1) as f64;
    let mut centre = surface.corners().fold(DVec3::ZERO, |sum, p| sum + p * weight);
    let mut planes = Planes::of(surface);
    let (mut height, mut nearest) = planes.nearest(centre)?;
    let (mut best, mut best_height) = (centre, height);
    let mut step = FIRST_PUSH * reach(surface.corners().map(|p| p - centre));
    for _ in 0..PUSHES {
        centre += surface.faces[nearest].inward * step;
        (height, nearest) = planes.nearest(centre)?;
        if height > best_height {
            (best, best_height) = (centre, height);
        }
        step *= PUSH_DECAY;
    }
    Some(best)
}

/// The planes of all faces, four at a time: a row a coordinate, which any compiler makes vectors of.
struct Planes {
    blocks: Vec<PlaneBlock>,
    heights: Vec<[f64; 4]>,
}

#[derive(Clone, Copy, Default)]
struct PlaneBlock {
    inward: [[f64; 4]; 3],
    base: [[f64; 4]; 3],
}

impl Planes {
    /// The last block is filled up with the last face.
    fn of(surface: &Surface<'_>) -> Self {
        let block = |faces: &[Face]| {
            let mut block = PlaneBlock::default();
            for lane in 0..4 {
                let face = &faces[lane.min(faces.len() - 1)];
                for axis in 0..3 {
                    block.inward[axis][lane] = face.inward[axis];
                    block.base[axis][lane] = surface.points[face.corners[0] as usize][axis];
                }
            }
            block
        };
        let blocks: Vec<_> = surface.faces.chunks(4).map(block).collect();
        Self { heights: vec![[0.0; 4]; blocks.len()], blocks }
    }

    /// The least height of a point above a face, and the first face that it is that of: as
    /// [`Face::height`] has it, bit for bit.
    fn nearest(&mut self, p: DVec3) -> Option<(f64, usize)> {
        let mut least = [f64::INFINITY; 4];
        for (PlaneBlock { inward, base }, heights) in self.blocks.iter().zip(&mut self.heights) {
            for lane in 0..4 {
                // Written out: a closure here stays out of line in a build of many codegen units.
                let x = inward[0][lane] * (p.x - base[0][lane]);
                let y = inward[1][lane] * (p.y - base[1][lane]);
                let z = inward[2][lane] * (p.z - base[2][lane]);
                heights[lane] = x + y + z;
                least[lane] = if heights[lane] < least[lane] { heights[lane] } else { least[lane] };
            }
        }
        let least = least.into_iter().fold(f64::INFINITY, f64::min);
        let face = self.heights.as_flattened().iter().position(|&height| height == least)?;
        Some((least, face))
    }
}

/// The radius of a sphere round `centre` that surely misses every face, if every face surely sees
/// the centre on its inner side.
fn proved_radius(surface: &Surface<'_>, centre: DVec3) -> Option<f64> {
    let Surface { points, faces } = surface;
    let mut clearance = f64::INFINITY;
    for face in faces {
        if !face.surely_sees(points, centre) {
            return None;
        }
        clearance = clearance.min(face.clearance(points, centre));
    }
    let size = reach(surface.corners().map(|p| p - centre));
    let radius = clearance * (1.0 - 8.0 * U) - 5.0 * U * size * (1.0 + 8.0 * U);
    // False for NaN and for no face at all.
    (radius > 0.0 && radius.is_finite()).then_some(radius)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube() -> Vec<DVec3> {
        (0..8).map(|k| DVec3::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64)).collect()
    }

    /// Points in a box by a linear congruence.
    fn cloud(count: usize, size: DVec3) -> Vec<DVec3> {
        let mut state = 7u64;
        let mut unit = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        (0..count).map(|_| DVec3::new(unit(), unit(), unit()) * size).collect()
    }

    #[test]
    fn the_surface_is_closed_and_holds_every_point() {
        let clouds = [cube(), cloud(10, DVec3::ONE), cloud(60, DVec3::new(1.0, 0.1, 5.0))];
        for points in clouds {
            let faces = Surface::around(&points).unwrap().faces;
            let edges: Vec<[u32; 2]> = faces
                .iter()
                .flat_map(|face| (0..3).map(|e| [face.corners[e], face.corners[(e + 1) % 3]]))
                .collect();
            for &[a, b] in &edges {
                assert_eq!(edges.iter().filter(|e| **e == [b, a]).count(), 1);
            }
            for face in &faces {
                assert!(points.iter().all(|&p| face.height(&points, p) > -1e-12));
            }
        }
    }

    #[test]
    fn the_inner_sphere_of_a_large_cloud_is_found_from_its_extreme_points() {
        let sphere = Sphere::inside(&cloud(1000, DVec3::ONE));
        let walls = sphere.centre.min(DVec3::ONE - sphere.centre).min_element();
        assert!(sphere.radius <= walls && sphere.radius > 0.4, "{sphere:?}");
    }

    #[test]
    fn the_inner_sphere_of_a_cube_is_inside_and_large() {
        let sphere = Sphere::inside(&cube());
        let walls = sphere.centre.min(DVec3::ONE - sphere.centre).min_element();
        assert!(sphere.radius <= walls && sphere.radius > 0.48, "{sphere:?}");
    }

    #[test]
    fn the_inner_sphere_of_an_octahedron_is_inside_and_large() {
        let axes = [DVec3::X, DVec3::Y, DVec3::Z];
        let points: Vec<DVec3> = axes.into_iter().flat_map(|d| [d, -d]).collect();
        let sphere = Sphere::inside(&points);
        // |x| + |y| + |z| ≤ 1 holds at the sphere's farthest point along (1, 1, 1).
        let farthest = sphere.centre.abs().element_sum() + sphere.radius * 3f64.sqrt();
        assert!(farthest <= 1.0 && sphere.radius > 0.5, "{sphere:?}");
    }

    #[test]
    fn flat_collinear_single_and_huge_sets_have_an_inner_sphere_of_zero() {
        let flat: Vec<DVec3> = cube().into_iter().map(|p| p * DVec3::new(1.0, 1.0, 0.0)).collect();
        let line: Vec<DVec3> = (0..5).map(|k| DVec3::new(1.0, 2.0, 3.0) * k as f64).collect();
        let huge: Vec<DVec3> = cube().into_iter().map(|p| p * f64::MAX).collect();
        for points in [flat, line, vec![DVec3::ONE], huge] {
            let sphere = Sphere::inside(&points);
            assert_eq!(sphere.radius, 0.0);
            assert!(sphere.centre.is_finite());
        }
    }

    #[test]
    fn the_centre_of_a_set_without_an_inner_sphere_is_the_mean_to_two_roundings() {
        let far = |x: f64, y: f64, z: f64| DVec3::new(x, y, z) * 2135251731709.0234;
        let line = |count: u32| (0..count).map(|k| far(1.0, -0.3, 0.7) + DVec3::X * f64::from(k));
        let copies = |count: usize| std::iter::repeat_n(far(1.0, 1.0, 1.0), count);
        let flat = |count: u32| {
            let point = |k: u32| far(f64::from(k % 7) * 0.1, f64::from(k * k % 11) / 3.0, 0.0);
            (0..count).map(point)
        };
        for count in 1..=98 {
            let sets = [line(count).collect(), copies(count as usize).collect::<Vec<_>>()];
            for points in sets.into_iter().chain([flat(count).collect()]) {
                let centre = Sphere::at_mean(&points).centre;
                for axis in 0..3 {
                    // All are whole multiples of 2⁻²⁰ metres: exact in i128.
                    let unit = 2f64.powi(20);
                    let whole = |x: f64| {
                        let scaled = x * unit;
                        assert!(scaled.abs() < 1e30);
                        scaled as i128
                    };
                    let sum: i128 = points.iter().map(|p| whole(p[axis])).sum();
                    let fraction = points.iter().all(|p| (p[axis] * unit).fract() == 0.0);
                    assert!(fraction && (centre[axis] * unit).fract() == 0.0);
                    let off = (whole(centre[axis]) * i128::from(count) - sum).unsigned_abs() as f64;
                    let allowed = 2.02 * U * sum.unsigned_abs() as f64;
                    assert!(off <= allowed, "{count} points: {off} of {allowed}");
                }
            }
        }
        assert_eq!(Sphere::at_mean(&[DVec3::MAX; 5]).centre, DVec3::MAX);
    }

    #[test]
    fn the_outer_sphere_holds_every_point() {
        let points = cube();
        let sphere = Sphere::around(DVec3::splat(0.3), &points);
        assert!(points.iter().all(|p| p.distance(sphere.centre) <= sphere.radius));
        assert!(sphere.radius < 3f64.sqrt() * 0.7 + 1e-12);
    }
}
