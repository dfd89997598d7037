//! Mixed bodies that fall on a terrain, and a solver of velocities that pushes them apart by their manifolds.
//!
//! Sequential impulses (Catto 2006) without warm start: each point of each manifold takes back the speed at
//! which the two approach, and a part of its depth, and friction. No physics engine: bodies turn as spheres do.

use dcd_pipeline::prelude::*;

/// A frame's length, seconds.
const FRAME_TIME: f64 = 1.0 / 60.0;
/// Metres a second squared, along −z.
const GRAVITY: f64 = 9.81;
/// Coulomb's coefficient. No unit.
const FRICTION: f64 = 0.6;
/// How often the points of a frame are gone through. More: a stiffer pile, slower.
const ROUNDS: usize = 12;
/// The part of a depth that a frame takes back. No unit. Larger: jitter. Smaller: sinking.
const RECOVERY: f64 = 0.2;
/// The depth that is left alone, metres, so that what rests stays in contact.
const REST_DEPTH: f64 = 0.004;
/// The fastest that a depth is taken back, metres a second: deep ones do not explode.
const RECOVERY_SPEED: f64 = 2.0;
/// The part of its spin that a touching body keeps a frame: what rolls on a slope comes to rest.
const KEPT_SPIN: f64 = 0.9;
/// The part of its velocity that a touching body keeps a frame.
const KEPT_SPEED: f64 = 0.98;
/// The speed, metres a second, below which a touching body counts as resting, and a tenth of it stays.
const RESTING: f64 = 0.08;

/// The terrain's squares along a side, and half its width, metres.
const SQUARES: u32 = 64;

#[derive(Clone, Copy, Debug)]
struct Body {
    position: DVec3,
    rotation: DQuat,
    velocity: DVec3,
    spin: DVec3,
    /// 0 for the terrain.
    inverse_mass: f64,
    inverse_inertia: f64,
}

/// One point of a manifold, with what it has pushed so far in this frame.
struct Point {
    bodies: [usize; 2],
    arms: [DVec3; 2],
    normal: DVec3,
    bias: f64,
    pushed: f64,
    rubbed: DVec3,
}

/// The terrain is object 0.
pub struct World {
    scene: Scene,
    bodies: Vec<Body>,
    half_width: f64,
}

/// Drawn numbers (splitmix64).
struct Draw(u64);

impl Draw {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        low + (high - low) * ((z ^ z >> 31) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn vector(&mut self) -> DVec3 {
        DVec3::new(self.between(-1.0, 1.0), self.between(-1.0, 1.0), self.between(-1.0, 1.0))
    }
}

/// Height of the hills' formula, metres; the terrain is its triangles.
fn hills(x: f64, y: f64) -> f64 {
    0.5 * (0.35 * x).sin() * (0.3 * y).cos() + 0.02 * (x * x + y * y) / 10.0
}

impl World {
    /// So many bodies of seven kinds in loose layers above a terrain.
    pub fn new(count: usize, seed: u64) -> Result<Self, Box<dyn std::error::Error>> {
        let row = (1usize..).find(|row| 4 * row * row >= count).unwrap_or(1);
        let half_width = 0.8 * row as f64 + 6.0;
        let mut shapes = vec![terrain(half_width)?];
        shapes.extend(kinds()?);
        let mut draw = Draw(seed);
        let terrain = Object::new(0, Pose::IDENTITY).fixed();
        let (mut objects, mut bodies) = (vec![terrain], vec![Body::fixed()]);
        for k in 0..count {
            let shape = 1 + k % (shapes.len() - 1);
            let [x, y] = [k % row, k / row % row].map(|at| 1.6 * (at as f64 - 0.5 * row as f64));
            let layer = k / (row * row);
            let place = DVec3::new(x, y, hills(x, y) + 1.2 + 1.3 * layer as f64);
            let place = place + draw.vector() * 0.1;
            let turn = DQuat::from_scaled_axis(draw.vector() * 1.5);
            bodies.push(Body::new(place, turn, shapes[shape].reach()));
            objects.push(Object::new(shape as u32, Pose::new(turn, place)?));
        }
        Ok(Self { scene: Scene::new(shapes, objects)?, bodies, half_width })
    }

    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The speeds of all bodies' fastest points, metres a second.
    pub fn speeds(&self) -> impl Iterator<Item = f64> + '_ {
        let speed = |(k, body): (usize, &Body)| {
            body.velocity.length() + body.spin.length() * self.scene.shape(k).reach()
        };
        self.bodies.iter().enumerate().skip(1).map(speed)
    }

