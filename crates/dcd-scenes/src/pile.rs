//! A pile: hulls that fall on a slab and on each other.

use crate::random::Draw;
use crate::{RawShape, SpecError};
use dcd_geom::{Object, Pair, Pose, Scene, SceneError, Shape};
use glam::{DQuat, DVec3};

/// Different hulls in a pile; the objects share them.
const HULLS: u64 = 32;
/// Streams from here on are hulls; below they are objects.
const HULL_STREAMS: u64 = 1 << 63;
/// A frame's length, seconds.
const FRAME_TIME: f64 = 1.0 / 60.0;
/// Metres a second squared, along −z.
const GRAVITY: f64 = 9.81;
/// Coulomb's coefficient. No unit. Larger: a steeper heap.
const FRICTION: f64 = 0.5;
/// How often the contacts of a frame are gone through. More: a stiffer pile, slower.
const ROUNDS: usize = 8;
/// The part of an overlap that a frame takes back. No unit. Larger: jitter. Smaller: sinking.
const RECOVERY: f64 = 0.2;
/// The overlap that is left alone, metres, so that what rests stays in contact.
const REST_DEPTH: f64 = 0.005;
/// The fastest that an overlap is taken back, metres a second: deep ones do not explode.
const RECOVERY_SPEED: f64 = 3.0;
/// The part of its speed that a body keeps in a second without contact. No unit.
const KEPT_SPEED: f64 = 0.9;

/// Hulls above a slab, and how they move: gravity, contacts without rebound, friction.
///
/// It takes the contacts of its scene and gives the next frame: who finds them is the caller's
/// matter. The slab is object 0 and never moves. Each body turns as a sphere of its own size would,
/// which is all that a scene needs; nothing here is a physics engine. Sums and square roots alone
/// decide, so that the same contacts give the same bits on every machine.
#[derive(Clone, Debug)]
pub struct Pile {
    scene: Scene,
    bodies: Vec<Body>,
}

/// A touching pair of a pile, from whoever found it. World frame, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PileContact {
    /// The objects.
    pub pair: Pair,
    /// The unit normal, from the pair's first object to its second.
    pub normal: DVec3,
    /// How deep they overlap.
    pub depth: f64,
    /// Where.
    pub point: DVec3,
}

/// What moves; masses are in units of a hull's, so that only their inverse counts.
#[derive(Clone, Copy, Debug)]
struct Body {
    position: DVec3,
    rotation: DQuat,
    velocity: DVec3,
    spin: DVec3,
    /// 0 for the slab.
    inverse_mass: f64,
    inverse_inertia: f64,
}

impl Pile {
    /// So many hulls of 8 to 31 points, about a metre wide, in loose layers above the slab.
    ///
    /// # Errors
    /// More hulls than a u32 counts with the slab.
    pub fn new(hulls: usize, seed: u64) -> Result<Self, SpecError> {
        if u32::try_from(hulls + 1).is_err() {
            return Err(SpecError::TooManyObjects { objects: hulls });
        }
        let row = row_length(hulls);
        let half_width = 2.0 * row as f64 + 10.0;
        let slab = Shape::cuboid(DVec3::new(half_width, half_width, 0.5));
        let shapes = std::iter::once(slab).chain((0..HULLS).map(|k| Shape::hull(points(seed, k))));
        let shapes = shapes.collect::<Result<Vec<_>, _>>().map_err(refused_shape)?;
        let mut bodies = vec![Body::slab()];
        bodies.extend((0..hulls).map(|k| Body::falling(k, row, seed)));
        let objects: Vec<Object> = bodies
            .iter()
            .enumerate()
            .map(|(k, body)| {
                let shape = if k == 0 { 0 } else { 1 + (k as u64 - 1) % HULLS };
                let object = Object::new(shape as u32, body.pose(k)?);
                Ok(if k == 0 { object.fixed() } else { object })
            })
            .collect::<Result<_, SpecError>>()?;
        let scene = Scene::new(shapes, objects).map_err(refused_scene)?;
        Ok(Self { scene, bodies })
    }

