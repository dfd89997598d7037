//! Point clouds: u32 count, then count times 3 f32, little endian, to the end of the file.

use crate::ReadError;
use crate::bytes::{Cursor, Field};
use glam::{DVec3, Vec3};
use std::path::Path;

/// Reads point clouds, widened to f64 without loss.
///
/// # Errors
/// A file that ends within a cloud, an empty cloud, a number that is not finite.
pub fn read_clouds(bytes: &[u8]) -> Result<Vec<Vec<DVec3>>, ReadError> {
    let mut cursor = Cursor::new(bytes, 0);
    let mut clouds = Vec::new();
    while !cursor.is_at_end() {
        let index = clouds.len();
        let count = cursor.u32(Field { what: "count", index })?;
        if count == 0 {
            return Err(ReadError::Empty { what: "cloud", index });
        }
        let field = Field { what: "points", index };
        cursor.check_count(field, count.into(), 12)?;
        let mut cloud = Vec::with_capacity(count as usize);
        for _ in 0..count {
            let point = cursor.f32s::<3>(field)?;
            if let Some(&value) = point.iter().find(|x| !x.is_finite()) {
                return Err(ReadError::NotFinite { what: "cloud", index, value: value.into() });
            }
            cloud.push(Vec3::from_array(point).as_dvec3());
        }
        clouds.push(cloud);
    }
    Ok(clouds)
}

/// [`read_clouds`] from a file.
///
/// # Errors
/// Those of [`read_clouds`], and those of reading the file, both with its path.
pub fn load_clouds(path: &Path) -> Result<Vec<Vec<DVec3>>, ReadError> {
    ReadError::within(path, read_clouds)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(clouds: &[&[[f32; 3]]]) -> Vec<u8> {
        let mut bytes = Vec::new();
        for cloud in clouds {
            bytes.extend((cloud.len() as u32).to_le_bytes());
            bytes.extend(cloud.as_flattened().iter().flat_map(|x| x.to_le_bytes()));
        }
        bytes
    }

    #[test]
    fn clouds_are_read_in_order() {
        let clouds = read_clouds(&file(&[&[[1.0, 2.0, 3.0]], &[[0.1; 3], [4.0; 3]]])).unwrap();
        assert_eq!(clouds.len(), 2);
        assert_eq!(clouds[0], [DVec3::new(1.0, 2.0, 3.0)]);
        assert_eq!(clouds[1][0].x, f64::from(0.1f32));
        assert!(read_clouds(&[]).unwrap().is_empty());
    }

    #[test]
    fn a_file_cut_within_a_cloud_is_refused() {
        let bytes = file(&[&[[1.0; 3]], &[[2.0; 3], [3.0; 3]]]);
        for end in 0..bytes.len() {
            match read_clouds(&bytes[..end]) {
                Ok(clouds) => {
                    assert!((end, clouds.len()) == (0, 0) || (end, clouds.len()) == (16, 1))
                }
                Err(refused) => {
                    assert!(matches!(refused, ReadError::Truncated { .. }), "{refused}")
                }
            }
        }
    }

    #[test]
    fn an_empty_cloud_a_corrupt_count_and_nan_are_refused_with_their_index() {
        let empty = read_clouds(&file(&[&[[1.0; 3]], &[]])).unwrap_err();
        assert!(matches!(empty, ReadError::Empty { index: 1, .. }));
        let mut corrupt = file(&[&[[1.0; 3]]]);
        corrupt[..4].fill(0xff);
        let refused = read_clouds(&corrupt).unwrap_err();
        assert!(matches!(refused, ReadError::Truncated { needed: 51_539_607_540, left: 12, .. }));
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let refused = read_clouds(&file(&[&[[1.0; 3]], &[[0.0, bad, 0.0]]])).unwrap_err();
            assert!(matches!(refused, ReadError::NotFinite { index: 1, .. }), "{refused}");
        }
    }
}
