//! Folders: copied, listed, compared.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use zwidth_store::file_blake3;

/// The workspace's folder.
pub(crate) fn workspace() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap()
}

/// Copies a folder and everything in it.
pub(crate) fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        let target = to.join(path.file_name().unwrap());
        if path.is_dir() {
            copy(&path, &target);
        } else {
            fs::copy(&path, &target).unwrap();
        }
    }
}

/// Everything below a folder, hidden files too, but for a study's lock, which is nobody's data:
/// relative path → hash of the content, a folder's is empty.
pub(crate) fn listing(folder: &Path) -> BTreeMap<String, String> {
    let shown = |p: &PathBuf| p.strip_prefix(folder).unwrap().to_str().unwrap().to_owned();
    let hash = |p: &PathBuf| if p.is_dir() { String::new() } else { file_blake3(p).unwrap() };
    let is_lock = |p: &&PathBuf| p.file_name().is_some_and(|name| name == ".lock");
    below(folder).iter().filter(|p| !is_lock(p)).map(|p| (shown(p), hash(p))).collect()
}

/// The files below a folder with this extension, sorted.
pub(crate) fn files(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let mut found = below(folder);
    found.retain(|p| p.is_file() && p.extension().is_some_and(|e| e == extension));
    found.sort();
    found
}

fn below(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).into_iter().flatten() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path.clone());
            }
            found.push(path);
        }
    }
    found
}

/// A text file with one text, which must be there, in the place of another.
pub(crate) fn edit(path: &Path, from: &str, to: &str) {
    let text = fs::read_to_string(path).unwrap();
    assert!(text.contains(from), "'{from}' is not in {text}");
    fs::write(path, text.replacen(from, to, 1)).unwrap();
}

/// Puts a text behind what a file holds.
pub(crate) fn append(path: &Path, more: &str) {
    let text = fs::read_to_string(path).unwrap();
    fs::write(path, text + more).unwrap();
}

/// Changes one bit of a file.
pub(crate) fn flip_bit(path: &Path, byte: usize) {
    let mut bytes = fs::read(path).unwrap();
    bytes[byte] ^= 1 << (byte % 8);
    fs::write(path, bytes).unwrap();
}

/// Keeps only the first `length` bytes of a file.
pub(crate) fn truncate(path: &Path, length: usize) {
    let bytes = fs::read(path).unwrap();
    fs::write(path, &bytes[..length]).unwrap();
}
