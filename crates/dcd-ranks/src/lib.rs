//! One scene over many ranks.
//!
//! The world is a grid of cells, numbered along a Morton curve; a rank's region is an interval of that
//! numbering ([`Cuts`]). A rank owns the objects whose boxes' middles lie in its region, and has a copy, a
//! ghost, of every other whose box reaches into it. Each runs the ordinary step on what it has; a pair is
//! reported by the rank whose region holds the lower corner of the two boxes' intersection, so by exactly
//! one, which has both. A wall as large as the world is a ghost everywhere, and its pairs are found where
//! they are.
//!
//! A [`Transport`] carries the messages. [`threads::run`] makes the ranks threads of one process; the crate
//! `dcd-mpi` makes them processes.
//!
//! Every function that takes a [`Transport`] is collective: all ranks call it, in the same order.
//!
//! Deliberately absent: MPI, files (of `dcd-io` it takes the bytes of a shape), clocks but for the caller's.
#![forbid(unsafe_code)]

mod balance;
mod contacts;
mod cuts;
mod error;
mod ghosts;
mod grid;
mod local;
mod share;
mod step;
pub mod threads;
mod transport;
mod wire;

pub use balance::{Load, cut};
pub use contacts::{SortedContacts, digest, gather_contacts, sort_contacts};
pub use cuts::Cuts;
pub use error::RankError;
pub use grid::Grid;
pub use share::{Body, Share};
pub use step::{RankScene, RankStep};
pub use transport::{Traffic, Transport};

/// The guide's page, whose code is compiled and run.
#[cfg(doctest)]
mod guide {
    #[doc = include_str!("../../../docs/guide/beyond-one-machine.md")]
    mod beyond_one_machine {}
}
