//! The content of a file: in memory if it is small, else on the disk, where only the requested
//! parts are read. So a long recording is never in memory whole.

use bytes::Bytes;
use parquet::errors::ParquetError;
use parquet::file::reader::{ChunkReader, Length};
use std::fs::File;
use std::io::{self, BufReader, Read, Seek as _, SeekFrom};
use std::sync::{Arc, Mutex, PoisonError};

/// Files of up to so many bytes are read whole (16 MiB): most trials are far smaller.
pub(crate) const WHOLE: u64 = 1 << 24;
/// Bytes at the end of a file that are read at once (16 KiB): the footer of most trials.
const END: u64 = 1 << 14;
/// Bytes that are read at a time to hash a file.
const HASHED_AT_ONCE: usize = 1 << 20;

/// The content of a file.
#[derive(Debug, Clone)]
pub struct Content {
    /// What of it is in memory: all, its end, or nothing.
    end: Bytes,
    /// Where the bytes before that are.
    file: Option<Arc<Mutex<File>>>,
    length: u64,
}

impl Content {
    /// Bytes that were already read.
    pub fn of(bytes: Vec<u8>) -> Self {
        Self { length: bytes.len() as u64, end: Bytes::from(bytes), file: None }
    }

    /// An open file of `length` bytes, none of them read yet.
    pub(crate) fn on_disk(file: File, length: u64) -> Self {
        Self { end: Bytes::new(), file: Some(Arc::new(Mutex::new(file))), length }
    }

    /// The same with its end read: it contains the footer of a trial.
    pub(crate) fn with_end(file: File, length: u64) -> io::Result<Self> {
        let content = Self::on_disk(file, length);
        let end = length.min(END);
        let end = content.range(length - end, usize::try_from(end).unwrap_or(0))?;
        Ok(Self { end, ..content })
    }

    /// The number of bytes.
    pub fn length(&self) -> u64 {
        self.length
    }

    /// The bytes from `from` on, `length` of them.
    ///
    /// # Errors
    /// There are fewer, or they cannot be read.
    pub fn range(&self, from: u64, length: usize) -> io::Result<Bytes> {
        let within = from.checked_add(length as u64).is_some_and(|to| to <= self.length);
        if !within {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        let before = self.length - self.end.len() as u64;
        let Some(file) = self.file.as_ref().filter(|_| from < before) else {
            let from = usize::try_from(from - before).map_err(|_| io::ErrorKind::UnexpectedEof)?;
            return Ok(self.end.slice(from..from + length));
        };
        // Its length was looked at: what is claimed beyond it takes no memory.
        let mut bytes = room(length)?;
        bytes.resize(length, 0);
        // A panic elsewhere leaves the file at any place, and it is sought anew here.
        let mut file = file.lock().unwrap_or_else(PoisonError::into_inner);
        file.seek(SeekFrom::Start(from))?;
        file.read_exact(&mut bytes)?;
        Ok(Bytes::from(bytes))
    }

    /// BLAKE3 of all, hexadecimal.
    ///
    /// # Errors
    /// The disk's.
    pub(crate) fn blake3(&self) -> io::Result<String> {
        let mut hasher = blake3::Hasher::new();
        let mut at = 0;
        while at < self.length() {
            let left = usize::try_from(self.length() - at).unwrap_or(usize::MAX);
            let bytes = self.range(at, left.min(HASHED_AT_ONCE))?;
            hasher.update(&bytes);
            at += bytes.len() as u64;
        }
        Ok(hasher.finalize().to_hex().to_string())
    }
}

impl Length for Content {
    fn len(&self) -> u64 {
        self.length()
    }
}

impl ChunkReader for Content {
    type T = BufReader<Part>;

    fn get_read(&self, start: u64) -> Result<Self::T, ParquetError> {
        // Each read of a part is a seek, and headers are decoded byte by byte.
        Ok(BufReader::new(Part { content: self.clone(), at: start }))
    }

    fn get_bytes(&self, start: u64, length: usize) -> Result<Bytes, ParquetError> {
        Ok(self.range(start, length)?)
    }
}

/// The bytes of a file from a place on.
#[derive(Debug)]
pub struct Part {
    content: Content,
    at: u64,
}

impl Read for Part {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let left = self.content.length().saturating_sub(self.at);
        let length = usize::try_from(left).unwrap_or(usize::MAX).min(buffer.len());
        buffer[..length].copy_from_slice(&self.content.range(self.at, length)?);
        self.at += length as u64;
        Ok(length)
    }
}

/// Memory for so many bytes of a file, if the system gives it and has some left for what is made of
/// them: a smaller part that it refuses afterwards would end the program.
///
/// # Errors
/// [`io::ErrorKind::OutOfMemory`].
pub(crate) fn room(length: usize) -> io::Result<Vec<u8>> {
    /// Memory that must remain, bytes (64 MiB).
    const LEFT: usize = 1 << 26;
    let mut bytes = Vec::new();
    let mut spare = Vec::<u8>::new();
    let reserved = bytes.try_reserve_exact(length).and_then(|()| match length < LEFT {
        true => Ok(()),
        false => spare.try_reserve_exact(LEFT),
    });
    reserved.map_err(|_| {
        let what = format!("the system does not give {length} bytes of memory for it");
        io::Error::new(io::ErrorKind::OutOfMemory, what)
    })?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_that_the_system_does_not_give_is_an_error_of_the_system_and_none_of_the_file() {
        let error = room(1 << 62).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::OutOfMemory);
        let error = crate::StoreError::io(std::path::Path::new("a.npy"), "read", &error);
        assert!(error.by_system && error.remedy.contains("larger machine"), "{error}");
        assert!(room(1 << 10).unwrap().capacity() >= 1 << 10);
    }

    #[test]
    fn a_file_on_the_disk_gives_the_same_bytes_and_hash_as_one_in_memory() {
        let bytes: Vec<u8> = (0..3_000_000_u32).map(|i| (i % 251) as u8).collect();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x");
        std::fs::write(&path, &bytes).unwrap();
        let disk = Content::on_disk(File::open(&path).unwrap(), bytes.len() as u64);
        let memory = Content::of(bytes.clone());
        assert_eq!(disk.blake3().unwrap(), memory.blake3().unwrap());
        assert_eq!(disk.blake3().unwrap(), crate::hex_blake3(&bytes));
        for (from, length) in [(0, 10), (2_999_990, 10), (1_234_567, 0)] {
            assert_eq!(disk.range(from, length).unwrap(), memory.range(from, length).unwrap());
        }
        let end = Content::with_end(File::open(&path).unwrap(), bytes.len() as u64).unwrap();
        assert_eq!(end.blake3().unwrap(), memory.blake3().unwrap());
        let last = bytes.len() as u64 - END;
        for (from, length) in [(last, 10), (last - 1, 10), (last + 5, 10), (last, END as usize)] {
            assert_eq!(end.range(from, length).unwrap(), memory.range(from, length).unwrap());
        }
        for content in [&disk, &memory, &end] {
            assert!(content.range(2_999_990, 11).is_err() && content.range(u64::MAX, 2).is_err());
            let mut read = Vec::new();
            content.get_read(2_000_000).unwrap().read_to_end(&mut read).unwrap();
            assert_eq!(read, bytes[2_000_000..]);
        }
    }
}
