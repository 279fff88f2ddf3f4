//! The program with its page, and requests to it.

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStderr, Command, Stdio};
use std::time::{Duration, Instant};

use lodestar::image::layers::Layers;
use lodestar::image::{Image, exr};
use serde_json::Value;

use crate::browser::PATIENCE;

/// Folder of caches that all tests of the program share.
const CACHE: &str = concat!(env!("CARGO_TARGET_TMPDIR"), "/cache");
/// Name of the picture of [`Program::start_view`].
pub const PICTURE: &str = "shown.exr";
/// Scene whose light is known.
pub const SCENE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/cornell-box/scene.xml");

/// A running program. It is killed when this is dropped.
pub struct Program {
    child: Child,
    /// Address of the page, with the token.
    pub url: String,
    stderr: BufReader<ChildStderr>,
    folder: tempfile::TempDir,
}

/// Answer to a request: the status, and what follows the headers.
pub type Answer = (u16, Vec<u8>);

/// Arguments of a render of a small Cornell box.
pub fn render<'a>(more: &[&'a str]) -> Vec<&'a str> {
    let fixed = ["render", SCENE, "--quiet", "--nee", "off", "--width", "96", "--height", "96", "-o", "a.exr"];
    [&fixed[..], more].concat()
}

/// Arguments of a render that goes on until it is ended.
pub fn endless<'a>() -> Vec<&'a str> {
    render(&["--time", "1h", "--view"])
}

impl Program {
    /// Starts the program and waits for the address of its page.
    pub fn start(arguments: &[&str]) -> Self {
        Self::start_silent(arguments).with_address()
    }

    fn with_address(mut self) -> Self {
        let mut line = String::new();
        self.stderr.read_line(&mut line).unwrap();
        let url = line.split_whitespace().find(|word| word.starts_with("http://"));
        self.url = url.unwrap_or_else(|| panic!("no address in {line}")).to_owned();
        self
    }

    /// Starts the program.
    pub fn start_silent(arguments: &[&str]) -> Self {
        Self::start_with(arguments, None)
    }

    /// Starts the program. `denoiser` is the folder of Open Image Denoise, or an empty folder for none.
    pub fn start_with_denoiser(arguments: &[&str], denoiser: &Path) -> Self {
        Self::start_with(arguments, Some(denoiser)).with_address()
    }

