//! The spheres that cover what each link carries.

use super::covers::{CoverSphere, Covers, STRETCH};
use super::separate::MOST_BLOCKS;
use super::solids::{inner_radius, margin_of};
use crate::Robot;
use crate::kinematics::JointFrame;
use dcd_geom::{ConvexHull, Shape};
use dcd_simd::{Block, Row, WIDTH};
use glam::{DVec3, Vec3};

/// A shape that moves with a link.
pub(super) struct Body<'a> {
    /// Its number, by which hits name it.
    pub(super) number: u32,
    pub(super) link: usize,
    pub(super) shape: &'a Shape,
    /// Its frame in the link's.
    pub(super) origin: JointFrame,
}

/// The most points of a mesh whose hull is found. More: some take the square of that to prepare.
pub(crate) const MESH_POINTS: usize = 1 << 16;

/// The vertices of a body that is a hull, or of a mesh's hull, in its link's frame: planes part either.
#[derive(Clone, Debug)]
pub(super) struct BodyHull {
    pub(super) link: usize,
    pub(super) blocks: Vec<Block>,
    /// What is swept round it, metres, rounded up.
    pub(super) swept: f32,
}

impl BodyHull {
    /// `None` for a body without a hull of vertices, and for a point, which its sphere covers exactly.
    pub(super) fn of(body: &Body<'_>) -> Option<Self> {
        let (vertices, swept) = match body.shape {
            Shape::Polytope(polytope) => (polytope.vertices().to_vec(), polytope.swept_radius()),
            Shape::Mesh(mesh) if mesh.points().len() <= MESH_POINTS => {
                let (points, hull) = (mesh.points(), ConvexHull::of(mesh.points()).ok()?);
                let corners = hull.corners().iter().map(|&k| points[k as usize]);
                (corners.collect(), mesh.swept_radius())
            }
            _ => return None,
        };
        let JointFrame { rotation, translation } = body.origin;
        let vertices: Vec<DVec3> = vertices.iter().map(|&v| rotation * v + translation).collect();
        let count = vertices.len().div_ceil(WIDTH);
        let swept = (swept as f32).next_up();
        (vertices.len() > 1 && count <= MOST_BLOCKS).then(|| Self {
            link: body.link,
            blocks: Block::relative(&vertices, DVec3::ZERO).collect(),
            swept,
        })
    }
}

/// Sixteen spheres on a link, those of one body next to each other.
#[derive(Clone, Debug, Default)]
pub(super) struct SphereRow {
    /// In the link's frame, metres.
    pub(super) centre: Block,
    /// Below 0 where there is none.
    pub(super) outer: Row,
    pub(super) inner: Row,
    /// The body that each covers.
    pub(super) bodies: [u32; WIDTH],
    /// All that cover the same body, a bit each.
    pub(super) same: [u32; WIDTH],
    /// Those that there are.
    pub(super) filled: u32,
}

/// What a link carries.
#[derive(Clone, Debug, Default)]
pub(super) struct LinkSpheres {
    pub(super) link: usize,
    /// A sphere round all of it, in the link's frame, metres.
    pub(super) centre: Vec3,
    pub(super) radius: f32,
    /// By how much a comparison may be off, beside what the link's place adds, metres.
    pub(super) margin: f32,
    /// By how much for the rounding of the link's place, [`FrameError::of_size`](super::chain::FrameError::of_size), the
    /// first number with `margin`: found with the chain.
    pub(super) lost: [f32; 2],
    /// How far from the link's origin any of it is at most, metres.
    pub(super) size: f32,
    pub(super) rows: Vec<SphereRow>,
}

