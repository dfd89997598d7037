//! Queries of a scene against every object on its own, at any number of threads, and what is refused.

mod batches;
mod brackets;
mod changed;
mod crowd;
mod regions;

use crate::random::Random;
use dcd_exec::{Segments, with_threads};
use dcd_geom::glam::{DQuat, DVec3};
use dcd_geom::{Filter, Motion, Object, Pose, Scene, Shape};
use dcd_gjk::motion::{Impact, MovingShape, RigidMotion, time_of_impact};
use dcd_gjk::query::ray::{Ray, first_hit};
use dcd_gjk::{PosedShape, Verdict, certified, distance};
use dcd_pipeline::{
    Found, Impacts, ObjectHit, Par, Pipeline, QueryError, QueryFilter, RegionError, SensorChoice,
    Velocity,
};
use dcd_scenes::SceneSpec;

/// Mixed shapes; some static, some sensors, a floor, a free slot; few objects or many.
fn scene(objects: usize) -> Scene {
    let mixed =
        SceneSpec::parse("mixed").unwrap().with_objects(objects).with_seed(3).scene().unwrap();
    let mut shapes = mixed.shapes().to_vec();
    let floor = shapes.len() as u32;
    shapes.push(Shape::half_space(DVec3::Z, -3.0).unwrap());
    let corners = |k: u32| DVec3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2));
    let triangles = vec![[0, 1, 2], [1, 3, 2], [0, 4, 1], [1, 4, 5], [2, 6, 4], [2, 4, 0]];
    shapes.push(Shape::mesh((0..8).map(corners).collect(), triangles).unwrap());
    let placed = (0..mixed.len()).map(|i| {
        let object = Object::new(mixed.shape_of()[i], mixed.poses()[i]);
        let object = if i % 3 == 0 { object.fixed() } else { object };
        let object = if i % 5 == 1 { object.as_sensor() } else { object };
        object.with_filter(Filter { groups: 1 << (i % 3), mask: u32::MAX })
    });
    let extra = [floor, floor + 1].map(|shape| Object::new(shape, Pose::IDENTITY).fixed());
    let mut scene = Scene::new(shapes, placed.chain(extra)).unwrap();
    let gone = scene.handle(4).unwrap();
    scene.remove(gone).unwrap();
    scene
}

/// How far the scene's objects are from the origin.
fn extent(scene: &Scene) -> f64 {
    scene.poses().iter().map(|pose| pose.translation().length()).fold(1.0, f64::max)
}

fn rays(scene: &Scene, count: usize) -> Vec<Ray> {
    let (mut random, size) = (Random::seeded(17), extent(scene));
    (0..count)
        .map(|k| {
            let target = scene.poses()[k % scene.len()].translation();
            let from = random.vector() * size * if k % 4 == 0 { 0.5 } else { 3.0 };
            let axis = [DVec3::X, DVec3::Y, -DVec3::Z][k % 3];
            match k % 4 {
                1 => Ray::endless(target - axis * size, axis),
                2 => Ray::new(from, target - from, 0.8),
                _ => Ray::endless(from, target - from),
            }
            .unwrap()
        })
        .collect()
}

fn sees(scene: &Scene, filter: &QueryFilter<'_>, i: usize) -> bool {
    let sensor = match filter.sensors {
        SensorChoice::Solid => !scene.sensors()[i],
        SensorChoice::Sensors => scene.sensors()[i],
        SensorChoice::All => true,
    };
    scene.motion(i).is_some()
        && sensor
        && filter.filter.allows(scene.filters()[i])
        && filter.motion.is_none_or(|motion| scene.motion(i) == Some(motion))
        && filter.may.is_none_or(|may| may(i as u32))
}

fn filters() -> [QueryFilter<'static>; 4] {
    let odd = &|object: u32| !object.is_multiple_of(2);
    [
        QueryFilter::ALL,
        QueryFilter { sensors: SensorChoice::All, ..QueryFilter::ALL },
        QueryFilter {
            filter: Filter { groups: 1, mask: 3 },
            motion: Some(Motion::Moving),
            ..QueryFilter::ALL
        },
        QueryFilter { sensors: SensorChoice::Sensors, ..QueryFilter::ALL }.with_predicate(odd),
    ]
}

