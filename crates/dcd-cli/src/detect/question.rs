//! The query for the pairs of a scene.

use crate::failure::Failure;
use crate::precision::{Accuracy, Library, Precision};
use clap::{Args, ValueEnum};
use dcd_geom::Aabb;
use dcd_gjk::query::{ManifoldOptions, MeshEdges, MeshSides};
use std::path::PathBuf;

/// The question, within which distance, and where the answers go.
#[derive(Args)]
pub(super) struct QueryOptions {
    /// What to compute for each touching pair
    #[arg(long, value_enum, default_value_t, conflicts_with = "capture")]
    query: Question,
    /// How tight the error bound of a measure must be: looser is faster, and still proved; ignored with
    /// --query overlap
    #[arg(long, value_enum, default_value_t, conflicts_with = "capture")]
    accuracy: Accuracy,
    /// Pairs within M metres of each other count as touching; with --query overlap, distance and
    /// gradient
    #[arg(
        long,
        value_name = "M",
        default_value_t = 0.0,
        allow_negative_numbers = true,
        conflicts_with = "capture",
        value_parser = margin
    )]
    margin: f64,
    /// Which side of a mesh's triangles touches, with --query manifold: meshes against other shapes
    #[arg(long, value_enum, default_value_t, conflicts_with = "capture")]
    mesh_sides: Sides,
    /// Which edges and vertices of a mesh touch, with --query manifold: meshes against other shapes
    #[arg(long, value_enum, default_value_t, conflicts_with = "capture")]
    mesh_edges: Edges,
    /// Write the answer for each contact as JSON Lines, sorted by i and j (format: see
    /// --help)
    #[arg(long, value_name = "FILE", conflicts_with = "capture")]
    pub(super) answers: Option<PathBuf>,
}

/// What is computed for each touching pair.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(super) enum Question {
    /// Nothing more
    #[default]
    Overlap,
    /// How far apart it is, and between which points
    Distance,
    /// How deep it overlaps, and where
    Depth,
    /// The points in which it touches, up to four
    Manifold,
    /// Its signed distance, and how that changes with both poses
    Gradient,
}

/// The same as [`MeshSides`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum Sides {
    /// Both
    #[default]
    Both,
    /// The front, where the corners are seen counter-clockwise; what touches from behind is left out
    Front,
    /// The front, and what lies behind a face is pushed out along its normal
    Outward,
}

/// The same as [`MeshEdges`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum Edges {
    /// All, as if each triangle were alone
    #[default]
    All,
    /// Those that stand out of the surface
    Active,
}

/// A query that its precision supports.
#[derive(Clone, Copy, Debug)]
pub(super) struct Query {
    pub(super) question: Question,
    pub(super) accuracy: Accuracy,
    /// Metres.
    pub(super) margin: f64,
    /// Of a manifold.
    options: ManifoldOptions,
    pub(super) answers: Answers,
}

/// What becomes of the answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Answers {
    Kept,
    /// The contacts alone are kept.
    Dropped,
}

impl QueryOptions {
    /// The question, if that precision answers it.
    pub(super) fn query(&self, precision: Precision) -> Result<Query, Failure> {
        let Self { query: question, accuracy, margin, .. } = *self;
        let answers = if self.answers.is_some() { Answers::Kept } else { Answers::Dropped };
        let options = self.options();
        let query = Query { question, accuracy, margin, options, answers };
        if question != Question::Manifold && options != ManifoldOptions::default() {
            return Err(Failure::at("--mesh-sides, --mesh-edges", "for --query manifold alone"));
        }
        if !matches!(precision.library(), Library::Ours(_)) && !query.is_plain() {
            let only = "answers --query overlap without a margin alone";
            return Err(Failure::at(format_args!("--precision {}", precision.name()), only));
        }
        if precision != Precision::Certified && question != Question::Overlap {
            let what =
                "it is for --query overlap alone; --accuracy chooses how a measure is computed";
            return Err(Failure::at(format_args!("--precision {}", precision.name()), what));
        }
        if matches!(question, Question::Depth | Question::Manifold) && margin > 0.0 {
            let name = query.name();
            let what = format_args!("touching pairs alone have a {name}: it must be 0");
            return Err(Failure::at(format_args!("--margin {margin:e}"), what));
        }
        Ok(query)
    }

    fn options(&self) -> ManifoldOptions {
        ManifoldOptions {
            mesh_sides: match self.mesh_sides {
                Sides::Both => MeshSides::Both,
                Sides::Front => MeshSides::Front,
                Sides::Outward => MeshSides::Outward,
            },
            mesh_edges: match self.mesh_edges {
                Edges::All => MeshEdges::All,
                Edges::Active => MeshEdges::Active,
            },
        }
    }
}

impl Query {
    /// Whether the query is yes or no alone.
    pub(super) fn is_plain(&self) -> bool {
        self.question == Question::Overlap && self.margin == 0.0
    }

    /// The same as the library's type. The precision of a yes or no is chosen separately.
    pub(super) fn question(&self) -> dcd_pipeline::Question {
        let (accuracy, margin) = (self.accuracy.into(), self.margin);
        match self.question {
            Question::Overlap => {
                dcd_pipeline::Question::Overlap { precision: Default::default(), margin }
            }
            Question::Distance => dcd_pipeline::Question::Distance { accuracy, margin },
            Question::Depth => dcd_pipeline::Question::Depth { accuracy },
            Question::Manifold => {
                dcd_pipeline::Question::Manifold { accuracy, options: self.options }
            }
            Question::Gradient => dcd_pipeline::Question::Gradient { accuracy, margin },
        }
    }

    /// As it is written on the command line.
    pub(super) fn name(&self) -> String {
        let value = self.question.to_possible_value();
        value.map_or_else(String::new, |value| value.get_name().into())
    }
}

fn margin(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| format!("{text:?} is not a number"))?;
    if (0.0..=Aabb::LIMIT).contains(&value) {
        Ok(value)
    } else {
        Err(format!("{value:e} is not within 0 … {:e} metres", Aabb::LIMIT))
    }
}
