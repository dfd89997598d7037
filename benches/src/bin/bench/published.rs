//! What the paper prints: an Intel i7 of 8 performance and 12 efficient cores, 28 threads.

/// How many objects the tables are of.
pub(crate) const OBJECTS: usize = 10_000;

/// Table 1: milliseconds of a stage, serial and parallel, in the order of the stages.
pub(crate) const TABLE_1: [(f64, f64); 4] =
    [(1.974, 0.546), (1.928, 1.426), (188.925, 46.219), (3549.824, 266.638)];

/// Table 2: leaf cutoff, and milliseconds of the parallel double phase.
pub(crate) const TABLE_2: [(u32, f64); 6] =
    [(1, 247.11), (4, 247.27), (16, 247.96), (64, 261.28), (256, 245.47), (1024, 245.19)];

/// Figure 3: objects, and candidate pairs.
pub(crate) const FIGURE_3: [(usize, u64); 4] =
    [(10, 24), (100, 755), (1_000, 50_517), (10_000, 3_286_997)];

/// Where figures 1 and 2 have their points.
pub(crate) const SIZES: [usize; 16] = [
    10, 20, 50, 100, 200, 500, 1_000, 2_000, 3_000, 4_000, 5_000, 6_000, 7_000, 8_000, 9_000,
    10_000,
];

/// The sums of table 1: the double phase from end to end, serial and parallel.
pub(crate) fn double_phase() -> [f64; 2] {
    let sum = |of: fn(&(f64, f64)) -> f64| TABLE_1.iter().map(of).sum();
    [sum(|stage| stage.0), sum(|stage| stage.1)]
}
