//! Parry's answer for a pair, through its public queries, unchanged.

use super::answer::{Answer, Way};
use super::{Query, Side};
use dcd_geom::glam::DVec3;
use dcd_gjk::{Reason, Verdict};
use dcd_parry::Library;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// A shape of Parry's at a pose.
pub(super) type Placed<'a, R> = (&'a <R as Library>::Form, &'a <R as Library>::Pose);

/// The queries of a build of Parry that give more than yes or no.
pub(super) trait Queries: Library {
    /// `query::distance`; 0 is how it says that the shapes touch.
    fn distance(a: Placed<'_, Self>, b: Placed<'_, Self>) -> Option<f64>;
    /// `query::closest_points`, at any distance.
    fn closest_points(a: Placed<'_, Self>, b: Placed<'_, Self>) -> Option<[DVec3; 2]>;
    /// `query::contact`, without a margin. The outer `None`: it does not know the pair.
    fn contact(a: Placed<'_, Self>, b: Placed<'_, Self>) -> Option<Option<Contact>>;
}

/// A contact in f64.
pub(super) struct Contact {
    /// Below 0 where the shapes overlap.
    distance: f64,
    way: Way,
}

macro_rules! queries {
    ($real:ty, $parry:ident) => {
        impl Queries for $real {
            fn distance(a: Placed<'_, Self>, b: Placed<'_, Self>) -> Option<f64> {
                let found = $parry::query::distance(a.1, &**a.0, b.1, &**b.0).ok()?;
                Some(found.distance.into())
            }

            fn closest_points(a: Placed<'_, Self>, b: Placed<'_, Self>) -> Option<[DVec3; 2]> {
                use $parry::query::{ClosestPoints, closest_points};
                match closest_points(a.1, &**a.0, b.1, &**b.0, <$real>::MAX).ok()? {
                    ClosestPoints::WithinMargin(a, b) => Some([in_f64(a), in_f64(b)]),
                    _ => None,
                }
            }

            fn contact(a: Placed<'_, Self>, b: Placed<'_, Self>) -> Option<Option<Contact>> {
                let found = $parry::query::contact(a.1, &**a.0, b.1, &**b.0, 0.0).ok()?;
                Some(found.map(|contact| {
                    let [normal, a, b] =
                        [contact.normal1, contact.point1, contact.point2].map(in_f64);
                    Contact { distance: contact.dist.into(), way: Way::new(normal, a, b) }
                }))
            }
        }
    };
}

queries!(f32, parry3d);
queries!(f64, parry3d_f64);

/// A vector of either build, without loss.
fn in_f64<T: Into<f64>>(v: impl Into<[T; 3]>) -> DVec3 {
    DVec3::from_array(v.into().map(Into::into))
}

/// The answer of the build for R. Undecided where it refuses a shape, does not know the pair, is out
/// of its range, panics, or answers with what is no number.
pub(super) fn answer<R: Queries>(query: Query, method: &'static str, a: &Side, b: &Side) -> Answer {
    let undecided = |reason| Answer::new(&Verdict::<()>::Undecided(reason), method);
    if !within_range::<R>(a, b) {
        return undecided(Reason::Range);
    }
    let run = || {
        let [form_a, form_b] = [a, b].map(|side| R::form(&side.shape));
        let [pose_a, pose_b] = [a, b].map(|side| R::pose(&side.pose));
        let (a, b) = ((&form_a?, &pose_a), (&form_b?, &pose_b));
        match query {
            Query::Boolean => touching::<R>(method, a, b),
            Query::Distance => distance::<R>(method, a, b),
            Query::Depth => depth::<R>(method, a, b),
            Query::Manifold => None,
        }
    };
    // It asserts its own invariants. Nothing that the closure reads can be left half changed.
    let answer = catch_unwind(AssertUnwindSafe(run));
    answer.ok().flatten().unwrap_or_else(|| undecided(Reason::Foreign))
}

fn within_range<R: Library>(a: &Side, b: &Side) -> bool {
    let offset = (b.pose.translation() - a.pose.translation()).length();
    a.shape.reach() + b.shape.reach() + offset <= R::RANGE
}

fn touching<R: Queries>(
    method: &'static str,
    a: Placed<'_, R>,
    b: Placed<'_, R>,
) -> Option<Answer> {
    let touching = R::touching(dcd_parry::Query::IntersectionTest, a, b)?;
    Some(verdict(touching, method))
}

fn distance<R: Queries>(
    method: &'static str,
    a: Placed<'_, R>,
    b: Placed<'_, R>,
) -> Option<Answer> {
    let distance = R::distance(a, b).filter(|distance| distance.is_finite())?;
    let mut answer = verdict(distance == 0.0, method);
    answer.distance = Some(distance);
    if distance != 0.0 {
        let points = R::closest_points(a, b).filter(|points| points.iter().all(|p| p.is_finite()));
        answer.way = points.map(|[a, b]| Way::new((b - a).normalize_or_zero(), a, b));
    }
    Some(answer)
}

fn depth<R: Queries>(method: &'static str, a: Placed<'_, R>, b: Placed<'_, R>) -> Option<Answer> {
    let contact = R::contact(a, b)?;
    let Some(contact) = contact else { return Some(verdict(false, method)) };
    if !(contact.distance.is_finite() && contact.way.is_finite()) {
        return None;
    }
    let touching = contact.distance <= 0.0;
    let mut answer = verdict(touching, method);
    if touching {
        answer.depth = Some(contact.distance.abs());
        answer.way = Some(contact.way);
    }
    Some(answer)
}

fn verdict(touching: bool, method: &'static str) -> Answer {
    Answer::new(&if touching { Verdict::Touching(()) } else { Verdict::Apart }, method)
}
