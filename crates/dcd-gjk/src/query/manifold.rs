//! Where touching pairs touch: up to four points of the patch that they share.
//!
//! The normal is that of the depth. Each shape shows a feature along it: a face that looks almost
//! that way, else an edge almost square to it, else a vertex. Seen along the normal, the two
//! features are polygons of a plane; what they have in common is clipped, every corner of it being
//! a point of both features, one above the other, and so with a depth of its own. Of the corners
//! that are at least 0 deep, the deepest is kept, and three that span the most. Objects of parts have such a patch for
//! each normal along which some of their parts meet.

mod alone;
mod bounds;
mod clip;
mod contacts;
mod core_contact;
mod corners;
mod cuboid_faces;
mod cuboid_pair;
mod cuboid_patch;
mod cuboids;
mod facing;
mod feature;
mod feature_code;
mod few;
mod few_on_plane;
mod hull_pair;
mod hull_patches;
mod leaning_edge;
mod mesh_on_plane;
mod on_mesh;
mod on_plane;
mod one_point;
mod outline;
mod parts;
mod patch_writer;
mod polygon;
mod reduce;
mod set;
mod stand_in;
mod surface;
mod triangle_clip;
mod upright;

use super::depths::Searched;
use super::{Accuracy, FoundDepth, FoundPair, MeasureAt, MeasureDepth, PartContact};
use crate::epa::{self, Depth};
use crate::mesh::{self, KnownParts, PartIndex};
use crate::simd::{CoreContact, CuboidPatch};
use crate::{Depths, Method, PairSolver, PosedShape, Verdict, certified, order};
use alone::Known;
use bounds::{bound_of, bound_of_witnesses, turned_by, uneven_by, unevenness};
pub use contacts::ManifoldContacts;
use corners::Corners;
pub(crate) use cuboid_faces::case_of;
pub(super) use cuboid_patch::depth_of_patch;
use dcd_geom::Pair;
use dcd_geom::glam::DVec3;
use dcd_simd::{ArrayVec, Path, dispatch_on};
pub(crate) use facing::{FACING, LEVEL};
use feature::View;
use hull_patches::{PAIRS, Packet, WriteSeveral};
use one_point::in_one_point;
use parts::Measure;
use patch_writer::{InOrder, PatchWriter};
pub use set::ManifoldSet;
pub use surface::{ManifoldOptions, MeshEdges, MeshSides};

/// One patch of the surfaces along which two objects touch: a normal and up to four points. World frame, metres.
// In this order: what one point needs lies on the first cache lines.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Manifold {
    /// From a to b, of unit length: the direction of the deepest parts' [`Depth`].
    pub normal: DVec3,
    /// How far a point may be off its object's surface, and the first one's depth off that of the deepest parts:
    /// metres. The depth's own bound, and how flat a face is, about 1e-8 of the objects' size, and twice what the hulls' faces are bent by
    /// ([`dcd_geom::Facets::unevenness`]). More where a rounded face
    /// or edge leans, at most by what its points are less deep than the first; where parts meet along normals that agree
    /// within 1e-3 rad and no better, that angle's part of the depth; and by what poses are off rotations.
    pub error_bound: f64,
    /// Which parts of a and of b are the patch's deepest, where they are compounds or meshes.
    pub parts: [Option<PartIndex>; 2],
    points: ArrayVec<ManifoldPoint, 4>,
}

/// A point where two objects touch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ManifoldPoint {
    /// Of a's surface.
    pub point_a: DVec3,
    /// Of b's surface: `point_a − point_b` is `normal·depth`, within the manifold's bound.
    pub point_b: DVec3,
    /// How deep the objects overlap here along the normal: at least 0, at most the depth of the patch's deepest
    /// parts, and that at the first point.
    pub depth: f64,
    /// What of a it belongs to, and what of b: the same as long as the same features meet, so that
    /// a point is known again in the next frame.
    pub features: [Feature; 2],
    /// Of which parts of a and of b they are features, where these are compounds or meshes.
    pub parts: [Option<PartIndex>; 2],
}

