//! `dcd robot`: which links of a robot touch each other or its world.

mod acm;
mod edges;
mod geometry;
mod judge;
mod lines;
mod picture;
mod problems;
mod state;
mod states;

use crate::failure::{Failure, print_message};
use crate::output::{Output, check_distinct};
use clap::{Args, ValueEnum};
use dcd_io::{MeshPaths, shown};
use dcd_pipeline::{Par, Pipeline};
use dcd_robot::{
    AllowedPairs, MeshSource, PairSearch, Request, Robot as Model, RobotError, Srdf, Workcell,
    World,
};
use geometry::{Geometry, Links, LinksOf, link_shapes};
use picture::Picture;
use serde::Serialize;
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::io::{Write, stdout};
use std::path::{Path, PathBuf};

const DETAILS: &str = "\
Each mesh of the URDF's collision geometry (STL, COLLADA, OBJ, glTF, binary PLY) is taken as the \
hull of its vertices, or as --links and --links-of say. Without an SRDF, links that a \
joint joins and links that are rigidly tied may touch; links without a shape are passed over, \
so that each link may touch the nearest one above it that has a shape. Joints that are fixed in the URDF stay as \
they are, whatever a request says.

A world is a scene of MoveIt as YAML, as ROS or Robowflex write it. Used are: boxes, spheres, \
cylinders, cones and meshes (surfaces without an inside); header.frame_id, which is empty, the \
frame of the SRDF's virtual joint, a link's at the scene's state, or one of \
fixed_frame_transforms; joint values, where --state or a request says nothing; the virtual joint's \
transform; attached objects; link_padding and link_scale of links and what they carry, against the \
world alone; the allowed collision matrix with its defaults, which counts more than the SRDF; \
operations add and remove. \
Planes, an octomap and other operations are refused. A file whose name ends in .scene is the text that \
MoveIt and RViz save: objects alone.

Whatever a file says that is not understood is refused (exit code 2). What is understood and makes \
no difference (colours, velocities, inertias, visual geometry, values of fixed joints), and what a \
planner would warn of (values beyond limits, names that the robot does not have), is named on \
standard error. xacro must be expanded first: xacro FILE > robot.urdf

Files that are opened, all for reading: those named here, each mesh that the collision geometry of \
the URDF names, the buffers that a glTF names, and each package.xml where a package is looked for. \
Such a name may lead anywhere: a package:// or model:// is the folder that --package gives it; \
else the one whose package.xml names it, or that has none and is called so, below a folder of ROS_PACKAGE_PATH, \
or beside or above the URDF; else what follows the package's name, or begins with it, beside or above the URDF. \
file:///A is /A, any other name itself, from the URDF's folder or any above it. Nothing else is \
opened, no texture and no visual mesh.

Limits, each refused beyond: 64 MiB a file; of XML 2,000,000 elements, 64 nested, 64 attributes an \
element, 64 namespaces; of YAML 4,000,000 nodes, 64 nested, 10,000 aliases; of a robot 10,000 mesh \
files of 2 GiB each, 16,777,216 vertices; of a COLLADA or glTF file 4,194,304 triangles; of COLLADA \
64 attributes an element, 1,024 namespaces; of a \
package search 10,000 folders, 4 nested, in each folder of ROS_PACKAGE_PATH, and 1 MiB a \
package.xml; 8,388,608 pairs of shapes that may touch (rigid bodies do not count); with \
--all-problems 4,096 shapes of a robot.

--all-problems checks, for each scene and request of the archive, 100 states on the straight line \
from start to goal in joint space, both ends among them, by Parry in f64 as well, on the same \
shapes; each pair on which the two differ is judged exactly and reported. Times are of one thread. \
Ours: kinematics (measured separately and subtracted from the checks, which include it); preparation \
of world and robot, once a problem (the checks prepare the obstacles for the narrow phase, whether \
they need it or not); a batch of 100 states, for all hits and for a first hit of each. Parry's: the \
AABBs of the links, a tree over the world that is built before, and query::intersection_test, up to \
the last or the first hit. \
ratio is Parry's check alone over our sum, for all hits, ratio_first for first hits. Padded links are \
refused there. A file of the archive unpacks to 16,777,216 bytes at most, all of it to \
1,073,741,824.";

