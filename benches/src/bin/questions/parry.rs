//! Parry's queries of a scene's candidate pairs, its shapes and poses made outside of any timer.

use anyhow::{Context, Result, ensure};
use dcd_geom::{Pair, Scene, Shape};
use dcd_parry::Library;
use parry3d::query::{self, ContactManifold, PersistentQueryDispatcher};

use crate::contest::Kind;

/// Shapes, poses, and the pairs that are asked.
pub(crate) struct Parry {
    forms: Vec<<f32 as Library>::Form>,
    objects: Vec<(usize, <f32 as Library>::Pose)>,
    pairs: Vec<Pair>,
    margin: f32,
}

impl Parry {
    /// In f32, its default.
    pub(crate) fn new(scene: &Scene, pairs: &[Pair], margin: f64) -> Result<Self> {
        let curved = scene.shapes().iter().any(|shape| matches!(shape, Shape::Curved(_)));
        ensure!(!curved, "Parry's cylinders and cones stand along another axis");
        let forms = scene
            .shapes()
            .iter()
            .map(|shape| <f32 as Library>::form(shape).context("Parry has no such shape"));
        let shapes = scene.shape_of().iter().map(|&shape| shape as usize);
        let poses = scene.poses().iter().map(<f32 as Library>::pose);
        Ok(Self {
            forms: forms.collect::<Result<_>>()?,
            objects: shapes.zip(poses).collect(),
            pairs: pairs.to_vec(),
            margin: margin as f32,
        })
    }

    /// Asks every pair and returns how many were found.
    pub(crate) fn ask(&self, kind: Kind) -> usize {
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
                    let asked = query::DefaultQueryDispatcher.contact_manifolds(
                        &relative,
                        a,
                        b,
                        0.0,
                        &mut manifolds,
                        &mut None,
                    );
                    asked.is_ok() && manifolds.iter().any(|manifold| !manifold.points.is_empty())
                }
            }
        };
        self.pairs.iter().filter(|pair| found(pair)).count()
    }
}
