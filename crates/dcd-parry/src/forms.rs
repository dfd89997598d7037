//! Parry's shapes for the shapes of a scene, and where the objects are.

use crate::{Library, Query};
use dcd_geom::glam::{DMat3, DVec3};
use dcd_geom::{Pair, Pose, Revision, Scene, Shape};
use dcd_gjk::{ContactSink, Method, Reason, Verdict};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Parry's shapes, made once for the shapes of a scene.
pub(crate) struct Forms<R: Library> {
    /// The revision of the shapes that they were made for.
    source: Revision,
    forms: Vec<Form<R>>,
}

struct Form<R: Library> {
    /// `None` where Parry refused.
    form: Option<R::Form>,
    reach: f64,
}

/// Where an object is, in Parry's terms.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placement<R: Library> {
    shape: u32,
    /// Whether it reaches so far from the origin that its pairs may be out of Parry's range.
    far: bool,
    pose: R::Pose,
}

impl<R: Library> Default for Placement<R> {
    fn default() -> Self {
        Self { shape: 0, far: false, pose: R::Pose::default() }
    }
}

impl<R: Library> Placement<R> {
    /// Object `i` of the scene.
    pub(crate) fn of(scene: &Scene, i: usize) -> Self {
        Self::at(scene.shape_of()[i], scene.shape(i), &scene.poses()[i])
    }

    /// A shape, by index and itself, at a pose.
    pub(crate) fn at(index: u32, shape: &Shape, pose: &Pose) -> Self {
        let pose = &in_parrys_frame(shape, pose);
        let farthest = pose.translation().length() + reach(shape);
        // Two objects that are not far are within the range. Written so that NaN is far.
        let far = !(farthest <= R::RANGE / 4.0);
        Self { shape: index, far, pose: R::pose(pose) }
    }
}

/// How far a shape reaches from the origin of its frame at Parry. Of a half-space nothing counts:
/// its queries are one product with the normal.
fn reach(shape: &Shape) -> f64 {
    if shape.is_bounded() { shape.reach() } else { 0.0 }
}

/// Where Parry's own shape is. Its cylinders and cones are round the y axis, ours round z; its
/// half-spaces end at the origin of their frame.
pub(crate) fn in_parrys_frame(shape: &Shape, pose: &Pose) -> Pose {
    let DMat3 { x_axis: x, y_axis: y, z_axis: z } = *pose.rotation();
    let moved = match shape {
        Shape::Curved(_) => Pose::from_matrix(DMat3::from_cols(x, z, -y), pose.translation()),
        Shape::HalfSpace(half_space) => {
            let end =
                half_space.unit_normal() * (half_space.unit_offset() + half_space.swept_radius());
            Pose::from_matrix(*pose.rotation(), pose.apply(end))
        }
        _ => return *pose,
    };
    // A turned rotation is one; a plane too far away for f64 stays where its frame is.
    moved.unwrap_or(*pose)
}

impl<R: Library> Forms<R> {
    /// Parry's forms of the scene's shapes: hulls are what costs.
    pub(crate) fn of(scene: &Scene) -> Self {
        let made = |shape: &Shape| Form { form: R::form(shape), reach: reach(shape) };
        let forms = scene.shapes().iter().map(made).collect();
        Self { forms, source: scene.shape_revision() }
    }

    /// Whether they were made for the shapes of this scene.
    pub(crate) fn fit(&self, scene: &Scene) -> bool {
        self.source == scene.shape_revision()
    }

    /// What the query says of two objects with these shapes.
    #[inline]
    pub(crate) fn verdict(&self, query: Query, a: &Placement<R>, b: &Placement<R>) -> Verdict<()> {
        touching(query, (self.form_of(a), a), (self.form_of(b), b))
    }

    fn form_of(&self, placement: &Placement<R>) -> &Form<R> {
        &self.forms[placement.shape as usize]
    }

    /// The shape's index for each that Parry refused.
    pub(crate) fn refused(&self) -> impl Iterator<Item = u32> {
        (0..).zip(&self.forms).filter(|(_, form)| form.form.is_none()).map(|(index, _)| index)
    }

    /// Whether Parry has a shape for this object.
    pub(crate) fn accept(&self, placement: &Placement<R>) -> bool {
        self.forms[placement.shape as usize].form.is_some()
    }

