//! Sixteen vectors at a time.

use dcd_simd::{Lanes, Row};

/// The x, y and z of sixteen vectors.
pub(crate) struct V3<L: Lanes>(pub(crate) L::F, pub(crate) L::F, pub(crate) L::F);

impl<L: Lanes> Clone for V3<L> {
    #[inline(always)]
    fn clone(&self) -> Self {
        *self
    }
}

impl<L: Lanes> Copy for V3<L> {}

impl<L: Lanes> V3<L> {
    #[inline(always)]
    pub(crate) fn load(l: L, rows: &[Row; 3]) -> Self {
        Self(l.load(&rows[0]), l.load(&rows[1]), l.load(&rows[2]))
    }

    #[inline(always)]
    pub(crate) fn store(self, l: L, rows: &mut [Row; 3]) {
        l.store(self.0, &mut rows[0]);
        l.store(self.1, &mut rows[1]);
        l.store(self.2, &mut rows[2]);
    }

    #[inline(always)]
    pub(crate) fn add(self, l: L, o: Self) -> Self {
        Self(l.add(self.0, o.0), l.add(self.1, o.1), l.add(self.2, o.2))
    }

    #[inline(always)]
    pub(crate) fn sub(self, l: L, o: Self) -> Self {
        Self(l.sub(self.0, o.0), l.sub(self.1, o.1), l.sub(self.2, o.2))
    }

    #[inline(always)]
    pub(crate) fn neg(self, l: L) -> Self {
        Self(l.neg(self.0), l.neg(self.1), l.neg(self.2))
    }

    /// self + k·o.
    #[inline(always)]
    pub(crate) fn plus(self, l: L, k: L::F, o: Self) -> Self {
        Self(l.mul_add(k, o.0, self.0), l.mul_add(k, o.1, self.1), l.mul_add(k, o.2, self.2))
    }

    #[inline(always)]
    pub(crate) fn dot(self, l: L, o: Self) -> L::F {
        l.mul_add(self.0, o.0, l.mul_add(self.1, o.1, l.mul(self.2, o.2)))
    }

    #[inline(always)]
    pub(crate) fn cross(self, l: L, o: Self) -> Self {
        let minor = |a, b, c, d| l.sub(l.mul(a, b), l.mul(c, d));
        Self(
            minor(self.1, o.2, self.2, o.1),
            minor(self.2, o.0, self.0, o.2),
            minor(self.0, o.1, self.1, o.0),
        )
    }

    #[inline(always)]
    pub(crate) fn norm1(self, l: L) -> L::F {
        l.add(l.abs(self.0), l.add(l.abs(self.1), l.abs(self.2)))
    }

    /// `yes` where the mask is set, else `no`.
    #[inline(always)]
    pub(crate) fn select(l: L, mask: L::M, yes: Self, no: Self) -> Self {
        Self(l.select(mask, yes.0, no.0), l.select(mask, yes.1, no.1), l.select(mask, yes.2, no.2))
    }
}
