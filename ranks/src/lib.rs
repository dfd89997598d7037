//! The transport of [`dcd_ranks`] on MPI.
//!
//! ```no_run
//! let mpi = dcd_mpi::Mpi::start().expect("MPI had been started before");
//! # use dcd_ranks::Transport;
//! println!("rank {} of {}", mpi.rank(), mpi.size());
//! ```
//!
//! Deliberately absent: cutting, ghosts, the step (`dcd-ranks`).
#![forbid(unsafe_code)]

use dcd_ranks::{Traffic, Transport};
use mpi::Threading;
use mpi::collective::SystemOperation;
use mpi::datatype::PartitionMut;
use mpi::environment::Universe;
use mpi::topology::SimpleCommunicator;
use mpi::traits::{Communicator, CommunicatorCollectives, Destination, Root, Source};
use std::cell::Cell;
use std::panic;

/// A process under MPI. MPI ends when it is dropped.
pub struct Mpi {
    world: SimpleCommunicator,
    traffic: Cell<Traffic>,
    piece: usize,
    _universe: Universe,
}

/// A message is sent in pieces of at most so many bytes: MPI counts in i32.
const PIECE: usize = 1 << 30;

impl Mpi {
    /// Starts MPI; nothing if it has been started before. From now on a panic on any thread ends all ranks with its
    /// message: the others would wait for this one without end.
    pub fn start() -> Option<Self> {
        // Worker threads never speak to MPI.
        let (universe, _) = mpi::initialize_with_threading(Threading::Funneled)?;
        let report = panic::take_hook();
        panic::set_hook(Box::new(move |what| {
            report(what);
            SimpleCommunicator::world().abort(101);
        }));
        Some(Self {
            world: universe.world(),
            traffic: Cell::default(),
            piece: PIECE,
            _universe: universe,
        })
    }

    /// The same with messages in pieces of at most so many bytes, at least one a rank: for tests.
    #[doc(hidden)]
    pub fn in_pieces_of(self, bytes: usize) -> Self {
        Self { piece: bytes.clamp(self.size(), PIECE), ..self }
    }

    /// Ends all ranks with an exit code.
    pub fn abort(&self, code: i32) -> ! {
        self.world.abort(code)
    }

    /// How many ranks run on this rank's machine, sharing its memory. Collective.
    pub fn neighbours(&self) -> usize {
        self.world.split_shared(0).size() as usize
    }

    /// How many bytes come from each rank, if so many go to each.
    fn lengths(&self, own: &[u64]) -> Vec<u64> {
        let mut lengths = vec![0; self.size()];
        self.world.all_to_all_into(own, &mut lengths[..]);
        lengths
    }
}

impl Transport for Mpi {
    fn rank(&self) -> usize {
        self.world.rank() as usize
    }

    fn size(&self) -> usize {
        self.world.size() as usize
    }

    fn exchange(&self, messages: Vec<(usize, Vec<u8>)>) -> Vec<(usize, Vec<u8>)> {
        let me = self.rank();
        let mut own = vec![0; self.size()];
        messages.iter().for_each(|(to, message)| own[*to] = message.len() as u64);
        let lengths = self.lengths(&own);
        let (to_self, messages): (Vec<_>, Vec<_>) =
            messages.into_iter().partition(|(to, _)| *to == me);
        let froms = lengths.iter().enumerate().filter(|&(from, &length)| from != me && length > 0);
        let mut incoming: Vec<(usize, Vec<u8>)> =
            froms.map(|(from, &length)| (from, vec![0; length as usize])).collect();
        let mut traffic = self.traffic.get();
        traffic.sent += messages.iter().map(|(_, message)| message.len() as u64).sum::<u64>();
        traffic.received += incoming.iter().map(|(_, message)| message.len() as u64).sum::<u64>();
        self.traffic.set(traffic);
        // Pieces from one rank arrive in the order in which they were sent.
        let pieces = |length: usize| length.div_ceil(self.piece);
        let all = messages.iter().chain(&incoming);
        let count = all.map(|(_, message)| pieces(message.len())).sum();
        mpi::request::multiple_scope(count, |scope, requests| {
            for (from, message) in &mut incoming {
                let source = self.world.process_at_rank(*from as i32);
                for piece in message.chunks_mut(self.piece) {
                    requests.add(source.immediate_receive_into(scope, piece));
                }
            }
            for (to, message) in &messages {
                let destination = self.world.process_at_rank(*to as i32);
                for piece in message.chunks(self.piece) {
                    requests.add(destination.immediate_send(scope, piece));
                }
            }
            requests.wait_all(&mut Vec::new());
        });
        incoming.extend(to_self.into_iter().filter(|(_, message)| !message.is_empty()));
        incoming.sort_unstable_by_key(|(from, _)| *from);
        incoming
    }

    fn all_gather(&self, own: &[u8]) -> Vec<Vec<u8>> {
        let mut lengths = vec![0u64; self.size()];
        self.world.all_gather_into(&(own.len() as u64), &mut lengths[..]);
        let mut all: Vec<Vec<u8>> =
            lengths.iter().map(|&length| Vec::with_capacity(length as usize)).collect();
        // In rounds, so that all that is on the way is counted by an i32.
        let share = self.piece / self.size();
        let longest = lengths.iter().max().map_or(0, |&length| length as usize);
        for start in (0..longest).step_by(share) {
            let part = |length: usize| length.min(start + share) - length.min(start);
            let counts: Vec<i32> =
                lengths.iter().map(|&length| part(length as usize) as i32).collect();
            let places: Vec<i32> = counts
                .iter()
                .scan(0, |end, &count| {
                    *end += count;
                    Some(*end - count)
                })
                .collect();
            let mut received = vec![0u8; counts.iter().map(|&count| count as usize).sum()];
            let mut partition = PartitionMut::new(&mut received[..], &counts[..], &places[..]);
            let piece = &own[own.len().min(start)..own.len().min(start + share)];
            self.world.all_gather_varcount_into(piece, &mut partition);
            for ((bytes, &count), &place) in all.iter_mut().zip(&counts).zip(&places) {
                bytes.extend_from_slice(&received[place as usize..(place + count) as usize]);
            }
        }
        all
    }

    fn sum(&self, numbers: &mut [u64]) {
        let own = numbers.to_vec();
        self.world.all_reduce_into(&own[..], numbers, SystemOperation::sum());
    }

    fn chain(&self, first: u64, pass: impl FnOnce(u64) -> u64) -> u64 {
        let (rank, last) = (self.world.rank(), self.world.size() - 1);
        let given =
            if rank == 0 { first } else { self.world.process_at_rank(rank - 1).receive::<u64>().0 };
        let mut made = pass(given);
        if rank < last {
            self.world.process_at_rank(rank + 1).send(&made);
        }
        self.world.process_at_rank(last).broadcast_into(&mut made);
        made
    }

    fn traffic(&self) -> Traffic {
        self.traffic.get()
    }
}
