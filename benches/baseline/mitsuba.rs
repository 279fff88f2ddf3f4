//! Mitsuba 3 in a process of its own, which measures on request.

use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use lodestar::gpu::{DeviceInfo, DeviceKind};
use serde_json::Value;

/// Process that runs `benches/mitsuba_baseline.py`, if Python has Mitsuba.
pub struct Mitsuba {
    process: Option<Process>,
    /// Version and variant of Mitsuba, or the reason why it is not available.
    pub description: String,
}

struct Process {
    child: Child,
    requests: ChildStdin,
    answers: BufReader<ChildStdout>,
}

impl Mitsuba {
    /// Starts Mitsuba on the same kind of device: the processor or an NVIDIA GPU.
    pub fn start(device: &DeviceInfo) -> Self {
        let variant = if device.kind == DeviceKind::Cpu { "llvm_ad_rgb" } else { "cuda_ad_rgb" };
        match Process::start(variant) {
            Some((process, version)) => {
                Self { process: Some(process), description: format!("Mitsuba {version}, {variant}") }
            }
            None => Self {
                process: None,
                description: format!(
                    "Mitsuba not found ({variant}): pip install mitsuba, and name LLVM in DRJIT_LIBLLVM_PATH"
                ),
            },
        }
    }

    /// Seconds that Mitsuba measures for a request; NaN without an answer.
    pub fn seconds(&mut self, request: &Value) -> f64 {
        let answer = self.process.as_mut().and_then(|process| process.ask(request));
        answer.and_then(|line| line.trim().parse().ok()).unwrap_or(f64::NAN)
    }
}

impl Process {
    fn start(variant: &str) -> Option<(Self, String)> {
        let script = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/mitsuba_baseline.py");
        let mut command = Command::new("python3");
        let command = command.args(["-B", script, variant]).stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut child = command.stderr(Stdio::null()).spawn().ok()?;
        let (requests, answers) = (child.stdin.take()?, BufReader::new(child.stdout.take()?));
        let mut process = Self { child, requests, answers };
        let version = process.line()?.strip_prefix("ready ")?.trim().to_owned();
        Some((process, version))
    }

    fn ask(&mut self, request: &Value) -> Option<String> {
        writeln!(self.requests, "{request}").ok()?;
        self.requests.flush().ok()?;
        self.line()
    }

    fn line(&mut self) -> Option<String> {
        let mut line = String::new();
        let length = self.answers.read_line(&mut line).ok()?;
        (length > 0).then_some(line)
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
