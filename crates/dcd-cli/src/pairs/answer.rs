//! An answer as it is printed.

use crate::precision::in_words;
use crate::reported::Point;
use dcd_geom::glam::DVec3;
use dcd_gjk::Verdict;
use serde::Serialize;

/// The answer for a pair: only what the query computes is present. World frame, metres.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Answer {
    answer: &'static str,
    method: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) reason: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) distance: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) depth: Option<f64>,
    #[serde(flatten)]
    pub(super) way: Option<Way>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) points: Option<Vec<Point>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) error_bound: Option<f64>,
}

/// Between which points the distance or depth is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Way {
    /// From a to b.
    pub(super) normal: [f64; 3],
    pub(super) point_a: [f64; 3],
    pub(super) point_b: [f64; 3],
}

impl Way {
    pub(super) fn new(normal: DVec3, point_a: DVec3, point_b: DVec3) -> Self {
        let [normal, point_a, point_b] = [normal, point_a, point_b].map(|v| v.to_array());
        Self { normal, point_a, point_b }
    }

    pub(super) fn is_finite(&self) -> bool {
        let Self { normal, point_a, point_b } = self;
        [normal, point_a, point_b].into_iter().flatten().all(|x| x.is_finite())
    }
}

impl Answer {
    /// The verdict alone.
    pub(super) fn new<A>(verdict: &Verdict<A>, method: &'static str) -> Self {
        let (answer, reason) = match verdict {
            Verdict::Apart => ("apart", None),
            Verdict::Touching(_) => ("touching", None),
            Verdict::Undecided(reason) => ("undecided", Some(in_words(*reason))),
        };
        let (distance, depth, way, points, error_bound) = (None, None, None, None, None);
        Self { answer, method, reason, distance, depth, way, points, error_bound }
    }

    /// The same with the parts of a and b exchanged.
    pub(super) fn mirrored(self) -> Self {
        let way = self.way.map(|Way { normal, point_a, point_b }| Way {
            normal: normal.map(|x| -x),
            point_a: point_b,
            point_b: point_a,
        });
        let points = self.points.map(|points| points.into_iter().map(Point::mirrored).collect());
        Self { way, points, ..self }
    }
}
