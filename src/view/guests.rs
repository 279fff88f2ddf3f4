//! Everybody who is connected. Strangers make room for others; holders of the token stay.

use std::collections::HashMap;
use std::net::{IpAddr, Ipv6Addr};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::task::AbortHandle;

use crate::view::limits::Limits;

/// Network from which a stranger comes: an IPv4 address, or the 64 bits of an IPv6 address that one person has.
type Network = IpAddr;

/// Everybody who is connected.
pub struct Guests {
    limits: Limits,
    crowd: Mutex<Crowd>,
}

#[derive(Default)]
struct Crowd {
    next: u64,
    /// Strangers, the one that was silent for longest first.
    strangers: Vec<Stranger>,
    holders: usize,
}

struct Stranger {
    number: u64,
    network: Network,
    connection: AbortHandle,
}

/// One connection. It leaves when this is dropped.
pub struct Visit {
    guests: Arc<Guests>,
    number: u64,
    /// Number of requests before the token was shown.
    requests: AtomicUsize,
    is_holder: AtomicBool,
}

impl Guests {
    pub fn new(limits: Limits) -> Arc<Self> {
        Arc::new(Self { limits, crowd: Mutex::default() })
    }

    fn crowd(&self) -> MutexGuard<'_, Crowd> {
        self.crowd.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Lets a stranger in. `attend` begins the connection's task. Where there is no room, another stranger leaves: the one of the
    /// same network, or of the network with the most strangers, that was silent for longest.
    pub fn enter(self: &Arc<Self>, address: IpAddr, attend: impl FnOnce(Visit) -> AbortHandle) {
        let network = network(address);
        let number = self.crowd().make_room(network, self.limits);
        let (requests, is_holder) = (AtomicUsize::new(0), AtomicBool::new(false));
        let connection = attend(Visit { guests: Arc::clone(self), number, requests, is_holder });
        // The task has not run yet, because the server has one thread.
        self.crowd().strangers.push(Stranger { number, network, connection });
    }

    /// Sends a stranger away, if there is one.
    pub fn send_one_away(&self) {
        self.crowd().send_one_away();
    }

    /// Sends all strangers away.
    pub fn send_strangers_away(&self) {
        self.crowd().strangers.drain(..).for_each(|stranger| stranger.connection.abort());
    }

    /// Number of connections that have shown the token.
    pub fn holders(&self) -> usize {
        self.crowd().holders
    }
}

impl Crowd {
    /// Makes room for a stranger. Returns the stranger's number.
    fn make_room(&mut self, network: Network, limits: Limits) -> u64 {
        let neighbors = self.strangers.iter().filter(|stranger| stranger.network == network).count();
        if neighbors >= limits.strangers_of_address {
            self.send_away(network);
        }
        if self.strangers.len() >= limits.strangers {
            self.send_one_away();
        }
        self.next += 1;
        self.next
    }

    fn send_one_away(&mut self) {
        let mut counts: HashMap<Network, usize> = HashMap::new();
        self.strangers.iter().for_each(|stranger| *counts.entry(stranger.network).or_default() += 1);
        // Of several networks with the most strangers, that of the stranger who has been silent for longest.
        let most = counts.values().max().copied().unwrap_or(0);
        let network = self.strangers.iter().map(|stranger| stranger.network).find(|network| counts[network] == most);
        network.into_iter().for_each(|network| self.send_away(network));
    }

    fn send_away(&mut self, network: Network) {
        if let Some(at) = self.strangers.iter().position(|stranger| stranger.network == network) {
            self.strangers.remove(at).connection.abort();
        }
    }

    fn position(&self, number: u64) -> Option<usize> {
        self.strangers.iter().position(|stranger| stranger.number == number)
    }
}

impl Visit {
    /// Notes that the connection has sent a request without the token. Returns how many it has sent.
    pub fn ask_as_stranger(&self) -> usize {
        if self.is_holder.load(Ordering::Relaxed) {
            return 0;
        }
        let mut crowd = self.guests.crowd();
        if let Some(at) = crowd.position(self.number) {
            let stranger = crowd.strangers.remove(at);
            crowd.strangers.push(stranger);
        }
        self.requests.fetch_add(1, Ordering::Relaxed) + 1
    }

