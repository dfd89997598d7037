use super::*;
use crate::motion::tests::Draw;
use crate::query::MeasureAt;
use crate::{Depths, Verdict};
use dcd_geom::glam::DQuat;

fn pose(draw: &mut Draw, reach: f64) -> Pose {
    let turn = DQuat::from_scaled_axis(draw.vector() * 3.0).normalize();
    Pose::new(turn, draw.vector() * reach).unwrap()
}

#[test]
fn a_part_is_as_deep_below_a_plane_in_its_frame_as_in_the_world() {
    let mut draw = Draw(73);
    let [mut deep, mut apart] = [0; 2];
    for k in 0..4000 {
        let half = draw.vector().abs() * 0.3 + 0.05;
        let made = match k % 4 {
            0 => Shape::cuboid(half),
            1 => Shape::capsule(half.x, half.y),
            2 => Shape::hull((0..10).map(|_| draw.vector() * 0.4).collect()),
            _ => Shape::cuboid(half).and_then(|cuboid| cuboid.rounded(0.05)),
        };
        let (part, at) = (made.unwrap(), pose(&mut draw, 0.4));
        let plane = Shape::half_space(draw.vector(), -0.3).unwrap();
        let far = if k % 3 == 0 { 1e3 } else { 0.3 };
        let (frame, ground) = (pose(&mut draw, far), pose(&mut draw, 0.3));
        let ground = match k % 3 {
            0 => ground.with_translation(frame.translation() + draw.vector() * 0.3).unwrap(),
            _ => ground,
        };
        let ground = PosedShape { shape: &plane, pose: &ground };
        let seen = PlaneInFrame::of(Accuracy::F32, ground, &frame).unwrap();
        let posed = PosedShape { shape: &part, pose: &at };
        // What the product of the poses loses is the compound's own.
        let moved = 4e-15;
        let (gap, _) = seen.gap_of(posed, moved).unwrap();
        let compound = Shape::compound(vec![(part.clone(), at)]).unwrap();
        let Shape::Compound(compound) = &compound else { panic!() };
        let placed = PosedShape { shape: compound.parts()[0].placed(), pose: &frame };
        match gap.verdict() {
            Verdict::Touching(found) => {
                let due =
                    Depths.measure_at(Accuracy::Certified, placed, ground, &mut Default::default());
                let Verdict::Touching(due) = due else { panic!("{k}: {found:?}") };
                let off = (found.depth - due.depth).abs();
                assert!(off <= found.error_bound + due.error_bound, "{k}: {found:?} {due:?}");
                assert!(found.error_bound < 1e-10, "{k}: {found:?}");
                let placed_point = frame.apply(found.point_a);
                assert!(placed_point.distance(due.point_a) < 1e-9, "{k}");
                deep += 1;
            }
            Verdict::Apart => {
                let overlap = crate::certified::overlap_of(placed, ground).0;
                assert_eq!(overlap, Verdict::Apart, "{k}");
                apart += 1;
            }
            Verdict::Undecided(_) => {}
        }
    }
    assert!(deep > 1000 && apart > 500, "{deep} {apart}");
}