#[test]
fn rays_meet_what_they_meet_of_every_object_alone() {
    for objects in [9, 300] {
        let scene = scene(objects);
        let mut pipeline = Pipeline::new();
        pipeline.step(&scene, Par::Serial);
        let queries = pipeline.queries(&scene).unwrap();
        let (mut met, mut all) = (0, Vec::new());
        for (k, ray) in rays(&scene, 400).iter().enumerate() {
            for filter in &filters() {
                let mut alone: Vec<ObjectHit> = (0..scene.len())
                    .filter(|&i| sees(&scene, filter, i))
                    .filter_map(|i| {
                        let object = i as u32;
                        let hit = first_hit(ray, PosedShape::of(&scene, object))?;
                        Some(ObjectHit { object, hit })
                    })
                    .collect();
                alone.sort_by(|x, y| x.hit.t.total_cmp(&y.hit.t).then(x.object.cmp(&y.object)));
                queries.all_hits(ray, filter, &mut all);
                // Of what grazes, a box may prove the miss that the shape alone leaves open.
                alone
                    .retain(|hit| hit.hit.is_certain || all.iter().any(|x| x.object == hit.object));
                assert_eq!(queries.first_hit(ray, filter), alone.first().copied(), "ray {k}");
                let mut firsts = all.clone();
                let mut known = std::collections::BTreeSet::new();
                firsts.retain(|hit| known.insert(hit.object));
                assert_eq!(firsts, alone, "ray {k}");
                assert!(all.is_sorted_by(|x, y| x.hit.t <= y.hit.t));
                let any = queries.any_hit(ray, filter);
                assert_eq!(any.is_some(), all.iter().any(|hit| hit.hit.is_certain), "ray {k}");
                assert!(any.is_none_or(|any| all.contains(&any)));
                met += usize::from(!alone.is_empty());
            }
        }
        assert!(met > 300, "{met}");
    }
}

#[test]
fn regions_hold_what_touches_them_of_every_object_alone() {
    let scene = scene(300);
    let mut pipeline = Pipeline::new();
    pipeline.step(&scene, Par::Serial);
    let queries = pipeline.queries(&scene).unwrap();
    let (mut random, size) = (Random::seeded(29), extent(&scene));
    let (mut found, mut counts) = (Vec::new(), [0; 4]);
    for round in 0..60 {
        let filter = &filters()[round % 4];
        let centre = match round % 2 {
            0 => scene.poses()[round % scene.len()].translation(),
            _ => random.vector() * size,
        };
        let (a, b) = (centre, centre + random.vector() * size * 0.3);
        let (min, max) = (a.min(b), a.max(b));
        let corner = |k: usize| {
            let pick =
                |bit: usize, axis: usize| if k >> bit & 1 == 0 { min[axis] } else { max[axis] };
            DVec3::new(pick(0, 0), pick(1, 1), pick(2, 2))
        };
        let at = Pose::from_translation(centre).unwrap();
        let regions = [
            (Shape::sphere(0.0).unwrap(), at),
            (Shape::sphere(size * 0.2).unwrap(), at),
            (Shape::hull((0..8).map(corner).collect()).unwrap(), Pose::IDENTITY),
        ];
        for (kind, (shape, pose)) in regions.iter().enumerate() {
            match kind {
                0 => queries.at_point(centre, filter, &mut found).unwrap(),
                1 => queries.in_sphere(centre, size * 0.2, filter, &mut found).unwrap(),
                _ => queries.in_box([min, max], filter, &mut found).unwrap(),
            }
            let alone: Vec<Found> = (0..scene.len())
                .filter(|&i| sees(&scene, filter, i))
                .filter_map(|i| {
                    let other = PosedShape::of(&scene, i as u32);
                    let (verdict, _) = certified::overlap_of(PosedShape { shape, pose }, other);
                    let is_certain = verdict == Verdict::Touching(());
                    (verdict != Verdict::Apart).then_some(Found { object: i as u32, is_certain })
                })
                .collect();
            assert_eq!(found, alone, "round {round}, region {kind}");
            counts[kind] += found.len();
        }
        // A box by its planes holds at least what the box does, and nothing that is outside of one plane.
        let planes: Vec<_> = [DVec3::X, DVec3::Y, DVec3::Z]
            .into_iter()
            .flat_map(|n| [(n, n.dot(max)), (-n * 7.0, n.dot(-min) * 7.0)])
            .collect();
        let inside = found.clone();
        queries.in_planes(&planes, filter, &mut found).unwrap();
        assert!(inside.iter().all(|x| found.iter().any(|y| x.object == y.object)), "round {round}");
        for object in &found {
            let shape = scene.shape(object.object as usize);
            let aabb = shape.aabb(&scene.poses()[object.object as usize]);
            let (low, high) = (aabb.min.as_dvec3(), aabb.max.as_dvec3());
            assert!(low.cmple(max).all() && min.cmple(high).all(), "round {round} {object:?}");
        }
        counts[3] += found.len();
    }
    assert!(counts[0] >= 8 && counts[1..].iter().all(|&count| count > 50), "{counts:?}");
}