    /// Notes that the connection has shown the token. Returns whether it may be kept: there may be too many.
    pub fn show_token(&self) -> bool {
        if self.is_holder.load(Ordering::Relaxed) {
            return true;
        }
        let mut crowd = self.guests.crowd();
        let Some(at) = crowd.position(self.number) else { return false };
        let has_room = crowd.holders < self.guests.limits.holders;
        if has_room {
            crowd.strangers.remove(at);
            crowd.holders += 1;
            self.is_holder.store(true, Ordering::Relaxed);
        }
        has_room
    }
}

impl Drop for Visit {
    fn drop(&mut self) {
        let mut crowd = self.guests.crowd();
        if self.is_holder.load(Ordering::Relaxed) {
            crowd.holders -= 1;
        } else if let Some(at) = crowd.position(self.number) {
            crowd.strangers.remove(at);
        }
    }
}

fn network(address: IpAddr) -> Network {
    match address.to_canonical() {
        IpAddr::V4(address) => address.into(),
        IpAddr::V6(address) => Ipv6Addr::from_bits(address.to_bits() & (u128::MAX << 64)).into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: Limits = Limits { strangers: 5, strangers_of_address: 3, holders: 2, listeners: 1 };

    /// Guests whose connections do nothing. Returns them with a function that lets one in.
    fn guests(runtime: &tokio::runtime::Runtime) -> (Arc<Guests>, impl Fn(&str) -> Arc<Visit>) {
        let guests = Guests::new(LIMITS);
        let (entered, handle) = (Arc::clone(&guests), runtime.handle().clone());
        let enter = move |address: &str| {
            let mut visits = Vec::new();
            entered.enter(address.parse().unwrap(), |visit| {
                visits.push(Arc::new(visit));
                handle.spawn(std::future::pending::<()>()).abort_handle()
            });
            visits.remove(0)
        };
        (guests, enter)
    }

    fn runtime() -> tokio::runtime::Runtime {
        tokio::runtime::Builder::new_current_thread().build().unwrap()
    }

    /// Numbers of the strangers.
    fn strangers(guests: &Guests) -> Vec<u64> {
        guests.crowd().strangers.iter().map(|stranger| stranger.number).collect()
    }

    #[test]
    fn whoever_was_silent_for_longest_makes_room() {
        let runtime = runtime();
        let (guests, enter) = guests(&runtime);
        let visits: Vec<_> = ["10.0.0.1", "10.0.0.1", "10.0.0.2", "10.0.0.1"].map(&enter).into();
        assert_eq!(strangers(&guests), [1, 2, 3, 4]);
        visits[0].ask_as_stranger();
        let fifth = enter("::ffff:10.0.0.1");
        assert_eq!(strangers(&guests), [3, 4, 1, 5], "one of the same address has left");
        let others = ["10.0.0.3", "10.0.0.4", "10.0.0.5"].map(&enter);
        assert_eq!(strangers(&guests), [3, 5, 6, 7, 8], "the address with the most has left twice");
        assert!(!visits[1].show_token() && guests.holders() == 0, "whoever has left holds nothing");
        drop((visits, fifth, others));
        assert!(strangers(&guests).is_empty());
    }

    #[test]
    fn addresses_of_one_person_count_as_one() {
        let runtime = runtime();
        let (guests, enter) = guests(&runtime);
        let _visits: Vec<_> = (0..5).map(|host| enter(&format!("2001:db8::{host}"))).collect();
        assert_eq!(strangers(&guests), [3, 4, 5]);
        let _other = enter("2001:db8:0:1::1");
        assert_eq!(strangers(&guests), [3, 4, 5, 6]);
    }

    #[test]
    fn holders_make_room_for_nobody() {
        let runtime = runtime();
        let (guests, enter) = guests(&runtime);
        let visits = [enter("10.0.0.1"), enter("10.0.0.1"), enter("10.0.0.1")];
        assert_eq!(visits.each_ref().map(|visit| visit.show_token()), [true, true, false]);
        assert!(visits[0].show_token(), "the second request of a holder");
        let _flood: Vec<_> = (0..100).map(|_| enter("10.0.0.1")).collect();
        assert_eq!((guests.holders(), strangers(&guests).len()), (2, 3));
        drop(visits);
        assert_eq!(guests.holders(), 0);
    }
}
