//! Random numbers of the tests of queries.

use dcd_geom::glam::DVec3;

/// The generator of Numerical Recipes, within ±1.
pub(crate) struct Random(pub(crate) u32);

impl Random {
    /// From the seed that `DCD_SEED` names, else from this one.
    pub(crate) fn seeded(fixed: u32) -> Self {
        Self(std::env::var("DCD_SEED").map_or(fixed, |seed| seed.parse().expect("a seed")))
    }

    pub(crate) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(self.0 >> 8) / f64::from(1 << 23) - 1.0
    }

    pub(crate) fn vector(&mut self) -> DVec3 {
        DVec3::new(self.next(), self.next(), self.next())
    }
}
