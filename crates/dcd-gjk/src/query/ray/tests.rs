//! Hits against a method of their own: certified yes or no, and distance, of points of the ray.

use super::*;
use crate::{Verdict, certified, distance};
use dcd_geom::glam::DQuat;
use dcd_geom::{Pose, Shape};

/// The generator of Numerical Recipes.
pub(in crate::query) struct Random(u32);

impl Random {
    /// From the seed that `DCD_SEED` names, else from this one.
    pub(in crate::query) fn seeded(fixed: u32) -> Self {
        Self(std::env::var("DCD_SEED").map_or(fixed, |seed| seed.parse().expect("a seed")))
    }
    pub(in crate::query) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(self.0 >> 8) / f64::from(1 << 23) - 1.0
    }
    pub(in crate::query) fn vector(&mut self) -> DVec3 {
        DVec3::new(self.next(), self.next(), self.next())
    }
    pub(in crate::query) fn pose(&mut self, at: DVec3) -> Pose {
        let q = DQuat::from_xyzw(self.next(), self.next(), self.next(), self.next() + 1.1);
        Pose::new(q.normalize(), at).unwrap()
    }
}

fn hull(random: &mut Random, count: usize, scale: f64) -> Shape {
    Shape::hull((0..count).map(|_| random.vector() * scale).collect()).unwrap()
}

/// An octahedron's surface, each triangle cut into four, so that edges and vertices are many.
fn ball_mesh(scale: f64) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let mut vertices = vec![DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z];
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    for (x, y, z) in
        [(0, 1, 2), (1, 3, 2), (3, 4, 2), (4, 0, 2), (1, 0, 5), (3, 1, 5), (4, 3, 5), (0, 4, 5)]
    {
        triangles.push([x, y, z]);
    }
    for _ in 0..2 {
        let mut finer = Vec::new();
        for [a, b, c] in triangles {
            let mut middle = |a: u32, b: u32| {
                let point = (vertices[a as usize] + vertices[b as usize]).normalize();
                match vertices.iter().position(|&v| v == point) {
                    Some(k) => k as u32,
                    None => {
                        vertices.push(point);
                        vertices.len() as u32 - 1
                    }
                }
            };
            let (d, e, f) = (middle(a, b), middle(b, c), middle(c, a));
            finer.extend([[a, d, f], [d, b, e], [f, e, c], [d, e, f]]);
        }
        triangles = finer;
    }
    (vertices.into_iter().map(|v| v * scale).collect(), triangles)
}

pub(in crate::query) fn shapes(random: &mut Random, s: f64) -> Vec<(&'static str, Shape)> {
    let (vertices, triangles) = ball_mesh(s);
    let cuboid = || Shape::cuboid(DVec3::new(0.5, 0.8, 0.2) * s).unwrap();
    let parts = vec![
        (cuboid(), random.pose(DVec3::X * s)),
        (Shape::sphere(0.6 * s).unwrap(), random.pose(DVec3::ZERO)),
        (Shape::cylinder(0.5 * s, 0.3 * s).unwrap(), random.pose(-DVec3::X * s)),
        (hull(random, 12, s), random.pose(DVec3::Y * s)),
    ];
    vec![
        ("sphere", Shape::sphere(0.7 * s).unwrap()),
        ("capsule", Shape::capsule(0.6 * s, 0.3 * s).unwrap()),
        ("cuboid", cuboid()),
        ("rounded cuboid", cuboid().rounded(0.1 * s).unwrap()),
        ("hull", hull(random, 24, s)),
        ("rounded hull", hull(random, 10, s).rounded(0.2 * s).unwrap()),
        ("tetrahedron", hull(random, 4, s)),
        (
            "triangle",
            Shape::triangle([random.vector() * s, random.vector() * s, random.vector() * s])
                .unwrap(),
        ),
        (
            "rounded triangle",
            Shape::triangle([random.vector() * s, random.vector() * s, random.vector() * s])
                .unwrap()
                .rounded(0.1 * s)
                .unwrap(),
        ),
        ("cylinder", Shape::cylinder(0.6 * s, 0.4 * s).unwrap()),
        ("flat cylinder", Shape::cylinder(0.001 * s, 0.9 * s).unwrap()),
        ("rounded cylinder", Shape::cylinder(0.6 * s, 0.4 * s).unwrap().rounded(0.1 * s).unwrap()),
        ("cone", Shape::cone(0.6 * s, 0.5 * s).unwrap()),
        ("half-space", Shape::half_space(random.vector(), 0.1 * s).unwrap()),
        ("compound", Shape::compound(parts).unwrap()),
        ("mesh", Shape::mesh(vertices, triangles).unwrap()),
    ]
}

