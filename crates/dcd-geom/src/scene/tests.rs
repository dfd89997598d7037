//! Scenes: what is refused, what changes, what stays.

use super::*;
use crate::SupportMap;
use glam::DVec3;

fn sphere() -> Shape {
    Shape::sphere(1.0).unwrap()
}

#[test]
fn lengths_that_differ_are_refused_with_both() {
    let refused = Scene::one_each(vec![sphere()], vec![]).unwrap_err();
    assert_eq!(refused, SceneError::LengthsDiffer { shapes: 1, poses: 0 });
}

#[test]
fn an_unknown_shape_is_refused_with_the_object() {
    let object = |shape| Object::new(shape, Pose::IDENTITY);
    let refused = Scene::new(vec![sphere()], [object(0), object(7)]).unwrap_err();
    assert_eq!(refused, SceneError::NoSuchShape { object: 1, shape: 7, shapes: 1 });
}

#[test]
fn an_object_out_of_range_is_refused_and_set_pose_leaves_the_scene_alone() {
    let far = Pose::from_translation(DVec3::new(0.0, 1e38, 0.0)).unwrap();
    let refused = Scene::one_each(vec![sphere()], vec![far]).unwrap_err();
    assert!(matches!(refused, SceneError::OutOfRange { object: 0, reach } if reach >= 1e38));
    let mut scene = Scene::one_each(vec![sphere()], vec![Pose::IDENTITY]).unwrap();
    assert!(scene.set_pose(0, far).is_err());
    assert_eq!(scene.poses()[0], Pose::IDENTITY);
    let missing = SceneError::NoSuchObject { object: 1, objects: 1 };
    assert_eq!(scene.set_pose(1, Pose::IDENTITY), Err(missing));
}

#[test]
fn a_count_past_u32_is_refused() {
    assert!(check_count("objects", u32::MAX as usize).is_ok());
    let count = u32::MAX as usize + 1;
    assert_eq!(check_count("objects", count), Err(SceneError::TooMany { what: "objects", count }));
}

#[test]
fn an_empty_scene_is_legal() {
    assert!(Scene::one_each(vec![], vec![]).unwrap().is_empty());
}

#[test]
fn filters_must_agree_both_ways() {
    let robot = Filter { groups: 1, mask: 2 };
    let world = Filter { groups: 2, mask: 1 };
    assert!(robot.allows(world) && world.allows(robot));
    assert!(!robot.allows(robot) && !world.allows(Filter { groups: 1, mask: 0 }));
}

/// Four spheres in a row, the second and the last static.
fn row() -> Scene {
    let at = |x: f64| Object::new(0, Pose::from_translation(DVec3::X * x).unwrap());
    Scene::new(vec![sphere()], [at(0.0), at(1.0).fixed(), at(2.0), at(3.0).fixed()]).unwrap()
}

#[test]
fn a_slot_is_taken_again_and_the_old_handle_is_not_honoured() {
    let mut scene = row();
    let second = scene.handle(1).unwrap();
    scene.remove(second).unwrap();
    assert_eq!((scene.len(), scene.object_count(), scene.static_count()), (4, 3, 1));
    assert_eq!(scene.aabb(1), Aabb::EMPTY);
    assert_eq!((scene.motion(1), scene.handle(1)), (None, None));
    let missing = SceneError::NoSuchObject { object: 1, objects: 4 };
    assert_eq!(scene.set_pose(1, Pose::IDENTITY), Err(missing));

    let newcomer = scene.insert(Object::new(0, Pose::IDENTITY)).unwrap();
    assert_eq!(newcomer, Handle { index: 1, generation: 1 });
    assert_eq!(scene.index_of(newcomer), Ok(1));
    let gone = Err(SceneError::StaleHandle { handle: second });
    assert_eq!(scene.remove(second), gone);
    assert_eq!(scene.index_of(second).map(|_| ()), gone);
    assert_eq!(scene.insert(Object::new(0, Pose::IDENTITY)).unwrap().index, 4);
    assert_eq!((scene.object_count(), scene.static_count()), (5, 1));
}

