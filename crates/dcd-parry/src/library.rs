//! The interface to Parry, written once for both of its builds.

use crate::forms::in_parrys_frame;
use dcd_exec::Exec;
use dcd_geom::{
    Compound, CurvedKind, Kind, Mesh, Part, Polytope, Pose, Real, Shape, SupportMap, Vector,
};
use std::panic::catch_unwind;

/// Which of Parry's queries decides whether two of its shapes touch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Query {
    /// `query::intersection_test`, its yes or no. It answers "apart" where its GJK runs out of
    /// iterations, and does not say so.
    #[default]
    IntersectionTest,
    /// The same query, with the function that it ends up in called directly where both shapes are
    /// polyhedra: no dynamic dispatch at each support.
    DirectIntersectionTest,
    /// `query::distance` is 0, as the paper judged. It answers 0 where its GJK runs out of
    /// iterations, and does not say so.
    Distance,
}

/// More points than this are not handed to Parry's hull: it recurses over the facets that a point
/// sees, and a stack that runs out cannot be caught.
const MOST_POINTS: usize = 4096;

/// Parry built for this number type: `parry3d` for f32, `parry3d-f64` for f64. Sealed, as [`Real`].
pub trait Library: Real {
    /// A pose.
    type Pose: Copy + Default + Send + Sync + 'static;
    /// A shape in its own frame, made once.
    type Form: Clone + Send + Sync + 'static;
    /// An AABB.
    type Box: Copy + Send + Sync + 'static;
    /// A bounding volume hierarchy with its scratch memory; the default holds nothing.
    type Tree: Default + Send + Sync;

    /// The largest sum of two shapes' reaches and the distance between them, metres, at which no
    /// formula of Parry's GJK overflows. Its triangle projections are sums of products of four
    /// lengths, at most 64·m⁴; beyond, infinities cancel to NaN, which it takes for a hit.
    const RANGE: f64;

    /// The nearest pose: the rotation as a quaternion.
    fn pose(pose: &Pose) -> Self::Pose;
    /// The translation of a pose, metres.
    fn translation(pose: &Self::Pose) -> dcd_geom::glam::DVec3;
    /// Whether Parry's GJK finds that the shapes touch. `None` where it ran out of iterations.
    fn gjk(a: (&Shape, &Self::Pose), b: (&Shape, &Self::Pose)) -> Option<bool>;
    /// Parry's own shape: round its y axis where ours is round z, a half-space through its origin.
    /// `None` where it has none such or refuses the points.
    fn form(shape: &Shape) -> Option<Self::Form>;
    /// What the query says. `None` where it does not know the pair.
    fn touching(
        query: Query,
        a: (&Self::Form, &Self::Pose),
        b: (&Self::Form, &Self::Pose),
    ) -> Option<bool>;
    /// The AABB of a shape at a pose, rounded to nearest.
    fn boxed(form: &Self::Form, pose: &Self::Pose) -> Self::Box;
    /// An AABB of nothing.
    const NO_BOX: Self::Box;
    /// The binned tree over AABBs, its leaves numbered in their order.
    fn build(boxes: impl ExactSizeIterator<Item = Self::Box>, tree: &mut Self::Tree);
    /// Builds in the memory of the tree before, if it had as many leaves: Parry's fastest way.
    /// It starts from the order of that tree's leaves, so that the new one depends on it.
    fn rebuild(boxes: impl ExactSizeIterator<Item = Self::Box>, tree: &mut Self::Tree);
    /// The tree before with the leaves' new AABBs: its nodes are fitted anew and a part of it is
    /// improved, as Parry's users do from frame to frame. Built if it had another number of leaves.
    fn refit(boxes: impl ExactSizeIterator<Item = Self::Box>, tree: &mut Self::Tree);
    /// Calls `pair` for every two leaves whose AABBs overlap, once each, in the tree's order.
    fn leaf_pairs(tree: &mut Self::Tree, pair: impl FnMut(u32, u32));
    /// The same pairs in the same order, found on rayon's current pool.
    fn leaf_pairs_parallel(tree: &Self::Tree) -> Vec<(u32, u32)>;

    /// Calls `leaf` for the leaves whose AABBs overlap that one, until it returns `false`.
    fn leaves_near(tree: &Self::Tree, aabb: &Self::Box, leaf: impl FnMut(u32) -> bool);

    /// Replaces `found` by the same pairs, found where `exec` says.
    fn collect_leaf_pairs(tree: &mut Self::Tree, exec: Exec, found: &mut Vec<(u32, u32)>) {
        if is_parallel(exec) {
            *found = Self::leaf_pairs_parallel(tree);
        } else {
            found.clear();
            Self::leaf_pairs(tree, |a, b| found.push((a, b)));
        }
    }
}

/// Whether Parry's parallel functions are the faster ones.
pub(crate) fn is_parallel(exec: Exec) -> bool {
    exec.is_pooled() && dcd_exec::threads() > 1
}

