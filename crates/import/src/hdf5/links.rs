//! The links of an HDF5 file that name a path: soft ones lead to a path in the file, external ones to
//! another file.
//!
//! The library (hdf5-pure 0.47) takes a soft link in a group of the old form for an object at
//! address 2⁶⁴ − 1, and refuses the group with its contents. So such links are removed from their
//! groups, in memory, before the library reads them. This module follows them when a column is
//! requested by their name.
//!
//! Source: HDF5 File Format Specification 3.0, III.A–D (groups).

use super::super::limits::MOST_NAME;
use super::raw::Raw;
use std::collections::{BTreeMap, BTreeSet};

/// Groups within groups, at most.
pub(super) const MOST_DEPTH: usize = 16;
/// Links that lead to each other, at most.
const MOST_HOPS: usize = 16;
/// Types of messages of an object's header.
const LINK: u16 = 0x06;
const SYMBOL_TABLE: u16 = 0x11;
/// The kind of an entry of a symbol table that is a soft link.
const IS_SOFT: usize = 2;

/// Where a link leads.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Target {
    /// To a path in the file.
    Path(String),
    /// To another file.
    File(String),
}

/// The links of a file, by their paths.
#[derive(Debug, Default)]
pub(super) struct Links(BTreeMap<String, Target>);

impl Links {
    /// Finds the links of a file, and takes those out that the library cannot pass by. Of a file that is
    /// damaged they are found as far as it can be read: what is wrong with it is for the library to say.
    pub(super) fn take_out(bytes: &mut [u8]) -> Self {
        let mut walk = Walk::default();
        if let Some((raw, root)) = Raw::open(bytes) {
            walk.groups(&raw, root);
        }
        for SymbolTable { entries, size, stay } in &walk.tables {
            for (to, from) in stay.iter().enumerate() {
                let from = entries + from * size;
                bytes.copy_within(from..from + size, entries + to * size);
            }
            // No more than there were, which two bytes held.
            let count = u16::try_from(stay.len()).unwrap_or(u16::MAX).to_le_bytes();
            bytes[entries - 2..*entries].copy_from_slice(&count);
        }
        Self(walk.links)
    }

    /// The path of the object that `name` leads to, if there is a link on the way.
    ///
    /// # Errors
    /// Why the link leads nowhere in this file, in words.
    pub(super) fn follow(&self, name: &str) -> Result<Option<String>, String> {
        let mut rest: Vec<String> = parts(name).rev().collect();
        let mut path = String::new();
        let mut hops = 0;
        while let Some(part) = rest.pop() {
            let here = join(&path, &part);
            match self.0.get(&here) {
                None => path = here,
                Some(Target::File(file)) => {
                    return Err(format!("'{here}' is a link to another file, {file}"));
                }
                Some(Target::Path(_)) if hops == MOST_HOPS => {
                    return Err(format!("'{here}' is a link that leads in a circle"));
                }
                Some(Target::Path(target)) => {
                    hops += 1;
                    // A path that begins with a stroke is counted from the file's root.
                    if target.starts_with('/') {
                        path.clear();
                    }
                    rest.extend(parts(target).rev());
                }
            }
        }
        Ok((hops > 0).then_some(path))
    }
}

/// The names in a path.
fn parts(path: &str) -> impl DoubleEndedIterator<Item = String> {
    path.split('/').filter(|part| !part.is_empty() && *part != ".").map(str::to_owned)
}

fn join(path: &str, name: &str) -> String {
    if path.is_empty() { name.to_owned() } else { format!("{path}/{name}") }
}

/// A symbol table, of whose entries some are soft links.
struct SymbolTable {
    /// Where its first entry stands; the number of entries stands in the two bytes before.
    entries: usize,
    /// Bytes of an entry.
    size: usize,
    /// The entries that stay, of how many.
    stay: Vec<usize>,
}

/// A group on the way through a file.
struct Group {
    header: usize,
    path: String,
    depth: usize,
}

/// A walk through a file, which looks at each byte once, whatever leads to it.
#[derive(Default)]
struct Walk {
    links: BTreeMap<String, Target>,
    tables: Vec<SymbolTable>,
    seen: BTreeSet<usize>,
    groups: Vec<Group>,
}