#[test]
fn an_object_that_is_refused_takes_no_slot() {
    let mut scene = row();
    scene.remove(scene.handle(2).unwrap()).unwrap();
    let refused = scene.insert(Object::new(9, Pose::IDENTITY)).unwrap_err();
    assert_eq!(refused, SceneError::NoSuchShape { object: 2, shape: 9, shapes: 1 });
    assert_eq!(scene.insert(Object::new(0, Pose::IDENTITY)).unwrap().index, 2);
}

#[test]
fn two_static_objects_and_free_slots_may_not_pair() {
    let mut scene = row();
    assert!(scene.allows(0, 1) && scene.allows(0, 2) && !scene.allows(1, 3));
    scene.remove(scene.handle(0).unwrap()).unwrap();
    assert!(!scene.allows(0, 1) && !scene.allows(0, 2) && scene.allows(1, 2));
}

#[test]
fn an_ignored_pair_may_not_pair_until_it_is_unignored_or_an_object_leaves() {
    let mut scene = row();
    assert!(!scene.filters_movers());
    scene.ignore_pair(2, 0).unwrap();
    assert!(scene.filters_movers() && !scene.allows(0, 2) && scene.allows(0, 1));
    scene.unignore_pair(0, 2).unwrap();
    assert!(!scene.filters_movers() && scene.allows(0, 2));
    scene.ignore_pair(0, 2).unwrap();
    scene.remove(scene.handle(2).unwrap()).unwrap();
    scene.insert(Object::new(0, Pose::IDENTITY)).unwrap();
    assert!(scene.allows(0, 2));
    assert_eq!(scene.ignore_pair(0, 0), Err(SceneError::SelfPair { object: 0 }));
    let missing = SceneError::NoSuchObject { object: 7, objects: 4 };
    assert_eq!(scene.ignore_pair(0, 7), Err(missing));
}

#[test]
fn an_object_is_in_the_last_group_that_names_it_whichever_pairs_are_taken_back() {
    let mut scene = row();
    scene.ignore_among(&[0, 1, 2]).unwrap();
    scene.unignore_pair(0, 1).unwrap();
    assert!(scene.allows(0, 1) && !scene.allows(0, 2) && !scene.allows(1, 2));
    scene.ignore_among(&[2, 3]).unwrap();
    assert!(scene.allows(0, 2) && scene.allows(1, 2) && !scene.allows(2, 3));
    assert!(scene.ignored_pairs().eq([crate::Pair::new(2, 3)]));
    // A new group ignores all of its pairs.
    scene.ignore_among(&[0, 1]).unwrap();
    assert!(!scene.allows(0, 1) && !scene.allows(2, 3));
}

#[test]
fn a_revision_changes_with_what_it_marks_and_with_nothing_else() {
    let mut scene = row();
    let copy = scene.clone();
    assert_eq!((copy.layout(), copy.statics()), (scene.layout(), scene.statics()));
    scene.set_pose(0, Pose::IDENTITY).unwrap();
    assert_eq!((copy.layout(), copy.statics()), (scene.layout(), scene.statics()));
    let before = scene.statics();
    let same = scene.poses().to_vec();
    scene.set_poses(&same).unwrap();
    assert_eq!(before, scene.statics());
    // Equal numbers are not the same bits.
    let other_zeros = same.iter().map(|pose| {
        let place = pose.translation().to_array().map(|x| if x == 0.0 { -x } else { x });
        pose.with_translation(DVec3::from_array(place)).unwrap()
    });
    scene.set_poses(&other_zeros.collect::<Vec<_>>()).unwrap();
    assert_ne!(before, scene.statics());
    scene.set_pose(1, Pose::IDENTITY).unwrap();
    assert_eq!(copy.layout(), scene.layout());
    assert_ne!(copy.statics(), scene.statics());
    let statics = scene.statics();
    scene.insert(Object::new(0, Pose::IDENTITY)).unwrap();
    assert_ne!(copy.layout(), scene.layout());
    assert_eq!(statics, scene.statics());
    scene.remove(scene.handle(3).unwrap()).unwrap();
    assert_ne!(statics, scene.statics());
    assert_ne!(row().layout(), row().layout());
}

