//! Every stage's scalar reference: the same step in f64, one pair at a time, on the vertices as the scene
//! has them. Where a quantity is farther from its threshold than rounding reaches, stage and reference
//! must say the same.

mod compounds;
mod curved;
mod faces;
mod forms;
mod simplex;

use super::bounds::{ROTATED, U};
use super::certificate::CertifiedBounds;
use super::first_stages::{Entry, Place, Resolved, cone, first_axis};
use super::frame::{FramePair, SimdFrame};
use super::obb::{ObbPairs, obbs};
use super::packet::{PairPacket, Vector};
use super::support::{SupportScratch, supports};
use super::vector::V3;
use super::{Overlap, portal};
use crate::{NarrowPhase, Sides};
use dcd_geom::glam::{DMat3, DQuat, DVec3};
use dcd_geom::{Aabb, Pair, Pose, Scene, Shape};
use dcd_simd::{Kernel, Lanes, Path, Row, WIDTH, dispatch_on};

/// How far from its threshold a length must be for stage and reference to have to agree, metres: a
/// hundred times the rounding of f32 on objects of a metre.
const CLEAR: f64 = 1e-4;

/// Numbers in −1 … 1 by a linear congruence.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    fn vector(&mut self) -> DVec3 {
        DVec3::new(self.next(), self.next(), self.next())
    }
}

/// Hulls of 4 to 63 points, so of one to four blocks, turned and placed near one another.
fn scene(seed: u64) -> Scene {
    let mut numbers = Numbers(seed);
    let shapes = (0..60).map(|k| {
        let size = DVec3::new(0.5, 0.5 + 0.1 * f64::from(k % 5), 0.3);
        Shape::hull((0..4 + k).map(|_| numbers.vector() * size).collect()).unwrap()
    });
    let shapes = shapes.collect();
    let poses = (0..60).map(|_| {
        let turn = DQuat::from_xyzw(numbers.next(), numbers.next(), numbers.next(), numbers.next());
        Pose::new(turn.normalize(), numbers.vector() * 1.3).unwrap()
    });
    let poses = poses.collect();
    Scene::one_each(shapes, poses).unwrap()
}

fn prepared(scene: &Scene, path: Path) -> (SimdFrame, Vec<Aabb>) {
    let (overlap, mut frame) = (Overlap::on(path), SimdFrame::default());
    let mut aabbs = vec![Aabb::default(); scene.len()];
    let part = overlap.layout(scene, Sides::One, &mut frame);
    overlap.prepare(scene, 0, part, &mut aabbs);
    (frame, aabbs)
}

fn pairs(scene: &Scene) -> Vec<Pair> {
    let objects = scene.len() as u32;
    (0..objects).flat_map(|i| (i + 1..objects).map(move |j| Pair { i, j })).collect()
}

fn paths() -> impl Iterator<Item = Path> {
    Path::ALL.into_iter().filter(|path| path.is_available())
}

/// A − B in f64: its points, its centre and the radii of spheres round that.
struct Plain {
    points: Vec<DVec3>,
    centre: DVec3,
    inner: f64,
    outer: f64,
}

impl Plain {
    fn of(scene: &Scene, pair: Pair) -> Self {
        let side = |i: u32| {
            let polytope = scene.shape(i as usize).as_polytope().unwrap();
            (polytope, &scene.poses()[i as usize])
        };
        let ((a, at_a), (b, at_b)) = (side(pair.i), side(pair.j));
        let world = |v: &[DVec3], at: &Pose| v.iter().map(|&v| at.apply(v)).collect::<Vec<_>>();
        let (in_a, in_b) = (world(a.vertices(), at_a), world(b.vertices(), at_b));
        Self {
            points: in_a.iter().flat_map(|&a| in_b.iter().map(move |&b| a - b)).collect(),
            centre: at_a.apply(a.inner().centre) - at_b.apply(b.inner().centre),
            inner: a.inner().radius + b.inner().radius,
            outer: a.outer_radius() + b.outer_radius(),
        }
    }

