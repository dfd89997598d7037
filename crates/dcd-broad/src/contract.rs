//! The contract of this crate's trait, as a test that any backend can call.

use crate::BroadPhase;
use dcd_exec::{Exec, Par, Segments};
pub use dcd_geom::contract::Violation;
use dcd_geom::{Aabb, Pair};
use std::sync::atomic::{AtomicBool, Ordering};

/// Tests the contract of [`BroadPhase`] on these AABBs: each overlapping pair is listed once and no
/// pair twice, i < j, `keep` is respected, and the list is the same on the pool, in used buffers,
/// and after other AABBs. Returns how many listed pairs do not overlap. N²/2 comparisons.
///
/// # Errors
/// The first breach.
pub fn broad_phase(phase: &mut impl BroadPhase, aabbs: &[Aabb]) -> Result<usize, Violation> {
    let overlapping = overlapping(aabbs);
    let mut out = Segments::default();
    let serial = list(phase, aabbs, Par::Serial, &mut out);
    let surplus = covers(&serial, &overlapping, aabbs.len())?;

    if list(phase, aabbs, Par::Pool, &mut Segments::default()) != serial {
        return Err(Violation("the list on the pool is another one".into()));
    }
    for few in 0..aabbs.len().min(2) {
        if let Some(pair) = list(phase, &aabbs[..few], Par::Pool, &mut out).first() {
            return Err(Violation(format!("of {few} boxes {pair:?} is listed")));
        }
    }
    let others: Vec<Aabb> = aabbs.iter().rev().step_by(2).copied().collect();
    let listed = list(phase, &others, Par::Serial, &mut out);
    covers(&listed, &self::overlapping(&others), others.len()).map_err(of("every other box"))?;
    if list(phase, aabbs, Par::Serial, &mut out) != serial {
        return Err(Violation("after other boxes the list is another one".into()));
    }

    let listed = kept(phase, aabbs, Par::Serial)?;
    let due: Vec<Pair> = overlapping.into_iter().filter(is_kept).collect();
    covers(&listed, &due, aabbs.len()).map_err(of("the kept pairs"))?;
    if let Some(pair) = listed.iter().find(|pair| !is_kept(pair)) {
        return Err(Violation(format!("{pair:?} is listed, which `keep` refuses")));
    }
    if kept(phase, aabbs, Par::Pool)? != listed {
        return Err(Violation("the list of kept pairs on the pool is another one".into()));
    }
    Ok(surplus)
}

fn of(what: &str) -> impl Fn(Violation) -> Violation {
    move |Violation(breach)| Violation(format!("of {what}: {breach}"))
}

/// A predicate without a pattern that a phase could follow by chance.
fn is_kept(pair: &Pair) -> bool {
    (pair.i.wrapping_mul(7) ^ pair.j).wrapping_mul(2_654_435_769) >> 30 != 0
}

fn list(
    phase: &mut impl BroadPhase,
    aabbs: &[Aabb],
    par: Par,
    out: &mut Segments<Pair>,
) -> Vec<Pair> {
    let exec = Exec::from(par);
    phase.build(aabbs, exec);
    phase.pairs(aabbs, |_, _| true, exec, out);
    out.iter().flatten().copied().collect()
}

/// The list under [`is_kept`], which must be called for i < j alone.
fn kept(phase: &mut impl BroadPhase, aabbs: &[Aabb], par: Par) -> Result<Vec<Pair>, Violation> {
    let exec = Exec::from(par);
    let mut out = Segments::default();
    let in_order = AtomicBool::new(true);
    let keep = |i: u32, j: u32| {
        if i >= j || j as usize >= aabbs.len() {
            in_order.store(false, Ordering::Relaxed);
        }
        is_kept(&Pair { i, j })
    };
    phase.build(aabbs, exec);
    phase.pairs(aabbs, keep, exec, &mut out);
    if !in_order.into_inner() {
        return Err(Violation("`keep` is called with indices that are not i < j < N".into()));
    }
    Ok(out.iter().flatten().copied().collect())
}

/// Brute force: every two AABBs, ascending.
fn overlapping(aabbs: &[Aabb]) -> Vec<Pair> {
    let mut pairs = Vec::new();
    for (i, a) in (0..).zip(aabbs) {
        for (j, b) in (i + 1..).zip(&aabbs[i as usize + 1..]) {
            if a.overlaps(b) {
                pairs.push(Pair { i, j });
            }
        }
    }
    pairs
}

