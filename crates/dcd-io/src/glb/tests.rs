use super::*;
use crate::{MeshFormat, MeshOptions, TriangleMesh, UpAxis};
use dcd_geom::{Object, Shape};

fn at(x: f64, z: f64) -> Pose {
    let turn = DQuat::from_rotation_z(x);
    Pose::new(turn, DVec3::new(x, 0.0, z)).unwrap()
}

fn scene() -> Scene {
    let shapes = vec![
        Shape::cuboid(DVec3::ONE).unwrap(),
        Shape::half_space(DVec3::Z, 0.0).unwrap(),
        Shape::cylinder(1.0, 0.5).unwrap(),
    ];
    let ground = Object { motion: Motion::Static, ..Object::new(1, Pose::IDENTITY) };
    let objects = [Object::new(0, at(0.0, 1.0)), ground, Object::new(2, at(5.0, 3.0))];
    Scene::new(shapes, objects).unwrap()
}

fn written(glb: &GlbScene<'_>) -> Vec<u8> {
    let mut bytes = Vec::new();
    glb.write(&mut bytes).unwrap();
    bytes
}

/// The document, as the library checks it.
fn document(bytes: &[u8]) -> gltf::Gltf {
    gltf::Gltf::from_slice(bytes).unwrap()
}

#[test]
fn what_is_written_is_read_again_as_the_same_triangles() {
    let scene = scene();
    let bytes = written(&GlbScene::new(&scene));
    let options = MeshOptions { up_axis: UpAxis::File, ..MeshOptions::default() };
    let mesh = TriangleMesh::read(&bytes, MeshFormat::Gltf, &options).unwrap();
    // A box, a square, a prism of 32 sides: two ends of 30 triangles and 64 of the sides.
    assert_eq!(mesh.triangles.len(), 12 + 2 + 2 * 30 + 64);
    // The reader turns glTF's y up back to z up: the ground lies below everything.
    let lowest = mesh.vertices.iter().map(|v| v.z).fold(f64::INFINITY, f64::min);
    let highest = mesh.vertices.iter().map(|v| v.z).fold(f64::NEG_INFINITY, f64::max);
    assert!(lowest.abs() < 1e-6 && (highest - 4.0).abs() < 1e-6, "{lowest} {highest}");
}

#[test]
fn each_look_has_a_material_and_a_still_scene_no_animation() {
    let scene = scene();
    let mut glb = GlbScene::new(&scene);
    let contact = GlbContact { point: DVec3::ZERO, normal: DVec3::Z };
    glb.frame(0.0, scene.poses(), [0, 1], vec![contact]).unwrap();
    let document = document(&written(&glb));
    let names: Vec<_> = document.materials().filter_map(|m| m.name().map(str::to_owned)).collect();
    assert_eq!(names, ["touching", "apart", "contact"]);
    assert_eq!(document.animations().count(), 0);
}

#[test]
fn frames_move_what_moves_and_show_one_look_at_a_time() {
    let scene = scene();
    let mut glb = GlbScene::new(&scene);
    for k in 0..3 {
        let mut poses = scene.poses().to_vec();
        poses[0] = at(f64::from(k), 1.0);
        let contact = GlbContact { point: DVec3::X, normal: DVec3::Z };
        let touching = if k == 1 { vec![0] } else { vec![] };
        glb.frame(f64::from(k), &poses, touching, vec![contact]).unwrap();
    }
    let bytes = written(&glb);
    let document = document(&bytes);
    let animation = document.animations().next().unwrap();
    let (mut scales, mut places, mut turns) = (0, 0, 0);
    for channel in animation.channels() {
        assert_eq!(channel.sampler().input().count(), 3);
        match channel.target().property() {
            gltf::animation::Property::Scale => scales += 1,
            gltf::animation::Property::Translation => places += 1,
            gltf::animation::Property::Rotation => turns += 1,
            other => panic!("{other:?}"),
        }
    }
    // Two looks of the box, and the contacts of three frames.
    assert_eq!((scales, places, turns), (5, 1, 1));
}

#[test]
fn frames_that_do_not_fit_are_refused() {
    let scene = scene();
    let mut glb = GlbScene::new(&scene);
    let poses = scene.poses();
    assert!(glb.frame(0.0, &poses[1..], [], vec![]).is_err());
    assert!(glb.frame(0.0, poses, [3], vec![]).is_err());
    assert!(glb.frame(1.0, poses, [], vec![]).is_err());
    glb.frame(0.0, poses, [], vec![]).unwrap();
    assert!(glb.frame(0.0, poses, [], vec![]).is_err());
    assert!(glb.frame(f64::NAN, poses, [], vec![]).is_err());
}

#[test]
fn an_empty_scene_is_a_file_too() {
    let scene = Scene::default();
    let document = document(&written(&GlbScene::new(&scene)));
    assert_eq!(document.nodes().count(), 1);
}

#[test]
fn objects_have_the_names_that_they_are_given_and_none_without_a_name() {
    let scene = scene();
    let names = || vec![Some("arm".to_owned()), None, Some("wall".to_owned())];
    let mut glb = GlbScene::new(&scene).named(names()).unwrap().held();
    for k in 0..2 {
        let mut poses = scene.poses().to_vec();
        poses[0] = at(f64::from(k), 1.0);
        glb.frame(f64::from(k), &poses, [], Vec::new()).unwrap();
    }
    let document = document(&written(&glb));
    let drawn: Vec<_> = document.nodes().filter_map(|n| n.name().map(str::to_owned)).collect();
    assert_eq!(drawn, ["arm", "wall", "z up"]);
    for channel in document.animations().next().unwrap().channels() {
        let interpolation = channel.sampler().interpolation();
        assert_eq!(interpolation, gltf::animation::Interpolation::Step);
    }
    assert!(GlbScene::new(&scene).named(names()[1..].to_vec()).is_err());
    let mut hole = scene.clone();
    hole.remove(hole.handle(0).unwrap()).unwrap();
    let refused = GlbScene::new(&hole).named(names()).unwrap_err().to_string();
    assert!(refused.contains("object 0"), "{refused}");
}
