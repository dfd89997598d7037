//! Files of JSON Lines about one robot: a line of JSON comes out for each, in order.

use super::picture::Picture;
use super::refused;
use crate::failure::{Failure, print_message};
use crate::output::Output;
use crate::progress::Progress;
use dcd_exec::{Exec, PerThread, Segments};
use dcd_io::{read_lines, shown};
use dcd_pipeline::Par;
use dcd_robot::{
    AllowedPairs, AttachedObject, EdgeCertificate, MeshSource, Robot, RobotError, StateReader,
    Workcell, World,
};
use serde::Serialize;
use serde_json::json;
use std::fs::File;
use std::io::{self, BufReader, IsTerminal, Write, stdout};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// How many lines are read before they are checked.
const BLOCK: usize = 4096;

/// The same where each has a proof, which may be a megabyte.
const BLOCK_OF_PROOFS: usize = 64;

/// What all lines have in common.
pub(super) struct Given<'a> {
    pub(super) robot: &'a Robot,
    pub(super) world: &'a World,
    pub(super) allowed: &'a AllowedPairs,
    pub(super) meshes: MeshSource,
}

/// The query of each line.
pub(super) trait Question: Sync {
    /// The content of a line.
    type Item: Send + Sync;
    /// What a thread keeps from line to line.
    type Checker: Default + Send;
    type Answer: Clone + Send + Sync + Serialize;
    /// What the lines are called.
    const PLURAL: &'static str;
    /// How many lines a task checks: some tenths of a millisecond of work.
    const PER_TASK: usize;

    /// The number of a line under its name.
    fn which(index: usize) -> Which;

