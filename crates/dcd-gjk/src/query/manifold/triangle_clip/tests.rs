//! The general clip is the other method: it shares the view and the parts that are shown, and none of the clipping.

use super::super::Feature;
use super::super::clip::{Patch, drop_doubles};
use super::super::cuboid_faces::tests::Draw;
use super::super::feature::Placed;
use super::super::uneven_by;
use super::*;
use dcd_geom::glam::{DMat3, DQuat};
use dcd_geom::{Polytope, SupportMap};

/// Far above what rounding does to lengths of about a metre, far below what a wrong corner is off by.
const SAME_PLACE: f64 = 1e-9;

fn draw(fixed: u64) -> Draw {
    Draw(std::env::var("DCD_SEED").map_or(fixed, |seed| seed.parse().expect("a seed")))
}

fn vector(draw: &mut Draw) -> DVec3 {
    DVec3::new(draw.unit(), draw.unit(), draw.unit()) * 2.0 - 1.0
}

fn turn(draw: &mut Draw) -> DQuat {
    DQuat::from_vec4(vector(draw).extend(draw.unit() - 0.5)).normalize()
}

/// A cloud, a prism of three to nine sides, a box, a segment, or a triangle; every third has a swept radius.
fn body(draw: &mut Draw, k: usize) -> Polytope {
    let sides = 3 + k / 5 % 7;
    let corner = |j: usize| {
        let angle = (j / 2) as f64 * std::f64::consts::TAU / sides as f64;
        let height = if j.is_multiple_of(2) { -0.4 } else { 0.4 };
        DVec3::new(angle.cos(), angle.sin(), height) * 0.6
    };
    let body = match k % 5 {
        0 => Polytope::hull((0..16).map(|_| vector(draw) * 0.7).collect()),
        1 => Polytope::hull((0..2 * sides).map(corner).collect()),
        2 => Polytope::cuboid(DVec3::new(0.5, 0.3, 0.2) * (0.5 + draw.unit())),
        3 => Polytope::hull(vec![vector(draw), vector(draw)]),
        _ => Polytope::mesh_triangle([vector(draw), vector(draw), vector(draw)]),
    };
    body.and_then(|body| body.rounded(if k.is_multiple_of(3) { 0.1 } else { 0.0 })).unwrap()
}

/// A triangle, a body and a normal that see each other's faces and edges often: the normal is nearly that of the
/// triangle, of one of the body's faces, or any.
struct Round {
    triangle: [DVec3; 3],
    body: Polytope,
    rotation: DMat3,
    place: DVec3,
    view: View,
}

impl Round {
    fn draw(draw: &mut Draw, k: usize) -> Self {
        let body = body(draw, k);
        let rotation = DMat3::from_quat(turn(draw));
        let facets = body.facets().facets();
        let facing = match k / 5 % 3 {
            0 if !facets.is_empty() => {
                let facet = (draw.unit() * facets.len() as f64) as usize;
                -(rotation * facets[facet].normal)
            }
            _ => vector(draw).normalize(),
        };
        let lean = DQuat::from_scaled_axis(vector(draw) * [0.0, 1e-3, 0.1, 0.2][k / 15 % 4]);
        let normal = (lean * facing).normalize();
        // In the plane square to the normal, but for a little.
        let (x, y) = normal.any_orthonormal_pair();
        let off = [0.0, 0.05, 0.2, 1.0][k / 60 % 4];
        let size = 0.3 + 1.5 * draw.unit();
        let triangle = [0; 3].map(|_| {
            let at = vector(draw) * size;
            x * at.x + y * at.y + normal * (at.z * off)
        });
        // Its deepest point is near the triangle's plane.
        let local = rotation.transpose() * -normal;
        let below = SupportMap::<f64>::support(&body, local).point;
        let aside = vector(draw) * 0.5;
        let place = x * aside.x + y * aside.y + normal * (aside.z * 0.4) - rotation * below;
        Self { triangle, body, rotation, place, view: View::along(normal) }
    }

    fn placed(&self) -> Placed<'_> {
        Placed { rotation: &self.rotation, place: self.place, sense: -1.0 }
    }

    /// The corners that the general way has; `None` of a needle.
    fn general(&self, radii: [f64; 2], size: f64) -> Option<Vec<Corner>> {
        let part = Part::of_triangle(self.triangle, self.view.normal())?;
        let placed = Placed { rotation: &DMat3::IDENTITY, place: DVec3::ZERO, sense: 1.0 };
        let triangle = self.view.seen_triangle(part, &placed, (&self.triangle, radii[0]));
        let seen = self.view.seen(&self.body, &self.placed());
        let mut patch = Patch::default();
        patch.of(&triangle, &seen, -(radii[0] + radii[1]), size);
        let level = [triangle.level(), seen.level()];
        Some(patch.corners().iter().map(|corner| corner.swept(radii, level)).collect())
    }

    /// Those in fixed memory; `None` where the general way is needed.
    fn fixed(&self, radii: [f64; 2], (most, size): (f64, f64)) -> Option<Vec<Corner>> {
        let part = Part::of_triangle(self.triangle, self.view.normal())?;
        let placed = self.placed();
        let shown = self.view.part(&self.body, &placed);
        let outline = Outline::of(&self.view, &shown, &self.body, &placed)?;
        let (mut points, mut corners) = (TrianglePolygon::default(), Vec::new());
        let (how, of_triangle) = ((&self.view, radii, most), (&part, &self.triangle));
        add(how, of_triangle, &outline, &mut points, &mut corners)?;
        drop_doubles(&mut corners, size);
        Some(corners)
    }
}