// clap does not insist on what an argument requires where that conflicts with another one that is given. So
// what depends on --states, --edges, --request or --acm conflicts with all that the same does.

const NOT_WITH_STATES: [&str; 6] = ["state", "edges", "request", "goal", "all_problems", "acm"];
const NOT_WITH_EDGES: [&str; 6] = ["state", "states", "request", "goal", "all_problems", "acm"];
const NOT_WITH_REQUEST: [&str; 5] = ["state", "states", "edges", "all_problems", "acm"];
const NOT_WITH_ACM: [&str; 9] =
    ["srdf", "world", "state", "states", "edges", "request", "goal", "all_problems", "padding"];

/// Which way is up in a mesh file.
#[derive(Clone, Copy, ValueEnum)]
enum UpAxis {
    /// Coordinates as they stand in the file, as MoveIt and RViz take them
    Ros,
    /// The up axis that the file names is turned to z
    File,
}

/// Find the touching links of a robot
#[derive(Args)]
#[command(after_long_help = format!("{}\n\n{}\n\n{DETAILS}", states::FORMAT, edges::FORMAT))]
pub(crate) struct Robot {
    /// The robot as URDF
    urdf: PathBuf,
    /// The pairs of links that may touch (disable_collisions); a later file overrides an earlier one
    #[arg(long, value_name = "FILE")]
    srdf: Vec<PathBuf>,
    /// How meshes of links are represented: hulls (of their vertices), hulls:N (hulls round them of at most N
    /// vertices; how much larger is reported), meshes (their triangles, which have no inside)
    #[arg(long, value_name = "hulls|hulls:N|meshes", default_value_t)]
    links: Links,
    /// The same for one link
    #[arg(long, value_name = "LINK=hulls|hulls:N|meshes")]
    links_of: Vec<LinksOf>,
    /// Where a package is whose meshes the URDF names: NAME=DIR
    #[arg(long, value_name = "NAME=DIR")]
    package: Vec<String>,
    /// Which way is up in a COLLADA or glTF file that says so
    #[arg(long, value_enum, default_value = "ros")]
    up_axis: UpAxis,
    /// The obstacles: a scene of MoveIt as YAML, or as text (.scene)
    #[arg(long, value_name = "SCENE", conflicts_with = "all_problems")]
    world: Option<PathBuf>,
    /// Joint values, comma-separated: one for each moved joint in the URDF's order, or NAME=VALUE
    /// for some [default: the world's, else 0]
    #[arg(
        long,
        value_name = "VALUES",
        allow_hyphen_values = true,
        conflicts_with_all = ["request", "goal", "all_problems"]
    )]
    state: Option<String>,
    /// States in place of one, JSON Lines (format: see --help): prints a line of JSON for each
    #[arg(long, value_name = "FILE", conflicts_with_all = NOT_WITH_STATES)]
    states: Option<PathBuf>,
    /// Measure the least signed distance of each state of --states too, with its derivative by the joints
    #[arg(long, requires = "states", conflicts_with_all = NOT_WITH_STATES)]
    clearance: bool,
    /// Edges between states, JSON Lines (format: see --help): whether each is proved free throughout
    #[arg(long, value_name = "FILE", conflicts_with_all = NOT_WITH_EDGES)]
    edges: Option<PathBuf>,
    /// The most intervals of an edge that are checked
    #[arg(
        long,
        value_name = "N",
        requires = "edges",
        conflicts_with_all = NOT_WITH_EDGES,
        default_value_t = 100_000
    )]
    budget: usize,
    /// Write for each free edge of --edges the planes that prove it (format: see --help)
    #[arg(long, value_name = "FILE", requires = "edges", conflicts_with_all = NOT_WITH_EDGES)]
    certificate: Option<PathBuf>,
    /// Grow all links and what they carry by this much on all sides, metres, against the world alone
    #[arg(
        long,
        value_name = "METRES",
        allow_hyphen_values = true,
        conflicts_with = "all_problems"
    )]
    padding: Option<f64>,
    /// Apply padding, the world's too, between the robot's links as well
    #[arg(long, conflicts_with_all = ["all_problems", "acm"])]
    pad_self: bool,
    /// A request of MoveIt as YAML in place of a state: its start
    #[arg(long, value_name = "REQUEST.yaml", conflicts_with_all = NOT_WITH_REQUEST)]
    request: Option<PathBuf>,
    /// The request's goal in place of its start
    #[arg(long, requires = "request", conflicts_with_all = NOT_WITH_REQUEST)]
    goal: bool,
    /// An archive (tar.bz2) of sceneNUMBER.yaml and requestNUMBER.yaml in folders, a set of problems each: all
    /// are checked, beside Parry
    #[arg(long, value_name = "ARCHIVE")]
    all_problems: Option<PathBuf>,
    /// Write the pairs of links that need no check as an SRDF: Adjacent, Always, and Never within the
    /// joints' limits, with proved="true" where that is proved and not only sampled; pairs with a joint
    /// between them that slides without limits are left to be checked
    #[arg(long, value_name = "OUT.srdf", conflicts_with_all = NOT_WITH_ACM)]
    acm: Option<PathBuf>,
    /// How many states are sampled
    #[arg(
        long,
        value_name = "N",
        requires = "acm",
        conflicts_with_all = NOT_WITH_ACM,
        default_value_t = PairSearch::default().samples
    )]
    samples: usize,
    /// Write pairs that touch at rest but not always too, as Default
    #[arg(long, requires = "acm", conflicts_with_all = NOT_WITH_ACM)]
    allow_default: bool,
    /// Write what was checked as binary glTF: links and obstacles, what touches in another colour, the points
    /// where; states one after the other, half a second each; edges as motions of two seconds
    #[arg(long, value_name = "OUT.glb", conflicts_with_all = ["all_problems", "acm"])]
    glb: Option<PathBuf>,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// What one state's check found.
