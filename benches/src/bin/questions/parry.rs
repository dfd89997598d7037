//! Parry's queries of a scene's candidate pairs and its whole step, its shapes and poses made outside of any timer.

use std::sync::atomic::{AtomicUsize, Ordering};

use anyhow::{Context, Result};
use dcd_geom::{Pair, Scene};
use dcd_parry::Library;
use dcd_pipeline::{Exec, Par};
use parry3d::bounding_volume::BoundingVolume;
use parry3d::query::{self, ContactManifold, PersistentQueryDispatcher};

use crate::contest::Kind;
use crate::kinds::in_parrys_frame;

/// Pairs a task: on one thread a task costs nothing that shows.
const TASK: usize = 1024;

/// Shapes, poses, and the pairs to query.
pub(crate) struct Parry {
    forms: Vec<<f32 as Library>::Form>,
    objects: Vec<(usize, <f32 as Library>::Pose)>,
    pairs: Vec<Pair>,
    margin: f32,
    boxes: Vec<<f32 as Library>::Box>,
    tree: <f32 as Library>::Tree,
    own_pairs: Vec<(u32, u32)>,
}

impl Parry {
    /// In f32, its default.
    pub(crate) fn new(scene: &Scene, pairs: &[Pair], margin: f64) -> Result<Self> {
        let forms = scene
            .shapes()
            .iter()
            .map(|shape| <f32 as Library>::form(shape).context("Parry has no such shape"));
        let placed = scene.shape_of().iter().zip(scene.poses()).map(|(&index, pose)| {
            let index = index as usize;
            let pose = in_parrys_frame(&scene.shapes()[index], pose)?;
            Ok((index, <f32 as Library>::pose(&pose)))
        });
        Ok(Self {
            forms: forms.collect::<Result<_>>()?,
            objects: placed.collect::<Result<_>>()?,
            pairs: pairs.to_vec(),
            margin: margin as f32,
            boxes: vec![<f32 as Library>::NO_BOX; scene.len()],
            tree: Default::default(),
            own_pairs: Vec::new(),
        })
    }

    /// Queries every pair that is given and returns how many it finds.
    pub(crate) fn count(&self, kind: Kind, par: Par) -> usize {
        self.found_of(kind, par, self.pairs.len(), |k| [self.pairs[k].i, self.pairs[k].j])
    }

    /// Parry's own step: boxes, grown by half the margin, the binned tree, the tree against itself, and the query
    /// of each pair. Returns how many it finds.
    pub(crate) fn step(&mut self, kind: Kind, par: Par) -> usize {
        let Self { forms, objects, boxes, margin, .. } = &mut *self;
        let grown = *margin / 2.0;
        Exec::from(par).divide((&objects[..], &mut boxes[..]), TASK, |_, (objects, boxes)| {
            for ((form, pose), slot) in objects.iter().zip(boxes) {
                *slot = <f32 as Library>::boxed(&forms[*form], pose).loosened(grown);
            }
        });
        <f32 as Library>::rebuild(self.boxes.iter().copied(), &mut self.tree);
        let mut pairs = std::mem::take(&mut self.own_pairs);
        <f32 as Library>::collect_leaf_pairs(&mut self.tree, par.into(), &mut pairs);
        let found = self.found_of(kind, par, pairs.len(), |k| [pairs[k].0, pairs[k].1]);
        self.own_pairs = pairs;
        found
    }

    /// How many of so many pairs it finds.
    fn found_of(
        &self,
        kind: Kind,
        par: Par,
        count: usize,
        pair: impl Fn(usize) -> [u32; 2] + Sync,
    ) -> usize {
        let found = AtomicUsize::new(0);
        Exec::from(par).tasks(count.div_ceil(TASK), |task| {
            let mut manifolds = Vec::new();
            let own = task * TASK..count.min((task + 1) * TASK);
            let of_task = own.filter(|&k| self.finds(kind, pair(k), &mut manifolds)).count();
            found.fetch_add(of_task, Ordering::Relaxed);
        });
        found.into_inner()
    }

    /// Whether a pair touches, or is within the margin, as the query has it.
    #[inline]
    fn finds(&self, kind: Kind, pair: [u32; 2], manifolds: &mut Manifolds) -> bool {
        let [(a, at_a), (b, at_b)] = pair.map(|k| self.objects[k as usize]);
        let (a, b) = (&*self.forms[a], &*self.forms[b]);
        match kind {
            Kind::Distance => {
                let found = query::closest_points(&at_a, a, &at_b, b, self.margin);
                !matches!(found, Ok(query::ClosestPoints::Disjoint) | Err(_))
            }
            Kind::Depth => matches!(query::contact(&at_a, a, &at_b, b, 0.0), Ok(Some(_))),
            Kind::Overlap => {
                query::intersection_test(&at_a, a, &at_b, b).is_ok_and(|found| found.intersecting)
            }
            Kind::Manifold => {
                // Without a warm start: none is kept from pair to pair.
                manifolds.clear();
                let relative = at_a.inv_mul(&at_b);
                let result = query::DefaultQueryDispatcher
                    .contact_manifolds(&relative, a, b, 0.0, manifolds, &mut None);
                result.is_ok() && manifolds.iter().any(|manifold| !manifold.points.is_empty())
            }
        }
    }
}

type Manifolds = Vec<ContactManifold<(), ()>>;
