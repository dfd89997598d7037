//! The faces of boxes beside the same in f64.

use super::super::obb::{ObbPairs, faces};
use super::*;

/// The faces of the boxes of at most sixteen pairs: which are apart along one, by how much.
struct Faces<'a> {
    frame: &'a SimdFrame,
    pairs: &'a [Pair],
}

impl Kernel for Faces<'_> {
    type Output = (Verdicts, Row);

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Self::Output {
        let (mut entry, mut boxes) = (Entry::default(), ObbPairs::default());
        let (frames, mut gaps) = (FramePair::of_one(self.frame), Row::default());
        entry.read::<CertifiedBounds>(frames, self.pairs, 0);
        entry.spheres::<L, CertifiedBounds>(l);
        let resolved = faces(l, frames, &mut boxes, (&entry.packet, self.pairs.len()));
        l.store(resolved.clearance, &mut gaps);
        (Verdicts::of(resolved), gaps)
    }
}

/// How far apart two boxes are along a direction, by projecting their corners.
fn gap_along(axis: DVec3, c: DVec3, boxes: [PlainBox; 2]) -> f64 {
    let reach = |(edges, half): PlainBox| half.dot((edges.transpose() * axis).abs());
    axis.dot(c).abs() - boxes.map(reach).iter().sum::<f64>()
}

#[test]
fn the_gap_of_faces_is_the_widest_of_boxes_in_f64_whichever_box_is_first() {
    for seed in 20..24 {
        let scene = thin_scene(seed);
        let (pairs, mut seen) = (pairs(&scene), 0);
        let outer = |i: u32| {
            let reference = *scene.shape(i as usize).as_polytope().unwrap().obb().unwrap();
            (*scene.poses()[i as usize].rotation() * reference.axes, reference.outer)
        };
        for path in paths() {
            let (frame, _) = prepared(&scene, path);
            for group in pairs.chunks(WIDTH) {
                let turned: Vec<Pair> =
                    group.iter().map(|pair| Pair { i: pair.j, j: pair.i }).collect();
                let (said, found) = dispatch_on(path, Faces { frame: &frame, pairs: group });
                let (_, back) = dispatch_on(path, Faces { frame: &frame, pairs: &turned });
                for (k, &pair) in group.iter().enumerate() {
                    let boxes = [outer(pair.i), outer(pair.j)];
                    let c = Plain::of(&scene, pair).centre;
                    let axes = boxes.map(|(m, _)| [m.x_axis, m.y_axis, m.z_axis]);
                    let gaps = axes.as_flattened().iter().map(|&axis| gap_along(axis, c, boxes));
                    let widest = gaps.fold(f64::NEG_INFINITY, f64::max);
                    agree("faces of boxes", said.apart >> k & 1 == 1, widest);
                    let gap = found.0[k];
                    assert_eq!(gap, back.0[k]);
                    let gap = f64::from(gap);
                    assert!(gap <= widest && widest - gap < 1e-3, "{gap} {widest}");
                    seen += usize::from(said.apart >> k & 1 == 1);
                }
            }
        }
        assert!(seen > 0, "no face parted two boxes");
    }
}