#[derive(Debug, Serialize)]
struct Answer {
    robot: String,
    /// The subject of the answer.
    #[serde(flatten)]
    geometry: Geometry,
    links_with_shapes: usize,
    obstacles: usize,
    state: Vec<(String, f64)>,
    candidates: usize,
    touching: Vec<[String; 2]>,
    undecided: Vec<[String; 2]>,
}

impl Robot {
    pub(crate) fn run(self) -> Result<(), Failure> {
        let outputs = self.outputs()?;
        let meshes = self.meshes()?;
        let model = Model::load_with(&self.urdf, &meshes).map_err(refused)?;
        let opened = meshes.paths.opened().paths();
        outputs.check_no_input(&opened)?;
        note(&self.urdf, model.notes());
        // One object of JSON says it by itself; lines of it do not.
        if !self.json || self.states.is_some() || self.edges.is_some() {
            print_message(self.geometry(&model));
        }
        let srdf = load_srdf(&self.srdf, &model)?;
        let allowed = match &srdf {
            Some(srdf) => srdf.allowed.clone(),
            None => AllowedPairs::adjacent(&model),
        };
        if let Some(path) = self.states.as_ref().or(self.edges.as_ref()) {
            return self.answer_lines((&model, srdf.as_ref()), allowed, path, outputs);
        }
        if let Some(out) = &self.acm {
            let search = PairSearch { samples: self.samples, ..PairSearch::default() };
            let read: Vec<&Path> =
                opened.iter().chain([&self.urdf]).map(PathBuf::as_path).collect();
            let allow_default = self.allow_default;
            let found = acm::Acm { search, allow_default, out, read: &read }.write(&model)?;
            let text = if self.json { found.json() } else { found.text() };
            return stdout().write_all(text.as_bytes()).map_err(Failure::Output);
        }
        let text = match &self.all_problems {
            Some(archive) => {
                let given = problems::Given {
                    robot: &model,
                    srdf: srdf.as_ref(),
                    allowed,
                    geometry: self.geometry(&model),
                };
                let checked = problems::check(&given, archive)?;
                if self.json { checked.json() } else { checked.text() }
            }
            None => {
                let answer = self.check(model, srdf.as_ref(), allowed, outputs.glb)?;
                if self.json { answer.json() } else { answer.text() }
            }
        };
        stdout().write_all(text.as_bytes()).map_err(Failure::Output)
    }

