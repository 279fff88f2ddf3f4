//! Trials of an exchange, for tests that must find a wrong one and benches of a slow one. Only this file reads the environment
//! variable `LODESTAR_EXCHANGE`.
//!
//! With `lose@N`, the sums of rank N are lost on the way to all ranks. With `double@N`, they are added twice. With `delay@N`, every
//! addition of sums takes N microseconds longer.

use std::sync::Arc;
use std::thread;
use std::time::Duration;

use crate::Result;
use crate::fleet::exchange::{Exchange, Kind};
use crate::fleet::sums::Sums;

/// Environment variable that says what the exchange does besides.
const VARIABLE: &str = "LODESTAR_EXCHANGE";

/// What an exchange does besides.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Trial {
    /// The sums of this rank are lost.
    Lose(usize),
    /// The sums of this rank are added twice.
    Double(usize),
    /// Every addition takes so much longer.
    Delay(Duration),
}

impl Trial {
    fn parse(text: &str) -> Option<Self> {
        let (name, number) = text.split_once('@')?;
        match name {
            "lose" => number.parse().ok().map(Self::Lose),
            "double" => number.parse().ok().map(Self::Double),
            "delay" => number.parse().ok().map(Duration::from_micros).map(Self::Delay),
            _ => None,
        }
    }

    /// The exchange with the trial that the environment variable names, if it names one.
    pub(super) fn from_environment(exchange: Arc<dyn Exchange>) -> Arc<dyn Exchange> {
        match std::env::var(VARIABLE).ok().and_then(|text| Self::parse(&text)) {
            Some(trial) => trial.on(exchange),
            None => exchange,
        }
    }

    /// The exchange with this trial.
    pub fn on(self, exchange: Arc<dyn Exchange>) -> Arc<dyn Exchange> {
        Arc::new(Tried { exchange, trial: self })
    }
}

struct Tried {
    exchange: Arc<dyn Exchange>,
    trial: Trial,
}

impl Exchange for Tried {
    fn rank(&self) -> usize {
        self.exchange.rank()
    }

    fn ranks(&self) -> usize {
        self.exchange.ranks()
    }

    fn local_rank(&self) -> usize {
        self.exchange.local_rank()
    }

    fn machine(&self) -> String {
        self.exchange.machine()
    }

    fn send(&self, to: usize, kind: Kind, bytes: &[u8]) -> Result<()> {
        self.exchange.send(to, kind, bytes)
    }

    fn try_receive(&self, from: usize, kind: Kind) -> Result<Option<Vec<u8>>> {
        self.exchange.try_receive(from, kind)
    }

    fn add(&self, sums: &mut Sums) -> Result<()> {
        match self.trial {
            Trial::Lose(rank) if rank == self.rank() => {
                sums.targets.fill(0);
                sums.counts.fill(0);
            }
            Trial::Double(rank) if rank == self.rank() => sums.add(&sums.clone()),
            Trial::Lose(_) | Trial::Double(_) => {}
            Trial::Delay(time) => thread::sleep(time),
        }
        self.exchange.add(sums)
    }

    fn is_ending(&self) -> bool {
        self.exchange.is_ending()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trial_has_a_name_and_a_number() {
        assert_eq!(Trial::parse("lose@2"), Some(Trial::Lose(2)));
        assert_eq!(Trial::parse("double@0"), Some(Trial::Double(0)));
        assert_eq!(Trial::parse("delay@1500"), Some(Trial::Delay(Duration::from_micros(1500))));
        assert!(["", "lose", "lose@", "lose@-1", "keep@1"].iter().all(|text| Trial::parse(text).is_none()));
    }
}
