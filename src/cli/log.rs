//! Log of a render in JSON: one object per line, for programs that watch many renders.

use std::mem::discriminant;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use lodestar::Error;
use lodestar::film::noise::NoiseReport;
use lodestar::session::{Beginning, Ending, Event, Preparation, Progress};
use serde::Serialize;
use serde_json::{Value, json};

use super::print::print_message;

/// Log of one render on standard error.
pub struct Log {
    is_quiet: bool,
    /// Last kind of work before the first step that was logged.
    preparation: Option<Preparation>,
    /// Files that were written, each once.
    files: Vec<PathBuf>,
    /// Reason of the end and the progress then.
    ending: Option<(Ending, Value)>,
}

impl Log {
    /// A log without a line. A quiet one has lines for warnings and for a failure only.
    pub fn new(is_quiet: bool) -> Self {
        Self { is_quiet, preparation: None, files: Vec::new(), ending: None }
    }

    /// Logs an event. The end is logged by [`Log::end`].
    pub fn write(&mut self, event: Event<'_>) {
        match event {
            Event::Preparing(preparation) => self.prepare(preparation),
            Event::Ready | Event::InStep(_) | Event::Rendered | Event::Finishing(_) | Event::Writing(..) => {}
            Event::Begun(beginning) => self.line("start", start(beginning)),
            Event::Step(step) => self.line("step", progress(step)),
            Event::Written(path) => {
                self.line("written", json!({ "file": text(path) }));
                if !self.files.iter().any(|file| file == path) {
                    self.files.push(path.to_path_buf());
                }
            }
            Event::Note(message) => self.line("note", json!({ "message": message })),
            Event::Warning(message) => print("warning", json!({ "message": message })),
            Event::Validation(message) => print("validation", json!({ "message": message })),
            Event::Ended(ending, last) => self.ending = Some((ending, progress(last))),
        }
    }

    /// Logs the end of the render, which has failed if there is an error.
    pub fn end(&mut self, error: Option<&Error>) {
        let (ending, progress) = self.ending.take().unwrap_or((Ending::Failed, json!({})));
        let ending = if error.is_some() { Ending::Failed } else { ending };
        let files: Vec<_> = self.files.iter().map(|file| text(file)).collect();
        let mut value = json!({ "reason": reason(ending), "files": files });
        add(&mut value, progress);
        if let Some(error) = error {
            add(&mut value, json!({ "message": error.to_string() }));
        }
        match error {
            Some(_) => print("end", value),
            None => self.line("end", value),
        }
    }

    /// Logs the address of the page, also if the log is quiet.
    pub fn tell_address(&self, url: &str) {
        print("view", json!({ "address": url }));
    }

    /// Logs the beginning of each kind of work once.
    fn prepare(&mut self, preparation: Preparation) {
        if self.preparation.is_none_or(|last| discriminant(&last) != discriminant(&preparation)) {
            self.preparation = Some(preparation);
            self.line("preparing", json!({ "message": preparation.to_string() }));
        }
    }

    fn line(&self, event: &str, value: Value) {
        if !self.is_quiet {
            print(event, value);
        }
    }
}

fn start(beginning: &Beginning<'_>) -> Value {
    let Beginning { scene, scene_hash, device, settings, length, samples, files } = *beginning;
    let files: Vec<_> = files.iter().map(|file| text(file)).collect();
    let version = env!("CARGO_PKG_VERSION");
    json!({
        "version": version, "scene": text(scene), "scene_hash": scene_hash, "device": device, "settings": decimal(settings),
        "length": length, "samples": samples, "files": files,
    })
}

fn progress(progress: &Progress) -> Value {
    let Progress { samples, seconds, paths, light_hit_rate, noise, fraction, length: _ } = *progress;
    let paths_per_second = if seconds > 0.0 { paths as f64 / seconds } else { 0.0 };
    let mut value = json!({
        "samples": samples, "seconds": seconds, "paths": paths, "paths_per_second": paths_per_second,
        "light_hit_rate": light_hit_rate, "fraction": fraction,
    });
    if let Some(NoiseReport { target, largest, mean, sampled_share }) = noise {
        let noise = json!({
            "target": decimal(&target), "largest": decimal(&largest), "mean": decimal(&mean),
            "sampled_share": decimal(&sampled_share),
        });
        add(&mut value, json!({ "noise": noise }));
    }
    value
}

/// Value with the shortest decimals of its numbers. Otherwise an `f32` of 0.05 would become 0.05000000074505806.
fn decimal(value: &impl Serialize) -> Value {
    serde_json::to_string(value).ok().and_then(|text| serde_json::from_str(&text).ok()).unwrap_or_default()
}

fn reason(ending: Ending) -> &'static str {
    match ending {
        Ending::Samples => "samples",
        Ending::Time => "time",
        Ending::Noise => "noise",
        Ending::Stopped => "stopped",
        Ending::Failed => "failed",
    }
}

fn text(path: &Path) -> String {
    path.display().to_string()
}

/// Adds the members of `more` to those of `value`.
fn add(value: &mut Value, more: Value) {
    if let (Value::Object(value), Value::Object(more)) = (value, more) {
        value.extend(more);
    }
}

/// Prints one line with the name of the event and the present time in seconds since 1970.
fn print(event: &str, mut value: Value) {
    let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0.0, |since| since.as_secs_f64());
    add(&mut value, json!({ "event": event, "time": now }));
    print_message(&value.to_string());
}
