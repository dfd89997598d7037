//! Queries of random scenes on every SIMD path: the same bytes, and those of every object alone.
//!
//! One test, for the path is that of the whole process.
#![allow(missing_docs)]

mod random;

use dcd_geom::glam::{DQuat, DVec3};
use dcd_geom::{Object, Pose, Scene, Shape};
use dcd_gjk::motion::{Impact, MovingShape, RigidMotion, time_of_impact};
use dcd_gjk::query::ray::{Ray, RayHit, for_each_hit};
use dcd_gjk::{DistanceResult, PosedShape, Verdict, certified, distance};
use dcd_pipeline::{ObjectHit, Par, Pipeline, Queries, QueryFilter};
use dcd_simd::Path;
use random::Random;

impl Random {
    fn pose(&mut self, far: f64, is_turned: bool) -> Pose {
        let q = DQuat::from_xyzw(self.next(), self.next(), self.next(), self.next());
        let turn = if is_turned { q.normalize() } else { DQuat::IDENTITY };
        Pose::new(turn, self.vector() * far).unwrap()
    }
}

/// A shape of any kind, of about that size.
fn shape(random: &mut Random, k: usize, size: f64) -> Shape {
    let half = random.vector().abs() * size + 0.02 * size;
    let cloud = |random: &mut Random, count: usize| -> Vec<DVec3> {
        (0..count).map(|_| random.vector() * size).collect()
    };
    let shape = match k % 12 {
        0 => Shape::sphere(half.x),
        1 => Shape::cuboid(half),
        2 => Shape::capsule(half.x, half.y),
        3 => Shape::cylinder(half.x, half.y),
        4 => Shape::cone(half.x, half.y),
        5 => Shape::ellipsoid(half),
        6 => Shape::hull(cloud(random, 14)),
        7 => Shape::triangle([random.vector() * size, random.vector() * size, half]),
        8 => Shape::mesh(
            cloud(random, 9),
            vec![[0, 1, 2], [2, 3, 4], [3, 4, 5], [6, 7, 8], [0, 4, 8]],
        ),
        9 => Shape::compound(vec![
            (Shape::cuboid(half).unwrap(), random.pose(size, true)),
            (Shape::cylinder(half.y, half.z).unwrap(), random.pose(size, true)),
        ]),
        10 => Shape::segment(random.vector() * size, half),
        _ => Shape::hull(cloud(random, 40)),
    };
    let shape = shape.unwrap();
    if random.next() > 0.6 { shape.swept(0.1 * size).unwrap() } else { shape }
}

/// Few objects or many, of a size; some fixed; a floor in some.
fn scene(random: &mut Random, round: usize, size: f64) -> Scene {
    let count = [5, 40, 150][round % 3];
    let mut shapes: Vec<Shape> = (0..count).map(|k| shape(random, k + round, size)).collect();
    let spread = size * [1.5, 4.0, 7.0][round % 3];
    let mut objects: Vec<Object> = (0..count)
        .map(|k| {
            let object = Object::new(k as u32, random.pose(spread, k % 3 > 0));
            if (k + round).is_multiple_of(3) { object.fixed() } else { object }
        })
        .collect();
    if round.is_multiple_of(2) {
        objects.push(Object::new(count as u32, Pose::IDENTITY).fixed());
        shapes.push(Shape::half_space(DVec3::new(0.1, 0.2, 1.0), -0.7 * spread).unwrap());
    }
    Scene::new(shapes, objects).unwrap()
}

