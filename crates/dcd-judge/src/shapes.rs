//! Shapes of other kinds: compounds and meshes part by part, and cylinders and cones where comparing squares
//! of integers decides.

use crate::touches;
use crate::world::{lowest_bit, whole};
use dcd_geom::glam::DVec3;
use dcd_geom::{Curved, CurvedKind, Polytope, Pose, Shape};
use num_bigint::BigInt;

/// A shape and where it is.
pub type Placed<'a> = (&'a Shape, &'a Pose);

/// Whether two shapes share a point. `None` where this judge does not know: of foreign maps, half-spaces,
/// compounds with parts that are no polytopes, and of cylinders and cones but in the places of
/// [`curved_touch`].
pub fn shapes_touch(a: Placed<'_>, b: Placed<'_>) -> Option<bool> {
    if let (Shape::Curved(in_a), Shape::Curved(in_b)) = (a.0, b.0) {
        return curved_touch((in_a, a.1), (in_b, b.1));
    }
    let (in_a, in_b) = (polytopes(a.0)?, polytopes(b.0)?);
    Some(in_a.iter().any(|one| in_b.iter().any(|other| touches((one, a.1), (other, b.1)))))
}

/// What it is the union of, every vertex once; `None` if that is not known exactly.
fn polytopes(shape: &Shape) -> Option<Vec<Polytope>> {
    let once = |points: &[DVec3], radius: f64| {
        let mut points = points.to_vec();
        points.sort_by(|p, q| {
            p.to_array()
                .partial_cmp(&q.to_array())
                .unwrap_or_else(|| unreachable!("checked vertices are finite"))
        });
        points.dedup();
        Polytope::hull(points).and_then(|hull| hull.rounded(radius)).ok()
    };
    match shape {
        Shape::Polytope(polytope) => {
            Some(vec![once(polytope.vertices(), polytope.swept_radius())?])
        }
        Shape::Compound(compound) => {
            let parts = compound.parts().iter().map(|part| polytopes(part.placed()));
            Some(parts.collect::<Option<Vec<_>>>()?.concat())
        }
        Shape::Mesh(mesh) => (0..mesh.triangles().len())
            .map(|k| once(&mesh.corners(k)?, mesh.swept_radius()))
            .collect(),
        _ => None,
    }
}

/// Whether two cylinders or cones touch whose frames are turned by quarters: cylinders side by side, end
/// to end or anywhere else with parallel axes; crossed at a right angle, if their axes pass each other
/// between their ends; a cone beside a cylinder that is as high as its base, or below one above its
/// apex. `None` in any other place.
pub fn curved_touch(a: (&Curved, &Pose), b: (&Curved, &Pose)) -> Option<bool> {
    let (axis_a, axis_b) = (axis(a.1)?, axis(b.1)?);
    let lengths =
        [a, b].map(|(curved, _)| [curved.half_height(), curved.radius(), curved.swept_radius()]);
    let places = [a, b].map(|(_, pose)| pose.translation().to_array());
    let numbers = lengths.iter().flatten().chain(places.iter().flatten());
    let unit = numbers.map(|&x| lowest_bit(x)).min()?;
    let [[h, r, s], [g, q, t]] = lengths.map(|of| of.map(|x| whole(x, unit)));
    let [from, to] = places.map(|of| of.map(|x| whole(x, unit)));
    let delta: Vec<BigInt> = (0..3).map(|k| &to[k] - &from[k]).collect();
    let swept = &s + &t;
    let beside = &r + &q + &swept;
    if axis_a.0 != axis_b.0 {
        let cylinders = a.0.kind() == CurvedKind::Cylinder && b.0.kind() == CurvedKind::Cylinder;
        let pass = magnitude(&delta[axis_a.0]) <= h && magnitude(&delta[axis_b.0]) <= g;
        let third = 3 - axis_a.0 - axis_b.0;
        return (cylinders && pass).then(|| magnitude(&delta[third]) <= beside);
    }
    let k = axis_a.0;
    let along = delta[k].clone();
    let across: BigInt = (0..3).filter(|&i| i != k).map(|i| &delta[i] * &delta[i]).sum();
    match (a.0.kind(), b.0.kind()) {
        (CurvedKind::Cylinder, CurvedKind::Cylinder) => {
            let gap = magnitude(&along) - (&h + &g);
            Some(discs_touch(&across, &(&r + &q), &gap, &swept))
        }
        (CurvedKind::Cone, CurvedKind::Cylinder) => {
            // Upwards is where the cone's apex points.
            let along = if axis_a.1 { along } else { -along };
            if magnitude(&(&along + &h)) <= g {
                return Some(across <= &beside * &beside);
            }
            let above = &along - (&h + &g);
            (along > BigInt::ZERO && across <= &q * &q).then(|| above <= swept)
        }
        (CurvedKind::Cylinder, CurvedKind::Cone) => curved_touch(b, a),
        _ => None,
    }
}

