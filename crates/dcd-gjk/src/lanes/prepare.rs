//! Objects made ready: vertices rotated, balls bounded, boxes found.

use super::bounds::{CENTRE, ROTATED, U};
use super::frame::{Part, Record};
use super::vector::V3;
use dcd_geom::glam::DVec3;
use dcd_geom::lanes::{Block, Kernel, Lanes, Row, WIDTH};
use dcd_geom::{Aabb, Core, Pose, Scene};

/// Prepares the objects from `first` on.
pub(super) struct Prepare<'a> {
    pub(super) scene: &'a Scene,
    pub(super) first: usize,
    pub(super) part: Part<'a>,
    pub(super) aabbs: &'a mut [Aabb],
}

/// Sixteen objects' coordinates, the largest of each lane of a block.
type Extremes<L> = [<L as Lanes>::F; WIDTH];

impl Kernel for Prepare<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        let mut blocks = self.part.blocks;
        let groups = self.part.records.chunks_mut(WIDTH).zip(self.aabbs.chunks_mut(WIDTH));
        for (group, (records, aabbs)) in groups.enumerate() {
            let first = self.first + group * WIDTH;
            // The largest x, y, z and the largest −x, −y, −z of each object.
            let mut extremes: [Extremes<L>; 6] = [[l.splat(0.0); WIDTH]; 6];
            for (lane, record) in records.iter_mut().enumerate() {
                let (own, others) =
                    std::mem::take(&mut blocks).split_at_mut(record.blocks as usize);
                blocks = others;
                let object = first + lane;
                let core = &self.scene.cores().cores()[self.scene.shape_of()[object] as usize];
                let pose = &self.scene.poses()[object];
                *record = place(record, core, pose);
                let local = &self.scene.cores().blocks(core)[..own.len()];
                let found = rotate(l, pose, local, own);
                for (side, extreme) in extremes.iter_mut().zip(found) {
                    side[lane] = extreme;
                }
            }
            let mut reach = [Row::default(); 6];
            for (row, extremes) in reach.iter_mut().zip(&extremes) {
                l.store(l.largest_of_each(extremes), row);
            }
            for (lane, (record, aabb)) in records.iter().zip(aabbs).enumerate() {
                *aabb = match record.blocks {
                    0 => self.scene.aabb(first + lane),
                    _ => boxed(record, reach.each_ref().map(|row| row.0[lane])),
                };
            }
        }
    }
}

/// Everything of a record but its vertices.
#[inline(always)]
fn place(record: &Record, core: &Core, pose: &Pose) -> Record {
    let stretch = 1.0 + pose.deviation();
    let t = pose.translation();
    let centre = *pose.rotation() * core.centre + t;
    let slack = CENTRE * (f64::EPSILON / 2.0) * (t.abs().max_element() + core.reach * stretch);
    let inner = core.inner * (1.0 - pose.deviation()) + core.radius;
    Record {
        centre: centre.to_array(),
        first: record.first,
        blocks: record.blocks,
        inner: below(inner),
        outer: above(core.outer * stretch + core.radius),
        size: above(core.outer * stretch),
        radius: above(core.radius),
        slack: above(slack),
    }
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

/// Writes R·v in f32 for every vertex, and returns the largest x, y, z, −x, −y, −z lane by lane.
#[inline(always)]
fn rotate<L: Lanes>(l: L, pose: &Pose, local: &[Block], out: &mut [Block]) -> [L::F; 6] {
    let columns = pose.rotation().as_mat3().to_cols_array_2d();
    let m = columns.map(|column| column.map(|x| l.splat(x)));
    let lowest = l.splat(f32::NEG_INFINITY);
    let mut extremes = [lowest; 6];
    for (v, out) in local.iter().zip(out) {
        let V3(x, y, z) = V3::load(l, &v.0);
        let row = |k: usize| l.mul_add(m[0][k], x, l.mul_add(m[1][k], y, l.mul(m[2][k], z)));
        let world = [row(0), row(1), row(2)];
        V3::<L>(world[0], world[1], world[2]).store(l, &mut out.0);
        for k in 0..3 {
            extremes[k] = l.max(extremes[k], world[k]);
            extremes[k + 3] = l.max(extremes[k + 3], l.neg(world[k]));
        }
    }
    extremes
}

/// The object's box: its rotated vertices' extremes round its centre, and what all of it may be
/// off by.
#[inline(always)]
fn boxed(record: &Record, reach: [f32; 6]) -> Aabb {
    let [x, y, z, nx, ny, nz] = reach.map(f64::from);
    let pad = f64::from(record.size) * f64::from(ROTATED * U)
        + f64::from(record.radius)
        + f64::from(record.slack);
    let centre = DVec3::from_array(record.centre);
    Aabb::outward(centre - (DVec3::new(nx, ny, nz) + pad), centre + (DVec3::new(x, y, z) + pad))
}