/// A part of a polytope, by index into its vertices or its [contact facets](dcd_geom::Polytope::contact_facets); of a cylinder or
/// cone the vertices are eight corners that stand for a rim, and the ends of a line of its side.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Feature {
    /// The whole, for shapes that have no vertices.
    #[default]
    Surface,
    /// A vertex.
    Vertex(u32),
    /// Between two vertices, the smaller index first.
    Edge(u32, u32),
    /// A face.
    Face(u32),
}

impl Default for Manifold {
    /// Without a point.
    #[inline(always)]
    fn default() -> Self {
        Self { normal: DVec3::ZERO, points: ArrayVec::new(), error_bound: 0.0, parts: [None; 2] }
    }
}

impl Manifold {
    /// One to four, the deepest first.
    pub fn points(&self) -> &[ManifoldPoint] {
        &self.points
    }

    /// Exchanges a and b.
    fn mirror(&mut self) {
        for point in &mut *self.points {
            (point.point_a, point.point_b) = (point.point_b, point.point_a);
            point.features.reverse();
            point.parts.reverse();
        }
        self.parts.reverse();
        self.normal = -self.normal;
    }
}

/// The contact manifolds of touching pairs: see [`ManifoldSet`].
///
/// Up to four points between polytopes, rounded or not, half-spaces, and cylinders and cones that rest on a
/// face or along a line; with a foreign shape the one point of the [`Depth`]. Costs [`Depths`], two passes over
/// each polytope's faces, and for each polytope once a microsecond a vertex to find them.
///
/// Of compounds and meshes the touching pairs of parts are grouped, from the deepest on: a manifold is about the
/// parts whose own normals agree with the deepest's within 1e-3 rad, and those that its normal and depth separate too.
/// So every two parts that touch meet along the normal of a manifold, or come apart when the objects are moved by its
/// depth and bound along its normal; curved and rounded ones a little later, as their [`Depth`] says. The first manifold
/// is that of the pair's [`Depths`]; at [`Accuracy::F32`], of a mesh and a polytope, or a compound of few, and of two cuboids
/// in a scene, to within the bounds of both.
///
/// ```
/// use dcd_gjk::query::{ManifoldOptions, MeshEdges, MeshSides};
/// use dcd_gjk::{Manifolds, ThenMeasure};
/// let options = ManifoldOptions { mesh_sides: MeshSides::Outward, mesh_edges: MeshEdges::Active };
/// let on_terrain = ThenMeasure::new(Manifolds { options })?;
/// # Ok::<(), dcd_geom::ShapeError>(())
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct Manifolds {
    /// How the surfaces of meshes count: by default both sides and every edge.
    pub options: ManifoldOptions,
}

/// What a thread reuses from pair to pair.
#[derive(Debug, Default)]
pub struct Scratch {
    depth: epa::Scratch,
    corners: Corners,
    /// Made where it is first of use: it is large.
    packet: Option<Box<Packet>>,
    parts: mesh::Scratch,
    on_mesh: on_mesh::Scratch,
    on_plane: mesh_on_plane::Scratch,
    of_few: Vec<few::Found>,
    /// Which parts touch, where that is known.
    known: Vec<[u32; 2]>,
}

impl PairSolver for Manifolds {
    type Answer = ManifoldSet;
    type Scratch = Scratch;

    fn method(&self) -> Method {
        Depths.method()
    }

    fn solve(
        &self,
        a: PosedShape<'_>,
        b: PosedShape<'_>,
        scratch: &mut Scratch,
    ) -> Verdict<ManifoldSet> {
        self.resolve(a, b, scratch).0
    }

    fn measure(
        &self,
        a: PosedShape<'_>,
        b: PosedShape<'_>,
        scratch: &mut Scratch,
    ) -> Verdict<ManifoldSet> {
        self.measure_at(Accuracy::Certified, a, b, scratch)
    }

    fn may_leave_out(&self) -> bool {
        self.options != ManifoldOptions::default()
    }

    fn resolve(
        &self,
        a: PosedShape<'_>,
        b: PosedShape<'_>,
        scratch: &mut Scratch,
    ) -> (Verdict<ManifoldSet>, Method) {
        if mesh::have_parts(a.shape, b.shape) {
            let (verdict, method) = certified::overlap_of(a, b);
            let verdict = match verdict {
                Verdict::Touching(()) => self.measure(a, b, scratch),
                Verdict::Apart => Verdict::Apart,
                Verdict::Undecided(reason) => Verdict::Undecided(reason),
            };
            return (verdict, method);
        }
        let (verdict, method) = Depths.resolve(a, b, &mut scratch.depth);
        (manifold_of(verdict, a, b, &mut scratch.corners), method)
    }
}

