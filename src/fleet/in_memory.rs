//! An exchange between threads of one process, for tests of ranks without other processes.

use std::collections::{HashMap, VecDeque};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use crate::fleet::exchange::{Exchange, Kind};
use crate::fleet::sums::Sums;
use crate::{Error, Result};

/// One rank's end of an exchange in memory.
pub struct InMemory {
    rank: usize,
    shared: Arc<Shared>,
}

struct Shared {
    ranks: usize,
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Default)]
struct State {
    messages: HashMap<(usize, usize, Kind), VecDeque<Vec<u8>>>,
    /// Sums of the round under way, and the number of ranks that have added theirs.
    round: Sums,
    added: usize,
    /// Sums of the last round that is complete, and the number of rounds.
    total: Sums,
    rounds: usize,
    /// Ranks that have ended.
    ended: Vec<usize>,
}

impl InMemory {
    /// Exchanges of so many ranks, the first rank's first.
    pub fn new(ranks: usize) -> Vec<Self> {
        let shared = Arc::new(Shared { ranks, state: Mutex::default(), changed: Condvar::new() });
        (0..ranks).map(|rank| Self { rank, shared: Arc::clone(&shared) }).collect()
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.shared.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn lost(rank: usize) -> Error {
    Error::RankLost { rank: format!("rank {rank}"), note: String::new() }
}

impl Exchange for InMemory {
    fn rank(&self) -> usize {
        self.rank
    }

    fn ranks(&self) -> usize {
        self.shared.ranks
    }

    fn local_rank(&self) -> usize {
        self.rank
    }

    fn machine(&self) -> String {
        "this process".into()
    }

    fn send(&self, to: usize, kind: Kind, bytes: &[u8]) -> Result<()> {
        let mut state = self.state();
        state.messages.entry((self.rank, to, kind)).or_default().push_back(bytes.to_vec());
        Ok(())
    }

    fn try_receive(&self, from: usize, kind: Kind) -> Result<Option<Vec<u8>>> {
        let mut state = self.state();
        let arrived = state.messages.get_mut(&(from, self.rank, kind)).and_then(VecDeque::pop_front);
        match arrived {
            None if state.ended.contains(&from) => Err(lost(from)),
            arrived => Ok(arrived),
        }
    }

    fn add(&self, sums: &mut Sums) -> Result<()> {
        let mut state = self.state();
        let round = state.rounds;
        match state.added {
            0 => state.round = sums.clone(),
            _ => state.round.add(sums),
        }
        state.added += 1;
        if state.added == self.shared.ranks {
            (state.total, state.added, state.rounds) = (std::mem::take(&mut state.round), 0, round + 1);
            self.shared.changed.notify_all();
        }
        while state.rounds == round {
            if let Some(&rank) = state.ended.first() {
                return Err(lost(rank));
            }
            state = self.shared.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        sums.clone_from(&state.total);
        Ok(())
    }

    fn is_ending(&self) -> bool {
        false
    }
}

impl Drop for InMemory {
    fn drop(&mut self) {
        self.state().ended.push(self.rank);
        self.shared.changed.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::thread;

    #[test]
    fn every_rank_gets_the_sums_of_all() {
        let add = |exchange: InMemory| {
            let number = exchange.rank() as u64;
            // The totals of a round must not be those of the next one.
            let rounds = (0..50).map(|round| {
                let mut sums = Sums {
                    targets: vec![u64::MAX, number * round],
                    counts: vec![1],
                    marks: vec![1 << number],
                    flux: vec![],
                };
                exchange.add(&mut sums).unwrap();
                sums
            });
            (rounds.collect::<Vec<_>>(), exchange)
        };
        let threads: Vec<_> =
            InMemory::new(3).into_iter().map(|exchange| thread::spawn(move || add(exchange))).collect();
        let done: Vec<_> = threads.into_iter().map(|thread| thread.join().unwrap()).collect();
        for (rounds, _) in &done {
            for (round, sums) in (0..).zip(rounds) {
                let expected =
                    Sums { targets: vec![u64::MAX - 2, 3 * round], counts: vec![3], marks: vec![7], flux: vec![] };
                assert_eq!(*sums, expected);
            }
        }
    }

    #[test]
    fn a_rank_that_has_ended_is_named() {
        let mut ranks = InMemory::new(3);
        let last = ranks.pop().unwrap();
        last.send(0, Kind::Report, &[7]).unwrap();
        drop(last);
        assert_eq!(ranks[0].try_receive(2, Kind::Report).unwrap(), Some(vec![7]), "messages before the end arrive");
        for error in
            [ranks[0].try_receive(2, Kind::Report).unwrap_err(), ranks[1].add(&mut Sums::default()).unwrap_err()]
        {
            assert_eq!(error.to_string(), "rank 2 does not answer any more");
        }
    }
}
