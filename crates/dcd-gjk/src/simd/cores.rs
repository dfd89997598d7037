//! What the lanes read of a shape, in one place for all shapes of a scene.

use super::inscribed::Inscribed;
use super::part_group::PartGroups;
use crate::query::case_of;
use dcd_geom::glam::{DVec3, Vec3};
use dcd_geom::{
    Compound, Corners, Curved, Kind, Mesh, ObbBounds, Part, Polytope, Pose, Revision, Scene, Shape,
    SupportMap,
};
use dcd_simd::{Block, WIDTH};

/// Whether a polytope is a sphere round the origin of its frame.
pub(super) fn is_sphere(polytope: &Polytope) -> bool {
    polytope.kind() == Kind::Point && polytope.reach() == 0.0
}

/// What depends on a shape alone, as the lanes want it: of a polytope, or of a curved shape with the
/// vertices of a hull inside it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Core {
    /// The inner sphere's centre in the shape's own frame, metres: the blocks count from here.
    pub(crate) centre: DVec3,
    /// The radius of a sphere round the centre inside the core, rounded down.
    pub(crate) inner: f64,
    /// The radius of a sphere round the centre that holds the core, rounded up.
    pub(crate) outer: f64,
    /// The largest distance of a vertex from the origin of the shape's own frame, rounded up; of a part that of all its
    /// compound's.
    pub(crate) reach: f64,
    /// The radius swept round the core.
    pub(crate) radius: f64,
    /// Its first block in [`Cores::blocks`].
    pub(crate) first: u32,
    /// How many blocks it has; 0 for a shape that the lanes do not know.
    pub(crate) blocks: u32,
    /// How much farther the core reaches than its vertices, at most, in any direction, metres: 0
    /// for polytopes.
    pub(crate) excess: f64,
    /// Whether [`Cores::obbs`] (of a part [`Cores::part_obbs`]) has its boxes.
    pub(crate) has_obb: bool,
    /// Whether the core is its inner and outer OBBs, both of them.
    pub(crate) is_box: bool,
    /// Whether the core is a part that was a cuboid before it was placed, and its OBBs are that to [`NEARLY`].
    pub(crate) is_nearly_box: bool,
    /// Whether it is a sphere round the origin of its frame.
    pub(crate) is_sphere: bool,
    /// Whether it is a point, or a segment with its centre in the middle.
    pub(crate) is_straight: bool,
    /// The first of its parts' cores in [`Cores::parts`].
    pub(crate) first_part: u32,
    /// The first of their groups in [`Cores::groups`].
    pub(crate) first_group: u32,
    /// How many of those parts it has: 0 but for compounds of at most [`MAX_PARTS`] parts.
    pub(crate) parts: u32,
    /// Of a part its number in the compound.
    pub(crate) part: u32,
}

impl Core {
    /// That of a polytope, without blocks or boxes.
    pub(super) fn of_polytope(polytope: &Polytope) -> Self {
        Self {
            inner: polytope.inner().radius,
            outer: polytope.outer_radius(),
            reach: polytope.reach(),
            radius: polytope.swept_radius(),
            centre: polytope.inner().centre,
            is_sphere: is_sphere(polytope),
            is_straight: matches!(polytope.kind(), Kind::Point | Kind::Segment),
            ..Self::default()
        }
    }
}

/// Of a compound with more parts than these the lanes know nothing. No unit.
///
/// All parts of one are compared with all of another, sixteen at a time, and each is prepared with
/// the object. Larger: large compounds cost memory and lists where a tree is quicker. Smaller: more
/// of them are searched one pair at a time. Never an answer.
pub(crate) const MAX_PARTS: usize = 256;

/// How far apart the outer and the inner OBB of a placed cuboid may be that is taken for a cuboid in f32, relative to its
/// shortest half edge. Its vertices are hundreds of times nearer to the cuboid's: that is less than a thousandth of a rounding in
/// f32. Larger: cuboids far from their compound's origin whose bounds do not count what they are off. Smaller: more of them are
/// searched as hulls.
const NEARLY: f64 = 1e-9;

/// How far a point and a centre, each R·v + t rounded, may have moved apart. Unit: of their distance
/// from the origin. Each loses 4u a component, √3 of that: 14u, and a margin.
const MOVED: f64 = 16.0 * f64::EPSILON;

/// A [`ObbBounds`] in f32.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct ObbBoundsF32 {
    /// The directions of the edges, each component off by one rounding.
    pub(crate) axes: [Vec3; 3],
    /// Half the edges of the outer box, rounded up.
    pub(crate) outer: Vec3,
    /// Half the edges of the inner box, rounded down.
    pub(crate) inner: Vec3,
    /// Of a cuboid how its half edges compare: see [`case_of`]. [`UNKNOWN_CASE`] where that does not tell, and for others.
    pub(crate) case: f32,
}

