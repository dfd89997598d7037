//! Time and memory for each object as a scene grows at the same density.

use anyhow::{Context, Result, ensure};
use dcd_benches::{
    Axis, Cell, Column, Figure, Options, Report, Sample, Series, Table, Units, timing,
};
use dcd_broad::{BroadPhase, WideTree};
use dcd_exec::{Exec, Segments};
use dcd_geom::glam::{DMat3, DVec3};
use dcd_geom::{Aabb, Pair, Scene};
use dcd_io::{RawScene, RawShape};
use dcd_pipeline::Par;
use dcd_scenes::SceneSpec;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::runner::{PARTS, Runner, WHOLE};

/// Steps before a pipeline holds what it will hold.
const WARM_UP: usize = 3;

/// Memory beside the input shapes and poses that a step may hold, bytes: for each object, rotated
/// vertex and candidate pair.
const BUDGET: [f64; 3] = [200.0, 16.0, 8.0];

/// What is grown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum What {
    /// Whole steps.
    Step,
    /// The broad phase alone, on AABBs that are there.
    Broad,
}

/// A scene in several sizes.
#[derive(Clone, Copy, Debug)]
struct Family {
    scene: &'static str,
    what: What,
    sizes: &'static [usize],
    /// At most, as a multiple of what the whole run is limited to.
    reach: usize,
    /// Memory that making the scene and stepping through it takes, bytes an object: measured, and
    /// rounded up.
    bytes: u64,
}

const FAMILIES: [Family; 3] = [
    Family {
        scene: "sparse",
        what: What::Step,
        sizes: &[1_000, 3_000, 10_000, 30_000, 100_000, 300_000, 1_000_000],
        reach: 1,
        bytes: 9_000,
    },
    Family {
        scene: "paper",
        what: What::Step,
        sizes: &[10, 30, 100, 300, 1_000, 3_000, 10_000],
        reach: 1,
        bytes: 20_000,
    },
    Family {
        scene: "boxes",
        what: What::Broad,
        sizes: &[1_000, 10_000, 100_000, 1_000_000, 10_000_000],
        reach: 10,
        bytes: 800,
    },
];

/// What was seen of a size.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Seen {
    objects: usize,
    vertices: usize,
    candidates: usize,
    contacts: usize,
    /// As [`PARTS`]; the broad phase alone has no others.
    times: [Option<Sample>; PARTS.len()],
    /// The most that was held at once during the first steps, beside the scene.
    peak: u64,
    /// Allocations of the step after those.
    later_allocations: u64,
}

/// A size that is measured, or why it is not.
#[derive(Clone, Copy, Debug)]
struct Planned {
    family: Family,
    objects: usize,
}

impl Planned {
    fn key(&self) -> String {
        format!("growth/{}/N={}", self.family.scene, self.objects)
    }
}

/// The sizes of all families up to `most` objects (of AABBs ten times as many).
fn planned(most: usize) -> Vec<Planned> {
    let of_family = |family: Family| {
        let within = family.sizes.iter().filter(move |&&size| size <= most * family.reach);
        within.map(move |&objects| Planned { family, objects })
    };
    FAMILIES.into_iter().flat_map(of_family).collect()
}

/// The units of all families.
pub(crate) fn plan(most: usize) -> Vec<String> {
    planned(most).iter().map(Planned::key).collect()
}

/// Measures every size that there is memory for; the others stay missing.
pub(crate) fn measure(most: usize, options: &Options, units: &mut Units) -> Result<()> {
    for planned in planned(most) {
        if let Some(reason) = planned.skipped() {
            eprintln!("{}: {reason}", planned.key());
            continue;
        }
        units.run(&planned.key(), || planned.see(options))?;
    }
    Ok(())
}

impl Planned {
    /// Why this size cannot be measured here, if it cannot.
    fn skipped(&self) -> Option<String> {
        let need = self.family.bytes * self.objects as u64;
        let free = available_memory()?;
        let gib = |bytes: u64| bytes as f64 / (1u64 << 30) as f64;
        let (need_gib, free_gib) = (gib(need), gib(free));
        (need > free).then(|| {
            format!("skipped, needs about {need_gib:.1} GiB of memory, {free_gib:.1} are free")
        })
    }

