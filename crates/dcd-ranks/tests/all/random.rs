//! Random courses of random scenes, most of them degenerate: shapes of every kind that ranks exchange, in a
//! plane, on a line, on a lattice, at one place, far away; with margins; that move, and are dealt out anyhow.

use dcd_geom::glam::{DQuat, DVec3};
use dcd_geom::{Object, Pose, Scene, Shape};
use dcd_pipeline::{AnyPipeline, Par, Precision, Question};
use dcd_ranks::threads::{self, ThreadRank};
use dcd_ranks::{Body, RankScene, Share, Transport, sort_contacts};

/// Numbers from a seed (SplitMix64).
#[derive(Clone)]
struct Numbers(u64);

impl Numbers {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, count: u64) -> u64 {
        self.bits() % count
    }

    /// In −1 … 1.
    fn side(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    fn point(&mut self) -> DVec3 {
        let (x, y) = (self.side(), self.side());
        DVec3::new(x, y, self.side())
    }
}

fn shape(numbers: &mut Numbers) -> Shape {
    let size = [0.01, 0.3, 0.3, 0.3, 3.0][numbers.below(5) as usize];
    let mut points = |count: u64| (0..count).map(|_| numbers.point() * size).collect::<Vec<_>>();
    let nine = points(9);
    let shape = match numbers.below(10) {
        0 => Shape::hull((0..4 + numbers.below(20)).map(|_| numbers.point() * size).collect()),
        1 => Shape::sphere(size),
        2 => Shape::cuboid(numbers.point().abs() * size),
        3 => Shape::capsule(size, 0.3 * size),
        4 => Shape::segment(nine[0], nine[1]),
        5 => Shape::triangle([nine[0], nine[1], nine[2]]),
        6 => Shape::cylinder(size, 0.7 * size),
        7 => Shape::cone(size, 0.7 * size),
        8 => Shape::mesh(nine, vec![[0, 1, 2], [2, 3, 4], [4, 5, 6], [6, 7, 8], [8, 0, 3]]),
        _ => {
            let parts = [Shape::sphere(0.4 * size), Shape::hull(nine)].map(Result::unwrap);
            let places = [0.0, 0.5].map(|x| Pose::from_translation(DVec3::X * x * size).unwrap());
            Shape::compound(parts.into_iter().zip(places).collect())
        }
    };
    let radius = [0.0, 0.0, 0.1][numbers.below(3) as usize];
    shape.and_then(|shape| shape.swept(radius)).unwrap()
}

/// Where the objects of a course are: a kind of place, and how far it reaches.
#[derive(Clone, Copy, Debug)]
struct Places {
    kind: u64,
    width: f64,
    off: DVec3,
}

impl Places {
    fn draw(numbers: &mut Numbers) -> Self {
        let width = [0.0, 1.0, 6.0, 6.0, 6.0, 1e5][numbers.below(6) as usize];
        let off = numbers.point() * [0.0, 0.0, 1e4][numbers.below(3) as usize];
        Self { kind: numbers.below(4), width, off }
    }

    fn pose(self, numbers: &mut Numbers) -> Pose {
        let p = numbers.point() * self.width;
        let spot = match self.kind {
            0 => p,
            1 => DVec3::new(p.x, p.y, 0.0),
            2 => DVec3::new(p.x, p.x, p.x),
            _ => (p * 2.0).round() * 0.5,
        };
        let axis = numbers.point().try_normalize().unwrap_or(DVec3::X);
        let angle = [0.0, numbers.side() * 3.0][numbers.below(2) as usize];
        Pose::new(DQuat::from_axis_angle(axis, angle), self.off + spot).unwrap()
    }
}

struct Course {
    seed: u64,
    size: usize,
    shapes: Vec<Shape>,
    /// For each object its shape, and for each frame its pose.
    objects: Vec<(u32, Vec<Pose>)>,
    question: Question,
}

impl Course {
    fn draw(seed: u64) -> Self {
        let mut numbers = Numbers(seed);
        let size = 1 + numbers.below(9) as usize;
        let shapes: Vec<Shape> = (0..1 + numbers.below(30)).map(|_| shape(&mut numbers)).collect();
        let places = Places::draw(&mut numbers);
        let frames = 1 + numbers.below(5) as usize;
        let objects = (0..numbers.below(250))
            .map(|_| {
                let shape = numbers.below(shapes.len() as u64) as u32;
                let mut pose = places.pose(&mut numbers);
                let still = numbers.below(2) == 0;
                let poses = (0..frames).map(|_| {
                    if !still {
                        pose = places.pose(&mut numbers);
                    }
                    pose
                });
                (shape, poses.collect())
            })
            .collect();
        let margin = [0.0, 0.0, 0.25][numbers.below(3) as usize];
        let question = Question::Overlap { precision: Precision::Certified, margin };
        Self { seed, size, shapes, objects, question }
    }

