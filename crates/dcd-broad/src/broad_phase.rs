//! The trait for a broad phase of one's own.

use dcd_bvh::WideBvh;
use dcd_exec::{Exec, Segments};
use dcd_geom::{Aabb, Pair};

/// From AABBs to candidate pairs.
///
/// # Contract
/// After `build(aabbs)`, `pairs(aabbs, keep)` lists each pair i < j whose closed AABBs overlap and
/// for which `keep(i, j)` holds exactly once. It may list further pairs (a looser phase's
/// candidates), each once and only where `keep` holds. The list and its order depend on the AABBs
/// and on `keep` alone, not on `exec`. `contract` tests it.
///
/// AABBs are valid ([`Aabb::is_valid`]): what a [`dcd_geom::Scene`] yields always is.
///
/// ```
/// use dcd_broad::BroadPhase;
/// use dcd_exec::{Exec, Segments};
/// use dcd_geom::glam::Vec3;
/// use dcd_geom::{Aabb, Pair};
/// /// Every pair, whatever its boxes: a looser phase is allowed.
/// #[derive(Default)]
/// struct AllPairs;
/// impl BroadPhase for AllPairs {
///     fn build(&mut self, _: &[Aabb], _: Exec) {}
///     fn pairs(
///         &mut self,
///         aabbs: &[Aabb],
///         keep: impl Fn(u32, u32) -> bool + Sync,
///         exec: Exec,
///         out: &mut Segments<Pair>,
///     ) {
///         // A task for each j: the order depends on the boxes alone.
///         out.fill(exec, aabbs.len(), |j, list| {
///             let j = j as u32;
///             list.extend((0..j).filter(|&i| keep(i, j)).map(|i| Pair { i, j }));
///         });
///     }
/// }
/// // How many listed pairs do not overlap: none, of boxes that all do.
/// let unit = Aabb { min: Vec3::ZERO, max: Vec3::ONE };
/// assert_eq!(dcd_broad::contract::broad_phase(&mut AllPairs, &[unit; 3])?, 0);
/// # Ok::<(), dcd_geom::contract::Violation>(())
/// ```
pub trait BroadPhase: Send {
    /// Takes in the AABBs: makes or mends whatever structure the search needs.
    fn build(&mut self, aabbs: &[Aabb], exec: Exec);

    /// Replaces `out` by the candidate pairs of the AABBs of the last update. `keep(i, j)` is called for
    /// i < j during the search, before any narrow work; it must be a pure function.
    fn pairs(
        &mut self,
        aabbs: &[Aabb],
        keep: impl Fn(u32, u32) -> bool + Sync,
        exec: Exec,
        out: &mut Segments<Pair>,
    );

    /// The wide tree over exactly the boxes that were taken in last, numbered as they were, where there is one:
    /// queries use it in place of a comparison with every box.
    fn tree(&self) -> Option<&WideBvh> {
        None
    }
}