    fn see(&self, options: &Options) -> Result<Seen> {
        let spec = SceneSpec::parse(self.family.scene)?;
        let spec = spec.with_objects(self.objects).with_seed(options.seed);
        match self.family.what {
            What::Step => see_steps(&dcd_benches::draw(&spec)?, options),
            What::Broad => see_broad(&boxes(&spec.raw()?)?, options),
        }
    }
}

fn see_steps(scene: &Scene, options: &Options) -> Result<Seen> {
    let mut pipeline = None;
    let first = allocation_counter::measure(|| {
        let pipeline = pipeline.insert(<dcd_pipeline::Pipeline>::default());
        for _ in 0..WARM_UP {
            pipeline.step(scene, Par::Serial);
        }
    });
    let mut pipeline = pipeline.context("no pipeline was made")?;
    let (mut candidates, mut contacts) = (0, 0);
    let later = allocation_counter::measure(|| {
        let step = pipeline.step(scene, Par::Serial);
        (candidates, contacts) = (step.candidate_count(), step.contact_count());
    });
    drop(pipeline);
    let mut runner = Runner::new(scene, Par::Serial);
    let times = timing::measure_stages(options.effort(), || runner.times());
    runner.agrees_with(&runner)?;
    let vertices = |i: usize| scene.shape(i).as_polytope().map_or(0, |p| p.vertices().len());
    Ok(Seen {
        objects: scene.len(),
        vertices: (0..scene.len()).map(vertices).sum(),
        candidates,
        contacts,
        times: times.map(Some),
        peak: first.bytes_max,
        later_allocations: later.count_total,
    })
}

fn see_broad(boxes: &[Aabb], options: &Options) -> Result<Seen> {
    let step = |tree: &mut WideTree, pairs: &mut Segments<Pair>| {
        let exec = Exec::from(Par::Serial);
        let (build, ()) = timing::time(|| tree.build(boxes, exec));
        let (search, ()) = timing::time(|| tree.pairs(boxes, |_, _| true, exec, pairs));
        [build, search, build + search]
    };
    let (mut tree, mut pairs) = (WideTree::default(), Segments::default());
    let first = allocation_counter::measure(|| {
        for _ in 0..WARM_UP {
            step(&mut tree, &mut pairs);
        }
    });
    let later = allocation_counter::measure(|| {
        step(&mut tree, &mut pairs);
    });
    let candidates = pairs.len();
    let [build, search, whole] =
        timing::measure_stages(options.effort(), || step(&mut tree, &mut pairs));
    ensure!(pairs.len() == candidates, "the number of pairs changed from step to step");
    Ok(Seen {
        objects: boxes.len(),
        vertices: 0,
        candidates,
        contacts: 0,
        times: [None, Some(build), Some(search), None, Some(whole)],
        peak: first.bytes_max,
        later_allocations: later.count_total,
    })
}

/// The world AABBs of a scene of cuboids.
fn boxes(scene: &RawScene) -> Result<Vec<Aabb>> {
    let of = |object: &dcd_io::RawObject| {
        let shape = scene.shapes.get(object.shape as usize);
        let Some(RawShape::Cuboid { half_extents }) = shape else { return None };
        let [x, y, z] = DMat3::from_quat(object.rotation).to_cols_array_2d();
        let column = |c: [f64; 3]| DVec3::from_array(c).abs();
        let half =
            column(x) * half_extents.x + column(y) * half_extents.y + column(z) * half_extents.z;
        Some(Aabb::outward(object.translation - half, object.translation + half))
    };
    let boxes: Option<Vec<Aabb>> = scene.objects.iter().map(of).collect();
    boxes.context("the scene has an object that is no cuboid")
}

/// Memory that can be had without swapping, bytes: `MemAvailable` of Linux. `None` elsewhere.
fn available_memory() -> Option<u64> {
    let info = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = info.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kibibytes.checked_mul(1024)
}

impl Seen {
    /// For each object, nanoseconds.
    fn time(&self, part: usize) -> Option<f64> {
        let sample = self.times[part]?;
        Some(sample.median.as_secs_f64() * 1e9 / self.objects as f64)
    }

    /// How much memory the step may hold.
    fn budget(&self) -> f64 {
        let counts = [self.objects, self.vertices, self.candidates];
        counts.iter().zip(BUDGET).map(|(&count, bytes)| count as f64 * bytes).sum()
    }
}