    fn read(reader: &mut StateReader<'_>, line: &[u8]) -> Result<Self::Item, RobotError>;

    /// The states that are named in it.
    fn states(item: &Self::Item) -> &[Vec<f64>];

    fn check(
        &self,
        given: &Given<'_>,
        checker: &mut Self::Checker,
        item: &Self::Item,
    ) -> Result<Self::Answer, Refusal>;

    /// What the robot carries in it.
    fn attached(item: &Self::Item) -> &Arc<[AttachedObject]>;

    /// What a certificate says of it.
    fn proof(_: &Self::Answer) -> &Proof {
        &Proof::None
    }

    /// Adds what was checked to a picture.
    fn draw(robot: &Robot, item: &Self::Item, answer: &Self::Answer, picture: &mut Picture);
}

/// What a certificate says of an answer.
#[derive(Clone, Debug)]
pub(super) enum Proof {
    None,
    /// There is nothing to prove; what the answer is called.
    NotFree(&'static str),
    Found {
        /// The line that states the robot and its world.
        cell: Arc<str>,
        certificate: Arc<EdgeCertificate>,
    },
    Missing {
        error: String,
    },
}

/// The files that are written beside the answers.
#[derive(Debug, Default)]
pub(super) struct Outputs {
    pub(super) glb: Option<Output>,
    pub(super) certificate: Option<Output>,
}

impl Outputs {
    /// [`Output::check_no_input`] of each.
    pub(super) fn check_no_input(&self, inputs: &[PathBuf]) -> Result<(), Failure> {
        let mut outputs = [&self.glb, &self.certificate].into_iter().flatten();
        outputs.try_for_each(|output| output.check_no_input(inputs))
    }
}

/// The first key of the output for a line.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Which {
    State(usize),
    Edge(usize),
}

/// The output for a line.
#[derive(Clone, Debug, Serialize)]
struct Line<A> {
    #[serde(flatten)]
    which: Which,
    #[serde(flatten)]
    outcome: Outcome<A>,
}

#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
enum Outcome<A> {
    Checked(A),
    Refused { error: String },
}

/// The names of a pair of a cell's objects, sorted.
pub(super) fn sorted_names(cell: &Workcell, pair: (u32, u32)) -> [String; 2] {
    let mut names = cell.names_of(pair).map(str::to_owned);
    names.sort();
    names
}

/// Why a line was refused, in words.
#[derive(Clone, Debug)]
pub(super) struct Refusal(String);

impl From<RobotError> for Refusal {
    fn from(error: RobotError) -> Self {
        Self(error.to_string())
    }
}

/// What is made for a robot that carries something, or why it is refused, kept while lines say the same.
#[derive(Debug)]
pub(super) struct CellCache<T>(Option<Carrying<T>>);

/// What is made for one load.
#[derive(Debug)]
struct Carrying<T> {
    attached: Arc<[AttachedObject]>,
    made: Result<T, Refusal>,
}

impl<T> Default for CellCache<T> {
    fn default() -> Self {
        Self(None)
    }
}

impl<T> CellCache<T> {
    pub(super) fn of(
        &mut self,
        attached: &Arc<[AttachedObject]>,
        make: impl FnOnce(&[AttachedObject]) -> Result<T, RobotError>,
    ) -> Result<&mut T, Refusal> {
        let made = match self.0.take() {
            Some(last) if Arc::ptr_eq(&last.attached, attached) => last.made,
            _ => make(attached).map_err(Refusal::from),
        };
        let last = self.0.insert(Carrying { attached: Arc::clone(attached), made });
        last.made.as_mut().map_err(|refusal| refusal.clone())
    }
}

/// Answers the lines of a file in their order, and draws them, if a file is named for it.
pub(super) fn answer<Q: Question>(
    question: &Q,
    given: &Given<'_>,
    path: &Path,
    outputs: Outputs,
) -> Result<(), Failure> {
    let place = shown(path);
    let file = File::open(path).map_err(|error| Failure::at(&place, error))?;
    let defaults = given.robot.state(&given.world.joints).map_err(refused)?;
    let mut reader = StateReader::new(given.robot, defaults, given.meshes.clone());
    let mut out = stdout().lock();
    // Lines on a terminal are progress enough.
    let progress = (!out.is_terminal()).then(|| Progress::over(0, Q::PLURAL));
    let mut lines = read_lines(BufReader::new(file));
    let block_size = if outputs.certificate.is_some() { BLOCK_OF_PROOFS } else { BLOCK };
    let mut beside = Beside::new(outputs);
    let (mut tally, checkers, mut answers) =
        (Tally::new(Q::PLURAL), PerThread::default(), Segments::default());
    loop {
        let (block, ended) = read_block::<Q>(&mut lines, &mut reader, block_size);
        reader.take_notes().iter().for_each(|note| print_message(format_args!("{note}")));
        for (k, item) in (tally.lines..).zip(&block) {
            tally.note_limits(given.robot, item.as_ref().map_or(&[], Q::states), (&place, k + 1));
        }
        let exec = Exec::from(Par::Pool).serial_below(block.len(), 2 * Q::PER_TASK);
        answers.fill(exec, block.len().div_ceil(Q::PER_TASK), |task, answers| {
            checkers.with(|checker: &mut Q::Checker| {
                let first = task * Q::PER_TASK;
                for (k, item) in (tally.lines + first..).zip(&block[first..]).take(Q::PER_TASK) {
                    answers.push(line_of(question, given, checker, (k, item)));
                    progress.iter().for_each(Progress::step);
                }
            });
        });
        for (line, item) in answers.iter().flatten().zip(&block) {
            beside.add::<Q>(given.robot, (line, item), &place)?;
            if let Outcome::Refused { error } = &line.outcome {
                print_message(format_args!("{place}: {error}"));
                tally.refused += 1;
            }
            serde_json::to_writer(&mut out, line).map_err(|error| Failure::Output(error.into()))?;
            out.write_all(b"\n").map_err(Failure::Output)?;
        }
        tally.lines += block.len();
        if let Some(error) = ended {
            let line = tally.lines + 1;
            return Err(Failure::at(&place, format_args!("line {line}: {error}")));
        }
        if block.is_empty() {
            break;
        }
    }
    drop(progress);
    // The old files are better than those of no answer.
    if tally.refused == tally.lines {
        return tally.end(&place);
    }
    let missing = beside.write(given)?;
    tally.end(&place)?;
    if missing > 0 {
        return Err(Failure::at(place, format_args!("{missing} free edges have no certificate")));
    }
    Ok(())
}

/// What the next lines say, up to `most`, and why there are no more if reading fails: what stands before that is
/// answered.
fn read_block<Q: Question>(
    lines: &mut impl Iterator<Item = io::Result<Vec<u8>>>,
    reader: &mut StateReader<'_>,
    most: usize,
) -> (Vec<Result<Q::Item, String>>, Option<io::Error>) {
    let mut block = Vec::new();
    for line in lines.take(most) {
        match line {
            Ok(line) => block.push(Q::read(reader, &line).map_err(|error| error.to_string())),
            Err(error) => return (block, Some(error)),
        }
    }
    (block, None)
}

/// What comes out for the item of line k, counted from 0, or for why it is none.
fn line_of<Q: Question>(
    question: &Q,
    given: &Given<'_>,
    checker: &mut Q::Checker,
    (k, item): (usize, &Result<Q::Item, String>),
) -> Line<Q::Answer> {
    let checked = item
        .as_ref()
        .map_err(String::clone)
        .and_then(|item| question.check(given, checker, item).map_err(|Refusal(error)| error));
    let outcome = checked.map_or_else(
        |error| Outcome::Refused { error: format!("line {}: {error}", k + 1) },
        Outcome::Checked,
    );
    Line { which: Q::which(k), outcome }
}

/// What is written beside the answers.
struct Beside {
    drawing: Option<Drawing>,
    proofs: Option<Proofs>,
}

impl Beside {
    fn new(Outputs { glb, certificate }: Outputs) -> Self {
        Self { drawing: glb.map(Drawing::new), proofs: certificate.map(Proofs::new) }
    }

