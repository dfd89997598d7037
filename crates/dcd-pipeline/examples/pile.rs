//! A pile of bodies that falls on a terrain mesh and comes to rest: manifolds as a physics engine uses them.
//!
//! The solver is the simplest that stands: sequential impulses on the points of the manifolds, with friction, a few
//! rounds a frame, each point beginning with what held it the frame before: its parts and features know it again. `cargo run --release --example pile -- 2000` drops more bodies.

use dcd_pipeline::geom::glam::DMat3;
use dcd_pipeline::prelude::*;
use std::collections::HashMap;
use std::error::Error;

const FRAMES: usize = 300;
/// How many bodies are above each other at first.
const LAYERS: f64 = 3.0;
const DT: f64 = 1.0 / 60.0;
const GRAVITY: DVec3 = DVec3::new(0.0, 0.0, -9.81);
const FRICTION: f64 = 0.8;
/// How far before its middle the ground presses against what rolls, metres: it stops on slopes up to two fifths.
const ROLLING: f64 = 0.1;
/// Part of a velocity that is left after a second: of a body's, and of its spin.
const DRAG: [f64; 2] = [0.3, 0.05];
/// A body with less energy, joules a kilogram, loses that part of its velocity a frame: what hardly moves stays, though
/// it stands on a tip.
const STILL: [f64; 2] = [0.05, 0.3];
/// Overlap that is left as it is, metres, so that contacts do not come and go.
const SLOP: f64 = 0.002;
/// Part of the overlap that a frame takes back, and the most metres a second for that.
const PUSH: [f64; 2] = [0.2, 1.0];
const ROUNDS: usize = 12;
/// Joules a kilogram below which the pile rests: some centimetres a second.
const REST: f64 = 1e-3;

/// A body that moves. Its mass is its volume's, about; kilograms, metres, seconds.
struct Body {
    inverse_mass: f64,
    /// Along the axes of its own frame.
    inverse_inertia: DVec3,
    velocity: DVec3,
    spin: DVec3,
}

impl Body {
    /// Joules a kilogram, with the largest moment of inertia.
    fn energy(&self) -> f64 {
        let inertia = self.inverse_mass / self.inverse_inertia.min_element();
        0.5 * (self.velocity.length_squared() + inertia * self.spin.length_squared())
    }
}

/// What knows a point again: two objects, their parts and their features.
type Key = (Pair, [Option<PartIndex>; 2], [Feature; 2]);

/// A point of a manifold as the solver takes it.
struct Constraint {
    key: Key,
    bodies: [usize; 2],
    /// From the centres of a and b to the point.
    arms: [DVec3; 2],
    /// The normal from a to b, and two directions of the plane.
    axes: [DVec3; 3],
    /// Along each; and round each, of what rolls.
    inverse_masses: [f64; 3],
    impulses: [f64; 3],
    inverse_inertias: [f64; 3],
    twists: [f64; 3],
    depth: f64,
}

/// The world: the terrain is object 0, which does not move.
struct Pile {
    scene: Scene,
    bodies: Vec<Body>,
    inertias: Vec<DMat3>,
    constraints: Vec<Constraint>,
    /// What the points of the frame before took at last: an impulse and a twist.
    held: HashMap<Key, [DVec3; 2]>,
}

/// Numbers from 0 to 1.
struct Draw(u64);

impl Draw {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(0xd134_2543_de82_ef95).wrapping_add(1);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn vector(&mut self) -> DVec3 {
        DVec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0
    }
}

/// The height of the ground: waves, and a rim that keeps the bodies in.
fn height(x: f64, y: f64, half: f64) -> f64 {
    let beyond = (x.abs().max(y.abs()) - 0.8 * half).max(0.0);
    0.25 * (1.1 * x).sin() * (0.9 * y).cos() + 3.0 * beyond * beyond
}

