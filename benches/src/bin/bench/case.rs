//! The scenes that are measured, and the contact set that every other is compared with.

use std::sync::OnceLock;

use anyhow::Result;
use dcd_benches::{Agreement, Effort, Options};
use dcd_exec::Par;
use dcd_geom::{Pair, Scene};
use dcd_gjk::{Report, Undecided};
use dcd_parry::{ParryShapes, Query};
use dcd_pipeline::Pipeline;
use dcd_scenes::SceneSpec;

use crate::published;

/// What a run measures by.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Setting {
    pub(crate) effort: Effort,
    pub(crate) seed: u64,
    /// The numbers of objects of the figures, ascending.
    pub(crate) sizes: &'static [usize],
}

/// A quick run ends here among the sizes.
const QUICK_LARGEST: usize = 1_000;

impl Setting {
    pub(crate) fn of(options: &Options) -> Self {
        let all = &published::SIZES[..];
        let quick = all.partition_point(|&size| size <= QUICK_LARGEST);
        let sizes = if options.quick { &all[..quick] } else { all };
        Self { effort: options.effort(), seed: options.seed, sizes }
    }

    /// The number of objects of the tables.
    pub(crate) fn largest(&self) -> usize {
        self.sizes.last().copied().unwrap_or(0)
    }
}

/// A scene and its contacts.
pub(crate) struct Case {
    pub(crate) scene: Scene,
    /// What the default pipeline finds, ascending. Brute force is one of those compared with it.
    contacts: Vec<Pair>,
    parry: OnceLock<ParryShapes<f64>>,
}

impl Case {
    pub(crate) fn new(scene: Scene) -> Self {
        let mut pipeline = Pipeline::new();
        let mut contacts: Vec<Pair> =
            pairs(pipeline.step(&scene, Par::WarmPool).contacts()).collect();
        contacts.sort_unstable();
        Self { scene, contacts, parry: OnceLock::new() }
    }

    /// Parry's shapes in f64, judged by `distance` as the paper judged them; made once, since
    /// whoever uses Parry holds them as Parry's own.
    pub(crate) fn parry(&self) -> &ParryShapes<f64> {
        let made = || ParryShapes::new(&self.scene).with_query(Query::Distance);
        self.parry.get_or_init(made)
    }

    /// How these contacts stand to the scene's.
    pub(crate) fn agreement(
        &self,
        contacts: impl IntoIterator<Item = Pair>,
        undecided: &[Undecided],
    ) -> Agreement {
        Agreement::of(&self.scene, contacts.into_iter().collect(), undecided, &self.contacts)
    }

    /// The same for what a pipeline found.
    pub(crate) fn agreement_of(
        &self,
        contacts: impl Iterator<Item = (u32, u32)>,
        report: &Report,
    ) -> Agreement {
        self.agreement(pairs(contacts), report.undecided())
    }

    /// How many pairs of objects there are.
    pub(crate) fn pairs(&self) -> u64 {
        pairs_of(self.scene.len())
    }
}

/// The paper's scenes of one seed, made on demand; the last one is kept.
pub(crate) struct Cases {
    seed: u64,
    last: Option<Case>,
}

impl Cases {
    pub(crate) fn of(setting: &Setting) -> Self {
        Self { seed: setting.seed, last: None }
    }

    /// The paper's scene of so many objects.
    pub(crate) fn get(&mut self, objects: usize) -> Result<&Case> {
        let case = match self.last.take().filter(|case| case.scene.len() == objects) {
            Some(case) => case,
            None => Case::new(dcd_benches::draw(&spec(self.seed, objects))?),
        };
        Ok(self.last.insert(case))
    }
}

/// The paper's scene.
pub(crate) fn spec(seed: u64, objects: usize) -> SceneSpec {
    SceneSpec::paper().with_seed(seed).with_objects(objects)
}

/// How many pairs so many objects make.
pub(crate) fn pairs_of(objects: usize) -> u64 {
    let objects = objects as u64;
    objects * objects.saturating_sub(1) / 2
}

fn pairs(contacts: impl Iterator<Item = (u32, u32)>) -> impl Iterator<Item = Pair> {
    contacts.map(|(i, j)| Pair { i, j })
}
