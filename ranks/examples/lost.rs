//! One rank panics while the others wait for its message: MPI ends them all. For the test.

use dcd_mpi::Mpi;
use dcd_ranks::Transport;

fn main() {
    let mpi = Mpi::start().expect("MPI starts once");
    assert!(mpi.rank() != 1, "rank 1 is lost");
    let got = mpi.exchange(vec![(1, vec![0])]);
    println!("rank {} goes on with {} messages", mpi.rank(), got.len());
}