/// Draws what is there.
pub(crate) fn show(most: usize, units: &Units, report: &mut Report) -> Result<()> {
    let [object, vertex, pair] = BUDGET;
    report.heading("Growth");
    report.note(format!(
        "One thread. Sparse scenes and AABBs keep their density, so that the pairs grow with the \
         objects; the paper's scene keeps its volume, so that they grow with the square. Memory is \
         the most that the step held at once during its first {WARM_UP} runs beside the scene, \
         counted at the allocator; its budget is {object} bytes an object, {vertex} a rotated \
         vertex and {pair} a candidate pair. Of the AABBs the broad phase runs alone, and its \
         budget has no share for a vertex. A slope of 1 is a time that grows as the objects do.",
    ));
    for skipped in planned(most).iter().filter(|planned| units.missing().contains(&&*planned.key()))
    {
        let reason = skipped.skipped().unwrap_or_else(|| "not measured".to_owned());
        report.note(format!("{}, N = {}: {reason}.", skipped.family.scene, skipped.objects));
    }
    for family in FAMILIES {
        let left_out: Vec<String> = family.sizes[..]
            .iter()
            .filter(|&&size| size > most * family.reach)
            .map(ToString::to_string)
            .collect();
        if !left_out.is_empty() {
            let (scene, sizes) = (family.scene, left_out.join(", "));
            report.note(format!("{scene}: left out by --n-max: N = {sizes}."));
        }
    }
    let seen: Vec<(Family, Vec<Seen>)> = FAMILIES
        .into_iter()
        .map(|family| {
            let own = planned(most).into_iter().filter(|p| p.family.scene == family.scene);
            (family, own.filter_map(|planned| units.get(&planned.key())).collect())
        })
        .collect();
    report.table(sizes(&seen)?);
    report.table(slopes(&seen)?);
    report.figure(figure(&seen)?);
    report
        .attach("growth", seen.iter().flat_map(|(family, seen)| objects(*family, seen)).collect());
    Ok(())
}

fn sizes(seen: &[(Family, Vec<Seen>)]) -> Result<Table> {
    let ns = |name: &str| Column::new(name).unit("ns/object").decimals(1);
    let mut columns = ["scene", "N"].map(Column::new).to_vec();
    columns.extend(
        ["vertices", "candidates"].map(|name| Column::new(name).unit("an object").decimals(1)),
    );
    columns.extend(PARTS.map(ns));
    columns.push(Column::new("narrow").unit("ns/pair").decimals(1));
    columns.push(Column::new("memory").unit("bytes/object").decimals(0));
    columns.push(Column::new("budget").unit("bytes/object").decimals(0));
    columns.push(Column::new("allocations later"));
    let mut table = Table::new("growth", "Time and memory for each object", columns);
    for (family, seen) in seen {
        for seen in seen {
            let each = |total: f64| Cell::from(total / seen.objects as f64);
            let mut row = vec![Cell::from(family.scene), seen.objects.into()];
            row.extend([seen.vertices, seen.candidates].map(|count| each(count as f64)));
            row.extend((0..PARTS.len()).map(|part| Cell::from(seen.time(part))));
            let narrow = seen.time(WHOLE - 1);
            let per_pair = seen.objects as f64 / seen.candidates as f64;
            row.push(narrow.map(|ns| ns * per_pair).into());
            row.extend([each(seen.peak as f64), each(seen.budget())]);
            row.push(seen.later_allocations.into());
            table.push(row)?;
        }
    }
    Ok(table)
}

/// The exponent of each stage's time in the number of objects.
fn slopes(seen: &[(Family, Vec<Seen>)]) -> Result<Table> {
    let mut columns = vec![Column::new("scene"), Column::new("from N"), Column::new("to N")];
    columns.extend(PARTS.map(|part| Column::new(part).decimals(3)));
    columns.push(Column::new("memory").decimals(3));
    let mut table = Table::new("slopes", "Exponent of the growth with the objects", columns);
    for (family, seen) in seen {
        let (Some(first), Some(last)) = (seen.first(), seen.last()) else { continue };
        let mut row = vec![Cell::from(family.scene), first.objects.into(), last.objects.into()];
        row.extend((0..PARTS.len()).map(|part| {
            let time = |seen: &Seen| Some((seen.objects, seen.time(part)? * seen.objects as f64));
            Cell::from(slope(&seen.iter().filter_map(time).collect::<Vec<_>>()))
        }));
        let memory = seen.iter().map(|seen| (seen.objects, seen.peak as f64));
        row.push(slope(&memory.collect::<Vec<_>>()).into());
        table.push(row)?;
    }
    Ok(table)
}

