//! A wire: bytes out, bytes in, never longer than a deadline.

use std::io;
use std::time::Duration;

/// Two ends with bytes between them.
pub trait Wire: Send {
    /// Takes bytes that have come, how many; waits for the first one so long at most. 0: none came.
    ///
    /// # Errors
    /// A wire that is gone.
    fn receive(&mut self, into: &mut [u8], wait: Duration) -> io::Result<usize>;

    /// Sends bytes, all of them.
    ///
    /// # Errors
    /// A wire that is gone, or that takes nothing any more.
    fn send(&mut self, bytes: &[u8]) -> io::Result<()>;
}
