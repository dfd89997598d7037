//! The queries, the libraries that answer them, and which answers agree.

use std::hint::black_box;

use anyhow::{Result, ensure};
use dcd_benches::timing::{Effort, Pair, pairs_of, time};
use dcd_geom::glam::DVec3;
use dcd_geom::{Object, Pose, Scene, Shape};
use dcd_gjk::motion::{Impact, MovingShape, RigidMotion, time_of_impact};
use dcd_gjk::query::ray::Ray;
use dcd_pipeline::{Par, Pipeline, Queries, QueryFilter};
use dcd_scenes::SceneSpec;
use serde::{Deserialize, Serialize};

use crate::parry::{double, single};

/// How far a time of Parry's in f64 may be from ours, relative, before one of us counts as wrong: far above what its
/// tolerances leave, far below another hit.
const AGREES: f64 = 1e-4;

/// Rounds of two rivals.
fn rounds(effort: Effort) -> u32 {
    match effort {
        Effort::Full => 11,
        Effort::Quick => 3,
    }
}

/// A question, its answers and times.
#[derive(Serialize, Deserialize)]
pub(crate) struct Row {
    pub(crate) question: String,
    pub(crate) count: usize,
    /// How many were met.
    pub(crate) met: usize,
    /// Of ours that Parry in f64 contradicts where our bracket excludes its answer and its own is confirmed.
    pub(crate) wrong: usize,
    /// Of Parry's in f32 and f64 that differ from ours.
    pub(crate) differs: [usize; 2],
    /// Ours beside f32, and beside f64.
    pub(crate) times: [Pair; 2],
}

#[derive(Serialize, Deserialize)]
pub(crate) struct Outcome {
    pub(crate) objects: usize,
    pub(crate) triangles: usize,
    pub(crate) rows: Vec<Row>,
}

/// Scenes and the queries on them.
pub(crate) struct Work {
    hulls: Scene,
    mesh: Scene,
    rays: Vec<Ray>,
    down: Vec<Ray>,
    points: Vec<DVec3>,
    pairs: Vec<([usize; 2], [RigidMotion; 2])>,
}

/// The generator of splitmix64, within ±1.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ z >> 31) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
    fn vector(&mut self) -> DVec3 {
        DVec3::new(self.next(), self.next(), self.next())
    }
}

/// How many cells a side of the mesh has; two triangles each.
const CELLS: u32 = 100;

fn terrain() -> Result<Shape> {
    let height = |x: u32, y: u32| ((x * 7 + y * 13) % 11) as f64 * 0.05;
    let side = 0..=CELLS;
    let vertices = side
        .clone()
        .flat_map(|y| {
            (0..=CELLS).map(move |x| DVec3::new(f64::from(x), f64::from(y), height(x, y)))
        })
        .collect();
    let at = |x: u32, y: u32| y * (CELLS + 1) + x;
    let cell = |x: u32, y: u32| {
        [[at(x, y), at(x + 1, y), at(x, y + 1)], [at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)]]
    };
    let triangles = (0..CELLS).flat_map(|y| (0..CELLS).flat_map(move |x| cell(x, y))).collect();
    Ok(Shape::mesh(vertices, triangles)?)
}

impl Work {
    pub(crate) fn new(seed: u64, [count, objects]: [usize; 2]) -> Result<Self> {
        let hulls = SceneSpec::paper().with_objects(objects).with_seed(seed).scene()?;
        let mesh = Scene::new(vec![terrain()?], [Object::new(0, Pose::IDENTITY).fixed()])?;
        let mut random = Random(seed);
        let places = hulls.poses().iter().map(|pose| pose.translation());
        let (low, high) =
            places.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
        let (middle, half) = ((low + high) * 0.5, (high - low) * 0.5);
        let place = |random: &mut Random| middle + random.vector() * half;
        let mut rays = Vec::new();
        while rays.len() < count {
            // From outside or within, across the scene.
            let (from, to) = (middle + random.vector() * half * 1.5, place(&mut random));
            rays.extend(Ray::endless(from, (to - from).normalize()));
        }
        let down = (0..count).map(|_| {
            let span = f64::from(CELLS) * 0.5;
            let from = DVec3::new(random.next() * span + span, random.next() * span + span, 5.0);
            let tilt = DVec3::new(random.next(), random.next(), -0.5);
            Ray::endless(from, tilt.normalize())
        });
        let down = down.collect::<Result<_, _>>()?;
        let points = (0..count).map(|_| place(&mut random)).collect();
        let pairs = (0..count.min(hulls.len() / 2))
            .map(|k| {
                let ids = [2 * k, 2 * k + 1];
                let [a, b] = ids.map(|i| hulls.poses()[i]);
                let motion = |start: Pose, way: DVec3, random: &mut Random| RigidMotion {
                    linear: way + random.vector() * half.length() * 0.02,
                    angular: random.vector() * 2.0,
                    ..RigidMotion::at_rest(start)
                };
                let way = (b.translation() - a.translation()) * 0.6;
                (ids, [motion(a, way, &mut random), motion(b, -way, &mut random)])
            })
            .collect();
        Ok(Self { hulls, mesh, rays, down, points, pairs })
    }