    fn frames(&self) -> usize {
        self.objects.first().map_or(1, |(_, poses)| poses.len())
    }

    /// And how many pairs are undecided.
    fn contacts_of_one_machine(&self, frame: usize) -> (Vec<[u64; 2]>, usize) {
        let objects = self.objects.iter().map(|(shape, poses)| Object::new(*shape, poses[frame]));
        let scene = Scene::new(self.shapes.clone(), objects).unwrap();
        let mut pipeline = AnyPipeline::new(self.question).unwrap();
        let step = pipeline.step(&scene, Par::Serial);
        let mut contacts: Vec<[u64; 2]> =
            step.contacts().map(|(i, j)| [i, j].map(u64::from)).collect();
        contacts.sort_unstable();
        (contacts, step.report().undecided().len())
    }

    /// What this rank brings along, and then finds in each frame; and how many pairs it leaves undecided.
    fn contacts_of_a_rank(&self, rank: &ThreadRank) -> Vec<(Vec<[u64; 2]>, usize)> {
        let mut numbers = Numbers(self.seed ^ 0xdea1);
        let dealt: Vec<usize> =
            self.objects.iter().map(|_| numbers.below(self.size as u64) as usize).collect();
        let own = (0u64..).zip(&self.objects).zip(&dealt);
        let own = own.filter(|(_, to)| **to == rank.rank());
        let bodies = own.map(|((name, (shape, poses)), _)| Body {
            // Names are far apart, and not in the order of anything.
            name: scattered(name),
            shape: *shape,
            pose: poses[0],
        });
        let shapes = (0u64..).zip(self.shapes.iter().cloned()).collect();
        let share = Share { shapes, bodies: bodies.collect() };
        let mut scene = RankScene::new(rank, share, self.question).unwrap();
        let mut found = Vec::new();
        for frame in 0..self.frames() {
            let names: Vec<u64> = scene.owned().map(|(name, _)| name).collect();
            for name in names {
                let (_, poses) = &self.objects[gathered(name) as usize];
                scene.set_pose(name, poses[frame]).unwrap();
            }
            scene.refresh(Par::Serial).unwrap();
            let step = scene.detect(Par::Serial).unwrap();
            scene.balance(step.load);
            let contacts = step.contacts.into_iter().map(|pair| {
                let [i, j] = pair.map(gathered);
                [i.min(j), i.max(j)]
            });
            found.push((sort_contacts(rank, contacts.collect()).contacts, step.undecided));
        }
        found
    }
}

/// A name of 64 bits for an index, and back: multiplication by an odd number modulo 2⁶⁴.
const ODD: u64 = 0x9e37_79b9_7f4a_7c15;

fn scattered(index: u64) -> u64 {
    index.wrapping_mul(ODD)
}

fn gathered(name: u64) -> u64 {
    // Newton's iteration doubles the bits of the inverse that are right.
    let inverse = (0..6).fold(1u64, |x, _| x.wrapping_mul(2u64.wrapping_sub(ODD.wrapping_mul(x))));
    name.wrapping_mul(inverse)
}

#[test]
fn random_courses_find_what_one_machine_finds() {
    let (mut pairs, mut largest) = (0, 0);
    for seed in 0..400 {
        let course = Course::draw(seed);
        let found = threads::run(course.size, |rank| course.contacts_of_a_rank(rank));
        for frame in 0..course.frames() {
            let of_ranks = || found.iter().map(|frames| &frames[frame]);
            let contacts: Vec<[u64; 2]> = of_ranks().flat_map(|(found, _)| found.clone()).collect();
            let (due, undecided) = course.contacts_of_one_machine(frame);
            assert_eq!(contacts, due, "seed {seed}, frame {frame}, {} ranks", course.size);
            assert_eq!(of_ranks().map(|(_, count)| count).sum::<usize>(), undecided, "seed {seed}");
            pairs += due.len();
            largest = largest.max(due.len());
        }
    }
    assert!(pairs > 100_000 && largest > 10_000, "{pairs} {largest}");
}