    fn farthest(&self, d: DVec3) -> DVec3 {
        *self.points.iter().max_by(|p, q| p.dot(d).total_cmp(&q.dot(d))).unwrap()
    }

    /// How far the origin is beyond the plane with that normal that A − B touches, metres.
    fn separation(&self, d: DVec3) -> f64 {
        let d = d.normalize();
        d.dot(self.farthest(-d))
    }

    /// How much the sphere's part of c + Σ τ·p leaves to reach the origin: positive if it does.
    fn reach(&self, points: &[DVec3], taus: &[f64]) -> f64 {
        let v = points.iter().zip(taus).fold(self.centre, |v, (&p, &tau)| v + p * tau.max(0.0));
        self.inner - v.length()
    }

    /// The touching answer of a cone over these points, by least squares.
    fn cone(&self, points: &[DVec3]) -> f64 {
        let c = self.centre;
        match *points {
            [p] => self.reach(points, &[-c.dot(p) / p.dot(p)]),
            [p, q] => {
                let (pp, pq, qq) = (p.dot(p), p.dot(q), q.dot(q));
                let determinant = pp * qq - pq * pq;
                let tau_p = (c.dot(q) * pq - c.dot(p) * qq) / determinant;
                let tau_q = (c.dot(p) * pq - c.dot(q) * pp) / determinant;
                self.reach(points, &[tau_p, tau_q])
            }
            [p, q, r] => {
                let taus = DMat3::from_cols(p, q, r).inverse() * -c;
                self.reach(points, &taus.to_array())
            }
            _ => self.inner - c.length(),
        }
    }
}

/// Asserts that a stage decides yes where the reference's length is clearly above 0, and no where it is below.
fn agree(what: &str, said: bool, reference: f64) {
    assert!(
        reference.abs() < CLEAR || said == (reference > 0.0),
        "{what}: {said}, but the reference has {reference}"
    );
}

#[test]
fn prepared_vertices_and_boxes_are_those_of_the_plain_pose() {
    let scene = scene(1);
    for path in paths() {
        let (frame, aabbs) = prepared(&scene, path);
        for (i, ours) in aabbs.iter().enumerate() {
            let polytope = scene.shape(i).as_polytope().unwrap();
            let (record, pose) = (frame.record(i as u32), &scene.poses()[i]);
            let bound = f64::from(ROTATED * U * record.size);
            for (k, &v) in polytope.vertices().iter().enumerate() {
                let turned = *pose.rotation() * (v - polytope.inner().centre);
                let block = frame.blocks_of(record)[k / WIDTH];
                let found = DVec3::from_array(block.0.map(|row| f64::from(row.0[k % WIDTH])));
                assert!((found - turned).abs().max_element() <= bound, "{path:?} {i} {k}");
                assert!((record.outer as f64) >= turned.length());
            }
            // Both are round the same vertices; neither need hold the other's rounding.
            let plain = scene.aabb(i);
            assert!((ours.min - plain.min).abs().max_element() < 1e-6, "{path:?} {i}");
            assert!((ours.max - plain.max).abs().max_element() < 1e-6, "{path:?} {i}");
        }
    }
}

/// Supports of sixteen objects along sixteen directions.
struct Supports<'a> {
    frame: &'a SimdFrame,
    packet: &'a PairPacket,
    directions: &'a [Row; 3],
    used: usize,
}

impl Kernel for Supports<'_> {
    type Output = [Row; 3];

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> [Row; 3] {
        let mut points = [Row::default(); 3];
        let side = (&self.packet.a, V3::load(l, self.directions));
        supports(l, self.frame, &mut SupportScratch::default(), side, self.used)
            .0
            .store(l, &mut points);
        points
    }
}