/// A square of that half edge, 5,000 triangles.
fn terrain(half: f64) -> Result<Shape, Box<dyn Error>> {
    const SIDE: u32 = 50;
    let line = SIDE + 1;
    let place = |k: u32| (f64::from(k) / f64::from(SIDE) * 2.0 - 1.0) * half;
    let vertex = |i: u32, j: u32| {
        let (x, y) = (place(i), place(j));
        DVec3::new(x, y, height(x, y, half))
    };
    let vertices = (0..line).flat_map(|i| (0..line).map(move |j| vertex(i, j))).collect();
    let square = |i: u32, j: u32| {
        let [a, b] = [i * line + j, (i + 1) * line + j];
        [[a, b, b + 1], [a, b + 1, a + 1]]
    };
    let triangles = (0..SIDE).flat_map(|i| (0..SIDE).flat_map(move |j| square(i, j))).collect();
    Ok(Shape::mesh(vertices, triangles)?)
}

/// A cuboid, a sphere, a capsule, a hull and a cylinder, each with half of its extent.
fn shapes(draw: &mut Draw) -> Result<Vec<(Shape, DVec3)>, Box<dyn Error>> {
    let half = DVec3::new(0.3, 0.2, 0.25);
    let cloud = (0..14).map(|_| draw.vector().normalize_or(DVec3::X) * half).collect();
    Ok(vec![
        (Shape::cuboid(half)?, half),
        (Shape::sphere(0.25)?, DVec3::splat(0.25)),
        (Shape::capsule(0.2, 0.18)?, DVec3::new(0.18, 0.18, 0.38)),
        (Shape::hull(cloud)?, half),
        (Shape::cylinder(0.2, 0.22)?, DVec3::new(0.22, 0.22, 0.2)),
    ])
}

impl Pile {
    fn new(count: usize) -> Result<Self, Box<dyn Error>> {
        let draw = &mut Draw(1);
        let kinds = shapes(draw)?;
        let side = (count as f64 / LAYERS).sqrt().ceil().max(2.0);
        let half = 0.7 * side;
        let all = std::iter::once(terrain(half)?).chain(kinds.iter().map(|kind| kind.0.clone()));
        let mut scene = Scene::new(all.collect(), [Object::new(0, Pose::IDENTITY).fixed()])?;
        let still = Body {
            inverse_mass: 0.0,
            inverse_inertia: DVec3::ZERO,
            velocity: DVec3::ZERO,
            spin: DVec3::ZERO,
        };
        let mut bodies = vec![still];
        for k in 0..count {
            let cell = [k as f64 % side, (k as f64 / side).floor() % side];
            let [x, y] = cell.map(|c| (c - 0.5 * (side - 1.0)) * 1.0 + 0.1 * draw.unit());
            let layer = (k as f64 / (side * side)).floor();
            let place = DVec3::new(x, y, 1.0 + 0.9 * layer);
            let pose = Pose::new(DQuat::from_scaled_axis(draw.vector() * 3.0), place)?;
            scene.insert(Object::new((1 + k % kinds.len()) as u32, pose))?;
            let half = kinds[k % kinds.len()].1;
            let mass = 1000.0 * 5.0 * half.x * half.y * half.z;
            // That of an ellipsoid, about.
            let squares = half * half;
            let inertia = (DVec3::splat(squares.element_sum()) - squares) * (mass / 4.0);
            bodies.push(Body {
                inverse_mass: 1.0 / mass,
                inverse_inertia: inertia.recip(),
                velocity: DVec3::ZERO,
                spin: DVec3::ZERO,
            });
        }
        let (inertias, constraints, held) = (Vec::new(), Vec::new(), HashMap::new());
        Ok(Self { scene, bodies, inertias, constraints, held })
    }

