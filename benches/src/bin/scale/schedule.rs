//! How long a recorded step would take on many workers, and what keeps it from taking less.

use serde::{Deserialize, Serialize};

use crate::record::{Piece, Program, STAGES};

/// What running at once costs, as measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Charges {
    /// For each task, nanoseconds.
    pub(crate) task: f64,
    /// For a worker that sleeps, as all but one do before a step, nanoseconds at two workers: until
    /// it works in a section.
    pub(crate) waking: f64,
    /// The same for one that has worked in the step and been idle since as long as [`IDLE`] says.
    pub(crate) joining: [f64; IDLE.len()],
    /// How many times as long the tasks of each stage take beside others: memory, and whatever
    /// else two threads share.
    pub(crate) slowdown: [f64; STAGES],
}

/// Idle times after which joining a section was measured, nanoseconds. The longest stands for every
/// longer one.
pub(crate) const IDLE: [f64; 8] = [1e3, 3e3, 1e4, 1.5e4, 2e4, 3e4, 1e5, 3e5];

/// Why a step on P workers takes longer than a P-th of the time on one, in nanoseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Losses {
    /// Work that one thread does while the others wait.
    pub(crate) serial: f64,
    /// Workers that wait for the last task of a section, or for the parts of a sort.
    pub(crate) waiting: f64,
    /// Tasks that take longer beside others.
    pub(crate) memory: f64,
    /// Making, waking and joining tasks.
    pub(crate) overhead: f64,
}

/// A step on so many workers, stage by stage, in nanoseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Forecast {
    pub(crate) workers: usize,
    pub(crate) stages: [f64; STAGES],
    pub(crate) losses: [Losses; STAGES],
    /// The same step on one thread.
    pub(crate) alone: f64,
}

/// Smaller parts of a parallel sort are sorted by one worker: rayon's `MAX_SEQUENTIAL`.
const SORTED_BY_ONE: f64 = 2000.0;

/// The schedule of a program on so many workers, at least one: whoever is free takes the next task
/// of the section; a piece begins when the one before has ended.
pub(crate) fn forecast(program: &Program, workers: usize, charges: &Charges) -> Forecast {
    let mut crew = Crew::new(workers.max(1), charges);
    let mut forecast = Forecast { workers: crew.workers(), ..Forecast::default() };
    for stage in 0..STAGES {
        forecast.alone += program.work(stage);
        for piece in &program.stages[stage] {
            let (time, losses) = crew.run(piece, charges.slowdown[stage]);
            forecast.stages[stage] += time;
            forecast.losses[stage] = forecast.losses[stage].plus(losses);
        }
    }
    forecast
}

impl Forecast {
    /// The whole step.
    pub(crate) fn time(&self) -> f64 {
        self.stages.iter().sum()
    }

    /// How many times as fast as alone.
    pub(crate) fn speedup(&self) -> f64 {
        self.alone / self.time()
    }

    /// The speed-up for each worker.
    pub(crate) fn efficiency(&self) -> f64 {
        self.speedup() / self.workers as f64
    }
}

impl Losses {
    /// What each is called.
    pub(crate) const NAMES: [&str; 4] = ["serial work", "waiting", "memory", "overhead"];

    /// In the order of [`Losses::NAMES`].
    pub(crate) fn each(&self) -> [f64; 4] {
        [self.serial, self.waiting, self.memory, self.overhead]
    }

    pub(crate) fn plus(self, other: Self) -> Self {
        Self {
            serial: self.serial + other.serial,
            waiting: self.waiting + other.waiting,
            memory: self.memory + other.memory,
            overhead: self.overhead + other.overhead,
        }
    }
}

impl Charges {
    /// How long a worker that has been idle that long takes to join a section, of two workers; for
    /// ever idle is who sleeps.
    fn join_after(&self, idle: f64) -> f64 {
        if idle == f64::INFINITY {
            return self.waking;
        }
        let above = IDLE.iter().position(|&known| idle < known).unwrap_or(IDLE.len());
        match above.checked_sub(1) {
            None => self.joining[0],
            Some(below) if above == IDLE.len() => self.joining[below],
            Some(below) => {
                let part = (idle - IDLE[below]) / (IDLE[above] - IDLE[below]);
                self.joining[below] + part * (self.joining[above] - self.joining[below])
            }
        }
    }
}

