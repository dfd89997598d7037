//! Meshes as surfaces: the front of their triangles, and no edges inside of them.

use super::patches::grid;
use super::scenes::Draw;
use super::{PosedSupport, answer_of};
use dcd_geom::glam::{DQuat, DVec3};
use dcd_geom::{Pose, Shape, SupportMap};
use dcd_gjk::query::{ManifoldOptions, MeasureAt, MeshEdges, MeshSides};
use dcd_gjk::{Accuracy, ManifoldSet, Manifolds, Verdict, certified};

const ACTIVE: ManifoldOptions =
    ManifoldOptions { mesh_sides: MeshSides::Both, mesh_edges: MeshEdges::Active };

fn with(options: ManifoldOptions, a: &PosedSupport, b: &PosedSupport) -> ManifoldSet {
    answer_of(&Manifolds { options }, a, b)
}

fn touch(a: &PosedSupport, b: &PosedSupport) -> bool {
    certified::overlap_of(a.placed(), b.placed()).0 == Verdict::Touching(())
}

/// Squares of that width round the origin, at heights by place.
fn ground(width: f64, height: impl Fn(f64, f64) -> f64) -> Shape {
    let (vertices, triangles) = grid(12, |i, j| {
        let [x, y] = [i - 6.0, j - 6.0].map(|k| k * width);
        DVec3::new(x, y, height(x, y))
    });
    Shape::mesh(vertices, triangles).unwrap()
}

/// What slides and rolls, with its position.
fn bodies() -> Vec<(Shape, DQuat)> {
    let cube = Shape::cuboid(DVec3::new(0.4, 0.3, 0.2)).unwrap();
    let tip = DQuat::from_rotation_arc(DVec3::ONE.normalize(), DVec3::Z);
    vec![
        (Shape::sphere(0.3).unwrap(), DQuat::IDENTITY),
        (cube.clone(), DQuat::IDENTITY),
        (cube.clone(), DQuat::from_rotation_y(0.3)),
        (cube, tip),
        (Shape::capsule(0.3, 0.2).unwrap(), DQuat::from_rotation_y(1.2)),
        (Shape::cylinder(0.3, 0.2).unwrap(), DQuat::from_rotation_x(0.4)),
    ]
}

/// How far below its middle the lowest point of a body is.
fn lowest(shape: &Shape, turn: DQuat) -> f64 {
    let down = turn.inverse() * DVec3::NEG_Z;
    shape.support(down).point.dot(down) + shape.radius()
}

#[test]
fn what_slides_and_rolls_over_a_flat_floor_of_triangles_has_its_normal_everywhere() {
    let mut draw = Draw(51);
    let mut caught = 0;
    for width in [0.07, 0.3, 2.0] {
        let floor = PosedSupport::at(&ground(width, |_, _| 0.0), DVec3::ZERO);
        for (shape, tilt) in bodies() {
            for step in 0..40 {
                // Along the edges, and across them.
                let x = 0.25 * width * f64::from(step % 20) / 5.0;
                let y = if step < 20 { 0.0 } else { draw.unit() * width };
                let turn = DQuat::from_rotation_z(0.1 * f64::from(step)) * tilt;
                let deep = 1e-3 + 0.009 * draw.unit().abs();
                let place = DVec3::new(x, y, lowest(&shape, turn) - deep);
                let body = PosedSupport::new(shape.clone(), turn, place);
                let what = format!("width {width}, {body:?}");
                let found = with(ACTIVE, &floor, &body);
                let [manifold] = &found[..] else { panic!("{what}: {found:?}") };
                assert!(manifold.normal.distance(DVec3::Z) < 1e-3, "{what}: {found:?}");
                let depth = manifold.points()[0].depth;
                assert!(depth <= deep + manifold.error_bound + 1e-9, "{what}: {found:?}");
                assert!(depth >= deep - manifold.error_bound - 1e-9, "{what}: {found:?}");
                let back = with(ACTIVE, &body, &floor);
                assert_eq!((back.len(), back[0].normal), (1, -manifold.normal), "{what}");
                let as_is = answer_of(&Manifolds::default(), &floor, &body);
                caught += usize::from(as_is.iter().any(|m| m.normal.distance(DVec3::Z) > 1e-3));
            }
        }
    }
    assert!(caught > 10, "{caught}: the edges catch nothing even without the option");
}

