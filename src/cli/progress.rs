//! Progress on standard error: a bar on a terminal, elsewhere a line every few seconds.

use std::io::{self, IsTerminal};
use std::path::Path;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use lodestar::film::noise::NoiseReport;
use lodestar::session::Progress;

use super::print::print_message;

/// Least time between two lines where there is no bar.
const LINE_INTERVAL: Duration = Duration::from_secs(5);
/// Number of steps of the bar from empty to full.
const BAR_STEPS: u64 = 1000;

/// Shows the work before the first step: on a terminal at once, elsewhere if it takes longer than 5 seconds.
pub struct Loading {
    bar: Option<ProgressBar>,
    /// Time before which no line is printed, where there is no bar.
    next_line: Option<Mutex<Instant>>,
}

impl Loading {
    /// A display that shows nothing yet, and never anything if `quiet`.
    pub fn new(quiet: bool) -> Self {
        let is_terminal = io::stderr().is_terminal();
        let bar = (!quiet && is_terminal).then(|| styled(ProgressBar::no_length(), "{wide_msg}"));
        let next_line = (!quiet && !is_terminal).then(|| Mutex::new(Instant::now() + LINE_INTERVAL));
        Self { bar, next_line }
    }

    /// Shows `text`, from any thread.
    pub fn show(&self, text: &str) {
        if let Some(bar) = &self.bar {
            bar.set_message(text.to_string());
        }
        if let Some(Ok(mut next)) = self.next_line.as_ref().map(Mutex::lock)
            && *next <= Instant::now()
        {
            *next = Instant::now() + LINE_INTERVAL;
            print_message(text);
        }
    }

    /// Shows the share of a file that is written, in [0, 1].
    pub fn show_writing(&self, path: &Path, share: f64) {
        self.show(&format!("writing {}: {:.0} %", path.display(), 100.0 * share));
    }

    /// Hides the text while `print` writes to standard error.
    pub fn interleave<T>(&self, print: impl FnOnce() -> T) -> T {
        match &self.bar {
            Some(bar) => bar.suspend(print),
            None => print(),
        }
    }
}

impl Drop for Loading {
    fn drop(&mut self) {
        self.bar.iter().for_each(ProgressBar::finish_and_clear);
    }
}

/// Shows a share of a whole and a text, as a bar or as lines.
pub struct Meter(Display);

enum Display {
    Nothing,
    Bar(ProgressBar),
    /// Lines: the time of the last one, and the text that has come since then.
    Lines {
        last: Option<Instant>,
        pending: Option<String>,
    },
}

impl Meter {
    /// A meter that shows nothing yet, and never anything if `quiet`.
    pub fn new(quiet: bool) -> Self {
        Self(match (quiet, io::stderr().is_terminal()) {
            (true, _) => Display::Nothing,
            (false, true) => Display::Bar(new_bar()),
            (false, false) => Display::Lines { last: None, pending: None },
        })
    }

    /// Shows `text` and the share that is done, in [0, 1].
    pub fn update(&mut self, fraction: f64, text: String) {
        match &mut self.0 {
            Display::Nothing => {}
            Display::Bar(bar) => {
                bar.set_position((fraction.clamp(0.0, 1.0) * BAR_STEPS as f64) as u64);
                bar.set_message(text);
            }
            Display::Lines { last, pending } => {
                if last.is_some_and(|last| last.elapsed() < LINE_INTERVAL) {
                    *pending = Some(text);
                } else {
                    (*last, *pending) = (Some(Instant::now()), None);
                    print_message(&text);
                }
            }
        }
    }

    /// Hides the bar while `print` writes to standard error.
    pub fn interleave(&self, print: impl FnOnce()) {
        match &self.0 {
            Display::Bar(bar) => bar.suspend(print),
            Display::Lines { .. } | Display::Nothing => print(),
        }
    }

    /// Shows the last text and ends the bar, so that later lines follow below it.
    pub fn finish(&mut self) {
        match std::mem::replace(&mut self.0, Display::Nothing) {
            Display::Bar(bar) => bar.abandon(),
            Display::Lines { pending: Some(text), .. } => print_message(&text),
            Display::Lines { .. } | Display::Nothing => {}
        }
    }
}

impl Drop for Meter {
    /// Ends the bar also after a failure, so that the error message stands on a line of its own.
    fn drop(&mut self) {
        self.finish();
    }
}

fn new_bar() -> ProgressBar {
    styled(ProgressBar::with_draw_target(Some(BAR_STEPS), ProgressDrawTarget::stderr()), "{bar:10} {wide_msg}")
}

