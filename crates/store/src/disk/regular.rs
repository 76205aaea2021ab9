//! Opens files that others may have put there: regular files only. A pipe or a device could hang
//! its reader, and a link leads out of the data.

use crate::disk::content::{Content, WHOLE, room};
use crate::{Files, StoreError};
use std::fs::{File, Metadata, OpenOptions};
use std::io::{self, Read as _};
use std::path::Path;

/// The largest file that is read whole into memory, bytes (1 GiB).
pub const MOST_BYTES: u64 = 1 << 30;

/// The largest recording of ours, bytes (4 GiB): it is read part by part.
pub const MOST_RECORDING: u64 = 1 << 32;

/// Opens a regular file for reading. A link is refused, not followed; a pipe or a device does not
/// block.
///
/// # Errors
/// What the system says; [`io::ErrorKind::InvalidInput`] for anything but a regular file, with what
/// it is.
pub fn open_regular(path: &Path) -> io::Result<File> {
    open_as(OpenOptions::new().read(true), path)
}

/// Opens a file that a person named, for reading, as [`open_regular`] does; a link of theirs is
/// followed.
///
/// # Errors
/// Those of [`open_regular`].
pub fn open_named(path: &Path) -> io::Result<File> {
    open_regular(&path.canonicalize()?)
}

/// Reads a regular file whole ([`open_regular`]).
///
/// # Errors
/// Those of [`open_regular`]; [`io::ErrorKind::FileTooLarge`] for more than `most` bytes, of which
/// none is read.
pub fn read_regular(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    read_whole(open_regular(path)?, most)
}

/// Reads a file that a person named whole ([`open_named`]).
///
/// # Errors
/// Those of [`read_regular`].
pub fn read_named(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    read_whole(open_named(path)?, most)
}

/// The content of a regular file ([`open_regular`]); that of a large one is left on the disk.
///
/// # Errors
/// Those of [`read_regular`].
pub(crate) fn open_content(path: &Path, most: u64) -> io::Result<Content> {
    let file = open_regular(path)?;
    let length = file.metadata()?.len();
    if length <= WHOLE.min(most) {
        return read_whole(file, most).map(Content::of);
    }
    if length > most { Err(too_large(length, most)) } else { Ok(Content::on_disk(file, length)) }
}

/// The same, but however small the file is, only its end is read.
pub(crate) fn open_end(path: &Path, most: u64) -> io::Result<Content> {
    let file = open_regular(path)?;
    let length = file.metadata()?.len();
    if length > most { Err(too_large(length, most)) } else { Content::with_end(file, length) }
}

fn too_large(length: u64, most: u64) -> io::Error {
    let what = format!("it has {length} bytes, and at most {most} are read");
    io::Error::new(io::ErrorKind::FileTooLarge, what)
}

/// A regular file's text.
pub(crate) fn text(files: &dyn Files, path: &Path, most: u64) -> Result<String, StoreError> {
    as_text(path, files.read(path, most).map_err(|e| StoreError::io(path, "read", &e))?)
}

/// The bytes of a file as text.
pub(crate) fn as_text(path: &Path, bytes: Vec<u8>) -> Result<String, StoreError> {
    String::from_utf8(bytes).map_err(|e| {
        let what = format!("byte {} is not UTF-8", e.utf8_error().valid_up_to());
        StoreError::new(path, what, "restore the file from a copy, or save it as UTF-8")
    })
}

/// Opens a regular file with `options`, which must not create or truncate it: what stands there is
/// looked at first.
fn open_as(options: &mut OpenOptions, path: &Path) -> io::Result<File> {
    refuse(path, &path.symlink_metadata()?)?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::OpenOptionsExt as _;
        // A link or a pipe may have taken its place since: opening a pipe would wait for a writer.
        options.custom_flags(libc::O_NOFOLLOW | libc::O_NONBLOCK);
    }
    let file = options.open(path)?;
    // What was opened may be another than what was looked at.
    refuse(path, &file.metadata()?)?;
    Ok(file)
}

/// The same, and creates the file if there is none.
pub(crate) fn open_or_create(options: &mut OpenOptions, path: &Path) -> io::Result<File> {
    match options.clone().create_new(true).open(path) {
        Err(e) if e.kind() == io::ErrorKind::AlreadyExists => open_as(options, path),
        created => created,
    }
}

/// Refuses anything but a regular file.
fn refuse(path: &Path, metadata: &Metadata) -> io::Result<()> {
    let kind = metadata.file_type();
    if kind.is_file() {
        return Ok(());
    }
    let what = if kind.is_symlink() {
        "a link; only the file itself is read"
    } else if kind.is_dir() {
        "a folder, not a file"
    } else {
        "a pipe, socket or device, not a file"
    };
    let name = path.file_name().unwrap_or(path.as_os_str());
    Err(io::Error::new(io::ErrorKind::InvalidInput, format!("{} is {what}", name.display())))
}

fn read_whole(file: File, most: u64) -> io::Result<Vec<u8>> {
    let length = file.metadata()?.len();
    if length > most {
        return Err(too_large(length, most));
    }
    let mut bytes = room(usize::try_from(length).unwrap_or(0))?;
    // It may grow while it is read.
    file.take(most.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most {
        return Err(too_large(bytes.len() as u64, most));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn a_file_up_to_the_limit_is_read_and_a_larger_one_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        fs::write(&path, "four").unwrap();
        assert_eq!(read_regular(&path, 4).unwrap(), b"four");
        let error = read_regular(&path, 3).unwrap_err();
        assert!(error.to_string().contains("4 bytes, and at most 3"), "{error}");
    }

    #[test]
    fn a_folder_is_no_file() {
        let folder = tempfile::tempdir().unwrap();
        assert!(read_regular(folder.path(), 9).unwrap_err().to_string().contains("is a folder"));
    }

    #[cfg(unix)]
    #[test]
    fn links_and_devices_are_refused_and_do_not_hang() {
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("a"), folder.path().join("l"));
        fs::write(&file, "x").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        assert!(read_regular(&link, 9).unwrap_err().to_string().contains("l is a link"));
        assert_eq!(read_named(&link, 9).unwrap(), b"x");
        fs::remove_file(&link).unwrap();
        std::os::unix::fs::symlink(&link, &link).unwrap();
        assert!(read_regular(&link, 9).is_err() && read_named(&link, 9).is_err());
        for device in ["/dev/zero", "/dev/null"] {
            let error = read_named(Path::new(device), 9).unwrap_err();
            assert!(error.to_string().contains("device"), "{error}");
        }
    }
}
