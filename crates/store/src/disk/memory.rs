//! A disk in memory that fails on request: for simulations of whole sessions, and for hostile
//! files, thousands of which are read per second.
//!
//! Beside what a process sees (the page cache) it keeps what is durable: a file's content from its
//! last sync, and a name from the last sync of its folder. [`Memory::restart`] leaves what survives
//! a kill or a power cut.

use crate::disk::SECTOR;
use crate::disk::sectors::{Draws, torn};
use crate::{Append, Entry, Files, Held, Stamp};
use std::cell::Cell;
use std::collections::BTreeMap;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// What happens at a step: a write, a sync, a rename, an append or a removal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// The process ends there, a write half done: nothing works until [`Memory::restart`].
    End,
    /// The disk is full from there on: a write is half done and fails, what is there can be read
    /// and removed.
    Full,
    /// The disk can be read only from there on: nothing is written or removed.
    ReadOnly,
}

/// What outlives the end of a process.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Survives {
    /// A kill: everything that was written, synced or not.
    Everything,
    /// A power cut: only what was synced.
    Synced,
    /// A power cut that spares names, and loses content that was not synced.
    Names,
    /// A power cut that spares names and lengths, and leaves zeros where content was not synced.
    Zeros,
    /// A power cut that spares names, and half of what was not synced.
    Half,
    /// A power cut that leaves of each write that was not synced any of its sectors, as drawn from
    /// this seed; names are spared, or only those that were synced.
    Torn(u64),
}

/// A disk in memory. Clones are the same disk.
#[derive(Debug, Clone, Default)]
pub struct Memory(Arc<Mutex<State>>);

#[derive(Debug, Default)]
struct State {
    /// Steps taken since the start.
    steps: u64,
    reads: usize,
    /// The step at which something fails, and how.
    fault: Option<(u64, Fault)>,
    /// Whether that step was tried, or anything after it.
    has_failed: Cell<bool>,
    live: BTreeMap<PathBuf, Node>,
    durable: BTreeMap<PathBuf, Node>,
    contents: Vec<Content>,
    /// Changes of anything since the start, and the last one of the names in each folder.
    changes: i64,
    renamed: BTreeMap<PathBuf, i64>,
    /// Processes that ended.
    lives: i64,
    /// The write of which a sector goes astray, counted down, and the seed of where it goes.
    misdirected: Option<(u64, u64)>,
    /// What lies on the disk for sectors of which the process still sees what it wrote.
    hidden: Vec<Hidden>,
}

/// A sector that holds something else than was written to it.
#[derive(Debug)]
struct Hidden {
    file: usize,
    /// Its number in the file.
    sector: usize,
    bytes: Vec<u8>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Node {
    Folder,
    File(usize),
}

impl Node {
    fn entry(&self) -> Entry {
        match self {
            Self::Folder => Entry::Folder,
            Self::File(_) => Entry::File,
        }
    }
}

#[derive(Debug, Clone, Default)]
struct Content {
    live: Vec<u8>,
    durable: Vec<u8>,
    /// The change that was its last.
    changed: i64,
    /// What was written, where a sector that went astray left something else.
    meant: Option<Vec<u8>>,
}

impl Content {
    fn extend(&mut self, bytes: &[u8]) {
        self.live.extend_from_slice(bytes);
        if let Some(meant) = &mut self.meant {
            meant.extend_from_slice(bytes);
        }
    }
}

impl Memory {
    /// An empty disk.
    pub fn new() -> Self {
        Self::default()
    }

    /// Lays a file down, with its folders, all of it durable; no step is counted.
    pub fn put(&self, path: &Path, bytes: &[u8]) {
        let mut state = self.state();
        for folder in path.ancestors().skip(1) {
            state.live.insert(folder.to_owned(), Node::Folder);
            state.durable.insert(folder.to_owned(), Node::Folder);
        }
        let live = bytes.to_vec();
        let durable = bytes.to_vec();
        state.contents.push(Content { live, durable, ..Content::default() });
        let file = Node::File(state.contents.len() - 1);
        state.live.insert(path.to_owned(), file);
        state.durable.insert(path.to_owned(), file);
        state.rename_in(path);
    }