#[test]
fn a_triangle_and_a_body_share_the_corners_that_the_general_clip_finds() {
    let mut draw = draw(61);
    let (mut counts, mut general, mut swept, mut crossings) = ([0; 13], 0, 0, 0);
    for k in 0..30_000 {
        let round = Round::draw(&mut draw, k);
        let radii = [if k.is_multiple_of(7) { 0.05 } else { 0.0 }, round.body.swept_radius()];
        let size = 4.0;
        let Some(due) = round.general(radii, size) else { continue };
        let Some(found) = round.fixed(radii, (f64::INFINITY, size)) else {
            general += 1;
            continue;
        };
        assert_eq!(found.len(), due.len(), "{k}: {found:?} {due:?}");
        for (p, q) in found.iter().zip(&due) {
            assert_eq!(p.features, q.features, "{k}: {found:?} {due:?}");
            let off = [p.heights[0] - q.heights[0], p.heights[1] - q.heights[1]];
            assert!(p.at.distance(q.at) < SAME_PLACE, "{k}: {found:?} {due:?}");
            // A face that is bent is a plane to the one, and its corners to the other.
            let same = SAME_PLACE + uneven_by(&round.body);
            assert!(off.iter().all(|off| off.abs() < same), "{k}: {found:?} {due:?}");
            // What a leaning face's radius is counted too much, as far as the deepest is deeper.
            let most = due.iter().map(|corner| corner.heights[0] - corner.heights[1]);
            let most = most.fold(f64::NEG_INFINITY, f64::max);
            let off_surface = [p.off_surface(most), q.off_surface(most)];
            assert!((off_surface[0] - off_surface[1]).abs() < SAME_PLACE, "{k}: {off_surface:?}");
            swept += usize::from(off_surface[0] > 0.0);
            let is_edge = |feature: &Feature| matches!(feature, Feature::Edge(..));
            crossings += usize::from(p.features.iter().all(is_edge));
        }
        counts[found.len()] += 1;
    }
    assert!(counts[0] > 1000 && general < 15_000, "{counts:?} {general}");
    assert!(counts[2..7].iter().all(|&count| count > 20), "{counts:?}");
    assert!(swept > 200 && crossings > 500, "{swept} {crossings}");
}

#[test]
fn corners_that_would_be_deeper_than_the_deepest_are_all_left_out() {
    let mut draw = draw(62);
    let (mut kept, mut dropped) = (0, 0);
    for k in 0..5000 {
        let round = Round::draw(&mut draw, k);
        let radii = [0.0, round.body.swept_radius()];
        let Some(due) = round.general(radii, 4.0).filter(|due| !due.is_empty()) else { continue };
        let depths = due.iter().map(|corner| corner.heights[0] - corner.heights[1]);
        let deepest = depths.fold(f64::NEG_INFINITY, f64::max);
        for (most, count) in [(deepest + 1e-6, due.len()), (deepest - 1e-6, 0)] {
            let Some(found) = round.fixed(radii, (most, 4.0)) else { continue };
            assert_eq!(found.len(), count, "{k}: {most} {found:?}");
            if count == 0 { dropped += 1 } else { kept += 1 }
        }
    }
    assert!(kept > 500 && dropped == kept, "{kept} {dropped}");
}

#[test]
fn faces_of_many_corners_and_parallel_edges_take_the_general_way() {
    let corner = |j: usize| {
        let angle = (j / 2) as f64 * std::f64::consts::TAU / 12.0;
        DVec3::new(angle.cos(), angle.sin(), if j.is_multiple_of(2) { -0.5 } else { 0.5 })
    };
    let prism = Polytope::hull((0..24).map(corner).collect()).unwrap();
    let view = View::along(DVec3::NEG_Z);
    let above = Placed { rotation: &DMat3::IDENTITY, place: DVec3::NEG_Z * 0.45, sense: -1.0 };
    let part = view.part(&prism, &above);
    assert!(matches!(part, Part::Face { corners, .. } if corners.len() == 12));
    assert!(Outline::of(&view, &part, &prism, &above).is_none());

    let segment = Polytope::hull(vec![DVec3::X, DVec3::NEG_X]).unwrap();
    let part = view.part(&segment, &above);
    let outline = Outline::of(&view, &part, &segment, &above).unwrap();
    let seen = |end: DVec3| {
        // An upright triangle on its longest edge.
        let triangle = [DVec3::NEG_X * 2.0, end, DVec3::Z];
        let part = Part::of_triangle(triangle, DVec3::NEG_Z).unwrap();
        assert!(matches!(part, Part::Edge([0, 1])));
        let mut corners = Vec::new();
        let how = (&view, [0.0; 2], f64::INFINITY);
        let points = &mut TrianglePolygon::default();
        add(how, (&part, &triangle), &outline, points, &mut corners).map(|()| corners.len())
    };
    assert_eq!(seen(DVec3::X * 2.0), None);
    assert_eq!(seen(DVec3::X * 2.0 + DVec3::Y), Some(0));
}
