//! A disk that fails on purpose, and one that loses power, for tests.
//!
//! The folder on the real disk is what processes see (the page cache). Beside it the model keeps what is durable: a
//! file's content from its last sync, a name from the last sync of its folder.

use crate::{Append, Files, RealFiles};
use std::collections::BTreeMap;
use std::fs;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard};

/// What outlives the end of a process.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Survives {
    /// A kill: everything that was written, synced or not.
    Everything,
    /// A power cut: only what was synced.
    Synced,
    /// A power cut that spares names, and loses content that was not synced.
    Names,
    /// A power cut that spares names and lengths, and leaves zeros where content was not synced.
    Zeros,
}

/// Which removals work.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Removals {
    /// All: a full disk.
    Free,
    /// Those before the fault: a process that ends there.
    Counted,
    /// None.
    Never,
}

/// Fails at the n-th step, after doing half of it where it is a write, and from then on.
#[derive(Clone)]
pub(crate) struct Faulty {
    state: Arc<Mutex<State>>,
    removals: Removals,
}

struct State {
    /// Steps that still work; none counts down where nothing fails.
    left: Option<u32>,
    live: BTreeMap<PathBuf, Node>,
    durable: BTreeMap<PathBuf, Node>,
    /// Durable content of the files, by number.
    contents: Vec<Vec<u8>>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Node {
    Folder,
    File(usize),
}

impl Faulty {
    /// A disk that is full from step n on: what is there can still be removed.
    pub(crate) fn at(n: u32) -> Self {
        Self::new(Some(n), Removals::Free)
    }

    /// Nothing can be removed from it either.
    pub(crate) fn stuck_at(n: u32) -> Self {
        Self::new(Some(n), Removals::Never)
    }

    /// A process that is killed at step n, or never. What is below `root` now is durable.
    pub(crate) fn killed_at(n: Option<u32>, root: &Path) -> Self {
        let disk = Self::new(n, Removals::Counted);
        disk.state().load(root);
        disk
    }

    fn new(left: Option<u32>, removals: Removals) -> Self {
        let (live, durable) = (BTreeMap::new(), BTreeMap::new());
        let state = State { left, live, durable, contents: Vec::new() };
        Self { state: Arc::new(Mutex::new(state)), removals }
    }

    /// The process has ended, perhaps with the power: the next one finds what survives, and is killed at step n.
    pub(crate) fn restart(&self, root: &Path, survives: Survives, n: Option<u32>) {
        let mut state = self.state();
        state.left = n;
        if survives != Survives::Everything {
            state.lose(root, survives);
            state.load(root);
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap()
    }
}

impl State {
    fn step(&mut self) -> io::Result<()> {
        match &mut self.left {
            None => Ok(()),
            Some(0) => Err(io::Error::from(io::ErrorKind::StorageFull)),
            Some(n) => {
                *n -= 1;
                Ok(())
            }
        }
    }

    /// Takes what is below `root` for durable.
    fn load(&mut self, root: &Path) {
        self.live.clear();
        self.contents.clear();
        let mut folders = vec![root.to_owned()];
        while let Some(folder) = folders.pop() {
            for path in fs::read_dir(&folder).unwrap().map(|e| e.unwrap().path()) {
                let node = if path.is_dir() {
                    folders.push(path.clone());
                    Node::Folder
                } else {
                    self.contents.push(fs::read(&path).unwrap());
                    Node::File(self.contents.len() - 1)
                };
                self.live.insert(path, node);
            }
        }
        self.durable = self.live.clone();
    }

    /// Writes below `root` what is left after a power cut.
    fn lose(&self, root: &Path, survives: Survives) {
        let names = if survives == Survives::Synced { &self.durable } else { &self.live };
        let lengths: BTreeMap<&PathBuf, usize> =
            self.live.keys().filter(|p| p.is_file()).map(|p| (p, fs::read(p).unwrap().len())).collect();
        fs::remove_dir_all(root).unwrap();
        fs::create_dir(root).unwrap();
        for (path, node) in names.iter().filter(|(path, _)| path.parent().unwrap().exists()) {
            match node {
                Node::Folder => fs::create_dir(path).unwrap(),
                Node::File(number) => {
                    let mut content = self.contents[*number].clone();
                    if survives == Survives::Zeros {
                        content.resize(content.len().max(lengths[path]), 0);
                    }
                    fs::write(path, content).unwrap();
                }
            }
        }
    }

    /// The number of a file, which gets one if it is new.
    fn number(&mut self, path: &Path) -> usize {
        match self.live.get(path) {
            Some(Node::File(number)) => *number,
            _ => {
                self.contents.push(Vec::new());
                self.live.insert(path.to_owned(), Node::File(self.contents.len() - 1));
                self.contents.len() - 1
            }
        }
    }

    fn sync(&mut self, path: &Path) {
        let number = self.number(path);
        self.contents[number] = fs::read(path).unwrap();
    }

    /// Writes and syncs: two steps, of which the first may do half of its work.
    fn write(
        &mut self,
        path: &Path,
        bytes: &[u8],
        mut write: impl FnMut(&[u8]) -> io::Result<()>,
    ) -> io::Result<()> {
        self.number(path);
        if let Err(e) = self.step() {
            write(&bytes[..bytes.len() / 2])?;
            return Err(e);
        }
        write(bytes)?;
        self.step()?;
        self.sync(path);
        Ok(())
    }
}

impl Files for Faulty {
    fn create_folder(&self, path: &Path) -> io::Result<()> {
        self.state().step()?;
        self.state().live.entry(path.to_owned()).or_insert(Node::Folder);
        RealFiles.create_folder(path)
    }

    fn write_synced(&self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        self.state().live.remove(path); // a new file, whatever stood there
        self.state().write(path, bytes, |bytes| fs::write(path, bytes))
    }

    fn rename(&self, from: &Path, to: &Path) -> io::Result<()> {
        let mut state = self.state();
        state.step()?;
        let node = state.live.remove(from).unwrap();
        state.live.insert(to.to_owned(), node);
        RealFiles.rename(from, to)
    }

    fn sync_folder(&self, path: &Path) -> io::Result<()> {
        let mut state = self.state();
        state.step()?;
        state.durable.retain(|p, _| p.parent() != Some(path));
        let inside: Vec<_> = state
            .live
            .iter()
            .filter(|(p, _)| p.parent() == Some(path))
            .map(|(p, n)| (p.clone(), *n))
            .collect();
        state.durable.extend(inside);
        Ok(())
    }

    fn open_append(&self, path: &Path) -> io::Result<Box<dyn Append>> {
        let mut state = self.state();
        state.step()?;
        fs::File::options().append(true).create(true).open(path)?;
        state.number(path);
        Ok(Box::new(Handle { disk: self.clone(), path: path.to_owned() }))
    }

    fn remove(&self, path: &Path) -> io::Result<()> {
        match self.removals {
            Removals::Free => {}
            Removals::Counted => self.state().step()?,
            Removals::Never => return Err(io::Error::from(io::ErrorKind::ReadOnlyFilesystem)),
        }
        self.state().live.remove(path);
        RealFiles.remove(path)
    }

    fn remove_folder(&self, path: &Path) -> io::Result<()> {
        RealFiles.remove_folder(path)
    }
}

struct Handle {
    disk: Faulty,
    path: PathBuf,
}

impl Append for Handle {
    fn append_synced(&mut self, bytes: &[u8]) -> io::Result<()> {
        let write = |bytes: &[u8]| fs::File::options().append(true).open(&self.path)?.write_all(bytes);
        self.disk.state().write(&self.path, bytes, write)
    }
}
