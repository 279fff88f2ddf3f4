//! Lock of a checkpoint's file, so that one render at a time keeps its state there.
//!
//! The lock is that of an empty file beside the checkpoint, because each new checkpoint takes the place of the older one. The system
//! ends the lock with its process, however the process ends. An empty file that a killed process leaves locks nothing, and the next
//! render removes it. Between machines that share a disk, the lock holds where the disk's server keeps locks, as NFS 4 does.

use std::fs::{self, File, TryLockError};
#[cfg(unix)]
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::process;

use crate::files::{self, folder_of};
use crate::{Error, Result};

/// How often a lock file is made again that another process has removed just then.
const TRIES: usize = 100;

/// A lock that this process holds.
#[derive(Debug)]
pub(super) struct CheckpointLock {
    path: PathBuf,
    file: File,
    /// The process that has made the lock. A child that it forks must not remove the file.
    process: u32,
}

impl CheckpointLock {
    /// Takes the lock of the checkpoint at `checkpoint`. There is none where the disk keeps no locks.
    ///
    /// # Errors
    /// Where another render has the lock, or no file can be made in the folder.
    pub fn take(checkpoint: &Path) -> Result<Option<Self>> {
        let Some(path) = lock_file(checkpoint) else {
            // The folder is missing or cannot be read, which the check of the checkpoint itself says.
            return files::check_writable(checkpoint).map(|()| None);
        };
        for _ in 0..TRIES {
            let file = files::open_to_lock(&path, true).map_err(Error::write(checkpoint))?;
            match file.try_lock() {
                Ok(()) if is_at(&file, &path) => return Ok(Some(Self { path, file, process: process::id() })),
                // The process that had the lock has removed the file.
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => break,
                Err(TryLockError::Error(_)) => {
                    let _ = fs::remove_file(&path);
                    return Ok(None);
                }
            }
        }
        let message = "another render keeps its checkpoint in this file; wait until it ends, or give another name";
        Err(Error::checkpoint(checkpoint, message))
    }
}

impl Drop for CheckpointLock {
    fn drop(&mut self) {
        // Somebody may have removed the file, and another render may have made one of this name.
        if self.process == process::id() && is_at(&self.file, &self.path) {
            // A file that stays harms nobody.
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// Name of the lock's file. Two names of one checkpoint have one lock.
fn lock_file(checkpoint: &Path) -> Option<PathBuf> {
    let file = files::written_file(checkpoint).ok()?;
    let name = format!(".{}.lock", file.file_name()?.to_string_lossy());
    Some(folder_of(&file).join(name))
}

/// Whether `path` still names the open file. The name of a file that is removed on Windows stays until all have closed it, so no other file
/// can have it.
#[cfg(not(unix))]
fn is_at(_: &File, path: &Path) -> bool {
    path.exists()
}

/// Whether `path` still names the open file.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    let place = |metadata: fs::Metadata| (metadata.dev(), metadata.ino());
    let open = file.metadata().map(place);
    open.is_ok_and(|open| fs::metadata(path).is_ok_and(|named| place(named) == open))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_at_a_time_by_any_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.ckpt");
        fs::write(&path, "").unwrap();
        let link = folder.path().join("b.ckpt");
        std::os::unix::fs::symlink(&path, &link).unwrap();
        let lock = CheckpointLock::take(&path).unwrap();
        assert!(lock.is_some());
        for name in [&path, &link, &folder.path().join("../").join(folder.path().file_name().unwrap()).join("a.ckpt")] {
            let error = CheckpointLock::take(name).unwrap_err().to_string();
            assert!(error.contains("another render keeps its checkpoint"), "{error}");
        }
        assert!(CheckpointLock::take(&folder.path().join("c.ckpt")).unwrap().is_some());
        drop(lock);
        assert!(CheckpointLock::take(&link).unwrap().is_some());
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
    }

    /// Somebody removes the file of a lock, and another render takes its own. The end of the first render leaves that one alone.
    #[cfg(unix)]
    #[test]
    fn a_lock_removes_its_own_file_only() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.ckpt");
        let first = CheckpointLock::take(&path).unwrap();
        fs::remove_file(folder.path().join(".a.ckpt.lock")).unwrap();
        let second = CheckpointLock::take(&path).unwrap();
        drop(first);
        assert!(CheckpointLock::take(&path).is_err());
        drop(second);
        assert!(CheckpointLock::take(&path).unwrap().is_some());
    }

    #[test]
    fn what_a_killed_process_left_locks_nothing() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join(".a.ckpt.lock"), "").unwrap();
        assert!(CheckpointLock::take(&folder.path().join("a.ckpt")).unwrap().is_some());
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    /// Many threads take and leave one lock until each has had it often. Two never have it at once.
    #[test]
    fn taking_and_leaving_never_lets_two_in() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.ckpt");
        let inside = std::sync::atomic::AtomicU32::new(0);
        let order = std::sync::atomic::Ordering::SeqCst;
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    let mut taken = 0;
                    while taken < 200 {
                        let Ok(lock) = CheckpointLock::take(&path) else {
                            std::thread::yield_now();
                            continue;
                        };
                        assert!(lock.is_some());
                        assert_eq!(inside.fetch_add(1, order), 0);
                        taken += 1;
                        inside.fetch_sub(1, order);
                    }
                });
            }
        });
    }
}
