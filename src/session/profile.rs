//! Times of a render's dispatches, by kernel and by step: as a table, as numbers and as a trace.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::time::Duration;

use serde::Serialize;
use serde_json::{Value, json};

use crate::gpu::{Clock, SubmissionTime};

/// Largest number of steps for which the table shows every step. Of a longer render it shows the last step and the steps
/// whose number is a power of two.
const STEPS_SHOWN: usize = 16;

/// One step of a render, with its submissions.
#[derive(Debug, Clone, PartialEq)]
pub struct ProfiledStep {
    /// Samples per pixel that the step was asked for.
    pub samples: u32,
    /// Rays traced.
    pub rays: u64,
    /// Wall time of the step.
    pub seconds: f64,
    /// Submissions in the order in which they ran.
    pub submissions: Vec<SubmissionTime>,
}

/// A render's steps, timed.
#[derive(Debug, Clone, PartialEq)]
pub struct Profile {
    clock: Clock,
    device: String,
    steps: Vec<ProfiledStep>,
}

/// Times of one kernel's dispatches. By the host's clock, the kernels of one submission count as one kernel, called `a + b`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct KernelTime {
    /// Name of the kernel.
    pub kernel: String,
    /// Number of dispatches.
    pub dispatches: u64,
    /// Sum of the dispatches' times.
    pub milliseconds: f64,
    /// Share of the steps' wall time, in [0, 1].
    pub share: f64,
    /// Time of the shortest dispatch.
    pub least_milliseconds: f64,
    /// Time of the longest dispatch.
    pub most_milliseconds: f64,
}

/// Times of one step.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StepTime {
    /// Number of the step, counted from 1.
    pub step: usize,
    /// Samples per pixel that the step was asked for.
    pub samples: u32,
    /// Wall time.
    pub milliseconds: f64,
    /// Milliseconds of each kernel, by its name.
    pub kernels: BTreeMap<String, f64>,
    /// Wall time in which no kernel ran.
    pub other_milliseconds: f64,
    /// Rays traced.
    pub rays: u64,
    /// Rays per second of wall time.
    pub rays_per_second: f64,
}

/// All numbers of a profile.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Summary {
    /// Name of the device.
    pub device: String,
    /// Clock that measured the kernels' times.
    pub clock: Clock,
    /// Wall time of all steps.
    pub milliseconds: f64,
    /// Rays traced.
    pub rays: u64,
    /// Rays per second of wall time.
    pub rays_per_second: f64,
    /// Wall time in which no kernel ran.
    pub other_milliseconds: f64,
    /// Kernels; the one with the longest time comes first.
    pub kernels: Vec<KernelTime>,
    /// Steps in order.
    pub steps: Vec<StepTime>,
}

/// Name of a kernel, and begin and end of one of its spans since the begin of the submission.
type Span = (String, Duration, Duration);

impl Profile {
    /// An empty profile of the device with this name.
    pub fn new(clock: Clock, device: &str) -> Self {
        Self { clock, device: device.into(), steps: Vec::new() }
    }

    /// Adds a step.
    pub fn add(&mut self, step: ProfiledStep) {
        self.steps.push(step);
    }

    /// All numbers of the profile.
    pub fn summary(&self) -> Summary {
        let steps: Vec<_> = (1..).zip(&self.steps).map(|(number, step)| step_time(number, step)).collect();
        let milliseconds = sum(&steps, |step| step.milliseconds);
        let rays = self.steps.iter().map(|step| step.rays).sum();
        Summary {
            device: self.device.clone(),
            clock: self.clock,
            milliseconds,
            rays,
            rays_per_second: per_second(rays, milliseconds),
            other_milliseconds: sum(&steps, |step| step.other_milliseconds),
            kernels: kernel_times(&self.steps, milliseconds),
            steps,
        }
    }

    /// The trace in Chrome's Trace Event Format, which Perfetto and `chrome://tracing` open. Its `otherData` has the numbers
    /// of [`Self::summary`]. The host's clock places each submission; the device's clock places the kernels within it.
    pub fn trace(&self) -> Value {
        let mut events = vec![
            json!({"ph": "M", "name": "process_name", "pid": 1, "args": {"name": format!("lodestar on {}", self.device)}}),
            thread_name(STEPS, "steps"),
            thread_name(SUBMISSIONS, "submissions, by the host's clock"),
            thread_name(KERNELS, self.clock_title()),
        ];
        for (number, step) in (1..).zip(&self.steps) {
            events.extend(step_events(number, step));
        }
        json!({"displayTimeUnit": "ms", "otherData": self.summary(), "traceEvents": events})
    }

