//! Proposed triangles beside the faces of A − B by their definition: planes through three of its points with none beyond.

use super::super::super::prepare::{Prepare, prepare};
use super::super::super::scene_pairs::ScenePairs;
use super::super::answers::WriteDepth;
use super::super::start::Starts;
use super::super::surface::Surface;
use super::super::{SEATS, SearchPairs};
use super::*;
use crate::epa::{self, Depth};
use crate::motion::tests::Draw;
use crate::query::FoundDepth;
use crate::simd::Purpose;
use crate::simd::frame::SimdFrame;
use crate::{Accuracy, PosedSupport, Sides};
use dcd_geom::glam::{DQuat, DVec3};
use dcd_geom::{Aabb, Object, Pose, Scene, Shape, SupportMap};
use dcd_simd::{Path, dispatch_on};

/// Pairs 2k, 2k + 1 of small hulls, boxes and flat ones, that overlap by a little, about a place that is drawn for each.
pub(in super::super) fn scene(draw: &mut Draw, count: u32, far: f64) -> Scene {
    let mut shapes = vec![
        Shape::cuboid(DVec3::new(0.5, 0.4, 0.3)).unwrap(),
        Shape::hull(vec![DVec3::X, DVec3::Y, DVec3::NEG_X]).unwrap(),
        Shape::capsule(0.4, 0.2).unwrap(),
    ];
    for corners in [4, 5, 6, 8, 8] {
        let corner = |_| draw.vector().normalize_or(DVec3::X) * 0.5;
        shapes.push(Shape::hull((0..corners).map(corner).collect()).unwrap());
    }
    let mut objects = Vec::new();
    for k in 0..count {
        let at = draw.vector() * far;
        for side in [0.0, 1.0] {
            let turn = DQuat::from_scaled_axis(draw.vector() * 3.0);
            let away = draw.vector().normalize_or(DVec3::X) * 0.6 * side;
            let away = if k % 9 == 0 { DVec3::Z * 0.5 * side } else { away };
            let kind = (draw.number().abs() * 1e6) as u32 % shapes.len() as u32;
            objects.push(Object::new(kind, Pose::new(turn, at + away).unwrap()));
        }
    }
    Scene::new(shapes, objects).unwrap()
}

pub(in super::super) fn proposed(
    scene: &Scene,
    path: Path,
    pairs: &[Pair],
) -> Vec<Option<Proposal>> {
    let (mut frame, mut aabbs) = (SimdFrame::default(), vec![Aabb::default(); scene.len()]);
    let part = frame.layout(scene, Sides::One, Purpose::Measure);
    prepare(path, Prepare { scene, first: 0, part, aabbs: &mut aabbs });
    let (mut scratch, mut found) = (SupportScratch::default(), Vec::new());
    let frames = FramePair::of_one(&frame);
    dispatch_on(path, Propose::of(frames, (pairs, true), &mut scratch, &mut found));
    found
}

/// The vertices of an object in the world.
pub(in super::super) fn vertices(scene: &Scene, object: u32) -> Vec<DVec3> {
    let polytope = scene.shape(object as usize).as_polytope().unwrap();
    let pose = &scene.poses()[object as usize];
    let placed = |&v: &DVec3| *pose.rotation() * v + pose.translation();
    polytope.vertices().iter().map(placed).collect()
}

#[test]
fn the_ray_from_the_centre_leaves_through_what_is_proposed_and_no_swept_pair_has_a_triangle() {
    let mut draw = Draw(5);
    let scene = scene(&mut draw, 2000, 100.0);
    let pairs: Vec<_> = (0..2000).map(|k| Pair::new(2 * k, 2 * k + 1)).collect();
    let found = proposed(&scene, Path::best(), &pairs);
    let [mut asked, mut faces, mut pierced] = [0; 3];
    for (pair, proposal) in pairs.iter().zip(&found) {
        let is_swept = |object: u32| scene.shape(object as usize).radius() > 0.0;
        if is_swept(pair.i) || is_swept(pair.j) {
            assert_eq!(*proposal, None, "{pair:?}");
            continue;
        }
        let Some(Proposal { triangle, .. }) = proposal else { continue };
        asked += 1;
        let (a, b) = (vertices(&scene, pair.i), vertices(&scene, pair.j));
        let point = |[i, j]: [u32; 2]| {
            // The last block is filled up with the last vertex.
            a[(i as usize).min(a.len() - 1)] - b[(j as usize).min(b.len() - 1)]
        };
        let [p, q, r] = triangle.map(point);
        let centre = |object: u32| {
            let inner = scene.shape(object as usize).as_polytope().unwrap().inner().centre;
            let pose = &scene.poses()[object as usize];
            *pose.rotation() * inner + pose.translation()
        };
        let c = centre(pair.i) - centre(pair.j);
        // The ray from c along −c has the three on its one side, or on the other, turned round it.
        let way = -c;
        let turns = [(p, q), (q, r), (r, p)].map(|(u, v)| (u - c).cross(v - c).dot(way));
        let least = turns.iter().map(|turn| turn.signum()).sum::<f64>().abs();
        pierced += usize::from(least == 3.0);
        let normal = (q - p).cross(r - p).normalize_or_zero();
        let normal = normal * normal.dot(p - c).signum();
        let reach = a.iter().flat_map(|a| b.iter().map(move |b| (a - b - p).dot(normal)));
        faces += usize::from(reach.fold(0.0, f64::max) < 1e-5);
    }
    println!("{asked} proposed, {pierced} pierced, {faces} faces");
    assert!(asked > 800 && pierced * 100 > asked * 98 && faces * 100 > asked * 70);
}

