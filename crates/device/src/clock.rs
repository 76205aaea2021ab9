//! Time as the control loop sees it.

/// A monotonic clock with a deadline timer. Seconds since some fixed moment.
pub trait Clock {
    /// Now, s.
    fn now_s(&mut self) -> f64;

    /// Waits for a deadline, s, and returns when it really woke: not before the deadline, and later by the jitter.
    /// A deadline that is past returns at once.
    fn wait_until(&mut self, deadline_s: f64) -> f64;
}
