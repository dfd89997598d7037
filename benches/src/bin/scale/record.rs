//! What a step consists of: its tasks, and the serial work between, with the time of each.

use std::sync::Mutex;
use std::thread::{self, ThreadId};
use std::time::Instant;

use anyhow::{Result, bail, ensure};
use dcd_exec::{Exec, Observer, Stage};
use serde::{Deserialize, Serialize};

/// Stages of a step.
pub(crate) const STAGES: usize = Stage::ALL.len();

/// Writes down when stages, sections and tasks begin and end, and on which thread.
#[derive(Debug, Default)]
pub(crate) struct Recorder(Mutex<Vec<Event>>);

/// Something began or ended.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Event {
    what: What,
    at: Instant,
    thread: ThreadId,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum What {
    StageBegins(Stage),
    StageEnds,
    SectionBegins,
    SectionEnds,
    SortBegins(usize),
    SortEnds,
    TaskBegins(usize),
    TaskEnds,
}

/// What a step consists of, stage by stage; times in nanoseconds.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Program {
    /// In the order of [`Stage::ALL`], each a sequence with a barrier after every piece.
    pub(crate) stages: [Vec<Piece>; STAGES],
}

/// Work between two barriers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum Piece {
    /// On one thread, while the others wait.
    Serial(f64),
    /// Tasks that may run at once, in the order of their numbers.
    Section(Vec<f64>),
    /// A sort that is parallel inside.
    Sort {
        /// How many items it sorts.
        items: usize,
        /// On one thread.
        time: f64,
    },
}

impl Recorder {
    /// What happened since the last call.
    pub(crate) fn take(&self) -> Vec<Event> {
        self.with(std::mem::take)
    }

    fn note(&self, what: What) {
        let event = Event { what, at: Instant::now(), thread: thread::current().id() };
        self.with(|events| events.push(event));
    }

    fn with<T>(&self, work: impl FnOnce(&mut Vec<Event>) -> T) -> T {
        // A panic elsewhere leaves events that are as good as before.
        work(&mut self.0.lock().unwrap_or_else(|poisoned| poisoned.into_inner()))
    }
}

impl Observer for Recorder {
    fn stage_begins(&self, stage: Stage) {
        self.note(What::StageBegins(stage));
    }
    fn stage_ends(&self, _: Stage) {
        self.note(What::StageEnds);
    }
    fn section_begins(&self, _: usize) {
        self.note(What::SectionBegins);
    }
    fn section_ends(&self) {
        self.note(What::SectionEnds);
    }
    fn sort_begins(&self, items: usize) {
        self.note(What::SortBegins(items));
    }
    fn sort_ends(&self) {
        self.note(What::SortEnds);
    }
    fn task_begins(&self, task: usize) {
        self.note(What::TaskBegins(task));
    }
    fn task_ends(&self, _: usize) {
        self.note(What::TaskEnds);
    }
}

/// Time within tasks, stage by stage, whatever threads they ran on; nanoseconds. The parts of a
/// parallel sort are no tasks.
pub(crate) fn task_times(events: &[Event]) -> [f64; STAGES] {
    let mut sums = [0.0; STAGES];
    let mut stage = 0;
    // The tasks that each thread is in, the outermost first.
    let mut open: Vec<(ThreadId, Vec<Instant>)> = Vec::new();
    for event in events {
        let place = open.iter().position(|(thread, _)| *thread == event.thread);
        match event.what {
            What::StageBegins(begun) => stage = begun as usize,
            What::TaskBegins(_) => match place {
                Some(place) => open[place].1.push(event.at),
                None => open.push((event.thread, vec![event.at])),
            },
            What::TaskEnds => {
                let Some(place) = place else { continue };
                let tasks = &mut open[place].1;
                if let (Some(begun), true) = (tasks.pop(), tasks.is_empty()) {
                    sums[stage] += nanoseconds(begun, event.at);
                }
            }
            _ => {}
        }
    }
    sums
}

impl Program {
    /// Of the events of one step on one thread.
    ///
    /// # Errors
    /// Events that do not nest, which no step makes.
    pub(crate) fn of(events: &[Event]) -> Result<Self> {
        let mut program = Self::default();
        let mut place = Place::Outside;
        let mut stage = 0;
        for event in events {
            if let What::StageBegins(begun) = event.what {
                stage = begun as usize;
            }
            place = place.after(event, &mut program.stages[stage])?;
        }
        Ok(program)
    }