#[test]
fn shapes_can_be_added_and_objects_keep_theirs() {
    let mut scene = row();
    let layout = scene.layout();
    let added = scene.add_shapes([Shape::cuboid(DVec3::ONE).unwrap(), sphere()]).unwrap();
    assert_eq!(added, 1..3);
    assert_ne!(scene.layout(), layout);
    let handle = scene.insert(Object::new(added.start, Pose::IDENTITY)).unwrap();
    assert_eq!(scene.shape(handle.index as usize).as_polytope().unwrap().vertices().len(), 8);
    assert_eq!(scene.shape(0).as_polytope().unwrap().vertices().len(), 1);
}

#[test]
fn who_derives_something_from_the_shapes_learns_which_are_new() {
    let mut scene = row();
    let nothing = Scene::default();
    assert_eq!(scene.shapes_since(nothing.shape_revision()).map(<[Shape]>::len), Some(1));
    let mut known = Vec::new();
    for count in 1..12 {
        known.push((scene.shape_revision(), count));
        scene.add_shapes([sphere()]).unwrap();
        let mut other = scene.clone();
        other.add_shapes([sphere()]).unwrap();
        assert_eq!(other.shapes_since(scene.shape_revision()).map(<[Shape]>::len), Some(1));
        assert!(scene.shapes_since(other.shape_revision()).is_none());
    }
    let new = |revision| scene.shapes_since(revision).map(<[Shape]>::len);
    assert_eq!(new(scene.shape_revision()), Some(0));
    assert!(known[8..].iter().all(|&(revision, count)| new(revision) == Some(12 - count)));
    // So far behind that all has to be derived anew.
    assert_eq!(new(known[0].0), None);
    assert!(scene.swept(1.0).unwrap().shapes_since(scene.shape_revision()).is_none());
}

#[test]
fn a_swept_scene_has_grown_shapes_in_the_same_slots_and_follows_the_poses() {
    let at = |x: f64| Pose::from_translation(DVec3::X * x).unwrap();
    let objects = [Object::new(0, at(0.0)), Object::new(0, at(5.0)).fixed()];
    let mut scene = Scene::new(vec![sphere()], objects).unwrap();
    scene.remove(scene.handle(0).unwrap()).unwrap();
    let mut swept = scene.swept(0.5).unwrap();
    assert_eq!((swept.shape(1).radius(), swept.motion(0)), (1.5, None));
    assert!(swept.layout() != scene.layout() && swept.len() == scene.len());
    let statics = swept.statics();
    assert!(swept.follow(&scene) && swept.statics() == statics);
    scene.set_pose(1, at(6.0)).unwrap();
    assert!(swept.follow(&scene) && swept.statics() != statics);
    assert_eq!(swept.poses(), scene.poses());
    scene.set_pose(1, at(0.9 * Aabb::LIMIT)).unwrap();
    assert!(swept.follow(&scene) && scene.swept(0.2 * Aabb::LIMIT).is_none());
    assert!(scene.swept(-1.0).is_none() && scene.swept(f64::NAN).is_none());
}