impl MeasureAt for Manifolds {
    fn measure_at(
        &self,
        accuracy: Accuracy,
        a: PosedShape<'_>,
        b: PosedShape<'_>,
        scratch: &mut Scratch,
    ) -> Verdict<ManifoldSet> {
        if !mesh::have_parts(a.shape, b.shape) {
            let how = (accuracy, Searched::Not);
            return alone::of_convex(how, [a, b], scratch, |depth, known, corners| {
                alone::of_depth(depth, [a, b], known, corners)
            });
        }
        let how = Measure { accuracy, options: self.options };
        match accuracy {
            Accuracy::F32 | Accuracy::F64 => of_few_or_more(how, [a, b], scratch),
            Accuracy::Certified => parts::measure(how, [a, b], scratch),
        }
    }
}

impl MeasureDepth for Manifolds {
    fn measure_depth(
        &self,
        depth: Depth,
        a: PosedShape<'_>,
        b: PosedShape<'_>,
        scratch: &mut Scratch,
    ) -> Verdict<ManifoldSet> {
        manifold_of(Verdict::Touching(depth), a, b, &mut scratch.corners)
    }

    #[inline(always)]
    fn measure_spheres(&self, depth: &Depth, off_surface: f64, answer: &mut ManifoldSet) {
        answer.write_one(|found| {
            write_one_point(depth, OF_SPHERES, found);
            found.error_bound += off_surface;
            true
        });
    }

    #[inline(always)]
    fn push_spheres(
        &self,
        pair: Pair,
        (depth, off_surface): (&Depth, f64),
        contacts: &mut ManifoldContacts,
    ) {
        let error_bound = depth.error_bound + off_surface;
        contacts.push_one_point(pair, &Depth { error_bound, ..*depth }, OF_SPHERES);
    }

