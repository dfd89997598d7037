//! The lines of a certificate: what it is about, and the planes. Numbers print so that they read back to the same f64.

use super::super::EdgeChecker;
use super::pieces::{Core, Piece, Pieces};
use super::{CertifiedPair, EdgeCertificate};
use crate::kinematics::JointFrame;
use crate::{Drive, Joint, Motion, RobotError};
use dcd_geom::Pose;
use glam::{DMat3, DVec3};
use serde::Serialize;
use std::collections::{BTreeSet, HashSet};

/// The version of the format.
const FORMAT: &str = "dcd-edges-1";

#[derive(Serialize)]
struct CellLine<'a> {
    certificate: &'static str,
    robot: &'a str,
    links: Vec<&'a str>,
    base: Placement,
    joints: Vec<JointLine<'a>>,
    values: &'a [String],
    bodies: Vec<BodyLine<'a>>,
    allowed: BTreeSet<[&'a str; 2]>,
}

/// A rotation by rows, and a translation.
#[derive(Serialize)]
struct Placement {
    #[serde(rename = "R")]
    rows: [[f64; 3]; 3],
    t: [f64; 3],
}

#[derive(Serialize)]
struct JointLine<'a> {
    name: &'a str,
    parent: &'a str,
    child: &'a str,
    origin: Placement,
    motion: MotionLine,
}

#[derive(Serialize)]
#[serde(rename_all = "lowercase")]
enum MotionLine {
    Fixed,
    Turns { axis: [f64; 3], value: usize, factor: f64, offset: f64 },
    Slides { axis: [f64; 3], value: usize, factor: f64, offset: f64 },
    Orients { first: usize },
}

#[derive(Serialize)]
struct BodyLine<'a> {
    name: &'a str,
    link: Option<&'a str>,
    meets: Meets,
    pose: Placement,
    shape: ShapeLine,
}

#[derive(Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
enum Meets {
    All,
    Robot,
    Obstacles,
}

#[derive(Serialize)]
#[serde(untagged)]
enum ShapeLine {
    Convex { pieces: Vec<PieceLine> },
    Surface { points: Vec<[f64; 3]>, triangles: Vec<[u32; 3]>, radius: f64 },
}

#[derive(Serialize)]
struct PieceLine {
    #[serde(flatten)]
    core: CoreLine,
    radius: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pose: Option<Placement>,
}

#[derive(Serialize)]
#[serde(rename_all = "lowercase")]
enum CoreLine {
    Points(Vec<[f64; 3]>),
    Discs([(f64, f64); 2]),
}

#[derive(Serialize)]
struct EdgeLine<'a> {
    edge: usize,
    answer: &'static str,
    control: &'a [Vec<f64>],
    #[serde(skip_serializing_if = "Option::is_none")]
    clearance: Option<f64>,
    pairs: Vec<PairLine<'a>>,
}

#[derive(Serialize)]
struct PairLine<'a> {
    bodies: [u32; 2],
    frame: Option<&'a str>,
    planes: Vec<Vec<f64>>,
}

impl Placement {
    fn new(rotation: &DMat3, translation: DVec3) -> Self {
        let rows = [0, 1, 2].map(|k| rotation.row(k).to_array());
        Self { rows, t: translation.to_array() }
    }

    fn of_frame(frame: &JointFrame) -> Self {
        Self::new(&frame.rotation, frame.translation)
    }

    fn of_pose(pose: &Pose) -> Self {
        Self::new(pose.rotation(), pose.translation())
    }
}

impl MotionLine {
    fn of(joint: &Joint) -> Self {
        let axis_of = |axis: DVec3, Drive { value, factor, offset }: Drive| {
            (axis.to_array(), value, factor, offset)
        };
        match joint.motion {
            Motion::Fixed => Self::Fixed,
            Motion::Turns { axis, by } => {
                let (axis, value, factor, offset) = axis_of(axis, by);
                Self::Turns { axis, value, factor, offset }
            }
            Motion::Slides { axis, by } => {
                let (axis, value, factor, offset) = axis_of(axis, by);
                Self::Slides { axis, value, factor, offset }
            }
            Motion::Orients { first } => Self::Orients { first },
        }
    }
}

impl PieceLine {
    fn of(piece: &Piece) -> Self {
        let (core, pose) = match &piece.core {
            Core::Points(points) => (CoreLine::Points(arrays(points)), None),
            Core::Discs(discs, pose) => {
                (CoreLine::Discs(*discs), pose.as_ref().map(Placement::of_pose))
            }
        };
        Self { core, radius: piece.radius, pose }
    }
}

fn arrays(points: &[DVec3]) -> Vec<[f64; 3]> {
    points.iter().map(|p| p.to_array()).collect()
}

