//! Messages in pieces of 777 bytes arrive whole, from and to every rank. For the test.

use dcd_mpi::Mpi;
use dcd_ranks::{Traffic, Transport};

/// What goes from one rank to another: longer with each, and not a number of pieces.
fn message(from: usize, to: usize) -> Vec<u8> {
    (0..10_000 + 100 * from + to).map(|k| (k * (3 + from) + to) as u8).collect()
}

fn main() {
    let mpi = Mpi::start().expect("MPI starts once").in_pieces_of(777);
    let (rank, size) = (mpi.rank(), mpi.size());
    let got = mpi.exchange((0..size).map(|to| (to, message(rank, to))).collect());
    assert_eq!(got, (0..size).map(|from| (from, message(from, rank))).collect::<Vec<_>>());
    let others = (0..size).filter(|&other| other != rank);
    let (sent, received) = others.fold((0, 0), |(sent, received), other| {
        (sent + message(rank, other).len() as u64, received + message(other, rank).len() as u64)
    });
    assert_eq!(mpi.traffic(), Traffic { sent, received });
    let gathered = mpi.all_gather(&message(rank, 0)[..1000 * rank]);
    let due: Vec<Vec<u8>> =
        (0..size).map(|from| message(from, 0)[..1000 * from].to_vec()).collect();
    assert_eq!(gathered, due);
    let mut numbers = [rank as u64, 1];
    mpi.sum(&mut numbers);
    assert_eq!(numbers, [(size * (size - 1) / 2) as u64, size as u64]);
    assert_eq!(mpi.chain(1, |before| 2 * before), 1 << size);
    println!("whole");
}