#[test]
fn no_vertex_is_farther_than_the_support_by_more_than_its_bound() {
    let (scene, mut numbers) = (scene(2), Numbers(3));
    for path in paths() {
        let (frame, _) = prepared(&scene, path);
        for first in 0..(scene.len() - WIDTH) as u32 {
            let mut packet = PairPacket::default();
            let directions: [DVec3; WIDTH] = std::array::from_fn(|_| numbers.vector());
            let rows = [0, 1, 2].map(|axis| Row(directions.map(|d| d[axis] as f32)));
            for k in 0..WIDTH {
                packet.a.0[k] = first + k as u32;
            }
            let used = WIDTH - first as usize % 3;
            let found = dispatch_on(
                path,
                Supports { frame: &frame, packet: &packet, directions: &rows, used },
            );
            for k in 0..used {
                let at = |rows: &[Row; 3]| {
                    DVec3::from_array([0, 1, 2].map(|axis| f64::from(rows[axis].0[k])))
                };
                let (d, point) = (at(&rows), at(&found));
                let record = frame.record(first + k as u32);
                let farthest = frame.blocks_of(record).iter().flat_map(|block| {
                    (0..WIDTH).map(move |lane| {
                        DVec3::from_array(block.0.map(|row| f64::from(row.0[lane])))
                    })
                });
                let farthest = farthest.map(|v| v.dot(d)).fold(f64::MIN, f64::max);
                // Two dot products of 3u, and what the vertex's number may hide.
                let bound = 6.1 * f64::from(U * record.size) + f64::from(record.choice);
                let bound = bound * d.abs().element_sum();
                assert!(point.dot(d) >= farthest - bound, "{path:?} {k}");
            }
        }
    }
}

/// Long, flat and box-shaped objects, turned and placed near one another.
fn thin_scene(seed: u64) -> Scene {
    let mut numbers = Numbers(seed);
    let shapes = (0..60).map(|k| match k % 3 {
        0 => Shape::cuboid((numbers.vector() * 0.5).abs() + 0.05).unwrap(),
        1 => cloud(&mut numbers, DVec3::new(0.1, 0.1, 1.5)),
        _ => cloud(&mut numbers, DVec3::new(0.8, 0.8, 0.05)),
    });
    let shapes = shapes.collect();
    let poses = (0..60).map(|_| {
        let turn = DQuat::from_xyzw(numbers.next(), numbers.next(), numbers.next(), numbers.next());
        Pose::new(turn.normalize(), numbers.vector()).unwrap()
    });
    let poses = poses.collect();
    Scene::one_each(shapes, poses).unwrap()
}

fn cloud(numbers: &mut Numbers, size: DVec3) -> Shape {
    Shape::hull((0..40).map(|_| numbers.vector() * size).collect()).unwrap()
}

/// The box stage of at most sixteen pairs.
struct BoxStage<'a> {
    frame: &'a SimdFrame,
    pairs: &'a [Pair],
}

impl Kernel for BoxStage<'_> {
    type Output = (Verdicts, u32);

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Self::Output {
        let (mut entry, mut boxes) = (Entry::default(), ObbPairs::default());
        entry.read::<CertifiedBounds>(FramePair::of_one(self.frame), self.pairs, 0);
        entry.spheres::<L, CertifiedBounds>(l);
        let (resolved, _) = obbs::<L, CertifiedBounds>(
            l,
            FramePair::of_one(self.frame),
            &mut boxes,
            (&entry.packet, self.pairs.len()),
        );
        (Verdicts::of(resolved), entry.boxed & entry.live)
    }
}

/// A shape's box in f64: its edges' directions and half its edges.
type PlainBox = (DMat3, DVec3);