/// All ways to take a mesh as a surface.
fn all_options() -> impl Iterator<Item = ManifoldOptions> {
    [MeshSides::Both, MeshSides::Front, MeshSides::Outward].into_iter().flat_map(|mesh_sides| {
        [MeshEdges::All, MeshEdges::Active]
            .map(|mesh_edges| ManifoldOptions { mesh_sides, mesh_edges })
    })
}

#[test]
fn what_rests_on_a_floor_however_that_is_turned_is_pushed_up_and_no_farther_than_it_is_deep() {
    let mut draw = Draw(53);
    // Four squares, on whose inner edges something rests.
    let (vertices, triangles) = grid(2, |i, j| DVec3::new(i - 1.0, j, 0.0));
    let floor = Shape::mesh(vertices, triangles).unwrap();
    let cube = Shape::cuboid(DVec3::splat(0.2)).unwrap();
    let rod = Shape::cuboid(DVec3::new(0.01, 0.01, 0.3)).unwrap();
    for step in 0..600 {
        let turn = match step {
            0 => DQuat::from_axis_angle(
                DVec3::new(0.24400851542459806, 0.33577557550270887, 0.9097882211240746),
                2.462157434520969,
            ),
            _ => DQuat::from_scaled_axis(draw.vector() * 3.0).normalize(),
        };
        // A cube that hardly reaches over the edge, and a rod that leans and pierces the floor near it.
        let (shape, tilt, deep) = match step % 3 {
            2 => (&rod, DQuat::from_rotation_y(0.6 * draw.unit()), 0.02 * draw.unit().abs()),
            _ => (&cube, DQuat::IDENTITY, [0.01, 0.0005][step as usize % 2]),
        };
        let across = if step == 0 { -0.195 } else { 0.2 * draw.unit() };
        let place = DVec3::new(across, 0.1 + 0.3, lowest(shape, tilt) - deep);
        let floor = PosedSupport::new(floor.clone(), turn, DVec3::ZERO);
        let body = PosedSupport::new(shape.clone(), turn * tilt, turn * place);
        for options in all_options().filter(|options| options.mesh_edges == MeshEdges::Active) {
            if step % 3 == 2 && options.mesh_sides == MeshSides::Both {
                // From either side: a rod may be pulled through.
                continue;
            }
            let found = with(options, &floor, &body);
            let what = format!("{step} {options:?}, {body:?}: {found:?}");
            assert!(!found.is_empty(), "{what}");
            for manifold in &found {
                assert!(manifold.normal.distance(turn * DVec3::Z) < 1e-3, "{what}");
                let most = deep + manifold.error_bound + 1e-9;
                assert!(manifold.points()[0].depth <= most, "{what}");
            }
            let depth = found[0].points()[0].depth;
            assert!(depth >= deep - found[0].error_bound - 1e-9, "{what}");
        }
    }
}

#[test]
fn no_option_changes_what_a_half_space_and_a_mesh_have_but_for_what_a_front_has_behind() {
    let mut draw = Draw(54);
    let (mut kept, mut dropped) = (0, 0);
    for k in 0..300 {
        let rough = if k % 3 == 0 { 0.0 } else { 0.5 };
        let (vertices, triangles) = match k % 2 {
            0 => grid(1 + k / 2 % 3, |i, j| {
                DVec3::new(i, j, rough * (13.7 * i + 7.1 * j + f64::from(k)).sin())
            }),
            _ => (vec![draw.vector(), draw.vector(), draw.vector()], vec![[0, 1, 2]]),
        };
        let turn = match k % 4 {
            0 => DQuat::IDENTITY,
            _ => DQuat::from_scaled_axis(draw.vector() * 3.0).normalize(),
        };
        let mesh = Shape::mesh(vertices, triangles).unwrap();
        let ground = Shape::half_space(DVec3::Z, 0.0).unwrap();
        let mesh = PosedSupport::new(mesh, turn, DVec3::Z * 0.3 * draw.unit());
        let ground = PosedSupport::at(&ground, DVec3::ZERO);
        if !touch(&mesh, &ground) {
            continue;
        }
        for options in all_options() {
            let found = with(options, &mesh, &ground);
            let back = with(options, &ground, &mesh);
            assert_eq!(found.len(), back.len(), "{k} {options:?}");
            if options.mesh_sides == MeshSides::Front && found.is_empty() {
                dropped += 1;
                continue;
            }
            kept += 1;
            let what = format!("{k} {options:?}: {found:?}");
            assert!(found[0].normal.distance(DVec3::NEG_Z) < 1e-12, "{what}");
            assert!(found[0].points()[0].depth.is_finite(), "{what}");
            if options.mesh_sides != MeshSides::Front {
                let as_is = answer_of(&Manifolds::default(), &mesh, &ground);
                let due = as_is[0].points()[0].depth;
                let bound = found[0].error_bound + as_is[0].error_bound;
                assert!((found[0].points()[0].depth - due).abs() <= bound, "{what} {due}");
            }
        }
    }
    assert!(kept > 300 && dropped > 5, "{kept} {dropped}");
}