    /// Piece by piece the median of several runs of one step.
    ///
    /// # Errors
    /// None at all, or runs that consist of different tasks.
    pub(crate) fn median(runs: &[Self]) -> Result<Self> {
        let Some(first) = runs.first() else { bail!("no run was recorded") };
        let mut median = first.clone();
        for (k, stage) in median.stages.iter_mut().enumerate() {
            let same = runs.iter().all(|run| run.stages[k].len() == stage.len());
            ensure!(same, "the runs of one step consist of different pieces");
            for (place, piece) in stage.iter_mut().enumerate() {
                let of_runs: Vec<&Piece> = runs.iter().map(|run| &run.stages[k][place]).collect();
                *piece = median_piece(&of_runs)?;
            }
        }
        Ok(median)
    }

    /// All of a stage on one thread.
    pub(crate) fn work(&self, stage: usize) -> f64 {
        self.stages[stage].iter().map(Piece::work).sum()
    }

    /// How many tasks a stage has.
    pub(crate) fn tasks(&self, stage: usize) -> usize {
        let tasks = |piece: &Piece| match piece {
            Piece::Section(tasks) => tasks.len(),
            Piece::Serial(_) | Piece::Sort { .. } => 0,
        };
        self.stages[stage].iter().map(tasks).sum()
    }

    /// The longest task of a stage.
    pub(crate) fn longest(&self, stage: usize) -> f64 {
        let tasks = self.stages[stage].iter().flat_map(|piece| match piece {
            Piece::Section(tasks) => tasks.as_slice(),
            Piece::Serial(_) | Piece::Sort { .. } => &[],
        });
        tasks.copied().fold(0.0, f64::max)
    }

    /// What of a stage only one thread can do.
    pub(crate) fn serial(&self, stage: usize) -> f64 {
        let serial = |piece: &Piece| if let Piece::Serial(time) = piece { *time } else { 0.0 };
        self.stages[stage].iter().map(serial).sum()
    }
}

impl Piece {
    /// All of it on one thread.
    pub(crate) fn work(&self) -> f64 {
        match self {
            Self::Serial(time) | Self::Sort { time, .. } => *time,
            Self::Section(tasks) => tasks.iter().sum(),
        }
    }

    /// Whether the other is the same but for the times.
    fn is_like(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Serial(_), Self::Serial(_)) => true,
            (Self::Section(a), Self::Section(b)) => a.len() == b.len(),
            (Self::Sort { items: a, .. }, Self::Sort { items: b, .. }) => a == b,
            _ => false,
        }
    }
}

/// Where the reading of a step's events stands.
#[derive(Debug)]
enum Place {
    /// Before a stage or after.
    Outside,
    /// In a stage since then, in no section and no sort.
    Between(Instant),
    Sort(usize, Instant),
    /// With the times of the tasks that have ended.
    Section(Vec<f64>),
    Task(Task),
}

/// A task that runs. Sections, sorts and tasks within it belong to it.
#[derive(Debug)]
struct Task {
    number: usize,
    begun: Instant,
    within: usize,
    /// Of the same section, ended.
    others: Vec<f64>,
}

impl Place {
    /// After the event; what it completes is appended to `pieces`.
    fn after(self, event: &Event, pieces: &mut Vec<Piece>) -> Result<Self> {
        let now = event.at;
        Ok(match (self, event.what) {
            (Self::Outside, What::StageBegins(_)) => Self::Between(now),
            (Self::Between(since), what) => {
                pieces.push(Piece::Serial(nanoseconds(since, now)));
                match what {
                    What::SectionBegins => Self::Section(Vec::new()),
                    What::SortBegins(items) => Self::Sort(items, now),
                    What::StageEnds => Self::Outside,
                    other => bail!("{other:?} between sections"),
                }
            }
            (Self::Sort(items, begun), What::SortEnds) => {
                let time = nanoseconds(begun, now);
                let at_once = items <= Exec::SORTED_AT_ONCE;
                pieces.push(if at_once {
                    Piece::Serial(time)
                } else {
                    Piece::Sort { items, time }
                });
                Self::Between(now)
            }
            (Self::Section(others), What::TaskBegins(number)) => {
                Self::Task(Task { number, begun: now, within: 0, others })
            }
            (Self::Section(tasks), What::SectionEnds) => {
                pieces.push(Piece::Section(tasks));
                Self::Between(now)
            }
            (Self::Task(task), what) => task.after(what, now)?,
            (place, what) => bail!("{what:?} in {place:?}"),
        })
    }
}

impl Task {
    fn after(mut self, what: What, now: Instant) -> Result<Place> {
        match what {
            What::TaskEnds if self.within == 0 => {
                let mut tasks = self.others;
                let count = tasks.len().max(self.number + 1);
                tasks.resize(count, 0.0);
                tasks[self.number] = nanoseconds(self.begun, now);
                return Ok(Place::Section(tasks));
            }
            What::TaskBegins(_) | What::SectionBegins | What::SortBegins(_) => self.within += 1,
            What::TaskEnds | What::SectionEnds | What::SortEnds if self.within > 0 => {
                self.within -= 1;
            }
            other => bail!("{other:?} within a task"),
        }
        Ok(Place::Task(self))
    }
}