/// From anywhere, from inside of objects, along the axes, at vertices, and short ones.
fn rays(random: &mut Random, scene: &Scene, size: f64) -> Vec<Ray> {
    (0..120)
        .map(|k| {
            let object = k % scene.len();
            let pose = &scene.poses()[object];
            let middle = pose.translation();
            let target = match scene.shape(object).as_polytope() {
                Some(polytope) if k % 2 == 0 => pose.apply(polytope.vertices()[0]),
                _ => middle + random.vector() * 0.5 * size,
            };
            let from = random.vector() * 12.0 * size;
            let axis = [DVec3::X, -DVec3::Y, DVec3::Z, DVec3::new(1.0, 0.0, 1.0)][k % 4];
            match k % 5 {
                0 => Ray::endless(target - axis * 3.0 * size, axis),
                1 => Ray::new(from, target - from, 0.9),
                2 => Ray::endless(middle, random.vector()),
                3 => Ray::new(from, target - from, 1.5),
                _ => Ray::endless(from, target - from),
            }
            .unwrap()
        })
        .collect()
}

fn motions(random: &mut Random, rays: &[Ray], size: f64) -> Vec<RigidMotion> {
    let moved = rays.iter().take(30).enumerate().map(|(k, ray)| RigidMotion {
        linear: ray.direction().normalize() * size * 8.0,
        angular: if k % 2 == 0 { DVec3::ZERO } else { random.vector() * 3.0 },
        centre: if k % 4 < 2 { DVec3::ZERO } else { random.vector() * 0.2 * size },
        start: random.pose(0.0, k % 3 > 0).with_translation(ray.origin()).unwrap(),
    });
    moved.collect()
}

fn assert_rays_are_those_of_objects_alone(
    queries: &Queries<'_>,
    rays: &[Ray],
    said: &str,
) -> usize {
    let (scene, filter) = (queries.scene(), QueryFilter::ALL);
    let (mut all, mut met) = (Vec::new(), 0);
    for (k, ray) in rays.iter().enumerate() {
        let mut alone = Vec::new();
        for object in 0..scene.len() as u32 {
            for_each_hit(ray, PosedShape::of(scene, object), ray.max_t(), &mut |hit: RayHit| {
                alone.push(ObjectHit { object, hit });
                ray.max_t()
            });
        }
        queries.all_hits(ray, &filter, &mut all);
        // Of what grazes, a box may prove the miss that the shape alone leaves open.
        let is_known = |hit: &ObjectHit| hit.hit.is_certain || all.contains(hit);
        alone.retain(is_known);
        alone.sort_by(|x, y| {
            let of = |hit: &ObjectHit| (hit.object, hit.hit.part);
            x.hit.t.total_cmp(&y.hit.t).then(of(x).cmp(&of(y)))
        });
        assert_eq!(all, alone, "{said}, ray {k}");
        assert_eq!(queries.first_hit(ray, &filter), all.first().copied(), "{said}, ray {k}");
        let any = queries.any_hit(ray, &filter);
        assert_eq!(any.is_some(), all.iter().any(|hit| hit.hit.is_certain), "{said}, ray {k}");
        assert!(any.is_none_or(|any| all.contains(&any)), "{said}, ray {k}");
        met += usize::from(any.is_some());
    }
    met
}

fn assert_casts_are_proved(
    queries: &Queries<'_>,
    shape: &Shape,
    (motions, tolerance): (&[RigidMotion], f64),
    said: &str,
) -> usize {
    let (scene, mut hits) = (queries.scene(), 0);
    for (k, motion) in motions.iter().enumerate() {
        let moving = MovingShape { shape, motion };
        let found = queries.cast(moving, 1.0, tolerance, &QueryFilter::ALL).unwrap();
        let free = match found.map(|found| found.impact) {
            None => 1.0,
            Some(Impact::Hit { free_until, .. } | Impact::Undecided { free_until }) => free_until,
            Some(Impact::Free) => panic!("{said}, cast {k}"),
        };
        hits += usize::from(found.is_some());
        for object in 0..scene.len() as u32 {
            let PosedShape { shape, pose } = PosedShape::of(scene, object);
            let still = RigidMotion::at_rest(*pose);
            let target = MovingShape { shape, motion: &still };
            if let Ok(Impact::Hit { t, touches: true, .. }) =
                time_of_impact(moving, target, 1.0, tolerance)
            {
                assert!(
                    found.is_some() && free <= t,
                    "{said}, cast {k}: {object} at {t}, {found:?}"
                );
            }
        }
        for step in 0..=12 {
            let t = free * f64::from(step) / 12.0 * (1.0 - 1e-9);
            let pose = motion.pose_at(t).unwrap();
            let here = PosedShape { shape, pose: &pose };
            for object in 0..scene.len() as u32 {
                let (verdict, _) = certified::overlap_of(here, PosedShape::of(scene, object));
                let is_free = verdict != Verdict::Touching(()) || free == 0.0;
                assert!(is_free, "{said}, cast {k}: {object} at {t} of {free}, {found:?}");
            }
        }
    }
    hits
}