/// Whether the point is proved to be of the shape, or proved not to be.
fn holds(shape: &Shape, pose: &Pose, point: DVec3) -> Option<bool> {
    let (ball, at) = (Shape::sphere(0.0).unwrap(), Pose::from_translation(point).unwrap());
    let point = PosedShape { shape: &ball, pose: &at };
    match certified::overlap_of(point, PosedShape { shape, pose }).0 {
        Verdict::Touching(()) => Some(true),
        Verdict::Apart => Some(false),
        Verdict::Undecided(_) => None,
    }
}

/// At least how far a point is from the shape.
fn distance_of(shape: &Shape, pose: &Pose, point: DVec3) -> f64 {
    let (ball, at) = (Shape::sphere(0.0).unwrap(), Pose::from_translation(point).unwrap());
    match distance::distance(PosedShape { shape: &ball, pose: &at }, PosedShape { shape, pose }).0 {
        crate::DistanceResult::Apart(found) => found.lower(),
        _ => 0.0,
    }
}

/// Judges one ray; whether it hit, certainly.
fn judge(what: &str, (shape, pose): (&Shape, &Pose), ray: &Ray, s: f64) -> Option<bool> {
    let found = first_hit(ray, PosedShape { shape, pose });
    let far = (ray.origin() - pose.translation()).length() + 4.0 * s;
    let end = ray.max_t().min(2.0 * far / ray.direction().length());
    // What a point of the ray is off by.
    let off = 1e-13 * (ray.origin().length() + far);
    for k in 0..=64 {
        let t = end * f64::from(k) / 64.0;
        let is_inside = holds(shape, pose, ray.at(t)) == Some(true);
        match found {
            None => assert!(
                !is_inside,
                "{what}: {ray:?} misses, but {t} is inside of {shape:?} at {pose:?}"
            ),
            Some(hit) if is_inside => {
                let ahead = (hit.t_lower - t) * ray.direction().length();
                assert!(ahead <= off, "{what}: {ray:?} {hit:?} but {t} is inside");
            }
            Some(_) => {}
        }
    }
    let hit = found?;
    assert!(
        hit.t_lower <= hit.t && hit.t <= hit.t_upper && hit.t_upper <= ray.max_t(),
        "{what} {hit:?}"
    );
    assert!(
        (hit.normal.length() - 1.0).abs() < 1e-9 || hit.normal == DVec3::ZERO,
        "{what} {hit:?}"
    );
    if hit.is_certain {
        let width = (hit.t_upper - hit.t_lower) * ray.direction().length();
        let at = distance_of(shape, pose, ray.at(hit.t_upper));
        // Of what is infinitely thin the bracket has both sides.
        assert!(at <= off + width, "{what}: {ray:?} {hit:?} is {at} off");
        assert!(width <= 1e-6 * far, "{what}: {ray:?} {hit:?} is {width} wide");
    } else {
        // What grazes is near, somewhere in the bracket.
        let near = (0..=64)
            .map(|k| hit.t_lower + (hit.t_upper.min(end) - hit.t_lower) * f64::from(k) / 64.0)
            .map(|t| distance_of(shape, pose, ray.at(t)))
            .fold(distance_of(shape, pose, ray.at(hit.t)), f64::min);
        assert!(near <= 1e-8 * far, "{what}: {ray:?} {hit:?} grazes at {near}");
    }
    Some(hit.is_certain)
}

