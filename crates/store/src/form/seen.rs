//! What files were when their content was last hashed: as long as the system says that a file has
//! not changed, its hash is known without reading it.
//!
//! A file counts as the same while its length, its two times and its number on the disk are the
//! same. The time at which its state last changed (`ctime`) moves with every write and every
//! renaming, and if a file system keeps it, no program can set it back without the machine's clock.
//! docs/data.md ("Where a result is from") lists the changes that stay unnoticed: a disk loses
//! bytes by itself; a program writes through a memory map, where the time moves only when a page is
//! first touched after it was last written back; a result is changed within the step of the clock
//! in which it was written; a file system gives the time of the last write for `ctime`; the times
//! of a network disk lag. [`verify`](crate::verify) reads every recording in any case. On a system
//! without such a time, no hash is kept.
//!
//! A recording's signals are compared with their digests when they are first read. Later, the bytes
//! of the file are compared with their hash, which proves the same in less time, because the bytes
//! are compressed.

use crate::disk::regular::read_regular;
use crate::disk::stamp::Stamp;
use crate::{Layout, Signal, StoreError, file_blake3};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, HashMap};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::SystemTime;

/// Largest file of hashes that is read, bytes (256 MiB): a million files.
const MOST_SEEN: u64 = 1 << 28;

/// Files from which on their hashes are worth a file of their own.
const WORTH_WRITING: usize = 2000;

/// BLAKE3 of a file's content: in a file hexadecimal, in memory not half of that.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "&str", into = "String")]
struct Blake3(blake3::Hash);

impl TryFrom<&str> for Blake3 {
    type Error = blake3::HexError;

    fn try_from(text: &str) -> Result<Self, Self::Error> {
        blake3::Hash::from_hex(text).map(Self)
    }
}

impl From<Blake3> for String {
    fn from(hash: Blake3) -> Self {
        hash.0.to_hex().to_string()
    }
}

/// A file as it was, the hash of its content then, and of a recording the signals of that content
/// that matched their digests.
type Known = (Stamp, Blake3, Signals);

/// Signals of a recording, a bit for each.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub(crate) struct Signals(u32);

const _: () = assert!(Signal::COUNT <= u32::BITS as usize);

impl Signals {
    pub(crate) fn of(signals: &[Signal]) -> Self {
        Self(signals.iter().fold(0, |bits, signal| bits | 1 << *signal as usize))
    }

    pub(crate) fn has(self, others: Self) -> bool {
        self.0 & others.0 == others.0
    }

    pub(crate) fn with(self, others: Self) -> Self {
        Self(self.0 | others.0)
    }
}

/// The contents of [`Seen::file`].
#[derive(Serialize, Deserialize)]
struct Written<N, F> {
    /// The signal that each bit stands for, from the lowest on.
    signals: Vec<N>,
    files: F,
}

/// The names of all signals, in the order of their bits.
fn names() -> Vec<&'static str> {
    Signal::all().map(Signal::name).collect()
}

/// The hashes of a study's files, recordings and results, by what these files were.
#[derive(Debug, Default)]
pub struct Seen {
    root: PathBuf,
    /// The hashes of earlier runs, by the path relative to the root.
    before: HashMap<Box<str>, Known>,
    /// The files that were hashed since, or written with their hash.
    since: Mutex<BTreeMap<Box<str>, Known>>,
}

impl Seen {
    /// Its place: hidden, because it is not one of a study's results.
    pub fn file(layout: &Layout) -> PathBuf {
        layout.derived().join(".hashes.json")
    }

    /// What earlier runs of the study wrote down. Nothing where that is missing, or cannot be
    /// understood.
    pub fn of(layout: &Layout) -> Self {
        let text = read_regular(&Self::file(layout), MOST_SEEN).unwrap_or_default();
        let written = serde_json::from_slice(&text).ok();
        // Bits of a version with other signals would stand for others.
        let written = written.filter(|written: &Written<String, _>| written.signals == names());
        let mut before: HashMap<_, _> = written.map(|written| written.files).unwrap_or_default();
        // It has grown by doubling, and does not grow any more.
        before.shrink_to_fit();
        Self { before, ..Self::nothing(layout) }
    }

    /// As if no run had written anything down.
    pub fn nothing(layout: &Layout) -> Self {
        Self { root: layout.root().to_owned(), ..Self::default() }
    }

