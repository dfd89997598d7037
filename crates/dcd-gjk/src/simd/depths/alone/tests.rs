//! The search of one pair: the same bits on every path and in both orders, and shapes that are not searched.

use super::{Search, SearchAlone};
use crate::motion::tests::Draw;
use crate::{Accuracy, PosedShape, Verdict, certified, epa};
use dcd_geom::glam::{DQuat, DVec3};
use dcd_geom::{Pose, Shape};
use dcd_simd::{Path, Unfused, dispatch_on};

fn on(path: Path, accuracy: Accuracy, sides: [PosedShape<'_>; 2]) -> Option<epa::Depth> {
    let SearchAlone { surface, blocks } = &mut SearchAlone::default();
    let found = dispatch_on(path, Unfused(Search { accuracy, sides, surface, blocks }));
    found.map(|found| found.depth)
}

/// Hulls of up to forty vertices, rounded or flat ones among them, cuboids, capsules, cylinders and cones.
fn shape(draw: &mut Draw, kind: usize) -> Shape {
    let count = 4 + (draw.number().abs() * 36.0) as usize;
    let half = draw.vector().abs() * 0.5 + 0.1;
    let mut hull =
        |scale: DVec3| Shape::hull((0..count).map(|_| draw.vector() * scale).collect()).unwrap();
    match kind % 7 {
        0 => hull(half),
        1 => hull(half).swept(0.1).unwrap(),
        2 => hull(half * DVec3::new(1.0, 1.0, 1e-3)),
        3 => Shape::cuboid(half).unwrap(),
        4 => Shape::capsule(half.x, half.y).unwrap(),
        5 => Shape::cylinder(half.x, half.y).unwrap(),
        _ => Shape::cone(half.x, half.y).unwrap(),
    }
}

#[test]
fn every_path_and_both_orders_have_the_same_bits() {
    let mut draw = Draw(17);
    let (mut touching, mut found) = (0, 0);
    for k in 0..3000 {
        let shapes = [shape(&mut draw, k), shape(&mut draw, k / 7)];
        let pose = |draw: &mut Draw| {
            let turn = DQuat::from_scaled_axis(draw.vector() * 3.0).normalize();
            Pose::new(turn, draw.vector() * 0.4).unwrap()
        };
        let poses = [pose(&mut draw), pose(&mut draw)];
        let [a, b] = [0, 1].map(|k| PosedShape { shape: &shapes[k], pose: &poses[k] });
        touching += usize::from(certified::overlap_of(a, b).0 == Verdict::Touching(()));
        for accuracy in [Accuracy::F32, Accuracy::F64, Accuracy::Certified] {
            let first = SearchAlone::default().depth(accuracy, [a, b]).map(|found| found.depth);
            found += usize::from(first.is_some());
            for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
                assert_eq!(on(path, accuracy, [a, b]), first, "{k} {path:?} {accuracy:?}");
                let back = on(path, accuracy, [b, a]);
                assert_eq!(back.map(epa::Depth::mirrored), first, "{k} {path:?} {accuracy:?}");
            }
        }
    }
    // Of round ones only at f32, and not of what has a formula.
    assert!(touching > 1500 && found > touching, "{found} of {touching}");
}

#[test]
fn what_the_lanes_do_not_search_is_refused() {
    let ring = |k: u32| DQuat::from_rotation_z(f64::from(k) * 0.02) * DVec3::X;
    let tips = [DVec3::Z, -DVec3::Z];
    let many = Shape::hull((0..314).map(ring).chain(tips).collect()).unwrap();
    let [sphere, cube] = [Shape::sphere(1.0).unwrap(), Shape::cuboid(DVec3::ONE).unwrap()];
    let ellipsoid = Shape::ellipsoid(DVec3::new(1.0, 0.5, 0.3)).unwrap();
    let cylinder = Shape::cylinder(0.5, 0.5).unwrap();
    let at = |shape| PosedShape { shape, pose: &Pose::IDENTITY };
    let mut search = SearchAlone::default();
    for (one, other) in [
        (&many, &cube),
        (&sphere, &cylinder),
        (&cube, &cube),
        (&ellipsoid, &cube),
        (&sphere, &sphere),
    ] {
        let found = search.depth(Accuracy::F32, [at(one), at(other)]);
        assert!(found.is_none(), "{one:?} {other:?}");
    }
    assert!(search.depth(Accuracy::F32, [at(&cylinder), at(&cube)]).is_some());
    // By its rims alone, which f64 does not confirm.
    assert!(search.depth(Accuracy::F64, [at(&cylinder), at(&cube)]).is_none());
}
