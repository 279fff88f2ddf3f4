//! Whole-file writes: a reader sees the old file or the new one, never a part of it.

use std::fs::{self, File, TryLockError};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

use crate::{Error, Result};

/// Age after which a temporary file that is empty, or whose folder knows no locks, counts as abandoned: a process that still
/// writes would have touched it.
const ABANDONED_AFTER: Duration = Duration::from_secs(10);
/// Most temporary files of this process's number that are passed over.
const MOST_LEFT_BEHIND: usize = 1000;
/// Command that makes a folder and those above it.
const MAKE_FOLDER: &str = if cfg!(windows) { "mkdir" } else { "mkdir -p" };
/// Endings of the pictures that a render writes.
pub const PICTURE_ENDINGS: [&str; 7] = ["exr", "png", "jpg", "jpeg", "tif", "tiff", "hdr"];

/// Number of temporary files made so far; it makes each temporary name unique within the process.
static TEMPORARY_COUNT: AtomicU32 = AtomicU32::new(0);

/// Writes `path` under a temporary name in the same folder and renames it once everything has reached the disk. The folder is
/// then synced too, so that a power failure after the return does not bring the older file back.
///
/// On failure the temporary file is removed and an older file of that name is left as it was. Only where the folder cannot be
/// synced is the new file in place already.
pub fn write_whole(path: &Path, write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>) -> Result<()> {
    let fill = || {
        let (temporary, file) = Temporary::create(path)?;
        let mut writer = BufWriter::new(file);
        write(&mut writer)?;
        writer.flush()?;
        writer.get_ref().sync_all()?;
        // The lock ends with the file, so it lasts until the file has its name.
        temporary.rename()
    };
    fill().map_err(Error::write(path))
}

/// Writes `value` as indented JSON, whole.
pub fn write_json(path: &Path, value: &impl serde::Serialize) -> Result<()> {
    write_whole(path, |writer| {
        serde_json::to_writer_pretty(&mut *writer, value)?;
        writeln!(writer)
    })
}

/// Checks that [`write_whole`] could write `path`, so that a long render is refused before it starts. Removes temporary
/// files of `path` that killed processes have left behind.
///
/// # Errors
/// [`Error::Write`] where the temporary file cannot be created.
pub fn check_writable(path: &Path) -> Result<()> {
    let (temporary, _) = Temporary::create(path).map_err(Error::write(path))?;
    remove_abandoned(&temporary.target);
    Ok(())
}

/// Whether the name of `path` ends in `extension`, in any case.
pub fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|found| found.eq_ignore_ascii_case(extension))
}

/// Whether a render writes pictures whose names end as that of `path` does.
pub fn is_picture(path: &Path) -> bool {
    PICTURE_ENDINGS.iter().any(|ending| has_extension(path, ending))
}

/// File that a write to `path` replaces, as an absolute path without links and `..`.
///
/// # Errors
/// Where the folder does not exist or may not be read.
pub fn written_file(path: &Path) -> io::Result<PathBuf> {
    match (path.canonicalize(), path.file_name()) {
        (Ok(file), _) => Ok(file),
        (Err(_), Some(name)) => Ok(folder_of(path).canonicalize()?.join(name)),
        (Err(error), None) => Err(error),
    }
}

/// Folder that holds the file at `path`.
pub fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Error of a temporary file that cannot be made for `target`, with the remedy where its folder is missing.
fn explained(error: io::Error, target: &Path) -> io::Error {
    let folder = folder_of(target);
    match fs::metadata(folder) {
        Err(missing) if missing.kind() == io::ErrorKind::NotFound => {
            let folder = folder.display();
            io::Error::other(format!(
                "there is no folder `{folder}`; make it first, such as by `{MAKE_FOLDER} {folder}`"
            ))
        }
        Ok(metadata) if !metadata.is_dir() => {
            io::Error::other(format!("`{}` is no folder; give another path", folder.display()))
        }
        _ => error,
    }
}