/// Who runs the pieces, and at what price. The first worker is the step's own thread.
struct Crew<'a> {
    charges: &'a Charges,
    now: f64,
    /// When each worker stopped working.
    stopped: Vec<f64>,
}

impl<'a> Crew<'a> {
    /// All but the first asleep.
    fn new(workers: usize, charges: &'a Charges) -> Self {
        Self { charges, now: 0.0, stopped: vec![f64::NEG_INFINITY; workers] }
    }

    fn workers(&self) -> usize {
        self.stopped.len()
    }

    /// The time of a piece, and what of it is beyond a fair share of its work.
    fn run(&mut self, piece: &Piece, slowdown: f64) -> (f64, Losses) {
        let p = self.workers() as f64;
        let work = piece.work();
        let (time, losses) = match piece {
            Piece::Serial(time) => (*time, Losses { serial: time - time / p, ..Losses::default() }),
            Piece::Section(tasks) if self.workers() == 1 || tasks.len() <= 1 => {
                (work, Losses { waiting: work - work / p, ..Losses::default() })
            }
            Piece::Section(tasks) => self.share(tasks, slowdown),
            Piece::Sort { items, time } => {
                let span = time.min(sort_span(*items as f64, *time));
                let joining = self.joining().iter().sum::<f64>() / p;
                // No greedy schedule takes longer (Brent 1974).
                let time = joining + span + (work - span) / p;
                self.stopped.fill(self.now + time);
                let waiting = time - joining - work / p;
                (time, Losses { waiting, overhead: joining, ..Losses::default() })
            }
        };
        self.now += time;
        (time, losses)
    }

    /// How long each worker takes until it works.
    fn joining(&self) -> Vec<f64> {
        // As many wake at once as are awake already.
        let rounds = (self.workers() as f64).log2();
        let delay = |stopped: &f64| self.charges.join_after(self.now - stopped) * rounds;
        let mut joining: Vec<f64> = self.stopped.iter().map(delay).collect();
        joining[0] = 0.0;
        joining
    }

    /// A section of several tasks.
    fn share(&mut self, tasks: &[f64], slowdown: f64) -> (f64, Losses) {
        let p = self.workers() as f64;
        let joining = self.joining();
        let charged = tasks.iter().map(|task| task * slowdown + self.charges.task);
        let ends = schedule(charged.clone(), &joining);
        let time = ends.iter().flatten().copied().fold(0.0, f64::max);
        for (stopped, end) in self.stopped.iter_mut().zip(&ends) {
            *stopped = end.map_or(*stopped, |end| self.now + end);
        }
        let joined = joining.iter().map(|delay| delay.min(time)).sum::<f64>() / p;
        let losses = Losses {
            memory: tasks.iter().sum::<f64>() * (slowdown - 1.0) / p,
            overhead: joined + self.charges.task * tasks.len() as f64 / p,
            waiting: time - joined - charged.sum::<f64>() / p,
            serial: 0.0,
        };
        (time, losses)
    }
}

/// When each worker ends its last task, if it takes one: tasks are taken in order by the worker that
/// is free first, from when it has joined.
fn schedule(tasks: impl Iterator<Item = f64>, joining: &[f64]) -> Vec<Option<f64>> {
    let mut ends = vec![None; joining.len()];
    let free = |ends: &[Option<f64>], k: usize| ends[k].unwrap_or(joining[k]);
    for task in tasks {
        let first = |&a: &usize, &b: &usize| free(&ends, a).total_cmp(&free(&ends, b));
        let next = (0..joining.len()).min_by(first).unwrap_or(0);
        ends[next] = Some(free(&ends, next) + task);
    }
    ends
}

/// The longest chain of a parallel quicksort whose every level takes as long as the others: one
/// worker parts all items, then two a half each, and so on.
fn sort_span(items: f64, time: f64) -> f64 {
    if items <= SORTED_BY_ONE {
        return time;
    }
    let per_item = time / (items * items.log2());
    let parted = 2.0 * (items - SORTED_BY_ONE);
    per_item * (parted + SORTED_BY_ONE * SORTED_BY_ONE.log2())
}

#[cfg(test)]
mod tests {
    use super::*;

    const FREE: Charges =
        Charges { task: 0.0, waking: 0.0, joining: [0.0; IDLE.len()], slowdown: [1.0; STAGES] };