#[test]
fn hits_and_misses_are_those_of_points_of_the_ray() {
    let mut random = Random::seeded(5);
    let mut counts = std::collections::BTreeMap::<&str, [u32; 3]>::new();
    for round in 0..40 {
        let s = [1.0, 1e-3, 1e-6, 1e3][round % 4];
        let centre = random.vector() * [0.0, 1.0, 1e6][round % 3];
        for (what, shape) in shapes(&mut random, s) {
            let pose = random.pose(centre);
            for kind in 0..5 {
                let target = centre + random.vector() * s * 0.8;
                let from = match kind {
                    0 => centre + random.vector() * s,
                    1 => centre + random.vector() * s * 1e3,
                    _ => centre + random.vector() * s * 4.0,
                };
                let direction = match kind {
                    2 => [DVec3::X, -DVec3::Y, DVec3::Z][round % 3],
                    3 => (target - from) * 1e-3,
                    _ => target - from,
                };
                let max_t = if kind == 4 { 0.75 } else { f64::INFINITY };
                let ray = Ray::new(from, direction, max_t).unwrap();
                let found = judge(what, (&shape, &pose), &ray, s);
                let slot = found.map_or(0, |is_certain| if is_certain { 1 } else { 2 });
                counts.entry(what).or_default()[slot] += 1;
            }
        }
    }
    for (what, [missed, met, grazed]) in counts {
        let few = if what.contains("triangle") || what.contains("flat") { 1 } else { 5 };
        assert!(missed >= few && met >= few && grazed <= 4, "{what}: {missed} {met} {grazed}");
    }
}

#[test]
fn no_ray_passes_between_the_triangles_of_a_closed_mesh() {
    let mut random = Random::seeded(11);
    for round in 0..6 {
        let s = [1.0, 1e-6, 1e3][round % 3];
        let (vertices, triangles) = ball_mesh(s);
        let shape = Shape::mesh(vertices.clone(), triangles.clone()).unwrap();
        let pose = if round < 2 { Pose::IDENTITY } else { random.pose(random_offset(round)) };
        let posed = PosedShape { shape: &shape, pose: &pose };
        for [a, b, _] in triangles {
            let (p, q) = (vertices[a as usize], vertices[b as usize]);
            for target in [p, q, (p + q) * 0.5, p * 0.25 + q * 0.75] {
                let target = pose.apply(target);
                let out = (target - pose.translation()) * 3.0;
                // From outside to the point and on through the ball; and from its middle.
                for (from, direction) in [(target + out, -out), (pose.translation(), out)] {
                    let hit = first_hit(&Ray::endless(from, direction).unwrap(), posed);
                    let hit =
                        hit.unwrap_or_else(|| panic!("{from} {direction} passes round {round}"));
                    let point = from + direction * hit.t;
                    assert!(point.distance(target) <= 1e-9 * (s + target.length()), "{hit:?}");
                }
            }
        }
    }
}

fn random_offset(round: usize) -> DVec3 {
    DVec3::new(1.0, -2.0, 0.5) * [1.0, 1e3][round % 2]
}

#[test]
fn rays_along_faces_and_through_edges_and_vertices_of_a_box_are_not_missed() {
    let cuboid = Shape::cuboid(DVec3::ONE).unwrap();
    let as_hull = Shape::hull(cuboid.as_polytope().unwrap().vertices().to_vec()).unwrap();
    for shape in [&cuboid, &as_hull] {
        let cast = |from: [f64; 3], direction: [f64; 3]| {
            let ray = Ray::endless(DVec3::from(from), DVec3::from(direction)).unwrap();
            first_hit(&ray, PosedShape { shape, pose: &Pose::IDENTITY })
        };
        // In a face, along an edge, into a vertex, across an edge.
        for (from, direction, t) in [
            ([-5.0, 0.25, 1.0], [1.0, 0.0, 0.0], 4.0),
            ([-5.0, 1.0, 1.0], [1.0, 0.0, 0.0], 4.0),
            ([-5.0, -5.0, -5.0], [1.0, 1.0, 1.0], 4.0),
            ([-2.0, 0.0, 0.0], [1.0, 1.0, 0.0], 1.0),
        ] {
            let hit = cast(from, direction).unwrap();
            assert!(hit.t_lower <= t && t <= hit.t_upper, "{from:?}: {hit:?}");
        }
        assert_eq!(cast([-5.0, 0.0, 1.0 + 1e-9], [1.0, 0.0, 0.0]), None);
        assert_eq!(cast([5.0, 0.0, 0.0], [1.0, 0.0, 0.0]), None);
        let inside = cast([0.5, 0.0, 0.0], [0.0, 0.0, 2.0]).unwrap();
        assert!(inside.t == 0.0 && inside.is_certain && inside.normal == DVec3::ZERO);
        let on_it = cast([1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]).unwrap();
        assert!(on_it.t_lower == 0.0 && on_it.is_certain && on_it.t_upper < 1e-12);
    }
}

