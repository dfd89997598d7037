//! The contract of this crate's trait, as a test that any narrow phase can call.

use crate::{
    Contact, ContactList, ContactSink, ContactsOf, Method, NarrowPhase, Prepared, Report, Sides,
    Undecided,
};
use dcd_geom::contract::Violation;
use dcd_geom::glam::{DMat3, DVec3};
use dcd_geom::{Aabb, HalfSpace, List, Pair, Scene, Shape, SphereBounds, Splittable, SupportMap};
use std::fmt::Debug;

/// Tests the contract of [`NarrowPhase`] on a scene and pairs of its objects, each at most once; shapes
/// of every kind will do.
///
/// # Errors
/// The first breach.
pub fn narrow_phase<N>(narrow: &N, scene: &Scene, pairs: &[Pair]) -> Result<(), Violation>
where
    N: NarrowPhase,
    N::Answer: PartialEq + Debug,
{
    let mut frame = N::Frame::default();
    let aabbs = prepared(narrow, scene, Sides::One, &mut frame, usize::MAX);
    boxes_contain_their_objects(scene, &aabbs)?;
    if let Some(aabb_margin) = narrow.aabb_margin() {
        bounds_contain_their_boxes(scene, &aabbs, aabb_margin)?;
    }
    let whole = decided(narrow, scene, &frame, pairs, &mut N::Scratch::default());
    whole.has_each_once(pairs)?;
    senses_the_contacts(narrow, scene, &frame, pairs, &whole)?;
    if let Some(answer) = narrow.constant_answer() {
        contacts_of_inner_spheres_have_it(scene, pairs, &whole.contacts, answer)?;
    }

    // Prepared in single objects from the last to the first, into a frame that was used before.
    let again = prepared(narrow, scene, Sides::One, &mut frame, 1);
    if again != aabbs {
        return Err(Violation("the boxes depend on how the objects are cut".into()));
    }
    let mut scratch = N::Scratch::default();
    let mut pieces = Decided::default();
    for piece in pairs.chunks(3) {
        pieces.append(decided(narrow, scene, &frame, piece, &mut scratch));
    }
    pieces.must_equal(&whole, "in threes, the objects prepared one at a time")?;

    upper_half_prepared(narrow, scene, &mut frame);
    decided(narrow, scene, &frame, pairs, &mut scratch)
        .must_equal(&whole, "the lower half of the objects prepared before")?;
    let upper = |pair: &&Pair| pair.i as usize >= scene.len() / 2;
    let upper: Vec<Pair> = pairs.iter().filter(upper).copied().collect();
    let due = decided(narrow, scene, &frame, &upper, &mut scratch);
    let mut half_empty = N::Frame::default();
    upper_half_prepared(narrow, scene, &mut half_empty);
    decided(narrow, scene, &half_empty, &upper, &mut scratch)
        .must_equal(&due, "the lower half of the objects never prepared")?;

    prepared(narrow, scene, Sides::One, &mut frame, usize::MAX);
    if keeps_when_laid_out_again(narrow, scene, &mut frame) {
        decided(narrow, scene, &frame, pairs, &mut scratch)
            .must_equal(&whole, "laid out again by a frame that keeps what it held")?;
    }
    // Another scene between, of nothing: a frame that keeps something of it must not show it.
    prepared(narrow, &Scene::default(), Sides::One, &mut frame, usize::MAX);
    if prepared(narrow, scene, Sides::One, &mut frame, usize::MAX) != aabbs {
        return Err(Violation("the boxes depend on the scene before".into()));
    }

    let mut alone = Decided::default();
    for &pair in pairs.iter().rev() {
        alone.append(decided(narrow, scene, &frame, &[pair], &mut scratch));
    }
    alone.reverse();
    alone.must_equal(&whole, "alone, from the last to the first, in used scratch memory")?;

    let backwards: Vec<Pair> = pairs.iter().rev().copied().collect();
    let mut backwards = decided(narrow, scene, &frame, &backwards, &mut scratch);
    backwards.reverse();
    backwards.must_equal(&whole, "in reverse order")?;
    two_sides_agree(narrow, scene, pairs, whole)
}

/// Compares the answers of one frame with those of two that hold the same objects. What resolved a pair may
/// differ.
fn two_sides_agree<N>(
    narrow: &N,
    scene: &Scene,
    pairs: &[Pair],
    whole: Decided<N::Answer>,
) -> Result<(), Violation>
where
    N: NarrowPhase,
    N::Answer: PartialEq + Debug,
{
    let mut frames = [N::Frame::default(), N::Frame::default()];
    for frame in &mut frames {
        prepared(narrow, scene, Sides::Two, frame, usize::MAX);
    }
    let [a, b] = frames.each_ref().map(|frame| Prepared { scene, frame });
    let mut scratch = N::Scratch::default();
    let mut two = decided_between(narrow, (a, b), pairs, &mut scratch);
    two.has_each_once(pairs)?;
    two.resolved = whole.resolved;
    two.must_equal(&whole, "of two frames")?;
    let mut one = decided_between(narrow, (a, a), pairs, &mut scratch);
    one.resolved = whole.resolved;
    one.must_equal(&whole, "of one frame laid out for two sides")
}