fn assert_nearest_is_that_of_objects_alone(queries: &Queries<'_>, points: &[DVec3], said: &str) {
    let scene = queries.scene();
    let sphere = Shape::sphere(0.0).unwrap();
    for (k, &point) in points.iter().enumerate() {
        let at = Pose::from_translation(point).unwrap();
        let bounds = (0..scene.len() as u32).map(|object| {
            let own = PosedShape { shape: &sphere, pose: &at };
            match distance::distance(own, PosedShape::of(scene, object)).0 {
                DistanceResult::Apart(found) => [found.lower(), found.upper()],
                DistanceResult::Interval { within, .. } => [0.0, within.upper()],
                _ => [0.0; 2],
            }
        });
        let least = bounds.fold([f64::INFINITY; 2], |x, y| [x[0].min(y[0]), x[1].min(y[1])]);
        let found = queries.nearest(point, f64::INFINITY, &QueryFilter::ALL).unwrap().unwrap();
        let meets = found.lower <= least[1] && least[0] <= found.upper;
        assert!(meets, "{said}, point {k}: {found:?}, {least:?}");
    }
}

#[test]
fn queries_are_the_same_bytes_on_every_path_and_those_of_every_object_alone() {
    let mut random = Random::seeded(97);
    let [mut met, mut hits] = [0; 2];
    let widest = Path::best();
    for round in 0..9 {
        let size = [1.0, 1e-3, 1e4][round / 3];
        let scene = scene(&mut random, round, size);
        let rays = rays(&mut random, &scene, size);
        let points: Vec<DVec3> = rays.iter().map(|ray| ray.at(0.4)).collect();
        let motions = motions(&mut random, &rays, size);
        let shape = shape(&mut random, round, 0.5 * size);
        let mut due: Option<String> = None;
        for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
            path.force().unwrap();
            let said = format!("round {round} on {path:?}");
            let mut pipeline = Pipeline::new();
            pipeline.step(&scene, Par::Serial);
            let queries = pipeline.queries(&scene).unwrap();
            let filter = QueryFilter::ALL;
            let (mut first, mut nearest, mut impacts) = (Vec::new(), Vec::new(), Vec::new());
            queries.first_hits(&rays, &filter, Par::Serial, &mut first);
            queries
                .nearest_of_each(&points, f64::INFINITY, &filter, Par::Serial, &mut nearest)
                .unwrap();
            let moving: Vec<_> =
                motions.iter().map(|motion| MovingShape { shape: &shape, motion }).collect();
            let tolerance = 1e-6 * size;
            queries.casts(&moving, 1.0, tolerance, &filter, Par::Serial, &mut impacts).unwrap();
            let found = format!("{first:?} {nearest:?} {impacts:?}");
            assert!(due.get_or_insert_with(|| found.clone()) == &found, "{said}");
            met += assert_rays_are_those_of_objects_alone(&queries, &rays, &said);
            if path == widest {
                hits += assert_casts_are_proved(&queries, &shape, (&motions, tolerance), &said);
                assert_nearest_is_that_of_objects_alone(&queries, &points, &said);
            }
        }
    }
    widest.force().unwrap();
    assert!(met > 500 && hits > 50, "{met} {hits}");
}