    pub(crate) fn run(&self, effort: Effort) -> Result<Outcome> {
        let mut rows = Vec::new();
        let mut pipeline = Pipeline::new();
        pipeline.step(&self.hulls, Par::Serial);
        let queries = pipeline.queries(&self.hulls)?;
        let rivals = (single::Rival::new(&self.hulls)?, double::Rival::new(&self.hulls)?);
        rows.push(rays("first hit, hulls", &queries, &self.rays, &rivals, effort)?);
        rows.push(batch("first hit, hulls, in a batch", &queries, &self.rays, &rivals, effort)?);
        rows.push(self.nearest(&queries, &rivals, effort)?);
        rows.push(self.impacts("shape cast of two hulls", Turn::Without, &rivals, effort)?);
        rows.push(self.impacts("time of impact of two hulls", Turn::With, &rivals, effort)?);
        let mut on_mesh = Pipeline::new();
        on_mesh.step(&self.mesh, Par::Serial);
        let meshed = (single::Rival::new(&self.mesh)?, double::Rival::new(&self.mesh)?);
        let queries = on_mesh.queries(&self.mesh)?;
        rows.push(rays("first hit, mesh", &queries, &self.down, &meshed, effort)?);
        let triangles = 2 * CELLS as usize * CELLS as usize;
        Ok(Outcome { objects: self.hulls.len(), triangles, rows })
    }

    fn nearest(&self, queries: &Queries<'_>, rivals: &Rivals, effort: Effort) -> Result<Row> {
        let ours = |point: &DVec3| {
            queries.nearest(*point, f64::INFINITY, &QueryFilter::ALL).ok().flatten()
        };
        let mut tally = Tally::default();
        for point in &self.points {
            let found = ours(point).map(|found| [found.lower, found.distance, found.upper]);
            tally.take(
                found,
                [rivals.0.nearest(*point), rivals.1.nearest(*point)].map(|x| x.map(|x| x.1)),
            );
        }
        let points = &self.points;
        let times = [
            beside(
                effort,
                || points.iter().filter_map(ours).count(),
                || points.iter().filter_map(|p| rivals.0.nearest(*p)).count(),
            ),
            beside(
                effort,
                || points.iter().filter_map(ours).count(),
                || points.iter().filter_map(|p| rivals.1.nearest(*p)).count(),
            ),
        ];
        tally.row("nearest object", times)
    }

    fn impacts(&self, name: &str, turn: Turn, rivals: &Rivals, effort: Effort) -> Result<Row> {
        let pairs: Vec<_> = self
            .pairs
            .iter()
            .map(|&(ids, motions)| match turn {
                Turn::With => (ids, motions),
                Turn::Without => {
                    (ids, motions.map(|motion| RigidMotion { angular: DVec3::ZERO, ..motion }))
                }
            })
            .collect();
        type CastQuery = ([usize; 2], [RigidMotion; 2]);
        let ours = |&(ids, ref motions): &CastQuery| {
            let [a, b] = [0, 1]
                .map(|k| MovingShape { shape: self.hulls.shape(ids[k]), motion: &motions[k] });
            let size = a.shape.reach() + b.shape.reach();
            match time_of_impact(a, b, 1.0, 1e-6 * size) {
                Ok(Impact::Hit { free_until, t, .. }) => Some([free_until, t, t]),
                _ => None,
            }
        };
        let f32s = |(ids, [u, v]): &CastQuery| match turn {
            Turn::With => rivals.0.impact(*ids, [u, v]),
            Turn::Without => rivals.0.cast(*ids, [u, v]),
        };
        let f64s = |(ids, [u, v]): &CastQuery| match turn {
            Turn::With => rivals.1.impact(*ids, [u, v]),
            Turn::Without => rivals.1.cast(*ids, [u, v]),
        };
        let mut tally = Tally::default();
        pairs.iter().for_each(|pair| tally.take(ours(pair), [f32s(pair), f64s(pair)]));
        let all = || pairs.iter().filter_map(ours).count();
        let times = [
            beside(effort, all, || pairs.iter().filter_map(f32s).count()),
            beside(effort, all, || pairs.iter().filter_map(f64s).count()),
        ];
        tally.row(name, times)
    }
}