#[test]
fn both_orders_any_path_and_any_other_pairs_propose_the_same() {
    let mut draw = Draw(6);
    let scene = scene(&mut draw, 300, 100.0);
    let pairs: Vec<_> = (0..300).map(|k| Pair::new(2 * k, 2 * k + 1)).collect();
    let all = proposed(&scene, Path::best(), &pairs);
    assert!(all.iter().flatten().count() > 100);
    for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
        assert_eq!(proposed(&scene, path, &pairs), all, "{path:?}");
    }
    let mirrored: Vec<_> = pairs.iter().map(|pair| Pair { i: pair.j, j: pair.i }).collect();
    let back = proposed(&scene, Path::best(), &mirrored);
    for (one, other) in all.iter().zip(back) {
        let exchanged = other.map(|Proposal { triangle, nearest }| {
            let triangle = triangle.map(|[a, b]| [b, a]);
            let nearest = nearest.map(|face| {
                let [a, b] = face.farthest;
                NearestFace { farthest: [b, a], ..face }
            });
            Proposal { triangle, nearest }
        });
        assert_eq!(*one, exchanged);
    }
    for (k, pair) in pairs.iter().enumerate() {
        assert_eq!(proposed(&scene, Path::best(), &[*pair]), [all[k]]);
    }
}

/// Keeps what is found by its number.
struct Kept(Vec<Option<Depth>>);

impl WriteDepth for Kept {
    fn write(&mut self, number: usize, found: Option<&FoundDepth>) {
        self.0[number] = found.map(|found| found.depth);
    }

    fn prefetch(&self, _: usize) {}
}

/// The depths that searches find which start with those triangles.
fn searched(
    scene: &Scene,
    (pairs, proposals): (&[Pair], &[Option<Proposal>]),
    accuracy: Accuracy,
) -> Vec<Option<Depth>> {
    let (mut frame, mut aabbs) = (SimdFrame::default(), vec![Aabb::default(); scene.len()]);
    let part = frame.layout(scene, Sides::One, Purpose::Measure);
    let path = Path::best();
    prepare(path, Prepare { scene, first: 0, part, aabbs: &mut aabbs });
    let frames = FramePair::of_one(&frame);
    let numbers: Vec<u32> = (0..).take(pairs.len()).collect();
    let mut surfaces = Box::<[Surface; SEATS]>::default();
    let (mut starts, mut apart) = (Starts::default(), Vec::new());
    starts.begin();
    let mut kept = Kept(vec![None; pairs.len()]);
    let search = SearchPairs {
        objects: ScenePairs { frames, scenes: [scene, scene], pairs },
        numbers: &numbers,
        place: 0,
        accuracy,
        surfaces: &mut surfaces,
        starts: &mut starts,
        proposals,
        apart: &mut apart,
        reads_facets: false,
        looks_ahead: false,
        answers: &mut kept,
    };
    search.search_on(path);
    kept.0
}

#[test]
fn a_search_that_starts_with_any_triangle_ends_with_a_depth_within_its_bound() {
    let mut draw = Draw(7);
    let scene = scene(&mut draw, 2000, 100.0);
    let pairs: Vec<_> = (0..2000).map(|k| Pair::new(2 * k, 2 * k + 1)).collect();
    let mut triangle = |pair: &Pair| {
        let counts = [pair.i, pair.j].map(|object| vertices(&scene, object).len());
        let mut corner = || counts.map(|count| (draw.number().abs() * 1e6) as u32 % count as u32);
        Some(Proposal { triangle: std::array::from_fn(|_| corner()), nearest: None })
    };
    let any: Vec<_> = pairs.iter().map(&mut triangle).collect();
    let none = vec![None; pairs.len()];
    let mut scratch = epa::Scratch::default();
    for accuracy in [Accuracy::F32, Accuracy::F64, Accuracy::Certified] {
        let found = searched(&scene, (&pairs, &any), accuracy);
        let without = searched(&scene, (&pairs, &none), accuracy);
        for (pair, found) in pairs.iter().zip(&found) {
            let Some(found) = found else { continue };
            let side = |object: u32| {
                let polytope = scene.shape(object as usize).as_polytope().unwrap();
                PosedSupport::polytope(polytope, &scene.poses()[object as usize])
            };
            let exact = epa::depth_of_overlap(side(pair.i), side(pair.j), &mut scratch);
            assert!(exact.depth > 0.0, "{pair:?}, {accuracy:?}: {found:?} of what does not touch");
            let holds = found.lower() <= exact.upper() && found.upper() >= exact.lower();
            assert!(holds, "{pair:?}, {accuracy:?}: {found:?} {exact:?}");
        }
        let count = |found: &[Option<Depth>]| found.iter().flatten().count();
        println!("{accuracy:?}: {} found, {} without a triangle", count(&found), count(&without));
        assert!(count(&found) > 500 && count(&found) * 100 > count(&without) * 97);
    }
}
