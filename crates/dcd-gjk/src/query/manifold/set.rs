//! The manifolds of one pair.

use super::Manifold;
use std::ops::Deref;

/// Where two objects touch: a [`Manifold`] for each patch of their surfaces, the deepest first.
///
/// Two convex objects have one. Objects of parts have one for each direction that separates some of their parts: a box
/// in the corner of a mesh one against the floor and one against the wall. A slice of manifolds, in an order that
/// depends on the pair alone; not empty for a pair that touches.
#[derive(Clone, Debug, Default)]
pub struct ManifoldSet(Held);

/// One without an allocation: nearly all pairs have no more.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "the larger one is the common one")]
enum Held {
    One(Manifold),
    /// Of length 1 where the memory of more is kept.
    Many(Vec<Manifold>),
}

impl Default for Held {
    fn default() -> Self {
        Self::Many(Vec::new())
    }
}

impl ManifoldSet {
    /// One manifold, to be written.
    #[inline(always)]
    pub(super) fn empty_one() -> Self {
        Self(Held::One(Manifold::default()))
    }

    /// Becomes the default, which keeps the memory of more than one.
    #[inline(always)]
    pub(super) fn clear(&mut self) {
        match &mut self.0 {
            Held::Many(all) => all.clear(),
            Held::One(_) => *self = Self::default(),
        }
    }

    /// Becomes one manifold, to be written, in the memory of more if there is any.
    pub(super) fn begin_one(&mut self) {
        match &mut self.0 {
            Held::Many(all) if all.capacity() > 0 => {
                all.clear();
                all.push(Manifold::default());
            }
            _ => *self = Self::empty_one(),
        }
    }

    /// The bound of all of them: see [`Manifold::error_bound`]. Metres.
    #[inline]
    pub fn error_bound(&self) -> f64 {
        match &self.0 {
            Held::One(manifold) => manifold.error_bound,
            Held::Many(all) => all.iter().map(|manifold| manifold.error_bound).fold(0.0, f64::max),
        }
    }

    /// Adds an empty manifold to one or more, and has it written in its place; at least so many are to come.
    pub(super) fn push_with(
        &mut self,
        more: usize,
        write: impl FnOnce(&mut Manifold) -> Option<()>,
    ) -> Option<()> {
        if let Held::One(first) = &self.0 {
            let mut all = Vec::with_capacity(1 + more);
            all.push(*first);
            self.0 = Held::Many(all);
        }
        let Held::Many(all) = &mut self.0 else { return None };
        all.push(Manifold::default());
        write(all.last_mut()?)
    }

    pub(super) fn push(&mut self, manifold: Manifold) {
        match &mut self.0 {
            Held::Many(all) if all.capacity() == 0 => self.0 = Held::One(manifold),
            Held::Many(all) => all.push(manifold),
            Held::One(first) => self.0 = Held::Many(vec![*first, manifold]),
        }
    }

    /// Holds one manifold in place of what there was: empty, and then written in its place, which saves copies.
    #[inline(always)]
    pub(super) fn write_one(&mut self, write: impl FnOnce(&mut Manifold) -> bool) -> bool {
        self.begin_one();
        self.only_mut().is_some_and(write)
    }

    /// The only manifold, if there is one alone.
    #[inline(always)]
    pub(super) fn only_mut(&mut self) -> Option<&mut Manifold> {
        match &mut self.0 {
            Held::One(manifold) => Some(manifold),
            Held::Many(all) => match &mut all[..] {
                [only] => Some(only),
                _ => None,
            },
        }
    }

    pub(super) fn all_mut(&mut self) -> &mut [Manifold] {
        match &mut self.0 {
            Held::One(manifold) => std::slice::from_mut(manifold),
            Held::Many(all) => all,
        }
    }

    /// Exchanges a and b.
    pub(super) fn mirror(&mut self) {
        self.all_mut().iter_mut().for_each(Manifold::mirror);
    }
}

impl From<Manifold> for ManifoldSet {
    #[inline]
    fn from(manifold: Manifold) -> Self {
        Self(Held::One(manifold))
    }
}

impl PartialEq for ManifoldSet {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl Deref for ManifoldSet {
    type Target = [Manifold];

    #[inline]
    fn deref(&self) -> &[Manifold] {
        match &self.0 {
            Held::One(manifold) => std::slice::from_ref(manifold),
            Held::Many(all) => all,
        }
    }
}

impl<'a> IntoIterator for &'a ManifoldSet {
    type Item = &'a Manifold;
    type IntoIter = std::slice::Iter<'a, Manifold>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}