#[derive(Clone, Copy)]
enum Turn {
    With,
    Without,
}

type Rivals = (single::Rival, double::Rival);

/// Our times and one rival's, interleaved.
fn beside(effort: Effort, ours: impl Fn() -> usize, theirs: impl Fn() -> usize) -> Pair {
    let [pair] = pairs_of(
        rounds(effort),
        || [time(|| black_box(ours())).0],
        || [time(|| black_box(theirs())).0],
    );
    pair
}

#[derive(Default)]
struct Tally {
    count: usize,
    met: usize,
    wrong: usize,
    differs: [usize; 2],
}

impl Tally {
    fn take(&mut self, ours: Option<[f64; 3]>, theirs: [Option<f64>; 2]) {
        self.count += 1;
        self.met += usize::from(ours.is_some());
        let agrees = |theirs: Option<f64>| match (ours, theirs) {
            (Some([lower, _, upper]), Some(t)) => {
                let tolerance = AGREES * (1.0 + t.abs());
                lower - tolerance <= t && t <= upper + tolerance
            }
            (None, None) => true,
            _ => false,
        };
        for (differs, theirs) in self.differs.iter_mut().zip(theirs) {
            *differs += usize::from(!agrees(theirs));
        }
    }

    fn row(self, question: &str, times: [Pair; 2]) -> Result<Row> {
        ensure!(self.met > 0, "{question}: nothing was met");
        let Self { count, met, wrong, differs } = self;
        Ok(Row { question: question.into(), count, met, wrong, differs, times })
    }
}

/// Answers on rays; a hit of Parry's in f64 that lies before ours is wrong of ours if it is confirmed by a point of
/// the ray inside of the shape.
fn judged(queries: &Queries<'_>, rays: &[Ray], rivals: &Rivals) -> Tally {
    let mut tally = Tally::default();
    for ray in rays {
        let found = queries.first_hit(ray, &QueryFilter::ALL).map(|found| found.hit);
        let (f32s, f64s) = (
            rivals.0.ray(ray.origin(), ray.direction()),
            rivals.1.ray(ray.origin(), ray.direction()),
        );
        let ours = found.map(|hit| [hit.t_lower, hit.t, hit.t_upper]);
        tally.take(ours, [f32s, f64s].map(|found| found.map(|found| found.1)));
        let is_sooner =
            f64s.is_some_and(|(_, t)| found.is_none_or(|hit| t < hit.t_lower * (1.0 - AGREES)));
        if is_sooner && confirmed(queries, ray, f64s) {
            tally.wrong += 1;
        }
    }
    tally
}

/// Whether a point of the ray a little after Parry's hit is proved to be of that object.
fn confirmed(queries: &Queries<'_>, ray: &Ray, hit: Option<(u32, f64)>) -> bool {
    let Some((object, t)) = hit else { return false };
    let mut found = Vec::new();
    let behind = [0.0, 1e-9, 1e-6, 1e-5].map(|by| ray.at(t * (1.0 + by)));
    behind.into_iter().any(|point| {
        queries.at_point(point, &QueryFilter::ALL, &mut found).is_ok()
            && found.iter().any(|found| found.object == object && found.is_certain)
    })
}

fn rays(
    name: &str,
    queries: &Queries<'_>,
    rays: &[Ray],
    rivals: &Rivals,
    effort: Effort,
) -> Result<Row> {
    let ours = || rays.iter().filter_map(|ray| queries.first_hit(ray, &QueryFilter::ALL)).count();
    timed(name, queries, (rays, rivals), effort, ours)
}

/// On one thread, as the rivals, which have no batch.
fn batch(
    name: &str,
    queries: &Queries<'_>,
    rays: &[Ray],
    rivals: &Rivals,
    effort: Effort,
) -> Result<Row> {
    let ours = || {
        let mut hits = Vec::new();
        queries.first_hits(rays, &QueryFilter::ALL, Par::Serial, &mut hits);
        hits.iter().flatten().count()
    };
    timed(name, queries, (rays, rivals), effort, ours)
}

fn timed(
    name: &str,
    queries: &Queries<'_>,
    (rays, rivals): (&[Ray], &Rivals),
    effort: Effort,
    ours: impl Fn() -> usize,
) -> Result<Row> {
    let tally = judged(queries, rays, rivals);
    let times = [
        beside(effort, &ours, || {
            rays.iter().filter_map(|ray| rivals.0.ray(ray.origin(), ray.direction())).count()
        }),
        beside(effort, &ours, || {
            rays.iter().filter_map(|ray| rivals.1.ray(ray.origin(), ray.direction())).count()
        }),
    ];
    tally.row(name, times)
}