/// The slope of the line through the logarithms, least squares.
fn slope(points: &[(usize, f64)]) -> Option<f64> {
    let logs: Vec<(f64, f64)> =
        points.iter().map(|&(n, value)| ((n as f64).ln(), value.ln())).collect();
    let count = logs.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| logs.iter().map(of).sum::<f64>() / count;
    let (x, y) = (mean(|log| log.0), mean(|log| log.1));
    let (mut across, mut along) = (0.0, 0.0);
    for (a, b) in &logs {
        across += (a - x) * (b - y);
        along += (a - x) * (a - x);
    }
    Some(across / along).filter(|slope| slope.is_finite())
}

fn figure(seen: &[(Family, Vec<Seen>)]) -> Result<Figure> {
    let (x, y) = (Axis::logarithmic("objects N"), Axis::logarithmic("time [ns/object]"));
    let mut figure = Figure::new("growth", "Time for each object on one thread", x, y);
    for (family, seen) in seen {
        let name = match family.what {
            What::Step => format!("{}, step", family.scene),
            What::Broad => format!("{}, broad phase", family.scene),
        };
        let points = seen.iter().filter_map(|seen| Some((seen.objects as f64, seen.time(WHOLE)?)));
        figure.push(Series::measured(name, points))?;
    }
    Ok(figure)
}

fn objects(family: Family, seen: &[Seen]) -> Vec<Value> {
    let object = |seen: &Seen| {
        json!({
            "scene": family.scene,
            "objects": seen.objects,
            "vertices": seen.vertices,
            "candidates": seen.candidates,
            "contacts": seen.contacts,
            "ns_per_object": PARTS.into_iter().enumerate()
                .map(|(part, name)| (name.to_owned(), json!(seen.time(part))))
                .collect::<serde_json::Map<_, _>>(),
            "peak_bytes": seen.peak,
            "budget_bytes": seen.budget(),
            "later_allocations": seen.later_allocations,
        })
    };
    seen.iter().map(object).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::runner::Case;

    #[test]
    fn the_slope_of_a_power_is_its_exponent() {
        let points = [10, 100, 1000].map(|n| (n, 3.0 * (n as f64).powf(1.5)));
        assert!((slope(&points).unwrap() - 1.5).abs() < 1e-12);
        assert_eq!(slope(&points[..1]), None);
        assert_eq!(slope(&[]), None);
    }

    #[test]
    fn boxes_that_are_found_without_a_scene_are_those_of_the_scene() {
        let raw = SceneSpec::boxes().with_objects(300).raw().unwrap();
        let boxes = boxes(&raw).unwrap();
        let scene = raw.into_scene().unwrap();
        for (i, found) in boxes.iter().enumerate() {
            let expected = scene.aabb(i);
            let near = |a: dcd_geom::glam::Vec3, b| a.distance(b) < 1e-5;
            assert!(near(found.min, expected.min) && near(found.max, expected.max), "{i}");
        }
    }

    #[test]
    fn a_small_scene_is_counted_and_allocates_nothing_later() {
        let scene = Case::new("sparse", 500, 1).unwrap();
        let options = Options { quick: true, ..Options::default() };
        let seen = see_steps(scene.scene().unwrap(), &options).unwrap();
        assert_eq!((seen.objects, seen.later_allocations), (500, 0));
        assert!(seen.peak > 500 * 64 && seen.vertices > 500 * 4 && seen.candidates > 0);
        assert!(seen.times.iter().all(Option::is_some));
    }

    #[test]
    fn no_size_is_beyond_the_limit() {
        let sizes: Vec<usize> = planned(10_000).iter().map(|planned| planned.objects).collect();
        assert_eq!(sizes.iter().max(), Some(&100_000));
        let hulls = planned(10_000).into_iter().filter(|planned| planned.family.scene == "sparse");
        assert_eq!(hulls.map(|planned| planned.objects).max(), Some(10_000));
    }
}
