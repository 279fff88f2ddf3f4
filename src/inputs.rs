//! Files that others have made. They are opened here and nowhere else: without waiting, regular files only, and nothing is read beyond the
//! length that a file has when it is opened. So a pipe, a device or a file of the system that never ends cannot hold up a render.

use std::fs::{self, File, FileType, Metadata, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

use crate::{Error, Result};

/// Beginning of the text that stands for a file in a repository whose large files were not fetched.
const GIT_LFS_POINTER: &[u8] = b"version https://git-lfs";

/// An open file, which ends at the length that it had when it was opened.
#[derive(Debug)]
pub struct Input {
    file: File,
    length: u64,
    at: u64,
}

impl Input {
    /// The file itself, for readers that keep to its length on their own.
    pub fn into_file(self) -> File {
        self.file
    }
}

impl Read for Input {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let left = usize::try_from(self.length.saturating_sub(self.at)).unwrap_or(usize::MAX);
        let most = buffer.len().min(left);
        // A file of the system may wait even for nothing.
        let count = if most == 0 { 0 } else { self.file.read(&mut buffer[..most])? };
        self.at += count as u64;
        Ok(count)
    }
}

impl Seek for Input {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.at = self.file.seek(to)?;
        Ok(self.at)
    }
}

/// Opens a file whose content is read piece by piece. The second value is its length in bytes.
///
/// # Errors
/// [`Error::Read`] where there is no such file, or it is no regular file.
pub fn open(path: &Path) -> Result<(Input, u64)> {
    let (file, length) = open_regular(path).map_err(Error::read(path))?;
    Ok((Input { file, length, at: 0 }, length))
}

/// Reads a whole file of up to `limit` bytes.
///
/// # Errors
/// [`Error::Read`] where there is no such file, it is no regular file, it is longer, or it only stands for a file that was not fetched.
pub fn read(path: &Path, limit: u64) -> Result<Vec<u8>> {
    read_within(path, limit).map_err(Error::read(path))
}

fn read_within(path: &Path, limit: u64) -> io::Result<Vec<u8>> {
    let (file, length) = open_regular(path)?;
    if length > limit {
        return Err(io::Error::other(format!("a file of {length} bytes is refused; the limit is {limit}")));
    }
    let mut bytes = Vec::new();
    let room = usize::try_from(length).ok().and_then(|length| bytes.try_reserve_exact(length).ok());
    room.ok_or_else(|| io::Error::other(format!("there is no memory for its {length} bytes")))?;
    file.take(length).read_to_end(&mut bytes)?;
    match bytes.starts_with(GIT_LFS_POINTER) {
        true => Err(io::Error::other("it is a git-lfs pointer, not the file itself; fetch it with `git lfs pull`")),
        false => Ok(bytes),
    }
}

fn open_regular(path: &Path) -> io::Result<(File, u64)> {
    // A device may act when it is opened, so the file is asked first by its name. The name may lead elsewhere a moment later, so the open
    // file is asked again.
    check_regular(&fs::metadata(path)?)?;
    let file = without_waiting().open(path)?;
    let metadata = file.metadata()?;
    check_regular(&metadata)?;
    Ok((file, metadata.len()))
}

/// Options that read, and do not wait for the other end of a pipe.
#[cfg(unix)]
fn without_waiting() -> OpenOptions {
    use std::os::unix::fs::OpenOptionsExt;
    let mut options = File::options();
    options.read(true).custom_flags(libc::O_NONBLOCK | libc::O_NOCTTY);
    options
}

#[cfg(not(unix))]
fn without_waiting() -> OpenOptions {
    let mut options = File::options();
    options.read(true);
    options
}

fn check_regular(metadata: &Metadata) -> io::Result<()> {
    if metadata.is_file() {
        return Ok(());
    }
    let advice = match metadata.is_dir() {
        true => "name a file in it",
        false => "save its content as a file, and name that",
    };
    Err(io::Error::other(format!("it is {}, not a regular file; {advice}", kind(metadata.file_type()))))
}

#[cfg(unix)]
fn kind(kind: FileType) -> &'static str {
    use std::os::unix::fs::FileTypeExt;
    match kind {
        kind if kind.is_dir() => "a folder",
        kind if kind.is_fifo() => "a pipe",
        kind if kind.is_socket() => "a socket",
        _ => "a device",
    }
}

#[cfg(not(unix))]
fn kind(kind: FileType) -> &'static str {
    if kind.is_dir() { "a folder" } else { "a device" }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn only_regular_files_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let (file, empty, link) = (folder.path().join("file"), folder.path().join("empty"), folder.path().join("link"));
        fs::write(&file, "content").unwrap();
        fs::write(&empty, "").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        for path in [&file, &link] {
            assert_eq!(read(path, 7).unwrap(), b"content");
            assert_eq!(open(path).unwrap().1, 7);
        }
        assert_eq!(read(&empty, 7).unwrap(), b"");
        let error = |path: &Path| read(path, 6).unwrap_err().to_string();
        assert!(
            error(&file).ends_with("cannot be read: a file of 7 bytes is refused; the limit is 6"),
            "{}",
            error(&file)
        );
        assert_eq!(open(&empty).unwrap().1, 0);
        let socket = folder.path().join("socket");
        let _listener = std::os::unix::net::UnixListener::bind(&socket).unwrap();
        for (path, kind) in [(Path::new("/dev/zero"), "a device"), (&socket, "a socket"), (folder.path(), "a folder")] {
            assert!(
                error(path).contains(&format!("cannot be read: it is {kind}, not a regular file; ")),
                "{}",
                error(path)
            );
            assert!(open(path).unwrap_err().to_string().contains(kind));
        }
    }

    #[test]
    fn an_open_file_ends_where_it_ended_when_it_was_opened() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        fs::write(&path, "content").unwrap();
        let (mut input, _) = open(&path).unwrap();
        fs::write(&path, "content and more").unwrap();
        let mut text = String::new();
        input.read_to_string(&mut text).unwrap();
        assert_eq!(text, "content");
        input.seek(SeekFrom::Start(3)).unwrap();
        text.clear();
        input.read_to_string(&mut text).unwrap();
        assert_eq!(text, "tent");
        input.seek(SeekFrom::End(0)).unwrap();
        assert_eq!(input.read_to_string(&mut text).unwrap(), 0);
    }

    /// Files of the system have no length. What they would give is never read.
    #[cfg(target_os = "linux")]
    #[test]
    fn nothing_is_read_beyond_the_length() {
        let environment = Path::new("/proc/self/environ");
        assert_eq!(read(environment, 1 << 20).unwrap(), b"");
        let mut bytes = Vec::new();
        assert_eq!(open(environment).unwrap().0.read_to_end(&mut bytes).unwrap(), 0);
    }
}
