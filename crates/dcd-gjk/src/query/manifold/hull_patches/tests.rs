use super::super::corners::Corners;
use super::super::cuboid_faces::tests::Draw;
use super::super::hull_pair::{
    self,
    tests::{shape, turn, vector},
};
use super::super::{Manifold, ManifoldContacts, ManifoldPoint};
use super::rows::{Kept, Slot, Slots};
use super::*;
use crate::query::MeasureAt;
use crate::{Accuracy, ContactList, Depths, PosedShape, Verdict};
use dcd_geom::glam::DQuat;
use dcd_geom::{List, Pair, Pose, Shape};
use dcd_simd::{Kernel, Path, dispatch_on};

/// Two shapes that touch.
struct Two {
    shapes: [Shape; 2],
    poses: [Pose; 2],
    found: FoundDepth,
    /// Whether no corner is as far, deep or wide as another but for rounding.
    is_general: bool,
}

impl Two {
    fn sides(&self) -> [PosedShape<'_>; 2] {
        [0, 1].map(|k| PosedShape { shape: &self.shapes[k], pose: &self.poses[k] })
    }

    fn pair(&self, number: usize) -> FoundPair<'_> {
        FoundPair { found: self.found, sides: self.sides(), number }
    }

    fn mirrored(&self, number: usize) -> FoundPair<'_> {
        let [a, b] = self.sides();
        FoundPair { found: self.found.mirrored(), sides: [b, a], number }
    }
}

/// Hulls, prisms, triangles and capsules at random, and such whose faces are nearly parallel.
fn touching(seed: u64, count: usize) -> Vec<Two> {
    let mut draw = Draw(seed);
    let mut list = Vec::new();
    for k in 0..count {
        let shapes = [shape(&mut draw, k), shape(&mut draw, k / 6)];
        let turned = turn(&mut draw);
        let tilt = DQuat::from_scaled_axis(vector(&mut draw) * [0.0, 1e-9, 1e-3, 0.2][k / 25 % 4]);
        let is_general = k % 2 == 0 || k / 25 % 4 == 3;
        let other = if k % 2 == 0 { turn(&mut draw) } else { turned * tilt };
        let far = vector(&mut draw) * 10.0;
        let place = far + turned * (vector(&mut draw) * 0.6);
        let poses = [Pose::new(turned, far).unwrap(), Pose::new(other, place).unwrap()];
        let [a, b] = [0, 1].map(|k| PosedShape { shape: &shapes[k], pose: &poses[k] });
        if crate::certified::overlap_of(a, b).0 != Verdict::Touching(()) {
            continue;
        }
        let found = Depths.measure_at(Accuracy::F64, a, b, &mut Default::default());
        let Verdict::Touching(depth) = found else { panic!("{k}") };
        let found = FoundDepth { depth, farthest: None };
        list.push(Two { shapes, poses, found, is_general });
    }
    list
}