#[test]
fn the_nearest_object_is_that_of_every_object_alone() {
    for objects in [9, 300] {
        let scene = scene(objects);
        let mut pipeline = Pipeline::new();
        pipeline.step(&scene, Par::Serial);
        let queries = pipeline.queries(&scene).unwrap();
        let (mut random, size) = (Random::seeded(41), extent(&scene));
        for round in 0..100 {
            let point = random.vector() * size * [0.5, 2.0, 1e3][round % 3];
            let filter = &filters()[round % 4];
            let sphere = Shape::sphere(0.0).unwrap();
            let at = Pose::from_translation(point).unwrap();
            let alone = (0..scene.len()).filter(|&i| sees(&scene, filter, i)).map(|i| {
                let found = distance::distance(
                    PosedShape { shape: &sphere, pose: &at },
                    PosedShape::of(&scene, i as u32),
                );
                match found.0 {
                    dcd_gjk::DistanceResult::Apart(found) => (found.lower(), found.upper()),
                    _ => (0.0, 0.0),
                }
            });
            let least =
                alone.fold((f64::INFINITY, f64::INFINITY), |x, y| (x.0.min(y.0), x.1.min(y.1)));
            let found = queries.nearest(point, f64::INFINITY, filter).unwrap();
            let Some(found) = found else {
                assert_eq!(least.0, f64::INFINITY, "round {round}");
                continue;
            };
            assert!(
                found.lower <= least.1 && least.0 <= found.upper,
                "round {round}: {found:?} {least:?}"
            );
            assert!(found.lower <= found.distance && found.distance <= found.upper);
            let gap = found.point.distance(point) - found.distance;
            assert!(gap.abs() <= 1e-6 * (1.0 + point.length()), "round {round}: {found:?}");
            let near = queries.nearest(point, found.distance * 0.5, filter).unwrap();
            assert!(near.is_none() || found.distance == 0.0, "round {round}: {near:?}");
        }
    }
}

#[test]
fn a_cast_without_an_end_meets_what_a_spinning_ball_flies_through() {
    let ball = Shape::sphere(0.5).unwrap();
    let scene = Scene::one_each(vec![ball.clone()], vec![Pose::IDENTITY]).unwrap();
    let mut pipeline = Pipeline::new();
    pipeline.step(&scene, Par::Serial);
    let queries = pipeline.queries(&scene).unwrap();
    let start = Pose::from_translation(DVec3::X * -5.0).unwrap();
    for spin in [0.0, 0.5, 2.0, 1e10] {
        let at_rest = RigidMotion::at_rest(start);
        let motion = RigidMotion { linear: DVec3::X, angular: DVec3::X * spin, ..at_rest };
        let moving = MovingShape { shape: &ball, motion: &motion };
        for until in [10.0, 1e300, f64::MAX] {
            let found = queries.cast(moving, until, 1e-6, &QueryFilter::ALL).unwrap();
            let Some(Impact::Hit { free_until, t, .. }) = found.map(|found| found.impact) else {
                panic!("{spin} {until}: {found:?}")
            };
            assert!(free_until <= 4.0 && (t - 4.0).abs() < 1e-5, "{spin} {until}: {found:?}");
        }
    }
}

