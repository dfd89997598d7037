//! Scenes of one kind whose pairs need no vertices: what depends on a shape alone is written once a
//! layout, what depends on its pose once a step.

use super::super::axis_aligned::AxisAligned;
use super::super::bounds::{CENTRE, TURNED};
use super::super::cores::Cores;
use super::super::frame::{AXIS_ALIGNED, BOX, HAS_OBB, LIVE, ObbRecord, Record, WHOLE};
use super::{Prepare, above, place, turn};
use dcd_geom::glam::DVec3;
use dcd_geom::{Aabb, Pose, Scene};
use dcd_simd::prefetch;

/// Writes what depends on the shapes alone, for poses that depart from a rotation by less than
/// [`TURNED`]. Spheres have no box record.
pub(in super::super) fn constants(
    scene: &Scene,
    cores: &Cores,
    records: &mut [Record],
    boxes: &mut [ObbRecord],
) {
    let (cores, obbs) = (cores.cores(), cores.obbs());
    for (record, &shape) in records.iter_mut().zip(scene.shape_of()) {
        let core = &cores[shape as usize];
        *record = place(&Record::default(), core, &Pose::IDENTITY);
        record.marks |= LIVE | WHOLE;
    }
    for ((boxes, record), &shape) in boxes.iter_mut().zip(records).zip(scene.shape_of()) {
        *boxes = turn(&obbs[shape as usize], record, &Pose::IDENTITY);
    }
}

impl Prepare<'_> {
    /// A sphere's centre is its translation; its matrix moves nothing.
    #[inline(always)]
    pub(super) fn spheres(self) {
        let poses = &self.scene.poses()[self.first..];
        let objects = self.part.records.iter_mut().zip(poses).zip(self.aabbs).enumerate();
        for (k, ((record, pose), aabb)) in objects {
            look_ahead(poses, k);
            let centre = pose.translation();
            write_centre(record, centre);
            *aabb = around(record, centre, DVec3::splat(record.outer.into()));
        }
    }

    /// A cuboid reaches |R|·h from its translation along the world's axes, whatever R departs from
    /// a rotation by; what it departs by decides whether the lanes may turn the boxes with it.
    #[inline(always)]
    pub(super) fn cuboids(self) {
        let poses = &self.scene.poses()[self.first..];
        let shape_of = &self.scene.shape_of()[self.first..];
        let records = self.part.records.iter_mut().zip(self.part.boxes).zip(self.part.uprights);
        let objects = records.zip(poses).zip(self.aabbs).enumerate();
        for (k, ((((record, boxes), upright), pose), aabb)) in objects {
            look_ahead(poses, k);
            let (centre, rotation) = (pose.translation(), pose.rotation());
            write_centre(record, centre);
            let marks = HAS_OBB | BOX | LIVE | WHOLE;
            record.marks = if pose.deviation() < TURNED { marks } else { 0 };
            if let Some(found) = AxisAligned::of(&self.scene.shapes()[shape_of[k] as usize], pose) {
                *upright = found;
                record.marks |= AXIS_ALIGNED;
            }
            let numbers = &mut boxes.numbers.0;
            let columns = rotation.to_cols_array();
            for k in 0..9 {
                numbers[k] = columns[k] as f32;
            }
            let reach = rotation.x_axis.abs() * f64::from(numbers[9])
                + rotation.y_axis.abs() * f64::from(numbers[10])
                + rotation.z_axis.abs() * f64::from(numbers[11]);
            *aabb = around(record, centre, reach);
        }
    }
}

/// How many poses ahead are prefetched: some hundred cycles of work. No effect on any result.
const AHEAD: usize = 24;

#[inline(always)]
fn look_ahead(poses: &[Pose], k: usize) {
    if let Some(pose) = poses.get(k + AHEAD) {
        prefetch(std::slice::from_ref(pose));
    }
}

/// The record of a shape whose centre is the origin of its frame.
#[inline(always)]
fn write_centre(record: &mut Record, centre: DVec3) {
    let size = centre.abs().max_element() + f64::from(record.size);
    record.centre[..3].copy_from_slice(&centre.to_array());
    record.slack = above(CENTRE * (f64::EPSILON / 2.0) * size);
}

/// What reaches so far from the centre, and what both may be off by.
#[inline(always)]
fn around(record: &Record, centre: DVec3, reach: DVec3) -> Aabb {
    let reach = reach + f64::from(record.slack);
    Aabb::outward(centre - reach, centre + reach)
}