    /// Parry's AABB; an AABB of nothing for a refused shape.
    #[inline]
    pub(crate) fn boxed(&self, placement: &Placement<R>) -> R::Box {
        let form = self.forms[placement.shape as usize].form.as_ref();
        form.map_or(R::NO_BOX, |form| R::boxed(form, &placement.pose))
    }
}

/// Objects of a scene: Parry's shapes and where they are.
pub(crate) struct Placed<'a, R: Library> {
    pub(crate) forms: &'a Forms<R>,
    pub(crate) placements: &'a [Placement<R>],
}

impl<'a, R: Library> Placed<'a, R> {
    fn object(&self, object: u32) -> (&'a Form<R>, &'a Placement<R>) {
        let placement = &self.placements[object as usize];
        (self.forms.form_of(placement), placement)
    }
}

/// What the query says of two objects.
#[inline]
fn touching<R: Library>(
    query: Query,
    (form_a, a): (&Form<R>, &Placement<R>),
    (form_b, b): (&Form<R>, &Placement<R>),
) -> Verdict<()> {
    let (Some(shape_a), Some(shape_b)) = (&form_a.form, &form_b.form) else {
        return Verdict::Undecided(Reason::Foreign);
    };
    if a.far || b.far {
        let offset = R::translation(&b.pose) - R::translation(&a.pose);
        if !within_range::<R>([form_a.reach, form_b.reach], offset) {
            return Verdict::Undecided(Reason::Range);
        }
    }
    verdict(R::touching(query, (shape_a, &a.pose), (shape_b, &b.pose)), Reason::Foreign)
}

/// Files every pair of an object of the first side with one of the second. A pair on which Parry panics is
/// undecided: the run over the pairs is caught there and goes on behind it, so that the others do not
/// pay.
pub(crate) fn decide<R: Library>(
    query: Query,
    (first, second): (Placed<'_, R>, Placed<'_, R>),
    pairs: impl Iterator<Item = Pair>,
    sink: &mut ContactSink<'_, ()>,
) {
    let mut rest = pairs;
    let mut pair_in_query = None;
    loop {
        let run = catch_unwind(AssertUnwindSafe(|| {
            for pair in rest.by_ref() {
                pair_in_query = Some(pair);
                let verdict = touching(query, first.object(pair.i), second.object(pair.j));
                sink.file(pair, Method::Foreign, verdict);
            }
        }));
        match (run, pair_in_query) {
            (Err(_), Some(pair)) => {
                sink.file(pair, Method::Foreign, Verdict::Undecided(Reason::Foreign));
            }
            _ => return,
        }
    }
}

/// Whether Parry's formulas stay finite for two shapes of these reaches, so far apart.
pub(crate) fn within_range<R: Library>(reaches: [f64; 2], offset: DVec3) -> bool {
    reaches[0] + reaches[1] + offset.length() <= R::RANGE
}

/// Parry's word as a verdict; its silence is `reason`.
pub(crate) fn verdict(touching: Option<bool>, reason: Reason) -> Verdict<()> {
    match touching {
        Some(true) => Verdict::Touching(()),
        Some(false) => Verdict::Apart,
        None => Verdict::Undecided(reason),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dcd_gjk::Report;

    #[test]
    fn a_panic_leaves_its_pair_undecided_and_the_others_decided() {
        let sphere = Shape::sphere(1.0).unwrap();
        let poses = [0.0, 1.0, 1.5].map(|x| Pose::from_translation(DVec3::X * x).unwrap());
        let scene = Scene::one_each(vec![sphere; 3], poses.to_vec()).unwrap();
        let forms = Forms::<f32>::of(&scene);
        let placements: Vec<_> = (0..3).map(|i| Placement::of(&scene, i)).collect();
        // There is no object 7, so that its query panics.
        let pairs = [(0, 1), (0, 7), (1, 7), (1, 2), (2, 7)].map(|(i, j)| Pair { i, j });
        let (mut contacts, mut report) = (Vec::new(), Report::default());
        let sink = &mut ContactSink { contacts: &mut contacts, report: &mut report };
        let side = || Placed { forms: &forms, placements: &placements };
        decide(Query::Distance, (side(), side()), pairs.iter().copied(), sink);
        let touching: Vec<_> = contacts.iter().map(|contact| contact.pair).collect();
        assert_eq!(touching, [pairs[0], pairs[3]]);
        let undecided: Vec<_> = report.undecided().iter().map(|undecided| undecided.pair).collect();
        assert_eq!(undecided, [pairs[1], pairs[2], pairs[4]]);
    }
}
