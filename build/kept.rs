//! Kernels that earlier builds have compiled. They lie in the folder `kernels` of the target folder's profile, where builds with any
//! features find them. The file depends only on the standard library, so that Cargo.toml can declare it as a test.

use std::fs;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Folder of the kernels, beside the folder `build` that has the folder of each build script.
const FOLDER: &str = "kernels";
/// Parent of that folder, seen from OUT_DIR: `release` of `release/build/lodestar-render-0123/out`.
const PARENT: usize = 3;
/// Time after which a file is removed. A kernel that is still in use is then compiled once more.
const LIFE: Duration = Duration::from_secs(14 * 24 * 60 * 60);

/// Place of one compiled kernel.
pub struct Kept {
    file: PathBuf,
    /// All that decides about the SPIR-V.
    text: String,
}

impl Kept {
    /// Place of the kernel that `text` decides about, for the build script whose OUT_DIR is `out`. `None` where that folder is not as
    /// cargo makes it.
    pub fn new(out: &Path, text: String) -> Option<Self> {
        let folder = out.ancestors().nth(PARENT)?.join(FOLDER);
        let mut hasher = DefaultHasher::new();
        text.hash(&mut hasher);
        Some(Self { file: folder.join(format!("{:016x}", hasher.finish())), text })
    }

    /// The SPIR-V, if an earlier build has written it. Texts are compared as a whole, because different ones may have one hash.
    pub fn read(&self) -> Option<Vec<u8>> {
        let content = fs::read(&self.file).ok()?;
        let (length, rest) = content.split_first_chunk()?;
        let (text, spirv) = rest.split_at_checked(usize::try_from(u64::from_le_bytes(*length)).ok()?)?;
        (text == self.text.as_bytes()).then(|| spirv.to_vec())
    }

    /// Writes the SPIR-V for later builds, whole or not at all, and removes old files. A build does without it where that fails.
    pub fn write(&self, spirv: &[u8]) {
        let Some(folder) = self.file.parent() else { return };
        let content = [&(self.text.len() as u64).to_le_bytes(), self.text.as_bytes(), spirv].concat();
        // Several build scripts may write at one time.
        let part = self.file.with_extension(std::process::id().to_string());
        let written = fs::create_dir_all(folder).and_then(|()| fs::write(&part, content));
        if written.and_then(|()| fs::rename(&part, &self.file)).is_err() {
            let _ = fs::remove_file(&part);
        }
        for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
            let age = entry.metadata().and_then(|data| data.modified()).ok().and_then(|time| time.elapsed().ok());
            if age.is_some_and(|age| age > LIFE) {
                let _ = fs::remove_file(entry.path());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::SystemTime;

    fn out(name: &str) -> PathBuf {
        let root = std::env::temp_dir().join(format!("lodestar-kept-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&root);
        root.join("release/build/lodestar-0/out")
    }

    #[test]
    fn a_kernel_is_found_by_its_whole_text() {
        let out = out("text");
        let kept = |text: &str| Kept::new(&out, text.to_owned()).unwrap();
        assert_eq!(kept("void main").read(), None);
        kept("void main").write(&[3, 2, 2, 7]);
        assert_eq!(kept("void main").read(), Some(vec![3, 2, 2, 7]));
        assert_eq!(kept("void main()").read(), None);
        // Another text with this hash.
        let other = Kept { text: "void maim".into(), ..kept("void main") };
        assert_eq!(other.read(), None);
        fs::write(&other.file, [9]).unwrap();
        assert_eq!(kept("void main").read(), None, "a file that was cut short");
        fs::remove_dir_all(out.ancestors().nth(4).unwrap()).unwrap();
    }

    #[test]
    fn old_files_are_removed() {
        let out = out("old");
        let kept = |text: &str| Kept::new(&out, text.to_owned()).unwrap();
        kept("old").write(&[1]);
        kept("new").write(&[2]);
        let file = fs::File::options().write(true).open(&kept("old").file).unwrap();
        file.set_modified(SystemTime::now() - 2 * LIFE).unwrap();
        kept("third").write(&[3]);
        assert_eq!([kept("old").read(), kept("new").read()], [None, Some(vec![2])]);
        fs::remove_dir_all(out.ancestors().nth(4).unwrap()).unwrap();
    }
}
