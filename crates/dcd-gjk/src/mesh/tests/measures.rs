//! How far apart shapes are that are made of parts, and how deep they overlap.

use super::*;
use dcd_simd::Path;

#[test]
fn the_distance_is_that_of_the_nearest_parts() {
    let mut scratch = Scratch::default();
    let mut apart = 0;
    for seed in 0..150 {
        let mut draw = Draw(seed);
        let scale = [1.0, 1e-9, 1e3][seed as usize % 3];
        let mut shape = |kind: u64| match kind % 3 {
            0 => draw.mesh(1 + (seed % 23) as usize, scale),
            1 => draw.compound(1 + (seed % 11) as usize, scale),
            _ => draw.hull(scale),
        };
        let (a, b) = (shape(seed % 2), shape(seed / 2));
        let (pose_a, pose_b) = (draw.pose(1.6 * scale), draw.pose(1.6 * scale));
        let (a, b) =
            (PosedShape { shape: &a, pose: &pose_a }, PosedShape { shape: &b, pose: &pose_b });
        let mut least = Some(f64::INFINITY);
        for in_a in &polytopes(a.shape) {
            for in_b in &polytopes(b.shape) {
                let (in_a, in_b) =
                    (PosedSupport::polytope(in_a, a.pose), PosedSupport::polytope(in_b, b.pose));
                let found = crate::distance::of_polytopes(in_a, in_b).0;
                least = match (least, found) {
                    (Some(least), DistanceResult::Apart(found)) => Some(least.min(found.distance)),
                    _ => None,
                };
            }
        }
        let there = crate::mesh::distance(a, b, &mut scratch).0;
        match (there, least) {
            (DistanceResult::Apart(found), Some(least)) => {
                assert_eq!(found.distance, least, "seed {seed}");
                let relative = (found.point_a - found.point_b).length();
                assert!((relative - least).abs() < 1e-9 * (least + scale), "seed {seed}");
                apart += 1;
            }
            (found, least) => assert_eq!((found, least), (DistanceResult::Touching, None)),
        }
        let DistanceResult::Apart(found) = there else { continue };
        let DistanceResult::Apart(back) = crate::mesh::distance(b, a, &mut scratch).0 else {
            panic!("seed {seed}: the other order is not apart");
        };
        assert_eq!((found.distance, found.point_a), (back.distance, back.point_b), "seed {seed}");
    }
    assert!((50..140).contains(&apart), "{apart}");
}

#[test]
fn the_depth_is_that_of_the_deepest_parts() {
    use crate::{Depths, PairSolver, epa};
    let mut scratch = epa::Scratch::default();
    let mut touching = 0;
    for seed in 0..60 {
        let mut draw = Draw(seed);
        let a = draw.compound(1 + (seed % 9) as usize, 1.0);
        let b = if seed % 2 == 0 { draw.compound(5, 1.0) } else { draw.mesh(9, 1.0) };
        let (pose_a, pose_b) = (draw.pose(0.8), draw.pose(0.8));
        let (a, b) =
            (PosedShape { shape: &a, pose: &pose_a }, PosedShape { shape: &b, pose: &pose_b });
        let mut most = None;
        for in_a in &polytopes(a.shape) {
            for in_b in &polytopes(b.shape) {
                let (in_a, in_b) =
                    (PosedSupport::polytope(in_a, a.pose), PosedSupport::polytope(in_b, b.pose));
                if let Verdict::Touching(found) = epa::depth(in_a, in_b, &mut scratch) {
                    most = Some(found.depth.max(most.unwrap_or(0.0)));
                }
            }
        }
        let there = Depths.solve(a, b, &mut scratch);
        let back = Depths.solve(b, a, &mut scratch);
        match (there, back, most) {
            (Verdict::Touching(found), Verdict::Touching(back), Some(most)) => {
                let off = (found.depth - most).abs();
                assert!(off <= found.error_bound + 1e-12 * most, "seed {seed}: {found:?} {most}");
                assert_eq!((found.depth, found.normal), (back.depth, -back.normal), "seed {seed}");
                touching += 1;
            }
            (found, _, most) => assert!(found == Verdict::Apart && most.is_none(), "seed {seed}"),
        }
    }
    assert!((15..60).contains(&touching), "{touching}");
}