    /// One frame: what falls is stopped by what it touches.
    fn advance(
        &mut self,
        answers: impl Iterator<Item = Contact<ManifoldSet>>,
    ) -> Result<(), Box<dyn Error>> {
        let drag = DRAG.map(|left| left.powf(DT));
        for body in &mut self.bodies[1..] {
            if body.energy() < STILL[0] {
                body.velocity *= 1.0 - STILL[1];
                body.spin *= 1.0 - STILL[1];
            }
            body.velocity = (body.velocity + GRAVITY * DT) * drag[0];
            body.spin *= drag[1];
        }
        let world = |(body, pose): (&Body, &Pose)| {
            let turn = *pose.rotation();
            turn * DMat3::from_diagonal(body.inverse_inertia) * turn.transpose()
        };
        self.inertias.clear();
        self.inertias.extend(self.bodies.iter().zip(self.scene.poses()).map(world));
        let held = |c: &Constraint| (c.key, [along(c.axes, c.impulses), along(c.axes, c.twists)]);
        self.held.clear();
        self.held.extend(self.constraints.iter().map(held));
        self.constraints.clear();
        for Contact { pair, answer } in answers {
            for manifold in &answer {
                for point in manifold.points() {
                    self.constrain(pair, manifold.normal, point);
                }
            }
        }
        for _ in 0..ROUNDS {
            self.solve(PUSH[0] / DT);
        }
        self.integrate()?;
        // What pushed bodies apart is no velocity of theirs.
        for _ in 0..2 {
            self.solve(0.0);
        }
        Ok(())
    }

    fn constrain(&mut self, pair: Pair, normal: DVec3, point: &ManifoldPoint) {
        let ManifoldPoint { point_a, point_b, depth, features, parts } = *point;
        let bodies = [pair.i as usize, pair.j as usize];
        let middle = (point_a + point_b) * 0.5;
        let arms = bodies.map(|k| middle - self.scene.poses()[k].translation());
        let (u, v) = normal.any_orthonormal_pair();
        let axes = [normal, u, v];
        let inverse_masses = axes.map(|axis| {
            let of = |k: usize| {
                let turn = arms[k].cross(axis);
                self.bodies[bodies[k]].inverse_mass + turn.dot(self.inertias[bodies[k]] * turn)
            };
            of(0) + of(1)
        });
        let inertias = bodies.map(|k| self.inertias[k]);
        let inverse_inertias = axes.map(|axis| axis.dot((inertias[0] + inertias[1]) * axis));
        let key = (pair, parts, features);
        let [impulse, twist] = self.held.remove(&key).unwrap_or_default();
        let mut impulses = axes.map(|axis| axis.dot(impulse));
        impulses[0] = impulses[0].max(0.0);
        let twists = axes.map(|axis| axis.dot(twist));
        let (impulse, twist) = (along(axes, impulses), along(axes, twists));
        for (k, sense) in [(0, -1.0), (1, 1.0)] {
            let (body, inertia) = (&mut self.bodies[bodies[k]], inertias[k]);
            body.velocity += impulse * (sense * body.inverse_mass);
            body.spin += inertia * (arms[k].cross(impulse) + twist) * sense;
        }
        self.constraints.push(Constraint {
            key,
            bodies,
            arms,
            axes,
            inverse_masses,
            impulses,
            inverse_inertias,
            twists,
            depth,
        });
    }

    /// A round of impulses; `push` is the part of the overlap that a second takes back.
    fn solve(&mut self, push: f64) {
        let Self { constraints, bodies, inertias, .. } = self;
        for constraint in constraints {
            let Constraint { bodies: [a, b], arms, axes, impulses, twists, .. } = constraint;
            let wanted = ((constraint.depth - SLOP) * push).clamp(0.0, PUSH[1]);
            for k in 0..3 {
                let [of_a, of_b] = [(*a, arms[0]), (*b, arms[1])]
                    .map(|(body, arm)| bodies[body].velocity + bodies[body].spin.cross(arm));
                let speed = (of_b - of_a).dot(axes[k]);
                let target = if k == 0 { wanted } else { 0.0 };
                let most = if k == 0 { f64::INFINITY } else { FRICTION * impulses[0] };
                let least = if k == 0 { 0.0 } else { -most };
                let change = (target - speed) / constraint.inverse_masses[k];
                let impulse = axes[k] * add(&mut impulses[k], change, [least, most]);
                for (body, arm, impulse) in [(*a, arms[0], -impulse), (*b, arms[1], impulse)] {
                    let change = impulse * bodies[body].inverse_mass;
                    bodies[body].velocity += change;
                    bodies[body].spin += inertias[body] * arm.cross(impulse);
                }
            }
            let most = ROLLING * impulses[0];
            for k in 0..3 {
                let speed = (bodies[*b].spin - bodies[*a].spin).dot(axes[k]);
                let change = -speed / constraint.inverse_inertias[k];
                let twist = axes[k] * add(&mut twists[k], change, [-most, most]);
                bodies[*a].spin -= inertias[*a] * twist;
                bodies[*b].spin += inertias[*b] * twist;
            }
        }
    }

