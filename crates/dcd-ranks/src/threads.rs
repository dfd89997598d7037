//! Ranks as threads of one process: for tests, and to see how a scene is cut without MPI.

use crate::{Traffic, Transport};
use std::cell::Cell;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;

/// A rank that is a thread.
#[derive(Debug)]
pub struct ThreadRank {
    rank: usize,
    /// To each rank, this one too.
    to: Vec<Sender<Vec<u8>>>,
    /// From each rank.
    from: Vec<Receiver<Vec<u8>>>,
    traffic: Cell<Traffic>,
}

/// Runs `work` once for each of so many ranks, each on a thread of its own. What they return, by rank.
///
/// # Panics
/// Where one of them does.
pub fn run<T: Send>(size: usize, work: impl Fn(&ThreadRank) -> T + Sync) -> Vec<T> {
    let ranks = ThreadRank::connected(size);
    let work = &work;
    thread::scope(|scope| {
        let threads: Vec<_> =
            ranks.into_iter().map(|rank| scope.spawn(move || work(&rank))).collect();
        threads.into_iter().map(|thread| thread.join().expect("a rank panicked")).collect()
    })
}

impl ThreadRank {
    fn connected(size: usize) -> Vec<Self> {
        let mut ranks: Vec<Self> = (0..size)
            .map(|rank| Self { rank, to: Vec::new(), from: Vec::new(), traffic: Cell::default() })
            .collect();
        // Sender by sender, so that each receiver's channels ascend by sender.
        for sender in 0..size {
            for receiver in 0..size {
                let (to, from) = channel();
                ranks[sender].to.push(to);
                ranks[receiver].from.push(from);
            }
        }
        ranks
    }

    fn send(&self, to: usize, bytes: Vec<u8>) {
        self.to[to].send(bytes).expect("another rank is gone");
    }

    fn receive(&self, from: usize) -> Vec<u8> {
        self.from[from].recv().expect("another rank is gone")
    }
}

impl Transport for ThreadRank {
    fn rank(&self) -> usize {
        self.rank
    }

    fn size(&self) -> usize {
        self.to.len()
    }

    fn exchange(&self, messages: Vec<(usize, Vec<u8>)>) -> Vec<(usize, Vec<u8>)> {
        let mut outgoing = vec![Vec::new(); self.size()];
        let mut traffic = self.traffic.get();
        for (to, bytes) in messages {
            traffic.sent += if to == self.rank { 0 } else { bytes.len() as u64 };
            outgoing[to] = bytes;
        }
        for (to, bytes) in outgoing.into_iter().enumerate() {
            self.send(to, bytes);
        }
        let mut incoming = Vec::new();
        for from in 0..self.size() {
            let bytes = self.receive(from);
            traffic.received += if from == self.rank { 0 } else { bytes.len() as u64 };
            if !bytes.is_empty() {
                incoming.push((from, bytes));
            }
        }
        self.traffic.set(traffic);
        incoming
    }

    fn all_gather(&self, own: &[u8]) -> Vec<Vec<u8>> {
        (0..self.size()).for_each(|to| self.send(to, own.to_vec()));
        (0..self.size()).map(|from| self.receive(from)).collect()
    }

    fn sum(&self, numbers: &mut [u64]) {
        let own: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        numbers.fill(0);
        for given in self.all_gather(&own) {
            let (given, _) = given.as_chunks();
            numbers.iter_mut().zip(given).for_each(|(sum, &more)| *sum += u64::from_le_bytes(more));
        }
    }

    fn chain(&self, first: u64, pass: impl FnOnce(u64) -> u64) -> u64 {
        let number = |bytes: Vec<u8>| bytes.try_into().map_or(first, u64::from_le_bytes);
        let given = if self.rank == 0 { first } else { number(self.receive(self.rank - 1)) };
        let made = pass(given);
        if self.rank + 1 < self.size() {
            self.send(self.rank + 1, made.to_le_bytes().to_vec());
        }
        let all = self.all_gather(&made.to_le_bytes());
        all.into_iter().next_back().map_or(made, number)
    }

    fn traffic(&self) -> Traffic {
        self.traffic.get()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_arrive_with_their_senders_in_order_and_their_bytes_are_counted() {
        let found = run(4, |rank| {
            let me = rank.rank() as u8;
            let next = (rank.rank() + 1) % rank.size();
            let got = rank.exchange(vec![(next, vec![me; 3]), (rank.rank(), vec![me])]);
            (got, rank.traffic())
        });
        for (me, (got, traffic)) in found.iter().enumerate() {
            let before = (me + 3) % 4;
            let mut expected = vec![(before, vec![before as u8; 3]), (me, vec![me as u8])];
            expected.sort();
            assert_eq!(*got, expected);
            assert_eq!(*traffic, Traffic { sent: 3, received: 3 });
        }
    }

    #[test]
    fn sums_gathers_and_chains_are_the_same_on_all_ranks() {
        let found = run(3, |rank| {
            let mut numbers = [rank.rank() as u64, 10];
            rank.sum(&mut numbers);
            let gathered = rank.all_gather(&[rank.rank() as u8; 2]);
            let chained = rank.chain(7, |before| before * 10 + rank.rank() as u64);
            (numbers, gathered, chained)
        });
        for (numbers, gathered, chained) in found {
            assert_eq!(numbers, [3, 30]);
            assert_eq!(gathered, [[0, 0], [1, 1], [2, 2]]);
            assert_eq!(chained, 7012);
        }
    }
}