/// Whether two parallel discs touch, so far apart across and along: whether √across ≤ radii with no gap along,
/// and else whether a sphere of the swept radius closes both gaps.
fn discs_touch(across: &BigInt, radii: &BigInt, gap: &BigInt, swept: &BigInt) -> bool {
    let square = |x: &BigInt| x * x;
    if *gap <= BigInt::ZERO {
        return *across <= square(&(radii + swept));
    }
    if *across <= square(radii) {
        return gap <= swept;
    }
    // √across − radii ≤ √(swept² − gap²).
    let rest = square(swept) - square(gap);
    if rest < BigInt::ZERO {
        return false;
    }
    let more = across - square(radii) - &rest;
    more <= BigInt::ZERO || square(&more) <= BigInt::from(4) * square(radii) * rest
}

fn magnitude(x: &BigInt) -> BigInt {
    BigInt::from(x.magnitude().clone())
}

/// The world axis that the frame's z is along, and whether it points up it; `None` of a frame that is
/// not turned by quarters exactly.
fn axis(pose: &Pose) -> Option<(usize, bool)> {
    let columns = pose.rotation().to_cols_array();
    if columns.iter().any(|&x| x != 0.0 && x.abs() != 1.0) {
        return None;
    }
    let z = pose.rotation().z_axis.to_array();
    let k = z.iter().position(|&x| x != 0.0)?;
    Some((k, z[k] > 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use dcd_geom::glam::DMat3;

    fn at(x: f64, y: f64, z: f64) -> Pose {
        Pose::from_translation(DVec3::new(x, y, z)).unwrap()
    }

    #[test]
    fn cylinders_and_cones_touch_up_to_the_last_bit_and_no_farther() {
        let cylinder = Shape::cylinder(1.0, 3.0).unwrap();
        let cone = Shape::cone(1.0, 3.0).unwrap();
        let rounded = cylinder.clone().rounded(0.5).unwrap();
        let next = 6f64.next_up();
        let judge =
            |a: &Shape, b: &Shape, pose: Pose| shapes_touch((a, &Pose::IDENTITY), (b, &pose));
        assert_eq!(judge(&cylinder, &cylinder, at(6.0, 0.0, 2.0)), Some(true));
        assert_eq!(judge(&cylinder, &cylinder, at(next, 0.0, 2.0)), Some(false));
        assert_eq!(judge(&cylinder, &cylinder, at(6.0, 0.0, 2f64.next_up())), Some(false));
        assert_eq!(judge(&cylinder, &cylinder, at(6.0, 1e-9, 0.0)), Some(false));
        // 3, 4 and 5 times a fifth: the rims are 0.3 apart across and 0.4 along, off by rounding.
        let [near, far] = [0.3 - 1e-15, 0.3 + 1e-15].map(|x| at(6.0 + x, 0.0, 2.4));
        let half = cylinder.clone().rounded(0.25).unwrap();
        assert_eq!(judge(&half, &half, near), Some(true));
        assert_eq!(judge(&half, &half, far), Some(false));
        assert_eq!(judge(&rounded, &cone, at(6.5, 0.0, 1.0)), Some(true));
        assert_eq!(judge(&cone, &rounded, at(6.5f64.next_up(), 0.0, -1.0)), Some(false));
        assert_eq!(judge(&cone, &cylinder, at(2.0, 0.0, 2.0)), Some(true));
        assert_eq!(judge(&cone, &cylinder, at(2.0, 0.0, 2f64.next_up())), Some(false));
        assert_eq!(judge(&cone, &cylinder, at(4.0, 0.0, 2.0)), None);
        let quarter = DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X);
        let crossed = |y: f64| Pose::from_matrix(quarter, DVec3::new(0.5, y, -0.5)).unwrap();
        assert_eq!(judge(&cylinder, &cylinder, crossed(6.0)), Some(true));
        assert_eq!(judge(&cylinder, &cylinder, crossed(next)), Some(false));
    }

    #[test]
    fn compounds_and_meshes_touch_where_a_part_does() {
        let point = Shape::sphere(0.0).unwrap();
        let parts = vec![(point.clone(), at(5.0, 0.0, 0.0)), (point.clone(), at(0.0, 1.0, 0.0))];
        let compound = Shape::compound(parts).unwrap();
        let corners = vec![DVec3::ZERO, DVec3::X, DVec3::Y * 2.0];
        let mesh = Shape::mesh(corners, vec![[0, 1, 2], [2, 1, 0]]).unwrap();
        let judge = |pose: Pose| shapes_touch((&compound, &Pose::IDENTITY), (&mesh, &pose));
        assert_eq!(judge(Pose::IDENTITY), Some(true));
        assert_eq!(judge(at(5.0, 0.0, 0.0)), Some(true));
        assert_eq!(judge(at(5.0, 0.0, 5e-324)), Some(false));
        let cylinder = Shape::cylinder(1.0, 1.0).unwrap();
        let here = &Pose::IDENTITY;
        assert_eq!(shapes_touch((&cylinder, here), (&mesh, here)), None);
    }
}