    /// BLAKE3 of a file's content, hexadecimal: read only if it may have changed.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn blake3(&self, path: &Path) -> Result<String, StoreError> {
        if let Some(hash) = self.unchanged_hash(path) {
            return Ok(hash);
        }
        // Before it is read: a change meanwhile shows only against how it was then.
        let begun = Stamp::settled(path);
        let hash = file_blake3(path)?;
        self.read(path, begun, &hash);
        Ok(hash)
    }

    /// Remembers what was read of a file, unless it changed since it was as `begun`, its state
    /// before that if any later change shows.
    pub(crate) fn read(&self, path: &Path, begun: Option<Stamp>, blake3: &str) {
        let Ok(blake3) = blake3.try_into() else { return };
        if let Some(stamp) = begun.filter(|stamp| Stamp::at(path) == Some(*stamp)) {
            self.note(path, (stamp, blake3, Signals::default()));
        }
    }

    /// Remembers the content just written to a file.
    pub fn written(&self, path: &Path, blake3: &str) {
        if let (Some(stamp), Ok(blake3)) = (Stamp::at(path), blake3.try_into()) {
            self.note(path, (stamp, blake3, Signals::default()));
        }
    }

    /// The length in bytes that a file had when it was last hashed.
    pub fn length(&self, path: &Path) -> Option<u64> {
        self.noted(path, |(stamp, ..)| stamp.length)
    }

    /// Whether these signals of a recording matched their digests when its content was the same:
    /// `blake3` of it now is asked for only where they did at all.
    pub(crate) fn matched(
        &self,
        path: &Path,
        signals: Signals,
        blake3: impl FnOnce() -> Result<String, StoreError>,
    ) -> Result<bool, StoreError> {
        let hash = self.noted(path, |(_, hash, matched)| matched.has(signals).then_some(*hash));
        Ok(match hash.flatten() {
            Some(hash) => String::from(hash) == blake3()?,
            None => false,
        })
    }

    /// Remembers that these signals matched their digests, of a recording that is what it was when
    /// it was hashed.
    pub(crate) fn match_now(&self, path: &Path, stamp: Stamp, signals: Signals) {
        let more = self.noted(path, |(before, hash, matched)| {
            let is_more = *before == stamp && !matched.has(signals);
            is_more.then_some((stamp, *hash, matched.with(signals)))
        });
        if let Some(more) = more.flatten() {
            self.note(path, more);
        }
    }

    /// Whether to write it to [`Seen::file`]: not if nothing was hashed since, or if there are so few
    /// files that they are as soon read.
    pub fn is_worth_writing(&self) -> bool {
        let since = self.since();
        let now = SystemTime::now();
        let is_news = since.values().any(|(stamp, ..)| stamp.is_settled(now));
        let new = since.keys().filter(|path| !self.before.contains_key(*path)).count();
        is_news && self.before.len() + new >= WORTH_WRITING
    }

    /// Writes the known hashes.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write(&self, out: impl io::Write) -> io::Result<()> {
        let since = self.since();
        let now = SystemTime::now();
        // What was written a moment ago is hashed once more by the next run.
        let settled = since.iter().filter(|(_, (stamp, ..))| stamp.is_settled(now));
        let files: BTreeMap<_, _> = self.before.iter().chain(settled).collect();
        Ok(serde_json::to_writer(out, &Written { signals: names(), files })?)
    }

    /// The hash of a file that has not changed.
    pub(crate) fn unchanged_hash(&self, path: &Path) -> Option<String> {
        let (stamp, hash) = self.noted(path, |(stamp, hash, _)| (*stamp, *hash))?;
        (Stamp::at(path)? == stamp).then(|| hash.into())
    }

    /// The part of a file's entry that `part` takes.
    fn noted<T>(&self, path: &Path, part: impl FnOnce(&Known) -> T) -> Option<T> {
        let named = self.named(path)?;
        let before = self.before.get(named);
        let since = self.since();
        // What was hashed since is newer.
        since.get(named).or(before).map(part)
    }

    fn note(&self, path: &Path, state: Known) {
        if let Some(named) = self.named(path) {
            self.since().insert(named.into(), state);
        }
    }

    /// A path relative to the root; one that is no text is not kept.
    fn named<'p>(&self, path: &'p Path) -> Option<&'p str> {
        path.strip_prefix(&self.root).ok()?.to_str()
    }

    fn since(&self) -> MutexGuard<'_, BTreeMap<Box<str>, Known>> {
        self.since.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use super::*;
    use crate::disk::stamp::SETTLED;
    use crate::hex_blake3;
    use std::fs::{self, File};
    use std::os::unix::fs::FileExt as _;
    use std::time::Duration;

    /// A study's folder with a file, as a run finds it that knows `text` of it.
    fn known(text: &str) -> (tempfile::TempDir, Layout, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let layout = Layout::new(folder.path(), "s".parse().unwrap());
        let path = layout.derived().join("a");
        fs::create_dir_all(layout.derived()).unwrap();
        fs::write(&path, text).unwrap();
        (folder, layout, path)
    }

    fn knowing(layout: &Layout, path: &Path, hash: &str) -> Seen {
        let seen = Seen::nothing(layout);
        seen.written(path, hash);
        seen
    }

    #[test]
    fn what_has_not_changed_is_not_read_and_what_has_is() {
        let (_folder, layout, path) = known("text");
        let told = hex_blake3(b"told");
        let seen = knowing(&layout, &path, &told);
        assert_eq!(seen.blake3(&path).unwrap(), told, "nothing was read");
        assert_eq!([&path, &layout.raw()].map(|path| seen.length(path)), [Some(4), None]);
        assert_eq!(Seen::nothing(&layout).blake3(&path).unwrap(), hex_blake3(b"text"));
        // As long as before, and with the time of its last write set back.
        let modified = fs::metadata(&path).unwrap().modified().unwrap();
        let changed = |of: &Path| Stamp::at(of).unwrap().changed;
        let before = changed(&path);
        let file = File::options().write(true).open(&path).unwrap();
        while changed(&path) == before {
            file.write_all_at(b"TEXT", 0).unwrap();
            file.set_modified(modified).unwrap();
        }
        assert_eq!(seen.blake3(&path).unwrap(), hex_blake3(b"TEXT"));
        fs::remove_file(&path).unwrap();
        assert!(seen.blake3(&path).is_err());
    }

    #[test]
    fn another_file_with_the_same_name_and_a_link_are_not_the_one_that_was_seen() {
        let (_folder, layout, path) = known("text");
        let seen = knowing(&layout, &path, &hex_blake3(b"told"));
        let other = layout.derived().join("b");
        fs::write(&other, "text").unwrap();
        fs::rename(&other, &path).unwrap();
        assert_eq!(seen.blake3(&path).unwrap(), hex_blake3(b"text"));
        let seen = knowing(&layout, &path, &hex_blake3(b"told"));
        fs::rename(&path, &other).unwrap();
        std::os::unix::fs::symlink(&other, &path).unwrap();
        assert_eq!(seen.unchanged_hash(&path), None);
    }

    #[test]
    fn what_changed_a_moment_ago_is_not_taken_as_known() {
        let (_folder, layout, path) = known("text");
        let seen = Seen::nothing(&layout);
        seen.blake3(&path).unwrap();
        let hash = seen.unchanged_hash(&path);
        assert_eq!(hash, None, "it may change again within the same step of its time");
        let stamp = Stamp::at(&path).unwrap();
        let written = SystemTime::UNIX_EPOCH + Duration::from_secs(stamp.changed.0 as u64);
        assert!(!stamp.is_settled(written) && !stamp.is_settled(SystemTime::UNIX_EPOCH));
        assert!(stamp.is_settled(written + 2 * SETTLED));
    }

    #[test]
    fn many_files_are_written_down_and_read_back_and_few_are_not() {
        let (_folder, layout, path) = known("text");
        let seen = knowing(&layout, &path, &hex_blake3(b"told"));
        assert!(!seen.is_worth_writing());
        let long_ago = Stamp { changed: (1, 0), ..Stamp::at(&path).unwrap() };
        let hash = |i: usize| Blake3(blake3::hash(&i.to_le_bytes()));
        let note = |i: usize| {
            seen.note(&layout.derived().join(i.to_string()), (long_ago, hash(i), Signals(5)))
        };
        (0..WORTH_WRITING).for_each(note);
        assert!(seen.is_worth_writing());
        let mut text = Vec::new();
        seen.write(&mut text).unwrap();
        fs::write(Seen::file(&layout), &text).unwrap();
        let back = Seen::of(&layout);
        assert_eq!(back.before.len(), WORTH_WRITING, "what was just written is left out");
        assert_eq!(back.before["derived/s/7"], (long_ago, hash(7), Signals(5)));
        assert!(!back.is_worth_writing(), "nothing is new");
        let other = String::from_utf8(text).unwrap().replace("t_s", "t_min");
        for damaged in ["", "[]", "{\"derived/s/7\": 1}", "\u{0}", &other] {
            fs::write(Seen::file(&layout), damaged).unwrap();
            assert!(Seen::of(&layout).before.is_empty());
        }
    }
}
