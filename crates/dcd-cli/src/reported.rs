//! What a query reports of a pair, as JSON. World frame, metres.

use dcd_geom::glam::DVec3;
use dcd_gjk::epa::Depth;
use dcd_gjk::query::{Feature, ManifoldPoint, PartIndex, Smoothness, Twist};
use dcd_gjk::{Distance, Manifold, ManifoldSet, Proximity};
use dcd_pipeline::Answer;
use serde::Serialize;

/// What is reported: only what the query computes is present.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(crate) struct Reported {
    #[serde(skip_serializing_if = "Option::is_none")]
    distance: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    depth: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    normal: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    point_a: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    point_b: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    manifolds: Option<Vec<Patch>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    gradient_a: Option<Slopes>,
    #[serde(skip_serializing_if = "Option::is_none")]
    gradient_b: Option<Slopes>,
    #[serde(skip_serializing_if = "Option::is_none")]
    smoothness: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    error_bound: Option<f64>,
}

/// A manifold: one normal, up to four points.
#[derive(Clone, Debug, PartialEq, Serialize)]
struct Patch {
    normal: [f64; 3],
    depth: f64,
    points: Vec<Point>,
    error_bound: f64,
    /// The deepest parts, of compounds and of meshes.
    #[serde(skip_serializing_if = "Option::is_none")]
    part_a: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    part_b: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    triangle_a: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    triangle_b: Option<u32>,
}

/// A point of a manifold.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Point {
    depth: f64,
    point_a: [f64; 3],
    point_b: [f64; 3],
    feature_a: String,
    feature_b: String,
}

impl Point {
    /// The same with the parts of a and b exchanged.
    pub(crate) fn mirrored(self) -> Self {
        let Self { point_a, point_b, feature_a, feature_b, .. } = self;
        Self {
            point_a: point_b,
            point_b: point_a,
            feature_a: feature_b,
            feature_b: feature_a,
            ..self
        }
    }
}

/// Derivatives with respect to a pose.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
struct Slopes {
    translation: [f64; 3],
    rotation: [f64; 3],
}

/// An answer that can be reported.
pub(crate) trait Report {
    fn report(&self) -> Reported;

    /// The bound of what was measured: none where nothing was, or nothing bounds it.
    fn error_bound(&self) -> Option<f64>;
}

impl Report for Answer {
    fn report(&self) -> Reported {
        match self {
            Self::Distance(distance) => distance.report(),
            Self::Depth(depth) => depth.report(),
            Self::Manifold(manifolds) => manifolds.report(),
            Self::Gradient(proximity) => proximity.report(),
            _ => Reported::default(),
        }
    }

    fn error_bound(&self) -> Option<f64> {
        match self {
            Self::Distance(distance) => distance.error_bound(),
            Self::Depth(depth) => depth.error_bound(),
            Self::Manifold(manifolds) => Report::error_bound(manifolds),
            Self::Gradient(proximity) => proximity.error_bound(),
            _ => None,
        }
    }
}

impl Report for Option<Distance> {
    fn report(&self) -> Reported {
        let Some(found) = self else {
            return Reported { distance: Some(0.0), error_bound: Some(0.0), ..Reported::default() };
        };
        Reported {
            distance: Some(found.distance),
            error_bound: self.error_bound(),
            ..Reported::between(found.normal, found.point_a, found.point_b)
        }
    }

    fn error_bound(&self) -> Option<f64> {
        self.map_or(Some(0.0), |found| (!found.is_saturated()).then_some(found.error_bound))
    }
}

impl Report for Depth {
    fn report(&self) -> Reported {
        let way = Reported::between(self.normal, self.point_a, self.point_b);
        Reported { depth: Some(self.depth), error_bound: self.error_bound(), ..way }
    }

    fn error_bound(&self) -> Option<f64> {
        (!self.is_saturated()).then_some(self.error_bound)
    }
}

impl From<&Manifold> for Patch {
    fn from(manifold: &Manifold) -> Self {
        let part = |k: usize| match manifold.parts[k] {
            Some(PartIndex::Part(part)) => Some(part),
            _ => None,
        };
        let triangle = |k: usize| match manifold.parts[k] {
            Some(PartIndex::Triangle(triangle)) => Some(triangle),
            _ => None,
        };
        Self {
            normal: manifold.normal.to_array(),
            depth: manifold.points().first().map_or(0.0, |deepest| deepest.depth),
            points: points(manifold),
            error_bound: manifold.error_bound,
            part_a: part(0),
            part_b: part(1),
            triangle_a: triangle(0),
            triangle_b: triangle(1),
        }
    }
}

impl Report for ManifoldSet {
    fn report(&self) -> Reported {
        let manifolds = Some(self.iter().map(Patch::from).collect());
        Reported { manifolds, ..Reported::default() }
    }

    fn error_bound(&self) -> Option<f64> {
        Some(ManifoldSet::error_bound(self))
    }
}

impl Report for Proximity {
    fn report(&self) -> Reported {
        let slopes = |twist: Twist| {
            let [translation, rotation] = [twist.translation, twist.rotation].map(|v| v.to_array());
            Some(Slopes { translation, rotation })
        };
        Reported {
            distance: Some(self.signed_distance),
            gradient_a: slopes(self.gradient.a),
            gradient_b: slopes(self.gradient.b),
            smoothness: Some(match self.smoothness {
                Smoothness::Smooth => "smooth",
                Smoothness::ManyPoints => "many points",
                Smoothness::ManyDirections => "many directions",
                _ => "unknown",
            }),
            error_bound: Some(self.error_bound),
            ..Reported::between(self.normal, self.point_a, self.point_b)
        }
    }

    fn error_bound(&self) -> Option<f64> {
        (self.error_bound < f64::MAX).then_some(self.error_bound)
    }
}

impl Reported {
    fn between(normal: DVec3, point_a: DVec3, point_b: DVec3) -> Self {
        let [normal, point_a, point_b] = [normal, point_a, point_b].map(|v| Some(v.to_array()));
        Self { normal, point_a, point_b, ..Self::default() }
    }
}

impl Reported {
    /// The points in which a pair touches, halfway between its two surfaces, with the normal; none
    /// where the query computes none.
    pub(crate) fn contact_points(&self) -> Vec<(DVec3, DVec3)> {
        let halfway =
            |a: [f64; 3], b: [f64; 3]| (DVec3::from_array(a) + DVec3::from_array(b)) * 0.5;
        let patches = self.manifolds.iter().flatten();
        let of_patches = patches.flat_map(|patch| {
            let normal = DVec3::from_array(patch.normal);
            patch.points.iter().map(move |p| (halfway(p.point_a, p.point_b), normal))
        });
        let alone = self.depth.and_then(|_| {
            let (a, b) = (self.point_a?, self.point_b?);
            Some((halfway(a, b), DVec3::from_array(self.normal?)))
        });
        of_patches.chain(alone).collect()
    }
}

/// The points of a manifold, the deepest first.
pub(crate) fn points(manifold: &Manifold) -> Vec<Point> {
    let point = |point: &ManifoldPoint| Point {
        depth: point.depth,
        point_a: point.point_a.to_array(),
        point_b: point.point_b.to_array(),
        feature_a: in_words(point.features[0]),
        feature_b: in_words(point.features[1]),
    };
    manifold.points().iter().map(point).collect()
}

fn in_words(feature: Feature) -> String {
    match feature {
        Feature::Surface => "surface".into(),
        Feature::Vertex(k) => format!("vertex {k}"),
        Feature::Edge(j, k) => format!("edge {j} {k}"),
        Feature::Face(k) => format!("face {k}"),
    }
}