/// Whether `listed` has every pair of `due`, which ascends, and nothing twice; how many more.
fn covers(listed: &[Pair], due: &[Pair], boxes: usize) -> Result<usize, Violation> {
    if let Some(pair) = listed.iter().find(|p| p.i >= p.j || p.j as usize >= boxes) {
        return Err(Violation(format!("{pair:?} of {boxes} boxes is listed")));
    }
    let mut sorted = listed.to_vec();
    sorted.sort_unstable();
    if let Some(twice) = sorted.windows(2).find(|two| two[0] == two[1]) {
        return Err(Violation(format!("{:?} is listed twice", twice[0])));
    }
    let mut surplus = sorted.iter();
    match due.iter().find(|&pair| !surplus.any(|listed| listed == pair)) {
        Some(pair) => Err(Violation(format!("{pair:?} overlaps and is not listed"))),
        None => Ok(sorted.len() - due.len()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::BruteForce;
    use glam::Vec3;
    use std::sync::atomic::AtomicU32;

    /// Brute force whose list is altered.
    struct Spoilt<F>(F);

    impl<F: Fn(&mut Vec<Pair>, &[Aabb]) + Send> BroadPhase for Spoilt<F> {
        fn build(&mut self, _: &[Aabb], _: Exec) {}
        fn pairs(
            &mut self,
            aabbs: &[Aabb],
            keep: impl Fn(u32, u32) -> bool + Sync,
            exec: Exec,
            out: &mut Segments<Pair>,
        ) {
            BruteForce.pairs(aabbs, keep, exec, out);
            let mut list: Vec<Pair> = out.iter().flatten().copied().collect();
            (self.0)(&mut list, aabbs);
            out.fill(Par::Serial.into(), 1, |_, out| out.extend(&list));
        }
    }

    /// What the contract says of a row of twenty AABBs, each of which overlaps the next.
    fn verdict(spoil: impl Fn(&mut Vec<Pair>, &[Aabb]) + Send) -> String {
        let half = Vec3::splat(0.75);
        let centres = (0..20).map(|k| Vec3::X * k as f32);
        let aabbs: Vec<_> = centres.map(|c| Aabb { min: c - half, max: c + half }).collect();
        match broad_phase(&mut Spoilt(spoil), &aabbs) {
            Ok(surplus) => format!("surplus {surplus}"),
            Err(Violation(breach)) => breach,
        }
    }

    #[test]
    fn a_surplus_pair_that_is_kept_is_counted() {
        assert_eq!(verdict(|_, _| ()), "surplus 0");
        let far = Pair { i: 0, j: 9 };
        assert!(is_kept(&far));
        let add = |list: &mut Vec<Pair>, aabbs: &[Aabb]| {
            if aabbs.len() > 9 {
                list.push(far);
            }
        };
        assert_eq!(verdict(add), "surplus 1");
    }

    #[test]
    fn each_breach_of_the_contract_is_caught() {
        let says = |spoil: fn(&mut Vec<Pair>, &[Aabb]), words: &str| {
            let verdict = verdict(spoil);
            assert!(verdict.contains(words), "{verdict}");
        };
        says(|list, _| list.truncate(3), "is not listed");
        says(|list, _| list.extend(list.clone().first()), "is listed twice");
        says(|list, _| list.iter_mut().for_each(|p| *p = Pair { i: p.j, j: p.i }), "of 20 boxes");
        says(
            |list, aabbs| list.extend((aabbs.len() == 1).then_some(Pair { i: 0, j: 1 })),
            "of 1 boxes",
        );
        says(|list, aabbs| *list = overlapping(aabbs), "which `keep` refuses");
    }

    #[test]
    fn a_list_that_remembers_is_caught() {
        let calls = AtomicU32::new(0);
        let turn = move |list: &mut Vec<Pair>, _: &[Aabb]| {
            let call = calls.fetch_add(1, Ordering::Relaxed) as usize;
            let len = list.len();
            list.rotate_left(call.min(len));
        };
        assert!(verdict(turn).contains("another one"));
    }
}
