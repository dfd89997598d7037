//! Objects made ready: vertices rotated, spheres bounded, boxes found.

mod forms;
#[cfg(test)]
mod tests;

pub(super) use forms::constants;

use super::axis_aligned::AxisAligned;
use super::bounds::{CENTRE, CHOICE, ROTATED, TURNED, U};
use super::compounds::{CompoundPart, Whole};
use super::cores::{Core, Cores, ObbBoundsF32};
use super::form::Form;
use super::frame::{
    AXIS_ALIGNED, BOX, Extremes, HAS_OBB, LIVE, NEARLY_BOX, ObbRecord, Part, Record, SPHERE,
    STRAIGHT_CORE, WHOLE,
};
use super::vector::V3;
use dcd_geom::glam::{DVec3, Vec3};
use dcd_geom::{Aabb, Corners, Mesh, Pose, Scene, Shape};
use dcd_simd::{Block, Kernel, Lanes, Path, Row, Unfused, WIDTH, dispatch_on, prefetch};

/// Runs the kernel on that path: compiled here, once. Nothing is fused: AABBs are the same to the bit on every path, for they
/// decide in which order pairs are found.
pub(crate) fn prepare(path: Path, objects: Prepare<'_>) {
    dispatch_on(path, Unfused(objects));
}

/// Prepares the objects from `first` on.
pub(crate) struct Prepare<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) first: usize,
    pub(crate) part: Part<'a>,
    pub(crate) aabbs: &'a mut [Aabb],
}

impl Kernel for Prepare<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        match self.part.form {
            Form::Any | Form::CuboidParts => self.any(l),
            Form::Spheres => self.spheres(),
            Form::Cuboids => self.cuboids(),
        }
    }
}

impl Prepare<'_> {
    /// Of any kinds, each from its vertices.
    #[inline(always)]
    fn any<L: Lanes>(self, l: L) {
        let mut blocks = self.part.blocks;
        let mut compound_part = self.part.compound_part;
        let mut own;
        let extremes = match self.part.extremes {
            Some(lent) => lent,
            None => {
                own = Extremes::default();
                &mut own
            }
        };
        let cores = self.part.cores;
        let (boxes, uprights) = (self.part.boxes, self.part.uprights);
        let groups = self.part.records.chunks_mut(WIDTH).zip(self.aabbs.chunks_mut(WIDTH));
        for (group, (records, aabbs)) in groups.enumerate() {
            let first = self.first + group * WIDTH;
            for (lane, record) in records.iter_mut().enumerate() {
                let (own, others) =
                    std::mem::take(&mut blocks).split_at_mut(usize::from(record.blocks));
                blocks = others;
                let object = first + lane;
                look_ahead(self.scene, cores, object + AHEAD);
                let core = &cores.cores()[self.scene.shape_of()[object] as usize];
                let pose = &self.scene.poses()[object];
                *record = place(record, core, pose);
                if record.marks & HAS_OBB != 0 {
                    let shape = self.scene.shape_of()[object] as usize;
                    let place = group * WIDTH + lane;
                    boxes[place] = turn(&cores.obbs()[shape], record, pose);
                    if own.is_empty() {
                        boxes[place].hold_nothing();
                    }
                    if let Some(upright) = AxisAligned::of(&self.scene.shapes()[shape], pose) {
                        uprights[place] = upright;
                        record.marks |= AXIS_ALIGNED;
                    }
                }
                let found = match own {
                    [] => reach_of_corners(l, self.scene.shape(object), pose),
                    _ => Rotation::of(l, pose).turn_all(l, &cores.blocks(core)[..own.len()], own),
                };
                extremes.keep(l, lane, found);
            }
            let reach = extremes.of_each(l);
            for (lane, (record, aabb)) in records.iter().zip(aabbs).enumerate() {
                let place = (group * WIDTH + lane, first + lane);
                *aabb = match record.marks & WHOLE {
                    0 => {
                        let rest = (&mut compound_part, &mut *extremes, &reach);
                        not_whole(l, (self.scene, cores), place, rest)
                    }
                    _ => boxed(record, &reach, lane),
                };
            }
        }
    }
}

