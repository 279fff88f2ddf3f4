//! Several ranks, here threads with an exchange in memory, render one picture with the bits of one rank. `tests/mpi/run.sh` does the
//! same with processes and MPI.

use std::cell::Cell;
use std::sync::Arc;
use std::thread;

use lodestar::Error;
use lodestar::fleet::Fleet;
use lodestar::fleet::exchange::Exchange;
use lodestar::fleet::in_memory::InMemory;
use lodestar::fleet::team::{Member, Team};
use lodestar::fleet::trial::Trial;
use lodestar::scene::Scene;
use lodestar::settings::{Sampler, Settings};
use support::scenes::settings;
use support::tier;

use crate::device::Device;
use crate::ranks::{Left, SIZE, SPP, configurations, left, left_by_one, scene};

/// Configurations in the quick tier.
const IN_QUICK_TIER: usize = 4;

/// Calls `lead` with the fleet of the first of several ranks. `devices` has each rank's number of devices.
fn in_ranks<T>(
    scene: &Scene,
    settings: &Settings,
    devices: &[usize],
    trial: Option<Trial>,
    lead: impl FnOnce(&mut Fleet) -> T,
) -> T {
    let with_fleet = |exchange: InMemory, act: &mut dyn FnMut(&mut Fleet)| {
        let count = devices[exchange.rank()];
        let devices: Vec<_> = (0..count).map(|_| Device::new()).collect();
        let mut renderers = devices.iter().map(|device| device.renderer(scene, settings));
        let first = renderers.next().expect("a device");
        let mut fleet = Fleet::new(first, renderers.collect()).expect("renderers without samples");
        let facts = vec![("scene".to_owned(), "ours".to_owned())];
        let process = std::process::id();
        let member = Member { machine: "this one".into(), process, devices: vec!["a device".into(); count], facts };
        let exchange: Arc<dyn Exchange> = Arc::new(exchange);
        let exchange = trial.map_or(Arc::clone(&exchange), |trial| trial.on(exchange));
        let team = Team::gather(exchange, Ok(member)).expect("ranks of one scene");
        fleet.join(&Arc::new(team)).expect("a fleet without samples");
        act(&mut fleet);
    };
    let mut exchanges = InMemory::new(devices.len()).into_iter();
    let first = exchanges.next().expect("a rank");
    thread::scope(|scope| {
        for exchange in exchanges {
            let with_fleet = &with_fleet;
            scope.spawn(move || with_fleet(exchange, &mut |fleet| fleet.serve().expect("a first rank")));
        }
        let (mut lead, mut led) = (Some(lead), None);
        with_fleet(first, &mut |fleet| led = lead.take().map(|lead| lead(fleet)));
        led.expect("the first rank's result")
    })
}

/// Everything that a render leaves, and its state after the first half, from which it goes on.
fn left_by(scene: &Scene, settings: &Settings, devices: &[usize], trial: Option<Trial>) -> Left {
    in_ranks(scene, settings, devices, trial, |fleet| left(fleet, settings, SPP))
}

#[test]
fn any_number_of_ranks_leaves_what_one_leaves() {
    let scene = scene();
    let all = configurations(&scene);
    let all = tier::some_of(&all, IN_QUICK_TIER);
    let teams: &[&[usize]] = if tier::is_full() { &[&[1, 1], &[1, 2], &[1, 1, 1], &[2, 1, 1]] } else { &[&[1, 2]] };
    for (name, settings) in all {
        let one = left_by_one(&scene, settings, SPP);
        for &devices in teams {
            let several = left_by(&scene, settings, devices, None);
            assert!(several == one, "{name}, ranks with {devices:?} devices");
        }
    }
}

/// Ranks deal out tiles by the speed of all their devices, and the bits stay.
#[test]
fn ranks_deal_tiles_by_speed() {
    let scene = scene();
    for sampler in [Sampler::Product, Sampler::Quadtree] {
        let settings = settings(&scene, SIZE, sampler, 21);
        let one = left_by_one(&scene, &settings, SPP);
        let several = in_ranks(&scene, &settings, &[1, 2], None, |fleet| {
            let weights = fleet.deal_by_speed().expect("renderers without samples");
            assert!(weights.len() == 3 && weights.iter().sum::<u32>() > 0, "{weights:?}");
            left(fleet, &settings, SPP)
        });
        assert!(several == one, "{sampler:?}");
    }
}

/// The comparison finds sums of a rank that are lost on the way, and sums that are added twice.
#[test]
fn wrong_sums_of_a_rank_are_found() {
    let scene = scene();
    for sampler in [Sampler::RejectionMix, Sampler::Quadtree] {
        let settings = settings(&scene, SIZE, sampler, 21);
        let one = left_by_one(&scene, &settings, SPP);
        for trial in [Trial::Lose(1), Trial::Double(1), Trial::Lose(0)] {
            let several = left_by(&scene, &settings, &[1, 1], Some(trial));
            assert!(several.0 != one.0 && several.1 != one.1, "{sampler:?}: {trial:?}, but nothing differs");
        }
    }
}

/// A step that the first rank stops leaves no message behind that would stop a later one.
#[test]
fn ranks_stop_together_and_begin_again() {
    let scene = scene();
    for sampler in [Sampler::RejectionMix, Sampler::Quadtree] {
        let settings = settings(&scene, SIZE, sampler, 21);
        let whole = left_by_one(&scene, &settings, SPP);
        in_ranks(&scene, &settings, &[1, 1, 1], None, |fleet| {
            let (_, state, _) = left(fleet, &settings, 16);
            // Where the last question is asked decides a race: other ranks may have taken all samples by then.
            for questions in 0..6 {
                let asked = Cell::new(0);
                let stop = || asked.replace(asked.get() + 1) >= questions;
                let report = fleet.step(8, &stop).expect("a step");
                assert_eq!(report.complete, !fleet.first().is_stopped(), "{questions} questions");
                assert!(!report.complete || questions > 0);
                fleet.begin_again(settings.samples_per_dispatch, Some(&state)).expect("the same settings");
            }
            assert!(left(fleet, &settings, SPP).1 == whole.1, "{sampler:?}");
        });
    }
}

/// No rank renders where one differs, and the sentence names it.
#[test]
fn a_rank_that_differs_is_refused_by_all() {
    let member = |scene: &str| Member {
        machine: "m".into(),
        process: std::process::id(),
        devices: vec!["d".into()],
        facts: vec![("scene_hash".into(), scene.into())],
    };
    let gather = |exchange: InMemory, own| Team::gather(Arc::new(exchange), own).err().map(|error| error.to_string());
    for (own, expected) in [
        (Ok(member("b")), "rank 1 on m has another scene_hash than rank 0 (b there, a here)"),
        (Err(Error::Device("there is no device".into())), "rank 1: there is no device"),
    ] {
        let [first, second] = InMemory::new(2).try_into().ok().expect("two ranks");
        let refused = thread::scope(|scope| {
            let second = scope.spawn(|| gather(second, own));
            [gather(first, Ok(member("a"))), second.join().expect("no panic")]
        });
        for refused in refused {
            let refused = refused.expect("a refusal");
            assert!(refused.starts_with(expected), "{refused}");
        }
    }
}
