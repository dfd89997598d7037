//! Hulls of points, with or without a radius: the shape of the lanes.

use crate::error::check_length;
use crate::facets::AllFacets;
use crate::sphere::{Sphere, reach};
use crate::support::{FarthestVertex, farthest};
use crate::{
    FacetPlanes, Facets, FeatureRows, ObbBounds, Pose, Real, ShapeError, Support, SupportMap,
};
use dcd_simd::{Block, WIDTH, dispatch};
use glam::DVec3;
use std::sync::OnceLock;

/// The kind of a polytope: the parameters that a closed form, or another library, needs.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Kind {
    /// The hull of its vertices.
    Hull,
    /// One vertex; with a radius, a sphere.
    Point,
    /// Two vertices; with a radius, a capsule.
    Segment,
    /// Three vertices.
    Triangle,
    /// The cuboid of these half extents round the origin, metres.
    Cuboid {
        /// Half the edge along x, y and z.
        half_extents: DVec3,
    },
}

/// The hull of at least one point, rounded by a radius of at least 0.
///
/// The points are taken as they are: they may be inside the hull, repeated, coplanar, collinear,
/// or one alone. Made and checked once; whatever depends on the shape alone is computed here.
///
/// ```
/// use dcd_geom::glam::DVec3;
/// use dcd_geom::Polytope;
/// let cube = Polytope::cuboid(DVec3::splat(0.5))?;
/// assert_eq!((cube.vertices().len(), cube.swept_radius()), (8, 0.0));
/// let rounded = cube.rounded(0.1)?; // grows by 0.1 on all sides
/// assert_eq!(rounded.swept_radius(), 0.1);
/// # Ok::<(), dcd_geom::ShapeError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Polytope {
    kind: Kind,
    vertices: Vec<DVec3>,
    radius: f64,
    inner: Sphere,
    outer_radius: f64,
    obb: Option<Box<ObbBounds>>,
    reach: f64,
    blocks: Box<[Block]>,
    facets: OnceLock<AllFacets>,
    planes: OnceLock<FacetPlanes>,
    feature_rows: OnceLock<Option<Box<FeatureRows>>>,
}

impl Polytope {
    /// The hull of the points, in the shape's own frame, metres. Costs microseconds.
    ///
    /// # Errors
    /// No point at all, a number that is not finite, or more points than a u32 counts.
    pub fn hull(vertices: Vec<DVec3>) -> Result<Self, ShapeError> {
        check_vertices(&vertices)?;
        let inner = Sphere::inside(&vertices);
        Ok(Self::from_parts(Kind::Hull, vertices, inner))
    }

    /// A sphere round the origin.
    ///
    /// # Errors
    /// A radius that is negative or not finite.
    pub fn sphere(radius: f64) -> Result<Self, ShapeError> {
        let centre = Sphere { centre: DVec3::ZERO, radius: 0.0 };
        Self::from_parts(Kind::Point, vec![DVec3::ZERO], centre).rounded(radius)
    }

    /// The segment between two points, metres. With a radius, a capsule anywhere.
    ///
    /// # Errors
    /// A number that is not finite.
    pub fn segment(from: DVec3, to: DVec3) -> Result<Self, ShapeError> {
        Self::flat(Kind::Segment, vec![from, to])
    }

    /// A capsule round the z axis, its middle at the origin: a sphere of `radius` swept from
    /// z = −`half_height` to z = `half_height`; metres.
    ///
    /// # Errors
    /// A half height or radius that is negative or not finite.
    pub fn capsule(half_height: f64, radius: f64) -> Result<Self, ShapeError> {
        check_length("half height", half_height)?;
        Self::segment(DVec3::Z * -half_height, DVec3::Z * half_height)?.rounded(radius)
    }

    /// The triangle between three points, metres.
    ///
    /// # Errors
    /// A number that is not finite.
    pub fn triangle(corners: [DVec3; 3]) -> Result<Self, ShapeError> {
        Self::flat(Kind::Triangle, corners.to_vec())
    }

