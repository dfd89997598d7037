//! Parry's own shapes as a narrow phase.

use crate::forms::{Forms, Placed, Placement, decide};
use crate::{Library, Query};
use dcd_geom::{Aabb, Pair, Scene};
use dcd_gjk::{ContactSink, Method, NarrowPhase, Prepared, Reason, Sides, Verdict};
use std::sync::Arc;

/// Parry's own shapes, queried through its public API.
///
/// Each kind is Parry's own: sphere, cuboid, capsule, segment, triangle, cylinder, cone, half-space, a hull
/// its convex polyhedron, rounded ones its round shapes. Shapes that it has no counterpart for, or whose
/// points its hull refuses, leave their pairs undecided ([`dcd_gjk::Reason::Foreign`]). Its hull loses
/// points that it takes for coplanar; the answer is then for its shape, not for ours.
///
/// The shapes are made once and kept in the frame for as long as the scene keeps its shapes:
/// by the first step, or beforehand by [`ParryShapes::new`], so that no step pays for them.
pub struct ParryShapes<R: Library> {
    query: Query,
    made: Option<Arc<Forms<R>>>,
}

impl<R: Library> Default for ParryShapes<R> {
    fn default() -> Self {
        Self { query: Query::default(), made: None }
    }
}

impl<R: Library> ParryShapes<R> {
    /// Makes the shapes of this scene now. Any other scene can be stepped too; its shapes are
    /// made by its first step.
    pub fn new(scene: &Scene) -> Self {
        Self { query: Query::default(), made: Some(Arc::new(Forms::of(scene))) }
    }

    /// Uses this query instead.
    pub fn with_query(self, query: Query) -> Self {
        Self { query, ..self }
    }

    /// The shapes, by index, that Parry refused when [`ParryShapes::new`] made them.
    pub fn refused(&self) -> impl Iterator<Item = u32> {
        self.made.iter().flat_map(|forms| forms.refused())
    }
}

/// Parry's shapes for a scene's, and where its objects are.
pub struct ShapesFrame<R: Library> {
    forms: Option<Arc<Forms<R>>>,
    placements: Vec<Placement<R>>,
}

impl<R: Library> Default for ShapesFrame<R> {
    fn default() -> Self {
        Self { forms: None, placements: Vec::new() }
    }
}

impl<R: Library> ShapesFrame<R> {
    fn side(&self) -> Option<Placed<'_, R>> {
        Some(Placed { forms: self.forms.as_deref()?, placements: &self.placements })
    }
}

/// Buffers for the placements of a range of objects.
pub struct ShapesPart<'f, R: Library> {
    placements: &'f mut [Placement<R>],
    /// Whether the shapes are those of the step before.
    kept: bool,
}

impl<R: Library> dcd_geom::Splittable for ShapesPart<'_, R> {
    fn len(&self) -> usize {
        self.placements.len()
    }
    fn split_at(self, middle: usize) -> (Self, Self) {
        let (left, right) = self.placements.split_at_mut(middle);
        let part = |placements| Self { placements, kept: self.kept };
        (part(left), part(right))
    }
}

impl<R: Library> NarrowPhase for ParryShapes<R> {
    type Answer = ();
    type Frame = ShapesFrame<R>;
    type Part<'f> = ShapesPart<'f, R>;
    type Scratch = ();

    fn aabb_margin(&self) -> Option<f64> {
        Some(0.0)
    }

    fn layout<'f>(
        &self,
        scene: &Scene,
        _: Sides,
        frame: &'f mut ShapesFrame<R>,
    ) -> ShapesPart<'f, R> {
        let kept = frame.forms.as_ref().is_some_and(|forms| forms.fit(scene));
        if !kept {
            let made = self.made.as_ref().filter(|forms| forms.fit(scene)).cloned();
            frame.forms = Some(made.unwrap_or_else(|| Arc::new(Forms::of(scene))));
        }
        frame.placements.resize_with(scene.len(), Placement::default);
        ShapesPart { placements: &mut frame.placements, kept }
    }

    fn keeps(&self, part: &ShapesPart<'_, R>) -> bool {
        part.kept
    }

    fn prepare(&self, scene: &Scene, first: usize, part: ShapesPart<'_, R>, aabbs: &mut [Aabb]) {
        for (i, (placement, aabb)) in (first..).zip(part.placements.iter_mut().zip(aabbs)) {
            *placement = Placement::of(scene, i);
            *aabb = scene.aabb(i);
        }
    }

    fn decide(
        &self,
        a: Prepared<'_, ShapesFrame<R>>,
        b: Prepared<'_, ShapesFrame<R>>,
        pairs: &[Pair],
        (): &mut (),
        sink: &mut ContactSink<'_, ()>,
    ) {
        let pairs = pairs.iter().copied();
        match (a.frame.side(), b.frame.side()) {
            (Some(a), Some(b)) => decide(self.query, (a, b), pairs, sink),
            // Nothing was laid out.
            _ => pairs.for_each(|pair| {
                sink.file(pair, Method::Foreign, Verdict::Undecided(Reason::Foreign));
            }),
        }
    }
}