    /// Every file below a folder, with its content.
    pub fn below(&self, folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
        let state = self.state();
        let files = state.files().filter(|(path, _)| path.starts_with(folder));
        files.map(|(path, content)| (path.clone(), content.live.clone())).collect()
    }

    /// Steps taken so far.
    pub fn steps(&self) -> u64 {
        self.state().steps
    }

    /// How often a file was read.
    pub fn reads(&self) -> usize {
        self.state().reads
    }

    /// Has something fail `steps` steps from now.
    pub fn fail_in(&self, steps: u64, fault: Fault) {
        let mut state = self.state();
        state.fault = Some((state.steps.saturating_add(steps), fault));
        state.has_failed.set(false);
    }

    /// Whether a step at which something was to fail was tried.
    pub fn has_failed(&self) -> bool {
        self.state().has_failed.get()
    }

    /// Has one sector go astray of the write that is `writes` writes from now: it lands at a place
    /// drawn from the seed, of the same file or another, and its own place stays as it was. The
    /// process sees that at once, or reads on what it wrote until [`Memory::restart`].
    pub fn misdirect_in(&self, writes: u64, seed: u64) {
        self.state().misdirected = Some((writes, seed));
    }

    /// The files that hold something else than was written to them.
    pub fn damaged(&self) -> Vec<PathBuf> {
        let state = self.state();
        let is_damaged =
            |content: &Content| content.meant.as_ref().is_some_and(|meant| *meant != content.live);
        let files = state.files().filter(|(_, content)| is_damaged(content));
        files.map(|(path, _)| path.clone()).collect()
    }

    /// What was written to a file, whatever it now holds.
    pub fn meant(&self, path: &Path) -> Option<Vec<u8>> {
        let state = self.state();
        let content = &state.contents[state.file(path).ok()?];
        Some(content.meant.as_ref().unwrap_or(&content.live).clone())
    }