/// Lays out and prepares, in parts of `grain` objects from the last to the first.
fn prepared<N: NarrowPhase>(
    narrow: &N,
    scene: &Scene,
    sides: Sides,
    frame: &mut N::Frame,
    grain: usize,
) -> Vec<Aabb> {
    let mut aabbs = vec![Aabb::default(); scene.len()];
    let mut rest = (narrow.layout(scene, sides, frame), &mut aabbs[..]);
    let mut parts = Vec::new();
    let mut first = 0;
    while rest.len() > grain {
        let (part, others) = rest.split_at(grain);
        parts.push((first, part));
        rest = others;
        first += grain;
    }
    parts.push((first, rest));
    for (first, (part, aabbs)) in parts.into_iter().rev() {
        narrow.prepare(scene, first, part, aabbs);
    }
    aabbs
}

/// Lays out and prepares the upper half of the objects alone.
fn upper_half_prepared<N: NarrowPhase>(narrow: &N, scene: &Scene, frame: &mut N::Frame) {
    let middle = scene.len() / 2;
    let (_, part) = narrow.layout(scene, Sides::One, frame).split_at(middle);
    let mut aabbs = vec![Aabb::default(); scene.len() - middle];
    narrow.prepare(scene, middle, part, &mut aabbs);
}

fn keeps_when_laid_out_again<N: NarrowPhase>(
    narrow: &N,
    scene: &Scene,
    frame: &mut N::Frame,
) -> bool {
    let part = narrow.layout(scene, Sides::One, frame);
    narrow.keeps(&part)
}

fn decided<N: NarrowPhase>(
    narrow: &N,
    scene: &Scene,
    frame: &N::Frame,
    pairs: &[Pair],
    scratch: &mut N::Scratch,
) -> Decided<N::Answer> {
    let side = Prepared { scene, frame };
    decided_between(narrow, (side, side), pairs, scratch)
}

fn decided_between<N: NarrowPhase>(
    narrow: &N,
    (a, b): (Prepared<'_, N::Frame>, Prepared<'_, N::Frame>),
    pairs: &[Pair],
    scratch: &mut N::Scratch,
) -> Decided<N::Answer> {
    let mut contacts = ContactsOf::<N::Answer>::default();
    let mut report = Report::default();
    let mut sink = ContactSink { contacts: &mut contacts, report: &mut report };
    narrow.decide(a, b, pairs, scratch, &mut sink);
    let contacts = contacts.contacts(0..contacts.len()).collect();
    let resolved = Method::ALL.iter().map(|&method| report.resolved(method)).sum();
    let undecided = report.undecided().to_vec();
    Decided { contacts, undecided, resolved, pair_count: report.pair_count() }
}

/// Compares the pairs that are sensed with those that are decided to touch.
fn senses_the_contacts<N: NarrowPhase>(
    narrow: &N,
    scene: &Scene,
    frame: &N::Frame,
    pairs: &[Pair],
    whole: &Decided<N::Answer>,
) -> Result<(), Violation> {
    let side = Prepared { scene, frame };
    let (mut contacts, mut report) = (ContactsOf::<N::Answer>::default(), Report::default());
    let mut sink = ContactSink { contacts: &mut contacts, report: &mut report };
    narrow.sense(side, side, pairs, &mut N::Scratch::default(), &mut sink);
    let is_unmeasured = |pair: Pair| whole.undecided.iter().any(|undecided| undecided.pair == pair);
    let mut due = whole.contacts.iter().map(|contact| contact.pair).peekable();
    for pair in contacts.pairs(0..contacts.len()) {
        // Of a pair that touches and cannot be measured, it is known that it touches.
        if due.next_if_eq(&pair).is_none() && !is_unmeasured(pair) {
            return Err(Violation(format!("{pair:?} is sensed and no contact")));
        }
    }
    match due.next() {
        None => Ok(()),
        Some(pair) => Err(Violation(format!("{pair:?} is a contact and not sensed"))),
    }
}

/// What was decided of some pairs.
struct Decided<A> {
    contacts: Vec<Contact<A>>,
    undecided: Vec<Undecided>,
    resolved: u64,
    pair_count: u64,
}