impl Walk {
    fn groups(&mut self, raw: &Raw, root: usize) {
        self.groups.push(Group { header: root, path: String::new(), depth: 0 });
        while let Some(group) = self.groups.pop() {
            if group.depth > MOST_DEPTH {
                continue;
            }
            for message in raw.messages(group.header, &mut self.seen) {
                // What cannot be read has no links that are known.
                match message.kind {
                    LINK => _ = self.link(raw, &group, message.from),
                    SYMBOL_TABLE => _ = self.symbol_table(raw, &group, message.from),
                    _ => {}
                }
            }
        }
    }

    /// A link of a group of the new form.
    fn link(&mut self, raw: &Raw, group: &Group, at: usize) -> Option<()> {
        let flags = raw.number(at + 1, 1)?;
        let mut next = at + 2;
        let mut kind = 0;
        if flags & 0x08 != 0 {
            kind = raw.number(next, 1)?;
            next += 1;
        }
        // The order of its creation, and the character set of its name.
        next += if flags & 0x04 != 0 { 8 } else { 0 };
        next += usize::from(flags & 0x10 != 0);
        let size = 1 << (flags & 3);
        let length = raw.number(next, size).filter(|n| *n <= MOST_NAME)?;
        let name = raw.bytes.get(next + size..next + size + length)?;
        let path = join(&group.path, &String::from_utf8_lossy(name));
        let value = next + size + length;
        match kind {
            0 => {
                let header = raw.address(value)?;
                self.groups.push(Group { header, path, depth: group.depth + 1 });
            }
            1 => {
                let length = raw.number(value, 2)?;
                let target = raw.bytes.get(value + 2..value + 2 + length)?;
                let target = String::from_utf8_lossy(target).into_owned();
                self.links.insert(path, Target::Path(target));
            }
            // Behind its length and a byte of flags: the file's name, then the path in it.
            64 => _ = self.links.insert(path, Target::File(raw.text(value + 3)?)),
            _ => {}
        }
        Some(())
    }

    /// The tables of a group of the old form: a tree of them, whose names stand in a heap.
    fn symbol_table(&mut self, raw: &Raw, group: &Group, at: usize) -> Option<()> {
        let heap = raw.address(at + raw.address_size)?;
        let names = raw.address(heap + 8 + 2 * raw.length_size)?;
        let mut nodes = vec![raw.address(at)?];
        while let Some(node) = nodes.pop() {
            if !self.seen.insert(node) {
                continue;
            }
            if raw.has(node, b"SNOD") {
                self.entries(raw, group, names, node)?;
            } else if raw.has(node, b"TREE") {
                let children = raw.number(node + 6, 2)?;
                // Behind the head and both neighbours keys and children take turns, a key first.
                let first = node + 8 + 2 * raw.address_size + raw.length_size;
                let step = raw.address_size + raw.length_size;
                for child in 0..children {
                    nodes.push(raw.address(first + child * step)?);
                }
            }
        }
        Some(())
    }

    fn entries(&mut self, raw: &Raw, group: &Group, names: usize, node: usize) -> Option<()> {
        let count = raw.number(node + 6, 2)?;
        let mut table =
            SymbolTable { entries: node + 8, size: 2 * raw.address_size + 24, stay: Vec::new() };
        for i in 0..count {
            let at = table.entries + i * table.size;
            // All of it is there.
            raw.number(at + table.size - 8, 8)?;
            let name = raw.text(names.checked_add(raw.number(at, raw.address_size)?)?);
            let kind = at + 2 * raw.address_size;
            if raw.number(kind, 4)? != IS_SOFT {
                table.stay.push(i);
                if let Some((name, header)) = name.zip(raw.address(at + raw.address_size)) {
                    let path = join(&group.path, &name);
                    self.groups.push(Group { header, path, depth: group.depth + 1 });
                }
                continue;
            }
            let target = names.checked_add(raw.number(kind + 8, 4)?).and_then(|at| raw.text(at));
            if let Some((name, target)) = name.zip(target) {
                self.links.insert(join(&group.path, &name), Target::Path(target));
            }
        }
        if table.stay.len() < count {
            self.tables.push(table);
        }
        Some(())
    }
}