/// More than any of [`case_of`], and below 32.
const UNKNOWN_CASE: u32 = 31;

impl ObbBoundsF32 {
    fn of(obb: &ObbBounds) -> Self {
        let axes = [obb.axes.x_axis, obb.axes.y_axis, obb.axes.z_axis];
        let up = |x: f64| (x as f32).next_up();
        let down = |x: f64| (x as f32).next_down().max(0.0);
        let [x, y, z] = obb.outer.to_array().map(up);
        let [u, v, w] = obb.inner.to_array().map(down);
        Self {
            axes: axes.map(|axis| axis.as_vec3()),
            outer: Vec3::new(x, y, z),
            inner: Vec3::new(u, v, w),
            case: UNKNOWN_CASE as f32,
        }
    }
}

/// The cores of all shapes of a scene, and their vertices in f32 blocks, one after the other.
#[derive(Clone, Debug, Default)]
pub(crate) struct Cores {
    /// Of which shapes.
    of: Revision,
    shapes: Column,
    parts: Column,
    /// The same parts, sixteen of one compound at a time.
    groups: PartGroups,
    blocks: Vec<Block>,
}

/// Cores, and the boxes of those that have some.
#[derive(Clone, Debug, Default)]
struct Column {
    cores: Vec<Core>,
    /// One for each core, up to the last that has one.
    obbs: Vec<ObbBoundsF32>,
}

impl Column {
    #[inline]
    fn push(&mut self, core: Core, obb: Option<ObbBoundsF32>) {
        self.cores.push(core);
        if let Some(obb) = obb {
            self.obbs.resize(self.cores.len(), ObbBoundsF32::default());
            self.obbs[self.cores.len() - 1] = obb;
        }
    }
}

impl Cores {
    /// Takes in the shapes of a scene: those that are new, where the others are in already.
    pub(crate) fn follow(&mut self, scene: &Scene) {
        if self.of == scene.shape_revision() {
            return;
        }
        match scene.shapes_since(self.of) {
            Some(new) => self.append(new),
            None => {
                *self = Self::default();
                self.append(scene.shapes());
            }
        }
        self.of = scene.shape_revision();
    }

    /// Adds those of these shapes: costs what they do, whatever is there.
    fn append(&mut self, shapes: &[Shape]) {
        self.shapes.cores.reserve(shapes.len());
        for shape in shapes {
            let (core, obb) = self.core(shape);
            self.shapes.push(core, obb);
        }
        let first = self.shapes.cores.len() - shapes.len();
        for (k, shape) in shapes.iter().enumerate() {
            if let Shape::Compound(compound) = shape {
                self.append_parts(first + k, compound);
            }
        }
    }

    fn core(&mut self, shape: &Shape) -> (Core, Option<ObbBoundsF32>) {
        match shape {
            Shape::Polytope(polytope) => self.of_polytope(polytope),
            Shape::Curved(curved) => self.of_inscribed(&Inscribed::of(curved), shape),
            Shape::Ellipsoid(ellipsoid) => {
                self.of_inscribed(&Inscribed::of_ellipsoid(ellipsoid), shape)
            }
            Shape::Mesh(mesh) => Self::of_mesh(mesh),
            _ => (Core::default(), None),
        }
    }

    /// A surface, of which the lanes know no more than a box round it.
    fn of_mesh(mesh: &Mesh) -> (Core, Option<ObbBoundsF32>) {
        let Some((centre, obb)) = mesh.obb() else { return (Core::default(), None) };
        let Corners { centre: near, radius, .. } = mesh.all_corners();
        // At most the way from one centre to the other more, and what both are rounded by.
        let outer = (radius + near.distance(centre)) * (1.0 + 1e-9) + MOVED * mesh.reach();
        let (reach, radius) = (mesh.reach(), mesh.swept_radius());
        let core = Core { centre, outer, reach, radius, has_obb: true, ..Core::default() };
        (core, Some(ObbBoundsF32::of(&obb)))
    }

    /// The cores of a compound's parts, neighbours beside each other: in the order of its tree.
    fn append_parts(&mut self, shape: usize, compound: &Compound) {
        let after = self.parts.cores.len() + compound.parts().len();
        // More than a u32 counts stay with the general search.
        if compound.parts().len() > MAX_PARTS || u32::try_from(after).is_err() {
            return;
        }
        let first_part = self.parts.cores.len() as u32;
        for number in compound.tree().parts() {
            let part = &compound.parts()[number as usize];
            let (core, obb) = match part.moved_curved() {
                Some(curved) => self.of_moved(curved, &part.pose),
                None => self.of_placed(part),
            };
            self.parts.push(Core { part: number, ..core }, obb);
        }
        let parts = self.parts.cores.len() as u32 - first_part;
        let first_group = self.groups.len() as u32;
        self.append_groups(first_part as usize);
        let whole = &mut self.shapes.cores[shape];
        *whole = Core { first_part, parts, first_group, ..*whole };
    }