    /// The same without a box: for a triangle of a mesh that is made for one pair.
    ///
    /// # Errors
    /// A number that is not finite.
    pub fn mesh_triangle(corners: [DVec3; 3]) -> Result<Self, ShapeError> {
        check_vertices(&corners)?;
        let centre = Sphere::at_mean(&corners);
        Ok(Self::with_obb(Kind::Triangle, corners.to_vec(), centre, None))
    }

    /// A convex polygon: its corners counter-clockwise as `normal`, of unit length, looks back on them; or a
    /// segment or a point, whose normal does not count. Without a box, and its faces are known: for what a shape
    /// shows of itself to one pair.
    ///
    /// # Errors
    /// No corner, or a number that is not finite.
    pub fn polygon(corners: Vec<DVec3>, normal: DVec3) -> Result<Self, ShapeError> {
        check_vertices(&corners)?;
        let centre = Sphere::at_mean(&corners);
        let facets = Facets::of_polygon(corners.len(), normal);
        let polygon = Self::with_obb(Kind::Hull, corners, centre, None);
        Ok(Self { facets: OnceLock::from(AllFacets::alike(facets)), ..polygon })
    }

    /// Points in one plane: there is no sphere inside, and the centre is their mean.
    fn flat(kind: Kind, vertices: Vec<DVec3>) -> Result<Self, ShapeError> {
        check_vertices(&vertices)?;
        let centre = Sphere::at_mean(&vertices);
        Ok(Self::from_parts(kind, vertices, centre))
    }

    /// A cuboid round the origin.
    ///
    /// # Errors
    /// A half extent that is negative or not finite.
    pub fn cuboid(half_extents: DVec3) -> Result<Self, ShapeError> {
        for value in half_extents.to_array() {
            check_length("half extent", value)?;
        }
        let corner = |k: u32| {
            let sign = |bit: u32| if k >> bit & 1 == 0 { -1.0 } else { 1.0 };
            half_extents * DVec3::new(sign(0), sign(1), sign(2))
        };
        let inner = Sphere { centre: DVec3::ZERO, radius: half_extents.min_element() };
        Ok(Self::from_parts(Kind::Cuboid { half_extents }, (0..8).map(corner).collect(), inner))
    }

    /// The same core with a sphere of this radius swept round it, metres; replaces any other radius.
    ///
    /// # Errors
    /// A radius that is negative or not finite.
    pub fn rounded(mut self, radius: f64) -> Result<Self, ShapeError> {
        check_length("radius", radius)?;
        self.radius = radius;
        Ok(self)
    }

    /// The hull of the vertices R·v + t, each rounded; without the radius. A cuboid keeps its OBBs,
    /// one a little larger and one a little smaller.
    ///
    /// # Errors
    /// A vertex that is not finite in its place.
    pub(crate) fn moved(&self, pose: &Pose) -> Result<Self, ShapeError> {
        let vertices: Vec<DVec3> = self.vertices.iter().map(|&v| pose.apply(v)).collect();
        let turned = match self.kind {
            Kind::Cuboid { half_extents } => {
                let size = half_extents.length() + pose.translation().length();
                ObbBounds::of_cuboid(half_extents).rotated(pose, size)
            }
            _ => None,
        };
        let Some(obb) = turned else { return Self::hull(vertices) };
        check_vertices(&vertices)?;
        let inner = Sphere { centre: pose.translation(), radius: obb.inner.min_element() };
        Ok(Self::with_obb(Kind::Hull, vertices, inner, Some(obb)))
    }

    fn from_parts(kind: Kind, vertices: Vec<DVec3>, inner: Sphere) -> Self {
        let obb = match kind {
            Kind::Cuboid { half_extents } => Some(ObbBounds::of_cuboid(half_extents)),
            _ => {
                let outer_radius = Sphere::around(inner.centre, &vertices).radius;
                ObbBounds::of_hull(&vertices, inner, outer_radius)
            }
        };
        Self::with_obb(kind, vertices, inner, obb).with_blocks()
    }

