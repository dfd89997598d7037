//! From bytes to numbers, shapes and poses.
//!
//! Numbers are made so that a fuzzer's small changes meet what is hard: a coarse grid (faces and
//! edges meet exactly), floats a few ulps off it, powers of two to the ends of the range, and any
//! bits at all, NaN included. Each function is `None` at the bytes' end, and where a constructor
//! refuses what it was given.

use dcd_geom::{Polytope, Pose, Shape};
use glam::{DMat3, DQuat, DVec3};

/// A shape's first byte from which on it is no polytope.
const RARE: u8 = 224;

/// One more than the parts of a compound or a mesh at most: enough for a second row of sixteen boxes.
const PARTS: u8 = 20;

/// Bytes that are read from the front.
#[derive(Clone, Copy, Debug)]
pub struct Input<'a>(pub &'a [u8]);

impl Input<'_> {
    /// The next byte.
    pub fn byte(&mut self) -> Option<u8> {
        let (&first, rest) = self.0.split_first()?;
        self.0 = rest;
        Some(first)
    }

    fn bytes<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (first, rest) = self.0.split_first_chunk::<N>()?;
        self.0 = rest;
        Some(*first)
    }

    /// A number; mostly eighths between −8 and 8.
    pub fn number(&mut self) -> Option<f64> {
        let tag = self.byte()?;
        let eighths = |byte: u8| f64::from(byte as i8) / 8.0;
        Some(match tag {
            0..=63 | 192..=255 => eighths(tag),
            64..=95 => {
                let near = eighths(self.byte()?).to_bits() as i64;
                f64::from_bits(near.wrapping_add(i64::from(tag) - 80) as u64)
            }
            96..=111 => f64::from(i16::from_le_bytes(self.bytes()?)) / 4096.0,
            112..=143 => {
                let [mantissa, exponent] = self.bytes()?;
                eighths(mantissa) * 2f64.powi(i32::from(exponent as i8) * 8)
            }
            144..=167 => f64::from(f32::from_le_bytes(self.bytes()?)),
            168..=191 => f64::from_le_bytes(self.bytes()?),
        })
    }

    /// Three numbers.
    pub fn vector(&mut self) -> Option<DVec3> {
        Some(DVec3::new(self.number()?, self.number()?, self.number()?))
    }

    /// Up to sixteen points.
    pub fn points(&mut self) -> Option<Vec<DVec3>> {
        let count = self.byte()? % 17;
        (0..count).map(|_| self.vector()).collect()
    }

    /// A polytope, rounded or not.
    pub fn polytope(&mut self) -> Option<Polytope> {
        let kind = self.byte()?;
        let core = match kind % 8 {
            0 | 4 => Polytope::cuboid(self.vector()?.abs()),
            1 => Polytope::sphere(self.number()?),
            3 => Polytope::segment(self.vector()?, self.vector()?),
            5 => Polytope::capsule(self.number()?, self.number()?),
            7 => Polytope::triangle([self.vector()?, self.vector()?, self.vector()?]),
            _ => Polytope::hull(self.points()?),
        };
        let core = core.ok()?;
        if kind & 16 == 0 { Some(core) } else { core.rounded(self.number()?.abs()).ok() }
    }

    /// A shape of any kind, most of them polytopes.
    pub fn shape(&mut self) -> Option<Shape> {
        if !self.0.first().is_some_and(|&kind| kind >= RARE && kind % 4 == 3) {
            return self.convex();
        }
        let kind = self.byte()?;
        let core = if kind & 8 == 0 { self.compound() } else { self.mesh() };
        self.perhaps_rounded(kind, core?)
    }

    fn compound(&mut self) -> Option<Shape> {
        let count = self.byte()? % PARTS;
        let parts = (0..count).map(|_| Some((self.convex()?, self.pose()?)));
        Shape::compound(parts.collect::<Option<_>>()?).ok()
    }

    fn mesh(&mut self) -> Option<Shape> {
        let vertices = self.points()?;
        let count = self.byte()? % PARTS;
        let corner = |byte: u8| u32::from(byte) % (vertices.len().max(1) as u32);
        let triangles = (0..count).map(|_| Some(self.bytes()?.map(corner)));
        let triangles = triangles.collect::<Option<_>>()?;
        Shape::mesh(vertices, triangles).ok()
    }

    /// A shape without parts, most of them polytopes.
    fn convex(&mut self) -> Option<Shape> {
        let (&kind, _) = self.0.split_first()?;
        if kind < RARE {
            return self.polytope().map(Shape::from);
        }
        self.byte()?;
        let core = match kind % 4 {
            0 => Shape::half_space(self.vector()?, self.number()?),
            1 => Shape::cone(self.number()?, self.number()?),
            2 => Shape::ellipsoid(self.vector()?),
            _ => Shape::cylinder(self.number()?, self.number()?),
        };
        self.perhaps_rounded(kind, core.ok()?)
    }

    fn perhaps_rounded(&mut self, kind: u8, core: Shape) -> Option<Shape> {
        if kind & 16 == 0 { Some(core) } else { core.rounded(self.number()?.abs()).ok() }
    }

    /// A pose.
    pub fn pose(&mut self) -> Option<Pose> {
        let kind = self.byte()?;
        match kind % 4 {
            0 => Pose::from_translation(self.vector()?),
            1 => Pose::from_matrix(quarter_turn(kind), self.vector()?),
            2 => {
                let [x, y, z, w] = [self.number()?, self.number()?, self.number()?, self.number()?];
                let turn = DQuat::from_xyzw(x, y, z, w);
                let unit = turn.normalize();
                Pose::new(if unit.is_finite() { unit } else { turn }, self.vector()?)
            }
            _ => {
                let columns = [self.vector()?, self.vector()?, self.vector()?];
                let [x, y, z] = columns;
                Pose::from_matrix(DMat3::from_cols(x, y, z), self.vector()?)
            }
        }
        .ok()
    }
}

/// One of the turns that map the axes to each other.
fn quarter_turn(kind: u8) -> DMat3 {
    let cycle = DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X);
    let quarter = DMat3::from_cols(DVec3::Y, -DVec3::X, DVec3::Z);
    let half = DMat3::from_cols(DVec3::X, -DVec3::Y, -DVec3::Z);
    let power = |turn: DMat3, times: u8| (0..times).fold(DMat3::IDENTITY, |m, _| m * turn);
    power(cycle, kind >> 2 & 3) * power(quarter, kind >> 4 & 3) * power(half, kind >> 6 & 1)
}