    /// A new process finds what survives, on a disk that works and has room.
    pub fn restart(&self, survives: Survives) {
        let mut state = self.state();
        state.fault = None;
        state.lives += 1;
        state.misdirected = None;
        // What the process saw of its own writes is gone with it.
        let hidden = std::mem::take(&mut state.hidden);
        hidden.into_iter().for_each(|hidden| state.damage(hidden));
        if survives != Survives::Everything {
            state.lose(survives);
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    /// Whether a step may be taken; it counts.
    fn step(&mut self, removes: bool) -> io::Result<()> {
        let failed = self.fault.filter(|(at, _)| self.steps >= *at).map(|(_, fault)| fault);
        self.has_failed.set(self.has_failed.get() || failed.is_some());
        match failed {
            Some(Fault::End) => Err(ended()),
            Some(Fault::Full) if !removes => Err(io::Error::from(ErrorKind::StorageFull)),
            Some(Fault::ReadOnly) => Err(io::Error::from(ErrorKind::ReadOnlyFilesystem)),
            _ => {
                self.steps += 1;
                Ok(())
            }
        }
    }

    /// Every file, with its content.
    fn files(&self) -> impl Iterator<Item = (&PathBuf, &Content)> {
        self.live.iter().filter_map(|(path, node)| match node {
            Node::File(number) => Some((path, &self.contents[*number])),
            Node::Folder => None,
        })
    }

    /// Whether anything can be looked at: not by a process that has ended.
    fn look(&self) -> io::Result<()> {
        match self.fault {
            Some((at, Fault::End)) if self.steps >= at => {
                self.has_failed.set(true);
                Err(ended())
            }
            _ => Ok(()),
        }
    }

    fn file(&self, path: &Path) -> io::Result<usize> {
        self.look()?;
        match self.live.get(path) {
            Some(Node::File(number)) => Ok(*number),
            Some(Node::Folder) => Err(io::Error::from(ErrorKind::IsADirectory)),
            None => Err(io::Error::from(ErrorKind::NotFound)),
        }
    }

    /// The file at a path, made if there is none.
    fn create(&mut self, path: &Path) -> io::Result<usize> {
        match self.file(path) {
            Err(e) if e.kind() == ErrorKind::NotFound => {
                self.parent(path)?;
                self.contents.push(Content::default());
                self.live.insert(path.to_owned(), Node::File(self.contents.len() - 1));
                self.rename_in(path);
                Ok(self.contents.len() - 1)
            }
            existing => existing,
        }
    }

    fn parent(&self, path: &Path) -> io::Result<()> {
        let folder = path.parent().map(|folder| self.live.get(folder));
        if folder == Some(Some(&Node::Folder)) {
            Ok(())
        } else {
            Err(io::Error::from(ErrorKind::NotFound))
        }
    }

    /// Gives a folder another name, with what lies in it: the names below it are as safe as they were.
    fn move_folder(&mut self, from: &Path, to: &Path) {
        let moved = |nodes: &BTreeMap<PathBuf, Node>, is_self: bool| -> Vec<(PathBuf, Node)> {
            let inside = nodes.iter().filter(|(path, _)| path.starts_with(from));
            let inside = inside.filter(|(path, _)| is_self || path.as_path() != from);
            inside.map(|(path, node)| (path.clone(), *node)).collect()
        };
        for (path, node) in moved(&self.live, true) {
            self.live.remove(&path);
            let Ok(below) = path.strip_prefix(from) else { continue };
            self.live.insert(to.join(below).components().collect(), node);
        }
        // Below the old name they stay too: it is what a power cut leaves until the rename is synced.
        for (path, node) in moved(&self.durable, false) {
            let Ok(below) = path.strip_prefix(from) else { continue };
            self.durable.insert(to.join(below), node);
        }
    }

    /// A name in the folder of this path has changed.
    fn rename_in(&mut self, path: &Path) {
        self.changes += 1;
        let folder = path.parent().unwrap_or(path).to_owned();
        self.renamed.insert(folder, self.changes);
    }

    /// Appends to a file and syncs it: two steps, of which the first may do half of its work.
    fn append(&mut self, number: usize, bytes: &[u8]) -> io::Result<()> {
        self.changes += 1;
        self.contents[number].changed = self.changes;
        if let Err(e) = self.step(false) {
            self.contents[number].extend(&bytes[..bytes.len() / 2]);
            return Err(e);
        }
        let begin = self.contents[number].live.len();
        // The sector in which this begins is written once more, as the process sees it.
        self.hidden.retain(|hidden| (hidden.file, hidden.sector) != (number, begin / SECTOR));
        self.contents[number].extend(bytes);
        self.lead_astray(number, begin);
        self.step(false)?;
        self.contents[number].durable = self.contents[number].live.clone();
        Ok(())
    }

    /// Cuts a file off behind so many bytes, and syncs that.
    fn cut(&mut self, number: usize, length: usize) -> io::Result<()> {
        self.step(true)?;
        self.changes += 1;
        self.hidden
            .retain(|hidden| hidden.file != number || hidden.sector < length.div_ceil(SECTOR));
        let content = &mut self.contents[number];
        content.changed = self.changes;
        content.live.truncate(length);
        if let Some(meant) = &mut content.meant {
            meant.truncate(length);
        }
        content.durable = content.live.clone();
        Ok(())
    }

    /// Leads a sector of what was written to a file from `begin` on astray, if this write is the
    /// one.
    fn lead_astray(&mut self, number: usize, begin: usize) {
        let end = self.contents[number].live.len();
        let Some((writes, seed)) = self.misdirected.filter(|_| begin < end) else { return };
        self.misdirected = writes.checked_sub(1).map(|left| (left, seed));
        if writes > 0 {
            return;
        }
        let mut draws = Draws::from(seed);
        let from = begin / SECTOR + draws.below((end - 1) / SECTOR - begin / SECTOR + 1);
        let at = from * SECTOR;
        let to = (from * SECTOR + SECTOR).min(end);
        let bytes = self.contents[number].live[at..to].to_vec();
        // At its own place there stays what was there, or nothing was yet.
        let mut stays = self.contents[number].live[at..begin.max(at)].to_vec();
        stays.resize(bytes.len(), 0);
        let files: Vec<usize> = self
            .live
            .values()
            .filter_map(|node| match node {
                Node::File(file) if !self.contents[*file].live.is_empty() => Some(*file),
                _ => None,
            })
            .collect();
        let file = files[draws.below(files.len())];
        let sector = draws.below(self.contents[file].live.len().div_ceil(SECTOR));
        let is_hidden = draws.one_in(2);
        let places =
            [Hidden { file: number, sector: from, bytes: stays }, Hidden { file, sector, bytes }];
        for place in places {
            if is_hidden { self.hidden.push(place) } else { self.damage(place) }
        }
    }

    /// A sector holds something else from now on, as far as its file goes.
    fn damage(&mut self, Hidden { file, sector, bytes }: Hidden) {
        let content = &mut self.contents[file];
        content.meant.get_or_insert_with(|| content.live.clone());
        for stored in [&mut content.live, &mut content.durable] {
            let sector = stored.get_mut(sector * SECTOR..).unwrap_or_default();
            let length = bytes.len().min(sector.len());
            sector[..length].copy_from_slice(&bytes[..length]);
        }
    }

    /// What a power cut leaves.
    fn lose(&mut self, survives: Survives) {
        let mut draws = match survives {
            Survives::Torn(seed) => Draws::from(seed),
            _ => Draws::from(0),
        };
        let names = matches!(survives, Survives::Torn(_)) && draws.one_in(2);
        if survives == Survives::Synced || names {
            self.live = self.durable.clone();
        }
        // A name whose folder is gone leads nowhere.
        let live = self.live.clone();
        self.live.retain(|path, _| {
            path.ancestors().skip(1).all(|folder| live.get(folder) == Some(&Node::Folder))
        });
        for content in &mut self.contents {
            let written = content.live.len();
            let synced = content.durable.len().min(written);
            content.live = match survives {
                Survives::Half => content.live[..synced + (written - synced) / 2].to_vec(),
                Survives::Torn(_) => torn(&content.durable, &content.live, &mut draws),
                _ => content.durable.clone(),
            };
            if survives == Survives::Zeros {
                content.live.resize(written.max(content.live.len()), 0);
            }
            content.durable = content.live.clone();
        }
        self.durable = self.live.clone();
    }
}

fn ended() -> io::Error {
    io::Error::new(ErrorKind::BrokenPipe, "the process has ended")
}

impl Files for Memory {
    fn kind(&self, path: &Path) -> Option<Entry> {
        self.state().live.get(path).map(Node::entry)
    }

    fn list(&self, folder: &Path) -> io::Result<Vec<(PathBuf, Entry)>> {
        let state = self.state();
        state.look()?;
        if state.live.get(folder) != Some(&Node::Folder) {
            return Err(io::Error::from(ErrorKind::NotFound));
        }
        let inside =
            state.live.range(folder.to_owned()..).take_while(|(path, _)| path.starts_with(folder));
        let inside = inside.filter(|(path, _)| path.parent() == Some(folder));
        Ok(inside.map(|(path, node)| (path.clone(), node.entry())).collect())
    }

    fn read(&self, path: &Path, most: u64) -> io::Result<Vec<u8>> {
        let mut state = self.state();
        state.reads += 1;
        let bytes = &state.contents[state.file(path)?].live;
        if bytes.len() as u64 > most {
            return Err(io::Error::from(ErrorKind::FileTooLarge));
        }
        Ok(bytes.clone())
    }

    fn stamp(&self, path: &Path) -> Option<Stamp> {
        let state = self.state();
        Some(match *state.live.get(path)? {
            Node::Folder => {
                let renamed = state.renamed.get(path).copied().unwrap_or_default();
                Stamp::counted(u64::MAX, state.lives, renamed, 0)
            }
            Node::File(number) => {
                let content = &state.contents[number];
                let length = content.live.len() as u64;
                Stamp::counted(number as u64, state.lives, content.changed, length)
            }
        })
    }

    fn hold(&self, folder: &Path) -> io::Result<Box<dyn Held>> {
        let state = self.state();
        state.look()?;
        match state.live.get(folder) {
            Some(Node::Folder) => {
                Ok(Box::new(HeldFolder { disk: self.clone(), path: folder.to_owned() }))
            }
            Some(Node::File(_)) => Err(io::Error::from(ErrorKind::NotADirectory)),
            None => Err(io::Error::from(ErrorKind::NotFound)),
        }
    }

    fn make_private(&self, path: &Path) -> io::Result<()> {
        // Whoever has this disk is alone with it.
        let state = self.state();
        state.look()?;
        state.live.get(path).map(drop).ok_or_else(|| io::Error::from(ErrorKind::NotFound))
    }

    fn create_folder(&self, path: &Path) -> io::Result<()> {
        let mut state = self.state();
        state.step(false)?;
        state.live.entry(path.to_owned()).or_insert(Node::Folder);
        state.rename_in(path);
        Ok(())
    }

    fn write_synced(&self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        let mut state = self.state();
        state.look()?;
        state.live.remove(path); // a new file, whatever stood there
        let number = state.create(path)?;
        state.append(number, bytes)
    }

    fn rename(&self, from: &Path, to: &Path) -> io::Result<()> {
        let mut state = self.state();
        state.step(false)?;
        if state.live.get(from) == Some(&Node::Folder) {
            state.move_folder(from, to);
        } else {
            let file = Node::File(state.file(from)?);
            state.live.remove(from);
            state.live.insert(to.to_owned(), file);
        }
        state.rename_in(from);
        state.rename_in(to);
        Ok(())
    }

    fn sync_folder(&self, path: &Path) -> io::Result<()> {
        let mut state = self.state();
        state.step(false)?;
        let State { live, durable, .. } = &mut *state;
        durable.retain(|p, _| p.parent() != Some(path));
        let inside = live.iter().filter(|(p, _)| p.parent() == Some(path));
        durable.extend(inside.map(|(p, node)| (p.clone(), *node)));
        Ok(())
    }

    fn open_append(&self, path: &Path) -> io::Result<Box<dyn Append>> {
        let mut state = self.state();
        state.step(false)?;
        let number = state.create(path)?;
        let length = state.contents[number].live.len();
        Ok(Box::new(Handle { disk: self.clone(), number, length }))
    }

    fn remove(&self, path: &Path) -> io::Result<()> {
        let mut state = self.state();
        state.step(true)?;
        state.file(path)?;
        state.live.remove(path);
        state.rename_in(path);
        Ok(())
    }

    fn remove_folder(&self, path: &Path) -> io::Result<()> {
        let mut state = self.state();
        state.step(true)?;
        let is_empty = state.live.keys().all(|inside| inside.parent() != Some(path));
        match state.live.get(path) {
            Some(Node::Folder) if is_empty => {
                state.live.remove(path);
                state.rename_in(path);
                Ok(())
            }
            Some(_) => Err(io::Error::from(ErrorKind::DirectoryNotEmpty)),
            None => Err(io::Error::from(ErrorKind::NotFound)),
        }
    }
}

/// A folder of this disk. None can be moved, and one that is made anew cannot be told from it.
struct HeldFolder {
    disk: Memory,
    path: PathBuf,
}

impl Held for HeldFolder {
    fn is_there(&self) -> bool {
        self.disk.kind(&self.path) == Some(Entry::Folder)
    }

    fn now(&self) -> Option<PathBuf> {
        None
    }
}

struct Handle {
    disk: Memory,
    number: usize,
    /// How long the file was when it was opened.
    length: usize,
}

impl Append for Handle {
    fn append_synced(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.disk.state().append(self.number, bytes)
    }

    fn take_back(&mut self) -> io::Result<()> {
        self.disk.state().cut(self.number, self.length)
    }
}
