//! The ranks of a render, as one of them sees them. The first rank leads: it names the work, and all decisions are its own.
//!
//! Ranks agree in meetings. Each hands the first rank a report, its result or its failure, and all get the first rank's answer. If one
//! has failed, all leave the work under way with its error. So no rank waits for another one that does something else.

use std::ops::Range;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::thread;
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use crate::fleet::exchange::{Exchange, Kind};
use crate::fleet::failure::{self, Failure};
use crate::fleet::sums::Sums;
use crate::fleet::times::{Clock, Traffic};
use crate::fleet::trial::Trial;
use crate::renderer::Counts;
use crate::{Error, Result};

/// Time in which a rank must answer once the ranks are being ended. Open MPI kills all ranks one second after the first sign.
const GRACE: Duration = Duration::from_millis(500);
/// The command that ends a render.
const END: &[u8] = &[];
/// Longest pause between two looks for a message.
const LONGEST_PAUSE: Duration = Duration::from_millis(1);
/// Looks for a message before the first pause.
const EAGER_LOOKS: u32 = 100;

/// What a rank tells of itself before the render begins.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Member {
    /// Name of the rank's machine.
    pub machine: String,
    /// Number of the rank's process on that machine.
    pub process: u32,
    /// The rank's devices with their drivers.
    pub devices: Vec<String>,
    /// Facts with names in which all ranks must agree.
    pub facts: Vec<(String, String)>,
}

/// The ranks of a render.
pub struct Team {
    exchange: Arc<dyn Exchange>,
    members: Vec<Member>,
    /// Whether a rank has failed in the work under way, so that all have left it.
    is_over: AtomicBool,
    /// Whether the first rank has told the others to stop, or this other rank has heard of it.
    is_stopped: AtomicBool,
    /// The rank that is lost, if one is. No further work is possible then.
    lost: OnceLock<String>,
    /// Time in which the first rank, after its own work, has waited for the others.
    waiting: Clock,
}

impl Team {
    /// Makes the ranks known to each other. `own` is what this rank tells of itself, or the reason why it cannot render.
    ///
    /// # Errors
    /// Where a rank cannot render, or differs from the first one in a fact.
    pub fn gather(exchange: Arc<dyn Exchange>, own: Result<Member>) -> Result<Self> {
        let exchange = Trial::from_environment(exchange);
        let mut team = Self {
            exchange,
            members: Vec::new(),
            is_over: AtomicBool::new(false),
            is_stopped: AtomicBool::new(false),
            lost: OnceLock::new(),
            waiting: Clock::default(),
        };
        let own = own.map(|own| failure::encode(&own));
        let members = team.meet(own, &|| false, |reports| {
            let members: Vec<Member> = reports.iter().map(|report| failure::decode(report)).collect::<Result<_>>()?;
            (0..).zip(&members).try_for_each(|(rank, member)| member.check(rank, &members[0]))?;
            Ok(failure::encode(&members))
        })?;
        team.members = failure::decode(&members)?;
        Ok(team)
    }

    /// Whether this is the first rank.
    pub fn leads(&self) -> bool {
        self.exchange.rank() == 0
    }

    /// Number of ranks.
    pub fn ranks(&self) -> usize {
        self.exchange.ranks()
    }

    /// What the ranks have told of themselves.
    pub fn members(&self) -> &[Member] {
        &self.members
    }

    /// Number of devices of all ranks.
    pub fn device_count(&self) -> usize {
        self.members.iter().map(|member| member.devices.len()).sum()
    }

    /// Indices of a rank's devices among those of all ranks.
    pub(crate) fn devices(&self, rank: usize) -> Range<usize> {
        let before: usize = self.members[..rank].iter().map(|member| member.devices.len()).sum();
        before..before + self.members[rank].devices.len()
    }

    /// Indices of this rank's devices among those of all ranks.
    pub(crate) fn own_devices(&self) -> Range<usize> {
        self.devices(self.exchange.rank())
    }

    /// Seconds in which the first rank, after its own work, has waited for the others.
    pub fn waiting_seconds(&self) -> f64 {
        self.waiting.seconds()
    }

    /// Names the next work to all other ranks.
    pub(super) fn command(&self, bytes: &[u8]) -> Result<()> {
        self.is_over.store(false, Ordering::Relaxed);
        if let Some(rank) = self.lost.get() {
            return Err(Error::RankLost { rank: rank.clone(), note: String::new() });
        }
        (1..self.ranks()).try_for_each(|rank| self.noting_loss(self.exchange.send(rank, Kind::Command, bytes)))
    }

    /// Waits for the next work. Returns none where the render ends.
    pub(super) fn next_command(&self) -> Result<Option<Vec<u8>>> {
        let command = self.receive(0, Kind::Command, &|| {})?;
        self.is_over.store(false, Ordering::Relaxed);
        Ok((command != END).then_some(command))
    }