/// The manifolds of pairs, eight after eight; none of those that are left.
fn measured(path: Path, pairs: &[FoundPair<'_>]) -> Vec<Option<Manifold>> {
    let (mut packet, mut corners) = (Packet::default(), Corners::default());
    let mut contacts = ManifoldContacts::default();
    pairs.iter().for_each(|_| contacts.push_pair(Pair::new(0, 1)));
    for eight in pairs.chunks(PAIRS) {
        let (packet, corners, contacts) = (&mut packet, &mut corners, &mut contacts);
        dispatch_on(path, WriteSeveral { pairs: eight, packet, corners, contacts });
    }
    let sets = contacts.contacts(0..contacts.len()).map(|contact| contact.answer);
    sets.map(|set| set.first().copied()).collect()
}

/// The area that points span, square to the normal: of a triangle or a quadrangle of them, in any order.
fn area(found: &Manifold) -> f64 {
    let at = |p: &ManifoldPoint| p.point_a;
    let across = |p, q, r, s| (at(p) - at(q)).cross(at(r) - at(s)).dot(found.normal).abs() / 2.0;
    match found.points() {
        [p, q, r] => across(p, q, r, q),
        [p, q, r, s] => {
            let quadrangles = [across(p, q, r, s), across(p, r, q, s), across(p, s, q, r)];
            let triangles = [across(p, q, r, q), across(p, q, s, q), across(p, r, s, r)];
            let last = across(q, r, s, r);
            // The diagonals of a convex one make its area; of others these are less than the largest triangle.
            let all = quadrangles.into_iter().chain(triangles).chain([last]);
            all.fold(0.0, f64::max)
        }
        _ => 0.0,
    }
}

/// How far a point is outside of a shape with faces, metres; `None` of others.
fn outside(point: DVec3, side: PosedShape<'_>) -> Option<f64> {
    let polytope = side.shape.as_polytope()?;
    let local = side.pose.rotation().transpose() * (point - side.pose.translation());
    let facets = polytope.facets();
    let beyond = facets.facets().iter().map(|facet| {
        let corner = polytope.vertices()[facets.corners(facet)[0] as usize];
        facet.normal.dot(local - corner) - polytope.swept_radius()
    });
    (polytope.vertices().len() > 2).then(|| beyond.fold(f64::NEG_INFINITY, f64::max))
}

#[test]
fn eight_pairs_have_manifolds_as_good_as_pair_by_pair() {
    let list = touching(21, 20_000);
    let pairs: Vec<_> = (0..).zip(&list).map(|(number, two)| two.pair(number)).collect();
    let all = measured(Path::best(), &pairs);
    let (mut points, mut counts, mut more) = (Default::default(), [0; 5], 0);
    let (mut others, mut same) = (0, 0);
    for (k, (two, found)) in list.iter().zip(&all).enumerate() {
        let mut due = Manifold::default();
        let [a, b] = two.sides();
        let is_swapped = order::is_swapped(a, b);
        let (known, sides) =
            if is_swapped { (two.found.mirrored(), [b, a]) } else { (two.found, [a, b]) };
        if !hull_pair::write(&known, sides, &mut points, &mut due) {
            continue;
        }
        if is_swapped {
            due.mirror();
        }
        let found = found.as_ref().unwrap();
        assert_eq!(found.normal, due.normal, "{k}");
        assert_eq!(found.points()[0].depth, due.points()[0].depth, "{k}");
        assert!((found.error_bound - due.error_bound).abs() <= 1e-9, "{k}");
        assert!(area(found) >= area(&due) - 1e-8, "{k} {found:?} {due:?}");
        for point in found.points() {
            for (point, side) in [point.point_a, point.point_b].into_iter().zip(two.sides()) {
                let outside = outside(point, side).unwrap_or(0.0);
                assert!(outside <= 1e-8, "{k} {outside} {found:?}");
            }
        }
        if !two.is_general {
            continue;
        }
        counts[due.points().len()] += 1;
        assert!(found.points().len() >= due.points().len(), "{k} {found:?} {due:?}");
        more += usize::from(found.points().len() > due.points().len());
        let is_near = |p: &ManifoldPoint, q: &ManifoldPoint| {
            p.point_a.distance(q.point_a) < 1e-9
                && p.point_b.distance(q.point_b) < 1e-9
                && (p.depth - q.depth).abs() < 1e-9
        };
        assert!(is_near(&found.points()[0], &due.points()[0]), "{k} {found:?} {due:?}");
        let is_same = |p: &ManifoldPoint, q| is_near(p, q) && p.features == q.features;
        for point in due.points() {
            match found.points().iter().any(|other| is_same(point, other)) {
                true => same += 1,
                false => others += 1,
            }
        }
    }
    // Another corner stands where it adds more to the area than one on the other side of the line does; and where an edge, a side
    // and the surface meet, either may name the corner.
    assert!(others < same / 10, "{same} {others}");
    assert!(counts[1..].iter().all(|&count| count > 50), "{counts:?}");
    assert!(more > 0 && more < counts[3], "{more} {counts:?}");
}

#[test]
fn eight_pairs_have_the_same_bits_on_every_path_and_in_either_order() {
    let list = touching(22, 3_000);
    let pairs: Vec<_> = (0..).zip(&list).map(|(number, two)| two.pair(number)).collect();
    let mirrored: Vec<_> = (0..).zip(&list).map(|(number, two)| two.mirrored(number)).collect();
    let due = measured(Path::Portable, &pairs);
    assert!(due.iter().flatten().count() > 500);
    for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
        assert_eq!(measured(path, &pairs), due, "{path:?}");
        let mut back = measured(path, &mirrored);
        back.iter_mut().flatten().for_each(Manifold::mirror);
        assert_eq!(back, due, "{path:?}");
    }
}