#[test]
fn a_ray_that_begins_in_a_corner_of_a_mesh_meets_it_at_zero_without_a_sign() {
    let corners = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    let mesh = Shape::mesh(corners, vec![[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]).unwrap();
    for k in 0..8 {
        let sign = |bit: u32| if k >> bit & 1 == 0 { 1.0 } else { -1.0 };
        for direction in [DVec3::new(1.3, 1.7, 0.7), DVec3::X] {
            let direction = direction * DVec3::new(sign(0), sign(1), sign(2));
            let ray = Ray::endless(DVec3::ZERO, direction).unwrap();
            let posed = PosedShape { shape: &mesh, pose: &Pose::IDENTITY };
            for_each_hit(&ray, posed, f64::INFINITY, &mut |hit| {
                let has_sign = [hit.t, hit.t_lower].map(f64::is_sign_negative);
                assert_eq!(has_sign, [false; 2], "{direction}: {hit:?}");
                f64::INFINITY
            });
        }
    }
}

#[test]
fn a_bad_ray_is_refused_with_its_value() {
    let refused = Ray::endless(DVec3::new(0.0, f64::NAN, 0.0), DVec3::X);
    assert!(matches!(refused, Err(RayError::BadOrigin { value }) if value.is_nan()));
    let refused = Ray::endless(DVec3::splat(2e37), DVec3::X);
    assert_eq!(refused, Err(RayError::BadOrigin { value: 2e37 }));
    for direction in [DVec3::ZERO, DVec3::NAN, DVec3::X * f64::INFINITY, DVec3::X * 1e-101] {
        let refused = Ray::endless(DVec3::ZERO, direction).unwrap_err();
        assert!(matches!(refused, RayError::BadDirection { .. }), "{direction}: {refused}");
    }
    assert_eq!(Ray::new(DVec3::ZERO, DVec3::X, -1.0), Err(RayError::BadEnd { max_t: -1.0 }));
    assert!(Ray::new(DVec3::ZERO, DVec3::X, f64::NAN).is_err());
}

#[test]
fn no_part_is_met_before_the_first_hit_though_another_is_surely_met() {
    // In the plane of a face, from t = 1 on; a part that is surely met from 1.5 on.
    let ray = Ray::endless(DVec3::Y, DVec3::X).unwrap();
    let at = |x, y| Pose::from_translation(DVec3::new(x, y, 0.0)).unwrap();
    let long = Shape::cuboid(DVec3::new(2.0, 1.0, 1.0)).unwrap();
    let small = Shape::cuboid(DVec3::splat(0.25)).unwrap();
    let compound = Shape::compound(vec![(long, at(3.0, 0.0)), (small, at(1.75, 1.0))]).unwrap();
    let corners = [
        [1.0, 1.0, -1.0],
        [1.0, 1.0, 1.0],
        [5.0, 1.0, 0.0],
        [1.5, 0.0, -1.0],
        [1.5, 0.0, 1.0],
        [1.5, 3.0, 0.0],
    ];
    let corners = corners.map(DVec3::from_array).to_vec();
    let mesh = Shape::mesh(corners, vec![[0, 1, 2], [3, 4, 5]]).unwrap();
    for shape in [&compound, &mesh] {
        let hit = first_hit(&ray, PosedShape { shape, pose: &Pose::IDENTITY }).unwrap();
        assert!(hit.t_lower <= 1.0 && hit.t <= 1.0 && !hit.is_certain, "{hit:?}");
    }
}

/// Sizes, and lengths of directions, of which products underflow; and some of which they do not.
const TINY: [[f64; 2]; 12] = [
    [1.0, 1.0],
    [1e-20, 1e-30],
    [1e-57, 1e-100],
    [1e-58, 1e-100],
    [1e-64, 1e-100],
    [1e-70, 1e-100],
    [1e-100, 1e-100],
    [1e-150, 1e-50],
    [1e-100, 1e-49],
    [1e-170, 1.0],
    [1e-90, 1.0],
    [1e-60, 1e100],
];

#[test]
fn tiny_shapes_and_directions_have_no_false_hit_and_no_bracket_without_the_truth() {
    let mut certain = 0;
    for [r, length] in TINY {
        let corner = |x: f64, y: f64| DVec3::new(0.0, x, y) * (4.0 * r);
        let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(0.0, 1.0)];
        let side = 0.75f64.sqrt();
        for (shape, depth) in [
            (Shape::sphere(r), side),
            (Shape::capsule(r, r), side),
            (Shape::cylinder(r, r), side),
            (Shape::cuboid(DVec3::splat(r)), 1.0),
            (Shape::hull(vec![DVec3::ZERO]).and_then(|point| point.rounded(r)), side),
            (Shape::triangle(corners), 0.0),
            (Shape::mesh(corners.to_vec(), vec![[0, 1, 2]]), 0.0),
            (Shape::half_space(DVec3::X, r), -1.0),
        ] {
            let shape = shape.unwrap();
            let posed = PosedShape { shape: &shape, pose: &Pose::IDENTITY };
            let ray = |side: f64, along: f64| {
                let from = DVec3::new(1e4 * r, side * r, 0.0);
                Ray::endless(from, DVec3::X * (along * length)).unwrap()
            };
            // Past it at a distance of a hundred, unless it has no end; and away from it.
            let beside = if shape.is_bounded() { ray(101.0, -1.0) } else { ray(0.0, 1.0) };
            for missed in [beside, ray(0.0, 1.0)] {
                let found = first_hit(&missed, posed);
                assert!(
                    found.is_none_or(|hit| !hit.is_certain),
                    "{r:e} {length:e} {shape:?} {found:?}"
                );
            }
            let truth = if shape.is_bounded() { 1e4 - depth } else { 1e4 - 1.0 } * r / length;
            let Some(hit) = first_hit(&ray(0.5, -1.0), posed) else {
                panic!("{r:e} {length:e} {shape:?}")
            };
            let holds = hit.t_lower <= truth && truth <= hit.t_upper;
            assert!(holds, "{r:e} {length:e} {shape:?}: {truth:e} {hit:?}");
            if hit.is_certain {
                assert!(
                    (hit.normal.length() - 1.0).abs() < 1e-12,
                    "{r:e} {length:e} {shape:?} {hit:?}"
                );
                certain += 1;
            }
        }
    }
    assert!(certain > 50, "{certain}");
}