    /// With [`Polytope::vertex_blocks`], where they are worth their memory and f32 has the range.
    fn with_blocks(mut self) -> Self {
        let range = WIDEST_IN_F32.recip()..WIDEST_IN_F32;
        if self.vertices.len() >= MIN_VERTICES_IN_BLOCKS && range.contains(&self.outer_radius) {
            self.blocks = Block::relative(&self.vertices, self.inner.centre).collect();
        }
        self
    }

    fn with_obb(kind: Kind, vertices: Vec<DVec3>, inner: Sphere, obb: Option<ObbBounds>) -> Self {
        let outer_radius = Sphere::around(inner.centre, &vertices).radius;
        let obb = obb.map(Box::new);
        let reach = reach(vertices.iter().copied());
        let (facets, planes, feature_rows) = Default::default();
        Self {
            kind,
            vertices,
            radius: 0.0,
            inner,
            outer_radius,
            obb,
            reach,
            blocks: Box::default(),
            facets,
            planes,
            feature_rows,
        }
    }

    /// Its kind and parameters.
    pub fn kind(&self) -> Kind {
        self.kind
    }

    /// The points whose hull is the core, in the order given.
    pub fn vertices(&self) -> &[DVec3] {
        &self.vertices
    }

    /// The radius swept round the core, metres.
    pub fn swept_radius(&self) -> f64 {
        self.radius
    }

    /// A sphere inside the core. Its centre is the point that the lanes count from. Of radius 0 where
    /// the core is flat: the centre is then within 2.02·2⁻⁵³ of [`Polytope::reach`] from the core.
    pub fn inner(&self) -> Sphere {
        self.inner
    }

    /// The radius of a sphere round [`Polytope::inner`]'s centre that holds the core, rounded up.
    pub fn outer_radius(&self) -> f64 {
        self.outer_radius
    }

    /// The faces of the core: computed at the first call, then shared by all objects, threads and frames.
    #[inline]
    pub fn facets(&self) -> &Facets {
        self.all_facets().exact()
    }

    /// The faces that contacts show: those of [`Polytope::facets`], but that vertices within 1e-5 of the extent of a face's
    /// plane count as in it. A box whose corners were rounded to f32, or to six decimals, has six faces of four corners here, and twelve
    /// triangles there.
    #[inline]
    pub fn contact_facets(&self) -> &Facets {
        &self.all_facets().contact
    }

    #[inline]
    fn all_facets(&self) -> &AllFacets {
        match self.facets.get() {
            Some(facets) => facets,
            None => self.derived_facets(),
        }
    }

    #[cold]
    fn derived_facets(&self) -> &AllFacets {
        let found = || match (self.kind, &*self.vertices) {
            (Kind::Triangle, &[a, b, c]) => AllFacets::alike(Facets::of_triangle([a, b, c])),
            (Kind::Cuboid { half_extents }, vertices) if is_thin(half_extents) => {
                // A cube's faces have the same corners and normals. On a lattice those of a plate would be one.
                let cube: Vec<DVec3> = vertices.iter().map(|vertex| vertex.signum()).collect();
                AllFacets::alike(Facets::of(&cube))
            }
            (Kind::Hull, vertices) => AllFacets::of_hull(vertices),
            _ => AllFacets::alike(Facets::of(&self.vertices)),
        };
        self.facets.get_or_init(found)
    }

    /// Prefetches the faces if they are known already, but not what is around a vertex: a hint, without effect on any
    /// result.
    #[inline]
    pub fn prefetch_facets(&self) {
        if self.facets.get().is_some() {
            self.contact_facets().prefetch();
        }
    }

    /// Prefetches what is around a vertex, by index, if the faces are known already: a hint, without effect on any result.
    #[inline]
    pub fn prefetch_half_edges(&self, vertex: u32) {
        if self.facets.get().is_some() {
            self.contact_facets().prefetch_half_edges(vertex);
        }
    }

