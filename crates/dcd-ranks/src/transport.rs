//! What carries messages between ranks.

/// Bytes of messages, those to itself apart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Traffic {
    /// Given away.
    pub sent: u64,
    /// Come in.
    pub received: u64,
}

/// One of some ranks that exchange messages. Each method is collective, but for those that say otherwise: all
/// ranks call it, in the same order.
///
/// A rank that is lost loses all: whoever waits for it does not come back. An implementation ends the
/// program with a message instead.
pub trait Transport {
    /// Which of them this is, below [`Transport::size`]. Not collective.
    fn rank(&self) -> usize;

    /// How many there are, at least 1. Not collective.
    fn size(&self) -> usize;

    /// Delivers messages, one for each destination at most, to itself as well. Returns those for this rank
    /// that are not empty, each with its sender, the senders ascending.
    fn exchange(&self, messages: Vec<(usize, Vec<u8>)>) -> Vec<(usize, Vec<u8>)>;

    /// What each rank gives, by rank. For little.
    fn all_gather(&self, own: &[u8]) -> Vec<Vec<u8>>;

    /// Replaces each number by its sum over all ranks, which give equally many.
    fn sum(&self, numbers: &mut [u64]);

    /// `pass` on rank 0 is given `first`, on every other what it returned on the rank before. Returns what it
    /// returned on the last rank.
    fn chain(&self, first: u64, pass: impl FnOnce(u64) -> u64) -> u64;

    /// The bytes that have gone through [`Transport::exchange`] so far. Not collective.
    fn traffic(&self) -> Traffic;
}
