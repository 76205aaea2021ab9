//! A wire: it sends and receives bytes, and never takes longer than a deadline.

use std::io;
use std::sync::LazyLock;
use std::time::{Duration, Instant};

/// What the machine's time is counted from.
static BEGAN: LazyLock<Instant> = LazyLock::new(Instant::now);

/// Two ends with bytes between them.
pub trait Wire: Send {
    /// Takes bytes that have come, how many; waits for the first one so long at most. 0: none came.
    /// Fewer than there is room for: nothing more is there now.
    ///
    /// # Errors
    /// A wire that is gone.
    fn receive(&mut self, into: &mut [u8], wait: Duration) -> io::Result<usize>;

    /// Sends bytes, all of them; there may be none.
    ///
    /// # Errors
    /// A wire that is gone, or that takes nothing any more.
    fn send(&mut self, bytes: &[u8]) -> io::Result<()>;

    /// The time by which its waits go, since some moment: the machine's, unless the wire is
    /// simulated.
    fn now(&self) -> Duration {
        BEGAN.elapsed()
    }

    /// Connects anew what was gone.
    ///
    /// # Errors
    /// What still is gone.
    fn reopen(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// A wire that a caller keeps.
impl<W: Wire + ?Sized> Wire for Box<W> {
    fn receive(&mut self, into: &mut [u8], wait: Duration) -> io::Result<usize> {
        (**self).receive(into, wait)
    }

    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        (**self).send(bytes)
    }

    fn now(&self) -> Duration {
        (**self).now()
    }

    fn reopen(&mut self) -> io::Result<()> {
        (**self).reopen()
    }
}
