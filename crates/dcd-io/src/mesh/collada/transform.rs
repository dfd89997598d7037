//! The transforms of a node.

use super::MeshError;
use super::xml::{numbers, refused};
use glam::{DAffine3, DMat3, DVec3};
use roxmltree::Node;

/// The elements that move what a node holds.
pub(super) const NAMES: [&str; 6] = ["matrix", "translate", "rotate", "scale", "skew", "lookat"];

/// The transform that an element is, from the node's frame to its parent's; none if it is no
/// transform. Angles are in degrees, the matrix row by row.
pub(super) fn read(node: Node<'_, '_>) -> Result<Option<DAffine3>, MeshError> {
    let name = node.tag_name().name();
    if !NAMES.contains(&name) {
        return Ok(None);
    }
    let given = numbers(node)?;
    let wrong = || refused(node, format!("{} numbers are not what a <{name}> has", given.len()));
    let transform = match (name, &given[..]) {
        ("matrix", rows) => matrix(node, rows.try_into().map_err(|_| wrong())?)?,
        ("translate", &[x, y, z]) => DAffine3::from_translation(DVec3::new(x, y, z)),
        ("scale", &[x, y, z]) => DAffine3::from_scale(DVec3::new(x, y, z)),
        ("rotate", &[x, y, z, angle]) => rotate(node, DVec3::new(x, y, z), angle)?,
        ("skew", &[angle, a, b, c, d, e, f]) => {
            skew(node, angle, [DVec3::new(a, b, c), DVec3::new(d, e, f)])?
        }
        ("lookat", &[a, b, c, d, e, f, g, h, i]) => {
            look_at(node, [DVec3::new(a, b, c), DVec3::new(d, e, f), DVec3::new(g, h, i)])?
        }
        _ => return Err(wrong()),
    };
    if transform.is_finite() { Ok(Some(transform)) } else { Err(refused(node, "it overflows")) }
}

fn matrix(node: Node<'_, '_>, rows: [f64; 16]) -> Result<DAffine3, MeshError> {
    if rows[12..] != [0.0, 0.0, 0.0, 1.0] {
        return Err(refused(node, "a last row other than 0 0 0 1 is not supported"));
    }
    let column = |k: usize| DVec3::new(rows[k], rows[4 + k], rows[8 + k]);
    Ok(DAffine3::from_cols(column(0), column(1), column(2), column(3)))
}

fn rotate(node: Node<'_, '_>, axis: DVec3, angle: f64) -> Result<DAffine3, MeshError> {
    if angle == 0.0 {
        // Tools write it with any axis, that of length 0 too.
        return Ok(DAffine3::IDENTITY);
    }
    let axis = unit(node, axis, "axis")?;
    let (sin, cos) = sin_cos(angle);
    let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z].map(|of| {
        // Rodrigues' formula.
        of * cos + axis.cross(of) * sin + axis * (axis.dot(of) * (1.0 - cos))
    });
    Ok(DAffine3::from_mat3(DMat3::from_cols(x, y, z)))
}

/// RenderMan's skew, which COLLADA names as its source: space is sheared along the second axis, so
/// that the first one turns towards it by the angle.
fn skew(node: Node<'_, '_>, angle: f64, axes: [DVec3; 2]) -> Result<DAffine3, MeshError> {
    let first = unit(node, axes[0], "first axis")?;
    let second = unit(node, axes[1], "second axis")?;
    let across = first - second * first.dot(second);
    // The sine and cosine of the angle between the axes.
    let (sin, cos) = (across.length(), first.dot(second));
    let (sin_angle, cos_angle) = sin_cos(angle);
    // The sine of what is left of that angle: none is left if the skew turns onto the second axis.
    let left = sin * cos_angle - cos * sin_angle;
    if !(sin > 0.0 && left > 0.0) {
        return Err(refused(node, "it turns its first axis onto or beyond its second"));
    }
    // A point moves along the second axis by how far it lies across that axis; the first axis
    // itself lies `sin` across.
    let along = second * (sin_angle / left);
    let share = across / (sin * sin);
    let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z].map(|of| of + along * share.dot(of));
    Ok(DAffine3::from_mat3(DMat3::from_cols(x, y, z)))
}

/// Where a camera at the first point that looks at the second stands, its y towards the third.
fn look_at(node: Node<'_, '_>, [eye, at, up]: [DVec3; 3]) -> Result<DAffine3, MeshError> {
    let back = unit(node, eye - at, "way to what is looked at")?;
    let right = unit(node, unit(node, up, "up axis")?.cross(back), "up axis across that way")?;
    Ok(DAffine3::from_cols(right, back.cross(right), back, eye))
}

fn unit(node: Node<'_, '_>, axis: DVec3, what: &str) -> Result<DVec3, MeshError> {
    // Scaled first, so that no square leaves the range.
    let scaled = axis / axis.abs().max_element();
    scaled.try_normalize().ok_or_else(|| refused(node, format!("the {what} has no direction")))
}

/// Sine and cosine of degrees; exact for quarters of a turn.
fn sin_cos(degrees: f64) -> (f64, f64) {
    let within = degrees % 360.0;
    match within.rem_euclid(360.0) {
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        _ => libm::sincos(within.to_radians()),
    }
}