#[test]
fn what_touches_the_sharp_rim_of_a_solid_from_outside_is_in_front_of_it() {
    const SIDES: u32 = 7;
    let mut draw = Draw(55);
    for round in 0..400 {
        // A flat cone: its faces meet at some ten degrees.
        let height = [0.1, 0.3, 1.0][round % 3];
        let at = |k: u32| {
            let angle = std::f64::consts::TAU * f64::from(k % SIDES) / f64::from(SIDES);
            DVec3::new(angle.cos(), angle.sin(), 0.0)
        };
        let mut vertices: Vec<DVec3> = (0..SIDES).map(at).collect();
        vertices.extend([DVec3::Z * height, DVec3::ZERO]);
        let faces = |k: u32| {
            let next = (k + 1) % SIDES;
            [[k, next, SIDES], [next, k, SIDES + 1]]
        };
        let solid = Shape::mesh(vertices, (0..SIDES).flat_map(faces).collect()).unwrap();
        let solid = PosedSupport::at(&solid, DVec3::ZERO);
        let body = Shape::capsule(0.6, 0.05).unwrap();
        let turn = DQuat::from_scaled_axis(draw.vector() * 3.0).normalize();
        // Beyond the rim, from where it is brought to touch.
        let away = DVec3::new(draw.unit(), draw.unit(), 0.1 * draw.unit()).normalize();
        let (mut apart, mut touching) = (3.0, 0.0);
        for _ in 0..60 {
            let middle = 0.5 * (apart + touching);
            let body = PosedSupport::new(body.clone(), turn, away * middle);
            if touch(&solid, &body) { touching = middle } else { apart = middle }
        }
        let body = PosedSupport::new(body.clone(), turn, away * (touching - 1e-6));
        for options in all_options() {
            let found = with(options, &solid, &body);
            let what = format!("{round} {options:?}: {body:?} {found:?}");
            assert!(!found.is_empty(), "{what}");
        }
    }
}

#[test]
fn over_a_ridge_the_ridge_has_its_own_normal() {
    let sphere = Shape::sphere(0.5).unwrap();
    for slope in [0.05, 0.5, 2.0] {
        let ridge = PosedSupport::at(&ground(0.5, |x, _| -slope * x.abs()), DVec3::ZERO);
        let steepest = slope.atan();
        for step in -9..=9 {
            // Round the ridge, from the normal of one side to that of the other.
            let angle = steepest * 0.98 * f64::from(step) / 9.0;
            let normal = DVec3::new(angle.sin(), 0.0, angle.cos());
            let place = normal * 0.49 + DVec3::Y * 0.13;
            let body = PosedSupport::at(&sphere, place);
            let found = with(ACTIVE, &ridge, &body);
            let what = format!("slope {slope}, angle {angle}: {found:?}");
            assert_eq!(found.len(), 1, "{what}");
            assert!(found[0].normal.distance(normal) < 1e-9, "{what}");
            assert!((found[0].points()[0].depth - 0.01).abs() < 1e-9, "{what}");
        }
        // A box that balances on it, which touches both sides along the edge.
        let cube = Shape::cuboid(DVec3::splat(0.4)).unwrap();
        let body = PosedSupport::at(&cube, DVec3::new(0.1, 0.13, 0.39));
        let found = with(ACTIVE, &ridge, &body);
        assert!(found[0].normal.distance(DVec3::Z) < 1e-9, "{found:?}");
        assert!((found[0].points()[0].depth - 0.01).abs() < 1e-9, "{found:?}");
    }
}

