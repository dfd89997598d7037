//! Parry through its public queries, right or wrong.

use std::panic::{AssertUnwindSafe, catch_unwind};

use dcd_parry::Library;

use crate::precision::{Query, Said};
use crate::subject::Subject;

/// A shape of Parry's at a pose.
type Placed<'a, R> = (&'a <R as Library>::Form, &'a <R as Library>::Pose);

/// The queries of a build of Parry that give a number.
pub(crate) trait Numbers: Library {
    /// `query::distance`; 0 is how it says that the shapes touch.
    fn distance(a: Placed<'_, Self>, b: Placed<'_, Self>) -> Option<f64>;
    /// The `dist` of `query::contact` without a margin: not above 0 where they touch. The outer
    /// `None`: it does not know the pair.
    fn contact(a: Placed<'_, Self>, b: Placed<'_, Self>) -> Option<Option<f64>>;
    /// The least `dist` of the points of `contact_manifolds`, without a warm start.
    fn manifold(a: Placed<'_, Self>, b: Placed<'_, Self>) -> Option<Option<f64>>;
}

macro_rules! numbers {
    ($real:ty, $parry:ident) => {
        impl Numbers for $real {
            fn distance(a: Placed<'_, Self>, b: Placed<'_, Self>) -> Option<f64> {
                let found = $parry::query::distance(a.1, &**a.0, b.1, &**b.0).ok()?;
                Some(found.distance.into())
            }

            fn contact(a: Placed<'_, Self>, b: Placed<'_, Self>) -> Option<Option<f64>> {
                let found = $parry::query::contact(a.1, &**a.0, b.1, &**b.0, 0.0).ok()?;
                Some(found.map(|contact| contact.dist.into()))
            }

            fn manifold(a: Placed<'_, Self>, b: Placed<'_, Self>) -> Option<Option<f64>> {
                use $parry::query::{
                    ContactManifold, DefaultQueryDispatcher, PersistentQueryDispatcher,
                };
                let mut found: Vec<ContactManifold<(), ()>> = Vec::new();
                let (dispatcher, b_in_a) = (DefaultQueryDispatcher, a.1.inv_mul(b.1));
                dispatcher
                    .contact_manifolds(&b_in_a, &**a.0, &**b.0, 0.0, &mut found, &mut None)
                    .ok()?;
                let points = found.iter().flat_map(|manifold| &manifold.points);
                Some(points.map(|point| f64::from(point.dist)).min_by(f64::total_cmp))
            }
        }
    };
}

numbers!(f32, parry3d);
numbers!(f64, parry3d_f64);

/// A subject's objects as Parry holds them, made outside of any timer.
pub(crate) struct Theirs<'s, R: Library> {
    forms: Vec<Option<R::Form>>,
    poses: Vec<R::Pose>,
    subject: &'s Subject,
}

impl<'s, R: Numbers> Theirs<'s, R> {
    pub(crate) fn new(subject: &'s Subject) -> Self {
        Self {
            forms: quietly(|| subject.shapes.iter().map(R::form).collect()),
            poses: subject.poses.iter().map(R::pose).collect(),
            subject,
        }
    }

    pub(crate) fn run(&self, query: Query, subject: &Subject, pairs: &[u32], said: &mut Vec<Said>) {
        debug_assert!(std::ptr::eq(self.subject, subject));
        quietly(|| {
            said.extend(pairs.iter().map(|&k| {
                let [i, j] = subject.pairs[k as usize].map(|i| i as usize);
                // It asserts its own invariants. Nothing that is read can be left half changed.
                let answer = catch_unwind(AssertUnwindSafe(|| self.one(query, i, j)));
                answer.ok().flatten().unwrap_or(Said::Open)
            }));
        });
    }

    fn one(&self, query: Query, i: usize, j: usize) -> Option<Said> {
        let a = (self.forms[i].as_ref()?, &self.poses[i]);
        let b = (self.forms[j].as_ref()?, &self.poses[j]);
        let [shape_a, shape_b] = [i, j].map(|k| &self.subject.shapes[k]);
        let offset = R::translation(b.1) - R::translation(a.1);
        if !(shape_a.reach() + shape_b.reach() + offset.length() <= R::RANGE) {
            return None;
        }
        match query {
            Query::YesNo => {
                let touching = R::touching(dcd_parry::Query::IntersectionTest, a, b)?;
                Some(if touching { Said::Touching } else { Said::Apart })
            }
            Query::Distance => {
                let distance = R::distance(a, b).filter(|distance| distance.is_finite())?;
                Some(if distance == 0.0 { Said::Touching } else { Said::Measured(distance) })
            }
            Query::Depth => deep(R::contact(a, b)?),
            Query::Manifold => deep(R::manifold(a, b)?),
        }
    }
}

/// A depth is how far `dist` is below 0. `None`: it is no number.
fn deep(dist: Option<f64>) -> Option<Said> {
    match dist {
        None => Some(Said::Apart),
        Some(dist) if !dist.is_finite() => None,
        Some(dist) if dist > 0.0 => Some(Said::Apart),
        Some(dist) => Some(Said::Measured(-dist)),
    }
}

/// Runs what may panic and is caught, without a word on standard error.
fn quietly<T>(work: impl FnOnce() -> T) -> T {
    let hook = std::panic::take_hook();
    std::panic::set_hook(Box::new(|_| {}));
    let result = work();
    std::panic::set_hook(hook);
    result
}