impl<A> Default for Decided<A> {
    fn default() -> Self {
        Self { contacts: Vec::new(), undecided: Vec::new(), resolved: 0, pair_count: 0 }
    }
}

impl<A: PartialEq + Debug> Decided<A> {
    fn append(&mut self, mut other: Self) {
        self.contacts.append(&mut other.contacts);
        self.undecided.append(&mut other.undecided);
        self.resolved += other.resolved;
        self.pair_count += other.pair_count;
    }

    fn reverse(&mut self) {
        self.contacts.reverse();
    }

    fn has_each_once(&self, pairs: &[Pair]) -> Result<(), Violation> {
        if self.pair_count != pairs.len() as u64 {
            return Err(Violation(format!(
                "{} verdicts on {} pairs",
                self.pair_count,
                pairs.len()
            )));
        }
        let mut remaining = pairs.iter();
        for Contact { pair, .. } in &self.contacts {
            if !remaining.any(|known| known == pair) {
                return Err(Violation(format!("the contact {pair:?} is not in the pairs' order")));
            }
        }
        for Undecided { pair, .. } in &self.undecided {
            let touches = self.contacts.iter().any(|contact| contact.pair == *pair);
            if touches || !pairs.contains(pair) {
                return Err(Violation(format!("{pair:?} is undecided and not open")));
            }
        }
        Ok(())
    }

    fn must_equal(&self, whole: &Self, how: &str) -> Result<(), Violation> {
        let first = self.contacts.iter().zip(&whole.contacts).find(|(ours, theirs)| ours != theirs);
        if let Some((ours, theirs)) = first {
            return Err(Violation(format!("{ours:?} {how}, but {theirs:?} at once")));
        }
        let sorted = |decided: &Self| {
            let mut undecided = decided.undecided.clone();
            undecided.sort_unstable_by_key(|undecided| undecided.pair);
            (undecided, decided.contacts.len(), decided.resolved)
        };
        let (ours, theirs) = (sorted(self), sorted(whole));
        if ours != theirs {
            return Err(Violation(format!("{ours:?} {how}, but {theirs:?} at once")));
        }
        Ok(())
    }
}

/// The directions in which a shape without vertices is compared with its box.
const DIRECTIONS: [DVec3; 7] =
    [DVec3::X, DVec3::Y, DVec3::Z, DVec3::ONE, DVec3::NEG_ONE, DVec3::NEG_X, DVec3::NEG_Z];

fn boxes_contain_their_objects(scene: &Scene, aabbs: &[Aabb]) -> Result<(), Violation> {
    for (i, (aabb, pose)) in aabbs.iter().zip(scene.poses()).enumerate() {
        let to_local = pose.rotation().transpose();
        for Sample { point, radius } in samples(scene.shape(i), to_local) {
            let world = pose.apply(point);
            // Three products and three sums of the comparison's own.
            let size = point.length() + pose.translation().abs().max_element();
            let margin = DVec3::splat(radius - (size + radius) * 1e-15);
            if !holds(aabb, world - margin, world + margin) {
                return Err(Violation(format!("{aabb:?} of object {i} does not hold {world}")));
            }
        }
    }
    Ok(())
}

/// A sphere inside a shape, in its own frame.
struct Sample {
    point: DVec3,
    radius: f64,
}

/// Spheres that reach as far as the shape does: round vertices, or supports where it has none; of a
/// compound those of every part, of a half-space some on its plane and below it.
fn samples(shape: &Shape, to_local: DMat3) -> Vec<Sample> {
    let points = match shape {
        Shape::Compound(compound) => {
            let parts = compound.parts().iter();
            return parts.flat_map(|part| samples(part.placed(), to_local)).collect();
        }
        Shape::HalfSpace(half_space) => below(half_space),
        Shape::Mesh(mesh) => mesh.points().to_vec(),
        Shape::Polytope(polytope) => polytope.vertices().to_vec(),
        convex => DIRECTIONS.iter().map(|&d| convex.support(to_local * d).point).collect(),
    };
    let radius = shape.radius();
    points.into_iter().map(|point| Sample { point, radius }).collect()
}

/// How far from the plane's foot a half-space is looked at, metres.
const FAR: [f64; 3] = [0.0, 1.0, 1e6];

/// Points of a half-space: on its plane and below it, near and far to every side.
fn below(half_space: &HalfSpace) -> Vec<DVec3> {
    let normal = half_space.normal();
    let foot = normal * (half_space.offset() / normal.length_squared());
    let up = normal.normalize();
    let along = up.any_orthonormal_vector();
    let across = up.cross(along);
    // The foot is off the plane by its rounding, so a point a little lower is tested.
    let foot = foot - up * (foot.length() * 1e-15);
    let sides = [along, -along, across, -across];
    let around = |far: f64| sides.map(|side| foot + side * far - up * (far * 1e-15));
    let under = FAR.map(|far| foot - up * far);
    FAR.into_iter().flat_map(around).chain(under).collect()
}

