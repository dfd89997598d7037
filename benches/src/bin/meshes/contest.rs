//! Runs everyone, judges, and takes times.

use std::path::Path;

use anyhow::{Context, Result, bail};
use dcd_benches::Effort;
use dcd_benches::timing::{Pair, pairs_of, time};
use dcd_geom::{Polytope, Pose, Shape};
use dcd_gjk::{PosedShape, PosedSupport, Verdict, certified, mesh};
use dcd_io::load_mesh;
use dcd_parry::{Library, Query};
use dcd_scenes::poses_in;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// Two meshes and the poses of the second.
pub(crate) struct Contest {
    fixed: Shape,
    moving: Shape,
    poses: Vec<Pose>,
}

/// How someone answered.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Answers {
    pub(crate) touching: usize,
    /// Poses on which exact integers say otherwise.
    pub(crate) wrong: usize,
    pub(crate) undecided: usize,
}

/// Our time beside that of a rival.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Beside {
    pub(crate) rival: String,
    pub(crate) poses: String,
    pub(crate) count: usize,
    pub(crate) pair: Pair,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Outcome {
    pub(crate) triangles: [usize; 2],
    pub(crate) poses: usize,
    pub(crate) ours: Answers,
    pub(crate) parry_f32: Answers,
    pub(crate) parry_f64: Answers,
    /// Poses on which not all three agree, and so many of them were judged exactly.
    pub(crate) judged: usize,
    pub(crate) times: Vec<Beside>,
}

/// One answer a pose, none where there is no answer.
type Replies = Vec<Option<bool>>;

impl Contest {
    /// Translations are uniform in the AABB of the fixed mesh.
    pub(crate) fn new(paths: [&Path; 2], seed: u64, count: usize) -> Result<Self> {
        let [fixed, moving] = paths.map(load_mesh);
        let (fixed, moving) = (fixed?, moving?);
        let (low, high) = fixed.extent();
        let poses = poses_in(low, high, seed).take(count).collect();
        Ok(Self { fixed: fixed.into_shape()?, moving: moving.into_shape()?, poses })
    }

    pub(crate) fn run(&self, effort: Effort) -> Result<Outcome> {
        let every: Vec<usize> = (0..self.poses.len()).collect();
        let mut scratch = mesh::Scratch::default();
        let ours: Replies = self.poses.iter().map(|pose| self.ours(pose, &mut scratch)).collect();
        let parry_f32 = Parry::<f32>::of(self)?;
        let parry_f64 = Parry::<f64>::of(self)?;
        let (of_f32, of_f64) = (parry_f32.replies(), parry_f64.replies());

        let all = [&ours, &of_f32, &of_f64];
        let differ = |k: &usize| all.iter().any(|replies| replies[*k] != ours[*k]);
        let unclear = |k: &usize| differ(k) || ours[*k].is_none();
        let judged: Vec<usize> = every.iter().copied().filter(unclear).collect();
        let truth: Vec<(usize, bool)> = judged.iter().map(|&k| (k, self.truth(k))).collect();
        let account = |replies: &Replies| Answers {
            touching: replies.iter().filter(|reply| **reply == Some(true)).count(),
            wrong: truth.iter().filter(|&&(k, yes)| replies[k] == Some(!yes)).count(),
            undecided: replies.iter().filter(|reply| reply.is_none()).count(),
        };

        let answer = |touching: bool| {
            every.iter().copied().filter(|&k| ours[k] == Some(touching)).collect::<Vec<_>>()
        };
        let subsets =
            [("all", every.clone()), ("touching", answer(true)), ("apart", answer(false))];
        let mut times = Vec::new();
        for (name, which) in &subsets {
            if !which.is_empty() {
                parry_f32.race(self, (name, which), effort, &mut times);
                parry_f64.race(self, (name, which), effort, &mut times);
            }
        }
        Ok(Outcome {
            triangles: [triangles(&self.fixed)?, triangles(&self.moving)?],
            poses: every.len(),
            ours: account(&ours),
            parry_f32: account(&of_f32),
            parry_f64: account(&of_f64),
            judged: judged.len(),
            times,
        })
    }

