//! Bodies that lie on a terrain: one mesh under many.

use crate::SpecError;
use crate::pile::{refused_scene, refused_shape};
use crate::random::Draw;
use dcd_geom::{Object, Pose, Scene, Shape, SupportMap};
use glam::{DQuat, DVec3};

/// Squares of the terrain along each side, two triangles each.
const SQUARES: u32 = 50;
/// Metres from body to body: at most 0.8 of it is one wide, so that they do not touch each other.
const PITCH: f64 = 1.0;
/// Different hulls; the bodies share all shapes.
const HULLS: u64 = 8;
/// Streams from here on are hulls; below they are bodies.
const HULL_STREAMS: u64 = 1 << 63;
/// How deep bodies lie in the ground, metres, measured at their lowest point; negative ones hardly touch or do not.
const DEPTHS: [f64; 2] = [-0.01, 0.04];

/// A wavy square mesh of 5,000 triangles, object 0, which does not move, and so many bodies in a grid on it: spheres,
/// cuboids, capsules and hulls in a cycle, 0.3 m to 0.8 m wide. Half of them stand upright on the slope, the others are
/// turned at random. The same on every machine.
///
/// # Errors
/// More objects than a u32 counts.
pub fn terrain(bodies: usize, seed: u64) -> Result<Scene, SpecError> {
    if u32::try_from(bodies.saturating_add(1)).is_err() {
        return Err(SpecError::TooManyObjects { objects: bodies });
    }
    let side = (bodies as f64).sqrt().ceil().max(1.0);
    let half_width = 0.5 * PITCH * (side + 2.0);
    let hull = |k: u64| {
        let mut draw = Draw::new(seed, HULL_STREAMS | k);
        let count = draw.count(10..20);
        let half = DVec3::new(0.35, 0.25, 0.3);
        let mut point = || draw.point(-1.0, 1.0).normalize_or(DVec3::X) * half;
        Shape::hull((0..count).map(|_| point()).collect())
    };
    let simple =
        [Shape::sphere(0.25), Shape::cuboid(DVec3::new(0.3, 0.2, 0.15)), Shape::capsule(0.2, 0.15)];
    let shapes = std::iter::once(ground(half_width)).chain(simple).chain((0..HULLS).map(hull));
    let shapes = shapes.collect::<Result<Vec<_>, _>>().map_err(refused_shape)?;
    let mut objects = vec![Object::new(0, Pose::IDENTITY).fixed()];
    for k in 0..bodies {
        let shape = if k % 4 < 3 { 1 + k % 4 } else { 4 + k / 4 % HULLS as usize };
        let mut draw = Draw::new(seed, k as u64);
        let cell = [k % side as usize, k / side as usize].map(|c| c as f64 - 0.5 * (side - 1.0));
        let at = DVec3::new(cell[0], cell[1], 0.0) * PITCH + draw.point(-0.1, 0.1);
        let up = slope(at.x, at.y);
        let turn = draw.rotation();
        let turn = if k / 4 % 2 == 0 {
            DQuat::from_rotation_arc(DVec3::Z, up) * upright(turn)
        } else {
            turn.normalize()
        };
        let below = shapes[shape].support(turn.inverse() * -up);
        let reach = (turn * below.point).dot(-up) + shapes[shape].radius();
        let on = DVec3::new(at.x, at.y, height(at.x, at.y));
        let place = on + up * (reach - draw.between(DEPTHS[0], DEPTHS[1]));
        let pose = Pose::new(turn, place)
            .map_err(|error| SpecError::Build(crate::BuildError::Pose { object: k + 1, error }))?;
        objects.push(Object::new(shape as u32, pose));
    }
    Scene::new(shapes, objects).map_err(refused_scene)
}

/// What of a rotation is about z.
fn upright(turn: DQuat) -> DQuat {
    DQuat::from_xyzw(0.0, 0.0, turn.z, turn.w).normalize()
}

fn height(x: f64, y: f64) -> f64 {
    0.25 * libm::sin(1.1 * x) * libm::cos(0.9 * y)
}

/// The normal of the ground there.
fn slope(x: f64, y: f64) -> DVec3 {
    let along_x = 0.275 * libm::cos(1.1 * x) * libm::cos(0.9 * y);
    let along_y = -0.225 * libm::sin(1.1 * x) * libm::sin(0.9 * y);
    DVec3::new(-along_x, -along_y, 1.0).normalize()
}

fn ground(half_width: f64) -> Result<Shape, dcd_geom::ShapeError> {
    let line = SQUARES + 1;
    let place = |k: u32| (f64::from(k) / f64::from(SQUARES) * 2.0 - 1.0) * half_width;
    let vertex = |i: u32, j: u32| DVec3::new(place(i), place(j), height(place(i), place(j)));
    let vertices = (0..line).flat_map(|i| (0..line).map(move |j| vertex(i, j))).collect();
    let square = |i: u32, j: u32| {
        let [a, b] = [i * line + j, (i + 1) * line + j];
        [[a, b, b + 1], [a, b + 1, a + 1]]
    };
    let triangles = (0..SQUARES).flat_map(|i| (0..SQUARES).flat_map(move |j| square(i, j)));
    Shape::mesh(vertices, triangles.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_lies_on_the_ground_and_the_first_bodies_have_the_same_turns_in_a_larger_scene() {
        let (few, many) = (terrain(16, 3).unwrap(), terrain(100, 3).unwrap());
        let Shape::Mesh(mesh) = few.shape(0) else { panic!("no mesh") };
        assert_eq!(mesh.triangles().len(), 5000);
        assert_eq!((few.len(), many.len()), (17, 101));
        for k in 1..17 {
            assert_eq!(few.shape_of()[k], many.shape_of()[k]);
            let at = few.poses()[k].translation();
            let above = at.z - height(at.x, at.y);
            assert!(above > 0.05 && above < 0.6, "{k}: {above}");
        }
    }

    #[test]
    fn too_many_bodies_are_refused_with_their_number() {
        let count = u32::MAX as usize;
        let refused = terrain(count, 1);
        assert!(matches!(refused, Err(SpecError::TooManyObjects { objects }) if objects == count));
        assert_eq!(terrain(0, 1).unwrap().len(), 1);
    }
}