    /// Ends the work under way: all ranks succeed, or all fail.
    pub(crate) fn close<T>(&self, done: Result<T>) -> Result<T> {
        if self.is_over.load(Ordering::Relaxed) || self.lost.get().is_some() {
            return done;
        }
        match done {
            Ok(done) => self.meet(Ok(Vec::new()), &|| false, |_| Ok(Vec::new())).map(|_| done),
            Err(error) => {
                Err(self.meet(Err(error), &|| false, |_| Ok(Vec::new())).err().unwrap_or_else(nothing_failed))
            }
        }
    }

    /// Whether tracing must stop. The first rank asks `stop` and tells the others, which look for its message.
    pub(super) fn is_to_stop(&self, stop: &dyn Fn() -> bool) -> bool {
        match self.leads() {
            true if stop() => self.tell_stop(),
            true => {}
            false if self.is_stopped.load(Ordering::Relaxed) => {}
            // An exchange that fails here fails in the next meeting, too.
            false => {
                let is_told = !matches!(self.exchange.try_receive(0, Kind::Stop), Ok(None));
                self.is_stopped.store(is_told, Ordering::Relaxed);
            }
        }
        self.is_stopped.load(Ordering::Relaxed)
    }

    /// Tells the other ranks, from the first one, to stop tracing.
    pub(super) fn tell_stop(&self) {
        if self.leads() && !self.is_stopped.swap(true, Ordering::Relaxed) {
            // A rank that cannot be told is missed in the next meeting.
            (1..self.ranks()).for_each(|rank| drop(self.exchange.send(rank, Kind::Stop, &[])));
        }
    }

    /// Hands the first rank what every rank has, and every rank the first one's answer. While the first rank waits for others, it
    /// asks `stop` and tells them.
    pub(super) fn meet(
        &self,
        own: Result<Vec<u8>>,
        stop: &dyn Fn() -> bool,
        answer: impl FnOnce(Vec<Vec<u8>>) -> Result<Vec<u8>>,
    ) -> Result<Vec<u8>> {
        let met = if self.leads() { self.hear(own, stop, answer) } else { self.report(own) };
        self.is_stopped.store(false, Ordering::Relaxed);
        self.is_over.store(met.is_err(), Ordering::Relaxed);
        self.noting_loss(met)
    }

    /// Ends the tracing of a batch of samples, and adds what all ranks have counted to `counts` of the first one. Returns whether all
    /// ranks have taken all samples.
    pub(super) fn end_batch(
        &self,
        traced: Result<bool>,
        own: &Counts,
        counts: &mut Counts,
        stop: &dyn Fn() -> bool,
    ) -> Result<bool> {
        if !matches!(traced, Ok(true)) {
            self.tell_stop();
        }
        let count = |reports: Vec<Vec<u8>>| {
            let mut is_complete = true;
            for report in reports {
                let (of_rank, of_counts): (bool, Counts) = failure::decode(&report)?;
                is_complete &= of_rank;
                counts.add(&of_counts);
            }
            Ok(vec![u8::from(is_complete)])
        };
        let report = traced.map(|is_complete| failure::encode(&(is_complete, own)));
        let answer = self.waiting.time(|| self.meet(report, stop, count))?;
        Ok(answer == [1])
    }

    /// Adds up the sums of all ranks, times it and counts its bytes. `own` is what this rank has, or its failure. Ranks first tell
    /// each other where they have targets, and hand over only the blocks of bins in which a rank has some.
    pub(super) fn add(&self, own: Result<Sums>, clock: &Clock, traffic: &Traffic) -> Result<Sums> {
        let (mut sums, touched) = match own {
            Ok(sums) => {
                let touched = failure::encode(&sums.touched_blocks());
                (sums, Ok(touched))
            }
            Err(error) => (Sums::default(), Err(error)),
        };
        let unite = |reports: Vec<Vec<u8>>| {
            let mut all: Vec<u32> = Vec::new();
            for report in reports {
                let blocks: Vec<u32> = failure::decode(&report)?;
                all.resize(all.len().max(blocks.len()), 0);
                all.iter_mut().zip(blocks).for_each(|(all, blocks)| *all |= blocks);
            }
            Ok(failure::encode(&all))
        };
        // No rank may begin to add while another one has failed.
        let touched = self.waiting.time(|| self.meet(touched, &|| false, unite))?;
        let touched: Vec<u32> = failure::decode(&touched)?;
        let added = clock.time(|| {
            let mut packed = sums.packed(&touched);
            traffic.note(packed.len_bytes());
            self.noting_loss(self.exchange.add(&mut packed))?;
            sums.unpack(&touched, packed);
            Ok(())
        });
        self.is_over.store(added.is_err(), Ordering::Relaxed);
        added.map(|()| sums)
    }

