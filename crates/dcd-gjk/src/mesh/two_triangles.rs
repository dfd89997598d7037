//! How deep two triangles overlap that touch, by their eleven axes: in f64 with a bound
//! (docs/numerics/proofs.md, "two triangles").

use super::bounds::U64;
use super::cuboid::{AXIS, PLACED};
use super::reach::Couple;
use super::side::Part;
use crate::closed::nearest_of_triangle;
use crate::epa::Depth;
use dcd_geom::Pose;
use dcd_geom::glam::DVec3;
use dcd_simd::{larger, smaller};
use std::hint::select_unpredictable;

/// The sine between an edge of each below which no axis is taken from the two. Larger: pairs that are searched. Smaller: axes
/// that are rounding.
const PARALLEL: f64 = 1e-9;

/// Products of two lengths, metres², whose squares are clear of underflow. Smaller: directions that are rounding.
const SHORTEST: f64 = 1e-120;

/// How often the witnesses are brought nearer to each other. No unit. Smaller: wider bounds.
const ROUNDS: usize = 4;

/// How far the witnesses may be beside each other to be brought no nearer. Unit: u of the sizes. Larger: wider bounds.
const OVER: f64 = 9.0;

/// Two triangles; the first's first corner is the origin of world axes.
struct Triangles {
    corners: [[DVec3; 3]; 2],
    /// From each corner to the next one, and how long that is.
    edges: [[DVec3; 3]; 2],
    lengths: [[f64; 3]; 2],
    /// At least the length of every vector from the one to the other.
    span: f64,
}

/// The axis of the least reach so far, and what is known of all.
struct Least {
    reach: f64,
    /// From the first to the second, of unit length.
    normal: DVec3,
    feature: Axis,
    /// No axis reaches less, but for rounding.
    at_least: f64,
}

/// Of which features the axis is the normal.
#[derive(Clone, Copy)]
enum Axis {
    Face(usize),
    /// An edge of each, by its first corner.
    Edges(usize, usize),
}

impl Couple<'_> {
    /// The depth of two triangles that touch, from the first to the second. `None` of other parts, of needles and of triangles
    /// with edges that are nearly parallel, and of those of which it is not known that their cores overlap.
    pub(super) fn of_two_triangles(&self) -> Option<Depth> {
        let [
            Part::Triangle { corners: of_a, radius: radius_a, .. },
            Part::Triangle { corners: of_b, radius: radius_b, .. },
        ] = self.parts()
        else {
            return None;
        };
        let [turn_a, turn_b] = self.poses().map(Pose::rotation);
        let first = *turn_a * of_a[0];
        let to_b = self.delta() - first;
        let pair = Triangles::of([
            [DVec3::ZERO, *turn_a * of_a[1] - first, *turn_a * of_a[2] - first],
            [*turn_b * of_b[0] + to_b, *turn_b * of_b[1] + to_b, *turn_b * of_b[2] + to_b],
        ]);
        let radius = radius_a + radius_b;
        let deviation = self.poses()[0].deviation() + self.poses()[1].deviation();
        let off = (PLACED * U64 + 4.0 * deviation) * self.size();
        let least = pair.least()?;
        let at_least = least.at_least - AXIS * U64 * pair.span;
        // Of cores that do not meet, the axes do not bound what the radii overlap.
        if !(at_least > off) {
            return None;
        }
        let (at_b, beside) = pair.witness(&least)?;
        let (normal, depth) = (least.normal, least.reach + radius);
        let open = (least.reach - at_least).max(0.0) + off;
        let error_bound = open + beside + AXIS * U64 * (self.size() + radius);
        let point_b = self.poses()[0].translation() + (first + at_b - normal * *radius_b);
        let point_a = point_b + normal * depth;
        let found = Depth { depth, normal, point_a, point_b, error_bound };
        (depth.is_finite() && error_bound.is_finite()).then_some(found)
    }
}

impl Triangles {
    fn of(corners: [[DVec3; 3]; 2]) -> Self {
        let edges = corners.map(|[p, q, r]| [q - p, r - q, p - r]);
        let lengths = edges.map(|edges| edges.map(DVec3::length));
        let [longest_a, longest_b] = lengths.map(longest);
        let span = corners[1][0].length() + longest_a + longest_b;
        Self { corners, edges, lengths, span }
    }