/// `bar` in the style of `template`. A wrong template would leave the default style, which shows the position too.
fn styled(bar: ProgressBar, template: &str) -> ProgressBar {
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
    bar
}

/// Progress on one line: `128/256 spp, 12 s left, 3.21 Mpaths/s, light hit rate 41.5 %`.
pub fn line(progress: &Progress) -> String {
    let samples = match progress.length.spp {
        Some(target) => format!("{}/{target} spp", progress.samples),
        None => format!("{} spp", progress.samples),
    };
    let time = match seconds_left(progress) {
        Some(seconds) => format!("{} left", duration(seconds)),
        None => format!("{} so far", duration(progress.seconds)),
    };
    let rate = if progress.seconds > 0.0 { progress.paths as f64 / progress.seconds / 1e6 } else { 0.0 };
    let noise = progress.noise.as_ref().map_or_else(String::new, |noise| format!(", {}", noise_words(noise)));
    format!("{samples}, {time}, {rate:.2} Mpaths/s, light hit rate {:.1} %{noise}", 100.0 * progress.light_hit_rate)
}

/// Noise in words: `noise up to 0.0812 (0.05 is wanted), 12.5 % of the pixels left`.
pub fn noise_words(NoiseReport { target, largest, sampled_share, .. }: &NoiseReport) -> String {
    let largest = largest.map_or_else(|| "not known yet".to_owned(), |largest| format!("up to {largest:.4}"));
    format!("noise {largest} ({target} is wanted), {:.1} % of the pixels left", 100.0 * sampled_share)
}

fn seconds_left(progress: &Progress) -> Option<f64> {
    let Progress { seconds, fraction, length, .. } = *progress;
    let by_fraction = (fraction > 0.0).then(|| seconds * (1.0 / fraction - 1.0).max(0.0));
    let by_limit = length.seconds.map(|limit| (limit - seconds).max(0.0));
    match (by_fraction, by_limit) {
        (Some(a), Some(b)) => Some(a.min(b)),
        (a, b) => a.or(b),
    }
}

/// Duration in words: `59 s`, `2 min 05 s`, `3 h 07 min`.
pub fn duration(seconds: f64) -> String {
    let seconds = seconds.round() as u64;
    match (seconds / 3600, seconds / 60 % 60, seconds % 60) {
        (0, 0, seconds) => format!("{seconds} s"),
        (0, minutes, seconds) => format!("{minutes} min {seconds:02} s"),
        (hours, minutes, _) => format!("{hours} h {minutes:02} min"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lodestar::session::Length;

    const UNLIMITED: Length = Length { spp: None, seconds: None };
    const PROGRESS: Progress = Progress {
        samples: 128,
        seconds: 12.0,
        paths: 38_520_000,
        light_hit_rate: 0.415,
        noise: None,
        fraction: 0.5,
        length: Length { spp: Some(256), seconds: None },
    };

    #[test]
    fn a_line_says_it_all() {
        assert_eq!(line(&PROGRESS), "128/256 spp, 12 s left, 3.21 Mpaths/s, light hit rate 41.5 %");
        let by_time = Progress { length: Length { spp: None, seconds: Some(20.0) }, ..PROGRESS };
        assert!(line(&by_time).starts_with("128 spp, 8 s left"));
    }

    #[test]
    fn nothing_is_made_up_before_the_first_sample() {
        let length = Length { spp: Some(8), seconds: None };
        let start =
            Progress { samples: 0, seconds: 0.0, paths: 0, light_hit_rate: 0.0, fraction: 0.0, length, ..PROGRESS };
        assert_eq!(line(&start), "0/8 spp, 0 s so far, 0.00 Mpaths/s, light hit rate 0.0 %");
    }

    #[test]
    fn noise_is_told_where_it_ends_the_render() {
        let noise = |largest| {
            let noise = NoiseReport { target: 0.05, largest, mean: largest, sampled_share: 0.125 };
            line(&Progress { noise: Some(noise), length: UNLIMITED, ..PROGRESS })
        };
        assert!(noise(Some(0.08124)).ends_with(", noise up to 0.0812 (0.05 is wanted), 12.5 % of the pixels left"));
        assert!(noise(None).ends_with(", noise not known yet (0.05 is wanted), 12.5 % of the pixels left"));
    }

    #[test]
    fn durations_read_well() {
        assert_eq!([59.2, 125.0, 11_220.0].map(duration), ["59 s", "2 min 05 s", "3 h 07 min"]);
    }
}
