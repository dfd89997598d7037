//! What links are placed with: sixteen states in lanes, or one state alone, each operation rounded alike, so that a state's
//! frames do not depend on how many are placed together.

use dcd_simd::{Lanes, Row};

/// Operations on f32, IEEE and rounded to nearest.
pub(super) trait Numbers: Copy {
    type F: Copy;
    /// Yes or no.
    type M: Copy;
    fn splat(self, x: f32) -> Self::F;
    fn load(self, row: &Row) -> Self::F;
    fn store(self, a: Self::F, row: &mut Row);
    fn add(self, a: Self::F, b: Self::F) -> Self::F;
    fn sub(self, a: Self::F, b: Self::F) -> Self::F;
    fn mul(self, a: Self::F, b: Self::F) -> Self::F;
    /// a·b + c, rounded once or twice, as the lanes do.
    fn mul_add(self, a: Self::F, b: Self::F, c: Self::F) -> Self::F;
    fn neg(self, a: Self::F) -> Self::F;
    fn abs(self, a: Self::F) -> Self::F;
    fn max(self, a: Self::F, b: Self::F) -> Self::F;
    fn lt(self, a: Self::F, b: Self::F) -> Self::M;
    fn select(self, mask: Self::M, yes: Self::F, no: Self::F) -> Self::F;
}

/// Sixteen states.
#[derive(Clone, Copy)]
pub(super) struct All<L>(pub(super) L);

/// Hands a method on to the lanes.
macro_rules! hand_on {
    ($($name:ident($($a:ident: $of:ty),*) $(-> $to:ty)?;)*) => {
        $(
            #[inline(always)]
            fn $name(self, $($a: $of),*) $(-> $to)? {
                self.0.$name($($a),*)
            }
        )*
    };
}

impl<L: Lanes> Numbers for All<L> {
    type F = L::F;
    type M = L::M;

    hand_on! {
        splat(x: f32) -> L::F;
        load(row: &Row) -> L::F;
        store(a: L::F, row: &mut Row);
        add(a: L::F, b: L::F) -> L::F;
        sub(a: L::F, b: L::F) -> L::F;
        mul(a: L::F, b: L::F) -> L::F;
        mul_add(a: L::F, b: L::F, c: L::F) -> L::F;
        neg(a: L::F) -> L::F;
        abs(a: L::F) -> L::F;
        max(a: L::F, b: L::F) -> L::F;
        lt(a: L::F, b: L::F) -> L::M;
        select(mask: L::M, yes: L::F, no: L::F) -> L::F;
    }
}

/// The state of the first lane: the others' numbers stay what they were.
#[derive(Clone, Copy)]
pub(super) struct First<L>(pub(super) L);

impl<L: Lanes> Numbers for First<L> {
    type F = f32;
    type M = bool;

    #[inline(always)]
    fn splat(self, x: f32) -> f32 {
        x
    }
    #[inline(always)]
    fn load(self, row: &Row) -> f32 {
        row.0[0]
    }
    #[inline(always)]
    fn store(self, a: f32, row: &mut Row) {
        row.0[0] = a;
    }
    #[inline(always)]
    fn add(self, a: f32, b: f32) -> f32 {
        a + b
    }
    #[inline(always)]
    fn sub(self, a: f32, b: f32) -> f32 {
        a - b
    }
    #[inline(always)]
    fn mul(self, a: f32, b: f32) -> f32 {
        a * b
    }
    #[inline(always)]
    fn mul_add(self, a: f32, b: f32, c: f32) -> f32 {
        // One instruction where the lanes have one: it is inlined where they are.
        if L::FUSED { a.mul_add(b, c) } else { a * b + c }
    }
    #[inline(always)]
    fn neg(self, a: f32) -> f32 {
        -a
    }
    #[inline(always)]
    fn abs(self, a: f32) -> f32 {
        a.abs()
    }
    #[inline(always)]
    fn max(self, a: f32, b: f32) -> f32 {
        if a > b { a } else { b }
    }
    #[inline(always)]
    fn lt(self, a: f32, b: f32) -> bool {
        a < b
    }
    #[inline(always)]
    fn select(self, mask: bool, yes: f32, no: f32) -> f32 {
        if mask { yes } else { no }
    }
}