#[test]
fn objects_are_named_by_handle_or_by_index_and_a_stale_handle_is_refused() {
    let mut scene = row();
    let first = scene.handle(0).unwrap();
    let moved = Pose::from_translation(DVec3::X * 9.0).unwrap();
    scene.set_pose(first, moved).unwrap();
    assert_eq!(scene.poses()[0], moved);
    scene.remove(first).unwrap();
    let gone = Err(SceneError::StaleHandle { handle: first });
    assert_eq!(scene.set_pose(first, moved), gone);
    assert_eq!(scene.set_filter(first, Filter::ALL), gone);
    assert_eq!(scene.set_motion(first, Motion::Static), gone);
    assert_eq!(scene.set_shape(first, 0), gone);
    assert_eq!(scene.set_user_data(first, 7), gone);
    let missing = Err(SceneError::NoSuchObject { object: 0, objects: 4 });
    assert_eq!(scene.set_pose(0, moved), missing);
}

#[test]
fn all_poses_change_at_once_or_none_does() {
    let mut scene = row();
    scene.remove(scene.handle(2).unwrap()).unwrap();
    let (before, statics) = (scene.poses().to_vec(), scene.statics());
    let differ = SceneError::SlotsDiffer { given: 3, slots: 4 };
    assert_eq!(scene.set_poses(&before[..3]), Err(differ));
    let far = Pose::from_translation(DVec3::X * 1e38).unwrap();
    let mut poses = before.clone();
    (poses[0], poses[3]) = (Pose::IDENTITY, far);
    assert!(matches!(scene.set_poses(&poses), Err(SceneError::OutOfRange { object: 3, .. })));
    assert_eq!((scene.poses(), scene.statics()), (&before[..], statics));

    // A free slot's pose is not read; static objects that stay where they are keep their revision.
    (poses[0], poses[2], poses[3]) = (Pose::from_translation(DVec3::Y).unwrap(), far, before[3]);
    scene.set_poses(&poses).unwrap();
    assert_eq!((scene.poses()[0], scene.statics()), (poses[0], statics));
    poses[1] = Pose::IDENTITY;
    poses[3] = Pose::IDENTITY;
    scene.set_poses(&poses).unwrap();
    assert_ne!(scene.statics(), statics);
}

#[test]
fn filter_motion_and_shape_change_without_a_new_handle() {
    let mut scene = row();
    scene.add_shapes([Shape::cuboid(DVec3::ONE).unwrap()]).unwrap();
    let handle = scene.handle(0).unwrap();
    scene.set_filter(handle, Filter { groups: 1, mask: 0 }).unwrap();
    assert!(scene.filters_movers() && !scene.allows(0, 1));
    scene.set_filter(handle, Filter::ALL).unwrap();
    assert!(scene.allows(0, 1));

    let (layout, statics) = (scene.layout(), scene.statics());
    scene.set_motion(handle, Motion::Moving).unwrap();
    assert_eq!((scene.layout(), scene.statics()), (layout, statics));
    scene.set_motion(handle, Motion::Static).unwrap();
    assert!(scene.layout() != layout && scene.statics() != statics);
    assert_eq!((scene.static_count(), scene.allows(0, 1), scene.allows(0, 2)), (3, false, true));

    let (layout, statics) = (scene.layout(), scene.statics());
    scene.set_shape(handle, 1).unwrap();
    assert!(scene.layout() != layout && scene.statics() != statics);
    assert_eq!(scene.aabb(0), scene.shapes()[1].aabb(&scene.poses()[0]));
    let missing = SceneError::NoSuchShape { object: 0, shape: 5, shapes: 2 };
    assert_eq!(scene.set_shape(handle, 5), Err(missing));
    assert_eq!(scene.handle(0), Some(handle));
}

#[test]
fn an_object_carries_its_users_number_until_it_is_changed() {
    let mut scene = row();
    let handle = scene.insert(Object::new(0, Pose::IDENTITY).with_user_data(41)).unwrap();
    assert_eq!((scene.user_data()[0], scene.user_data()[4]), (0, 41));
    scene.set_user_data(handle, 42).unwrap();
    assert_eq!(scene.user_data()[4], 42);
    scene.remove(handle).unwrap();
    scene.insert(Object::new(0, Pose::IDENTITY)).unwrap();
    assert_eq!(scene.user_data()[4], 0);
}