    /// The axis along which they reach least past each other. `None` where one is not known.
    fn least(&self) -> Option<Least> {
        let [a, b] = &self.corners;
        let mut least = Least {
            reach: f64::INFINITY,
            normal: DVec3::ZERO,
            feature: Axis::Face(0),
            at_least: f64::INFINITY,
        };
        for face in 0..2 {
            let normal = self.edges[face][0].cross(self.edges[face][1]);
            let area = normal.length();
            // Written so that NaN is no triangle.
            if !(area > SHORTEST) {
                return None;
            }
            let (axis, longest) = (normal / area, longest(self.lengths[face]));
            let along = |corners: &[DVec3; 3]| corners.map(|corner| axis.dot(corner));
            let off = AXIS * U64 * longest * longest / area * self.span;
            least.add((Axis::Face(face), axis), [ends(along(a)), ends(along(b))], off);
        }
        for i in 0..3 {
            // Both ends of an edge are at one height.
            let (e, from_a, opposite_a) = (self.edges[0][i], a[i], a[(i + 2) % 3]);
            for j in 0..3 {
                let (f, from_b, opposite_b) = (self.edges[1][j], b[j], b[(j + 2) % 3]);
                let product = e.cross(f);
                let (length, most) = (product.length(), self.lengths[0][i] * self.lengths[1][j]);
                // Written so that NaN is no axis.
                if !(length > PARALLEL * most && length > SHORTEST) {
                    return None;
                }
                let inverse = 1.0 / length;
                let axis = product * inverse;
                let [from_a, opposite_a] = [axis.dot(from_a), axis.dot(opposite_a)];
                let [from_b, opposite_b] = [axis.dot(from_b), axis.dot(opposite_b)];
                let heights = [
                    [smaller(from_a, opposite_a), larger(from_a, opposite_a)],
                    [smaller(from_b, opposite_b), larger(from_b, opposite_b)],
                ];
                let off = AXIS * U64 * most * inverse * self.span;
                least.add((Axis::Edges(i, j), axis), heights, off);
            }
        }
        Some(least)
    }

    /// The point of the second that is deepest along the least axis, under a point of the first; and how far the two are beside
    /// each other.
    fn witness(&self, least: &Least) -> Option<(DVec3, f64)> {
        let ([a, b], normal) = (self.corners, least.normal);
        let up = normal * least.reach;
        let mut at = match least.feature {
            Axis::Face(0) => lowest(b, normal),
            Axis::Face(_) => nearest_of_triangle(b, lowest(a, -normal) - up),
            Axis::Edges(i, j) => {
                // Where they cross, seen along the normal.
                let (e, f) = (self.edges[0][i], self.edges[1][j]);
                let product = e.cross(f);
                let apart = a[i] - b[j] - up;
                let share = -apart.cross(e).dot(product) / product.length_squared();
                b[j] + f * share.clamp(0.0, 1.0)
            }
        };
        let near = OVER * U64 * self.span;
        let mut beside = f64::INFINITY;
        for _ in 0..ROUNDS {
            let over = nearest_of_triangle(a, at + up);
            beside = over.distance(at + up);
            if beside <= near {
                break;
            }
            at = nearest_of_triangle(b, over - up);
        }
        // Of the last step the witness is of the second, and nearer.
        beside.is_finite().then_some((at, beside))
    }
}

impl Least {
    /// Compares an axis of unit length, which may be off the true one by that much of a reach, metres: between which heights
    /// each triangle is.
    #[inline(always)]
    fn add(
        &mut self,
        (feature, axis): (Axis, DVec3),
        [[low_a, high_a], [low_b, high_b]]: [[f64; 2]; 2],
        off: f64,
    ) {
        // The second goes along the axis, or against it.
        let (forth, back) = (high_a - low_b, high_b - low_a);
        let is_back = forth > back;
        let reach = select_unpredictable(is_back, back, forth);
        self.at_least = smaller(self.at_least, reach - off);
        if reach < self.reach {
            self.reach = reach;
            self.normal = if is_back { -axis } else { axis };
            self.feature = feature;
        }
    }
}

/// The least and the greatest.
#[inline(always)]
fn ends([p, q, r]: [f64; 3]) -> [f64; 2] {
    [smaller(smaller(p, q), r), larger(larger(p, q), r)]
}

fn longest([p, q, r]: [f64; 3]) -> f64 {
    larger(larger(p, q), r)
}