#[test]
fn a_pair_has_the_same_manifold_whichever_others_are_beside_it() {
    let list = touching(23, 1_000);
    let pairs: Vec<_> = (0..).zip(&list).map(|(number, two)| two.pair(number)).collect();
    let due = measured(Path::best(), &pairs);
    for (pair, due) in pairs.iter().zip(&due) {
        assert_eq!(measured(Path::best(), &[FoundPair { number: 0, ..*pair }])[0], *due);
    }
}

/// Two shapes at those places, of the depth that they have.
fn at(shapes: [Shape; 2], places: [DVec3; 2]) -> Two {
    let poses = places.map(|place| Pose::from_translation(place).unwrap());
    let [a, b] = [0, 1].map(|k| PosedShape { shape: &shapes[k], pose: &poses[k] });
    let found = Depths.measure_at(Accuracy::F64, a, b, &mut Default::default());
    let Verdict::Touching(depth) = found else { panic!() };
    Two { shapes, poses, found: FoundDepth { depth, farthest: None }, is_general: false }
}

/// A prism over a triangle, 1 high.
fn prism() -> Shape {
    let base = [DVec3::ZERO, DVec3::X * 2.0, DVec3::Y * 2.0];
    Shape::hull(base.into_iter().chain(base.map(|corner| corner + DVec3::Z)).collect()).unwrap()
}

#[test]
fn of_level_faces_the_same_clips_in_either_order() {
    let two = at([prism(), prism()], [DVec3::ZERO, DVec3::new(0.25, 0.25, 0.75)]);
    let mut back = measured(Path::best(), &[two.mirrored(0)])[0].unwrap();
    back.mirror();
    let found = measured(Path::best(), &[two.pair(0)])[0].unwrap();
    assert_eq!((found, found.points().len()), (back, 3));
}

#[test]
fn a_face_with_a_sharp_corner_is_left_to_the_general_way() {
    let needle = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 5e-5, 0.0)];
    let shapes = [Shape::triangle(needle).unwrap(), prism()];
    let two = at(shapes, [DVec3::new(-0.2, 0.1, 0.95), DVec3::ZERO]);
    assert_eq!(measured(Path::best(), &[two.pair(0), two.mirrored(1)]), [None, None]);
}

#[test]
fn of_corners_in_line_the_ends_are_kept() {
    struct Choose<'a>(&'a Slots, &'a mut Kept);
    impl Kernel for Choose<'_> {
        type Output = ();
        #[inline(always)]
        fn run<L: Lanes>(self, l: L) {
            let Self(slots, kept) = self;
            kept.choose(l, slots, 4, l.splat_d(1e-9));
        }
    }
    let (mut slots, mut kept) = (Slots::default(), Kept::default());
    let depths = [f64::NEG_INFINITY, 2.0, 2.0, 2.0];
    for (slot, (x, depth)) in [9.0, 0.0, -1.0, 3.0].into_iter().zip(depths).enumerate() {
        slots.0[slot] = Slot { x: [x; 8], y: [2.0 * x; 8], depth: [depth; 8], by: [0.0; 8] };
    }
    dispatch_on(Path::best(), Choose(&slots, &mut kept));
    let found = [0, 1, 2].map(|k| kept.slots[k][5]);
    assert_eq!((found, kept.count[5]), ([1.0, 3.0, 2.0], 3.0));
}