/// Removes temporary files of `target` whose processes have ended. Failures are ignored, because such a file does no harm.
fn remove_abandoned(target: &Path) {
    let (Some(name), Ok(entries)) = (target.file_name(), fs::read_dir(folder_of(target))) else { return };
    let prefix = format!(".{}.", name.to_string_lossy());
    for entry in entries.filter_map(io::Result::ok) {
        let name = entry.file_name();
        let owner = name.to_str().and_then(|name| name.strip_prefix(&prefix)?.strip_suffix(".part")?.split_once('-'));
        let Some(owner) = owner.and_then(|(id, _)| id.parse().ok()) else { continue };
        // In a container every process may have the number of this one, and on another machine, too.
        let is_left = is_gone(owner) || owner == std::process::id() && is_old(&entry.path());
        if is_left && is_abandoned(&entry.path()) {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// Whether the process with this number is known to have ended. Always false where there is no `/proc`.
fn is_gone(process: u32) -> bool {
    Path::new("/proc/self").exists() && !Path::new(&format!("/proc/{process}")).exists()
}

/// Whether nobody writes the temporary file at `path`. A process on another machine that shares the disk is not listed here, but
/// it holds the file's lock. A file without content may wait for its lock, so it must be old.
fn is_abandoned(path: &Path) -> bool {
    let Ok(file) = open_to_lock(path, false) else { return false };
    let Ok(metadata) = file.metadata() else { return false };
    match file.try_lock() {
        Ok(()) => metadata.len() > 0 || is_old(path),
        Err(TryLockError::WouldBlock) => false,
        Err(TryLockError::Error(_)) => is_old(path),
    }
}

/// Whether nobody has written to the file at `path` for some time.
fn is_old(path: &Path) -> bool {
    let modified = fs::symlink_metadata(path).and_then(|metadata| metadata.modified());
    modified.is_ok_and(|time| time.elapsed().is_ok_and(|age| age >= ABANDONED_AFTER))
}

/// Opens a file for its lock, and makes it if `is_made`. Others may have put anything there, so it is not waited for, no link is followed,
/// and it must be a regular file.
///
/// # Errors
/// Where there is no such file, or it is no regular file.
pub fn open_to_lock(path: &Path, is_made: bool) -> io::Result<File> {
    let mut options = File::options();
    options.write(true).create(is_made).truncate(false);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::custom_flags(&mut options, libc::O_NONBLOCK | libc::O_NOFOLLOW | libc::O_NOCTTY);
    let is_regular = |metadata: &fs::Metadata| metadata.is_file();
    let refused = || io::Error::other(format!("`{}` is no regular file; remove it", path.display()));
    // A device may act when it is opened.
    if fs::symlink_metadata(path).is_ok_and(|metadata| !is_regular(&metadata)) {
        return Err(refused());
    }
    let file = options.open(path)?;
    if is_regular(&file.metadata()?) { Ok(file) } else { Err(refused()) }
}

/// Makes the names in the folder of `path` reach the disk. Folders that cannot be opened, and systems that cannot sync a folder,
/// are left alone.
fn sync_folder(path: &Path) -> io::Result<()> {
    let Ok(folder) = File::options().read(true).open(folder_of(path)) else { return Ok(()) };
    match folder.sync_all() {
        Err(error) if !matches!(error.kind(), ErrorKind::InvalidInput | ErrorKind::Unsupported) => Err(error),
        _ => Ok(()),
    }
}

/// Temporary file that is removed when dropped, unless it was renamed to its target.
struct Temporary {
    path: PathBuf,
    target: PathBuf,
    renamed: bool,
}

impl Temporary {
    fn create(path: &Path) -> io::Result<(Self, File)> {
        let target = target_of(path)?;
        let name = target.file_name().ok_or_else(|| io::Error::other("the path names no file; give a file name"))?;
        let make = || {
            let number = TEMPORARY_COUNT.fetch_add(1, Ordering::Relaxed);
            let name = format!(".{}.{}-{number}.part", name.to_string_lossy(), std::process::id());
            let path = target.with_file_name(name);
            (File::options().write(true).create_new(true).open(&path), path)
        };
        let (mut file, mut path) = make();
        // A process of this number may have left files behind, as in a container, where all have the number 1.
        for _ in 0..MOST_LEFT_BEHIND {
            if !file.as_ref().is_err_and(|error| error.kind() == ErrorKind::AlreadyExists) {
                break;
            }
            (file, path) = make();
        }
        let file = file.map_err(|error| explained(error, &target))?;
        // The lock tells others that the file is being written. Where the disk knows no locks, the file's age does.
        let _ = file.try_lock();
        Ok((Self { path, target, renamed: false }, file))
    }

    fn rename(mut self) -> io::Result<()> {
        fs::rename(&self.path, &self.target)?;
        self.renamed = true;
        sync_folder(&self.target)
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if !self.renamed {
            // A failure here is ignored: the caller already reports the first one.
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// Final path of a write to `path`: symbolic links are followed, because renaming would replace the link itself.
/// Folders and devices are refused.
fn target_of(path: &Path) -> io::Result<PathBuf> {
    match fs::metadata(path) {
        Ok(metadata) if metadata.is_dir() => Err(io::Error::other("it is a folder; give a file name")),
        Ok(metadata) if !metadata.is_file() => Err(io::Error::other("it is not a regular file; give another name")),
        Ok(_) => path.canonicalize(),
        Err(_) => Ok(path.to_path_buf()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::SystemTime;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn writes_and_replaces() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        for text in ["first", "second"] {
            write_whole(&path, |writer| writer.write_all(text.as_bytes())).unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), text);
        }
        assert_eq!(names(folder.path()), ["a.txt"]);
    }

    #[test]
    fn json_is_indented_and_ends_its_line() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.json");
        write_json(&path, &std::collections::BTreeMap::from([("spp", 64)])).unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "{\n  \"spp\": 64\n}\n");
    }

    #[test]
    fn failure_leaves_the_old_file_and_no_other() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        fs::write(&path, "old").unwrap();
        let error = write_whole(&path, |writer| {
            writer.write_all(&[0; 1 << 16])?;
            Err(io::Error::other("disk on fire"))
        });
        assert_eq!(error.unwrap_err().to_string(), format!("{}: cannot be written: disk on fire", path.display()));
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(names(folder.path()), ["a.txt"]);
    }

    #[test]
    fn refuses_what_cannot_be_written() {
        let folder = tempfile::tempdir().unwrap();
        for path in [folder.path().to_path_buf(), folder.path().join("missing/a.txt"), PathBuf::from("")] {
            assert!(check_writable(&path).is_err(), "{}", path.display());
            assert!(write_whole(&path, |_| Ok(())).is_err(), "{}", path.display());
        }
        assert!(check_writable(&folder.path().join("a.txt")).is_ok());
        assert!(names(folder.path()).is_empty());
    }

    #[test]
    fn a_missing_folder_is_named_with_the_remedy() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("file"), "").unwrap();
        let error = |name: &str| check_writable(&folder.path().join(name)).unwrap_err().to_string();
        let missing = folder.path().join("missing/inner");
        assert!(
            error("missing/inner/a.exr")
                .ends_with(&format!("make it first, such as by `mkdir -p {}`", missing.display()))
        );
        assert!(error("file/a.exr").ends_with("file` is no folder; give another path"), "{}", error("file/a.exr"));
    }

    /// In a container a new process may have the number of a killed one, whose files are still there.
    #[test]
    fn files_that_a_process_of_this_number_left_are_passed_over() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        let next = TEMPORARY_COUNT.load(Ordering::Relaxed);
        for number in next..next + 20 {
            fs::write(folder.path().join(format!(".a.txt.{}-{number}.part", std::process::id())), "left").unwrap();
        }
        write_whole(&path, |writer| writer.write_all(b"whole")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"whole");
    }

    /// Whoever can write into a folder can put a pipe there. Nothing waits for it.
    #[cfg(unix)]
    #[test]
    fn pipes_and_links_are_not_locked() {
        let folder = tempfile::tempdir().unwrap();
        let (pipe, link) = (folder.path().join(".a.txt.4194305-0.part"), folder.path().join("link"));
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        std::os::unix::fs::symlink(folder.path().join("target"), &link).unwrap();
        for path in [&pipe, &link] {
            assert!(open_to_lock(path, true).is_err_and(|error| error.to_string().contains("is no regular file")));
        }
        check_writable(&folder.path().join("a.txt")).unwrap();
        assert!(!folder.path().join("target").exists());
    }

    #[test]
    fn extensions_have_any_case() {
        for (name, is_png) in [("a.png", true), ("a.PNG", true), ("a.Png", true), ("a.exr", false), ("png", false)] {
            assert_eq!(has_extension(Path::new(name), "png"), is_png, "{name}");
        }
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn what_killed_processes_left_is_cleared_away() {
        let folder = tempfile::tempdir().unwrap();
        let own = std::process::id();
        // Linux gives no process number above 2^22.
        let gone = (1 << 22) + 1;
        let old = SystemTime::now() - Duration::from_secs(3600);
        let make = |name: &str, content: &str, modified| {
            fs::write(folder.path().join(name), content).unwrap();
            File::options().write(true).open(folder.path().join(name)).unwrap().set_modified(modified).unwrap();
        };
        let now = SystemTime::now();
        let gone = |number: u32| format!(".a.txt.{gone}-{number}.part");
        make(&gone(0), "", old);
        make(&gone(1), "content", now);
        // A process in another container had this number, too.
        make(&format!(".a.txt.{own}-7.part"), "content", old);
        let kept = [
            gone(2),
            gone(3),
            format!(".a.txt.{own}-8.part"),
            ".a.txt.notes.part".into(),
            gone(0).replace("a.txt", "b.txt"),
        ];
        for (name, content) in kept.iter().zip(["", "content", "content", "content", "content"]) {
            make(name, content, if [gone(2), format!(".a.txt.{own}-8.part")].contains(name) { now } else { old });
        }
        // A process on another machine writes this file.
        let locked = File::options().write(true).open(folder.path().join(gone(3))).unwrap();
        locked.lock().unwrap();
        check_writable(&folder.path().join("a.txt")).unwrap();
        let mut kept = kept.to_vec();
        kept.sort();
        assert_eq!(names(folder.path()), kept);
        drop(locked);
        check_writable(&folder.path().join("a.txt")).unwrap();
        assert!(!folder.path().join(gone(3)).exists());
    }

    #[test]
    fn a_file_that_is_written_is_locked() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        write_whole(&path, |_| {
            let part = fs::read_dir(folder.path())?.next().expect("a temporary file")?.path();
            let locked = File::options().write(true).open(part)?.try_lock();
            assert!(matches!(locked, Err(TryLockError::WouldBlock)));
            Ok(())
        })
        .unwrap();
    }

    #[cfg(unix)]
    #[test]
    fn links_and_dots_are_resolved() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path().canonicalize().unwrap();
        fs::create_dir(root.join("inner")).unwrap();
        fs::write(root.join("target"), "").unwrap();
        std::os::unix::fs::symlink(root.join("target"), root.join("inner/link")).unwrap();
        std::os::unix::fs::symlink(root.join("absent"), root.join("inner/dangling")).unwrap();
        for (path, expected) in [
            ("inner/../new", Some("new")),
            ("inner/link", Some("target")),
            // A write replaces a link that leads nowhere.
            ("inner/dangling", Some("inner/dangling")),
            ("missing/new", None),
            ("..", None),
        ] {
            let found = written_file(&root.join(path)).ok().filter(|found| found.starts_with(&root));
            assert_eq!(found, expected.map(|name| root.join(name)), "{path}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn devices_and_links_survive() {
        assert!(write_whole(Path::new("/dev/null"), |_| Ok(())).is_err());
        let folder = tempfile::tempdir().unwrap();
        let link = folder.path().join("link");
        let target = folder.path().join("target");
        fs::write(&target, "old").unwrap();
        std::os::unix::fs::symlink(&target, &link).unwrap();
        write_whole(&link, |writer| writer.write_all(b"new")).unwrap();
        assert!(link.is_symlink());
        assert_eq!(fs::read_to_string(&target).unwrap(), "new");
    }
}
