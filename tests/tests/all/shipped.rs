//! The study that comes with the software, in temporary folders.

use crate::binary::zwidth;
use crate::folders::{copy, workspace};
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use tempfile::TempDir;
use zwidth_store::{
    Layout, RealFiles, append_events, hex_blake3, log_sweeps, read_sweep, sweep_bytes,
};
use zwidth_study::Event;

/// The study's raw data alone.
pub(crate) fn raw() -> TempDir {
    let root = tempfile::tempdir().unwrap();
    copy(&workspace().join("raw/thesis-twin"), &root.path().join("raw/thesis-twin"));
    root
}

/// A copy of the study after its first run.
pub(crate) fn finished() -> TempDir {
    let root = tempfile::tempdir().unwrap();
    copy(&FINISHED.folder, root.path());
    root
}

/// Where the first run's results lie, to be read only.
pub(crate) fn folder() -> &'static Path {
    &FINISHED.folder
}

/// Changes the response of a sweep of the motor, as if it had been recorded so.
pub(crate) fn change_sweep(root: &Path, name: &str) {
    let path = root.join(name);
    let mut sweep = read_sweep(&path).unwrap();
    sweep.response_values[10] += 0.1;
    let bytes = sweep_bytes(&sweep, &path).unwrap();
    fs::write(&path, &bytes).unwrap();
    let layout = Layout::new(root, "thesis-twin".parse().unwrap());
    let logged = (sweep.actuator, sweep.sweep, hex_blake3(&bytes));
    log_sweeps(&RealFiles, &layout, "2026-01-02T00:00:00Z", &[logged]).unwrap();
}

/// Adds an event to the log of the study's session.
pub(crate) fn log(root: &Path, event: Event) {
    let log = root.join("raw/thesis-twin/sessions/P01_S01.events.jsonl");
    append_events(&RealFiles, &log, "2026-01-02T00:00:00Z", &[event]).unwrap();
}

/// The study run once, on four threads, for all tests of this process. It lies under `target/tmp`,
/// because nothing removes it in the end; the lock keeps a second process of this test away
/// meanwhile.
static FINISHED: LazyLock<Finished> = LazyLock::new(|| {
    let tmp = Path::new(env!("CARGO_TARGET_TMPDIR"));
    fs::create_dir_all(tmp).unwrap();
    let lock = File::create(tmp.join("thesis-twin.lock")).unwrap();
    lock.lock().unwrap();
    let folder = tmp.join("thesis-twin");
    let _ = fs::remove_dir_all(&folder);
    copy(&workspace().join("raw/thesis-twin"), &folder.join("raw/thesis-twin"));
    zwidth(&folder, &["--threads", "4", "run", "thesis-twin"]).exits(0);
    Finished { folder, _lock: lock }
});

struct Finished {
    folder: PathBuf,
    _lock: File,
}