    fn measure_polytopes(
        &self,
        path: Path,
        pairs: &[FoundPair<'_>],
        scratch: &mut Scratch,
        contacts: &mut ManifoldContacts,
    ) -> u32 {
        let Scratch { corners, packet, .. } = scratch;
        let packet = &mut **packet.get_or_insert_default();
        dispatch_on(path, WriteSeveral { pairs, packet, corners, contacts })
    }

    #[inline(always)]
    fn measure_cuboids(
        &self,
        patch: CuboidPatch<'_>,
        sides: [PosedShape<'_>; 2],
        (contacts, number): (&mut ManifoldContacts, usize),
    ) -> bool {
        let is_written = cuboid_patch::write(patch, sides, contacts.writer());
        if is_written {
            contacts.keep_last(number);
        }
        is_written
    }

    #[inline(always)]
    fn measure_cores(
        &self,
        contact: &CoreContact<'_>,
        (contacts, number): (&mut ManifoldContacts, usize),
    ) -> bool {
        let is_written = core_contact::write(contact, contacts.writer()).is_some();
        if is_written {
            contacts.keep_last(number);
        }
        is_written
    }

    fn measure_alone(
        &self,
        accuracy: Accuracy,
        sides: [PosedShape<'_>; 2],
        scratch: &mut Scratch,
        place: (&mut ManifoldContacts, usize),
    ) -> Verdict<()> {
        alone::write(self, accuracy, sides, scratch, place)
    }

    fn measure_parts(
        &self,
        accuracy: Accuracy,
        known: KnownParts<'_>,
        sides: [PosedShape<'_>; 2],
        scratch: &mut Scratch,
        answer: &mut ManifoldSet,
    ) -> Verdict<()> {
        let how = Measure { accuracy, options: self.options };
        parts::write(how, Some(known), sides, scratch, answer)
    }

    fn measure_compounds(
        &self,
        accuracy: Accuracy,
        known: &mut [PartContact<'_>],
        sides: [PosedShape<'_>; 2],
        scratch: &mut Scratch,
        answer: &mut ManifoldSet,
    ) -> Verdict<()> {
        answer.begin_one();
        if few::write_known(accuracy, known, sides, scratch, answer) {
            return Verdict::Touching(());
        }
        let how = Measure { accuracy, options: self.options };
        parts::write(how, None, sides, scratch, answer)
    }

    const TOGETHER: usize = PAIRS;
    const READS_FACETS: bool = true;
    const READS_PATCHES: bool = true;
}

/// The manifold of that depth.
#[inline]
fn manifold_of(
    verdict: Verdict<Depth>,
    a: PosedShape<'_>,
    b: PosedShape<'_>,
    corners: &mut Corners,
) -> Verdict<ManifoldSet> {
    match verdict {
        Verdict::Apart => Verdict::Apart,
        Verdict::Undecided(reason) => Verdict::Undecided(reason),
        Verdict::Touching(depth) => alone::of_depth(&depth, [a, b], Known::Nothing, corners),
    }
}

/// The manifolds of shapes of parts, at an accuracy below the certified one.
fn of_few_or_more(
    how: Measure,
    sides: [PosedShape<'_>; 2],
    scratch: &mut Scratch,
) -> Verdict<ManifoldSet> {
    let mut answer = Verdict::Touching(ManifoldSet::empty_one());
    let is_written = match &mut answer {
        Verdict::Touching(set) => few::write(how.accuracy, sides, scratch, set),
        _ => false,
    };
    if !is_written {
        answer = parts::measure(how, sides, scratch);
    }
    answer
}

/// Writes the manifold of two convex shapes over an empty one.
fn write_of_two(
    depth: &Depth,
    [a, b]: [PosedShape<'_>; 2],
    corners: &mut Corners,
    found: &mut Manifold,
) {
    if let Some((features, error_bound)) = in_one_point(depth, [a, b]) {
        write_one_point(depth, features, found);
        found.error_bound = error_bound;
        return;
    }
    if !on_plane::write(depth, [a, b], found) {
        write_by_corners(&FoundDepth::from(*depth), [a, b], corners, found);
    }
}

/// The same by what the shapes show along the normal.
fn write_by_corners(
    known: &FoundDepth,
    [a, b]: [PosedShape<'_>; 2],
    corners: &mut Corners,
    found: &mut Manifold,
) {
    if write_of_polytopes(known, a, b, corners, found) {
        return;
    }
    let depth = &known.depth;
    if order::is_swapped(a, b) {
        write_in_order(&depth.mirrored(), [b, a], corners, found);
        found.mirror();
    } else {
        write_in_order(depth, [a, b], corners, found);
    }
}

/// What two spheres touch with.
const OF_SPHERES: [Feature; 2] = [Feature::Vertex(0); 2];

/// How far from the witnesses' depth the deepest corner may be to stand for it, relative to the
/// shapes' size: faces are flat to a billionth. Larger: a deepest point that is not the deepest.
const SAME: f64 = 1e-9;

/// The sine above which two edges surely cross.
const CROSSING: f64 = 1e-6;

/// Writes the manifold of two polytopes, found in their canonical order; false, and nothing written, where the general way is
/// needed.
fn write_of_polytopes(
    known: &FoundDepth,
    a: PosedShape<'_>,
    b: PosedShape<'_>,
    corners: &mut Corners,
    writer: &mut impl PatchWriter,
) -> bool {
    let is_swapped = order::is_swapped(a, b);
    let writer = &mut InOrder { writer, is_swapped };
    let mirrored;
    let (known, sides) = match is_swapped {
        true => {
            mirrored = known.mirrored();
            (&mirrored, [b, a])
        }
        false => (known, [a, b]),
    };
    cuboid_pair::write(&known.depth, sides, &mut corners.of_cuboids, writer)
        || hull_pair::write(known, sides, &mut corners.of_hulls, writer)
}

/// By the corners of what the shapes show.
fn write_in_order(
    depth: &Depth,
    sides: [PosedShape<'_>; 2],
    corners: &mut Corners,
    found: &mut Manifold,
) {
    let view = View::along(depth.normal);
    corners.clear();
    let features = corners.add(&view, depth, sides);
    corners.write(&view, depth, sides, features, found);
}

/// The witnesses of the depth alone, over an empty manifold.
fn write_one_point(depth: &Depth, features: [Feature; 2], found: &mut Manifold) {
    found.write_witnesses(depth, features, depth.error_bound);
}