    /// The unit normal of a triangle that is no needle, round which its corners go counter-clockwise: that of the first
    /// of its [`Polytope::facets`], without them. `None` for needles and other kinds.
    #[inline]
    pub fn normal_of_triangle(&self) -> Option<DVec3> {
        match (self.kind, &*self.vertices) {
            (Kind::Triangle, &[a, b, c]) => crate::facets::normal_of_triangle([a, b, c]),
            _ => None,
        }
    }

    /// Prefetches the planes of the faces if they are known already: a hint, without effect on any result.
    #[inline]
    pub fn prefetch_planes(&self) {
        if let Some(planes) = self.planes.get() {
            planes.prefetch();
        }
    }

    /// The planes of the core's faces, and what is proved of them: derived on first use, then shared like the
    /// faces.
    pub fn planes(&self) -> &FacetPlanes {
        self.planes.get_or_init(|| FacetPlanes::of(self))
    }

    /// The faces and edges of a solid core for lanes; `None` of others. Derived on first use, then shared like the faces.
    #[inline]
    pub fn feature_rows(&self) -> Option<&FeatureRows> {
        self.feature_rows.get_or_init(|| FeatureRows::of(self).map(Box::new)).as_deref()
    }

    /// An OBB round the core and one inside it, where they are tighter than the spheres: for cuboids and
    /// shapes that are long or flat.
    pub fn obb(&self) -> Option<&ObbBounds> {
        self.obb.as_deref()
    }

    /// The largest distance of a vertex from the origin of the shape's own frame, rounded up.
    pub fn reach(&self) -> f64 {
        self.reach
    }

    /// The vertices in their order, relative to [`Polytope::inner`]'s centre in f32, metres: sixteen a block, the last
    /// one filled up with the last vertex. Empty for few vertices, for shapes that are made for one pair, and for sizes
    /// beyond 2^±40 m.
    pub fn vertex_blocks(&self) -> &[Block] {
        &self.blocks
    }
}

/// From how many vertices on a polytope keeps them in f32 as well. Smaller: memory for shapes whose supports are as
/// quick without.
const MIN_VERTICES_IN_BLOCKS: usize = WIDTH / 2 + 1;

/// The least half extent of a cuboid whose faces are those of its vertices, relative to the largest: [`Facets`] sees them on a
/// lattice of 2⁻³⁸ of the extent. Smaller: opposite faces that are taken for one.
const THIN: f64 = 1.0 / (1u64 << 30) as f64;

/// Whether a cuboid that is not flat is thinner than that.
fn is_thin(half_extents: DVec3) -> bool {
    let least = half_extents.min_element();
    least > 0.0 && least < THIN * half_extents.max_element()
}

/// From how many of those blocks on supports are sought in them. Smaller: what is saved is less than a kernel costs. No
/// effect on any answer.
const MIN_BLOCKS_TO_SCAN: usize = 2;

/// The largest outer radius of a polytope that keeps its vertices in f32, and the reciprocal of the smallest: no product
/// of a coordinate and a direction comes near the ends of f32. Metres.
const WIDEST_IN_F32: f64 = (1u64 << 40) as f64;

impl<R: Real> SupportMap<R> for Polytope {
    #[inline]
    fn support(&self, direction: R::Vec3) -> Support<R> {
        if self.blocks.len() < MIN_BLOCKS_TO_SCAN {
            farthest(&self.vertices, direction)
        } else {
            dispatch(FarthestVertex(self, direction))
        }
    }

    fn radius(&self) -> R {
        R::from_f64(self.radius)
    }
}

fn check_vertices(vertices: &[DVec3]) -> Result<(), ShapeError> {
    check_count(vertices.len())?;
    for (vertex, v) in vertices.iter().enumerate() {
        if let Some(&value) = v.to_array().iter().find(|x| !x.is_finite()) {
            return Err(ShapeError::NotFinite { vertex, value });
        }
    }
    Ok(())
}

