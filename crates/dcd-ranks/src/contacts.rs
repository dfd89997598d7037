//! All contacts in one order, over all ranks.

use crate::{RankError, Transport};
use std::ops::Range;

/// The part of the sorted contacts that this rank has; the parts of all ranks, by rank, are all of them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SortedContacts {
    /// By name, the smaller first; sorted.
    pub contacts: Vec<[u64; 2]>,
    /// Which of all contacts they are.
    pub places: Range<u64>,
    /// How many there are on all ranks.
    pub total: u64,
}

/// For each rank so many contacts are drawn, from which the ranks' parts are cut. More: parts that are more
/// alike.
const DRAWN_A_RANK: usize = 64;

/// Bytes of a contact in a message.
const CONTACT_BYTES: usize = 16;

/// Sorts the contacts of all ranks: equal parts but for some per cent, in the order of the ranks.
pub fn sort_contacts(transport: &impl Transport, mut own: Vec<[u64; 2]>) -> SortedContacts {
    own.sort_unstable();
    let size = transport.size();
    let drawn =
        (0..DRAWN_A_RANK.min(own.len())).map(|k| own[k * own.len() / DRAWN_A_RANK.min(own.len())]);
    let drawn: Vec<[u64; 2]> = drawn.collect();
    let mut splitters: Vec<[u64; 2]> =
        transport.all_gather(&bytes(&drawn)).iter().flat_map(|given| contacts(given)).collect();
    splitters.sort_unstable();
    // The first contact of each rank but the first.
    let splitter = |rank: usize| splitters.get(rank * splitters.len() / size);
    let start = |rank: usize| match splitter(rank) {
        Some(first) if rank > 0 => own.partition_point(|contact| contact < first),
        _ if rank > 0 => own.len(),
        _ => 0,
    };
    let end = |rank: usize| if rank + 1 < size { start(rank + 1) } else { own.len() };
    let messages =
        (0..size).map(|rank| (rank, bytes(&own[start(rank)..end(rank).max(start(rank))])));
    let messages: Vec<_> = messages.filter(|(_, message)| !message.is_empty()).collect();
    drop(own);
    let mut sorted: Vec<[u64; 2]> = Vec::new();
    for (_, message) in transport.exchange(messages) {
        sorted.extend(contacts(&message));
    }
    // Sorted runs, one after the other: what a merge sort is best at.
    sorted.sort();
    let counts = transport.all_gather(&(sorted.len() as u64).to_le_bytes());
    let counts: Vec<u64> =
        counts.into_iter().map(|count| count.try_into().map_or(0, u64::from_le_bytes)).collect();
    let first: u64 = counts[..transport.rank()].iter().sum();
    let places = first..first + sorted.len() as u64;
    SortedContacts { contacts: sorted, places, total: counts.iter().sum() }
}

/// All contacts in order, on every rank: for as many as one memory holds.
pub fn gather_contacts(transport: &impl Transport, sorted: &SortedContacts) -> Vec<[u64; 2]> {
    transport.all_gather(&bytes(&sorted.contacts)).iter().flat_map(|part| contacts(part)).collect()
}

/// 64-bit FNV-1a (Fowler, Noll, Vo) of all contacts in order, each as two u32, little endian: its state goes from
/// rank to rank.
///
/// # Errors
/// On all ranks: a name that no u32 holds.
pub fn digest(transport: &impl Transport, sorted: &SortedContacts) -> Result<u64, RankError> {
    let large = sorted.contacts.as_flattened().iter().find(|&&name| u32::try_from(name).is_err());
    let checked = large.map_or(Ok(()), |&name| Err(RankError::Name { name }));
    crate::share::agree(transport, checked)?;
    Ok(transport.chain(0xcbf2_9ce4_8422_2325, |state| {
        let names = sorted.contacts.as_flattened().iter();
        // The lower half, little endian: the upper one is 0.
        let bytes = names.flat_map(|name| name.to_le_bytes().into_iter().take(4));
        bytes.fold(state, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3))
    }))
}

fn bytes(contacts: &[[u64; 2]]) -> Vec<u8> {
    contacts.as_flattened().iter().flat_map(|name| name.to_le_bytes()).collect()
}

fn contacts(bytes: &[u8]) -> impl Iterator<Item = [u64; 2]> {
    let number = |half: &[u8]| half.try_into().map_or(0, u64::from_le_bytes);
    bytes.chunks_exact(CONTACT_BYTES).map(move |contact| {
        let (i, j) = contact.split_at(8);
        [number(i), number(j)]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::threads;

    fn drawn(count: u64) -> Vec<[u64; 2]> {
        let number = |k: u64| k.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 44;
        (0..count).map(|k| [number(k), (1 << 20) + number(k + count)]).collect()
    }

    #[test]
    fn parts_are_sorted_and_follow_each_other() {
        for (count, size) in [(0, 3), (1, 4), (2, 8), (5000, 1), (5000, 7), (300, 64)] {
            let all = drawn(count);
            let parts = threads::run(size, |rank| {
                // All on the last rank, or dealt out.
                let own = |k: usize| if count == 300 { size - 1 } else { k * k % size };
                let own = all.iter().enumerate().filter(|(k, _)| own(*k) == rank.rank());
                let sorted = sort_contacts(rank, own.map(|(_, contact)| *contact).collect());
                let mut expected = all.clone();
                expected.sort_unstable();
                assert_eq!(gather_contacts(rank, &sorted), expected);
                let digest = digest(rank, &sorted).unwrap();
                (sorted, digest)
            });
            let mut expected = all.clone();
            expected.sort_unstable();
            let joined: Vec<_> = parts.iter().flat_map(|(part, _)| part.contacts.clone()).collect();
            assert_eq!(joined, expected);
            let mut next = 0;
            for (part, _) in &parts {
                assert_eq!(part.places, next..next + part.contacts.len() as u64);
                assert_eq!(part.total, count);
                next = part.places.end;
            }
            let alone =
                threads::run(1, |rank| digest(rank, &sort_contacts(rank, all.clone())).unwrap());
            assert!(parts.iter().all(|(_, digest)| *digest == alone[0]));
        }
    }

    #[test]
    fn the_digest_is_the_published_fnv1a() {
        let of = |contacts: Vec<[u64; 2]>| {
            threads::run(1, |rank| digest(rank, &sort_contacts(rank, contacts.clone())))[0].clone()
        };
        assert_eq!(of(vec![]), Ok(0xcbf2_9ce4_8422_2325));
        let letters = |text: [u8; 4]| u64::from(u32::from_le_bytes(text));
        // FNV-1a of "foobarba", by its definition.
        let slowly = b"foobarba".iter().fold(0xcbf2_9ce4_8422_2325u64, |hash, &byte| {
            (hash ^ u64::from(byte)).wrapping_mul(1_099_511_628_211)
        });
        assert_eq!(of(vec![[letters(*b"foob"), letters(*b"arba")]]), Ok(slowly));
    }

    #[test]
    fn a_name_that_no_file_holds_is_refused_on_all_ranks() {
        let refused = threads::run(2, |rank| {
            let own = if rank.rank() == 1 { vec![[1, 1 << 40]] } else { vec![[1, 2]] };
            digest(rank, &sort_contacts(rank, own)).is_err()
        });
        assert_eq!(refused, [true, true]);
    }
}
