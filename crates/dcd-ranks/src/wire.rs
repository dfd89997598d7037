//! Messages: numbers, little endian, one after the other; every one of 64 bits but for flags and
//! what shapes are made of.

use crate::RankError;
use dcd_geom::glam::{DMat3, DVec3};
use dcd_geom::{Pose, Shape};
use dcd_io::{read_shape, write_shape};

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

    /// As a capture holds it, so that the same shape is made of it.
    pub(crate) fn shape(&mut self, name: u64, shape: &Shape) -> Result<(), RankError> {
        // Memory takes all that is written: what is refused is the shape.
        write_shape(&mut self.0, shape).map_err(|_| RankError::Foreign { shape: name })
    }
}

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
        let (shape, rest) = read_shape(self.0).ok()?;
        self.0 = rest;
        Some(shape)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dcd_geom::glam::DQuat;
    use dcd_geom::{Support, SupportMap};
    use std::sync::Arc;

    #[test]
    fn a_shape_and_a_pose_arrive_as_they_were() {
        let rotation = DQuat::from_xyzw(0.1, -0.7, 0.2, 0.3).normalize();
        let pose = Pose::new(rotation, DVec3::new(1e-3, -7.0, 1e9)).unwrap();
        let points = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z, DVec3::splat(0.1)];
        let shapes = [
            Shape::hull(points.clone()).unwrap(),
            Shape::capsule(0.5, 0.25).unwrap(),
            Shape::cuboid(DVec3::new(1.0, 2.0, 3.0)).unwrap().rounded(0.125).unwrap(),
            Shape::half_space(DVec3::Z, 0.5).unwrap(),
            Shape::mesh(points, vec![[0, 1, 2], [1, 2, 3]]).unwrap(),
        ];
        for shape in shapes {
            let mut writer = Writer::default();
            writer.shape(0, &shape).unwrap();
            writer.pose(&pose);
            let mut reader = Reader(&writer.0);
            let (got, place) = (reader.shape().unwrap(), reader.pose().unwrap());
            assert!(reader.0.is_empty());
            // All that a shape is made of shows here.
            assert_eq!(format!("{got:?}"), format!("{shape:?}"));
            assert_eq!(place, pose);
            for end in 0..writer.0.len() {
                let mut cut = Reader(&writer.0[..end]);
                assert!(cut.shape().and_then(|_| cut.pose()).is_none(), "{end}");
            }
        }
    }

    #[test]
    fn a_shape_that_no_message_holds_is_refused_with_its_name() {
        let foreign = Shape::custom(Arc::new(Foreign)).unwrap();
        let refused = Writer::default().shape(7, &foreign);
        assert_eq!(refused, Err(RankError::Foreign { shape: 7 }));
    }

    struct Foreign;

    impl SupportMap<f64> for Foreign {
        fn support(&self, direction: DVec3) -> Support<f64> {
            Support { point: direction, feature: 0 }
        }
    }
}