#[test]
fn what_is_far_beyond_any_scene_is_never_a_certain_hit_that_is_none() {
    let hit = |shape: &Shape, place: DVec3, ray: &Ray| {
        let pose = Pose::from_translation(place).unwrap();
        first_hit(ray, PosedShape { shape, pose: &pose })
    };
    let sphere = Shape::sphere(1.5e105).unwrap();
    let short = Ray::new(DVec3::ZERO, DVec3::X * 1e49, 1.0).unwrap();
    assert!(hit(&sphere, DVec3::X * 3e105, &short).is_none_or(|hit| !hit.is_certain));
    let far = Shape::segment(DVec3::X * 3e154, DVec3::X * 3.1e154).unwrap().rounded(1.5e154);
    let endless = Ray::endless(DVec3::ZERO, DVec3::X).unwrap();
    let found = hit(&far.unwrap(), DVec3::ZERO, &endless);
    assert!(found.is_some_and(|hit| !hit.is_certain || hit.t_lower > 1e154), "{found:?}");
    let corners = [DVec3::ZERO, DVec3::X, DVec3::Y].map(|corner| corner * 1e200);
    let mesh = Shape::mesh(corners.to_vec(), vec![[0, 1, 2]]).unwrap();
    let across = Ray::endless(DVec3::new(1.0, 1.0, 1.0), -DVec3::Z).unwrap();
    assert!(hit(&mesh, DVec3::ZERO, &across).is_some());
}