    fn clock_title(&self) -> &'static str {
        match self.clock {
            Clock::Device => "kernels, by the device's clock",
            Clock::Host => "kernels, by the host's clock: the device has no timestamps",
        }
    }
}

// Numbers of the trace's tracks.
const STEPS: u32 = 1;
const SUBMISSIONS: u32 = 2;
const KERNELS: u32 = 3;

fn thread_name(track: u32, name: &str) -> Value {
    json!({"ph": "M", "name": "thread_name", "pid": 1, "tid": track, "args": {"name": name}})
}

fn slice(track: u32, name: &str, begin: Duration, length: Duration, args: Value) -> Value {
    let (begin, length) = (microseconds(begin), microseconds(length));
    json!({"ph": "X", "cat": "lodestar", "name": name, "pid": 1, "tid": track, "ts": begin, "dur": length, "args": args})
}

fn step_events(number: usize, step: &ProfiledStep) -> Vec<Value> {
    // A picture that was read back between two steps is a submission without dispatches: the step begins after it.
    let first = step.submissions.iter().find(|submission| !submission.dispatches.is_empty());
    let begin = first.map_or(Duration::ZERO, |first| first.begin);
    let rate = per_second(step.rays, step.seconds * 1e3) / 1e6;
    let length = Duration::try_from_secs_f64(step.seconds).unwrap_or_default();
    let args = json!({"samples": step.samples, "rays": step.rays});
    let mut events = vec![
        slice(STEPS, &format!("step {number}"), begin, length, args),
        json!({"ph": "C", "name": "Mrays/s", "pid": 1, "ts": microseconds(begin), "args": {"Mrays/s": rate}}),
    ];
    for submission in &step.submissions {
        events.push(slice(SUBMISSIONS, &submission.label, submission.begin, submission.wall, json!({})));
        let workgroups: Vec<_> = submission.dispatches.iter().map(|dispatch| dispatch.workgroups).collect();
        for (place, (kernel, from, to)) in spans(submission).into_iter().enumerate() {
            let args = json!({"workgroups": workgroups.get(place)});
            events.push(slice(KERNELS, &kernel, submission.begin + from, to.saturating_sub(from), args));
        }
    }
    events
}

/// Spans of a submission's kernels. Where a dispatch has no time by the device's clock, the whole submission is one span of all
/// its kernels.
fn spans(submission: &SubmissionTime) -> Vec<Span> {
    let dispatches = &submission.dispatches;
    if dispatches.is_empty() {
        return Vec::new();
    }
    let timed = dispatches.iter().map(|dispatch| dispatch.span.map(|(from, to)| (dispatch.kernel.into(), from, to)));
    if let Some(timed) = timed.collect::<Option<Vec<_>>>() {
        return timed;
    }
    let names: Vec<_> = dispatches.iter().map(|dispatch| dispatch.kernel).collect();
    vec![(names.join(" + "), Duration::ZERO, submission.wall)]
}

fn step_time(number: usize, step: &ProfiledStep) -> StepTime {
    let milliseconds = step.seconds * 1e3;
    let mut kernels = BTreeMap::new();
    for (kernel, from, to) in step.submissions.iter().flat_map(spans) {
        *kernels.entry(kernel).or_insert(0.0) += to.saturating_sub(from).as_secs_f64() * 1e3;
    }
    let busy: f64 = kernels.values().sum();
    StepTime {
        step: number,
        samples: step.samples,
        milliseconds,
        kernels,
        other_milliseconds: (milliseconds - busy).max(0.0),
        rays: step.rays,
        rays_per_second: per_second(step.rays, milliseconds),
    }
}

