//! Folder to run the program in, and checks of its output.

use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStderr, Command, ExitStatus, Output, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

/// Scene of a lit wall in front of the camera. Its sampler asks for 12 samples per pixel.
pub const SCENE: &str = r#"<scene version="3.0.0">
	<default name="gray" value="0.5"/>
	<integrator type="path"/>
	<sensor type="perspective">
		<sampler type="independent"><integer name="sample_count" value="12"/></sampler>
		<film type="hdrfilm">
			<integer name="width" value="16"/><integer name="height" value="12"/>
			<rfilter type="box"/>
		</film>
	</sensor>
	<emitter type="constant"/>
	<shape type="cube">
		<transform name="to_world"><translate z="5"/></transform>
		<bsdf type="diffuse"><rgb name="reflectance" value="$gray"/></bsdf>
	</shape>
</scene>
"#;

/// Maximum time for anything that should take a moment. Other tests keep the cores busy.
const PATIENCE: Duration = Duration::from_secs(30);

/// Folder of caches that all tests of the program share: a kernel is then built once and not once for each test.
pub const SHARED_CACHE: &str = concat!(env!("CARGO_TARGET_TMPDIR"), "/cache");

/// Temporary folder, which is the program's working directory.
pub struct Folder(tempfile::TempDir);

impl Folder {
    /// Folder with `scene.xml` in it.
    pub fn new() -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        folder.write("scene.xml", SCENE);
        folder
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).unwrap();
    }

    pub fn read_json(&self, name: &str) -> Value {
        serde_json::from_str(&fs::read_to_string(self.path(name)).unwrap()).unwrap()
    }

    /// Names of all files below the folder.
    pub fn names(&self) -> Vec<String> {
        let mut names = Vec::new();
        collect_names(self.0.path(), "", &mut names);
        names.sort();
        names
    }

    /// Command that runs the program in this folder.
    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lodestar"));
        command.args(arguments);
        self.prepare(&mut command);
        command
    }

    /// Lets a command run in this folder.
    fn prepare(&self, command: &mut Command) {
        command.current_dir(self.0.path());
        command.env("XDG_CACHE_HOME", SHARED_CACHE).env_remove("LODESTAR_DEVICE");
    }

    /// Runs the program to its end.
    pub fn run(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().unwrap()
    }

    /// Runs the program to its end where no program of SPIRV-Tools is found.
    pub fn without_tools(&self, arguments: &[&str]) -> Output {
        self.command(arguments).env("PATH", "/nowhere").output().unwrap()
    }

    /// Renders `scene.xml` with more arguments and returns the statistics.
    pub fn render(&self, arguments: &[&str]) -> Value {
        self.render_scene("scene.xml", arguments)
    }

    /// Renders the given scene with more arguments and returns the statistics.
    pub fn render_scene(&self, scene: &str, arguments: &[&str]) -> Value {
        let all = [&["render", scene, "--quiet", "--stats", "stats.json"], arguments].concat();
        assert_quiet_success(&self.run(&all));
        self.read_json("stats.json")
    }

    /// Starts the program.
    pub fn start(&self, arguments: &[&str]) -> Running {
        self.start_process(&mut self.command(arguments))
    }

    /// Starts a command in this folder.
    pub fn start_process(&self, command: &mut Command) -> Running {
        self.prepare(command);
        let mut child = command.stderr(Stdio::piped()).spawn().unwrap();
        let stderr = BufReader::new(child.stderr.take().unwrap());
        Running { child, stderr }
    }
}

fn collect_names(folder: &Path, prefix: &str, names: &mut Vec<String>) {
    for entry in fs::read_dir(folder).unwrap().map(Result::unwrap) {
        let name = format!("{prefix}{}", entry.file_name().to_str().unwrap());
        match entry.file_type().unwrap().is_dir() {
            true => collect_names(&entry.path(), &format!("{name}/"), names),
            false => names.push(name),
        }
    }
}

/// The running program. It is killed when this is dropped, so that a failing test leaves nothing behind.
pub struct Running {
    child: Child,
    stderr: BufReader<ChildStderr>,
}

impl Running {
    /// Waits for a line on standard error that contains `word` and returns it.
    pub fn wait_for_line(&mut self, word: &str) -> String {
        let mut line = String::new();
        while !line.contains(word) {
            line.clear();
            assert_ne!(self.stderr.read_line(&mut line).unwrap(), 0, "the program ended before it said {word}");
        }
        line
    }

    /// Sends the signal with the given name.
    pub fn signal(&self, name: &str) {
        let pid = self.child.id().to_string();
        assert!(Command::new("kill").args([&format!("-{name}"), &pid]).status().unwrap().success());
    }

    pub fn is_running(&mut self) -> bool {
        self.child.try_wait().unwrap().is_none()
    }

    /// Waits for the end. Returns the exit code and the rest of standard error.
    pub fn wait(mut self) -> (Option<i32>, String) {
        let status: ExitStatus = wait_until(|| self.child.try_wait().unwrap());
        let mut rest = String::new();
        self.stderr.read_to_string(&mut rest).unwrap();
        (status.code(), rest)
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // Most programs have ended by themselves.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Calls `ask` until it returns a value.
pub fn wait_until<T>(mut ask: impl FnMut() -> Option<T>) -> T {
    let begin = Instant::now();
    loop {
        if let Some(answer) = ask() {
            return answer;
        }
        assert!(begin.elapsed() < PATIENCE, "nothing happened for {PATIENCE:?}");
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// Fails unless the program ended with `code` and one sentence on standard error that contains `words`.
#[track_caller]
pub fn assert_sentence(output: &Output, code: i32, words: &[&str]) {
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{error}");
    assert!(output.stdout.is_empty(), "{}", String::from_utf8_lossy(&output.stdout));
    assert!(error.starts_with("lodestar: error: ") && error.ends_with('\n') && error.lines().count() == 1, "{error}");
    for word in words {
        assert!(error.contains(word), "{error} lacks {word}");
    }
}

/// Fails unless the program succeeded and said nothing.
#[track_caller]
pub fn assert_quiet_success(output: &Output) {
    let said = [&output.stdout, &output.stderr].map(|said| String::from_utf8_lossy(said).into_owned());
    assert_eq!((output.status.code(), said), (Some(0), [String::new(), String::new()]));
}

/// Fails unless the program succeeded and said only that it wrote the file `name`.
#[track_caller]
pub fn assert_written(output: &Output, name: &str) {
    let said = [&output.stdout, &output.stderr].map(|said| String::from_utf8_lossy(said).into_owned());
    assert_eq!((output.status.code(), said), (Some(0), [String::new(), format!("wrote {name}\n")]));
}

/// Names of an object's members, sorted.
pub fn keys(value: &Value) -> Vec<&str> {
    let mut keys: Vec<_> = value.as_object().unwrap().keys().map(String::as_str).collect();
    keys.sort_unstable();
    keys
}

/// Text of an attribute of an EXR picture.
pub fn attribute(path: &Path, name: &str) -> String {
    let attributes = lodestar::image::exr::read_attributes(path).unwrap();
    let found = attributes.into_iter().find(|(found, _)| found == name);
    found.unwrap_or_else(|| panic!("{} has no attribute {name}", path.display())).1
}
