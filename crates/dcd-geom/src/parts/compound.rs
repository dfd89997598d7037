//! Convex parts, each with a place in the compound.

use super::tree::PartTree;
use crate::{Aabb, Curved, Kind, Polytope, Pose, Shape, ShapeError, Sphere, Support, SupportMap};
use glam::DVec3;
use std::sync::{Arc, OnceLock};

/// A convex part of a compound.
#[derive(Clone, Debug)]
pub struct Part {
    /// The shape as it was given, in its own frame.
    pub shape: Shape,
    /// Its pose in the compound.
    pub pose: Pose,
    placed: Shape,
    placed_faces: OnceLock<Box<[Option<u32>]>>,
    reach: f64,
    /// Whether the faces of the two are listed alike.
    is_listed_alike: bool,
}

impl Part {
    /// The shape in the compound's frame: what every answer is given for.
    pub fn placed(&self) -> &Shape {
        &self.placed
    }

    /// [`Shape::reach`] of the shape as it was given.
    pub fn reach(&self) -> f64 {
        self.reach
    }

    /// The cylinder or cone that [`Part::placed`] knows by its support map alone, since it was moved.
    pub fn moved_curved(&self) -> Option<&Curved> {
        match (&self.shape, &self.placed) {
            (Shape::Curved(curved), Shape::Custom(_)) => Some(curved),
            _ => None,
        }
    }

    /// Which face of [`Part::placed`] a face of the shape is there, by index: cuboids are placed as hulls, and the faces of a hull
    /// that is moved are listed anew, in another order. `None` of a face that is none of a polytope, or has no such place. All are found at the first
    /// call.
    pub fn placed_face(&self, face: u32) -> Option<u32> {
        if self.is_listed_alike {
            return Some(face);
        }
        let (own, placed) = (self.shape.as_polytope()?, self.placed.as_polytope()?);
        let found = || {
            let (own, placed) = (own.contact_facets(), placed.contact_facets());
            let place = |due: &[u32]| {
                let is_same = |corners: &[u32]| {
                    corners.len() == due.len() && corners.iter().all(|corner| due.contains(corner))
                };
                let at = placed.facets().iter().position(|facet| is_same(placed.corners(facet)))?;
                Some(at as u32)
            };
            own.facets().iter().map(|facet| place(own.corners(facet))).collect()
        };
        *self.placed_faces.get_or_init(found).get(face as usize)?
    }
}

/// A union of convex parts, which may overlap.
///
/// Each part is brought into the compound's frame once, when the compound is made: a polytope's
/// vertices R·v + t are rounded to f64 there, and those are the compound's vertices from then on.
/// A compound touches what one of its parts touches; a part inside another changes nothing.
#[derive(Clone, Debug)]
pub struct Compound {
    parts: Vec<Part>,
    /// Beside each other: parts keep their shapes elsewhere, and most are far from what is asked about.
    spheres: Box<[Sphere]>,
    tree: PartTree,
    reach: f64,
    swept_radius: f64,
}

impl Compound {
    /// A compound of at least one convex part and its place in the compound.
    ///
    /// # Errors
    /// No part at all, more than a u32 counts, a part that is itself made of parts or has no end,
    /// a vertex that is not finite once it is in its place.
    pub fn new(parts: Vec<(Shape, Pose)>) -> Result<Self, ShapeError> {
        let count = parts.len();
        if count == 0 {
            return Err(ShapeError::Empty);
        }
        if u32::try_from(count).is_err() {
            return Err(ShapeError::TooManyParts { count });
        }
        let place = |(part, (shape, pose)): (usize, (Shape, Pose))| {
            let placed = placed(part, &shape, &pose)?;
            // A hull's faces are listed anew where it was moved.
            let kind = |shape: &Shape| shape.as_polytope().map(Polytope::kind);
            let are_alike = kind(&shape).is_some() && kind(&shape) == kind(&placed);
            let is_kept = pose == Pose::IDENTITY || kind(&shape) != Some(Kind::Hull);
            let is_listed_alike = are_alike && is_kept;
            let (reach, placed_faces) = (shape.reach(), OnceLock::new());
            Ok(Part { shape, pose, placed, placed_faces, reach, is_listed_alike })
        };
        let parts = parts.into_iter().enumerate().map(place).collect::<Result<Vec<_>, _>>()?;
        let boxes: Vec<Aabb> = parts.iter().map(|part| part.placed.aabb(&Pose::IDENTITY)).collect();
        let reach = parts.iter().map(|part| part.placed.reach()).fold(0.0, f64::max);
        let swept_radius = parts.iter().map(|part| part.shape.radius()).fold(0.0, f64::max);
        let spheres = parts.iter().map(sphere_round).collect();
        Ok(Self { parts, spheres, tree: PartTree::over(&boxes), reach, swept_radius })
    }

