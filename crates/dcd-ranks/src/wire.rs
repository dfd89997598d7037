//! Messages: numbers, little endian, one after the other; every one of 64 bits but for flags.

use crate::RankError;
use dcd_geom::glam::{DMat3, DVec3};
use dcd_geom::{Kind, Pose, Shape};

/// A message that is being written.
#[derive(Debug, Default)]
pub(crate) struct Writer(pub(crate) Vec<u8>);

impl Writer {
    pub(crate) fn byte(&mut self, byte: u8) {
        self.0.push(byte);
    }

    pub(crate) fn number(&mut self, number: u64) {
        self.0.extend_from_slice(&number.to_le_bytes());
    }

    pub(crate) fn length(&mut self, length: f64) {
        self.number(length.to_bits());
    }

    pub(crate) fn vector(&mut self, v: DVec3) {
        v.to_array().into_iter().for_each(|x| self.length(x));
    }

    /// The matrix itself, which is the truth.
    pub(crate) fn pose(&mut self, pose: &Pose) {
        pose.rotation().to_cols_array().into_iter().for_each(|x| self.length(x));
        self.vector(pose.translation());
    }

    /// A polytope as it was made, so that the same shape is made of it.
    pub(crate) fn shape(&mut self, name: u64, shape: &Shape) -> Result<(), RankError> {
        let polytope = shape.as_polytope().ok_or(RankError::Foreign { shape: name })?;
        let tag = match polytope.kind() {
            Kind::Hull => HULL,
            Kind::Point => POINT,
            Kind::Segment => SEGMENT,
            Kind::Triangle => TRIANGLE,
            Kind::Cuboid { .. } => CUBOID,
            _ => return Err(RankError::Foreign { shape: name }),
        };
        self.byte(tag);
        self.length(polytope.swept_radius());
        if let Kind::Cuboid { half_extents } = polytope.kind() {
            self.vector(half_extents);
            return Ok(());
        }
        self.number(polytope.vertices().len() as u64);
        polytope.vertices().iter().for_each(|&vertex| self.vector(vertex));
        Ok(())
    }
}

const HULL: u8 = 0;
const POINT: u8 = 1;
const SEGMENT: u8 = 2;
const TRIANGLE: u8 = 3;
const CUBOID: u8 = 4;

/// A message that is being read. Nothing where it ends early or says what no message says.
#[derive(Debug)]
pub(crate) struct Reader<'a>(pub(crate) &'a [u8]);

impl Reader<'_> {
    pub(crate) fn byte(&mut self) -> Option<u8> {
        let (&byte, rest) = self.0.split_first()?;
        self.0 = rest;
        Some(byte)
    }

    pub(crate) fn number(&mut self) -> Option<u64> {
        let (number, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(u64::from_le_bytes(*number))
    }

    /// A count of what takes so many bytes each: no more than there can be.
    pub(crate) fn count(&mut self, bytes: usize) -> Option<usize> {
        let count = usize::try_from(self.number()?).ok()?;
        (count.checked_mul(bytes)? <= self.0.len()).then_some(count)
    }

    pub(crate) fn length(&mut self) -> Option<f64> {
        self.number().map(f64::from_bits)
    }

    pub(crate) fn vector(&mut self) -> Option<DVec3> {
        let (x, y) = (self.length()?, self.length()?);
        Some(DVec3::new(x, y, self.length()?))
    }

    pub(crate) fn pose(&mut self) -> Option<Pose> {
        let columns = [self.vector()?, self.vector()?, self.vector()?];
        let [x, y, z] = columns;
        Pose::from_matrix(DMat3::from_cols(x, y, z), self.vector()?).ok()
    }

    pub(crate) fn shape(&mut self) -> Option<Shape> {
        let (tag, radius) = (self.byte()?, self.length()?);
        if tag == CUBOID {
            return Shape::cuboid(self.vector()?).ok()?.rounded(radius).ok();
        }
        let count = self.count(24)?;
        let vertices = (0..count).map(|_| self.vector()).collect::<Option<Vec<_>>>()?;
        let core = match (tag, vertices.as_slice()) {
            (HULL, _) => Shape::hull(vertices),
            (POINT, [_]) => Shape::sphere(0.0),
            (SEGMENT, &[from, to]) => Shape::segment(from, to),
            (TRIANGLE, &[a, b, c]) => Shape::triangle([a, b, c]),
            _ => return None,
        };
        core.ok()?.rounded(radius).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dcd_geom::glam::DQuat;

    #[test]
    fn a_shape_and_a_pose_arrive_as_they_were() {
        let rotation = DQuat::from_xyzw(0.1, -0.7, 0.2, 0.3).normalize();
        let pose = Pose::new(rotation, DVec3::new(1e-3, -7.0, 1e9)).unwrap();
        let points = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z, DVec3::splat(0.1)];
        let shapes = [
            Shape::hull(points).unwrap(),
            Shape::sphere(0.3).unwrap(),
            Shape::capsule(0.5, 0.25).unwrap(),
            Shape::triangle([DVec3::X, DVec3::Y, DVec3::Z]).unwrap(),
            Shape::cuboid(DVec3::new(1.0, 2.0, 3.0)).unwrap().rounded(0.125).unwrap(),
        ];
        for shape in shapes {
            let mut writer = Writer::default();
            writer.shape(0, &shape).unwrap();
            writer.pose(&pose);
            let mut reader = Reader(&writer.0);
            let (got, place) = (reader.shape().unwrap(), reader.pose().unwrap());
            assert!(reader.0.is_empty());
            let [a, b] = [&shape, &got].map(|shape| shape.as_polytope().unwrap());
            assert_eq!((a.kind(), a.vertices()), (b.kind(), b.vertices()));
            assert_eq!((a.swept_radius(), a.inner()), (b.swept_radius(), b.inner()));
            assert_eq!(place, pose);
            for end in 0..writer.0.len() {
                let mut cut = Reader(&writer.0[..end]);
                assert!(cut.shape().and_then(|_| cut.pose()).is_none(), "{end}");
            }
        }
    }

    #[test]
    fn a_shape_that_no_message_holds_is_refused_with_its_name() {
        let refused = Writer::default().shape(7, &Shape::cylinder(1.0, 1.0).unwrap());
        assert_eq!(refused, Err(RankError::Foreign { shape: 7 }));
    }
}