    /// Where the meshes are and how they are read.
    fn meshes(&self) -> Result<MeshSource, Failure> {
        let folder = self.urdf.parent().unwrap_or(Path::new("."));
        let mut paths = MeshPaths::new(folder).with_environment();
        for package in &self.package {
            paths = match package.split_once('=') {
                Some((name, folder)) if !name.is_empty() && !folder.is_empty() => {
                    paths.with_package(name, folder)
                }
                _ => return Err(Failure::at("--package", format!("{package:?} is no NAME=DIR"))),
            };
        }
        let up_axis = match self.up_axis {
            UpAxis::Ros => dcd_io::UpAxis::Ros,
            UpAxis::File => dcd_io::UpAxis::File,
        };
        let of_links = link_shapes(&self.links_of)?;
        Ok(MeshSource { paths, up_axis, shapes: self.links.0, of_links })
    }

    fn geometry(&self, robot: &Model) -> Geometry {
        Geometry::new(self.links, &self.links_of, robot)
    }

    fn check(
        &self,
        model: Model,
        srdf: Option<&Srdf>,
        mut allowed: AllowedPairs,
        glb: Option<Output>,
    ) -> Result<Answer, Failure> {
        let mut world = self.load_world(&model, srdf)?;
        extend(&mut allowed, &world.allowed);
        let state = self.state_of(&model, srdf, &mut world)?;
        model
            .beyond_limits(&state)
            .iter()
            .for_each(|beyond| print_message(format_args!("state: {beyond}")));
        let cell = Workcell::new(model, &world, &allowed);
        let mut cell = cell.map_err(|error| match &self.world {
            Some(path) => Failure::at(shown(path), error),
            None => refused(error),
        })?;
        cell.set_state(&state).map_err(refused)?;
        let mut pipeline = Pipeline::new();
        let step = pipeline.step(cell.scene(), Par::Serial);
        let named = |pair| cell.names_of(pair).map(str::to_owned);
        let touching = once(step.contacts().map(named));
        let undecided = step.report().undecided().iter();
        let undecided = once(undecided.map(|undecided| named(undecided.pair.into())));
        let candidates = step.candidate_count();
        if let Some(glb) = glb {
            let mut picture = Picture::default();
            picture.show(&state);
            picture.write(&mut cell, glb)?;
        }
        Ok(Answer {
            robot: cell.robot().name.clone(),
            geometry: self.geometry(cell.robot()),
            links_with_shapes: links_with_shapes(cell.robot()),
            obstacles: world.obstacles.len(),
            state: cell.robot().variables().iter().cloned().zip(state).collect(),
            candidates,
            undecided: undecided.difference(&touching).cloned().collect(),
            touching: touching.into_iter().collect(),
        })
    }

    fn load_world(&self, model: &Model, srdf: Option<&Srdf>) -> Result<World, Failure> {
        let mut world = World::default();
        if let Some(path) = &self.world {
            world = World::load(path, model, srdf).map_err(refused)?;
            note(path, &world.notes);
        }
        if let Some(padding) = self.padding {
            world.pad(model, padding).map_err(|error| Failure::at("--padding", error))?;
        }
        if self.pad_self {
            world.padding.values_mut().for_each(|padding| padding.against_robot = true);
        }
        Ok(world)
    }

    /// Checks the states or edges of a file.
    fn answer_lines(
        &self,
        (model, srdf): (&Model, Option<&Srdf>),
        mut allowed: AllowedPairs,
        path: &Path,
        outputs: lines::Outputs,
    ) -> Result<(), Failure> {
        let world = self.load_world(model, srdf)?;
        extend(&mut allowed, &world.allowed);
        // Mesh files of what is carried are beside the file that names them.
        let folder = path.parent().unwrap_or(Path::new("."));
        let meshes = MeshSource { paths: MeshPaths::new(folder), ..self.meshes()? };
        let given = lines::Given { robot: model, world: &world, allowed: &allowed, meshes };
        if self.states.is_some() {
            lines::answer(&states::States { clearance: self.clearance }, &given, path, outputs)
        } else {
            let certificates = match self.certificate {
                Some(_) => edges::Certificates::Written,
                None => edges::Certificates::None,
            };
            let edges = edges::Edges { budget: self.budget, certificates };
            lines::answer(&edges, &given, path, outputs)
        }
    }