    /// How far the centre of the lowest body is above the terrain's triangles, metres.
    pub fn lowest_centre(&self) -> f64 {
        let above = |body: &Body| body.position.z - self.ground(body.position);
        self.bodies[1..].iter().map(above).fold(f64::INFINITY, f64::min)
    }

    /// The height of the terrain's triangle under a place.
    fn ground(&self, place: DVec3) -> f64 {
        let step = 2.0 * self.half_width / f64::from(SQUARES);
        let [u, v] = [place.x, place.y].map(|x| (x + self.half_width) / step);
        let corner = |u: f64, v: f64| hills(u * step - self.half_width, v * step - self.half_width);
        let (s, t) = (u.floor(), v.floor());
        let (du, dv) = (u - s, v - t);
        let (one, other) = (corner(s + 1.0, t), corner(s, t + 1.0));
        if du + dv <= 1.0 {
            let base = corner(s, t);
            base + (one - base) * du + (other - base) * dv
        } else {
            let top = corner(s + 1.0, t + 1.0);
            top + (other - top) * (1.0 - du) + (one - top) * (1.0 - dv)
        }
    }

    /// The next frame, by the manifolds of this one.
    pub fn advance(
        &mut self,
        manifolds: impl Iterator<Item = Contact<Manifold>>,
    ) -> Result<(), Box<dyn std::error::Error>> {
        for body in self.bodies.iter_mut().filter(|body| body.inverse_mass > 0.0) {
            body.velocity.z -= GRAVITY * FRAME_TIME;
        }
        let mut points = self.points(manifolds);
        for _ in 0..ROUNDS {
            for point in &mut points {
                self.push(point);
            }
        }
        let mut touching = vec![false; self.bodies.len()];
        for point in points.iter().filter(|point| point.pushed > 0.0) {
            point.bodies.into_iter().for_each(|k| touching[k] = true);
        }
        let mut poses = Vec::with_capacity(self.bodies.len());
        for ((body, touches), k) in self.bodies.iter_mut().zip(touching).zip(0..) {
            if touches {
                body.slow_down(self.scene.shape(k).reach());
            }
            body.position += body.velocity * FRAME_TIME;
            let turn = DQuat::from_scaled_axis(body.spin * FRAME_TIME);
            body.rotation = (turn * body.rotation).normalize();
            poses.push(Pose::new(body.rotation, body.position)?);
        }
        self.scene.set_poses(&poses)?;
        Ok(())
    }

    fn points(&self, manifolds: impl Iterator<Item = Contact<Manifold>>) -> Vec<Point> {
        let mut points = Vec::new();
        for Contact { pair, answer } in manifolds {
            let bodies = [pair.i as usize, pair.j as usize];
            for found in answer.points() {
                let middle = 0.5 * (found.point_a + found.point_b);
                let arms = bodies.map(|k| middle - self.bodies[k].position);
                let excess = (found.depth - REST_DEPTH).max(0.0);
                let bias = (RECOVERY * excess / FRAME_TIME).min(RECOVERY_SPEED);
                let (pushed, rubbed) = (0.0, DVec3::ZERO);
                points.push(Point { bodies, arms, normal: answer.normal, bias, pushed, rubbed });
            }
        }
        points
    }

    /// Takes back the speed of approach at a point, and as much of the sliding as friction holds.
    fn push(&mut self, point: &mut Point) {
        let Point { bodies, arms, normal, bias, .. } = *point;
        let along = -self.sliding(bodies, arms).dot(normal);
        let push = (along + bias) / self.give(bodies, arms, normal);
        let pushed = (point.pushed + push).max(0.0);
        self.apply(bodies, arms, normal * (pushed - point.pushed));
        point.pushed = pushed;
        let sliding = self.sliding(bodies, arms);
        let sliding = sliding - normal * sliding.dot(normal);
        let Some(direction) = sliding.try_normalize() else { return };
        let wanted = point.rubbed - sliding / self.give(bodies, arms, direction);
        let rubbed = wanted.clamp_length_max(FRICTION * pushed);
        self.apply(bodies, arms, rubbed - point.rubbed);
        point.rubbed = rubbed;
    }