    fn hear(
        &self,
        own: Result<Vec<u8>>,
        stop: &dyn Fn() -> bool,
        answer: impl FnOnce(Vec<Vec<u8>>) -> Result<Vec<u8>>,
    ) -> Result<Vec<u8>> {
        let mut reports = vec![own];
        for rank in 1..self.ranks() {
            let report = self.receive(rank, Kind::Report, &|| _ = self.is_to_stop(stop))?;
            reports.push(failure::unpack(report).map_err(|failure| failure.into_error(&self.name(rank))));
        }
        let answer = reports.into_iter().collect::<Result<Vec<_>>>().and_then(answer);
        let failure = answer.as_ref().err().map(Failure::of);
        let packed = failure::pack(failure.map_or_else(|| Ok(answer.as_deref().unwrap_or_default().to_vec()), Err));
        let mark = u8::from(self.is_stopped.load(Ordering::Relaxed));
        let packed = [packed, vec![mark]].concat();
        (1..self.ranks()).try_for_each(|rank| self.exchange.send(rank, Kind::Answer, &packed))?;
        answer
    }

    fn report(&self, own: Result<Vec<u8>>) -> Result<Vec<u8>> {
        self.exchange.send(0, Kind::Report, &failure::pack(own.map_err(|error| Failure::of(&error))))?;
        let mut answer = self.receive(0, Kind::Answer, &|| {})?;
        let is_stopped = answer.pop() == Some(1);
        if is_stopped && !self.is_stopped.load(Ordering::Relaxed) {
            // The message came too late for this rank. It must not stop the next work.
            self.receive(0, Kind::Stop, &|| {})?;
        }
        failure::unpack(answer).map_err(|failure| failure.into_error(""))
    }

    /// Waits for a message, and does something between two looks for it.
    fn receive(&self, from: usize, kind: Kind, idle: &dyn Fn()) -> Result<Vec<u8>> {
        let (mut looks, mut pause, mut ending) = (0, Duration::from_micros(20), None);
        loop {
            if let Some(message) = self.exchange.try_receive(from, kind)? {
                return Ok(message);
            }
            idle();
            let mut is_late = || ending.get_or_insert_with(Instant::now).elapsed() > GRACE;
            if self.exchange.is_ending() && is_late() && self.may_be_lost() {
                return Err(Error::RankLost { rank: self.name(from), note: String::new() });
            }
            looks += 1;
            if looks < EAGER_LOOKS {
                thread::yield_now();
            } else {
                thread::sleep(pause);
                pause = (2 * pause).min(LONGEST_PAUSE);
            }
        }
    }

    fn noting_loss<T>(&self, mut done: Result<T>) -> Result<T> {
        if let Err(Error::RankLost { rank, .. }) = &mut done {
            let name = || self.ended().map_or_else(|| rank.clone(), |ended| self.name(ended));
            *rank = self.lost.get_or_init(name).clone();
        }
        done
    }

    /// The first rank on this machine whose process has ended, where the system lists its processes.
    fn ended(&self) -> Option<usize> {
        let processes = Path::new("/proc");
        let own = self.members.get(self.exchange.rank()).filter(|_| processes.join("self").exists())?;
        let has_ended =
            |member: &Member| member.machine == own.machine && !processes.join(member.process.to_string()).exists();
        self.members.iter().position(has_ended)
    }

    /// Whether a rank may have ended: one has, or nobody can know. The signal that ends the ranks after a loss may also come from a user.
    fn may_be_lost(&self) -> bool {
        let own = self.members.get(self.exchange.rank());
        let is_known = own.is_some_and(|own| self.members.iter().all(|member| member.machine == own.machine));
        !is_known || !Path::new("/proc/self").exists() || self.ended().is_some()
    }

    /// Number of a rank, with its machine where that is known.
    fn name(&self, rank: usize) -> String {
        self.members.get(rank).map_or(format!("rank {rank}"), |member| format!("rank {rank} on {}", member.machine))
    }
}

impl Drop for Team {
    /// Ends the work of the other ranks.
    fn drop(&mut self) {
        let has_begun = !self.members.is_empty() && self.lost.get().is_none();
        if self.leads() && has_begun && !thread::panicking() {
            // Whoever has started a rank that cannot be told ends it.
            let _ = self.command(END);
        }
    }
}

impl Member {
    /// Refuses a rank that differs from the first one in a fact.
    fn check(&self, rank: usize, first: &Self) -> Result<()> {
        let differs = |(own, of_first): &(&(String, String), &(String, String))| own != of_first;
        let Some(((name, own), (_, of_first))) = self.facts.iter().zip(&first.facts).find(differs) else {
            return Ok(());
        };
        Err(Error::Settings(format!(
            "rank {rank} on {} has another {name} than rank 0 ({own} there, {of_first} here); all ranks need the same program, \
             options and scene",
            self.machine
        )))
    }
}

fn nothing_failed() -> Error {
    Error::Render("a rank has failed without an error".into())
}