/// The corner that is least far along a direction, the first of equals.
fn lowest([p, q, r]: [DVec3; 3], direction: DVec3) -> DVec3 {
    let along = [direction.dot(p), direction.dot(q), direction.dot(r)];
    let (low, corner) = if along[1] < along[0] { (along[1], q) } else { (along[0], p) };
    if along[2] < low { r } else { corner }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::tests::Draw;
    use crate::{Depths, PairSolver, PosedShape, Verdict};
    use dcd_geom::glam::DQuat;
    use dcd_geom::{Polytope, Shape};

    /// The search is the other method.
    #[test]
    fn two_triangles_are_as_deep_as_the_search_finds() {
        let mut draw = Draw(81);
        let (mut faces, mut edges, mut left) = (0, 0, 0);
        for k in 0..20_000 {
            let size = [1.0, 0.3, 10.0, 1e-3][k % 4];
            let far = draw.vector() * [0.0, 1.0, 1e4][k / 4 % 3] * size;
            let radii = [[0.0; 2], [0.05, 0.0], [0.02, 0.1]][k / 12 % 3];
            let corners = [0; 2].map(|_| [0; 3].map(|_| draw.vector() * size));
            let poses = [0; 2].map(|_| {
                let turn = DQuat::from_scaled_axis(draw.vector() * 3.0);
                Pose::new(turn, far + draw.vector() * (0.4 * size)).unwrap()
            });
            let shapes = [0, 1].map(|k| {
                let core = Polytope::mesh_triangle(corners[k]).unwrap();
                Shape::from(core.rounded(radii[k] * size).unwrap())
            });
            let [a, b] = [0, 1].map(|k| PosedShape { shape: &shapes[k], pose: &poses[k] });
            let parts = [0, 1].map(|k| Part::Triangle {
                corners: corners[k],
                reach: shapes[k].reach(),
                radius: radii[k] * size,
            });
            let couple = Couple::of(parts, [&poses[0], &poses[1]]).unwrap();
            let Some(found) = couple.of_two_triangles() else {
                left += 1;
                continue;
            };
            let Verdict::Touching(due) = Depths.solve(a, b, &mut Default::default()) else {
                panic!("{k}: {found:?}")
            };
            let off = (due.depth - found.depth).abs();
            assert!(off <= due.error_bound + found.error_bound, "{k}: {found:?} {due:?}");
            assert!(found.error_bound <= 1e-11 * couple.size(), "{k}: {found:?}");
            let between = found.point_a - found.point_b - found.normal * found.depth;
            assert!(between.length() <= 1e-12 * couple.size(), "{k}: {found:?}");
            let points = [
                found.point_a - found.normal * (radii[0] * size),
                found.point_b + found.normal * (radii[1] * size),
            ];
            for side in 0..2 {
                // What is swept round a triangle is on the other's side of it.
                let (turn, origin) = (poses[side].rotation(), poses[side].translation());
                let own = turn.transpose() * (points[side] - origin);
                let beside = own.distance(nearest_of_triangle(corners[side], own));
                assert!(beside <= found.error_bound + 1e-12 * couple.size(), "{k}: {found:?}");
            }
            let is_face = [0, 1].iter().any(|&side| {
                let [p, q, r] = corners[side].map(|corner| *poses[side].rotation() * corner);
                (q - p).cross(r - p).normalize().dot(found.normal).abs() > 1.0 - 1e-9
            });
            if is_face { faces += 1 } else { edges += 1 }
        }
        assert!(faces > 500 && edges > 2000, "{faces} {edges} {left}");
    }

    #[test]
    fn triangles_in_one_plane_needles_and_parallel_edges_are_left_to_the_search() {
        let flat = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let needle = [DVec3::ZERO, DVec3::X, DVec3::X * 2.0];
        let tilted =
            [DVec3::new(0.2, 0.2, -0.5), DVec3::new(0.3, 0.2, 0.5), DVec3::new(0.2, 0.4, 0.5)];
        let along =
            [DVec3::new(0.1, 0.2, -0.5), DVec3::new(0.6, 0.2, -0.5), DVec3::new(0.2, 0.2, 0.5)];
        let of = |corners: [[DVec3; 3]; 2]| {
            let parts = corners.map(|corners| Part::Triangle { corners, reach: 2.0, radius: 0.0 });
            Couple::of(parts, [&Pose::IDENTITY; 2]).unwrap().of_two_triangles()
        };
        assert!(of([flat, tilted]).is_some());
        assert!(of([flat, flat]).is_none());
        assert!(of([needle, tilted]).is_none());
        assert!(of([flat, along]).is_none());
    }
}