/// Of the same piece in several runs, task by task.
fn median_piece(runs: &[&Piece]) -> Result<Piece> {
    let of = |time: fn(&Piece) -> f64| median(runs.iter().map(|piece| time(piece)).collect());
    let alike = runs.windows(2).all(|two| two[0].is_like(two[1]));
    ensure!(alike, "the runs of one step consist of different tasks");
    Ok(match runs[0] {
        Piece::Serial(_) => Piece::Serial(of(Piece::work)),
        Piece::Sort { items, .. } => Piece::Sort { items: *items, time: of(Piece::work) },
        Piece::Section(tasks) => {
            let time = |task: usize| {
                median(
                    runs.iter()
                        .map(|piece| match piece {
                            Piece::Section(tasks) => tasks[task],
                            Piece::Serial(time) | Piece::Sort { time, .. } => *time,
                        })
                        .collect(),
                )
            };
            Piece::Section((0..tasks.len()).map(time).collect())
        }
    })
}

/// The upper one of the middle two where the number is even; 0 of none.
pub(crate) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or_default()
}

fn nanoseconds(from: Instant, to: Instant) -> f64 {
    to.duration_since(from).as_secs_f64() * 1e9
}

#[cfg(test)]
mod tests {
    use super::*;
    use dcd_exec::Par;

    fn recorded(par: Par, work: impl FnOnce(Exec)) -> Vec<Event> {
        let recorder = Recorder::default();
        let exec = Exec::observed(par, &recorder);
        exec.stage(Stage::Pairs, || work(exec));
        recorder.take()
    }

    #[test]
    fn a_stage_is_its_sections_and_sorts_and_the_serial_work_between() {
        let mut items: Vec<u32> = (0..2 * Exec::SORTED_AT_ONCE as u32).rev().collect();
        let events = recorded(Par::Serial, |exec| {
            exec.tasks(5, |_| ());
            exec.sort(&mut items);
            exec.divide(&mut items[..20], 8, |_, _| ());
        });
        let program = Program::of(&events).unwrap();
        let [boxes, build, pairs, narrow] = &program.stages;
        assert!(boxes.is_empty() && build.is_empty() && narrow.is_empty());
        let shape: Vec<usize> = pairs
            .iter()
            .map(|piece| match piece {
                Piece::Serial(_) => 0,
                Piece::Section(tasks) => tasks.len(),
                Piece::Sort { items, .. } => *items,
            })
            .collect();
        assert_eq!(shape, [0, 5, 0, 2 * Exec::SORTED_AT_ONCE, 0, 3, 0]);
        assert_eq!(program.tasks(Stage::Pairs as usize), 8);
    }

    #[test]
    fn work_within_a_task_belongs_to_the_task() {
        let events = recorded(Par::Serial, |exec| {
            exec.tasks(2, |_| {
                exec.tasks(3, |_| ());
                exec.sort(&mut [2, 1]);
            });
        });
        let program = Program::of(&events).unwrap();
        assert_eq!(program.tasks(Stage::Pairs as usize), 2);
        assert_eq!(program.stages[Stage::Pairs as usize].len(), 3);
    }

    #[test]
    fn the_time_within_tasks_is_summed_over_all_threads() {
        let pause = std::time::Duration::from_millis(2);
        let events = dcd_exec::with_threads(2, || {
            recorded(Par::Pool, |exec| exec.tasks(4, |_| std::thread::sleep(pause)))
        });
        let times = task_times(&events.unwrap());
        assert!(times[Stage::Pairs as usize] >= 4.0 * 2e6, "{times:?}");
        assert_eq!(times[Stage::Narrow as usize], 0.0);
    }

    #[test]
    fn the_median_is_taken_task_by_task_and_refuses_other_tasks() {
        let run = |a: f64, b: f64| {
            let mut program = Program::default();
            program.stages[0] = vec![Piece::Section(vec![a, b])];
            program
        };
        let median = Program::median(&[run(1.0, 9.0), run(3.0, 7.0), run(2.0, 8.0)]).unwrap();
        assert_eq!(median, run(2.0, 8.0));
        let mut other = run(1.0, 2.0);
        other.stages[0] = vec![Piece::Section(vec![1.0])];
        assert!(Program::median(&[run(1.0, 2.0), other]).is_err());
        assert!(Program::median(&[]).is_err());
    }
}
