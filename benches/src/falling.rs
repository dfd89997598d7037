//! A pile of hulls that falls by its own contacts.

use anyhow::Result;
use dcd_geom::Scene;
use dcd_gjk::{Accuracy, Depths, SimdDepths};
use dcd_pipeline::{Par, Pipeline, WideTree};
use dcd_scenes::{Pile, PileContact};

/// A [`Pile`] and what finds its contacts.
pub struct FallingPile {
    pile: Pile,
    pipeline: Pipeline<WideTree, SimdDepths>,
}

impl FallingPile {
    /// So many hulls, after so many frames of falling.
    ///
    /// # Errors
    /// More hulls than a u32 counts with the slab, or one that leaves the range of a scene.
    pub fn after(frames: usize, hulls: usize, seed: u64) -> Result<Self> {
        let depths = SimdDepths::new(Depths, Accuracy::F32);
        let pipeline = Pipeline::with(WideTree::default(), depths);
        let mut falling = Self { pile: Pile::new(hulls, seed)?, pipeline };
        (0..frames).try_for_each(|_| falling.advance())?;
        Ok(falling)
    }

    /// The scene as it stands.
    pub fn scene(&self) -> &Scene {
        self.pile.scene()
    }

    /// Moves on by a frame.
    ///
    /// # Errors
    /// A hull leaves the range of a scene.
    pub fn advance(&mut self) -> Result<()> {
        let step = self.pipeline.step(self.pile.scene(), Par::Pool);
        let contacts = step.answers().map(|contact| PileContact {
            pair: contact.pair,
            normal: contact.answer.normal,
            depth: contact.answer.depth,
            point: (contact.answer.point_a + contact.answer.point_b) / 2.0,
        });
        let contacts: Vec<_> = contacts.collect();
        Ok(self.pile.advance(&contacts)?)
    }
}