#[test]
fn a_bodys_depth_in_a_mesh_is_that_of_its_deepest_triangle_however_few_are_measured() {
    use crate::mesh::{KnownParts, Lists, touching_with_depths};
    use crate::query::{Accuracy, MeasureDepth};
    use crate::{Depths, epa};
    let mut scratch = epa::Scratch::default();
    let (mut counts, mut tight, mut of_hulls) = ([0; 4], [0; 4], 0);
    for seed in 0..240 {
        let mut draw = Draw(seed);
        let ground = draw.mesh(25 + (seed % 16) as usize, 1.0);
        let kind = (seed / 2 % 4) as usize;
        let body = match kind {
            0 => Shape::cuboid(draw.point(0.4).abs() + 0.1),
            1 => Shape::cuboid(draw.point(0.3).abs() + 0.1).and_then(|cuboid| cuboid.rounded(0.1)),
            2 => Shape::capsule(0.3, 0.2),
            _ => Ok(draw.hull(0.8)),
        };
        let (body, poses) = (body.unwrap(), [draw.pose(0.3), draw.pose(0.3)]);
        let [a, b] = [(&ground, &poses[0]), (&body, &poses[1])]
            .map(|(shape, pose)| PosedShape { shape, pose });
        let (mut pairs, mut depths, mut bounds) = (Vec::new(), Vec::new(), Vec::new());
        let (known, bounded) = (&mut depths, Some(&mut bounds));
        let lists = Lists { pairs: &mut pairs, depths: known, at_most: bounded };
        touching_with_depths(Path::best(), [a, b], &mut Scratch::default(), lists);
        for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
            let mut on_path = (Vec::new(), Vec::new(), Vec::new());
            let lists = Lists {
                pairs: &mut on_path.0,
                depths: &mut on_path.1,
                at_most: Some(&mut on_path.2),
            };
            touching_with_depths(path, [a, b], &mut Scratch::default(), lists);
            assert_eq!((&on_path.0, &on_path.1), (&pairs, &depths), "{seed} {path:?}");
            assert_eq!(on_path.2, bounds, "{seed} {path:?}");
        }
        let bounded: Vec<_> = bounds.iter().map(|&(triangle, _)| [triangle, 0]).collect();
        assert_eq!(bounded, pairs, "{seed}");
        // Each triangle alone, by the expanding polytope.
        let (mut most, mut known) = (0.0f64, 0);
        let core = PosedSupport::polytope(b.shape.as_polytope().unwrap(), b.pose);
        for (number, triangle) in (0..).zip(&polytopes(a.shape)) {
            let triangle = PosedSupport::polytope(triangle, a.pose);
            let due = match epa::depth(triangle, core, &mut scratch) {
                Verdict::Touching(found) => found.depth,
                _ => 0.0,
            };
            most = most.max(due);
            for &(_, at_most) in bounds.iter().filter(|(of, _)| *of == number) {
                let above = f64::from(at_most) - due;
                assert!(above >= -1e-12, "{seed}: {at_most} {due}");
                tight[kind] += usize::from(above < 1e-5);
            }
            for (_, found) in depths.iter().filter(|(of, _)| *of == number) {
                let off = (found.depth - due).abs();
                assert!(off <= found.error_bound + 1e-12, "{seed}: {found:?} {due}");
                known += 1;
            }
        }
        assert_eq!(known, depths.len(), "{seed}");
        of_hulls += if kind == 3 { known } else { 0 };
        if pairs.is_empty() {
            continue;
        }
        let back: Vec<_> = pairs.iter().map(|&[of_a, of_b]| [of_b, of_a]).collect();
        for accuracy in [Accuracy::F32, Accuracy::F64, Accuracy::Certified] {
            let mut depth = |parts: &[[u32; 2]], sides| {
                let lists = [(&depths[..], &bounds[..]), (&depths[..], &[]), (&[], &[])];
                let [found, again, alone] = lists.map(|(depths, at_most)| {
                    let known = KnownParts { parts, depths, at_most };
                    let mut found = Default::default();
                    let verdict =
                        Depths.measure_parts(accuracy, known, sides, &mut scratch, &mut found);
                    assert_eq!(verdict, Verdict::Touching(()), "{seed}");
                    found
                });
                for other in [again, alone] {
                    let off = (found.depth - other.depth).abs();
                    assert!(
                        off <= found.error_bound + other.error_bound,
                        "{seed}: {found:?} {other:?}"
                    );
                }
                found
            };
            let (found, back) = (depth(&pairs, [a, b]), depth(&back, [b, a]));
            assert_eq!(found, back.mirrored(), "{seed} {accuracy:?}");
            let off = (found.depth - most).abs();
            assert!(off <= found.error_bound + 1e-12, "{seed} {accuracy:?}: {found:?} {most}");
            assert!(found.error_bound <= 1e-5, "{seed} {accuracy:?}: {found:?}");
        }
        counts[kind] += usize::from(pairs.len() > 1);
    }
    assert!(counts.iter().all(|&count| count > 5) && of_hulls > 10, "{counts:?} {of_hulls}");
    assert!(tight[..3].iter().all(|&count| count > 20) && tight[3] > 3, "{tight:?}");
}

#[test]
fn what_touches_in_no_part_that_is_known_has_no_depth() {
    let found = crate::mesh::deepest(&[], |_, _| None);
    assert_eq!(found.map(|(pair, _)| pair), Err(Reason::WithinRounding));
}