/// Checks that a shape may have this many vertices.
fn check_count(count: usize) -> Result<(), ShapeError> {
    match u32::try_from(count) {
        Ok(0) => Err(ShapeError::Empty),
        Ok(_) => Ok(()),
        Err(_) => Err(ShapeError::TooManyVertices { count }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_empty_hull_is_refused() {
        assert_eq!(Polytope::hull(vec![]).unwrap_err(), ShapeError::Empty);
    }

    #[test]
    fn a_vertex_that_is_not_finite_is_named() {
        let points = vec![DVec3::ZERO, DVec3::new(0.0, f64::NEG_INFINITY, 0.0)];
        let refused = Polytope::hull(points).unwrap_err();
        assert_eq!(refused, ShapeError::NotFinite { vertex: 1, value: f64::NEG_INFINITY });
        let nan = Polytope::hull(vec![DVec3::NAN]).unwrap_err();
        assert!(matches!(nan, ShapeError::NotFinite { vertex: 0, value } if value.is_nan()));
    }

    #[test]
    fn segments_triangles_and_capsules_have_their_vertices_and_kinds() {
        let segment = Polytope::segment(DVec3::X, DVec3::Y).unwrap();
        assert_eq!(
            (segment.kind(), segment.vertices()),
            (Kind::Segment, &[DVec3::X, DVec3::Y][..])
        );
        let capsule = Polytope::capsule(2.0, 0.5).unwrap();
        assert_eq!((capsule.kind(), capsule.swept_radius()), (Kind::Segment, 0.5));
        assert_eq!(capsule.vertices(), [DVec3::Z * -2.0, DVec3::Z * 2.0]);
        assert_eq!(capsule.inner(), Sphere { centre: DVec3::ZERO, radius: 0.0 });
        let triangle = Polytope::triangle([DVec3::X, DVec3::Y, DVec3::Z]).unwrap();
        assert!(triangle.kind() == Kind::Triangle && triangle.outer_radius() < 0.8165);
        let refused = Polytope::segment(DVec3::X, DVec3::NAN).unwrap_err();
        assert!(matches!(refused, ShapeError::NotFinite { vertex: 1, .. }));
        let refused = Polytope::capsule(-1.0, 0.5).unwrap_err();
        assert_eq!(refused, ShapeError::BadLength { what: "half height", value: -1.0 });
    }

    #[test]
    fn hulls_keep_their_vertices_in_blocks_and_small_shapes_do_not() {
        let points: Vec<_> = (0..20u32)
            .map(|k| DVec3::new(f64::from(k), f64::from(k * k % 7), f64::from(k % 3)))
            .collect();
        let hull = Polytope::hull(points.clone()).unwrap();
        assert_eq!(hull.vertex_blocks().len(), 2);
        for (k, point) in points.iter().enumerate() {
            let relative = hull.vertex_blocks()[k / WIDTH].point(k % WIDTH);
            assert_eq!(relative, (*point - hull.inner().centre).as_vec3());
        }
        let cube = Polytope::cuboid(DVec3::ONE).unwrap();
        let tiny = Polytope::hull(points.iter().map(|p| *p * 1e-30).collect()).unwrap();
        assert!(cube.vertex_blocks().is_empty() && tiny.vertex_blocks().is_empty());
    }

    #[test]
    fn a_count_past_u32_is_refused() {
        assert_eq!(check_count(u32::MAX as usize), Ok(()));
        let count = u32::MAX as usize + 1;
        assert_eq!(check_count(count), Err(ShapeError::TooManyVertices { count }));
    }

    #[test]
    fn bad_lengths_are_refused_with_their_value() {
        for bad in [-1.0, f64::INFINITY, f64::NAN] {
            assert!(matches!(
                Polytope::sphere(bad),
                Err(ShapeError::BadLength { what: "radius", .. })
            ));
            let half = DVec3::new(1.0, bad, 1.0);
            assert!(matches!(
                Polytope::cuboid(half),
                Err(ShapeError::BadLength { what: "half extent", .. })
            ));
        }
    }
}
