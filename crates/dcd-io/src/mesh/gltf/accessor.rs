//! The numbers of accessors, each place checked against its buffer before anything is allocated.

use super::super::MeshError;
use super::refused;
use glam::DVec3;
use gltf::Accessor;
use gltf::accessor::{DataType, Dimensions};

/// The buffers that accessors read from.
pub(super) struct Accessors<'a> {
    pub(super) buffers: &'a [Vec<u8>],
}

impl<'a> Accessors<'a> {
    /// Points of three f32 coordinates.
    pub(super) fn points(&self, accessor: &Accessor<'_>) -> Result<Vec<DVec3>, MeshError> {
        let kind = (accessor.dimensions(), accessor.data_type());
        if kind != (Dimensions::Vec3, DataType::F32) {
            return Err(refused(&path(accessor), format!("{kind:?} are no points")));
        }
        let records = self.records(accessor)?;
        let point = |record: &[u8]| {
            let coordinate = |k: usize| {
                let [a, b, c, d] = [0, 1, 2, 3].map(|byte| record[4 * k + byte]);
                f64::from(f32::from_le_bytes([a, b, c, d]))
            };
            DVec3::new(coordinate(0), coordinate(1), coordinate(2))
        };
        let points: Vec<DVec3> = records.map(point).collect();
        match points.iter().position(|point| !point.is_finite()) {
            Some(index) => {
                let problem = format!("point {index} is {}, not finite", points[index]);
                Err(refused(&path(accessor), problem))
            }
            None => Ok(points),
        }
    }

    /// Indices of 8, 16 or 32 bits.
    pub(super) fn indices(&self, accessor: &Accessor<'_>) -> Result<Vec<u32>, MeshError> {
        let kind = (accessor.dimensions(), accessor.data_type());
        let index: fn(&[u8]) -> u32 = match kind {
            (Dimensions::Scalar, DataType::U8) => |record| record[0].into(),
            (Dimensions::Scalar, DataType::U16) => {
                |record| u16::from_le_bytes([record[0], record[1]]).into()
            }
            (Dimensions::Scalar, DataType::U32) => {
                |record| u32::from_le_bytes([record[0], record[1], record[2], record[3]])
            }
            _ => return Err(refused(&path(accessor), format!("{kind:?} are no indices"))),
        };
        Ok(self.records(accessor)?.map(index).collect())
    }

    /// The bytes of each element, all there and of the element's size.
    fn records(
        &self,
        accessor: &Accessor<'_>,
    ) -> Result<impl Iterator<Item = &'a [u8]>, MeshError> {
        let refuse = |problem: &str| refused(&path(accessor), problem);
        if accessor.sparse().is_some() {
            return Err(refuse("sparse accessors are not supported"));
        }
        let Some(view) = accessor.view() else {
            return Err(refuse("an accessor without a view holds zeros alone"));
        };
        let size = accessor.size();
        let stride = view.stride().unwrap_or(size);
        if stride < size {
            return Err(refuse("the stride is shorter than an element"));
        }
        let outside = || {
            let (index, bytes) = (view.index(), view.length());
            refuse(&format!(
                "{} elements leave bufferViews[{index}] of {bytes} bytes or its buffer",
                accessor.count()
            ))
        };
        let buffer = self.buffers.get(view.buffer().index()).ok_or_else(outside)?;
        let end = view.offset().checked_add(view.length()).ok_or_else(outside)?;
        let bytes = buffer.get(view.offset()..end).ok_or_else(outside)?;
        let bytes = bytes.get(accessor.offset()..).ok_or_else(outside)?;
        let count = accessor.count();
        // The last element may end before its stride does.
        let needed = count
            .checked_sub(1)
            .map_or(Some(0), |before| before.checked_mul(stride)?.checked_add(size));
        if needed.is_none_or(|needed| needed > bytes.len()) {
            return Err(outside());
        }
        Ok((0..count).map(move |k| &bytes[k * stride..k * stride + size]))
    }
}

fn path(accessor: &Accessor<'_>) -> String {
    format!("accessors[{}]", accessor.index())
}
