//! The exchange between ranks: the only thing that the ranks of a render need from the machines that they run on.
//!
//! A rank is a process, or in tests a thread, that renders a share of the film. Messages go between the first rank and the others.
//! Sums are added over all ranks at once.

use crate::Result;
use crate::fleet::sums::Sums;

/// Kinds of messages.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Kind {
    /// The first rank names the next work.
    Command,
    /// The first rank ends the work under way.
    Stop,
    /// A rank tells the first one what it has done.
    Report,
    /// The first rank answers the reports of all ranks.
    Answer,
}

/// Connection of one rank to the others. Messages of one kind from one rank arrive in the order in which they were sent.
pub trait Exchange: Send + Sync {
    /// Number of this rank. The first one, 0, leads.
    fn rank(&self) -> usize;

    /// Number of ranks.
    fn ranks(&self) -> usize;

    /// Number of this rank among those of its machine.
    fn local_rank(&self) -> usize;

    /// Name of this rank's machine.
    fn machine(&self) -> String;

    /// Sends a message to a rank.
    ///
    /// # Errors
    /// [`crate::Error::RankLost`].
    fn send(&self, to: usize, kind: Kind, bytes: &[u8]) -> Result<()>;

    /// Receives a message that has arrived from a rank, if there is one.
    ///
    /// # Errors
    /// [`crate::Error::RankLost`].
    fn try_receive(&self, from: usize, kind: Kind) -> Result<Option<Vec<u8>>>;

    /// Replaces the sums of every rank by the sums of all. All ranks call it.
    ///
    /// # Errors
    /// [`crate::Error::RankLost`].
    fn add(&self, sums: &mut Sums) -> Result<()>;

    /// Whether whoever has started the ranks is ending them, so that a rank which does not answer is lost.
    fn is_ending(&self) -> bool;
}