/// How far apart two boxes are at most along one of the fifteen axes, by projecting their corners;
/// each axis as long as the product of the edges that make it.
fn gap_of_boxes(c: DVec3, a: PlainBox, b: PlainBox) -> f64 {
    let reach = |axis: DVec3, (edges, half): PlainBox| half.dot((edges.transpose() * axis).abs());
    let edges = |m: DMat3| [m.x_axis, m.y_axis, m.z_axis];
    let crossed = edges(a.0).into_iter().flat_map(|e| edges(b.0).map(|f| e.cross(f)));
    let axes = edges(a.0).into_iter().chain(edges(b.0)).chain(crossed);
    let gaps = axes.map(|axis| axis.dot(c).abs() - reach(axis, a) - reach(axis, b));
    gaps.fold(f64::NEG_INFINITY, f64::max)
}

#[test]
fn the_box_stage_says_what_boxes_in_f64_say() {
    for seed in 20..24 {
        let scene = thin_scene(seed);
        let (pairs, mut seen) = (pairs(&scene), [0; 2]);
        let side = |i: u32| {
            let reference = *scene.shape(i as usize).as_polytope().unwrap().obb().unwrap();
            let edges = *scene.poses()[i as usize].rotation() * reference.axes;
            [(edges, reference.outer), (edges, reference.inner)]
        };
        for path in paths() {
            let (frame, _) = prepared(&scene, path);
            for group in pairs.chunks(WIDTH) {
                let (said, boxed) = dispatch_on(path, BoxStage { frame: &frame, pairs: group });
                assert_eq!(boxed, u32::MAX >> (32 - group.len()));
                for (k, &pair) in group.iter().enumerate() {
                    let (a, b) = (side(pair.i), side(pair.j));
                    let c = Plain::of(&scene, pair).centre;
                    let bit = |bits: u32| bits >> k & 1 == 1;
                    agree("outer boxes", bit(said.apart), gap_of_boxes(c, a[0], b[0]));
                    agree("inner boxes", bit(said.touching), -gap_of_boxes(c, a[1], b[1]));
                    seen[0] += usize::from(bit(said.apart));
                    seen[1] += usize::from(bit(said.touching));
                }
            }
        }
        assert!(seen.iter().all(|&count| count > 0), "boxes resolved nothing: {seen:?}");
    }
}

/// The opening and the second point of at most sixteen pairs, and then rounds to the end.
struct Stages<'a> {
    frame: &'a SimdFrame,
    pairs: &'a [Pair],
}

/// The verdicts of a stage on sixteen pairs.
#[derive(Clone, Copy, Default)]
struct Verdicts {
    apart: u32,
    touching: u32,
}

impl Verdicts {
    fn of<L: Lanes>(resolved: Resolved<L>) -> Self {
        Self { apart: resolved.apart, touching: resolved.touching }
    }
}

/// The verdicts of all stages on sixteen pairs.
struct AllVerdicts {
    live: u32,
    spheres: Verdicts,
    axis: u32,
    cone: u32,
    second: u32,
    /// The portal after the second point.
    p: [[Row; 3]; 2],
    rounds: Verdicts,
}

impl Kernel for Stages<'_> {
    type Output = AllVerdicts;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> AllVerdicts {
        let (mut entry, mut support_scratch) = (Entry::default(), SupportScratch::default());
        let mut at =
            Place { frames: FramePair::of_one(self.frame), support_scratch: &mut support_scratch };
        entry.read::<CertifiedBounds>(FramePair::of_one(self.frame), self.pairs, 0);
        let spheres = Verdicts::of(entry.spheres::<L, CertifiedBounds>(l));
        let live = entry.live;
        // Every stage runs on every pair, resolved or not: each has its reference.
        let used = self.pairs.len();
        let c = entry.packet.vector(l, Vector::C);
        let axis = first_axis::<L, CertifiedBounds>(l, &mut at, (&mut entry.packet, used), c);
        let axis = l.bits(axis.holds);
        let cone = l.bits(cone::<L, CertifiedBounds>(l, &entry.packet).holds) & !axis;
        let second =
            portal::second_point::<L, CertifiedBounds>(l, &mut at, &mut entry.packet, used);
        let second = l.bits(second.holds);
        let mut p = [[Row::default(); 3]; 2];
        entry.packet.vector(l, Vector::P0).store(l, &mut p[0]);
        entry.packet.vector(l, Vector::P1).store(l, &mut p[1]);
        let mut rounds = Verdicts::default();
        let mut open = live & !(spheres.apart | spheres.touching | axis | cone | second);
        while open != 0 {
            let (resolved, stuck) =
                portal::round::<L, CertifiedBounds>(l, &mut at, &mut entry.packet, used);
            rounds.apart |= resolved.apart & open;
            rounds.touching |= resolved.touching & open;
            open &= !(resolved.apart | resolved.touching | stuck);
        }
        AllVerdicts { live, spheres, axis, cone, second, p, rounds }
    }
}