    /// The same parts with a sphere of this radius swept round each, metres; replaces any other
    /// radius.
    ///
    /// # Errors
    /// A radius that is negative or not finite.
    pub fn rounded(&self, radius: f64) -> Result<Self, ShapeError> {
        self.with_parts(|shape| shape.clone().rounded(radius))
    }

    /// The same parts with this radius added to that of each: see [`Shape::swept`].
    ///
    /// # Errors
    /// A radius that is negative or not finite, by itself or when added.
    pub fn swept(&self, radius: f64) -> Result<Self, ShapeError> {
        self.with_parts(|shape| shape.swept(radius))
    }

    fn with_parts(
        &self,
        other: impl Fn(&Shape) -> Result<Shape, ShapeError>,
    ) -> Result<Self, ShapeError> {
        let parts = self.parts.iter().map(|part| Ok((other(&part.shape)?, part.pose)));
        Self::new(parts.collect::<Result<_, ShapeError>>()?)
    }

    /// The parts, in the order given.
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// A sphere round each part in the compound's frame, by index, metres: as it is placed there, and as it was given, at its
    /// pose. What rounding loses is counted.
    pub fn part_bounding_spheres(&self) -> &[Sphere] {
        &self.spheres
    }

    /// The tree over the parts.
    pub fn tree(&self) -> &PartTree {
        &self.tree
    }

    /// The largest distance of a point from the origin of the compound's frame, rounded up.
    pub fn reach(&self) -> f64 {
        self.reach
    }

    /// The largest radius of a sphere swept round the core of a part, metres.
    pub fn swept_radius(&self) -> f64 {
        self.swept_radius
    }
}

/// By how much the sphere round a part is larger than it would be without rounding, relative to its radius: what a pose may be off
/// a rotation, and a margin. Smaller: parts that stand out. Larger: more that are looked at.
const STRETCH: f64 = 4.0 * Pose::UNIT_TOLERANCE;

/// The same, relative to the part's reach and its place. Unit: 2⁻⁵³. Moving its points and its centre loses 8 of each.
const MOVED: f64 = 32.0;

/// A sphere round a part: see [`Compound::part_bounding_spheres`].
fn sphere_round(part: &Part) -> Sphere {
    let (centre, radius) = match &part.shape {
        Shape::Polytope(polytope) => {
            (polytope.inner().centre, polytope.outer_radius() + polytope.swept_radius())
        }
        _ => (DVec3::ZERO, part.reach),
    };
    let far = part.reach + part.pose.translation().length();
    let lost = MOVED * (f64::EPSILON / 2.0) * far + part.placed.support_error();
    Sphere { centre: part.pose.apply(centre), radius: radius * (1.0 + STRETCH) + lost }
}

/// A part in the compound's frame.
fn placed(part: usize, shape: &Shape, pose: &Pose) -> Result<Shape, ShapeError> {
    if !shape.is_convex() || !shape.reach().is_finite() {
        return Err(ShapeError::BadPart { part });
    }
    if *pose == Pose::IDENTITY {
        return Ok(shape.clone());
    }
    let Some(polytope) = shape.as_polytope() else {
        return Shape::custom(Arc::new(Moved { shape: shape.clone(), pose: *pose }));
    };
    match polytope.moved(pose).and_then(|hull| hull.rounded(polytope.swept_radius())) {
        Ok(polytope) => Ok(Shape::from(polytope)),
        Err(ShapeError::NotFinite { vertex, value }) => {
            Err(ShapeError::PartNotFinite { part, vertex, value })
        }
        Err(other) => Err(other),
    }
}

/// A shape known by its support map alone, at a place.
struct Moved {
    shape: Shape,
    pose: Pose,
}

impl SupportMap<f64> for Moved {
    fn support(&self, direction: DVec3) -> Support<f64> {
        let local = self.pose.rotation().transpose() * direction;
        let Support { point, feature } = self.shape.support(local);
        Support { point: self.pose.apply(point), feature }
    }

    fn radius(&self) -> f64 {
        self.shape.radius()
    }

