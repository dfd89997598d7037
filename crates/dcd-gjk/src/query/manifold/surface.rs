//! A mesh as a surface with a front, and without the edges inside of it.

use crate::PosedShape;
use crate::closed::nearest_of_triangle;
use crate::epa::Depth;
use crate::mesh::{PartIndex, PartPair};
use dcd_geom::glam::DVec3;
use dcd_geom::{Mesh, Pose, Shape, SupportMap};

/// How the triangles of a mesh are taken where it touches a convex shape or a compound; two meshes touch as they are. A half-space
/// touches along its own normal, whatever the edges: from behind a triangle not at all with [`MeshSides::Front`], and as it
/// does without options with [`MeshSides::Outward`], for no finite way pushes it out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ManifoldOptions {
    /// Which side of a triangle touches.
    pub mesh_sides: MeshSides,
    /// Which edges and vertices touch.
    pub mesh_edges: MeshEdges,
}

/// Which side of a mesh's triangles touches. A triangle's front is where its corners are seen counter-clockwise; one
/// without area has two.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MeshSides {
    /// Both.
    #[default]
    Both,
    /// The front: what touches from behind has no manifold there, and an empty set if it touches nowhere else. The way on which
    /// the two come free the soonest says from where. Where that is more than sixty degrees from the triangle's normal, either
    /// way, what touches from behind has its middle behind, and does not touch a ridge or a peak from outside: with
    /// [`MeshEdges::All`] a contact from the front may so lean back by thirty degrees.
    Front,
    /// The front, and what lies behind a face is pushed out along the face's normal: for terrain that nothing is under. What
    /// touches an edge or a vertex from behind, and no face, is not.
    Outward,
}

/// Which edges and vertices of a mesh touch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MeshEdges {
    /// All, as if each triangle were alone: what slides over a floor of triangles may catch on the edges in it.
    #[default]
    All,
    /// Those that stand out: a contact's direction must be one that the surface has at the edge or vertex, to within
    /// 1e-3 rad, so that no neighbour reaches farther along it. Any other contact has its triangle's normal. Where the
    /// convex part is deepest beside the triangle its depth is then that part of the true one that is along the normal,
    /// and the error bound counts the rest.
    Active,
}

/// How far a neighbour may reach along a contact's direction, relative to its distance: an angle of 1e-3 rad, as that of
/// normals that count as one. Larger: catching edges. Smaller: normals of rounding.
const LEAN: f64 = 1e-3;

/// The cosine to a triangle's front, or to its back, below which a contact counts as sideways: it is from the side where the
/// part's middle is. Larger: contacts along a front that count as from behind. Smaller: parts behind a face that are pushed along
/// it.
const SIDEWAYS: f64 = 0.5;

/// How far beside a triangle, relative to its size, the foot of a point may be and still be on it.
const BESIDE: f64 = 1e-9;

