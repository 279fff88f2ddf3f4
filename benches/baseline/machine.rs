//! Machine and build on which a number was measured.

use std::process::Command;

use lodestar::gpu::DeviceInfo;
use serde::{Deserialize, Serialize};

/// Number of tasks per thread above which a machine counts as busy.
const MOST_LOAD: f64 = 0.5;

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Machine {
    pub device: String,
    pub driver: String,
    pub processor: String,
    /// Number of the processor's threads that this process may use.
    pub threads: usize,
    /// Commit of the build, with `-changed` if files differ from it.
    pub commit: String,
}

impl Machine {
    pub fn here(device: &DeviceInfo) -> Self {
        Self {
            device: device.name.clone(),
            driver: format!("{} {}", device.driver_name, device.driver_info),
            processor: processor(),
            threads: std::thread::available_parallelism().map_or(1, usize::from),
            commit: commit(),
        }
    }

    pub fn print(&self) {
        println!("driver: {}", self.driver);
        println!("processor: {}, {} threads", self.processor, self.threads);
        println!("build: {}", self.commit);
    }

    /// Warns if other work keeps the machine busy.
    pub fn warn_of_load(&self, load: Option<f64>) {
        match load {
            Some(load) if load > MOST_LOAD * self.threads as f64 => {
                println!("the machine is busy: {load} tasks wanted its {} threads in the last minute", self.threads);
            }
            Some(load) => println!("tasks that wanted the machine's threads in the last minute: {load}"),
            None => {}
        }
    }

    /// File name made of device, processor and number of threads.
    pub fn file_name(&self) -> String {
        let text = format!("{} {} {} threads", self.device, self.processor, self.threads).to_lowercase();
        let words = text.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
        words.collect::<Vec<_>>().join("-") + ".json"
    }
}

/// Mean number of tasks that wanted a thread in the last minute, if the system reports it.
pub fn load() -> Option<f64> {
    std::fs::read_to_string("/proc/loadavg").ok()?.split_whitespace().next()?.parse().ok()
}

/// Name, family and model of the processor. Family and model distinguish products with the same name.
fn processor() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let field = |name: &str| {
        let line = text.lines().find(|line| line.split(':').next().is_some_and(|key| key.trim() == name))?;
        line.split(':').nth(1).map(|value| value.trim().to_owned())
    };
    match (field("model name"), field("cpu family"), field("model")) {
        (Some(name), Some(family), Some(model)) => format!("{name}, family {family}, model {model}"),
        (Some(name), ..) => name,
        _ => std::env::consts::ARCH.into(),
    }
}

fn commit() -> String {
    let git = |arguments: &[&str]| {
        let output = Command::new("git").current_dir(env!("CARGO_MANIFEST_DIR")).args(arguments).output().ok()?;
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    let Some(commit) = git(&["rev-parse", "--short=10", "HEAD"]) else { return "unknown".into() };
    let built_from = ["src", "glsl", "build", "build.rs", "Cargo.toml", "Cargo.lock"];
    let changed = git(&[&["status", "--porcelain", "--"], &built_from[..]].concat());
    if changed.is_some_and(|text| text.is_empty()) { commit } else { commit + "-changed" }
}