    /// |Rᵀd|₁ ≤ √3·σ·|d|₁ turns the shape's own error; turning the direction and the point and
    /// moving the point lose 3u, 3u and 1u of what they work on, doubled.
    fn support_error(&self) -> f64 {
        let stretch = 1.0 + self.pose.deviation();
        let size = self.shape.reach() * stretch + self.pose.translation().abs().element_sum();
        1.7321 * stretch * self.shape.support_error() + 16.0 * (f64::EPSILON / 2.0) * size
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;

    fn at(x: f64) -> Pose {
        Pose::from_translation(DVec3::X * x).unwrap()
    }

    #[test]
    fn a_compound_without_parts_is_refused() {
        assert_eq!(Compound::new(vec![]).unwrap_err(), ShapeError::Empty);
    }

    #[test]
    fn a_compound_in_a_compound_is_refused_with_its_index() {
        let sphere = Shape::sphere(1.0).unwrap();
        let pair =
            Shape::compound(vec![(sphere.clone(), at(0.0)), (sphere.clone(), at(1.0))]).unwrap();
        let refused = Compound::new(vec![(sphere, at(2.0)), (pair, at(0.0))]).unwrap_err();
        assert_eq!(refused, ShapeError::BadPart { part: 1 });
    }

    #[test]
    fn a_vertex_that_overflows_in_its_place_is_named() {
        let far = Shape::hull(vec![DVec3::ZERO, DVec3::X * 1.5e308]).unwrap();
        let refused = Compound::new(vec![(far, at(1.5e308))]).unwrap_err();
        let value = f64::INFINITY;
        assert_eq!(refused, ShapeError::PartNotFinite { part: 0, vertex: 1, value });
    }

    #[test]
    fn parts_stand_where_they_were_put() {
        let cube = Shape::cuboid(DVec3::splat(0.5)).unwrap();
        let turned = Pose::new(DQuat::from_rotation_z(0.5), DVec3::new(3.0, 0.0, 0.0)).unwrap();
        let compound = Shape::compound(vec![(cube.clone(), at(-3.0)), (cube, turned)]).unwrap();
        let aabb = compound.aabb(&at(1.0));
        assert!(aabb.min.x <= -2.5 && aabb.min.x > -2.5001);
        assert!(aabb.max.x > 4.5 && aabb.max.x < 4.8);
        assert!(compound.reach() > 3.5 && compound.reach() < 4.0);
    }

    #[test]
    fn a_face_of_a_part_has_the_same_corners_where_it_is_placed() {
        let corner = |k: u32| {
            DVec3::from([1, 2, 4].map(|bit| if k & bit == 0 { -0.5 } else { 0.5 }))
                * DVec3::new(1.0, 2.0, 3.0)
        };
        let hull = Shape::hull((0..8).map(corner).collect()).unwrap();
        let (mut named, mut moved) = (0, 0);
        for shape in [hull, Shape::cuboid(DVec3::new(0.3, 0.2, 0.1)).unwrap()] {
            for k in 0..40 {
                let turn = DQuat::from_scaled_axis(DVec3::new(0.1, 0.2, -0.3) * f64::from(k));
                let pose = Pose::new(turn, DVec3::splat(0.1 * f64::from(k))).unwrap();
                let compound = Compound::new(vec![(shape.clone(), pose)]).unwrap();
                let part = &compound.parts()[0];
                let [own, placed] =
                    [&part.shape, part.placed()].map(|shape| shape.as_polytope().unwrap().facets());
                let sorted = |corners: &[u32]| {
                    let mut corners = corners.to_vec();
                    corners.sort_unstable();
                    corners
                };
                for (face, facet) in (0..).zip(own.facets()) {
                    let Some(there) = part.placed_face(face) else { continue };
                    let found = &placed.facets()[there as usize];
                    assert_eq!(sorted(own.corners(facet)), sorted(placed.corners(found)), "{k}");
                    named += 1;
                    moved += usize::from(there != face);
                }
            }
        }
        assert!(named > 400 && moved > 0, "{named} {moved}");
    }

    #[test]
    fn sweeping_adds_to_each_radius_and_rounding_replaces_it() {
        let parts = vec![
            (Shape::sphere(1.0).unwrap(), at(2.0)),
            (Shape::cuboid(DVec3::ONE).unwrap(), at(0.0)),
        ];
        let compound = Compound::new(parts).unwrap();
        let radii = |compound: Compound| -> Vec<f64> {
            compound.parts().iter().map(|part| part.placed().radius()).collect()
        };
        assert_eq!(radii(compound.swept(0.25).unwrap()), [1.25, 0.25]);
        assert_eq!(radii(compound.rounded(0.25).unwrap()), [0.25, 0.25]);
        assert!(compound.rounded(f64::NAN).is_err() && compound.swept(-1.0).is_err());
    }

    #[test]
    fn a_moved_support_map_is_the_map_of_the_moved_shape() {
        struct Cube;
        impl SupportMap<f64> for Cube {
            fn support(&self, d: DVec3) -> Support<f64> {
                Support { point: DVec3::ONE.copysign(d), feature: 0 }
            }
        }
        let cube = Shape::custom(Arc::new(Cube)).unwrap();
        let pose = Pose::new(DQuat::from_rotation_y(0.3), DVec3::new(1.0, 2.0, 3.0)).unwrap();
        let moved = Moved { shape: cube, pose };
        let hull = Polytope::cuboid(DVec3::ONE).unwrap();
        for d in [DVec3::X, DVec3::new(1.0, -2.0, 0.5), -DVec3::Z] {
            let local = pose.rotation().transpose() * d;
            let expected = d.dot(pose.apply(SupportMap::<f64>::support(&hull, local).point));
            let error = moved.support_error() * d.abs().element_sum();
            assert!((d.dot(moved.support(d).point) - expected).abs() <= error);
        }
        assert!(moved.support_error() < 1e-13);
    }
}
