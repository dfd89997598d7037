//! Parry's queries of a scene's candidate pairs, its shapes and poses made outside of any timer.

use anyhow::{Context, Result};
use dcd_geom::{Pair, Scene};
use dcd_parry::Library;
use parry3d::query::{self, ContactManifold, PersistentQueryDispatcher};

use crate::contest::Kind;
use crate::kinds::in_parrys_frame;

/// Shapes, poses, and the pairs to query.
pub(crate) struct Parry {
    forms: Vec<<f32 as Library>::Form>,
    objects: Vec<(usize, <f32 as Library>::Pose)>,
    pairs: Vec<Pair>,
    margin: f32,
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
        })
    }

    /// Queries every pair and returns how many it finds.
    pub(crate) fn count(&self, kind: Kind) -> usize {
        let mut manifolds: Vec<ContactManifold<(), ()>> = Vec::new();
        let mut found = |pair: &&Pair| {
            let [(a, at_a), (b, at_b)] = [pair.i, pair.j].map(|k| self.objects[k as usize]);
            let (a, b) = (&*self.forms[a], &*self.forms[b]);
            match kind {
                Kind::Distance => {
                    let found = query::closest_points(&at_a, a, &at_b, b, self.margin);
                    !matches!(found, Ok(query::ClosestPoints::Disjoint) | Err(_))
                }
                Kind::Depth => {
                    matches!(query::contact(&at_a, a, &at_b, b, 0.0), Ok(Some(_)))
                }
                Kind::Manifold => {
                    // Without a warm start: none is kept from pair to pair.
                    manifolds.clear();
                    let relative = at_a.inv_mul(&at_b);
                    let result = query::DefaultQueryDispatcher.contact_manifolds(
                        &relative,
                        a,
                        b,
                        0.0,
                        &mut manifolds,
                        &mut None,
                    );
                    result.is_ok() && manifolds.iter().any(|manifold| !manifold.points.is_empty())
                }
            }
        };
        self.pairs.iter().filter(|pair| found(pair)).count()
    }
}