    /// The groups of a compound's parts, which begin there. All of them count with the farthest one's reach, so that one slack is
    /// known for all.
    fn append_groups(&mut self, first: usize) {
        let Column { cores, obbs } = &mut self.parts;
        let cores = &mut cores[first..];
        let reach = cores.iter().map(|core| core.reach).fold(0.0, f64::max);
        cores.iter_mut().for_each(|core| core.reach = reach);
        for (group, cores) in cores.chunks(WIDTH).enumerate() {
            let obbs = obbs.get(first + group * WIDTH..).unwrap_or_default();
            self.groups.push(cores, obbs);
        }
    }

    /// A part as its compound has placed it.
    fn of_placed(&mut self, part: &Part) -> (Core, Option<ObbBoundsF32>) {
        let (core, obb) = self.core(part.placed());
        let kind = part.shape.as_polytope().map(Polytope::kind);
        let placed = part.placed().as_polytope().and_then(Polytope::obb);
        let (Some(Kind::Cuboid { half_extents }), Some(placed)) = (kind, placed) else {
            return (core, obb);
        };
        let apart = (placed.outer - placed.inner).max_element();
        // Else it was placed as any hull, whose OBBs have axes of their own, in an order of their own.
        let is_turned = placed.axes == *part.pose.rotation();
        if !is_turned || !(apart <= NEARLY * half_extents.min_element()) {
            return (core, obb);
        }
        let case = case_of(half_extents.to_array()).unwrap_or(UNKNOWN_CASE) as f32;
        (Core { is_nearly_box: true, ..core }, obb.map(|obb| ObbBoundsF32 { case, ..obb }))
    }

    fn of_polytope(&mut self, polytope: &Polytope) -> (Core, Option<ObbBoundsF32>) {
        let core = Core::of_polytope(polytope);
        let (core, obb) = self.with_blocks(core, polytope.vertices(), polytope.obb());
        let case = match polytope.kind() {
            Kind::Cuboid { half_extents } => case_of(half_extents.to_array()),
            _ => None,
        };
        (core, obb.map(|obb| ObbBoundsF32 { case: case.unwrap_or(UNKNOWN_CASE) as f32, ..obb }))
    }

    fn of_inscribed(&mut self, hull: &Inscribed, shape: &Shape) -> (Core, Option<ObbBoundsF32>) {
        let core = Core {
            inner: hull.inner.radius,
            outer: hull.outer,
            reach: hull.reach,
            radius: shape.radius(),
            centre: hull.inner.centre,
            excess: hull.excess,
            ..Core::default()
        };
        self.with_blocks(core, &hull.vertices, hull.obb.as_ref())
    }

    /// A curved part in its place: R·v + t of the hull's vertices, each rounded. The reach counts
    /// twice, for what they and the centre lose by that (docs/numerics/proofs.md, "parts").
    fn of_moved(&mut self, curved: &Curved, pose: &Pose) -> (Core, Option<ObbBoundsF32>) {
        let hull = Inscribed::of(curved);
        let stretch = 1.0 + pose.deviation();
        let reach = curved.reach() * stretch + pose.translation().length();
        let vertices: Vec<DVec3> = hull.vertices.iter().map(|&v| pose.apply(v)).collect();
        let core = Core {
            inner: hull.inner.radius * (2.0 - stretch),
            outer: hull.outer * stretch + MOVED * reach,
            reach: 2.0 * reach,
            radius: curved.swept_radius(),
            centre: pose.apply(hull.inner.centre),
            excess: hull.excess * stretch,
            ..Core::default()
        };
        let obb = hull.obb.and_then(|obb| obb.rotated(pose, reach));
        self.with_blocks(core, &vertices, obb.as_ref())
    }

    /// The core with its vertices and boxes.
    fn with_blocks(
        &mut self,
        core: Core,
        vertices: &[DVec3],
        obb: Option<&ObbBounds>,
    ) -> (Core, Option<ObbBoundsF32>) {
        let after = self.blocks.len() + vertices.len().div_ceil(WIDTH);
        // More than a u32 counts are not kept: a shape without blocks is one that the lanes do not know.
        let kept = if u32::try_from(after).is_ok() { vertices } else { &[] };
        let first = self.blocks.len() as u32;
        self.blocks.extend(Block::relative(kept, core.centre));
        let blocks = self.blocks.len() as u32 - first;
        let has_obb = obb.is_some();
        let is_box = obb.is_some_and(ObbBounds::is_exact);
        (Core { first, blocks, has_obb, is_box, ..core }, obb.map(ObbBoundsF32::of))
    }

