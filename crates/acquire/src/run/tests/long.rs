//! A session of very many trials: no trial costs more than earlier ones.

use super::*;
use std::sync::atomic::{AtomicU64, Ordering};
use zwidth_store::{Entry, Stamp};

/// What was asked of a disk.
#[derive(Debug, Default)]
struct Counts {
    /// Files and names that were looked at.
    looks: AtomicU64,
    reads: AtomicU64,
    read_bytes: AtomicU64,
    /// Names in folders that were listed.
    listed: AtomicU64,
    writes: AtomicU64,
    written_bytes: AtomicU64,
}

/// The same at a moment: looks, reads and their bytes, names, writes and their bytes.
type Sums = [u64; 6];

impl Counts {
    fn sums(&self) -> Sums {
        let Self { looks, reads, read_bytes, listed, writes, written_bytes } = self;
        [looks, reads, read_bytes, listed, writes, written_bytes]
            .map(|count| count.load(Ordering::Relaxed))
    }

    fn add(count: &AtomicU64, n: u64) {
        count.fetch_add(n, Ordering::Relaxed);
    }

    fn write(&self, bytes: &[u8]) {
        Self::add(&self.writes, 1);
        Self::add(&self.written_bytes, bytes.len() as u64);
    }
}

/// A disk that counts what is asked of it.
#[derive(Default)]
struct Counted(Arc<Counts>);

struct CountedFile(Box<dyn Append>, Arc<Counts>);

impl Append for CountedFile {
    fn append_synced(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.1.write(bytes);
        self.0.append_synced(bytes)
    }
    fn take_back(&mut self) -> io::Result<()> {
        self.0.take_back()
    }
}

impl Files for Counted {
    fn kind(&self, path: &Path) -> Option<Entry> {
        Counts::add(&self.0.looks, 1);
        Unsynced.kind(path)
    }
    fn stamp(&self, path: &Path) -> Option<Stamp> {
        Counts::add(&self.0.looks, 1);
        Unsynced.stamp(path)
    }
    fn list(&self, folder: &Path) -> io::Result<Vec<(PathBuf, Entry)>> {
        let found = Unsynced.list(folder)?;
        Counts::add(&self.0.listed, 1 + found.len() as u64);
        Ok(found)
    }
    fn read(&self, path: &Path, most: u64) -> io::Result<Vec<u8>> {
        let bytes = Unsynced.read(path, most)?;
        Counts::add(&self.0.reads, 1);
        Counts::add(&self.0.read_bytes, bytes.len() as u64);
        Ok(bytes)
    }
    fn create_folder(&self, path: &Path) -> io::Result<()> {
        Unsynced.create_folder(path)
    }
    fn write_synced(&self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        self.0.write(bytes);
        Unsynced.write_synced(path, bytes)
    }
    fn rename(&self, from: &Path, to: &Path) -> io::Result<()> {
        Unsynced.rename(from, to)
    }
    fn sync_folder(&self, path: &Path) -> io::Result<()> {
        Counts::add(&self.0.looks, 1);
        Unsynced.sync_folder(path)
    }
    fn open_append(&self, path: &Path) -> io::Result<Box<dyn Append>> {
        Ok(Box::new(CountedFile(Unsynced.open_append(path)?, Arc::clone(&self.0))))
    }
    fn remove(&self, path: &Path) -> io::Result<()> {
        Unsynced.remove(path)
    }
    fn remove_folder(&self, path: &Path) -> io::Result<()> {
        Unsynced.remove_folder(path)
    }
}

/// Six conditions this often, and one trial for practice: 2,005 trials.
const REPEATS: usize = 334;

#[test]
fn the_last_of_two_thousand_trials_asks_no_more_of_the_disk_than_the_tenth() {
    let mut desk = Desk::new(false);
    let text = small("small", false)
        .replace("repeats = 1", &format!("repeats = {REPEATS}"))
        .replace("trial_limit_s = 4.0", "trial_limit_s = 0.1")
        .replace("pause_s = 5.0", "pause_s = 0.0");
    std::fs::write(desk.plan.layout.study_toml(), &text).unwrap();
    desk.plan.study = Study::from_toml(&text).unwrap();
    desk.plan.study_toml = text.into_bytes();
    let files = Counted::default();
    let counts = Arc::clone(&files.0);
    // What had been asked when so many trials were done.
    let mut sums: Vec<Sums> = Vec::new();
    let outcome = {
        let mut front = somebody(|view: &View| {
            if view.done == sums.len() {
                sums.push(counts.sums());
            }
            None
        });
        desk.run(&mut Mock::default(), &files, &mut front).unwrap()
    };
    assert_eq!((outcome.done, outcome.total), (6 * REPEATS + 1, 6 * REPEATS + 1));
    let of_trial = |n: usize| -> Sums { std::array::from_fn(|i| sums[n][i] - sums[n - 1][i]) };
    let [looks, reads, read_bytes, listed, writes, written_bytes] = of_trial(10);
    let last = of_trial(outcome.done - 1);
    assert!(reads > 0 && writes > 0, "nothing was counted");
    assert_eq!([last[0], last[1], last[3], last[4]], [looks, reads, listed, writes]);
    // A number has three digits more, which stand in a handful of names and lines.
    const DIGITS: u64 = 200;
    assert!(last[2] < read_bytes + DIGITS, "{} bytes read, not {read_bytes}", last[2]);
    assert!(last[5] < written_bytes + DIGITS, "{} bytes written, not {written_bytes}", last[5]);
}