/// A support point of the core, in R; a custom shape is evaluated in f64.
fn core_support<R: Real>(shape: &Shape, direction: R::Vec3) -> R::Vec3 {
    match shape.as_polytope() {
        Some(polytope) => SupportMap::<R>::support(polytope, direction).point,
        None => R::Vec3::from_dvec3(shape.support(direction.to_dvec3()).point),
    }
}

/// The points to take Parry's hull of.
fn hull_points<R: Real>(polytope: &Polytope) -> Option<Vec<R::Vec3>> {
    let vertices = polytope.vertices();
    let points = || vertices.iter().map(|&v| R::Vec3::from_dvec3(v)).collect();
    (vertices.len() <= MOST_POINTS).then(points)
}

macro_rules! behind_library {
    ($real:ty, $parry:ident, $range:expr, $rotation:expr) => {
        const _: () = {
            use $parry::bounding_volume::Aabb;
            use $parry::math::{Pose as ParryPose, Vector as ParryVector};
            use $parry::partitioning::{Bvh, BvhBuildStrategy, BvhWorkspace};
            use $parry::query::details::{
                intersection_test_support_map_support_map,
                intersection_test_support_map_support_map_with_params,
            };
            use $parry::query::gjk::{CsoPoint, VoronoiSimplex};
            use $parry::query::{distance, intersection_test};
            use $parry::shape::{SharedShape, SupportMap as ParrySupportMap};

            /// Our shape to Parry's GJK: the radius is added as Parry's own rounded shapes do.
            struct Rounded<'a>(&'a Shape, $real);

            impl ParrySupportMap for Rounded<'_> {
                fn local_support_point(&self, direction: ParryVector) -> ParryVector {
                    let core = core_support::<$real>(self.0, direction);
                    if self.1 == 0.0 { core } else { core + direction.normalize_or_zero() * self.1 }
                }
            }

            /// Parts that Parry has no shape for leave it without the compound.
            fn compound_form(compound: &Compound) -> Option<SharedShape> {
                let part = |part: &Part| {
                    let pose = in_parrys_frame(&part.shape, &part.pose);
                    Some((<$real>::pose(&pose), <$real>::form(&part.shape)?))
                };
                let parts = compound.parts().iter().map(part).collect::<Option<Vec<_>>>()?;
                Some(SharedShape::compound(parts))
            }

            /// Parry has no rounded mesh.
            fn mesh_form(mesh: &Mesh) -> Option<SharedShape> {
                let vertices = mesh.vertices().iter().map(|&v| Vector::from_dvec3(v)).collect();
                let triangles = mesh.triangles().to_vec();
                let sharp = mesh.swept_radius() == 0.0;
                sharp.then(|| SharedShape::trimesh(vertices, triangles).ok()).flatten()
            }

            impl Library for $real {
                type Pose = ParryPose;
                type Form = SharedShape;
                type Box = Aabb;
                type Tree = (Bvh, BvhWorkspace);

                const RANGE: f64 = $range;
                const NO_BOX: Aabb = Aabb { mins: ParryVector::MAX, maxs: ParryVector::MIN };

                fn pose(pose: &Pose) -> ParryPose {
                    let rotation = dcd_geom::glam::DQuat::from_mat3(pose.rotation());
                    let translation = Vector::from_dvec3(pose.translation());
                    ParryPose::from_parts(translation, $rotation(rotation))
                }

                fn translation(pose: &ParryPose) -> dcd_geom::glam::DVec3 {
                    Vector::to_dvec3(pose.translation)
                }

                fn gjk(a: (&Shape, &ParryPose), b: (&Shape, &ParryPose)) -> Option<bool> {
                    let b_in_a = a.1.inv_mul(b.1);
                    let [a, b] = [a.0, b.0].map(|s| Rounded(s, s.radius() as $real));
                    let (touching, axis) = intersection_test_support_map_support_map_with_params(
                        &b_in_a,
                        &a,
                        &b,
                        &mut VoronoiSimplex::new(),
                        None,
                    );
                    // Parry says "apart along x" when it gives up. If x does separate, querying
                    // that axis again gives the same positive separation, bit by bit.
                    if !touching && axis == ParryVector::X {
                        let nearest = CsoPoint::from_shapes(&b_in_a, &a, &b, axis).point;
                        return (nearest.x < 0.0).then_some(false);
                    }
                    Some(touching)
                }

                fn form(shape: &Shape) -> Option<SharedShape> {
                    let radius = shape.radius() as $real;
                    let polytope = match shape {
                        Shape::Polytope(polytope) => polytope,
                        Shape::Curved(curved) => {
                            let (h, r) = (curved.half_height() as $real, curved.radius() as $real);
                            return Some(match (curved.kind(), radius == 0.0) {
                                (CurvedKind::Cylinder, true) => SharedShape::cylinder(h, r),
                                (CurvedKind::Cylinder, false) => {
                                    SharedShape::round_cylinder(h, r, radius)
                                }
                                (CurvedKind::Cone, true) => SharedShape::cone(h, r),
                                (CurvedKind::Cone, false) => SharedShape::round_cone(h, r, radius),
                                _ => return None,
                            });
                        }
                        // Its frame's origin is on the plane, the radius included.
                        Shape::HalfSpace(half_space) => {
                            let normal = half_space.unit_normal();
                            return Some(SharedShape::halfspace(Vector::from_dvec3(normal)));
                        }
                        Shape::Compound(compound) => return compound_form(compound),
                        Shape::Mesh(mesh) => return mesh_form(mesh),
                        _ => return None,
                    };
                    let corner = |k: usize| -> ParryVector {
                        let vertex = polytope.vertices().get(k).copied();
                        Vector::from_dvec3(vertex.unwrap_or_default())
                    };
                    match polytope.kind() {
                        Kind::Segment if radius == 0.0 => {
                            Some(SharedShape::segment(corner(0), corner(1)))
                        }
                        Kind::Segment => Some(SharedShape::capsule(corner(0), corner(1), radius)),
                        Kind::Triangle if radius == 0.0 => {
                            Some(SharedShape::triangle(corner(0), corner(1), corner(2)))
                        }
                        Kind::Triangle => Some(SharedShape::round_triangle(
                            corner(0),
                            corner(1),
                            corner(2),
                            radius,
                        )),
                        Kind::Point => Some(SharedShape::ball(radius)),
                        Kind::Cuboid { half_extents } => {
                            let [x, y, z] = half_extents.to_array().map(|h| h as $real);
                            Some(if radius == 0.0 {
                                SharedShape::cuboid(x, y, z)
                            } else {
                                SharedShape::round_cuboid(x, y, z, radius)
                            })
                        }
                        _ => {
                            let points = hull_points::<$real>(polytope)?;
                            // Parry's hull asserts its own invariants, which degenerate points
                            // break; catching is the last resort.
                            catch_unwind(|| match radius {
                                0.0 => SharedShape::convex_hull(&points),
                                _ => SharedShape::round_convex_hull(&points, radius),
                            })
                            .ok()?
                        }
                    }
                }

                #[inline]
                fn touching(
                    query: Query,
                    (a, pose_a): (&SharedShape, &ParryPose),
                    (b, pose_b): (&SharedShape, &ParryPose),
                ) -> Option<bool> {
                    if query == Query::Distance {
                        let between = distance(pose_a, &**a, pose_b, &**b).ok()?;
                        return Some(between.distance == 0.0);
                    }
                    if query == Query::DirectIntersectionTest
                        && let Some(a) = a.as_convex_polyhedron()
                        && let Some(b) = b.as_convex_polyhedron()
                    {
                        let b_in_a = pose_a.inv_mul(pose_b);
                        return Some(intersection_test_support_map_support_map(&b_in_a, a, b));
                    }
                    let test = intersection_test(pose_a, &**a, pose_b, &**b).ok()?;
                    Some(test.intersecting)
                }

                #[inline]
                fn boxed(form: &SharedShape, pose: &ParryPose) -> Aabb {
                    form.compute_aabb(pose)
                }

                fn build(boxes: impl ExactSizeIterator<Item = Aabb>, (tree, _): &mut Self::Tree) {
                    *tree = Bvh::from_iter(BvhBuildStrategy::Binned, boxes.enumerate());
                }

                fn rebuild(boxes: impl ExactSizeIterator<Item = Aabb>, tree: &mut Self::Tree) {
                    // Parry leaves a tree of one or two leaves as it is, AABBs apart.
                    if boxes.len() < 3 || tree.0.leaf_count() as usize != boxes.len() {
                        return Self::build(boxes, tree);
                    }
                    for (leaf, aabb) in (0..).zip(boxes) {
                        tree.0.update_partially_if_present(aabb, leaf, 0.0);
                    }
                    tree.0.rebuild(&mut tree.1, BvhBuildStrategy::Binned);
                }

                fn refit(boxes: impl ExactSizeIterator<Item = Aabb>, tree: &mut Self::Tree) {
                    if boxes.len() < 3 || tree.0.leaf_count() as usize != boxes.len() {
                        return Self::build(boxes, tree);
                    }
                    for (leaf, aabb) in (0..).zip(boxes) {
                        tree.0.update_partially_if_present(aabb, leaf, 0.0);
                    }
                    tree.0.refit(&mut tree.1);
                    tree.0.optimize_incremental(&mut tree.1);
                }

                fn leaf_pairs((tree, memory): &mut Self::Tree, mut pair: impl FnMut(u32, u32)) {
                    tree.traverse_bvtt_single_tree::<false>(memory, &mut pair);
                }

                fn leaves_near(
                    (tree, _): &Self::Tree,
                    aabb: &Aabb,
                    mut leaf: impl FnMut(u32) -> bool,
                ) {
                    for near in tree.intersect_aabb(aabb) {
                        if !leaf(near) {
                            return;
                        }
                    }
                }

                fn leaf_pairs_parallel((tree, _): &Self::Tree) -> Vec<(u32, u32)> {
                    tree.traverse_bvtt_single_tree_parallel::<false>()
                }
            }
        };
    };
}

behind_library!(f32, parry3d, 1_073_741_824.0, |q: dcd_geom::glam::DQuat| q.as_quat());
behind_library!(f64, parry3d_f64, 1e75, |q| q);