#[test]
fn every_stage_says_what_its_plain_reference_says() {
    for seed in 4..8 {
        let scene = scene(seed);
        let (pairs, mut seen) = (pairs(&scene), [0; 6]);
        for path in paths() {
            let (frame, _) = prepared(&scene, path);
            for group in pairs.chunks(WIDTH) {
                let said = dispatch_on(path, Stages { frame: &frame, pairs: group });
                for (k, &pair) in group.iter().enumerate() {
                    let plain = Plain::of(&scene, pair);
                    let bit = |bits: u32| bits >> k & 1 == 1;
                    assert!(bit(said.live));
                    let (c, length) = (plain.centre, plain.centre.length());
                    agree("inscribed spheres", bit(said.spheres.touching), plain.inner - length);
                    agree("bounding spheres", bit(said.spheres.apart), length - plain.outer);
                    agree("centre axis", bit(said.axis), plain.separation(c));

                    let portal =
                        said.p.map(|rows| DVec3::from_array(rows.map(|row| f64::from(row.0[k]))));
                    let first = plain.farthest(-c);
                    agree("cone", bit(said.cone), plain.cone(&[first]));
                    agree("second point", bit(said.second), plain.cone(&portal));

                    let reference = plain.refined(portal);
                    if bit(said.rounds.apart) || bit(said.rounds.touching) {
                        assert!(
                            bit(said.rounds.touching) == (reference > 0.0)
                                || reference.abs() < CLEAR,
                            "{reference}"
                        );
                    }
                    let all = [
                        said.spheres.touching,
                        said.spheres.apart,
                        said.axis,
                        said.cone,
                        said.second,
                    ];
                    for (count, bits) in seen.iter_mut().zip(all) {
                        *count += usize::from(bit(bits));
                    }
                    seen[5] += usize::from(bit(said.rounds.apart | said.rounds.touching));
                }
            }
        }
        assert!(seen.iter().all(|&count| count > 0), "a stage resolved nothing: {seen:?}");
    }
}

impl Plain {
    /// MPR from a centre and two points in plain f64: how deep the origin is, or minus how far the
    /// last plane separates it.
    fn refined(&self, [mut p0, mut p1]: [DVec3; 2]) -> f64 {
        let c = self.centre;
        let mut d = (p0 - c).cross(p1 - c);
        let mut p2 = None;
        for _ in 0..200 {
            let w = self.farthest(d);
            let beyond = w.dot(d.normalize());
            if beyond < 0.0 {
                return beyond;
            }
            let across = w.cross(c);
            let side = |p: DVec3| p.dot(across) > 0.0;
            match p2 {
                None if !side(p0) => p1 = w,
                None if side(p1) => p0 = w,
                None => p2 = Some(w),
                Some(_) if side(p0) && !side(p1) => p2 = Some(w),
                Some(p) if !side(p0) && side(p) => p1 = w,
                Some(_) => p0 = w,
            }
            d = match p2 {
                None => (p0 - c).cross(p1 - c),
                Some(p) => (p1 - p0).cross(p - p0),
            };
            if p2.is_some() && d.dot(p0) >= 0.0 {
                return d.normalize().dot(p0);
            }
        }
        0.0
    }
}