    /// The scene as it stands.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Moves on by a sixtieth of a second. The contacts are those of the scene as it stands, in an
    /// order that is the same each time; one that names no object of the pile is passed over.
    ///
    /// # Errors
    /// A body leaves the range of a scene.
    pub fn advance(&mut self, contacts: &[PileContact]) -> Result<(), SceneError> {
        let keep = 1.0 - (1.0 - KEPT_SPEED) * FRAME_TIME;
        for body in self.bodies.iter_mut().filter(|body| body.inverse_mass > 0.0) {
            body.velocity = (body.velocity - DVec3::Z * (GRAVITY * FRAME_TIME)) * keep;
            body.spin *= keep;
        }
        for _ in 0..ROUNDS {
            contacts.iter().for_each(|contact| self.resolve(contact));
        }
        for (object, body) in self.bodies.iter_mut().enumerate().skip(1) {
            body.drift();
            if let Ok(pose) = body.pose(object) {
                self.scene.set_pose(object, pose)?;
            }
        }
        Ok(())
    }

    /// Gives both bodies the impulse after which they approach no more.
    fn resolve(&mut self, contact: &PileContact) {
        let PileContact { pair, normal, depth, point } = *contact;
        let [i, j] = [pair.i as usize, pair.j as usize];
        if let Ok([a, b]) = self.bodies.get_disjoint_mut([i, j]) {
            let excess = (depth - REST_DEPTH).max(0.0);
            let recovery = (RECOVERY * excess / FRAME_TIME).min(RECOVERY_SPEED);
            let parting = (b.speed_at(point) - a.speed_at(point)).dot(normal);
            let push = ((recovery - parting) / resistance(a, b, point, normal)).max(0.0);
            a.strike(point, normal * -push);
            b.strike(point, normal * push);
            let sliding = b.speed_at(point) - a.speed_at(point);
            let sliding = sliding - normal * sliding.dot(normal);
            let along = sliding.normalize_or_zero();
            let stop = sliding.length() / resistance(a, b, point, along);
            let drag = along * stop.min(FRICTION * push);
            a.strike(point, drag);
            b.strike(point, -drag);
        }
    }
}

/// How many hulls stand in a row of a layer: about twice as many layers as that.
fn row_length(hulls: usize) -> usize {
    libm::ceil(libm::cbrt(hulls as f64 / 2.0)).max(1.0) as usize
}

/// A hull's points, counted from their middle.
fn points(seed: u64, hull: u64) -> Vec<DVec3> {
    let mut draw = Draw::new(seed, HULL_STREAMS | hull);
    let count = draw.count(8..32);
    let mut points: Vec<DVec3> = (0..count).map(|_| draw.point(0.0, 1.0)).collect();
    let middle = points.iter().sum::<DVec3>() / f64::from(count);
    points.iter_mut().for_each(|point| *point -= middle);
    RawShape::of_cloud(points).points()
}

/// How much two bodies resist an impulse along `direction`: what their speeds differ by for one of 1.
fn resistance(a: &Body, b: &Body, point: DVec3, direction: DVec3) -> f64 {
    let one = |body: &Body| {
        let lever = (point - body.position).cross(direction);
        body.inverse_mass + lever.length_squared() * body.inverse_inertia
    };
    // Two slabs resist without end, and so does any body along no direction.
    let sum = one(a) + one(b);
    if sum > 0.0 { sum } else { f64::INFINITY }
}

pub(crate) fn refused_shape(error: dcd_geom::ShapeError) -> SpecError {
    SpecError::Build(crate::BuildError::Shape { shape: 0, error })
}

pub(crate) fn refused_scene(error: SceneError) -> SpecError {
    SpecError::Build(crate::BuildError::Scene(error))
}

impl Body {
    /// Its upper side is z = 0.
    fn slab() -> Self {
        Self {
            position: DVec3::new(0.0, 0.0, -0.5),
            rotation: DQuat::IDENTITY,
            velocity: DVec3::ZERO,
            spin: DVec3::ZERO,
            inverse_mass: 0.0,
            inverse_inertia: 0.0,
        }
    }

