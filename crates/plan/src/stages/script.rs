//! What a stage of the study's own runs: its command and its files, read once, and the digest by which
//! a person allows it.

use std::fs;
use std::io;
use std::path::Path;
use zwidth_store::{
    Entry, Files as _, Layout, RealFiles, StoreError, hex_blake3, read_regular, real_path,
};
use zwidth_study::{OwnStage, StudyId};

/// The most that a file of a stage may have, bytes (64 MiB).
const MOST_BYTES: u64 = 1 << 26;

/// A file of a stage, as it was read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ScriptFile {
    /// Its path from `analysis/<study>` on, with `/`.
    pub file: String,
    /// Its BLAKE3, hexadecimal.
    pub blake3: String,
    bytes: Vec<u8>,
    is_executable: bool,
}

/// What a stage runs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ReadScript {
    /// Its files, in the order of study.toml.
    pub files: Vec<ScriptFile>,
    /// BLAKE3, hexadecimal, of the study's absolute path and of the stage's id, command and files.
    pub digest: String,
}

/// Reads the files of a stage of a study below `root`, each once.
///
/// # Errors
/// A file that is missing, is no regular file or has more than 64 MiB; a link to it or on the way to
/// it.
pub fn read_script(
    root: &Path,
    study: &StudyId,
    stage: &OwnStage,
) -> Result<ReadScript, StoreError> {
    read_program(root, study, stage.id.as_str(), &stage.command, &stage.files)
}

/// Reads the files of any program of a study, likewise: `name` is what it is for.
///
/// # Errors
/// As [`read_script`].
pub fn read_program(
    root: &Path,
    study: &StudyId,
    name: &str,
    command: &[String],
    files: &[String],
) -> Result<ReadScript, StoreError> {
    let named = files;
    let folder = Layout::new(root, study.clone()).analysis();
    let mut files = Vec::new();
    for file in named {
        let path = folder.join(file);
        check_way(root, &path)?;
        let bytes =
            read_regular(&path, MOST_BYTES).map_err(|e| StoreError::io(&path, "read", &e))?;
        let blake3 = hex_blake3(&bytes);
        let is_executable = is_executable(&path);
        files.push(ScriptFile { file: file.clone(), blake3, bytes, is_executable });
    }
    // The same study by another way (a link, a relative path) is the same.
    let root = if root.as_os_str().is_empty() { Path::new(".") } else { root };
    let place = real_path(root).map_err(|e| StoreError::io(root, "find", &e))?;
    let place = place.to_string_lossy();
    let mut parts = vec![&*place, study.as_str(), name];
    parts.extend(command.iter().map(String::as_str));
    parts.push("files");
    for file in &files {
        let executable = if file.is_executable { "executable" } else { "plain" };
        parts.extend([&*file.file, &*file.blake3, executable]);
    }
    // Lengths first: no part can pass for two.
    let text: String = parts.iter().map(|part| format!("{} {part}\n", part.len())).collect();
    Ok(ReadScript { files, digest: hex_blake3(text.as_bytes()) })
}

/// Whether no folder on the way from the root, nor the file itself, is a link.
fn check_way(root: &Path, path: &Path) -> Result<(), StoreError> {
    let mut at = root.to_owned();
    for part in path.strip_prefix(root).unwrap_or(path) {
        at.push(part);
        if RealFiles.kind(&at) == Some(Entry::Link) {
            let what = "it is a link, and what a stage runs lies in the study's own folder alone";
            return Err(StoreError::new(&at, what, "put a copy in its place"));
        }
    }
    Ok(())
}

#[cfg(unix)]
fn is_executable(path: &Path) -> bool {
    use std::os::unix::fs::PermissionsExt as _;
    fs::metadata(path).is_ok_and(|file| file.permissions().mode() & 0o100 != 0)
}

#[cfg(not(unix))]
fn is_executable(_: &Path) -> bool {
    false
}

impl ReadScript {
    /// Writes the files into the folder in which the program runs: exactly what was read.
    pub(super) fn write_into(&self, folder: &Path) -> io::Result<()> {
        for file in &self.files {
            let path = folder.join(&file.file);
            if let Some(parent) = path.parent() {
                fs::create_dir_all(parent)?;
            }
            fs::write(&path, &file.bytes)?;
            #[cfg(unix)]
            if file.is_executable {
                use std::os::unix::fs::PermissionsExt as _;
                fs::set_permissions(&path, fs::Permissions::from_mode(0o700))?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tempfile::TempDir;

    const STAGE: &str = "[[stage]]\nid = \"grip\"\ncommand = [\"python3\", \"grip.py\"]\nfiles = [\"grip.py\"]\n\
                         inputs = [\"samples\"]\ngives = [{ id = \"grip_peak\", unit = \"N\", label = \"grip\" }]\n";

    fn stage(text: &str) -> OwnStage {
        let template = zwidth_study::template(&"demo".parse().unwrap());
        zwidth_study::Study::from_toml(&format!("{template}\n{text}")).unwrap().stages.remove(0)
    }

    fn world() -> TempDir {
        let root = tempfile::tempdir().unwrap();
        let folder = root.path().join("analysis/s");
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join("grip.py"), "print(1)").unwrap();
        root
    }

    fn digest(root: &Path, text: &str) -> String {
        read_script(root, &"s".parse().unwrap(), &stage(text)).unwrap().digest
    }

    #[test]
    fn a_digest_is_of_place_command_and_files() {
        let root = world();
        let first = digest(root.path(), STAGE);
        assert_eq!(first, digest(root.path(), STAGE));
        // Neither what it gives nor when it is ended is what is run.
        assert_eq!(first, digest(root.path(), &STAGE.replace("unit = \"N\"", "unit = \"mN\"")));
        assert_ne!(first, digest(root.path(), &STAGE.replace("python3", "python4")));
        assert_ne!(
            first,
            digest(root.path(), &STAGE.replace("\"grip.py\"]\nfiles", "\"grip\", \".py\"]\nfiles"))
        );
        assert_ne!(first, digest(world().path(), STAGE), "a stranger's copy");
        fs::write(root.path().join("analysis/s/grip.py"), "print(2)").unwrap();
        assert_ne!(first, digest(root.path(), STAGE));
    }

    #[cfg(unix)]
    #[test]
    fn another_way_to_the_same_study_is_the_same_and_a_link_inside_is_refused() {
        use std::os::unix::fs::symlink;
        let root = world();
        let other = tempfile::tempdir().unwrap();
        symlink(root.path(), other.path().join("linked")).unwrap();
        assert_eq!(digest(root.path(), STAGE), digest(&other.path().join("linked"), STAGE));
        let script = root.path().join("analysis/s/grip.py");
        fs::rename(&script, other.path().join("grip.py")).unwrap();
        symlink(other.path().join("grip.py"), &script).unwrap();
        let error = read_script(root.path(), &"s".parse().unwrap(), &stage(STAGE)).unwrap_err();
        assert!(error.to_string().contains("it is a link"), "{error}");
        fs::remove_file(&script).unwrap();
        let error = read_script(root.path(), &"s".parse().unwrap(), &stage(STAGE)).unwrap_err();
        assert!(error.to_string().contains("grip.py"), "{error}");
    }
}