    fn program(pieces: Vec<Piece>) -> Program {
        let mut program = Program::default();
        program.stages[3] = pieces;
        program
    }

    #[test]
    fn equal_tasks_share_evenly_and_serial_work_does_not() {
        let program = program(vec![Piece::Serial(10.0), Piece::Section(vec![5.0; 8])]);
        let times = [1, 2, 4, 8, 16].map(|workers| forecast(&program, workers, &FREE).time());
        assert_eq!(times, [50.0, 30.0, 20.0, 15.0, 15.0]);
        let two = forecast(&program, 2, &FREE);
        assert_eq!(two.losses[3], Losses { serial: 5.0, ..Losses::default() });
        assert_eq!(forecast(&program, 16, &FREE).losses[3].waiting, 2.5);
    }

    #[test]
    fn whoever_is_free_takes_the_next_task() {
        let ends = |tasks: [f64; 5], joining| schedule(tasks.into_iter(), joining);
        assert_eq!(ends([4.0, 1.0, 1.0, 1.0, 1.0], &[0.0; 2]), [Some(4.0); 2]);
        assert_eq!(ends([1.0, 1.0, 1.0, 1.0, 4.0], &[0.0; 2]), [Some(6.0), Some(2.0)]);
        assert_eq!(ends([1.0; 5], &[0.0, 3.5]), [Some(4.0), Some(4.5)]);
        assert_eq!(ends([1.0; 5], &[0.0, 9.0]), [Some(5.0), None]);
    }

    #[test]
    fn who_has_just_stopped_joins_sooner_than_who_dozes_or_sleeps() {
        let joining = [1.0, 1.0, 1.0, 1.0, 11.0, 30.0, 30.0, 30.0];
        let asleep = Charges { waking: 40.0, joining, ..FREE };
        let pieces = |between| {
            let section = Piece::Section(vec![1e5; 2]);
            program(vec![section.clone(), Piece::Serial(between), section])
        };
        // The first section of a step wakes the other worker; two workers are woken in one round.
        let overhead =
            |between| forecast(&pieces(between), 2, &asleep).losses[3].overhead * 2.0 - 40.0;
        let (awake, dozing, sleeping) = (overhead(10.0), overhead(1.75e4), overhead(1e7));
        assert!((awake - 1.0).abs() < 1e-9, "{awake}");
        assert!((dozing - 6.0).abs() < 0.1, "{dozing}");
        assert!((sleeping - 30.0).abs() < 1e-9, "{sleeping}");
    }

    #[test]
    fn what_is_lost_is_the_time_beyond_a_fair_share() {
        let pieces = vec![
            Piece::Serial(100.0),
            Piece::Section((1..40).map(f64::from).collect()),
            Piece::Sort { items: 10_000, time: 500.0 },
            Piece::Section(vec![30.0]),
        ];
        let joining = [3.0; IDLE.len()];
        let charges = Charges { task: 0.5, waking: 9.0, joining, slowdown: [1.2; STAGES] };
        for workers in [1, 2, 3, 28, 64, 128] {
            let forecast = forecast(&program(pieces.clone()), workers, &charges);
            let lost: f64 = forecast.losses.iter().flat_map(Losses::each).sum();
            let fair = forecast.alone / workers as f64;
            assert!((forecast.time() - fair - lost).abs() < 1e-9 * forecast.alone, "{workers}");
            assert!(forecast.losses.iter().flat_map(Losses::each).all(|loss| loss >= -1e-9));
        }
    }

    #[test]
    fn one_worker_takes_the_time_of_one_thread_without_charges() {
        let pieces = vec![Piece::Section(vec![1.0; 9]), Piece::Sort { items: 5000, time: 7.0 }];
        let joining = [9.0; IDLE.len()];
        let charges = Charges { task: 9.0, waking: 9.0, joining, slowdown: [2.0; STAGES] };
        assert_eq!(forecast(&program(pieces), 1, &charges).time(), 16.0);
    }

    #[test]
    fn a_sort_ends_no_sooner_than_its_first_two_partings() {
        let sort = program(vec![Piece::Sort { items: 1 << 20, time: 20.0 }]);
        let time = forecast(&sort, 1_000_000, &FREE).time();
        assert!((2.0..2.2).contains(&time), "{time}");
    }
}