    fn integrate(&mut self) -> Result<(), Box<dyn Error>> {
        for k in 1..self.bodies.len() {
            let (body, pose) = (&self.bodies[k], &self.scene.poses()[k]);
            let turn = DQuat::from_scaled_axis(body.spin * DT) * DQuat::from_mat3(pose.rotation());
            let pose = Pose::new(turn.normalize(), pose.translation() + body.velocity * DT)?;
            self.scene.set_pose(k, pose)?;
        }
        Ok(())
    }

    /// Joules a kilogram, on average.
    fn energy(&self) -> f64 {
        self.bodies[1..].iter().map(Body::energy).sum::<f64>() / (self.bodies.len() - 1) as f64
    }

    /// A number that two piles share if all their poses are the same.
    fn digest(&self) -> u64 {
        let numbers = self.scene.poses().iter().flat_map(|pose| {
            pose.rotation().to_cols_array().into_iter().chain(pose.translation().to_array())
        });
        numbers.fold(0xcbf2_9ce4_8422_2325, |hash, x| {
            (hash ^ x.to_bits()).wrapping_mul(0x0100_0000_01b3)
        })
    }
}

/// So much along each of three axes.
fn along(axes: [DVec3; 3], parts: [f64; 3]) -> DVec3 {
    axes[0] * parts[0] + axes[1] * parts[1] + axes[2] * parts[2]
}

/// Adds to a sum that has limits, and returns what was added.
fn add(sum: &mut f64, change: f64, [least, most]: [f64; 2]) -> f64 {
    let before = *sum;
    *sum = (before + change).clamp(least, most);
    *sum - before
}

/// Drops so many bodies and returns the pile at rest.
fn drop(count: usize, par: Par) -> Result<Pile, Box<dyn Error>> {
    let mut pile = Pile::new(count)?;
    // Nothing is under the terrain, and what slides over it does not catch on its edges.
    let options = ManifoldOptions { mesh_sides: MeshSides::Outward, mesh_edges: MeshEdges::Active };
    // Some micrometres are good enough.
    let narrow = SimdDepths::new(Manifolds { options }, Accuracy::F32);
    let mut pipeline = Pipeline::with(WideTree::default(), narrow);
    for frame in 0..FRAMES {
        let step = pipeline.step(&pile.scene, par);
        let deepest = step.answers().flat_map(|contact| contact.answer.to_vec());
        let deepest = deepest.map(|manifold| manifold.points()[0].depth).fold(0.0, f64::max);
        let (contacts, energy) = (step.contact_count(), pile.energy());
        if frame % 30 == 29 {
            println!("frame {frame}: {contacts} contacts, {energy:.6} J/kg, {deepest:.4} m deep");
        }
        if frame > 60 && energy < REST && deepest < 0.02 {
            println!("at rest in frame {frame}: {contacts} contacts, {deepest:.4} m deep");
            return Ok(pile);
        }
        pile.advance(step.answers())?;
    }
    Err("the pile does not come to rest".into())
}

fn main() -> Result<(), Box<dyn Error>> {
    let count = std::env::args().nth(1).map_or(Ok(200), |count| count.parse())?;
    let pile = drop(count, Par::Pool)?;
    let half = 0.7 * (count as f64 / LAYERS).sqrt().ceil().max(2.0);
    for pose in &pile.scene.poses()[1..] {
        let place = pose.translation();
        assert!(place.x.abs().max(place.y.abs()) < half, "over the rim: {place}");
        assert!(place.z > height(place.x, place.y, half), "through the ground: {place}");
    }
    if count <= 200 {
        assert_eq!(drop(count, Par::Serial)?.digest(), pile.digest(), "another pile, serially");
    }
    println!("{count} bodies rest on the ground");
    Ok(())
}
