//! Pairs with cylinders, cones or ellipsoids within rounding of touching: what is left undecided is a matter of the pair alone.

use super::PosedSupport;
use super::scenes::Draw;
use super::within::found;
use dcd_geom::glam::{DQuat, DVec3};
use dcd_geom::{Object, Pair, Pose, Scene, Shape};
use dcd_gjk::{Overlap, Verdict, certified};
use dcd_simd::Path;

/// One that is convex, with an exact method or without.
fn convex(draw: &mut Draw) -> Shape {
    let [x, y, z] = [(); 3].map(|()| 0.05 + 0.5 * draw.unit().abs());
    let shape = match (draw.unit().abs() * 8.0) as u32 {
        0 | 1 => Shape::cylinder(x, y),
        2 => Shape::cone(x, y),
        3 => Shape::ellipsoid(DVec3::new(x, y, z)),
        4 => Shape::sphere(x),
        5 => Shape::capsule(x, y),
        6 => Shape::hull((0..12).map(|_| draw.vector() * 0.5).collect()),
        _ => Shape::cuboid(DVec3::new(x, y, z)),
    };
    let swept = if draw.unit() < -0.5 { 0.03 } else { 0.0 };
    shape.unwrap().swept(swept).unwrap()
}

/// One of those, or a compound of up to four.
fn shape(draw: &mut Draw) -> Shape {
    if draw.unit() < 0.0 {
        return convex(draw);
    }
    let parts = (0..1 + (draw.unit().abs() * 4.0) as u32)
        .map(|_| (convex(draw), Pose::new(draw.turn(), draw.vector() * 0.5).unwrap()));
    Shape::compound(parts.collect()).unwrap()
}

/// Two shapes, of which the second goes a way, and how far.
struct Course {
    first: PosedSupport,
    second: PosedSupport,
    way: DVec3,
}

impl Course {
    fn at(&self, far: f64) -> PosedSupport {
        let pose = self.second.pose;
        let there = pose.with_translation(pose.translation() + self.way * far).unwrap();
        PosedSupport { shape: self.second.shape.clone(), pose: there }
    }

    /// Of the pair alone, in either order.
    fn verdict(&self, far: f64) -> Verdict<()> {
        let second = self.at(far);
        let verdict = certified::overlap_of(self.first.placed(), second.placed()).0;
        assert_eq!(verdict, certified::overlap_of(second.placed(), self.first.placed()).0);
        verdict
    }

    /// Places round those where the verdict changes, if it does.
    fn places(&self) -> Option<Vec<f64>> {
        let flip = |is_near: &dyn Fn(Verdict<()>) -> bool| {
            let (mut near, mut far) = (0.0, 8.0);
            if !is_near(self.verdict(near)) || is_near(self.verdict(far)) {
                return None;
            }
            while far - near > f64::EPSILON * far {
                let middle = f64::midpoint(near, far);
                if middle == near || middle == far {
                    break;
                }
                if is_near(self.verdict(middle)) { near = middle } else { far = middle }
            }
            Some(near)
        };
        let touching = flip(&|verdict| verdict == Verdict::Touching(()))?;
        let open = flip(&|verdict| verdict != Verdict::Apart)?;
        let step = f64::EPSILON * (open + self.first.pose.translation().abs().max_element());
        let beside = (-8..=8).flat_map(|k| [touching, open].map(|at| at + f64::from(k) * step));
        let between = (1..8).map(|k| touching + (open - touching) * f64::from(k) / 8.0);
        Some(beside.chain(between).collect())
    }

    /// Compares what the lanes make of those places with the verdicts of the pairs alone; how many are undecided.
    fn check(&self, is_first: bool) -> Option<usize> {
        let places = self.places()?;
        let count = places.len() as u32;
        let moved = places.iter().map(|&far| Object::new(1, self.at(far).pose));
        let own = Object::new(0, self.first.pose);
        let objects: Vec<_> = if is_first {
            [own].into_iter().chain(moved).collect()
        } else {
            moved.chain([own]).collect()
        };
        let shapes = vec![self.first.shape.clone(), self.second.shape.clone()];
        let scene = Scene::new(shapes, objects).unwrap();
        let pairs: Vec<_> = match is_first {
            true => (1..=count).map(|k| Pair::new(0, k)).collect(),
            false => (0..count).map(|k| Pair::new(k, count)).collect(),
        };
        let due = |is_due: &dyn Fn(Verdict<()>) -> bool| -> Vec<Pair> {
            let due = pairs.iter().zip(&places).filter(|&(_, &far)| is_due(self.verdict(far)));
            due.map(|(&pair, _)| pair).collect()
        };
        let touching = due(&|verdict| matches!(verdict, Verdict::Touching(())));
        let open = due(&|verdict| matches!(verdict, Verdict::Undecided(_)));
        for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
            let (contacts, report) = found(&Overlap::on(path), &scene, &pairs);
            let found: Vec<_> = contacts.iter().map(|contact| contact.pair).collect();
            assert_eq!(found, touching, "{path:?} {:?} {:?}", self.first, self.second);
            let mut left: Vec<_> = report.undecided().iter().map(|left| left.pair).collect();
            left.sort_unstable();
            assert_eq!(left, open, "{path:?} {:?} {:?}", self.first, self.second);
        }
        Some(open.len())
    }
}

#[test]
fn lanes_leave_undecided_what_the_pair_alone_is() {
    let mut draw = Draw::seeded(107);
    let mut open = 0;
    for round in 0..150 {
        let origin = draw.vector() * [0.0, 1.0, 1e3][round % 3];
        let (one, other) = (shape(&mut draw), shape(&mut draw));
        let turns = [(); 2].map(|()| draw.turn());
        let course = Course {
            first: PosedSupport::new(one, turns[0], origin),
            second: PosedSupport::new(other, turns[1], origin),
            way: draw.vector().normalize(),
        };
        open += course.check(round % 2 == 0).unwrap_or(0);
    }
    assert!(open > 300, "{open}");
}

/// An axis of f32 parts these by less than what the search of f64 finds.
#[test]
fn an_axis_of_the_lanes_decides_nothing_within_rounding() {
    let origin = DVec3::new(-0.6987248596304387, -0.9686213642823425, 0.041596146606253104);
    let cuboid =
        Shape::cuboid(DVec3::new(0.5190359574240699, 0.20617111100674473, 0.3258494510919567));
    let turn = DQuat::from_xyzw(
        0.9113641626158597,
        0.31972563066141274,
        0.14919933037034405,
        -0.21196802592536437,
    );
    let cylinder = Shape::cylinder(0.3496280031660944, 0.18541537629079458).unwrap();
    let course = Course {
        first: PosedSupport::at(&cuboid.unwrap(), origin),
        second: PosedSupport::new(cylinder, turn, origin),
        way: DVec3::new(-0.9994184275606083, 0.03269141527437757, -0.009699382435969142),
    };
    assert!(course.check(true).unwrap() > 0);
}
