//! Many queries at once beside each alone, at any number of threads.

use super::*;

#[test]
fn many_queries_at_once_have_the_answer_of_each_alone() {
    let scene = scene(300);
    let mut pipeline = Pipeline::new();
    pipeline.step(&scene, Par::Serial);
    let queries = pipeline.queries(&scene).unwrap();
    let sphere = Shape::sphere(0.1).unwrap();
    let (mut hits, mut nearest, mut impacts) = (Vec::new(), Vec::new(), Vec::new());
    let (mut all, mut found) = (Segments::default(), Segments::default());
    let mut met = [0; 5];
    // Few are answered as they come, many in an order of their own.
    for (filter, count) in filters().iter().flat_map(|f| [40, 800].map(|count| (f, count))) {
        let rays = rays(&scene, count);
        let points: Vec<DVec3> = rays.iter().map(|ray| ray.at(0.3)).collect();
        let motion = |ray: &Ray| RigidMotion {
            linear: ray.direction(),
            ..RigidMotion::at_rest(Pose::from_translation(ray.origin()).unwrap())
        };
        let motions: Vec<RigidMotion> = rays.iter().map(motion).collect();
        let moving: Vec<_> =
            motions.iter().map(|motion| MovingShape { shape: &sphere, motion }).collect();
        let due = (
            rays.iter().map(|ray| queries.first_hit(ray, filter)).collect::<Vec<_>>(),
            points.iter().map(|&at| queries.nearest(at, 2.0, filter).unwrap()).collect::<Vec<_>>(),
            moving.iter().map(|&m| queries.cast(m, 1.0, 1e-6, filter).unwrap()).collect::<Vec<_>>(),
        );
        let list_of_ray = |ray| {
            let mut hits = Vec::new();
            queries.all_hits(ray, filter, &mut hits);
            hits
        };
        let list_of_point = |&at| {
            let mut found = Vec::new();
            queries.at_point(at, filter, &mut found).unwrap();
            found
        };
        let lists_due = (
            rays.iter().map(list_of_ray).collect::<Vec<_>>(),
            points.iter().map(list_of_point).collect::<Vec<_>>(),
        );
        for threads in [1, 3] {
            with_threads(threads, || {
                queries.all_hits_of_each(&rays, filter, Par::Pool, &mut all);
                queries.at_points(&points, filter, Par::Pool, &mut found).unwrap();
                queries.first_hits(&rays, filter, Par::Pool, &mut hits);
                queries.nearest_of_each(&points, 2.0, filter, Par::Pool, &mut nearest).unwrap();
                queries.casts(&moving, 1.0, 1e-6, filter, Par::Pool, &mut impacts).unwrap();
            })
            .unwrap();
            assert!(hits == due.0, "{count} rays on {threads} threads");
            assert!(nearest == due.1, "{count} points on {threads} threads");
            assert!(impacts == due.2, "{count} casts on {threads} threads");
            assert!(all.iter().eq(&lists_due.0), "{count} rays on {threads} threads");
            assert!(found.iter().eq(&lists_due.1), "{count} points on {threads} threads");
        }
        met[0] += hits.iter().flatten().count();
        met[1] += nearest.iter().flatten().count();
        met[2] += impacts.iter().flatten().count();
        met[3] += all.len();
        met[4] += found.len();
    }
    assert!(met.iter().all(|&met| met > 100), "{met:?}");
}

#[test]
fn batches_are_the_same_bytes_at_any_number_of_threads() {
    let scene = scene(300);
    let mut pipeline = Pipeline::new();
    pipeline.step(&scene, Par::Pool);
    let queries = pipeline.queries(&scene).unwrap();
    let rays = rays(&scene, 333);
    let points: Vec<DVec3> = rays.iter().map(|ray| ray.at(0.3)).collect();
    let filter = QueryFilter::ALL;
    let sphere = Shape::sphere(0.1).unwrap();
    let motions: Vec<RigidMotion> = rays
        .iter()
        .take(40)
        .map(|ray| RigidMotion {
            linear: ray.direction(),
            angular: DVec3::new(0.1, 0.2, 0.0),
            ..RigidMotion::at_rest(Pose::from_translation(ray.origin()).unwrap())
        })
        .collect();
    let moving: Vec<_> =
        motions.iter().map(|motion| MovingShape { shape: &sphere, motion }).collect();
    let run = |par: Par| {
        let (mut hits, mut nearest, mut impacts) = (Vec::new(), Vec::new(), Vec::new());
        let (mut all, mut found) = (Segments::default(), Segments::default());
        queries.first_hits(&rays, &filter, par, &mut hits);
        queries.all_hits_of_each(&rays, &filter, par, &mut all);
        queries.at_points(&points, &filter, par, &mut found).unwrap();
        queries.nearest_of_each(&points, f64::INFINITY, &filter, par, &mut nearest).unwrap();
        queries.casts(&moving, 1.0, 1e-6, &filter, par, &mut impacts).unwrap();
        let all: Vec<Vec<ObjectHit>> = all.iter().map(<[_]>::to_vec).collect();
        let found: Vec<Vec<Found>> = found.iter().map(<[_]>::to_vec).collect();
        format!("{hits:?} {all:?} {found:?} {nearest:?} {impacts:?}")
    };
    let serial = run(Par::Serial);
    for threads in [1, 2, 5] {
        assert!(with_threads(threads, || run(Par::Pool)).unwrap() == serial, "{threads} threads");
    }
}
