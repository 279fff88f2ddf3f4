//! Headless Chromium, driven through the DevTools protocol over a pair of pipes.

use std::env;
use std::fs::{self, File};
use std::io::{BufRead, BufReader, Write};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

/// Names of Chromium.
const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "chrome"];
/// Maximum time for anything that should take a moment. Other tests keep the cores busy.
pub const PATIENCE: Duration = Duration::from_secs(60);

/// A running browser. It ends when this is dropped.
pub struct Browser {
    child: Child,
    to: File,
    messages: Receiver<Value>,
    next: u32,
    _folder: tempfile::TempDir,
}

/// A tab of a browser.
pub struct Tab(String);

/// The browser's program, if there is one.
pub fn program() -> Option<PathBuf> {
    if let Some(path) = env::var_os("LODESTAR_CHROMIUM") {
        return Some(path.into());
    }
    let folders = env::var_os("PATH")?;
    let mut files = env::split_paths(&folders).flat_map(|folder| NAMES.map(|name| folder.join(name)));
    files.find(|file| file.is_file())
}

impl Browser {
    /// Starts the browser.
    pub fn start(program: &PathBuf) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let pipes = ["to", "from"].map(|name| folder.path().join(name));
        assert!(Command::new("mkfifo").args(&pipes).status().unwrap().success());
        let command = "exec \"$0\" --headless=new --remote-debugging-pipe --no-sandbox --disable-gpu --disable-dev-shm-usage \
                       --no-first-run --disable-extensions --disable-background-networking --disable-component-update \
                       --hide-scrollbars \"--user-data-dir=$1\" about:blank 3<\"$2\" 4>\"$3\"";
        let profile = folder.path().join("profile");
        fs::create_dir(&profile).unwrap();
        let mut shell = Command::new("sh");
        shell.args(["-c", command]).arg(program).args([&profile, &pipes[0], &pipes[1]]);
        let child = shell.env("HOME", &profile).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        let to = File::options().write(true).open(&pipes[0]).unwrap();
        let from = BufReader::new(File::open(&pipes[1]).unwrap());
        let (sender, messages) = channel();
        thread::spawn(move || {
            for message in from.split(0).map_while(Result::ok) {
                if sender.send(serde_json::from_slice(&message).unwrap()).is_err() {
                    break;
                }
            }
        });
        Self { child, to, messages, next: 0, _folder: folder }
    }

    /// Sends a command and returns its result.
    fn send(&mut self, tab: Option<&Tab>, method: &str, parameters: Value) -> Value {
        self.try_to_send(tab, method, parameters).unwrap_or_else(|error| panic!("{method}: {error}"))
    }

    /// Sends a command and returns its result, or the error of the browser.
    fn try_to_send(&mut self, tab: Option<&Tab>, method: &str, parameters: Value) -> Result<Value, Value> {
        self.next += 1;
        let mut message = json!({ "id": self.next, "method": method, "params": parameters });
        if let Some(Tab(session)) = tab {
            message["sessionId"] = json!(session);
        }
        let mut bytes = message.to_string().into_bytes();
        bytes.push(0);
        self.to.write_all(&bytes).unwrap();
        loop {
            let answer = self.messages.recv_timeout(PATIENCE).unwrap_or_else(|_| panic!("no answer to {method}"));
            if answer["id"] == self.next {
                let failed = !answer["error"].is_null();
                return if failed { Err(answer) } else { Ok(answer["result"].clone()) };
            }
        }
    }

    /// Opens a page in a new tab.
    pub fn open(&mut self, url: &str, [width, height]: [u32; 2]) -> Tab {
        let target = self.send(None, "Target.createTarget", json!({ "url": "about:blank", "newWindow": true }));
        let attached =
            self.send(None, "Target.attachToTarget", json!({ "targetId": target["targetId"], "flatten": true }));
        let tab = Tab(attached["sessionId"].as_str().unwrap().to_owned());
        self.resize(&tab, [width, height]);
        self.send(Some(&tab), "Page.enable", json!({}));
        self.send(Some(&tab), "Page.navigate", json!({ "url": url }));
        self.wait(&tab, "location.href !== 'about:blank' && document.readyState === 'complete'");
        tab
    }

    /// Sets the size of a tab's window.
    pub fn resize(&mut self, tab: &Tab, [width, height]: [u32; 2]) {
        let size = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 500 });
        self.send(Some(tab), "Emulation.setDeviceMetricsOverride", size);
    }

    /// Chooses the light or the dark colors of a tab's page.
    pub fn choose_colors(&mut self, tab: &Tab, scheme: &str) {
        let features = json!([{ "name": "prefers-color-scheme", "value": scheme }]);
        self.send(Some(tab), "Emulation.setEmulatedMedia", json!({ "features": features }));
    }

    /// Value of a JavaScript expression, or of the promise that it is.
    pub fn value(&mut self, tab: &Tab, expression: &str) -> Value {
        let answer = self.send(Some(tab), "Runtime.evaluate", evaluation(expression));
        assert!(answer["exceptionDetails"].is_null(), "{expression}: {answer}");
        answer["result"]["value"].clone()
    }

    /// Waits until an expression is true. An expression that fails counts as false, and so does a page that is being loaded.
    #[track_caller]
    pub fn wait(&mut self, tab: &Tab, expression: &str) {
        let begin = Instant::now();
        let tried = format!("(() => {{ try {{ return Boolean({expression}) }} catch {{ return false }} }})()");
        let is_true =
            |answer: Result<Value, Value>| answer.is_ok_and(|answer| answer["result"]["value"] == json!(true));
        while !is_true(self.try_to_send(Some(tab), "Runtime.evaluate", evaluation(&tried))) {
            if begin.elapsed() > PATIENCE {
                let text = self.value(tab, "document.body?.innerText");
                panic!("not true within {PATIENCE:?}: {expression}; the page says {text}");
            }
            thread::sleep(Duration::from_millis(50));
        }
    }

    /// Clicks a point of the window.
    pub fn click(&mut self, tab: &Tab, [x, y]: [f64; 2]) {
        for kind in ["mouseMoved", "mousePressed", "mouseReleased"] {
            let button = if kind == "mouseMoved" { "none" } else { "left" };
            let event = json!({ "type": kind, "x": x, "y": y, "button": button, "clickCount": 1 });
            self.send(Some(tab), "Input.dispatchMouseEvent", event);
        }
    }

    /// Drags from one point of the window to another, in a few steps.
    pub fn drag(&mut self, tab: &Tab, from: [f64; 2], to: [f64; 2]) {
        const STEPS: u32 = 6;
        let at =
            |step: u32| [0, 1].map(|axis| from[axis] + (to[axis] - from[axis]) * f64::from(step) / f64::from(STEPS));
        let mut events = vec![("mouseMoved", 0, at(0)), ("mousePressed", 1, at(0))];
        events.extend((1..=STEPS).map(|step| ("mouseMoved", 1, at(step))));
        events.push(("mouseReleased", 0, at(STEPS)));
        for (kind, buttons, [x, y]) in events {
            let button = if buttons == 0 && kind == "mouseMoved" { "none" } else { "left" };
            let event = json!({ "type": kind, "x": x, "y": y, "button": button, "buttons": buttons, "clickCount": 1 });
            self.send(Some(tab), "Input.dispatchMouseEvent", event);
            thread::sleep(Duration::from_millis(60));
        }
    }

    /// Holds a key for a time.
    pub fn hold(&mut self, tab: &Tab, key: &str, code: &str, time: Duration) {
        for kind in ["keyDown", "keyUp"] {
            self.send(Some(tab), "Input.dispatchKeyEvent", json!({ "type": kind, "key": key, "code": code }));
            thread::sleep(time);
        }
    }

    /// Presses a key.
    pub fn press(&mut self, tab: &Tab, key: &str, code: u32) {
        for kind in ["keyDown", "keyUp"] {
            let event = json!({ "type": kind, "key": key, "code": key, "windowsVirtualKeyCode": code });
            self.send(Some(tab), "Input.dispatchKeyEvent", event);
        }
    }

    /// Saves a picture of a tab, if the environment names a folder for it.
    pub fn photograph(&mut self, tab: &Tab, name: &str) {
        let Some(folder) = env::var_os("LODESTAR_SCREENSHOTS") else { return };
        let whole = name.contains("390");
        let parameters = json!({ "format": "png", "captureBeyondViewport": whole });
        let shot = self.send(Some(tab), "Page.captureScreenshot", parameters);
        let path = PathBuf::from(folder).join(format!("{name}.png"));
        fs::write(path, base64(shot["data"].as_str().unwrap())).unwrap();
    }
}

/// Parameters of an evaluation.
fn evaluation(expression: &str) -> Value {
    json!({ "expression": expression, "awaitPromise": true, "returnByValue": true })
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.to.write_all(b"{\"id\":0,\"method\":\"Browser.close\"}\0");
        let begin = Instant::now();
        while begin.elapsed() < Duration::from_secs(3) && matches!(self.child.try_wait(), Ok(None)) {
            thread::sleep(Duration::from_millis(20));
        }
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn base64(text: &str) -> Vec<u8> {
    let value = |byte: u8| match byte {
        b'A'..=b'Z' => byte - b'A',
        b'a'..=b'z' => byte - b'a' + 26,
        b'0'..=b'9' => byte - b'0' + 52,
        b'+' => 62,
        _ => 63,
    };
    let digits: Vec<u8> = text.bytes().filter(|&byte| byte != b'=').map(value).collect();
    let group = |digits: &[u8]| {
        let bits = digits.iter().enumerate().fold(0_u32, |bits, (i, &digit)| bits | u32::from(digit) << (18 - 6 * i));
        bits.to_be_bytes()[1..digits.len()].to_vec()
    };
    digits.chunks(4).flat_map(group).collect()
}