#[test]
fn shape_casts_stop_where_the_first_object_does() {
    let scene = scene(120);
    let mut pipeline = Pipeline::new();
    pipeline.step(&scene, Par::Serial);
    let queries = pipeline.queries(&scene).unwrap();
    let mut random = Random::seeded(53);
    let shape = Shape::cuboid(DVec3::new(0.1, 0.2, 0.3)).unwrap();
    let (mut hits, mut frees) = (0, 0);
    for (k, ray) in rays(&scene, 60).iter().enumerate() {
        let motion = RigidMotion {
            linear: ray.direction() * 0.7,
            angular: if k % 2 == 0 { DVec3::ZERO } else { random.vector() * 3.0 },
            centre: DVec3::new(0.05, 0.0, 0.0),
            ..RigidMotion::at_rest(Pose::from_translation(ray.origin()).unwrap())
        };
        let moving = MovingShape { shape: &shape, motion: &motion };
        let filter = &filters()[k % 4];
        let found = queries.cast(moving, 1.0, 1e-6, filter).unwrap();
        // Samples in time of yes or no against every object: none before the bracket.
        let free = match found.map(|found| found.impact) {
            Some(Impact::Hit { free_until, t, .. }) => {
                assert!(free_until <= t);
                hits += 1;
                free_until
            }
            Some(Impact::Undecided { free_until }) => free_until,
            Some(Impact::Free) => panic!("ray {k}: free is no impact"),
            None => {
                frees += 1;
                1.0
            }
        };
        for s in 0..=20 {
            let t = free * f64::from(s) / 20.0 * (1.0 - 1e-9);
            let pose = motion.pose_at(t).unwrap();
            for i in (0..scene.len()).filter(|&i| sees(&scene, filter, i)) {
                let here = PosedShape { shape: &shape, pose: &pose };
                let (verdict, _) = certified::overlap_of(here, PosedShape::of(&scene, i as u32));
                assert!(free == 0.0 || verdict != Verdict::Touching(()), "ray {k}: {i} at {t}");
            }
        }
        if let Some(found) = found
            && let Impact::Hit { t, .. } = found.impact
        {
            let pose = motion.pose_at(t).unwrap();
            let here = PosedShape { shape: &shape, pose: &pose };
            match distance::distance(here, PosedShape::of(&scene, found.object)).0 {
                dcd_gjk::DistanceResult::Apart(found) => assert!(found.lower() <= 1e-6),
                dcd_gjk::DistanceResult::Undecided(reason) => panic!("ray {k}: {reason:?}"),
                _ => {}
            }
        }
    }
    assert!(hits > 5 && frees > 5, "{hits} {frees}");
}

/// Small fast spheres and thin plates that turn.
fn moving_scene() -> (Scene, Vec<Velocity>) {
    let mut random = Random::seeded(71);
    let shapes = vec![
        Shape::sphere(0.05).unwrap(),
        Shape::cuboid(DVec3::new(0.5, 0.5, 0.002)).unwrap(),
        Shape::cylinder(0.1, 0.1).unwrap(),
    ];
    let (mut objects, mut velocities) = (Vec::new(), Vec::new());
    for k in 0..90 {
        let at = random.vector() * 4.0;
        let turn = DQuat::from_xyzw(random.next(), random.next(), random.next(), 1.1).normalize();
        let object = Object::new(k % 3, Pose::new(turn, at).unwrap());
        let is_static = k % 7 == 0;
        objects.push(if is_static { object.fixed() } else { object });
        velocities.push(if is_static {
            Velocity::default()
        } else {
            Velocity {
                linear: random.vector() * if k % 3 == 0 { 60.0 } else { 1.0 },
                angular: random.vector() * 2.0,
                centre: DVec3::X * 0.1,
            }
        });
    }
    (Scene::new(shapes, objects).unwrap(), velocities)
}

#[test]
fn what_moves_in_a_scene_meets_as_every_pair_alone_and_nothing_tunnels() {
    let (scene, velocities) = moving_scene();
    let motion = |i: usize| {
        let Velocity { linear, angular, centre } = velocities[i];
        RigidMotion { start: scene.poses()[i], linear, angular, centre }
    };
    let mut alone = Vec::new();
    for j in 0..scene.len() {
        for i in 0..j {
            if !scene.allows(i as u32, j as u32) {
                continue;
            }
            let (in_a, in_b) = (motion(i), motion(j));
            let a = MovingShape { shape: scene.shape(i), motion: &in_a };
            let b = MovingShape { shape: scene.shape(j), motion: &in_b };
            let impact = time_of_impact(a, b, 0.2, 1e-6).unwrap();
            if impact != Impact::Free {
                alone.push((i as u32, j as u32, impact));
            }
        }
    }
    let mut impacts = Impacts::new();
    let found = impacts.find(&scene, &velocities, [0.2, 1e-6], Par::Serial).unwrap().to_vec();
    assert_eq!(found.len(), alone.len());
    assert!(!found.is_empty());
    for one in &found {
        let expected = (one.pair.i, one.pair.j, one.impact);
        assert!(alone.contains(&expected), "{one:?}");
    }
    let time = |impact: &Impact| match *impact {
        Impact::Hit { t, .. } => t,
        Impact::Undecided { free_until } => free_until,
        Impact::Free => f64::NAN,
    };
    assert!(found.is_sorted_by(|x, y| time(&x.impact) <= time(&y.impact)));
    for threads in [1, 3] {
        let again = with_threads(threads, || {
            Impacts::new().find(&scene, &velocities, [0.2, 1e-6], Par::Pool).unwrap().to_vec()
        });
        assert!(again.unwrap() == found, "{threads} threads");
    }
}