#[test]
fn a_fold_has_the_normals_of_its_faces() {
    let sphere = Shape::sphere(0.3).unwrap();
    let fold = PosedSupport::at(&ground(0.4, |x, _| 0.5 * x.abs()), DVec3::ZERO);
    let height = 0.29 * 1.25f64.sqrt();
    let body = PosedSupport::at(&sphere, DVec3::new(0.0, 0.07, height));
    let found = with(ACTIVE, &fold, &body);
    assert_eq!(found.len(), 2, "{found:?}");
    for manifold in &found {
        let face = DVec3::new(0.5 * manifold.normal.x.signum(), 0.0, 1.0).normalize();
        assert!(manifold.normal.distance(face) < 1e-9, "{found:?}");
    }
}

#[test]
fn a_front_alone_ignores_what_is_behind_and_outward_pushes_it_out() {
    let sides = |mesh_sides| ManifoldOptions { mesh_sides, ..ManifoldOptions::default() };
    let floor = PosedSupport::at(&ground(0.4, |_, _| 0.0), DVec3::ZERO);
    let cube = Shape::cuboid(DVec3::splat(0.2)).unwrap();
    let sphere = Shape::sphere(0.2).unwrap();
    for shape in [cube, sphere] {
        for place in [DVec3::new(0.1, 0.17, 0.0), DVec3::new(0.0, 0.0, 0.0)] {
            let above = PosedSupport::at(&shape, place + DVec3::Z * 0.19);
            let below = PosedSupport::at(&shape, place - DVec3::Z * 0.19);
            for options in [MeshSides::Front, MeshSides::Outward].map(sides) {
                let found = with(options, &floor, &above);
                let as_is = answer_of(&Manifolds::default(), &floor, &above);
                assert_eq!((found.len(), found[0].points()), (1, as_is[0].points()), "{options:?}");
                assert!(found[0].normal.distance(DVec3::Z) < 1e-12, "{found:?}");
            }
            let both = answer_of(&Manifolds::default(), &floor, &below);
            assert!((both[0].normal + DVec3::Z).length() < 1e-12, "{both:?}");
            assert!(with(sides(MeshSides::Front), &floor, &below).is_empty());
            let pushed = with(sides(MeshSides::Outward), &floor, &below);
            assert!((pushed[0].normal - DVec3::Z).length() < 1e-12, "{pushed:?}");
            let deepest = pushed[0].points()[0];
            let bound = pushed[0].error_bound + 1e-9;
            assert!((deepest.depth - 0.39).abs() <= bound, "{pushed:?}");
            let back = with(sides(MeshSides::Outward), &below, &floor);
            assert_eq!((back.len(), back[0].normal), (pushed.len(), -pushed[0].normal));
        }
    }
}

#[test]
fn two_meshes_and_two_compounds_touch_as_they_are() {
    let mut draw = Draw(56);
    let mut counts = [0; 2];
    for k in 0..60 {
        let shapes = [0; 2].map(|_| match k % 2 {
            0 => {
                let (x, y) = (draw.unit(), draw.unit());
                ground(0.2, |i, j| 0.2 * (5.0 * i + x).sin() * (4.0 * j + y).cos())
            }
            _ => {
                let parts = (0..3).map(|_| {
                    let turn = DQuat::from_scaled_axis(draw.vector() * 3.0).normalize();
                    let pose = Pose::new(turn, draw.vector() * 0.3).unwrap();
                    (Shape::cuboid(DVec3::splat(0.2)).unwrap(), pose)
                });
                Shape::compound(parts.collect()).unwrap()
            }
        });
        let [a, b] = shapes.map(|shape| {
            let turn = DQuat::from_scaled_axis(draw.vector() * 3.0).normalize();
            PosedSupport::new(shape, turn, draw.vector() * 0.4)
        });
        if !touch(&a, &b) {
            continue;
        }
        for accuracy in [Accuracy::F32, Accuracy::F64, Accuracy::Certified] {
            let of = |options| {
                let solver = Manifolds { options };
                let answer =
                    solver.measure_at(accuracy, a.placed(), b.placed(), &mut Default::default());
                let Verdict::Touching(found) = answer else { panic!("{k}: {answer:?}") };
                found
            };
            let as_is = of(ManifoldOptions::default());
            for options in all_options() {
                assert_eq!(of(options), as_is, "{k} {options:?} {accuracy:?}");
            }
        }
        counts[k % 2] += 1;
    }
    assert!(counts.iter().all(|&count| count > 5), "{counts:?}");
}