    fn ours(&self, pose: &Pose, scratch: &mut mesh::Scratch) -> Option<bool> {
        let fixed = PosedShape { shape: &self.fixed, pose: &Pose::IDENTITY };
        let (verdict, _) = mesh::overlap(fixed, PosedShape { shape: &self.moving, pose }, scratch);
        match verdict {
            Verdict::Apart => Some(false),
            Verdict::Touching(()) => Some(true),
            Verdict::Undecided(_) => None,
        }
    }

    /// Every pair of triangles whose AABBs come near each other, in exact integers.
    fn truth(&self, k: usize) -> bool {
        let fixed = posed(&self.fixed, &Pose::IDENTITY);
        let moving = posed(&self.moving, &self.poses[k]);
        moving.iter().any(|(hull, low, high)| {
            fixed.iter().any(|(other, other_low, other_high)| {
                low.cmple(*other_high).all()
                    && other_low.cmple(*high).all()
                    && certified::overlap_exactly(
                        PosedSupport::polytope(other, &Pose::IDENTITY),
                        PosedSupport::polytope(hull, &self.poses[k]),
                    )
            })
        })
    }
}

/// Each triangle with its AABB in the world, grown by far more than any rounding.
fn posed(shape: &Shape, pose: &Pose) -> Vec<(Polytope, DVec3, DVec3)> {
    let Shape::Mesh(mesh) = shape else { return Vec::new() };
    let near = DVec3::splat(1e-6 * (mesh.reach() + pose.translation().length()));
    let triangles = (0..mesh.triangles().len()).filter_map(|k| mesh.corners(k));
    let boxed = triangles.filter_map(|corners| {
        let [a, b, c] = corners.map(|corner| pose.apply(corner));
        let hull = Polytope::hull(corners.to_vec()).ok()?;
        Some((hull, a.min(b).min(c) - near, a.max(b).max(c) + near))
    });
    boxed.collect()
}

fn triangles(shape: &Shape) -> Result<usize> {
    match shape {
        Shape::Mesh(mesh) => Ok(mesh.triangles().len()),
        other => bail!("{other:?} is no mesh"),
    }
}

/// Parry's meshes, made and posed outside of any timer.
struct Parry<R: Library> {
    fixed: R::Form,
    moving: R::Form,
    poses: Vec<R::Pose>,
    name: &'static str,
}

/// Which of the two meshes Parry is given first: its search is not symmetric.
#[derive(Clone, Copy)]
enum First {
    Fixed,
    Moving,
}

impl<R: Library> Parry<R> {
    fn of(contest: &Contest) -> Result<Self> {
        let form = |shape| R::form(shape).context("Parry refuses a mesh");
        let poses = contest.poses.iter().map(R::pose).collect();
        let name = if size_of::<R>() == 4 { "Parry f32" } else { "Parry f64" };
        Ok(Self { fixed: form(&contest.fixed)?, moving: form(&contest.moving)?, poses, name })
    }

    fn answer(&self, first: First, k: usize) -> Option<bool> {
        let here = R::pose(&Pose::IDENTITY);
        let (fixed, moving) = ((&self.fixed, &here), (&self.moving, &self.poses[k]));
        match first {
            First::Fixed => R::touching(Query::IntersectionTest, fixed, moving),
            First::Moving => R::touching(Query::IntersectionTest, moving, fixed),
        }
    }

    fn replies(&self) -> Replies {
        (0..self.poses.len()).map(|k| self.answer(First::Fixed, k)).collect()
    }

    /// Takes turns with us on some of the poses, in both of its orders.
    fn race(
        &self,
        contest: &Contest,
        (name, which): (&str, &[usize]),
        effort: Effort,
        times: &mut Vec<Beside>,
    ) {
        let rounds = if effort == Effort::Quick { 3 } else { 5 };
        let mut scratch = mesh::Scratch::default();
        for (first, order) in [(First::Fixed, "env first"), (First::Moving, "rob first")] {
            let mut ours = || {
                let yes =
                    |k: &&usize| contest.ours(&contest.poses[**k], &mut scratch) == Some(true);
                [time(|| which.iter().filter(yes).count()).0]
            };
            let rival = || {
                let yes = |k: &&usize| self.answer(first, **k) == Some(true);
                [time(|| which.iter().filter(yes).count()).0]
            };
            let [pair] = pairs_of(rounds, &mut ours, rival);
            let rival = format!("{}, {order}", self.name);
            times.push(Beside { rival, poses: name.to_owned(), count: which.len(), pair });
        }
    }
}