/// The spheres of all links that carry any of the bodies, in the order of the links.
pub(super) fn links(robot: &Robot, bodies: &[Body<'_>], covers: &mut Covers) -> Vec<LinkSpheres> {
    let mut of_link: Vec<Vec<&Body<'_>>> = vec![Vec::new(); robot.links.len()];
    bodies.iter().for_each(|body| of_link[body.link].push(body));
    let carrying = of_link.iter().enumerate().filter(|(_, bodies)| !bodies.is_empty());
    carrying.map(|(link, bodies)| LinkSpheres::of(link, bodies, covers)).collect()
}

impl LinkSpheres {
    /// The bodies that the spheres cover.
    pub(super) fn bodies(&self) -> Vec<u32> {
        let filled = |row: &SphereRow| row.filled.count_ones() as usize;
        let all = self.rows.iter().flat_map(|row| row.bodies[..filled(row)].to_vec());
        let mut bodies: Vec<u32> = all.collect();
        bodies.dedup();
        bodies
    }

    fn of(link: usize, bodies: &[&Body<'_>], known: &mut Covers) -> Self {
        // A row holds the spheres of all bodies where there are few of them.
        let each = (WIDTH / bodies.len()).max(1);
        let covers: Vec<(u32, Vec<CoverSphere>)> = bodies
            .iter()
            .map(|body| {
                let spheres = known.of(body.shape, each).into_iter();
                (body.number, spheres.map(|sphere| placed(sphere, &body.origin)).collect())
            })
            .collect();
        let all = || covers.iter().flat_map(|(_, spheres)| spheres);
        let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (min, max) = all().fold(none, |(min, max), sphere| {
            (min.min(sphere.centre - sphere.outer), max.max(sphere.centre + sphere.outer))
        });
        let middle = min * 0.5 + max * 0.5;
        // Of what has no end there is no middle.
        let middle = if middle.is_finite() { middle } else { DVec3::ZERO };
        let radius = |sphere: &CoverSphere| middle.distance(sphere.centre) + sphere.outer;
        let radius = all().map(radius).fold(0.0, f64::max);
        let size = |sphere: &CoverSphere| sphere.centre.abs().element_sum() + 2.0 * sphere.outer;
        let size = all().map(size).fold(0.0, f64::max);
        let mut rows: Vec<SphereRow> = Vec::new();
        let mut used = WIDTH;
        for (number, spheres) in &covers {
            if used + spheres.len() > WIDTH {
                rows.push(SphereRow::empty());
                used = 0;
            }
            if let Some(row) = rows.last_mut() {
                row.add(used, *number, spheres);
            }
            used += spheres.len();
        }
        let size = size + middle.abs().element_sum() + radius;
        let (margin, size) = (margin_of(size), (size as f32).next_up());
        let (centre, radius) = (middle.as_vec3(), radius as f32);
        Self { link, centre, radius, margin, lost: [0.0; 2], size, rows }
    }
}

impl SphereRow {
    fn empty() -> Self {
        let nothing = Row([f32::NEG_INFINITY; WIDTH]);
        Self { outer: nothing, inner: nothing, ..Self::default() }
    }

    /// Adds the spheres of a body from a place on where they all fit.
    fn add(&mut self, from: usize, body: u32, spheres: &[CoverSphere]) {
        let same = ((1u32 << spheres.len()) - 1) << from;
        for (k, sphere) in (from..).zip(spheres) {
            let Block(rows) = &mut self.centre;
            for (row, x) in rows.iter_mut().zip(sphere.centre.as_vec3().to_array()) {
                row.0[k] = x;
            }
            self.outer.0[k] = sphere.outer as f32;
            self.inner.0[k] = inner_radius(sphere.inner);
            (self.bodies[k], self.same[k]) = (body, same);
        }
        self.filled |= same;
    }
}

/// In the link's frame; the radii as much larger and smaller as a matrix that just passes for a rotation could
/// make what they stand for, but those of points, which no matrix changes.
fn placed(sphere: CoverSphere, origin: &JointFrame) -> CoverSphere {
    let centre = origin.rotation * sphere.centre + origin.translation;
    let is_exact = sphere.inner == sphere.outer;
    let stretch = if is_exact { 0.0 } else { STRETCH };
    CoverSphere {
        centre,
        outer: sphere.outer * (1.0 + stretch),
        inner: if sphere.inner > 0.0 { sphere.inner * (1.0 - stretch) } else { sphere.inner },
    }
}