/// The box of an object that is not the hull of its vertices: round its parts, a mesh's corners, or its
/// shape. It is the part's `k`-th and the scene's `object`-th.
#[inline(always)]
fn not_whole<L: Lanes>(
    l: L,
    (scene, cores): (&Scene, &Cores),
    (k, object): (usize, usize),
    (compound_part, extremes, reach): (&mut CompoundPart<'_>, &mut Extremes, &[Row; 6]),
) -> Aabb {
    let core = &cores.cores()[scene.shape_of()[object] as usize];
    let (shape, pose) = (scene.shape(object), &scene.poses()[object]);
    match shape {
        Shape::Mesh(mesh) => boxed(&round_corners(mesh, pose), reach, k % WIDTH),
        _ if compound_part.holds(k) => {
            compound_part.prepare(l, (k, Whole { cores, core, shape, pose }), extremes)
        }
        _ => scene.aabb(object),
    }
}

/// How far the corners of a mesh reach, lane by lane; of any other shape, nowhere.
#[inline(always)]
fn reach_of_corners<L: Lanes>(l: L, shape: &Shape, pose: &Pose) -> [L::F; 6] {
    let mut all = [l.splat(f32::NEG_INFINITY); 6];
    let Shape::Mesh(mesh) = shape else { return all };
    let rotation = Rotation::of(l, pose);
    let mut turned = [Block::default(); SOME];
    for some in mesh.all_corners().blocks.chunks(SOME) {
        let found = rotation.turn_all(l, some, &mut turned);
        for side in 0..6 {
            all[side] = l.max(all[side], found[side]);
        }
    }
    all
}

/// How many blocks of a mesh are turned at once: what that leaves behind stays near. No effect on any
/// result.
const SOME: usize = 16;

/// What [`boxed`] needs to know of the corners of a mesh.
#[inline(always)]
fn round_corners(mesh: &Mesh, pose: &Pose) -> Record {
    let &Corners { centre, radius: outer, .. } = mesh.all_corners();
    // The middle of a box may be farther off than its corners, by less than √3.
    let reach = 2.0 * mesh.reach();
    let core = Core { centre, outer, reach, radius: mesh.swept_radius(), ..Core::default() };
    place(&Record::default(), &core, pose)
}

/// How many objects ahead vertices are prefetched: about as many as are prepared within one memory
/// latency. No effect on any result.
const AHEAD: usize = 4;

#[inline(always)]
fn look_ahead(scene: &Scene, cores: &Cores, object: usize) {
    if let Some(&shape) = scene.shape_of().get(object) {
        prefetch(cores.blocks(&cores.cores()[shape as usize]));
    }
}

/// Everything of a record but its vertices, for this pose and any that departs from a rotation by
/// less than [`TURNED`].
#[inline(always)]
pub(super) fn place(record: &Record, core: &Core, pose: &Pose) -> Record {
    let deviation = pose.deviation().max(TURNED);
    let stretch = 1.0 + deviation;
    let centre = *pose.rotation() * core.centre + pose.translation();
    let tag = u16::from(record.blocks).next_power_of_two() * WIDTH as u16 - 1;
    let inner = core.inner * (1.0 - deviation) + core.radius;
    Record {
        centre: centre.extend(if core.is_sphere { core.radius } else { 0.0 }).to_array(),
        first: record.first,
        blocks: record.blocks,
        tag,
        inner: below(inner),
        outer: above(core.outer * stretch + core.radius),
        size: above(core.outer * stretch),
        radius: above(core.radius),
        slack: slack(core.reach, pose, stretch),
        marks: marks(record, core, pose),
        choice: above((core.outer * f64::from(tag) * CHOICE + core.excess) * stretch),
    }
}

/// What [`Record::slack`] is of a core that reaches so far, at a pose that stretches it so much at most.
#[inline(always)]
pub(super) fn slack(reach: f64, pose: &Pose, stretch: f64) -> f32 {
    above(
        CENTRE * (f64::EPSILON / 2.0) * (pose.translation().abs().max_element() + reach * stretch),
    )
}

/// What [`place`] marks.
#[inline(always)]
fn marks(record: &Record, core: &Core, pose: &Pose) -> u8 {
    let marked = |holds: bool, mark: u8| if holds { mark } else { 0 };
    let boxed = core.has_obb && pose.deviation() < TURNED;
    // What needs no vertices has none, and is marked already.
    let is_live = record.blocks > 0 || record.marks & LIVE != 0;
    marked(boxed, HAS_OBB)
        | marked(boxed && core.is_box && core.radius == 0.0, BOX)
        | marked(boxed && core.is_nearly_box && core.radius == 0.0, NEARLY_BOX)
        | marked(core.is_sphere, SPHERE)
        | marked(record.blocks > 0 && core.is_straight, STRAIGHT_CORE)
        | marked(is_live, LIVE)
        | marked(is_live && core.excess == 0.0, WHOLE)
}

/// The boxes of a shape at a pose. What the matrix departs from a rotation by makes the boxes of the
/// exact rotation larger and smaller.
#[inline(always)]
pub(super) fn turn(obb: &ObbBoundsF32, record: &Record, pose: &Pose) -> ObbRecord {
    let mut numbers = Row::default();
    let margin = 4.0 * pose.deviation().max(TURNED) * f64::from(record.size);
    for axis in 0..3 {
        let edge = *pose.rotation() * obb.axes[axis].as_dvec3();
        numbers.0[3 * axis..][..3].copy_from_slice(&edge.as_vec3().to_array());
        let outer = f64::from(obb.outer[axis]) + margin + f64::from(record.radius);
        numbers.0[9 + axis] = above(outer);
        numbers.0[12 + axis] = below((f64::from(obb.inner[axis]) - margin).max(0.0));
    }
    numbers.0[15] = obb.case;
    ObbRecord { numbers }
}

/// An f32 at most x ≥ 0: two roundings and the sum that made x are less than two units.
#[inline(always)]
fn below(x: f64) -> f32 {
    (x as f32) * (1.0 - 4.0 * U)
}

/// An f32 at least x ≥ 0, and above 0 where x is.
#[inline(always)]
fn above(x: f64) -> f32 {
    let up = (x as f32) * (1.0 + 4.0 * U);
    if x > 0.0 { up.max(f32::MIN_POSITIVE) } else { up }
}

/// A rotation's matrix in f32, its columns in every lane.
pub(super) struct Rotation<L: Lanes>([V3<L>; 3]);

impl<L: Lanes> Rotation<L> {
    #[inline(always)]
    pub(super) fn of(l: L, pose: &Pose) -> Self {
        let m = pose.rotation().as_mat3();
        Self([spread(l, m.x_axis), spread(l, m.y_axis), spread(l, m.z_axis)])
    }

    /// Writes R·v in f32 for sixteen vertices.
    #[inline(always)]
    pub(super) fn turn(&self, l: L, local: &Block, out: &mut Block) -> V3<L> {
        let Self([mx, my, mz]) = self;
        let V3(x, y, z) = V3::<L>::load(l, &local.0);
        let zero = l.splat(0.0);
        let world = V3(zero, zero, zero).plus(l, z, *mz).plus(l, y, *my).plus(l, x, *mx);
        world.store(l, &mut out.0);
        world
    }

    /// [`Rotation::turn`] of every block. Returns the largest x, y, z, −x, −y, −z lane by lane.
    #[inline(always)]
    pub(super) fn turn_all(&self, l: L, local: &[Block], out: &mut [Block]) -> [L::F; 6] {
        let lowest = l.splat(f32::NEG_INFINITY);
        let mut extremes = [lowest; 6];
        for (local, out) in local.iter().zip(out) {
            let world = self.turn(l, local, out);
            let back = world.neg(l);
            extremes = [
                l.max(extremes[0], world.0),
                l.max(extremes[1], world.1),
                l.max(extremes[2], world.2),
                l.max(extremes[3], back.0),
                l.max(extremes[4], back.1),
                l.max(extremes[5], back.2),
            ];
        }
        extremes
    }
}

/// One vector in every lane.
#[inline(always)]
fn spread<L: Lanes>(l: L, v: Vec3) -> V3<L> {
    V3(l.splat(v.x), l.splat(v.y), l.splat(v.z))
}

/// The box of the object in that lane: its rotated vertices' extremes round its centre, and what all
/// of it may be off by.
#[inline(always)]
pub(super) fn boxed(record: &Record, reach: &[Row; 6], lane: usize) -> Aabb {
    let at = |side: usize| f64::from(reach[side].0[lane]);
    let pad = f64::from(record.size) * f64::from(ROTATED * U)
        + f64::from(record.radius)
        + f64::from(record.slack);
    let [x, y, z, _] = record.centre;
    let centre = DVec3::new(x, y, z);
    let (reach, back) = (DVec3::new(at(0), at(1), at(2)), DVec3::new(at(3), at(4), at(5)));
    Aabb::outward(centre - (back + pad), centre + (reach + pad))
}