#[test]
fn a_swept_box_holds_the_shape_whenever() {
    let (scene, velocities) = moving_scene();
    for (i, &Velocity { linear, angular, centre }) in velocities.iter().enumerate() {
        for scale in [1.0, 10.0] {
            let motion =
                RigidMotion { start: scene.poses()[i], linear, angular: angular * scale, centre };
            let moving = MovingShape { shape: scene.shape(i), motion: &motion };
            let swept = moving.swept_aabb(0.5);
            for k in 0..=40 {
                let pose = motion.pose_at(0.5 * f64::from(k) / 40.0).unwrap();
                let here = scene.shape(i).aabb(&pose);
                // The box of a pose is itself rounded outward.
                let off =
                    1e-5 * (1.0 + here.max.abs().max_element().max(here.min.abs().max_element()));
                let (min, max) = (swept.min - off, swept.max + off);
                assert!(
                    min.cmple(here.min).all() && here.max.cmple(max).all(),
                    "{i} at {k}: {swept:?} {here:?}"
                );
            }
        }
    }
}

#[test]
fn what_cannot_be_answered_is_refused_by_index_and_value() {
    let mut scene = scene(40);
    let mut pipeline = Pipeline::new();
    assert_eq!(pipeline.queries(&scene).unwrap_err(), QueryError::NoStep);
    pipeline.step(&scene, Par::Serial);
    let still = scene.poses()[1];
    assert!(pipeline.queries(&scene.clone()).is_ok());
    scene.set_pose(1, still).unwrap();
    assert_eq!(pipeline.queries(&scene).unwrap_err(), QueryError::SceneChanged);
    pipeline.step(&scene, Par::Serial);
    scene.set_filter(1, Filter { groups: 0, mask: 0 }).unwrap();
    let queries = pipeline.queries(&scene).unwrap();
    let (all, mut found) = (QueryFilter::ALL, Vec::new());
    let nan = DVec3::new(0.0, f64::NAN, 0.0);
    let refused = queries.at_point(nan, &all, &mut found).unwrap_err();
    let RegionError::Query(QueryError::BadNumber { what: "point", index: 0, value }) = refused
    else {
        panic!("{refused}")
    };
    assert!(value.is_nan());
    assert!(queries.in_sphere(DVec3::ZERO, -1.0, &all, &mut found).is_err());
    let refused = queries.in_planes(&[(DVec3::X, 0.0), (DVec3::ZERO, 1.0)], &all, &mut found);
    assert!(matches!(refused, Err(RegionError::Shape { index: 1, .. })));
    assert!(queries.nearest(DVec3::ZERO, -1.0, &all).is_err());
    let refused =
        queries.nearest_of_each(&[DVec3::ZERO, nan], 1.0, &all, Par::Serial, &mut Vec::new());
    assert!(matches!(refused, Err(QueryError::BadNumber { index: 1, .. })));
    let mut velocities = vec![Velocity::default(); scene.len()];
    let mut impacts = Impacts::new();
    let refused = impacts.find(&scene, &velocities[1..], [1.0, 1e-6], Par::Serial);
    assert!(matches!(refused, Err(QueryError::LengthsDiffer { .. })));
    velocities[3].angular.y = f64::INFINITY;
    let refused = impacts.find(&scene, &velocities, [1.0, 1e-6], Par::Serial);
    assert_eq!(
        refused.unwrap_err(),
        QueryError::BadNumber { what: "velocity", index: 3, value: f64::INFINITY }
    );
    velocities[3].angular.y = 0.0;
    assert!(impacts.find(&scene, &velocities, [-1.0, 1e-6], Par::Serial).is_err());
}

#[test]
fn an_empty_scene_has_nothing_in_it() {
    let scene = Scene::default();
    let mut pipeline = Pipeline::new();
    pipeline.step(&scene, Par::Serial);
    let queries = pipeline.queries(&scene).unwrap();
    let ray = Ray::endless(DVec3::ZERO, DVec3::X).unwrap();
    assert_eq!(queries.first_hit(&ray, &QueryFilter::ALL), None);
    assert_eq!(queries.nearest(DVec3::ZERO, f64::INFINITY, &QueryFilter::ALL), Ok(None));
}