fn bounds_contain_their_boxes(
    scene: &Scene,
    aabbs: &[Aabb],
    aabb_margin: f64,
) -> Result<(), Violation> {
    for (i, (aabb, pose)) in aabbs.iter().zip(scene.poses()).enumerate() {
        let Some(bound) = SphereBounds::of(scene.shape(i)) else { continue };
        let bound = bound.swept(aabb_margin).aabb(pose);
        if !bound.contains(aabb) {
            return Err(Violation(format!("{bound:?} of object {i} does not hold {aabb:?}")));
        }
    }
    Ok(())
}

fn contacts_of_inner_spheres_have_it<A: PartialEq + Debug>(
    scene: &Scene,
    pairs: &[Pair],
    contacts: &[Contact<A>],
    answer: A,
) -> Result<(), Violation> {
    let inner = |i: u32| {
        let i = i as usize;
        Some(SphereBounds::of(scene.shape(i))?.inner_sphere(&scene.poses()[i]))
    };
    for pair in pairs {
        let spheres = inner(pair.i).zip(inner(pair.j));
        let touch = spheres.is_some_and(|(a, b)| a.short_of(&b) <= 0.0);
        if touch && !contacts.iter().any(|c| c.pair == *pair && c.answer == answer) {
            return Err(Violation(format!(
                "{pair:?} touch, and {answer:?} is not reported of them"
            )));
        }
    }
    Ok(())
}

fn holds(aabb: &Aabb, min: DVec3, max: DVec3) -> bool {
    aabb.min.as_dvec3().cmple(min).all() && max.cmple(aabb.max.as_dvec3()).all()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Certified, Coherent, Gjk, Overlap, PairSolver, Pairwise, PosedShape, Verdict};
    use dcd_geom::glam::DQuat;
    use dcd_geom::{Pose, Shape};
    use std::sync::atomic::{AtomicU32, Ordering};

    fn pile() -> (Scene, Vec<Pair>) {
        let turned = |k: u32| DQuat::from_rotation_x(f64::from(k)) * DQuat::from_rotation_z(0.7);
        let place = |k: u32| DVec3::new(f64::from(k % 3), f64::from(k / 3 % 3), f64::from(k / 9));
        let shapes = vec![
            Shape::cuboid(DVec3::new(0.5, 0.6, 0.3)).unwrap(),
            Shape::sphere(0.4).unwrap(),
            Shape::hull(vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z, DVec3::ONE]).unwrap(),
            Shape::custom(std::sync::Arc::new(dcd_geom::Polytope::sphere(0.5).unwrap())).unwrap(),
        ];
        let pose =
            |k| Pose::new(if k < 9 { DQuat::IDENTITY } else { turned(k) }, place(k)).unwrap();
        let objects = (0..27).map(|k| dcd_geom::Object::new(k % 4, pose(k)));
        let scene = Scene::new(shapes, objects).unwrap();
        let pairs = (0..27).flat_map(|i| (i + 1..27).map(move |j| Pair::new(i, j)));
        (scene, pairs.collect())
    }

    #[test]
    fn our_narrow_phases_keep_the_contract() {
        let (scene, pairs) = pile();
        narrow_phase(&Pairwise(Gjk::<f32>::default()), &scene, &pairs).unwrap();
        narrow_phase(&Pairwise(Gjk::<f64>::default()), &scene, &pairs).unwrap();
        narrow_phase(&Pairwise(Certified), &scene, &pairs).unwrap();
        narrow_phase(&Overlap::default(), &scene, &pairs).unwrap();
        narrow_phase(&Overlap::default(), &Scene::default(), &[]).unwrap();
        narrow_phase(&Coherent::default(), &scene, &pairs).unwrap();
    }

    #[test]
    fn a_solver_with_a_memory_is_caught() {
        #[derive(Default)]
        struct Forgetful(AtomicU32);
        impl PairSolver for Forgetful {
            type Answer = ();
            type Scratch = ();
            fn method(&self) -> Method {
                Method::Foreign
            }
            fn solve(&self, _: PosedShape<'_>, _: PosedShape<'_>, (): &mut ()) -> Verdict<()> {
                let first = self.0.fetch_add(1, Ordering::Relaxed) < 100;
                if first { Verdict::Touching(()) } else { Verdict::Apart }
            }
        }
        let (scene, pairs) = pile();
        assert!(narrow_phase(&Pairwise(Forgetful::default()), &scene, &pairs).is_err());
    }
}