fn kernel_times(steps: &[ProfiledStep], wall: f64) -> Vec<KernelTime> {
    let mut durations = BTreeMap::<String, Vec<f64>>::new();
    for (kernel, from, to) in steps.iter().flat_map(|step| &step.submissions).flat_map(spans) {
        durations.entry(kernel).or_default().push(to.saturating_sub(from).as_secs_f64() * 1e3);
    }
    let time = |(kernel, all): (String, Vec<f64>)| {
        let milliseconds: f64 = all.iter().sum();
        KernelTime {
            kernel,
            dispatches: all.len() as u64,
            milliseconds,
            share: if wall > 0.0 { milliseconds / wall } else { 0.0 },
            least_milliseconds: all.iter().copied().fold(f64::INFINITY, f64::min),
            most_milliseconds: all.iter().copied().fold(0.0, f64::max),
        }
    };
    let mut times: Vec<_> = durations.into_iter().map(time).collect();
    times.sort_by(|a, b| b.milliseconds.total_cmp(&a.milliseconds));
    times
}

impl Summary {
    /// A table of all times, for people.
    pub fn table(&self) -> String {
        let mut text = format!("{}, {}\n\n", self.device, self.clock_sentence());
        let _ = writeln!(
            text,
            "{:<40} {:>10} {:>10} {:>7} {:>9} {:>9} {:>9}",
            "kernel", "dispatches", "ms", "share", "mean ms", "least ms", "most ms"
        );
        for k in &self.kernels {
            let mean = k.milliseconds / k.dispatches as f64;
            let _ = writeln!(
                text,
                "{:<40} {:>10} {:>10.1} {:>6.1}% {:>9.3} {:>9.3} {:>9.3}",
                k.kernel,
                k.dispatches,
                k.milliseconds,
                k.share * 100.0,
                mean,
                k.least_milliseconds,
                k.most_milliseconds
            );
        }
        self.write_sums(&mut text);
        self.write_steps(&mut text);
        text
    }

    fn clock_sentence(&self) -> &'static str {
        match self.clock {
            Clock::Device => "times by the device's clock",
            Clock::Host => "wall times of whole submissions, because the device has no timestamps",
        }
    }

    fn write_sums(&self, text: &mut String) {
        let share = if self.milliseconds > 0.0 { self.other_milliseconds / self.milliseconds } else { 0.0 };
        let other = "none: recording, waiting, reading back";
        let _ = writeln!(text, "{other:<40} {:>10} {:>10.1} {:>6.1}%", "", self.other_milliseconds, share * 100.0);
        let _ = writeln!(text, "{:<40} {:>10} {:>10.1} {:>6.1}%", "all steps", "", self.milliseconds, 100.0);
        let _ = writeln!(text, "\n{} rays, {:.3} Mrays/s", self.rays, self.rays_per_second / 1e6);
    }

    fn write_steps(&self, text: &mut String) {
        let names: Vec<_> = self.kernels.iter().map(|k| k.kernel.as_str()).collect();
        let width = |name: &str| name.len().max(10);
        let _ = write!(text, "\n{:>6} {:>8} {:>10}", "step", "samples", "ms");
        for name in &names {
            let _ = write!(text, " {name:>0$}", width(name));
        }
        let _ = writeln!(text, " {:>10} {:>10}", "other", "Mrays/s");
        let is_shown = |step: &&StepTime| {
            let last = self.steps.len();
            last <= STEPS_SHOWN || step.step.is_power_of_two() || step.step == last
        };
        for step in self.steps.iter().filter(is_shown) {
            let _ = write!(text, "{:>6} {:>8} {:>10.1}", step.step, step.samples, step.milliseconds);
            for name in &names {
                let _ = write!(text, " {:>1$.1}", step.kernels.get(*name).copied().unwrap_or(0.0), width(name));
            }
            let _ = writeln!(text, " {:>10.1} {:>10.3}", step.other_milliseconds, step.rays_per_second / 1e6);
        }
    }
}

fn sum(steps: &[StepTime], of: impl Fn(&StepTime) -> f64) -> f64 {
    steps.iter().map(of).sum()
}

fn per_second(count: u64, milliseconds: f64) -> f64 {
    if milliseconds > 0.0 { count as f64 / milliseconds * 1e3 } else { 0.0 }
}

