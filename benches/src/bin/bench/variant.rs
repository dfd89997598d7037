//! The six variants that the paper measures from end to end, and our default pipeline.

use anyhow::Result;
use dcd_benches::{Agreement, Sample, timing};
use dcd_broad::{BroadPhase, TreePairs};
use dcd_bvh::PaperTree;
use dcd_exec::{Exec, Par};
use dcd_gjk::{Gjk, NarrowPhase, Pairwise};
use dcd_pipeline::Pipeline;
use serde::{Deserialize, Serialize};

use crate::case::{Case, Setting};
use crate::every_pair::EveryPair;

/// Our narrow phase where the paper's is meant: GJK in f64, one pair at a time.
pub(crate) type OurGjk = Pairwise<Gjk<f64>>;

/// A way from a scene to its contacts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Variant {
    pub(crate) name: &'static str,
    way: Way,
    par: Par,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Way {
    /// Our GJK in f64 on every pair.
    OurNarrow,
    /// Parry's shapes in f64 on every pair.
    ParryNarrow,
    /// The paper's pipeline as its code has it.
    DoublePhase,
    /// The default pipeline.
    Ours,
}

/// How long a variant took, and what it found.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Timed {
    pub(crate) sample: Sample,
    pub(crate) candidates: u64,
    pub(crate) agreement: Agreement,
}

impl Variant {
    /// In the paper's order, the default pipeline last.
    pub(crate) const ALL: [Self; 7] = [
        Self::new("our narrow phase, serial", Way::OurNarrow, Par::Serial),
        Self::new("Parry's narrow phase, serial", Way::ParryNarrow, Par::Serial),
        Self::new("our narrow phase, parallel", Way::OurNarrow, Par::WarmPool),
        Self::new("Parry's narrow phase, parallel", Way::ParryNarrow, Par::WarmPool),
        Self::new("double phase, serial", Way::DoublePhase, Par::Serial),
        Self::new("double phase, parallel", Way::DoublePhase, Par::WarmPool),
        Self::new("our default, parallel", Way::Ours, Par::WarmPool),
    ];

    const fn new(name: &'static str, way: Way, par: Par) -> Self {
        Self { name, way, par }
    }

    /// The name of the unit that measures it.
    pub(crate) fn key(&self, objects: usize) -> String {
        format!("runtime/N={objects}/{}", self.name)
    }

    /// Whether what it finds is ours to answer for.
    pub(crate) fn is_ours(&self) -> bool {
        self.way != Way::ParryNarrow
    }

    /// Where the paper prints its runtime: the sum of table 1's column.
    pub(crate) fn published(&self) -> Option<f64> {
        let [serial, parallel] = crate::published::double_phase();
        match (self.way, self.par) {
            (Way::DoublePhase, Par::Serial) => Some(serial),
            (Way::DoublePhase, Par::WarmPool) => Some(parallel),
            _ => None,
        }
    }

    /// Checks what it finds and times it.
    pub(crate) fn measure(&self, setting: &Setting, case: &Case) -> Result<Timed> {
        let job = Job { setting, case, exec: self.par.into() };
        Ok(match self.way {
            Way::OurNarrow => job.every_pair(&OurGjk::default()),
            Way::ParryNarrow => job.every_pair(case.parry()),
            Way::DoublePhase => {
                job.pipeline(Pipeline::with(TreePairs::paper_as_coded(), OurGjk::default()))
            }
            Way::Ours => job.pipeline(Pipeline::new()),
        })
    }
}

/// The paper's pipeline over one of its trees, walked as the paper walks it unless said otherwise.
pub(crate) fn double_phase(broad: TreePairs<PaperTree>) -> Pipeline<TreePairs<PaperTree>, OurGjk> {
    Pipeline::with(broad, OurGjk::default())
}

/// What is measured, and how.
#[derive(Clone, Copy)]
pub(crate) struct Job<'a> {
    pub(crate) setting: &'a Setting,
    pub(crate) case: &'a Case,
    pub(crate) exec: Exec<'a>,
}

impl Job<'_> {
    /// A narrow phase over all pairs; what the last run found is checked.
    pub(crate) fn every_pair<N: NarrowPhase<Answer = ()>>(self, narrow: &N) -> Timed {
        let mut every_pair = EveryPair::new(narrow);
        let run = || every_pair.run(&self.case.scene, self.exec);
        let sample = timing::measure(self.setting.effort, run);
        let agreement = every_pair.agreement(self.case);
        Timed { sample, candidates: self.case.pairs(), agreement }
    }

    /// A whole pipeline; what its first step finds is checked.
    pub(crate) fn pipeline<B, N>(self, mut pipeline: Pipeline<B, N>) -> Timed
    where
        B: BroadPhase,
        N: NarrowPhase<Answer = ()>,
    {
        let mut found = None;
        let [sample] = timing::measure_stages(self.setting.effort, || {
            let (time, step) = timing::time(|| pipeline.step(&self.case.scene, self.exec));
            found.get_or_insert_with(|| {
                let agreement = self.case.agreement_of(step.contacts(), step.report());
                (step.candidate_count() as u64, agreement)
            });
            [time]
        });
        let (candidates, agreement) = found.unwrap_or_default();
        Timed { sample, candidates, agreement }
    }
}
