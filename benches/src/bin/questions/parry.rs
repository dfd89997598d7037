//! Parry's queries of a scene's candidate pairs and its whole step, its shapes and poses made outside of any timer.

use anyhow::{Context, Result};
use dcd_geom::{Pair, Scene};
use dcd_parry::Library;
use dcd_pipeline::Par;
use parry3d::bounding_volume::BoundingVolume;
use parry3d::query::{self, ContactManifold, PersistentQueryDispatcher};

use crate::contest::Kind;
use crate::kinds::in_parrys_frame;

/// Shapes, poses, and the pairs to query.
pub(crate) struct Parry {
    forms: Vec<<f32 as Library>::Form>,
    objects: Vec<(usize, <f32 as Library>::Pose)>,
    pairs: Vec<Pair>,
    margin: f32,
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
            tree: Default::default(),
            own_pairs: Vec::new(),
        })
    }

    /// Queries every pair that is given and returns how many it finds.
    pub(crate) fn count(&self, kind: Kind) -> usize {
        let mut manifolds = Vec::new();
        self.pairs.iter().filter(|pair| self.finds(kind, [pair.i, pair.j], &mut manifolds)).count()
    }

    /// Parry's own step: boxes, grown by half the margin, the binned tree, the tree against itself, and the query
    /// of each pair. Returns how many it finds.
    pub(crate) fn step(&mut self, kind: Kind) -> usize {
        let boxes = self.objects.iter().map(|(form, pose)| {
            <f32 as Library>::boxed(&self.forms[*form], pose).loosened(self.margin / 2.0)
        });
        <f32 as Library>::rebuild(boxes, &mut self.tree);
        let mut pairs = std::mem::take(&mut self.own_pairs);
        <f32 as Library>::collect_leaf_pairs(&mut self.tree, Par::Serial.into(), &mut pairs);
        let mut manifolds = Vec::new();
        let found =
            pairs.iter().filter(|&&(i, j)| self.finds(kind, [i, j], &mut manifolds)).count();
        self.own_pairs = pairs;
        found
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