fn microseconds(time: Duration) -> f64 {
    time.as_nanos() as f64 / 1e3
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::DispatchTime;

    fn ms(milliseconds: u64) -> Duration {
        Duration::from_millis(milliseconds)
    }

    fn submission(begin: u64, wall: u64, dispatches: &[(&'static str, Option<(u64, u64)>)]) -> SubmissionTime {
        let time = |&(kernel, span): &(&'static str, Option<(u64, u64)>)| DispatchTime {
            kernel,
            workgroups: [2, 1, 1],
            span: span.map(|(from, to)| (ms(from), ms(to))),
        };
        SubmissionTime {
            label: format!("at {begin}"),
            begin: ms(begin),
            wall: ms(wall),
            dispatches: dispatches.iter().map(time).collect(),
        }
    }

    fn profile(clock: Clock) -> Profile {
        let span = |from, to| (clock == Clock::Device).then_some((from, to));
        let mut profile = Profile::new(clock, "a device");
        let update = [("learn", span(1, 3)), ("normalize", span(3, 4))];
        profile.add(ProfiledStep {
            samples: 8,
            rays: 6000,
            seconds: 0.060,
            submissions: vec![
                submission(10, 30, &[("trace", span(1, 21))]),
                submission(40, 20, &[("trace", span(0, 10))]),
                submission(60, 6, &update),
            ],
        });
        profile.add(ProfiledStep { samples: 4, rays: 0, seconds: 0.0, submissions: Vec::new() });
        profile
    }

    #[test]
    fn times_add_up_by_the_devices_clock() {
        let summary = profile(Clock::Device).summary();
        let names: Vec<_> = summary.kernels.iter().map(|k| (k.kernel.as_str(), k.dispatches)).collect();
        assert_eq!(names, [("trace", 2), ("learn", 1), ("normalize", 1)]);
        let trace = &summary.kernels[0];
        assert!((trace.milliseconds - 30.0).abs() < 1e-9 && (trace.share - 0.5).abs() < 1e-9, "{trace:?}");
        assert!((trace.least_milliseconds - 10.0).abs() < 1e-9 && (trace.most_milliseconds - 20.0).abs() < 1e-9);
        assert!((summary.other_milliseconds - 27.0).abs() < 1e-9, "{summary:?}");
        assert!((summary.rays_per_second - 1e5).abs() < 1e-6);
        assert_eq!((summary.steps[1].milliseconds, summary.steps[1].rays_per_second), (0.0, 0.0));
    }

    #[test]
    fn without_timestamps_a_submission_is_one() {
        let summary = profile(Clock::Host).summary();
        let names: Vec<_> = summary.kernels.iter().map(|k| (k.kernel.as_str(), k.milliseconds)).collect();
        assert_eq!(names, [("trace", 50.0), ("learn + normalize", 6.0)]);
        assert!(summary.table().contains("the device has no timestamps"), "{}", summary.table());
        assert!(!profile(Clock::Device).summary().table().contains("no timestamps"));
    }

    #[test]
    fn the_trace_has_every_dispatch_where_it_ran() {
        let trace = profile(Clock::Device).trace();
        let events = trace["traceEvents"].as_array().expect("events");
        let of = |track: u32| events.iter().filter(move |e| e["ph"] == "X" && e["tid"] == track);
        let kernels: Vec<_> = of(KERNELS).map(|e| (e["name"].as_str(), e["ts"].as_f64(), e["dur"].as_f64())).collect();
        let at = |name, ts: f64, dur: f64| (Some(name), Some(ts), Some(dur));
        let expected =
            [at("trace", 11e3, 20e3), at("trace", 40e3, 10e3), at("learn", 61e3, 2e3), at("normalize", 63e3, 1e3)];
        assert_eq!(kernels, expected);
        assert_eq!((of(STEPS).count(), of(SUBMISSIONS).count()), (2, 3));
        assert_eq!(trace["otherData"]["kernels"][0]["kernel"], "trace");
    }

    #[test]
    fn a_long_render_shows_few_steps() {
        let mut profile = Profile::new(Clock::Device, "a device");
        (0..100).for_each(|_| profile.add(ProfiledStep { samples: 8, rays: 1, seconds: 1.0, submissions: Vec::new() }));
        let table = profile.summary().table();
        let steps = table.lines().skip_while(|line| !line.trim_start().starts_with("step")).skip(1);
        let numbers: Vec<_> = steps.filter_map(|line| line.split_whitespace().next()).collect();
        assert_eq!(numbers, ["1", "2", "4", "8", "16", "32", "64", "100"]);
    }
}