    /// One for each shape of the scene.
    pub(crate) fn cores(&self) -> &[Core] {
        &self.shapes.cores
    }

    /// For each shape its boxes, up to the last that has some; meaningful where
    /// [`Core::has_obb`] is set.
    pub(crate) fn obbs(&self) -> &[ObbBoundsF32] {
        &self.shapes.obbs
    }

    /// Those of the parts of compounds: of each one after the other, from [`Core::first_part`] on.
    pub(crate) fn parts(&self) -> &[Core] {
        &self.parts.cores
    }

    /// [`Cores::parts`], sixteen of one compound at a time: of each one from [`Core::first_group`] on.
    pub(crate) fn groups(&self) -> &PartGroups {
        &self.groups
    }

    /// For each of [`Cores::parts`] its boxes, as [`Cores::obbs`] has them.
    pub(crate) fn part_obbs(&self) -> &[ObbBoundsF32] {
        &self.parts.obbs
    }

    /// Whether any has boxes.
    pub(crate) fn have_obbs(&self) -> bool {
        !self.shapes.obbs.is_empty() || !self.parts.obbs.is_empty()
    }

    /// All vertices: those of a compound's parts follow each other.
    #[inline]
    pub(crate) fn all_blocks(&self) -> &[Block] {
        &self.blocks
    }

    /// The vertices of a core, relative to its centre.
    #[inline]
    pub(crate) fn blocks(&self, core: &Core) -> &[Block] {
        &self.blocks[core.first as usize..][..core.blocks as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(shapes: &[Shape]) -> Cores {
        let mut cores = Cores::default();
        cores.append(shapes);
        cores
    }

    #[test]
    fn the_last_block_is_filled_up_with_the_last_vertex() {
        let points = (0..20).map(|k| DVec3::new(f64::from(k), f64::from(k % 3), 1.0)).collect();
        let shapes = [Shape::hull(points).unwrap(), Shape::cylinder(1.0, 2.0).unwrap()];
        let cores = of(&shapes);
        let [hull, cylinder] = [0, 1].map(|k| cores.cores()[k]);
        assert_eq!((hull.first, hull.blocks, cylinder.first, cylinder.blocks), (0, 2, 2, 3));
        let last = cores.blocks(&hull)[1];
        assert_eq!(last.0[0].0[3], (19.0 - hull.centre.x) as f32);
        assert_eq!(last.0[0].0[15], (19.0 - hull.centre.x) as f32);
        assert!(hull.excess == 0.0 && cylinder.excess > 0.0);
    }

    #[test]
    fn the_parts_of_compounds_stand_apart_from_the_shapes_in_the_order_of_their_tree() {
        let cube = Shape::cuboid(DVec3::ONE).unwrap();
        let parts = (0..20).map(|k| {
            (cube.clone(), Pose::from_translation(DVec3::X * f64::from(k * 7 % 20)).unwrap())
        });
        let compound = Compound::new(parts.collect()).unwrap();
        let shapes = [Shape::from(compound.clone()), cube];
        let mut cores = of(&shapes);
        // Another one behind them, as if it had been there from the start.
        cores.append(&shapes[..1]);
        let (whole, again) = (cores.cores()[0], cores.cores()[2]);
        assert_eq!((whole.first_part, whole.parts, whole.blocks), (0, 20, 0));
        assert_eq!((again.first_part, again.parts, cores.parts().len()), (20, 20, 40));
        let parts = &cores.parts()[..20];
        let mut numbers: Vec<u32> = parts.iter().map(|core| core.part).collect();
        numbers.sort_unstable();
        assert_eq!(numbers, (0..20).collect::<Vec<_>>());
        for core in parts {
            let placed = compound.parts()[core.part as usize].placed();
            assert_eq!(core.centre, placed.as_polytope().unwrap().inner().centre);
            assert!(core.has_obb && cores.blocks(core).len() == 1);
        }
    }

    #[test]
    fn of_a_compound_of_very_many_parts_the_lanes_know_nothing() {
        let part = (Shape::sphere(1.0).unwrap(), Pose::IDENTITY);
        let shape = |parts| Shape::compound(vec![part.clone(); parts]).unwrap();
        let cores = of(&[shape(MAX_PARTS), shape(MAX_PARTS + 1)]);
        assert_eq!([0, 1].map(|k| cores.cores()[k].parts), [MAX_PARTS as u32, 0]);
        assert_eq!((cores.cores().len(), cores.parts().len()), (2, MAX_PARTS));
    }
}