    /// The velocity of the second body's point against that of the first.
    fn sliding(&self, bodies: [usize; 2], arms: [DVec3; 2]) -> DVec3 {
        let [a, b] = [0, 1].map(|k| {
            let body = &self.bodies[bodies[k]];
            body.velocity + body.spin.cross(arms[k])
        });
        b - a
    }

    /// How much speed along a direction an impulse of 1 gives.
    fn give(&self, bodies: [usize; 2], arms: [DVec3; 2], direction: DVec3) -> f64 {
        let one = |k: usize| {
            let Body { inverse_mass, inverse_inertia, .. } = self.bodies[bodies[k]];
            inverse_mass + inverse_inertia * arms[k].cross(direction).length_squared()
        };
        one(0) + one(1)
    }

    fn apply(&mut self, bodies: [usize; 2], arms: [DVec3; 2], impulse: DVec3) {
        for (k, impulse) in [(0, -impulse), (1, impulse)] {
            let body = &mut self.bodies[bodies[k]];
            body.velocity += impulse * body.inverse_mass;
            body.spin += arms[k].cross(impulse) * body.inverse_inertia;
        }
    }
}

impl Body {
    fn new(position: DVec3, rotation: DQuat, reach: f64) -> Self {
        let (velocity, spin) = (DVec3::ZERO, DVec3::ZERO);
        // A sphere's, of the shape's size.
        let inverse_inertia = 1.0 / (0.4 * reach * reach);
        Self { position, rotation, velocity, spin, inverse_mass: 1.0, inverse_inertia }
    }

    fn fixed() -> Self {
        let body = Self::new(DVec3::ZERO, DQuat::IDENTITY, 1.0);
        Self { inverse_mass: 0.0, inverse_inertia: 0.0, ..body }
    }

    fn slow_down(&mut self, reach: f64) {
        self.velocity *= KEPT_SPEED;
        self.spin *= KEPT_SPIN;
        if self.velocity.length() + self.spin.length() * reach < RESTING {
            self.velocity *= 0.1;
            self.spin *= 0.1;
        }
    }
}

fn terrain(half_width: f64) -> Result<Shape, Box<dyn std::error::Error>> {
    let at = |k: u32| 2.0 * half_width * f64::from(k) / f64::from(SQUARES) - half_width;
    let line = || 0..=SQUARES;
    let vertex = |x: u32, y: u32| DVec3::new(at(x), at(y), hills(at(x), at(y)));
    let vertices = line().flat_map(|x| line().map(move |y| vertex(x, y))).collect();
    let square = |x: u32, y: u32| {
        let [a, b] = [x * (SQUARES + 1) + y, (x + 1) * (SQUARES + 1) + y];
        [[a, b, a + 1], [b, b + 1, a + 1]]
    };
    let triangles = (0..SQUARES).flat_map(|x| (0..SQUARES).flat_map(move |y| square(x, y)));
    Ok(Shape::mesh(vertices, triangles.collect())?)
}

/// Seven kinds of bodies, about a metre across.
fn kinds() -> Result<Vec<Shape>, Box<dyn std::error::Error>> {
    let mut draw = Draw(7);
    let points = (0..24).map(|_| draw.vector().normalize_or(DVec3::Z) * 0.45).collect();
    let corner = Pose::from_translation(DVec3::new(0.25, 0.0, 0.3))?;
    let bar = Shape::cuboid(DVec3::new(0.4, 0.15, 0.15))?;
    let post = Shape::cuboid(DVec3::new(0.15, 0.15, 0.25))?;
    Ok(vec![
        Shape::cuboid(DVec3::new(0.4, 0.35, 0.3))?,
        Shape::sphere(0.4)?,
        Shape::capsule(0.3, 0.25)?,
        Shape::cylinder(0.35, 0.35)?,
        Shape::cone(0.35, 0.45)?,
        Shape::hull(points)?,
        Shape::compound(vec![(bar, Pose::IDENTITY), (post, corner)])?,
    ])
}
