//! Where seals are kept until they are opened: in a folder of the user's own, outside the data.
//!
//! ```text
//! <folder>/<study>/seed                                  the order's seed, where none was given
//! <folder>/<study>/<participant>_<session>.<16 digits of the commitment>.json
//! ```
//!
//! Because its name contains the commitment, a seal is never mistaken for that of another study
//! with the same id. Opened seals stay: the event log holds them too. Only this user can read seeds
//! and seals: files have 0600, the study's folder and newly made folders 0700, whatever the umask
//! says. Existing folders above it keep their permissions: they may be the user's home.

use crate::AcquireError;
use std::io;
use std::path::{Path, PathBuf};
use zwidth_store::{Files, Layout, StoreError, keep_private, real_path, sync_names, write_private};
use zwidth_study::{Seal, SessionRecord, StudyId};

/// Digits of the commitment in a seal's name: enough to tell any two apart.
const DIGITS: usize = 16;
/// Largest seal that is read, bytes: that of a hundred thousand trials.
const MOST_SEAL: u64 = 1 << 23;

/// Whether seals in this folder are apart from the data, which others may read. Paths are followed
/// through links, `..` and folders that are still to be made.
///
/// # Errors
/// The seals of the study would lie in raw/, derived/ or reports/; a path that leads nowhere.
pub fn check_apart(folder: &Path, layout: &Layout) -> Result<(), AcquireError> {
    // The study's own folder in it counts as well: a study may be called `raw`.
    let seals = [folder.to_owned(), folder.join(layout.study().as_str())];
    for data in ["raw", "derived", "reports"].map(|name| layout.root().join(name)) {
        let real_data = resolve(&data)?;
        for seals in &seals {
            if resolve(seals)?.starts_with(&real_data) {
                return Err(AcquireError::refused(
                    format!(
                        "the folder of the seals, {}, is inside {}, where all who read the data could read the seals",
                        seals.display(),
                        data.display()
                    ),
                    "name a folder outside of raw/, derived/ and reports/ with --key",
                ));
            }
        }
    }
    Ok(())
}

fn resolve(path: &Path) -> Result<PathBuf, StoreError> {
    real_path(path).map_err(|e| {
        let what = format!("cannot tell where this folder leads: {e}");
        StoreError::new(path, what, "see that it can be looked into, or name another with --key")
    })
}

/// Where a session's seal is.
fn seal_path(folder: &Path, study: &StudyId, record: &SessionRecord, commitment: &str) -> PathBuf {
    let SessionRecord { participant, session, .. } = record;
    let digits: String = commitment.chars().take(DIGITS).collect();
    folder.join(study.as_str()).join(format!("{participant}_{session}.{digits}.json"))
}

/// Keeps a seal. By its name, a seal that is already there is the same one: a simulated study made
/// again from its seed.
///
/// # Errors
/// A folder that cannot be written.
pub fn keep(
    files: &dyn Files,
    folder: &Path,
    study: &StudyId,
    record: &SessionRecord,
    seal: &Seal,
) -> Result<(), AcquireError> {
    let path = seal_path(folder, study, record, &seal.commitment());
    let text = seal.to_json().map_err(|e| {
        StoreError::new(&path, e.to_string(), "this is a defect of zwidth, please report it")
    })?;
    if files.read(&path, MOST_SEAL).is_ok_and(|existing| existing == text.as_bytes()) {
        restrict_to_user(files, &path)?;
    } else {
        write_private(files, &path, text.as_bytes())?;
    }
    sync_seal_names(files, folder, &path)
}

/// Sees to it that a power cut leaves what is kept: without its seal a session could not go on.
fn sync_seal_names(files: &dyn Files, folder: &Path, path: &Path) -> Result<(), AcquireError> {
    Ok(sync_names(files, path, folder.parent().unwrap_or(folder))?)
}

/// Keeps a file that is there, and its folder, for this user alone: it may come from where nobody
/// saw to that.
fn restrict_to_user(files: &dyn Files, path: &Path) -> Result<(), AcquireError> {
    path.parent().map_or(Ok(()), |folder| keep_private(files, folder))?;
    Ok(keep_private(files, path)?)
}

/// The seal of a sealed session.
///
/// # Errors
/// It is not there, it is no seal, or it does not fit the session's commitment.
pub fn find(
    files: &dyn Files,
    folder: &Path,
    study: &StudyId,
    record: &SessionRecord,
) -> Result<Seal, AcquireError> {
    let Some(commitment) = &record.commitment else {
        return Err(AcquireError::refused(
            format!("session {} of {} is not sealed", record.session, record.participant),
            "there is nothing to unseal",
        ));
    };
    let path = seal_path(folder, study, record, commitment);
    let text = text(files, &path).map_err(|e| {
        let remedy =
            "the seal is where the session was begun: name that folder with --key, or copy the file here";
        StoreError::new(&path, format!("cannot read the session's seal: {e}"), remedy)
    })?;
    let seal = Seal::from_json(&text).and_then(|seal| seal.verify(commitment).map(|()| seal));
    Ok(seal.map_err(|e| StoreError::new(&path, e.to_string(), "see --key"))?)
}