/// The depth of a pair of parts with that surface; `None` where it does not touch.
pub(super) fn taken(
    options: ManifoldOptions,
    pair: &PartPair<'_>,
    sides: [PosedShape<'_>; 2],
    depth: Depth,
) -> Option<Depth> {
    if options == ManifoldOptions::default() {
        return Some(depth);
    }
    let Some(triangle) = Triangle::of(pair.parts, sides) else { return Some(depth) };
    let Some(posed) = pair.posed(sides[0], sides[1]) else { return Some(depth) };
    let other = posed[1 - triangle.side];
    let along = triangle.pose.rotation().transpose() * (depth.normal * triangle.sense());
    if !other.shape.is_bounded() {
        let is_behind = triangle.normal.dot(along) < -LEAN;
        return (options.mesh_sides != MeshSides::Front || !is_behind).then_some(depth);
    }
    let feature = triangle.farthest(along);
    let is_behind = triangle.is_touched_from_behind(other, (&feature, along));
    if is_behind && options.mesh_sides != MeshSides::Both {
        let is_pushed = options.mesh_sides == MeshSides::Outward && feature.len() == 3;
        return is_pushed.then(|| triangle.pushed_out(other, depth));
    }
    if options.mesh_edges == MeshEdges::Active && !triangle.stands_out(&feature, along) {
        let normal = if is_behind { -triangle.normal } else { triangle.normal };
        return Some(triangle.flattened(other, normal, depth));
    }
    Some(depth)
}

/// Whether a pair may add points to a manifold of that normal: not from behind a triangle that has a front only.
pub(super) fn is_seen(
    options: ManifoldOptions,
    pair: &PartPair<'_>,
    sides: [PosedShape<'_>; 2],
    normal: DVec3,
) -> bool {
    options.mesh_sides == MeshSides::Both
        || Triangle::of(pair.parts, sides).is_none_or(|triangle| {
            let front = *triangle.pose.rotation() * triangle.normal;
            front.dot(normal * triangle.sense()) >= -LEAN
        })
}

/// A triangle of the one mesh of a pair.
struct Triangle<'a> {
    mesh: &'a Mesh,
    pose: &'a Pose,
    /// Whether the mesh is a or b: its number in the pair.
    side: usize,
    corners: [u32; 3],
    /// Of its front, in the mesh's frame.
    normal: DVec3,
}

impl<'a> Triangle<'a> {
    /// `None` of other pairs, and of triangles without area.
    fn of(parts: [Option<PartIndex>; 2], sides: [PosedShape<'a>; 2]) -> Option<Self> {
        let (side, mesh) = match sides.map(|side| side.shape) {
            [Shape::Mesh(_), Shape::Mesh(_)] => return None,
            [Shape::Mesh(mesh), _] => (0, mesh),
            [_, Shape::Mesh(mesh)] => (1, mesh),
            _ => return None,
        };
        let Some(PartIndex::Triangle(k)) = parts[side] else { return None };
        let corners = mesh.adjacency().corners(k as usize)?;
        let [p, q, r] = corners.map(|corner| mesh.points()[corner as usize]);
        let normal = (q - p).cross(r - p).try_normalize()?;
        Some(Self { mesh, pose: sides[side].pose, side, corners, normal })
    }

    fn at(&self, corner: u32) -> DVec3 {
        self.mesh.points()[corner as usize]
    }

    /// Whether the other part touches it from behind, that feature of its own along that direction.
    fn is_touched_from_behind(
        &self,
        other: PosedShape<'_>,
        (feature, along): (&[u32], DVec3),
    ) -> bool {
        let cosine = self.normal.dot(along);
        if cosine.abs() >= SIDEWAYS {
            return cosine < 0.0;
        }
        // Of a sharp edge the middle of what touches it may be behind both of its planes.
        self.has_behind(other) && !self.is_outside(feature, along)
    }

    /// Whether a direction is one that a ridge, or a peak, of the surface has there: all round it is behind the triangle's plane.
    fn is_outside(&self, feature: &[u32], along: DVec3) -> bool {
        let is_own = |other: u32| self.corners.contains(&other);
        let is_behind = |corner: u32, other: u32| {
            let between = self.at(other) - self.at(corner);
            self.normal.dot(between) < -LEAN * between.length()
        };
        let is_alone = self.all_round(feature, |_, other| is_own(other));
        !is_alone
            && self.all_round(feature, |corner, other| is_own(other) || is_behind(corner, other))
            && self.stands_out(feature, along)
    }

    /// Whether the middle of the other part is behind its plane.
    fn has_behind(&self, other: PosedShape<'_>) -> bool {
        let middle = *other.pose.rotation() * other.shape.inner().centre;
        let from_mesh = middle + (other.pose.translation() - self.pose.translation());
        let local = self.pose.rotation().transpose() * from_mesh;
        self.normal.dot(local - self.at(self.corners[0])) < 0.0
    }

    /// 1 where the pair's normal points away from the mesh, else −1.
    fn sense(&self) -> f64 {
        if self.side == 0 { 1.0 } else { -1.0 }
    }

    /// Whether `other` reaches no farther along a direction than `corner`, or hardly.
    fn is_level(&self, corner: u32, other: u32, along: DVec3) -> bool {
        let between = self.at(other) - self.at(corner);
        along.dot(between) <= LEAN * between.length()
    }

    /// The corners that are the farthest along a direction, or hardly less far.
    fn farthest(&self, along: DVec3) -> Vec<u32> {
        let is_farthest =
            |corner: &u32| self.corners.iter().all(|&other| self.is_level(*corner, other, along));
        self.corners.into_iter().filter(is_farthest).collect()
    }

    /// Whether none of the triangles that share a vertex or an edge reaches farther along a direction than that.
    fn stands_out(&self, feature: &[u32], along: DVec3) -> bool {
        self.all_round(feature, |corner, other| self.is_level(corner, other, along))
    }

    /// Whether that is true of a corner of a vertex or an edge, and each of the others of the triangles round it; true of a face.
    fn all_round(&self, feature: &[u32], is: impl Fn(u32, u32) -> bool) -> bool {
        match *feature {
            [corner] => self.mesh.adjacency().ring(corner).all(|other| is(corner, other)),
            [p, q] => self.mesh.adjacency().opposite([p, q]).all(|other| is(p, other)),
            _ => true,
        }
    }

    /// The depth along a normal of the triangle: of the other part's deepest point where that is under the triangle,
    /// else what the depth has along it.
    fn flattened(&self, other: PosedShape<'_>, normal: DVec3, depth: Depth) -> Depth {
        let (whole, beside) = self.along_face(other, normal, depth);
        let [p, q, r] = self.corners.map(|corner| self.at(corner));
        if beside <= BESIDE * p.distance(q).max(p.distance(r)) {
            return whole;
        }
        let cosine = whole.normal.dot(depth.normal).clamp(0.0, 1.0);
        let sine = (1.0 - cosine * cosine).sqrt();
        let Depth { mut point_a, mut point_b, .. } = depth;
        let along = depth.depth * cosine;
        if self.side == 0 {
            point_a = point_b + whole.normal * along;
        } else {
            point_b = point_a - whole.normal * along;
        }
        // The witness that stays is off its surface by as much as the two miss of the depth.
        let error_bound = depth.error_bound + depth.depth * sine + depth.missed();
        Depth { depth: along, normal: whole.normal, point_a, point_b, error_bound }
    }

    /// The depth along the normal of the front, as if the triangle were a half-space.
    fn pushed_out(&self, other: PosedShape<'_>, depth: Depth) -> Depth {
        let (whole, beside) = self.along_face(other, self.normal, depth);
        Depth { error_bound: whole.error_bound + beside, ..whole }
    }

    /// The same, and how far beside the triangle the foot of the other part's deepest point is.
    fn along_face(&self, other: PosedShape<'_>, normal: DVec3, depth: Depth) -> (Depth, f64) {
        let (turn, origin) = (self.pose.rotation(), self.pose.translation());
        let world = (*turn * normal).normalize_or(depth.normal * self.sense());
        let local = other.pose.rotation().transpose() * -world;
        let core = *other.pose.rotation() * other.shape.support(local).point;
        let lowest = core + (other.pose.translation() - origin) - world * other.shape.radius();
        let corners = self.corners.map(|corner| *turn * self.at(corner));
        let plane = world.dot(corners[0]) + self.mesh.swept_radius();
        let under = plane - world.dot(lowest);
        let foot = lowest + world * (under - self.mesh.swept_radius());
        let beside = foot.distance(nearest_of_triangle(corners, foot));
        let (at_mesh, at_other) = (origin + (lowest + world * under), origin + lowest);
        let (point_a, point_b) =
            if self.side == 0 { (at_mesh, at_other) } else { (at_other, at_mesh) };
        let normal = world * self.sense();
        let error_bound = depth.error_bound + other.shape.support_error();
        (Depth { depth: under.max(0.0), normal, point_a, point_b, error_bound }, beside)
    }
}