    fn add<Q: Question>(
        &mut self,
        robot: &Robot,
        (line, item): (&Line<Q::Answer>, &Result<Q::Item, String>),
        place: &str,
    ) -> Result<(), Failure> {
        let Self { drawing, proofs } = self;
        if let (Some(drawing), Outcome::Checked(answer), Ok(item)) = (drawing, &line.outcome, item)
        {
            drawing.draw::<Q>(robot, (line.which, item, answer));
        }
        proofs.as_mut().map_or(Ok(()), |proofs| proofs.add::<Q>(line, place))
    }

    /// Writes the files, and says how many free edges are not proved in theirs.
    fn write(self, given: &Given<'_>) -> Result<usize, Failure> {
        let Self { drawing, proofs } = self;
        // Lines name meshes too.
        let opened = given.meshes.paths.opened().paths();
        let files = [drawing.as_ref().map(|to| &to.file), proofs.as_ref().map(|to| &to.file)];
        files.into_iter().flatten().try_for_each(|file| file.check_no_input(&opened))?;
        // The proofs stand, whatever a picture cannot show.
        let missing = proofs.map_or(Ok(0), Proofs::commit)?;
        drawing.map(|drawing| drawing.write(given)).transpose()?;
        Ok(missing)
    }
}

/// A certificate that is written line by line.
struct Proofs {
    file: Output,
    /// What the last edge was of.
    cell: Option<Arc<str>>,
    missing: usize,
}

impl Proofs {
    fn new(file: Output) -> Self {
        Self { file, cell: None, missing: 0 }
    }

    fn add<Q: Question>(&mut self, line: &Line<Q::Answer>, place: &str) -> Result<(), Failure> {
        let (Which::State(k) | Which::Edge(k)) = line.which;
        let proof = match &line.outcome {
            Outcome::Checked(answer) => Q::proof(answer),
            Outcome::Refused { .. } => &Proof::NotFree("error"),
        };
        let text = match proof {
            Proof::None => return Ok(()),
            Proof::NotFree(answer) => json!({ "edge": k, "answer": answer }).to_string(),
            Proof::Missing { error } => {
                print_message(format_args!("{place}: line {}: no certificate: {error}", k + 1));
                self.missing += 1;
                json!({ "edge": k, "answer": "free", "error": error }).to_string()
            }
            Proof::Found { cell, certificate } => {
                // Threads make it each for itself.
                if self.cell.as_ref() != Some(cell) {
                    self.file.write(|out| writeln!(out, "{cell}"))?;
                    self.cell = Some(Arc::clone(cell));
                }
                certificate.line(k)
            }
        };
        self.file.write(|out| writeln!(out, "{text}"))
    }