fn text(files: &dyn Files, path: &Path) -> io::Result<String> {
    String::from_utf8(files.read(path, MOST_SEAL)?)
        .map_err(|e| io::Error::new(io::ErrorKind::InvalidData, e.utf8_error()))
}

/// The study's secret seed: the order of a sealed session must not follow from anything in the
/// data.
///
/// # Errors
/// A folder that cannot be written, or a file that holds no number.
pub fn seed(
    files: &dyn Files,
    folder: &Path,
    study: &StudyId,
    draw: impl FnOnce() -> u64,
) -> Result<u64, AcquireError> {
    let path = folder.join(study.as_str()).join("seed");
    if files.kind(&path).is_none() {
        write_private(files, &path, format!("{}\n", draw()).as_bytes())?;
    } else {
        restrict_to_user(files, &path)?;
    }
    sync_seal_names(files, folder, &path)?;
    let text = text(files, &path).map_err(|e| StoreError::io(&path, "read", &e))?;
    Ok(text.trim().parse().map_err(|_| {
        StoreError::new(
            &path,
            "it should hold a seed, a whole number below 2⁶⁴, and does not",
            "restore the file from a copy",
        )
    })?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_store::{Raw, RealFiles};
    use zwidth_study::{SealedTrial, Source};

    fn sealed() -> (SessionRecord, Seal) {
        let mut record = SessionRecord::new(
            "P01".parse().unwrap(),
            "S01".parse().unwrap(),
            Source::Twin,
            "test",
            "",
            Vec::new(),
        );
        let only = SealedTrial { trial: 1, mode: "active".parse().unwrap(), is_standard: None };
        let seal = Seal { nonce: [7; 32], order: vec![only] };
        record.commitment = Some(seal.commitment());
        (record, seal)
    }

    #[test]
    fn a_seal_is_found_again_by_its_commitment_and_by_no_other() {
        let folder = tempfile::tempdir().unwrap();
        let study = "s".parse().unwrap();
        let (mut record, seal) = sealed();
        keep(&RealFiles, folder.path(), &study, &record, &seal).unwrap();
        keep(&RealFiles, folder.path(), &study, &record, &seal).unwrap();
        assert_eq!(find(&RealFiles, folder.path(), &study, &record).unwrap(), seal);
        for (commitment, words) in [(Some("0".repeat(64)), "--key"), (None, "not sealed")] {
            record.commitment = commitment;
            let error = find(&RealFiles, folder.path(), &study, &record).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        }
    }

    /// In which folder the child of the test below keeps a seed and a seal.
    #[cfg(unix)]
    const FOLDER: &str = "ZWIDTH_TEST_VAULT";

    #[cfg(unix)]
    #[test]
    fn keeps_a_seed_and_a_seal_in_the_folder_that_it_is_told() {
        let Some(folder) = std::env::var_os(FOLDER).map(PathBuf::from) else { return };
        let study: StudyId = "s".parse().unwrap();
        let (record, seal) = sealed();
        let layout = Layout::new(Path::new("elsewhere"), study.clone());
        let raw = Raw::new_study(&RealFiles, &layout).with_vault(&folder);
        seed(&raw, &folder, &study, || 5).unwrap();
        keep(&raw, &folder, &study, &record, &seal).unwrap();
        // Both again, now that they are there.
        seed(&raw, &folder, &study, || 5).unwrap();
        keep(&raw, &folder, &study, &record, &seal).unwrap();
    }

    /// What lies below a folder, with its mode.
    #[cfg(unix)]
    fn modes(folder: &Path) -> Vec<(PathBuf, u32)> {
        use std::os::unix::fs::PermissionsExt as _;
        let mut found = Vec::new();
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let mode = std::fs::symlink_metadata(&path).unwrap().permissions().mode() & 0o7777;
            found.push((path.clone(), mode));
            if path.is_dir() {
                found.extend(modes(&path));
            }
        }
        found
    }

    #[cfg(unix)]
    #[test]
    fn seeds_and_seals_are_for_this_user_alone_whatever_the_umask_says_and_whatever_was_there() {
        use std::os::unix::fs::PermissionsExt as _;
        for umask in ["0000", "0022", "0777"] {
            let root = tempfile::tempdir().unwrap();
            let home = root.path().join("home");
            std::fs::create_dir(&home).unwrap();
            std::fs::set_permissions(&home, std::fs::Permissions::from_mode(0o751)).unwrap();
            let folder = home.join("state/zwidth");
            let child = || {
                let mut command = std::process::Command::new("sh");
                command.args(["-c", &format!("umask {umask}; exec \"$0\" \"$@\"")]);
                command.arg(std::env::current_exe().unwrap()).arg("--exact");
                command.arg("vault::tests::keeps_a_seed_and_a_seal_in_the_folder_that_it_is_told");
                let output = command.env(FOLDER, &folder).output().unwrap();
                assert!(
                    output.status.success(),
                    "{umask}: {}",
                    String::from_utf8_lossy(&output.stdout)
                );
            };
            let check = || {
                let found = modes(root.path());
                assert_eq!(found.len(), 6, "{found:?}");
                for (path, mode) in found {
                    let expect = match path.is_dir() {
                        true if path == home => 0o751, // was there
                        true => 0o700,
                        false => 0o600,
                    };
                    assert_eq!(mode, expect, "{umask}: {} is {mode:o}", path.display());
                }
            };
            child();
            check();
            // A vault of before that anybody could read; its own folders are the user's to see to.
            for (path, _) in modes(&folder) {
                let open = if path.is_dir() { 0o755 } else { 0o644 };
                std::fs::set_permissions(&path, std::fs::Permissions::from_mode(open)).unwrap();
            }
            child();
            check();
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_vault_that_is_a_link_is_refused_and_what_it_leads_to_is_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        let elsewhere = folder.path().join("elsewhere");
        std::fs::create_dir(&elsewhere).unwrap();
        let before = modes(folder.path());
        std::os::unix::fs::symlink(&elsewhere, folder.path().join("s")).unwrap();
        assert!(seed(&RealFiles, folder.path(), &"s".parse().unwrap(), || 5).is_err());
        std::fs::remove_file(folder.path().join("s")).unwrap();
        assert_eq!(modes(folder.path()), before);
    }

    #[test]
    fn a_vault_within_the_data_is_refused() {
        let check = |root: &str, folder: &str| {
            check_apart(Path::new(folder), &Layout::new(Path::new(root), "s".parse().unwrap()))
        };
        for (root, folder) in [
            ("/x", "/x/raw"),
            ("/x", "/x/raw/s/keys"),
            ("", "derived/s"),
            ("", "reports"),
            (".", "./raw"),
        ] {
            let error = check(root, folder).unwrap_err().to_string();
            assert!(error.contains("--key"), "{error}");
        }
        let here = std::env::current_dir().unwrap();
        assert!(check("", here.join("raw").to_str().unwrap()).is_err());
        for (root, folder) in
            [("/x", "/x/keys"), ("/x", "/x/rawer"), ("", "keys"), ("/x", "/y/raw")]
        {
            check(root, folder).unwrap();
        }
    }

    #[cfg(unix)]
    #[test]
    fn what_counts_is_where_a_vault_leads_and_not_how_it_is_spelled() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path().join("root");
        let disk = folder.path().join("disk");
        for made in [root.join("raw/s"), root.join("reports"), disk.clone()] {
            std::fs::create_dir_all(made).unwrap();
        }
        for (target, link) in [
            ("root/raw", "into"),
            ("root/raw/new", "dangling"),
            ("disk", "out"),
            ("root", "same"),
            ("circle", "circle"),
            ("../disk", "root/derived"),
            ("../../disk", "root/raw/out"),
        ] {
            symlink(target, folder.path().join(link)).unwrap();
        }
        let check = |study: &str, vault: &str| {
            let layout = Layout::new(&root, study.parse().unwrap());
            check_apart(&folder.path().join(vault), &layout)
        };
        for vault in [
            "into",
            "into/new/keys",
            "dangling/keys",
            "same/raw",
            "same/reports/keys",
            "root/x/../raw/keys",
            "root/./raw//keys",
            "disk/keys", // which derived/ leads to
            "out/keys",
        ] {
            let error = check("s", vault).unwrap_err().to_string();
            assert!(error.contains("is inside") && error.contains("--key"), "{vault}: {error}");
        }
        for vault in
            ["keys", "raw", "root", "root/keys", "root/rawer", "root/keys/raw", "root/raw/../keys"]
        {
            check("s", vault).unwrap_or_else(|error| panic!("{vault}: {error}"));
        }
        assert!(check("raw", "root").unwrap_err().to_string().contains("root/raw"));
        assert!(check("s", "circle/x").unwrap_err().to_string().contains("--key"));
        // A link within the data that leads out of it: its seals lie apart.
        std::fs::remove_file(root.join("derived")).unwrap();
        check("s", "root/raw/out/keys").unwrap();
    }

    #[test]
    fn a_study_keeps_its_first_seed() {
        let folder = tempfile::tempdir().unwrap();
        let study = "s".parse().unwrap();
        assert_eq!(seed(&RealFiles, folder.path(), &study, || 5).unwrap(), 5);
        assert_eq!(seed(&RealFiles, folder.path(), &study, || 6).unwrap(), 5);
    }
}