impl ShapeLine {
    fn of(pieces: &Pieces) -> Self {
        match &pieces.surface {
            Some((points, triangles)) => Self::Surface {
                points: arrays(points),
                triangles: triangles.clone(),
                radius: pieces.list.first().map_or(0.0, |piece| piece.radius),
            },
            None => Self::Convex { pieces: pieces.list.iter().map(PieceLine::of).collect() },
        }
    }
}

/// Which others an object of the scene meets.
fn meets(checker: &EdgeChecker, object: usize) -> Meets {
    let (cell, parts) = (&checker.cell, checker.robot().parts().len());
    let padded = |part: usize| (parts..cell.scene().len()).any(|i| cell.part_of(i) == Some(part));
    match cell.part_of(object) {
        Some(_) if object >= parts => Meets::Obstacles,
        Some(part) if cell.is_padded() && padded(part) => Meets::Robot,
        _ => Meets::All,
    }
}

pub(super) fn cell(checker: &EdgeChecker, pieces: &[Pieces]) -> Result<String, RobotError> {
    let (cell, robot) = (&checker.cell, checker.robot());
    let links: Vec<&str> = robot.links().iter().map(|link| link.name.as_str()).collect();
    let joints = robot.joints().iter().map(|joint| JointLine {
        name: &joint.name,
        parent: links[joint.parent],
        child: links[joint.child],
        origin: Placement::of_frame(&joint.origin),
        motion: MotionLine::of(joint),
    });
    let joints = joints.collect();
    let body = |i: usize| {
        let part = cell.part_of(i).map(|part| &robot.parts()[part]);
        BodyLine {
            name: &cell.names()[i],
            link: part.map(|part| links[part.link]),
            meets: meets(checker, i),
            pose: match part {
                Some(part) => Placement::of_frame(&part.origin),
                None => Placement::of_pose(&cell.scene().poses()[i]),
            },
            shape: ShapeLine::of(&pieces[i]),
        }
    };
    let bodies: Vec<BodyLine<'_>> = (0..cell.scene().len()).map(body).collect();
    let line = CellLine {
        certificate: FORMAT,
        robot: &robot.name,
        allowed: allowed(checker, &bodies)?,
        base: Placement::of_frame(&robot.base),
        values: robot.variables(),
        links: links.clone(),
        joints,
        bodies,
    };
    Ok(serde_json::to_string(&line).unwrap_or_default())
}

/// The names of bodies that may touch: all pairs that are not checked and that nothing else explains.
fn allowed<'a>(
    checker: &EdgeChecker,
    bodies: &[BodyLine<'a>],
) -> Result<BTreeSet<[&'a str; 2]>, RobotError> {
    let sorted = |[i, j]: [u32; 2]| [i.min(j), i.max(j)];
    let checked: HashSet<[u32; 2]> =
        checker.pairs.iter().map(|pair| sorted(pair.objects)).collect();
    let meets = |a: &BodyLine<'_>, b: &BodyLine<'_>| match a.meets {
        Meets::All => true,
        Meets::Robot => b.link.is_some(),
        Meets::Obstacles => b.link.is_none(),
    };
    let (mut allowed, mut required) = (BTreeSet::new(), BTreeSet::new());
    // No two obstacles: there may be very many.
    let of_robot = bodies.iter().enumerate().filter(|(_, body)| body.link.is_some());
    for (i, a) in of_robot {
        for (j, b) in bodies.iter().enumerate() {
            if a.link == b.link || !meets(a, b) || !meets(b, a) {
                continue;
            }
            let names = [a.name.min(b.name), a.name.max(b.name)];
            let is_checked = checked.contains(&sorted([i as u32, j as u32]));
            (if is_checked { &mut required } else { &mut allowed }).insert(names);
        }
    }
    // Pairs are allowed by name.
    match allowed.intersection(&required).next() {
        None => Ok(allowed),
        Some([a, b]) => Err(RobotError::Refused {
            user: format!("bodies {a:?} and {b:?}"),
            why: "some pairs of those names may touch and others not: a certificate cannot say so"
                .to_owned(),
        }),
    }
}

pub(super) fn edge(certificate: &EdgeCertificate, edge: usize) -> String {
    let planes = |pair: &CertifiedPair| -> Vec<Vec<f64>> {
        let rows = pair.planes.iter().map(|plane| {
            let mut row = plane.t.to_vec();
            row.extend(plane.normal.to_array());
            row.extend(plane.offset);
            let pieces = plane.pieces.iter().flatten();
            row.extend(pieces.flat_map(|range| [range.start, range.end]).map(f64::from));
            row
        });
        rows.collect()
    };
    let pairs = certificate.pairs.iter().map(|of| PairLine {
        bodies: of.objects,
        frame: of.frame.as_deref(),
        planes: planes(of),
    });
    let line = EdgeLine {
        edge,
        answer: "free",
        control: certificate.path.control_points(),
        clearance: certificate.clearance.is_finite().then_some(certificate.clearance),
        pairs: pairs.collect(),
    };
    serde_json::to_string(&line).unwrap_or_default()
}