    /// Writes the file, and says how many free edges are not proved in it.
    fn commit(self) -> Result<usize, Failure> {
        self.file.commit()?;
        Ok(self.missing)
    }
}

/// A picture of lines that are answered one after the other.
struct Drawing {
    file: Output,
    picture: Picture,
    /// What the robot carries in all of them, once one is drawn.
    attached: Option<Arc<[AttachedObject]>>,
    /// The first line in which it carries something else.
    other: Option<Which>,
}

impl Drawing {
    fn new(file: Output) -> Self {
        Self { file, picture: Picture::default(), attached: None, other: None }
    }

    fn draw<Q: Question>(
        &mut self,
        robot: &Robot,
        (which, item, answer): (Which, &Q::Item, &Q::Answer),
    ) {
        let attached = Q::attached(item);
        if !Arc::ptr_eq(self.attached.get_or_insert_with(|| Arc::clone(attached)), attached) {
            self.other.get_or_insert(which);
        }
        Q::draw(robot, item, answer, &mut self.picture);
    }

    fn write(self, given: &Given<'_>) -> Result<(), Failure> {
        let Self { file, picture, attached, other } = self;
        if let Some(Which::State(k) | Which::Edge(k)) = other {
            let problem = format!("line {}: the robot carries other objects than before", k + 1);
            return Err(Failure::at("--glb", problem));
        }
        let mut cell = given.cell(attached.as_deref().unwrap_or_default()).map_err(refused)?;
        picture.write(&mut cell, file)
    }
}

/// What is reported of all lines together.
struct Tally {
    plural: &'static str,
    lines: usize,
    refused: usize,
    beyond: usize,
}

impl Tally {
    fn new(plural: &'static str) -> Self {
        Self { plural, lines: 0, refused: 0, beyond: 0 }
    }

    /// Reports the first line with a state that a planner would not go to, and counts all.
    fn note_limits(&mut self, robot: &Robot, states: &[Vec<f64>], (place, line): (&str, usize)) {
        let mut beyond = states.iter().flat_map(|state| robot.beyond_limits(state)).peekable();
        if let (Some(first), 0) = (beyond.peek(), self.beyond) {
            print_message(format_args!("{place}: line {line}: {first}"));
        }
        self.beyond += usize::from(beyond.peek().is_some());
    }

    fn end(self, place: &str) -> Result<(), Failure> {
        let Self { plural, lines, refused, beyond } = self;
        if beyond > 1 {
            print_message(format_args!("{place}: {beyond} of {lines} {plural} are beyond limits"));
        }
        if refused > 0 {
            return Err(Failure::at(place, format_args!("{refused} of {lines} lines refused")));
        }
        if lines == 0 {
            return Err(Failure::at(place, format_args!("there are no {plural} in it")));
        }
        Ok(())
    }
}

impl Given<'_> {
    /// The robot in its world, with what a line says that it carries.
    pub(super) fn cell(&self, attached: &[AttachedObject]) -> Result<Workcell, RobotError> {
        let mut world = World { allowed: AllowedPairs::default(), ..self.world.clone() };
        for AttachedObject { object, touch } in attached {
            world.attach(object.clone(), touch);
        }
        // What an attached object may touch counts more than what is said of all lines.
        let mut allowed = self.allowed.clone();
        allowed.extend(&world.allowed);
        Workcell::new(self.robot.clone(), &world, &allowed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_refused_for_a_load_is_not_made_again_while_lines_say_the_same() {
        let load = || Arc::<[AttachedObject]>::from(Vec::new());
        let (none, same) = (load(), load());
        let mut made = 0;
        let mut cache = CellCache::<u32>::default();
        let mut ask = |attached: &Arc<[AttachedObject]>, is_refused: bool| {
            let found = cache.of(attached, |_| {
                made += 1;
                let error = RobotError::TooLarge { what: "pairs", limit: 7 };
                if is_refused { Err(error) } else { Ok(made) }
            });
            (found.map(|number| *number).map_err(|Refusal(why)| why), made)
        };
        let refused = Err("more than 7 pairs".to_owned());
        assert_eq!(ask(&none, true), (refused.clone(), 1));
        assert_eq!(ask(&none, false), (refused, 1));
        assert_eq!(ask(&same, false), (Ok(2), 2));
        assert_eq!(ask(&same, true), (Ok(2), 2));
    }
}