    /// The files of the picture and of the certificate, which are none that is read.
    fn outputs(&self) -> Result<lines::Outputs, Failure> {
        let read = [&self.world, &self.states, &self.edges, &self.request];
        let read = self.srdf.iter().chain(read.into_iter().flatten()).chain([&self.urdf]);
        let read: Vec<&Path> = read.map(PathBuf::as_path).collect();
        let written = self.glb.iter().chain(&self.certificate);
        check_distinct(&read, &written.map(PathBuf::as_path).collect::<Vec<_>>())?;
        let made = |path: &Option<PathBuf>| path.as_deref().map(Output::create).transpose();
        Ok(lines::Outputs { glb: made(&self.glb)?, certificate: made(&self.certificate)? })
    }

    fn state_of(
        &self,
        model: &Model,
        srdf: Option<&Srdf>,
        world: &mut World,
    ) -> Result<Vec<f64>, Failure> {
        if let Some(path) = &self.request {
            let request = Request::load(path).map_err(refused)?;
            note(path, &request.notes(model));
            let state = request.place_base(world, model, srdf).and_then(|()| {
                if self.goal {
                    request.goal_in(world, model)
                } else {
                    request.start_in(world, model)
                }
            });
            return state.map_err(|error| Failure::at(shown(path), error));
        }
        match &self.state {
            Some(text) => {
                state::parse(text, model, &world.joints).map_err(|e| Failure::at("--state", e))
            }
            None => model.state(&world.joints).map_err(refused),
        }
    }
}

/// All files merged, if there are any.
fn load_srdf(paths: &[PathBuf], model: &Model) -> Result<Option<Srdf>, Failure> {
    let mut all: Option<Srdf> = None;
    for path in paths {
        let srdf = Srdf::load(path).map_err(refused)?;
        let at = |error| Failure::at(shown(path), error);
        note(path, &srdf.notes(model).map_err(at)?);
        match &mut all {
            Some(all) => all.extend(srdf).map_err(at)?,
            None => all = Some(srdf),
        }
    }
    Ok(all)
}

/// Takes over what a scene says of pairs, and prints where MoveIt would check more of them.
fn extend(allowed: &mut AllowedPairs, of_scene: &AllowedPairs) {
    let missing = allowed.count_missing_in_matrix_of(of_scene);
    if missing > 0 {
        print_message(format_args!(
            "{missing} pairs may touch by the SRDF alone; MoveIt would check them, for the scene's matrix takes the SRDF's place there"
        ));
    }
    allowed.extend(of_scene);
}

/// How many links have a shape, or carry one.
fn links_with_shapes(robot: &Model) -> usize {
    robot.parts().iter().map(|part| part.link).collect::<BTreeSet<_>>().len()
}

/// Prints what a file says that is not used, or that a planner would warn of.
fn note(path: &Path, notes: &[String]) {
    notes.iter().for_each(|note| print_message(format_args!("{}: {note}", shown(path))));
}

/// Each pair of names once, though links have several shapes.
fn once(pairs: impl Iterator<Item = [String; 2]>) -> BTreeSet<[String; 2]> {
    pairs.collect()
}

/// A failure from an error that names its file.
fn refused(error: RobotError) -> Failure {
    Failure::Input(error.to_string())
}

impl Answer {
    fn json(&self) -> String {
        // Strings and finite numbers alone: nothing in it can fail.
        serde_json::to_string(self).unwrap_or_default() + "\n"
    }

    fn text(&self) -> String {
        let mut text = String::new();
        for (pairs, what) in [(&self.touching, "touch"), (&self.undecided, "are undecided")] {
            for [a, b] in pairs {
                // Writing to a string cannot fail.
                let [a, b] = [a, b].map(|name| on_one_line(name));
                let _ = writeln!(text, "{a} and {b} {what}");
            }
        }
        if text.is_empty() {
            text.push_str("nothing touches\n");
        }
        text
    }
}

/// A name with its control characters escaped.
fn on_one_line(name: &str) -> String {
    let escaped = |c: char| if c.is_control() { c.escape_default().to_string() } else { c.into() };
    name.chars().map(escaped).collect()
}
