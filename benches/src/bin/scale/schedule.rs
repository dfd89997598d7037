//! How long a recorded step would take on many workers, and what keeps it from taking less.

use serde::{Deserialize, Serialize};

use crate::record::{Piece, Program, STAGES};

/// What running at once costs, as measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Charges {
    /// For each task, nanoseconds.
    pub(crate) task: f64,
    /// For each section, nanoseconds at two workers: waking the others and waiting for the last.
    pub(crate) section: f64,
    /// How many times as long the tasks of each stage take beside others: memory, and whatever
    /// else two threads share.
    pub(crate) slowdown: [f64; STAGES],
}

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
    let workers = workers.max(1);
    let mut forecast = Forecast { workers, ..Forecast::default() };
    for stage in 0..STAGES {
        forecast.alone += program.work(stage);
        for piece in &program.stages[stage] {
            let crew = Crew { workers, charges, slowdown: charges.slowdown[stage] };
            let (time, losses) = crew.run(piece);
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

/// Who runs a piece, and at what price.
struct Crew<'a> {
    workers: usize,
    charges: &'a Charges,
    slowdown: f64,
}

impl Crew<'_> {
    /// The time of a piece, and what of it is beyond a fair share of its work.
    fn run(&self, piece: &Piece) -> (f64, Losses) {
        let p = self.workers as f64;
        let work = piece.work();
        match piece {
            Piece::Serial(time) => (*time, Losses { serial: time - time / p, ..Losses::default() }),
            Piece::Section(tasks) if self.workers == 1 || tasks.len() <= 1 => {
                (work, Losses { waiting: work - work / p, ..Losses::default() })
            }
            Piece::Section(tasks) => {
                let charged = tasks.iter().map(|task| task * self.slowdown + self.charges.task);
                // As many wake at once as are awake already.
                let joined = self.charges.section * p.log2();
                let busy = makespan(charged.clone(), self.workers);
                let losses = Losses {
                    memory: work * (self.slowdown - 1.0) / p,
                    overhead: joined + self.charges.task * tasks.len() as f64 / p,
                    waiting: busy - charged.sum::<f64>() / p,
                    serial: 0.0,
                };
                (busy + joined, losses)
            }
            Piece::Sort { items, time } => {
                let span = time.min(sort_span(*items as f64, *time));
                // No greedy schedule takes longer (Brent 1974).
                let time = span + (work - span) / p;
                (time, Losses { waiting: time - work / p, ..Losses::default() })
            }
        }
    }
}

/// When the last of the tasks ends, each taken in turn by the worker that is free first.
fn makespan(tasks: impl Iterator<Item = f64>, workers: usize) -> f64 {
    let mut free = vec![0.0_f64; workers];
    for task in tasks {
        let next = (0..workers).min_by(|&a, &b| free[a].total_cmp(&free[b])).unwrap_or(0);
        free[next] += task;
    }
    free.into_iter().fold(0.0, f64::max)
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

    const FREE: Charges = Charges { task: 0.0, section: 0.0, slowdown: [1.0; STAGES] };

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
        assert_eq!(makespan([4.0, 1.0, 1.0, 1.0, 1.0].into_iter(), 2), 4.0);
        assert_eq!(makespan([1.0, 1.0, 1.0, 1.0, 4.0].into_iter(), 2), 6.0);
    }

    #[test]
    fn what_is_lost_is_the_time_beyond_a_fair_share() {
        let pieces = vec![
            Piece::Serial(100.0),
            Piece::Section((1..40).map(f64::from).collect()),
            Piece::Sort { items: 10_000, time: 500.0 },
            Piece::Section(vec![30.0]),
        ];
        let charges = Charges { task: 0.5, section: 3.0, slowdown: [1.2; STAGES] };
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
        let charges = Charges { task: 9.0, section: 9.0, slowdown: [2.0; STAGES] };
        assert_eq!(forecast(&program(pieces), 1, &charges).time(), 16.0);
    }

    #[test]
    fn a_sort_ends_no_sooner_than_its_first_two_partings() {
        let sort = program(vec![Piece::Sort { items: 1 << 20, time: 20.0 }]);
        let time = forecast(&sort, 1_000_000, &FREE).time();
        assert!((2.0..2.2).contains(&time), "{time}");
    }
}