    /// Hull `k` in layers of `row` × `row`, off its place by up to a fifth of a metre.
    fn falling(k: usize, row: usize, seed: u64) -> Self {
        let mut draw = Draw::new(seed, k as u64);
        let rotation = draw.rotation();
        let cell = [k % row, k / row % row, k / (row * row)].map(|n| n as f64);
        let middle = DVec3::new(1.0, 1.0, 0.0) * (0.5 * (row as f64 - 1.0));
        let place = (DVec3::from_array(cell) - middle) * 1.4 + DVec3::Z * 1.2;
        Self {
            position: place + draw.point(-0.2, 0.2),
            rotation: rotation.normalize(),
            inverse_mass: 1.0,
            // A sphere's 2/5·m·r², r half a metre.
            inverse_inertia: 10.0,
            ..Self::slab()
        }
    }

    fn pose(&self, object: usize) -> Result<Pose, SpecError> {
        Pose::new(self.rotation, self.position)
            .map_err(|error| SpecError::Build(crate::BuildError::Pose { object, error }))
    }

    fn speed_at(&self, point: DVec3) -> DVec3 {
        self.velocity + self.spin.cross(point - self.position)
    }

    fn strike(&mut self, point: DVec3, impulse: DVec3) {
        self.velocity += impulse * self.inverse_mass;
        self.spin += (point - self.position).cross(impulse) * self.inverse_inertia;
    }

    /// Moves on by a frame at the speed it has.
    fn drift(&mut self) {
        self.position += self.velocity * FRAME_TIME;
        let half = self.spin * (0.5 * FRAME_TIME);
        let turn = DQuat::from_xyzw(half.x, half.y, half.z, 0.0) * self.rotation;
        self.rotation = (self.rotation + turn).normalize();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hull_without_contact_falls_as_gravity_says() {
        let mut pile = Pile::new(1, 3).unwrap();
        let before = pile.scene().poses()[1].translation();
        for _ in 0..10 {
            pile.advance(&[]).unwrap();
        }
        let fallen = before - pile.scene().poses()[1].translation();
        // Steps of 1/60 s: 1 + 2 + … + 10 times g/60², less what the air takes.
        let free = 55.0 * GRAVITY * FRAME_TIME * FRAME_TIME;
        assert_eq!((fallen.x, fallen.y), (0.0, 0.0));
        assert!(fallen.z < free && fallen.z > 0.98 * free, "{fallen}");
        assert_eq!(pile.scene().poses()[0].translation(), DVec3::new(0.0, 0.0, -0.5));
    }

    #[test]
    fn two_hulls_part_with_opposite_impulses_and_the_slab_stays() {
        let mut pile = Pile::new(2, 3).unwrap();
        let point = (pile.bodies[1].position + pile.bodies[2].position) * 0.5;
        let normal = (pile.bodies[2].position - pile.bodies[1].position).normalize();
        let pair = Pair::new(1, 2);
        pile.resolve(&PileContact { pair, normal, depth: 0.1, point });
        let [slab, a, b] = [0, 1, 2].map(|k| pile.bodies[k].velocity);
        assert!((a + b).length() < 1e-12 && (b - a).dot(normal) > 0.0, "{a} {b}");
        let pair = Pair::new(0, 1);
        pile.resolve(&PileContact { pair, normal: DVec3::Z, depth: 1.0, point });
        assert_eq!(slab, pile.bodies[0].velocity);
        assert!(pile.bodies[1].velocity.z > a.z);
    }

    #[test]
    fn a_contact_of_no_object_is_passed_over() {
        let mut pile = Pile::new(1, 3).unwrap();
        let mut other = pile.clone();
        let pair = Pair::new(1, 9);
        let lost = PileContact { pair, normal: DVec3::Z, depth: 1.0, point: DVec3::ZERO };
        pile.advance(&[lost]).unwrap();
        other.advance(&[]).unwrap();
        assert_eq!(pile.scene().poses(), other.scene().poses());
    }

    #[test]
    fn too_many_hulls_are_refused_with_their_number() {
        let count = u32::MAX as usize;
        assert!(matches!(
            Pile::new(count, 1),
            Err(SpecError::TooManyObjects { objects }) if objects == count
        ));
        assert_eq!(Pile::new(0, 1).unwrap().scene().len(), 1);
    }
}
