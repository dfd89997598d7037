//! The lines of a certificate as they stand in the file. What is not known is refused.

use serde::de::IgnoredAny;
use serde::{Deserialize, Deserializer};

/// The only version there is.
pub(super) const FORMAT: &str = "dcd-edges-1";

/// Which of the two a line is.
#[derive(Debug, Deserialize)]
pub(super) struct Kind {
    pub(super) certificate: Option<IgnoredAny>,
}

/// What may be null, but is not left out.
fn required<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<String>, D::Error> {
    Option::deserialize(deserializer)
}

/// A robot in its world.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CellLine {
    pub(super) certificate: String,
    pub(super) robot: String,
    pub(super) links: Vec<String>,
    pub(super) base: PoseLine,
    pub(super) joints: Vec<JointLine>,
    pub(super) values: Vec<String>,
    pub(super) bodies: Vec<BodyLine>,
    pub(super) allowed: Vec<[String; 2]>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PoseLine {
    #[serde(rename = "R")]
    pub(super) rows: [[f64; 3]; 3],
    pub(super) t: [f64; 3],
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct JointLine {
    pub(super) name: String,
    pub(super) parent: String,
    pub(super) child: String,
    pub(super) origin: PoseLine,
    pub(super) motion: MotionLine,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "lowercase", deny_unknown_fields)]
pub(super) enum MotionLine {
    Fixed,
    Turns { axis: [f64; 3], value: usize, factor: f64, offset: f64 },
    Slides { axis: [f64; 3], value: usize, factor: f64, offset: f64 },
    Orients { first: usize },
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct BodyLine {
    pub(super) name: String,
    // Left out it would stand still, and need be apart from no obstacle.
    #[serde(deserialize_with = "required")]
    pub(super) link: Option<String>,
    #[serde(default)]
    pub(super) meets: Meets,
    pub(super) pose: PoseLine,
    pub(super) shape: ShapeLine,
}

/// Which others a body must be apart from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Meets {
    #[default]
    All,
    /// What links carry.
    Robot,
    /// What no link carries.
    Obstacles,
}

/// Convex pieces, or a surface of triangles.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ShapeLine {
    pub(super) pieces: Option<Vec<PieceLine>>,
    pub(super) points: Option<Vec<[f64; 3]>>,
    pub(super) triangles: Option<Vec<[usize; 3]>>,
    pub(super) radius: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PieceLine {
    pub(super) points: Option<Vec<[f64; 3]>>,
    pub(super) discs: Option<[[f64; 2]; 2]>,
    pub(super) radius: f64,
    pub(super) pose: Option<PoseLine>,
}

/// An edge and its proof.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EdgeLine {
    pub(super) edge: usize,
    pub(super) answer: String,
    pub(super) error: Option<String>,
    pub(super) control: Option<Vec<Vec<f64>>>,
    pub(super) clearance: Option<f64>,
    pub(super) pairs: Option<Vec<PairLine>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PairLine {
    pub(super) bodies: [usize; 2],
    #[serde(deserialize_with = "required")]
    pub(super) frame: Option<String>,
    pub(super) planes: Vec<Vec<f64>>,
}
