//! Bounds and sides of many AABBs by halving the list: the same work, in the same order, whether
//! the halves run at once or one after the other.

use super::Partition;
use dcd_exec::Exec;
use dcd_geom::Aabb;

/// Indices handled in one go. Larger: fewer tasks to share, more stack. Smaller: more overhead.
const GRAIN: usize = 1024;

/// The union of the AABBs that `of` gives for the indices.
pub(super) fn reduce(indices: &[u32], exec: Exec, of: &(impl Fn(u32) -> Aabb + Sync)) -> Aabb {
    if indices.len() <= GRAIN {
        return indices.iter().fold(Aabb::EMPTY, |bounds, &i| bounds.union(&of(i)));
    }
    let (left, right) = indices.split_at(indices.len() / 2);
    let (left, right) = exec.join(|| reduce(left, exec, of), || reduce(right, exec, of));
    left.union(&right)
}

/// Moves the indices on the left side before the others and counts them.
///
/// The halves are filtered at once, each in place, and what is on the left side in the second is
/// rotated to the end of what is in the first: stable if the parts are, without an allocation.
/// The rotations move four bytes an index and level, beside the gathering of 24 by the filter.
pub(super) fn partition(
    order: Partition,
    indices: &mut [u32],
    exec: Exec,
    is_left: &(impl Fn(u32) -> bool + Sync),
) -> usize {
    if indices.len() <= GRAIN {
        return match order {
            Partition::Stable => stable(indices, is_left),
            Partition::Unstable => unstable(indices, is_left),
        };
    }
    let middle = indices.len() / 2;
    let (first, second) = indices.split_at_mut(middle);
    let (in_first, in_second) = exec.join(
        || partition(order, first, exec, is_left),
        || partition(order, second, exec, is_left),
    );
    indices[in_first..middle + in_second].rotate_left(middle - in_first);
    in_first + in_second
}

/// Partitions at most [`GRAIN`] indices, stably.
fn stable(indices: &mut [u32], is_left: impl Fn(u32) -> bool) -> usize {
    let mut right_side = [0; GRAIN];
    let (mut left, mut right) = (0, 0);
    for k in 0..indices.len() {
        let index = indices[k];
        if is_left(index) {
            indices[left] = index;
            left += 1;
        } else {
            right_side[right] = index;
            right += 1;
        }
    }
    indices[left..].copy_from_slice(&right_side[..right]);
    left
}

fn unstable(indices: &mut [u32], is_left: impl Fn(u32) -> bool) -> usize {
    let (mut left, mut right) = (0, indices.len());
    while left < right {
        if is_left(indices[left]) {
            left += 1;
        } else {
            right -= 1;
            indices.swap(left, right);
        }
    }
    left
}

#[cfg(test)]
mod tests {
    use super::*;
    use dcd_exec::Par;

    /// A list without order, and a side for each of its numbers that has no pattern.
    fn shuffled(count: u32) -> Vec<u32> {
        (0..count).map(|k| k.wrapping_mul(2_654_435_769) >> 8).collect()
    }

    #[test]
    fn a_stable_partition_keeps_the_order_on_both_sides() {
        for count in [0, 1, 2, 1024, 1025, 5000] {
            let list = shuffled(count);
            let is_left = |i: u32| i % 7 < 3;
            let (mut expected, right): (Vec<u32>, Vec<u32>) =
                list.iter().partition(|&&i| is_left(i));
            let left = expected.len();
            expected.extend(right);
            for par in [Par::Serial, Par::Pool] {
                let mut found = list.clone();
                assert_eq!(partition(Partition::Stable, &mut found, par.into(), &is_left), left);
                assert_eq!(found, expected);
            }
        }
    }

    #[test]
    fn an_unstable_partition_separates_the_sides_and_is_the_same_serial_and_pooled() {
        for count in [0, 1, 2, 1024, 1025, 5000] {
            let is_left = |i: u32| i % 5 < 2;
            let [serial, pooled] = [Par::Serial, Par::Pool].map(|par| {
                let mut list = shuffled(count);
                let left = partition(Partition::Unstable, &mut list, par.into(), &is_left);
                assert!(list[..left].iter().all(|&i| is_left(i)));
                assert!(!list[left..].iter().any(|&i| is_left(i)));
                list
            });
            assert_eq!(serial, pooled);
            let mut sorted = [serial, shuffled(count)];
            sorted.iter_mut().for_each(|list| list.sort_unstable());
            assert_eq!(sorted[0], sorted[1]);
        }
    }
}