    fn start_with(arguments: &[&str], denoiser: Option<&Path>) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_lodestar"));
        command.args(arguments).current_dir(folder.path());
        command.env("XDG_CACHE_HOME", CACHE).env_remove("LODESTAR_DEVICE").env_remove("LODESTAR_VIEW_TOKEN");
        if let Some(folder) = denoiser {
            command.env("LODESTAR_OIDN", folder);
        }
        Self::start_command(command, folder)
    }

    /// Starts the page of a small picture. Its process does nothing else.
    pub fn start_view() -> Self {
        Self::start_view_in("unlimited", None)
    }

    /// Starts the page of a small picture in a process that may open so many files.
    pub fn start_view_with_files(most: u32) -> Self {
        Self::start_view_in(&most.to_string(), None)
    }

    /// Starts the page of a small picture with a token of the user.
    pub fn start_view_with_token(token: &str) -> Self {
        Self::start_view_in("unlimited", Some(token))
    }

    fn start_view_in(files: &str, token: Option<&str>) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(PICTURE);
        let image = Image { width: 64, height: 64, pixels: vec![[0.25, 0.5, 1.0]; 64 * 64] };
        fs::write(&path, exr::encode_rgb(&path, &image).unwrap()).unwrap();
        let mut command = Command::new("sh");
        command.args(["-c", "[ \"$1\" = unlimited ] || ulimit -n \"$1\"; exec \"$0\" view \"$2\""]);
        command.arg(env!("CARGO_BIN_EXE_lodestar")).args([files, PICTURE]).current_dir(folder.path());
        command.env("LODESTAR_VIEW_TOKEN", token.unwrap_or_default());
        Self::start_command(command, folder).with_address()
    }

    fn start_command(mut command: Command, folder: tempfile::TempDir) -> Self {
        let mut child = command.stderr(Stdio::piped()).stdout(Stdio::null()).spawn().unwrap();
        let stderr = BufReader::new(child.stderr.take().unwrap());
        Self { child, url: String::new(), stderr, folder }
    }

    /// Sends a signal by its name.
    pub fn signal(&self, name: &str) {
        let status = Command::new("kill").args([&format!("-{name}"), &self.child.id().to_string()]).status();
        assert!(status.unwrap().success());
    }

    /// Memory of the process in MiB: `VmHWM`, the most so far, or `VmRSS`, that of now.
    pub fn memory(&self, kind: &str) -> f64 {
        let status = fs::read_to_string(format!("/proc/{}/status", self.child.id())).unwrap();
        let line = status.lines().find_map(|line| line.strip_prefix(kind)?.strip_prefix(':')).unwrap();
        line.split_whitespace().next().unwrap().parse::<f64>().unwrap() / 1024.0
    }

    /// Lets the process open so many files more than it has open.
    pub fn limit_files_to_those_open_and(&self, more: usize) {
        let id = self.child.id();
        let most = fs::read_dir(format!("/proc/{id}/fd")).unwrap().count() + more;
        let status = Command::new("prlimit").args(["--pid", &id.to_string(), &format!("--nofile={most}:")]).status();
        assert!(status.unwrap().success());
    }

    /// Rest of the messages of a program that has ended.
    pub fn messages(&mut self) -> String {
        let mut text = String::new();
        self.stderr.read_to_string(&mut text).unwrap();
        text
    }

    /// Address and token.
    pub fn address(&self) -> (&str, &str) {
        self.url.strip_prefix("http://").unwrap().split_once("/#").unwrap()
    }

    pub fn is_running(&mut self) -> bool {
        self.child.try_wait().unwrap().is_none()
    }

    /// Waits for the end. Returns the exit code.
    pub fn wait(&mut self) -> Option<i32> {
        let begin = Instant::now();
        while self.is_running() {
            assert!(begin.elapsed() < PATIENCE, "the program does not end");
            std::thread::sleep(Duration::from_millis(10));
        }
        self.child.wait().unwrap().code()
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Sends a request with these lines of headers.
    pub fn ask(&self, request: &str, headers: &[&str]) -> Answer {
        ask(self.address().0, request, headers)
    }

    /// Sends a request as the page does.
    pub fn ask_as_page(&self, request: &str) -> Answer {
        let (address, token) = self.address();
        self.ask(request, &[&format!("Host: {address}"), &format!("X-Lodestar-Token: {token}")])
    }

    /// State that the first event holds.
    pub fn state(&self) -> Value {
        let mut stream = self.listen();
        let mut lines = BufReader::new(&mut stream).lines().map_while(Result::ok);
        let data = lines.find_map(|line| line.strip_prefix("data: ").map(str::to_owned)).unwrap();
        serde_json::from_str(&data).unwrap()
    }

    /// Connection that receives events.
    pub fn listen(&self) -> TcpStream {
        let (address, token) = self.address();
        let mut stream = TcpStream::connect(address).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        write!(stream, "GET /events HTTP/1.1\r\nHost: {address}\r\nX-Lodestar-Token: {token}\r\n\r\n").unwrap();
        stream
    }

    /// Waits until the state is as wanted.
    #[track_caller]
    pub fn wait_for(&self, wanted: impl Fn(&Value) -> bool) -> Value {
        let begin = Instant::now();
        loop {
            let state = self.state();
            if wanted(&state) {
                return state;
            }
            assert!(begin.elapsed() < PATIENCE, "{state}");
            std::thread::sleep(Duration::from_millis(30));
        }
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        // Most programs have ended by themselves.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn ask(address: &str, request: &str, headers: &[&str]) -> Answer {
    let mut stream = TcpStream::connect(address).unwrap();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    let headers: String = headers.iter().map(|line| format!("{line}\r\n")).collect();
    write!(stream, "{request} HTTP/1.1\r\n{headers}Connection: close\r\nContent-Length: 0\r\n\r\n").unwrap();
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer).unwrap();
    let end = answer.windows(4).position(|four| four == b"\r\n\r\n").expect("headers");
    let status = std::str::from_utf8(&answer[9..12]).unwrap().parse().unwrap();
    (status, answer[end + 4..].to_vec())
}

/// Layers of a picture file.
pub fn layers(path: &Path) -> Layers {
    exr::read_layers(path).unwrap().0
}

/// Server on a free port of this machine.
pub fn listener() -> (TcpListener, String) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    (listener, address)
}

/// Size of a file in bytes.
pub fn size(path: &Path) -> u64 {
    fs::metadata(path).unwrap().len()
}
